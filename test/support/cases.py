"""The catalogue of hard cases: what each is, why it is hard, where its truth comes from.

`make_cases.py` writes them to data/hard; `test_hard.py` runs them.
"""

from dataclasses import dataclass

GEOMETRY = "Geometry and Hertz with {} digits, from the numbers as the arithmetic holds them."
NOTHING = "No pair is near enough in plan: nothing touches, whatever the closing."
TOO_SMALL = "too small for this arithmetic"
TOO_MUCH = "the load is larger than the surfaces carry"
LEVEL = "come level"
NO_PAIR = "no pair of asperities can touch"

# Radii 3 and 2, a plan distance of 3: a triangle of 3, 4, 5, so that first touch is exact. With
# heights 1 and 0 it falls on the approach 0.
TRIANGLE = ([(3.0, 0.0, 1.0, 3.0)], [(0.0, 0.0, 0.0, 2.0)])


@dataclass
class Case:
    """A scene with two surfaces of asperities (x, y, height, radius).

    refused: the message of a refusal. coordinates: whether rounding of the coordinates limits
    the results. digits: those of the truth. positions: those compared; all by default.
    """

    name: str
    why: str
    upper: list
    lower: list
    groups: dict
    modulus: tuple = (2.0e5, 1.0e5)
    ratio: tuple = (0.3, 0.25)
    truth: str = ""
    refused: str = ""
    coordinates: bool = False
    digits: int = 60
    positions: tuple = ()

    def __post_init__(self):
        if not self.truth:
            self.truth = GEOMETRY.format(self.digits)


def load(value):
    return {"loading": {"control": "load", "value": value}}


def approach(value, **other):
    return {"loading": {"control": "approach", "value": value, **other}}


def limit(value, criterion="load"):
    name = {"greenwood_williamson": "hardness", "hardy": "yield_stress"}.get(criterion, "value")
    return {"limit": {"criterion": criterion, name: value}}


def grid(rows, columns, pitch, height, radius, offset=(0.0, 0.0)):
    return [(offset[0] + pitch * i, offset[1] + pitch * j, height, radius)
            for i in range(columns) for j in range(rows)]


def scaled(rows, factor):
    return [tuple(c * factor for c in row) for row in rows]


def grazing():
    """Plan distances a few units of the last place from 0.5 (candidates) and from 2 (RU + RL)."""
    for bits, who in ((20, "single precision"), (49, "double precision")):
        for side, sign in (("inside", -1), ("outside", 1)):
            yield Case(
                f"candidate_{side}_{bits}",
                f"The plan distance is 2**-{bits} {side} the candidate distance: a few units of "
                f"the last place in {who}.",
                [(0.5 + sign * 2.0 ** -bits, 0.0, 0.0625, 1.25)], [(0.0, 0.0, 0.0625, 0.75)],
                limit(1.0))
        pair = [(2.0 - 2.0 ** -bits, 0.0, 1.0, 1.25)], [(0.0, 0.0, 1.0, 0.75)]
        small = 6.0e4 * 2.0 ** (-1.5 * (bits + 2))
        yield Case(
            f"sideways_load_{bits}",
            f"The plan distance is 2**-{bits} less than RU + RL: the slope at first touch is about "
            f"2**{bits // 2}, and that distance is all the overlap there can be.", *pair,
            load(small))
        yield Case(
            f"sideways_limit_{bits}",
            "The same pair closed to a limit: RU + RL less the overlap at the limit rounds by as "
            "much as it exceeds the plan distance.", *pair, limit(2 * small))
        yield Case(
            f"sideways_outside_{bits}",
            f"The plan distance is RU + RL or 2**-{bits} more: the spheres pass without touching.",
            [(2.0 + 2.0 ** -bits, 0.0, 1.0, 1.25), (0.0, 2.0, 1.0, 1.25)], [(0.0, 0.0, 1.0, 0.75)],
            limit(1.0), truth=NOTHING)


def penetrations():
    for power, digits in ((3, 60), (8, 60), (15, 60), (100, 400)):
        yield Case(
            f"penetration_1e-{power}",
            f"Pressed 1e-{power} of a radius past first touch: RU + RL less the distance of the "
            "centres has no digits left.",
            *TRIANGLE, approach(float(f"-3e-{power}")), digits=digits)


def ties():
    rows = grid(1, 10, 1.0, 0.5, 1.0)
    for count in (2, 10):
        yield Case(
            f"ties_{count}", f"{count} pairs touch at once: none may be left out or counted twice.",
            rows[:count], [(x + 0.25, y + 0.125, 0.0, 0.75) for x, y, _, _ in rows[:count]],
            load(7.0))
    yield Case(
        "ties_all", "Every pair there is touches at once, 25 of 25.",
        [(0.0, 0.0, 0.5, 1.0)] * 5, [(0.25, 0.125, 0.0, 0.75)] * 5, limit(3.0))
    for bits, who in ((22, "single"), (51, "double")):
        yield Case(
            f"near_ties_{bits}",
            f"Ten pairs touch within 2**-{bits} of each other: a few units of the last place in "
            f"{who} precision. Their order must not spoil their loads.",
            [(x, y, 0.5 - (7 * i % 10) * 2.0 ** -bits, r) for i, (x, y, _, r) in enumerate(rows)],
            [(x + 0.25, y + 0.125, 0.0, 0.75) for x, y, _, _ in rows], load(7.0),
            coordinates=True)
    yield Case(
        "coincident", "Three upper asperities in one place over two lower ones in one place.",
        [(0.125, 0.25, 0.5, 1.0)] * 3, [(0.5, 0.25, 0.125, 0.75)] * 2, load(11.0))
    yield Case("one_pair", "One asperity a surface.", [(0.3, 0.1, 0.4, 1.1)],
               [(0.1, 0.2, 0.3, 0.9)], limit(2.0))
    spread = [(0.1 * i, 0.07 * j, 0.5 + 0.001 * ((3 * i + 5 * j) % 7), 100.0)
              for i in range(4) for j in range(3)]
    yield Case(
        "all_in_contact", "All 144 pairs of 12 and 12 asperities are in contact: four times the "
        "places in the original's list.", spread,
        [(x + 0.05, y + 0.02, h, 80.0) for x, y, h, _ in spread], approach(0.75),
        coordinates=True)
    lattice = grid(7, 7, 2.0, 0.5, 1.0)
    yield Case(
        "more_than_37", "49 pairs in contact, each far from the others: more than the original's "
        "list of 37 places holds.", lattice,
        [(x + 0.0625, y, h + 0.0009765625 * (i % 5), 0.75)
         for i, (x, y, h, _) in enumerate(lattice)], approach(0.9375), coordinates=True)


def materials():
    pair = [(0.5, 0.25, 0.5, 1.0)], [(0.25, 0.125, 0.25, 0.75)]
    yield Case("moduli_1e12", "The moduli differ by 1e12: all compliance is the soft surface's.",
               *pair, limit(1.0e-7), modulus=(2.0e11, 0.2))
    yield Case("rigid", "The lower surface is as good as rigid: 1e280 against 1.",
               *pair, limit(1.0e-3), modulus=(1.0, 1.0e280))
    yield Case("stiff", "Both surfaces have a modulus of 1e280: short numbers have no room for it.",
               *pair, limit(1.0e277), modulus=(1.0e280, 1.0e280))
    yield Case("poisson_half", "Poisson's ratio 0.5, the largest there is, on both surfaces.",
               *pair, limit(1.0), ratio=(0.5, 0.5))
    yield Case("poisson_minus_1", "Poisson's ratio just above -1: 1 - nu**2 is a small "
               "difference.", *pair, limit(1.0), ratio=(-0.999999, 0.25), coordinates=True)
    yield Case("radii_1e6", "Radii 1e6 apart: the sum of the radii has no room for the small one.",
               [(0.0, 0.0, 5.0e-4, 1.0e3)], [(2.0e-4, 1.0e-4, 4.0e-4, 1.0e-3),
                                             (1.0, 1.0e-4, 3.0e-4, 1.0e-3)], limit(1.0e-3))
    yield Case("load_beyond_all", "The target load is more than any closing can bring.",
               *pair, load(1.0e9), refused=TOO_MUCH)
    yield Case("load_1e300", "A target load near the largest number.", *pair, load(1.0e300),
               refused=TOO_MUCH)
    # In the units of the solver the smallest normal number is subnormal, with 35 bits.
    for name, value, message in (("1e-300", 1.0e-300, ""),
                                 ("smallest_normal", 2.2250738585072014e-308, TOO_SMALL)):
        yield Case(f"load_{name}", f"A target load of {value!r}: the overlap is about 1e-203.",
                   *pair, load(value), digits=500, refused=message)
        yield Case(f"limit_{name}", f"A limit load of {value!r}: reached at first touch.",
                   *pair, limit(value), digits=500, refused=message)
    for power, digits, message in ((90, 500, ""), (150, 700, TOO_SMALL)):
        yield Case(f"limit_pressure_1e-{power}",
                   f"A limit pressure of 1e-{power}: reached at first touch, at an overlap of "
                   f"about 1e-{2 * power + 10}.", *pair, limit(float(f"1e-{power}"), "pressure"),
                   digits=digits, refused=message)
    yield Case("limit_never", "No pair can reach this limit before its centres are level.",
               *pair, limit(1.0e9), refused="no pair of asperities reaches the limit")


def lengths():
    """One scene in many units. The pressure limit is the same in all; loads go by the square."""
    upper = [(0.5, 0.25, 0.5, 1.0), (1.75, 0.375, 0.4375, 1.125)]
    lower = [(0.25, 0.125, 0.25, 0.75), (1.5, 0.75, 0.3125, 0.8125)]
    pressed = limit(2.0e4, "pressure")
    yield Case("unit_base", "The scene that the next ones scale: lengths near 1.",
               upper, lower, pressed, coordinates=True)
    for power in (3, 40, -72, 500, -500):
        yield Case(
            f"unit_2^{power}",
            f"Lengths times 2**{power}: results must be unit_base's, scaled, bit for bit.",
            scaled(upper, 2.0 ** power), scaled(lower, 2.0 ** power), pressed, coordinates=True,
            truth="unit_base times 2**k (areas and loads 4**k), and as there.")
    for name, power in (("metres", -3), ("nanometres", 6), ("light_years", -19)):
        yield Case(
            f"unit_{name}", f"Millimetres written in {name.replace('_', ' ')}, a factor of "
            f"1e{power}: equal within rounding.", scaled(upper, float(f"1e{power}")),
            scaled(lower, float(f"1e{power}")), pressed, coordinates=True)
    far = 1.0e6
    yield Case(
        "offset_1e6", "All coordinates carry a common offset of 1e6 radii: their difference is "
        "exact, their rounding (0.06 radii in real32, 1 in ibm370) is not undone by anything.",
        [(x + far, y - far, h, r) for x, y, h, r in upper],
        [(x + far, y - far, h, r) for x, y, h, r in lower], pressed, coordinates=True)


def motions():
    for name, count, where in (
            ("ten_thousand", 10000, (1, 2, 3333, 7777, 9999, 10000)),
            ("a_million", 1000000, (1, 2, 333333, 777777, 999999, 1000000))):
        yield Case(
            f"positions_{name}", f"{name.replace('_', ' ').capitalize()} positions over a tenth of "
            "a radius: a displacement that is summed step by step drifts.",
            [(0.0, 0.0, 0.5, 1.0)], [(0.0, 0.125, 0.25, 0.75)],
            {"motion": {"x_first": -0.05, "x_step": 0.1 / count, "positions": count}, **limit(1.0)},
            coordinates=True, positions=where)
    step = {"motion": {"x_step": 1.0, "positions": 6}}
    spots = [(0.0, 0.0, 0.125, 1.0), (1.25, 0.0, 0.125, 1.0), (5.0, 0.0, 0.125, 1.0)]
    one = [(0.0, 0.0, 0.125, 1.0)]
    yield Case("none_at_some", "Contact, none, contact again: what one position leaves must not "
               "reach the next.", one, [(x, 0.0, 0.125, 1.0) for x in (0.0, 0.75, 5.25)],
               {**step, **limit(1.0)}, coordinates=True)
    yield Case("none_at_one", "No pair that can touch at one position of six.", one,
               [(x, 0.0, 0.125, 1.0) for x in (-0.25, 4.25, 5.0)],
               {**step, **limit(1.0)}, coordinates=True)
    yield Case("none_at_all", "No pair that can touch at any position.", one,
               [(0.0, 3.0, 0.125, 1.0)], {**step, **limit(1.0)}, truth=NOTHING)
    yield Case("far_under_load", "At the third position all pairs are beyond the candidate "
               "distance, but a load must be borne: the planes pass through each other.",
               one, spots, {**step, **load(1.0)}, coordinates=True)
    yield Case("none_under_load", "At the second position no spheres are less than RU + RL apart "
               "in plan: no closing can bring a load.", one,
               [(0.0, 0.0, 0.125, 1.0), (9.0, 0.0, 0.125, 1.0)],
               {"motion": {"x_step": 3.0, "positions": 4}, **load(1.0)},
               refused="position 2: " + NO_PAIR)
    yield Case("wraps", "The surface comes from far, slides over whole lattice pitches and is "
               "gone: from none to contact and to none.", grid(1, 3, 4.0, 0.125, 1.0),
               grid(1, 3, 4.0, 0.125, 1.0, (0.25, 0.0)),
               {"motion": {"x_first": -12.0, "x_step": 4.0, "positions": 7}, **limit(1.0)},
               coordinates=True)
    tall = [(0.0, 0.0, 1.0, 1.0), (3.75, 0.0, 1.0, 1.0)]
    low = [(1.875, 0.0, 1.0, 1.0), (3.75, 0.0, 1.0, 1.0)]
    yield Case("tilt_sideways", "The plate's slope of 2 lifts far pairs over near ones: they touch "
               "sideways first, at a slope of 2.7.", tall, low,
               {"tilt": {"upper_slope": (2.0, 0.0)}, **limit(1.0)}, coordinates=True)
    yield Case("tilt_level", "Tilted so steeply that the first pair at its limit would leave "
               "another one with level centres.", tall, low,
               {"tilt": {"upper_slope": (2.0, 0.0)}, **limit(1.0e5)},
               refused=LEVEL)
    yield Case("approach_level", "An approach at which the centres of the pair are past level.",
               *TRIANGLE, approach(-4.5), refused=LEVEL)
    yield Case("approach_before_touch", "An approach at which nothing touches yet, by one unit of "
               "the last place of double precision.", *TRIANGLE, approach(2.0 ** -52),
               truth="The pair touches at 0, exactly.")


def scenes():
    """All scene cases."""
    for part in (grazing, penetrations, ties, materials, lengths, motions):
        yield from part()
