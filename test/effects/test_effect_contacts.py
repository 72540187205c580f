"""Interaction in scenes of a few contacts and of many caps, against truths made apart.

The truth of `boundary` is boundary_truth.py; that of `coupled` is the same, and its own equations
evaluated in coupled_truth.py.
"""

import numpy as np
import pytest

from boundary_equations import evaluate
from boundary_truth import sneddon
from coupled_truth import leftover
from effect_runs import (CAP, CELLS, COMBINED, CONVERGED, COUPLED_APART, FLAT, MODULUS, RATIO,
                         random_caps, write_caps)
from judge import column, compare, solved
from surfaces_csv import write_csv_scene


def one_pair(folder, penetration, **effects):
    """Two spheres of the thesis one above the other, first touch at zero."""
    top = [(0.0, 0.0, 0.5, CAP)]
    return write_csv_scene(folder, top, [(0.0, 0.0, -0.5, CAP)], modulus=(MODULUS, MODULUS),
                           ratio=(RATIO, RATIO), effects=effects,
                           loading={"control": "approach", "value": -float(penetration)})


@pytest.mark.parametrize("circle", (0.01, 0.03, 0.0937))
def test_one_aligned_pair_on_boundary_elements(circle, asperity, tmp_path):
    """Hertz: together over alone is 1, the load is the law's, both to the discretisation error of
    elements. The last circle is as large as the thesis' contacts."""
    penetration, _ = sneddon(CAP, circle)
    run = solved(asperity, one_pair(tmp_path, penetration, interaction="boundary"))
    found = float(run.positions[0]["load"])
    hertz = 4 / 3 * COMBINED * np.sqrt(CAP / 2) * penetration ** 1.5
    allowed = min(0.1 * CELLS, float(run.positions[0]["error_estimate"]))
    compare("effects: one pair, boundary against Hertz", [abs(found / hertz - 1)], allowed)
    assert float(run.positions[0]["factor"]) == pytest.approx(found / hertz, abs=1e-12)
    assert float(run.contacts[0]["area"]) == pytest.approx(np.pi * circle ** 2, rel=0.05)
    alone = solved(asperity, one_pair(tmp_path, penetration, interaction="coupled"))
    assert float(alone.positions[0]["load"]) == pytest.approx(hertz, rel=1e-12)
    assert alone.positions[0]["factor"] == "1.0000000000000000E+000"


def compression_of(run):
    return float(run.curve[-1]["compression"])


@pytest.mark.truth
def test_deep_contact_opens_a_shallow_one(asperity, tmp_path):
    """A cap that touched alone stands free beside one that is pressed deep; a little higher, it
    touches. Against cells, and the truth of the cells."""
    for height, is_open in ((0.9895, True), (0.9925, False), (0.9995, False)):
        caps = write_caps(tmp_path, [(0, 0), (0.3, 0)], [1.0, height],
                          loading={"control": "approach", "value": 2.0 - 0.012},
                          effects={"interaction": "coupled"})
        runs = {"coupled": solved(asperity, caps.scene)}
        write_caps(tmp_path, [(0, 0), (0.3, 0)], [1.0, height],
                   loading={"control": "approach", "value": 2.0 - 0.012},
                   effects={"interaction": "boundary"})
        runs["boundary"] = solved(asperity, caps.scene)
        closing = compression_of(runs["coupled"])
        found = evaluate(caps.contacts(closing), COMBINED, ("4",))
        assert (found["loads"][1] == 0.0) == is_open and found["loads_alone"][1] > 1.0
        for mode, run in runs.items():
            assert int(run.positions[0]["contacts"]) == sum(v > 0 for v in found["loads"]), mode
            compare(f"effects: factor beside a deep contact, {mode}",
                   [abs(float(run.positions[0]["factor"]) - found["factor"])], COUPLED_APART)


@pytest.mark.parametrize("mode", ("coupled", "boundary", "auto"))
def test_position_without_contact(mode, asperity, tmp_path):
    upper, lower = [(0.0, 0.0, 0.5, CAP)], [(0.0, 0.0, 0.5, CAP)]
    run = solved(asperity, write_csv_scene(
        tmp_path, upper, lower, motion={"x_first": 0.0, "x_step": 50.0, "positions": 2},
        loading={"control": "limit"}, limit={"criterion": "load", "value": 300.0},
        effects={"interaction": mode, "friction": "on", "friction_coefficient": 0.2}))
    assert "no contact at 1 position" in run.stdout
    empty = run.positions[1]
    assert empty["contacts"] == "0" and float(empty["load"]) == 0.0
    assert empty["interaction"] == empty["friction"] == "off"
    assert {float(empty[name]) for name in ("alone_load", "cells", "rig_force_x")} == {0.0}
    assert [row["position"] for row in run.contacts] == ["1"]


# Caps on a plane. Only loads of Hertz' law are corrected by the curvature of the field. A high
# cap far away flows: so the law is another one, and all others, which do not flow, keep the
# equations of the potential.
FLOWS = {"interaction": "coupled", "plasticity": "on", "plastic_yield_stress": 7500.0}


def with_one_that_flows(places, heights):
    """Caps, and the high one."""
    return np.append(places, [[30.0, 0.0]], axis=0), np.append(heights, 1.02)


def check_caps(run, caps, name):
    """A surface of caps at a compression: its equations, and the open contacts."""
    assert "plastic" in run.contacts[0]
    row = run.positions[0]
    assert float(row["interaction_residual"]) <= CONVERGED
    closing, gaps = compression_of(run), caps.gaps()
    shut = column(run.contacts, "lower").astype(int) - 1
    assert len(set(shut)) == len(shut) == int(row["contacts"])
    opened = np.setdiff1d(np.flatnonzero(gaps < closing), shut)
    radius = CAP * FLAT / (CAP + FLAT)
    rest, closed = leftover(caps.places[shut], radius, (closing - gaps)[shut],
                            column(run.contacts, "penetration"),
                            np.sqrt(radius * column(run.contacts, "penetration")),
                            column(run.contacts, "vertical_load"), COMBINED,
                            caps.places[opened], (closing - gaps)[opened])
    print(f"{name}: {len(shut)} contacts, {len(opened)} opened, "
          f"{row['overlapping_circles']} pairs of circles overlap, {row['interaction_iterations']} "
          f"iterations, open ones stay {-closed:.1e} apart")
    # Where circles overlap the quadrature is coarse: that holds the worst, not the many.
    compare(f"effects: {name}, equations", np.abs(rest), 1e-3)
    assert np.median(np.abs(rest)) < 1e-5
    assert closed < 1e-3
    return opened


@pytest.mark.truth
@pytest.mark.parametrize("count, sides, seed, compression, least", [
    (400, (3.4, 4.5), 7, 0.0288, 50), (400, (3.4, 4.5), 8, 0.0288, 50),
    (400, (3.4, 4.5), 9, 0.0288, 50), (2000, (7.6, 10.0), 7, 0.036, 500)])
def test_many_caps(count, sides, seed, compression, least, asperity, tmp_path):
    """Caps of 1.27 cm anywhere on the plane, many nearly coincident; 20 kN on 2000 of them."""
    caps = write_caps(tmp_path, *with_one_that_flows(*random_caps(count, *sides, seed)),
                      loading={"control": "compression", "value": compression}, effects=FLOWS)
    run = solved(asperity, caps.scene)
    assert len(check_caps(run, caps, f"{count} caps")) > least


@pytest.mark.truth
def test_some_caps_against_the_truth(asperity, tmp_path):
    """The sum of loads that the truth of the cells finds at the compression the program found."""
    places, heights = random_caps(8, 1.2, 1.2, 3)
    found, closing = None, None
    for mode, bound in (("coupled", 0.002), ("boundary", 2 * CELLS)):
        caps = write_caps(tmp_path, places, heights, loading={"control": "load", "value": 2000.0},
                          effects={"interaction": mode})
        run = solved(asperity, caps.scene)
        if closing != compression_of(run):
            closing = compression_of(run)
            found = evaluate(caps.contacts(closing), COMBINED, ("4",))
        assert sum(v > 0 for v in found["loads"]) == len(run.contacts) < len(found["loads"])
        compare(f"effects: load of 8 caps, {mode}", [abs(found["together"] / 2000.0 - 1)], bound)
        assert found["factor"] < 0.6
