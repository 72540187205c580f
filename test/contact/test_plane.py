"""A plane as one of the surfaces: caps on it by closed form."""

import math
import re

import numpy as np
import pytest
from mpmath import mp, mpf

from surfaces_csv import solve, write_scene, write_surface

E = 2.0e4
SIDES = ("upper", "lower")


def other(side):
    return "lower" if side == "upper" else "upper"


def plane_scene(folder, caps, side="lower", name="plane", **groups):
    """Caps (x, y, height, radius) on a plane, which is the surface `side`."""
    surfaces = {side: "plane", other(side): write_surface(folder / "caps.csv", caps)}
    return write_scene(folder / f"{name}.scene", surfaces=surfaces,
                       material={"contact_modulus": E}, **groups)


def random_caps(number, seed, side=4.0):
    rng = np.random.default_rng(seed)
    return [(float(x), float(y), float(h), float(r)) for x, y, h, r in
            np.column_stack([rng.random((number, 2)) * side - side / 2,
                             0.1 - 0.01 * np.abs(rng.standard_normal(number)),
                             rng.uniform(0.5, 2, number)])]


def by_hand(levels, radii, approach):
    """Loads and areas of caps at an approach, with many digits: Hertz 1882."""
    overlaps = [max(mpf(h) - approach, 0) for h in levels]
    return ([4 * mpf(E) / 3 * mp.sqrt(mpf(r)) * w ** mpf(1.5) for r, w in zip(radii, overlaps)],
            [mp.pi * mpf(r) * w for r, w in zip(radii, overlaps)])


def approach_at(levels, radii, load):
    """Where caps carry a load together: by halving in doubles, then by Newton with many digits."""
    heights, roots = np.array(levels), 4 / 3 * E * np.sqrt(radii)
    low, high = heights.max() - 1000, heights.max()
    for _ in range(100):
        middle = (low + high) / 2
        bears = (roots * np.maximum(heights - middle, 0) ** 1.5).sum()
        low, high = (low, middle) if bears < load else (middle, high)
    approach = mpf(low)
    for _ in range(4):
        loads, _ = by_hand(levels, radii, approach)
        slope = sum(1.5 * p / (mpf(h) - approach) for p, h in zip(loads, levels) if p)
        approach += (sum(loads) - load) / slope
    return approach


def off(found, true):
    return abs(float((mpf(found) - true) / true))


@pytest.mark.parametrize("side", SIDES)
def test_ball_on_flat(asperity, tmp_path, side):
    """Hertz: load 4/3 E sqrt(R) w^1.5, area pi R w; all numbers have few binary digits."""
    with mp.workdps(40):
        for radius, closing in ((1.0, 0.0625), (2.0, 2.0 ** -18), (0.75, 1.25)):
            scene = plane_scene(tmp_path, [(1.0, 2.0, 0.5, radius)], side,
                                loading={"control": "approach", "value": 0.5 - closing})
            # A double has no more of the decimal in the scene.
            wide = mpf(0.5) - mpf(0.5 - closing)
            run = solve(asperity, scene)
            assert run.status == 0, run.stderr
            row = run.contacts[0]
            loads, areas = by_hand([0.5], [radius], 0.5 - wide)
            peak = 2 * mpf(E) / mp.pi * mp.sqrt(wide / radius)
            errors = [off(row["load"], loads[0]), off(row["vertical_load"], loads[0]),
                      off(row["area"], areas[0]), off(row["projected_area"], areas[0]),
                      off(row["maximum_pressure"], peak)]
            assert max(errors) <= 1e-15, errors
            assert float(row["overlap"]) == float(row["penetration"]) == float(wide)
            assert row["load"] == row["vertical_load"]
            assert float(row["slope"]) == 0
            assert (float(row["x"]), float(row["y"])) == (1, 2)
            assert (int(row[side]), int(row[other(side)])) == (0, 1)


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("number", [1, 40, pytest.param(1200, marks=pytest.mark.truth)])
def test_caps_on_a_plane_are_those_of_hertz(asperity, tmp_path, side, number):
    """Load, approach and limit against the equations; 1200 caps are searched part by part."""
    caps = random_caps(number, seed=number)
    heights, radii = [c[2] for c in caps], [c[3] for c in caps]
    with mp.workdps(30):
        for load in (1e-3, 3.0, 5e3):
            scene = plane_scene(tmp_path, caps, side, loading={"control": "load", "value": load})
            row = solve(asperity, scene, contacts=False).positions[0]
            approach = approach_at(heights, radii, load)
            _, areas = by_hand(heights, radii, approach)
            assert off(row["load"], mpf(load)) < 1e-14
            assert abs(float(row["separation"]) - approach) < 1e-16
            # An area forgets a rounding of the approach over the compression.
            assert off(row["area"], sum(areas)) < 1e-15 * (1 + 0.1 / (max(heights) - approach))
            assert int(row["contacts"]) == sum(h >= approach for h in heights)

        scene = plane_scene(tmp_path, caps, side, loading={"control": "approach", "value": 0.085})
        row = solve(asperity, scene, contacts=False).positions[0]
        loads, _ = by_hand(heights, radii, mpf(0.085))
        assert off(row["load"], sum(loads)) < 2e-14
        assert int(row["contacts"]) == sum(h >= 0.085 for h in heights)

        limit = 20.0
        scene = plane_scene(tmp_path, caps, side, limit={"criterion": "load", "value": limit})
        row = solve(asperity, scene, contacts=False).positions[0]
        # The first at its limit: w/R = (3 P/(4 E R^2))^(2/3).
        ends = [mpf(h) - mpf(r) * (3 * limit / (4 * mpf(E) * mpf(r) ** 2)) ** (mpf(2) / 3)
                for h, r in zip(heights, radii)]
        assert abs(float(row["separation"]) - max(ends)) < 2e-17
        assert row["limit_reached"] == "1"


@pytest.mark.parametrize("side", SIDES)
def test_tilt_and_motion(asperity, tmp_path, side):
    """Slopes of both surfaces and the displacement raise a cap over the plane; nothing else does.

    With h the height and (x, y) the place of a cap, the slopes u (upper) and l (lower), and the
    displacement (X, Y): caps above, h - u.(x, y) + l.(x + X, y + Y); caps below, h + l.(x, y)
    - u.(x - X, y - Y).
    """
    caps = random_caps(30, seed=7)
    upper, lower, rotation = (0.011, -0.004), (0.003, 0.008), 0.4
    motion = {"x_first": -1.0, "x_step": 0.75, "y_first": 0.25, "y_step": -0.5, "positions": 4}
    tilt = {"upper_slope": upper, "lower_slope": lower, "rotation": (rotation, rotation)}
    scene = plane_scene(tmp_path, caps, side, tilt=tilt, motion=motion,
                        loading={"control": "approach", "value": 0.06})
    run = solve(asperity, scene)
    cos, sin = math.cos(rotation), math.sin(rotation)
    for m, row in enumerate(run.positions):
        shift = np.array([-1.0 + 0.75 * m, 0.25 - 0.5 * m])
        load = 0.0
        for x, y, height, radius in caps:
            place = np.array([x * cos - y * sin, x * sin + y * cos])
            level = (height - place @ upper + (place + shift) @ lower if side == "lower" else
                     height + place @ lower - (place - shift) @ upper)
            load += 4 / 3 * E * math.sqrt(radius) * max(level - 0.06, 0.0) ** 1.5
        assert abs(float(row["load"]) / load - 1) < 1e-13
    assert len({row["load"] for row in run.positions}) == 4


def test_radius_and_refusals(asperity, tmp_path):
    """One plane at most; beside it one radius serves."""
    (tmp_path / "bare.csv").write_text("x,y,height\n0,0,0\n")
    for radius in ("1.5", "1.5, 2.5"):
        path = tmp_path / "one.scene"
        path.write_text(f"&surfaces upper = 'bare.csv', lower = 'plane', radius = {radius} /\n"
                        "&material contact_modulus = 1. /\n"
                        "&loading control = 'approach', value = -0.01 /\n")
        row = solve(asperity, path).contacts[0]
        assert abs(float(row["area"]) / (math.pi * 1.5 * 0.01) - 1) < 1e-15
    for surfaces, expected in (
            ("upper = 'plane', lower = 'plane'", ":1:28: lower: found two planes"),
            ("upper = 'plane', lower = 'bare.csv'", "no radius column in the lower surface's file"),
            ("deck = 'x.deck', lower = 'plane'", "found beside deck")):
        path = tmp_path / "bad.scene"
        path.write_text(f"&surfaces {surfaces} / &material contact_modulus = 1. /\n"
                        "&loading control = 'load', value = 1. /\n")
        run = solve(asperity, path)
        assert run.status == 2
        assert expected in run.stderr


def test_a_nominal_area_gives_pressure_and_area_fraction(asperity, tmp_path):
    """Vertical load and projected area over the nominal area, in every file that has totals."""
    scene = plane_scene(tmp_path, random_caps(9, seed=4),
                        loading={"control": "load", "value": 5.0, "points": 3})
    text = scene.read_text()
    assert "nominal pressure" not in solve(asperity, scene, curve=True).stdout
    scene.write_text(text.replace("&surfaces ", "&surfaces nominal_area = 16., "))
    run = solve(asperity, scene, curve=True)
    assert re.search(r"^nominal pressure +0\.3125$", run.stdout, re.M)
    assert len(run.curve) > 3
    for row in run.positions + run.curve:
        assert float(row["nominal_pressure"]) == float(row["vertical_load"]) / 16
        assert float(row["area_fraction"]) == float(row["projected_area"]) / 16
