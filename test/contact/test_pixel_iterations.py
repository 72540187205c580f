"""Iterations of conjugate gradients on the pixels of a map: how many long pixels need, and where
no conjugate step is accepted."""

import numpy as np
import pytest

from map_press_truth import rough
from map_scenes import map_scene
from surfaces_csv import solve


def solved(asperity, folder, height, sides, pressure, edge="periodic"):
    """The position of a map, indexed [y, x], of a body of the modulus 1."""
    scene = map_scene(folder, height.T, sides, material=1.0, surfaces={"map_edge": edge},
                      loading={"control": "pressure", "value": pressure})
    return solve(asperity, scene).positions[0]


@pytest.mark.parametrize("edge", ["periodic", "free"])
@pytest.mark.parametrize("sides", [(0.1, 1.0), (4.0, 1.0)], ids=str)
def test_iterations_on_long_pixels(sides, edge, asperity, tmp_path):
    """They need about as many iterations as square ones: the approximate inverse has their sides;
    one for squares needs twice as many."""
    height = 0.1 * rough(128, seed=3, stretched=sides[1] / sides[0])
    square, long = (int(solved(asperity, tmp_path, height, spacing, 0.002,
                               edge)["interaction_iterations"]) for spacing in ((1.0, 1.0), sides))
    assert long <= 1.7 * square


def test_iterations_on_rims(asperity, tmp_path):
    """Displacements that are shared beside the contact save iterations: 14 are left."""
    found = solved(asperity, tmp_path, 0.1 * rough(128, seed=3), (1.0, 1.0), 0.002)
    assert int(found["interaction_iterations"]) <= 15


def test_projected_steps(asperity, tmp_path):
    """Pixels a thousand times as long as wide, some missing: no conjugate step is accepted, and
    projected steps of the length 1/|A| take more than 2000 iterations."""
    random = np.random.default_rng(138)
    k = np.arange(1, 17)
    waves = np.cos(2 * np.pi * (np.outer(np.arange(64) / 64, k) + random.random(16)))
    height = np.repeat(0.01 * waves @ k[:, None] ** -1.8, 96, 1)
    height[random.random(height.shape) < 0.1] = np.nan
    found = solved(asperity, tmp_path, height, (0.001, 1.0), 1e-4)
    assert float(found["interaction_residual"]) <= 1e-10
