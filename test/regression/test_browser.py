"""Pages (`--html`) as a browser shows them, on a phone and on a desk: no error in the console, no
text cut off, every figure within the page, wide tables in a box that scrolls."""

import re

import pytest
from browser import measured
from builds import ROOT
from programs import run_program
from surfaces_csv import write_csv_scene

pytestmark = pytest.mark.pages

SCENES = {"one position": "data/examples/one_pair.scene",
          "sweep": "data/examples/thesis.scene",
          "sweep of a few": "data/examples/csv_surfaces.scene",
          "load cycle": "data/examples/effects/cycle.scene",
          "adhesion": "data/examples/effects/gelatine.scene",
          "hold": "data/examples/effects/ten_minutes.scene",
          "map, summits": "data/examples/summits/press.scene",
          "map, pixels": "data/examples/summits/press_samples.scene",
          "no contact at some": "data/hard/none_at_some.scene",
          "no contact": "data/hard/none_at_all.scene",
          "tiny numbers": "data/hard/load_1e-300.scene",
          "huge numbers": "data/hard/unit_2^500.scene",
          "far from the origin": "data/hard/offset_1e6.scene"}
# What a page has, at least: curves, and plans of contacts.
FIGURES = {"one position": 1, "sweep": 103, "load cycle": 2, "map, summits": 3, "map, pixels": 7,
           "many contacts": 1, "long words": 6}


def many_contacts(folder):
    """10,000 summits under a plane."""
    lower = [(i + 0.001 * (j % 7), j, 0.2 + 1e-5 * ((i * 37 + j * 11) % 101), 0.7)
             for i in range(100) for j in range(100)]
    scene = write_csv_scene(folder, [(0, 0, 0, 1)], lower, name="many",
                            loading={"control": "approach", "value": 0.15})
    scene.write_text(re.sub("upper = '[^']*'", "upper = 'plane'", scene.read_text()))
    return scene


def long_words(folder, name="long"):
    """File names without a place to break, units of 16 letters, nearly equal loads, a surface in
    another place and turned."""
    upper = [(0.3 * i, 0.1 * i, 0.2, 1) for i in range(4)]
    scene = write_csv_scene(folder, upper, [(0, 0, .1, 1), (1.2, 0, .1, 1.5)],
                            name=name + "_surface_of_a_specimen" * 6,
                            motion={"x_step": 1e-9, "positions": 3},
                            tilt={"rotation": (0.2, -0.1)},
                            loading={"control": "approach", "value": 0.25})
    scene.write_text(scene.read_text().replace(
        "&surfaces ", "&surfaces units = 'WWWWWWWWWWWWWWWW', 'micropoundforces', "))
    return scene


def page_of(asperity, words, path):
    run_program(asperity, *words, "--quiet", "--html", path, cwd=ROOT)
    return path.read_text(encoding="utf-8")


def test_pages_in_a_browser(asperity, tmp_path):
    """Every kind of page at 400 and 1400 pixels of width."""
    scenes = {**SCENES, "many contacts": many_contacts(tmp_path),
              "long words": long_words(tmp_path)}
    pages = {name: page_of(asperity, ["solve", scene], tmp_path / "page.html")
             for name, scene in scenes.items()}
    pages["accuracy"] = page_of(asperity, ["accuracy", "data/examples/one_pair.scene"],
                                tmp_path / "page.html")
    found, figures, errors = measured(pages, tmp_path)
    assert not errors
    assert {key: sentences for key, sentences in found.items() if sentences} == {}
    for (name, width), number in figures.items():
        assert number >= FIGURES.get(name, 0), (name, width)
