"""The three doors of the README, each followed word for word: its blocks as they stand, in its
order, by a shell in a folder that looks like the checkout."""

import os
import re
import subprocess

import pytest
from builds import ROOT
from surfaces_csv import records

README = (ROOT / "README.md").read_text(encoding="utf-8")
DOORS = re.split(r"(?m)^### ", README.split("## Three doors")[1].split("\n## ")[0])[1:]


@pytest.fixture
def follow(asperity, tmp_path):
    """Runs every block of a door; what it prints, block by block. `fpm` is a stand-in: it builds
    nothing and runs the executable under test."""
    for path in ROOT.iterdir():
        if not path.name.startswith(".") and path.name != "build":
            (tmp_path / path.name).symlink_to(path)
    words = tmp_path / "bin"
    words.mkdir()
    (words / "asperity").symlink_to(asperity)
    (words / "fpm").write_text('#!/bin/sh\n[ "$1" = run ] || exit 0\nshift 2\nexec asperity "$@"\n')
    (words / "fpm").chmod(0o755)

    def run(door):
        printed = []
        for block in re.findall(r"(?s)```\n(.*?)```", door):
            name = re.search(r"\(`([\w.]+)`\):\n\n```\n" + re.escape(block), door)
            if name:
                (tmp_path / name[1]).write_text(block)
                continue
            done = subprocess.run(["bash", "-ec", block], cwd=tmp_path, stdin=subprocess.DEVNULL,
                                  env={**os.environ, "PATH": f"{words}:{os.environ['PATH']}"},
                                  capture_output=True, text=True, timeout=200)
            assert done.returncode == 0, done.stdout + done.stderr
            printed.append(done.stdout)
        return printed
    return run


def test_doors_are_three():
    assert [door.split("\n")[0] for door in DOORS] == [
        "The report of the thesis", "Two surfaces of your own", "A measured map"]
    for door in DOORS:
        assert len([line for line in door.splitlines()[1:] if line.strip()]) <= 20


def test_the_report(follow):
    report, difference = follow(DOORS[0])
    assert report == (ROOT / "reference_output/thesis.ibm370.txt").read_text()
    assert difference == ""


def test_two_surfaces(follow, tmp_path):
    [summary] = follow(DOORS[1])
    for promised in ("total load             40.00000", "contact area", "mean pressure",
                     "separation of the reference planes"):
        assert promised in summary
    contacts = records(tmp_path / "contacts.csv")
    assert abs(sum(float(row["load"]) for row in contacts) - 40) < 4e-5
    assert "interaction  auto, tolerance 1.00 %" in summary


def test_a_map(follow, tmp_path):
    [printed] = follow(DOORS[2])
    assert re.search(r"(?m)^summits +\d", printed)
    assert (tmp_path / "map.svg").read_text().startswith("<svg ")
    assert "Summits against the map itself" in printed and "interaction  coupled" in printed
    loads = [float(row["load"]) for row in records(tmp_path / "curve.csv")]
    assert len(loads) > 10 and loads == sorted(loads)


@pytest.mark.once
def test_gallery_has_every_example():
    """Each scene and specification of the examples, and a picture below each heading."""
    page = (ROOT / "docs/gallery.md").read_text(encoding="utf-8")
    for path in sorted((ROOT / "data/examples").rglob("*.s[cp]e[nc]*")):
        assert f"`{path.relative_to(ROOT)}`" in page or f"`{path.name}`" in page, path
    pictures = re.findall(r"!\[[^]]+\]\((figures/[\w.-]+\.svg)\)", page)
    assert len(pictures) == len(set(pictures)) >= 12
    for picture in pictures:
        assert (ROOT / "docs" / picture).exists()
