"""docs/development/listing-port-scan.md: every mark has its place, and its tables are current."""

import re

import pytest
from builds import ROOT
from listing_page import DATA, DOCUMENT, MADE, begin, inside, records

# Says nothing about the build under test.
pytestmark = pytest.mark.once

PAGE = (ROOT / "docs/development/listing-port-scan.md").read_text(encoding="utf-8")
TABLES = (ROOT / DOCUMENT).read_text(encoding="utf-8")
ROWS = re.findall(r"^\| [^|]+ \| `([\w./]+)`(?:, (\w+))? \| ([^|]+) \| [^|]+ \|$", PAGE,
                  re.MULTILINE)


def marks(text):
    return {(kind.lower(), name)
            for kind, name in re.findall(r"([Ff]ault|[Dd]eviation)s? (\d+|[a-z])\b",
                                         text.replace('"Deviation x"', ""))}


def routine(name, text):
    """A routine and the comments before it."""
    lines = text.splitlines()
    first = next(i for i, line in enumerate(lines)
                 if re.match(rf" *(elemental )?(subroutine|function) {name}\b", line))
    last = next(i for i, line in enumerate(lines)
                if re.match(rf" *end (subroutine|function) {name}$", line))
    while lines[first - 1].lstrip().startswith("!"):
        first -= 1
    return "\n".join(lines[first:last])


def test_every_mark_is_told():
    """What docs/theory/faults.md lists is on the page, once or more, and nothing else is."""
    faults = (ROOT / "docs/theory/faults.md").read_text(encoding="utf-8")
    listed = {("fault", name) for name in re.findall(r"^\| (\d+) \|", faults, re.MULTILINE)}
    listed |= {("deviation", name) for name in re.findall(r"^\| ([a-z]) \|", faults, re.MULTILINE)}
    told = set().union(*(marks(text) for _, _, text in ROWS))
    assert told == listed and len(told) == 29


@pytest.mark.parametrize("file, name, text", [row for row in ROWS if marks(row[2])])
def test_a_mark_stands_where_the_page_says(file, name, text):
    source = (ROOT / "src" / "original" / file).read_text(encoding="utf-8")
    assert marks(text) <= marks(routine(name, source) if name else source)


def test_tables_are_current():
    for name, lines in MADE.items():
        assert inside(TABLES, begin(name))[1].strip("\n").splitlines() == list(lines())


def test_every_correction_is_told():
    told = inside(TABLES, begin("corrections"))[1]
    rows = records(DATA / "corrections.csv")
    cells = re.findall(r"(?:\| |; )\d+ [a-z ]+ (?:`[^`]*`|blank) (?:`[^`]*`|blank)", told)
    assert len(cells) == len(rows) == int(re.search(r"withdrawn, (\d+) in all", TABLES)[1])


def test_what_is_open_is_within_its_bounds():
    rows = re.findall(r"^\| VII\w \| [^|]+ \| [^|]+ \| [a-z]+ \| ([\d.]+) to ([\d.]+) "
                      r"\| ([\d.]+) \|$", inside(TABLES, begin("unsettled"))[1], re.MULTILINE)
    assert len(rows) == 12 and all(low <= printed <= high for low, high, printed in rows)
