!> Reads a scene, solves it, and prints every position's load, contacts and area.
!>
!>     fpm run --example read_a_scene -- data/examples/thesis.scene
program read_a_scene
  use, intrinsic :: iso_fortran_env, only: error_unit
  use asperity, only: last_state, problem_list, read_scene, scene, scene_results, solve, state_row
  implicit none
  type(scene) :: thesis
  type(scene_results) :: results
  type(problem_list) :: problems
  type(state_row) :: last
  character(len=:), allocatable :: failure
  character(len=1000) :: file
  integer :: m

  file = 'data/examples/thesis.scene'
  if (command_argument_count() > 0) call get_command_argument(1, file)
  call read_scene(trim(file), thesis, problems)
  if (problems%count() > 0) then
    write (error_unit, '(a)', advance='no') problems%text()
    stop 2
  end if

  call solve(thesis, results, failure)
  if (allocated(failure)) then
    write (error_unit, '(a)') failure
    stop 1
  end if

  print '(a)', 'position  contacts           load           area'
  do m = 1, size(results%positions)
    last = last_state(results%positions(m))
    print '(i8, i10, 2es15.6)', m, last%contacts, last%load, last%area
  end do
end program read_a_scene
