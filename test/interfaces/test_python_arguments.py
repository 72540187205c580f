"""Arguments of the Python package: each with every kind of bad value, and numbers of every kind.

A new argument is covered by a row of ARGUMENTS."""

import array
import decimal
import fractions
import math
import os
import pathlib
import re
import subprocess

import numpy as np
import pytest
from builds import ROOT

pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]

NAN, INF = math.nan, math.inf
LARGE = 2**32 + 1
MASKED = np.ma.masked_array([1.0, 2.0], mask=[False, True])


class NoPath:
    def __fspath__(self):
        return 3


# What no argument of a kind may be. Numbers out of range are those that no number of the kind is.
OF_ANY = [object(), NoPath(), {1, 2}, 1j, np.complex128(1j), np.ma.masked, MASKED, lambda: 0]
BAD = {
    "path": [None, 3, 1.5, True, [], "a\0b", b"a\0b", "\ud800", "", np.zeros(2), *OF_ANY],
    "word": [None, 3, True, [], "a\0b", "\ud800", "no such word", b"real64", *OF_ANY],
    "flag": [None, 2, -1, 0.5, "on", [], NAN, np.zeros(2), *OF_ANY],
    "whole": [None, True, 1.5, NAN, "1", b"1", [1], LARGE, -LARGE, 10**5000, np.float32(1),
              np.int64(LARGE), decimal.Decimal(1), np.zeros(2), *OF_ANY],
    "number": [None, True, np.True_, "1", b"1", [], [1.0, 2.0], {}, NAN, INF, -INF, 10**400,
               decimal.Decimal("sNaN"), np.float32(NAN), np.array([1.0, 2.0]), np.array([[1.0]]),
               *OF_ANY],
    "wholes": [None, 13, 1.5, "all", b"13", [None], [True], [1.5], ["1"], [LARGE], {13: 1},
               *OF_ANY],
    "pair": [None, 0.5, "1,1", b"11", [], [1.0], [1.0, 1.0, 1.0], [1.0, None], [1.0, "1"],
             [1.0, True], [1.0, NAN], [1.0, INF], [1.0, 0.0], [1.0, -1.0], [1e-31, 1.0],
             [1.0, 1e31], np.zeros((2, 2)), {1: 1, 2: 2}, *OF_ANY],
    "column": [None, "1", b"12", bytearray(b"12"), {}, [], [NAN, 1.0], [1.0, INF], [1.0, None],
               [1.0, "1"], [1.0, True], [1.0, 1j], [1.0], [1.0] * 3, [[1.0, 2.0]], [10**400, 1],
               np.zeros((2, 2)), np.array([1j, 1]), np.array([True, False]), np.array(["1", "2"]),
               np.array([1, 2], "M8[s]"), np.array([1.0, None]), np.float32([1, NAN]), *OF_ANY],
    "surface": [None, 3, 1.5, True, [], {}, [1.0, 2.0], np.zeros(3), {"x": [1.0]}, {1: 2},
                *OF_ANY],
    "matrix": [None, 3, 1.5, True, [], {}, "abc", [1.0, 2.0], [[1.0], [1.0, 2.0]], [["1"]],
               [[1j]], [[1.0, None]], np.zeros(3), np.zeros((2, 2, 2)), np.zeros((2, 2), complex),
               np.array([["1"]]), np.zeros((2, 2), bool), *OF_ANY],
    "group": [None, 3, "a", [1], [("value", 1)], {1: 2}, {"a b": 1}, {"value = 1, a": 1},
              {"no_such_name": 1}, *OF_ANY],
}


def scene(**changes):
    """Two caps under a plane. A change is named `group` or `group__name`, `__` for a dot."""
    cap = {"x": [0.0, 9.0], "y": [0.0, 0.0], "height": [1.0, 1.0], "radius": [2.0, 2.0]}
    groups = {"surfaces": {"upper": cap, "lower": "plane", "nominal_area": 100.0},
              "material": {"contact_modulus": 1000.0},
              "loading": {"control": "approach", "value": 0.9},
              "effects": {"interaction": "off"}}
    for names, value in changes.items():
        *path, last = names.split("__")
        place = groups
        for name in path:
            place = place.setdefault(name, {})
        place[last] = value
    return groups


def of_scene(name):
    return lambda asperity, value: asperity.solve(scene(**{name.replace(".", "__"): value}))


def option(function, first, name):
    return lambda asperity, value: getattr(asperity, function)(first, **{name: value})


SCENE, DECK = ROOT / "data/examples/one_pair.scene", ROOT / "data/thesis.deck"
MAP = ROOT / "data/examples/summits/rough.sdf"
SPEC = {"surfaces": {"number": 9, "length": 1.0, "width": 2.0}, "radii": {"mean": 3.0},
        "heights": {"mean": 0.1, "deviation": 0.01}}
MATRIX = "matrix.txt"

# Name, kind, further values that are out of its own range, call.
ARGUMENTS = [
    ("scene", "path", [], lambda asperity, value: asperity.solve(value)),
    ("arithmetic", "word", ["real128"], option("solve", SCENE, "arithmetic")),
    ("accuracy", "number", [-1.0, 1.0, 2.0, -1e-300], option("solve", SCENE, "accuracy")),
    ("accuracy_of", "word", ["volume"], option("solve", SCENE, "accuracy_of")),
    ("contacts", "flag", [], option("solve", SCENE, "contacts")),
    ("threads", "whole", [-1, 10000, 2**31 - 1], option("solve", SCENE, "threads")),
    ("progress", "flag", [], option("solve", SCENE, "progress")),
    ("deck", "path", [], lambda asperity, value: asperity.report(value)),
    ("arithmetic", "word", [], option("report", DECK, "arithmetic")),
    ("tables", "wholes", [[0], [101], [-1]], option("report", DECK, "tables")),
    ("map", "path", [], lambda asperity, value: asperity.summits(value)),
    ("rule", "word", [], option("summits", MAP, "rule")),
    ("level", "word", [], option("summits", MAP, "level")),
    ("radius", "word", [], option("summits", MAP, "radius")),
    ("unit", "word", [], option("summits", MAP, "unit")),
    ("spacing", "pair", [], option("summits", MATRIX, "spacing")),
    ("despike", "flag", [], option("summits", MAP, "despike")),
    ("edge", "word", [], option("summits", MAP, "edge")),
    ("path", "path", [], lambda asperity, value: asperity.read_map(value)),
    ("spacing", "pair", [], option("read_map", MATRIX, "spacing")),
    ("unit", "word", [], option("read_map", MAP, "unit")),
    ("periodic", "flag", [], option("read_map", MAP, "periodic")),
    ("heights", "matrix", [], lambda asperity, value: asperity.HeightMap(value, 1.0)),
    ("spacing", "pair", [], lambda asperity, value: asperity.HeightMap([[1.0]], value)),
    ("unit", "word", ["furlong"], lambda asperity, value: asperity.HeightMap([[1.0]], 1.0, value)),
    ("periodic", "flag", [], lambda asperity, value: asperity.HeightMap(
        [[1.0]], 1.0, periodic=value)),
    ("specification", "path", [], lambda asperity, value: asperity.generate(value)),
    ("surface", "whole", [0, -1, 2], option("generate", SPEC, "surface")),
    ("surfaces.upper", "surface", [], of_scene("surfaces.upper")),
    ("surfaces.lower", "surface", [], of_scene("surfaces.lower")),
    ("surfaces.upper.x", "column", [], of_scene("surfaces.upper.x")),
    ("surfaces.upper.y", "column", [], of_scene("surfaces.upper.y")),
    ("surfaces.upper.height", "column", [[4.0, 1.0], [1.0, 100.0]],
     of_scene("surfaces.upper.height")),
    ("surfaces.upper.radius", "column", [[0.0, 2.0], [2.0, -1.0]],
     of_scene("surfaces.upper.radius")),
    ("surfaces", "group", [], of_scene("surfaces")),
    ("material", "group", [], of_scene("material")),
    ("loading", "group", [], of_scene("loading")),
    ("effects", "group", [], of_scene("effects")),
    ("surfaces.nominal_area", "number", [-1.0, 0.0], of_scene("surfaces.nominal_area")),
    ("material.contact_modulus", "number", [-1.0, 0.0], of_scene("material.contact_modulus")),
    ("motion.x_first", "number", [], of_scene("motion.x_first")),
    ("loading.value", "number", [], lambda asperity, value: asperity.solve(
        scene(loading={"control": "load", "value": value}))),
    ("loading.control", "word", ["lode"], of_scene("loading.control")),
    ("loading.points", "whole", [-1], of_scene("loading.points")),
    ("effects.plasticity", "word", ["onn"], of_scene("effects.plasticity")),
    ("effects.tolerance", "number", [0.0, 1.0], of_scene("effects.tolerance")),
]
# A default, on, one radius for all, a path of loads, a list of one.
GOOD_AFTER_ALL = {"radius": [None], "unit": [None], "level": [None], "edge": [None],
                  "spacing": [None, 0.5],
                  "effects.plasticity": [True],
                  "surfaces.upper.radius": [[1.0]], "loading.points": [[1]],
                  "loading.value": [[1.0, 2.0], np.array([1.0, 2.0])]}
COUNTS = r"found \d+ x, \d+ y, \d+ heights and \d+ radii"


def refused(name, kind, further):
    good = GOOD_AFTER_ALL.get(name, [])
    return [value for value in [*BAD[kind], *further]
            if not any(type(value) is type(one) and repr(value) == repr(one) for one in good)]


@pytest.mark.parametrize("name, kind, further, call", ARGUMENTS,
                         ids=[f"{row[0]}-{row[1]}" for row in ARGUMENTS])
def test_refused(package, name, kind, further, call, tmp_path, monkeypatch, capfd):
    """Every bad value is refused before anything is computed, by its name, with what was found and
    what is expected; nothing is printed."""
    np.savetxt(tmp_path / MATRIX, np.random.default_rng(1).normal(size=(9, 9)))
    monkeypatch.chdir(tmp_path)
    values = refused(name, kind, further)
    # The lengths of columns are those of all of a surface.
    surface = name.rpartition(".")[0] if kind == "column" else name
    reported = re.compile(rf"^({re.escape(name)}[^:\n]*: (.*: )?found .+, expected .+|"
                      rf"{re.escape(surface)}: {COUNTS}, expected .+|"
                      rf"{re.escape(name)}[^:\n]*: (unknown|wrong|a value).*expected .+)", re.S)
    for value in values:
        with pytest.raises((package.InputError, TypeError)) as caught:
            call(package, value)
        assert reported.match(str(caught.value)), (value, str(caught.value))
    assert capfd.readouterr() == ("", "")


NUMBERS = [0.75, np.float64(0.75), np.float32(0.75), np.float16(0.75), np.longdouble(0.75),
           decimal.Decimal("0.75"), fractions.Fraction(3, 4), np.array(0.75), np.array(0.75, ">f4"),
           np.ma.masked_array(0.75), memoryview(array.array("d", [0.75]))[0]]


@pytest.mark.parametrize("name", ["loading.value", "material.contact_modulus", "motion.x_first",
                                  "surfaces.upper.radius", "accuracy"])
def test_numbers_of_every_kind(package, name):
    def load(value):
        if name == "accuracy":
            return package.solve(scene(), accuracy=value).positions["load"][0]
        return package.solve(scene(**{name.replace(".", "__"): value})).positions["load"][0]
    assert {load(value) for value in NUMBERS} == {load(0.75)}
    wholes = [2, 2.0, np.int8(2), np.uint64(2), np.array(2), np.float32(2), fractions.Fraction(2)]
    if name != "accuracy":
        assert len({load(value) for value in wholes}) == 1


def test_whole_numbers_of_every_kind(package):
    for two in (2, np.int8(2), np.uint64(2), np.array(2)):
        assert package.solve(scene(loading__points=two), threads=two).states.rows == \
            package.solve(scene(loading__points=2)).states.rows
        with pytest.raises(package.InputError, match="surface: found 2, which is not in the ens"):
            package.generate(SPEC, two)


RADIUS = [2.0, 3.0]
COLUMNS = [tuple, array.array("d", RADIUS), array.array("f", RADIUS), array.array("b", [2, 3]),
           memoryview(array.array("d", RADIUS)), memoryview(array.array("d", [2.0, 0.0, 3.0]))[::2],
           np.array(RADIUS), np.array([2.0, 0.0, 3.0])[::2], np.array([3.0, 2.0])[::-1],
           np.array(RADIUS, ">f8"), np.array(RADIUS, np.float16), np.array([2, 3], np.uint8),
           np.array(RADIUS, np.longdouble), np.array(RADIUS, object), np.ma.masked_array(RADIUS),
           np.array([[2.0, 0.0], [3.0, 0.0]])[:, 0], (2, 3), [np.float32(2), decimal.Decimal(3)],
           range(2, 4)]


def test_columns_of_every_kind(package):
    """Strides, orders of bytes, types and readers: the numbers arrive."""
    expected = package.solve(scene(surfaces__upper__radius=RADIUS)).contacts
    fixed = np.array(RADIUS)
    fixed.flags.writeable = False
    record = np.array([(0.0, 0.0, 1.0, 2.0), (9.0, 0.0, 1.0, 3.0)],
                      [(name, ">f4") for name in ("x", "y", "height", "radius")])
    for radius in [*COLUMNS[1:], tuple(RADIUS), fixed, (value for value in RADIUS)]:
        found = package.solve(scene(surfaces__upper__radius=radius)).contacts
        assert list(found["load"]) == list(expected["load"]) and found.rows == 2
    found = package.solve(scene(surfaces__upper=record)).contacts
    assert list(found["load"]) == list(expected["load"])


def test_paths_of_every_kind(package, tmp_path, monkeypatch):
    """Texts, bytes, path objects, and names that are no UTF-8."""
    monkeypatch.chdir(tmp_path)
    name = os.fsdecode(b"b\xe4lle.csv")
    text = "x,y,height,radius\n0,0,1,2\n"
    (tmp_path / name).write_text(text)
    loads = set()
    for path in (name, os.fsencode(name), pathlib.Path(name), tmp_path / name):
        loads.add(package.solve(scene(surfaces={"upper": path, "lower": "plane"})
                                ).positions["load"][0])
    assert len(loads) == 1
    (tmp_path / f"{name}.scene").write_bytes(
        b"&surfaces upper = 'b\xe4lle.csv', lower = 'plane' / &material contact_modulus = 1000. /"
        b"&loading control = 'approach', value = 0.9 / &effects interaction = 'off' /")
    for path in (f"{name}.scene", os.fsencode(f"{name}.scene"), pathlib.Path(f"{name}.scene")):
        assert package.solve(path).positions["load"][0] in loads
    with pytest.raises(package.InputError, match="surfaces.upper: found 'a.nb', expected a text w"):
        package.solve(scene(surfaces={"upper": "a\nb", "lower": "plane"}))


def test_true_and_false(package):
    """Where on and off are expected."""
    for value in (True, np.True_, False, np.False_):
        done = package.solve(scene(
            material={"elastic_modulus": (1e3, 1e3), "poisson_ratio": (0.3, 0.3)},
            effects={"plasticity": value, "plastic_yield_stress": 1.0, "interaction": "off"}))
        assert ("model: plasticity" in done.summary) == value


@pytest.mark.parametrize("groups, reported", [
    ({"loading__valu": 1.0}, "^loading.valu: unknown name.*did you mean 'value'"),
    ({"loadin": {}}, "^loadin: unknown group"),
    ({"material": {}}, "^material: needs elastic_modulus: "),
    ({"surfaces__upper": {"x": [0], "y": [0], "heights": [1], "radius": 2}},
     "^surfaces.upper: found no height, expected x, y, height and radius; "
     "did you mean 'height' by 'heights'"),
    ({"surfaces__lower": {}}, "^surfaces.lower: found no x, y, height, radius"),
    ({"material__contact_modulus": -0.1}, "found '-0.1', expected a number more than 0$")])
def test_names_in_messages(package, groups, reported):
    with pytest.raises(package.InputError, match=reported):
        package.solve(scene(**groups))


def test_doubles_arrive_exactly(package):
    """At coordinates of 1e7 a compression of 1.7e-5 is a few units of the last place of a double:
    the load of Hertz' law for the double is not that for its shortest decimal."""
    height = 1e7
    value = math.nextafter(height - 1.7e-5, 0)
    cap = {"x": [0.0], "y": [0.0], "height": [height], "radius": [height]}
    for number in (value, np.array(value), fractions.Fraction(value)):
        found = package.solve(
            {"surfaces": {"upper": cap, "lower": "plane"}, "material": {"contact_modulus": 1.0},
             "loading": {"control": "approach", "value": number},
             "effects": {"interaction": "off"}})
        closing = fractions.Fraction(height) - fractions.Fraction(value)
        load = 4 / 3 * math.sqrt(height) * float(closing) ** 1.5
        assert found.positions["load"][0] == pytest.approx(load, rel=1e-12)


def test_summits_of_a_flat_map(package, tmp_path):
    """What has no summits has no mean of them: NaN, not 0."""
    np.savetxt(tmp_path / "flat", np.ones((5, 5)))
    found = package.summits(tmp_path / "flat", spacing=(1.0, 1.0))
    assert found.rows == 0
    for name in ("density", "mean_height", "height_deviation", "mean_curvature", "mean_radius",
                 "alpha", "expected_density"):
        assert math.isnan(found.statistics[name]), name
    assert found.statistics["rms_height"] == 0.0
    shown = dict(re.findall(r"^(\S[^\n]*?)  +(\S+)", found.summary, re.M))
    assert shown["mean summit radius"] == shown["density of summits"] == "-"


def test_summits_of_a_periodic_map(package, asperity, tmp_path):
    """Edge and default level as on the command line; a plane of a periodic map is refused."""
    height = np.random.default_rng(3).normal(size=(12, 16)).round(3)
    np.savetxt(tmp_path / "map", height, fmt="%.3f")
    for edge in ("free", "periodic"):
        subprocess.run([asperity, "summits", tmp_path / "map", "--spacing=1,1", "--edge", edge,
                        "--output", tmp_path / "s.csv", "--quiet"], check=True, timeout=60)
        found = package.summits(tmp_path / "map", spacing=(1.0, 1.0), edge=edge)
        rows = np.loadtxt(tmp_path / "s.csv", delimiter=",", skiprows=1)
        for column, name in enumerate(("x", "y", "height", "radius")):
            assert np.array_equal(np.asarray(found[name]), rows[:, column]), (edge, name)
    with pytest.raises(package.InputError, match="level: .*plane"):
        package.summits(tmp_path / "map", spacing=(1.0, 1.0), edge="periodic", level="plane")
