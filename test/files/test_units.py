"""Names of units: reported wherever results are, never converted; what contradicts them is
refused."""

import json
import re

import numpy as np
import pytest
from builds import ROOT
from made_maps import write_bytes
from programs import run_program
from surfaces_csv import write_csv_scene

SURFACES = "upper = 'pair_upper.csv', lower = 'pair_lower.csv'"
NAMED = "length mm, force N, area mm2, pressure MPa"


def run(asperity, *words, status=0):
    return run_program(asperity, "solve", *words, status=status, cwd=ROOT)


def scene_with(folder, units, header="x,y,height,radius"):
    scene = write_csv_scene(folder, [(0, 0, .2, 1)], [(0, 0, .1, 1)],
                            loading={"control": "approach", "value": 0.29})
    text = scene.read_text()
    assert SURFACES in text
    scene.write_text(text.replace(SURFACES, f"{SURFACES}{units}"))
    surface = folder / "pair_upper.csv"
    surface.write_text(surface.read_text().replace("x,y,height,radius", header))
    return scene


def test_units_change_no_number(asperity, tmp_path):
    """The same bytes but for the names."""
    files = {option: tmp_path / option[2:] for option in ("--positions", "--contacts", "--curve",
                                                          "--json")}
    words = [word for pair in files.items() for word in pair]
    bare = run(asperity, scene_with(tmp_path, ""), *words).stdout
    without = {option: path.read_text() for option, path in files.items()}
    scene = scene_with(tmp_path, ", units = 'mm', 'N'")
    shown = run(asperity, scene, *words).stdout
    assert "total load (N) " in shown and "contact area (mm2) " in shown and "(MPa) " in shown
    assert [re.sub(r" \((?!Hertz)[^)]*\) *", " ", line).split() for line in shown.splitlines()] == \
        [line.split() for line in bare.splitlines()]
    named = {option: path.read_text() for option, path in files.items()}
    for option in ("--positions", "--contacts", "--curve"):
        assert named[option] == without[option]
    assert json.loads(named["--json"])["scene"]["units"] == {"length": "mm", "force": "N"}
    assert "units" not in json.loads(without["--json"])["scene"]
    run(asperity, scene, *words, "--units", "--quiet")
    for option in ("--positions", "--contacts", "--curve"):
        assert files[option].read_text() == f"# units: {NAMED}\n{without[option]}"


@pytest.mark.parametrize("length, force, pressure", [
    ("mm", "N", "MPa"), ("um", "uN", "MPa"), ("m", "N", "Pa"), ("um", "mN", "GPa"),
    ("nm", "nN", "GPa"), ("mm", "kN", "kN/mm2"), ("\u00b5m", "\u03bcN", "MPa")])
def test_names_of_pressures(asperity, tmp_path, length, force, pressure):
    """A force on an area has its own name where the units give one; `u` is the one micro sign."""
    scene = scene_with(tmp_path, f", units = '{length}', '{force}'")
    out = run(asperity, scene, "--units", "--curve", tmp_path / "c").stdout
    micro = str.maketrans("\u00b5\u03bc", "uu")
    length, force = length.translate(micro), force.translate(micro)
    assert f"greatest pressure ({pressure}) " in out and f"contact area ({length}2) " in out
    assert (tmp_path / "c").read_text().startswith(
        f"# units: length {length}, force {force}, area {length}2, pressure {pressure}\n")


def test_units_of_a_deck(asperity, tmp_path):
    scene = ROOT / "data/examples/position_56.scene"
    out = run(asperity, scene, "--units", "--positions", tmp_path / "p")
    units = "units: length cm, force N, area cm2, pressure N/cm2"
    assert "total load (N) " in out.stdout and "contact area (cm2) " in out.stdout
    assert (tmp_path / "p").read_text().startswith(f"# {units}\nposition,")


@pytest.mark.parametrize("units, answer", [
    ("'mm'", "units: wrong number of values: found 1, expected 2"),
    ("'mm', 2", "units: found '2', expected a text of 1 to 16 bytes between quotes"),
    ("'mm', ' '", "units: found the text ' ', expected a text of 1 to 16 bytes between quotes"),
    (f"'{17 * 'm'}', 'N'", "expected a text of 1 to 16 bytes"),
    ("'cm', 'N'", "units: found length 'cm' beside 'mm' in the header of a surface")])
def test_refused(asperity, tmp_path, units, answer):
    scene = scene_with(tmp_path, f", units = {units}", "x [mm],y [mm],height [mm],radius [mm]")
    assert answer in run(asperity, scene, status=2).stderr


def test_refused_otherwise(asperity, tmp_path):
    assert "--units: the scene does not name its units" in run(
        asperity, scene_with(tmp_path, ""), "--units", status=2).stderr
    scene = tmp_path / "d.scene"
    scene.write_text(f"&surfaces deck = '{ROOT}/data/thesis.deck', units = 'mm', 'N' /\n")
    assert ":1:" in (said := run(asperity, scene, status=2).stderr)
    assert "units: found beside deck, which brings cm and N" in said


def test_unit_of_a_map_without_units(asperity, tmp_path):
    """The unit of a map names lengths and areas; forces and pressures have none."""
    heights = np.zeros((4, 4))
    heights[1, 1] = 1e-6
    write_bytes(tmp_path / "m.sdf", heights, 1e-6, 1e-6)
    (tmp_path / "m.scene").write_text(
        "&surfaces upper = 'plane', lower = 'm.sdf', map_unit = 'um' /\n"
        "&material contact_modulus = 1e3 /\n&loading control = 'load', value = 1. /\n"
        "&effects interaction = 'boundary' /\n")
    shown = run(asperity, tmp_path / "m.scene").stdout
    assert "separation (um) " in shown and "contact area (um2) " in shown
    assert "total load  " in shown and "mean pressure  " in shown
