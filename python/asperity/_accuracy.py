"""Run time and errors of each method that applies to a scene."""

from __future__ import annotations

import html
import itertools
import math
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from . import _arguments as _a
from ._columns import Lazy, Table, column
from ._errors import ComputeError, InputError
from ._maps import HeightMap
from ._plots import new_axes, picture_html
from ._scenes import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._results import Results

numpy: Any = Lazy("numpy", "numpy", "accuracy")
# Quantities, and the columns of the positions with their estimated errors.
ESTIMATES = {"area": "area_error_estimate", "separation": "error_estimate",
             "load": "error_estimate", "pressure": "pressure_error_estimate"}
WORDS = {"area": "contact area", "pressure": "greatest pressure"}
OTHERS = ("friction", "plasticity", "adhesion", "creep")
# Changes of &effects for asperities: those of `asperity accuracy`.
FINE = 1e-4
EFFECTS: list[dict[str, Any]] = [
    {"interaction": "off"}, {"interaction": "coupled", "tolerance": FINE},
    *({"interaction": "auto", "tolerance": share} for share in (0.01, 0.003, 0.001)),
    *({"interaction": "boundary", "tolerance": FINE, "boundary_tolerance": share,
       **({"area_tolerance": 1e-3} if share < 0.01 else {})} for share in (0.01, 0.001, FINE))]
# For maps every n-th pixel, and pixels divided by n.
COARSER, FINER = (4, 2), (2, 4)
# Chosen: the next method takes at most this number of times as long as those of its kind; a solve
# shorter than these seconds is repeated, and the least time counts; methods with one label.
LONGER, SHORT, REPEATS, NEAR = 8.0, 0.2, 3, 1.4


class Method:
    """A method, its changes of surfaces and effects, and its time, totals and estimated errors."""

    def __init__(self, name: str, typed: str, change: Callable[[Any], Any] | None = None,
                 effects: dict[str, Any] | None = None):
        self.name, self.typed, self.change, self.effects = name, typed, change, effects or {}
        self.seconds = math.inf
        self.totals: dict[str, Any] = {}
        self.own: dict[str, float] = {}
        self.others: set[str] = set()

    @property
    def kind(self) -> str:
        return str(self.effects.get("interaction", "pixels"))


class Accuracy:
    """Run times and errors of the methods of a scene; `print` shows them.

    Attributes
    ----------
    table : Table
        A row for each method: `method`, what to `type`, `seconds`, and the relative error of each
        quantity. An error below that of the reference is the error of the reference.
    reference : str
        The method of the least estimated error, with which the others are compared.
    own : dict of str to float
        Estimated error of the reference, by quantity.
    digits : float or None
        Greatest change of a quantity when the heights change by half of their last digit.
    notes : list of str
        Methods that were left out, with the reason.
    """

    def __init__(self, table: Table, reference: str, own: dict[str, float],
                 goals: Sequence[float], digits: float | None, notes: list[str]):
        self.table, self.reference, self.own, self.goals = table, reference, own, tuple(goals)
        self.digits, self.notes = digits, notes

    def answer(self, goal: float, of: str) -> dict[str, Any] | None:
        """The fastest row with an error of at most `goal` of the quantity `of`; None: no such."""
        if of not in self.own:
            raise _a.wrong("of", repr(of), ", ".join(map(repr, self.own)))
        return min((row for row in self.table.rows() if row[of] <= goal),
                   key=lambda row: float(row["seconds"]), default=None)

    def __str__(self) -> str:
        cells = [["error at most", *(WORDS.get(name, name) for name in self.own)]]
        for goal in self.goals:
            cells.append([f"{100 * goal:g} %"])
            for name in self.own:
                row = self.answer(goal, name)
                cells[-1].append(f"{row['method']}, {row['seconds']:.2g} s" if row else (
                    f"not reached, best {100 * self.table[name].min():.2g} %"))
        rows = [["seconds", *self.own, "type"]]
        for row in self.table.rows():
            rows.append([f"{row['seconds']:.2g}", *(
                f"{'<' if 0 < row[name] <= self.own[name] else ''}{row[name]:.2g}"
                for name in self.own), row["type"]])
        lines = [*_aligned(cells), "", *_aligned(rows), "", f"Reference: {self.reference}. "
                 "<: below its estimated error, which is printed.",
                 "Errors are relative, of the separation to the compression. Times are of solves "
                 "to the last state."]
        if self.digits is not None:
            lines.append(f"Half of the last digit of the heights: {self.digits:.1g}.")
        return "\n".join([*lines, *self.notes])

    def __repr__(self) -> str:
        return f"<asperity.Accuracy of {len(self.table)} methods: {', '.join(self.own)}>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>" + picture_html(self.plot)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the errors against the run time: a curve for each quantity, of the least error up to
        a time, and a line for each method. Open markers are bounds by the reference; errors in the
        grey band are below the digits of the heights.
        """
        axes: Axes = new_axes(ax, size=(9.0, 4.5))
        rows = sorted(self.table.rows(), key=lambda row: float(row["seconds"]))
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
        marks: list[tuple[float, list[int]]] = []
        for number, row in enumerate(rows, 1):
            axes.axvline(row["seconds"], color="0.9", lw=0.8, zorder=0)
            if not marks or row["seconds"] > NEAR * marks[-1][0]:
                marks.append((row["seconds"], []))
            marks[-1][1].append(number)
        for place, numbers in marks:
            axes.text(place, 1.01, "\u2013".join(map(str, sorted({numbers[0], numbers[-1]}))),
                      ha="center", va="bottom", fontsize="small",
                      transform=axes.get_xaxis_transform())
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
    """Solve the last state of a scene by each method that applies: run times and errors.

    Asperities: isolated, coupled and by boundary elements, with several tolerances. A `HeightMap`
    in a dict: every fourth and second pixel, and finer pixels by `resample`, for maps without
    shorter waves. The errors are those of `asperity accuracy`.

    Parameters
    ----------
    scene : str, os.PathLike, mapping or Scene
        As for `solve`. A map in a file has its own pixels only.
    quantities : list of str, optional
        Of `area`, `separation`, `load` and `pressure` (the greatest). Default: area, pressure, and
        load or separation, the one that is not prescribed.
    goals : list of float, default (0.1, 0.01, 0.001)
        Relative errors for which the fastest method is stated.
    seconds : float, default 60
        Time limit: a method that could exceed it is left out.

    Examples
    --------
    >>> import asperity
    >>> found = asperity.accuracy("data/examples/csv_surfaces.scene", ["separation"])
    >>> found.reference
    "interaction='auto', tolerance=0.001"
    """
    given = scene if isinstance(scene, Scene) else Scene(scene)
    begun, notes = time.monotonic(), []
    first = Method("as in the scene", "scene.solve()")
    results = _solve(given, first)
    surfaces = _surfaces(given)
    found = [first]
    for method in _methods(surfaces, "samples" in results.contacts):
        longest = LONGER * max((one.seconds for one in found if one.kind == method.kind), default=0)
        reason = ""
        if longest > seconds - (time.monotonic() - begun):
            reason = f"it could take {longest:.1g} s"
        else:
            try:
                _solve(given, method)
            except (InputError, ComputeError) as error:
                reason = str(error)
            if not reason and method.others != first.others:
                reason = "the other effects of the scene are not solved with it"
        if reason:
            notes.append(f"Left out: {method.name}: {reason}.")
        else:
            found.append(method)
    control = results._control()
    names = list(quantities or ("area", "separation" if control in (
        "load", "vertical_load", "pressure") else "load", "pressure"))
    if set(names) - ESTIMATES.keys():
        raise _a.wrong("quantities", repr(names), ", ".join(map(repr, ESTIMATES)))
    # As `asperity accuracy`: the least estimate with interaction, of maps the last pixels.
    best = found[-1] if found[-1].kind == "pixels" else min(
        [one for one in reversed(found) if one.kind not in ("off", "pixels")] or found,
        key=lambda one: one.own["load"] if one.own["load"] >= 0 else math.inf)
    own = {name: max(best.own[name], 0.0) if best.own[name] >= 0 else 0.0 for name in names}
    digits = []
    for seed in (1, 2) if surfaces else ():
        changed = Method("", "", lambda one, seed=seed: _with_half_digit(  # type: ignore[misc]
            best.change(one) if best.change else one, seed), best.effects)
        _solve(given, changed)
        digits += [_error(changed.totals, best.totals, name) for name in names]
    table = Table({"method": column([one.name for one in found]),
                   "type": column([one.typed for one in found]),
                   "seconds": column(numpy.array([one.seconds for one in found])),
                   **{name: column(numpy.array([max(own[name], _error(
                       one.totals, best.totals, name)) for one in found])) for name in names}},
                  {"seconds": "s"}, "methods")
    return Accuracy(table, best.name, own, goals, max(digits, default=None), notes)


def _surfaces(given: Scene) -> dict[str, Any]:
    """The sides of a scene that are arrays, by name."""
    source = given._source if isinstance(given._source, Mapping) else {}
    return {side: value for side, value in dict(source.get("surfaces", {})).items()
            if side in ("upper", "lower") and (isinstance(value, (HeightMap, Mapping)))}


def _methods(surfaces: dict[str, Any], has_maps: bool) -> list[Method]:
    """The methods from fast to slow."""
    if not has_maps:
        return [Method(", ".join(f"{name}={value!r}" for name, value in effects.items() if (
            name, value) != ("tolerance", FINE) and name != "area_tolerance"),
            f"scene.solve(effects={effects})", None, effects) for effects in EFFECTS]
    maps = {side: one for side, one in surfaces.items() if isinstance(one, HeightMap)}
    if not maps:
        return []
    side, one = next(iter(maps.items()))
    found = [Method(f"every {step}. pixel", f"{side} = HeightMap({side}.heights[::{step}, ::{step}]"
                    f", ({step * one.spacing[0]:g}, {step * one.spacing[1]:g}), {one.unit!r}, "
                    f"{one.periodic})", lambda each, step=step: HeightMap(  # type: ignore[misc]
                        each.heights[::step, ::step], [step * size for size in each.spacing],
                        each.unit, each.periodic)) for step in COARSER]
    found.append(Method("pixels of the map", "scene.solve()", lambda each: each))
    return found + [
        Method(f"pixels / {parts}", f"{side} = {side}.resample({one.spacing[0] / parts:g})",
               lambda each, parts=parts: each.resample(  # type: ignore[misc]
                   [size / parts for size in each.spacing]))
        for parts in FINER if hasattr(one, "resample")]


def _solve(given: Scene, method: Method) -> Results:
    """Solves the last state of a scene by a method, which gets its time, totals and estimates."""
    scene = given
    if method.change:
        source: Any = given._source
        scene = Scene({**source, "surfaces": {**source["surfaces"], **{
            side: method.change(one) for side, one in _surfaces(given).items()}}})
    groups: dict[str, Any] = {"loading": {"points": None}} if "loading" in given.groups else {}
    if method.effects:
        groups["effects"] = method.effects
    for _ in range(REPEATS):
        begun = time.perf_counter()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            results = scene.solve(**groups)
        method.seconds = min(method.seconds, time.perf_counter() - begun)
        if method.seconds > SHORT:
            break
    positions, states, contacts = results.positions, results.states, results.contacts
    method.own = {name: float(numpy.nanmax(positions[title], initial=-1.0)) if title in positions
                  else math.nan for name, title in ESTIMATES.items()}
    method.others = {name for name in OTHERS if name in positions
                     and set(positions[name].tolist()) != {"off"}}
    keys = {key: place for place, key in enumerate(zip(states["position"].tolist(),
                                                       states["step"].tolist()))}
    greatest = numpy.zeros(len(states))
    places = [keys[key] for key in zip(contacts["position"].tolist(), contacts["step"].tolist())]
    numpy.maximum.at(greatest, numpy.array(places, int), contacts["maximum_pressure"])
    method.totals = {"pressure": greatest, **{name: states[name] for name in (
        "position", "area", "load", "separation", "compression")}}
    return results


def _error(mine: dict[str, Any], other: dict[str, Any], name: str) -> float:
    """The largest relative error over the positions: at every state of a position where both have
    as many, else at the deepest."""
    found = 0.0
    for position in set(other["position"].tolist()):
        one, two = ({key: values[each["position"] == position] for key, values in each.items()}
                    for each in (mine, other))
        if len(one[name]) != len(two[name]):
            one, two = ({key: values[[each["compression"].argmax()]]
                         for key, values in each.items()} for each in (one, two))
        difference = float(abs(one[name] - two[name]).max())
        whole = float(abs(two["compression" if name == "separation" else name]).max())
        found = max(found, difference / whole if whole > 0 else float(difference > 0))
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
