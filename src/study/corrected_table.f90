!> Table VI as it should read, beside what the original prints, with the reason of every change.
!>
!> Each number is computed in stages, and each stage removes faults of
!> docs/theory/faults.md: the start
!> values of maxima and minima, rounding (the same program in real128), marching (exact events
!> instead), the contacts left out of the averages and the wrong divisor, and the loads normal to
!> the contacts (their vertical parts instead).
module asperity_corrected_table
  use asperity_card_deck, only: card_deck
  use asperity_kinds, only: real64
  use asperity_original, only: run_in_arithmetic
  use asperity_original_records, only: approach_row, individual_difference_row, original_records, &
                                       original_request, points_row, slope_row, total_area_row, &
                                       total_difference_row, total_load_row
  use asperity_scene_results, only: scene_results
  implicit none
  private

  public :: corrected_table, correct_table, stage_name

  ! Stages, in the order in which faults are removed.
  integer, parameter :: start_value = 1  ! fault 14
  integer, parameter :: rounding = 2     ! faults 2 and 3
  integer, parameter :: marching = 3     ! faults 4, 5, 7, 11 and 15
  integer, parameter :: counting = 4     ! faults 1 and 13
  integer, parameter :: vertical = 5     ! fault 8

  !> Table VI, before and after: rows of the original's table; maximum, minimum, average.
  type :: corrected_table
    real(real64) :: historic(7, 3) = 0.0_real64   !! as the original prints it
    real(real64) :: change(7, 3, vertical) = 0.0_real64  !! by stage; their sum leads to `corrected`
    real(real64) :: corrected(7, 3) = 0.0_real64  !! as it should read
    character(len=:), allocatable :: marching     !! how the marching went wrong on this deck
    character(len=:), allocatable :: why_not      !! where the original stops; allocated: no table
  end type corrected_table

contains

  !> Builds the table from the original's runs on a deck, in its own arithmetic and in real128, and
  !> the present-day results. A deck on which the original goes astray has none.
  type(corrected_table) function correct_table(deck, results) result(table)
    type(card_deck), intent(in) :: deck            !! cards of the deck
    type(scene_results), intent(in) :: results     !! its sweep, with the rows of the last states
    type(original_records) :: historic, exact_arithmetic
    real(real64) :: stage(7, 3, 0:vertical)
    integer :: number

    call run_in_arithmetic('ibm370', deck, original_request(), historic, table%why_not)
    if (allocated(table%why_not)) return
    call run_in_arithmetic('real128', deck, original_request(), exact_arithmetic, table%why_not)
    if (allocated(table%why_not)) return
    stage(:, :, 0) = historic%variance
    stage(:, :, start_value) = without_start_values(historic)
    stage(:, :, rounding) = without_start_values(exact_arithmetic)
    stage(:, :, marching) = table_of(results, as_original=.true., is_vertical=.false.)
    stage(:, :, counting) = table_of(results, as_original=.false., is_vertical=.false.)
    stage(:, :, vertical) = table_of(results, as_original=.false., is_vertical=.true.)
    table%historic = stage(:, :, 0)
    table%corrected = stage(:, :, vertical)
    do number = 1, vertical
      table%change(:, :, number) = stage(:, :, number) - stage(:, :, number - 1)
    end do
    ! The last step of a position passes the limit, or the approaches run out before it.
    associate (positions => exact_arithmetic%positions)
      table%marching = 'overshoot'
      if (.not. all(positions%limit_reached)) &
        table%marching = table%marching // ' or approaches run out'
      if (.not. any(positions%limit_reached)) table%marching = 'approaches run out'
      ! A displacement of the deck before the first step is in the present-day solver alone.
      if (max(abs(2 * positions(1)%x_displacement - positions(2)%x_displacement), &
              abs(2 * positions(1)%y_displacement - positions(2)%y_displacement)) > &
          1.0e-9_real64) table%marching = table%marching // ' and displacement of the deck'
    end associate
  end function correct_table

  !> Name of a stage in print, for a row of the table.
  function stage_name(table, stage, row) result(name)
    type(corrected_table), intent(in) :: table   !! table of the deck
    integer, intent(in) :: stage                 !! from 1, as in `change`
    integer, intent(in) :: row                   !! of the table
    character(len=:), allocatable :: name        !! a few words

    select case (stage)
    case (start_value)
      name = 'start value'
    case (rounding)
      name = 'rounding'
    case (marching)
      name = table%marching
    case (counting)
      name = 'wrong divisor'
      ! The average number of points is cut to a whole number.
      if (row == points_row) name = 'cut to a whole number'
      if (row == slope_row .or. row == individual_difference_row) name = 'contacts left out'
    case default
      name = 'vertical load'
    end select
  end function stage_name

  !> The original's table with true maxima and minima where it prints their start values.
  function without_start_values(records) result(table)
    type(original_records), intent(in) :: records
    real(real64) :: table(7, 3)

    table = records%variance
    associate (positions => records%positions)
      table(total_load_row, :2) = [maxval(positions%load), minval(positions%load)]
      table(total_area_row, :2) = [maxval(positions%area), minval(positions%area)]
      table(points_row, :2) = real([maxval(positions%contacts), minval(positions%contacts)], real64)
      table(approach_row, :2) = [maxval(positions%approach), minval(positions%approach)]
    end associate
    ! A percentage cannot pass its start value. Without a contact at its limit there are no slopes.
    if (table(slope_row, 1) < table(slope_row, 2)) &
      table([slope_row, individual_difference_row], :2) = 0.0_real64
  end function without_start_values

  !> Table VI of the present-day results. `as_original` keeps the original's averages: contacts from
  !> the first at its limit on, and the sum over positions divided by their count. `is_vertical`:
  !> the loads are the vertical ones.
  function table_of(results, as_original, is_vertical) result(table)
    type(scene_results), intent(in) :: results
    logical, intent(in) :: as_original, is_vertical
    real(real64) :: table(7, 3)
    real(real64) :: values(size(results%positions), 7), difference, slopes, differences
    integer :: contacts, i, m
    logical :: at_limit

    table(:, 1) = -huge(1.0_real64)
    table(:, 2) = huge(1.0_real64)
    slopes = 0.0_real64
    differences = 0.0_real64
    contacts = 0
    do m = 1, size(results%positions)
      associate (position => results%positions(m), &
                 last => results%positions(m)%states(size(results%positions(m)%states)))
        values(m, total_load_row) = merge(last%vertical_load, last%load, is_vertical)
        values(m, total_area_row) = last%area
        values(m, points_row) = real(last%contacts, real64)
        values(m, approach_row) = last%approach
        values(m, total_difference_row) = area_difference(last%area, last%projected_area)
        at_limit = .not. as_original
        do i = last%first_row, last%last_row
          at_limit = at_limit .or. position%rows(i)%limit_exceeded
          if (.not. (at_limit .and. position%rows(i)%load > 0.0_real64)) cycle
          contacts = contacts + 1
          difference = area_difference(position%rows(i)%area, position%rows(i)%projected_area)
          slopes = slopes + position%rows(i)%slope
          differences = differences + difference
          table(slope_row, 1) = max(table(slope_row, 1), position%rows(i)%slope)
          table(slope_row, 2) = min(table(slope_row, 2), position%rows(i)%slope)
          table(individual_difference_row, 1) = max(table(individual_difference_row, 1), difference)
          table(individual_difference_row, 2) = min(table(individual_difference_row, 2), difference)
        end do
      end associate
    end do
    ! Without a contact there are no slopes.
    if (contacts == 0) table([slope_row, individual_difference_row], :) = 0.0_real64
    do i = 1, 7
      if (i == slope_row .or. i == individual_difference_row) cycle
      table(i, 1) = maxval(values(:, i))
      table(i, 2) = minval(values(:, i))
      table(i, 3) = sum(values(:, i)) / size(results%positions)
    end do
    if (as_original) then
      table(points_row, 3) = aint(table(points_row, 3))
      table(total_difference_row, 3) = sum(values(:, total_difference_row)) / max(1, contacts)
    end if
    table(slope_row, 3) = slopes / max(1, contacts)
    table(individual_difference_row, 3) = differences / max(1, contacts)
  end function table_of

  !> By how much the projected area falls short of the area, %.
  pure real(real64) function area_difference(area, projected)
    real(real64), intent(in) :: area, projected

    area_difference = 0.0_real64
    if (area > 0.0_real64) area_difference = 100 * (area - projected) / area
  end function area_difference

end module asperity_corrected_table
