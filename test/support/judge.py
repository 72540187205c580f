"""The judge: what a run of `asperity solve` found against what is true, with the errors of both.

`ask` runs a scene, `ask_all` many of them side by side: answers. `has_result` states whether an
answer is a result or a refusal, and raises where it is neither. A truth makes figures of an answer:
a number that was found, the true one and its bound, the estimate of the run. `is_met` defines when
a figure is right; `missed` lists the others, `check` and `compare` raise for them, and `estimates`
compares estimates with errors.
"""

import os
import re
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
# Columns of words; no other text than a number stands in the other columns.
WORDS = ("interaction", "friction", "plasticity", "adhesion", "creep")
NO_NUMBER = re.compile(r"\b(nan|inf|infinity)\b|\*\*\*", re.IGNORECASE)


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
                       contacts=[], curve=[], scene=scene)
        return Answer(**ran, name=name, seconds=time.perf_counter() - start)


def ask_all(jobs):
    """Answers of calls without arguments, in order. Tests run side by side: each takes its share of
    the cores."""
    workers = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    with ThreadPoolExecutor(max(1, (os.cpu_count() or 1) // workers)) as pool:
        return list(pool.map(lambda job: job(), jobs))


def solved(exe, scene, *options, **wanted):
    """A run that must have results, with all its tables."""
    run = solve(exe, scene, *options, **{"curve": True, **wanted})
    assert run.status == 0, run.stderr
    return run


def has_result(answer, refusals=(1,)):
    """Whether a run has results, which are finite numbers. Otherwise it is a refusal: one of these
    exit statuses, no output, and one message of the scene beside the notes."""
    rows = [*answer.positions, *answer.contacts, *answer.curve]
    if answer.status == 0:
        assert answer.positions and "model: " in answer.stdout, answer.stdout
        printed = answer.stdout.replace(str(answer.scene), "")
        assert not NO_NUMBER.search(printed), printed
        for row in rows:
            assert all(name in WORDS or abs(float(cell or 0)) < np.inf
                       for name, cell in row.items()), row
        return True
    assert answer.status in refusals, f"status {answer.status}: {answer.stderr[-300:]}"
    assert answer.stdout == "" and not rows
    said = [line for line in answer.stderr.splitlines() if ": note: " not in line]
    assert len(said) == 1 and re.match(rf"{re.escape(str(answer.scene))}:.{{10}}", said[0]), \
        answer.stderr
    return False


def is_met(error, tolerance, bound=0.0):
    """Whether an error is within the tolerance and the bound of the truth; false for NaN."""
    return np.abs(error) <= tolerance + bound


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
        size = self.true if np.isnan(self.scale) else self.scale
        difference = self.found - self.true
        return difference / size if size else np.inf * difference if difference else 0.0

    def within(self, tolerance):
        return bool(is_met(self.error, tolerance, self.bound))

    def __str__(self):
        return f"{self.what} {self.found!r} for {self.true!r}, {self.error:+.1e} " \
               f"{self.message[-80:]}"


def missed(figures, tolerance):
    """How many are beyond a tolerance, and the first of them, for a message; else nothing."""
    beyond = [figure for figure in figures
              if not figure.within(tolerance(figure) if callable(tolerance) else tolerance)]
    return f"{len(beyond)}: " + "; ".join(map(str, beyond[:8])) if beyond else ""


def check(what, found, true, tolerance, bound=0.0, scale=np.nan):
    """A figure that must be right."""
    wrong = missed([Figure(what, found, true, bound, scale=scale)], tolerance)
    assert not wrong, wrong


def compare(name, errors, tolerance):
    """Errors that must be within a tolerance, or each within its own. Prints the worst."""
    errors = np.atleast_1d(np.asarray(errors, float))
    assert errors.size, f"{name}: nothing compared"
    tolerance = np.broadcast_to(tolerance, errors.shape)
    worst = int(np.argmax(np.abs(errors) - tolerance))
    text = (f"{name}: {errors.size} compared, worst {errors[worst]:.2e} (number {worst + 1}), "
            f"allowed {tolerance[worst]:.2g}")
    print(text)
    assert is_met(errors, tolerance).all(), text


def column(rows, name):
    """A column as numbers; not a number where a cell is empty."""
    return np.array([float(row[name] or "nan") for row in rows])


def relative(found, true):
    """Relative errors; the truth may have many digits. Where it is 0, the numbers found."""
    return np.array([abs(float((f - t) / t)) if t else abs(float(f))
                     for f, t in zip(found, true, strict=True)])


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
