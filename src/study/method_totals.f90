!> Totals of all positions by some method, and their errors against another method.
module asperity_method_totals
  use asperity_contact_records, only: state_row
  use asperity_kinds, only: not_computed, real64
  use asperity_original_records, only: original_positions, original_records
  use asperity_scene_results, only: scene_results
  implicit none
  private

  public :: method_errors, method_totals
  public :: errors_of, original_totals, totals_of
  public :: error_of_area, error_of_greatest_pressure, error_of_load, error_of_separation, &
            quantity_names

  ! Quantities whose errors are measured one by one.
  integer, parameter :: error_of_load = 1        !! sum of the normal forces
  integer, parameter :: error_of_area = 2        !! contact area
  integer, parameter :: error_of_separation = 3  !! separation over the compression
  integer, parameter :: error_of_contacts = 4    !! number of contacts
  integer, parameter :: error_of_greatest_pressure = 5  !! at any point
  integer, parameter :: number_of_quantities = 5 !! all of them
  !> Their names in the order of the numbers.
  character(len=*), parameter :: quantity_names(number_of_quantities) = [character(len=17) :: &
    'load', 'area', 'separation', 'contacts', 'greatest_pressure']

  !> Totals of the states of all positions.
  type :: method_totals
    integer, allocatable :: first(:)             !! state of a position; one more: past the last
    type(state_row), allocatable :: states(:)    !! states of all positions
    real(real64) :: own_estimate = not_computed  !! largest `error_estimate` of the positions
    !> Largest estimates of the last states: of area, separation and greatest pressure.
    real(real64) :: estimates(3) = not_computed
    logical :: is_held = .false.                 !! states in time follow
  end type method_totals

  !> Errors of a method.
  type :: method_errors
    !> Largest over the positions: relative, of the load, or of the approach over the compression.
    real(real64) :: largest = not_computed
    real(real64) :: mean = not_computed    !! the same, mean over the positions
    integer :: worst = 0                   !! position of the largest
    !> Relative errors by quantity, largest and mean over the positions.
    real(real64) :: quantity(number_of_quantities) = not_computed
    real(real64) :: quantity_mean(number_of_quantities) = not_computed
  end type method_errors

  ! Errors of a method that agrees with the other.
  type(method_errors), parameter :: no_errors = method_errors( &
    largest=0.0_real64, mean=0.0_real64, quantity=0.0_real64, quantity_mean=0.0_real64)

contains

  !> The totals of results.
  pure type(method_totals) function totals_of(results) result(totals)
    type(scene_results), intent(in) :: results  !! of a method
    integer :: k, m

    associate (positions => results%positions)
      allocate (totals%first(size(positions) + 1), totals%states( &
                sum([(size(positions(m)%states), m=1, size(positions))])))
    end associate
    k = 0
    do m = 1, size(results%positions)
      totals%first(m) = k + 1
      associate (position => results%positions(m))
        k = k + size(position%states)
        totals%states(totals%first(m):k) = position%states
        totals%is_held = totals%is_held .or. any(position%states%time > 0.0_real64)
        associate (last => totals%states(k))
          totals%estimates = max(totals%estimates, &
                                 [last%area_error, last%separation_error, last%pressure_error])
        end associate
        ! The estimate is that of the last state, not of a path that came back.
        if (totals%is_held .or. &
            maxval(position%states%compression) <= totals%states(k)%compression) &
          totals%own_estimate = max(totals%own_estimate, position%error_estimate)
      end associate
    end do
    totals%first(size(totals%first)) = k + 1
  end function totals_of

  !> The totals of the original program: one state a position, its compression not known.
  pure type(method_totals) function original_totals(records) result(totals)
    type(original_records), intent(in) :: records  !! of a run
    integer :: m

    allocate (totals%first(original_positions + 1), totals%states(original_positions))
    totals%first(:) = [(m, m=1, original_positions + 1)]
    totals%states%load = records%positions%load
    totals%states%approach = records%positions%approach
    totals%states%compression = 0.0_real64
    totals%states%area = records%positions%area
    totals%states%contacts = records%positions%contacts
    do m = 1, original_positions
      associate (first => records%positions(m)%first_contact, &
                 last => records%positions(m)%last_contact)
        if (last >= first) totals%states(m)%greatest_pressure = maxval( &
          records%contacts(first:last)%maximum_pressure, &
          records%contacts(first:last)%step == records%contacts(last)%step)
      end associate
    end do
  end function original_totals

  !> Errors of a method against another one: at every state of a position where both have as many,
  !> else at the last one of a hold, else at the deepest. The error of a load, of the normal forces
  !> or of their vertical parts, is relative to the largest of the position, that of the approach to
  !> its largest compression; the largest counts, as one of them is asked for.
  type(method_errors) function errors_of(totals, reference) result(errors)
    type(method_totals), intent(in) :: totals     !! of a method
    type(method_totals), intent(in) :: reference  !! of the method it is compared with
    real(real64) :: error, by_quantity(number_of_quantities)
    integer :: have, last, m, positions, want

    errors = no_errors
    do m = 1, size(reference%first) - 1
      want = reference%first(m)
      last = reference%first(m + 1) - 1
      have = totals%first(m)
      if (totals%first(m + 1) - have == last - want + 1) then
        call compare_states(totals%states(have:have + last - want), reference%states(want:last))
      else
        if (reference%is_held) then
          have = totals%first(m + 1) - 1
          want = last
        else
          have = have - 1 + maxloc(totals%states(have:totals%first(m + 1) - 1)%compression, 1)
          want = want - 1 + maxloc(reference%states(want:last)%compression, 1)
        end if
        call compare_states(totals%states(have:have), reference%states(want:want))
      end if
      errors%mean = errors%mean + error
      errors%quantity = max(errors%quantity, by_quantity)
      errors%quantity_mean = errors%quantity_mean + by_quantity
      if (error > errors%largest .or. errors%worst == 0) then
        errors%largest = error
        errors%worst = m
      end if
    end do
    positions = max(1, size(reference%first) - 1)
    errors%mean = errors%mean / positions
    errors%quantity_mean = errors%quantity_mean / positions

  contains

    ! States of the one against states of the other.
    subroutine compare_states(one, other)
      type(state_row), intent(in) :: one(:), other(:)

      by_quantity(error_of_load) = relative_to(maxval(abs(one%load - other%load)), &
                                               maxval(abs(other%load)))
      by_quantity(error_of_area) = relative_to(maxval(abs(one%area - other%area)), &
                                               maxval(other%area))
      by_quantity(error_of_separation) = &
        relative_to(maxval(abs(one%approach - other%approach)), maxval(other%compression))
      by_quantity(error_of_contacts) = &
        relative_to(real(maxval(abs(one%contacts - other%contacts)), real64), &
                    real(maxval(other%contacts), real64))
      by_quantity(error_of_greatest_pressure) = &
        relative_to(maxval(abs(one%greatest_pressure - other%greatest_pressure)), &
                    maxval(other%greatest_pressure))
      error = max(by_quantity(error_of_load), by_quantity(error_of_separation), &
                  relative_to(maxval(abs(one%vertical_load - other%vertical_load), &
                                     one%vertical_load > not_computed), &
                              maxval(abs(other%vertical_load))))
    end subroutine compare_states

  end function errors_of

  ! A difference over what it is of; all of it where there is none of that.
  pure real(real64) function relative_to(difference, whole)
    real(real64), intent(in) :: difference, whole

    relative_to = 0.0_real64
    if (.not. difference > 0.0_real64) return
    relative_to = 1.0_real64
    if (whole > difference * tiny(whole)) relative_to = difference / whole
  end function relative_to

end module asperity_method_totals
