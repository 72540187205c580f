"""Pressure, gap and displacement on the pixels of a height map or of a grid."""

from __future__ import annotations

import html
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, cast

from . import _arguments as _a
from . import _library as _c
from ._columns import (Axes, Column, Lazy, NDArray, in_rows, label_of, needed, numpy, shown,
                       xarray)
from ._errors import AccuracyWarning, warn_caller
from ._plots import (STATES, draw_pixels, draw_section, draw_states, new_axes, picture_html,
                     shade_hills)

np: Any = Lazy("numpy", "numpy", "an array of fields")
NAMES = ("pressure", "gap", "displacement", "contact")
# With friction on pixels alone.
SLIP_NAMES = ("traction_x", "traction_y", "slip_x", "slip_y", "stick")
# Arrays of yes and no.
FLAGS = ("contact", "stick")
# States that a solve keeps the fields of, by the argument of `solve`.
NONE, LAST, ALL = 0, 1, 2


class Arrays:
    """Arrays that are attributes and the values of a mapping."""

    _kind = ""
    _names: tuple[str, ...]
    if TYPE_CHECKING:
        def __getattr__(self, name: str) -> NDArray[Any]: ...

    def keys(self) -> tuple[str, ...]:
        """The names of the arrays."""
        return self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name not in self._names:
            raise KeyError(f"no {self._kind} {name!r}: {', '.join(self._names)}")
        return cast("NDArray[Any]", getattr(self, name))

    def _checked(self, name: str) -> None:
        if name not in self._names:
            raise _a.wrong("name", repr(name), ", ".join(map(repr, self._names)))

    def _repr_html_(self: Any) -> str:
        return f"<p>{html.escape(repr(self)[1:-1])}</p>" + picture_html(
            lambda axes: self.plot(ax=axes))


class Fields(Arrays):
    """Pressure, gap and displacement of one state, on the pixels of a height map or on a grid.

    The arrays have the shape (rows, columns) and are indexed `[row, column]` = `[y, x]`, as the map
    is. They are read-only and NaN at missing pixels; without numpy they are sequences of rows.
    `fields["pressure"]` is `fields.pressure`, and `dict(fields)` has all by their names.

    Attributes:
        pressure: Contact pressure, 0 out of contact. Its sum times the area of a pixel is the load.
        gap: Distance of the deformed surfaces, 0 in contact.
        displacement: Sum of the elastic displacements of both surfaces, more than 0 apart from each
            other. On a periodic map its mean is 0.
        contact: True where the pixel is in contact.
        traction_x, traction_y, slip_x, slip_y, stick: Under a tangential load or with coupling:
            traction on the lower body, slip of the upper body over it, True where a pixel sticks.
        spacing: Distance of pixels along x and y.
        origin: Centre of the first pixel; 0, 0 on a height map.
        periodic: Whether the pixels repeat along x and y; None where a file does not have it.
        unit: Unit of gap, displacement, spacing and origin.
        units: Unit of each array, empty where it is not known.
        position: Position of the motion, from 1.
        step: Number of the state, from 1, as in the column `step` of the states.
        boundary_contacts, hertz_contacts: On a grid: contacts with the pressure of boundary
            elements, and with that of Hertz.
    """

    _kind = "field"

    def __init__(self, outcome: _c.Outcome, position: int, step: int):
        facts, table = outcome.facts(_c.MAP), outcome.table(_c.FIELDS, "pixels")
        self.shape: tuple[int, int] = int(facts["rows"]), int(facts["columns"])
        self.spacing: tuple[float, float] = facts["spacing_x"], facts["spacing_y"]
        self.origin: tuple[float, float] = facts["origin_x"], facts["origin_y"]
        self.periodic: tuple[bool, bool] | None = (bool(facts["periodic_x"]),
                                                   bool(facts["periodic_y"]))
        self.boundary_contacts, self.hertz_contacts = (
            int(facts[name]) if facts[name] >= 0 else None
            for name in ("boundary_contacts", "hertz_contacts"))
        self._names = NAMES + tuple(name for name in SLIP_NAMES if name in table)
        self.unit: str | None = outcome.text(_c.UNIT) or None
        self.units: dict[str, str] = {name: table.units[name] for name in self._names}
        self.position, self.step = position, step
        for name in self._names:
            setattr(self, name, in_rows(table[name], self.shape, name in FLAGS))

    def to_xarray(self) -> xarray.Dataset:
        """The arrays as a dataset with the coordinates `y` and `x`, the centres of the pixels,
        `position` and `step`; `attrs["units"]` of each variable is its unit."""
        places = {axis: (axis, [start + number * step for number in range(count)], {
            "units": self.unit or ""}) for axis, start, step, count in zip(
                "xy", self.origin, self.spacing, self.shape[::-1])}
        return cast("xarray.Dataset", needed("xarray", "xarray", "a dataset").Dataset(
            {name: (("y", "x"), self[name], {"units": self.units[name]}) for name in self._names},
            {**places, "position": self.position, "step": self.step}))

    def plot(self, name: str = "pressure", ax: Axes | None = None, *, scale: str = "auto",
             percentile: float = 99.5, on: Any = None) -> Axes:
        """Draw one of the arrays in plan on axes of matplotlib, new ones without `ax`.

        Pixels out of contact have no colour in pressure, tractions and slip, those in contact none
        in the gap; `contact` and `stick` have a legend with shares of the area.

        Args:
            scale: `linear`, `log`, or `auto`: `log` where the greatest value exceeds 20 medians.
            percentile: Where a linear scale ends if few values are far beyond.
            on: Heights of the same pixels, drawn as hills in oblique light below the array.
        """
        self._checked(name)
        place = self.spacing, self.unit
        if name in FLAGS:
            names = ("no contact", "contact") if name == "contact" else tuple(STATES)
            return draw_states(self._drawn(name), names, *place, ax, self.origin)
        if on is not None:
            heights = np.ma.filled(np.ma.asarray(getattr(on, "heights", on), float), math.nan)
            if heights.shape != self.shape:
                raise _a.wrong("on", f"an array of shape {heights.shape}", f"{self.shape}")
            ax = new_axes(ax)
            shade_hills(heights, self.spacing, ax, self.origin)
        return draw_pixels(self._drawn(name), *place, ax, origin=self.origin, scale=scale,
                           label=label_of(name, self.units[name]), percentile=percentile,
                           least=0.0 if name in ("pressure", "gap") else None)

    def _drawn(self, name: str) -> Any:
        """The values of an array that a picture has, NaN elsewhere; of stick 1 where it slips."""
        if name in FLAGS:
            return np.asarray(self.contact, int) + (
                np.logical_and(self.contact, self.stick) if name == "stick" else 0)
        return np.asarray(self[name]) if name == "displacement" else np.where(
            self.contact == (name != "gap"), self[name], math.nan)

    def __repr__(self) -> str:
        unit = f" {self.units['pressure']}" if self.units["pressure"] else ""
        pressed = pressures(self)
        return f"<asperity.Fields of {self.shape[1]} x {self.shape[0]} pixels: step {self.step}, " \
               f"pressure 0 to {shown(float(max(pressed, default=0.0)))}{unit}, " \
               f"{len(pressed)} pixels in contact>"


class Stress(Arrays):
    """Stress in a body below the pixels of one state; tension is positive, z points into the body.

    `stress["xx"]` and `stress.xx` are arrays with the shape (depths, rows, columns).

    Attributes:
        depth: Depths below the surface.
        xx, yy, zz, xy, xz, yz: Components.
        von_mises, largest_shear: Von Mises stress, and half of the difference of the principal
            stresses.
        unit: Unit of the stresses, empty where it is not known.
    """

    _kind = "stress"

    def __init__(self, fields: Fields, depths: Any, arrays: dict[str, NDArray[Any]]):
        self.depth: NDArray[Any] = depths
        self.unit = fields.units["pressure"]
        self._fields = fields
        self._names = tuple(arrays)
        vars(self).update(arrays)

    def __repr__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        return f"<asperity.Stress at {len(self.depth)} depths: step {self._fields.step}, " \
               f"von Mises up to {shown(float(self.von_mises.max()))}{unit}>"

    def plot(self, name: str = "von_mises", ax: Axes | None = None, *, depth: float | None = None,
             y: float | None = None, scale: str = "linear", percentile: float = 99.9) -> Axes:
        """Draw one of the arrays in plan at the `depth`, that of the largest value unless given, or
        in a section along x at `y`, with the surface above; components with a sign have white at 0.
        `scale` and `percentile` are as of `Fields.plot`."""
        self._checked(name)
        at, unit = self._fields, self._fields.unit or ""
        how: dict[str, Any] = {"scale": scale, "percentile": percentile,
                               "label": label_of(name, self.unit),
                               "is_signed": name not in ("von_mises", "largest_shear")}
        if y is None:
            near = self.depth - (self.largest(name)[1] if depth is None else depth)
            level = int(np.abs(near).argmin())
            axes = draw_pixels(self[name][level], at.spacing, at.unit, ax, origin=at.origin, **how)
            axes.set_title(f"depth {shown(float(self.depth[level]))} {unit}", fontsize="medium")
            return axes
        if len(self.depth) < 2:
            raise _a.wrong("y", "stresses at one depth", "stresses at two depths or more")
        order = self.depth.argsort()
        row = min(max(round((y - at.origin[1]) / at.spacing[1]), 0), at.shape[0] - 1)
        across = at.origin[0] + np.arange(at.shape[1]) * at.spacing[0]
        axes = draw_section(self[name][order, row], across, self.depth[order], ax, unit=unit, **how)
        axes.set_title(f"y = {shown(float(at.origin[1] + row * at.spacing[1]))} {unit}",
                       fontsize="medium")
        return axes

    def largest(self, name: str = "von_mises") -> tuple[float, float, float, float]:
        """The largest value of an array, with its depth, x and y."""
        depth, row, column_ = map(int, np.unravel_index(self[name].argmax(), self[name].shape))
        at = self._fields
        near: Any = at.contact[max(0, row - 1):row + 2, max(0, column_ - 1):column_ + 2]
        if self.depth[depth] < min(at.spacing) and near.any() and not near.all():
            warn_caller(f"the largest {name} is on the rim of the contact: it grows with the "
                        "resolution", AccuracyWarning)
        return (float(self[name][depth, row, column_]), float(self.depth[depth]),
                at.origin[0] + column_ * at.spacing[0], at.origin[1] + row * at.spacing[1])


def states_kept(fields: Any) -> int:
    """The states whose fields a solve keeps."""
    if isinstance(fields, str) and fields != "all":
        raise _a.wrong("fields", repr(fields), "True, False or 'all'")
    return ALL if isinstance(fields, str) else LAST if _a.flag("fields", fields) else NONE


def pressures(fields: Fields) -> Any:
    """The pressures of the pixels in contact."""
    return fields.pressure[fields.contact] if numpy() else [
        value for row in cast("Any", fields.pressure) for value in row if value > 0]


def histogram(fields: Fields, bins: int) -> tuple[Column, Column]:
    """Pressures in the middle of bins up to the greatest, and the density of the area there."""
    pressed = pressures(fields)
    greatest = float(pressed.max(initial=0.0))
    width, counts = greatest / bins, np.histogram(pressed, bins, (0.0, greatest or 1.0))[0]
    measured = (fields.pressure >= 0).sum()
    return ((np.arange(bins) + 0.5) * width,
            counts / (measured * width) if width else np.zeros(bins))
