"""Threads, progress and interruption of `asperity solve`.

What a run writes is the same for any number of threads: files, summary, and the failure it reports.
"""

import os
import pty
import re
import select
import signal
import subprocess
import time

import numpy as np
import pytest

import made_maps
from programs import run_program
from surfaces_csv import write_csv_scene, write_scene
from test_kept_positions import OUTPUTS, rough


def outcome(asperity, scene, threads, folder):
    """Everything a run leaves: status, both streams, files by name."""
    folder.mkdir()
    words = [word for name in OUTPUTS for word in (f"--{name}", folder / f"{name}.csv")]
    done = run_program(asperity, "solve", scene, "--threads", threads, *words, status=None,
                       text=False)
    return (done.returncode, done.stdout, done.stderr,
            {path.name: path.read_bytes() for path in sorted(folder.iterdir())})


def compare_threads(asperity, scene, folder):
    one = outcome(asperity, scene, 1, folder / "1")
    for threads in (2, 3):
        assert outcome(asperity, scene, threads, folder / str(threads)) == one
    return one


def test_a_large_sweep_does_not_depend_on_threads(asperity, tmp_path):
    rng = np.random.default_rng(2000)
    scene = write_csv_scene(
        tmp_path, rough(rng, 2000), rough(rng, 2000), modulus=(275760.0, 275760.0),
        ratio=(0.42, 0.42), motion={"positions": 40, "x_step": 0.05, "y_step": -0.01},
        loading={"control": "limit", "points": 2}, limit={"criterion": "load", "value": 288.89})
    one = [subprocess.run([asperity, "solve", scene, "--threads", t,
                           "--curve", "/dev/stdout", "--quiet"], capture_output=True, timeout=60)
           for t in "123"]
    assert [run.returncode for run in one] == [0, 0, 0]
    assert one[0].stdout.count(b"\n") > 100
    assert one[0].stdout == one[1].stdout == one[2].stdout


@pytest.mark.parametrize("effects", [
    {"interaction": "coupled", "plasticity": "on", "plastic_yield_stress": 8000.0},
    {"interaction": "auto", "friction": "on", "friction_coefficient": 0.1}])
def test_effects_do_not_depend_on_threads(effects, asperity, root, tmp_path):
    scene = write_scene(
        tmp_path / "effects.scene", surfaces={"deck": str(root / "data" / "thesis.deck")},
        motion={"x_first": 0.1, "x_step": 0.1, "positions": 30},
        loading={"control": "load", "value": (50.0, 400.0, 100.0) if "plasticity" in effects
                 else (50.0, 400.0)}, effects=effects)
    status, _, err, files = compare_threads(asperity, scene, tmp_path)
    assert status == 0, err
    assert files["curve.csv"].count(b"\n") >= 60


def test_a_map_does_not_depend_on_threads(asperity, tmp_path):
    """So large that threads share its transforms."""
    height = made_maps.self_affine((160, 160), 21, shortest=4)[0]
    made_maps.write_bytes(tmp_path / "map.sdf", 1e-7 * height, 1e-6, 1e-6)
    scene = write_scene(
        tmp_path / "map.scene", surfaces={"upper": "plane", "lower": str(tmp_path / "map.sdf")},
        material={"contact_modulus": 1e5}, effects={"interaction": "boundary"},
        loading={"control": "pressure", "value": 500.0})
    status, out, err, _ = compare_threads(asperity, scene, tmp_path)
    assert status == 0, err
    assert b"area fraction" in out


def test_first_failure_is_returned(asperity, tmp_path):
    """Past 1.5 no pair is left to carry the load: of all positions the first is reported."""
    rng = np.random.default_rng(5)
    upper = rough(rng, 60)
    lower = upper.copy()
    scene = write_csv_scene(
        tmp_path, upper, lower, motion={"positions": 60, "x_step": 0.7},
        loading={"control": "load", "value": 20000.0}, limit={"criterion": "load", "value": 288.0})
    status, _, err, files = compare_threads(asperity, scene, tmp_path)
    shown = re.search(rb"position (\d+): .* they carry no load|position (\d+): the load", err)
    assert status == 1 and shown and not files
    first = int(shown[1] or shown[2])
    assert 1 < first < 60
    # One position fewer, and all can be solved.
    scene.write_text(re.sub(r"positions = 60", f"positions = {first - 1}", scene.read_text()))
    assert outcome(asperity, scene, 2, tmp_path / "fewer")[0] == 0


@pytest.mark.parametrize("word", ["0", "-1", "two", "1.5", "10000", "+2"])
def test_numbers_that_are_none(asperity, root, word):
    done = run_program(asperity, "solve", root / "data" / "thesis.deck", "--threads", word,
                       status=2)
    assert "--threads: found" in done.stderr
    assert "expected a number from 1 to 9999" in done.stderr


@pytest.fixture
def endless(tmp_path):
    """A sweep that takes far longer than a test."""
    rng = np.random.default_rng(9)
    return write_csv_scene(
        tmp_path, rough(rng, 3000), rough(rng, 3000), modulus=(275760.0, 275760.0),
        motion={"positions": 200000, "x_step": 1e-5}, loading={"control": "approach", "value": 0.1},
        limit={"criterion": "load", "value": 288.0})


@pytest.mark.long
def test_progress_on_a_terminal(asperity, endless, tmp_path):
    """A line after two seconds, that goes; interrupted: files stay as they were."""
    kept = tmp_path / "p.csv"
    kept.write_text("kept\n")
    here, there = pty.openpty()
    child = subprocess.Popen([asperity, "solve", endless, "--threads", "2", "--positions", kept],
                             stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=there,
                             preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    os.close(there)
    said, until = b"", time.monotonic() + 100
    while said.count(b"left") < 2 and time.monotonic() < until:
        if select.select([here], [], [], 1)[0]:
            said += os.read(here, 4096)
    child.send_signal(signal.SIGINT)
    try:
        while more := os.read(here, 4096):
            said += more
    except OSError:
        pass  # the terminal is closed
    out, _ = child.communicate(timeout=100)
    os.close(here)
    lines = [line.strip().decode() for line in said.split(b"\r")]
    # At once: the first position may take long.
    assert lines.pop(0) == "0 of 200000 positions"
    assert re.fullmatch(r"\d+ of 200000 positions, \d+ a (second|minute), \d+ (s|min|h) left",
                        lines[0])
    assert child.returncode == -signal.SIGINT and out == b""
    assert kept.read_text() == "kept\n"
    assert not list(tmp_path.glob(".asperity*"))
