"""What the summary shows beside the totals, against the files of the same run."""

import csv
import re
import subprocess

import pytest
from builds import ROOT
from surfaces_csv import write_csv_scene

# One of each effect, a hold under a load and one at an approach.
SCENES = ["ten_minutes", "ten_minutes_approach", "cycle", "gelatine", "index_092"]


def summary_of(lines):
    """The block of names and values: name to the first number."""
    block = lines[next(i for i, line in enumerate(lines) if line.strip() == "value") + 1:]
    values = {}
    for line in block:
        if re.match(r"limit reached|no contact|\d+ pairs? of|Effects", line):
            break
        if line.strip():
            words = line.split()
            k = next(i for i, word in enumerate(words) if word[-1].isdigit() and i > 0)
            values[" ".join(words[:k])] = float(words[k])
    return values


def near(value):
    return pytest.approx(value, rel=1e-6, abs=1e-300)


@pytest.mark.parametrize("name", SCENES)
def test_summary_shows_what_the_files_say(asperity, tmp_path, name):
    files = {which: tmp_path / which for which in ("contacts", "positions", "curve")}
    outputs = [word for which, path in files.items() for word in (f"--{which}", path)]
    run = subprocess.run([asperity, "solve", ROOT / f"data/examples/effects/{name}.scene",
                          *outputs],
                         capture_output=True, text=True, check=True)
    rows = {which: list(csv.DictReader(path.open())) for which, path in files.items()}
    shown = summary_of(run.stdout.splitlines())
    position, last = rows["positions"][-1], rows["curve"][-1]

    load, area = float(position["load"]), float(position["area"])
    assert shown["total load"] == near(load)
    if area > 0:
        assert shown["mean pressure"] == near(load / area)
    highest = [float(row["maximum_pressure"]) for row in rows["contacts"]
               if row["step"] == position["steps"]]
    assert shown["greatest pressure"] == near(max(highest, default=0.0))

    # Each number that an effect tells of the position, where it was computed.
    told = list(position)[list(position).index("vertical_load") + 1:]
    numbers = {key: position[key] for key in told
               if position[key] and not key.startswith(("warnings", "error_estimate"))}
    compared = 0
    for key, value in numbers.items():
        if key.replace("_", " ") in shown:
            assert shown[key.replace("_", " ")] == near(float(value))
            compared += 1
    print(f"{compared} of {len(numbers)} numbers of the position")
    assert compared > 0

    begin = rows["curve"][-1]
    for row in reversed(rows["curve"]):
        begin = row
        if not float(row.get("time") or 0) > 0:
            break
    if float(last.get("time") or 0) > 0:
        lost = 1 - float(last["load"]) / float(begin["load"])
        sunk = float(begin["separation"]) - float(last["separation"])
        assert shown.get("lost while held", 0.0) == pytest.approx(lost, abs=1e-6)
        assert shown.get("sunk while held", 0.0) == near(sunk)
        assert max(abs(lost), abs(sunk)) > 1e-6


def solve_at_load(asperity, folder, effects, load):
    """Closing and area at a load, and what the summary says of them, with some effects."""
    scene = write_csv_scene(
        folder, [(0, 0, .30, 1), (.5, .1, .30, 1), (.3, .6, .299, 1)], [(0, 0, 0, 1)],
        loading={"control": "vertical_load", "value": load},
        limit={"criterion": "hardy", "yield_stress": 300.0},
        effects={**effects, "friction_coefficient": 0.3} if effects else {"tolerance": 0.01})
    text = scene.read_text()
    scene.write_text(text.replace("lower = 'pair_lower.csv'", "lower = 'plane'"))
    done = subprocess.run([asperity, "solve", scene, "--curve", folder / "curve"], cwd=folder,
                          capture_output=True, text=True, timeout=100)
    assert done.returncode == 0, done.stderr
    last = list(csv.DictReader((folder / "curve").open()))[-1]
    return float(last["compression"]), float(last["area"]), done.stdout


def test_influence_at_the_load_asked_for(asperity, tmp_path):
    """What each effect changes under the load, against runs with fewer effects under it."""
    words = {"plasticity": "on", "interaction": "coupled", "friction": "on"}
    load = 300.0
    runs = [solve_at_load(asperity, tmp_path, dict(list(words.items())[:n]), load)
            for n in range(len(words) + 1)]
    told = re.findall(r"at the load asked for: closing (.*) %, area (.*) %", runs[-1][2])
    assert len(told) == len(words)
    for before, after, percent in zip(runs, runs[1:], told):
        for k in (0, 1):
            change = 100 * (after[k] / before[k] - 1)
            # Three digits of a percentage; half a unit of the last one.
            assert float(percent[k]) == pytest.approx(change, rel=6e-3, abs=1e-4)
    assert abs(float(told[0][1])) > 1 and abs(float(told[1][0])) > 1
    assert "asked for" not in solve_at_load(asperity, tmp_path, {}, load)[2]
