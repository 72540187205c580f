"""Runs a scene with effects and holds its results against laws that need no other truth."""

from surfaces_csv import Solved, solve

WORDS = ("interaction", "friction", "plasticity", "adhesion", "creep")
# Residual of the gaps on elements over their tolerance.
RESIDUAL, ROUNDING = 0.004, 1e-9


def run(asperity, path, folder, *options, curve=False):
    """Solve, within the two minutes that `solve` waits: results, or status 1 and one sentence,
    after the notes on the scene."""
    solved = solve(asperity, path, *options, folder=folder, curve=curve)
    assert solved.status in (0, 1), f"{path.name}: {solved.status} {solved.stderr}"
    if solved.status == 0:
        assert solved.positions
        assert "model: " in solved.stdout
    else:
        assert solved.stdout == "" and not solved.positions and not solved.contacts
        said = [line for line in solved.stderr.splitlines()
                if not line.startswith(f"{path}: note: ")]
        assert len(said) == 1 and said[0].startswith(f"{path}: ")
        assert len(said[0]) > len(str(path)) + 11
    return solved


def value(row, name):
    return float(row[name])


def keeps_laws(solved: Solved, groups):
    """Number of laws kept; an assertion for the first that is broken."""
    kept, mu = 0, groups["effects"].get("friction_coefficient", 0.0)
    rows = {}
    for row in solved.contacts:
        rows.setdefault(int(row["position"]), []).append(row)
    for row in (*solved.positions, *solved.contacts, *solved.curve):
        for name, cell in row.items():
            assert name in WORDS or abs(float(cell or 0)) < float("inf"), (name, cell)
    for row in solved.positions:
        where = f"position {row['position']}"
        last = max((int(c["step"]) for c in rows.get(int(row["position"]), [])), default=1)
        own = [c for c in rows.get(int(row["position"]), []) if int(c["step"]) == last]
        assert len(own) == int(row["contacts"]), where
        elements = tolerance_of_elements(row, groups["effects"])
        kept += total_laws(row, own, where, elements)
        kept += interaction_laws(row, own, where, elements)
        kept += friction_laws(row, own, where, mu)
    return kept


def close(a, b, size, share, what):
    assert abs(a - b) <= share * abs(size), f"{what}: {a!r} and {b!r}"


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
        cells = [value(c, name) for c in own]
        assert all(c >= 0.0 for c in cells), f"{where}: {name} {min(cells)}"
        close(sum(cells), value(row, name), sum(cells), 1e-12 * max(1, len(own)) ** 0.5,
              f"{where}: {name}")
    for name, cell in row.items():
        if name.endswith("_residual") and cell:
            assert 0.0 <= float(cell) <= max(1e-5, RESIDUAL * elements), f"{where}: {name} {cell}"
    return 4


def interaction_laws(row, own, where, elements):
    """Neighbours only ever take load away, from all and from each."""
    way = row.get("interaction", "off")
    if way == "off" or not own:
        return 0
    slack = ROUNDING + elements
    share, alone = value(row, "factor"), value(row, "alone_load")
    assert 0.0 < share <= 1.0 + slack, f"{where}: factor {share!r}"
    together = value(row, "frictionless_load" if row.get("friction") == "on" else "vertical_load")
    close(share * alone, together, together, 1e-12, f"{where}: factor times alone_load")
    for contact in own:
        assert value(contact, "lowered") >= 0.0, where
        if row.get("friction", "off") == "off":
            assert value(contact, "vertical_load") <= \
                value(contact, "alone_load") + slack * alone, f"{where}: {contact}"
    return 3 + 2 * len(own)


def friction_laws(row, own, where, mu):
    """Coulomb's law, the balance in plan, and no load lost."""
    if row.get("friction", "off") != "on":
        return 0
    for contact in own:
        assert 0.0 <= value(contact, "tangential_load"), where
        assert value(contact, "tangential_load") <= mu * value(contact, "load") * (1 + 1e-12), where
        assert 0.0 <= value(contact, "slip_annulus") <= 1.0, where
    assert value(row, "vertical_load") >= value(row, "frictionless_load") * (1 - 1e-12), where
    size = sum(abs(value(c, "lateral_" + axis)) for c in own for axis in "xy")
    for axis in "xy":
        close(-sum(value(c, "lateral_" + axis) for c in own), value(row, "rig_force_" + axis),
              size, 1e-12, f"{where}: rig_force_{axis}")
    assert int(value(row, "sliding_contacts")) == \
        sum(int(value(c, "sliding")) for c in own), where
    return 4 + 3 * len(own)
