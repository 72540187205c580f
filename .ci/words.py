"""The words of what a user reads: README, pages, changelog, messages, help, the last commit.

usage: words.py [FILE...]    without files: README.md, CHANGELOG.md, the pages of docs, the string
                             literals of src, app and python, the subject of the last commit

A few words are refused in comments, names and code, too, in every text file of these folders and in
the tests, a few more in the comments and docstrings of tests.

Prints FILE:LINE: WORD: REASON, one line a finding; exit status 1 where there is one.
Own, as a list of codespell has neither patterns of several words nor strings of Fortran alone.
"""

import csv
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
# Rows with a file: findings that are right as they are. The others: refused words, as patterns, and
# their replacements; case is ignored.
with open(pathlib.Path(__file__).with_suffix(".csv"), encoding="utf-8", newline="") as table:
    ROWS = list(csv.DictReader(table))
EXCEPTIONS = tuple((row["file"], row["words"], row["reason"]) for row in ROWS if row["file"])
WORDS = tuple((row["words"], row["reason"]) for row in ROWS if not row["file"])
MOST_WORDS = 30        # of a sentence of a page
LONGEST_LINE = 200     # of a page; rows of tables, pictures and code are longer
MOST_CHARACTERS = 160  # of an entry of the changelog

# First words of a sentence, unless it is a question.
FIRST = re.compile(r"(?:^|(?<=[.:;!?] ))(Of|Nor|Or|What|So who)\b (?![^.!?]*\?)")


# Refused wherever they occur, also in comments, names and blocks of code.
ANYWHERE = re.compile(r"\b(whoever|foretell|foretold|nobody|who bears|told|tells|press less)\b",
                      re.IGNORECASE)
# Refused in comments and docstrings of tests, with the replacements of words.csv.
IN_TESTS = re.compile(r"\b(tell|telling|says?|said|knows?|knew|wants?|bears?|bore|borne|closings?|"
                      r"samples?|spots?|tips?|rungs?|who|whom|somebody)\b", re.IGNORECASE)
# Text files beside pages and sources, which are read for these words alone.
OTHER_TEXTS = (".h", ".html", ".ipynb", ".json", ".scene", ".toml", ".svg")

# Headings of sections that are questions or sentences.
HEADING = re.compile(r"##+ (.*\?$|(How|What|When|Where|Which|Who|Why|So|If|It|They)\b)")


def literals(text):
    """The string literals of Fortran source: line and text; parts joined by // are one, with a #
    for what is not literal between them."""
    parts, gap, line, at = [], "", 1, 0
    while at < len(text):
        letter = text[at]
        if letter in "'\"":
            content, end = "", at + 1
            while end < len(text) and text[end] != "\n":
                if text[end] == letter:
                    if text[end + 1:end + 2] != letter:
                        break
                    end += 1
                content += text[end]
                end += 1
            between = re.sub(r"[&\s]", "", gap)
            if parts and between.startswith("//") and between.endswith("//"):
                parts[-1][1] += ("" if between == "//" else " # ") + content
            else:
                parts.append([line, content])
            gap, at = "", end + 1
            continue
        if letter == "!":
            while at < len(text) and text[at] != "\n":
                at += 1
            continue
        line += letter == "\n"
        gap += letter
        at += 1
    return parts


def python_literals(text):
    """The string literals of Python source, docstrings too: line and text."""
    import ast

    return [(node.lineno, node.value) for node in ast.walk(ast.parse(text))
            if isinstance(node, ast.Constant) and isinstance(node.value, str)]


def paragraphs(text):
    """The paragraphs of a Markdown page without code, addresses and markup: line and text."""
    found, lines, first, fenced = [], [], 0, False

    def end():
        nonlocal lines
        if lines:
            found.append((first, " ".join(lines)))
        lines = []

    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("```"):
            fenced = not fenced
            end()
            continue
        if fenced or not line.strip() or (not lines and line.startswith("    ")):
            end()
            continue
        if re.match(r"\s*([-*#|]|\d+[.])", line):
            end()
        if not lines:
            first = number
        line = re.sub(r"`[^`]*`", "NAME", line)
        line = re.sub(r"(!?)\[([^\]]*)\]\([^)]*\)", r"\2", line)
        lines.append(re.sub(r"^\s*([-*]|#+|\d+[.])\s+|[*]|^-+$", " ", line).strip())
    end()
    return found


def words_in(text):
    """Findings of the rules in a text: the words and the reason of each."""
    found = [(match.group(0).strip(), instead) for pattern, instead in WORDS
             for match in re.finditer(pattern, text, re.IGNORECASE)]
    return found + [(match.group(1), "a sentence begins with its subject")
                    for match in FIRST.finditer(text)]


def of_lines(text):
    """Findings in the lines of a page: those that are too long, and headings that ask."""
    found, fenced = [], False
    for number, line in enumerate(text.splitlines(), 1):
        fenced ^= line.startswith("```")
        if fenced:
            continue
        if len(line) > LONGEST_LINE and not re.match(r"[|>!\[ ]|</?\w", line):
            found.append((number, line[:30], f"line longer than {LONGEST_LINE} characters"))
        if HEADING.match(line):
            found.append((number, line.strip("# "), "a heading is a noun phrase"))
    return found


def of_page(text, is_changelog):
    """Findings in a Markdown page, but for the settings before it: line, words, reason."""
    settings = re.match(r"---\n.*?^---$", text, re.M | re.S)
    if settings:
        text = "\n" * settings[0].count("\n") + text[settings.end():]
    found = of_lines(text)
    for line, paragraph in paragraphs(text):
        found += [(line, *finding) for finding in words_in(paragraph)]
        if is_changelog:
            if len(paragraph) > MOST_CHARACTERS:
                found.append((line, paragraph[:30], f"entry longer than {MOST_CHARACTERS}"))
            continue
        for sentence in re.split(r"(?<=[.!?])\s+|\s*[|]\s*", paragraph):
            if len(sentence.split()) > MOST_WORDS:
                found.append((line, sentence[:30], f"sentence longer than {MOST_WORDS} words"))
    return found


def of_literals(parts):
    """Findings in string literals: line, words, reason; names and formats are no sentences."""
    return [(line, *finding) for line, text in parts if " " in text.strip()
            for finding in words_in(text)]


def anywhere(text):
    """Findings of the words that are refused in comments and code, too: line, word, reason."""
    return [(number, match[0], "report, print, estimate, return; things are no persons")
            for number, line in enumerate(text.splitlines(), 1)
            for match in ANYWHERE.finditer(line)]


def of_tests(path, text):
    """Findings in the comments and docstrings of a test: line, words, reason."""
    if path.suffix != ".py":
        parts = [(number, line[line.index("!"):]) for number, line in enumerate(
            re.sub(r"'[^'\n]*'|\"[^\"\n]*\"", "''", text).splitlines(), 1) if "!" in line]
    else:
        import ast
        import io
        import tokenize

        parts = [(token.start[0], token.string) for token in tokenize.generate_tokens(
            io.StringIO(text).readline) if token.type == tokenize.COMMENT]
        parts += [(node.body[0].lineno, ast.get_docstring(node)) for node in ast.walk(
            ast.parse(text)) if isinstance(node, (ast.Module, ast.FunctionDef, ast.ClassDef))
            and ast.get_docstring(node)]
    return [(line, match[0], "a word of another field: words.csv has its replacement")
            for line, part in parts for match in IN_TESTS.finditer(re.sub(r"`[^`]*`", "", part))]


def findings(path):
    text = path.read_text(encoding="utf-8")
    found = anywhere(text)
    if path.resolve().is_relative_to(ROOT / "test"):
        return found + of_tests(path, text)
    if path.suffix == ".md":
        return found + of_page(text, path.name == "CHANGELOG.md")
    if path.suffix == ".py":
        return found + of_literals(python_literals(text))
    if path.suffix in OTHER_TEXTS or path.parent.name == "original":
        return found
    return found + of_literals(literals(text))


def of_last_commit():
    """Findings in the subject of the last commit, where there is a repository."""
    log = subprocess.run(["git", "-C", ROOT, "log", "-1", "--no-merges", "--format=%s"],
                         capture_output=True, text=True, check=False)
    subject = log.stdout.strip()
    if log.returncode or not subject:
        return []
    found = [(1, *finding) for finding in words_in(re.sub(r"\S+[._/]\S+", "NAME", subject))]
    if not re.match(r"[a-z0-9_. -]+: \w", subject):
        found.append((1, subject[:30], "expected 'area: imperative sentence'"))
    return found


def all_files():
    tracked = subprocess.run(["git", "-C", ROOT, "ls-files", "src", "app", "python", "docs",
                              "include", "test"], text=True, capture_output=True, check=True
                             ).stdout.split()
    sources = [ROOT / name for name in tracked
               if name.endswith((".f90", ".F90", ".inc", ".py", *OTHER_TEXTS))]
    pages = sorted(ROOT.glob("docs/**/*.md"))
    return [*(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")), *pages,
            *sources]


def main(names):
    unused = set(EXCEPTIONS)
    paths = [pathlib.Path(name) for name in names] or all_files()
    rows = [(path, finding) for path in paths for finding in findings(path)]
    if not names:
        rows += [("commit", finding) for finding in of_last_commit()]
    status = 0
    for path, (line, words, reason) in rows:
        name = str(path).removeprefix(f"{ROOT}/")
        row = next((row for row in EXCEPTIONS if re.fullmatch(row[0], name) and
                    re.fullmatch(row[1], words, re.IGNORECASE)), None)
        if row:
            unused.discard(row)
            continue
        print(f"{name}:{line}: {words}: {reason}")
        status = 1
    for row in sorted(unused) if not names else ():
        print(f"words.py: exception {row[0]} | {row[1]} allows nothing: take the line away")
        status = 1
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
