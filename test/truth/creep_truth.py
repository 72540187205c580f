"""Creep of contacts of a standard linear solid, evaluated apart from the program.

The load of a contact is the hereditary integral of its elastic load (Lee and Radok 1960),

    P(t) = integral over t' of E(t - t')/E(0) dPe(t'),   E(t)/E(0) = r + (1 - r) exp(-t/tau)

`hereditary` is that integral by mpmath, for any smooth course of the elastic load. `held_load`
follows several spheres under a held load: at each time a bisection for the compression and the same
integral as a sum over the whole past; it has neither the compliance nor the memory variable of
the program.
"""

import mpmath
import numpy


def relaxation(ratio, tau, t):
    """E(t)/E(0)."""
    return ratio + (1 - ratio) * mpmath.exp(-t / tau)


def hereditary(ratio, tau, t, elastic, slope):
    """Load at time t of a contact with the elastic load elastic(t); a jump at time 0 is loading."""
    after = mpmath.quad(lambda s: relaxation(ratio, tau, t - s) * slope(s), [0, t / 2, t])
    return elastic(mpmath.mpf(0)) * relaxation(ratio, tau, t) + after


def compliance(ratio, tau, t):
    """J(t) E(0) by inverting the convolution of J and E numerically: Laplace, Talbot's contour."""
    t, tau = mpmath.mpf(t), mpmath.mpf(tau)

    def transform(s):  # s**2 J~ E~ = 1
        modulus = ratio / s + (1 - ratio) / (s + 1 / tau)
        return 1 / (s**2 * modulus)

    return mpmath.invertlaplace(transform, t, method="talbot")


def held_load(gaps, radii, load, ratio, tau, hold, steps):
    """Elastic loads Pe and loads P of aligned spheres at the end of a held load (modulus 1).

    At every time the compression is the one at which the integrals add up to the load. The
    integrals
    are trapezoidal sums over all earlier times, with even steps; the error falls as 1/steps**2.
    """
    gaps, radii = numpy.asarray(gaps, float), numpy.asarray(radii, float)

    def elastic(closing):
        return 4 / 3 * numpy.sqrt(radii) * numpy.maximum(closing - gaps, 0) ** 1.5

    def closing_at(total_of):
        low, high = gaps.min(), gaps.min() + 2 * (load / radii.max() ** 0.5 / ratio) ** (2 / 3)
        for _ in range(200):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if total_of(middle) < load else (low, middle)
        return 0.5 * (low + high)

    times = numpy.linspace(0, hold, steps + 1)
    course = [elastic(closing_at(lambda c: elastic(c).sum()))]
    loads = course[0]
    for n in range(1, steps + 1):
        modulus = ratio + (1 - ratio) * numpy.exp(-(times[n] - times[: n + 1]) / tau)
        middle = 0.5 * (modulus[1:] + modulus[:-1])  # of each step
        past = modulus[0] * course[0]
        if n > 1:
            past = past + middle[:-1] @ numpy.diff(numpy.array(course), axis=0)
        last = course[-1]
        at = closing_at(lambda c: (past + middle[-1] * (elastic(c) - last)).sum())
        course.append(elastic(at))
        loads = past + middle[-1] * (course[-1] - last)
    return course[-1], loads


def extrapolated(*arguments, steps):
    """`held_load` freed of its error of second order, and how far that moved it."""
    coarse, fine = held_load(*arguments, steps), held_load(*arguments, 2 * steps)
    found = [f + (f - c) / 3 for c, f in zip(coarse, fine)]
    return found, max(abs(f - x).max() for f, x in zip(fine, found))
