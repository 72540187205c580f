"""The port against a second text of SECTIONS I to V: every bit of every contact, and Table VI.

The second text (test/truth/listing_text.py) was written from Appendix 4 and shares no line with
`src/original`. Both take the readings of the scan from
reference_output/faults/listing_port_scan.md.
"""

import csv
import random
import re

import pytest

import listing_text
from decks import random_model, write_deck
from programs import run_program

# The thesis' deck has 2491 contacts; a made one that ends early would compare little.
LEAST_CONTACTS = 100
VALUES, FIELD = 48, 10  # columns before the values of Table VI, and of each of them


def model(rng_seed, count, length, radius=0.5, height=0.07, modulus=400000.0, ratio=0.42):
    return random_model(random.Random(rng_seed), count, length, 3.0, radius, height, modulus, ratio)


def made(seed, upper=12, lower=60, over=None, under=None, **other):
    """Models of a seed; the lower one reaches 4 in beyond the upper one."""
    return {"upper": model(seed, upper, 4.0) | (over or {}),
            "lower": model(seed + 1000, lower, 8.0) | (under or {}), **other}


def facing(count):
    """As many pairs of one height as the list has places, and a row of lower asperities."""
    places = [(round(0.7 * (i % 7), 3), round(0.5 * (i // 7), 3)) for i in range(count)]
    return {"upper": {**model(0, 1, 1.0), "asperities": [(x, y, 0.06) for x, y in places]},
            "lower": {**model(0, 1, 1.0), "asperities":
                      [(round(x + 2.0, 3), round(3.0 - y, 3), 0.06) for x, y in places]
                      + [(round(0.25 * i, 3), 1.5, 0.05) for i in range(36)]},
            "width": 3.0}


FAST = {
    "tilted": made(1, angles=(0.0125, -0.0075)),
    "radii of 1/4 and 1": made(2, over={"radius": 0.25}, under={"radius": 1.0}),
    "stiff": made(3, over={"modulus": 4.0e8}, under={"modulus": 4.0e8}),
    "ties": made(4, over={"radius": 9.0, "height_max": 0.9,
                          "asperities": [(2.0, 1.5, 0.07)] * 3 + [(1.0, 1.0, 0.065)] * 2},
                 under={"radius": 9.5}, lower=4),
    "no pair": made(5, over={"asperities": [(0.5, 1.5, 0.06)]},
                    under={"asperities": [(0.8, 1.955, 0.06)]}),
}
SLOW = {
    "37 facing pairs": facing(37),
    "turned by 2 pi": made(6, angles=(6.2832, 6.2832)),
    "shifted in print": made(7, displacement=(1.0, -0.5)),
    "soft": made(8, over={"modulus": 150000.0}, under={"modulus": 150000.0}),
    "unlike bodies": made(9, over={"modulus": 30000000.0, "ratio": 0.3}, under={"ratio": 0.1}),
    "38 lower": made(10, upper=37, lower=38),
    "one upper": made(11, upper=1, lower=9, over={"radius": 9.0, "height_max": 0.9}),
    "full arrays": made(12, upper=37, lower=75),
    "stated heights of 0.03": made(13, over={"height_max": 0.03}, under={"height_max": 0.03},
                                   upper=30, lower=75),
    "Poisson 0.9": made(14, over={"ratio": 0.9}),
    "tall cap": made(15, over={"asperities": [(2.0, 1.5, 1.1)]}, lower=400),
    "narrow": made(16, width=2.8),
    "flat": made(17, over={"radius": 9.0, "height_max": 0.9}, under={"radius": 9.5},
                 upper=4, lower=6),
    "large turn": made(18, angles=(0.2, -0.3), lower=75),
}


@pytest.fixture(scope="module")
def thesis(root):
    return (root / "data" / "thesis.deck").read_text(encoding="ascii")


def table_vi(report):
    """Label and cells of the rows of Table VI."""
    page = next(page for page in report.split("\f") if re.search(r"^ +TABLE VI$", page, re.M))
    for line in page.splitlines():
        label = line[:VALUES].partition("(")[0].strip()
        cells = [line[at:at + FIELD].strip(" )") for at in range(VALUES, VALUES + 3 * FIELD, FIELD)]
        if all(re.fullmatch(r"-?[\d.]+|\*+", cell) for cell in cells):
            yield label, cells


def compare(asperity, folder, text):
    """Contacts compared. The port must stop where the second text stops."""
    (folder / "d.deck").write_text(text)
    done = run_program(asperity, "d.deck", "--contacts", "c.csv", status=None, cwd=folder)
    expected = listing_text.run(text)
    if expected.stopped:
        assert done.returncode == 1
        assert f"position {expected.stopped}:" in done.stderr
        return len(expected.contacts)
    assert done.returncode == 0, done.stderr
    with open(folder / "c.csv", encoding="ascii") as file:
        rows = [tuple(map(float, row)) for row in list(csv.reader(file))[1:]]
    for row, contact in zip(rows, expected.contacts):
        assert row == tuple(map(float, contact))
    assert len(rows) == len(expected.contacts)
    printed = dict(table_vi(done.stdout))
    assert printed.keys() == expected.table_vi.keys()
    for label, values in expected.table_vi.items():
        for cell, value in zip(printed[label], values):
            if len(str(value)) > FIELD or value == float("inf"):
                assert set(cell) == {"*"}, label
            else:
                assert listing_text.Decimal(cell) == value, label
    return len(rows)


def test_thesis_deck(asperity, tmp_path, thesis):
    assert compare(asperity, tmp_path, thesis) == 2491


@pytest.mark.parametrize("name", FAST)
def test_made_deck(name, asperity, tmp_path):
    write_deck(tmp_path / "made.deck", **FAST[name])
    compared = compare(asperity, tmp_path, (tmp_path / "made.deck").read_text())
    assert name == "no pair" or compared >= LEAST_CONTACTS


@pytest.mark.truth
@pytest.mark.parametrize("name", SLOW)
def test_further_deck(name, asperity, tmp_path):
    write_deck(tmp_path / "made.deck", **SLOW[name])
    assert compare(asperity, tmp_path, (tmp_path / "made.deck").read_text()) >= LEAST_CONTACTS
