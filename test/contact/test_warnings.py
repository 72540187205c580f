"""Each kind of warning provoked once, and absent just inside its limit.

The limits are found here from closed forms of Hertz, of the standard linear solid, and from the
geometry of a cap; nothing is taken from the program.
"""

import math
import re

import numpy as np
import pytest

from ball_scenes import balls
from effect_runs import CAP, COMBINED, DECK, MODULUS, RATIO, column
from programs import run_program
from surfaces_csv import solve, write_csv_scene, write_plane_scene, write_scene

# A ball on a ball as large, one above the other: combined radius R/2.
RADIUS = 2.0
INSIDE, OUTSIDE = 0.999, 1.001


def pressed(asperity, folder, overlap, height=1.9, limit=None, **effects):
    """Two balls of radius 2 one above the other, pressed by an overlap."""
    folder.mkdir()
    for name, top in (("upper", height), ("lower", 1.9)):
        (folder / f"{name}.csv").write_text(f"x,y,height,radius\n0,0,{top!r},{RADIUS!r}\n")
    return solve(asperity, write_scene(
        folder / "pair.scene", surfaces={"upper": "upper.csv", "lower": "lower.csv"},
        material={"elastic_modulus": (MODULUS, MODULUS), "poisson_ratio": (RATIO, RATIO)},
        loading={"control": "approach", "value": height + 1.9 - overlap},
        **({"limit": limit} if limit else {}), **({"effects": effects} if effects else {})))


def overlap_of(contact_radius):
    """a**2 = R W."""
    return contact_radius**2 / (RADIUS / 2)


def shown(run, what):
    """The one line of this kind, or none; the column counts what was reported."""
    assert run.status == 0, run.stderr
    lines = [line for line in run.stderr.splitlines() if ": warning: " in line]
    assert all(re.fullmatch(r".+: warning: position \d+( and \d+ more)?: [^,]+, [^,]+, .+", line)
               for line in lines), lines
    if len(run.positions) == 1:
        assert int(run.positions[0]["warnings"]) == len(lines)
    found = [line for line in lines if what in line]
    assert len(found) <= 1
    return found[0] if found else ""


def check_pair(inside, outside, what, size=None):
    assert shown(inside, what) == ""
    line = shown(outside, what)
    assert line, outside.stderr
    if size is not None:
        number = float(re.search(r": [^,]+, (\S+) ", line).group(1))
        assert number == pytest.approx(size, rel=6e-3), line


def test_a_wide_contact_circle_is_warned_of(asperity, tmp_path):
    runs = [pressed(asperity, tmp_path / str(f), overlap_of(0.3 * RADIUS * f))
            for f in (INSIDE, OUTSIDE)]
    check_pair(*runs, "wide for its sphere", 0.3)
    # Far beyond.
    far = pressed(asperity, tmp_path / "far", overlap_of(0.9 * RADIUS))
    assert "0.900 of the radius" in shown(far, "wide for its sphere")


def test_a_circle_beyond_its_cap_is_warned_of(asperity, tmp_path):
    """The edge of the circle at the depth of the plane: 1 - cos(a/r) = h/r on the sphere."""
    height = 0.01
    edge = math.sqrt(RADIUS**2 - (RADIUS - height)**2)
    runs = [pressed(asperity, tmp_path / str(f), overlap_of(edge * f), height=height)
            for f in (INSIDE, OUTSIDE)]
    check_pair(*runs, "base of its spherical cap")


def test_a_steep_contact_is_warned_of(asperity, tmp_path):
    """A pair offset in plan by d touches with slope d/z; nothing is pressed far."""
    def inclined(factor):
        folder = tmp_path / str(factor)
        folder.mkdir()
        slope = 0.3 * factor
        d = 2 * RADIUS * slope / math.hypot(1, slope)
        fall = 2 * RADIUS - math.sqrt(4 * RADIUS**2 - d**2)
        return solve(asperity, write_csv_scene(
            folder, [(d, 0.0, 1.9, RADIUS)], [(0.0, 0.0, 1.9, RADIUS)],
            loading={"control": "approach", "value": 3.8 - fall - 1e-5}))
    check_pair(inclined(INSIDE), inclined(OUTSIDE), "is steep", 0.3)


@pytest.mark.parametrize("given, pressure", [
    ({"plastic_yield_stress": 3000.0}, 3000.0 * 1.295 * math.exp(0.736 * RATIO) / 1.5),
    ({"hardness": 6000.0}, 6000.0), ({"yield_stress": 2000.0}, 2000.0 * 2.76 / 1.5)])
def test_a_pressure_beyond_yield_is_warned_of(given, pressure, asperity, tmp_path):
    """Average pressure 4 E sqrt(W/R)/(3 pi)."""
    overlap = RADIUS / 2 * (0.75 * math.pi * pressure / COMBINED)**2
    effects = {k: v for k, v in given.items() if k == "plastic_yield_stress"}
    limit = {k: v for k, v in given.items() if k not in effects}
    if limit:
        limit["criterion"] = "hardy" if "yield_stress" in given else "greenwood_williamson"
    runs = [pressed(asperity, tmp_path / f"{f}", overlap * f**2, limit=limit, **effects)
            for f in (INSIDE, OUTSIDE)]
    check_pair(*runs, "beyond yield", 1.0)
    plastic = pressed(asperity, tmp_path / "on", overlap * OUTSIDE**2, limit=limit, **effects,
                      plasticity="on")
    assert shown(plastic, "beyond yield") == ""


def caps(asperity, folder, side, overlap, nominal=None, interaction="off", **effects):
    """Four caps on the corners of a square, on a plane."""
    return solve(asperity, write_plane_scene(
        folder, [(x * side, y * side, 0.5, CAP) for x, y in np.ndindex(2, 2)],
        {"nominal_area": nominal} if nominal else {}, (MODULUS, MODULUS), (RATIO, RATIO),
        loading={"control": "approach", "value": 0.5 - overlap},
        effects={"interaction": interaction, **effects}))


def test_overlapping_circles_are_warned_of(asperity, tmp_path):
    overlap = 0.02
    a = math.sqrt(CAP * overlap)
    runs = [caps(asperity, tmp_path / f"{f}", 2 * a / f, overlap, nominal=1e3)
            for f in (INSIDE, OUTSIDE)]
    check_pair(*runs, "contact circles overlap", 4)
    coupled = caps(asperity, tmp_path / "coupled", 2 * a / OUTSIDE, overlap, 1e3, "coupled")
    assert shown(coupled, "contact circles overlap") == ""


def test_crowded_circles_are_warned_of(asperity, tmp_path):
    """Four circles over the nominal area; without one, over that of the box and a distance."""
    overlap, side = 0.01, 1.0
    covered = 4 * math.pi * CAP * overlap
    runs = [caps(asperity, tmp_path / f"{f}", side, overlap, nominal=10 * covered / f)
            for f in (INSIDE, OUTSIDE)]
    check_pair(*runs, "cover much of the area", 10.0)
    # Mean distance 1/2, so the box is 1.5 wide.
    runs = [caps(asperity, tmp_path / f"box{f}", side, 0.1 * 1.5**2 / (4 * math.pi * CAP) * f)
            for f in (INSIDE, OUTSIDE)]
    check_pair(*runs, "cover much of the area", 10.0)


def test_a_tabor_parameter_between_two_laws_is_warned_of(asperity, tmp_path):
    """The law for small parameters between 0.045 and 0.1."""
    def adhering(tabor):
        work, modulus = 0.01, 1000.0
        distance = (RADIUS * work**2 / modulus**2) ** (1 / 3) / tabor
        return solve(asperity, balls(
            tmp_path, f"tabor{tabor}", {"adhesion": "on", "work_of_adhesion": work,
                                        "equilibrium_distance": distance},
            {"control": "approach", "value": -1e-4}, radii=(RADIUS,), modulus=modulus))
    what = "small Tabor parameters"
    check_pair(adhering(0.0449), adhering(0.0451), what, 0.0451)
    check_pair(adhering(0.101), adhering(0.099), what, 0.099)


def held(asperity, folder, overlap, hold="approach", time=6.0, ratio=0.5):
    return pressed(asperity, folder, overlap, creep="on", hold=hold, hold_time=time,
                   relaxation_time=1.0, relaxed_modulus_ratio=ratio)


def test_creep_strain(asperity, tmp_path):
    """Equal bodies: 0.2 a/R times a half is 1 %."""
    runs = [held(asperity, tmp_path / f"{f}", overlap_of(0.1 * RADIUS / 2 * f), time=20.0)
            for f in (INSIDE, OUTSIDE)]
    check_pair(*runs, "beyond the linear range", 1.0)


@pytest.mark.parametrize("hold", ["approach", "load"])
def test_relaxing(hold, asperity, tmp_path):
    """What is still to come is 1 %, the tolerance."""
    r = 0.5
    if hold == "approach":
        # 1 - r/(r + (1 - r) exp(-T)) = 0.01
        time = -math.log(r * (1 / 0.99 - 1) / (1 - r))
    else:
        # ((1/r)/J)**(2/3) = 1.01, J = 1/r - (1/r - 1) exp(-r T)
        time = -math.log((1 / r - (1 / r) / 1.01**1.5) / (1 / r - 1)) / r
    runs = [held(asperity, tmp_path / f"{f}", 1e-4, hold, time * f, r) for f in (1.01, 0.99)]
    check_pair(*runs, "before relaxation is done")


def test_an_uncertain_area_is_warned_of(asperity, tmp_path):
    """Reported where the column of the area's error is above the tolerance, and nowhere else."""
    what = "less sure than the tolerance"

    def caps_by(tolerance):
        run = solve(asperity, write_plane_scene(
            tmp_path, [(0, 0, 0.107, 1), (0.2, 0, 0.1015, 1)], None, (MODULUS, MODULUS),
            (RATIO, RATIO), loading={"control": "approach", "value": 0.0945},
            effects={"interaction": "auto", "tolerance": tolerance}))
        return run, float(run.positions[0]["area_error_estimate"])

    (low, outside), (high, inside) = ((t, caps_by(t)[0]) for t in (0.001, 0.02))
    while high > 1.001 * low:
        middle = (low + high) / 2
        run, size = caps_by(middle)
        assert bool(shown(run, what)) == (size > middle)
        if size > middle:
            low, outside, stated = middle, run, size
        else:
            high, inside = middle, run
    # The elements, and with them the estimate, change in steps with the tolerance.
    check_pair(inside, outside, what, 100 * stated)


def test_a_load_unlike_the_vertical_load_is_warned_of(asperity, tmp_path):
    """One pair whose vertical load is less than its load by the tolerance: 1 - cos."""
    tolerance = 0.01

    def inclined(factor, control="load"):
        folder = tmp_path / f"{factor} {control}"
        folder.mkdir()
        # Pressed by next to nothing, so the slope is that of first touch.
        d = 2 * RADIUS * math.sqrt(1 - (1 - tolerance * factor)**2)
        return solve(asperity, write_csv_scene(
            folder, [(d, 0.0, 1.9, RADIUS)], [(0.0, 0.0, 1.9, RADIUS)],
            loading={"control": control, "value": 1e-6}, effects={"tolerance": tolerance}))
    what = "total normal force and vertical load differ"
    check_pair(inclined(INSIDE), inclined(OUTSIDE), what, 1.0)
    assert shown(inclined(OUTSIDE, "vertical_load"), what) == ""


def test_no_common_theory(asperity, tmp_path):
    """Adhesion and interaction by `auto`, each of more than the tolerance or one of them not."""
    def caps_that_adhere(side, work):
        return caps(asperity, tmp_path / f"{side} {work}", side, 0.001, interaction="auto",
                    adhesion="auto", work_of_adhesion=work, equilibrium_distance=1e-6,
                    tolerance=0.01)
    what = "two effects have no common theory"
    assert shown(caps_that_adhere(1e4, 1.0), what) == ""
    assert shown(caps_that_adhere(0.5, 0.0), what) == ""
    assert shown(caps_that_adhere(0.5, 1.0), what)


def test_effects_left_out_stay_within_one_tolerance(asperity, tmp_path):
    """All that `auto` leaves out at a position adds up to the tolerance at most."""
    tolerance = 0.02
    run = solve(asperity, write_scene(
        tmp_path / "sweep.scene", surfaces={"deck": str(DECK)},
        motion={"x_first": 0.1, "x_step": 0.1, "positions": 100},
        effects={"interaction": "auto", "friction": "auto", "friction_coefficient": 0.3,
                 "tolerance": tolerance}))
    assert run.status == 0, run.stderr
    both, forces = 0, 0.0
    for row in run.positions:
        left = [float(row[f"{name}_estimate"]) for name in ("interaction", "friction")
                if row[name] == "off"]
        assert sum(left) <= tolerance * (1 + 1e-12)
        if row["interaction"] != "off":
            assert sum(left) <= 0.5 * tolerance
            assert float(row["interaction_residual"]) >= 0.0
        else:
            assert row["interaction_influence"] == row["factor"] == ""
            assert row["interaction_residual"] == row["interaction_iterations"] == ""
            assert float(row["error_estimate"]) == pytest.approx(sum(left), rel=1e-12)
        # Each alone would be left out, both together not.
        both += max(float(row[f"{n}_estimate"]) for n in ("interaction", "friction")) \
            <= tolerance < sum(float(row[f"{n}_estimate"]) for n in ("interaction", "friction"))
        if row["friction"] == "off":
            forces = max(forces, math.hypot(float(row["rig_force_x"]), float(row["rig_force_y"]))
                         / float(row["vertical_load"]))
    assert both > 0
    # Left out of the vertical load, friction's forces in plan are reported all the same.
    assert forces > 0.02


TOLD_WHERE_LEFT_OUT = [
    ("friction", {"friction_coefficient": 0.05}, 300.0,
     ("rig_force_x", "rig_force_y", "rig_moment_x", "rig_moment_y", "rig_moment_z",
      "sliding_contacts", "frictionless_load"), ("tangential_load", "lateral_x", "lateral_y")),
    ("plasticity", {"plastic_yield_stress": 5000.0}, (300.0, 100.0),
     ("dissipated_work", "contacts_flowing"), ("largest_overlap", "residual_overlap")),
    ("adhesion", {"work_of_adhesion": 1e-6, "equilibrium_distance": 1e-7}, 300.0,
     ("adhering_contacts", "pull_off_sum"), ("adhering", "pull_off_force", "tabor_parameter"))]


@pytest.mark.parametrize("effect, numbers, load, of_position, of_contacts", TOLD_WHERE_LEFT_OUT)
def test_results_beside_an_effect_left_out(effect, numbers, load, of_position, of_contacts,
                                           asperity, tmp_path):
    """The rig's forces and moments, overlaps that stay, pulls: as with the effect, never 0 or
    missing; and what was not computed is an empty cell."""
    auto, on = (solve(asperity, write_scene(
        tmp_path / f"{mode}.scene", surfaces={"deck": str(DECK)}, motion={"x_first": 5.6},
        loading={"control": "load", "value": load},
        effects={effect: mode, "tolerance": 0.5, **numbers})) for mode in ("auto", "on"))
    row, full = auto.positions[0], on.positions[0]
    assert row[effect] == "off" and full[effect] == "on"
    empty = row[f"{effect}_influence"], row[f"{effect}_residual"], full[f"{effect}_estimate"]
    assert set(empty) == {""}
    for name in of_position:
        assert float(row[name]) == pytest.approx(float(full[name]), rel=1e-9), name
    assert len(auto.contacts) == len(on.contacts)
    for name in of_contacts:
        printed_cells = column(auto.contacts, name)
        assert np.allclose(printed_cells, column(on.contacts, name), rtol=1e-6, atol=0.0), name
        assert np.any(printed_cells != 0.0), name
    if effect == "friction":
        # In plan forces are no less for that.
        assert math.hypot(float(row["rig_force_x"]), float(row["rig_force_y"])) \
            > 5 * float(row["friction_estimate"]) * float(row["vertical_load"])


def test_no_warning_is_printed_twice(asperity, root):
    """The summary of the thesis' deck has totals; its three warnings are on standard error."""
    done = run_program(asperity, "solve", root / "data/thesis.deck")
    lines = [line for line in done.stderr.splitlines() if "warning: " in line]
    assert len(lines) == len(set(lines)) == 3
    assert "total load" in done.stdout and "warning" not in done.stdout
