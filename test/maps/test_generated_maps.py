"""Random height maps of `asperity generate`, against an independent synthesis in numpy, and power
spectra of `asperity summits --spectrum`, against numpy and SurfaceTopography."""

import math
import statistics

import numpy as np
import pytest

from philox import philox
from programs import run_program
from surfaces_csv import records

# A small map whose sides, spacings and lengths differ, with a prime factor of 7.
SMALL = ("&map pixels = 42, 30, spacing = 0.5, 0.75, hurst = 0.7, roll_off = 9., cut_off = 2.,\n"
         "  {rms}, seed = 5{more} /\n")


# The distribution of a Gaussian of deviation 1, and its inverse (Wichura, AS 241, 1e-16).
ndtr = np.vectorize(lambda z: math.erfc(-z / math.sqrt(2)) / 2)
ndtri = np.vectorize(statistics.NormalDist().inv_cdf)


@pytest.fixture
def run(asperity, tmp_path):
    def start(*words, status=0, **environment):
        return run_program(asperity, *words, status=status, cwd=tmp_path, variables=environment)
    return start


@pytest.fixture
def generate(run, tmp_path):
    """The heights of a specification, by row and column."""
    def start(text, **environment):
        (tmp_path / "map.spec").write_text(text, encoding="ascii")
        run("generate", "map.spec", "--output", "map.npy", **environment)
        return np.load(tmp_path / "map.npy")
    return start


def gaussian(words):
    """Deviations from three words each: the inverse of a Gaussian between -8 and 8, by 1024 pieces
    of equal length, of which the first 52 bits choose one and 31 more bits the place in it."""
    edges = np.linspace(-8.0, 8.0, 1025)
    counts = np.rint(2.0 ** 52 * (ndtr(edges) - ndtr(-8.0)) / (ndtr(8.0) - ndtr(-8.0)))
    wanted = (words[0] << np.uint64(20) | words[1] >> np.uint64(12)).astype(float)
    piece = np.searchsorted(counts, wanted, side="right") - 1
    share = (words[2] >> np.uint64(1)) / 2.0 ** 31
    # In the tail nearer to the piece no digit is lost.
    sign = np.where(piece < 512, 1.0, -1.0)
    left, right = ndtr(sign * edges[piece]), ndtr(sign * edges[piece + 1])
    return sign * ndtri(left + share * (right - left))


def synthesis(columns, rows, spacing, hurst, roll_off, cut_off, seed, below="flat"):
    """Components a(q) of the periodic map, in the layout of np.fft, and its wave vectors."""
    kx, ky = np.meshgrid(np.fft.fftfreq(columns, 1 / columns).astype(int),
                         np.fft.fftfreq(rows, 1 / rows).astype(int))
    qx, qy = 2 * np.pi * kx / columns / spacing[0], 2 * np.pi * ky / rows / spacing[1]
    q, q_r, q_c = np.hypot(qx, qy), 2 * np.pi / roll_off, 2 * np.pi / cut_off
    density = np.maximum(q, q_r) ** (-2 * (1 + hurst)) * (q <= q_c * (1 + 1e-13)) * (q > 0)
    if below == "none":
        density *= q >= q_r * (1 - 1e-13)
    # A wave of two pixels has no power.
    density *= (2 * abs(kx) < columns) & (2 * abs(ky) < rows)
    half = (kx > 0) | (kx == 0) & (ky > 0)
    draws = [gaussian(philox((kx[half] & 0xFFFFFFFF, ky[half] & 0xFFFFFFFF, part, 7),
                             (seed, 0)))
             for part in (1, 2)]
    waves = np.zeros((rows, columns), complex)
    waves[half] = (draws[0] + 1j * draws[1]) * np.sqrt(density[half])
    mirrored = np.roll(waves[::-1, ::-1], (1, 1), (0, 1)).conj()
    return waves + mirrored, qx, qy


def summed(waves):
    heights = np.fft.ifft2(waves) * waves.size
    assert abs(heights.imag).max() <= 1e-12 * abs(heights.real).max()
    return heights.real


@pytest.mark.parametrize("below", ("flat", "none"))
@pytest.mark.parametrize("quantity", ("rms_height", "rms_slope"))
@pytest.mark.parametrize("periodic", ("on", "off"))
def test_heights_are_those_of_the_definition(below, quantity, periodic, generate):
    """The map anew with numpy's transform. Allowed: 1e-9 of the rms height, for the draws, whose
    stated error is 1e-11 of their range of 16 deviations."""
    found = generate(SMALL.format(rms=f"{quantity} = 0.3", more=f", periodic = '{periodic}', "
                                  f"below_roll_off = '{below}'"))
    # 84 x 60 pixels for a free map: no prime factor above 5 from twice 42 on is 90.
    columns, rows = (42, 30) if periodic == "on" else (90, 60)
    waves, qx, qy = synthesis(columns, rows, (0.5, 0.75), 0.7, 9.0, 2.0, 5, below)
    part = np.s_[:30, :42]
    heights = summed(waves)[part]
    heights -= heights.mean()
    slopes = [summed(1j * q * waves)[part] for q in (qx, qy)]
    rms = heights.std() if quantity == "rms_height" else \
        np.sqrt((slopes[0] ** 2 + slopes[1] ** 2).mean())
    wanted = heights * (0.3 / rms)
    met = int((abs(found - wanted) <= 1e-9 * wanted.std()).sum())
    assert found.shape == (30, 42)
    assert met == found.size


def test_seeds_differ_and_threads_do_not(generate):
    text = ("&map pixels = 256, spacing = 1., hurst = 0.8, roll_off = 16., rms_height = 1., "
            "seed = {} /")
    first, second = generate(text.format(0)), generate(text.format(2147483647))
    assert abs((first * second).mean()) < 0.2
    for threads in (1, 2, 5):
        again = generate(text.format(0), OMP_NUM_THREADS=str(threads))
        assert again.tobytes() == first.tobytes()


def test_finer_pixels_show_the_same_map(generate):
    """Waves depend on neither spacing nor number of pixels: at half the spacing, with the cut-off
    of the coarse map, every other height is the same."""
    text = ("&map pixels = {}, spacing = {}, hurst = 0.8, roll_off = 8., cut_off = 2., "
            "rms_height = 1., seed = 4 /")
    coarse, fine = generate(text.format(64, 0.5)), generate(text.format(128, 0.25))
    assert abs(fine[::2, ::2] - coarse).max() < 1e-8


def test_defaults(generate, run, tmp_path):
    """Roll-off: the shorter side; cut-off: two of the larger spacings."""
    text = "&map pixels = 40, 60, spacing = 0.5, 0.4, hurst = 0.8, rms_height = 1.{} /"
    short = generate(text.format(""))
    long = generate(text.format(", roll_off = 20., cut_off = 1., seed = 1, periodic = 'on', "
                                "below_roll_off = 'flat'"))
    assert short.tobytes() == long.tobytes()
    assert generate(text.format(", roll_off = 19.")).tobytes() != short.tobytes()


@pytest.mark.parametrize("ending", ("sdf", "npy", "txt"))
def test_files_have_the_same_heights(ending, generate, run, tmp_path):
    """All formats, and standard output, which is text."""
    heights = generate(SMALL.format(rms="rms_height = 0.3", more=", unit = 'um'"))
    done = run("generate", "map.spec", "--output", f"again.{ending}")
    assert done.stdout == ""
    # SMALL is periodic, which neither an array nor surface data can keep.
    assert done.stderr.count("has no edge: give it as periodic where it is read\n") == \
        len(done.stderr.splitlines()) == (ending != "txt")
    spacing = () if ending == "sdf" else ("--spacing", "0.5,0.75")
    report = run("summits", f"again.{ending}", *spacing, "--edge", "free", "--unit", "um").stdout
    assert "42 x 30 pixels" in report
    # Of a free map without its plane.
    x, y = np.meshgrid(np.arange(42.0), np.arange(30.0))
    basis = np.stack([x.ravel(), y.ravel(), np.ones(x.size)], 1)
    level = heights.ravel() - basis @ np.linalg.lstsq(basis, heights.ravel(), rcond=None)[0]
    found = float(next(line.split()[2] for line in report.splitlines() if "rms height" in line))
    assert found == pytest.approx(level.std(), rel=1e-12)
    if ending == "txt":
        assert run("generate", "map.spec").stdout == (tmp_path / "again.txt").read_text()


BAD = [
    ("&map hurst = 0.8, rms_height = 1. /", "1:1: &map needs pixels: found none"),
    ("&map hurst = 0.8, rms_height = 1. /", "1:1: &map needs spacing: found none"),
    ("&map pixels = 64, spacing = 1., rms_height = 1. /", "1:1: &map needs hurst: found none"),
    ("&map pixels = 64, spacing = 1., hurst = 0.8 /",
     "1:1: &map needs rms_height or rms_slope: found none"),
    ("&map pixels = 64, spacing = 1., hurst = 0.8, rms_height = 1., rms_slope = 1. /",
     "1:63: rms_slope: found beside rms_height, expected one of them"),
    ("&map pixels = 2.5, spacing = 1., hurst = 0.8, rms_height = 1. /",
     "1:15: pixels: found '2.5', expected a whole number from 3 to 1048576"),
    ("&map pixels = 64, spacing = 1e-31, hurst = 0.8, rms_height = 1. /",
     "1:29: spacing: found '1e-31', expected a length from 1e-30 to 1e30"),
    ("&map pixels = 64, spacing = 1., hurst = 1.1, rms_height = 1. /",
     "1:41: hurst: found '1.1', expected a number more than 0 and at most 1"),
    ("&map pixels = 64, spacing = 1., hurst = 0.8, rms_height = 0. /",
     "1:59: rms_height: found '0.', expected a length from 1e-30 to 1e30"),
    ("&map pixels = 64, spacing = 1., hurst = 0.8, rms_height = 1.,\n cut_off = 1.9 /",
     "2:2: cut_off: found less than two pixels, expected at least two spacings"),
    ("&map pixels = 64, spacing = 1., hurst = 0.8, rms_height = 1.,\n roll_off = 2. /",
     "2:2: roll_off: found at most the cut-off, expected a wavelength above cut_off"),
    ("&map pixels = 64, spacing = 1., hurst = 0.8, rms_height = 1.,\n cut_off = 64. /",
     "2:2: cut_off: found at least the roll-off, expected a wavelength below roll_off"),
    ("&map pixels = 64, 3, spacing = 1., 2., hurst = 0.8, rms_height = 1.,\n"
     " roll_off = 4.12, cut_off = 4.1, below_roll_off = 'none' /",
     "1:1: found no wave of the map between cut_off and roll_off"),
    ("&map pixels = 64, spacing = 1., hurst = 0.8, rms_height = 1., seed = -1 /",
     "1:70: seed: found '-1', expected a whole number from 0 to 2147483647"),
    ("&map pixels = 64, spacing = 1., hurst = 0.8, rms_height = 1., periodic = 'yes' /",
     "1:74: periodic: found the text 'yes', expected 'on' or 'off'"),
    ("&map pixels = 64, spacing = 1., hurst = 0.8, rms_height = 1., below_roll_off = 'flta' /",
     "1:80: below_roll_off: found the text 'flta', expected 'flat' or 'none'; did you mean "
     "'flat'?"),
    ("&map pixels = 64, spacing = 1., hurst = 0.8, rms_height = 1., unit = 'km' /",
     "1:70: unit: found the text 'km', expected 'm', 'mm', 'um', 'nm', 'cm' or 'in'"),
    ("&map pixels = 64, spacing = 1., hurst = 0.8, rms_height = 1. /\n&random seed = 1 /",
     "2:1: found &random beside &map, expected one of them"),
    ("&map pixels = 64, spacings = 1., hurst = 0.8, rms_height = 1. /",
     "1:19: unknown name in &map: found 'spacings'"),
]


@pytest.mark.parametrize("text, message", BAD, ids=[str(k) for k in range(len(BAD))])
def test_problems_are_reported_with_their_place(text, message, run, tmp_path):
    (tmp_path / "bad.spec").write_text(text + "\n", encoding="ascii")
    done = run("generate", "bad.spec", "--output", "bad.npy", status=2)
    assert f"bad.spec:{message}" in done.stderr
    assert done.stdout == "" and not (tmp_path / "bad.npy").exists()


def test_numbers_at_the_ends_of_their_ranges(generate, run, tmp_path):
    """Sides of unequal order of magnitude, a roll-off beyond every wave, a double as it is."""
    heights = generate("&map pixels = 5, 7, spacing = 1e-30, 1e30, hurst = 1e-9, cut_off = 2e30, "
                       "roll_off = 1e300, rms_height = 1. /")
    assert heights.std() == pytest.approx(1.0, rel=1e-12)
    # No wave along x.
    assert np.ptp(heights, axis=1).max() < 1e-12
    text = "&map pixels = 16, spacing = 1., hurst = {}, rms_height = {} /"
    (tmp_path / "map.spec").write_text(text.format(0.7, "9e29"), encoding="ascii")
    done = run("generate", "map.spec", "--output", "high.npy", status=1)
    assert "map.spec: heights beyond 1e30, expected a lower rms value" in done.stderr


def test_memory_is_requested_before_the_map(asperity, tmp_path):
    """Under a limit of the shell: status 1, and no file; also of more pixels than 2**31."""
    for pixels in (20000, 1048576):
        (tmp_path / "map.spec").write_text(f"&map pixels = {pixels}, spacing = 1., hurst = 0.8, "
                                           "rms_height = 1. /\n", encoding="ascii")
        done = run_program("bash", "-c", "ulimit -v 2000000; OMP_NUM_THREADS=1 "
                           f"{asperity} generate map.spec --output map.npy", status=1, cwd=tmp_path)
        assert f"not enough memory for the map, {pixels} x {pixels} pixels" in done.stderr
        assert not (tmp_path / "map.npy").exists()


def spectra(path):
    """The three spectra of a CSV: columns of numbers."""
    found = {"iso": [], "x": [], "y": []}
    for row in records(path):
        assert list(row) == ["spectrum", "q", "c_iso", "c_1d", "number"]
        kind = row["spectrum"]
        full, empty = ("c_iso", "c_1d") if kind == "iso" else ("c_1d", "c_iso")
        assert row[empty] == ""
        found[kind].append([float(row["q"]), float(row[full]), int(row["number"])])
    return {kind: np.array(rows).T for kind, rows in found.items()}


@pytest.mark.parametrize("edge", ("free", "periodic"))
@pytest.mark.parametrize("columns, rows, dx, dy", ((96, 70, 0.5, 0.4), (65, 81, 0.2, 0.3),
                                                   (128, 128, 1.0, 1.0)))
def test_spectra_are_those_of_SurfaceTopography(columns, rows, dx, dy, edge, run, tmp_path):
    """A map with waves and noise, from its mean. Rings whose edges it has, too, and lines."""
    topography = pytest.importorskip("SurfaceTopography").Topography
    random = np.random.default_rng(8)
    x, y = np.meshgrid(np.arange(columns) * dx, np.arange(rows) * dy)
    z = np.cos(0.7 * x) + 0.3 * np.sin(1.1 * y) + 0.1 * random.standard_normal((rows, columns))
    z -= z.mean()
    np.save(tmp_path / "map.npy", z)
    run("summits", "map.npy", "--spacing", f"{dx},{dy}", "--edge", edge, "--level", "none",
        "--spectrum", "spectrum.csv")
    found = spectra(tmp_path / "spectrum.csv")
    sides = columns * dx, rows * dy
    other = topography(z.T, sides, periodic=edge == "periodic")
    q, c = other.power_spectrum_from_area()
    np.testing.assert_allclose(found["iso"][0], np.ma.compressed(q), rtol=1e-10)
    np.testing.assert_allclose(found["iso"][1], np.ma.compressed(c), rtol=1e-10)
    # It does not take the mean out of a line before the window.
    lines_of = [topography((h - h.mean(axis=1, keepdims=True)).T, side,
                           periodic=edge == "periodic")
                for h, side in ((z, sides), (z.T, sides[::-1]))]
    for kind, map_of, lines in zip("xy", lines_of, (rows, columns)):
        q, c = map_of.power_spectrum_from_profile(resampling_method=None)
        # It leaves out q = 0 here, and of an odd number of pixels the last wave number there.
        q, c = q[1:], c[1:]
        np.testing.assert_allclose(found[kind][0][:len(q)], q, rtol=1e-10)
        np.testing.assert_allclose(found[kind][1][:len(q)], c, rtol=1e-10)
        assert len(found[kind][0]) == (map_of.nb_grid_pts[0] - 1) // 2
        assert (found[kind][2] == lines).all()


@pytest.mark.parametrize("kind", ["x", "y"])
def test_spectra_of_grooves(kind, run, tmp_path):
    """Lines along grooves have their means taken out: twice the sum is their mean square, here
    within the leakage of Hann's window, and their height has no share in it."""
    z = np.sin(2 * np.pi * 7.3 / 128 * np.arange(128))[:, None] + \
        0.02 * np.random.default_rng(2).standard_normal((128, 128))
    np.save(tmp_path / "map.npy", z if kind == "x" else z.T)
    run("summits", "map.npy", "--spacing", "1,1", "--level", "mean", "--spectrum", "s.csv")
    density = spectra(tmp_path / "s.csv")[kind][1]
    about = z - z.mean(axis=1, keepdims=True)
    assert 2 * density.sum() / 128 == pytest.approx((about ** 2).mean(), rel=0.05)
    window = 1 - np.cos(2 * np.pi * np.arange(128) / 128)
    waves = np.abs(np.fft.rfft(about * window / np.sqrt((window ** 2).mean()), axis=1)) ** 2
    np.testing.assert_allclose(density, waves.mean(axis=0)[1:64] / 128, rtol=1e-9)


def test_missing_pixels_have_no_spectrum(run, tmp_path):
    z = np.arange(30.0).reshape(5, 6) % 7
    z[2, 3] = z[4, 0] = np.nan
    np.save(tmp_path / "map.npy", z)
    done = run("summits", "map.npy", "--spacing", "1,1", "--spectrum", "s.csv", status=2)
    assert ("--spectrum: map.npy: found 2 missing pixels, expected none, as a power spectrum needs "
            "all heights") in done.stderr
    assert not (tmp_path / "s.csv").exists()


@pytest.mark.parametrize("edge", ("free", "periodic"))
def test_statistics_are_those_of_SurfaceTopography(edge, generate, run, tmp_path):
    """rms height, and the mean squares of slope and curvature of all lines along x and along y. The
    gradient of a whole free map is another one there: it leaves out the slopes along x of the last
    row and those along y of the last column."""
    surface = pytest.importorskip("SurfaceTopography")
    periodic = edge == "periodic"
    z = generate(SMALL.format(rms="rms_height = 0.3", more=""))
    report = run("summits", "map.npy", "--spacing", "0.5,0.75", "--edge", edge, "--level",
                 "mean").stdout
    found = {line[:24].strip(): float(line[24:48]) for line in report.splitlines()[2:]
             if line[24:48].strip() not in ("", "-")}
    other = surface.Topography(z.T, (21.0, 22.5), periodic=periodic)
    assert found["rms height"] == pytest.approx(other.rms_height_from_area(), rel=1e-10)
    for number, which in ((1, "m2"), (2, "m4")):
        for along, lines, side in (("x", z, 21.0), ("y", z.T, 22.5)):
            slopes = [surface.UniformLineScan(line, side, periodic=periodic).derivative(number)
                      for line in lines]
            assert found[f"{which} along {along}"] == \
                pytest.approx((np.array(slopes) ** 2).mean(), rel=1e-10)
    gradient = other.rms_gradient()
    assert found["rms slope"] == pytest.approx(gradient, rel=1e-10 if periodic else 0.02)
    assert periodic or abs(found["rms slope"] / gradient - 1) > 1e-6
