"""Load and area of dense scenes, by pressures on squares: the truth for `interaction`.

Written apart from the solver. One half-space of the combined modulus under the least vertical gap
of all pairs of spheres, exact. The displacement at the centre of a square is that of uniform
pressures on all squares (Love 1929); the solver averages over its receiving cell, so the two have
different errors. The product is a Fourier transform on twice the domain: no periodic image.
Pressures are positive or the gap is: conjugate gradients (Polonsky and Keer 1999).

The load of a contact is what its law gives alone, times its load together over its load alone, both
on the same squares. So a pair that is inclined, or not quite a paraboloid, counts as in its law,
and most of the error of squares cancels. The same for areas, after the rim is corrected: squares
under pressure count too much, in proportion to the length of their edge (Yastrebov, Anciaux and
Molinari 2017). `settled` makes one number of three grids and states its error.

    python test/truth/dense_truth.py reference_output/interaction/dense.csv [PROCESSES]

Rows that are there are kept; remove the file to make it anew. `--rim` prints what RIM is made of.
"""

import csv
import sys
from multiprocessing import Pool
from pathlib import Path

import numpy as np

from dense_scenes import COMBINED, dense_scenes
from elements_truth import good, love
from surfaces_csv import records

# Of the edge of the squares under pressure (a staircase), in sides of a square: area counted too
# much. Measured on 98 circles of Hertz of 5 to 80 squares, places at random: .087 to .003 (`--rim`
# makes it again). Yastrebov's (pi - 1 + ln 2)/24 = .118 is for displacements of another grid.
RIM, RIM_ERROR = 0.087, 0.005
# Sizes of squares over the finest.
GRIDS = (1.7, 1.3, 1.0)
# Squares on the finest grid: at most so many in the domain, and in the radius of the largest
# contact alone. Of many contacts the errors of squares are averaged.
MANY = 60
MOST, RADIUS = 160_000, 80
MOST_OF_MANY, RADIUS_OF_MANY = 1_440_000, 32
# Errors to which squares are made smaller, and how much smaller; not for many contacts.
LOAD_ERROR, AREA_ERROR = 5e-5, 1.5e-3
FINER = (1.0, 0.6, 0.36)
# Few contacts do not average what squares scatter, and three grids can agree by chance: squares in
# the radius at least, of up to so many contacts.
FEW, RADIUS_OF_FEW = 3, 60
# Of the largest penetration: residual at which a solve ends.
CONVERGED = 2e-7
STEPS = 600


class Failed(Exception):
    """A solve that does not end."""


class Product:
    """Displacements of pressures on a grid: the last two axes."""

    def __init__(self, shape, side):
        self.shape, self.wide = shape, [good(2 * n) for n in shape]
        x, y = (np.minimum(np.arange(m), m - np.arange(m)) * side for m in self.wide)
        self.kernel = np.fft.rfft2(love(x[:, None], y[None], side, side)) / (np.pi * COMBINED)

    def __call__(self, pressure):
        # Zeros are not transformed where that can be left out.
        turned = np.fft.rfft(pressure, n=self.wide[1], axis=-1)
        turned = np.fft.fft(turned, n=self.wide[0], axis=-2)
        turned *= self.kernel
        turned = np.fft.ifft(turned, axis=-2)[..., :self.shape[0], :]
        return np.fft.irfft(turned, n=self.wide[1], axis=-1)[..., :self.shape[1]]


def total(values):
    return values.sum((-2, -1), keepdims=True)


def solve(gap, product, start, scale):
    """Pressures on grids that have no part of each other, all at a time.

    gap: (count, n, m); scale: (count, 1, 1), the penetration that the residual is measured by.
    """
    pressure = np.where(gap < 0, np.maximum(start, 0), 0)
    direction, previous, keep = np.zeros_like(gap), 1.0, np.zeros_like(scale)
    residual = gap + product(pressure)
    for _ in range(STEPS):
        inside = pressure > 0
        square = total(np.where(inside, residual ** 2, 0))
        rms = np.sqrt(square / np.maximum(total(inside), 1))
        least = np.where(inside, 0, residual).min((-2, -1), keepdims=True)
        if ((rms < CONVERGED * scale) & (least > -CONVERGED * scale)).all():
            return pressure
        direction = np.where(inside, residual + keep * square / previous * direction, 0)
        previous = np.where(square > 0, square, 1)
        image = product(direction)
        below = total(image * direction)
        step = total(residual * direction) / np.where(below > 0, below, 1)
        moved = np.maximum(pressure - step * direction, 0)
        enters = (moved <= 0) & (residual - step * image < 0) & ~inside
        # As in the source, but every square that needs pressure gets some, by the same step.
        moved = np.where(enters, np.maximum(-step * (residual - step * image), 0), moved)
        changed = enters.any((-2, -1), keepdims=True)
        keep = np.where(changed, 0.0, 1.0)
        if (moved - pressure + step * direction != 0).any():
            residual = gap + product(moved)
        else:
            residual = residual - step * image
        pressure = moved
    raise Failed(f"residual {(rms / scale).max():.1e}, {(least / scale).min():.1e}")


def area_of(pressure, side):
    """Area of the squares under pressure, and the length of their edge times their side."""
    inside = np.pad(pressure > 0, ((0, 0), (1, 1), (1, 1)))
    edge = (inside[:, 1:] != inside[:, :-1]).sum((1, 2)) + \
        (inside[:, :, 1:] != inside[:, :, :-1]).sum((1, 2))
    return side ** 2 * inside.sum((1, 2)), side ** 2 * edge


class Gap:
    """Vertical gaps of pairs, undeformed; from the places of first touch as they keep digits."""

    def __init__(self, pairs):
        self.place, self.penetration = pairs.place, pairs.penetration
        self.reach = np.sqrt(2 * pairs.radius * pairs.penetration)
        # Horizontal offset and height of the touch over (under) each centre.
        self.spheres = []
        for sign, radius in ((1, pairs.upper_radius), (-1, pairs.lower_radius)):
            offset = sign * (radius / pairs.sum)[:, None] * (pairs.lower - pairs.upper)
            self.spheres.append((offset, radius * pairs.rise / pairs.sum))

    def __call__(self, k, x, y):
        """Of pair k, at places given from its place of first touch."""
        gap = -self.penetration[k]
        for offset, height in self.spheres:
            drop = 2 * (offset[k, 0] * x + offset[k, 1] * y) + x * x + y * y
            root = height[k] ** 2 - drop
            gap = gap + np.where(root > 0, drop / (height[k] + np.sqrt(np.maximum(root, 0))), 1e6)
        return gap


class Grid:
    """A scene on squares of one size."""

    def __init__(self, pairs, side):
        self.gap, self.side, self.count = Gap(pairs), side, len(pairs.gap)
        reach = self.gap.reach[:, None]
        self.low = (self.gap.place - reach).min(0) - side
        self.shape = [int(v) for v in
                      np.ceil(((self.gap.place + reach).max(0) + side - self.low) / side)]
        # The window of each pair: as many squares for several of them, so that they go together.
        self.size = np.array([good(int(np.ceil(2 * r / side + 4))) for r in self.gap.reach])
        middle = (self.gap.place - self.low) / side
        self.first = np.floor(middle - self.size[:, None] / 2).astype(int)

    def window(self, k):
        """Gap of pair k in its window."""
        axes = (self.low[d] + self.side * (self.first[k, d] + np.arange(self.size[k]) + 0.5)
                - self.gap.place[k, d] for d in (0, 1))
        x, y = np.meshgrid(*axes, indexing="ij")
        return self.gap(k, x, y)

    def alone(self):
        """Load, area and edge of each pair by itself."""
        load, area, edge = np.zeros((3, self.count))
        for size in np.unique(self.size):
            product = Product((size, size), self.side)
            members = np.flatnonzero(self.size == size)
            at_a_time = max(1, 250_000 // size ** 2)
            for part in np.split(members, range(at_a_time, len(members), at_a_time)):
                gap = np.array([self.window(k) for k in part])
                depth = self.gap.penetration[part][:, None, None]
                pressure = solve(gap, product, self.lone_start(gap, part), depth)
                load[part] = self.side ** 2 * pressure.sum((1, 2))
                area[part], edge[part] = area_of(pressure, self.side)
        return load, area, edge

    def lone_start(self, gap, part):
        """Hertz' pressures: sqrt(1 - r^2/a^2), and the gap is -p (1 - r^2/(2 a^2))."""
        depth = self.gap.penetration[part][:, None, None]
        radius = self.gap.reach[part][:, None, None] ** 2 / (2 * depth)
        peak = 2 * COMBINED / np.pi * np.sqrt(depth / radius)
        return peak * np.sqrt(np.maximum(-2 * gap / depth - 1, 0))

    def together(self, start=None):
        """Pressures of all, and whose each square is."""
        gap, owner = np.full(self.shape, 1e6), np.zeros(self.shape, int)
        for k in range(self.count):
            own = self.window(k)
            low = np.maximum(self.first[k], 0)
            high = np.minimum(self.first[k] + self.size[k], self.shape)
            there = tuple(slice(a, b) for a, b in zip(low, high))
            here = tuple(slice(a - f, b - f) for a, b, f in zip(low, high, self.first[k]))
            less = own[here] < gap[there]
            gap[there][less] = own[here][less]
            owner[there][less] = k
        if start is None:
            start = np.sqrt(np.maximum(-gap, 0)) * COMBINED / 2
        depth = self.gap.penetration.max().reshape(1, 1, 1)
        return solve(gap[None], Product(self.shape, self.side), start[None], depth)[0], owner

    def spread(self, pressure, other):
        """Pressures on the squares of another grid, for a start."""
        index = [np.clip(((other.low[d] + other.side * (np.arange(other.shape[d]) + 0.5)
                           - self.low[d]) / self.side).astype(int), 0, self.shape[d] - 1)
                 for d in (0, 1)]
        return pressure[np.ix_(*index)]


def finest(pairs, finer):
    """The size of the finest squares; a side `finer` times that which the numbers above give."""
    gap = Gap(pairs)
    reach = gap.reach[:, None]
    extent = (gap.place + reach).max(0) - (gap.place - reach).min(0)
    most, radius = (MOST_OF_MANY, RADIUS_OF_MANY) if len(pairs.gap) > MANY else (MOST, RADIUS)
    return finer * max(np.sqrt(extent.prod() / most), gap.reach.max() / np.sqrt(2) / radius)


def share(part, whole):
    """Quotient; 0 for a contact that no square sees."""
    return np.divide(part, whole, out=np.zeros_like(whole), where=whole > 0)


def on_grids(pairs, side):
    """Of every grid: vertical load, area, what an error of RIM_ERROR moves it by, normal load."""
    law_load, law_normal, law_area = pairs.law()
    results, start, before = [], None, None
    for size in GRIDS:
        grid = Grid(pairs, size * side)
        if before is not None:
            start = before.spread(start, grid)
        pressure, owner = grid.together(start)
        start, before = pressure, grid
        load, area, edge = grid.alone()
        mine = np.bincount(owner.ravel(), pressure.ravel(), len(load)) * grid.side ** 2
        under = np.bincount(owner.ravel(), (pressure > 0).ravel(), len(load)) * grid.side ** 2
        areas = []
        for rim in (RIM, RIM + RIM_ERROR):
            # The edge of all belongs to each by its squares: circles that merge share one.
            whole, around = (v[0] for v in area_of(pressure[None], grid.side))
            corrected = under * (1 - rim * around / whole)
            areas.append((law_area * share(corrected, np.maximum(area - rim * edge, 0))).sum())
        kept = share(mine, load)
        results.append(((law_load * kept).sum(), areas[0], abs(areas[1] - areas[0]),
                        (law_normal * kept).sum()))
    return np.array(results)


def settled(results):
    """Load and area with their relative errors.

    The load's error falls as the square of the side: the line through three grids. Its error is
    what the finest grid differs from that, and twice what the grids differ from the line. The area
    is the mean of the grids, the finer the heavier: squares that are counted scatter as side^1.5.
    Its error is what that scatter is on these grids, and an error of the rim's constant.
    """
    sides = np.array(GRIDS)
    line = np.stack([np.ones(3), sides ** 2], 1)
    fit = np.linalg.lstsq(line, results[:, 0], rcond=None)[0]
    off = np.sqrt(((line @ fit - results[:, 0]) ** 2).sum())
    load_error = abs(fit[0] - results[-1, 0]) + 2 * off
    weight = sides ** -3 / (sides ** -3).sum()
    area = weight @ results[:, 1]
    scatter = np.sqrt(weight @ (results[:, 1] - area) ** 2)
    return (fit[0], max(load_error / fit[0], 1e-6), area,
            max((scatter + results[-1, 2]) / area, 1e-5))


def truth_of(scene):
    """A row of the table."""
    pairs = scene.pairs()
    for finer in FINER if len(pairs.gap) <= MANY else FINER[:1]:
        side = finest(pairs, finer)
        results = on_grids(pairs, side)
        load, load_error, area, area_error = settled(results)
        squares = Gap(pairs).reach.max() / np.sqrt(2) / side
        if load_error < LOAD_ERROR and area_error < AREA_ERROR and (
                len(pairs.gap) > FEW or squares >= RADIUS_OF_FEW):
            break
    alone, _, alone_area = (v.sum() for v in pairs.law())
    normal = load * results[-1, 3] / results[-1, 0]
    return {"scene": scene.name, "checksum": scene.checksum(), "contacts": len(pairs.gap),
            "closing": repr(pairs.closing), "alone": f"{alone:.9g}", "load": f"{load:.9g}",
            "load_error": f"{load_error:.1e}", "normal_load": f"{normal:.9g}",
            "alone_area": f"{alone_area:.6g}", "area": f"{area:.6g}",
            "area_error": f"{area_error:.1e}",
            "squares": f"{squares:.0f}"}


def rim():
    """RIM and the load's error on single circles, by squares a radius."""
    from dense_scenes import caps
    rng = np.random.default_rng(1)
    for n in (5, 10, 20, 40, 80):
        found = []
        for _ in range(max(6, 160 // n)):
            pairs = caps("one", "one", np.zeros((1, 2)), 1.0, [0], 1e-6, 1e9).pairs()
            circle = np.sqrt(pairs.radius * pairs.penetration)[0]
            grid = Grid(pairs, circle / (n * rng.uniform(0.93, 1.07)))
            grid.low += grid.side * rng.random(2)
            pressure = grid.together()[0]
            area, edge = (v[0] for v in area_of(pressure[None], grid.side))
            load = pressure.sum() * grid.side ** 2 / pairs.law()[0][0] - 1
            found.append(((area - pairs.law()[2][0]) / edge, load))
        found = np.array(found)
        print(n, *(f"{v:.2e}" for v in found.mean(0)), "+-",
              *(f"{v:.1e}" for v in found.std(0) / np.sqrt(len(found))))


def main(words):
    if words[0] == "--rim":
        rim()
        return
    path = Path(words[0])
    rows = {row["scene"]: row for row in records(path)}
    wanted = [s for s in dense_scenes() if s.checksum() != rows.get(s.name, {}).get("checksum")]
    with Pool(int(words[1]) if len(words) > 1 else 2) as pool:
        for row in pool.imap_unordered(truth_of, wanted):
            rows[row["scene"]] = row
            with open(path, "w", encoding="ascii", newline="") as file:
                writer = csv.DictWriter(file, list(row), lineterminator="\n")
                writer.writeheader()
                writer.writerows(rows[s.name] for s in dense_scenes() if s.name in rows)


if __name__ == "__main__":
    main(sys.argv[1:])
