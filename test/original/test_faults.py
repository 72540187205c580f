"""docs/theory/faults.md: its marks in the code, and its figures."""

import csv
import math
import re

import pytest

from exact_contact import Truth, read_deck
from programs import run_program


@pytest.fixture(scope="module")
def page(root):
    return (root / "docs/theory/faults.md").read_text()


def row_of(page, name):
    """The row of a table that begins with a number or letter."""
    return next(line for line in page.splitlines() if line.startswith(f"| {name} |"))


@pytest.mark.parametrize("word, row", [(r"[Ff]aults? (\d+)", r"^\| (\d+) \|"),
                                       (r"[Dd]eviation ([a-z])\b", r"^\| ([a-z]) \|")])
def test_every_mark_has_its_row(word, row, root, page):
    """Faults of the page and deviations of the list are marked in the sources of the original."""
    if word.startswith("[Dd]eviation"):
        page = (root / "reference_output/faults/listing_port_scan.md").read_text(encoding="utf-8")
    names = re.findall(row, page, re.MULTILINE)
    assert len(set(names)) == len(names) > 10
    marks = set()
    for file in [*(root / "src" / "original").iterdir(), root / "src/input/card_deck.f90"]:
        # "Deviation x" and "Fault n" are how a file states what its marks refer to.
        marks |= set(re.findall(word, file.read_text().replace('"Deviation x"', "")))
    assert marks == set(names)


def test_the_pages_count_the_faults(root, page):
    last = re.findall(r"^\| (\d+) \|", page, re.MULTILINE)[-1]
    words = {"16": "sixteen"}
    assert f"lists {words[last]}, each" in (root / "docs/theory/original.md").read_text()


def run(asperity, folder, deck, *options):
    """Rows of contacts and positions."""
    run_program(asperity, *options, deck, "--contacts", "c.csv", "--positions", "p.csv", cwd=folder)
    return [[{name: float(text or "nan") for name, text in row.items()}
             for row in csv.DictReader((folder / name).read_text().splitlines())]
            for name in ("c.csv", "p.csv")]


@pytest.fixture(scope="module")
def runs(asperity, root, tmp_path_factory):
    """The thesis' deck: as it printed, without rounding, and by the present-day solver."""
    folder, deck = tmp_path_factory.mktemp("runs"), root / "data" / "thesis.deck"
    return {"printed": run(asperity, folder, deck),
            "exact": run(asperity, folder, deck, "--arithmetic", "real128"),
            "solved": run(asperity, folder, deck, "solve")}


@pytest.mark.truth
def test_rounding_of_the_approach(runs, page):
    off = [a["approach"] - b["approach"] for a, b in zip(runs["printed"][1], runs["exact"][1])]
    assert f"{off[55]:.4f} cm at position 56 and {off[99]:.4f} cm at position 100" in \
        row_of(page, 2)


def test_rounding_of_the_pressure(runs, page):
    def key(row):
        return tuple(int(row[name]) for name in ("position", "step", "upper", "lower"))

    exact = {key(row): row for row in runs["exact"][0]}
    start = {key(row)[0]: row["approach"] for row in runs["exact"][0] if row["step"] == 1}
    whole, every = {}, {}
    for row in runs["printed"][0]:
        if row["load"] > 0:
            true = exact[key(row)]
            error = abs(row["average_pressure"] / true["average_pressure"] - 1)
            every[key(row)] = error
            step = start[key(row)[0]] - true["approach"]
            if row["step"] == 2 and row["area_no"] == 1 and abs(step - 0.001) < 1e-9:
                whole[key(row)] = error
    worst, worst_whole = max(every, key=every.get), max(whole, key=whole.get)
    row = row_of(page, 3)
    assert f"up to {100 * whole[worst_whole]:.3f} % (position {worst_whole[0]})" in row
    assert f"{100 * every[worst]:.1f} % at most (position {worst[0]})" in row
    assert f"{100 * every[56, 2, 10, 2]:.1f} % in Table VIIC (764 for 779" in row
    assert round(exact[56, 2, 10, 2]["average_pressure"]) == 779


def test_rounding_of_the_total_loads(runs, root):
    off = [abs(a["load"] / b["load"] - 1) for a, b in zip(runs["printed"][1], runs["exact"][1])]
    shown = (root / "docs/theory/original.md").read_text()
    assert f"{100 * max(off):.1f} % (fault 3: no total load has a larger error)" in shown


def test_overshoot(runs, page):
    over = [100 * (a["load"] / b["load"] - 1)
            for a, b in zip(runs["printed"][1], runs["solved"][1])]
    assert f"{sum(over) / 100:.1f} % too high on average over the positions and " \
        f"{max(over):.1f} % at most (position {over.index(max(over)) + 1})" in row_of(page, 4)


def last_contacts(runs, name):
    contacts, positions = runs[name]
    steps = {row["position"]: row["steps"] for row in positions}
    return [row for row in contacts if row["step"] == steps[row["position"]]]


def test_vertical_parts(runs, page):
    short = []
    for position in runs["printed"][1]:
        rows = [row for row in last_contacts(runs, "printed")
                if row["position"] == position["position"]]
        vertical = sum(row["load"] / (1 + row["slope"] ** 2) ** 0.5 for row in rows)
        short.append(100 * (1 - vertical / position["load"]))
    assert f"{sum(short) / 100:.1f} % less on average and {max(short):.1f} % at most " \
        f"(position {short.index(max(short)) + 1})" in row_of(page, 8)


def test_contacts_that_count(runs, page):
    """Averages by the right and the wrong count; none left out; one without load."""
    rows = last_contacts(runs, "printed")
    loaded = [row for row in rows if row["load"] > 0]
    counted = passed = 0
    for number, row in enumerate(loaded):
        passed = row["limit_exceeded"] or (passed and number > 0 and
                                           row["position"] == loaded[number - 1]["position"])
        counted += bool(passed)
    assert counted == len(loaded) == len(runs["solved"][0])
    assert "None is left out on the thesis' deck" in row_of(page, 13)
    (idle,) = [row for row in rows if not row["load"] > 0]
    assert f"One of the {len(rows)} contacts counted (position {idle['position']:.0f}) has no " \
        f"load: the average is {len(rows) / 100:.2f} for {len(loaded) / 100:.2f}" in \
        row_of(page, 15)
    differences = sum(100 * (1 - row["projected_area"] / row["area"]) for row in runs["printed"][1])
    assert f"It prints {differences / counted:.1f} %; {differences / 100:.1f} % is correct" in \
        row_of(page, 1)


def test_prices_of_single_faults(runs, root):
    """Faults whose correction changes no approach, computed again from the contacts' table."""
    rows, positions = last_contacts(runs, "printed"), runs["printed"][1]
    with open(root / "reference_output/faults/table_vi.csv", encoding="ascii") as file:
        prices = {(row["mended"], row["quantity"], row["column"]): float(row["mended_to"])
                  for row in csv.DictReader(file)}
    vertical = [sum(row["load"] / math.hypot(1, row["slope"]) for row in rows
                    if row["position"] == position["position"]) for position in positions]
    found = {
        ("divisor", "total_area_difference", "average"):
            sum(100 * (1 - row["projected_area"] / row["area"]) for row in positions) / 100,
        ("count", "contact_points", "average"): sum(row["load"] > 0 for row in rows) / 100,
        ("normal-load", "total_load", "maximum"): max(vertical),
        ("normal-load", "total_load", "minimum"): min(vertical),
        ("normal-load", "total_load", "average"): sum(vertical) / 100}
    for cell, value in found.items():
        # The program adds 100 numbers of 24 bits and cuts each sum.
        assert value == pytest.approx(prices[cell], rel=100 * 2.0 ** -20), cell
    assert {cell for cell in prices if cell[0] in ("divisor", "count", "normal-load")} == set(found)


def test_table_vi_without_faults(root):
    """The last column of effects.md is an evaluation with 40 digits, with 3.1416 for pi."""
    page = (root / "reference_output/faults/effects.md").read_text(encoding="utf-8")
    truth = Truth(read_deck(root / "data/thesis.deck"), 40)
    states = [truth.state(m) for m in range(1, 101)]
    values = {"total load": [float(state.vertical_load) for state in states],
              "total contact area": [3.1416 / math.pi * float(state.area) for state in states],
              "contact points": [len(state.contacts) for state in states],
              "approach": [float(state.separation) for state in states],
              "total area difference":
                  [100 * (1 - float(state.projected_area / state.area)) for state in states]}
    seen = 0
    for line in page.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        quantity, _, column = cells[0].rpartition(" ")
        if quantity in values and len(cells) > 4:
            of = values[quantity]
            exact = {"maximum": max(of), "minimum": min(of), "average": sum(of) / 100}[column]
            assert f"{exact:.{len(cells[-1].partition('.')[2])}f}" == cells[-1], line
            seen += 1
    assert seen == 13


def test_load_at_first_yield(asperity, root, page, tmp_path):
    """N* of section III.G: the printed value, that of its own numbers, and that of the deck."""
    stress, printed = 2.76 * 0.707 * 3500, 2.43e5  # N/cm2; E_o without its unit

    def load_at(pressure_factor, pressure, radius, modulus):
        return (pressure_factor * math.pi * pressure) ** 3 * (0.75 * radius / modulus) ** 2

    assert round(load_at(3 / 2, 6700, 0.25, printed)) == 19
    modulus = 0.6894 * 4.0e5 / (2 * (1 - 0.42 ** 2))
    assert modulus / 0.6894 == pytest.approx(printed, rel=1e-3)
    right = load_at(2 / 3, stress, 0.635, modulus)
    assert f"N* = 19 N, has 3/2 pi for 2/3 pi, R in inches and E_o in psi, with pressures in " \
        f"N/cm2. Hertz' equation gives {right:.1f} N, or " \
        f"{load_at(2 / 3, stress, 0.635, printed):.1f} N where 2.43e5" in row_of(page, 10)
    scene = tmp_path / "yield.scene"
    scene.write_text(f"&surfaces deck = '{root / 'data/thesis.deck'}' /\n&motion x_first = 5.5 /\n"
                     f"&limit criterion = 'hardy', yield_stress = {stress / 2.76!r} /\n"
                     "&effects interaction = 'off' /\n")
    contacts, _ = run(asperity, tmp_path, scene, "solve")
    assert max(row["load"] for row in contacts) == pytest.approx(right, rel=1e-9)


def test_neighbours(asperity, root, tmp_path, page):
    """Overlapping circles, and what interaction takes off at position 56."""
    done = run_program(asperity, "solve", root / "data" / "thesis.deck")
    assert "circles overlap, at positions 18, 56, 79:" in done.stdout
    scene = tmp_path / "together.scene"
    scene.write_text(f"&surfaces deck = '{root / 'data' / 'thesis.deck'}' /\n"
                     "&motion x_first = 5.6 /\n&effects interaction = 'coupled' /\n")
    done = run_program(asperity, "solve", scene)
    share = re.search(r"^interaction +coupled .* -(\S+ %)", done.stdout, re.MULTILINE)[1]
    assert "At positions 18, 56 (the maximum of Table VI) and 79 two" in row_of(page, 12)
    assert f"`coupled` reduces the vertical load by {share}" in row_of(page, 12)
