"""Interaction in dense scenes against the archived truth: tolerance, area, the error it tells."""

import os

import numpy as np
import pytest
from boundary_equations import evaluate
from boundary_patch import Contact
from dense_judge import CONTROLS, TOLERANCES, estimates, groups, run_all, table, truths
from dense_scenes import COMBINED, caps, dense_scenes
from dense_truth import finest, on_grids, settled, truth_of
from surfaces_csv import solve

# Every twentieth scene: all families are among them. All: dense_judge.py, in some minutes.
FEW = dense_scenes()[::20]
# The cells' own tolerance, of the load (boundary_tolerance).
CELLS = 1e-3

def solved(asperity, scenes, mode="auto", tolerance=TOLERANCES[0]):
    """Runs in both controls. Tests run side by side: each takes its share of the cores."""
    workers = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    results = run_all(asperity, scenes, (mode,), (tolerance,),
                      processes=max(1, (os.cpu_count() or 1) // workers))
    print("\n".join(table(results)))
    return results


def told(results):
    """How many, and the first of them, for a message."""
    return f"{len(results)}: " + "; ".join(
        f"{r.scene} {r.control} {r.error:+.1e} (area {r.area_error:+.1e}) {r.message[-80:]}"
        for r in results[:8])


@pytest.mark.once
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_auto(asperity, tally, tolerance):
    """Within the tolerance: vertical load at a given approach; approach, over the closing, at a
    given load; real area (half a percent at least). Every run tells its error; how often that is
    below the true one, and above ten times it, is in the table."""
    results = solved(asperity, FEW, tolerance=tolerance)
    missed = [r for r in results if r.missed]
    area_missed = [r for r in results if r.area_missed]
    tally.add(f"dense scenes, auto {tolerance:g}", len(results), len(results) - len(missed))
    tally.add(f"dense scenes, area {tolerance:g}", len(results), len(results) - len(area_missed))
    wrong = []
    if missed:
        wrong.append(f"beyond the tolerance {told(missed)}")
    if area_missed:
        wrong.append(f"areas beyond the tolerance {told(area_missed)}")
    for name, area in (("error_estimate", False), ("area_error_estimate", True)):
        found = estimates(results, area)
        if found.known < len(results):
            wrong.append(f"{name}: {len(results) - found.known} of {len(results)} without")
    assert not wrong, "\n".join(wrong)


@pytest.mark.once
@pytest.mark.parametrize("shear, apart, count", [(0, 0.7, 4), (0.5, 0.6, 5)])
def test_areas_of_contacts_that_merge(asperity, tmp_path, shear, apart, count):
    """Lattices whose creases hold slits narrower than a cell: .01 had 1.6 and 1.7 % too much."""
    depth, turn = 1e-4, np.array([[np.cos(0.3), np.sin(0.3)], [-np.sin(0.3), np.cos(0.3)]])
    places = [(i + shear * (j % 2), np.sqrt(1 - shear ** 2) * j)
              for j in range(4) for i in range(count)]
    scene = caps("merging", "lattices", apart * np.sqrt(depth) * np.array(places) @ turn, 1.0,
                 np.zeros(4 * count), depth, 1e9)
    pairs = scene.pairs()
    area, error = settled(on_grids(pairs, finest(pairs, 2.0)))[2:]
    for tolerance in TOLERANCES:
        ran = solve(asperity, scene.write(tmp_path, interaction="auto", tolerance=tolerance),
                    contacts=False)
        off = float(ran.positions[0]["area"]) / area - 1
        assert abs(off) <= max(tolerance, 0.005) + error, (tolerance, off, error)


@pytest.mark.once
def test_boundary_agrees_with_the_truth(asperity):
    """All contacts on cells, as fine as CELLS calls for."""
    scenes = [s for s in FEW if int(truths()[s.name]["contacts"]) <= 60]
    results = solved(asperity, scenes, "boundary")
    missed = [r for r in results if not abs(r.error) <= CELLS + r.bound]
    assert not missed, told(missed)


@pytest.mark.once
def test_coupled_solves_all_and_errs_low(asperity):
    """No contact resolved: how far it is off is in the table; caps carry less, never more (steep
    pairs, whose contacts are oval, may carry more)."""
    results = solved(asperity, FEW, "coupled")
    failed = [r for r in results if r.status != 0]
    assert not failed, told(failed)
    low = [r for r in results if r.control == "approach" and r.family != "steep"
           and r.error > CELLS + r.bound]
    assert not low, told(low)


@pytest.mark.once
def test_the_truth_is_of_these_scenes(tally):
    """Every scene has a truth, each of the numbers that the generator gives, and good enough."""
    scenes = dense_scenes()
    assert len(scenes) >= 320 and [s.name for s in scenes] == list(truths())
    for scene in scenes:
        row = truths()[scene.name]
        assert row["checksum"] == scene.checksum(), scene.name
        assert float(row["load_error"]) <= 1e-4 and float(row["area_error"]) <= 4e-3, row
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
