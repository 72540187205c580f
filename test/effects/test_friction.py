"""Friction as `asperity solve` does it, contact by contact, against friction_truth.py.

Two evaluations made apart: the superposition of Hertz states with mpmath (`closed_form`), and a row
of springs that touch, stick and slip one by one (`march`).
"""

from functools import cache

import mpmath
import numpy as np
import pytest

import friction_truth
from effect_runs import (CAP, COMBINED, MODULUS, RATIO, SHOWN, Sweeps, by_position,
                         effect_rows, place_of, total)
from judge import column, compare, solved
from surfaces_csv import write_csv_scene

KAPPA = 2 * (1 - RATIO) / (2 - RATIO)  # tangential over normal stiffness (Mindlin 1949)
# Of the loads, against closed_form; and of loads and slip annulus against 1000 springs.
EXACT, BY_SPRINGS, ANNULUS_BY_SPRINGS = 1e-13, 2e-6, 5e-3
# The annulus is a root of the overlap that sticks, which hangs on a difference of slopes.
EXACT_ANNULUS = 1e-9


@pytest.fixture(scope="module")
def sweeps(asperity, tmp_path_factory):
    return Sweeps(asperity, tmp_path_factory.mktemp("friction"))


@cache
def by_closed_form(upper, lower, distance, penetration, coefficient,
                   material=(MODULUS, RATIO, MODULUS, RATIO)):
    found = friction_truth.closed_form(upper, lower, distance, penetration, *material, coefficient,
                                       digits=20)
    return found, float(1 - found.stick_radius / found.contact_radius)


def numbers(row, *names):
    return [float(row[name]) for name in names]


def errors_of(row, place, truth, annulus):
    """Of one contact: the three forces over its normal load, the slip annulus, sliding or not."""
    along, up, x, y = numbers(row, "tangential_load", "vertical_load", "lateral_x", "lateral_y")
    normal = float(truth.normal)
    lateral = np.hypot(x - float(truth.lateral) * place.outward[0],
                       y - float(truth.lateral) * place.outward[1])
    forces = max(abs(float(row["load"]) - normal), abs(along - float(truth.tangential)),
                 abs(up - float(truth.vertical)), lateral) / normal
    return forces, abs(float(row["slip_annulus"]) - annulus), (
        float(row["sliding"]) == float(truth.sliding))


def against_closed_form(rows, coefficient, name, **more):
    """All rows against the closed form."""
    forces, annuli, agreed = [], [], 0
    for row in rows:
        place = place_of(row)
        truth, annulus = by_closed_form(place.upper_radius, place.lower_radius, place.distance,
                                        float(row["penetration"]), coefficient, **more)
        force, annulus, same = errors_of(row, place, truth, annulus)
        forces.append(force)
        annuli.append(annulus)
        agreed += same
    compare(f"friction: forces, {name}", forces, EXACT)
    compare(f"friction: slip annulus, {name}", annuli, EXACT_ANNULUS)
    assert agreed == len(rows)


@pytest.mark.truth
@pytest.mark.parametrize("coefficient", (0.05, 0.1, 0.5))
def test_every_contact_of_the_sweep(coefficient, sweeps):
    run = sweeps.solve(friction="on", friction_coefficient=coefficient)
    assert len(run.contacts) == len(sweeps.solve().contacts) > 200
    kinds = {"stick": 0, "part": 0, "slide": 0}
    for row in run.contacts:
        annulus = float(row["slip_annulus"])
        kinds["stick" if annulus == 0 else "slide" if annulus == 1 else "part"] += 1
    print(f"coefficient {coefficient}: {kinds}")
    assert (kinds["slide"] > 50) == (coefficient < 0.5) and kinds["stick"] > 30
    against_closed_form(run.contacts, coefficient, f"coefficient {coefficient}")


@pytest.mark.truth
def test_contacts_that_slip_in_part(sweeps):
    """The slope grows little while a pair closes: only a coefficient in a narrow band makes part of
    a contact slip. Against both truths."""
    rows = sweeps.solve().contacts
    forces, annuli = [], []
    for number in (1, 40, 80, 120, 160, 200):
        for share in (0.9995, 0.998, 0.9997):
            coefficient = share * KAPPA * float(rows[number]["slope"])
            position = int(rows[number]["position"])
            run = sweeps.solve(positions=1, x_first=position / 10, friction="on",
                               friction_coefficient=coefficient)
            against_closed_form(run.contacts, coefficient, "beside part slip")
            row = next(r for r in run.contacts if r["upper"] == rows[number]["upper"]
                       and r["lower"] == rows[number]["lower"])
            if not 0 < float(row["slip_annulus"]) < 1:
                continue
            place = place_of(row)
            truth = friction_truth.march(
                place.upper_radius, place.lower_radius, place.distance, float(row["penetration"]),
                MODULUS, RATIO, MODULUS, RATIO, coefficient, steps=1000)
            force, annulus, same = errors_of(row, place, truth,
                                             1 - truth.stick_radius / truth.contact_radius)
            assert same
            forces.append(force)
            annuli.append(annulus)
    assert len(forces) >= 8
    compare("friction: forces against springs", forces, BY_SPRINGS)
    compare("friction: slip annulus against springs", annuli, ANNULUS_BY_SPRINGS)


@pytest.mark.truth
def test_coefficient_without_bound(sweeps):
    """All sticks, and no coefficient above a certain one makes a difference."""
    huge = sweeps.solve(friction="on", friction_coefficient=1e300)
    for name in ("sliding", "slip_annulus"):
        assert column(huge.contacts, name).max() == 0.0
    assert column(huge.positions, "sliding_contacts").max() == 0.0
    for other in (10.0, 1e99, 1e308):
        assert sweeps.solve(friction="on", friction_coefficient=other).contacts == huge.contacts
    against_closed_form(huge.contacts, 10, "coefficient 1e300")
    # Walton 1978: T/N = kappa tan, with the slope at the end. The slope grows a little on the way.
    ratio = column(huge.contacts, "tangential_load") / column(huge.contacts, "load")
    slope = column(huge.contacts, "slope")
    compare("friction: stick against Walton's ratio", np.abs(ratio / (KAPPA * slope) - 1), 0.01)
    assert (ratio < KAPPA * slope).all()


def test_positions_are_sums_of_contacts(sweeps):
    """The rig holds the upper body with the opposite of all lateral forces and moments."""
    run = sweeps.solve(friction="on", friction_coefficient=0.1)
    worst = []
    for m, rows in by_position(run.contacts).items():
        x, y, up, fx, fy = (column(rows, name) for name in
                            ("x", "y", "vertical_load", "lateral_x", "lateral_y"))
        want = {"vertical_load": up.sum(), "rig_force_x": -fx.sum(), "rig_force_y": -fy.sum(),
                "rig_moment_x": -(y * up).sum(), "rig_moment_y": (x * up).sum(),
                "rig_moment_z": -(x * fy - y * fx).sum(),
                "sliding_contacts": total(rows, "sliding")}
        size = up.sum() * max(1.0, np.abs([x, y]).max())
        worst += [abs(float(run.positions[m - 1][name]) - value) / size
                  for name, value in want.items()]
    compare("friction: rig and sums", worst, 1e-13)
    assert column(run.positions, "sliding_contacts").max() > 2


def test_auto_simulates_friction_beyond_the_tolerance(sweeps):
    on = sweeps.solve(friction="on", friction_coefficient=0.1)
    off = sweeps.solve()
    for tolerance in (0.002, 0.01):
        auto = sweeps.solve(friction="auto", friction_coefficient=0.1, tolerance=tolerance)
        estimate = column(auto.positions, "friction_estimate")
        simulated = np.array([row["friction"] == "on" for row in auto.positions])
        assert (simulated == (estimate > tolerance)).all() and 5 < simulated.sum() < 95
        compare("friction: influence above the estimate",
               np.maximum(column(on.positions, "friction_influence") - estimate, 0), 1e-12)
        compare("friction: estimate beyond the influence",
               estimate / column(on.positions, "friction_influence") - 1, 0.02)
        compare("friction: vertical load, auto against on",
               np.abs(column(auto.positions, "vertical_load")
                      / column(on.positions, "vertical_load") - 1), tolerance)
        for row, full, free, there in zip(auto.positions, on.positions, off.positions, simulated):
            names = [name for name in (full if there else free)
                     if name not in (*SHOWN, "friction_estimate")]
            want = full if there else free
            assert {n: row[n] for n in names} == {n: want[n] for n in names}
        assert effect_rows(auto.stdout)["friction"]["simulated at"] == f"{simulated.sum()} of 100"


def test_unlike_materials(sweeps):
    """Mindlin's stiffness of unlike bodies."""
    material = {"elastic_modulus": (3.0e5, 1.1e5), "poisson_ratio": (0.2, 0.45)}
    run = sweeps.solve(material=material, positions=20, friction="on", friction_coefficient=0.1)
    against_closed_form(run.contacts, 0.1, "unlike materials", material=(3.0e5, 0.2, 1.1e5, 0.45))


@pytest.mark.truth
def test_neighbours_reduce_friction(sweeps):
    """With interaction, friction sees the loads that the neighbours leave."""
    coupled = sweeps.solve(interaction="coupled")
    both = sweeps.solve(interaction="coupled", friction="on", friction_coefficient=0.1)
    for free, row in zip(coupled.contacts, both.contacts, strict=True):
        assert all(free[name] == row[name] for name in ("penetration", "load", "lowered"))
    against_closed_form(both.contacts, 0.1, "lowered contacts")
    assert all(a["vertical_load"] == b["frictionless_load"]
               for a, b in zip(coupled.positions, both.positions))
    assert all(a["factor"] == b["factor"] for a, b in zip(coupled.positions, both.positions))
    alone = sweeps.solve(friction="on", friction_coefficient=0.1)
    less = column(both.positions, "rig_force_x") / column(alone.positions, "rig_force_x")
    print(f"rig force with interaction over without: {less.min():.2f} to {less.max():.2f}")
    assert "model: interaction coupled, friction on; " in both.stdout
    modes = {name: row["mode"] for name, row in effect_rows(both.stdout).items()}
    assert list(modes.items()) == [("interaction", "coupled"), ("friction", "on")]


@pytest.mark.truth
def test_friction_on_boundary_elements(sweeps):
    """Cells bring the vertical load of each contact. Friction goes on from it: T, N and the lateral
    force are in equilibrium with it."""
    run = sweeps.solve(positions=30, interaction="boundary", friction="on",
                       friction_coefficient=0.1)
    cells = sweeps.solve(positions=30, interaction="boundary")
    worst = []
    for row, free in zip(run.contacts, cells.contacts, strict=True):
        slope = float(row["slope"])
        sine, cosine = slope / np.hypot(1, slope), 1 / np.hypot(1, slope)
        vertical, along = float(free["vertical_load"]), float(row["tangential_load"])
        side = np.hypot(*numbers(row, "lateral_x", "lateral_y"))
        want = abs(vertical / cosine * sine - along * cosine)
        worst.append(max(abs(side - want), abs(float(row["vertical_load"]) - vertical
                                               - along * sine)) / vertical)
    compare("friction: equilibrium on cells", worst, 1e-10)


def test_one_contact_that_slips_in_part(asperity, tmp_path):
    """A deep pair, in the plane's other directions; both truths with many digits."""
    along = np.array([0.3, -0.4])
    distance, coefficient = 0.5, 0.14835
    touch = float(np.sqrt((2 * CAP) ** 2 - distance ** 2))
    level = 2 * CAP - touch  # heights of the summits over the reference planes, together
    scene = write_csv_scene(
        tmp_path, [(*along, level / 2, CAP)], [(0.0, 0.0, level / 2, CAP)],
        modulus=(MODULUS, MODULUS), ratio=(RATIO, RATIO),
        loading={"control": "approach", "value": -0.02},
        effects={"friction": "on", "friction_coefficient": coefficient})
    run = solved(asperity, scene)
    row = run.contacts[0]
    depth = float(row["penetration"])
    assert depth == pytest.approx(0.02, rel=1e-12)
    with mpmath.workdps(30):
        truth = friction_truth.closed_form(CAP, CAP, distance, depth, MODULUS, RATIO, MODULUS,
                                           RATIO, coefficient, digits=30)
    annulus = float(1 - truth.stick_radius / truth.contact_radius)
    assert 0.05 < annulus < 0.95
    side = along / distance * float(truth.lateral)
    want = [float(truth.tangential), float(truth.vertical), *side]
    have = numbers(row, "tangential_load", "vertical_load", "lateral_x", "lateral_y")
    compare("friction: one pair that slips in part",
           np.abs(np.array(have) - want) / float(truth.normal), EXACT)
    compare("friction: its slip annulus", [abs(float(row["slip_annulus"]) - annulus)], 1e-9)
    assert float(truth.normal) == pytest.approx(
        4 / 3 * COMBINED * np.sqrt(CAP / 2) * float(row["overlap"]) ** 1.5, rel=1e-12)
