"""Contacts pressed together and each alone on one half-space: the truth for `boundary`.

Written apart from the solver, on another basis. The bodies are an elastic half-space of combined
modulus E* below a rigid surface whose gap is the vertical one between two spheres,

    g_i(x) = zc_i - p_i - sqrt(ru^2 - |x - xu|^2) - sqrt(rl^2 - |x - xl|^2),

the least over the pairs. The pressure of contact i is written p = (2 E* a/(pi R)) sqrt(F), F a
polynomial in the plane; Hertz is F = 1 - r^2/a^2. The contact is where F > 0 around its centre,
so the edge is part of the unknowns and the pressure falls to zero there as a square root, which
is what p >= 0 with complementarity asks for. The coefficients follow from Galerkin's equations
(the displacement plus gap is orthogonal to every change of pressure, dF/(2 sqrt F)) by Newton's
method. Integrals of p/|x - x'| inside the own contact run along chords through x, where 1/|x - x'|
cancels against the plane polar element. Degrees of F are raised level by level; the difference of
the last two levels is the uncertainty.

`lattice` solves the same contacts on squares with Love's coefficients: slower, coarser, but simple
enough to check the above.

    python3 test/truth/boundary_truth.py > reference_output/boundary/factors.csv
    python3 test/truth/boundary_truth.py --check
"""

import sys
from pathlib import Path

import numpy as np

from boundary_equations import evaluate
from boundary_lattice import lattice
from boundary_patch import Contact, circles_that_overlap

ROOT = Path(__file__).resolve().parents[2]


def thesis_contacts():
    """E* in N/cm2 and the contacts of each position, from the exact evaluation of the deck."""
    from exact_contact import Truth, mp, read_deck

    truth = Truth(read_deck(ROOT / "data" / "thesis.deck"), 30)
    positions = {}
    for m in range(1, truth.scene.positions + 1):
        state, contacts = truth.state(m), []
        with mp.workdps(truth.digits):
            pairs = [] if state is None else [p for p in truth.near_pairs(m)
                                              if p.names in state.contacts]
            for p in pairs:
                upper = float(truth.upper[p.names[0] - 1][3])
                lower = float(truth.lower[p.names[1] - 1][3])
                contacts.append(Contact(*map(float, p.upper), upper, *map(float, p.lower), lower,
                                        float(p.touch - state.separation)))
        positions[m] = contacts
    return float(truth.modulus), positions


def write_factors(positions, modulus):
    """One row a position. Less than 1e-10 is not claimed, whatever the levels say."""
    print("position,contacts,together,alone,factor,uncertainty,overlapping_circles,open,hertz,"
          "hertz_normal,least_gap,by_contact")
    for m, contacts in positions.items():
        levels = ("4", "6", "8") if circles_that_overlap(contacts) else ("4", "6")
        r = evaluate(contacts, modulus, levels)
        by_contact = sum(c.hertz(modulus) * together / alone for c, together, alone
                         in zip(contacts, r["loads"], r["loads_alone"]))
        print(f"{m},{len(contacts)},{r['together']:.10g},{r['alone']:.10g},{r['factor']:.10g},"
              f"{max(r['uncertainty'], 1e-10):.1e},{r['overlapping_circles']},"
              f"{r['loads'].count(0.0)},{r['hertz']:.10g},{r['hertz_normal']:.10g},"
              f"{r['least_gap']:.1e},{by_contact:.10g}", flush=True)


def sneddon(sphere, radius):
    """Two equal spheres one above the other, exact profile (Sneddon 1965): penetration, load/E*."""
    log = np.log((sphere + radius) / (sphere - radius))
    return radius * log, (radius ** 2 + sphere ** 2) * log - 2 * radius * sphere


def check():
    """One pair against closed forms; two near contacts and position 56 against the lattice."""
    from mpmath import mp

    print("aligned spheres of radius 1.27 against Sneddon's closed form and Hertz")
    for radius in (0.01, 0.03, 0.0937, 0.2, 0.4):
        penetration, load = sneddon(1.27, radius)
        one = Contact(0, 0, 1.27, 0, 0, 1.27, penetration)
        found = evaluate([one], 1.0)
        print(f"  a/R {radius / 0.635:.3f}  error {found['together'] / load - 1:8.1e}"
              f"  over Hertz {found['together'] / found['hertz'] - 1:9.2e}")
    print("inclined pair at a small penetration against the elliptical Hertz contact")
    for slope in (0.05, 0.1, 0.2):
        plan = 2.54 * slope / np.hypot(1, slope)
        one = Contact(0, 0, 1.27, plan, 0, 1.27, 1e-6)
        found, truth = evaluate([one], 1.0), ellipse(slope, 0.635, 1e-6, mp)
        print(f"  slope {slope}  error {found['together'] / truth - 1:8.1e}"
              f"  over Hertz's normal load {found['together'] / found['hertz_normal'] - 1:.2e}"
              f"  over its vertical part {found['together'] / found['hertz'] - 1:.2e}")
    modulus, positions = thesis_contacts()
    near = [Contact(0, 0, 1.27, 0, 0, 1.27, 0.0138), Contact(0.16, 0, 1.27, 0.16, 0, 1.27, 0.0132)]
    for name, contacts, cells in (("two circles that overlap", near, (10.3, 20.3, 40.3, 80.3)),
                                  ("position 18", positions[18], (10.3, 20.3, 40.3)),
                                  ("position 56", positions[56], (10.3, 20.3))):
        found = evaluate(contacts, modulus, ("4", "6", "8"))
        print(f"{name}: factor by level", *(f"{f:.8f}" for f in found["factors"]))
        for n in cells:
            side = max(c.circle for c in contacts) / n
            alone = sum(sum(lattice([c], modulus, side)) for c in contacts)
            loads = lattice(contacts, modulus, side)
            print(f"  lattice, {n} squares a radius: factor {sum(loads) / alone:.7f}, "
                  f"load {sum(loads) / found['together'] - 1:8.1e}")


def ellipse(slope, radius, penetration, mp):
    """Load/E* of the gap x^2/(2 R c^3) + y^2/(2 R c), c = cos M (Hertz; Johnson 1985, 4.2)."""
    ratio = mp.mpf(1 + slope ** 2)
    cosine = 1 / mp.sqrt(ratio)
    # The curvatures' ratio as a function of the axes' gives the eccentricity m = e^2.
    def curvatures(m):
        k, e = mp.ellipk(m), mp.ellipe(m)
        return (e / (1 - m) - k) / (k - e)

    m = mp.findroot(lambda v: curvatures(v) - ratio, (slope ** 2, 1.5 * slope ** 2))
    k, e = mp.ellipk(m), mp.ellipe(m)
    # With the long half axis l: y^2/(2 R c) and the penetration give l and the peak.
    # u = (p0 b/E*) (K - ((K - E)/m) y^2/l^2 - ...), y along the long axis.
    long2 = penetration * 2 * radius * cosine * (k - e) / (m * k)
    short = mp.sqrt(long2 * (1 - m))
    peak = penetration / (short * k)
    return float(2 * mp.pi / 3 * peak * mp.sqrt(long2) * short)


if __name__ == "__main__":
    if "--check" in sys.argv[1:]:
        check()
    else:
        E_STAR, POSITIONS = thesis_contacts()
        write_factors(POSITIONS, E_STAR)
