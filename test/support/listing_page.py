"""The tables of reference_output/faults/listing_port_scan.md, between its markers.

    python test/support/listing_page.py

Corrections of the scan, and their reasons, are those of reference_output/thesis.
"""

from digitised_tables import DATA, ROOT, records
from printed_report import Report

DOCUMENT = "reference_output/faults/listing_port_scan.md"
ARCHIVE = ROOT / "reference_output" / "thesis.ibm370.txt"
END = "<!-- end of what was made -->"


def begin(name):
    return f"<!-- {name}: made by test/support/listing_page.py -->"


def inside(text, first):
    """What stands between a marker and the next end: before, inside, behind."""
    before, _, rest = text.partition(first)
    return before, *rest.partition(END)[::2]


def shown(text):
    return f"`{text}`" if text else "blank"


def name_of(table):
    """The printed table of a file."""
    return table.removeprefix("table_").upper().replace("VII_HEADINGS", "VII, headings")


def table_of_corrections():
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


def table_of_unsettled():
    """Every cell that is not settled: its bounds, and what the port prints."""
    yield "| table | row | column | state | bounds of the evidence | the port prints |"
    yield "| --- | ---: | --- | --- | --- | --- |"
    report = Report(ARCHIVE.read_text(encoding="ascii"))
    for row in records(DATA / "unsettled.csv"):
        table = name_of(row["table"])
        printed = report.contacts(f"TABLE {table}")[int(row["row"]) - 1][row["column"]]
        yield f"| {table} | {row['row']} | {row['column'].replace('_', ' ')} | {row['state']} | " \
            f"{row['low']} to {row['high']} | {printed} |"


MADE = {"corrections": table_of_corrections, "unsettled": table_of_unsettled}


def main():
    path = ROOT / DOCUMENT
    for name, lines in MADE.items():
        before, _, after = inside(path.read_text(encoding="utf-8"), begin(name))
        table = "\n".join(lines())
        path.write_text(f"{before}{begin(name)}\n{table}\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
