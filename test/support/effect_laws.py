"""Laws that the results of a scene with effects keep, and that need no other truth."""

from judge import check, number
from surfaces_csv import Solved

# Residual of the gaps on elements over their tolerance.
RESIDUAL, ROUNDING = 0.004, 1e-9


def keeps_laws(solved: Solved, groups):
    """An assertion for the first law that is broken."""
    mu = groups["effects"].get("friction_coefficient", 0.0)
    rows = {}
    for row in solved.contacts:
        rows.setdefault(int(row["position"]), []).append(row)
    for row in solved.positions:
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
