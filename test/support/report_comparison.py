"""A printed report against the whole text that the thesis has: nothing missing, nothing else.

Outside the cells every character of every line must be there. A cell must stand in its columns, in
the form of its FORMAT. `ibm370` must print the thesis' text; another arithmetic may be off in
numbers with a decimal point, by what the original's rounding explains.
"""

import math
import re
from collections import Counter
from itertools import zip_longest

from thesis_report import UNSETTLED, bounds, printed_lines

LABELS = "labels"
# Cells: as text; as numbers; within what the thesis leaves open (illegible or withdrawn).
EXACT, TOLERATED, OPEN = "exact", "within tolerance", "within bounds"
COMBINED_RADIUS = 0.635  # cm: two spheres of 1.27 cm
# One unit in the last place of a System/370 short number between 1 and 16: the size of the
# sphere centres' heights and of their distance, from which the original takes its overlap W.
UNIT = 16.0 ** -5
POSITION = {"VIIA": 13, "VIIB": 55, "VIIC": 56}


def half_unit(text):
    """Half a unit in the last printed place."""
    return 0.5 * 10.0 ** -len(text.partition(".")[2])


def overlap_error(step):
    """Largest error of the original's W at a step of a position, cm (fault 3).

    W is RL + RU - SQRT(DIST**2 + Z**2): six operations on numbers of this size, each cut by up to
    a unit; and each step so far has cut up to a unit off the height of a centre.
    """
    return (6 + step) * UNIT


def approach_error(position):
    """Largest error of the original's approach at a position, cm (fault 2).

    Half a unit is cut off on average at each of about 16 steps of every position so far.
    """
    return 0.5 * UNIT * 16 * position


def exact_everywhere(cell):
    """Cells that every arithmetic must print as the thesis does: displacements and zeros."""
    return cell.table.endswith("heading") or cell.text in ("0.0", "0.")


def tolerance(cell, number):
    """How far real64 may be from the exact value behind the original's printed number.

    `real32` and `real128` are held to the same.
    """
    row, column = cell.row, cell.column
    if cell.table == "VI":
        return approach_error(100) if row["quantity"] == "approach" else 2.0e-3 * number
    if not cell.table.startswith("VII"):
        return 0.0
    if column == "approach":
        return approach_error(POSITION[cell.table])
    area_error = math.pi * COMBINED_RADIUS * overlap_error(cell.step)
    if column in ("area", "projected_area"):
        return cell.contacts * area_error
    if column in ("load", "average_pressure", "maximum_pressure"):
        # Pressure goes with the root of W, load with its power 1.5. A total is dominated by its
        # larger contacts, so the error of the mean contact stands for all.
        area = row["area"] if row["area"] != "?" else row["projected_area"]
        power = 1.5 if column == "load" else 0.5
        return number * power * cell.contacts * area_error / float(area)
    return 0.0


class Comparison:
    """What was compared and met, by table and kind, and what is wrong."""

    def __init__(self, text, arithmetic, expected=None):
        self.arithmetic = arithmetic
        self.compared, self.met, self.wrong = Counter(), Counter(), []
        self.to_the_last_digit = Counter()
        self.bounds = bounds()
        expected, found = expected or printed_lines(), text.split("\n")
        if found.pop() != "":
            self.wrong.append("the last line has no end")
        self.lines = len(expected)
        if len(found) != self.lines:
            self.wrong.append(f"{len(found)} lines, the thesis has {self.lines}")
        for number, (want, have) in enumerate(zip_longest(expected, found), 1):
            if want is None:
                self.wrong.append(f"line {number} is none of the thesis: '{have}'")
            else:
                self.line(number, *want, have)

    def count(self, key, met, what, amount=1):
        self.compared[key] += amount
        self.met[key] += amount if met else 0
        if not met:
            self.wrong.append(what)

    def line(self, number, line, cells, found):
        """One line: what is fixed, then its cells."""
        printed = "" if found is None else found
        blanked = printed
        for field in line.fields:
            gap = len(printed[field.first:field.last])
            blanked = blanked[:field.first] + " " * gap + blanked[field.last:]
        fixed = (found is not None and blanked.rstrip(" ") == line.text.rstrip(" ")
                 and printed == printed.rstrip(" ") and len(printed) <= len(line.text))
        self.count(LABELS, fixed, f"line {number}: '{found}', thesis '{line.text.rstrip(' ')}'",
                   len(line.text.split()))
        for field, cell in zip(line.fields, cells):
            text = printed[field.first:field.last].ljust(field.last - field.first)
            kind, met = self.cell(field, cell, text)
            table = cell.table
            self.count((table, kind), met,
                       f"line {number}, {cell.place}: printed '{text}', thesis {cell.text}")
            if kind != OPEN:
                self.to_the_last_digit[table] += text == field.lay(cell.text)

    def cell(self, field, cell, printed):
        """How a cell is compared, and whether it is met."""
        exact = self.arithmetic == "ibm370"
        if cell.text == UNSETTLED:
            low, high = self.bounds[cell.table, cell.number, cell.column]
            return OPEN, self.near(field, cell, printed, low, high, exact)
        if exact or field.kind != "F" or exact_everywhere(cell):
            return EXACT, printed == field.lay(cell.text)
        return TOLERATED, self.near(field, cell, printed, cell.text, cell.text, False)

    @staticmethod
    def near(field, cell, printed, low, high, exact):
        """Whether a number in the form of its FORMAT is one of those allowed."""
        text = printed.strip()
        if (not re.fullmatch(rf"\d+\.\d{{{field.decimals}}}", text)
                or field.lay(text) != printed):
            return False
        if exact:
            return float(low) <= float(text) <= float(high)
        allowed = tolerance(cell, float(high)) + half_unit(text) + half_unit(high)
        allowed *= 1 + 1e-9
        return float(low) - allowed <= float(text) <= float(high) + allowed
