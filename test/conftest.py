"""What all tests of the harness share: the executable, the root folder, the cells of the thesis.

Tests run side by side (pytest-xdist), in any order: each writes in its own `tmp_path` alone.
"""

import fcntl
import importlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

# Tests import what they share across folders (.ci/setup gives these to scripts, too).
sys.path[:0] = [str(path) for path in Path(__file__).resolve().parent.iterdir() if path.is_dir()]

from absent import stand_in  # noqa: E402
from builds import ROOT, build  # noqa: E402

stand_in()

os.environ.setdefault("MPLBACKEND", "Agg")
# Tests run side by side: threads of numpy would spin for cores that they do not get.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Tests that share what takes long to make: all of such a file run in one process.
TOGETHER = ("test_accuracy.py", "test_effects.py", "test_python.py", "test_python_arguments.py",
            "test_python_copies.py", "test_c_arguments.py", "test_map_arrays.py")


# Kinds of tests beside `fast`, which `make test` leaves to `make test-all`, and other marks.
KINDS = ("truth", "pages", "fuzz", "long")
MARKS = ("fast: what `make test` runs: all tests of no other kind",
         "truth: many positions, pixels or contacts against an independent evaluation",
         "pages: blocks, tables and links of the pages, and the site",
         "fuzz: random decks, scenes and maps", "long: the statements of shorter tests, more often",
         "once: in the release build alone: depends on no build, or a sibling runs in the others",
         "trouble: runs in these builds although it is not fast")


# Cases of a test that a build runs, by the option --cases.
CASES = {"first": (0,), "last": (-1,), "ends": (0, -1)}


class Tally:
    """Counts of printed cells, table by table."""

    def __init__(self):
        self.rows = {}

    def add(self, name, compared, met, illegible=0):
        """Add the cells of one table: compared, met among these, and illegible beside these."""
        if not 0 <= met <= compared or illegible < 0:
            raise ValueError(f"{name}: compared {compared}, met {met}, illegible {illegible}")
        old = self.rows.get(name, (0, 0, 0))
        self.rows[name] = tuple(int(a + b) for a, b in zip(old, (compared, met, illegible)))

    def lines(self):
        """The table, one line a name, and the totals in the last line."""
        width = max(map(len, self.rows))
        yield f"{'cells':<{width}} {'compared':>9} {'met':>9} {'illegible':>9}"
        for name, counts in sorted(self.rows.items()):
            yield f"{name:<{width}} " + " ".join(f"{count:>9}" for count in counts)
        compared, met, illegible = map(sum, zip(*self.rows.values()))
        yield f"cells compared {compared}, met {met}, illegible {illegible}"


TALLY = pytest.StashKey[Tally]()


def pytest_configure(config):
    config.stash[TALLY] = Tally()
    for line in MARKS:
        config.addinivalue_line("markers", line)


def pytest_addoption(parser):
    parser.addoption("--cases", choices=CASES,
                     help="of the cases of a test the first, the last or both alone")


@pytest.hookimpl(wrapper=True)
def pytest_collection_modifyitems(config, items):
    """A test without a kind is `fast`; pages do not depend on the build. `--cases` comes last."""
    for item in items:
        marks = {mark.name for mark in item.iter_markers()}
        if marks.isdisjoint(KINDS):
            item.add_marker(pytest.mark.fast)
        if "pages" in marks:
            item.add_marker(pytest.mark.once)
    result = yield
    if config.getoption("cases"):
        cases = {}
        for item in items:
            cases.setdefault(item.nodeid.partition("[")[0], []).append(item)
        kept = {of_test[i] for of_test in cases.values() for i in CASES[config.getoption("cases")]}
        config.hook.pytest_deselected(items=[item for item in items if item not in kept])
        items[:] = [item for item in items if item in kept]
    return result


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """One test after the other to the process that is free; the files of TOGETHER come first."""
    from xdist.scheduler import LoadScopeScheduling

    class Scheduler(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            file = nodeid.partition("::")[0]
            return file if file.endswith(TOGETHER) else nodeid

    return Scheduler(config, log)


def pytest_sessionfinish(session):
    """A process that runs a share of the tests hands its cells on."""
    output = getattr(session.config, "workeroutput", None)
    if output is not None:
        output["cells"] = session.config.stash[TALLY].rows


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node):
    """One of these processes has ended: its cells count with the others."""
    for name, counts in getattr(node, "workeroutput", {}).get("cells", {}).items():
        node.config.stash[TALLY].add(name, *counts)


@pytest.fixture(scope="session")
def root():
    """The root folder of the project."""
    return ROOT


@pytest.fixture(autouse=True)
def closed_figures():
    """Figures of matplotlib are closed after the test that has drawn them."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


@pytest.fixture
def checkout(tmp_path):
    """A folder that looks like the root to what only reads."""
    for path in ROOT.iterdir():
        if not path.name.startswith(".") and path.name != "build":
            (tmp_path / path.name).symlink_to(path)
    return tmp_path


@pytest.fixture(scope="session")
def tally(request):
    """Where the report of the thesis counts its cells; printed at the end of the run."""
    return request.config.stash[TALLY]


@pytest.fixture(scope="session")
def asperity():
    """The executable: ASPERITY_EXE if that is set, else the release build."""
    given = os.environ.get("ASPERITY_EXE")
    path = Path(given).resolve() if given else build("release")
    if not os.access(path, os.X_OK):
        pytest.fail(f"no executable at {path}")
    return path


def shared(factory, name, commands):
    """A folder that one process of a run fills for all of them, by commands on the folder, which
    find the programs of .venv. Usage: `commands(folder)`."""
    base = factory.getbasetemp()
    base = base.parent if os.environ.get("PYTEST_XDIST_WORKER") else base
    folder, mark = base / name, base / f"{name}.done"
    with open(base / f"{name}.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not mark.exists():
            build("release")
            path = os.pathsep.join((str(ROOT / ".venv" / "bin"), os.environ["PATH"]))
            for command in commands(folder):
                done = subprocess.run(command, cwd=ROOT, env={**os.environ, "PATH": path},
                                      stdin=subprocess.DEVNULL, capture_output=True, text=True,
                                      timeout=500)
                assert done.returncode == 0, done.stdout + done.stderr
            mark.touch()
    return folder


@pytest.fixture(scope="session")
def venv(tmp_path_factory):
    """A fresh venv with the package and nothing else: pip install ./python, without a network."""
    if os.environ.get("ASPERITY_PACKAGE"):
        pytest.skip("ASPERITY_PACKAGE is in no environment of its own")
    return shared(tmp_path_factory, "venv", lambda folder: (
        [sys.executable, "-m", "venv", "--without-pip", folder],
        [sys.executable, "-m", "pip", "--python", folder / "bin" / "python", "install", "-q",
         "--no-index", "--disable-pip-version-check", "./python"]))


@pytest.fixture(scope="session")
def installed(tmp_path_factory):
    """A prefix with all that `make install` puts there, of one build whatever others build."""
    return shared(tmp_path_factory, "prefix", lambda folder: (
        [sys.executable, "python/build_backend.py", folder],))


@pytest.fixture(scope="session")
def fortran(installed):
    """Builds a Fortran program that uses the library; its path."""
    def make(source, *flags):
        program = source.with_suffix("")
        done = subprocess.run(
            ["gfortran", *flags, source, "-o", program, "-I", installed / "include", "-J",
             source.parent, installed / "lib/libasperity.a", "-lgomp", "-lquadmath", "-lfftw3"],
            capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
        return program
    return make


@pytest.fixture(scope="session")
def package_folder(request):
    """The folder with the package: ASPERITY_PACKAGE if that is set, else one freshly installed."""
    given = os.environ.get("ASPERITY_PACKAGE")
    if given:
        return Path(given).resolve()
    return next(request.getfixturevalue("venv").glob("lib/python*/site-packages"))


@pytest.fixture(scope="session")
def package(package_folder):
    """The package in this process, which has numpy."""
    folder = str(package_folder)
    sys.path.insert(0, folder)
    try:
        yield importlib.import_module("asperity")
    finally:
        sys.path.remove(folder)


def pytest_terminal_summary(terminalreporter, config):
    counts = config.stash[TALLY]
    if counts.rows:
        terminalreporter.section("printed cells")
        for line in counts.lines():
            terminalreporter.write_line(line)
    write_outcome(terminalreporter)


def write_outcome(terminalreporter):
    """Leave 'N passed, M failed' for the script that adds it to the unit tests."""
    path = os.environ.get("ASPERITY_TALLY")
    if path:
        passed, failed, errors = (
            len(terminalreporter.stats.get(key, [])) for key in ("passed", "failed", "error")
        )
        Path(path).write_text(f"{passed} passed, {failed + errors} failed\n", encoding="ascii")
