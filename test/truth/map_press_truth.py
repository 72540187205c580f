"""A map of heights under a rigid flat, in numpy: the truth for a map in a scene.

Written apart from the program. Pressures are uniform on the sample's rectangle, displacements are
taken at the samples: Love's (1929) on a half-space that goes on without load, or waves on one that
repeats itself. The method is that of Polonsky and Keer (1999): conjugate gradients under a load.
"""

import numpy as np

STEPS = 3000


def love(x, y, a, b):
    """Integral of 1/r over a rectangle of sides a and b at a distance (x, y) from its centre."""
    def part(u, v):
        return u * np.arcsinh(v / np.abs(u)) + v * np.arcsinh(u / np.abs(v))

    return (part(x + a / 2, y + b / 2) - part(x - a / 2, y + b / 2)
            - part(x + a / 2, y - b / 2) + part(x - a / 2, y - b / 2))


def product(shape, sides, periodic):
    """Displacements times the modulus, of pressures on a map."""
    n, m = shape
    a, b = sides
    if periodic:
        wave = 2 * np.pi * np.hypot(*np.meshgrid(np.fft.fftfreq(n, a), np.fft.rfftfreq(m, b),
                                                 indexing="ij"))
        with np.errstate(divide="ignore"):
            transform = np.where(wave > 0, 2 / wave, 0.0)
        return lambda p: np.fft.irfft2(np.fft.rfft2(p) * transform, shape)
    x = np.fft.fftfreq(2 * n, 1 / (2 * n)) * a
    y = np.fft.fftfreq(2 * m, 1 / (2 * m)) * b
    transform = np.fft.rfft2(love(x[:, None], y[None, :], a, b)) / np.pi

    def displacements(p):
        return np.fft.irfft2(np.fft.rfft2(p, (2 * n, 2 * m)) * transform, (2 * n, 2 * m))[:n, :m]

    return displacements


def press(height, sides, modulus, load, periodic=False, closed=1e-10):
    """Level of the flat, pressures; nan is no sample. Gaps are closed to `closed` of the range."""
    there = ~np.isnan(height)
    gap = np.where(there, np.nanmax(height) - height, 1e6 * np.ptp(height[there]))
    act = product(height.shape, sides, periodic)
    total = load / (sides[0] * sides[1])
    p = there * total / there.sum()
    direction = np.zeros_like(p)
    before, fresh = 1.0, True
    for _ in range(STEPS):
        g = act(p) / modulus + gap
        loaded = p > 0
        level = g[loaded].mean()
        g -= level
        off = max(np.abs(g[loaded]).max(), -g.min()) / np.ptp(height[there])
        if off < closed:
            return np.nanmax(height) - level, p
        now = (g[loaded] ** 2).sum()
        direction = np.where(loaded, g + (0.0 if fresh else now / before) * direction, 0.0)
        before = now
        change = act(direction) / modulus
        change -= change[loaded].mean()
        step = (g * direction)[loaded].sum() / (change * direction)[loaded].sum()
        p = np.maximum(0.0, np.where(loaded, p - step * direction, p))
        taken = ~loaded & (g < 0) & there
        p[taken] = -step * g[taken]
        fresh = taken.any()
        p *= total / p.sum()
    raise RuntimeError(f"not closed after {STEPS} steps: {off:.1e}")


def rough(n, m=None, hurst=0.8, longest=0.25, shortest=8, stretched=1.0, seed=1):
    """A random self-affine surface of rms height 1: spectrum between two wavelengths, in parts of
    the side and in samples."""
    m = m or n
    random = np.random.default_rng(seed)
    q = np.hypot(np.fft.fftfreq(n, 1 / n)[:, None], np.fft.fftfreq(m, 1 / n)[None, :] * stretched)
    with np.errstate(divide="ignore"):
        size = np.where((q >= 1 / longest) & (q <= n / shortest), q ** -(1 + hurst), 0.0)
    height = np.fft.ifft2(size * np.exp(2j * np.pi * random.random((n, m)))).real
    return height / height.std()
