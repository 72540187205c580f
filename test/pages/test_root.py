"""Files of the repository: at its root only what is listed here, nowhere a file that a compiler or
an unfinished run has left."""

import subprocess
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
