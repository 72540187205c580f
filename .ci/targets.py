"""Every make target sets up what its Python needs: what each imports, against what it installs.

    python .ci/targets.py        fails with a line for each import that nothing brings

Cheap, so that CI can ask it at every change: no target is run. An import is looked for in the
standard library, beside the script and in the folders of tests, then in the lists of requirements
of the groups that a line `.ci/setup GROUP...` of the target or of its script names.
"""

import ast
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = [ROOT / "test" / name
           for name in ("", "support", "truth", "regression", "hard", "bench", "validation")]
LISTS = {"test": "test/requirements.txt", "bench": "test/bench/requirements.txt",
         "build": ".ci/requirements/build.txt", "lint": ".ci/requirements/lint.txt",
         "docs": ".ci/requirements/docs.txt", "wheel": ".ci/requirements/wheel.txt"}
# What a package is called when it is imported.
MODULES = {"pytest-xdist": "xdist", "surfacetopography": "SurfaceTopography"}
# Targets whose script runs the harness.
HARNESS = {".ci/test", ".ci/images", ".ci/trouble", ".ci/wheel-test"}


def recipes():
    """The text of each target's recipe."""
    text = (ROOT / "Makefile").read_text(encoding="utf-8")
    return re.findall(r"^([a-z-]+):.*\n((?:\t.*\n)+)", text, re.MULTILINE)


def imports(path, seen):
    """Modules from outside that a script imports, by itself or by those beside it."""
    if path in seen:
        return
    seen.add(path)
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [node.module]
        for name in (name.split(".")[0] for name in names):
            local = [folder / f"{name}.py" for folder in [path.parent, *FOLDERS]]
            local = [file for file in local if file.exists()]
            if local:
                yield from imports(local[0], seen)
            elif name not in sys.stdlib_module_names:
                yield name, path


def brought(groups):
    """Modules that the lists of some groups install."""
    for group in groups & LISTS.keys():
        for line in (ROOT / LISTS[group]).read_text(encoding="utf-8").splitlines():
            if match := re.match(r"([A-Za-z0-9_-]+)", line):
                name = match.group(1).lower()
                yield MODULES.get(name, name.replace("-", "_"))


def main():
    wrong, looked_at = [], 0
    for target, text in recipes():
        called = [(ROOT / name).read_text(encoding="utf-8")
                  for name in re.findall(r"bash (\.ci/[a-z-]+)", text)]
        groups = {group for lines in (text, *called)
                  for found in re.findall(r"\.ci/setup ([a-z ]+)", lines)
                  for group in found.split()}
        scripts = [ROOT / name for name in re.findall(r"python (\S+\.py)", text)]
        if any(f"bash {script}" in text for script in HARNESS):
            scripts += [file for name in ("", "regression", "hard", "wheel")
                        for file in sorted((ROOT / "test" / name).glob("*.py"))]
        have, seen = set(brought(groups)), set()
        for script in scripts:
            looked_at += 1
            wrong += [f"make {target}: {path.relative_to(ROOT)} imports {name}, which .ci/setup "
                      f"{' '.join(sorted(groups))} does not install"
                      for name, path in imports(script, seen) if name not in have]
    if looked_at < 20:
        wrong.append(f"only {looked_at} scripts found: the Makefile is not read rightly")
    print("\n".join(sorted(set(wrong))), end="\n" if wrong else "")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
