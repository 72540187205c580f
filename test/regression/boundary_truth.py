"""Contacts pressed together and each alone on one half-space: the truth for `boundary`.

Written apart from the solver, on another basis. The bodies are an elastic half-space of combined
modulus E* below a rigid surface whose gap is the vertical one between two spheres,

    g_i(x) = zc_i - p_i - sqrt(ru^2 - |x - xu|^2) - sqrt(rl^2 - |x - xl|^2),

the least over the pairs. The pressure of contact i is written p = (2 E* a/(pi R)) sqrt(F), F a
polynomial in the plane; Hertz is F = 1 - r^2/a^2. The contact is where F > 0 around its centre,
so the edge is part of the unknowns and the pressure falls to zero there as a square root, which
is what p >= 0 with complementarity asks for. The coefficients follow from Galerkin's equations
(the displacement plus gap is orthogonal to every change of pressure, dF/(2 sqrt F)) by Newton's
method. Integrals of p/|x - x'| inside the own contact run along chords through x, where 1/|x - x'|
cancels against the plane polar element. Degrees of F are raised level by level; the difference of
the last two levels is the uncertainty.

`lattice` solves the same contacts on squares with Love's coefficients: slower, coarser, but simple
enough to check the above.

    python3 test/regression/boundary_truth.py > reference_output/boundary/factors.csv
    python3 test/regression/boundary_truth.py --check
"""

import sys
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
# Degree of F; chord directions and nodes a chord; radial and angular nodes of a contact; nodes
# in use where another contact is near.
LEVELS = {"4": (4, 12, 8, 8, 20, (24, 72)), "6": (6, 16, 10, 10, 28, (32, 96)),
          "8": (8, 20, 12, 12, 36, (40, 128)), "10": (10, 26, 16, 14, 44, (48, 160)),
          "12": (12, 32, 18, 16, 52, (56, 192)), "14": (14, 40, 22, 18, 64, (64, 240))}
LEVEL_NAMES = tuple(LEVELS)
REACH = 1.35    # an edge is looked for up to this radius, in units of the contact's own


class Failed(Exception):
    """No solution of the form sought was reached."""


@dataclass(frozen=True)
class Contact:
    """Two spheres, one above the other, and how far they came together past first touch."""

    xu: float
    yu: float
    ru: float
    xl: float
    yl: float
    rl: float
    penetration: float

    @property
    def plan(self):
        return float(np.hypot(self.xu - self.xl, self.yu - self.yl))

    @property
    def sum(self):
        return self.ru + self.rl

    @property
    def radius(self):
        return self.ru * self.rl / self.sum

    @property
    def rise(self):
        return float(np.sqrt(self.sum ** 2 - self.plan ** 2))

    @property
    def overlap(self):
        """W: the sum of radii less the distance of the centres; written without cancellation."""
        left = self.rise - self.penetration
        distance = np.hypot(self.plan, left)
        return self.penetration * (self.rise + left) / (self.sum + distance)

    @property
    def place(self):
        """Where the spheres touch first, in plan."""
        share = self.ru / self.sum
        return np.array([self.xu + share * (self.xl - self.xu),
                         self.yu + share * (self.yl - self.yu)])

    @property
    def circle(self):
        """Radius of the contact circle of the independent model."""
        return float(np.sqrt(self.radius * self.overlap))

    def hertz_normal(self, modulus):
        """Load of the independent model: Hertz along the line of centres."""
        return 4 / 3 * modulus * np.sqrt(self.radius) * self.overlap ** 1.5

    def hertz(self, modulus):
        """Its vertical part."""
        left = self.rise - self.penetration
        return self.hertz_normal(modulus) * left / np.hypot(self.plan, left)

    def gap(self, points):
        """Vertical gap without deformation; far outside where a sphere ends."""
        upper = self.ru ** 2 - ((points - (self.xu, self.yu)) ** 2).sum(-1)
        lower = self.rl ** 2 - ((points - (self.xl, self.yl)) ** 2).sum(-1)
        end = self.rise - self.penetration
        return np.where((upper > 0) & (lower > 0), end - np.sqrt(np.maximum(upper, 0))
                        - np.sqrt(np.maximum(lower, 0)), np.inf)


def circles_that_overlap(contacts):
    return sum(np.hypot(*(a.place - b.place)) < a.circle + b.circle
               for a, b in combinations(contacts, 2))


# One contact: a polynomial in the disc of its own centre and radius.

def powers(values, degree):
    """Chebyshev polynomials 0..degree; the last axis counts them."""
    out = np.empty((*np.shape(values), degree + 1))
    out[..., 0] = 1
    out[..., 1] = values
    for k in range(2, degree + 1):
        out[..., k] = 2 * values * out[..., k - 1] - out[..., k - 2]
    return out


def columns(degree):
    """Powers (i, j) of the two coordinates, i + j <= degree, in order of their sum."""
    return np.array([(i, n - i) for n in range(degree + 1) for i in range(n + 1)]).T


def basis(points, degree):
    i, j = columns(degree)
    return powers(points[..., 0], degree)[..., i] * powers(points[..., 1], degree)[..., j]


@dataclass(frozen=True)
class Patch:
    """A contact area: centre and scale of its coordinates, coefficients of F, size of p."""

    centre: np.ndarray
    scale: float
    peak: float
    degree: int
    coefficients: np.ndarray

    def value(self, points):
        return basis(points, self.degree) @ self.coefficients

    def raised(self, degree):
        more = np.zeros(columns(degree).shape[1])
        more[:self.coefficients.size] = self.coefficients
        return replace(self, degree=degree, coefficients=more)

    def roots(self, start, direction):
        """First zero of F from each start along each direction, in units of the scale."""
        along = (start * direction).sum(-1)
        end = -along + np.sqrt(along ** 2 + REACH ** 2 - (start ** 2).sum(-1))
        # F on the line, by interpolation: cheap to evaluate many times.
        n = self.degree + 1
        angles = (np.arange(n) + 0.5) * np.pi / n
        nodes = (np.cos(angles) + 1) / 2
        points = start[..., None, :] + (end[..., None] * nodes)[..., None] * direction[..., None, :]
        to_line = 2 / n * np.cos(np.outer(np.arange(n), angles))
        to_line[0] /= 2
        line = self.value(points) @ to_line.T
        at = np.linspace(0, 1, 4 * n)
        inside = line @ powers(2 * at - 1, self.degree).T > 0
        if not inside[..., 0].all() or inside.all(-1).any():
            raise Failed("a start outside, or an edge out of reach")
        first = np.argmin(inside, axis=-1)
        low, high = at[first - 1], at[first]
        slope = 2 * np.polynomial.chebyshev.chebder(line, axis=-1)
        zero = (low + high) / 2
        for _ in range(7):
            p = powers(2 * zero - 1, self.degree)
            zero = zero - (p * line).sum(-1) / (p[..., :-1] * slope).sum(-1)
            zero = np.clip(zero, low, high)
        return zero * end

    def nodes(self, radial, angular):
        """Points, weights for integrals of f dA over the area, and sqrt F."""
        theta = np.arange(angular) * 2 * np.pi / angular
        direction = np.stack([np.cos(theta), np.sin(theta)], -1)
        edge = self.roots(np.zeros_like(direction), direction)
        u, w = np.polynomial.legendre.leggauss(radial)
        beta, w = (u + 1) * np.pi / 4, w * np.pi / 4
        r = edge * np.sin(beta)[:, None]
        weights = (w * np.cos(beta))[:, None] * r * edge * (2 * np.pi / angular)
        points = (r[..., None] * direction).reshape(-1, 2)
        return points, weights.ravel(), np.sqrt(np.maximum(self.value(points), 1e-300))

    def recentred(self):
        """The same F in coordinates whose disc is near the area."""
        points, weights, _ = self.nodes(8, 4 * self.degree + 8)
        area = weights.sum()
        shift, size = weights @ points / area, np.sqrt(area / np.pi)
        n = self.degree + 1
        c = np.cos((np.arange(n) + 0.5) * np.pi / n)
        grid = np.stack(np.meshgrid(c, c), -1).reshape(-1, 2)
        new = np.linalg.lstsq(basis(grid, self.degree), self.value(shift + size * grid),
                              rcond=None)[0]
        return replace(self, centre=self.centre + self.scale * shift, scale=self.scale * size,
                       coefficients=new)

    def own_displacement(self, points, directions, nodes):
        """Integral of p/|x - x'| over the own area at points of it; its change with F."""
        phi = np.arange(directions) * np.pi / directions
        direction = np.broadcast_to(np.stack([np.cos(phi), np.sin(phi)], -1),
                                    (len(points), directions, 2))
        start = np.broadcast_to(points[:, None, :], direction.shape)
        ahead, behind = self.roots(start, direction), self.roots(start, -direction)
        alpha = (np.arange(nodes) + 0.5) * np.pi / nodes
        middle, half = (ahead - behind) / 2, (ahead + behind) / 2
        along = middle[..., None] + half[..., None] * np.cos(alpha)
        at = (start[:, :, None, :] + along[..., None] * direction[:, :, None, :])
        at = at.reshape(len(points), -1, 2)
        weights = (half[..., None] * np.sin(alpha)).reshape(len(points), -1)
        weights = weights * (np.pi / nodes) * (np.pi / directions)
        x, y = powers(at[..., 0], self.degree), powers(at[..., 1], self.degree)
        i, j = columns(self.degree)
        square = np.zeros((self.degree + 1, self.degree + 1))
        square[i, j] = self.coefficients
        root = np.sqrt(np.maximum(((x @ square) * y).sum(-1), 1e-300))
        factor = self.scale * self.peak
        value = factor * (weights * root).sum(-1)
        change = np.matmul((x * (weights / (2 * root))[..., None]).transpose(0, 2, 1), y)
        return value, factor * change[:, i, j]

    def load(self, radial=40, angular=96):
        _, weights, root = self.nodes(radial, angular)
        return self.peak * self.scale ** 2 * float(weights @ root)


def hertz_patch(contact, penetration, modulus, shift=(0.0, 0.0)):
    """The disc of an aligned pair."""
    scale = np.sqrt(contact.radius * penetration)
    coefficients = np.zeros(6)
    i, j = columns(2)
    coefficients[(i == 2) | (j == 2)] = -0.5
    return Patch(contact.place + np.array(shift), scale,
                 2 * modulus * np.sqrt(contact.radius * penetration) / (np.pi * contact.radius),
                 2, coefficients)


# All contacts together.

def inverse_distance(points, others):
    x = points[:, None, 0] - others[None, :, 0]
    y = points[:, None, 1] - others[None, :, 1]
    return 1 / np.sqrt(x * x + y * y)


def assemble(contacts, patches, modulus, level):
    """Galerkin's residual and matrix, and the error of the gap they leave."""
    degree, directions, chord, radial, angular, fine = level
    factor = 1 / (np.pi * modulus)
    targets = [p.nodes(radial, angular) for p in patches]
    places = [p.centre + p.scale * t[0] for p, t in zip(patches, targets)]
    tests = [basis(t[0], p.degree) * (t[1] / (2 * t[2]))[:, None] * p.scale ** 2 * p.peak
             for p, t in zip(patches, targets)]
    residual = [c.gap(x) for c, x in zip(contacts, places)]
    size = tests[0].shape[1]
    matrix = np.empty((len(patches) * size, len(patches) * size))
    for j, source in enumerate(patches):
        there = {}
        for i, target in enumerate(patches):
            block = np.s_[i * size:(i + 1) * size, j * size:(j + 1) * size]
            if i == j:
                value, change = source.own_displacement(targets[i][0], directions, chord)
                residual[i] = residual[i] + factor * value
                matrix[block] = factor * tests[i].T @ change
                continue
            apart = np.hypot(*(target.centre - source.centre))
            near = apart < 1.6 * source.scale + target.scale
            if near not in there:
                points, weights, root = source.nodes(*(fine if near else (radial, angular)))
                there[near] = (source.centre + source.scale * points,
                               source.peak * source.scale ** 2 * weights * root,
                               basis(points, degree)
                               * (source.peak * source.scale ** 2 * weights / (2 * root))[:, None])
            points, pressure, change = there[near]
            inverse = inverse_distance(places[i], points)
            residual[i] = residual[i] + factor * inverse @ pressure
            matrix[block] = factor * tests[i].T @ (inverse @ change)
    vector = np.concatenate([t.T @ r for t, r in zip(tests, residual)])
    return vector, matrix, size


def newton(contacts, patches, modulus, level, steps=25):
    """Patches in equilibrium at one level."""
    patches = [p.raised(level[0]) for p in patches]
    vector, matrix, size = assemble(contacts, patches, modulus, level)
    for _ in range(steps):
        # Rows and columns are scaled: loads differ by powers of ten.
        d = 1 / np.sqrt(np.abs(np.diag(matrix)))
        step = -d * np.linalg.solve(matrix * d[:, None] * d[None], d * vector)
        most = np.abs(step).max()
        share = 1.0
        while True:
            try:
                trial = [replace(p, coefficients=p.coefficients
                                 + share * step[k * size:(k + 1) * size]).recentred()
                         for k, p in enumerate(patches)]
                vector, matrix, size = assemble(contacts, trial, modulus, level)
                break
            except Failed:
                share /= 2
                if share < 1e-3:
                    raise
        patches = trial
        if share > 0.99 and most < 1e-8:    # quadratic: what is left is at rounding
            return patches
    raise Failed(f"Newton's method stopped at a step of {most:.1e}")


def first_guess(contacts, modulus):
    """Discs whose neighbours act as P/(pi E* r) at their centre; None for one that opens."""
    places = np.array([c.place for c in contacts])
    given = np.array([c.penetration for c in contacts])
    radius = np.array([c.radius for c in contacts])
    difference = places[:, None] - places[None]
    distance = np.hypot(difference[..., 0], difference[..., 1])
    np.fill_diagonal(distance, np.inf)
    left = given.copy()
    for _ in range(200):
        load = 4 / 3 * modulus * np.sqrt(radius) * np.maximum(left, 0) ** 1.5
        left = 0.5 * left + 0.5 * (given - (load / (np.pi * modulus * distance)).sum(1))
    # A neighbour's slope moves the deepest point away from it.
    shift = radius[:, None] * (difference * (load / (np.pi * modulus * distance ** 3))[..., None]
                               ).sum(1)
    return [None if w <= 0 else hertz_patch(c, w, modulus, s)
            for c, w, s in zip(contacts, left, shift)]


def outside(points, patches, modulus):
    """Displacement at points outside the areas, not at an edge."""
    total = np.zeros(len(points))
    for p in patches:
        near = np.hypot(*(points - p.centre).T).min() < 2 * p.scale
        at, weights, root = p.nodes(*((40, 160) if near else (8, 24)))
        at = p.centre + p.scale * at
        pressure = p.peak * p.scale ** 2 * weights * root
        total += inverse_distance(points, at) @ pressure
    return total / (np.pi * modulus)


def is_inside(points, patch, margin=1.03):
    """Inside the area widened by a margin: sums are too coarse for points at its edge."""
    local = (points - patch.centre) / patch.scale
    r = np.hypot(local[:, 0], local[:, 1])
    theta = 2 * np.pi * np.arange(720) / 720
    direction = np.stack([np.cos(theta), np.sin(theta)], -1)
    edge = patch.roots(np.zeros_like(direction), direction)
    angle = np.mod(np.arctan2(local[:, 1], local[:, 0]), 2 * np.pi)
    return r < margin * np.interp(angle, np.append(theta, 2 * np.pi), np.append(edge, edge[0]))


def clearance(contact, contacts, closed, modulus, steps=40):
    """Where, in a contact's undeformed overlap and outside the areas, the gap left is least, and
    that gap; None when the areas cover the overlap."""
    axis = np.linspace(-1.6 * contact.circle, 1.6 * contact.circle, steps)
    points = contact.place + np.stack(np.meshgrid(axis, axis), -1).reshape(-1, 2)
    gap = np.min([c.gap(points) for c in contacts], axis=0)
    points, gap = points[gap < 0], gap[gap < 0]
    for patch in closed:
        keep = ~is_inside(points, patch)
        points, gap = points[keep], gap[keep]
    if not len(points):
        return None
    left = gap + outside(points, closed, modulus)
    return points[left.argmin()], left.min()


def least_gap(contacts, patches, modulus):
    """The least gap left outside the areas over the largest penetration."""
    closed = [p for p in patches if p is not None]
    found = [clearance(c, contacts, closed, modulus) for c in contacts]
    return (min((f[1] for f in found if f is not None), default=0.0)
            / max(c.penetration for c in contacts))


def side(contacts, patches):
    """Least gap of the other pairs less the own gap, in the areas: positive when each area lies
    where its own pair is the nearest, as the polynomials take for granted."""
    least = np.inf
    for k, patch in enumerate(patches):
        if patch is not None and len(contacts) > 1:
            inner = patch.centre + patch.scale * patch.nodes(8, 64)[0]
            others = np.min([c.gap(inner) for c in contacts[:k] + contacts[k + 1:]], axis=0)
            least = min(least, (others - contacts[k].gap(inner)).min())
    return float(least)


def solve(contacts, modulus, level, start=None):
    """Patches of the contacts, None for those that stay open, through degrees 2, 4, ..."""
    patches = list(start or first_guess(contacts, modulus))
    top = LEVELS[level]
    for _ in range(4 + 2 * len(contacts)):
        shut = [k for k, p in enumerate(patches) if p is not None]
        group, now = [contacts[k] for k in shut], [patches[k] for k in shut]
        try:
            for degree in range(max(p.degree for p in now), top[0] + 1, 2):
                settings = (top if degree == top[0] else
                            LEVELS.get(str(degree), (2, 10, 6, 6, 16, (16, 48))))
                now = newton(group, now, modulus, settings)
        except Failed:
            # The weakest opens, and closes again below if that was wrong.
            if len(shut) == 1:
                raise
            patches[min(shut, key=lambda k: patches[k].scale)] = None
            continue
        reopened = False
        for k, c in enumerate(contacts):
            if patches[k] is None:
                found = clearance(c, contacts, now, modulus)
                if found is not None and found[1] < -1e-6 * c.penetration:
                    patches[k] = hertz_patch(c, -found[1], modulus, found[0] - c.place)
                    reopened = True
        if reopened:
            continue
        for k, p in zip(shut, now):
            patches[k] = p
        return patches
    raise Failed("which contacts stay open was not settled")


def evaluate(contacts, modulus, levels=("4", "6")):
    """Loads of contacts together and each alone, at rising levels; a dict, the last level's.

    contacts: list of `Contact`; modulus: E*; levels: names in LEVELS, the degree of F. `factor` is
    together over alone, `uncertainty` what the last level changed of it, `loads` and `loads_alone`
    by contact (zero: pushed open), `hertz` and `hertz_normal` sums of the independent model,
    `least_gap` and `side` as above: not negative. Raises `Failed`.
    """
    rows, together, alone = [], None, [None] * len(contacts)
    for level in levels:
        alone = [solve([c], modulus, level, a) for c, a in zip(contacts, alone)]
        together = alone[0] if len(contacts) == 1 else solve(contacts, modulus, level, together)
        rows.append(([0.0 if p is None else p.load() for p in together],
                     [a[0].load() for a in alone]))
    factors = [sum(r[0]) / sum(r[1]) for r in rows]
    own_side = side(contacts, together)
    if own_side <= 0:
        raise Failed("areas run into each other")
    return {"together": sum(rows[-1][0]), "alone": sum(rows[-1][1]), "factor": factors[-1],
            "uncertainty": abs(factors[-1] - factors[-2]) if len(factors) > 1 else np.nan,
            "factors": factors, "loads": rows[-1][0], "loads_alone": rows[-1][1],
            "hertz": sum(c.hertz(modulus) for c in contacts),
            "hertz_normal": sum(c.hertz_normal(modulus) for c in contacts),
            "least_gap": least_gap(contacts, together, modulus), "side": own_side,
            "overlapping_circles": circles_that_overlap(contacts), "patches": together}


# The same contacts on squares.

def lattice(contacts, modulus, side):
    """Loads of the contacts by pressures on squares of one lattice: conjugate gradients with
    p >= 0 (after Polonsky and Keer 1999), the product by Fourier transforms without images."""
    low = np.min([c.place - 1.5 * c.circle for c in contacts], axis=0)
    high = np.max([c.place + 1.5 * c.circle for c in contacts], axis=0)
    n = [int(np.ceil(v)) for v in (high - low) / side]
    points = np.stack(np.meshgrid(*(low[k] + side * (np.arange(n[k]) + 0.5) for k in (0, 1)),
                                  indexing="ij"), -1)
    gaps = np.array([c.gap(points) for c in contacts])
    gap = np.minimum(gaps.min(axis=0), max(c.rise for c in contacts))
    apart = [np.minimum(np.arange(2 * m), 2 * m - np.arange(2 * m)) * side for m in n]
    kernel = np.fft.rfft2(love(apart[0][:, None], apart[1][None], side / 2)) / (np.pi * modulus)

    def product(pressure):
        return np.fft.irfft2(np.fft.rfft2(pressure, s=(2 * n[0], 2 * n[1])) * kernel,
                             s=(2 * n[0], 2 * n[1]))[:n[0], :n[1]]

    pressure = np.sqrt(np.maximum(-gap, 0)) * modulus / 2
    direction, previous, restart = np.zeros_like(gap), 1.0, True
    scale = max(c.penetration for c in contacts)
    for _ in range(2000):
        residual = gap + product(pressure)
        inside = pressure > 0
        square = (residual[inside] ** 2).sum()
        if np.sqrt(square / inside.sum()) < 1e-9 * scale and not restart:
            return [side ** 2 * pressure[gaps.argmin(axis=0) == k].sum()
                    for k in range(len(contacts))]
        direction = np.where(inside, residual + (0 if restart else square / previous) * direction,
                             0.0)
        previous = square
        image = product(direction)
        step = (residual * direction)[inside].sum() / (image * direction)[inside].sum()
        pressure = np.maximum(pressure - step * np.where(inside, direction, 0), 0)
        closing = (pressure <= 0) & (residual < 0)
        restart = bool(closing.any())
        pressure[closing] -= step * residual[closing]
    raise Failed("the lattice did not converge")


def love(x, y, half):
    """Integral of 1/|x - x'| over a square about the origin (Love 1929)."""
    a, b, c, d = x + half, x - half, y + half, y - half

    def part(u, v):
        """u ln(v + r): the corner's share."""
        return u * np.arcsinh(v / np.abs(u)) + v * np.arcsinh(u / np.abs(v))

    return part(a, c) - part(a, d) - part(b, c) + part(b, d)


# The sweep of the thesis, and checks.

def thesis_contacts():
    """E* in N/cm2 and the contacts of each position, from the exact evaluation of the deck."""
    from exact_contact import Truth, mp, read_deck

    truth = Truth(read_deck(ROOT / "data" / "thesis.deck"), 30)
    positions = {}
    for m in range(1, truth.scene.positions + 1):
        state, contacts = truth.state(m), []
        with mp.workdps(truth.digits):
            pairs = [] if state is None else [p for p in truth.near_pairs(m)
                                              if p.names in state.contacts]
            for p in pairs:
                upper = float(truth.upper[p.names[0] - 1][3])
                lower = float(truth.lower[p.names[1] - 1][3])
                contacts.append(Contact(*map(float, p.upper), upper, *map(float, p.lower), lower,
                                        float(p.touch - state.approach)))
        positions[m] = contacts
    return float(truth.modulus), positions


def write_factors(positions, modulus):
    """One row a position. Less than 1e-10 is not claimed, whatever the levels say."""
    print("position,contacts,together,alone,factor,uncertainty,overlapping_circles,open,hertz,"
          "hertz_normal,least_gap")
    for m, contacts in positions.items():
        levels = ("4", "6", "8") if circles_that_overlap(contacts) else ("4", "6")
        r = evaluate(contacts, modulus, levels)
        print(f"{m},{len(contacts)},{r['together']:.10g},{r['alone']:.10g},{r['factor']:.10g},"
              f"{max(r['uncertainty'], 1e-10):.1e},{r['overlapping_circles']},"
              f"{r['loads'].count(0.0)},{r['hertz']:.10g},{r['hertz_normal']:.10g},"
              f"{r['least_gap']:.1e}", flush=True)


def sneddon(sphere, radius):
    """Two equal spheres one above the other, exact profile (Sneddon 1965): penetration, load/E*."""
    log = np.log((sphere + radius) / (sphere - radius))
    return radius * log, (radius ** 2 + sphere ** 2) * log - 2 * radius * sphere


def check():
    """One pair against closed forms; two near contacts and position 56 against the lattice."""
    from mpmath import mp

    print("aligned spheres of radius 1.27 against Sneddon's closed form and Hertz")
    for radius in (0.01, 0.03, 0.0937, 0.2, 0.4):
        penetration, load = sneddon(1.27, radius)
        one = Contact(0, 0, 1.27, 0, 0, 1.27, penetration)
        found = evaluate([one], 1.0)
        print(f"  a/R {radius / 0.635:.3f}  error {found['together'] / load - 1:8.1e}"
              f"  over Hertz {found['together'] / found['hertz'] - 1:9.2e}")
    print("inclined pair at a small penetration against the elliptical Hertz contact")
    for slope in (0.05, 0.1, 0.2):
        plan = 2.54 * slope / np.hypot(1, slope)
        one = Contact(0, 0, 1.27, plan, 0, 1.27, 1e-6)
        found, truth = evaluate([one], 1.0), ellipse(slope, 0.635, 1e-6, mp)
        print(f"  slope {slope}  error {found['together'] / truth - 1:8.1e}"
              f"  over Hertz's normal load {found['together'] / found['hertz_normal'] - 1:.2e}"
              f"  over its vertical part {found['together'] / found['hertz'] - 1:.2e}")
    modulus, positions = thesis_contacts()
    near = [Contact(0, 0, 1.27, 0, 0, 1.27, 0.0138), Contact(0.16, 0, 1.27, 0.16, 0, 1.27, 0.0132)]
    for name, contacts, cells in (("two circles that overlap", near, (10.3, 20.3, 40.3, 80.3)),
                                  ("position 18", positions[18], (10.3, 20.3, 40.3)),
                                  ("position 56", positions[56], (10.3, 20.3))):
        found = evaluate(contacts, modulus, ("4", "6", "8"))
        print(f"{name}: factor by level", *(f"{f:.8f}" for f in found["factors"]))
        for n in cells:
            side = max(c.circle for c in contacts) / n
            alone = sum(sum(lattice([c], modulus, side)) for c in contacts)
            loads = lattice(contacts, modulus, side)
            print(f"  lattice, {n} squares a radius: factor {sum(loads) / alone:.7f}, "
                  f"load {sum(loads) / found['together'] - 1:8.1e}")


def ellipse(slope, radius, penetration, mp):
    """Load/E* of the gap x^2/(2 R c^3) + y^2/(2 R c), c = cos M (Hertz; Johnson 1985, 4.2)."""
    ratio = mp.mpf(1 + slope ** 2)
    cosine = 1 / mp.sqrt(ratio)
    # The curvatures' ratio as a function of the axes' gives the eccentricity m = e^2.
    def curvatures(m):
        k, e = mp.ellipk(m), mp.ellipe(m)
        return (e / (1 - m) - k) / (k - e)

    m = mp.findroot(lambda v: curvatures(v) - ratio, (slope ** 2, 1.5 * slope ** 2))
    k, e = mp.ellipk(m), mp.ellipe(m)
    # With the long half axis l: y^2/(2 R c) and the penetration give l and the peak.
    # u = (p0 b/E*) (K - ((K - E)/m) y^2/l^2 - ...), y along the long axis.
    long2 = penetration * 2 * radius * cosine * (k - e) / (m * k)
    short = mp.sqrt(long2 * (1 - m))
    peak = penetration / (short * k)
    return float(2 * mp.pi / 3 * peak * mp.sqrt(long2) * short)


if __name__ == "__main__":
    if "--check" in sys.argv[1:]:
        check()
    else:
        E_STAR, POSITIONS = thesis_contacts()
        write_factors(POSITIONS, E_STAR)
