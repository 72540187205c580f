"""The printed report against the thesis: every line, heading and cell, and nothing else."""

from collections import Counter

import pytest

from cells_met import ARITHMETICS, report_of, table_of_cells
from report_comparison import EXACT, LABELS, OPEN, TOLERATED, Comparison
from side_by_side import CORRECTED, DIFFERENT, NOT_SETTLED, TABLES, cells, lines_of
from thesis_report import UNSETTLED, digitised, printed_lines

LINES = 678
CELLS = 2582


@pytest.fixture(scope="module", params=ARITHMETICS)
def comparison(request, asperity):
    return Comparison(report_of(asperity, request.param), request.param)


def test_the_report_is_the_thesis_s(comparison):
    wrong = comparison.wrong
    assert not wrong, f"{len(wrong)} differences:\n" + "\n".join(wrong[:10])


def test_everything_was_compared(comparison, root, tally):
    """As many words and cells, as text and as numbers, as the README of the tables promises."""
    arithmetic, compared, met = comparison.arithmetic, comparison.compared, comparison.met
    tally.add(f"{arithmetic}: words of headings", compared[LABELS], met[LABELS])
    illegible = sum(cell["state"] == "illegible" for cell in digitised("unsettled"))
    counts = [compared[LABELS]]
    for kind in (EXACT, TOLERATED, OPEN):
        keys = [key for key in compared if key[1] == kind]
        counts.append(sum(compared[key] for key in keys))
        tally.add(f"{arithmetic}: cells {kind}", counts[-1], sum(met[key] for key in keys),
                  illegible if kind == EXACT else 0)
    name = "`ibm370`" if arithmetic == "ibm370" else "the others, each"
    readme = (root / "reference_output" / "thesis" / "README.md").read_text(encoding="utf-8")
    assert " | ".join(["", name, *map(str, counts), ""]).strip() in readme
    assert comparison.lines == LINES and sum(counts[1:]) == CELLS


def test_a_missing_table_is_a_failure(asperity):
    report = report_of(asperity, "ibm370", "--tables", "none")
    assert Comparison(report, "ibm370").wrong
    assert Comparison("", "ibm370").wrong


def test_the_page_counts_the_cells(asperity, root):
    """The page's table of cells met in each arithmetic is that of this build."""
    page = (root / "docs/theory/original.md").read_text()
    for line in table_of_cells(asperity):
        assert line in page, f"docs/theory/original.md has no line '{line}'"


@pytest.mark.once
@pytest.mark.long
def test_every_changed_character_is_seen(asperity):
    """Each character of print in turn; only in cells that the thesis leaves open may one pass."""
    passing = 0
    lines = report_of(asperity, "ibm370").split("\n")[:-1]
    for line, expected in zip(lines, printed_lines(), strict=True):
        can_pass = [field for field, cell in zip(expected[0].fields, expected[1])
                    if cell.text == UNSETTLED]
        assert not Comparison(line + "\n", "ibm370", [expected]).wrong
        for at, char in enumerate(line):
            new = str((int(char) + 1) % 10) if char.isdigit() else "X" if char != "X" else "Y"
            damaged = line[:at] + new + line[at + 1:] + "\n"
            if not Comparison(damaged, "ibm370", [expected]).wrong:
                assert any(field.first <= at < field.last for field in can_pass), damaged
                passing += 1
    # The last digit of such a cell, where the thesis allows the next one, too.
    assert passing <= 12


def test_side_by_side(asperity):
    """Each cell of Tables VI and VII once; corrected and open ones are those of the two lists."""
    report = report_of(asperity, "ibm370")
    found = list(cells(report))
    assert len({place for place, *_ in found}) == len(found)
    files = {f"table_{table.lower()}" for table in TABLES}
    corrections = [row for row in digitised("corrections") if row["table"] in files]
    taken = [row for row in corrections if row["corrected"] not in ("", UNSETTLED)]
    kinds = Counter(kind for *_, kind in found)
    assert kinds[CORRECTED] == len(taken)
    assert kinds[NOT_SETTLED] == len(digitised("unsettled"))
    assert kinds[DIFFERENT] == 0
    *_, total, _, _, _, different = lines_of(report)
    assert total == f"{len(found)} cells:" and different == f"     0 {DIFFERENT}"


def test_side_by_side_names_a_changed_cell(asperity):
    report = report_of(asperity, "ibm370")
    other = report.replace("(NT)     1438.", "(NT)     1439.")
    (changed,) = [cell for cell in cells(other) if cell[-1] == DIFFERENT]
    assert changed[:4] == ("Table VI row 1 maximum", "1438.", "1438.", "1439.")
