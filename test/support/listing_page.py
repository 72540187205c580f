"""The tables of reference_output/faults/listing_port_scan.md, between its markers.

    python test/support/listing_page.py EXECUTABLE

What a mended fault changes in print is the executable's; what was corrected in the scan, and why,
is that of reference_output/thesis.
"""

import re
import sys
from pathlib import Path

from digitised_tables import DATA, records
from fault_effects import DECIMALS, END, ROOT, TABLES, inside, names, printed_rows
from printed_report import Report

DOCUMENT = "reference_output/faults/listing_port_scan.md"
ARCHIVE = ROOT / "reference_output" / "thesis.ibm370.txt"
PLACES = ("displacement", "approach", "x", "y")


def begin(name):
    return f"<!-- {name}: made by test/support/listing_page.py -->"


def numbered():
    """Number of each fault that has a name, by docs/theory/faults.md."""
    page = (ROOT / "docs/theory/faults.md").read_text(encoding="utf-8")
    return {name: number for number, name in
            re.findall(r"^\| (\d+) \|.*\| `([a-z-]+)` \|$", page, re.MULTILINE)}


def number(text):
    """A printed cell as a number; a word is none."""
    return float(text) if re.fullmatch(r"-?\d*\.?\d*", text) and re.search(r"\d", text) else None


def of_table_vi(before, after):
    """Cells of Table VI that print otherwise, in words."""
    told = []
    for quantity in DECIMALS:
        old, new = before["TABLE VI", quantity], after["TABLE VI", quantity]
        told += [f"{quantity.replace('_', ' ')} {column} {old[column]} to {new[column]}"
                 for column in old if old[column] != new[column]]
    return "; ".join(told)


def of_table_vii(before, after, table):
    """By column: how many cells print otherwise and the largest change; rows of one report only."""
    columns, only = {}, 0
    for key in sorted({key for key in (*before, *after) if key[0] == table}, key=str):
        if key not in before or key not in after:
            only += 1
            continue
        for column, old in before[key].items():
            new = after[key][column]
            if old != new:
                change = columns.setdefault(column, [0, 0.0])
                change[0] += 1
                if None not in (number(old), number(new)):
                    change[1] = max(change[1], abs(number(new) - number(old)))
    told = [f"{column.replace('_', ' ')} {count}" + (f" (by {most:.5g} at most)" if most else "")
            for column, (count, most) in columns.items()]
    return "; ".join(told + [f"{only} rows in one of both reports only"] * bool(only))


def table_of_cells(asperity):
    """What each mended fault changes in print, table by table."""
    yield "| fault | table | printed numbers that are others without it |"
    yield "| --- | --- | --- |"
    before, by_name = printed_rows(asperity), numbered()
    for name in names(asperity):
        after = printed_rows(asperity, name)
        told = {"VI": of_table_vi(before, after)}
        told |= {table.removeprefix("TABLE "): of_table_vii(before, after, table)
                 for table in TABLES}
        told = {table: text for table, text in told.items() if text}
        for table, text in told.items():
            yield f"| {by_name[name]} `{name}` | {table} | {text} |"
        if not told:
            yield f"| {by_name[name]} `{name}` | - | none on this deck |"


def shown(text):
    return f"`{text}`" if text else "blank"


def name_of(table):
    """The printed table of a file."""
    return table.removeprefix("table_").upper().replace("VII_HEADINGS", "VII, headings")


def table_of_corrections(_):
    """Every cell that differs from the scan, by table and reason."""
    yield "| table | cells: row, column, scan, taken | evidence |"
    yield "| --- | --- | --- |"
    groups = {}
    for row in records(DATA / "corrections.csv"):
        column = row["column"].replace("_", " ")
        groups.setdefault((row["table"], row["reason"]), []).append(
            f"{row['row']} {column} {shown(row['scanned'])} {shown(row['corrected'])}")
    for (table, reason), cells in groups.items():
        yield f"| {name_of(table)} | {'; '.join(cells)} | {reason} |"


def table_of_unsettled(_):
    """Every cell that is not settled: its bounds, and what the port prints."""
    yield "| table | row | column | state | bounds of the evidence | the port prints |"
    yield "| --- | ---: | --- | --- | --- | --- |"
    report = Report(ARCHIVE.read_text(encoding="ascii"))
    for row in records(DATA / "unsettled.csv"):
        table = name_of(row["table"])
        printed = report.contacts(f"TABLE {table}")[int(row["row"]) - 1][row["column"]]
        yield f"| {table} | {row['row']} | {row['column'].replace('_', ' ')} | {row['state']} | " \
            f"{row['low']} to {row['high']} | {printed} |"


MADE = {"cells": table_of_cells, "corrections": table_of_corrections,
        "unsettled": table_of_unsettled}


def main(executable):
    path = ROOT / DOCUMENT
    for name, lines in MADE.items():
        before, _, after = inside(path.read_text(encoding="utf-8"), begin(name))
        table = "\n".join(lines(Path(executable).resolve()))
        path.write_text(f"{before}{begin(name)}\n{table}\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
