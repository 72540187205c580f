"""Results, surfaces and errors of the Python package, copied and sent to other processes; and what
thousands of calls leave behind."""

import copy
import gc
import json
import pickle

import pytest
from builds import ROOT
from programs import run_program

pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]

MAP = ROOT / "data/examples/summits/rough.sdf"
SPEC = {"surfaces": {"number": 60, "length": 1.0, "width": 1.0},
        "heights": {"mean": 0.01, "deviation": 0.001}, "radii": {"mean": 0.5}}


def solved(asperity):
    results = asperity.solve(ROOT / "data/examples/thesis.scene")
    pressed = asperity.solve(ROOT / "data/examples/summits/press_samples.scene", fields=True)
    return [results, pressed.fields(), results.positions, results.states, results.contacts,
            asperity.summits(MAP), *asperity.generate(SPEC)]


def content(thing):
    """All numbers and texts of a result, as text."""
    if hasattr(thing, "keys"):
        extra = [thing.statistics, thing.summary] if hasattr(thing, "statistics") else []
        return repr([getattr(thing, "rows", 0), *extra,
                     *((name, list(thing[name])) for name in thing)])
    return repr([content(thing.positions), content(thing.states), content(thing.contacts),
                 thing.summary, thing.warnings, thing.notes])


COPIES = {"copy": copy.copy, "deepcopy": copy.deepcopy,
          **{f"pickle {protocol}": lambda thing, protocol=protocol: pickle.loads(
              pickle.dumps(thing, protocol)) for protocol in (0, 2, pickle.HIGHEST_PROTOCOL)}}


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


MANY = '''
import asperity, os, resource

open("u.csv", "w").write("x,y,height,radius\\n0,0,1,2\\n")
open("m.txt", "w").write("".join(f"0 {i % 3} 0 1 0\\n" for i in range(5)))
material, loading = {"contact_modulus": 1e3}, {"control": "load", "value": 1e-3}
surfaces = [{"upper": "u.csv", "lower": "plane"}, {"upper": "u.csv", "lower": "u.csv"},
            {"upper": "plane", "lower": "m.txt", "map_spacing": (1.0, 1.0)},
            {"upper": "m.txt", "lower": "m.txt", "map_spacing": (1.0, 1.0)}]
bad = [{"upper": "none.csv", "lower": "plane"}, {"upper": ".", "lower": "m.txt"},
       {"upper": "u.csv", "lower": "m.txt"}]

def solve(number):
    for i in range(number):
        asperity.solve({"surfaces": surfaces[i % 4], "material": material, "loading": loading},
                       threads=1)
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
