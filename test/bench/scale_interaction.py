"""Interaction: user seconds and peak memory of the default beside `coupled` and `off`, on one
thread. Part of run_scale.py; test_dense.py has the errors.
"""

import resource
import subprocess
import tempfile
from pathlib import Path

from dense_scenes import Rough
from effect_runs import random_caps, write_caps
from whole_runs import ENVIRONMENT, peak_of

# Caps, seed and load a cap [N]; the sparse ones have contacts far apart.
ROUGH = ((100, 5, 40.0), (10_000, 5, 40.0), (100_000, 5, 40.0), (1_000_000, 5, 40.0),
         (2000, 31, 10.0), (2000, 31, 40.0), (2000, 31, 160.0))
SPARSE = (100_000, 5, 1e-4)
DENSE_POSITIONS = 6


def aligned(cells):
    return "".join(f"{cell:>{width}}" for cell, width in
                   zip(map(str, cells), (18, 10, 10, 10, 10, 13, 10, 10, 10, 10))).rstrip()


def run(exe, scene):
    """User seconds, and MiB at the peak."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    process = subprocess.Popen([exe, "solve", scene, "--quiet", "--threads", "1"],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                               env=ENVIRONMENT)
    peak = peak_of(process, 0.002)
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return seconds, peak / 2 ** 20


def dense(folder, mode):
    """2000 caps of half-normal heights at 20 kN, 630 contacts: one position, and more."""
    scenes = []
    for number in (1, DENSE_POSITIONS):
        place = folder / f"dense.{mode}.{number}"
        place.mkdir()
        scenes.append(write_caps(place, *random_caps(2000, 7.6, 10.0, 7),
                                 motion={"positions": number, "x_step": 0.0},
                                 loading={"control": "load", "value": 2.0e4},
                                 effects={"interaction": mode}).scene)
    return scenes


def rough(folder, number, seed, each, mode):
    place = folder / f"{number}.{each:g}.{mode}"
    effects = {} if mode == "auto" else {"interaction": mode}
    return Rough(number, seed, 0.0, number * each).write(place, by_default=True, **effects)


def interaction_part(asperity, most, rounds, beside=None):
    """The lines: seconds and memory by scene, mode and executable."""
    names = {"": asperity, **({"before": beside} if beside else {})}
    lines = ["interaction: user seconds and MiB of one thread, the least of the rounds",
             aligned(("caps", "N a cap", "mode", "program", "s", "over coupled", "MiB"))]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for number, seed, each in (*ROUGH, SPARSE):
            if number > most:
                continue
            base = {}
            for mode in ("coupled", "auto", "off") if each == SPARSE[2] else ("coupled", "auto"):
                scene = rough(folder, number, seed, each, mode)
                for program, exe in names.items():
                    if program and number > 10_000:
                        continue
                    found = min(run(exe, scene) for _ in range(rounds))
                    base.setdefault(program, found[0])
                    lines.append(aligned((number, f"{each:g}", mode, program, f"{found[0]:.3f}",
                                          f"{found[0] / max(base[program], 1e-3):.2f}",
                                          f"{found[1]:.0f}")))
                    print(lines[-1], flush=True)
        for mode in ("coupled", "auto"):
            one, many = dense(folder, mode)
            for program, exe in names.items():
                seconds = (min(run(exe, many)[0] for _ in range(rounds))
                           - min(run(exe, one)[0] for _ in range(rounds))) / (DENSE_POSITIONS - 1)
                lines.append(aligned(("630 dense", "", mode, program, f"{1e3 * seconds:.1f} ms")))
    return "\n".join(lines)
