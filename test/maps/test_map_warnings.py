"""Warnings of a map's load: each provoked just beyond its limit and absent just inside. The shares
are found here, by a solution of its own in numpy."""

import math
import re

import numpy as np
import pytest

from map_press_truth import press, rough
from surfaces_csv import solve
from map_scenes import E, level, load_for, map_scene

SIDES = (0.02, 0.02)
N = 48
# Little enough that nothing but what a test puts there touches.
LOAD = 5e-5


def floor():
    """A bowl: the middle, and the edge, carry nothing."""
    x, y = np.indices((N, N)) - 23.3
    return -1e-2 * (1 - 1e-4 * (x**2 + y**2)) + 1e-5 * rough(N, shortest=6, seed=3)


def cap(height, x, y, top):
    """A round hill of radius 5 pixels."""
    i, j = np.indices(height.shape)
    bump = top - 2e-4 * ((i - x) ** 2 + (j - y) ** 2)
    height[:] = np.maximum(height, bump)


def run(asperity, folder, height, load, tolerance, **surfaces):
    folder.mkdir(exist_ok=True)
    scene = map_scene(folder, height, SIDES, surfaces=surfaces,
                      loading={"control": "load", "value": load}, effects={"tolerance": tolerance})
    done = solve(asperity, scene)
    assert done.status == 0, done.stderr
    lines = [line for line in done.stderr.splitlines() if ": warning: " in line]
    assert int(done.positions[0]["warnings"]) == len(lines)
    return lines


def shares(height, load):
    """Of the load, on every pixel."""
    _, pressure = press(level(height), SIDES, E, load)
    return pressure / pressure.sum()


def shown(lines, what):
    found = [line for line in lines if what in line]
    assert len(found) <= 1
    return float(re.search(r", (\S+) % of", found[0])[1]) / 100 if found else None


def check_at_tolerance(asperity, folder, height, share, what):
    share = float(share)
    assert 0.02 < share < 0.98
    inside = run(asperity, folder, height, LOAD, 1.001 * share)
    outside = run(asperity, folder, height, LOAD, 0.999 * share)
    assert shown(inside, what) is None
    assert shown(outside, what) == pytest.approx(share, abs=6e-4 * max(1, 10 * share))


@pytest.mark.parametrize("beyond", [False, True])
def test_edge(asperity, tmp_path, beyond):
    """A hill cut by the edge beside one that is not, against a round flat punch as wide."""
    limit = math.sqrt(1 - (1 - 4 / N) ** 2)

    def with_hills(top):
        height = floor()
        cap(height, 23, 24, 1e-3)
        cap(height, 0.3, 24, top)
        return height

    def on_edge(top):
        share = shares(with_hills(top), 4 * LOAD)
        return 1 - share[2:-2, 2:-2].sum()

    low, high = 0.0, 2e-3
    for _ in range(14):
        middle = (low + high) / 2
        low, high = (low, middle) if on_edge(middle) > limit else (middle, high)
    share = on_edge(high if beyond else low)
    assert abs(share / limit - 1) < 0.02 and (share > limit) == beyond
    lines = run(asperity, tmp_path, with_hills(high if beyond else low), 4 * LOAD, 0.5)
    found = shown(lines, "the edge cuts")
    assert found == (pytest.approx(share, abs=6e-4) if beyond else None)
    # One that repeats itself has no edge.
    assert shown(run(asperity, tmp_path, with_hills(high), 4 * LOAD, 0.5, map_edge="periodic"),
                "the edge cuts") is None


def test_a_load_on_scan_lines_is_warned_of(asperity, tmp_path):
    height = floor()
    cap(height, 14, 24, 1.4e-3)
    height[25:36, 30] = 1e-3
    pressed = shares(height, LOAD)
    assert (pressed[25:36, 30] > 0).all() and not pressed[25:36, [29, 31]].any()
    check_at_tolerance(asperity, tmp_path, height, pressed[25:36, 30].sum(), "scan lines")
    # Seven pixels are no line.
    height[25:29, 30] = floor()[25:29, 30]
    assert shown(run(asperity, tmp_path, height, LOAD, 1e-3), "scan lines") is None


def test_a_load_on_spikes_is_warned_of(asperity, tmp_path):
    height = floor()
    cap(height, 14, 24, 1e-3)
    height[30, 30] = 1e-3
    pressed = shares(height, LOAD)
    check_at_tolerance(asperity, tmp_path, height, pressed[30, 30], "outliers")
    # They are taken out where that is asked for.
    assert shown(run(asperity, tmp_path, height, LOAD, 1e-3, map_despike="on"), "outliers") is None


def test_effects_left_out_beside_pixels(asperity, tmp_path):
    """Adhesion that the pixels do not resolve has no estimate, nor the results an error, also where
    it is off; of a range that they resolve it is simulated."""
    numbers = {"work_of_adhesion": 1e-7 * E, "equilibrium_distance": 1e-5}
    height = 1e-3 * rough(32, shortest=4, seed=5)
    found = []
    for word in ({}, {"adhesion": "auto"}, {"adhesion": "off"}, {"equilibrium_distance": 1e-4},
                 {"adhesion": "on"}):
        scene = map_scene(tmp_path, height, SIDES, interaction="auto", effects={**numbers, **word},
                          loading={"control": "load", "value": load_for(height, SIDES, 0.1)})
        done = solve(asperity, scene)
        found.append((done.positions and done.positions[0], done.stderr))
    for row, lines in found[:3]:
        assert row["interaction"] == "boundary" and row.get("adhesion_estimate", "") == ""
        assert row["error_estimate"] == "" and "adhesion is left out and has no estimate" in lines
    row, lines = found[3]
    assert (row["adhesion"], row["interaction"]) == ("on", "boundary")
    assert "adhesion" not in lines
    assert row["adhesion_estimate"] == "" or float(row["adhesion_estimate"]) > 0.01
    assert "the pixels are too wide for the range of adhesion" in found[4][1]


def test_a_steep_map(asperity, tmp_path):
    """The rms slope by neighbouring pixels, of the levelled map."""
    step = SIDES[0]
    height = level(rough(N, shortest=6, seed=3))
    slope = math.hypot(*((np.diff(height, axis=k) ** 2).mean() ** .5 / step for k in (0, 1)))
    for factor in (0.999, 1.001, 5.0):
        lines = run(asperity, tmp_path, height * (0.3 * factor / slope), 1e-3 * LOAD, 0.99)
        found = [line for line in lines if "the map is steep" in line]
        assert len(found) == (factor > 1)
    assert "1.50 is its rms slope (limit 0.3), check the unit of its heights" in found[0]


def test_pressures_near_the_modulus(asperity, tmp_path):
    """Hertz: the greatest pressure is 2 a/(pi R) of the modulus, 0.191 where a = 0.3 R."""
    step = SIDES[0]
    radius = 40 * step
    x, y = (np.indices((N, N)) - (N - 1) / 2) * step
    height = -(x**2 + y**2) / (2 * radius)
    for factor in (0.98, 1.02):
        load = math.pi**3 * radius**2 * E / 6 * (0.19 * factor) ** 3
        lines = run(asperity, tmp_path, height, load, 0.99)
        found = [line for line in lines if "pressures are near the contact modulus" in line]
        assert len(found) == (factor > 1)
    assert shown(lines, "near the contact modulus") == pytest.approx(0.19 * 1.02, rel=0.01)
