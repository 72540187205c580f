"""Whole runs of the program, timed from outside: surfaces, maps and scenes as files, the least time
of runs that take turns, peak memory; the machine and the kept records. All benchmarks share it."""

import datetime
import hashlib
import math
import os
import platform
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from csv_rows import records
from placed_asperities import Surface

ROOT = Path(__file__).resolve().parents[2]
KEPT = ROOT / "reference_output/bench"

DENSITY = 0.48
RADIUS = 1.27
MODULUS = 275760.0
POISSON = 0.42
LIMIT_LOAD = 288.89

# One thread unless a run has an option for more.
ENVIRONMENT = {**os.environ, "OMP_NUM_THREADS": "1"}


def output_of(*command):
    done = subprocess.run(
        command, cwd=ROOT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True
    )
    return done.stdout.strip() if done.returncode == 0 else ""


def release_build():
    """Path of the executable and the flags it was compiled with, as fpm reports them."""
    path = output_of("bash", ".ci/build", "release")
    if not path:
        raise SystemExit("bench: the release build failed, see: bash .ci/build release")
    fpm = ROOT / ".venv" / "bin" / "fpm"
    model = output_of(str(fpm), "build", "--profile", "release", "--show-model")
    flags = re.search(r'fortran_compile_flags="([^"]*)"', model)
    return path, flags.group(1) if flags else "not known"


def machine(flags):
    """The lines without which the numbers below mean nothing."""
    cpuinfo = Path("/proc/cpuinfo")
    text = cpuinfo.read_text() if cpuinfo.exists() else ""
    model = re.search(r"^model name\s*:\s*(.*)$", text, re.MULTILINE)
    compiler = output_of(os.environ.get("FPM_FC", "gfortran"), "--version").splitlines()
    return [
        f"date      {datetime.date.today().isoformat()}",
        f"machine   {model.group(1) if model else platform.machine()}, {os.cpu_count()} cores, "
        f"{platform.system()} {platform.release()}",
        f"compiler  {compiler[0] if compiler else 'not known'}",
        f"flags     {flags}",
    ]


def heading():
    """Date and machine in one line, for the first line of a CSV file."""
    return f"# {datetime.date.today()}; {machine('')[1].split(maxsplit=1)[1]}; python test/bench/"


def save(name, text):
    """Keep a text in a file of this day."""
    stem, _, ending = name.rpartition(".")
    path = KEPT / f"{stem}.{datetime.date.today().isoformat()}.{ending}"
    path.write_text(text, encoding="utf-8")
    print(f"saved     {path.relative_to(ROOT)}")


def surfaces(n):
    """An upper and a lower one. Heights as in the thesis: 0.050 in mean, 0.012 in deviation, cut at
    both ends; places at random, 0.48 to the cm2."""
    rng = np.random.default_rng(1978)
    side = math.sqrt(n / DENSITY)
    return [Surface(rng.random(n) * side, rng.random(n) * side,
                    2.54 * rng.normal(0.050, 0.012, n).clip(0.020, 0.080), RADIUS)
            for _ in range(2)]


def write_csv(path, surface):
    table = np.column_stack((surface.x, surface.y, surface.height))
    np.savetxt(path, table, "%.17g", ",", header="x,y,height", comments="")


def write_scene(path, surfaces_text, motion, loading="control = 'limit'", limit=LIMIT_LOAD):
    """`surfaces_text` names a deck or two CSV files. Without a limit load the scene is refused."""
    lines = [f"&surfaces  {surfaces_text} /",
             f"&material  elastic_modulus = 2*{MODULUS}, poisson_ratio = 2*{POISSON} /",
             f"&motion    {motion} /", f"&loading   {loading} /"]
    if limit:
        lines.append(f"&limit     criterion = 'load', value = {limit} /")
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


class Failed(Exception):
    """A run that ended otherwise than it should."""


class Work:
    """A command, or copies of it at once, and what came of its runs."""

    def __init__(self, *command, copies=1, status=0):
        self.command = [str(word) for word in command]
        self.copies = copies
        self.status = status
        self.least = math.inf
        self.output = None

    def run(self):
        """Keep the least time from before the first start until the last end. Whatever is printed
        must be the same every time."""
        with tempfile.TemporaryFile() as printed, tempfile.TemporaryFile() as reported:
            begin = time.perf_counter()
            processes = [self.start(printed if i == 0 else subprocess.DEVNULL, reported)
                         for i in range(self.copies)]
            ends = [process.wait() for process in processes]
            seconds = time.perf_counter() - begin
            printed.seek(0)
            output = hashlib.sha256(printed.read()).hexdigest()
            reported.seek(0)
            last = reported.read().decode(errors="replace").strip().splitlines()[-1:]
        wrong = [end for end in ends if end != self.status]
        if wrong:
            # What the run stated may hold paths: it is shown, not saved.
            print(*self.command, *last, sep="\n  ", file=sys.stderr)
            raise Failed(f"ended with status {wrong[0]}")
        if self.output not in (None, output):
            raise Failed("prints something else every time")
        self.output = output
        self.least = min(self.least, seconds)

    def start(self, printed, reported):
        return subprocess.Popen(self.command, cwd=ROOT, env=ENVIRONMENT, stdin=subprocess.DEVNULL,
                                stdout=printed, stderr=reported)

    def peak(self):
        """Bytes resident at most, in a run of its own."""
        return peak_of(self.start(subprocess.DEVNULL, subprocess.DEVNULL), pause=0.001)


def take_turns(works, rounds):
    """A slow moment of the machine must hit all of them."""
    for _ in range(rounds):
        for work in works:
            work.run()


def same_output(*works):
    """A bench of different works would state nothing."""
    if len({work.output for work in works}) > 1:
        raise Failed("prints something else")


def available_memory():
    """Bytes that the system would give now; endless where it does not report."""
    path = Path("/proc/meminfo")
    for line in path.read_text().splitlines() if path.exists() else ():
        if line.startswith("MemAvailable:"):
            return 1024 * int(line.split()[1])
    return math.inf


def peak_of(process, pause=0.0):
    """Bytes resident at most of a process just started, read until it has gone; 0 where the system
    does not report.

    Not ru_maxrss: what the kernel reports there includes the parent's pages before exec.
    """
    peak = 0
    status = Path(f"/proc/{process.pid}/status")
    while process.poll() is None:
        try:
            found = re.search(r"VmHWM:\s+(\d+) kB", status.read_text())
        except OSError:
            found = None
        if found:
            peak = max(peak, 1024 * int(found.group(1)))
        if pause:
            time.sleep(pause)
    return peak


def make_map(exe, folder, **names):
    """A random height map by `asperity generate`, as map.npy in the folder."""
    (folder / "map.spec").write_text(
        f"&map {', '.join(f'{name} = {value}' for name, value in names.items())} /\n")
    subprocess.run([exe, "generate", folder / "map.spec", "--output", folder / "map.npy"],
                   check=True, capture_output=True)
    return folder / "map.npy"


def press_map(exe, path, values, *words, spacing=1.0, edge="free", level="", **how):
    """Solve the pixels of a height map under a plane as `solve_surface` does.

    A map with a spacing of its own has `spacing=None`; a strip has two edges.
    """
    edge = ", ".join(map(repr, [edge] if isinstance(edge, str) else edge))
    of_map = "" if spacing is None else (
        f", map_spacing = {spacing!r}, {spacing!r}, map_edge = {edge}")
    of_map += f", map_level = {level!r}" if level else ""
    return solve_surface(exe, path, of_map, values, *words, **how)


def press_summits(exe, path, values, *words, spacing=None, area=None, rule="contact", **how):
    """Solve the summits of a height map under a plane; separations are those of its mean plane."""
    table = path.with_suffix(".csv")
    subprocess.run([exe, "summits", path, "--rule", rule, "--output", table, "--quiet",
                    *(["--spacing", repr(spacing)] if spacing else [])], check=True,
                   capture_output=True)
    # Below the plane: a cap is no higher than its sphere.
    caps = np.loadtxt(table, delimiter=",", skiprows=1, ndmin=2)
    top = caps[:, 2].max()
    np.savetxt(table, caps - [0, 0, top, 0], "%.17g", ",", header="x,y,height,radius", comments="")
    seconds, summary, *tables = solve_surface(
        exe, table, f", nominal_area = {area!r}" if area else "", values, *words, **how)
    for row in (row for table in tables for row in table if "separation" in row):
        row["separation"] = str(float(row["separation"]) + top)
    return seconds, summary, *tables


def solve_surface(exe, path, more, values, *words, control="pressure", interaction="boundary",
                  modulus=1.0, files=("positions",), threads=1, effects="", material="",
                  loading=""):
    """Solve a surface under a plane: seconds of the whole process, what it prints, and the rows of
    each file. `more`, `loading` and `effects` are further names of &surfaces, &loading and
    &effects, `material` those of &material in place of the modulus."""
    scene = path.with_suffix(".scene")
    scene.write_text(
        f"&surfaces upper = 'plane', lower = '{path.name}'{more} /\n"
        f"&material {material or f'contact_modulus = {modulus!r}'} /\n"
        f"&loading control = '{control}', value = {', '.join(repr(float(v)) for v in values)}"
        f"{loading} /\n"
        f"&effects interaction = '{interaction}'{effects} /\n", encoding="ascii")
    paths = [path.with_suffix(f".{name}.csv") for name in files]
    begin = time.perf_counter()
    done = subprocess.run(
        [exe, "solve", scene, "--threads", str(threads), *words,
         *(word for name, file in zip(files, paths) for word in (f"--{name}", file))],
        capture_output=True, text=True, check=False,
        env={**os.environ, "OMP_NUM_THREADS": str(threads)})
    seconds = time.perf_counter() - begin
    if done.returncode:
        raise Failed(done.stderr.strip())
    return seconds, done.stdout, *map(records, paths)
