"""Controls of &loading: one state by each of them, and the mean gap of a periodic map."""

import numpy as np
import pytest
from map_press_truth import first_contact
from map_scenes import E, map_scene, solve_map
from programs import run_program
from surfaces_csv import solve, write_csv_scene

PIXELS, SIDE = 32, 1 / 32
PERIODIC = {"map_edge": "periodic"}
CAPS = [(0.0, 0.0, 0.30, 1.0), (0.9, 0.2, 0.297, 1.5), (0.3, 1.1, 0.293, 0.7)]


def periodic_map(seed, mean=0.0):
    """Heights of random waves of at least six pixels, of root mean square 0.01."""
    wave = np.fft.fftfreq(PIXELS, SIDE)
    length = np.hypot(*np.meshgrid(wave, wave))
    size = np.where((length > 0) & (length < PIXELS / 6), np.maximum(length, 1.0) ** -1.8, 0.0)
    phase = np.random.default_rng(seed).uniform(0.0, 2 * np.pi, length.shape)
    height = np.fft.ifft2(size * np.exp(1j * phase)).real
    return 0.01 * height / height.std() + mean


def solved(asperity, folder, height, loading, **groups):
    """States of a periodic map, with its heights as they are."""
    surfaces = {**PERIODIC, "map_level": "none", **groups.pop("surfaces", {})}
    states = solve_map(asperity, map_scene(folder, height, SIDE, surfaces=surfaces,
                                           loading=loading, **groups))[0]
    return states


def pressure_for(share):
    """A nominal pressure that brings about a share of these maps into contact."""
    return share * E * 0.1


@pytest.mark.parametrize("mean", (0.0, -3.0))
@pytest.mark.parametrize("share", (0.01, 0.2, 0.6, 1.0))
def test_mean_gap_of_a_load_gives_the_load_back(asperity, tmp_path, share, mean):
    """The mean gap is a monotone function of the load: its inverse is unique."""
    height = periodic_map(7, mean)
    by_load, = solved(asperity, tmp_path, height, {"control": "pressure",
                                                   "value": pressure_for(share)})
    assert 0.0 < by_load["area_fraction"] < 1.0
    by_gap, = solved(asperity, tmp_path, height, {"control": "mean_gap",
                                                  "value": by_load["mean_gap"]})
    for name in ("load", "area", "separation", "rms_gap"):
        assert by_gap[name] == pytest.approx(by_load[name], rel=1e-6)
    assert by_gap["separation"] == pytest.approx(mean + by_load["mean_gap"], rel=1e-9)


@pytest.mark.parametrize("count", (64, 256))
@pytest.mark.parametrize("half", (0.2, 0.35, 0.45))
def test_mean_gap_of_a_wave(asperity, tmp_path, half, count):
    """Westergaard (1939): the wave d cos(2 pi x/l) under a flat, in contact over |x| < a.

    With s = sin(pi a/l)**2 the nominal pressure is s pi E d/l (Johnson, Contact Mechanics, 1985,
    equation 13.7). At constant a it acts as on a row of punches, so that the mean gap g falls by
    dg/dp = (2 l/(pi E)) ln sin(pi a/l). From g = d without load, g/d = 1 - s + s ln(s); full
    contact is at s = 1, and the work done until then, pi E d**2/(4 l) for a unit area, is the
    energy of a wave. On pixels the rim of the contact is within half a pixel of a, which is that
    share of s; the energy is stationary in a, so that the gap of a load is in error by its square.
    """
    def gap(s):
        return 1 - s + s * np.log(s)

    depth = 0.01
    x = (np.arange(count) + 0.5) / count
    height = np.tile(depth * np.cos(2 * np.pi * x), (3, 1)).T
    s = np.sin(np.pi * half) ** 2
    scene = map_scene(
        tmp_path, height, 1 / count, surfaces=PERIODIC,
        loading={"control": "mean_gap", "value": float(depth * gap(s))})
    state, = solve_map(asperity, scene)[0]
    found = state["nominal_pressure"] / (np.pi * E * depth)
    rim = np.pi * np.sin(2 * np.pi * half) / (2 * count)
    assert found == pytest.approx(s, abs=rim)
    assert gap(found) == pytest.approx(gap(s), abs=rim ** 2)
    assert state["area_fraction"] == pytest.approx(2 * half, abs=2 / count)


def test_path_of_mean_gaps(asperity, tmp_path):
    """The path begins at first contact; the load rises where the gap falls, and back on its way."""
    height = periodic_map(3, 0.5)
    ends = [0.02, 0.008, 0.014]
    states = solved(asperity, tmp_path, height,
                    {"control": "mean_gap", "value": ends, "points": 3})
    gaps = np.array([row["mean_gap"] for row in states])
    loads = np.array([row["load"] for row in states])
    expected = [first_contact(height, True) - height.mean()]
    for end in ends:
        expected += list(np.linspace(expected[-1], end, 4)[1:])
    assert gaps == pytest.approx(np.array(expected), rel=1e-8)
    assert loads[0] == 0.0
    assert (np.diff(loads)[np.diff(gaps) < 0] > 0).all()
    assert (np.diff(loads)[np.diff(gaps) > 0] < 0).all()
    # Without adhesion or flow a state does not depend on the path.
    alone, = solved(asperity, tmp_path, height, {"control": "mean_gap", "value": ends[-1]})
    assert alone["load"] == pytest.approx(loads[-1], rel=1e-7)


def test_mean_gap_above_first_contact(asperity, tmp_path):
    """Surfaces that are apart carry no load, and their gap is the prescribed one."""
    height = periodic_map(3)
    state, = solved(asperity, tmp_path, height, {"control": "mean_gap", "value": 0.5})
    assert state["load"] == 0.0
    assert state["mean_gap"] == pytest.approx(0.5, rel=1e-14)


@pytest.mark.parametrize("effects", (
    {"adhesion": "on", "work_of_adhesion": 2e-4, "equilibrium_distance": 0.003},
    {"creep": "on", "relaxation_time": 1.0, "relaxed_modulus_ratio": 0.4, "loading_time": 2.0,
     "hold_time": 3.0, "hold": "separation"}))
def test_mean_gap_with_effects(asperity, tmp_path, effects):
    """With attraction, and while the load relaxes, the mean gap is the prescribed one."""
    states = solved(asperity, tmp_path, periodic_map(11, 0.2), {"control": "mean_gap",
                                                               "value": 0.012}, effects=effects)
    last = states[-1]
    assert last["contacts"] > 0
    assert last["mean_gap"] == pytest.approx(0.012, rel=1e-7)
    if "creep" in effects:
        assert last["load"] < 0.9 * max(row["load"] for row in states)


def test_mean_gap_of_maps_that_move(asperity, tmp_path):
    """At each position of two maps the mean gap is the prescribed one."""
    heights = periodic_map(1), periodic_map(2, 0.3)
    np.save(tmp_path / "upper.npy", heights[0].T)
    scene = map_scene(
        tmp_path, heights[1], SIDE, upper="upper.npy", surfaces={**PERIODIC, "map_level": "none"},
        loading={"control": "mean_gap", "value": 0.015},
        motion={"x_step": 5 * SIDE, "positions": 3})
    found = solve(asperity, scene)
    assert found.status == 0, found.stderr
    assert len({row["separation"] for row in found.positions}) > 1
    for row in found.positions:
        assert float(row["mean_gap"]) == pytest.approx(0.015, rel=1e-8)
        assert float(row["load"]) > 0.0


@pytest.mark.parametrize("name", ("separation", "approach", "compression", "load",
                                  "vertical_load", "pressure", "mean_gap"))
def test_each_control_gives_one_state(asperity, tmp_path, name):
    """The value of its own column prescribes the same state, of a map and of asperities."""
    column = {"approach": "separation", "pressure": "nominal_pressure"}.get(name, name)
    height = periodic_map(5, 0.1)
    first, = solved(asperity, tmp_path, height, {"control": "load", "value": pressure_for(0.3)})
    again, = solved(asperity, tmp_path, height, {"control": name, "value": first[column]})
    assert again["load"] == pytest.approx(first["load"], rel=1e-6)
    if name == "mean_gap":
        return

    def caps(**loading):
        scene = write_csv_scene(tmp_path, CAPS, [(0.1, 0.1, 0.2, 2.0)], loading=loading,
                                effects={"interaction": "coupled"})
        scene.write_text(scene.read_text().replace("&surfaces", "&surfaces nominal_area = 2."))
        found = solve(asperity, scene)
        assert found.status == 0, found.stderr
        return found.positions[0]

    first = caps(control="compression", value=0.015)
    again = caps(control=name, value=float(first[column]))
    assert again["contacts"] == first["contacts"]
    for other in ("load", "vertical_load", "area", "compression"):
        assert float(again[other]) == pytest.approx(float(first[other]), rel=1e-9)


@pytest.mark.parametrize("change, reason", (
    ({"surfaces": {"map_edge": "free"}}, "sets the separation of a periodic map alone"),
    ({"surfaces": {"map_edge": ["free", "periodic"]}}, "is known by its load"),
    ({"surfaces": PERIODIC, "effects": {"plasticity": "on", "plastic_hardness": 1.0}},
     "plastic flow changes the mean height"),
    ({"surfaces": PERIODIC, "value": 0.0}, "expected a number more than 0"),
    ({"surfaces": PERIODIC, "value": [0.01, -0.01]}, "expected a number more than 0"),
    ({"surfaces": PERIODIC, "missing": True}, "missing pixels have no gap")))
def test_refused_mean_gaps_of_maps(asperity, tmp_path, change, reason):
    height = periodic_map(2)
    if change.pop("missing", False):
        height[3, 4] = np.nan
    value = change.pop("value", 0.01)
    refused = solve_map(asperity, map_scene(
        tmp_path, height, SIDE, loading={"control": "mean_gap", "value": value}, **change),
        status=2).splitlines()
    assert len(refused) == 1
    assert reason in refused[0]


def test_refused_mean_gap_of_asperities(asperity, tmp_path):
    scene = write_csv_scene(tmp_path, CAPS, [(0.1, 0.1, 0.2, 2.0)],
                            loading={"control": "mean_gap", "value": 0.01})
    refused = run_program(asperity, "solve", scene, status=2).stderr.splitlines()
    assert len(refused) == 1
    assert "between asperities the surfaces have no height" in refused[0]
    assert "'mean_gap'" not in refused[0].split("expected")[1]


def test_mean_gap_in_the_summary(asperity, tmp_path):
    """The heading names the control, and each end of a path has a line."""
    scene = map_scene(tmp_path, periodic_map(5), SIDE, surfaces=PERIODIC,
                      loading={"control": "mean_gap", "value": [0.015, 0.01, 0.02]})
    printed = run_program(asperity, "solve", scene).stdout
    assert "; control: mean_gap; " in printed
    assert [f"end {k}" in printed for k in (1, 2, 3, 4)] == [True, True, True, False]
