"""Interaction of neighbouring contacts, as `asperity solve` does it, against truths made apart.

The truth is reference_output/boundary; its README reports how it was made and how well it holds.
"""

import numpy as np
import pytest

from effect_runs import (CAP, CELLS, COMBINED, CONVERGED, COUPLED_APART, COUPLED_OVERLAPPING,
                         ROOT, Sweeps, effect_rows, total)
from judge import column, compare, solved
from surfaces_csv import records, solve, write_scene, write_surface

OVERLAPPING = (18, 56, 79)  # positions of the thesis where contact circles overlap


def factors(truth):
    """Load over load alone as the program reports it: the law's load of each contact, times
    together over alone of the contact."""
    return column(truth, "by_contact") / column(truth, "hertz")


@pytest.fixture(scope="module")
def sweeps(asperity, tmp_path_factory):
    return Sweeps(asperity, tmp_path_factory.mktemp("effects"))


@pytest.fixture(scope="module")
def truth():
    """The rows of factors.csv, by position."""
    rows = records(ROOT / "reference_output" / "boundary" / "factors.csv")
    assert [int(row["position"]) for row in rows] == list(range(1, 101))
    return rows


def overlapping(truth):
    return np.array([row["overlapping_circles"] != "0" for row in truth])


def column_of_words(run, name):
    return [row[name] for row in run.positions]


# The thesis sweep.

def test_truth_has_the_positions_that_overlap(truth):
    assert tuple(np.flatnonzero(overlapping(truth)) + 1) == OVERLAPPING


def test_factor_of_coupled(sweeps, truth):
    run = sweeps.solve(interaction="coupled")
    errors = np.abs(column(run.positions, "factor") - column(truth, "factor"))
    apart = ~overlapping(truth)
    compare("effects: factor, coupled, circles apart", errors[apart], COUPLED_APART)
    compare("effects: factor, coupled, overlapping", errors[~apart], COUPLED_OVERLAPPING)


def test_isolated_loads(sweeps, truth):
    """The contacts each alone are those of Hertz, and those of the solver without effects."""
    for mode in ("coupled", "off"):
        run = sweeps.solve(interaction=mode)
        alone = column(run.positions, "alone_load" if mode == "coupled" else "vertical_load")
        errors = np.abs(alone / column(truth, "hertz") - 1)
        compare(f"effects: load alone, {mode}", errors, 5e-10)  # the truth's printed digits


@pytest.mark.truth
def test_contacts_that_open(sweeps, truth):
    """As many contacts are left as in the truth."""
    want = column(truth, "contacts") - column(truth, "open")
    for mode in ("coupled", "boundary"):
        have = column(sweeps.solve(interaction=mode).positions, "contacts")
        compare(f"effects: contacts left, {mode}", np.abs(have - want), 0.5)
    assert column(truth, "open").sum() > 3


def test_displacement_by_neighbours(sweeps):
    """Row by row: the penetration without effects is the one that is left and what was lowered; the
    loads are Hertz's at the penetration left."""
    off = {(r["position"], r["upper"], r["lower"]): r
           for r in sweeps.solve(interaction="off").contacts}
    rows = sweeps.solve(interaction="coupled").contacts
    depth, load, alone = [], [], []
    for row in rows:
        free = off[row["position"], row["upper"], row["lower"]]
        assert row["area_no"] == free["area_no"]
        left, lowered = float(row["penetration"]), float(row["lowered"])
        assert lowered >= 0.0
        depth.append(abs((left + lowered) / float(free["penetration"]) - 1))
        alone.append(abs(float(row["alone_load"]) / float(free["vertical_load"]) - 1))
        hertz = 4 / 3 * COMBINED * np.sqrt(CAP / 2) * float(row["overlap"]) ** 1.5
        load.append(abs(float(row["load"]) / hertz - 1))
    assert max(float(row["lowered"]) for row in rows) > 1e-3
    # The loads' residual is of the largest penetration: a lone contact, too, has it.
    compare("effects: penetration and lowering", depth, CONVERGED)
    compare("effects: load alone of a contact", alone, 1e-12)
    compare("effects: load of a lowered contact", load, 1e-12)


def test_load_of_boundary_is_converged(sweeps, truth):
    """Within 0.1 % of the truth at every position, together and alone."""
    run = sweeps.solve(interaction="boundary")
    for ours, theirs in (("vertical_load", "by_contact"), ("alone_load", "hertz")):
        errors = np.abs(column(run.positions, ours) / column(truth, theirs) - 1)
        compare(f"effects: load {theirs}, boundary", errors, CELLS)


@pytest.mark.parametrize("position", (8, 18, 19, 38, 57))
def test_finer_elements_change_loads_within_the_tolerance(position, sweeps, truth):
    coarse, fine = (sweeps.solve(positions=1, x_first=position / 10, interaction="boundary",
                                 boundary_tolerance=bound).positions[0]
                    for bound in (CELLS, 1e-4))
    assert float(fine["cells"]) >= float(coarse["cells"])
    load = float(fine["vertical_load"])
    compare("effects: load, default cells against finer",
           [abs(float(coarse["vertical_load"]) / load - 1)], CELLS)
    compare("effects: load, finer cells",
           [abs(load / float(truth[position - 1]["by_contact"]) - 1)], 2e-4)


def test_auto_is_within_its_tolerance(sweeps, truth):
    """Factor against that of cells, like with like: what was left out counts as factor 1."""
    auto = sweeps.solve(interaction="auto", tolerance=0.01).positions
    cells = column(sweeps.solve(interaction="boundary").positions, "factor")
    factor = np.array([float(r["factor"]) if r["interaction"] != "off" else 1.0 for r in auto])
    compare("effects: factor, auto against boundary", np.abs(factor - cells), 0.01)
    compare("effects: factor, auto", np.abs(factor - column(truth, "factor")), 0.01)


@pytest.mark.parametrize("tolerance", (0.001, 0.01, 0.1))
def test_auto_simulates_effects_above_the_tolerance(tolerance, sweeps, truth):
    rows = sweeps.solve(interaction="auto", tolerance=tolerance).positions
    estimate = column(rows, "interaction_estimate")
    simulated = np.array([row["interaction"] != "off" for row in rows])
    assert (simulated == (estimate > tolerance)).all()
    assert 0 < simulated.sum() < 100
    # First order, with stiffnesses of contacts alone: together they carry less than that takes.
    ours = 1 - column(sweeps.solve(interaction="coupled").positions, "factor")
    compare("effects: influence of coupled above the estimate",
           np.maximum(ours - estimate, 0), 1e-9)
    lost = 1 - column(truth, "factor")
    compare("effects: influence above the estimate", np.maximum(lost - estimate, 0), 2e-4)
    measured = column(rows, "interaction_influence")[simulated]
    assert np.allclose(measured, column(rows, "factor")[simulated] - 1, rtol=0, atol=1e-15)
    ways = [row["interaction"] for row in rows]
    assert set(ways) <= {"off", "coupled", "coupled+boundary"}
    assert all((way != "off") == on for way, on in zip(ways, simulated))
    for row, way, of_coupled, of_truth in zip(rows, ways, ours, factors(truth)):
        assert ((float(row["cells"]) > 0) == (float(row["resolved"]) > 0) ==
                (way == "coupled+boundary")), row["position"]
        # Circles that are wrong by more than the tolerance are not left so.
        if way == "coupled":
            assert abs(1 - of_coupled - of_truth) <= tolerance, row["position"]
    # What circles leave out of the load is at most 0.0034, of the area 0.013, where they overlap.
    resolved = {int(row["position"]) for row, way in zip(rows, ways) if way == "coupled+boundary"}
    if tolerance < 0.002:
        assert resolved >= set(OVERLAPPING)
    else:
        assert resolved <= set(OVERLAPPING) and not (resolved and tolerance > 0.02)


def test_summary_has_the_numbers_of_the_columns(sweeps):
    """A row an effect: estimate of what is off; counts, largest influence and what is left out."""
    off = sweeps.solve(interaction="off")
    assert "non-interacting contacts (Hertz); control" in off.stdout
    # Not below what interaction takes away at position 18, and not far above it.
    row = effect_rows(off.stdout)["interaction"]
    assert row["mode"] == "off" and 25 < float(row["left out"].removesuffix("%")) < 50, row
    assert off.stdout.split("\n", 1)[1] == sweeps.solve().stdout.split("\n", 1)[1]
    coupled = sweeps.solve(interaction="coupled")
    assert "model: interaction coupled; " in coupled.stdout
    assert effect_rows(coupled.stdout)["interaction"]["simulated at"] == "100 of 100"
    auto = sweeps.solve(interaction="auto", tolerance=0.003)
    row, ways = effect_rows(auto.stdout)["interaction"], column_of_words(auto, "interaction")
    assert (row["mode"], row["tolerance"]) == ("auto", "0.300 %")
    assert row["simulated at"] == f"{100 - ways.count('off')} of 100"
    assert row["note"].startswith(f"{next(way for way in ways if way != 'off')} (estimate above")
    influence = column(auto.positions, "interaction_influence")
    assert row["influence"] == f"{100 * influence[np.nanargmax(np.abs(influence))]:.1f} %"
    left_out = max(float(position["interaction_estimate"]) for position, way
                   in zip(auto.positions, ways) if way == "off")
    assert row["left out"] == (f"{100 * left_out:.3f} %" if left_out else "0 %")


# Curves, the same again.

@pytest.mark.parametrize("mode", (
    "coupled", pytest.param("boundary", marks=pytest.mark.long), "auto"))
def test_curve_is_made_of_states(mode, sweeps):
    """Every state of a curve is what the same approach gives by itself."""
    points = 5
    run = sweeps.solve(positions=1, x_first=5.6, curve=True, interaction=mode,
                       loading={"control": "limit", "points": points})
    # First touch and the points asked for; contacts that touch first alone begin later together.
    assert len(run.curve) == int(run.positions[0]["steps"]) == points + 1
    full = float(run.positions[0]["load"])
    last = run.curve[-1]
    assert all(run.positions[0][name] == last[name] for name in
               ("separation", "contacts", "load", "area", "projected_area", "vertical_load"))
    errors = []
    for step, state in enumerate(run.curve, 1):
        rows = [row for row in run.contacts if int(row["step"]) == step]
        assert total(rows, "load") == pytest.approx(float(state["load"]), rel=1e-13, abs=1e-300)
        assert len(rows) == int(state["contacts"])
        if step == 1:
            continue
        one = sweeps.solve(positions=1, x_first=5.6, interaction=mode, curve=True,
                           loading={"control": "approach", "value": float(state["separation"])})
        errors.append(abs(float(one.positions[0]["load"]) - float(state["load"])) / full)
    # The approach of a state is rounded where it is written.
    compare(f"effects: states of a curve, {mode}", errors, 1e-9)
    loads = column(run.curve, "load")
    assert (np.diff(loads) > 0).all()


def caps_on_a_plane(folder, loading, modulus=1.0, length=1.0, **effects):
    """Two caps of radius 2 and height 1, 0.9 apart, on a plane, in units of one's own."""
    (folder / "two.csv").write_text("x,y,height,radius\n" + "".join(
        f"{x * length!r},0,{length!r},{2 * length!r}\n" for x in (0.0, 0.9)))
    return write_scene(folder / "two.scene",
                       surfaces={"upper": "two.csv", "lower": "plane",
                                 "nominal_area": 4 * length ** 2},
                       material={"contact_modulus": 1e3 * modulus}, loading=loading,
                       effects={"interaction": "coupled", **effects})


def test_influence_is_the_load_over_that_of_isolated_contacts(asperity, tmp_path):
    """Hertz' load of two isolated contacts at the same separation, in closed form."""
    for compression in (0.01, 0.05):
        found = solved(asperity, caps_on_a_plane(
            tmp_path, {"control": "approach", "value": 1 - compression}))
        isolated = 2 * 4 / 3 * 1e3 * 2.0 ** 0.5 * compression ** 1.5
        row = found.positions[0]
        assert float(row["interaction_influence"]) == pytest.approx(
            float(row["load"]) / isolated - 1, abs=1e-12)
        assert -0.5 < float(row["interaction_influence"]) < -0.01


@pytest.mark.parametrize("modulus, length", [(1.0, 1.0), (1e6, 1e-6), (1e-6, 1e3)])
def test_a_path_of_pressures_in_any_units(asperity, tmp_path, modulus, length):
    """The nominal pressure of each state is the one asked for, and the compression scales with the
    unit of length."""
    pressures = [1.0, 4.0, 2.0]
    found = solved(asperity, caps_on_a_plane(
        tmp_path, {"control": "pressure", "value": tuple(p * modulus for p in pressures)},
        modulus, length), curve=True)
    np.testing.assert_allclose(column(found.curve, "nominal_pressure"),
                               np.array(pressures) * modulus, rtol=1e-9)
    plain = solve(asperity, caps_on_a_plane(
        tmp_path, {"control": "pressure", "value": tuple(pressures)}), curve=True)
    np.testing.assert_allclose(1 - column(found.curve, "separation") / length,
                               1 - column(plain.curve, "separation"), rtol=1e-9)


@pytest.mark.parametrize("seed", [0] + [pytest.param(seed, marks=pytest.mark.long)
                                        for seed in (3, 8)])
def test_a_load_beyond_the_centres_is_named(asperity, tmp_path, seed):
    """Thirty caps of radii 0.5 to 30 under a sphere, far beyond what they carry: coupled contacts
    are solved up to the largest compression, where isolated ones would penetrate many times."""
    random = np.random.default_rng(seed)
    caps = np.c_[random.uniform(0, 3, (30, 2)), 0.3 + random.exponential(0.02, 30),
                 random.choice((0.5, 1.0, 2.0, 30.0), 30)]
    scene = write_scene(
        tmp_path / "deep.scene",
        surfaces={"upper": write_surface(tmp_path / "u.csv", [(1.5, 1.5, 0.306, 1.0)]),
                  "lower": write_surface(tmp_path / "l.csv", caps.tolist())},
        material={"contact_modulus": 8893.79}, effects={"interaction": "coupled"},
        loading={"control": "vertical_load", "value": 42222.1})
    done = solve(asperity, scene)
    assert done.status == 1 and "larger than the surfaces carry" in done.stderr, done.stderr
