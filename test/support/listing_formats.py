"""FORMAT statements of the listing: what they print, character by character.

Reads the descriptors that the report uses: nH, nX, Iw, Fw.d, Aw and slashes. Parentheses only
group: no statement of the report repeats a group. Column one of a record is carriage control: 1 is
a form feed, blank a new line.
"""

import re
from dataclasses import dataclass

SHORT_ZERO = ("0.0", "0.")
DESCRIPTOR = re.compile(r"(\d*)([IFAX])(\d*)(?:\.(\d+))?")


class BadFormat(ValueError):
    """A FORMAT statement that cannot be read."""


@dataclass(frozen=True)
class Field:
    """Columns of a cell, from 0, half open, after carriage control is dropped."""

    first: int
    last: int
    kind: str
    decimals: int

    def lay(self, cell):
        """The cell's text in its columns; an exact zero has its point where the others have it."""
        width = self.last - self.first
        if self.kind == "A":
            text = cell.ljust(width)
        elif self.kind == "I":
            text = cell.rjust(width)
        else:
            whole, point, decimals = cell.partition(".")
            if not point or (len(decimals) != self.decimals and cell not in SHORT_ZERO):
                raise BadFormat(f"'{cell}' has not {self.decimals} decimals")
            text = (whole.rjust(width - self.decimals - 1) + "." + decimals).ljust(width)
        if len(text) != width:
            raise BadFormat(f"'{cell}' is wider than {width} columns")
        return text


@dataclass(frozen=True)
class Line:
    """A record: its fixed text, blank in the fields, and its fields."""

    text: str
    fields: tuple

    def filled(self, cells):
        """The printed line; paper shows no blanks at its end."""
        text = self.text
        for field, cell in zip(self.fields, cells, strict=True):
            text = text[:field.first] + field.lay(cell) + text[field.last:]
        return text.rstrip(" ")


def tokens(statement):
    """Texts, descriptors and slashes of a FORMAT statement, in order."""
    at = 0
    after_text = False
    while at < len(statement):
        char = statement[at]
        if after_text and char not in ",/)":
            raise BadFormat(f"count of a text before '{statement[at:]}'")
        after_text = False
        if char in "(), ":
            at += 1
        elif char == "/":
            yield "/", "", 0, 0
            at += 1
        elif text := re.match(r"(\d+)H", statement[at:]):
            first = at + text.end()
            at = first + int(text[1])
            if at >= len(statement):
                raise BadFormat(f"{text[0]} is longer than the statement")
            yield "H", statement[first:at], 0, 0
            after_text = True
        elif found := DESCRIPTOR.match(statement, at):
            count, kind, width, decimals = found.groups()
            if (kind == "X") != (width == "") or (kind == "F") != (decimals is not None):
                raise BadFormat(f"descriptor {found[0]}")
            if kind == "X":
                yield "H", " " * int(count), 0, 0
            else:
                for _ in range(int(count or 1)):
                    yield kind, "", int(width), int(decimals or 0)
            at = found.end()
        else:
            raise BadFormat(f"'{statement[at:]}'")


def lines_of_format(statement):
    """The lines that a FORMAT statement prints."""
    if statement.count("(") != statement.count(")") or statement[0] + statement[-1] != "()":
        raise BadFormat(f"parentheses of {statement}")
    lines, text, fields = [], "", []

    def end_record():
        if text[:1] not in ("", " ", "1"):
            raise BadFormat(f"carriage control of '{text}'")
        lines.append(Line("\f" * (text[:1] == "1") + text[1:], tuple(fields)))

    for kind, fixed, width, decimals in tokens(statement):
        if kind == "/":
            end_record()
            text, fields = "", []
        else:
            if kind != "H":
                first = len(text) - 1
                fields.append(Field(first, first + width, kind, decimals))
            text += fixed or " " * width
    end_record()
    return lines
