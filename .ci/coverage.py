"""Lines of src that the tests ran, by file, from what a build with --coverage has counted.

    python .ci/coverage.py LEAST [FOLDER]       (default folder: build)

Ends with status 1 when less than LEAST per cent of all lines of src ran. A line is one that holds
code for gcov. A line of an included text ran if it ran in any of the arithmetics it is compiled
for. `end module` holds only procedures the compiler made up for types, and is no line.
"""

import json
import os
import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NO_LINE = re.compile(r"\s*end\s+(sub)?module\b", re.IGNORECASE)


def counted_files(folder):
    """What gcov says of every object that was compiled for counting, file by file."""
    tool = os.environ.get("GCOV", "gcov")
    notes = sorted(map(str, folder.rglob("*.gcno")))
    if not notes:
        raise SystemExit(f"coverage: nothing in {folder} was built with --coverage")
    done = subprocess.run([tool, "--json-format", "--stdout", *notes],
                          cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"coverage: {tool} failed:\n{done.stderr}")
    for document in done.stdout.splitlines():
        yield from json.loads(document)["files"]


def runs_by_line(folder):
    """For every file of src, how often each of its lines ran."""
    runs = defaultdict(lambda: defaultdict(int))
    for entry in counted_files(folder):
        path = (ROOT / entry["file"]).resolve()
        if path.is_relative_to(ROOT / "src"):
            for line in entry["lines"]:
                runs[path][line["line_number"]] += line["count"]
    for path, lines in runs.items():
        text = path.read_text(encoding="utf-8").splitlines()
        for number in [number for number in lines if NO_LINE.match(text[number - 1])]:
            del lines[number]
    return {path: lines for path, lines in sorted(runs.items()) if lines}


def ranges(numbers):
    """1, 2, 3, 7 as `1-3 7`."""
    parts = []
    for number in numbers:
        if parts and parts[-1][1] == number - 1:
            parts[-1][1] = number
        else:
            parts.append([number, number])
    return " ".join(str(a) if a == b else f"{a}-{b}" for a, b in parts)


def main(least, folder="build"):
    runs = runs_by_line(ROOT / folder)
    listed = {path.resolve() for path in (ROOT / "src").rglob("*")
              if path.suffix in (".f90", ".F90")}
    all_lines = all_run = 0
    print(f"{'file':<40} {'lines':>6} {'run':>6} {'%':>6}  not run")
    for path, lines in runs.items():
        missed = sorted(number for number, count in lines.items() if count == 0)
        run = len(lines) - len(missed)
        print(f"{path.relative_to(ROOT).as_posix():<40} {len(lines):>6} {run:>6} "
              f"{100 * run / len(lines):>6.1f}  {ranges(missed)}".rstrip())
        all_lines += len(lines)
        all_run += run
    share = 100 * all_run / all_lines
    print(f"{'src':<40} {all_lines:>6} {all_run:>6} {share:>6.1f}")
    without = [path.relative_to(ROOT).as_posix() for path in sorted(listed - set(runs))]
    if without:
        print("no lines of their own:", " ".join(without))
    return 0 if share >= float(least) else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
