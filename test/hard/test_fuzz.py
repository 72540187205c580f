"""The fuzzer's runs with fixed seeds, and every fault that it found so far."""

import json
import re
import sys
from pathlib import Path

import fuzz_checks
import pytest
from fuzz_cases import Case
from programs import run_program

ROOT = Path(__file__).resolve().parents[2]
FOUND = sorted((ROOT / "data/hard/found").glob("*/case.json"))
# Parts that can run side by side, each of so many seeds.
PARTS, RUNS = 8, 300
# Scenes of so many elements that these four take as long as all others in builds that are slow.
LONG = (19, 965, 1974, 2435)


def test_found_cases_are_there():
    assert len(FOUND) >= 18


def marked(path):
    """A case of the list; one with a fault that is open is expected to fail."""
    fault = json.loads(path.read_text(encoding="ascii")).get("open")
    marks = [pytest.mark.xfail(reason=fault, strict=True)] if fault else []
    return pytest.param(path, id=path.parent.name, marks=marks)


@pytest.mark.parametrize("path", [marked(path) for path in FOUND])
def test_found_case(path, asperity):
    expected = json.loads(path.read_text(encoding="ascii"))
    files = {name.name: name.read_bytes() for name in path.parent.iterdir() if name != path}
    case = Case({"deck": b"", "s.scene": b"", **files}, expected["arguments"])
    status, messages, wrong = fuzz_checks.run_and_check(asperity, case)
    assert not wrong
    assert status == expected["status"], messages
    said = [line for line in messages.decode("utf-8").splitlines(True) if ": note: " not in line]
    assert re.search(expected["message"], "".join(said)), messages


def fuzz(asperity, folder, *words):
    """Runs of the fuzzer in a process of its own, whose limits they inherit: number by status."""
    done = run_program(sys.executable, ROOT / "tools/fuzz.py", "--exe", asperity, "--processes",
                       "1", "--seconds", "inf", *words, cwd=folder, timeout=1500)
    return {int(status): int(number) for number, status in
            re.findall(r"(\d+) with status (-?\d+)", done.stdout.splitlines()[-1])}


@pytest.mark.trouble
@pytest.mark.fuzz
@pytest.mark.parametrize("part", range(PARTS))
def test_fuzz(part, asperity, tmp_path):
    seeds = range(part * RUNS, (part + 1) * RUNS)
    left_out = [seed for seed in LONG if seed in seeds]
    ended = fuzz(asperity, tmp_path, "--seed", seeds[0], "--runs", RUNS, "--without", *left_out)
    # The cases must reach what they are meant for: good runs, failures and bad input.
    assert sum(ended.values()) == RUNS - len(left_out)
    assert all(ended.get(status, 0) > RUNS // 50 for status in (0, 1, 2)), ended


@pytest.mark.once
@pytest.mark.fuzz
def test_fuzz_with_little(asperity, tmp_path):
    """The same with little memory: a message, and no part of a file."""
    ended = fuzz(asperity, tmp_path, "--seed", 4000, "--runs", 300, "--tight")
    assert sum(ended.values()) == 300 and ended[1] > 50


@pytest.mark.long
@pytest.mark.parametrize("seed", LONG)
def test_fuzz_on_many_elements(seed, asperity, tmp_path):
    assert sum(fuzz(asperity, tmp_path, "--seed", seed, "--runs", 1).values()) == 1
