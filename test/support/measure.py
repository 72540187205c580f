"""Runs a hard case and measures its results in units of the last place of a double.

The truth is exact_contact's, evaluated for the numbers as doubles hold them. The unit of an error
is one unit of the last place of the true value. Approach and places are differences of
coordinates: their unit is that of the largest coordinate. Where a case states that coordinates
limit
it, the unit also has the largest change that moving every coordinate by one unit of the largest
coordinate brings, seen in a few trials.
"""

import random
from dataclasses import dataclass, replace
from fractions import Fraction

from exact_contact import TOTALS, Truth, read_deck
from judge import has_result
from mpmath import mp, mpf
from programs import run_program
from surfaces_csv import Solved, exact_csv_scene, solve

# Bits of a double, and the exponent of the least one.
BITS, LEAST = 53, -1074
TRIALS = 4
# Of a condition number: changes so small that even a contact of 1e-100 is only bent by them.
CHANGE, CONDITION_DIGITS = Fraction(1, 10 ** 240), 300
PLACES = ("separation", "x", "y", "x_displacement", "y_displacement")
CONTACT = ("load", "vertical_load", "area", "projected_area", "slope", "average_pressure",
           "penetration", "overlap", "x", "y")


@dataclass
class Outcome:
    """What a run came to: the message of a refusal, or the worst error and where it is."""

    refused: str = ""
    worst: float = 0.0
    where: str = ""

    def see(self, error, where):
        if not error <= self.worst:
            self.worst, self.where = float(error), where


def binary_order(value):
    """e with 2**(e-1) <= |value| < 2**e."""
    order = value.numerator.bit_length() - value.denominator.bit_length()
    while abs(value) >= Fraction(2) ** order:
        order += 1
    while abs(value) < Fraction(2) ** (order - 1):
        order -= 1
    return order


def spacing(value):
    """One unit of the last place at the size of a fraction other than zero."""
    return Fraction(2) ** max(binary_order(value) - BITS, LEAST)


def held(value):
    """The nearest double."""
    if value == 0 or value is None:
        return value
    unit = spacing(value)
    return round(value / unit) * unit


def held_scene(scene):
    """The scene with every number as a double holds it."""
    def hold(values):
        return tuple(map(held, values))

    def hold_surface(surface):
        return replace(surface, asperities=[hold(a) for a in surface.asperities],
                       modulus=held(surface.modulus), ratio=held(surface.ratio),
                       slope=hold(surface.slope), rotation=held(surface.rotation),
                       mirror=held(surface.mirror))

    return replace(scene, upper=hold_surface(scene.upper), lower=hold_surface(scene.lower),
                   first=hold(scene.first), step=hold(scene.step),
                   value=held(scene.value), limit=held(scene.limit))


def largest_coordinate(scene):
    """The largest number that places, displacements and heights are computed from."""
    sizes = [abs(s.mirror) for s in (scene.lower,) if s.mirror is not None]
    for surface in (scene.upper, scene.lower):
        for x, y, height, radius in surface.asperities:
            tilt = abs(x * surface.slope[0]) + abs(y * surface.slope[1])
            sizes += [abs(x), abs(y), abs(height), radius, tilt]
    sizes += [abs(f + m * s) for f, s in zip(scene.first, scene.step)
              for m in (0, scene.positions - 1)]
    return max(sizes)


def moved(scene, step, seed):
    """The scene with every place, height and displacement moved by one step, up or down."""
    rng = random.Random(seed)

    def shift(value):
        return value + rng.choice((-1, 1)) * step

    def move(surface):
        return replace(surface, asperities=[(shift(x), shift(y), shift(h), r)
                                            for x, y, h, r in surface.asperities])

    value = shift(scene.value) if scene.control == "approach" else scene.value
    return replace(scene, upper=move(scene.upper), lower=move(scene.lower),
                   first=tuple(map(shift, scene.first)), value=value)


def changed(scene, share, seed):
    """The scene with every number changed by a share of it, up or down: places, heights and
    displacements by that share of the largest."""
    rng = random.Random(seed)
    scene = moved(scene, share * largest_coordinate(scene), seed)

    def change(value):
        return None if value is None else value * (1 + rng.choice((-1, 1)) * share)

    def change_surface(surface):
        return replace(surface, asperities=[(x, y, h, change(r))
                                            for x, y, h, r in surface.asperities],
                       modulus=change(surface.modulus))

    value = scene.value if scene.control == "approach" else change(scene.value)
    return replace(scene, upper=change_surface(scene.upper), lower=change_surface(scene.lower),
                   value=value, limit=change(scene.limit))


def condition(scene, positions):
    """How many times larger a relative change of the totals is than the changes of the numbers of
    the scene that bring it: the worst of a few trials."""
    with mp.workdps(CONDITION_DIGITS):
        truth = Truth(scene, CONDITION_DIGITS)
        others = [Truth(changed(scene, CHANGE, seed), CONDITION_DIGITS) for seed in range(TRIALS)]
        worst = mpf(0)
        for m in positions:
            true = truth.state(m)
            if true is None or not true.contacts or not true.load:
                continue
            for other in (o.state(m) for o in others):
                for name in TOTALS:
                    size = getattr(true, name)
                    if other is not None and size:
                        worst = max(worst, abs(getattr(other, name) / size - 1))
        return worst * CHANGE.denominator


class Yardstick:
    """The truth of one scene, and the unit of each error."""

    def __init__(self, scene, coordinates, digits):
        scene = held_scene(scene)
        self.digits = digits
        self.place = spacing(largest_coordinate(scene))
        self.truth = Truth(scene, digits)
        self.others = [Truth(moved(scene, self.place, seed), digits)
                       for seed in range(TRIALS if coordinates else 0)]

    def state(self, m):
        self.now = self.truth.state(m)
        self.trials = [t for t in (other.state(m) for other in self.others) if t is not None]
        return self.now

    def error(self, found, name, true, others):
        """How many units a found number is off."""
        off = abs(mpf(float(found)) - true)
        if off == 0:
            return 0.0
        if name in PLACES:
            unit = mpf(self.place.numerator) / self.place.denominator
        elif true == 0:
            unit = mpf(0)
        else:
            unit = spacing(Fraction(*map(int, mp_fraction(true))))
            unit = mpf(unit.numerator) / unit.denominator
        unit += max((abs(other - true) for other in others), default=0)
        return off / unit if unit else mp.inf


def mp_fraction(value):
    """An mpf as numerator and denominator, cut to what a spacing needs."""
    sign, mantissa, exponent, _ = value._mpf_
    return ((-1) ** sign * mantissa << max(exponent, 0), 1 << max(-exponent, 0))


def run(asperity, path, folder, positions=()):
    """Solve: a result, with a number in every cell but that of an unknown error, or a refusal."""
    solved = solve_some(asperity, path, folder, positions) if positions else \
        solve(asperity, path, folder=folder)
    has_result(solved, refusals=(1, 2))
    assert all(cell or name == "error_estimate" for row in (*solved.positions, *solved.contacts)
               for name, cell in row.items())
    return solved


def solve_some(asperity, path, folder, positions):
    """Solve a long sweep and keep the rows of a few positions."""
    file = folder / f"{path.name}.csv"
    done = run_program(asperity, "solve", path, "--positions", file, status=None)
    with open(file, encoding="ascii") as lines:
        names = next(lines).rstrip().split(",")
        rows = [dict(zip(names, line.rstrip().split(","), strict=True))
                for m, line in enumerate(lines, 1) if m in positions]
    file.unlink()
    return Solved(done.returncode, done.stdout, done.stderr, rows, [], [], path)


def compare(solved, yardstick, positions):
    """The worst error over positions and their contacts."""
    outcome = Outcome()
    by_position = {}
    for row in solved.contacts:
        by_position.setdefault(int(row["position"]), []).append(row)
    with mp.workdps(yardstick.digits):
        for row in solved.positions:
            m = int(row["position"])
            if m not in positions:
                continue
            state = yardstick.state(m)
            for name, true in zip(("x_displacement", "y_displacement"),
                                  yardstick.truth.displacement(m)):
                outcome.see(yardstick.error(row[name], name, true, ()), f"{name} at position {m}")
            if state is None or not state.contacts:
                assert int(row["contacts"]) == 0 and float(row["load"]) == 0, f"position {m}"
                continue
            contacts = compare_contacts(by_position.get(m, []), yardstick, outcome, m)
            if solved.contacts:
                assert int(row["contacts"]) == contacts, f"position {m}: contacts"
            for name in ("separation", *TOTALS):
                outcome.see(yardstick.error(row[name], name, getattr(state, name),
                                            [getattr(t, name) for t in yardstick.trials]),
                            f"{name} at position {m}")
    return outcome


def compare_contacts(rows, yardstick, outcome, m):
    """Each contact against the truth; one that touches within the unit may be missed or added."""
    true = yardstick.now.contacts
    trials = [t.contacts for t in yardstick.trials]
    found = {(int(row["upper"]), int(row["lower"])): row for row in rows}
    assert len(found) == len(rows), f"position {m}: a contact twice"
    sure = {pair for pair in true if all(pair in t for t in trials)}
    maybe = set(true).union(*trials)
    if rows:
        assert sure <= set(found) <= maybe, f"position {m}: {sorted(found)} for {sorted(true)}"
    for pair, row in found.items():
        if pair not in true:
            continue
        others = [t[pair] for t in trials if pair in t]
        for name in CONTACT:
            outcome.see(yardstick.error(row[name], name, true[pair][name],
                                        [o[name] for o in others]),
                        f"{name} of {pair} at position {m}")
    return len(found)


def scene_of(case):
    return exact_csv_scene(case.upper, case.lower, case.modulus, case.ratio, **case.groups)


def positions_of(case, scene):
    """Those of a case that are compared."""
    return case.positions or range(1, scene.positions + 1)


def positions_of_deck(scene):
    pairs = len(scene.upper.asperities) * len(scene.lower.asperities)
    return range(1, 101, 11 if pairs < 50 else 99)


def measure(asperity, case, path, folder):
    """Run one scene case."""
    solved = run(asperity, path, folder, case.positions)
    if solved.status:
        return Outcome(refused=reason(solved, path))
    scene = scene_of(case)
    yardstick = Yardstick(scene, case.coordinates, case.digits)
    return compare(solved, yardstick, positions_of(case, scene))


def measure_deck(asperity, path, folder):
    """Run one deck in the present-day solver; some of its positions."""
    solved = run(asperity, path, folder)
    if solved.status:
        return Outcome(refused=reason(solved, path))
    scene = read_deck(path)
    yardstick = Yardstick(scene, True, 60)
    return compare(solved, yardstick, positions_of_deck(scene))


def reason(solved, path):
    """The message of a refusal, without the file."""
    return solved.stderr.strip().replace(f"{path}: ", "")
