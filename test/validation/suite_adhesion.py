"""The closed forms of the tests of Adhesion: JKR, Maugis and DMT for a sphere.

Source: https://github.com/ContactEngineering/Adhesion, commit f923c56 of 2025-06-05:
`Adhesion/ReferenceSolutions/JKR.py`, `MaugisDugdale.py`, `DMT.py`, and the tests in
`test/ReferenceSolutions`. Their unit, pi w = 1, has contacts wider than the sphere; with pi w =
1e-6 the same curves have narrow ones. Radii, moduli and overlaps are our own.
"""

import math

from comparisons import Suite, last_contact, spheres

WORK = 1e-6 / math.pi
# Range of the attraction over the equilibrium distance, that of docs/theory/adhesion.md.
RANGE = 9 * math.sqrt(3) / 16
MATERIALS = ((1.0, 0.75), (1.0, 1.9), (10.0, 0.75), (0.3, 40.0))


def adhering(overlaps, radius, modulus, distance):
    return last_contact(spheres(overlaps, radius, modulus, adhesion="on", work_of_adhesion=WORK,
                                equilibrium_distance=distance))


def distance_of(number, radius, modulus):
    """Equilibrium distance of a Tabor parameter."""
    return (radius * WORK**2 / modulus**2 / number**3)**(1 / 3)


def jkr(found):
    """Overlap and load by radius of contact, on the stable branch; stress intensity at its edge."""
    for radius, modulus in MATERIALS:
        unit = (1.5 * math.pi * WORK * radius**2 / (2 * modulus))**(1 / 3)
        distance = distance_of(20.0, radius, modulus)
        for share in (1.5, 2.0, 3.0, 5.0):
            a = share * unit
            overlap = a**2 / radius - math.sqrt(2 * math.pi * a * WORK / modulus)
            load = 4 / 3 * modulus * a**3 / radius - math.sqrt(8 * math.pi * a**3 * WORK * modulus)
            # Contact begins at no overlap: smaller ones are reached by unloading.
            path = overlap if overlap > 0 else [0.2 * unit**2 / radius, overlap]
            contact = adhering(path, radius, modulus, distance)
            name = f"JKR, R {radius}, E {modulus}, a {share}"
            found.within(f"{name}, radius of contact", a, contact["contact_radius"], 1e-9)
            found.within(f"{name}, load", load, contact["load"], 1e-9)
            a = contact["contact_radius"]
            hertz = 4 / 3 * modulus * a**3 / radius
            found.within(f"{name}, energy release rate", WORK,
                         (hertz - contact["load"])**2 / (8 * math.pi * modulus * a**3), 1e-9)
        # The largest pull, 3/2 pi w R, is at this radius of contact.
        a = (9 * math.pi * WORK * radius**2 / (8 * modulus))**(1 / 3)
        overlap = a**2 / radius - math.sqrt(2 * math.pi * a * WORK / modulus)
        contact = adhering([0.2 * unit**2 / radius, overlap], radius, modulus, distance)
        found.within(f"JKR, R {radius}, E {modulus}, largest pull", -1.5 * math.pi * WORK * radius,
                     contact["load"], 1e-9)


def griffith(m, a, strength):
    """Maugis 1992, (6.17): zero at the ratio m of the radii of attraction and contact."""
    root, angle = math.sqrt(m * m - 1), math.acos(1 / m)
    return (strength * a * a / 2 * (root + (m * m - 2) * angle)
            + 4 / 3 * strength**2 * a * (root * angle - m + 1) - 1)


def ratio_of(a, strength):
    """The ratio m, by bisection: Griffith's condition grows with it from -1."""
    low, high = 1.0, 1e6
    while high - low > 1e-15 * high:
        middle = (low + high) / 2
        if middle in (low, high):
            break
        low, high = (middle, high) if griffith(middle, a, strength) < 0 else (low, middle)
    return low


def maugis(found):
    """Load and overlap by radius of contact, for a constant attraction."""
    for strength in (0.12, 0.3, 0.8, 2.0, 5.5):
        for radius, modulus in MATERIALS[1:]:
            k = 4 / 3 * modulus
            stress = strength / 2 * (math.pi * WORK * k**2 / radius)**(1 / 3)
            for a in (1.5, 2.5, 4.0):
                m = ratio_of(a, strength)
                root = math.sqrt(m * m - 1)
                load = a**3 - strength * a * a * (root + m * m * math.acos(1 / m))
                overlap = a * a - 4 / 3 * a * strength * root
                contact = adhering(overlap * (math.pi**2 * WORK**2 * radius / k**2)**(1 / 3),
                                   radius, modulus, WORK / stress / RANGE)
                name = f"Maugis, lambda {strength}, R {radius}, E {modulus}, a {a}"
                found.within(f"{name}, radius of contact", a,
                             contact["contact_radius"] / (math.pi * WORK * radius**2 / k)**(1 / 3),
                             1e-9)
                found.near(f"{name}, load", load, contact["load"] / (math.pi * WORK * radius), 1e-8)


def dmt(found):
    """DMT.py: the load of Hertz less 2 pi w R."""
    for radius, modulus in MATERIALS:
        unit = (math.pi * WORK * radius**2 / (4 / 3 * modulus))**(1 / 3)
        for a in (0.5, 1.0, 3.0):
            contact = adhering((a * unit)**2 / radius, radius, modulus,
                               distance_of(0.01, radius, modulus))
            name = f"DMT, R {radius}, E {modulus}, a {a}"
            found.near(f"{name}, load", a**3 - 2, contact["load"] / (math.pi * WORK * radius), 1e-9)
            found.within(f"{name}, radius of contact", a, contact["contact_radius"] / unit, 1e-9)


def suite():
    found = Suite("Adhesion", "closed forms of its tests: JKR, Maugis, DMT")
    for part in (jkr, maugis, dmt):
        part(found)
    return found
