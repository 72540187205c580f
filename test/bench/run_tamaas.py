"""Caps under a flat at a load: asperity against tamaas on a grid, time and memory at an error.

    python test/bench/run_tamaas.py [--most N] [--seconds S] [--small] [--save]

tamaas (conjugate gradients of Polonsky and Keer over FFTs, free boundary) is installed by pip into
a venv of its own, build/tamaas; where that cannot be, a sentence states so and nothing is measured.
N caps of 1.27 cm, 26 a cm2, heights normal 0.127 +- 0.03 cm, 40 N a cap, one thread. The grid has
paraboloids. Cells have spheres, which are others by the penetration over the radius, 6 % here. So
ours are pressed with ten times the lengths in plan and a hundred times the radii: the same
paraboloids, heights and compression, at ten times the load, and flat as spheres. The grid is
refined until a solve takes more than S seconds. What the compression converges to is taken from the
two finest grids, whose error falls with the power 3/2 of the cell, and an error is the difference
from that over the compression.
"""

import argparse
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from csv_rows import records
from whole_runs import ROOT, Work, available_memory, machine, release_build, save

VERSION = "tamaas==2.9.0"
MODULUS, RATIO, RADIUS, DENSITY, EACH = 275760.0, 0.42, 1.27, 26.0, 40.0
# Lengths in plan of ours, over those of the grid.
WIDER = 10.0
# Room around the caps, so that no contact is cut off by the edge of the grid.
MARGIN = 0.25
# Bytes a pixel that it needs: its padded lattice, complex, and some fields.
BYTES_A_SAMPLE = 250
TOLERANCE = 1e-6
# More than these caps are pressed, and every touching point lies above that.
DEPTH = 0.12


def its_python():
    """Of the venv that has tamaas; None where it cannot be installed."""
    folder = ROOT / "build/tamaas"
    python = folder / "bin/python"
    has_it = [python, "-c", "import tamaas"]
    if python.exists() and subprocess.run(has_it, capture_output=True, check=False).returncode == 0:
        return python
    for command in ([sys.executable, "-m", "venv", folder],
                    [python, "-m", "pip", "install", "-q", VERSION]):
        if subprocess.run(command, capture_output=True, check=False).returncode != 0:
            return None
    return python


def place_caps(count):
    """The caps, and the side of the square that holds them."""
    rng = np.random.default_rng([26, count])
    side = math.sqrt(count / DENSITY)
    caps = np.column_stack([MARGIN + side * rng.random((count, 2)),
                            0.127 + 0.03 * rng.standard_normal(count), np.full(count, RADIUS)])
    return caps, side + 2 * MARGIN


def ours(exe, folder, caps, effects):
    """Seconds and peak memory of the whole process, and the compression past first touch."""
    scene, positions = folder / "caps.scene", folder / "positions.csv"
    wide = caps * [WIDER, WIDER, 1.0, WIDER ** 2]
    np.savetxt(folder / "wide.csv", wide, "%.17g", ",", header="x,y,height,radius", comments="")
    scene.write_text(
        "&surfaces upper = 'plane', lower = 'wide.csv' /\n"
        f"&material elastic_modulus = 2*{MODULUS}, poisson_ratio = 2*{RATIO} /\n"
        f"&loading control = 'load', value = {WIDER * EACH * len(caps)} /\n"
        f"&effects {effects} /\n", encoding="ascii")
    work = Work(exe, "solve", scene, "--quiet", "--threads", "1", "--positions", positions)
    work.run()
    row = records(positions)[0]
    return work.least, work.peak(), caps[:, 2].max() - float(row["separation"]), row["contacts"]


def sampled(caps, n, side):
    """Highest cap, a paraboloid as Hertz' law has it, at the middle of each of n by n cells; the
    lowest of these where none is near enough to touch."""
    cell = side / n
    heights = np.full((n, n), -np.inf)
    for x, y, top, radius in caps:
        reach = np.sqrt(2 * radius * DEPTH)
        i, j = (np.arange(max(0, int((v - reach) / cell)), min(n, int((v + reach) / cell) + 2))
                for v in (x, y))
        square = ((i + 0.5) * cell - x)[:, None] ** 2 + ((j + 0.5) * cell - y)[None] ** 2
        heights[np.ix_(i, j)] = np.maximum(heights[np.ix_(i, j)], top - square / (2 * radius))
    return np.where(np.isfinite(heights), heights, heights[np.isfinite(heights)].min())


def solve_by_tamaas(python, *words):
    """The numbers that tamaas_map.py prints; its last words are edge and threads."""
    done = subprocess.run(
        [python, ROOT / "test/bench/tamaas_map.py", *map(str, words)], check=True, text=True,
        capture_output=True, env={**os.environ, "OMP_NUM_THREADS": str(words[-1])})
    return tuple(map(float, done.stdout.split()))


def theirs(python, folder, caps, side, samples):
    """Seconds of the solve alone, peak memory of the process, and the compression."""
    np.save(folder / "caps.npy", sampled(caps, samples, side))
    peak, level, seconds, _ = solve_by_tamaas(
        python, folder / "caps.npy", side / samples, MODULUS / (2 * (1 - RATIO ** 2)),
        EACH * len(caps) / side ** 2, TOLERANCE, "free", 1)
    return seconds, peak, caps[:, 2].max() - level


def table(exe, python, count, seconds):
    """The lines of one number of caps."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        caps, side = place_caps(count)
        ways = {way: ours(exe, folder, caps, effects) for way, effects in (
            ("coupled", "interaction = 'coupled'"),
            ("auto 0.01", "interaction = 'auto', tolerance = 0.01"),
            ("auto 0.001", "interaction = 'auto', tolerance = 0.001"))}
        grids, samples = {}, 2 ** round(math.log2(side / 0.1))
        while len(grids) < 2 or list(grids.values())[-1][0] < seconds:
            if samples ** 2 * BYTES_A_SAMPLE > available_memory():
                break
            grids[samples] = theirs(python, folder, caps, side, samples)
            samples *= 2
    if len(grids) < 2:
        yield f"{count} caps: no two grids within time and memory"
        return
    coarse, fine = [closing for *_, closing in grids.values()][-2:]
    limit = fine + (fine - coarse) / (2 ** 1.5 - 1)
    yield (f"{count} caps, {ways['coupled'][3]} contacts, closing {limit:.6f} cm, the finest grid "
           f"{abs(fine / limit - 1):.1e} from it")
    yield f"  {'':<26}{'s':>9}{'MB':>9}{'error':>10}"
    for way, (spent, peak, closing, _) in ways.items():
        yield row(f"asperity, {way}", spent, peak, closing / limit - 1)
    for samples, (spent, peak, closing) in grids.items():
        yield row(f"tamaas, {samples} x {samples}", spent, peak, closing / limit - 1)


def row(name, spent, peak, error):
    return f"  {name:<26}{spent:>9.3f}{peak / 1e6:>9.1f}{error:>10.1e}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--most", type=float, default=1e5, help="caps at most (default 1e5)")
    parser.add_argument("--seconds", type=float, default=60.0,
                        help="a solve of tamaas above this is the last (default 60)")
    parser.add_argument("--small", action="store_true", help="to see that it runs")
    parser.add_argument("--save", action="store_true", help="also to reference_output/bench")
    options = parser.parse_args()

    python = its_python()
    if python is None:
        print(f"{VERSION} cannot be installed here: the comparison on a grid is left out")
        return
    exe, flags = release_build()
    blocks = ["\n".join([*machine(flags), f"peer      {VERSION}, tolerance {TOLERANCE:g}"])]
    print(blocks[0])
    counts = [300] if options.small else [c for c in (1000, 3000, 10_000, 100_000)
                                          if c <= options.most]
    for count in counts:
        blocks.append("\n".join(table(exe, python, count, 0.0 if options.small else
                                      options.seconds)))
        print("\n" + blocks[-1], flush=True)
    if options.save:
        save("tamaas.txt", "\n\n".join(blocks) + "\n")


if __name__ == "__main__":
    main()
