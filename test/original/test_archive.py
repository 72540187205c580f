"""The archived output: the build under test prints its bytes. `ibm370` is integer work and has the
same bytes under every flag. Nothing here writes an archive.
"""

import difflib

import pytest
from programs import run_program

REPORTS = ("ibm370", "real32", "real64", "real128")
CONTACTS = ("ibm370", "real64")


def same_text(found, expected, name):
    """Fails with the first lines that differ."""
    if found == expected:
        return
    pairs = difflib.unified_diff(expected.decode("latin-1").splitlines()[:20000],
                                 found.decode("latin-1").splitlines()[:20000],
                                 "expected", "found", lineterm="", n=0)
    some = [line for _, line in zip(range(12), pairs)]
    pytest.fail(f"{name} differs:\n" + "\n".join(some))


def archived(root, name):
    path = root / "reference_output" / name
    if not path.is_file():
        pytest.fail(f"no archive reference_output/{name}: restore it (make archive writes them)")
    return path.read_bytes()


@pytest.mark.parametrize("arithmetic", REPORTS)
def test_archived_output(arithmetic, asperity, root, tmp_path):
    """Report and contacts CSV of the thesis deck."""
    done = run_program(asperity, root / "data" / "thesis.deck", "--arithmetic", arithmetic,
                       "--contacts", "contacts.csv", cwd=tmp_path, text=False)
    name = f"thesis.{arithmetic}.txt"
    same_text(done.stdout, archived(root, name), name)
    if arithmetic in CONTACTS:
        name = f"thesis.{arithmetic}.contacts.csv"
        same_text((tmp_path / "contacts.csv").read_bytes(), archived(root, name), name)


def test_every_archive_is_compared(root):
    expected = {f"thesis.{a}.txt" for a in REPORTS} | {f"thesis.{a}.contacts.csv" for a in CONTACTS}
    assert {path.name for path in (root / "reference_output").iterdir() if path.is_file()
            and path.name.startswith("thesis.")} == expected


def test_a_missing_archive_fails(root, tmp_path):
    with pytest.raises(pytest.fail.Exception, match="no archive"):
        archived(tmp_path, "thesis.ibm370.txt")
    with pytest.raises(pytest.fail.Exception, match="differs"):
        same_text(b"one\ntwo\n", b"one\n2\n", "a text")
