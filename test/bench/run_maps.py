"""How good are summits? Maps pressed to a given share of their area, the summits against the truth.

    python test/bench/run_maps.py [MAP.sdf ...] [--made N] [--side N] [--shares A,B,...]
                                  [--ways W,X,...] [--csv FILE]

The truth is a boundary-element solution on every sample by numpy (test/truth/map_press_truth),
area corrected at its rim. Ways: contact, what a scene with a map computes; plain, the summits of
`--rule eight`; alone, the summits of a scene each for itself; half, the map at half its resolution.
Maps of files come in addition to N of our own. With --side 1024 and --ways contact what is claimed
of maps that are pressed coarser, give or take, stands beside what is true. Deterministic but for
the times.
"""

import argparse
import csv
import os
import re
import subprocess
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from made_maps import self_affine, write_bytes
from map_press_truth import press
from map_truth import levelled
from map_scenes import patch_areas
from whole_runs import Failed, press_map, release_build

MODULUS = 1e5
SHARES = (0.003, 0.01, 0.03, 0.1, 0.2)
WAYS = ("contact", "plain", "alone", "half")
SIDE, SPACING = 256, 1e-6
# Hurst exponent, shortest wave in samples, how much longer waves along a profile are.
MADE = {f"{'rough' if shortest < 4 else 'smooth'}_h{round(10 * hurst)}_s{shortest}_x{stretch}":
        (hurst, shortest, stretch) for hurst, shortest, stretch in (
            (0.8, 8, 1), (0.8, 2, 1), (0.5, 4, 1), (0.3, 8, 1), (1.0, 4, 1), (0.8, 16, 1),
            (0.8, 4, 2), (0.5, 8, 3), (0.8, 16, 4), (0.3, 2, 1), (0.5, 2, 2), (1.0, 2, 1))}


def made(name, side=SIDE):
    """Heights in metres of one of our own."""
    hurst, shortest, stretch = MADE[name]
    heights, _ = self_affine((side, side), 100 + list(MADE).index(name), hurst=hurst,
                             shortest=shortest, stretch=stretch)
    return 1e-7 * heights


def measured(path):
    """Heights and sampling of a file, read by sdfio."""
    import sdfio
    found = sdfio.read(path)
    return np.asarray(found.data, float), (found.header.x_scale, found.header.y_scale)


def half(height):
    """Of four samples the mean of their mean and the highest; of those that are there."""
    rows, columns = (n + n % 2 for n in height.shape)
    padded = np.full((rows, columns), np.nan)
    padded[:height.shape[0], :height.shape[1]] = height
    four = padded.reshape(rows // 2, 2, columns // 2, 2)
    with np.errstate(all="ignore"):
        return (np.nanmean(four, axis=(1, 3)) + np.nanmax(four, axis=(1, 3))) / 2


def truth(height, sides, load, closed=1e-7):
    """Level of the flat and corrected area."""
    level, pressure = press(height, sides, MODULUS, load, closed=closed)
    return level, patch_areas(pressure, sides, False).sum()


def load_for(height, sides, share):
    """What presses a share of the area, by the slope first, then by one trial."""
    total = np.isfinite(height).sum() * np.prod(sides)
    slope = np.sqrt(sum(np.nanmean((np.diff(height, axis=k) / sides[k]) ** 2) for k in (0, 1)))
    load = share * MODULUS * slope / 2 * total
    _, area = truth(height, sides, load, 1e-4)
    return float(load * share * total / area)


def told(summary, name):
    found = re.search(rf"{name} +([-+.\dEe]+)", summary.partition("Summits against boundary")[2])
    return float(found[1]) if found else float("nan")


def load_share(summary, place):
    """Percentage of the load at a place."""
    found = re.search(rf"([-+.\dEe]+) % {place}", summary.partition("Summits against boundary")[2])
    return float(found[1]) if found else float("nan")


def study(exe, name, height, sides, shares, ways):
    """A row a share and way."""
    height = levelled(height)
    rms = np.nanstd(height)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        write_bytes(folder / "map.sdf", height, *sides)
        subprocess.run([exe, "summits", folder / "map.sdf", "--output", folder / "plain.csv",
                        "--quiet"], check=True)
        # Below the plane: a cap of a surface in CSV is no higher than its sphere.
        plain = np.loadtxt(folder / "plain.csv", delimiter=",", skiprows=1, ndmin=2)
        top = plain[:, 2].max()
        plain[:, 2] -= top
        np.savetxt(folder / "plain.csv", plain, "%.17g", ",", header="x,y,height,radius",
                   comments="")
        across = (sides[1], sides[0])
        for share in shares:
            load = load_for(height, across, share)
            begin = time.perf_counter()
            level, area = truth(height, across, load)
            base = {"map": name, "share": share, "rms": rms, "load": load, "level": level,
                    "area": area, "truth_seconds": time.perf_counter() - begin,
                    "found_share": area / (np.isfinite(height).sum() * np.prod(sides))}
            for way in ways:
                row = dict(base, way=way)
                if way == "half":
                    begin = time.perf_counter()
                    at, its_area = truth(half(height), tuple(2 * s for s in across), load)
                    row.update(seconds=time.perf_counter() - begin)
                else:
                    file = "plain.csv" if way == "plain" else "map.sdf"
                    try:
                        row["seconds"], summary, (got, *_) = press_map(
                            exe, folder / file, [load], control="load", spacing=None,
                            modulus=MODULUS,
                            interaction="off" if way == "alone" else "coupled")
                    except Failed as failure:
                        row["failure"] = str(failure)
                        yield row
                        continue
                    at, its_area = float(got["separation"]), float(got["projected_area"])
                    if way == "plain":
                        at += top
                    else:
                        row.update(claim=told(summary, "separation"),
                                   give=told(summary, "uncertainty"), estimate=float(
                            got["error_estimate"] or "nan"), closing=np.nanmax(height) - level,
                                   edge=load_share(summary, "at the edge"),
                                   lines=load_share(summary, "on scan"),
                                   without=load_share(summary, "without a summit"))
                row.update(error=(at - level) / rms, ratio=its_area / area)
                yield row


COLUMNS = ("map", "share", "way", "found_share", "error", "ratio", "claim", "give", "estimate",
           "edge", "without", "lines", "seconds", "truth_seconds", "failure", "rms", "load",
           "level", "area", "closing")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("maps", nargs="*", help="surface data files")
    parser.add_argument("--made", type=int, default=len(MADE), help="how many of our own")
    parser.add_argument("--side", type=int, default=SIDE, help="samples of a side of our own")
    parser.add_argument("--shares", default=",".join(map(str, SHARES)))
    parser.add_argument("--ways", default=",".join(WAYS))
    parser.add_argument("--csv", help="all rows")
    options = parser.parse_args()
    exe, _ = release_build()
    maps = [(name, made(name, options.side), (SPACING, SPACING))
            for name in list(MADE)[:options.made]]
    maps += [(Path(file).stem, *measured(file)) for file in options.maps]
    rows = []
    for name, height, sides in maps:
        for row in study(exe, name, height, sides, map(float, options.shares.split(",")),
                         options.ways.split(",")):
            rows.append(row)
            print(f"{name:<20}{row['share']:>7}{row['way']:>9}  " + (
                f"{row['error']:+8.3f} rms{row['ratio']:>9.3f}{row.get('claim', np.nan):>+9.3f}"
                f"{row.get('give', np.nan):>7.3f}"
                f"{row.get('edge', np.nan):>7}{row.get('without', np.nan):>7}"
                f"{row.get('lines', np.nan):>7}{row['seconds']:>8.2f} s"
                if "error" in row else row["failure"]), flush=True)
            if options.csv:
                with open(options.csv, "w", encoding="ascii", newline="") as file:
                    table = csv.DictWriter(file, COLUMNS, restval="")
                    table.writeheader()
                    table.writerows(rows)
    report(rows)


def report(rows):
    """Middle and worst a way and share."""
    print(f"\n{'way':<9}{'share':>7}{'solved':>9}{'error':>16}{'area':>8}{'seconds':>9}")
    for way in dict.fromkeys(row["way"] for row in rows):
        for share in dict.fromkeys(row["share"] for row in rows):
            here = [row for row in rows if (row["way"], row["share"]) == (way, share)]
            good = [row for row in here if "error" in row]
            off = np.abs([row["error"] for row in good] or [np.nan])
            area = [row["ratio"] for row in good] or [np.nan]
            spent = np.median([row["seconds"] for row in good] or [np.nan])
            print(f"{way:<9}{share:>7}{len(good):>5}/{len(here):<3}{np.median(off):>8.3f}"
                  f"{off.max():>8.3f}{np.median(area):>8.3f}{spent:>9.2f}")


if __name__ == "__main__":
    main()
