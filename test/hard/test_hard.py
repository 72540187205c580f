"""The catalogue of hard cases: every result right within a few units of the last place, or refused.

Units and truth are those of measure.py. Decks also run through the historic port, which keeps the
original's behaviour, and stops where the original's numbers lost their meaning.
"""

import filecmp
import re

import pytest
from builds import ROOT
from cases import scenes
from cells_met import ARITHMETICS as HISTORIC
from deck_cases import decks
from decks import random_deck, write_deck
from historic import NAMES, LostMeaningError, restate
from make_cases import write_all
from exact_contact import TOTALS
from judge import NO_NUMBER
from measure import condition, largest_coordinate, measure, measure_deck, run, scene_of
from programs import run_program
from surfaces_csv import records
from test_solve import deck_truth, relative, solve_deck

# Largest error, units of the last place. A sum of 144 loads has the most.
ALLOWED = 16.0

LONG = ("positions_a_million", "near_ties_22", "near_ties_51", "deck_list_full", "deck_past_37",
        "deck_ties_10")
SCENES = {case.name: case for case in scenes()}
DECKS = {case.name: case for case in decks()}


@pytest.fixture(scope="module")
def data(root):
    return root / "data" / "hard"


def test_data_are_those_of_the_catalogue(data, tmp_path):
    write_all(tmp_path)
    names, kept = (sorted(str(path.relative_to(folder)) for path in folder.rglob("*.*")
                          if "found" not in path.parts) for folder in (tmp_path, data))
    assert names == kept and len(names) > 150
    assert filecmp.cmpfiles(data, tmp_path, names, shallow=False)[1:] == ([], [])


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=[pytest.mark.long] * (name in LONG)) for name in SCENES])
def test_scene(name, asperity, data, tmp_path):
    meets(measure(asperity, SCENES[name], data / f"{name}.scene", tmp_path), SCENES[name].refused)


def meets(outcome, refused):
    """A refusal with this message, or a result within the allowed error."""
    if refused:
        assert refused in outcome.refused
    else:
        assert not outcome.refused
        assert outcome.worst <= ALLOWED, outcome.where


@pytest.mark.parametrize("name", ["penetration_1e-3", "penetration_1e-15", "penetration_1e-100"])
def test_condition_of_a_small_penetration(name):
    """One pair at a given approach: a load goes with the power 3/2 of the penetration, which is a
    difference of three numbers of the size of the largest. A trial may add all three or one."""
    case = SCENES[name]
    scene = scene_of(case)
    one = 1.5 * float(largest_coordinate(scene)) / float(name.partition("_")[2])
    assert 0.99 * one <= condition(scene, [1]) <= 3.01 * one + 3


@pytest.mark.parametrize("seed, position", [(20, 2), (26, 2), (146, 2)])
def test_errors_of_random_decks_are_their_condition(seed, position, asperity, tmp_path):
    """The positions of 200 random decks that are farthest from the truth, up to 1.8e-13: they end
    soon after first touch. Each is nearer than their condition times half a unit of a double."""
    deck, motion, solved = solve_deck(asperity, tmp_path, seed)
    truth = deck_truth(deck, motion)
    state, row = truth.state(position), solved.positions[position - 1]
    error = max(relative(row[name], getattr(state, name)) for name in TOTALS)
    assert 5e-14 < error < float(condition(truth.scene, [position])) * 2.0**-53


# Power of the length in a dimension, at the same moduli.
POWERS = {"length": 1, "area": 2, "force": 2, "pressure": 0, "moment": 3}


def power_of(column):
    """Power of the length in a column, by its dimension in the source; one without it has none."""
    source = (ROOT / "src/output/result_table.f90").read_text(encoding="utf-8")
    calls = re.findall(rf"call add_\w+\(table, '{column}',(?:[^&\n]|&\n)*", source)
    dimensions = {name for call in calls for name in re.findall(r"dimension=is_(\w+)", call)}
    assert len(dimensions) <= 1
    return POWERS[dimensions.pop()] if dimensions else 0


@pytest.mark.parametrize("power", (3, 40, -72, 500, -500))
def test_lengths_times_a_power_of_2_scale_bit_for_bit(power, asperity, data, tmp_path):
    base, other = (run(asperity, data / f"{name}.scene", tmp_path)
                   for name in ("unit_base", f"unit_2^{power}"))
    compared = 0
    for rows in ("positions", "contacts"):
        for a, b in zip(getattr(base, rows), getattr(other, rows), strict=True):
            for name in a:
                if a[name] == b[name] == "":
                    continue
                factor = 2.0 ** (power * power_of(name))
                assert float(b[name]) == float(a[name]) * factor, f"{rows} {name}"
                compared += 1
    assert compared > 40


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=[pytest.mark.long] * (name in LONG)) for name in DECKS])
def test_deck_in_the_present_day_solver(name, asperity, data, tmp_path):
    meets(measure_deck(asperity, data / f"{name}.deck", tmp_path), DECKS[name].solver_refused)


@pytest.mark.parametrize("name, arithmetic", [
    (name, arithmetic) for name in DECKS for arithmetic in HISTORIC])
def test_deck_in_the_historic_port(name, arithmetic, asperity, data, tmp_path):
    case, path = DECKS[name], data / f"{name}.deck"
    file = tmp_path / "positions.csv"
    done = run_program(asperity, path, "--arithmetic", arithmetic, "--positions", file, status=None)
    if case.historic != "runs":
        assert (done.returncode, file.exists()) == (1, False)
        # What stood on paper where the original stopped.
        assert "TABLE V\n" in done.stdout and "TABLE VI\n" not in done.stdout
        last = done.stderr.splitlines()[-1]
        assert last.startswith(f"{path}: position ") and case.historic in last
        return
    assert done.returncode == 0, done.stderr
    # A number too long for its field prints as stars, as it always did.
    assert "TABLE VI\n" in done.stdout and not NO_NUMBER.search(done.stdout.replace("*", " "))
    if arithmetic in ("real64", "real128"):
        assert case.note in done.stderr
    rows = records(file)
    assert len(rows) == 100
    assert all(abs(float(cell)) < float("inf") for row in rows for cell in row.values())


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=[pytest.mark.long] * (name in LONG)) for name in DECKS])
def test_historic_port_against_the_restated_march(name, asperity, data, tmp_path):
    case, path = DECKS[name], data / f"{name}.deck"
    if case.historic != "runs":
        with pytest.raises(LostMeaningError) as lost:
            restate(**case.deck)
        done = run_program(asperity, path, "--arithmetic", "real128", status=1)
        position, fault = lost.value.args
        assert f"position {position}: " in done.stderr and f"(fault {fault})" in done.stderr
        return
    expected = restate(**case.deck)
    for arithmetic, most in (("real64", case.coarse), ("real128", 1.0e-15)):
        worst = historic_error(asperity, path, arithmetic, tmp_path, expected)
        assert worst <= most, arithmetic


@pytest.mark.parametrize("seed", [
    pytest.param(seed, marks=[pytest.mark.long] * (seed < 6)) for seed in (0, 2, 5, 6)])
def test_random_deck_in_the_historic_port(seed, asperity, tmp_path):
    deck = random_deck(seed)
    path = write_deck(tmp_path / "random.deck", **deck)
    # Penetrations are known to 4e-15 cm of 1e-2 cm; the decrements of 100 positions add theirs.
    assert historic_error(asperity, path, "real64", tmp_path, restate(**deck)) < 1e-9
    last = records(tmp_path / "real64.csv")[-1]
    assert float(last["x_displacement"]) == pytest.approx(2.54 * deck["displacement"][0] + 10.0)


def historic_error(asperity, path, arithmetic, folder, expected):
    """The largest relative error; counts must be the same."""
    file = folder / f"{arithmetic}.csv"
    run_program(asperity, path, "--arithmetic", arithmetic, "--positions", file)
    worst = 0.0
    for m, (row, want) in enumerate(zip(records(file), expected, strict=True), 1):
        for name, value in zip(NAMES, want):
            if name in ("steps", "contacts", "limit_reached"):
                assert int(row[name]) == value, f"position {m}: {name}"
            elif value:
                worst = max(worst, abs(float((float(row[name]) - value) / value)))
            else:
                assert float(row[name]) == 0.0, f"position {m}: {name}"
    return worst
