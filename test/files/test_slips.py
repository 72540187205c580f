"""Common mistakes, each with the message of docs/how-to/common-mistakes.md, word for word."""

import pytest
from builds import ROOT
from programs import run_program

UPPER = "x,y,height,radius\n0,0,.1,1\n.1,0,.1,1\n"
LOWER = "x,y,height,radius\n0,0,.1,100\n"
SURFACES = "&surfaces upper = 'upper.csv', lower = 'lower.csv' /\n"
MATERIAL = "&material elastic_modulus = 1000., 1000., poisson_ratio = .3, .3 /\n"
LOADING = "&loading control = 'load', value = 1. /\n"
SCENE = SURFACES + MATERIAL + LOADING
SOLVE = ("solve", "my.scene")
PAGE = ROOT / "docs/how-to/common-mistakes.md"

# Slip: files in the place of the good ones, what is typed, exit status.
SLIPS = {
    "a surface where a scene is expected": ({}, ("solve", "upper.csv"), 2),
    "a scene where a deck is expected": ({}, ("my.scene",), 2),
    "a command that does not exist": ({}, ("sovle", "my.scene"), 2),
    "an option misspelt": ({}, ("solve", "--contact", "c.csv", "my.scene"), 2),
    "a name misspelt": ({"my.scene": SCENE.replace("elastic_modulus", "elastic_modul")}, SOLVE, 2),
    "no radius anywhere": ({"upper.csv": "x,y,height\n0,0,.1\n"}, SOLVE, 2),
    "names in the wrong groups":
        ({"my.scene": MATERIAL.replace("material", "surfaces") +
          SURFACES.replace("surfaces", "material") + LOADING}, SOLVE, 2),
    "decimal commas": ({"upper.csv": "x;y;height;radius\n0;0;0,1;1\n"}, SOLVE, 2),
    "the header forgotten": ({"upper.csv": "0,0,.1,1\n.1,0,.1,1\n"}, SOLVE, 2),
    "an empty file": ({"upper.csv": ""}, SOLVE, 2),
    "heights in another unit than places":
        ({"upper.csv": "x [mm],y [mm],height [um],radius\n0,0,.1,1\n"}, SOLVE, 2),
    "degrees for radians": ({"my.scene": SCENE + "&tilt rotation = 30., 0. /\n"}, SOLVE, 0),
    "a surface upside down": ({"upper.csv": UPPER.replace(".1,1", "-.1,1")}, SOLVE, 0),
    "a load, or moduli, in other units":
        ({"my.scene": SCENE.replace("value = 1.", "value = 1e3")}, SOLVE, 0),
}
ROWS = [[cell.strip() for cell in line.strip("|").split(" | ")]
        for line in PAGE.read_text(encoding="utf-8").split("\n## ")[0].splitlines()
        if line.startswith("| ")][1:]


def typed(asperity, words, folder):
    return run_program(asperity, *words, status=None, cwd=folder)


def test_every_slip_is_made():
    assert [row[0] for row in ROWS] == list(SLIPS)


# Digits of a solution on elements depend on compiler and flags, within its tolerance.
DIGITS = ("a load, or moduli, in other units",)


@pytest.mark.parametrize("slip,answer", [
    pytest.param(*row, id=row[0], marks=[pytest.mark.once] if row[0] in DIGITS else [])
    for row in ROWS])
def test_answer(asperity, tmp_path, slip, answer):
    files, words, status = SLIPS[slip]
    for name, text in {"upper.csv": UPPER, "lower.csv": LOWER, "my.scene": SCENE, **files}.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    run = typed(asperity, words, tmp_path)
    assert run.returncode == status
    promised = answer.split("`")[1::2]
    assert promised
    for text in promised:
        assert text in run.stderr
    # One slip, one line, but where a line names every misplaced name or every consequence.
    if slip not in ("names in the wrong groups", "a load, or moduli, in other units",
                    "degrees for radians", "a surface upside down"):
        assert len([line for line in run.stderr.splitlines() if not line.startswith("Try")]) == 1


# As other programs write tables: the same numbers, however they stand there.
WRITTEN = {
    "semicolons": UPPER.replace(",", ";"),
    "tabulators": UPPER.replace(",", "\t"),
    "capitals and blanks": UPPER.replace("x,y,height,radius", " X , Y,HEIGHT , Radius"),
    "byte order mark and CRLF": "\ufeff" + UPPER.replace("\n", "\r\n"),
    "comments": "# made by hand\n" + UPPER.replace("0,0,", "  # the first\n\n0,0,") + "# end\n",
    "units": UPPER.replace("x,y,height,radius", "x [mm],y (mm),\"height [mm]\",radius [mm]"),
    "other columns": "id,x,y,name,height,radius,z\n1,0,0,a,.1,1,-\n2,.1,0,\"b\",.1,1,\n",
    "another order": "radius,height,y,x\n1,.1,0,0\n1,.1,0,.1\n",
}


@pytest.mark.parametrize("written, meant", [
    ("E = 1e5", "elastic_modulus"), ("youngs = 1e5", "elastic_modulus"),
    ("nu = .3, .3", "poisson_ratio"), ("E_star = 1e5", "contact_modulus")])
def test_symbol_in_place_of_a_name(asperity, tmp_path, written, meant):
    """The names are listed, and the one that is meant."""
    (tmp_path / "upper.csv").write_text(UPPER, encoding="utf-8")
    (tmp_path / "my.scene").write_text(
        f"&surfaces upper = 'upper.csv', lower = 'plane' /\n&material {written} /\n{LOADING}",
        encoding="utf-8")
    run = typed(asperity, SOLVE, tmp_path)
    lines = run.stderr.splitlines()
    assert run.returncode == 2 and "unknown name in &material" in lines[0]
    assert "expected elastic_modulus, poisson_ratio, contact_modulus, " in lines[0]
    assert lines[0].endswith(f"; did you mean '{meant}'?")
    assert not any(f"needs {meant}" in line or "CSV" in line for line in lines)


@pytest.mark.parametrize("how", WRITTEN)
def test_written_as_others_do(asperity, tmp_path, how):
    (tmp_path / "lower.csv").write_text(LOWER, encoding="utf-8")
    (tmp_path / "my.scene").write_text(SCENE, encoding="utf-8")
    tables = []
    for text in (UPPER, WRITTEN[how]):
        (tmp_path / "upper.csv").write_text(text, encoding="utf-8", newline="")
        run = typed(asperity, (*SOLVE, "--contacts", "c.csv"), tmp_path)
        assert run.returncode == 0, run.stderr
        tables.append((tmp_path / "c.csv").read_text(encoding="utf-8"))
    assert tables[0] == tables[1]
    assert ("upper.csv: note: columns that are not read: id, name, z\n" in run.stderr) == \
        (how == "other columns")


def test_errors_that_follow_are_not_printed(asperity, tmp_path):
    """A group that is misspelt hides neither its names nor what they state."""
    (tmp_path / "upper.csv").write_text(UPPER, encoding="utf-8")
    (tmp_path / "lower.csv").write_text(LOWER, encoding="utf-8")
    (tmp_path / "my.scene").write_text(
        SCENE.replace("&material", "&materail").replace("1000.,", "-1.,", 1), encoding="utf-8")
    lines = typed(asperity, SOLVE, tmp_path).stderr.splitlines()
    assert len(lines) == 2
    assert "unknown group: found '&materail'" in lines[0]
    assert lines[0].endswith("did you mean 'material'?")
    assert "elastic_modulus: found '-1.'" in lines[1]
