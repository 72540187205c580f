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
import itertools
import sys
import tempfile
from pathlib import Path

from run_tamaas import VERSION, its_python, solve_by_tamaas
from whole_runs import machine, make_map, press_map, release_build, save

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


def theirs(python, path, pressures, threads, power):
    """Seconds, residual and the power of ten of the first tolerance with small residuals."""
    while True:
        _, _, seconds, found = solve_by_tamaas(
            python, path, 1, 1, ",".join(map(repr, pressures)), f"1e-{power}", "periodic", threads)
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
            path = make_map(exe, folder, pixels=pixels, spacing=1.0, hurst=0.8, cut_off=8.0,
                            roll_off=pixels / 5, rms_slope=SLOPE)
            for shares, threads in itertools.product(PRESSURES, (1, 2)):
                pressures = [SLOPE * share for share in shares]
                # The residual of asperity is at most RESIDUAL at each pressure.
                seconds, _, (row, *_) = press_map(exe, path, pressures, "--quiet", edge="periodic",
                                                  threads=threads)
                other, found, power = theirs(python, path, pressures, threads, power - 1)
                residual = float(row["interaction_residual"])
                lines.append(f"{pixels:6} {len(shares):9} {threads:7} {seconds:11.2f} "
                             f"{residual:9.1e} {other:10.2f} {found:9.1e} {other / seconds:7.1f}")
                print(lines[-1], flush=True)
    if words.save:
        save("map_beside_tamaas.txt", "\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
