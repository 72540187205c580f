"""What the Python package states of itself: types, examples of docstrings, pages and notebooks."""

import doctest
import os
import re
import sys

import notebooks
import pytest
from builds import ROOT
from programs import run_program

pytestmark = [pytest.mark.pages, pytest.mark.filterwarnings("ignore::UserWarning")]

NOTEBOOKS = sorted(path.stem for path in (ROOT / "python/notebooks").glob("*.ipynb"))


def page_examples():
    """The Python examples of the pages, by page and number."""
    pages = [ROOT / "README.md", ROOT / "python/README.md",
             *sorted((ROOT / "docs").glob("**/*.md"))]
    return {f"{page.parent.stem}_{page.stem}_{number}".replace("-", "_"): text
            for page in pages for number, text in enumerate(
                re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.S), 1)}


def test_types(tmp_path):
    """mypy --strict on the package, on the examples of the pages, and on the notebooks."""
    sources = [ROOT / "python/asperity"]
    for name, text in page_examples().items():
        sources.append(tmp_path / f"page_{name}.py")
        sources[-1].write_text(text)
    for name in NOTEBOOKS:
        sources.append(tmp_path / f"notebook_{name}.py")
        cells = notebooks.nbformat.read(ROOT / f"python/notebooks/{name}.ipynb", 4).cells
        sources[-1].write_text("\n".join(cell.source for cell in cells
                                         if cell.cell_type == "code"))
    run_program(sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path,
                "--disable-error-code", "import-untyped", *sources, cwd=ROOT / "python")
    assert len(sources) > 8


def test_examples_of_docstrings(package, monkeypatch):
    """Each public function and class has an example that runs and shows what it states."""
    monkeypatch.chdir(ROOT)
    finder, runner = doctest.DocTestFinder(), doctest.DocTestRunner(
        optionflags=doctest.NORMALIZE_WHITESPACE)
    with_example = set()
    for test in finder.find(package, "asperity", extraglobs={"asperity": package}):
        if test.examples:
            runner.run(test)
            with_example.add(test.name)
    assert runner.failures == 0 and runner.tries > 20
    for name in ("solve", "report", "summits", "generate", "read_map", "Scene", "HeightMap",
                 "Results", "Table"):
        assert f"asperity.{name}" in with_example, name


def test_page_examples(package, venv, checkout):
    """The examples of the pages run, each by itself, in a folder that looks like the checkout."""
    environment = {**os.environ, "PYTHONPATH": str(next(venv.glob("lib/python*/site-packages"))),
                   "MPLBACKEND": "Agg"}
    for name, text in page_examples().items():
        run_program(sys.executable, "-W", "ignore", "-c", text, cwd=checkout, env=environment)


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_notebook(venv, name, monkeypatch):
    """A notebook runs, draws, and prints what it shows."""
    monkeypatch.setenv("PYTHONPATH", str(next(venv.glob("lib/python*/site-packages"))))
    monkeypatch.delenv("MPLBACKEND")
    path = ROOT / f"python/notebooks/{name}.ipynb"
    kept, made = notebooks.nbformat.read(path, 4), notebooks.executed(path)
    assert notebooks.printed(made) == notebooks.printed(kept), \
        f"after pip install ./python: python test/support/notebooks.py {path}"
    assert notebooks.pictures(made) == notebooks.pictures(kept) >= 1
