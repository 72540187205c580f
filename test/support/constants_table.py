"""The named numeric constants of the solvers of interaction, with the fields of their comments.

A comment states meaning and unit, the source (derived, measured, chosen or a publication) and a
test that fails when the value changes by 30 %.
"""

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("grid", "circles", "joint")
DECLARED = re.compile(r"^\s*(?:real|integer)\b[^!]*\bparameter\b[^!]*::([^!]*)", re.IGNORECASE)
ITEM = re.compile(r"(\w+)\s*(?:\([^()]*\))?\s*=\s*([^=]+?)(?=,\s*\w+\s*(?:\([^()]*\))?\s*=|$)")
SOURCES = {"literature": r"\b(?:18|19|20)\d\d\b", "derived": r"\bderived\b",
           "measured": r"\bmeasured\b", "chosen": r"\bchosen\b"}
TEST = re.compile(r"\b(\w+_suite\.f90|test_\w+\.py)")


@dataclass
class Constant:
    """A constant; text that its comment does not have is empty."""

    room: str
    file: str
    name: str
    value: str
    comment: str

    @property
    def source(self):
        return next((source for source, words in SOURCES.items()
                     if re.search(words, self.comment, re.IGNORECASE)), "")

    @property
    def test(self):
        """The file of the test."""
        found = TEST.search(self.comment)
        return found[1] if found else ""


def statement_at(lines, first):
    """The statement that begins in a line, and the line after it."""
    text, last = lines[first], first
    while text.partition("!")[0].rstrip().endswith("&"):
        last += 1
        text = text.partition("!")[0].rstrip().rstrip("&") + lines[last].strip().lstrip("&")
    return text, last + 1


def shown(value):
    """A Fortran expression without kinds of numbers and blanks."""
    value = re.sub(r"(?:\.0)?_(?:real|int)\d+\b", "", value)
    value = re.sub(r"(\d)\.0e", r"\1e", value)
    return re.sub(r"\s+", "", value).replace("epsilon(1)", "epsilon").replace("|", "")


def is_number(value):
    """Whether a value is one number, or few: no name, no size or table, no implied loop."""
    return bool(re.search(r"\d", value)) and len(value) < 40 and \
        not re.match(r"[a-z]\w*$|ubound\(", value)


def are_codes(items):
    """Whether the names of a statement stand for different small whole numbers."""
    values = [value for _, value in items]
    return len(items) > 2 and all(map(str.isdigit, values)) and \
        len({*values}) == len(values) and max(map(int, values)) <= 2 * len(values)


def constants(room):
    """The constants of a room, file by file; names of codes are none."""
    for path in sorted((ROOT / "src" / room).glob("*.[fF]90")):
        lines = path.read_text(encoding="utf-8").splitlines()
        for number in range(len(lines)):
            statement, after = statement_at(lines, number) if DECLARED.match(lines[number]) \
                else ("", 0)
            found = DECLARED.match(statement)
            if not found:
                continue
            comment, above = [], number - 1
            while re.match(r"\s*!", lines[above]):
                comment.insert(0, lines[above].strip("! >"))
                above -= 1
            comment += [line.partition("!")[2] for line in lines[number:after]]
            items = [(name, shown(value)) for name, value in ITEM.findall(found[1].strip())]
            for name, value in items:
                if is_number(value) and "reshape" not in statement and not are_codes(items):
                    yield Constant(room, path.stem, name, value, " ".join(comment))


def table_of_constants(_):
    """Rows without blanks: the pages are limited in words."""
    yield "|constant|value|source|test|"
    yield "|---|---|---|---|"
    for room in ROOMS:
        for one in constants(room):
            yield f"|`{one.file}:{one.name}`|{one.value}|{one.source}|{one.test}|"
