"""The page of the columns: every column of every file is there, and none that is not written."""

import csv
import re

import pytest
from builds import ROOT
from programs import run_program
from surfaces_csv import write_scene

# Of the release build: what other builds write has the same columns.
pytestmark = pytest.mark.pages

EFFECTS = ("interaction", "friction", "plasticity", "adhesion", "creep")
SCENES = sorted([*ROOT.glob("data/examples/*.scene"), *ROOT.glob("data/examples/effects/*.scene"),
                 ROOT / "data/hard/effects/inside_circle_auto.scene",
                 ROOT / "data/hard/none_at_some.scene"])
FILES = ("--positions", "--curve", "--contacts")
HOME = {"`--positions` of `asperity solve`": "--positions",
        "`--curve` of `asperity solve`": "--curve",
        "`--contacts` of `asperity solve`": "--contacts"}


def page():
    """For every heading of the page the rows of its table: name, unit and meaning, in order."""
    text = (ROOT / "docs/reference/columns.md").read_text(encoding="utf-8")
    found = {}
    for heading, body in re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", text, re.M | re.S):
        rows = found[heading] = {}
        for names, unit, meaning in re.findall(r"^\| (`.*?) \| (.*?)\| (.*) \|$", body, re.M):
            for name in re.findall(r"`(\w+)`", names):
                for one in EFFECTS if "EFFECT" in name else ("",):
                    own = name.replace("EFFECT", one)
                    assert own not in rows, f"{heading}: {own} twice"
                    rows[own] = unit.strip(), meaning
    return found


def read(path):
    """Header and rows of a CSV file."""
    with open(path, encoding="ascii", newline="") as file:
        header, *rows = csv.reader(file)
    assert len(set(header)) == len(header), f"{path}: a column twice"
    return header, rows


def run(asperity, *words):
    run_program(asperity, *words, cwd=ROOT)


@pytest.fixture(scope="module")
def solved(asperity, tmp_path_factory):
    """The three files of many scenes: a map on a nominal area, effects that are off, ..."""
    folder = tmp_path_factory.mktemp("columns")
    map_scene = write_scene(
        folder / "map.scene", surfaces={"upper": "plane", "nominal_area": 1e-9,
                                        "lower": str(ROOT / "data/examples/summits/rough.sdf")},
        material={"contact_modulus": 1e11}, effects={"interaction": "boundary"},
        loading={"control": "vertical_load", "value": 5e-4, "points": 2})
    off = write_scene(
        folder / "off.scene", surfaces={"deck": str(ROOT / "data/thesis.deck")},
        effects={**dict.fromkeys(EFFECTS, "off"), "friction_coefficient": 0.1,
                 "plastic_yield_stress": 6000.0, "work_of_adhesion": 1e-3,
                 "equilibrium_distance": 1e-7, "relaxation_time": 1.0, "hold_time": 1.0,
                 "relaxed_modulus_ratio": 0.5})
    plastic = write_scene(
        folder / "plastic.scene", surfaces={"upper": "plane", "form_radius": (0, 1e3), "lower": str(
            ROOT / "data/examples/summits/rough.sdf")},
        material={"contact_modulus": 1e11, "electrical_conductivity": (6e7, 6e7),
                  "thermal_conductivity": (400, 400)}, effects={
            "interaction": "boundary", "plasticity": "on", "plastic_hardness": 1e9},
        loading={"control": "vertical_load", "value": (5e-4, 0.0)})
    slip = write_scene(
        folder / "slip.scene", surfaces={"upper": "plane", "lower": str(
            ROOT / "data/examples/summits/rough.sdf")},
        material={"elastic_modulus": (2e11, 2e11), "poisson_ratio": (0.3, 0.3)}, effects={
            "interaction": "boundary", "friction_coefficient": 0.2},
        loading={"control": "vertical_load", "value": 5e-4, "tangential_load": 5e-5})
    sticky = write_scene(
        folder / "sticky.scene", surfaces={"upper": "plane", "lower": str(
            ROOT / "data/examples/summits/rough.sdf")},
        material={"contact_modulus": 1e11}, effects={
            "interaction": "boundary", "work_of_adhesion": 1.0, "equilibrium_distance": 1e-8},
        loading={"control": "vertical_load", "value": 5e-4})
    tables = {name: [] for name in FILES}
    for scene in (*SCENES, map_scene, off, plastic, slip, sticky):
        words = [word for name in FILES for word in (name, folder / name[2:])]
        run(asperity, "solve", scene, "--quiet", *words)
        for name in FILES:
            tables[name].append((scene.name, *read(folder / name[2:])))
    return tables


@pytest.mark.parametrize("heading", HOME)
def test_columns_of_solve(heading, solved):
    """The page has the columns that are written, in the order in which they are written."""
    shown = page()[heading]
    written = set()
    for scene, header, _ in solved[HOME[heading]]:
        written |= set(header)
        # Effects stand in the order in which they act, which is not that of the page.
        own = [name for name in header if name in shown and ":" not in shown[name][1]
               and "EFFECT" not in shown[name][1] and not name.startswith(EFFECTS)]
        assert own == [name for name in shown if name in own], scene
    assert written == set(shown)


def test_columns_of_the_others(asperity, tmp_path):
    shown = page()
    run(asperity, "data/thesis.deck", "--positions", tmp_path / "p", "--contacts", tmp_path / "c")
    run(asperity, "summits", "data/examples/summits/rough.sdf", "--output", tmp_path / "s")
    run(asperity, "summits", "data/examples/summits/smooth.sdf", "--spectrum", tmp_path / "f")
    (tmp_path / "a.spec").write_text("&surfaces number = 9, length = 1., width = 2. /\n"
                                     "&radii mean = 3. / &heights mean = 0.1, deviation = 0.01 /\n")
    run(asperity, "generate", tmp_path / "a.spec", "--output", tmp_path / "g")
    run(asperity, "accuracy", "data/thesis.deck", "--seconds", "6", "--csv", tmp_path / "a")
    for heading, file in (("`--positions` of `asperity DECK`", "p"), ("Surfaces", "s"),
                          ("`--contacts` of `asperity DECK`", "c"), ("Surfaces", "g"),
                          ("`--spectrum` of `asperity summits`", "f"),
                          ("`--csv` of `asperity accuracy`", "a")):
        header, rows = read(tmp_path / file)
        assert header == list(shown[heading]), heading
        for name, cells in zip(header, zip(*rows)):
            if "" in cells:
                assert re.search("empty", shown[heading][name][1]) or file == "a", name
    assert len(shown) == 9
