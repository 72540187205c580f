"""One height map moved over another, against numpy's sums of the same pixels and against itself
over a period."""

import numpy as np
import pytest

from map_press_truth import press, rough
from programs import run_program
from surfaces_csv import records, solve
from map_scenes import E, map_scene, write_map

SIDE = 0.25


def moved(folder, upper, lower, edge="free", spacing=(SIDE, SIDE), upper_spacing=None, motion=None,
          effects=None, **loading):
    return map_scene(folder, lower, (*(upper_spacing or spacing), *spacing), interaction="auto",
                     upper=write_map(folder / "upper.txt", upper), effects=effects, loading=loading,
                     surfaces={"map_edge": edge, "map_level": "mean"}, motion=motion or {})


def numbers(rows, *names):
    return np.array([[float(row[name]) for name in names] for row in rows])


def centred(height):
    return height - height.mean()


def test_moved_steps_ring(asperity, tmp_path):
    """The warning of outliers names what makes them, and does not advise to remove them; by whole
    pixels nothing rings."""
    upper = np.zeros((32, 32))
    upper[8:24, 8:24] = 1e-2
    shown = []
    for move in (SIDE / 2, SIDE):
        scene = moved(tmp_path, upper, np.zeros((32, 32)), "periodic", motion={"x_first": move},
                      control="pressure", value=1e-3 * E)
        shown.append(solve(asperity, scene).stderr)
    assert "(moved steps ring between the pixels)" in shown[0] and "whole pixels" in shown[0]
    assert "map_despike" not in shown[0] and "moved steps" not in shown[1]


def test_periodic_maps_by_whole_pixels_are_rolled(asperity, tmp_path):
    upper, lower = (1e-2 * rough(32, shortest=4, seed=seed) for seed in (1, 2))
    scene = moved(tmp_path, upper, lower, "periodic",
                  motion={"x_first": 0.0, "x_step": 5 * SIDE, "y_first": 0.0, "y_step": 3 * SIDE,
                          "positions": 4}, control="load", value=0.02)
    found = numbers(solve(asperity, scene).positions, "separation", "area", "x_displacement")
    for m, (separation, area, displacement) in enumerate(found):
        rolled = np.roll(centred(upper), (5 * m, 3 * m), (0, 1)) + centred(lower)
        flat, pressure = press(rolled, (SIDE, SIDE), E, 0.02, periodic=True)
        assert abs(separation / flat - 1) < 1e-6 and displacement == 5 * m * SIDE
        assert 0.5 < area / (np.count_nonzero(pressure) * SIDE ** 2) <= 1


@pytest.mark.parametrize("step", [0.3, 1.0])
def test_a_period_later_all_is_the_same(asperity, tmp_path, step):
    """The last position is one period of 24 pixels after the first, by parts of pixels or whole
    ones."""
    upper, lower = (1e-2 * rough(24, shortest=4, seed=seed) for seed in (3, 4))
    scene = moved(tmp_path, upper, lower, "periodic",
                  motion={"x_first": step * SIDE, "x_step": 12 * SIDE, "positions": 3},
                  control="load", value=0.02)
    rows = solve(asperity, scene).positions
    found = numbers(rows, "separation", "area", "mean_gap", "load", "elastic_energy")
    assert np.allclose(found[0], found[2], rtol=1e-9, atol=0)
    assert abs(found[1, 0] / found[0, 0] - 1) > 1e-3


def test_parts_of_a_pixel_move_waves(asperity, tmp_path):
    """A wave of eight pixels moved by a third of a pixel: its cosine there."""
    n = 32
    k = 2 * np.pi / (8 * SIDE)
    x = SIDE * np.arange(n)
    lower = 1e-2 * rough(n, shortest=8, seed=5)
    upper = np.repeat(0.01 * np.cos(k * x)[:, None], n, axis=1)
    scene = moved(tmp_path, upper, lower, "periodic", motion={"x_first": SIDE / 3},
                  control="load", value=0.02)
    there = np.repeat(0.01 * np.cos(k * (x - SIDE / 3))[:, None], n, axis=1) + centred(lower)
    flat, _ = press(there, (SIDE, SIDE), E, 0.02, periodic=True)
    found, = numbers(solve(asperity, scene).positions, "separation")
    assert abs(found[0] / flat - 1) < 1e-6


@pytest.mark.parametrize("shift", [(0, 0), (7, 0), (-5, 4)])
def test_free_maps_have_a_window_in_common(asperity, tmp_path, shift):
    """Maps of unlike sizes: numpy's sum of the rows and columns that both have."""
    lower = 1e-2 * rough(40, shortest=5, seed=6)[:36]
    upper = 1e-2 * rough(30, shortest=5, seed=7)
    scene = moved(tmp_path, upper, lower,
                  motion={"x_first": shift[0] * SIDE, "y_first": shift[1] * SIDE},
                  control="load", value=0.02)
    done = solve(asperity, scene)
    assert done.status == 0 and "their common area is solved" in done.stderr
    first = [max(0, s) for s in shift]
    last = [min(n, s + 30) for n, s in zip(lower.shape, shift)]
    window = (centred(lower)[first[0]:last[0], first[1]:last[1]]
              + centred(upper)[first[0] - shift[0]:last[0] - shift[0],
                               first[1] - shift[1]:last[1] - shift[1]])
    flat, pressure = press(window, (SIDE, SIDE), E, 0.02)
    found, = numbers(done.positions, "separation")
    assert abs(found[0] / flat - 1) < 1e-6
    # Places of contacts count from the first pixel of the lower map.
    load = numbers(done.contacts, "load", "x", "y")
    centre = [(pressure * (first[axis] + np.indices(pressure.shape)[axis])).sum() * SIDE
              / pressure.sum() for axis in (0, 1)]
    assert np.allclose(load[:, 0] @ load[:, 1:] / load[:, 0].sum(), centre, rtol=0, atol=1e-6)


@pytest.mark.parametrize("edge", ["free", "periodic"])
def test_unlike_pixels_are_the_coarser_ones(asperity, tmp_path, edge):
    """A smooth map on 96 pixels against one on 64: the same as both on 96, within 1 %."""
    fine = [1e-2 * smooth(96, seed) for seed in (8, 9)]
    coarse = 1e-2 * smooth(64, 9)
    size = 24.0
    loading = {"control": "load", "value": 0.1}
    unlike = solve(asperity, moved(tmp_path, fine[0], coarse, edge, (size / 64, size / 64),
                                   (size / 96, size / 96), **loading))
    alike = solve(asperity, moved(tmp_path, fine[0], fine[1], edge, (size / 96, size / 96),
                                  **loading))
    pair = numbers(unlike.positions + alike.positions, "mean_gap", "area")
    assert np.all(abs(pair[0] / pair[1] - 1) < 0.01)


def smooth(n, seed):
    """Twelve waves of at least an eighth of the side, from the corner of the first pixel."""
    random = np.random.default_rng(seed)
    x, y = (np.indices((n, n)) / n) * 2 * np.pi
    return sum(random.normal() * np.cos(i * x + j * y + random.uniform(0, 2 * np.pi))
               for i, j in random.integers(-4, 5, (12, 2)))


@pytest.mark.parametrize("upper, motion, said", [
    ("plane", {"x_first": 1.0}, "found beside a map and a plane, expected none"),
    (None, {"x_first": 100.0}, "fewer than 3 pixels in common"),
])
def test_a_motion_without_common_pixels_is_refused(asperity, tmp_path, upper, motion, said):
    height = 1e-2 * rough(16, shortest=4, seed=10)
    scene = moved(tmp_path, height, height, motion=motion, control="load", value=0.02)
    if upper:
        scene.write_text(scene.read_text().replace("'upper.txt'", f"'{upper}'"))
        scene.write_text(scene.read_text().replace(f"map_spacing = {SIDE}, {SIDE}, ",
                                                   "map_spacing = "))
    done = solve(asperity, scene)
    assert done.status != 0 and said in done.stderr, done.stderr


def test_parts_of_a_sweep_choose_the_same_methods(asperity, tmp_path):
    """Adhesion under `auto` is chosen by each position, whatever part of them is solved."""
    upper, lower = (1e-2 * rough(24, shortest=6, seed=seed) for seed in (12, 13))
    effects = {"work_of_adhesion": 2e-6, "equilibrium_distance": 0.02, "adhesion": "auto"}

    def scene_with(**more):
        return moved(tmp_path, upper, lower, "periodic",
                     motion={"x_first": 0.0, "x_step": 5 * SIDE, "positions": 2},
                     effects={**effects, **more}, control="load", value=0.02)

    influence = [float(row["adhesion_estimate"])
                 for row in solve(asperity, scene_with()).positions]
    # One position leaves adhesion out.
    scene = scene_with(tolerance=sum(influence) / 2)
    whole = solve(asperity, scene).positions
    assert min(influence) < max(influence) and {row["adhesion"] for row in whole} == {"off", "on"}
    for part in (1, 2):
        run_program(asperity, "solve", scene.name, "--quiet", "--share", f"{part}/2",
                    "--keep", f"part{part}", cwd=tmp_path)
    run_program(asperity, "solve", scene.name, "--quiet", "--keep", "part1", "--keep", "part2",
                "--positions", "all.csv", cwd=tmp_path)
    assert records(tmp_path / "all.csv") == whole


def test_influence_on_a_patch_without_a_centre(asperity, tmp_path):
    """A periodic map in full contact is one patch: the influence of adhesion that is off is
    printed."""
    height = 1e-3 * rough(32, shortest=8, seed=14)
    scene = moved(tmp_path, height, height, "periodic", control="pressure", value=0.3, effects={
        "work_of_adhesion": 1e-2, "equilibrium_distance": 0.02, "adhesion": "off"})
    done = solve(asperity, scene)
    assert done.status == 0 and done.contacts[0]["x"] == "", done.stderr
    # No gap is open: nothing attracts across one.
    line, = (line for line in done.stdout.splitlines() if line.startswith("adhesion"))
    assert line.split() == ["adhesion", "off", "0", "%"]
