"""The archived output: the build under test prints its bytes, and so does that of `make archive`,
which forbids what may change a last bit of IEEE arithmetic. `ibm370` is integer work and has the
same bytes under every flag. Nothing here writes an archive.
"""

import difflib

import pytest
from builds import build
from programs import run_program

REPORTS = ("ibm370", "real32", "real64", "real128")
CONTACTS = ("ibm370", "real64")
# Two ends of what a compiler may do: look for faults alone, and more than the standard allows.


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


def run(executable, root, arithmetic, folder):
    """Report and contacts CSV of the thesis deck."""
    done = run_program(executable, root / "data" / "thesis.deck", "--arithmetic", arithmetic,
                       "--contacts", "contacts.csv", cwd=folder, text=False)
    return done.stdout, (folder / "contacts.csv").read_bytes()


def prints_the_archive(executable, root, arithmetic, folder):
    report, contacts = run(executable, root, arithmetic, folder)
    name = f"thesis.{arithmetic}.txt"
    same_text(report, archived(root, name), name)
    if arithmetic in CONTACTS:
        name = f"thesis.{arithmetic}.contacts.csv"
        same_text(contacts, archived(root, name), name)


@pytest.mark.parametrize("arithmetic", REPORTS)
def test_archived_output(arithmetic, asperity, root, tmp_path):
    prints_the_archive(asperity, root, arithmetic, tmp_path)


@pytest.mark.long
@pytest.mark.once
def test_archived_output_of_its_own_build(root, tmp_path):
    executable = build("archive")
    for arithmetic in REPORTS:
        prints_the_archive(executable, root, arithmetic, tmp_path)


def test_every_archive_is_compared(root):
    expected = {f"thesis.{a}.txt" for a in REPORTS} | {f"thesis.{a}.contacts.csv" for a in CONTACTS}
    assert {path.name for path in (root / "reference_output").iterdir() if path.is_file()
            and path.name.startswith("thesis.")} == expected


def test_a_missing_archive_fails(root, tmp_path):
    with pytest.raises(pytest.fail.Exception, match="no archive"):
        archived(tmp_path, "thesis.ibm370.txt")
    with pytest.raises(pytest.fail.Exception, match="differs"):
        same_text(b"one\ntwo\n", b"one\n2\n", "a text")


@pytest.mark.long
@pytest.mark.once
def test_ibm370_is_the_same_unoptimised(root, tmp_path):
    report, contacts = run(build("strict"), root, "ibm370", tmp_path)
    same_text(report, archived(root, "thesis.ibm370.txt"), "report")
    same_text(contacts, archived(root, "thesis.ibm370.contacts.csv"), "contacts")
