"""Contact between two rough surfaces of spherical asperities.

    >>> import asperity
    >>> results = asperity.solve("data/examples/thesis.scene")
    >>> max(results.positions["load"])

Units are those of the scene, any consistent set: with mm and N, moduli and pressures are in N/mm2.
A card deck brings cm, N and N/cm2. Angles are radians. Arrays are one-dimensional, of doubles.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from ctypes import POINTER, byref, c_int

from . import _arguments as _a
from . import _library as _c
from ._library import ComputeError, InputError, Problem, Table, TheoryWarning

__all__ = ["solve", "report", "summits", "generate", "Results", "Summits", "Table", "InputError",
           "ComputeError", "Problem", "TheoryWarning", "__version__"]

__version__ = _c.VERSION

Path = str | os.PathLike


class Results:
    """Results of `solve`: three tables, each a mapping from the name of a column to its values.

    positions: one row for each position of the motion: its last state.
    states: one row for each state of each position.
    contacts: one row for each contact of each state.

    docs/columns.md lists the columns with meaning, unit and sign. Lengths, forces and pressures
    are in the units of the scene. A value that was not computed is NaN. Results can be copied,
    pickled and sent to another process.
    """

    def __init__(self, outcome: _c.Outcome):
        self.positions = Table(outcome.columns(_c.POSITIONS))
        self.states = Table(outcome.columns(_c.STATES))
        self.contacts = Table(outcome.columns(_c.CONTACTS))
        #: the printed summary
        self.summary: str = outcome.text(_c.REPORT)
        #: warnings, one line for each kind; also issued as `TheoryWarning`
        self.warnings: list[str] = outcome.lines(_c.WARNINGS)
        #: notes on the deck, the scene or the map
        self.notes: list[str] = outcome.lines(_c.NOTES)

    def __str__(self) -> str:
        return self.summary


class Summits(Table):
    """Summits of a height map: columns `x`, `y`, `height` and `radius`, in the unit of the map
    or in the requested one. It can be used as a surface of a scene."""

    def __init__(self, outcome: _c.Outcome):
        super().__init__(outcome.columns(_c.SUMMITS))
        #: statistics of the map and its summits by name, in the same unit of length
        self.statistics: dict[str, float] = {
            name: cells[0] for name, cells in Table(outcome.columns(_c.STATISTICS)).items()}
        #: the printed summary
        self.summary: str = outcome.text(_c.REPORT)
        #: notes on the file of the map
        self.notes: list[str] = outcome.lines(_c.NOTES)


def solve(scene: Path | Mapping[str, Mapping], *, arithmetic: str = "real64",
          accuracy: float = 0.0, contacts: bool = True, threads: int = 0) -> Results:
    """Solve a scene: contacts, load, area and pressures of two surfaces.

    scene: the path of a scene file or of a card deck; or the groups of a scene as a dict of dicts,
        with the names and units of docs/scene.md. There, `upper` and `lower` of the group
        `surfaces` may be arrays: a mapping with `x`, `y` (places on the reference plane), `height`
        (above it) and `radius` (more than 0), arrays of n doubles each, or one radius for all;
        `"plane"` for one of the two. Objects with a buffer of doubles, for instance numpy arrays,
        are used without a copy, other sequences are copied. Files are relative to the current
        folder.
        A number is taken as the double that it is; True and False stand for `on` and `off`.
    arithmetic: `real64`, `real32`, `real128` or `ibm370`. Effects need `real64`.
    accuracy: largest estimated relative error of every total, less than 1; the fastest method with
        this error is used. 0: no such choice.
    contacts: False: totals only, `contacts` of the results has no rows.
    threads: 0: all cores; at most 9999. The results are the same for any number.

    Raises InputError with all that is wrong with the scene or an argument, TypeError for a value of
    a type that cannot be taken, and ComputeError when the scene cannot be solved. Each names what
    is wrong as it was given, as in `surfaces.upper.height`. A result outside the range of a
    theory is a TheoryWarning. Ctrl-C ends the computation.
    """
    interrupt = c_int(0)
    options = _c.Options(
        _a.word("arithmetic", arithmetic), _a.number("accuracy", accuracy),
        not _a.flag("contacts", contacts),
        _a.whole("threads", threads, "a number from 1 to 9999, or 0 for all cores"),
        POINTER(c_int)(interrupt))
    if isinstance(scene, Mapping):
        rest, surfaces = _a.surfaces(scene)
        groups = _a.Groups("scene", rest, _a.DOUBLE)
        read = _c.call("build_scene", groups.text, *surfaces)
    else:
        groups = _a.Groups("scene", {})
        read = _c.call("read_scene", _a.path("scene", scene, "a path, or a dict of groups"))
    solved = _c.call("solve_scene", read, byref(options), interrupt=interrupt)
    return Results(solved.checked(groups.named))


def report(deck: Path, arithmetic: str = "ibm370",
           tables: Iterable[int] = (13, 55, 56)) -> str:
    """Run the original program of the thesis on a card deck; the printed report as text.

    deck: the path of a card deck, in inches and psi; the report is in cm and N.
    arithmetic: `ibm370`, with which the thesis was printed, `real32`, `real64` or `real128`.
    tables: positions, from 1 to 100, whose contact tables are printed.

    Raises InputError for a bad deck, ComputeError where the original would have gone astray.
    """
    expected = "positions from 1 to 100"
    positions = [_a.whole("tables", one, expected)
                 for one in _a.several("tables", tables, expected)]
    return _c.call("make_report", _a.path("deck", deck), _a.word("arithmetic", arithmetic),
                   (c_int * max(1, len(positions)))(*positions), len(positions)
                   ).checked().text(_c.REPORT)


def summits(map: Path, *, rule: str = "eight", level: str | None = None,
            radius: str | None = None, unit: str | None = None,
            spacing: tuple[float, float] = (0.0, 0.0), despike: bool = False,
            edge: str = "free") -> Summits:
    """Find the summits of a measured height map (docs/summits.md).

    map: the path of a surface data file (ISO 25178-71), a matrix of heights, or `x,y,z` lines.
    rule: `eight` (higher than all eight neighbours) or `contact` (for a contact calculation).
    level: subtract the least-squares `plane`, the `mean`, or `none`; None: `plane` for a free map,
        `mean` for a periodic one.
    radius: `neighbours`, `geometric` or `paraboloid`; None: that of the rule.
    unit: `m`, `mm`, `um`, `nm`, `cm` or `in`, of all lengths that are given; None: the file's own.
    spacing: of a matrix, along x and y, in its unit, from 1e-30 to 1e30; other files have their
        own.
    despike: remove single outliers.
    edge: `free`, or `periodic` for a map that repeats itself.

    Raises InputError for a bad map, ComputeError where there is not enough memory for it.
    """
    options = _c.SummitsOptions(
        _a.word("rule", rule), None if level is None else _a.word("level", level),
        None if radius is None else _a.word("radius", radius),
        None if unit is None else _a.word("unit", unit),
        _a.pair("spacing", spacing), _a.flag("despike", despike))
    name = {b"free": "summits", b"periodic": "periodic_summits"}.get(_a.word("edge", edge))
    if name is None:
        raise InputError([Problem(None, None, None,
                                  f"edge: found {edge!r}, expected 'free' or 'periodic'")])
    return Summits(_c.call(name, _a.path("map", map), byref(options)).checked())


def generate(specification: Path | Mapping[str, Mapping], surface: int = 1) -> tuple[Table, Table]:
    """Make the two random surfaces of a specification (docs/generate.md).

    specification: the path of a file, or its groups as a dict of dicts.
    surface: which of the ensemble, from 1.

    Gives the upper and the lower surface, tables with columns `x`, `y`, `height` and `radius` in
    the unit of the specification, which serve as surfaces of a scene. The same specification gives
    the same numbers everywhere. Raises InputError, and ComputeError where the surface is too full.
    """
    number = _a.whole("surface", surface, "a number from 1 to the size of the ensemble")
    if isinstance(specification, Mapping):
        groups = _a.Groups("specification", specification)
        place = None, groups.text
    else:
        groups = _a.Groups("specification", {})
        place = _a.path("specification", specification, "a path, or a dict of groups"), None
    made = _c.call("generate", *place, number).checked(groups.named)
    return Table(made.columns(_c.UPPER)), Table(made.columns(_c.LOWER))
