"""One solve by tamaas, run by the Python of its own venv: caps on a grid, free boundary.

    python tamaas_solve.py CAPS.csv SAMPLES SIDE MODULUS LOAD TOLERANCE

Prints seconds of the solve, peak memory of the process in bytes and the closing past first touch.
"""

import csv
import resource
import sys
import time

import numpy as np
import tamaas

# More than these caps are pressed, and every touching point lies above that.
DEPTH = 0.12


def sampled(caps, n, side):
    """Highest cap, a paraboloid as Hertz' law takes it, at the middle of each of n by n cells; the
    lowest of these where none is near enough to touch."""
    cell = side / n
    heights = np.full((n, n), -np.inf)
    for x, y, top, radius in caps:
        reach = np.sqrt(2 * radius * DEPTH)
        i, j = (np.arange(max(0, int((v - reach) / cell)), min(n, int((v + reach) / cell) + 2))
                for v in (x, y))
        square = ((i + 0.5) * cell - x)[:, None] ** 2 + ((j + 0.5) * cell - y)[None] ** 2
        heights[np.ix_(i, j)] = np.maximum(heights[np.ix_(i, j)], top - square / (2 * radius))
    return np.where(np.isfinite(heights), heights, heights[np.isfinite(heights)].min())


def main():
    file, n, side, modulus, load, tolerance = sys.argv[1], int(sys.argv[2]), *map(float,
                                                                                 sys.argv[3:])
    with open(file, encoding="ascii", newline="") as rows:
        caps = [[float(row[c]) for c in ("x", "y", "height", "radius")]
                for row in csv.DictReader(rows)]
    tamaas.set_log_level(tamaas.LogLevel.error)
    tamaas.initialize(1)
    heights = sampled(caps, n, side)
    begin = time.perf_counter()
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [side, side], [n, n])
    model.E, model.nu = modulus, 0.0
    tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")
    solver = tamaas.PolonskyKeerRey(model, heights, tolerance)
    solver.setIntegralOperator("dcfft")
    solver.solve(load / side ** 2)
    seconds = time.perf_counter() - begin
    pressure, displacement = model.traction, np.zeros((n, n))
    model.operators["dcfft"](pressure, displacement)
    touching = pressure > 0
    closing = (displacement - heights)[touching].mean() + max(cap[2] for cap in caps)
    print(seconds, 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, closing)


if __name__ == "__main__":
    main()
