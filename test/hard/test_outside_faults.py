"""Faults from outside: full disks, places that cannot be written, little memory.

Each is a real one. Files appear whole and all together, or not at all.
"""

import os
import re
import resource
import shutil
import subprocess

import numpy as np
import pytest

from outside_runs import LONG, OUTPUTS, files, is_whole, one_line


# ---------------------------------------------------------------- no room

def test_full_standard_output(run, tmp_path):
    with open("/dev/full", "wb") as full:
        done = run("t.deck", *LONG, *OUTPUTS, stdout=full, capture_output=False,
                   stderr=subprocess.PIPE)
    assert done.returncode == 1
    assert one_line(done) == "standard output: cannot be written: No space left on device"
    assert files(tmp_path) == []


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


def test_names_that_differ_by_a_blank(run, tmp_path):
    """Fortran takes them for one."""
    done = run("t.deck", "--tables", "none", "--positions", "c.csv", "--contacts", "c.csv ")
    assert done.returncode == 0, done.stderr
    assert files(tmp_path) == ["c.csv", "c.csv "]
    shutil.copy(tmp_path / "t.deck", tmp_path / "u ")
    (tmp_path / "s ").write_text("&surfaces deck = 'u ' /\n", encoding="ascii")
    assert run("solve", "s ", "--positions", "u", "--contacts", "s").returncode == 0
    assert files(tmp_path) == ["c.csv", "c.csv ", "s", "s ", "u", "u "]
    done = run("solve", "s ", "--positions", "u ")
    assert done.returncode == 2 and b"names the input" in done.stderr
    shutil.copy(tmp_path / "t.deck", tmp_path / "solve ")
    assert run("solve ", "--tables", "none").returncode == 0


# ---------------------------------------------------------------- little memory

@pytest.mark.parametrize("room", [64, 128, 1023])
def test_small_stack(run, room):
    """Beyond its stack (`room`, kB) the system ends a program by a signal."""
    done = run("t.deck", *LONG, preexec_fn=lambda: resource.setrlimit(
        resource.RLIMIT_STACK, (1024 * room, 1024 * room)))
    assert done.returncode == 1 and done.stdout == b""
    assert one_line(done) == (f"stack: found a limit of {room} kB, expected 1024 or more "
                              "(ulimit -s)")


# Commands with the largest local arrays: records of the report, sums and searches over caps.
@pytest.mark.parametrize("words", [["t.deck", *LONG], ["solve", "coupled.scene", "--threads", "2"],
                                   ["solve", "boundary.scene", "--threads", "2"]])
def test_least_stack(run, tmp_path, words):
    number = np.arange(3000)
    np.savetxt(tmp_path / "lower.csv", np.c_[
        3.0 * (number % 50), 3.0 * (number // 50), 0.1 + 1e-7 * (number * 7919 % 5000),
        np.ones(len(number))], "%.8g", ",", header="x,y,height,radius", comments="")
    (tmp_path / "m.txt").write_text("\n".join(
        " ".join(str((i * i + 7 * j * j) % 101 / 1000) for j in range(97)) for i in range(90)))
    for name, lower in (("coupled", "lower = 'lower.csv'"),
                        ("boundary", "lower = 'm.txt', map_spacing = 2*0.5")):
        (tmp_path / f"{name}.scene").write_text(
            f"&surfaces upper = 'plane', {lower} / &material contact_modulus = 1e3 / &loading "
            f"control = 'load', value = 30. / &effects interaction = '{name}' /\n")
    done = run(*words, preexec_fn=lambda: resource.setrlimit(
        resource.RLIMIT_STACK, (2**20, 2**20)))
    assert done.returncode == 0, done.stderr



MANY = {
    "positions": "&surfaces deck = 't.deck' /\n&motion x_step = 1e-3, positions = 4000 /\n"
                 "&effects interaction = 'off' /\n",
    "states": "&surfaces deck = 't.deck' /\n&motion positions = 2 /\n"
              "&loading control = 'limit', points = 20000 /\n&effects interaction = 'off' /\n",
    "surfaces": "&surfaces upper = 'u.csv', lower = 'l.csv', radius = 2*1.27 /\n"
                "&material elastic_modulus = 2*2.8e5, poisson_ratio = 2*0.42 /\n"
                "&loading control = 'load', value = 3e4 /\n"
                "&effects friction = 'on', friction_coefficient = 0.3 /\n",
    "neighbours": "&surfaces deck = 't.deck' /\n&motion x_first = 5.6 /\n"
                  "&effects interaction = 'boundary', boundary_tolerance = 0.00005 /\n",
    "map": "&surfaces upper = 'plane', lower = 'm.txt', map_spacing = 2*0.5 /\n"
           "&material contact_modulus = 1e5 /\n&loading control = 'load', value = 1e4 /\n"
           "&effects interaction = 'boundary' /\n",
    "report": ""}
# A sentence of the program names the file or output, and states that memory has ended.
SENTENCE = re.compile(r"[^:]+: .*(not enough|no|more than .* of) memory.*")


@pytest.mark.long
@pytest.mark.parametrize("what", MANY)
def test_little_memory_at_any_time(run, tmp_path, what):
    """Wherever memory ends the status is not 0, no file is left but what was to be kept, and what
    is solved is right. What is large is refused with one sentence, status 1; where the run-time
    library meets the end first, it states so in its own words."""
    (tmp_path / "s.scene").write_text(MANY[what], encoding="ascii")
    for name, height in (("u.csv", 0.11), ("l.csv", 0.12)):
        (tmp_path / name).write_text("x,y,height\n" + "".join(
            f"{3.0 * (i % 150)},{3.0 * (i // 150)},{height + 1e-6 * (i * 7919 % 5000)}\n"
            for i in range(22500 if what == "surfaces" else 1)), encoding="ascii")
    (tmp_path / "m.txt").write_text("\n".join(
        " ".join(str((i * i + 7 * j * j) % 101 / 1000) for j in range(200)) for i in range(200)),
        encoding="ascii")
    words = ["solve", "s.scene", *OUTPUTS, "--keep", "kept"]
    if what == "report":
        words = ["t.deck", *LONG, *OUTPUTS]
    # The report needs little more than the program itself.
    room, shown, ended, step = 15_000_000, 0, 0, 1.01 if what == "report" else 1.1
    whole = run(*words)
    assert whole.returncode == 0
    texts = {name: (tmp_path / name).read_bytes() for name in OUTPUTS[1::2]}
    for name in (*texts, "kept"):
        (tmp_path / name).unlink(missing_ok=True)
    before = files(tmp_path)

    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (room, room))

    # What the libraries of the program take before it begins is the loader's to report.
    while run("--version", preexec_fn=limit).returncode != 0:
        room = int(step * room)
    while room < 4_000_000_000:
        done = run(*words, preexec_fn=limit)
        (tmp_path / "kept").unlink(missing_ok=True)
        if done.returncode == 0 and b"unknown, the map of every second pixel" not in done.stdout:
            break
        if done.returncode == 0:
            # Memory ends in the estimate of the error: the contacts are right.
            assert (tmp_path / "c.csv").read_bytes() == texts["c.csv"]
            for name in texts:
                (tmp_path / name).unlink()
            room = int(step * room)
            continue
        ended += 1
        assert done.stdout == b"" and files(tmp_path) == before, (room, done.stderr)
        lines = [line for line in done.stderr.decode().splitlines() if ": note: " not in line]
        if len(lines) == 1 and SENTENCE.fullmatch(lines[0]):
            assert done.returncode == 1
            assert sum(name in lines[0] for name in ("m.txt", "s.scene", "c.csv")) <= 1, lines
            shown += 1
        room = int(step * room)
    assert ended > 1 and shown > 0
    assert done.returncode == 0 and done.stdout == whole.stdout
    for name, text in texts.items():
        assert (tmp_path / name).read_bytes() == text


def test_a_map_that_does_not_fit(run, tmp_path):
    """Status 1, as nothing is wrong with the map; its name stands once."""
    with open(tmp_path / "m.txt", "w", encoding="ascii") as file:
        file.writelines(["1 2 3 4\n"] * 200000)
    (tmp_path / "s.scene").write_text(MANY["map"], encoding="ascii")

    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (room, room))

    room = 15_000_000
    while run("--version", preexec_fn=limit).returncode != 0:
        room = int(1.05 * room)
    room += 3_000_000
    done = run("solve", "s.scene", *OUTPUTS, preexec_fn=limit)
    assert done.returncode == 1 and done.stdout == b""
    assert one_line(done) == ("m.txt: not enough memory for the map, 4 x 200000 pixels, "
                              "6400000 bytes")


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


# Scenes of a map of 360,000 pixels and of 20,000 asperities: effects and edges with arrays of
# their own. Limits of memory and words of a command, where it is another one.
CAPS = "interaction = 'coupled'"
LIMITED = {
    "elastic": (", map_edge = 'periodic'", ""), "free": ("", ""),
    "hardness": (", map_edge = 'periodic'", "plasticity = 'on', plastic_hardness = 100."),
    "adhesion": (", map_edge = 'periodic'", "adhesion = 'on', work_of_adhesion = 1e-3, "
                                            "equilibrium_distance = 0.02"),
    "strip": (", map_edge = 'periodic', 'free'", ""),
    "creep": (", map_edge = 'periodic'", "relaxation_time = 1., relaxed_modulus_ratio = 0.5, "
                                         "hold_time = 5., hold_points = 3"),
    "asperities": (None, f"{CAPS}, relaxation_time = 1., relaxed_modulus_ratio = 0.5, "
                         "hold_time = 5., hold_points = 3"),
    "coupled": (None, CAPS), "coupled, 2 threads": (None, CAPS), "2 threads": ("", ""),
    "boundary": (None, "interaction = 'boundary'"),
    "tangential": ("", "friction = 'on', friction_coefficient = 0.3"),
    "tangential waves": (", map_edge = 'periodic'", "friction = 'on', friction_coefficient = 0.3"),
    "layers": ("", ""), "layers of waves": (", map_edge = 'periodic'", ""),
    "stress": ("", ""), "stress of waves": (", map_edge = 'periodic'", ""),
    "stress of strips": (", map_edge = 'periodic', 'free'", "")}
COMMANDS = {
    "summits": "summits lower.npy --spacing 1 --despike --output p.csv",
    "spectrum": "summits lower.npy --spacing 1 --spectrum p.csv",
    "generated": "generate g.spec --output p.csv,l.csv",
    "generated map": "generate m.spec --output p.npy"}
SPECS = {"g": "&surfaces number = 40000, length = 100., width = 100. / &heights mean = 0.01, "
              "deviation = 0.001 / &radii mean = 0.5 /",
         "m": "&map pixels = 600, spacing = 1., hurst = 0.8, rms_slope = 0.1 /"}


@pytest.mark.long
@pytest.mark.parametrize("what", [*LIMITED, *COMMANDS])
def test_limits_of_memory(what, asperity, tmp_path):
    """From what the program itself needs to what a solve needs, each limit of memory ends with
    results, or with a sentence on the memory and status 1; never with a signal."""
    edge, effects = LIMITED.get(what, ("", ""))
    threads = "2" if "2" in what else "1"
    words = f"solve s.scene --quiet --threads {threads} --positions p.csv"
    if "stress" in what:
        words += " --depths 0.5,1 --stress s.csv"
    words = COMMANDS.get(what, words).split()
    for name, text in SPECS.items():
        (tmp_path / f"{name}.spec").write_text(text)
    if edge is None:
        number = np.arange(2000 if what == "boundary" else 20000)
        rows = np.c_[3.0 * (number % 150), 3.0 * (number // 150),
                     0.1 + 1e-7 * (number * 7919 % 5000),
                     np.ones(len(number))]
        np.savetxt(tmp_path / "lower.csv", rows, "%.8g", ",", header="x,y,height,radius",
                   comments="")
        surface, load = "lower = 'lower.csv'", "'load', value = 300."
    else:
        side = 200 if re.search("stress|2|free|tangential|layers$", what) else 600
        y, x = np.mgrid[:side, :side]
        np.save(tmp_path / "lower.npy", 0.1 * (np.sin(x * np.pi / 30) + np.cos(y * np.pi / 37.5)))
        surface, load = f"lower = 'lower.npy', map_spacing = 1.{edge}", "'pressure', value = 1."
    if "tangential" in what:
        load += ", tangential_load = 4e3, 2e3"
    body = ", layer_thickness = 2*0.5, layer_modulus = 2*2e3, layer_poisson = 2*0.3"
    (tmp_path / "s.scene").write_text(
        f"&surfaces upper = 'plane', {surface} / &material elastic_modulus = 2*1e3, "
        f"poisson_ratio = 2*0.3{body if 'layer' in what else ''} / &loading control = {load} / "
        f"&effects {effects} /\n")
    ended = solved = 0
    for room in np.geomspace(24e6, 150e6, 18).astype(int):
        done = subprocess.run(
            [asperity, *words],
            cwd=tmp_path, env={**os.environ, "OMP_NUM_THREADS": threads}, capture_output=True,
            text=True, timeout=300,
            preexec_fn=lambda room=room: resource.setrlimit(resource.RLIMIT_AS, (room, room)))
        assert done.returncode in (0, 1) and "acktrace" not in done.stderr, (room, done.stderr)
        ended += done.returncode
        solved += done.returncode == 0
        if done.returncode == 1:
            assert re.search("not enough memory|error while loading", done.stderr), done.stderr
    assert ended > 0 and solved > 0
