"""Height maps as a user has them: arrays, files, topographies of SurfaceTopography."""

from __future__ import annotations

import importlib
import math
import operator
import os
import re
from collections.abc import Mapping, Sequence
from ctypes import POINTER, byref, c_char_p, c_double, cast
from pathlib import Path
from typing import Any

from . import _arguments as _a
from . import _library as _c
from ._columns import ArrayLike, Axes, NDArray, Table, in_rows, label_of, needed, numpy, shown
from ._conditioning import Conditioning
from ._errors import InputError, Problem, warn_caller
from ._plots import draw_pixels
from ._text_maps import named_columns, read_text, written_header

UNITS = ("m", "mm", "um", "nm", "cm", "in")
METRES = ("1", "1e-3", "1e-6", "1e-9", "1e-2", "0.0254")


def plain_unit(unit: str) -> str:
    """The name of a unit with `u` for a micro sign."""
    return unit.replace("\N{MICRO SIGN}", "u").replace("\N{GREEK SMALL LETTER MU}", "u")


class HeightMap(Conditioning):
    """A height map: heights on a rectangular grid, with their spacing and unit.

    Args:
        heights: Heights of shape (rows, columns), indexed `[row, column]` = `[y, x]` as in a text
            matrix, which are copied. NaN or a mask marks missing pixels. An array of xarray is
            indexed by its dimensions `x` and `y`; its coordinates must have this spacing, and its
            attribute `units` is the unit. A topography of SurfaceTopography has its own spacing,
            unit and edge, and its heights are indexed `[x, y]`.
        spacing: Distance from pixel to pixel along x and y, in the unit of the heights.
        unit: Unit of heights and spacing: `m`, `mm`, `um`, `nm`, `cm` or `in`.
        periodic: Whether the map repeats itself along x and y. Otherwise its edge is free.

    Attributes:
        heights: The heights, read-only; without numpy a sequence of rows.
        is_profile: Whether it is a profile: a strip along y of the width 1, so that a load is a
            load per length (`HeightMap.profile`).
        notes: Notes on the file that it was read from, and what methods have done to the heights.

    Examples:
        >>> tilted = asperity.HeightMap([[0, 1, 2], [0, 1, 2], [0, 1, 2]], spacing=0.5, unit="um")
        >>> tilted
        <asperity.HeightMap of 3 x 3 pixels: 1.5 x 1.5 um, heights 0 to 2 um, free>
    """

    is_profile: bool = False

    def __init__(self, heights: ArrayLike | Sequence[Sequence[float]],
                 spacing: float | Sequence[float] | None = None, unit: str | None = None,
                 periodic: bool = False):
        source: Any = heights
        if is_topography(source):
            source = map_of_topography("heights", source)
            spacing = source.spacing if spacing is None else spacing
            unit, periodic = agreed_unit("unit", unit, source.unit), periodic or source.periodic
        if isinstance(source, HeightMap):
            self.is_profile, source = source.is_profile, source.heights
        self.spacing: tuple[float, float] = _a.pair("spacing", spacing)
        source, _, own_unit = in_order("heights", source, self.spacing)
        unit = agreed_unit("unit", unit, own_unit)
        self._cells = _a.doubles("heights", source, 2, True)
        self.shape: tuple[int, int] = (self._cells.rows, self._cells.columns)
        self.notes: list[str] = []
        if not all(1e-30 <= step <= 1e30 for step in self.spacing):
            raise _a.wrong("spacing", " x ".join(map(shown, self.spacing)),
                           "lengths from 1e-30 to 1e30")
        self.unit: str | None = None if unit is None else plain_unit(_a.word("unit", unit).decode())
        if self.unit not in (None, *UNITS):
            raise _a.wrong("unit", repr(unit), f"one of {', '.join(UNITS)}, or None")
        self.periodic: bool = _a.flag("periodic", periodic)

    @classmethod
    def of(cls, topography: Any) -> HeightMap:
        """The height map of a topography of SurfaceTopography; of a line scan the profile."""
        if not is_topography(topography):
            raise _a.wrong_type("topography", topography, "a topography of SurfaceTopography")
        return map_of_topography("topography", topography)

    @classmethod
    def profile(cls, heights: ArrayLike | Sequence[float], spacing: float,
                unit: str | None = None, periodic: bool = False) -> HeightMap:
        """A profile along x, with its spacing, unit and edge, as a body in plane strain: three
        equal rows that repeat themselves along y, 1 unit of length wide in all, so that a load is a
        load per length, an area a contact width. A free profile has `map_edge = 'free',
        'periodic'`.

        Examples:
            >>> places = [0.01 * i - 1.0 for i in range(201)]
            >>> cylinder = asperity.HeightMap.profile([-x**2 / 20 for x in places], 0.01)
            >>> found = asperity.solve({
            ...     "surfaces": {"upper": "plane", "lower": cylinder},
            ...     "material": {"contact_modulus": 1e3},
            ...     "loading": {"control": "load", "value": 10.0}}).states
            >>> print(f"{found['area'][-1]:.3f}")  # 2 sqrt(4 P R/(pi E*)) = 0.714
            0.714
        """
        row = list(_a.doubles("heights", heights))
        made = cls([row] * 3, (_a.number("spacing", spacing), 1.0 / 3.0), unit, periodic)
        made.is_profile = True
        return made

    @property
    def heights(self) -> NDArray[Any]:
        return in_rows(self._cells, self.shape)

    @property
    def sizes(self) -> tuple[float, float]:
        """Lengths of the map along x and y: number of pixels times spacing."""
        return self.shape[1] * self.spacing[0], self.shape[0] * self.spacing[1]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return needed("numpy", "numpy", "an array").array(  # type: ignore[no-any-return]
            self.heights, dtype=dtype)

    def write(self, path: _a.Path) -> None:
        """Write the map to a file: `.sdf` (surface data, ISO 25178-71, in metres; needs a unit),
        `.npy` (the heights alone) or `.txt` (a matrix). `.sdf` and `.txt` keep spacing and edge,
        `.txt` the unit. A file that cannot be written is a ComputeError."""
        written = _c.call("write_map", byref(self._struct()), _a.path("path", path)).checked()
        for note in written.lines(_c.NOTES):
            warn_caller(note, UserWarning)

    def power_spectrum(self, kind: str = "iso", level: str | None = None) -> Table:
        """Power spectral density of the heights (`docs/reference/height-maps.md`).

        The table has `q`, the wave number, 2 pi over the wavelength; `c_iso`, length to the power
        4, or `c_1d`, length to the power 3; and `number` of wave vectors or lines averaged. A free
        map has a Hann window; a map with missing pixels is refused.

        Args:
            kind: `iso`: averaged over rings of equal wave number. `x`, `y`: over lines along them.
            level: Subtract the least-squares `plane` (default of a free map), the `mean` (of a
                periodic one) or `none`.
        """
        if kind not in _c.SPECTRA:
            raise _a.wrong("kind", repr(kind), "'iso', 'x' or 'y'")
        found = _c.call("power_spectrum", byref(self._struct()),
                        _a.optional_word("level", level)).checked()
        return found.table(_c.SPECTRA[kind], "wave numbers")

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the heights in plan on axes of matplotlib, new ones without `ax`."""
        return draw_pixels(self.heights, self.spacing, self.unit, ax,
                           label=label_of("height", self.unit))

    def _struct(self) -> Any:
        is_strip = self.is_profile and not self.periodic
        return struct(self._cells, self.spacing, self.unit, -1 if is_strip else int(self.periodic))

    def __reduce__(self) -> Any:
        return HeightMap, (self.heights, self.spacing, self.unit, self.periodic), {
            "notes": self.notes, "is_profile": self.is_profile}

    def __repr__(self) -> str:
        rows = f"a profile of {self.shape[1]}" if self.is_profile else \
            f"{self.shape[1]} x {self.shape[0]}"
        unit, sizes = f" {self.unit}" if self.unit else "", " x ".join(map(shown, self.sizes))
        known = [value for value in self._cells if value == value]
        missing = len(self._cells) - len(known)
        return f"<asperity.HeightMap of {rows} pixels: {sizes}{unit}, heights " \
               f"{min(known, default=math.nan):.6g} to {max(known, default=math.nan):.6g}{unit}, " \
               f"{'periodic' if self.periodic else 'free'}" + (
                   f", {missing} pixels missing>" if missing else ">")


def struct(cells: Any, spacing: tuple[float, float], unit: str | None, periodic: int) -> Any:
    """A height map for the library. periodic: -1 where that is not known."""
    made = _c.Map(cells.columns, cells.rows, cast(cells, POINTER(c_double)),
                  (c_double * 2)(*spacing), c_char_p(unit.encode() if unit else None), periodic)
    made.cells = cells
    return made


def map_of(name: str, value: Any, spacing: Any = None) -> Any | None:
    """The height map for the library that a value is: a HeightMap, a topography, a matrix of
    numbers; None for what is none of them. `spacing` is that of a matrix, which is given to the
    library beside it; None: there is none, and coordinates of the matrix are taken."""
    if isinstance(value, HeightMap):
        return value._struct()
    if is_topography(value):
        return map_of_topography(name, value)._struct()
    if _a.is_text(value) or _a.columns_of(value) is not None:
        return None
    dimensions = getattr(value, "ndim", None)
    if dimensions is None and isinstance(value, Sequence) and len(value) > 0:
        dimensions = 1 + (isinstance(value[0], Sequence) and not _a.is_text(value[0]))
    if dimensions is None or dimensions < 2:
        return None
    value, steps, unit = in_order(name, value, spacing)
    return struct(_a.doubles(name, value, 2, True), steps, unit, -1)


def in_order(name: str, value: Any,
             spacing: Any = None) -> tuple[Any, tuple[float, float], str | None]:
    """Heights indexed `[y, x]`, the spacing of their coordinates, 0 without, and their unit: of an
    array with named dimensions as those of xarray. Coordinates must have the spacing that is given;
    heights and coordinates must have one unit."""
    dims, coords = getattr(value, "dims", None), getattr(value, "coords", None)
    if not isinstance(dims, tuple) or len(dims) != 2 or coords is None:
        return value, (0.0, 0.0), None
    unit = None
    for one in (value, *(coords[dim] for dim in dims if dim in coords)):
        unit = agreed_unit(name, unit, getattr(one, "attrs", {}).get("units") or None)
    _a.refuse_unit(name, getattr(value, "data", None))
    first, second = (str(one).lower() for one in dims)
    if first == "x" or second == "y":
        value, dims = value.T, dims[::-1]
    found = [0.0, 0.0]
    for axis, dim in enumerate(reversed(dims)):
        if dim not in coords:
            continue
        places = _a.doubles(f"{name}.{dim}", coords[dim].values)
        step = (places[-1] - places[0]) / max(1, len(places) - 1)
        if not step > 0.0 or any(abs(place - places[0] - number * step) > 1e-3 * step
                                 for number, place in enumerate(places)):
            raise _a.wrong(f"{name}.{dim}", "coordinates with unequal or no positive steps",
                           "equal steps, ascending: sortby and interp of xarray make them")
        if spacing is None:
            found[axis] = step
        elif abs(step - spacing[axis]) > 1e-6 * step:
            raise _a.wrong(f"{name}.{dim}", f"coordinates with the step {shown(step)}",
                           f"the spacing {shown(spacing[axis])}, or none")
    if any(found) and not all(found):
        raise _a.wrong(name, "coordinates of one dimension", "those of both, or a spacing")
    return value, (found[0], found[1]), unit


def agreed_unit(name: str, unit: str | None, other: str | None) -> str | None:
    """The one unit of two, of which either may be unknown."""
    if other is None or unit is None:
        return other if unit is None else unit
    if plain_unit(str(unit)) == plain_unit(str(other)):
        return unit
    raise _a.wrong(name, f"{unit} and {other}", "one unit for heights and places")


def is_topography(value: Any) -> bool:
    """Whether a value has heights, sizes and a unit as a topography of SurfaceTopography has."""
    return callable(getattr(value, "heights", None)) and hasattr(value, "physical_sizes")


def map_of_topography(name: str, topography: Any, rows_first: bool = False) -> HeightMap:
    """The height map of a topography, whose heights are indexed `[x, y]`; of a plain array that
    was read as one `[y, x]`."""
    unit = getattr(topography, "unit", None) or None
    if unit is not None and plain_unit(unit) not in UNITS and hasattr(topography, "to_unit"):
        topography, unit = topography.to_unit("nm"), "nm"
    heights, sizes = topography.heights(), topography.physical_sizes
    periodic = bool(getattr(topography, "is_periodic", False))
    if getattr(heights, "ndim", 0) == 1 and sizes is not None and getattr(
            topography, "is_uniform", False):
        return HeightMap.profile(needed("numpy", "maps", "a topography").ma.filled(
            heights.astype(float), math.nan), sizes[0] / len(heights), unit, periodic)
    if getattr(heights, "ndim", 0) != 2 or sizes is None or len(sizes) != 2:
        raise _a.wrong(name, "a topography without two dimensions of known length",
                       "a map with physical_sizes along x and y")
    steps = sizes[0] / heights.shape[0], sizes[1] / heights.shape[1]
    return HeightMap(heights if rows_first else heights.T, steps[::-1] if rows_first else steps,
                     unit, periodic)


def read_map(path: _a.Path, *, spacing: float | Sequence[float] | None = None,
             unit: str | None = None, periodic: bool = False, delimiter: str | None = None,
             decimal: str | None = None, columns: Sequence[str | int] | None = None) -> HeightMap:
    """Read a height map from a file; its `notes` are issued as warnings (`UserWarning`), too. A
    file that cannot be read is an InputError with the reasons of both readers.

    Args:
        path: Surface data (ISO 25178-71, `.sdf`), a matrix of heights as text, lines of `x,y,z`, or
            `.npy`, recognised by content. Where SurfaceTopography is installed, also its other
            formats, and text with a header that it understands.
        spacing: Distance of pixels along x and y, for a file without one, in its unit.
        unit: `m`, `mm`, `um`, `nm`, `cm` or `in`: the map is converted to it. For a file without a
            unit it is the unit of its numbers.
        periodic: Whether the map repeats itself. Not needed where the file has the edge.
        delimiter: Separator of the numbers of a text, one sign; blanks without. With one of
            `delimiter`, `decimal` or `columns` the file is a text, whose comments begin with `#` or
            `%` and whose missing pixels are empty, `NaN` or `BAD`.
        decimal: Decimal sign of a text, `.` or `,`.
        columns: Columns of x, y and height of a full regular grid: names in the first line of the
            text, or numbers from 0 without names. A first line with `x`, `y` and one of `z`,
            `height`, `value`, `elevation` is read without. Other texts are matrices.

    Examples:
        >>> asperity.read_map("data/examples/summits/rough.sdf", unit="um")
        <asperity.HeightMap of 64 x 64 pixels: 32 x 32 um, heights -0.0623152 to 0.0478979 um, free,
         20 pixels missing>
    """
    made = map_of_file(path, spacing, unit, periodic) if delimiter is decimal is columns is None \
        else _map_of_text(os.fsdecode(_a.path("path", path)), spacing, unit, periodic, delimiter,
                          decimal, columns)
    for note in made.notes:
        warn_caller(note, UserWarning)
    return made


def map_of_file(path: _a.Path, spacing: Any = None, unit: str | None = None,
                periodic: bool = False) -> HeightMap:
    """The map of a file, without warnings."""
    coded, is_periodic = _a.path("path", path), _a.flag("periodic", periodic)
    steps = None if spacing is None else _a.pair("spacing", spacing)
    is_known = unit is None or (isinstance(unit, str) and unit in UNITS)
    header = written_header(os.fsdecode(coded)) if is_known and steps is None else None
    if header is not None:
        steps, own, edge = header
        made = map_of_file(path, steps, own or unit, is_periodic or edge == "periodic")
        made.notes = []  # the library does not read comments
        return made if unit is None or made.unit == unit else _in_unit(made, unit)
    try:
        read = _c.call("read_map", coded, None if steps is None else (c_double * 2)(*steps),
                       _a.optional_word("unit", unit)).checked()
    except InputError as refused:
        name = os.fsdecode(coded)
        named = named_columns(name) if Path(name).is_file() else None
        if named is not None:
            return _map_of_text(name, steps, unit, is_periodic, named[0], None, named[1])
        if (unit is None or unit in UNITS) and min(steps or (1.0,)) > 0.0 and Path(name).is_file():
            return _read_other_format(name, steps, unit, is_periodic, refused)
        raise
    return _map_of_outcome(read, is_periodic)


def _map_of_text(path: str, spacing: Any, unit: str | None, periodic: bool,
                 delimiter: str | None, decimal: str | None,
                 columns: Sequence[Any] | None) -> HeightMap:
    """The map of a text whose form is stated."""
    heights, steps = read_text(path, None if spacing is None else _a.pair("spacing", spacing),
                               delimiter, decimal or ".", columns)
    return HeightMap(heights, steps, unit, periodic)


def _in_unit(map: HeightMap, unit: str) -> HeightMap:
    """A map with a unit in another one."""
    from fractions import Fraction  # decimal takes long to import
    own, other = (Fraction(METRES[UNITS.index(str(one))]) for one in (map.unit, unit))
    ratio = float(own / other)
    heights: Any = map.heights * ratio if numpy() else [
        [height * ratio for height in row] for row in map.heights]
    return HeightMap(heights, [step * ratio for step in map.spacing], unit, map.periodic)


def generate_map(specification: _a.Path | Mapping[str, Mapping[str, Any]] | None = None,
                 **names: Any) -> HeightMap:
    """Make a self-affine random height map (`docs/reference/generate.md`).

    The specification is the path of a file with a group `&map`, its groups as a dict of dicts, or
    the names of the group: `pixels`, `spacing`, `hurst` and `rms_height` or `rms_slope` are needed;
    `roll_off`, `cut_off`, `below_roll_off`, `seed`, `periodic` and `unit` are not. Maps of two
    machines agree to 1e-12 of the rms height.
    """
    if specification is not None and names:
        raise TypeError(f"generate_map takes a specification or names: found both, {min(names)}")
    groups, *place = _a.specification_of({"map": names} if specification is None else specification)
    return _map_of_outcome(_c.call("generate_map", *place).checked(groups.named))


def _map_of_outcome(outcome: _c.Outcome, periodic: bool = False) -> HeightMap:
    """The map that a call has returned; periodic where it or the call is."""
    facts, made = outcome.facts(_c.MAP), HeightMap.__new__(HeightMap)
    made._cells = _a.doubles("heights", outcome.table(_c.PIXELS, "pixels")["height"])
    made.shape = made._cells.rows, made._cells.columns = int(facts["rows"]), int(facts["columns"])
    made.spacing = facts["spacing_x"], facts["spacing_y"]
    made.unit = outcome.text(_c.UNIT) or None
    made.periodic = periodic or bool(facts.get("periodic", 0))
    made.notes = outcome.lines(_c.NOTES)
    return made


# Formats of SurfaceTopography whose files the reader of this package knows better: what it refuses
# is refused. Text is read where its header has the size of the map.
OWN_FORMATS = {"xyz", "sdf", "npy"}
# Plain arrays: their rows run along y, as those of `.npy`; SurfaceTopography takes them as [x, y].
ROWS_FIRST = {"npz", "mat", "h5"}
# Bytes by which SurfaceTopography recognises a format.
FIRST_BYTES = 512


def _read_other_format(path: str, spacing: tuple[float, float] | None, unit: str | None,
                       periodic: bool, refused: InputError) -> HeightMap:
    """A map that SurfaceTopography reads; otherwise the reasons of both readers are raised."""
    try:
        library: Any = importlib.import_module("SurfaceTopography.IO")
    except ImportError:
        raise refused from None
    reader = None
    try:
        opened = library.open_topography(path)
        known, channel, reader = opened.format(), opened.default_channel, opened
        # A format without a mark in its file is that of the ending of the name, or none.
        if known in OWN_FORMATS or (known in ("hgt", "nms") and not path.lower().endswith(known)) \
                or (known == "asc" and (channel.physical_sizes is None or
                                        not _has_all_lines(path, channel.nb_grid_pts))):
            raise refused
        given: dict[str, Any] = {}
        if spacing is not None:
            steps = spacing[::-1] if known in ROWS_FIRST else spacing
            given["physical_sizes"] = tuple(map(operator.mul, steps, channel.nb_grid_pts))
        if channel.unit is None and unit is not None:
            given["unit"] = unit
        topography = reader.topography(**given)
        if unit is not None and topography.unit is not None:
            topography = topography.to_unit(unit)
        found = map_of_topography("path", topography, known in ROWS_FIRST)
        found.periodic = found.periodic or periodic
        return found
    except Exception as error:  # of forty readers
        reason = error if reader is not None else _reason_of_format(library, path)
    if reason is None or reason is refused:
        raise refused from None
    text = " ".join(str(reason).split()) or type(reason).__name__
    raise InputError([Problem(path, None, None, f"SurfaceTopography cannot read it: {text}"),
                      *refused.problems[:2]]) from reason


def _reason_of_format(library: Any, path: str) -> Exception | None:
    """Why SurfaceTopography refuses a file that has the ending or the first bytes of one of its
    formats."""
    with open(path, "rb") as file:
        start = file.read(FIRST_BYTES)
    found = None
    for kind in library.readers:
        match, name = kind.can_read(start), kind.format()
        is_named = path.lower().endswith(tuple(f".{one}" for one in kind.file_extensions()))
        if name not in {"asc", *OWN_FORMATS} and (match == library.MagicMatch.YES or (
                is_named and match != library.MagicMatch.NO)):
            try:
                if not library.open_topography(path, name).channels:
                    raise ValueError("found no channel of heights")
            except Exception as error:
                found = error if is_named or found is None else found
    return found


def _has_all_lines(path: str, pixels: Sequence[int]) -> bool:
    """Whether a text has as many lines from its first number on as the map that was read of it, or
    a multiple: SurfaceTopography leaves lines out that it cannot read."""
    text = Path(path).read_text(encoding="utf-8", errors="replace")
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    while lines and not re.match(r"\s*[-+.]*(\d|nan)", lines[0], re.IGNORECASE):
        del lines[0]
    return not re.search(r"\d\.?#", text) and 0 in (len(lines) % one for one in pixels)
