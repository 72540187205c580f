"""Separation and mean gap of a free height map against the size of the scan.

    python test/bench/scan_size.py

Squares are cut out of one random height map of 1024 x 1024 pixels (Hurst exponent 0.8, roll-off 64
pixels, cut-off 8) and pressed with a free edge at one nominal pressure. Writes
reference_output/bench/scan_size.csv: side over roll-off, separation and mean gap over rms height.
"""

import csv
import datetime
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from run_bench import ROOT, release_build

SIDE, ROLL_OFF, CUT_OFF = 1024, 64, 8
SIDES = (64, 96, 128, 192, 256, 384, 512, 768, 1024)
# Of contact modulus times rms slope.
PRESSURE, SLOPE = 0.05, 0.1


def solved(exe, folder, heights):
    """Separation and mean gap under the pressure."""
    np.save(folder / "part.npy", heights)
    (folder / "part.scene").write_text(
        "&surfaces upper = 'plane', lower = 'part.npy', map_spacing = 1., 1. /\n"
        "&material contact_modulus = 1. /\n"
        f"&loading control = 'pressure', value = {PRESSURE * SLOPE!r} /\n"
        "&effects interaction = 'boundary' /\n")
    subprocess.run([exe, "solve", folder / "part.scene", "--quiet", "--positions",
                    folder / "part.csv"], check=True, capture_output=True)
    with open(folder / "part.csv", encoding="ascii", newline="") as file:
        row = next(csv.DictReader(file))
    return float(row["separation"]), float(row["mean_gap"])


def main():
    exe, _ = release_build()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "map.spec").write_text(
            f"&map pixels = {SIDE}, spacing = 1., hurst = 0.8, roll_off = {ROLL_OFF}., "
            f"cut_off = {CUT_OFF}., rms_slope = {SLOPE}, periodic = 'off' /\n")
        subprocess.run([exe, "generate", folder / "map.spec", "--output", folder / "map.npy"],
                       check=True, capture_output=True)
        heights = np.load(folder / "map.npy")
        rms = heights.std()
        lines = [f"# {datetime.date.today()}; python test/bench/scan_size.py",
                 "side,separation,mean_gap"]
        for side in SIDES:
            separation, gap = solved(exe, folder, heights[:side, :side])
            lines.append(f"{side / ROLL_OFF},{separation / rms:.6f},{gap / rms:.6f}")
            print(lines[-1])
    (ROOT / "reference_output/bench/scan_size.csv").write_text("\n".join(lines) + "\n",
                                                               encoding="ascii")


if __name__ == "__main__":
    main()
