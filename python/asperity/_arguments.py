"""Arguments of Python as the library takes them. Other types are refused by their name.

The ranges of numbers are checked by the library itself, for all languages.
"""

from __future__ import annotations

import contextlib
import operator
import os
import re
import reprlib
from array import array
from collections.abc import Mapping
from ctypes import POINTER, c_double, cast
from typing import Any, TypeAlias

from ._columns import Values, numpy
from ._errors import InputError, Problem, refused
from ._library import Surface

Path: TypeAlias = "str | os.PathLike[str]"

COLUMNS = ("x", "y", "height", "radius")
INT = range(-2**31, 2**31)  #: C's int
A_PATH = "a path"
PLAIN = (bool, int, float, complex, str, bytes, type(None))


def wrong(name: str, found: str, expected: str) -> InputError:
    """The error for a value that is refused."""
    return refused(None, f"{name}: found {found}, expected {expected}")


def wrong_type(name: str, value: Any, expected: str) -> TypeError:
    """The error for a value of a type that is refused."""
    return TypeError(f"{name}: found {shown(value)}, expected {expected}")


def shown(value: Any) -> str:
    """A value for a message; of a large one its type."""
    try:
        return reprlib.repr(value) if isinstance(value, PLAIN) else f"a {type(value).__name__}"
    except ValueError:  # an int of thousands of digits
        return f"a large {type(value).__name__}"


def is_text(value: Any) -> bool:
    return isinstance(value, (str, bytes, os.PathLike))


def path(name: str, value: Any, expected: str = A_PATH) -> bytes:
    """A path, or any other text, as the system has it."""
    try:
        coded = os.fsencode(value)
    except TypeError:
        raise wrong_type(name, value, expected) from None
    except UnicodeEncodeError:
        raise wrong(name, ascii(value), f"{expected} that the system can encode") from None
    if coded == b"" and expected == A_PATH:
        raise wrong(name, "an empty text", expected)
    if b"\0" in coded:
        raise wrong(name, shown(os.fspath(value)), f"{expected} without null characters")
    return coded


def word(name: str, value: Any) -> bytes:
    value = unwrapped(name, value)
    if not isinstance(value, str):
        raise wrong_type(name, value, "a word")
    return path(name, value, "a word")


def optional_word(name: str, value: Any) -> bytes | None:
    return None if value is None else word(name, value)


def unwrapped(name: str, value: Any) -> Any:
    """The value in an array without dimensions or in a numpy scalar; otherwise the value itself."""
    if type(value) in PLAIN:
        return value
    refuse_unit(name, value)
    if getattr(value, "shape", None) != () or not hasattr(value, "item"):
        return value
    refuse_mask(name, value)
    return value.item()


def refuse_unit(name: str, values: Any) -> None:
    """Refuse quantities with a unit, as those of pint and astropy: the unit would be lost."""
    for unit, number in (("units", "magnitude"), ("unit", "to_value")):
        found = str(getattr(values, unit, "")) if hasattr(type(values), number) else ""
        if found not in ("", "dimensionless"):
            raise wrong(name, f"numbers in {found}", "plain numbers in the units of the scene")


def refuse_mask(name: str, values: Any) -> None:
    is_any_masked: Any = getattr(getattr(values, "mask", None), "any", None)
    if is_any_masked is not None and is_any_masked():
        raise wrong(name, "a masked value", "none: leave out what is masked")


def number(name: str, value: Any, expected: str = "a number") -> float:
    value = unwrapped(name, value)
    if isinstance(value, (bool, complex)) or getattr(value, "ndim", None) or not (
            hasattr(type(value), "__float__") or hasattr(type(value), "__index__")):
        raise wrong_type(name, value, expected)
    try:
        return float(value)
    except TypeError:
        raise wrong_type(name, value, expected) from None
    except (OverflowError, ValueError):
        raise wrong(name, shown(value), f"{expected} within the range of a double") from None


def whole(name: str, value: Any, expected: str, within: range = INT) -> int:
    """A whole number in a range, or that C's int can hold."""
    value = unwrapped(name, value)
    try:
        found = operator.index(value)
    except TypeError:
        raise wrong_type(name, value, expected) from None
    if isinstance(value, bool):
        raise wrong_type(name, value, expected)
    if found not in within:
        raise wrong(name, shown(found), expected)
    return found


def flag(name: str, value: Any) -> bool:
    value = unwrapped(name, value)
    if not isinstance(value, int) or value not in (0, 1):
        raise wrong_type(name, value, "True or False")
    return bool(value)


def several(name: str, values: Any, expected: str) -> list[Any]:
    """The members of a sequence, in their order."""
    refuse_mask(name, values)
    if (values is None or is_text(values)
            or isinstance(values, (bytearray, Mapping, set, frozenset))):
        raise wrong_type(name, values, expected)
    try:
        return list(values)
    except TypeError:
        raise wrong_type(name, values, expected) from None


def doubles(name: str, values: Any, dimensions: int = 1, is_copied: bool = False) -> Any:
    """An array of C's doubles, row by row: in the memory of what has a buffer of them, else a copy.
    Of two dimensions, `rows` and `columns` of the result have the shape."""
    expected = ("numbers, an array of one dimension" if dimensions == 1 else
                "heights, an array of two dimensions, [row, column]")
    values = getattr(values, "_values", values) if isinstance(values, Values) else values
    refuse_unit(name, values)
    shape = None
    if hasattr(type(values), "__array__"):
        values, shape = _numpy_doubles(name, values, dimensions, expected)
    elif dimensions == 2:
        rows = several(name, values, expected)
        if not all(hasattr(type(row), "__len__") for row in rows):
            raise wrong(name, f"{len(rows)} numbers in one row", expected)
        rows = [doubles(f"{name}[{i}]", row) for i, row in enumerate(rows)]
        shape = len(rows), len(rows[0]) if rows else 0
        for i, row in enumerate(rows):
            if len(row) != shape[1]:
                raise wrong(f"{name}[{i}]", f"{len(row)} heights",
                            f"{shape[1]}, as many as in the first row")
        values = memoryview(array("d", (value for row in rows for value in row)))
    view: Any = None
    with contextlib.suppress(TypeError):
        view = memoryview(values)
    if isinstance(values, (bytes, bytearray)) or view is None or view.format != "d" or \
            view.ndim != 1 or not view.c_contiguous:
        view = memoryview(_copied(name, values, expected))
    if view.readonly:
        view = memoryview(array("d", bytes(view)))
    found: Any = (c_double * len(view)).from_buffer(view) if len(view) else (c_double * 0)()
    if is_copied:
        found = type(found).from_buffer_copy(found)
    if shape is not None:
        if len(found) == 0:
            raise wrong(name, "no heights", expected)
        found.rows, found.columns = shape
    return found


def _numpy_doubles(name: str, values: Any, dimensions: int,
                   expected: str) -> tuple[Any, tuple[int, int] | None]:
    """The numbers of an array of numpy in one row, and the shape of one of two dimensions."""
    library: Any = numpy()
    if dimensions == 1:
        refuse_mask(name, values)
    elif hasattr(values, "mask"):
        values = library.ma.filled(values.astype(float), library.nan)
    try:
        cells = library.asarray(values)
    except (AttributeError, TypeError, ValueError):
        raise wrong_type(name, values, expected) from None
    if cells.ndim > dimensions or cells.ndim < dimensions == 2:
        raise wrong(name, f"an array of {cells.ndim} dimensions", expected)
    if cells.dtype.kind not in ("fiuO" if dimensions == 1 else "fiu"):
        raise TypeError(f"{name}: found an array of {cells.dtype}, expected {expected}")
    flat = cells.reshape(-1)
    return flat if cells.dtype.kind == "O" else library.require(
        flat, library.float64, ("C", "W", "A")).data, cells.shape if dimensions == 2 else None


def _copied(name: str, values: Any, expected: str) -> array[float]:
    """A copy of numbers of any type."""
    is_single = hasattr(type(values), "__float__") and not hasattr(type(values), "__iter__")
    members = [values] if is_single else several(name, values, expected)
    with contextlib.suppress(OverflowError):
        if set(map(type, members)) <= {float, int}:
            return array("d", members)
    return array("d", [number(f"{name}[{i}]", value) for i, value in enumerate(members)])


def pair(name: str, values: Any) -> tuple[float, float]:
    """Two numbers, along x and y, or one for both."""
    if hasattr(type(values), "__float__") and not hasattr(values, "__len__"):
        value = number(name, values)
        return value, value
    found = doubles(name, values)
    if len(found) != 2:
        raise wrong(name, f"{len(found)} numbers", "one number, or two, along x and y")
    return found[0], found[1]


def columns_of(value: Any) -> list[str] | None:
    """The names of the columns of a table, of whatever kind; None for what is no table."""
    names = getattr(getattr(value, "dtype", None), "names", None)
    if names is None and hasattr(type(value), "keys"):
        names = value.keys()
    return None if names is None else [name for name in names if isinstance(name, str)]


def asperities(name: str, table: Any, known: list[str]) -> Surface:
    """The asperities of a surface for the library, which reads the arrays where they are."""
    missing = [column for column in COLUMNS if column not in known]
    if missing:
        import difflib  # takes long
        near = [(column, match) for column in missing for match in
                difflib.get_close_matches(column, set(known).difference(COLUMNS), 1)]
        raise wrong(name, f"no {', '.join(missing)}", "x, y, height and radius" + "".join(
            f"; did you mean {column!r} by {match!r}?" for column, match in near[:1]))
    x, y, height, radius = (doubles(f"{name}.{column}", table[column]) for column in COLUMNS)
    count = len(x)
    if count == 0 or {len(y), len(height)} != {count} or len(radius) not in (1, count):
        raise wrong(name, f"{count} x, {len(y)} y, {len(height)} heights and {len(radius)} radii",
                    "as many of each, or one radius, and at least one asperity")
    return Surface(count, len(radius), *(cast(cells, POINTER(c_double))
                                         for cells in (x, y, height, radius)))


class Written(str):
    """Values as they stand in a scene file."""


class Groups:
    """Groups as a scene file has them, one a line, and what stands where in it."""

    def __init__(self, kind: str, groups: Mapping[str, Any]):
        self.kind = kind
        self.text = b""
        self._places: list[tuple[str, list[tuple[int, str]]]] = []
        for group, names in groups.items():
            self._check_name(kind, group)
            if not isinstance(names, Mapping):
                raise wrong_type(group, names, "a dict of names and values")
            line, places = f"&{group} ".encode(), []
            for name, value in names.items():
                self._check_name(group, name)
                places.append((len(line) + 1, name))
                line += f"{name} = ".encode() + _values(f"{group}.{name}", value) + b", "
            self.text += line.removesuffix(b", ") + b" /\n"
            self._places.append((group, places))

    @staticmethod
    def _check_name(where: str, name: Any) -> None:
        if not isinstance(name, str):
            raise wrong_type(where, name, "a text as a name")
        if not (name.isascii() and name.isidentifier()):
            raise wrong(where, shown(name), "a name of letters, digits and _")

    def named(self, problem: Problem) -> Problem:
        """A problem with the group and name it is of, in place of a line and column."""
        if problem.file != self.kind or problem.line is None:
            return problem
        text, where = problem.text, self.kind
        if problem.line <= len(self._places):
            where, places = self._places[problem.line - 1]
            names = [name for column, name in places if column <= (problem.column or 0)]
            other = re.search(r"&(\w+)", text)
            if names:
                text = text.removeprefix(f"{names[-1].lower()}: ")
                where = f"{where}.{names[-1]}"
            elif other:
                where = other[1]
                text = text.removeprefix(f"&{where} ")
        return Problem(None, None, None, f"{where}: {text}")


def specification_of(value: Any) -> tuple[Groups, bytes | None, bytes | None]:
    """The groups of a specification, and its path or its text."""
    groups = Groups("specification", value if isinstance(value, Mapping) else {})
    return (groups, None, groups.text) if isinstance(value, Mapping) else (
        groups, path("specification", value, "a path, or a dict of groups"), None)


def _values(name: str, value: Any) -> bytes:
    """The values of a name as a scene file has them."""
    if isinstance(value, Written):
        return value.encode("utf-8", "surrogateescape")
    if name == "effects.interaction" and value is True:
        return b"'auto'"
    is_single = not hasattr(type(value), "__iter__") or getattr(value, "shape", None) == ()
    if is_text(value) or is_single:
        return _value(name, value)
    expected = "a number, a text, or several in one row"
    return b", ".join(_value(name, one) for one in several(name, value, expected))


def _value(name: str, value: Any) -> bytes:
    value = unwrapped(name, value)
    if is_text(value):
        coded = path(name, value, "a text")
        if re.search(rb"[\0-\x1f\x7f]", coded):
            raise wrong(name, shown(os.fsdecode(coded)), "a text without control characters")
        return b"'" + coded.replace(b"'", b"''") + b"'"
    if isinstance(value, bool):
        return str(value).encode()
    if not hasattr(value, "shape") and hasattr(type(value), "__index__") and abs(value) < 10**18:
        return str(operator.index(value)).encode()
    return repr(number(name, value, "a number or a text")).encode()
