"""Whole runs of the program, timed from outside: surfaces and scenes as files, the least time of
runs that take turns, peak memory. Shared by the parts of the scale benchmark."""

import hashlib
import math
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from run_bench import output_of, peak_of
from search_files import ROOT, Surface

DENSITY = 0.48
RADIUS = 1.27
MODULUS = 275760.0
POISSON = 0.42
LIMIT_LOAD = 288.89

# One thread unless a run asks for more. Open MPI wants to be told that root and few cores are fine.
ENVIRONMENT = {
    **os.environ, "OMP_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1"}


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
        with tempfile.TemporaryFile() as printed, tempfile.TemporaryFile() as told:
            begin = time.perf_counter()
            processes = [self.start(printed if i == 0 else subprocess.DEVNULL, told)
                         for i in range(self.copies)]
            ends = [process.wait() for process in processes]
            seconds = time.perf_counter() - begin
            printed.seek(0)
            output = hashlib.sha256(printed.read()).hexdigest()
            told.seek(0)
            last = told.read().decode(errors="replace").strip().splitlines()[-1:]
        wrong = [end for end in ends if end != self.status]
        if wrong:
            # What the run said may hold paths: it is shown, not saved.
            print(*self.command, *last, sep="\n  ", file=sys.stderr)
            raise Failed(f"ended with status {wrong[0]}")
        if self.output not in (None, output):
            raise Failed("prints something else every time")
        self.output = output
        self.least = min(self.least, seconds)

    def start(self, printed, told):
        return subprocess.Popen(self.command, cwd=ROOT, env=ENVIRONMENT, stdin=subprocess.DEVNULL,
                                stdout=printed, stderr=told)

    def peak(self):
        """Bytes resident at most, in a run of its own."""
        return peak_of(self.start(subprocess.DEVNULL, subprocess.DEVNULL), pause=0.001)


def take_turns(works, rounds):
    """A slow moment of the machine must hit all of them."""
    for _ in range(rounds):
        for work in works:
            work.run()


def same_output(*works):
    """A bench of different works would say nothing."""
    if len({work.output for work in works}) > 1:
        raise Failed("prints something else")


def images_build():
    """How to start several images of the build for them, or why that cannot be."""
    if not shutil.which("cafrun"):
        return None, "no OpenCoarrays here (cafrun): two images are left out"
    path = output_of("bash", ".ci/build", "images")
    if not path:
        return None, "the build for images failed: two images are left out"
    return lambda number: ["cafrun", "-n", number, path], ""


def images_flags():
    """Flags of the build for images, where its scripts keep them."""
    script = '. .ci/common.sh && options_of images && echo "${fpm_options[*]}"'
    return output_of("bash", "-c", script)


def available_memory():
    """Bytes that the system would give now; endless where it does not tell."""
    path = Path("/proc/meminfo")
    for line in path.read_text().splitlines() if path.exists() else ():
        if line.startswith("MemAvailable:"):
            return 1024 * int(line.split()[1])
    return math.inf


def free_disk():
    """Bytes free where temporary files go."""
    return shutil.disk_usage(tempfile.gettempdir()).free
