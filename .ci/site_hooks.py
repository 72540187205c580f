"""Hooks of mkdocs: files beside docs that pages link to become files of the site, in project/.

Pages link to README.md, CONTRIBUTING.md, examples and archived results as files of the project.
The site has a copy of each under project/, so that no link leads out of it.
"""

import os
import re
from pathlib import Path, PurePosixPath

from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parents[1]
LINK = re.compile(r"(\]\()([^)\s#]+)(#[^)\s]*)?(\))")
FORTRAN = ROOT / "build/fortran"
# Weight of pages in the results of the search, by the start of their source; 1 for others.
WEIGHTS = {"project/": 0.1, "development/": 0.3, "reference/python-api.md": 0.2,
           "reference/glossary.md": 6, "reference/scene.md": 4, "reference/": 1.5}


def outside(source, target):
    """The file of the project that a link of a page leads to, if it is not in docs."""
    if re.match(r"[a-z]+:|/", target):
        return None
    path = os.path.normpath((PurePosixPath(source).parent / target).as_posix())
    return None if path.startswith(("docs/", "..")) or not (ROOT / path).is_file() else path


def address(path):
    """The source of a file of the project in the site."""
    return f"project/{path}"


def rewritten(markdown, source, at):
    """A page with its links to files of the project; source: in the project, at: in the site."""
    def change(link):
        path = outside(source, link[2])
        if path:
            new = os.path.relpath(address(path), PurePosixPath(at).parent)
        elif source.startswith("docs/") or re.match(r"[a-z]+:", link[2]):
            return link[0]
        else:
            inner = os.path.normpath((PurePosixPath(source).parent / link[2]).as_posix())
            new = os.path.relpath(inner.removeprefix("docs/"), PurePosixPath(at).parent)
        return f"{link[1]}{new}{link[3] or ''}{link[4]}"
    return LINK.sub(change, markdown)


def linked_files():
    """All files of the project that pages link to, over any number of links."""
    waiting = [str(path.relative_to(ROOT)) for path in sorted(ROOT.glob("docs/**/*.md"))]
    found = set()
    while waiting:
        source = waiting.pop()
        for link in LINK.finditer((ROOT / source).read_text(encoding="utf-8")):
            path = outside(source, link[2])
            if path and path not in found:
                found.add(path)
                waiting += [path] if path.endswith(".md") else []
    return sorted(found)


def on_config(config):
    """A menu entry for the API pages of the Fortran library."""
    if (FORTRAN / "index.html").is_file():
        (reference,) = [part["Reference"] for part in config.nav if "Reference" in part]
        reference.append({"Fortran modules": "fortran/index.html"})
    return config


def on_files(files, config):
    """Adds the files of the project, and the API pages of the Fortran library where they are."""
    for path in linked_files():
        at = address(path)
        if path.endswith(".md"):
            text = rewritten((ROOT / path).read_text(encoding="utf-8"), path, at)
            files.append(File.generated(config, at, content=text))
        else:
            files.append(File.generated(config, at, abs_src_path=str(ROOT / path)))
    for path in sorted(FORTRAN.rglob("*")):
        at = f"fortran/{path.relative_to(FORTRAN)}"
        if path.suffix == ".html":
            files.append(File.generated(config, at, content=with_anchors(path)))
        elif path.is_file():
            files.append(File.generated(config, at, abs_src_path=str(path)))
    return files


def with_anchors(path):
    """A page of FORD. Its list of the procedures of a generic interface links to anchors that the
    page has under another name."""
    return re.sub(r"#moduleprocedure-(\w+)(~\d+)?", r"#proc-\1",
                  path.read_text(encoding="utf-8"))


def on_page_markdown(markdown, page, config, files):
    """Links of the pages of docs."""
    source = page.file.src_uri
    weights = [weight for start, weight in WEIGHTS.items() if source.startswith(start)]
    page.meta["search"] = {"boost": weights[0] if weights else 1}
    if source.startswith("project/"):
        return markdown
    return rewritten(markdown, f"docs/{source}", source)
