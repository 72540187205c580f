"""Random scenes with effects, each under one law (metamorphic_laws.py).

    python tools/metamorphic.py --exe PATH --runs 20000 [--seed 0] [--processes 1] [--keep DIR]

Prints every law that was broken, with its seed, and a line for each law.
"""

import argparse
import multiprocessing
import shutil
import sys
import tempfile
from collections import Counter
from pathlib import Path

import metamorphic_laws
import metamorphic_scenes


def one_seed(task):
    exe, seed = task
    with tempfile.TemporaryDirectory(prefix="law") as folder:
        return (seed, *metamorphic_laws.broken(seed, exe, Path(folder)))


def campaign(exe, seeds, processes=1, tell=lambda *_: None):
    """Counts of (law, status), status None where the law does not apply; and the faults."""
    ended, faults = Counter(), {}
    with multiprocessing.Pool(processes) as pool:
        for seed, law, status, wrong in pool.imap(one_seed, ((str(exe), s) for s in seeds), 4):
            ended[law, status] += 1
            if wrong:
                faults[seed] = (law, wrong)
                tell(seed, law, wrong)
    return ended, faults


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--exe", required=True)
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="folder for scenes that break a law")
    given = parser.parse_args()
    exe = Path(given.exe).resolve()
    ended, faults = campaign(
        exe, range(given.seed, given.seed + given.runs), given.processes,
        lambda seed, law, wrong: print(f"seed {seed}, {law}: {wrong}", flush=True))
    for law in metamorphic_laws.LAWS:
        print(f"{law}: {ended[law, 0]} kept or broken, {ended[law, 1]} refused alike, "
              f"{ended[law, None]} not asked")
    if given.keep:
        for seed in faults:
            shutil.rmtree(given.keep / str(seed), ignore_errors=True)
            (given.keep / str(seed)).mkdir(parents=True)
            metamorphic_scenes.write(metamorphic_scenes.scene_of_seed(seed),
                                     given.keep / str(seed))
    print(f"{given.runs} scenes, {len(faults)} misses")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
