"""`--fault-free`: without its faults the original is the truth; what each of them does is told.

The truth is `exact_contact`'s: the geometry and Hertz' equations with 40 digits. The original has
3.1416 for pi in its areas, fault or not.
"""

import csv
import io
import re
import subprocess

import pytest
from builds import ROOT
from decks import random_deck, write_deck
from exact_contact import Truth, read_deck
from fault_effects import (ARCHIVE, DECIMALS, DOCUMENT, MADE, archive, begin, effects, inside,
                           names, variance)
from mpmath import mp, mpf
from programs import run_program

DIGITS = 40
# A few units of the last place of a double, in which real128's results are written. Decks that take
# seconds in real128 run in real64, where a sum over contacts and an approach lose some more.
TOLERANCE = {"real128": 1.0e-15, "real64": 1.0e-11}
SLOW = ("deck_list_full", "deck_past_37")
HARD = ROOT / "data" / "hard"
THESIS = ROOT / "data" / "thesis.deck"
# Decks on which a fault spoils something or stops the run, and a word of what it says then.
SPOILT = {"list": ("deck_25_approaches", ""), "no-pair": ("deck_none_at_some", "fault 6"),
          "reach": ("deck_beyond_sum", "fault 7")}


def run(asperity, deck, mended, *options):
    return run_program(asperity, deck, "--fault-free", mended, *options, status=None)


def arithmetic_for(deck):
    return "real64" if deck.stem in SLOW else "real128"


def positions(asperity, deck, mended="all"):
    """The last approach of every position; the message when it stops."""
    done = run(asperity, deck, mended, "--arithmetic", arithmetic_for(deck), "--positions", "-")
    if done.returncode:
        return done.stderr
    return list(csv.DictReader(io.StringIO(done.stdout)))


def off(found, true):
    return abs(mpf(float(found)) / true - 1) if true else abs(mpf(float(found)))


def misses(rows, deck, step=1):
    """Numbers of positions that are not the truth."""
    truth, missed = Truth(read_deck(deck), DIGITS), []
    for m in range(1, 101, step):
        row, state = rows[m - 1], truth.state(m)
        true = {"load": 0, "area": 0, "projected_area": 0, "approach": 0, "contacts": 0}
        if state is not None:
            pi = mpf("3.1416") / mp.pi
            true = {"load": state.vertical_load, "area": pi * state.area,
                    "projected_area": pi * state.projected_area, "approach": state.separation,
                    "contacts": len(state.contacts)}
        true["x_displacement"], true["y_displacement"] = truth.displacement(m)
        with mp.workdps(DIGITS):
            missed += [(m, name) for name, value in true.items()
                       if off(row[name], value) > TOLERANCE[arithmetic_for(deck)]]
    return missed


def test_without_faults_the_thesis_is_the_truth(asperity, tally):
    assert misses(positions(asperity, THESIS), THESIS) == []
    tally.add("positions of the thesis without faults", 700, 700)


@pytest.mark.parametrize("name", [path.stem for path in sorted(HARD.glob("deck_*.deck"))
                                  if path.stem != "deck_moduli_1e12"])
def test_without_faults_hard_decks_are_the_truth(name, asperity):
    deck = HARD / f"{name}.deck"
    assert misses(positions(asperity, deck), deck, 11) == []


def test_a_displacement_moves_the_model(asperity, tmp_path):
    text = THESIS.read_text()
    zero = "  0.0000  0.0000  0.000  0.000"
    assert zero in text
    deck = tmp_path / "displaced.deck"
    deck.write_text(text.replace(zero, "  0.0000  0.0000  1.000 -0.250"))
    assert misses(positions(asperity, deck), deck, 11) == []
    others = ",".join(name for name in names(asperity) if name != "shift")
    assert misses(positions(asperity, deck, others), deck, 11)


@pytest.mark.parametrize("fault", SPOILT)
def test_what_a_fault_spoils(fault, asperity):
    name, said = SPOILT[fault]
    deck = HARD / f"{name}.deck"
    others = ",".join(name for name in names(asperity) if name != fault)
    rows = positions(asperity, deck, others)
    assert said in rows if said else misses(rows, deck, 11)


def test_a_limit_that_is_never_reached(asperity):
    """Moduli so unlike that two centres would meet before."""
    done = run(asperity, HARD / "deck_moduli_1e12.deck", "list", "--arithmetic", "real64")
    assert (done.returncode, done.stdout) == (1, "")
    assert "no contact reaches WLIMIT before the centres of asperities 1 (upper) and 1 (lower) " \
        "meet" in done.stderr


def test_table_vi_is_of_its_positions(asperity):
    """Without faults Table VI has maxima, minima and averages of what the positions have."""
    rows, table = positions(asperity, THESIS), variance(asperity, ("all",), "real128")
    for quantity, column in (("total_load", "load"), ("total_contact_area", "area"),
                             ("contact_points", "contacts"), ("approach", "approach")):
        values = [mpf(float(row[column])) for row in rows]
        want = {"maximum": max(values), "minimum": min(values), "average": mp.fsum(values) / 100}
        assert all(off(table[quantity, name], value) < 1e-15 for name, value in want.items())
    shares = [100 * (1 - mpf(float(row["projected_area"])) / float(row["area"])) for row in rows]
    assert off(table["total_area_difference", "average"], mp.fsum(shares) / 100) < 1e-12


def test_left_out_and_start_values(asperity, tmp_path):
    """Decks of test_faults.py: one leaves contacts out, one never passes a start value."""
    deck = write_deck(tmp_path / "random.deck", **random_deck(9))
    slopes = []
    for mended in ("", ",left-out"):
        table = variance(asperity, ("overshoot" + mended,), deck=deck)
        done = run(asperity, deck, "overshoot" + mended, "--contacts", "-")
        last = {}
        for row in csv.DictReader(io.StringIO(done.stdout)):
            last.setdefault(row["position"], {}).setdefault(int(row["step"]), []).append(row)
        ends = [row for steps in last.values() for row in steps[max(steps)] if float(row["load"])]
        mean = sum(float(row["slope"]) for row in ends) / len(ends)
        slopes.append(abs(table["slope", "average"] / mean - 1))
    assert slopes[1] < 1e-4 < slopes[0]
    stiff = tmp_path / "stiff.deck"
    stiff.write_text(THESIS.read_text().replace("   400000.", "    4.0E10"))
    least = {fault: variance(asperity, (fault,), deck=stiff)["total_load", "minimum"]
             for fault in ("start-value", "count")}
    assert least["count"] == 10000.0 < least["start-value"]


def test_the_report_without_faults(asperity):
    done = run(asperity, THESIS, "all")
    assert re.search(r"POINTS +8 +1 +2\.08$", done.stdout, re.MULTILINE)
    assert "note: faults are corrected: this is not what the original printed" in done.stderr


def test_names(asperity):
    """The page has the names of the program, with their numbers; the help has them, too."""
    page = (ROOT / "docs/theory/faults.md").read_text(encoding="utf-8")
    assert re.findall(r"^\| \d+ \|.*\| `([a-z-]+)` \|$", page, re.MULTILINE) == names(asperity)
    told = subprocess.run([asperity, "--help"], capture_output=True, text=True, check=False).stdout
    assert ", ".join(names(asperity)) in " ".join(told.split())


@pytest.mark.once
def test_tables_of_the_page_are_current(asperity):
    page = (ROOT / DOCUMENT).read_text(encoding="utf-8")
    for name, lines in MADE.items():
        assert inside(page, begin(name))[1].strip("\n").splitlines() == list(lines(asperity))
    assert ARCHIVE.read_text(encoding="ascii").splitlines() == list(archive(asperity))


def test_effects_explain_the_corrected_table(asperity):
    """All at once meets `Table VI, corrected` of the solver; the sum does within what the page
    lists as not additive, in printed units."""
    done = run_program(asperity, "solve", THESIS)
    lines = done.stdout.partition("Table VI, corrected")[2].splitlines()[1:]
    corrected = [line[44:55].strip() for line in lines]
    exact = variance(asperity, ("all",), "real128")
    assert len(corrected) == len(exact) == 21
    for (quantity, column), cell in zip(exact, corrected, strict=True):
        digits = len(cell.partition(".")[2])
        assert f"{exact[quantity, column]:.{digits}f}" == cell
    single, together = {}, effects(asperity, "all")
    for name in names(asperity):
        for cell, effect in effects(asperity, name).items():
            single[cell] = single.get(cell, 0) + effect
    for cell, effect in together.items():
        # Total loads: 1.3 N between overshoot and normal-load, see the page.
        most = 1.3 if cell[0] == "total_load" else 0.4
        assert abs(effect - single[cell]) < most * 10.0 ** -DECIMALS[cell[0]]
