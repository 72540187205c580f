"""Faults from outside: full disks, closed pipes, signals, files that vanish or are the input.

Each is a real one. Files appear whole and all together, or not at all.
"""

import os
import resource
import shutil
import signal
import subprocess
import threading
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DECK = ROOT / "data/thesis.deck"
# The report is longer than a pipe holds, so that the program waits for a reader.
LONG = ["--arithmetic", "real64", "--tables", "all"]
OUTPUTS = ["--contacts", "c.csv", "--positions", "p.csv"]


@pytest.fixture
def run(asperity, tmp_path):
    """Runs the program in the test's folder."""
    shutil.copy(DECK, tmp_path / "t.deck")

    def runner(*words, **options):
        settings = {"cwd": tmp_path, "capture_output": True, "timeout": 60,
                    "stdin": subprocess.DEVNULL, **options}
        return subprocess.run([asperity, *map(str, words)], check=False, **settings)

    return runner


@pytest.fixture
def waiting(asperity, tmp_path):
    """Starts the program, which then waits for a reader of its report."""
    started = []
    shutil.copy(DECK, tmp_path / "t.deck")

    def start(*words, cwd=tmp_path, outputs=2):
        child = subprocess.Popen([asperity, *map(str, words)], cwd=cwd, stdin=subprocess.DEVNULL,
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        started.append(child)
        wait_for(lambda: len(parts(cwd)) == outputs and is_asleep(child.pid))
        return child

    yield start
    for child in started:
        if child.poll() is None:
            child.kill()
        child.stdout.close()
        child.stderr.close()
        child.wait()


def wait_for(condition, seconds=20):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "the program did not come to the point waited for"
        time.sleep(0.005)


def is_asleep(pid):
    """Whether a process waits: the letter behind the name in its state."""
    state = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2]
    return state.split()[0] == "S"


def parts(folder):
    return [name for name in os.listdir(folder) if name.endswith(".part")]


def files(folder):
    return sorted(path.name for path in folder.iterdir() if path.name != "t.deck")


def one_line(done):
    """The error output as text: one line besides the notes on the deck."""
    text = done.stderr.decode("utf-8")
    lines = [line for line in text.splitlines() if ": note: " not in line]
    assert len(lines) == 1 and text.endswith("\n"), text
    return lines[0]


def is_whole(path):
    lines = path.read_text(encoding="ascii").splitlines()
    return len(lines) > 1 and len({line.count(",") for line in lines}) == 1


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


def test_head(run, asperity, tmp_path):
    done = subprocess.run(
        ["bash", "-c", '"$0" "$@" | head -1; echo "${PIPESTATUS[0]}"', asperity, "t.deck", *LONG],
        cwd=tmp_path, capture_output=True, timeout=60, check=False)
    assert done.stdout.splitlines()[-1] == b"1"
    assert one_line(done) == "standard output: cannot be written: Broken pipe"


@pytest.mark.parametrize("stream", ["<&-", ">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-"])
def test_closed_stream(run, asperity, tmp_path, stream):
    """A stream that is closed from the start: no file is mistaken for it."""
    (tmp_path / "p.csv").write_text("kept\n", encoding="ascii")
    done = subprocess.run(
        ["bash", "-c", f'"$0" t.deck --positions p.csv {stream}', asperity],
        cwd=tmp_path, capture_output=True, timeout=60, check=False)
    assert done.returncode == (1 if ">&-" in stream.replace("2>&-", "") else 0)
    if done.returncode == 0:
        assert is_whole(tmp_path / "p.csv")
    else:
        assert (tmp_path / "p.csv").read_text(encoding="ascii") == "kept\n"
    assert files(tmp_path) == ["p.csv"]
    assert (tmp_path / "t.deck").read_bytes() == DECK.read_bytes()


def test_pipe_that_does_not_wait(run, asperity, tmp_path):
    """A reader that is slow, at the end of a pipe that refuses instead of waiting."""
    expected = run("t.deck", *LONG).stdout
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    with subprocess.Popen([asperity, "t.deck", *LONG], cwd=tmp_path, stdout=writing,
                          stderr=subprocess.PIPE) as child:
        os.close(writing)
        time.sleep(0.2)
        with os.fdopen(reading, "rb") as pipe:
            assert pipe.read() == expected
        child.stderr.read()
        assert child.wait() == 0


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


@pytest.mark.parametrize("command", [[], ["solve"]])
def test_deck_from_a_pipe(run, command):
    """What is read once is enough: a pipe gives its text a single time."""
    expected = run(*command, "t.deck").stdout
    done = run(*command, "/dev/stdin", stdin=None, input=DECK.read_bytes())
    assert done.returncode == 0
    assert done.stdout.replace(b"/dev/stdin", b"t.deck") == expected


def test_endless_input(run):
    done = run("/dev/zero", timeout=20)
    assert done.returncode == 2
    assert one_line(done) == ("/dev/zero:1:1: cannot be read: more than 100000000 bytes, "
                              "expected a card deck")


def test_huge_input(run, tmp_path):
    with open(tmp_path / "huge.deck", "wb") as huge:
        huge.truncate(3 * 2 ** 30)
    done = run("huge.deck", timeout=20)
    assert done.returncode == 2
    assert "cannot be read: more than 1000000000 bytes" in one_line(done)


# ---------------------------------------------------------------- interruptions

@pytest.fixture(scope="module", autouse=True)
def signals_not_ignored():
    """A background job is started with signals ignored, and hands that on: not to these runs."""
    before = {number: signal.getsignal(number)
              for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)}
    for number in before:
        signal.signal(number, signal.default_int_handler if number == signal.SIGINT
                      else signal.SIG_DFL)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT])
@pytest.mark.parametrize("command", [[], ["solve"]])
def test_interrupted_while_writing(waiting, tmp_path, command, number):
    (tmp_path / "p.csv").write_text("kept\n", encoding="ascii")
    if command:
        # The summary is short; a pipe that is full holds it up instead.
        os.mkfifo(tmp_path / "pipe")
        keeper = os.open(tmp_path / "pipe", os.O_RDWR)
        words = ["solve", "t.deck", *OUTPUTS, "--curve", "pipe"]
        os.set_blocking(keeper, False)
        fill(keeper)
    else:
        words = ["t.deck", *LONG, *OUTPUTS]
    child = waiting(*words)
    child.send_signal(number)
    out, err = child.communicate(timeout=20)
    assert child.returncode == 1
    assert err.decode().splitlines()[-1] == f"interrupted by signal {number:2}, nothing kept"
    if command:
        os.close(keeper)
        (tmp_path / "pipe").unlink()
        assert out == b""
    assert files(tmp_path) == ["p.csv"]
    assert (tmp_path / "p.csv").read_text(encoding="ascii") == "kept\n"


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
        child.send_signal(signal.SIGINT)
        child.communicate(timeout=20)
    # Before its first instruction nobody guards the program.
    assert child.returncode in (0, 1, -signal.SIGINT)
    if child.returncode == 0:
        assert files(tmp_path) == ["c.csv", "p.csv"]
        assert is_whole(tmp_path / "c.csv") and is_whole(tmp_path / "p.csv")
    else:
        assert files(tmp_path) == []


def test_ignored_signal_stays_ignored(waiting, asperity, tmp_path):
    """`nohup`: the work goes on."""
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        child = waiting("t.deck", *LONG, *OUTPUTS)
    finally:
        signal.signal(signal.SIGHUP, before)
    child.send_signal(signal.SIGHUP)
    child.communicate(timeout=20)
    assert child.returncode == 0
    assert files(tmp_path) == ["c.csv", "p.csv"]


# ---------------------------------------------------------------- files that vanish

def test_folder_removed_before_the_end(waiting, tmp_path):
    (tmp_path / "away").mkdir()
    child = waiting("../t.deck", *LONG, *OUTPUTS, cwd=tmp_path / "away")
    shutil.rmtree(tmp_path / "away")
    _, err = child.communicate(timeout=20)
    assert child.returncode == 1
    assert err.decode().splitlines()[-1] == "c.csv: cannot be written: No such file or directory"
    assert files(tmp_path) == []


def test_output_becomes_a_folder(waiting, tmp_path):
    child = waiting("t.deck", *LONG, *OUTPUTS)
    (tmp_path / "c.csv").mkdir()
    _, err = child.communicate(timeout=20)
    assert child.returncode == 1
    assert err.decode().splitlines()[-1] == "c.csv: cannot be written: Is a directory"
    assert files(tmp_path) == ["c.csv"] and os.listdir(tmp_path / "c.csv") == []


def test_input_removed_while_it_is_read(asperity, tmp_path):
    """The rest of the deck never comes."""
    os.mkfifo(tmp_path / "deck")
    with subprocess.Popen([asperity, "deck", *OUTPUTS], cwd=tmp_path, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE) as child:
        with open(tmp_path / "deck", "wb") as pipe:
            pipe.write(DECK.read_bytes()[:1000])
            pipe.flush()
            (tmp_path / "deck").unlink()
        out, err = child.communicate(timeout=20)
    assert child.returncode == 2 and out == b""
    assert b"wrong count of cards" in err
    assert files(tmp_path) == []


def test_input_removed_after_it_was_read(waiting, tmp_path):
    child = waiting("t.deck", *LONG, *OUTPUTS)
    (tmp_path / "t.deck").unlink()
    child.communicate(timeout=20)
    assert child.returncode == 0
    assert files(tmp_path) == ["c.csv", "p.csv"]


@pytest.mark.parametrize("name", ["none.deck", "folder", "t.deck/x", "loop", "bare"])
@pytest.mark.parametrize("command", [[], ["solve"], ["accuracy"]])
def test_input_that_cannot_be_read(run, tmp_path, command, name):
    (tmp_path / "folder").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "bare").symlink_to("nowhere")
    done = run(*command, name)
    assert done.returncode == 2 and done.stdout == b""
    assert one_line(done).startswith(f"{name}:1:1: cannot be ")


# ---------------------------------------------------------------- one file, two uses

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


def one_line_of_two(done):
    """A bad command line ends with a hint."""
    lines = done.stderr.decode().splitlines()
    assert lines[1:] == ["Try: asperity --help"], lines
    return lines[0]


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


def test_output_is_where_standard_output_goes(run, tmp_path):
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


def test_bad_input_leaves_outputs_alone(run, tmp_path):
    (tmp_path / "p.csv").write_text("kept\n", encoding="ascii")
    (tmp_path / "bad.deck").write_bytes(DECK.read_bytes().replace(b"3.228", b"3.2x8"))
    done = run("bad.deck", *OUTPUTS)
    assert done.returncode == 2 and done.stdout == b""
    assert (tmp_path / "p.csv").read_text(encoding="ascii") == "kept\n"
    assert files(tmp_path) == ["bad.deck", "p.csv"]


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
