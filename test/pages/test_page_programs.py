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
WITH = "use, intrinsic :: iso_fortran_env, only: real64\nuse asperity\nimplicit none\n"
NO_PROBLEM = "if (problems%count() > 0) error stop problems%text()\n"
NO_FAILURE = NO_PROBLEM + "if (allocated(failure)) error stop failure\n"
FORTRAN = (("", ""), (WITH + SUMMITS, NO_PROBLEM), (WITH + MAP, NO_FAILURE),
           (WITH + FOUND, NO_FAILURE),
           (WITH + ORIGINAL, NO_FAILURE + "if (index(report%text(), 'TABLE VI') == 0) stop 1\n"))


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


def test_fortran(tmp_path):
    # Modules and archive of one build, whatever other tests build meanwhile.
    run(["bash", "-ec", '. .ci/common.sh; options_of release; mkdir -p build; '
         'flock build/lock fpm install "${fpm_options[@]}" --prefix "$0"', tmp_path])
    found = blocks("docs/reference/fortran.md", "fortran")
    for number, ((before, after), block) in enumerate(zip(FORTRAN, found, strict=True)):
        source = tmp_path / f"page{number}.f90"
        source.write_text(f"program page\n{before}{block}{after}end program\n")
        run(["gfortran", source, "-o", tmp_path / f"page{number}", "-I", tmp_path / "include",
             "-J", tmp_path, tmp_path / "lib/libasperity.a", "-lgomp", "-lquadmath", "-lfftw3"])
        run([tmp_path / f"page{number}"])
