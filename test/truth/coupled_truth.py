"""What the equations of `coupled` leave over, evaluated apart from the program.

The displacement that a Hertz pressure leaves on a half-space is taken in closed form (Johnson,
Contact Mechanics, 1985, equations 3.41a and 3.42a) and averaged over the other contact's circle by
quadrature: for its load with the weight of a flat punch (reciprocal theorem), for its tilt with
that of Hertz. Far away the first two terms of a series do.
"""

import numpy as np

NEAR = 6.0  # sums of radii; beyond it the series' error is 1e-5 of one pair's displacement
RADIAL, ANGULAR = 8, 16


def hertz_displacement(r, circle):
    """Displacement and its slope at a distance, for unit load and E* = 1."""
    ratio = np.minimum(circle / np.maximum(r, 1e-300), 1.0)
    root = np.sqrt((1 - ratio) * (1 + ratio))
    peak = 3 / (2 * np.pi * circle ** 2)
    lift = peak / (2 * circle) * ((2 * circle ** 2 - r ** 2) * np.arcsin(ratio)
                                  + r * circle * root)
    slope = peak / circle * (circle * root - r * np.arcsin(ratio))
    return lift, slope


def means(dx, dy, own, source):
    """Mean displacement over the own circles and mean slopes, at offsets from the sources."""
    node, weight = np.polynomial.legendre.leggauss(RADIAL)
    node, weight = (node + 1) / 2, weight / 2
    turn = 2 * np.pi * (np.arange(ANGULAR) + 0.5) / ANGULAR
    lift, slope_x, slope_y = (np.zeros_like(dx) for _ in range(3))
    for s, w in zip(node, weight):
        reach = own * np.sqrt(1 - s * s)
        for angle in turn:
            x, y = dx + reach * np.cos(angle), dy + reach * np.sin(angle)
            r = np.hypot(x, y)
            u, slope = hertz_displacement(r, source)
            lift += w * u / ANGULAR
            slope = slope / np.maximum(r, 1e-300) * 3 * s * s * w / ANGULAR
            slope_x += slope * x
            slope_y += slope * y
    return lift, slope_x, slope_y


class Field:
    """Loaded contacts and what they do to each other and to open ones."""

    def __init__(self, places, circles, loads, modulus):
        self.places, self.circles = places, circles
        self.loads = loads / modulus

    def at(self, places, circles, sources, itself):
        """Displacement and slopes at contacts; `sources` where the loads stand now. `itself`: the
        contacts are the sources, and none acts on itself."""
        dx = places[:, None, 0] - sources[None, :, 0]
        dy = places[:, None, 1] - sources[None, :, 1]
        r = np.hypot(dx, dy)
        if itself:
            np.fill_diagonal(r, np.inf)
        near = r < NEAR * (circles[:, None] + self.circles[None])
        far = np.where(near, np.inf, r)
        own2, source2 = circles[:, None] ** 2, self.circles[None] ** 2
        load = self.loads[None] / np.pi
        lift = (load / far * (1 + (own2 / 3 + source2 / 5) / (2 * far ** 2))).sum(1)
        slope = -load / far ** 3 * (1 + 1.5 * (own2 + source2) / 5 / far ** 2)
        tilt_x, tilt_y = (slope * dx).sum(1), (slope * dy).sum(1)
        i, j = np.nonzero(near)
        parts = means(dx[i, j], dy[i, j], circles[i], self.circles[j])
        for total, part in zip((lift, tilt_x, tilt_y), parts):
            np.add.at(total, i, part * self.loads[j])
        return lift, np.stack([tilt_x, tilt_y], -1)

    def shifts(self, radius):
        """Where each contact comes to lie on the tilted surface: s = -R slope, at the shifted
        places. Damped by how fast the slope changes."""
        shift = np.zeros_like(self.places)
        probe = 1e-4 * self.circles[:, None]
        for _ in range(400):
            now = self.places + shift
            wanted = -radius * self.at(now, self.circles, now, True)[1]
            step = wanted - shift
            along = step / np.maximum(np.hypot(*step.T), 1e-300)[:, None]
            moved = now + probe * along
            change = -radius * self.at(moved, self.circles, now, True)[1] - wanted
            rate = np.maximum(-(change * along).sum(1) / probe[:, 0], 0)
            step *= (1 / (1 + 1.5 * rate))[:, None]
            shift = shift + step
            if (np.abs(step).max(1) < 1e-7 * self.circles).all():
                return shift
        left = (np.abs(step).max(1) / self.circles).max()
        raise AssertionError(f"places did not settle: {left:.1e} of a circle")


def leftover(places, radius, room, penetrations, circles, loads, modulus, open_places, open_room):
    """What each loaded contact's equation leaves over, and how far open ones would penetrate; over
    the largest penetration.

    room: compression less gap, of the loaded and of the open contacts."""
    field = Field(places, circles, loads, modulus)
    shift = field.shifts(radius)
    now = places + shift
    lift, _ = field.at(now, circles, now, True)
    rest = room - lift - (shift ** 2).sum(1) / (2 * radius) - penetrations
    closed = -np.inf
    if len(open_places):
        lift, _ = field.at(open_places, np.zeros(len(open_places)), now, False)
        closed = (open_room - lift).max()
    return rest / penetrations.max(), closed / penetrations.max()
