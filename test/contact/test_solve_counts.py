"""States solved for the states asked for, as `--cost` counts them: one each without a load, at most
eight more a load or an event, and one choice of effects each; on pixels one more to estimate
influences."""

import re

import numpy as np
import pytest

from map_press_truth import rough
from programs import run_program
from surfaces_csv import solve, write_plane_scene, write_scene

rng = np.random.default_rng(5)
CAPS = [(3 * i + rng.uniform(-0.5, 0.5), 3 * j + rng.uniform(-0.5, 0.5),
         1 + rng.uniform(0, 0.05), 2.0) for i in range(6) for j in range(6)]
COUPLED, BOUNDARY = {"interaction": "coupled"}, {"interaction": "boundary"}
PLASTIC = {"plasticity": "on", "plastic_yield_stress": 2.0}
ADHESIVE = {"adhesion": "on", "work_of_adhesion": 1e-3, "equilibrium_distance": 1e-3}
HELD = {"creep": "on", "relaxed_modulus_ratio": 0.5, "relaxation_time": 10.0, "hold": "load",
        "hold_time": 10.0, "hold_points": 5}
EFFECTS = {"coupled": COUPLED, "boundary": BOUNDARY, "auto": {"interaction": "auto"},
           "plastic": PLASTIC, "plastic coupled": PLASTIC | COUPLED, "adhesive": ADHESIVE,
           "held": HELD, "held coupled": HELD | COUPLED}
# Loading, states, and those of them whose compression is searched for a load.
DEPTH, DEPTHS = ("compression", 0.03), ("compression", (0.03, 0.01, 0.03))
LOAD, LOADS = ("load", 5.0), ("load", (5.0, 1.0, 5.0))
LOADINGS = {"one": (DEPTH, 0, 1, 0), "eight": (DEPTH, 8, 9, 0), "cycle": (DEPTHS, 4, 13, 0),
            "load": (LOAD, 0, 1, 1), "eight to a load": (LOAD, 8, 9, 1),
            "cycle of loads": (LOADS, 4, 13, 13)}


def counts(asperity, scene, *words):
    """States solved, states asked for, choices of effects."""
    said = run_program(asperity, "solve", scene, "--cost", "--quiet", *words).stdout
    found = re.search(r"^solves: (\d+) for (\d+) states?, effects chosen (\d+) times?$", said,
                      re.MULTILINE)
    return list(map(int, found.groups()))


@pytest.mark.parametrize("loading", LOADINGS)
@pytest.mark.parametrize("effects", EFFECTS)
def test_asperities(effects, loading, asperity, tmp_path):
    (control, value), points, states, loads = LOADINGS[loading]
    held = 4 if "held" in effects else 0
    if held and isinstance(value, tuple):
        pytest.skip("a hold has no path")
    scene = write_plane_scene(
        tmp_path, CAPS, loading={"control": control, "value": value, "points": points},
        effects=EFFECTS[effects])
    solves, found, choices = counts(asperity, scene)
    assert found == states + held
    assert solves <= found + 8 * (loads + held)
    if not loads + held:  # `auto` leaves out interaction at small compressions
        assert solves <= found if effects == "auto" else solves == found
    assert choices <= found + 8 * (loads + held) + 1


@pytest.mark.parametrize("loads", [(5.0, -0.01), (5.0, 0.0), (-0.002,), (1.0, 0.2, -0.005)],
                         ids=str)
def test_pull_off(loads, asperity, tmp_path):
    """Where contacts separate no states are solved beside those of the loads on loading."""
    scene = write_plane_scene(tmp_path, CAPS, effects=ADHESIVE, loading={
        "control": "load", "value": loads if len(loads) > 1 else loads[0]})
    solves, states, choices = counts(asperity, scene)
    assert states == len(loads) and choices <= solves <= states + 8


@pytest.mark.parametrize("effects, loading", [(COUPLED, LOAD), (COUPLED, DEPTH), (BOUNDARY, LOAD),
                                              ({"interaction": "auto"}, DEPTH)], ids=str)
def test_events(effects, loading, asperity, tmp_path):
    """At most eight solves more for the compression of an event, on average."""
    control, value = loading
    scene = write_plane_scene(tmp_path, CAPS, effects=effects, loading={
        "control": control, "value": value, "events": "on"})
    solves, states, _ = counts(asperity, scene)
    assert states > 8 and solves <= 9 * states


NUMBERS = {"work_of_adhesion": 0.05, "equilibrium_distance": 1.0, "adhesion_law": "exponential"}
CREEP = {"relaxed_modulus_ratio": 0.5, "relaxation_time": 10.0, "hold": "load", "hold_time": 10.0,
         "hold_points": 3}
HARD = {"plasticity": "on", "plastic_hardness": 0.05}


@pytest.mark.parametrize("effects, positions, solved_more, choices", [
    ({}, 1, 0, 0), ({}, 3, 0, 0), (HARD, 1, 0, 0), ({"adhesion": "on", **NUMBERS}, 1, 0, 0),
    (NUMBERS, 1, 1, 1), (NUMBERS, 3, 3, 3), (NUMBERS | {"work_of_adhesion": 1e-12}, 1, 1, 1),
    (CREEP, 1, 1, 1)], ids=str)
@pytest.mark.parametrize("value, points, states", [
    (0.02, 0, 1), (0.02, 4, 5), ((0.02, 0.01, 0.02), 2, 7)])
def test_pixels(effects, positions, solved_more, choices, value, points, states, asperity,
                tmp_path):
    """The estimate of effects needs the last state alone; it is the result where it is the only one
    and no effect is called for."""
    np.save(tmp_path / "map.npy", 0.1 * rough(32, seed=3))
    if effects is CREEP and isinstance(value, tuple):
        pytest.skip("a hold has no path")
    scene = write_scene(
        tmp_path / "map.scene", by_default=True,
        surfaces={"upper": "map.npy", "lower": "map.npy", "map_spacing": (1.0, 1.0),
                  "map_edge": "periodic"} if positions > 1 else
        {"upper": "plane", "lower": "map.npy", "map_spacing": (1.0, 1.0)},
        material={"contact_modulus": 1.0}, effects=effects,
        loading={"control": "pressure", "value": value, "points": points},
        **({"motion": {"x_first": 1.0, "x_step": 1.0, "positions": positions}}
           if positions > 1 else {}))
    solves, found, chosen = counts(asperity, scene)
    held = 2 if effects is CREEP else 0
    assert found == positions * (states + held)
    assert chosen == choices
    if effects.get("work_of_adhesion") == 1e-12 and states == 1:
        solved_more = 0
    assert solves == found + solved_more


@pytest.mark.parametrize("edge", ["periodic", "free"])
@pytest.mark.parametrize("sides", [(0.1, 1.0), (4.0, 1.0)], ids=str)
def test_iterations_on_long_pixels(sides, edge, asperity, tmp_path):
    """They need about as many iterations as square ones: the approximate inverse has their sides;
    one for squares needs twice as many."""
    np.save(tmp_path / "map.npy", 0.1 * rough(128, seed=3, stretched=sides[1] / sides[0]))
    iterations = []
    for spacing in ((1.0, 1.0), sides):
        scene = write_scene(
            tmp_path / "map.scene", surfaces={
                "upper": "plane", "lower": "map.npy", "map_spacing": spacing, "map_edge": edge},
            material={"contact_modulus": 1.0}, effects=BOUNDARY,
            loading={"control": "pressure", "value": 0.002})
        iterations.append(int(solve(asperity, scene).positions[0]["interaction_iterations"]))
    assert iterations[1] <= 1.5 * iterations[0], iterations


def test_projected_steps(asperity, tmp_path):
    """Pixels a thousand times as long as wide, some missing: no conjugate step is accepted, and
    projected steps of the length 1/|A| take more than 2000 iterations."""
    random = np.random.default_rng(138)
    k = np.arange(1, 17)
    waves = np.cos(2 * np.pi * (np.outer(np.arange(64) / 64, k) + random.random(16)))
    height = np.repeat(0.01 * waves @ k[:, None] ** -1.8, 96, 1)
    height[random.random(height.shape) < 0.1] = np.nan
    np.save(tmp_path / "map.npy", height)
    scene = write_scene(
        tmp_path / "map.scene", surfaces={"upper": "plane", "lower": "map.npy",
                                          "map_spacing": (0.001, 1.0), "map_edge": "periodic"},
        material={"contact_modulus": 1.0}, effects=BOUNDARY,
        loading={"control": "pressure", "value": 1e-4})
    assert float(solve(asperity, scene).positions[0]["interaction_residual"]) <= 1e-10
