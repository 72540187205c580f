!> Finds the summits of a measured map and compares them with theory.
!>
!>     fpm run --example summits_of_a_map -- data/examples/summits/smooth.sdf
program summits_of_a_map
  use, intrinsic :: iso_fortran_env, only: error_unit, real64
  use asperity, only: find_summits, height_map, level_map, level_plane, map_statistics, &
                      map_summits, measure_map, problem_list, radius_neighbours, read_height_map, &
                      rule_eight
  implicit none
  type(height_map) :: map
  type(map_summits) :: summits
  type(map_statistics) :: found
  type(problem_list) :: problems
  character(len=:), allocatable :: failure
  character(len=1000) :: file
  real(real64), parameter :: own_spacing(2) = 0.0_real64

  file = 'data/examples/summits/smooth.sdf'
  if (command_argument_count() > 0) call get_command_argument(1, file)
  call read_height_map(trim(file), own_spacing, .false., map, problems, failure)
  if (problems%count() > 0) then
    write (error_unit, '(a)', advance='no') problems%text()
    stop 2
  end if
  if (.not. allocated(failure)) then
    call level_map(map, level_plane)
    call find_summits(map, rule_eight, radius_neighbours, summits, failure)
  end if
  if (allocated(failure)) then
    write (error_unit, '(a)') failure
    stop 1
  end if

  call measure_map(map, summits, found)
  print '(i0, a)', size(summits%x), ' summits'
  print '(a, 2es14.6)', 'density          ', found%density, found%expected_density
  print '(a, 2es14.6)', 'mean height      ', found%mean_height, found%expected_height
  print '(a, 2es14.6)', 'mean curvature   ', found%mean_curvature, found%expected_curvature
end program summits_of_a_map
