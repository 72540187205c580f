!> The totals of all positions in some way of computing, and how far those of another way are off.
module asperity_way_totals
  use asperity_kinds, only: not_computed, real64
  use asperity_original_records, only: original_positions, original_records
  use asperity_scene_results, only: scene_results
  implicit none
  private

  public :: way_errors, way_totals
  public :: errors_of, mean_ends, original_totals, totals_of

  !> Totals of the states of all positions.
  type :: way_totals
    integer, allocatable :: first(:)             !! state of a position; one more: past the last
    real(real64), allocatable :: load(:)         !! sum of the normal forces
    real(real64), allocatable :: vertical(:)     !! sum of their vertical parts
    real(real64), allocatable :: approach(:)     !! separation of the reference planes
    real(real64), allocatable :: closing(:)      !! past first touch
    real(real64), allocatable :: area(:)         !! real
    real(real64) :: greatest_pressure = 0.0_real64    !! at any point of a last state
    real(real64) :: own_estimate = not_computed  !! largest `error_estimate` of the positions
    logical :: is_held = .false.                 !! states in time follow
  end type way_totals

  !> How far a way is off.
  type :: way_errors
    !> Largest over the positions: relative, of the load, or of the approach over the closing.
    real(real64) :: largest = not_computed
    real(real64) :: mean = not_computed    !! the same, mean over the positions
    real(real64) :: area = not_computed    !! largest over the positions: relative, of the area
    integer :: worst = 0                   !! position of the largest
  end type way_errors

contains

  !> The totals of results.
  pure function totals_of(results) result(totals)
    type(scene_results), intent(in) :: results  !! of a way
    type(way_totals) :: totals
    integer :: i, k, m, number

    number = 0
    do m = 1, size(results%positions)
      number = number + size(results%positions(m)%states)
    end do
    call make_room(totals, size(results%positions), number)
    k = 0
    do m = 1, size(results%positions)
      totals%first(m) = k + 1
      associate (position => results%positions(m))
        do i = 1, size(position%states)
          k = k + 1
          associate (state => position%states(i))
            totals%load(k) = state%load
            totals%vertical(k) = state%vertical_load
            totals%approach(k) = state%approach
            totals%closing(k) = state%closing
            totals%area(k) = state%area
            totals%is_held = totals%is_held .or. state%time > 0.0_real64
          end associate
        end do
        totals%greatest_pressure = max(totals%greatest_pressure, &
                                       position%states(size(position%states))%greatest_pressure)
        ! It is of the last state, and says nothing of a path that came back.
        if (totals%is_held .or. maxval(totals%closing(totals%first(m):k)) <= totals%closing(k)) &
          totals%own_estimate = max(totals%own_estimate, position%error_estimate)
      end associate
    end do
    totals%first(size(totals%first)) = k + 1
  end function totals_of

  !> The totals of the original program: one state a position, its closing not known.
  pure function original_totals(records) result(totals)
    type(original_records), intent(in) :: records  !! of a run
    type(way_totals) :: totals
    integer :: m

    call make_room(totals, original_positions, original_positions)
    totals%first = [(m, m=1, original_positions + 1)]
    totals%load = records%positions%load
    totals%vertical = not_computed
    totals%approach = records%positions%approach
    totals%closing = 0.0_real64
    totals%area = records%positions%area
  end function original_totals

  pure subroutine make_room(totals, positions, states)
    type(way_totals), intent(inout) :: totals
    integer, intent(in) :: positions, states

    allocate (totals%first(positions + 1), totals%load(states), totals%vertical(states), &
              totals%approach(states), totals%closing(states), totals%area(states))
  end subroutine make_room

  !> How far a way is off from another one: at every state of a position where both have as many,
  !> else at the last one of a hold, else at the deepest. The error of a load, of the normal forces
  !> or of their vertical parts, is relative to the largest of the position, that of the approach to
  !> its largest closing; the largest counts, as one of them is asked for.
  pure function errors_of(totals, reference) result(errors)
    type(way_totals), intent(in) :: totals     !! of a way
    type(way_totals), intent(in) :: reference  !! of the way it is held against
    type(way_errors) :: errors
    real(real64) :: error, of_area, all_errors
    integer :: have, k, last, m, want

    errors = way_errors(largest=0.0_real64, mean=0.0_real64, area=0.0_real64, worst=0)
    all_errors = 0.0_real64
    do m = 1, size(reference%first) - 1
      want = reference%first(m)
      last = reference%first(m + 1) - 1
      have = totals%first(m)
      if (totals%first(m + 1) - have == last - want + 1) then
        call compare([(have + k, k=0, last - want)], [(k, k=want, last)], &
                     error, of_area)
      else if (reference%is_held) then
        call compare([totals%first(m + 1) - 1], [last], error, of_area)
      else
        call compare([have - 1 + maxloc(totals%closing(have:totals%first(m + 1) - 1), 1)], &
                     [want - 1 + maxloc(reference%closing(want:last), 1)], &
                     error, of_area)
      end if
      all_errors = all_errors + error
      errors%area = max(errors%area, of_area)
      if (error > errors%largest .or. errors%worst == 0) then
        errors%largest = error
        errors%worst = m
      end if
    end do
    errors%mean = all_errors / max(1, size(reference%first) - 1)

  contains

    ! States of the one against states of the other.
    pure subroutine compare(one, other, error, of_area)
      integer, intent(in) :: one(:), other(:)
      real(real64), intent(out) :: error, of_area

      error = max(share(maxval(abs(totals%load(one) - reference%load(other))), &
                        maxval(abs(reference%load(other)))), &
                  share(maxval(abs(totals%vertical(one) - reference%vertical(other)), &
                               totals%vertical(one) > not_computed), &
                        maxval(abs(reference%vertical(other)))), &
                  share(maxval(abs(totals%approach(one) - reference%approach(other))), &
                        maxval(reference%closing(other))))
      of_area = share(maxval(abs(totals%area(one) - reference%area(other))), &
                      maxval(reference%area(other)))
    end subroutine compare

  end function errors_of

  !> Load, approach and area of the last states, mean over the positions.
  pure function mean_ends(totals) result(means)
    type(way_totals), intent(in) :: totals  !! of a way
    real(real64) :: means(3)

    associate (ends => totals%first(2:) - 1)
      means = [sum(totals%load(ends)), sum(totals%approach(ends)), sum(totals%area(ends))] / &
              size(ends)
    end associate
  end function mean_ends

  ! A difference over what it is of; all of it where there is none of that.
  pure real(real64) function share(difference, whole)
    real(real64), intent(in) :: difference, whole

    share = 0.0_real64
    if (.not. difference > 0.0_real64) return
    share = 1.0_real64
    if (whole > difference * tiny(whole)) share = difference / whole
  end function share

end module asperity_way_totals
