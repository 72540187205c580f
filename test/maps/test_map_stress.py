"""Stress below the pixels (`--depths`, `--stress`): Hertz' largest stresses, waves of pressure in
closed form, one pixel by quadrature of Boussinesq's and Cerruti's point loads, a sliding sphere,
asperities, files in all formats, refused options."""

import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss

from image_data import read_vti
from programs import run_program
from map_scenes import map_scene
from surfaces_csv import records, write_plane_scene

MODULUS, RATIO = 2.0e3, 0.3
COMBINED = MODULUS / (1 - RATIO**2) / 2
COMPONENTS = ("xx", "yy", "zz", "xy", "xz", "yz")


def below(asperity, folder, height, sides, depths, loading, ratio=RATIO, **surfaces):
    """Numbers of the table by name, indexed [depth, x, y], and the summary."""
    scene = map_scene(folder, height, sides, name="s",
                      surfaces={"map_level": "none", **surfaces}, loading=loading,
                      material={"elastic_modulus": (MODULUS, MODULUS),
                                "poisson_ratio": (ratio, ratio)})
    return table_of(asperity, scene, folder, depths, height.shape)


def table_of(asperity, scene, folder, depths, shape, body="lower"):
    found = run_program(asperity, "solve", scene, "--depths", depths, "--body", body, "--stress",
                        folder / "s.csv", "--positions", folder / "p.csv", "--fields",
                        folder / "f.vti")
    rows = records(folder / "s.csv")
    numbers = {name: np.array([float(row[name]) for row in rows]).reshape(-1, *shape[::-1])
               .transpose(0, 2, 1) for name in rows[0]}
    position, = records(folder / "p.csv")
    return numbers, found.stdout, float(position["load"])


def principal(numbers):
    """Largest von Mises and shear stress from the components."""
    xx, yy, zz, xy, xz, yz = (numbers[f"stress_{name}"] for name in COMPONENTS)
    tensor = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], -1).reshape(*xx.shape, 3, 3)
    values = np.linalg.eigvalsh(tensor)
    mises = np.sqrt(((values - np.roll(values, 1, -1)) ** 2).sum(-1) / 2)
    return mises, (values[..., 2] - values[..., 0]) / 2


def test_largest_stresses_of_hertz(asperity, tmp_path):
    contact, pixels = 0.1, 101
    side = 2.1 * contact / pixels
    place = (np.arange(pixels) - pixels // 2) * side
    height = -(place[:, None] ** 2 + place[None, :] ** 2) / 2
    peak = 2 * COMBINED * contact / np.pi
    numbers, text, _ = below(asperity, tmp_path, height, (side, side), "0.045:0.051:7",
                             {"control": "load", "value": 4 / 3 * COMBINED * contact**3})
    mises, shear = principal(numbers)
    assert np.abs(numbers["von_mises"] - mises).max() < 1e-12 * peak
    assert np.abs(numbers["largest_shear"] - shear).max() < 1e-7 * peak
    # Johnson (1985), section 3.4: .620 and .310 of the greatest pressure at .48 of the radius.
    z = np.linspace(0.3, 0.7, 4001)
    radial = -((1 + RATIO) * (1 - z * np.arctan(1 / z)) - 0.5 / (1 + z**2))
    truth = np.abs(radial + 1 / (1 + z**2))
    assert truth.max() == pytest.approx(0.620, abs=5e-4)
    middle = pixels // 2
    for found, factor in ((numbers["von_mises"], 1.0), (numbers["largest_shear"], 0.5)):
        depth, x, y = np.unravel_index(found.argmax(), found.shape)
        assert (x, y) == (middle, middle)
        assert found.max() / peak == pytest.approx(factor * truth.max(), rel=2e-3)
        assert numbers["depth"][depth, x, y] == pytest.approx(contact * z[truth.argmax()],
                                                              abs=1.01e-3)
    printed = re.findall(r"(von Mises|largest shear) stress\s+(\S+) at depth (\S+), x (\S+), "
                         r"y (\S+)\n", text)
    assert [name for name, *_ in printed] == ["von Mises", "largest shear"]
    assert float(printed[0][1]) == pytest.approx(numbers["von_mises"].max(), rel=1e-5)
    assert float(printed[1][1]) == pytest.approx(numbers["largest_shear"].max(), rel=1e-5)
    assert float(printed[0][3]) == pytest.approx(middle * side, rel=1e-5)


@pytest.mark.parametrize("waves", [(1, 0), (0, 3), (2, 1)])
def test_wave_of_pressure(asperity, tmp_path, waves):
    """Full contact of a cosine: stresses of plane strain, turned into the direction of the wave."""
    shape, sides = (24, 18), (0.01, 0.013)
    place = np.meshgrid(*(np.arange(n) * s for n, s in zip(shape, sides)), indexing="ij")
    number = 2 * np.pi * np.array(waves) / (np.array(shape) * sides)
    q = np.hypot(*number)
    phase = number[0] * place[0] + number[1] * place[1]
    amplitude = 1e-4
    peak = COMBINED * q * amplitude / 2
    load = 1.5 * peak * np.prod(shape) * np.prod(sides)
    numbers, _, _ = below(asperity, tmp_path, amplitude * np.cos(phase), sides, "0.01,0.03",
                          {"control": "load", "value": float(load)}, map_edge="periodic")
    # The solve leaves 1e-10 of the heights: the wave is that of the pressures that were found.
    found = read_vti(tmp_path / "f.vti")[2]["pressure"]
    amplitude = 2 * (found * np.cos(phase)).mean()
    assert amplitude == pytest.approx(peak, rel=1e-9)
    peak = amplitude
    for k, z in enumerate((0.01, 0.03)):
        fall = peak * np.exp(-q * z)
        along, down = -fall * (1 - q * z) * np.cos(phase), -fall * (1 + q * z) * np.cos(phase)
        shear = -fall * q * z * np.sin(phase)
        across = RATIO * (along + down)
        c, s = number / q
        mean = -1.5 * peak
        truth = {"xx": c * c * along + s * s * across + mean * RATIO / (1 - RATIO),
                 "yy": s * s * along + c * c * across + mean * RATIO / (1 - RATIO),
                 "zz": down + mean, "xy": c * s * (along - across), "xz": c * shear,
                 "yz": s * shear}
        for name, stress in truth.items():
            error = numbers[f"stress_{name}"][k] - stress
            of_wave = [error.mean(), (error * np.exp(1j * phase)).mean()]
            assert np.abs(of_wave).max() < 1e-10 * peak, (name, of_wave)
            assert np.abs(error).max() < 1e-9 * peak, name


def point_load(x, y, z, ratio):
    """Stresses by a unit load at the origin, times 2 pi (Johnson 1985, equation 3.19)."""
    r = np.sqrt(x * x + y * y + z * z)
    square = x * x + y * y

    def lateral(x, y):
        return (1 - 2 * ratio) / square * ((1 - z / r) * (x * x - y * y) / square +
                                           z * y * y / r**3) - 3 * z * x * x / r**5

    return {"xx": lateral(x, y), "yy": lateral(y, x), "zz": -3 * z**3 / r**5,
            "xy": (1 - 2 * ratio) / square * ((1 - z / r) * 2 * x * y / square -
                                              x * y * z / r**3) - 3 * x * y * z / r**5,
            "xz": -3 * x * z * z / r**5, "yz": -3 * y * z * z / r**5}


@pytest.mark.parametrize("ratio", [-0.5, 0.0, 0.3, 0.5])
def test_one_pixel_by_quadrature(asperity, tmp_path, ratio):
    shape, sides = (9, 7), (1.0, 1.3)
    height = np.full(shape, -10.0)
    height[4, 2] = 0.0
    numbers, _, load = below(asperity, tmp_path, height, sides, "0.7,3",
                             {"control": "load", "value": 1.0}, ratio)
    pressure = load / np.prod(sides)
    node, weight = leggauss(60)
    u, v = np.meshgrid(node * sides[0] / 2, node * sides[1] / 2, indexing="ij")
    share = np.outer(weight, weight) * np.prod(sides) / 4
    for k, z in enumerate((0.7, 3.0)):
        for i, j in ((4, 2), (5, 2), (4, 1), (6, 4), (0, 6), (1, 0)):
            truth = point_load((i - 4) * sides[0] - u, (j - 2) * sides[1] - v, z, ratio)
            for name, values in truth.items():
                stress = pressure * (values * share).sum() / (2 * np.pi)
                assert numbers[f"stress_{name}"][k, i, j] == pytest.approx(
                    stress, rel=1e-9, abs=1e-10 * pressure), (name, i, j)


def shear_load(x, y, z, ratio):
    """Stresses by a unit tangential load along x, times 2 pi (Johnson 1985, equation 3.76)."""
    r = np.sqrt(x * x + y * y + z * z)
    k, w = 1 - 2 * ratio, r + z
    return {"xx": -3 * x**3 / r**5 + k * (x / r**3 - 3 * x / (r * w * w) + x**3 / (r**3 * w * w) +
                                          2 * x**3 / (r * r * w**3)),
            "yy": -3 * x * y * y / r**5 + k * (x / r**3 - x / (r * w * w) + x * y * y / (
                r**3 * w * w) + 2 * x * y * y / (r * r * w**3)),
            "zz": -3 * x * z * z / r**5, "xz": -3 * x * x * z / r**5, "yz": -3 * x * y * z / r**5,
            "xy": -3 * x * x * y / r**5 + k * (-y / (r * w * w) + x * x * y / (r**3 * w * w) +
                                               2 * x * x * y / (r * r * w**3))}


@pytest.mark.parametrize("ratio", [-0.5, 0.3, 0.5])
def test_tractions_on_one_pixel_by_quadrature(package, ratio):
    """At the pixel, and two pixels away, where no step of tractions is beside."""
    shape, sides = (7, 9), (1.0, 1.3)
    body = package.HalfSpace(shape, sides, MODULUS, ratio)
    one, none = np.zeros(shape), np.zeros(shape)
    one[2, 4] = 1.0
    node, weight = leggauss(60)
    u, v = np.meshgrid(node * sides[0] / 2, node * sides[1] / 2, indexing="ij")
    share = np.outer(weight, weight) * np.prod(sides) / 4
    turned = dict(zip(COMPONENTS, ("yy", "xx", "zz", "xy", "yz", "xz")))
    for z in (0.7, 3.0):
        along, across = (body.stress(z, none, pair) for pair in ((one, none), (none, one)))
        for i, j in ((4, 2), (6, 4), (0, 6), (4, 0), (1, 2)):
            x, y = (i - 4) * sides[0] - u, (j - 2) * sides[1] - v
            for found, truth in ((along, shear_load(x, y, z, ratio)),
                                 (across, shear_load(y, x, z, ratio))):
                for name in COMPONENTS:
                    of = name if found is along else turned[name]
                    stress = (truth[of] * share).sum() / (2 * np.pi)
                    assert found[name][0, j, i] == pytest.approx(stress, rel=1e-9, abs=1e-10)


def sliding_sphere(x, y, friction):
    """Stresses at the surface of a sphere that slides along x, in the contact circle of radius 1,
    over p0: Hertz' (Johnson 1985, equation 3.42), and those of mu p (Hamilton and Goodman 1966)."""
    r = np.hypot(x, y)
    w = np.sqrt(np.maximum(0, 1 - r * r))
    a = (1 - 2 * RATIO) / 3 / r**2 * (1 - w**3)
    radial, hoop, c, s = a - w, -a - 2 * RATIO * w, x / r, y / r
    m = np.pi * friction / 8
    return {"xx": c * c * radial + s * s * hoop - m * (4 + RATIO) * x,
            "yy": s * s * radial + c * c * hoop - 3 * m * RATIO * x, "zz": -w,
            "xy": c * s * (radial - hoop) - m * (2 - RATIO) * y, "xz": -friction * w, "yz": 0 * w}


def hertz_pixels(pixels, side):
    """Places of the pixels, and Hertz' pressure over p0, the mean over each pixel."""
    place = (np.arange(pixels) - (pixels - 1) / 2) * side
    fine = (place[:, None] + ((np.arange(8) + 0.5) / 8 - 0.5) * side).ravel()
    p = np.sqrt(np.maximum(0, 1 - fine[:, None]**2 - fine**2))
    return np.meshgrid(place, place), p.reshape(pixels, 8, pixels, 8).mean(axis=(1, 3))


@pytest.mark.parametrize("friction", [0.25, 0.5])
def test_surface_of_a_sliding_sphere(package, friction):
    """Of second order in the pixels inside. The edge tension is (1 - 2 nu)/3 + pi mu (4 + nu)/8:
    at the rim pixels are 7 % low at 102 pixels a radius, and more before."""
    errors, tension = [], []
    for pixels in (64, 128, 256):
        (x, y), p = hertz_pixels(pixels, 2.5 / pixels)
        found = package.HalfSpace(p.shape, 2.5 / pixels, MODULUS, RATIO).stress(
            0.0, p, (friction * p, 0 * p))
        inside = np.hypot(x, y) < 0.6
        errors.append(max(np.abs(found[name][0] - truth)[inside].max()
                          for name, truth in sliding_sphere(x, y, friction).items()))
        tension.append(found["xx"].max())
    assert errors[0] < 1e-3 and errors[1] < errors[0] / 3.5 and errors[2] < errors[1] / 3.5, errors
    edge = (1 - 2 * RATIO) / 3 + np.pi * friction * (4 + RATIO) / 8
    shares = np.array(tension) / edge
    assert (np.diff(shares) > 0).all() and 0.91 < shares[-1] < 1, shares


@pytest.mark.parametrize("depth", [0.0, 0.01, 0.3])
def test_waves_are_the_sums_over_pixels(package, depth):
    """A local traction without a mean, on periodic and on free pixels: they differ by the pixel's
    own size alone."""
    n = 256
    x = (np.arange(n) - n // 2) / 16
    x, y = np.meshgrid(x, x)
    g = np.exp(-2 * (x * x + y * y))
    p, q = g * (x * x - y * y), (g * x * (1 - y), g * y)
    free, waves = (package.HalfSpace((n, n), 1 / 16, 1.0, RATIO, periodic=periodic).stress(
        depth, p, q) for periodic in (False, True))
    unit = max(np.abs(waves[name]).max() for name in COMPONENTS)
    for name in COMPONENTS:
        assert np.abs(free[name] - waves[name])[0, 96:160, 96:160].max() < 3e-3 * unit, name


@pytest.mark.parametrize("axis", [0, 1])
def test_tractions_on_strips_are_those_of_plane_strain(package, axis):
    """A band of tractions across the strip (Johnson 1985, section 2.6), three bands away, and along
    it: antiplane shear."""
    shape, sides = ((9, 6), (0.5, 1.0)) if axis == 0 else ((6, 9), (1.0, 0.5))
    body = package.HalfSpace(shape, sides, MODULUS, RATIO, periodic=(axis == 0, axis == 1))
    band, none = np.zeros(shape), np.zeros(shape)
    band[(4, slice(None)) if axis == 0 else (slice(None), 4)] = 1.0
    across, along = ("yy", "xx") if axis == 0 else ("xx", "yy")
    shear, other = ("yz", "xz") if axis == 0 else ("xz", "yz")
    z = 0.7
    for offset in (-4, -2, 0, 3):
        pick = (0, 4 + offset, slice(None)) if axis == 0 else (0, slice(None), 4 + offset)
        a, b = offset + 0.5, offset - 0.5
        logs = np.log(np.hypot(a, z) / np.hypot(b, z))
        squares = z * z / (a * a + z * z) - z * z / (b * b + z * z)
        angle = np.arctan2(a, z) - np.arctan2(b, z)
        double = a * z / (a * a + z * z) - b * z / (b * b + z * z)
        truth = {across: -2 / np.pi * logs - squares / np.pi, "zz": squares / np.pi,
                 shear: -(angle - double) / np.pi, "xy": 0.0, other: 0.0}
        truth[along] = RATIO * (truth[across] + truth["zz"])
        found = body.stress(z, none, (none, band) if axis == 0 else (band, none))
        for name, stress in truth.items():
            if abs(offset) != 1:
                assert np.abs(found[name][pick] - stress).max() < 1e-5, (name, offset)
        found = body.stress(z, none, (band, none) if axis == 0 else (none, band))
        for name in COMPONENTS:
            stress = {other: -angle / np.pi, "xy": -logs / np.pi}.get(name, 0.0)
            assert np.abs(found[name][pick] - stress).max() < 1e-5, (name, offset)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_tractions_of_a_scene_and_both_bodies(asperity, package, tmp_path):
    """Complete sliding: the stress of p and mu p in the lower body, of p and -mu p in the upper
    one, the same in the program, in C and of saved results; the rim of the contact is named."""
    pixels, contact = 64, 0.1
    side, friction = 2.5 * contact / pixels, 0.5
    place = (np.arange(pixels) - (pixels - 1) / 2) * side
    height = -(place[:, None] ** 2 + place[None, :] ** 2) / 2
    ratios = (0.2, RATIO)
    modulus = 1 / sum((1 - nu**2) / MODULUS for nu in ratios)
    load = 4 / 3 * modulus * contact**3
    scene = map_scene(tmp_path, height, (side, side), name="s", surfaces={"map_level": "none"},
                      material={"elastic_modulus": (MODULUS, MODULUS), "poisson_ratio": ratios},
                      effects={"friction_coefficient": friction},
                      loading={"control": "load", "value": load, "tangential_load": load})
    results = package.solve(scene, fields=True)
    p = np.nan_to_num(results.fields().pressure)
    results.save(tmp_path / "r.zip")
    depths = [0.0, 0.05]
    for body, sign in (("upper", -1), ("lower", 1)):
        nu = ratios[body == "lower"]
        half_space = package.HalfSpace(p.shape, side, MODULUS, nu)
        truth = half_space.stress(depths, p, (sign * friction * p, 0 * p))
        alone = half_space.stress(depths, p)
        numbers, text, _ = table_of(asperity, scene, tmp_path, "0,0.05", height.shape, body)
        saved = package.load(tmp_path / "r.zip").stress(depths, body=body)
        for name, values in truth.items():
            found = results.stress(depths, body=body)[name]
            assert np.abs(found - values).max() < 1e-9 * p.max(), name
            assert np.array_equal(saved[name], found)
            column = name if name in ("von_mises", "largest_shear") else f"stress_{name}"
            # The package has the release build, the program may have other flags.
            printed = numbers[column].transpose(0, 2, 1)
            assert np.abs(printed - found).max() < 1e-9 * p.max(), name
        assert np.abs(truth["xx"] - alone["xx"]).max() > 0.5 * p.max()
        assert f"Stress in the {body} body under pressures and tractions, largest" in text
        with pytest.warns(package.AccuracyWarning, match="on the rim of the contact: it grows"):
            results.stress(0.0, body=body).largest("xx")
    assert "on the rim of the contact, grows with resolution" in text
    with pytest.raises(package.InputError, match="body: found 'both', expected 'upper' or 'lower'"):
        results.stress(0.1, body="both")


@pytest.mark.parametrize("axis", [0, 1])
def test_stresses_on_strips_are_those_of_plane_strain(asperity, tmp_path, axis):
    """A line of pressure across a strip: plane strain of one pixel's band (Johnson 1985, section
    2.5). One pixel of a long strip: that of a free map, but for far images."""
    edges = ("periodic", "free") if axis == 0 else ("free", "periodic")
    shape, sides = ((6, 9), (0.5, 1.0)) if axis == 0 else ((9, 6), (1.0, 0.5))
    height = np.full(shape, -10.0)
    height[(slice(None), 4) if axis == 0 else (4, slice(None))] = 0.0
    numbers, _, load = below(asperity, tmp_path, height, sides, "0.7,3",
                             {"control": "load", "value": 1.0}, map_edge=edges)
    pressure = load / (6 * 0.5)
    names = dict(zip(COMPONENTS, COMPONENTS if axis == 0 else ("yy", "xx", "zz", "xy", "yz", "xz")))
    for k, z in enumerate((0.7, 3.0)):
        for offset in range(-4, 5):
            first, second = (np.arctan2(offset + half, z) for half in (0.5, -0.5))
            span, double = first - second, (np.sin(2 * first) - np.sin(2 * second)) / 2
            across = -pressure / np.pi * (span - double)
            down = -pressure / np.pi * (span + double)
            shear = pressure / np.pi * (np.cos(2 * first) - np.cos(2 * second)) / 2
            truth = {"xx": RATIO * (across + down), "yy": across, "zz": down, "xy": 0.0,
                     "xz": 0.0, "yz": shear}
            for name, stress in truth.items():
                found = numbers[f"stress_{names[name]}"][k]
                line = found[:, 4 + offset] if axis == 0 else found[4 + offset, :]
                assert np.abs(line - stress).max() < 1e-6 * pressure, (name, offset, line, stress)


def test_asperities_on_their_grid(asperity, tmp_path):
    """Below the grid of fields of a sphere: the stresses on the axis of Hertz' pressure."""
    contact, radius, side = 0.1, 1.0, 0.004
    load = 4 / 3 * COMBINED * contact**3 / radius
    scene = write_plane_scene(
        tmp_path, [(0.2, 0.2, 0.1, radius), (-0.3, -0.3, 0.0, radius)],
        surfaces={"field_spacing": side},
        modulus=(MODULUS, MODULUS), ratio=(RATIO, RATIO), effects={"interaction": "off"},
        loading={"control": "load", "value": load})
    found = run_program(asperity, "solve", scene, "--depths", "0.048")
    value, = re.findall(r"von Mises stress\s+(\S+) at depth", found.stdout)
    assert float(value) / (2 * COMBINED * contact / np.pi) == pytest.approx(0.620, rel=5e-3)


def test_all_formats_have_the_stresses_of_the_table(asperity, tmp_path):
    """JSON and a grid for ParaView have the numbers of the table; the first pixel is at 0."""
    numbers, _, _ = below(asperity, tmp_path, np.eye(5, 4), (1.0, 2.0), "0.5,2",
                          {"control": "load", "value": 10.0})
    for name in ("s.json", "s.vts"):
        run_program(asperity, "solve", tmp_path / "s.scene", "--quiet", "--depths", "0.5,2",
                    "--stress", tmp_path / name)
    lines = {name: values.transpose(0, 2, 1).ravel().tolist() for name, values in numbers.items()}
    assert (set(lines["x"]), set(lines["y"])) == ({0, 1, 2, 3, 4}, {0, 2, 4, 6})
    assert json.loads((tmp_path / "s.json").read_text()) == {"stress": lines}
    root = ElementTree.parse(tmp_path / "s.vts").getroot()
    assert (root.tag, root.get("type")) == ("VTKFile", "StructuredGrid")
    grid, = root.findall("StructuredGrid")
    piece, = grid.findall("Piece")
    assert grid.get("WholeExtent") == piece.get("Extent") == "0 4 0 3 0 1"
    points, = piece.findall("Points/DataArray")
    assert points.get("NumberOfComponents") == "3"
    found = np.array(points.text.split(), float).reshape(-1, 3)
    assert (found == np.transpose([lines.pop(name) for name in ("x", "y", "depth")])).all()
    assert {array.get("Name"): [float(word) for word in array.text.split()]
            for array in piece.findall("PointData/DataArray")} == lines
    assert piece.find("Verts") is None


@pytest.mark.parametrize("words, text", [
    (("--stress", "s.csv"), "--stress: expected --depths LIST beside it"),
    (("--stress", "s.vtk"), "expected a name that ends with .csv, .json or .vts"),
    (("--depths", "0.1,-0.1"), "expected depths of 0 or more"),
    (("--depths", "0.2:0.1:4"), "expected depths of 0 or more"),
    (("--depths", "0.1:0.2:1"), "expected depths of 0 or more"),
    (("--depths", "0.1,,0.2"), "expected depths of 0 or more"),
    (("--body", "upper"), "--body: expected --depths LIST beside it"),
    (("--depths", "0.1"), "--depths: stress needs poisson_ratio in &material")])
def test_refused_options(asperity, tmp_path, words, text):
    scene = map_scene(tmp_path, np.eye(8), (1.0, 1.0), material=10.0,
                      loading={"control": "load", "value": 1.0})
    found = run_program(asperity, "solve", scene, *words, status=2, cwd=tmp_path)
    assert text in found.stderr
