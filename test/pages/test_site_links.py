"""The pages of the site, and the check of its links (.ci/site_links.py)."""

import re
import sys

import pytest
from builds import ROOT
from programs import run_program

pytestmark = [pytest.mark.pages, pytest.mark.once]


@pytest.mark.parametrize("link, is_broken", [
    ("b/#there", False), ("b/index.html#there", False), ("b/", False), ("#here", False),
    ("https://none.example/x#y", False), ("b/a%2Bb.html", False), ("a.txt#line", False),
    ("b/#elsewhere", True), ("c/", True), ("#there", True), ("b/none.html", True),
])
def test_links(tmp_path, link, is_broken):
    (tmp_path / "b").mkdir()
    (tmp_path / "a.txt").write_text("text")
    (tmp_path / "b/a+b.html").write_text("")
    (tmp_path / "b/index.html").write_text('<h1 id="there">B</h1><a href="..#here">A</a>')
    (tmp_path / "index.html").write_text(f'<p id=here><a class="x" href="{link}">link</a>')
    done = run_program(sys.executable, ROOT / ".ci/site_links.py", tmp_path, status=None)
    assert done.returncode == is_broken
    assert done.stderr == (f"index.html: {link} leads nowhere\n" if is_broken else "")


def test_the_pages_become_a_site():
    """Without a warning: a broken link or anchor, a page that no menu has, a name without text."""
    done = run_program("bash", ROOT / ".ci/site", "--pages", status=None)
    if re.search("No matching distribution|Connection", done.stderr):
        pytest.skip("mkdocs cannot be installed here")
    assert not done.returncode, done.stderr
