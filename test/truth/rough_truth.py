"""Rough caps under a plane by pressures on grids: the truth for dense scenes that are not shallow.

    python test/truth/rough_truth.py reference_output/interaction/rough.csv

Bodies are paraboloids of the caps' radius, those of Hertz' law; `spheres` is the load of spheres.
Loads and compressions converge as the square of the side, areas as its power 1.5: the last two of
the grids are extrapolated, and the error is what that adds to the last one.
"""

import csv
import sys
from pathlib import Path

import numpy as np

from dense_scenes import rough_scenes
from elements_truth import area_of, press, product

MODULUS, RATIO = 275760.0, 0.42
COMBINED = MODULUS / (2 * (1 - RATIO ** 2))
# Elements a side, of 60 caps and of 2000.
GRIDS = ((128, 256, 512, 1024), (256, 512, 1024, 2048))


def gap_of(caps, compression, count, spheres=False):
    """Gap on a square lattice of `count` rows, past first touch by the compression; its side."""
    x, y, height, radius = np.array(caps).T
    depth = compression - height.max() + height
    reach = np.sqrt(2 * radius * np.maximum(depth, 0.0))
    low = np.array([(v - reach)[depth > 0].min() for v in (x, y)])
    side = 1.01 * max((v + reach)[depth > 0].max() - at for v, at in zip((x, y), low)) / count
    gap = np.full((count, count), np.inf)
    axes = [at + side * (np.arange(count) + 0.5 - 0.005 * count) for at in low]
    for cap in np.flatnonzero(depth > 0):
        at = [np.searchsorted(axis, (v - reach[cap], v + reach[cap]))
              for axis, v in zip(axes, (x[cap], y[cap]))]
        here = tuple(slice(*v) for v in at)
        square = (axes[0][here[0], None] - x[cap]) ** 2 + (axes[1][here[1]] - y[cap]) ** 2
        drop = square / (radius[cap] + np.sqrt(np.maximum(radius[cap] ** 2 - square, 0.0))) \
            if spheres else square / (2 * radius[cap])
        gap[here] = np.minimum(gap[here], drop - depth[cap])
    return gap, side


def solved(scene, counts, spheres=False):
    """Load, or under a load the compression, and area: limits of grids, and relative errors."""
    found, p = [], None
    for count in counts:
        gap, side = gap_of(scene.caps(), scene.compression, count, spheres)
        if p is not None:
            p = np.kron(p, np.ones((2, 2)))
        p, level = press(gap, product(gap.shape, (side, side), COMBINED), (side, side),
                         scene.load, p)
        area, rim = area_of(p, (side, side))
        found.append((scene.compression + level if scene.load else p.sum() * side ** 2, area))
    step, area_step = np.subtract(found[-1], found[-2]) / (2 ** 2 - 1, 2 ** 1.5 - 1)
    value, area = np.add(found[-1], (step, area_step))
    return value, abs(step / value), area, (abs(area_step) + rim) / area


def row_of(scene):
    """A row of the table."""
    counts = GRIDS[scene.number > 100]
    value, error, area, area_error = solved(scene, counts)
    given = scene.compression if scene.load is None else scene.load
    pair = (given, value) if scene.load is None else (value, given)
    return {"scene": scene.name, "compression": f"{pair[0]:.9g}", "load": f"{pair[1]:.9g}",
            "error": f"{error:.1e}", "area": f"{area:.6g}", "area_error": f"{area_error:.1e}",
            "spheres": "" if scene.load else f"{solved(scene, counts, True)[0]:.9g}"}


def main(path):
    with open(path, "w", encoding="ascii", newline="") as file:
        for scene in rough_scenes():
            row = row_of(scene)
            if file.tell() == 0:
                csv.writer(file, lineterminator="\n").writerow(row)
            csv.writer(file, lineterminator="\n").writerow(row.values())
            file.flush()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
