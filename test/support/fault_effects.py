"""What each fault of the original does to each printed number of the thesis' deck.

    python test/support/fault_effects.py EXECUTABLE

writes the tables of reference_output/faults/effects.md between their markers, and
reference_output/faults/table_vi.csv. All numbers are those of the executable, which mends one
fault after the other with --fault-free; effects are Table VI mended less Table VI as printed.
"""

import csv
import functools
import io
import itertools
import re
import subprocess
import sys
from pathlib import Path

from printed_report import Report
from programs import run_program

ROOT = Path(__file__).resolve().parents[2]
DECK = ROOT / "data" / "thesis.deck"
ARCHIVE = ROOT / "reference_output" / "faults" / "table_vi.csv"
END = "<!-- end of what was made -->"
COLUMNS = ("maximum", "minimum", "average")
# Decimals that Table VI prints, by quantity.
DECIMALS = {"total_load": 0, "total_contact_area": 4, "contact_points": 0, "approach": 4,
            "slope": 3, "total_area_difference": 1, "individual_area_difference": 1}
TABLES = ("TABLE VIIA", "TABLE VIIB", "TABLE VIIC")
# What two faults together may come to less, in printed units, before it is worth a line.
WORTH_A_LINE = 0.05


def names(asperity):
    """Faults that can be mended, in the order of their numbers, as the program lists them."""
    told = subprocess.run([asperity, DECK, "--fault-free", "?"], capture_output=True, text=True,
                          check=False, timeout=60).stderr
    return re.search(r"expected (.*) or all", told)[1].split(", ")


@functools.cache
def variance(asperity, mended=(), arithmetic="ibm370", deck=DECK):
    """Table VI with all digits, by quantity and column, without some faults."""
    options = ["--fault-free", ",".join(mended)] if mended else []
    done = run_program(asperity, deck, "--arithmetic", arithmetic, *options, "--variance", "-")
    return {(row["quantity"], column): float(row[column])
            for row in csv.DictReader(io.StringIO(done.stdout)) for column in COLUMNS}


def effects(asperity, *mended):
    """What mending some faults together does to each cell."""
    printed, without = variance(asperity), variance(asperity, mended)
    return {cell: without[cell] - printed[cell] for cell in printed}


def printed_rows(asperity, *mended):
    """Rows of the printed tables VIIA to C by what names them, and of Table VI."""
    options = ["--fault-free", ",".join(mended)] if mended else []
    done = run_program(asperity, DECK, *options)
    report, rows = Report(done.stdout), {}
    for table in TABLES:
        step = 1
        for row in report.contacts(table):
            kind = row.pop("kind")
            pair = (row.pop("upper"), row.pop("lower")) if kind == "contact" else kind
            rows[table, step, pair] = row
            step += kind == "total"
    lines = [line for line in report.table("TABLE VI") if re.search(r"(\s+[\d.]+){3}\s*$", line)]
    for quantity, line in zip(DECIMALS, lines, strict=True):
        rows["TABLE VI", quantity] = dict(zip(COLUMNS, line.split()[-3:], strict=True))
    return rows


def changed(before, after, table):
    """Cells of a table that print otherwise; a row that only one of them has counts whole."""
    count = 0
    for key in {key for key in (*before, *after) if key[0] == table}:
        old, new = before.get(key, {}), after.get(key, {})
        count += sum(old.get(column) != new.get(column) for column in {*old, *new})
    return count


def shown(value, quantity, places=2):
    """An effect with two decimals more than the table prints; a dash when there is none."""
    return f"{value:+.{DECIMALS[quantity] + places}f}" if value else "-"


def active(single):
    return [name for name, effect in single.items() if any(effect.values())]


def label(cell):
    return " ".join(cell).replace("_", " ")


def table_of_effects(asperity):
    """Markdown: every fault and every cell of Table VI that changes, and how they add up."""
    single = {name: effects(asperity, name) for name in names(asperity)}
    printed, mended = variance(asperity), variance(asperity, ("all",))
    exact = variance(asperity, ("all",), "real128")
    some = active(single)
    yield "| cell | printed | " + " | ".join(f"`{name}`" for name in some) + \
        " | sum | all at once | not additive | mended | `real128` |"
    yield "| --- |" + " ---: |" * (len(some) + 6)
    for cell in printed:
        quantity, places = cell[0], DECIMALS[cell[0]]
        together = sum(single[name][cell] for name in some)
        whole = mended[cell] - printed[cell]
        if not any(single[name][cell] for name in some) and not whole:
            continue
        cells = [f"{printed[cell]:.{places + 2}f}",
                 *(shown(single[name][cell], quantity) for name in some),
                 shown(together, quantity), shown(whole, quantity),
                 shown(round(whole - together, places + 2), quantity),
                 f"{mended[cell]:.{places + 2}f}", f"{exact[cell]:.{places + 2}f}"]
        yield f"| {label(cell)} | " + " | ".join(cells) + " |"
    idle = [f"`{name}`" for name in single if name not in some]
    yield ""
    yield f"{', '.join(idle[:-1])} and {idle[-1]} change no cell of this deck."
    yield ""
    yield from pairs(asperity, single)


def pairs(asperity, single):
    """What two faults mended together do beyond the sum of both."""
    yield "| two faults together | cell | beyond their sum |"
    yield "| --- | --- | ---: |"
    for a, b in itertools.combinations(single, 2):
        both = effects(asperity, a, b)
        for cell, effect in both.items():
            beyond = effect - single[a][cell] - single[b][cell]
            if abs(beyond) >= WORTH_A_LINE * 10.0 ** -DECIMALS[cell[0]]:
                yield f"| `{a}`, `{b}` | {label(cell)} | {shown(beyond, cell[0])} |"


def table_of_prints(asperity):
    """Markdown: how many printed numbers each fault changes, by table."""
    before = printed_rows(asperity)
    tables = ("TABLE VI", *TABLES)
    count = [sum(len(row) for key, row in before.items() if key[0] == table) for table in tables]
    yield "| mended | " + " | ".join(f"{table.replace('TABLE ', '')}, of {number}"
                                     for table, number in zip(tables, count)) + " |"
    yield "| --- |" + " ---: |" * len(tables)
    for name in [*names(asperity), "all"]:
        after = printed_rows(asperity, name)
        yield f"| `{name}` | " + " | ".join(str(changed(before, after, table))
                                            for table in tables) + " |"


def archive(asperity):
    """Every fault and every cell of Table VI that changes, with all digits."""
    printed = variance(asperity)
    yield "mended,quantity,column,printed,mended_to,effect"
    for name in [*names(asperity), "all"]:
        mended = variance(asperity, (name,))
        for cell, value in printed.items():
            if mended[cell] != value:
                yield f"{name},{cell[0]},{cell[1]},{value!r},{mended[cell]!r}," \
                    f"{mended[cell] - value!r}"


DOCUMENT = "reference_output/faults/effects.md"
MADE = {"effects": table_of_effects, "prints": table_of_prints}


def begin(name):
    return f"<!-- {name}: made by test/support/fault_effects.py -->"


def inside(text, first):
    """What stands between a marker and the next end: before, inside, behind."""
    before, _, rest = text.partition(first)
    return before, *rest.partition(END)[::2]


def main(executable):
    asperity = Path(executable).resolve()
    path = ROOT / DOCUMENT
    for name, lines in MADE.items():
        before, _, after = inside(path.read_text(encoding="utf-8"), begin(name))
        table = "\n".join(lines(asperity))
        path.write_text(f"{before}{begin(name)}\n{table}\n{END}{after}", encoding="utf-8")
    ARCHIVE.write_text("\n".join(archive(asperity)) + "\n", encoding="ascii")


if __name__ == "__main__":
    main(*sys.argv[1:])
