"""Stiffness, conductance and open paths of maps on their pixels: `contact_stiffness`,
`interface_stiffness`, `conductance_length`, `open_path_x`, `open_path_y`."""

import math

import numpy as np
import pytest
from elements_truth import love
from map_press_truth import rough
from programs import run_program
from surfaces_csv import solve
from map_scenes import E, load_for, map_scene

SIDES = (0.01, 0.01)


def press(asperity, folder, height, edge, sides=SIDES, effects=None, level="mean", **loading):
    scene = map_scene(folder, height, sides, surfaces={"map_edge": edge, "map_level": level},
                      loading=loading)
    found = solve(asperity, scene)
    assert found.status == 0, found.stderr
    return found.positions[0]


@pytest.mark.parametrize("edge, share, seed", [
    ("periodic", 0.02, 1), ("free", 0.05, 2), (("periodic", "free"), 0.1, 3),
    ("periodic", 0.2, 4)])
def test_stiffness_against_differences(asperity, tmp_path, edge, share, seed):
    """Central differences over 1e-4 of the load."""
    height = 1e-3 * rough(64, shortest=8, seed=seed)
    load = load_for(height, SIDES, share)
    less, at, more = (press(asperity, tmp_path, height, edge, control="load",
                            value=load * (1 + step)) for step in (-1e-4, 0, 1e-4))
    names = {"separation": "contact_stiffness", "mean_gap": "interface_stiffness"}
    if edge not in ("periodic", "free"):
        assert at["contact_stiffness"] == at["conductance_length"] == ""
        del names["separation"]
    for length, stiffness in names.items():
        change = float(less[length]) - float(more[length])
        assert abs(2e-4 * load / change / float(at[stiffness]) - 1) < 1e-6, length


def test_a_circle_has_the_closed_stiffness_and_conductance(asperity, tmp_path):
    """A ball of the contact radius a: dP/d(compression) = 2 E a (Johnson 1985, section 4.2), the
    conductance 4 a over the conductivity (Holm 1967), to the width of a pixel."""
    n, radius, a = 129, 1.0, 0.25
    u = (np.arange(n) - n // 2) * a / 40
    row = press(asperity, tmp_path, -(u[:, None] ** 2 + u**2) / (2 * radius), "free",
                (a / 40, a / 40), level="none", control="load", value=4 / 3 * E * a**3 / radius)
    assert float(row["contact_stiffness"]) == pytest.approx(2 * E * a, rel=3e-3)
    assert float(row["conductance_length"]) == pytest.approx(4 * a, rel=3e-3)
    # By the definition of the mean gap the interface of a free map is stiffer.
    assert float(row["interface_stiffness"]) > float(row["contact_stiffness"])


def test_full_contact_of_a_free_map(asperity, tmp_path):
    """Stiffness of all measured pixels by a dense solve in numpy. Their gaps stay 0."""
    height = 1e-3 * np.random.default_rng(7).normal(size=(9, 7))
    height[[2, 5], [3, 1]] = np.nan
    inside = np.argwhere(np.isfinite(height))
    for turn, sides in enumerate([(0.01, 0.014), (0.014, 0.01)]):
        one, other = (np.subtract.outer(part, part) * side
                      for part, side in zip(inside.T, (0.01, 0.014)))
        matrix = love(one, other, 0.01, 0.014) / (math.pi * E)
        row = press(asperity, tmp_path, height.T if turn else height, "free", sides,
                    control="load", value=1e-2 * E)
        assert float(row["samples_in_contact"]) == len(inside)
        assert row["interface_stiffness"] == ""
        assert float(row["contact_stiffness"]) == pytest.approx(
            0.01 * 0.014 * np.linalg.solve(matrix, np.ones(len(inside))).sum(), rel=1e-5)


def test_conductances(asperity, tmp_path):
    """Barber (2003): the length over 1/k1 + 1/k2, and refused without a map."""
    height = 1e-3 * rough(32, shortest=8, seed=1)
    loading = {"control": "load", "value": load_for(height, SIDES, 0.05)}
    text = map_scene(tmp_path, height, SIDES, surfaces={"map_edge": "free"},
                     loading=loading).read_text()
    given = "electrical_conductivity = 6e4, 2e4, thermal_conductivity = 0.4, 0.1"
    (tmp_path / "k.scene").write_text(text.replace("&material", f"&material {given},"))
    row = solve(asperity, tmp_path / "k.scene").positions[0]
    length = float(row["conductance_length"])
    assert float(row["electrical_conductance"]) == pytest.approx(length * 1.5e4, rel=1e-12)
    assert float(row["thermal_conductance"]) == pytest.approx(length * 0.08, rel=1e-12)
    (tmp_path / "s.csv").write_text("x,y,height,radius\n0,0,0.1,1\n")
    (tmp_path / "k.scene").write_text(
        "&surfaces upper = 'plane', lower = 's.csv' / &loading control = 'load', value = 1. /\n"
        "&material contact_modulus = 1., thermal_conductivity = 1., 1. /\n")
    words = run_program(asperity, "solve", tmp_path / "k.scene", status=2).stderr
    assert "thermal_conductivity" in words and "found no map, expected one" in words


def test_a_limit_on_the_pressure(asperity, tmp_path):
    """Pixels at the hardness carry no further load; with all of them there the stiffness is 0."""
    height = 1e-3 * rough(48, shortest=8, seed=5)
    scene = map_scene(tmp_path, height, SIDES, surfaces={"map_edge": "periodic"},
                      loading={"control": "load", "value": load_for(height, SIDES, 0.1)})
    elastic = solve(asperity, scene).positions[0]
    scene.write_text(scene.read_text().replace(
        "plasticity = 'off'", "plasticity = 'on', plastic_hardness = 0.02"))
    plastic = solve(asperity, scene).positions[0]
    assert 0 < float(plastic["contact_stiffness"]) < 0.9 * float(elastic["contact_stiffness"])


def walls(kind):
    """Heights of 12 x 12 pixels, 0.1 at walls; whether the rest has a path along x and along y."""
    wall = np.zeros((12, 12))
    if kind == "none":
        wall[5:7, 5:7] = 1
        return wall, (1, 1), (1, 1)
    if kind == "across x":
        wall[6] = 1
        return wall, (0, 1), (0, 1)
    if kind == "across x, one pixel open":
        wall[6] = 1
        wall[6, 4] = 0
        return wall, (1, 1), (1, 1)
    if kind == "diagonal":
        # Beside the wall a path goes around the period along both axes.
        np.fill_diagonal(wall, 1)
        return wall, (0, 0), (1, 1)
    if kind == "stair":
        wall[:] = 1
        for i in range(12):
            wall[i, i] = wall[i, (i + 1) % 12] = 0
        return wall, (1, 1), (1, 1)
    wall[3:9, 3:9] = 1
    wall[5:7, 5:7] = 0
    wall[6, :3] = wall[6, 9:] = 1
    return wall, (0, 1), (0, 1)


@pytest.mark.parametrize("edge", ["free", "periodic"])
@pytest.mark.parametrize("kind", ["none", "across x", "across x, one pixel open", "diagonal",
                                  "stair", "ring and walls"])
def test_paths_between_walls_are_open_or_closed(asperity, tmp_path, edge, kind):
    height, *known = walls(kind)
    row = press(asperity, tmp_path, 0.1 * height, edge, (1.0, 1.0), level="none",
                control="approach", value=0.0999)
    assert float(row["samples_in_contact"]) == height.sum()
    assert tuple(float(row[f"open_path_{axis}"]) for axis in "xy") == known[edge == "periodic"]


def test_a_missing_pixel_is_no_path(asperity, tmp_path):
    height, *_ = walls("across x, one pixel open")
    height[6, 4] = math.nan
    row = press(asperity, tmp_path, 0.1 * height, "free", (1.0, 1.0), level="none",
                control="approach", value=0.0999)
    assert [float(row[f"open_path_{axis}"]) for axis in "xy"] == [0, 1]
