"""JSON holds the cells of the CSV files, to the last bit; `-` stands for the standard streams."""

import json
import re

import jsonschema
import pytest
from builds import ROOT
from programs import run_program
from surfaces_csv import records, write_csv_scene

SCHEMA = json.loads((ROOT / "docs/results.schema.json").read_text(encoding="utf-8"))
SCENES = ("data/examples/thesis.scene", "data/hard/effects/inside_circle_auto.scene",
          "data/examples/effects/ten_minutes.scene")


def run(asperity, *words, cwd=ROOT, status=0, **more):
    return run_program(asperity, *words, status=status, cwd=cwd, **more)


def fnv(data):
    """FNV-1a of 32 bits, from its definition."""
    state = 2166136261
    for byte in data:
        state = (state ^ byte) * 16777619 % 2**32
    return f"{state:08X}"


@pytest.mark.parametrize("name", SCENES)
def test_json_has_the_values_of_the_tables(name, asperity, tmp_path):
    tables = {"positions": "--positions", "states": "--curve", "contacts": "--contacts"}
    done = run(asperity, "solve", name, "--quiet", "--json", tmp_path / "r.json",
               *(word for table, option in tables.items() for word in (option, tmp_path / table)))
    text = (tmp_path / "r.json").read_text(encoding="utf-8")
    found = json.loads(text)
    jsonschema.validate(found, SCHEMA)
    numbers = re.findall(r'^(?:"\w+": \[)?([-+\d.E,]+)(?:\],?)?$', text, re.M)
    assert numbers and max(line.count(",") for line in numbers) <= 8
    assert found["scene"]["text"] == (ROOT / name).read_text(encoding="utf-8")
    assert done.stderr.splitlines() == found["notes"] + found["warnings"]
    for entry in found["provenance"]["inputs"]:
        assert entry["checksum"] == fnv((ROOT / entry["file"]).read_bytes())
    for table in tables:
        rows = records(tmp_path / table)
        assert list(found[table]) == list(rows[0])
        met = 0
        for column, cells in found[table].items():
            assert len(cells) == len(rows)
            for cell, row in zip(cells, rows):
                text = row[column]
                met += cell is None if text == "" else \
                    cell == (text if isinstance(cell, str) else float(text))
        assert met == len(rows) * len(rows[0])


def test_json_of_any_text(asperity, tmp_path):
    """What a scene states in its comments is in the file: quotes, tabs, letters of all kinds; a
    byte that is no letter becomes a question mark."""
    scene = write_csv_scene(tmp_path, [(0, 0, .2, 1)], [(0, 0, .1, 1)], name='a"b\\c',
                            loading={"control": "approach", "value": 0.29})
    text = scene.read_bytes() + '! "quotes" \\ \t µm 𝄞\r\n'.encode() + b"! \xe4\n"
    scene.write_bytes(text)
    found = json.loads(run(asperity, "solve", scene, "--json", "-").stdout)
    assert found["scene"] == {"file": str(scene), "text": text[:-2].decode() + "?\n"}


@pytest.mark.long
def test_standard_streams(asperity, tmp_path):
    """A scene from standard input is one of the current folder; an output is all that is
    reported."""
    folder = ROOT / "data/examples"
    text = (folder / "one_pair.scene").read_bytes().decode()
    for option in ("--positions", "--curve", "--contacts", "--json"):
        run(asperity, "solve", "one_pair.scene", option, tmp_path / "file", cwd=folder)
        printed = run(asperity, "solve", "-", option, "-", cwd=folder, input=text, stdin=None)
        expected = (tmp_path / "file").read_text()
        for member in ("file", "summary"):
            expected = expected.replace(f'"{member}": "one_pair.scene', f'"{member}": "-')
        assert printed.stdout == expected and printed.stderr == ""
    deck = (ROOT / "data/thesis.deck").read_text()
    assert run(asperity, "-", input=deck, stdin=None).stdout == \
        run(asperity, "data/thesis.deck").stdout
    assert run(asperity, "solve", "-", input=deck, stdin=None).stdout.splitlines()[1:] == \
        run(asperity, "solve", "data/thesis.deck").stdout.splitlines()[1:]
    run(asperity, "data/thesis.deck", "--positions", tmp_path / "p")
    assert run(asperity, "data/thesis.deck", "--positions", "-").stdout == (tmp_path / "p"
                                                                            ).read_text()
    kept = [run(asperity, "solve", "-", "--keep", tmp_path / "k", "--positions", "-", input=text,
                stdin=None, cwd=folder).stdout for _ in range(2)]
    assert kept[0] == kept[1]


def test_standard_streams_refused(asperity, tmp_path):
    scene = ROOT / "data/examples/one_pair.scene"
    assert "--curve and --json both go to standard output, expected one" in run(
        asperity, "solve", scene, "--curve", "-", "--json", "-", status=2).stderr
    assert "--keep: found -, expected a file" in run(
        asperity, "solve", scene, "--keep", "-", status=2).stderr
    bad = run(asperity, "solve", "-", input="&loadin /", stdin=None, status=2, cwd=tmp_path)
    assert bad.stderr.startswith("-:1:1: unknown group: found '&loadin'") and bad.stdout == ""
    # A file of that name is another one: a surface is never read from there.
    (tmp_path / "a.scene").write_text("&surfaces upper = '-', lower = 'plane' /\n"
                                      "&material contact_modulus = 1. /\n"
                                      "&loading control = 'approach', value = 0.09 /\n")
    assert "./-:1:1: cannot be opened" in run(asperity, "solve", "a.scene", status=2,
                                              cwd=tmp_path).stderr
