"""The blocks of C and Fortran of the pages: each is a part of a program that is built and run."""

import re

import pytest
from builds import ROOT
from programs import run_program

pytestmark = pytest.mark.pages

# What stands before the blocks of a page, in their order.
C_BEFORE = (
    "",
    "asperity_outcome *scene = asperity_read_scene(\"data/examples/one_pair.scene\");\n",
    "")
C_AFTER = (
    "", "if (asperity_status(next) != ASPERITY_DONE || progress[0] < 1) return 2;\n",
    "if (asperity_status(fields) != ASPERITY_DONE || !(pressure[0] >= 0)) return 3;\n")
SUMMITS = """real(real64) :: x(2) = [0.0, 0.5], y(2) = 0.0, height(2) = 0.1, radius(1) = 1.0
type(scene_surface) :: upper, lower
type(scene) :: pressed
type(problem_list) :: problems
"""
MAP = """real(real64) :: heights(8, 8)
type(height_map) :: map
type(scene_side) :: sides(2)
type(scene) :: pressed
type(problem_list) :: problems
character(len=:), allocatable :: failure
heights = 0.0
heights(4, 4) = 0.1
"""
FOUND = """type(height_map) :: map
type(map_summits) :: summits
type(scene_surface) :: upper
type(problem_list) :: problems
character(len=:), allocatable :: failure
"""
ORIGINAL = """type(card_deck) :: deck
type(original_request) :: request
type(original_records) :: records
type(text_buffer) :: report
type(problem_list) :: problems
character(len=:), allocatable :: failure
"""
# A ball on a flat: at a depth the stress along z is less than the greatest pressure.
STRESSED = """real(real64) :: heights(8, 8)
type(height_map) :: map
type(scene_side) :: sides(2)
type(scene) :: pressed
type(scene_results) :: results
type(run_options) :: options
type(problem_list) :: problems
real(real64), allocatable :: stress(:, :, :)
character(len=:), allocatable :: failure
integer :: i, j
heights = reshape([((-((i - 4.5)**2 + (j - 4.5)**2) * 0.01_real64, i=1, 8), j=1, 8)], [8, 8])
call take_map('lower', heights, [0.5_real64, 0.5_real64], 'um', 1, map, problems, failure)
allocate (sides(2)%map, source=map)
call build_scene_of(sides, '&surfaces upper = ''plane'' / &material elastic_modulus = 2*1e3, ' // &
  'poisson_ratio = 2*0.3 / &loading control = ''load'', value = 20. /', pressed, problems)
"""
UNDER_BALL = """if (abs(minval(stress(:, :, 3)) / last_greatest() + 0.9) > 0.1) stop 1
contains
real(real64) function last_greatest()
last_greatest = results%positions(1)%states(1)%greatest_pressure
end function
"""
WITH = "use, intrinsic :: iso_fortran_env, only: real64\nuse asperity\nimplicit none\n"
NO_PROBLEM = "if (problems%count() > 0) error stop problems%text()\n"
NO_FAILURE = NO_PROBLEM + "if (allocated(failure)) error stop failure\n"
FORTRAN = (("", ""), (WITH + SUMMITS, NO_PROBLEM), (WITH + MAP, NO_FAILURE),
           (WITH + FOUND, NO_FAILURE),
           (WITH + ORIGINAL, NO_FAILURE + "if (index(report%text(), 'TABLE VI') == 0) stop 1\n"),
           (WITH + STRESSED, NO_FAILURE + UNDER_BALL))
# Tables of the page of Fortran: heading text before each, its type, and components of the type that
# serve the solver alone.
TYPES = {"Options": ("run/run_options", "run_options", ("largest_error",)),
         "## Results": ("results/contact_records", "position_result",
                        ("counted", "rows_used", "lacks_memory", "pressures", "no_estimate",
                         "left_out")),
         "`type(state_row)`": ("results/contact_records", "state_row", ()),
         "`type(contact_row)`": ("results/contact_records", "contact_row", ()),
         "Fields, `type(contact_field)`": ("results/contact_field", "contact_field", ())}


def blocks(page, language):
    text = (ROOT / page).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.M | re.S)


@pytest.fixture(scope="module")
def library(venv):
    return next(venv.glob("lib/python*/site-packages/asperity"))


def run(command, library=""):
    run_program(*command, cwd=ROOT, variables={"LD_LIBRARY_PATH": str(library)})


def test_c(library, tmp_path):
    found = blocks("docs/how-to/c.md", "c")
    source = tmp_path / "page.c"
    source.write_text("#include <stdio.h>\n#include \"asperity.h\"\n" + "".join(
        f"static int part{number}(void)\n{{\n{before}{block}{after}return 0;\n}}\n"
        for number, (before, block, after) in enumerate(zip(C_BEFORE, found, C_AFTER, strict=True)))
        + "int main(void) { return part0() + part1() + part2(); }\n")
    run(["gcc", "-std=c99", "-I", "include", source, "-o", tmp_path / "page", "-L", library,
         "-l:libasperity.so.1"], library)
    run([tmp_path / "page"], library)


def test_fortran(fortran, tmp_path):
    found = blocks("docs/reference/fortran.md", "fortran")
    for number, ((before, after), block) in enumerate(zip(FORTRAN, found, strict=True)):
        source = tmp_path / f"page{number}.f90"
        source.write_text(f"program page\n{before}{block}{after}end program\n")
        run([fortran(source)])


def components(file, name):
    """Names of the components of a type, from its source."""
    text = (ROOT / f"src/{file}.f90").read_text(encoding="utf-8")
    body = re.search(rf"^  type :: {name}\n(.*?)^  (?:contains|end type)", text, re.M | re.S)[1]
    lines = re.sub(r"!.*|&\n|\((?:[^()]|\([^()]*\))*\)", "", body).splitlines()
    return [word.split("=")[0].strip() for line in lines if "::" in line
            for word in line.partition("::")[2].split(",")]


@pytest.mark.parametrize("before", TYPES)
def test_tables_of_fortran(before):
    """A table has all components of its type, and no other name."""
    file, name, internal = TYPES[before]
    page = (ROOT / "docs/reference/fortran.md").read_text(encoding="utf-8").partition(before)[2]
    table = page[page.index("| component |"):].partition("\n\n")[0]
    cells = re.findall(r"^\| (`.*?`) \|", table, re.M)
    named = [word for cell in cells for word in re.findall(r"`(\w+)", cell)]
    assert sorted(named) == sorted(set(components(file, name)) - set(internal))
