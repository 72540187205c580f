"""Partial slip of asperities under a tangential load: spheres under a plane in closed form, paths,
motion, interaction, plasticity, sliding."""

import numpy as np
import pytest

from judge import WORDS, solved
from surfaces_csv import write_csv_scene, write_plane_scene

MODULUS, RATIO, MU = 1.0e3, 0.3, 0.3
COMBINED = MODULUS / (1 - RATIO**2) / 2
KAPPA = 2 * (1 - RATIO) / (2 - RATIO)
CAPS = [(0.0, 0.0, 0.1, 1.0), (3.0, 1.0, 0.098, 2.0), (-2.0, 4.0, 0.0965, 0.5),
        (5.0, -3.0, 0.05, 1.0)]
GAP = np.array([0.1 - cap[2] for cap in CAPS])
RADIUS = np.array([cap[3] for cap in CAPS])


def loads(compression):
    return 4 / 3 * COMBINED * np.sqrt(RADIUS) * np.maximum(0, compression - GAP) ** 1.5


def compression_at(load):
    """By bisection."""
    low, high = 0.0, 1.0
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (low, middle) if loads(middle).sum() > load else (middle, high)
    return high


def numbers(asperity, scene):
    """Positions and the contacts of each last state."""
    run = solved(asperity, scene)
    positions, contacts = ([{name: float(cell or "nan") for name, cell in row.items()
                             if name not in WORDS} for row in rows]
                           for rows in (run.positions, run.contacts))
    return positions, [[row for row in contacts if row["position"] == position["position"] and
                        row["step"] == position["steps"]] for position in positions]


def caps(asperity, folder, loading, **effects):
    scene = write_plane_scene(folder, CAPS, modulus=(MODULUS, MODULUS), ratio=(RATIO, RATIO),
                              loading=loading, effects={"friction_coefficient": MU, **effects})
    (position,), (rows,) = numbers(asperity, scene)
    return position, rows


@pytest.mark.parametrize("share", [1e-6, 0.2, 0.6, 0.99])
@pytest.mark.parametrize("by_load", [True, False])
def test_spheres_in_closed_form(asperity, tmp_path, share, by_load):
    compression = 0.005
    load = loads(compression).sum()
    less = compression_at((1 - share) * load)
    if share == 1e-6:
        less = compression - share * load / (2 * COMBINED * np.sqrt(
            RADIUS * np.maximum(0, compression - GAP))).sum()
    moved = MU / KAPPA * (compression - less)
    loading = {"control": "load", "value": float(load),
               **({"tangential_load": float(share * MU * load)} if by_load else
                  {"tangential_displacement": float(moved)})}
    position, rows = caps(asperity, tmp_path, loading)
    near = 4e-4 if share == 1e-6 else 1e-6
    assert position["tangential_load"] == pytest.approx(share * MU * load, rel=near)
    assert position["tangential_displacement"] == pytest.approx(moved, rel=near)
    stick = np.sqrt(RADIUS * np.maximum(0, less - GAP))
    assert position["tangential_stiffness"] == pytest.approx(KAPPA * 2 * COMBINED * stick.sum(),
                                                             rel=max(near, 1e-5))
    assert position["stick_area"] == pytest.approx(np.pi * (stick**2).sum(), rel=near)
    assert position["slides"] == 0 and len(rows) == 3
    for row in rows:
        i = int(row["lower"]) - 1
        assert row["stick_area"] == pytest.approx(np.pi * stick[i]**2, rel=near)
        if share > 1e-6:
            assert row["shear_load"] == pytest.approx(
                MU * (loads(compression) - loads(less))[i], rel=1e-6)
    assert sum(row["shear_load"] for row in rows) == pytest.approx(share * MU * load, rel=near)


def test_sliding(asperity, tmp_path):
    load = float(loads(0.005).sum())
    position, rows = caps(asperity, tmp_path, {"control": "load", "value": load,
                                               "tangential_load": 2 * MU * load})
    assert position["slides"] == 1 and np.isnan(position["tangential_displacement"])
    assert position["tangential_load"] == pytest.approx(MU * load, rel=1e-6)
    assert position["stick_area"] == 0 == position["tangential_stiffness"]
    for row in rows:
        assert row["shear_load"] == pytest.approx(MU * row["load"], rel=1e-12)
        assert row["stick_area"] == 0


@pytest.mark.parametrize("mode", ["off", "coupled"])
def test_the_load_of_sliding(asperity, tmp_path, mode):
    """mu times the requested load slides, whatever the rounding of the load that was found."""
    for load in np.geomspace(0.1, 4.0, 9).round(2):
        loading = {"control": "load", "value": float(load), "tangential_load": float(MU * load)}
        position, _ = caps(asperity, tmp_path, loading, interaction=mode)
        assert position["slides"] == 1 and position["stick_area"] == 0, load
        assert position["tangential_load"] == pytest.approx(MU * load, rel=1e-9)


@pytest.mark.parametrize("mode", ["coupled", "boundary"])
def test_close_spheres_by_two_states(asperity, tmp_path, mode):
    """Under interaction the principle holds for the coupled solutions at both loads."""
    near = [(0.0, 0.0, 0.1, 1.0), (0.25, 0.0, 0.1, 1.0), (0.1, 0.22, 0.0985, 0.7)]
    load, share = 4.0, 0.5

    def of_loading(**loading):
        scene = write_plane_scene(
            tmp_path, near, modulus=(MODULUS, MODULUS), ratio=(RATIO, RATIO),
            loading={"control": "load", **loading},
            effects={"friction_coefficient": MU, "interaction": mode})
        (position,), (rows,) = numbers(asperity, scene)
        return position, rows

    found, contacts = of_loading(value=load, tangential_load=share * MU * load)
    full, _ = of_loading(value=load)
    less, fewer = of_loading(value=(1 - share) * load)
    precision = 1e-5 if mode == "coupled" else 3e-3
    moved = MU / KAPPA * (less["separation"] - full["separation"])
    assert found["tangential_displacement"] == pytest.approx(moved, rel=precision)
    assert found["stick_area"] == pytest.approx(less["area"], rel=precision)
    assert found["tangential_load"] == pytest.approx(share * MU * load, rel=1e-5)
    assert sum(row["shear_load"] for row in contacts) == pytest.approx(share * MU * load, rel=1e-5)
    loads_less = {row["lower"]: row["load"] for row in fewer}
    for row in contacts:
        assert row["shear_load"] == pytest.approx(
            MU * (row["load"] - loads_less[row["lower"]]), rel=10 * precision)


def test_positions_of_a_motion(asperity, tmp_path):
    """Each position has the columns of its own states, at its own load."""
    scene = write_csv_scene(
        tmp_path, [(0.0, 0.0, 0.1, 1.0), (1.0, 0.0, 0.095, 1.0)],
        [(0.0, 0.0, 0.1, 1.0), (1.02, 0.0, 0.1, 1.0)], modulus=(MODULUS, MODULUS),
        ratio=(RATIO, RATIO), motion={"x_first": 0.0, "x_step": 0.01, "positions": 3},
        loading={"control": "separation", "value": 0.19, "tangential_load": 0.1},
        effects={"friction_coefficient": MU})
    positions, contacts = numbers(asperity, scene)
    assert len(positions) == 3
    for position, rows in zip(positions, contacts):
        assert position["tangential_load"] == pytest.approx(0.1, rel=1e-6)
        assert sum(row["shear_load"] for row in rows) == pytest.approx(0.1, rel=1e-6)
        assert sum(row["stick_area"] for row in rows) == pytest.approx(position["stick_area"])
        assert position["load"] * MU > 0.1 and 0 < position["stick_area"] < position["area"]
    assert len({position["tangential_displacement"] for position in positions}) == 3


def test_plasticity_unloads_elastically(asperity, tmp_path):
    """The second state is on the unloading branch: stiffer, so that the displacement is less."""
    load = float(loads(0.005).sum())
    loading = {"control": "load", "value": load, "tangential_load": 0.3 * MU * load}
    elastic, _ = caps(asperity, tmp_path, loading)
    plastic, rows = caps(asperity, tmp_path, loading, plasticity="on", plastic_yield_stress=5.0)
    assert plastic["tangential_load"] == pytest.approx(0.3 * MU * load, rel=1e-5)
    assert 0 < plastic["tangential_displacement"] < elastic["tangential_displacement"]
    assert plastic["tangential_stiffness"] > elastic["tangential_stiffness"]
    assert plastic["stick_area"] < plastic["area"]
