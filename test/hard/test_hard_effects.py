"""Hard cases of interaction and friction: truths and laws."""

import math

import pytest
from boundary_equations import evaluate
from boundary_patch import Contact
from effect_cases import AUTO, BOUNDARY, COUPLED, THREE, combined, effect_cases
from effect_laws import keeps_laws
from friction_truth import closed_form
from judge import check, has_result, solved
from surfaces_csv import solve, write_csv_scene

CASES = {case.name: case for case in effect_cases()}
# Many cells: a steep contact is a long strip of them; the curve solves them fifty times.
LONG = ("slope_10_load_boundary", "curve_boundary")


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=[pytest.mark.long] * (name in LONG)) for name in CASES])
def test_effect_case(name, asperity, root, tmp_path):
    case = CASES[name]
    scene = root / "data/hard/effects" / f"{name}.scene"
    run = solve(asperity, scene, folder=tmp_path, curve=name.startswith("curve"))
    if not has_result(run):
        assert case.refused and case.refused in run.stderr, run.stderr
        return
    assert case.either or not case.refused, "a result for what no surfaces can do"
    keeps_laws(run, case.groups)
    for law in case.laws:
        law(run)
    if "mpmath" in case.truth:
        meets_closed_form(run, case)
    if run.curve:
        loads = [float(row["load"]) for row in run.curve]
        assert len(loads) >= 50 and loads == sorted(loads)


def meets_closed_form(run, case):
    """Every contact's loads against mpmath, at the penetration that the program found."""
    upper, lower, mu = case.upper[0], case.lower[0], case.groups["effects"]["friction_coefficient"]
    for row in run.contacts:
        numbers = (upper[3], lower[3], upper[0] - lower[0], float(row["penetration"]),
                   case.modulus[0], case.ratio[0], case.modulus[1], case.ratio[1], mu)
        true = closed_form(*numbers)
        for name, wanted in (("load", true.normal), ("tangential_load", true.tangential),
                             ("vertical_load", true.vertical)):
            check(name, float(row[name]), float(wanted), 1e-11)
        # A difference of two large numbers in plan.
        check("lateral_x", float(row["lateral_x"]), float(true.lateral), 1e-11,
              scale=float(true.normal + true.tangential))
        assert bool(float(row["sliding"])) == true.sliding
    assert run.contacts


def test_interaction_does_not_depend_on_the_material(asperity, root, tmp_path):
    factors = []
    for name in CASES:
        if name.startswith("interaction_poisson"):
            run = solved(asperity, root / "data/hard/effects" / f"{name}.scene", folder=tmp_path)
            factors.append(float(run.positions[0]["factor"]))
    assert len(factors) == 3
    assert max(factors) - min(factors) < 1e-12 < 1 - max(factors)


@pytest.mark.truth
def test_three_contacts_against_the_independent_evaluation(asperity, tmp_path):
    lower = [(0.0, 0.0, 0.0, 500.0)]
    end = 0.4995
    contacts = []
    for x, y, height, radius in THREE[0]:
        # Heights of the centres: height - radius; the lower sphere is not flat at a distance.
        s = radius + lower[0][3]
        rise = math.sqrt(s * s - x * x - y * y)
        centres = end - (height - radius) - (0.0 - lower[0][3])
        contacts.append(Contact(x, y, radius, 0.0, 0.0, lower[0][3], rise - centres))
    true = evaluate(contacts, combined(), ("4", "6"))
    for way, allowed in ((COUPLED, 0.02), (BOUNDARY, 1e-3), (AUTO, 0.01)):
        path = write_csv_scene(tmp_path, THREE[0], lower, way,
                               loading={"control": "approach", "value": end},
                               effects={"interaction": way})
        row = solved(asperity, path).positions[0]
        assert int(row["contacts"]) == 3
        check(f"{way}: factor", float(row["factor"]), true["factor"], allowed, true["uncertainty"],
              scale=1.0)
