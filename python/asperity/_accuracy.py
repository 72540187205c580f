"""Run time and errors of each method that applies to a scene."""

from __future__ import annotations

import csv
import html
import io
import math
import os
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from . import _arguments as _a
from . import _library as _c
from ._columns import Axes, Lazy, Table, column
from ._maps import HeightMap
from ._plots import new_axes, picture_html
from ._results import SIDES
from ._scenes import Scene

numpy: Any = Lazy("numpy", "numpy", "accuracy")
WORDS = ("family", "method", "arithmetic", "overlap", "typed", "left_out")
# Quantities: what begins their columns `error_max` and `error_estimate`, and the quantity whose
# estimate stands for theirs where a method has none.
QUANTITIES = {"load": ("", "", ""), "area": ("area_", "area_", ""),
              "separation": ("separation_", "separation_", "load"),
              "greatest_pressure": ("greatest_pressure_", "pressure_", "area")}
# The card of an asperity: x and y, height with its decimals, which leave room for one more.
CARD = r"(?m)^([-\d. ]{12})( *\d?\.(\d{1,4}))(?=\s*$)"
# Chosen: errors above this share of another are no smaller; a load below this error is prescribed;
# numbers of methods that are closer than this share of the axis stand in one place.
SMALLER, PRESCRIBED, NEAR = 0.9, 1e-9, 0.04


class Accuracy:
    """Run times and errors of the methods of a scene; `print` shows them, and what to type.

    Attributes:
        table: A row for each method, with the columns of `asperity accuracy --csv`.
        reference: The method with which the others are compared.
        answers: For each of the goals the fastest row with this error of the load; None: no such.
        digits: Greatest change of a total by half of the last digit of the heights; None: unknown.
    """

    def __init__(self, table: Table, text: str, digits: float | None, goals: Sequence[float]):
        self.table, self._text, self.digits = table, text, digits
        best = next(row for row in table.rows() if row["reference"])
        self.reference: str = best["method"]
        self._own: dict[str, float] = {}
        for of, (_, start, other) in QUANTITIES.items():
            estimate = best[f"{start}error_estimate"]
            self._own[of] = self._own.get(other, 0.0) if math.isnan(estimate) else max(0, estimate)
        self.answers = {goal: self.answer(goal) for goal in goals}

    def error(self, row: Mapping[str, Any], of: str = "load") -> float:
        """The error of a row of the table: of `load` (under load control, of the compression),
        `area`, `separation` or `greatest_pressure`; at least that of the reference."""
        if of not in QUANTITIES:
            raise _a.wrong("of", repr(of), ", ".join(map(repr, QUANTITIES)))
        return max(self._own[of], float(row[f"{QUANTITIES[of][0]}error_max"]))

    def answer(self, goal: float, of: str = "load") -> dict[str, Any] | None:
        """The fastest row that can be typed with an error of at most `goal`; None: no such."""
        return next((row for row in self._fastest_first() if row["typed"]
                     and self.error(row, of) <= goal), None)

    def _fastest_first(self) -> list[dict[str, Any]]:
        """The rows of methods that were run."""
        return sorted((row for row in self.table.rows() if row["seconds"] > 0),
                      key=lambda row: float(row["seconds"]))

    def __str__(self) -> str:
        band = f"\nHalf of the last digit of the heights: {self.digits or 0.0:.1g}."
        return self._text + band * (self.digits is not None)

    def __repr__(self) -> str:
        return f"<asperity.Accuracy of {len(self.table)} methods>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>" + picture_html(self.plot)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the errors against the run time, a curve a quantity through the methods with the
        least error in their time. Each has a vertical line with a number, and below what to type.
        Dots: other methods; open: bounds; dotted: goals; grey: digits of the heights."""
        axes: Axes = new_axes(ax, size=(6.0, 5.5))
        axes.set(xscale="log", yscale="log")
        axes.tick_params("x", which="minor", labelbottom=False)
        rows, listed = self._fastest_first(), set[int]()
        seconds = numpy.array([row["seconds"] for row in rows])
        for number, (of, own) in enumerate(self._own.items()):
            errors = numpy.array([self.error(row, of) for row in rows])
            if not errors.any() or (of == "load" and max(
                    row["load_error_max"] for row in rows) < PRESCRIBED):
                continue
            best = [place for place, row in enumerate(rows) if row["typed"] and errors[place] > 0
                    and errors[place] < SMALLER * min((errors[other] for other in range(place)
                                                       if rows[other]["typed"]), default=math.inf)]
            listed.update(best)
            style, color, bound = "os^D"[number], f"C{number}", errors <= own
            axes.plot(seconds, errors, ".", color=color, ms=3)
            axes.plot(seconds[best], errors[best], f"{style}-", color=color, ms=5,
                      label=of.replace("_", " "))
            axes.plot(seconds[bound], errors[bound], style, color=color, ms=5, mfc="white")
        low, high = axes.get_ylim()
        axes.axhspan(low / 10, self.digits or low / 10, color="0.92", zorder=0)
        for goal in self.answers:
            axes.axhline(goal, color="0.6", lw=0.8, ls=":", zorder=0)
        span = NEAR * math.log(numpy.divide(*axes.get_xlim()[::-1]))
        numbers, lines = dict[float, str](), ["time (s); dots: other methods, open: bounds"]
        for number, place in enumerate(sorted(listed), 1):
            at = next((one for one in numbers if math.log(seconds[place] / one) < span),
                      seconds[place])
            numbers[at] = f"{numbers[at]},{number}" if at in numbers else str(number)
            lines.append(f"{number}  {self.typed(rows[place])}: {seconds[place]:.2g} s")
            axes.axvline(seconds[place], color="0.85", lw=0.6, zorder=0)
        above = axes.secondary_xaxis("top")
        above.set_xticks(list(numbers), list(numbers.values()))
        above.set_xticks([], minor=True)
        axes.set(ylim=(low, high), ylabel="relative error")
        axes.set_xlabel("\n".join(lines), fontsize="small", ma="left", loc="left")
        axes.legend(fontsize="small")
        return axes

    @staticmethod
    def typed(row: Mapping[str, Any]) -> str:
        """Names of `effects`, or an argument of `solve`, to type for a row; else its method."""
        return str(row["typed"] or row["method"]).replace("--accuracy ", "accuracy=")


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
    text = re.sub("--accuracy ([^ ,]+)", r"accuracy=\1", outcome.text(_c.REPORT).rstrip("\n"))
    text = re.sub("asperity solve scene ([^ ,]+)", r"asperity.solve(scene, \1)", text)
    return Accuracy(table, text, _digits(given), goals)


def _digits(given: Scene) -> float | None:
    """Greatest change of a total when all heights change by half of their last digit."""
    import tempfile  # takes long
    found = one = None
    with warnings.catch_warnings(), tempfile.TemporaryDirectory() as folder:
        warnings.simplefilter("ignore")
        for other in _with_half_digits(given.with_arrays(), os.path.join(folder, "a.deck")):
            one, moved = one or given.solve().positions, other.solve().positions
            found = max(found or 0.0, *(
                float(numpy.nanmax(abs(moved[name] - one[name]) / abs(one[whole]), initial=0.0))
                for name, whole in zip(("load", "area", "separation"),
                                       ("load", "area", "compression"))))
    return found or None


def _with_half_digits(given: Scene, deck: str) -> Iterator[Scene]:
    """A scene with arrays twice, each height changed by half of its last digit, up or down at
    random, the first two unlike and alike; a card deck by a file `deck`."""
    source = given._source if isinstance(given._source, Mapping) else given.groups
    surfaces = dict(source.get("surfaces", {}))
    arrays = {side: value for side, value in surfaces.items()
              if side in SIDES and isinstance(value, (HeightMap, Mapping))}
    for seed in (1, 4) if arrays or "deck" in surfaces else ():
        made = {side: _with_half_digit(value, seed) for side, value in arrays.items()}
        if "deck" in surfaces:
            made["deck"] = deck
            path = os.path.join(os.path.dirname(given._name), str(surfaces["deck"]).strip("'"))

            def moved(card: re.Match[str], random: Any = numpy.random.default_rng(seed)) -> str:
                height = float(card[2]) + random.choice((-0.5, 0.5)) / 10**len(card[3])
                return f"{card[1]}{height:7.{len(card[3]) + 1}f}"
            with open(path, encoding="ascii") as cards, open(deck, "w", encoding="ascii") as file:
                file.write(re.sub(CARD, moved, cards.read()))
        yield Scene({**source, "surfaces": {**surfaces, **made}})


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
