"""Damaged copies of the report are told from the thesis: the comparison sees what is printed."""

import os
import sys

import pytest

from cells_met import report_of
from report_comparison import Comparison
from programs import run_program
from report_damage import COPIES, KINDS, damaged_copies, passing_copies
from thesis_report import UNSETTLED, printed_lines

# Says nothing about the build under test.
pytestmark = pytest.mark.once


@pytest.mark.parametrize("arithmetic", ["ibm370", "real64"])
def test_damaged_copies_fail(asperity, arithmetic):
    """None may pass; in another arithmetic a last digit may change within the tolerance."""
    passing, copies = passing_copies(report_of(asperity, arithmetic), arithmetic)
    print(f"{arithmetic}: {len(passing)} of {copies} damaged copies pass")
    assert copies == COPIES
    if arithmetic != "ibm370":
        assert len(passing) <= 3
        passing = [name for name in passing if name != "change_digit"]
    assert not passing


def test_the_copies_are_the_same_in_every_run(asperity):
    report = report_of(asperity, "ibm370")
    copies = list(damaged_copies(report))
    assert copies == list(damaged_copies(report))
    assert {name for name, _ in copies} == {kind.__name__ for kind in KINDS}
    assert report not in [text for _, text in copies]


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


def test_the_comparison_needs_numpy_and_pytest_alone(asperity, root):
    """The printed tables and the archive are compared where no other package is installed."""
    folder = root / "test/regression"
    variables = {"ASPERITY_EXE": str(asperity), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
                 "ASPERITY_TALLY": os.devnull}
    done = run_program(
        sys.executable, root / "test/support/only_numpy.py", "-q", "--rootdir", root, "-k",
        "test_digitised or ibm370 or missing", folder / "test_digitised.py",
        folder / "test_report.py", cwd=root, variables=variables)
    assert "ibm370: cells exact" in done.stdout and " passed" in done.stdout
    # All that the two files and the archive's import.
    run_program(
        sys.executable, root / "test/support/only_numpy.py", "-q", "--rootdir", root,
        "--collect-only", folder / "test_archive.py", folder / "test_digitised_relations.py",
        cwd=root, variables=variables)
