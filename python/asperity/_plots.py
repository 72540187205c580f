"""Drawings of results and maps with matplotlib. Each function returns the axes it draws on."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from ._columns import Table, needed
from ._maps import HeightMap, is_topography, map_of_topography, read_map

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._fields import Fields
    from ._results import Results, Summits

# More curves than these are drawn without a legend.
MOST_NAMED = 8


def new_axes(ax: Any, number: int = 1) -> Any:
    """The axes that are given, or those of a new figure."""
    if ax is not None:
        return ax
    plt = needed("matplotlib.pyplot", "plot", "a plot")
    _, made = plt.subplots(1, number, figsize=(5.0 * number, 4.0), layout="constrained")
    return made


def draw_curves(results: Results, ax: Any) -> tuple[Axes, Axes]:
    """Load against separation, and contact area against load, one curve a position."""
    left, right = new_axes(ax, 2)
    table = results.states
    positions = sorted(set(table["position"].tolist()))
    for position in positions:
        rows = table["position"] == position
        name = f"position {position}" if 1 < len(positions) <= MOST_NAMED else None
        for axes, across, up in ((left, "separation", "load"), (right, "load", "area")):
            axes.plot(table[across][rows], table[up][rows], marker=".", label=name)
            axes.set_xlabel(table.label(across))
            axes.set_ylabel({"area": "contact "}.get(up, "") + table.label(up))
            axes.locator_params(axis="x", nbins=5)
            axes.grid(alpha=0.3)
    if 1 < len(positions) <= MOST_NAMED:
        left.legend()
    return left, right


def draw_contacts(results: Results, position: int, state: int, ax: Axes | None) -> Axes:
    """Contacts of one state in plan, with their area, coloured by the greatest pressure."""
    table, states = results.contacts, results.states
    steps = states["step"][states["position"] == position]
    if len(steps) == 0:
        raise IndexError(f"position: found {position}, expected one of the results")
    if not -len(steps) <= state < len(steps):
        raise IndexError(f"state: found {state}, expected -{len(steps)} to {len(steps) - 1}")
    rows = (table["position"] == position) & (table["step"] == steps[state]) & (table["load"] != 0)
    axes: Axes = new_axes(ax)
    circles = needed("matplotlib.patches", "plot", "a plot").Circle
    collections = needed("matplotlib.collections", "plot", "a plot")
    patches = [circles((x, y), math.sqrt(area / math.pi)) for x, y, area in
               zip(table["x"][rows], table["y"][rows], table["area"][rows])]
    drawn = collections.PatchCollection(patches, cmap="viridis")
    drawn.set_array(table["maximum_pressure"][rows])
    axes.add_collection(drawn)
    axes.autoscale_view()
    in_plan(axes, table.units.get("x", ""))
    axes.figure.colorbar(drawn, ax=axes, label=table.label("maximum_pressure"))
    return axes


def draw_map(heights: HeightMap, ax: Axes | None, label: str = "height") -> Axes:
    """Heights in plan; x to the right, y upwards."""
    axes: Axes = new_axes(ax)
    width, depth = heights.sizes
    drawn = axes.imshow(heights.heights, origin="lower", extent=(0.0, width, 0.0, depth),
                        cmap="gray" if label == "" else "viridis", interpolation="nearest")
    in_plan(axes, heights.unit or "")
    if label:
        unit = f" ({heights.unit})" if heights.unit else ""
        axes.figure.colorbar(drawn, ax=axes, label=label + unit)
    return axes


def draw_field(fields: Fields, name: str, ax: Axes | None) -> Axes:
    """One array of a state in plan; x to the right, y upwards. The pressure leaves pixels out of
    contact white, the gap those in contact."""
    axes: Axes = new_axes(ax)
    library = needed("numpy", "plot", "a plot")
    values = library.asarray(getattr(fields, name), dtype=float)
    contact = library.asarray(fields.contact)
    if name == "pressure":
        values = library.where(contact, values, math.nan)
    if name == "gap":
        values = library.where(contact, math.nan, values)
    width, depth = (number * step for number, step in zip(fields.shape[::-1], fields.spacing))
    left, bottom = 0.0, 0.0  # of a map
    if fields.hertz_contacts is not None:
        left, bottom = (at - step / 2 for at, step in zip(fields.origin, fields.spacing))
    drawn = axes.imshow(values, origin="lower", cmap="viridis",
                        extent=(left, left + width, bottom, bottom + depth),
                        interpolation="nearest", vmin=0.0 if name in ("pressure", "gap") else None)
    in_plan(axes, fields.unit or "")
    if name != "contact":
        axes.figure.colorbar(drawn, ax=axes, label=Table(units=fields.units).label(name))
    return axes


def draw_summits(summits: Summits, source: Any, ax: Axes | None) -> Axes:
    """Summits on their map, coloured by height."""
    axes: Axes = new_axes(ax)
    unit = summits.units.get("x", "")
    pixels = _map_to_draw(source, unit)
    if pixels is not None:
        draw_map(pixels, axes, label="")
    drawn = axes.scatter(summits["x"], summits["y"], c=summits["height"], s=14,
                         edgecolors="white", linewidths=0.3)
    in_plan(axes, unit)
    axes.figure.colorbar(drawn, ax=axes, label=summits.label("height"))
    return axes


def _map_to_draw(source: Any, unit: str) -> HeightMap | None:
    """The map behind summits, in their unit; None where it cannot be had."""
    if is_topography(source):
        source = map_of_topography("map", source)
    elif not isinstance(source, HeightMap):
        try:
            return read_map(source, unit=unit or None)
        except (ValueError, TypeError):
            return None
    return source if (source.unit or "") == unit else None


def in_plan(axes: Axes, unit: str) -> None:
    axes.set_aspect("equal")
    for name, setter in (("x", axes.set_xlabel), ("y", axes.set_ylabel)):
        setter(Table(units={name: unit}).label(name))
