"""Creep, as `asperity solve` does it, against closed forms and creep_truth.py."""

import math
import re
from itertools import product

import mpmath
import numpy as np
import pytest

import creep_truth as truth
from ball_scenes import balls, path
from effect_runs import DECK, by_position
from judge import column, compare, relative, solved
from programs import run_program
from surfaces_csv import write_scene
from test_creep_pixels import ting

MODULUS, RADIUS, LOAD = 1000.0, 2.0, 0.5
SOLIDS = ((0.8, 100.0, 600.0), (0.5, 1.0, 5.0), (0.01, 30.0, 3000.0), (0.999, 5.0, 1.0))
# What loads are met to, and so compressions and areas.
MET = 1e-10


def solid(ratio, tau, hold_time, hold="load", points=30, **more):
    """Group &effects."""
    return {"creep": "on", "relaxed_modulus_ratio": ratio, "relaxation_time": tau,
            "hold_time": hold_time, "hold": hold, "hold_points": points, **more}


def held(asperity, folder, effects, loading=None, name="ball", **more):
    """A ball under a held load, or as stated."""
    loading = loading or {"control": "load", "value": LOAD}
    more = {"radii": (RADIUS,), "modulus": MODULUS, **more}
    return solved(asperity, balls(folder, name, effects, loading, **more))


def compliance(ratio, tau, times):
    """J(t) E(0), as printed; creep_suite.f90 compares it with a Laplace inversion."""
    return 1 / ratio - (1 / ratio - 1) * np.exp(-ratio * times / tau)


def relaxed(ratio, tau, times):
    return ratio + (1 - ratio) * np.exp(-times / tau)


@pytest.mark.parametrize("ratio, tau, hold_time", SOLIDS)
def test_held_separation(ratio, tau, hold_time, asperity, tmp_path):
    """The load relaxes as the modulus, in every state."""
    run = held(asperity, tmp_path, solid(ratio, tau, hold_time, "approach"), path((0.01,)))
    times, loads = column(run.curve, "time"), column(run.curve, "load")
    assert times[0] == 0 and times[-1] == hold_time and len(times) == 30
    assert (np.diff(times) >= 0).all()
    elastic = 4 / 3 * MODULUS * math.sqrt(RADIUS) * 0.01**1.5
    compare("creep: held approach", relative(loads, elastic * relaxed(ratio, tau, times)), 2e-14)
    compare("creep: elastic load at a held approach",
            relative(column(run.contacts, "elastic_load"), [elastic] * 30), 2e-14)
    assert column(run.positions, "time") == hold_time
    assert relative(column(run.positions, "elastic_load"), [elastic]) < 2e-14
    assert len(set(row["area"] for row in run.curve)) == 1
    peak = 2 * MODULUS / math.pi * math.sqrt(0.01 / RADIUS)
    compare("creep: pressure at a held approach",
            relative(column(run.contacts, "maximum_pressure"),
                     peak * relaxed(ratio, tau, times)), 2e-14)


@pytest.mark.parametrize("ratio, tau, hold_time", SOLIDS)
def test_held_load(ratio, tau, hold_time, asperity, tmp_path):
    """Lee and Radok: a**3 = 3/4 P R J(t); approach and area grow, the pressure falls."""
    run = held(asperity, tmp_path, solid(ratio, tau, hold_time, points=200))
    times, area = column(run.curve, "time"), column(run.curve, "area")
    closing = column(run.curve, "compression")
    compare("creep: load held", relative(column(run.curve, "load"), [LOAD] * 200), MET)
    cube = 0.75 * LOAD * RADIUS / MODULUS * compliance(ratio, tau, times)
    compare("creep: area of Lee and Radok", relative(area, math.pi * cube ** (2 / 3)), MET)
    compare("creep: closing of Lee and Radok", relative(closing, cube ** (2 / 3) / RADIUS), MET)
    peak = column(run.contacts, "maximum_pressure")
    assert (np.diff(area) > 0).all() and (np.diff(closing) > 0).all() and (np.diff(peak) < 0).all()
    # The middle pressure is the hereditary integral of the elastic one, which goes with a.
    with mpmath.workdps(20):
        r, end = mpmath.mpf(repr(ratio)), mpmath.mpf(hold_time)
        j = lambda s: 1 / r - (1 / r - 1) * mpmath.exp(-r * s / tau)
        rate = lambda s: ((1 - r) / tau * mpmath.exp(-r * s / tau) / 3
                          * j(s) ** (-mpmath.mpf(2) / 3))
        true = truth.hereditary(r, tau, end, lambda s: mpmath.cbrt(j(s)), rate)
    compare("creep: pressure, 200 states, quadrature",
            abs(peak[-1] / peak[0] / float(true) - 1), 1e-6 if ratio > 0.1 else 1e-3)


def test_no_time_and_all_time(asperity, tmp_path):
    """No hold and a short one are elastic, an endless one is the relaxed solid."""
    elastic = held(asperity, tmp_path, {"creep": "off"}, name="elastic")
    for name, effects, compliant in (
            ("none", {"creep": "on", "hold_time": 0.0}, 1.0),
            ("short", solid(0.5, 1.0, 1e-14), 1.0), ("short", solid(0.5, 1.0, 1e-300), 1.0),
            ("long", solid(0.5, 1.0, 1e300), 2.0), ("long", solid(0.5, 1.0, 100.0), 2.0),
            ("at once", solid(0.5, 0.0, 1.0), 2.0), ("at once", solid(0.5, 1e-300, 1.0), 2.0),
            ("never", solid(0.5, 1e300, 1.0), 1.0), ("never", solid(1.0, 1.0, 10.0), 1.0)):
        run = held(asperity, tmp_path, effects, name="limit")
        closing = column(run.curve, "compression")
        start = float(elastic.curve[-1]["compression"])
        compare(f"creep: limits, {name}",
                abs(closing[-1] / (start * compliant ** (2 / 3)) - 1), MET)
        compare("creep: limits, load",
                relative(column(run.curve, "load"), [LOAD] * len(closing)), MET)
    for tau, share in ((0.0, 0.5), (1e-300, 0.5), (1e300, 1.0)):
        run = held(asperity, tmp_path, solid(0.5, tau, 1.0, "approach"), path((0.01,)))
        loads = column(run.curve, "load")
        compare("creep: limits, held approach",
                relative(loads[1:], [share * loads[0]] * (len(loads) - 1)), 1e-15)


def test_thesis_model_at_a_separation(asperity, tmp_path):
    """With neighbours every load relaxes by the same factor; the contact circles stay."""
    effects = solid(0.8, 100.0, 600.0, "approach", 12, interaction="coupled")
    run = solved(asperity, write_scene(
        tmp_path / "creep.scene", surfaces={"deck": str(DECK)}, motion={"x_first": 5.3,
        "x_step": 0.1, "positions": 4}, loading={"control": "approach", "value": 0.27},
        effects=effects))
    errors = []
    for rows in by_position(run.contacts).values():
        steps = {int(row["step"]): {} for row in rows}
        for row in rows:
            steps[int(row["step"])][row["area_no"]] = row
        curve = [row for row in run.curve if row["position"] == rows[0]["position"]]
        factors = relaxed(0.8, 100.0, column(curve, "time"))
        assert len(factors) == len(steps) == 12
        for number, factor in enumerate(factors, 1):
            assert steps[number].keys() == steps[1].keys()
            now, start = list(steps[number].values()), list(steps[1].values())
            errors += list(relative(column(now, "load"), factor * column(start, "load")))
            assert (column(now, "area") == column(start, "area")).all()
    assert len(errors) > 100
    compare("creep: neighbours at a held approach", errors, 1e-12)


@pytest.mark.truth
def test_three_balls(asperity, tmp_path):
    """The last one touches during the hold: shares of the load as the truth's march has them."""
    gaps, radii, load, ratio, tau, hold_time = (0, 0.01, 0.03), (1, 2, 0.5), 0.008, 0.4, 1.0, 3.0
    (elastic, loads), moved = truth.extrapolated(gaps, radii, load, ratio, tau, hold_time,
                                                 steps=200)
    assert moved < 1e-4 * load
    run = held(asperity, tmp_path, solid(ratio, tau, hold_time, points=400),
               {"control": "load", "value": load}, radii=radii, gaps=gaps, modulus=1.0)
    last = [row for row in run.contacts if row["step"] == run.curve[-1]["step"]]
    assert run.curve[0]["contacts"] == "2" and len(last) == 3
    found = {int(row["upper"]): row for row in last}
    compare("creep: loads of three balls, shares",
            [abs(float(found[i + 1]["load"]) - loads[i]) / load for i in range(3)], 2e-6)
    compare("creep: elastic loads of three balls",
            [abs(float(found[i + 1]["elastic_load"]) - elastic[i]) / load for i in range(3)], 2e-6)


@pytest.mark.parametrize("control", ("load", "approach"))
def test_hold_after_a_path(control, asperity, tmp_path):
    """What is held is where the path ended, not its deepest point."""
    values = (0.4, 0.9, 0.5) if control == "load" else (-0.005, -0.009, -0.006)
    for hold, points in product(("load", "approach"), (0, 5)):
        loading = {"control": control, "value": values, "points": points}
        run = held(asperity, tmp_path, solid(0.5, 1.0, 4.0, hold, 10), loading, name="path")
        times = column(run.curve, "time")
        start = int((times == 0).sum()) - 1
        held_rows = run.curve[start:]
        assert len(held_rows) == 10 and start + 1 == (1 + 3 * 5 if points else 3)
        end = -values[-1] if control == "approach" else None
        if hold == "approach":
            end = end or float(held_rows[0]["compression"])
            compare("creep: approach held after a path",
                    relative(column(held_rows, "compression"), [end] * 10), 1e-15)
            compare("creep: load relaxing after a path", relative(
                column(held_rows, "load"),
                float(held_rows[0]["load"]) * relaxed(0.5, 1.0, times[start:])), 1e-13)
        else:
            compare("creep: load held after a path",
                    relative(column(held_rows, "load"), [float(held_rows[0]["load"])] * 10), MET)
        if control == "load":
            assert float(held_rows[0]["load"]) == pytest.approx(0.5, rel=1e-10)


def many_times(ratios, times, at):
    """J(t) E(0) of a solid with several relaxation times, and its integral from 0 to t, by the
    method of Runge and Kutta with 100 steps from one time to the next."""
    shares, times = -np.diff([1, *ratios]), np.array(times)
    state, found = np.array([1.0, 0.0, *shares]), []

    def rate(state):
        rising = (state[2:] / times).sum()
        return np.array([rising, state[0], *(shares * rising - state[2:] / times)])

    for h in np.diff(at, prepend=0) / 100:
        for _ in range(100):
            one = rate(state)
            two = rate(state + h / 2 * one)
            three = rate(state + h / 2 * two)
            state = state + h / 6 * (one + 2 * two + 2 * three + rate(state + h * three))
        found.append(state[:2])
    return np.array(found).T


def test_three_relaxation_times(asperity, tmp_path):
    """A held load after fast loading, also in three states; loading in time at a rate of the load,
    whose elastic load is the integral of the compliance, with errors of second order."""
    ratios, times, end = (0.8, 0.5, 0.2), (0.1, 1.0, 10.0), 6.0
    for points in (20, 3):
        run = held(asperity, tmp_path, solid(ratios, times, end, points=points), name="hold")
        true = 0.75 * LOAD * RADIUS / MODULUS * many_times(
            ratios, times, column(run.curve, "time"))[0]
        compare("creep: three relaxation times, held", relative(
            column(run.curve, "compression"), true**(2 / 3) / RADIUS), 1e-9)
    errors = []
    for points in (0, 40):
        run = held(asperity, tmp_path, solid(ratios, times, 0.0, loading_time=end),
                   {"control": "load", "value": LOAD, "points": points}, name="ramp")
        true = 0.75 * LOAD * RADIUS / MODULUS / end * many_times(
            ratios, times, column(run.curve, "time"))[1]
        assert len(true) == (points or 20) + 1
        errors.append(relative(column(run.curve, "compression")[1:], true[1:]**(2 / 3) / RADIUS))
    compare("creep: three relaxation times, loading", np.concatenate(errors), 5e-3)
    assert errors[1][-1] < 0.3 * errors[0][-1]


def ball_in_time(turns, ratios, times, points, gap=0.0):
    """Loads and squared contact radii of a ball of radius 1 and modulus 1 whose compression passes
    `turns` at a constant rate in 3 units of time, at `points` states between two of them: 4000
    flat punches in 4000 steps (Popov and Hess 2015). The first time down is that of Ting (1966)."""
    ratios, times = np.atleast_1d(ratios), np.atleast_1d(times)
    shares = -np.diff([1, *ratios])
    turns = np.array([0, *turns])
    at = np.concatenate([[0], np.cumsum(np.abs(np.diff(turns)))])
    at *= 3.0 / at[-1]
    rim = np.linspace(0, 1, 4001)**1.5 * turns.max()
    wanted = np.concatenate([np.linspace(one, other, points + 1)[1:] for one, other in
                             zip(at, at[1:])])
    clock = np.unique(np.concatenate([np.linspace(0, 3, 4001), wanted]))
    moved, memory = np.zeros_like(rim), np.zeros((len(times), len(rim)))
    found = []
    for before, now in zip(clock, clock[1:]):
        x = ((now - before) / times)[:, None]
        gain = shares[:, None] * -np.expm1(-x) / x
        past = (np.exp(-x) * memory).sum(0) - gain.sum(0) * moved
        gain_of_all = ratios[-1] + gain.sum(0)
        force = np.maximum(gain_of_all * (np.interp(now, at, turns) - gap - rim) + past, 0)
        new = (force - past) / gain_of_all
        memory = np.exp(-x) * memory + gain * (new - moved)
        moved = new
        if now in wanted:
            radius = np.sqrt(rim)
            found.append((2 * np.trapezoid(force, radius), rim[force > 0].max(initial=0)))
    return np.array(found).T


@pytest.mark.parametrize("ratios, times", [(0.3, 1.0), ((0.7, 0.5, 0.3), (0.1, 1.0, 5.0))])
def test_ball_up_and_down(asperity, tmp_path, ratios, times):
    """Loads and squared radii to 0.1 % of the largest against Ting (1966); the ball leaves
    the surface before it is back. In a second cycle, where the surface has not recovered, against
    flat punches. The contact of a second ball, which touches later, is its own."""
    deepest, points, gap = 0.01, 20, 0.003

    def relaxed_by(t):
        shares = -np.diff([1, *np.atleast_1d(ratios)])
        return np.atleast_1d(ratios)[-1] + sum(
            share * np.exp(-t / of) for share, of in zip(shares, np.atleast_1d(times)))

    effects = {"relaxation_time": times, "relaxed_modulus_ratio": ratios, "loading_time": 3.0,
               "creep": "on"}
    for turns in ((1, 0), (1, 0.4, 1.2, 0)):
        values = deepest * np.array(turns)
        run = held(asperity, tmp_path, effects, path(values, points), radii=(1.0,), modulus=1.0)
        assert "shrink" not in run.stderr
        loads, rims = column(run.curve, "load")[1:], column(run.curve, "area")[1:] / np.pi
        exact = ball_in_time(values, ratios, times, points)
        if turns == (1, 0):
            true = np.array([ting(relaxed_by, deepest, 1.5, time)
                             for time in column(run.curve, "time")[1:]]).T
            assert np.abs(true[0] - exact[0]).max() < 1e-4 * true[0].max()
            exact = true / np.array([[1], [np.pi]])
            assert loads[-2] == 0 and rims[-2] == 0
        compare("creep: loads of a ball up and down",
                np.abs(loads - exact[0]) / exact[0].max(), 1e-3)
        compare("creep: areas of a ball up and down",
                np.abs(rims - exact[1]) / exact[1].max(), 1e-3)
    run = held(asperity, tmp_path, effects, path(values, points), radii=(1.0, 1.0),
               gaps=(0.0, gap), modulus=1.0)
    late = column(run.curve, "load")[1:] - loads
    exact = ball_in_time(values, ratios, times, points, gap)[0]
    compare("creep: loads of a ball that is later", np.abs(late - exact) / exact.max(), 1e-3)


def test_cycle_in_time(asperity, tmp_path):
    """Contacts that shrink do not end a run: every load is met, and the surface has not recovered
    when the load is 0."""
    run = held(asperity, tmp_path, solid(0.3, 1.0, 2.0, points=5, loading_time=6.0),
               {"control": "load", "value": (LOAD, 0.0, LOAD), "points": 5})
    loads, closing = column(run.curve, "load"), column(run.curve, "compression")
    wanted = LOAD * np.concatenate([np.linspace(0, 1, 6), np.linspace(0.8, 0, 5),
                                    np.linspace(0.2, 1, 5), np.ones(4)])
    assert np.abs(loads - wanted).max() < 1e-9 * LOAD
    assert np.allclose(column(run.curve, "time")[:16], np.linspace(0, 6, 16))
    assert closing[10] > 0.3 * closing[5] and float(run.curve[10]["area"]) == 0
    assert "shrink" not in run.stderr


def test_auto_estimates_the_load_lost_in_a_hold(asperity, tmp_path):
    """`auto` asks what a held approach would lose."""
    for hold_time, wanted in ((1e-3, "off"), (1.0, "on"), (0.0, "off")):
        effects = {**solid(0.8, 10.0, hold_time), "creep": "auto"}
        run = held(asperity, tmp_path, effects, name="auto")
        row = run.positions[0]
        assert row["creep"] == wanted, hold_time
        # Relative to the load with creep.
        assert float(row["creep_estimate"]) == pytest.approx(
            1 / relaxed(0.8, 10.0, hold_time) - 1, abs=1e-12)
        assert len(run.curve) == (30 if wanted == "on" else 1)


@pytest.mark.parametrize("hold", ("load", "separation"))
def test_totals_of_a_hold_after_a_ramp(hold, asperity, tmp_path):
    """Creep displacement and load relaxation of the summary are those since the end of loading.
    Load P t/T on a ball and its hold: delta**1.5 = 3/(4 E sqrt(R)) int J dP (Lee and Radok 1960); a
    depth that is held relaxes by the difference of the moduli, from the memory of the ramp."""
    modulus, load, ramp, hold_time, ratio, tau = 1e6, 10.0, 1.0, 5.0, 0.5, 1.0
    (tmp_path / "ball.csv").write_text("x,y,height,radius\n0,0,0.1,1\n")
    (tmp_path / "hold.scene").write_text(
        f"&surfaces upper = 'plane', lower = 'ball.csv' / &material contact_modulus = {modulus} /"
        f"&loading control = 'load', value = {load} / &effects relaxation_time = {tau}, hold = "
        f"'{hold}', relaxed_modulus_ratio = {ratio}, loading_time = {ramp}, "
        f"hold_time = {hold_time} /")
    text = run_program(asperity, "solve", "hold.scene", cwd=tmp_path).stdout

    def grown(time):
        """delta**1.5 over 3/(4 E sqrt(R)); J(t) = 1/r - (1/r - 1) exp(-r t/tau)."""
        late = np.maximum(time - ramp, 0)
        memory = np.exp(-ratio * late / tau) - np.exp(-ratio * time / tau)
        return load / ramp * (np.minimum(time, ramp) / ratio
                              - tau / ratio * (1 / ratio - 1) * memory)

    found = {name: float(number) for name, number in re.findall(
        r"^(creep displacement|load relaxation) +(\S+)", text, re.M)}
    if hold == "load":
        depths = (3 / (4 * modulus) * grown(np.array([ramp, ramp + hold_time]))) ** (2 / 3)
        assert found == {"creep displacement": pytest.approx(depths[1] - depths[0], rel=1e-3)}
    else:
        # P = 4/3 E sqrt(R) int g(t - s) d(delta**1.5), g = r + (1 - r) exp(-t/tau).
        times = np.linspace(0, ramp, 2001)
        middles = times[1:] / 2 + times[:-1] / 2
        loads = [np.sum((ratio + (1 - ratio) * np.exp(-(end - middles) / tau))
                        * np.diff(grown(times))) for end in (ramp, ramp + hold_time)]
        assert found == {"load relaxation": pytest.approx(1 - loads[1] / loads[0], rel=1e-3)}
