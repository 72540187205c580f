"""The tables of docs/reference that are made from the tables of the source, between their markers.

    python test/support/reference_tables.py EXECUTABLE

The help of the program prints its tables of options and of the names of a scene; this script
writes them as tables of commands.md and scene.md. In groups other than &effects the page has the
defaults and meanings; test_written_defaults.py compares the defaults. A name that the page lacks
gets a row from the help.
"""

import re
import subprocess
import sys
import textwrap
from pathlib import Path

from constants_table import table_of_constants

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = ("", "solve", "accuracy", "generate", "summits")
END = "<!-- end of what was made -->"
# A word of a scene, with or without its name: in code marks in a page.
WORD = re.compile(r"(?:\w+ = )?'\w+'")


def begin(name):
    return f"<!-- {name}: made by make tables -->"


def help_of(asperity, command, group=""):
    """The paragraphs of the help of a command, or of a group of the file that it reads."""
    words = [word for word in (command, "--help", group) if word]
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


def names_of(asperity, group):
    """The names of a group of a scene: values, default, unit, meaning, as the help has them."""
    lines = help_of(asperity, "solve", group)[1].splitlines()
    found = {}
    for first, second in zip(lines[::2], lines[1::2], strict=True):
        name, values, default = re.fullmatch(r" +(\w+) +(.+?); (?:default )?(.+)", first).groups()
        meaning, unit = re.fullmatch(r" +(.+?)(?: \[(.+)\])?", second).groups()
        found[name] = [WORD.sub(lambda word: f"`{word[0]}`", cell)
                       for cell in (values, default, unit or "", meaning)]
    return found


def row_of(cells):
    """A row of a table in a page."""
    return re.sub(r"\|  (?=\|)", "| ", f"| {' | '.join(cells)} |")


def table_of_effects(asperity):
    """The names of &effects with values, default, unit and meaning."""
    yield "| name | values | default | unit | meaning |"
    yield "| --- | --- | --- | --- | --- |"
    for name, cells in names_of(asperity, "effects").items():
        yield row_of((f"`{name}`", *cells))


GROUPS = ("surfaces", "material", "motion", "tilt", "loading", "limit")


def table_of_group(group):
    """The function that makes the table of a group from that on the page."""
    def table(asperity):
        page = (ROOT / MADE[group][0]).read_text(encoding="utf-8")
        head, rule, *rows = inside(page, group)[1].strip("\n").splitlines()
        columns = head.strip("| ").split(" | ")
        yield from (head, rule)
        known = names_of(asperity, group)
        for row in rows:
            cells = [cell.strip() for cell in row.strip("|").split("|")]
            names = re.findall(r"`(\w+)`", cells[0])
            cells[1] = known[names[0]][0]
            yield row_of(cells)
            for name in names:
                del known[name]
        for name, (values, default, unit, meaning) in known.items():
            others = {"meaning": meaning, "unit": unit, columns[2]: default}
            yield row_of((f"`{name}`", values, *(others.get(head, "") for head in columns[2:])))
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
