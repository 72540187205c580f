"""Laws that every answer of `asperity solve` must obey, on random scenes.

Coordinates are multiples of 2**-10 below 16: sums and differences of them are exact, so moving and
turning the surfaces changes no bit unless the law's own arithmetic rounds. "Bit for bit" holds in
builds that do not contract to fused multiply-add, as gfortran on x86-64 without -march.
"""

import random

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from exact_contact import TOTALS
from surfaces_csv import solve, write_csv_scene

pytestmark = pytest.mark.fuzz

FEW = settings(max_examples=40)
UNIT = 2.0 ** -10
SAME = ("separation", "contacts", "limit_reached", *TOTALS)
CONTACT = ("area", "projected_area", "slope", "load", "average_pressure", "maximum_pressure",
           "limit_exceeded", "vertical_load", "penetration", "overlap")


def grid(low, high):
    """Multiples of UNIT from low to high."""
    return st.integers(round(low / UNIT), round(high / UNIT)).map(lambda n: n * UNIT)


def surfaces(least=1):
    asperity = st.tuples(grid(0, 6), grid(0, 6), grid(0.25, 0.5), grid(0.75, 2))
    return st.lists(asperity, min_size=least, max_size=12)


SLOPES = st.tuples(grid(-0.02, 0.02), grid(-0.02, 0.02))
SHIFT = st.tuples(grid(-1, 1), grid(-1, 1))
LOADINGS = st.one_of(
    st.just({"control": "limit"}),
    st.fixed_dictionaries({"control": st.just("load"),
                           "value": st.floats(1e-3, 1e4)}),
    st.fixed_dictionaries({"control": st.just("approach"), "value": grid(0.3, 0.9)}))
SCENES = st.fixed_dictionaries({
    "upper": surfaces(), "lower": surfaces(), "upper_slope": SLOPES, "lower_slope": SLOPES,
    "shift": SHIFT, "loading": LOADINGS})


@pytest.fixture(scope="module")
def run(asperity, tmp_path_factory):
    """Solve a scene given as a dict; None when it cannot be computed."""
    folder = tmp_path_factory.mktemp("laws")

    def run_scene(scene, **changed):
        scene = {**scene, **changed}
        x, y = scene["shift"]
        path = write_csv_scene(
            folder, scene["upper"], scene["lower"],
            modulus=scene.get("modulus", (2.0e5, 1.0e5)), ratio=scene.get("ratio", (0.3, 0.25)),
            tilt={"upper_slope": scene["upper_slope"], "lower_slope": scene["lower_slope"],
                  "rotation": scene.get("rotation", (0.0, 0.0))},
            motion={"x_first": x, "y_first": y}, loading=scene["loading"],
            limit=scene.get("limit", {"criterion": "load", "value": 500.0}))
        for left in folder.glob("*scene-*"):
            left.unlink()
        solved = solve(asperity, path, curve=True)
        assert solved.status in (0, 1), solved.stderr
        return solved if solved.status == 0 else None

    return run_scene


def totals(solved):
    return tuple(solved.positions[0][name] for name in SAME)


def contacts(solved, extra=()):
    """Contact rows without their names, in an order of their own."""
    return sorted(tuple(row[name] for name in (*CONTACT, *extra)) for row in solved.contacts)


def test_order_of_tied_asperities(run):
    """Eight pairs that touch at the very same approach, by Pythagorean triangles; their sums must
    not depend on who comes first."""
    triangles = [(5, 3, 4), (5, 4, 3), (13, 12, 5), (13, 5, 12), (17, 15, 8), (17, 8, 15),
                 (25, 7, 24), (25, 24, 7)]
    pairs = []
    for i, (s, d, zc) in enumerate(triangles):
        r, height = s / 32, (4 + s - zc) / 32
        if i == len(triangles) - 1:
            height = 1.5  # one tall asperity makes all pairs near enough
        pairs.append(((2.0 * i, 0.0, height, r),
                      (2.0 * i + d / 16, 0.0, (4 + s - zc) / 16 - height, r)))
    seen = set()
    for seed in range(12):
        upper, lower = ([pair[side] for pair in pairs] for side in (0, 1))
        random.Random(seed).shuffle(upper)
        random.Random(-seed).shuffle(lower)
        solved = run({"upper": upper, "lower": lower, "upper_slope": (0.0, 0.0),
                      "lower_slope": (0.0, 0.0), "shift": (0.0, 0.0),
                      "loading": {"control": "approach", "value": 0.15}})
        assert len(solved.contacts) == len(pairs)
        assert len({row["penetration"] for row in solved.contacts}) == 1
        seen.add((totals(solved), tuple(contacts(solved, "xy"))))
    assert len(seen) == 1


@FEW
@given(scene=SCENES, by=st.tuples(st.floats(-10, 10), st.floats(-10, 10)))
def test_common_shift_of_tilted_surfaces(run, scene, by):
    """Nothing is exact here: heights and places may round by 2**-49 (of 16 to 32). A load grows
    with the power 1.5 of a penetration, so its error is at most some ulps over the closing."""
    scene = {**scene, "loading": {"control": "limit"}, "lower_slope": scene["upper_slope"]}
    moved = {side: [(x + by[0], y + by[1], h, r) for x, y, h, r in scene[side]]
             for side in ("upper", "lower")}
    one, two = run(scene), run(scene, **moved)
    assert (one is None) == (two is None)
    if one is None or not one.contacts:
        return
    closing = float(one.curve[0]["compression"])
    for name in (*TOTALS, "separation"):
        expected = float(one.positions[0][name])
        assert abs(float(two.positions[0][name]) - expected) <= (
            20 * 2.0 ** -49 / min(closing, 1.0) * abs(expected) + 20 * 2.0 ** -49 * (
                name == "separation"))


@FEW
@given(scene=SCENES, steps=st.integers(2, 40))
def test_nothing_falls_while_closing(run, scene, steps):
    solved = run(scene, loading={**scene["loading"], "points": steps})
    assume(solved is not None and solved.contacts)
    for one, two in zip(solved.curve, solved.curve[1:]):
        assert float(one["separation"]) >= float(two["separation"])
        assert int(one["contacts"]) <= int(two["contacts"])
        for name in ("load", "area"):
            assert float(one[name]) <= float(two[name])
    # Also between runs: a little further down, no less of anything.
    end = float(solved.positions[0]["separation"])
    deeper = run(scene, loading={"control": "approach", "value": end - 1e-9})
    if deeper is not None:
        for name in ("contacts", "load", "area"):
            assert float(deeper.positions[0][name]) >= float(solved.positions[0][name])


@FEW
@given(scene=SCENES, closing=st.floats(1e-3, 0.2))
def test_load_and_approach_invert_each_other(run, scene, closing):
    """The approach is a double near 1, so the closing must not be too small for 1e-12."""
    first = run(scene, loading={"control": "load", "value": 1e-200})
    assume(first is not None)
    approach = float(first.positions[0]["separation"]) - closing
    by_approach = run(scene, loading={"control": "approach", "value": approach})
    assume(by_approach is not None)
    load = float(by_approach.positions[0]["load"])
    by_load = run(scene, loading={"control": "load", "value": load})
    again = run(scene, loading={"control": "approach",
                                "value": float(by_load.positions[0]["separation"])})
    assert abs(float(by_load.positions[0]["load"]) / load - 1) <= 1e-14
    assert abs(float(by_load.curve[0]["compression"]) / closing - 1) <= 1e-12
    assert float(by_load.positions[0]["separation"]) == pytest.approx(
        approach, rel=1e-12, abs=1e-15)
    assert abs(float(again.positions[0]["load"]) / load - 1) <= 1e-12
