"""Heights may count from any plane: a scene that is raised as a whole has the same contacts.

Raising both surfaces by z moves the separation by 2 z and nothing else, under every control.
"""

import random

import pytest

from surfaces_csv import solve, write_scene, write_surface

# What rounding leaves of a load: its digits, over closings that are a thousandth of the heights.
DIGITS = 1e-9
CONTROLS = ("limit", "load", "vertical_load", "pressure", "approach")


def raised(asperity, folder, surfaces, lifts, control, value, **groups):
    """Contacts, load, area and separation less the lift; or why there are none."""
    lift = sum(z for z, rows in zip(lifts, surfaces) if rows)
    names = [write_surface(folder / f"{side}.csv", [(x, y, h + z, r) for x, y, h, r in rows])
             if rows else "plane" for side, z, rows in zip(("upper", "lower"), lifts, surfaces)]
    loading = {"control": control}
    if control == "limit":
        groups["limit"] = {"criterion": "load", "value": value}
    else:
        loading["value"] = value + lift if control == "approach" else value
    run = solve(asperity, write_scene(
        folder / "raised.scene",
        surfaces={"upper": names[0], "lower": names[1], "nominal_area": 100.0},
        material={"elastic_modulus": (210e3, 210e3), "poisson_ratio": (0.3, 0.3)},
        loading=loading, **groups), contacts=False)
    assert run.status in (0, 1), run.stderr
    if run.status:
        return run.status,
    row = run.positions[0]
    return (int(row["contacts"]), float(row["load"]), float(row["area"]),
            float(row["separation"]) - lift)


def check_same(found, expected):
    assert len(found) == len(expected), (found, expected)
    if len(found) == 1:
        return
    *numbers, approach = found
    *wanted, there = expected
    assert numbers == pytest.approx(wanted, rel=DIGITS), (found, expected)
    if found[0] > 0:
        assert approach == pytest.approx(there, abs=1e-3 * DIGITS), (found, expected)


@pytest.mark.long
@pytest.mark.parametrize("control", CONTROLS)
def test_two_spheres(control, asperity, tmp_path):
    """Unit spheres of height 0.1, 0.9 apart in plan: they touch 0.007 past their planes."""
    spheres = [(0.0, 0.0, 0.1, 1.0)], [(0.9, 0.0, 0.1, 1.0)]
    value = {"approach": -0.02, "pressure": 0.1}.get(control, 10.0)
    runs = [raised(asperity, tmp_path, spheres, (z, z), control, value)
            for z in (k / 20 for k in range(-20, 21))]
    assert runs[0][0] == 1
    for run in runs:
        check_same(run, runs[20])


def surface(generator, number, side):
    return [(generator.uniform(0, side), generator.uniform(0, side), generator.uniform(-0.1, 0.1),
             generator.uniform(0.8, 2)) for _ in range(number)]


@pytest.mark.parametrize("seed", range(60))
def test_random_scenes(seed, asperity, tmp_path):
    """Few asperities, sparse or dense, tilted and turned, or on a plane."""
    generator = random.Random(seed)
    side = generator.choice((0.5, 2.0, 4.0))
    surfaces = [surface(generator, generator.randint(1, 8), side) for _ in range(2)]
    if generator.random() < 0.2:
        surfaces[generator.randrange(2)] = []
    tilt = {}
    for name in ("upper_slope", "lower_slope"):
        if generator.random() < 0.4:
            tilt[name] = (generator.uniform(-0.1, 0.1), generator.uniform(-0.1, 0.1))
    if generator.random() < 0.4 and all(surfaces):
        tilt["rotation"] = (generator.uniform(-1, 1), generator.uniform(-1, 1))
    # Half of them by the control that the distance in plan once ended.
    control = "limit" if seed % 2 else generator.choice(CONTROLS)
    value = -0.02 if control == "approach" else 10 ** generator.uniform(-1, 1)
    groups = {"tilt": tilt} if tilt else {}
    lifts = [(0.0, 0.0), (1.0, 1.0), (-1.0, -1.0)] + [
        (generator.uniform(-1, 0.6), generator.uniform(-1, 0.6)) for _ in range(4)]
    lifts[1] = (0.6, 0.6)
    runs = [raised(asperity, tmp_path, surfaces, pair, control, value, **groups)
            for pair in lifts]
    for run in runs:
        check_same(run, runs[0])


def test_many_asperities(asperity, tmp_path):
    """Enough for the search by levels of height, so sparse that few pairs are near in plan."""
    for seed in range(6):
        generator = random.Random(seed)
        surfaces = [surface(generator, 400, 1000.0) for _ in range(2)]
        runs = [raised(asperity, tmp_path, surfaces, (z, z), "limit", 1.0)
                for z in (0.0, -0.1, -0.05, 0.02, 0.6, -1.0)]
        assert runs[0][0] >= 1
        for run in runs:
            check_same(run, runs[0])


def test_effects(asperity, tmp_path):
    """Effects take their pairs from the same search."""
    spheres = [(0.0, 0.0, 0.1, 1.0)], [(0.9, 0.0, 0.1, 1.0), (0.9, 3.0, 0.1, 1.0)]
    effects = {"interaction": "coupled"}
    runs = [raised(asperity, tmp_path, spheres, (z, z), control, value, effects=effects)
            for control, value in (("limit", 10.0), ("load", 10.0)) for z in (0.0, -0.1, 0.3, 0.9)]
    for k, run in enumerate(runs):
        check_same(run, runs[k // 4 * 4])
