"""Results, surfaces and errors of the Python package, copied and sent to other processes; and what
thousands of calls leave behind."""

import concurrent.futures
import copy
import gc
import json
import os
import pickle
import threading

import numpy as np
import pytest
from builds import ROOT
from programs import run_program

pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]

MAP = ROOT / "data/examples/summits/rough.sdf"
SPEC = {"surfaces": {"number": 60, "length": 1.0, "width": 1.0},
        "heights": {"mean": 0.01, "deviation": 0.001}, "radii": {"mean": 0.5}}


def solved(asperity):
    results = asperity.solve(ROOT / "data/examples/thesis.scene")
    return [results, results.positions, results.states, results.contacts,
            asperity.summits(MAP), *asperity.generate(SPEC)]


def content(thing):
    """All numbers and texts of a result, as text."""
    if hasattr(thing, "keys"):
        extra = [thing.statistics, thing.summary] if hasattr(thing, "statistics") else []
        return repr([thing.rows, *extra, *((name, list(thing[name])) for name in thing)])
    return repr([content(thing.positions), content(thing.states), content(thing.contacts),
                 thing.summary, thing.warnings, thing.notes])


COPIES = {"copy": copy.copy, "deepcopy": copy.deepcopy,
          **{f"pickle {protocol}": lambda thing, protocol=protocol: pickle.loads(
              pickle.dumps(thing, protocol)) for protocol in range(pickle.HIGHEST_PROTOCOL + 1)}}


@pytest.mark.long
@pytest.mark.parametrize("how", COPIES)
def test_copies(package, how):
    """A copy has all of its own, whichever of the two goes first; so has a copy of a copy."""
    things = solved(package)
    while things:
        original = things.pop()
        expected = content(original)
        copied = COPIES[how](original)
        again = COPIES[how](copied)
        assert type(copied) is type(original) and content(copied) == expected
        del copied
        gc.collect()
        assert content(original) == expected
        del original
        # Whatever takes the place of memory that was freed.
        filler = [package.generate(SPEC) for _ in range(3)]
        assert content(again) == expected and filler


def test_cycles_and_finalizers(package):
    """A finalizer of garbage in a cycle still reads the column, in any order of collection."""
    found = []

    class Holder:
        def __init__(self, column):
            self.column, self.self = column, self

        def __del__(self):
            found.append(float(np.asarray(self.column)[-1]))

    gc.disable()
    try:
        states = [package.solve(ROOT / "data/examples/one_pair.scene").states for _ in range(20)]
        expected = states[0]["load"][-1]
        holders = [Holder(table["load"]) for table in states]
        for table, holder in zip(states, holders):
            table.holder = holder
        del states, holders, table, holder
        gc.collect()
    finally:
        gc.enable()
    assert found == [expected] * 20


@pytest.mark.long
def test_varied_scene(package):
    """A deep copy of a scene with surfaces of `generate`, changed and solved, again and again."""
    upper, lower = package.generate(SPEC)
    base = {"surfaces": {"upper": upper, "lower": lower}, "material": {"contact_modulus": 1e5},
            "loading": {"control": "load", "value": 20.0}, "effects": {"interaction": "off"}}
    for value in (10.0, 20.0, 30.0):
        varied = copy.deepcopy(base)
        varied["loading"]["value"] = value
        assert package.solve(varied).states["load"][-1] == pytest.approx(value, 1e-6)
        del varied
        gc.collect()
    assert list(upper["x"]) == list(package.generate(SPEC)[0]["x"])


def test_problems_and_errors(package):
    """Errors come back from another process as they were."""
    with pytest.raises(package.InputError) as caught:
        package.solve({"loading": {"control": "lod"}, "materia": {}})
    for error in (caught.value, package.ComputeError("why"), package.TheoryWarning("what")):
        for copied in (copy.deepcopy(error), pickle.loads(pickle.dumps(error)), copy.copy(error)):
            assert str(copied) == str(error) and type(copied) is type(error)
    copied = pickle.loads(pickle.dumps(caught.value))
    assert copied.problems == caught.value.problems and len(copied.problems) > 1
    assert isinstance(copied.problems[0], package.Problem)
    assert pickle.loads(pickle.dumps(copied.problems[0])) == copied.problems[0]


# Alone, as children of `spawn` import it.
POOL = '''
import asperity, concurrent.futures, json, multiprocessing

def scene(i):
    cap = {"x": [0.0], "y": [0.0], "height": [1.0], "radius": [2.0]}
    return {"surfaces": {"upper": cap, "lower": "plane"}, "material": {"contact_modulus": 1e3},
            "loading": {"control": "load", "value": 1.0 + i}, "effects": {"interaction": "off"}}

def bad(i):
    return asperity.solve({"loading": {"control": i}})

if __name__ == "__main__":
    spawn = multiprocessing.get_context("spawn")
    with spawn.Pool(4) as pool:
        loads = [r.states["load"][-1] for r in pool.map(asperity.solve, map(scene, range(40)))]
        upper, lower = pool.apply(asperity.generate, (SPEC,))
        sizes = [pool.apply(len, (table["x"].tolist(),)) for table in (upper, lower)]
        try:
            pool.apply(bad, (1,))
        except asperity.InputError as error:
            told = str(error)
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=spawn) as pool:
        results = list(pool.map(asperity.solve, map(scene, range(4))))
        tables = list(pool.map(len, [one.positions for one in results]))
    print(json.dumps([loads, sizes, told, [one.positions["load"][0] for one in results], tables]))
'''


@pytest.mark.long
def test_spawn_pools(venv, tmp_path):
    """Results come back from processes, and go to them, as in docs/reference/python.md."""
    script = tmp_path / "pool.py"
    script.write_text(POOL.replace("SPEC", repr(SPEC)))
    done = run_program(venv / "bin/python", "-W", "ignore", script)
    loads, sizes, told, again, tables = json.loads(done.stdout)
    assert loads == pytest.approx([1.0 + i for i in range(40)], 1e-6)
    assert sizes == [60, 60] and "loading.control: found '1'" in told
    assert again == loads[:4] and tables == [1] * 4


def test_thread_pool(package):
    """Calls at once in several threads: each has its own results."""
    upper, lower = package.generate(SPEC)

    def load(value):
        return package.solve(
            {"surfaces": {"upper": upper, "lower": lower}, "material": {"contact_modulus": 1e5},
             "loading": {"control": "load", "value": value}, "effects": {"interaction": "off"}},
            threads=1).positions["load"][0]
    values = [1.0 + i for i in range(32)]
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        assert list(pool.map(load, values)) == list(map(load, values))


def test_surfaces_from_pipes(package, tmp_path):
    """Two named pipes, written slowly and line by line while the library reads."""
    text = "x,y,height,radius\n" + "".join(f"{i},0,{0.001 * i:.3f},2\n" for i in range(100))
    (tmp_path / "file").write_text(text)

    def write(path):
        with open(path, "w", buffering=1, encoding="ascii") as pipe:
            for line in text.splitlines(keepends=True):
                pipe.write(line)

    def load(upper, lower):
        return package.solve(
            {"surfaces": {"upper": upper, "lower": lower}, "material": {"contact_modulus": 1e3},
             "loading": {"control": "load", "value": 1.0}, "effects": {"interaction": "off"}}
            ).positions["separation"][0]
    for name in ("u", "l"):
        os.mkfifo(tmp_path / name)
    writers = [threading.Thread(target=write, args=[tmp_path / name]) for name in ("u", "l")]
    for writer in writers:
        writer.start()
    assert load(tmp_path / "u", tmp_path / "l") == load(tmp_path / "file", tmp_path / "file")


MANY = '''
import asperity, os, resource

open("u.csv", "w").write("x,y,height,radius\\n0,0,1,2\\n")
open("m.txt", "w").write("".join(f"0 {i % 3} 0 1 0\\n" for i in range(5)))
material, loading = {"contact_modulus": 1e3}, {"control": "load", "value": 1e-3}
surfaces = [{"upper": "u.csv", "lower": "plane"}, {"upper": "u.csv", "lower": "u.csv"},
            {"upper": "plane", "lower": "m.txt", "map_spacing": (1.0, 1.0)},
            {"upper": "m.txt", "lower": "m.txt", "map_spacing": (1.0, 1.0)}]
bad = [{"upper": "none.csv", "lower": "plane"}, {"upper": ".", "lower": "m.txt"},
       {"upper": "u.csv", "lower": "m.txt", "map_spacing": (1.0, 1.0)}]

def solve(number):
    for i in range(number):
        asperity.solve({"surfaces": surfaces[i % 4], "material": material, "loading": loading,
                        "effects": {"interaction": "off"}}, threads=1)
        if i % 4 == 0:
            try:
                asperity.solve({"surfaces": bad[i % 3], "material": material, "loading": loading})
            except asperity.InputError:
                continue
            raise AssertionError("not refused")

def used():
    return [len(os.listdir("/proc/self/fd")), int(open("/proc/self/statm").read().split()[1]) * 4]

resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64))
solve(1000)
before = used()
solve(2000)
print(before, used())
'''


@pytest.mark.long
def test_many_solves_with_files(venv, tmp_path):
    """Two thousand solves of surfaces and maps from files, some refused, with room for 64 open
    files: as many are open afterwards as before, and less than half a kilobyte a solve is left."""
    done = run_program(venv / "bin/python", "-W", "ignore", "-c", MANY, cwd=tmp_path)
    before, after = json.loads(f"[{done.stdout.replace('] [', '], [')}]")
    assert after[0] == before[0] and after[1] - before[1] < 1000, (before, after)
