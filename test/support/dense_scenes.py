"""Dense scenes of 2 to 200 contacts, made by rule: the same bytes on every machine.

A family is a kind of closeness: pairs, triples, three in a line, rings, chains, small caps on the
flank of a large one, lattices, clumps, two clusters that see each other, steep pairs, many
contacts. All but the steep ones are caps under one huge sphere. Places and heights are rounded to
12 decimals, so that a last digit of a library's sine does not matter.

    python test/support/dense_scenes.py FOLDER      writes them all
"""

import random
import sys
import zlib
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from surfaces_csv import write_csv_scene, write_plane_scene

MODULUS, RATIO = 1000.0, 0.3
COMBINED = MODULUS / (2 * (1 - RATIO ** 2))
TOP = 0.1  # approach of the first touch of the scenes that are placed by gaps


@dataclass(frozen=True)
class Pairs:
    """Pairs that overlap without deformation: spheres in plan, and compression of their first
    touch."""

    upper: np.ndarray    # x, y
    upper_radius: np.ndarray
    lower: np.ndarray
    lower_radius: np.ndarray
    gap: np.ndarray
    closing: float

    @property
    def penetration(self):
        return self.closing - self.gap

    @property
    def sum(self):
        return self.upper_radius + self.lower_radius

    @property
    def plan(self):
        return np.hypot(*(self.lower - self.upper).T)

    @property
    def rise(self):
        """Between the centres at first touch."""
        return np.sqrt((self.sum - self.plan) * (self.sum + self.plan))

    @property
    def radius(self):
        return self.upper_radius * self.lower_radius / self.sum

    @property
    def place(self):
        share = (self.upper_radius / self.sum)[:, None]
        return self.upper + share * (self.lower - self.upper)

    def law(self):
        """Of Hertz' contacts along the lines of centres: vertical load, normal load and area."""
        p, rise = self.penetration, self.rise
        # The overlap of the spheres, by its conjugate: s - sqrt(s^2 - (2 rise - p) p).
        lost = (2 * rise - p) * p
        overlap = lost / (self.sum + np.sqrt(self.sum ** 2 - lost))
        cosine = (rise - p) / (self.sum - overlap)
        load = 4 / 3 * COMBINED * np.sqrt(self.radius) * overlap ** 1.5
        return load * cosine, load, np.pi * self.radius * overlap


@dataclass(frozen=True)
class Dense:
    """A scene under a given approach; asperities are (x, y, height, radius)."""

    name: str
    family: str
    upper: tuple
    lower: tuple
    approach: float

    def pairs(self):
        """The pairs that overlap, the one that touches first first."""
        u, v = np.array(self.upper), np.array(self.lower)
        i, j = (k.ravel() for k in np.indices((len(u), len(v))))
        total, apart = u[i, 3] + v[j, 3], v[j, :2] - u[i, :2]
        square = (apart ** 2).sum(1)
        near = square < total ** 2
        i, j, total, square = i[near], j[near], total[near], square[near]
        touch = u[i, 2] + v[j, 2] - square / (total + np.sqrt(total ** 2 - square))
        gap = touch.max() - touch
        closing = touch.max() - self.approach
        order = [k for k in np.argsort(gap, kind="stable") if gap[k] < closing]
        i, j = i[order], j[order]
        return Pairs(u[i, :2], u[i, 3], v[j, :2], v[j, 3], gap[order], float(closing))

    def checksum(self):
        """Of the numbers of the scene: which scene a truth belongs to."""
        text = repr((self.upper, self.lower, self.approach))
        return f"{zlib.crc32(text.encode('ascii')):08x}"

    def write(self, folder, loading=None, **effects):
        """The scene's files; at its approach unless `loading` states else."""
        groups = {"effects": effects} if effects else {}
        return write_csv_scene(
            folder, self.upper, self.lower, name=self.name, modulus=(MODULUS,) * 2,
            ratio=(RATIO,) * 2,
            loading=loading or {"control": "approach", "value": self.approach}, **groups)


def rounded(*columns):
    """Rows of plain numbers with 12 decimals."""
    columns = np.broadcast_arrays(*[np.asarray(c, float) for c in columns])
    return tuple(tuple(round(float(v), 12) for v in row) for row in zip(*columns))


def caps(name, family, places, radii, gaps, closing, sphere=1e5):
    """Caps that a huge sphere touches at the compressions `gaps`; the centre of all is its
    middle."""
    places = np.round(np.asarray(places, float) - np.mean(places, axis=0), 12)
    radii = np.round(np.broadcast_to(np.asarray(radii, float), len(places)), 12)
    total, square = sphere + radii, (places ** 2).sum(1)
    # A cap is lower than twice its radius.
    top = min(TOP, float(radii.min()))
    heights = top - np.asarray(gaps) + square / (total + np.sqrt(total ** 2 - square))
    return Dense(name, family, ((0.0, 0.0, 0.0, sphere),),
                 rounded(places[:, 0], places[:, 1], heights, radii), round(top - closing, 12))


def depth_of(rng):
    """A compression for caps of radius 1: from 3e-5 to 5e-3."""
    return 10 ** rng.uniform(-4.5, -2.3)


def sphere_of(rng):
    return 10.0 ** (4 + int(3 * rng.random()))


def two(rng, distance, ratio, lower, depth=None):
    """Places, radii, gaps and compression of a pair; distance in the larger radius of contact."""
    c = depth or depth_of(rng)
    d, angle = distance * np.sqrt(c), 2 * np.pi * rng.random()
    return (np.array([[0, 0], [d * np.cos(angle), d * np.sin(angle)]]), [1, 1 / ratio],
            [0, lower * c], c)


def pairs(rng, count):
    for k in range(count):
        distance = 0.3 * (4 / 0.3) ** (k / (count - 1))
        lower = 0.0 if k % 3 == 0 else 0.6 * rng.random()
        yield *two(rng, distance, 1.0, lower), sphere_of(rng)


def unlike_pairs(rng, count):
    """Radii to 1:30, from one inside the other's circle to well apart."""
    for k in range(count):
        ratio = 30 ** ((k + 1) / count)
        distance = rng.uniform(0.3, 2.2)
        # On the flank the small cap must stand out of the large one.
        lower = min(0.5, distance ** 2 / 2) * rng.random()
        yield *two(rng, distance, ratio, lower), sphere_of(rng)


def coincident(rng, count):
    """From .01 to .3 of a contact radius apart."""
    for k in range(count):
        distance = 0.01 * 30 ** (k / (count - 1))
        ratio = (1.0, 1.0, 1.5, 4.0)[k % 4]
        lower = (0.0, 0.05, 0.02, 0.1)[k % 4] * rng.random() * distance
        yield *two(rng, distance, ratio, lower), sphere_of(rng)


def triples(rng, count):
    for k in range(count):
        c = depth_of(rng)
        places = rng.uniform(-1, 1, (3, 2)) * (0.5 + 2 * (k / count)) * np.sqrt(c)
        radii = 1.0 if k % 2 else 10 ** rng.uniform(-0.7, 0.3, 3)
        yield places, radii, c * np.append(0, 0.5 * rng.random(2)), c, sphere_of(rng)


def rings(rng, count):
    for k in range(count):
        c, n = depth_of(rng), 4 + int(20 * rng.random() ** 2)
        spacing = rng.uniform(0.8, 2.4) * np.sqrt(c)
        angle = 2 * np.pi * (np.arange(n) / n + rng.random())
        places = spacing / (2 * np.sin(np.pi / n)) * np.stack([np.cos(angle), np.sin(angle)], 1)
        gaps = 0.15 * c * rng.random(n)
        if k % 2:
            places, gaps = np.vstack([places, [0, 0]]), np.append(gaps, 0.3 * c * rng.random())
        yield places, 1.0, gaps, c, sphere_of(rng)


def chains(rng, count):
    for k in range(count):
        c, n = depth_of(rng), 3 + int(22 * rng.random() ** 2)
        spacing = rng.uniform(0.7, 2.4) * np.sqrt(c)
        x = spacing * np.arange(n)
        wave = rng.uniform(0, 1.5) * spacing * np.sin(2 * np.pi * np.arange(n) / 7)
        radii = 1.0 if k % 3 else 10 ** rng.uniform(-0.6, 0.0, n)
        yield np.stack([x, wave], 1), radii, 0.25 * c * rng.random(n), c, sphere_of(rng)


def flanks(rng, count):
    """Small caps on the slope of a large one; some hardly stand out, some are hidden."""
    for k in range(count):
        c, n = depth_of(rng), 1 + int(7 * rng.random() ** 2)
        distance = rng.uniform(0.35, 1.5, n)
        angle = 2 * np.pi * rng.random(n)
        ratio = rng.uniform(3, 30, n)
        gap = np.minimum(distance ** 2 / 2 * rng.uniform(0.55, 1.04, n), 0.95)
        places = np.sqrt(c) * distance[:, None] * np.stack([np.cos(angle), np.sin(angle)], 1)
        yield (np.vstack([[0, 0], places]), np.append(1, 1 / ratio), c * np.append(0, gap), c,
               sphere_of(rng))


def lattices(rng, count):
    for k in range(count):
        c, n = depth_of(rng), (2, 3, 4, 5, 6, 7, 8, 9, 10, 12)[k % 10]
        spacing = rng.uniform(0.9, 2.6) * np.sqrt(c)
        i, j = (v.ravel() for v in np.indices((n, n)))
        places = np.stack([i + 0.5 * (j % 2), np.sqrt(0.75) * j], 1) if k % 2 else \
            np.stack([i, j], 1)
        yield (spacing * places, 1.0, (k % 4 > 0) * 0.2 * c * rng.random(n * n), c,
               sphere_of(rng))


def strewn(rng, n, c, cover, mixed, spread):
    """Caps at random in a disc; `cover`: the share of it that lone circles would cover."""
    radii = 10 ** rng.uniform(-mixed, 0, n)
    gaps = c * spread * rng.random(n)
    gaps -= gaps.min()
    area = np.pi * (radii * np.maximum(c - gaps, 0)).sum()
    angle, out = 2 * np.pi * rng.random(n), np.sqrt(area / (np.pi * cover) * rng.random(n))
    return out[:, None] * np.stack([np.cos(angle), np.sin(angle)], 1), radii, gaps


def clumps(rng, count):
    for k in range(count):
        c, n = depth_of(rng), 4 + int(46 * rng.random() ** 2)
        mixed = (0, 0.4, 0, 0.9, 0, 1.47)[k % 6]
        yield (*strewn(rng, n, c, rng.uniform(0.08, 0.6), mixed, rng.uniform(0, 1.1)), c,
               sphere_of(rng))


def clusters(rng, count):
    """Two clumps, three to six of their radii apart."""
    for _ in range(count):
        c, parts = depth_of(rng), []
        for _ in range(2):
            n = 3 + int(8 * rng.random())
            parts.append(strewn(rng, n, c, rng.uniform(0.25, 0.7), 0.3, 0.6))
        reach = max(np.hypot(*p[0].T).max() for p in parts)
        parts[1] = (parts[1][0] + [reach * rng.uniform(2, 3.5), 0], *parts[1][1:])
        places, radii, gaps = (np.concatenate(v) for v in zip(*parts))
        yield places, radii, gaps - gaps.min(), c, sphere_of(rng)


def many(rng, count):
    for k in range(count):
        c, n = depth_of(rng), 80 + int(121 * rng.random())
        yield (*strewn(rng, n, c, rng.uniform(0.08, 0.3), 0.5 * (k % 2), rng.uniform(0.1, 0.9)),
               c, sphere_of(rng))


def in_line(rng, count):
    """Three in a line, .02 to .4 of a contact radius apart; some stand out more than others."""
    for k in range(count):
        c = depth_of(rng)
        apart = 0.02 * 20 ** (k / (count - 1)) * np.sqrt(c) * np.array([-1, 0, rng.uniform(0.3, 1)])
        angle = 2 * np.pi * rng.random()
        gaps = c * (0, 1e-3, 0.01, 0.05)[k % 4] * rng.random(3)
        yield (apart[:, None] * [np.cos(angle), np.sin(angle)], 1.0, gaps - gaps.min(), c,
               sphere_of(rng))


def steep(rng, count):
    """Spheres on spheres of their own size, offset in plan: slopes up to .5."""
    for k in range(count):
        c, slope = depth_of(rng), 0.5 * (k + 1) / count
        n = 2 + int(5 * rng.random() ** 2)
        upper_radius = rng.uniform(0.7, 1.5)
        radii = rng.uniform(0.7, 1.5, n)
        reach = np.sqrt(0.5 * c) * rng.uniform(0.5, 2.2)
        out = upper_radius * slope / np.hypot(1, slope)
        # Places of first touch, from the upper centre: on one side, or (two) on both sides.
        places = np.array([out, 0]) + reach * rng.uniform(-1, 1, (n, 2))
        if k % 4 == 3:
            places[1] *= -1
        yield (f"steep_{k + 1:03d}", "steep",
               *steep_surfaces(places, upper_radius, radii, c * 0.4 * rng.random(n)), c)


def steep_surfaces(places, upper_radius, radii, gaps):
    """One upper sphere, and lower ones that it touches at given places and compressions."""
    gaps = gaps - gaps.min()
    radii = np.round(radii, 12)
    upper_radius = round(float(upper_radius), 12)
    total = upper_radius + radii
    plan = np.round(places * (total / upper_radius)[:, None], 12)
    square = (plan ** 2).sum(1)
    heights = TOP - gaps + square / (total + np.sqrt(total ** 2 - square))
    return (((0.0, 0.0, 0.0, upper_radius),), rounded(plan[:, 0], plan[:, 1], heights, radii))


FAMILIES = ((pairs, 36, 11), (unlike_pairs, 36, 12), (coincident, 24, 13), (triples, 36, 14),
            (rings, 28, 15), (chains, 28, 16), (flanks, 44, 17), (lattices, 20, 18),
            (clumps, 60, 19), (clusters, 20, 20), (many, 12, 21))
# After the steep ones, so that those before keep their places.
LATER = ((in_line, 12, 23),)


@dataclass(frozen=True)
class Rough:
    """Caps under a plane, 26 a unit of area, of radius 1.27, at a compression or under a load."""

    number: int
    seed: int
    compression: float
    load: float = None

    @property
    def name(self):
        return f"rough_{self.number}_{self.load or self.compression:g}"

    @cache
    def caps(self):
        """x, y, height, radius: places at random, heights normal, .127 and .03, within limits."""
        rng, side = random.Random(self.seed), np.sqrt(self.number / 26)
        return tuple((float(f"{rng.uniform(0, side):.7g}"), float(f"{rng.uniform(0, side):.7g}"),
                      float(f"{min(.22, max(.03, rng.gauss(.127, .03))):.7g}"), 1.27)
                     for _ in range(self.number))

    def write(self, folder, by_default=False, **effects):
        """The scene's files."""
        loading = {"control": "load", "value": self.load} if self.load else \
            {"control": "approach",
             "value": round(max(cap[2] for cap in self.caps()) - self.compression, 12)}
        return write_plane_scene(folder, self.caps(), modulus=(275760.0,) * 2, ratio=(0.42,) * 2,
                                 loading=loading, effects=effects, by_default=by_default)


def rough_scenes():
    """60 caps at compressions of .016 to .17 of their radius; 2000 under loads of 10 to 160 a cap,
    with compressions that are not less than those."""
    return (*(Rough(60, 6, c) for c in (0.02, 0.06, 0.12, 0.22)),
            *(Rough(2000, 31, c, 2000.0 * each) for each, c in
              ((10, 0.06), (20, 0.08), (40, 0.12), (60, 0.15), (80, 0.18), (120, 0.24),
               (160, 0.29))))


def made_by(families):
    for family, count, seed in families:
        for k, made in enumerate(family(np.random.default_rng(seed), count), 1):
            places, radii, gaps, closing, sphere = made
            yield caps(f"{family.__name__}_{k:03d}", family.__name__, places, radii, gaps, closing,
                       sphere)


def the_three():
    """Three caps of which the field of a neighbour tilts what the third one sees."""
    return Dense("triples_000", "triples", ((0.0, 0.0, 0.0, 1e4),),
                 ((0.0, 0.0, 0.1, 1.0), (0.1, 0.0, 0.1, 1.0), (0.05, 0.13, 0.1, 1.0)), 0.095)


@cache
def dense_scenes():
    """All scenes, in order."""
    scenes = [the_three(), *made_by(FAMILIES)]
    for name, family, upper, lower, closing in steep(np.random.default_rng(22), 44):
        scenes.append(Dense(name, family, upper, lower, round(TOP - closing, 12)))
    return (*scenes, *made_by(LATER))


if __name__ == "__main__":
    for scene in dense_scenes():
        scene.write(Path(sys.argv[1]))
