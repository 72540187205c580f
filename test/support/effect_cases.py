"""Hard cases for the effects of neighbours and of friction: scenes, and laws that they must keep.

`make_cases.py` writes them to data/hard/effects. Every case ends with results or with one sentence,
in the time that it has. Where a truth is known, `truth` computes it here, from closed forms or
independently of the program.
"""

from dataclasses import dataclass
from math import sqrt

from cases import approach, limit
from judge import check, number

MODULUS = (2.0e5, 1.0e5)
RATIO = (0.3, 0.25)
COUPLED, BOUNDARY, AUTO = "coupled", "boundary", "auto"
WAYS = (COUPLED, BOUNDARY, AUTO)

TOO_MUCH = "the load is larger than the surfaces carry"


@dataclass
class EffectCase:
    """A scene with effects.

    refused: part of the sentence that is demanded; `either`: a result will do as well. laws: what
    its results must keep beside the laws of all cases.
    """

    name: str
    why: str
    upper: list
    lower: list
    groups: dict
    laws: tuple = ()
    truth: str = "The laws of all results."
    refused: str = ""
    either: bool = False
    modulus: tuple = MODULUS
    ratio: tuple = RATIO


# ---------------------------------------------------------------- closed forms

def combined(modulus=MODULUS, ratio=RATIO):
    return 1.0 / sum((1.0 - n * n) / e for e, n in zip(modulus, ratio))


def hertz(radius, penetration, modulus=None):
    """Load of an aligned pair."""
    return 4.0 / 3.0 * (modulus or combined()) * sqrt(radius) * penetration ** 1.5


# ---------------------------------------------------------------- laws

def total(true, share, column="load"):
    """A total of the last position."""
    def law(solved):
        check(column, number(solved.positions[-1], column), true, share)
    return law


def factor(true, share):
    return total(true, share, "factor")


def count(least, most=None):
    """How many contacts there are."""
    def law(solved):
        n = int(solved.positions[-1]["contacts"])
        assert least <= n <= (most or least), f"{n} contacts"
    return law


def nothing_at_all(solved):
    for row in solved.positions:
        assert int(row["contacts"]) == 0 and number(row, "load") == 0.0
    assert not solved.contacts


def all_slide(solved):
    for row in solved.contacts:
        assert int(float(row["sliding"])) == 1
        check("T", number(row, "tangential_load"), number(row, "load") * 1e-300, 1e-9)


def no_tangential_load(solved):
    for row in solved.contacts:
        assert number(row, "tangential_load") == 0.0
    for row in solved.positions:
        check("vertical", number(row, "vertical_load"), number(row, "frictionless_load"), 1e-15)


def nothing_slides(solved):
    for row in solved.contacts:
        assert int(float(row["sliding"])) == 0
        assert number(row, "slip_annulus") == 0.0


# ---------------------------------------------------------------- scenes

def effects(**values):
    return {"effects": values}


def load(value, **other):
    return {"loading": {"control": "load", "value": value, **other}}


FLAT = [(0.0, 0.0, 0.0, 1.0e6)]
# Combined radius of a cap of radius 1 on it.
FLAT_RADIUS = FLAT[0][3] / (1.0 + FLAT[0][3])


def caps(places, radius=1.0, height=0.5):
    """Caps on the upper surface over a sphere as good as flat."""
    return [(x, y, height, radius) for x, y in places]


ONE = [(0.0, 0.0, 0.5, 1.0)], [(0.0, 0.0, 0.5, 1.0)]
# One presses 1e-3 into a plane, the other, 0.02 beside, 2e-5.
OPENED = [(0.0, 0.0, 0.5, 1.0), (0.04, 0.0, 0.49905, 1.0)], FLAT


def in_one_place():
    for n in (2, 5, 10):
        upper = caps([(0.0, 0.0)] * n)
        groups = approach(0.499)
        for way in WAYS:
            exact = 1e-9 if way == COUPLED else 2e-3
            one = (factor(1.0 / n, exact), total(hertz(FLAT_RADIUS, 1e-3), exact))
            yield EffectCase(
                f"coincident_{n}_{way}", f"{n} equal contacts in one place are one contact.",
                upper, FLAT, {**groups, **effects(interaction=way)}, (*one, count(1)),
                "Hertz's load of one of them: 1/n of the sum.")
            yield EffectCase(
                f"as_good_as_coincident_{n}_{way}",
                f"{n} equal contacts 1e-12 apart: their differences are all rounding.",
                caps([(1e-12 * i, 0.0) for i in range(n)]), FLAT,
                {**groups, **effects(interaction=way)}, one, "As for coincident contacts.")
    yield EffectCase(
        "as_good_as_coincident_load", "Five contacts 1e-12 apart under a load: which of them stay "
        "is open, the load is not.", *(caps([(1e-12 * i, 0.0) for i in range(5)]),
                                        [(0.1, 0.0, 0.5, 0.75)]),
        {**load(0.001), **effects(interaction=COUPLED)}, (total(0.001, 1e-9),),
        "The load is met.")


def how_many():
    packed = [(0.01 * i - 0.05, 0.01 * j - 0.05, 0.5 - 1e-8 * (37 * (10 * i + j) % 100), 1.0)
              for i in range(10) for j in range(10)]
    yield EffectCase(
        "packed_100_coupled", "100 caps ten times nearer to each other than their circles are "
        "wide: all but a few open.", packed, FLAT,
        {**approach(0.49), **effects(interaction=COUPLED)}, truth="The laws of all results.")
    for way in WAYS:
        yield EffectCase(
            f"one_contact_{way}", "One contact has no neighbour: Hertz.", *ONE,
            {**approach(1.0 - 1e-4), **effects(interaction=way)},
            (total(hertz(0.5, 1.0 - (1.0 - 1e-4)), 1e-3 if way == BOUNDARY else 1e-11), count(1)),
            "Hertz's closed form.")
        yield EffectCase(
            f"no_contact_{way}", "Nothing touches at this approach.", *ONE,
            {**approach(1.25), **effects(interaction=way, friction="on",
                                         friction_coefficient=0.1)},
            (nothing_at_all,), "No load.")
        yield EffectCase(
            f"no_pair_{way}", "The asperities pass beside each other.",
            [(9.0, 0.0, 0.5, 1.0)], [(0.0, 0.0, 0.5, 1.0)],
            {**limit(1.0), **effects(interaction=way, friction="auto",
                                     friction_coefficient=0.1)}, (nothing_at_all,), "No load.")


def how_deep():
    pair = caps([(5e-5, 0.0), (-5e-5, 0.0)]), FLAT
    for way in WAYS:
        yield EffectCase(
            f"penetration_1e-12_{way}", "Two contacts 1e-12 deep, 1e-6 wide, 1e-4 apart.", *pair,
            {**approach(0.5 - 1e-12), **effects(interaction=way)},
            (total(2 * hertz(FLAT_RADIUS, 0.5 - (0.5 - 1e-12)) , 1.2e-2),
             count(2)), "Hertz. They take 0.6 % from each other.")
    tiny = {"tiny": 1e-30, "hardly_any": 1e-300}
    for name, value in tiny.items():
        for way in (COUPLED, BOUNDARY):
            yield EffectCase(
                f"load_{name}_{way}", f"A load of {value!r} on one pair.", *ONE,
                {**load(value), **effects(interaction=way)},
                (total(value, 1.1e-3 if way == BOUNDARY else 1e-9),),
                "The load is met; at 1e-300 cells may say that the contact is too shallow.",
                refused="below the resolution of boundary"
                if name == "hardly_any" and way == BOUNDARY else "", either=True)
    for name, value in (("beyond_all", 1e9), ("huge", 1e300)):
        for way in WAYS:
            yield EffectCase(
                f"load_{name}_{way}", f"A load of {value!r}: no closing can bring it.",
                *(caps([(0.0, 0.0), (0.01, 0.0)], radius=1.0), [(0.0, 0.0, 0.5, 1.0)]),
                {**load(value), **effects(interaction=way)}, refused=TOO_MUCH,
                truth="A refusal that says so.")


def how_unlike():
    for small in (1e-3, 1e3):
        upper = [(0.0, 0.0, 5e-4, 1e-3), (0.5, 0.0, 5e-4, 1e3)]
        for way in WAYS:
            yield EffectCase(
                f"radii_{small:g}_{way}", "Radii of 1e-3 and 1e3 beside each other.",
                upper, [(0.0, 0.0, 0.0, 1e3 / small)],
                {**approach(5e-4 - 1e-6), **effects(interaction=way)},
                truth="The laws of all results, or a refusal that cells are too many.",
                refused="the boundary elements would" if way != COUPLED else "", either=True)
    for way in WAYS:
        # The wide contact has a circle of 0.1; the sharp one stands at 0.02 in it.
        yield EffectCase(
            f"inside_circle_{way}", "A small contact inside a wide one's circle.",
            [(0.0, 0.0, 0.05, 10.0), (0.02, 0.0, 0.0505, 0.05)], [(0.0, 0.0, 0.0, 1e6)],
            {**approach(0.049), **effects(interaction=way)},
            truth="The laws of all results, or a refusal that cells are too many.",
            refused="the boundary elements would" if way != COUPLED else "", either=way != COUPLED)
        yield EffectCase(
            f"opened_{way}", "A contact that its neighbour's displacement opens.", *OPENED,
            {**approach(0.499), **effects(interaction=way)},
            (count(1), total(hertz(FLAT_RADIUS, 0.5 - 0.499), 2e-3)),
            "At 0.04 the neighbour, circle 0.0316, moves the surface by more than the 5e-5 that "
            "the second contact has: Hertz's load of the first alone.")


def how_steep():
    pairs = {}
    for slope in (1.0, 10.0, 100.0):
        plan = 2.0 * slope / sqrt(1.0 + slope * slope)
        pairs[slope] = [(plan, 0.0, 0.5, 1.0)], [(0.0, 0.0, 0.5, 1.0)]
        for name, mu in (("0", 0.0), ("1e-300", 1e-300), ("0.3", 0.3), ("1e300", 1e300)):
            yield EffectCase(
                f"slope_{slope:g}_friction_{name}",
                f"Slope {slope:g} at first touch, coefficient {name}.",
                *pairs[slope],
                {**load(1e-3), **effects(friction="on", friction_coefficient=mu)},
                {"0": (no_tangential_load,), "1e-300": (all_slide,), "0.3": (),
                 "1e300": (nothing_slides,)}[name],
                "friction_truth.closed_form, with mpmath.")
    for way in (COUPLED, BOUNDARY):
        yield EffectCase(
            f"slope_10_load_{way}", "A load on one pair that touches at a slope of 10.",
            *pairs[10.0], {**load(1e-6), **effects(interaction=way)},
            (total(1e-6, 1e-2 if way == BOUNDARY else 1e-9),), "The load is met.")
    far = 2.0 ** 340
    yield EffectCase(
        "moment_beyond_doubles", "Loads near 1e207 at lengths near 1e102: the rig's moment, their "
        "product, is beyond a double.", [(0.3 * far, 0.0, 0.5 * far, far)],
        [(0.0, 0.0, 0.5 * far, far)],
        {**load(500.0 * far * far), **effects(friction="on", friction_coefficient=0.2)},
        truth="A refusal that says so.", refused="beyond the range of a double")
    for ratio in ((-0.99, -0.99), (0.5, 0.5), (-0.99, 0.5)):
        yield EffectCase(
            f"friction_poisson_{ratio[0]:g}_{ratio[1]:g}",
            "Poisson's ratios at their ends: kappa is largest and least there.",
            *pairs[1.0], {**load(1e-3), **effects(friction="on", friction_coefficient=0.9)},
            truth="friction_truth.closed_form, with mpmath.", ratio=ratio)
        yield EffectCase(
            f"interaction_poisson_{ratio[0]:g}_{ratio[1]:g}",
            "The same for two contacts that lower each other.",
            caps([(0.0, 0.0), (0.1, 0.0)]), FLAT,
            {**approach(0.4995), **effects(interaction=COUPLED)},
            truth="The factor does not know the material.", ratio=ratio)


THREE = [(0.0, 0.0, 0.5, 1.0), (0.12, 0.02, 0.4998, 1.1), (0.03, 0.13, 0.4999, 0.9)], FLAT


def how_exact():
    for name, value in (("1e-12", 1e-12), ("0.999", 0.999)):
        for way in ("interaction", "friction"):
            too_many = way == "interaction" and value < 0.5
            yield EffectCase(
                f"tolerance_{name}_{way}", f"`auto` with a tolerance of {name}.", *THREE,
                {**load(100.0), **effects(**{way: AUTO}, tolerance=value,
                                          friction_coefficient=0.1)},
                (total(100.0, 2e-3 if value < 0.5 else 1.0),),
                "A refusal that cells are too many." if too_many else "The load is met.",
                refused="the boundary elements would" if too_many else "")
    yield EffectCase(
        "boundary_tolerance_0.9", "Cells halved until the load moves by 0.9.", *THREE,
        {**approach(0.4995), **effects(interaction=BOUNDARY, boundary_tolerance=0.9)},
        truth="The laws of all results, or a refusal that cells are too many.")
    for way in WAYS:
        yield EffectCase(
            f"curve_{way}", "A curve of 50 states: each is solved.", *THREE,
            {**load(50.0, points=50), **effects(interaction=way, friction="auto",
                                                friction_coefficient=0.2)},
            (total(50.0, 1.1e-2 if way == AUTO else 1.1e-3),), "Loads rise along the curve.")
    yield EffectCase(
        "positions_200_all_auto", "200 positions, each with its own choice of effects.",
        [(0.0, 0.0, 0.5, 1.0), (0.4, 0.1, 0.49, 0.8), (0.1, 0.4, 0.48, 1.2)],
        [(0.0, 0.0, 0.5, 1.0), (0.9, 0.1, 0.45, 0.7), (2.0, -0.1, 0.5, 1.0), (3.1, 0.3, 0.4, 2.0)],
        {"motion": {"x_step": 0.02, "positions": 200}, **limit(20.0),
         **effects(interaction=AUTO, friction=AUTO, friction_coefficient=0.2)},
        truth="The laws of all results at every position.")


def effect_cases():
    """All cases with effects."""
    for part in (in_one_place, how_many, how_deep, how_unlike, how_steep, how_exact):
        yield from part()
