"""Names of the library that are public and have no description.

    python .ci/undocumented.py [FOLDER]      (default: src)

A description is a `!>` or `!!` comment right before the entity, or `!!` on its line or the next.
FORD's own warnings do not tell public names from local ones.
"""

import re
import sys
from pathlib import Path

DEFINES = (
    r"^(?:[\w\s=()*:,]*\s)?(?:subroutine|function)\s+{name}\s*(?:\(|$)",
    r"^type\b[^:]*::\s*{name}\s*$",
    r"^type\s+{name}\s*$",
    r"^(?:abstract\s+)?interface\s+{name}\s*$",
    r"^[^!']*\bparameter\b[^!']*::[^!']*\b{name}\b",
)


def lines_of(path):
    """The lines of a file with its included texts in their places."""
    for line in path.read_text(encoding="utf-8").splitlines():
        included = re.match(r"""#include\s+["<](.+)[">]""", line)
        if included:
            yield from lines_of(path.parent / included.group(1))
        else:
            yield line.strip()


def statements(lines):
    """Statements without comments, continued lines joined."""
    text = "\n".join(re.sub(r"!.*", "", line) for line in lines)
    return re.sub(r"&\s*\n\s*&?", " ", text).lower().splitlines()


def names_after(pattern, lines):
    """Names listed after a pattern, `operator(+)` among them."""
    for statement in statements(lines):
        found = re.match(pattern, statement.strip())
        if found:
            for name in re.split(r",(?![^(]*\))", found.group(1)):
                yield re.sub(r"\s", "", name).partition("=>")[0]


def documented(lines, name):
    """Whether any definition of the name carries a description."""
    escaped = re.sub(r"\\\(", r"\\s*\\(", re.escape(name))
    patterns = [re.compile(pattern.format(name=escaped), re.IGNORECASE) for pattern in DEFINES]
    for number, line in enumerate(lines):
        if line.lower().startswith(("public", "private", "end ", "use ", "import", "procedure")):
            continue
        if any(pattern.search(line) for pattern in patterns):
            before = lines[number - 1] if number else ""
            after = lines[number + 1] if number + 1 < len(lines) else ""
            if before.startswith(("!>", "!!")) or "!!" in line or after.startswith("!!"):
                return True
    return False


def described_enumerators(lines):
    """Names of every `enum` that has a description right before it."""
    for found in re.finditer(r"^!>.*\nenum\b(?s:.*?)^end enum", "\n".join(lines), re.MULTILINE):
        yield from re.findall(r"\w+", found.group().lower())


def undocumented(path):
    """Public names of one module without a description; a name that is only passed on has none."""
    lines = list(lines_of(path))
    used = set(names_after(r"use\b.*\bonly\s*:(?!:)(.*)", lines))
    used.update(described_enumerators(lines))
    public = names_after(r"public\s*::(.*)", lines)
    if not any(line.startswith(("!>", "!!")) for line in lines[:3]):
        yield "the module itself"
    for name in public:
        if name not in used and not documented(lines, name):
            yield name


def main(folder="src"):
    missing = [
        f"{path}: no description: {name}"
        for path in sorted(Path(folder).rglob("*.[fF]90"))
        for name in undocumented(path)
    ]
    print("\n".join(missing), end="\n" if missing else "")
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
