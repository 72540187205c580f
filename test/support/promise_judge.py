"""Judges `solve --accuracy E`: promise against truth over random scenes of all kinds.

Kinds: contacts without effects (50 digits), dense neighbours, up to 100 contacts or more (the
archived solutions on grids), flow, adhesion, cycles of adhesion, friction and creep on one pair
(laws evaluated apart), maps (conjugate gradients in numpy). A promise is kept when loads, areas and
separations (over the compression where effects are on) are within it and the truth's own error, or
when it is refused.
"""

import random
import re
from dataclasses import dataclass

import numpy as np

import made_maps
from adhesion_truth import jkr, maugis
from ball_scenes import balls, path
from dense_figures import truths
from dense_scenes import dense_scenes
from exact_contact import Truth
from friction_truth import closed_form
from judge import ask
from map_press_truth import press, rough
from mpmath import mpf, sqrt, workdps
from plastic_truth import STEEL
from surfaces_csv import exact_csv_scene, write_csv_scene, write_scene

TOTALS = ("load", "vertical_load", "area", "separation")


@dataclass
class Verdict:
    """One scene asked for one accuracy."""

    kind: str
    scene: int
    asked: float
    status: int = 0
    error: float = 0.0    # the largest of the totals
    bound: float = 0.0    # of the truth, for that total
    promised: float = 0.0  # what the run states of itself: a bound, or an estimate
    message: str = ""
    proposed: "Verdict | None" = None  # of the accuracy that a refusal proposes

    @property
    def kept(self):
        if self.status:
            return self.status == 1 and self.message != "" and (
                self.proposed is None or self.proposed.status == 0 and self.proposed.kept)
        return self.error <= self.asked + self.bound and self.promised <= self.asked * 1.06


def alone(rng, folder):
    """Hertz' contact, one at a position, as neighbours would count; some are far from the origin,
    some steep."""
    offset = rng.choice((0.0, 0.0, 0.0, 1e3, 1e6))
    def surface():
        return [(offset + rng.uniform(0, 1), offset + rng.uniform(0, 1), rng.uniform(0.05, 0.2),
                 rng.uniform(0.5, 2))]
    upper, lower = surface(), surface()
    loading = rng.choice(({"control": "load", "value": float(f"{10 ** rng.uniform(-1, 3):.3g}")},
                          {"control": "approach", "value": rng.choice((0.05, 0.1, 0.2))},
                          {"control": "limit"}))
    groups = {"loading": loading, "motion": {"x_step": 0.25, "positions": rng.randint(1, 3)}}
    if loading["control"] == "limit":
        groups["limit"] = {"criterion": "load", "value": 50.0}
    scene = write_csv_scene(folder, upper, lower, **groups)
    truth = Truth(exact_csv_scene(upper, lower, **groups))

    def errors(rows):
        for m, row in enumerate(rows, 1):
            state = truth.state(m)
            yield 0.0, 0.0
            for name in TOTALS if state else ():
                want = getattr(state, name)
                if want:
                    yield float(abs((float(row[name]) - want) / want)), 2.0 ** -53
    return scene, errors


def dense(rng, folder):
    """Neighbours: `auto`, `coupled` or `boundary` in the scene, at its approach or its load."""
    return neighbours(rng, folder, lambda contacts: contacts <= 100)


def many(rng, folder):
    """The same of more contacts than that."""
    return neighbours(rng, folder, lambda contacts: contacts > 100)


def neighbours(rng, folder, has_so_many):
    scene = rng.choice([s for s in dense_scenes()
                        if has_so_many(int(truths()[s.name]["contacts"]))])
    want, pairs = truths()[scene.name], scene.pairs()
    # The truth has the loads of paraboloids, whose share of p/(10 R) depends on the penetration p.
    doubt = float(want["load_error"]) + float(
        (pairs.law()[0] * pairs.penetration / pairs.radius).sum() / pairs.law()[0].sum()) / 10
    by_load = rng.random() < 0.5
    loading = {"control": "load", "value": float(want["normal_load"])} if by_load else None
    written = scene.write(folder, loading, interaction=rng.choice(("auto", "coupled", "boundary")))

    def errors(rows):
        row, = rows
        if by_load:
            yield (abs(float(row["separation"]) - scene.approach) / float(want["closing"]),
                   doubt)
        else:
            yield abs(float(row["vertical_load"]) / float(want["load"]) - 1), doubt
        yield abs(float(row["area"]) / float(want["area"]) - 1), float(want["area_error"])
    return written, errors


def flow(rng, folder):
    x = round(10 ** rng.uniform(0.8, 2.0), 3)
    closing = x * STEEL.critical_overlap
    scene = balls(folder, "ball", {"plasticity": rng.choice(("on", "auto")),
                                   "plastic_yield_stress": 0.9115},
                  path([closing]), modulus=200 / (1 - 0.32 ** 2), ratio=0.32)

    def errors(rows):
        load = float(STEEL.critical_load * STEEL.published(str(x)))
        area = float(STEEL.critical_area * STEEL.area(str(x)))
        yield abs(float(rows[0]["load"]) / load - 1), 1e-12
        yield abs(float(rows[0]["area"]) / area - 1), 1e-12
    return scene, errors


def adhesion(rng, folder):
    """The theory is that of docs/theory/adhesion.md for the Tabor parameter, DMT aside."""
    work = 10 ** rng.uniform(-6, -4)
    tabor = 10 ** rng.uniform(-0.9, 1.5)
    distance = (work ** 2 / tabor ** 3) ** (1 / 3)
    closing = 10 ** rng.uniform(-3, -2)
    scene = balls(folder, "ball", {"adhesion": rng.choice(("on", "auto")),
                                   "work_of_adhesion": work, "equilibrium_distance": distance},
                  path([closing]))

    def errors(rows):
        given = mpf(1), mpf(1), mpf(work), mpf(closing)
        want = jkr(*given) if tabor > 5 else maugis(*given[:3], mpf(distance), given[3])
        yield float(abs(float(rows[0]["load"]) / want.load - 1)), 1e-12
        yield float(abs(float(rows[0]["area"]) / (np.pi * want.contact_radius ** 2) - 1)), 1e-12
    return scene, errors


def cycle(rng, folder):
    """Adhesion on a way down and up again, by the branch that holds on; some beyond the snap."""
    work = 10 ** rng.uniform(-6, -4)
    distance = (work ** 2 / 10 ** rng.uniform(3 * 0.8, 3 * 1.5)) ** (1 / 3)  # Tabor's above 5
    depth = (2 * np.pi * work) ** (2 / 3)  # compressions of JKR: depth (t**4 - t)
    snap = -0.75 * 0.25 ** (1 / 3) * depth
    last = rng.choice((rng.uniform(0.01, 3) * depth, rng.uniform(0.05, 0.95) * snap, 1.2 * snap))
    scene = balls(folder, "ball", {"adhesion": "on", "work_of_adhesion": work,
                                   "equilibrium_distance": distance},
                  path([rng.uniform(3, 30) * depth, last]))

    def errors(rows):
        row, = rows
        if last < snap:
            yield abs(float(row["load"])) / work, 0.0
            yield abs(float(row["area"])), 0.0
            return
        want = jkr(mpf(1), mpf(1), mpf(work), mpf(last))
        # A load may be next to nothing: then over the pull.
        scale = max(abs(want.load), 1.5 * np.pi * work)
        yield float(abs(float(row["load"]) - want.load) / scale), 1e-12
        yield float(abs(float(row["area"]) / (np.pi * want.contact_radius ** 2) - 1)), 1e-12
    return scene, errors


def friction(rng, folder):
    """A pair aside, under friction: normal and vertical load at an approach."""
    radii = [round(rng.uniform(0.5, 2), 6) for _ in range(2)]
    distance = round(rng.uniform(0.05, 0.6) * sum(radii), 6)
    depth = 10 ** rng.uniform(-4, -2) * min(radii)
    coefficient = round(rng.uniform(0.02, 0.8), 6)
    with workdps(30):
        touch = sqrt((mpf(radii[0]) + mpf(radii[1])) ** 2 - mpf(distance) ** 2) \
            + 2 * mpf(0.1) - mpf(radii[0]) - mpf(radii[1])
        approach = float(touch - depth)
        want = closed_form(mpf(radii[0]), mpf(radii[1]), mpf(distance), touch - mpf(approach),
                           *(mpf(repr(v)) for v in (2.0e5, 0.3, 1.0e5, 0.25)), mpf(coefficient),
                           digits=30)
    scene = write_csv_scene(folder, [(distance, 0.0, 0.1, radii[0])], [(0.0, 0.0, 0.1, radii[1])],
                            loading={"control": "approach", "value": approach},
                            effects={"friction": "on", "friction_coefficient": coefficient})

    def errors(rows):
        yield float(abs(float(rows[0]["load"]) / want.normal - 1)), 1e-12
        yield float(abs(float(rows[0]["vertical_load"]) / want.vertical - 1)), 1e-12
        yield float(abs(float(rows[0]["area"]) / (np.pi * want.contact_radius ** 2) - 1)), 1e-12
    return scene, errors


def creep(rng, folder):
    """A held ball: Lee and Radok's a**3 = 3/4 P R J(t)/E under a load, else the load relaxes as
    the modulus (the standard solid)."""
    ratio, tau = round(rng.uniform(0.05, 0.95), 4), round(10 ** rng.uniform(0, 3), 3)
    time = round(tau * 10 ** rng.uniform(-1, 1.5), 3)
    by_load = rng.random() < 0.5
    value = 10 ** rng.uniform(-3, -1.5)
    scene = balls(folder, "ball", {"creep": "on", "relaxed_modulus_ratio": ratio,
                                   "relaxation_time": tau, "hold_time": time, "hold_points": 5,
                                   "hold": "load" if by_load else "approach"},
                  {"control": "load", "value": value ** 1.5} if by_load else path([value]))

    def errors(rows):
        row, = rows
        if by_load:
            compliance = 1 / ratio - (1 / ratio - 1) * np.exp(-ratio * time / tau)
            square = (0.75 * value ** 1.5 * compliance) ** (2 / 3)
            yield abs(-float(row["separation"]) / square - 1), 1e-12
            yield abs(float(row["area"]) / (np.pi * square) - 1), 1e-12
        else:
            relaxed = ratio + (1 - ratio) * np.exp(-time / tau)
            yield abs(float(row["load"]) / (4 / 3 * value ** 1.5 * relaxed) - 1), 1e-12
            yield abs(float(row["area"]) / (np.pi * value) - 1), 1e-12
    return scene, errors


def measured(rng, folder):
    """A map's pixels: the level of the flat at a load."""
    n = rng.choice((32, 48))
    height = 1e-3 * rough(n, shortest=rng.choice((4, 8)), seed=rng.randrange(10 ** 6))
    y, x = np.mgrid[0:n, 0:n]
    plane = np.c_[x.ravel(), y.ravel(), np.ones(n * n)]
    level = height - (plane @ np.linalg.lstsq(plane, height.ravel(), rcond=None)[0]).reshape(n, n)
    load = 10 ** rng.uniform(-3, -1.5)
    made_maps.write_bytes(folder / "map.sdf", height)
    scene = write_scene(folder / "map.scene", surfaces={"upper": "plane", "lower": "map.sdf"},
                        material={"contact_modulus": 1.0},
                        loading={"control": "load", "value": load},
                        effects={"interaction": rng.choice(("auto", "boundary"))})

    def errors(rows):
        want = press(level, (1.0, 1.0), 1.0, load)[0]
        yield abs(float(rows[0]["separation"]) - want) / (level.max() - want), 1e-9
    return scene, errors


KINDS = {"alone": alone, "dense": dense, "many": many, "flow": flow, "adhesion": adhesion,
         "cycle": cycle, "friction": friction, "creep": creep, "map": measured}

def judge_promise(exe, kind, number, asked):
    """One scene by its kind and number, the same in every run; a refusal that suggests another
    accuracy is solved with that."""
    rng, errors = random.Random(f"promise {kind} {number}"), None

    def write(folder):
        nonlocal errors
        scene, errors = KINDS[kind](rng, folder)
        return scene

    # Of a map the load alone, or its compression.
    of = () if kind == "map" else ("--of", "all")
    answer = ask(exe, write, "--accuracy", asked, *of, contacts=False)
    verdict = Verdict(kind, number, float(asked), answer.status, message=answer.message)
    if answer.status == 0:
        said = re.search(r"fastest method .*(?:error bound|estimated error)\s*(\S+)", answer.stdout)
        verdict.promised = float(said[1])
        verdict.error, verdict.bound = max(errors(answer.positions),
                                           key=lambda pair: pair[0] - pair[1])
    if proposal := re.search(r"set --accuracy ([-+.\dE]+)", verdict.message):
        verdict.proposed = judge_promise(exe, kind, number, proposal[1])
    return verdict
