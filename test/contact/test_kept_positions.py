"""`asperity solve --keep FILE`: positions that are solved stay, and a rerun goes on from there.

With ASPERITY_IMAGES, for instance `cafrun -n 2 EXE`, the same over several images (make images):
whatever a run of several leaves is what a run of one leaves.
"""

import os
import re
import shlex
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from programs import run_program
from surfaces_csv import write_csv_scene, write_scene
from test_result_files import fnv

OUTPUTS = ("contacts", "positions", "curve")
IMAGES = shlex.split(os.environ.get("ASPERITY_IMAGES", ""))
several_images = pytest.mark.skipif(not IMAGES, reason="ASPERITY_IMAGES is no command for several")


def rough(rng, n, lowest=0.03):
    """Asperities as dense as in the thesis, of its radius."""
    side = (n / 0.48) ** 0.5
    return np.column_stack((rng.random((n, 2)) * side, rng.normal(0.127, 0.03, n).clip(lowest, 0.2),
                            np.full(n, 1.27)))


def run(command, scene, folder, *options):
    """Status, standard output, standard error and the files of a run, by name."""
    folder.mkdir()
    words = [word for name in OUTPUTS for word in (f"--{name}", f"{name}.csv")
             if name != "contacts" or "without a list" not in scene.name]
    done = run_program(*command, "solve", scene, "--threads", "1", *words, *options, status=None,
                       cwd=folder, text=False)
    files = {name: (folder / f"{name}.csv").read_bytes() for name in OUTPUTS
             if (folder / f"{name}.csv").exists()}
    return done.returncode, done.stdout, done.stderr, files


SCENES = {
    "thesis": {},
    "curve": {"loading": {"control": "load", "value": 400.0, "points": 5}},
    "effects": {"effects": {"interaction": "auto", "friction": "on", "friction_coefficient": 0.2}},
    "effects without a list": {"effects": {"interaction": "coupled", "plasticity": "auto"}},
    "path": {"loading": {"control": "load", "value": (50.0, 400.0, 100.0)},
             "effects": {"plasticity": "on", "plastic_yield_stress": 8000.0}},
}


def kept_records(path):
    """The whole records of a kept file, in any order: its first line, then number and words. The
    next record follows an interrupted one on the same line."""
    first, *lines = path.read_bytes().split(b"\n")
    heads = [re.search(rb"(?:position|surface) \d+, words \d+, checksum (\w{8})$", line)
             for line in lines]
    return first, {(head[0], body) for head, body in zip(heads, lines[1:])
                   if head and head[1] == fnv(body).encode()}


def thesis_scene(name, root, folder):
    """The thesis' surfaces at 40 positions, with what the scene is about."""
    if name == "thesis":
        return root / "data" / "thesis.deck"
    return write_scene(folder / f"{name}.scene", surfaces={"deck": str(root / "data/thesis.deck")},
                       motion={"x_first": 0.1, "x_step": 0.1, "positions": 40}, **SCENES[name])


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=[pytest.mark.long] * (name == "thesis")) for name in SCENES])
def test_continued_anywhere(name, asperity, root, tmp_path):
    """A file cut anywhere is continued to the same outputs and records, and so is a damaged one."""
    scene = thesis_scene(name, root, tmp_path)
    none = run([asperity], scene, tmp_path / "none")
    whole = run([asperity], scene, tmp_path / "whole", "--keep", "../whole.keep")
    assert none[0] == 0 and whole == none
    kept = (tmp_path / "whole.keep").read_bytes()
    places = [match.start() for match in re.finditer(rb"(?m)^position ", kept)]
    assert len(places) == (100 if name == "thesis" else 40)
    cuts = [0, 9, places[0], places[0] + 3, places[1] - 1, places[17], places[30] + 200]
    versions = [kept[:cut] for cut in cuts]
    versions.append(kept[:places[2] + 100] + b"A" * 8 + kept[places[2] + 108:])
    for number, version in enumerate(versions):
        (tmp_path / "part.keep").write_bytes(version)
        again = run([asperity], scene, tmp_path / str(number), "--keep", "../part.keep")
        assert again == none
        assert kept_records(tmp_path / "part.keep") == kept_records(tmp_path / "whole.keep")


def test_records_stand_in_any_order(asperity, root, tmp_path):
    """Images append as they are done: a reversed file with a position twice is whole."""
    scene = thesis_scene("effects", root, tmp_path)
    whole = run([asperity], scene, tmp_path / "whole", "--keep", "../a.keep")
    first, *lines = (tmp_path / "a.keep").read_bytes().split(b"\n")
    pairs = [b"\n".join(lines[i:i + 2]) for i in range(0, len(lines) - 1, 2)]
    (tmp_path / "a.keep").write_bytes(b"\n".join([first, *pairs[::-1], pairs[7], b""]))
    before = (tmp_path / "a.keep").read_bytes()
    assert run([asperity], scene, tmp_path / "again", "--keep", "../a.keep") == whole
    assert len(pairs) == 40 and (tmp_path / "a.keep").read_bytes() == before


def test_kept_positions_are_taken(asperity, root, tmp_path):
    """What is kept is not solved again: a number changed there, with its checksum, is printed."""
    scene = thesis_scene("thesis", root, tmp_path)
    run([asperity], scene, tmp_path / "whole", "--keep", "../a.keep")
    lines = (tmp_path / "a.keep").read_bytes().split(b"\n")
    # The displacement is the first number; 0.1 becomes 0.5.
    assert lines[2].startswith(b"3FB999999999999A")
    lines[2] = np.float64(0.5).tobytes()[::-1].hex().upper().encode() + lines[2][16:]
    lines[1] = lines[1][:-8] + fnv(lines[2]).encode()
    (tmp_path / "a.keep").write_bytes(b"\n".join(lines))
    done = run([asperity], scene, tmp_path / "again", "--keep", "../a.keep")
    assert done[3]["positions"].split(b"\n")[1].startswith(b"1,5.000000")


@pytest.mark.parametrize("change", ["scene", "surface", "contacts", "version"])
def test_other_work_is_refused(change, asperity, tmp_path):
    rng = np.random.default_rng(3)
    scene = write_csv_scene(tmp_path, rough(rng, 40), rough(rng, 40),
                            motion={"positions": 5, "x_step": 0.1},
                            loading={"control": "approach", "value": 0.1},
                            limit={"criterion": "load", "value": 288.89})
    assert run([asperity], scene, tmp_path / "a", "--keep", "../a.keep")[0] == 0
    before = (tmp_path / "a.keep").read_bytes()
    if change == "version":
        before = re.sub(rb"^asperity [0-9.]+ ", b"asperity 0.0.9 ", before)
        (tmp_path / "a.keep").write_bytes(before)
    if change == "scene":
        scene.write_text(scene.read_text().replace("0.1", "0.2"))
    elif change == "surface":
        surface = tmp_path / "pair_upper.csv"
        assert surface.exists()
        surface.write_text(surface.read_text() + "0.5,0.5,0.1,1.27\n")
    command = [asperity, "solve", scene, "--keep", "a.keep"]
    if change != "contacts":
        command += ["--contacts", "c.csv"]
    done = run_program(*command, status=1, cwd=tmp_path)
    assert done.stdout == ""
    assert "a.keep: holds no positions of this scene" in done.stderr
    assert (tmp_path / "a.keep").read_bytes() == before
    assert not (tmp_path / "c.csv").exists()


def test_words_that_do_not_go_together(asperity, root, tmp_path):
    deck = tmp_path / "a.deck"
    deck.write_bytes((root / "data" / "thesis.deck").read_bytes())
    for words, message in ((["--keep", "k", "--accuracy", "1e-3"], "expected one of both"),
                           (["--keep", "a.deck"], "--keep names the input"),
                           (["--keep", "k", "--positions", "k"], "both name k")):
        done = run_program(asperity, "solve", "a.deck", *words, status=2, cwd=tmp_path)
        assert message in done.stderr
        assert deck.read_bytes() == (root / "data" / "thesis.deck").read_bytes()


LONG = 1500


def long_scene(tmp_path):
    """A sweep of a second or more."""
    rng = np.random.default_rng(9)
    return write_csv_scene(
        tmp_path, rough(rng, 1000), rough(rng, 1000), modulus=(275760.0, 275760.0),
        motion={"positions": LONG, "x_step": 1e-3},
        loading={"control": "approach", "value": 0.1}, limit={"criterion": "load", "value": 288.0})


def processes(name, session):
    """Numbers of the processes of a session that have a name (Linux)."""
    for place in Path("/proc").glob("[0-9]*/stat"):
        try:
            number, rest = place.read_text().split(" (", 1)
        except OSError:
            continue  # it has ended
        found, words = rest.rsplit(") ", 1)
        if found == name and int(words.split()[3]) == session:
            yield int(number)


def kill_in_the_middle(command, scene, tmp_path, number):
    """Starts a run and sends a signal to it, or to one of its images, when some is kept."""
    begun = subprocess.Popen([*command, *solve_to("part", scene)], cwd=tmp_path,
                             stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                             stderr=subprocess.PIPE, start_new_session=True)
    kept = tmp_path / "part.keep"
    until = time.monotonic() + 60
    while begun.poll() is None and time.monotonic() < until and \
            (not kept.exists() or b"position 9," not in kept.read_bytes()):
        time.sleep(0.001)
    if len(command) == 1:
        begun.send_signal(number)
    else:
        # The last image, not image 1 and not the starter.
        images = sorted(processes("asperity", os.getsid(begun.pid)))
        assert len(images) >= 2
        os.kill(images[-1], number)
    _, err = begun.communicate(timeout=60)
    assert begun.returncode != 0
    assert 9 <= kept.read_bytes().count(b"\nposition ") < LONG
    assert not (tmp_path / "part.csv").exists()
    return err.decode()


def solve_to(name, scene):
    return ["solve", scene, "--threads", "1", "--keep", f"{name}.keep", "--positions",
            f"{name}.csv"]


def compare_continued(command, asperity, scene, tmp_path):
    """Killed, then continued: the bytes of an undisturbed run."""
    for words, name in ((command, "part"), ([asperity], "whole")):
        run_program(*words, *solve_to(name, scene), cwd=tmp_path)
    assert (tmp_path / "part.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()
    assert kept_records(tmp_path / "part.keep") == kept_records(tmp_path / "whole.keep")


@pytest.mark.long
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_kill_and_continue(number, asperity, tmp_path):
    scene = long_scene(tmp_path)
    kill_in_the_middle([asperity], scene, tmp_path, number)
    compare_continued([asperity], asperity, scene, tmp_path)


@several_images
@pytest.mark.parametrize("name", SCENES)
def test_images_leave_the_same_bytes(name, asperity, root, tmp_path):
    scene = thesis_scene(name, root, tmp_path)
    one = run([asperity], scene, tmp_path / "one", "--keep", "../one.keep")
    several = run(IMAGES, scene, tmp_path / "several")
    kept = run(IMAGES, scene, tmp_path / "kept", "--keep", "../several.keep")
    assert one[0] == several[0] == kept[0] == 0
    assert several[1] == kept[1] == one[1] and several[3] == kept[3] == one[3]
    assert len(one[3]) >= 2
    assert kept_records(tmp_path / "several.keep") == kept_records(tmp_path / "one.keep")
    assert not list(tmp_path.rglob(".asperity*"))


@several_images
def test_images_killed_and_continued(asperity, tmp_path):
    """One image of the run is lost: the others end, what is kept is continued by one image."""
    scene = long_scene(tmp_path)
    message = kill_in_the_middle(IMAGES, scene, tmp_path, signal.SIGKILL)
    assert re.search(r"signal 9|[Kk]illed|lost", message), message
    compare_continued([asperity], asperity, scene, tmp_path)
