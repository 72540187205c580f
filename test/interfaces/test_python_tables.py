"""Tables, columns and drawings of the Python package, with numpy and without it."""

import copy
import gc
import json
import pickle
import warnings

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from builds import ROOT
from programs import run_program

pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]

SPHERE = {"x": [0.0], "y": [0.0], "height": [1.0], "radius": [10.0]}
CURVE = {"surfaces": {"upper": SPHERE, "lower": "plane", "units": ("mm", "N")},
         "material": {"contact_modulus": 1000.0},
         "loading": {"control": "compression", "value": 0.01, "points": 4}}
# Hertz: P = 4/3 E sqrt(R) d**1.5, area pi R d.
COMPRESSION = 0.01 * np.arange(5) / 4
LOAD = 4 / 3 * 1000.0 * np.sqrt(10.0) * COMPRESSION**1.5


@pytest.fixture
def results(package):
    return package.solve(CURVE)


def test_float_of_a_column_with_one_row(results):
    """As numpy before 2.4 did; the value at a place is a `float`, which compares to a `bool`.
    Calculations, copies and repr are those of any array."""
    assert {"positions", "states", "contacts", "scene"} <= set(dir(results))
    column = results.positions["load"]
    assert float(column) == pytest.approx(LOAD[-1], rel=1e-12)
    assert isinstance(column, np.ndarray) and repr(column).startswith("array([4.21")
    for made in (column * 2, np.sqrt(column), np.concatenate([column, column])):
        assert type(made) is np.ndarray
    for made in (column.sum(), column.max(), np.mean(column)):
        assert type(made) is np.float64
    assert type(column[0]) is type(column[-1]) is float and type(column[0] > 1) is bool
    for same in (copy.copy(results.positions), copy.deepcopy(results.positions),
                 pickle.loads(pickle.dumps(results.positions))):
        assert float(same["load"]) == float(column) and not same["load"].flags.writeable
    assert pickle.loads(pickle.dumps(column)) == column
    assert int(results.positions["steps"]) == 5


def test_columns_compute(results):
    """Arithmetic, comparison, boolean and list indexing, slices and plot of a column."""
    load, compression = results.states["load"], results.states["compression"]
    assert isinstance(load, np.ndarray) and load.dtype == np.float64
    assert np.allclose(load * 2, 2 * LOAD, rtol=1e-12)
    assert np.allclose(compression, COMPRESSION, rtol=1e-9, atol=1e-12)
    assert load[load > 1.0].tolist() == load.tolist()[2:] and load[[0, 1]][0] == 0
    assert load.mean() == pytest.approx(LOAD.mean(), rel=1e-12)
    [line] = plt.plot(results.states["separation"], load)
    assert np.array_equal(line.get_ydata(), load)
    with pytest.raises(ValueError, match="read-only"):
        load[0] = 1.0


def test_arrays_outlive_their_results(package):
    """Columns use the memory of the library, without a copy, and keep it."""
    results = package.solve(CURVE)
    load, again = results.states["load"], np.asarray(results.states["load"])
    assert np.shares_memory(load, again)
    part = load[2:]
    del results, load, again
    gc.collect()
    filler = [package.solve(CURVE) for _ in range(20)]
    assert np.allclose(part, LOAD[2:], rtol=1e-12) and len(filler) == 20


def test_rows(results):
    """`len`, rows, lists of rows."""
    states = results.states
    assert len(states) == states.rows == 5 and bool(states)
    rows = list(states.rows())
    assert [row["load"] for row in rows] == states["load"].tolist()
    assert list(rows[0]) == list(states) and isinstance(rows[0]["contacts"], int)
    without = results.contacts.__class__()
    assert len(without) == 0 and not without and list(without.rows()) == []


def test_to_pandas_and_numpy(results):
    """The table as a DataFrame by three ways, and as a structured array."""
    frame = results.states.to_pandas()
    assert pd.DataFrame(results.states).equals(frame) and results.to_pandas().equals(frame)
    assert list(frame) == list(results.states) and len(frame) == 5
    assert np.allclose(frame["load"], LOAD, rtol=1e-12)
    assert frame.attrs["units"]["load"] == "N"
    array = np.asarray(results.states)
    assert array.shape == (5,) and np.array_equal(array["load"], results.states["load"])
    assert pd.DataFrame(array).equals(frame)


def test_to_dict(results):
    """Lists and texts that `json` writes: a number that was not computed is null there."""
    found = json.loads(json.dumps(results.to_dict(), allow_nan=False))
    for table in ("positions", "states", "contacts"):
        for name, cells in getattr(results, table).items():
            assert found[table][name] == [None if cell != cell else cell
                                          for cell in cells.tolist()]
    assert any(None in cells for cells in found["positions"].values())
    assert found["states"]["load"] == results.states["load"].tolist()
    assert found["units"]["states"]["load"] == "N" and found["summary"] == results.summary
    assert set(found) == {"positions", "states", "contacts", "units", "summary", "warnings",
                          "notes", "scene"}


def test_units_and_labels(package, results):
    units = results.states.units
    assert (units["load"], units["area"], units["separation"], units["contacts"]) == (
        "N", "mm2", "mm", "")
    assert results.contacts.units["maximum_pressure"] == "MPa"
    assert results.states.label("projected_area") == "projected area (mm2)"
    assert results.states.label("contacts") == "contacts"
    unnamed = {**CURVE, "surfaces": {"upper": SPHERE, "lower": "plane"}}
    assert package.solve(unnamed).states.units["load"] == ""


def test_unknown_column(results):
    with pytest.raises(KeyError, match="did you mean 'separation'"):
        results.states["seperation"]
    with pytest.raises(KeyError, match="no column 'q' in the table of states: position, step"):
        results.states["q"]


def test_repr(package, results):
    """One line with the facts; tables with units in a notebook."""
    for thing in (results, results.states, results.contacts, package.Scene(CURVE),
                  package.HeightMap(np.eye(3), 1.0), package.Table()):
        assert "\n" not in repr(thing) and "0x" not in repr(thing), repr(thing)
    assert repr(results).startswith("<asperity.Results: 1 position, 5 states, load 4.2163")
    text = results._repr_html_()
    assert text.count("<tr>") == 7 and "<td>N</td>" in text and "<pre>" in text
    long = package.Table({"n": np.arange(1000)}, name="<rows>")._repr_html_()
    assert long.count("<tr>") < 20 and "1000 &lt;rows&gt;" in long


def test_warnings_in_a_notebook(package):
    results = package.solve(ROOT / "data/examples/thesis.scene")
    assert f"{len(results.warnings)} warnings" in repr(results)
    assert results._repr_html_().count("<li>") == len(results.warnings) == 3


def test_plot(results):
    """Load against separation, area against load, with units; on axes that are given."""
    left, right = results.plot()
    assert (left.get_xlabel(), left.get_ylabel()) == ("separation (mm)", "load (N)")
    assert (right.get_xlabel(), right.get_ylabel()) == ("load (N)", "contact area (mm2)")
    assert np.array_equal(left.lines[0].get_ydata(), results.states["load"])
    assert np.array_equal(right.lines[0].get_xdata(), results.states["load"])
    _, axes = plt.subplots(1, 2)
    assert results.plot(ax=axes)[1] is axes[1] and len(axes[0].lines) == 1


def test_plot_of_positions(package):
    """One curve a position; a legend while they are few."""
    scene = {**CURVE, "motion": {"x_step": 0.001, "positions": 3}}
    left, _ = package.solve(scene).plot()
    assert [line.get_label() for line in left.lines] == [f"position {i}" for i in (1, 2, 3)]


def test_plot_contacts(package):
    """Circles at the place of the contacts, with their area; pressure as colour."""
    scene = ROOT / "data/examples/thesis.scene"
    results = package.solve(scene)
    table = results.contacts
    axes = results.plot_contacts(position=56)
    mine = (table["position"] == 56) & (table["load"] > 0)
    drawn = axes.collections[0]
    sizes = sorted(path.get_extents().width for path in drawn.get_paths())
    assert np.allclose(sizes, sorted(2 * np.sqrt(table["area"][mine] / np.pi)), rtol=1e-3)
    assert np.array_equal(drawn.get_array(), table["maximum_pressure"][mine])
    assert axes.get_xlabel() == "x (cm)"
    _, own = plt.subplots()
    assert results.plot_contacts(1, ax=own, step=1) is own
    own = results.states.plot_columns("load", "contacts", color="k")
    assert (own.get_xlabel(), own.get_ylabel()) == ("load (N)", "contacts")
    assert np.array_equal(own.lines[0].get_ydata(), results.states["contacts"])
    with pytest.raises(IndexError, match="position: found 101"):
        results.plot_contacts(101)
    with pytest.raises(IndexError, match="step: found 8, expected 1 to "):
        results.plot_contacts(1, step=8)


def test_one_warning_a_line_and_kind(package):
    """Two classes; each kind once for each line of code, whatever its numbers; pointing here."""
    def solve(load):
        return package.solve({**CURVE, "surfaces": {
            "upper": {"x": [0.0, 0.05], "y": [0.0, 0.0], "height": [1.0, 1.0], "radius": [1.0] * 2},
            "lower": "plane", "nominal_area": 100.0}, "loading": {"control": "load", "value": load},
            "effects": {"interaction": False}})
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("default")
        for load in (1.0, 2.0, 3.0):
            results = solve(load)
    kinds = {one.category for one in found}
    assert kinds == {package.TheoryWarning, package.AccuracyWarning}
    assert len(found) == len(results.warnings) and {one.filename for one in found} == {__file__}
    assert all(str(one.message).startswith("position 1: ") for one in found)
    assert all("\n" not in str(one.message) for one in found)
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        for load in (1.0, 2.0):
            solve(load)
    assert len(found) == 2 * len(results.warnings)
    with warnings.catch_warnings(), pytest.raises(package.AccuracyWarning):
        warnings.simplefilter("error", package.AccuracyWarning)
        solve(1.0)


WITHOUT = """
import sys
for name in ("numpy", "pandas", "matplotlib", "tqdm", "SurfaceTopography"):
    sys.modules[name] = None
import asperity, copy, json, pickle
results = asperity.solve(SCENE)
states = results.states
load = states["load"]
assert len(load) == len(states) == 5 and load[-1] == load[4:][0]
assert [value > 1 for value in load] == (load > 1) and load == load.tolist()
assert (load == 0.0) == [True, False, False, False, False]
assert copy.deepcopy(states) == states == pickle.loads(pickle.dumps(states))
assert json.loads(json.dumps(results.to_dict()))["states"]["load"] == load.tolist()
assert [row["load"] for row in states.rows()] == load.tolist()
pixels = [[0.0, 1.0, 0.0, 0.5], [0.0, 0.0, 2.0, 0.0], [float("nan"), 0.0, 0.0, 1.0]]
surface = asperity.HeightMap(pixels, 0.5, "um")
assert surface.shape == (3, 4) and surface.heights[1][2] == 2.0
assert pickle.loads(pickle.dumps(surface)).heights[1] == pixels[1]
found = asperity.summits(surface, level="none")
assert (found["x"][0], found["y"][0]) == (1.0, 0.5), found["x"]
pressed = asperity.solve({"surfaces": {"upper": "plane", "lower": pixels, "map_spacing": 0.5},
    "material": {"contact_modulus": 100.0}, "loading": {"control": "vertical_load", "value": 1.0},
    "effects": {"interaction": "boundary"}})
assert abs(pressed.states["load"][-1] - 1) < 1e-6
fields = asperity.solve({"surfaces": {"upper": "plane", "lower": surface},
    "material": {"contact_modulus": 100.0}, "loading": {"control": "load", "value": 1.0},
    "effects": {"interaction": "boundary"}}, fields=True).fields()
assert fields.shape == (len(fields.gap), len(fields.gap[0])) == (3, 4)
assert fields.contact[1][2] is True and fields.contact[1][1] is False
assert sum(value * 0.25 for row in fields.pressure for value in row if value > 0) > 0.999
for call in (states.to_pandas, results.plot, surface.plot, lambda: states.__array__()):
    try:
        call()
    except ImportError as error:
        assert "pip install" in str(error)
    else:
        raise AssertionError(call)
print(repr(results), repr(surface), results._repr_html_()[:7])
print(load, states["contacts"])
"""


def test_without_numpy(venv):
    """In a venv that has nothing else: the package solves lists, and prints columns."""
    done = run_program(venv / "bin/python", "-W", "ignore", "-c",
                       WITHOUT.replace("SCENE", repr(CURVE)))
    numbers, _, counts = done.stdout.splitlines()[-1].partition("] ")
    assert np.allclose([float(word) for word in numbers[1:].split(",")], LOAD, rtol=1e-12)
    assert counts == "[1, 1, 1, 1, 1]"
