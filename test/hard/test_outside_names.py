"""One file under two names: an output that is the input, another output, or a link.

No input is written over, and no run writes one file twice.
"""

import os
import shutil
import subprocess

import pytest

from programs import run_program

from outside_runs import DECK, OUTPUTS, ROOT, files, is_whole, one_line_of_two


@pytest.fixture
def aliases(tmp_path):
    """Spellings of one file's path."""
    def make(name):
        (tmp_path / "sub").mkdir(exist_ok=True)
        (tmp_path / "link").symlink_to(name)
        (tmp_path / "here").symlink_to(".")
        return [name, f"./{name}", f".//{name}", f"sub/../{name}", str(tmp_path / name), "link",
                f"here/{name}", f"/proc/self/cwd/{name}"]

    return make


def test_output_is_the_input(run, aliases, tmp_path):
    for number, alias in enumerate(aliases("t.deck")):
        for command, options in ([], ("--contacts", "--positions")), \
                (["solve"], ("--contacts", "--positions", "--curve")), (["accuracy"], ("--csv",)):
            for option in options:
                for words in (["t.deck", option, alias], [alias, option, "t.deck"])[:1 + number]:
                    done = run(*command, *words)
                    assert done.returncode == 2 and done.stdout == b"", words
                    assert one_line_of_two(done) == f"{option} names the input, {words[0]}"
                    assert (tmp_path / "t.deck").read_bytes() == DECK.read_bytes()


def test_output_is_a_file_of_the_scene(run, tmp_path):
    for path in (ROOT / "data/examples").glob("*"):
        if path.is_file():
            shutil.copy(path, tmp_path)
    (tmp_path / "d.scene").write_text("&surfaces deck = 't.deck' /\n", encoding="ascii")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    for scene, name in (("csv_surfaces.scene", "upper.csv"), ("csv_surfaces.scene", "lower.csv"),
                        ("d.scene", "t.deck"), ("csv_surfaces.scene", "./csv_surfaces.scene")):
        for option in ("--contacts", "--positions", "--curve"):
            done = run("solve", scene, option, name)
            assert done.returncode == 2 and done.stdout == b""
            assert f"{option} names the input" in done.stderr.decode()
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_hard_link_to_the_input(run, tmp_path):
    """Writing by rename takes the link's name and leaves the input as it is."""
    os.link(tmp_path / "t.deck", tmp_path / "hard")
    assert run("t.deck", "--tables", "none", "--positions", "hard").returncode == 0
    assert (tmp_path / "t.deck").read_bytes() == DECK.read_bytes()
    assert is_whole(tmp_path / "hard")


def test_same_output_twice(run, aliases, tmp_path):
    for exists in (False, True):
        for alias in aliases("p.csv") if not exists else ["p.csv", "./p.csv", "link", "here/p.csv"]:
            if exists:
                (tmp_path / "p.csv").write_text("kept\n", encoding="ascii")
            done = run("t.deck", "--contacts", "p.csv", "--positions", alias)
            assert done.returncode == 2, alias
            assert one_line_of_two(done) == "--contacts and --positions both name p.csv"


def test_output_is_the_file_of_standard_output(run, tmp_path):
    for alias in ("report", "./report"):
        with open(tmp_path / "report", "wb") as report:
            done = run("t.deck", "--positions", alias, stdout=report, capture_output=False,
                       stderr=subprocess.PIPE)
        assert done.returncode == 2
        assert one_line_of_two(done) == ("--positions names the file that standard output goes to, "
                                         + alias)


def test_link_stays_a_link(run, tmp_path):
    (tmp_path / "real.csv").write_text("old\n", encoding="ascii")
    (tmp_path / "link.csv").symlink_to("real.csv")
    assert run("t.deck", "--tables", "none", "--positions", "link.csv").returncode == 0
    assert (tmp_path / "link.csv").is_symlink() and is_whole(tmp_path / "real.csv")


def test_bad_input_changes_no_output(run, tmp_path):
    (tmp_path / "p.csv").write_text("kept\n", encoding="ascii")
    (tmp_path / "bad.deck").write_bytes(DECK.read_bytes().replace(b"3.228", b"3.2x8"))
    done = run("bad.deck", *OUTPUTS)
    assert done.returncode == 2 and done.stdout == b""
    assert (tmp_path / "p.csv").read_text(encoding="ascii") == "kept\n"
    assert files(tmp_path) == ["bad.deck", "p.csv"]


def test_link_in_the_place_of_an_unfinished_file(asperity, root, tmp_path):
    """The name of an unfinished file does not follow from the process, and its file is new."""
    (tmp_path / "other").write_text("precious")
    script = """for k in 0 1 2 3; do ln -s other .asperity.$$.$k.part; done
umask 027; exec "$0" solve "$1" --quiet --positions o.csv"""
    run_program("bash", "-c", script, asperity, root / "data/examples/one_pair.scene", cwd=tmp_path)
    assert (tmp_path / "other").read_text() == "precious"
    assert not (tmp_path / "o.csv").is_symlink()
    assert (tmp_path / "o.csv").stat().st_mode & 0o777 == 0o640
