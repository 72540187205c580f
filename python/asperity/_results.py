"""Results of a solve, and the summits of a height map."""

from __future__ import annotations

import contextlib
import functools
import html
import json
import math
import os
import re
from collections.abc import Mapping, Sequence
from typing import Any, cast

from . import _arguments as _a
from . import _fields
from . import _library as _c
from ._columns import Axes, Column, Table, needed, pandas, shown, xarray
from ._errors import ComputeError, warn_caller
from ._fields import Fields, Stress
from ._half_space import stresses
from ._maps import HeightMap, map_of_file
from ._page import page_of
from ._plots import draw_contacts, draw_curves, draw_pixels, in_plan, new_axes
from .theory import AREA_THEORIES, area_fraction

TABLES = ("positions", "states", "contacts")
# Names of the group `material`: moduli of both bodies, and of layers on them.
MATERIAL = ("elastic_modulus", "poisson_ratio", "layer_thickness", "layer_modulus", "layer_poisson")
SIDES = ("upper", "lower")
# Columns that `repr` prints of the last state.
FACTS = ("load", "separation", "area", "contacts")


class Results:
    """Results of `solve`: tables, summary, warnings.

    Lengths, forces and pressures are in the units of the scene; `docs/reference/columns.md` lists
    the columns with meaning, unit and sign. Results can be copied and pickled.

    Attributes:
        positions: One row for each position of the motion: its last state.
        states: One row for each state of each position.
        contacts: One row for each contact of each state.
        summary: The printed summary.
        warnings: One line for each kind, issued also as `TheoryWarning` or `AccuracyWarning`.
        notes: Notes on the deck, the scene or the map.
        scene: `text` without arrays, `file`, `units` of length and force where they are known, and
            `provenance`: version, arithmetic, effects, checksums of files.

    Examples:
        >>> print(f'{asperity.solve("data/examples/one_pair.scene").states["area"][-1]:.5f}')
        0.10472
    """

    def __init__(self, outcome: _c.Outcome, kept: int = _fields.NONE):
        self._kept, self._fields = kept, dict[tuple[int, int], Fields]()
        self._outcome: _c.Outcome = outcome  #: None of results that were loaded or copied
        self.summary: str = outcome.text(_c.REPORT)
        self.warnings: list[str] = outcome.lines(_c.WARNINGS)
        self.notes: list[str] = outcome.lines(_c.NOTES)

    @functools.cached_property
    def positions(self) -> Table:
        return self._outcome.table(_c.POSITIONS, "positions")

    @functools.cached_property
    def states(self) -> Table:
        return self._outcome.table(_c.STATES, "states")

    @functools.cached_property
    def contacts(self) -> Table:
        return self._outcome.table(_c.CONTACTS, "contacts")

    @functools.cached_property
    def scene(self) -> dict[str, Any]:
        facts = json.loads(self._outcome.text(_c.SCENE))
        return {**facts["scene"], "provenance": facts["provenance"]}

    def __getstate__(self) -> dict[str, Any]:
        for name in (*TABLES, "scene"):
            getattr(self, name)
        self._all_fields()
        return {**vars(self), "_outcome": None}

    def _all_fields(self) -> list[Fields]:
        """The fields that were kept, in the order of the states."""
        if self._kept and self._outcome is not None and "mean_gap" in self.states \
                and not math.isnan(self.states["mean_gap"][-1]):
            for place in zip(self.states["position"].tolist(), self.states["step"].tolist()):
                if self._keeps(*place):
                    self.fields(place[0], step=place[1])
        return [self._fields[place] for place in sorted(self._fields)]

    def to_dict(self) -> dict[str, Any]:
        """All results as lists, numbers and texts: what `json` writes. None: not computed."""
        return {**{name: {title: [None if cell != cell else cell for cell in cells]
                          for title, cells in getattr(self, name).to_dict().items()}
                   for name in TABLES},
                "units": {name: dict(getattr(self, name).units) for name in TABLES},
                "summary": self.summary, "warnings": list(self.warnings),
                "notes": list(self.notes), "scene": dict(self.scene)}

    def to_pandas(self) -> pandas.DataFrame:
        """The states as a `pandas.DataFrame`; `positions` and `contacts` have `to_pandas`, too."""
        return self.states.to_pandas()

    def to_xarray(self) -> xarray.Dataset:
        """The fields that were kept, with the dimensions `step`, `y` and `x`, and along `step` the
        columns of the states that are numbers; `attrs["units"]` of each variable is its unit."""
        kept = self._all_fields() or [self.fields()]
        made = needed("xarray", "xarray", "a dataset").concat(
            map(Fields.to_xarray, kept), "step", join="outer", coords="different", compat="equals")
        places = list(zip(self.states["position"].tolist(), self.states["step"].tolist()))
        rows = [places.index((one.position, one.step)) for one in kept]
        for name, values in self.states.items():
            if name not in ("step", "position") and values.dtype.kind in "fi":
                made[name] = ("step", values[rows], {"units": self.states.units[name]})
        return cast("xarray.Dataset", made)

    def save(self, path: _a.Path) -> None:
        """Write the results to one file, which `asperity.load` reads.

        It is a zip archive, whose parts other programs read: `results.json` (version, summary,
        warnings, notes, units), `positions.csv`, `states.csv`, `contacts.csv`, and the fields that
        were kept as arrays of numpy (`.npy`). A file of this name is replaced; one that cannot be
        written is a ComputeError.
        """
        from . import _files  # zipfile and tempfile take long to import
        _files.write_results(path, _c.VERSION, {"summary": self.summary, "warnings": self.warnings,
                                                "notes": self.notes, "scene": self.scene},
                             {name: getattr(self, name) for name in TABLES}, self._all_fields())

    def to_html(self, path: _a.Path, *, position: int | None = None,
                title: str | None = None) -> str:
        """Write one page for a browser, without a network, and return its name: maps of the fields
        that were kept, or contacts to scale; curves with errors; a table of contacts, summary,
        warnings and scene. A slider visits the states, of one position where that is given. A file
        of this name is replaced; one that cannot be written is a ComputeError. The title is the
        name of the scene unless given.
        """
        name = os.fsdecode(_a.path("path", path))
        if position is not None:
            self._step(position)
        text = page_of(self, position, title)
        try:
            with open(name, "w", encoding="utf-8") as file:
                file.write(text)
        except OSError as error:
            raise ComputeError(f"{name}: {error.strerror}") from None
        return name

    def plot(self, ax: Any = None, *, log: bool = False, errors: bool = True,
             theory: Mapping[str, Any] | None = None) -> tuple[Axes, Axes]:
        """Draw the load against the separation, and the contact area against the load; with a
        nominal area the nominal pressure and the area fraction in their place.

        Args:
            ax: Two axes to draw on; a new figure otherwise.
            log: Logarithmic axes, but for the separation.
            errors: Draw the estimated errors of the states as bands, of a path up and down as bars.
            theory: Curves of the second axes by name: x and y, or a function of x. Under the names
                `persson`, `bush_gibson_thomas` and `greenwood_williamson` a rough surface as these
                functions take it; the scene must have a nominal area and the moduli.
        """
        curves = {name: self._area_curve(name, given) for name, given in (theory or {}).items()}
        return draw_curves(self.states, ax, control=self._control(), log=log, errors=errors,
                           theory=curves)

    def _area_curve(self, name: str, given: Any) -> Any:
        """The curve of a theory that is named with a surface; another curve as it was given."""
        if name not in AREA_THEORIES or callable(given) or type(given) in (tuple, list):
            if isinstance(given, HeightMap):
                raise _a.wrong("theory", repr(name), f"{', '.join(AREA_THEORIES)} of a height map")
            return given
        text = self.scene.get("text", "")
        modulus, both, ratios = (numbers_of(text, title) for title in (
            "contact_modulus", "elastic_modulus", "poisson_ratio"))
        if not modulus and len(both) == len(ratios) == 2:
            modulus = [1.0 / sum((1.0 - nu**2) / one for nu, one in zip(ratios, both))]
        if "nominal_pressure" not in self.states or not modulus:
            raise _a.wrong("theory", f"{name!r} for a scene " + (
                "that states no moduli" if "nominal_pressure" in self.states else
                "without a nominal area"), "(x, y) or a function")
        pressures = needed("numpy", "theory", "a theory").unique(self.states["nominal_pressure"])
        pressures = pressures[pressures > 0.0]
        return pressures, area_fraction(name, given, modulus[0], pressures)

    def _control(self) -> str:
        """The prescribed quantity of the loading; empty where the scene does not state it."""
        found = re.search(r"\bcontrol\s*=\s*['\"](\w+)", self.scene.get("text", ""))
        return found[1].lower() if found else ""

    def plot_contacts(self, position: int = 1, state: int | None = None, ax: Axes | None = None, *,
                      step: int = -1) -> Axes:
        """Draw the contacts in plan, coloured by pressure: circles with the area of the contacts of
        asperities; of a height map the pressure where fields were kept, otherwise the centres of
        the contact patches. `position`, `state` and `step` as for `fields`.
        """
        step = self._step(position, step, state)
        table = self.contacts
        if "samples" in table and self._keeps(position, step):
            return self.fields(position, step=step).plot("pressure", ax)
        rows = (table["position"] == position) & (table["step"] == step) & (table["load"] != 0)
        return draw_contacts(table, rows, ax)

    def fields(self, position: int = 1, state: int | None = None, *, step: int = -1) -> Fields:
        """Pressure, gap and displacement on the pixels of a height map or of asperities.

        Args:
            position: A value of the column `position`.
            state: Deprecated, use `step`: the index among the states of the position, from 0.
            step: A value of the column `step` of the states; -1, the default, is the last state.

        Raises:
            IndexError: The results do not have this state, or did not keep it.
            ComputeError: `solve` did not request fields, or the scene has none (`field_spacing`).
        """
        step = self._step(position, step, state)
        if self._kept == _fields.LAST and not self._keeps(position, step):
            raise IndexError(f"step: found {step}, expected -1: the last state alone was kept; "
                             "solve(..., fields='all') keeps all")
        if (position, step) not in self._fields:
            if self._outcome is None:
                raise ComputeError("no fields: expected solve(..., fields=True) of a height map "
                                   "on its pixels, or of a scene with field_spacing in surfaces")
            found = _c.call("fields", self._outcome, int(position), step).checked()
            self._fields[position, step] = _fields.Fields(found, int(position), step)
        return self._fields[position, step]

    def stress(self, depths: Any, position: int = 1, *, step: int = -1,
               body: str = "lower") -> Stress:
        """Stress in the lower or the upper body below the pixels of `fields`, by pressures and
        tractions.

        `depths` are one or several, 0 or more; `position` and `step` as for `fields`. A scene
        without Poisson's ratio is a ComputeError.

        Examples:
            >>> import numpy as np
            >>> x = np.linspace(-0.2, 0.2, 65)
            >>> results = asperity.solve({
            ...     "surfaces": {"upper": "plane", "lower": asperity.HeightMap(
            ...         -(x[:, None]**2 + x**2) / 2, x[1] - x[0])},
            ...     "material": {"elastic_modulus": (1e3, 1e3), "poisson_ratio": (0.3, 0.3)},
            ...     "loading": {"control": "load", "value": 0.6}}, fields=True)
            >>> stress = results.stress(np.linspace(0.02, 0.1, 17))
            >>> value, depth, _, _ = stress.largest("von_mises")
            >>> print(f"{value / results.fields().pressure.max():.2f} {depth:.2f}")
            0.62 0.05
        """
        library: Any = needed("numpy", "stress", "stresses")
        fields = self.fields(position, step=step)
        if body not in SIDES:
            raise _a.wrong("body", repr(body), "'upper' or 'lower'")
        at = library.atleast_1d(library.asarray(depths))
        if not (at.ndim == 1 and at.size > 0 and at.dtype.kind in "iuf" and (at >= 0).all()):
            raise _a.wrong("depths", _a.shown(depths), "one or several numbers of 0 or more")
        side = SIDES.index(body)
        arrays = [library.ascontiguousarray(fields.pressure, float)] + [
            library.ascontiguousarray(fields[name]) * (1 - 2 * (side == 0)) for name in fields
            if name.startswith("traction")]
        arrays += [library.zeros_like(arrays[0])] * (len(arrays) == 2)
        return Stress(fields, at, stresses(self._body(fields, side), fields.shape, at, arrays))

    def _body(self, fields: Fields, side: int) -> _c.Body:
        """The upper (0) or lower (1) body of the scene under the pixels of fields."""
        text, edges = self.scene.get("text", ""), fields.periodic
        found = {name: numbers_of(text, name) for name in MATERIAL}
        if not found["poisson_ratio"]:
            raise ComputeError("stress needs poisson_ratio in &material: found " + (
                "contact_modulus in its place" if "contact_modulus" in text else "none"))
        if edges is None:
            raise ComputeError("no stress of fields in a file of --fields, which has no map_edge: "
                               "expected those of solve(...) or Results.save")
        bases, layers = (tuple((found[name] or [0.0, 0.0])[side] for name in names)
                         for names in (MATERIAL[:2], MATERIAL[2:]))
        modulus, ratio = zip(layers[1:] if layers[0] else bases, bases)
        return _c.Body(fields.shape[1], fields.shape[0], fields.spacing, edges, modulus, ratio,
                       layers[0])

    def pressure_histogram(self, position: int = 1, state: int | None = None, bins: int = 100, *,
                           step: int = -1) -> tuple[Column, Column]:
        """Distribution of the pressure on the pixels in contact: the pressure in the middle of each
        of the `bins` of equal width up to the greatest one, and the area per pressure over the
        measured area, whose integral is the contact area fraction. Other arguments as for `fields`.
        """
        number = _a.whole("bins", bins, "a number from 1", range(1, 2**31))
        return _fields.histogram(self.fields(position, state, step=step), number)

    def _step(self, position: int, step: int = -1, state: int | None = None) -> int:
        """The number of a state, from 1, which a public function was given."""
        number = _a.whole("step", step, "a whole number")
        if state is not None:
            if number != -1:
                raise TypeError("found state and step, expected one of them")
            number = _a.whole("state", state, "a whole number")
            if number >= 0:
                number += 1
                warn_caller(f"state={state} counts from 0: use step={number}, which counts from 1 "
                            "as the column does", DeprecationWarning)
        last = sum(place == position for place in self.states["position"].tolist())
        if not last:
            raise IndexError(f"position: found {position}, expected one of the results")
        if not (1 <= number <= last or -last <= number <= -1):
            raise IndexError(f"step: found {number}, expected 1 to {last}, or -1 for the last")
        return number if number > 0 else last + 1 + number

    def _keeps(self, position: int, step: int) -> bool:
        """Whether the fields of a state were to be kept."""
        return self._kept == _fields.ALL or (
            self._kept == _fields.LAST and step == self._step(position))

    def __str__(self) -> str:
        return self.summary

    def __repr__(self) -> str:
        facts = [counted(len(self.positions), "position"), counted(len(self.states), "state")]
        for name in FACTS if self.states else ():
            value = self.states[name].tolist()[-1]
            if not math.isnan(value):
                facts.append(f"{name} {shown(value)} {self.states.units.get(name, '')}".rstrip())
        if self.warnings:
            facts.append(counted(len(self.warnings), "warning"))
        return f"<asperity.Results: {', '.join(facts)}>"

    def _repr_html_(self) -> str:
        lines = "".join(f"<li>{html.escape(line)}</li>" for line in self.warnings)
        return (f"{self.states._repr_html_()}\n<pre>{html.escape(self.summary)}</pre>"
                + f"\n<ul>{lines}</ul>" * bool(lines))


def load(path: _a.Path, *, fields: _a.Path | Sequence[_a.Path] | None = None) -> Results:
    """Read results that `Results.save` or `asperity solve --json` wrote, to the last bit.

    Args:
        path: Name of the file; one of another kind is an InputError.
        fields: Beside a file of `--json`: the file of `--fields`, of the last state; a list has
            those of all states in their order (`--fields-of all`).
    """
    from . import _files
    made, given = Results.__new__(Results), cast("Any", fields)
    facts, tables, found = _files.read_results(path)
    paths = [] if given is None else given if isinstance(given, (list, tuple)) else [given]
    if found is None:
        places = list(zip(tables["states"]["position"].tolist(), tables["states"]["step"].tolist()))
        if len(paths) > 1 and len(paths) != len(places):
            raise _a.wrong("fields", f"{len(paths)} files", "one for each state")
        found = [_files.read_vti(one, place, tables["states"].units["separation"],
                                 tables["contacts"].units["maximum_pressure"])
                 for one, place in zip(paths, places[len(places) - len(paths):])]
    elif paths:
        raise _a.wrong("fields", repr(fields), "None: a saved file has its fields")
    vars(made).update(tables, _outcome=None, summary=facts["summary"], warnings=facts["warnings"],
                      notes=facts["notes"], scene=facts.get("scene", {}), _kept=_fields.NONE
                      if not found else _fields.LAST if len(found) < len(tables["states"])
                      else _fields.ALL, _fields={(one.position, one.step): one for one in found})
    return made


def numbers_of(text: str, name: str) -> list[float]:
    """The one or two numbers of a name in a scene, `2*0.3` being two; empty where it is absent."""
    number = r"(?:\d+\*)?[-+]?[.\d]+(?:[ed][-+]?\d+)?"
    found = re.search(rf"^[^!\n]*\b{name}\s*=\s*({number}(?:[\s,]+{number})?)", text, re.I | re.M)
    numbers: list[float] = []
    for one in re.split(r"[\s,]+", found[1]) if found else ():
        count, _, value = one.rpartition("*")
        numbers += [float(value.lower().replace("d", "e"))] * int(count or 1)
    return numbers


class Summits(Table):
    """Summits of a height map: columns `x`, `y`, `height` and `radius`, in the unit of the map
    or in the requested one. It can be used as a surface of a scene.

    Attributes:
        statistics: Statistics of the map and its summits by name, in the same unit of length.
        summary: The printed summary.
        notes: Notes on the file of the map.
    """

    def __init__(self, outcome: _c.Outcome, source: Any):
        table = outcome.table(_c.SUMMITS, "summits")
        super().__init__(dict(table), table.units, table.name)
        self.statistics = outcome.facts(_c.STATISTICS)
        self.summary: str = outcome.text(_c.REPORT)
        self.notes: list[str] = outcome.lines(_c.NOTES)
        self._source = source

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the summits in plan on their height map, coloured by height."""
        axes: Axes = new_axes(ax)
        pixels, unit = self._source, self.units.get("x", "")
        with contextlib.suppress(ValueError, TypeError):  # a map that cannot be had is not drawn
            if not isinstance(pixels, HeightMap):
                pixels = map_of_file(pixels, unit=unit or None)
            if (pixels.unit or "") == unit:
                draw_pixels(pixels.heights, pixels.spacing, pixels.unit, axes, cmap="gray")
        drawn = axes.scatter(self["x"], self["y"], c=self["height"], s=14, edgecolors="white",
                             linewidths=0.3)
        in_plan(axes, unit)
        axes.figure.colorbar(drawn, ax=axes, label=self.label("height"))
        return axes

    def __str__(self) -> str:
        return self.summary


def counted(number: int, noun: str) -> str:
    return f"{number} {noun}" + ("" if number == 1 else "s")
