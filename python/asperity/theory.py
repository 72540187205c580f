"""Theories of rough contact, to be compared with a solve.

Any consistent units. Pressures and loads may be arrays; the results are arrays of the same shape.
`contact_modulus` is E* with 1/E* = (1 - nu1**2)/E1 + (1 - nu2**2)/E2. Heights are normally
distributed unless stated otherwise. The module needs numpy and scipy (extra `theory`).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

from . import _arguments as _a
from ._columns import Lazy, Table
from ._errors import ComputeError
from ._maps import HeightMap

__all__ = ["Moments", "SummitStatistics", "moments", "summit_statistics", "persson",
           "persson_pressures", "bush_gibson_thomas", "akarapu", "height_integral",
           "greenwood_williamson", "greenwood_tripp", "greenwood_tripp_plastic",
           "greenwood_tripp_ball", "plasticity_index", "bowden_tabor", "blok", "halliday"]

np: Any = Lazy("numpy", "theory", "a theory")
special, optimize, interpolate = (Lazy(f"scipy.{name}", "theory", "a theory")
                                  for name in ("special", "optimize", "interpolate"))
# Theories of the contact area that `Results.plot` draws by name.
AREA_THEORIES = ("persson", "bush_gibson_thomas", "greenwood_williamson")
# Separations between which a pressure is inverted, in deviations of the summit heights. The
# parabolic cylinder function overflows below.
LOWEST, HIGHEST = -50.0, 30.0
# Nodes of the splines, and points of the rules between 0 and pi/2 and along a half-line.
# Twice as many change the results by less than 1e-4 (`test_ball_converges`).
NODES, ANGLES, ALONG = 120, 32, 200
# Relative error of the displacements, and the load whose logarithm is taken where none is left.
CLOSED, LEAST = 1e-9, 1e-300
# Pressure at the end of the disc over that in the centre, at most; otherwise the disc grows.
LEFT, GROWTH = 1e-9, 1.25


class Moments(NamedTuple):
    """Spectral moments of a surface: mean squares of height, slope and curvature of its profiles,
    means over the directions."""

    m0: float
    m2: float
    m4: float

    @property
    def rms_height(self) -> float:
        return math.sqrt(self.m0)

    @property
    def rms_slope(self) -> float:
        """Root mean square of the gradient, sqrt(2 m2)."""
        return math.sqrt(2.0 * self.m2)

    @property
    def alpha(self) -> float:
        """Nayak's m0 m4/m2**2."""
        return self.m0 * self.m4 / self.m2**2


class SummitStatistics(NamedTuple):
    """Statistics of the asperities of a surface."""

    density: float    #: number over the nominal area
    radius: float     #: of the spherical caps
    mean: float       #: height above the reference plane
    deviation: float  #: standard deviation of the heights


def moments(surface: Any, spacing: Any = None) -> Moments:
    """Spectral moments of a height map.

    A periodic map: by its waves, m2 = <q_x**2 |h|**2>. A free map, or an array with its `spacing`:
    by the differences of `asperity.summits` about its plane, which underestimate slopes. A profile:
    of its one direction. Moments are returned as they are.

    P. R. Nayak, J. Lubr. Technol. 93 (1971) 398. Checked on the closed moments of a cosine.
    """
    if isinstance(surface, Moments):
        return surface
    if not isinstance(surface, HeightMap):
        surface = HeightMap(surface, spacing)
    directions = 1 if surface.is_profile else 2
    if not surface.periodic:
        from ._calls import summits
        found = summits(surface).statistics
        return Moments(found["m0"], *((found[f"{name}_x"] + (directions - 1) * found[f"{name}_y"])
                                      / directions for name in ("m2", "m4")))
    heights = surface.heights - surface.heights.mean()
    power = np.abs(np.fft.fft2(heights))**2 / heights.size**2
    q_y, q_x = (2.0 * np.pi * np.fft.fftfreq(number, step)
                for number, step in zip(surface.shape, surface.spacing[::-1]))
    return Moments(*(float((power * (q_x**order + q_y[:, None]**order)).sum() / share)
                     for order, share in ((0, 2), (2, directions), (4, directions))))


def summit_statistics(surface: Any, area: float | None = None) -> SummitStatistics:
    """Density, radius and heights of the asperities of a surface.

    `surface` is a table of summits or asperities; of a map or moments the expected summits of an
    isotropic Gaussian surface are returned (A. W. Bush, R. D. Gibson, G. P. Keogh, Mech. Res.
    Commun. 3 (1976) 169; J. I. McCool, Wear 107 (1986) 37), checked on `asperity.summits`. The
    nominal `area` of a table is the rectangle of the extreme places unless given.
    """
    if isinstance(surface, SummitStatistics):
        return surface
    if _a.columns_of(surface) is None:
        of = moments(surface)
        return SummitStatistics(of.m4 / (6.0 * math.pi * math.sqrt(3.0) * of.m2),
                                0.375 * math.sqrt(math.pi / of.m4),
                                4.0 * math.sqrt(of.m0 / (math.pi * of.alpha)),
                                math.sqrt((1.0 - 0.8968 / of.alpha) * of.m0))
    x, y, height, radius = (np.asarray(surface[name], dtype=float) for name in _a.COLUMNS)
    density = getattr(surface, "statistics", {}).get("density")
    if area is not None or density is None:
        density = x.size / (np.ptp(x) * np.ptp(y) if area is None else area)
    return SummitStatistics(float(density), float(radius.mean()), float(height.mean()),
                            float(height.std()))


def persson(surface: Any, contact_modulus: float, pressure: Any) -> Any:
    """Contact area over nominal area, erf(sqrt(2) p/(E* h')) with the rms slope h' of a HeightMap
    or of Moments and the nominal pressure p, by Persson.

    B. N. J. Persson, J. Chem. Phys. 115 (2001) 3840. All pressures; below solved maps at small
    ones. Checked on the factor 1.596 there (S. Hyun et al., Phys. Rev. E 70 (2004) 026117).
    """
    ratio = _ratio(surface, contact_modulus, pressure)
    return special.erf(math.sqrt(2.0) * ratio)


def persson_pressures(surface: Any, contact_modulus: float, pressure: float, at: Any) -> Any:
    """Probability density of the local pressures `at` in contact, by Persson.

    As `persson`: the difference of the normal distributions about p and -p of the variance
    (E* h')**2/4. Checked: its integral is the area of `persson`, its first moment p.
    """
    variance = (contact_modulus * moments(surface).rms_slope)**2 / 4.0
    local = np.asarray(at, dtype=float)
    return (np.exp(-(local - pressure)**2 / (2.0 * variance))
            - np.exp(-(local + pressure)**2 / (2.0 * variance))) / math.sqrt(2 * math.pi * variance)


def bush_gibson_thomas(surface: Any, contact_modulus: float, pressure: Any) -> Any:
    """Contact area over nominal area, sqrt(2 pi) p/(E* h'), by Bush, Gibson and Thomas.

    A. W. Bush, R. D. Gibson, T. R. Thomas, Wear 35 (1975) 87, in the limit of small pressures: area
    fractions of a few per mille. Checked on the factor 2.507 of Hyun et al. (2004).
    """
    return math.sqrt(2.0 * math.pi) * _ratio(surface, contact_modulus, pressure)


def akarapu(surface: Any, pressure: Any, factor: float = 0.48) -> Any:
    """Normal contact stiffness over nominal area, p/(0.48 rms height), by Akarapu and others.

    S. Akarapu, T. Sharp, M. O. Robbins, Phys. Rev. Lett. 106 (2011) 204301, which has the factor of
    solved self-affine surfaces; area fractions of about 1 to 10 %.
    """
    return np.asarray(pressure, dtype=float) / (factor * moments(surface).rms_height)


def height_integral(order: float, separation: Any, heights: str = "gaussian") -> Any:
    """F_n(h), the mean of (s - h)**n over the heights s above h.

    The `order` n is 0 or more; the `separation` h is counted from the mean of the heights in units
    of their deviation. `heights` are `gaussian`, or `exponential` with a beginning at -1.

    n!/sqrt(2 pi) exp(-h**2/4) D_(-n-1)(h), relative error below 2e-9 up to h = 30. Checked on
    F_1(0) = 0.3989, F_3/2(0) = 0.4300, F_2(0) = 0.5, F_5/2(0) = 0.6166 of J. A. Greenwood,
    J. H. Tripp, Proc. Inst. Mech. Engrs 185 (1970-71) 625.
    """
    h = np.asarray(separation, dtype=float)
    if heights == "exponential":
        # Below the lowest height the integral begins there: an incomplete gamma function.
        return math.gamma(order + 1.0) * np.exp(-h - 1.0) * special.gammaincc(
            order + 1.0, np.maximum(0.0, -h - 1.0))
    if heights != "gaussian":
        raise _a.wrong("heights", repr(heights), "'gaussian' or 'exponential'")
    near, far = np.maximum(h, LOWEST), np.minimum(h, LOWEST)
    found = (math.gamma(order + 1.0) / math.sqrt(2.0 * math.pi) * np.exp(-near**2 / 4.0)
             * special.pbdv(-order - 1.0, near)[0])
    # The mean of the binomial series, whose next term is less than 1e-9 of it.
    series = 1.0 + special.binom(order, 2) / far**2 + 3.0 * special.binom(order, 4) / far**4
    return np.where(h < LOWEST, np.abs(far)**order * series, found)


def greenwood_williamson(summits: Any, contact_modulus: float, *, separation: Any = None,
                         pressure: Any = None, heights: str = "gaussian") -> Table:
    """A rough surface against a smooth plane, by Greenwood and Williamson.

    `summits` are as for `summit_statistics`, with `gaussian` or `exponential` heights. One of two
    is given: the separation of the reference planes or the nominal pressure. The table has both,
    `area_fraction`, and over the nominal area `contact_density` and `stiffness`.

    J. A. Greenwood, J. B. P. Williamson, Proc. R. Soc. Lond. A 295 (1966) 300: isolated Hertzian
    contacts of equal radius, area fractions of a few per cent. Checked on their load over contact
    area of exponential heights, E* sqrt(deviation/(pi radius)), and on solved caps.
    """
    of = summit_statistics(summits)
    depth = math.sqrt(of.radius * of.deviation)
    factors = {"pressure": (1.5, contact_modulus * of.density * depth * of.deviation * 4.0 / 3.0),
               "area_fraction": (1.0, math.pi * of.density * depth**2),
               "contact_density": (0.0, of.density),
               "stiffness": (0.5, 2.0 * contact_modulus * of.density * depth)}
    return _table(factors, of.mean, of.deviation, separation, pressure, heights)


def greenwood_tripp(upper: Any, lower: Any, contact_modulus: float, *, separation: Any = None,
                    pressure: Any = None) -> Table:
    """Two rough surfaces with elastic asperities, by Greenwood and Tripp.

    `upper` and `lower` as for `summit_statistics`, the rest as for `greenwood_williamson`.

    J. A. Greenwood, J. H. Tripp, Proc. Inst. Mech. Engrs 185 (1970-71) 625: paraboloids that meet
    at any offset, small penetrations. Checked on the formulas of the paper for equal surfaces,
    (16 sqrt(2)/15) pi (eta beta sigma)**2 E* sqrt(sigma/beta) F_5/2(h) and
    pi**2 (eta beta sigma)**2 F_2(h), and on sums over pairs of unequal ones.
    """
    factors, mean, deviation = _pair_factors(upper, lower)
    _, load = factors["pressure"]
    factors["pressure"] = 2.5, contact_modulus * load
    factors["stiffness"] = 1.5, 2.5 * contact_modulus * load / deviation
    return _table(factors, mean, deviation, separation, pressure)


def greenwood_tripp_plastic(upper: Any, lower: Any, hardness: float, *, separation: Any = None,
                            pressure: Any = None) -> Table:
    """Two rough surfaces with plastic asperities, by Greenwood and Tripp.

    `hardness` is the mean pressure of a plastic contact, the rest is as for `greenwood_tripp`.

    Source as for `greenwood_tripp`. A plastic contact has the area of the geometric intersection,
    twice the Hertzian one, and the load is the hardness times it. The thesis (section II.D.1)
    prints this load, 2 pi**2 (eta beta sigma)**2 H F_2(h), beside the elastic area, half of it.
    """
    factors, mean, deviation = _pair_factors(upper, lower)
    order, area = factors["area_fraction"]
    factors["area_fraction"] = order, 2.0 * area
    factors["pressure"] = order, 2.0 * area * hardness
    return _table(factors, mean, deviation, separation, pressure)


def greenwood_tripp_ball(summits: Any, contact_modulus: float, ball_radius: float,
                         load: Any) -> Table:
    """A smooth ball on a rough plane, by Greenwood and Tripp.

    `summits` of the plane as for `summit_statistics`; loads are more than 0. The table has `load`;
    `roughness`: deviation times ball radius over the square of the contact radius of Hertz;
    `pressure`: nominal, in the centre, and `pressure_ratio`: over that of Hertz;
    `effective_radius`: 3 pi/4 times the integral of r p over that of p; `area_ratio`: its square
    over that of Hertz; `area` and `contacts` of the asperities.

    J. A. Greenwood, J. H. Tripp, J. Appl. Mech. 34 (1967) 153: asperities of Greenwood and
    Williamson on a half-space. Error below 1e-4 for a roughness from 0.01, 3e-3 at 0.001. Checked
    on the limit of Hertz, on the thesis' "ten times the area" and "a third of the pressure" at
    small loads, and on ContactMechanics 1.8 to 1e-3.
    """
    of, modulus = summit_statistics(summits), contact_modulus
    loads = np.atleast_1d(np.asarray(load, dtype=float))
    if not (loads > 0.0).all():
        raise _a.wrong("load", _a.shown(load), "more than 0")
    length = math.sqrt(2.0 * ball_radius * of.deviation)
    unit = modulus * math.sqrt(of.deviation / (8.0 * ball_radius))
    mu = 8.0 / 3.0 * of.density * of.deviation * math.sqrt(2.0 * ball_radius * of.radius)
    rows = []
    for one in loads:
        hertz = (0.75 * one * ball_radius / modulus)**(1.0 / 3.0)
        r, h, weights = _gap(mu, one / (unit * length**2), hertz / length)
        p = mu * height_integral(1.5, h)
        effective = 0.75 * math.pi * (weights @ (r * p)) / (weights @ p) * length
        peak = 1.5 * one / (math.pi * hertz**2)
        contacts = of.density * length**2 * np.array(
            [weights @ (2.0 * math.pi * r * height_integral(n, h)) for n in (0.0, 1.0)])
        rows.append((one, of.deviation * ball_radius / hertz**2, unit * p[0], unit * p[0] / peak,
                     effective, (effective / hertz)**2,
                     math.pi * of.radius * of.deviation * contacts[1], contacts[0]))
    names = ("load", "roughness", "pressure", "pressure_ratio", "effective_radius", "area_ratio",
             "area", "contacts")
    return Table(dict(zip(names, np.array(rows).T)), name="loads")


def plasticity_index(summits: Any, contact_modulus: float, hardness: float) -> float:
    """E*/H sqrt(deviation/radius): below 0.6 contacts are elastic, above 1 plastic.

    J. A. Greenwood, J. B. P. Williamson, Proc. R. Soc. Lond. A 295 (1966) 300.
    """
    of = summit_statistics(summits)
    return contact_modulus / hardness * math.sqrt(of.deviation / of.radius)


def bowden_tabor(load: Any, hardness: float) -> Any:
    """Area of plastic contacts, load over yield pressure (thesis, section II.D.1)."""
    return np.asarray(load, dtype=float) / hardness


def blok(height: float, distance: float, contact_modulus: float) -> float:
    """Smallest hardness at which sinusoidal asperities stay elastic, pi E* height/(2 distance):
    height from peak to valley, distance from peak to peak (thesis, section II.D.3)."""
    return math.pi * contact_modulus * height / (2.0 * distance)


def halliday(slope: float, contact_modulus: float) -> float:
    """Smallest hardness at which spherical caps stay elastic, slope E/(0.84 (1 - nu**2)), with the
    slope at their rims and two bodies of one material, whose E/(1 - nu**2) is 2 E* (thesis, section
    II.D.3)."""
    return 2.0 * contact_modulus * slope / 0.84


def area_fraction(name: str, surface: Any, contact_modulus: float, pressure: Any) -> Any:
    """Contact area over nominal area by one of `AREA_THEORIES`."""
    found = globals()[name](surface, contact_modulus, pressure=pressure)
    return found["area_fraction"] if isinstance(found, Table) else found


def _ratio(surface: Any, contact_modulus: float, pressure: Any) -> Any:
    """Nominal pressure over E* times the rms slope."""
    return np.asarray(pressure, dtype=float) / (contact_modulus * moments(surface).rms_slope)


def _pair_factors(upper: Any, lower: Any) -> tuple[dict[str, tuple[float, float]], float, float]:
    """Orders and factors of the height integrals of two surfaces; mean and deviation of the sum of
    their heights. With s the sum of the radii and R = r1 r2/s, the integrals over the offset of a
    pair at the overlap t are 2 pi s t contacts, the area pi**2 R s t**2, and E* times the load
    (16/15) pi sqrt(R) s t**(5/2)."""
    one, two = summit_statistics(upper), summit_statistics(lower)
    total = one.radius + two.radius
    radius = one.radius * two.radius / total
    deviation = math.hypot(one.deviation, two.deviation)
    pairs = math.pi * one.density * two.density * total
    return {"pressure": (2.5, 16.0 / 15.0 * pairs * math.sqrt(radius) * deviation**2.5),
            "area_fraction": (2.0, math.pi * pairs * radius * deviation**2),
            "contact_density": (1.0, 2.0 * pairs * deviation)}, one.mean + two.mean, deviation


def _table(factors: dict[str, tuple[float, float]], mean: float, deviation: float, separation: Any,
           pressure: Any, heights: str = "gaussian") -> Table:
    """Factors times height integrals, at separations or at the pressures."""
    if (separation is None) == (pressure is None):
        raise _a.wrong("separation, pressure", "both or none", "one of them")
    order, factor = factors["pressure"]
    given = np.atleast_1d(np.asarray(pressure if separation is None else separation, dtype=float))
    h = (given - mean) / deviation if separation is not None else np.array([
        _separation(lambda at: factor * height_integral(order, at, heights), one) for one in given])
    return Table({"separation": mean + deviation * h, **{
        name: of * height_integral(n, h, heights) for name, (n, of) in factors.items()}},
        name="separations")


def _separation(pressure_at: Callable[[float], Any], pressure: float) -> float:
    """The separation, in deviations from the mean, at a nominal pressure."""
    if not pressure_at(HIGHEST) <= pressure <= pressure_at(LOWEST):
        raise _a.wrong("pressure", str(pressure), "one between the highest summit and full overlap")
    return float(optimize.brentq(lambda at: math.log(pressure_at(at) / pressure), LOWEST, HIGHEST))


@functools.cache
def _disc() -> tuple[Any, Any, Any]:
    """Nodes of a disc of radius 1, weights of an integral of values there over the radius, and the
    matrix from pressures to displacements. Both grow with the radius."""
    nodes = np.linspace(0.0, 1.0, NODES)
    weights = interpolate.CubicSpline(nodes, np.eye(NODES)).antiderivative()(1.0)
    # Pressure and G are even functions of the radius, and 0 with their slope at the end.
    basis = interpolate.CubicSpline(nodes, np.eye(NODES), bc_type="clamped")
    (angle, turn), (along, share) = (
        ((points + 1.0) * end / 2.0, sizes * end / 2.0) for end, (points, sizes) in
        ((math.pi / 2.0, np.polynomial.legendre.leggauss(ANGLES)),
         (1.0, np.polynomial.legendre.leggauss(ALONG))))
    lines, turns = np.zeros((NODES, NODES)), np.zeros((NODES, NODES))
    for i, x in enumerate(nodes):
        half = math.sqrt(1.0 - x**2)
        lines[i] = half * share @ basis(np.hypot(x, half * along))
        turns[i] = turn @ basis(x * np.sin(angle))
    return nodes, weights, 2.0 / math.pi * turns @ lines


def _gap(mu: float, load: float, hertz: float) -> tuple[Any, Any, Any]:
    """Places, separations of the mean planes there, and weights of an integral over the radius.

    With lengths along the surface in sqrt(2 R sigma), heights in sigma and pressures in
    E* sqrt(sigma/(8 R)), h = d + r**2 + u and p = mu F_3/2(h); the displacement is (2/pi) times the
    integral of G(r sin t) over t from 0 to pi/2, G(x) that of p(sqrt(x**2 + y**2)) over y > 0
    (E. T. Copson, Proc. Edinb. Math. Soc. 8 (1947) 14). By Powell's method from Hertz' pressure.
    """
    nodes, weights, matrix = _disc()
    reach = 1.5 * math.sqrt(hertz**2 + 1.0)
    while True:
        r, ring = reach * nodes, 2.0 * math.pi * reach**2 * weights * nodes

        def residual(values: Any) -> tuple[Any, Any]:
            h = values[-1] + r**2 + values[:-1]
            p, slope = (share * mu * height_integral(n, h) for share, n in ((1, 1.5), (-1.5, 0.5)))
            total = max(LEAST, ring @ p)
            jacobian = np.eye(NODES + 1)
            jacobian[:-1, :-1] -= reach * matrix * slope
            jacobian[:-1, -1] = -reach * matrix @ slope
            jacobian[-1] = np.append(ring * slope, ring @ slope) / total
            return np.append(values[:-1] - reach * matrix @ p, math.log(total / load)), jacobian

        # From the displacement of Hertz, at the separation that has the load then.
        u = reach * matrix @ (1.5 * load / (math.pi * hertz**2) * np.sqrt(
            np.maximum(0.0, 1.0 - (r / hertz)**2)))
        low = -float((load / (mu * ring.sum()))**(2.0 / 3.0) + (r**2 + u).max())
        start = optimize.brentq(lambda d: math.log(max(LEAST, ring @ (
            mu * height_integral(1.5, d + r**2 + u)) / load)), low, -LOWEST)
        found = optimize.root(residual, np.append(u, start), jac=True, tol=CLOSED)
        if not found.success:
            raise ComputeError(f"the ball on a rough plane: {found.message}")
        h = found.x[-1] + r**2 + found.x[:-1]
        ends = height_integral(1.5, h[[0, -1]])
        if ends[1] <= LEFT * ends[0]:
            return r, h, reach * weights
        reach *= GROWTH
