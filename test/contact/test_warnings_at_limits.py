"""Kinds of warnings that one number decides, each just below its limit and just beyond it, and the
results that have no meaning and end with status 1. A further kind is a row of `AT_LIMITS`.

All limits come from closed forms of Hertz' theory and of the published fits.
"""

import itertools
import math
import re
from functools import partial

import numpy as np
import pytest

from ball_scenes import balls
from effect_runs import CAP, COMBINED
from judge import NO_NUMBER
from map_press_truth import rough
from plastic_truth import Sphere
from surfaces_csv import solve, write_csv_scene, write_plane_scene
from map_scenes import E, load_for, map_scene
from test_warnings import INSIDE, OUTSIDE, RADIUS, check_pair, overlap_of, pressed, shown

# Sy/E' far inside the fit.
SOFT = Sphere("1", "0", "0.002", "1")


def hertz(overlap, radius=RADIUS / 2):
    """Load and average pressure."""
    return (4 / 3 * COMBINED * math.sqrt(radius) * overlap**1.5,
            4 * COMBINED * math.sqrt(overlap / radius) / (3 * math.pi))


def beyond_limit(criterion, asperity, folder, factor):
    overlap = overlap_of(0.01)
    value = dict(zip(("load", "pressure"), hertz(overlap)))[criterion] / factor
    return pressed(asperity, folder, overlap, limit={"criterion": criterion, "value": value})


def tilted_plane(asperity, folder, factor):
    return solve(asperity, write_plane_scene(
        folder, [(0, 0, 0.5, 2)], tilt={"upper_slope": (0.18 * factor, 0.24 * factor)},
        loading={"control": "approach", "value": 0.49}))


def far_adhesion(asperity, folder, factor):
    folder.mkdir()
    return solve(asperity, balls(
        folder, "far", {"adhesion": "on", "work_of_adhesion": 1.0,
                        "equilibrium_distance": 0.045 * RADIUS * 2 * factor},
        {"control": "approach", "value": -1e-3}, radii=(RADIUS,), modulus=1000.0))


def relaxing_pair(asperity, folder, ratio):
    """Two balls whose moduli have this ratio."""
    folder.mkdir()
    return solve(asperity, write_csv_scene(
        folder, [(0.0, 0.0, 1.9, RADIUS)], [(0.0, 0.0, 1.9, RADIUS)],
        modulus=(1000.0, 1000.0 / ratio), ratio=(0.3, 0.3),
        loading={"control": "approach", "value": 3.8 - 1e-4},
        effects={"creep": "on", "hold_time": 30.0, "relaxation_time": 1.0,
                 "relaxed_modulus_ratio": 0.5}))


def unlike_bodies(asperity, folder, factor):
    """k(1 - k)/(1 + k) of the compliance, k the ratio of the two: equal Poisson's ratios."""
    share = 0.01 * factor
    ratio = ((1 - share) - math.sqrt((1 - share) ** 2 - 4 * share)) / 2
    return relaxing_pair(asperity, folder, ratio)


def yield_strain(asperity, folder, factor):
    sphere = Sphere("1", "0", repr(0.0073 * factor), "1")
    folder.mkdir()
    return solve(asperity, balls(
        folder, "strain", {"plasticity": "on", "plastic_yield_stress": 0.0073 * factor},
        {"control": "approach", "value": -2 * float(sphere.critical_overlap)}))


def flow_depth(asperity, folder, factor, largest=110, unloaded=None):
    overlap = largest * float(SOFT.critical_overlap) * factor
    value = -overlap if unloaded is None else (-overlap, -overlap * unloaded)
    folder.mkdir()
    return solve(asperity, balls(
        folder, "depth", {"plasticity": "on", "plastic_yield_stress": 0.002},
        {"control": "approach", "value": value}))


def unloading_depth(asperity, folder, factor):
    return flow_depth(asperity, folder, factor, 170, 0.9)


# What the line states, the scene at a factor of its limit, the size printed at the limit.
AT_LIMITS = {
    "limit by load": ("exceeds the limit of the scene", partial(beyond_limit, "load"), 1.0),
    "limit by pressure": ("exceeds the limit of the scene", partial(beyond_limit, "pressure"), 1.0),
    "tilt": ("reference plane is steep", tilted_plane, 0.3),
    "adhesion range": ("adhesion acts farther", far_adhesion, 4.5),
    "unlike bodies": ("they are unlike", unlike_bodies, 1.0),
    "yield strain": ("the yield strain is beyond the fit", yield_strain, 0.73),
    "flow depth": ("flows beyond the fit", flow_depth, 110.0),
    "unloading depth": ("unloaded from beyond the fit", unloading_depth, 170.0),
}


@pytest.mark.parametrize("row", AT_LIMITS)
def test_at_its_limit(row, asperity, tmp_path):
    what, scene, size = AT_LIMITS[row]
    runs = [scene(asperity, tmp_path / f"{factor}", factor) for factor in (INSIDE, OUTSIDE)]
    check_pair(*runs, what, size)


def test_limit_with_plasticity(asperity, tmp_path):
    """Nothing exceeds a limit that plasticity respects, nor under control of the limit."""
    overlap = overlap_of(0.01)
    limit = {"criterion": "load", "value": hertz(overlap)[0] / 2}
    run = pressed(asperity, tmp_path / "on", overlap, limit=limit, plasticity="on")
    assert shown(run, "exceeds the limit") == ""
    scene = (tmp_path / "on" / "pair.scene")
    scene.write_text(re.sub(r"&loading.*", "&loading control = 'limit' /", scene.read_text())
                     .replace("plasticity = 'on'", "plasticity = 'off'"))
    assert shown(solve(asperity, scene), "exceeds the limit") == ""


def test_like_and_rigid_bodies(asperity, tmp_path):
    """Equal bodies are like; a rigid one has nothing to relax."""
    for ratio in (1.0, 1e-9):
        run = relaxing_pair(asperity, tmp_path / f"{ratio}", ratio)
        assert shown(run, "they are unlike") == ""


# Height maps.

N = 24
SIDES = (0.02, 0.03)


def on_map(asperity, folder, height, load, interaction="boundary", edge="free", limit=None,
           **material):
    folder.mkdir(exist_ok=True)
    scene = map_scene(folder, height, SIDES, interaction=interaction, surfaces={"map_edge": edge},
                      loading={"control": "load", "value": load},
                      **({"limit": limit} if limit else {}))
    return solve(asperity, scene)


def has(run, what):
    assert run.status == 0, run.stderr
    return any(": warning: " in line and what in line for line in run.stderr.splitlines())


def test_many_missing_pixels_are_warned_of(asperity, tmp_path):
    """The tolerance of 1 %: 5 of 576 pixels are 0.87 %, 6 are 1.04 %."""
    height = 1e-3 * rough(N, shortest=4, seed=3)
    load = load_for(height, SIDES, 0.02)
    lowest = np.argsort(height, axis=None)
    for number, expected in ((5, False), (6, True)):
        holes = height.copy()
        holes.ravel()[lowest[:number]] = np.nan
        run = on_map(asperity, tmp_path / f"{number}", holes, load)
        assert has(run, "missing pixels") == expected


def border_ratio(height):
    """Second differences across the border, root mean square, over those of the roughest line."""
    found = []
    for h in (height, height.T):
        bend = np.sqrt(((np.roll(h, 1, 0) - 2 * h + np.roll(h, -1, 0)) ** 2).mean(axis=1))
        found.append(max(bend[0], bend[-1]) / bend[1:-1].max())
    return max(found)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("kind", ["jump", "bend"])
def test_map_that_is_not_periodic(kind, axis, asperity, tmp_path):
    """A periodic map and more and more of what is not: a jump, or the bend of a parabola."""
    i = np.indices((N, N))[axis] / (N - 1)
    added = 1e-3 * (i**2 if kind == "bend" else i**3 - i)
    if kind == "jump":
        added = 1e-3 * np.sign(i - 0.5) * (np.abs(i - 0.5) > 0.49)
    start = 1e-3 * rough(N, shortest=4, seed=5)

    def ratio(share):
        return border_ratio(start + share * added)

    low, high = 0.0, 1000.0
    assert ratio(low) < 1.5 and ratio(high) > 2
    while high > (1 + 1e-4) * low + 1e-9:
        middle = (low + high) / 2
        low, high = (low, middle) if ratio(middle) > 2 else (middle, high)
    for share, expected in ((low, False), (1.01 * high, True)):
        height = start + share * added
        run = on_map(asperity, tmp_path / f"{expected}", height, load_for(start, SIDES, 0.02),
                     edge="periodic")
        assert has(run, "the map is not periodic") == expected, (share, ratio(share))
        free = on_map(asperity, tmp_path / f"{expected}", height, load_for(start, SIDES, 0.02))
        assert not has(free, "the map is not periodic")


@pytest.mark.parametrize("axis", [0, 1])
def test_ridge_along_the_border(axis, asperity, tmp_path):
    """The sharpest that a periodic map can hold has exactly the ratio 2, wherever it is cut."""
    height = np.zeros((N, N))
    height[0] = 1e-3
    height = np.swapaxes(height, 0, axis)
    run = on_map(asperity, tmp_path, height, load_for(height, SIDES, 0.02), edge="periodic")
    assert not has(run, "the map is not periodic")


@pytest.mark.long
def test_area_at_the_limit_of_resolution(asperity, tmp_path):
    """A Hertzian contact anywhere on the grid: its area is in error by less than 10 % without the
    warning; all larger errors have it."""
    generator = np.random.default_rng(3)
    errors = {True: [], False: []}
    x = (np.arange(N) - N / 2) * SIDES[0]
    for k, pixels in enumerate(np.geomspace(0.7, 12, 40)):
        place = generator.uniform(-0.5, 0.5, 2) * SIDES[0]
        radius = float(pixels) * SIDES[0]
        height = -((x[:, None] - place[0]) ** 2 + (x - place[1]) ** 2) / 2
        scene = map_scene(tmp_path, height, (SIDES[0], SIDES[0]), interaction="boundary",
                          surfaces={"map_level": "none"},
                          loading={"control": "load", "value": 4 / 3 * E * radius**3})
        run = solve(asperity, scene)
        area = sum(float(row["area"]) for row in run.contacts)
        errors[has(run, "not resolved by the pixels")].append(area / (math.pi * radius**2) - 1)
    assert min(map(len, errors.values())) > 8
    assert np.abs(errors[False]).max() < 0.1 < np.abs(errors[True]).max()


@pytest.mark.parametrize("name, what", [("hardness", "beyond yield"), ("pressure", "the limit"),
                                        ("load", "the limit")])
def test_pixels_beyond_yield(name, what, asperity, tmp_path):
    """The patch with the largest pressure, or load, at a limit a little higher or lower."""
    height = 1e-3 * rough(N, shortest=4, seed=3)
    load = load_for(height, SIDES, 0.1)
    run = on_map(asperity, tmp_path / "plain", height, load)
    values = [float(row["load" if name == "load" else "average_pressure"]) for row in run.contacts]
    if name == "hardness":
        # A Hertzian contact of this greatest pressure has two thirds of it on average.
        values += [float(row["maximum_pressure"]) / 1.5 for row in run.contacts]
    for factor, expected in ((INSIDE, False), (OUTSIDE, True)):
        limit = {"criterion": name, "value": max(values) / factor}
        if name == "hardness":
            limit = {"criterion": "greenwood_williamson", "hardness": max(values) / factor}
        found = on_map(asperity, tmp_path / f"{factor}", height, load, limit=limit)
        line = shown(found, what)
        assert bool(line) == expected, found.stderr
        assert "plasticity = 'auto'" not in line


# Contacts as circles that have no part of each other's pressure.

def nested(asperity, folder, ratio, gap, interaction="coupled", **effects):
    """A blunt cap that the plane presses by 1e-4, a sharper one in its circle of about 0.01."""
    return solve(asperity, write_plane_scene(
        folder, [(0, 0, 0, 1), (0.004, 0.002, -gap, 1 / ratio)],
        loading={"control": "approach", "value": -1e-4},
        effects={"interaction": interaction, **effects}))


def share_of_sharp(run):
    loads = {row["lower"]: float(row["load"]) for row in run.contacts}
    return loads.get("2", 0.0) / sum(loads.values())


NESTED = "overlaps the circle of one 3 times blunter"


@pytest.mark.parametrize("ratio, expected", [(2.997, False), (3.003, True), (300.0, True)])
def test_nested_ratio(ratio, expected, asperity, tmp_path):
    run = nested(asperity, tmp_path, ratio, -8e-5)
    assert 0.021 < share_of_sharp(run) < 0.98
    assert bool(shown(run, NESTED)) == expected
    for interaction in ("auto", "boundary", "off"):
        assert shown(nested(asperity, tmp_path, ratio, -8e-5, interaction), NESTED) == ""


def test_nested_load(asperity, tmp_path):
    """2 % of the load."""
    low, high = -2e-5, 1e-4
    runs = {}
    while high - low > 1e-8:
        gap = (low + high) / 2
        run = nested(asperity, tmp_path, 50.0, gap)
        more = share_of_sharp(run) > 0.02
        runs[more] = run
        low, high = (gap, high) if more else (low, gap)
    assert share_of_sharp(runs[True]) < 0.0202 and share_of_sharp(runs[False]) > 0.0198
    check_pair(runs[False], runs[True], NESTED, 2.0)


# The compression of the contact patches of a plane under load, from boundary elements (numpy, two
# grids).
SPOTS = ((0.0, 0.0, 1.0, 4974.1524222838307),
         (-3.1765315724570424, -1.2319723428603127, 1.0103457590008218, 99.776495596014897))


def test_error_of_nested_contacts(asperity, tmp_path):
    """Circles miss the compression by 3.7 %: their estimate holds it, and 'auto' resolves them."""
    run = {interaction: solve(asperity, write_plane_scene(
        tmp_path, SPOTS, modulus=1e3, loading={"control": "load", "value": 101.49736966383077},
        effects={"interaction": interaction})) for interaction in ("coupled", "auto", "boundary")}
    closing = {name: SPOTS[1][2] - float(found.positions[0]["separation"])
               for name, found in run.items()}
    error = abs(closing["coupled"] / closing["boundary"] - 1)
    assert 0.01 < error <= float(run["coupled"].positions[0]["error_estimate"])
    assert shown(run["coupled"], NESTED) and not shown(run["auto"], NESTED)
    assert abs(closing["auto"] / closing["boundary"] - 1) < 0.01


# Results without a meaning.

@pytest.mark.parametrize("interaction", ["off", "auto", "coupled", "boundary"])
@pytest.mark.parametrize("nominal, load, count", [(0.25, 1700.0, 5), (1e-6, 30.0, 1)])
def test_area_above_the_nominal_area(nominal, load, count, interaction, asperity, tmp_path):
    """No file and one sentence."""
    run = solve(asperity, write_plane_scene(
        tmp_path, [(0.1 * i, 0.1 * j, 0.5, 2) for i, j in np.ndindex(count, count)],
        {"nominal_area": nominal}, 1e3, loading={"control": "load", "value": load},
        effects={"interaction": interaction}))
    assert run.status == 1 and not run.positions
    lines = run.stderr.splitlines()
    assert len(lines) == 1 and (interaction != "off" or "times the nominal area" in lines[0]), lines


def test_area_at_the_nominal_area(asperity, tmp_path):
    """One contact on its own area, a hair more and less; on the least one its ratio is a number."""
    area = math.pi * CAP * 0.01
    for nominal, status in ((area / INSIDE, 0), (area / OUTSIDE, 1), (1e-312, 1)):
        run = solve(asperity, write_plane_scene(
            tmp_path, [(0, 0, 0.5, CAP)], {"nominal_area": nominal}, 1e3,
            loading={"control": "approach", "value": 0.49}))
        assert run.status == status and not NO_NUMBER.search(run.stderr), run.stderr


def test_area_above_that_of_a_map(asperity, tmp_path):
    height = 1e-3 * rough(N, shortest=4, seed=3)
    scene = map_scene(tmp_path, height, SIDES, surfaces={"nominal_area": 1e-6},
                      loading={"control": "load", "value": load_for(height, SIDES, 0.05)})
    run = solve(asperity, scene)
    assert run.status == 1 and "times the nominal area" in run.stderr


@pytest.mark.parametrize("effects", [{}, {"interaction": "coupled"},
                                     {"plasticity": "on", "plastic_yield_stress": 1e9}])
def test_plane_at_the_bottom_of_a_sphere(effects, asperity, tmp_path):
    """The overlap is twice the radius there."""
    for factor, status in ((INSIDE, 0), (OUTSIDE, 1)):
        run = solve(asperity, write_plane_scene(
            tmp_path, [(0, 0, 0.5, 1)], effects=effects,
            loading={"control": "approach", "value": 0.5 - 2 * factor}))
        assert run.status == status, run.stderr
        assert status == 0 or "beyond the sphere" in run.stderr


# Advice can be followed.

MODES = {"interaction": ("off", "auto", "coupled", "boundary"),
         "friction": ("off", "on", "auto"), "plasticity": ("off", "on", "auto"),
         "adhesion": ("off", "on", "auto"), "creep": ("off", "on", "auto")}
NUMBERS = {"friction_coefficient": 0.2, "plastic_yield_stress": 5.0, "work_of_adhesion": 0.1,
           "equilibrium_distance": 0.01, "hold": "approach", "hold_time": 1.0,
           "relaxation_time": 1.0, "relaxed_modulus_ratio": 0.9}


def dense(asperity, folder, effects, modulus):
    return solve(asperity, write_plane_scene(
        folder, [(0, 0, 0.5, 2), (0.5, 0, 0.5, 2), (0.25, 0.4330127018922193, 0.5, 2)],
        modulus=modulus, limit={"criterion": "load", "value": 1.0},
        loading={"control": "load", "value": 40.0}, effects={**NUMBERS, **effects}))


def check_advice(asperity, folder, effects, modulus, run):
    """Every effect that a warning proposes is computed when it is set."""
    proposed = set(re.findall(r"set (\w+) = '(\w+)'", run.stderr)) - {("control", "vertical_load")}
    for name, mode in proposed:
        again = dense(asperity, folder, {**effects, name: mode}, modulus)
        assert again.status == 0, (effects, name, mode, again.stderr)
        assert f"({name} beside" not in again.stderr or "auto" in effects.values(), (effects, name)
    return len(proposed)


@pytest.mark.long
def test_advice_of_every_combination(asperity, tmp_path):
    """All combinations of effects that are not refused, each at dense contacts beyond the limit."""
    bodies = (2e3, 2e3)
    solved = followed = 0
    for modes in itertools.product(*MODES.values()):
        effects = dict(zip(MODES, modes))
        run = dense(asperity, tmp_path, effects, bodies)
        if run.status != 0:
            continue
        solved += 1
        followed += check_advice(asperity, tmp_path, effects, bodies, run)
    assert solved > 100 and followed > 20


def test_advice_beside_a_combined_modulus(asperity, tmp_path):
    """Plasticity needs Poisson's ratios, which a combined modulus hides."""
    effects = {"interaction": "off", "adhesion": "off"}
    run = dense(asperity, tmp_path, effects, 1e3)
    assert shown(run, "exceeds the limit of the scene").endswith(", reduce the load")
    assert check_advice(asperity, tmp_path, effects, 1e3, run) == 1


def test_adhesion_beside_dense_contacts(asperity, tmp_path):
    run = dense(asperity, tmp_path, {"adhesion": "on"}, 1e3)
    assert shown(run, "contact circles overlap")
    assert shown(run, "interaction is off and has no common theory")
    assert "interaction = 'auto'" not in run.stderr
