"""The digitised FORMAT statements and pages agree with the scanned listing and the printed tables.

The text of the port is compiled again when it changes. Nothing here runs the program.
"""

import re
from collections import Counter

import pytest

from listing_formats import BadFormat, lines_of_format
from thesis_report import CONTACT, MODEL, digitised, formats, table_cells

# States nothing about the build under test.
pytestmark = pytest.mark.once

# Columns of a table, the FORMAT of a row that places them, and the FORMATs of their heads.
COLUMNS = {"V": (MODEL, "18", ("16", "17")),
           "III": (("index", "x", "y", "height"), "26", ("24", "25")),
           "VII": (CONTACT, "13", ("30", "31", "29", "32")),
           "VI": (("maximum", "minimum", "average"), "43", ("45",))}
# Pages whose every heading word the scan shows; on the others the columns' heads are merged.
COMPLETE = ("1", "2", "3", "4", "8", "16")


def without_blanks(statement):
    """A FORMAT without blanks and without the marks of continued cards ('| 1')."""
    return re.sub(r" \| *\d", "", statement).replace(" ", "")


def texts(*numbers):
    """Fixed texts of FORMATs, one a line, blank in the cells."""
    return [line.text for number in numbers for line in lines_of_format(formats()[number])]


def heads(number):
    return [row for row in digitised("printed_heads") if row["page"] == number]


def over_columns(table, names):
    """The head of one column, or of neighbours: words with half their letters over it."""
    columns, row, head = COLUMNS[table.rstrip("ABC")]
    (line,) = [line for line in lines_of_format(formats()[row]) if line.fields]
    fields = dict(zip(columns, line.fields))
    first, last = fields[names[0]].first, fields[names[-1]].last
    return [word[0] for text in texts(*head) for word in re.finditer(r"\S+", text)
            if 2 * (min(last, word.end()) - max(first, word.start())) >= len(word[0])]


def test_formats_are_those_of_the_scan():
    """Up to blanks and the marks of continued cards; every other difference has a reason."""
    for row in digitised("formats"):
        same = without_blanks(row["scanned"]) == without_blanks(row["format"])
        assert same == (row["reason"] == ""), row["number"]
        assert lines_of_format(row["format"]), row["number"]


def test_a_text_must_have_its_count():
    for statement in ("(25X,9HTOTAL LOAD)", "(25X,11HTOTAL LOAD)", "(25X,10HTOTAL LOAD", "(5XF)",
                      "(10HPROPERTIES,10X5HTOTAL,A)", "(5,F8.5)"):
        with pytest.raises(BadFormat):
            lines_of_format(statement)
    (line,) = lines_of_format("(25X,10HTOTAL LOAD,10X,4H(NT),3F10.0)")
    assert line.text[24:48] == "TOTAL LOAD          (NT)" and len(line.fields) == 3
    assert line.filled(["1438.", "289.", "0."])[48:] == "     1438.      289.        0."


def test_every_page_has_its_place():
    pages = digitised("pages")
    assert [int(page["page"]) for page in pages] == list(range(1, 18))
    for table in dict.fromkeys(page["table"] for page in pages):
        firsts = [int(page["first_row"]) for page in pages
                  if page["table"] == table and page["first_row"]]
        if not firsts:
            continue
        rows = list(table_cells(table))
        room = 21 if table.startswith("VII") else 39
        assert firsts[0] == 1
        ends = firsts[1:] + [len(rows) + 1]
        assert all(0 < end - first <= room for first, end in zip(firsts, ends))
        for page in pages:
            if page["table"] == table:
                _, cells = rows[int(page["first_row"]) - 1]
                assert page["first_cells"].split() == [cell.text for cell in cells[:2]], page


def test_every_format_is_printed():
    used = {number for page in digitised("pages") for number in page["formats"].split()}
    assert used | {"12", "13", "14", "26"} == formats().keys()


@pytest.mark.parametrize("page", digitised("pages")[:16], ids=lambda page: page["page"])
def test_headings_are_those_of_the_printed_tables(page):
    """What the scan of the page shows stands in its FORMATs, over the same columns."""
    run = " ".join(" ".join(texts(*page["formats"].split())).split())
    at = 0
    for row in heads(page["page"]):
        assert (row["scanned"].replace(" ", "") == row["head"].replace(" ", "")) or row["reason"]
        if row["place"] in ("line", "rows"):
            at = run.find(row["head"], at)
            assert at >= 0, row
            at += len(row["head"])
        elif row["place"] != "columns":
            assert over_columns(page["table"], row["place"].split()) == row["head"].split(), row
    if page["page"] in COMPLETE:
        shown = " ".join(row["head"] for row in heads(page["page"])).split()
        assert Counter(shown) == Counter(run.split())
