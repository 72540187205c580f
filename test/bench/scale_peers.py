"""Pair search, as the solver runs it, against peers: order the surfaces, find the pairs.

N upper and N lower asperities at random on a square, 0.48 to the cm2 each; pairs are nearer in plan
than the solver looks at summits of at most 0.178 cm, 0.95 cm. The search and its peers take turns
round by round, with as many tries a round, but two for peers that take long. Times settle after
some tries, when a process has its memory; so the first try of a fresh process is told, too, of the
search and of every peer.
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

try:
    from scipy.spatial import cKDTree
except ImportError:
    raise SystemExit("bench: scipy is missing, see test/bench/requirements.txt")

from search_files import read_pairs, run_search, write_input
from whole_runs import RADIUS, available_memory, free_disk, surfaces

DISTANCE = 0.95
# The height whose bound on the distance that is: d**2 < 2 (RU + RL) height.
HEIGHT = DISTANCE**2 / (4.0 * RADIUS)
FRESH = ", first"
OURS, FIRST = "asperity", "asperity" + FRESH


class Clock:
    """Seconds of the steps of a peer."""

    def __init__(self):
        self.steps = {}
        self.last = time.perf_counter()

    def step(self, name):
        now = time.perf_counter()
        self.steps[name] = now - self.last
        self.last = now


def places(surface):
    return np.column_stack((surface.x, surface.y))


def by_distance_matrix(upper, lower, clock):
    """scipy cKDTree.sparse_distance_matrix, in the quickest of its forms of output."""
    above, below = cKDTree(places(upper)), cKDTree(places(lower))
    clock.step("order surfaces")
    found = above.sparse_distance_matrix(below, DISTANCE, output_type="ndarray")
    clock.step("search")
    return found["i"], found["j"]


def by_ball_query(upper, lower, clock):
    """scipy cKDTree.query_ball_point."""
    below = cKDTree(places(lower))
    clock.step("order surfaces")
    lists = below.query_ball_point(places(upper), DISTANCE)
    number = np.fromiter(map(len, lists), dtype=np.int64, count=len(lists))
    i = np.repeat(np.arange(len(upper)), number)
    j = np.fromiter((k for some in lists for k in some), dtype=np.int64, count=len(i))
    clock.step("search")
    return i, j


def by_all_pairs(upper, lower, clock):
    """numpy, every asperity against all."""
    clock.step("order surfaces")
    rows, columns = [], []
    for begin in range(0, len(upper), 500):
        part = slice(begin, begin + 500)
        squared = ((upper.x[part, None] - lower.x) ** 2 + (upper.y[part, None] - lower.y) ** 2)
        i, j = np.nonzero(squared < DISTANCE * DISTANCE)
        rows.append(i + begin)
        columns.append(j)
    i, j = map(np.concatenate, (rows, columns))
    clock.step("search")
    return i, j


PEERS = {"sparse_distance_matrix": by_distance_matrix, "query_ball_point": by_ball_query,
         "numpy, all pairs": by_all_pairs}
# Above these a peer takes minutes.
MOST = {"numpy, all pairs": 10_000, "query_ball_point": 1_000_000}
# Bytes an upper asperity while it works, surfaces and pairs found included, with some room; memory
# of the search itself (with what this process holds), and its files.
NEEDS = {"sparse_distance_matrix": 600, "query_ball_point": 750, "numpy, all pairs": 20_000}
SEARCH_NEEDS = 450
FILES_NEED = 110


def compare(found, truth, name):
    """The peers' pairs must be ours, but for those at the very edge, which the solver looks at
    again; a bench of two different works would say nothing."""
    ours, theirs = (np.sort(pair[0].astype(np.int64) * 2**31 + pair[1]) for pair in (found, truth))
    if not (np.isin(theirs, ours).all() and len(ours) <= len(theirs) + 3):
        raise SystemExit(f"bench: {name} finds other pairs")


def peers_of(n, left_out):
    """The peers that are asked at this size. Whoever is not is told in `left_out`."""
    chosen = {}
    for name, peer in PEERS.items():
        if n > MOST.get(name, n):
            left_out.append(f"{n:>9} {name}: would take minutes")
        elif n * NEEDS[name] > available_memory():
            left_out.append(f"{n:>9} {name}: would not fit into memory")
        else:
            chosen[name] = peer
    return chosen


def tried(peer, tries, upper, lower):
    """Steps of every try, and what the last one found."""
    all_steps = []
    begin = time.perf_counter()
    while len(all_steps) < tries and (len(all_steps) < 2 or time.perf_counter() - begin < 5.0):
        clock = Clock()
        result = peer(upper, lower, clock)
        all_steps.append(clock.steps)
    return all_steps, result


def first_try(name, n):
    """Steps of a peer in a process of its own."""
    done = subprocess.run([sys.executable, __file__, name, str(n)], stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def measure(program, n, rounds, left_out):
    """Least seconds by step, of the search and of every peer; pairs, bytes an asperity. Nothing
    where memory or disk would not do."""
    if n * SEARCH_NEEDS > available_memory() or n * FILES_NEED > free_disk():
        left_out.append(f"{n:>9} everything: would not fit into memory or onto disk")
        return None
    upper, lower = surfaces(n)
    peers = peers_of(n, left_out)
    tries = max(5, min(200, 500_000 // n))
    if n > 1_000_000 and rounds > 1:
        rounds = 1
        left_out.append(f"{n:>9} all but the first round")
    least, figures = {}, {}
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in", Path(folder) / "out"
        write_input(source, upper, lower, height=HEIGHT)
        for turn in range(rounds):
            figures = run_search(program, source, target, tries)
            for name, which in ((OURS, 0), (FIRST, 1)):
                steps = {key: value[which] for key, value in figures.items()
                         if isinstance(value, list)}
                keep_least(least, name, steps)
            for name, peer in peers.items():
                all_steps, result = tried(peer, tries, upper, lower)
                for steps in all_steps:
                    keep_least(least, name, steps)
                keep_least(least, name + FRESH, first_try(name, n))
                if turn == 0:
                    compare(read_pairs(target), result, name)
        # Without an output no second list of the pairs is made.
        memory = run_search(program, source)
    return least, {"pairs": figures["pairs"], "process": memory["peak"] / (2 * n)}


def keep_least(least, name, steps):
    if name not in least or total(steps) < total(least[name]):
        least[name] = steps


def total(steps):
    return sum(steps.values())


def later(steps):
    """Without what is done once for all positions."""
    return total(steps) - steps["order surfaces"]


def ratio_lines(results):
    yield "times slower than asperity, one core (whole: order, search; later: without the order, as"
    yield "for a second position; first: whole, both the first search of a fresh process)"
    yield f"{'N':>9} {'peer':<32}{'whole':>9}{'later':>9}{'first':>9}"
    for n, (least, _) in results.items():
        for name in PEERS:
            if name in least:
                ratios = (total(least[name]) / total(least[OURS]),
                          later(least[name]) / later(least[OURS]),
                          total(least[name + FRESH]) / total(least[FIRST]))
                yield f"{n:>9} {name:<32}" + "".join(f"{ratio:>9.1f}" for ratio in ratios)


def exponent_lines(results):
    large = [n for n in results if n >= 10_000]
    # To a million, and to the end where that is farther.
    for most in sorted({min(1_000_000, max(large, default=0)), max(large, default=0)}):
        sizes = [n for n in large if n <= most]
        if len(sizes) < 2:
            continue
        for title, name, part in (("whole", OURS, total), ("later", OURS, later),
                                  ("first", FIRST, total)):
            seconds = [part(results[n][0][name]) for n in sizes]
            slope = np.polyfit(np.log(sizes), np.log(seconds), 1)[0]
            yield f"cost exponent from {sizes[0]} to {sizes[-1]}, {title}: {slope:.3f}"


def memory_lines(results):
    yield f"{'N':>9} {'pairs':>10}{'bytes an asperity, whole process':>34}"
    for n, (_, memory) in results.items():
        yield f"{n:>9} {memory['pairs']:>10}{memory['process']:>34.1f}"


def time_lines(results):
    yield f"{'N':>9} {'by':<32}{'order ms':>10}{'search ms':>10}{'whole ms':>10}"
    for n, (least, _) in results.items():
        for name, steps in least.items():
            cells = [steps["order surfaces"], steps["search"], total(steps)]
            yield f"{n:>9} {name:<32}" + "".join(f"{1e3 * value:>10.2f}" for value in cells)


def search_part(program, sizes, rounds):
    """The lines of all sizes."""
    left_out, results = [], {}
    for n in sizes:
        result = measure(program, n, rounds, left_out)
        if result:
            results[n] = result
    blocks = [list(lines(results)) for lines in (ratio_lines, exponent_lines, memory_lines,
                                                 time_lines)]
    if left_out:
        blocks.append(["left out:", *left_out])
    return "\n\n".join("\n".join(block) for block in blocks if block)


if __name__ == "__main__":
    chosen = PEERS[sys.argv[1]]
    both = surfaces(int(sys.argv[2]))
    clock = Clock()
    chosen(*both, clock)
    print(json.dumps(clock.steps))
