"""The tables of docs/reference that are made from the source: current, and complete."""

import csv

import pytest
from builds import ROOT
from constants_table import ROOMS, constants
from reference_tables import MADE, Reader, begin, inside, made, options
import accuracy_costs

pytestmark = pytest.mark.once
@pytest.mark.parametrize("name", MADE)
def test_a_table_is_current(name, asperity):
    """After a change of an option or a default in the source: make tables."""
    text = (ROOT / MADE[name][0]).read_text(encoding="utf-8")
    assert text.count(begin(name)) == 1
    assert inside(text, name)[1].strip("\n") == made(asperity, name), "run make tables"


@pytest.mark.parametrize("group, name, column, value, other", [
    ("motion", "positions", "default", "1", "3"), ("motion", "x_step", "default", "0", "1"),
    ("loading", "points", "default", "0", "2"), ("loading", "control", "default", "`'limit'`", "x"),
    ("surfaces", "map_level", "default of a free map", "`'plane'`", "`'mean'`"),
    ("surfaces", "map_level", "if periodic", "`'mean'`", "`'none'`"),
    ("tilt", "upper_slope", "default", "0, 0", "0.1, 0.1")])
def test_a_default_is_found(asperity, tmp_path, group, name, column, value, other):
    """Whether the page shows it or another value."""
    reader = Reader(asperity, tmp_path)
    assert reader.default(group, name, column, value) == value
    assert reader.default(group, name, column, other) == value


def test_a_default_that_is_not_found(asperity, tmp_path):
    """Slopes of a deck are no numbers that are tried: the page must have them."""
    reader = Reader(asperity, tmp_path)
    column = "default with a deck"
    assert reader.default("tilt", "upper_slope", column, "0.004, -0.00058") == "0.004, -0.00058"
    with pytest.raises(ValueError, match="upper_slope: default with a deck is not 0.004, 0"):
        reader.default("tilt", "upper_slope", column, "0.004, 0")


def test_costs_of_accuracy():
    """The table of the page is that of the kept measurement; three goals have an option."""
    page = accuracy_costs.PAGE.read_text(encoding="utf-8")
    shown = page.partition(accuracy_costs.BEGIN)[2].partition(accuracy_costs.END)[0]
    kept = accuracy_costs.KEPT.read_text(encoding="ascii")
    rows = list(accuracy_costs.advice(kept))
    assert shown.strip("\n").splitlines() == rows and len(rows) == 5
    assert len([word for word in page.split() if word.strip("|-:")]) <= 600


# Rooms whose comments are not written yet.
PENDING = ("circle_error", "resolved_answers", "interaction_estimate")


def test_fields_of_constants():
    """The comment of a constant of the solvers has a meaning and a source."""
    found = [one for room in ("grid", "joint") for one in constants(room)
             if one.file not in PENDING]
    assert len(found) > 15
    for one in found:
        assert one.source, one.name
        assert len(one.comment.split()) > 4, one.name


def test_tests_of_constants():
    """A test that a comment names was seen to fail with the constant changed."""
    path = ROOT / "reference_output/interaction/constants.csv"
    with open(path, encoding="utf-8", newline="") as file:
        rows = {row["constant"]: row for row in csv.DictReader(file)}
    found = [one for room in ROOMS for one in constants(room) if one.test]
    assert len(found) > 8
    for one in found:
        row = rows.get(f"{one.file}:{one.name}", {})
        assert row.get("test") == one.test and "seen" in (row["up"], row["down"]), \
            f"run tools/mutate.py --constants {one.file}:{one.name}"


def test_all_options_are_read():
    """An option with its value, one without, one whose line is too long, a meaning of two lines."""
    text = "  --a FILE  first\n            second\n  --bb      other\n  --ccc, -c, --d\n    last"
    assert options(text) == [("--a FILE", "first second"), ("--bb", "other"),
                             ("--ccc, -c, --d", "last")]
