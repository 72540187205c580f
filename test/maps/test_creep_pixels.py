"""Creep on the pixels of a height map: holds against hereditary integrals of pressures in numpy, a
ball up and down in time against Ting."""

import numpy as np
import pytest

from map_press_truth import first_contact, press, rough
from map_scenes import level, load_for, map_scene, solve_map

RATIO, TAU, HOLD = 0.3, 2.0, 6.0
SIDES = (0.01, 0.013)


def run(asperity, folder, height, loading, edge="free", **effects):
    """Rows of the states, the position, fields of the last state."""
    return solve_map(asperity, map_scene(
        folder, height, SIDES, surfaces={"map_edge": edge}, loading=loading, by_default=True,
        effects={"creep": "on", "hold_time": HOLD, "relaxation_time": TAU,
                 "relaxed_modulus_ratio": RATIO, **effects}))[:3]


def compliance(t):
    """J(t) E(0) of the solid."""
    return 1 / RATIO - (1 / RATIO - 1) * np.exp(-RATIO * t / TAU)


def relaxation(t):
    """E(t)/E(0)."""
    return RATIO + (1 - RATIO) * np.exp(-t / TAU)


@pytest.mark.parametrize("edge", ["free", "periodic"])
def test_held_load(asperity, tmp_path, edge):
    """Area and separation are those of the elastic map at the load times J, the pressures those of
    the hereditary integral over 40 steps (Lee and Radok 1960), to 1e-3."""
    height = 1e-3 * rough(32, shortest=8, seed=9)
    load = load_for(height, SIDES, 0.02)
    rows, position, fields = run(asperity, tmp_path, height, {"control": "load", "value": load},
                                 edge, hold_points=41)
    of = height - height.mean() if edge == "periodic" else level(height)
    pressure, before = 0.0, 0.0
    for row in rows:
        flat, elastic = press(of, SIDES, 3.0, load * compliance(row["time"]), edge == "periodic")
        middle = HOLD - row["time"] if row["step"] == 1 else HOLD - (row["time"] + last) / 2
        pressure = pressure + relaxation(middle) * (elastic - before)
        before, last = elastic, row["time"]
        assert abs(row["separation"] - flat) < 1e-6 * abs(flat) and row["load"] == load
    assert len(rows) == 41 and position["samples_in_contact"] == (elastic > 0).sum()
    assert np.abs(fields["pressure"] - pressure).max() < 1e-3 * pressure.max()
    assert abs(position["elastic_load"] / (load * compliance(HOLD)) - 1) < 1e-6


def test_held_separation(asperity, tmp_path):
    """All pressures relax as the modulus does, also after a path that unloads."""
    height = 1e-3 * rough(32, shortest=8, seed=9)
    load = load_for(height, SIDES, 0.1)
    for path in ((load,), (load, 0.4 * load)):
        rows, _, fields = run(asperity, tmp_path, height, {"control": "load", "value": path},
                              hold="separation", hold_points=5)
        _, elastic = press(level(height), SIDES, 3.0, path[-1])
        for row in rows[len(path) - 1:]:
            assert abs(row["load"] / path[-1] / relaxation(row["time"]) - 1) < 1e-8
        assert np.abs(fields["pressure"] - relaxation(HOLD) * elastic).max() < 1e-7 * elastic.max()


def test_open_surfaces_stay_open(asperity, tmp_path):
    """A hold of no load beyond first contact jumped to first contact."""
    height = 1e-3 * np.random.default_rng(9).random((8, 6))
    flat = 1.5 * float(level(height).max())
    for hold in ("load", "separation"):
        rows, _, fields = run(asperity, tmp_path, height,
                              {"control": "separation", "value": flat}, hold=hold)
        assert all(row["separation"] == flat and row["load"] == 0 for row in rows)
        assert fields["gap"] == pytest.approx(flat - level(height), rel=1e-9)


@pytest.mark.parametrize("edge", [("periodic", "free"), ("free", "periodic")])
def test_held_separation_of_a_strip(asperity, tmp_path, edge):
    """All pressures relax as the modulus does on strips much wider than their period, where they
    opened: displacements from one period beside a line have no least energy there."""
    height = 1e-3 * np.random.default_rng(9).random((4, 48))
    if edge[1] == "periodic":
        height = height.T
    for share in (0.1, 0.5, 20.0):
        load = load_for(height, SIDES, share)
        rows, _, _ = run(asperity, tmp_path, height, {"control": "load", "value": load}, edge,
                         hold="separation", hold_points=3)
        for row in rows:
            assert row["load"] == pytest.approx(load * relaxation(row["time"]), rel=1e-8)
            assert row["area"] == pytest.approx(rows[0]["area"], rel=1e-12)


@pytest.mark.parametrize("edge", ["free", ("periodic", "free")])
def test_flat_with_missing_pixels(asperity, tmp_path, edge):
    """The heights that remain are those of rounding: missing pixels came into contact."""
    height = np.full((5, 3), 2.5e-6)
    height[[1, 1, 2, 3, 3], [0, 2, 2, 1, 2]] = np.nan
    for load in (1e-3, 40.0, 4e4):
        rows, _, fields = run(asperity, tmp_path, height, {"control": "load", "value": load}, edge)
        assert all(row["load"] == load for row in rows)
        assert all(row["area"] == pytest.approx(10 * SIDES[0] * SIDES[1]) for row in rows)
        assert np.nansum(fields["pressure"]) * SIDES[0] * SIDES[1] == pytest.approx(load)


def test_beside_other_effects(asperity, tmp_path):
    """A work of adhesion next to 0 and a hardness above all pressures change nothing; adhesion
    makes the area grow, a hardness limits the pressures."""
    height = 1e-3 * rough(32, shortest=8, seed=9)
    loading = {"control": "load", "value": load_for(height, SIDES, 0.05)}
    plain, _, fields = run(asperity, tmp_path, height, loading, hold_points=5)
    highest = fields["pressure"].max()
    none, _, _ = run(asperity, tmp_path, height, loading, hold_points=5, adhesion="on",
                     work_of_adhesion=1e-16, equilibrium_distance=1e-5,
                     plastic_hardness=float(10 * highest))
    for row, other in zip(plain, none):
        assert abs(row["separation"] - other["separation"]) < 1e-8 * abs(row["separation"])
    sticky, _, _ = run(asperity, tmp_path, height, loading, hold_points=5, adhesion="on",
                       work_of_adhesion=1e-7, equilibrium_distance=5e-5)
    assert sticky[-1]["area"] > 1.01 * plain[-1]["area"]
    soft, _, fields = run(asperity, tmp_path, height, loading, hold_points=5,
                          plastic_hardness=float(0.8 * highest))
    assert fields["pressure"].max() <= 0.8 * highest and soft[-1]["plastic_area"] > 0


def ting(relaxation_of, deepest, middle, time):
    """Load and contact area of a ball of radius 1 and modulus 1 whose approach rises at a constant
    rate until `middle` and falls after it: Ting, J. Appl. Mech. 33 (1966) 845, by quadrature."""
    def integral(low, high):
        t = np.linspace(low, high, 2001)
        return np.trapezoid(relaxation_of(time - t), t)

    low, high = (time, time) if time <= middle else (0.0, middle)
    for _ in range(50 if time > middle else 0):
        half = (low + high) / 2
        if integral(half, middle) > integral(middle, time):
            low = half
        else:
            high = half
    t = low * np.linspace(0, 1, 2001)**2
    elastic = 4 / 3 * (deepest * t / middle)**1.5
    load = (relaxation_of(time - (t[1:] + t[:-1]) / 2) * np.diff(elastic)).sum()
    return load, np.pi * deepest * low / middle


@pytest.mark.parametrize("ratios, times, points", [
    (0.3, 1.0, 20), ((0.7, 0.5, 0.3), (0.1, 1.0, 5.0), 0)])
def test_ball_up_and_down(asperity, tmp_path, ratios, times, points):
    """Loads to 0.2 % of the largest, areas to a row of pixels; the area shrinks to nothing before
    the ball has left the surface as it was."""
    middle, deepest, n = 1.5, 0.01, 64
    shares = -np.diff([1, *np.atleast_1d(ratios)])
    x = (np.arange(n) - (n - 1) / 2) * 0.25 / n
    rows, _, _, lines = solve_map(asperity, map_scene(
        tmp_path, -(x[:, None]**2 + x[None, :]**2) / 2, (0.25 / n, 0.25 / n), material=1.0,
        surfaces={"map_level": "none"},
        loading={"control": "compression", "value": (deepest, 0.0), "points": points},
        effects={"relaxation_time": times, "relaxed_modulus_ratio": ratios,
                 "loading_time": 2 * middle}))
    # Tabor: 0.2 a/R, with a = sqrt(R deepest) at the middle. The table of the ball has this line.
    assert len(rows) == 41 and lines.count("warning:") == 1
    assert "a contact creeps beyond the linear range, 2.00 % of strain" in lines
    exact = np.array([ting(lambda t: np.atleast_1d(ratios)[-1] + sum(
        share * np.exp(-t / of) for share, of in zip(shares, np.atleast_1d(times))),
        deepest, middle, row["time"]) for row in rows])
    loads = np.array([row["load"] for row in rows])
    assert np.abs(loads - exact[:, 0]).max() < 2e-3 * exact[:, 0].max()
    radii = np.sqrt([row["area"] / np.pi for row in rows]) - np.sqrt(exact[:, 1] / np.pi)
    assert np.abs(radii).max() < x[1] - x[0]
    assert loads[-2] == 0 and rows[-2]["area"] == 0 and rows[20]["time"] == middle


def test_cycles_of_load_in_time(asperity, tmp_path):
    """Twice as many states change a cycle of loads by the square of the step; a slow cycle is that
    of the relaxed solid, a fast one that of the instantaneous one."""
    height = 1e-3 * rough(32, shortest=8, seed=9)
    load = load_for(height, SIDES, 0.05)
    ends = {}
    for time, points in ((8.0, 5), (8.0, 10), (8.0, 40), (1e9, 5), (1e-9, 5)):
        rows, _, _ = run(asperity, tmp_path, height, {"control": "load", "points": points,
                         "value": (load, 0.2 * load, load)}, hold_time=0.0, loading_time=time)
        assert len(rows) == 1 + 3 * points and rows[-1]["load"] == load
        assert rows[-1]["time"] == time
        ends[time, points] = rows[-1]["compression"]
    off = [abs(ends[8.0, points] / ends[8.0, 40] - 1) for points in (5, 10)]
    assert off[0] < 1e-2 and off[1] < 0.4 * off[0]
    of = level(height)
    for time, stiffness in ((1e9, RATIO), (1e-9, 1.0)):
        flat, _ = press(of, SIDES, 3.0, load / stiffness)
        assert abs(ends[time, 5] / (first_contact(of) - flat) - 1) < 1e-5
