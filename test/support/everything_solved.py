"""Whether `coupled` solves all that has a solution: random scenes, loads of a table, summits.

Solved is: status 0, sums that are those of the contacts, and contacts that bear what they
penetrate, or nothing where they do not.

    python test/support/everything_solved.py EXECUTABLE [--parts random,packed,stepped,loads,rough]
        [--count 10000] [--first 1] [--processes 2] [--timeout 300] [--mode coupled]
        [--out results.csv] [--surface SUMMITS.csv ...]

Random scenes: 2 to 5000 contacts, from .1 to 30 % of the area, heights from one level to widely
spread, equal and mixed radii (to 1:30), at random, in heaps, in packed lattices and with coincident
caps, under an approach or a load. Scene K is made of the seed K: `--first K --count 1` runs it
alone. Packed, of seeds too: 9 to 300 equal caps, .02 to .5 of a radius apart, on a lattice or in a
heap, level or nearly, so lightly pressed that they cover 1 to 30 % of the area, or so deeply that
circles are wider than caps are apart. Stepped: caps of which some stand on blunter ones, with
nearly the same axis. Loads: 2000 to 32000 caps at 40 loads from 3 to 90 N a cap.
Rough: the summits of a made-up rough surface, and of others (`x,y,height,radius`), up to 20 %
contact.

Prints every failure with its seed, and counts, steps and times at the end; status 1 if any failed.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from csv_rows import records, write_records
from solved_cases import COMBINED, OF_SEEDS, SPHERE, load_cases, rough_parts


@dataclass
class Outcome:
    """How a case ended."""

    name: str
    kind: str
    caps: int
    status: int = -1
    contacts: int = 0
    share: float = np.nan     # of the nominal area
    steps: float = np.nan
    seconds: float = 0.0
    message: str = ""


def run(exe, mode, timeout, case):
    """Solve a case."""
    outcome = Outcome(case.name, case.kind, len(case.caps))
    with tempfile.TemporaryDirectory(dir=ROOM) as folder:
        path = case.write(Path(folder), mode)
        positions, contacts = path.with_name("positions.csv"), path.with_name("contacts.csv")
        start = time.perf_counter()
        try:
            done = subprocess.run([exe, "solve", path, "--positions", positions, "--contacts",
                                   contacts, "--quiet", "--threads", "1"],
                                  capture_output=True, text=True, timeout=timeout)
            outcome.status = done.returncode
            outcome.message = done.stderr.strip().replace(f"{path}: ", "")
        except subprocess.TimeoutExpired:
            outcome.message = f"no end in {timeout:g} s"
        outcome.seconds = time.perf_counter() - start
        for row in records(positions) if positions.exists() else []:
            outcome.contacts = int(row["contacts"])
            outcome.share = float(row["area"]) / case.area
            outcome.steps = float(row.get("interaction_iterations") or "nan")
            fault = fault_of(case, row, records(contacts))
            if fault:
                outcome.status, outcome.message = WRONG, fault
    return outcome


# Status of a result that is not what it says; relative error of a load by its penetration.
WRONG, OF_LAW = -2, 1e-6


def fault_of(case, position, contacts):
    """What is wrong with the sums of the contacts, or with one of them: "" when nothing is.

    Who bears something bears what its penetration, alone and less what it is lowered by, says; who
    bears nothing does not penetrate. Nobody is lowered where `auto` leaves the interaction off.
    """
    names = ("vertical_load", "projected_area", "alone_load", "lowered")
    if position["interaction"] == "off":
        contacts = [row | {"lowered": 0} for row in contacts]
    load, area, alone, lowered = (np.array([float(row[n]) for row in contacts]) for n in names)
    for name, values in (("vertical_load", load), ("projected_area", area)):
        if abs(values.sum() - float(position[name])) > 1e-9 * abs(values).sum():
            return f"{name} is not the sum of the contacts"
    if load.min(initial=0) < 0:
        return f"a contact bears {load.min()}"
    radius = case.caps[[int(row["lower"]) - 1 for row in contacts], 3]
    stiff = 4 / 3 * COMBINED * np.sqrt(1 / (1 / radius + 1 / SPHERE))
    deep = (alone / stiff) ** (2 / 3) - lowered
    borne = stiff * np.maximum(deep, 0) ** 1.5
    most = load.max(initial=0)
    wrong = np.abs(borne - load) > OF_LAW * most
    return f"{wrong.sum()} contacts do not bear what they penetrate" if wrong.any() else ""


# Many small files: in memory where there is room for them.
ROOM = "/dev/shm" if Path("/dev/shm").is_dir() else None


def told(outcomes):
    """Lines that sum up."""
    for word in dict.fromkeys(w for o in outcomes for w in sorted(o.kind.split(", "))):
        yield summed(word, [o for o in outcomes if word in o.kind.split(", ")])
    yield summed("all", outcomes)


def summed(kind, outcomes):
    good = [o for o in outcomes if o.status == 0]
    steps = np.array([o.steps for o in good if np.isfinite(o.steps)])
    seconds = [o.seconds for o in outcomes]
    share = [o.share for o in good] or [np.nan]
    mean, most = (f"{steps.mean():.1f}", f"{steps.max():.0f}") if steps.size else ("-", "-")
    return (f"{kind:<24} {len(outcomes):>6} {len(outcomes) - len(good):>6} {mean:>6} {most:>6} "
            f"{max((o.contacts for o in good), default=0):>8} {100 * min(share):>6.2f} "
            f"{100 * max(share):>6.1f} {sum(seconds):>8.1f} {max(seconds):>7.2f}")


def run_seed(exe, mode, timeout, seed, part="random"):
    """Made where it runs: scenes are not sent between processes."""
    return run(exe, mode, timeout, OF_SEEDS[part](seed))


def main():
    parser = argparse.ArgumentParser(description="Whether everything is solved.")
    parser.add_argument("exe")
    parser.add_argument("--parts", default="random,packed,stepped,loads,rough")
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--timeout", type=float, default=300)
    parser.add_argument("--mode", default="coupled")
    parser.add_argument("--surface", nargs="*", default=[])
    parser.add_argument("--out")
    words = parser.parse_args()
    exe, parts = Path(words.exe).resolve(), words.parts.split(",")
    how = (exe, words.mode, words.timeout)
    outcomes = []
    with ProcessPoolExecutor(words.processes) as pool:
        for part in parts:
            if part in OF_SEEDS:
                seeds = range(words.first, words.first + words.count)
                ended = pool.map(partial(run_seed, *how, part=part), seeds, chunksize=4)
            else:
                cases = load_cases() if part == "loads" else rough_parts(words.surface)
                ended = pool.map(partial(run, *how), cases)
            for outcome in ended:
                outcomes.append(outcome)
                if outcome.status != 0:
                    print(f"NOT SOLVED: {outcome.name} ({outcome.kind}), {outcome.caps} caps: "
                          f"status {outcome.status}, {outcome.message[:200]}", flush=True)
    print(f"{'kind':<24} {'runs':>6} {'failed':>6} {'steps':>6} {'most':>6} {'contacts':>8} "
          f"{'% from':>6} {'to':>6} {'s':>8} {'most':>7}")
    for line in told(outcomes):
        print(line)
    if words.out:
        write_records(words.out, outcomes)
    return int(any(o.status != 0 for o in outcomes))


if __name__ == "__main__":
    sys.exit(main())
