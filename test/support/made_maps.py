"""Height maps made for tests: random self-affine surfaces of given spectrum and seed, and what is
archived of them.

    python test/support/made_maps.py        writes the maps of data/examples/summits anew

A surface is periodic over twice its side and a quarter of that is cut out, so its edges are like
those of a measured map.
"""

from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parents[2] / "data/examples/summits"


def spectrum(k, hurst, longest, shortest):
    """Power at wave numbers k (cycles a pixel): flat up to 1/longest, then a power law, nothing
    beyond 1/shortest."""
    with np.errstate(divide="ignore"):
        return np.where((k > 0) & (k <= 1 / shortest),
                        np.maximum(k, 1 / longest) ** (-2 - 2 * hurst), 0.0)


def self_affine(shape, seed, hurst=0.8, longest=None, shortest=8.0, stretch=1.0, periodic=False):
    """Gaussian heights of rms 1 (in expectation), rows by columns; `stretch` makes waves along a
    row longer. Also the exact moments m0, m2, m4 along x of the spectrum, a pixel apart."""
    rows, columns = shape if periodic else (2 * shape[0], 2 * shape[1])
    longest = longest or min(shape) / 4
    ky = np.fft.fftfreq(rows)[:, None]
    kx = np.fft.fftfreq(columns)[None, :]
    power = spectrum(np.hypot(kx * stretch, ky), hurst, longest, shortest)
    power /= power.sum()
    noise = np.random.default_rng(seed).normal(size=(rows, columns))
    heights = np.fft.ifft2(np.fft.fft2(noise) * np.sqrt(power * rows * columns)).real
    moments = tuple(float(((2 * np.pi * kx) ** n * power).sum()) for n in (0, 2, 4))
    return heights[:shape[0], :shape[1]], moments


def write_bytes(path, heights, dx=1.0, dy=1.0):
    """The heights, all bits of them, as binary ISO-1.0 of type BINARY64; NaN for a missing one."""
    rows, columns = heights.shape
    head = b"bISO-1.0by hand   000000000000000000000000"
    counts = columns.to_bytes(2, "little") + rows.to_bytes(2, "little")
    scales = np.array([dx, dy, 1.0, -1.0], "<f8").tobytes()
    path.write_bytes(head + counts + scales + bytes([0, 7, 0]) + heights.astype("<f8").tobytes())
    return path


def archived():
    """The maps of the folder by name: heights in metres, and pixels' distance."""
    smooth, _ = self_affine((96, 128), 15, shortest=8)
    rough, _ = self_affine((64, 64), 16, hurst=0.5, shortest=2, stretch=2.0)
    rough[20:24, 40:45] = np.nan
    return {"smooth.sdf": (1e-7 * smooth, 1e-6), "rough.sdf": (2e-8 * rough, 5e-7)}
