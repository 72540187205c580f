"""`tools/mutate.py`: which changes it draws, and that a change is noticed and undone."""

import importlib.util
import json
import subprocess

import pytest

from builds import ROOT

pytestmark = pytest.mark.once

TEXT = """\
module asperity_sample
  use asperity_kinds, only: real64
  implicit none
  private
  public :: total
  !> Least count, 1 or more: n >= 1 .and. n < 5
  integer, parameter :: least = 1 ! > 0, 2.5
  character(12), parameter :: words(3) = ['a < 1.5', 'b + c', 'min(1)']
  real(real64) :: values(3)
contains
  !> The sum of n + 1 values.
  pure function total(x, n) result(sum_of)
    real(real64), intent(in) :: x(0:n + 1)
    integer, intent(in) :: n
    real(real64) :: sum_of
    write (*, '(a, f8.2)') 'x > 1.5 && it''s + 3', "a - ! 7 &
      &< 2"
100 format (2x, f8.3)
    sum_of = huge(1.0_real64) ! - 3
    if (n > 2 &
        .and. x(1) >= 0.25_real64) then
      sum_of = max(x(n - 1), sum(x(1:n)))
    end if
  end function total
end module asperity_sample
"""

PROJECT = {
    "fpm.toml": """name = "asperity"
[build]
auto-executables = false
auto-tests = false
[[executable]]
name = "asperity"
source-dir = "app"
main = "main.f90"
[[test]]
name = "unit"
source-dir = "test/unit"
main = "main.f90"
""",
    ".gitignore": "build\n",
    "src/doubled.inc": """  !> 2 n
  pure integer function doubled(n)
    integer, intent(in) :: n
    doubled = n + n
  end function doubled
""",
    "src/asperity_small.f90": """module asperity_small
  implicit none
  private
  public :: doubled, unused
contains
  include 'doubled.inc'
  !> n - 7, which no test looks at
  pure integer function unused(n)
    integer, intent(in) :: n
    unused = n - 7
  end function unused
end module asperity_small
""",
    "app/main.f90": """program asperity
  use asperity_small, only: doubled, unused
  implicit none
  print '(i0)', doubled(2)
  if (unused(1) > 100) stop 1
end program asperity
""",
    "test/unit/main.f90": """program unit
  use asperity_small, only: doubled
  implicit none
  if (doubled(3) /= 6) print '(a)', 'FAILED numbers: twice three: found another, expected 6'
  if (doubled(3) /= 6) error stop 1
end program unit
""",
    "test/test_small.py": """import os, subprocess

def test_doubled():
    assert subprocess.check_output(os.environ["ASPERITY_EXE"]) == b"4\\n"
""",
}


@pytest.fixture
def mutate():
    """The tool as a module of its own."""
    spec = importlib.util.spec_from_file_location("mutate_under_test", ROOT / "tools/mutate.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_what_is_changed(mutate):
    """Operators and numbers of statements: each kind once, on the right line, and nothing else."""
    found = {(change["line"], change["kind"], change["after"].strip())
             for change in mutate.candidates(TEXT)}
    assert found == {
        (7, "bound", "integer, parameter :: least = 2 ! > 0, 2.5"),
        (20, "comparison", "if (n >= 2 &"), (20, "comparison", "if (n < 2 &"),
        (20, "bound", "if (n > 3 &"),
        (21, "logical", ".or. x(1) >= 0.25_real64) then"),
        (21, "comparison", ".and. x(1) > 0.25_real64) then"),
        (21, "comparison", ".and. x(1) <= 0.25_real64) then"),
        (21, "bound", ".and. x(2) >= 0.25_real64) then"),
        (21, "constant", ".and. x(1) >= 0.325_real64) then"),
        (22, "extreme", "sum_of = min(x(n - 1), sum(x(1:n)))"),
        (22, "sign", "sum_of = max(x(n + 1), sum(x(1:n)))"),
        (22, "bound", "sum_of = max(x(n - 2), sum(x(1:n)))"),
        (22, "bound", "sum_of = max(x(n - 1), sum(x(2:n)))"),
        (22, "bound", "sum_of = max(x(n - 1), sum(x(1 + 1:n)))"),
        (22, "bound", "sum_of = max(x(n - 1), sum(x(1:n - 1)))"),
    }


def test_a_draw_depends_on_its_seed_alone(mutate, capsys):
    """The same list for the same seed, another for another; folders change from one to the next."""
    lists = []
    for seed in (3, 3, 4):
        mutate.main(["--seed", str(seed), "--number", "25", "--list"])
        lists.append(capsys.readouterr().out)
    assert lists[0] == lists[1] != lists[2]
    folders = [line.split()[1].rpartition("/")[0] for line in lists[0].splitlines()]
    assert len(folders) == 25 and len(set(folders)) >= 14


def test_every_line_of_src_is_read(mutate):
    """No change of src stands in a comment, a string or a preprocessor line."""
    files = mutate.source_files(["src"], [])
    looked_at = 0
    for path in sum(files.values(), []):
        for change in mutate.candidates((ROOT / path).read_text(encoding="utf-8")):
            code = change["before"][:change["column"] - 1]
            looked_at += 1
            assert not code.lstrip().startswith(("!", "#")), (path, change)
            assert code.count("'") % 2 == 0 or code.count('"') % 2 == 1, (path, change)
    assert looked_at > 10000


def test_constants_are_scaled(mutate):
    """Two changes of each constant of the table, on its line, of its own value alone."""
    found = {(one["constant"], one["kind"]): one for one in mutate.scaled_constants()}
    for name, kind, expected in (
            ("element_solver:box_elements", "up", "((24)*13 + 9)/10"),
            ("element_solver:box_elements", "down", "(24)*10/13"),
            ("circle_field:most_iterations", "up",
             "= ((400)*13 + 9)/10, most_inner_iterations = 40"),
            ("circle_field:most_inner_iterations", "down",
             "= 400, most_inner_iterations = (40)*10/13"),
            ("element_solver:lattice_offset", "up", "= ([0.29_real64, 0.13_real64])*13/10")):
        assert expected in found[name, kind]["after"]
    assert len(found) == 2 * len(mutate.named_constants()) > 100
    for one in found.values():
        lines = (ROOT / one["file"]).read_text(encoding="utf-8").split("\n")
        assert lines[one["line"] - 1] == one["before"] != one["after"]


def test_a_mutant_is_found_and_undone(mutate, tmp_path, monkeypatch, capsys):
    """A small project: the tested function's mutants are noticed, the other's survive."""
    for name, text in PROJECT.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    subprocess.run(["git", "init", "-q"], cwd=tmp_path, check=True)
    monkeypatch.setattr(mutate, "ROOT", tmp_path)
    monkeypatch.setattr(mutate, "QUICK", ["test/test_small.py"])
    monkeypatch.setattr(mutate, "QUICK_WITHOUT", [])
    tracked = mutate.tracked_files()

    assert mutate.main(["--number", "1", "--folder", "src/doubled.inc"]) == 0
    out = capsys.readouterr().out
    assert "noticed" in out and "doubled = n - n" in out
    record = json.loads((tmp_path / "build/mutants/seed-1.json").read_text())
    assert [mutant["outcome"] for mutant in record["mutants"]] == ["noticed"]

    # Continued: the first is not run again; those drawn now are in the function without a test.
    assert mutate.main(["--number", "3", "--jobs", "2", "--folder",
                        "src/asperity_small.f90"]) == 1
    record_now = json.loads((tmp_path / "build/mutants/seed-1.json").read_text())
    assert record_now["mutants"][0] == record["mutants"][0]
    assert [mutant["outcome"] for mutant in record_now["mutants"][1:]] == ["survived"] * 2
    mutate.main(["--equivalent", "2", "no caller"])
    mutate.main(["--report", str(tmp_path / "build/page.md")])
    page = (tmp_path / "build/page.md").read_text()
    assert "1 equivalent, 1 noticed, 1 survived" in page and "no caller" in page

    assert mutate.tracked_files() == tracked
    for name, text in PROJECT.items():
        assert (tmp_path / name).read_text(encoding="utf-8") == text
        assert (tmp_path / "build/mutants/copy1/tree" / name).read_text(encoding="utf-8") == text
