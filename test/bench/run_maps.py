"""Summits of height maps against their pixels, at given shares of the area in contact.

    python test/bench/run_maps.py [MAP.sdf ...] [--made N] [--side N] [--save]

The reference is a boundary-element solution on every pixel by numpy (test/truth/map_press_truth),
its area corrected at the perimeter. Ways: contact, the summits of `--rule contact`, coupled; plain,
those of `--rule eight`; alone, those of `--rule contact` without interaction. Maps of files come in
addition to N random ones. With --save the rows of these ways in reference_output/bench/maps.csv are
replaced. Deterministic.
"""

import argparse
import os
import tempfile
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from made_maps import self_affine, write_bytes
from map_press_truth import press
from map_scenes import patch_areas
from map_truth import levelled
from whole_runs import KEPT, Failed, press_summits, release_build

MODULUS = 1e5
SHARES = (0.003, 0.01, 0.03, 0.1, 0.2)
WAYS = {"contact": ("contact", "coupled"), "plain": ("eight", "coupled"),
        "alone": ("contact", "off")}
SPACING = 1e-6
# Hurst exponent, shortest wave in pixels, how much longer waves along a profile are.
MADE = ((0.8, 8, 1), (0.8, 2, 1), (0.5, 4, 1), (0.3, 8, 1), (1.0, 4, 1), (0.8, 16, 1), (0.8, 4, 2),
        (0.5, 8, 3), (0.8, 16, 4), (0.3, 2, 1), (0.5, 2, 2), (1.0, 2, 1))
HEAD = "way,share,solved,tried,error_median,error_worst,area_median,area_off_median,area_off_worst"


def made(number, side):
    """Heights in metres of a random map."""
    hurst, shortest, stretch = MADE[number]
    return 1e-7 * self_affine((side, side), 100 + number, hurst=hurst, shortest=shortest,
                              stretch=stretch)[0]


def measured(path):
    """Heights and spacing of a file, read by sdfio."""
    import sdfio
    found = sdfio.read(path)
    return np.asarray(found.data, float), (found.header.x_scale, found.header.y_scale)


def reference(height, sides, load, closed=1e-7):
    """Level of the flat and corrected area."""
    level, pressure = press(height, sides, MODULUS, load, closed=closed)
    return level, patch_areas(pressure, sides, False).sum()


def load_for(height, sides, share):
    """The load of a share of the area: by the slope first, then by one solve."""
    total = np.isfinite(height).sum() * np.prod(sides)
    slope = np.sqrt(sum(np.nanmean((np.diff(height, axis=k) / sides[k]) ** 2) for k in (0, 1)))
    load = share * MODULUS * slope / 2 * total
    return float(load * share * total / reference(height, sides, load, 1e-4)[1])


def compare(exe, height, sides):
    """Way, share, error of the separation in rms heights and ratio of areas; None: not solved."""
    height, across = levelled(height), (sides[1], sides[0])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.sdf"
        write_bytes(path, height, *sides)
        for share in SHARES:
            load = load_for(height, across, share)
            level, area = reference(height, across, load)
            for way, (rule, interaction) in WAYS.items():
                try:
                    _, _, (row,) = press_summits(exe, path, [load], control="load", rule=rule,
                                                 modulus=MODULUS, interaction=interaction)
                    yield (way, share, (float(row["separation"]) - level) / np.nanstd(height),
                           float(row["projected_area"]) / area)
                except Failed as failure:
                    print(failure)
                    yield way, share, None, None


def table(rows):
    """Medians and largest values of each way and share."""
    for way in sorted(WAYS):
        for share in SHARES:
            here = [row[2:] for row in rows if row[:2] == (way, share)]
            solved = np.array([row for row in here if row[0] is not None]).reshape(-1, 2)
            error, area = np.abs(solved[:, 0]), solved[:, 1]
            numbers = (np.median(error), error.max(), np.median(area),
                       np.median(abs(area - 1)), abs(area - 1).max()) if len(solved) else ()
            yield f"{way},{share},{len(solved)},{len(here)}," + ",".join(
                f"{number:.3g}" for number in numbers)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("maps", nargs="*", help="surface data files")
    parser.add_argument("--made", type=int, default=len(MADE), help="number of random maps")
    parser.add_argument("--side", type=int, default=256, help="pixels of a side of a random map")
    parser.add_argument("--save", action="store_true", help="also to reference_output/bench")
    words = parser.parse_args()
    exe, _ = release_build()
    rows = []
    for height, sides in ([(made(number, words.side), (SPACING, SPACING))
                           for number in range(words.made)] + [*map(measured, words.maps)]):
        rows += compare(exe, height, sides)
        print(f"{len(rows)} solves", flush=True)
    lines = list(table(rows))
    print(HEAD, *lines, sep="\n")
    if words.save:
        kept = [line for line in (KEPT / "maps.csv").read_text(encoding="ascii").splitlines()[1:]
                if line.partition(",")[0] not in WAYS]
        (KEPT / "maps.csv").write_text("\n".join([HEAD, *sorted(lines + kept), ""]),
                                       encoding="ascii")


if __name__ == "__main__":
    main()
