"""Form and edges of maps on their pixels (`form_radius`, `map_edge` of each axis), against closed
forms of Hertz and other arrangements of the same bodies."""

import math

import numpy as np
import pytest
from elements_truth import love
from image_data import read_vti
from programs import run_program
from surfaces_csv import solve
from map_scenes import E, map_scene

N = 65


def rd(y, z):
    """Carlson's RD(0, y, z), 3/2 of the integral of 1/((t + z) sqrt(t (t + y) (t + z))), with
    t = tan**2."""
    angle = (np.arange(4000) + 0.5) * math.pi / 2 / 4000
    t = np.tan(angle) ** 2
    return 3 * math.pi / 8000 * float(np.sum((1 + t) / ((t + z) * np.sqrt((t + y) * (t + z)))))


def ellipse(ratio, long_axis, load):
    """Radii along the long and the short axis of the contact that has these axes (Johnson 1985,
    section 4.2), and its greatest pressure."""
    pressure = 1.5 * load / (math.pi * ratio * long_axis**2)
    least = pressure * ratio / (3 * long_axis * E)
    return 0.5 / (least * rd(ratio**2, 1)), 0.5 / (least * rd(1, ratio**2)), pressure


def of_form(asperity, folder, radius, sides, load, height=None, edge="free", **surfaces):
    """The one position and the greatest pressure of a map with a form."""
    height = np.zeros((N, N)) if height is None else height
    scene = map_scene(folder, height, sides, surfaces={"form_radius": radius, "map_edge": edge,
                                                       **surfaces},
                      loading={"control": "load", "value": load})
    found = solve(asperity, scene)
    assert found.status == 0, found.stderr
    return found, max(float(contact["maximum_pressure"]) for contact in found.contacts)


@pytest.mark.parametrize("ratio, turned", [(1, False), (1 / 3, False), (1 / 3, True)])
def test_hertz_of_ball_and_ellipsoid(asperity, tmp_path, ratio, turned):
    load, axes = 0.2, (0.4, 0.4 * ratio)
    *radii, exact = ellipse(ratio, axes[0], load)
    order = slice(None, None, -1 if turned else 1)
    # 24 pixels along each semi-axis.
    sides = tuple(axis / 24 for axis in axes[order])
    found, largest = of_form(asperity, tmp_path, tuple(radii[order]), sides, load)
    row = found.positions[0]
    errors = [largest / exact - 1, float(row["hertz_pressure"]) / exact - 1,
              float(row["hertz_area"]) / (math.pi * axes[0] * axes[1]) - 1]
    assert abs(errors[0]) < 1e-3 and max(map(abs, errors[1:])) < 1e-9, errors
    assert float(row["area"]) == pytest.approx(float(row["hertz_area"]), rel=0.02)


@pytest.mark.parametrize("axis", [0, 1])
def test_cylinder_on_a_strip(asperity, tmp_path, axis):
    """Line contact (Johnson 1985, eq. 4.43 to 4.46): 24 pixels in half its width."""
    radius, half, period = 2.0, 0.3, 0.5
    load = math.pi * half**2 * E / (4 * radius) * period
    exact = half * E / (2 * radius)
    shape, sides = [N, N], [half / 24, half / 24]
    shape[axis], sides[axis] = 16, period / 16
    radii, edges = [radius, radius], ["free", "free"]
    radii[axis], edges[axis] = 0, "periodic"
    found, largest = of_form(asperity, tmp_path, tuple(radii), tuple(sides), load,
                             np.zeros(shape), tuple(edges))
    row = found.positions[0]
    errors = [largest / exact - 1, float(row["hertz_pressure"]) / exact - 1,
              float(row["hertz_area"]) / (2 * half * period) - 1]
    assert abs(errors[0]) < 1e-3 and max(map(abs, errors[1:])) < 1e-9, errors
    assert f"periodic along {'xy'[axis]}" in found.stdout and "smooth form (Hertz)" in found.stdout


def test_a_ball_in_each_period_of_a_strip(asperity, tmp_path):
    """Against the middle one of a row of 15 balls at the same load on each; the row ends, so that
    its outer balls carry more at one separation: their loads are compared."""
    n, side, radius = 16, 0.05, 1.0
    u = (np.arange(n) - (n - 1) / 2) * side
    ball = -(u[:, None] ** 2 + u**2) / (2 * radius)
    load = 0.15
    row = np.tile(ball, (15, 1))
    scene = map_scene(tmp_path, row, (side, side), name="row", surfaces={"map_level": "none"},
                      loading={"control": "load", "value": 15 * load})
    middle = solve(asperity, scene).contacts[7]
    again, largest = of_form(asperity, tmp_path, 0, (side, side), float(middle["load"]), ball,
                             ("periodic", "free"), map_level="none")
    errors = [largest / float(middle["maximum_pressure"]) - 1,
              float(again.positions[0]["area"]) / float(middle["area"]) - 1]
    assert max(map(abs, errors)) < 1e-3, errors


def test_a_strip_needs_a_load(asperity, tmp_path):
    scene = map_scene(tmp_path, np.zeros((N, N)), (1, 1),
                      loading={"control": "approach", "value": 0},
                      surfaces={"form_radius": 9, "map_edge": ("periodic", "free")})
    shown = run_program(asperity, "solve", scene, status=2).stderr
    assert "is known by its load" in shown


def test_form_radius_is_refused(asperity, tmp_path):
    for radius, word in (((1, -1), "expected a number of 0 or more"), (1e-40, "expected a length")):
        scene = map_scene(tmp_path, np.zeros((N, N)), (1, 1), surfaces={"form_radius": radius})
        assert word in run_program(asperity, "solve", scene, status=2).stderr


@pytest.mark.parametrize("axis", [0, 1])
def test_displacements_on_a_strip(asperity, tmp_path, axis):
    """Differences of the displacements of the solved pressures, by 4001 periods of rectangles."""
    shape, sides, edges = [5, 8], [0.1, 0.13], ["periodic", "free"]
    if axis:
        shape, sides, edges = shape[::-1], sides[::-1], edges[::-1]
    height = 1e-2 * np.random.default_rng(3).random(shape)
    scene = map_scene(tmp_path, height, tuple(sides), surfaces={"map_edge": tuple(edges)},
                      loading={"control": "load", "value": 2e-3})
    run_program(asperity, "solve", scene, "--quiet", "--fields", tmp_path / "f.vti")
    fields = read_vti(tmp_path / "f.vti")[2]
    offset = np.indices(shape).reshape(2, -1)
    offset = (offset[:, :, None] - offset[:, None, :]) * np.array(sides)[:, None, None]
    moved = np.zeros(height.size)
    pressure = fields["pressure"].ravel()
    for period in range(-2000, 2001):
        shift = [0.0, 0.0]
        shift[axis] = period * shape[axis] * sides[axis]
        moved += love(offset[0] + shift[0], offset[1] + shift[1], *sides) @ pressure / (math.pi * E)
    found = fields["displacement"].ravel()
    assert np.ptp(found - moved) < 2e-6 * np.ptp(found)
