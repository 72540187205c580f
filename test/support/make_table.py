"""The tables of reference_output/bench/hard_cases.md, between their markers.

    python test/support/make_table.py EXECUTABLE
"""

import sys
import tempfile
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

from cases import ARITHMETICS, scenes
from deck_cases import decks
from exact_contact import read_deck
from model_cases import ModelCase, model_cases
from measure import (condition, measure, measure_deck, positions_of,
                     positions_of_deck, scene_of)
from surfaces_csv import solve

DOCUMENT = "reference_output/bench/hard_cases.md"
BEGIN, END = "<!-- begin: made by test/support/make_table.py -->", "<!-- end -->"


def verdict(refused, arithmetics):
    """What the catalogue demands, in words."""
    refused = {a: said for a, said in refused.items() if a in arithmetics}
    right = [a for a in arithmetics if a not in refused]
    if not refused:
        return "right"
    said = "; ".join(dict.fromkeys(refused.values()))
    if not right:
        return f"refused: {said}"
    return f"right; in {', '.join(refused)} refused: {said}"


def historic(case):
    """What the port does with a deck."""
    if case.historic != "runs":
        return f"stops: {case.historic}"
    return f"runs; note: {case.note}" if case.note else "runs"


def row(name, verdicts, cells):
    return "| " + " | ".join((f"`{name}`", *cells, *verdicts)) + " |"


def lines(found):
    """The tables. `found` gives the cell of a case in an arithmetic, or its condition."""
    head = ["condition", *ARITHMETICS, "verdict"]
    yield from ("### Scenes", "", "| case | " + " | ".join(head) + " |", "| --- " * 4 + "|")
    for case in scenes():
        yield row(case.name, [verdict(case.refused, case.arithmetics)],
                  [found(case, "condition")] +
                  [found(case, a) if a in case.arithmetics else "not run" for a in ARITHMETICS])
    head += ["historic port"]
    yield from ("", "### Decks", "", "| case | " + " | ".join(head) + " |", "| --- " * 5 + "|")
    for case in decks():
        refused = dict.fromkeys(ARITHMETICS, case.solver_refused) if case.solver_refused else {}
        yield row(case.name, [verdict(refused, ARITHMETICS), historic(case)],
                  [found(case, a) for a in ("condition", *ARITHMETICS)])
    yield from ("", "### Adhesion, plasticity, creep, maps, dense caps", "",
                "| case | result | error | tolerance | reason of the tolerance |",
                "| --- " * 5 + "|")
    for case in model_cases():
        for value in case.values:
            yield row(f"{case.name}", [f"{value.tolerance:.0e}", value.reason],
                      [value.column, found(case, value)])


def without_errors(text):
    """The table without its measured cells."""
    kept = []
    for line in text.splitlines():
        cells = line.split(" | ")
        kept.append(" | ".join(cells[:1] + cells[3:]) if len(cells) > 3 else line)
    return kept


def is_current(document):
    """Whether a document lists every case with the catalogue's verdict."""
    inside = document.partition(BEGIN)[2].partition(END)[0].strip()
    return without_errors(inside) == without_errors("\n".join(lines(lambda case, a: "")))


def condition_of(case):
    """In two digits; a dash where nothing is borne or all is refused."""
    if hasattr(case, "deck"):
        scene = read_deck(ROOT / "data" / "hard" / f"{case.name}.deck")
        number = 0 if case.solver_refused else condition(scene, positions_of_deck(scene))
    else:
        scene = scene_of(case)
        every = set(case.refused) >= set(case.arithmetics)
        number = 0 if every else condition(scene, positions_of(case, scene))
    return f"{float(number):.1e}" if number else "-"


def measured(executable, folder):
    """A function that runs a case and gives its cell."""
    @cache
    def solved(name):
        return solve(executable, ROOT / "data/hard/models" / f"{name}.scene", folder=folder,
                     curve=True)

    def found(case, arithmetic):
        if isinstance(case, ModelCase):
            return f"{arithmetic.error(solved(case.name)):.1e}"
        if arithmetic == "condition":
            return condition_of(case)
        if hasattr(case, "deck"):
            path = ROOT / "data" / "hard" / f"{case.name}.deck"
            outcome = measure_deck(executable, path, arithmetic, folder)
        else:
            path = ROOT / "data" / "hard" / f"{case.name}.scene"
            outcome = measure(executable, case, path, arithmetic, folder)
        return "refused" if outcome.refused else f"{outcome.worst:.2f}"

    return found


def main(executable):
    path = ROOT / DOCUMENT
    before, _, rest = path.read_text(encoding="utf-8").partition(BEGIN)
    after = rest.partition(END)[2]
    with tempfile.TemporaryDirectory() as folder:
        table = "\n".join(lines(measured(Path(executable).resolve(), Path(folder))))
    path.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
