"""What the summary shows beside the totals, against the files of the same run."""

import csv
import subprocess

import pytest
from builds import ROOT

# One of each effect, a hold under a load and one at an approach.
SCENES = ["ten_minutes", "ten_minutes_approach", "cycle", "gelatine", "index_092"]


def summary_of(lines):
    """The block of names and values: name to the first number."""
    block = lines[next(i for i, line in enumerate(lines) if line.strip() == "value") + 1:]
    values = {}
    for line in block:
        if line.startswith(("limit reached", "no contact", "Effects")):
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
        sunk = float(begin["approach"]) - float(last["approach"])
        assert shown.get("lost while held", 0.0) == pytest.approx(lost, abs=1e-6)
        assert shown.get("sunk while held", 0.0) == near(sunk)
        assert max(abs(lost), abs(sunk)) > 1e-6
