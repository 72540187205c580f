"""Decks that are refused, decks that run with a note, and decks that look odd and are not.

The columns below are the deck's as the original reads it, written down a second time.
"""

import re

import pytest
from programs import run_program

NAME = "bad.deck"
RAN = f"{NAME}: note: the original program did not check this, and ran:"
MODEL = (("N", 1, 5), ("R", 6, 10), ("Z", 11, 15), ("E", 16, 25), ("MU", 26, 30),
         ("ELIMT", 31, 40))
# Line, first and last column, name, of every field of the header.
HEADER = (
    [(2, a, b, {"Z": "ZUMAX"}.get(name, name + "U")) for name, a, b in MODEL]
    + [(3, a, b, {"Z": "ZLMAX"}.get(name, name + "L")) for name, a, b in MODEL]
    + [(3, 41, 47, "WIDTHL"), (4, 1, 8, "THETAU"), (4, 9, 16, "THETAL"), (4, 17, 23, "XDISPL"),
       (4, 24, 30, "YDISPL")]
)
POSITION = ((1, 6, "x"), (7, 12, "y"), (13, 19, "height"))
UPPER, LOWER = 37, 75
FIRST_UPPER, FIRST_LOWER, LAST = 5, 5 + UPPER, 4 + UPPER + LOWER
COUNTS = ("NU", "NL")


def fields_of_asperities():
    for line in range(FIRST_UPPER, LAST + 1):
        upper = line < FIRST_LOWER
        index = line - (FIRST_UPPER if upper else FIRST_LOWER) + 1
        for first, last, name in POSITION:
            yield line, first, last, f"{name} of {'upper' if upper else 'lower'} asperity {index}"


def sample_fields():
    """The header, and the first and last card of each model."""
    lines = (FIRST_UPPER, FIRST_LOWER - 1, FIRST_LOWER, LAST)
    return HEADER + [field for field in fields_of_asperities() if field[0] in lines]


def label(field):
    return f"line{field[0]}-{field[3].replace(' ', '-')}"


@pytest.fixture(scope="module")
def cards(root):
    lines = (root / "data" / "thesis.deck").read_text(encoding="ascii").splitlines()
    assert len(lines) == LAST
    return lines


def punch(cards, line, column, text):
    """The deck with other characters from a column on."""
    card = cards[line - 1].ljust(column - 1)
    changed = card[:column - 1] + text + card[column - 1 + len(text):]
    return cards[:line - 1] + [changed] + cards[line:]


def deck(lines):
    return ("\n".join(lines) + "\n").encode("ascii")


class Runner:
    """Runs decks in a folder of their own and looks at what is left there."""

    def __init__(self, executable, folder):
        self.executable, self.folder = executable, folder

    def run(self, content, *options, timeout=100):
        if content is not None:
            (self.folder / NAME).write_bytes(content)
        return run_program(self.executable, NAME, *options, status=None, cwd=self.folder,
                           timeout=timeout, text=False)

    def problems(self, content, timeout=100):
        """Line, column and message of every problem of a deck that must be refused."""
        kept = self.folder / "contacts.csv"
        kept.write_text("from another run")
        done = self.run(content, "--contacts", "contacts.csv", "--positions", "positions.csv",
                        timeout=timeout)
        assert done.returncode == 2, done.stderr
        assert done.stdout == b""
        assert kept.read_text() == "from another run"
        assert {p.name for p in self.folder.iterdir()} <= {NAME, "contacts.csv"}
        return self.places(done.stderr.decode())

    @staticmethod
    def places(errors):
        """Line, column and message of each line."""
        assert errors.endswith("\n")
        found = [re.fullmatch(rf"{NAME}:(\d+):(\d+): (.+)", line) for line in errors.splitlines()]
        assert all(found) and found, errors
        return [(int(m[1]), int(m[2]), m[3]) for m in found]

    def unchecked(self, content, status=0):
        """Report, and what the original program did not check in a deck that it computed.

        `asperity solve` must refuse such a deck for the same reasons.
        """
        done = self.run(content)
        errors = done.stderr.decode()
        assert done.returncode == status, errors
        assert b"TABLE V" in done.stdout
        assert errors.count(RAN) == 1, errors
        lines = errors.split(RAN + "\n")[1].splitlines(keepends=True)
        found = self.places("".join(line for line in lines if re.match(rf"{NAME}:\d", line)))
        solved = run_program(self.executable, "solve", NAME, status=2, cwd=self.folder)
        assert solved.stdout == ""
        assert self.places(solved.stderr) == found
        return done.stdout, found

    def problem(self, content, **options):
        """The only problem of a deck."""
        found = self.problems(content, **options)
        assert len(found) == 1, found
        return found[0]


@pytest.fixture
def runner(asperity, tmp_path):
    return Runner(asperity, tmp_path)


@pytest.fixture(scope="module")
def report(asperity, root):
    """What the thesis deck prints."""
    return run_program(asperity, root / "data" / "thesis.deck", text=False).stdout


def quoted(content, line, first, last):
    """The field as a message quotes it."""
    card = content.decode().splitlines()[line - 1].ljust(last)
    return f"'{card[first - 1:last]}'"


@pytest.mark.parametrize("field", sample_fields(), ids=label)
def test_not_a_number_in_any_column(field, runner, cards):
    line, first, last, name = field
    for column in range(first, last + 1):
        content = deck(punch(cards, line, column, "?"))
        at_line, at_column, message = runner.problem(content)
        assert (at_line, at_column) == (line, column)
        assert message.startswith(name + " (" if line <= 4 else name + ":")
        assert f"found {quoted(content, line, first, last)}, expected " in message
        assert ("a whole number" if name in COUNTS else "a number") in message
        assert f"{first}-{last}" in message


@pytest.mark.parametrize("field", [f for f in sample_fields() if f[3] not in COUNTS], ids=label)
def test_not_finite(field, runner, cards):
    line, first, last, name = field
    width = last - first + 1
    for text in ("1E999", "-1E999"):
        if len(text) > width:
            continue
        at_line, at_column, message = runner.problem(
            deck(punch(cards, line, first, text.rjust(width))))
        assert (at_line, at_column) == (line, first)
        assert message.startswith(name) and "finite" in message


OUT_OF_RANGE = [
    *[(line, 1, text, "at least 1") for line in (2, 3) for text in ("    0", "   -1", "     ")],
    *[(line, 6, text, "more than zero") for line in (2, 3) for text in ("0.000", " -0.5", "     ")],
    *[(line, 16, text, "more than zero") for line in (2, 3)
      for text in ("        0.", "  -400000.", "          ")],
    *[(3, 41, text, "more than zero") for text in (" 0.0000", "-3.4550", "       ")],
    (2, 11, "-0.01", "no negative number"),
]
# Not physical, and computed by the original program, which reads neither as a condition.
UNCHECKED = [
    *[(line, 26, text, "more than -1 and at most 0.5") for line in (2, 3)
      for text in ("0.501", "-1.00", "-1   ", "  600")],
    *[(line, 13, text, "less than twice the radius")
      for line in (FIRST_UPPER, FIRST_LOWER - 1, FIRST_LOWER, LAST)
      for text in (" 1.0000", " 1.0001", "  10000")],
]
# OFSTMX reaches beyond RU + RL: the first candidate pair has no root (fault 7).
UNCHECKED_STOPS = [(line, 11, text, "less than twice the radius") for line in (2, 3)
                   for text in ("1.000", "1.001", " 1000")]


@pytest.mark.parametrize("line, first, text, expected", OUT_OF_RANGE)
def test_out_of_range(line, first, text, expected, runner, cards):
    at_line, at_column, message = runner.problem(deck(punch(cards, line, first, text)))
    assert (at_line, at_column) == (line, first)
    assert f"found '{text}'" in message and message.endswith("expected " + expected)


@pytest.mark.parametrize("line, first, text, expected", UNCHECKED + UNCHECKED_STOPS)
def test_unchecked_values_run_with_a_note(line, first, text, expected, runner, cards):
    stops = (line, first, text, expected) in UNCHECKED_STOPS
    report, found = runner.unchecked(deck(punch(cards, line, first, text)), status=int(stops))
    assert [place[:2] for place in found] == [(line, first)]
    assert f"found '{text}'" in found[0][2] and found[0][2].endswith("expected " + expected)
    assert (b"TABLE VI\n" in report) != stops


def test_numbers_beyond_the_machine_stop_before_any_table(runner, cards):
    """7.2E75 is the largest number of a System/370; a machine interrupt ended the run there."""
    lines = punch(punch(cards, 2, 16, "     4.E74"), 3, 16, "     4.E74")
    done = runner.run(deck(lines))
    assert done.returncode == 1 and done.stdout == b""
    assert "out of the range of ibm370, 1E75" in done.stderr.decode()
    same = runner.run(deck(punch(punch(cards, 2, 16, "     4.E40"), 3, 16, "     4.E40")))
    assert same.returncode == 0 and b"*****" in same.stdout


@pytest.mark.parametrize("line, first, text", [
    *[(line, 26, text) for line in (2, 3) for text in ("0.500", "-.999", "0.000", "  500")],
    *[(line, 11, ".9999") for line in (2, 3)],
    *[(line, 13, " 0.9999") for line in (FIRST_UPPER, LAST)],
    (3, 41, " 0.0001"),
])
def test_just_within_range(line, first, text, runner, cards):
    done = runner.run(deck(punch(cards, line, first, text)), "--arithmetic", "real64")
    # Such a deck may still be one that the original cannot compute.
    assert done.returncode in (0, 1), done.stderr


@pytest.mark.parametrize("change, line, column, count", [
    ("last card gone", LAST, 1, (111, 112, 37, 75)),
    ("first card gone", LAST, 1, (111, 112, 37, 75)),
    ("last card blank", LAST, 1, (111, 112, 37, 75)),
    ("no cards", 5, 1, (0, 112, 37, 75)),
    ("one card more", LAST + 1, 2, (113, 112, 37, 75)),
    ("NU one less", LAST, 2, (112, 111, 36, 75)),
    ("NU one more", LAST + 1, 1, (112, 113, 38, 75)),
    ("NL one less", LAST, 2, (112, 111, 37, 74)),
    ("NL one more", LAST + 1, 1, (112, 113, 37, 76)),
    ("blank card", LAST + 1, 2, (113, 112, 37, 75)),
    ("NU to the left", LAST + 1, 1, (112, 37075, 37000, 75)),
    ("NL to the left", LAST + 1, 1, (112, 75037, 37, 75000)),
])
def test_wrong_count_of_cards(change, line, column, count, runner, cards):
    lines = {
        "last card gone": cards[:-1],
        "first card gone": cards[:4] + cards[5:],
        "last card blank": cards[:-1] + ["   ", ""],
        "no cards": cards[:4],
        "one card more": cards + [" 1.000 1.000 0.0500"],
        "blank card": cards[:60] + [""] + cards[60:],
        "NU one less": punch(cards, 2, 1, "   36"),
        "NU one more": punch(cards, 2, 1, "   38"),
        "NL one less": punch(cards, 3, 1, "   74"),
        "NL one more": punch(cards, 3, 1, "   76"),
        "NU to the left": punch(cards, 2, 1, "37   "),
        "NL to the left": punch(cards, 3, 1, "75   "),
    }[change]
    found, expected, upper, lower = count
    if found > expected:
        _, ((at_line, at_column, message),) = runner.unchecked(deck(lines))
    else:
        at_line, at_column, message = runner.problem(deck(lines))
    assert (at_line, at_column) == (line, column)
    assert (f"wrong count of cards: found {found} asperities, expected {expected} "
            f"(NU {upper} and NL {lower})") in message
    assert message.startswith("text after the last card") == (found > expected)
    assert ("line 61 is blank: an asperity of zeros" in message) == (change == "blank card")


@pytest.mark.parametrize("line, name, count", [(2, "NU", 37), (3, "NL", 75)])
@pytest.mark.parametrize("shift", (1, 2))
def test_card_shifted_to_the_left_is_named(line, name, count, shift, runner, cards):
    card = cards[line - 1]
    shifted = {1: card[1:], 2: card[:5].strip().ljust(5) + card[5:]}[shift]
    message = runner.problems(deck(cards[:line - 1] + [shifted] + cards[line:]))[-1][2]
    assert message.endswith(f"; {name} {count} would fit: is card {line} shifted to the left? "
                            "Blanks after a digit are zeros")


def test_few_cards_are_no_shifted_card(runner, cards):
    for lines in (cards[:-1], punch(cards, 2, 1, "   40")):
        assert "shifted" not in runner.problem(deck(lines))[2]


@pytest.mark.parametrize("line", (2, 3))
def test_huge_number_of_asperities_is_answered(line, runner, cards):
    """The cards are counted, however many the deck speaks of."""
    content = deck(punch(cards, line, 1, "99999")[:20])
    _, _, message = runner.problem(content)
    assert "wrong count of cards: found 16 asperities" in message


@pytest.mark.parametrize("blank_lines", (0, 3))
@pytest.mark.parametrize("text, column", [("END", 1), ("   9", 4), (" " * 70 + "x", 71),
                                          ("/*", 1), ("//", 1)])
def test_text_after_the_last_card_is_never_read(blank_lines, text, column, runner, cards, report):
    lines = cards + [" "] * blank_lines + [text, "and more", "and more"]
    printed, ((at_line, at_column, message),) = runner.unchecked(deck(lines))
    assert printed == report
    assert (at_line, at_column) == (LAST + blank_lines + 1, column)
    assert message.startswith("text after the last card: found '" + text)


@pytest.mark.parametrize("present", (1, 2, 3))
def test_missing_header_cards(present, runner, cards):
    found = runner.problems(deck(cards[:present]))
    names = {2: "NU, RU, ZUMAX, EU, MUU, ELIMTU", 3: "NL, RL, ZLMAX, EL, MUL, ELIMTL, WIDTHL",
             4: "THETAU, THETAL, XDISPL, YDISPL"}
    assert [place[:2] for place in found] == [(line, 1) for line in range(present + 1, 5)]
    for line, _, message in found:
        assert f"card {line} is missing" in message and names[line] in message


def every_field():
    return HEADER + list(fields_of_asperities())


def spoil(cards, fields):
    for line, first, _, _ in fields:
        cards = punch(cards, line, first, "?")
    return cards


def test_all_bad_fields_at_once_in_order(runner, cards):
    fields = [field for field in every_field() if field[3] not in COUNTS]
    found = runner.problems(deck(spoil(cards, fields)))
    assert [place[:2] for place in found] == [field[:2] for field in fields]
    assert all(message.startswith(field[3]) for (_, _, message), field in zip(found, fields))


@pytest.mark.parametrize("bad", [("NU",), ("NL",), ("NU", "NL")], ids=" ".join)
def test_all_bad_fields_at_once_even_without_the_counts(bad, runner, cards):
    fields = [field for field in every_field() if field[3] in bad or field[3] not in COUNTS]
    found = runner.problems(deck(spoil(cards, fields)))
    assert [place[:2] for place in found] == [field[:2] for field in fields]
    if len(bad) == 1:
        assert all(message.startswith(field[3]) for (_, _, message), field in zip(found, fields))


def test_a_bad_count_brings_no_further_complaints(runner, cards):
    for line in (2, 3):
        assert runner.problem(deck(punch(cards, line, 1, "    x")))[:2] == (line, 5)


def kinds_at_once(cards):
    lines = punch(cards, 2, 26, "0.700")
    lines = punch(lines, 50, 13, " 1.5000")
    unchecked = lines + ["surplus"]
    lines = punch(unchecked, 2, 6, "0.000")
    lines = punch(lines, 3, 16, "  4000O0. ")
    return unchecked, punch(lines, 4, 30, "-")


def test_different_kinds_at_once(runner, cards):
    """The historic program refuses what it cannot compute; `solve` refuses all of it."""
    unchecked, refused = kinds_at_once(cards)
    cannot = [(2, 6), (3, 22), (4, 30)]
    found = runner.problems(deck(refused))
    assert [place[:2] for place in found] == cannot
    solved = run_program(runner.executable, "solve", NAME, status=2, cwd=runner.folder)
    everything = runner.places(solved.stderr)
    assert everything[:3] == found
    ran = [(2, 26), (50, 13), (LAST + 1, 1)]
    assert [place[:2] for place in everything[3:]] == ran
    assert [place[:2] for place in runner.unchecked(deck(unchecked))[1]] == ran


def titles(report):
    """Titles of the tables of a report in their order, each once."""
    lines = report.decode().splitlines()
    return list(dict.fromkeys(line.strip() for line in lines
                              if re.fullmatch(r" +TABLE [IVX]+[A-C]?", line)))


def test_tables_before_the_stop_are_printed(runner, cards, report):
    """Position 50 has no pair. Tables V, III and VIIA, of position 13, stood on paper by then."""
    lower = [f"{float(card[:6]) * .3:6.3f}{card[6:]}" for card in cards[FIRST_LOWER - 1:]]
    done = runner.run(deck(cards[:FIRST_LOWER - 1] + lower))
    assert done.returncode == 1
    assert titles(done.stdout) == ["TABLE V", "TABLE IIIA", "TABLE IIIB", "TABLE VIIA"]
    message = done.stderr.decode()
    assert f"{NAME}: position 50: no pair" in message and "fault 6" in message
    # The message ends with the command that computes such a deck, and it does.
    assert message.endswith(f"(fault 6); the present-day solver: asperity solve {NAME}\n")
    run_program(runner.executable, "solve", NAME, cwd=runner.folder)
    # Tables V and IIIA are those of the thesis' deck, which has the same upper model.
    assert done.stdout.split(b"TABLE IIIB")[0] == report.split(b"TABLE IIIB")[0]


def test_tall_cap_enters_as_its_centre(runner, cards):
    """Only Z - R enters: a cap of 1.1 in on a sphere of 0.5 in has its centre at 0.6 in."""
    _, ((line, column, _),) = runner.unchecked(deck(punch(cards, FIRST_LOWER - 1, 13, " 1.1000")))
    assert (line, column) == (FIRST_LOWER - 1, 13)


@pytest.mark.parametrize("line, count, places", [(2, 38, "XSU(37)"), (3, 76, "XSL(75)")])
def test_models_larger_than_the_arrays_have_a_note(line, count, places, runner, cards):
    lines = punch(cards, line, 1, f"{count:5d}")
    at = FIRST_LOWER - 1 if line == 2 else LAST
    done = runner.run(deck(lines[:at] + [" 2.000 2.000 0.0500"] + lines[at:]))
    assert done.returncode == 0
    assert titles(done.stdout)[-1] == "TABLE VI"
    notes = [text for text in done.stderr.decode().splitlines() if "DIMENSION" in text]
    assert len(notes) == 1
    assert f"{'NU' if line == 2 else 'NL'} is {count}, DIMENSION {places}" in notes[0]
    assert "deviation h" in notes[0]


def test_models_that_fill_the_arrays_have_no_note(runner, cards):
    assert "DIMENSION" not in runner.run(deck(cards)).stderr.decode()


NUMERIC = {
    "matrix": "\n".join(" ".join(f"{i * k % 7 - 3:.5e}" for k in range(20)) for i in range(20)),
    "six columns": "\n".join(" ".join(f"{i * k % 5:.2f}" for k in range(6)) for i in range(20)),
    "commas": "\n".join(f"{i},{i * .5},{i * .25}" for i in range(20)),
    "one column": "0\n" * 30,
    "ragged": "\n".join(" ".join(map(str, range(i % 7 + 1))) for i in range(1, 30)),
    "ragged, wide": "\n".join(" ".join(["0.1234"] * (8 - i % 5)) for i in range(29)),
    "tabulators": "\n".join("\t".join(f"{i * k:.4f}" for k in range(5)) for i in range(29)),
    "atoms": "30\nwater\n" + "\n".join(f"O {i:.3f} {i * .1:.3f} 0.500" for i in range(30)),
    "addresses": "\n".join(f"10.0.0.{i} 255.255.255.0" for i in range(30)),
}


@pytest.mark.parametrize("kind", NUMERIC)
def test_numbers_of_another_kind_of_file_are_one_mistake(kind, runner):
    assert 1 <= len(runner.problems(NUMERIC[kind].encode())) <= 3


@pytest.mark.parametrize("content", [b"", b"\n", b" ", b"  \n \t\n\n", b"\r\n\r\n", b"\n" * 200])
def test_empty(content, runner):
    line, column, message = runner.problem(content)
    assert (line, column) == (1, 1) and "empty" in message


@pytest.mark.parametrize("content, line, column", [
    (b"\0", 1, 1),
    (b"\x7fELF\x02\x01\x01\0" + bytes(range(256)), 1, 1),
    (b"NO  YES \n   37\0", 2, 6),
    (b"NO  YES \n   \x1b[31m", 2, 4),
])
def test_binary(content, line, column, runner):
    at_line, at_column, message = runner.problem(content)
    assert (at_line, at_column) == (line, column)
    assert "not a text file" in message


def same_report(runner, content, report):
    done = runner.run(content)
    assert done.returncode == 0, done.stderr
    assert done.stdout == report


@pytest.mark.long
def test_line_ends_do_not_matter(runner, cards, report):
    plain = deck(cards)
    same_report(runner, plain, report)
    same_report(runner, plain.replace(b"\n", b"\r\n"), report)
    same_report(runner, plain.rstrip(b"\n"), report)
    same_report(runner, plain.replace(b"\n", b"\r\n").rstrip(b"\n"), report)
    same_report(runner, plain + b"\n  \n\t\n" + b" " * 90, report)
    # Cards that end within a field: the line end is no part of it.
    short = cards[:3] + [""] + [card[:12] + card[12:].strip(" 0") for card in cards[4:]]
    assert max(map(len, short[4:])) < 19
    same_report(runner, deck(short), report)
    same_report(runner, deck(short).replace(b"\n", b"\r\n"), report)


def test_columns_behind_the_fields_are_ignored(runner, cards, report):
    numbered = [f"{card:<72}{10 * i:08d}" for i, card in enumerate(cards, 1)]
    same_report(runner, deck(numbered), report)
    same_report(runner, deck([f"{card:<80}?? beyond" for card in cards]), report)
    # A card with nothing but a sequence number is blank.
    same_report(runner, deck(numbered + [" " * 72 + "00001170"]), report)


def test_fields_without_point_or_with_blanks_give_the_same_report(runner, cards, report):
    lines = cards
    for line, column, text in (
        (2, 6, "  500"), (2, 11, ".07  "), (2, 16, "     4.E+5"), (2, 26, "42.-2"),
        (3, 6, ".5   "), (3, 16, "     4.D05"), (3, 31, "     112  "), (3, 41, "  34550"),
        (4, 1, " " * 30), (5, 1, "  3228   977    654"), (6, 1, "1.044 2.532 652.E-4"),
    ):
        lines = punch(lines, line, column, text)
    same_report(runner, deck(lines), report)
