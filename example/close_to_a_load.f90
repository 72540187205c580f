!> Builds two surfaces in memory, closes them to a load with neighbouring contacts taken together,
!> and prints the contacts.
!>
!>     fpm run --example close_to_a_load
program close_to_a_load
  use, intrinsic :: iso_fortran_env, only: error_unit, real64
  use asperity, only: build_scene, contact_row, last_state, problem_list, run_options, scene, &
                      scene_results, scene_surface, solve, state_row, take_surface
  implicit none
  ! Lengths in mm, forces in N, moduli in N/mm2.
  character(len=*), parameter :: groups = &
    '&material elastic_modulus = 210000., 70000., poisson_ratio = 0.3, 0.33 / ' // &
    '&loading  control = ''load'', value = 25. / ' // &
    '&effects  interaction = ''coupled'' /'
  type(scene_surface) :: ball, bumps
  type(scene) :: pressed
  type(scene_results) :: results
  type(problem_list) :: problems
  type(state_row) :: state
  type(contact_row) :: row
  character(len=:), allocatable :: failure
  integer :: i

  ! A ball of radius 10 mm, whose summit is at (0.1, 0.1), on nine bumps 0.2 mm apart.
  call take_surface('upper', [0.1_real64], [0.1_real64], [0.01_real64], [10.0_real64], ball, &
                    problems)
  call take_surface('lower', 0.2_real64 * [0, 1, 2, 0, 1, 2, 0, 1, 2], &
                    0.2_real64 * [0, 0, 0, 1, 1, 1, 2, 2, 2], &
                    [(0.005_real64 + 0.0002_real64 * modulo(5 * i, 9), i=0, 8)], [2.0_real64], &
                    bumps, problems)
  call build_scene(ball, bumps, groups, pressed, problems)
  if (problems%count() > 0) then
    write (error_unit, '(a)', advance='no') problems%text()
    stop 2
  end if

  call solve(pressed, results, failure, run_options(threads=1))
  if (allocated(failure)) then
    write (error_unit, '(a)') failure
    stop 1
  end if

  state = last_state(results%positions(1))
  print '(a, f8.4, a, f9.6, a)', 'load', state%load, ' N at a separation of', state%approach, ' mm'
  print '(a)', 'upper lower       x       y    load, N  greatest pressure, N/mm2'
  do i = state%first_row, state%last_row
    row = results%positions(1)%rows(i)
    print '(2i6, 2f8.4, f11.6, f12.2)', row%upper, row%lower, row%x, row%y, row%load, &
      row%maximum_pressure
  end do
end program close_to_a_load
