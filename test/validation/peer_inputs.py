"""Inputs of the comparisons with programs that were run; numpy is all that they need.

Heights are sums of cosines of whole waves with the phases of the golden ratio, so that every
machine has the same ones.
"""

import math

import numpy as np

GOLDEN = (math.sqrt(5) - 1) / 2
MODULUS = 100.0
# Name, rows, columns, spacing in y and x, whether periodic, and the mean pressures.
MAPS = (("rough", 64, 64, 1.0, 1.0, True, (0.05, 0.4, 1.5, 4.0)),
        ("fine", 128, 128, 0.5, 0.5, True, (0.1, 0.8, 2.5)),
        ("oblong", 48, 96, 1.0, 0.5, True, (0.1, 0.8, 3.0)),
        ("free", 64, 64, 1.0, 1.0, False, (0.05, 0.4, 1.5)),
        ("ball", 64, 64, 0.25, 0.25, False, (0.05, 0.4, 1.5)))
# Hardness of the maps in ContactMechanics.
HARDNESS = 6.0
# Pixels whose pressure is compared, by their rank in height.
RANKS = (0, 7, 20)


def heights_of(name):
    rows, columns, dy, dx = next(item[1:5] for item in MAPS if item[0] == name)
    y, x = np.arange(rows)[:, None], np.arange(columns)[None, :]
    if name == "ball":
        square = ((x - columns // 2) * dx)**2 + ((y - rows // 2) * dy)**2
        return -square / 60.0 + 0.02 * np.cos(square)
    heights = np.zeros((rows, columns))
    number = 0
    for k_x in range(0, 9):
        for k_y in range(-8, 9):
            if (k_x, k_y) <= (0, 0) or k_x * k_x + k_y * k_y > 64:
                continue
            number += 1
            phase = 2 * math.pi * (number * GOLDEN % 1.0)
            wave = 2 * math.pi * (k_x * x / columns + k_y * y / rows) + phase
            heights += 0.4 * (k_x * k_x + k_y * k_y)**-0.9 * np.cos(wave)
    return heights - heights.mean()


def measured(heights, pressure, gap, energy=None):
    """What is compared of a solution: name and number."""
    ranked = np.argsort(-heights, axis=None, kind="stable")
    inside = pressure > 0
    numbers = {"pixels in contact": inside.sum(), "greatest pressure": pressure.max(),
               "rms pressure": math.sqrt((pressure**2).mean()),
               "mean gap": gap.mean()}
    if energy is not None:
        numbers["elastic energy"] = energy
    for rank in RANKS:
        numbers[f"pressure at pixel {rank + 1} in height"] = pressure.ravel()[ranked[rank]]
    return numbers


# Radii, Young's modulus, Poisson's ratio, energy of a surface and overlap of pairs of spheres.
def pairs():
    for radii in ((1.0, 1.0), (1.0, 3.0), (0.2, 5.0)):
        for young, ratio in ((1e5, 0.3), (2e3, 0.45)):
            for share in (1e-4, 1e-3, 5e-3):
                yield radii, young, ratio, share * min(radii)
