"""`asperity.accuracy`: the numbers of `asperity accuracy`, and digits of heights."""

import csv

import numpy as np
import pytest
from programs import run_program

pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]

CAPS = 12
CLOCK = {"seconds", "front"}
SECONDS = 1.5


@pytest.fixture(scope="module")
def caps(package):
    _, lower = package.generate({
        "surfaces": {"number": CAPS, "length": 60, "width": 60},
        "heights": {"mean": 2, "deviation": 0.3}, "radii": {"mean": 20.0}})
    return lower


@pytest.mark.parametrize("kind", ("asperities", "deck"))
def test_numbers_of_the_command(kind, package, caps, asperity, root, tmp_path):
    """All numbers of `--csv` but the clock's; of a deck the arithmetics and steps, too. The rows
    that one of both has no time for are few."""
    scene = root / "data/hard/deck_one_pair.deck"
    if kind == "asperities":
        (tmp_path / "l.csv").write_text("x,y,height,radius\n" + "".join(
            ",".join(repr(row[name]) for name in ("x", "y", "height", "radius")) + "\n"
            for row in caps.rows()))
        scene = tmp_path / "s.scene"
        scene.write_text(
            "&surfaces upper = 'plane', lower = 'l.csv' /\n&material contact_modulus = 1e5 /\n"
            "&loading control = 'load', value = 1e5 /\n")
    needed = {"isolated contacts", "real64; exact events"}
    if kind == "deck":
        needed.add("ibm370; original program; 1976")
    for seconds in (SECONDS, 10 * SECONDS, 60):
        run_program(asperity, "accuracy", scene, "--quiet", "--csv", tmp_path / "a.csv",
                    "--seconds", seconds)
        found = package.accuracy(scene, seconds=seconds)
        rows = list(csv.DictReader(open(tmp_path / "a.csv", encoding="ascii")))
        if needed <= compare(found.table, rows):
            break
    else:
        raise AssertionError("no time for the methods of a deck")
    assert found.reference in str(found) and "what to type" in str(found)


def compare(table, rows):
    """The methods that both have solved, all of whose numbers are equal."""
    assert len(rows) == len(table) and list(rows[0]) == list(table)
    solved = set()
    for mine, row in zip(table.rows(), rows):
        if "takes longer" in mine["left_out"] + row["left_out"]:
            continue
        solved.add(row["method"])
        for name in row.keys() - CLOCK:
            text = row[name].replace(";", ",")
            if isinstance(mine[name], str):
                assert mine[name] == text
            else:
                assert mine[name] == pytest.approx(float(text or "nan"), rel=1e-9, nan_ok=True)
    return solved


def test_answers(package, caps):
    """The fastest row within a goal that can be typed, and which then has these totals."""
    scene = {"surfaces": {"upper": "plane", "lower": caps}, "material": {"contact_modulus": 1e5},
             "loading": {"control": "load", "value": 1e5}}
    found = package.accuracy(scene)
    row = found.answer(0.02)
    typed = {name: eval(value) for name, _, value in (
        part.partition(" = ") for part in row["typed"].split(", "))}
    area = package.solve({**scene, "effects": typed}).states["area"][-1]
    assert row["area"] == pytest.approx(area, rel=1e-3) and found.error(row) <= 0.02
    assert found.answer(1e-30) is None
    assert list(found.answers) == [0.1, 0.01, 0.001]
    assert found.answers[0.1]["typed"] == found.answer(0.1)["typed"]
    assert "<img" in found._repr_html_()
    with pytest.raises(ValueError, match="of: found 'gap', expected 'load', 'area', 'separ"):
        found.answer(0.1, "gap")
    with pytest.raises(ValueError, match="seconds: found"):
        package.accuracy(scene, seconds=0.0)


def test_curves(package, caps):
    """One curve a quantity: its points are methods that can be typed, each faster one less
    accurate; a number above each line and a line below it with what to type."""
    found = package.accuracy({
        "surfaces": {"upper": "plane", "lower": caps}, "material": {"contact_modulus": 1e5},
        "loading": {"control": "load", "value": 1e5}})
    axes = found.plot()
    assert [text.get_text() for text in axes.get_legend().get_texts()] == [
        "area", "separation", "greatest pressure"]  # the load is prescribed
    typed = {row["seconds"]: row for row in found.table.rows() if row["typed"]}
    listed = set()
    for name in ("area", "separation", "greatest_pressure"):
        [curve] = [line for line in axes.lines if line.get_label() == name.replace("_", " ")]
        seconds, errors = curve.get_data()
        assert list(seconds) == sorted(seconds) and (np.diff(errors) < 0).all()
        assert list(errors) == [found.error(typed[one], name) for one in seconds]
        assert min(errors) <= 1.2 * min(found.error(row, name) for row in typed.values())
        listed |= set(seconds)
    _, *lines = axes.get_xlabel().splitlines()
    assert [line.split()[0] for line in lines] == [str(1 + k) for k in range(len(listed))]
    for line, one in zip(lines, sorted(listed)):
        assert found.typed(typed[one]) in line
    goals = [line.get_ydata()[0] for line in axes.lines if line.get_linestyle() == ":"]
    assert goals == [0.1, 0.01, 0.001]


def test_greatest_pressure(package):
    """Of a cap alone under a load P: that of Hertz, (6 P E**2/(pi**3 R**2))**(1/3); the errors of
    several caps are the differences of the column."""
    def of(caps, load):
        return package.accuracy({
            "surfaces": {"upper": "plane", "lower": caps}, "material": {"contact_modulus": 1e5},
            "loading": {"control": "load", "value": load}})
    alone = of({"x": [0.0], "y": [0.0], "height": [1.0], "radius": [2.0]}, 50.0)
    hertz = (6 * 50.0 * 1e5**2 / (np.pi**3 * 2.0**2))**(1 / 3)
    exact = [row["greatest_pressure"] for row in alone.table.rows()
             if "boundary" not in row["method"]]
    assert len(exact) > 4 and np.allclose(exact, hertz, rtol=1e-9)
    found = of({"x": [0.0, 0.2, 0.5], "y": [0.0, 0.1, 0.0], "height": [1.0, 1.001, 0.999],
                "radius": [2.0]}, 50.0)
    best = next(row for row in found.table.rows() if row["reference"])
    for row in found.table.rows():
        differs = abs(row["greatest_pressure"] / best["greatest_pressure"] - 1)
        assert row["greatest_pressure_error_max"] == pytest.approx(differs, abs=1e-12)
        # The area's estimate stands for that of the greatest pressure.
        assert found.error(row, "greatest_pressure") == pytest.approx(
            max(differs, best["area_error_estimate"]), rel=1e-9)
    assert max(found.table["greatest_pressure_error_max"]) > 0.01


def test_digits_of_a_deck(package, root, tmp_path):
    """One pair at its limit: heights with four digits in inches move its separation by the sum of
    both halves, 2.54e-4 cm, or not at all."""
    text = (root / "data/hard/deck_one_pair.deck").read_text()
    (tmp_path / "a.deck").write_text(text.replace(".800000", " .8000").replace(".750000", " .7500"))
    found = package.accuracy(tmp_path / "a.deck", seconds=2.0)
    compression = package.solve(tmp_path / "a.deck").positions["compression"]
    assert found.digits == pytest.approx(2.54e-4 / min(compression[compression > 0]), rel=1e-6)


def test_digits_of_heights(package):
    """A cap alone under a prescribed compression d of its scene: half of its last digit changes the
    load by the law of Hertz."""
    cap = {"x": [0.0], "y": [0.0], "height": [1.04], "radius": [10.0]}
    found = package.accuracy({
        "surfaces": {"upper": cap, "lower": "plane"}, "material": {"contact_modulus": 1000.0},
        "loading": {"control": "separation", "value": 1.0}}, seconds=SECONDS)
    expected = [abs((1 + sign * 0.005 / 0.04)**1.5 - 1) for sign in (-1, 1)]
    assert np.isclose(found.digits, expected, rtol=1e-9).any()
    assert "digit of the heights" in str(found)


def test_pixels(package):
    """A map in an array: what to type for its pixels is the option of the command, and in Python
    the accuracy that chooses these pixels."""
    lower = package.generate_map(pixels=64, spacing=1, unit="um", hurst=0.8, cut_off=8,
                                 rms_slope=0.02)
    scene = {"surfaces": {"upper": "plane", "lower": lower, "units": ("um", "uN")},
             "material": {"contact_modulus": 1e5}, "loading": {"control": "pressure", "value": 100}}
    found = package.accuracy(scene, finer=True)
    printed = str(package.accuracy(scene))
    assert "--accuracy" not in printed and "asperity.solve(scene, accuracy=" in printed
    assert {"pixels half as wide", "pixels of the map"} <= set(found.table["method"].tolist())
    assert {"--accuracy 1e-2", "--accuracy 1e-3"} <= set(found.table["typed"].tolist())
    for row in found.table.rows():
        name, _, value = found.typed(row).partition("=")
        if name == "accuracy" and not row["left_out"]:
            made = package.solve(scene, accuracy=float(value))
            assert made.positions["separation"][0] == pytest.approx(row["separation"], rel=1e-12)


@pytest.mark.parametrize("is_map", [False, True])
def test_digits_of_files(package, tmp_path, is_map):
    """A scene with files has the digits of the arrays that they have."""
    x = np.arange(-20, 21) * 0.1
    surface = package.HeightMap(np.round(2.0 - (x[:, None]**2 + x**2) / 20, 3), 0.1) if is_map \
        else {"x": [0.0, 9.0], "y": [0.0, 3.0], "height": [1.04, 1.02], "radius": [10.0, 10.0]}
    if is_map:
        surface.write(tmp_path / "s.txt")
    else:
        (tmp_path / "s.csv").write_text("x,y,height\n0,0,1.04\n9,3,1.02\n")
    names = "'s.txt', map_spacing = 0.1, 0.1" if is_map else "'s.csv', radius = 10.0, 10.0"
    (tmp_path / "s.scene").write_text(
        f"&surfaces upper = 'plane', lower = {names} /\n&material contact_modulus = 1e3 /\n"
        "&loading control = 'load', value = 5 /\n")
    of_file = package.accuracy(tmp_path / "s.scene", seconds=SECONDS)
    of_arrays = package.accuracy({
        "surfaces": {"upper": "plane", "lower": surface}, "material": {"contact_modulus": 1e3},
        "loading": {"control": "load", "value": 5}}, seconds=SECONDS)
    # Of a map in a dict finer pixels are the reference, which average the digits.
    assert of_file.digits == pytest.approx(of_arrays.digits, rel=0.5 if is_map else 1e-6)
    assert of_file.digits > 1e-3
