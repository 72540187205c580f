"""Normal problems of CONTACT (E. A. H. Vollebregt) on its own grids, against its printed outputs.

Source: https://github.com/eve70a/CONTACT, commit d431cdb of 2025-07-23, revision 2707: the files
`testbank/testbank.ref_out` and `examples/*.ref_out`. Lengths in mm, forces in N. Geometry and
material are those of the inputs; numbers are kept as printed, and are met to half a unit in the
last place.
"""

import math

import numpy as np
from comparisons import Suite, pixels

COUPLED = ("unlike bodies with friction, here without it: `coupling = 'on'` is compared in "
           "test_unlike_bodies.py")
HERTZ = "CONTACT prints the formula of Hertz here, and its own solution in `testbank 14`"
EXACT = "CONTACT counts the elements in the exact ellipse here, those of its FASTSIM option"


def modulus(nu_1, nu_2, shear_1, shear_2):
    """Combined modulus of two Poisson ratios and two shear moduli."""
    return 1 / ((1 - nu_1) / (2 * shear_1) + (1 - nu_2) / (2 * shear_2))


def paraboloid(b_1, b_3, columns, rows, x_1, y_1, dx, dy):
    """Heights of -(b_1 x**2 + b_3 y**2) at the centres of the elements, and their spacing."""
    x = (x_1 + dx * np.arange(columns))[None, :]
    y = (y_1 + dy * np.arange(rows))[:, None]
    return -(b_1 * x * x + b_3 * y * y), (dx, dy)


def centred(b_1, b_3, columns, rows, dx, dy):
    return paraboloid(b_1, b_3, columns, rows, -(columns - 1) / 2 * dx, -(rows - 1) / 2 * dy,
                      dx, dy)


def cylinder(radius, columns, x_1, dx, dy):
    x = (x_1 + dx * np.arange(columns))[None, :]
    return np.sqrt(radius**2 - x * x) - radius, (dx, dy)


STEEL = modulus(.28, .28, 82e3, 82e3)
UNIT = modulus(.28, .28, 1., 1.)
SOFT = modulus(0., 0., .5, 1e5)
BENCH = paraboloid(.0056566, .0056566, 17, 17, -1.06666, -1.06666, .13333, .13333)
KALKER = paraboloid(.002963, .002963, 41, 41, -4., -4., .2, .2)
LINE = paraboloid(.001, 0., 55, 1, -1.045, 0., .04, 200.)
# The curvature of semi-axes of 4.1 mm at 0.7563 N, and the element of 41 in 1.17143 of them.
SCALED = 2 * 1.17143 * 4.1 / 41
HERTZIAN = centred(.75 * .7563 / (4.1**3 * UNIT) / 2, .75 * .7563 / (4.1**3 * UNIT) / 2, 41, 41,
                   SCALED, SCALED)
CATTANEO = centred(.01, .01, 19, 19, 2 * 1.26667 / 19, 2 * 1.26667 / 19)
SPENCE = paraboloid(.004116, .004116, 45, 45, -4.4, -4.4, .2, .2)
ELLIPSE = centred(.8464e-3, .2406e-2, 44, 44, .4, .2)
ROLLERS = paraboloid(.01, 0., 99, 1, -7.92, 0., .16, 1000.)

# Problem, heights, modulus, what is given, and what is printed: FN, APPROACH, PMAX, NCON and
# ELAST.EN. (in J), or None; then the reason of differences.
CASES = (
    ("testbank 1", BENCH, STEEL, ("separation", -.01131),
     ("1720.", None, "821.0", 177, None), ""),
    ("testbank 10", BENCH, STEEL, ("load", 1722.), (None, "1.132E-02", "821.4", 177, None), ""),
    ("testbank 3", paraboloid(1.085, 1.085, 3, 3, -1., -1., 1., 1.), modulus(.28, .28, 200., 1.),
     ("load", 1.), (None, "0.406012", "1.000", 1, "2.030E-04"), ""),
    ("testbank 6", LINE, STEEL, ("load", 35780.), (None, "6.492E-03", "113.9", 51, None), ""),
    ("testbank 7", KALKER, UNIT, ("load", .4705), (None, "7.258E-02", "1.834E-02", 973, None), ""),
    ("testbank 8", paraboloid(.002963, .002963, 51, 41, -4., -4., .2, .2), UNIT,
     ("load", .4705), (None, "7.258E-02", "1.834E-02", 973, None), ""),
    ("testbank 13", HERTZIAN, UNIT, ("load", .7563), (None, "9.961E-02", None, None, None), HERTZ),
    ("testbank 14", HERTZIAN, UNIT, ("load", .7563),
     (None, "9.959E-02", "2.148E-02", 973, None), ""),
    ("catt_to_cart 1", paraboloid(.002963, .002963, 34, 33, -4., -4., .25, .25), UNIT,
     ("load", .4705), (None, "7.258E-02", "1.834E-02", 621, None), ""),
    ("cattaneo 1", CATTANEO, modulus(.42, .42, 200., 200.), ("load", 9.1954),
     (None, "1.998E-02", "4.393", 177, "7.350E-05"), ""),
    ("spence35 1", SPENCE, SOFT, ("load", 1.1e-5),
     (None, "6.172E-05", "2.750E-04", 1, None), ""),
    ("spence35 6", SPENCE, SOFT, ("load", 2.370e-3), (None, None, None, 29, None), ""),
    ("spence35 6", SPENCE, SOFT, ("load", 2.370e-3),
     (None, "2.901E-03", "3.941E-03", None, None), COUPLED),
    ("spence35 18", SPENCE, SOFT, ("load", .064),
     (None, "2.610E-02", "1.220E-02", 241, None), COUPLED),
    ("spence35 35", SPENCE, SOFT, ("load", .470508),
     (None, "9.874E-02", "2.392E-02", 921, None), COUPLED),
    ("carter2d 1", paraboloid(.001, 0., 55, 1, -1.05, 0., .04, 200.), STEEL, ("load", 35780.),
     (None, "6.492E-03", "113.9", 50, None), ""),
    ("ertz_temperature 1", paraboloid(.001015, .0004215, 216, 45, -7.8, -11., .2, .5), STEEL,
     ("load", 1e5), (None, "8.190E-02", "770.6", 1969, None), ""),
    ("bentall 1", centred(.02, 0., 216, 1, .001, 1000.), modulus(.31, .28, 23e3, 82e3),
     ("load", 16201.9), (None, "2.081E-03", "103.1", 200, None), ""),
    ("veldep_fric 1", cylinder(460., 92, -4.6, .1, 200.), STEEL, ("load", 622216.),
     (None, "8.879E-02", "495.3", 81, None), ""),
    ("visc_cylindr 5", ROLLERS, modulus(.4, .4, 571.5, 571.5), ("load", 6e5),
     (None, "2.50845", "60.32", 80, None), ""),
    ("visc_cylindr 6", ROLLERS, modulus(.4, .4, 1143., 1143.), ("load", 6e5),
     (None, "1.32370", "85.29", 56, None), ""),
    ("subsurf 1", paraboloid(2.16, 2.16, 1, 1, 1e-4, 2e-4, 1., 1.), UNIT, ("load", 1.),
     (None, "0.807984", "1.000", 1, None), ""),
    ("plastic_3bl 1", paraboloid(.02371, .02371, 1, 1, 0., 0., 1., 1.), STEEL, ("load", 900.),
     (None, "8.868E-03", "900.0", 1, None), ""),
    ("fastsim 1", ELLIPSE, STEEL, ("load", 82e3), (None, "9.266E-02", "1223.", 1276, None), ""),
    ("fastsim 6", centred(.8464e-3, .2406e-2, 220, 220, .08, .04), STEEL, ("load", 82e3),
     (None, None, None, 31428, None), EXACT),
)


def padded(heights):
    """A map needs 3 x 3 pixels: missing ones around an element or a row of them."""
    around = [(1, 1) if size < 3 else (0, 0) for size in heights.shape]
    return np.pad(heights, around, constant_values=math.nan)


def suite():
    found = Suite("CONTACT", "printed outputs of its test bank and examples, 3 to 6 digits")
    for name, (heights, spacing), combined, given, printed, reason in CASES:
        results = pixels(padded(heights), spacing, combined, *given)
        state = {name: results.states[name][-1]
                 for name in ("load", "separation", "elastic_energy")}
        pressure = np.nan_to_num(np.asarray(results.fields().pressure))
        load, approach, greatest, elements, energy = printed
        for label, text, value in (("load", load, state["load"]),
                                   ("compression", approach, -state["separation"]),
                                   ("greatest pressure", greatest, pressure.max()),
                                   ("elastic energy", energy, state["elastic_energy"] / 1e3)):
            if text:
                found.printed(f"{name}, {label}", text, value, reason)
        if elements:
            found.count(f"{name}, elements in contact", elements, (pressure > 0).sum(), reason)
    return found
