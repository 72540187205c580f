"""Contact between two rough surfaces of spherical asperities.

    >>> import asperity
    >>> results = asperity.solve("data/examples/thesis.scene")
    >>> max(results.positions["load"])

Units are those of the scene, any consistent set: with mm and N, moduli and pressures are in N/mm2.
A card deck brings cm, N and N/cm2. Angles are radians. Arrays are one-dimensional, of doubles.
"""

from __future__ import annotations

import numbers
import os
from array import array
from collections.abc import Iterable, Mapping
from ctypes import POINTER, byref, c_double, c_int, cast

from . import _library as _c
from ._library import ComputeError, InputError, Problem, Table, TheoryWarning

__all__ = ["solve", "report", "summits", "generate", "Results", "Summits", "Table", "InputError",
           "ComputeError", "Problem", "TheoryWarning", "__version__"]

__version__ = _c.VERSION

Path = str | os.PathLike


class Results:
    """What `solve` gives. Three tables, each a mapping from the name of a column to its cells.

    positions: a row a position of the scene's motion: its last state.
    states: a row a state on the way there.
    contacts: a row a contact, of every state of every position.

    The columns, with meaning, unit and sign, are those of the files of the program
    (docs/columns.md). Lengths, forces and pressures are in the units of the scene. Cells that are
    empty in the files, as nothing was computed for them, are NaN.
    """

    def __init__(self, outcome: _c.Outcome):
        self.positions = Table(outcome, _c.POSITIONS)
        self.states = Table(outcome, _c.STATES)
        self.contacts = Table(outcome, _c.CONTACTS)
        #: what the program prints, as text
        self.summary: str = outcome.text(_c.REPORT)
        #: what lies outside a theory, a line a kind; they were raised as `TheoryWarning`, too
        self.warnings: list[str] = outcome.lines(_c.WARNINGS)
        #: oddities of a deck, a scene or a map that are no errors
        self.notes: list[str] = outcome.lines(_c.NOTES)

    def __str__(self) -> str:
        return self.summary


class Summits(Table):
    """What `summits` gives: columns `x`, `y`, `height` and `radius`, lengths in the unit of the map
    or in the one asked for. It serves as a surface of a scene as it stands."""

    def __init__(self, outcome: _c.Outcome):
        super().__init__(outcome, _c.SUMMITS)
        #: of the map and its summits, by name; lengths, and their powers, in the same unit
        self.statistics: dict[str, float] = {
            name: cells[0] for name, cells in Table(outcome, _c.STATISTICS).items()}
        #: what the program prints, as text
        self.summary: str = outcome.text(_c.REPORT)
        #: oddities of the map's file that are no errors
        self.notes: list[str] = outcome.lines(_c.NOTES)


def solve(scene: Path | Mapping[str, Mapping], *, arithmetic: str = "real64",
          accuracy: float = 0.0, contacts: bool = True, threads: int = 0) -> Results:
    """Solve a scene: where do two surfaces touch, what load do they carry?

    scene: the path of a scene file or of a card deck; or the groups of a scene as a dict of dicts,
        with the names and units of docs/scene.md. There, `upper` and `lower` of the group
        `surfaces` may be arrays: a mapping with `x`, `y` (places on the reference plane), `height`
        (above it) and `radius` (more than 0), arrays of n doubles each, or one radius for all;
        `"plane"` for one of the two. Anything with a buffer of doubles, numpy's arrays among them,
        is taken as it stands, other sequences are copied. Files are relative to the current folder.
    arithmetic: `real64`, `real32`, `real128` or `ibm370`. Effects need `real64`.
    accuracy: relative error of every total that is allowed; the cheapest way that has it is taken.
        0: none is asked for.
    contacts: False: totals only, `contacts` of the results has no rows.
    threads: 0: all cores. The results are the same for any number.

    Raises InputError with all that is wrong with the scene, and ComputeError when it cannot be
    solved. What lies outside a theory is a TheoryWarning. Ctrl-C works.
    """
    if isinstance(scene, Mapping):
        read = _build(scene)
    else:
        read = _c.call("read_scene", os.fsencode(scene))
    interrupt = c_int(0)
    options = _c.Options(arithmetic.encode(), accuracy, not contacts, threads,
                         POINTER(c_int)(interrupt))
    return Results(_c.call("solve_scene", read, byref(options), interrupt=interrupt).checked())


def report(deck: Path, arithmetic: str = "ibm370",
           tables: Iterable[int] = (13, 55, 56)) -> str:
    """Run the original program of the thesis on a card deck; the printed report as text.

    deck: the path of a card deck, in inches and psi; the report is in cm and N.
    arithmetic: `ibm370`, with which the thesis was printed, `real32`, `real64` or `real128`.
    tables: positions, from 1 to 100, whose contact tables are printed.

    Raises InputError for a bad deck, ComputeError where the original would have gone astray.
    """
    positions = list(tables)
    return _c.call("make_report", os.fsencode(deck), arithmetic.encode(),
                   (c_int * max(1, len(positions)))(*positions), len(positions)
                   ).checked().text(_c.REPORT)


def summits(map: Path, *, rule: str = "eight", level: str = "plane", radius: str | None = None,
            unit: str | None = None, spacing: tuple[float, float] = (0.0, 0.0),
            despike: bool = False) -> Summits:
    """Find the summits of a measured height map (docs/summits.md).

    map: the path of a surface data file (ISO 25178-71), a matrix of heights, or `x,y,z` lines.
    rule: `eight` (higher than all eight neighbours) or `contact` (what is best pressed).
    level: heights count from the `plane` of least squares, from the `mean`, or as they are, `none`.
    radius: `neighbours`, `geometric` or `paraboloid`; None: that of the rule.
    unit: `m`, `mm`, `um`, `nm`, `cm` or `in`, of all lengths that are given; None: the file's own.
    spacing: of a matrix, along x and y, in its unit; other files have their own.
    despike: take single outliers out.

    Raises InputError for a bad map, ComputeError where there is not enough memory for it.
    """
    options = _c.SummitsOptions(rule.encode(), level.encode(), radius and radius.encode(),
                                unit and unit.encode(), tuple(spacing), despike)
    return Summits(_c.call("summits", os.fsencode(map), byref(options)).checked())


def generate(specification: Path | Mapping[str, Mapping], surface: int = 1) -> tuple[Table, Table]:
    """Make the two random surfaces of a specification (docs/generate.md).

    specification: the path of a file, or its groups as a dict of dicts.
    surface: which of the ensemble, from 1.

    Gives the upper and the lower surface, tables with columns `x`, `y`, `height` and `radius` in
    the unit of the specification, which serve as surfaces of a scene. The same specification gives
    the same numbers everywhere. Raises InputError, and ComputeError where the surface is too full.
    """
    if isinstance(specification, Mapping):
        place = None, _text(specification)
    else:
        place = os.fsencode(specification), None
    made = _c.call("generate", *place, surface).checked()
    return Table(made, _c.UPPER), Table(made, _c.LOWER)


def _build(groups: Mapping[str, Mapping]) -> _c.Outcome:
    """A scene of groups; surfaces that are no texts are arrays."""
    sides = {side: value for side, value in groups.get("surfaces", {}).items()
             if side in ("upper", "lower")}
    if all(isinstance(value, (str, os.PathLike)) for value in sides.values()):
        return _c.call("build_scene", _text(groups), None, None)
    others = {name: value for name, value in groups["surfaces"].items() if name not in sides}
    rest = {**groups, "surfaces": others}
    if not others:
        del rest["surfaces"]
    surfaces = [_surface(side, sides.get(side)) for side in ("upper", "lower")]
    return _c.call("build_scene", _text(rest), *map(byref, surfaces))


def _surface(side: str, columns) -> _c.Surface:
    """One surface for the library, which reads the arrays where they are."""
    if columns == "plane":
        return _c.Surface()
    if isinstance(columns, (str, os.PathLike)) or columns is None:
        raise InputError([Problem(None, None, None, f"{side} surface: found {columns!r} beside a "
                                  "surface of arrays, expected arrays or 'plane'")])
    missing = [name for name in ("x", "y", "height", "radius") if name not in columns]
    if missing:
        raise InputError([Problem(None, None, None, f"{side} surface: found no "
                                  f"{', '.join(missing)}, expected x, y, height and radius")])
    x, y, height, radius = (_doubles(columns[name]) for name in ("x", "y", "height", "radius"))
    count = len(x)
    if count == 0 or {len(y), len(height)} != {count} or len(radius) not in (1, count):
        raise InputError([Problem(
            None, None, None, f"{side} surface: found {count} x, {len(y)} y, {len(height)} heights "
            f"and {len(radius)} radii, expected as many of each, or one radius, and at least one "
            "asperity")])
    return _c.Surface(count, len(radius), *(cast(cells, POINTER(c_double))
                                            for cells in (x, y, height, radius)))


def _doubles(values):
    """An array of C's doubles: in the memory of what has a writable buffer of them, else a copy."""
    if isinstance(values, numbers.Real):
        values = (values,)
    try:
        view = memoryview(values)
    except TypeError:
        view = None
    if view is None or view.format != "d" or view.ndim != 1 or not view.c_contiguous or \
            view.readonly:
        view = memoryview(array("d", values))
    return (c_double * len(view)).from_buffer(view) if len(view) else (c_double * 0)()


def _text(groups: Mapping[str, Mapping]) -> bytes:
    """Groups as a scene file has them, one a line."""
    return "".join(
        f"&{group} " + ", ".join(f"{name} = {_value(value)}" for name, value in names.items())
        + " /\n" for group, names in groups.items()).encode()


def _value(value) -> str:
    """A value as a scene file has it."""
    if isinstance(value, (str, os.PathLike)):
        return "'" + os.fspath(value).replace("'", "''") + "'"
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    return ", ".join(map(_value, value))
