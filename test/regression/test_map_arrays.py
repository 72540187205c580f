"""Height maps as arrays: the functions for C take them, `.npy` is read as any other map, and the
same map gives the same numbers to the last bit, however it comes."""

import ctypes
import os
import sys
from ctypes import POINTER, Structure, byref, c_char_p, c_double, c_int, c_void_p

import numpy as np
import pytest

from made_maps import self_affine, write_bytes
from programs import run_program

# The library of the package, not the build under test: `checks` runs this file with its own.
pytestmark = pytest.mark.once

NEEDS_SDFIO = pytest.mark.skipif(sys.version_info < (3, 11), reason="sdfio needs Python 3.11")
DONE, NOT_COMPUTED, BAD_INPUT = range(3)
FAILURE, PROBLEMS, NOTES, UNIT = 1, 2, 4, 7
POSITIONS, STATES, CONTACTS, SUMMITS, STATISTICS, MAP, PIXELS = 1, 2, 3, 4, 5, 8, 9
# Along x and y; their products with whole numbers are exact.
SPACING = (0.5, 0.375)


class CSurface(Structure):
    _fields_ = [("count", c_int), ("radii", c_int),
                *((name, POINTER(c_double)) for name in ("x", "y", "height", "radius"))]


class CMap(Structure):
    _fields_ = [("columns", c_int), ("rows", c_int), ("height", POINTER(c_double)),
                ("spacing", c_double * 2), ("unit", c_char_p), ("periodic", c_int)]


class CSide(Structure):
    _fields_ = [("asperities", POINTER(CSurface)), ("map", POINTER(CMap))]


class CSummitsOptions(Structure):
    _fields_ = [("rule", c_char_p), ("level", c_char_p), ("radius", c_char_p), ("unit", c_char_p),
                ("spacing", c_double * 2), ("despike", c_int)]


def doubles(values):
    return np.ascontiguousarray(values, float).ctypes.data_as(POINTER(c_double))


def height_map(heights, spacing=SPACING, unit=b"um", periodic=-1):
    """The map of the header; it keeps the heights alive."""
    heights = np.ascontiguousarray(heights, float)
    rows, columns = heights.shape
    made = CMap(columns, rows, doubles(heights), (c_double * 2)(*spacing), unit, periodic)
    made.keep = heights
    return made


def side_of(given):
    """A side of a map, of asperities as four lists, of the word 'plane', or NULL."""
    if given is None:
        return None
    if isinstance(given, CMap):
        made = CSide(None, ctypes.pointer(given))
    elif isinstance(given, CSide):
        return byref(given)
    else:
        columns = [] if given == "plane" else [np.array(c, float) for c in given]
        surface = CSurface(*(2 * [len(columns[0])] if columns else [0, 0]),
                           *map(doubles, columns))
        made = CSide(ctypes.pointer(surface), None)
        made.keep = columns
    return byref(made)


class Outcome:
    """What a call gave."""

    def __init__(self, library, handle):
        self.c, self.handle = library, handle
        self.status = library.asperity_status(handle)

    def __del__(self):
        self.c.asperity_free(self.handle)

    def text(self, which):
        return self.c.asperity_text(self.handle, which).decode()

    @property
    def wrong(self):
        return self.text(FAILURE) + self.text(PROBLEMS)

    def table(self, which):
        """Columns by name; words left out."""
        rows = self.c.asperity_rows(self.handle, which)
        found = {}
        for i in range(self.c.asperity_columns(self.handle, which)):
            kind = self.c.asperity_column_type(self.handle, which, i)
            if kind not in (1, 2) or not rows:
                continue
            cells = ctypes.cast(self.c.asperity_column(self.handle, which, i),
                                POINTER({1: c_double, 2: c_int}[kind]))
            name = self.c.asperity_column_name(self.handle, which, i).decode()
            found[name] = np.ctypeslib.as_array(cells, (rows,)).copy()
        return found


class Library:
    """The functions of include/asperity.h that take maps."""

    def __init__(self, path):
        self.c = c = ctypes.CDLL(str(path))
        for name in ("text", "column_name"):
            getattr(c, f"asperity_{name}").restype = c_char_p
        for name in ("build_scene_of", "summits_of_map", "read_map", "write_map", "solve_scene",
                     "summits", "column", "read_scene"):
            getattr(c, f"asperity_{name}").restype = c_void_p
        for name, arguments in (("status", [c_void_p]), ("free", [c_void_p]),
                                ("text", [c_void_p, c_int]), ("rows", [c_void_p, c_int]),
                                ("columns", [c_void_p, c_int]), ("solve_scene", 2 * [c_void_p]),
                                *((f"column{end}", [c_void_p, c_int, c_int])
                                  for end in ("", "_name", "_type"))):
            getattr(c, f"asperity_{name}").argtypes = arguments

    def build(self, groups, upper, lower):
        return Outcome(self.c, self.c.asperity_build_scene_of(groups.encode(), side_of(upper),
                                                              side_of(lower)))

    def solve(self, groups, upper, lower):
        scene = self.build(groups, upper, lower)
        return Outcome(self.c, self.c.asperity_solve_scene(scene.handle, None))

    def solve_file(self, path):
        scene = Outcome(self.c, self.c.asperity_read_scene(str(path).encode()))
        return Outcome(self.c, self.c.asperity_solve_scene(scene.handle, None))

    def summits(self, given, **options):
        chosen = CSummitsOptions(spacing=(c_double * 2)(*options.pop("spacing", (0, 0))), **options)
        if isinstance(given, CMap):
            return Outcome(self.c, self.c.asperity_summits_of_map(byref(given), byref(chosen)))
        return Outcome(self.c, self.c.asperity_summits(str(given).encode(), byref(chosen)))

    def read(self, path, spacing=None, unit=None):
        along = spacing and (c_double * 2)(*spacing)
        return Outcome(self.c, self.c.asperity_read_map(str(path).encode(), along, unit))

    def write(self, given, path):
        return Outcome(self.c, self.c.asperity_write_map(byref(given), str(path).encode()))


@pytest.fixture(scope="module")
def library(package_folder):
    return Library(package_folder / "asperity" / "libasperity.so")


def uneven():
    """40 rows of 24 pixels, whole numbers from 1 to 100 in turn with real ones; no symmetry."""
    heights, _ = self_affine((40, 24), 3, shortest=6)
    heights += 0.02 * np.arange(24) + 0.05 * np.arange(40)[:, None]
    return heights


def missing():
    heights = uneven()
    heights[3, 17] = heights[20:22, 5:7] = np.nan
    return heights


def same_tables(first, second, tables=(POSITIONS, STATES, CONTACTS)):
    """Both were computed, and all numbers are the same bits."""
    assert (first.status, first.wrong, second.status, second.wrong) == (DONE, "", DONE, "")
    for which in tables:
        one, other = first.table(which), second.table(which)
        assert one.keys() == other.keys() and one
        for name in one:
            assert one[name].tobytes() == other[name].tobytes(), name


GROUPS = ("&material contact_modulus = 1e3 / &loading control = 'load', value = 2., points = 3 / "
          "&effects interaction = '{}' / &surfaces {} /")


# ---------------------------------------------------------------- the same bits

@pytest.mark.parametrize("make", [uneven, missing])
@pytest.mark.parametrize("interaction", ["off", "boundary"])
def test_same_bits_however_it_comes(library, tmp_path, make, interaction):
    """Array, .npy, surface data with 64-bit heights in metres, text with 17 digits."""
    heights = make()
    np.save(tmp_path / "m.npy", heights)
    write_bytes(tmp_path / "m.sdf", np.where(np.isnan(heights), -np.finfo(float).max, heights),
                *SPACING)
    np.savetxt(tmp_path / "m.txt", heights, fmt="%.17g")
    spaced = "map_spacing = 0.5, 0.375, map_unit = 'm'"
    array = library.solve(GROUPS.format(interaction, ""), "plane",
                          height_map(heights, unit=b"m"))
    bare = library.solve(GROUPS.format(interaction, spaced), "plane",
                         height_map(heights, (0, 0), None))
    same_tables(array, bare)
    for name, words in (("m.npy", spaced), ("m.sdf", ""), ("m.txt", spaced)):
        named = f"lower = '{tmp_path / name}', {words}"
        file = library.solve(GROUPS.format(interaction, named), "plane", None)
        same_tables(array, file)
        options = {} if name == "m.sdf" else {"spacing": SPACING, "unit": b"m"}
        same_tables(library.summits(height_map(heights, unit=b"m")),
                    library.summits(tmp_path / name, **options), (SUMMITS, STATISTICS))


@pytest.mark.parametrize("kind", ["f8", "f4", *(f"{sign}{wide}" for sign in "iu" for wide in
                                                (1, 2, 4, 8))])
@pytest.mark.parametrize("byte_order", "<>")
@pytest.mark.parametrize("order", "CF")
def test_types_of_arrays(library, tmp_path, kind, byte_order, order):
    """Every type, order of bytes and of the array; the ends of each type among the heights."""
    rng = np.random.default_rng(8)
    values = rng.integers(0, 100, (5, 7)).astype(kind)
    if kind[0] == "f":
        values = (values / np.array(3.0, kind)).astype(kind)
        values[1, 2] = np.nan
    else:
        values[0, 1], values[4, 6] = np.iinfo(kind).min, np.iinfo(kind).max
    np.save(tmp_path / "m.npy", np.array(values, byte_order + kind, order=order))
    read = library.read(tmp_path / "m.npy", SPACING)
    assert (read.status, read.wrong, read.text(UNIT)) == (DONE, "", "")
    table = read.table(MAP)
    assert [table[name][0] for name in ("columns", "rows", "spacing_x", "spacing_y")] == [
        7, 5, *SPACING]
    assert table["columns"].dtype == np.intc
    pixels = read.table(PIXELS)["height"].reshape(5, 7)
    assert pixels.tobytes() == values.astype(float).tobytes() or (
        np.array_equal(pixels, values.astype(float), equal_nan=True))


def test_every_version_of_the_format(library, tmp_path):
    heights = uneven()
    for version in ((1, 0), (2, 0), (3, 0)):
        with open(tmp_path / "m.npy", "wb") as file:
            np.lib.format.write_array(file, heights, version=version)
        read = library.read(tmp_path / "m.npy", SPACING)
        assert read.wrong == ""
        assert read.table(PIXELS)["height"].tobytes() == heights.tobytes()


def test_large_whole_numbers_round_as_in_numpy(library, tmp_path):
    values = np.array([[2**63 + 1025, 2**63 + 1024, 2**63 + 1023], [2**64 - 1, 2**64 - 1024, 3],
                       [2**53 + 1, 2**53 + 3, 2**63 + 3071]], "u8")
    np.save(tmp_path / "m.npy", values)
    pixels = library.read(tmp_path / "m.npy", SPACING).table(PIXELS)["height"]
    assert np.array_equal(pixels, values.astype(float).ravel())


def test_blocks_of_a_large_array(library, tmp_path):
    """Rows longer than the blocks that are read, in both orders."""
    heights = np.random.default_rng(5).normal(size=(5, 9001))
    for order in "CF":
        np.save(tmp_path / "m.npy", np.array(heights, order=order))
        pixels = library.read(tmp_path / "m.npy", SPACING).table(PIXELS)["height"]
        assert pixels.tobytes() == heights.tobytes()


# ---------------------------------------------------------------- orientation

def test_x_runs_along_the_row(library, tmp_path):
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
    found = library.summits(height_map(heights), level=b"none").table(SUMMITS)
    assert set(zip(found["x"], found["y"])) == expected
    groups = GROUPS.format("boundary", "map_level = 'none'").replace("value = 2.", "value = 200.")
    contacts = library.solve(groups, "plane", height_map(heights)).table(CONTACTS)
    for along in expected:
        assert np.hypot(contacts["x"] - along[0], contacts["y"] - along[1]).min() < 1e-3
    np.save(tmp_path / "m.npy", np.asfortranarray(heights))
    same_tables(library.summits(height_map(heights), level=b"none"),
                library.summits(tmp_path / "m.npy", level=b"none", unit=b"um", spacing=SPACING),
                (SUMMITS, STATISTICS))


# ---------------------------------------------------------------- sides

CAPS = ([0.0, 3.0], [0.0, 0.0], [0.2, 0.15], [2.0, 2.0])


def test_asperities_as_before(library):
    """Asperities beside a plane, and beside a file of asperities."""
    groups = GROUPS.format("off", "nominal_area = 10.")
    one = library.solve(groups, CAPS, "plane")
    assert one.wrong == "" and one.table(POSITIONS)["contacts"][0] >= 1
    same_tables(one, library.solve(GROUPS.format("off", "nominal_area = 10., lower = 'plane'"),
                                   CAPS, None))


def test_asperities_beside_a_file(library, tmp_path):
    lines = ["x,y,height,radius", *(",".join(map(repr, row)) for row in zip(*CAPS))]
    (tmp_path / "s.csv").write_text("\n".join(lines) + "\n")
    (tmp_path / "bare.csv").write_text("\n".join(line.rpartition(",")[0] for line in lines) + "\n")
    arrays = library.solve(GROUPS.format("off", ""), CAPS, CAPS)
    same_tables(arrays, library.solve(GROUPS.format("off", f"lower = '{tmp_path / 's.csv'}'"),
                                      CAPS, None))
    same_tables(arrays, library.solve(GROUPS.format("off", f"upper = '{tmp_path / 'bare.csv'}', "
                                                    "radius = 2., 2."), None, CAPS))


def test_asperities_beside_a_map(library, tmp_path):
    """Both as arrays, or one of them a file: the same."""
    lines = ["x,y,height,radius", *(",".join(map(repr, row)) for row in zip(*CAPS))]
    (tmp_path / "s.csv").write_text("\n".join(lines) + "\n")
    np.save(tmp_path / "m.npy", ROUGH)
    groups = GROUPS.format("boundary", "{}")
    both = library.solve(groups.format(""), CAPS, height_map(ROUGH))
    assert both.wrong == "" and both.table(POSITIONS)["contacts"][0] >= 1
    same_tables(both, library.solve(groups.format(f"upper = '{tmp_path / 's.csv'}'"), None,
                                    height_map(ROUGH)))
    same_tables(both, library.solve(
        groups.format(f"lower = '{tmp_path / 'm.npy'}', map_spacing = 0.5, 0.375, map_unit = 'um'"),
        CAPS, None))


@pytest.mark.parametrize("interaction", ["off", "boundary"])
def test_map_beside_a_map(library, tmp_path, interaction):
    """Two arrays, an array and a file on either side: the same; in two units, too."""
    upper, lower = uneven(), missing()[::-1]
    np.save(tmp_path / "u.npy", upper)
    np.save(tmp_path / "l.npy", lower)
    both = library.solve(GROUPS.format(interaction, ""), height_map(upper), height_map(lower))
    file_above = library.solve(
        GROUPS.format(interaction, f"upper = '{tmp_path / 'u.npy'}', map_spacing = 0.5, 0.375, "
                      "map_unit = 'um'"), None, height_map(lower))
    file_below = library.solve(
        GROUPS.format(interaction, f"lower = '{tmp_path / 'l.npy'}', map_spacing = 0.5, 0.375, "
                      "map_unit = 'um'"), height_map(upper), None)
    same_tables(both, file_above)
    same_tables(both, file_below)
    # An array without spacing and unit takes them from the text, as a file does.
    same_tables(both, library.solve(
        GROUPS.format(interaction, "map_spacing = 0.5, 0.375, map_unit = 'um', 'um'"),
        height_map(upper), height_map(lower, (0, 0), None)))
    # The lower one in millimetres, whether it has a unit or the text names it: micrometres.
    small, own = lower / 1000, np.array(SPACING) / 1000
    one = library.solve(GROUPS.format(interaction, ""), height_map(upper),
                        height_map(small, own, b"mm"))
    same_tables(one, library.solve(GROUPS.format(interaction, "map_unit = 'um', 'mm'"),
                                   height_map(upper, unit=None), height_map(small, own, None)))
    assert one.table(POSITIONS)["area"] == pytest.approx(both.table(POSITIONS)["area"], rel=1e-6)


def test_units_of_maps_without_one(library, tmp_path):
    """map_unit names the unit of a matrix; a map that has one is converted."""
    heights = uneven()
    np.savetxt(tmp_path / "m.txt", heights, fmt="%.17g")
    text = f"lower = '{tmp_path / 'm.txt'}', map_spacing = 0.5, 0.375"
    for words, unit in (("", ""), (", map_unit = 'mm'", "mm"), (", map_unit = 'um'", "um")):
        solved = library.solve(GROUPS.format("off", text + words), "plane", None)
        same_tables(solved, library.solve(GROUPS.format("off", ""), "plane",
                                          height_map(heights, unit=unit.encode())))
    read = library.read(tmp_path / "m.txt", SPACING, b"nm")
    assert (read.text(UNIT), read.table(MAP)["spacing_x"][0]) == ("nm", 0.5)
    assert read.table(PIXELS)["height"].tobytes() == heights.tobytes()
    # Summits, too: converted, or in the unit that is named.
    found = [library.summits(height_map(heights, unit=own), unit=b"nm").table(SUMMITS)["radius"]
             for own in (b"um", None)]
    assert found[0] == pytest.approx(1000 * found[1], rel=1e-12) and len(found[0])
    # One value serves two maps without a unit, and converts one that has a unit.
    both = library.solve(GROUPS.format("off", "map_unit = 'um'"), height_map(heights, unit=None),
                         height_map(heights, unit=b""))
    same_tables(both, library.solve(GROUPS.format("off", ""), height_map(heights),
                                    height_map(heights)))


def test_edge_of_a_map(library):
    """A periodic array makes the scene periodic; map_edge has precedence."""
    heights, _ = self_affine((32, 24), 4, shortest=6, periodic=True)
    words = {"periodic": "map_edge = 'periodic'", "free": "map_edge = 'free'"}
    truth = {edge: library.solve(GROUPS.format("boundary", words[edge]), "plane",
                                 height_map(heights)) for edge in words}
    assert (truth["free"].table(POSITIONS)["separation"] !=
            truth["periodic"].table(POSITIONS)["separation"])
    for own in (-1, 0, 1):
        given = height_map(heights, periodic=own)
        for edge, word in words.items():
            same_tables(library.solve(GROUPS.format("boundary", word), "plane", given), truth[edge])
        same_tables(library.solve(GROUPS.format("boundary", ""), "plane", given),
                    truth["periodic" if own == 1 else "free"])
    # Beside a map without an edge the other one's serves both.
    pair = [height_map(heights, periodic=own) for own in (1, -1)]
    same_tables(library.solve(GROUPS.format("boundary", ""), *pair),
                library.solve(GROUPS.format("boundary", words["periodic"]), *pair))
    mixed = library.solve(GROUPS.format("boundary", ""), pair[0], height_map(heights, periodic=0))
    assert mixed.status == BAD_INPUT
    assert mixed.wrong == ("surfaces.upper: two maps: found one that is free and one that is "
                           "periodic, expected both alike, or map_edge\n")


def test_summits_of_a_periodic_array(library, asperity, tmp_path):
    """As --edge periodic does."""
    heights, _ = self_affine((32, 24), 4, shortest=6, periodic=True)
    np.save(tmp_path / "m.npy", heights)
    run_program(asperity, "summits", "m.npy", "--spacing", "0.5,0.375", "--unit", "um", "--edge",
                "periodic", "--quiet", "--output", "s.csv", cwd=tmp_path)
    rows = np.loadtxt(tmp_path / "s.csv", delimiter=",", skiprows=1)
    found = library.summits(height_map(heights, periodic=1)).table(SUMMITS)
    assert np.array_equal(rows, np.column_stack([found[n] for n in ("x", "y", "height", "radius")]))
    free = library.summits(height_map(heights, periodic=0)).table(SUMMITS)
    assert len(free["x"]) < len(rows)


# ---------------------------------------------------------------- refusals

ROUGH = uneven()
GOOD = height_map(ROUGH)
BARE = height_map(ROUGH, (0, 0), None)


def changed(**fields):
    made = height_map(ROUGH)
    for name, value in fields.items():
        setattr(made, name, value)
    return made


def spoiled(value, place=(2, 3)):
    heights = ROUGH.copy()
    heights[place] = value
    return height_map(heights)


@pytest.mark.parametrize("upper, lower, words, expected", [
    ("plane", BARE, "", "surfaces.lower: found heights without a spacing, expected map_spacing "
                        "along x and y"),
    (GOOD, BARE, "", "surfaces.lower: found heights without a spacing"),
    ("plane", GOOD, "map_spacing = 1., 1.", "surfaces.lower: map_spacing given, but the map has "
                                            "its own"),
    (GOOD, GOOD, "map_spacing = 1., 1.", "map_spacing: found although both maps have their own"),
    ("plane", "plane", "", "surfaces.lower: found two planes"),
    ("plane", None, "lower = 'plane'", "lower: found two planes"),
    (GOOD, None, "", "a surface is missing: found one as an array, expected the other one as an "
                     "array, too, or its file or 'plane' as lower"),
    (None, GOOD, "", "or its file or 'plane' as upper"),
    (GOOD, "plane", "upper = 'plane'", "upper: found beside a surface that is given as an array"),
    (GOOD, "plane", "deck = 'a.deck'", "deck: found beside a surface that is given as an array"),
    (CAPS, "plane", "radius = 1., 2.", "radius: found although both surfaces have radii"),
    (CAPS, "plane", "map_unit = 'um'", "map_unit: found without a map"),
    (GOOD, "plane", "radius = 1.", "radius: found beside a map"),
    (GOOD, height_map(ROUGH, (0.5, 0.4)), "map_edge = 'periodic', map_level = 'mean'",
     "surfaces.upper: two periodic maps: found 24 x 40 pixels of"),
    (CSide(ctypes.pointer(CSurface()), ctypes.pointer(GOOD)), "plane", "",
     "surfaces.upper: found asperities and a map, expected one of them"),
    ("plane", GOOD, "units = 'mm', 'N'", "units: found length 'mm' beside 'um' of the map"),
    ("plane", changed(columns=0), "", "surfaces.lower.columns: found 0, expected 3 or more"),
    ("plane", changed(columns=-5, rows=-5), "", "surfaces.lower.rows: found -5"),
    ("plane", changed(columns=2**31 - 1, rows=2), "", "surfaces.lower: found 2147483647 x 2"),
    ("plane", changed(columns=2), "", "surfaces.lower: found 2 x 40 pixels, expected at least 3"),
    ("plane", changed(height=None), "", "surfaces.lower.height: found NULL"),
    ("plane", changed(periodic=2), "", "surfaces.lower.periodic: found 2, expected 1, 0, or -1"),
    ("plane", changed(unit=b"furlong"), "", "surfaces.lower.unit: found furlong, expected one of "
                                            "m, mm, um, nm, cm, in, or none"),
    ("plane", changed(spacing=(c_double * 2)(1.0, 0.0)), "", "surfaces.lower.spacing: found 1.0"),
    ("plane", changed(spacing=(c_double * 2)(np.nan, np.nan)), "",
     "surfaces.lower.spacing: found NaN, NaN"),
    ("plane", changed(spacing=(c_double * 2)(-1.0, -1.0)), "", "surfaces.lower.spacing: found -1"),
    ("plane", spoiled(np.inf), "", "surfaces.lower.height: found Infinity at [2][3], expected a "
                                   "height of at most 1e30, or NaN where missing"),
    ("plane", spoiled(-1e31), "", "surfaces.lower.height: found -1.000000E+031 at [2][3]"),
    ("plane", spoiled(np.nan, slice(None)), "", "surfaces.lower: all pixels are missing"),
    ("plane", None, "lower = 'no.npy'", "no.npy:1:1: cannot be opened")])
def test_refused(library, upper, lower, words, expected):
    """One sentence, which names the side."""
    scene = library.build(GROUPS.format("off", words), upper, lower)
    assert scene.status == BAD_INPUT
    assert expected in scene.wrong and scene.wrong.count("\n") <= 2, scene.wrong


@pytest.mark.parametrize("given, options, expected", [
    (BARE, {}, "found heights without a spacing, expected spacing along x and y"),
    (GOOD, {"spacing": (1.0, 1.0)}, "spacing given, but the map has its own"),
    (BARE, {"spacing": (1.0, -1.0)}, "spacing: found 1.0"),
    (GOOD, {"unit": b"mile"}, "unit: found mile, expected one of m, mm"),
    (changed(periodic=1), {"level": b"plane"}, "level: a periodic map without its plane"),
    (changed(rows=0), {}, "map.rows: found 0")])
def test_refused_summits(library, given, options, expected):
    found = library.summits(given, **options)
    assert found.status == BAD_INPUT and expected in found.wrong


def array_bytes(descr="'<f8'", order="False", shape="(3, 4)", pixels=96, version=1, **changes):
    text = f"{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}"
    text = changes.get("text", text).encode() + b" " * 20 + b"\n"
    length = changes.get("length", len(text)).to_bytes(2 if version == 1 else 4, "little")
    return b"\x93NUMPY" + bytes([version, 0]) + length + text + bytes(pixels)


@pytest.mark.parametrize("data, expected", [
    (array_bytes("'<f2'"), "type of the array: found '<f2', expected float64 or float32"),
    (array_bytes("'<c16'"), "type of the array: found '<c16'"),
    (array_bytes("'|b1'"), "type of the array: found '|b1'"),
    (array_bytes("'=f8'"), "type of the array: found '=f8'"),
    (array_bytes("[('a', '<f8'), ('b', '<f8')]"), "type of the array: found "),
    (array_bytes(shape="(12,)"), "shape of the array: found '(12,)', expected (ROWS, COLUMNS)"),
    (array_bytes(shape="()"), "shape of the array: found '()'"),
    (array_bytes(shape="(1, 3, 4)"), "shape of the array: found '(1, 3, 4)'"),
    (array_bytes(shape="(-3, 4)"), "shape of the array: found '(-3, 4)'"),
    (array_bytes(shape="(3.0, 4)"), "shape of the array: found '(3.0, 4)'"),
    (array_bytes(shape="(0, 4)", pixels=0), "found 4 x 0 pixels, expected at least 3 x 3"),
    (array_bytes(shape="(0, 0)", pixels=0), "found 0 x 0 pixels"),
    (array_bytes(shape="(4294967296, 4294967296)"), ", expected at most 2147483647 pixels"),
    (array_bytes(shape="(99999999999999999999999, 3)"), ", expected at most 2147483647 pixels"),
    (array_bytes(pixels=95), "found 95 bytes behind the header, expected 96 for shape (3, 4) of 8 "
                             "bytes a pixel"),
    (array_bytes(pixels=97), "found 97 bytes behind the header, expected 96"),
    (array_bytes(version=0), "version of the array format: found 0, expected 1, 2 or 3"),
    (array_bytes(version=4), "version of the array format: found 4"),
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
    (array_bytes(text="{"), "header: found "),
    (array_bytes(text="{'descr"), "header: found "),
    (b"\x93NUMPY", "version of the array format"),
    (b"\x93NUMPY\x01\x00\x01", "the file ends in the header"),
    (array_bytes(pixels=0) + np.array([np.inf, *range(11)]).tobytes(),
     "byte 91, pixel [0][0]: found an infinite or too large height")])
def test_refused_arrays(library, asperity, tmp_path, data, expected):
    """With file, what was found and what is expected; by the command, too, and from a pipe."""
    (tmp_path / "m.npy").write_bytes(data)
    read = library.read(tmp_path / "m.npy", SPACING)
    assert read.status == BAD_INPUT
    assert expected in read.wrong and read.wrong.startswith(str(tmp_path / "m.npy")), read.wrong
    assert read.wrong.count("\n") == 1 and "expected" in read.wrong
    done = run_program(asperity, "summits", "-", "--spacing=1,1", status=2, input=data, text=False)
    assert done.stderr.count(b"\n") == 1, done.stderr


def test_array_without_a_spacing(library, asperity, tmp_path):
    np.save(tmp_path / "m.npy", ROUGH)
    read = library.read(tmp_path / "m.npy")
    assert "m.npy: found heights without a spacing, expected spacing along x and y" in read.wrong
    done = run_program(asperity, "summits", "m.npy", status=2, cwd=tmp_path)
    assert "expected --spacing along x and y" in done.stderr


def test_array_through_a_pipe(library, asperity, tmp_path):
    np.save(tmp_path / "m.npy", ROUGH)
    command = [str(asperity), "summits", "--spacing=0.5,0.375", "--output", "s.csv"]
    for source in ("m.npy", "-"):
        with open(tmp_path / "m.npy", "rb") as file:
            run_program(*command, source, cwd=tmp_path, stdin=file)
        (tmp_path / "s.csv").rename(tmp_path / f"{len(source)}.csv")
    assert (tmp_path / "5.csv").read_bytes() == (tmp_path / "1.csv").read_bytes()


# ---------------------------------------------------------------- files that are written

@pytest.mark.parametrize("unit", [b"m", b"um", b"nm", b"in"])
@pytest.mark.parametrize("ending", ["sdf", "npy", "txt", "NPY"])
@pytest.mark.parametrize("make", [uneven, missing])
def test_written_and_read(library, tmp_path, ending, make, unit):
    """All bits come back: heights, spacing, unit, and the edge where the format has one."""
    heights, path = make(), tmp_path / f"m.{ending}"
    spacing = (0.1, 1 / 3)
    bare = ending.lower() == "npy"
    for edge in (0, 1):
        written = library.write(height_map(heights, spacing, unit, edge), path)
        assert (written.status, written.wrong) == (DONE, "")
        assert ("has no edge" in written.text(NOTES)) == (bare and edge == 1)
        read = library.read(path, spacing if bare else None, unit)
        assert (read.wrong, read.text(NOTES), read.text(UNIT)) == ("", "", unit.decode())
        table = read.table(MAP)
        assert (table["columns"][0], table["rows"][0]) == (24, 40)
        assert (table["spacing_x"][0], table["spacing_y"][0]) == spacing
        assert table["periodic"][0] == (edge if not bare else 0)
        assert np.array_equal(read.table(PIXELS)["height"].reshape(40, 24), heights,
                              equal_nan=True)


def test_read_by_numpy(library, tmp_path):
    heights = missing()
    library.write(height_map(heights), tmp_path / "m.npy")
    found = np.load(tmp_path / "m.npy")
    assert found.dtype == "<f8" and found.flags.c_contiguous
    assert np.array_equal(found, heights, equal_nan=True)
    with open(tmp_path / "m.npy", "rb") as file:
        np.lib.format.read_magic(file)
        np.lib.format.read_array_header_1_0(file)
        assert file.tell() % 64 == 0
    library.write(height_map(heights), tmp_path / "m.txt")
    assert np.array_equal(np.loadtxt(tmp_path / "m.txt"), heights, equal_nan=True)
    assert (tmp_path / "m.txt").read_text().startswith(
        "# Spacing: 5.0000000000000000E-001 3.7500000000000000E-001\n# Units: um\n")


@pytest.mark.long
@NEEDS_SDFIO
def test_read_by_sdfio(library, tmp_path):
    """Metres by the header; a wide map has the longer header of ISO-2.0."""
    import sdfio
    for heights in (missing(), np.arange(3.0 * 65536).reshape(3, 65536)):
        library.write(height_map(heights), tmp_path / "m.sdf")
        found = sdfio.read(tmp_path / "m.sdf")
        header = found.header
        assert found.data.shape == heights.shape
        assert (header.x_scale, header.y_scale) == pytest.approx([0.5e-6, 0.375e-6], rel=1e-15)
        assert header.z_scale == 1e-6
        kept = np.isfinite(heights)
        assert np.array_equal(found.data, heights * header.z_scale, equal_nan=True)
        read = library.read(tmp_path / "m.sdf", None, b"um")
        assert read.table(PIXELS)["height"].reshape(heights.shape)[kept] == pytest.approx(
            heights[kept], rel=1e-15, abs=0)


def test_the_command_reads_what_is_written(library, asperity, tmp_path):
    """As text with its header, and as surface data."""
    for ending in ("txt", "sdf"):
        library.write(height_map(ROUGH, unit=b"m"), tmp_path / f"m.{ending}")
        run_program(asperity, "summits", f"m.{ending}", "--quiet", "--output", "s.csv",
                    cwd=tmp_path)
        rows = np.loadtxt(tmp_path / "s.csv", delimiter=",", skiprows=1)
        found = library.summits(height_map(ROUGH, unit=b"m")).table(SUMMITS)
        assert np.array_equal(rows[:, 3], found["radius"])


@pytest.mark.parametrize("given, name, status, expected", [
    (GOOD, "m.csv", BAD_INPUT, "found another ending, expected .sdf, .npy or .txt"),
    (GOOD, "sdf", BAD_INPUT, "found another ending"),
    (GOOD, "a.sdf/m", BAD_INPUT, "found another ending"),
    (height_map(ROUGH, unit=None), "m.sdf", BAD_INPUT, "found a map without a unit"),
    (height_map(ROUGH, (0, 0)), "m.sdf", BAD_INPUT, "found a map without a spacing"),
    (GOOD, "none/m.npy", NOT_COMPUTED, "cannot be written: No such file or directory"),
    (changed(columns=0), "m.npy", BAD_INPUT, "map.columns: found 0")])
def test_refused_to_write(library, tmp_path, given, name, status, expected):
    done = library.write(given, tmp_path / name)
    assert done.status == status and expected in done.wrong
    assert not list(tmp_path.iterdir())


def test_refused_null(library):
    for done in (library.c.asperity_summits_of_map(None, None),
                 library.c.asperity_read_map(None, None, None),
                 library.c.asperity_write_map(None, None)):
        assert "found NULL" in Outcome(library.c, done).wrong
    missing_groups = library.c.asperity_build_scene_of(None, None, None)
    assert "groups: found NULL" in Outcome(library.c, missing_groups).wrong


def test_a_full_disk(library):
    if not os.path.exists("/dev/full"):
        pytest.skip("no /dev/full here")
    os.symlink("/dev/full", path := f"/tmp/full.{os.getpid()}.npy")
    try:
        done = library.write(height_map(np.random.default_rng(1).normal(size=(200, 200))), path)
        assert done.status == NOT_COMPUTED and "No space left on device" in done.wrong
    finally:
        os.unlink(path)
