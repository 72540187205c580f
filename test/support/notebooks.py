"""Executes notebooks with nbclient.

    python test/support/notebooks.py NOTEBOOK...   puts what the cells print and draw into them

To be run by a Python that has the package `asperity`. Paths are relative to the notebook.
"""

import sys
import tempfile
from pathlib import Path

import nbformat
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient


def executed(path):
    """The notebook with the outputs of a fresh run, without warnings: they have a path.

    Sockets are files: a free TCP port may be taken by another program before the kernel binds it.
    """
    book = nbformat.read(path, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        kernel = AsyncKernelManager(kernel_name="python3", transport="ipc", ip=f"{folder}/kernel")
        NotebookClient(book, timeout=100, km=kernel,
                       resources={"metadata": {"path": str(Path(path).parent)}}).execute()
    for cell in book.cells:
        cell.metadata.pop("execution", None)
        if cell.cell_type == "code":
            cell.outputs = [output for output in cell.outputs if output.get("name") != "stderr"]
    return book


def printed(book):
    """What each code cell prints, and the text of its last value."""
    return [[output.get("text") or output.get("data", {}).get("text/plain", "")
             for output in cell.outputs if "image/png" not in output.get("data", {})]
            for cell in book.cells if cell.cell_type == "code"]


def pictures(book):
    """The number of pictures in the outputs."""
    return sum("image/png" in output.get("data", {})
               for cell in book.cells if cell.cell_type == "code" for output in cell.outputs)


if __name__ == "__main__":
    for name in sys.argv[1:]:
        nbformat.write(executed(name), name)
