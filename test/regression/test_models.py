"""A ball as one asperity and as the pixels of a height map: the same load, area, compression,
greatest pressure and columns of each effect, within the size of the pixels."""

import pytest
from surfaces_csv import solve, write_scene, write_surface

RADIUS, SIDE, PIXELS = 10.0, 2.4, 64
COLUMNS = ("load", "area", "compression")
SLIP = ("tangential_displacement", "tangential_stiffness", "stick_area")


def ball(folder):
    """Heights of a ball whose top is the centre of the map, as text."""
    step = SIDE / PIXELS
    x = [(i - PIXELS / 2 + 0.5) * step for i in range(PIXELS)]
    (folder / "ball.txt").write_text("\n".join(
        " ".join(repr(-(a * a + b * b) / (2 * RADIUS)) for a in x) for b in x) + "\n")
    return {"upper": "plane", "lower": "ball.txt", "map_spacing": (step, step),
            "map_level": "none"}


@pytest.mark.parametrize("effects, loading, more", [
    ({}, {}, ()),
    ({"creep": "on", "hold_time": 3.0, "relaxation_time": 1.0, "relaxed_modulus_ratio": 0.4,
      "hold_points": 4}, {}, ()),
    ({"friction": "on", "friction_coefficient": 0.3}, {"tangential_load": 0.8}, SLIP)],
    ids=["elastic", "creep", "slip"])
def test_a_ball_as_asperity_and_as_pixels(asperity, tmp_path, tally, effects, loading, more):
    found = []
    for surfaces in (ball(tmp_path),
                     {"upper": "plane",
                      "lower": write_surface(tmp_path / "cap.csv", [(0.0, 0.0, 0.0, RADIUS)])}):
        done = solve(asperity, write_scene(
            tmp_path / "ball.scene", surfaces=surfaces,
            material={"elastic_modulus": (182.0, 182.0), "poisson_ratio": (0.3, 0.3)},
            effects={"interaction": "auto", **effects},
            loading={"control": "load", "value": 5.0, **loading}))
        assert done.status == 0, done.stderr
        found.append([float(done.positions[0][name]) for name in (*COLUMNS, *more)]
                     + [float(done.contacts[-1]["maximum_pressure"])])
    for pixels, cap in zip(*found, strict=True):
        assert abs(pixels / cap - 1) < 0.01, (pixels, cap)
    tally.add("a ball as asperity and as pixels", len(found[0]), len(found[0]))
