"""`--cost` tells time and memory beforehand, writes nothing, and its memory is what a run takes."""

import re
import resource
import subprocess
import sys

import numpy as np
import pytest

import made_maps
from effect_runs import DECK
from programs import run_program
from surfaces_csv import write_scene

pytestmark = pytest.mark.long

# Its own process, as what the tests hold would count as the program's.
MEASURE = """
import os, subprocess, sys
_, status, usage = os.wait4(subprocess.Popen(sys.argv[1:]).pid, 0)
print(status, usage.ru_maxrss * 1024)
"""
# Predicted over measured; what is told is rounded up to a megabyte.
LEAST, MOST = 0.5, 2.0


def told(asperity, folder, *words):
    """The lines of `--cost`: pieces, of them tried, bytes. No file appears."""
    before = sorted(path.name for path in folder.iterdir())
    done = run_program(asperity, *words, "--cost", cwd=folder)
    assert sorted(path.name for path in folder.iterdir()) == before
    found = re.fullmatch(r"work: (\d+) .*, tried (\d+) in \d+\.\d+ s\n"
                         r"time: (?:about|at most) \d+ (?:s|min|h) .*\nmemory: about (\d+) MB\n"
                         r"(?:solves: .*\n)?",
                         done.stdout)
    assert found, done.stdout
    total, tried, megabytes = map(int, found.groups())
    assert 1 <= tried <= total
    return total, tried, megabytes * 1e6


def taken(asperity, folder, *words):
    """The most memory that a run holds, bytes."""
    done = run_program(sys.executable, "-c", MEASURE, asperity, *words, status=None, cwd=folder)
    status, most = map(int, done.stdout.split()[-2:])
    assert status == 0, done.stderr
    return most


def check_memory(asperity, folder, *words):
    """Told against taken; gives how many pieces there are, and how many were tried."""
    total, tried, expected = told(asperity, folder, *words)
    measured = taken(asperity, folder, *words)
    assert measured > 25e6
    assert LEAST < expected / measured < MOST, (expected, measured)
    return total, tried


@pytest.mark.once
@pytest.mark.parametrize("positions, outputs", [
    (20000, ("--contacts", "c.csv", "--curve", "k.csv")), (50000, ("--positions", "p.csv"))])
def test_memory_of_a_sweep(positions, outputs, asperity, tmp_path):
    scene = write_scene(tmp_path / "sweep.scene", surfaces={"deck": str(DECK)},
                        motion={"x_first": 0.1, "x_step": 10.0 / positions, "positions": positions})
    words = ("solve", scene.name, "--quiet", "--threads", "1", *outputs)
    assert check_memory(asperity, tmp_path, *words) == (positions, 3)


LARGE = """&surfaces number = {number}, length = 2000., width = 2000. /
&heights mean = 0.127, deviation = 0.03048 /
&radii mean = 1.27 /
&random seed = {seed}, ensemble = {ensemble} /
"""


@pytest.mark.once
def test_memory_of_an_ensemble(asperity, root, tmp_path):
    (tmp_path / "g.spec").write_text(LARGE.format(number=400000, seed=14, ensemble=3))
    assert check_memory(asperity, tmp_path, "generate", "g.spec", "--output", "x%.csv") == (3, 3)
    text = (root / "data/examples/study/thesis.spec").read_text()
    for old, new in (("= 120.", "= 500."), ("ensemble = 50", "ensemble = 4"), ("= 112., ", "= "),
                     ("sections = 200", "sections = 20")):
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "s.spec").write_text(text)
    words = ("study", "s.spec", "--quiet", "--csv", "s.csv")
    assert check_memory(asperity, tmp_path, *words) == (4, 3)


@pytest.mark.once
def test_what_is_done_once_is_not_multiplied(asperity, root, tmp_path):
    """The integrals of a study took ten times what three small surfaces do, and were counted with
    them: 5000 were told to take 20 times too long. Processor times, of which the least counts."""
    text = (root / "data/examples/study/thesis.spec").read_text()
    for old, new in (("= 120.", "= 20."), ("ensemble = 50", "ensemble = 5000"),
                     ("= 112., 70., 44., 28., 17.6, ", "= "), ("sections = 200", "sections = 2")):
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "s.spec").write_text(text)
    words, times = [asperity, "study", "s.spec", "--quiet"], []
    for _ in range(2):
        said = run_program(*words, "--cost", cwd=tmp_path)
        seconds = int(re.search(r"time: about (\d+) s of one core", said.stdout)[1])
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        run_program(*words, cwd=tmp_path)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(seconds / (after.ru_utime - before.ru_utime))
    assert min(times) < 5


@pytest.mark.once
def test_memory_of_the_ways_of_computing(asperity, tmp_path):
    for seed, name in enumerate(("upper.csv", "lower.csv")):
        (tmp_path / "g.spec").write_text(LARGE.format(number=60000, seed=seed, ensemble=1))
        with open(tmp_path / name, "wb") as out:
            subprocess.run([asperity, "generate", "g.spec", "--surface", "1"], cwd=tmp_path,
                           stdout=out, check=True)
    write_scene(tmp_path / "a.scene", surfaces={"upper": "upper.csv", "lower": "lower.csv"},
                material={"elastic_modulus": (2e5, 2e5), "poisson_ratio": (0.3, 0.3)},
                limit={"criterion": "load", "value": 10.0})
    _, tried = check_memory(asperity, tmp_path, "accuracy", "a.scene", "--seconds", "3")
    assert tried > 1


@pytest.mark.once
def test_memory_of_a_map(asperity, tmp_path):
    rng = np.random.default_rng(14)
    made_maps.write_bytes(tmp_path / "map.sdf", rng.normal(size=(1500, 2000)))
    assert check_memory(asperity, tmp_path, "summits", "map.sdf", "--quiet") == (1500, 64)


def test_every_command_tells_its_cost(asperity, root, tmp_path):
    examples = root / "data/examples"
    for words in (("generate", examples / "generate/thesis.spec", "--output", "x%.deck"),
                  ("study", examples / "study/thesis.spec", "--csv", "s.csv", "--keep", "kept"),
                  ("accuracy", DECK, "--csv", "a.csv"),
                  ("solve", DECK, "--keep", "kept", "--contacts", "c.csv", "--json", "j.json"),
                  ("solve", examples / "effects/beyond_limit.scene", "--curve", "c.csv")):
        told(asperity, tmp_path, *words)


def test_cost_and_budget_exclude_each_other(asperity, tmp_path):
    done = run_program(asperity, "solve", DECK, "--budget", "--cost", status=2, cwd=tmp_path)
    assert "--cost does not estimate --budget" in done.stderr
