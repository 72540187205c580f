!> The totals of a scene or deck by exact events, with the stable or the original overlap.
!>
!>     overlap_totals SCENE stable|original
!>
!> prints a line a position: load, vertical load, area, projected area.
program overlap_totals
  use, intrinsic :: iso_fortran_env, only: error_unit
  use asperity_contact_records, only: overlap_original, overlap_stable, solve_method, state_row
  use asperity_problems, only: problem_list
  use asperity_run_options, only: run_options
  use asperity_scene_reader, only: read_scene
  use asperity_scene_results, only: last_state, scene_results
  use asperity_scene_values, only: scene
  use asperity_model_solve, only: solve_effects
  implicit none

  character(len=4096) :: words(2)
  character(len=:), allocatable :: failure
  type(scene) :: checked
  type(problem_list) :: problems
  type(scene_results) :: results
  type(run_options) :: options
  type(solve_method) :: method
  type(state_row) :: last
  integer :: i, m

  do i = 1, size(words)
    call get_command_argument(i, words(i))
  end do
  call read_scene(trim(words(1)), checked, problems)
  if (problems%count() > 0) then
    write (error_unit, '(a)', advance='no') problems%text()
    error stop
  end if
  options%threads = 1
  method%overlap = merge(overlap_original, overlap_stable, words(2) == 'original')
  call solve_effects(checked, options, results, failure, method)
  if (allocated(failure)) then
    write (error_unit, '(a)') failure
    error stop
  end if
  do m = 1, size(results%positions)
    last = last_state(results%positions(m))
    print '(4es25.16e3)', last%load, last%vertical_load, last%area, last%projected_area
  end do
end program overlap_totals
