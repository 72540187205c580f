"""What it costs `solve --accuracy E` that the truth is not known: its processor time over that of
the cheapest rung that the truth shows to be good enough.

    python tools/promise_cost.py EXECUTABLE [--scenes 12] [--kinds dense,map,...]
        [--asked 1e-2,1e-4,1e-8] [--each]

The scenes are those of promise_judge.py. A rung is the same scene solved in one way that a user
could name: neighbours off, coupled, auto and boundary to some tolerances; of contacts alone the two
arithmetics; else as the scene is. Processor time of whole processes, user and system, one thread,
the least of three. With --each a line a scene.
"""

import argparse
import os
import random
import re
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from promise_judge import ASKED, KINDS
from surfaces_csv import records

RUNS = 3
# A rung that takes longer is not run again.
LONG = 2.0
ENVIRONMENT = {**os.environ, "OMP_NUM_THREADS": "1", "OMP_WAIT_POLICY": "passive"}
NEIGHBOURS = ("interaction = 'off'", "interaction = 'coupled'",
              *(f"interaction = 'auto', tolerance = {t}" for t in (0.1, 0.03, 0.01, 0.003, 0.001)),
              *(f"interaction = 'boundary', boundary_tolerance = {t}"
                for t in (0.01, 0.003, 0.001)))


def spent():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run(exe, scene, *options):
    """Processor seconds, and the rows of positions; none where it was refused."""
    file, least = scene.with_name("positions.csv"), np.inf
    for _ in range(RUNS):
        file.unlink(missing_ok=True)
        before = spent()
        subprocess.run([exe, "solve", scene, "--positions", file, "--threads", "1", *options],
                       env=ENVIRONMENT, capture_output=True, check=False)
        least = min(least, spent() - before)
        if least > LONG:
            break
    return least, records(file)


def rungs(kind, scene):
    """Options of each rung; the scene is rewritten for it."""
    if kind == "alone":
        yield from (("--arithmetic", name) for name in ("real64", "real128"))
        return
    text = scene.read_text()
    for effects in NEIGHBOURS if kind in ("dense", "many", "map") else ("",):
        if effects:
            scene.write_text(re.sub(r"&effects.*?/\n", f"&effects {effects} /\n", text, flags=re.S))
        yield ()


def ratios(exe, kind, number, asked):
    """Of each accuracy: time over that of the cheapest rung; None where it was refused."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scene, errors = KINDS[kind](random.Random(f"promise {kind} {number}"), folder)
        taken = [run(exe, scene, "--accuracy", a) for a in asked]
        ladder = []
        for options in rungs(kind, scene):
            seconds, rows = run(exe, scene, *options)
            if rows:
                ladder.append((seconds, max(error - bound for error, bound in errors(rows))))
        for a, (seconds, rows) in zip(asked, taken):
            good = [s for s, error in ladder if error <= float(a)]
            yield seconds / min(good) if rows and good else None


def main(words):
    told = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    told.add_argument("executable")
    told.add_argument("--scenes", type=int, default=12, help="of each kind")
    told.add_argument("--kinds", default=",".join(KINDS))
    told.add_argument("--asked", default=",".join(ASKED))
    told.add_argument("--each", action="store_true")
    given = told.parse_args(words)
    exe, asked = Path(given.executable).resolve(), given.asked.split(",")
    every = []
    for kind in given.kinds.split(","):
        found = {a: [] for a in asked}
        for number in range(1, given.scenes + 1):
            for a, ratio in zip(asked, ratios(exe, kind, number, asked)):
                if ratio is not None:
                    found[a].append(ratio)
                    every.append(ratio)
                if given.each:
                    print(kind, number, a, "refused" if ratio is None else f"{ratio:.2f}")
        for a in asked:
            if found[a]:
                print(f"{kind:9} {a}  {len(found[a]):3} solved, median {np.median(found[a]):.2f}, "
                      f"{sum(r > 2 for r in found[a])} above 2, largest {max(found[a]):.1f}",
                      flush=True)
    print(f"all       {len(every)} solved, median {np.median(every):.2f}")


if __name__ == "__main__":
    main(sys.argv[1:])
