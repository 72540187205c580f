!> What stands beside the ways of computing a scene: what the digits of the input mean, and what
!> theories in closed form give.
module asperity_way_beside
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_given_digits, only: half_units, perturbed_scene
  use asperity_kinds, only: int64, real64
  use asperity_numeral, only: rounded_decimal
  use asperity_reviewed_theories, only: reviewed_theory, theories_of
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: control_approach, effect_boundary, scene
  use asperity_scene_ways, only: of_arithmetic, of_input, of_theory, run_way, scene_way, &
                                 without_map
  use asperity_timing, only: time_allowance
  use asperity_way_study, only: way_row, way_table
  use asperity_way_totals, only: errors_of, totals_of, way_errors, way_totals
  implicit none
  private

  public :: add_exponent, add_input_error, add_theories

  ! Other inputs with the same digits that are tried: the largest of so many is above the median
  ! with a chance of 15/16.
  integer, parameter :: draws = 4

contains

  !> Adds a row: how far results of contacts each alone move when heights and radii are other
  !> numbers with the same digits; the largest of some draws. Of a map its samples move: a row of
  !> summits, and one of the samples where they are the reference.
  subroutine add_input_error(scene_in, allowance, table)
    type(scene), intent(in) :: scene_in            !! checked values
    type(time_allowance), intent(in) :: allowance  !! time that may be spent
    type(way_table), intent(inout) :: table        !! gets the row
    real(real64) :: halves(2)
    character(len=32) :: name

    halves = half_units(scene_in)
    if (.not. allocated(scene_in%map)) then
      write (name, '("heights", es8.1e2, ", radii", es8.1e2)') halves
      call add_draws(scene_way(family=of_arithmetic), table%plain, name)
      return
    end if
    write (name, '("heights", es8.1e2, ", of summits")') halves(1)
    call add_draws(scene_way(family=of_arithmetic), table%plain, name)
    ! What the samples themselves mean, where they are the reference.
    if (table%rows(table%reference)%way%interaction /= effect_boundary) return
    write (name, '("heights", es8.1e2, ", of samples")') halves(1)
    call add_draws(table%rows(table%reference)%way, table%truth, name)

  contains

    ! A row: other inputs in a way, against the totals that it has as given.
    subroutine add_draws(way, as_given, name)
      type(scene_way), intent(in) :: way
      type(way_totals), intent(in) :: as_given
      character(len=*), intent(in) :: name
      type(way_row) :: row
      type(way_errors) :: errors
      type(scene) :: other
      type(scene_results) :: results
      type(run_options) :: options
      integer :: draw

      row%way = scene_way(family=of_input)
      row%way%name = name
      if (.not. allocated(as_given%first)) then
        row%left_out = 'contacts each alone were not run'
      else
        row%own = way_errors(largest=0.0_real64, mean=0.0_real64, area=0.0_real64, worst=0)
        options = run_options(keep_contacts=.false., threads=1)
        call options%interrupt%end_within(allowance%left())
        do draw = 1, draws
          call perturbed_scene(scene_in, halves, draw, other)
          call run_way(other, way, options, results, row%left_out)
          if (options%interrupt%is_asked()) row%left_out = 'takes longer than --seconds'
          if (allocated(row%left_out)) exit
          errors = errors_of(totals_of(results), as_given)
          if (errors%largest >= row%own%largest) row%own = errors
        end do
        if (allocated(row%left_out)) row%own = way_errors()
      end if
      table%rows = [table%rows, row]
    end subroutine add_draws

  end subroutine add_input_error

  !> Adds a row a theory, and the criteria of the elastic limit.
  subroutine add_theories(scene_in, table)
    type(scene), intent(in) :: scene_in      !! checked values
    type(way_table), intent(inout) :: table  !! gets them
    type(scene) :: plain
    type(reviewed_theory), allocatable :: theories(:)
    type(way_row) :: row
    integer(int64) :: from, rate, until
    integer :: i

    call system_clock(from, rate)
    if (allocated(scene_in%map)) then
      call without_map(scene_in, plain, table%no_theories)
      if (allocated(table%no_theories)) return
    else
      plain = scene_in
    end if
    call theories_of(plain, table%truth, theories, table%criteria, table%no_theories)
    call system_clock(until)
    do i = 1, size(theories)
      row = way_row(way=scene_way(family=of_theory))
      row%way%name = theories(i)%name
      if (allocated(theories(i)%left_out)) then
        row%left_out = theories(i)%left_out
      else
        row%total%largest = theories(i)%load
        row%total%area = theories(i)%area
        ! Of all theories together.
        row%seconds = real(until - from, real64) / real(rate, real64)
      end if
      table%rows = [table%rows, row]
    end do
  end subroutine add_theories

  !> Measures with what power of the load the area grows, contacts each alone, over the last
  !> hundredth of the closing at the position with the greatest load: what Archard's hemispheres on
  !> hemispheres have exponents for.
  subroutine add_exponent(scene_in, table)
    type(scene), intent(in) :: scene_in      !! checked values
    type(way_table), intent(inout) :: table  !! gets the exponent
    type(scene) :: one
    type(way_totals) :: less
    type(scene_results) :: results
    character(len=:), allocatable :: failure
    integer :: m, last

    if (.not. allocated(table%plain%first)) return
    if (allocated(scene_in%map)) then
      call without_map(scene_in, one, failure)
      if (allocated(failure)) return
    else
      one = scene_in
    end if
    associate (plain => table%plain)
      m = maxloc(plain%load(plain%first(2:) - 1), 1)
      last = plain%first(m + 1) - 1
      if (.not. (plain%closing(last) > 0.0_real64 .and. plain%area(last) > 0.0_real64)) return
      one%motion%x_first = place_of(one%motion%x_first, one%motion%x_step)
      one%motion%y_first = place_of(one%motion%y_first, one%motion%y_step)
      one%motion%positions = 1
      one%loading%control = control_approach
      if (allocated(one%loading%path)) deallocate (one%loading%path)
      one%loading%value = rounded_decimal(plain%approach(last) + &
                                          0.01_real64 * plain%closing(last), 17)
      call run_way(one, scene_way(family=of_arithmetic), &
                   run_options(keep_contacts=.false., threads=1), results, failure)
      if (allocated(failure)) return
      less = totals_of(results)
      if (less%load(1) < plain%load(last) .and. less%area(1) > 0.0_real64) &
        table%exponent = log(less%area(1) / plain%area(last)) / log(less%load(1) / plain%load(last))
    end associate

  contains

    type(decimal_value) function place_of(first, step)
      type(decimal_value), intent(in) :: first, step

      place_of = rounded_decimal(decimal_to_real64(first) + (m - 1) * decimal_to_real64(step), 17)
    end function place_of

  end subroutine add_exponent

end module asperity_way_beside
