"""`asperity.accuracy`: errors of `asperity accuracy`, rows that can be typed, digits of heights."""

import csv
import re

import numpy as np
import pytest
from programs import run_program

pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]

CAPS = 30
OF_COMMAND = {"as in the scene": "as in the scene", "isolated contacts": "interaction='off'",
              "contacts coupled": "interaction='coupled'",
              **{f"auto; tolerance {share}": f"interaction='auto', tolerance={share}"
                 for share in ("0.01", "0.003", "0.001")},
              **{f"boundary elements; {share}":
                 f"interaction='boundary', boundary_tolerance={share}"
                 for share in ("0.01", "0.001", "0.0001")}}


@pytest.fixture(scope="module")
def caps(package):
    _, lower = package.generate({
        "surfaces": {"number": CAPS, "length": 60, "width": 60},
        "heights": {"mean": 2, "deviation": 0.3}, "radii": {"mean": 20.0}})
    return lower


def test_errors_of_the_command(package, caps, asperity, tmp_path):
    """The same errors of the methods that both have, against the same reference."""
    (tmp_path / "l.csv").write_text("x,y,height,radius\n" + "".join(
        ",".join(repr(row[name]) for name in ("x", "y", "height", "radius")) + "\n"
        for row in caps.rows()))
    (tmp_path / "s.scene").write_text(
        "&surfaces upper = 'plane', lower = 'l.csv' /\n&material contact_modulus = 1e5 /\n"
        "&loading control = 'load', value = 1e5 /\n")
    run_program(asperity, "accuracy", tmp_path / "s.scene", "--quiet", "--csv", tmp_path / "a.csv",
                "--seconds", "20")
    found = package.accuracy(tmp_path / "s.scene", ["area", "separation"], seconds=20)
    rows = {OF_COMMAND.get(row["method"]): row
            for row in csv.DictReader(open(tmp_path / "a.csv", encoding="ascii"))
            if row["error_max"]}
    [reference] = [name for name, row in rows.items() if row["reference"] == "1"]
    assert found.reference == reference
    compared = 0
    for number, method in enumerate(found.table["method"].tolist()):
        for name, title in (("separation", "error_max"), ("area", "area_error_max")):
            if method in rows:
                own = found.own[name]
                compared += 1
                assert found.table[name][number] == pytest.approx(
                    max(own, float(rows[method][title])), rel=1e-6), (method, name)
    assert compared >= 10 and max(found.own.values()) > 0


def test_rows_can_be_typed(package):
    """What a row says to type gives the totals of its errors."""
    lower = package.generate_map(pixels=64, spacing=1, unit="um", hurst=0.8, rms_slope=0.02)
    def groups(surface):
        return {"surfaces": {"upper": "plane", "lower": surface, "units": ("um", "uN")},
                "material": {"contact_modulus": 1e5},
                "loading": {"control": "pressure", "value": 100, "points": 3}}
    found = package.accuracy(groups(lower), ["area", "pressure"])
    assert "pixels of the map" in found.table["method"].tolist() and len(found.table) >= 4
    solved = {}
    for row in found.table.rows():
        names = {"HeightMap": package.HeightMap, "lower": lower}
        exec(row["type"].replace("scene.solve()", "lower = lower"), names)
        results = package.solve(groups(names["lower"]))
        solved[row["method"]] = (results.states["area"][-1], results.contacts["maximum_pressure"][
            results.contacts["step"] == results.states["step"][-1]].max())
    for row in found.table.rows():
        for number, name in enumerate(("area", "pressure")):
            mine, best = solved[row["method"]][number], solved[found.reference][number]
            assert row[name] == pytest.approx(max(found.own[name], abs(mine - best) / best),
                                              rel=1e-6, abs=1e-9)


def test_answers(package, caps):
    """The fastest row within a goal; text, table and figure have them."""
    scene = {"surfaces": {"upper": "plane", "lower": caps}, "material": {"contact_modulus": 1e5},
             "loading": {"control": "load", "value": 1e5}}
    found = package.accuracy(scene, goals=(0.5, 1e-30))
    assert list(found.own) == ["area", "separation", "pressure"]
    row = found.answer(0.5, "separation")
    within = found.table["separation"] <= 0.5
    assert row["seconds"] == found.table["seconds"][within].min() and row["separation"] <= 0.5
    assert found.answer(1e-30, "area") is None and "not reached, best" in str(found)
    assert all(row["type"] in str(found) for row in found.table.rows())
    axes = found.plot()
    assert len([line for line in axes.lines if line.get_drawstyle() == "steps-post"]) == 3
    assert "<img" in found._repr_html_()
    with pytest.raises(ValueError, match="of: found 'load', expected 'area', 'separation'"):
        found.answer(0.1, "load")
    with pytest.raises(ValueError, match="quantities: found"):
        package.accuracy(scene, ["volume"])
    short = package.accuracy(scene, seconds=0.0)
    assert re.search(r"Left out: interaction='auto', tolerance=0.003: it could take", str(short))


def test_digits_of_heights(package):
    """A cap alone under a prescribed compression d of its scene: half of its last digit changes the
    load by the law of Hertz."""
    cap = {"x": [0.0], "y": [0.0], "height": [1.04], "radius": [10.0]}
    found = package.accuracy({
        "surfaces": {"upper": cap, "lower": "plane"}, "material": {"contact_modulus": 1000.0},
        "loading": {"control": "separation", "value": 1.0}})
    expected = [abs((1 + sign * 0.005 / 0.04)**1.5 - 1) for sign in (-1, 1)]
    assert np.isclose(found.digits, expected, rtol=1e-9).any()
    assert "digit of the heights" in str(found)
