"""Faults from outside: full disks, places that cannot be written, little memory.

Each is a real one. Files appear whole and all together, or not at all.
"""

import os
import resource
import subprocess

import pytest

from outside_runs import LONG, OUTPUTS, files, is_whole, one_line

pytestmark = pytest.mark.usefixtures("signals_not_ignored")


# ---------------------------------------------------------------- no room

def test_full_standard_output(run, tmp_path):
    with open("/dev/full", "wb") as full:
        done = run("t.deck", *LONG, *OUTPUTS, stdout=full, capture_output=False,
                   stderr=subprocess.PIPE)
    assert done.returncode == 1
    assert one_line(done) == "standard output: cannot be written: No space left on device"
    assert files(tmp_path) == []


@pytest.mark.parametrize("words", [["--help"], ["--version"], [], ["solve", "--help"]])
def test_full_standard_output_of_help(run, words):
    with open("/dev/full", "wb") as full:
        done = run(*words, stdout=full, capture_output=False, stderr=subprocess.PIPE)
    assert done.returncode == 1
    assert "No space left on device" in one_line(done)


def test_full_device_as_output(run, tmp_path):
    done = run("t.deck", *LONG, "--positions", "p.csv", "--contacts", "/dev/full")
    assert done.returncode == 1 and done.stdout == b""
    assert one_line(done) == "/dev/full: cannot be written: No space left on device"
    assert files(tmp_path) == []


@pytest.fixture
def small_disk(tmp_path):
    """A disk of 64 KB."""
    place = tmp_path / "disk"
    place.mkdir()
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", place],
                          capture_output=True, text=True, check=False)
    if done.returncode != 0:
        pytest.skip(f"no small disk without the right to mount: {done.stderr.strip()}")
    yield place
    subprocess.run(["umount", "-l", place], check=True)


def test_full_disk(run, small_disk):
    (small_disk / "p.csv").write_text("kept\n", encoding="ascii")
    done = run("t.deck", *LONG, "--positions", "disk/p.csv", "--contacts", "disk/c.csv")
    assert done.returncode == 1 and done.stdout == b""
    assert one_line(done) == "disk/c.csv: cannot be written: No space left on device"
    assert os.listdir(small_disk) == ["p.csv"]
    assert (small_disk / "p.csv").read_text(encoding="ascii") == "kept\n"


def test_read_only_disk(run, small_disk):
    (small_disk / "p.csv").write_text("kept\n", encoding="ascii")
    subprocess.run(["mount", "-o", "remount,ro", small_disk], check=True)
    for name in ("disk/p.csv", "disk/new.csv"):
        done = run("t.deck", "--tables", "none", "--positions", name)
        assert done.returncode == 1 and done.stdout == b""
        assert one_line(done) == f"{name}: cannot be written: Read-only file system"
    assert os.listdir(small_disk) == ["p.csv"]


@pytest.mark.parametrize("words", [["t.deck", *LONG], ["solve", "t.deck"]])
def test_largest_file_of_the_shell(run, tmp_path, words):
    """`ulimit -f`: the system would end the program with SIGXFSZ."""
    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))

    (tmp_path / "c.csv").write_text("kept\n", encoding="ascii")
    done = run(*words, *OUTPUTS, preexec_fn=limit)
    assert done.returncode == 1 and done.stdout == b""
    assert one_line(done) == "c.csv: cannot be written: File too large"
    assert files(tmp_path) == ["c.csv"]
    assert (tmp_path / "c.csv").read_text(encoding="ascii") == "kept\n"


# ---------------------------------------------------------------- places that cannot be written

@pytest.mark.parametrize("place, reason", [
    ("t.deck/c.csv", "Not a directory"),
    ("none/c.csv", "No such file or directory"),
    ("folder", "Is a directory"),
    (".", "Is a directory"),
    ("folder/", "Is a directory"),
    ("new.csv/", "Is a directory|Not a directory|No such file or directory"),
    ("x" * 300, "File name too long"),
    ("loop", "Too many levels of symbolic links"),
])
def test_place_that_cannot_be_written(run, tmp_path, place, reason):
    (tmp_path / "folder").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    done = run("t.deck", "--tables", "none", "--positions", "p.csv", "--contacts", place)
    assert done.returncode == 1 and done.stdout == b""
    line = one_line(done)
    assert line.startswith(f"{place}: cannot be written: ")
    assert line.split(": ")[2] in reason.split("|")
    assert files(tmp_path) == ["folder", "loop"]
    assert os.listdir(tmp_path / "folder") == []


def test_protected_file_and_folder(run, tmp_path):
    if os.geteuid() == 0:
        pytest.skip("root may write everywhere")
    (tmp_path / "p.csv").write_text("kept\n", encoding="ascii")
    (tmp_path / "p.csv").chmod(0o444)
    (tmp_path / "closed").mkdir(mode=0o555)
    for place in ("p.csv", "closed/p.csv"):
        done = run("t.deck", "--tables", "none", "--positions", place)
        assert done.returncode == 1
        assert one_line(done) == f"{place}: cannot be written: Permission denied"
    assert (tmp_path / "p.csv").read_text(encoding="ascii") == "kept\n"


@pytest.mark.parametrize("name", ["n" * 251 + ".csv", "blank at the end ", "-c.csv", "\u20ac"])
def test_name_can_be_written(run, tmp_path, name):
    assert run("t.deck", "--tables", "none", f"--positions={name}").returncode == 0
    assert files(tmp_path) == [name] and is_whole(tmp_path / name)


# ---------------------------------------------------------------- little memory

def test_little_memory(run, tmp_path):
    """No crash when memory ends: a message, or the work is done."""
    scene = tmp_path / "many.scene"
    scene.write_text("&surfaces deck = 't.deck' /\n&motion positions = 1000000 /\n",
                     encoding="ascii")

    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (60_000_000, 60_000_000))

    done = run("solve", "many.scene", *OUTPUTS, preexec_fn=limit)
    assert done.returncode == 1 and done.stdout == b""
    assert "memory" in one_line(done)
    assert files(tmp_path) == ["many.scene"]
