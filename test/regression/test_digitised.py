"""The digitised tables of the thesis agree with themselves, with their scan and with the deck.

A printed number stands for an interval: half a unit in its last place either way. Every relation
is tested on these intervals, exactly, so no tolerance is chosen by hand. Nothing here runs the
program.
"""

import csv
import re
from decimal import ROUND_HALF_DOWN, Decimal
from fractions import Fraction
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "reference_output" / "thesis"
DECK = ROOT / "data" / "thesis.deck"

ROWS = {
    "table_iiia": 37,
    "table_iiib": 75,
    "table_v": 2,
    "table_vi": 7,
    "table_vii_headings": 3,
    "table_viia": 30,
    "table_viib": 49,
    "table_viic": 124,
}
TABLES_VII = ("table_viia", "table_viib", "table_viic")
LABELS = ("row", "kind", "model", "quantity", "table")
SUMMED = ("area", "projected_area", "load")

INDEX = r"\d+"
LENGTH = r"\d+\.\d{3}"
AREA = r"0\.0|0\.\d{5}"
PRESSURE = r"\d+\."
FORMS_VII = {
    "approach": r"0\.\d{4}",
    "area_no": INDEX,
    "x": LENGTH,
    "y": LENGTH,
    "upper": INDEX,
    "lower": INDEX,
    "area": AREA,
    "projected_area": AREA,
    "slope": r"0\.\d{3}",
    "load": PRESSURE,
    "average_pressure": PRESSURE,
    "maximum_pressure": PRESSURE,
    "limit_exceeded": "NO|YES",
}


def read(path):
    """Rows of a CSV file, header first."""
    with open(path, newline="", encoding="ascii") as file:
        return list(csv.reader(file))


def records(path):
    """Rows of a CSV file as dictionaries."""
    with open(path, newline="", encoding="ascii") as file:
        return list(csv.DictReader(file))


def legible(cell):
    return cell not in ("", "?")


def interval(cell):
    """What a printed number can stand for; nothing for an illegible one; an exact zero is exact."""
    if not legible(cell):
        return None
    if cell in ("0.0", "0."):
        return Fraction(0), Fraction(0)
    half = Fraction(1, 2 * 10 ** len(cell.partition(".")[2]))
    return Fraction(cell) - half, Fraction(cell) + half


def pressure(record):
    """Average pressure bounded by both printed pressures."""
    average = interval(record["average_pressure"])
    maximum = interval(record["maximum_pressure"])
    bounds = [b for b in (average, maximum and tuple(m / Fraction(3, 2) for m in maximum)) if b]
    return max(b[0] for b in bounds), min(b[1] for b in bounds)


def loaded(record):
    return record["kind"] == "contact" and record["average_pressure"] != ""


def approaches(table):
    """The contacts of each approach with the total that closes them."""
    contacts, groups = [], []
    for record in records(DATA / f"{table}.csv"):
        if record["kind"] == "contact":
            contacts.append(record)
        else:
            groups.append((contacts, record))
            contacts = []
    assert not contacts, "contacts without a total at the end"
    return groups


def loaded_records():
    return [
        (f"{table} row {record['row']}", record)
        for table in TABLES_VII
        for record in records(DATA / f"{table}.csv")
        if loaded(record)
    ]


@pytest.mark.parametrize("table", ROWS)
def test_scan_and_table_have_the_same_shape(table):
    printed, scanned = read(DATA / f"{table}.csv"), read(DATA / "scan" / f"{table}.csv")
    assert printed[0] == scanned[0]
    assert len(printed) == len(scanned) == ROWS[table] + 1
    assert {len(row) for row in printed + scanned} == {len(printed[0])}
    labels = [i for i, name in enumerate(printed[0]) if name in LABELS]
    assert [[r[i] for i in labels] for r in printed] == [[r[i] for i in labels] for r in scanned]


def test_no_other_table_is_kept():
    for folder in (DATA, DATA / "scan"):
        assert {p.stem for p in folder.glob("table_*.csv")} == set(ROWS)


def test_every_difference_is_recorded_once_and_nothing_else():
    found = []
    for table in ROWS:
        printed, scanned = read(DATA / f"{table}.csv"), read(DATA / "scan" / f"{table}.csv")
        for number, (new, old) in enumerate(zip(printed[1:], scanned[1:]), 1):
            for column, value, text in zip(printed[0], new, old):
                if value != text:
                    found.append((table, str(number), column, text, value))
    listed = records(DATA / "corrections.csv")
    assert all(entry["reason"].strip() for entry in listed)
    keys = ("table", "row", "column", "scanned", "corrected")
    assert sorted(tuple(entry[key] for key in keys) for entry in listed) == sorted(found)


def test_no_cell_of_the_scan_is_marked_illegible():
    for table in ROWS:
        assert "?" not in [cell for row in read(DATA / "scan" / f"{table}.csv") for cell in row]


def counts(table):
    """Total, as scanned, corrected, illegible, compared; then blank cells with text in the scan."""
    as_scanned = corrected = illegible = blank = 0
    pairs = zip(records(DATA / f"{table}.csv"), records(DATA / "scan" / f"{table}.csv"))
    for printed, scanned in pairs:
        for column in printed.keys() - set(LABELS):
            value, text = printed[column], scanned[column]
            if value == "":
                blank += text != ""
            elif value == "?":
                illegible += 1
            elif value == text:
                as_scanned += 1
            else:
                corrected += 1
    total = as_scanned + corrected + illegible
    return [total, as_scanned, corrected, illegible, total - illegible, blank]


def test_readme_counts_are_those_of_the_files():
    stated = {}
    for line in (DATA / "README.md").read_text(encoding="utf-8").splitlines():
        match = re.fullmatch(r"\| (\w+) ((?:\| \d+ )+)\|", line)
        if match:
            assert match[1] not in stated
            stated[match[1]] = [int(n) for n in re.findall(r"\d+", match[2])]
    computed = {table: counts(table) for table in ROWS}
    computed["all"] = [sum(column) for column in zip(*computed.values())]
    assert stated == computed


def test_number_of_rows_by_kind():
    rows = [r for table in TABLES_VII for r in records(DATA / f"{table}.csv")]
    assert sum(loaded(r) for r in rows) == 140
    assert sum(r["kind"] == "total" for r in rows) == 51
    assert sum(r["kind"] == "contact" for r in rows) == 152
    assert [len(approaches(table)) for table in TABLES_VII] == [15, 16, 20]


@pytest.mark.parametrize("table", TABLES_VII)
def test_cells_have_the_printed_form(table):
    for number, record in enumerate(records(DATA / f"{table}.csv"), 1):
        assert record["row"] == str(number)
        if record["kind"] == "total":
            columns = set(SUMMED)
        elif loaded(record):
            columns = set(FORMS_VII)
        else:
            columns = set(FORMS_VII) - {"average_pressure", "maximum_pressure", "limit_exceeded"}
            assert [record[c] for c in SUMMED] == ["0.0", "0.0", "0."], number
        for column, form in FORMS_VII.items():
            cell = record[column]
            if column not in columns:
                assert cell == "", (number, column)
            else:
                assert cell == "?" or re.fullmatch(form, cell), (number, column, cell)


def cards():
    text = DECK.read_bytes().decode("ascii")
    assert text.endswith("\n") and "\t" not in text and "\r" not in text
    return text.split("\n")[:-1]


def fields(card, *widths):
    assert len(card) == sum(widths)
    starts = [sum(widths[:i]) for i in range(len(widths))]
    return [card[start : start + width] for start, width in zip(starts, widths)]


def test_deck_gives_table_iii():
    deck = cards()
    assert len(deck) == 4 + 37 + 75
    printed = records(DATA / "table_iiia.csv") + records(DATA / "table_iiib.csv")
    assert [r["index"] for r in printed] == [str(i) for n in (37, 75) for i in range(1, n + 1)]
    for card, record in zip(deck[4:], printed):
        for field, decimals, name in zip(fields(card, 6, 6, 7), (3, 3, 4), ("x", "y", "height")):
            assert re.fullmatch(rf" *\d\.\d{{{decimals}}}", field), card
            # Half a unit goes down: the machine's 2.54 lies just below the decimal one.
            product = (Decimal(field.strip()) * Decimal("2.54")).quantize(
                Decimal(1).scaleb(-decimals), ROUND_HALF_DOWN
            )
            assert str(product) == record[name], (card, record)


def test_deck_gives_table_v():
    deck = cards()
    assert deck[0] == "NO  YES "
    models = [fields(deck[1], 5, 5, 5, 10, 5, 10), fields(deck[2], 5, 5, 5, 10, 5, 10, 7)]
    assert Decimal(models[1].pop().strip()) == Decimal("3.455")
    for model, record in zip(models, records(DATA / "table_v.csv")):
        number, *numbers = [field.strip() for field in model]
        radius, height, modulus, ratio, limit = [Fraction(n) for n in numbers]
        inch, psi = Fraction("2.54"), Fraction("0.6894")
        assert number == record["number"]
        for value, name in (
            (radius * inch, "summit_radius"),
            (height * inch, "maximum_height"),
            (modulus * psi, "elastic_modulus"),
            (ratio, "poissons_ratio"),
            (limit * psi, "maximum_stress"),
        ):
            low, high = interval(record[name])
            assert low <= value <= high, name
    angles = fields(deck[3], 8, 8, 7, 7)
    assert [Decimal(a.strip()) for a in angles] == [0, 0, 0, 0]
    assert [r["theta"] for r in records(DATA / "table_v.csv")] == ["0.0", "0.0"]


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
