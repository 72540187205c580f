"""The short hexadecimal arithmetic against a System/370, and against exact whole numbers.

Always: the archived pairs, in reference_output/hex32, and random operands against exact results.
With the emulator Hercules: more pairs, under both program masks, and the archived ones again.
"""

import random
from fractions import Fraction

import mpmath
import pytest
import s370_machine
from builds import build
from hex32_against_machine import (BODIES, COUNTS, FOLDER, FRACTION, KEPT, LARGEST, MASKS, PAIRS,
                                   ROUGH, SIGN, agrees, arithmetic, compare, explained, fraction,
                                   kept, machine, machine_result, operands, shown, word)
from surfaces_csv import records

# The same words whatever build is under test: the unit tests try its rules in every build.
pytestmark = [pytest.mark.truth, pytest.mark.once]

NORMAL = [kind for kind in BODIES if not kind.endswith(ROUGH)]


@pytest.fixture(scope="module")
def program():
    return build("release").parent.parent / "example" / "hex32_words"


@pytest.mark.parametrize("kind", BODIES)
def test_archived_pairs(kind, program):
    """What the machine gave for 200 pairs of each kind."""
    pairs, left = kept()
    assert len(pairs[kind]) == KEPT and pairs[kind] == operands(kind, KEPT)
    found = arithmetic(program, kind, pairs[kind])
    rows = list(zip(pairs[kind], left[kind], found, strict=True))
    differ = [row for row in rows if not agrees(kind, *row)]
    assert kind not in NORMAL or not differ, shown((kind, "0", *differ[0]))
    assert all(explained(kind, operand, machines) for operand, machines, _ in differ)


def test_archived_counts():
    """100000 operations of each kind under each mask, no difference that is not explained, none at
    all where operands are normalised; and the page reports so."""
    lines = records(FOLDER / "counts.csv")
    assert [(line["program_mask"], line["kind"]) for line in lines] == \
        [(mask, kind) for mask in MASKS for kind in BODIES]
    for line in lines:
        assert tuple(line) == COUNTS and int(line["operations"]) == PAIRS
        assert line["differences"] == (line["explained"] if line["kind"].endswith(ROUGH) else "0")
    page = (FOLDER / "README.md").read_text(encoding="utf-8")
    for line in lines[:len(BODIES)]:
        cells = [line[name] for name in COUNTS[2:6]] + [line["divisions_by_zero"]]
        assert f"| {line['kind']} | {' | '.join(cells)} |" in page


# ---------------------------------------------------------------- exact whole numbers

NUMBER = 20_000


def value(number):
    """The value of a word."""
    size = (number & FRACTION) * Fraction(16) ** ((number >> 24 & 127) - 70)
    return -size if number & SIGN else size


def unit(number):
    """The distance from the value of a word to the next greater magnitude."""
    return Fraction(16) ** ((number >> 24 & 127) - 70)


@pytest.mark.parametrize("kind", ["AE", "SE", "ME", "DE", "CE"])
def test_random_pairs(kind, program):
    """Sums keep one guard digit, products and quotients are cut; over- and underflow."""
    pairs = operands(kind, NUMBER)
    for operand, found in zip(pairs, arithmetic(program, kind, pairs), strict=True):
        result, condition = machine_result(kind, *operand)
        assert agrees(kind, operand, (result, condition, 0), found), \
            shown((kind, "none", operand, (result, condition, 0), found))


def test_random_roots(program):
    """Within one unit of the exact root, and not always the nearest number: the method of the
    FORTRAN library misses it in about 36 of 1000, by a model of the method in exact fractions."""
    rng = random.Random("SQRT")
    pairs = [(word(0, rng.randrange(128), rng.randrange(0x100000, 0x1000000)), 0)
             for _ in range(NUMBER)]
    missed = 0
    for (operand, _), (root, _) in zip(pairs, arithmetic(program, "SQRT", pairs), strict=True):
        low, half, exact = value(root) - unit(root), unit(root) / 2, value(operand)
        assert max(low, 0) ** 2 < exact < (value(root) + unit(root)) ** 2, f"{operand:08X}"
        missed += not (value(root) - half) ** 2 <= exact < (value(root) + half) ** 2
    assert 0.032 < missed / NUMBER < 0.041


def test_random_powers(program):
    """x**1.5 is the nearest number, ties upwards; 64 times an odd square makes ties."""
    rng = random.Random("POWER")
    words = [word(0, rng.randrange(23, 106), fraction(rng)) for _ in range(NUMBER)]
    words += [word(0, 65, 64 * odd**2) for odd in range(129, 321, 2)]
    ties = 0
    for operand, (power, _) in zip(words, arithmetic(program, "POWER", [(w, 0) for w in words]),
                                   strict=True):
        cube, result, half = value(operand) ** 3, value(power), unit(power) / 2
        below = half / 16 if power & FRACTION == 0x100000 else half
        assert (result - below) ** 2 <= cube < (result + half) ** 2, f"{operand:08X}"
        ties += (result - half) ** 2 == cube
    assert ties > 10


@pytest.mark.parametrize("kind, function", [("SIN", mpmath.sin), ("COS", mpmath.cos)])
def test_random_angles(kind, function, program):
    """Sine and cosine of 1e-6 rad to the largest number are the nearest numbers."""
    rng = random.Random(kind)
    words = [word(rng.getrandbits(1), rng.randrange(60, 128), fraction(rng))
             for _ in range(NUMBER)]
    with mpmath.workdps(30):
        for operand, (found, _) in zip(words, arithmetic(program, kind, [(w, 0) for w in words]),
                                       strict=True):
            angle, result = value(operand), value(found)
            exact = function(mpmath.mpf(angle.numerator) / angle.denominator)
            off = exact - mpmath.mpf(result.numerator) / result.denominator
            below = 16 if found & FRACTION == 0x100000 and abs(exact) < abs(result) else 1
            size = unit(found)
            assert abs(off) * 2 * below <= mpmath.mpf(size.numerator) / size.denominator, \
                f"{operand:08X}"


def test_random_decimals(program):
    """A decimal number is cut to six digits; beyond the range it is the largest number or zero."""
    rng = random.Random("DECIMAL")
    pairs = [(rng.getrandbits(31) >> rng.randrange(31), rng.randrange(-120, 121) // (1 + i % 3))
             for i in range(NUMBER)]
    given = [(digits, power & 0xFFFFFFFF) for digits, power in pairs]
    smallest = value(0x00100000)
    for (digits, power), (found, _) in zip(pairs, arithmetic(program, "DECIMAL", given),
                                           strict=True):
        exact = digits * Fraction(10) ** power
        if found == 0:
            assert exact < smallest, f"{digits}e{power}"
        else:
            assert value(found) <= exact, f"{digits}e{power}"
            assert found == LARGEST or exact < value(found) + unit(found), f"{digits}e{power}"


@pytest.mark.skipif(not s370_machine.is_here(), reason=s370_machine.MISSING)
def test_on_the_machine(program):
    """Fewer pairs than are archived, as they take a second."""
    number = 1000
    lines, _, strange = compare(program, number)
    assert not strange, shown(strange[0])
    assert sum(line["operations"] for line in lines) == 2 * number * len(BODIES)
    assert all(line["differences"] == 0 for line in lines if not line["kind"].endswith(ROUGH))
    assert all(sum(line[name] for line in lines) > 100
               for name in ("overflows", "underflows", "divisions_by_zero"))


@pytest.mark.skipif(not s370_machine.is_here(), reason=s370_machine.MISSING)
def test_the_archive_is_the_machine_s():
    pairs, left = kept()
    assert machine(pairs, 0) == left
