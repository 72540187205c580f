"""Scenes of balls one above the other, for tests of a law of contact."""

import numpy as np

from judge import column
from surfaces_csv import write_csv_scene

# Far enough apart for balls of one scene not to meet their neighbours'.
APART = 1000.0


def balls(folder, name, effects, loading, radii=(1.0,), gaps=(0.0,), modulus=1.0, ratio=0.0,
          **groups):
    """Aligned pairs with combined radii, of which each touches when the compression is its gap.

    `modulus` is the combined one. The planes are 0 apart at first touch, so that an approach is
    minus the compression, without rounding.
    """
    body = 2 * modulus * (1 - ratio**2)
    upper = [(APART * i, 0.0, 0.0, 2 * r) for i, r in enumerate(radii)]
    lower = [(APART * i, 0.0, -gap, 2 * r) for i, (r, gap) in enumerate(zip(radii, gaps))]
    return write_csv_scene(folder, upper, lower, name=name, modulus=(body, body),
                           ratio=(ratio, ratio), loading=loading, effects=effects, **groups)


def path(values, points=None):
    """Approaches for compressions."""
    loading = {"control": "approach", "value": tuple(-float(v) for v in values)}
    return {**loading, "points": points} if points else loading


def work(curve, load="vertical_load"):
    """Work done by the compression up to each state, by the trapezoidal rule."""
    closing, force = column(curve, "compression"), column(curve, load)
    return np.concatenate([[0.0], np.cumsum(np.diff(closing) * (force[1:] + force[:-1]) / 2)])
