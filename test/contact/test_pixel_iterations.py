"""Iterations of conjugate gradients on the pixels of a map: how many long pixels need, and where
no conjugate step is accepted."""

import numpy as np
import pytest

from map_press_truth import rough
from surfaces_csv import solve, write_scene

BOUNDARY = {"interaction": "boundary"}


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
    assert iterations[1] <= 1.7 * iterations[0], iterations


def test_iterations_on_rims(asperity, tmp_path):
    """Displacements that are shared beside the contact save iterations: 14 are left."""
    np.save(tmp_path / "map.npy", 0.1 * rough(128, seed=3))
    scene = write_scene(
        tmp_path / "map.scene", surfaces={"upper": "plane", "lower": "map.npy",
                                          "map_spacing": (1.0, 1.0), "map_edge": "periodic"},
        material={"contact_modulus": 1.0}, effects=BOUNDARY,
        loading={"control": "pressure", "value": 0.002})
    assert int(solve(asperity, scene).positions[0]["interaction_iterations"]) <= 15


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
