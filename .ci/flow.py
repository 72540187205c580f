"""The folders of src and the one direction of flow: a module uses what stands before it.

    python .ci/flow.py           fails on a use against the order, naming file and line, and when
                                 CONTRIBUTING.md does not have the table
    python .ci/flow.py --table   the table: each folder and those whose modules it uses
    python .ci/flow.py --write   puts it into CONTRIBUTING.md

The facade src/asperity.f90, app, example and test see all of src; src/c uses the facade.
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ORDER = ("foundation", "numerics", "arithmetic", "input", "original", "surfaces", "search",
         "results", "contact", "summation", "grid", "circles", "joint", "maps", "effects", "models",
         "run", "study", "output", "c")
# The historic wing shares these folders with the present-day wing, and no others.
SHARED = ("foundation", "arithmetic", "input")
BEGIN, END = "<!-- flow: python .ci/flow.py --table -->\n", "<!-- end of flow -->\n"
USE = re.compile(r"^\s*use\s*(?:,\s*\w+\s*::)?\s*asperity_(\w+)", re.IGNORECASE)
FACADE = re.compile(r"^\s*use\s+asperity\s*(,|$)", re.IGNORECASE | re.MULTILINE)


def modules():
    """Every module of src: its name without `asperity_`, and its file."""
    return {path.stem: path for path in sorted((ROOT / "src").rglob("*"))
            if path.suffix in (".f90", ".F90") and path.parent != ROOT / "src"}


def folder(path):
    return path.relative_to(ROOT / "src").parts[0]


def uses(files):
    """Every use of a module by another: (file, line, used)."""
    for path in files.values():
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            found = USE.match(line)
            if found and found.group(1).lower() in files:
                yield path, number, found.group(1).lower()


def against_the_order(files):
    """What is wrong, one line a finding."""
    for path in files.values():
        if folder(path) not in ORDER:
            yield f"{path.relative_to(ROOT)}: folder {folder(path)} is not in the order"
            return
        if folder(path) != "c" and FACADE.search(path.read_text(encoding="utf-8")):
            yield f"{path.relative_to(ROOT)}: uses the facade, which is for users of the library"
    for path, number, used in uses(files):
        own, other = folder(path), folder(files[used])
        if own == other:
            continue
        where = f"{path.relative_to(ROOT)}:{number}"
        if ORDER.index(other) > ORDER.index(own):
            yield f"{where}: {own} uses {other} ({used}), which comes after it"
        if own == "original" and other not in SHARED:
            yield f"{where}: the historic wing uses {other} ({used}): only {', '.join(SHARED)}"


def table(files):
    """A Markdown table: each folder, and those whose modules it uses."""
    used_by = {}
    for path, _, used in uses(files):
        used_by.setdefault(folder(path), set()).add(folder(files[used]))
    lines = ["| folder | uses |", "| --- | --- |"]
    for own in ORDER:
        if any(folder(path) == own for path in files.values()):
            others = [other for other in ORDER if other in used_by.get(own, ()) and other != own]
            lines.append(f"| `{own}/` | {', '.join(others) or '-'} |")
    return "\n".join(lines) + "\n"


def main(arguments):
    files = modules()
    page = ROOT / "CONTRIBUTING.md"
    before, rest = page.read_text(encoding="utf-8").split(BEGIN)
    old, after = rest.split(END)
    if arguments == ["--table"]:
        print(table(files), end="")
        return 0
    if arguments == ["--write"]:
        page.write_text(before + BEGIN + table(files) + END + after, encoding="utf-8")
        return 0
    findings = list(against_the_order(files))
    if old != table(files):
        findings.append("CONTRIBUTING.md: its table of uses is not that of the code: "
                        "python .ci/flow.py --write")
    print("\n".join(findings), end="\n" if findings else "")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
