"""The original's marching algorithm, restated with 60 digits.

Written from what the program computes (sections I to IV), with the list of NU least separations and
the state that it carries from one position to the next. Rounding is left out: what remains of the
faults is what the algorithm itself does.
"""

from bisect import insort

from exact_contact import THESIS_LIMIT, THESIS_SLOPES, exact
from mpmath import mp, mpf

STEPS, PLACES = 25, 37
NAMES = ("steps", "approach", "contacts", "load", "area", "projected_area", "limit_reached")


class LostMeaningError(Exception):
    """The original went on with numbers it had not got: position and fault."""


def centres(model, angle, slopes, mirror_at, level):
    """Centres in inches become centimetres."""
    for x, y, z in model["asperities"]:
        x, y, z = (mpf(repr(c)) for c in (x, y, z))
        u = x * mp.cos(angle) - y * mp.sin(angle)
        v = x * mp.sin(angle) + y * mp.cos(angle)
        v = v if mirror_at is None else mirror_at - v
        rise = exact(slopes[0]) * u + exact(slopes[1]) * v
        yield tuple(c * mpf("2.54") for c in (u, v, level(z) + rise))


def restate(upper, lower, width=3.455, angles=(0.0, 0.0), displacement=(0.0, 0.0)):
    """One tuple (NAMES) a position. The displacement shifts only what is printed (fault 11)."""
    del displacement
    with mp.workdps(60):
        inch, psi = mpf("2.54"), mpf("0.6894")
        radii = [mpf(repr(m["radius"])) for m in (upper, lower)]
        over = list(centres(upper, mpf(repr(angles[0])), THESIS_SLOPES[0], None,
                            lambda z: mpf("0.5") + radii[0] - z))
        under = list(centres(lower, mpf(repr(angles[1])), THESIS_SLOPES[1], mpf(repr(width)),
                             lambda z: z - radii[1]))
        ru, rl = (inch * r for r in radii)
        compliance = sum((1 - mpf(repr(m["ratio"])) ** 2) / (psi * mpf(repr(m["modulus"])))
                         for m in (upper, lower))
        tallest = inch * max(mpf(repr(m["height_max"])) for m in (upper, lower))
        reach = 2 * mp.sqrt(ru * tallest)
        return list(march(over, under, ru, rl, 1 / compliance, reach))


def march(over, under, ru, rl, modulus, reach):
    share, radius, limit = ru / (ru + rl), ru * rl / (ru + rl), exact(THESIS_LIMIT)
    approach, lowered = mpf("1.27"), mpf(0)
    for m in range(1, 101):
        shift = m * mpf("0.1")
        near = []
        for j, (x, y, z) in enumerate(over):
            for k, (u, v, w) in enumerate(under):
                plan = mp.sqrt((x + shift - u) ** 2 + (y - v) ** 2)
                if plan >= reach:
                    continue
                squares = ru ** 2 - (plan * share) ** 2, rl ** 2 - (plan * (1 - share)) ** 2
                if min(squares) < 0:
                    raise LostMeaningError(m, 7)
                gap = z - lowered - w - sum(map(mp.sqrt, squares))
                if gap < 100:
                    insort(near, (gap, j, k, plan))
        least = near[:len(over)]
        if not least:
            raise LostMeaningError(m, 6)
        end = mpf(0)
        decrement = least[0][0]
        for step in range(1, STEPS + 1):
            end += decrement
            touching = [c for c in least if c[0] <= end]
            loads, areas, projected = [], [], []
            for gap, j, k, plan in touching:
                if gap == end:
                    continue
                rise = over[j][2] - lowered - end - under[k][2]
                overlap = ru + rl - mp.sqrt(plan ** 2 + rise ** 2)
                areas.append(mpf("3.1416") * overlap * radius)
                projected.append(areas[-1] / mp.sqrt(1 + (plan / rise) ** 2))
                loads.append(mpf(4) / 3 * modulus * mp.sqrt(radius) * overlap ** mpf("1.5"))
            reached = any(load >= limit for load in loads)
            if reached or step == STEPS:
                break
            if len(touching) == max(len(over), PLACES):
                raise LostMeaningError(m, 5)
            following = least[len(touching)][0] - end if len(touching) < len(least) else mpf(100)
            decrement = min(following, mpf("0.001"))
        lowered += end
        approach -= end
        yield (step, approach, len(touching), mp.fsum(loads), mp.fsum(areas), mp.fsum(projected),
               reached)
