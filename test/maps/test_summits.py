"""`asperity summits`: maps of every format, their summits and statistics against numpy, and what
the command states of maps that it cannot read."""

import re
import sys

import numpy as np
import pytest

import map_truth
from made_maps import FOLDER, self_affine
from programs import run_program
from surfaces_csv import solve, write_scene

NEEDS_SDFIO = pytest.mark.skipif(sys.version_info < (3, 11), reason="sdfio needs Python 3.11")


@pytest.fixture
def summits(asperity, tmp_path):
    """Run the command; what it printed, and the rows of its surface."""
    def start(path, *options, status=0, **environment):
        out = tmp_path / "s.csv"
        out.unlink(missing_ok=True)
        done = run_program(asperity, "summits", path, "--output", out, *options, status=status,
                           cwd=tmp_path, variables=environment)
        if status != 0:
            assert not out.exists() and done.stdout == ""
            return done
        lines = out.read_text(encoding="ascii").splitlines()
        assert lines[0] == "x,y,height,radius"
        done.rows = np.array([list(map(float, line.split(","))) for line in lines[1:]])
        done.rows = done.rows.reshape(-1, 4)
        return done
    return start


def value(done, name):
    """The number beside a name of the summary."""
    return float(re.search(rf"^ *{re.escape(name)} +(\S+)", done.stdout, re.M)[1])


def assert_same(found, expected, scale):
    """The same rows; lengths to 1e-12 of their scale, radii to 1e-12 of what second differences of
    heights of that size can report."""
    assert found.shape == expected.shape
    assert np.abs(found[:, :2] - expected[:, :2]).max() <= 1e-12 * np.abs(expected[:, :2]).max()
    assert np.abs(found[:, 2] - expected[:, 2]).max() <= 1e-12 * scale
    assert np.abs(found[:, 3] / expected[:, 3] - 1).max() <= 1e-12


def write_matrix(path, heights, missing="NaN", separator=" "):
    lines = [separator.join(missing if np.isnan(z) else repr(float(z)) for z in row)
             for row in heights]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return path


# ---------------------------------------------------------------- against numpy

def holes(heights):
    heights = heights.copy()
    heights[5, 7] = heights[0, 3] = np.nan
    heights[20:24, 10:13] = np.nan
    # One alone, and one with neighbours along x only.
    heights[30:33, 20:23] = np.nan
    heights[31, 21] = 1.0
    heights[36:39:2, 30:37] = np.nan
    return heights


MADE = {
    "smooth": lambda: self_affine((60, 48), 1, shortest=8)[0],
    "rough": lambda: self_affine((50, 64), 2, hurst=0.3, shortest=2)[0],
    "anisotropic": lambda: self_affine((64, 64), 3, shortest=4, stretch=3)[0],
    "holes": lambda: holes(self_affine((48, 48), 4, shortest=4)[0]),
    "tilted": lambda: self_affine((40, 40), 5)[0] + 1e3 + sum(np.indices((40, 40))),
}


@pytest.mark.parametrize("rule", ["eight", "contact"])
@pytest.mark.parametrize("name", MADE)
def test_summits_are_those_of_the_definition(name, rule, summits, tmp_path):
    heights, dx, dy = MADE[name](), 0.5, 0.75
    path = write_matrix(tmp_path / "a.txt", heights)
    # What rounding of the tilt leaves.
    scale = max(1.0, np.nanmax(np.abs(heights)) * 1e-2)
    for level in ("plane", "mean", "none"):
        for radius in map_truth.RADII:
            done = summits(path, "--spacing", f"{dx},{dy}", "--rule", rule, "--radius", radius,
                           "--level", level)
            expected, ridges = map_truth.summits(heights, dx, dy, rule, radius, level)
            if name == "tilted":
                assert done.rows.shape == expected.shape
                assert np.allclose(done.rows, expected, rtol=1e-9, atol=1e-9)
            else:
                assert_same(done.rows, expected, scale)
            assert value(done, "summits") == len(expected)
            if rule == "contact":
                assert value(done, "on ridges") == ridges
                assert ridges > 0 or level != "plane"


@pytest.mark.parametrize("name", MADE)
def test_statistics_are_those_of_the_definition(name, summits, tmp_path):
    heights, dx, dy = MADE[name](), 0.5, 0.75
    done = summits(write_matrix(tmp_path / "a.txt", heights), "--spacing", f"{dx},{dy}")
    assert value(done, "samples") == heights.size
    assert value(done, "missing") == np.isnan(heights).sum()
    tolerance = 1e-12 if name != "tilted" else 1e-9
    for key, expected in map_truth.statistics(heights, dx, dy).items():
        assert value(done, key) == pytest.approx(expected, rel=tolerance), key
    z, r = done.rows[:, 2], done.rows[:, 3]
    possible = np.isfinite(map_truth.surroundings(heights, False)).all(axis=(0, 1)).sum()
    for key, expected in {"density of summits": len(z) / (possible * dx * dy),
                          "mean summit height": z.mean(), "deviation of heights": z.std(),
                          "mean summit curvature": (1 / r).mean(),
                          "mean summit radius": r.mean()}.items():
        assert value(done, key) == pytest.approx(expected, rel=tolerance), key
    moments = [value(done, "m0"), *(sum(value(done, f"m{n} along {axis}") for axis in "xy") / 2
                                    for n in (2, 4))]
    expects = re.findall(r"(?m)^(?:density|mean|dev).* (\d\S+)$", done.stdout)[:4]
    assert [float(word) for word in expects] == pytest.approx(map_truth.nayak(*moments), rel=1e-4)


# ---------------------------------------------------------------- plateaus, spikes, units

def test_a_plateau_counts_once(summits, tmp_path):
    heights = np.zeros((14, 16))
    heights[2:4, 2:5] = 1.0             # a block
    heights[6, 6] = heights[7, 7] = heights[8, 6] = 2.0  # joined by corners
    heights[11, 0:3] = 3.0              # reaches the rim
    heights[2, 9:14] = heights[3, 9] = heights[3, 13] = 1.0  # an arch: one summit
    heights[10, 10:12] = 1.0            # beside something higher
    heights[11, 12] = 1.5
    path = write_matrix(tmp_path / "a.txt", heights)
    done = summits(path, "--spacing", "1,1", "--level", "none")
    assert done.rows.tolist() == [[2, 2, 1, 1], [9, 2, 1, 1], [6, 6, 2, 1 / 4],
                                  [12, 11, 1.5, 1 / 3]]
    # A mean leaves equal pixels equal.
    assert len(summits(path, "--spacing", "1,1", "--level", "mean").rows) == 4
    # By rule contact what reaches the rim counts, too.
    done = summits(path, "--spacing", "1,1", "--level", "none", "--rule", "contact")
    assert len(done.rows) - value(done, "on ridges") == 5


def test_a_level_plateau_stays_one(summits, tmp_path):
    """The plane of a map that is level already is rounding: it must not break ties."""
    heights = np.zeros((21, 21))
    for i, j in ((5, 5), (5, 14), (14, 5), (14, 14)):
        heights[i:i + 2, j:j + 2] = 0.1
    done = summits(write_matrix(tmp_path / "a.txt", heights), "--spacing", "1,1")
    assert len(done.rows) == 4


def test_spikes_are_removed(summits, tmp_path):
    heights, _ = self_affine((100, 100), 7, shortest=4)
    clean = summits(write_matrix(tmp_path / "a.txt", heights), "--spacing", "1,1", "--despike")
    assert value(clean, "spikes removed") == 0
    spiked = heights.copy()
    places = [(0, 0), (17, 30), (50, 50), (51, 90), (99, 40), (60, 61)]
    for i, (row, column) in enumerate(places):
        spiked[row, column] += (-1) ** i * 45.0
    path = write_matrix(tmp_path / "a.txt", spiked)
    assert value(summits(path, "--spacing", "1,1"), "rms height") > 1.2
    done = summits(path, "--spacing", "1,1", "--despike")
    assert value(done, "spikes removed") == len(places)
    # The medians are of the map as it was levelled with the spikes in it.
    mended = map_truth.levelled(spiked)
    for row, column in places:
        window = mended[max(0, row - 2):row + 3, max(0, column - 2):column + 3]
        mended[row, column] = np.median(window)
    assert_same(done.rows, map_truth.summits(mended, 1.0, 1.0)[0], 1.0)


def test_rims_of_holes(summits, tmp_path):
    """Pixels beside holes are off, as instruments leave them: the slopes are those of cells of four
    measured pixels. The share of slopes left out is printed, the missing pixels are noted."""
    heights, random = self_affine((60, 70), 8, shortest=6)[0], np.random.default_rng(4)
    holes = np.zeros(heights.shape, bool)
    for row, column in random.integers(0, 60, (40, 2)):
        holes[row:row + random.integers(1, 7), column:column + random.integers(1, 7)] = True
    heights[holes] = np.nan
    done = summits(write_matrix(tmp_path / "a.txt", heights), "--spacing", "1,1", "--level", "none")
    slopes = np.diff(heights, axis=1), np.diff(heights, axis=0)
    cells = [(slopes[0][:-1] ** 2 + slopes[0][1:] ** 2) / 2,
             (slopes[1][:, :-1] ** 2 + slopes[1][:, 1:] ** 2) / 2]
    whole = np.isfinite(cells[0] + cells[1])
    # The outermost lines have one cell beside them.
    assert value(done, "rms slope") == pytest.approx(
        np.sqrt(cells[0][whole].mean() + cells[1][whole].mean()), rel=0.02)
    left_out = 1 - 2 * whole.sum() / sum(np.isfinite(s).sum() for s in slopes)
    assert value(done, "slopes left out") / 100 == pytest.approx(left_out, abs=0.03)
    assert f"{round(100 * holes.mean())} % of the pixels are missing" in done.stderr
    alone = summits(write_matrix(tmp_path / "a.txt", self_affine((60, 70), 8, shortest=6)[0]),
                    "--spacing", "1,1")
    assert "missing:" not in alone.stderr and "slopes left out" not in alone.stdout


@pytest.mark.parametrize("repeated", ["row", "column", None])
def test_a_period_with_its_first_line_twice(asperity, summits, tmp_path, repeated):
    """Noted in scenes, too; a map without it, or of lines that are all alike, has no note."""
    heights = self_affine((30, 34), 8, shortest=6)[0]
    if repeated:
        heights = np.append(heights, heights[:1] if repeated == "row" else heights[:, :1],
                            axis=int(repeated == "column"))
    path = write_matrix(tmp_path / "a.txt", heights)
    note = f"last {repeated} repeats its first" if repeated else "repeats"
    done = summits(path, "--spacing", "1,1", "--edge", "periodic")
    assert (note in done.stderr) == bool(repeated)
    assert "repeats" not in summits(path, "--spacing", "1,1").stderr
    scene = write_scene(
        tmp_path / "a.scene", surfaces={"upper": "plane", "lower": "a.txt", "map_spacing": (1, 1),
                                        "map_edge": "periodic"},
        material={"contact_modulus": 1.0}, loading={"control": "load", "value": 1.0},
        effects={"interaction": "boundary"})
    assert (note in solve(asperity, scene).stderr) == bool(repeated)
    grooves = write_matrix(tmp_path / "b.txt", np.tile(heights[0], (30, 1)))
    assert ("row repeats" not in summits(grooves, "--spacing", "1,1", "--edge", "periodic").stderr)


@pytest.mark.parametrize("unit, factor", [("m", 1), ("mm", 1e3), ("um", 1e6), ("nm", 1e9),
                                          ("cm", 1e2), ("in", 1 / 0.0254)])
def test_units(unit, factor, summits):
    path = FOLDER / "smooth.sdf"
    metres = summits(path)
    done = summits(path, "--unit", unit)
    assert np.allclose(done.rows, metres.rows * factor, rtol=1e-12, atol=0)
    assert value(done, "rms height") == pytest.approx(value(metres, "rms height") * factor,
                                                      rel=1e-12)
    assert re.search(rf"^rms height +\S+ +{unit}$", done.stdout, re.M)


# ---------------------------------------------------------------- surface data files

def variants():
    import sdfio
    for revision in sdfio.Revision:
        for kind in revision.rules.data_types:
            for encoding in sdfio.FileFormat:
                yield revision, kind, encoding


def raw_heights(kind, revision, rng):
    """Numbers from end to end of what a type holds, NaN for some."""
    shape = (9, 11)
    name = kind.name
    if name.startswith("BINARY"):
        heights = rng.normal(size=shape) * 10.0 ** rng.integers(-9, 9, size=shape)
    else:
        bits = int(re.sub(r"\D", "", name))
        low = 0 if name[0] == "U" else -2 ** (bits - 1)
        high = low + 2 ** bits - 1
        # One end is reserved.
        heights = rng.integers(low + 1, high, size=shape).astype(float)
        heights.flat[:2] = low + 1, high - 1
    return heights


@pytest.mark.long
@NEEDS_SDFIO
def test_every_variant_is_read_to_the_last_bit(summits, tmp_path):
    """What sdfio writes. A pixel shows where it is a summit: each in turn is lifted over its
    neighbours by taking these from among the lowest."""
    import sdfio
    rng = np.random.default_rng(7)
    path, seen = tmp_path / "a.sdf", 0
    for revision, kind, encoding in variants():
        heights = raw_heights(kind, revision, rng)
        order = np.sort(heights.ravel())
        for at in np.ndindex(2, 2):
            mixed = np.empty_like(heights)
            chosen = np.zeros(heights.shape, bool)
            chosen[1 + at[0]:-1:2, 1 + at[1]:-1:2] = True
            mixed[chosen] = rng.permutation(order[-chosen.sum():])
            mixed[~chosen] = rng.permutation(order[:-chosen.sum()])
            mixed[4, 6] = mixed[0, 0] = np.nan
            scale = 1.0 if kind.name.startswith("BINARY") else 2.93348705463536e-016
            sdfio.write(path, mixed * scale, x_scale=3.484e-6, y_scale=7.25e-7, z_scale=scale,
                        format=encoding, metadata=sdfio.Metadata(revision=revision, data_type=kind))
            read = sdfio.read(path).data
            done = summits(path, "--level", "none")
            expected, _ = map_truth.summits(read, 3.484e-6, 7.25e-7, level="none")
            assert done.rows.shape == expected.shape
            assert (done.rows[:, :3] == expected[:, :3]).all(), (revision, kind, encoding)
            assert np.allclose(done.rows[:, 3], expected[:, 3], rtol=1e-12, atol=0)
            assert value(done, "missing") == 2
            seen += len(expected)
    assert seen > 32 * 40


@NEEDS_SDFIO
def test_archived_maps_are_read_as_sdfio_reads_them(summits):
    import sdfio
    for path in sorted(FOLDER.glob("*.sdf")):
        sdf = sdfio.read(path)
        dx, dy = sdf.header.x_scale, sdf.header.y_scale
        for rule in ("eight", "contact"):
            expected, _ = map_truth.summits(sdf.data, dx, dy, rule)
            assert_same(summits(path, "--rule", rule).rows, expected, np.nanstd(sdf.data))


HEADER = """aBCR-1.0 ; what it is
ManufacID   = by hand ; a comment
CreateDate  = 010120261200
ModDate     = 010120261200
NumPoints   = 3
NumProfiles = 4
Xscale      = 1e-6
yscale      = 2E-6
Zscale      = 1e-9
Zresolution = -1 ; not known
Compression = NULL
DataType    = INTEGER
CheckType   = None
*
"""


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_proposal_as_others_write_it(end, summits, tmp_path):
    """Words for numbers, comments, any line end; the first profile lies at the largest y."""
    text = HEADER + "0 0 0\n0 5 32767\n; nothing\n0 7 0 0\n0 0\n*\n*\n"
    (tmp_path / "a.sdf").write_text(text.replace("\n", end), encoding="ascii", newline="")
    done = summits("a.sdf", "--level", "none", "--rule", "contact", "--radius", "neighbours")
    assert value(done, "missing") == 1
    assert value(done, "spacing along y") == 2e-6
    assert done.rows[0].tolist()[:2] == pytest.approx([1e-6, 2.0 * 1e-6 + 2e-6 * 5 / 18])


# ---------------------------------------------------------------- text

@pytest.mark.parametrize("separator", [" ", "\t", ",", ";", "  ", ", "])
@pytest.mark.parametrize("missing", ["NaN", "nan", "BAD"])
def test_a_matrix(separator, missing, summits, tmp_path):
    heights = holes(self_affine((40, 44), 9, shortest=4)[0])
    path = write_matrix(tmp_path / "a.txt", heights, missing, separator)
    text = "\ufeff# heights\n\n" + path.read_text(encoding="ascii").replace("\n", " # row\r\n")
    path.write_text(text, encoding="utf-8", newline="")
    done = summits(path, "--spacing", "0.5,.25")
    assert_same(done.rows, map_truth.summits(heights, 0.5, 0.25)[0], 1.0)
    assert re.search(r"^rms height +\S+$", done.stdout, re.M)


@pytest.mark.parametrize("order", ["rows", "columns", "down", "columns down"])
@pytest.mark.parametrize("header", ["x,y,z", "X; Y; Height", "x\ty\tz", "x y z"])
def test_points(order, header, summits, tmp_path):
    heights = holes(self_affine((40, 44), 9, shortest=4)[0])
    rows, columns = np.indices(heights.shape)
    points = np.stack([10 + 0.1 * columns.ravel(), -3 + 0.2 * rows.ravel(), heights.ravel()],
                      axis=1)
    if "columns" in order:
        points = points[np.argsort(columns.ravel(), kind="stable")]
    if "down" in order:
        points = points[::-1]
    separator = re.search(r"[^xX](?=\s?[yY])", header)[0]
    lines = [separator.join((f"{x:.6g}", f"{y:.6g}", repr(float(z)))) for x, y, z in points]
    (tmp_path / "a.csv").write_text("# points\n" + "\n".join([header, *lines]), encoding="ascii")
    done = summits("a.csv", "--rule", "contact")
    assert_same(done.rows, map_truth.summits(heights, 0.1, 0.2, "contact")[0], 1.0)


def grid(change=lambda points: points, header="x,y,z"):
    """The points of 4 x 3 pixels, a spacing of 1 along x and 2 along y."""
    points = change([[i, 2 * j, i * j % 3] for j in range(3) for i in range(4)])
    return "\n".join([header, *(",".join(map(str, point)) for point in points)]) + "\n"


@pytest.mark.parametrize("off, status", [(0.07, 0), (-0.07, 0), (0.13, 2), (-0.13, 2)])
@pytest.mark.parametrize("axis", [0, 1])
def test_points_beside_the_grid(off, status, axis, summits, tmp_path):
    """A tenth of the spacing is the limit."""
    def move(points):
        points[6][axis] += off * (1 + axis)
        return points
    (tmp_path / "a.csv").write_text(grid(move), encoding="ascii")
    done = summits("a.csv", status=status)
    assert status == 0 or done.stderr.startswith(f"a.csv:8:{1 + 2 * axis}: found {'xy'[axis]} = ")


def test_a_map_from_a_pipe(asperity, tmp_path):
    path = write_matrix(tmp_path / "a.txt", MADE["smooth"]())
    command = [asperity, "summits", "--spacing", "1,1"]
    direct = run_program(*command, path)
    for name in ("/dev/stdin", "-"):
        piped = run_program(*command, name, input=path.read_text(encoding="ascii"))
        assert piped.stdout.splitlines()[1:] == direct.stdout.splitlines()[1:]


# ---------------------------------------------------------------- what is refused

GOOD = "0 0 0\n0 1 0\n0 0 0\n"
BINARY = (b"bISO-1.0sdfio     010120261200010120261200" + bytes([3, 0, 3, 0]) +
          np.array([1e-6, 1e-6, 1e-9, -1.0]).tobytes() + bytes([0, 5, 0]))


@pytest.mark.parametrize("content, options, message", [
    ("", [], r"1:1: the file is empty"),
    (GOOD.replace("1", "x"), ["--spacing=1,1"], r"2:3: found 'x', expected a height"),
    ("0 0 0\n0 1\n0 0 0\n", ["--spacing=1,1"], r"2:4: found 2 pixels, expected 3"),
    ("0,0,0\n0,,0\n0,0,0\n", ["--spacing=1,1"], r"2:3: found '', expected a height"),
    ("0 0 0\n1e31 0 0\n0 0 0\n", ["--spacing=1,1"], r"2:1: found '1e31'"),
    ("0 0\n0 1\n", ["--spacing=1,1"], r" found 2 x 2 pixels, expected at least 3 x 3"),
    ("nan nan nan\n" * 3, ["--spacing=1,1"], r" all pixels are missing"),
    ("0 0 0 0\n" * 3, [], r"1:1: a matrix of heights has no spacing: found no --spacing"),
    ("0,0,0 0\n" * 3, ["--spacing=1,1"], r"1:5: found '0 0', expected a height"),
    (grid(lambda points: points[:5] + points[6:]), [], r"7:1: found x = '2', expected x = 1\.0+E"),
    (grid(lambda points: points[:5] + points[4:]), [], r"7:1: found x = '0', expected x = 1\.0+E"),
    (grid(lambda points: points[:-1]), [], r"13:1: found the end of the file, expected x = 3\.0+E"),
    (grid(lambda points: points[::2] + points[1::2]), [], r"4:3: found y = '2', expected x = 0\.0"),
    (grid(lambda points: points[1:2] + points[:1] + points[2:]), [], r"\d+:\d+: found "),
    (grid(lambda points: points[:4]), [], r"6:1: found 4 points in no order of columns and rows"),
    (grid(lambda points: 12 * points[:1]), [], r"14:1: found 12 points in no order"),
    (grid(lambda points: points + [[0, 6]]), [], r"14:1: found 2 cells, expected 3"),
    (grid(lambda points: points[:7] + [["nan", 2, 0]] + points[8:]), [], r"9:1: found 'nan'"),
    (grid(lambda points: points[:7] + [[3, 2, "x"]] + points[8:]), [], r"9:5: found 'x', expected"),
    (grid(), ["--spacing=1,2"], r"1:1: --spacing given, but x,y,z lines have their own spacing"),
    (b"\x00\x01\x02", [], r"1:1: found a control character"),
    (HEADER, [], r" found \d+ bytes, expected 3 x 4 pixels of INT16"),
    (HEADER + "*\n" + "a comment of some length\n", [],
     r"15:1: the pixels end behind 0, expected 3 x 4"),
    (HEADER + "1 " * 13 + "*", [], r"15:25: found '1' behind 3 x 4 pixels"),
    (HEADER + "1 2 3.5 " + "1 " * 9 + "*", [], r"15:5: found '3.5', expected a whole number"),
    (HEADER.replace("= 3", "= -3"), [], r"5:15: NumPoints: found '-3'"),
    (HEADER.replace("1e-6", "0"), [], r"7:15: Xscale: found '0', expected a length"),
    (HEADER.replace("BCR", "ABC"), [], r"1:"),
    (HEADER.replace("1.0", "9.0"), [], r"1:1: unknown revision: found 'aBCR-9.0'"),
    (HEADER.replace("yscale", "y"), [], r"14:1: the header ends without Yscale"),
    (HEADER.replace("yscale", "xscale"), [], r"8:1: Xscale occurs twice"),
    (HEADER.replace("INTEGER", "8"), [], r"12:15: DataType: found '8', expected one of 0 \(UINT8"),
    (HEADER.replace("NULL", "1"), [], r"11:15: Compression: found '1'"),
    (HEADER, ["--spacing=1,1"], r"--spacing given, but the map has its own"),
    (BINARY, [], r" found 81 bytes, expected 3 x 3 pixels of INT16"),
    (BINARY[:70], [], r" byte 71, record 1: the file ends in the header, expected 81 bytes"),
    (BINARY[:42] + bytes([0]) + BINARY[43:], [], r" byte 43, record 1: NumPoints: found 0"),
    (BINARY[:79] + bytes([3]) + BINARY[80:] + bytes(40), [],
     r" byte 80, record 1: DataType: found 3"),
    (BINARY[:78] + bytes([1]) + BINARY[79:], [], r" byte 79, record 1: Compression: found 1"),
    (BINARY[:46] + bytes(8) + BINARY[54:], [], r" byte 47, record 1: Xscale: found 0.0"),
    (BINARY[:79] + bytes([7]) + BINARY[80:] + np.array([1.0] * 5 + [np.inf] + [2.0] * 3).tobytes(),
     [], r" byte 122, record 2: pixel 3 of profile 2: found an infinite"),
])
def test_bad_maps_are_refused(content, options, message, summits, tmp_path):
    data = content if isinstance(content, bytes) else content.encode()
    (tmp_path / "bad.map").write_bytes(data)
    done = summits("bad.map", *options, status=2)
    shown = done.stderr.splitlines()
    assert any(re.match(rf"(?:bad\.map:)? ?{message}", line) for line in shown), done.stderr


def test_each_profile_with_a_fault_is_named(summits, tmp_path):
    (tmp_path / "a.txt").write_text("0 0 0\n0 1\n0 0 b\n", encoding="ascii")
    done = summits("a.txt", "--spacing=1,1", status=2)
    assert [line.split(": ")[0] for line in done.stderr.splitlines()] == \
        ["a.txt:2:4", "a.txt:3:5"]


def test_missing_memory_is_reported(summits, asperity, tmp_path):
    """Status 1 and a sentence."""
    import resource
    with open(tmp_path / "a.sdf", "wb") as file:
        file.write(BINARY[:42] + (5000).to_bytes(2, "little") * 2 + BINARY[46:])
        file.truncate(81 + 2 * 5000 ** 2)

    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (150_000_000, 150_000_000))

    done = run_program(asperity, "summits", "a.sdf", "--output", "b.csv", status=1, cwd=tmp_path,
                       preexec_fn=limit, variables={"OMP_NUM_THREADS": "1"})
    assert "not enough memory" in done.stderr
    assert not (tmp_path / "b.csv").exists()
