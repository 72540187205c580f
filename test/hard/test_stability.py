"""docs/development/hard-cases.md, condition against error: a few cases of the figure."""

import pytest
from builds import build
from stability import ROUNDOFF, measured

# States nothing about the build under test: the program is of the release build.
pytestmark = [pytest.mark.truth, pytest.mark.once]

CASES = ("penetration_1e-8", "radii_1e6", "sideways_load_20", "one_pair", "deck_one_pair")


@pytest.fixture(scope="module")
def errors():
    """Condition and error by case, arithmetic and formula."""
    program = build("release").parent.parent / "example" / "overlap_totals"
    rows = [line.split(",") for line in measured(program, CASES)]
    # The original overlap may find no result.
    assert sum(row[3] == "stable" for row in rows) == len(CASES)
    return {(name, formula): (float(condition), float(error))
            for name, condition, _, formula, error in rows}


def test_the_stable_overlap_keeps_the_bound(errors):
    for (_, formula), (condition, error) in errors.items():
        if formula == "stable":
            assert error <= 8.5 * condition * ROUNDOFF["real64"]
    condition, error = errors["deck_one_pair", "stable"]
    assert 7.5 < error / (condition * ROUNDOFF["real64"]) < 8.5


def test_the_original_overlap_does_not(errors):
    for name, least in (("radii_1e6", 1.0e7), ("one_pair", 100)):
        condition, error = errors[name, "original"]
        assert error > least * condition * ROUNDOFF["real64"]
    # A given penetration: the problem is as sensitive as the formula.
    condition, error = errors["penetration_1e-8", "original"]
    assert 0.1 < error / (condition * ROUNDOFF["real64"]) < 10
