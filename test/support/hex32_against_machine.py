"""The short hexadecimal arithmetic of the historic wing against a System/370, bit for bit.

    python test/support/hex32_against_machine.py EXECUTABLE [PAIRS]

draws pairs of operands for every kind of operation (100000, or PAIRS), runs them on the machine
(s370_machine.py) under both program masks and through `hex32_words`, the arithmetic of the build
that EXECUTABLE belongs to. With 100000 it writes reference_output/hex32.

What the machine leaves after an interruption becomes what the FORTRAN library put in its place:
the largest magnitude after overflow, zero after underflow, and for a division by zero the largest
magnitude, or zero for 0/0. A zero with a sign counts as zero: the arithmetic has one zero.
"""

import array
import csv
import hashlib
import random
import sys
import tempfile
from collections import Counter
from pathlib import Path

import s370_machine
from programs import run_program
from s370_machine import BODIES, DIVIDE_CODE, OVERFLOW_CODE, UNDERFLOW, WHOLE

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "reference_output" / "hex32"
PAIRS, KEPT, AT_ONCE = 100_000, 200, 6
SIGN, FRACTION, LARGEST = 1 << 31, 0xFFFFFF, 0x7FFFFFFF
ROUGH = " unnormalised"
MASKS = {"0": 0, "underflow": UNDERFLOW}
COUNTS = ("kind", "program_mask", "operations", "differences", "explained", "overflows",
          "underflows", "divisions_by_zero", "signed_zeros", "sha256_of_operands",
          "sha256_of_results")


# ---------------------------------------------------------------- operands

def fraction(rng):
    """Six digits, the first not zero; now and then all ones, a power of two, few digits."""
    choice = rng.randrange(8)
    if choice == 0:
        return rng.choice((0x100000, 0x100001, 0x800000, 0xFFFFFF, 0xFFFFFE, 0x7FFFFF, 0x1FFFFF))
    if choice == 1:
        return rng.randrange(0x100, 0x1000) << 12
    return rng.randrange(0x100000, 0x1000000)


def word(sign, characteristic, digits):
    return sign << 31 | min(max(characteristic, 0), 127) << 24 | digits


def pair(rng, kind):
    """Two operands, by one of several ways to be difficult."""
    way, signs = rng.randrange(20), (rng.getrandbits(1), rng.getrandbits(1))
    c, a, b = rng.randrange(128), fraction(rng), fraction(rng)
    if kind in ("FLOAT", "FIX", "FIX-AU", "SQRT"):
        return single(rng, kind, signs[0], way, a)
    if way < 4:       # any two
        return word(signs[0], c, a), word(signs[1], rng.randrange(128), b)
    if way < 9:       # exponents near each other
        return word(signs[0], c, a), word(signs[1], c + rng.randrange(-7, 8), b)
    if way < 12:      # nearly equal, of either sign, or one digit apart at a power of 16
        if rng.randrange(4) == 0:
            return word(signs[0], c, 0x100000 + rng.randrange(16)), \
                word(signs[1], c - 1, 0xFFFFFF - rng.randrange(16))
        return word(signs[0], c, a), \
            word(signs[1], c, min(max(a + rng.randrange(-16, 17), 0x100000), FRACTION))
    if way < 14:      # the guard digit: the shifted one has one digit more than fits
        shift = rng.randrange(1, 8)
        low = rng.randrange(1, 16) << 4 * min(shift - 1, 5)
        return word(signs[0], c, rng.choice((0x100000, a))), \
            word(signs[1], c - shift, 0x100000 | low & FRACTION)
    if way < 18:      # ends of the range, of sums, products or quotients
        sizes = {"ME": (64, 192), "DE": (-64, 64)}.get(kind[:2])
        if sizes is None:
            low = rng.getrandbits(1)
            return tuple(word(s, rng.randrange(3) if low else 127 - rng.randrange(3), f)
                         for s, f in zip(signs, (a, b), strict=True))
        other = rng.choice(sizes) + rng.randrange(-2, 3)
        return word(signs[0], c, a), word(signs[1], other - c if kind[:2] == "ME" else c - other, b)
    if way < 19:      # zero, with and without sign, on one side or both
        return rng.choice(((0, word(signs[1], c, b)), (word(signs[0], c, a), 0), (0, 0),
                           (SIGN, word(signs[1], c, b)), (word(signs[0], c, a), SIGN), (SIGN, 0)))
    return word(signs[0], c, a), word(signs[1], c, a)


def single(rng, kind, sign, way, digits):
    """The operand of a conversion or a root, and nothing."""
    if kind == "FLOAT":
        size = rng.getrandbits(rng.randrange(1, 32))
        return (-size & 0xFFFFFFFF if sign else size if way else 0x80000000), 0
    if kind == "SQRT":
        return word(0, rng.randrange(128), digits), 0
    most = 70 if kind == "FIX-AU" else 72
    if way == 0:
        return sign << 31, 0
    characteristic = rng.randrange(60, most + 1)
    # Whole parts below 2**31.
    return word(sign, characteristic, digits >> 1 | 0x100000 if characteristic == 72 and
                digits >= 0x800000 else digits), 0


def roughened(rng, operand):
    """The same word with zeros before its digits, or none but zeros."""
    digits = (operand & FRACTION) >> 4 * rng.randrange(6)
    return operand & ~FRACTION | (0 if rng.randrange(20) == 0 else digits)


def operands(kind, number):
    """The pairs of a kind; the first of many are those of few."""
    rng = random.Random(kind)
    drawn = []
    for _ in range(number):
        a, b = pair(rng, kind)
        drawn.append((roughened(rng, a), roughened(rng, b)) if kind.endswith(ROUGH) else (a, b))
    return drawn


# ---------------------------------------------------------------- both sides

def machine(pairs, mask):
    """Word, condition code and interruption code of every operation, by kind."""
    kinds, found = list(pairs), {}
    for first in range(0, len(kinds), AT_ONCE):
        some = kinds[first:first + AT_ONCE]
        found |= zip(some, s370_machine.run([(kind, pairs[kind]) for kind in some], mask),
                     strict=True)
    return found


def arithmetic(program, kind, pairs):
    """Word and condition code by the arithmetic under test."""
    name = kind.removesuffix(ROUGH).removesuffix("-AU")
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "in"), Path(folder, "out")
        array.array("I", [number for one in pairs for number in one]).tofile(source.open("wb"))
        done = run_program(program, name, source, target, status=None)
        if done.returncode:
            raise RuntimeError(done.stderr)
        words = array.array("I", target.read_bytes())
    return list(zip(words[::2], words[1::2], strict=True))


def settled(kind, first, left):
    """The result after the library's standard correction; for CE there is no other."""
    result, _, code = left
    if kind.startswith("CE"):
        return 0
    if code == OVERFLOW_CODE:
        return result & SIGN | LARGEST
    if code == DIVIDE_CODE:
        return first & SIGN | LARGEST if first & FRACTION else 0
    if code:
        return 0
    return result if kind in WHOLE or result & FRACTION else 0


def has_condition(kind):
    return kind.removesuffix(ROUGH) in ("AE", "SE", "CE", "LTER", "LCER")


def agrees(kind, operand, left, found):
    """Whether a result of the machine is that of the arithmetic, with its condition code."""
    if not kind.startswith("CE") and settled(kind, operand[0], left) != found[0]:
        return False
    return left[2] != 0 or not has_condition(kind) or left[1] == found[1]


def machine_result(kind, a, b):
    """Word and condition code for words as they stand, normalised or not, from whole numbers.

    The arithmetic holds normalised numbers only. The machine's sum aligns operands as they are,
    keeps one guard digit and normalises the result alone; its product and quotient normalise
    operands first, but in registers whose exponents do not end."""
    if kind[:2] in ("ME", "DE"):
        f, g = a & FRACTION, b & FRACTION
        c, d = (a >> 24 & 127) - 64, (b >> 24 & 127) - 64
        if kind[:2] == "ME":
            return in_range(f * g, c + d + 64, (a ^ b) & SIGN, 12), 0
        if g == 0:
            return (a & SIGN | LARGEST if f else 0), 0
        return in_range((f << 80) // g, c - d + 64, (a ^ b) & SIGN, 20), 0
    if kind[:2] != "AE":
        b ^= SIGN
    parts = sorted(((x >> 24 & 127, x & FRACTION, x >> 31) for x in (a, b)), reverse=True)
    (high, large, sign), (low, small, other) = parts
    total = (-1) ** sign * (large << 4) + (-1) ** other * ((small << 4) >> 4 * min(high - low, 7))
    result = in_range(abs(total), high, SIGN * (total < 0), 7)
    return result, 0 if result == 0 and kind[:2] != "CE" else (total > 0) * 2 + (total < 0)


def in_range(size, characteristic, sign, digits):
    """The word of size / 16**digits times the power of 16, normalised and cut to six digits."""
    if size == 0:
        return 0
    length = -(-size.bit_length() // 4)
    characteristic += length - digits
    size = size >> 4 * (length - 6) if length > 6 else size << 4 * (6 - length)
    if characteristic > 127:
        return sign | LARGEST
    return sign | characteristic << 24 | size if characteristic >= 0 else 0


def explained(kind, operand, left):
    """Whether a difference is that of operands which the arithmetic cannot hold as they stand."""
    if not kind.endswith(ROUGH):
        return False
    return agrees(kind, operand, left, machine_result(kind, *operand))


def count(kind, mask, pairs, left, found):
    """A line of the counts."""
    differ = [i for i, rows in enumerate(zip(pairs, left, found, strict=True))
              if not agrees(kind, *rows)]
    codes = Counter(code for _, _, code in left)
    zeros = sum(result == SIGN for result, _, code in left if code == 0)
    hashes = [hashlib.sha256(repr(values).encode()).hexdigest() for values in (pairs, left)]
    return dict(zip(COUNTS, (
        kind, mask, len(pairs), len(differ),
        sum(explained(kind, pairs[i], left[i]) for i in differ), codes[OVERFLOW_CODE],
        codes[s370_machine.UNDERFLOW_CODE], codes[DIVIDE_CODE],
        0 if kind in WHOLE or kind.startswith("CE") else zeros, *hashes), strict=True)), differ


def compare(program, number):
    """Counts of all kinds under both masks; what the machine gave under mask 0; differences."""
    pairs = {kind: operands(kind, number) for kind in BODIES}
    found = {kind: arithmetic(program, kind, pairs[kind]) for kind in BODIES}
    counts, strange, plain = [], [], None
    for mask, bits in MASKS.items():
        left = machine(pairs, bits)
        plain = plain or left
        for kind in BODIES:
            line, differ = count(kind, mask, pairs[kind], left[kind], found[kind])
            counts.append(line)
            strange += [(kind, mask, pairs[kind][i], left[kind][i], found[kind][i])
                        for i in differ if not explained(kind, pairs[kind][i], left[kind][i])]
    return counts, {kind: list(zip(pairs[kind], plain[kind], strict=True)) for kind in BODIES}, \
        strange


def shown(strange):
    """One difference in words."""
    kind, mask, operand, left, found = strange
    return f"{kind} of {operand[0]:08X} and {operand[1]:08X}, mask {mask}: machine " \
        f"{left[0]:08X}, condition {left[1]}, interruption {left[2]:X}; here {found[0]:08X}, " \
        f"condition {found[1]}"


# ---------------------------------------------------------------- the archive

def write(counts, results):
    """counts.csv, and of every kind the first pairs with what the machine gave."""
    FOLDER.mkdir(exist_ok=True)
    with (FOLDER / "counts.csv").open("w", newline="", encoding="ascii") as file:
        writer = csv.DictWriter(file, COUNTS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(counts)
    with (FOLDER / "pairs.csv").open("w", encoding="ascii") as file:
        file.write("kind,first,second,result,condition,interruption\n")
        for kind, rows in results.items():
            for (a, b), (result, condition, code) in rows[:KEPT]:
                file.write(f"{kind},{a:08X},{b:08X},{result:08X},{condition},{code:X}\n")


def kept():
    """The archived pairs: by kind, operands and what the machine gave."""
    pairs, left = {}, {}
    with (FOLDER / "pairs.csv").open(newline="", encoding="ascii") as file:
        for row in csv.DictReader(file):
            pairs.setdefault(row["kind"], []).append((int(row["first"], 16),
                                                      int(row["second"], 16)))
            left.setdefault(row["kind"], []).append((int(row["result"], 16), int(row["condition"]),
                                                     int(row["interruption"], 16)))
    return pairs, left


def main(executable, number=PAIRS):
    if not s370_machine.is_here():
        raise SystemExit(s370_machine.MISSING)
    program = Path(executable).resolve().parent.parent / "example" / "hex32_words"
    counts, results, strange = compare(program, int(number))
    for line in counts:
        print(*(line[name] for name in COUNTS[:-2]), sep=",")
    for one in strange[:20]:
        print(shown(one))
    if int(number) == PAIRS:
        write(counts, results)
    print(f"{s370_machine.version()}: {sum(line['operations'] for line in counts)} operations, "
          f"{len(strange)} differences not explained")
    return 1 if strange else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
