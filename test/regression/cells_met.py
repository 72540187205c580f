"""How many printed cells of the thesis each arithmetic meets to the last digit.

As a script: cells_met.py EXECUTABLE prints the table of the README.
"""

import csv
import subprocess
import sys
from pathlib import Path

from printed_report import Report

ROOT = Path(__file__).resolve().parents[2]
TABLES = ("IIIA", "IIIB", "V", "VI", "VIIA", "VIIB", "VIIC")
ARITHMETICS = ("ibm370", "real32", "real64", "real128")
ILLEGIBLE = "?"
LABELS = ("row", "kind", "model", "quantity")


def digitised(table):
    with open(ROOT / "reference_output" / "thesis" / f"table_{table.lower()}.csv") as file:
        return list(csv.DictReader(file))


def printed_rows(report, table):
    if table.startswith("III"):
        return report.asperities(f"TABLE {table}")
    if table == "V":
        return report.models()
    if table == "VI":
        return report.variance()
    return report.contacts(f"TABLE {table}")


def report_of(asperity, arithmetic):
    done = subprocess.run([asperity, ROOT / "data" / "thesis.deck", "--arithmetic", arithmetic],
                          capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return Report(done.stdout)


def cells_met(report, table):
    """Cells compared, and met to the last digit. Rows are matched by their kind, in order."""
    compared = met = 0
    printed = {}
    for row in printed_rows(report, table):
        printed.setdefault(row.get("kind", ""), []).append(row)
    for want in digitised(table):
        rows = printed.get(want.get("kind", ""), [])
        have = rows.pop(0) if rows else {}
        for column, text in want.items():
            if column in LABELS or text == ILLEGIBLE or (text == "" and not have.get(column)):
                continue
            compared += 1
            met += have.get(column) == text
    return compared, met


def table_of_cells(asperity):
    """Lines of a Markdown table."""
    lines = ["| table | cells | " + " | ".join(ARITHMETICS) + " |",
             "| --- | ---: |" + " ---: |" * len(ARITHMETICS)]
    reports = [report_of(asperity, arithmetic) for arithmetic in ARITHMETICS]
    totals = [0] * (1 + len(ARITHMETICS))
    for table in TABLES:
        counts = [cells_met(report, table) for report in reports]
        row = [counts[0][0]] + [met for _, met in counts]
        totals = [a + b for a, b in zip(totals, row)]
        lines.append(f"| {table} | " + " | ".join(map(str, row)) + " |")
    lines.append("| all | " + " | ".join(map(str, totals)) + " |")
    return lines


if __name__ == "__main__":
    print("\n".join(table_of_cells(sys.argv[1])))
