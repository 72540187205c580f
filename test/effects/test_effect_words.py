"""Which effects a scene may name, what each needs, and where `auto` calls for them."""

import itertools
import math
import re
from itertools import product

import numpy as np
import pytest

from ball_scenes import balls
from effect_runs import DECK, ROOT, SHOWN, effect_rows
from judge import column, compare, solved
from surfaces_csv import records, solve, write_scene

EXAMPLES = ROOT / "data" / "examples" / "effects"
ON = {"interaction": ("coupled", "boundary"), "friction": ("on",), "plasticity": ("on",),
      "adhesion": ("on",), "creep": ("on",)}
NO_EFFECTS = dict.fromkeys(ON, "off")
NUMBERS = {"friction_coefficient": 0.1, "plastic_yield_stress": 6000.0, "work_of_adhesion": 1e-3,
           "equilibrium_distance": 1e-7, "relaxation_time": 1.0, "relaxed_modulus_ratio": 0.5,
           "hold_time": 1.0,
           # Coarse cells: what is asked is whether, not how much.
           "boundary_tolerance": 0.1}
LIGHT = {"control": "load", "value": 20.0}
# Why two effects are not added up.
REFUSED = {
    ("adhesion", "plasticity"): "the theories of adhesion are elastic",
    ("adhesion", "creep"): "the theory of creep has no attraction",
    ("adhesion", "interaction"): "displacements by neighbours assume Hertzian",
    ("adhesion", "friction"): "shear changes adhesion",
    ("creep", "plasticity"): "the theory of creep is for elastic contacts",
    ("creep", "friction"): "slip and creep together have no closed theory",
}


def why(first, second, word):
    """The sentence for a pair, if it is refused."""
    pair = tuple(sorted((first, second)))
    if pair == ("interaction", "plasticity") and word == "boundary":
        return "boundary elements are elastic: use interaction = 'coupled'"
    return REFUSED.get(pair) or REFUSED.get(pair[::-1])


def run(asperity, folder, **groups):
    """A scene of the thesis model at its position 56, each in a file of its own."""
    name = f"{len(list(folder.iterdir()))}.scene"
    return solve(asperity, write_scene(folder / name, surfaces={"deck": str(DECK)},
                                       motion={"x_first": 5.6}, **groups))


def test_every_pair_of_effects_is_computed_or_refused(asperity, tmp_path):
    """Every pair: refused with its sentence, or computed."""
    pairs = [(a, b, wa, wb) for i, a in enumerate(ON) for b in list(ON)[:i]
             for wa, wb in product(ON[a], ON[b])]
    refused = 0
    for first, second, first_word, second_word in pairs:
        done = run(asperity, tmp_path, loading=LIGHT,
                   effects={**NO_EFFECTS, first: first_word, second: second_word, **NUMBERS})
        interaction = second_word if second == "interaction" else first_word
        sentence = why(first, second, interaction)
        if sentence:
            refused += 1
            assert done.status == 2, (first, second)
            assert sentence in done.stderr and "do not go together" in done.stderr, done.stderr
            assert first in done.stderr and second in done.stderr
            assert not done.positions and not done.stdout
        else:
            assert done.status == 0, (first, second, done.stderr)
            assert done.positions[0][first] == first_word
            assert done.positions[0][second] == second_word
    # Adhesion with any other, creep with flow and friction, flow with cells.
    assert len(pairs) == 14 and refused == 8, refused


def cells_of_the_page():
    """The table of docs/theory/effects.md: {(row, column): cell}, for asperities above the
    diagonal, for pixels below it."""
    lines = (ROOT / "docs/theory/effects.md").read_text().split("## Combinations\n\n")[1]
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines.splitlines()
            if line.startswith("|")]
    header, rows = rows[0][1:], rows[2:2 + len(ON)]
    assert set(header) == set(ON) and header == [row[0] for row in rows]
    return {(header[i], header[j]): re.sub(r"\[(\w+)\].*", r"\1", cell)
            for i, (_, *cells) in enumerate(rows) for j, cell in enumerate(cells)}


def test_the_page_has_each_pair_of_effects():
    """On asperities: yes, no, or only with contacts coupled."""
    cells = cells_of_the_page()
    names = [row for row, column in cells if row == column]
    for first, second in itertools.combinations(names, 2):
        sentences = [why(first, second, word) for word in ON["interaction"]]
        expected = {(False, False): "yes", (True, True): "no", (False, True): "`coupled`"}
        assert cells[first, second] == expected[tuple(map(bool, sentences))], (first, second)


def test_pairs_on_pixels_are_those_of_the_page(asperity, tmp_path):
    """Two effects that are on, on the pixels of a map: computed, or refused with the reason."""
    ball = [[-0.02 * ((i - 8) ** 2 + (j - 8) ** 2) for i in range(17)] for j in range(17)]
    (tmp_path / "ball.txt").write_text("\n".join(" ".join(map(str, row)) for row in ball))
    numbers = {"plastic_hardness": 0.5, "friction_coefficient": 0.2, "work_of_adhesion": 0.02,
               "equilibrium_distance": 1.0, "hold_time": 1.0, "relaxation_time": 2.0,
               "relaxed_modulus_ratio": 0.5, "hold_points": 3}
    cells = cells_of_the_page()
    names = [row for row, column in cells if row == column]
    for second, first in itertools.combinations(names, 2):
        others = {name: "off" for name in names if name not in (first, second, "interaction")}
        words = {first: "on", second: "on", **others, "interaction": "boundary"}
        pull = {"tangential_load": 0.01} if "friction" in (first, second) else {}
        scene = write_scene(
            tmp_path / "pair.scene",
            surfaces={"upper": "plane", "lower": "ball.txt", "map_spacing": (0.5, 0.5),
                      "map_level": "none"},
            material={"elastic_modulus": (2.0, 2.0), "poisson_ratio": (0.3, 0.3)},
            loading={"control": "load", "value": 0.3, **pull}, effects={**words, **numbers})
        done = solve(asperity, scene)
        if cells[first, second] == "yes":
            assert done.status == 0, (first, second, done.stderr)
            row = done.positions[0]
            assert row[first] == "on" and row[second] in ("on", "boundary"), (first, second)
        else:
            assert done.status == 2 and "do not go together" in done.stderr, (first, second,
                                                                              done.stderr)


def test_auto_meets_a_refused_pair(asperity, tmp_path):
    """With `auto` the larger of two such effects is simulated; the other one is reported with its
    size, only where both are called for."""
    both = {**NO_EFFECTS, "plasticity": "auto", "creep": "auto", **NUMBERS}
    for load, met in ((1000.0, False), (6000.0, True)):
        done = run(asperity, tmp_path, effects=both, loading={"control": "load", "value": load})
        assert done.status == 0, done.stderr
        row = done.positions[0]
        assert row["creep"] == "on" and row["plasticity"] == "off"
        left_out = float(row["plasticity_estimate"])
        assert float(row["error_estimate"]) >= 0.75 * left_out
        shown = re.search(r"position 1: two effects have no common theory and one is left out "
                         r".plasticity beside creep., (\S+) % is", done.stderr)
        assert bool(shown) == met == (left_out > 0.01), done.stderr
        if met:
            assert float(shown.group(1)) == pytest.approx(100 * left_out, rel=0.01)


BAD = [
    ("interaction", "'on'", "the text 'on', expected 'off', 'auto', 'coupled' or 'boundary'"),
    ("friction", "'coupled'", "the text 'coupled', expected 'off', 'on' or 'auto'"),
    ("boundary_tolerance", "1.", "more than 0 and less than 1"),
    ("boundary_tolerance", "'x'", "more than 0 and less than 1"),
    ("plasticity", "'maybe'", "expected"), ("adhesion", "1", "expected"),
    ("creep", "'coupled'", "expected"), ("plastic_yield_stress", "0", "a number more than 0"),
    ("plastic_yield_stress", "-1", "a number more than 0"),
    ("work_of_adhesion", "-1e-3", "a number of 0 or more"),
    ("work_of_adhesion", "'much'", "a number of 0 or more"),
    ("equilibrium_distance", "0.", "a number more than 0"),
    ("relaxation_time", "-1", "a number of 0 or more"),
    ("relaxed_modulus_ratio", "0", "a number more than 0 and at most 1"),
    ("relaxed_modulus_ratio", "1.01", "a number more than 0 and at most 1"),
    ("hold_time", "-600", "a number of 0 or more"),
    ("hold_time", "Inf", "expected a number"), ("hold", "'pressure'", "expected"),
    ("hold_points", "1", "expected"), ("hold_points", "2.5", "expected"),
    ("hold_points", "100001", "expected"), ("friction_coefficient", "-0.1", "of 0 or more"),
    ("tolerance", "0", "more than 0 and less than 1"),
    ("tolerance", "1", "more than 0 and less than 1"),
    ("work_of_adhesion", "1, 2", "wrong number of values"),
    ("yield", "1", "unknown name"),
]


def test_bad_input(asperity, tmp_path):
    """A bad value of each name: exit status 2, the place, what was found and expected."""
    for name, value, words in BAD:
        scene = tmp_path / "bad.scene"
        scene.write_text(f"&surfaces deck = '{DECK}' /\n&effects {name} = {value} /\n")
        done = solve(asperity, scene)
        assert done.status == 2, (name, value, done.stderr)
        line = done.stderr.splitlines()[-1]
        assert line.startswith(f"{scene}:2:") and words in line, line
        assert name in line and not done.positions


MISSING = [
    ({"friction": "on"}, "friction_coefficient"), ({"adhesion": "on"}, "work_of_adhesion"),
    ({"adhesion": "on", "work_of_adhesion": 1e-3}, "equilibrium_distance"),
    ({"creep": "on"}, "hold_time"),
    ({"creep": "on", "hold_time": 1.0, "relaxed_modulus_ratio": 0.5}, "relaxation_time"),
    ({"creep": "on", "hold_time": 1.0, "relaxation_time": 0.5}, "relaxed_modulus_ratio"),
]


def test_missing_numbers(asperity, tmp_path):
    """What an effect needs must be there; with CSV surfaces and no limit a yield stress, too."""
    for effects, name in MISSING:
        done = run(asperity, tmp_path, effects=effects)
        assert done.status == 2 and f"{name} is missing in &effects" in done.stderr, done.stderr
        assert len(done.stderr.splitlines()) == 1
    done = solve(asperity, balls(tmp_path, "no-limit", {"plasticity": "on"},
                                 {"control": "load", "value": 1.0}))
    assert done.status == 2
    assert "plasticity needs plastic_yield_stress in &effects, or a &limit" in done.stderr


def test_bad_paths(asperity, tmp_path):
    """Loads of a path: not negative, one more than zero."""
    for value, words in ((0.0, "a number more than 0"), ((1.0, -1.0), "a number of 0 or more"),
                         ((0.0, 0.0), "no load is more than 0")):
        done = run(asperity, tmp_path, loading={"control": "load", "value": value})
        assert done.status == 2 and words in done.stderr, done.stderr


def test_auto_changes_no_result_of_the_thesis(asperity, tmp_path):
    """Elastic, no hold, no work of adhesion: byte for byte the sweep without effects."""
    sweep = {"surfaces": {"deck": str(DECK)},
             "motion": {"x_first": 0.1, "x_step": 0.1, "positions": 100}}
    quiet = {"plasticity": "auto", "adhesion": "auto", "creep": "auto", "friction": "auto"}
    plain, auto = (solved(asperity, write_scene(tmp_path / f"{name}.scene", **sweep,
                                                effects=effects))
                   for name, effects in (("plain", {"plasticity": "off"}), ("auto", quiet)))
    for kind in ("positions", "contacts", "curve"):
        rows = list(zip(getattr(auto, kind), getattr(plain, kind), strict=True))
        same = [all(a[name] == b[name] for name in b if name not in SHOWN) for a, b in rows]
        assert same and all(same), kind
    every = solved(asperity, write_scene(tmp_path / "every.scene", **sweep,
                                         effects={**quiet, "interaction": "auto"}))
    for done in (auto, every):
        for name in quiet:
            assert {row[name] for row in done.positions} == {"off"}
        rows = effect_rows(done.stdout)
        assert {(rows[name]["tolerance"], rows[name]["simulated at"]) for name in quiet} == {
            ("1.00 %", "0 of 100")}
    # Where `auto` leaves interaction out, too, nothing differs.
    left = [all(a[name] == b[name] for name in b if name not in SHOWN) for a, b in
            zip(every.positions, plain.positions) if a["interaction"] == "off"]
    assert len(left) > 40 and all(left)


@pytest.mark.parametrize("limit, effects, hardness", (
    ({"criterion": "greenwood_williamson", "hardness": 21560.0}, {}, 21560.0),
    ({"criterion": "load"}, {"plastic_yield_stress": 6465.0}, 2.84 * 6465.0),
    ({"criterion": "load"}, {}, None),
    ({"criterion": "pressure", "value": 9000.0}, {}, 0.75 * math.pi * 9000.0),
    ({"criterion": "hardy", "yield_stress": 5000.0}, {},
     math.pi / 2 * 2.76 * 5000.0 * math.sqrt(1.9))))
def test_plasticity_index(limit, effects, hardness, asperity, tmp_path):
    """(E/H) sqrt(sigma/R) of the deck's summits, as the summary prints it."""
    done = run(asperity, tmp_path, limit=limit, effects={"plasticity": "auto", **effects})
    assert done.status == 0, done.stderr
    printed = re.search(r"index ([^ ,]+)", effect_rows(done.stdout)["plasticity"]["note"])[1]
    lines = DECK.read_text().splitlines()
    upper, heights = int(lines[1][:5]), [float(line[12:19]) for line in lines[4:]]
    # Of the sum of both surfaces' heights; inches.
    sigma = math.hypot(np.std(heights[:upper]), np.std(heights[upper:]))
    modulus = 400000 * 0.6894 / (2 * (1 - 0.42**2))
    if hardness is None:  # by the limit load: E sqrt(w/R)
        hardness = modulus * (0.75 * 65 * 9.8 / 2.205 / (modulus * 0.635**2)) ** (1 / 3)
    index = modulus / hardness * math.sqrt(sigma / 0.25)
    compare("plasticity index", abs(float(printed) / index - 1), 5e-3)


# What each example is about: what `auto` simulates there, at the last state.
ABOUT = {"beyond_limit": {"plasticity": "on"}, "ten_minutes": {"creep": "on"},
         "ten_minutes_approach": {"creep": "on"}, "index_092": {"plasticity": "on"},
         "gelatine": {"adhesion": "on"}, "beyond_limit_hertz": {}, "cycle": {"plasticity": "on"},
         "cycle_elastic": {}, "steel": {"plasticity": "on"}}


@pytest.mark.parametrize("name", sorted(path.stem for path in EXAMPLES.glob("*.scene")))
def test_an_example_simulates_its_effect(name, asperity, tmp_path):
    """Only what an example is about is simulated; its output beside it is still what comes out."""
    done = solved(asperity, EXAMPLES / f"{name}.scene", folder=tmp_path, contacts=False)
    row = done.positions[0]
    simulated = {effect: row[effect] for effect in ON if row.get(effect, "off") != "off"}
    assert simulated == ABOUT[name]
    kept = records(EXAMPLES / f"{name}.curve.csv")
    assert len(kept) == len(done.curve) and kept[0].keys() == done.curve[0].keys()
    for column_name in ("separation", "load", "area", "time"):
        found, true = column(done.curve, column_name), column(kept, column_name)
        scale = np.abs(true).max() or 1.0
        compare(f"examples: {column_name} of the curves", np.abs(found - true) / scale, 1e-9)
    if name.startswith(("beyond_limit", "ten", "index")) and "hertz" not in name:
        # All five effects were asked for.
        assert all(row[effect + "_estimate"] for effect in ON)
