"""A sphere pressed past its elastic limit, evaluated apart from the program.

The formulas stand here as they were published, in mpmath with 40 digits:

- Jackson and Green 2005 (J. Tribology 127, 343): critical load and overlap, load and area.
- Etsion, Kligerman and Kadin 2005 (Int. J. Solids Struct. 42, 3716): unloading.

`joined` is what the program makes of the first between x = 1.9 and 6.
"""

import mpmath
from mpmath import mpf

mpmath.mp.dps = 40


class Sphere:
    """An elastic-plastic sphere of radius R on a rigid flat."""

    def __init__(self, modulus, poisson, yield_stress, radius):
        modulus, poisson, self.yield_stress, self.radius = (
            mpf(n) for n in (modulus, poisson, yield_stress, radius)
        )
        self.modulus = modulus / (1 - poisson**2)
        self.c = mpf("1.295") * mpmath.exp(mpf("0.736") * poisson)
        self.strain = self.yield_stress / self.modulus
        self.b = mpf("0.14") * mpmath.exp(23 * self.strain)
        stress = mpmath.pi * self.c * self.yield_stress / 2
        self.critical_overlap = (stress / self.modulus) ** 2 * self.radius
        self.critical_load = mpf(4) / 3 * (self.radius / self.modulus) ** 2 * stress**3
        self.critical_area = mpmath.pi**3 * (self.c * self.yield_stress * self.radius
                                             / (2 * self.modulus)) ** 2

    def area(self, x):
        """A/Ac."""
        x = mpf(x)
        return x if x <= mpf("1.9") else x * (x / mpf("1.9")) ** self.b

    def hardness(self, x):
        """HG/Sy."""
        x = mpf(x)
        radius = (mpmath.pi * self.c * self.strain / 2 * mpmath.sqrt(x)
                  * (x / mpf("1.9")) ** (self.b / 2))
        return mpf("2.84") * (1 - mpmath.exp(mpf("-0.82") * radius ** mpf("-0.7")))

    def published(self, x):
        """P/Pc as printed, without its switch at x = 1.9."""
        x = mpf(x)
        first = mpmath.exp(-(x ** (mpf(5) / 12)) / 4) * x**1.5
        second = 4 * self.hardness(x) / self.c * (1 - mpmath.exp(-(x ** (mpf(5) / 9)) / 25)) * x
        return first + second

    def joined(self, x):
        """P/Pc of the program: Hertz up to 1.9, as published from 6."""
        x, low, high = mpf(x), mpf("1.9"), mpf(6)
        if x <= low:
            return x**1.5
        if x >= high:
            return self.published(x)
        jump = low**1.5 / self.published(low)
        t = (x - low) / (high - low)
        weight = 3 * t**2 - 2 * t**3
        return self.published(x) * (jump + (1 - jump) * weight)

    def lost(self, x):
        """Work that a press to x and back loses, over Pc times w_c; x of 1 or more."""
        x = mpf(x)
        taken = mpmath.quad(self.joined, [0, *(v for v in ("1.9", "3", "6") if mpf(v) < x), x])
        residual, power, _ = unloading(x)
        low = residual * x
        back = mpmath.quad(lambda w: self.joined(x) * ((w - low) / (x - low)) ** power,
                           mpmath.linspace(low, x, 5))
        return taken - back


def unloading(x):
    """Residual over largest overlap, power of the load, power of the area; x of 1 or more.

    Up to x = 1.2 the program's power of the load is a little above the published one: the least
    with which no work is won."""
    x = mpf(x)
    residual = (1 - x ** mpf("-0.28")) * (1 - x ** mpf("-0.69"))
    power = max(x ** mpf("-0.0331"), 1 - residual)
    return residual, mpf("1.5") * power, x ** mpf("-0.12")


# A steel of Jackson and Green (GPa), and the thesis' plastic (N/cm2) with the yield strain that its
# limit load stands for.
STEEL = Sphere("200", "0.32", "0.9115", "1")
POINTS = ["6", "8", "10", "15", "20", "30", "50", "70", "100", "150"]
BETWEEN = ["1.95", "2.5", "3", "4", "5.5"]
