"""Dense scenes against the archived truth, in figures of the judge.

A scene is solved at its approach, where the vertical load is compared, and at the load that the
truth has there, where the approach is, as a share of the compression; the real area in both.
"""

from functools import cache, partial
from pathlib import Path

from csv_rows import records
from judge import Figure, ask, ask_all, number

TRUTH = Path(__file__).resolve().parents[2] / "reference_output" / "interaction" / "dense.csv"
TOLERANCES = (0.01, 0.003, 0.001)
CONTROLS = ("approach", "load")


@cache
def truths():
    """Rows of the archived table by scene."""
    return {row["scene"]: row for row in records(TRUTH)}


def figures_of(exe, scene, mode, tolerance, control):
    """The load, or the approach, and the area."""
    truth = truths()[scene.name]
    assert truth["checksum"] == scene.checksum(), f"{scene.name}: the truth is of another scene"
    loading = None if control == "approach" else \
        {"control": "load", "value": float(truth["normal_load"])}
    answer = ask(exe, partial(scene.write, loading=loading, interaction=mode, tolerance=tolerance),
                 contacts=False)
    row = answer.positions[0] if answer.status == 0 else {}
    what, bound = f"{scene.name} {control}", float(truth["load_error"])
    shown = number(row, "error_estimate")
    first = Figure(what, number(row, "vertical_load"), float(truth["load"]), bound, shown) \
        if control == "approach" else \
        Figure(what, -number(row, "separation"), -scene.approach, bound, shown,
               float(truth["closing"]))
    area = Figure(f"{what}, area", number(row, "area"), float(truth["area"]),
                  float(truth["area_error"]), number(row, "area_error_estimate"))
    first.message = area.message = answer.message
    return first, area


def all_figures(exe, scenes, mode="auto", tolerance=TOLERANCES[0], controls=CONTROLS):
    """Figures of loads, or approaches, and those of areas."""
    return zip(*ask_all([partial(figures_of, exe, scene, mode, tolerance, control)
                         for control in controls for scene in scenes]))
