"""Height maps in Python: arrays, HeightMap, files, topographies of SurfaceTopography."""

import copy
import pickle
import struct
import sys
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from builds import ROOT
from programs import run_program

pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning"),
              pytest.mark.filterwarnings("ignore::DeprecationWarning")]

ROUGH = ROOT / "data/examples/summits/rough.sdf"
DX, DY = 0.5, 0.25
ASPERITY = {"x": [3.0], "y": [4.0], "height": [1.0], "radius": [2.0]}


def made(rows=24, columns=32, seed=5):
    """Heights without symmetry, of few digits, so that a text has them all."""
    rng = np.random.default_rng(seed)
    spectrum = np.fft.fft2(rng.standard_normal((rows, columns)))
    q = np.hypot(*np.meshgrid(np.fft.fftfreq(columns), np.fft.fftfreq(rows))) + 0.05
    heights = np.fft.ifft2(spectrum * (q < 0.3) / q**2).real
    return np.round(0.02 * heights / heights.std(), 8)


HEIGHTS = made()


def Topography(*arguments, **options):
    """A map of SurfaceTopography, which takes a second to import."""
    from SurfaceTopography import Topography as made_topography
    return made_topography(*arguments, **options)


def scene(lower, **more):
    return {"surfaces": {"upper": "plane", "lower": lower, **more},
            "material": {"contact_modulus": 10.0},
            "loading": {"control": "pressure", "value": 0.04, "points": 3}}


def test_axes(package):
    """The one summit of [row, column] = [2, 5] of a topography and of a list stands at x = 5 dx,
    y = 2 dy, and the drawing has it there."""
    heights = np.zeros((6, 9))
    heights[2, 5] = 1.0
    topography = Topography(heights.T, (DX * 9, DY * 6), unit="um")
    for found in (package.summits(topography, level="none"),
                  package.summits(heights, level="none", spacing=(DX, DY))):
        assert (found["x"].tolist(), found["y"].tolist()) == ([5 * DX], [2 * DY])
    axes = package.HeightMap(heights, (DX, DY), "um").plot()
    # Pixels are around their places.
    assert np.allclose(axes.images[0].get_extent(), (-DX / 2, 8.5 * DX, -DY / 2, 5.5 * DY))
    assert np.array_equal(axes.images[0].get_array(), heights) and axes.images[0].origin == "lower"


@pytest.mark.parametrize("periodic", [False, True])
def test_summits_of_all_kinds(package, tmp_path, periodic):
    """Summits and statistics of array, file and topography, to the last bit."""
    np.savetxt(tmp_path / "m.txt", HEIGHTS, fmt="%.17g")
    edge = "periodic" if periodic else "free"
    expected = package.summits(tmp_path / "m.txt", spacing=(DX, DY), edge=edge, unit="um")
    surface = package.HeightMap(HEIGHTS, (DX, DY), "um", periodic)
    topography = Topography(HEIGHTS.T, (DX * HEIGHTS.shape[1], DY * HEIGHTS.shape[0]), unit="um",
                            periodic=periodic)
    for found in (package.summits(surface), package.summits(topography),
                  package.summits(HEIGHTS, spacing=(DX, DY), unit="um", edge=edge)):
        assert found == expected and found.units == expected.units
        assert repr(found.statistics) == repr(expected.statistics)
    assert len(expected) > 10 and expected.units["x"] == "um"
    millimetres = package.summits(surface, unit="mm")
    assert np.allclose(millimetres["x"], expected["x"] * 1e-3, rtol=1e-14)


def test_missing_pixels(package, tmp_path):
    """NaN and a mask are missing pixels, as the word BAD in a text."""
    mask = np.zeros(HEIGHTS.shape, bool)
    mask[4:7, 10:14] = True
    with_nan = np.where(mask, np.nan, HEIGHTS)
    masked = np.ma.masked_array(HEIGHTS, mask=mask)
    np.savetxt(tmp_path / "m.txt", with_nan, fmt="%.17g")
    expected = package.summits(tmp_path / "m.txt", spacing=(DX, DY))
    for heights in (with_nan, masked):
        assert package.summits(heights, spacing=(DX, DY)) == expected
        assert "12 pixels missing" in repr(package.HeightMap(heights, 1.0))
    assert expected.statistics["missing"] == 12


def test_written_without_an_edge(package, tmp_path):
    for name in ("p.npy", "p.sdf"):
        with pytest.warns(UserWarning, match="has no edge"):
            package.HeightMap(HEIGHTS, 1.0, "um", periodic=True).write(tmp_path / name)


def test_read_other_formats(package, tmp_path):
    """A format that only SurfaceTopography reads: its own NetCDF."""
    topography = Topography(HEIGHTS.T, (DX * HEIGHTS.shape[1], DY * HEIGHTS.shape[0]), unit="um",
                            periodic=True)
    topography.to_netcdf(str(tmp_path / "m.nc"))
    found = package.read_map(tmp_path / "m.nc")
    assert np.array_equal(found.heights, HEIGHTS) and found.periodic and found.unit == "um"
    assert found.spacing == pytest.approx((DX, DY), rel=1e-14)
    assert package.solve(scene(found)).states["load"][-1] > 0
    with pytest.raises(package.InputError, match="read it: .*'physical_sizes' is already fixed"):
        package.read_map(tmp_path / "m.nc", spacing=1.0)
    (tmp_path / "bad").write_bytes(bytes(range(256)) * 9)
    with pytest.raises(package.InputError, match="control character"):
        package.read_map(tmp_path / "bad")


def test_maps_without_a_size(package, tmp_path):
    """Spacing and unit reach SurfaceTopography: a map of MATLAB has neither."""
    rows, columns = HEIGHTS.shape
    (tmp_path / "m.mat").write_bytes(struct.pack("<5i", 0, rows, columns, 0, 7) + b"height\0" +
                                     HEIGHTS.T.tobytes())
    with pytest.raises(package.InputError) as caught:
        package.read_map(tmp_path / "m.mat")
    reason, *own = str(caught.value).splitlines()
    assert "SurfaceTopography cannot read it: `physical_sizes` could not" in reason and own
    found = package.read_map(tmp_path / "m.mat", spacing=(DX, DY), unit="nm", periodic=True)
    assert np.array_equal(found.heights, HEIGHTS) and found.periodic and found.unit == "nm"
    assert found.spacing == pytest.approx((DX, DY), rel=1e-14)


GERMAN = "# Kanal: Hoehe\n# Breite: 16 \u00b5m\n# H\u00f6he: 6 \u00b5m\n# Einheiten: um\n"


def test_headers_of_other_languages(package, tmp_path):
    """A text of Gwyddion in German, which SurfaceTopography reads. A line that it would leave out,
    and a text without a size in its header, stay refused."""
    lines = [" ".join(map(repr, row)) for row in HEIGHTS.tolist()]
    path = tmp_path / "m.txt"
    path.write_text(GERMAN + "\n".join(lines), encoding="utf-8")
    found = package.read_map(path, unit="um")
    assert np.allclose(found.heights, HEIGHTS, rtol=1e-12, atol=0) and found.unit == "um"
    assert found.spacing == pytest.approx((DX, DY), rel=1e-12)
    for header, number, word in ((GERMAN, 5, "1.#QNAN"), (GERMAN, 0, "-1.#IND"), (GERMAN, 7, "?"),
                                 ("# no size\n", 0, "0.5")):
        cells = [line.split() for line in lines]
        cells[3][number] = word
        path.write_text(header + "\n".join(map(" ".join, cells)), encoding="utf-8")
        with pytest.raises(package.InputError):
            package.read_map(path)


def test_notes_of_the_reader(package, tmp_path):
    """A note on the file is in `notes` and a warning at the line of the caller; copies keep it."""
    path = tmp_path / "m.sdf"
    package.HeightMap(HEIGHTS, (DX, DY), "um").write(path)
    path.write_bytes(path.read_bytes() + b"by hand\n")
    with pytest.warns(UserWarning, match="note: 8 bytes of text behind") as found:
        surface = package.read_map(path)
    assert [str(one.message) for one in found] == surface.notes and len(surface.notes) == 1
    assert found[0].filename == __file__
    assert pickle.loads(pickle.dumps(surface)).notes == copy.copy(surface).notes == surface.notes
    assert package.HeightMap(HEIGHTS, 1.0).notes == []


class Named:
    """An array with named dimensions and coordinates, as xarray has it."""

    def __init__(self, data, dims, **coords):
        self.data, self.dims, self.ndim = data, dims, data.ndim
        self.coords = {name: SimpleNamespace(values=np.asarray(values))
                       for name, values in coords.items()}

    def __array__(self, dtype=None, copy=None):
        return np.array(self.data, dtype=dtype)

    @property
    def T(self):
        turned = Named(self.data.T, self.dims[::-1])
        turned.coords = self.coords
        return turned


def test_named_dimensions(package):
    """Dimensions `x` and `y` rule the order, coordinates are the spacing or contradict it."""
    x, y = DX * np.arange(32) + 7.0, DY * np.arange(24)
    named = Named(HEIGHTS, ("y", "x"), x=x, y=y)
    bare = Named(HEIGHTS.T, ("X", "row"))
    for one in (named, named.T, bare):
        assert np.array_equal(package.HeightMap(one, (DX, DY)).heights, HEIGHTS)
    expected = package.solve(scene(HEIGHTS, map_spacing=(DX, DY))).states
    for more in ({}, {"map_spacing": (DX, DY)}):
        assert package.solve(scene(named.T, **more)).states == expected
    found = package.summits(named.T)
    assert found == package.summits(HEIGHTS, spacing=(DX, DY)) and found.plot().images
    two = {"map_spacing": (1.0, 1.0, DX, DY)}
    package.solve(scene(named, upper=np.zeros_like(HEIGHTS), map_spacing=(DX, DY, DX, DY)))
    turned = Named(HEIGHTS, ("y", "x"), y=y[::-1])
    uneven = Named(HEIGHTS, ("y", "x"), x=np.sqrt(x))
    for call, shown in (
            (lambda: package.HeightMap(named, 1.0), "heights.x: found coordinates with the step"),
            (lambda: package.HeightMap(turned, (DX, DY)), "heights.y: found coordinates with un"),
            (lambda: package.HeightMap(uneven, (DX, DY)), "heights.x: found coordinates with un"),
            (lambda: package.summits(named, spacing=(DX, 1.0)), "map.y: found coordinates with"),
            (lambda: package.solve(scene(named, map_spacing=1.0)), "surfaces.lower.x: found"),
            (lambda: package.solve(scene(HEIGHTS, upper=named, **two)), "surfaces.upper.x: foun"),
            (lambda: package.solve(scene(Named(HEIGHTS, ("y", "x"), x=x))), "one dimension")):
        with pytest.raises(package.InputError, match=shown):
            call()


def test_quantities_with_a_unit(package):
    """Their unit would be lost: refused, in arrays and in single numbers."""
    class Quantity(float):
        units = magnitude = "nanometer"
    class Length(np.ndarray):
        unit = to_value = "nm"
    for call in (lambda: package.HeightMap(HEIGHTS.view(Length), 1.0),
                 lambda: package.HeightMap(HEIGHTS, (1.0, Quantity(2.0))),
                 lambda: package.HeightMap(Named(HEIGHTS.view(Length), ("y", "x")), 1.0),
                 lambda: package.solve({**scene(HEIGHTS, map_spacing=1.0), "loading": {
                     "control": "pressure", "value": Quantity(2.0)}})):
        with pytest.raises(package.InputError, match="found numbers in n.*, expected plain numb"):
            call()


def test_file_beside_array(package, tmp_path):
    """One side of asperities a file and the other an array or a table."""
    other = {"x": [3.1], "y": [4.0], "height": [0.5], "radius": [1.0]}
    pd.DataFrame(other).to_csv(tmp_path / "a.csv", index=False)
    groups = {"material": {"contact_modulus": 10.0}, "loading": {"control": "load", "value": 0.1}}
    both = [package.solve({"surfaces": {"upper": upper, "lower": lower}, **groups}).states
            for upper, lower in ((ASPERITY, other), (ASPERITY, tmp_path / "a.csv"),
                                 (pd.DataFrame(ASPERITY), str(tmp_path / "a.csv")))]
    assert both[1] == both[0] == both[2]


def test_structured_array_and_pandas(package):
    """Tables of numpy and pandas as surfaces."""
    frame = pd.DataFrame(ASPERITY)
    groups = {"material": {"contact_modulus": 10.0}, "loading": {"control": "load", "value": 0.1}}
    found = [package.solve({"surfaces": {"upper": one, "lower": "plane"}, **groups}).states
             for one in (ASPERITY, frame, frame.to_records(index=False))]
    assert found[0] == found[1] == found[2]


@pytest.mark.parametrize("heights, shown", [
    ([[0.0, 1.0], [0.0]], r"heights\[1\]: found 1 heights, expected 2"),
    (np.zeros(9), "an array of 1 dimensions"), (np.zeros((3, 3, 3)), "3 dimensions"),
    ([1.0, 2.0], "2 numbers in one row"), (3.0, "heights"), ("abc", "heights")])
def test_no_matrix(package, heights, shown):
    with pytest.raises((package.InputError, TypeError), match=shown):
        package.HeightMap(heights, 1.0)


@pytest.mark.parametrize("surfaces, shown", [
    ({"lower": HEIGHTS, "map_spacing": -1.0}, "map_spacing"),
    ({"lower": HEIGHTS, "map_spacing": 1.0, "map_edge": "perodic"}, "did you mean 'periodic'")])
def test_bad_maps(package, surfaces, shown):
    """Each is refused in a sentence that names what was given."""
    groups = scene(None)
    groups["surfaces"].update(surfaces)
    with pytest.raises(package.InputError, match=shown):
        package.solve(groups)


def test_height_map_is_its_own(package):
    """It copies heights; it can be copied and pickled; `asarray` of it is read-only heights."""
    heights = HEIGHTS.copy()
    surface = package.HeightMap(heights, (DX, DY), "um", True)
    heights[:] = 0
    for one in (surface, copy.deepcopy(surface), pickle.loads(pickle.dumps(surface)),
                package.HeightMap(surface, (DX, DY), "um", True)):
        assert np.array_equal(one.heights, HEIGHTS) and np.array_equal(np.asarray(one), HEIGHTS)
        assert (one.spacing, one.unit, one.periodic) == ((DX, DY), "um", True)
        assert one.sizes == (DX * 32, DY * 24) and one.shape == (24, 32)
        assert not one.heights.flags.writeable
    assert repr(surface).startswith("<asperity.HeightMap of 32 x 24 pixels: 16 x 6 um, heights -")
    assert repr(surface).endswith(" um, periodic>") and "32 x 24" in repr(surface)


def test_plots(package):
    """Map and summits with axes and units; on axes that are given."""
    surface = package.read_map(ROUGH, unit="um")
    axes = surface.plot()
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x (um)", "y (um)")
    assert axes.figure.axes[1].get_ylabel() == "height (um)"
    for source in (surface, ROUGH):
        summits = package.summits(source, unit="um")
        _, own = plt.subplots()
        assert summits.plot(ax=own) is own and len(own.images) == 1
        points = own.collections[0].get_offsets()
        assert np.array_equal(points[:, 0], summits["x"])
        assert np.array_equal(np.ma.filled(own.images[0].get_array(), np.nan), surface.heights,
                              equal_nan=True)
    assert len(package.summits(HEIGHTS, spacing=1.0).plot().images) == 1


LIMITED = """
import resource, sys
import numpy
import asperity
heights = numpy.load("big.npy")
used = 4096 * int(open("/proc/self/statm").read().split()[0])
resource.setrlimit(resource.RLIMIT_AS, (used + int(sys.argv[1]),) * 2)
scene = {"surfaces": {"upper": "plane", "lower": heights, "map_spacing": 1.0,
                      "map_edge": "periodic"},
         "material": {"elastic_modulus": (1e3, 1e3), "poisson_ratio": (0.3, 0.3)},
         "loading": {"control": "pressure", "value": 1.0}}
try:
    CALL
except (asperity.ComputeError, MemoryError):
    print("memory")
else:
    print("done")
"""


@pytest.mark.long
@pytest.mark.once
@pytest.mark.parametrize("call", [
    "asperity.read_map('big.npy', spacing=1.0)", "asperity.solve(scene, fields=True)",
    "asperity.summits(asperity.HeightMap(heights, 1.0))",
    "asperity.solve(scene, fields=True).stress([1.0, 2.0])",
    "asperity.solve({**scene, 'effects': {'friction': 'on', 'friction_coefficient': 0.3}, "
    "'loading': {**scene['loading'], 'tangential_load': 2e4}}, fields=True)",
    "asperity.HalfSpace(heights.shape, 1.0, 1e3, 0.3).displacement(heights, (heights, heights))",
    "asperity.HalfSpace(heights.shape, 1.0, 1e3, 0.3, periodic=True).pressure(heights)",
    "asperity.HalfSpace((300, 300), 1.0, 1e3, 0.3).stress([1.0, 2.0], heights[:300, :300])",
    "asperity.generate_map(pixels=512, spacing=1, hurst=0.8, rms_slope=0.1)"])
def test_limits_of_memory(package_folder, call, tmp_path):
    """A limit of memory is an exception, never the end of the interpreter."""
    y, x = np.mgrid[:600, :600]
    np.save(tmp_path / "big.npy", 0.1 * (np.sin(x * np.pi / 30) + np.cos(y * np.pi / 37.5)))
    ends = [run_program(sys.executable, "-W", "ignore", "-c", LIMITED.replace("CALL", call), room,
                        cwd=tmp_path, variables={"PYTHONPATH": str(package_folder),
                                                 "OMP_NUM_THREADS": "1",
                                                 "OPENBLAS_NUM_THREADS": "1"}).stdout.strip()
            for room in np.geomspace(2e6, 300e6, 11).astype(int)]
    assert set(ends) == {"memory", "done"}
