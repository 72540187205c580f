"""Periodic height maps solved on their pixels by asperity and by tamaas, in one run.

    python test/bench/map_beside_tamaas.py [--pixels N ...] [--save]

Random maps (Hurst exponent 0.8, roll-off a fifth of the side, cut-off 8 pixels) at a nominal
pressure of 0.05 contact modulus times rms slope, and at five pressures in one run, on one and on
two threads. The residual is the largest distance of pixels under pressure from the flat, over the
range of heights: at most 1e-10 at each pressure by asperity. The tolerance of tamaas is lowered by
factors of ten, from ten times that of the run before, until its residuals are so too; these solves
count. The time of asperity is that of the whole command with reading and writing, that of tamaas is
its solves alone.
"""

import argparse
import csv
import itertools
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from run_bench import ROOT, machine, release_build, save
from run_tamaas import VERSION, its_python

SLOPE = 0.01
# Nominal pressures over contact modulus times rms slope.
PRESSURES = ((0.05,), (0.002, 0.01, 0.05, 0.15, 0.4))
RESIDUAL = 1e-10
# What the columns of the record are.
ABOUT = f"""\
command   python test/bench/map_beside_tamaas.py {" ".join(sys.argv[1:])}
programs  asperity solve; {VERSION}, PolonskyKeerRey
map       periodic self-affine, Hurst 0.8, roll-off a fifth of the side, cut-off 8 pixels, rms
          slope {SLOPE}
pressures nominal, over contact modulus times rms slope: 0.05, or a run of five: 0.002, 0.01, 0.05,
          0.15 and 0.4
seconds   of the whole command of asperity with reading and writing; of the solves of tamaas alone
residual  largest gap of pixels under pressure over the range of heights: of asperity at the last
          pressure, at each at most 1e-10; the largest of tamaas at the first tolerance with at
          most 1e-10
ratio     seconds of tamaas over those of asperity; two threads on a busy machine can be slower"""


def ours(exe, folder, threads):
    """Seconds and residual, which is at most `RESIDUAL` at each pressure."""
    begin = time.perf_counter()
    subprocess.run([exe, "solve", folder / "map.scene", "--quiet", "--threads", str(threads),
                    "--positions", folder / "map.csv"], check=True, capture_output=True,
                   env={**os.environ, "OMP_NUM_THREADS": str(threads)})
    seconds = time.perf_counter() - begin
    with open(folder / "map.csv", encoding="ascii", newline="") as file:
        return seconds, float(next(csv.DictReader(file))["interaction_residual"])


def theirs(python, folder, pressures, threads, power):
    """Seconds, residual and the power of ten of the first tolerance with small residuals."""
    while True:
        done = subprocess.run(
            [python, ROOT / "test/bench/tamaas_map.py", folder / "map.npy", "1", "1",
             ",".join(map(repr, pressures)), f"1e-{power}", "periodic", str(threads)], check=True,
            capture_output=True, text=True, env={**os.environ, "OMP_NUM_THREADS": str(threads)})
        _, _, _, seconds, found = map(float, done.stdout.split())
        if found <= RESIDUAL:
            return seconds, found, power
        power += 1


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--pixels", type=int, nargs="+", default=[256, 512, 1024])
    parser.add_argument("--save", action="store_true")
    words = parser.parse_args()
    exe, flags = release_build()
    python = its_python()
    if python is None:
        print("tamaas cannot be installed here")
        return
    lines = [*machine(flags), *ABOUT.splitlines(), "",
             "pixels pressures threads  asperity s  residual   tamaas s  residual   ratio"]
    print(lines[-1], flush=True)
    power = 7
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for pixels in words.pixels:
            (folder / "map.spec").write_text(
                f"&map pixels = {pixels}, spacing = 1., hurst = 0.8, roll_off = {pixels / 5}, "
                f"cut_off = 8., rms_slope = {SLOPE} /\n")
            subprocess.run([exe, "generate", folder / "map.spec", "--output",
                            folder / "map.npy"], check=True, capture_output=True)
            for shares, threads in itertools.product(PRESSURES, (1, 2)):
                pressures = [SLOPE * share for share in shares]
                (folder / "map.scene").write_text(
                    "&surfaces upper = 'plane', lower = 'map.npy', map_spacing = 1., 1., "
                    "map_edge = 'periodic' /\n&material contact_modulus = 1. /\n&loading control = "
                    f"'pressure', value = {', '.join(map(repr, pressures))} /\n"
                    "&effects interaction = 'boundary' /\n")
                seconds, residual = ours(exe, folder, threads)
                other, found, power = theirs(python, folder, pressures, threads, power - 1)
                lines.append(f"{pixels:6} {len(shares):9} {threads:7} {seconds:11.2f} "
                             f"{residual:9.1e} {other:10.2f} {found:9.1e} {other / seconds:7.1f}")
                print(lines[-1], flush=True)
    if words.save:
        save("map_beside_tamaas.txt", "\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
