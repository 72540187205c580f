"""The tables of docs/reference that are made from the tables of the source, between their markers.

    python test/support/reference_tables.py EXECUTABLE

The help of the program prints its tables of options and of the names of &effects; this script
writes them as tables of commands.md and scene.md. The other groups of a scene have no table in the
help. Their values are those that the reader of scenes expects in its messages; a default is the
value with which a scene has the results that it has without the name. Cells that are no such value
are kept as they are.
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


# Scenes in which a name and its default are compared, by the heading of the column: groups, each
# with its names.
SCENES = {
    "default with a deck": {"surfaces": {"deck": "'thesis.deck'"},
                            "motion": {"x_step": "0.1", "positions": "2"}},
    "default": {"surfaces": {"upper": "'upper.csv'", "lower": "'plane'"},
                "material": {"contact_modulus": "1000."},
                "loading": {"control": "'separation'", "value": "0.05"},
                "motion": {"x_step": "0.1", "positions": "2"}},
    "default of a free map": {"surfaces": {"upper": "'plane'", "lower": "'map.txt'",
                                           "map_spacing": "2*1."},
                              "material": {"contact_modulus": "1000."},
                              "loading": {"control": "'compression'", "value": "0.01"}}}
SCENES["if periodic"] = {
    **SCENES["default of a free map"],
    "surfaces": {**SCENES["default of a free map"]["surfaces"], "map_edge": "'periodic'"}}
UPPER = "x,y,height,radius\n0,0,0.1,1\n0.4,0.1,0.09,1\n"
GROUPS = ("surfaces", "material", "motion", "tilt", "loading", "limit")
# Groups whose names need a deck to have a default.
OF_DECK = ("loading", "limit")
LITERAL = re.compile(r"`'\w+'`|-?[\d.]+(?:, -?[\d.]+)*")
EXPECTED = re.compile(r"found [^\n]*, expected ([^\n]*)")
# Values that no message of the reader lists, as they are files, texts or counts beside numbers.
KEPT = ("surfaces deck", "surfaces upper", "surfaces radius", "surfaces units", "surfaces map_unit",
        "surfaces map_edge", "surfaces form_radius",
        "surfaces map_spacing", "loading value")


def write_map(folder):
    """A map of 16 x 16 heights: waves on a slope, with one spike."""
    rows = [[0.02 * ((3 * i * i + 5 * j) % 7) + 0.003 * i for i in range(16)] for j in range(16)]
    rows[7][9] += 2.0
    (folder / "map.txt").write_text(
        "".join(" ".join(f"{z:.6f}" for z in row) + "\n" for row in rows), encoding="ascii")


def scene_text(scene, group, names):
    """The text of a scene with other names in one group."""
    scene = {**scene, group: {**scene.get(group, {}), **names}}
    return "".join(
        f"&{name} {', '.join(f'{key} = {value}' for key, value in values.items() if value)} /\n"
        for name, values in scene.items())


class Reader:
    """The program as a reader of scenes, in a folder with the files of `SCENES`."""

    def __init__(self, asperity, folder):
        self.asperity, self.folder, self.known = asperity, Path(folder), {}
        (self.folder / "thesis.deck").write_bytes((ROOT / "data/thesis.deck").read_bytes())
        (self.folder / "upper.csv").write_text(UPPER, encoding="ascii")
        write_map(self.folder)

    def solve(self, text):
        """Problems of a scene, and its outputs: of both one is empty."""
        if text not in self.known:
            (self.folder / "a.scene").write_text(text, encoding="ascii")
            outputs = [self.folder / name for name in ("positions", "curve", "contacts")]
            for path in outputs:
                path.unlink(missing_ok=True)
            done = subprocess.run(
                [self.asperity, "solve", "a.scene", "--quiet", "--threads", "1",
                 *(word for path in outputs for word in (f"--{path.name}", path))],
                cwd=self.folder, capture_output=True, text=True)
            self.known[text] = (done.stderr, b"") if done.returncode else \
                ("", b"".join(path.read_bytes() for path in outputs))
        return self.known[text]

    def expected(self, group, name):
        """The values of a name, in the words of the message on another one."""
        column = "default of a free map" if name.startswith("map_") else "default with a deck"
        beside = {("limit", "value"): {"criterion": "'pressure'"}}.get((group, name), {})
        for values in ("'?'", "2*'?'"):
            problems, _ = self.solve(scene_text(SCENES[column], group, {**beside, name: values}))
            found = [EXPECTED.search(line) for line in problems.splitlines()
                     if f" {name}: " in line]
            words = next((match[1] for match in found if match), "")
            if not re.fullmatch(r"\d+", words):
                words = words.replace("a finite number within the range of a double", "a number")
                return re.sub("^a number", "2 numbers", words) if "*" in values else words
        raise ValueError(f"&{group} {name}: no values found in the messages")

    def default(self, group, name, column, shown):
        """The value with which a scene has the results that it has without the name: the one that
        the page shows, or another one."""
        if column == "default" and group in OF_DECK:
            column = "default with a deck"
        scene = SCENES[column]
        beside = {"points": {"value": "0.25", "control": "'separation'"}}.get(name, {})
        _, without = self.solve(scene_text(scene, group, {**beside, name: ""}))
        several = shown.count(",") + 1
        words = re.findall(r"'\w+'", self.expected(group, name)) or \
            [", ".join([number] * several) for number in ("0", "0.25", "1", "2", "3")]
        fitting = [word for word in (shown.strip("`"), *words)
                   if without and self.solve(scene_text(scene, group, {**beside, name: word}))[1]
                   == without]
        if not fitting or set(words) <= set(fitting):
            raise ValueError(f"&{group} {name}: {column} is not {shown}, and not found")
        return f"`{fitting[0]}`" if "'" in fitting[0] else fitting[0]


def table_of_group(group):
    """The function that makes the table of a group from that on the page."""
    def table(asperity):
        page = (ROOT / MADE[group][0]).read_text(encoding="utf-8")
        head, rule, *rows = inside(page, group)[1].strip("\n").splitlines()
        columns = head.strip("| ").split(" | ")
        yield from (head, rule)
        with tempfile.TemporaryDirectory() as folder:
            reader = Reader(asperity, folder)
            for row in rows:
                cells = [cell.strip() for cell in row.strip("|").split("|")]
                name = re.findall(r"`(\w+)`", cells[0])[0]
                if f"{group} {name}" not in KEPT:
                    cells[1] = WORD.sub(lambda word: f"`{word[0]}`", reader.expected(group, name))
                for i, column in enumerate(columns):
                    if column in SCENES and LITERAL.fullmatch(cells[i]):
                        cells[i] = reader.default(group, name, column, cells[i])
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
