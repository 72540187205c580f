"""The names of &effects: help, messages and documents say the same of them.

The program has them in one table (src/input/effect_names.f90), which its help prints. The tables of
the documents are that help in another form: when one of these tests fails, it shows the lines that
the page must have.
"""

import re
import subprocess
from typing import NamedTuple

import pytest

from effect_runs import DECK, ROOT
from surfaces_csv import solve

HEAD = "| name | values | default | unit | meaning |"
RULE = "| --- | --- | --- | --- | --- |"
# A word of the scene, with or without its name: in code marks in a page.
WORD = re.compile(r"(?:\w+ = )?'\w+'")


class Name(NamedTuple):
    """What the help says of one name."""

    name: str
    effect: str  # whose number it is; an effect's own name is its own; none: of all effects
    values: str
    default: str
    unit: str
    meaning: str

    def row(self):
        """Its row in a page."""
        marked = [WORD.sub(lambda word: f"`{word[0]}`", text) for text in self[2:]]
        return " | ".join((f"| `{self.name}`", *marked)).replace("|  |", "| |") + " |"


@pytest.fixture(scope="module")
def names(asperity):
    """All names, as `asperity solve --help` lists them."""
    done = subprocess.run([asperity, "solve", "--help"], capture_output=True, text=True, check=True)
    lines = done.stdout.split("Names of group &effects")[1].split("\n\n")[1].splitlines()
    found, effect = [], ""
    for first, second in zip(lines[::2], lines[1::2], strict=True):
        parts = re.fullmatch(r"( {2}| {4})(\w+) +(.+); (?:default )?(.+)", first)
        meaning = re.fullmatch(r" {26}(.+?)(?: \[(.+)\])?", second)
        assert parts and meaning, (first, second)
        if len(parts[1]) == 2 and "'off'" in parts[3]:
            effect = parts[2]
        found.append(Name(parts[2], effect, parts[3], parts[4], meaning[2] or "", meaning[1]))
    return found


def effects_of(names):
    """The effects among the names."""
    return [name for name in names if name.name == name.effect]


def table_of(names):
    """The lines of their table in a page."""
    return [HEAD, RULE, *(name.row() for name in names)]


def tables_in(path):
    """Every such table of a page."""
    lines = path.read_text().splitlines()
    for start in (i for i, line in enumerate(lines) if line == HEAD):
        end = next((i for i, line in enumerate(lines) if i > start and not line.startswith("|")),
                   len(lines))
        yield lines[start:end]


def test_scene_page(names, tally):
    """docs/reference/scene.md has all names, in the order of the help."""
    expected = table_of(names)
    assert list(tables_in(ROOT / "docs/reference/scene.md")) == [expected], "\n".join(expected)
    tally.add("names of &effects: docs/reference/scene.md", len(names), len(names))


def test_pages_of_effects(names, tally):
    """Every effect has its page with its own names, and a line in docs/theory/effects.md."""
    overview = (ROOT / "docs/theory/effects.md").read_text()
    for effect in effects_of(names):
        page = (ROOT / "docs/theory" / f"{effect.name}.md").read_text(encoding="utf-8")
        for name in names:
            assert name.effect != effect.name or f"`{name.name}`" in page, name.name
        row = f"| `{effect.name}` | {effect.meaning} | [{effect.name}]({effect.name}.md) |"
        assert row in overview, row
    number = len(list(effects_of(names)))
    tally.add("names of &effects: pages of effects", number, number)


def refused(asperity, folder, words):
    """The message on a line in &effects."""
    scene = folder / "refused.scene"
    scene.write_text(f"&surfaces deck = '{DECK}' /\n&effects {words} /\n")
    done = solve(asperity, scene)
    assert done.status == 2
    return done.stderr.strip()


def test_the_reader_knows_them(asperity, names, tmp_path):
    """The names that the reader lists are those of the help."""
    message = refused(asperity, tmp_path, "nothing = 1")
    listed = message.split("expected ")[1].replace(" or ", ", ").split(", ")
    assert sorted(listed) == sorted(name.name for name in names)
    assert len(listed) == len(set(listed))


def test_messages_say_what_is_expected(asperity, names, tmp_path, tally):
    """A value that is refused is told as the help tells it; a default is none."""
    for name in names:
        message = refused(asperity, tmp_path, f"{name.name} = '?'")
        assert f"{name.name}: found the text '?', expected {name.values}" in message
        if name.effect and name.default.startswith("needed with "):
            assert name.effect in name.default
    tally.add("names of &effects: messages", len(names), len(names))
