"""The page of results in a browser: hover, slider, zoom, sort, a narrow window; no network, no
complaint. The values are those of the arrays."""

import html
import re
import subprocess
import sys

import numpy as np
import pytest
from browser import browser, complaints_of, open_page, point, requests_of, wait_for
from builds import ROOT
from programs import run_program

pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]

BODIES = {"elastic_modulus": (2e5, 2e5), "poisson_ratio": (0.3, 0.3)}
UNITS = {"units": ("um", "uN")}
CASES = ("map", "caps", "slip", "thesis")
SIX = 5e-6  # six digits


def solved(package, case):
    """A map with 10 states after first touch, 200 caps, partial slip, and the thesis' sweep."""
    if case == "thesis":
        return package.solve(ROOT / "data/examples/thesis.scene")
    if case == "caps":
        _, lower = package.generate({
            "surfaces": {"number": 200, "length": 200, "width": 200},
            "heights": {"mean": 2, "deviation": 0.3}, "radii": {"mean": 20.0}})
        return package.solve({
            "surfaces": {"upper": "plane", "lower": lower, "nominal_area": 4e4, **UNITS},
            "material": {"contact_modulus": 1e5},
            "loading": {"control": "pressure", "value": 20, "points": 6}})
    pixels, points = (160, 10) if case == "map" else (64, 4)
    rough = package.generate_map(pixels=pixels, spacing=64 / pixels, unit="um", hurst=0.8,
                                 rms_slope=0.1)
    slip = {} if case == "map" else {"tangential_load": 4e4}
    return package.solve({
        "surfaces": {"upper": "plane", "lower": rough, **UNITS}, "material": BODIES,
        "loading": {"control": "pressure", "value": 100, "points": points, **slip},
        **({} if case == "map" else {"effects": {"friction": "on", "friction_coefficient": 0.3}})},
        fields="all")


@pytest.fixture(scope="module")
def results(package):
    """Each result is solved once."""
    found = {}

    def result(case):
        if case not in found:
            found[case] = solved(package, case)
        return found[case]
    return result


def test_file(package, results, tmp_path):
    """One file without an address to load from; with summary, warnings and scene, escaped."""
    found = results("thesis")
    path = found.to_html(tmp_path / "p.html", title="<b> & co")
    text = (tmp_path / "p.html").read_text(encoding="utf-8")
    assert path == str(tmp_path / "p.html") and "<title>&lt;b&gt; &amp; co</title>" in text
    scripts = re.findall(r"<script[^>]*>", text)
    rest = re.sub(r"(<script[^>]*>).*?</script>", "", text, flags=re.DOTALL)
    assert not any("src" in one for one in scripts) and not re.search(r"(src|href)=", rest)
    [shown] = re.findall(r'<script type="application/json"[^>]*>(.*?)</script>', text, re.DOTALL)
    words = html.unescape(shown)
    assert "interaction is off, 39.8 % is its estimated influence" in words
    assert "The sweep of the thesis: 100 positions" in words and "3F1974FE" in words
    with pytest.raises(IndexError, match="position: found 101"):
        found.to_html(tmp_path / "q.html", position=101)
    with pytest.raises(package.ComputeError, match="No such file or directory"):
        found.to_html(tmp_path / "none" / "q.html")
    assert [each.name for each in tmp_path.iterdir()] == ["p.html"]


def test_page_of_files_of_the_program(package, package_folder, asperity, tmp_path):
    """The command makes the page of a run of the program; its tables and fields are those of the
    same solve in Python."""
    scene = ROOT / "data/examples/summits/press_samples.scene"
    run_program(asperity, "solve", scene, "--quiet", "--json", tmp_path / "r.json",
                "--fields", tmp_path / "f.vti", "--fields-of", "all")
    paths = sorted(tmp_path.glob("f_*.vti"))
    mine, own = package.load(tmp_path / "r.json", fields=paths), package.solve(scene, fields="all")
    assert len(paths) == len(own.states) == 21
    assert mine.states == own.states and mine.contacts == own.contacts
    assert mine.states.units == own.states.units and mine.contacts.units == own.contacts.units
    assert (mine.summary, mine.warnings, mine.scene) == (own.summary, own.warnings, own.scene)
    assert mine.scene["text"] == scene.read_text() and mine.scene["units"]["force"] == "uN"
    for step in (1, 7, 21):
        for name in own.fields(step=step):
            assert np.array_equal(mine.fields(step=step)[name], own.fields(step=step)[name],
                                  equal_nan=True), (step, name)
        assert mine.fields(step=step).units == own.fields(step=step).units
        assert mine.fields(step=step).origin == own.fields(step=step).origin
    for words, status in ((["r.json", "--fields", "f_0021.vti"], 0), (["f_0001.vti"], 2),
                          (["none.json"], 2), (["r.json", "--output", "no/p.html"], 1)):
        done = subprocess.run([sys.executable, "-m", "asperity", "page", *words], cwd=tmp_path,
                              capture_output=True, text=True, env={
                                  "PYTHONPATH": str(package_folder), "PATH": "/usr/bin"})
        assert done.returncode == status, done.stderr
        assert (done.stdout == "r.html\n") == (status == 0) and (done.stderr == "") == (status == 0)
    assert "pressure" in (tmp_path / "r.html").read_text(encoding="utf-8")


def test_states_left_out(results, tmp_path, monkeypatch):
    """Of large fields fewer states are shown, the last among them, and the page states so."""
    page = sys.modules["asperity._page"]
    monkeypatch.setattr(page, "MOST_BYTES", 4 * 2 * 160 * 160 * 4)
    results("map").to_html(tmp_path / "p.html")
    text = (tmp_path / "p.html").read_text(encoding="utf-8")
    assert "4 of 11 states are shown" in text
    assert page.Page(results("map"), None).shown == ["1.1", "1.4", "1.8", "1.11"]


@pytest.mark.long
@pytest.mark.parametrize("case", CASES)
def test_in_a_browser(case, results, tmp_path):
    """All of the page in one browser, which takes seconds to start."""
    found = results(case)
    found.to_html(tmp_path / "p.html")
    states, contacts = found.states, found.contacts
    keys = [f"{position}.{step}" for position, step in zip(states["position"], states["step"])]
    with browser(1200, 1000) as driver:
        open_page(driver, tmp_path / "p.html")
        run = driver.execute_script
        assert run("return models('Slider')[0].end") == len(states) - 1

        # The slider by its keys: maps, table and mark are those of the state.
        place = len(states) // 2
        run("models('Slider')[0].value = arguments[0]", place)
        assert set(run("return models('GroupFilter').map(f => f.group)")) == {keys[place]}
        mine = (contacts["position"] == states["position"][place]) & \
            (contacts["step"] == states["step"][place]) & (contacts["load"] != 0)
        assert run("return models('DataTable')[0].view && [...models('Slider')][0].value") == place
        rows = int(mine.sum())
        assert wait_for(driver, "return all('slick-row').length") >= min(rows, 8)
        assert f"state {states['step'][place]}" in run("return models('Slider')[0].title")

        # The table sorts by a column: after two clicks the largest is in the first row, where it
        # is not without them.
        by = next((each for each in ("load", "x", "y")
                   if contacts[each][mine].argmax() > 0), "load")
        title = contacts.label(by)
        for _ in range(2):
            run("all('slick-header-column').find(e => e.innerText.trim() == arguments[0]).click()",
                title)
        cell = run("""const rows = all('slick-row').sort((a, b) =>
          a.getBoundingClientRect().top - b.getBoundingClientRect().top);
          const names = all('slick-header-column').map(e => e.innerText.trim());
          return rows[0].children[names.indexOf(arguments[0])].innerText""", title)
        assert float(cell.replace(",", "")) == pytest.approx(contacts[by][mine].max(), rel=SIX)

        # Hover at the greatest value of a map, or at the largest contact.
        if case in ("map", "slip"):
            fields = found.fields(step=int(states["step"][place]))
            row, column = np.unravel_index(np.nanargmax(fields.pressure), fields.shape)
            value = fields.pressure[row, column]
            figure, name = f"Pressure ({fields.units['pressure']})", "pressure"
            x, y = (start + step * number for start, step, number in zip(
                fields.origin, fields.spacing, (column, row)))
        else:
            number = np.flatnonzero(mine)[contacts["area"][mine].argmax()]
            x, y, value = (float(contacts[key][number]) for key in ("x", "y", "load"))
            figure, name = "Contacts to scale", contacts.label("load")
        assert hovered(driver, figure, x, y)[name] == pytest.approx(value, rel=SIX)

        # The other map has the same window after a zoom.
        if case == "map":
            run("figureOf(arguments[0]).x_range.start = 10", figure)
            assert run("return figureOf('Gap (um)').x_range.start") == 10

        # A click on a point of a curve shows its state; the mark is there.
        down = "nominal pressure (MPa)" if case != "thesis" else "load (N)"
        across, up = ("position", "load") if case == "thesis" else \
            ("separation", "nominal_pressure")
        x, y = float(states[across][1]), float(states[up][1])
        point(driver, *wait_for(driver, "return placeOf(...arguments)", down, x, y), click=True)
        wait_for(driver, "return models('Slider')[0].value == 1")
        assert set(run("return models('GroupFilter').map(f => f.group)")) == {keys[1]}

        assert requests_of(driver) == [] and complaints_of(driver) == []
    with browser(400, 800) as driver:
        open_page(driver, tmp_path / "p.html")
        assert driver.execute_script("return document.documentElement.scrollWidth") <= 400
        assert requests_of(driver) == [] and complaints_of(driver) == []


def hovered(driver, figure, x, y):
    """Values by name that are shown at a place of a figure."""
    point(driver, *wait_for(driver, "return placeOf(...arguments)", figure, float(x), float(y)))
    words = wait_for(driver, """const found = i => all('bk-tooltip-row-' + i).map(e => e.innerText);
      const [names, values] = [found('label'), found('value')];
      return names.length && values.length == names.length && [names, values]""")
    return {name.rstrip(": "): float(value) for name, value in zip(*words)}
