"""Fortran programs that use the library: loops, threads, wrong order of calls; installed files."""

import re

import pytest
from builds import ROOT
from programs import run_program

USES = """program user
  use, intrinsic :: iso_fortran_env, only: real64
  use asperity
  implicit none
"""
LOADS = USES + """  type(height_map) :: map
  type(scene_side) :: sides(2)
  type(scene) :: one
  type(scene_results) :: results
  type(problem_list) :: problems
  character(len=:), allocatable :: failure
  character(len=120) :: text
  real(real64) :: h(32, 32)
  integer :: i, j
  h = reshape([((-((i - 16.5_real64)**2 + (j - 16.5_real64)**2) / 800, i=1, 32), j=1, 32)], &
              [32, 32])
  call take_map('lower', h, [0.5_real64, 0.5_real64], 'um', 1, map, problems, failure)
  allocate (sides(2)%map, source=map)
  do i = 1, 3
    write (text, '(a, i0, a)') '&surfaces upper=''plane'' / &material contact_modulus=1e5 / ' // &
      '&loading control=''load'', value=', 1000 * i, ' /'
    call build_scene_of(sides, text, one, problems)
    if (problems%count() > 0) error stop problems%text()
    call solve(one, results, failure)
    if (allocated(failure)) error stop failure
    print '(es24.16)', results%positions(1)%states(1)%load
  end do
end program user
"""
WRONG = USES + """  type(scene_surface) :: ball
  type(scene) :: never, wrong
  type(scene_results) :: results
  type(array_table) :: table
  type(problem_list) :: problems
  character(len=:), allocatable :: failure
  call solve(never, results, failure)
  print '(a)', failure
  call make_arrays(of_states, results, table, failure)
  print '(a)', failure
  print '(i0)', place_of(table, 'load')
  call take_surface('upper', [0.0_real64], [0.0_real64], [0.1_real64], [1.0_real64], ball, problems)
  call build_scene(ball, plane_surface(), '&loading control=''nothing'' /', wrong, problems)
  print '(l1)', problems%count() > 0
  call solve(wrong, results, failure)
  print '(a)', failure
  call problems%clear()
  call build_scene(ball, plane_surface(), '&material contact_modulus=1e5 / ' // &
                   '&loading control=''load'', value=1 /', wrong, problems)
  print '(a)', problems%text() // 'built'
  call solve(wrong, results, failure)
  call make_arrays(of_states, results, table, failure)
  print '(f4.1)', table%columns(place_of(table, 'load'))%reals(1)
  print '(i0)', place_of(table, 'no column')
end program user
"""
THREADS = USES + """  integer :: i, refused
  refused = 0
  !$omp parallel do schedule(dynamic) num_threads(8) reduction(+: refused)
  do i = 1, 12000
    refused = refused + build(i)
  end do
  print '(i0)', refused
contains
  integer function build(k)
    integer, intent(in) :: k
    type(scene_surface) :: caps
    type(scene) :: one
    type(problem_list) :: problems
    character(len=200) :: groups
    call take_surface('upper', [0.0_real64, 0.5_real64], [0.0_real64, 0.0_real64], &
                      [0.01_real64, 0.01_real64], [2.0_real64], caps, problems)
    write (groups, '(a, i0, a)') '&material contact_modulus=1e5 / &loading control=''load'', ' // &
      'value=', 1 + modulo(k, 50), ' / &effects interaction=''coupled'' /'
    call build_scene(caps, plane_surface(), trim(groups), one, problems)
    build = merge(1, 0, problems%count() > 0)
  end function build
end program user
"""


def printed(fortran, folder, text, *flags):
    source = folder / "user.f90"
    source.write_text(text)
    return run_program(fortran(source, *flags),
                       variables={"OMP_WAIT_POLICY": "passive"}).stdout.splitlines()


def test_loop_over_loads(fortran, tmp_path):
    """Scenes of one `sides`: each has the heights."""
    loads = [float(line) for line in printed(fortran, tmp_path, LOADS)]
    assert loads == pytest.approx([1000.0, 2000.0, 3000.0], rel=1e-6)


def test_wrong_order_of_calls(fortran, tmp_path):
    """Scenes that were never built, or with problems, and results of failed solves are failures in
    words. A list of problems can be emptied."""
    unbuilt = "the scene was not read or built without problems"
    assert printed(fortran, tmp_path, WRONG) == [
        unbuilt, "no results: the scene is not solved", "0", "T", unbuilt, "built", " 1.0", "0"]


def test_builds_in_threads(fortran, tmp_path):
    """Right scenes that eight threads build at once are all built. Without turns a run refuses some
    with a probability above 99 % (55 of 20,000 were refused)."""
    assert printed(fortran, tmp_path, THREADS, "-fopenmp") == ["0"]


def test_installed(installed, tmp_path):
    """Program, header and library as the file for pkg-config has them, completion, manual page."""
    names = {path.relative_to(installed).as_posix() for path in installed.rglob("*")}
    assert {"bin/asperity", "lib/libasperity.a", "lib/libasperity.so.1", "include/asperity.h",
            "include/asperity.mod", "share/man/man1/asperity.1",
            "share/bash-completion/completions/asperity"} <= names
    text = (installed / "lib/pkgconfig/asperity.pc").read_text(encoding="utf-8")
    text = text.replace("${pcfiledir}", str(installed / "lib/pkgconfig"))
    found = re.findall(r"^(?:Libs|Cflags): (.*)$", text, re.M)
    assert "${" not in text and len(found) == 2
    found = " ".join(found).split()
    run_program("gcc", ROOT / "example/press_two_surfaces.c", "-o", tmp_path / "press", *found)
    listed = run_program("objdump", "-p", installed / "lib/libasperity.so.1").stdout
    assert "SONAME               libasperity.so.1" in listed
    run_program(tmp_path / "press", ROOT / "data/examples/one_pair.scene",
                variables={"LD_LIBRARY_PATH": str(installed / "lib")})
