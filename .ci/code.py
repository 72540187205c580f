"""Rules of CONTRIBUTING.md for Fortran code that a compiler does not check.

    python .ci/code.py [FILE...]      (default: every file of src and app)

1. No variable has the name of an intrinsic procedure.
2. The name of a procedure has at least two words, or stands in SHORT.
3. The description of an argument has at least three words.
4. No procedure is longer than 80 lines nor has more than 8 arguments, unless the comment right
   before or after its first line says why, beginning with `Long:`.
5. No comment block begins with "Of", "Or", "Nor" or "What".
6. Each named numeric constant of the solvers has a source in its comment: derived, measured,
   chosen, or a published one.
7. No variable has a name of ADVERBS: a name is the noun of its quantity.

The wing of the original program (`src/original`) keeps the original's names and length.
"""

import re
import sys
from pathlib import Path

LINES, ARGUMENTS, WORDS = 80, 8, 3
ROOT = Path(__file__).resolve().parent.parent
# Procedures of one word: those of the generic arithmetic of hex32, and names that are usual nouns.
SHORT = set("add checksum cosine divide integrate multiply respond sine solve subtract".split())
ORIGINAL = "src/original/"
SOLVERS = ("src/circles/", "src/grid/", "src/joint/", "src/effects/")
SOURCES = r"derived|measured|chosen|source|equation|page|\b(?:18|19|20)\d\d\b"
INTRINSICS = frozenset(
    """abs achar acos acosh adjustl adjustr aimag aint all allocated anint any asin asinh associated
    atan atan2 atanh bit_size btest ceiling char cmplx conjg cos cosh count cpu_time cshift dble
    digits dim dot_product dprod eoshift epsilon erf erfc exp exponent floor fraction gamma hypot
    huge iachar iand ibclr ibits ibset ichar ieor index int ior ishft ishftc kind lbound len
    len_trim lge lgt lle llt log log10 log_gamma logical matmul max maxexponent maxloc maxval merge
    min minexponent minloc minval mod modulo mvbits nearest nint norm2 not null pack parity popcnt
    poppar precision present product radix random_number random_seed range real repeat reshape
    rrspacing scale scan selected_int_kind selected_real_kind set_exponent shape shifta shiftl
    shiftr sign sin sinh size spacing spread sqrt sum system_clock tan tanh this_image tiny trailz
    leadz transfer transpose trim ubound unpack verify""".split()
)
ADVERBS = frozenset(
    """aloft alone apart again aside asked gone here lift miss off since still there together
    told way ways worth""".split()
)
TYPES = r"(?:real|integer|logical|complex|character|type|class|double precision)"
DECLARED = re.compile(rf"^\s*{TYPES}\b[^!']*?::\s*(.*)$", re.IGNORECASE)
BEGINS = re.compile(
    r"^\s*(?:(?:pure|impure|elemental|recursive|module)\s+|"
    rf"{TYPES}\s*(?:\([^()]*(?:\([^()]*\))?[^()]*\))?\s+)*(subroutine|function)\s+(\w+)",
    re.IGNORECASE,
)
ENDS = re.compile(r"^\s*end\s+(?:subroutine|function)\b", re.IGNORECASE)


def without_brackets(text):
    """The text without anything in brackets."""
    before = None
    while before != text:
        before, text = text, re.sub(r"\([^()]*\)", "", text)
    return text


def code_of(line):
    """The line without its comment; quoted text is taken out as well."""
    line = re.sub(r"'[^']*'|\"[^\"]*\"", "''", line)
    return line.partition("!")[0].rstrip()


def statement_at(lines, first):
    """The statement that begins in a line, with its continuations, and the number of its lines."""
    text, last = code_of(lines[first]), first
    while text.rstrip().endswith("&") and last + 1 < len(lines):
        last += 1
        text = text.rstrip().rstrip("&") + code_of(lines[last]).strip().lstrip("&")
    return text, last - first + 1


def declared_names(statement):
    """Names that a declaration declares."""
    found = DECLARED.match(statement)
    if not found:
        return []
    names = without_brackets(found.group(1)).split(",")
    return [re.split(r"[=\s*]", name.strip())[0].lower() for name in names if name.strip()]


def name_findings(lines):
    for number, line in enumerate(lines):
        for name in declared_names(statement_at(lines, number)[0]):
            if name in INTRINSICS:
                yield number, f"'{name}' is an intrinsic procedure"
            if name in ADVERBS:
                yield number, f"'{name}' is no noun of a quantity"


def procedures(lines):
    """First line, kind, name, arguments and last line of each procedure, but of interfaces."""
    begun, interface = [], False
    for number, line in enumerate(lines):
        code = code_of(line)
        if re.match(r"^\s*(?:abstract\s+)?interface\b", code, re.IGNORECASE):
            interface = True
        if re.match(r"^\s*end\s+interface\b", code, re.IGNORECASE):
            interface = False
        found = BEGINS.match(code)
        if interface:
            continue
        if found and not re.match(r"^\s*end\b", code, re.IGNORECASE):
            statement, _ = statement_at(lines, number)
            after = statement[found.end(2) - len(found.group(2)):]
            listed = re.search(r"\w+\s*\(([^()]*)\)", after)
            arguments = len([name for name in listed.group(1).split(",") if name.strip()]) \
                if listed else 0
            begun.append((number, found.group(1).lower(), found.group(2).lower(), arguments))
        elif ENDS.match(code) and begun:
            yield (*begun.pop(), number)


def explained(lines, number):
    near = lines[max(0, number - 12): number + 6]
    return any(re.search(r"!.*\bLong:", line) for line in near)


def procedure_findings(lines, short):
    for first, _, name, arguments, last in procedures(lines):
        if "_" not in name and name not in short:
            yield first, f"'{name}' is one word: verb and object, or a noun of two words"
        if last - first + 1 > LINES and not explained(lines, first):
            yield first, f"'{name}' has {last - first + 1} lines, more than {LINES}"
        if arguments > ARGUMENTS and not explained(lines, first):
            yield first, f"'{name}' has {arguments} arguments, more than {ARGUMENTS}"


def argument_findings(lines):
    """Descriptions of arguments, at the end of their line or in the lines after."""
    for number, line in enumerate(lines):
        if not re.search(r"\bintent\s*\(", code_of(line)):
            continue
        found = re.search(r"!!\s*(.*)$", line)
        text = found.group(1) if found else ""
        for after in lines[number + 1:]:
            more = re.match(r"^\s*!!\s*(.*)$", after)
            if not more:
                break
            text += " " + more.group(1)
        if text.strip() and len(re.findall(r"[\w'-]+", text)) < WORDS:
            yield number, f"description of an argument under {WORDS} words: {text.strip()}"


def comment_findings(lines):
    before = False
    for number, line in enumerate(lines):
        found = re.match(r"^\s*![!>]?\s*(.*)$", line)
        if found and not before and re.match(r"(?:Of|Or|Nor|What)\b", found.group(1)):
            yield number, f"a comment begins with '{found.group(1).split()[0]}'"
        before = bool(found)


def constant_findings(lines):
    for number, line in enumerate(lines):
        statement, count = statement_at(lines, number)
        if not re.search(r"\bparameter\b.*::", statement, re.IGNORECASE):
            continue
        if not re.search(r"=\s*[-+(]*\d", statement) or re.match(r"^\s*character", statement):
            continue
        said, above = "", number - 1
        while above >= 0 and re.match(r"^\s*!", lines[above]):
            said += lines[above]
            above -= 1
        below = number + count
        said += " ".join(text.partition("!")[2] for text in lines[number:below])
        while below < len(lines) and re.match(r"^\s*!!", lines[below]):
            said += lines[below]
            below += 1
        if not re.search(SOURCES, said, re.IGNORECASE):
            name = re.search(r"::\s*(\w+)", statement)
            yield number, f"constant '{name.group(1)}' without a source"


def findings(path, name, short):
    lines = path.read_text(encoding="utf-8").splitlines()
    if name.startswith(ORIGINAL):
        return
    yield from name_findings(lines)
    yield from procedure_findings(lines, short)
    yield from argument_findings(lines)
    yield from comment_findings(lines)
    if name.startswith(SOLVERS):
        yield from constant_findings(lines)


def main(*names):
    paths = [Path(name).resolve() for name in names] or sorted(
        path for folder in ("src", "app") for path in (ROOT / folder).rglob("*")
        if path.suffix in (".f90", ".F90", ".inc"))
    bad = 0
    for path in paths:
        name = path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else path.name
        for number, text in findings(path, name, SHORT):
            print(f"{name}:{number + 1}: {text}")
            bad += 1
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
