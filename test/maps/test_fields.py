"""Pressure, gap and displacement on the pixels of a height map (`--fields`, `--histogram`, the
columns of the gap), against numpy: the pressures of another method, the displacements of the same
pressures, closed forms."""

import csv
import re


import numpy as np
import pytest
from builds import ROOT
from image_data import read_vti
from elements_truth import product
from map_press_truth import first_contact, press, rough
from programs import run_program
from surfaces_csv import records
from map_scenes import E, level, load_for, map_scene

# Pixels along x and y, spacings, edge, whether pixels are missing.
MAPS = [(64, 64, (0.01, 0.01), "periodic", False), (64, 64, (0.01, 0.01), "free", False),
        (96, 64, (0.01, 0.017), "periodic", False), (80, 100, (0.02, 0.01), "free", False),
        (128, 128, (0.01, 0.01), "free", True), (128, 96, (0.01, 0.013), "periodic", True),
        (256, 256, (0.01, 0.01), "periodic", False), (256, 200, (0.01, 0.012), "free", False),
        (512, 512, (0.01, 0.01), "periodic", False), (512, 384, (0.01, 0.01), "free", True)]


def run(asperity, *words, status=0, cwd=ROOT):
    return run_program(asperity, *words, status=status, cwd=cwd)


def perimeter(pressed, there, sides, periodic):
    """Length of the sides between pixels in contact and measured pixels out of contact."""
    total = 0.0
    for axis in (0, 1):
        other = np.roll(pressed, -1, axis), np.roll(there, -1, axis)
        rim = (pressed != other[0]) & there & other[1]
        if not periodic:
            rim = np.delete(rim, -1, axis)
        total += rim.sum() * sides[1 - axis]
    return total


@pytest.mark.parametrize("number", [
    pytest.param(n, marks=[pytest.mark.truth] * (n > 5)) for n in range(len(MAPS))])
def test_ten_maps_against_numpy(asperity, tmp_path, number):
    columns, rows, sides, edge, missing = MAPS[number]
    height = 1e-3 * rough(columns, rows, shortest=8, seed=40 + number)
    load = load_for(height, sides, 0.05)
    if missing:
        height[columns // 3:columns // 2, rows // 2:rows // 2 + 9] = np.nan
    scene = map_scene(tmp_path, height, sides, surfaces={"map_edge": edge},
                      loading={"control": "load", "value": load})
    run(asperity, "solve", scene, "--quiet", "--fields", tmp_path / "f.vti", "--positions",
        tmp_path / "p.csv")
    row = {name: float(cell) for name, cell in records(tmp_path / "p.csv")[0].items()
           if name not in ("interaction",) and cell}
    origin, spacing, fields = read_vti(tmp_path / "f.vti")
    assert origin[:2] == pytest.approx(-0.5 * np.array(sides))
    assert tuple(spacing[:2]) == sides
    there = ~np.isnan(height)
    for name in ("pressure", "gap", "displacement"):
        assert np.array_equal(np.isnan(fields[name]), ~there), name
    periodic = edge == "periodic"
    of = height - np.nanmean(height) if periodic else level(height)
    pressure, gap = fields["pressure"], fields["gap"]
    pressed = np.nan_to_num(pressure) > 0
    assert np.array_equal(fields["contact"], pressed)
    # The load is the sum; the mean is the nominal pressure.
    assert np.nansum(pressure) * np.prod(sides) == pytest.approx(load, rel=1e-12)
    assert np.nanmean(pressure) == pytest.approx(row["nominal_pressure"], rel=1e-12)
    # Conditions of the one solution: gaps of these pressures by another transform.
    act = product(height.shape, sides, 1.0, periodic)
    moved = act(np.nan_to_num(pressure)) / E
    left = row["separation"] - of + moved
    reach = np.ptp(of[there])
    assert np.abs(left[pressed]).max() < 1.001e-10 * reach
    assert np.nanmin(left) > -1.001e-10 * reach
    assert np.nanmax(np.abs(pressure * left)) < 1e-9 * np.nanmax(pressure) * np.nanmax(gap)
    assert np.nanmax(np.abs(fields["displacement"] - moved)) < 1e-12 * np.abs(moved).max()
    assert np.nanmin(pressure) == 0 and np.nanmin(gap) == 0 and np.nanmax(pressure * gap) == 0
    # Pressures and gaps of Polonsky and Keer's method, closed a thousand times better.
    flat, other = press(of, sides, E, load, periodic, closed=1e-12)
    true = np.where(other > 0, 0.0, flat - of + act(other) / E)
    errors = [np.nanmax(np.abs(pressure - other)) / other.max(),
               np.nanmax(np.abs(gap - true)) / np.nanmax(true),
               row["mean_gap"] / np.nanmean(true) - 1,
               row["rms_gap"] / np.sqrt(np.nanmean(true**2)) - 1,
               row["elastic_energy"] / (0.5 * (other * act(other)).sum() / E * np.prod(sides)) - 1,
               row["contact_perimeter"] / perimeter(pressed, there, sides, periodic) - 1]
    print("errors", " ".join(f"{error:.1e}" for error in errors))
    assert max(map(abs, errors)) < 1e-8


@pytest.fixture(scope="module")
def curve(asperity, tmp_path_factory):
    """A free map with missing pixels, three states, with all files; names of units."""
    folder = tmp_path_factory.mktemp("fields")
    height = 1e-3 * rough(60, 44, shortest=6, seed=3)
    height[20:26, 8:12] = np.nan
    scene = map_scene(folder, height, (0.01, 0.012), surfaces={"units": ["mm", "N"]},
                      loading={"control": "load", "value": load_for(
                          height[:20], (0.01, 0.012), 0.3), "points": 3})
    run(asperity, "solve", scene, "--quiet", "--fields", folder / "f.vti", "--fields-of", "all",
        "--curve", folder / "c", "--histogram", folder / "h.csv", "--units")
    with open(folder / "c", newline="") as file:
        assert "pressure MPa" in file.readline()
        states = [{name: float(cell or "nan") for name, cell in row.items()}
                  for row in csv.DictReader(file)]
    return folder, scene, height, states


def test_every_state_has_its_file(curve):
    folder, _, height, states = curve
    names = sorted(path.name for path in folder.glob("*.vti"))
    assert names == [f"f_{k:04}.vti" for k in range(1, 5)]
    for name, state in zip(names, states):
        _, _, fields = read_vti(folder / name)
        assert np.nansum(fields["pressure"]) * 0.00012 == pytest.approx(state["load"], rel=1e-12)
        assert np.nanmean(fields["gap"]) == pytest.approx(state["mean_gap"], rel=1e-12)
        pressed = fields["contact"].astype(bool)
        assert perimeter(pressed, ~np.isnan(height), (0.01, 0.012), False) == pytest.approx(
            state["contact_perimeter"])
    # First contact: no pressure, the gap is that of the map below its top between the pixels.
    _, _, first = read_vti(folder / names[0])
    of = level(height)
    assert np.nanmax(first["pressure"]) == 0 and states[0]["elastic_energy"] == 0
    assert np.nanmax(np.abs(first["gap"] - (first_contact(of) - of))) < 1e-15


def test_histogram_integrates_to_the_contact_area(curve):
    folder, _, height, _ = curve
    _, _, fields = read_vti(folder / "f_0004.vti")
    lines = (folder / "h.csv").read_text().splitlines()
    assert lines[0].startswith("# units: length mm") and lines[1] == "pressure,density"
    centre, density = np.array([line.split(",") for line in lines[2:]], float).T
    pressure = fields["pressure"][fields["contact"] == 1]
    measured = (~np.isnan(height)).sum()
    counts, edges = np.histogram(pressure, 100, (0, pressure.max()))
    width = edges[1]
    assert np.allclose(centre, edges[:-1] + width / 2, rtol=1e-12)
    assert np.allclose(density, counts / measured / width, rtol=1e-12)
    assert density.sum() * width == pytest.approx(pressure.size / measured, rel=1e-12)


def test_a_patch_that_spans_a_periodic_map(asperity, tmp_path):
    """Full contact: no gap anywhere, and the patch has no centre."""
    height = 1e-3 * rough(24, 20, shortest=6, seed=6)
    scene = map_scene(tmp_path, height, (0.01, 0.01), surfaces={"map_edge": "periodic"},
                      loading={"control": "load", "value": load_for(height, (0.01, 0.01), 20.0)})
    run(asperity, "solve", scene, "--quiet", "--contacts", tmp_path / "c", "--fields",
        tmp_path / "f.vti")
    _, _, fields = read_vti(tmp_path / "f.vti")
    assert fields["contact"].all() and not fields["gap"].any()
    patch, = records(tmp_path / "c")
    assert (patch["x"], patch["y"]) == ("", "") and float(patch["load"]) > 0


def test_without_contact(asperity, tmp_path):
    height = 1e-3 * rough(24, 20, shortest=6, seed=6)
    scene = map_scene(tmp_path, height, (0.01, 0.01),
                      loading={"control": "separation", "value": 1.0})
    run(asperity, "solve", scene, "--quiet", "--fields", tmp_path / "f.vti", "--histogram",
        tmp_path / "h.csv")
    _, _, fields = read_vti(tmp_path / "f.vti")
    assert not fields["pressure"].any() and not fields["displacement"].any()
    assert np.abs(fields["gap"] - (1.0 - level(height))).max() < 1e-15
    assert set(np.loadtxt(tmp_path / "h.csv", delimiter=",", skiprows=1).ravel()) == {0.0}


def test_energy_is_the_work_of_loading(asperity, tmp_path):
    """The work along a curve, by Simpson's rule: load over compression."""
    height = 1e-3 * rough(48, 40, shortest=12, seed=8)
    scene = map_scene(tmp_path, height, (0.01, 0.01), loading={
        "control": "compression", "value": 2e-3, "points": 60})
    run(asperity, "solve", scene, "--quiet", "--curve", tmp_path / "c")
    states = np.genfromtxt(tmp_path / "c", delimiter=",", names=True)
    load, step = states["load"], states["compression"][1]
    work = step / 3 * (load[0] + 4 * load[1:-1:2].sum() + 2 * load[2:-1:2].sum() + load[-1])
    assert states["elastic_energy"][-1] == pytest.approx(work, rel=1e-4)


def test_refusals(asperity, tmp_path, curve):
    scene = curve[1]
    for words, text in (
            (("--fields", "a.vtp"), "--fields: found 'a.vtp', expected a name that ends with .vti"),
            (("--fields-of", "all"), "--fields-of: expected --fields FILE beside it"),
            (("--fields", "a.vti", "--fields-of", "first"),
             "--fields-of: found 'first', expected last or all"),
            (("--fields", "-", "--fields-of", "all"), "--fields-of all writes a file a state"),
            (("--fields", "a.vti", "--keep", "k"), "--fields: a file of --keep has no pressure")):
        assert text in run(asperity, "solve", scene, *words, status=2, cwd=tmp_path).stderr
    done = run(asperity, "solve", "data/examples/one_pair.scene", "--fields", tmp_path / "a.vti",
               status=2)
    assert "--fields: no grid for the fields of asperities, expected field_spacing" in done.stderr
    done = run(asperity, "solve", "data/examples/one_pair.scene", "--histogram", tmp_path / "h.csv",
               status=2)
    assert "--histogram: no grid for the fields of asperities" in done.stderr
    assert not list(tmp_path.iterdir())


def test_fields_of_a_hold_have_their_time(asperity, tmp_path):
    """The time of each state, as ParaView reads it; without creep there is none."""
    (tmp_path / "m.txt").write_text("\n".join(" ".join(
        f"{0.02 * np.cos(0.7 * i) * np.cos(0.5 * j):.6f}" for i in range(16)) for j in range(16)))
    creep = "&effects relaxation_time = 1., relaxed_modulus_ratio = 0.5, hold_time = 5., " \
            "hold_points = 4 /"
    for name, effects in (("c", creep), ("e", "")):
        (tmp_path / f"{name}.scene").write_text(
            "&surfaces upper = 'plane', lower = 'm.txt', map_spacing = 1. / &material "
            f"contact_modulus = 1e3 / &loading control = 'pressure', value = 0.3 / {effects}\n")
        run_program(asperity, "solve", f"{name}.scene", "--quiet", "--fields", f"{name}.vti",
                    "--fields-of", "all", "--curve", f"{name}.csv", cwd=tmp_path)
    heads = [path.read_bytes().partition(b"<AppendedData")[0].decode()
             for path in sorted(tmp_path.glob("c_*.vti"))]
    tag = r'<FieldData>\n<DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" ' \
          r'format="ascii">(\S+)</DataArray>\n</FieldData>'
    times = [float(re.search(tag, head)[1]) for head in heads]
    assert times == [float(row["time"]) for row in records(tmp_path / "c.csv")]
    assert times[0] == 0 and times[-1] == 5 and len(times) > 3
    assert b"FieldData" not in (tmp_path / "e_0001.vti").read_bytes()
