"""Run time and error of each mode of interaction on four kinds of surfaces: what to type.

    python test/bench/accuracy_costs.py [--seconds 60] [--save]

Runs `asperity accuracy` on the sweep of the thesis, on a rough surface, on a dense one and on a
height map. With --save the rows go to reference_output/bench/accuracy_costs.csv, and what to type
for an error as a table into docs/how-to/accuracy.md. test_reference_tables.py compares both.
"""

import argparse
import csv
import io
import subprocess
import tempfile
from pathlib import Path

import whole_runs
from builds import build
from csv_rows import records
from whole_runs import ROOT, heading

KEPT = whole_runs.KEPT / "accuracy_costs.csv"
PAGE = ROOT / "docs/how-to/accuracy.md"
BEGIN, END = "<!-- costs: made by make bench PART=accuracy -->", "<!-- end of what was made -->"
MATERIAL = "&material elastic_modulus = 2*275760., poisson_ratio = 2*0.42 /\n"
SUMMITS = ("&surfaces number = {}, length = {}, width = {} /\n"
           "&heights mean = 0.127, deviation = {}, lowest = 0.01 /\n&radii mean = 1.27 /\n")
SURFACES = {"rough": (10000, 19.6, 19.6, 0.03), "dense": (100, 2.0, 2.0, 0.005)}
SCENES = {
    "thesis, 100 positions": f"&surfaces deck = '{ROOT}/data/thesis.deck' /\n"
                             "&motion x_first = 0.1, x_step = 0.1, positions = 100 /\n",
    "rough, 10,000 summits": "&surfaces upper = 'plane', lower = 'rough.csv' /\n" + MATERIAL +
                             "&loading control = 'load', value = 1e5 /\n",
    "dense, 100 summits": "&surfaces upper = 'plane', lower = 'dense.csv' /\n" + MATERIAL +
                          "&loading control = 'load', value = 3000. /\n",
    "map, 128 x 96 pixels": f"&surfaces upper = 'plane', map_unit = 'um', lower = "
                            f"'{ROOT}/data/examples/summits/smooth.sdf' /\n"
                            "&material contact_modulus = 1e5 /\n"
                            "&loading control = 'pressure', value = 200 /\n"}
# What `asperity accuracy` calls a method, and the options of a scene.
OPTIONS = {"isolated": "`interaction = 'off'`", "coupled": "`'coupled'`",
           "auto; tolerance 0.01": "`'auto', tolerance = 0.01`",
           "auto; tolerance 0.001": "`'auto', tolerance = 0.001`",
           "boundary elements; 0.01": "`'boundary', boundary_tolerance = 0.01`",
           "boundary elements; 0.001": "`'boundary', area_tolerance = 0.001`",
           "pixels; every fourth": "`'boundary'`, every fourth pixel",
           "pixels; every second": "`'boundary'`, every second pixel",
           "pixels of the map": "`'boundary'`, on the pixels",
           "pixels half as wide": "`'boundary'`, pixels half as wide"}
# Kinds of surfaces: name, and their scenes.
KINDS = {"asperities": list(SCENES)[:3], "a map": list(SCENES)[3:]}


def measured(asperity, seconds):
    """Scene, option, seconds, error of the load and of the area of each method that was run."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for surface, numbers in SURFACES.items():
            (folder / "a.spec").write_text(SUMMITS.format(*numbers), encoding="ascii")
            subprocess.run([asperity, "generate", "a.spec", "--upper", f"{surface}.csv", "--lower",
                            "lower.csv"], cwd=folder, check=True)
        for scene, text in SCENES.items():
            (folder / "a.scene").write_text(text, encoding="ascii")
            subprocess.run([asperity, "accuracy", "a.scene", "--seconds", str(seconds), "--finer",
                            "--csv", "a.out"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
            rows = records(folder / "a.out")
            # No error is known to be less than that of the reference.
            best = next(row for row in rows if row["reference"] == "1")
            least = [float(best[name] or 0) for name in ("error_estimate", "area_error_estimate")]
            for row in rows:
                option = next((text for start, text in OPTIONS.items()
                               if start in row["method"]), "")
                if row["family"] == "neighbours" and option and row["seconds"]:
                    yield (scene, option, f"{float(row['seconds']):.2g}",
                           *(f"{max(float(row[name]), floor):.1g}" for name, floor in zip(
                               ("error_max", "area_error_max"), least)))


def rows_of(text):
    """The kept rows without the first line."""
    return list(csv.DictReader(io.StringIO(text.partition("\n")[2])))


def advice(text):
    """The table of what to type: each option with its largest errors over the scenes of a kind, and
    its time over that of the fastest option with interaction. Fast ones come first."""
    cells = {(row["option"], row["scene"]): [float(row[name]) for name in (
        "seconds", "error", "area_error")] for row in rows_of(text) if row["seconds"]}
    yield "| surface | `interaction =` | error of the load | of the area | time |"
    yield "|---|---|---:|---:|---:|"
    for kind, scenes in KINDS.items():
        options = [option for option in OPTIONS.values()
                   if all((option, scene) in cells for scene in scenes)]
        unit = [min(cells[option, scene][0] for option in options if "'off'" not in option)
                for scene in scenes]
        found = []
        for option in options:
            values = [cells[option, scene] for scene in scenes]
            times = [value[0] / one for value, one in zip(values, unit)]
            worst = [max(value[k] for value in values) for k in (1, 2)]
            found.append((sum(times), option, worst, times))
        for _, option, worst, times in sorted(found):
            span = " to ".join(dict.fromkeys(f"{float(f'{time:.1g}'):g}"
                                             for time in (min(times), max(times))))
            yield f"| {kind} | {option} | {worst[0]:.1g} | {worst[1]:.1g} | {span} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--save", action="store_true")
    words = parser.parse_args()
    rows = [",".join(f'"{cell}"' for cell in row) for row in measured(build("release"),
                                                                     words.seconds)]
    text = "\n".join([f"{heading()}accuracy_costs.py --seconds {words.seconds:g}",
                      "scene,option,seconds,error,area_error", *rows, ""])
    print("\n".join(advice(text)))
    if words.save:
        KEPT.write_text(text, encoding="ascii")
        before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
        PAGE.write_text("\n".join([f"{before}{BEGIN}\n", *advice(text), f"\n{END}"]) +
                        rest.partition(END)[2], encoding="utf-8")


if __name__ == "__main__":
    main()
