"""What all tests of the harness share: the executable, the root folder, the count of cells."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parents[1]

# The same examples in every run: a failure on one machine is a failure on all.
settings.register_profile("fixed", derandomize=True, deadline=None, database=None)
settings.load_profile("fixed")


class Tally:
    """Counts of printed cells, table by table."""

    def __init__(self):
        self.rows = {}

    def add(self, name, compared, met, illegible=0):
        """Add the cells of one table: compared, met among these, and illegible beside these."""
        if not 0 <= met <= compared or illegible < 0:
            raise ValueError(f"{name}: compared {compared}, met {met}, illegible {illegible}")
        old = self.rows.get(name, (0, 0, 0))
        self.rows[name] = tuple(a + b for a, b in zip(old, (compared, met, illegible)))

    def lines(self):
        """The table, one line a name, and the totals in the last line."""
        width = max(map(len, self.rows))
        yield f"{'cells':<{width}} {'compared':>9} {'met':>9} {'illegible':>9}"
        for name, counts in self.rows.items():
            yield f"{name:<{width}} " + " ".join(f"{count:>9}" for count in counts)
        compared, met, illegible = map(sum, zip(*self.rows.values()))
        yield f"cells compared {compared}, met {met}, illegible {illegible}"


TALLY = pytest.StashKey[Tally]()


def pytest_configure(config):
    config.stash[TALLY] = Tally()


@pytest.fixture(scope="session")
def root():
    """The root folder of the project."""
    return ROOT


@pytest.fixture(scope="session")
def tally(request):
    """Where a test counts the cells it compared; printed at the end of the run."""
    return request.config.stash[TALLY]


@pytest.fixture(scope="session")
def asperity():
    """The executable: ASPERITY_EXE if that is set, else the release build by fpm."""
    given = os.environ.get("ASPERITY_EXE")
    path = Path(given).resolve() if given else release_build()
    if not os.access(path, os.X_OK):
        pytest.fail(f"no executable at {path}")
    return path


def release_build():
    """Build with fpm and ask it for the path, which is the last line it prints."""
    local = ROOT / ".venv" / "bin" / "fpm"
    fpm = local if local.exists() else shutil.which("fpm")
    if fpm is None:
        pytest.fail("fpm not found: run make setup")
    command = [fpm, "run", "asperity", "--profile", "release", "--runner", "echo"]
    done = subprocess.run(
        command, cwd=ROOT, stdin=subprocess.DEVNULL, capture_output=True, text=True
    )
    if done.returncode != 0:
        pytest.fail(f"the release build failed:\n{done.stdout}{done.stderr}")
    return ROOT / done.stdout.splitlines()[-1].strip()


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
