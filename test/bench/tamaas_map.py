"""One solve by tamaas, run by the Python of its own venv: a map under a flat.

    python tamaas_map.py HEIGHTS.npy SPACING MODULUS PRESSURE TOLERANCE [periodic [THREADS]]

The edge is free, or periodic. Prints processor seconds of the solve, peak memory of the process
in bytes, the flat's level, seconds of the solve, and the largest distance of pixels under
pressure from the flat over the range of heights.
"""

import resource
import sys
import time

import numpy as np
import tamaas


def main():
    heights = np.load(sys.argv[1])
    spacing, modulus, pressure, tolerance = map(float, sys.argv[2:6])
    is_free = sys.argv[6:7] != ["periodic"]
    n = heights.shape
    sides = [spacing * m for m in n]
    tamaas.set_log_level(tamaas.LogLevel.error)
    tamaas.initialize(int(sys.argv[7]) if sys.argv[7:] else 1)
    begin, started = time.process_time(), time.perf_counter()
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, sides, list(n))
    model.E, model.nu = modulus, 0.0
    if is_free:
        tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")
    solver = tamaas.PolonskyKeerRey(model, heights, tolerance)
    if is_free:
        solver.setIntegralOperator("dcfft")
    solver.max_iter = 3000
    solver.solve(pressure)
    seconds, wall = time.process_time() - begin, time.perf_counter() - started
    displacement = np.array(model.displacement)
    if is_free:
        model.operators["dcfft"](model.traction, displacement)
    touching = model.traction > 0
    flat = (heights - displacement)[touching]
    print(seconds, 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, flat.mean(), wall,
          abs(flat - flat.mean()).max() / (heights.max() - heights.min()))


if __name__ == "__main__":
    main()
