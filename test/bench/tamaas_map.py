"""One solve by tamaas, run by the Python of its own venv: a map under a flat, free boundary.

    python tamaas_map.py HEIGHTS.npy SPACING MODULUS PRESSURE TOLERANCE

Prints processor seconds of the solve, peak memory of the process in bytes and the flat's level.
"""

import resource
import sys
import time

import numpy as np
import tamaas


def main():
    heights = np.load(sys.argv[1])
    spacing, modulus, pressure, tolerance = map(float, sys.argv[2:])
    n = heights.shape
    sides = [spacing * m for m in n]
    tamaas.set_log_level(tamaas.LogLevel.error)
    tamaas.initialize(1)
    begin = time.process_time()
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, sides, list(n))
    model.E, model.nu = modulus, 0.0
    tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")
    solver = tamaas.PolonskyKeerRey(model, heights, tolerance)
    solver.setIntegralOperator("dcfft")
    solver.max_iter = 3000
    solver.solve(pressure)
    seconds = time.process_time() - begin
    displacement = np.zeros(n)
    model.operators["dcfft"](model.traction, displacement)
    touching = model.traction > 0
    print(seconds, 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
          (heights - displacement)[touching].mean())


if __name__ == "__main__":
    main()
