"""Mutated decks, scenes, CSV files and command lines: the program keeps its word on all of them.

Every run must end with status 0, 1 or 2, here also within a second of processor time (30 where
cells may be used). With 1 or 2 it states why in printable lines and leaves no file behind; with 0
its files are whole and hold finite numbers. The same seed gives the same cases on every machine.

With --tight each run has little memory and one thread, as OpenMP itself ends a program that has no
memory for the stacks of its threads; with --sanitized, for a build with sanitizers, memory is not
limited.

Longer run: python tools/fuzz.py --exe PATH --minutes 30 --keep FOLDER (or make fuzz).
"""

import argparse
import json
import math
import multiprocessing
import os
import random
import resource
import shlex
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from fuzz_cases import make_case
from fuzz_checks import run_and_check

# Of the sanitizers, whose builds map terabytes of addresses: a finding has a status of its own, an
# allocation that fails is the program's to see.
SANITIZERS = {"ASAN_OPTIONS": "exitcode=99:allocator_may_return_null=1:"
                              "detect_stack_use_after_return=1:quarantine_size_mb=16",
              "UBSAN_OPTIONS": "exitcode=99:print_stacktrace=1"}


def prepare(place, tight=False, sanitized=False):
    """A place for all folders, and limits that the runs inherit: a fault stays small."""
    tempfile.tempdir = place
    if tight:
        os.environ["OMP_NUM_THREADS"] = "1"
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (10 ** 6, 10 ** 6))
    if sanitized:
        for name, options in SANITIZERS.items():
            os.environ[name] = ":".join(filter(None, (options, os.environ.get(name))))
        return
    memory = resource.getrlimit(resource.RLIMIT_AS)[1]
    most = 4_000_000_000
    resource.setrlimit(resource.RLIMIT_AS,
                       (most if memory == resource.RLIM_INFINITY else min(most, memory), memory))


def tight_limits(seed):
    """Little memory: `ulimit -v`."""
    return {"RLIMIT_AS": int(15.9e6 * 20 ** random.Random(f"tight {seed}").random())}


def one_seed(task):
    exe, seed, tight, limits = task
    status, _, wrong = run_and_check(exe, make_case(seed), tight_limits(seed) if tight else None,
                                     **limits)
    return seed, status, wrong


def campaign(exe, seeds, processes=2, until=None, tight=False, sanitized=False, **limits):
    """Run the cases of all seeds; how many ended with which status, and the faults by seed."""
    ended, faults = Counter(), {}
    # One place, so that a campaign that is cut short leaves nothing behind.
    with tempfile.TemporaryDirectory(prefix="fuzz") as place, \
            multiprocessing.Pool(processes, prepare, (place, tight, sanitized)) as pool:
        tasks = ((str(exe), seed, tight, limits) for seed in seeds)
        for seed, status, wrong in pool.imap_unordered(one_seed, tasks, chunksize=16):
            ended[status] += 1
            if wrong:
                faults[seed] = wrong
            if until is not None and time.monotonic() > until:
                pool.terminate()
                break
    return ended, faults


def keep(case, folder):
    """Write a case as a folder like those of data/hard/found."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in case.files.items():
        (folder / name).write_bytes(data)
    (folder / "case.json").write_text(json.dumps(
        {"why": case.what, "arguments": case.arguments}, indent=2) + "\n", encoding="ascii")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--exe", required=True, help="the program")
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--runs", type=int, help="so many runs instead of a time")
    parser.add_argument("--seed", type=int, default=None, help="first seed (default: the clock)")
    parser.add_argument("--without", type=int, nargs="*", default=(), help="seeds to leave out")
    parser.add_argument("--seconds", type=float, default=1.0, help="processor time for a run")
    parser.add_argument("--processes", type=int, default=os.cpu_count())
    parser.add_argument("--keep", type=Path, help="folder for the cases with faults")
    parser.add_argument("--tight", action="store_true", help="little memory")
    parser.add_argument("--sanitized", action="store_true",
                        help="a build with sanitizers: memory and time are not limited")
    parser.add_argument("--show", action="store_true", help="print each fault's command and errors")
    given = parser.parse_args()
    first = int(time.time()) * 1000 if given.seed is None else given.seed
    seeds = (seed for seed in range(first, first + (given.runs or 10 ** 9))
             if seed not in given.without)
    until = None if given.runs else time.monotonic() + 60 * given.minutes
    exe = Path(given.exe).resolve()
    begun = time.monotonic()
    limits = {"most_seconds": given.seconds}
    if given.sanitized:
        limits = {"most_seconds": math.inf, "most_kilobytes": math.inf}
    ended, faults = campaign(exe, seeds, given.processes, until, given.tight, given.sanitized,
                             **limits)
    for seed in sorted(faults):
        case = make_case(seed)
        print(f"seed {seed} ({case.what}): {'; '.join(faults[seed])}")
        if given.show:
            print("   ", shlex.join(case.arguments)[:300])
        if given.keep:
            keep(case, given.keep / str(seed))
    print(summary(ended, faults), f"in {time.monotonic() - begun:.0f} s, seeds from {first}")
    return 1 if faults else 0


def summary(ended, faults):
    """`N runs: ... ended with status 0, ...; M with faults`."""
    parts = ", ".join(f"{ended[status]} with status {status}" for status in sorted(ended))
    return f"{sum(ended.values())} runs: {parts}; {len(faults)} faults"


if __name__ == "__main__":
    sys.exit(main())
