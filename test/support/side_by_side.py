"""Tables VI and VIIA to C, number by number: as scanned, as taken, as printed here.

As a script: side_by_side.py EXECUTABLE [TABLE ...] prints a line for each cell, and a count at the
end. A mark stands where the three are not the same.
"""

import sys
from collections import Counter

from cells_met import report_of
from digitised_tables import DATA, records
from thesis_report import UNSETTLED, bounds, printed_lines

TABLES = ("VI", "VIIA", "VIIB", "VIIC")
EQUAL, CORRECTED, NOT_SETTLED, DIFFERENT = (
    "the same in all three", "corrected on evidence of the thesis, and printed here so",
    "not settled by the thesis: printed here within its bounds", "different")
MARKS = {EQUAL: "", CORRECTED: "corrected", NOT_SETTLED: "not settled", DIFFERENT: "DIFFERENT"}


def scanned(table):
    """Rows of a table as the scan shows them."""
    return records(DATA / "scan" / f"table_{table.lower()}.csv")


def cells(report, tables=TABLES):
    """Place, scanned, taken and printed text, and how they agree, of each cell."""
    scans = {table: scanned(table) for table in tables}
    for (line, placed), printed in zip(printed_lines(), report.split("\n")):
        for field, cell in zip(line.fields, placed):
            if cell.table not in tables:
                continue
            scan = scans[cell.table][cell.number - 1][cell.column]
            ours = printed[field.first:field.last].strip()
            yield cell.place, scan, cell.text, ours, agreement(cell, scan, ours)


def agreement(cell, scan, ours):
    if cell.text == UNSETTLED:
        low, high = map(float, bounds()[cell.table, cell.number, cell.column])
        return NOT_SETTLED if low <= float(ours) <= high else DIFFERENT
    if ours != cell.text:
        return DIFFERENT
    return EQUAL if scan == cell.text else CORRECTED


def lines_of(report, tables=TABLES):
    """The table, and its count."""
    counts = Counter()
    yield f"{'cell':<42} {'scanned':>10} {'taken':>10} {'ours':>10}"
    for place, *texts, kind in cells(report, tables):
        counts[kind] += 1
        yield f"{place:<42} {texts[0]:>10} {texts[1]:>10} {texts[2]:>10} {MARKS[kind]}".rstrip()
    yield ""
    yield f"{counts.total()} cells:"
    for kind in MARKS:
        yield f"{counts[kind]:6} {kind}"


if __name__ == "__main__":
    print("\n".join(lines_of(report_of(sys.argv[1], "ibm370"), sys.argv[2:] or TABLES)))
