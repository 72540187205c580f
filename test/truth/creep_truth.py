"""Creep of contacts of a standard linear solid, evaluated apart from the program.

The load of a contact is the hereditary integral of its elastic load (Lee and Radok 1960),

    P(t) = integral over t' of E(t - t')/E(0) dPe(t'),   E(t)/E(0) = r + (1 - r) exp(-t/tau)

`hereditary` is that integral by mpmath, for any smooth course of the elastic load. `held_load`
follows several spheres under a held load: at each time a bisection for the closing and the same
integral as a sum over the whole past; it knows neither the compliance nor the memory variable of
the program. `cycle_work` is Ting (1966): what a sphere gives back after a hold.

Run as a program it prints the values that test/unit/creep_solid_suite.f90 and
creep_suite.f90 hold.
"""

import math

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

    At every time the closing is the one at which the integrals add up to the load. The integrals
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


def cycle_work(ratio, tau, hold, steps=4000):
    """Work taken and given back by a sphere: loaded at once to 1, load held, unloaded at once.

    Radius and modulus are such that P = delta**1.5 at once. During the hold delta**1.5 = J E0. At
    unloading the circle runs back through its radii; with t1 the time at which it had the radius
    before, P = integral up to t1 of E(T - s) dPe(s), and the approach goes back by the integral
    from t1 to T of E(T - s)/E(0) d(delta) (Ting 1966, at a single time T). The error is 1e-7.
    """
    t = numpy.linspace(0, hold, steps + 1)
    delta = (1 / ratio - (1 / ratio - 1) * numpy.exp(-ratio * t / tau)) ** (2 / 3)
    loading = numpy.linspace(0, 1, steps + 1) ** 2  # the approach while it is loaded
    taken = 0.4 + (delta[-1] - delta[0])  # integral of delta**1.5, then 1 times the creep
    times = numpy.concatenate([numpy.zeros(steps), t])
    path = numpy.concatenate([loading[:-1], delta])
    modulus = ratio + (1 - ratio) * numpy.exp(-(hold - times) / tau)
    middle = 0.5 * (modulus[1:] + modulus[:-1])
    load = numpy.concatenate([[0], numpy.cumsum(middle * numpy.diff(path**1.5))])
    back = middle * numpy.diff(path)  # approach given back in each piece
    given = (0.5 * (load[1:] + load[:-1]) * back).sum()
    return taken, given, load[-1]


def main():
    """Prints the truths of the unit tests."""
    mpmath.mp.dps = 30
    print("compliance J(t) E(0) by Laplace inversion, r tau t")
    for r, tau, t in ((0.5, 1, 0.7), (0.9, 150, 600), (0.01, 2, 30), (0.75, 100, 1e-3)):
        print(r, tau, t, mpmath.nstr(compliance(mpmath.mpf(str(r)), tau, t), 20))
    print("load for Pe = (1 + t)**1.5, r tau t")
    for r, tau, t in ((0.5, 1, 2), (0.2, 0.3, 2), (0.9, 5, 2)):
        found = hereditary(
            mpmath.mpf(str(r)),
            mpmath.mpf(str(tau)),
            mpmath.mpf(t),
            lambda s: (1 + s) ** 1.5,
            lambda s: 1.5 * mpmath.sqrt(1 + s),
        )
        print(r, tau, t, mpmath.nstr(found, 20))
    print("pressure of a held load: integral of E d[(J E0)**(1/3)], r tau t")
    for r, tau, t in ((0.5, 1, 5), (0.8, 100, 600)):
        r = mpmath.mpf(str(r))
        j = lambda s: 1 / r - (1 / r - 1) * mpmath.exp(-r * s / tau)
        rate = lambda s: (1 - r) / tau * mpmath.exp(-r * s / tau) / 3 * j(s) ** (-mpmath.mpf(2) / 3)
        found = hereditary(r, tau, mpmath.mpf(t), lambda s: mpmath.cbrt(j(s)), rate)
        print(mpmath.nstr(r, 3), tau, t, mpmath.nstr(found, 20))
    print("held load of spheres, gaps 0 0.01 0.03, radii 1 2 0.5, load 0.008, r 0.4, tau 1, t 3")
    case = ((0, 0.01, 0.03), (1, 2, 0.5), 0.008, 0.4, 1.0, 3.0)
    (elastic, loads), moved = extrapolated(*case, steps=800)
    print("Pe", elastic.tolist(), "P", loads.tolist(), "moved", moved, "sum",
          math.fsum(elastic) / 0.008)
    print("work of a cycle taken, given back, load at the end of the hold")
    for r, tau, hold in ((0.5, 1, 1e-9), (0.5, 1, 1), (0.5, 1, 50), (0.8, 100, 600)):
        print(r, tau, hold, *cycle_work(r, tau, hold))


if __name__ == "__main__":
    main()
