"""An adhesive sphere on a half-space, in the radius alone: the truth for adhesion on pixels.

The traction is constant on rings. A ring is the difference of two discs, whose displacements are
complete elliptic integrals (Johnson, Contact Mechanics, 1985, eq. 3.29). With the attraction s(g)
of the gap g the tractions t are those with g = 0 and t >= -s(0) in contact, t = -s(g) beyond it:
Newton's method on the rings, with the contact as an active set. The modulus and the radius are 1.
"""

import numpy as np


def elliptic(m):
    """Complete elliptic integrals K, E of the parameter m < 1, by the arithmetic-geometric mean."""
    a, b, c = np.ones_like(m), np.sqrt(1 - m), np.sqrt(m)
    lost, power = 0.5 * c**2, 0.5
    for _ in range(30):
        a, b, c = (a + b) / 2, np.sqrt(a * b), (a - b) / 2
        power *= 2
        lost = lost + power * c**2
    k = np.pi / 2 / a
    return k, k * (1 - lost)


def disc(r, a):
    """Displacement at radii r by unit pressure on a disc of radius a."""
    with np.errstate(divide="ignore", invalid="ignore"):
        inside = elliptic(np.where(r < a, (r / a)**2, 0.0))[1] * a
        k, e = elliptic(np.where(r < a, 0.0, (a / r)**2))
        beyond = r * (e - (1 - (a / r)**2) * k)
    return 4 / np.pi * np.where(r < a, inside, beyond)


class Sphere:
    """Rings from the axis to `side`; `attraction(g)` and its slope."""

    def __init__(self, attraction, slope, side, rings=240):
        edges = np.linspace(0, side, rings + 1)
        self.r = (edges[1:] + edges[:-1]) / 2
        discs = np.array([disc(self.r, a) for a in edges[1:]]).T
        self.act = np.diff(discs, axis=1, prepend=0.0)
        self.area = np.pi * np.diff(edges**2)
        self.attraction, self.slope = attraction, slope
        self.t = np.zeros(rings)

    def load(self, separation):
        """Load at a separation, from the last state."""
        t, act = self.t, self.act
        gap0 = separation + self.r**2 / 2
        closed = gap0 + act @ t <= 1e-12
        for _ in range(60):
            gap = gap0 + act @ t
            force = np.where(closed, gap, t + self.attraction(gap))
            turn = np.where(closed[:, None], act, np.eye(len(t)) + self.slope(gap)[:, None] * act)
            step = np.linalg.solve(turn, -force)
            t = t + step
            gap = gap0 + act @ t
            change = np.where(closed, t < -self.attraction(0.0), gap < 0)
            if np.abs(step).max() < 1e-11 * self.attraction(0.0) and not change.any():
                break
            closed = closed ^ change
        else:
            return None
        self.t = t
        return self.area @ t


def largest_pull(attraction, slope, side, start, stop, states, **grid):
    """The largest tensile load on a path of separations, by a parabola through the least loads."""
    sphere = Sphere(attraction, slope, side, **grid)
    loads = []
    for separation in np.linspace(start, stop, states):
        loads.append(sphere.load(separation))
        if loads[-1] is None or len(loads) > 3 and loads[-1] > loads[-2] > loads[-3] < 0:
            break
    loads = np.array([load for load in loads if load is not None])
    i = min(max(loads.argmin(), 1), len(loads) - 2)
    left, least, right = loads[i - 1:i + 2]
    return -(least - (right - left)**2 / (8 * (left - 2 * least + right)))
