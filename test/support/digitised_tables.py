"""The digitised tables of the thesis: their cells, and what a printed number can stand for."""

import csv
from fractions import Fraction
from pathlib import Path

from csv_rows import records

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


def read(path):
    """Rows of a CSV file, header first."""
    with open(path, newline="", encoding="ascii") as file:
        return list(csv.reader(file))


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
