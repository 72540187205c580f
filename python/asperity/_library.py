"""The shared library, as include/asperity.h has it, and what its outcomes become in Python."""

from __future__ import annotations

import ctypes
import os
import threading
import time
from collections.abc import Callable
from ctypes import POINTER, Structure, byref, c_char, c_char_p, c_double, c_int, c_int64, c_void_p
from pathlib import Path
from typing import Any

from . import _errors
from ._columns import Column, Table, column
from ._errors import ComputeError, InputError, Problem

# Of the header.
NOT_COMPUTED, BAD_INPUT = 1, 2
FAILURE, PROBLEMS, WARNINGS, NOTES, REPORT, WARNING_KINDS, UNIT, GROUPS, SCENE, METHODS = (
    range(1, 11))
POSITIONS, STATES, CONTACTS, SUMMITS, STATISTICS, UPPER, LOWER, MAP, PIXELS, FIELDS = range(1, 11)
DISPLACEMENTS, PRESSURES, STRESSES = 1, 2, 3
SPECTRA = {"iso": 11, "x": 12, "y": 13}
WORD_LENGTH = 16
# Of the types of columns: bytes of a cell, and its code for `memoryview`; a word is 16 letters.
CELLS = {1: (8, "d"), 2: (4, "i"), 3: (WORD_LENGTH, "c")}


class Surface(Structure):
    _fields_ = [("count", c_int), ("radii", c_int)] + [
        (name, POINTER(c_double)) for name in ("x", "y", "height", "radius")]


class Map(Structure):
    _fields_ = [("columns", c_int), ("rows", c_int), ("height", POINTER(c_double)),
                ("spacing", c_double * 2), ("unit", c_char_p), ("periodic", c_int)]


class Side(Structure):
    _fields_ = [("asperities", POINTER(Surface)), ("map", POINTER(Map))]


class Options(Structure):
    _fields_ = [("arithmetic", c_char_p), ("accuracy", c_double), ("totals_only", c_int),
                ("threads", c_int), ("interrupt", POINTER(c_int)),
                ("accuracy_of", c_char_p), ("progress", POINTER(c_int)), ("fields", c_int)]


class SummitsOptions(Structure):
    _fields_ = [("rule", c_char_p), ("level", c_char_p), ("radius", c_char_p), ("unit", c_char_p),
                ("spacing", c_double * 2), ("despike", c_int), ("periodic", c_int)]


class Body(Structure):
    _fields_ = [("columns", c_int), ("rows", c_int), ("spacing", c_double * 2),
                ("periodic", c_int * 2), ("modulus", c_double * 2), ("ratio", c_double * 2),
                ("layer", c_double)]


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


_C = _loaded(next(Path(__file__).parent.glob("libasperity.so*")))
# Result and arguments of each function by these letters.
LETTERS: dict[str, Any] = {
    "p": c_void_p, "s": c_char_p, "i": c_int, "d": c_double, "l": c_int64, "-": None,
    "I": POINTER(c_int), "D": POINTER(c_double), "S": POINTER(Side), "M": POINTER(Map),
    "O": POINTER(Options), "R": POINTER(SummitsOptions), "P": POINTER(CProblem), "B": POINTER(Body)}
_FUNCTIONS = [(name, *map(LETTERS.get, letters)) for name, letters in map(str.split, """
    get_version s, read_scene ps, build_scene psSS, rebuild_scene pps, solve_scene ppO,
    study_scene ppdi, fields ppii, loaded pBiDDDd, make_report pssIi, summits psMR, read_map
    psDs, write_map pMs, generate pssi, generate_map pss, power_spectrum pMs, status ip, text
    spi, problem_count ip, get_problem -piP, rows lpi, columns ipi, column_name spii,
    column_type ipii, column_unit spii, column ppii, free -p""".split(","))]
for _name, _result, *_arguments in _FUNCTIONS:
    _function = getattr(_C, f"asperity_{_name}")
    _function.restype, _function.argtypes = _result, _arguments

VERSION: str = _C.asperity_get_version().decode()


class Outcome:
    """Result of a call of the library, the only owner of its address. The columns that are read
    from it use its memory and keep it."""

    _free = staticmethod(_C.asperity_free)

    def __init__(self, handle: int | None):
        self.handle = handle
        self.seconds = 0.0  #: of processor, of the call that made it

    def __del__(self) -> None:
        self._free(self.handle)

    def __reduce__(self) -> Any:
        raise TypeError("an outcome of the library cannot be copied")

    def text(self, which: int) -> str:
        text: bytes = _C.asperity_text(self.handle, which)
        return text.decode(errors="replace")

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

    def table(self, which: int, name: str) -> Table:
        """A table, with the units of its columns."""
        table, rows = Table(name=name), _C.asperity_rows(self.handle, which)
        for number in range(_C.asperity_columns(self.handle, which)):
            place = self.handle, which, number
            title = _C.asperity_column_name(*place).decode()
            table.units[title] = _C.asperity_column_unit(*place).decode()
            table[title] = self._column(place, rows)
        return table

    def facts(self, which: int) -> dict[str, float]:
        """A table of one row."""
        return {name: values.tolist()[0] for name, values in self.table(which, "maps").items()}

    def _column(self, place: tuple[int | None, int, int], rows: int) -> Column:
        size, code = CELLS[_C.asperity_column_type(*place)]
        cells: Any = (c_char * 0)()
        if rows:
            cells = (c_char * (size * rows)).from_address(_C.asperity_column(*place))
            cells.outcome = self
        if code != "c":
            view: Any = memoryview(cells).toreadonly().cast("B")
            return column(view.cast(code))
        letters = cells.raw.decode("ascii")
        return column([letters[i:i + size].rstrip() for i in range(0, size * rows, size)])

    def checked(self, named: Callable[[Problem], Problem] = lambda problem: problem) -> Outcome:
        """Itself after a success; its warnings become Python warnings. `named` gives the place of
        a problem the name that the caller used."""
        status = _C.asperity_status(self.handle)
        if status == BAD_INPUT:
            raise InputError([named(problem) for problem in self.problems()])
        if status == NOT_COMPUTED:
            failure = self.text(FAILURE)
            raise MemoryError(failure) if self.handle is None else ComputeError(failure)
        _errors.issue(self.lines(WARNINGS), self.lines(WARNING_KINDS))
        return self


# Seconds from one look at the progress to the next, and that a call has to end after Ctrl-C.
PAUSE, TIME_TO_END = 0.1, 1.0
# Seconds of processor of a call that needs no thread of its own: starting one takes 0.05 to 0.1 ms.
SHORT = 0.5e-3


def call(name: str, *arguments: Any, interrupt: c_int | None = None,
         watch: Callable[[], None] | None = None, is_short: bool = False) -> Outcome:
    """Call the library from a thread of its own, so that Ctrl-C is heard while it computes; a call
    that `is_short` from the thread of the caller.

    `watch` is called ten times a second. Ctrl-C sets `interrupt`, which ends the call;
    `KeyboardInterrupt` is raised then, and after a second at the latest. The thread keeps the
    arguments until the call has ended.
    """
    outcomes: list[Outcome | BaseException] = []

    def compute() -> Outcome:
        handles = [getattr(value, "handle", value) for value in arguments]
        begin = time.thread_time()
        made = Outcome(getattr(_C, f"asperity_{name}")(*handles))
        made.seconds = time.thread_time() - begin
        return made

    def work() -> None:
        try:
            outcomes.append(compute())
        except BaseException as error:
            outcomes.append(error)

    if is_short:
        return compute()
    thread = threading.Thread(target=work, name=f"asperity {name}", daemon=True)
    try:
        thread.start()
    except RuntimeError:
        raise ComputeError("not enough memory for a thread of the solve") from None
    try:
        while watch and thread.is_alive():
            thread.join(PAUSE)
            watch()
        thread.join()
    except BaseException:
        if interrupt is not None:
            interrupt.value = 1
            thread.join(TIME_TO_END)
        raise
    if isinstance(outcomes[0], BaseException):
        raise outcomes[0]
    return outcomes[0]
