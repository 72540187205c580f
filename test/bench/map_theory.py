"""Theories of rough contact for the moments of a map: separation and area fraction at a pressure.

`greenwood_williamson`: the summits of rule eight, heights normal about their mean with their
deviation, one radius from their mean curvature (Greenwood and Williamson, Proc. R. Soc. A 295
(1966) 300). `bush_gibson_thomas`: the asymptote for little contact (Wear 35 (1975) 87): area
sqrt(2 pi) p/(E slope), a quarter of erfc(d/(sqrt(2) rms height)). `persson`: area
erf(sqrt(2) p/(E slope)) (J. Chem. Phys. 115 (2001) 3840), separation by Yang and Persson (J. Phys.
Condens. Matter 20 (2008) 215214) with gamma = .45 (Almqvist and others, J. Mech. Phys. Solids 59
(2011) 2355). None knows the edge of a map: the mean displacement of a uniform pressure on a square,
.946 p side/E (Love 1929), is taken from the separation.
"""

import numpy as np
from scipy.optimize import brentq
from scipy.special import erf, erfcinv

from map_truth import statistics, summits

GAMMA = 0.45


def sunk(pressure, modulus, shape, sides):
    return 0.946 * pressure / modulus * np.sqrt(shape[0] * sides[0] * shape[1] * sides[1])


def greenwood_williamson(height, sides, modulus, pressure):
    rows, _ = summits(height, sides[1], sides[0])
    density = len(rows) / (height.size * np.prod(sides))
    mean, deviation, radius = rows[:, 2].mean(), rows[:, 2].std(), 1 / (1 / rows[:, 3]).mean()
    z = np.linspace(0, 12, 4001)

    def moment(d, power):
        s = z * deviation
        normal = np.exp(-((d + s - mean) / deviation) ** 2 / 2) / np.sqrt(2 * np.pi) / deviation
        return np.trapezoid(s ** power * normal, s)

    d = brentq(lambda d: np.log(4 / 3 * modulus * density * np.sqrt(radius) * moment(d, 1.5)
                                / pressure), mean - 5 * deviation, mean + 6 * deviation)
    return d, np.pi * density * radius * moment(d, 1)


def bush_gibson_thomas(height, sides, modulus, pressure):
    known = statistics(height, sides[1], sides[0])
    area = np.sqrt(2 * np.pi) * pressure / (modulus * known["rms slope"])
    return np.sqrt(2 * known["m0"]) * erfcinv(min(4 * area, 1.999)), area


def persson(height, sides, modulus, pressure):
    known = statistics(height, sides[1], sides[0])
    window = np.hanning(height.shape[0])[:, None] * np.hanning(height.shape[1])
    power = np.abs(np.fft.fft2(window * np.nan_to_num(height))) ** 2
    q = 2 * np.pi * np.hypot(np.fft.fftfreq(height.shape[0], sides[0])[:, None],
                             np.fft.fftfreq(height.shape[1], sides[1]))
    edges = np.geomspace(q[q > 0].min() * 0.999, q.max() * 1.001, 120)
    share = np.histogram(q, edges, weights=power)[0]
    share, q = known["m0"] * share / share.sum(), np.sqrt(edges[1:] * edges[:-1])
    # Of d2q C(q) a ring has `share`: q**2 C dq is q share/(2 pi), pi q**3 C dq is q**2 share/2.
    w = 1 / np.sqrt(np.cumsum(q ** 2 * share / 2) + 1e-300)
    gap = 0.0
    for ring, wave, reach in zip(share, q, w):
        if ring > 0 and np.isfinite(reach):
            p = np.geomspace(pressure, max(pressure * 1.01, 6 * modulus / reach), 400)
            inner = (GAMMA + 3 * (1 - GAMMA) * erf(reach * p / modulus) ** 2) * np.exp(
                -(reach * p / modulus) ** 2)
            gap += np.sqrt(np.pi) * wave * ring / (2 * np.pi) * reach * np.trapezoid(inner,
                                                                                    np.log(p))
    return gap, erf(np.sqrt(2) * pressure / (modulus * known["rms slope"]))


THEORIES = {"greenwood_williamson": greenwood_williamson,
            "bush_gibson_thomas": bush_gibson_thomas, "persson": persson}


def separation_and_area(name, height, sides, modulus, load):
    """Of a whole map, its edge free."""
    pressure = load / (height.size * np.prod(sides))
    at, area = THEORIES[name](height, sides, modulus, pressure)
    return at - sunk(pressure, modulus, height.shape, sides), area * height.size * np.prod(sides)
