"""Compares asperity with other programs and writes the table of docs/reference/validation.md.

    python test/validation/make_page.py [--check]

--check prints the table and leaves the page as it is. Without the package in this Python it is
installed from python/ into build/validation.
"""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/reference/validation.md"
BEGIN, END = "<!-- begin: made by make validation -->", "<!-- end -->"
# Module and function of each suite.
SUITES = (("suite_contact", "suite"), ("suite_contact_mechanics", "suite"),
          ("suite_programs", "contact_mechanics"), ("suite_adhesion", "suite"),
          ("suite_programs", "tamaas"), ("suite_programs", "lammps"))


def run_suite(module, function):
    return getattr(importlib.import_module(module), function)()


def row_of(suite):
    met = sum(row.met for row in suite.rows)
    return (f"| {suite.name} | {suite.source} | {len(suite.rows)} | {met} | "
            f"{len(suite.rows) - met} |")


def misses_of(suite):
    """A row for each reason: the numbers that are missed for it, by case."""
    reasons = {}
    for row in suite.rows:
        if not row.met:
            case, _, quantity = row.name.rpartition(", ")
            cases = reasons.setdefault(row.reason or "no reason is known", {})
            cases.setdefault(case, []).append(quantity)
    for reason, cases in reasons.items():
        missed = "; ".join(f"{case}: {', '.join(names)}" for case, names in cases.items())
        yield f"| {suite.name} | {missed} | {reason} |"


def table(suites):
    yield "| suite | numbers from | comparisons | passed | missed |"
    yield "| --- | --- | ---: | ---: | ---: |"
    yield from map(row_of, suites)
    rows = [row for suite in suites for row in suite.rows]
    met = sum(row.met for row in rows)
    yield f"| all | | {len(rows)} | {met} | {len(rows) - met} |"
    yield ""
    yield "| suite | missed | reason |"
    yield "| --- | --- | --- |"
    for suite in suites:
        yield from misses_of(suite)


def install_package():
    """Put the package on the path; it is built from the sources of this checkout."""
    if importlib.util.find_spec("asperity"):
        return
    folder = ROOT / "build/validation"
    path = os.pathsep.join((str(ROOT / ".venv/bin"), os.environ["PATH"]))
    for command in (["venv", "--clear", "--without-pip", folder],
                    ["pip", "--python", folder / "bin/python", "install", "-q", "--no-index",
                     "--disable-pip-version-check", ROOT / "python"]):
        subprocess.run([sys.executable, "-m", *command], check=True, cwd=ROOT,
                       env={**os.environ, "PATH": path})
    sys.path.insert(0, str(next(folder.glob("lib/python*/site-packages"))))


def main(check):
    install_package()
    lines = list(table([run_suite(*names) for names in SUITES]))
    print("\n".join(lines))
    if not check:
        before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
        PAGE.write_text(f"{before}{BEGIN}\n\n" + "\n".join(lines)
                        + f"\n\n{END}{rest.partition(END)[2]}", encoding="utf-8")


if __name__ == "__main__":
    main("--check" in sys.argv[1:])
