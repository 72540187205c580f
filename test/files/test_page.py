"""The page of a run (`--html`): read by a parser that forgives nothing; it holds what the CSV files
and the summary hold, loads nothing, and can be read without eyes and without a mouse."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from builds import ROOT
from programs import run_program
from surfaces_csv import records, write_csv_scene

SCENES = ("data/examples/csv_surfaces.scene", "data/examples/position_56.scene",
          "data/examples/effects/ten_minutes.scene", "data/hard/none_at_some.scene",
          "data/hard/none_at_all.scene", "data/hard/effects/inside_circle_auto.scene",
          "data/hard/load_1e-300.scene", "data/hard/unit_2^500.scene")


class Page:
    """The elements of a page in order, each with its attributes, text and place in the tree."""

    def __init__(self, text):
        assert text.startswith("<!DOCTYPE html>\n")
        self.all = []
        self.add(ElementTree.fromstring(text.partition("\n")[2]), [])

    def add(self, node, outer):
        element = {"tag": node.tag, "text": "".join(node.itertext()), "in": outer, **node.attrib}
        self.all.append(element)
        for part in node:
            self.add(part, [*outer, element])

    def of(self, tag, within=None):
        return [element for element in self.all if element["tag"] == tag
                and (within is None or any(outer is within for outer in element["in"]))]

    def rows(self, table):
        return [[cell["text"] for cell in self.all if cell["tag"] in ("th", "td")
                 and any(outer is row for outer in cell["in"])] for row in self.of("tr", table)]


def page_of(asperity, scene, path, *words, **more):
    done = run_program(asperity, "solve", scene, "--html", path, *words, cwd=ROOT, **more)
    text = path.read_bytes().decode()
    return Page(text), text, done


def near(text, cell, digits=6):
    value = float(cell)
    return abs(float(text) - value) <= 0.5000001 * 10.0**(1 - digits) * abs(value)


def table_named(page, beginning):
    return [table for table in page.of("table")
            if page.of("caption", table)[0]["text"].startswith(beginning)]


@pytest.mark.parametrize("name", SCENES)
def test_page_can_be_read(name, asperity, tmp_path):
    """One language, one title, headings in order, a name for every region, drawing and table."""
    page, text, _ = page_of(asperity, name, tmp_path / "r.html")
    assert page.all[0]["lang"] == "en" and len(page.of("h1")) == len(page.of("main")) == 1
    assert page.of("title")[0]["text"] == page.of("h1")[0]["text"] == name
    assert not re.search(r'https?:|<script|\bsrc=|\bhref="[^#]|url\(|@import', text)
    identities = [element["id"] for element in page.all if "id" in element]
    assert len(identities) == len(set(identities))
    for section in page.of("section"):
        assert page.of("h2", section)[0]["id"] == section["aria-labelledby"]
    for element in page.all:
        if element.get("role") == "region" or element["tag"] == "svg":
            assert element["aria-label"]
        if "tabindex" in element:
            assert element["tabindex"] == "0" and element["aria-label"] and element["role"]
    for table in page.of("table"):
        rows = page.rows(table)
        assert page.of("caption", table)[0]["text"] and len({len(row) for row in rows}) == 1
        for row in page.of("tr", table):
            heads = [cell.get("scope") for cell in page.of("th", row)]
            assert heads in (["row"], ["col"] * len(rows[0]))


@pytest.mark.parametrize("name", SCENES)
def test_page_holds_all(name, asperity, tmp_path, tally):
    """Every position and contact with its numbers and at its place, summary, warnings, scene."""
    page, _, done = page_of(asperity, name, tmp_path / "r.html", "--positions", tmp_path / "p",
                            "--contacts", tmp_path / "c")
    positions, contacts = records(tmp_path / "p"), records(tmp_path / "c")
    ends = [[row for row in contacts if row["position"] == place["position"]
             and row["step"] == place["steps"]] for place in positions]
    words = re.sub(r"\s+", " ", " ".join(element["text"] for element in page.of("main")))
    for line in done.stderr.splitlines():
        assert re.sub(r"\s+", " ", line) in words
    totals, effects = re.split(r"\n\nEffects.*\n", done.stdout + "\n\nEffects\n")[:2]
    for line in totals.splitlines()[:3]:
        assert line in words
    assert re.sub(r"\s+", " ", effects).split() == \
        [word for part in page.of("dl") for word in part["text"].split()]
    for line in totals.splitlines()[5:]:
        for number in re.findall(r"(?<=\s)-?[\d.]+(?:E[+-]\d+)?(?=\s|$)", line)[:3]:
            assert any(near(cell, number) for row in page.rows(table_named(page, "totals")[0])[1:]
                       for cell in row[1:]) or number in words, line
    # The scene is a text of lines: a first line end after <pre> is none of it.
    assert page.of("pre")[-1]["text"].removeprefix("\n").split() == \
        (ROOT / name).read_text(encoding="utf-8").split()
    met = 0
    if len(positions) > 1:
        [table] = table_named(page, "positions")
        header, *rows = page.rows(table)
        assert len(rows) == len(positions)
        for row, place in zip(rows, positions):
            for column, cell in zip(header, row):
                met += cell == {"0": "no", "1": "yes"}[place[column]] \
                    if column == "limit_reached" else near(cell, place[column]) \
                    if re.match(r"[-+.\d]", place[column]) else cell == place[column]
        assert met == len(rows) * len(header)
    rows = [row for table in table_named(page, "contacts, ") for row in page.rows(table)[1:]]
    header = ["area_no", "x", "y", "contact_radius", "load", "average_pressure", "maximum_pressure"]
    expected = [row for end in ends for row in end]
    assert len(rows) == len(expected)
    for row, contact in zip(rows, expected):
        assert all(near(cell, contact[column]) for column, cell in zip(header, row))
    circles = [circle for circle in page.of("circle") if "class" not in circle]
    assert len(circles) == len(expected)
    tally.add("page: contacts", len(expected), len(circles))
    for circle, contact in zip(circles, expected):
        said = page.of("title", circle)[0]["text"]
        number, load = re.match(r"(\d+): load ([^,]+)", said).groups()
        assert number == contact["area_no"] and near(load, contact["load"], 4)
    if len(circles) > 2:
        drawn = np.array([[float(c[key]) for key in ("cx", "cy", "r")] for c in circles])
        true = np.array([[float(c[key]) for key in ("x", "y", "contact_radius")]
                         for c in expected])
        scale = np.ptp(drawn[:, 0]) / np.ptp(true[:, 0]) if np.ptp(true[:, 0]) else \
            np.ptp(drawn[:, 1]) / np.ptp(true[:, 1])
        span = np.ptp(true[:, :2], axis=0) * scale
        assert (np.abs(np.ptp(drawn[:, :2], axis=0) - span) < 0.03 + 1e-3 * span).all()
        shift = drawn[:, :2] - true[:, :2] * scale * [1, -1]
        assert (np.ptp(shift, axis=0) < 0.06).all()
        radius = np.maximum(true[:, 2] * scale, 0.5)
        assert (np.abs(drawn[:, 2] - radius) < 0.006 * radius).all()


def scales(page, svg):
    """Of both axes the line from places to values, by the numbers along them."""
    marks = {"M": [], "H": []}
    parts = [part for part in page.all if any(outer is svg for outer in part["in"])]
    for path, text in zip(parts, parts[1:]):
        place = re.fullmatch(r"M(?P<M>\S+) 0V\S+|M0 (?P<H>\S+)H\S+", path.get("d", ""))
        if place:
            key = "M" if place["M"] else "H"
            marks[key].append((float(place[key]), text["text"]))
    return [np.polyfit([place for place, _ in part], [float(text) for _, text in part], 1)
            for part in marks.values()]


def path_points(path):
    return np.array([list(map(float, pair.split())) for pair in re.findall(r"[ML]([^MLz]+)",
                                                                           path["d"])])


def test_curves_of_a_page_are_the_states(asperity, tmp_path):
    """Load over compression and area over load, with an arrow a branch of the cycle."""
    page, _, _ = page_of(asperity, "data/examples/effects/cycle.scene", tmp_path / "r.html",
                         "--curve", tmp_path / "c")
    states = records(tmp_path / "c")
    load, area, apart = (np.array([float(row[name]) for row in states])
                         for name in ("load", "area", "separation"))
    path = page.of("pre")[0]["text"].split("\n")
    assert [line[:5] for line in path if line.startswith("end ")] == \
        [f"end {number}" for number in range(1, 7)] and "largest load" in path[-3]
    assert path[-2].startswith("energy lost in each cycle (N cm): ")
    sections = [section["aria-labelledby"] for section in page.of("section")]
    assert sections == ["summary", "curves", "contacts", "effects", "origin"]
    for svg, x, y, names in zip(page.of("svg"), (apart[0] - apart, load), (load, area),
                                (("compression (cm)", "load (N)"),
                                 ("load (N)", "contact area (cm2)"))):
        assert [text["text"] for text in page.of("text", svg) if "(" in text["text"]] == \
            list(names)
        [curve] = [path for path in page.of("path", svg) if path["class"] == "curve"]
        drawn = path_points(curve)
        for k, values in enumerate((x, y)):
            there = np.polyval(scales(page, svg)[k], drawn[:, k])
            assert np.abs(there - values).max() < 1e-3 * np.ptp(values)
        arrows = [path for path in page.of("path", svg) if path["class"] == "arrow"]
        assert len(arrows) == 6
        # Up along the first branch, down along the second, in the drawing.
        turns = [float(re.search(r"rotate\((.*)\)", arrow["transform"])[1]) for arrow in arrows]
        assert all(-90 < turn < 0 for turn in turns[::2]) and \
            all(90 < turn < 180 for turn in turns[1::2])


def test_page_of_any_text(asperity, tmp_path):
    """Names and comments are text on the page, whatever letters they have."""
    folder = tmp_path / 'a<b> & "c"'
    folder.mkdir()
    scene = write_csv_scene(folder, [(0, 0, .2, 1)], [(0, 0, .1, 1)], name='<i>"&amp;',
                            loading={"control": "approach", "value": 0.29})
    said = b'! </pre><script>alert("1 < 2 && 3 > 2")</script> \xc2\xb5m\r\n!\ttab \xe4 ]]> <!--'
    scene.write_bytes(scene.read_bytes() + said)
    page, text, _ = page_of(asperity, scene, tmp_path / "r.html", "--quiet")
    assert page.of("h1")[0]["text"] == str(scene) and not page.of("script")
    told = page.of("pre")[-1]["text"].removesuffix("\n").split("\n")
    assert told[-2:] == ['! </pre><script>alert("1 < 2 && 3 > 2")</script> µm', "! tab ? ]]> <!--"]
    assert "\r" not in text


@pytest.mark.long
@pytest.mark.parametrize("side, positions", [(100, 1), (10, 100)])
def test_large_page(side, positions, asperity, tmp_path):
    """10,000 contacts are a page below a megabyte, and each has its circle."""
    upper = [(i + 0.001 * (j % 7), j, 0.2 + 1e-5 * ((i * 37 + j * 11) % 101), 0.7)
             for i in range(side) for j in range(side)]
    scene = write_csv_scene(tmp_path, upper, [(0, 0, 0, 1)],
                            motion={"x_step": 0.013, "positions": positions},
                            loading={"control": "approach", "value": 0.15})
    text = scene.read_text()
    scene.write_text(re.sub(r"lower = '[^']*'", "lower = 'plane'", text))
    page, text, _ = page_of(asperity, scene, tmp_path / "r.html", "--quiet")
    circles = [circle for circle in page.of("circle") if "class" not in circle]
    assert len(circles) == 10**4 and len(text.encode()) < 10**6
    stops = [element for element in page.all if element["tag"] == "g" and "tabindex" in element]
    assert len(stops) == (100 if positions > 1 else 0)
    assert len([use for use in page.of("use") if use["href"] == "#axes"]) == positions - 1
    # A copy of the axes is outside the drawing for the style: it knows its letters by name alone.
    assert "\ntext{" in text and "svg text" not in text
    rows = [row for table in table_named(page, "contacts, ") for row in page.rows(table)[1:]]
    assert len(rows) == 500
    assert "500 rows of contacts at most" in page.of("main")[0]["text"]


def test_page_in_pieces(asperity, tmp_path):
    """A page goes to standard output, and appears whole or not at all."""
    scene = "data/examples/one_pair.scene"
    _, text, _ = page_of(asperity, scene, tmp_path / "r.html")
    done = run_program(asperity, "solve", scene, "--html", "-", cwd=ROOT, text=False)
    assert done.stdout.decode() == text
    full = run_program(asperity, "solve", scene, "--html", "/dev/full", "--json",
                       tmp_path / "r.json", status=1, cwd=ROOT)
    assert "/dev/full: cannot be written" in full.stderr
    assert not (tmp_path / "r.json").exists()
