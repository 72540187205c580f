"""Pressure, gap and displacement in Python: the bytes of the files of the command, their places,
states, copies, plots, refusals, and a Python without numpy."""

import copy
import math
import pickle

import numpy as np
import pytest
from builds import ROOT
from image_data import read_vti
from programs import run_program
from surfaces_csv import write_scene

pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]

NAMES = ("pressure", "gap", "displacement")


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
        fields = solved.fields(step=number + 1)
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
    steps = solved.states["step"]
    assert [solved.fields(step=step).step for step in steps] == steps.tolist() == [1, 2, 3, 4]
    assert solved.fields() is solved.fields(1, -1) is solved.fields(step=4)
    assert solved.fields(1, step=-4).step == solved.fields(step=-4).step == 1


def test_positions_of_moved_maps(package, asperity, tmp_path):
    """Free maps that move: fields of the last state of each position, or of all, at their places;
    the file of a state is that of its row."""
    for name, seed in (("u", 1), ("l", 2)):
        np.save(tmp_path / f"{name}.npy", np.random.default_rng(seed).normal(size=(8, 8)))
    scene = write_scene(
        tmp_path / "m.scene", surfaces={"upper": "u.npy", "lower": "l.npy", "map_spacing": 0.5},
        material={"contact_modulus": 100.0}, effects={"interaction": "boundary"},
        motion={"x_step": 1.0, "positions": 3},
        loading={"control": "load", "value": 20.0, "points": 2})
    run_program(asperity, "solve", scene, "--quiet", "--json", tmp_path / "m.json", "--fields",
                tmp_path / "f.vti", "--fields-of", "all")
    last, every = (package.solve(scene, fields=kept) for kept in (True, "all"))
    read = package.load(tmp_path / "m.json",
                        fields=[tmp_path / f"f_000{i}.vti" for i in range(1, 10)])
    for results in (last, pickle.loads(pickle.dumps(last)), every, read):
        assert list(results.to_xarray()["load"]) == pytest.approx(
            [20.0] * 3 if results is not every and results is not read else [0.0, 10.0, 20.0] * 3)
        for position in (1, 2, 3):
            fields = results.fields(position)
            assert (fields.shape, fields.origin) == ((8, 10 - 2 * position), (position - 1.0, 0.0))
            assert fields.pressure.sum() * 0.25 == pytest.approx(20.0)
            assert np.array_equal(fields.pressure, every.fields(position, step=3).pressure)
            rows = results.contacts["position"] == position
            assert fields.pressure.max() == pytest.approx(
                results.contacts["maximum_pressure"][rows].max())


def test_names_of_fields(solved):
    """By name as by attribute; a dict of them."""
    fields = solved.fields()
    assert list(fields) == list(dict(fields)) == [*NAMES, "contact"]
    assert all(fields[name] is getattr(fields, name) for name in fields)
    with pytest.raises(KeyError, match="no field 'load': pressure, gap"):
        fields["load"]


def test_units_and_columns(solved):
    fields = solved.fields()
    assert fields.unit == "um"
    assert fields.units == {"pressure": "MPa", "gap": "um", "displacement": "um", "contact": ""}
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
    with pytest.raises(IndexError, match="step: found 1, expected -1: the last state alone"):
        last.fields(step=1)
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
    nothing = solved.pressure_histogram(step=1)
    assert not nothing[0].any() and not nothing[1].any()


@pytest.mark.parametrize("bins", [7, 50, 100])
def test_histogram_has_the_greatest_pressure(package, bins):
    """All pixels at the hardness are in the last bin, also where bins (H/bins) < H by rounding."""
    rough = np.random.default_rng(0).normal(size=(16, 16)) * 0.01
    for hardness in (813.9000000000005, 1471.1, 900.0):
        results = package.solve({
            "surfaces": {"upper": "plane", "lower": rough, "map_spacing": 1.0},
            "material": {"contact_modulus": 1e5}, "loading": {"control": "pressure", "value": 50.0},
            "effects": {"interaction": "boundary", "plastic_hardness": hardness}}, fields=True)
        pressure = results.fields().pressure
        _, density = results.pressure_histogram(bins=bins)
        counts = density * pressure.max() / bins * pressure.size
        assert counts.sum() == pytest.approx((pressure > 0).sum())
        assert counts[-1] == pytest.approx((pressure > pressure.max() * (1 - 1 / bins)).sum())


def test_plots(solved):
    fields = solved.fields()
    for name, blank in (("pressure", ~fields.contact), ("gap", fields.contact),
                        ("displacement", np.zeros((13, 18), bool)),
                        ("contact", np.zeros((13, 18), bool))):
        axes = fields.plot(name)
        drawn = axes.images[0]
        assert list(drawn.get_extent()) == [-0.25, 8.75, -0.125, 3.125] and drawn.origin == "lower"
        hidden = np.ma.getmaskarray(np.ma.masked_invalid(drawn.get_array()))
        missing = np.isnan(heights()) if name != "contact" else False
        assert np.array_equal(hidden, blank | missing), name
        assert axes.get_xlabel() == "x (um)"
    labels = [other.get_ylabel() for other in fields.plot().figure.axes]
    assert "pressure (MPa)" in labels
    with pytest.raises(ValueError, match="name: found 'load', expected 'pressure', 'gap'"):
        fields.plot("load")


def test_contacts_of_pixels(package, solved, path):
    """A patch of a map is no circle: its pressure where that was kept, else its centre."""
    assert np.array_equal(solved.plot_contacts(step=3).images[0].get_array().filled(0.0),
                          np.nan_to_num(solved.fields(step=3).pressure))
    results = package.solve(path)
    axes = results.plot_contacts(step=2)
    rows = results.contacts["step"] == 2
    assert not axes.images and np.array_equal(
        axes.collections[0].get_offsets(),
        np.column_stack([results.contacts[name][rows] for name in "xy"]))


def test_fields_of_a_ball(package):
    """A smooth ball as a map: load and greatest pressure are those of Hertz."""
    x = 0.1 * (np.arange(41) - 20)
    ball = package.HeightMap(1.0 - (x**2 + x[:, None]**2) / 40.0, 0.1, "um")
    scene = package.Scene({"surfaces": {"upper": "plane", "lower": ball, "map_level": "none"},
                           "material": {"contact_modulus": 100.0}, "effects": {"tolerance": 0.5},
                           "loading": {"control": "load", "value": 5.0}})
    results = scene.solve(fields=True)
    assert np.nansum(results.fields().pressure) * 0.01 == pytest.approx(5.0)
    hertz = (6 * 5.0 * 100.0**2 / (np.pi**3 * 20.0**2))**(1 / 3)
    assert results.fields().pressure.max() == pytest.approx(hertz, rel=0.03)


def test_refusals(package, solved, path):
    for value in ("last", "ALL"):
        with pytest.raises(ValueError, match=f"fields: found '{value}', expected True, False or"):
            package.solve(path, fields=value)
    with pytest.raises(TypeError, match="fields"):
        package.solve(path, fields=2.5)
    with pytest.raises(package.InputError, match="fields: no grid for the fields of asperities"):
        package.solve(ROOT / "data/examples/one_pair.scene", fields=True)
    for results in (package.solve(path), pickle.loads(pickle.dumps(package.solve(path)))):
        with pytest.raises(package.ComputeError, match="no fields: expected .*fields=True"):
            results.fields()
    with pytest.raises(IndexError, match="position: found 2, expected one of the results"):
        solved.fields(2)
    for step in (0, 5, -5):
        with pytest.raises(IndexError, match=f"step: found {step}, expected 1 to 4, or -1 for the"):
            solved.fields(step=step)
    with pytest.raises(ValueError, match="bins: found 0, expected a number from 1"):
        solved.pressure_histogram(bins=0)


def test_traction_and_stick(package, path, asperity, tmp_path):
    """Under a tangential load there are two arrays more, also in a saved file."""
    scene = path.parent / "slip.scene"
    scene.write_text(path.read_text().replace(
        "contact_modulus = 100.0", "elastic_modulus = 2*182., poisson_ratio = 2*0.3").replace(
        "value = 20.0", "value = 20.0, tangential_load = 3.0").replace(
        "interaction = 'boundary'", "interaction = 'boundary', friction_coefficient = 0.3"))
    results = package.solve(scene, fields=True)
    run_program(asperity, "solve", scene, "--quiet", "--fields", tmp_path / "f.vti")
    arrays = read_vti(tmp_path / "f.vti")[2]
    results.save(tmp_path / "r.zip")
    for fields in (results.fields(), package.load(tmp_path / "r.zip").fields(),
                   copy.deepcopy(results.fields())):
        assert fields.keys() == (*NAMES, "contact", "traction_x", "traction_y", "slip_x",
                                 "slip_y", "stick")
        assert all(np.array_equal(fields[name], arrays[name].T, equal_nan=True)
                   for name in fields)
        assert fields.stick.dtype == bool and np.array_equal(fields.stick, arrays["stick"].T)
        assert np.nansum(fields["traction_x"]) * 0.125 == pytest.approx(3.0)
        assert fields.units["traction_y"] == fields.units["pressure"] != ""
        assert fields.plot("slip_x") is not None
    assert results.positions["tangential_load"][0] == pytest.approx(3.0)
    with pytest.raises(KeyError):
        package.solve(path, fields=True).fields()["traction_x"]


def test_stress_below(package, tmp_path):
    """The arrays of `stress` are the file of `--stress`; largest values have their place; refusals
    have the reason."""
    x = np.linspace(-0.2, 0.2, 33)
    scene = {"surfaces": {"upper": "plane", "lower": package.HeightMap(
        -((x[:, None] - 0.05)**2 + x**2) / 2, x[1] - x[0], "mm"), "map_level": "none"},
        "material": {"elastic_modulus": (1e3, 1e3), "poisson_ratio": (0.3, 0.3)},
        "loading": {"control": "load", "value": 0.6}}
    results = package.solve(scene, fields=True)
    stress = results.stress((0.03, 0.05, 0.07))
    a, peak = (0.75 * 0.6 / (1e3 / 0.91 / 2))**(1 / 3), results.fields().pressure.max()
    value, depth, at_x, at_y = stress.largest()
    assert stress.von_mises.shape == (3, 33, 33) and abs(value / peak - 0.62) < 0.01
    assert (depth, at_x) == (0.05, 16 * (x[1] - x[0])) and abs(depth - 0.48 * a) < 0.02
    assert at_y == 20 * (x[1] - x[0])
    xx, yy, zz, xy, xz, yz = (stress[name] for name in ("xx", "yy", "zz", "xy", "xz", "yz"))
    mises = np.sqrt(((xx - yy)**2 + (yy - zz)**2 + (zz - xx)**2) / 2
                    + 3 * (xy**2 + xz**2 + yz**2))
    assert np.allclose(stress.von_mises, mises, rtol=1e-12, atol=1e-12 * peak)
    area = (x[1] - x[0])**2
    assert abs(-zz.sum(axis=(1, 2))[0] * area / 0.6 - 1) < 0.05
    assert repr(stress).startswith("<asperity.Stress at 3 depths: step 1, von Mises up to ")
    for again in (copy.copy(stress), copy.deepcopy(stress), pickle.loads(pickle.dumps(stress))):
        assert list(again) == list(stress) and np.array_equal(again.xz, stress["xz"])
    results.save(tmp_path / "r.zip")
    for own in (copy.deepcopy(results), pickle.loads(pickle.dumps(results)),
                package.load(tmp_path / "r.zip")):
        assert np.array_equal(own.stress(0.05).xz[0], stress["xz"][1])
    for wrong in (-1.0, [], "deep", [[0.1]], [0.1, math.nan]):
        with pytest.raises(package.InputError, match="depths: found .*, expected one or several"):
            results.stress(wrong)
    with pytest.raises(package.ComputeError, match="depth: found Infinity, expected a number of 0"):
        results.stress(math.inf)
    scene["material"] = {"contact_modulus": 1e3, "thermal_conductivity": (0.1, 0.4)}
    with pytest.raises(package.ComputeError, match="poisson_ratio"):
        package.solve(scene, fields=True).stress(0.1)
    assert results.positions.units["conductance_length"] == "mm"
    assert package.solve(scene).positions.units["thermal_conductance"] == "W/K"


def test_index_of_a_state(solved):
    """Earlier scripts count states from 0: the same fields, with a warning at their line."""
    for call, expected in ((lambda: solved.fields(1, 2).step, 3),
                           (lambda: solved.fields(state=0).step, 1),
                           (lambda: solved.pressure_histogram(state=3)[0][0],
                            solved.pressure_histogram()[0][0])):
        with pytest.warns(DeprecationWarning, match=r"counts from 0: use step=\d, which") as found:
            assert call() == expected
        assert found[0].filename == __file__
    with pytest.raises(TypeError, match="found state and step"):
        solved.fields(state=-1, step=1)
