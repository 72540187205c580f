"""Where the time of one position goes, N on N asperities read from CSV, one core.

All from outside, by what runs of the whole process differ in: one that is refused when all is read
(its scene has no limit load), one position, some more positions, one position with its contacts
written. What is left is done once for all positions, above all the order of the surfaces.
"""

import tempfile
from pathlib import Path

from whole_runs import Work, surfaces, take_turns, write_csv, write_scene

# Separation of the reference planes under approach control, cm, as near as in the thesis.
APPROACH = 0.28
# How many positions more tell what one costs, at 1e6 asperities.
MORE = {"limit": 100, "approach": 10, "load": 3}
# Fewer asperities take no time to speak of; CSV files of more take minutes to write.
LEAST, MOST = 10_000, 1_000_000
HEAD = ("N", "control", "whole", "reading", "once", "position", "contacts", "rows", "bytes")
WIDTHS = (9, 10, 9, 9, 9, 11, 9, 9, 8)


def loading(control, n):
    """To the limit load; to a separation; to 1 N an upper asperity."""
    value = {"limit": "", "approach": f", value = {APPROACH}", "load": f", value = {n}."}
    return f"control = '{control}'{value[control]}"


class Phases:
    """The runs of one control at one N."""

    def __init__(self, asperity, folder, control, n):
        self.control, self.n = control, n
        self.more = min(MORE[control] * 1_000_000 // n, 1000)
        self.contacts = folder / f"{control}.contacts.csv"
        files = "upper = 'upper.csv', lower = 'lower.csv', radius = 2*1.27"

        def scene(name, positions, control=control, **other):
            path = folder / f"{control}.{name}.scene"
            write_scene(path, files, f"x_step = 0.01, positions = {positions}", loading(control, n),
                        **other)
            return [asperity, "solve", path, "--quiet", "--threads", "1"]

        one = scene("one", 1)
        # Only limit control asks for a limit.
        self.refused = Work(*scene("refused", 1, "limit", limit=None), status=2)
        self.one = Work(*one)
        self.many = Work(*scene("many", 1 + self.more))
        self.written = Work(*one, "--contacts", self.contacts)

    def works(self):
        return [self.refused, self.one, self.many, self.written]

    def row(self):
        """Differences of least times; seconds, but milliseconds for a position."""
        whole, reading = self.one.least, self.refused.least
        position = (self.many.least - whole) / self.more
        with open(self.contacts, encoding="ascii") as file:
            rows = sum(1 for _ in file) - 1
        return (self.n, self.control, f"{whole:.3f}", f"{reading:.3f}",
                f"{whole - reading - position:.3f}", f"{1e3 * position:.3f}",
                f"{self.written.least - whole:.3f}", rows,
                f"{self.one.peak() / (2 * self.n):.0f}")


def aligned(cells):
    return "".join(f"{cell:>{width}}" for cell, width in zip(cells, WIDTHS)).rstrip()


def solve_part(asperity, sizes, rounds):
    """The lines of all sizes."""
    lines = ["one position, N on N asperities from CSV, whole process, one core",
             "(reading: until a run is refused; once: order of the surfaces, start and end;",
             " position: search and states of one more; contacts: what writing them adds;",
             " bytes: an asperity, at the peak of the process with one position)",
             aligned(HEAD), aligned(("", "", "s", "s", "s", "ms", "s", "", ""))]
    for n in (size for size in sizes if LEAST <= size <= MOST):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            upper, lower = surfaces(n)
            write_csv(folder / "upper.csv", upper)
            write_csv(folder / "lower.csv", lower)
            all_phases = [Phases(asperity, folder, control, n) for control in MORE]
            take_turns([work for phases in all_phases for work in phases.works()], rounds)
            lines += [aligned(phases.row()) for phases in all_phases]
    if max(sizes) > MOST:
        lines.append(f"left out: more than {MOST}, whose CSV files take minutes to write")
    lines.append("(differences of least times: below a hundredth of the whole they are noise)")
    return "\n".join(lines)
