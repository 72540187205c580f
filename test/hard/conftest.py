"""The helpers of the regression tests serve here too; programs for the faults from outside."""

import shutil
import subprocess

import pytest

from outside_runs import DECK, is_asleep, parts, wait_for


@pytest.fixture
def run(asperity, tmp_path):
    """Runs the program in the test's folder."""
    shutil.copy(DECK, tmp_path / "t.deck")

    def runner(*words, **options):
        settings = {"cwd": tmp_path, "capture_output": True, "timeout": 60,
                    "stdin": subprocess.DEVNULL, **options}
        return subprocess.run([asperity, *map(str, words)], check=False, **settings)

    return runner


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
