"""Height maps as arrays and as `.npy`, read and written by the Python package: every type of array,
the sides of a scene, units and edges, and the same bits however a map comes."""

import os
import sys

import numpy as np
import pytest

from made_maps import self_affine, write_bytes
from programs import run_program

# The library of the package, not the build under test: `checks` runs this file with its own.
pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]

NEEDS_SDFIO = pytest.mark.skipif(sys.version_info < (3, 11), reason="sdfio needs Python 3.11")
# Along x and y; their products with whole numbers are exact.
SPACING = (0.5, 0.375)
OWN = {"map_spacing": SPACING, "map_unit": "um"}


def uneven():
    """40 rows of 24 pixels, whole numbers from 1 to 100 in turn with real ones; no symmetry."""
    heights, _ = self_affine((40, 24), 3, shortest=6)
    heights += 0.02 * np.arange(24) + 0.05 * np.arange(40)[:, None]
    return heights


def missing():
    heights = uneven()
    heights[3, 17] = heights[20:22, 5:7] = np.nan
    return heights


ROUGH = uneven()
CAPS = {"x": [0.0, 3.0], "y": [0.0, 0.0], "height": [0.2, 0.15], "radius": [2.0, 2.0]}


UNDER_LOAD = {"material": {"contact_modulus": 1e3},
              "loading": {"control": "load", "value": 2.0, "points": 3},
              "effects": {"interaction": "boundary"}}


def solve(package, upper, lower, **surfaces):
    """All numbers of positions, states and contacts under a load."""
    done = package.solve({"surfaces": {"upper": upper, "lower": lower, **surfaces}, **UNDER_LOAD})
    assert done.positions["contacts"][0] >= 1
    return repr([one.to_dict() for one in (done.positions, done.states, done.contacts)])


# ---------------------------------------------------------------- the same bits

@pytest.mark.parametrize("edge", ["free", "periodic"])
def test_arrays_and_files_give_the_same_bits(package, tmp_path, edge):
    """Arrays, .npy, surface data with 64-bit heights in metres, text with 17 digits, a topography
    of SurfaceTopography."""
    from SurfaceTopography import Topography
    heights = missing()
    np.save(tmp_path / "m.npy", heights)
    write_bytes(tmp_path / "m.sdf", np.where(np.isnan(heights), -np.finfo(float).max, heights),
                *SPACING)
    np.savetxt(tmp_path / "m.txt", heights, fmt="%.17g")
    edge_alone, options = {"map_edge": edge}, {"spacing": SPACING, "unit": "m"}
    spaced = {"map_spacing": SPACING, "map_unit": "m", **edge_alone}
    expected = solve(package, "plane", package.HeightMap(heights, SPACING, "m", edge == "periodic"))
    for own in (heights, heights.tolist(), np.asfortranarray(heights)):
        assert solve(package, "plane", own, **spaced) == expected
    of_array = package.summits(package.HeightMap(heights, SPACING, "m"))
    for name, words, known in (("m.npy", spaced, options), ("m.txt", spaced, options),
                               ("m.sdf", edge_alone, {})):
        assert solve(package, "plane", tmp_path / name, **words) == expected
        found = package.summits(tmp_path / name, **known)
        assert found == of_array and repr(found.statistics) == repr(of_array.statistics)
    whole = package.HeightMap(ROUGH, SPACING, "m", edge == "periodic")
    topography = Topography(ROUGH.T, whole.sizes, unit="m", periodic=whole.periodic)
    assert solve(package, "plane", topography) == solve(package, "plane", whole)


@pytest.mark.parametrize("kind", ["f8", "f4", *(f"{sign}{wide}" for sign in "iu" for wide in
                                                (1, 2, 4, 8))])
@pytest.mark.parametrize("byte_order", "<>")
@pytest.mark.parametrize("order", "CF")
def test_types_of_arrays(package, tmp_path, kind, byte_order, order):
    """Every type, order of bytes and of the array; the ends of each type among the heights."""
    rng = np.random.default_rng(8)
    values = rng.integers(0, 100, (5, 7)).astype(kind)
    if kind[0] == "f":
        values = (values / np.array(3.0, kind)).astype(kind)
        values[1, 2] = np.nan
    else:
        values[0, 1], values[4, 6] = np.iinfo(kind).min, np.iinfo(kind).max
    np.save(tmp_path / "m.npy", np.array(values, byte_order + kind, order=order))
    read = package.read_map(tmp_path / "m.npy", spacing=SPACING)
    assert (read.shape, read.spacing, read.unit) == ((5, 7), SPACING, None)
    assert np.array_equal(read.heights, values.astype(float), equal_nan=True)


def test_every_version_of_the_format(package, tmp_path):
    for version in ((1, 0), (2, 0), (3, 0)):
        with open(tmp_path / "m.npy", "wb") as file:
            np.lib.format.write_array(file, ROUGH, version=version)
        assert np.array_equal(package.read_map(tmp_path / "m.npy", spacing=SPACING).heights, ROUGH)


def test_large_whole_numbers_round_as_in_numpy(package, tmp_path):
    values = np.array([[2**63 + 1025, 2**63 + 1024, 2**63 + 1023], [2**64 - 1, 2**64 - 1024, 3],
                       [2**53 + 1, 2**53 + 3, 2**63 + 3071]], "u8")
    np.save(tmp_path / "m.npy", values)
    read = package.read_map(tmp_path / "m.npy", spacing=SPACING)
    assert np.array_equal(read.heights, values.astype(float))


def test_blocks_of_a_large_array(package, tmp_path):
    """Rows longer than the blocks that are read, in both orders."""
    heights = np.random.default_rng(5).normal(size=(5, 9001))
    for order in "CF":
        np.save(tmp_path / "m.npy", np.array(heights, order=order))
        assert np.array_equal(package.read_map(tmp_path / "m.npy", spacing=SPACING).heights,
                              heights)


def test_x_runs_along_the_row(package):
    """Two caps in different columns and rows: contacts and summits lie at column times the first
    spacing and row times the second."""
    rows, columns = np.mgrid[:40, :24]
    x, y = SPACING[0] * columns, SPACING[1] * rows
    places = [(4, 30, 0.3), (17, 8, 0.25)]
    heights = np.full((40, 24), -1.0)
    for column, row, top in places:
        square = (x - SPACING[0] * column)**2 + (y - SPACING[1] * row)**2
        heights = np.maximum(heights, top - square / 8)
    expected = {(SPACING[0] * column, SPACING[1] * row) for column, row, _ in places}
    surface = package.HeightMap(heights, SPACING, "um")
    found = package.summits(surface, level="none")
    assert set(zip(found["x"], found["y"])) == expected
    contacts = package.solve({
        "surfaces": {"upper": "plane", "lower": surface, "map_level": "none"},
        "material": {"contact_modulus": 1e3},
        "loading": {"control": "load", "value": 200.0, "points": 3},
        "effects": {"interaction": "boundary"}}).contacts
    for along in expected:
        assert np.hypot(contacts["x"] - along[0], contacts["y"] - along[1]).min() < 1e-3


# ---------------------------------------------------------------- sides

def test_asperities_beside_a_map(package, tmp_path):
    """Both as arrays, or one of them a file: the same. One radius serves a file without radii."""
    rows = ["x,y,height,radius", *(",".join(map(repr, row)) for row in zip(*CAPS.values()))]
    (tmp_path / "s.csv").write_text("\n".join(rows) + "\n")
    (tmp_path / "bare.csv").write_text("\n".join(row.rpartition(",")[0] for row in rows) + "\n")
    np.save(tmp_path / "m.npy", ROUGH)
    surface = package.HeightMap(ROUGH, SPACING, "um")
    both = solve(package, CAPS, surface)
    assert solve(package, tmp_path / "s.csv", surface) == both
    assert solve(package, CAPS, tmp_path / "m.npy", **OWN) == both
    assert solve(package, tmp_path / "bare.csv", CAPS, radius=(2.0, 2.0)) == solve(
        package, CAPS, CAPS)


def test_map_beside_a_map(package, tmp_path):
    """Two arrays, an array and a file on either side: the same; in two units, too."""
    upper, lower = uneven(), missing()[::-1]
    np.save(tmp_path / "u.npy", upper)
    np.save(tmp_path / "l.npy", lower)
    maps = [package.HeightMap(heights, SPACING, "um") for heights in (upper, lower)]
    both = solve(package, *maps)
    assert solve(package, tmp_path / "u.npy", maps[1], **OWN) == both
    assert solve(package, maps[0], tmp_path / "l.npy", **OWN) == both
    # An array without spacing and unit takes them from the group, as a file does.
    assert solve(package, maps[0], lower, map_spacing=SPACING, map_unit=("um", "um")) == both
    # The lower one in millimetres, whether it has a unit or the group names it: micrometres.
    small = package.HeightMap(lower / 1000, [step / 1000 for step in SPACING], "mm")
    bare = [package.HeightMap(one.heights, one.spacing) for one in (maps[0], small)]
    assert solve(package, maps[0], small) == solve(package, *bare, map_unit=("um", "mm"))


def test_units_of_maps_without_one(package, tmp_path):
    """map_unit names the unit of a matrix; a map that has one is converted."""
    np.savetxt(tmp_path / "m.txt", ROUGH, fmt="%.17g")
    bare = package.HeightMap(ROUGH, SPACING)
    for unit in (None, "mm", "um"):
        words = {"map_unit": unit} if unit else {}
        assert solve(package, "plane", tmp_path / "m.txt", map_spacing=SPACING, **words) == \
            solve(package, "plane", package.HeightMap(ROUGH, SPACING, unit))
    read = package.read_map(tmp_path / "m.txt", spacing=SPACING, unit="nm")
    assert (read.unit, read.spacing) == ("nm", SPACING) and np.array_equal(read.heights, ROUGH)
    # Summits, too: converted, or in the unit that is named.
    radii = [package.summits(one, unit="nm")["radius"]
             for one in (package.HeightMap(ROUGH, SPACING, "um"), bare)]
    assert np.allclose(radii[0], 1000 * radii[1], rtol=1e-12) and len(radii[0])
    named = package.HeightMap(ROUGH, SPACING, "um")
    assert solve(package, bare, bare, map_unit="um") == solve(package, named, named)


def test_edge_of_a_map(package):
    """A periodic map makes the scene periodic; map_edge has precedence."""
    heights, _ = self_affine((32, 24), 4, shortest=6, periodic=True)
    truth = {edge: solve(package, "plane", heights, map_edge=edge, **OWN)
             for edge in ("free", "periodic")}
    assert truth["free"] != truth["periodic"] and truth["free"] == solve(
        package, "plane", heights, **OWN)
    maps = {edge: package.HeightMap(heights, SPACING, "um", edge == "periodic") for edge in truth}
    for edge, one in maps.items():
        assert solve(package, "plane", one) == truth[edge]
        for other in truth:
            assert solve(package, "plane", one, map_edge=other) == truth[other]
    # Beside a map without an edge the other one's serves both.
    beside = [solve(package, maps["periodic"], heights, map_spacing=SPACING, map_unit=("um", "um"),
                    **words) for words in ({}, {"map_edge": "periodic"})]
    assert beside[0] == beside[1]
    with pytest.raises(package.InputError) as caught:
        solve(package, maps["periodic"], maps["free"])
    assert str(caught.value) == ("surfaces.upper: two maps: found one that is free and one that is "
                                 "periodic, expected both alike, or map_edge")


@pytest.mark.parametrize("unit, factor", [("nm", 1e3), ("mm", 1e-3), ("m", 1e-6)])
def test_a_map_is_converted_to_the_units_of_the_scene(package, unit, factor):
    """Each of two maps on its own; lengths are exact but for rounding."""
    other = package.HeightMap(ROUGH * factor, [step * factor for step in SPACING], unit)
    words = {"units": ("um", "uN"), "map_level": "none"}
    own = package.HeightMap(ROUGH, SPACING, "um")
    for upper in ("plane", own):
        scenes = [{"surfaces": {"upper": upper, "lower": one, **words}, **UNDER_LOAD}
                  for one in (other, own)]
        found, right = (package.solve(scene).positions["area"][0] for scene in scenes)
        assert found == pytest.approx(right, rel=1e-9) and right > 0


def test_a_map_without_a_unit_is_named(package):
    for unit, named in ((None, True), ("um", False)):
        text = package.solve({"surfaces": {"upper": "plane", "lower": package.HeightMap(
            ROUGH, SPACING, unit)}, **UNDER_LOAD}).summary
        assert ("lengths without a unit" in text) == named, text


# ---------------------------------------------------------------- refusals

def spoiled(value, place=(2, 3)):
    heights = ROUGH.copy()
    heights[place] = value
    return heights


@pytest.mark.parametrize("upper, lower, words, expected", [
    ("map", ROUGH, {}, "surfaces.lower: found heights without a spacing, expected map_spacing "
                       "along x and y"),
    ("plane", "map", {"map_spacing": 1.0}, "surfaces.lower: map_spacing given, but the map has "
                                           "its own"),
    ("map", "map", {"map_spacing": 1.0}, "map_spacing: found although both maps have their own"),
    ("plane", "plane", {}, "lower: found two planes"),
    ("map", "plane", {"deck": "a.deck"}, "deck: found beside"),
    (CAPS, "plane", {"radius": (1.0, 2.0)}, "radius: found although both surfaces have radii"),
    (CAPS, "plane", {"map_unit": "um"}, "map_unit: found without a map"),
    ("map", "plane", {"radius": 1.0}, "radius: found beside a map"),
    ("plane", "map", {"units": ("mm", "N"), "map_unit": "um"},
     "units: found length 'mm' beside 'um' of the map"),
    ("plane", spoiled(np.inf), OWN, "surfaces.lower.height: found Infinity at [2][3], expected a "
                                    "height of at most 1e30, or NaN where missing"),
    ("plane", spoiled(-1e31), OWN, "surfaces.lower.height: found -1.000000E+031 at [2][3]"),
    ("plane", spoiled(np.nan, slice(None)), OWN, "surfaces.lower: all pixels are missing"),
    ("plane", ROUGH[:, :2], OWN, "surfaces.lower: found 2 x 40 pixels, expected at least 3"),
    ("plane", ROUGH, {**OWN, "map_unit": "furlong"}, "found the text 'furlong', expected"),
    ("plane", "no.npy", OWN, "no.npy:1:1: cannot be opened")])
def test_a_bad_array_is_refused_by_its_side(package, upper, lower, words, expected):
    """A sentence that names the side."""
    good = package.HeightMap(ROUGH, SPACING, "um")
    upper, lower = (good if isinstance(one, str) and one == "map" else one
                    for one in (upper, lower))
    with pytest.raises(package.InputError) as caught:
        solve(package, upper, lower, **words)
    assert expected in str(caught.value) and str(caught.value).count("\n") <= 1


def array_bytes(descr="'<f8'", order="False", shape="(3, 4)", pixels=96, version=1, **changes):
    text = f"{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}"
    text = changes.get("text", text).encode() + b" " * 20 + b"\n"
    length = changes.get("length", len(text)).to_bytes(2 if version == 1 else 4, "little")
    return b"\x93NUMPY" + bytes([version, 0]) + length + text + bytes(pixels)


@pytest.mark.parametrize("data, expected", [
    (array_bytes("'<f2'"), "type of the array: found '<f2', expected float64 or float32"),
    (array_bytes("'<c16'"), "type of the array: found '<c16'"),
    (array_bytes("'=f8'"), "type of the array: found '=f8'"),
    (array_bytes("[('a', '<f8'), ('b', '<f8')]"), "type of the array: found "),
    (array_bytes(shape="(12,)"), "shape of the array: found '(12,)', expected (ROWS, COLUMNS)"),
    (array_bytes(shape="()"), "shape of the array: found '()'"),
    (array_bytes(shape="(1, 3, 4)"), "shape of the array: found '(1, 3, 4)'"),
    (array_bytes(shape="(3.0, 4)"), "shape of the array: found '(3.0, 4)'"),
    (array_bytes(shape="(0, 4)", pixels=0), "found 4 x 0 pixels, expected at least 3 x 3"),
    (array_bytes(shape="(4294967296, 4294967296)"), "at most 536870912 pixels a side"),
    (array_bytes(shape="(99999999999999999999999, 3)"), "at most 536870912 pixels a side"),
    (array_bytes(pixels=95), "found 95 bytes behind the header, expected 96 for shape (3, 4) of 8 "
                             "bytes a pixel"),
    (array_bytes(pixels=97), "found 97 bytes behind the header, expected 96"),
    (array_bytes(version=0), "version of the array format: found 0, expected 1, 2 or 3"),
    (array_bytes(version=2, length=2**32 - 1), "length of the header: found 4294967295"),
    (array_bytes(length=9999, pixels=0), "the file ends in the header"),
    (array_bytes(order="None"), "header: found "),
    (array_bytes(text="{'descr': '<f8', 'shape': (3, 4), }"), "header: found "),
    (array_bytes(text="{'descr': '<f8', 'descr': '<f8', 'fortran_order': False, 'shape': (3, 4)}"),
     "header: found "),
    (array_bytes(text="{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), 'more': 1}"),
     "header: found "),
    (array_bytes(text="{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4)} x"),
     "header: found "),
    (array_bytes(text=""), "header: found "),
    (array_bytes(text="{'descr"), "header: found "),
    (b"\x93NUMPY", "version of the array format"),
    (b"\x93NUMPY\x01\x00\x01", "the file ends in the header"),
    (array_bytes(pixels=0) + np.array([np.inf, *range(11)]).tobytes(),
     "byte 91, pixel [0][0]: found an infinite or too large height")])
def test_refused_arrays(asperity, tmp_path, data, expected):
    """With file, what was found and what is expected; from a pipe, too."""
    (tmp_path / "m.npy").write_bytes(data)
    done = run_program(asperity, "summits", "m.npy", "--spacing=1,1", status=2, cwd=tmp_path)
    assert expected in done.stderr and done.stderr.startswith("m.npy"), done.stderr
    assert done.stderr.count("\n") == 1 and "expected" in done.stderr
    done = run_program(asperity, "summits", "-", "--spacing=1,1", status=2, input=data, text=False)
    assert done.stderr.count(b"\n") == 1, done.stderr


@pytest.mark.parametrize("rows, columns", [(65536, 65536), (46341, 46342), (3, 2**29)])
@pytest.mark.parametrize("ending", ["npy", "sdf"])
def test_more_pixels_than_32_bits_count(asperity, tmp_path, ending, rows, columns):
    """Memory is their one limit, in its right number of bytes: whole sparse files."""
    head = array_bytes(shape=f"({rows}, {columns})", pixels=0) if ending == "npy" else (
        b"bISO-2.0asperity  " + b"0" * 24 + np.array([columns, rows], "<u4").tobytes() +
        np.array([1e-6, 1e-6, 1.0, -1.0]).tobytes() + bytes([0, 7, 0]))
    with open(tmp_path / "m", "wb") as file:
        file.write(head)
        file.truncate(len(head) + 8 * rows * columns)
    done = run_program("bash", "-c", f"ulimit -v 2000000; {asperity} summits m " +
                       "--spacing=1,1" * (ending == "npy"), status=1, cwd=tmp_path)
    assert done.stderr == (f"m: not enough memory for the map, {columns} x {rows} pixels, "
                           f"{8 * rows * columns} bytes\n")


# ---------------------------------------------------------------- files that are written

@pytest.mark.parametrize("unit", ["m", "um", "nm", "in"])
@pytest.mark.parametrize("ending", ["sdf", "npy", "txt", "NPY"])
@pytest.mark.parametrize("periodic", [False, True])
def test_written_and_read(package, tmp_path, ending, periodic, unit):
    """All bits of heights come back, and spacing and unit where the format has them: surface data
    has the spacing in metres, rounded twice. The comments of a text are noted where a spacing is
    given, and read where none is."""
    path, spacing = tmp_path / f"m.{ending}", (0.1, 1 / 3)
    bare = ending != "sdf"
    for heights in (ROUGH, missing()):
        package.HeightMap(heights, spacing, unit, periodic).write(path)
        read = package.read_map(path, spacing=spacing if bare else None, unit=unit)
        assert (len(read.notes), read.unit) == (ending == "txt", unit)
        assert read.spacing == (spacing if bare else pytest.approx(spacing, rel=2.3e-16, abs=0))
        assert not read.periodic
        assert np.array_equal(read.heights, heights, equal_nan=True)
    if ending == "txt":
        read, scaled = package.read_map(path), package.read_map(path, unit="mm")
        assert (read.spacing, read.unit, read.periodic, read.notes) == (spacing, unit, periodic, [])
        assert np.array_equal(read.heights, heights, equal_nan=True)
        ratio = {"m": 1e3, "um": 1e-3, "nm": 1e-6, "in": 25.4}[unit]
        assert (scaled.unit, scaled.periodic) == ("mm", periodic)
        assert scaled.spacing == pytest.approx([step * ratio for step in spacing], rel=1e-15)
        assert np.allclose(scaled.heights, heights * ratio, rtol=1e-15, equal_nan=True)


def test_read_by_numpy(package, tmp_path):
    surface = package.HeightMap(missing(), SPACING, "um")
    surface.write(tmp_path / "m.npy")
    found = np.load(tmp_path / "m.npy")
    assert found.dtype == "<f8" and found.flags.c_contiguous
    assert np.array_equal(found, surface.heights, equal_nan=True)
    with open(tmp_path / "m.npy", "rb") as file:
        np.lib.format.read_magic(file)
        np.lib.format.read_array_header_1_0(file)
        assert file.tell() % 64 == 0
    surface.write(tmp_path / "m.txt")
    assert np.array_equal(np.loadtxt(tmp_path / "m.txt"), surface.heights, equal_nan=True)
    assert (tmp_path / "m.txt").read_text().startswith(
        "# Spacing: 5.0000000000000000E-001 3.7500000000000000E-001\n# Units: um\n")


@pytest.mark.long
@NEEDS_SDFIO
def test_read_by_sdfio(package, tmp_path):
    """Metres by the header; a wide map has the longer header of ISO-2.0."""
    import sdfio
    for heights in (missing(), np.arange(3.0 * 65536).reshape(3, 65536)):
        package.HeightMap(heights, SPACING, "um").write(tmp_path / "m.sdf")
        found = sdfio.read(tmp_path / "m.sdf")
        header = found.header
        assert found.data.shape == heights.shape
        assert (header.x_scale, header.y_scale) == pytest.approx([0.5e-6, 0.375e-6], rel=1e-15)
        assert header.z_scale == 1e-6
        assert np.array_equal(found.data, heights * header.z_scale, equal_nan=True)


@pytest.mark.parametrize("unit, name, error, expected", [
    ("um", "m.csv", "InputError", "found another ending, expected .sdf, .npy or .txt"),
    ("um", "sdf", "InputError", "found another ending"),
    ("um", "a.sdf/m", "InputError", "found another ending"),
    (None, "m.sdf", "InputError", "found a map without a unit"),
    ("um", "none/m.npy", "ComputeError", "cannot be written: No such file or directory")])
def test_refused_to_write(package, tmp_path, unit, name, error, expected):
    with pytest.raises(getattr(package, error), match=expected):
        package.HeightMap(ROUGH, SPACING, unit).write(tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_a_full_disk(package):
    if not os.path.exists("/dev/full"):
        pytest.skip("no /dev/full here")
    os.symlink("/dev/full", path := f"/tmp/full.{os.getpid()}.npy")
    try:
        with pytest.raises(package.ComputeError, match="No space left on device"):
            package.HeightMap(np.random.default_rng(1).normal(size=(200, 200)), 1.0).write(path)
    finally:
        os.unlink(path)
