"""Comparisons of asperity with a number of another program or of a closed form of its suite."""

from dataclasses import dataclass

import asperity
from judge import is_met


@dataclass
class Comparison:
    """A number of the other side, ours, and the largest absolute difference. `reason` states why a
    difference is expected; it is empty where the numbers have to agree."""

    suite: str
    name: str
    expected: float
    found: float
    tolerance: float
    reason: str = ""

    @property
    def met(self):
        return bool(is_met(self.found - self.expected, self.tolerance))


def half_unit(printed):
    """Half a unit in the last place of a printed number, as 0.5E-5 of 7.258E-02."""
    digits, _, exponent = printed.upper().partition("E")
    decimals = len(digits.partition(".")[2])
    # The last bits of a decimal fraction must not decide.
    return 0.5000001 * 10.0 ** (int(exponent or 0) - decimals)


class Suite:
    """The comparisons of one suite, in their order."""

    def __init__(self, name, source):
        self.name, self.source, self.rows = name, source, []

    def within(self, name, expected, found, relative, reason=""):
        """A number within a relative difference."""
        self.rows.append(Comparison(self.name, name, float(expected), float(found),
                                    relative * abs(float(expected)), reason))

    def near(self, name, expected, found, absolute, reason=""):
        """A number within an absolute difference."""
        self.rows.append(Comparison(self.name, name, float(expected), float(found), absolute,
                                    reason))

    def printed(self, name, text, found, reason=""):
        """A number to all digits that are printed."""
        self.near(name, float(text), found, half_unit(text), reason)

    def count(self, name, expected, found, reason=""):
        """A whole number."""
        self.near(name, expected, found, 0.0, reason)


def last_contact(results):
    """The columns of the contact of the last state."""
    return {name: column[-1] for name, column in results.contacts.items()}


def spheres(overlap, radius, modulus, **effects):
    """A flat on a sphere of a combined radius, along a path of overlaps."""
    path = [overlap] if isinstance(overlap, float) else list(overlap)
    return asperity.solve({
        "surfaces": {"upper": "plane",
                     "lower": {"x": [0.0], "y": [0.0], "height": [0.5 * radius],
                               "radius": [radius]}},
        "material": {"contact_modulus": modulus},
        "loading": {"control": "separation",
                    "value": [0.5 * radius - value for value in path]},
        "effects": {"interaction": "off", **effects}})


def pixels(heights, spacing, modulus, control, value, periodic=False, **effects):
    """A height map on its pixels under a flat, with the fields of its states."""
    surface = asperity.HeightMap(heights, spacing, periodic=periodic)
    return asperity.solve({
        "surfaces": {"upper": "plane", "lower": surface, "map_level": "none"},
        "material": {"contact_modulus": modulus}, "loading": {"control": control, "value": value},
        "effects": {"interaction": "boundary", **effects}}, fields=True)
