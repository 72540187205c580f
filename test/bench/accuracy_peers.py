"""What accuracy costs for an archived map, with peers beside: the page docs/accuracy-map.html.

    python test/bench/accuracy_peers.py [--html FILE] [--seconds S]

One run measures all, one thread each: every way of `asperity accuracy --html`, the conjugate
gradients of the harness (numpy, Polonsky and Keer) and tamaas, which run_tamaas.py installs into a
venv of its own; where that cannot be, it is left out and the page says so. Peers press the same
levelled samples by the same load and are held against the program's reference: the level of the
flat over the closing, and the area where they tell one. Times are of the solve alone; ours are from
the scene read on.
"""

import argparse
import csv
import html
import os
import re
import subprocess
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from run_bench import release_build
from run_maps import measured, patch_areas, press
from run_tamaas import ENVIRONMENT, VERSION, its_python
from map_truth import levelled

ROOT = Path(__file__).resolve().parents[2]
SCENE = ROOT / "data/examples/summits/press.scene"
# What the scene says: micrometres and MPa.
MICRO, MODULUS, PRESSURE = 1e6, 1e5, 200.0
CLOSED = (1e-3, 1e-5, 1e-7)
TOLERANCES = (1e-3, 1e-6, 1e-9)
# A peer is run until it has taken so long, and the median is told.
LEAST_SECONDS, MOST_RUNS = 0.5, 9
HEAD = ("peer", "time, s", "error", "of the area")


def ours(exe, scene, page, seconds):
    """Writes the page; the row of the reference."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "ways.csv"
        subprocess.run([exe, "accuracy", os.path.relpath(scene, ROOT), "--seconds", str(seconds),
                        "--quiet", "--csv", file, "--html", page], cwd=ROOT, check=True)
        with open(file, encoding="ascii", newline="") as rows:
            return next(row for row in csv.DictReader(rows) if row["reference"] == "1")


def median(run):
    """Runs until the time is enough: the median of its seconds, and its last answer."""
    spent = []
    while len(spent) < MOST_RUNS and sum(spent) < LEAST_SECONDS:
        seconds, answer = run()
        spent.append(seconds)
    return float(np.median(spent)), answer


def by_numpy(height, sides, closed):
    def run():
        begin = time.perf_counter()
        load = PRESSURE * height.size * np.prod(sides)
        level, pressure = press(height, sides, MODULUS, load, closed=closed)
        return (time.perf_counter() - begin,
                (level, patch_areas(pressure, sides, False).sum()))
    return median(run)


def by_tamaas(python, heights, spacing, tolerance):
    def run():
        done = subprocess.run([python, ROOT / "test/bench/tamaas_map.py", heights,
                               *map(repr, (spacing, MODULUS, PRESSURE, tolerance))],
                              env=ENVIRONMENT, capture_output=True, text=True, check=True)
        seconds, _, level, *_ = map(float, done.stdout.split())
        return seconds, (level, None)
    return median(run)


def peers(height, sides):
    """Name, seconds, level and area of each; or why it is left out."""
    for closed in CLOSED:
        yield (f"numpy, Polonsky and Keer, gaps closed to {closed:.0e}",
               *by_numpy(height, sides, closed))
    python = its_python()
    if python is None:
        yield f"{VERSION}: cannot be installed here", None, None
        return
    with tempfile.TemporaryDirectory() as folder:
        heights = Path(folder) / "heights.npy"
        np.save(heights, height)
        for tolerance in TOLERANCES:
            yield (f"{VERSION.replace('==', ' ')}, tolerance {tolerance:.0e}",
                   *by_tamaas(python, heights, sides[0], tolerance))


def axis_of(page):
    """From seconds and error to a place in the diagram: by the dots that are there."""
    data = np.array(re.findall(r'^\[".*?",\s*(\S+?),\s*(\S+?)\],$', page, re.M), float)
    part = page[page.index('id="total-plot"'):]
    dots = np.array(re.findall(r'class="dot"[^>]*? cx="([^"]+)" cy="([^"]+)"', part), float)
    dots = dots[:len(data)]
    fits = [np.polyfit(np.log10(data[:, k]), dots[:, k], 1) for k in (0, 1)]
    # They lie on the lines: else the page has changed and this has not.
    for k, fit in enumerate(fits):
        assert np.abs(np.polyval(fit, np.log10(data[:, k])) - dots[:, k]).max() < 0.2, fit
    return fits, data


def with_peers(page, found):
    """The page with a section more, and a square a peer in the diagram where it has room."""
    (across, up), data = axis_of(page)
    rows, marks = [], []
    for name, seconds, error, area in found:
        cells = [name] + [f"{v:.1e}" if v is not None else "" for v in (seconds, error, area)]
        rows.append(f'<tr><th scope="row">{html.escape(cells[0])}</th>'
                    + "".join(f"<td>{c}</td>" for c in cells[1:]) + "</tr>")
        if seconds is None:
            continue
        x, y = (np.polyval(fit, np.log10(max(v, 1e-17))) for fit, v in
                ((across, seconds), (up, error)))
        inside = data[:, 0].min() / 2 <= seconds <= data[:, 0].max() * 2
        if inside and data[:, 1].min() <= error:
            marks.append(f'<path class="peer" fill="none" stroke="currentColor" stroke-width="1.5" '
                         f'd="M{x - 4:.1f} {y - 4:.1f}h8v8h-8z"><title>peer: '
                         f'{html.escape(name)}, {seconds:.1e} s, {error:.1e}</title></path>')
    plot = page.index('id="total-plot"')
    end = page.index("</svg>", plot)
    page = page[:end] + "".join(marks) + page[end:]
    title = "time and error of peers; squares in the diagram above"
    table = (
        '<section aria-labelledby="peers">\n'
        '<h2 id="peers">Peers, measured in the same run</h2>\n'
        '<p>The map is made, not measured: self-affine heights, data/examples/summits/smooth.sdf, '
        'whole numbers of 16 bits. Here the same levelled pixels under the same load, one thread, '
        'the solve alone; errors against the reference of this page.</p>\n'
        f'<div class="scroll" role="region" tabindex="0" aria-label="{title}">\n<table>\n'
        f'<caption>{title}</caption>\n<thead><tr>'
        + "".join(f'<th scope="col">{c}</th>' for c in HEAD) + "</tr></thead>\n<tbody>\n"
        + "\n".join(rows) + "\n</tbody>\n</table>\n</div>\n</section>\n")
    at = page.index('<section aria-labelledby="methods">')
    return page[:at] + table + page[at:]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--html", type=Path, default=ROOT / "docs/accuracy-map.html")
    parser.add_argument("--seconds", type=float, default=60.0, help="of the study (default 60)")
    options = parser.parse_args()
    exe, _ = release_build()
    best = ours(exe, SCENE, options.html.resolve(), options.seconds)
    height, sides = measured(SCENE.with_name("smooth.sdf"))
    height, sides = levelled(height * MICRO), tuple(s * MICRO for s in sides)
    level, area = float(best["separation"]), float(best["area"])
    closing = height.max() - level
    found = []
    for name, seconds, answer in peers(height, sides):
        # Nothing is known better than the reference.
        error = answer and max(abs(answer[0] - level) / closing, float(best["error_estimate"]))
        off = abs(answer[1] / area - 1) if answer and answer[1] else None
        found.append((name, seconds, error, off))
        print(*(found[-1]))
    page = options.html.read_text(encoding="utf-8")
    options.html.write_text(with_peers(page, found), encoding="utf-8")


if __name__ == "__main__":
    main()
