"""Theories of the Python package: against printed and closed values, mpmath, another program, and
the solver."""

import math

import mpmath
import numpy as np
import pytest

pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]

MODULUS = 1.0e3


@pytest.fixture(scope="module")
def theory(package):
    return package.theory


def test_height_integrals(theory):
    """Printed by Greenwood and Tripp (1970-71) for h = 0; 50 digits of mpmath elsewhere."""
    for order, printed in ((1.0, 0.3989), (1.5, 0.4300), (2.0, 0.5), (2.5, 0.6166)):
        assert round(float(theory.height_integral(order, 0.0)), 4) == printed
    with mpmath.workdps(50):
        for order in (0.0, 0.5, 1.0, 1.5, 2.0, 2.5):
            for h in (-200.0, -50.5, -49.0, -7.0, -1.0, 0.3, 2.0, 5.0, 9.0, 25.0):
                density = mpmath.exp(-mpmath.mpf(h)**2 / 4) * mpmath.pcfd(-order - 1, h)
                exact = mpmath.gamma(order + 1) / mpmath.sqrt(2 * mpmath.pi) * density
                assert float(theory.height_integral(order, h) / exact) == pytest.approx(1, abs=2e-9)
            for h in (-3.0, -1.0, 0.0, 4.0):
                exact = mpmath.quad(lambda s: (s - h)**order * mpmath.exp(-s - 1),
                                    [max(h, -1.0), max(h, -1.0) + 2, mpmath.inf])
                found = theory.height_integral(order, h, "exponential")
                assert float(found) == pytest.approx(float(exact), rel=1e-9)


def test_greenwood_williamson_of_exponential_heights(theory):
    """Greenwood and Williamson (1966): the load over the contact area is E* sqrt(s/(pi R))."""
    summits = theory.SummitStatistics(density=30.0, radius=0.7, mean=0.2, deviation=0.01)
    found = theory.greenwood_williamson(summits, MODULUS, heights="exponential",
                                        separation=[0.2, 0.22, 0.25])
    expected = MODULUS * math.sqrt(0.01 / (math.pi * 0.7))
    assert found["pressure"] / found["area_fraction"] == pytest.approx([expected] * 3, rel=1e-12)


@pytest.mark.parametrize("heights", ["gaussian", "exponential"])
def test_greenwood_williamson_inverse_and_stiffness(theory, heights):
    summits = theory.SummitStatistics(density=30.0, radius=0.7, mean=0.2, deviation=0.01)
    places = np.array([0.17, 0.2, 0.23])

    def found(**given):
        return theory.greenwood_williamson(summits, MODULUS, heights=heights, **given)

    there = found(separation=places)
    assert found(pressure=there["pressure"])["separation"] == pytest.approx(places, rel=1e-8)
    step = 1e-6
    slope = (found(separation=places - step)["pressure"]
             - found(separation=places + step)["pressure"]) / (2 * step)
    assert there["stiffness"] == pytest.approx(slope, rel=1e-6)


def test_greenwood_williamson_beside_solved_caps(package, theory):
    """20,000 caps at the middles of equal shares of a normal distribution, without interaction."""
    number, deviation, mean, radius = 20000, 0.01, 0.1, 0.7
    from scipy.special import ndtri
    places = np.arange(number)
    table = {"x": places % 200, "y": places // 200, "radius": radius,
             "height": mean + deviation * ndtri((places + 0.5) / number)}
    separations = mean + deviation * np.array([0.5, 1.0, 1.5])
    summits = theory.SummitStatistics(1.0, radius, mean, deviation)
    expected = theory.greenwood_williamson(summits, MODULUS, separation=separations)
    for place, p, area in zip(separations, expected["pressure"], expected["area_fraction"]):
        state = package.solve({
            "surfaces": {"upper": "plane", "lower": table},
            "material": {"contact_modulus": MODULUS}, "effects": {"interaction": "off"},
            "loading": {"control": "separation", "value": place}}, contacts=False).positions
        assert float(state["load"][0]) / number == pytest.approx(p, rel=1e-3)
        assert float(state["area"][0]) / number == pytest.approx(area, rel=1e-3)
    spread = theory.summit_statistics({**table, "radius": np.full(number, radius)}, area=number)
    assert spread == pytest.approx(summits, rel=1e-4)


def test_greenwood_tripp_as_printed(theory):
    """The formulas of the paper for equal surfaces; the plastic area is twice the elastic one."""
    one = theory.SummitStatistics(density=40.0, radius=0.5, mean=0.1, deviation=0.01)
    sigma = 0.01 * math.sqrt(2.0)
    h, k = np.array([0.0, 1.5]), 40.0 * 0.5 * sigma
    found = theory.greenwood_tripp(one, one, MODULUS, separation=0.2 + h * sigma)
    area = math.pi**2 * k**2 * theory.height_integral(2.0, h)
    pressure = (16 * math.sqrt(2) / 15 * math.pi * k**2 * MODULUS * math.sqrt(sigma / 0.5)
                * theory.height_integral(2.5, h))
    assert found["pressure"] == pytest.approx(pressure, rel=1e-12)
    assert found["area_fraction"] == pytest.approx(area, rel=1e-12)
    plastic = theory.greenwood_tripp_plastic(one, one, 50.0, separation=found["separation"])
    assert plastic["area_fraction"] == pytest.approx(2.0 * area, rel=1e-12)
    assert plastic["pressure"] == pytest.approx(50.0 * plastic["area_fraction"], rel=1e-12)


def test_greenwood_tripp_of_unequal_surfaces(theory):
    """Pairs of paraboloids at all offsets, summed by Gauss's rule over heights and offsets."""
    upper = theory.SummitStatistics(density=40.0, radius=0.5, mean=0.1, deviation=0.01)
    lower = theory.SummitStatistics(density=15.0, radius=1.5, mean=0.05, deviation=0.02)
    separation, sigma = 0.17, math.hypot(0.01, 0.02)
    nodes, weights = np.polynomial.legendre.leggauss(60)
    t = (nodes + 1) / 2 * 12 * sigma
    share = weights * 6 * sigma * np.exp(-((t + separation - 0.15) / sigma)**2 / 2) / (
        math.sqrt(2 * math.pi) * sigma)
    total, radius = 2.0, 0.5 * 1.5 / 2.0
    s = (nodes + 1) / 2  # offset over the largest one
    offset = s * np.sqrt(2 * total * t)[:, None]
    ring = 2 * math.pi * offset * weights / 2 * np.sqrt(2 * total * t)[:, None] * 40.0 * 15.0
    overlap = t[:, None] - offset**2 / (2 * total)
    found = theory.greenwood_tripp(upper, lower, MODULUS, separation=separation)
    laws = {"contact_density": overlap**0, "area_fraction": math.pi * radius * overlap,
            "pressure": 4 / 3 * MODULUS * math.sqrt(radius) * overlap**1.5}
    for name, law in laws.items():
        expected = (share * (ring * law).sum(axis=1)).sum()
        assert found[name][0] == pytest.approx(expected, rel=1e-5), name
    step = 1e-6
    ends = theory.greenwood_tripp(upper, lower, MODULUS,
                                  separation=[separation - step, separation + step])["pressure"]
    assert found["stiffness"][0] == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-6)


# A plane of asperities in units of the deviation, and a ball.
PLANE, BALL = (0.05, 1.0, 0.0, 1.0), 1.0e3


def test_ball_of_hertz(theory):
    """A small deviation with many asperities: the pressure and the radius of Hertz, which differ by
    less than the roughness to the power 2/3; a contact area below that of Hertz."""
    plane = theory.SummitStatistics(1e7, 1e-4, 0.0, 1e-3)
    found = theory.greenwood_tripp_ball(plane, MODULUS, 10.0, 100.0)
    hertz = (0.75 * 100 * 10 / MODULUS)**(1 / 3)
    assert found["roughness"][0] == pytest.approx(1e-3 * 10 / hertz**2)
    share = found["roughness"][0]**(2 / 3)
    assert found["pressure_ratio"][0] == pytest.approx(1.0, abs=share)
    assert found["area_ratio"][0] == pytest.approx(1.0, abs=share)
    assert found["area"][0] < math.pi * hertz**2


def test_ball_at_small_loads(theory):
    """The thesis on Greenwood and Tripp (1967): at small loads about ten times the area of Hertz;
    the greatest pressure is down to a third of his before that."""
    loads = np.geomspace(0.1, 1e3, 9)
    found = theory.greenwood_tripp_ball(theory.SummitStatistics(*PLANE), 1.0, BALL, loads)
    assert (np.diff(found["area_ratio"]) < 0).all() and (np.diff(found["pressure_ratio"]) > 0).all()
    at_third = np.interp(1 / 3, found["pressure_ratio"], found["area_ratio"])
    at_ten = np.interp(-10, -found["area_ratio"], found["pressure_ratio"])
    assert 3 < at_third < 4 and 0.08 < at_ten < 0.15
    with pytest.raises(ValueError, match="more than 0"):
        theory.greenwood_tripp_ball(theory.SummitStatistics(*PLANE), 1.0, BALL, 0.0)


def test_displacement_of_a_pressure(theory):
    """p = (1 - r^2)^(3/2) has G = (3 pi/16) (1 - x^2)^2: u = (3 pi/16) (1 - r^2 + (3/8) r^4)."""
    r, weights, matrix = theory._disc()
    expected = 3 * math.pi / 16 * (1 - r**2 + 3 / 8 * r**4)
    assert matrix @ (1 - r**2)**1.5 == pytest.approx(expected, rel=1e-5)
    assert weights @ r**3 == pytest.approx(0.25, rel=1e-9)


def test_ball_converges(theory, monkeypatch):
    """Twice as many nodes and points, and a wider disc, change no column by more than 1e-4."""
    loads = [1e-2, 1.0, 1e2, 4e4]
    plane = theory.SummitStatistics(*PLANE)
    coarse = theory.greenwood_tripp_ball(plane, 1.0, BALL, loads)
    for name in ("NODES", "ANGLES", "ALONG"):
        monkeypatch.setattr(theory, name, 2 * getattr(theory, name))
    monkeypatch.setattr(theory, "LEFT", 1e-13)
    theory._disc.cache_clear()
    fine = theory.greenwood_tripp_ball(plane, 1.0, BALL, loads)
    theory._disc.cache_clear()
    for name in fine:
        assert coarse[name] == pytest.approx(fine[name], rel=1e-4), name


@pytest.mark.truth
def test_ball_is_that_of_another_program(theory):
    """ContactMechanics solves the same equations by relaxation on linear pieces."""
    from ContactMechanics.ReferenceSolutions.GreenwoodTripp import GreenwoodTripp
    density, radius, _, deviation = PLANE
    mu = 8 / 3 * density * deviation * math.sqrt(2 * BALL * radius)
    _, p, rho = GreenwoodTripp(1.0, mu, rhomax=5, n=200, mix=0.2, maxiter=5000)
    length, unit = math.sqrt(2 * BALL * deviation), math.sqrt(deviation / (8 * BALL))
    load = np.trapezoid(2 * math.pi * rho * p, rho) * unit * length**2
    found = theory.greenwood_tripp_ball(theory.SummitStatistics(*PLANE), 1.0, BALL, load)
    effective = 0.75 * math.pi * np.trapezoid(rho * p, rho) / np.trapezoid(p, rho) * length
    assert found["pressure"][0] == pytest.approx(p[0] * unit, rel=1e-3)
    assert found["effective_radius"][0] == pytest.approx(effective, rel=1e-3)


def test_moments_of_a_cosine(package, theory):
    """a cos(q x) has the mean squares a^2/2, q^2 a^2/2, q^4 a^2/2, half of them on the average of
    the directions. Differences give 4 sin^2(q d/2)/d^2 in place of q^2."""
    a, q, d = 0.3, 2 * math.pi / 8.0, 0.5
    row = a * np.cos(q * d * np.arange(64))
    whole = theory.moments(package.HeightMap(np.tile(row, (32, 1)), d, periodic=True))
    assert whole == pytest.approx((a**2 / 2, q**2 * a**2 / 4, q**4 * a**2 / 4), rel=1e-12)
    turned = theory.moments(package.HeightMap(np.tile(row[:, None], (1, 32)), d, periodic=True))
    assert turned == pytest.approx(whole, rel=1e-12)
    strip = theory.moments(package.HeightMap.profile(row, d, periodic=True))
    assert strip == pytest.approx((a**2 / 2, q**2 * a**2 / 2, q**4 * a**2 / 2), rel=1e-12)
    free = theory.moments(package.HeightMap.profile(row, d))
    assert free.m2 == pytest.approx(a**2 / 2 * (2 * math.sin(q * d / 2) / d)**2, rel=0.02)
    assert whole.rms_slope == pytest.approx(a * q / math.sqrt(2), rel=1e-12)


def test_expected_summits(package, theory):
    """Statistics of the summits that `asperity summits` prints as expected of the same moments."""
    rough = package.generate_map(pixels=64, spacing=1, hurst=0.8, rms_height=1, cut_off=8,
                                 periodic=False)
    expected = package.summits(rough).statistics
    found = theory.summit_statistics(rough)
    assert found == pytest.approx((expected["expected_density"], 1 / expected["expected_curvature"],
                                   expected["expected_height"], expected["expected_deviation"]))
    summits = package.summits(rough)
    own = theory.summit_statistics(summits)
    assert own.density == summits.statistics["density"]
    assert own.deviation == pytest.approx(float(np.std(summits["height"])))


def test_area_of_persson_and_of_bush(package, theory):
    """Hyun and others (2004): sqrt(8/pi) = 1.596 and sqrt(2 pi) = 2.507 at small pressures."""
    surface = theory.Moments(m0=1.0, m2=0.02, m4=0.01)
    p = 1e-6 * MODULUS * surface.rms_slope
    assert theory.persson(surface, MODULUS, p) / 1e-6 == pytest.approx(1.596, abs=5e-4)
    assert theory.bush_gibson_thomas(surface, MODULUS, p) / 1e-6 == pytest.approx(2.507, abs=5e-4)
    assert theory.persson(surface, MODULUS, 5 * MODULUS * surface.rms_slope) == 1.0
    nominal = 0.1 * MODULUS * surface.rms_slope
    at = np.linspace(0.0, 5.0 * MODULUS * surface.rms_slope, 20001)
    density = theory.persson_pressures(surface, MODULUS, nominal, at)
    assert np.trapezoid(density, at) == pytest.approx(
        float(theory.persson(surface, MODULUS, nominal)), rel=1e-6)
    assert np.trapezoid(at * density, at) == pytest.approx(nominal, rel=1e-6)
    assert theory.akarapu(surface, [0.48]).tolist() == [1.0]


@pytest.mark.truth
def test_solver_between_persson_and_bush(package, theory):
    """512 x 512 pixels, eight in the shortest wave: the solver is above Persson, and at area
    fractions below a tenth below Bush, Gibson and Thomas."""
    rough = package.generate_map(pixels=512, spacing=1, hurst=0.8, roll_off=128, cut_off=8,
                                 rms_slope=0.1)
    surface = theory.moments(rough)
    scale = MODULUS * surface.rms_slope
    states = package.solve({"surfaces": {"upper": "plane", "lower": rough},
                            "material": {"contact_modulus": MODULUS},
                            "loading": {"control": "pressure", "value": 0.04 * scale, "points": 4}},
                           contacts=False).states
    pressures, areas = states["nominal_pressure"][1:], states["area_fraction"][1:]
    assert (areas > theory.persson(surface, MODULUS, pressures)).all()
    assert (areas < theory.bush_gibson_thomas(surface, MODULUS, pressures)).all()
    assert areas[-1] < 0.1


def test_criteria_of_the_thesis(theory):
    """The relations of sections II.D.1 and II.D.3, solved for their left sides."""
    hardness = theory.blok(0.02, 0.5, MODULUS)
    assert 0.02 / (2 * 0.5) == pytest.approx(hardness / (math.pi * MODULUS))
    young, ratio = 2.1e5, 0.3
    alike = 0.5 * young / (1 - ratio**2)
    hardness = theory.halliday(0.1, alike)
    assert 0.1 == pytest.approx(0.84 * hardness / young * (1 - ratio**2))
    assert theory.bowden_tabor([10.0, 20.0], 5.0).tolist() == [2.0, 4.0]
    # W_p = B (H/E)^2 is the deviation at which the index is 1.
    summits = theory.SummitStatistics(1.0, 0.5, 0.0, 0.5 * (50.0 / MODULUS)**2)
    index = theory.plasticity_index(summits, MODULUS, 50.0)
    assert index == pytest.approx(1.0)


def test_refusals(theory):
    summits = theory.SummitStatistics(30.0, 0.7, 0.2, 0.01)
    for given in ({}, {"separation": 0.2, "pressure": 1.0}):
        with pytest.raises(ValueError, match="one of them"):
            theory.greenwood_williamson(summits, MODULUS, **given)
    with pytest.raises(ValueError, match="'gaussian' or 'exponential'"):
        theory.height_integral(1.0, 0.0, "uniform")
    for pressure in (-1.0, math.nan):
        with pytest.raises(ValueError, match="pressure"):
            theory.greenwood_williamson(summits, MODULUS, pressure=pressure)
