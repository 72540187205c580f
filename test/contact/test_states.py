"""The states of a position: `points` and `events` of &loading.

References: the number asked for; equal parts of the compression; on a plane the height of a summit
below the highest, at which its isolated contact begins; Johnson's closed form of the displacement
beside a Hertzian contact (Contact Mechanics, 1985, eq. 3.42a), by which a contact begins later.
"""

import re
import sys

import numpy as np
import pytest
from coupled_truth import hertz_displacement
from made_maps import self_affine
from programs import run_program
from surfaces_csv import records, solve, write_plane_scene, write_scene

E, RADIUS = 1000.0, 2.0
# Heights are multiples of 1/8, so that the compression at which a contact begins is exact.
CAPS = [(0.0, 0.0, 1.0, RADIUS), (2.0, 0.0, 0.875, RADIUS), (0.0, 4.0, 0.625, RADIUS),
        (5.0, 5.0, -0.5, RADIUS)]
CONTROLS = {
    "limit": {"control": "limit"},
    "approach": {"control": "approach", "value": 0.5},
    "load": {"control": "load", "value": 700.0},
    "vertical_load": {"control": "vertical_load", "value": 700.0},
    "pressure": {"control": "pressure", "value": 7.0}}
MODES = ("off", "coupled", "boundary", "auto", None)


def pressed(asperity, folder, loading, mode, caps=CAPS, options=(), **groups):
    effects = {} if mode is None else {"effects": {"interaction": mode}}
    scene = write_plane_scene(folder, caps, {"nominal_area": 100.0}, E, limit={"value": 500.0},
                              loading=loading, **effects, **groups)
    return solve(asperity, scene, *options, curve=True)


def numbers(rows, name):
    return np.array([float(row[name]) for row in rows])


def marked(mode):
    """Boundary elements under many loads take seconds."""
    return pytest.param(mode, marks=[pytest.mark.truth] * (mode == "boundary"))


@pytest.mark.parametrize("mode", [marked(mode) for mode in MODES])
@pytest.mark.parametrize("control", CONTROLS)
def test_points_are_the_states(asperity, tmp_path, control, mode):
    for points, states in ((0, 1), (1, 1), (2, 3), (5, 6)):
        run = pressed(asperity, tmp_path, CONTROLS[control] | {"points": points}, mode)
        assert run.status == 0, run.stderr
        assert len(run.curve) == int(run.positions[0]["steps"]) == states
        closed = numbers(run.curve, "compression")
        assert closed[-1] > 0.25, "fewer than two contacts"
        if points > 1:
            assert np.abs(closed / closed[-1] - np.linspace(0, 1, states)).max() < 1e-9
            assert float(run.curve[0]["load"]) == 0 and run.curve[0]["contacts"] == "1"


@pytest.mark.parametrize("control", CONTROLS)
def test_events_of_isolated_contacts(asperity, tmp_path, control):
    """Points and events together; the events alone; a contact carries nothing where it begins."""
    for mode, caps in (("off", CAPS), ("auto", [(x, 1e6 * y, h, r) for x, y, h, r in CAPS[::2]])):
        gaps = [1.0 - cap[2] for cap in caps]
        for points in (0, 4):
            run = pressed(asperity, tmp_path,
                          CONTROLS[control] | {"points": points, "events": "on"}, mode, caps)
            assert run.status == 0, run.stderr
            closed = numbers(run.curve, "compression")
            begun = [gap for gap in gaps if gap <= closed[-1]]
            assert len(begun) > 1
            parts = [closed[-1] * k / 4 for k in range(4)] if points else []
            assert np.array_equal(closed, sorted({*begun, *parts, closed[-1]}))
            for number, gap in enumerate(begun, 1):
                step = str(int(np.flatnonzero(closed == gap)[0]) + 1)
                rows = [row for row in run.contacts if row["step"] == step]
                assert len(rows) == number and float(rows[-1]["load"]) == 0.0


def lowered(a):
    """How far a contact of radius a at (0, 0) lowers the second cap, which touches a little beyond
    its summit, where the surface is lower: the least of its height and the displacement."""
    s = np.linspace(0.0, 0.2, 100_001)
    beside = hertz_displacement(2.0 + s, a)[0] * 4 / 3 * a**3 / RADIUS
    return (s**2 / (2 * RADIUS) + beside).min()


@pytest.mark.parametrize("mode", [marked(mode) for mode in MODES[1:4]])
@pytest.mark.parametrize("control", CONTROLS)
def test_events_of_contacts_that_interact(asperity, tmp_path, control, mode):
    run = pressed(asperity, tmp_path, CONTROLS[control] | {"points": 3, "events": "on"}, mode,
                  CAPS[:2])
    assert run.status == 0, run.stderr
    closed = numbers(run.curve, "compression")
    assert len(closed) == 5 and (np.diff(closed) > 0).all()
    event = next(i for i, row in enumerate(run.curve) if row["contacts"] == "2")
    low, high = 0.3, 0.7
    for _ in range(50):
        a = 0.5 * (low + high)
        low, high = (a, high) if a**2 / RADIUS - lowered(a) < 0.125 else (low, a)
    # On cells it is a sphere, not a paraboloid, and the load is good to 1e-3.
    bound = 1e-7 if run.positions[0]["interaction"] == "coupled" else 1e-2
    assert closed[event] == pytest.approx(a**2 / RADIUS, rel=bound)
    step = [row for row in run.contacts if row["step"] == str(event + 1)]
    assert float(step[1]["load"]) < 1e-6 * float(step[0]["load"])


@pytest.mark.parametrize("mode", ["coupled", "boundary", "auto", "off"])
def test_errors_of_each_state(asperity, tmp_path, mode):
    """A row of a curve has the errors of its state solved alone at its compression, at which the
    load has the error, also by what is off. The last one has those of the position."""
    run = pressed(asperity, tmp_path, {"control": "load", "value": 700.0, "points": 4}, mode)
    for row in run.curve[1:-1]:
        alone = pressed(asperity, tmp_path, {"control": "compression",
                                             "value": float(row["compression"])}, mode)
        for name in ("error_estimate", "area_error_estimate")[:1 if mode == "off" else 2]:
            assert float(row[name]) == pytest.approx(float(alone.curve[-1][name]), rel=0.1,
                                                     abs=1e-9), name
            assert run.curve[-1][name] == run.positions[0][name]
    errors = numbers(run.curve[1:-1], "error_estimate")
    assert errors[0] < 0.9 * errors[-1]


def test_a_path_has_only_its_points(asperity, tmp_path):
    path = {"control": "load", "value": (500.0, 100.0, 700.0), "points": 4}
    for mode in ("off", "coupled"):
        run = pressed(asperity, tmp_path, path, mode)
        assert len(run.curve) == 1 + 3 * 4, run.stderr
        run = pressed(asperity, tmp_path, path | {"events": "on"}, mode)
        assert run.status == 2 and "events: found beside several values" in run.stderr


def test_a_map_has_only_its_points(asperity, tmp_path):
    heights, _ = self_affine((24, 24), 3, shortest=6)
    np.savetxt(tmp_path / "map.txt", 1e-3 * heights)
    for events, status in (("off", 0), ("on", 2)):
        scene = write_scene(
            tmp_path / "map.scene",
            surfaces={"upper": "plane", "lower": "map.txt", "map_spacing": (0.02, 0.02)},
            material={"contact_modulus": E}, effects={"interaction": "boundary"},
            loading={"control": "load", "value": 0.01, "points": 4, "events": events})
        run = solve(asperity, scene, curve=True)
        assert run.status == status, run.stderr
        if events == "off":
            assert len(run.curve) == 5 and float(run.curve[0]["load"]) == 0.0
        else:
            assert "events: found beside a map" in run.stderr


def peak_kilobytes(*words):
    """Peak memory of a command."""
    # What a process held before it became another counts for both: this one holds much.
    between = ("import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True); "
               "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)")
    return int(run_program(sys.executable, "-c", between, *words).stdout)


@pytest.mark.once
def test_memory_out_of_reach(asperity, tmp_path):
    """Surfaces that do not touch need no more memory than in contact: candidates of the pair search
    are kept level by level."""
    random = np.random.default_rng(7)
    for name in ("upper.csv", "lower.csv"):
        places = random.random((20_000, 2)) * 28.0
        heights = random.normal(0.127, 0.03, 20_000).clip(0.03, 0.22)
        (tmp_path / name).write_text("x,y,height,radius\n" + "".join(
            f"{x:.7g},{y:.7g},{z:.7g},1.27\n" for (x, y), z in zip(places, heights)))
    peaks = []
    for separation in (0.36, 0.5):
        scene = write_scene(
            tmp_path / "pair.scene", surfaces={"upper": "upper.csv", "lower": "lower.csv"},
            material={"contact_modulus": 2e5}, effects={"interaction": "off"},
            loading={"control": "separation", "value": separation})
        peaks.append(peak_kilobytes(asperity, "solve", scene, "--quiet"))
    assert peaks[1] < 1.3 * peaks[0], peaks


@pytest.mark.once
@pytest.mark.parametrize(("edge", "bytes_a_pixel"), [("periodic", 110), ("free", 130)])
def test_memory_of_a_map(edge, bytes_a_pixel, asperity, root, tmp_path):
    """Bytes a pixel at the largest stage, with fields, beside 12 MB of the program; sides of maps
    that fill the memories of the page."""
    n = 512
    waves = 0.1 * np.cos(2 * np.pi * np.arange(n) * 3 / n)
    np.save(tmp_path / "map.npy", waves[:, None] + waves)
    scene = write_scene(
        tmp_path / "map.scene", surfaces={"upper": "plane", "lower": "map.npy",
                                          "map_spacing": (1.0, 1.0), "map_edge": edge},
        material={"contact_modulus": 1.0}, loading={"control": "pressure", "value": 5e-4},
        effects={"interaction": "boundary"})
    peak = peak_kilobytes(asperity, "solve", scene, "--quiet", "--threads", "1",
                          "--positions", tmp_path / "positions.csv",
                          "--fields", tmp_path / "fields.vti")
    assert 1024 * peak < 12e6 + bytes_a_pixel * n**2, 1024 * peak / n**2
    page = (root / "docs/reference/maps.md").read_text(encoding="utf-8").replace(",", "")
    rows = [map(int, re.search(rf"^\| {name} \| ([\d |]+) \|$", page, re.M)[1].split(" | "))
            for name in ("free memory GiB", edge)]
    for memory, side in zip(*rows, strict=True):
        assert 0.95 < bytes_a_pixel * side**2 / (memory * 2**30) <= 1, side


# The memory of a build with sanitizers is another.
@pytest.mark.truth
@pytest.mark.once
def test_five_points_of_many_contacts(asperity, tmp_path):
    """2264 of 1e5 asperities on 1e5 touch: six states, and below 300 MB with every list written."""
    (tmp_path / "spec").write_text(
        "&surfaces number = 100000, length = 1000., width = 1000. /\n"
        "&heights mean = .5, deviation = .1, lowest_deviation = -3, highest_deviation = 3 /\n"
        "&radii mean = 1. /\n")
    run_program(asperity, "generate", "spec", "--upper", "u.csv", "--lower", "l.csv", cwd=tmp_path)
    scene = write_scene(
        tmp_path / "many.scene",
        surfaces={"upper": "u.csv", "lower": "l.csv", "nominal_area": 1e6},
        material={"elastic_modulus": (2e5, 2e5), "poisson_ratio": (0.3, 0.3)},
        loading={"control": "pressure", "value": 5.0, "points": 5}, effects={"interaction": "off"})
    peak = peak_kilobytes(asperity, "solve", scene, "--quiet", "--curve", tmp_path / "curve.csv",
                          "--json", tmp_path / "all.json")
    assert len(records(tmp_path / "curve.csv")) == 6
    assert peak < 300_000
