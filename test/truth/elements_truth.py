"""Pressures on a grid that press a rigid body on a half-space, in numpy: the truth for dense scenes
and for height maps. Written apart from the program.

Minimise 1/2 p A p + g p over pressures p >= 0, at a compression (g < 0 where the bodies overlap
without deformation) or under a load (sum p given, g up to a constant). Pressures are uniform on
each rectangle, A p is the displacement at its centre: Love (1929) on a half-space, waves on one
that repeats itself. Method: conjugate gradients over the loaded elements (Polonsky and Keer 1999),
preconditioned by the wave number, the inverse of A up to the edges.
"""

import numpy as np
from numpy.fft import fft, ifft, irfft, irfft2, rfft, rfft2

STEPS = 3000
# Of the edge of the elements under pressure (a staircase), in sides of an element: area counted too
# much. Measured on 98 circles of Hertz of 5 to 80 elements, places at random: .087 to .003
# (`dense_truth.py --rim` makes it again). Yastrebov, Anciaux and Molinari's (2017) .118 is for
# displacements of another grid.
RIM, RIM_ERROR = 0.087, 0.005


class Failed(Exception):
    """A solve that does not end."""


def good(n):
    """The least number of 2, 3 and 5 not below n: quick to transform."""
    most = int(n).bit_length() + 1
    return min(v for i in range(most) for j in range(most) for k in range(most)
               if (v := 2 ** i * 3 ** j * 5 ** k) >= n)


def love(x, y, a, b):
    """Integral of 1/r over a rectangle of sides a and b at a distance (x, y) from its centre."""
    def part(u, v):
        return u * np.arcsinh(v / np.abs(u)) + v * np.arcsinh(u / np.abs(v))

    return (part(x + a / 2, y + b / 2) - part(x - a / 2, y + b / 2)
            - part(x + a / 2, y - b / 2) + part(x - a / 2, y - b / 2))


def waves(shape, sides):
    """Wave numbers of a grid [1/length]."""
    return 2 * np.pi * np.hypot(np.fft.fftfreq(shape[0], sides[0])[:, None],
                                np.fft.rfftfreq(shape[1], sides[1]))


def product(shape, sides, modulus, periodic=False):
    """The function p -> A p on a grid."""
    if periodic:
        wave = waves(shape, sides)
        wave[0, 0] = np.inf
        return lambda p: irfft2(rfft2(p) * (2 / wave / modulus), shape)
    wide = [good(2 * n) for n in shape]
    x, y = (np.minimum(np.arange(m), m - np.arange(m)) * side for m, side in zip(wide, sides))
    kernel = rfft2(love(x[:, None], y, *sides)) / (np.pi * modulus)

    def displacement(p):
        # Zeros are not transformed where that can be left out.
        turned = fft(rfft(p, wide[1]), wide[0], axis=0) * kernel
        return irfft(ifft(turned, axis=0)[:shape[0]], wide[1])[:, :shape[1]]

    return displacement


def press(gap, act, sides, load=None, start=None, closed=1e-8):
    """Pressures and level: the gap left is g + A p - level, 0 where loaded to `closed` of the range
    of gaps. At a compression (no load) the level is 0."""
    shape, cell = gap.shape, sides[0] * sides[1]
    wave = waves(shape, sides)
    if load is None:
        wave[0, 0] = wave[0, 1] / 4
        p = np.zeros(shape) if start is None else np.where(gap < 0, start, 0.0)
    else:
        p = np.where(np.isfinite(gap), 1.0 if start is None else start, 0.0)
        p = p * (load / cell / p.sum())
    size = -gap.min() if load is None else np.ptp(gap[np.isfinite(gap)])
    gap = np.where(np.isfinite(gap), gap, 1e6 * np.ptp(gap[np.isfinite(gap)]))
    direction, before, change = np.zeros(shape), 0.0, None
    g = gap + act(p)
    for _ in range(STEPS):
        loaded = p > 0
        level = 0.0 if load is None or not loaded.any() else g[loaded].mean()
        g -= level
        wanted = loaded | (g < 0)
        if np.abs(g[wanted]).max() <= closed * size:
            return p, level
        z = np.where(wanted, irfft2(rfft2(np.where(wanted, g, 0.0)) * wave, shape), 0.0)
        if load is not None:
            z -= np.where(loaded, z[loaded].mean(), 0.0)
        now = (g * z).sum()
        # Polak and Ribiere: no negative share of the last direction.
        keep = 0.0 if change is None else max(0.0, (z * (g - change)).sum() / before)
        direction = np.where(wanted, z + keep * direction, 0.0)
        if (g * direction).sum() <= 0:
            direction = z
        change, before = g.copy(), now
        image = act(direction)
        if load is not None:
            image -= image[loaded].mean()
        step = (g * direction).sum() / (image * direction).sum()
        moved = np.maximum(0.0, p - step * direction)
        if load is not None:
            moved *= load / cell / moved.sum()
        if ((moved > 0) == loaded).all() and load is None:
            g = g - step * image
        else:
            g = gap + act(moved)
        p = moved
    raise Failed(f"gaps of {np.abs(g[wanted]).max() / size:.1e} are left after {STEPS} steps")


def area_of(p, sides):
    """Area of the elements under pressure without what their staircase adds, and its error."""
    inside = np.pad(p > 0, 1)
    edge = sum((inside.take(range(1, n), axis) != inside.take(range(n - 1), axis)).sum()
               for axis, n in enumerate(inside.shape))
    cell = sides[0] * sides[1]
    return cell * ((p > 0).sum() - RIM * edge), cell * RIM_ERROR * edge
