"""Contact area of self-affine surfaces against nominal pressure, beside two theories.

    python test/bench/map_area.py [--pixels N] [--cut-off LENGTH] [--realisations N]
                                  [--methods NAME ...] [--save]

Periodic random height maps of side 100, Hurst exponent 0.8 and roll-off 20, as those of the
Contact Mechanics Challenge (Tribology Letters 65 (2017) 118), made by `asperity generate`. All
pixels are solved at nominal pressures p from 0.001 to 0.3 of contact modulus times rms slope. On
pixels the result depends on p alone; the rms slope is small for the summits, whose spheres it
keeps shallow (`asperity summits --rule contact`). The area of the pixels in contact is corrected by
their perimeter, A - (pi - 1 + ln 2)/24 S d, with the width d of a pixel (Yastrebov, Anciaux and
Molinari, J. Mech. Phys. Solids 107 (2017) 469). The same maps with a free edge are solved on their
pixels and by their summits, with and without interaction.

Theories for an area fraction a at p = pressure/(contact modulus times rms slope): Persson (2001),
a = erf(sqrt(2) p); Bush, Gibson and Thomas (1975) at small pressures, a = sqrt(2 pi) p.
"""

import argparse
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from whole_runs import (ROOT, Failed, heading, make_map, press_map, press_summits,
                        release_build)

SIDE, HURST, ROLL_OFF, SLOPE = 100.0, 0.8, 20.0, 0.01
PRESSURES = (0.001, 0.003, 0.01, 0.03, 0.06, 0.1, 0.2, 0.3)
# Summits are solved below the percolation of their contacts.
MOST_FOR_SUMMITS = 0.06
RIM = (math.pi - 1 + math.log(2)) / 24
METHODS = {"pixels_periodic": ("boundary", "periodic"), "pixels_free": ("boundary", "free"),
           "summits_coupled": ("coupled", "free"), "summits_off": ("off", "free")}


def area_fractions(exe, path, pixels, method):
    """Area fraction by p; none where the solve fails."""
    interaction, edge = METHODS[method]
    step = SIDE / pixels
    try:
        if interaction == "boundary":
            _, _, rows = press_map(exe, path, [SLOPE * p for p in PRESSURES], spacing=step,
                                   edge=edge, files=("curve",))
        else:
            _, _, rows = press_summits(
                exe, path, [SLOPE * p for p in PRESSURES if p <= MOST_FOR_SUMMITS], spacing=step,
                area=SIDE**2, interaction=interaction, files=("curve",))
    except Failed as failure:
        print(failure)
        return {}
    found = {}
    for pressure, row in zip(PRESSURES,
                             (row for row in rows if float(row["nominal_pressure"]) > 0)):
        found[pressure] = float(row["area_fraction"])
        if interaction == "boundary":
            found[pressure] -= RIM * float(row["contact_perimeter"]) * step / SIDE**2
    return found


def theories(pressure):
    """Area fractions of Persson, and of Bush, Gibson and Thomas."""
    return math.erf(math.sqrt(2) * pressure), math.sqrt(2 * math.pi) * pressure


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--pixels", type=int, default=1024)
    parser.add_argument("--cut-off", type=float, default=0.4)
    parser.add_argument("--realisations", type=int, default=5)
    parser.add_argument("--methods", nargs="+", choices=list(METHODS), default=list(METHODS))
    parser.add_argument("--save", action="store_true")
    words = parser.parse_args()
    # Another cut-off has a file of its own.
    name = "map_area.csv" if words.cut_off == 0.4 else f"map_area_cut_off_{words.cut_off}.csv"
    exe, _ = release_build()
    with tempfile.TemporaryDirectory() as folder:
        found = {method: [] for method in words.methods}
        for seed in range(1, words.realisations + 1):
            path = make_map(exe, Path(folder), pixels=words.pixels, spacing=SIDE / words.pixels,
                            hurst=HURST, roll_off=ROLL_OFF, cut_off=words.cut_off,
                            rms_slope=SLOPE, seed=seed)
            for method in words.methods:
                found[method].append(area_fractions(exe, path, words.pixels, method))
    lines = ["cut_off,pixels,method,pressure,realisations,area_fraction,deviation,"
             "persson,bush_gibson_thomas"]
    for method, runs in found.items():
        for pressure in PRESSURES:
            values = [run[pressure] for run in runs if pressure in run]
            if values:
                persson, asperities = theories(pressure)
                lines.append(f"{words.cut_off},{words.pixels},{method},{pressure},{len(values)},"
                             f"{np.mean(values):.6f},{np.std(values):.6f},{persson:.6f},"
                             f"{asperities:.6f}")
    print("\n".join(lines))
    table = (f"{heading()}map_area.py --pixels {words.pixels} --cut-off {words.cut_off} "
             f"--realisations {words.realisations} --methods {' '.join(words.methods)}\n" +
             "\n".join(lines) + "\n")
    for path in [f"build/{name}", f"reference_output/bench/{name}"][:1 + words.save]:
        (ROOT / path).write_text(table, encoding="ascii")
    if words.save:
        subprocess.run([sys.executable, "docs/figures/draw.py", exe, "map-area"], cwd=ROOT,
                       check=True)


if __name__ == "__main__":
    main()
