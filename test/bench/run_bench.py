"""Run time and memory: large surfaces, threads, interaction.

    python test/bench/run_bench.py [--parts NAMES] [--most N] [--rounds R] [--small] [--save]
        [--beside EXE]

The least time of runs that take turns counts, so that a slow moment of the machine hits all of
them. Ratios carry over to another machine, seconds do not. With --save the lines go to
reference_output/bench/.

phases       one position, N on N asperities read from CSV, one core. All from outside, by what runs
             of the whole process differ in: one that is refused when all is read (its scene has no
             limit load), one position, some more positions, one position with its contacts written
threads      sweeps on one and on two threads; `machine` is twice the time of one run over the time
             of two such runs at once: where it is not near 2 the cores are busy
interaction  user seconds and peak memory of the default beside `coupled` and `off`, on one thread;
             test_dense.py has the errors
"""

import argparse
import os
import resource
import subprocess
import tempfile
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

from dense_scenes import Rough
from effect_runs import random_caps, write_caps
from whole_runs import (ENVIRONMENT, ROOT, Failed, Work, machine, peak_of, release_build,
                        same_output, save, surfaces, take_turns, write_csv, write_scene)

DECK = "data/thesis.deck"
# Controls of one position, and how many positions more show what one costs, at 1e6 asperities: to
# the limit load; to a separation [cm], as near as in the thesis; to 1 N an upper asperity.
CONTROLS = {"limit": ("", 100), "approach": (", value = 0.28", 10), "load": (", value = {n}.", 3)}
CSV_FILES = "upper = 'upper.csv', lower = 'lower.csv', radius = 2*1.27"
# Fewer asperities take no time to speak of; CSV files of more take minutes to write.
LEAST, MOST = 10_000, 1_000_000
# Asperities and positions of the sweeps; the deck's own sweep goes 10 cm.
SIZES, SWEEP = {False: (100_000, 10_000), True: (10_000, 1000)}, 10.0
# Caps, seed and load a cap [N]; the sparse ones have contacts far apart.
SPARSE = (100_000, 5, 1e-4)
ROUGH = ((100, 5, 40.0), (10_000, 5, 40.0), (100_000, 5, 40.0), (1_000_000, 5, 40.0),
         (2000, 31, 10.0), (2000, 31, 40.0), (2000, 31, 160.0), SPARSE)
DENSE_POSITIONS = 6


def aligned(first, *cells):
    return f"{first:<40}" + "".join(f"{cell:>12}" for cell in cells)


def write_surfaces(folder, n):
    for name, surface in zip(("upper", "lower"), surfaces(n)):
        write_csv(folder / f"{name}.csv", surface)


def csv_scene(folder, positions, control, n, x_step=0.1, **other):
    """A scene of N on N asperities at so many positions."""
    path = folder / f"{len(list(folder.iterdir()))}.scene"
    value = CONTROLS[control][0].format(n=n)
    write_scene(path, CSV_FILES, f"x_step = {x_step}, positions = {positions}",
                f"control = '{control}'{value}", **other)
    return path


def phases_part(exe, folder, words):
    """Seconds, but milliseconds for a position; bytes of an asperity at the peak of the process."""
    yield "one position, N on N asperities from CSV (reading: until a run is refused; once: order"
    yield " of the surfaces, start and end; position: one more; contacts: what writing them adds)"
    yield aligned("N, control", "whole s", "reading s", "once s", "position ms", "contacts s",
                  "rows", "bytes")
    for n in (10**k for k in range(3, 9) if LEAST <= 10**k <= min(words.most, MOST)):
        write_surfaces(folder, n)
        runs, contacts = {}, folder / "contacts.csv"
        for control, (_, more) in CONTROLS.items():
            more = min(more * 1_000_000 // n, 1000)

            def work(*options, positions=1, control=control, status=0, **other):
                scene = csv_scene(folder, positions, control, n, 0.01, **other)
                return Work(exe, "solve", scene, "--quiet", *options, status=status)

            # Only limit control needs a limit.
            runs[control] = (work(), work(positions=1 + more), work("--contacts", contacts),
                             work(control="limit", limit=None, status=2), more)
        take_turns([one for works in runs.values() for one in works[:4]], words.rounds)
        for control, (one, many, written, refused, more) in runs.items():
            written.run()
            rows = contacts.read_text(encoding="ascii").count("\n") - 1
            position = (many.least - one.least) / more
            yield aligned(f"{n}, {control}", f"{one.least:.3f}", f"{refused.least:.3f}",
                          f"{one.least - refused.least - position:.3f}", f"{1e3 * position:.3f}",
                          f"{written.least - one.least:.3f}", rows, f"{one.peak() / (2 * n):.0f}")


def threads_part(exe, folder, words):
    """The sweep of the thesis, and sweeps of N on N asperities."""
    n, positions = SIZES[words.small]
    write_surfaces(folder, n)
    sweeps = {}
    for number in (positions, 1):
        path = folder / f"thesis.{number}.scene"
        write_scene(path, f"deck = '{ROOT / DECK}'", f"x_first = {SWEEP / number!r}, "
                    f"x_step = {SWEEP / number!r}, positions = {number}")
        sweeps.setdefault(f"thesis scene, {positions} positions", []).append(path)
    for control, number in (("limit", 300), ("load", 30)):
        sweeps[f"{n} on {n}, {number} positions, {control}"] = [
            csv_scene(folder, some, control, n) for some in (number, 1)]
    works = {title: [Work(exe, "solve", scene, "--threads", threads, copies=copies)
                     for scene, threads, copies in ((many, 1, 1), (many, 2, 1), (many, 1, 2),
                                                    (one, 1, 1))]
             for title, (many, one) in sweeps.items()}
    take_turns([work for row in works.values() for work in row], words.rounds)
    yield aligned("threads", "one s", "two s", "ratio", "machine", "start s")
    for title, (one, two, at_once, start) in works.items():
        same_output(one, two, at_once)
        yield aligned(title, f"{one.least:.3f}", f"{two.least:.3f}",
                      f"{one.least / two.least:.2f}", f"{2 * one.least / at_once.least:.2f}",
                      f"{start.least:.3f}")


def user_seconds(exe, scene):
    """User seconds, and MiB at the peak."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    process = subprocess.Popen([exe, "solve", scene, "--quiet", "--threads", "1"],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                               env=ENVIRONMENT)
    peak = peak_of(process, 0.002)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, peak / 2 ** 20


def interaction_part(exe, folder, words):
    """Rough surfaces by number of caps and load, ratios to `coupled`; 2000 caps of half-normal
    heights at 20 kN, 630 contacts, by the difference of one position and of more."""
    programs = {"": exe, **({"before": words.beside} if words.beside else {})}
    yield aligned("caps, load a cap, mode, program", "user s", "ratio", "MiB")
    for number, seed, each in ROUGH if not words.small else ROUGH[:1]:
        base = {}
        for mode in ("coupled", "auto", *(("off",) if each == SPARSE[2] else ())):
            if number > words.most:
                continue
            scene = Rough(number, seed, 0.0, number * each).write(
                folder / f"{number}.{each:g}.{mode}", by_default=True,
                **({} if mode == "auto" else {"interaction": mode}))
            for program, path in programs.items():
                if program and number > 10_000:
                    continue
                seconds, peak = min(user_seconds(path, scene) for _ in range(words.rounds))
                base.setdefault(program, max(seconds, 1e-3))
                yield aligned(f"{number}, {each:g} N, {mode} {program}", f"{seconds:.3f}",
                              f"{seconds / base[program]:.2f}", f"{peak:.0f}")
    for mode in ("coupled", "auto"):
        scenes = []
        for number in (1, DENSE_POSITIONS):
            place = folder / f"dense.{mode}.{number}"
            place.mkdir()
            scenes.append(write_caps(place, *random_caps(2000, 7.6, 10.0, 7),
                                     motion={"positions": number, "x_step": 0.0},
                                     loading={"control": "load", "value": 2.0e4},
                                     effects={"interaction": mode}).scene)
        for program, path in programs.items():
            one, many = (min(user_seconds(path, scene)[0] for _ in range(words.rounds))
                         for scene in scenes)
            yield aligned(f"630 dense contacts, {mode} {program}",
                          f"{(many - one) / (DENSE_POSITIONS - 1):.4f}")


PARTS = {"phases": phases_part, "threads": threads_part, "interaction": interaction_part}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--parts", default=",".join(PARTS), help=f"some of {','.join(PARTS)}")
    parser.add_argument("--most", type=float, default=1e6, help="largest N (default 1e6)")
    parser.add_argument("--rounds", type=int, default=3, help="turns of all (default 3)")
    parser.add_argument("--small", action="store_true", help="small sweeps: to see that it runs")
    parser.add_argument("--beside", help="another executable, for the part 'interaction'")
    parser.add_argument("--save", action="store_true", help="also to reference_output/bench")
    words = parser.parse_args()
    exe, flags = release_build()
    lines = [*machine(flags), f"rounds    {words.rounds}, the least time counts",
             f"busy      {os.getloadavg()[0]:.1f} processes in the minute before the start"]
    print(*lines, sep="\n")
    for name in words.parts.split(","):
        lines.append("")
        print()
        with tempfile.TemporaryDirectory() as folder:
            try:
                for line in PARTS[name](exe, Path(folder), words):
                    lines.append(line)
                    print(line, flush=True)
            except Failed as failure:
                raise SystemExit(f"bench: a run of the part '{name}' {failure}")
    if words.save:
        save("bench.txt", "\n".join([*lines, ""]))


if __name__ == "__main__":
    main()
