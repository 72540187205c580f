"""The whole printed report as the digitised thesis has it: every line, every cell, in order.

Pages, headings and columns come from the FORMAT and WRITE statements of the listing, cells from the
printed tables. Nothing here runs the program.
"""

import functools
from dataclasses import dataclass

from digitised_tables import DATA, records
from listing_formats import lines_of_format

UNSETTLED = "?"
CONTACT = ("approach", "area_no", "x", "y", "upper", "lower", "area", "projected_area", "slope",
           "load", "average_pressure", "maximum_pressure", "limit_exceeded")
# Columns that a FORMAT of rows prints, as the WRITE statement has them.
ROWS = {"26": ("index", "x", "y", "height"), "13": CONTACT, "12": CONTACT[:10],
        "14": ("area", "projected_area", "load")}
MODEL = ("number", "summit_radius", "maximum_height", "elastic_modulus", "poissons_ratio",
         "maximum_stress")
# Quantities of Table VI that a FORMAT prints, each maximum, minimum, average.
QUANTITIES = {"41": ("total_load", "total_contact_area"), "42": ("contact_points", "approach"),
              "43": ("slope",), "46": ("total_area_difference",),
              "47": ("individual_area_difference",)}


@dataclass(frozen=True)
class Cell:
    """A digitised cell: where it stands, and what the thesis prints there."""

    table: str
    row: dict
    column: str
    number: int = 0   # of the row in its table, from 1
    step: int = 1     # of the approach in its position, from 1
    contacts: int = 1  # summed in the cell

    @property
    def text(self):
        return self.row[self.column]

    @property
    def place(self):
        return f"Table {self.table} row {self.number} {self.column}"


def digitised(name):
    """A file of the digitised thesis: rows as dictionaries."""
    return records(DATA / f"{name}.csv")


def formats():
    """FORMAT statements of the listing by number."""
    return {row["number"]: row["format"] for row in digitised("formats")}


def table_cells(table):
    """FORMAT number and cells of each row of Table III or VII."""
    rows = digitised(f"table_{table.lower()}")
    step, contacts = 1, 0
    for number, row in enumerate(rows, 1):
        if "kind" not in row:
            kind = "26"
        elif row["kind"] == "total":
            kind = "14"
        else:
            kind = "13" if row["average_pressure"] else "12"
            contacts = int(row["area_no"])
        total = kind == "14"
        yield kind, [Cell(table, row, column, number, step, contacts if total else 1)
                     for column in ROWS[kind]]
        step += total


def heading_cells(table):
    """Cells of the FORMATs that print no rows, in order; what a FORMAT prints twice comes twice."""
    cells = {}
    if table == "V":
        models = digitised("table_v")
        cells["18"] = [[Cell("V", row, column, number) for column in MODEL]
                       for number, row in enumerate(models, 1)]
        cells["20"] = [[Cell("V", row, "theta", number) for number, row in enumerate(models, 1)]]
    elif table == "VI":
        rows = {row["quantity"]: (number, row)
                for number, row in enumerate(digitised("table_vi"), 1)}
        for kind, quantities in QUANTITIES.items():
            cells[kind] = [[Cell("VI", rows[quantity][1], column, rows[quantity][0])
                            for quantity in quantities
                            for column in ("maximum", "minimum", "average")]]
    elif table.startswith("VII"):
        (row,) = [row for row in digitised("table_vii_headings") if row["table"] == table]
        cells["28"] = [[Cell(f"{table} heading", row, column)
                        for column in ("x_displacement", "y_displacement")]]
    return cells


@functools.cache
def printed_lines():
    """The report: for each line of print its Line and the cells in it."""
    return tuple(lines_of_pages(digitised("pages"), formats()))


def lines_of(statement, cells):
    """Each line that a WRITE statement prints, and its cells."""
    cells = iter(cells)
    for line in lines_of_format(statement):
        yield line, [next(cells) for _ in line.fields]


def lines_of_pages(pages, statements):
    """Page by page: headings, then the rows up to where the next page begins."""
    for page, following in zip(pages, pages[1:] + [{"table": ""}]):
        cells = heading_cells(page["table"])
        for kind in page["formats"].split():
            yield from lines_of(statements[kind], cells[kind].pop(0) if kind in cells else ())
        if page["first_row"]:
            last = int(following["first_row"]) - 1 if following["table"] == page["table"] else None
            rows = list(table_cells(page["table"]))[int(page["first_row"]) - 1:last]
            for kind, row in rows:
                yield from lines_of(statements[kind], row)


@functools.cache
def bounds():
    """What the thesis leaves open in each unsettled cell: lowest and highest printed number."""
    return {(row["table"].removeprefix("table_").upper(), int(row["row"]), row["column"]):
            (row["low"], row["high"]) for row in digitised("unsettled")}
