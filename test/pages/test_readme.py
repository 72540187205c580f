"""The README: its length, and its blocks, each run as it stands in a folder that looks like the
checkout."""

import os
import re

import pytest
from builds import ROOT
from image_data import read_vti
from programs import run_program
from surfaces_csv import records

pytestmark = pytest.mark.pages

README = (ROOT / "README.md").read_text(encoding="utf-8")
# Heading of each example, and its blocks: language and text.
EXAMPLES = {
    part.split("\n")[0]: re.findall(r"(?ms)^```(\w*)\n(.*?)^```$", part)
    for part in re.split(r"(?m)^### ", README.split("## Examples")[1].split("\n## ")[0])[1:]}


@pytest.fixture
def run(asperity, checkout):
    """Runs the commands of a block in a shell. `fpm` is a stand-in: it builds nothing and runs the
    executable under test."""
    words = checkout / ".venv/bin"
    words.mkdir(parents=True)
    (words / "asperity").symlink_to(asperity)
    (words / "fpm").write_text('#!/bin/sh\n[ "$1" = run ] || exit 0\nshift 2\nexec asperity "$@"\n')
    (words / "fpm").chmod(0o755)

    def run(commands):
        return run_program("bash", "-ec", commands, cwd=checkout,
                           variables={"PATH": f"{words}:{os.environ['PATH']}"}).stdout
    return run


@pytest.mark.once
def test_length():
    assert len(README.split()) <= 740


def lines_shown(block):
    return [line for line in block.splitlines() if line != "..." and line[:1] != "$"]


def test_command_line(run, tmp_path):
    """The scene is the one of the picture; the printed lines are those of the program, in order."""
    (_, scene), (_, commands) = EXAMPLES["Command line"]
    assert scene == (ROOT / "docs/figures/scenes/surface.scene").read_text()
    (tmp_path / "surface.scene").write_text(scene)
    printed = run("\n".join(re.findall(r"(?m)^\$ (.*)", commands))).splitlines()
    shown = lines_shown(commands)
    places = [printed.index(line) for line in shown]
    assert len(places) >= 4 and places == sorted(places)
    # No line between the totals and the error is left out that has a warning.
    assert not any("warning" in line for line in printed) and len(printed) <= 25
    loads = [float(row["load"]) for row in records(tmp_path / "curve.csv")]
    assert len(loads) > 10 and loads == sorted(loads)
    _, _, fields = read_vti(tmp_path / "pressure.vti")
    greatest = next(line for line in printed if line.startswith("greatest pressure"))
    assert f"{fields['pressure'].max():.6g}" == greatest.split()[3]


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_python(package, capsys, monkeypatch):
    """The block prints the lines below it, which are those of the command line."""
    monkeypatch.chdir(ROOT)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    (language, code), (_, output) = EXAMPLES["Python"]
    assert language == "python" and sum(map(bool, code.splitlines())) <= 9
    exec(compile(code, "README.md", "exec"), {})
    printed = capsys.readouterr().out.splitlines()
    shown = lines_shown(output)
    places = [printed.index(line) for line in shown]
    assert len(places) >= 6 and places == sorted(places)
    assert set(lines_shown(EXAMPLES["Command line"][1][1])) <= set(printed)


@pytest.mark.once
def test_gallery_has_every_example():
    """Each scene and specification of the examples, and a picture below each heading."""
    page = (ROOT / "docs/tutorial/gallery.md").read_text(encoding="utf-8")
    for path in sorted((ROOT / "data/examples").rglob("*.s[cp]e[nc]*")):
        assert f"`{path.relative_to(ROOT)}`" in page or f"`{path.name}`" in page, path
    pictures = re.findall(r"!\[[^]]+\]\(\.\./(figures/[\w.-]+\.svg)\)", page)
    assert len(pictures) == len(set(pictures)) >= 12
    for picture in pictures:
        assert (ROOT / "docs" / picture).exists()
