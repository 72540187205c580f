"""The digitised tables of the thesis agree with their scan, their README and the deck.

Nothing here runs the program.
"""

import re
from decimal import ROUND_HALF_DOWN, Decimal
from fractions import Fraction

import pytest

from digitised_tables import (DATA, DECK, ROWS, SUMMED, TABLES_VII, LABELS, approaches, interval,
                              loaded, read, records)

# States nothing about the build under test.
pytestmark = pytest.mark.once

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


def unsettled():
    """Cells that are not compared as text: why, and the bounds that the evidence leaves."""
    return {(entry["table"], entry["row"], entry["column"]): entry
            for entry in records(DATA / "unsettled.csv")}


def counts(table):
    """Total, as scanned, corrected, illegible, withdrawn, compared; then blank cells with text."""
    found = dict.fromkeys(("as scanned", "corrected", "illegible", "withdrawn", "blank"), 0)
    states = unsettled()
    pairs = zip(records(DATA / f"{table}.csv"), records(DATA / "scan" / f"{table}.csv"))
    for number, (printed, scanned) in enumerate(pairs, 1):
        for column in printed.keys() - set(LABELS):
            value, text = printed[column], scanned[column]
            if value == "":
                found["blank"] += text != ""
            elif value == "?":
                found[states[table, str(number), column]["state"]] += 1
            else:
                found["as scanned" if value == text else "corrected"] += 1
    blank = found.pop("blank")
    compared = found["as scanned"] + found["corrected"]
    return [sum(found.values()), *found.values(), compared, blank]


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


def test_every_unsettled_cell_has_its_bounds():
    """10 are illegible; 2 are legible in the scan and were withdrawn."""
    open_cells = {(table, str(number), column): row
                  for table in ROWS for number, row in enumerate(records(DATA / f"{table}.csv"), 1)
                  for column, cell in row.items() if cell == "?"}
    cells = unsettled()
    assert cells.keys() == open_cells.keys()
    states = [entry["state"] for entry in cells.values()]
    assert (states.count("illegible"), states.count("withdrawn"), len(states)) == (10, 2, 12)
    reasons = {(entry["table"], entry["row"], entry["column"]): entry
               for entry in records(DATA / "corrections.csv")}
    for key, entry in cells.items():
        reason = reasons[key]["reason"]
        assert entry["low"] in reason and entry["high"] in reason, key
        assert (entry["state"] == "withdrawn") == reason.startswith("withdrawn"), key
        last_place = Decimal(entry["high"]) - Decimal(entry["low"])
        assert last_place == Decimal(1).scaleb(last_place.as_tuple().exponent), key
        area, slope = open_cells[key]["area"], open_cells[key]["slope"]
        if entry["column"] == "projected_area" and "?" not in (area, slope):
            ratio = (1 + float(slope) ** 2) ** -0.5 if slope else 1.0
            for bound in (entry["low"], entry["high"]):
                assert abs(float(bound) - float(area) * ratio) < 1.1e-5, key


def test_withdrawn_cells_are_legible_in_the_scan():
    """The scan has the calculated area again, in row 21, too, where the total proves it wrong."""
    scanned = records(DATA / "scan" / "table_viia.csv")
    printed = records(DATA / "table_viia.csv")
    withdrawn = [key for key, entry in unsettled().items() if entry["state"] == "withdrawn"]
    assert withdrawn == [("table_viia", row, "projected_area") for row in ("19", "20")]
    for row in (19, 20):
        assert scanned[row - 1]["projected_area"] == scanned[row - 1]["area"] == "0.01796"
    assert scanned[20]["projected_area"] == scanned[20]["area"] == "0.01996"
    assert printed[20]["projected_area"] == "0.01995" == scanned[21]["projected_area"]


def test_number_of_rows_by_kind():
    rows = [r for table in TABLES_VII for r in records(DATA / f"{table}.csv")]
    assert sum(loaded(r) for r in rows) == 140
    assert sum(r["kind"] == "total" for r in rows) == 51
    assert sum(r["kind"] == "contact" for r in rows) == 152
    assert [len(approaches(table)) for table in TABLES_VII] == [15, 16, 20]


@pytest.mark.parametrize("table", TABLES_VII)
def test_numbers_have_the_printed_form(table):
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
