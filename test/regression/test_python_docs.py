"""What the Python package says of itself: types, examples of docstrings, pages and notebooks."""

import ast
import doctest
import inspect
import os
import re
import sys

import matplotlib
import notebooks
import pytest
from builds import ROOT
from programs import run_program

matplotlib.use("Agg")

pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]

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


def test_types_notice_an_error(tmp_path):
    """A wrong argument is found by the types of the package."""
    (tmp_path / "wrong.py").write_text("import asperity\nasperity.solve(3)\n"
                                       "asperity.HeightMap([[0.0]], 1.0, periodic='yes')\n")
    done = run_program(sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path,
                       tmp_path / "wrong.py", status=1, cwd=ROOT / "python")
    assert done.stdout.count("error:") == 2, done.stdout


def test_examples_of_docstrings(package, monkeypatch):
    """Each public function and class has an example that runs and shows what it says."""
    monkeypatch.chdir(ROOT)
    finder, runner = doctest.DocTestFinder(), doctest.DocTestRunner(
        optionflags=doctest.NORMALIZE_WHITESPACE)
    with_example = set()
    for test in finder.find(package, "asperity"):
        if test.examples:
            runner.run(test)
            with_example.add(test.name)
    assert runner.failures == 0 and runner.tries > 20
    for name in ("solve", "report", "summits", "generate", "read_map", "Scene", "HeightMap",
                 "Results", "Table"):
        assert f"asperity.{name}" in with_example, name


def test_docstrings(package):
    """Numpydoc: every public function and method names its parameters and what it returns."""
    for name in package.__all__[:-1]:
        thing = getattr(package, name)
        if inspect.isclass(thing) and issubclass(thing, Exception):
            assert inspect.getdoc(thing)
            continue
        members = [thing] + [member for key, member in vars(thing).items()
                             if inspect.isfunction(member) and not key.startswith("_")] \
            if inspect.isclass(thing) else [thing]
        for member in members:
            text = inspect.getdoc(member)
            assert text and text[0].isupper(), (name, member)
            names = [one for one in inspect.signature(member).parameters
                     if one not in ("self", "args", "kwargs")] if callable(member) else []
            if inspect.isfunction(member) and len(names) > 1:
                for one in names:
                    assert re.search(rf"^[\w*, ]*\b{one}\b", text, re.M), (name, one)


def test_page_examples(package, venv, tmp_path):
    """The examples of the pages run, each by itself."""
    environment = {**os.environ, "PYTHONPATH": str(next(venv.glob("lib/python*/site-packages"))),
                   "MPLBACKEND": "Agg"}
    for name, text in page_examples().items():
        run_program(sys.executable, "-W", "ignore", "-c", text, cwd=ROOT, env=environment)


def test_width_of_examples():
    """Lines of the examples fit into the column of the site: 84 letters."""
    pages = [ROOT / "README.md", *(ROOT / "docs").glob("**/*.md")]
    wide = [(page.name, line) for page in pages
            for text in re.findall(r"```py(?:thon)?\n(.*?)```", page.read_text(encoding="utf-8"),
                                   re.S)
            for line in text.splitlines() if len(line) > 84]
    assert not wide


def test_first_example_is_short():
    """The page keeps its promise: at most twelve lines, and neither savetxt nor asarray."""
    text = page_examples()["tutorial_first_contact_python_1"]
    assert len(text.splitlines()) <= 12 and "savetxt" not in text and "asarray" not in text
    assert ast.parse(text)


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_notebook(venv, name, monkeypatch):
    """A notebook runs, draws, and prints what it shows."""
    monkeypatch.setenv("PYTHONPATH", str(next(venv.glob("lib/python*/site-packages"))))
    path = ROOT / f"python/notebooks/{name}.ipynb"
    kept, made = notebooks.nbformat.read(path, 4), notebooks.executed(path)
    assert notebooks.printed(made) == notebooks.printed(kept), \
        f"after pip install ./python: python test/support/notebooks.py {path}"
    assert notebooks.pictures(made) == notebooks.pictures(kept) >= 1


def test_five_notebooks():
    assert len(NOTEBOOKS) == 5
