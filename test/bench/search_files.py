"""What test/bench/scale_search.f90 reads and writes, shared by the benchmark and the test."""

import os
import subprocess
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
HUGE = float(np.finfo(float).max)


class Surface:
    """Places, summit levels and radii of asperities."""

    def __init__(self, x, y, height, radius):
        self.x, self.y, self.height, self.radius = (
            np.ascontiguousarray(np.broadcast_to(a, np.shape(x)), dtype=float)
            for a in (x, y, height, radius))

    def __len__(self):
        return len(self.x)


def write_input(path, upper, lower, *, height, everything=False, shift=(0.0, 0.0),
                unit=float(np.finfo(float).eps), floor=-HUGE):
    """`height` bounds pairs as in the thesis; `everything`: all whose spheres can touch; `unit`:
    the spacing at 1 of the arithmetic that will look at them again; `floor`: the least touch."""
    head = [len(upper), len(lower), height, everything, *shift, unit, floor]
    with open(path, "wb") as file:
        np.array(head, dtype=float).tofile(file)
        for surface in (upper, lower):
            for numbers in (surface.x, surface.y, surface.height, surface.radius):
                numbers.tofile(file)


def read_pairs(path):
    """Indices from 0 of the upper and of the lower asperities."""
    raw = np.fromfile(path, dtype=np.int32)
    return raw.reshape(2, len(raw) // 2).astype(np.int64) - 1


def run_search(program, source, target="-", runs=1):
    """Run the search; its figures by name: seconds of the best and the first run, or a count."""
    done = subprocess.run(
        [program, str(source), str(target), str(runs)], stdin=subprocess.DEVNULL,
        capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"scale_search: {done.stderr}")
    figures = {}
    for line in done.stdout.splitlines():
        name, *numbers = line.rsplit(None, 2 if "." in line else 1)
        values = [float(number) for number in numbers]
        figures[name.strip()] = values if len(values) > 1 else int(values[0])
    return figures


def search_program():
    """Path of the program: SCALE_SEARCH_EXE if that is set, else the release build by fpm."""
    given = os.environ.get("SCALE_SEARCH_EXE")
    if given:
        return Path(given).resolve()
    done = subprocess.run(["bash", ".ci/build", "release"], cwd=ROOT, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"the release build failed:\n{done.stdout}{done.stderr}")
    return Path(done.stdout.splitlines()[-1]).parent.parent / "example" / "scale_search"
