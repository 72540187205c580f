"""Damaged copies of a printed report, made from its own lines with a fixed seed.

As a script: report_damage.py EXECUTABLE tells how many copies pass the comparison with the thesis.
"""

import random
import re
import sys

from cells_met import ARITHMETICS, report_of
from report_comparison import Comparison

COPIES = 150
SEED = 1972
UNIT = re.compile(r"\([A-Z%0-9/]+\)| CM\b|RADIANS")
JUNK = ("END OF TABLE", "1", "*", "     0.2815  1   9.974   2.126", "TABLE VIID", ".", "0.0",
        "ASPERITY CONTACT PROGRAM    PAGE 7", "WARNING: LIMIT EXCEEDED", "\t", "\r", "NO")


def is_heading(line):
    return re.search("[A-Z]{2}|[XYUL] ", line) is not None and not is_row(line)


def is_row(line):
    return re.fullmatch(r"[ \d.]*\d\.\d*( +NO| +YES| +TOTAL)?", line) is not None


def pick(rng, lines, wanted):
    """Number of a line that is wanted."""
    return rng.choice([i for i, line in enumerate(lines) if wanted(line)])


def other(rng, letters, but):
    return rng.choice([letter for letter in letters if letter != but])


def put(line, first, text):
    return line[:first] + text + line[first + len(text):]


def change_letter(rng, lines):
    i = pick(rng, lines, is_heading)
    at = rng.choice([m.start() for m in re.finditer("[A-Z]", lines[i])])
    letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ" + lines[i][at].lower() + " 0"
    lines[i] = put(lines[i], at, other(rng, letters, lines[i][at]))


def change_unit(rng, lines):
    i = pick(rng, lines, UNIT.search)
    unit = rng.choice(list(UNIT.finditer(lines[i])))
    new = other(rng, ("(CM)", "(MM)", "(NT)", "(LB)", "(CM2)", "(IN2)", "(NT/CM2)", "(NT/MM2)",
                      " IN", "DEGREES", ""), unit[0])
    lines[i] = lines[i][:unit.start()] + new.ljust(len(unit[0])) + lines[i][unit.end():]


def remove_heading(rng, lines):
    del lines[pick(rng, lines, is_heading)]


def double_heading(rng, lines):
    i = pick(rng, lines, is_heading)
    lines.insert(i, lines[i])


def swap_heading(rng, lines):
    i = pick(rng, lines, is_heading)
    j = i + rng.choice((-1, 1))
    lines[i], lines[j] = lines[j], lines[i]


def junk_line(rng, lines):
    lines.insert(rng.randrange(len(lines) + 1), " " * rng.randrange(60) + rng.choice(JUNK))


def blank_line(rng, lines):
    if rng.random() < 0.5:
        lines.insert(rng.randrange(len(lines) + 1), " " * rng.choice((0, 0, 1, 20)))
    else:
        del lines[pick(rng, lines, lambda line: line == "")]


def swap_columns(rng, lines):
    """Two neighbouring words of a line, or two numbers in each row of a table, change places."""
    i = pick(rng, lines, lambda line: len(line.split()) > 1)
    words = list(re.finditer(r"\S+", lines[i]))
    k = rng.randrange(len(words) - 1)
    first, last = words[k].start(), words[k + 1].end()
    cut = rng.randint(words[k].end(), words[k + 1].start())
    while True:
        line = lines[i].ljust(last)
        lines[i] = (line[:first] + line[cut:last] + line[first:cut] + line[last:]).rstrip()
        i += 1
        if not is_row(lines[i - 1]) or i == len(lines) or not is_row(lines[i]):
            return


def change_digit(rng, lines):
    i = pick(rng, lines, is_row)
    at = rng.choice([m.start() for m in re.finditer(r"\d", lines[i])])
    lines[i] = put(lines[i], at, other(rng, "0123456789", lines[i][at]))


def change_cell(rng, lines):
    """A cell is lost, moved by a place, gets another sign or point; NO and YES change."""
    i = pick(rng, lines, is_row)
    cell = rng.choice(list(re.finditer(r"\S+", lines[i])))
    text = cell[0]
    new = {"NO": "YES", "YES": "NO", "TOTAL": "SUM"}.get(text) or other(
        rng, ("*" * len(text), "", "-" + text, text.replace(".", ","), text + "0", text[:-1],
              text.replace(".", "")), text)
    lines[i] = lines[i][:cell.start()] + new.ljust(len(text)) + lines[i][cell.end():]


def change_row(rng, lines):
    """A row is lost, comes twice, or changes places with the next."""
    i = pick(rng, lines, is_row)
    lines[i:i + 2] = rng.choice((lines[i + 1:i + 2], [lines[i], *lines[i:i + 2]],
                                 lines[i:i + 2][::-1]))


def page_break(rng, lines):
    """A form feed is lost, with or without its line, or a page begins where none should."""
    i = pick(rng, lines, lambda line: line.startswith("\f"))
    chance = rng.randrange(4)
    if chance == 0:
        lines[i] = lines[i][1:]
    elif chance == 1:
        del lines[i]
    else:
        lines.insert(rng.randrange(len(lines)), "\f" * (chance - 1))


def shift_blank(rng, lines):
    """A blank more or less, or one from between two words to between two others."""
    i = pick(rng, lines, lambda line: line.strip())
    gaps = [m.start() for m in re.finditer(" ", lines[i])]
    at = rng.choice(gaps)
    without = lines[i][:at] + lines[i][at + 1:]
    to = rng.randrange(len(without) + 1)
    lines[i] = rng.choice((without, lines[i] + " ", lines[i][:at] + " " + lines[i][at:],
                           without[:to] + " " + without[to:]))


def move_table(rng, lines):
    """A page is moved, lost, comes twice, or the report ends too soon or too late."""
    pages = "\n".join(lines).split("\f")
    i, j = rng.sample(range(1, len(pages)), 2)
    chance = rng.randrange(4)
    if chance == 0:
        pages.insert(j, pages.pop(i))
    elif chance == 1:
        del pages[i]
    elif chance == 2:
        pages.insert(i, pages[i])
    else:
        del pages[max(i, 2):]
    lines[:] = "\f".join(pages).split("\n")


KINDS = (change_letter, change_unit, remove_heading, double_heading, swap_heading, junk_line,
         blank_line, swap_columns, change_digit, change_cell, change_row, page_break, shift_blank,
         move_table)


def damaged_copies(report, copies=COPIES, seed=SEED):
    """Name of the damage and text of each copy; every text differs from the report."""
    rng = random.Random(seed)
    for number in range(copies):
        damage = KINDS[number % len(KINDS)]
        text = report
        while text == report:
            lines = report.split("\n")[:-1]
            damage(rng, lines)
            text = "\n".join(lines) + "\n"
        yield damage.__name__, text


def passing_copies(report, arithmetic, **options):
    """Names of the damages that the comparison does not see, and the number of copies."""
    copies = list(damaged_copies(report, **options))
    return [name for name, text in copies if not Comparison(text, arithmetic).wrong], len(copies)


if __name__ == "__main__":
    for arithmetic_ in ARITHMETICS:
        passing, number_ = passing_copies(report_of(sys.argv[1], arithmetic_), arithmetic_)
        print(f"{arithmetic_}: {len(passing)} of {number_} damaged copies pass", *passing)
