"""Links between the pages of a built site: each leads to a file and, with one, to an anchor.

usage: site_links.py FOLDER    prints page and link where not, and ends with status 1
"""

import re
import sys
from functools import cache
from html import unescape
from pathlib import Path
from urllib.parse import unquote

LINK = re.compile(r"""\bhref\s*=\s*["']([^"']*)["']""")
ANCHOR = re.compile(r"""\b(?:id|name)\s*=\s*["']?([^"'\s>]+)""")
# Addresses of other sites, and scripts.
ELSEWHERE = re.compile(r"[a-z]+:|//")
# The page for addresses that do not exist has links from the root of the server.
NOT_FOUND = "404.html"


@cache
def anchors(page):
    return set(map(unescape, ANCHOR.findall(page.read_text(encoding="utf-8", errors="replace"))))


def broken(folder):
    """Page and link of each link that leads nowhere."""
    for page in sorted(folder.rglob("*.html")):
        if page == folder / NOT_FOUND:
            continue
        links = LINK.findall(page.read_text(encoding="utf-8", errors="replace"))
        for link in dict.fromkeys(map(unescape, links)):
            if not ELSEWHERE.match(link) and not is_there(page, link):
                yield page.relative_to(folder), link


def is_there(page, link):
    path, _, anchor = link.partition("#")
    path = unquote(path.partition("?")[0])
    target = (page.parent / path).resolve() if path else page
    if target.is_dir():
        target /= "index.html"
    if not target.is_file():
        return False
    return not anchor or target.suffix != ".html" or bool(
        {anchor, unquote(anchor)} & anchors(target))


if __name__ == "__main__":
    found = list(broken(Path(sys.argv[1]).resolve()))
    for page, link in found:
        print(f"{page}: {link} leads nowhere", file=sys.stderr)
    sys.exit(bool(found))
