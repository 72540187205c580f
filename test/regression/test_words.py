"""The lint for words: it refuses every sentence of a list, in a page and in a message."""

import sys

import pytest
from builds import ROOT
from programs import run_program

pytestmark = pytest.mark.once

LINT = ROOT / ".ci/words.py"
# Sentences of earlier versions that readers did not understand.
REFUSED = (ROOT / "test/regression/refused_sentences.txt").read_text(encoding="utf-8").splitlines()


def lint(*files):
    return run_program(sys.executable, LINT, *files, status=None)


def test_the_project_passes():
    done = lint()
    assert done.returncode == 0, done.stdout


def test_sentences_in_a_page(tmp_path):
    assert len(REFUSED) >= 80
    for name in ("README.md", "CHANGELOG.md", "docs/page.md"):
        for number, sentence in enumerate(REFUSED):
            page = tmp_path / f"{number}" / name
            page.parent.mkdir(parents=True, exist_ok=True)
            page.write_text(f"# Title\n\n- {sentence}\n")
    found = lint(*sorted(tmp_path.glob("*/**/*.md"))).stdout
    for number, sentence in enumerate(REFUSED):
        for name in ("README.md", "CHANGELOG.md", "docs/page.md"):
            assert f"{tmp_path}/{number}/{name}:3: " in found, sentence


def test_sentences_in_a_message(tmp_path):
    """Also when the sentence is broken over two lines of source."""
    for number, sentence in enumerate(REFUSED):
        words = sentence.replace("'", "''").split(" ")
        half = len(words) // 2
        (tmp_path / f"m{number}.f90").write_text(
            f"call say('{' '.join(words[:half])} ' // &\n  '{' '.join(words[half:])}')\n")
    found = lint(*sorted(tmp_path.glob("*.f90"))).stdout
    for number, sentence in enumerate(REFUSED):
        assert f"{tmp_path}/m{number}.f90:1: " in found, sentence


def test_all_pages_are_read():
    """Without names the lint reads every page of docs: one more sentence in any is a finding."""
    code = "import words; print(*words.all_files(), sep='\\n')"
    done = run_program(sys.executable, "-c", code, cwd=LINT.parent)
    pages = {str(page) for page in (*ROOT.glob("docs/**/*.md"), ROOT / "CONTRIBUTING.md")}
    assert len(pages) > 30 and pages <= set(done.stdout.split())


@pytest.mark.parametrize("name, line, reason", [
    ("README.md", "word " * 31 + "end.", "sentence longer than 30 words"),
    ("CHANGELOG.md", "- " + "letters " * 21, "entry longer than 160"),
    ("page.md", "- word " + "letters " * 26, "line longer than 200"),
    ("page.md", "| word | " + "letters " * 16 + "| " + "letters " * 31 + "|",
     "longer than 30 words"),
    ("page.md", "## How it works", "a heading is a noun phrase"),
    ("page.md", "### Is it exact?", "a heading is a noun phrase"),
    ("a.f90", "print *, 'the closing of the surfaces'", "compression"),
    ("a.py", "x = 'nobody is here'", "contacts and programs are things")])
def test_each_kind(tmp_path, name, line, reason):
    (tmp_path / name).write_text(line + "\n")
    done = lint(tmp_path / name)
    assert done.returncode == 1 and reason in done.stdout


@pytest.mark.parametrize("name, text", [
    ("a.f90", "x = 1  ! Whoever is near\n"), ("a.inc", "real :: told\n"),
    ("a.py", "# it tells\n"), ("a.html", "<p>nobody</p>\n"), ("a.h", "/* foretold */\n"),
    ("README.md", "```\npress less\n```\n")])
def test_words_refused_in_comments_and_code(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    done = lint(tmp_path / name)
    assert done.returncode == 1 and "things are no persons" in done.stdout


def test_what_is_allowed(tmp_path):
    """Names of columns, comments, code and addresses are no sentences."""
    (tmp_path / "a.f90").write_text("call put('closing')  ! somebody\n! who waits\n")
    (tmp_path / "README.md").write_text(
        "# Title\n\n```\nwho waits\n```\n\n[text](who-waits.md)\n\n    p = who waits\n\n"
        "| " + "a | " * 60 + "\n")
    done = lint(tmp_path / "a.f90", tmp_path / "README.md")
    assert (done.returncode, done.stdout) == (0, "")
