"""What an earlier outcome saves: fifty loads through one scene, over fifty solves.

    python test/bench/run_again.py [--rounds R] [--small] [--save]

Two random surfaces of 2,000 asperities each, interaction = 'coupled', one thread, through the C
interface. A solve alone builds its scene from arrays; a solve with the outcome of the one before
builds it with the surfaces of the first. The least time of the rounds counts, load by load.
"""

import argparse
import os
import random
import subprocess
import tempfile
import time
from ctypes import byref
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

from run_bench import ROOT, machine, release_build, save

import test_solve_again as again

# Of .ci/common.sh: objects that a shared library can be made of.
FLAGS = "-fPIC -fno-semantic-interposition"
LOADS = 50
ASPERITIES, SIDE = 2000, 65.0
# Loads from and to: contacts from and to on these surfaces.
RANGES = {"260 to 400 contacts": (1e5, 2e5), "400 to 730 contacts": (2e5, 6e5),
          "730 to 1260 contacts": (6e5, 2e6)}


def shared_library(folder):
    """The library of the release build as a shared one."""
    subprocess.run([ROOT / ".venv/bin/fpm", "install", "--profile", "release", "--no-prune",
                    "--flag", FLAGS, "--prefix", folder], cwd=ROOT, check=True, capture_output=True)
    path = folder / "libasperity.so"
    subprocess.run([os.environ.get("FPM_FC", "gfortran"), "-shared", "-fopenmp", "-o", path,
                    "-Wl,--whole-archive", folder / "lib/libasperity.a", "-Wl,--no-whole-archive",
                    "-lfftw3"], check=True)
    return path


def least(rounds, work, free):
    """The least time of some rounds, and the last outcome."""
    times, outcome = [], None
    for _ in range(rounds):
        free(outcome)
        start = time.perf_counter()
        outcome = work()
        times.append(time.perf_counter() - start)
    return min(times), outcome


def both(c, sides, loads, rounds):
    """Seconds of all loads, alone and with the outcome before."""
    base = again.built(c, sides, value=loads[0])
    options = byref(again.Options(threads=1))
    seconds, earlier = [0.0, 0.0], None
    for load in loads:
        def alone():
            scene = again.built(c, sides, value=load)
            outcome = again.done(c, c.asperity_solve_scene(scene, options))
            c.asperity_free(scene)
            return outcome

        def with_earlier():
            scene = c.asperity_rebuild_scene(base, again.groups(value=load))
            outcome = again.done(c, c.asperity_solve_again(scene, options, earlier, None))
            c.asperity_free(scene)
            return outcome
        one, outcome = least(rounds, alone, c.asperity_free)
        c.asperity_free(outcome)
        other, outcome = least(rounds, with_earlier, c.asperity_free)
        c.asperity_free(earlier)
        earlier = outcome
        seconds[0] += one
        seconds[1] += other
    c.asperity_free(earlier)
    return seconds


def lines(c, rounds, less):
    number = ASPERITIES // less
    side = SIDE / less**0.5
    sides = again.random_sides(c, f"number = {number}, length = {side}, width = {side}, "
                                  "least_distance = 0.762", 1976)
    yield (f"{LOADS // less} loads on {number} and {number} asperities, s: alone, with the outcome "
           "before, ratio")
    for name, (first, last) in RANGES.items():
        number = LOADS // less
        loads = [(first + (last - first) * i / (number - 1)) / less for i in range(number)]
        for order in ("up", "random"):
            if order == "random":
                random.Random(1).shuffle(loads)
            one, other = both(c, sides, loads, rounds)
            yield f"  {name + ', ' + order:<40}{one:>10.3f}{other:>10.3f}{other / one:>10.2f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3, help="turns of each (default 3)")
    parser.add_argument("--small", action="store_true",
                        help="a tenth of everything, one turn: to see that it runs")
    parser.add_argument("--save", action="store_true", help="also to reference_output/bench")
    options = parser.parse_args()

    rounds, less = (1, 10) if options.small else (options.rounds, 1)
    flags = release_build()[1]
    with tempfile.TemporaryDirectory() as name:
        c = again.library_at(shared_library(Path(name)))
        text = "\n".join(machine(flags)) + "\n\n" + "\n".join(lines(c, rounds, less)) + "\n"
    print(text, end="")
    if options.save:
        save("again.txt", text)


if __name__ == "__main__":
    main()
