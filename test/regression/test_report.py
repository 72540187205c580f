"""The printed report against the thesis: every line, heading and cell, and nothing else."""

import pytest

from cells_met import ARITHMETICS, report_of, table_of_cells
from report_comparison import EXACT, LABELS, OPEN, TOLERATED, Comparison

LINES = 678
# Words of headings, units and row labels; the same in every arithmetic.
WORDS = 627
# Cells by kind of comparison: 2564 of the tables and 6 displacements, and 12 that stay open.
CELLS = {"ibm370": {EXACT: 2570, TOLERATED: 0, OPEN: 12}}
IEEE_CELLS = {EXACT: 771, TOLERATED: 1799, OPEN: 12}


@pytest.fixture(scope="module", params=ARITHMETICS)
def comparison(request, asperity):
    return Comparison(report_of(asperity, request.param), request.param)


def test_the_report_is_the_thesis_s(comparison):
    wrong = comparison.wrong
    assert not wrong, f"{len(wrong)} differences:\n" + "\n".join(wrong[:10])


def test_everything_was_compared(comparison, tally):
    """Each cell once, as text or as a number: what is not compared is missed here."""
    arithmetic, compared, met = comparison.arithmetic, comparison.compared, comparison.met
    assert (comparison.lines, compared[LABELS]) == (LINES, WORDS)
    tally.add(f"{arithmetic}: words of headings", compared[LABELS], met[LABELS])
    cells = {}
    for kind in (EXACT, TOLERATED, OPEN):
        keys = [key for key in compared if key[1] == kind]
        cells[kind] = sum(compared[key] for key in keys)
        tally.add(f"{arithmetic}: cells {kind}", cells[kind], sum(met[key] for key in keys))
    assert cells == CELLS.get(arithmetic, IEEE_CELLS)
    assert sum(cells.values()) == sum(CELLS["ibm370"].values())


def test_a_missing_table_is_a_failure(asperity):
    report = report_of(asperity, "ibm370", "--tables", "none")
    assert Comparison(report, "ibm370").wrong
    assert Comparison("", "ibm370").wrong


def test_the_readme_counts_the_cells(asperity, root):
    """The README's table of cells met in each arithmetic is that of this build."""
    readme = (root / "README.md").read_text()
    for line in table_of_cells(asperity):
        assert line in readme, f"README.md has no line '{line}'"
