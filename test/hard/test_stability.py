"""docs/development/hard-cases.md, condition against error: a few cases of the figure."""

import pytest
from builds import build
from stability import ROUNDOFF, measured

# Says nothing about the build under test: the program is of the release build.
pytestmark = [pytest.mark.truth, pytest.mark.once]

CASES = ("penetration_1e-8", "radii_1e6", "sideways_load_20", "one_pair", "deck_one_pair")
ARITHMETICS = ("real64",)


@pytest.fixture(scope="module")
def errors():
    """Condition and error by case, arithmetic and formula."""
    program = build("release").parent.parent / "example" / "overlap_totals"
    rows = [line.split(",") for line in measured(program, CASES, ARITHMETICS)]
    # The original overlap may find no result.
    assert sum(row[3] == "stable" for row in rows) == len(CASES) * len(ARITHMETICS)
    return {(name, arithmetic, formula): (float(condition), float(error))
            for name, condition, arithmetic, formula, error in rows}


def test_the_stable_overlap_keeps_the_bound(errors):
    for (_, arithmetic, formula), (condition, error) in errors.items():
        if formula == "stable":
            assert error <= 8.5 * condition * ROUNDOFF[arithmetic]
    condition, error = errors["deck_one_pair", "real64", "stable"]
    assert 7.5 < error / (condition * ROUNDOFF["real64"]) < 8.5


def test_the_original_overlap_does_not(errors):
    for arithmetic in ARITHMETICS:
        condition, error = errors["radii_1e6", arithmetic, "original"]
        assert error > 1.0e7 * condition * ROUNDOFF[arithmetic]
        condition, error = errors["one_pair", arithmetic, "original"]
        assert error > 100 * condition * ROUNDOFF[arithmetic]
    # A given penetration: the problem is as sensitive as the formula.
    condition, error = errors["penetration_1e-8", "real64", "original"]
    assert 0.1 < error / (condition * ROUNDOFF["real64"]) < 10
