"""A default that a scene writes out changes nothing: random scenes, every name with a default.

Names and defaults are those of the tables of docs/reference/scene.md, which are made from the
program's own, and of `asperity solve --help effects`: a new name needs no line here.
"""

import math
import random
import re

import pytest
from builds import ROOT
from effect_runs import DECK
from programs import run_program
from surfaces_csv import text_of, write_surface

pytestmark = pytest.mark.fuzz

SCENES = 300
FILES = ("positions", "contacts", "curve")
# Numbers that make an effect `auto` (docs/theory/effects.md), with ranges of random values.
NUMBERS = {
    "friction": {"friction_coefficient": (0.01, 0.5)},
    "plasticity": {"plastic_yield_stress": (0.5, 5.0)},
    "adhesion": {"work_of_adhesion": (1e-4, 3e-2), "equilibrium_distance": (1e-4, 1e-2)},
    "creep": {"hold_time": (0.01, 3.0), "relaxation_time": (0.5, 2.0),
              "relaxed_modulus_ratio": (0.1, 0.99), "hold_points": None}}


def defaults_of_page():
    """{group: {name: (default, default of a periodic map)}} of the tables of the page."""
    page = (ROOT / "docs/reference/scene.md").read_text(encoding="utf-8")
    found = {}
    for group, table in re.findall(r"<!-- (\w+): made by make tables -->(.+?)<!-- end", page, re.S):
        head, _, *rows = table.strip().splitlines()
        columns = [cell.strip() for cell in head.strip("|").split("|")]
        # A deck has defaults of its own; the scenes here have none.
        at = next((i for i, name in enumerate(columns)
                   if name in ("default", "default of a free map")), None)
        for row in rows if at else ():
            cells = [cell.strip() for cell in row.strip("|").split("|")]
            values = [cells[at], cells[at + 1] if group == "surfaces" else ""]
            for name in re.findall(r"`(\w+)`", cells[0]):
                found.setdefault(group, {})[name] = values
    return found


def written(default):
    """The text of a default in a scene; none where it is not one value for all scenes."""
    word = re.fullmatch(r"`('\w+')`", default)
    number = re.fullmatch(r"[-\d.]+(, [-\d.]+)*", default)
    return word[1] if word else number and default


@pytest.fixture(scope="module")
def defaults(asperity):
    """The defaults of all groups; the effects have those of the help."""
    found = defaults_of_page()
    listed = run_program(asperity, "solve", "--help", "effects").stdout
    of_help = re.findall(r"^ {2,4}(\w+) +.+; default (.+)$", listed, re.M)
    assert {name for name, default in of_help if "with its numbers" in default} == set(NUMBERS)
    found["effects"] = {name: [default if "with its numbers" in default
                               else re.sub(r"^('\w+')$", r"`\1`", default), ""]
                        for name, default in of_help}
    return found


def missing_defaults(scene, defaults):
    """The names with a default that a scene leaves out: [(group, name, text)]."""
    is_map = "map_spacing" in scene["surfaces"]
    periodic = scene["surfaces"].get("map_edge") == "periodic"
    missing = []
    for group, names in defaults.items():
        for name, values in names.items():
            # `&motion` and `&tilt` are refused beside a map, `map_` names without one.
            if name in scene.get(group, {}) or (group in ("motion", "tilt") and is_map) or \
                    (group == "surfaces" and not is_map):
                continue
            text = written(values[1] if periodic and values[1] else values[0])
            if "with its numbers" in values[0]:
                given = scene["effects"]
                called = all(number in given for number in NUMBERS[name] if number != "hold_points")
                if name == "plasticity" and "control" in scene["loading"]:
                    called = called or "limit" in scene
                called = called or (name == "plasticity" and "plastic_hardness" in given)
                text = "'auto'" if called else "'off'"
            if text and not (name == "control" and scene["loading"]):
                missing.append((group, name, text))
    return missing


def write(path, scene, added=()):
    """The scene, its added names behind those of their groups and new groups at the end."""
    groups = {group: [f"{name} = {text_of(value)}" for name, value in names.items()]
              for group, names in scene.items()}
    for group, name, text in added:
        groups.setdefault(group, []).append(f"{name} = {text}")
    path.write_text("".join(f"&{group} {', '.join(names)} /\n" for group, names in groups.items()))


def random_loading(rng, scene, is_map):
    """A control with one value or a path; a limit with some of them."""
    control = rng.choice(("separation", "compression", "load", "vertical_load", "pressure",
                          "limit"))
    if control == "limit" and not is_map:
        scene["limit"] = {"criterion": "load", "value": 0.01}
        return scene
    sign, size = {"separation": (-1, 0.01), "compression": (1, 0.01), "pressure": (1, 0.02)}.get(
        control, (1, 0.5))
    control = "load" if control == "limit" else control
    shift = 0.30 if control == "separation" and not is_map else 0.0
    value = [shift + sign * size * rng.uniform(0.1, 1.0)
             for _ in range(rng.choice((1, 1, 1, 2, 3)))]
    if rng.random() < 0.7:
        value.sort(key=lambda number: sign * number)
    scene["loading"] = {"control": control, "value": tuple(value)}
    if rng.random() < 0.2:
        scene["loading"]["points"] = 2
    if rng.random() < 0.2 and not is_map:
        scene["limit"] = {"criterion": "load", "value": 0.05}
    return scene


def random_scene(rng, folder, is_map):
    """Some caps over a plane or caps, or a small map, with the numbers of some effects."""
    if is_map:
        (folder / "map.txt").write_text("\n".join(
            " ".join(f"{rng.gauss(0, 0.02):.6f}" for _ in range(8)) for _ in range(8)) + "\n")
        surfaces = {"upper": "plane", "lower": "map.txt", "map_spacing": (0.5, 0.5)}
        if rng.random() < 0.5:
            surfaces["map_edge"] = "periodic"
    else:
        def caps(number):
            return [(rng.uniform(0, 3), rng.uniform(0, 3), rng.uniform(0.29, 0.30),
                     rng.uniform(0.5, 2.0)) for _ in range(number)]
        surfaces = {"upper": "plane", "lower": write_surface(folder / "lower.csv",
                                                             caps(rng.randint(1, 5))),
                    "nominal_area": 9.0}
    scene = {"surfaces": surfaces, "material": {"contact_modulus": 100.0} if rng.random() < 0.3 else
             {"elastic_modulus": (200.0, 200.0), "poisson_ratio": (0.3, 0.3)},
             "loading": {}, "effects": {}}
    for numbers in NUMBERS.values():
        if rng.random() < (0.1 if is_map else 0.3):
            scene["effects"].update({
                name: math.exp(rng.uniform(*map(math.log, limits))) if limits else 3
                for name, limits in numbers.items()})
    if is_map and rng.random() < 0.3:
        scene["effects"]["plastic_hardness"] = rng.uniform(5.0, 20.0)
    elif rng.random() < 0.3:
        scene["effects"]["interaction"] = rng.choice(("off", "coupled"))
    return random_loading(rng, scene, is_map)


def outcome(asperity, folder):
    """Status, messages and the bytes of all outputs."""
    for name in FILES:
        (folder / name).unlink(missing_ok=True)
    done = run_program(asperity, "solve", "s.scene", "--threads", "1",
                       *(word for name in FILES for word in (f"--{name}", name)),
                       status=None, cwd=folder)
    return (done.returncode, done.stdout, done.stderr,
            *((folder / name).read_bytes() if (folder / name).exists() else None for name in FILES))


def test_written_defaults_of_a_deck(asperity, tmp_path):
    """The slopes of the plates and the limit of the thesis, as the tables of the page have them."""
    page = (ROOT / "docs/reference/scene.md").read_text(encoding="utf-8")
    added = [(group, name, cells[1].strip(" `"))
             for group in ("tilt", "limit")
             for line in page.split(f"<!-- {group}: made")[1].split("<!-- end")[0].splitlines()
             for name, *cells in re.findall(r"^\| `(\w+)` \| (.+?) \| ([^|]+?) \|", line)
             if re.fullmatch(r"`'load'`|[-\d., ]+", cells[1])]
    assert {name for _, name, _ in added} == {"upper_slope", "lower_slope", "criterion", "value"}
    scene = {"surfaces": {"deck": str(DECK)}, "motion": {"x_first": 5.6}, "effects": {}}
    write(tmp_path / "s.scene", scene)
    plain = outcome(asperity, tmp_path)
    write(tmp_path / "s.scene", scene, added)
    assert plain[0] == 0 and outcome(asperity, tmp_path) == plain


def test_written_defaults(asperity, defaults, tmp_path):
    """All names at once, or one of them, in turn: the outputs have the same bytes."""
    rng = random.Random(20261126)
    names, solved = set(), 0
    for k in range(SCENES):
        scene = random_scene(rng, tmp_path, is_map=k % 10 >= 8)
        added = missing_defaults(scene, defaults)
        if k % 2:
            added = [added[(k // 2) % len(added)]]
        write(tmp_path / "s.scene", scene)
        plain = outcome(asperity, tmp_path)
        write(tmp_path / "s.scene", scene, added)
        assert outcome(asperity, tmp_path) == plain, (scene, added)
        solved += plain[0] == 0
        names.update((group, name) for group, name, _ in added)
    of_tables = {(group, name) for group, texts in defaults.items() for name, values in
                 texts.items() if written(values[0]) or "with its numbers" in values[0]}
    assert names == of_tables and solved > SCENES // 2
