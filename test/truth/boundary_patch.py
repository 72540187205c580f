"""Two spheres in contact and the pressure between them, for boundary_truth.py.

The pressure is the root of a polynomial F, whose zero line is the edge of the contact.
"""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

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
