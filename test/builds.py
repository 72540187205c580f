"""Builds that tests ask for, by the names of .ci/build, which makes one at a time."""

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def build(kind):
    """The executable of a build; what stands is not built again."""
    done = subprocess.run(["bash", ".ci/build", kind], cwd=ROOT, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True)
    if done.returncode != 0:
        pytest.fail(f"the build {kind} failed:\n{(done.stdout + done.stderr)[-4000:]}")
    return Path(done.stdout.splitlines()[-1])
