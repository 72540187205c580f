"""Hard cases of interaction and friction: truths, laws, and what must not change a result.

A case that the program does not master is marked with its fault and fails as expected; it fails
the tests when the program masters it and the mark is still there. The large cases take minutes:
slow_effects.py runs them.
"""

import math

import pytest
from boundary_equations import evaluate
from boundary_patch import Contact
from effect_cases import AUTO, BOUNDARY, COUPLED, THREE, WAYS, combined, effect_cases
from effect_laws import keeps_laws, run
from friction_truth import closed_form
from make_cases import write_effect_case, surface_writer
from surfaces_csv import Solved, write_csv_scene

CASES = {case.name: case for case in effect_cases()}
# Many cells: a steep contact is a long strip of them; the curve solves them fifty times.
LONG = ("slope_10_load_boundary", "curve_boundary")


def scene_of(case, root, folder):
    if case.large:
        folder.mkdir(exist_ok=True)
        return write_effect_case(folder, case, surface_writer(folder))
    return root / "data/hard/effects" / f"{case.name}.scene"


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=[pytest.mark.xfail(reason=case.open, strict=True)] * bool(case.open)
                 + [pytest.mark.long] * (name in LONG))
    for name, case in CASES.items() if not case.large])
def test_effect_case(name, asperity, root, tmp_path, tally):
    check(CASES[name], asperity, root, tmp_path, tally)


def check(case, asperity, root, folder, tally):
    solved = run(asperity, scene_of(case, root, folder), folder,
                 curve=case.name.startswith("curve"))
    if solved.status:
        assert case.refused and case.refused in solved.stderr, solved.stderr
        tally.add("hard cases of effects", 1, 1)
        return
    assert case.either or not case.refused, "a result for what no surfaces can do"
    kept = keeps_laws(solved, case.groups)
    for law in case.laws:
        kept += law(solved)
    if "mpmath" in case.truth:
        kept += meets_closed_form(solved, case)
    if solved.curve:
        loads = [float(row["load"]) for row in solved.curve]
        assert len(loads) >= 50 and loads == sorted(loads)
    tally.add("hard cases of effects", kept, kept)


def meets_closed_form(solved, case):
    """Every contact's loads against mpmath, at the penetration that the program found."""
    upper, lower, mu = case.upper[0], case.lower[0], case.groups["effects"]["friction_coefficient"]
    for row in solved.contacts:
        numbers = (upper[3], lower[3], upper[0] - lower[0], float(row["penetration"]),
                   case.modulus[0], case.ratio[0], case.modulus[1], case.ratio[1], mu)
        true = closed_form(*numbers)
        for name, wanted in (("load", true.normal), ("tangential_load", true.tangential),
                             ("vertical_load", true.vertical)):
            off = abs(float(row[name]) - wanted)
            assert off <= 1e-11 * abs(wanted), f"{name}: {row[name]} for {wanted}"
        # A difference of two large numbers in plan.
        assert abs(float(row["lateral_x"]) - true.lateral) <= 1e-11 * (
            true.normal + true.tangential)
        assert bool(float(row["sliding"])) == true.sliding
    assert solved.contacts
    return 5 * len(solved.contacts)


def test_interaction_does_not_know_the_material(asperity, root, tmp_path):
    factors = []
    for name in CASES:
        if name.startswith("interaction_poisson"):
            solved = run(asperity, root / "data/hard/effects" / f"{name}.scene", tmp_path)
            factors.append(float(solved.positions[0]["factor"]))
    assert len(factors) == 3
    assert max(factors) - min(factors) < 1e-12 < 1 - max(factors)


def test_three_contacts_against_the_independent_evaluation(asperity, tmp_path, tally):
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
        solved = run(asperity, path, tmp_path)
        assert int(solved.positions[0]["contacts"]) == 3
        off = abs(float(solved.positions[0]["factor"]) - true["factor"])
        print(f"{way}: factor {solved.positions[0]['factor']}, off by {off:.1e}")
        assert off <= allowed + true["uncertainty"]
        tally.add("hard cases of effects", 1, 1)


# ---------------------------------------------------------------- what must not matter

SLOPED = [(0.3, 0.0, 0.5, 1.0), (0.5, 0.2, 0.48, 0.8), (0.2, 0.35, 0.49, 1.2)], \
    [(0.0, 0.0, 0.5, 1.0), (0.4, 0.5, 0.5, 0.9)]
BASES = {way: {"interaction": way} for way in WAYS}
BASES["friction"] = {"friction": "on", "friction_coefficient": 0.2}
BASES["both"] = {**BASES["friction"], "interaction": COUPLED}
# What rounding may change: the cells' equations are solved to 1e-6, a path of `auto` likewise.
SHARE = {COUPLED: 1e-10, BOUNDARY: 4e-6, AUTO: 4e-6, "friction": 1e-12, "both": 1e-10}
LOADS = ("load", "vertical_load", "alone_load", "frictionless_load", "rig_force_x", "rig_force_y")
# Powers of the length by column; the rest has none.
POWERS = {"separation": 1, "compression": 1, "x": 1, "y": 1, "penetration": 1, "overlap": 1,
          "lowered": 1,
          "contact_radius": 1, "x_displacement": 1, "y_displacement": 1, "area": 2,
          "projected_area": 2, "tangential_load": 2, "lateral_x": 2, "lateral_y": 2,
          "rig_moment_x": 3, "rig_moment_y": 3, "rig_moment_z": 3, **dict.fromkeys(LOADS, 2)}


def solve_base(asperity, folder, name, key, upper, lower, scale=1.0, **other):
    groups = {"loading": {"control": "load", "value": 500.0 * scale * scale},
              "effects": BASES[key], **other}
    return run(asperity, write_csv_scene(folder, upper, lower, name, **groups), folder)


def scaled(rows, factor):
    return [tuple(c * factor for c in row) for row in rows]


@pytest.mark.parametrize("key", BASES)
@pytest.mark.parametrize("power", [20, -20, 3, 300])
def test_lengths_times_a_power_of_2(key, power, asperity, tmp_path, tally):
    """Bit for bit where the solver's own unit is a power of 16."""
    scale = 2.0 ** power
    base = solve_base(asperity, tmp_path, "base", key, *SLOPED)
    other = solve_base(asperity, tmp_path, "other", key, *(scaled(r, scale) for r in SLOPED),
                       scale=scale)
    assert base.status == other.status == 0, other.stderr
    compared = 0
    for a, b in zip((*base.positions, *base.contacts), (*other.positions, *other.contacts),
                    strict=True):
        for name, cell in a.items():
            if name in ("interaction", "friction") or not cell:
                assert b[name] == cell
                continue
            true = float(cell) * scale ** POWERS.get(name, 0)
            if power % 4 == 0:
                assert float(b[name]) == true, name
            elif name in LOADS:
                assert abs(float(b[name]) - true) <= SHARE[key] * abs(true) + 1e-9 * scale, name
            compared += 1
    tally.add("hard cases of effects", compared, compared)


@pytest.mark.parametrize("key", BASES)
@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_units_of_1e6(key, unit, asperity, tmp_path, tally):
    base = solve_base(asperity, tmp_path, "base", key, *SLOPED)
    other = solve_base(asperity, tmp_path, "other", key, *(scaled(r, unit) for r in SLOPED),
                       scale=unit)
    tally.add("hard cases of effects", *2 * (same_loads(base, other, key, unit),))


@pytest.mark.parametrize("key", BASES)
def test_surfaces_exchanged(key, asperity, tmp_path, tally):
    base = solve_base(asperity, tmp_path, "base", key, *SLOPED)
    groups = {"loading": {"control": "load", "value": 500.0}, "effects": BASES[key]}
    other = run(asperity, write_csv_scene(tmp_path, SLOPED[1], SLOPED[0], "other",
                                          modulus=(1.0e5, 2.0e5), ratio=(0.25, 0.3), **groups),
                tmp_path)
    tally.add("hard cases of effects", *2 * (same_loads(base, other, key, 1.0, sign=-1.0),))


@pytest.mark.parametrize("key", BASES)
def test_asperities_in_another_order(key, asperity, tmp_path, tally):
    base = solve_base(asperity, tmp_path, "base", key, *SLOPED)
    other = solve_base(asperity, tmp_path, "other", key, SLOPED[0][::-1], SLOPED[1][::-1])
    tally.add("hard cases of effects", *2 * (same_loads(base, other, key, 1.0),))


def same_loads(base, other, key, unit, sign=1.0):
    """Totals within rounding; forces in plan change their sign with the surfaces."""
    assert base.status == other.status == 0, base.stderr + other.stderr
    a, b = base.positions[0], other.positions[0]
    assert a["contacts"] == b["contacts"] and int(a["contacts"]) > 1
    size, compared = float(a["load"]), 0
    for name in LOADS:
        if name not in a:
            continue
        true = float(a[name]) * (sign if name.startswith("rig") else 1.0)
        assert abs(float(b[name]) / unit / unit - true) <= SHARE[key] * size, name
        compared += 1
    return compared


@pytest.mark.parametrize("key", BASES)
def test_two_runs_give_the_same_bytes(key, asperity, tmp_path):
    texts = []
    for name in ("one", "two"):
        folder = tmp_path / name
        folder.mkdir()
        solved = solve_base(asperity, folder, "same", key, *SLOPED)
        assert solved.status == 0
        texts.append([(path.name, path.read_bytes()) for path in sorted(folder.iterdir())]
                     + [solved.stdout.replace(str(folder), "")])
    assert texts[0] == texts[1]


def test_a_broken_law_is_seen():
    """The laws themselves: results that no surfaces give."""
    row = {"position": "1", "contacts": "1", "load": "1.0", "vertical_load": "1.0", "area": "1.0",
           "projected_area": "1.0", "interaction": "coupled", "factor": "1.1", "alone_load": "0.9",
           "interaction_residual": "0.0"}
    contact = {"position": "1", "step": "1", "load": "1.0", "vertical_load": "1.0", "area": "1.0",
               "projected_area": "1.0", "lowered": "0.0", "alone_load": "0.9"}
    for change in ({}, {"factor": "nan"}, {"load": "2.0"}, {"interaction_residual": "1.0"},
                   {"contacts": "2"}):
        with pytest.raises(AssertionError):
            keeps_laws(Solved(0, "", "", [{**row, **change}], [contact], []), {"effects": {}})
    good = {**row, "factor": "0.8", "alone_load": "1.25"}
    assert keeps_laws(Solved(0, "", "", [good], [{**contact, "alone_load": "1.25"}], []),
                      {"effects": {}})
