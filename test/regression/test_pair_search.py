"""The pair search against a search in numpy that shares nothing with it but the formulas.

The numpy search looks up nine square cells around every asperity, decade of radius by decade of
radius. Pairs must be the same, pair for pair; square distances are the same two products and one
sum in doubles, so the same bits; separations are computed another way (touching_level), so they
agree within rounding.
"""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench"))

from search_files import HUGE, Surface, read_pairs, run_search, search_program, write_input

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


def bound_on_squares(upper, lower, reach):
    s = upper + lower
    bound = s * s
    bound = np.minimum(bound, np.where(reach.get("distance", HUGE) < s,
                                       min(reach.get("distance", HUGE), 1e100) ** 2, HUGE))
    return np.minimum(bound, 2.0 * s * min(reach.get("height", HUGE), 1e100))


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


def numpy_search(upper, lower, shift, reach):
    """Indices and squares of the distances of all pairs, by upper, then lower index."""
    x, y = upper.x + shift[0], upper.y + shift[1]
    found = []
    decades = [np.floor(np.log10(surface.radius)) for surface in (upper, lower)]
    for a in np.unique(decades[0]):
        for b in np.unique(decades[1]):
            ups, downs = np.flatnonzero(decades[0] == a), np.flatnonzero(decades[1] == b)
            cell = 1.001 * bound_on_squares(
                upper.radius[ups].max(), lower.radius[downs].max(), reach) ** 0.5
            for i, j in cell_pairs(x[ups], y[ups], lower.x[downs], lower.y[downs], cell):
                i, j = ups[i], downs[j]
                squared = (x[i] - lower.x[j]) ** 2 + (y[i] - lower.y[j]) ** 2
                near = squared < bound_on_squares(upper.radius[i], lower.radius[j], reach)
                found.append((i[near], j[near], squared[near]))
    i, j, squared = map(np.concatenate, zip(*found))
    order = np.lexsort((j, i))
    return i[order], j[order], squared[order]


def touching_level(upper, lower, i, j, squared):
    """Approach at which two spheres touch: the height between level centres, less both sinks."""
    s = upper.radius[i] + lower.radius[j]
    return upper.height[i] + lower.height[j] - (s - np.sqrt(s * s - squared))


CASES = {
    "uniform": (lambda rng: (uniform(rng), uniform(rng)), (0.0, 0.0), {"distance": 0.95}),
    "uniform displaced": (lambda rng: (uniform(rng), uniform(rng)), (31.7, -12.4),
                          {"distance": 0.95}),
    "uniform by height": (lambda rng: (uniform(rng), uniform(rng, radius=2.0)), (0.3, 0.2),
                          {"height": 0.17}),
    "all that can touch": (lambda rng: (uniform(rng, radius=0.5), uniform(rng, radius=0.7)),
                           (0.1, 0.0), {}),
    "small on large": (lambda rng: (uniform(rng, radius=0.02), uniform(rng, radius=5.0)),
                       (0.0, 0.1), {"height": 0.17}),
    "large on small": (lambda rng: (uniform(rng, radius=5.0), uniform(rng, radius=0.02)),
                       (0.0, 0.1), {"height": 0.17}),
    "clusters": (lambda rng: pair_with(rng, clusters(rng, 1.0e5), (2.0, 1.0)), (2.0, 1.0),
                 {"distance": 0.95}),
    "clusters far apart": (lambda rng: pair_with(rng, clusters(rng, 1.0e10), (0.0, 1.0)),
                           (0.0, 1.0), {"distance": 0.95}),
    "mixed radii": (lambda rng: pair_with(rng, mixed(rng, 2), (0.5, 0.1)), (0.5, 0.1),
                    {"height": 0.05}),
    "mixed radii, all that can touch": (lambda rng: (mixed(rng, 1.5), mixed(rng, 1.5)),
                                        (0.0, 0.0), {}),
    "lattice": (lambda rng: (lattice(rng), lattice(rng)), (0.125, 0.125), {"distance": 1.0}),
}


def pair_with(rng, surface, shift):
    return twins(rng, surface, shift), surface


@pytest.fixture(scope="module")
def program():
    return search_program()


@pytest.fixture(scope="module", params=CASES)
def case(request, program, tmp_path_factory):
    """Surfaces, the truth, and what the search found, in the order of touch."""
    make, shift, reach = CASES[request.param]
    upper, lower = make(np.random.default_rng(sorted(CASES).index(request.param)))
    folder = tmp_path_factory.mktemp("pairs")

    def search(**wanted):
        write_input(folder / "in", upper, lower, shift=shift, **reach, **wanted)
        run_search(program, folder / "in", folder / "out")
        return read_pairs(folder / "out", ordered=wanted.get("margin", -1.0) < 0.0)

    return request.param, upper, lower, numpy_search(upper, lower, shift, reach), search


def test_pairs_and_separations(case, tally):
    name, upper, lower, (i, j, squared), search = case
    assert len(i) > 10_000
    up, low, touch, square = search()
    order = np.lexsort((low, up))
    assert np.array_equal(up[order], i)
    assert np.array_equal(low[order], j)
    assert np.array_equal(square[order], squared)
    # s - sqrt(s*s - d*d) loses at most a few units of s; where d is near s its root magnifies
    # them by s/zc.
    s = upper.radius[i] + lower.radius[j]
    rise = np.sqrt(np.maximum(s * s - squared, 1e-18 * s * s))
    allowed = 4e-16 * s * (1.0 + s / rise) + 1e-16
    met = np.abs(touch[order] - touching_level(upper, lower, i, j, squared)) <= allowed
    assert met.all()
    tally.add(f"pairs: {name}", len(i), int(met.sum()))

    # The order: by gap, equal gaps by distance, sum of radii, combined radius, indices.
    s = upper.radius[up] + lower.radius[low]
    combined = upper.radius[up] * lower.radius[low] / s
    wanted = np.lexsort((low, up, combined, s, np.sqrt(square), touch[0] - touch))
    assert np.array_equal(wanted, np.arange(len(up)))

    # The first of them, and those above a level, are the same without the others.
    few = len(up) // 7
    for got in (search(most=few), search(floor=float(touch[few]))):
        assert few <= len(got[0]) < few + len(up) // 2
        for a, b in zip(got, (up, low, touch, square)):
            assert np.array_equal(a[:few], b[:few])


def test_candidates_with_margin(case):
    """No pair is lost, few are added, and none is left out that a shorter arithmetic may keep."""
    _name, upper, lower, (i, j, squared), search = case
    up, low = search(margin=1e-6)
    assert np.array_equal(np.lexsort((low, up)), np.arange(len(up)))
    key, truth = (a.astype(np.int64) * len(lower) + b for a, b in ((up, low), (i, j)))
    assert np.isin(truth, key).all()
    assert len(up) <= 1.01 * len(i) + 100
    level = float(np.quantile(touching_level(upper, lower, i, j, squared), 0.9))
    up, low = search(margin=1e-6, floor=level)
    key = up.astype(np.int64) * len(lower) + low
    high = touching_level(upper, lower, i, j, squared) > level
    assert np.isin(truth[high], key).all()
    assert len(up) < 0.5 * len(i)


def test_candidates_of_a_shorter_arithmetic(program, tmp_path, tally):
    """What counts as near by the solver's steps in 24 bits is a candidate by the margin for them.

    The margin of `margin_of_arithmetic`: 8 units of the last place of the largest length.
    """
    rng = np.random.default_rng(5)
    short = np.float32
    shift = short(0.3), short(-0.7)
    upper, lower = (Surface(*(a.astype(short) for a in (s.x, s.y, s.height)), short(1.27))
                    for s in (uniform(rng), uniform(rng)))
    # Pairs at the very edge of the reach, where rounding decides.
    height = short(0.17)
    angle, edge = 6.28 * rng.random(20_000), (2 * 2.54 * 0.17) ** 0.5
    upper.x[:20_000] = (lower.x[:20_000] - shift[0] + edge * np.cos(angle)).astype(short)
    upper.y[:20_000] = (lower.y[:20_000] - shift[1] + edge * np.sin(angle)).astype(short)
    margin = 8 * 2.0**-23 * (2 * SIDE + 5)
    write_input(tmp_path / "in", upper, lower, shift=shift, height=height, margin=margin)
    run_search(program, tmp_path / "in", tmp_path / "out")
    up, low = read_pairs(tmp_path / "out", ordered=False)
    x, y = upper.x.astype(short) + shift[0], upper.y.astype(short) + shift[1]
    s = short(1.27) + short(1.27)
    truth = []
    for i, j in cell_pairs(x, y, lower.x, lower.y, 1.0):
        across, along = x[i] - lower.x[j].astype(short), y[i] - lower.y[j].astype(short)
        squared = across * across + along * along
        assert squared.dtype == short
        near = (squared < (s + s) * height) & (np.sqrt(squared) < s)
        truth.append(i[near] * len(lower) + j[near])
    truth = np.concatenate(truth)
    met = np.isin(truth, up.astype(np.int64) * len(lower) + low)
    assert len(truth) > 100_000
    assert met.all()
    assert len(up) < 1.2 * len(truth)
    tally.add("pairs: candidates of 24 bits", len(truth), int(met.sum()))


def test_far_apart(program, tmp_path):
    """Surfaces that do not meet have no pairs."""
    rng = np.random.default_rng(7)
    for shift in ((1e4, 0.0), (0.0, -1e4), (1e300, 0.0), (0.0, 1e300)):
        write_input(tmp_path / "in", uniform(rng), uniform(rng), shift=shift, distance=0.95)
        assert run_search(program, tmp_path / "in")["pairs"] == 0
