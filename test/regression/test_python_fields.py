"""Pressure, gap and displacement in Python: the bytes of the files of the command, their places,
states, copies, plots, refusals, and a Python without numpy."""

import copy
import pickle

import matplotlib
import numpy as np
import pytest
from builds import ROOT
from image_data import read_vti
from programs import run_program
from surfaces_csv import write_scene

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]

NAMES = ("pressure", "gap", "displacement")


@pytest.fixture(autouse=True)
def closed_figures():
    yield
    plt.close("all")


def heights():
    """Heights without symmetry, with missing pixels, of few digits."""
    x, y = np.meshgrid(np.arange(18), np.arange(13))
    found = np.round(np.sin(0.9 * x + 0.3 * y) + 0.7 * np.cos(1.1 * y - 0.2 * x), 6)
    found[4, 7:9] = np.nan
    return found


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """A scene of a map with unequal spacing and named units, four states."""
    folder = tmp_path_factory.mktemp("python_fields")
    (folder / "m.txt").write_text("".join(" ".join("BAD" if np.isnan(z) else repr(float(z))
                                                   for z in row) + "\n" for row in heights()))
    return write_scene(
        folder / "m.scene", surfaces={"upper": "plane", "lower": "m.txt", "units": ("um", "uN"),
                                      "map_unit": "um", "map_spacing": (0.5, 0.25)},
        material={"contact_modulus": 100.0}, effects={"interaction": "boundary"},
        loading={"control": "load", "value": 20.0, "points": 3})


@pytest.fixture(scope="module")
def solved(package, path):
    return package.solve(path, fields="all")


def test_all_states_are_those_of_the_files(solved, path, asperity):
    run_program(asperity, "solve", path, "--quiet", "--fields", path.parent / "f.vti",
                "--fields-of", "all")
    assert len(solved.states) == 4
    for number in range(4):
        fields = solved.fields(state=number)
        _, spacing, arrays = read_vti(path.parent / f"f_000{number + 1}.vti")
        for name in NAMES:
            assert np.array_equal(getattr(fields, name), arrays[name].T, equal_nan=True), name
        assert fields.contact.dtype == bool and np.array_equal(fields.contact, arrays["contact"].T)
        assert fields.pressure.shape == fields.shape == (13, 18)
        assert fields.spacing == tuple(spacing[:2]) == (0.5, 0.25)
        assert (fields.position, fields.step) == (1, number + 1)
        assert np.array_equal(np.isnan(fields.gap), np.isnan(heights()))
        assert np.nansum(fields.pressure) * 0.125 == pytest.approx(solved.states["load"][number])
        assert np.nanmean(fields.gap) == pytest.approx(solved.states["mean_gap"][number])
    assert solved.fields() is solved.fields(1, 3) and solved.fields(1, -4).step == 1


def test_units_and_columns(solved):
    fields = solved.fields()
    assert fields.unit == "um"
    assert fields.units == {"pressure": "uN/um2", "gap": "um", "displacement": "um", "contact": ""}
    for table in (solved.positions, solved.states):
        assert [table.units[name] for name in (
            "mean_gap", "rms_gap", "contact_perimeter", "elastic_energy")] == [
                "um", "um", "um", "uN um"]
    assert repr(fields).startswith("<asperity.Fields of 18 x 13 pixels: step 4, pressure 0 to ")
    assert f"{fields.contact.sum()} pixels in contact>" in repr(fields)
    with pytest.raises(ValueError):
        fields.pressure[0, 0] = 1.0


def test_one_state_by_default_and_without_files(package, solved, path):
    """True keeps the last state; a HeightMap in memory gives the same numbers."""
    last = package.solve(path, fields=True)
    for name in (*NAMES, "contact"):
        assert np.array_equal(getattr(last.fields(), name), getattr(solved.fields(), name),
                              equal_nan=True)
    with pytest.raises(IndexError, match="state: found 0, expected -1: the last state alone"):
        last.fields(state=0)
    surface = package.HeightMap(heights(), (0.5, 0.25), "um")
    scene = package.Scene({"surfaces": {"upper": "plane", "lower": surface},
                           "material": {"contact_modulus": 100.0},
                           "effects": {"interaction": "boundary"},
                           "loading": {"control": "load", "value": 20.0, "points": 3}})
    again = scene.solve(fields=True).fields()
    assert np.array_equal(again.pressure, solved.fields().pressure, equal_nan=True)
    assert again.units["pressure"] == "" and again.unit == "um"
    other = scene.solve(loading={"value": 10.0}, fields=True)
    assert np.nansum(other.fields().pressure) * 0.125 == pytest.approx(10.0)


def test_histogram(solved):
    pressure, density = solved.pressure_histogram(bins=7)
    fields = solved.fields()
    pressed = fields.pressure[fields.contact]
    counts, edges = np.histogram(pressed, 7, (0, pressed.max()))
    measured = (~np.isnan(heights())).sum()
    assert np.allclose(pressure, edges[:-1] + edges[1] / 2)
    assert np.allclose(density, counts / measured / edges[1])
    assert len(solved.pressure_histogram()[0]) == 100
    nothing = solved.pressure_histogram(state=0)
    assert not nothing[0].any() and not nothing[1].any()


@pytest.mark.parametrize("way", ["pickle", "copy", "deepcopy"])
def test_copies_keep_the_fields(package, path, way):
    results = package.solve(path, fields="all")
    same = {"pickle": lambda it: pickle.loads(pickle.dumps(it)), "copy": copy.copy,
            "deepcopy": copy.deepcopy}[way](results)
    for state in range(4):
        for name in NAMES:
            assert np.array_equal(getattr(same.fields(state=state), name),
                                  getattr(results.fields(state=state), name), equal_nan=True)


def test_plots(solved):
    fields = solved.fields()
    for name, blank in (("pressure", ~fields.contact), ("gap", fields.contact),
                        ("displacement", np.zeros((13, 18), bool)),
                        ("contact", np.zeros((13, 18), bool))):
        axes = fields.plot(name)
        drawn = axes.images[0]
        assert drawn.get_extent() == [0.0, 9.0, 0.0, 3.25] and drawn.origin == "lower"
        hidden = np.ma.getmaskarray(np.ma.masked_invalid(drawn.get_array()))
        missing = np.isnan(heights()) if name != "contact" else False
        assert np.array_equal(hidden, blank | missing), name
        assert axes.get_xlabel() == "x (um)"
    labels = [other.get_ylabel() for other in fields.plot().figure.axes]
    assert "pressure (uN/um2)" in labels
    with pytest.raises(ValueError, match="name: found 'load', expected 'pressure', 'gap'"):
        fields.plot("load")


def test_refusals(package, solved, path):
    for value in ("last", "ALL"):
        with pytest.raises(ValueError, match=f"fields: found '{value}', expected True, False or"):
            package.solve(path, fields=value)
    with pytest.raises(TypeError, match="fields"):
        package.solve(path, fields=2.5)
    for results in (package.solve(path),
                    package.solve(ROOT / "data/examples/one_pair.scene", fields=True),
                    pickle.loads(pickle.dumps(package.solve(path))),
                    pickle.loads(pickle.dumps(package.solve(
                        ROOT / "data/examples/one_pair.scene", fields="all")))):
        with pytest.raises(package.ComputeError, match="no fields: expected a height map"):
            results.fields()
    with pytest.raises(IndexError, match="position: found 2, expected one of the results"):
        solved.fields(2)
    with pytest.raises(IndexError, match="state: found 4, expected -4 to 3"):
        solved.fields(state=4)
    with pytest.raises(ValueError, match="bins: found 0, expected a number from 1"):
        solved.pressure_histogram(bins=0)


def test_without_numpy(venv, path, solved):
    """Sequences of rows with the same values."""
    program = f"""
import asperity, warnings
warnings.simplefilter("ignore")
results = asperity.solve({str(path)!r}, fields=True)
fields = results.fields()
print(fields.shape, len(fields.gap), len(fields.gap[0]))
print(repr(fields.gap[2][3]), fields.contact[2][3] is False or fields.contact[2][3] is True)
pressure, density = results.pressure_histogram(bins=5)
print(sum(density) * pressure[0] * 2)
print(fields)
"""
    done = run_program(venv / "bin/python", "-c", program)
    lines = done.stdout.splitlines()
    assert lines[0] == "(13, 18) 13 18"
    assert lines[1] == f"{float(solved.fields().gap[2, 3])!r} True"
    measured = (~np.isnan(heights())).sum()
    assert float(lines[2]) == pytest.approx(solved.fields().contact.sum() / measured)
    assert lines[3] == repr(solved.fields())
