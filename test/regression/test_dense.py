"""Interaction in dense scenes against the archived truth: tolerance, area, the error it tells."""

import os

import numpy as np
import pytest
from boundary_equations import evaluate
from boundary_patch import Contact
from dense_judge import CONTROLS, TOLERANCES, estimates, groups, run_all, table, truths
from dense_scenes import COMBINED, dense_scenes
from dense_truth import truth_of

# Every tenth scene: all families are among them.
FEW = dense_scenes()[::10]
# The cells' own tolerance, of the load (boundary_tolerance).
CELLS = 1e-3

ALL_AND_FEW = pytest.mark.parametrize(
    "scenes", [pytest.param(FEW, id="few"),
               pytest.param(dense_scenes(), id="all", marks=pytest.mark.long)])

_RUNS = {}


def solved(asperity, scenes, mode="auto", tolerance=TOLERANCES[0]):
    """Runs in both controls, each done once in a process."""
    key = (str(asperity), len(scenes), mode, tolerance)
    if key not in _RUNS:
        # The tests run side by side: as many runs at a time as this process has a share of cores.
        workers = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
        _RUNS[key] = run_all(asperity, scenes, (mode,), (tolerance,),
                             processes=max(1, (os.cpu_count() or 1) // workers))
        print("\n".join(table(_RUNS[key])))
    return _RUNS[key]


def told(results):
    """The first of them, for a message."""
    return f"{len(results)}: " + "; ".join(
        f"{r.scene} {r.control} {r.error:+.1e} (area {r.area_error:+.1e}) {r.message[-80:]}"
        for r in results[:8])


@pytest.mark.parametrize("tolerance", TOLERANCES)
@ALL_AND_FEW
def test_auto_keeps_its_tolerance(asperity, tally, scenes, tolerance):
    """Vertical load at a given approach; approach, over the closing, at a given load."""
    results = solved(asperity, scenes, tolerance=tolerance)
    missed = [r for r in results if r.missed]
    tally.add(f"dense scenes, auto {tolerance:g}", len(results), len(results) - len(missed))
    assert not missed, told(missed)


@pytest.mark.parametrize("tolerance", TOLERANCES)
@ALL_AND_FEW
def test_real_area(asperity, tally, scenes, tolerance):
    """Within the larger of the tolerance and half a percent."""
    results = solved(asperity, scenes, tolerance=tolerance)
    missed = [r for r in results if r.area_missed]
    tally.add(f"dense scenes, area {tolerance:g}", len(results), len(results) - len(missed))
    assert not missed, told(missed)


@pytest.mark.parametrize("area", [False, True], ids=["load or approach", "area"])
@pytest.mark.parametrize("tolerance", TOLERANCES)
@ALL_AND_FEW
def test_error_that_is_told(asperity, scenes, tolerance, area):
    """Not below the true error in 99 of 100, not above ten times it in 90 of 100."""
    results = solved(asperity, scenes, tolerance=tolerance)
    found = estimates(results, area)
    assert found.known == len(results), f"{len(results) - found.known} without an estimate"
    assert found.kept, found


@ALL_AND_FEW
def test_boundary_agrees_with_the_truth(asperity, scenes):
    """All contacts on cells, which are halved until they move the load by less than CELLS."""
    scenes = [s for s in scenes if int(truths()[s.name]["contacts"]) <= 60]
    results = solved(asperity, scenes, "boundary")
    missed = [r for r in results if not abs(r.error) <= CELLS + r.bound]
    assert not missed, told(missed)


@ALL_AND_FEW
def test_coupled_solves_all_and_errs_low(asperity, scenes):
    """No contact resolved: how far it is off is in the table; it carries less, never more."""
    results = solved(asperity, scenes, "coupled")
    failed = [r for r in results if r.status != 0]
    assert not failed, told(failed)
    low = [r for r in results if r.control == "approach" and r.error > CELLS + r.bound]
    assert not low, told(low)


@pytest.mark.once
def test_the_truth_is_of_these_scenes(tally):
    """Every scene has a truth, each of the numbers that the generator gives, and good enough."""
    scenes = dense_scenes()
    assert len(scenes) >= 320 and [s.name for s in scenes] == list(truths())
    for scene in scenes:
        row = truths()[scene.name]
        assert row["checksum"] == scene.checksum(), scene.name
        assert float(row["load_error"]) <= 1e-4 and float(row["area_error"]) <= 2e-3, row
        assert 2 <= int(row["contacts"]) <= 200
        assert 0 < float(row["load"]) < float(row["alone"]), row
    assert {f for f, in groups(FEW, "family")} == {f for f, in groups(scenes, "family")}
    assert set(CONTROLS) == {"approach", "load"}
    tally.add("dense scenes with a truth", len(scenes), len(scenes))


@pytest.mark.once
@pytest.mark.parametrize("name", ["coincident_009", "flanks_005", "unlike_pairs_020"])
def test_the_truth_can_be_made_again(name):
    scene = next(s for s in dense_scenes() if s.name == name)
    again, kept = truth_of(scene), truths()[name]
    for column in ("load", "normal_load", "area"):
        assert np.isclose(float(again[column]), float(kept[column]), rtol=1e-5), column


@pytest.mark.once
@pytest.mark.parametrize("name", ["pairs_033", "triples_000"])
def test_the_truth_by_another_method(name):
    """Polynomials under a root in place of squares: load within 1e-5, as far as both state."""
    pairs = next(s for s in dense_scenes() if s.name == name).pairs()
    spheres = zip(pairs.upper, pairs.upper_radius, pairs.lower, pairs.lower_radius,
                  pairs.penetration)
    other = evaluate([Contact(*map(float, (*upper, ru, *lower, rl, p)))
                      for upper, ru, lower, rl, p in spheres], COMBINED)
    load = (pairs.law()[0] * np.array(other["loads"]) / np.array(other["loads_alone"])).sum()
    row = truths()[name]
    assert abs(load / float(row["load"]) - 1) <= float(row["load_error"]) + other["uncertainty"]
