"""Scenes: read and checked once, solved many times."""

from __future__ import annotations

import contextlib
import importlib
import math
import os
import re
import sys
from collections.abc import Mapping
from ctypes import POINTER, byref, c_int, pointer
from typing import Any

from . import _arguments as _a
from . import _library as _c
from ._fields import states_kept
from ._maps import HeightMap, map_of, map_of_file
from ._results import Results

EXPECTED_SCENE = "a path, or a dict of groups"
EXPECTED_SIDE = "a path, a height map, 'plane', or a mapping with x, y, height and radius"


class Scene:
    """A scene that is read and checked once and can be solved many times.

    `scene` is as for `solve`; an InputError has all that is wrong with it.

    Attributes:
        groups: The groups of the scene without its arrays; for a file, values as they stand there.

    Examples:
        >>> scene = asperity.Scene("data/examples/one_pair.scene")
        >>> round(scene.solve(loading={"control": "load", "value": 20}).states["load"][-1])
        20
    """

    def __init__(self, scene: _a.Path | Mapping[str, Mapping[str, Any]]):
        self._source, self._name = scene, "scene"
        self._last: tuple[float, Any] = math.inf, None  # seconds of processor and choices
        self.groups: dict[str, dict[str, Any]]
        if isinstance(scene, Mapping):
            rest, sides = _without_arrays(scene)
            text = _a.Groups(self._name, rest)
            self._read = _c.call("build_scene", text.text, *map(byref, sides)).checked(text.named)
            self.groups = {group: dict(names) for group, names in rest.items()}
        else:
            coded = _a.path("scene", scene, EXPECTED_SCENE)
            self._name = os.fsdecode(coded)
            self._read = _c.call("read_scene", coded).checked()
            self.groups = {}
            for line in self._read.lines(_c.GROUPS):
                group, name, values = line.split("\t", 2)
                self.groups.setdefault(group, {})[name] = _a.Written(values)

    def solve(self, *, arithmetic: str = "real64", accuracy: float = 0.0, accuracy_of: str = "load",
              contacts: bool = True, threads: int = 0, progress: bool = False,
              fields: bool | str = False, **groups: Mapping[str, Any] | None) -> Results:
        """Solve the scene, with other values where they are given.

        The keywords of `asperity.solve` mean the same, and errors are the same. **groups are values
        that replace those of the scene for this solve: `loading={"value": 20}` keeps the other
        names of the group; None in place of a value or of a group removes it. The group `surfaces`
        cannot be changed. The results are those of a new scene, to the tolerance of the solver.
        """
        read, text = self._read, _a.Groups(self._name, {})
        kept = states_kept(fields)
        choices = arithmetic, accuracy, accuracy_of, contacts, threads, progress, kept
        # Another value of the loading keeps the number of states: the solve takes about as long.
        is_short = self._last[0] < _c.SHORT and choices == self._last[1] \
            and _is_another_value(groups)
        if groups:
            if "surfaces" in groups:
                raise _a.wrong("surfaces", "a change of the surfaces", "a new asperity.Scene")
            text = _a.Groups(self._name, _changed(self.groups, groups))
            read = _c.call("rebuild_scene", self._read, text.text,
                           is_short=is_short).checked(text.named)
        interrupt, counts = c_int(0), (c_int * 2)()
        options = _c.Options(
            _a.word("arithmetic", arithmetic), _a.number("accuracy", accuracy),
            not _a.flag("contacts", contacts),
            _a.whole("threads", threads, "a number from 1 to 9999, or 0 for all cores"),
            POINTER(c_int)(interrupt), _a.word("accuracy_of", accuracy_of), counts, kept)
        shows = _a.flag("progress", progress)
        with _Progress(counts) if shows else contextlib.nullcontext() as bar:
            solved = _c.call("solve_scene", read, byref(options), interrupt=interrupt,
                             watch=bar.show if bar else None, is_short=is_short and bar is None)
        self._last = solved.seconds, choices
        return Results(solved.checked(text.named), kept)

    def with_arrays(self) -> Scene:
        """The scene with the surfaces of its files as arrays; those of decks stay as they are."""
        given = (self._source if isinstance(self._source, Mapping) else self.groups).get(
            "surfaces", {})
        is_file = not isinstance(self._source, Mapping)
        words = {name: re.findall(r"[^\s,'()\[\]]+", str(given[name])) for name in (
            "radius", "map_spacing", "map_unit") if name in given}
        steps = [float(one) for one in words.get("map_spacing", ())]
        made = {name: value for name, value in given.items() if not is_file or name not in words}
        for place, side in ((0, "upper"), (-1, "lower")):
            path = str(given.get(side, "plane")).strip("'")
            if not _a.is_text(given.get(side, "")) or path == "plane":
                continue
            path = os.path.join(os.path.dirname(self._name) if is_file else "", path)
            if path.lower().endswith(".csv"):
                table = importlib.import_module("numpy").genfromtxt(path, delimiter=",", names=True)
                made[side] = {"radius": [float(words.get("radius", "1")[place])], **{
                    name: table[name].reshape(-1) for name in table.dtype.names}}
            else:
                made[side] = map_of_file(path, steps[2 * place:][:2] or None,
                                         words.get("map_unit", [None])[place])
        is_same = all(value is given[name] for name, value in made.items())
        return self if is_same else Scene({**self.groups, "surfaces": made})

    def __reduce__(self) -> Any:
        return Scene, (self._source,)

    def __repr__(self) -> str:
        return f"<asperity.Scene {self._name!r}: {', '.join(self.groups)}>"


def solve(scene: _a.Path | Mapping[str, Mapping[str, Any]] | Scene, *, arithmetic: str = "real64",
          accuracy: float = 0.0, accuracy_of: str = "load", contacts: bool = True,
          threads: int = 0, progress: bool = False, fields: bool | str = False) -> Results:
    """Solve a scene: contacts, load, area and pressures of two surfaces.

    Args:
        scene: The path of a scene file or of a card deck; or the groups of a scene as a dict of
            dicts, with the names and units of `docs/reference/scene.md`. There, `upper` and `lower`
            of `surfaces` are a path; `"plane"` for one of the two; asperities: a mapping, a
            structured array or a pandas table with `x`, `y` (places on the reference plane),
            `height` (above it) and `radius`, n numbers each, or one radius for all; or a height
            map: a `HeightMap`, a topography of SurfaceTopography, or a matrix of heights `[y, x]`
            with `map_spacing`. True and False stand for `on` and `off`, True for `auto` of
            `interaction`.
        arithmetic: No other is accepted. `report` has other arithmetics.
        accuracy: Largest estimated relative error, less than 1; the fastest method with this error
            is used. 0: no such choice.
        accuracy_of: Totals that `accuracy` limits: `all`, `area`, `pressure` or `load`, for which
            the separation stands under a load.
        contacts: False: totals only, `contacts` of the results has no rows.
        threads: 0: all cores; at most 9999. The results are the same for any number.
        progress: Show a bar of tqdm, or a line on standard error where tqdm is not installed.
        fields: Keep pressure, gap and displacement for `Results.fields`, True of the last state,
            `all` of all states: on the pixels of a height map, or on the grid of a scene of
            asperities with `field_spacing` in `surfaces`. A state takes 24 bytes a pixel.

    `docs/reference/python.md` has the errors and warnings.

    Examples:
        >>> ridges = [[0.0, 0.1, 0.0, -0.1] * 8] * 32  # heights in um
        >>> results = asperity.solve({
        ...     "surfaces": {"upper": "plane", "lower": ridges, "map_spacing": 0.5,
        ...                  "map_unit": "um", "map_edge": "periodic"},
        ...     "material": {"contact_modulus": 1e5},
        ...     "loading": {"control": "pressure", "value": 500.0}})
        >>> print(f"{results.states['nominal_pressure'][-1]:.1f}")
        500.0
    """
    given = scene if isinstance(scene, Scene) else Scene(scene)
    return given.solve(arithmetic=arithmetic, accuracy=accuracy, accuracy_of=accuracy_of,
                       contacts=contacts, threads=threads, progress=progress, fields=fields)


def _without_arrays(scene: Mapping[str, Any]) -> tuple[dict[str, Any], list[Any]]:
    """The groups of a scene without its arrays, and the two sides for the library."""
    rest, sides = dict(scene), [_c.Side(), _c.Side()]
    given = scene.get("surfaces")
    if not isinstance(given, Mapping):
        return rest, sides
    own = rest["surfaces"] = dict(given)
    steps, numbers = own.get("map_spacing"), []
    if steps is not None and not _a.is_text(steps):
        if hasattr(type(steps), "__float__") and not hasattr(type(steps), "__len__"):
            own["map_spacing"] = steps = [steps, steps]
        numbers = _a.doubles("surfaces.map_spacing", steps)
    for place, name, side in zip((0, -2), ("upper", "lower"), sides):
        value = given.get(name, "")
        if not _a.is_text(value):
            # Of two pairs the first is that of the upper side.
            pixels = map_of(f"surfaces.{name}", own.pop(name),
                            numbers[place:][:2] if len(numbers) in (2, 4) else None)
            known = _a.columns_of(value)
            if pixels is not None:
                side.map = pointer(pixels)
            elif known is None:
                raise _a.wrong_type(f"surfaces.{name}", value, EXPECTED_SIDE)
            else:
                side.asperities = pointer(_a.asperities(f"surfaces.{name}", value, known))
            if isinstance(value, HeightMap) and value.is_profile and not value.periodic:
                own.setdefault("map_edge", ["free", "periodic"])
    if not own:
        del rest["surfaces"]
    return rest, sides


def _is_another_value(groups: Mapping[str, Mapping[str, Any] | None]) -> bool:
    """Whether changes are none, or one number as the value of the loading."""
    return all(group == "loading" and isinstance(names, Mapping) and all(
        name == "value" and isinstance(value, (int, float)) for name, value in names.items())
        for group, names in groups.items())


def _changed(groups: Mapping[str, Mapping[str, Any]],
             changes: Mapping[str, Mapping[str, Any] | None]) -> dict[str, dict[str, Any]]:
    """The groups with other values; None removes one."""
    for group, names in changes.items():
        if not isinstance(names, (Mapping, type(None))):
            raise _a.wrong_type(group, names, "a dict of names and values, or None")
    return {group: {name: value for name, value in {
        **groups.get(group, {}), **(changes.get(group) or {})}.items() if value is not None}
        for group in {**groups, **changes} if changes.get(group, {}) is not None}


class _Progress:
    """How far a solve has come: a bar of tqdm, or a line on standard error."""

    def __init__(self, counts: Any):
        self._counts, self._last, self._bar = counts, "", None
        with contextlib.suppress(ImportError):
            self._bar = importlib.import_module("tqdm.auto").tqdm(unit="state", desc="asperity")

    def show(self) -> None:
        done, total = self._counts
        line = f"\rasperity: {done} of {total} states"
        if total and self._bar is not None:
            self._bar.total, self._bar.n = total, done
            self._bar.refresh()
        elif total and line != self._last:
            print(line, end="", file=sys.stderr, flush=True)
            self._last = line

    def __enter__(self) -> _Progress:
        return self

    def __exit__(self, *_: Any) -> None:
        self.show()
        if self._bar is not None:
            self._bar.close()
        elif self._last:
            print(file=sys.stderr)
