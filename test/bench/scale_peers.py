"""Pair search, as the solver runs it, beside scipy: order the surfaces, find the pairs.

N upper and N lower asperities at random on a square, 0.48 to the cm2 each; pairs are nearer in plan
than the solver looks at summits of at most 0.178 cm, 0.95 cm. Both take turns round by round, with
as many tries a round; the least time of the tries counts.
"""

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
STEPS = ("order surfaces", "search")
# Bytes an upper asperity while both work, with some room; and of the files.
NEEDS, FILES_NEED = 600, 110


def by_distance_matrix(upper, lower):
    """cKDTree.sparse_distance_matrix in the quickest of its forms: seconds by step, pairs."""
    begun = time.perf_counter()
    above, below = (cKDTree(np.column_stack((side.x, side.y))) for side in (upper, lower))
    ordered = time.perf_counter()
    found = above.sparse_distance_matrix(below, DISTANCE, output_type="ndarray")
    return (ordered - begun, time.perf_counter() - ordered), (found["i"], found["j"])


def compare(found, truth):
    """The pairs of both are the same, but for those at the very edge, which the solver looks at
    again."""
    ours, theirs = (np.sort(pair[0].astype(np.int64) * 2**31 + pair[1]) for pair in (found, truth))
    if not (np.isin(theirs, ours).all() and len(ours) <= len(theirs) + 3):
        raise SystemExit("bench: scipy finds other pairs")


def measure(program, n, rounds):
    """Least seconds of the steps of the search and of scipy; pairs, bytes an asperity."""
    upper, lower = surfaces(n)
    tries = max(2, min(200, 500_000 // n))
    ours, theirs = [], []
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in", Path(folder) / "out"
        write_input(source, upper, lower, height=HEIGHT)
        for turn in range(rounds):
            figures = run_search(program, source, target, tries)
            ours.append([figures[name][0] for name in STEPS])
            for _ in range(tries):
                seconds, pairs = by_distance_matrix(upper, lower)
                theirs.append(seconds)
            if turn == 0:
                compare(read_pairs(target), pairs)
        # Without an output no second list of the pairs is made.
        memory = run_search(program, source)
    return np.min(ours, axis=0), np.min(theirs, axis=0), figures["pairs"], memory["peak"] / (2 * n)


def search_part(program, sizes, rounds):
    """The lines of all sizes: whole is order and search, later the search alone, as for a second
    position."""
    fitting = [n for n in sizes if n * NEEDS < available_memory() and n * FILES_NEED < free_disk()]
    results = {n: measure(program, n, rounds) for n in fitting}
    lines = [f"{'N':>9} {'order ms':>9} {'search ms':>9} {'pairs':>10} {'bytes an asperity':>18}  "
             "scipy over asperity: whole, later"]
    for n, (ours, theirs, pairs, size) in results.items():
        lines.append(f"{n:>9} {1e3 * ours[0]:>9.2f} {1e3 * ours[1]:>9.2f} {pairs:>10} "
                     f"{size:>18.1f}  {theirs.sum() / ours.sum():.1f}, {theirs[1] / ours[1]:.1f}")
    large = [n for n in results if n >= 10_000]
    if len(large) > 1:
        slope = np.polyfit(np.log(large), np.log([results[n][0].sum() for n in large]), 1)[0]
        lines.append(f"cost exponent from {large[0]} to {large[-1]}: {slope:.3f}")
    lines += [f"{n:>9} left out: would not fit into memory or onto disk"
              for n in sizes if n not in fitting]
    return "\n".join(lines)
