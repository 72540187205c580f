"""Hard cases of interaction and friction: truths and laws."""

import math

import pytest
from boundary_equations import evaluate
from boundary_patch import Contact
from effect_cases import AUTO, BOUNDARY, COUPLED, THREE, combined, effect_cases
from friction_truth import closed_form
from judge import check, has_result, number, solved
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


# ---------------------------------------------------------------- laws that need no other truth

# Residual of the gaps on elements over their tolerance.
RESIDUAL, ROUNDING = 0.004, 1e-9


def keeps_laws(run, groups):
    """An assertion for the first law that is broken."""
    mu = groups["effects"].get("friction_coefficient", 0.0)
    rows = {}
    for row in run.contacts:
        rows.setdefault(int(row["position"]), []).append(row)
    for row in run.positions:
        where = f"position {row['position']}"
        last = max((int(c["step"]) for c in rows.get(int(row["position"]), [])), default=1)
        own = [c for c in rows.get(int(row["position"]), []) if int(c["step"]) == last]
        assert len(own) == int(row["contacts"]), where
        elements = tolerance_of_elements(row, groups["effects"])
        total_laws(row, own, where, elements)
        interaction_laws(row, own, where, elements)
        friction_laws(row, own, where, mu)


def tolerance_of_elements(row, effects):
    """Relative error of loads on elements: they press bodies without a ratio to Hertz' law."""
    if row.get("interaction", "off") in ("off", "coupled"):
        return 0.0
    if effects["interaction"] == "boundary":
        return effects.get("boundary_tolerance", 1e-3)
    return 0.25 * effects.get("tolerance", 0.01)


def total_laws(row, own, where, elements):
    """The totals are those of the contacts; a load is never negative."""
    for name in ("load", "vertical_load", "area", "projected_area"):
        cells = [number(c, name) for c in own]
        assert all(c >= 0.0 for c in cells), f"{where}: {name} {min(cells)}"
        check(f"{where}: {name}", number(row, name), sum(cells),
              1e-12 * max(1, len(own)) ** 0.5)
    for name, cell in row.items():
        if name.endswith("_residual") and cell:
            assert 0.0 <= float(cell) <= max(1e-5, RESIDUAL * elements), f"{where}: {name} {cell}"


def interaction_laws(row, own, where, elements):
    """Neighbours only ever take load away, from all and from each."""
    way = row.get("interaction", "off")
    if way == "off" or not own:
        return
    slack = ROUNDING + elements
    share, alone = number(row, "factor"), number(row, "alone_load")
    assert 0.0 < share <= 1.0 + slack, f"{where}: factor {share!r}"
    together = number(row, "frictionless_load" if row.get("friction") == "on" else "vertical_load")
    check(f"{where}: factor times alone_load", share * alone, together, 1e-12)
    for contact in own:
        assert number(contact, "lowered") >= 0.0, where
        if row.get("friction", "off") == "off":
            assert number(contact, "vertical_load") <= \
                number(contact, "alone_load") + slack * alone, f"{where}: {contact}"


def friction_laws(row, own, where, mu):
    """Coulomb's law, the balance in plan, and no load lost."""
    if row.get("friction", "off") != "on":
        return
    for contact in own:
        assert 0.0 <= number(contact, "tangential_load"), where
        assert number(contact, "tangential_load") <= \
            mu * number(contact, "load") * (1 + 1e-12), where
        assert 0.0 <= number(contact, "slip_annulus") <= 1.0, where
    assert number(row, "vertical_load") >= number(row, "frictionless_load") * (1 - 1e-12), where
    size = sum(abs(number(c, "lateral_" + axis)) for c in own for axis in "xy")
    for axis in "xy":
        check(f"{where}: rig_force_{axis}", number(row, "rig_force_" + axis),
              -sum(number(c, "lateral_" + axis) for c in own), 1e-12, scale=size)
    assert int(number(row, "sliding_contacts")) == \
        sum(int(number(c, "sliding")) for c in own), where


# ---------------------------------------------------------------- single truths

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
