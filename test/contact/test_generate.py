"""`asperity generate`: the numbers against an independent evaluation, their statistics, and what
the command states when it cannot do what is asked."""

import os
from decimal import Decimal

import mpmath
import numpy as np
import pytest

from philox import philox, whole_number
from programs import run_program

HEADER = "x,y,height,radius"
PLAIN = """&surfaces number = {number}, length = 40., width = 25., least_distance = {least} /
&heights mean = 0.05, deviation = 0.012, lowest = 0.04, highest_deviation = 1.75 /
&radii mean = 0.5, deviation = 0.03, lowest_deviation = -2., highest_deviation = 1. /
&random seed = {seed}{more} /
"""


@pytest.fixture
def generate(asperity, tmp_path):
    def start(text, *options, status=0, **environment):
        spec = tmp_path / "a.spec"
        spec.write_text(text, encoding="ascii")
        return run_program(asperity, "generate", "a.spec", *options, status=status, cwd=tmp_path,
                           variables=environment)
    return start


def rows(text):
    """The numbers of a CSV as decimals, column by column."""
    lines = text.splitlines()
    assert lines[0] == HEADER
    return [[Decimal(cell) for cell in column] for column in zip(*(line.split(",")
                                                                   for line in lines[1:]))]


def units(values, decimals):
    """Whole numbers of 10**-decimals."""
    scaled = [value.scaleb(decimals) for value in values]
    assert all(value == int(value) for value in scaled)
    return np.array([int(value) for value in scaled])


def cdf(z):
    return mpmath.erfc(-z / mpmath.sqrt(2)) / 2


def quantile(words, lowest, highest):
    """A deviation from three words: a piece of 1024 by the first 52 bits, then the inverse of the
    distribution within it at the other 31."""
    low, total = cdf(lowest), cdf(highest) - cdf(lowest)
    step = (highest - lowest) / 1024
    wanted = (int(words[0]) << 20) | (int(words[1]) >> 12)
    near = mpmath.erfinv(2 * (low + total * wanted / mpmath.mpf(2) ** 52) - 1) * mpmath.sqrt(2)
    piece = int((near - lowest) / step)
    # Near the end of a piece the rounded table decides.
    for piece in (piece - 1, piece, piece + 1):
        ends = [mpmath.nint((cdf(lowest + (piece + i) * step) - low) / total * 2 ** 52)
                for i in (0, 1)]
        if ends[0] <= wanted < ends[1]:
            break
    else:
        raise AssertionError("no piece")
    left, right = cdf(lowest + piece * step), cdf(lowest + (piece + 1) * step)
    share = (int(words[2]) >> 1) / mpmath.mpf(2) ** 31
    return mpmath.erfinv(2 * (left + share * (right - left)) - 1) * mpmath.sqrt(2)


def truncated_moments(lowest, highest):
    """Mean and deviation of a standard Gaussian between two cut-offs (N. L. Johnson, S. Kotz,
    N. Balakrishnan, Continuous Univariate Distributions 1, section 13.10.1)."""
    a, b = mpmath.mpf(lowest), mpmath.mpf(highest)
    total = cdf(b) - cdf(a)
    mean = (mpmath.npdf(a) - mpmath.npdf(b)) / total
    variance = 1 + (a * mpmath.npdf(a) - b * mpmath.npdf(b)) / total - mean ** 2
    return float(mean), float(mpmath.sqrt(variance))


@pytest.mark.parametrize("counter, key, words", [
    ((0, 0, 0, 0), (0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
    ((2**32 - 1,) * 4, (2**32 - 1,) * 2, (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
    ((0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344), (0xA4093822, 0x299F31D0),
     (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1))])
def test_words_of_the_generator(counter, key, words):
    """The definition that draws and places are compared with has the published vectors."""
    assert tuple(philox(counter, key).ravel()) == words


def test_positions_are_those_of_the_definition(generate):
    """Random sequential addition anew, with all earlier asperities asked, in whole numbers."""
    x, y, _, _ = rows(generate(PLAIN.format(number=400, least=1, seed=77, more="")).stdout)
    x, y = units(x, 8), units(y, 8)
    # Python's own integers: squares have more than 63 bits.
    placed = np.empty((0, 2), dtype=object)
    tries = 0
    for number in range(1, 401):
        for attempt in range(1, 10001):
            tries += 1
            words = philox((number, attempt, 1, 1), (77, 0)).ravel()
            place = np.array([whole_number(words[0], words[1], 40 * 10 ** 8 + 1),
                              whole_number(words[2], words[3], 25 * 10 ** 8 + 1)], dtype=object)
            if (((placed - place) ** 2).sum(axis=1) >= 10 ** 16).all():
                break
        placed = np.vstack([placed, place])
    assert tries > 450
    met = int((placed[:, 0] == x).sum() + (placed[:, 1] == y).sum())
    assert met == 800


@pytest.mark.truth
@pytest.mark.parametrize("column, stream, mean, deviation, lowest, highest", [
    (2, 5, "0.05", "0.012", "0.04", "0.071"), (3, 6, "0.5", "0.03", "0.44", "0.53")],
    ids=("heights", "radii"))
def test_draws_are_those_of_the_definition(column, stream, mean, deviation, lowest, highest,
                                           generate, tmp_path):
    """Of the lower surface 3 of an ensemble, by mpmath. Allowed: half a unit of the last digit
    written, and the stated error of 1e-11 of the range."""
    generate(PLAIN.format(number=400, least=0, seed=2147483647, more=", ensemble = 3"),
             "--lower", "l.csv", "--surface", 3)
    found = rows((tmp_path / "l.csv").read_text())[column]
    words = philox((np.arange(1, 401), 1, 3, stream), (2147483647, 0))
    unit = Decimal(1).scaleb(found[0].as_tuple().exponent)
    span = Decimal(highest) - Decimal(lowest)
    assert unit <= Decimal("1e-11") * span
    with mpmath.workdps(40):
        m, s, a, b = map(mpmath.mpf, (mean, deviation, lowest, highest))
        allowed = mpmath.mpf(str(unit)) / 2 + (b - a) * mpmath.mpf("1e-11")
        off = [abs(mpmath.mpf(str(value)) - m - s * quantile(words[:, i], (a - m) / s, (b - m) / s))
               for i, value in enumerate(found)]
        met = sum(value <= allowed for value in off)
    assert met == 400


@pytest.mark.truth
def test_least_distance_holds_exactly(generate):
    """4000 asperities that cover 0.38 of the area: exact in whole numbers, and it is reached."""
    x, y, _, _ = rows(generate(PLAIN.format(number=4000, least="0.35", seed=5, more="")).stdout)
    decimals = -x[0].as_tuple().exponent
    least = 35 * 10 ** (decimals - 2)
    x, y = units(x, decimals), units(y, decimals)
    assert 0 <= x.min() and x.max() <= 40 * 10 ** decimals
    assert 0 <= y.min() and y.max() <= 25 * 10 ** decimals
    near = np.hypot(*(np.subtract.outer(c, c).astype(float) for c in (x, y)))
    i, j = np.nonzero(np.triu(near < 1.001 * least, 1))
    # Python's own integers: squares may have more than 63 bits.
    found = min(int(x[a] - x[b]) ** 2 + int(y[a] - y[b]) ** 2 for a, b in zip(i, j))
    assert found >= least ** 2


def deck_models(text):
    """Number of asperities and cards of both models."""
    lines = text.splitlines()
    numbers = [int(line[:5]) for line in lines[1:3]]
    assert len(lines) == 4 + sum(numbers)
    cards = [(Decimal(line[:6]), Decimal(line[6:12]), Decimal(line[12:19])) for line in lines[4:]]
    return cards[:numbers[0]], cards[numbers[0]:]


def test_the_design_of_the_thesis(generate, root, asperity, tmp_path):
    """The example, 200 times: counts, plates, least distance and cut-offs exactly; mean and
    deviation of the heights within 4 standard errors of the closed form."""
    members = 200
    example = (root / "data/examples/generate/thesis.spec").read_text()
    spec = example.replace("seed = 1976", f"seed = 1976, ensemble = {members}")
    assert spec != example
    generate(spec, "--output", "%.deck")
    decks = [deck_models((tmp_path / f"{i}.deck").read_text()) for i in range(1, members + 1)]
    for side, (number, length, lowest, highest) in enumerate((
            (37, 4, "0.0437", "0.0678"), (75, 8, "0.0376", "0.0732"))):
        heights = []
        for deck in decks:
            x, y, z = zip(*deck[side])
            assert len(x) == number
            a, b = units(x, 3), units(y, 3)
            assert 0 <= a.min() and a.max() <= 1000 * length
            assert 0 <= b.min() and b.max() <= 3000
            off = np.triu_indices(number, 1)
            assert ((a[off[0]] - a[off[1]]) ** 2 + (b[off[0]] - b[off[1]]) ** 2).min() >= 300 ** 2
            assert Decimal(lowest) <= min(z) and max(z) <= Decimal(highest)
            heights += map(float, z)
        z = (np.array(heights) - 0.050) / 0.012
        m, s = truncated_moments(*((float(cut) - 0.050) / 0.012 for cut in (lowest, highest)))
        # Rounding to 0.0001 in adds its variance; half cells at the ends are below that.
        s = np.hypot(s, 0.0001 / 0.012 / np.sqrt(12))
        fourth = ((z - m) ** 4).mean() / s ** 4
        assert abs(z.mean() - m) < 4 * s / np.sqrt(len(z))
        assert abs(z.std() - s) < 4 * s * np.sqrt((fourth - 1) / 4 / len(z))
    done = run_program(asperity, tmp_path / "1.deck")
    assert done.stderr == ""
    assert "    37" in done.stdout and "    75" in done.stdout


def test_a_deck_is_written_as_cards_hold_it(generate, root):
    spec = (root / "data/examples/generate/thesis.spec").read_text()
    spec = spec.replace("mean = 0.5 /", "mean = 0.50049 /").replace(
        "poisson_ratio = 0.42", "poisson_ratio = 0.4204, -0.2, lower_width = 3.455")
    done = generate(spec)
    assert done.stderr.splitlines() == [
        "note: the radius is rounded to 0.500, as a card holds it",
        "note: poisson_ratio is rounded to 0.420, as a card holds it",
        "note: the radius is rounded to 0.500, as a card holds it"]
    lines = done.stdout.splitlines()
    highest = max(card[2] for card in deck_models(done.stdout)[0])
    top = f"{-(-int(highest * 10000) // 10) / 1000:.3f}"
    assert lines[1] == f"   370.500{top}   400000.0.420    11200."
    assert lines[2].startswith("   750.5000.07") and lines[2][15:] == \
        "   400000.-.200    11200. 3.4550"
    assert lines[3] == "  0.0000  0.0000  0.000  0.000"


def test_same_bytes_as_a_single_member(generate, tmp_path):
    """Threads and locale change nothing, and a member is the same alone as in its ensemble."""
    spec = PLAIN.format(number=3000, least="0.1", seed=9, more=", ensemble = 4")
    generate(spec, "--upper", "u_%.csv", "--lower", "l_%.csv", OMP_NUM_THREADS="1")
    assert sorted(os.listdir(tmp_path)) == sorted(
        ["a.spec", *(f"{side}_{i}.csv" for side in "ul" for i in range(1, 5))])
    whole = {i: (tmp_path / f"u_{i}.csv").read_text() for i in range(1, 5)}
    assert len({*whole.values(), (tmp_path / "l_3.csv").read_text()}) == 5
    alone = generate(spec, "--surface", 3, OMP_NUM_THREADS="4", LC_ALL="de_DE.UTF-8").stdout
    assert alone == whole[3]


@pytest.mark.parametrize("least, words", [
    ("1.3", ["1000 asperities, expected at most 734", "no arrangement"]),
    ("0.9", ["found room for ", " of 1000 asperities", "10000 tries",
             "random placing ends near 0.547"])], ids=("impossible", "not_found"))
def test_asperities_too_dense_are_refused(least, words, generate, tmp_path):
    """1000 on 40 x 25: at most 2/sqrt(3) 1000/1.69 + 65/1.3 + 1 = 734.3 keep 1.3."""
    done = generate(PLAIN.format(number=1000, least=least, seed=1, more=""), "--output", "u.csv",
                    status=1)
    assert done.stdout == "" and done.stderr.startswith("a.spec: the upper surface cannot be ")
    for word in words:
        assert word in done.stderr
    assert done.stderr.count("\n") == 1
    assert os.listdir(tmp_path) == ["a.spec"]


GOOD = PLAIN.format(number=10, least=0, seed=1, more="")


@pytest.mark.parametrize("old, new, complaints", [
    ("", "", ["a.spec:1:1: &surfaces needs length", "a.spec:1:1: &surfaces needs width",
              "a.spec:1:1: &surfaces needs number", "a.spec:1:1: &heights needs mean",
              "a.spec:1:1: &heights needs deviation", "a.spec:1:1: &radii needs mean"]),
    ("number = 10", "number = 2.5, 0",
     ["a.spec:1:20: number: found '2.5'", "a.spec:1:25: number: found '0'"]),
    ("number = 10", "number = 1e1, 2.5",
     ["a.spec:1:25: number: found '2.5', expected a whole number from 1 to 20000000"]),
    ("number = 10", "number = 10, 20, 30", ["a.spec:1:11: number: wrong number of values"]),
    ("number = 10", "density = 1e9", ["a.spec:1:11: density: found too few or too many"] * 2),
    ("number = 10", "number = 1, density = 1", ["a.spec:1:23: density: found beside number"]),
    ("least_distance = 0", "least_distance = -1", ["a.spec:1:68: least_distance: found '-1'"]),
    ("lowest = 0.04", "lowest = 0.08", ["a.spec:2:1: nothing is left between the upper",
                                        "a.spec:2:1: nothing is left between the lower"]),
    ("lowest = 0.04", "lowest = 0.04, lowest_deviation = -1",
     ["a.spec:2:57: lowest_deviation: found beside lowest"]),
    ("highest_deviation = 1.75", "highest_deviation = 1.75, lowest = 0",
     ["a.spec:2:83: lowest occurs twice"]),
    ("lowest = 0.04, highest_deviation = 1.75", "lowest = 0.6, highest = 0.7",
     ["a.spec:2:1: the upper cut-offs leave only", "a.spec:2:1: the lower cut-offs leave only"]),
    ("mean = 0.05", "mean = 0.9", ["a.spec:2:1: heights of the upper", "a.spec:2:1: heights of "]),
    ("deviation = 0.03, lowest_deviation = -2., ", "deviation = 0.07, ",
     ["a.spec:3:1: radii of the upper", "a.spec:3:1: radii of the lower"]),
    ("seed = 1", "seed = 1.5, ensemble = 0, tries = x", [
        "a.spec:4:16: seed", "a.spec:4:32: ensemble", "a.spec:4:43: tries"]),
    ("seed = 1 /", "seed = 1 /\n&deck /", [
        "a.spec:5:1: &deck needs elastic_modulus", "a.spec:5:1: &deck needs poisson_ratio",
        "a.spec:5:1: &deck needs allowed_stress", "a.spec:5:1: the upper surface does not fit",
        "a.spec:5:1: the lower surface does not fit"]),
    ("&random", "&tilt /\n&random", ["a.spec:4:1: unknown group: found '&tilt'"]),
    ("seed", "sead", ["a.spec:4:9: unknown name in &random: found 'sead'"]),
    ("seed", "\x07", ["a.spec:4:9: not a text file"]),
], ids=range(18))
def test_bad_specifications(old, new, complaints, generate, tmp_path):
    text = GOOD.replace(old, new) if old else "! nothing\n"
    assert not old or text != GOOD
    done = generate(text, "--output", "u.csv", status=2)
    assert done.stdout == "" and os.listdir(tmp_path) == ["a.spec"]
    lines = done.stderr.splitlines()
    assert len(lines) == len(complaints), done.stderr
    for line, complaint in zip(lines, complaints):
        assert line.startswith(complaint), done.stderr
        assert "expected" in line


@pytest.mark.parametrize("options, words", [
    (["--surface", "0"], "--surface: found '0'"),
    (["--surface", "5"], "expected at most 4"),
    (["--output", "u.csv"], "expected % in it"),
    ([], "standard output holds one surface"),
    (["--output", "a_%", "--upper", "b_%"], "--output and --upper"),
    (["--upper", "a_%", "--lower", "a_%"], "both name"),
    (["--output", "a.spec", "--surface", "1"], "names the input"),
    (["--bogus"], "unknown option"),
], ids=range(8))
def test_bad_options(options, words, generate, tmp_path):
    spec = PLAIN.format(number=10, least=0, seed=1, more=", ensemble = 4")
    done = generate(spec, *options, status=2)
    assert words in done.stderr and done.stdout == ""
    assert os.listdir(tmp_path) == ["a.spec"] and (tmp_path / "a.spec").read_text() == spec


def test_a_later_member_cannot_be_made(generate, tmp_path):
    """Status 1 leaves no file of the members before it, nor a part of one."""
    spec = ("&surfaces number = 2, length = 10, width = 10, least_distance = 1 /\n"
            "&heights mean = .001, deviation = 1, lowest = -.1, highest = .2 /\n"
            "&radii mean = .5 /\n&random seed = 0, ensemble = 3, tries = 1 /\n")
    done = generate(spec, "--upper", "u_%.csv", "--lower", "l_%.csv", status=1)
    assert "cannot be packed" in done.stderr and os.listdir(tmp_path) == ["a.spec"]
