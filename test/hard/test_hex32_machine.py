"""The short hexadecimal arithmetic against what a System/370 made of the same words.

Always: the archived pairs, in reference_output/hex32. With the emulator Hercules: more pairs, under
both program masks, and the archived ones again.
"""

import csv

import pytest
import s370_machine
from builds import ROOT, build
from hex32_against_machine import (BODIES, COUNTS, FOLDER, KEPT, MASKS, PAIRS, ROUGH, agrees,
                                   arithmetic, compare, explained, kept, machine, operands, told)

# The same words whatever build is under test: the unit tests try its rules in every build.
pytestmark = pytest.mark.once

NORMAL = [kind for kind in BODIES if not kind.endswith(ROUGH)]


@pytest.fixture(scope="module")
def program():
    return build("release").parent.parent / "example" / "hex32_words"


def counts():
    with (FOLDER / "counts.csv").open(newline="", encoding="ascii") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("kind", BODIES)
def test_archived_pairs(kind, program, tally):
    """What the machine gave for 200 pairs of each kind."""
    pairs, left = kept()
    assert len(pairs[kind]) == KEPT and pairs[kind] == operands(kind, KEPT)
    found = arithmetic(program, kind, pairs[kind])
    rows = list(zip(pairs[kind], left[kind], found, strict=True))
    differ = [row for row in rows if not agrees(kind, *row)]
    assert kind not in NORMAL or not differ, told((kind, "0", *differ[0]))
    assert all(explained(kind, operand, machines) for operand, machines, _ in differ)
    if kind in NORMAL:
        tally.add("System/370, archived", KEPT, KEPT)


def test_a_wrong_digit_is_seen():
    """One unit of the last place, a wrong sign, a wrong condition code."""
    pairs, left = kept()
    for kind in ("AE", "ME", "FIX", "SQRT"):
        operand, (word, condition, code) = next(
            (p, m) for p, m in zip(pairs[kind], left[kind], strict=True) if m[0] and not m[2])
        assert agrees(kind, operand, (word, condition, code), (word, condition))
        for wrong in (word ^ 1, word ^ 1 << 31):
            assert not agrees(kind, operand, (word, condition, code), (wrong, condition))
    assert not agrees("CE", (0, 0), (0, 1, 0), (0, 2))


def test_archived_counts():
    """100000 operations of each kind under each mask, no difference that is not explained, none at
    all where operands are normalised; and the page tells so."""
    lines = counts()
    assert [(line["program_mask"], line["kind"]) for line in lines] == \
        [(mask, kind) for mask in MASKS for kind in BODIES]
    for line in lines:
        assert tuple(line) == COUNTS and int(line["operations"]) == PAIRS
        assert line["differences"] == (line["explained"] if line["kind"].endswith(ROUGH) else "0")
    page = (FOLDER / "README.md").read_text(encoding="utf-8")
    for line in lines[:len(BODIES)]:
        cells = [line[name] for name in COUNTS[2:6]] + [line["divisions_by_zero"]]
        assert f"| {line['kind']} | {' | '.join(cells)} |" in page


@pytest.mark.skipif(not s370_machine.is_here(), reason=s370_machine.MISSING)
def test_on_the_machine(program, tally):
    """Fewer pairs than are archived, as they take a second."""
    number = 1000
    lines, _, strange = compare(program, number)
    assert not strange, told(strange[0])
    assert sum(line["operations"] for line in lines) == 2 * number * len(BODIES)
    assert all(line["differences"] == 0 for line in lines if not line["kind"].endswith(ROUGH))
    assert all(sum(line[name] for line in lines) > 100
               for name in ("overflows", "underflows", "divisions_by_zero"))
    tally.add("System/370, on the machine", 2 * number * len(NORMAL), 2 * number * len(NORMAL))


@pytest.mark.skipif(not s370_machine.is_here(), reason=s370_machine.MISSING)
def test_the_archive_is_the_machine_s():
    pairs, left = kept()
    assert machine(pairs, 0) == left
