"""What `make` does about a compiler or FFTW that is not there: it installs, and prints so first, or
it prints what to install."""

import os
import shutil
import subprocess

import pytest
from builds import ROOT

pytestmark = [pytest.mark.pages, pytest.mark.once]


@pytest.fixture
def setup(tmp_path):
    """Runs `.ci/setup build` for a user, with programs in place of those of the system."""
    def setup(user, **programs):
        for name, text in {"id": f"echo {user}", **programs}.items():
            (tmp_path / name).write_text(f"#!/bin/sh\n{text}\n")
            (tmp_path / name).chmod(0o755)
        done = subprocess.run(
            ["bash", ROOT / ".ci/setup", "build"], capture_output=True, text=True,
            env={**os.environ, "FPM_FC": "no-compiler", "PATH": f"{tmp_path}:{os.environ['PATH']}"})
        return done.returncode, done.stderr.splitlines()
    return setup


def test_missing_packages_are_named(setup):
    assert setup(1000, sudo="exit 1") == (2, [
        "setup: please install: gfortran libc6-dev (sudo apt-get install gfortran libc6-dev)"])


@pytest.mark.parametrize("user, command", [(0, "apt-get"), (1000, "sudo -n apt-get")])
def test_an_installation_is_printed_first(user, command, setup):
    """The stand-in of apt-get fails with a line, which comes after the one that names it."""
    status, lines = setup(user, sudo='[ "$2" = true ] || { shift; exec "$@"; }',
                          **{"apt-get": "echo apt-get ran; exit 1"})
    assert status == 2
    assert lines[0] == f"setup: installing gfortran libc6-dev of the system, by {command}"
    assert "apt-get ran" in lines[1:]


@pytest.mark.parametrize("folder, expected", [("/opt/fftw/lib", "/opt/fftw/lib"),
                                              ("/usr/lib/x86_64-linux-gnu", "")])
def test_pkg_config_has_the_place_of_fftw(folder, expected, tmp_path):
    (tmp_path / "pkg-config").write_text(f"#!/bin/sh\necho {folder}\n")
    (tmp_path / "pkg-config").chmod(0o755)
    plain = {name: value for name, value in os.environ.items()
             if name not in ("LIBRARY_PATH", "LD_RUN_PATH")}
    done = subprocess.run(
        ["bash", "-c", '. .ci/common.sh; echo "${LIBRARY_PATH-}" "${LD_RUN_PATH-}"'], cwd=ROOT,
        capture_output=True, text=True,
        env={**plain, "PATH": f"{tmp_path}:{os.environ['PATH']}"})
    assert done.stdout.split() == [expected] * 2 if expected else done.stdout.split() == []


def test_a_machine_without_pkg_config_builds(tmp_path):
    """Scripts that stop at the first failure read the settings there, too."""
    (tmp_path / "dirname").symlink_to(shutil.which("dirname"))
    done = subprocess.run([shutil.which("bash"), "-euc", '. .ci/common.sh; echo "$kinds"'],
                          cwd=ROOT, capture_output=True, text=True, env={"PATH": str(tmp_path)})
    assert (done.returncode, done.stderr) == (0, "") and "release" in done.stdout
