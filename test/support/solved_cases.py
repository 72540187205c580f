"""Scenes that `coupled` must solve: random, packed and stepped ones by seeds, and rough summits.

Solved is: status 0, sums that are those of the contacts, and contacts that carry what they
penetrate, or nothing where they do not.

Random: 2 to 5000 contacts, from .1 to 30 % of the area, heights from one level to widely spread,
equal and mixed radii (to 1:30), at random, in heaps, in packed lattices and with coincident caps,
under an approach or a load. Packed: 9 to 300 equal caps, .02 to .5 of a radius apart, on a lattice
or in a heap, level or nearly, so lightly pressed that they cover 1 to 30 % of the area, or so
deeply that circles are wider than caps are apart. Stepped: caps of which some stand on blunter
ones, with nearly the same axis.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np

from judge import Figure, ask, is_met, missed, number
from surfaces_csv import write_csv_scene

MODULUS, RATIO = 275760.0, 0.42
COMBINED = MODULUS / (2 * (1 - RATIO ** 2))
SPHERE = 1e6
MOST_CAPS = 20_000


@dataclass
class Case:
    """Caps under a sphere so large that it is a flat."""

    caps: np.ndarray    # x, y, height above the flat's level of first touch, radius
    loading: dict

    def write(self, folder, mode):
        """The scene; what the sphere rises by away from its middle is added to the heights."""
        caps = self.caps.copy()
        caps[:, :2] -= (caps[:, :2].max(0) + caps[:, :2].min(0)) / 2
        square, total = (caps[:, :2] ** 2).sum(1), SPHERE + caps[:, 3]
        caps[:, 2] += square / (total + np.sqrt(total ** 2 - square))
        return write_csv_scene(folder, [(0.0, 0.0, 0.0, SPHERE)], caps, name="case",
                               modulus=(MODULUS,) * 2, ratio=(RATIO,) * 2,
                               loading=self.loading, effects={"interaction": mode})


# ---------------------------------------------------------------- random scenes

def heights_of(rng, contacts):
    """Heights below first touch, as many as touch at the compression 1, and the rest."""
    kind = ("level", "within", "rough", "rough", "wide")[int(5 * rng.random())]
    if kind == "level":
        return np.zeros(contacts)
    if kind == "within":
        below = 10 ** rng.uniform(-3, 0) * rng.random(contacts)
        return below - below.min()
    # Of so many caps that more stay open; the compression is where the number touches.
    most = max(1.5, min(100.0 if kind == "wide" else 10.0, MOST_CAPS / contacts))
    count = int(contacts * 10 ** rng.uniform(np.log10(1.5), np.log10(most))) + 1
    below = np.sort(-rng.standard_normal(count))
    below -= below[0]
    closing = (below[contacts - 1] + below[contacts]) / 2
    return below / closing


def places_of(rng, count, width):
    """In a square of this width."""
    kind = ("strewn", "strewn", "strewn", "heaps", "square", "hexagonal",
            "coincident")[int(7 * rng.random())]
    if kind in ("square", "hexagonal"):
        n = int(np.ceil(np.sqrt(count)))
        i, j = (v.ravel()[:count] for v in np.indices((n, n)))
        places = np.stack([i + 0.5 * (j % 2), np.sqrt(0.75) * j], 1) if kind == "hexagonal" else \
            np.stack([i, j], 1).astype(float)
        places += (rng.random() < 0.5) * 0.1 * rng.standard_normal((count, 2))
        return width / n * places
    places = width * rng.random((count, 2))
    if kind == "heaps":
        heaps = width * rng.random((max(1, count // 20), 2))
        near = 0.3 * width / np.sqrt(len(heaps))
        places = heaps[rng.integers(len(heaps), size=count)] + near * rng.standard_normal((count,
                                                                                           2))
    if kind == "coincident":
        # Some exactly, some within a rounding or a hundredth of where they would touch.
        twins = rng.integers(count, size=max(1, count // 10))
        apart = np.array([0, 1e-12, 1e-8, 1e-3])[rng.integers(4, size=len(twins))]
        places[rng.integers(count, size=len(twins))] = \
            places[twins] + width / np.sqrt(count) * apart[:, None]
    return places


def random_case(seed):
    """The scene of a seed."""
    rng = np.random.default_rng([13, seed])
    contacts = int(2 * 2500 ** (rng.random() ** 2))
    below = heights_of(rng, contacts)
    count = len(below)
    below = rng.permutation(below)
    radii = np.ones(count)
    if rng.random() < 0.5:
        radii = 30 ** -rng.uniform(0, rng.random(), count)
    closing = 10 ** rng.uniform(-5, -2.3)
    lone = np.pi * radii * closing * np.maximum(1 - below, 0)
    # Together they cover less than each alone, the more so the closer they are.
    share = 10 ** rng.uniform(np.log10(0.002), np.log10(0.45))
    area = lone.sum() / share
    caps = np.column_stack([places_of(rng, count, np.sqrt(area)), -closing * below, radii])
    load = (4 / 3 * COMBINED * np.sqrt(radii) * (closing * np.maximum(1 - below, 0)) ** 1.5).sum()
    loading = {"control": "approach", "value": -closing}
    if rng.random() < 0.5:
        loading = {"control": "load", "value": float(load * rng.uniform(0.1, 0.7))}
    return Case(caps, loading)


# ---------------------------------------------------------------- packed scenes

def packed_case(seed):
    """The scene of a seed."""
    rng = np.random.default_rng([26, seed])
    count = int(9 * (300 / 9) ** rng.random())
    apart = 0.02 * 25 ** rng.random()
    kind = ("square", "hexagonal", "heap")[rng.integers(3)]
    side = int(np.ceil(np.sqrt(count)))
    if kind == "heap":
        places = side * rng.random((count, 2))
    else:
        i, j = (v.ravel()[:count].astype(float) for v in np.indices((side, side)))
        places = np.stack([i, j], 1) if kind == "square" else \
            np.stack([i + 0.5 * (j % 2), np.sqrt(0.75) * j], 1)
    is_deep = rng.integers(2)
    closing = 10 ** rng.uniform(-2, np.log10(0.3)) * apart ** 2 / np.pi
    if is_deep:
        closing = 10 ** rng.uniform(-4, -1.5)
    below = np.zeros(count)
    if rng.integers(2):
        below = 10 ** rng.uniform(-4, 0) * rng.random(count)
        below -= below.min()
    loading = {"control": "approach", "value": -closing}
    if rng.random() < 0.5:
        # A heap that stands alone carries no more than one cap as blunt as it.
        lone = 4 / 3 * COMBINED * closing ** 1.5
        borne = min((np.maximum(1 - below, 0) ** 1.5).sum(),
                    max(1.0, side * apart / closing ** 0.5))
        loading = {"control": "load", "value": float(lone * borne * rng.uniform(0.1, 0.7))}
    return Case(np.column_stack([apart * places, -closing * below, np.ones(count)]), loading)


# ---------------------------------------------------------------- sharp caps on blunt ones

def stepped_case(seed):
    """The scene of a seed: caps of which some stand on blunter ones with nearly the same axis."""
    rng = np.random.default_rng([77, seed])
    count = int(2 * 1000 ** rng.random())
    closing = 10 ** rng.uniform(-5, -2.3)
    below = rng.integers(2) * rng.random(count) * 10 ** rng.uniform(-2, 0)
    share = 10 ** rng.uniform(-2.5, -0.6)
    lone = np.maximum(1 - below, 0)
    width = np.sqrt(np.pi * closing * lone.sum() / share)
    if rng.integers(3) == 2:
        side = int(np.ceil(np.sqrt(count)))
        i, j = (v.ravel()[:count] for v in np.indices((side, side)))
        places = width / side * np.stack([i, j], 1)
    else:
        places = width * rng.random((count, 2))
    caps = np.column_stack([places, -closing * below, np.ones(count)])
    on_one = rng.random(count) < rng.random()
    blunt = on_one.sum()
    radius = 10 ** rng.uniform(0.1, rng.uniform(0.3, 3), blunt)
    aside = np.array([0, 0, 1e-9, 1e-6, 1e-3, 0.03, 0.3])[rng.integers(7, size=blunt)]
    aside = np.sqrt(closing) * aside[:, None] * rng.standard_normal((blunt, 2))
    lower = closing * rng.uniform(0, 1, blunt) * 10 ** -rng.uniform(0, 1, blunt)
    caps = np.vstack([caps, np.column_stack([places[on_one] + aside, caps[on_one, 2] - lower,
                                             radius])])
    loading = {"control": "approach", "value": -closing}
    if rng.random() < 0.5:
        load = 4 / 3 * COMBINED * (closing ** 1.5 * lone ** 1.5).sum()
        loading = {"control": "load", "value": float(load * rng.uniform(0.1, 0.7))}
    return Case(caps, loading)


# ---------------------------------------------------------------- summits of a rough surface

def rough_surface(n=256, hurst=0.8, seed=2):
    """Heights of a self-affine surface, rough at all lengths from n pixels down to two."""
    rng = np.random.default_rng(seed)
    k = np.fft.fftfreq(n) * n
    k = np.hypot(k[:, None], k[None])
    size = np.where(k > 0, np.maximum(k, 1) ** -(1 + hurst), 0) * (k <= n / 2)
    heights = np.fft.ifft2(np.fft.fft2(rng.standard_normal((n, n))) * size).real
    slope = np.sqrt(2) * np.diff(heights, axis=0).std()
    return 0.1 * heights / slope


def summits(heights):
    """Pixels higher than their eight neighbours; radius: of both curvatures' geometric mean, which
    is less than the other, so that caps of ridges are blunter."""
    inner = heights[1:-1, 1:-1]
    n, m = heights.shape
    top = np.ones(inner.shape, bool)
    for i, j in np.ndindex(3, 3):
        if (i, j) != (1, 1):
            top &= inner > heights[i:n - 2 + i, j:m - 2 + j]
    along = (2 * inner - heights[2:, 1:-1] - heights[:-2, 1:-1])[top]
    across = (2 * inner - heights[1:-1, 2:] - heights[1:-1, :-2])[top]
    x, y = np.nonzero(top)
    return np.column_stack([x, y, inner[top], 1 / np.sqrt(along * across)])


def rough_case(share=0.2):
    """Many summits that would touch open others. The load is that of lone contacts that cover a
    share of the area: together they need more compression for it."""
    caps = summits(rough_surface())
    area = np.ptp(caps[:, 0]) * np.ptp(caps[:, 1])
    caps[:, 2] -= caps[:, 2].max()
    low, high = 0.0, float(-caps[:, 2].min())
    for _ in range(60):
        closing = (low + high) / 2
        deep = np.maximum(closing + caps[:, 2], 0)
        low, high = (closing, high) if np.pi * (caps[:, 3] * deep).sum() < share * area else \
            (low, closing)
    load = float((4 / 3 * COMBINED * np.sqrt(caps[:, 3]) * deep ** 1.5).sum())
    return Case(caps, {"control": "load", "value": load})


# Makers of scenes by their seed.
OF_SEEDS = {"random": random_case, "packed": packed_case, "stepped": stepped_case}


# ---------------------------------------------------------------- what solved is

def run(exe, mode, case):
    """Solve a case: the answer, with the steps that it took and what is wrong with it."""
    answer = ask(exe, partial(case.write, mode=mode), timeout=60)
    answer.steps = float("nan")
    for row in answer.positions:
        answer.steps = number(row, "interaction_iterations")
        if fault := fault_of(case, row, answer.contacts):
            answer.status, answer.stderr = WRONG, fault
    return answer


# Status of a result that is not what it states; relative error of a load by its penetration.
WRONG, OF_LAW = -2, 1e-6


def fault_of(case, position, contacts):
    """What is wrong with the sums of the contacts, or with one of them: "" when nothing is.

    A loaded contact carries what its penetration, alone and less what it is lowered by, states;
    what carries nothing does not penetrate. No contact is lowered where `auto` leaves the
    interaction off.
    """
    names = ("vertical_load", "projected_area", "alone_load", "lowered")
    if position["interaction"] == "off":
        contacts = [row | {"lowered": 0} for row in contacts]
    load, area, alone, lowered = (np.array([float(row[n]) for row in contacts]) for n in names)
    sums = [Figure(name, number(position, name), values.sum(), scale=abs(values).sum())
            for name, values in (("vertical_load", load), ("projected_area", area))]
    if wrong := missed(sums, 1e-9):
        return f"sums of the contacts: {wrong}"
    if load.min(initial=0) < 0:
        return f"a contact bears {load.min()}"
    radius = case.caps[[int(row["lower"]) - 1 for row in contacts], 3]
    stiff = 4 / 3 * COMBINED * np.sqrt(1 / (1 / radius + 1 / SPHERE))
    deep = (alone / stiff) ** (2 / 3) - lowered
    borne = stiff * np.maximum(deep, 0) ** 1.5
    wrong = ~is_met(borne - load, OF_LAW * load.max(initial=0))
    return f"{wrong.sum()} contacts do not bear what they penetrate" if wrong.any() else ""
