"""A body under arrays of pressures and tractions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import _library as _c
from ._columns import Table, needed

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence


def stresses(body: _c.Body, pressure: Any, tractions: Sequence[Any],
             depths: Iterable[float]) -> list[Table]:
    """A table of stresses for each depth; tractions are one along x, both, or none."""
    library: Any = needed("numpy", "stress", "stresses")
    arrays = [library.ascontiguousarray(one, float) for one in (pressure, *tractions)]
    arrays += [library.zeros_like(arrays[0])] * (len(arrays) == 2)
    places = [one.ctypes.data for one in arrays] + [None] * (3 - len(arrays))
    return [_c.call("stress", body, *places, float(depth)).checked().table(_c.FIELDS, "pixels")
            for depth in depths]
