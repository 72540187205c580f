"""Numbers of other programs and of the closed forms of their suites (test/validation): each is met,
or missed for the reason that the page states."""

import importlib
import re

import make_page
import pytest

PAGE = make_page.PAGE.read_text(encoding="utf-8")


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("module, function", make_page.SUITES,
                         ids=[f"{module}-{function}" for module, function in make_page.SUITES])
def test_suite(module, function, package):
    """All numbers but those with a reason are met; the page has the counts and the reasons."""
    suite = make_page.run_suite(module, function)
    wrong = [row for row in suite.rows if row.met == bool(row.reason)]
    assert not wrong, wrong[:5]
    assert make_page.row_of(suite) in PAGE, make_page.row_of(suite)
    for line in make_page.misses_of(suite):
        assert line in PAGE


@pytest.mark.once
def test_number_of_comparisons():
    """At least 300 in all, by the page that the suites agree with."""
    row = next(line for line in PAGE.splitlines() if line.startswith("| all |"))
    compared, met, missed = map(int, re.findall(r"\d+", row))
    assert compared == met + missed and compared >= 300 and missed <= 0.02 * compared


@pytest.mark.once
def test_printed_digits(package):
    """A number is met to half a unit of its last printed digit, not beyond."""
    comparisons = importlib.import_module("comparisons")
    for text, digit in (("1720.", 1.0), ("7.258E-02", 1e-5), ("0.406012", 1e-6)):
        suite = comparisons.Suite("a suite", "a source")
        suite.printed("below", text, float(text) + 0.49 * digit)
        suite.printed("above", text, float(text) + 0.51 * digit)
        assert [row.met for row in suite.rows] == [True, False]
