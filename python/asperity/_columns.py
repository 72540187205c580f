"""Tables of results: columns by name, as numpy arrays where numpy is installed."""

from __future__ import annotations

import functools
import html
import importlib
import operator
import warnings
from collections.abc import Callable, Iterator, Sequence
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeAlias, cast

# Types of libraries that are imported when they are used.
if TYPE_CHECKING:
    import pandas as pandas  # type: ignore[import-untyped, unused-ignore]
    import xarray as xarray
    from matplotlib.axes import Axes as Axes
    from numpy.typing import ArrayLike as ArrayLike
    from numpy.typing import NDArray as NDArray

    #: A numpy array, read-only; where numpy is not installed a `Values`.
    Column: TypeAlias = NDArray[Any]
else:
    pandas = xarray = Axes = ArrayLike = NDArray = Column = Any

# Names of columns in version 0.2.0, and their names since.
EARLIER_NAMES = {"approach": "separation", "decrease": "compression"}
# Rows of a table that a notebook shows, and columns that `repr` lists.
SHOWN_ROWS, SHOWN_COLUMNS = 12, 8
SHOWN_VALUES = 6


@functools.cache
def numpy() -> ModuleType | None:
    """numpy, where it is installed."""
    try:
        return importlib.import_module("numpy")
    except ImportError:
        return None


def needed(module: str, extra: str, what: str) -> Any:
    """A module of an optional extra."""
    try:
        return importlib.import_module(module)
    except ImportError:
        name = module.partition(".")[0]
        raise ImportError(f"{what} needs {name}: pip install {name}, or asperity[{extra}]",
                          name=name) from None


class Lazy:
    """A module of an optional extra, which is imported when it is first used."""

    def __init__(self, module: str, extra: str, what: str):
        self._module = module, extra, what

    def __getattr__(self, name: str) -> Any:
        return getattr(needed(*self._module), name)


class Values(Sequence[Any]):
    """The values of a column where numpy is not installed.

    It indexes, slices, iterates and has a length. A comparison with a number gives a list of bools,
    one for each value; a comparison with a sequence compares as lists do. It is read-only.
    """

    def __init__(self, values: Sequence[Any]):
        self._values = values

    def __getitem__(self, place: Any) -> Any:
        return Values(self._values[place]) if isinstance(place, slice) else self._values[place]

    def __len__(self) -> int:
        return len(self._values)

    def tolist(self) -> list[Any]:
        """The values as a list."""
        return list(self._values)

    def _compared(self, other: Any, how: Callable[[Any, Any], bool]) -> Any:
        if isinstance(other, (int, float)):
            return [how(value, other) for value in self._values]
        if isinstance(other, Sequence) and not isinstance(other, str):
            return how(self.tolist(), list(other))
        return NotImplemented

    __eq__ = functools.partialmethod(_compared, how=operator.eq)
    __lt__ = functools.partialmethod(_compared, how=operator.lt)
    __le__ = functools.partialmethod(_compared, how=operator.le)
    __gt__ = functools.partialmethod(_compared, how=operator.gt)
    __ge__ = functools.partialmethod(_compared, how=operator.ge)
    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> Any:
        return Values, (self.tolist(),)

    def __repr__(self) -> str:
        count, half = len(self), SHOWN_VALUES // 2
        if count <= SHOWN_VALUES:
            return repr(self.tolist())
        ends = [", ".join(map(repr, part)) for part in (self._values[:half], self._values[-half:])]
        return f"[{ends[0]}, ..., {ends[1]}] ({count} values)"


@functools.cache
def _column_type() -> Any:
    """The type of a column: its values are numbers of Python, which compare to True or False, and
    that of one row is the number of `float`."""
    library = needed("numpy", "numpy", "an array")

    class array(library.ndarray):  # type: ignore[misc, name-defined]
        def __float__(self) -> float:
            return float(self.item())

        def __int__(self) -> int:
            return int(self.item())

        def __getitem__(self, place: Any) -> Any:
            found = super().__getitem__(place)
            return found.item() if isinstance(found, library.generic) else found

        def __array_wrap__(self, made: Any, *_: Any) -> Any:
            return made if made.ndim else made[()]

        def __reduce__(self) -> Any:
            return column, (library.asarray(self),)
    return array


def column(values: Any) -> Column:
    """A column of a read-only `memoryview` of numbers, or of a list of words."""
    library = numpy()
    if library is None:
        return cast("Column", Values(values))
    array = library.asarray(values)
    if not len(array) and isinstance(values, list):
        array = library.empty(0, dtype="U1")
    array = array.view(_column_type())
    array.flags.writeable = False
    return cast("Column", array)


def in_rows(cells: Any, shape: tuple[int, int], is_flag: bool = False) -> NDArray[Any]:
    """The values of a column by row and column of a map."""
    library: Any = numpy()
    if library is None:
        values = [bool(value) for value in cells] if is_flag else cells
        return cast("Any", Values([Values(values[i:i + shape[1]])  # type: ignore[no-any-return]
                                   for i in range(0, len(values), shape[1])]))
    array: NDArray[Any] = library.asarray(cells, dtype=bool if is_flag else None).reshape(shape)
    array.flags.writeable = False
    return array


class _Count(int):
    """A number of rows, which gives the rows when it is called."""

    table: Table

    def __call__(self) -> Iterator[dict[str, Any]]:
        names = list(self.table)
        cells = [values.tolist() for values in self.table.values()]
        return (dict(zip(names, row)) for row in zip(*cells))


class Table(dict[str, "Column"]):
    """A table: columns by name, in the order of the CSV files. `len` is the number of rows.

    Columns of numbers are read-only numpy arrays of doubles or of whole numbers (yes and no are
    1 and 0) that use the memory of the library; a value that was not computed is NaN. Words are
    arrays of `str`. Where numpy is not installed, columns are sequences that index, slice and
    compare (`asperity.Values`).

    Attributes:
        name: Kind of the rows, for instance `states`.
        units: The unit of each column, "" where it is not known or has none.

    Examples:
        >>> len(asperity.solve("data/examples/one_pair.scene").contacts)
        1
    """

    def __init__(self, columns: dict[str, Column] | None = None,
                 units: dict[str, str] | None = None, name: str = "rows"):
        super().__init__(columns or {})
        self.units: dict[str, str] = units or {}
        self.name = name

    @property
    def rows(self) -> _Count:
        """Iterator over the rows, each a dict from the name of a column to its value; without
        parentheses the number of rows."""
        found = _Count(len(self))
        found.table = self
        return found

    def __len__(self) -> int:
        return len(next(iter(self.values()), ()))

    def __missing__(self, name: str) -> Column:
        if (now := EARLIER_NAMES.get(name)) in self:
            warnings.warn(f"column {name!r} is now {now!r}", DeprecationWarning, stacklevel=2)
            return self[cast("str", now)]
        import difflib  # takes long
        near = difflib.get_close_matches(str(name), list(self), 1)
        raise KeyError(f"no column {name!r} in the table of {self.name}" +
                       (f"; did you mean {near[0]!r}?" if near else f": {', '.join(self)}"))

    def __eq__(self, other: object) -> bool:
        """Whether both have the same columns with the same bits: NaN equals NaN."""
        return isinstance(other, Table) and list(self) == list(other) and all(
            repr(mine.tolist()) == repr(their.tolist())
            for mine, their in zip(self.values(), other.values()))

    def __ne__(self, other: object) -> bool:
        return not self == other

    __hash__ = None

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """A numpy array of the rows, whose fields have the names of the columns."""
        array: NDArray[Any] = needed("numpy", "numpy", "an array").empty(
            len(self), dtype=[(name, values.dtype) for name, values in self.items()])
        for name, values in self.items():
            array[name] = values
        return array if dtype is None else array.astype(dtype)

    def to_dict(self) -> dict[str, list[Any]]:
        """The columns as lists of Python numbers and words."""
        return {name: values.tolist() for name, values in self.items()}

    def to_pandas(self) -> pandas.DataFrame:
        """The table as a `pandas.DataFrame`; `attrs["units"]` has the units."""
        frame: pandas.DataFrame = needed("pandas", "pandas", "a DataFrame").DataFrame(self)
        frame.attrs["units"] = dict(self.units)
        return frame

    def __reduce__(self) -> Any:
        return _restored, (type(self), dict(self), dict(vars(self)))

    def label(self, name: str) -> str:
        """The name of a column in words, with its unit in brackets: for an axis of a plot."""
        return label_of(name, self.units.get(name))

    def plot_columns(self, x: str, y: str, ax: Axes | None = None, **style: Any) -> Axes:
        """Draw a column against another one, with their units at the axes; `style` is that of
        `plot` of matplotlib."""
        from ._plots import new_axes
        axes: Axes = new_axes(ax)
        axes.plot(self[x], self[y], **style)
        axes.set(xlabel=self.label(x), ylabel=self.label(y))
        return axes

    def __repr__(self) -> str:
        names = list(self)
        cut = ", ..." * (len(names) > SHOWN_COLUMNS)
        return f"<asperity.{type(self).__name__} of {len(self)} {self.name}: " \
               f"{len(names)} columns {', '.join(names[:SHOWN_COLUMNS])}{cut}>"

    def _repr_html_(self) -> str:
        """The first and last rows, for a notebook."""
        count, half = len(self), SHOWN_ROWS // 2
        places = [*range(count)] if count <= SHOWN_ROWS else [
            *range(half), -1, *range(count - half, count)]
        rows = [["..." if place < 0 else shown(values[place]) for values in self.values()]
                for place in places]
        lines = [_row("th", list(self)), *(_row("td", cells) for cells in (
            [self.units.get(name, "") for name in self], *rows))]
        return "\n".join(["<table>", *lines, f"</table>\n<p>{count} {html.escape(self.name)}</p>"])


def _restored(kind: type[Table], columns: dict[str, Column], state: dict[str, Any]) -> Table:
    table: Table = kind.__new__(kind)
    for name, values in columns.items():
        if numpy():
            values.flags.writeable = False
        table[name] = values
    vars(table).update(state)
    return table


def label_of(name: str, unit: str | None) -> str:
    """The name of a quantity in words, with its unit in brackets."""
    return name.replace("_", " ") + (f" ({unit})" if unit else "")


def _row(tag: str, cells: list[str]) -> str:
    return "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"


def shown(value: Any) -> str:
    """A value with six digits."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)
