"""How many printed cells of the thesis each arithmetic meets to the last digit.

As a script: cells_met.py EXECUTABLE prints the table of docs/theory/original.md.
"""

import sys
from pathlib import Path

from programs import run_program
from report_comparison import EXACT, TOLERATED, Comparison

ROOT = Path(__file__).resolve().parents[2]
TABLES = ("IIIA", "IIIB", "V", "VI", "VIIA", "VIIB", "VIIC")
ARITHMETICS = ("ibm370", "real32", "real64", "real128")


def report_of(asperity, arithmetic, *options):
    """The printed report of the thesis deck."""
    done = run_program(asperity, ROOT / "data" / "thesis.deck", "--arithmetic", arithmetic,
                       *options, text=False)
    return done.stdout.decode("latin-1")


def table_of_cells(asperity):
    """Lines of a Markdown table."""
    lines = ["| table | values | " + " | ".join(ARITHMETICS) + " |",
             "|---|---:|" + "---:|" * len(ARITHMETICS)]
    compared = [Comparison(report_of(asperity, name), name) for name in ARITHMETICS]
    totals = [0] * (1 + len(ARITHMETICS))
    for table in TABLES:
        cells = sum(compared[0].compared[table, kind] for kind in (EXACT, TOLERATED))
        row = [cells] + [one.to_the_last_digit[table] for one in compared]
        totals = [a + b for a, b in zip(totals, row)]
        lines.append(f"| {table} | " + " | ".join(map(str, row)) + " |")
    lines.append("| all | " + " | ".join(map(str, totals)) + " |")
    return lines


if __name__ == "__main__":
    print("\n".join(table_of_cells(sys.argv[1])))
