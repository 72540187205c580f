"""Adhesion, as `asperity solve` does it, against closed forms and adhesion_truth.py."""

import math

import numpy as np
import pytest
from mpmath import mpf

import adhesion_truth as truth
from ball_scenes import balls, path, work
from effect_runs import DECK
from judge import column, compare, relative, solved
from surfaces_csv import solve, write_csv_scene, write_scene

MODULUS, RADIUS, WORK = 1000.0, 2.0, 0.01
UNIT = math.pi * WORK * RADIUS
LENGTH = (2 * math.pi * WORK * RADIUS**2 / MODULUS) ** (1 / 3)
DEPTH = LENGTH**2 / RADIUS
# Overlaps of JKR, its curve being W = DEPTH (t**4 - t).
SNAP_OFF = -0.75 * 0.25 ** (1 / 3) * DEPTH
AT_PULL_OFF = (0.75 ** (4 / 3) - 0.75 ** (1 / 3)) * DEPTH


def distance(tabor):
    """Equilibrium distance that gives a Tabor parameter."""
    return (RADIUS * WORK**2 / MODULUS**2) ** (1 / 3) / tabor


def adhering(asperity, folder, tabor, closings, points=None, name="ball", work_of_adhesion=WORK,
             contacts=True, **more):
    """Balls with a Tabor parameter, closed as stated."""
    effects = {"adhesion": "on", "work_of_adhesion": work_of_adhesion,
               "equilibrium_distance": distance(tabor)}
    more = {"radii": (RADIUS,), "modulus": MODULUS, **more}
    return solved(asperity, balls(folder, name, effects, path(closings, points), **more),
                  contacts=contacts)


def radius(rows):
    return np.sqrt(column(rows, "area") / math.pi)


def against(name, run, truths, bound):
    """Contact radius, load and pressure of every state."""
    compare(f"adhesion: {name}, contact radius",
            relative(radius(run.curve), [t.contact_radius for t in truths]), bound)
    compare(f"adhesion: {name}, load",
            [abs(float((f - t.load) / max(UNIT, abs(t.load)))) for f, t in
             zip(column(run.curve, "load"), truths)], bound)
    compare(f"adhesion: {name}, pressure",
            relative(column(run.contacts, "maximum_pressure"), [t.pressure for t in truths]),
            10 * bound)


@pytest.mark.filterwarnings("ignore:Descending")
def test_jkr_curve(asperity, tmp_path):
    """Eleven points of a withdrawal, from a deep contact almost to the snap."""
    closings = [*np.array([300, 30, 8, 3, 1, 0.3, 0, -0.1, -0.25, -0.35, -0.45]) * DEPTH]
    run = adhering(asperity, tmp_path, 50, closings)
    truths = [truth.jkr(mpf(MODULUS), mpf(RADIUS), mpf(repr(WORK)), mpf(c)) for c in closings]
    against("JKR", run, truths, 1e-13)
    tabor = relative(column(run.contacts, "tabor_parameter"), [50] * 11)
    compare("adhesion: Tabor parameter", tabor, 1e-14)


def test_jkr_pull_off(asperity, tmp_path):
    """3/2 pi w R, met where the load is least; 5/6 pi w R at the snap of held planes."""
    run = adhering(asperity, tmp_path, 50, (DEPTH, AT_PULL_OFF, SNAP_OFF * (1 - 1e-12),
                                            SNAP_OFF * (1 + 1e-12)))
    load = column(run.curve, "load")
    compare("adhesion: JKR pull-off", abs(load[1] / (-1.5 * UNIT) - 1), 1e-14)
    compare("adhesion: JKR pull-off, column", abs(
        float(run.contacts[0]["pull_off_force"]) / (1.5 * UNIT) - 1), 1e-14)
    # The load goes with the root of the distance to the turn.
    compare("adhesion: JKR at snap-off", abs(load[2] / (-5 / 6 * UNIT) - 1), 1e-5)
    assert run.curve[3]["contacts"] == "0" and load[3] == 0
    fine = adhering(asperity, tmp_path, 50, (DEPTH, SNAP_OFF * 1.1), 2000, name="fine")
    least = column(fine.curve, "load").min()
    assert -1.5 * UNIT * (1 + 1e-13) <= least < -1.5 * UNIT * (1 - 1e-6)


@pytest.mark.truth
@pytest.mark.parametrize("tabor", (0.11, 0.5, 1.0, 4.9))
def test_maugis_curve(tabor, asperity, tmp_path):
    """Between the borders: the curve, across a gap without a contact circle too, and the largest
    pull, which a published fit gives within 2 %."""
    closings = [*np.array([300, 30, 8, 3, 1, 0.5, 0.3, 0.1, 0.05, 0.01, 0, -0.1]) * DEPTH]
    run = adhering(asperity, tmp_path, tabor, closings)
    given = mpf(repr(distance(tabor)))
    modulus, ball, energy = mpf(MODULUS), mpf(RADIUS), mpf(repr(WORK))
    truths = [truth.maugis(modulus, ball, energy, given, mpf(c)) for c in closings]
    if tabor < 0.8:  # the contact circle goes before the curve turns
        gap = 0.9 * float(truth.Z0_RANGE * given)
        run = adhering(asperity, tmp_path, tabor, [*closings, -gap])
        truths.append(truth.gap(modulus, ball, energy, given, mpf(-gap)))
    against(f"Maugis {tabor}", run, truths, 1e-12)
    lam = truth.maugis_units(modulus, ball, energy, given)[0]
    pull = truth.maugis_pull_off(lam)
    shown = float(run.contacts[0]["pull_off_force"]) / UNIT
    # Carpick, Ogletree and Salmeron, J. Colloid Interface Sci. 211 (1999) 395.
    power = float(4.04 * lam**1.4)
    fit = 1.75 - 0.25 * (power - 1) / (power + 1)
    compare("adhesion: published fit of the largest pull", abs(shown / fit - 1), 0.02)
    compare("adhesion: largest pull of Maugis", abs(float(shown / pull - 1)), 1e-9)
    assert 1.5 < shown < 2


def test_dmt_is_hertz_less_a_constant_pull(asperity, tmp_path):
    """2 pi w R at first touch, Hertz less that beyond, and the same way back."""
    reach = 9 * math.sqrt(3) / 16 * distance(0.05)
    closings = np.array([-1.001 * reach, -0.5 * reach, 0, 0.001 * DEPTH, 0.01 * DEPTH,
                         0.1 * DEPTH, 0.5 * DEPTH, DEPTH, 2 * DEPTH, 5 * DEPTH, 20 * DEPTH])
    run = adhering(asperity, tmp_path, 0.05, [*closings, *closings[-2::-1]])
    pressed = np.maximum(closings, 0)
    load = 4 / 3 * MODULUS * np.sqrt(RADIUS) * pressed**1.5 - 2 * UNIT
    load[:2] = 0, -UNIT
    compare("adhesion: DMT load", np.abs(column(run.curve, "load")[:11] - load) / UNIT, 1e-12)
    compare("adhesion: DMT contact radius",
            relative(radius(run.curve)[:11], np.sqrt(RADIUS * pressed)), 1e-13)
    compare("adhesion: DMT pull-off", abs(column(run.curve, "load")[2] / (-2 * UNIT) - 1), 1e-14)
    same = [a["load"] == b["load"] for a, b in zip(run.curve, run.curve[::-1])]
    assert all(same)


def test_a_contact_snaps_in_at_first_touch_and_out_at_the_turn(asperity, tmp_path):
    """A path down and up twice: in at first touch, out at the turn, not elsewhere."""
    near = 1e-12 * DEPTH
    ways = (DEPTH, 0.9 * SNAP_OFF, SNAP_OFF + near, SNAP_OFF - near, SNAP_OFF + near, -near, 0)
    run = adhering(asperity, tmp_path, 50, ways * 2)
    contacts = [row["contacts"] for row in run.curve]
    wanted = ["1", "1", "1", "0", "0", "0", "1"] * 2
    assert contacts == wanted
    compare("adhesion: load at snap-in", abs(
        float(run.curve[6]["load"]) / (-4 / 3 * UNIT) - 1), 1e-14)


def test_no_work_of_adhesion(asperity, tmp_path):
    """Byte for byte without adhesion in the common columns: one ball, and the thesis models."""
    sweep = {"surfaces": {"deck": str(DECK)},
             "motion": {"x_first": 0.1, "x_step": 0.1, "positions": 100},
             "loading": {"control": "approach", "value": (0.3, 0.26, 0.29), "points": 4}}
    choices = {"on": {"adhesion": "on", "work_of_adhesion": 0.0}, "off": {"adhesion": "off"}}
    pairs = [
        [balls(tmp_path, f"ball-{name}", effects, path(np.arange(1, 12) * DEPTH), radii=(RADIUS,),
               modulus=MODULUS) for name, effects in choices.items()],
        [write_scene(tmp_path / f"sweep-{name}.scene", **sweep, effects=effects)
         for name, effects in choices.items()]]
    for scenes in pairs:
        on, without = (solved(asperity, scene) for scene in scenes)
        for kind in ("curve", "positions", "contacts"):
            rows = list(zip(getattr(on, kind), getattr(without, kind), strict=True))
            same = [all(a[name] == b[name] for name in b) for a, b in rows]
            assert same and all(same), f"{scenes[0].name}: {kind} {same.index(False)}"
    # To the limit the solver without effects has its own order of rounding.
    del sweep["loading"]
    on, without = (solved(asperity, write_scene(tmp_path / f"limit-{name}.scene", **sweep,
                                                effects=effects))
                   for name, effects in choices.items())
    for name in ("load", "vertical_load", "area", "separation"):
        compare(f"adhesion: none, {name} at the limit",
                relative(column(on.positions, name), column(without.positions, name)), 2e-15)


def test_load_of_zero(asperity, tmp_path):
    """Without load a JKR contact keeps a**3 = 9 pi w R**2/(2 E), on a path of loads."""
    effects = {"adhesion": "on", "work_of_adhesion": WORK, "equilibrium_distance": distance(50)}
    scene = balls(tmp_path, "loads", effects,
                  {"control": "load", "value": (3.0, 0.0, 1.0), "points": 10}, radii=(RADIUS,),
                  modulus=MODULUS)
    run = solved(asperity, scene)
    loads = column(run.curve, "load")
    asked = np.concatenate([np.linspace(a, b, 11)[1:] for a, b in ((0, 3), (3, 0), (0, 1))])
    some = asked > 0
    compare("adhesion: loads asked for", relative(loads[1:][some], asked[some]), 1e-10)
    compare("adhesion: load of zero", np.abs(loads[1:][~some]), 1e-10)
    cube = 9 * math.pi * WORK * RADIUS**2 / (2 * MODULUS)
    compare("adhesion: contact radius without load",
            abs(radius(run.curve)[20] / cube ** (1 / 3) - 1), 1e-10)


def test_work_of_a_cycle(asperity, tmp_path):
    """The loss of a JKR cycle in closed form; a cycle without a snap returns its work."""
    tiny = 1e-10 * DEPTH
    run = adhering(asperity, tmp_path, 50,
                   (DEPTH, SNAP_OFF + tiny, SNAP_OFF - tiny, -tiny, 0, DEPTH), 1000)
    done = work(run.curve)
    loss = (0.3 + 0.05 * 0.25 ** (1 / 3)) * MODULUS * LENGTH**5 / RADIUS**2
    compare("adhesion: loss of a cycle", abs((done[-1] - done[1000]) / loss - 1), 1e-4)
    closed = adhering(asperity, tmp_path, 50, (DEPTH, 0.99 * SNAP_OFF, DEPTH), 500, name="closed")
    done = work(closed.curve)
    compare("adhesion: cycle without a snap", abs(done[-1] - done[500]) / np.abs(done).max(), 1e-10)


@pytest.mark.parametrize("tabor", (0.05, 0.3, 1.0, 50))
def test_a_cycle_returns_no_more_work(tabor, asperity, tmp_path):
    """Balls of three sizes and heights, pressed and parted again and again."""
    tops = (1.0, 0.2, 3.0, 0.5)
    ways = [v for top in tops for v in (top * DEPTH, -12 * DEPTH)]
    run = adhering(asperity, tmp_path, tabor, ways, 1200, contacts=False, radii=(RADIUS, 1.0, 3.0),
                   gaps=(0.0, 0.3 * DEPTH, 0.1 * DEPTH))
    done, loads = work(run.curve)[::1200], column(run.curve, "load")[::1200]
    assert (loads[2::2] == 0).all() and (column(run.curve, "load") < 0).any()
    # Each cycle after the first begins and ends apart. Without a jump nothing is lost.
    kept = np.diff(done[2::2]) / (UNIT * DEPTH)
    print(f"Tabor {tabor}: kept {kept} pi w R times the depth without load")
    assert (kept >= -1e-10).all()
    assert tabor < 0.1 or (kept > 1e-3).all()


def test_auto_compares_pulls_with_the_load(asperity, tmp_path):
    """`auto` compares the largest pulls with the load, and the area with that of Hertz."""
    effects = {"adhesion": "auto", "work_of_adhesion": WORK, "tolerance": 0.01,
               "equilibrium_distance": distance(50)}
    for share, wanted in ((6e-5, "on"), (3e-5, "off")):
        load = 1.5 * UNIT / share
        run = solved(asperity, balls(tmp_path, f"auto{share}", effects, {
            "control": "load", "value": load}, radii=(RADIUS,), modulus=MODULUS))
        assert run.positions[0]["adhesion"] == wanted
        overlap = float(run.contacts[0]["overlap"])
        # a = L t**2 and overlap = L**2/R (t**4 - t): the largest root.
        root = max(r.real for r in np.roots([1, 0, 0, -1, -overlap / DEPTH]) if abs(r.imag) < 1e-9)
        area = 1 - RADIUS * overlap / (LENGTH**2 * root**4)
        assert area > 10 * share and (area > 0.01) == (wanted == "on")
        # What closes the contact further under the load adds 2/3 of that share of the load.
        estimate = float(run.positions[0]["adhesion_estimate"])
        assert estimate == pytest.approx(area + 2 / 3 * share / (1 - share), rel=1e-6)
        # Area of Hertz at the load over that of JKR, closed form.
        truth = 1 - (1 + 2 * share + 2 * math.sqrt(share + share**2)) ** (-2 / 3)
        assert truth <= estimate <= 1.01 * truth
        assert float(run.positions[0]["load"]) == pytest.approx(load, rel=1e-10)


def jkr_loads(overlaps):
    """Loads of equal balls at overlaps on the stable branch, from L and R as in jkr_adhesion."""
    y = np.asarray(overlaps) / DEPTH
    t = np.maximum(0.25 ** (1 / 3), np.abs(y) ** 0.25) + 1.0
    for _ in range(20):
        t = t - (t**4 - t - y) / (4 * t**3 - 1)
    return MODULUS * LENGTH**3 / RADIUS * (4 / 3 * t**6 - 2 * t**3)


def test_loads_of_many_balls(asperity, tmp_path):
    """Unloaded under a load: each state carries it, and no compression on the way carries less; the
    largest pull is the least load on the way."""
    count = 600
    gaps = np.concatenate([[0.0], np.random.default_rng(3).uniform(0.0, 6 * DEPTH, count - 1)])
    loads = UNIT * np.array([1350, 1050, 450, 150, 0, -45, -90, -105.0])
    effects = {"adhesion": "on", "work_of_adhesion": WORK, "equilibrium_distance": distance(50)}

    found = solved(asperity, balls(tmp_path, "loads", effects, {
        "control": "load", "value": tuple(loads.tolist())}, radii=(RADIUS,) * count, gaps=gaps,
        modulus=MODULUS), contacts=False)
    closings = column(found.curve, "compression")
    for before, now, load in zip(closings, closings[1:], loads[1:]):
        # Contacts on the way: adhering until they have come back beyond their snap-off.
        adhered = gaps <= closings[0]
        ways = np.concatenate([np.linspace(before, now, 300),
                               gaps[adhered] + SNAP_OFF + 1e-9 * DEPTH])
        ways = np.sort(ways[(ways <= before) & (ways >= now)])[::-1]
        sums = np.array([jkr_loads(at - gaps[adhered & (at >= gaps + SNAP_OFF)]).sum()
                         for at in ways])
        assert (sums >= load - 1e-9 * UNIT * count).all()
        compare("adhesion: loads of many balls", abs(sums[-1] - load) / UNIT / count, 1e-9)
    refused = solve(asperity, balls(tmp_path, "more", effects, {
        "control": "load", "value": (1350 * UNIT, -1350 * UNIT)}, radii=(RADIUS,) * count,
        gaps=gaps, modulus=MODULUS), contacts=False)
    ways = np.sort(np.concatenate([np.linspace(0, closings[0], 500), gaps + AT_PULL_OFF,
                                   gaps + SNAP_OFF + 1e-9 * DEPTH]))
    least = min(jkr_loads(at - gaps[adhered & (at >= gaps + SNAP_OFF)]).sum() for at in ways)
    carried = float(refused.stderr.split()[-3])
    assert -least <= carried * (1 + 1e-6) and carried < -least + 2 * UNIT


def dmt_load(upper, lower, separation, modulus, distance, energy):
    """Sum of the printed formulas over all pairs of caps (x, y, height, radius)."""
    reach, load = 9 * math.sqrt(3) / 16 * distance, 0.0
    for xu, yu, hu, ru in upper:
        for xl, yl, hl, rl in lower:
            overlap = ru + rl - math.dist((xu, yu, separation - hu - hl + ru + rl), (xl, yl, 0))
            ball = ru * rl / (ru + rl)
            if overlap > 0:
                load += 4 / 3 * modulus * math.sqrt(ball) * overlap**1.5
            load -= 2 * math.pi * energy * ball * min(1, max(0, 1 + overlap / reach))
    return load


def test_pairs_in_the_range_of_attraction(asperity, tmp_path):
    """Caps that never touch attract from h0 on, inclined pairs too, above first contact too: the
    load at a separation is the sum of the formulas, and does not depend on the path."""
    rng = np.random.default_rng(4)
    far = 3e-4
    upper, lower = ([(3.0 * (k % 5) + 0.8 * u, 3.0 * (k // 5) + 0.8 * v, 0.1 + far * w, 1.0 + w)
                     for k, (u, v, w) in enumerate(rng.random((25, 3)))] for _ in range(2))
    energy = 0.05**1.5 * MODULUS * far**1.5

    def run(name, value):
        return solved(asperity, write_csv_scene(
            tmp_path, upper, lower, name=name, modulus=(2 * MODULUS,) * 2, ratio=(0.0, 0.0),
            loading={"control": "separation", "value": value}, effects={
                "adhesion": "on", "work_of_adhesion": energy, "equilibrium_distance": far}))

    deep = run("deep", 0.19).positions[0]
    touch = float(deep["separation"]) + float(deep["compression"])
    for k, closing in enumerate((-0.9, -0.4, 0.1, 0.7, 2.0, 30.0)):
        value = touch - closing * far
        expected = dmt_load(upper, lower, value, MODULUS, far, energy)
        direct, later = run(f"direct{k}", value), run(f"later{k}", (touch - 40 * far, value))
        compare("adhesion: pairs in the range",
                [abs(float(one.positions[0]["load"]) / expected - 1) for one in (direct, later)],
                1e-9)
        assert direct.positions[0]["contacts"] == later.positions[0]["contacts"] != "0"
    assert float(run("off", touch + 1.1 * far).positions[0]["load"]) == 0


def test_a_maugis_contact_before_it_touches(asperity, tmp_path):
    """A single separation above first contact has the load across the gap, as a path has."""
    gap = 0.9 * float(truth.Z0_RANGE) * distance(0.5)
    expected = truth.gap(mpf(MODULUS), mpf(RADIUS), mpf(repr(WORK)), mpf(repr(distance(0.5))),
                         mpf(-gap)).load
    run = adhering(asperity, tmp_path, 0.5, (-gap,))
    compare("adhesion: Maugis before first contact",
            abs(float(run.positions[0]["load"]) / float(expected) - 1), 1e-9)


def test_a_pull_without_loading(asperity, tmp_path):
    """First contact carries 4/3 pi w R of JKR, a loaded contact 3/2: the message states so."""
    effects = {"adhesion": "on", "work_of_adhesion": WORK, "equilibrium_distance": distance(50)}
    pull = -1.4 * UNIT
    for value, status in ((pull, 1), ((10 * UNIT, pull), 0)):
        done = solve(asperity, balls(tmp_path, f"pull{status}", effects,
                                     {"control": "load", "value": value}, radii=(RADIUS,),
                                     modulus=MODULUS))
        assert done.status == status, done.stderr
        assert status == 0 or "after loading they may carry more" in done.stderr


@pytest.mark.parametrize("control, after", [("load", ()), ("vertical_load", ()),
                                            ("load", (20 * UNIT,))])
def test_loads_near_zero(control, after, asperity, tmp_path):
    """Loads below the rounding error of the forces whose difference they are have the compression
    of a load of 0: were refused as loads that are jumped past, or that surfaces do not carry."""
    effects = {"adhesion": "on", "work_of_adhesion": WORK, "equilibrium_distance": distance(50)}

    def compression(load, gaps):
        done = solve(asperity, balls(tmp_path, "zero", effects,
                                     {"control": control, "value": (*after, load * UNIT)},
                                     radii=(RADIUS,) * len(gaps), gaps=gaps, modulus=MODULUS))
        assert done.status == 0, (load, done.stderr)
        return float(done.positions[0]["compression"])

    for gaps in ((0.0,), (0.0, 0.0), (0.0, 1e-3 * RADIUS)):
        zero = compression(0.0, gaps)
        found = np.array([compression(load, gaps) for load in (1e-10, 1e-15, 1e-30, 1e-300)])
        compare("adhesion: loads near 0", np.abs(found / zero - 1), 1e-9)
