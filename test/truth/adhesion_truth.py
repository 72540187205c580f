"""Adhering spheres, evaluated apart from the program with many digits.

`jkr` and `maugis` start from the equations as the papers print them and solve them by general root
searches; the program follows the same curves by parameters of its own. `gap` is a pull across a
gap: the deformation under a constant stress comes from quadrature of its point forces.
"""

from dataclasses import dataclass

import mpmath
from mpmath import mp, mpf

mp.dps = 40
Z0_RANGE = 9 * mpmath.sqrt(3) / 16  # h0/z0: the strength of the Lennard-Jones attraction


@dataclass
class Adhering:
    """One state. The pressure is that at the centre."""

    contact_radius: mpf
    load: mpf
    stiffness: mpf
    pressure: mpf


def jkr(modulus, radius, work, overlap):
    """Johnson, Kendall and Roberts 1971: largest root a of a**2/R - sqrt(2 pi w a/E) = overlap."""
    pull = mpmath.sqrt(2 * mp.pi * work / modulus)
    roots = mpmath.polyroots([1 / radius, 0, 0, -pull, -overlap], maxsteps=2000, extraprec=2000)
    a = max(r.real for r in roots if abs(r.imag) < mpf(10) ** -20 * abs(r)) ** 2

    def load(a):
        return 4 * modulus * a**3 / (3 * radius) - mpmath.sqrt(8 * mp.pi * work * modulus * a**3)

    def overlap_of(a):
        return a**2 / radius - pull * mpmath.sqrt(a)

    stiffness = mpmath.diff(load, a, h=a * mpf(10) ** -15) / mpmath.diff(
        overlap_of, a, h=a * mpf(10) ** -15)
    pressure = 2 * modulus * a / (mp.pi * radius) - mpmath.sqrt(2 * modulus * work / (mp.pi * a))
    return Adhering(a, load(a), stiffness, pressure)


def maugis_units(modulus, radius, work, distance):
    """lambda, and the units of contact radius, load and overlap of Maugis 1992."""
    k = 4 * modulus / 3
    strength = work / (Z0_RANGE * distance)
    third = mpf(1) / 3
    return (2 * strength * (radius / (mp.pi * work * k**2)) ** third,
            (mp.pi * work * radius**2 / k) ** third, mp.pi * work * radius,
            (mp.pi**2 * work**2 * radius / k**2) ** third)


def maugis_m(lam, a):
    """m = c/a of a contact radius, from Maugis' Griffith condition as printed."""
    def griffith(m):
        arc, root = mpmath.asec(m), mpmath.sqrt(m * m - 1)
        return (lam * a * a / 2 * (root + (m * m - 2) * arc)
                + 4 * lam**2 * a / 3 * (root * arc - m + 1) - 1)

    # It grows with m from -1: bisect, then polish.
    low, high = mpf(1), mpf(2)
    while griffith(high) < 0:
        low, high = high, 2 * high
    return mpmath.findroot(griffith, (low, high), solver="anderson", tol=mpf(10) ** -37,
                           verify=False)


def maugis_overlap(lam, a):
    """Overlap of a contact radius."""
    return a * a - 4 * lam * a / 3 * mpmath.sqrt(maugis_m(lam, a) ** 2 - 1)


def maugis_load(lam, a):
    """Load of a contact radius."""
    m = maugis_m(lam, a)
    return a**3 - lam * a * a * (mpmath.sqrt(m * m - 1) + m * m * mpmath.asec(m))


def maugis(modulus, radius, work, distance, overlap):
    """Maugis 1992 at an overlap: the contact radius by a search from large radii downwards."""
    lam, a_unit, load_unit, overlap_unit = maugis_units(modulus, radius, work, distance)
    wanted = overlap / overlap_unit
    high = mpmath.sqrt(abs(wanted)) + 4
    low = high
    while maugis_overlap(lam, low) > wanted:
        high, low = low, low * mpf("0.97")
    a = mpmath.findroot(lambda x: maugis_overlap(lam, x) - wanted, (low, high), solver="anderson",
                        tol=mpf(10) ** -35, verify=False)
    h = a * mpf(10) ** -12
    stiffness = ((maugis_load(lam, a + h) - maugis_load(lam, a - h))
                 / (maugis_overlap(lam, a + h) - maugis_overlap(lam, a - h)))
    m = maugis_m(lam, a)
    strength = work / (Z0_RANGE * distance)
    pressure = (2 * modulus * a * a_unit / (mp.pi * radius)
                - 2 * strength / mp.pi * mpmath.atan(mpmath.sqrt(m * m - 1)))
    return Adhering(a * a_unit, maugis_load(lam, a) * load_unit,
                    stiffness * load_unit / overlap_unit, pressure)


def maugis_pull_off(lam):
    """Largest pull in pi w R."""
    a = mpmath.findroot(lambda x: mpmath.diff(lambda y: maugis_load(lam, y), x, h=mpf(10) ** -13),
                        (mpf("0.3"), mpf("1.3")), solver="anderson", tol=mpf(10) ** -20,
                        verify=False)
    return -maugis_load(lam, a)


def gap(modulus, radius, work, distance, overlap):
    """Pull across a gap: a circle c under the constant stress, its edge h0 apart.

    The edge moves by the integral of the point forces' 1/(pi E r): over the chords through the
    point, 2 c cos(angle) long.
    """
    strength = work / (Z0_RANGE * distance)
    chords = mpmath.quad(lambda angle: 2 * mpmath.cos(angle), [-mp.pi / 2, mp.pi / 2])
    edge = strength * chords / (mp.pi * modulus)  # times c
    reach = Z0_RANGE * distance + overlap
    c = max(mpmath.polyroots([1 / (2 * radius), -edge, -reach]))
    rate = -2 * mp.pi * c * strength / (c / radius - edge)
    return Adhering(mpf(0), -mp.pi * c**2 * strength, rate, mpf(0))
