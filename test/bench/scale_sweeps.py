"""Sweeps of many positions on one and on two threads. Time of the whole process.

Beside each ratio stands that of the machine at the time: twice the time of one run over the time of
two such runs at once. Where that is not near 2 the cores are busy, or share what the work needs.
"""

import tempfile
from pathlib import Path

from whole_runs import ROOT, Work, same_output, surfaces, take_turns, write_csv, write_scene

# The deck's own sweep goes 10 cm.
SWEEP = 10.0


def thesis_sweep(folder, positions):
    """The thesis scene at so many positions."""
    path = folder / f"sweep.{positions}.scene"
    step = SWEEP / positions
    write_scene(path, f"deck = '{ROOT / 'data' / 'thesis.deck'}'",
                f"x_first = {step!r}, x_step = {step!r}, positions = {positions}")
    return path


def csv_sweep(folder, n, positions, loading):
    """N on N asperities from CSV at so many positions."""
    path = folder / f"csv.{len(list(folder.iterdir()))}.scene"
    if not (folder / "upper.csv").exists():
        for name, surface in zip(("upper", "lower"), surfaces(n)):
            write_csv(folder / f"{name}.csv", surface)
    write_scene(path, "upper = 'upper.csv', lower = 'lower.csv', radius = 2*1.27",
                f"x_step = 0.1, positions = {positions}", loading)
    return path


HEAD = f"{'':<46}{'one s':>8}{'two s':>8}{'ratio':>8}{'machine':>9}"


def row(title, one, two, at_once):
    return (f"{title:<46}{one.least:>8.3f}{two.least:>8.3f}{one.least / two.least:>8.2f}"
            f"{2.0 * one.least / at_once.least:>9.2f}")


class Threads:
    """A sweep on one thread and on two, and two runs of one thread at once; one position tells what
    is not shared."""

    def __init__(self, title, asperity, many, one, *options):
        def work(scene, threads, copies=1):
            return Work(asperity, "solve", scene, *options, "--threads", threads, copies=copies)

        self.title = title
        self.single, self.double = work(many, 1), work(many, 2)
        self.at_once, self.start = work(many, 1, copies=2), work(one, 1)

    def works(self):
        return [self.single, self.double, self.at_once, self.start]

    def line(self):
        same_output(self.single, self.double, self.at_once)
        start = f"{self.start.least:>10.3f}"
        return row(self.title, self.single, self.double, self.at_once) + start


def threads_part(asperity, n, positions, rounds):
    """The lines of the thesis sweep, and of sweeps of N on N asperities."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        thesis = [thesis_sweep(folder, number) for number in (positions, 1)]
        sweeps = [Threads(f"thesis scene, {positions} positions", asperity, *thesis)]
        for control, value, number in (("limit", "", 300), ("load", f", value = {n}.", 30)):
            files = [csv_sweep(folder, n, some, f"control = '{control}'{value}")
                     for some in (number, 1)]
            sweeps.append(Threads(f"{n} on {n}, {number} positions, {control} control", asperity,
                                  *files))
        take_turns([work for sweep in sweeps for work in sweep.works()], rounds)
        rows = [sweep.line() for sweep in sweeps]
    return "\n".join([
        "threads: one and two, whole process (machine: what two runs of one thread at once gain;",
        " start: one position on one thread)", f"{HEAD}{'start s':>10}", *rows])
