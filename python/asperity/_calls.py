"""The report of the original program, summits of maps, and random surfaces."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from ctypes import byref, c_int
from typing import Any

from . import _arguments as _a
from . import _library as _c
from ._columns import NDArray, Table
from ._maps import HeightMap, is_topography, map_of
from ._results import Summits


def report(deck: _a.Path, arithmetic: str = "ibm370",
           tables: Iterable[int] = (13, 55, 56)) -> str:
    """The printed report, in cm and N, of the original program of the thesis on a card deck. A deck
    on which that program would have failed is a ComputeError.

    Args:
        arithmetic: `ibm370`, with which the thesis was printed, `real32`, `real64` or `real128`.
        tables: Positions, from 1 to 100, whose contact tables are printed.

    Examples:
        >>> asperity.report("data/thesis.deck").count("TABLE") >= 4
        True
    """
    expected = "positions from 1 to 100"
    listed = [_a.whole("tables", one, expected) for one in _a.several("tables", tables, expected)]
    return _c.call("make_report", _a.path("deck", deck), _a.word("arithmetic", arithmetic),
                   (c_int * max(1, len(listed)))(*listed), len(listed)).checked().text(_c.REPORT)


def summits(map: _a.Path | HeightMap | NDArray[Any] | Sequence[Sequence[float]], *,
            rule: str = "eight", level: str | None = None, radius: str | None = None,
            unit: str | None = None, spacing: float | Sequence[float] = (0.0, 0.0),
            despike: bool = False, edge: str | None = None) -> Summits:
    """Find the summits of a height map (`docs/reference/height-maps.md`).

    Args:
        map: A file, a height map, a topography of SurfaceTopography, or a matrix with `spacing`.
        rule: `eight` (higher than all eight neighbours) or `contact` (for a contact calculation).
        level: Subtract the least-squares `plane` (default of a free map), the `mean` (of a
            periodic one) or `none`.
        radius: `neighbours`, `geometric` or `paraboloid`. Default: that of the rule.
        unit: `m`, `mm`, `um`, `nm`, `cm` or `in`, of all lengths that are returned. Default: that
            of the map. For a map without a unit it is the unit of its numbers.
        spacing: Distance of pixels along x and y, for a map without one, in its unit.
        despike: Remove single outliers.
        edge: `free` or `periodic`. Default: that of a `HeightMap`, otherwise `free`.

    Examples:
        >>> found = asperity.summits([[0, 0, 0, 0], [0, 2, 0, 0], [0, 0, 0, 0]], spacing=1,
        ...                          level="none", unit="um")
        >>> found["x"].tolist(), found["y"].tolist(), found["height"].tolist()
        ([1.0], [1.0], [2.0])
    """
    steps = _a.pair("spacing", spacing)
    options = _c.SummitsOptions(
        _a.word("rule", rule), _a.optional_word("level", level),
        _a.optional_word("radius", radius), _a.optional_word("unit", unit), steps,
        _a.flag("despike", despike))
    periodic = {None: None, b"free": False, b"periodic": True}.get(_a.optional_word("edge", edge))
    if edge is not None and periodic is None:
        raise _a.wrong("edge", repr(edge), "'free' or 'periodic'")
    pixels = map_of("map", map, steps if steps[0] > 0.0 else None)
    if pixels is not None:
        if periodic is not None:
            pixels.periodic = periodic
        found = _c.call("summits", None, byref(pixels), byref(options)).checked()
        source: Any = map
        if not isinstance(map, HeightMap):
            source = HeightMap.of(map) if is_topography(map) else HeightMap(
                source, steps if steps[0] > 0.0 else pixels.spacing, unit)
        return Summits(found, source)
    options.periodic = bool(periodic)
    return Summits(_c.call("summits", _a.path("map", map), None, byref(options)).checked(), map)


def generate(specification: _a.Path | Mapping[str, Mapping[str, Any]],
             surface: int = 1) -> tuple[Table, Table]:
    """Make the two random surfaces of a specification (`docs/reference/generate.md`).

    The specification is the path of a file, or its groups as a dict of dicts; `surface` counts the
    ensemble from 1. The upper and the lower surface have the columns `x`, `y`, `height` and
    `radius`, and serve in a scene. The same specification gives the same numbers everywhere. A
    surface without room for so many asperities is a ComputeError.

    Examples:
        >>> upper, lower = asperity.generate({"surfaces": {"number": 60, "length": 1, "width": 1},
        ...     "heights": {"mean": 0.01, "deviation": 0.001}, "radii": {"mean": 0.5}})
        >>> upper
        <asperity.Table of 60 asperities: 4 columns x, y, height, radius>
    """
    number = _a.whole("surface", surface, "a number from 1 to the size of the ensemble")
    groups, *place = _a.specification_of(specification)
    made = _c.call("generate", *place, number).checked(groups.named)
    return made.table(_c.UPPER, "asperities"), made.table(_c.LOWER, "asperities")
