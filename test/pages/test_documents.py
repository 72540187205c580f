"""What the pages state, as far as a machine can check it.

Links lead somewhere; files, modules and options that are named exist; commands and scenes in fenced
blocks are accepted, and print what is shown; the tables of names are those of the readers.
"""

import re
import shlex
import shutil
from itertools import takewhile

import pytest
from builds import ROOT
from programs import run_program

# States nothing about the build under test.
pytestmark = pytest.mark.pages

PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *ROOT.glob("docs/**/*.md")])
COMMANDS = ("", "solve", "accuracy", "generate", "summits")
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
FOLDERS = "app|data|docs|example|include|python|reference_output|src|test|tools|[.]ci"
PATH = re.compile(rf"(?<![\w./-])(?:{FOLDERS})/[\w.*/-]*[\w*/]")
SOURCE = re.compile(r"[\w*]+[.](?:f90|F90|inc|py)")
# Words of a page that stand for a name.
PLACEHOLDER = re.compile(r"(?<![A-Za-z])(?:NAME|ROOM|FOLDER|LAYER)(?![A-Za-z])")
# Options that shorten a command.
SHORT = {"accuracy": ["--seconds", "1"]}


def name_of(page):
    return str(page.relative_to(ROOT))


each_page = pytest.mark.parametrize("page", PAGES, ids=name_of)


def blocks(page):
    """The fenced blocks of a page: the line of each, and its text."""
    found, first = [], None
    lines = page.read_text(encoding="utf-8").splitlines()
    for number, line in enumerate(lines, 1):
        if not line.startswith("```"):
            continue
        if first is None:
            first = number
        else:
            found.append((first, "\n".join(lines[first:number - 1])))
            first = None
    assert first is None, f"{name_of(page)}:{first}: a block has no end"
    return found


def prose(page):
    """The page without its blocks."""
    return re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)


def code(page):
    """The words between single backquotes."""
    return re.findall(r"`([^`\n]+)`", prose(page))


# ---------------------------------------------------------------- links

def anchor(heading):
    """The anchor of a heading: small letters, blanks as hyphens, nothing else."""
    return re.sub(r"[^\w -]", "", heading.strip().lower()).replace(" ", "-")


def anchors(page):
    return {anchor(heading) for heading in re.findall(r"^#+ (.*)", prose(page), re.M)}


@each_page
def test_links_lead_somewhere(page):
    lost = []
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
        if re.match(r"https?:", target):
            continue
        path, _, place = target.partition("#")
        other = (page.parent / path).resolve() if path else page
        if not other.exists() or (place and place not in anchors(other)):
            lost.append(target)
    assert not lost


def test_figures_are_shown():
    """Each picture of docs/figures is in a page."""
    shown = {path for page in PAGES
             for path in re.findall(r"!\[[^]]*\]\([^)\s]*figures/([^)]+)\)", prose(page))}
    assert shown == {path.name for path in ROOT.glob("docs/figures/*.svg")}


# ---------------------------------------------------------------- files, modules, options

def is_there(path):
    pattern = PLACEHOLDER.sub("*", path).rstrip("/")
    return any(ROOT.glob(pattern)) if "*" in pattern else (ROOT / pattern).exists()


@each_page
def test_files_exist(page):
    texts = [*code(page), *(text for _, text in blocks(page))]
    named = {path for text in texts for path in PATH.findall(text)}
    lost = {path for path in named if not is_there(path)}
    names = {path.name for folder in ("app", "src", "test", "example", ".ci", "docs")
             for path in (ROOT / folder).rglob("*")}
    for text in code(page):
        if SOURCE.fullmatch(text):
            pattern = re.escape(PLACEHOLDER.sub("*", text)).replace(r"\*", r"\w+")
            if not any(re.fullmatch(pattern, name) for name in names):
                lost.add(text)
    assert not lost


@pytest.fixture(scope="module")
def options(asperity):
    """The options of every command, by its help."""
    known = {}
    for command in COMMANDS:
        words = [word for word in (command, "--help") if word]
        done = run_program(asperity, *words)
        known[command] = set(OPTION.findall(done.stdout))
        assert len(known[command]) > 1
    return known


@each_page
def test_options_exist(page, options):
    """An option is one of asperity, or of the script or the program that the same words name."""
    known = set().union(*options.values())
    for path in (*ROOT.glob("test/**/*.py"), *(p for p in ROOT.glob(".ci/*") if p.is_file())):
        known |= set(OPTION.findall(path.read_text(encoding="utf-8")))
    others = re.compile(r"(?:\S*/)?(?:fpm|git|cafrun|mpirun|srun|#SBATCH)\b")
    lost = set()
    for text in (*code(page), *(line for _, text in blocks(page) for line in text.splitlines())):
        # What fpm hands on is for asperity.
        own = text.partition(" -- ")[2] if others.match(text) else text
        lost |= set(OPTION.findall(own)) - known
    # One page names options that are gone.
    gone = "html picture vtk budget cost".split() if page.name == "from-0.3.md" else []
    assert lost == {f"--{name}" for name in gone}


# ---------------------------------------------------------------- commands and scenes

def command_lines(page):
    """Lines of the blocks that call asperity with real names: line, words, text shown below."""
    for first, text in blocks(page):
        lines = text.splitlines()
        for number, line in enumerate(lines, first + 1):
            call = re.match(r"(?:\$ )?(?:asperity|fpm run --) (?!\[)(.*)", line)
            if not call:
                continue
            words = shlex.split(call[1], comments=True)
            if any(re.fullmatch(r"[A-Z]+", word) for word in words):
                continue
            shown = lines[number - first:] if line.startswith("$ ") else []
            # Those before the next command.
            yield number, words, list(takewhile(lambda line: not line.startswith("$ "), shown))


def input_files(page, folder):
    """Write the scenes and specifications of a page, each under the name that stands before it.
    A block of a shipped scene needs the files beside that scene."""
    text = page.read_text(encoding="utf-8").splitlines()
    written = []
    for first, block in blocks(page):
        if block.startswith("x,y,height"):
            name = re.findall(r"`([\w.-]+[.]csv)`", "\n".join(text[:first]))[-1]
            (folder / name).write_text(block + "\n", encoding="utf-8")
            continue
        if not re.match(r"(?:!.*\n|\s)*&\w+", block) or any(
                block in shipped.read_text() for shipped in ROOT.glob("data/examples/*/*.scene")):
            continue
        before = re.findall(r"`([\w.-]+[.](?:scene|spec))`", "\n".join(text[:first]))
        near = re.findall(r"`([\w.-]+[.](?:scene|spec))`", "\n".join(text[max(0, first - 5):first]))
        name = before[-1] if near else f"block_{first}.scene"
        if name.endswith(".scene") and "&surfaces" not in block:
            block = f"&surfaces deck = 'data/thesis.deck' /\n{block}"
        (folder / name).write_text(block + "\n", encoding="utf-8")
        written.append((first, name))
    return written


@each_page
def test_commands_and_scenes_are_accepted(page, asperity, options, checkout):
    inputs = input_files(page, checkout)
    for name in re.findall(r"(?m)^\$ cp (\S+) [.]$", page.read_text(encoding="utf-8")):
        shutil.copy(ROOT / name, checkout)
    for number, words, shown in command_lines(page):
        where = f"{name_of(page)}:{number}"
        command = words[0] if words[0] in COMMANDS else ""
        strange = {word.partition("=")[0] for word in words if word.startswith("--")} \
            - options[command] - {"--help", "--version"}
        assert not strange, f"{where}: {strange}"
        done = run_program(asperity, *words, *SHORT.get(command, []), cwd=checkout)
        assert_shown(shown, done.stdout.splitlines(), where)
    for number, name in inputs:
        verb = "solve" if name.endswith(".scene") else "generate"
        run_program(asperity, verb, name, *(["--quiet"] if verb == "solve" else []), cwd=checkout)


def assert_shown(shown, printed, where):
    """Lines shown stand in what is printed, in this order; `...` leaves out."""
    at = 0
    for line in shown:
        if line.strip() in ("", "..."):
            continue
        found = [i for i in range(at, len(printed)) if same_line(line, printed[i])]
        assert found, f"{where}: not printed, or not there: {line}"
        at = found[0] + 1


def same_line(a, b):
    """The same words and numbers, but for rounding."""
    return len(a.split()) == len(b.split()) and all(map(same_word, a.split(), b.split()))


def same_word(a, b):
    try:
        x, y = float(a.rstrip(",")), float(b.rstrip(","))
    except ValueError:
        return a == b
    # Errors of the arithmetic depend on the compiler's flags.
    return abs(x - y) <= 1e-6 * abs(x) or max(abs(x), abs(y)) < 1e-9


def test_number_of_words():
    """README and the pages of docs have at most 38,000 words."""
    pages = [page for page in PAGES if page.name != "CONTRIBUTING.md"]
    assert sum(len(page.read_text(encoding="utf-8").split()) for page in pages) <= 38_000


# ---------------------------------------------------------------- names

def names_known(asperity, folder, command, group, suffix):
    """The names of a group, as the reader lists them when it finds another."""
    path = folder / f"a.{suffix}"
    path.write_text(f"&{group} no_such_name = 1 /\n", encoding="ascii")
    done = run_program(asperity, command, path, status=2)
    reported = re.search(rf"unknown name in &{group}: .*, expected (.*)", done.stderr)
    return set(re.split(r", | or ", reported[1]))


def test_names_of_a_specification(asperity, tmp_path):
    text = (ROOT / "docs/reference/generate.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (?:`&(\w+)`)? *\| ([^|]*) \|", text, re.M)
    named, group = {}, None
    for mark, cell in rows:
        group = mark or group
        named.setdefault(group, set()).update(re.findall(r"`(\w+)`", cell))
    for group in ("surfaces", "heights", "random", "deck", "map"):
        assert named[group] == names_known(asperity, tmp_path, "generate", group, "spec")
