!> Additions to the methods of a scene: the error from the rounding of the input, theories in closed
!> form, the exponent of the area over the load. Heights and radii are given within half a unit of
!> the last digit that any of them has.
module asperity_study_additions
  use asperity_contact_records, only: state_row
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_height_map, only: height_map, is_measured
  use asperity_interruption, only: interruption
  use asperity_kinds, only: int64, real64
  use asperity_method_study, only: method_row, method_table
  use asperity_method_totals, only: error_of_area, errors_of, no_errors, totals_of, method_errors, &
                                    method_totals
  use asperity_number_span, only: number_span, span_of
  use asperity_numeral, only: rounded_decimal
  use asperity_problems, only: real_text
  use asperity_random_philox, only: philox_block
  use asperity_reviewed_theories, only: reviewed_theory, evaluate_theories
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: control_separation, effect_boundary, scene, scene_surface
  use asperity_study_methods, only: of_arithmetic, of_input, of_theory, run_method, study_method, &
                                    replace_map
  implicit none
  private

  public :: add_exponent, add_input_error, add_theories

  ! Other inputs with the same digits that are tried: the largest of so many is above the median
  ! with a chance of 15/16.
  integer, parameter :: draws = 4

  ! The unit of the last digit is found from so many numbers, distributed over all.
  integer, parameter :: most_looked_at = 2000
  ! A deck has inches.
  real(real64), parameter :: cm_per_inch = 2.54_real64

contains

  !> Adds a row: how far results of contacts each alone move when heights and radii are other
  !> numbers with the same digits; the largest of some draws. Of a map its samples move: a row of
  !> summits, and one of the samples where they are the reference.
  subroutine add_input_error(scene_in, allowance, table)
    type(scene), intent(in) :: scene_in            !! scene with checked values
    type(interruption), intent(in) :: allowance    !! time that may be spent
    type(method_table), intent(inout) :: table        !! gets one more row
    real(real64) :: halves(2)
    character(len=32) :: name
    character(len=:), allocatable :: heights

    halves = half_last_digits(scene_in)
    heights = 'heights ' // real_text(halves(1), 'es8.1e2')
    if (.not. allocated(scene_in%map)) then
      name = heights // ', radii ' // real_text(halves(2), 'es8.1e2')
      call add_draws(study_method(family=of_arithmetic), table%plain, name)
      return
    end if
    name = heights // ', of summits'
    call add_draws(study_method(family=of_arithmetic), table%plain, name)
    ! The rounding of the pixels, where they are the reference.
    if (table%rows(table%reference)%method%interaction /= effect_boundary) return
    name = heights // ', of pixels'
    call add_draws(table%rows(table%reference)%method, table%truth, name)

  contains

    ! A row: other inputs in a method, against the totals that it has as given.
    subroutine add_draws(method, as_given, name)
      type(study_method), intent(in) :: method
      type(method_totals), intent(in) :: as_given
      character(len=*), intent(in) :: name
      type(method_row) :: row
      type(method_errors) :: errors
      type(scene) :: other
      type(scene_results) :: results
      type(run_options) :: options
      integer :: draw

      row%method = study_method(family=of_input)
      row%method%name = name
      if (.not. allocated(as_given%first)) then
        row%left_out = 'isolated contacts were not run'
      else
        row%own = no_errors
        options = run_options(keep_contacts=.false., threads=1)
        options%interrupt = allowance
        do draw = 1, draws
          call perturb_scene(scene_in, halves, draw, other)
          call run_method(other, method, options, results, row%left_out)
          if (options%interrupt%is_asked()) row%left_out = 'takes longer than --seconds'
          if (allocated(row%left_out)) exit
          errors = errors_of(totals_of(results), as_given)
          if (errors%largest >= row%own%largest) row%own = errors
        end do
        if (allocated(row%left_out)) row%own = method_errors()
      end if
      table%rows = [table%rows, row]
    end subroutine add_draws

  end subroutine add_input_error

  !> Adds a row a theory, and the criteria of the elastic limit.
  subroutine add_theories(scene_in, table)
    type(scene), intent(in) :: scene_in      !! scene with checked values
    type(method_table), intent(inout) :: table  !! gets a row each
    type(scene) :: plain
    type(reviewed_theory), allocatable :: theories(:)
    type(method_row) :: row
    integer(int64) :: from, rate, until
    integer :: i

    call system_clock(from, rate)
    call replace_map(scene_in, plain, table%no_theories)
    if (allocated(table%no_theories)) return
    call evaluate_theories(plain, table%truth, theories, table%criteria, table%no_theories)
    call system_clock(until)
    do i = 1, size(theories)
      row = method_row(method=study_method(family=of_theory))
      row%method%name = theories(i)%name
      if (allocated(theories(i)%left_out)) then
        row%left_out = theories(i)%left_out
      else
        row%total%largest = theories(i)%load
        row%total%quantity(error_of_area) = theories(i)%area
        ! Time of all theories together.
        row%seconds = real(until - from, real64) / real(rate, real64)
      end if
      table%rows = [table%rows, row]
    end do
  end subroutine add_theories

  !> Measures the exponent of the area over the load of isolated contacts, over the last hundredth
  !> of the compression at the position with the greatest load, as Archard's hemispheres have it.
  subroutine add_exponent(scene_in, table)
    type(scene), intent(in) :: scene_in      !! scene with checked values
    type(method_table), intent(inout) :: table  !! gets `area_exponent`, a number
    type(scene) :: one
    type(method_totals) :: less
    type(scene_results) :: results
    character(len=:), allocatable :: failure
    type(state_row) :: last
    integer :: m

    if (.not. allocated(table%plain%first)) return
    call replace_map(scene_in, one, failure)
    if (allocated(failure)) return
    associate (plain => table%plain)
      m = maxloc(plain%states(plain%first(2:) - 1)%load, 1)
      last = plain%states(plain%first(m + 1) - 1)
      if (.not. min(last%compression, last%area) > 0.0_real64) return
      one%motion%x_first = position_value(one%motion%x_first, one%motion%x_step)
      one%motion%y_first = position_value(one%motion%y_first, one%motion%y_step)
      one%motion%positions = 1
      one%loading%control = control_separation
      if (allocated(one%loading%path)) deallocate (one%loading%path)
      one%loading%value = rounded_decimal(last%approach + 0.01_real64 * last%compression, 17)
      call run_method(one, study_method(family=of_arithmetic), &
                   run_options(keep_contacts=.false., threads=1), results, failure)
      if (allocated(failure)) return
      less = totals_of(results)
      if (less%states(1)%load < last%load .and. less%states(1)%area > 0.0_real64) &
        table%area_exponent = log(less%states(1)%area / last%area) / &
                              log(less%states(1)%load / last%load)
    end associate

  contains

    type(decimal_value) function position_value(first, step)
      type(decimal_value), intent(in) :: first, step

      position_value = rounded_decimal(decimal_to_real64(first) + (m - 1) * &
                                       decimal_to_real64(step), 17)
    end function position_value

  end subroutine add_exponent

  !> Half a unit of the last digit that any number of both surfaces has: of the heights, of the
  !> radii. A whole number that all are is taken as exact. Of a map its samples'; of two the larger.
  pure function half_last_digits(scene_in) result(halves)
    type(scene), intent(in) :: scene_in  !! scene with checked values
    real(real64) :: halves(2)

    if (allocated(scene_in%map)) then
      halves = [0.5_real64 * max(scene_in%map%upper%digit, scene_in%map%lower%digit), 0.0_real64]
    else if (allocated(scene_in%deck) .and. scene_in%from_deck) then
      associate (upper => scene_in%deck%upper, lower => scene_in%deck%lower)
        halves(1) = cm_per_inch * last_digit_unit([upper%z, lower%z]) / 2
        halves(2) = cm_per_inch * last_digit_unit([upper%radius, lower%radius]) / 2
      end associate
    else
      halves(1) = last_unit_of_doubles([scene_in%upper%height, scene_in%lower%height]) / 2
      halves(2) = last_unit_of_doubles([scene_in%upper%radius, scene_in%lower%radius]) / 2
    end if
  end function half_last_digits

  ! The unit of the last digit of decimals as they were written.
  pure real(real64) function last_digit_unit(values)
    type(decimal_value), intent(in) :: values(:)

    last_digit_unit = 0.0_real64
    if (any(values%all_digits /= 0_int64)) &
      last_digit_unit = 10.0_real64**minval(values%power_of_ten, values%all_digits /= 0_int64)
  end function last_digit_unit

  ! Unit of the last digit of doubles: that of the shortest decimals that give them back.
  pure real(real64) function last_unit_of_doubles(values) result(unit)
    real(real64), intent(in) :: values(:)
    type(decimal_value) :: shortest
    integer :: i, last, number_of_digits

    last = huge(last)
    do i = 1, size(values), 1 + size(values) / most_looked_at
      if (.not. abs(values(i)) > 0.0_real64) cycle
      do number_of_digits = 1, 17
        shortest = rounded_decimal(values(i), number_of_digits)
        if (.not. abs(decimal_to_real64(shortest) - values(i)) > 0.0_real64) exit
      end do
      last = min(last, shortest%power_of_ten)
    end do
    unit = 0.0_real64
    if (last >= 0 .and. .not. maxval(values) > minval(values)) return
    if (last < huge(last)) unit = 10.0_real64**last
  end function last_unit_of_doubles

  !> A scene whose heights and radii are other numbers that would have been written as these, drawn
  !> evenly. Radii that are all equal move together.
  subroutine perturb_scene(scene_in, halves, draw, copy)
    type(scene), intent(in) :: scene_in      !! scene with checked values
    real(real64), intent(in) :: halves(2)    !! as `half_units` has them; of a map it has its own
    integer, intent(in) :: draw              !! number of the draw, from 1
    type(scene), intent(out) :: copy         !! the other scene

    copy = scene_in
    if (allocated(copy%map)) then
      call move_pixels(copy%map%upper, 1)
      call move_pixels(copy%map%lower, 2)
    else
      call move_asperities(copy%upper, 1)
      call move_asperities(copy%lower, 2)
    end if

  contains

    subroutine move_asperities(surface, side)
      type(scene_surface), intent(inout) :: surface
      integer, intent(in) :: side
      type(number_span) :: span
      integer :: i
      logical :: alike

      if (surface%is_plane) return
      span = span_of(surface%radius)
      alike = .not. span%largest > span%least
      do i = 1, size(surface%height)
        surface%height(i) = surface%height(i) + halves(1) * uniform_number(i, side, 1)
        surface%radius(i) = surface%radius(i) + halves(2) * uniform_number(merge(1, i, alike), &
                                                                           side, 2)
      end do
      surface%radius = max(surface%radius, 0.5_real64 * span%least)
    end subroutine move_asperities

    subroutine move_pixels(map, side)
      type(height_map), intent(inout) :: map
      integer, intent(in) :: side
      integer :: i, j

      do j = 1, map%rows
        do i = 1, map%columns
          if (is_measured(map%height(i, j))) map%height(i, j) = map%height(i, j) + &
            0.5_real64 * map%digit * uniform_number(i, side, 2 + j)
        end do
      end do
    end subroutine move_pixels

    ! From -1 to 1.
    real(real64) function uniform_number(i, side, what)
      integer, intent(in) :: i, side, what
      integer(int64) :: words(4)

      words = philox_block([int(i, int64), int(side, int64), int(what, int64), 0_int64], &
                           [int(draw, int64), 0_int64])
      uniform_number = real(words(1), real64) / 2.0_real64**31 - 1.0_real64
    end function uniform_number

  end subroutine perturb_scene

end module asperity_study_additions
