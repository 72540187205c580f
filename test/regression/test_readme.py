"""The README: its length, and its blocks, each run as it stands in a folder that looks like the
checkout."""

import os
import re

import pytest
from builds import ROOT
from programs import run_program
from surfaces_csv import records

README = (ROOT / "README.md").read_text(encoding="utf-8")
# Heading of each example, and its blocks: language and text.
EXAMPLES = {
    part.split("\n")[0]: re.findall(r"(?ms)^```(\w*)\n(.*?)^```$", part)
    for part in re.split(r"(?m)^### ", README.split("## Examples")[1].split("\n## ")[0])[1:]}


@pytest.fixture
def run(asperity, tmp_path):
    """Runs the commands of a block in a shell. `fpm` is a stand-in: it builds nothing and runs the
    executable under test."""
    for path in ROOT.iterdir():
        if not path.name.startswith(".") and path.name != "build":
            (tmp_path / path.name).symlink_to(path)
    words = tmp_path / "bin"
    words.mkdir()
    (words / "asperity").symlink_to(asperity)
    (words / "fpm").write_text('#!/bin/sh\n[ "$1" = run ] || exit 0\nshift 2\nexec asperity "$@"\n')
    (words / "fpm").chmod(0o755)

    def run(commands):
        return run_program("bash", "-ec", commands, cwd=tmp_path,
                           variables={"PATH": f"{words}:{os.environ['PATH']}"}).stdout
    return run


@pytest.mark.once
def test_length():
    assert len(README.split()) <= 700


@pytest.mark.once
def test_first_lines():
    """What it is, then a picture of contact patches, within twenty lines."""
    first = README.split("\n")[:20]
    assert "contact area, load, pressures and separation of rough surfaces" in " ".join(first)
    assert any(line.startswith("![Contact patches") for line in first)


def test_command_line(run, tmp_path):
    """The scene is the shipped one; the printed lines are those of the program, in order."""
    (_, scene), (_, commands) = EXAMPLES["Command line"]
    shipped = (ROOT / "data/examples/summits/press.scene").read_text()
    assert scene == shipped.split("\n", 1)[1]
    printed = run("\n".join(re.findall(r"(?m)^\$ (.*)", commands)))
    shown = [line for line in commands.splitlines() if line != "..." and line[:1] != "$"]
    places = [printed.splitlines().index(line) for line in shown]
    assert len(places) >= 4 and places == sorted(places)
    assert len(printed.splitlines()) <= 25
    loads = [float(row["load"]) for row in records(tmp_path / "curve.csv")]
    assert len(loads) > 10 and loads == sorted(loads)
    assert (tmp_path / "page.html").read_text().startswith("<!DOCTYPE html>")


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_python(package, capsys, monkeypatch):
    monkeypatch.chdir(ROOT)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    [(language, code)] = EXAMPLES["Python"]
    assert language == "python"
    exec(compile(code, "README.md", "exec"), {})
    load, unit = capsys.readouterr().out.split()
    # 200 uN/um2 on 4096 pixels of 0.25 um2, of which 20 are missing.
    assert float(load) == pytest.approx(200 * 0.25 * (4096 - 20), rel=1e-9) and unit == "uN"


def test_thesis(run):
    [(_, commands)] = EXAMPLES["Thesis"]
    assert run(commands) == ""
    assert run("asperity data/thesis.deck") == (
        ROOT / "reference_output/thesis.ibm370.txt").read_text()


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
