"""The printed report against the digitised tables of the thesis, cell by cell."""

import subprocess

import numpy as np
import pytest

from cells_met import ILLEGIBLE, TABLES, digitised, printed_rows, report_of, table_of_cells
from printed_report import NotFound, Report

COMBINED_RADIUS = 0.635  # cm: two spheres of 1.27 cm
# One unit in the last place of a System/370 short number between 1 and 16: the size of the
# sphere centres' heights and of their distance, from which the original takes its overlap W.
UNIT = 16.0 ** -5


@pytest.fixture(scope="module", params=("ibm370", "real64"))
def arithmetic_and_report(request, asperity):
    return request.param, report_of(asperity, request.param)


def half_unit(text):
    """Half a unit in the last printed place."""
    return 0.5 * 10.0 ** -len(text.partition(".")[2])


def overlap_error(step):
    """Largest error of the original's W at a step of a position, cm (fault 3).

    W is RL + RU - SQRT(DIST**2 + Z**2): six operations on numbers of this size, each cut by up to
    a unit; and each step so far has cut up to a unit off the height of a centre.
    """
    return (6 + step) * UNIT


def approach_error(position):
    """Largest error of the original's approach at a position, cm (fault 2).

    Half a unit is cut off on average at each of about 16 steps of every position so far.
    """
    return 0.5 * UNIT * 16 * position


def tolerance(table, column, row, text, step, contacts):
    """How far real64 may be from the exact value behind the original's printed cell."""
    value = abs(float(text))
    if table == "VI":
        return approach_error(100) if row["quantity"] == "approach" else 2.0e-3 * value
    if not table.startswith("VII"):
        return 0.0
    if column == "approach":
        return approach_error(POSITION[table])
    area_error = np.pi * COMBINED_RADIUS * overlap_error(step)
    if column in ("area", "projected_area"):
        return contacts * area_error
    if column in ("load", "average_pressure", "maximum_pressure"):
        # Pressure goes with the root of W, load with its power 1.5. A total is dominated by its
        # larger contacts, so the error of the mean contact stands for all.
        area = row["area"] if row["area"] != ILLEGIBLE else row["projected_area"]
        power = 1.5 if column == "load" else 0.5
        return value * power * contacts * area_error / float(area) if float(area) > 0.0 else 0.0
    return 0.0


POSITION = {"VIIA": 13, "VIIB": 55, "VIIC": 56}


@pytest.mark.parametrize("table", TABLES)
def test_every_legible_cell(arithmetic_and_report, table, tally):
    arithmetic, report = arithmetic_and_report
    expected, found = digitised(table), printed_rows(report, table)
    assert len(found) == len(expected), f"Table {table}: rows printed and digitised"
    compared = met = exact = illegible = 0
    step, contacts = 1, 0
    wrong = []
    for number, (want, have) in enumerate(zip(expected, found), 1):
        for column, text in want.items():
            if column == "row":
                continue
            if column in ("kind", "model", "quantity"):
                assert have[column] == text, f"Table {table} row {number}"
                continue
            if text == ILLEGIBLE:
                illegible += 1
                continue
            printed = have.get(column, "")
            if text == "" and printed == "":
                continue
            compared += 1
            same = printed == text
            exact += same
            if not same and arithmetic != "ibm370" and "." in text and "." in printed:
                allowed = tolerance(table, column, want, text, step, max(contacts, 1))
                rounding = half_unit(printed) + half_unit(text)
                same = abs(float(printed) - float(text)) <= (allowed + rounding) * (1 + 1e-9)
            met += same
            if not same:
                wrong.append(f"row {number} {column}: printed {printed}, thesis {text}")
        if want.get("kind") == "total":
            step, contacts = step + 1, 0
        elif number < len(expected) and expected[number].get("kind") == "total":
            contacts = int(have["area_no"])
    tally.add(f"Table {table} {arithmetic}", compared, met, illegible)
    print(f"Table {table} {arithmetic}: {exact} of {compared} cells to the last digit")
    assert not wrong, f"Table {table}, {len(wrong)} cells: " + "; ".join(wrong[:10])


@pytest.mark.parametrize("table", ("VIIA", "VIIB", "VIIC"))
def test_displacement_of_contact_tables(arithmetic_and_report, table):
    _, report = arithmetic_and_report
    heading = {row["table"]: row for row in digitised("vii_headings")}[table]
    x, y = report.displacement(f"TABLE {table}")
    assert (x, y) == (heading["x_displacement"], heading["y_displacement"])


def test_rows_that_were_promised(asperity):
    """140 loaded rows, 51 total rows, 336 coordinates."""
    report = report_of(asperity, "ibm370")
    rows = [row for table in POSITION for row in report.contacts(f"TABLE {table}")]
    assert sum(row["kind"] == "total" for row in rows) == 51
    assert sum(row["kind"] == "contact" and row["average_pressure"] != "" for row in rows) == 140
    coordinates = [row for table in ("IIIA", "IIIB") for row in report.asperities(f"TABLE {table}")]
    assert 3 * len(coordinates) == 336


def test_page_breaks_are_the_scan_s(asperity):
    """A page of Table VII holds 21 lines; the scan shows where each of them begins."""
    report = report_of(asperity, "ibm370")
    pages = [page for page in report.pages if any("TABLE VII" in line for line in page)]
    first_cells = []
    for page in pages:
        rows = [line for line in page if line.rstrip().endswith("TOTAL") or
                (line[12:19].strip().startswith("0.") and line[16:19].strip())]
        first_cells.append(rows[0].split()[0])
        assert len(rows) <= 21, rows[0]
    assert first_cells == ["0.3353", "0.01996", "0.2909", "0.2838", "0.2779", "0.2852", "0.2816",
                           "0.2787", "0.05927", "0.2744", "0.12338"]


def test_a_missing_table_is_a_failure(asperity, root):
    done = subprocess.run([asperity, root / "data" / "thesis.deck", "--tables", "none"],
                          capture_output=True, text=True, timeout=60)
    with pytest.raises(NotFound):
        Report(done.stdout).contacts("TABLE VIIA")


def test_the_readme_counts_the_cells(asperity, root):
    """The README's table of cells met in each arithmetic is that of this build."""
    readme = (root / "README.md").read_text()
    for line in table_of_cells(asperity):
        assert line in readme, f"README.md has no line '{line}'"
