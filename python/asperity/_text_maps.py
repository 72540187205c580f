"""Text files of heights by explicit keywords; other text is refused."""

import re
from collections.abc import Sequence
from typing import Any

from . import _arguments as _a
from ._columns import needed, shown
from ._errors import refused

# Names of the heights in a first line with `x` and `y`, which is read without keywords.
HEIGHTS = ("z", "height", "value", "elevation")
COMMENTS = ("#", "%")
# The first lines of a matrix that the library has written.
NUMBER = rb"(\d\.\d{16}E[-+]\d{3})"
WRITTEN = re.compile(rb"# Spacing: +" + NUMBER + rb" +" + NUMBER + rb"\n"
                     rb"(?:# Units: (m|[munc]m|in)\n)?(?:# Edge: (periodic)\n)?[^#]")
HEADER_BYTES = 128
# Largest distance of a place from its node of the grid, in steps: places are printed with few
# digits. Half a step would make two nodes possible.
ROUNDED = 0.1


def named_columns(path: str) -> tuple[str | None, list[str]] | None:
    """The separator and the names of the columns of x, y and heights, where the first line of a
    text has them; otherwise None."""
    line = _first_line(path)[1]
    found = re.search(r"[,;\t]", line)
    delimiter = found[0] if found else None
    names = _names(line, delimiter)
    wanted = [name for known in (("x",), ("y",), HEIGHTS) for name in names
              if name.lower() in known]
    return (delimiter, wanted) if len({name.lower() for name in wanted}) == len(wanted) == 3 \
        else None


def written_header(path: str) -> tuple[tuple[float, float], str | None, str | None] | None:
    """Spacing, unit and edge that `HeightMap.write` states above a matrix; None of other files."""
    try:
        with open(path, "rb") as file:
            found = WRITTEN.match(file.read(HEADER_BYTES))
    except OSError:
        return None
    if found is None:
        return None
    across, along, unit, edge = (one.decode() if one else None for one in found.groups())
    return (float(across or 0), float(along or 0)), unit, edge


def read_text(path: str, spacing: tuple[float, float] | None, delimiter: str | None, decimal: str,
              columns: Sequence[Any] | None) -> tuple[Any, tuple[float, float]]:
    """Heights and spacing."""
    np: Any = needed("numpy", "numpy", "a text by keywords")
    if decimal not in (".", ",") or (delimiter is not None and (
            len(delimiter) != 1 or delimiter == decimal)):
        raise _a.wrong("delimiter, decimal", f"{delimiter!r}, {decimal!r}",
                       "one sign or None for blanks, and another one, '.' or ','")
    if (columns is None) == (spacing is None):
        raise _a.wrong("spacing", str(spacing), "that of a matrix of heights, or none beside the "
                       "places in columns")
    wanted, heading = None if columns is None else list(columns), 0
    if len(wanted or "xyz") != 3:
        raise _a.wrong("columns", str(columns), "three: x, y and height, as names or from 0")
    if wanted and any(isinstance(one, str) for one in wanted):
        heading, line = _first_line(path)
        names = _names(line, delimiter)
        if not set(wanted) <= set(names):
            raise refused(path, f"found the columns {', '.join(names)}, expected "
                          f"{', '.join(map(str, wanted))}", heading)
        wanted = [names.index(one) for one in wanted]

    def number(text: str) -> float:
        text = text.strip().strip('"')
        if decimal == ",":
            text = text.replace(".", "?").replace(",", ".")
        return float("nan" if text.lower() in ("", "bad") else text)

    try:
        found = np.loadtxt(path, comments=COMMENTS, delimiter=delimiter, converters=number, ndmin=2,
                           skiprows=heading, usecols=wanted, encoding="utf-8-sig")
    except (OSError, ValueError) as error:
        # numpy counts rows from 0 or from 1, and not those of comments.
        raise refused(path, str(error).partition(" at row ")[0]
                       + "; delimiter=, decimal= and columns= state another form") from None
    if found.size == 0:
        raise refused(path, "found no line of numbers")
    if spacing is not None:
        return found, spacing
    nodes, steps = [], []
    for name, places in zip("xy", found.T):
        different = np.unique(places)
        step = (different[-1] - different[0]) / max(1, len(different) - 1)
        node = (places - different[0]) / (step or 1.0)
        if not (step > 0.0 and (np.abs(node - node.round()) <= ROUNDED).all()):
            raise refused(path, f"{name}: found {len(different)} places, step {shown(float(step))}"
                           ", expected a regular grid")
        nodes.append(node.round().astype(int))
        steps.append(float(step))
    heights = np.zeros((max(nodes[1]) + 1, max(nodes[0]) + 1))
    np.add.at(heights, (nodes[1], nodes[0]), 1.0)
    if not (heights == 1.0).all():
        raise refused(path, f"found {len(found)} places, expected each of the "
                       f"{heights.shape[1]} x {heights.shape[0]} of the grid once")
    heights[nodes[1], nodes[0]] = found[:, 2]
    return heights, (steps[0], steps[1])


def _first_line(path: str) -> tuple[int, str]:
    """The number and the text of the first line that is no comment."""
    with open(path, encoding="utf-8-sig", errors="replace") as file:
        return next(((number, line) for number, line in enumerate(file, 1)
                     if line.strip() and not line.lstrip().startswith(COMMENTS)), (0, ""))


def _names(line: str, delimiter: str | None) -> list[str]:
    return [name.strip().strip('"') for name in line.rstrip("\n").split(delimiter)]
