"""What an accuracy costs: a scene solved by each method that applies, with run time and errors."""

from __future__ import annotations

import html
import itertools
import math
import time
import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from . import _arguments as _a
from ._columns import Table, column, needed
from ._errors import ComputeError, InputError
from ._maps import HeightMap
from ._plots import new_axes, picture_html
from ._results import Results
from ._scenes import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Quantities, and the columns of estimated errors of the positions.
ESTIMATES = {"area": "area_error_estimate", "separation": "error_estimate",
             "load": "error_estimate", "pressure": "pressure_error_estimate"}
WORDS = {"area": "contact area", "pressure": "greatest pressure"}
# Of asperities the changes of &effects, as `asperity accuracy` has them.
FINE = 1e-4
EFFECTS = [{"interaction": "off"}, {"interaction": "coupled", "tolerance": FINE},
           *({"interaction": "auto", "tolerance": share} for share in (0.01, 0.003, 0.001)),
           {"interaction": "boundary", "tolerance": FINE, "boundary_tolerance": 0.01},
           *({"interaction": "boundary", "tolerance": FINE, "boundary_tolerance": share,
              "area_tolerance": 1e-3} for share in (0.001, FINE))]
OTHERS = ("friction", "plasticity", "adhesion", "creep")
# Of maps every n-th pixel, and pixels divided by n.
COARSER, FINER = (4, 2), (2, 4)
# Chosen: a next finer method takes at most this number of times as long; a solve shorter than this
# number of seconds is repeated, and the least time counts; methods of a plot with one label.
LONGER, SHORT, REPEATS, NEAR = 8.0, 0.2, 3, 1.4


class Accuracy:
    """Run times and errors of the methods of a scene; `print` shows them.

    Attributes
    ----------
    table : Table
        A row for each method: `method`, what to `type`, `seconds`, and the relative error of each
        quantity. An error below that of the reference is the error of the reference.
    reference : str
        The method that the others are compared with: that of the least estimated error.
    own : dict of str to float
        Estimated error of the reference, by quantity.
    digits : float or None
        Greatest change of the quantities when the heights change by half of their last digit.
    notes : list of str
        Methods that were left out, with the reason.
    """

    def __init__(self, rows: list[dict[str, Any]], reference: str, own: dict[str, float],
                 goals: Sequence[float], digits: float | None, notes: list[str]):
        self.reference, self.own, self.goals = reference, own, tuple(goals)
        self.digits, self.notes = digits, notes
        self._rows = rows
        self.table = Table({name: column(memoryview(needed("numpy", "numpy", "an array").array(
            [row[name] for row in rows]))) if name not in ("method", "type") else
            column([row[name] for row in rows]) for name in rows[0]}, {"seconds": "s"}, "methods")

    def answer(self, goal: float, of: str) -> dict[str, Any] | None:
        """The fastest row with an error of at most `goal` of the quantity `of`; None: no such."""
        if of not in self.own:
            raise _a.wrong("of", repr(of), ", ".join(map(repr, self.own)))
        return min((row for row in self._rows if row[of] <= goal),
                   key=lambda row: float(row["seconds"]), default=None)

    def __str__(self) -> str:
        cells = [["error at most", *(WORDS.get(name, name) for name in self.own)]]
        for goal in self.goals:
            cells.append([f"{100 * goal:g} %"])
            for name in self.own:
                row = self.answer(goal, name)
                cells[-1].append(f"{row['method']}, {row['seconds']:.2g} s" if row else (
                    f"not reached, best {100 * min(one[name] for one in self._rows):.2g} %"))
        rows = [["seconds", *self.own, "type"]] + [[f"{row['seconds']:.2g}", *(
            ("<" if 0 < row[name] <= self.own[name] else "") + (
                f"{row[name]:.2g}" if row["method"] != self.reference or row[name] else "reference")
            for name in self.own), row["type"]] for row in self._rows]
        lines = [*_aligned(cells), "", *_aligned(rows), "", f"Reference: {self.reference}. "
                 "<: below its estimated error, which is printed. Errors are relative,",
                 "that of the separation to the compression; times are of solves to the last state."]
        if self.digits is not None:
            lines.append(f"Half of the last digit of the heights changes them by {self.digits:.1g}.")
        return "\n".join([*lines, *self.notes])

    def __repr__(self) -> str:
        return f"<asperity.Accuracy of {len(self._rows)} methods: {', '.join(self.own)}>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>" + picture_html(self.plot)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the errors against the run time: a curve for each quantity, of the least error up to
        a time, and a line for each method. Open markers are bounds by the reference; errors in the
        grey band are below the digits of the heights.
        """
        axes: Axes = new_axes(ax, size=(9.0, 4.5))
        rows = sorted(self._rows, key=lambda row: float(row["seconds"]))
        for number, (name, own) in enumerate(self.own.items()):
            shown = [row for row in rows if row[name] > 0]
            style: dict[str, Any] = {"color": f"C{number}", "lw": 0.8}
            axes.step([row["seconds"] for row in shown], list(itertools.accumulate(
                (row[name] for row in shown), min)), where="post", **style)
            for row in shown:
                axes.plot(row["seconds"], row[name], "os^D"[number % 4],
                          mfc="white" if row[name] <= own else None, **style)
            axes.plot([], [], "os^D"[number % 4], label=WORDS.get(name, name), **style)
        for goal in self.goals:
            axes.axhline(goal, color="0.6", lw=0.7, ls=":")
        axes.set(xscale="log", yscale="log", xlabel="time (s)", ylabel="relative error")
        low, high = axes.get_ylim()
        if self.digits:
            axes.axhspan(min(low, self.digits) / 10, self.digits, color="0.92", zorder=0)
        axes.set_ylim(low, high)
        marks: list[list[Any]] = []  # place of a label, and the numbers of its methods
        for number, row in enumerate(rows, 1):
            axes.axvline(row["seconds"], color="0.9", lw=0.8, zorder=0)
            if not marks or row["seconds"] > NEAR * marks[-1][0]:
                marks.append([row["seconds"], []])
            marks[-1][1].append(number)
        for place, numbers in marks:
            axes.text(place, 1.01, str(numbers[0]) if len(numbers) == 1 else
                      f"{numbers[0]}\u2013{numbers[-1]}", ha="center", va="bottom",
                      fontsize="small", transform=axes.get_xaxis_transform())
        axes.text(1.03, 1.0, "\n".join(f"{number}  {row['method']}, {row['seconds']:.2g} s"
                                       for number, row in enumerate(rows, 1)),
                  va="top", fontsize="small", transform=axes.transAxes)
        axes.legend(fontsize="small", loc="lower left", bbox_to_anchor=(1.01, 0.0), frameon=False)
        return axes


def _aligned(rows: list[list[str]]) -> list[str]:
    widths = [max(map(len, cells)) + 2 for cells in zip(*rows)]
    return ["".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows]


def accuracy(scene: Any, quantities: Sequence[str] | None = None, *,
             goals: Sequence[float] = (0.1, 0.01, 0.001), seconds: float = 60.0) -> Accuracy:
    """Solve the last state of a scene by each method that applies, and compare run times and errors.

    Asperities: isolated, coupled and by boundary elements, with several tolerances. Height maps in
    the groups of the scene: every fourth and second pixel, and finer pixels by `HeightMap.resample`,
    which are right where the map has no shorter waves. The errors are those of
    `asperity accuracy`, the greatest pressure with them.

    Parameters
    ----------
    scene : str, os.PathLike, mapping or Scene
        As for `solve`. A map in a file has its own pixels only: hand over a `HeightMap`.
    quantities : list of str, optional
        Of `area`, `separation`, `load` and `pressure` (the greatest). Default: area, pressure, and
        load or separation, the one that is not prescribed.
    goals : list of float, default (0.1, 0.01, 0.001)
        Relative errors that the fastest method is stated for.
    seconds : float, default 60
        A method that could take longer than what is left of this time is left out.

    Returns
    -------
    Accuracy

    Raises
    ------
    InputError, ComputeError
        As `solve`; where no method can be solved.

    Examples
    --------
    >>> import asperity
    >>> found = asperity.accuracy("data/examples/csv_surfaces.scene", ["separation"])
    >>> found.reference
    "interaction='auto', tolerance=0.001"
    """
    given = scene if isinstance(scene, Scene) else Scene(scene)
    source = given._source if isinstance(given._source, Mapping) else {}
    surfaces = {side: value for side, value in dict(source.get("surfaces", {})).items()
                if side in ("upper", "lower") and not isinstance(value, str)}
    end: dict[str, Any] = {"loading": {"points": None}} if "loading" in given.groups else {}

    def prepared(change: Any, effects: dict[str, Any]) -> Any:
        """What solves the scene with its surfaces and effects changed."""
        made = given if change is None else Scene({**source, "surfaces": {
            **source["surfaces"], **{side: change(each) for side, each in surfaces.items()}}})
        return lambda: made.solve(**end, **({"effects": effects} if effects else {}))

    begun, notes, found = time.monotonic(), [], []
    methods: list[tuple[str, str, Any, dict[str, Any]]] = [
        ("as in the scene", "scene.solve()", None, {})]
    for name, typed, change, effects in methods:  # which grows
        kind = effects.get("interaction", "pixels")
        longest = LONGER * max((row["seconds"] for row in found if row["kind"] == kind), default=0)
        if found and longest > seconds - (time.monotonic() - begun):
            notes.append(f"Left out: {name}, it could take {longest:.1g} s.")
            continue
        try:
            spent, results = _measured(prepared(change, effects))
        except (InputError, ComputeError) as error:
            notes.append(f"Left out: {name}: {error}")
            continue
        others = {other for other in OTHERS if other in results.positions
                  and set(results.positions[other].tolist()) != {"off"}}
        if found and others != found[0]["others"]:
            notes.append(f"Left out: {name}: the other effects of the scene are not solved with it.")
            continue
        if change is None and not effects:
            methods += _methods(surfaces, "samples" in results.contacts)
        found.append({"kind": kind, "method": name, "type": typed, "seconds": spent,
                      "how": (change, effects), "others": others, "totals": _totals(results), "own": {
                          quantity: float(max(results.positions[title].tolist()))
                          if title in results.positions else math.nan
                          for quantity, title in ESTIMATES.items()}})
    if not found:
        raise ComputeError("\n".join(notes))
    names = list(quantities or ("area", "separation" if results._control() in (
        "load", "vertical_load", "pressure") else "load", "pressure"))
    if set(names) - ESTIMATES.keys():
        raise _a.wrong("quantities", repr(names), ", ".join(map(repr, ESTIMATES)))
    # As `asperity accuracy`: that of the least estimate with interaction, of maps the last pixels.
    best = found[-1] if found[-1]["kind"] == "pixels" else min(
        [row for row in reversed(found) if row["kind"] not in ("off", "pixels")] or found,
        key=lambda row: row["own"]["load"] if row["own"]["load"] >= 0 else math.inf)
    own = {name: best["own"][name] if best["own"][name] > 0 else 0.0 for name in names}
    rows = [{"method": row["method"], "type": row["type"], "seconds": row["seconds"],
             **{name: max(own[name], _error(row["totals"], best["totals"], name))
                for name in names}} for row in found]
    change, effects = best["how"]
    digits = [_error(_totals(_measured(prepared(
        lambda each: _with_half_digit(change(each) if change else each, seed), effects))[1]),
        best["totals"], name) for seed in (1, 2) for name in names] if surfaces else []
    return Accuracy(rows, best["method"], own, goals, max(digits, default=None), notes)


def _methods(surfaces: dict[str, Any], has_maps: bool) -> list[tuple[str, str, Any, dict[str, Any]]]:
    """Name, what to type, and changes of the surfaces and effects of each method, from fast to
    slow."""
    if not has_maps:
        return [(", ".join(f"{name}={value!r}" for name, value in effects.items()
                           if name != "area_tolerance" and (name, value) != ("tolerance", FINE)),
                 f"scene.solve(effects={effects})", None, effects) for effects in EFFECTS]
    maps = {side: each for side, each in surfaces.items() if isinstance(each, HeightMap)}
    if not maps:
        return []
    side, one = next(iter(maps.items()))
    found: list[tuple[str, str, Any, dict[str, Any]]] = []
    for step in COARSER:
        typed = f"{side} = HeightMap({side}.heights[::{step}, ::{step}], " \
                f"({step * one.spacing[0]:g}, {step * one.spacing[1]:g}), {one.unit!r}, " \
                f"{one.periodic})"
        found.append((f"every {step}. pixel", typed, lambda each, step=step: HeightMap(
            each.heights[::step, ::step], [step * size for size in each.spacing], each.unit,
            each.periodic), {}))
    found.append(("pixels of the map", "scene.solve()", lambda each: each, {}))
    if hasattr(one, "resample"):
        found += [(f"pixels / {parts}", f"{side} = {side}.resample({one.spacing[0] / parts:g})",
                   lambda each, parts=parts: each.resample([size / parts for size in each.spacing]),
                   {}) for parts in FINER]
    return found


def _measured(solve: Any) -> tuple[float, Results]:
    """The least time of a solve, and its results."""
    spent = math.inf
    for _ in range(REPEATS):
        begun = time.perf_counter()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            results = solve()
        spent = min(spent, time.perf_counter() - begun)
        if spent > SHORT:
            break
    return spent, results


def _totals(results: Results) -> dict[str, Any]:
    """Quantities of the states, by name, and the position of each state."""
    numpy = needed("numpy", "numpy", "accuracy")
    states, contacts = results.states, results.contacts
    keys = {key: place for place, key in enumerate(zip(states["position"].tolist(),
                                                       states["step"].tolist()))}
    greatest = numpy.zeros(len(states))
    places = [keys[key] for key in zip(contacts["position"].tolist(), contacts["step"].tolist())]
    numpy.maximum.at(greatest, numpy.array(places, int), contacts["maximum_pressure"])
    return {"pressure": greatest, **{name: states[name] for name in (
        "position", "area", "load", "separation", "compression")}}


def _error(mine: dict[str, Any], other: dict[str, Any], name: str) -> float:
    """The largest relative error over the positions: at every state of a position where both have as
    many, else at the deepest."""
    found = 0.0
    for position in set(other["position"].tolist()):
        one, two = ({key: values[each["position"] == position] for key, values in each.items()}
                    for each in (mine, other))
        if len(one[name]) != len(two[name]):
            one, two = ({key: values[[each["compression"].argmax()]] for key, values in each.items()}
                        for each in (one, two))
        difference = float(abs(one[name] - two[name]).max())
        whole = float(abs(two["compression" if name == "separation" else name]).max())
        found = max(found, difference / whole if whole > 0 else float(difference > 0))
    return found


def _with_half_digit(surface: Any, seed: int) -> Any:
    """A surface with each height changed by half of the last digit, up or down at random: of a map
    of the least step between its heights, of asperities of the last decimal that is written."""
    numpy = needed("numpy", "numpy", "accuracy")
    is_map = isinstance(surface, HeightMap)
    heights = numpy.array(surface.heights if is_map else surface["height"], float)
    values = numpy.unique(heights[numpy.isfinite(heights)])
    half = 0.5 * (numpy.diff(values).min(initial=math.inf) if is_map else 10.0**-max(
        len(repr(float(value)).partition(".")[2]) for value in values))
    sign = numpy.random.default_rng(seed).choice((-1.0, 1.0), heights.shape)
    heights += half * sign if math.isfinite(half) else 0.0
    return HeightMap(heights, surface.spacing, surface.unit, surface.periodic) if is_map else {
        **{name: surface[name] for name in ("x", "y", "radius")}, "height": heights}
