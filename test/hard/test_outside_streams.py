"""Faults from outside on the way: pipes, devices, interruptions, files that vanish.

Each is a real one. Files appear whole and all together, or not at all.
"""

import os
import re
import shutil
import signal
import subprocess
import threading
import time
from pathlib import Path

import pytest

from outside_runs import DECK, LONG, OUTPUTS, files, is_whole, one_line, wait_for
from programs import run_program


# ---------------------------------------------------------------- pipes and devices

@pytest.mark.parametrize("words", [["t.deck", *LONG], ["t.deck", *LONG, *OUTPUTS]])
def test_closed_pipe(run, tmp_path, words):
    """`| head -1`: the reader takes a line and goes."""
    reading, writing = os.pipe()
    os.close(reading)
    done = run(*words, stdout=writing, capture_output=False, stderr=subprocess.PIPE)
    os.close(writing)
    assert done.returncode == 1
    assert one_line(done) == "standard output: cannot be written: Broken pipe"
    assert files(tmp_path) == []


@pytest.mark.parametrize("stream", ["<&-", ">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-"])
def test_closed_stream(run, asperity, tmp_path, stream):
    """A stream that is closed from the start: no file is mistaken for it."""
    (tmp_path / "p.csv").write_text("kept\n", encoding="ascii")
    done = run_program("bash", "-c", f'"$0" t.deck --positions p.csv {stream}', asperity,
                       status=1 if ">&-" in stream.replace("2>&-", "") else 0, cwd=tmp_path,
                       text=False)
    if done.returncode == 0:
        assert is_whole(tmp_path / "p.csv")
    else:
        assert (tmp_path / "p.csv").read_text(encoding="ascii") == "kept\n"
    assert files(tmp_path) == ["p.csv"]
    assert (tmp_path / "t.deck").read_bytes() == DECK.read_bytes()


def test_devices_stay_devices(run, tmp_path):
    done = run("t.deck", "--tables", "none", "--contacts", "/dev/null",
               "--positions", "/dev/stdout")
    assert done.returncode == 0
    assert done.stdout.startswith(b"position,x_displacement")
    assert Path("/dev/null").is_char_device()
    assert files(tmp_path) == []


def test_named_pipe_stays_one(run, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    got = []
    reader = threading.Thread(target=lambda: got.append((tmp_path / "pipe").read_bytes()))
    reader.start()
    done = run("t.deck", "--tables", "none", "--positions", "pipe")
    reader.join(20)
    assert done.returncode == 0
    assert got[0].startswith(b"position,") and got[0].count(b"\n") == 101
    assert (tmp_path / "pipe").is_fifo() and files(tmp_path) == ["pipe"]


def test_a_pipe_keeps_no_output(run, tmp_path):
    """To open one waits for the process that holds its other end."""
    os.mkfifo(tmp_path / "pipe")
    done = run("solve", "t.deck", "--keep", "pipe", timeout=100)
    assert done.returncode == 1 and done.stdout == b""
    assert one_line(done) == ("t.deck: pipe: is a pipe or a terminal, expected a file for what "
                              "is kept")
    assert (tmp_path / "pipe").is_fifo() and files(tmp_path) == ["pipe"]


@pytest.mark.parametrize("command", [[], ["solve"]])
def test_deck_from_a_pipe(run, command):
    """What is read once is enough: a pipe gives its text a single time."""
    expected = run(*command, "t.deck").stdout
    done = run(*command, "/dev/stdin", stdin=None, input=DECK.read_bytes())
    assert done.returncode == 0
    assert done.stdout.replace(b"/dev/stdin", b"t.deck") == expected


CAPS = "x,y,height,radius\n" + "".join(
    f"{i % 30},{i // 30},{0.001 * (i * 37 % 101):.3f},2\n" for i in range(300))
HEIGHTS = "".join(" ".join(f"{0.01 * ((i * j * 37 + 11 * j) % 103):.2f}" for i in range(40)) + "\n"
                  for j in range(40))


def hand_over(writing, text, by_line):
    """Writes a text at once, or slowly and line by line, and closes the pipe."""
    with os.fdopen(writing, "wb", buffering=0) as pipe:
        for part in text.splitlines(keepends=True) if by_line else [text]:
            pipe.write(part.encode())
            if by_line:
                time.sleep(0.0005)


@pytest.mark.parametrize("by_line", [False, True], ids=("block", "lines"))
@pytest.mark.parametrize("side", ["upper", "lower"])
@pytest.mark.parametrize("text", [CAPS, HEIGHTS], ids=("caps", "map"))
@pytest.mark.parametrize("source", ["pipe", "/dev/stdin", "/dev/fd/N"])
def test_surface_from_a_pipe(asperity, tmp_path, source, text, side, by_line):
    """A surface or a map through a named pipe, standard input or a substituted process is whole:
    the results are those of the file, and so is its checksum."""
    def scene(path):
        other = "lower" if side == "upper" else "upper"
        spacing = ", map_spacing = 0.01, 0.01" if text == HEIGHTS else ""
        return (f"&surfaces {side} = '{path}', {other} = 'plane'{spacing} / &material "
                "contact_modulus = 1e3 / &loading control = 'load', value = 1e-6 /\n")
    (tmp_path / "file").write_text(text)
    (tmp_path / "f.scene").write_text(scene("file"))
    words = [asperity, "solve", "f.scene", "--quiet", "--json", "f.json", "--positions", "-"]
    expected = run_program(*words, cwd=tmp_path, text=False)
    reading, writing = os.pipe()
    (tmp_path / "f.scene").write_text(scene(source.replace("N", str(reading))))
    if source == "pipe":
        os.mkfifo(tmp_path / "pipe")
        os.close(writing)
        with subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE) as child:
            # Waits for the reader.
            hand_over(os.open(tmp_path / "pipe", os.O_WRONLY), text, by_line)
            found = child.communicate(timeout=60)
            status = child.returncode
    else:
        with subprocess.Popen(words, cwd=tmp_path, stdin=reading, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, pass_fds=[reading]) as child:
            hand_over(writing, text, by_line)
            found = child.communicate(timeout=60)
            status = child.returncode
    os.close(reading)
    assert (status, found[0]) == (0, expected.stdout), found[1]
    checksums = [re.findall(r'"checksum": "(\w+)"', (tmp_path / "f.json").read_text())]
    (tmp_path / "f.scene").write_text(scene("file"))
    run_program(*words, cwd=tmp_path)
    checksums.append(re.findall(r'"checksum": "(\w+)"', (tmp_path / "f.json").read_text()))
    assert len(checksums[0]) == 2 and checksums[0][1] == checksums[1][1]


def test_deck_of_a_scene_from_a_pipe(run, tmp_path):
    (tmp_path / "d.scene").write_text("&surfaces deck = '/dev/stdin' /\n")
    done = run("solve", "d.scene", "--json", "d.json", stdin=None, input=DECK.read_bytes())
    assert done.returncode == 0
    (tmp_path / "d.scene").write_text("&surfaces deck = 't.deck' /\n")
    assert run("solve", "d.scene", "--json", "e.json").returncode == 0
    [[_, piped], [_, read]] = [re.findall(r'"checksum": "(\w+)"', (tmp_path / name).read_text())
                               for name in ("d.json", "e.json")]
    assert piped == read


def test_one_pipe_for_two_surfaces(run, tmp_path):
    """It gives its bytes once: what cannot be read whole is refused."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "again").symlink_to("pipe")
    for lower in ("pipe", "again"):
        (tmp_path / "two.scene").write_text(f"&surfaces upper = 'pipe', lower = '{lower}' /\n")
        writer = threading.Thread(target=(tmp_path / "pipe").write_text, args=[CAPS])
        writer.start()
        done = run("solve", "two.scene", timeout=100)
        writer.join(20)
        assert done.returncode == 2
        assert f"two.scene:1:27: lower: found '{lower}', the pipe of upper" in done.stderr.decode()
    (tmp_path / "two.scene").write_text("&surfaces upper = '/dev/stdin', lower = '/dev/fd/0' /\n")
    done = run("solve", "two.scene", stdin=None, input=CAPS.encode(), timeout=100)
    assert done.returncode == 2


def test_endless_input(run):
    done = run("/dev/zero", timeout=100)
    assert done.returncode == 2
    assert one_line(done) == ("/dev/zero:1:1: cannot be read: more than 100000000 bytes, "
                              "expected a card deck")


# ---------------------------------------------------------------- interruptions

@pytest.mark.parametrize("command", [[], ["solve"]])
def test_interrupted_while_writing(waiting, tmp_path, command):
    """An output appears by its rename: an older file of its name is whole until then."""
    (tmp_path / "p.csv").write_text("kept\n", encoding="ascii")
    words = ["t.deck", *LONG, *OUTPUTS]
    if command:
        # The summary is short; a pipe that is full holds it up instead.
        os.mkfifo(tmp_path / "pipe")
        keeper = os.open(tmp_path / "pipe", os.O_RDWR)
        words = ["solve", "t.deck", *OUTPUTS, "--curve", "pipe"]
        os.set_blocking(keeper, False)
        fill(keeper)
    child = waiting(*words)
    child.send_signal(signal.SIGTERM)
    child.communicate(timeout=100)
    assert child.returncode == -signal.SIGTERM
    if command:
        os.close(keeper)
        (tmp_path / "pipe").unlink()
    assert outputs(tmp_path) == ["p.csv"]
    assert (tmp_path / "p.csv").read_text(encoding="ascii") == "kept\n"


def outputs(folder):
    """The files of a run that a signal has ended: hidden parts may remain beside them."""
    return [name for name in files(folder) if not name.endswith(".part")]


@pytest.mark.long
def test_an_interrupted_sweep_continues(run, asperity, tmp_path):
    """The same command continues from what is kept, to the same bytes."""
    (tmp_path / "long.scene").write_text(
        "&surfaces deck = 't.deck' /\n&motion x_step = 1e-4, positions = 40000 /\n"
        "&tilt rotation = 2*0. /\n&effects interaction = 'off' /\n", encoding="ascii")
    words = ["solve", "long.scene", "--quiet", "--threads", "1", "--positions"]
    with subprocess.Popen([asperity, *words, "p.csv", "--keep", "kept"], cwd=tmp_path,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE) as child:
        wait_for(lambda: (tmp_path / "kept").exists()
                 and (tmp_path / "kept").stat().st_size > 10000)
        child.send_signal(signal.SIGTERM)
        child.communicate(timeout=100)
    assert child.returncode == -signal.SIGTERM
    assert 0 < (tmp_path / "kept").read_text(encoding="ascii").count("position ") < 40000
    assert files(tmp_path) == ["kept", "long.scene"]
    assert run(*words, "p.csv", "--keep", "kept").returncode == 0
    assert run(*words, "whole.csv").returncode == 0
    assert (tmp_path / "p.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()


def fill(pipe):
    try:
        while True:
            os.write(pipe, b"x" * 4096)
    except BlockingIOError:
        pass


@pytest.mark.parametrize("delay", [0.0, 0.002, 0.005, 0.01, 0.03, 0.06, 0.1, 0.2])
def test_interrupted_at_any_time(asperity, tmp_path, delay):
    shutil.copy(DECK, tmp_path / "t.deck")
    with subprocess.Popen([asperity, "t.deck", "--tables", "none", *OUTPUTS], cwd=tmp_path,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE) as child:
        time.sleep(delay)
        child.send_signal(signal.SIGTERM)
        child.communicate(timeout=100)
    assert child.returncode in (0, -signal.SIGTERM)
    assert all(is_whole(tmp_path / name) for name in outputs(tmp_path))
    if child.returncode == 0:
        assert files(tmp_path) == ["c.csv", "p.csv"]


# ---------------------------------------------------------------- files that vanish


@pytest.mark.parametrize("name", ["none.deck", "folder", "t.deck/x", "loop", "bare"])
@pytest.mark.parametrize("command", [[], ["solve"], ["accuracy"]])
def test_input_that_cannot_be_read(run, tmp_path, command, name):
    (tmp_path / "folder").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "bare").symlink_to("nowhere")
    done = run(*command, name)
    assert done.returncode == 2 and done.stdout == b""
    if not command and name in ("loop", "bare"):
        # A word that is no file could be a command.
        assert done.stderr.decode().startswith(f"found '{name}', expected solve, ")
    else:
        assert one_line(done).startswith(f"{name}:1:1: cannot be ")
