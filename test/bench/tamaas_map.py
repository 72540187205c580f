"""One solve by tamaas, run by the Python of its own venv: a map under a flat.

    python tamaas_map.py HEIGHTS.npy SPACING MODULUS PRESSURE[,...] TOLERANCE [periodic [THREADS]]

The edge is free, or periodic. Each pressure is solved from the one before. Prints peak memory of
the process in bytes, the flat's last level, seconds of the solves, and the largest distance of
pixels under pressure from the flat over the range of heights.
"""

import resource
import sys
import time

import numpy as np
import tamaas


def main():
    heights = np.load(sys.argv[1])
    spacing, modulus, tolerance = (float(sys.argv[i]) for i in (2, 3, 5))
    pressures = [float(word) for word in sys.argv[4].split(",")]
    is_free = sys.argv[6:7] != ["periodic"]
    n = heights.shape
    sides = [spacing * m for m in n]
    tamaas.set_log_level(tamaas.LogLevel.error)
    tamaas.initialize(int(sys.argv[7]) if sys.argv[7:] else 1)
    seconds = residual = 0
    begin = time.perf_counter()
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, sides, list(n))
    model.E, model.nu = modulus, 0.0
    if is_free:
        tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")
    solver = tamaas.PolonskyKeerRey(model, heights, tolerance)
    if is_free:
        solver.setIntegralOperator("dcfft")
    solver.max_iter = 3000
    for pressure in pressures:
        solver.solve(pressure)
        seconds += time.perf_counter() - begin
        displacement = np.array(model.displacement)
        if is_free:
            model.operators["dcfft"](model.traction, displacement)
        flat = (heights - displacement)[model.traction > 0]
        residual = max(residual, abs(flat - flat.mean()).max() / np.ptp(heights))
        begin = time.perf_counter()
    print(1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, flat.mean(), seconds, residual)


if __name__ == "__main__":
    main()
