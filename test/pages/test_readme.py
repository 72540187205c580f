"""The README: its length, and its blocks, each run as it stands in a folder that looks like the
checkout."""

import os
import re

import pytest
from builds import ROOT
from cells_met import report_of
from image_data import read_vti
from programs import run_program
from side_by_side import lines_of
from surfaces_csv import records

pytestmark = pytest.mark.pages

README = (ROOT / "README.md").read_text(encoding="utf-8")
# Heading of each part, and its blocks: language and text.
PARTS = {part.split("\n")[0]: re.findall(r"(?ms)^```(\w*)\n(.*?)^```$", part)
         for part in re.split(r"(?m)^#+ ", README)[1:]}
CODE, SURFACE, ACCURACY = DOORS = (
    "I keep old code alive", "I have a surface", "I ask what accuracy costs")


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
        return run_program("bash", "-ec", f"exec 2>&1\n{commands}", cwd=checkout,
                           variables={"PATH": f"{words}:{os.environ['PATH']}"}).stdout
    return run


@pytest.mark.once
def test_length():
    assert len(README.split()) <= 600


@pytest.mark.once
def test_first_screen():
    """What it is, the two commands that need nothing before them, and the three doors."""
    first = "\n".join(README.splitlines()[:30])
    for text in ("program of 1976", "digit for digit", "the error of each result", "make report",
                 "make test", "2 minutes", "4 minutes", *DOORS):
        assert text in " ".join(first.split())
    assert [name for name in PARTS if name.startswith("I ")] == list(DOORS)
    assert README.count("pip install") == 1
    for name in re.findall(r"^make ([\w-]+)", PARTS["asperity"][0][1], re.M):
        assert re.search(rf"^{name}:", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M)


def test_old_code(asperity):
    """Lines of `make compare`, which calls this program (test_page_commands.py runs make)."""
    ((_, block),) = PARTS[CODE]
    assert block.startswith("$ make compare\n")
    in_order(lines_shown(block), list(lines_of(report_of(asperity, "ibm370"))), 6)


def lines_shown(block):
    return [line for line in block.splitlines() if line != "..." and line[:1] != "$"]


def in_order(shown, printed, least):
    """The lines of the page are printed, in their order."""
    places = [printed.index(line) for line in shown]
    assert len(places) >= least and places == sorted(places)


def test_command_line(run, tmp_path):
    """The scene is the one of the picture; the commands write the curve and the pressures."""
    (_, output), (_, commands) = PARTS[SURFACE][1:]
    printed = run("\n".join(re.findall(r"(?m)^\$ (.*)", commands))).splitlines()
    in_order(lines_shown(output), printed, 4)
    # No line between the totals and the error is left out that has a warning.
    assert not any("warning" in line for line in printed) and len(printed) <= 25
    loads = [float(row["load"]) for row in records(tmp_path / "curve.csv")]
    assert len(loads) > 10 and loads == sorted(loads)
    _, _, fields = read_vti(tmp_path / "pressure.vti")
    greatest = next(line for line in printed if line.startswith("greatest pressure"))
    assert f"{fields['pressure'].max():.6g}" == greatest.split()[3]


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_python(package, capsys, monkeypatch):
    """The block prints the lines below it."""
    monkeypatch.chdir(ROOT)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    (language, code), (_, output) = PARTS[SURFACE][:2]
    assert language == "python" and sum(map(bool, code.splitlines())) <= 9
    exec(compile(code, "README.md", "exec"), {})
    in_order(lines_shown(output), capsys.readouterr().out.splitlines(), 4)


def test_accuracy(run):
    """The command prints its line, and no warning."""
    ((_, block),) = PARTS[ACCURACY]
    printed = run("\n".join(re.findall(r"(?m)^\$ (.*)", block))).splitlines()
    in_order(lines_shown(block), printed, 1)


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
