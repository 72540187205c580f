"""Drawings with matplotlib, of arrays and tables. Each function returns the axes it draws on."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Mapping
from typing import Any

from . import _arguments as _a
from ._columns import Axes, Lazy, Table, label_of, needed

numpy: Any = Lazy("numpy", "plot", "a plot")
colors, patches, collections = (Lazy(f"matplotlib.{name}", "plot", "a plot")
                                for name in ("colors", "patches", "collections"))
# More curves than these are drawn without a legend.
MOST_NAMED = 8
# Chosen: a scale is logarithmic where the greatest value exceeds this number of medians, and begins
# at this percentile; outliers that would widen a linear scale by the share have the last colour.
LOG_MEDIANS, LOG_PERCENT, OUTLIER_SHARE = 20.0, 1.0, 0.25
# No contact, slip, stick; orange and blue of Okabe and Ito, which the colour-blind tell apart.
STATES = {"no contact": "#ffffff", "slip": "#e69f00", "stick": "#0072b2"}
SCALES = ("auto", "linear", "log")


def new_axes(ax: Any, number: int = 1, size: tuple[float, float] = (5.0, 4.0)) -> Any:
    """The axes that are given, or those of a new figure."""
    if ax is not None:
        return ax
    plt = needed("matplotlib.pyplot", "plot", "a plot")
    _, made = plt.subplots(1, number, figsize=(size[0] * number, size[1]), layout="constrained")
    return made


def quantities(states: Table) -> tuple[str, str]:
    """The columns of force and contact area that are drawn: with a nominal area over it."""
    return ("nominal_pressure", "area_fraction") if "area_fraction" in states else ("load", "area")


def draw_curves(states: Table, ax: Any, *, control: str = "", log: bool = False,
                errors: bool = True, theory: Mapping[str, Any] | None = None) -> tuple[Axes, Axes]:
    """Load against separation, and contact area against load, one curve for each position; with a
    nominal area, nominal pressure and area fraction. Bands are the estimated errors."""
    left, right = new_axes(ax, 2)
    force, size = quantities(states)
    positions = sorted(set(states["position"].tolist()))
    for position in positions:
        rows = states["position"] == position
        name = f"position {position}" if 1 < len(positions) <= MOST_NAMED else None
        for axes, across, up in ((left, "separation", force), (right, force, size)):
            x, y = states[across][rows], states[up][rows]
            [line] = axes.plot(x, y, marker=".", label=name)
            along, band = error_of(states, across, up, control) if errors else ("", None)
            if band is not None:
                style = {"color": line.get_color(), "alpha": 0.25}
                fill, base, of = (axes.fill_between, x, y) if along == "y" else (
                    axes.fill_betweenx, y, x)
                if is_monotonic(x):
                    fill(base, of - band[rows], of + band[rows], lw=0, **style)
                else:
                    axes.errorbar(x, y, fmt="none", **{f"{along}err": band[rows]}, **style)
            axes.set_xlabel(states.label(across))
            axes.set_ylabel({"area": "contact "}.get(up, "") + states.label(up))
            axes.grid(alpha=0.3)
    for number, (name, curve) in enumerate((theory or {}).items()):
        x, y = (states[force], curve(states[force])) if callable(curve) else curve
        right.plot(x, y, color="0.5", ls=("--", ":", "-.", (0, (5, 1)))[number % 4], label=name)
    if log:
        left.set_yscale("log")
        right.set(xscale="log", yscale="log")
    for axes in (left, right):
        if not log or axes is left:
            axes.locator_params(axis="x", nbins=5)
        if axes.get_legend_handles_labels()[1]:
            axes.legend(fontsize="small")
    return left, right


def is_monotonic(values: Any) -> bool:
    """Whether values only rise or only fall: on a path up and down a band would cover itself."""
    steps = values[1:] - values[:-1]
    return bool((steps >= 0).all() or (steps <= 0).all())


def error_of(states: Table, across: str, up: str, control: str) -> tuple[str, Any]:
    """The axis of two columns that has an estimated error, and the error in its unit; else None.
    `error_estimate` is of the load, under a prescribed load of the compression."""
    estimated = "separation" if control in ("load", "vertical_load", "pressure") else "load"
    for axis, name in (("y", up), ("x", across)):
        quantity = {"area_fraction": "area", "nominal_pressure": "load"}.get(name, name)
        found = f"{quantity}_error_estimate"
        if found not in states and quantity == estimated:
            found = "error_estimate"
        if found in states:
            scale = states["compression" if name == "separation" else name]
            band = abs(numpy.nan_to_num(states[found] * scale))
            if band.any():
                return axis, band
    return "", None


def draw_contacts(contacts: Table, rows: Any, ax: Axes | None) -> Axes:
    """Some rows of contacts in plan, coloured by the greatest pressure: circles with their area, or
    crosses at the centres of the patches of a height map, which are not circles."""
    axes: Axes = new_axes(ax)
    places = contacts["x"][rows], contacts["y"][rows]
    if "samples" in contacts:
        drawn: Any = axes.scatter(*places, marker="+", c=contacts["maximum_pressure"][rows])
    else:
        drawn = collections.PatchCollection(
            [patches.Circle((x, y), math.sqrt(area / math.pi))
             for x, y, area in zip(*places, contacts["area"][rows])], cmap="viridis")
        drawn.set_array(contacts["maximum_pressure"][rows])
        axes.add_collection(drawn)
    axes.autoscale_view()
    in_plan(axes, contacts.units.get("x", ""))
    axes.figure.colorbar(drawn, ax=axes, label=contacts.label("maximum_pressure"))
    return axes


def colour_limits(values: Any, scale: str = "auto", percentile: float = 99.5, *,
                  least: float | None = None, is_signed: bool = False) -> tuple[bool, float, float]:
    """Whether the colours of values are logarithmic, and their least and greatest value.

    `auto`: logarithmic where the greatest of values above 0 exceeds `LOG_MEDIANS` medians. A linear
    scale ends at the percentile where outliers would widen it by more than `OUTLIER_SHARE`."""
    if scale not in SCALES:
        raise _a.wrong("scale", repr(scale), ", ".join(map(repr, SCALES)))
    shown = values[numpy.isfinite(values)]
    above = shown[shown > 0]
    if not shown.size:
        return False, 0.0, 1.0
    if above.size and (scale == "log" or (
            scale == "auto" and shown.min() >= 0 and not is_signed
            and above.max() > LOG_MEDIANS * numpy.median(above))):
        low, high = numpy.percentile(above, LOG_PERCENT), above.max()
        return True, float(low), float(high if high > low else 2 * low)
    if is_signed:
        shown = numpy.concatenate((shown, -shown))
    low, high = numpy.percentile(shown, (100 - percentile, percentile))
    low = low if least is None else least
    share = OUTLIER_SHARE * (high - low)
    high = high if shown.max() > high + share else shown.max()
    low = low if least is not None or shown.min() < low - share else shown.min()
    return False, float(low), float(high if high > low else low + 1)


def draw_pixels(values: Any, spacing: tuple[float, float], unit: str | None, ax: Axes | None, *,
                origin: tuple[float, float] = (0.0, 0.0), label: str | None = None,
                cmap: str = "viridis", least: float | None = None, scale: str = "linear",
                percentile: float = 99.5, is_signed: bool = False) -> Axes:
    """Values on pixels in plan; x to the right, y upwards. `origin` is the centre of the first
    pixel. An arrow of the colour bar marks values beyond it, and the greatest stands above."""
    axes: Axes = new_axes(ax)
    colours = colours_of(values, scale, percentile, least, is_signed, cmap)
    drawn = axes.imshow(values, origin="lower", interpolation="nearest",
                        extent=extent_of(values.shape, spacing, origin), **colours)
    in_plan(axes, unit or "")
    if label:
        shown, norm = values[numpy.isfinite(values)], colours["norm"]
        beyond = 2 * bool((shown > norm.vmax).any()) + bool((shown < norm.vmin).any())
        bar = axes.figure.colorbar(drawn, ax=axes, label=label,
                                   extend=("neither", "min", "max", "both")[beyond])
        if beyond > 1:
            bar.ax.set_title(f"max {shown.max():.4g}", fontsize="x-small")
    return axes


def colours_of(values: Any, scale: str, percentile: float, least: float | None, is_signed: bool,
               cmap: str = "viridis") -> dict[str, Any]:
    """The map of colours of values, and their norm."""
    is_log, low, high = colour_limits(values, scale, percentile, least=least, is_signed=is_signed)
    return {"cmap": "RdBu_r" if is_signed else cmap,
            "norm": (colors.LogNorm if is_log else colors.Normalize)(low, high)}


def draw_states(state: Any, names: tuple[str, ...], spacing: tuple[float, float],
                unit: str | None, ax: Axes | None, origin: tuple[float, float]) -> Axes:
    """Pixels in one of the named states, a number from 0 each, with their shares in the legend."""
    axes: Axes = new_axes(ax)
    colours = [STATES.get(name, STATES["stick"]) for name in names]
    axes.imshow(state, origin="lower", interpolation="nearest", vmin=-0.5, vmax=len(names) - 0.5,
                cmap=colors.ListedColormap(colours), extent=extent_of(state.shape, spacing, origin))
    axes.legend(handles=[patches.Patch(facecolor=colour, edgecolor="0.5", label=(
        f"{name} {float((state == number).mean()):.1%}"))
        for number, (name, colour) in enumerate(zip(names, colours))],
        loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False, fontsize="small")
    in_plan(axes, unit or "")
    return axes


def shade_hills(heights: Any, spacing: tuple[float, float], axes: Axes,
                origin: tuple[float, float]) -> None:
    """Heights as grey hills in light from the upper left, below what is drawn next."""
    light = colors.LightSource(315, 45)
    filled = numpy.nan_to_num(heights, nan=float(numpy.nanmean(heights)))
    # The rms slope drawn is 1/2, whatever the unit of heights.
    slope = numpy.hypot(*(numpy.diff(filled, axis=axis).std() / spacing[1 - axis]
                          for axis in (0, 1)))
    grey = light.hillshade(filled[::-1], vert_exag=0.5 / slope if slope > 0 else 1.0,
                           dx=spacing[0], dy=spacing[1])[::-1]
    axes.imshow(grey, origin="lower", cmap="gray", vmin=-0.2, vmax=1.2,
                extent=extent_of(heights.shape, spacing, origin))


def draw_section(values: Any, across: Any, depth: Any, ax: Axes | None, *, label: str, unit: str,
                 scale: str, percentile: float, is_signed: bool) -> Axes:
    """Values by depth and place along x: the surface is above."""
    axes: Axes = new_axes(ax)
    drawn = axes.pcolormesh(across, depth, values, shading="nearest",
                            **colours_of(values, scale, percentile, None, is_signed))
    axes.invert_yaxis()
    axes.figure.colorbar(drawn, ax=axes, label=label)
    axes.set(xlabel=label_of("x", unit), ylabel=label_of("depth", unit))
    return axes


def extent_of(shape: tuple[int, ...], spacing: tuple[float, float],
              origin: tuple[float, float]) -> tuple[float, float, float, float]:
    """Left, right, lower and upper edge of pixels."""
    left, bottom = (start - step / 2 for start, step in zip(origin, spacing))
    return left, left + shape[1] * spacing[0], bottom, bottom + shape[0] * spacing[1]


def in_plan(axes: Axes, unit: str) -> None:
    axes.set(aspect="equal", xlabel=label_of("x", unit), ylabel=label_of("y", unit))


def picture_html(draw: Any) -> str:
    """A drawing as an element of HTML, for a notebook; empty without matplotlib."""
    try:
        axes = needed("matplotlib.figure", "plot", "a plot").Figure(
            figsize=(5.0, 4.0), layout="constrained").add_subplot()
    except ImportError:
        return ""
    draw(axes)
    buffer = io.BytesIO()
    axes.figure.savefig(buffer, dpi=70)
    return f"<img src='data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}'>"
