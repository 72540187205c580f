"""The judge: what a run of `asperity solve` found against what is true, with the doubt of both.

`ask` runs a scene, `ask_all` many of them side by side: answers. A truth makes figures of an answer:
a number that was found, the true one and its bound, what the run estimates of its error. `missed`
lists the figures beyond a tolerance, `estimates` how the estimates stand to the errors.
"""

import os
import subprocess
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from surfaces_csv import Solved, solve

# Many small files: in memory where there is room for them.
ROOM = "/dev/shm" if Path("/dev/shm").is_dir() else None


@dataclass
class Answer(Solved):
    """A run; status -1 where it did not end in time."""

    name: str = ""
    seconds: float = 0.0

    @property
    def message(self):
        return self.stderr.strip()


def ask(exe, write, *options, name="", timeout=300, **tables):
    """Write a scene to a folder of its own by `write(folder)`, and solve it in one thread."""
    with tempfile.TemporaryDirectory(dir=ROOM) as folder:
        scene, start = write(Path(folder)), time.perf_counter()
        try:
            ran = vars(solve(exe, scene, "--threads", "1", *options, timeout=timeout, **tables))
        except subprocess.TimeoutExpired:
            ran = dict(status=-1, stdout="", stderr=f"not done in {timeout} s", positions=[],
                       contacts=[], curve=[])
        return Answer(**ran, name=name, seconds=time.perf_counter() - start)


def ask_all(jobs):
    """Answers of calls without arguments, in order. Tests run side by side: each takes its share of
    the cores."""
    workers = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    with ThreadPoolExecutor(max(1, (os.cpu_count() or 1) // workers)) as pool:
        return list(pool.map(lambda job: job(), jobs))


@dataclass
class Figure:
    """A number of an answer; the error is relative and signed, over `scale` or the true value."""

    what: str
    found: float
    true: float
    bound: float = 0.0         # of the truth, relative
    estimate: float = np.nan   # of the run, relative
    scale: float = np.nan
    message: str = ""

    @property
    def error(self):
        return (self.found - self.true) / (self.true if np.isnan(self.scale) else self.scale)

    def within(self, tolerance):
        return abs(self.error) <= tolerance + self.bound

    def __str__(self):
        return f"{self.what} {self.error:+.1e} {self.message[-80:]}"


def missed(figures, tolerance):
    """How many are beyond a tolerance, and the first of them, for a message; else nothing."""
    beyond = [f for f in figures if not f.within(tolerance(f) if callable(tolerance) else tolerance)]
    return f"{len(beyond)}: " + "; ".join(map(str, beyond[:8])) if beyond else ""


def number(row, name):
    """A cell; not a number where the column or the value is missing."""
    return float(row.get(name) or "nan")


@dataclass
class Estimates:
    """How estimates stand to the errors."""

    known: int
    below: float   # share of figures whose true error is above the estimate
    above: float   # share of figures whose estimate is more than ten times the true error


def estimates(figures):
    """An error below the truth's own bound counts as that bound, by which the truth may be off."""
    rows = np.array([(abs(f.error), f.bound, f.estimate) for f in figures]).reshape(-1, 3)
    error, bound, estimate = rows[np.isfinite(rows).all(1)].T
    if not len(error):
        return Estimates(0, np.nan, np.nan)
    return Estimates(len(error), float((estimate < error - bound).mean()),
                     float((estimate > 10 * np.maximum(error, bound)).mean()))
