"""What the tests of faults from outside share: the deck, the outputs, and what a run left."""

import os
import re
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DECK = ROOT / "data/thesis.deck"
# The report is longer than a pipe holds, so that the program waits for a reader.
LONG = ["--arithmetic", "real64", "--tables", "all"]
OUTPUTS = ["--contacts", "c.csv", "--positions", "p.csv"]


def wait_for(condition, seconds=100):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "the program did not come to the point waited for"
        time.sleep(0.005)


def is_asleep(pid):
    """Whether a process waits: the letter behind the name in its state."""
    state = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2]
    return state.split()[0] == "S"


def parts(folder):
    return [name for name in os.listdir(folder) if name.endswith(".part")]


def files(folder):
    return sorted(path.name for path in folder.iterdir() if path.name != "t.deck")


def one_line(done):
    """The error output as text: one line besides the notes on the deck."""
    text = done.stderr.decode("utf-8")
    lines = [line for line in text.splitlines() if ": note: " not in line]
    assert len(lines) == 1 and text.endswith("\n"), text
    return lines[0]


def is_whole(path):
    lines = path.read_text(encoding="ascii").splitlines()
    return len(lines) > 1 and len({line.count(",") for line in lines}) == 1


def one_line_of_two(done):
    """A bad command line ends with a hint."""
    lines = done.stderr.decode().splitlines()
    assert re.fullmatch(r"Try: asperity( \w+)? --help", "\n".join(lines[1:])), lines
    return lines[0]
