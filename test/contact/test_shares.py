"""`--share I/N`: parts of a sweep done by themselves, joined by a run over their files,
are the whole, byte for byte."""

import re

import pytest
from programs import run_program
from test_kept_positions import OUTPUTS, SCENES, kept_records, thesis_scene


def run(asperity, folder, *words, status=0):
    return run_program(asperity, *words, status=status, cwd=folder)


def outputs(scene):
    return [word for name in OUTPUTS for word in (f"--{name}", f"{name}.csv")
            if name != "contacts" or "without a list" not in scene.name]


def files(folder):
    return {path.name: path.read_bytes() for path in folder.glob("*.csv")}


@pytest.mark.parametrize("parts", [2, pytest.param(7, marks=pytest.mark.long)])
@pytest.mark.parametrize("name", SCENES)
def test_parts_are_the_whole(name, parts, asperity, root, tmp_path):
    scene = thesis_scene(name, root, tmp_path)
    words = ["solve", scene, *outputs(scene)]
    whole, joined = tmp_path / "whole", tmp_path / "joined"
    whole.mkdir()
    joined.mkdir()
    at_once = run(asperity, whole, *words)
    expected = files(whole)
    positions = len(expected["positions.csv"].splitlines()) - 1
    keeps = []
    for part in range(1, parts + 1):
        keeps += ["--keep", f"part.{part}"]
        done = run(asperity, joined, *words, "--share", f"{part}/{parts}", *keeps[-2:])
        number = len(range(part, positions + 1, parts))
        assert done.stdout == (f"part {part} of {parts}: {number} positions are saved in "
                               f"part.{part}; the outputs come from a run with the files of all "
                               "parts\n")
        assert files(joined) == {}
    # The files in any order; what is kept is not changed.
    kept = {path.name: path.read_bytes() for path in joined.iterdir()}
    together = run(asperity, joined, *words, *keeps[4:], *keeps[:4])
    assert files(joined) == expected and expected
    assert (together.stdout, together.stderr) == (at_once.stdout, at_once.stderr)
    assert kept == {name: (joined / name).read_bytes() for name in kept}


def test_an_interrupted_part_continues(asperity, root, tmp_path):
    """A part that was ended in the middle is reported, goes on, and then the whole can be had."""
    scene = thesis_scene("curve", root, tmp_path)
    words = ["solve", scene, "--positions", "positions.csv"]
    for part in (1, 2, 3):
        run(asperity, tmp_path, *words, "--share", f"{part}/3", "--keep", f"p{part}")
    kept = (tmp_path / "p2").read_bytes()
    whole = kept_records(tmp_path / "p2")
    places = [match.start() for match in re.finditer(rb"(?m)^position ", kept)]
    assert len(places) == 13
    (tmp_path / "p2").write_bytes(kept[:places[4] + 50])
    keeps = ["--keep", "p1", "--keep", "p2", "--keep", "p3"]
    shown = run(asperity, tmp_path, *words, *keeps, status=1).stderr
    assert "p2: holds 4 of 13 positions, expected all: run it with --share 2/3 to its end" in shown
    assert not (tmp_path / "positions.csv").exists()
    run(asperity, tmp_path, *words, "--share", "2/3", "--keep", "p2")
    assert kept_records(tmp_path / "p2") == whole
    run(asperity, tmp_path, *words, *keeps)
    assert len((tmp_path / "positions.csv").read_text().splitlines()) == 41


def test_bad_shares_are_refused(asperity, root, tmp_path):
    scene = thesis_scene("curve", root, tmp_path)
    for part in (1, 2):
        run(asperity, tmp_path, "solve", scene, "--share", f"{part}/2", "--keep", f"p{part}")
    for words, answer in ((["--share", "0/2"], "expected I/N, part I of N"),
                          (["--share", "3/2"], "expected I/N, part I of N"),
                          (["--share", "half"], "--share: found 'half'"),
                          (["--share", "1/2"], "--share: expected one --keep"),
                          (["--share", "1/41", "--keep", "a"], "41 parts of 40 positions"),
                          (["--share", "1/2", "--keep", "a", "--keep", "b"], "expected one --keep"),
                          (["--keep", "p1", "--keep", "./p1"], "--keep and --keep both name"),
                          (["--keep", "p1", "--keep", "p2", "--positions", "p2"],
                           "--keep and --positions both name p2")):
        assert answer in run(asperity, tmp_path, "solve", scene, *words, status=2).stderr
    (tmp_path / "again").write_bytes((tmp_path / "p1").read_bytes())
    for words, answer in ((["p1"], "p1: holds no positions of this scene"),
                          (["p1", "again"], "again: holds part 1 of 2 once more"),
                          (["p1", "p2", "again"], "p1: holds no part of 3"),
                          (["p1", "none"], "none: "), (["p1", str(scene)], "holds no part of 2")):
        keeps = [word for path in words for word in ("--keep", path)]
        assert answer in run(asperity, tmp_path, "solve", scene, *keeps, status=1).stderr
    other = thesis_scene("thesis", root, tmp_path)
    assert "holds no part of 2 of the positions of this scene" in run(
        asperity, tmp_path, "solve", other, "--keep", "p1", "--keep", "p2", status=1).stderr
