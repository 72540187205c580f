"""Hard cases of adhesion, plasticity, creep, height maps and dense caps.

`make_cases.py` writes the scenes to data/hard/models. Each case has values with the truth, the
tolerance and its reason; `test/hard/test_hard_models.py` compares them. The
truths are closed forms and the evaluations of test/truth, never numbers of the program.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, partial
from math import expm1, pi, sqrt

import numpy as np
from adhesion_truth import maugis_load, maugis_units
from boundary_equations import evaluate
from boundary_patch import Contact
from judge import Figure
from map_press_truth import first_contact, press, rough
from map_truth import levelled
from mpmath import mp, mpf
from plastic_truth import Sphere, unloading

CLOSED_FORM = "closed form; rounding and the tolerance of the load"
EXACT = "rounding alone"
PIXELS = "tolerance of both solvers for the gaps"


@dataclass
class Value:
    """One number of the results: column, truth, relative tolerance and its reason. `state` is the
    index among the states; the column `greatest_pressure` is the largest of the contacts. A truth
    that takes long is a function."""

    column: str
    true: float | Callable
    tolerance: float
    reason: str
    state: int = -1

    def figure(self, solved):
        """The number of results; its error is absolute where the truth is 0."""
        true = self.true() if callable(self.true) else self.true
        if self.column == "greatest_pressure":
            found = max(float(row["maximum_pressure"]) for row in solved.contacts
                        if row["step"] == solved.contacts[-1]["step"])
        else:
            rows = solved.curve if self.column in solved.curve[-1] else solved.positions
            found = float(rows[self.state][self.column])
        return Figure(self.column, found, true, scale=abs(true) or 1.0, message=self.reason)


@dataclass
class ModelCase:
    """A scene of caps, rows (x, y, height, radius), or of heights, under a rigid plane."""

    name: str
    why: str
    truth: str
    groups: dict
    values: list
    caps: list = field(default_factory=list)
    heights: np.ndarray | None = None


def loading(control, value, **other):
    return {"control": control, "value": value, **other}


# ---------------------------------------------------------------- adhesion

E, R, W = 1000.0, 2.0, 0.01
SPHERE = [(0.0, 0.0, 0.5, R)]


def distance_of(tabor):
    """z0 of a Tabor parameter."""
    return (R * W**2 / E**2) ** (1 / 3) / tabor


def adhesion_groups(tabor, loads, **effects):
    return {"material": {"contact_modulus": E}, "loading": loads,
            "effects": {"adhesion": "on", "work_of_adhesion": W,
                        "equilibrium_distance": distance_of(tabor), **effects}}


def maugis_area_without_load(tabor):
    """Area of a contact without load: the largest zero of Maugis' load."""
    lam, unit, _, _ = maugis_units(mpf(E), mpf(R), mpf(W), mpf(distance_of(tabor)))
    low, high = mpf("0.5"), mpf(3)
    for _ in range(120):
        middle = (low + high) / 2
        low, high = (middle, high) if maugis_load(lam, middle) < 0 else (low, middle)
    return float(mp.pi * (low * unit) ** 2)


def jkr_load(overlap):
    """JKR: W = L**2/R (t**4 - t), P = E L**3/R (4/3 t**6 - 2 t**3), L**3 = 2 pi w R**2/E; t > 1."""
    length = (2 * pi * W * R**2 / E) ** (1 / 3)
    low, high = 1.0, 10.0
    for _ in range(200):
        t = (low + high) / 2
        low, high = (low, t) if length**2 / R * (t**4 - t) > overlap else (t, high)
    return E * length**3 / R * (4 / 3 * t**6 - 2 * t**3)


def adhesion_cases():
    areas = {"jkr": pi * (9 * pi * W * R**2 / (2 * E)) ** (2 / 3),
             "dmt": pi * (3 * pi * W * R**2 / (2 * E)) ** (2 / 3)}
    for tabor, theory in ((5.0001, "jkr"), (4.9999, "maugis"), (0.10001, "maugis"),
                          (0.09999, "dmt")):
        true = areas.get(theory) or maugis_area_without_load(tabor)
        yield ModelCase(
            f"adhesion_tabor_{tabor}", "The Tabor parameter is beside the limit of two theories; "
            "the sphere is loaded and unloaded to no load.", f"Area without load by {theory}.",
            adhesion_groups(tabor, loading("load", (0.05, 0.0))),
            [Value("area", true, 1e-9, CLOSED_FORM)], SPHERE)
    # Just before the pull-off force the compression is a square root away from its limit.
    pull = 1.5 * pi * W * R
    small = 1e-6
    length3 = 2 * pi * W * R**2 / E
    t3 = 0.75 * (1 + sqrt(small))
    area = pi * (length3 ** (1 / 3) * t3 ** (2 / 3)) ** 2
    yield ModelCase(
        "adhesion_before_pull_off", "A pull of the pull-off force less one part in a million.",
        "JKR: 4/3 t**6 - 2 t**3 = -3/4 (1 - 1e-6) has t**3 = 3/4 (1 + 1e-3).",
        adhesion_groups(10.0, loading("load", (0.05, -pull * (1 - small)))),
        [Value("area", area, 1e-6, "the load is met to 1e-9, magnified by the slope 1e3"),
         Value("load", -pull * (1 - small), 1e-9, "a requested load")], SPHERE)
    # Many caps: those that touched carry the JKR load of their overlap, tensile below 0.6 of it.
    random = np.random.default_rng(20261127)
    caps = [(float(x), float(y), float(h), R) for x, y, h in zip(
        *(random.random((2, 200)) * 100), np.round(1.0 - 1e-3 * random.random(200), 9))]
    top, level = max(c[2] for c in caps), 0.9995
    carried = [jkr_load(c[2] - level) for c in caps if c[2] > level]
    yield ModelCase(
        "adhesion_many_caps", "200 caps snap in one after the other; the load is a sum of tensile "
        "and compressive loads.", "JKR of each cap that has touched, on loading.",
        adhesion_groups(10.0, loading("separation", level)),
        [Value("load", sum(carried), 1e-9 * sum(map(abs, carried)) / abs(sum(carried)),
               "rounding of heights over overlaps, 1e-16/1e-6, and cancellation in the sum"),
         Value("contacts", len(carried), 0.0, "a count")], caps)
    # Within the range of attraction, out of contact.
    tabor, level = 0.05, top + 1e-4
    reach = 9 * sqrt(3) / 16 * distance_of(tabor)
    pulls = [-2 * pi * W * R * (1 + (c[2] - level) / reach) for c in caps
             if c[2] - level > -reach]
    yield ModelCase(
        "adhesion_range", "No cap touches; those within the range of attraction pull.",
        "DMT across a gap: -2 pi w R (1 - gap/h0).",
        adhesion_groups(tabor, loading("separation", level)),
        [Value("load", sum(pulls), 1e-9, "rounding of heights over the range, 1e-16/1e-4")], caps)


# ---------------------------------------------------------------- plasticity

STEEL = Sphere("200000", "0.32", "911.5", "1")


def plastic_case(name, why, truth, loads, values):
    # Two equal bodies of twice the modulus have the combined modulus of one.
    return ModelCase(
        name, why, truth,
        {"material": {"elastic_modulus": (400000.0, 400000.0), "poisson_ratio": (0.32, 0.32)},
         "loading": loads, "effects": {"plasticity": "on", "plastic_yield_stress": 911.5}},
        values, [(0.0, 0.0, 0.5, 1.0)])


def plasticity_cases():
    critical, load = float(STEEL.critical_overlap), float(STEEL.critical_load)
    below = load * 0.9999**1.5
    yield plastic_case(
        "plastic_cycles_below_yield", "Three cycles to 0.9999 of the overlap of first yield.",
        "Hertz: no work is lost.", loading("load", (below, 0.0) * 3),
        [Value("dissipated_work", 0.0, 1e-12 * below * critical, "absolute: rounding of the work"),
         Value("residual_flattening", 0.0, 0.0, "exact")])
    for over, word in ((1e-6, "just_beyond"), (0.05, "beyond")):
        x = 1.9 * (1 + over)
        residual, power, _ = (float(n) for n in unloading(x))
        at_half = (1 + residual) / 2
        yield plastic_case(
            f"plastic_{word}_onset", f"Loading to {1 + over} times the overlap of the onset, then "
            "to halfway between it and the residual overlap.",
            "Jackson and Green, made continuous at the onset; Etsion, Kligerman and Kadin.",
            loading("compression", (x * critical, at_half * x * critical)),
            [Value("load", float(STEEL.joined(x)) * load * 0.5**power, 1e-11, EXACT)])
    x = 2.5
    top = float(STEEL.joined(x)) * load
    lost = float(STEEL.lost(x)) * load * critical
    yield plastic_case(
        "plastic_cycles", "Ten cycles to the same load: only the first loses work.",
        "Work between the published curves, by quadrature.", loading("load", (top, 0.0) * 10),
        [Value("dissipated_work", lost, 1e-6, "the tests of plasticity: quadrature of the program"),
         Value("residual_flattening", float(unloading(x)[0]) * x * critical, 1e-7,
               "the load is met to 1e-9, the overlap of no load to its root")])


# ---------------------------------------------------------------- creep

def creep_cases():
    tau, time, load = 10.0, 3.0, 5.0
    for ratio in (1.0, 1e-3, 1e-12, 1e-300):
        compliance = 1.0 - (1.0 - ratio) * expm1(-ratio * time / tau) / ratio
        deep = (3 * load * compliance / (4 * E * sqrt(R))) ** (2 / 3)
        yield ModelCase(
            f"creep_ratio_{ratio:g}", "The relaxed modulus is this part of the instantaneous one: "
            "1/r - (1/r - 1) exp(-r t/tau) cancels.", "Hertz under the load times the compliance.",
            {"material": {"contact_modulus": E}, "loading": loading("load", load),
             "effects": {"creep": "on", "relaxation_time": tau, "relaxed_modulus_ratio": ratio,
                         "hold_time": time, "hold": "load"}},
            [Value("compression", deep, 1e-9, CLOSED_FORM),
             Value("area", pi * R * deep, 1e-9, CLOSED_FORM)], SPHERE)
    times, ratios = (1e-6, 1e-3, 1.0, 1e3, 1e6), (0.9, 0.5, 0.1, 1e-3, 1e-6)
    deep = (3 * load * compliance_of(times, ratios, time) / (4 * E * sqrt(R))) ** (2 / 3)
    yield ModelCase(
        "creep_five_times", "Relaxation times of twelve decades, six decades of the modulus.",
        "Hertz under the load times the compliance: the differential equations with 60 digits.",
        {"material": {"contact_modulus": E}, "loading": loading("load", load),
         "effects": {"creep": "on", "relaxation_time": times, "relaxed_modulus_ratio": ratios,
                     "hold_time": time, "hold": "load"}},
        [Value("compression", deep, 1e-9, CLOSED_FORM)], SPHERE)


def compliance_of(times, ratios, time):
    """J(t) E(0): e' = sum of q/tau, q' = g e' - q/tau, e(0) = 1, q(0) = g: matrix exponential."""
    with mp.workdps(60):
        shares = [mpf(a) - mpf(b) for a, b in zip((1, *ratios), ratios)]
        rates = mp.matrix(len(times) + 1)
        for column, tau in enumerate(times, 1):
            for row in range(len(times) + 1):
                rates[row, column] = (shares[row - 1] if row else 1) / mpf(tau)
            rates[column, column] -= 1 / mpf(tau)
        return float((mp.expm(rates * time) * mp.matrix([1, *shares]))[0])


# ---------------------------------------------------------------- height maps

N = 24


def map_case(name, why, truth, heights, loads, values, edge="periodic", level="mean", **effects):
    return ModelCase(
        name, why, truth,
        {"surfaces": {"map_spacing": (1.0, 1.0), "map_edge": edge, "map_level": level},
         "material": {"contact_modulus": E}, "loading": loads,
         "effects": {"interaction": "boundary", **effects}}, values, heights=heights)


def solved_apart(heights, load, periodic=True):
    """Compression, pixels in contact and greatest pressure by the solver of test/truth."""
    level, pressure = press(heights, (1.0, 1.0), E, load, periodic=periodic)
    return (float(first_contact(heights, periodic) - level), int((pressure > 0).sum()),
            float(np.nanmax(pressure)))


def map_values(heights, load, tolerance=1e-7, reason=PIXELS, periodic=True):
    compression, number, greatest = solved_apart(heights, load, periodic)
    return [Value("compression", compression, tolerance, reason),
            Value("samples_in_contact", number, 0.0, "a count of pixels"),
            Value("greatest_pressure", greatest, tolerance, reason)]


def map_cases():
    random_map = np.round(0.01 * rough(N, shortest=4, seed=11), 9)
    load = 150.0
    yield map_case(
        "map_offset_1e6", "Heights of 0.01 on an offset of 1e6: seven digits of them are left.",
        "The same doubles less 1e6, by conjugate gradients in numpy.", random_map + 1e6,
        loading("load", load), map_values((random_map + 1e6) - 1e6, load))
    x = np.arange(N) - N / 2 + 0.3
    bump = -(x**2 + x[:, None] ** 2) / 400
    slope = 0.25 * x[None, :] - 0.125 * x[:, None]
    yield map_case(
        "map_tilt", "A bump on a plane 10 times as high as the bump; the plane is subtracted.",
        "The bump less its plane of least squares, by conjugate gradients in numpy.",
        bump + slope, loading("load", 20.0),
        map_values(levelled(bump + slope), 20.0, 1e-6, PIXELS, periodic=False), "free",
        "plane")
    flat = np.full((N, N), 0.25)
    yield map_case(
        "map_flat", "All heights are equal: every pixel touches at once.",
        "A uniform pressure.", flat, loading("load", 3.0 * N**2),
        [Value("area", float(N**2), 1e-12, EXACT), Value("greatest_pressure", 3.0, 1e-9, PIXELS),
         Value("contacts", 1, 0.0, "a count")])
    steps = np.round(random_map / 0.005) * 0.005
    yield map_case(
        "map_quantised", "Heights of few levels, as of a camera: many pixels touch at once.",
        "The same heights, by conjugate gradients in numpy.", steps, loading("load", load),
        map_values(steps, load))
    wave = 0.01 * np.cos(2 * pi * 3 * np.arange(N) / N) * np.ones((N, 1))
    closing = E * (2 * pi * 3 / N) / 2 * 0.01  # pressure that closes the wave
    yield map_case(
        "map_full_contact", "A wave at 1.5 times the pressure that closes it: no gap is left.",
        "p + E q h/2 cos(q x) (Westergaard 1939).", wave, loading("load", 1.5 * closing * N**2),
        [Value("greatest_pressure", 2.5 * closing, 1e-8, PIXELS),
         Value("area", float(N**2), 1e-12, EXACT),
         Value("mean_gap", 0.0, 1e-12, "absolute: no gap is left")])
    hardness = 2.0
    yield map_case(
        "map_hardness_near_mean_pressure", "The load is 0.999 of what all pixels carry at the "
        "hardness: nearly all of them are plastic.",
        "Sum of pressures from 0 to H; at least load/H of the area is in contact.", random_map,
        loading("load", 0.999 * hardness * N**2),
        [Value("load", 0.999 * hardness * N**2, 1e-9, "a requested load"),
         Value("greatest_pressure", hardness, 1e-12, EXACT),
         Value("area", float(N**2), 1.1e-3, "between 0.999 and 1 of the nominal area")],
        plasticity="on", plastic_hardness=hardness)


def pixel_effect_cases():
    wave = 0.01 * np.cos(2 * pi * 3 * np.arange(N) / N) * np.ones((N, 1))
    closing = E * (2 * pi * 3 / N) / 2 * 0.01
    # The attraction of contact is twice the pressure that closes the wave; its range is 0.974 z0.
    distance = 0.05
    reach = 9 * sqrt(3) / 16 * distance
    sticky = {"adhesion": "on", "work_of_adhesion": 2 * closing * reach,
              "equilibrium_distance": distance}
    closed = "p + E q h/2 cos(q x) (Westergaard 1939): without a gap attraction is part of p."
    for name, path in (("pull", (1.5, -0.5)), ("cycles", (1.5, -0.5) * 5 + (0.0,))):
        yield map_case(
            f"pixels_adhesion_{name}", "Adhesion keeps a wave closed under pulls; the attraction "
            "is larger than all net tractions.", closed, wave,
            loading("load", tuple(closing * N**2 * part for part in path)),
            [Value("greatest_pressure", (path[-1] + 1) * closing, 1e-7, PIXELS),
             Value("area", float(N**2), 1e-12, EXACT),
             Value("mean_gap", 0.0, 1e-9, "absolute: no gap is left")], **sticky)
    yield map_case(
        "pixels_adhesion_across_a_gap", "Two flats attract each other; none of the pixels touches.",
        "A uniform traction, w/rho exp(-g/rho).", np.full((N, N), 0.25),
        loading("separation", 2 * distance),
        [Value("load", -N**2 * 2 * closing * np.exp(-2 * distance / reach), 1e-7, PIXELS),
         Value("contacts", 0, 0.0, "a count")], **sticky)
    tau, time = 10.0, 15.0
    for name, ratio, path, more in (
            ("hold", 1e-12, 1.5, {}), ("cycles", 0.3, (1.5, 1.2, 1.5, 1.2, 1.5),
                                       {"loading_time": 1e-9})):
        relaxed = ratio + (1 - ratio) * np.exp(-time / tau)
        loads = closing * N**2 * np.array(path)
        yield map_case(
            f"pixels_creep_{name}", "A wave stays closed while its pressures relax to their mean.",
            "The displacements are constant: p + E(t) q h/2 cos(q x).", wave,
            loading("load", tuple(map(float, loads)) if more else float(loads)),
            [Value("greatest_pressure", (1.5 + relaxed) * closing, 1e-7, PIXELS),
             Value("area", float(N**2), 1e-12, EXACT)],
            creep="on", relaxation_time=tau, relaxed_modulus_ratio=ratio, hold_time=time, **more)


# ---------------------------------------------------------------- dense caps

DEEP = 5e-4
PLACES = {"pair": [(0.0, 0.0), (0.066, 0.0)],
          "triangle": [(0.0, 0.0), (0.068, 0.0), (0.034, 0.058)]}
WAYS = {"coupled": (0.02, "Hertzian pressures on circles that nearly touch"),
        "auto": (0.01, "`tolerance` of the effects"),
        "boundary": (1e-3, "`boundary_tolerance`, and the truth's own 1e-4")}


@cache
def dense_load(name):
    """Load of caps under a plane by smooth pressures on each contact (test/truth)."""
    contacts = [Contact(0.0, 0.0, 1e6, x, y, R, DEEP) for x, y in PLACES[name]]
    # The large sphere stands for the plane: at 0.07 it is 2e-9 away from it.
    return evaluate(contacts, E, ("4", "6"))["together"]


def dense_cases():
    for name, places in PLACES.items():
        for way, (tolerance, reason) in WAYS.items():
            yield ModelCase(
                f"dense_{name}_{way}", "Circles of contact are 4 to 8 % of a radius apart; `auto` "
                "must not be worse than `coupled`.",
                "Boundary equations with a polynomial for the pressure of each contact.",
                {"material": {"contact_modulus": E},
                 "loading": loading("separation", 0.5 - DEEP),
                 "effects": {"interaction": way}},
                [Value("load", partial(dense_load, name), tolerance, reason)],
                [(x, y, 0.5, R) for x, y in places])


def model_cases():
    yield from adhesion_cases()
    yield from plasticity_cases()
    yield from creep_cases()
    yield from map_cases()
    yield from pixel_effect_cases()
    yield from dense_cases()
