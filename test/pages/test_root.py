"""Files of the repository: at its root only what is listed here, nowhere a file that a compiler or
an unfinished run has left."""

import os
import re
import subprocess
import sys
from pathlib import PurePosixPath

import pytest
from builds import ROOT

pytestmark = pytest.mark.once

IN_ROOT = set(""".ci .gitattributes .github .gitignore CHANGELOG.md CITATION.cff CONTRIBUTING.md
                 LICENSE Makefile README.md app data docs example fpm.toml include packaging python
                 reference_output src test tools""".split())
LEFT_BEHIND = {".gcno", ".gcda", ".o", ".mod", ".smod", ".part"}


def test_root_and_leftovers():
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True,
                            check=True).stdout.split("\0")
    paths = [PurePosixPath(name) for name in listed if name]
    assert {path.parts[0] for path in paths} == IN_ROOT
    assert not [path for path in paths if path.suffix in LEFT_BEHIND]


ALONE = """
import sys
sys.modules.update(dict.fromkeys(("jsonschema", "mpmath", "pandas", "sdfio", "tamaas", "xarray")))
import pytest
sys.exit(pytest.main(["-q", "-p", "no:xdist", "-p", "no:cacheprovider", *sys.argv[1:]]))
"""


def test_numpy_and_pytest_alone(asperity):
    """All tests of the printed report and of files are found without other packages. Only a test
    that needs one is skipped."""
    environment = {**os.environ, "ASPERITY_EXE": str(asperity)}
    del environment["PYTEST_CURRENT_TEST"]
    done = [subprocess.run([sys.executable, "-c", ALONE, *words], cwd=ROOT, env=environment,
                           capture_output=True, text=True, timeout=300)
            for words in (("--collect-only", "test/original", "test/files"),
                          ("test/original/test_faults.py",))]
    assert all(run.returncode == 0 for run in done), [run.stdout[-500:] for run in done]
    assert re.search(r"^\d+ tests collected", done[0].stdout, re.M)
    assert re.search(r"^\d+ passed, \d+ skipped in", done[1].stdout, re.M), done[1].stdout
