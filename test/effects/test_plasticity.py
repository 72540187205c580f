"""Plastic flow, as `asperity solve` does it, against the published formulas of plastic_truth.py."""

import random

import mpmath
import numpy as np
import pytest
from mpmath import mpf

from ball_scenes import balls, path, work
from effect_runs import DECK
from judge import column, compare, relative, solved
from plastic_truth import BETWEEN, POINTS, STEEL, Sphere, unloading
from surfaces_csv import write_csv_scene, write_plane_scene, write_scene

ONSET = 1.9 * float(STEEL.critical_overlap)
# The steel of Jackson and Green: on a rigid flat, or on its like with twice the modulus.
SIDES = ("upper", "lower")
MATERIAL = {"modulus": float(STEEL.modulus), "ratio": 0.32}
ON = {"plasticity": "on", "plastic_yield_stress": 0.9115}


def pressed(asperity, folder, closings, points=None, effects=ON, name="steel",
            contacts=True, **more):
    """One contact of the steel, closed as stated."""
    return solved(asperity, balls(folder, name, effects, path(closings, points), **MATERIAL,
                                  **more), contacts=contacts)


def overlaps(run):
    """Compressions over the critical overlap, with many digits."""
    return [mpf(float(row["compression"])) / STEEL.critical_overlap for row in run.curve]


def test_published_curve(asperity, tmp_path):
    """Ten points of Jackson and Green; below x = 6 the join that docs/theory/plasticity.md has."""
    wanted = sorted(map(float, (*BETWEEN, *POINTS)))
    run = pressed(asperity, tmp_path, [x * ONSET / 1.9 for x in wanted])
    x = overlaps(run)
    joined = sum(float(v) < 5.99 for v in x)
    assert len(x) == 15 and joined == 5
    load = relative(column(run.curve, "load"), [STEEL.joined(v) * STEEL.critical_load for v in x])
    area = relative(column(run.curve, "area"), [STEEL.area(v) * STEEL.critical_area for v in x])
    published = relative(column(run.curve, "load")[joined:],
                    [STEEL.published(v) * STEEL.critical_load for v in x[joined:]])
    compare("plasticity: published load, ten points", published, 1e-13)
    compare("plasticity: load, joined", load[:joined], 1e-13)
    compare("plasticity: area", area, 1e-13)
    # Kogut and Etsion 2002, J. Appl. Mech. 69, 657: another finite element study, up to 110.
    other = [1.40 * float(v) ** 1.263 * float(STEEL.critical_load) for v in x[joined:-1]]
    compare("plasticity: load of another study",
            relative(column(run.curve, "load")[joined:-1], other), 0.043)
    assert [row["plastic"] for row in run.contacts] == ["1.0000000000000000E+000"] * 15


def test_hertz_below_onset(asperity, tmp_path):
    """A hair below the onset every common column is that without plasticity; a hair above not."""
    below, above = ONSET * (1 - 1e-12), ONSET * (1 + 1e-9)
    on, without = (pressed(asperity, tmp_path, (0.3 * ONSET, 0.7 * ONSET, below, above),
                           effects=effects, name=name)
                   for effects, name in ((ON, "on"), ({"plasticity": "off"}, "off")))
    same = [all(a[key] == b[key] for key in b) for a, b in zip(on.contacts, without.contacts)]
    assert same == [True, True, True, False]
    assert [float(row["plastic"]) for row in on.contacts] == [0, 0, 0, 1]
    change = abs(float(on.contacts[3]["load"]) / float(without.contacts[3]["load"]) - 1)
    assert 1e-13 < change < 1e-8


def test_limit_is_onset(asperity, tmp_path):
    """The limit of the scene as onset: the load at it is the limit, past it the law of Sy."""
    limit = 1.9**1.5 * float(STEEL.critical_load)
    effects = {"plasticity": "on"}
    by_limit = pressed(asperity, tmp_path, np.array([1.0, 1.5, 3, 10]) * ONSET, effects=effects,
                       name="limit", limit={"criterion": "load", "value": limit})
    by_stress = pressed(asperity, tmp_path, np.array([1.0, 1.5, 3, 10]) * ONSET)
    for name in ("load", "area"):
        compare(f"plasticity: onset by limit, {name}",
                relative(column(by_limit.curve, name), column(by_stress.curve, name)), 1e-12)
    assert [row["limit_exceeded"] for row in by_limit.contacts] == ["1"] * 4
    # First yield by Hardy is 1.9 times earlier in overlap: C Sy = 2.76 times the shear stress.
    shear = float(STEEL.c * STEEL.yield_stress) / 2.76
    hardy = pressed(asperity, tmp_path, np.array([1.0, 1.5, 3, 10]) * ONSET, effects=effects,
                    name="hardy", limit={"criterion": "hardy", "yield_stress": shear})
    compare("plasticity: onset by Hardy's yield",
            relative(column(hardy.curve, "load"), column(by_stress.curve, "load")), 1e-12)


def onsets(asperity, folder):
    """Compressions 1e-13 apart through the onset, the end of the join and the largest overlap."""
    largest = 12 / 1.9 * ONSET
    return [pressed(asperity, folder, start * (1 + 1e-13 * np.arange(-30, 31)), name=name)
            for name, start in (("onset", ONSET), ("join", 6 / 1.9 * ONSET))] + [
        pressed(asperity, folder, [largest, *largest * (1 - 1e-13 * np.arange(0, 40))],
                name="turn")]


def test_load_and_area_do_not_jump(asperity, tmp_path):
    """Load and area do not jump, seen with steps of 1e-13."""
    for place, run in zip(("onset", "end of the join", "turn"), onsets(asperity, tmp_path)):
        for name in ("load", "area"):
            values = column(run.curve, name)
            jumps = np.abs(np.diff(values)) / values[:-1]
            compare(f"plasticity: jump of {name}, {place}", jumps, 1e-12)


@pytest.mark.parametrize("tops", [(2.5, 3), (3, 5), (10, 20), (50, 100)])
def test_unloading_is_the_published_curve(asperity, tmp_path, tops):
    """Down and up again on the curve of Etsion, Kligerman and Kadin, then on by the first one: just
    past the onset, too."""
    top, further = (x * ONSET / 1.9 for x in tops)
    run = pressed(asperity, tmp_path, (top, 0, top, further, 0), 40)
    up, down, again, on, last = (run.curve[1 + 40 * i : 41 + 40 * i] for i in range(5))
    for name, curve, start in (("unloading", down, up[-1]), ("again", again, up[-1]),
                               ("second unloading", last, on[-1])):
        x_top = mpf(float(start["compression"])) / STEEL.critical_overlap
        residual, load_power, area_power = unloading(x_top)
        share = [max(mpf(0), (mpf(float(row["compression"]))
                             / float(start["compression"]) - residual)
                     / (1 - residual)) for row in curve]
        for column_name, power, full in (
                ("load", load_power, STEEL.joined(x_top) * STEEL.critical_load),
                ("area", area_power, STEEL.area(x_top) * STEEL.critical_area)):
            true = [full * s**power for s in share]
            # Near the residual overlap the share itself cancels.
            errors = [e * min(1.0, float(s)) for e, s in
                      zip(relative(column(curve, column_name), true), share)]
            compare(f"plasticity: {name}, {column_name}", errors, 1e-13)
        flat = [row for row, s in zip(curve, share) if s == 0]
        assert flat and all(float(row["load"]) == 0 == float(row["area"]) for row in flat)
    x = [mpf(float(row["compression"])) / STEEL.critical_overlap for row in on]
    compare("plasticity: loading on",
            relative(column(on, "load"), [STEEL.joined(v) * STEEL.critical_load for v in x]), 1e-13)
    assert again[-1]["load"] == up[-1]["load"]


@pytest.mark.truth
def test_the_work_of_a_cycle_is_that_of_the_column(asperity, tmp_path):
    """Work of a cycle by the trapezoidal rule against the column and against quadrature."""
    tops = (3.0, 6.0, 12.0, 40.0)
    lost, errors = [], []
    for top in tops:
        run = pressed(asperity, tmp_path, (top * ONSET / 1.9, 0), 2000, name=f"cycle{top:g}",
                      contacts=False)
        took = work(run.curve)[-1]
        shown = float(run.positions[0]["dissipated_work"])
        lost.append(took)
        errors.append(abs(took / shown - 1))
        assert took > 0
    compare("plasticity: work of a cycle against its column", errors, 1e-6)
    unit = STEEL.critical_load * STEEL.critical_overlap
    true = [float(STEEL.lost(top) * unit) for top in tops[1:]]
    compare("plasticity: work of a cycle against quadrature", relative(lost[1:], true), 1e-6)
    assert (np.diff(lost) >= 0).all()


@pytest.mark.parametrize("interaction", ("off", "coupled"))
def test_closed_elastic_cycle(interaction, asperity, tmp_path):
    """The thesis model up, down, part up, down: the same loads at the same compressions."""
    effects = {"interaction": interaction}
    scene = write_scene(tmp_path / "cycle.scene", surfaces={"deck": str(DECK)},
                        motion={"x_first": 5.6}, effects=effects,
                        loading={"control": "approach", "value": (0.26, 0.29, 0.26, 0.29),
                                 "points": 60})
    run = solved(asperity, scene)
    first, down, up, last = (run.curve[1 + 60 * i : 61 + 60 * i] for i in range(4))
    loads = {name: column(rows, "load") for name, rows in (
        ("down", down), ("up", up), ("last", last))}
    closings = column(down, "compression")
    assert np.allclose(closings, column(last, "compression"), rtol=0, atol=1e-15)
    assert (loads["last"] > 0).sum() > 45 and column(last, "contacts").max() >= 5
    errors = [relative(loads["last"], loads["down"]),
              relative(loads["up"][:-1], loads["down"][-2::-1])]
    compare(f"elastic cycle, {interaction}: same loads", np.concatenate(errors), 1e-10)
    gained = work(run.curve)
    compare(f"elastic cycle, {interaction}: work left",
            abs(gained[240] - gained[120]) / gained[60], 1e-10)


def test_a_path_of_loads(asperity, tmp_path):
    """Loads up and down are met, with hysteresis, by many contacts of the thesis model."""
    scene = write_scene(tmp_path / "loads.scene", surfaces={"deck": str(DECK)},
                        motion={"x_first": 5.6}, effects={"plasticity": "on"},
                        loading={"control": "load", "value": (4000.0, 500.0, 4000.0, 6000.0, 0.0),
                                 "points": 30})
    run = solved(asperity, scene)
    loads, closing = column(run.curve, "load"), column(run.curve, "compression")
    assert len(loads) == 151
    asked = np.concatenate([np.linspace(a, b, 31)[1:] for a, b in (
        (0, 4000), (4000, 500), (500, 4000), (4000, 6000), (6000, 0))])
    compare("plasticity: loads asked for", relative(loads[1:-1], asked[:-1]), 1e-10)
    assert loads[-1] <= 1e-9 and closing[-1] > 0.003
    up, down, again = closing[1:31], closing[31:61], closing[61:91]
    compare("plasticity: reloading by the same curve", relative(again[:-1], down[-2::-1]), 1e-9)
    assert (np.interp(asked[31:60], asked[:30], up) < down[1:]).all()
    assert work(run.curve)[-1] > 0


@pytest.mark.truth
def test_a_cycle_returns_no_more_work(asperity, tmp_path):
    """Random ways over the thesis model: whenever the load is gone, work was taken."""
    rng = random.Random(6)
    for criterion, number in (("load", "value"), ("hardy", "yield_stress")):
        limit = {"criterion": criterion, number: {"load": 120.0, "hardy": 4000.0}[criterion]}
        for turn in range(4):
            ways = [round(rng.uniform(0.24, 0.29), 4) for _ in range(8)]
            values = tuple(v for way in ways for v in (way, 0.35))
            scene = write_scene(
                tmp_path / f"{criterion}{turn}.scene", surfaces={"deck": str(DECK)},
                motion={"x_first": 5.3 + 0.1 * turn}, limit=limit, effects={"plasticity": "on"},
                loading={"control": "approach", "value": values, "points": 100})
            run = solved(asperity, scene, contacts=False)
            done = work(run.curve)[::100]
            apart = done[2::2]
            assert (column(run.curve[200::200], "load") == 0).all()
            # A trapezoid of a step near first touch is coarse: allow it 1e-4 of what was taken.
            slack = 1e-4 * done.max()
            assert done.max() > 0 and (np.diff(np.concatenate([[0.0], apart])) > -slack).all()
            shown = float(run.positions[0]["dissipated_work"])
            assert abs(apart[-1] / shown - 1) < 5e-3, (apart[-1], shown)


def test_with_friction(asperity, tmp_path):
    """The tangential load is mu times the plastic one where a contact slides, else less."""
    groups = {"surfaces": {"deck": str(DECK)}, "motion": {"x_first": 5.6},
              "loading": {"control": "approach", "value": 0.23}}
    plastic = solved(asperity, write_scene(tmp_path / "plastic.scene", **groups,
                                           effects={"plasticity": "on"}))
    both = solved(asperity, write_scene(tmp_path / "both.scene", **groups, effects={
        "plasticity": "on", "friction": "on", "friction_coefficient": 0.1}))
    names = ("load", "area", "plastic", "largest_overlap", "maximum_pressure")
    same = [[a[name] for name in names] == [b[name] for name in names]
            for a, b in zip(plastic.contacts, both.contacts, strict=True)]
    assert all(same) and sum(float(row["plastic"]) for row in both.contacts) >= 3
    load, tangential = column(both.contacts, "load"), column(both.contacts, "tangential_load")
    sliding = column(both.contacts, "sliding") == 1
    assert sliding.any()
    compare("plasticity: friction of sliding contacts",
            relative(tangential[sliding], 0.1 * load[sliding]), 1e-14)
    assert (tangential <= 0.1 * load * (1 + 1e-14)).all()
    slope = column(both.contacts, "slope")
    cosine = 1 / np.sqrt(1 + slope**2)
    compare("plasticity: vertical load with friction",
            relative(column(both.contacts, "vertical_load"),
                cosine * (load + tangential * slope)), 1e-12)


def plastic_of_the_thesis():
    """Both bodies are of it, flowing from 6000 N/cm2; the exponent of the area as documented."""
    body = mpf(275760) / 2  # half: a rigid flat has none
    sphere = Sphere(body, "0.42", "6000", "0.635")
    sphere.b = min(sphere.b, mpf("0.14") * mpmath.exp(
        23 * mpf("1.619") * (1 - mpf("0.32")**2) / 200))
    return sphere


def model(asperity, folder, name, approaches, points=None, **effects):
    """The thesis model at its position 56."""
    loading = {"control": "approach", "value": approaches}
    if points:
        loading["points"] = points
    return solved(asperity, write_scene(
        folder / f"{name}.scene", surfaces={"deck": str(DECK)}, motion={"x_first": 5.6},
        loading=loading, effects={"plastic_yield_stress": 6000.0, **effects}))


def test_with_interaction(asperity, tmp_path):
    """With neighbours each contact still follows its own curve, at its own overlap."""
    run = model(asperity, tmp_path, "both", 0.23, plasticity="on", interaction="coupled")
    sphere = plastic_of_the_thesis()
    rows = [row for row in run.contacts if float(row["load"]) > 0]
    x = [mpf(float(row["overlap"])) / sphere.critical_overlap for row in rows]
    assert max(x) > 6 and max(column(rows, "lowered")) > 1e-4
    compare("plasticity: loads with neighbours",
            relative(column(rows, "load"),
                     [sphere.joined(v) * sphere.critical_load for v in x]), 1e-11)
    # The curvature of the field of neighbours changes areas of elastic contacts only.
    compare("plasticity: areas with neighbours",
            relative(column(rows, "area"),
                     [sphere.area(v) * sphere.critical_area for v in x]), 1e-11)
    alone = model(asperity, tmp_path, "alone", 0.23, plasticity="on")
    elastic = model(asperity, tmp_path, "elastic", 0.23, interaction="coupled")
    total, lonely, stiff = (float(r.positions[0]["vertical_load"])
                            for r in (run, alone, elastic))
    assert total < lonely and total < stiff


def test_unloading_with_interaction(asperity, tmp_path):
    """Flattened contacts open one after the other; those left follow their own curves."""
    run = model(asperity, tmp_path, "cycle", (0.215, 0.29), 80, plasticity="on",
                interaction="coupled")
    sphere, errors = plastic_of_the_thesis(), []
    down = run.curve[81:]
    loads = column(down, "load")
    assert (np.diff(loads) <= 0).all() and loads[-1] == 0
    assert len({row["contacts"] for row in down}) > 5
    for row in run.contacts:
        x_top = mpf(float(row["largest_overlap"])) / sphere.critical_overlap
        if int(row["step"]) < 82 or x_top < 6:
            continue
        residual, power, _ = unloading(x_top)
        share = (mpf(float(row["overlap"])) / float(row["largest_overlap"]) - residual) / (
            1 - residual)
        true = sphere.published(x_top) * sphere.critical_load * max(share, mpf(0)) ** power
        errors.append(float(abs(float(row["load"]) - true) / (
            sphere.published(x_top) * sphere.critical_load)))
    assert len(errors) > 300
    compare("plasticity: unloading with neighbours", errors, 1e-12)
    taken, left = work(run.curve)[80], work(run.curve)[-1]
    assert 0 < left < taken


def test_auto_at_the_onset(asperity, tmp_path):
    """`auto` waits until flow changes the load by the tolerance, and reports its estimate."""
    load = 1.9**1.5 * float(STEEL.critical_load)
    effects = {"plasticity": "auto", "plastic_yield_stress": 0.9115, "tolerance": 0.01}
    for times, wanted in ((0.999, "off"), (1.001, "off"), (1.2, "on")):
        scene = balls(tmp_path, f"auto{times}", effects,
                      {"control": "load", "value": times * load}, **MATERIAL)
        run = solved(asperity, scene)
        row = run.positions[0]
        assert row["plasticity"] == wanted, times
        assert (float(row["plasticity_estimate"]) > 0) == (times > 1)
        assert float(row["load"]) == pytest.approx(times * load, rel=1e-10)


@pytest.mark.parametrize("body", [None, "upper", "lower"])
@pytest.mark.parametrize("ball", ["upper", "lower"])
def test_body_that_yields(ball, body, asperity, tmp_path):
    """A ball of nu = 0.49 on a rigid plane of nu = 0.3, by the law of Jackson and Green with C of
    the body that the scene names, by default of the ball, which is softer."""
    flat = "upper" if ball == "lower" else "lower"
    yields = body or ball
    poisson = {ball: "0.49", flat: "0.3"}
    modulus = mpf(1000) / (1 - mpf("0.49")**2)
    nu = mpf(poisson[yields])
    law = Sphere(modulus * (1 - nu**2), nu, "2", "1")
    (tmp_path / "ball.csv").write_text("x,y,height,radius\n0,0,0.5,1\n")
    x = (10, 40, 90)
    run = solved(asperity, write_scene(
        tmp_path / "ball.scene", surfaces={ball: "ball.csv", flat: "plane"},
        material={"elastic_modulus": [1000 if side == ball else 1e30 for side in SIDES],
                  "poisson_ratio": [float(poisson[side]) for side in SIDES]},
        loading={"control": "approach",
                 "value": tuple(0.5 - v * float(law.critical_overlap) for v in x)},
        effects={"interaction": "off", "plasticity": "on", "plastic_yield_stress": 2.0,
                 **({"plastic_body": body} if body else {})}))
    assert f"the {yields} body yields" in run.stdout
    curve = run.curve[-len(x):]
    w = [mpf(row["separation"]) for row in curve]
    x = [(mpf("0.5") - v) / law.critical_overlap for v in w]
    load = relative(column(curve, "load"), [law.published(v) * law.critical_load for v in x])
    area = relative(column(curve, "area"), [law.area(v) * law.critical_area for v in x])
    assert max(*load, *area) < 1e-11, (load, area)


@pytest.mark.parametrize("modulus, ratio, yields", [
    ((1e3, 2e3), (0.3, 0.3), "upper"), ((2e3, 1e3), (0.2, 0.4), "lower"),
    ((1e3, 1e3), (0.4, 0.2), "lower"), ((1e3, 1e3), (0.2, 0.4), "upper")])
def test_softer_body_yields(modulus, ratio, yields, asperity, tmp_path):
    """The smaller modulus; of equal moduli the smaller Poisson's ratio."""
    run = solved(asperity, write_plane_scene(
        tmp_path, [(0, 0, 0.5, 1)], None, modulus, ratio,
        loading={"control": "approach", "value": 0.499},
        effects={"plasticity": "on", "plastic_yield_stress": 2.0}))
    assert f"the {yields} body yields" in run.stdout


@pytest.mark.parametrize("stress", [6000.0, 60000.0])
def test_load_with_interaction(stress, asperity, tmp_path):
    """The load that an approach gave is carried there, whether contacts flow or not: a load is
    searched with Hertz' law, and its corrected solution was taken for that of the law here."""
    effects = {"plasticity": "on", "interaction": "coupled", "plastic_yield_stress": stress}
    first = model(asperity, tmp_path, "first", 0.2, **effects).positions[0]
    again = solved(asperity, write_scene(
        tmp_path / "again.scene", surfaces={"deck": str(DECK)}, motion={"x_first": 5.6},
        loading={"control": "load", "value": float(first["load"])}, effects=effects)).positions[0]
    for name in ("separation", "vertical_load", "area"):
        assert float(again[name]) == pytest.approx(float(first[name]), rel=1e-9), name


@pytest.mark.parametrize("interaction", ["off", "coupled"])
def test_contacts_flow_at_every_equal_load(interaction, asperity, tmp_path):
    """Loads are met to 1e-6: a contact that is that near to its largest overlap flows."""
    flowing = [float(solved(asperity, write_scene(
        tmp_path / "equal.scene", surfaces={"deck": str(DECK)}, motion={"x_first": 5.6},
        loading={"control": "load", "value": values},
        effects={"plasticity": "on", "interaction": interaction})).positions[0]["contacts_flowing"])
               for values in ((4000.0,), (4000.0, 4000.0), (4000.0, 500.0, 4000.0),
                              (4000.0, 3999.9))]
    assert flowing[0] > 5 and flowing == [*3 * flowing[:1], 0]


@pytest.mark.parametrize("upper, lower, values, points", [
    (((2.38, 2.06, 0.11, 2.73), (2.36, 2.11, 0.1, 1.42)),
     ((1.34, 1.42, 0.1, 1.61), (1.41, 1.77, 0.1, 1.5), (1.71, 1.81, 0.1, 1.84)),
     (29.6, 0.116, 0.905), 0),
    (((0.365, 1.678, 0.086, 2.877), (0.354, 1.004, 0.1, 1.568)),
     ((1.409, 1.504, 0.098, 2.203), (0.552, 1.685, 0.087, 1.81)), (12.51, 4.492, 0.102), 3)])
def test_a_step_releases_flattened_contacts(upper, lower, values, points, asperity, tmp_path):
    """Flattened contacts open at their residual penetration, not at 0: with the energy from 0 the
    trust region shrinks to nothing about a state that is no solution."""
    loading = {"control": "load", "value": values, "points": points}
    run = solved(asperity, write_csv_scene(
        tmp_path, upper, lower, modulus=(1e3, 3e3), ratio=(0.3, 0.2), loading=loading,
        effects={"interaction": "coupled", "plasticity": "on", "plastic_yield_stress": 3.0}))
    assert float(run.positions[0]["load"]) == pytest.approx(values[-1], rel=1e-9)
