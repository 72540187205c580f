"""What the program answers to a first scene that is not quite one: kind of file, quotes, units,
missing groups and files, names of outputs."""

import os

import pytest

from programs import run_program

BALL = "x,y,height,radius\n0,0,.1,1\n"
SURFACES = "&surfaces upper = 'ball.csv', lower = 'plane' /\n"
MATERIAL = "&material elastic_modulus = 210e3, 70e3, poisson_ratio = 2*0.3 /\n"
LOADING = "&loading control = 'load', value = 20. /\n"
SCENE = SURFACES + MATERIAL + LOADING
COMMENT = "; a comment begins with '!'"
OTHER_FORM = "; a scene is a Fortran namelist"


@pytest.fixture
def run(asperity, tmp_path):
    (tmp_path / "ball.csv").write_text(BALL, encoding="utf-8")

    def start(text, *words, name="my.scene", command=("solve",), status=2):
        (tmp_path / name).write_text(text, encoding="utf-8")
        done = run_program(asperity, *command, name, *words, status=status, cwd=tmp_path)
        return done.stderr

    return start


@pytest.mark.parametrize("name", ["my.scene", "first.txt"])
@pytest.mark.parametrize("text, found, hint", [
    ("# my first scene\n" + SCENE, "1:1: text outside a group: found '#'", COMMENT),
    ("#my first scene\n" + SCENE, "1:1: text outside a group: found '#my'", COMMENT),
    ("% a comment, with & in it\n" + SCENE, "1:1: text outside a group: found '%'", COMMENT),
    ("\n  // a comment\n" + SCENE, "2:3: text outside a group: found '/'", COMMENT),
    (SURFACES + "# a comment\n" + MATERIAL + LOADING, "2:1: text outside a group", COMMENT),
    (SCENE[1:], "1:1: text outside a group: found 'surfaces', expected '&'", ""),
    (SCENE.replace("&", ""), "1:1: text outside a group: found 'surfaces', expected '&'", ""),
    ("\n" + SCENE[1:], "2:1: text outside a group: found 'surfaces', expected '&'", ""),
    (SCENE.replace("&", "$").replace(" /", " $end"), "1:1: text outside a group: found '$surfaces'",
     ""),
    ("surfaces:\n  upper: ball.csv\n  lower: plane\n", "1:1: text outside a group", OTHER_FORM),
    ("---\nsurfaces:\n  upper: ball.csv\n", "1:1: text outside a group", OTHER_FORM),
    ('{"surfaces": {"upper": "ball.csv"},\n "loading": {"value": 2}}\n',
     "1:1: text outside a group", OTHER_FORM),
    ("[surfaces]\nupper = 'ball.csv'\n[loading]\nvalue = 2\n", "1:1: text outside a group",
     OTHER_FORM)])
def test_a_scene_is_named_as_one(run, name, text, found, hint):
    said = run(text, name=name)
    assert said.startswith(f"{name}:{found}") and hint in said.splitlines()[0]
    assert "card" not in said and len(said.splitlines()) <= 2
    # The original program, which takes decks alone, reports in one line what to do with it.
    said = run(text, name=name, command=())
    assert "a scene: asperity solve FILE" in said and len(said.splitlines()) == 1


def test_a_comment_of_fortran_is_none_of_these(run):
    run("! my first scene\n\n  ! & more\n" + SCENE, name="first.txt", status=0)


def test_a_deck_is_a_deck(asperity, root, tmp_path):
    """Whatever its two words are, and with a field that is wrong."""
    cards = (root / "data/examples/shifted.deck").read_text(encoding="ascii").splitlines()
    (tmp_path / "a.deck").write_text("\n".join(["# : =[{", *cards[1:]]) + "\n", encoding="ascii")
    run_program(asperity, "solve", "a.deck", cwd=tmp_path)
    cards[1] = "   xx" + cards[1][5:]
    (tmp_path / "a.deck").write_text("\n".join(cards) + "\n", encoding="ascii")
    done = run_program(asperity, "solve", "a.deck", status=2, cwd=tmp_path)
    assert "NU (number of asperities): found '   xx'" in done.stderr


@pytest.mark.parametrize("old, new, said", [
    ("control = 'load'", "control = load",
     "control: found 'load', expected it in quotes: control = 'load'"),
    ("'plane'", "plane", "lower: found 'plane', expected a text between quotes: lower = 'plane'"),
    ("'ball.csv'", "ball.csv", "upper: found 'ball.csv', expected a text between quotes: "
     "upper = 'ball.csv'"),
    ("lower =", "units = mm, N, lower =", "units: found 'mm', expected a text of 1 to 16 bytes "
     "between quotes: units = 'mm'"),
    ("&loading", "&effects friction = on / &loading",
     "friction: found 'on', expected it in quotes: friction = 'on'"),
    ("210e3, 70e3", "210 GPa, 70 GPa", "elastic_modulus: found 'GPa', expected numbers without"),
    ("210e3, 70e3", "210GPa, 70GPa", "elastic_modulus: found '210GPa', expected numbers without"),
    ("value = 20.", "value = 20 N", "value: found 'N', expected numbers without a unit"),
    ("value = 20.", "value = 2e1N", "value: found '2e1N', expected numbers without a unit"),
    ("value = 20.", "value = 20 µN", "value: found 'µN', expected numbers without a unit"),
    ("value = 20.", "value = 1e400", "value: found '1e400', expected a number more than 0"),
    ("value = 20.", "value = 0., 20 kN", "value: found 'kN', expected numbers without a unit"),
    ("2*0.3", "30 %, 30 %", "poisson_ratio: found '%', expected numbers without a unit"),
    (LOADING, "", "no control and value in &loading; without them control is 'limit', which needs "
     "value in &limit: found none"),
    (", value = 20.", "", "control = 'load' needs value in &loading: found none, expected one"),
    ("&loading", "&effects plasticity = 'on' / &loading",
     "plasticity needs plastic_yield_stress in &effects, or a &limit: found neither"),
    ("'plane'", "'none.csv'", "none.csv:1:1: cannot be opened: No such file or directory")])
def test_one_sentence_states_the_remedy(run, old, new, said):
    assert old in SCENE
    text = run(SCENE.replace(old, new))
    assert said in text and "wrong number" not in text
    assert said.startswith("units") or len(text.splitlines()) == 1


MAP = "1 2 3 4\n2 3 4 5\n1 2 3 1\n4 4 2 1\n"


@pytest.mark.parametrize("upper, lower", [("none.txt", "m.txt"), ("m.txt", "none.txt")])
def test_a_missing_file_beside_a_map(run, tmp_path, upper, lower):
    (tmp_path / "m.txt").write_text(MAP, encoding="ascii")
    said = run(f"&surfaces upper = '{upper}', lower = '{lower}', map_spacing = 1., 1. /\n"
               "&material contact_modulus = 1e5 /\n" + LOADING)
    assert said == "none.txt:1:1: cannot be opened: No such file or directory, expected a map\n"


@pytest.mark.parametrize("unit", ["um", "\u00b5m", "\u03bcm", "micron"])
def test_one_unit_by_many_names(run, asperity, tmp_path, unit):
    """A micrometre, wherever a unit is read: an option, a scene, the header of a surface."""
    (tmp_path / "m.txt").write_text(MAP, encoding="ascii")
    done = run_program(asperity, "summits", "m.txt", "--spacing", "1,1", "--unit", unit,
                       cwd=tmp_path)
    assert done.stderr == "" and " um" in done.stdout
    run(f"&surfaces upper = 'm.txt', lower = 'plane', map_spacing = 1., 1., units = 'um', 'N', "
        f"map_unit = '{unit}' /\n&material contact_modulus = 1e5 /\n" + LOADING, status=0)
    (tmp_path / "u.csv").write_text(f"x [um],y ({unit}),height [um],radius [{unit}]\n0,0,.1,1\n",
                                    encoding="utf-8")
    run(SCENE.replace("'ball.csv'", f"'u.csv', units = '{unit}', 'N'"), status=0)


@pytest.mark.parametrize("header, place, said", [
    ("x,y,height [um],radius", 5, "height: found unit 'um' beside no unit"),
    ("x,y,height [um],radius [um]", 5, "height: found unit 'um' beside no unit"),
    ("x [mm],y,height [um],radius [nm]", 8, "y: found no unit beside unit 'mm'"),
    ("x [mm],y,height,radius", 8, "y: found no unit beside unit 'mm'"),
    ("x [mm],y [mm],height [mm],radius", 27, "radius: found no unit beside unit 'mm'"),
    ("height (um),x [mm],y [um],radius [um]", 13, "x: found unit 'mm' beside unit 'um'")])
def test_one_unit_for_all_lengths(run, tmp_path, header, place, said):
    (tmp_path / "u.csv").write_text(header + "\n0,0,.1,1\n", encoding="utf-8")
    text = run(SCENE.replace("ball.csv", "u.csv"))
    assert text == (f"u.csv:1:{place}: {said}, expected one unit for all lengths, in each column "
                    "or in none\n")


@pytest.mark.long
@pytest.mark.once
def test_a_header_of_many_columns(run, tmp_path):
    """A short note. To join a million names to those before would take minutes."""
    columns = 1_000_000
    (tmp_path / "w.csv").write_text(f"x,y,height,radius{',c' * columns}\n"
                                    f"0,0,.1,1{',0' * columns}\n", encoding="ascii")
    said = run(SCENE.replace("ball.csv", "w.csv"), "--quiet", status=0)
    assert said.splitlines()[0] == ("w.csv: note: columns that are not read: c, c, c, c, c and "
                                    f"{columns - 5} more")


@pytest.mark.parametrize("option, name, ending", [
    ("--json", "a.html", "json"), ("--json", "a.csv", "json"), ("--contacts", "a.json", "csv"),
    ("--positions", "A.XLSX", "csv"), ("--curve", "a.png", "csv")])
def test_an_output_named_as_another_kind(run, tmp_path, option, name, ending):
    said = run(SCENE, option, name)
    assert said.splitlines()[0] == (f"{option}: found '{name}', expected a name that ends with "
                                    f".{ending}, as that is what is written")
    assert not (tmp_path / name).exists()


def test_outputs_of_any_other_name(run):
    run(SCENE, "--json", "a.txt", "--contacts", "c", "--positions", "p.dat", "--curve", "c.CSV",
        status=0)


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o666, 0o755])
def test_a_replaced_file_keeps_its_permissions(run, tmp_path, mode):
    file = tmp_path / "p.csv"
    file.write_text("kept\n", encoding="ascii")
    file.chmod(mode)
    if os.geteuid() == 0:
        os.chown(file, 12345, 23456)
    before = file.stat()
    run(SCENE, "--positions", "p.csv", status=0)
    after = file.stat()
    assert file.read_text(encoding="ascii").startswith("position,")
    assert (after.st_mode, after.st_uid, after.st_gid) == (before.st_mode, before.st_uid,
                                                           before.st_gid)


@pytest.mark.parametrize("control", ["load", "pressure"])
def test_a_map_that_is_not_there(run, control):
    """One sentence: the names that a map has are not blamed for its absence."""
    said = run("&surfaces upper = 'plane', lower = 'none.txt', map_spacing = 2*0.5, map_unit = "
               "'mm', map_edge = 'free', units = 'mm', 'N' /\n" + MATERIAL
               + LOADING.replace("load'", f"{control}'"))
    assert said.startswith("none.txt:1:1: cannot be opened") and len(said.splitlines()) == 1
