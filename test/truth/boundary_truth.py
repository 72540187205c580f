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

dense_truth.py solves such contacts on squares: test_dense.py compares both.

    python3 test/truth/boundary_truth.py > reference_output/boundary/factors.csv
"""

from pathlib import Path

import numpy as np

from boundary_equations import evaluate
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
    """One row a position. Less than 1e-10 is not claimed, whatever the levels state."""
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


if __name__ == "__main__":
    E_STAR, POSITIONS = thesis_contacts()
    write_factors(POSITIONS, E_STAR)
