"""Drawings with matplotlib, of arrays and tables. Each function returns the axes it draws on."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from ._columns import Table, needed

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# More curves than these are drawn without a legend.
MOST_NAMED = 8


def new_axes(ax: Any, number: int = 1) -> Any:
    """The axes that are given, or those of a new figure."""
    if ax is not None:
        return ax
    plt = needed("matplotlib.pyplot", "plot", "a plot")
    _, made = plt.subplots(1, number, figsize=(5.0 * number, 4.0), layout="constrained")
    return made


def draw_curves(states: Table, ax: Any) -> tuple[Axes, Axes]:
    """Load against separation, and contact area against load, one curve for each position."""
    left, right = new_axes(ax, 2)
    positions = sorted(set(states["position"].tolist()))
    for position in positions:
        rows = states["position"] == position
        name = f"position {position}" if 1 < len(positions) <= MOST_NAMED else None
        for axes, across, up in ((left, "separation", "load"), (right, "load", "area")):
            axes.plot(states[across][rows], states[up][rows], marker=".", label=name)
            axes.set_xlabel(states.label(across))
            axes.set_ylabel({"area": "contact "}.get(up, "") + states.label(up))
            axes.locator_params(axis="x", nbins=5)
            axes.grid(alpha=0.3)
    if 1 < len(positions) <= MOST_NAMED:
        left.legend()
    return left, right


def draw_contacts(contacts: Table, rows: Any, ax: Axes | None) -> Axes:
    """Some rows of contacts in plan, coloured by the greatest pressure: circles with their area, or
    crosses at the centres of the patches of a height map, which are not circles."""
    axes: Axes = new_axes(ax)
    places = contacts["x"][rows], contacts["y"][rows]
    if "samples" in contacts:
        drawn: Any = axes.scatter(*places, marker="+", c=contacts["maximum_pressure"][rows])
    else:
        circle = needed("matplotlib.patches", "plot", "a plot").Circle
        drawn = needed("matplotlib.collections", "plot", "a plot").PatchCollection(
            [circle((x, y), math.sqrt(area / math.pi))
             for x, y, area in zip(*places, contacts["area"][rows])], cmap="viridis")
        drawn.set_array(contacts["maximum_pressure"][rows])
        axes.add_collection(drawn)
    axes.autoscale_view()
    in_plan(axes, contacts.units.get("x", ""))
    axes.figure.colorbar(drawn, ax=axes, label=contacts.label("maximum_pressure"))
    return axes


def draw_pixels(values: Any, spacing: tuple[float, float], unit: str | None, ax: Axes | None, *,
                corner: tuple[float, float] = (0.0, 0.0), label: str | None = None,
                cmap: str = "viridis", least: float | None = None) -> Axes:
    """Values on pixels in plan; x to the right, y upwards. The first pixel begins at `corner`."""
    axes: Axes = new_axes(ax)
    (left, bottom), (rows, columns) = corner, values.shape
    drawn = axes.imshow(values, origin="lower", cmap=cmap, interpolation="nearest", vmin=least,
                        extent=(left, left + columns * spacing[0],
                                bottom, bottom + rows * spacing[1]))
    in_plan(axes, unit or "")
    if label:
        axes.figure.colorbar(drawn, ax=axes, label=label)
    return axes


def draw_points(table: Table, axes: Axes) -> Axes:
    """Summits, coloured by height."""
    drawn = axes.scatter(table["x"], table["y"], c=table["height"], s=14,
                         edgecolors="white", linewidths=0.3)
    in_plan(axes, table.units.get("x", ""))
    axes.figure.colorbar(drawn, ax=axes, label=table.label("height"))
    return axes


def in_plan(axes: Axes, unit: str) -> None:
    axes.set_aspect("equal")
    for name, setter in (("x", axes.set_xlabel), ("y", axes.set_ylabel)):
        setter(Table(units={name: unit}).label(name))
