"""Layers bonded to the bodies of height maps: compliance and stress of waves against a solve of the
equations of plane strain (`layer_truth`), Hankel's integral on free maps, limits, refusals."""

import numpy as np
import pytest

from layer_truth import PAIRS, compliance, state
from scipy.special import j0

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")
N = 24
WAVES = ((1, 0), (0, 2), (3, 4), (10, 7))


def young(shear, ratio):
    return 2 * shear * (1 + ratio)


def layered(package, pair, n=N, periodic=True):
    thickness, shear, ratio, base, base_ratio = pair
    return package.HalfSpace((n, n), 1 / n, young(base, base_ratio), base_ratio, periodic=periodic,
                             layer=(thickness, young(shear, ratio), ratio))


def wave(numbers):
    x, y = np.meshgrid(np.arange(N) / N, np.arange(N) / N)
    return 2 * np.pi * np.hypot(*numbers), 2 * np.pi * (numbers[0] * x + numbers[1] * y)


@pytest.mark.parametrize("pair", PAIRS)
def test_waves_of_independent_materials(package, pair):
    thickness, shear, ratio, base, base_ratio = pair
    body = layered(package, pair)
    depths = thickness * np.array([0, 0.3, 1, 1 + 1e-12, 1.5])
    for numbers in WAVES:
        k, phase = wave(numbers)
        p, truth = np.cos(phase), compliance(k, *pair)
        displacement = body.displacement(p)
        assert np.abs(displacement - truth * p).max() < 1e-12 * truth
        assert np.abs(body.pressure(displacement) - p).max() < 1e-9
        c, s = np.array(numbers) / np.hypot(*numbers)
        found = body.stress(depths, p)
        for i, z in enumerate(depths[:3 if base == 0 else 5]):
            g, nu = (shear, ratio) if z <= thickness else (base, base_ratio)
            strain, _, zz, shearing = state(k, z, *pair)
            along = (-2 * g * k * strain + nu * zz) / (1 - nu)
            across = nu * (along + zz)
            truths = {"xx": (c * c * along + s * s * across) * p, "zz": zz * p,
                      "yy": (s * s * along + c * c * across) * p,
                      "xy": c * s * (along - across) * p,
                      "xz": -c * shearing * np.sin(phase), "yz": -s * shearing * np.sin(phase)}
            for name, stress in truths.items():
                assert np.abs(found[name][i] - stress).max() < 1e-12, (name, z, numbers)
        for name in ("zz", "xz", "yz"):
            assert np.abs(found[name][2] - found[name][3]).max() < 1e-11


@pytest.mark.parametrize("pair", [
    (0.1, 1.0, 0.3, 0.0, 0.3), (0.02, 1.0, 0.3, 10.0, 0.25), (0.1, 1.0, 0.3, 0.2, 0.4),
    (0.001, 1.0, 0.3, 0.2, 0.4), (5.0, 1.0, 0.3, 10.0, 0.25)])
def test_free_map_by_the_integral_of_hankel(package, pair):
    """A pressure exp(-r**2/(2 s**2)) on 96 pixels of 0.1 s, of which the uniform pixels have the
    curvature h**2/24 too much: the rest is of third order in h."""
    n, s = 96, 5 / 48
    x = (np.arange(n) + 0.5) / n - 0.5
    square = x[:, None]**2 + x**2
    p = np.exp(-square / (2 * s * s))
    p *= 1 - (square / s**4 - 2 / s**2) / (24 * n * n)
    node, weight = np.polynomial.legendre.leggauss(200)
    q = (node + 1) * 4.5 / s
    factor = np.array([compliance(k, *pair) for k in q]) * q * weight * 4.5 / s * s * s * np.exp(
        -(q * s)**2 / 2)
    found = layered(package, pair, n, False).displacement(p)
    centre = n // 2
    for place in ((centre, centre), (centre, centre + 16), (centre, n - 1)):
        truth = (factor * j0(q * np.sqrt(square[place]))).sum()
        assert abs(found[place] - truth) < 3e-4 * found.max(), (place, found[place], truth)


@pytest.mark.parametrize("pair", [
    (0.5, 5.0, 0.3, 1.0, 0.4), (0.5, 1.0, 0.45, 0.0, 0.3), (0.1, 1.0, 0.2, 3.0, 0.3)])
def test_stress_on_free_maps_is_that_of_waves(package, pair):
    """A local pressure without a mean, on periodic and on free pixels: they differ by the pixel's
    own size and, with 1/r**3 and more, by periods far away."""
    n = 96
    thickness, shear, ratio, base, base_ratio = pair
    x = (np.arange(n) - n // 2) / 12
    x, y = np.meshgrid(x, x)
    p = np.exp(-2 * (x * x + y * y)) * (x * x - y * y + 0.5 * x)
    depths = thickness * np.array([0, 0.5, 1, 1 + 1e-12, 2])[:3 if base == 0 else 5]
    free, waves, bare = (package.HalfSpace(
        (n, n), 1 / 12, young(base, base_ratio) if layer else young(shear, ratio),
        base_ratio if layer else ratio, periodic=periodic,
        layer=(thickness, young(shear, ratio), ratio) if layer else None).stress(depths, p)
        for periodic, layer in ((False, True), (True, True), (False, False)))
    for name in ("xx", "yy", "zz", "xy", "xz", "yz"):
        for i in range(len(depths)):
            error = np.abs(free[name][i] - waves[name][i])[36:60, 36:60].max()
            assert error < 8e-3 * np.abs(waves["zz"][0]).max(), (name, i, error)
    assert np.abs(free["xx"] - bare["xx"]).max() > 0.05 * p.max()


@pytest.mark.parametrize("periodic", [False, True])
def test_limits(package, periodic):
    """Equal materials: the half-space. Thin: the base. Thick: the layer, but for a constant."""
    p = np.random.default_rng(0).random((N, N))

    def displacement(layer=None, modulus=1.0, ratio=0.3):
        return package.HalfSpace((N, N), 1 / N, modulus, ratio, periodic=periodic,
                                 layer=layer).displacement(p)

    base, surface = displacement(), displacement(modulus=5.0, ratio=0.2)
    unit = np.abs(base).max()
    assert np.abs(displacement((0.2, 1.0, 0.3)) - base).max() < 1e-12 * unit
    assert np.abs(displacement((1e-6, 5.0, 0.2)) - base).max() < 1e-4 * unit
    thick = displacement((1e4, 5.0, 0.2)) - surface
    assert np.abs(thick - thick.mean()).max() < 1e-10 * unit and abs(thick.mean()) < 1e-3 * unit


@pytest.mark.parametrize("thickness, ratio", [(0.1, 0.3), (0.01, 0.49), (1.0, 0.0)])
def test_rigid_base_of_contactmechanics(package, thickness, ratio):
    library = pytest.importorskip("ContactMechanics")
    p = np.random.default_rng(1).random((N, N))
    other = library.PeriodicFFTElasticHalfSpace((N, N), young=1.0, physical_sizes=(1.0, 1.0),
                                                thickness=thickness, poisson=ratio)
    truth = -other.evaluate_disp(p / (N * N))
    body = package.HalfSpace((N, N), 1 / N, 0.0, 0.3, periodic=True, layer=(thickness, 1.0, ratio))
    assert np.abs(np.abs(body.displacement(p.T).T) - np.abs(truth)).max() < 1e-12 * np.abs(
        truth).max()


def scene(package, material=None, edge="periodic", load=0.01, **groups):
    h = 0.01 * np.random.default_rng(2).random((N, N))
    return {"surfaces": {"upper": "plane", "lower": package.HeightMap(h, 1 / N), "map_edge": edge},
            "material": {"elastic_modulus": (1e6, 1.0), "poisson_ratio": (0.3, 0.3),
                         **(material or {})},
            "loading": {"control": "load", "value": load}, **groups}


LAYER = {"layer_thickness": (0.0, 0.1), "layer_modulus": (0.0, 1.0), "layer_poisson": (0.0, 0.3)}


@pytest.mark.parametrize("edge", ["periodic", "free"])
def test_scene_is_the_body_of_its_pressures(package, edge):
    """Displacements, stiffness by a larger load, and equal materials of a solved scene."""
    material = {**LAYER, "layer_modulus": (0.0, 5.0)}
    results = package.solve(scene(package, material, edge), fields=True)
    fields = results.fields()
    both = [package.HalfSpace((N, N), 1 / N, modulus, 0.3, periodic=edge == "periodic",
                              layer=layer).displacement(fields.pressure)
            for modulus, layer in ((1.0, (0.1, 5.0, 0.3)), (1e6, None))]
    assert np.allclose(sum(both), fields.displacement, rtol=1e-9, atol=1e-12)
    more = package.solve(scene(package, material, edge, 0.01 * (1 + 1e-4)))
    slope = 1e-6 / (more.states["compression"][-1] - results.states["compression"][-1])
    assert results.positions["contact_stiffness"][-1] == pytest.approx(slope, rel=1e-3)
    alike = package.solve(scene(package, LAYER, edge))
    bare = package.solve(scene(package, None, edge))
    for name in ("area", "compression", "mean_gap", "nominal_pressure"):
        assert alike.states[name][-1] == pytest.approx(bare.states[name][-1], rel=1e-9)
    # The stiffness is solved to 1e-5.
    assert alike.positions["conductance_length"] == pytest.approx(
        bare.positions["conductance_length"], rel=1e-5)


def test_full_contact_on_a_rigid_base(package):
    """The stiffness of a confined layer, (1 - nu) E/((1 + nu) (1 - 2 nu)) over its thickness."""
    results = package.solve(scene(package, {**LAYER, "elastic_modulus": (1e12, 0.0)}, load=1.0))
    assert results.states["area"][-1] == 1.0 and results.states["separation"][-1] < 0
    assert results.positions["contact_stiffness"][-1] == pytest.approx(
        0.7 / (1.3 * 0.4) / 0.1, rel=1e-9)


def test_stress_of_a_scene(package):
    results = package.solve(scene(package, {**LAYER, "layer_modulus": (0.0, 5.0)}), fields=True)
    depths = [0.0, 0.1, 0.2]
    body = package.HalfSpace((N, N), 1 / N, 1.0, 0.3, periodic=True, layer=(0.1, 5.0, 0.3))
    found, truth = results.stress(depths), body.stress(depths, results.fields().pressure)
    for name, values in truth.items():
        assert np.array_equal(found[name], values)


@pytest.mark.parametrize("material, groups, text", [
    ({"layer_thickness": (0, 0.1)}, {}, "needs layer_modulus: found none, expected that of each"),
    ({**LAYER, "layer_modulus": (0, 0)}, {}, "layer_modulus: found 0 of a layer, expected"),
    ({"layer_modulus": (0, 1)}, {}, "layer_modulus: found without layer_thickness"),
    ({**LAYER, "elastic_modulus": (0, 1)}, {}, "found 0 of a body without a layer, expected"),
    (LAYER, {"effects": {"friction_coefficient": 0.3}}, "found beside friction, which is not"),
    (LAYER, {"effects": {"creep": True, "relaxation_time": 1.0, "relaxed_modulus_ratio": 0.5,
                         "hold_time": 1.0}}, "found beside creep, which is not solved on layers"),
    ({**LAYER, "thermal_conductivity": (1.0, 1.0)}, {}, "found beside conductivities, which a"),
    (LAYER, {"edge": ("periodic", "free")}, "found beside a map that is periodic along one axis")])
def test_refusals(package, material, groups, text):
    with pytest.raises(package.InputError, match=text):
        package.solve(scene(package, material, **groups))


def test_layers_need_pixels(package):
    ball = {"x": [0.0], "y": [0.0], "height": [1.0], "radius": 2.0}
    with pytest.raises(package.InputError, match="solved on pixels: found no map, expected one"):
        package.solve({**scene(package, LAYER), "surfaces": {"upper": ball, "lower": "plane"}})
