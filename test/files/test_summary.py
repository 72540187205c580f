"""What the summary shows beside the totals, against the files of the same run."""

import re

import pytest
from builds import ROOT
from programs import run_program
from surfaces_csv import records, write_csv_scene

# One of each effect, a hold under a load and one at an approach.
SCENES = ["ten_minutes", "ten_minutes_approach", "cycle", "gelatine", "index_092"]


# Columns of the positions and their names in the summary.
NAMES = {"hertz_load": "Hertzian load", "contacts_flowing": "yielding contacts",
         "dissipated_work": "dissipated work", "residual_flattening": "residual flattening",
         "adhering_contacts": "adhering contacts", "pulling_contacts": "contacts in tension",
         "pull_off_sum": "pull-off forces", "alone_load": "non-interacting load",
         "cells": "grid elements", "resolved": "contacts on grids", "elastic_load": "elastic load",
         "frictionless_load": "frictionless load", "sliding_contacts": "sliding contacts",
         "rig_force_x": "fixture force x", "rig_force_y": "fixture force y",
         "rig_moment_x": "fixture moment x", "rig_moment_y": "fixture moment y",
         "rig_moment_z": "fixture moment z", "compression": "compression"}


def summary_of(lines):
    """The block of names and values: name to the first number."""
    block = lines[lines.index("") + 1:]
    values = {}
    for line in block[:block.index("")]:
        name, value = re.match(r"(.*?)(?: \(.*\))? +([-+.\de]+)(?:   |$)", line).groups()
        values[name] = value
    return values


@pytest.mark.long
def test_numbers(asperity):
    """Counts are integers, all numbers have one format, and an example of a map fits a screen."""
    for path in sorted((ROOT / "data/examples").rglob("*.scene")):
        done = run_program(asperity, "solve", path)
        if "1 position" not in done.stdout.splitlines()[0]:
            continue
        shown = summary_of(done.stdout.splitlines())
        assert "approach" not in done.stdout.replace(path.name, "")
        assert shown["contacts"].isdigit()
        for value in shown.values():
            assert re.fullmatch(r"-?\d+(\.\d+)?(e-?\d+)?", value), (path, value)
            assert len(re.sub(r"e.*|\D", "", value).lstrip("0")) <= 6
    done = run_program(asperity, "solve", ROOT / "data/examples/summits/press_samples.scene")
    assert len(done.stdout.splitlines()) <= 25


def near(value):
    return pytest.approx(value, rel=5.1e-6, abs=1e-300)


@pytest.mark.parametrize("name", SCENES)
def test_summary_has_the_numbers_of_the_files(asperity, tmp_path, name):
    files = {which: tmp_path / which for which in ("contacts", "positions", "curve")}
    outputs = [word for which, path in files.items() for word in (f"--{which}", path)]
    run = run_program(asperity, "solve", ROOT / f"data/examples/effects/{name}.scene", *outputs)
    rows = {which: records(path) for which, path in files.items()}
    shown = {name: float(value) for name, value in summary_of(run.stdout.splitlines()).items()}
    position, last = rows["positions"][-1], rows["curve"][-1]

    load, area = float(position["load"]), float(position["area"])
    assert shown["total load"] == near(load)
    if area > 0:
        assert shown["mean pressure"] == near(load / area)
    highest = [float(row["maximum_pressure"]) for row in rows["contacts"]
               if row["step"] == position["steps"]]
    assert shown["greatest pressure"] == near(max(highest, default=0.0))

    # Each number that an effect reports of the position, where it was computed.
    reported = list(position)[list(position).index("vertical_load") + 1:]
    numbers = {key: position[key] for key in reported
               if position[key] and not key.startswith(("warnings", "error_estimate"))}
    compared = 0
    for key, value in numbers.items():
        name = NAMES.get(key, key.replace("_", " "))
        if name in shown:
            assert shown[name] == near(float(value)), name
            compared += 1
        else:
            assert name not in NAMES.values() or float(value) == 0, name
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
        assert shown.get("load relaxation", 0.0) == pytest.approx(lost, abs=1e-6)
        assert shown.get("creep displacement", 0.0) == near(sunk)
        assert max(abs(lost), abs(sunk)) > 1e-6


def test_mean_pressure_of_one_pixel(asperity, tmp_path):
    """The mean over the corrected area of an unresolved patch is at most its greatest pressure."""
    (tmp_path / "m.txt").write_text("0 0 0 0\n0 0 1 0\n0 0 0 0\n0 0 0 0\n")
    (tmp_path / "m.scene").write_text("""&surfaces
upper = 'plane', lower = 'm.txt', map_unit = 'um', map_spacing = 1.0, 1.0 /
&material contact_modulus = 1e5 / &loading control = 'load', value = 0.5 /""")
    run = run_program(asperity, "solve", tmp_path / "m.scene")
    shown = summary_of(run.stdout.splitlines())
    assert float(shown["mean pressure"]) == float(shown["greatest pressure"]) == 0.5


def solve_at_load(asperity, folder, effects, load):
    """Compression and area at a load, and what the summary states of them, with some effects."""
    scene = write_csv_scene(
        folder, [(0, 0, .30, 1), (.5, .1, .30, 1), (.3, .6, .299, 1)], [(0, 0, 0, 1)],
        loading={"control": "vertical_load", "value": load},
        limit={"criterion": "hardy", "yield_stress": 300.0},
        effects={**effects, "friction_coefficient": 0.3} if effects else {"tolerance": 0.01})
    text = scene.read_text()
    scene.write_text(text.replace("lower = 'pair_lower.csv'", "lower = 'plane'"))
    done = run_program(asperity, "solve", scene, "--curve", folder / "curve", cwd=folder)
    last = records(folder / "curve")[-1]
    return float(last["compression"]), float(last["area"]), done.stdout


def test_influence_at_the_requested_load(asperity, tmp_path):
    """What each effect changes under the load, against runs with fewer effects under it."""
    words = {"plasticity": "on", "interaction": "coupled", "friction": "on"}
    load = 300.0
    runs = [solve_at_load(asperity, tmp_path, dict(list(words.items())[:n]), load)
            for n in range(len(words) + 1)]
    reported = re.findall(r"at the prescribed load: compression (.*) %,\s+area (.*) %", runs[-1][2])
    assert len(reported) == len(words)
    for before, after, percent in zip(runs, runs[1:], reported):
        for k in (0, 1):
            change = 100 * (after[k] / before[k] - 1)
            # Three digits of a percentage; half a unit of the last one.
            assert float(percent[k]) == pytest.approx(change, rel=6e-3, abs=1e-4)
    assert abs(float(reported[0][1])) > 1 and abs(float(reported[1][0])) > 1
    assert "prescribed" not in solve_at_load(asperity, tmp_path, {}, load)[2]


def test_energy_lost_in_each_cycle(asperity, tmp_path):
    """The loops of load against compression enclose the energy that the summary has."""
    done = run_program(asperity, "solve", ROOT / "data/examples/effects/cycle.scene", "--curve",
                       tmp_path / "curve")
    rows = records(tmp_path / "curve")
    closing, load, work = ([float(row[name]) for row in rows]
                           for name in ("compression", "vertical_load", "dissipated_work"))
    lost = [float(word) for word in
            re.search(r"energy lost in each cycle \(N cm\): (.*)", done.stdout)[1].split(", ")]
    # Ends of the path: a load of 0 after each of the three loads.
    ends = [0] + [k for k in range(1, len(rows)) if load[k] == 0 and load[k - 1] > 0]
    assert len(ends) == 4 and len(lost) == 3
    for first, last, energy in zip(ends, ends[1:], lost):
        area = sum((load[k] + load[k + 1]) / 2 * (closing[k + 1] - closing[k])
                   for k in range(first, last))
        assert energy == pytest.approx(area, rel=0.01)
        assert energy == pytest.approx(work[last] - work[first], rel=1e-5)
    assert work == sorted(work)
