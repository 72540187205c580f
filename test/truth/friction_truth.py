"""Friction of two spheres closed vertically, evaluated apart from the program.

Two ways, which share nothing but the geometry with each other and with the program:

`march` goes step by step through the compression with a row of springs, each of which touches,
sticks
and slips by itself (method of dimensionality reduction: Popov and Hess, Method of Dimensionality
Reduction in Contact Mechanics and Friction, 2015, chapters 3 and 5). For axially symmetric contacts
it gives the loads and the stick radius of Hertz, Cattaneo and Mindlin for any path.

`closed_form` evaluates with mpmath the superposition of Hertz states: quadrature for the stick
part, root of the secant condition for the stick radius, plain differences with many digits.
"""

from dataclasses import dataclass

import mpmath
import numpy


@dataclass
class Friction:
    """State at the end of a compression. Forces in the unit of modulus times length squared."""

    normal: float
    tangential: float
    contact_radius: float
    stick_radius: float
    lateral: float  # on the upper body, from the lower centre towards the upper one
    vertical: float
    sliding: bool


def stiffnesses(e1, nu1, e2, nu2):
    """Combined modulus E and combined shear modulus G of Mindlin, from each body's own."""
    shear1, shear2 = 2 * (1 + nu1) / e1, 2 * (1 + nu2) / e2  # compliances, 1/G
    normal = 1 / ((1 - nu1**2) / e1 + (1 - nu2**2) / e2)
    shear = 1 / ((2 - nu1) * shear1 + (2 - nu2) * shear2)
    return normal, shear


def march(radius_upper, radius_lower, d, penetration, e1, nu1, e2, nu2, mu, steps=4000):
    """The compression in `steps` steps, one more spring touching in each.

    The row is symmetric: springs at x > 0 stand for both sides. The error falls as 1/steps**2.
    """
    modulus, shear = stiffnesses(e1, nu1, e2, nu2)
    s = radius_upper + radius_lower
    radius = radius_upper * radius_lower / s
    height = numpy.sqrt((s - d) * (s + d))

    # Steps at which the contact radius grows by equal amounts: penetration as its square, nearly.
    p = penetration * numpy.linspace(0, 1, steps + 1) ** 2
    z = height - p
    centres = numpy.hypot(d, z)
    overlap = p * (height + z) / (s + centres)
    # What each step moves along and across the line of centres, by its middle: Mindlin's increment.
    middle = 0.5 * (z[1:] + z[:-1])
    across = numpy.concatenate([[0], numpy.diff(p) * d / numpy.hypot(d, middle)])

    x = numpy.sqrt(radius * overlap)  # the spring that touches at each step
    pull = numpy.zeros(steps + 1)  # tangential force of each spring, over its length
    slipping = numpy.zeros(steps + 1, dtype=bool)
    for k in range(1, steps + 1):
        # Springs that touched before this step. The one that touches at its end has no force.
        pull[:k] += 4 * shear * across[k]
        press = modulus * (overlap[k] - overlap[:k])
        slipping[:k] = pull[:k] > mu * press
        pull[:k] = numpy.minimum(pull[:k], mu * press)
    press = modulus * (overlap[-1] - overlap)
    normal = 2 * numpy.trapezoid(press, x)
    tangential = 2 * numpy.trapezoid(pull, x)
    sticking = numpy.flatnonzero(~slipping[:-1])
    contact = x[-1]
    if not slipping.any():
        stick = contact
    elif sticking.size == 0:
        stick = 0.0
    else:
        stick = 0.5 * (x[sticking[-1]] + x[sticking[-1] + 1])
    return _resolved(normal, tangential, contact, stick, d / centres[-1], z[-1] / centres[-1])


def closed_form(radius_upper, radius_lower, d, penetration, e1, nu1, e2, nu2, mu, digits=40):
    """The superposition of Hertz states, in mpmath. Arguments as text or numbers."""
    with mpmath.workdps(digits):
        values = (radius_upper, radius_lower, d, penetration, e1, nu1, e2, nu2, mu)
        ru, rl, d, p_end, e1, nu1, e2, nu2, mu = (mpmath.mpf(v) for v in values)
        modulus, shear = stiffnesses(e1, nu1, e2, nu2)
        kappa = 4 * shear / modulus
        s, radius = ru + rl, ru * rl / (ru + rl)
        height = mpmath.sqrt(s * s - d * d)

        def overlap(p):
            return max(s - mpmath.sqrt(d * d + (height - p) ** 2), mpmath.mpf(0))

        def shift(p):
            return d * (mpmath.asinh(height / d) - mpmath.asinh((height - p) / d)) if d else d

        def load(p):
            return mpmath.mpf(4) / 3 * modulus * mpmath.sqrt(radius) * overlap(p) ** mpmath.mpf(1.5)

        def stick_load(p):
            # dT = 8 G a dU, dU = sin(slope) dp, with p = P t**2.
            def rate(t):
                now = p * t * t
                sine = d / mpmath.sqrt(d * d + (height - now) ** 2)
                return 8 * shear * mpmath.sqrt(radius * overlap(now)) * sine * 2 * p * t

            return mpmath.quad(rate, [0, 0.5, 1])

        z = height - p_end
        contact = mpmath.sqrt(radius * overlap(p_end))
        if kappa * d <= mu * z:
            tangential, stick = stick_load(p_end), contact
        elif kappa * shift(p_end) > mu * overlap(p_end):
            tangential, stick = mu * load(p_end), mpmath.mpf(0)
        else:
            steepest = height - kappa * d / mu

            def secant(p):
                return kappa * (shift(p_end) - shift(p)) - mu * (overlap(p_end) - overlap(p))

            past = mpmath.findroot(secant, (mpmath.mpf(0), steepest), solver="anderson")
            tangential = mu * (load(p_end) - load(past)) + stick_load(past)
            stick = mpmath.sqrt(radius * overlap(past))
        centres = mpmath.sqrt(d * d + z * z)
        return _resolved(load(p_end), tangential, contact, stick, d / centres, z / centres)


def _resolved(normal, tangential, contact, stick, sine, cosine):
    return Friction(
        normal=normal,
        tangential=tangential,
        contact_radius=contact,
        stick_radius=stick,
        lateral=normal * sine - tangential * cosine,
        vertical=normal * cosine + tangential * sine,
        sliding=bool(stick == 0 and sine > 0),
    )
