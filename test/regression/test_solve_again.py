"""Scenes that are changed and solved again through the C interface: the same results with and
without an earlier outcome, fewer iterations, units, classes of warnings, progress, an end."""

import ctypes
import threading
from ctypes import POINTER, Structure, byref, c_char_p, c_double, c_int, c_void_p

import numpy as np
import pytest
from builds import ROOT

# Says nothing about the build under test: the package has the release build.
pytestmark = pytest.mark.once

FAILURE, PROBLEMS, WARNINGS, REPORT, WARNING_KINDS, GROUPS = 1, 2, 3, 5, 6, 8
POSITIONS, STATES, CONTACTS, SUMMITS, STATISTICS, UPPER, LOWER = 1, 2, 3, 4, 5, 6, 7
# Two random surfaces whose summits keep a distance, and two whose summits may nearly coincide.
APART = "number = 400, length = 29., width = 29., least_distance = 0.762"
PACKED = "number = 300, length = 14., width = 14., least_distance = 0."
SPEC = """&surfaces {} / &radii mean = 1.27, deviation = 0.1, lowest = 0.8, highest = 1.8 /
&heights mean = 0.127, deviation = 0.03, lowest_deviation = -1., highest_deviation = 1.9 /
&random seed = {} /"""
TEXT = "&material contact_modulus = {modulus} / &loading control = '{control}', value = {value} /" \
    " &motion positions = {positions}, x_step = 0.4 / &effects {effects} /"
COUPLED = {"modulus": 1e5, "control": "load", "positions": 1, "effects": "interaction = 'coupled'"}
# What the solver leaves of its equations, over the deepest penetration, is at most 1e-9.
NEAR = 5e-9


class Surface(Structure):
    _fields_ = [("count", c_int), ("radii", c_int)] + [
        (name, POINTER(c_double)) for name in ("x", "y", "height", "radius")]


class Options(Structure):
    _fields_ = [("arithmetic", c_char_p), ("accuracy", c_double), ("totals_only", c_int),
                ("threads", c_int), ("interrupt", POINTER(c_int)), ("accuracy_of", c_char_p)]


@pytest.fixture(scope="module")
def c(venv):
    """The shared library of the package."""
    return library_at(next(venv.glob("lib/python*/site-packages/asperity/libasperity.so")))


def library_at(path):
    """The library with the types of its functions."""
    library = ctypes.CDLL(str(path))
    for name, result, *arguments in (
            ("read_scene", c_void_p, c_char_p),
            ("build_scene", c_void_p, c_char_p, POINTER(Surface), POINTER(Surface)),
            ("rebuild_scene", c_void_p, c_void_p, c_char_p),
            ("solve_scene", c_void_p, c_void_p, POINTER(Options)),
            ("solve_again", c_void_p, c_void_p, POINTER(Options), c_void_p, POINTER(c_int)),
            ("generate", c_void_p, c_char_p, c_char_p, c_int),
            ("summits", c_void_p, c_char_p, c_void_p),
            ("status", c_int, c_void_p), ("text", c_char_p, c_void_p, c_int),
            ("rows", c_int, c_void_p, c_int), ("columns", c_int, c_void_p, c_int),
            ("column_name", c_char_p, c_void_p, c_int, c_int),
            ("column_unit", c_char_p, c_void_p, c_int, c_int),
            ("column_type", c_int, c_void_p, c_int, c_int),
            ("column", c_void_p, c_void_p, c_int, c_int), ("free", None, c_void_p)):
        function = getattr(library, f"asperity_{name}")
        function.restype, function.argtypes = result, arguments
    return library


def text(c, outcome, which):
    return c.asperity_text(outcome, which).decode()


def done(c, outcome):
    assert c.asperity_status(outcome) == 0, text(c, outcome, FAILURE) + text(c, outcome, PROBLEMS)
    return outcome


def table(c, outcome, which):
    """Columns of numbers, as copies."""
    rows, columns = c.asperity_rows(outcome, which), {}
    for i in range(c.asperity_columns(outcome, which)):
        kind = {1: c_double, 2: c_int}.get(c.asperity_column_type(outcome, which, i))
        if kind and rows:
            cells = ctypes.cast(c.asperity_column(outcome, which, i), POINTER(kind))
            name = c.asperity_column_name(outcome, which, i).decode()
            columns[name] = np.ctypeslib.as_array(cells, (rows,)).copy()
    return columns


def units(c, outcome, which):
    return {c.asperity_column_name(outcome, which, i).decode():
            c.asperity_column_unit(outcome, which, i).decode()
            for i in range(c.asperity_columns(outcome, which))}


def random_sides(c, surfaces, seed):
    """Two random surfaces."""
    made = done(c, c.asperity_generate(None, SPEC.format(surfaces, seed).encode(), 1))
    sides = []
    for side in (UPPER, LOWER):
        columns = table(c, made, side)
        sides.append(Surface(len(columns["x"]), len(columns["x"]), *(
            columns[name].ctypes.data_as(POINTER(c_double)) for name in columns)))
        sides[-1].kept = columns
    c.asperity_free(made)
    return sides


def built(c, sides, **choices):
    return done(c, c.asperity_build_scene(groups(**choices), *map(byref, sides)))


def random_scene(c, surfaces, seed, **choices):
    """A scene of two random surfaces."""
    return built(c, random_sides(c, surfaces, seed), **choices)


def groups(**choices):
    return TEXT.format(**{**COUPLED, "value": 1e4, **choices}).encode()


def compare(c, base, changes, threads=1):
    """Solves a scene with its changes one after the other, alone and with the outcome before.
    Returns the largest relative differences by column, and both sums of iterations."""
    earlier, worst, iterations = None, {}, [0, 0]
    options = byref(Options(threads=threads))
    for change in changes:
        scene = done(c, c.asperity_rebuild_scene(base, groups(**change)))
        alone = done(c, c.asperity_solve_scene(scene, options))
        again = done(c, c.asperity_solve_again(scene, options, earlier, None))
        c.asperity_free(earlier)
        c.asperity_free(scene)
        earlier = again
        one, other = (table(c, outcome, POSITIONS) for outcome in (alone, again))
        contacts = [table(c, outcome, CONTACTS) for outcome in (alone, again)]
        for name in ("upper", "lower"):
            assert np.array_equal(contacts[0][name], contacts[1][name])
        for name in ("load", "vertical_load", "compression", "area"):
            off = np.max(np.abs(one[name] - other[name]) / np.abs(one[name]))
            worst[name] = max(off, worst.get(name, 0.0))
        for i, columns in enumerate((one, other)):
            iterations[i] += np.nansum(columns.get("interaction_iterations", [0]))
        c.asperity_free(alone)
    c.asperity_free(earlier)
    return worst, iterations


LOADS = np.linspace(2e4, 6e4, 12)
RANDOM = np.random.default_rng(7)
ORDERS = {"up": LOADS, "down": LOADS[::-1],
          "random": np.concatenate([RANDOM.permutation(LOADS) for _ in range(4)])}


@pytest.mark.parametrize("order", ORDERS)
def test_loads(c, order):
    """Loads up, down and in random order: the same contacts and totals with fewer iterations."""
    base = random_scene(c, APART, 3)
    worst, (alone, again) = compare(c, base, [{"value": load} for load in ORDERS[order]])
    print(order, worst, alone, again)
    assert max(worst.values()) < NEAR and worst["load"] < 1e-11
    # In random order the start is farther off.
    assert again <= (0.85 if order == "random" else 0.8) * alone


@pytest.mark.long
@pytest.mark.parametrize("seed", range(1, 4))
def test_contacts_that_nearly_coincide(c, seed):
    """Near contacts have several solutions: the one that is found does not depend on the start."""
    base = random_scene(c, PACKED, seed)
    loads = np.random.default_rng(seed).uniform(1e3, 1e5, 12)
    worst, _ = compare(c, base, [{"value": load} for load in loads])
    assert max(worst.values()) < NEAR


CHANGES = {
    "control": [{"value": 3e4}, {"control": "compression", "value": 0.08},
                {"control": "compression", "value": 0.09}, {"control": "vertical_load",
                                                            "value": 3.5e4}],
    "modulus": [{"value": 3e4}, {"value": 3e4, "modulus": 1.1e5}, {"value": 3e4, "modulus": 1.2e5}],
    "effects": [{"value": 3e4}, {"value": 3.1e4, "effects": "interaction = 'auto'"},
                {"value": 3.2e4, "effects": "interaction = 'auto', tolerance = 0.003"},
                {"value": 3.3e4, "effects": "interaction = 'off'"}, {"value": 3.4e4}],
    "positions": [{"value": load, "positions": 3} for load in (3e4, 3.2e4, 3.4e4)],
    "fewer positions": [{"value": 3e4, "positions": number} for number in (1, 3, 2)],
}


@pytest.mark.parametrize("change", CHANGES)
def test_other_changes(c, change):
    """Other control, modulus, effects, tolerance, positions."""
    worst, iterations = compare(c, random_scene(c, APART, 4), CHANGES[change], threads=2)
    print(change, worst, iterations)
    assert max(worst.values()) < NEAR


def test_memory_of_contacts(c):
    """Paths and effects that remember begin anew: every byte is that of a solve alone."""
    base = random_scene(c, APART, 5)
    for value, effects in ((3e4, "interaction = 'coupled', work_of_adhesion = 0.5"),
                           (3e4, "interaction = 'coupled', plasticity = 'on', hardness = 1e4"),
                           ("3e4, 1e4, 2e4", "interaction = 'coupled'")):
        scene = c.asperity_rebuild_scene(base, groups(value=value, effects=effects))
        first = c.asperity_solve_scene(base, None)
        alone, again = c.asperity_solve_scene(scene, None), c.asperity_solve_again(
            scene, None, first, None)
        assert text(c, alone, FAILURE) == text(c, again, FAILURE)
        for which in (POSITIONS, STATES, CONTACTS):
            one, other = table(c, alone, which), table(c, again, which)
            assert all(np.array_equal(one[name], other[name], equal_nan=True) for name in one)


def test_outcomes_of_other_scenes(c):
    """An earlier outcome of other surfaces, of a scene that was read, or that failed is left
    alone: every byte is that of a solve alone."""
    scene, other = random_scene(c, APART, 5, value=3e4), random_scene(c, APART, 6, value=3e4)
    alone = table(c, done(c, c.asperity_solve_scene(scene, None)), POSITIONS)
    failed = c.asperity_solve_scene(c.asperity_rebuild_scene(scene, groups(value=1e30)), None)
    assert c.asperity_status(failed) == 1
    for earlier in (done(c, c.asperity_solve_scene(other, None)), scene, failed):
        again = table(c, done(c, c.asperity_solve_again(scene, None, earlier, None)), POSITIONS)
        assert all(np.array_equal(alone[name], again[name], equal_nan=True) for name in alone)


@pytest.mark.parametrize("ratio, begins_anew", [(1.45, False), (1.55, True)])
def test_a_far_load_begins_anew(c, ratio, begins_anew):
    """Above 1.5 times the load**(2/3) of the earlier outcome a solve begins as one alone."""
    base = random_scene(c, APART, 5, value=2e4)
    first = done(c, c.asperity_solve_scene(base, None))
    scene = done(c, c.asperity_rebuild_scene(base, groups(value=2e4 * ratio ** 1.5)))
    alone = table(c, done(c, c.asperity_solve_scene(scene, None)), CONTACTS)
    again = table(c, done(c, c.asperity_solve_again(scene, None, first, None)), CONTACTS)
    assert begins_anew == all(np.array_equal(alone[name], again[name]) for name in alone)


def test_two_threads_share_an_outcome(c):
    """Solves at once with the same earlier outcome give what one gives after the other."""
    base = random_scene(c, APART, 8, value=3e4)
    first = done(c, c.asperity_solve_scene(base, None))
    scenes = [done(c, c.asperity_rebuild_scene(base, groups(value=3e4 + 500 * i)))
              for i in range(8)]
    options = Options(threads=1)

    def solve(i):
        return table(c, done(c, c.asperity_solve_again(scenes[i], byref(options), first, None)),
                     CONTACTS)
    expected, found = [solve(i) for i in range(8)], [None] * 8

    def work(numbers):
        for i in numbers:
            found[i] = solve(i)
    threads = [threading.Thread(target=work, args=(range(k, 8, 2),)) for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=100)
    for one, other in zip(expected, found):
        assert all(np.array_equal(one[name], other[name], equal_nan=True) for name in one)


# ---------------------------------------------------------------- groups, units, warnings

SCENES = ["data/examples/thesis.scene", "data/thesis.deck",
          "data/examples/summits/press_samples.scene", "data/examples/csv_surfaces.scene"]


def as_text(lines):
    """The text of a scene from its groups as a table."""
    names = {}
    for line in lines.splitlines():
        group, name, values = line.split("\t")
        names.setdefault(group, []).append(f"{name} = {values}")
    return "".join(f"&{group} {', '.join(all_names)} /\n" for group, all_names in names.items())


@pytest.mark.parametrize("path", SCENES)
def test_groups(c, path):
    """A scene made anew from its groups as a table gives the same report and the same table."""
    scene = done(c, c.asperity_read_scene(str(ROOT / path).encode()))
    lines = text(c, scene, GROUPS)
    again = done(c, c.asperity_rebuild_scene(scene, as_text(lines).encode()))
    assert text(c, again, GROUPS) == lines != ""
    reports = [text(c, done(c, c.asperity_solve_scene(one, None)), REPORT)
               for one in (scene, again)]
    assert reports[0] == reports[1]


def test_rebuilt_scenes(c, tmp_path):
    """The surfaces are not read again, and what their group says stays; the rest is new."""
    for name in ("upper", "lower"):
        (tmp_path / f"{name}.csv").write_text("x,y,height\n0,0,1\n3,0,0.9\n", encoding="ascii")
    (tmp_path / "a.scene").write_text(
        "&surfaces upper = 'upper.csv', lower = 'lower.csv', radius = 5., 5., nominal_area = 12.,\n"
        "units = 'mm', 'N' / ! a comment\n&material elastic_modulus = 2*1e3,\n  poisson_ratio ="
        " 0.3, 0.4 /\n&tilt upper_slope = 0.1, 0. /\n&loading control = 'load', value = 1. /\n",
        encoding="ascii")
    scene = done(c, c.asperity_read_scene(str(tmp_path / "a.scene").encode()))
    assert "material\telastic_modulus\t2*1e3\nmaterial\tpoisson_ratio\t0.3, 0.4\n" \
        in text(c, scene, GROUPS)
    (tmp_path / "upper.csv").unlink()
    changed = done(c, c.asperity_rebuild_scene(
        scene, b"&material contact_modulus = 1e3 / &loading control = 'pressure', value = 0.5 /"))
    solved = done(c, c.asperity_solve_scene(changed, None))
    assert abs(table(c, solved, POSITIONS)["vertical_load"][0] - 6.0) < 1e-6
    assert units(c, solved, POSITIONS)["nominal_pressure"] == "MPa"
    # Without the tilt both pairs are level with each other: 3 mm apart, 0.2 mm deep.
    assert table(c, solved, CONTACTS)["slope"][0] == 0.0
    bad = c.asperity_rebuild_scene(scene, b"&loading control = 'load', value = -1. /")
    assert c.asperity_status(bad) == 2
    assert "needs elastic_modulus" in text(c, bad, PROBLEMS) and ":1:" in text(c, bad, PROBLEMS)
    for wrong in (c.asperity_rebuild_scene(None, b""), c.asperity_rebuild_scene(scene, None),
                  c.asperity_rebuild_scene(solved, b"")):
        assert c.asperity_status(wrong) == 2 and "expected" in text(c, wrong, PROBLEMS)


def test_units(c):
    """Of positions, states, contacts, effects and summits; none where none is known."""
    path = ROOT / "data/examples/effects"
    scene = done(c, c.asperity_read_scene(str(path / "adhesion.scene").encode())) \
        if (path / "adhesion.scene").exists() else done(
            c, c.asperity_read_scene(str(ROOT / SCENES[0]).encode()))
    solved = done(c, c.asperity_solve_scene(scene, None))
    known = {"load": "force", "area": "area", "separation": "length", "average_pressure":
             "pressure", "slope": "", "contacts": "", "pull_off_force": "force", "time": ""}
    length, force = "cm", "N"
    named = {"length": length, "force": force, "area": f"{length}2",
             "pressure": f"{force}/{length}2", "": ""}
    found = {**units(c, solved, POSITIONS), **units(c, solved, STATES),
             **units(c, solved, CONTACTS)}
    assert {name: found[name] for name in known if name in found} == {
        name: named[unit] for name, unit in known.items() if name in found}
    assert c.asperity_column_unit(solved, 99, 0) == c.asperity_column_unit(None, 1, 0) == b""
    summits = done(c, c.asperity_summits(str(ROOT / "data/examples/summits/smooth.sdf").encode(),
                                         None))
    of_map = {**units(c, summits, SUMMITS), **units(c, summits, STATISTICS)}
    unit = of_map["x"]
    assert unit in ("m", "um") and of_map["density"] == f"1/{unit}2" and of_map["m0"] == f"{unit}2"
    assert of_map["mean_curvature"] == f"1/{unit}" and of_map["alpha"] == of_map["m2_x"] == ""
    plain = done(c, c.asperity_solve_scene(random_scene(c, APART, 1, value=1e3), None))
    assert set(units(c, plain, CONTACTS).values()) == {""}


def test_classes_of_warnings(c):
    """One line a warning, in the same order, of a theory or of accuracy."""
    solved = done(c, c.asperity_solve_scene(
        done(c, c.asperity_read_scene(str(ROOT / SCENES[0]).encode())), None))
    kinds = [line.split() for line in text(c, solved, WARNING_KINDS).splitlines()]
    lines = text(c, solved, WARNINGS).splitlines()
    assert kinds == [["overlapping", "theory"], ["load_direction", "theory"], ["off", "accuracy"]]
    assert len(lines) == 3 and "interaction is off, 39.8 %" in lines[2]


# ---------------------------------------------------------------- progress and an end
