"""Cases of public bug reports of similar programs, each with what is right: height maps as other
programs write them, in `asperity summits` and in scenes."""

import itertools
import random
import re
import struct

import numpy as np
import pytest

from programs import run_program
from surfaces_csv import solve, write_scene

SPACING = (0.5, 0.25)
Y, X = np.mgrid[:12, :16]
HEIGHTS = np.round(3 + np.cos(2 * np.pi * X / 8) * np.cos(2 * np.pi * Y / 6) + 0.01 * X, 6)


def rows_of(heights, separator=" ", end="\n", form="{:.6f}".format):
    return "".join(separator.join(map(form, row)) + end for row in heights)


def points_of(heights, separator=" "):
    return "".join(f"{j * SPACING[0]:g}{separator}{i * SPACING[1]:g}{separator}{z:.6f}\n"
                   for i, row in enumerate(heights) for j, z in enumerate(row))


def exact(value):
    return repr(float(value))


MATRIX, POINTS = rows_of(HEIGHTS), points_of(HEIGHTS)


class Maps:
    """Runs both doors on a map."""

    def __init__(self, asperity, folder):
        self.asperity, self.folder = asperity, folder

    def write(self, content, name="F"):
        (self.folder / name).write_bytes(content if isinstance(content, bytes)
                                         else content.encode("utf-8"))
        return name

    def summits(self, content, spacing=None, *options):
        """Status, standard error, and the numbers of the summary and of the surface."""
        self.write(content)
        words = [f"--spacing={spacing[0]!r},{spacing[1]!r}"] if spacing else []
        out = self.folder / "s.csv"
        out.unlink(missing_ok=True)
        done = run_program(self.asperity, "summits", "F", "--output", out, *words, *options,
                           status=None, cwd=self.folder)
        done.found = None
        if done.returncode == 0:
            done.found = (done.stdout.partition("\n")[2], out.read_text(encoding="ascii"))
            done.head = done.stdout.partition("\n")[0]
        return done

    def scene(self, content, spacing=None, upper="'plane'", lower="F", interaction="boundary",
              **surfaces):
        if content is not None:
            self.write(content)
        more = "".join(f", {name} = {value}" for name, value in surfaces.items())
        if spacing:
            more += f", map_spacing = {', '.join(map(repr, spacing))}"
        (self.folder / "a.scene").write_text(
            f"&surfaces upper = {upper}, lower = '{lower}'{more} /\n"
            f"&material contact_modulus = 1. /\n&effects interaction = '{interaction}' /\n"
            "&loading control = 'pressure', value = 1e-4 /\n", encoding="utf-8")
        return solve(self.asperity, self.folder / "a.scene", contacts=False)


@pytest.fixture
def maps(asperity, tmp_path):
    return Maps(asperity, tmp_path)


def number(done, name):
    """A number of the summary, and its unit."""
    found = re.search(rf"^{re.escape(name)} +(\S+) *(\S*)", done.stdout, re.M)
    return float(found[1]), found[2]


# ---------------------------------------------------------------- texts of other programs

NUMBERS = [line.split() for line in POINTS.splitlines()]
ESRI = "ncols 16\nnrows 12\ncellsize 0.5\n"


@pytest.mark.parametrize("text, place", [
    (ESRI + MATRIX, "1:1"), ("\ufeff" + ESRI.upper().replace("\n", "\r\n") + MATRIX, "1:4"),
    ("DSAA\n16 12\n0 7.5\n0 5.5\n2 4.1\n" + MATRIX, "1:1"),
    ("# Width: 8 um\n# Height: 3 um\n# Value units: m\n" + MATRIX, "4:1"), (MATRIX, "1:1"),
    (POINTS, "1:1"), (rows_of(HEIGHTS, ";").replace(".", ","), "1:1"),
    ("x [mm] y [mm] z [um]\n" + POINTS, "1:1"), ('"x" "y" "z"\n' + POINTS, "1:1"),
    ("x_mm,y_mm,z_mm\n" + POINTS.replace(" ", ","), "1:1"),
    ("lat lon z\n" + POINTS, "1:1"), ("x y mlw\n" + POINTS, "1:1"),
    ("y x z\n" + "".join(f"{y} {x} {z}\n" for x, y, z in NUMBERS), "1:1"),
    ("id,x,y,z\n" + "".join(f"{i},{','.join(row)}\n" for i, row in enumerate(NUMBERS)), "1:1"),
])
def test_other_texts_are_refused_in_one_line(text, place, maps):
    """It names the function that reads the formats of instruments."""
    done = maps.summits(text)
    assert done.returncode == 2 and done.stderr.startswith(f"F:{place}: ")
    assert done.stderr.count("\n") == 1 and "asperity.read_map in Python" in done.stderr
    found = maps.scene(text)
    assert found.status == 2 and found.stderr.count("\n") == 1 and "F:" in found.stderr


def test_comments_are_noted(maps):
    """They may have units, which are not read."""
    done = maps.summits("# Width: 8 mm\n# Value units: nm\n" + MATRIX, SPACING)
    assert done.stderr == ("F:1:1: note: comments are not read: spacing and heights are taken in "
                           "one unit\n")
    assert done.found == maps.summits(MATRIX, SPACING).found


# ---------------------------------------------------------------- shape

@pytest.mark.parametrize("text, found", [
    ("1 2 3\n4 5\n7 8 9\n", "2:4: found 2 pixels, expected 3"),
    ("1 2 3\n4 5 6\n\n7 8 9\n1 2 3\n", "3:1: found an empty line or a comment"),
    ("1 2 3\n4 5 6\n# x\n7 8 9\n", "3:1: found an empty line or a comment"),
    ("1 2 3\n4 5 6\n% x\n7 8 9\n", "3:1: found an empty line or a comment"),
    ("1 2 3\n4 5 6\n7 8 9\n\nb\n1 2 3\n", "4:1: found an empty line or a comment"),
    ("1 2 3\n4;5;6\n7 8 9\n", "2:1: found '4;5;6'"),
    ("1,2,3\n4;5;6\n7,8,9\n", "2:1: found '4;5;6'"),
    ("1\t\t3\n\t5\t6\n7\t8\t9\n", "1:3: found ''"),
    ("1,2,3\n,,\n7,8,9\n", "2:1: found ''"),
    ("1,2,3\n7,8,9\n7,8,9\n,,\n", "4:1: found ''"),
    ("1;2;3;\n4;5;6\n7;8;9;;\n", "3:7: found 4 pixels"),
    ("16 12\n" + MATRIX, "2:144: found 16 pixels, expected 2"),
    (rows_of(HEIGHTS, ",").replace(".", ","), "1:1: found commas and no decimal point"),
    (rows_of(HEIGHTS, ", ").replace(".", ","), "1:1: found commas and no decimal point"),
    ("2,990,3,010\n" * 4, "1:1: found commas and no decimal point"),
    (rows_of(HEIGHTS, ";").replace(".", ","), "1:1: found '4,000000'"),
    (rows_of(HEIGHTS, " ").replace(".", ",", 5), "1:3: found '000000 3"),
    ("1.234,5;2.345,6;1.111,1\n" * 4, "1:1: found '1.234,5'"),
    ("1,2,3 4,5,6\n" * 4, "1:5: found '3 4'"),
    ("1 2 3\n4 5 inf\n7 8 9\n", "2:5: found 'inf', expected a height"),
    (POINTS, "1:1: found places on a grid in the first two columns"),
    ("".join(POINTS.splitlines(keepends=True)[:-3]), "1:1: found places on a grid"),
    (points_of(HEIGHTS.T, ","), "1:1: found places on a grid in the first two columns"),
    ("".join(f"{y} {x} {z}\n" for x, y, z in NUMBERS), "1:1: found places on a grid"),
    ("x y z\n" + POINTS, "1:1: OPTION given, but x,y,z lines have their own spacing"),
])
def test_a_shape_is_no_guess(text, found, maps):
    for done, option in ((maps.summits(text, SPACING), "--spacing"),
                         (maps.scene(text, SPACING), "map_spacing")):
        assert re.search(rf"\bF:? ?{re.escape(found.replace('OPTION', option))}", done.stderr), \
            done.stderr


def test_whole_numbers_between_commas_are_read(maps):
    """Where they are no decimals: an odd number of columns, or signs."""
    rng = np.random.default_rng(3)
    for heights in (rng.integers(-9, 9, (12, 16)), rng.integers(0, 9, (12, 15))):
        done = maps.summits(rows_of(heights, ",", form=str), SPACING)
        assert done.found == maps.summits(rows_of(heights, form=str), SPACING).found is not None


def test_heights_of_three_columns_are_a_matrix(maps):
    rng = np.random.default_rng(1)
    for heights in (rng.normal(size=(192, 3)), np.add.outer(np.arange(9.0), [0, 1, 2]),
                    rng.integers(0, 3, (60, 3))):
        done = maps.summits(rows_of(heights), SPACING)
        assert done.returncode == 0 and f"3 x {len(heights)} pixels" in done.head


# ---------------------------------------------------------------- P4: one reader

LINES_BEFORE = {
    "none": "", "numpy": "# Channel: Height\n", "per cent": "% made by\n%\n",
    "mark": "\ufeff", "empty": "\n \t\n", "mark and comment": "\ufeff# a\r\n\r\n",
    "many": "".join(f"# line {i} of a long header, without a number\n" for i in range(900)),
}


@pytest.mark.parametrize("before", LINES_BEFORE.values(), ids=LINES_BEFORE)
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_the_first_line_does_not_choose_the_format(before, end, maps):
    plain, points = maps.summits(MATRIX, SPACING).found, maps.summits("x y z\n" + POINTS).found
    text = (before + MATRIX).replace("\r\n", "\n").replace("\n", end)
    for separator, last in ((" ", end), ("\t", ""), (";", end + end), (",", end)):
        done = maps.summits(text.replace(" ", separator) if before == "" else
                            before.replace("\r\n", "\n").replace("\n", end)
                            + MATRIX.replace(" ", separator).replace("\n", end)[:-len(end)] + last,
                            SPACING)
        assert done.found == plain, done.stderr
    assert maps.scene(text, SPACING).positions == maps.scene(MATRIX, SPACING).positions != []
    for sign in (" ", ",", "; ", "\t"):
        names = sign.join("xYz") + "\n"
        text = (before + names + POINTS.replace(" ", sign)).replace("\r\n", "\n").replace("\n", end)
        assert maps.summits(text).found == points
        found = maps.scene(text)
        assert found.status == 0, found.stderr


@pytest.mark.parametrize("word", ["NaN", "nan", "BAD", "Bad", "-nan"])
def test_a_missing_first_pixel(word, maps):
    heights = HEIGHTS.copy()
    heights[0, 0] = np.nan
    text = rows_of(heights, form=lambda z: word if np.isnan(z) else f"{z:.6f}")
    assert maps.summits(text, SPACING).returncode == 0
    found = maps.scene(text, SPACING)
    assert found.status == 0, found.stderr


def test_a_surface_is_no_map(maps):
    """In a scene; for `summits` its three columns are a map."""
    caps = "x,y,height\n" + POINTS.replace(" ", ",")
    assert maps.summits(caps).found == maps.summits("x y z\n" + POINTS).found
    assert "no radius column" in maps.scene(caps).stderr
    assert maps.summits("x,y,height,radius\n0,0,0,1\n").returncode == 2


# ---------------------------------------------------------------- P5: surface data of others

TEXT_HEADER = """{magic}
ManufacID   = Gwyddion
CreateDate  = 010120261200
ModDate     = 010120261200
NumPoints   = 16
NumProfiles = 12
Xscale      = 5.000000e-07
Yscale      = 2.500000e-07
Zscale      = 1.000000e-06
Zresolution = -1
Compression = 0
DataType    = {kind}
CheckType   = 0
NumDataSet  = 1
NanPresent  = 0
*
"""


@pytest.mark.parametrize("magic", ["aBCR-0.0", "aBCR-1.0"])
@pytest.mark.parametrize("end", ["", "*\n", "*", "*\nOBJECTIVEMAG = 5\n*\n"])
@pytest.mark.parametrize("equals", [" = ", " "])
def test_surface_data_as_gwyddion_writes_it(magic, end, equals, maps):
    header = TEXT_HEADER.format(magic=magic, kind=3).replace(" = ", equals)
    data = "".join(f"{z:g}\n" for z in HEIGHTS[::-1].ravel())
    done = maps.summits(header + data + end, None, "--unit=um", "--level=none")
    assert done.returncode == 0, done.stderr
    read = np.array([[float(f"{z:g}") for z in row] for row in HEIGHTS])
    assert number(done, "rms height") == (pytest.approx(read.std(), rel=1e-12), "um")
    assert number(done, "spacing along x") == (pytest.approx(0.5, rel=1e-12), "um")
    plain = maps.summits(rows_of(read, form=exact), SPACING, "--level=none")
    table = [[float(cell) for cell in line.split(",")] for line in done.found[1].split()[1:]]
    same = [[float(cell) for cell in line.split(",")] for line in plain.found[1].split()[1:]]
    assert np.allclose(table, same, rtol=1e-12, atol=1e-12)
    assert ("not read" in done.stderr) == ("OBJECTIVE" in end)


def test_numbers_beyond_the_pixels_are_refused(maps):
    header = TEXT_HEADER.format(magic="aISO-1.0", kind=7)
    data = "".join(f"{z:g}\n" for z in HEIGHTS.ravel())
    assert maps.summits(header + data + "*\n").returncode == 0
    for more in ("3.5\n", "3.5\n*\n", "*\n3.5\n", "*\n*\n3.5 3 2\n"):
        assert maps.summits(header + data + more).returncode == 2
    note = maps.summits((header + data)[:-1])
    assert note.returncode == 0 and "is the number whole?" in note.stderr


def binary(revision=b"ISO-1.0", between=b"", behind=b"", samples=None, kind=5, form="<i2",
           scales=(5e-7, 2.5e-7, 1e-9, -1)):
    samples = np.round(1000 * HEIGHTS) if samples is None else samples
    return (b"b" + revision + b"tests     010120261200010120261200" + struct.pack("<HH", 16, 12)
            + struct.pack("<4d", *scales) + bytes([0, kind, 0]) + between
            + samples.astype(form).tobytes() + behind)


@pytest.mark.parametrize("kind, form", [(5, "<i2"), (6, "<i4"), (7, "<f8")])
def test_bytes_that_the_standard_does_not_have(kind, form, maps):
    plain = maps.summits(binary(kind=kind, form=form)).found
    assert plain
    olympus = maps.summits(binary(between=struct.pack("<II", 5, 1), kind=kind, form=form))
    assert olympus.found == plain
    text = maps.summits(binary(behind=b"end\r\n", kind=kind, form=form))
    assert text.found == plain and "not read" in text.stderr
    for length in (1, 2, 3, 4, 6, 8, 9, 12, 16, 19, 64, 384):
        for byte in (b"\0", b"\1", b" ", b"\xff"):
            for where in ("between", "behind"):
                done = maps.summits(binary(**{where: byte * length}, kind=kind, form=form))
                assert done.returncode == 2 and "beyond header and pixels" in done.stderr
    piped = run_program(maps.asperity, "summits", "-", text=False,
                        input=binary(between=struct.pack("<II", 5, 1), kind=kind, form=form))
    assert piped.stdout.decode().partition("\n")[2] == plain[0]


@pytest.mark.parametrize("revision, missing, noted", [(b"BCR-1.0", 32767, -32768),
                                                      (b"ISO-1.0", -32768, 32767)])
def test_a_second_reserved_number_is_noted(revision, missing, noted, maps):
    samples = np.round(1000 * HEIGHTS)
    samples[2, 3] = missing
    samples[4, 5:8] = noted
    done = maps.summits(binary(revision, samples=samples))
    assert number(done, "missing")[0] == 1
    assert f"note: 3 pixels are {noted}," in done.stderr
    text = TEXT_HEADER.format(magic="a" + revision.decode(), kind=5)
    done = maps.summits(text + rows_of(samples.astype(int), form=str) + "*\n")
    assert f"note: 3 pixels are {noted}," in done.stderr
    samples[4, 5:8] = 5
    assert maps.summits(binary(revision, samples=samples)).stderr == ""


# ---------------------------------------------------------------- P13: two maps

def two(maps, upper, lower, **surfaces):
    """A scene of two maps; each is a text, or bytes."""
    maps.write(upper, "U")
    return maps.scene(lower, upper="'U'", **surfaces)


def sdf(scale=1e-6, spacing=(5e-7, 2.5e-7)):
    return binary(samples=HEIGHTS, kind=7, form="<f8", scales=(*spacing, scale, -1))


def near(found, expected):
    """The same positions to rounding."""
    assert found.status == expected.status == 0, (found.stderr, expected.stderr)
    for name in ("separation", "area", "load"):
        assert float(found.positions[0][name]) == \
            pytest.approx(float(expected.positions[0][name]), rel=1e-9)


def test_two_maps_each_with_its_unit_and_spacing(maps):
    expected = two(maps, MATRIX, MATRIX, map_spacing="0.5, 0.25")
    in_mm = rows_of(HEIGHTS / 1000, form="{:.9f}".format)
    for found in (
            two(maps, MATRIX, MATRIX, map_spacing="0.5, 0.25, 0.5, 0.25"),
            two(maps, MATRIX, in_mm, map_spacing="0.5, 0.25, 5e-4, 2.5e-4",
                map_unit="'um', 'mm'"),
            two(maps, sdf(), MATRIX, map_spacing="0.5, 0.25", map_unit="'um'"),
            two(maps, MATRIX, sdf(), map_spacing="0.5, 0.25", map_unit="'µm'"),
            two(maps, sdf(), in_mm, map_spacing="5e-4, 2.5e-4", map_unit="'um', 'mm'"),
            two(maps, MATRIX, MATRIX, map_spacing="0.5, 0.25", map_unit="'um'"),
            two(maps, sdf(), sdf(), map_unit="'um'"), two(maps, sdf(), sdf(), map_unit="2*'um'"),
            two(maps, "x y z\n" + POINTS, MATRIX, map_spacing="0.5, 0.25")):
        near(found, expected)


def test_one_spacing_is_that_along_both_axes(maps):
    """In scenes of one map or two, and in summits."""
    one, pair = {"map_spacing": "0.5"}, {"map_spacing": "0.5, 0.5"}
    near(maps.scene(MATRIX, **one), maps.scene(MATRIX, **pair))
    near(two(maps, MATRIX, MATRIX, **one), two(maps, MATRIX, MATRIX, **pair))
    square = sdf(spacing=(5e-7, 5e-7))
    near(two(maps, square, MATRIX, map_unit="'um'", **one),
         two(maps, square, square, map_unit="'um'"))
    assert maps.summits(MATRIX, None, "--spacing", "0.5").found == \
        maps.summits(MATRIX, (0.5, 0.5)).found


@pytest.mark.parametrize("upper, lower, surfaces, said", [
    (sdf(), MATRIX, {"map_spacing": "0.5, 0.25"},
     r"two maps: found .+ m and .+ \(no unit: name it in map_unit\), expected lengths in one unit"),
    (MATRIX, MATRIX, {"map_spacing": "0.5, 0.25, 0.5, 0.2500005", "map_edge": "'periodic'"},
     "two periodic maps: found 16 x 12 pixels of .+, expected the same lengths"),
    (MATRIX, rows_of(HEIGHTS[:, :15]), {"map_spacing": "0.5, 0.25", "map_edge": "'periodic'"},
     "two periodic maps: found 16 x 12 pixels of .+ and 15 x 12 pixels of"),
    (sdf(), sdf(), {"map_spacing": "0.5, 0.25"}, "map_spacing: found although both maps have"),
    (sdf(), MATRIX, {"map_spacing": "5e-7, 2.5e-7, 5e-7, 2.5e-7"},
     "U: map_spacing given, but the map has its own"),
    (MATRIX, MATRIX, {"map_spacing": "0.5, 0.25, 0.5"}, "found 3, expected 2"),
    (MATRIX, MATRIX, {"map_spacing": "0.5, 0.25", "map_unit": "'um', 'ft'"}, "found the text 'ft'"),
])
def test_differences_of_two_maps_are_named(upper, lower, surfaces, said, maps):
    found = two(maps, upper, lower, **surfaces)
    assert found.status == 2 and re.search(said, found.stderr), found.stderr
    assert "--spacing given" not in found.stderr


def test_grids_are_compared_to_a_millionth(maps):
    found = two(maps, MATRIX, MATRIX, map_spacing="0.5, 0.25, 0.5000004, 0.2499998")
    assert found.status == 0, found.stderr


# ---------------------------------------------------------------- P15: decimal comma in a path

@pytest.mark.parametrize("value, note", [("12,5", "12,5"), ("3, 12,5", "12,5"), ("12, 5", None),
                                         ("12 5", None), ("1.5,2.5", None), ("12", None),
                                         ("12,5.", None), ("1,000.5", "1,000.5"),
                                         ("1,234.5", "1,234.5"), ("12,0.5", "12,0.5"),
                                         ("1, 000.5", None), ("1,1234.5", None),
                                         ("1.,234.5", None)])
def test_a_path_from_a_decimal_comma_is_noted(value, note, asperity, tmp_path):
    scene = write_scene(
        tmp_path / "a.scene", surfaces={"upper": "plane", "lower": "l.csv"},
        material={"contact_modulus": 1e3}, loading={"control": "load", "value": "VALUE"})
    (tmp_path / "l.csv").write_text("x,y,height,radius\n0,0,1,5\n")
    scene.write_text(scene.read_text().replace("'VALUE'", value))
    found = solve(asperity, scene)
    assert found.status == 0, found.stderr
    assert (f"note: {note} in value of &loading" in found.stderr) if note else \
        ("decimal comma" not in found.stderr)


# ---------------------------------------------------------------- what parses as a number

def table(form=exact, first=(), index=(), separator=","):
    rows = [separator.join([*map(str, index[i:i + 1]), *map(form, row)])
            for i, row in enumerate(HEIGHTS)]
    return "\n".join([separator.join(map(str, first))] * bool(len(first)) + rows) + "\n"


@pytest.mark.parametrize("word", ["1.#QNAN", "-1.#IND", "1.#IND00", "-1.#QNAN0", "nan(ind)",
                                  "-nan(0x8)", "+NaN"])
def test_missing_pixels_of_other_libraries(word, maps):
    """At the end of a line too, where a comment may stand."""
    holes = HEIGHTS.copy()
    holes[3, -1] = np.nan
    plain = rows_of(holes, form=lambda z: "NaN" if np.isnan(z) else f"{z:.6f}")
    points = ["x y z", *POINTS.splitlines()]
    points[3 * 16 + 16] = points[3 * 16 + 16].rpartition(" ")[0] + " " + word
    for done in (maps.summits(plain.replace("NaN", word), SPACING),
                 maps.summits("\n".join(points))):
        assert number(done, "missing")[0] == 1
        assert done.found == maps.summits(plain, SPACING).found


@pytest.mark.parametrize("word", ["1.#INF", "#N/A", "#DIV/0!", "1#", "1.#QNAN9"])
def test_words_that_are_no_heights(word, maps):
    text = MATRIX.splitlines()
    text[3] = text[3].rpartition(" ")[0] + " " + word
    done = maps.summits("\n".join(text), SPACING)
    assert done.returncode == 2 and f"found '{word}'" in done.stderr


@pytest.mark.parametrize("text, said", [
    (table(first=range(16)), "1:1: found equal steps in the first line"),
    (table(index=range(12)), "1:1: found equal steps in the first column"),
    (table(first=range(1, 17), separator=" "), "1:1: found equal steps in the first line"),
    (table(first=np.arange(16) * 0.5, separator=" "), "note: equal steps in the first line"),
    (table(index=np.arange(12) * 0.25), "note: equal steps in the first column"),
    (table(first=["", *range(16)], index=range(12)), "1:1: found ''"),
    (table(first=range(17), index=range(12)), "1:1: found equal steps in the first"),
    (rows_of(np.vstack([np.arange(16), 1000 * HEIGHTS]), form="{:.0f}".format), "1:1: found equal"),
])
def test_numbers_of_lines_and_columns(text, said, maps):
    done = maps.summits(text, SPACING)
    assert said in done.stderr and done.returncode == (0 if "note" in said else 2)
    assert len(set(done.stderr.splitlines())) <= 2


def test_a_ramp_is_a_profile(maps):
    ramp = np.add.outer(np.arange(9.0) ** 2, 0.5 * np.arange(7))
    assert maps.summits(rows_of(ramp), SPACING).stderr == ""


# ---------------------------------------------------------------- one beginning of file

NOISE = np.random.default_rng(2).integers(0, 256, 3000, dtype=np.uint8).tobytes()
WRONG = {
    "random": NOISE, "zip": b"PK\x03\x04" + NOISE, "gwy": b"GWYPGWYO" + NOISE,
    "sur": b"DIGITAL SURF" + NOISE, "hdf5": b"\x89HDF\r\n\x1a\n" + NOISE, "nc": b"CDF\x01" + NOISE,
    "gzip": b"\x1f\x8b\x08" + NOISE, "opd": b"\x01\x00Directory" + NOISE,
    "di": b"\\*File list\r\n" + b"\\Version: 5\r\n" * 30, "png": b"\x89PNG\r\n\x1a\n" + NOISE,
    "zygo": b"Zygo ASCII Data File\n" + b"1 2 3\n" * 30, "utf16": MATRIX.encode("utf-16"),
    "prose": b"It was the best of times.\nIt was the worst of 3 times.\n" * 30,
    "numbers and words": b"12 men went to mow\n3 men, 2 men and his dog\n" * 30,
    "program": b"program a\n  print *, 1\nend program a\n" * 20,
}


@pytest.mark.parametrize("kind", WRONG)
def test_a_wrong_file_is_one_mistake(kind, maps):
    """At most three lines, and the program that reads the format where there is one."""
    maps.write(WRONG[kind])
    maps.write("&surfaces upper = 'F', lower = 'plane' /\n&material contact_modulus = 1. /\n"
               "&loading control = 'load', value = 1. /\n", "a.scene")
    for words in (["summits", "F"], ["summits", "F", "--spacing=1,1"], ["F"], ["solve", "F"],
                  ["generate", "F"], ["solve", "a.scene"]):
        done = run_program(maps.asperity, *words, status=2, cwd=maps.folder)
        lines = done.stderr.splitlines()
        assert 1 <= len(lines) <= 3 and re.match(r"F:\d+:\d+: ", lines[0]), done.stderr
        if kind in ("zip", "gwy", "sur", "hdf5", "nc", "opd", "di"):
            assert "not a format of this program" in lines[0] and "asperity.read_map" in lines[0]
        elif kind == "utf16":
            assert "text in UTF-16" in lines[0] and "saved as UTF-8" in lines[0]


def test_a_control_character_is_one_mistake(maps):
    """Further faults of the file are not listed beside it."""
    maps.write(MATRIX.encode() + b"1 2 \x01 a\n3 b c d\n")
    done = run_program(maps.asperity, "summits", "F", "--spacing=1,1", status=2, cwd=maps.folder)
    assert re.fullmatch(r"F:13:5: not a text file: found a control character, expected .*\n",
                        done.stderr)
    maps.write(b"x,y,height,radius\n1,2,0.1,b\n1,2,\x01,1\n")
    maps.write("&surfaces upper = 'F', lower = 'plane' /\n&material contact_modulus = 1. /\n"
               "&loading control = 'load', value = 1. /\n", "a.scene")
    done = run_program(maps.asperity, "solve", "a.scene", status=2, cwd=maps.folder)
    assert done.stderr == ("F:3:5: not a text file: found a control character, expected "
                           "comma-separated numbers\n")


@pytest.mark.parametrize("change", [
    lambda text: b"\xef\xbb\xbf" + text, lambda text: text.replace(b"\n", b"\r\n"),
    lambda text: b"\xef\xbb\xbf" + text.replace(b"\n", b"\r")])
def test_a_deck_as_other_editors_write_it(change, root, maps):
    plain = (root / "data/thesis.deck").read_bytes()
    reports = []
    for text in (plain, change(plain)):
        maps.write(text, "d.deck")
        reports.append(run_program(maps.asperity, "d.deck", "--arithmetic=real64",
                                   cwd=maps.folder).stdout)
    assert reports[0] == reports[1]


def test_tabs_in_a_surface_data_header(maps):
    text = TEXT_HEADER.format(magic="aISO-1.0", kind=7) + rows_of(HEIGHTS) + "*\n"
    assert maps.summits(text.replace(" = ", "\t=\t")).found == maps.summits(text).found


# ---------------------------------------------------------------- decimal commas in scenes

@pytest.mark.parametrize("names, said", [
    ({"map_spacing": "1,5"}, "note: 1,5 in map_spacing of &surfaces"),
    ({"map_spacing": "1, 5"}, None), ({"map_spacing": "1.,5."}, None),
    ({"map_spacing": "0,05"}, "map_spacing: found 0,05, a decimal comma, expected a point"),
    ({"map_spacing": "1, 5", "nominal_area": "3,5"}, "3,5: a decimal comma? write a point"),
    ({"map_spacing": "1,5e0"}, "note: 1,5e0 in map_spacing"),
])
def test_pairs_without_a_blank(names, said, maps):
    found = maps.scene(MATRIX, **names)
    assert (said in found.stderr) if said else ("comma" not in found.stderr)
    assert found.status == (2 if said and "note" not in said else 0), found.stderr


# ---------------------------------------------------------------- mixed dialects

CELL = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|(?i:nan|bad)"


def readings(text):
    """All matrices that a text may stand for, each tried in plain Python by a separator; none when
    lines are of unequal length or stand in two blocks."""
    lines = [line.partition("#")[0].rstrip(" ") for line in
             re.split(r"\r\n|\n|\r", text.removeprefix("\ufeff"))]
    lines = ["" if line.lstrip().startswith("%") else line for line in lines]
    blocks = [list(group) for full, group in itertools.groupby(lines, key=lambda s: s.strip() != "")
              if full]
    found = []
    for separator in (";", "\t", ",", "[ \t]+") if len(blocks) == 1 else ():
        rows = []
        for line in blocks[0]:
            cells = [cell.strip(" ") for cell in re.split(separator, line.strip(" "))]
            if cells[-1] == "":
                cells.pop()
            rows.append([float("nan" if cell.lower() == "bad" else cell) for cell in cells]
                        if all(re.fullmatch(CELL, cell) for cell in cells) else None)
        if None not in rows and len(set(map(len, rows))) == 1 and len(rows[0]) > 2 and \
                not any(np.array_equal(rows, other, equal_nan=True) for other in found):
            found.append(rows)
    return found


def mixed(seed):
    """A matrix in some dialect, most often with something that is of another one."""
    rng = random.Random(seed)
    rows, columns = rng.randrange(3, 7), rng.randrange(3, 7)
    form = rng.choice(["{:.2f}", "{:.3f}", "{:.0f}", "{:g}", "{:.2e}"])
    cells = [[form.format(rng.choice((1, 30, 2000)) * rng.gauss(1, 1)) for _ in range(columns)]
             for _ in range(rows)]
    if rng.random() < 0.2:
        cells[rng.randrange(rows)][rng.randrange(columns)] = rng.choice(("NaN", "BAD", "", "x"))
    separator = rng.choice([" ", "\t", ",", ";", ", ", "; ", "  "])
    lines = [separator.join(line) for line in cells]
    for _ in range(rng.choice((0, 0, 1, 1, 2))):
        at = rng.randrange(len(lines))
        kind = rng.randrange(8)
        if kind == 0:
            lines = [line.replace(".", ",") for line in lines]
        elif kind == 1:
            lines[at] = lines[at].replace(".", ",")
        elif kind == 2:
            lines[at] = lines[at].replace(separator, rng.choice([" ", "\t", ",", ";"]),
                                          rng.choice((1, 9)))
        elif kind == 3:
            lines.insert(at, rng.choice(["", "# comment", "  ", "% x"]))
        elif kind == 4:
            lines = [line + separator for line in lines]
        elif kind == 5:
            lines[at] += rng.choice([separator, " # remark", " ", ",", ";"])
        elif kind == 6:
            lines.pop(at)
        else:
            lines[at] = rng.choice(["", "1" + separator]) + lines[at]
    end = rng.choice(["\n", "\n", "\r\n", "\r"])
    return (rng.choice(["", "", "\ufeff", "# a" + end, end]) + end.join(lines)
            + rng.choice(["", end, end + end + "# b"]))


@pytest.mark.fuzz
@pytest.mark.parametrize("first", range(0, 400, 100))
def test_mixed_dialects_against_plain_reading(first, maps):
    """What is read is the one reading that there is; a file of one reading is read, unless
    commas without a point leave a doubt."""
    taken = refused = 0
    for seed in range(first, first + 100):
        text = mixed(seed)
        found = readings(text)
        done = maps.summits(text, SPACING, "--level=none")
        if done.returncode == 0:
            taken += 1
            assert len(found) == 1, (seed, text, done.stdout)
            heights = np.array(found[0])
            missing = np.isnan(heights).sum()
            assert f"{heights.shape[1]} x {heights.shape[0]} pixels" in done.head, (seed, text)
            assert number(done, "missing")[0] == missing
            same = maps.summits(rows_of(heights, form=exact), SPACING, "--level=none")
            assert done.found == same.found, (seed, text)
        else:
            refused += 1
            doubt = "," in text and "." not in text
            assert len(found) != 1 or doubt or len(found[0]) < 3, (seed, text, done.stderr)
    assert min(taken, refused) > 20
