"""Asperities of a table over a height map, against numpy's sum of their paraboloids and the map."""

import numpy as np
import pytest
from map_press_truth import press, rough
from programs import run_program
from surfaces_csv import solve, write_scene, write_surface
from map_scenes import E, write_map

SIDE, PIXELS = 0.25, 24
LENGTH = SIDE * PIXELS
CAPS = [(1.1, 2.3, 0.05, 3.0), (4.4, 4.0, 0.06, 2.0), (5.9, 0.2, 0.055, 4.0)]


def paraboloids(shift=(0.0, 0.0), periodic=False):
    """The highest of all paraboloids and the plane 0; the nearest of all periods."""
    x = SIDE * np.arange(PIXELS)
    height = np.zeros((PIXELS, PIXELS))
    for at_x, at_y, top, radius in CAPS:
        away = [x - at_x - shift[0], x - at_y - shift[1]]
        if periodic:
            away = [(d + LENGTH / 2) % LENGTH - LENGTH / 2 for d in away]
        height = np.maximum(height, top - (away[0][:, None]**2 + away[1]**2) / (2 * radius))
    return height


def caps_scene(folder, heights, caps=CAPS, side="upper", motion=None, surfaces=None, **loading):
    other = "lower" if side == "upper" else "upper"
    return write_scene(
        folder / "caps.scene",
        surfaces={side: write_surface(folder / "caps.csv", caps),
                  other: write_map(folder / "map.txt", heights), "map_spacing": (SIDE, SIDE),
                  "map_level": "mean", **(surfaces or {})},
        material={"contact_modulus": E}, motion=motion or {}, effects={"interaction": "auto"},
        loading={"control": "load", "value": 0.02, **loading})


@pytest.mark.parametrize("edge", ["free", "periodic"])
@pytest.mark.parametrize("side, sign", [("upper", 1), ("lower", -1)])
def test_the_sum_of_both_is_solved(asperity, tmp_path, edge, side, sign):
    """The upper body moves: asperities over the map, or the map over them."""
    heights = 5e-3 * rough(PIXELS, shortest=4, seed=4)
    scene = caps_scene(tmp_path, heights, side=side, surfaces={"map_edge": edge},
                       motion={"x_first": 0.1, "x_step": 0.4, "y_first": -0.2, "positions": 3})
    periodic = edge == "periodic"
    rows = solve(asperity, scene).positions
    assert len(rows) == 3
    for m, row in enumerate(rows):
        added = paraboloids((sign * (0.1 + 0.4 * m), -0.2 * sign), periodic)
        flat, pressure = press(heights - heights.mean() + added, (SIDE, SIDE), E, 0.02,
                               periodic=periodic)
        assert abs(float(row["separation"]) / flat - 1) < 1e-6
        assert float(row["samples_in_contact"]) == np.count_nonzero(pressure)


def test_contacts_lie_in_the_lower_body(asperity, tmp_path):
    """A map displaced over an asperity: the contact stays at the asperity."""
    scene = caps_scene(tmp_path, np.zeros((PIXELS, PIXELS)), CAPS[:1], "lower",
                       motion={"x_first": -1.0, "y_first": 0.5})
    contact, = solve(asperity, scene).contacts
    assert abs(float(contact["x"]) - 1.1) < 0.01 and abs(float(contact["y"]) - 2.3) < 0.01


def test_one_radius_and_one_unit(asperity, tmp_path):
    """A table without radii has that of the scene; units of header and map are the same."""
    heights = np.zeros((PIXELS, PIXELS))
    scene = caps_scene(tmp_path, heights, [(2.0, 2.0, 0.1, 3.0)])
    alike = solve(asperity, scene).positions
    (tmp_path / "caps.csv").write_text("x(um),y(um),height(um)\n2,2,0.1\n")
    scene.write_text(scene.read_text().replace("map_spacing", "radius = 3., map_spacing"))
    assert solve(asperity, scene).positions == alike
    scene.write_text(scene.read_text().replace("map_spacing", "map_unit = 'mm', map_spacing"))
    wrong = run_program(asperity, "solve", scene, status=2)
    assert ("found unit 'um' in its header beside 'mm' of the map, expected the same, or map_unit"
            in wrong.stderr)


def test_asperities_beside_the_map(asperity, tmp_path):
    """Some of them are noted; at least one lies over the map."""
    heights = np.zeros((PIXELS, PIXELS))
    scene = caps_scene(tmp_path, heights, [*CAPS, (-3.0, 1.0, 0.05, 3.0)])
    done = solve(asperity, scene)
    assert done.status == 0 and "1 of 4 summits lie beside the map" in done.stderr
    scene = caps_scene(tmp_path, heights, [(-3.0, 1.0, 0.05, 3.0)])
    done = solve(asperity, scene)
    assert done.status == 1 and "no asperity of the table lies over the map" in done.stderr


def test_asperities_of_few_pixels(asperity, tmp_path):
    """A contact radius below the spacing is a warning of the coarse pixels."""
    scene = caps_scene(tmp_path, np.zeros((PIXELS, PIXELS)), [(2.1, 2.1, 0.1, 0.3)], value=1e-4)
    assert "contact patches are not resolved" in solve(asperity, scene).stderr
