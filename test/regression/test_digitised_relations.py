"""The digitised tables of the thesis agree with themselves.

A printed number stands for an interval: half a unit in its last place either way. Every relation
is tested on these intervals, exactly, so no tolerance is chosen by hand. Nothing here runs the
program.
"""

from decimal import Decimal
from fractions import Fraction

import pytest

from digitised_tables import (DATA, SUMMED, TABLES_VII, approaches, interval, legible, loaded,
                              loaded_records, pressure, records)

# Says nothing about the build under test.
pytestmark = pytest.mark.once


def test_average_pressure_is_load_over_area():
    for where, record in loaded_records():
        area, load = interval(record["area"]), interval(record["load"])
        if area is None or load is None:
            continue
        if record["load"] == "0.":
            load = Fraction(0), Fraction(1, 2)
        low, high = pressure(record)
        assert low * area[0] <= load[1] and high * area[1] >= load[0], where


def test_maximum_pressure_is_one_and_a_half_times_the_average():
    for where, record in loaded_records():
        low, high = pressure(record)
        assert low <= high, where


def test_square_of_pressure_goes_with_area():
    """One factor, area over average pressure squared, serves every row (Hertz)."""
    bounds = []
    for where, record in loaded_records():
        area = interval(record["area"])
        if area:
            low, high = pressure(record)
            bounds.append((area[0] / high**2, area[1] / low**2, where))
    low, high = max(bounds), min(bounds, key=lambda b: b[1])
    assert low[0] <= high[1], (low[2], high[2])


def test_projected_area_follows_from_area_and_slope():
    for where, record in loaded_records():
        area, projected, slope = (interval(record[c]) for c in ("area", "projected_area", "slope"))
        if area and projected and slope:
            assert area[0] ** 2 <= projected[1] ** 2 * (1 + slope[1] ** 2), where
            assert area[1] ** 2 >= projected[0] ** 2 * (1 + slope[0] ** 2), where


@pytest.mark.parametrize("table", TABLES_VII)
def test_totals_are_sums(table):
    for contacts, total in approaches(table):
        bearing = [c for c in contacts if loaded(c)]
        for column in SUMMED:
            cells = [c[column] for c in contacts]
            if len(bearing) == 1:
                assert total[column] == bearing[0][column], (total["row"], column)
            elif legible(total[column]) and all(legible(cell) for cell in cells):
                parts = [interval(cell) for cell in cells]
                low, high = interval(total[column])
                assert sum(p[0] for p in parts) <= high, (total["row"], column)
                assert sum(p[1] for p in parts) >= low, (total["row"], column)


@pytest.mark.parametrize("table", TABLES_VII)
def test_approach_falls_by_a_step_or_to_a_new_contact(table):
    previous = None
    for contacts, _ in approaches(table):
        (approach,) = {Decimal(c["approach"]) for c in contacts}
        assert [c["area_no"] for c in contacts] == [str(i + 1) for i in range(len(contacts))]
        touching = [c for c in contacts if not loaded(c)]
        assert touching in ([], contacts[-1:])
        if previous is None:
            assert len(contacts) == 1 and touching
        elif touching:
            assert Decimal(0) < previous - approach <= Decimal("0.001")
        else:
            assert previous - approach == Decimal("0.001")
        previous = approach


@pytest.mark.parametrize("table", TABLES_VII)
def test_a_contact_keeps_its_place(table):
    seen = {}
    for contacts, _ in approaches(table):
        for contact in contacts:
            place = [contact[c] for c in ("x", "y", "upper", "lower")]
            first = seen.setdefault(contact["area_no"], {"place": place, "slope": "0"})
            assert place == first["place"], contact["row"]
            if legible(contact["slope"]):
                rise = Decimal(contact["slope"]) - Decimal(first["slope"])
                # It grows as the models draw nearer, by a unit or two of the last place.
                assert first["slope"] == "0" or 0 <= rise <= Decimal("0.002"), contact["row"]
                first["slope"] = contact["slope"]


@pytest.mark.parametrize("table", TABLES_VII)
def test_contacts_lie_midway_between_their_asperities(table):
    """Radii are equal. The lower y is mirrored about the model's width, 3.455 in."""
    upper = {r["index"]: r for r in records(DATA / "table_iiia.csv")}
    lower = {r["index"]: r for r in records(DATA / "table_iiib.csv")}
    heading = records(DATA / "table_vii_headings.csv")[TABLES_VII.index(table)]
    assert heading["table"] == table.removeprefix("table_").upper()
    assert heading["y_displacement"] == "0.0"
    width = Fraction("3.455") * Fraction("2.54")
    for contacts, _ in approaches(table):
        for contact in contacts:
            above, below = upper[contact["upper"]], lower[contact["lower"]]
            shift, x_above, x_below, x = (
                interval(cell)
                for cell in (heading["x_displacement"], above["x"], below["x"], contact["x"])
            )
            for i, j in ((0, 1), (1, 0)):
                sign = 1 if i == 0 else -1
                assert sign * (shift[i] + x_above[i] + x_below[i] - 2 * x[j]) <= 0, contact["row"]
                y = interval(above["y"])[i] + width - interval(below["y"])[j]
                assert sign * (y - 2 * interval(contact["y"])[j]) <= 0, contact["row"]


@pytest.mark.parametrize("table", TABLES_VII)
def test_only_the_last_approach_exceeds_the_limit(table):
    groups = approaches(table)
    words = [{c["limit_exceeded"] for c in contacts if loaded(c)} for contacts, _ in groups]
    assert all(word <= {"NO"} for word in words[:-1])
    assert "YES" in words[-1]


def test_limit_is_a_load():
    """The least total load of Table VI is that of one contact at the limit."""
    least = {r["quantity"]: r["minimum"] for r in records(DATA / "table_vi.csv")}["total_load"]
    for where, record in loaded_records():
        over = Fraction(record["load"]) >= Fraction(least)
        assert record["limit_exceeded"] == ("YES" if over else "NO"), where


def test_table_vi_agrees_with_table_viic():
    """Its largest load, area and number of contacts are those that end Table VIIC."""
    contacts, total = approaches("table_viic")[-1]
    most = {r["quantity"]: r["maximum"] for r in records(DATA / "table_vi.csv")}
    assert most["total_load"] == total["load"]
    assert Decimal(most["total_contact_area"]) == Decimal(total["area"])
    assert most["contact_points"] == str(len(contacts))
