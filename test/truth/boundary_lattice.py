"""The contacts of boundary_truth.py on squares with Love's coefficients, to check the others."""

import numpy as np

from boundary_patch import Failed


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
