"""The folders of src and the one direction of flow: a module uses what stands before it.

    python .ci/flow.py           fails on a use against the order, naming file and line
    python .ci/flow.py --table   the table of folders and the uses between them (CONTRIBUTING.md)

The facade src/asperity.f90, app, example and test see all of src.
"""

import re
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ORDER = ("foundation", "numerics", "arithmetic", "input", "original", "surfaces", "search",
         "contact", "summation", "interaction", "effects", "run", "study", "output")
# The historic wing shares these folders with the present-day wing, and no others.
SHARED = ("foundation", "arithmetic", "input")
# Uses against the order that are let pass for a while: (module, module).
EXCEPTIONS = ()
USE = re.compile(r"^\s*use\s*(?:,\s*\w+\s*::)?\s*asperity_(\w+)", re.IGNORECASE)


def modules():
    """Every module of src: its name without `asperity_`, and its file."""
    return {path.stem: path for path in sorted((ROOT / "src").rglob("*"))
            if path.suffix in (".f90", ".F90") and path.parent != ROOT / "src"}


def folder(path):
    return path.relative_to(ROOT / "src").parts[0]


def uses(files):
    """Every use of a module by another: (file, line, user, used)."""
    for user, path in files.items():
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            found = USE.match(line)
            if found and found.group(1).lower() in files:
                yield path, number, user, found.group(1).lower()


def against_the_order(files):
    """What is wrong, one line a finding."""
    for path in files.values():
        if folder(path) not in ORDER:
            yield f"{path.relative_to(ROOT)}: folder {folder(path)} is not in the order"
            return
    for path, number, user, used in uses(files):
        own, other = folder(path), folder(files[used])
        if (user, used) in EXCEPTIONS or own == other:
            continue
        where = f"{path.relative_to(ROOT)}:{number}"
        if ORDER.index(other) > ORDER.index(own):
            yield f"{where}: {own} uses {other} ({used}), which comes after it"
        if own == "original" and other not in SHARED:
            yield f"{where}: the historic wing uses {other} ({used}): only {', '.join(SHARED)}"


def table(files):
    """A Markdown table: each folder, its modules and lines, and the uses of each other folder."""
    counted = Counter((folder(path), folder(files[used])) for path, _, _, used in uses(files))
    sources = Counter(folder(path) for path in files.values())
    lines = Counter()
    for path in (ROOT / "src").rglob("*"):
        if path.suffix in (".f90", ".F90", ".inc") and path.parent != ROOT / "src":
            lines[folder(path)] += len(path.read_text(encoding="utf-8").splitlines())
    yield "| folder | modules | lines | uses (times) |"
    yield "| --- | ---: | ---: | --- |"
    for own in ORDER:
        if sources[own]:
            used = ", ".join(f"{other} {counted[own, other]}" for other in ORDER
                             if other != own and counted[own, other])
            yield f"| `{own}/` | {sources[own]} | {lines[own]} | {used or '-'} |"


def main(arguments):
    files = modules()
    if arguments == ["--table"]:
        print("\n".join(table(files)))
        return 0
    findings = list(against_the_order(files))
    print("\n".join(findings), end="\n" if findings else "")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
