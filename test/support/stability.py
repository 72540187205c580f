"""Condition number against error over the hard cases, in real64, with both ways to the overlap.

    python test/support/stability.py EXECUTABLE FILE

writes a CSV for the figure stability: case, condition, arithmetic, formula, the largest
relative error of the totals of all positions compared. The truth is that of the decimal numbers of
the scene, so rounding them to the arithmetic is part of the error. Cases are left out where they
are refused, where nothing is carried, and the sweeps of ten thousand positions and more.
"""

import sys
from pathlib import Path

from cases import scenes
from deck_cases import decks
from exact_contact import TOTALS, Truth, read_deck
from measure import condition, positions_of, positions_of_deck, scene_of
from mpmath import mp
from programs import run_program

ROOT = Path(__file__).resolve().parents[2]
FORMULAS = ("stable", "original")
# What an operation may lose. docs/figures/draw.py draws it.
ROUNDOFF = {"real64": 2.0 ** -53}
LONG = ("positions_ten_thousand", "positions_a_million")
# Decimal digits of the truth: the smallest penetration compared is 1e-147 of the lengths.
DIGITS = 340


def condition_of(case):
    """In two digits; a dash where nothing is carried or all is refused."""
    if hasattr(case, "deck"):
        scene = read_deck(ROOT / "data" / "hard" / f"{case.name}.deck")
        number = 0 if case.solver_refused else condition(scene, positions_of_deck(scene))
    else:
        scene = scene_of(case)
        number = 0 if case.refused else condition(scene, positions_of(case, scene))
    return f"{float(number):.1e}" if number else "-"


def totals(program, path, formula):
    """Totals by position, or nothing when the case is refused."""
    done = run_program(program, path, formula, status=None)
    if done.returncode:
        return None
    return [[float(word) for word in line.split()] for line in done.stdout.splitlines()]


def error(found, truth, positions):
    """The largest relative error of a total."""
    worst = 0.0
    with mp.workdps(DIGITS):
        for m in positions:
            state = truth.state(m)
            true = [0] * len(TOTALS) if state is None else [getattr(state, n) for n in TOTALS]
            for value, want in zip(found[m - 1], true, strict=True):
                if want:
                    worst = max(worst, float(abs(value / want - 1)))
    return worst


def cases():
    """Every hard case with its file, scene and the positions that are compared."""
    folder = ROOT / "data" / "hard"
    for case in scenes():
        if case.name not in LONG and not case.refused:
            scene = scene_of(case)
            yield case, folder / f"{case.name}.scene", scene, positions_of(case, scene)
    for case in decks():
        if not case.solver_refused:
            path = folder / f"{case.name}.deck"
            scene = read_deck(path)
            yield case, path, scene, positions_of_deck(scene)


def measured(program, names=()):
    """Lines of the CSV, of all cases or those named."""
    for case, path, scene, positions in cases():
        if names and case.name not in names:
            continue
        condition = condition_of(case)
        if condition == "-":
            continue
        truth = Truth(scene, DIGITS)
        for formula in FORMULAS:
            found = totals(program, path, formula)
            if found is not None:
                off = error(found, truth, positions)
                yield f"{case.name},{condition},real64,{formula},{off:.3e}"


def main(executable, target):
    program = Path(executable).resolve().parent.parent / "example" / "overlap_totals"
    lines = ["case,condition,arithmetic,formula,error", *measured(program)]
    Path(target).write_text("\n".join(lines) + "\n", encoding="ascii")


if __name__ == "__main__":
    main(*sys.argv[1:])
