"""The shared library, as include/asperity.h has it, and what its outcomes become in Python."""

from __future__ import annotations

import ctypes
import os
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping
from ctypes import POINTER, Structure, byref, c_char, c_char_p, c_double, c_int, c_void_p
from pathlib import Path
from typing import NamedTuple

# Of the header.
NOT_COMPUTED, BAD_INPUT = 1, 2
FAILURE, PROBLEMS, WARNINGS, NOTES, REPORT = 1, 2, 3, 4, 5
POSITIONS, STATES, CONTACTS, SUMMITS, STATISTICS, UPPER, LOWER = 1, 2, 3, 4, 5, 6, 7
WORD_LENGTH = 16
# Of the types of columns: bytes of a cell, and its code for `memoryview`; a word is 16 letters.
CELLS = {1: (8, "d"), 2: (4, "i"), 3: (WORD_LENGTH, "c")}


class Surface(Structure):
    _fields_ = [("count", c_int), ("radii", c_int)] + [
        (name, POINTER(c_double)) for name in ("x", "y", "height", "radius")]


class Options(Structure):
    _fields_ = [("arithmetic", c_char_p), ("accuracy", c_double), ("totals_only", c_int),
                ("threads", c_int), ("interrupt", POINTER(c_int))]


class SummitsOptions(Structure):
    _fields_ = [("rule", c_char_p), ("level", c_char_p), ("radius", c_char_p), ("unit", c_char_p),
                ("spacing", c_double * 2), ("despike", c_int)]


class CProblem(Structure):
    _fields_ = [("file", c_char_p), ("line", c_int), ("column", c_int), ("text", c_char_p)]


def _loaded(path: Path) -> ctypes.CDLL:
    """Load the library with idle threads that sleep, unless the environment sets their policy.
    The OpenMP runtime reads these settings when it is loaded."""
    settings = {"OMP_WAIT_POLICY": "passive", "GOMP_SPINCOUNT": "2000"}
    if settings.keys() & os.environ.keys():
        return ctypes.CDLL(str(path))
    os.environ.update(settings)
    try:
        return ctypes.CDLL(str(path))
    finally:
        for name in settings:
            del os.environ[name]


_C = _loaded(Path(__file__).with_name("libasperity.so"))
for _name, _result, *_arguments in (
        ("get_version", c_char_p),
        ("read_scene", c_void_p, c_char_p),
        ("build_scene", c_void_p, c_char_p, POINTER(Surface), POINTER(Surface)),
        ("solve_scene", c_void_p, c_void_p, POINTER(Options)),
        ("make_report", c_void_p, c_char_p, c_char_p, POINTER(c_int), c_int),
        ("summits", c_void_p, c_char_p, POINTER(SummitsOptions)),
        ("periodic_summits", c_void_p, c_char_p, POINTER(SummitsOptions)),
        ("generate", c_void_p, c_char_p, c_char_p, c_int),
        ("status", c_int, c_void_p),
        ("text", c_char_p, c_void_p, c_int),
        ("problem_count", c_int, c_void_p),
        ("get_problem", None, c_void_p, c_int, POINTER(CProblem)),
        ("rows", c_int, c_void_p, c_int),
        ("columns", c_int, c_void_p, c_int),
        ("column_name", c_char_p, c_void_p, c_int, c_int),
        ("column_type", c_int, c_void_p, c_int, c_int),
        ("column", c_void_p, c_void_p, c_int, c_int),
        ("free", None, c_void_p)):
    _function = getattr(_C, f"asperity_{_name}")
    _function.restype, _function.argtypes = _result, _arguments

VERSION = _C.asperity_get_version().decode()


class Problem(NamedTuple):
    """One thing that is wrong with an input."""

    file: str | None    #: as it was named; None where the problem is of no file
    line: int | None    #: from 1; None where it has none
    column: int | None  #: in bytes, from 1; None where it has none
    text: str           #: what is wrong, what was found, what is expected

    def __str__(self) -> str:
        place = [str(part) for part in self[:3] if part is not None]
        return ": ".join([":".join(place), self.text] if place else [self.text])


class InputError(ValueError):
    """The input is bad. `problems` has all that is wrong with it, in the order found."""

    def __init__(self, problems: list[Problem]):
        super().__init__(problems)
        self.problems = problems

    def __str__(self) -> str:
        return "\n".join(map(str, self.problems))


class ComputeError(RuntimeError):
    """A valid scene that cannot be solved; the text gives the reason."""


class TheoryWarning(UserWarning):
    """A result outside the range of validity of a theory."""


class Outcome:
    """Result of a call of the library, the only owner of its address. Everything that is read from
    it is a copy."""

    _free = staticmethod(_C.asperity_free)

    def __init__(self, handle: int | None):
        self.handle = handle

    def __del__(self):
        self._free(self.handle)

    def __reduce__(self):
        raise TypeError("an outcome of the library cannot be copied")

    def text(self, which: int) -> str:
        return _C.asperity_text(self.handle, which).decode(errors="replace")

    def lines(self, which: int) -> list[str]:
        return self.text(which).splitlines()

    def problems(self) -> list[Problem]:
        found = []
        for number in range(_C.asperity_problem_count(self.handle)):
            one = CProblem()
            _C.asperity_get_problem(self.handle, number, byref(one))
            found.append(Problem(one.file.decode(errors="replace") or None, one.line or None,
                                 one.column or None, one.text.decode(errors="replace")))
        return found

    def columns(self, which: int) -> dict[str, tuple[str, bytes]]:
        """The columns of a table by name: the code of their values, and the values."""
        rows, found = _C.asperity_rows(self.handle, which), {}
        for number in range(_C.asperity_columns(self.handle, which)):
            place = self.handle, which, number
            size, code = CELLS[_C.asperity_column_type(*place)]
            cells = (c_char * (size * rows)).from_address(_C.asperity_column(*place)).raw \
                if rows else b""
            found[_C.asperity_column_name(*place).decode()] = code, cells
        return found

    def checked(self, named: Callable[[Problem], Problem] = lambda problem: problem) -> Outcome:
        """Itself after a success; its warnings become Python warnings. `named` gives the place of
        a problem the name that the caller used."""
        status = _C.asperity_status(self.handle)
        if status == BAD_INPUT:
            raise InputError([named(problem) for problem in self.problems()])
        if status == NOT_COMPUTED:
            failure = self.text(FAILURE)
            raise MemoryError(failure) if self.handle is None else ComputeError(failure)
        for line in self.lines(WARNINGS):
            # Of whoever called the function of the package that called this.
            warnings.warn(line, TheoryWarning, stacklevel=3)
        return self


# Names of columns in version 0.2.0, and their names since.
EARLIER_NAMES = {"approach": "separation", "decrease": "compression"}


class Table(Mapping):
    """Columns by name, in the order of the CSV files, all as long as `rows`.

    A column of numbers is a read-only `memoryview`, of doubles or of whole numbers (yes and no are
    1 and 0): it indexes, iterates and has a length, and numpy takes it without a copy, as in
    `numpy.asarray(table["load"])`. A value that was not computed is NaN. A column of words is
    a tuple of `str`. A table can be copied and pickled.
    """

    def __init__(self, columns: dict[str, tuple[str, bytes]]):
        self._columns = columns
        code, cells = next(iter(columns.values()), ("c", b""))
        self.rows: int = len(cells) // {code: size for size, code in CELLS.values()}[code]

    def __getitem__(self, name: str) -> memoryview | tuple[str, ...]:
        if name in EARLIER_NAMES and name not in self._columns:
            warnings.warn(f"column {name!r} is now {EARLIER_NAMES[name]!r}", DeprecationWarning,
                          stacklevel=2)
            name = EARLIER_NAMES[name]
        code, cells = self._columns[name]
        if code != "c":
            return memoryview(cells).cast(code)
        letters = cells.decode("ascii")
        return tuple(letters[i:i + WORD_LENGTH].rstrip()
                     for i in range(0, len(letters), WORD_LENGTH))

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        return f"<{self.rows} rows of {', '.join(self)}>"


def call(name: str, *arguments, interrupt: c_int | None = None) -> Outcome:
    """Calls the library from a thread of its own, so that Ctrl-C is heard while it computes.

    After Ctrl-C `KeyboardInterrupt` is raised immediately. The thread ends at the next position
    where the call has an `interrupt`, and keeps its arguments until then.
    """
    outcomes: list[Outcome] = []
    errors: list[BaseException] = []

    def work():
        try:
            handles = (getattr(value, "handle", value) for value in arguments)
            outcomes.append(Outcome(getattr(_C, f"asperity_{name}")(*handles)))
        except BaseException as error:
            errors.append(error)

    thread = threading.Thread(target=work, name=f"asperity {name}", daemon=True)
    thread.start()
    try:
        thread.join()
    except BaseException:
        if interrupt is not None:
            interrupt.value = 1
        raise
    if errors:
        raise errors[0]
    return outcomes[0]
