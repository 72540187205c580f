"""What a release is cut from agrees with itself."""

import re
import subprocess
import tomllib

import pytest
from builds import ROOT

pytestmark = pytest.mark.once


def text_of(path):
    return (ROOT / path).read_text(encoding="utf-8")


def test_one_version(asperity):
    """The same number wherever it stands, and what the program states."""
    version = tomllib.loads(text_of("fpm.toml"))["version"]
    assert re.fullmatch(r"\d+\.\d+\.\d+", version)
    assert version == tomllib.loads(text_of("python/pyproject.toml"))["project"]["version"]
    assert re.findall(r"(?m)^version: (.*)", text_of("CITATION.cff")) == [version]
    assert f"version = '{version}'" in text_of("src/foundation/version.f90")
    assert text_of("packaging/debian/changelog").startswith(f"asperity ({version}) ")
    recipe = text_of("packaging/conda/recipe.yaml")
    assert re.findall(r'(?m)^  version: "(.*)"', recipe) == [version]
    said = subprocess.run([asperity, "--version"], capture_output=True, text=True, timeout=100)
    assert said.stdout.startswith(f"asperity {version}\n")


def test_changelog_can_be_cut():
    """The newest release is this version; versions fall, each has a line. What is not released yet
    stands above it."""
    log = text_of("CHANGELOG.md")
    versions = re.findall(r"(?m)^## (.*)$", log)
    if versions[0] == "Unreleased":
        del versions[0]
    assert versions[0] == tomllib.loads(text_of("fpm.toml"))["version"]
    numbers = [tuple(map(int, version.split("."))) for version in versions]
    assert numbers == sorted(numbers, reverse=True) and len(set(numbers)) == len(numbers)


def test_a_release_has_at_most_twelve_changes():
    """What is not released yet may have more."""
    for release in re.split(r"(?m)^## (?=\d)", text_of("CHANGELOG.md"))[1:]:
        assert 1 <= len(re.findall(r"(?m)^- ", release)) <= 12, release.split()[0]
