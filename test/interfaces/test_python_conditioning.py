"""Measured maps made fit for a solve, profiles, and one rule of axes for every source of a map."""

import math
import pickle
import struct

import numpy as np
import pytest
from builds import ROOT

pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]

DX, DY = 0.5, 0.25


def places(rows=24, columns=32):
    """y and x of the centres of pixels."""
    return np.mgrid[:rows, :columns] * np.array([DY, DX])[:, None, None]


def holes(heights, seed=3, share=0.1):
    found = np.array(heights)
    found[np.random.default_rng(seed).random(found.shape) < share] = np.nan
    return found


def noise(rows=24, columns=32, seed=5):
    return np.random.default_rng(seed).standard_normal((rows, columns))


@pytest.mark.parametrize("robust", [False, True])
@pytest.mark.parametrize("degree", [0, 1, 2, 4])
def test_level_removes_polynomials(package, degree, robust):
    """Beside holes, to rounding; one degree less leaves the rest of the last term."""
    y, x = places()
    form = np.ones_like(x) + sum((0.3 * x)**i * (0.2 * y)**(n - i) for n in range(1, degree + 1)
                     for i in range(n + 1))
    given = package.HeightMap(holes(form), (DX, DY), "um")
    found = given.level(degree, robust)
    assert np.array_equal(np.isnan(found.heights), np.isnan(given.heights))
    assert np.nanmax(np.abs(found.heights)) < 1e-12 * np.nanmax(np.abs(form))
    if degree:
        assert np.nanmax(np.abs(given.level(degree - 1, robust).heights)) > 1e-3
    assert (found.unit, found.spacing, found.periodic) == ("um", (DX, DY), False)
    assert given.notes == [] and f"degree {degree}" in found.notes[0]


@pytest.mark.parametrize("size, share", [(5.0, 0.1), (0.1, 0.25)])
def test_level_with_outliers(package, size, share):
    """A part of the pixels above the others: the biweight keeps the plane of the others."""
    y, x = places()
    outliers = np.random.default_rng(2).random(x.shape) < share
    given = package.HeightMap(0.1 * x - 0.2 * y + 1e-3 * noise() + size * outliers, (DX, DY))
    robust, least = given.level(robust=True).heights, given.level().heights
    assert abs(np.mean(robust[~outliers])) < 2e-4 and np.abs(robust[~outliers]).max() < 5e-3
    assert abs(np.mean(least[~outliers])) > 0.5 * size * share


def test_fill_is_harmonic(package):
    """x^2 - y^2 and x y^2 - x^3/3 solve the equation of differences; linear heights beside an
    edge with zero slope across it; a hole over the seam of a periodic map."""
    y, x = places()
    for form in (x**2 - y**2, x * y**2 - x**3 / 3):
        broken = form.copy()
        broken[5:9, 10:20] = broken[15, 3:29] = broken[11:20, 6] = np.nan
        found = package.HeightMap(broken, (DX, DY)).fill()
        assert np.abs(found.heights - form).max() < 1e-10 * np.abs(form).max()
    assert found.notes == [f"fill: {np.isnan(broken).sum()} missing pixels, harmonic"]
    ramp = 0.3 * x
    ramp[:6, 10:20] = np.nan
    assert package.HeightMap(ramp, (DX, DY)).fill().heights == pytest.approx(0.3 * x, rel=1e-12)
    tall = noise()
    tall[0, 0] = np.nan
    filled = package.HeightMap(tall, (DX, DY), periodic=True).fill().heights[0, 0]
    wx, wy = DX**-2, DY**-2
    beside = wx * (tall[0, 1] + tall[0, -1]) + wy * (tall[1, 0] + tall[-1, 0])
    assert filled == pytest.approx(beside / (2 * (wx + wy)))


def test_filter_transmission(package):
    """ISO 16610-61: waves of half, one and twice the cut-off pass with 2^-4, 2^-1 and 2^-1/4."""
    number, spacing, cut = 240, 0.5, 10.0
    x = spacing * np.arange(number)
    for wavelength, factor in ((cut / 2, 2.0**-4), (cut, 0.5), (2 * cut, 2.0**-0.25)):
        wave = np.tile(np.cos(2 * np.pi * x / wavelength), (number, 1))
        for heights in (wave, wave.T):
            surface = package.HeightMap(heights, spacing, "um", periodic=True)
            low = surface.filter(shortest=cut).heights
            high = surface.filter(longest=cut).heights
            assert np.allclose(low, factor * heights, rtol=1e-6, atol=1e-8)
            assert np.allclose(high, (1 - factor) * heights, rtol=1e-6, atol=1e-8)
    band = surface.filter(shortest=cut / 2, longest=2 * cut)
    between = 2.0**-(1 / 16) * (1 - 2.0**-1)
    assert np.allclose(band.heights, between * heights, rtol=1e-6, atol=1e-8)
    assert band.notes == ["filter: Gaussian (ISO 16610-61), wavelengths above 5 um and below 20 um"]


def test_filter_keeps_planes_and_holes(package):
    y, x = places()
    plane = holes(0.1 + 0.2 * x - 0.3 * y)
    surface = package.HeightMap(plane, (DX, DY))
    low, high = surface.filter(shortest=2.0).heights, surface.filter(longest=2.0).heights
    assert np.allclose(low, plane, rtol=0, atol=1e-12, equal_nan=True)
    assert np.allclose(high, 0 * plane, rtol=0, atol=1e-12, equal_nan=True)


def test_align_rows(package):
    """Steps between rows are removed; a row without a measured pixel does not stop it."""
    row = noise(1, 32)[0]
    broken = row + np.cumsum(noise(24, 1), axis=0)
    broken[7] = broken[12, 3:20] = np.nan
    found = package.HeightMap(broken, (DX, DY)).align().heights
    expected = np.where(np.isnan(broken), np.nan, row + broken[0, 0] - row[0])
    assert np.allclose(found, expected, rtol=0, atol=1e-12, equal_nan=True)


def test_crop(package):
    given = package.HeightMap(noise(), (DX, DY), "um", periodic=True)
    found = given.crop(x=(2.0, 11.9), y=(1.0, 3.0))
    assert np.array_equal(found.heights, given.heights[4:12, 4:24])
    assert (found.periodic, found.unit, found.spacing) == (False, "um", (DX, DY))
    assert found.notes == ["crop: x 2 to 11.9, y 1 to 3"]
    assert np.array_equal(given.crop().heights, given.heights)
    for ends in ((-1.0, 3.0), (3.0, 99.0), (3.0, 3.0)):
        with pytest.raises(package.InputError, match="x: found"):
            given.crop(x=ends)


def test_resample(package):
    """A periodic map of few waves has its exact values between the pixels; a free cubic is exact.
    The sides stay."""
    def waves(rows, columns):
        y, x = np.mgrid[:rows, :columns] * 2 * np.pi / np.array([rows, columns])[:, None, None]
        return np.cos(3 * x - 2 * y) + 0.5 * np.sin(4 * y)

    given = package.HeightMap(waves(24, 32), (DX, DY), "um", periodic=True)
    found = given.resample((0.2, 0.1))
    assert found.shape == (60, 80) and found.sizes == pytest.approx(given.sizes, rel=1e-12)
    assert found.heights == pytest.approx(waves(60, 80), abs=1e-12) and found.periodic

    def cubic(step_x, step_y, rows, columns):
        y, x = (np.mgrid[:rows, :columns] + 0.5) * np.array([step_y, step_x])[:, None, None]
        return x**3 - 2 * x * y**2 + y - 1

    given = package.HeightMap(cubic(DX, DY, 24, 32), (DX, DY))
    for spacing in ((0.2, 0.1), (1.0, 0.5)):
        found = given.resample(spacing)
        assert found.spacing == pytest.approx(spacing) and found.sizes == given.sizes
        exact = cubic(*spacing, *found.shape)
        assert found.heights == pytest.approx(exact, rel=1e-10, abs=1e-10 * np.abs(exact).max())
    with pytest.raises(package.InputError, match="fill"):
        package.HeightMap(holes(noise()), 1).resample(0.5)


def test_parameters_of_closed_forms(package):
    """A plane of the slopes 3/4 and 1: area sqrt(1 + 25/16); a cosine: Sq a/sqrt 2, Sku 3/2, Sa
    2 a/pi but for the pixels; a free map has a nominal mean of 0."""
    y, x = places(40, 48)
    found = package.HeightMap(0.75 * x + y, (DX, DY)).parameters()
    assert found["Sdq"] == pytest.approx(1.25, rel=1e-12)
    assert found["Sdr"] == pytest.approx(math.sqrt(1 + 1.25**2) - 1, rel=1e-12)
    a, number = 0.3, 600
    wave = np.tile(a * np.cos(2 * np.pi * np.arange(number) / number), (8, 1)) + 7.0
    found = package.HeightMap(wave, 0.01, periodic=True).parameters()
    expected = {"Sa": 2 * a / math.pi, "Sq": a / math.sqrt(2), "Sku": 1.5, "Sp": a, "Sv": a,
                "Sz": 2 * a}
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, rel=1e-5), name
    assert abs(found["Ssk"]) < 1e-12
    skew = package.HeightMap([[1.0, 0.0, 0.0, 0.0]] * 3, 1.0).parameters()
    assert skew["Ssk"] == pytest.approx(2 / math.sqrt(3)) and skew["Sku"] == pytest.approx(7 / 3)


@pytest.mark.parametrize("periodic", [False, True])
def test_parameters_of_surface_topography(package, periodic):
    """Sq to 1e-12; Sdq of a periodic map, whose differences are the same there."""
    surface = package.HeightMap(noise(), (DX, DY), "um", periodic)
    found, other = surface.parameters(), surface.to_topography()
    heights = np.array(surface.heights)
    assert found["Sq"] == pytest.approx(math.sqrt(((heights - heights.mean())**2).mean()))
    assert found["Sq"] == pytest.approx(float(other.detrend("center").rms_height_from_area()))
    if periodic:
        assert found["Sdq"] == pytest.approx(float(other.rms_gradient()), rel=1e-12)
        assert found["Sdr"] > 0.0


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("broken", [False, True])
def test_topography_and_back(package, periodic, broken):
    """Bit for bit, not square, with unequal spacing and holes; the constructor as `of`."""
    heights = holes(noise(5, 3)) if broken else noise(5, 3)
    given = package.HeightMap(heights, (DX, DY), "um", periodic)
    topography = given.to_topography()
    assert topography.nb_grid_pts == (3, 5) and topography.unit == "um"
    for found in (package.HeightMap.of(topography), package.HeightMap(topography)):
        assert np.array_equal(found.heights, heights, equal_nan=True)
        assert (found.spacing, found.unit, found.periodic) == ((DX, DY), "um", periodic)
    assert package.HeightMap(topography, spacing=1).spacing == (1.0, 1.0)
    with pytest.raises(package.InputError, match="nm and um"):
        package.HeightMap(topography, unit="nm")
    with pytest.raises(TypeError, match="a topography"):
        package.HeightMap.of(heights)


def test_one_rule_of_axes(package, tmp_path):
    """`.npy`, `.npz`, `.mat` and `.h5` are plain arrays: rows along y, as in Python."""
    import h5py
    import scipy.io
    heights = noise(12, 16)
    np.save(tmp_path / "m.npy", heights)
    np.savez(tmp_path / "m.npz", heights=heights)
    scipy.io.savemat(tmp_path / "m.mat", {"heights": heights})
    with h5py.File(tmp_path / "m.h5", "w") as file:
        file["surface"] = heights
    for ending in ("npy", "npz", "mat", "h5"):
        found = package.read_map(tmp_path / f"m.{ending}", spacing=(DX, DY), unit="um")
        assert np.array_equal(found.heights, heights), ending
        assert found.spacing == pytest.approx((DX, DY), rel=1e-12), ending


@pytest.mark.parametrize("columns", [["x", "y", "z"], ["y", "x", "height"], ["x", "mlw", "y"],
                                     [0, 1, 2], [2, 1, 0], [0, 2, 3]])
@pytest.mark.parametrize("delimiter, decimal", [(",", "."), (";", ","), ("\t", ","), (None, ".")])
def test_text_of_columns(package, tmp_path, columns, delimiter, decimal):
    """Places and heights in any columns and any order, with the separator and the decimal sign."""
    heights = np.round(holes(noise(4, 6)), 6)
    y, x = places(4, 6)
    order = np.random.default_rng(1).permutation(heights.size)
    named = isinstance(columns[0], str)
    if named:
        known = {"x": x, "y": y}
        names = tuple(next(name for name in columns if name == axis) for axis in "xy") + tuple(
            name for name in columns if name not in "xy")
        table = [known.get(name, heights).ravel()[order] for name in columns]
    else:
        names, table = tuple(columns), [np.full(heights.size, 9.0)] * 4
        for place, values in zip(columns, (x, y, heights)):
            table[place] = values.ravel()[order]
    sign = delimiter or " "
    lines = [sign.join(columns)] if named else []
    lines += [sign.join(f"{value:.8g}" for value in row).replace(".", decimal)
              for row in zip(*table)]
    (tmp_path / "m.txt").write_text("# a comment\n" + "\n".join(lines) + "\n")
    found = package.read_map(tmp_path / "m.txt", unit="um", delimiter=delimiter, decimal=decimal,
                             columns=names)
    assert np.array_equal(found.heights, heights, equal_nan=True)
    assert found.spacing == pytest.approx((DX, DY)) and found.unit == "um"


def test_text_of_a_matrix(package, tmp_path):
    (tmp_path / "m.txt").write_text("1,5;2;3\n4;;6\nBAD;8;-9,25\n")
    found = package.read_map(tmp_path / "m.txt", spacing=(DX, DY), delimiter=";", decimal=",")
    expected = [[1.5, 2, 3], [4, math.nan, 6], [math.nan, 8, -9.25]]
    assert np.array_equal(found.heights, expected, equal_nan=True)
    for name in ("value", "elevation"):
        (tmp_path / "n.csv").write_text(f"y,X,{name}\n" + "\n".join(
            f"{y},{x},{x * y}" for x in range(3) for y in (0, 0.5, 1)))
        named = package.read_map(tmp_path / "n.csv")
        assert named.spacing == (1.0, 0.5) and named.heights[2].tolist() == [0.0, 1.0, 2.0]


@pytest.mark.parametrize("text, options, expected", [
    ("1,2\n3,x\n", {"spacing": 1}, "could not convert string 'x' to float64; delim"),
    ("1,2\n3\n", {"spacing": 1}, "number of columns changed from 2 to 1; delim"),
    ("1,2\n3,4\n", {}, "spacing: found None"),
    ("#\n", {"spacing": 1}, "no line of numbers"),
    ("x,y,z\n0,0,1\n1,0,2\n0,1,3\n", {"columns": ("x", "y", "z")}, "3 places, expected each of"),
    ("x,y,z\n0,0,1\n1,0,2\n0,1,3\n0,1,4\n", {"columns": ("x", "y", "z")}, "each of"),
    ("x,y,z\n0,0,1\n1,0,2\n5,0,3\n", {"columns": ("x", "y", "z")}, "x: found 3 places, step 2.5"),
    ("x,y,z\n0,0,1\n0,1,2\n", {"columns": ("x", "y", "z")}, "x: found 1 places, step 0"),
    ("#\nx,y,z\n0,0,1\n", {"columns": ("x", "y", "h")}, "m.txt:2: found the columns x, y, z"),
    ("0,0,1\n", {"columns": (0, 1)}, "three: x, y and height"),
    ("0,0,1\n", {"columns": (0, 1, 2), "spacing": 1}, "none beside the places"),
    ("0,0,1\n", {"delimiter": ",", "decimal": ","}, "another one"),
    ("1.5;2\n", {"delimiter": ";", "decimal": ",", "spacing": 1}, "'1.5' to float64")])
def test_text_refused(package, tmp_path, text, options, expected):
    (tmp_path / "m.txt").write_text(text)
    with pytest.raises(package.InputError, match=expected):
        package.read_map(tmp_path / "m.txt", **{"delimiter": ",", **options})


def test_unit_of_an_xarray(package):
    """The attribute `units` of heights and coordinates is the unit of the map."""
    import xarray
    heights, x = noise(8, 8), np.arange(8.0)
    given = xarray.DataArray(heights, dims=("x", "y"), attrs={"units": "nm"}, coords={
        axis: (axis, x, {"units": "nm"}) for axis in "xy"})
    found = package.HeightMap(given, 1)
    assert found.unit == "nm" and np.array_equal(found.heights, heights.T)

    def area(lower):
        return package.solve({
            "surfaces": {"upper": "plane", "lower": lower, "units": ("um", "uN"),
                         "map_unit": "um"},
            "material": {"contact_modulus": 10.0},
            "loading": {"control": "pressure", "value": 0.5}}).positions["area"]

    assert area(given) == area(found)
    given.coords["x"].attrs["units"] = "um"
    for use in (lambda: package.HeightMap(given, 1), lambda: area(given)):
        with pytest.raises(package.InputError, match="one unit for heights and places"):
            use()


def test_profile(package):
    """A free profile is a strip: the half-width and the pressure of a line contact (Hertz), with
    loads per length."""
    radius, modulus, load, spacing = 10.0, 1e3, 10.0, 0.0025
    x = np.arange(-400, 401) * spacing
    cylinder = package.HeightMap.profile(-x**2 / (2 * radius), spacing, "um")
    assert "a profile of 801 pixels" in repr(cylinder) and cylinder.sizes[1] == 1.0
    half = math.sqrt(4 * load * radius / (math.pi * modulus))
    scene = {"surfaces": {"upper": "plane", "lower": cylinder, "units": ("um", "uN")},
             "material": {"contact_modulus": modulus},
             "loading": {"control": "load", "value": load}}
    for surface in (cylinder, pickle.loads(pickle.dumps(cylinder)), cylinder.level(0),
                    package.HeightMap(cylinder, cylinder.spacing, "um")):
        scene["surfaces"]["lower"] = surface
        results = package.solve(scene, fields=True)
        assert float(results.states["area"][-1]) == pytest.approx(2 * half, abs=2 * spacing)
        assert results.fields().pressure.max() == pytest.approx(
            2 * load / (math.pi * half), rel=1e-3)
    fine = cylinder.resample(spacing / 2)
    assert fine.shape == (3, 1602) and fine.is_profile and fine.sizes == cylinder.sizes
    topography = cylinder.to_topography()
    assert topography.nb_grid_pts == (801,)
    back = package.HeightMap.of(topography)
    assert back.is_profile and np.array_equal(back.heights, cylinder.heights)


def write_gwyddion(path, heights, sizes, unit="m"):
    """A file of Gwyddion with one channel, whose heights have a unit; lengths are in metres."""
    def item(name, kind, data):
        return name.encode() + b"\0" + kind + data

    def group(name, *items):
        body = b"".join(items)
        return name.encode() + b"\0" + struct.pack("<I", len(body)) + body

    numbers = [item(f"{axis}res", b"i", struct.pack("<i", count))
               for axis, count in zip("xy", heights.shape[::-1])]
    numbers += [item(f"{axis}real", b"d", struct.pack("<d", size))
                for axis, size in zip("xy", sizes)]
    units = (item(f"si_unit_{axis}", b"o", group("GwySIUnit", item(
        "unitstr", b"s", text.encode() + b"\0"))) for axis, text in (("xy", "m"), ("z", unit)))
    data = item("data", b"D", struct.pack("<I", heights.size) + heights.tobytes())
    path.write_bytes(b"GWYP" + group("GwyContainer", item("/0/data", b"o", group(
        "GwyDataField", *numbers, *units, data))))


@pytest.mark.parametrize("ending", ["x3p", "nc", "sdf", "gwy"])
def test_from_a_file_to_a_curve(package, tmp_path, ending):
    """A map of an instrument, made fit, and its curve beside the theories."""
    read = package.read_map(ROOT / "data/examples/summits/rough.sdf", unit="um")
    filled = package.HeightMap(read.fill().heights[:-4], read.spacing, "um")
    path = tmp_path / f"m.{ending}"
    if ending == "sdf":
        filled.write(path)
    elif ending == "gwy":
        write_gwyddion(path, filled.heights * 1e-6, [size * 1e-6 for size in filled.sizes])
    else:
        getattr(filled.to_topography().to_unit("m"),
                {"x3p": "to_x3p", "nc": "to_netcdf"}[ending])(str(path))
    found = package.read_map(path, unit="um")
    assert found.shape == (60, 64) and np.allclose(found.heights, filled.heights, atol=1e-9)
    surface = found.fill().align().level(2).filter(
        shortest=2, longest=20).crop(x=(2, 30), y=(1, 29))
    assert surface.shape == (56, 56) and len(surface.notes) >= 5
    results = package.solve({
        "surfaces": {"upper": "plane", "lower": surface, "units": ("um", "uN")},
        "material": {"contact_modulus": 1e5},
        "loading": {"control": "pressure", "value": 50, "points": 3}})
    persson = package.theory.persson(surface, 1e5, results.states["nominal_pressure"])
    assert (results.states["area_fraction"][1:] > 0.5 * persson[1:]).all()
    _, right = results.plot(theory={"persson": surface, "bush_gibson_thomas": surface})
    assert [line.get_label() for line in right.lines[1:]] == ["persson", "bush_gibson_thomas"]


def test_gwyddion_without_heights(package, tmp_path):
    """A Gwyddion file whose one channel has the unit of an angle: the message states so."""
    write_gwyddion(tmp_path / "m.gwy", noise(5, 4), (1e-6, 1e-6), "deg")
    with pytest.raises(package.InputError, match="cannot read it: found no channel of heights"):
        package.read_map(tmp_path / "m.gwy")


def test_refusals(package):
    surface = package.HeightMap(noise(), 1, periodic=True)
    for use, words in ((lambda: surface.level(1), "would not be periodic"),
                       (lambda: surface.level(-1), "0 to 0"),
                       (lambda: surface.filter(), "one or two wavelengths"),
                       (lambda: surface.filter(5.0, 2.0), "ascending"),
                       (lambda: surface.resample(0.0), "more than 0"),
                       (lambda: package.HeightMap(np.full((3, 3), np.nan), 1).fill(),
                        "no measured pixel")):
        with pytest.raises(package.InputError, match=words):
            use()
