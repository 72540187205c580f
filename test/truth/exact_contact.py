"""The truth for `asperity solve`: two surfaces of spheres, evaluated with many digits.

Written from the geometry of two spheres under a vertical approach and from Hertz's equations.
Input is exact (fractions of the decimal text). Doubles only leave out pairs that are far from
touching; every number and every decision near one is made with `digits` digits.
"""

from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise

import numpy as np
from mpmath import mp, mpf

INCH, PSI = Fraction("2.54"), Fraction("0.6894")
THESIS_LIMIT = 65 * Fraction("9.8") / Fraction("2.205")
THESIS_SLOPES = ((Fraction("0.004"), Fraction("-0.00058")),
                 (Fraction("-0.00067"), Fraction("-0.00045")))
TOTALS = ("load", "vertical_load", "area", "projected_area")


@dataclass
class Surface:
    """Asperities (x, y, height, radius) as they lie in the file, and what holds for all."""

    asperities: list
    modulus: Fraction
    ratio: Fraction
    slope: tuple = (Fraction(0), Fraction(0))
    rotation: Fraction = Fraction(0)
    mirror: Fraction | None = None


@dataclass
class Scene:
    """What a scene file states; numbers are fractions."""

    upper: Surface
    lower: Surface
    first: tuple = (Fraction(0), Fraction(0))
    step: tuple = (Fraction(0), Fraction(0))
    positions: int = 1
    control: str = "limit"
    value: Fraction | None = None
    criterion: str | None = "load"
    limit: Fraction | None = None
    is_deck: bool = False


@dataclass
class State:
    """The end of one position: its contacts by (upper, lower), totals, and the last events."""

    separation: mpf
    compression: mpf
    contacts: dict
    load: mpf = field(default_factory=mpf)
    vertical_load: mpf = field(default_factory=mpf)
    area: mpf = field(default_factory=mpf)
    projected_area: mpf = field(default_factory=mpf)


def card_number(card, first, width, decimals):
    """A FORTRAN IV field: implied decimal point, blanks behind the first digit are zeros."""
    text = card.ljust(80)[first - 1:first - 1 + width].lstrip().replace(" ", "0")
    if not text:
        return Fraction(0)
    return Fraction(text) if "." in text else Fraction(int(text), 10 ** decimals)


def read_deck(path):
    """A card deck as a scene in cm and N: the sweep of the thesis."""
    cards = path.read_text().splitlines()
    count, surfaces = [], []
    for card in cards[1:3]:
        count.append(int(card_number(card, 1, 5, 0)))
        surfaces.append(Surface([], PSI * card_number(card, 16, 10, 0), card_number(card, 26, 5, 3),
                                THESIS_SLOPES[len(surfaces)]))
    surfaces[1].mirror = INCH * card_number(cards[2], 41, 7, 4)
    surfaces[0].rotation = card_number(cards[3], 1, 8, 4)
    surfaces[1].rotation = card_number(cards[3], 9, 8, 4)
    shift = INCH * card_number(cards[3], 17, 7, 3), INCH * card_number(cards[3], 24, 7, 3)
    begin = 4
    for number, surface, header in zip(count, surfaces, cards[1:3]):
        radius = INCH * card_number(header, 6, 5, 3)
        surface.asperities = [
            (INCH * card_number(card, 1, 6, 3), INCH * card_number(card, 7, 6, 3),
             INCH * card_number(card, 13, 7, 4), radius)
            for card in cards[begin:begin + number]]
        begin += number
    tenth = Fraction("0.1")
    return Scene(*surfaces, first=(tenth + shift[0], shift[1]), step=(tenth, Fraction(0)),
                 positions=100, limit=THESIS_LIMIT, is_deck=True)


def exact(value):
    """A fraction as a number of the working precision."""
    return mpf(value.numerator) / value.denominator


def root(value):
    return mp.sqrt(value)


class Pair:
    """Two spheres, one above the other. At the approach A their centres are A + k apart in z."""

    def __init__(self, names, upper, lower, shift, modulus):
        self.names, self.modulus = names, modulus
        self.upper = upper[0] + shift[0], upper[1] + shift[1]
        self.lower = lower[0], lower[1]
        self.plan = root((self.upper[0] - self.lower[0]) ** 2
                         + (self.upper[1] - self.lower[1]) ** 2)
        self.sum = upper[3] + lower[3]
        self.share = upper[3] / self.sum
        self.radius = upper[3] * lower[3] / self.sum
        self.k = upper[2] - lower[2]
        if self.plan < self.sum:
            self.touch = root(self.sum ** 2 - self.plan ** 2) - self.k

    def overlap(self, approach):
        return self.sum - root(self.plan ** 2 + (approach + self.k) ** 2)

    def load(self, overlap):
        return mpf(4) / 3 * self.modulus * root(self.radius) * overlap ** mpf("1.5")

    def overlap_at_limit(self, criterion, limit):
        """Hertz: load, pressures and overlap of a contact between elastic spheres."""
        if criterion == "load":
            return (3 * limit / (4 * self.modulus * root(self.radius))) ** (mpf(2) / 3)
        if criterion == "greenwood_williamson":
            return self.radius * (limit / self.modulus) ** 2
        # Maximum pressure 2 E a/(pi R), a**2 = W R; the average is two thirds of it.
        most = limit * (mpf("1.5") if criterion == "pressure" else mpf("2.76"))
        return (most * mp.pi / (2 * self.modulus)) ** 2 * self.radius

    def approach_at_limit(self, criterion, limit):
        """None when the centres come level before."""
        distance = self.sum - self.overlap_at_limit(criterion, limit)
        if distance <= self.plan:
            return None
        return root(distance ** 2 - self.plan ** 2) - self.k

    def contact(self, approach):
        overlap = max(self.overlap(approach), mpf(0))
        rise = approach + self.k
        cosine = rise / root(self.plan ** 2 + rise ** 2)
        load, area = self.load(overlap), mp.pi * overlap * self.radius
        return {"penetration": self.touch - approach, "overlap": overlap,
                "load": load, "vertical_load": load * cosine,
                "area": area, "projected_area": area * cosine, "slope": self.plan / rise,
                "average_pressure": load / area if area else mpf(0),
                "x": self.upper[0] + self.share * (self.lower[0] - self.upper[0]),
                "y": self.upper[1] + self.share * (self.lower[1] - self.upper[1])}


class Truth:
    """A scene placed once; `state(m)` is the end of position m."""

    def __init__(self, scene, digits=50):
        self.scene, self.digits = scene, digits
        with mp.workdps(digits):
            compliance = sum((1 - exact(s.ratio) ** 2) / exact(s.modulus)
                             for s in (scene.upper, scene.lower))
            self.modulus = 1 / compliance
            self.upper = self.place(scene.upper, True)
            self.lower = self.place(scene.lower, False)
            self.tallest = exact(max(a[2] for s in (scene.upper, scene.lower)
                                     for a in s.asperities))
            self.limit = None if scene.limit is None else exact(scene.limit)
        self.upper_doubles = np.array(self.upper, dtype=float)
        self.lower_doubles = np.array(self.lower, dtype=float)

    @staticmethod
    def place(surface, is_upper):
        """Centres (x, y, z) at zero approach and radii."""
        cosine, sine = mp.cos(exact(surface.rotation)), mp.sin(exact(surface.rotation))
        slope = [exact(s) for s in surface.slope]
        placed = []
        for x, y, height, radius in (map(exact, a) for a in surface.asperities):
            u, v = x * cosine - y * sine, x * sine + y * cosine
            if surface.mirror is not None:
                v = exact(surface.mirror) - v
            z = radius - height if is_upper else height - radius
            placed.append((u, v, z + u * slope[0] + v * slope[1], radius))
        return placed

    def displacement(self, m):
        return [exact(first + (m - 1) * step)
                for first, step in zip(self.scene.first, self.scene.step)]

    def size(self):
        """The largest coordinate of a centre, at any position; z at the historic gap or less."""
        shifts = [abs(float(first + m * step)) for first, step in zip(self.scene.first,
                  self.scene.step) for m in (0, self.scene.positions - 1)]
        return max(np.abs(self.upper_doubles[:, :3]).max() + max(shifts),
                   np.abs(self.lower_doubles[:, :3]).max())

    def near_pairs(self, m):
        """Pairs near enough in plan, left out those that surely do not touch before the end."""
        shift = self.displacement(m)
        x, y, z, r = (self.upper_doubles.T[i][:, None] for i in range(4))
        u, v, w, q = (self.lower_doubles.T[i][None, :] for i in range(4))
        s = r + q
        d2 = (x + float(shift[0]) - u) ** 2 + (y + float(shift[1]) - v) ** 2
        margin = 1e-9 * self.size() ** 2
        maybe = d2 < s * s
        if self.scene.is_deck and self.scene.control == "limit" and self.tallest > 0:
            # The caps of a deck end at their reference plane: a position without a pair near enough
            # to touch before a summit reaches the other plane (Appendix 5 of the thesis) has no
            # contact. Heights in files may count from anywhere.
            reach = 2 * s * float(self.tallest)
            if not np.any(maybe & (d2 < reach - margin)) and not any(
                    self.is_near(j, k, shift)
                    for j, k in np.argwhere(maybe & (d2 < reach + margin))):
                return []
        # Pairs that graze the sum of radii only touch when far beyond any load of interest, but
        # they are pairs: the margin keeps them out of reach of rounding.
        touch = np.sqrt(np.where(maybe, s * s - d2, 0.0)) - (z - w)
        end = self.end_in_doubles(maybe, touch, s, d2, z - w, r * q / s)
        maybe &= touch > end - 1e-6 * self.size()
        pairs = []
        for j, k in np.argwhere(maybe):
            pair = Pair((int(j) + 1, int(k) + 1), self.upper[j], self.lower[k], shift,
                        self.modulus)
            if pair.plan < pair.sum:
                pairs.append(pair)
        return pairs

    def is_near(self, j, k, shift):
        """Whether a pair can touch before a summit reaches the other plane."""
        pair = Pair((), self.upper[j], self.lower[k], shift, self.modulus)
        return pair.plan ** 2 < 2 * pair.sum * self.tallest and pair.plan < pair.sum

    def end_in_doubles(self, maybe, touch, s, d2, k, radius):
        """About the approach at the end."""
        if not maybe.any():
            return 0.0
        scene, modulus = self.scene, float(self.modulus)
        if scene.control == "approach":
            return float(scene.value)
        touch, s, d2, k, radius = (np.broadcast_to(a, maybe.shape)[maybe]
                                   for a in (touch, s, d2, k, radius))
        if scene.control == "limit":
            stiff = 4 * modulus * np.sqrt(radius) / 3
            limit = float(self.limit)
            overlap = {"load": (limit / stiff) ** (2 / 3),
                       "pressure": radius * (0.75 * np.pi * limit / modulus) ** 2,
                       "greenwood_williamson": radius * (limit / modulus) ** 2,
                       "hardy": radius * (1.38 * np.pi * limit / modulus) ** 2}[scene.criterion]
            left = s - overlap
            good = left ** 2 > d2
            return np.max(np.sqrt(left[good] ** 2 - d2[good]) - k[good])
        low, high = np.max(-k), np.max(touch)
        for _ in range(100):
            middle = (low + high) / 2
            overlap = np.maximum(s - np.sqrt(d2 + (middle + k) ** 2), 0.0)
            if (4 / 3 * modulus * np.sqrt(radius) * overlap ** 1.5).sum() > float(scene.value):
                low = middle
            else:
                high = middle
        return low

    def end(self, pairs):
        """The approach at which the position ends."""
        scene = self.scene
        if scene.control == "approach":
            return exact(scene.value)
        if scene.control == "limit":
            ends = [p.approach_at_limit(scene.criterion, self.limit) for p in pairs]
            return max(e for e in ends if e is not None)
        # Compressions at which the load is too small and too large, brought together.
        target, touch = exact(scene.value), max(p.touch for p in pairs)
        small, large = mpf(0), min(touch + p.k for p in pairs)
        while large - small > large * mpf(10) ** (-45):
            if small == 0:
                middle = large / 2 if large > mpf("1e-3") else large * large
            else:
                middle = (small + large) / 2 if large < 4 * small else root(small * large)
            overlaps = [(p, p.overlap(touch - middle)) for p in pairs if p.touch > touch - middle]
            if sum(p.load(w) for p, w in overlaps) < target:
                small = middle
            else:
                large = middle
        return touch - large

    def state(self, m):
        """The end of position m, or None when no pair is near enough."""
        with mp.workdps(self.digits):
            pairs = self.near_pairs(m)
            if not pairs:
                return None
            approach, touch = self.end(pairs), max(p.touch for p in pairs)
            contacts = {p.names: p.contact(approach) for p in pairs if p.touch >= approach}
            state = State(approach, touch - approach, contacts)
            for name in TOTALS:
                setattr(state, name, mp.fsum(c[name] for c in contacts.values()))
            return state

    def touches(self, m):
        """Approaches at which contacts begin, the first one first."""
        with mp.workdps(self.digits):
            return sorted((p.touch for p in self.near_pairs(m)), reverse=True)


def slope_of_logs(x, y):
    """Least squares through (log x, log y)."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def local_slopes(x, y):
    """Slopes of the pieces between neighbouring points of a log-log curve."""
    points = list(zip(np.log(x), np.log(y)))
    return [(b[1] - a[1]) / (b[0] - a[0]) for a, b in pairwise(points)]
