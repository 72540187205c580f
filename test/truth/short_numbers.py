"""Short floating point of the System/370 in whole numbers, as its Principles of Operation state it.

A number is fraction * 16**exponent with a signed fraction of six hexadecimal digits, the first of
them not zero, or zero. Sums keep one guard digit; sums, products and quotients are cut to six
digits, never rounded. Constants and numbers of cards are cut as well.

The square root is that of the FORTRAN library: a rational first value, two of Newton's steps, the
last of them halved and rounded. W**1.5, SIN and COS are rounded correctly (deviation j of
reference_output/faults/listing_port_scan.md).
"""

from fractions import Fraction
from functools import lru_cache
from math import isqrt

from mpmath import mp, mpf

DIGITS = 6
LEAST, END = 16 ** (DIGITS - 1), 16 ** DIGITS


class Short:
    """A short number; immutable."""

    __slots__ = ("fraction", "exponent")

    def __init__(self, fraction, exponent=0):
        """The digits of an integer times a power of 16, cut to six."""
        magnitude = abs(fraction)
        if magnitude == 0:
            exponent = 0
        while magnitude >= END:
            magnitude >>= 4
            exponent += 1
        while 0 < magnitude < LEAST:
            magnitude <<= 4
            exponent -= 1
        self.fraction = magnitude if fraction > 0 else -magnitude
        self.exponent = exponent

    def __add__(self, other):
        large, small = (self, other) if self.exponent >= other.exponent else (other, self)
        if small.fraction == 0 or large.fraction == 0:
            return self if other.fraction == 0 else other
        places = 4 * (large.exponent - small.exponent)
        # One digit more than the fraction: the guard digit. What lies behind it is lost.
        guarded = (abs(small.fraction) << 4) >> places
        total = (large.fraction << 4) + (guarded if small.fraction > 0 else -guarded)
        return Short(total, large.exponent - 1)

    def __neg__(self):
        return Short(-self.fraction, self.exponent)

    def __sub__(self, other):
        return self + -other

    def __mul__(self, other):
        return Short(self.fraction * other.fraction, self.exponent + other.exponent)

    def __truediv__(self, other):
        if other.fraction == 0:
            if self.fraction == 0:
                return self
            raise ZeroDivisionError
        quotient = (abs(self.fraction) << 4 * 2 * DIGITS) // abs(other.fraction)
        sign = 1 if (self.fraction > 0) == (other.fraction > 0) else -1
        return Short(sign * quotient, self.exponent - other.exponent - 2 * DIGITS)

    def __float__(self):
        """Exact: six hexadecimal digits are 24 of the 53 bits of a double."""
        return float(self.fraction) * 16.0 ** self.exponent

    def __lt__(self, other):
        return float(self) < float(other)

    def __le__(self, other):
        return float(self) <= float(other)


@lru_cache
def cut(value):
    """A decimal number, of the text or of a card, cut to six digits."""
    value = Fraction(value)
    exponent = -2 * DIGITS
    while abs(value) * Fraction(16) ** -exponent < LEAST and value:
        exponent -= 1
    while abs(value) * Fraction(16) ** -exponent >= END:
        exponent += 1
    scaled = abs(value) * Fraction(16) ** -exponent
    digits = scaled.numerator // scaled.denominator
    return Short(digits if value > 0 else -digits, exponent)


def rounded(numerator, exponent):
    """numerator * 16**exponent, rounded half up to six digits; the numerator is positive."""
    places = 0
    while numerator >> places >= END:
        places += 4
    if places:
        numerator = (numerator + (1 << places - 1)) >> places
    return Short(numerator, exponent + places // 4)


FIRST = (cut("1.681595"), cut("1.288973"), cut("0.8408065"))
QUARTER = cut("0.25")


def square_root(x):
    """SQRT of the FORTRAN library. x = 16**(2p - q) m with q of 0 or 1 and m from 1/16 to 1."""
    if x.fraction == 0:
        return x
    if x.fraction < 0:
        raise ArithmeticError("root of a negative number")
    power = x.exponent + DIGITS
    p, q = (power + 1) // 2, power % 2
    m = Short(x.fraction, -DIGITS)
    y = FIRST[0] - FIRST[1] / (FIRST[2] + m)
    if q:
        y = y * QUARTER
    y = Short(y.fraction, y.exponent + p)
    total = y + x / y
    y = Short(total.fraction * 8, total.exponent - 1)
    other = x / y
    least = min(y.exponent, other.exponent)
    total = sum(z.fraction << 4 * (z.exponent - least) for z in (y, other))
    return rounded(total * 8, least - 1)


def power_three_halves(x):
    """x**1.5, rounded correctly."""
    if x.fraction < 0:
        raise ArithmeticError("power of a negative number")
    # An even exponent, and enough digits for a root of more than twelve.
    places = 4 * DIGITS + (x.exponent % 2)
    cube = x.fraction ** 3 << 4 * places
    exponent = 3 * x.exponent - places
    if exponent % 2:
        cube, exponent = cube << 4, exponent - 1
    root = isqrt(cube)
    # One digit more, not zero where the root leaves a remainder: no tie is one by the cut.
    return rounded(16 * root + (root * root != cube), exponent // 2 - 1)


def of_angle(function, angle):
    """SIN or COS of an angle, rounded correctly; from 40 digits."""
    with mp.workdps(40):
        value = function(mpf(angle.fraction) * mpf(16) ** angle.exponent)
        scaled = int(mp.floor(abs(value) * mpf(16) ** (4 * DIGITS)))
    found = rounded(scaled, -4 * DIGITS)
    return found if value > 0 else -found
