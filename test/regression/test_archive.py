"""The archived output, and the promise that makes it safe to diff.

The archives belong to the build of `make archive`, which forbids what may change a last bit of IEEE
arithmetic. `ibm370` is integer work and has the same bytes under every flag. Nothing here writes an
archive.
"""

import difflib
import shutil
import subprocess

import pytest

REPORTS = ("ibm370", "real32", "real64", "real128")
CONTACTS = ("ibm370", "real64")
# Two ends of what a compiler may do: nothing, and more than the standard allows.
FLAGS = ("-O0", "-O3 -march=native -ffast-math")


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


def last_line(command, root):
    """Runs a build; its last line is the executable's path."""
    done = subprocess.run(command, cwd=root, stdin=subprocess.DEVNULL, capture_output=True,
                          text=True, timeout=600)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return root / done.stdout.splitlines()[-1].strip()


@pytest.fixture(scope="module")
def archive_build(root):
    """The executable as `make archive` builds it.

    .ci/build throws all builds away when an included text has changed, which fpm does not see: it
    comes before every other build here.
    """
    return last_line(["bash", ".ci/build", "archive"], root)


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


@pytest.mark.usefixtures("archive_build")
def test_ibm370_is_the_same_under_all_flags(root, tmp_path):
    """Unoptimised, and with every liberty a compiler can be given: the same bytes."""
    local = root / ".venv" / "bin" / "fpm"
    fpm = local if local.exists() else shutil.which("fpm")
    if fpm is None:
        pytest.fail("fpm not found: run make setup")
    results, executables = [], []
    for number, flags in enumerate(FLAGS):
        folder = tmp_path / str(number)
        folder.mkdir()
        executables.append(last_line([fpm, "run", "asperity", "--flag", flags, "--runner", "echo"],
                                     root))
        results.append(run(executables[-1], root, "ibm370", folder))
    assert executables[0].read_bytes() != executables[1].read_bytes(), "one build, run twice"
    same_text(results[1][0], results[0][0], "report under " + FLAGS[1])
    same_text(results[1][1], results[0][1], "contacts under " + FLAGS[1])
    for (report, contacts), flags in zip(results, FLAGS):
        same_text(report, archived(root, "thesis.ibm370.txt"), "report under " + flags)
        same_text(contacts, archived(root, "thesis.ibm370.contacts.csv"), "contacts under " + flags)
