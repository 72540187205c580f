"""Pair search on large surfaces: time by phase, exponent, memory, and the same work by others.

    python test/bench/run_scale.py [--most N] [--rounds R] [--save]

N upper and N lower asperities at random on a square, 0.48 to the cm2 each; pairs are nearer than
0.95 cm in plan. Find them, compute the approach at which each touches, sort. One core each. The
search and its peers take turns round by round; the least time of each counts. Ratios come first:
they carry over to another machine, seconds do not.
"""

import argparse
import datetime
import math
import os
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

try:
    from scipy.spatial import cKDTree
except ImportError:
    raise SystemExit("bench: scipy is missing, see test/bench/requirements.txt")

from search_files import ROOT, Surface, read_pairs, run_search, search_program, write_input

DENSITY = 0.48
DISTANCE = 0.95
RADIUS = 1.27
SUM = 2.0 * RADIUS


def surfaces(n):
    """Heights as in the thesis: 0.050 in mean, 0.012 in deviation, both tails cut."""
    rng = np.random.default_rng(1978)
    side = math.sqrt(n / DENSITY)
    return [Surface(rng.random(n) * side, rng.random(n) * side,
                    2.54 * rng.normal(0.050, 0.012, n).clip(0.020, 0.080), RADIUS)
            for _ in range(2)]


class Clock:
    """Seconds of the steps of a peer."""

    def __init__(self):
        self.steps = {}
        self.last = time.perf_counter()

    def step(self, name):
        now = time.perf_counter()
        self.steps[name] = now - self.last
        self.last = now


def separate_and_sort(upper, lower, i, j, distance, clock):
    clock.step("search")
    squared = distance * distance
    touch = upper.height[i] + lower.height[j] - squared / (SUM + np.sqrt(SUM * SUM - squared))
    order = np.argsort(-touch)
    result = i[order], j[order], touch[order]
    clock.step("sort")
    return result


def places(surface):
    return np.column_stack((surface.x, surface.y))


def by_distance_matrix(upper, lower, clock):
    """scipy cKDTree.sparse_distance_matrix, in the quickest of its forms of output."""
    above, below = cKDTree(places(upper)), cKDTree(places(lower))
    clock.step("order surfaces")
    found = above.sparse_distance_matrix(below, DISTANCE, output_type="ndarray")
    return separate_and_sort(upper, lower, found["i"], found["j"], found["v"], clock)


def by_ball_query(upper, lower, clock):
    """scipy cKDTree.query_ball_point."""
    below = cKDTree(places(lower))
    clock.step("order surfaces")
    lists = below.query_ball_point(places(upper), DISTANCE)
    number = np.fromiter(map(len, lists), dtype=np.int64, count=len(lists))
    i = np.repeat(np.arange(len(upper)), number)
    j = np.fromiter((k for some in lists for k in some), dtype=np.int64, count=len(i))
    distance = np.hypot(upper.x[i] - lower.x[j], upper.y[i] - lower.y[j])
    return separate_and_sort(upper, lower, i, j, distance, clock)


def by_all_pairs(upper, lower, clock):
    """numpy, every asperity against all."""
    clock.step("order surfaces")
    rows, columns, squares = [], [], []
    for begin in range(0, len(upper), 500):
        part = slice(begin, begin + 500)
        squared = ((upper.x[part, None] - lower.x) ** 2 + (upper.y[part, None] - lower.y) ** 2)
        i, j = np.nonzero(squared < DISTANCE * DISTANCE)
        rows.append(i + begin)
        columns.append(j)
        squares.append(squared[i, j])
    i, j, squared = map(np.concatenate, (rows, columns, squares))
    return separate_and_sort(upper, lower, i, j, np.sqrt(squared), clock)


PEERS = {"sparse_distance_matrix": by_distance_matrix, "query_ball_point": by_ball_query,
         "numpy, all pairs": by_all_pairs}
MOST = {"numpy, all pairs": 10_000}


def compare(found, truth, name):
    """The peers' pairs must be ours; a bench of two different works would say nothing."""
    ours = np.sort(found[0].astype(np.int64) * 2**31 + found[1])
    theirs = np.sort(truth[0].astype(np.int64) * 2**31 + truth[1])
    same = np.array_equal(ours, theirs) and np.allclose(found[2], truth[2], rtol=0, atol=1e-14)
    if not same:
        raise SystemExit(f"bench: {name} finds other pairs")


def measure(program, n, rounds):
    """Least seconds by step, of the search and of every peer; bytes an asperity; pairs."""
    upper, lower = surfaces(n)
    least, figures = {}, {}
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in", Path(folder) / "out"
        write_input(source, upper, lower, distance=DISTANCE)
        runs = max(5, min(200, 2_000_000 // n))
        for turn in range(rounds):
            figures = run_search(program, source, target, runs)
            steps = {name: value[0] for name, value in figures.items() if isinstance(value, list)}
            keep_least(least, "asperity", steps)
            found = read_pairs(target)
            for name, peer in PEERS.items():
                if n > MOST.get(name, n):
                    continue
                clock = Clock()
                result = peer(upper, lower, clock)
                keep_least(least, name, clock.steps)
                if turn == 0:
                    compare(found, result, name)
        write_input(source, upper, lower, distance=DISTANCE)
        memory = run_search(program, source)
    return least, {"pairs": figures["pairs"], "structures": memory["bytes"] / (2 * n),
                   "process": memory["peak"] / (2 * n)}


def keep_least(least, name, steps):
    if name not in least or sum(steps.values()) < sum(least[name].values()):
        least[name] = steps


def ratio_lines(results):
    yield "times slower than asperity, one core (whole: order, search, separate, sort)"
    yield f"{'N':>9} {'peer':<24}{'whole':>9}{'search, separate, sort':>25}"
    for n, (least, _) in results.items():
        ours = least["asperity"]
        for name in PEERS:
            if name in least:
                yield (f"{n:>9} {name:<24}{total(least[name]) / total(ours):>9.1f}"
                       f"{later(least[name]) / later(ours):>25.1f}")


def total(steps):
    return sum(steps.values())


def later(steps):
    """Without what is done once for all positions."""
    return total(steps) - steps["order surfaces"]


def time_lines(results):
    yield f"{'N':>9} {'by':<24}{'order ms':>10}{'search ms':>10}{'sort ms':>10}{'whole ms':>10}"
    for n, (least, _) in results.items():
        for name, steps in least.items():
            cells = [*(steps.get(key, 0.0) for key in ("order surfaces", "search", "sort")),
                     total(steps)]
            yield f"{n:>9} {name:<24}" + "".join(f"{1e3 * value:>10.2f}" for value in cells)
    yield "(a peer's search ends with the pairs; ours with their separations)"


def exponent_lines(results):
    sizes = [n for n in results if n >= 10_000]
    if len(sizes) < 2:
        return
    for title, part in (("whole", total), ("search, separate, sort", later)):
        seconds = [part(results[n][0]["asperity"]) for n in sizes]
        slope = np.polyfit(np.log(sizes), np.log(seconds), 1)[0]
        yield f"cost exponent from {sizes[0]} to {sizes[-1]}, {title}: {slope:.3f}"


def memory_lines(results):
    yield f"{'N':>9} {'pairs':>10}{'bytes an asperity: structures':>32}{'whole process':>16}"
    for n, (_, memory) in results.items():
        yield f"{n:>9} {memory['pairs']:>10}{memory['structures']:>32.1f}{memory['process']:>16.1f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--most", type=int, default=1_000_000, help="largest N (default 1000000)")
    parser.add_argument("--rounds", type=int, default=3, help="turns of all (default 3)")
    parser.add_argument("--save", action="store_true", help="also to reference_output/bench")
    options = parser.parse_args()

    program = search_program()
    sizes = [10**k for k in range(3, 9) if 10**k <= options.most]
    results = {n: measure(program, n, options.rounds) for n in sizes}
    parts = (ratio_lines, exponent_lines, memory_lines, time_lines)
    text = "\n\n".join("\n".join(part(results)) for part in parts) + "\n"
    print(text, end="")
    if options.save:
        folder = ROOT / "reference_output" / "bench"
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"scale.{datetime.date.today().isoformat()}.txt"
        path.write_text(text, encoding="utf-8")
        print(f"saved     {path.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
