"""The helpers of the regression tests serve here too; programs for the faults from outside."""

import shutil
import subprocess
from functools import partial

import pytest

from outside_runs import DECK, is_asleep, parts, wait_for
from programs import run_program


@pytest.fixture
def run(asperity, tmp_path):
    """Runs the program in the test's folder."""
    shutil.copy(DECK, tmp_path / "t.deck")

    return partial(run_program, asperity, status=None, cwd=tmp_path, text=False, timeout=60)


@pytest.fixture
def waiting(asperity, tmp_path):
    """Starts the program, which then waits for a reader of its report."""
    started = []
    shutil.copy(DECK, tmp_path / "t.deck")

    def start(*words, cwd=tmp_path, outputs=2):
        child = subprocess.Popen([asperity, *map(str, words)], cwd=cwd, stdin=subprocess.DEVNULL,
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        started.append(child)
        wait_for(lambda: len(parts(cwd)) == outputs and is_asleep(child.pid))
        return child

    yield start
    for child in started:
        if child.poll() is None:
            child.kill()
        child.stdout.close()
        child.stderr.close()
        child.wait()
