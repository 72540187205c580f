"""The combined modulus given itself: results are those of two bodies that have it together."""

import math
import re

import numpy as np
import pytest

from ball_scenes import column
from programs import run_program
from surfaces_csv import solve, write_scene, write_surface

UPPER = [(0.0, 0.0, 0.10, 2.0), (3.0, 0.5, 0.12, 1.5), (5.0, 3.0, 0.09, 1.0)]
LOWER = [(0.1, 0.2, 0.10, 1.0), (3.2, 0.4, 0.08, 2.5), (5.0, 3.3, 0.11, 2.0)]
# 1/E = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.
BODIES = {"elastic_modulus": (2.0e5, 1.0e5), "poisson_ratio": (0.3, 0.25)}
COMBINED = 1 / ((1 - 0.3 ** 2) / 2.0e5 + (1 - 0.25 ** 2) / 1.0e5)
NUMBERS = ("separation", "load", "vertical_load", "area", "projected_area")


def scene(folder, name, material, **groups):
    return write_scene(folder / f"{name}.scene",
                       surfaces={"upper": write_surface(folder / "upper.csv", UPPER),
                                 "lower": write_surface(folder / "lower.csv", LOWER)},
                       material=material, **groups)


@pytest.mark.parametrize("loading", [{"control": "load", "value": 700.0},
                                     {"control": "approach", "value": 0.18}])
def test_of_bodies(asperity, tmp_path, loading):
    """A load depends on the modulus alone; COMBINED is rounded once, each result a few times."""
    found = [solve(asperity, scene(tmp_path, name, material, loading=loading)).positions[0]
             for name, material in (("bodies", BODIES), ("e", {"contact_modulus": COMBINED}))]
    pairs = np.array([[float(row[name]) for row in found] for name in NUMBERS])
    assert np.all(np.abs(pairs[:, 1] / pairs[:, 0] - 1) <= 2e-15), pairs


@pytest.mark.parametrize("effects", [
    {"interaction": "coupled"}, {"interaction": "boundary"},
    {"adhesion": "on", "work_of_adhesion": 0.05, "equilibrium_distance": 1e-6},
    {"creep": "on", "hold_time": 3.0, "relaxation_time": 1.0, "relaxed_modulus_ratio": 0.5}])
def test_effects(asperity, tmp_path, effects):
    """Effects that have the combined modulus alone give what they give with the two bodies."""
    loading = {"control": "approach", "value": 0.18}
    found = []
    for name, material in (("bodies", BODIES), ("e", {"contact_modulus": COMBINED})):
        run = solve(asperity, scene(tmp_path, name, material, loading=loading, effects=effects))
        assert run.status == 0, run.stderr
        found.append(np.concatenate([column(run.contacts, "load"), column(run.contacts, "area")]))
    assert np.allclose(found[0], found[1], rtol=1e-9, atol=0)


def test_deck(asperity, tmp_path, root):
    """Beside a deck it takes the place of the deck's own material."""
    surfaces = {"deck": str(root / "data" / "thesis.deck")}
    own = 1 / (2 * (1 - 0.42 ** 2) / 275760.0)
    loads = []
    for factor in (1, 2):
        path = write_scene(tmp_path / f"{factor}.scene", surfaces=surfaces,
                           material={"contact_modulus": factor * own},
                           loading={"control": "approach", "value": 0.28})
        loads.append(float(solve(asperity, path).positions[0]["load"]))
    path = write_scene(tmp_path / "deck.scene", surfaces=surfaces,
                       loading={"control": "approach", "value": 0.28})
    deck = float(solve(asperity, path).positions[0]["load"])
    assert deck > 0
    assert abs(loads[0] / deck - 1) < 4e-15
    assert abs(loads[1] / deck - 2) < 8e-15


def test_refusals(asperity, tmp_path):
    """One or the other; effects that need more than it state what."""
    for material, effects, expected in (
            ({"contact_modulus": 1.0, **BODIES}, {}, ("found beside contact_modulus",) * 2),
            ({"contact_modulus": 1.0, "poisson_ratio": (0.3, 0.3)}, {},
             ("found beside contact_modulus",)),
            ({"contact_modulus": 0.0}, {}, ("contact_modulus: found '0.0', expected",)),
            ({"contact_modulus": 1.0}, {"friction": "on", "friction_coefficient": 0.1},
             ("friction needs shear moduli",)),
            ({"contact_modulus": 1.0}, {"plasticity": "on", "plastic_yield_stress": 0.1},
             ("plasticity needs Poisson's ratio",))):
        run = solve(asperity, scene(tmp_path, "bad", material, effects=effects,
                                    loading={"control": "load", "value": 1.0}))
        lines = run.stderr.splitlines()
        assert run.status == 2
        assert len(lines) == len(expected), lines
        for line, text in zip(lines, expected, strict=True):
            assert text in line


@pytest.mark.parametrize("moduli, ratios, noted", [
    ((1.0, 2e5), (0.0, 0.0), True), ((2e5, 1.0), (0.0, 0.0), True), ((1.0, 1.0), (0.3, 0.3), False),
    ((1.0, 2e5), (0.5, 0.3), False), ((210e3, 70e3), (0.3, 0.33), True),
    ((210e3, 200e3), (0.3, 0.29), False), ((1.0, 1.0), (-0.5, 0.49), True)])
def test_unlike_bodies_are_noted(asperity, tmp_path, moduli, ratios, noted):
    """Dundurs' beta of shear moduli and Kolosov's constants: a note above 0.1, with and without
    friction, has the larger load of a contact circle without slip."""
    shear = [e / (2 * (1 + nu)) for e, nu in zip(moduli, ratios)]
    kolosov = [3 - 4 * nu for nu in ratios]
    beta = ((shear[0] * (kolosov[1] - 1) - shear[1] * (kolosov[0] - 1)) /
            (shear[0] * (kolosov[1] + 1) + shear[1] * (kolosov[0] + 1)))
    assert (abs(beta) > 0.1) == noted
    bodies = {"elastic_modulus": moduli, "poisson_ratio": ratios}
    for effects in ({}, {"friction_coefficient": 0.1}):
        path = scene(tmp_path, "unlike", bodies, effects=effects,
                     loading={"control": "compression", "value": 1e-4})
        done = run_program(asperity, "solve", path, "--quiet")
        found = re.search(r"note: unlike bodies, Dundurs' beta ([\d.]+): .* by ([\d.]+) %",
                          done.stderr)
        assert bool(found) == noted, done.stderr
        if noted:
            # A rigid sphere that sticks to a half-space: (1 - nu) ln(3 - 4 nu)/(1 - 2 nu), with the
            # nu of that beta.
            nu = (1 - 2 * abs(beta)) / (2 - 2 * abs(beta))
            share = (1 - nu) * math.log(3 - 4 * nu) / (1 - 2 * nu) - 1
            assert [*map(float, found.groups())] == pytest.approx(
                [abs(beta), 100 * share], abs=0.051)
    alone = scene(tmp_path, "alone", {"contact_modulus": COMBINED},
                  loading={"control": "compression", "value": 1e-4})
    assert "unlike" not in run_program(asperity, "solve", alone, "--quiet").stderr
