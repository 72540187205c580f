"""The solver's pair search against a search in numpy that shares nothing with it but the formulas.

The numpy search looks up nine square cells around every asperity, decade of radius by decade of
radius. Contacts of `asperity solve` must be the same, pair for pair, in the same order;
penetrations are computed another way (touching_level), so they agree within rounding. The unit
tests compare pairs within the margin of the search, also of shorter numbers.
"""

import math

import numpy as np
import pytest

from programs import run_program
from placed_asperities import Surface
from surfaces_csv import records

N = 100_000
SIDE = (N / 0.48) ** 0.5


def uniform(rng, n=N, side=SIDE, radius=1.27):
    return Surface(rng.random(n) * side, rng.random(n) * side,
                   rng.normal(0.127, 0.03, n).clip(0.0, 0.17), radius)


def clusters(rng, spread):
    """Dense clusters and a thin background over an enormous plane, negative places included."""
    centres = (rng.random((300, 2)) - 0.5) * spread
    which = rng.integers(0, len(centres), N)
    width = 10.0 ** rng.uniform(0.0, 1.0, len(centres))[which]
    places = centres[which] + rng.normal(0.0, 1.0, (N, 2)) * width[:, None] * 3.0
    places[:1000] = (rng.random((1000, 2)) - 0.5) * spread
    return Surface(*places.T, rng.random(N) * 0.17, 1.27)


def twins(rng, surface, shift):
    """A surface whose asperities lie near those of another: pairs wherever that one has any."""
    n = len(surface)
    return Surface(surface.x + rng.normal(0.0, 0.5, n) * surface.radius - shift[0],
                   surface.y + rng.normal(0.0, 0.5, n) * surface.radius - shift[1],
                   rng.permutation(surface.height), rng.permutation(surface.radius))


def mixed(rng, decades):
    """Radii over decades, as many small ones more as leave each decade as dense."""
    radius = 10.0 ** rng.exponential(0.25, N).clip(0.0, decades)
    return Surface(rng.random(N) * SIDE, rng.random(N) * SIDE, rng.random(N) * 0.1,
                   0.1 * radius)


def lattice(_rng):
    """Places and heights that repeat: ties in every separation."""
    k = np.arange(N)
    return Surface(k % 316 * 0.75, k // 316 * 0.75, k % 3 * 0.0625, 1.25)


def bound_on_squares(upper, lower, height):
    """No height: spheres that can touch."""
    s = upper + lower
    return s * s if height is None else np.minimum(s * s, 2.0 * s * height)


def cell_pairs(ux, uy, lx, ly, cell):
    """All pairs of asperities in the same or neighbouring square cells."""
    columns = np.floor(lx / cell)
    rows = np.floor(ly / cell)
    order = np.lexsort((columns, rows))
    keys, begins, counts = np.unique(np.column_stack((rows, columns))[order], axis=0,
                                     return_index=True, return_counts=True)
    keys = keys[:, 0] + 1j * keys[:, 1]  # compared by row, then by column
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            wanted = np.floor(uy / cell) + i + 1j * (np.floor(ux / cell) + j)
            at = np.searchsorted(keys, wanted).clip(0, len(keys) - 1)
            number = np.where(keys[at] == wanted, counts[at], 0)
            upper = np.repeat(np.arange(len(ux)), number)
            first = np.repeat(np.cumsum(number) - number, number)
            yield upper, order[np.repeat(begins[at], number) + np.arange(len(upper)) - first]


def numpy_search(upper, lower, shift, height):
    """Indices and squares of the distances of all pairs, by upper, then lower index."""
    x, y = upper.x + shift[0], upper.y + shift[1]
    found = []
    decades = [np.floor(np.log10(surface.radius)) for surface in (upper, lower)]
    for a in np.unique(decades[0]):
        for b in np.unique(decades[1]):
            ups, downs = np.flatnonzero(decades[0] == a), np.flatnonzero(decades[1] == b)
            cell = 1.001 * bound_on_squares(
                upper.radius[ups].max(), lower.radius[downs].max(), height) ** 0.5
            for i, j in cell_pairs(x[ups], y[ups], lower.x[downs], lower.y[downs], cell):
                i, j = ups[i], downs[j]
                squared = (x[i] - lower.x[j]) ** 2 + (y[i] - lower.y[j]) ** 2
                near = squared < bound_on_squares(upper.radius[i], lower.radius[j], height)
                found.append((i[near], j[near], squared[near]))
    i, j, squared = map(np.concatenate, zip(*found))
    order = np.lexsort((j, i))
    return i[order], j[order], squared[order]


def touching_level(upper, lower, i, j, squared):
    """Approach at which two spheres touch: the height between level centres, less both sinks."""
    s = upper.radius[i] + lower.radius[j]
    return upper.height[i] + lower.height[j] - (s - np.sqrt(s * s - squared))


# Surfaces, displacement, height that bounds pairs (none: all that can touch).
CASES = {
    "uniform": (lambda rng: (uniform(rng), uniform(rng)), (0.0, 0.0), 0.178),
    "uniform displaced": (lambda rng: (uniform(rng), uniform(rng)), (31.7, -12.4), 0.178),
    "uniform, unequal": (lambda rng: (uniform(rng), uniform(rng, radius=2.0)), (0.3, 0.2), 0.17),
    "all that can touch": (lambda rng: (uniform(rng, radius=0.5), uniform(rng, radius=0.7)),
                           (0.1, 0.0), None),
    "small on large": (lambda rng: (uniform(rng, radius=0.1), uniform(rng, radius=25.0)),
                       (0.0, 0.1), 0.17),
    "large on small": (lambda rng: (uniform(rng, radius=25.0), uniform(rng, radius=0.1)),
                       (0.0, 0.1), 0.17),
    "clusters": (lambda rng: pair_with(rng, clusters(rng, 1.0e5), (2.0, 1.0)), (2.0, 1.0), 0.178),
    "clusters far apart": (lambda rng: pair_with(rng, clusters(rng, 1.0e10), (0.0, 1.0)),
                           (0.0, 1.0), 0.178),
    "mixed radii": (lambda rng: pair_with(rng, mixed(rng, 2), (0.5, 0.1)), (0.5, 0.1), 0.05),
    "mixed radii, all that can touch": (lambda rng: (mixed(rng, 1.5), mixed(rng, 1.5)),
                                        (0.0, 0.0), None),
    "lattice": (lambda rng: (lattice(rng), lattice(rng)), (0.125, 0.125), 0.2),
}


def pair_with(rng, surface, shift):
    return twins(rng, surface, shift), surface


def write_surface(path, surface):
    table = np.column_stack((surface.x, surface.y, surface.height, surface.radius))
    np.savetxt(path, table, "%.17g", ",", header="x,y,height,radius", comments="")


@pytest.mark.truth
@pytest.mark.parametrize("name", CASES)
def test_contacts_are_those_of_all_pairs_in_the_order_of_touch(name, asperity, tmp_path):
    """`asperity solve` has the contacts of all pairs down to an approach, in the order of touch:
    by gap, equal gaps by distance, sum of radii, combined radius, indices."""
    make, shift, height = CASES[name]
    upper, lower = make(np.random.default_rng(sorted(CASES).index(name)))
    i, j, squared = numpy_search(upper, lower, shift, height)
    assert len(i) > 10_000
    touch = touching_level(upper, lower, i, j, squared)
    # Pairs within the height that bounds them are all that touch above this.
    least = upper.height.max() + lower.height.max() - (CASES[name][2] or 1.0)
    level = float(max(np.sort(touch)[-5000] - 1e-3, least))
    write_surface(tmp_path / "upper.csv", upper)
    write_surface(tmp_path / "lower.csv", lower)

    def solved(control, value):
        """Indices of the contacts, penetrations, and the load."""
        scene = tmp_path / "pairs.scene"
        scene.write_text(
            "&surfaces upper = 'upper.csv', lower = 'lower.csv' /\n"
            "&material elastic_modulus = 2*1.0, poisson_ratio = 2*0.3 /\n"
            f"&motion x_first = {shift[0]}, y_first = {shift[1]}, positions = 1 /\n"
            f"&loading control = '{control}', value = {value!r} /\n"
            "&effects interaction = 'off' /\n", encoding="ascii")
        run_program(asperity, "solve", scene, "--quiet", "--contacts", tmp_path / "c.csv")
        rows = records(tmp_path / "c.csv")
        return (*(np.array([int(row[key]) - 1 for row in rows]) for key in ("upper", "lower")),
                np.array([float(row["penetration"]) for row in rows]),
                math.fsum(float(row["load"]) for row in rows))

    up, low, penetration, load = solved("separation", level)

    # s - sqrt(s*s - d*d) loses at most a few units of s; where d is near s its root magnifies
    # them by s/zc.
    s = upper.radius[i] + lower.radius[j]
    allowed = 4e-16 * s * (1.0 + s / np.sqrt(np.maximum(s * s - squared, 1e-18 * s * s))) + 1e-16
    key, truth = up * len(lower) + low, i * len(lower) + j
    assert len(np.unique(key)) == len(key) > 100
    assert np.isin(truth[touch > level + allowed], key).all()
    assert np.isin(key, truth[touch >= level - allowed]).all()
    at = np.searchsorted(truth, key)
    met = np.abs(touch[at] - level - penetration) <= 2.0 * allowed[at]
    assert met.all()

    s, d = s[at], np.sqrt(squared[at])
    exact = (upper.height[up] + lower.height[low]) - \
        squared[at] / (s + np.sqrt((s - d) * (s + d)))
    combined = upper.radius[up] * lower.radius[low] / s
    wanted = np.lexsort((low, up, combined, s, d, exact.max() - exact))
    assert np.array_equal(wanted, np.arange(len(up)))
    # Under their load, whose compression bounds the search from above, the same contacts are found.
    again = solved("load", load)
    deep = penetration > 1e-6 * penetration.max()
    assert np.isin(key[deep], again[0] * len(lower) + again[1]).all()
    assert np.isin(again[0] * len(lower) + again[1], key).all()
