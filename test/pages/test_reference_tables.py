"""The tables of docs/reference that are made from the source: current, and complete."""

import accuracy_costs
import pytest
from builds import ROOT
from reference_tables import MADE, begin, inside, made

pytestmark = pytest.mark.pages


@pytest.mark.parametrize("name", MADE)
def test_a_table_is_current(name, asperity):
    """After a change of an option or a default in the source: make tables."""
    text = (ROOT / MADE[name][0]).read_text(encoding="utf-8")
    assert text.count(begin(name)) == 1
    assert inside(text, name)[1].strip("\n") == made(asperity, name), "run make tables"


def test_costs_of_accuracy():
    """The table of the page is that of the kept measurement, with each option on each kind of
    surface. No error is below that of the reference, which other options share where they agree
    with it."""
    page = accuracy_costs.PAGE.read_text(encoding="utf-8")
    shown = page.partition(accuracy_costs.BEGIN)[2].partition(accuracy_costs.END)[0]
    kept = accuracy_costs.KEPT.read_text(encoding="ascii")
    rows = list(accuracy_costs.advice(kept))
    assert shown.strip("\n").splitlines() == rows
    measured = {(kind, row["option"]) for row in accuracy_costs.rows_of(kept)
                for kind, scenes in accuracy_costs.KINDS.items()
                if row["scene"] in scenes and row["seconds"]}
    shown = {tuple(cell.strip() for cell in row.split("|")[1:3]) for row in rows[2:]}
    assert measured == shown and len(rows) == 2 + len(measured)
    for scene in accuracy_costs.SCENES:
        errors = [float(row["error"]) for row in accuracy_costs.rows_of(kept)
                  if row["scene"] == scene and row["seconds"]]
        assert errors.count(min(errors)) > 1, scene
    assert len([word for word in page.split() if word.strip("|-:")]) <= 600
