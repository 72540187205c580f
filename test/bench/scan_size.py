"""Separation and mean gap of a free height map against the size of the scan.

    python test/bench/scan_size.py

Squares are cut out of one random height map of 1024 x 1024 pixels (Hurst exponent 0.8, roll-off 64
pixels, cut-off 8) and pressed with a free edge at one nominal pressure. Writes
reference_output/bench/scan_size.csv: side over roll-off, separation and mean gap over rms height.
"""

import tempfile
from pathlib import Path

import numpy as np

from whole_runs import KEPT, heading, make_map, press_map, release_build

SIDE, ROLL_OFF, CUT_OFF = 1024, 64, 8
SIDES = (64, 96, 128, 192, 256, 384, 512, 768, 1024)
# Of contact modulus times rms slope.
PRESSURE, SLOPE = 0.05, 0.1


def main():
    exe, _ = release_build()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make_map(exe, folder, pixels=SIDE, spacing=1.0, hurst=0.8, roll_off=ROLL_OFF,
                 cut_off=CUT_OFF, rms_slope=SLOPE, periodic="'off'")
        heights = np.load(folder / "map.npy")
        rms = heights.std()
        lines = [f"{heading()}scan_size.py", "side,separation,mean_gap"]
        for side in SIDES:
            np.save(folder / "part.npy", heights[:side, :side])
            _, _, (row, *_) = press_map(exe, folder / "part.npy", [PRESSURE * SLOPE], "--quiet")
            separation, gap = (float(row[name]) / rms for name in ("separation", "mean_gap"))
            lines.append(f"{side / ROLL_OFF},{separation:.6f},{gap:.6f}")
            print(lines[-1])
    (KEPT / "scan_size.csv").write_text("\n".join(lines) + "\n", encoding="ascii")


if __name__ == "__main__":
    main()
