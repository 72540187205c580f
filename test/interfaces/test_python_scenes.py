"""Scenes that are read once and solved many times, from Python; progress, Ctrl-C, threads."""

import concurrent.futures
import copy
import pickle
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from builds import ROOT
from programs import run_program

pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]

SPEC = {"surfaces": {"number": 300, "length": 4.0, "width": 4.0},
        "heights": {"mean": 0.01, "deviation": 0.001}, "radii": {"mean": 0.5}}
MATERIAL = {"elastic_modulus": (210e3, 70e3), "poisson_ratio": (0.3, 0.33)}


def groups(package, **more):
    upper, lower = package.generate(SPEC)
    return {"surfaces": {"upper": upper, "lower": lower}, "material": MATERIAL,
            "loading": {"control": "load", "value": 20.0}, **more}


def assert_near(found, expected):
    """The same states, to the tolerance of the solver."""
    assert list(found) == list(expected) and len(found) == len(expected)
    for name in ("load", "separation", "compression", "area", "vertical_load"):
        assert np.allclose(found[name], expected[name], rtol=1e-6, atol=0), name
    assert np.array_equal(found["contacts"], expected["contacts"])


def test_changes(package):
    """A change keeps the other names of its group, None removes, and the scene stays as it was."""
    base = groups(package)
    scene = package.Scene(base)
    before = scene.solve().states
    curve = scene.solve(loading={"points": 4, "value": 10.0}).states
    assert len(curve) == 5 and curve["load"][-1] == pytest.approx(10.0, 1e-6)
    alone = scene.solve(effects={"interaction": False})
    assert alone.states["separation"][-1] > before["separation"][-1]
    for word in (True, "auto"):
        assert_near(scene.solve(effects={"interaction": word}).states, before)
    closed = scene.solve(loading={"control": "compression", "value": 1e-3}).states
    assert closed["compression"][-1] == pytest.approx(1e-3, rel=1e-9)
    soft = scene.solve(material={"elastic_modulus": None, "poisson_ratio": None,
                                 "contact_modulus": 1e4})
    assert soft.states["compression"][-1] > before["compression"][-1]
    assert_near(scene.solve().states, before)
    assert scene.groups["loading"] == {"control": "load", "value": 20.0}
    with pytest.raises(package.InputError, match="^loading: no control and value"):
        scene.solve(loading=None)
    with pytest.raises(package.InputError, match="surfaces: .* a new asperity.Scene"):
        scene.solve(surfaces={"nominal_area": 2.0})
    with pytest.raises(package.InputError, match="loading.values: .*did you mean .*value"):
        scene.solve(loading={"values": 3.0})
    with pytest.raises(package.InputError, match="did you mean .*loading"):
        scene.solve(loadin={"value": 3.0})
    with pytest.raises(TypeError, match="loading: found 3"):
        scene.solve(loading=3)
    assert_near(scene.solve().states, before)


@pytest.mark.parametrize("name", ["data/examples/csv_surfaces.scene", "data/examples/thesis.scene",
                                  "data/examples/summits/press_samples.scene", "data/thesis.deck",
                                  "data/examples/effects/cycle.scene",
                                  "data/examples/shifted.deck"])
def test_files(package, name):
    """A scene of a file, solved as it is and with a change."""
    scene = package.Scene(ROOT / name)
    expected = package.solve(ROOT / name).states
    assert scene.solve().states == expected
    near = scene.solve(effects={"tolerance": 0.02} if "deck" not in name else {"friction": "off"})
    assert len(near.states) == len(expected)
    if "press" not in name:
        assert len(scene.solve(motion={"positions": 2}).positions) == 2
    assert_near(scene.solve().states, expected)


def test_groups_of_a_deck(package):
    """The sweep that a deck stands for, in the fewest digits that read back as the same number."""
    assert package.Scene(ROOT / "data/thesis.deck").groups["motion"] == {
        "x_first": "1e-1", "x_step": "1e-1", "y_first": "0", "y_step": "0", "positions": "100"}


def test_file_is_read_once(package, tmp_path):
    (tmp_path / "u.csv").write_text("x,y,height,radius\n0,0,0.1,1\n")
    path = tmp_path / "a.scene"
    path.write_text("&surfaces upper = 'u.csv', lower = 'plane', units = 'mm', 'N' /\n"
                    "&material contact_modulus = 1000 /\n&loading control = 'load', value = 1 /\n")
    scene = package.Scene(path)
    (tmp_path / "u.csv").unlink()
    path.unlink()
    found = scene.solve(loading={"value": 8.0}).states
    # Hertz: d**1.5 = 3 P / (4 E sqrt(R)).
    assert found["compression"][-1] == pytest.approx((3 * 8 / 4000)**(2 / 3), rel=1e-9)
    assert found.units["load"] == "N" and scene.groups["loading"] == {"control": "'load'",
                                                                      "value": "1"}


def test_map(package):
    """Pressures on the pixels of a height map."""
    surface = package.read_map(ROOT / "data/examples/summits/rough.sdf", unit="um")
    base = {"surfaces": {"upper": "plane", "lower": surface}, "material": {"contact_modulus": 1e5},
            "loading": {"control": "pressure", "value": 100.0},
            "effects": {"interaction": "boundary"}}
    scene = package.Scene(base)
    for pressure in (100.0, 300.0, 50.0):
        base["loading"]["value"] = pressure
        assert_near(scene.solve(loading={"value": pressure}).states, package.solve(base).states)


def test_copies_of_scenes(package):
    scene = package.Scene(groups(package))
    expected = scene.solve().states
    for one in (copy.copy(scene), copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        assert_near(one.solve().states, expected)


def test_messages_in_threads(package):
    """Calls that fail in two threads at once have messages of their own, of any length."""
    def message(length):
        wrong = {f"n{i}": "y" * (1 + length * i % 50) for i in range(100)}
        with pytest.raises(package.InputError) as caught:
            package.Scene({"surfaces": {"deck": "x" * length}, "effects": wrong})
        return str(caught.value)
    lengths = range(1, 100)
    expected = [message(length) for length in lengths]
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        assert list(pool.map(message, lengths)) == expected


def test_no_shared_lengths(package_folder):
    """The rooms that solve call no function of a deferred length: gfortran keeps that length in
    static memory, under the name `slen`, where threads overwrite it."""
    listed = run_program("objdump", "-t", package_folder / "asperity" / "libasperity.so.1").stdout
    # Symbols follow the name of their source.
    parts = {part.split()[1]: part for part in listed.split(" df *ABS*")[1:]}
    held = {name for name, part in parts.items() if "slen." in part}
    rooms = ("circles", "contact", "effects", "grid", "joint", "maps", "models", "numerics",
             "results", "run", "search", "summation")
    sources = {path.name for room in rooms for path in (ROOT / "src" / room).glob("*.[fF]90")}
    assert len(sources & set(parts)) > 100
    assert sorted(sources & held) == []


PROGRESS = """
import sys
if HIDE: sys.modules["tqdm"] = None
import asperity
asperity.solve({"surfaces": {"deck": "data/thesis.deck"}, "loading": {"control": "load",
    "value": (100.0, 0.0) * 50, "points": 20}, "effects": {"interaction": "coupled"}},
    progress=True, contacts=False)
"""


@pytest.mark.parametrize("hide, shown", [(True, r"asperity: (\d+) of (\d+) states"),
                                        (False, r"asperity: .*\b(\d+)/(\d+) \[.*state/s")])
def test_progress(package_folder, hide, shown):
    """A bar of tqdm, or a line without it, on standard error; it ends with all states."""
    code = f"import sys; sys.path.insert(0, {str(package_folder)!r})"
    done = run_program(sys.executable, "-W", "ignore", "-c",
                       code + PROGRESS.replace("HIDE", str(hide)), cwd=ROOT)
    assert done.stdout == ""
    counts = [tuple(map(int, pair)) for pair in re.findall(shown, done.stderr)]
    assert len(counts) >= 2 and counts[-1][0] == counts[-1][1] > 1000
    assert counts == sorted(counts) and done.stderr.endswith("\n")


ENDED = """
import asperity, time
upper, lower = asperity.generate({"surfaces": {"number": NUMBER, "length": 100, "width": 100},
    "heights": {"mean": 0.01, "deviation": 0.001}, "radii": {"mean": 0.5}})
scene = {"surfaces": {"upper": upper, "lower": lower}, "material": {"contact_modulus": 1e5},
         "loading": {"control": "load", "value": 5.0 * NUMBER, "points": 50},
         "effects": {"interaction": "coupled"}}
print("begins", flush=True)
try:
    asperity.solve(scene)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


def hear_interrupts():
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.mark.long
def test_interrupt_within_a_second(venv):
    """Ctrl-C in the middle of one long state: the exception comes at once."""
    with subprocess.Popen([venv / "bin/python", "-c", ENDED.replace("NUMBER", "50000")], cwd=ROOT,
                          text=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                          preexec_fn=hear_interrupts) as process:
        assert process.stdout.readline() == "begins\n"
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        begun = time.monotonic()
        assert process.stdout.readline() == "interrupted\n"
        print(f"Ctrl-C to KeyboardInterrupt: {time.monotonic() - begun:.2f} s")
        process.wait(60)
