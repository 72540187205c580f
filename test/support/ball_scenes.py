"""Scenes of balls one above the other, for tests of a law of contact, and how they are compared."""

from itertools import pairwise

import numpy as np

from surfaces_csv import solve, write_csv_scene

# Far enough apart for balls of one scene not to meet their neighbours'.
APART = 1000.0


def balls(folder, name, effects, loading, radii=(1.0,), gaps=(0.0,), modulus=1.0, ratio=0.0,
          **groups):
    """Aligned pairs with combined radii, of which each touches when the closing is its gap.

    `modulus` is the combined one. The planes are 0 apart at first touch, so that an approach is
    minus the closing, without rounding.
    """
    body = 2 * modulus * (1 - ratio**2)
    upper = [(APART * i, 0.0, 0.0, 2 * r) for i, r in enumerate(radii)]
    lower = [(APART * i, 0.0, -gap, 2 * r) for i, (r, gap) in enumerate(zip(radii, gaps))]
    return write_csv_scene(folder, upper, lower, name=name, modulus=(body, body),
                           ratio=(ratio, ratio), loading=loading, effects=effects, **groups)


def solved(asperity, scene, *options, **wanted):
    """A run that must succeed, with all its files."""
    run = solve(asperity, scene, *options, curve=True, **wanted)
    assert run.status == 0, run.stderr
    return run


def path(values, points=None):
    """Approaches for closings."""
    loading = {"control": "approach", "value": tuple(-float(v) for v in values)}
    return {**loading, "points": points} if points else loading


def column(rows, name):
    """A column as numbers."""
    return np.array([float(row[name]) for row in rows])


def work(curve, load="vertical_load"):
    """Work done by the closing up to each state, by the trapezoidal rule."""
    closing, force = column(curve, "compression"), column(curve, load)
    return np.concatenate([[0.0], np.cumsum(np.diff(closing) * (force[1:] + force[:-1]) / 2)])


def off(found, true):
    """Relative errors; the truth may have many digits."""
    return np.array([abs(float((f - t) / t)) if t else abs(float(f))
                     for f, t in zip(found, true, strict=True)])


def compare(tally, name, errors, bound):
    """Print the worst and hold it against the bound; each number is a cell of the tally."""
    errors = np.atleast_1d(np.asarray(errors, float))
    assert errors.size, f"{name}: nothing compared"
    met = errors <= bound
    tally.add(name, errors.size, int(met.sum()))
    worst = errors.max()
    print(f"{name}: {errors.size} compared, worst {worst:.2g}, allowed {bound:.2g}")
    assert met.all(), f"{name}: worst {worst:.3g} of {errors.size}, allowed {bound:.2g}"


def rises(values):
    """Whether numbers never fall."""
    return all(b >= a for a, b in pairwise(values))
