"""Runs the code cells of notebooks, without Jupyter: a notebook is JSON.

    python test/regression/notebooks.py NOTEBOOK...          prints what each cell prints, as JSON
    python test/regression/notebooks.py --write NOTEBOOK...  puts it into the notebooks

To be run by a Python that has the package `asperity`. Paths are relative to the notebook.
"""

import contextlib
import io
import json
import os
import sys
from pathlib import Path


def code_cells(path):
    """The code cells of a notebook; one that is tagged `times` prints what no two runs print."""
    book = json.loads(Path(path).read_text(encoding="utf-8"))
    return [cell for cell in book["cells"] if cell["cell_type"] == "code"]


def shown(cell):
    """What a cell has printed, as the notebook keeps it."""
    return "".join("".join(output["text"]) for output in cell["outputs"])


def run(path):
    """What each code cell prints, run one after the other."""
    names = {"__name__": "__main__"}
    texts, cells = [], code_cells(path)
    before = Path.cwd()
    os.chdir(Path(path).parent)
    try:
        for cell in cells:
            with contextlib.redirect_stdout(io.StringIO()) as text:
                exec(compile("".join(cell["source"]), str(path), "exec"), names)
            texts.append(text.getvalue())
    finally:
        os.chdir(before)
    return texts


def write(path):
    """Puts what the cells print into the notebook."""
    book = json.loads(Path(path).read_text(encoding="utf-8"))
    cells = [cell for cell in book["cells"] if cell["cell_type"] == "code"]
    for number, (cell, text) in enumerate(zip(cells, run(path)), 1):
        cell["execution_count"] = number
        cell["outputs"] = [{"name": "stdout", "output_type": "stream",
                            "text": text.splitlines(keepends=True)}] if text else []
    Path(path).write_text(json.dumps(book, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def main(arguments):
    if arguments[:1] == ["--write"]:
        for path in arguments[1:]:
            write(path)
    else:
        json.dump([run(path) for path in arguments], sys.stdout)


if __name__ == "__main__":
    main(sys.argv[1:])
