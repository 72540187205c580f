"""Judges interaction by dense scenes: runs the program, compares with the archived truth.

A scene is solved at its approach, where the vertical load is compared, and at the load that the
truth has there, where the approach is, as a share of the closing; the real area in both. A result
keeps its tolerance when it is within it and the truth's own error. `coupled` and `boundary` do not
know the tolerance: they run at the first one.
"""

import subprocess
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from csv_rows import records

TRUTH = Path(__file__).resolve().parents[2] / "reference_output" / "interaction" / "dense.csv"
TOLERANCES = (0.01, 0.003, 0.001)
CONTROLS = ("approach", "load")
# The area's tolerance is at least so much.
LEAST_AREA = 0.005


@cache
def truths():
    """Rows of the archived table by scene."""
    return {row["scene"]: row for row in records(TRUTH)}


@dataclass
class Result:
    """A run: errors are relative and signed; what is not known is not a number."""

    scene: str
    family: str
    mode: str
    tolerance: float
    control: str
    status: int = 0
    error: float = np.nan          # load at the approach, or approach over the closing at the load
    bound: float = 0.0             # of the truth
    estimate: float = np.nan
    area_error: float = np.nan
    area_bound: float = 0.0
    area_estimate: float = np.nan
    seconds: float = 0.0
    message: str = ""

    @property
    def missed(self):
        return not abs(self.error) <= self.tolerance + self.bound

    @property
    def area_missed(self):
        return not abs(self.area_error) <= max(self.tolerance, LEAST_AREA) + self.area_bound


def number(row, name):
    """A cell; not a number where the column or the value is missing."""
    return float(row.get(name) or "nan")


def run(exe, scene, mode, tolerance, control, timeout=300):
    """Solve a scene in one way."""
    truth = truths()[scene.name]
    assert truth["checksum"] == scene.checksum(), f"{scene.name}: the truth is of another scene"
    result = Result(scene.name, scene.family, mode, tolerance, control,
                    bound=float(truth["load_error"]), area_bound=float(truth["area_error"]))
    loading = None if control == "approach" else \
        {"control": "load", "value": float(truth["normal_load"])}
    with tempfile.TemporaryDirectory() as folder:
        path = scene.write(Path(folder), loading, interaction=mode, tolerance=tolerance)
        positions = path.with_name("positions.csv")
        start = time.perf_counter()
        try:
            done = subprocess.run([exe, "solve", path, "--positions", positions, "--quiet",
                                   "--threads", "1"], capture_output=True, text=True,
                                  timeout=timeout)
            result.status, result.message = done.returncode, done.stderr.strip()
        except subprocess.TimeoutExpired:
            result.status, result.message = -1, f"not done in {timeout} s"
        result.seconds = time.perf_counter() - start
        row = records(positions)[0] if positions.exists() else {}
    if not row or result.status != 0:
        return result
    if control == "approach":
        result.error = number(row, "vertical_load") / float(truth["load"]) - 1
    else:
        result.error = (scene.approach - number(row, "separation")) / float(truth["closing"])
    result.area_error = number(row, "area") / float(truth["area"]) - 1
    result.estimate = number(row, "error_estimate")
    result.area_estimate = number(row, "area_error_estimate")
    return result


def run_all(exe, scenes, modes=("auto",), tolerances=TOLERANCES, controls=CONTROLS, processes=2,
            timeout=300):
    """Every scene in every way, in order."""
    jobs = [(exe, scene, mode, tolerance, control, timeout)
            for mode in modes for tolerance in (tolerances if mode == "auto" else tolerances[:1])
            for control in controls for scene in scenes]
    with ThreadPoolExecutor(processes) as pool:
        return list(pool.map(lambda job: run(*job), jobs))


@dataclass
class Estimates:
    """How a column of estimates stands to the errors."""

    known: int
    below: float   # share of runs whose true error is above the estimate
    above: float   # share of runs whose estimate is more than ten times the true error

    @property
    def kept(self):
        return self.known > 0 and self.below <= 0.01 and self.above <= 0.1


def estimates(results, area=False):
    """An error below the truth's own bound counts as that bound."""
    rows = [(abs(r.area_error), r.area_bound, r.area_estimate) if area else
            (abs(r.error), r.bound, r.estimate) for r in results]
    error, bound, estimate = np.array(rows, float).reshape(-1, 3).T
    known = np.isfinite(error) & np.isfinite(estimate)
    error, bound, estimate = error[known], bound[known], estimate[known]
    if not known.any():
        return Estimates(0, np.nan, np.nan)
    # A truth that is off by its bound can make an error look larger, or smaller, by as much.
    return Estimates(int(known.sum()), float((estimate < error - bound).mean()),
                     float((estimate > 10 * np.maximum(error, bound)).mean()))
