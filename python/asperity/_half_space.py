"""A body under arrays of pressures and tractions."""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import POINTER, c_double
from typing import Any

from . import _arguments as _a
from . import _library as _c
from ._columns import Lazy, NDArray, Table

numpy: Any = Lazy("numpy", "numpy", "HalfSpace")


class HalfSpace:
    """An elastic half-space, or a layer on one, under arrays of pixels.

    Pressures and displacements have the shape (rows, columns) and are indexed `[y, x]`; z points
    into the body. On a periodic side the mean displacement is 0, but on a layer with a rigid base.

    Args:
        shape: Rows and columns.
        spacing: Distance of pixels, or along x and y.
        modulus: Young's modulus, 0 for a rigid base under a layer.
        poisson: Poisson's ratio.
        periodic: Whether the body repeats itself, or along x and y; else there is no load beyond.
        layer: Thickness, Young's modulus, Poisson's ratio of a bonded layer, not on strips.

    Examples:
        >>> import numpy as np
        >>> body = asperity.HalfSpace((64, 64), 1 / 64, 1.0, 0.3, periodic=True)
        >>> wave = np.tile(np.cos(2 * np.pi * np.arange(64) / 64), (64, 1))
        >>> print(f"{body.displacement(wave).max():.6f}")  # 2 (1 - nu**2)/(E q)
        0.289662
    """

    def __init__(self, shape: tuple[int, int], spacing: float | tuple[float, float],
                 modulus: float, poisson: float, *, periodic: bool | tuple[bool, bool] = False,
                 layer: tuple[float, float, float] | None = None):
        self.shape = int(shape[0]), int(shape[1])
        sides = spacing if isinstance(spacing, (list, tuple)) else (spacing, spacing)
        edges = periodic if isinstance(periodic, (list, tuple)) else (periodic, periodic)
        thickness, *surface = layer or (0.0, modulus, poisson)
        self._body = _c.Body(self.shape[1], self.shape[0], tuple(sides), tuple(edges),
                             (surface[0], modulus), (surface[1], poisson), thickness)

    def displacement(self, pressure: Any, tractions: Any = None) -> NDArray[Any]:
        """Normal displacement by pressures. With `tractions` along x and y, the three
        displacements along x, y and z by both, of shape (3, rows, columns); not on a layer."""
        table = loaded(self._body, _c.DISPLACEMENTS, self._arrays(pressure, tractions))
        names = "z" if tractions is None else "xyz"
        found = [numpy.reshape(table[f"displacement_{name}"], self.shape) for name in names]
        return found[0] if tractions is None else numpy.stack(found)  # type: ignore[no-any-return]

    def pressure(self, displacement: Any) -> NDArray[Any]:
        """The pressures, positive and negative ones, that give normal displacements."""
        table = loaded(self._body, _c.PRESSURES, self._arrays(displacement, None))
        return numpy.array(table["pressure"]).reshape(self.shape)  # type: ignore[no-any-return]

    def stress(self, depths: Any, pressure: Any, tractions: Any = None) -> dict[str, NDArray[Any]]:
        """Stresses by name, as of `Results.stress`, of shape (depths, rows, columns)."""
        return stresses(self._body, self.shape, depths, self._arrays(pressure, tractions))

    def _arrays(self, values: Any, tractions: Any) -> list[Any]:
        """Arrays of numbers of the shape."""
        arrays = [numpy.ascontiguousarray(one, float) for one in (
            values, *(() if tractions is None else tractions))]
        for one in arrays:
            if one.shape != self.shape:
                raise _a.wrong("pixels", f"an array of shape {one.shape}", f"{self.shape}")
        return arrays


def stresses(body: _c.Body, shape: tuple[int, int], depths: Any,
             arrays: Sequence[Any]) -> dict[str, NDArray[Any]]:
    """Stresses by name, of shape (depths, rows, columns), under pressures and both tractions."""
    tables = [loaded(body, _c.STRESSES, arrays, float(depth)) for depth in numpy.atleast_1d(depths)]
    return {name.removeprefix("stress_"): numpy.stack(
        [numpy.reshape(table[name], shape) for table in tables]) for name in tables[0]}


def loaded(body: _c.Body, what: int, arrays: Sequence[Any], depth: float = 0.0) -> Table:
    """A table of a body under pressures, or displacements, and where given both tractions."""
    numbers: Any = POINTER(c_double)
    addresses = [one.ctypes.data_as(numbers) for one in arrays] + [None] * (3 - len(arrays))
    return _c.call("loaded", body, what, *addresses, depth).checked().table(_c.FIELDS, "pixels")
