"""The tables of docs/reference that are made from the tables of the source, between their markers.

    python test/support/reference_tables.py EXECUTABLE

The help of the program prints its tables of options and of the names of &effects; this script
writes them as tables of commands.md and scene.md. The other groups of a scene have no table in the
help. Their values are those that the reader of scenes expects in its messages; other cells are kept
as they are. test_written_defaults.py compares the defaults.
"""

import re
import subprocess
import sys
import tempfile
import textwrap
from pathlib import Path

from constants_table import table_of_constants

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = ("", "solve", "accuracy", "generate", "study", "summits")
END = "<!-- end of what was made -->"
# A word of a scene, with or without its name: in code marks in a page.
WORD = re.compile(r"(?:\w+ = )?'\w+'")


def begin(name):
    return f"<!-- {name}: made by make tables -->"


def help_of(asperity, command):
    """The paragraphs of the help of a command."""
    words = [word for word in (command, "--help") if word]
    text = subprocess.run([asperity, *words], capture_output=True, text=True, check=True).stdout
    return text.strip("\n").split("\n\n")


def options(paragraph):
    """The options of a paragraph of the help: the option with its value, and its meaning."""
    found = []
    for line in paragraph.splitlines():
        start = re.match(r"  (-\S+(?:,? \S+)*?)(?:  +(\S.*))?$", line)
        if start:
            found.append([start[1], start[2] or ""])
        else:
            found[-1][1] += f" {line.strip()}"
    return [(option, meaning.strip()) for option, meaning in found]


def table_of_options(asperity):
    """For each command its usage, its purpose and its options."""
    seen = set()
    for command in COMMANDS:
        usage, purpose, *others = help_of(asperity, command)
        line = usage.splitlines()[0].removeprefix("Usage: ").replace("[OPTIONS] ", "")
        yield from (f"## `{line}`", "", *textwrap.wrap(" ".join(purpose.split()), 100), "")
        yield from ("| option | meaning |", "| --- | --- |")
        (listed,) = [text for text in others if text.startswith("  --")]
        rows = options(listed)
        again = [f"`{row[0]}`" for row in rows if row in seen]
        for option, meaning in (row for row in rows if row not in seen):
            yield f"| `{option}` | {meaning} |".replace("|  |", "| |")
        seen |= set(rows)
        yield from ("", f"Also {', '.join(again)}, as above.", "") if again else ("",)


def table_of_effects(asperity):
    """The names of &effects with values, default, unit and meaning."""
    yield "| name | values | default | unit | meaning |"
    yield "| --- | --- | --- | --- | --- |"
    text = "\n\n".join(help_of(asperity, "solve"))
    lines = text.split("Names of group &effects")[1].split("\n\n")[1].splitlines()
    for first, second in zip(lines[::2], lines[1::2], strict=True):
        name, values, default = re.fullmatch(r" +(\w+) +(.+); (?:default )?(.+)", first).groups()
        meaning, unit = re.fullmatch(r" +(.+?)(?: \[(.+)\])?", second).groups()
        cells = [WORD.sub(lambda word: f"`{word[0]}`", cell)
                 for cell in (values, default, unit or "", meaning)]
        yield " | ".join((f"| `{name}`", *cells)).replace("|  |", "| |") + " |"


# Scenes of a deck and of a map, in which a name has a value that is refused.
SCENES = {
    "deck": {"surfaces": {"deck": "'thesis.deck'"}},
    "map": {"surfaces": {"upper": "'plane'", "lower": "'map.txt'", "map_spacing": "2*1."},
            "material": {"contact_modulus": "1000."}}}
GROUPS = ("surfaces", "material", "motion", "tilt", "loading", "limit")
EXPECTED = re.compile(r"found [^\n]*, expected ([^\n]*)")
# Values that no message of the reader lists, as they are files, texts or counts beside numbers.
KEPT = ("surfaces deck", "surfaces upper", "surfaces radius", "surfaces units", "surfaces map_unit",
        "surfaces map_edge", "surfaces form_radius",
        "surfaces map_spacing", "loading value")


def expected(asperity, folder, group, name):
    """The values of a name, in the words of the message on another one."""
    folder = Path(folder)
    (folder / "thesis.deck").write_bytes((ROOT / "data/thesis.deck").read_bytes())
    (folder / "map.txt").write_text("0 1 0\n1 2 1\n0 1 0\n", encoding="ascii")
    scene = SCENES["map" if name.startswith("map_") else "deck"]
    beside = {("limit", "value"): {"criterion": "'pressure'"}}.get((group, name), {})
    for values in ("'?'", "2*'?'"):
        groups = {**scene, group: {**scene.get(group, {}), **beside, name: values}}
        (folder / "a.scene").write_text("".join(
            f"&{key} {', '.join(f'{one} = {value}' for one, value in names.items())} /\n"
            for key, names in groups.items()), encoding="ascii")
        done = subprocess.run([asperity, "solve", "a.scene", "--quiet"], cwd=folder,
                              capture_output=True, text=True)
        found = [EXPECTED.search(line) for line in done.stderr.splitlines() if f" {name}: " in line]
        words = next((match[1] for match in found if match), "")
        if not re.fullmatch(r"\d+", words):
            words = words.replace("a finite number within the range of a double", "a number")
            return re.sub("^a number", "2 numbers", words) if "*" in values else words
    raise ValueError(f"&{group} {name}: no values found in the messages")


def table_of_group(group):
    """The function that makes the table of a group from that on the page."""
    def table(asperity):
        page = (ROOT / MADE[group][0]).read_text(encoding="utf-8")
        head, rule, *rows = inside(page, group)[1].strip("\n").splitlines()
        yield from (head, rule)
        with tempfile.TemporaryDirectory() as folder:
            for row in rows:
                cells = [cell.strip() for cell in row.strip("|").split("|")]
                name = re.findall(r"`(\w+)`", cells[0])[0]
                if f"{group} {name}" not in KEPT:
                    cells[1] = WORD.sub(lambda word: f"`{word[0]}`", expected(
                        asperity, folder, group, name))
                yield re.sub(r"\|  (?=\|)", "| ", f"| {' | '.join(cells)} |")
    return table


MADE = {"options": ("docs/reference/commands.md", table_of_options),
        "constants": ("docs/theory/interaction.md", table_of_constants),
        "effects": ("docs/reference/scene.md", table_of_effects),
        **{group: ("docs/reference/scene.md", table_of_group(group)) for group in GROUPS}}


def inside(text, name):
    """A page before a table, the table, and the page after it."""
    before, _, rest = text.partition(begin(name))
    return before, *rest.partition(END)[::2]


def made(asperity, name):
    return "\n".join(MADE[name][1](asperity)).strip("\n")


def main(executable):
    for name, (page, _) in MADE.items():
        path = ROOT / page
        before, _, after = inside(path.read_text(encoding="utf-8"), name)
        table = made(Path(executable).resolve(), name)
        path.write_text(f"{before}{begin(name)}\n\n{table}\n\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
