"""Judges interaction by dense scenes: runs the program, compares with the archived truth.

    python test/support/dense_judge.py EXECUTABLE [--modes auto,coupled,boundary]
        [--tolerances 0.01,0.003,0.001] [--controls approach,load] [--only NAME] [--every N]
        [--processes 2] [--timeout 300] [--worst 10] [--out results.csv]

A scene is solved at its approach, where the vertical load is compared, and at the load that the
truth has there, where the approach is, as a share of the closing; the real area in both. A result
keeps its tolerance when it is within it and the truth's own error. `coupled` and `boundary` do not
know the tolerance: they run at the first one.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from csv_rows import records, write_records
from dense_scenes import dense_scenes

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


def groups(results, *names):
    """Results that agree in these names, in order of appearance."""
    found = {}
    for result in results:
        found.setdefault(tuple(getattr(result, n) for n in names), []).append(result)
    return found


def line(rows):
    """Worst and root mean square of errors, misses, estimates and time of some results."""
    error = np.array([r.error for r in rows])
    area = np.array([r.area_error for r in rows])
    failed = sum(r.status != 0 for r in rows)

    def of(values):
        good = values[np.isfinite(values)]
        if not good.size:
            return f"{'-':>9} {'-':>8}"
        return f"{good[np.abs(good).argmax()]:>+9.1e} {np.sqrt((good ** 2).mean()):>8.1e}"

    def told(area):
        e = estimates(rows, area)
        return f"{100 * e.below:>5.1f} {100 * e.above:>6.1f}" if e.known else f"{'-':>5} {'-':>6}"

    return (f"{len(rows):>5} {failed:>6} {of(error)} {sum(r.missed for r in rows):>6} {of(area)} "
            f"{sum(r.area_missed for r in rows):>6} {told(False)} {told(True)} "
            f"{sum(r.seconds for r in rows):>7.1f} {max(r.seconds for r in rows):>6.2f}")


HEAD = (f"{'runs':>5} {'failed':>6} {'worst':>9} {'rms':>8} {'misses':>6} {'area':>9} {'rms':>8} "
        f"{'misses':>6} {'<err%':>5} {'>10x%':>6} {'<err%':>5} {'>10x%':>6} {'s':>7} {'most':>6}")


def table(results):
    """By mode, tolerance and control: every family, and all."""
    for (mode, tolerance, control), rows in groups(results, "mode", "tolerance",
                                                   "control").items():
        title = f"{mode} {tolerance:g} {control}" if mode == "auto" else f"{mode} {control}"
        yield ""
        yield f"{title:<22} {HEAD}"
        for (family,), part in groups(rows, "family").items():
            yield f"  {family:<20} {line(part)}"
        yield f"  {'all':<20} {line(rows)}"


def worst(results, count):
    """The results farthest beyond their tolerance, and failures before all."""
    def beyond(r):
        if not np.isfinite(r.error):
            return np.inf
        return max(abs(r.error) / (r.tolerance + r.bound),
                   abs(r.area_error) / (max(r.tolerance, LEAST_AREA) + r.area_bound))

    for (mode,), rows in groups(results, "mode").items():
        yield ""
        yield f"worst of {mode}: error over tolerance, load or approach, area, estimates"
        for r in sorted(rows, key=beyond, reverse=True)[:count]:
            yield (f"  {beyond(r):>7.2f}  {r.scene:<18} {r.tolerance:<6g} {r.control:<8} "
                   f"{r.error:>+9.2e} {r.area_error:>+9.2e} {r.estimate:>8.1e} "
                   f"{r.area_estimate:>8.1e}  {r.message[-70:]}")


def main():
    parser = argparse.ArgumentParser(description="Judges interaction by dense scenes.")
    parser.add_argument("exe")
    parser.add_argument("--modes", default="auto,coupled,boundary")
    parser.add_argument("--tolerances", default=",".join(map(str, TOLERANCES)))
    parser.add_argument("--controls", default=",".join(CONTROLS))
    parser.add_argument("--only", default="", help="scenes whose name has this in it")
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--timeout", type=float, default=300)
    parser.add_argument("--worst", type=int, default=10)
    parser.add_argument("--out")
    words = parser.parse_args()
    scenes = [s for s in dense_scenes() if words.only in s.name and s.name in truths()]
    results = run_all(Path(words.exe).resolve(), scenes[::words.every], words.modes.split(","),
                      tuple(map(float, words.tolerances.split(","))), words.controls.split(","),
                      words.processes, words.timeout)
    print("estimates: share below the true error, share above ten times it; of load or approach, "
          "then of area")
    for text in (*table(results), *worst(results, words.worst)):
        print(text)
    if words.out:
        write_records(words.out, results)
    automatic = [r for r in results if r.mode == "auto"]
    return int(any(r.missed or r.area_missed for r in automatic))


if __name__ == "__main__":
    sys.exit(main())
