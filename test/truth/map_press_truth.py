"""A map of heights under a rigid flat: the truth for a map in a scene, by elements_truth.py."""

import numpy as np

from elements_truth import press as press_gap
from elements_truth import product


def press(height, sides, modulus, load, periodic=False, closed=1e-10):
    """Level of the flat, pressures; nan is no pixel. Gaps are closed to `closed` of the range."""
    gap = np.where(np.isnan(height), np.inf, np.nanmax(height) - height)
    act = product(height.shape, sides, modulus, periodic)
    p, level = press_gap(gap, act, sides, load, closed=closed)
    return np.nanmax(height) - level, p


def rough(n, m=None, hurst=0.8, longest=0.25, shortest=8, stretched=1.0, seed=1):
    """A random self-affine surface of rms height 1: spectrum between two wavelengths, in parts of
    the side and in pixels."""
    m = m or n
    random = np.random.default_rng(seed)
    q = np.hypot(np.fft.fftfreq(n, 1 / n)[:, None], np.fft.fftfreq(m, 1 / n)[None, :] * stretched)
    with np.errstate(divide="ignore"):
        size = np.where((q >= 1 / longest) & (q <= n / shortest), q ** -(1 + hurst), 0.0)
    height = np.fft.ifft2(size * np.exp(2j * np.pi * random.random((n, m)))).real
    return height / height.std()


def first_contact(height, periodic=False):
    """Top of the surface between the pixels: the highest vertex within one pixel of
    the quadratics by central differences of nine pixels, at local maxima within half an rms height
    of the highest. Without such a vertex, and at other pixels, those of parabolas along x and y."""
    top = np.nanmax(height)
    least = top - np.nanstd(height) / 2
    near = np.pad(height, 1, mode="wrap") if periodic else np.pad(height, 1, constant_values=np.nan)
    for i, j in np.argwhere(height >= least):
        z = near[i:i + 3, j:j + 3]
        if np.isnan(z).any():
            continue
        slope = np.array([z[2, 1] - z[0, 1], z[1, 2] - z[1, 0]]) / 2
        twist = (z[2, 2] - z[0, 2] - z[2, 0] + z[0, 0]) / 4
        bend = np.array([[z[2, 1] - 2 * z[1, 1] + z[0, 1], twist],
                         [twist, z[1, 2] - 2 * z[1, 1] + z[1, 0]]])
        if (z <= z[1, 1]).all() and np.linalg.eigvalsh(bend).max() < 0:
            place = -np.linalg.solve(bend, slope)
            if abs(place).max() <= 1:
                top = max(top, z[1, 1] + slope @ place / 2)
                continue
        for line, s, b in zip((z[:, 1], z[1]), slope, np.diag(bend)):
            if line.max() == z[1, 1] and np.ptp(line) > 0:
                top = max(top, z[1, 1] - s**2 / (2 * b))
    return top
