"""Changes single lines of src and lists the changes that no test notices.

    mutate.py --seed 1 --number 25            draws, builds and tests 25 mutants
    mutate.py --seed 1 --list                 prints the mutants of a seed, runs nothing
    mutate.py --seed 1 --again                repeats the survivors with the present tests
    mutate.py --seed 1 --again 7 12           repeats mutants 7 and 12
    mutate.py --seed 1 --equivalent 7 REASON  marks a mutant that can change no result
    mutate.py --seed 1 --note 7 TEXT          adds a remark, e.g. the test that was added
    mutate.py --seed 1 --report FILE          writes the record as a page
    mutate.py --tests                         prints the tests that are run
    mutate.py --constants                     changes the constants of the solvers of interaction
    mutate.py --constants circle_error:taken  repeats those whose names contain this

A mutant is the program with one operator or one number changed: a comparison, a sign, a bound by
one, a constant times 1.3, .and. for .or., min for max. It is drawn by the seed, is built in a copy
of the tree under build/mutants, and runs against the unit tests and the quick harness (QUICK) at
once; the first failure ends both. The tree itself is never changed. Finished mutants are kept in
build/mutants/seed-N.json: a run that was cut short continues there. A change that does not compile,
or that gives the same object code, is drawn again.

--constants takes each constant of the table of docs/theory/interaction.md, once times 1.3 and once
over 1.3, and runs the test file that its comment names, at first without slow tests, or else a
suite of its folder. The outcomes are written to reference_output/interaction/constants.csv.

Only the changed file is compiled anew when its module file stays the same, as nothing else can
depend on the change then; otherwise fpm compiles what uses it, too.
"""

import argparse
import csv
import fcntl
import hashlib
import json
import os
import queue
import random
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# Checks of bounds end a mutant early; -O1 halves the time of the tests against -O0.
FLAGS = "-O1 -g0 -fcheck=bounds -fopenmp"
# A constant breaks no bound, and its suites take half the time.
CONSTANT_FLAGS = "-O1 -g0 -fopenmp"
# The quick harness: tests that need no other build, chosen so that every module of src runs.
QUICK = [
    "test/regression/test_slips.py", "test/regression/test_summary.py",
    "test/regression/test_warnings.py", "test/regression/test_map_warnings.py",
    "test/regression/test_effect_words.py", "test/regression/test_effect_names.py",
    "test/regression/test_contact_modulus.py",
    "test/regression/test_units.py", "test/regression/test_report.py",
    "test/regression/test_solve.py", "test/regression/test_creep.py",
    "test/regression/test_generate.py", "test/regression/test_study.py",
    "test/regression/test_shares.py", "test/regression/test_map_scene.py",
    "test/regression/test_adhesion.py", "test/regression/test_friction.py",
    "test/regression/test_plasticity.py", "test/regression/test_effect_contacts.py",
    "test/regression/test_page.py", "test/regression/test_solve_laws.py",
    "test/regression/test_bad_decks.py",
    "test/regression/test_summits.py", "test/regression/test_result_files.py",
    "test/regression/test_library.py", "test/regression/test_accuracy_any.py",
    "test/regression/test_accuracy.py::test_every_way_is_there[pair]",
    "test/regression/test_accuracy.py::test_the_csv_is_csv",
    "test/regression/test_accuracy.py::test_the_budget_of_cells",
    "test/regression/test_accuracy.py::test_the_budget_at_a_load",
    "test/hard/test_hard.py",
]
# Of these, tests that take more than a second or need another build.
QUICK_WITHOUT = [
    "test/regression/test_solve.py::test_random_decks",
    "test/regression/test_study.py::test_images",
    "test/regression/test_friction.py::test_coefficient_without_bound",
    "test/regression/test_friction.py::test_every_contact_of_the_sweep",
    "test/regression/test_effect_contacts.py::test_two_thousand_caps",
    "test/regression/test_effect_contacts.py::test_some_caps_against_the_truth",
    "test/regression/test_effect_contacts.py::test_deep_contact_opens_a_shallow_one",
    "test/regression/test_page.py::test_large_page",
    "test/regression/test_page.py::test_page_holds_all",
    "test/regression/test_bad_decks.py::test_any_deck_ends_with_an_answer",
    "test/regression/test_accuracy_any.py::test_the_promise",
    "test/regression/test_accuracy_any.py::test_any_scene",
    "test/regression/test_summits.py::test_every_variant_is_read_to_the_last_bit",
    "test/regression/test_summits.py::test_memory_that_is_not_there_is_told",
    "test/regression/test_solve_laws.py::test_common_shift_of_tilted_surfaces",
    "test/regression/test_library.py::test_read_a_scene_of_a_map[press]",
    "test/hard/test_hard.py::test_historic_port_against_the_restated_march",
    "test/hard/test_hard.py::test_scene",
    "test/hard/test_hard.py::test_deck_in_the_present_day_solver",
]
# Seconds: a test of the harness, and all tests of a mutant. A test takes at most a few; the rest is
# left for a busy machine.
TEST_LIMIT = 240
MUTANT_LIMIT = 1800
# Seconds: the test file of a constant.
FILE_LIMIT = 300
# Run for constants whose comments name no test.
ROOM_TESTS = {"grid": "elements_suite.f90", "circles": "coupled_suite.f90",
              "joint": "joint_suite.f90"}
# Statuses of pytest that say nothing about the program: internal error, usage, no test found.
PYTEST_FAULTS = (3, 4, 5)
# An allocation without end ends the mutant, not the machine: a process gets 8 GiB.
PYTEST = [sys.executable, "-m", "pytest", "--rootdir", ".", "-q", "-x", "-rfE", "--tb=line",
          "-p", "no:cacheprovider", "-p", "mutate"]
LIMITED = ["sh", "-c", 'ulimit -v 8388608; exec "$@"', "sh"]
# Folders that are drawn once at most: src/original is frozen, and archives compare its output.
SELDOM = {"src", "src/original", "src/arithmetic"}
# Files that hold no statement that could change a result.
LEFT_OUT = {"src/foundation/kinds.f90", "src/foundation/version.f90"}
MOST_DRAWS = 60
COMMANDS = "compile_commands.json"

STATEMENTS_LEFT_OUT = re.compile(
    r"(use|module|submodule|program|end|enddo|endif|implicit|private|public|interface|abstract"
    r"|import|include|generic|final|format|contains|stop|sequence)\b(?!\s*[=%(])"
    r"|(\d+\s+)?format\s*\(|(de)?allocate\s*\(|error\s+stop\b|#", re.IGNORECASE)
PROCEDURE = re.compile(r"[\w\s(),=*:]*\b(function|subroutine)\s+\w+\s*\(", re.IGNORECASE)
DECLARATION = re.compile(r"(integer|real|logical|complex|character|type\s*\(|class\s*\(|procedure"
                         r"|enumerator|type\s*[,:])", re.IGNORECASE)
REAL = re.compile(r"(?<![\w.])(\d+\.\d*|\.\d+|\d+(?=[edq]))([edq][+-]?\d+)?(_\w+)?(?![\w.])",
                  re.IGNORECASE)
INTEGER = re.compile(r"(?<![\w.])(\d+)(_\w+)?(?![\w.])")
COMPARISON = re.compile(r"(?<![<>=/])(<=|>=|==|/=|<|>)(?!=)")
# Their result depends on the type of the argument alone.
INQUIRY = re.compile(r"\b(epsilon|huge|tiny|kind|digits|precision|storage_size|c_sizeof|radix"
                     r"|minexponent|maxexponent|selected_\w+_kind)\s*\([^()]*\)", re.IGNORECASE)
COMPARISONS = {"<": ["<=", ">"], "<=": ["<", ">="], ">": [">=", "<"], ">=": [">", "<="],
               "==": ["/="], "/=": ["=="]}
EXTREMES = {"min": "max", "max": "min", "minval": "maxval", "maxval": "minval",
            "minloc": "maxloc", "maxloc": "minloc"}


# Statements of a text and the changes they offer

def statements(lines):
    """Each statement as a list of (line, column, character), a NUL for characters of a string."""
    found, places, quote, continued = [], [], None, False
    for number, line in enumerate(lines):
        body = line.lstrip()
        if body.startswith("#") or not body or (quote is None and body.startswith("!")):
            continue
        column = len(line) - len(body)
        if continued and body.startswith("&"):
            column += 1
        places = places if continued else []
        ends = len(line)
        if quote is None and places:
            places.append((number, column, " "))
        continued = False
        while column < ends:
            char = line[column]
            if quote:
                if char == quote:
                    quote = None
                elif char == "&" and not line[column + 1:].strip():
                    continued = True
                    break
                places.append((number, column, "\0"))
            elif char in "'\"":
                quote = char
                places.append((number, column, "\0"))
            elif char == "!":
                break
            elif char == "&" and re.match(r"&\s*(!.*)?$", line[column:]):
                continued = True
                break
            else:
                places.append((number, column, char))
            column += 1
        if not continued:
            quote = None
            found.append(places)
    return found


def parts_at_commas(text):
    """Spans between the commas of a text that stand in no parenthesis."""
    depth, start, spans = 0, 0, []
    for place, char in enumerate(text):
        depth += (char in "([") - (char in ")]")
        if char == "," and depth == 0:
            spans.append((start, place))
            start = place + 1
    return [*spans, (start, len(text))]


def first_value(text):
    """Where the initial values of a declaration begin; None where it has none that matter."""
    kind = re.match(r"(integer|real|logical)\b", text, re.IGNORECASE)
    if not kind or "::" not in text:
        return None
    depth = 0
    for place in range(text.index("::") + 2, len(text)):
        depth += (text[place] in "([") - (text[place] in ")]")
        if text[place] == "=" and depth == 0 and text[place + 1:place + 2] != ">":
            return place + 1
    return None


def times_factor(literal):
    """A real literal times 1.3, its kind kept; None for zero."""
    digits, exponent, kind = literal.group(1), literal.group(2) or "", literal.group(3) or ""
    value = 1.3 * float(digits + re.sub("[dq]", "e", exponent.lower()))
    if value == 0:
        return None
    text = f"{value:.15g}"
    if "." not in text:
        text = text.replace("e", ".0e") if "e" in text else text + ".0"
    return (text.replace("e", exponent[0]) if exponent else text) + kind


def changes_of(text):
    """Changes of one statement: (kind, begin, end, new text)."""
    if STATEMENTS_LEFT_OUT.match(text) or PROCEDURE.match(text):
        return
    begin, declared = 0, False
    if DECLARATION.match(text) and ("::" in text or not re.match(r"[\w%]+\s*(\(.*\))?\s*=", text)):
        begin, declared = first_value(text), True
        if begin is None:
            return
    spans = [match.span() for match in INQUIRY.finditer(text)]

    def free(match):
        return match.start() >= begin and not any(a <= match.start() < b for a, b in spans)

    for match in filter(free, COMPARISON.finditer(text)):
        for new in COMPARISONS[match.group()]:
            yield "comparison", *match.span(), new
    for match in filter(free, re.finditer(r"(?<= )[+-](?= )", text)):
        yield "sign", *match.span(), "-" if match.group() == "+" else "+"
    for match in filter(free, re.finditer(r"(?<=[(=,\[])( *)-(?=[\w(])", text)):
        yield "sign", *match.span(), match.group(1)
    for match in filter(free, re.finditer(r"\.and\.|\.or\.", text, re.IGNORECASE)):
        yield "logical", *match.span(), ".or." if match.group().lower() == ".and." else ".and."
    for match in filter(free, re.finditer(r"\.not\. *", text, re.IGNORECASE)):
        yield "logical", *match.span(), ""
    for match in filter(free, re.finditer(r"\b(min|max)(val|loc)?(?= *\()", text)):
        yield "extreme", *match.span(), EXTREMES[match.group()]
    reals = [match for match in REAL.finditer(text)]
    for match in filter(free, reals):
        new = times_factor(match)
        if new:
            yield "constant", *match.span(), new
    spans += [match.span() for match in reals]
    for match in filter(free, INTEGER.finditer(text)):
        value = int(match.group(1))
        if declared and value > 3:
            yield "constant", *match.span(1), str(round(1.3 * value))
        else:
            yield "bound", *match.span(1), str(value + 1)
    if declared:
        return
    loop = re.match(r"(?:\w+\s*:\s*)?do\s+\w+\s*=", text, re.IGNORECASE)
    if loop:
        rest = text[loop.end():]
        for (_, end), change in zip(parts_at_commas(rest), (" + 1", " - 1")):
            yield "bound", loop.end() + end, loop.end() + end, change
    for match in re.finditer(r"(?<=[(,])( *[\w%]+):([\w%]+)(?= *[,)])", text):
        yield "bound", match.end(1), match.end(1), " + 1"
        yield "bound", match.end(2), match.end(2), " - 1"


def candidates(text):
    """All changes of a file: dicts of line (from 1), column (from 1), kind, before, after."""
    lines, found = text.split("\n"), []
    for places in statements(lines):
        joined = "".join(char for _, _, char in places)
        for kind, begin, end, new in changes_of(joined):
            here = places[begin:end] or [places[min(begin, len(places) - 1)]]
            line, column = here[0][0], here[0][1]
            if begin == end and begin >= len(places):
                column += 1
            # A change stands on one line.
            if any(place[:2] != (line, column + i) for i, place in enumerate(here)):
                continue
            before = lines[line]
            after = before[:column] + new + before[column + end - begin:]
            found.append({"line": line + 1, "column": column + 1, "kind": kind,
                          "before": before, "after": after})
    return found


# The draw

def folder_of(path):
    """The folder a file of src counts for: its first two parts."""
    return "/".join(Path(path).parts[:2]) if len(Path(path).parts) > 2 else "src"


def source_files(folders, without):
    """Files of src that offer changes, by folder."""
    files = defaultdict(list)
    for path in tracked_files():
        wanted = any(Path(path).is_relative_to(folder) for folder in folders)
        if wanted and Path(path).suffix in (".f90", ".F90", ".inc") and path not in LEFT_OUT \
                and not any(Path(path).match(pattern) for pattern in without) \
                and candidates((ROOT / path).read_text(encoding="utf-8")):
            files[folder_of(path)].append(path)
    return dict(sorted(files.items()))


def slots(seed, files, number):
    """The folder of each mutant: in turn, in an order by the seed, those of SELDOM once."""
    draw = random.Random(f"folders {seed}")
    turn = sorted(files)
    order = []
    while len(order) < number:
        draw.shuffle(turn)
        order += turn
        turn = [name for name in turn if name not in SELDOM] or turn
    return order[:number]


def draws(seed, slot, paths):
    """The changes for one slot, one after the other, all different."""
    draw = random.Random(f"mutant {seed} {slot}")
    offers = {path: candidates((ROOT / path).read_text(encoding="utf-8")) for path in paths}
    seen = set()
    for _ in range(MOST_DRAWS):
        path = draw.choices(list(offers), [len(found) for found in offers.values()])[0]
        kind = draw.choice(sorted({change["kind"] for change in offers[path]}))
        change = draw.choice([change for change in offers[path] if change["kind"] == kind])
        key = (path, change["line"], change["after"])
        if key not in seen:
            seen.add(key)
            yield {"file": path, **change}


# The constants of the solvers of interaction

def named_constants():
    """Those of the table that have a source; the others are rules of quadrature."""
    sys.path.insert(0, str(ROOT / "test/support"))
    table = __import__("constants_table")
    return {f"{one.file}:{one.name}": one for room in table.ROOMS
            for one in table.constants(room) if one.source}


def scaled_constants():
    """Both mutants of each constant: its value times 1.3 and over 1.3."""
    for name, one in named_constants().items():
        (path,) = (ROOT / "src" / one.room).glob(f"{one.file}.[fF]90")
        lines = path.read_text(encoding="utf-8").split("\n")
        for places in statements(lines):
            text = "".join(char for _, _, char in places)
            found = re.match(rf".*\bparameter\b.*::.*?\b{one.name}\b *(\([^()]*\))? *= *", text)
            if found:
                break
        begin = found.end()
        end = begin + parts_at_commas(text[begin:])[0][1]
        line, column = places[begin][:2]
        # Whole numbers are rounded away from the value.
        up = f"(({text[begin:end]})*13 + 9)/10" if text.startswith("integer") else \
            f"({text[begin:end]})*13/10"
        for kind, new in (("up", up), ("down", f"({text[begin:end]})*10/13")):
            yield {"number": 0, "constant": name, "test": one.test or ROOM_TESTS[one.room],
                   "file": str(path.relative_to(ROOT)), "line": line + 1, "kind": kind,
                   "before": lines[line],
                   "after": lines[line][:column] + new + lines[line][column + end - begin:]}


def run_constants(copies, record, names):
    """Judges the constants that the record lacks, or those that are named, by their tests."""
    def key(mutant):
        return mutant["constant"], mutant["test"], mutant["before"], mutant["after"]

    old = {key(mutant): mutant for mutant in record.data["mutants"]}
    record.data["mutants"] = [old.get(key(mutant), mutant) for mutant in scaled_constants()]
    todo = [mutant for mutant in record.data["mutants"] if (any(
        name in mutant["constant"] for name in names) if names else "outcome" not in mutant)]
    slow = (ROOT / "test/slow_tests.txt").read_text(encoding="utf-8")
    for marks in ("not slow", "slow"):
        copies[0].restore_build()
        for test in sorted({mutant["test"] for mutant in todo}):
            (path,) = (ROOT / "test").glob(f"*/{test}")
            if re.search(r"def \w+\((.*\b)?venv\b", path.read_text(encoding="utf-8")):
                failed = "needs the Python package of the mutant"
            else:
                failed = copies[0].test(test=test, marks=marks)
            if failed:
                print(f"left out, unchanged program: {test}, {marks}: {failed}", flush=True)
                todo = [mutant for mutant in todo if mutant["test"] != test]
        for mutant in todo:
            mutant["marks"] = marks
        run(copies, [(repeat, record, mutant) for mutant in todo])
        todo = [mutant for mutant in todo
                if mutant["outcome"] == "survived" and f"/{mutant['test']}::" in slow]


def write_constants(record, path):
    """A row for each constant: whether its test sees the changes, and the first that fails.

    A row without an outcome in the record is kept as it is.
    """
    words = {"noticed": "seen", "survived": "not seen"}
    with open(path, "a+", encoding="utf-8", newline="") as file:
        file.seek(0)
        old = {row[0]: row for row in csv.reader(file)}
        file.truncate(0)
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["constant", "test", "up", "down", "first test that fails"])
        for up, down in zip(*[iter(record.data["mutants"])] * 2, strict=True):
            outcomes = [mutant.get("outcome", "") for mutant in (up, down)]
            row = [up["constant"], up["test"],
                   *(words.get(outcome, outcome) for outcome in outcomes),
                   up.get("by") or down.get("by", "")]
            table.writerow(row if any(outcomes) else old.get(row[0], row))


# The copy and its build

def tracked_files():
    """Files of the tree that git has or would take."""
    done = subprocess.run(["git", "ls-files", "-z", "-co", "--exclude-standard"], cwd=ROOT,
                          capture_output=True, text=True, check=True)
    return sorted(path for path in done.stdout.split("\0") if path and (ROOT / path).is_file())


def commands_in(folder):
    """The compiler's arguments for each source file, as fpm lists them in a folder of builds."""
    path = folder / COMMANDS
    listed = json.loads(path.read_text(encoding="utf-8")) if path.exists() else []
    return {os.path.normpath(entry["file"]): entry["arguments"] for entry in listed}


class Copy:
    """A copy of the tree in which mutants are built and tested."""

    def __init__(self, folder, flags):
        self.flags = flags
        self.tree = folder / "tree"
        self.kept = folder / "build"
        self.log = folder / "log"
        self.scratch = folder / "modules"
        self.stopped = False
        tools = [ROOT / ".venv/bin", Path(sys.executable).parent]
        self.environment = {**os.environ, "OMP_NUM_THREADS": "2", "OMP_WAIT_POLICY": "passive",
                            "PYTHONDONTWRITEBYTECODE": "1",
                            "PATH": ":".join([*map(str, tools), os.environ["PATH"]]),
                            "PYTHONPATH": str(Path(__file__).resolve().parent)}

    def bring_up(self, built=None):
        """Makes the copy equal to the tree; builds it, or takes the build of an equal copy."""
        wanted = {path: (ROOT / path).read_bytes() for path in tracked_files()}
        present = {str(path.relative_to(self.tree)) for path in self.tree.rglob("*")
                   if path.is_file() and path.relative_to(self.tree).parts[0] not in
                   ("build", ".venv")}
        texts = False
        for path in present - wanted.keys():
            (self.tree / path).unlink()
        for path, content in wanted.items():
            target = self.tree / path
            if not target.is_file() or target.read_bytes() != content:
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(content)
                target.chmod((ROOT / path).stat().st_mode)
                texts = texts or target.suffix == ".inc"
        if (ROOT / ".venv").exists() and not (self.tree / ".venv").exists():
            (self.tree / ".venv").symlink_to(ROOT / ".venv")
        # fpm does not see a change in an included text.
        if texts:
            shutil.rmtree(self.kept, ignore_errors=True)
        if not built:
            self.restore_build()
            if not self.fpm():
                raise SystemExit(f"mutate: the unchanged program does not compile, see {self.log}")
        # fpm lists the commands of this build alone.
        old = commands_in(self.kept)
        shutil.rmtree(self.kept, ignore_errors=True)
        shutil.copytree(built.kept if built else self.tree / "build", self.kept)
        self.commands = {**old, **commands_in(self.kept)}
        (self.kept / COMMANDS).write_text(json.dumps(
            [{"file": path, "arguments": words} for path, words in self.commands.items()]),
            encoding="utf-8")
        self.restore_build()

    def restore_build(self):
        """Puts the build of the unchanged program in place."""
        shutil.rmtree(self.tree / "build", ignore_errors=True)
        if self.kept.exists():
            shutil.copytree(self.kept, self.tree / "build")

    def fpm(self):
        """Builds program and unit tests; True when that succeeds."""
        return self.call(["fpm", "build", "--no-prune", "--tests", "--flag", self.flags])

    def call(self, command):
        with open(self.log, "w", encoding="utf-8") as log:
            return subprocess.run(command, cwd=self.tree, env=self.environment, stdout=log,
                                  stdin=subprocess.DEVNULL, stderr=log).returncode == 0

    def program(self, name):
        """The path of what was built: app/asperity or test/unit."""
        found = list((self.tree / "build").glob(f"*/{name}"))
        if len(found) != 1:
            raise SystemExit(f"mutate: {len(found)} programs {name} in {self.tree / 'build'}")
        return found[0]

    def compiled_with(self, path):
        """The files that the compiler reads a text in: itself, or those that include it."""
        users = set()
        for other in (self.tree / "src").rglob("*"):
            if other.suffix in (".f90", ".F90", ".inc") and re.search(
                    rf"^\s*#?include\s+['\"]{re.escape(Path(path).name)}['\"]",
                    other.read_text(encoding="utf-8"), re.MULTILINE | re.IGNORECASE):
                users |= self.compiled_with(str(other.relative_to(self.tree)))
        return users or {path}

    def build_mutant(self, mutant):
        """Builds with one line changed; '' when that succeeds, else why it is drawn again."""
        target = self.tree / mutant["file"]
        text = target.read_text(encoding="utf-8")
        self.restore_build()
        target.write_text(changed(text, mutant), encoding="utf-8")
        try:
            users = self.compiled_with(mutant["file"])
            same_modules, same_objects = True, True
            objects = []
            for user in sorted(users):
                shutil.rmtree(self.scratch, ignore_errors=True)
                self.scratch.mkdir()
                command = list(self.commands[user])
                command[command.index("-J") + 1] = str(self.scratch)
                place = command.index("-o") + 1
                old = self.tree / command[place]
                new = self.log.parent / f"object{len(objects)}.o"
                command[place] = str(new)
                if not self.call(command):
                    return "does not compile"
                objects.append((old, new))
                same_objects &= old.read_bytes() == new.read_bytes()
                for module in self.scratch.iterdir():
                    same_modules &= module.read_bytes() == \
                        (old.parents[1] / module.name).read_bytes()
            if same_modules and same_objects:
                return "same object code"
            if same_modules:
                for old, new in objects:
                    shutil.copyfile(new, old)
            else:
                for old, _ in objects:
                    Path(f"{old}.digest").unlink(missing_ok=True)
            if same_modules:
                # fpm compiles nothing anew and links what is missing.
                target.write_text(text, encoding="utf-8")
                for old in [*self.tree.glob("build/*/*/libasperity.a"),
                            self.program("app/asperity"), self.program("test/unit"),
                            *self.program("app/asperity").parents[1].glob("example/*")]:
                    old.unlink()
            return "" if self.fpm() else "does not compile"
        finally:
            target.write_text(text, encoding="utf-8")

    def commands_of(self, test, marks):
        """Runs one test file: a suite of the unit tests, or tests of the harness with a mark."""
        if test.endswith("_suite.f90"):
            main = (self.tree / "test/unit/main.f90").read_text(encoding="utf-8")
            collect = re.search(rf"use asperity_{test[:-4]}, only: (\w+)", main)[1]
            title = re.search(rf"run_suite\('(.*)', {collect},", main)[1]
            return {"unit": [str(self.program("test/unit")), title]}
        (path,) = (self.tree / "test").glob(f"*/{test}")
        return {"harness": [*PYTEST, "-m", marks, str(path.relative_to(self.tree))]}

    def test(self, path="", test="", marks=""):
        """Runs both kinds of test at once, or one file; the first failure, or '' when all pass.

        Tests whose names share a word with the path of the changed file come first.
        """
        words = set(re.split(r"[\W_]", path)) - {"src", "f90", "F90", "inc", ""}
        order = sorted(QUICK, key=lambda name: words.isdisjoint(
            word for part in re.split(r"[\W_]", name) for word in (part, part.rstrip("s"))))
        start = time.monotonic()
        environment = {**self.environment, "ASPERITY_EXE": str(self.program("app/asperity"))}
        folder = self.log.parent
        commands = {"unit": [str(self.program("test/unit"))],
                    "harness": [*PYTEST, "-m", "not once and not long",
                                *[f"--deselect={name}" for name in QUICK_WITHOUT], *order]}
        limit = MUTANT_LIMIT
        if test:
            commands, limit = self.commands_of(test, marks), FILE_LIMIT
        running, verdict = {}, ""
        for name, command in commands.items():
            with open(folder / f"{name}.log", "w", encoding="utf-8") as log:
                running[name] = subprocess.Popen(
                    [*LIMITED, *command], cwd=self.tree, env=environment, stdout=log, stderr=log,
                    stdin=subprocess.DEVNULL, start_new_session=True)
        try:
            while running and not verdict:
                time.sleep(0.2)
                if self.stopped:
                    raise SystemExit("mutate: ended before all tests were run")
                for name, child in list(running.items()):
                    status = child.poll()
                    said = (folder / f"{name}.log").read_text(encoding="utf-8", errors="replace")
                    failed = re.search(r"^(?:FAILED|ERROR) (.*)", said, re.MULTILINE)
                    if name == "unit" and failed:
                        # Suite and test; what was found is cut off.
                        verdict = "unit: " + ": ".join(failed.group(1).split(": ")[:2])
                    elif name == "harness" and status in PYTEST_FAULTS:
                        raise SystemExit(f"mutate: pytest cannot run, see {folder}/harness.log")
                    elif status:
                        verdict = f"{name}: " + (failed.group(1).split(" - ")[0] if failed else
                                                 f"ended with status {status}")
                    if status is not None:
                        del running[name]
                if not verdict and time.monotonic() - start > limit:
                    verdict = f"no end within {limit} s"
            return verdict
        finally:
            for child in running.values():
                try:
                    os.killpg(child.pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass
                child.wait()


# Loaded by pytest (-p mutate): a test that does not end fails.

def pytest_runtest_setup(item):
    """Starts the clock of a test."""
    def stop(*_):
        raise TimeoutError(f"{item.nodeid} has not ended within {TEST_LIMIT} s")
    signal.signal(signal.SIGALRM, stop)
    signal.alarm(TEST_LIMIT)


def pytest_runtest_teardown():
    """Stops it."""
    signal.alarm(0)


def tests():
    """What is run, for a reader."""
    yield "all suites of test/unit"
    yield from QUICK
    for name in QUICK_WITHOUT:
        yield f"without {name}"
    yield "without tests marked once or long"


# The record

def changed(text, mutant):
    """The text with the mutant's line changed; the line may have moved, if it is still unique."""
    lines = text.split("\n")
    number = mutant["line"] - 1
    if number >= len(lines) or lines[number] != mutant["before"]:
        places = [i for i, line in enumerate(lines) if line == mutant["before"]]
        if len(places) != 1:
            raise SystemExit(f"mutate: {mutant['file']}:{mutant['line']} is no longer "
                             f"'{mutant['before'].strip()}'")
        number = places[0]
    return "\n".join([*lines[:number], mutant["after"], *lines[number + 1:]])


class Record:
    """The finished mutants of a seed, kept in a file."""

    def __init__(self, path, seed):
        self.path = path
        self.lock = threading.Lock()
        self.data = {"seed": seed, "commit": "", "mutants": [], "redrawn": []}
        if path.exists():
            self.data = json.loads(path.read_text(encoding="utf-8"))

    def save(self):
        """Writes the file whole."""
        part = self.path.with_suffix(".part")
        part.write_text(json.dumps(self.data, indent=1) + "\n", encoding="utf-8")
        part.replace(self.path)

    def mutant(self, number):
        """The mutant of a number."""
        for mutant in self.data["mutants"]:
            if mutant["number"] == number:
                return mutant
        raise SystemExit(f"mutate: no mutant {number} in {self.path}")

    def page(self, options):
        """The record as a page."""
        data = self.data
        groups = defaultdict(list)
        for mutant in data["mutants"]:
            groups[mutant["outcome"]].append(mutant)
        counts = ", ".join(f"{len(found)} {outcome}" for outcome, found in sorted(groups.items()))
        yield f"## Seed {data['seed']}"
        yield ""
        yield f"Command: `{options}`. Commit {data['commit']}. {len(data['mutants'])} mutants: " \
              f"{counts}. {len(data['redrawn'])} drawn again."
        yield ""
        yield "| mutant | line | change | outcome | first test that noticed, or reason |"
        yield "| --- | --- | --- | --- | --- |"
        for mutant in data["mutants"]:
            why = "; ".join(filter(None, [mutant.get("reason"), mutant.get("by"),
                                          mutant.get("note")]))
            yield (f"| {mutant['number']} | `{mutant['file']}:{mutant['line']}` | "
                   f"{shown(mutant)} | {mutant['outcome']} | {why.replace('|', '/')} |")
        yield ""
        if data["redrawn"]:
            yield "Drawn again:"
            yield ""
            for mutant in data["redrawn"]:
                yield (f"- `{mutant['file']}:{mutant['line']}` {shown(mutant)}: "
                       f"{mutant['outcome']}")
            yield ""


def shown(mutant):
    """Both lines, as code."""
    before, after = mutant["before"].strip(), mutant["after"].strip()
    return f"{mutant['kind']}: `{before}` → `{after}`".replace("|", "\\|")


def tell(mutant):
    """A line on standard output."""
    print(f"{mutant['number']:>3} {mutant['outcome']:<10} {mutant['file']}:{mutant['line']} "
          f"{shown(mutant)}  {mutant.get('by') or mutant.get('reason') or ''}", flush=True)


# The runs

def judge(copy, mutant):
    """Builds and tests a mutant; sets outcome, by and seconds. False when it is to be redrawn."""
    start = time.monotonic()
    why = copy.build_mutant(mutant)
    if why:
        mutant["outcome"] = why
        return False
    mutant["by"] = copy.test(mutant["file"], mutant.get("test"), mutant.get("marks"))
    mutant["outcome"] = "noticed" if mutant["by"] else "survived"
    mutant["seconds"] = round(time.monotonic() - start)
    return True


def draw_and_judge(copy, record, options, number, paths):
    """Fills one slot: draws until a change compiles."""
    redrawn = {(old["file"], old["line"], old["after"]) for old in record.data["redrawn"]}
    for mutant in draws(options.seed, number, paths):
        if (mutant["file"], mutant["line"], mutant["after"]) in redrawn:
            continue
        mutant = {"number": number, **mutant}
        compiled = judge(copy, mutant)
        with record.lock:
            record.data["mutants" if compiled else "redrawn"].append(mutant)
            record.data["mutants"].sort(key=lambda found: found["number"])
            record.save()
            tell(mutant)
        if compiled:
            return


def repeat(copy, record, mutant):
    """Judges a mutant of the record by the present tests."""
    judge(copy, mutant)
    with record.lock:
        record.save()
        tell(mutant)


def tasks_of(record, options):
    """The mutants that the record lacks, or those to be repeated."""
    if options.again is None:
        files = source_files(options.folder, options.without)
        finished = {mutant["number"] for mutant in record.data["mutants"]}
        return [(draw_and_judge, record, options, number, files[folder])
                for number, folder in enumerate(slots(options.seed, files, options.number), 1)
                if number not in finished]
    again = options.again or [mutant["number"] for mutant in record.data["mutants"]
                              if mutant["outcome"] == "survived"]
    return [(repeat, record, record.mutant(number)) for number in again]


def run(copies, tasks):
    """Judges mutants, in each copy one at a time."""
    spare = queue.SimpleQueue()
    for copy in copies:
        spare.put(copy)

    def in_a_copy(task, *words):
        copy = spare.get()
        try:
            task(copy, *words)
        finally:
            spare.put(copy)

    pool = ThreadPoolExecutor(len(copies))
    try:
        for done in [pool.submit(in_a_copy, *task) for task in tasks]:
            done.result()
    finally:
        for copy in copies:
            copy.stopped = True
        pool.shutdown(cancel_futures=True)
        for copy in copies:
            copy.stopped = False


def digest_of_tests():
    """A mark of everything that the tests depend on."""
    digest = hashlib.sha256()
    for path in tracked_files():
        if Path(path).parts[0] in ("app", "data", "fpm.toml", "include", "src", "test", "tools"):
            digest.update(path.encode() + (ROOT / path).read_bytes())
    return digest.hexdigest()


def check_unchanged(copy):
    """The tests must pass on the unchanged program, or they notice nothing; once is enough."""
    passed, digest = copy.log.parent / "passed", digest_of_tests()
    if passed.exists() and passed.read_text(encoding="ascii") == digest:
        return
    start = time.monotonic()
    failed = copy.test()
    if failed:
        raise SystemExit(f"mutate: the unchanged program fails: {failed}")
    passed.write_text(digest, encoding="ascii")
    print(f"unchanged program: all tests pass in {time.monotonic() - start:.0f} s", flush=True)


def arguments(words):
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--seed", type=int, default=1, help="of the draw (default: 1)")
    parser.add_argument("--number", type=int, default=25, help="of mutants (default: 25)")
    parser.add_argument("--folder", action="append", help="draw from this folder or file of src "
                        "(may be given several times; default: src)")
    parser.add_argument("--without", action="append", default=[], metavar="PATTERN",
                        help="leave out files of this pattern, e.g. 'src/input/scene_*'")
    parser.add_argument("--jobs", type=int, default=1, help="mutants at a time (default: 1)")
    parser.add_argument("--list", action="store_true", help="print the first draws, run nothing")
    parser.add_argument("--tests", action="store_true", help="print the tests, run nothing")
    parser.add_argument("--again", nargs="*", type=int, metavar="MUTANT",
                        help="repeat these mutants of the record, or all survivors")
    parser.add_argument("--equivalent", nargs=2, metavar=("MUTANT", "REASON"),
                        help="mark a survivor that can change no result")
    parser.add_argument("--note", nargs=2, metavar=("MUTANT", "TEXT"), help="add a remark")
    parser.add_argument("--constants", nargs="*", metavar="NAME",
                        help="judge the constants of the solvers by their own tests")
    parser.add_argument("--report", type=Path, metavar="FILE", help="write the record as a page")
    options = parser.parse_args(words)
    options.folder = options.folder or ["src"]
    return options


def main(words=None):
    """Does what the command line says; status 1 when a mutant survived."""
    options = arguments(words)
    if options.tests:
        print(*tests(), sep="\n")
        return 0
    files = source_files(options.folder, options.without)
    if not files:
        raise SystemExit(f"mutate: no file of src in {' '.join(options.folder)}")
    if options.list:
        for number, folder in enumerate(slots(options.seed, files, options.number), 1):
            tell({"number": number, "outcome": "", **next(draws(options.seed, number,
                                                                files[folder]))})
        return 0
    folder = ROOT / "build/mutants"
    folder.mkdir(parents=True, exist_ok=True)
    constants = options.constants is not None
    seed = "constants" if constants else options.seed
    record = Record(folder / f"seed-{seed}.json", seed)
    if options.equivalent or options.note:
        number, text = options.equivalent or options.note
        mutant = record.mutant(int(number))
        mutant["reason" if options.equivalent else "note"] = text
        if options.equivalent:
            mutant["outcome"] = "equivalent"
        record.save()
        return 0
    if options.report:
        words = [f"--seed {options.seed}", f"--number {options.number}"]
        words += [f"--without '{pattern}'" for pattern in options.without]
        options.report.write_text("\n".join(record.page(f"tools/mutate.py {' '.join(words)}")),
                                  encoding="utf-8")
        return 0
    # An end from outside ends the tests, too.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    with open(folder / "lock", "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not constants:
            print("tests:", *tests(), sep="\n  ", flush=True)
        name, flags = ("constants", CONSTANT_FLAGS) if constants else ("copy", FLAGS)
        copies = [Copy(folder / f"{name}{number}", flags)
                  for number in range(1, options.jobs + 1)]
        copies[0].bring_up()
        if not constants:
            check_unchanged(copies[0])
        for copy in copies[1:]:
            copy.bring_up(copies[0])
        record.data["commit"] = record.data["commit"] or subprocess.run(
            ["git", "describe", "--always", "--dirty"], cwd=ROOT, text=True, capture_output=True,
            check=False).stdout.strip()
        if constants:
            run_constants(copies, record, options.constants)
            write_constants(record, ROOT / "reference_output/interaction/constants.csv")
        else:
            run(copies, tasks_of(record, options))
    survivors = [mutant for mutant in record.data["mutants"] if mutant.get("outcome") == "survived"]
    print(f"{len(record.data['mutants'])} mutants, {len(survivors)} survived; record: "
          f"{record.path.relative_to(ROOT)}")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
