"""Changes single lines of src and lists the changes that no test notices.

    mutate.py src/circles src/grid --number 10 --seed 1    mutants of universalmutator
    mutate.py --constants [PART...]                        constants of the interaction solvers

A mutant is built in a copy of the tree, build/mutants, and runs against its tests: the unit tests
and the tests marked `fast`; the first failure ends them. universalmutator, with its rules for
Fortran, makes the changes. Survivors are printed; exit status 1 where there is one.

--constants takes each constant of the table of docs/theory/interaction.md with PART in its name,
once times 1.3 and once over 1.3, and runs the test that its comment names, or else a suite of its
folder. Its rows go to reference_output/interaction/constants.csv.
"""

import argparse
import csv
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TREE = ROOT / "build/mutants"
sys.path.insert(0, str(ROOT / "test/support"))
from constants_table import ROOMS, constants  # noqa: E402

FLAGS = "-O1 -g0 -fcheck=bounds -fopenmp"
# Run for constants whose comments name no test.
ROOM_TESTS = {"grid": "elements_suite.f90", "circles": "coupled_suite.f90",
              "joint": "joint_suite.f90"}
LIMIT = 1800  # seconds of all tests of a mutant
KEPT = ROOT / "reference_output/interaction/constants.csv"
# Lines without a statement that could change a result.
NO_STATEMENT = re.compile(r"\s*(!|#|use |end\b|implicit|private|public|interface|contains|module|"
                          r"(pure |elemental )*(subroutine|function)|.*intent\()", re.IGNORECASE)


def copy_tree():
    """Makes build/mutants equal to the files that git has; builds there are kept."""
    done = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT,
                          capture_output=True, text=True, check=True)
    paths = {path for path in done.stdout.splitlines() if (ROOT / path).is_file()}
    for source in [*(TREE / "src").rglob("*.*90"), *(TREE / "test").rglob("*.*90")]:
        if str(source.relative_to(TREE)) not in paths:
            source.unlink()
    for path in sorted(paths):
        target = TREE / path
        content = (ROOT / path).read_bytes()
        if not target.is_file() or target.read_bytes() != content:
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / path, target)
    if not (TREE / ".venv").exists():
        (TREE / ".venv").symlink_to(ROOT / ".venv")


def run(*command, **variables):
    """Status and output of a command in the copy; 8 GiB of addresses, and an end in time."""
    limited = ["timeout", str(LIMIT), "sh", "-c", 'ulimit -v 8388608; exec "$@"', "sh", *command]
    done = subprocess.run(limited, cwd=TREE, capture_output=True, text=True,
                          env={**os.environ, "OMP_NUM_THREADS": "2", **variables})
    return done.returncode, done.stdout + done.stderr


def program(name):
    """A program of the build with the unit tests; tests of the library build another one."""
    (path,) = TREE.glob("build/*/test/unit")
    return str(path.parents[1] / name)


def first_failure(test=""):
    """The first test that fails: of one file, or of all units and the fast tests; else ''."""
    suite = []
    if test.endswith("_suite.f90"):
        main = (TREE / "test/unit/main.f90").read_text(encoding="utf-8")
        collect = re.search(rf"use asperity_{test[:-4]}, only: (\w+)", main)[1]
        suite = [re.search(rf"run_suite\('(.*)', {collect},", main)[1]]
    commands = [[program("test/unit"), *suite]] if suite or not test else []
    if not suite:
        files = [str(path) for path in (TREE / "test").glob(f"*/{test}")] if test else \
            [f"test/{name}" for name in ("hard", "maps", "effects", "contact", "files")]
        commands.append([".venv/bin/python", "-m", "pytest", "--rootdir", ".", "-q", "-x", "-rfE",
                         *([] if test else ["-m", "fast and not once", "-n", "2"]), *files])
    for command in commands:
        status, text = run(*command, ASPERITY_EXE=program("app/asperity"))
        if status:
            found = re.search(r"^(?:FAILED|ERROR) (.*?)(?: - |: found|$)", text, re.MULTILINE)
            return found[1] if found else f"status {status}"
    return ""


def outcome(path, text, test=""):
    """What becomes of a mutant: `seen` with the failing test, `not seen`, or `does not build`."""
    old = (TREE / path).read_text(encoding="utf-8")
    (TREE / path).write_text(text, encoding="utf-8")
    try:
        if build():
            return "does not build", ""
        failure = first_failure(test)
        return ("seen", failure) if failure else ("not seen", "")
    finally:
        (TREE / path).write_text(old, encoding="utf-8")


def build():
    return run(".venv/bin/fpm", "build", "--no-prune", "--tests", "--flag", FLAGS)[0]


def statement(line):
    """A line without its comment."""
    return re.match(r"""(?:'[^']*'|"[^"]*"|[^!'"])*""", line)[0].strip()


def mutants_of(path, seed):
    """The mutants of a file, in an order by the seed, but those of comments and declarations."""
    text = (ROOT / path).read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "source.f90"
        source.write_text(text, encoding="utf-8")
        subprocess.run([Path(sys.executable).parent / "mutate", source, "fortran", "--noCheck",
                        "--mutantDir", folder], stdout=subprocess.DEVNULL, check=True, cwd=folder)
        found = [file.read_text(encoding="utf-8") for file in
                 sorted(Path(folder).glob("source.mutant.*"))]
    random.Random(f"{seed} {path}").shuffle(found)
    for one in found:
        changed = [lines for lines in zip(text.splitlines(), one.splitlines())
                   if lines[0] != lines[1]]
        if len(changed) == 1 and not NO_STATEMENT.match(changed[0][0]) and \
                statement(changed[0][1]) not in ("", statement(changed[0][0])):
            yield one, changed[0]


def mutate_folders(folders, number, seed):
    """Mutants of files drawn from the folders in turn; the number of survivors."""
    files = {folder: sorted(str(path.relative_to(ROOT)) for path in (ROOT / folder).rglob("*.f90"))
             for folder in folders}
    draw, survivors, judged = random.Random(seed), 0, 0
    while judged < number:
        path = draw.choice(files[folders[judged % len(folders)]])
        for text, (before, after) in mutants_of(path, draw.random()):
            found, test = outcome(path, text)
            if found == "does not build":
                continue
            judged += 1
            survivors += found == "not seen"
            print(f"{found:<9} {path}\n  - {before.strip()}\n  + {after.strip()}\n  {test}",
                  flush=True)
            break
    return survivors


def scaled(one, factor):
    """The file of a constant, and its text with the value scaled; whole numbers round away."""
    (path,) = (ROOT / "src" / one.room).glob(f"{one.file}.[fF]90")
    text = path.read_text(encoding="utf-8")
    found = re.search(rf"^ *(integer|real)[^!\n]*\bparameter\b[^!]*?\b{one.name}\b *"
                      r"(?:\([^()]*\))? *= *(\[[^]]*\]|[^,!&\n]+)", text, re.MULTILINE)
    value = found[2].strip()
    new = {"up": f"({value})*13/10", "down": f"({value})*10/13"}[factor]
    if found[1] == "integer" and factor == "up":
        new = f"(({value})*13 + 9)/10"
    start = found.start(2)
    return str(path.relative_to(ROOT)), text[:start] + new + text[start + len(value):]


def scale_constants(parts):
    """Writes the rows of constants whose names have one of the parts; all if there is none."""
    with open(KEPT, encoding="utf-8", newline="") as file:
        old = {row["constant"]: row for row in csv.DictReader(file)}
    rows = []
    for one in (one for room in ROOMS for one in constants(room) if one.source):
        name, test = f"{one.file}:{one.name}", one.test or ROOM_TESTS[one.room]
        row = {"constant": name, "reason": one.source, "test": test}
        if not parts or any(part in name for part in parts):
            for factor in ("up", "down"):
                row[factor], failure = outcome(*scaled(one, factor), test)
                row["first test that fails"] = failure or row.get("first test that fails", "")
            print(*row.values(), sep=",", flush=True)
        rows.append({**old.get(name, {}), **row})
    with open(KEPT, "w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, ["constant", "reason", "test", "up", "down",
                                      "first test that fails"], lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*")
    parser.add_argument("--constants", action="store_true")
    parser.add_argument("--number", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    words = parser.parse_args()
    copy_tree()
    failure = "its build" if build() else "" if words.constants else first_failure()
    if failure:
        raise SystemExit(f"mutate: the unchanged program fails: {failure}")
    if words.constants:
        return scale_constants(words.names)
    return mutate_folders(words.names or ["src/circles", "src/grid", "src/effects", "src/run"],
                          words.number, words.seed) > 0


if __name__ == "__main__":
    sys.exit(main())
