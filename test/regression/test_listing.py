"""The digitised FORMAT statements and pages agree with the scanned listing and the printed tables.

The text of the port is compiled again when it changes. Nothing here runs the program.
"""

import os
import re
import shutil
from collections import Counter
from pathlib import Path

import pytest

from builds import ROOT
from listing_formats import BadFormat, fixed_texts, lines_of_format
from programs import run_program
from thesis_report import CONTACT, MODEL, digitised, formats, table_cells

# Says nothing about the build under test.
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


def blanks(text):
    return [len(found[0]) for found in re.finditer(" +", text)]


def test_how_far_the_counts_fix_the_blanks(root):
    """The README says how many texts have blanks that the count alone does not place."""
    texts = [text for statement in formats().values() for text in fixed_texts(statement)]
    placed = [text for text in texts if len(blanks(text)) > 1 and max(blanks(text)) > 1]
    readme = (root / "reference_output" / "thesis" / "README.md").read_text(encoding="utf-8")
    assert f"in {len(placed)} of the {len(texts)} texts" in " ".join(readme.split())


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


def test_each_included_text_is_a_module_that_its_includers_use():
    """fpm sees a change of a module, not of an included text: sections.F90 says how."""
    texts = set()
    for file in (ROOT / "src").glob("*/*.F90"):
        source = file.read_text(encoding="utf-8")
        for name in re.findall(r'^#include "(.*)\.F90"$', source, re.MULTILINE):
            assert f"  use asperity_{name}, only:\n" in source, file
            text = (file.parent / f"{name}.F90").read_text(encoding="utf-8")
            assert re.match(rf"#ifndef [A-Z]+\n(!>.*\n)+module asperity_{name}\n", text)
            texts.add(name)
    assert texts == {"ieee_numbers", "section_iv", "sections", "sections_i_to_iii"}
    for room in ("original", "arithmetic"):
        assert not list((ROOT / "src" / room).glob("*.inc"))


def test_fpm_compiles_users_of_a_changed_text(tmp_path):
    """One arithmetic's numbers in a project of their own."""
    (tmp_path / "src").mkdir()
    for name in ("foundation/kinds.f90", "foundation/decimal.f90", "arithmetic/ieee_numbers.F90",
                 "arithmetic/numbers_real64.F90"):
        shutil.copy(ROOT / "src" / name, tmp_path.joinpath("src", Path(name).name))
    (tmp_path / "fpm.toml").write_text('name = "numbers"\n[preprocess.cpp]\nsuffixes = ["F90"]\n')
    text = tmp_path / "src/ieee_numbers.F90"

    def compiled():
        done = run_program("fpm", "build", "--no-prune", cwd=tmp_path, variables={
            "PATH": f"{ROOT / '.venv/bin'}:{os.environ['PATH']}"})
        return set(re.findall(r"(\w+)\.[fF]90\s+done", done.stdout))

    assert {"kinds", "ieee_numbers", "numbers_real64"} <= compiled()
    text.write_text(text.read_text().replace("real(1.5, KIND)", "(real(1.5, KIND))"))
    assert compiled() == {"ieee_numbers", "numbers_real64"}
