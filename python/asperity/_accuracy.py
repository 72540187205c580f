"""Run time and errors of each method that applies to a scene."""

from __future__ import annotations

import csv
import html
import io
import math
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

from . import _arguments as _a
from . import _library as _c
from ._columns import Axes, Lazy, Table, column
from ._maps import HeightMap
from ._plots import new_axes, picture_html
from ._scenes import Scene

numpy: Any = Lazy("numpy", "numpy", "accuracy")
WORDS = ("family", "method", "arithmetic", "overlap", "typed", "left_out")


class Accuracy:
    """Run times and errors of the methods of a scene; `print` shows them, and what to type.

    Attributes:
        table: A row for each method, with the columns of `asperity accuracy --csv`.
        reference: The method with which the others are compared.
        answers: For each of the goals the fastest row with this error of the load; None: no such.
        digits: Greatest change of load, area or separation when the heights change by half of their
            last digit; None where it is unknown.
    """

    def __init__(self, table: Table, text: str, digits: float | None, goals: Sequence[float]):
        self.table, self._text, self.digits = table, text, digits
        best = next(row for row in table.rows() if row["reference"])
        self.reference: str = best["method"]
        self._own = {name: max(0.0, best[title]) if best[title] == best[title] else 0.0
                     for name, title in (("load", "error_estimate"),
                                         ("area", "area_error_estimate"))}
        self.answers = {goal: self.answer(goal) for goal in goals}

    def error(self, row: Mapping[str, Any], of: str = "load") -> float:
        """The error of a row of the table: of `load` (under load control, of the compression) or
        of `area`. It is at least the estimated error of the reference."""
        if of not in self._own:
            raise _a.wrong("of", repr(of), ", ".join(map(repr, self._own)))
        return max(self._own[of], float(row["error_max" if of == "load" else "area_error_max"]))

    def answer(self, goal: float, of: str = "load") -> dict[str, Any] | None:
        """The fastest row that can be typed with an error of at most `goal`; None: no such."""
        return min((row for row in self.table.rows() if row["typed"] and row["seconds"] > 0
                    and self.error(row, of) <= goal), key=lambda row: float(row["seconds"]),
                   default=None)

    def __str__(self) -> str:
        band = f"\nHalf of the last digit of the heights: {self.digits or 0.0:.1g}."
        return self._text + band * (self.digits is not None)

    def __repr__(self) -> str:
        return f"<asperity.Accuracy of {len(self.table)} methods>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>" + picture_html(self.plot)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the errors of load and area against the run time, with a number for each method.
        Open markers are bounds by the reference, a line connects the Pareto front; errors in the
        grey band are below the digits of the heights. Numbers of like points are stacked."""
        axes: Axes = new_axes(ax, size=(9.0, 4.5))
        rows = sorted((row for row in self.table.rows() if row["seconds"] > 0),
                      key=lambda row: float(row["seconds"]))
        for number, (of, own) in enumerate(self._own.items()):
            errors = [self.error(row, of) for row in rows]
            for row, error in zip(rows, errors):
                if error > 0:
                    axes.plot(row["seconds"], error, "os"[number], color=f"C{number}",
                              mfc="white" if error <= own else None)
            axes.plot([], [], "os"[number], color=f"C{number}", label=of)
        front = [(row["seconds"], self.error(row)) for row in rows if row["front"]]
        axes.plot(*zip(*front) if front else ([], []), color="C0", lw=0.8, zorder=0)
        axes.set(xscale="log", yscale="log", xlabel="time (s)", ylabel="relative error")
        low, high = axes.get_ylim()
        if self.digits:
            axes.axhspan(min(low, self.digits) / 10, self.digits, color="0.92", zorder=0)
        axes.set_ylim(low, high)
        numbers: dict[tuple[float, float], list[str]] = {}
        for number, row in enumerate(rows, 1):
            if (error := self.error(row)) > 0:
                near = next((place for place in numbers if row["seconds"] < 1.2 * place[0]
                             and 0.8 < error / place[1] < 1.25), (row["seconds"], error))
                numbers.setdefault(near, []).append(str(number))
        for near, words in numbers.items():
            axes.annotate("\n".join(words), near, (3, 3), textcoords="offset points", fontsize=7)
        axes.text(1.03, 1.0, "\n".join(f"{number}  {row['method']}, {row['seconds']:.2g} s"
                                       for number, row in enumerate(rows, 1)),
                  va="top", fontsize="x-small", transform=axes.transAxes)
        axes.legend(fontsize="small")
        return axes


def accuracy(scene: Any, *, seconds: float = 60.0, finer: bool = False,
             goals: Sequence[float] = (0.1, 0.01, 0.001)) -> Accuracy:
    """Solve a scene by each method that applies: run times and errors, those of the command
    `asperity accuracy`. A card deck has the arithmetics and steps of the original program too.

    Args:
        scene: As for `solve`.
        seconds: Time limit; slower methods are left out.
        finer: Solve a height map on pixels half as wide too, and compare with them.
        goals: Relative errors for `answers`.

    Examples:
        >>> asperity.accuracy("data/examples/csv_surfaces.scene").answers[0.01]["typed"]
        "interaction = 'off'"
    """
    given = scene if isinstance(scene, Scene) else Scene(scene)
    outcome = _c.call("study_scene", given._read, _a.number("seconds", seconds),
                      1 + _a.flag("finer", finer)).checked()
    rows = list(csv.DictReader(io.StringIO(outcome.text(_c.METHODS))))
    table = Table({name: column([row[name].replace(";", ",") for row in rows] if name in WORDS else
                                numpy.array([float(row[name] or math.nan) for row in rows]))
                   for name in rows[0]}, {"seconds": "s"}, "methods")
    return Accuracy(table, outcome.text(_c.REPORT).rstrip("\n"), _digits(given), goals)


def _digits(given: Scene) -> float | None:
    """Greatest change of a total when all heights change by half of their last digit."""
    given = given.with_arrays()
    source = given._source if isinstance(given._source, Mapping) else {}
    arrays = {side: value for side, value in dict(source.get("surfaces", {})).items()
              if side in ("upper", "lower") and isinstance(value, (HeightMap, Mapping))}
    found = None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for seed in (1, 2) if arrays else ():
            one = given.solve().positions
            other = Scene({**source, "surfaces": {**source["surfaces"], **{
                side: _with_half_digit(value, seed) for side, value in arrays.items()}}}
                ).solve().positions
            found = max(found or 0.0, *(
                float(numpy.nanmax(abs(other[name] - one[name]) / abs(one[whole]), initial=0.0))
                for name, whole in (("load", "load"), ("area", "area"),
                                    ("separation", "compression"))))
    return found


def _with_half_digit(surface: Any, seed: int) -> Any:
    """A surface with each height changed by half of the last digit, up or down at random: of a map
    of the least step between its heights, of asperities of the last decimal that is written."""
    is_map = isinstance(surface, HeightMap)
    heights = numpy.array(surface.heights if is_map else surface["height"], float)
    values = numpy.unique(heights[numpy.isfinite(heights)])
    half = 0.5 * (numpy.diff(values).min(initial=math.inf) if is_map else 10.0**-max(
        len(repr(float(value)).partition(".")[2]) for value in values))
    sign = numpy.random.default_rng(seed).choice((-1.0, 1.0), heights.shape)
    heights += half * sign if math.isfinite(half) else 0.0
    return HeightMap(heights, surface.spacing, surface.unit, surface.periodic) if is_map else {
        **{name: surface[name] for name in surface}, "height": heights}
