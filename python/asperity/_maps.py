"""Height maps as a user has them: arrays, files, topographies of SurfaceTopography."""

from __future__ import annotations

import html
import importlib
import typing
from collections.abc import Mapping, Sequence
from ctypes import POINTER, byref, c_char_p, c_double, cast
from typing import TYPE_CHECKING, Any

from . import _arguments as _a
from . import _library as _c
from ._columns import Table, Values, numpy, shown
from ._errors import InputError, Problem

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike, NDArray


UNITS = ("m", "mm", "um", "nm", "cm", "in")


def plain_unit(unit: str) -> str:
    """The name of a unit with `u` for a micro sign."""
    return unit.replace("\N{MICRO SIGN}", "u").replace("\N{GREEK SMALL LETTER MU}", "u")


class HeightMap:
    """A height map: heights on a rectangular grid, with their spacing and unit.

    Parameters
    ----------
    heights : array_like
        Heights of shape (rows, columns), indexed `[row, column]` = `[y, x]` as in a text matrix:
        x grows along a row, y with the row. NaN or a mask marks missing pixels. Without numpy a
        list of lists. The values are copied.
    spacing : float or (float, float)
        Distance from pixel to pixel along x and y, in the unit of the heights.
    unit : str, optional
        Unit of heights and spacing: `m`, `mm`, `um`, `nm`, `cm` or `in`.
    periodic : bool, default False
        Whether the map repeats itself along x and y. Otherwise its edge is free.

    Attributes
    ----------
    heights : numpy.ndarray
        The heights, read-only; without numpy a sequence of rows.
    spacing : (float, float)
    unit : str or None
    periodic : bool

    Raises
    ------
    InputError
        For heights that are no matrix of numbers, or a spacing that is no length.

    Examples
    --------
    >>> import asperity
    >>> tilted = asperity.HeightMap([[0, 1, 2], [0, 1, 2], [0, 1, 2]], spacing=0.5, unit="um")
    >>> tilted
    <asperity.HeightMap of 3 x 3 pixels: 1.5 x 1.5 um, heights 0 to 2 um, free>
    >>> tilted.shape, tilted.spacing
    ((3, 3), (0.5, 0.5))
    """

    def __init__(self, heights: ArrayLike | Sequence[Sequence[float]],
                 spacing: float | Sequence[float], unit: str | None = None,
                 periodic: bool = False):
        source = heights.heights if isinstance(heights, HeightMap) else heights
        self._cells = _own(_a.doubles("heights", source, 2))
        self.shape: tuple[int, int] = (self._cells.rows, self._cells.columns)
        self.spacing: tuple[float, float] = _a.pair("spacing", spacing)
        if not all(1e-30 <= step <= 1e30 for step in self.spacing):
            raise _a.wrong("spacing", shown_pair(self.spacing), "lengths from 1e-30 to 1e30")
        self.unit: str | None = None if unit is None else plain_unit(_a.word("unit", unit).decode())
        if self.unit not in (None, *UNITS):
            raise _a.wrong("unit", repr(unit), f"one of {', '.join(UNITS)}, or None")
        self.periodic: bool = _a.flag("periodic", periodic)

    @property
    def heights(self) -> NDArray[Any]:
        library: Any = numpy()
        if library is not None:
            flat = library.asarray(memoryview(self._cells).toreadonly())
            return typing.cast("NDArray[Any]", flat.reshape(self.shape))
        width = self.shape[1]
        return typing.cast("NDArray[Any]", Values([
            Values(self._cells[i:i + width]) for i in range(0, len(self._cells), width)]))

    @property
    def sizes(self) -> tuple[float, float]:
        """Lengths of the map along x and y: number of pixels times spacing."""
        return self.shape[1] * self.spacing[0], self.shape[0] * self.spacing[1]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        library: Any = numpy()
        array: NDArray[Any] = library.array(self.heights, dtype=dtype)
        return array

    def write(self, path: _a.Path) -> None:
        """Write the map to a file, in a format by the ending of its name.

        Parameters
        ----------
        path : str or os.PathLike
            `.sdf`: surface data (ISO 25178-71), binary, in metres; needs a unit. `.npy`: the
            heights alone. `.txt`: a matrix.

        Raises
        ------
        InputError
            For another ending, or `.sdf` without a unit.
        ComputeError
            When the file cannot be written.
        """
        _c.call("write_map", byref(self._struct()), _a.path("path", path)).checked()

    def power_spectrum(self, kind: str = "iso") -> Table:
        """Power spectral density of the heights (`docs/reference/height-maps.md`).

        The map is levelled first: a free map by its plane, a periodic one by its mean. A free map
        has a Hann window.

        Parameters
        ----------
        kind : {'iso', 'x', 'y'}
            `iso`: of the area, averaged over rings of equal wave number. `x`, `y`: of lines along
            x or y, averaged over all of them.

        Returns
        -------
        Table
            `q`: wave number, 2 pi over the wavelength. `c_iso`, length to the power 4, or `c_1d`,
            length to the power 3. `number`: values averaged, wave vectors or lines.

        Raises
        ------
        InputError
            For a map with missing pixels.

        Examples
        --------
        >>> import asperity
        >>> rough = asperity.generate_map(pixels=64, spacing=1, hurst=0.8, rms_height=1)
        >>> rough.power_spectrum()
        <asperity.Table of 25 wave numbers: 3 columns q, c_iso, number>
        """
        if kind not in _c.SPECTRA:
            raise _a.wrong("kind", repr(kind), "'iso', 'x' or 'y'")
        found = _c.call("power_spectrum", byref(self._struct())).checked()
        return found.table(_c.SPECTRA[kind], "wave numbers")

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the heights in plan.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure otherwise.

        Returns
        -------
        matplotlib.axes.Axes
        """
        from ._plots import draw_map
        return draw_map(self, ax)

    def _struct(self) -> Any:
        return struct(self._cells, self.spacing, self.unit, int(self.periodic))

    def __reduce__(self) -> Any:
        rows = [list(self._cells[i:i + self.shape[1]])
                for i in range(0, len(self._cells), self.shape[1])]
        return HeightMap, (self.heights if numpy() else rows, self.spacing, self.unit,
                           self.periodic)

    def _facts(self) -> list[str]:
        unit = f" {self.unit}" if self.unit else ""
        known = [value for value in self._cells if value == value]
        missing = len(self._cells) - len(known)
        low, high = (min(known), max(known)) if known else (float("nan"), float("nan"))
        facts = [f"{shown_pair(self.sizes)}{unit}", f"heights {low:.6g} to {high:.6g}{unit}",
                 "periodic" if self.periodic else "free"]
        return facts + ([f"{missing} pixels missing"] if missing else [])

    def __repr__(self) -> str:
        return f"<asperity.HeightMap of {self.shape[1]} x {self.shape[0]} pixels: " \
               f"{', '.join(self._facts())}>"

    def _repr_html_(self) -> str:
        return "<p>" + html.escape(repr(self)[1:-1]) + "</p>"


def struct(cells: Any, spacing: tuple[float, float], unit: str | None, periodic: int) -> Any:
    """A height map for the library. periodic: -1 where that is not known."""
    made = _c.Map(cells.columns, cells.rows, cast(cells, POINTER(c_double)),
                  (c_double * 2)(*spacing), c_char_p(unit.encode() if unit else None), periodic)
    made.cells = cells
    return made


def map_of(name: str, value: Any, spacing: tuple[float, float] = (0.0, 0.0)) -> Any | None:
    """The height map for the library that a value is: a HeightMap, a topography, a matrix of
    numbers; None for what is none of them."""
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
    return struct(_own(_a.doubles(name, value, 2)), spacing, None, -1)


def _own(cells: Any) -> Any:
    """A copy of heights in memory of its own."""
    copied: Any = type(cells).from_buffer_copy(cells)
    copied.rows, copied.columns = cells.rows, cells.columns
    return copied


def is_topography(value: Any) -> bool:
    """Whether a value has heights, sizes and a unit as a topography of SurfaceTopography has."""
    return callable(getattr(value, "heights", None)) and hasattr(value, "physical_sizes")


def map_of_topography(name: str, topography: Any) -> HeightMap:
    """The height map of a topography, whose heights are indexed `[x, y]`."""
    unit = getattr(topography, "unit", None) or None
    if unit is not None and plain_unit(unit) not in UNITS and hasattr(topography, "to_unit"):
        topography, unit = topography.to_unit("nm"), "nm"
    heights, sizes = topography.heights(), topography.physical_sizes
    if getattr(heights, "ndim", 0) != 2 or sizes is None or len(sizes) != 2:
        raise _a.wrong(name, "a topography without two dimensions of known length",
                       "a map with physical_sizes along x and y")
    columns, rows = heights.shape
    return HeightMap(heights.T, (sizes[0] / columns, sizes[1] / rows), unit,
                     bool(getattr(topography, "is_periodic", False)))


def read_map(path: _a.Path, *, spacing: float | Sequence[float] | None = None,
             unit: str | None = None, periodic: bool = False) -> HeightMap:
    """Read a height map from a file.

    Parameters
    ----------
    path : str or os.PathLike
        Surface data (ISO 25178-71, `.sdf`), a matrix of heights as text, lines of `x,y,z`, or
        `.npy`, recognised by content. Where SurfaceTopography is installed, all formats that it
        reads.
    spacing : float or (float, float), optional
        Distance of pixels along x and y, for a file without one, in its unit.
    unit : str, optional
        `m`, `mm`, `um`, `nm`, `cm` or `in`: the map is converted to it. For a file without a unit
        it is the unit of its numbers.
    periodic : bool, default False
        Whether the map repeats itself.

    Returns
    -------
    HeightMap

    Raises
    ------
    InputError
        For a file that cannot be read.

    Examples
    --------
    >>> import asperity
    >>> asperity.read_map("data/examples/summits/rough.sdf", unit="um")
    <asperity.HeightMap of 64 x 64 pixels: 32 x 32 um, heights -0.0623152 to 0.0478979 um, free,
     20 pixels missing>
    """
    coded = _a.path("path", path)
    steps = None if spacing is None else (c_double * 2)(*_a.pair("spacing", spacing))
    try:
        read = _c.call("read_map", coded, steps,
                       None if unit is None else _a.word("unit", unit)).checked()
    except InputError:
        found = None if spacing is not None else _read_other_format(path, unit)
        if found is None:
            raise
        return HeightMap(found.heights, found.spacing, found.unit, periodic or found.periodic)
    return _map_of_outcome(read, _a.flag("periodic", periodic))


def generate_map(specification: _a.Path | Mapping[str, Mapping[str, Any]] | None = None,
                 **names: Any) -> HeightMap:
    """Make a self-affine random height map (`docs/reference/generate.md`).

    Parameters
    ----------
    specification : str, os.PathLike or mapping, optional
        The path of a file with a group `&map`, or its groups as a dict of dicts.
    **names
        Without a specification, the names of the group: `pixels`, `spacing`, `hurst` and
        `rms_height` or `rms_slope` are needed; `roll_off`, `cut_off`, `below_roll_off`, `seed`,
        `periodic` and `unit` are not.

    Returns
    -------
    HeightMap
        The same specification gives the same bits on every machine.

    Raises
    ------
    InputError
        For a bad specification or name.
    ComputeError
        Where there is no memory for the map.

    Examples
    --------
    >>> import asperity
    >>> asperity.generate_map(pixels=(256, 128), spacing=0.1, unit="um", hurst=0.8, roll_off=8,
    ...                       rms_slope=0.1, seed=2, periodic=False).shape
    (128, 256)
    """
    place: tuple[bytes | None, bytes | None]
    if specification is None or isinstance(specification, Mapping):
        groups = _a.Groups("specification", {"map": names} if specification is None
                           else specification)
        place = None, groups.text
    else:
        groups = _a.Groups("specification", {})
        place = _a.path("specification", specification, "a path, or a dict of groups"), None
    if specification is not None and names:
        raise TypeError(f"generate_map takes a specification or names: found both, {min(names)}")
    made = _c.call("generate_map", *place).checked(groups.named)
    return _map_of_outcome(made, bool(made.table(_c.MAP, "maps")["periodic"][0]))


def _map_of_outcome(outcome: _c.Outcome, periodic: bool) -> HeightMap:
    """The map that a call has returned."""
    facts = {name: values[0] for name, values in outcome.table(_c.MAP, "maps").items()}
    cells = outcome.table(_c.PIXELS, "pixels")["height"]
    made = HeightMap.__new__(HeightMap)
    made._cells = _a.doubles("heights", cells)
    made._cells.rows, made._cells.columns = int(facts["rows"]), int(facts["columns"])
    made.shape = made._cells.rows, made._cells.columns
    made.spacing = float(facts["spacing_x"]), float(facts["spacing_y"])
    made.unit = outcome.text(_c.UNIT) or None
    made.periodic = periodic
    return made


# Formats of SurfaceTopography that this package reads by itself.
OWN_FORMATS = {"asc", "xyz", "sdf", "npy"}


def _read_other_format(path: Any, unit: str | None) -> HeightMap | None:
    """A map in a format of SurfaceTopography; None where that does not read it."""
    try:
        library: Any = importlib.import_module("SurfaceTopography.IO")
    except ImportError:
        return None
    try:
        found = library.detect_format(path)
    except Exception:  # of forty readers: no format
        return None
    if found in OWN_FORMATS:
        return None
    try:
        topography = library.open_topography(path).topography()
        if unit is not None and topography.unit is not None:
            topography = topography.to_unit(unit)
    except Exception as error:  # of the reader of that format
        raise InputError([Problem(str(path), None, None,
                                  f"SurfaceTopography cannot read it: {error}")]) from error
    return map_of_topography("path", topography)


def shown_pair(values: Sequence[float]) -> str:
    return " x ".join(map(shown, values))
