"""The archived output, and the promise that makes it safe to diff.

The archives belong to the build of `make archive`, which forbids what may change a last bit of IEEE
arithmetic. `ibm370` is integer work and has the same bytes under every flag. Nothing here writes an
archive.
"""

import difflib
import subprocess

import pytest
from builds import build

REPORTS = ("ibm370", "real32", "real64", "real128")
CONTACTS = ("ibm370", "real64")
# Two ends of what a compiler may do: look for faults alone, and more than the standard allows.
ENDS = ("strict", "fast")
# Builds of its own: nothing here is about the build under test.
pytestmark = pytest.mark.once


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
    done = subprocess.run([executable, root / "data" / "thesis.deck", "--arithmetic", arithmetic,
                           "--contacts", "contacts.csv"],
                          cwd=folder, capture_output=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout, (folder / "contacts.csv").read_bytes()


@pytest.fixture(scope="module")
def archive_build():
    """The executable as `make archive` builds it."""
    return build("archive")


@pytest.fixture(scope="module", params=REPORTS)
def fresh(request, root, archive_build, tmp_path_factory):
    """Arithmetic, report and contacts of a run made now."""
    arithmetic = request.param
    return arithmetic, *run(archive_build, root, arithmetic, tmp_path_factory.mktemp(arithmetic))


def test_report_is_the_archived_one(fresh, root):
    arithmetic, report, _ = fresh
    name = f"thesis.{arithmetic}.txt"
    same_text(report, archived(root, name), name)


def test_contacts_are_the_archived_ones(fresh, root):
    arithmetic, _, contacts = fresh
    name = f"thesis.{arithmetic}.contacts.csv"
    if arithmetic in CONTACTS:
        same_text(contacts, archived(root, name), name)
    else:
        assert not (root / "reference_output" / name).exists(), "an archive that nothing compares"


def test_every_archive_is_compared(root):
    expected = {f"thesis.{a}.txt" for a in REPORTS} | {f"thesis.{a}.contacts.csv" for a in CONTACTS}
    assert {path.name for path in (root / "reference_output").iterdir() if path.is_file()
            and path.name.startswith("thesis.")} == expected


def test_a_missing_archive_fails(root, tmp_path):
    with pytest.raises(pytest.fail.Exception, match="no archive"):
        archived(tmp_path, "thesis.ibm370.txt")
    with pytest.raises(pytest.fail.Exception, match="differs"):
        same_text(b"one\ntwo\n", b"one\n2\n", "a text")


def test_ibm370_is_the_same_under_all_flags(root, tmp_path):
    """Unoptimised, and with every liberty a compiler can be given: the same bytes."""
    for end in ENDS:
        folder = tmp_path / end
        folder.mkdir()
        report, contacts = run(build(end), root, "ibm370", folder)
        same_text(report, archived(root, "thesis.ibm370.txt"), f"report of the build {end}")
        same_text(contacts, archived(root, "thesis.ibm370.contacts.csv"),
                  f"contacts of the build {end}")
