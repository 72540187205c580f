!> Whether every state of a position carries the requested load and is physically valid.
!>
!> The driver checks this for every solver, independently of the error that the solver reports.
module asperity_loads_met
  use asperity_contact_records, only: prescribed_nothing, prescribed_vertical, position_result
  use asperity_kinds, only: real64
  use asperity_problems, only: decimal_text, real_text
  use asperity_theory_warnings, only: of_contact_radius, of_load_direction, take_worse, &
                                      theory_warning, add_warning
  implicit none
  private

  public :: check_loads, check_meaning, compare_loads

contains

  !> Checks the relative error of requested loads. That of a load of 0 is relative to the largest
  !> requested load. A load is not in error that is met to its rounding error.
  pure subroutine check_loads(position, tolerance, failure)
    type(position_result), intent(in) :: position             !! result of the position
    real(real64), intent(in) :: tolerance                     !! largest relative error
    character(len=:), allocatable, intent(inout) :: failure   !! state, requested and found load
    real(real64) :: found, largest, reference
    integer :: i

    largest = maxval(abs(position%states%prescribed_load), &
                     position%states%prescribed /= prescribed_nothing)
    do i = 1, size(position%states)
      associate (state => position%states(i))
        if (state%prescribed == prescribed_nothing) cycle
        found = merge(state%vertical_load, state%load, state%prescribed == prescribed_vertical)
        reference = abs(state%prescribed_load)
        if (.not. reference > 0.0_real64) reference = largest
        if (abs(found - state%prescribed_load) <= &
            max(tolerance * reference, state%load_rounding)) cycle
        ! All requested loads are 0.
        if (.not. reference > 0.0_real64) cycle
        failure = 'the load of state ' // decimal_text(i) // ' is missed: asked for ' // &
                  real_text(state%prescribed_load) // ', found ' // real_text(found)
        return
      end associate
    end do
  end subroutine check_loads

  !> Checks that states are possible: `failure` reports contacts on more than the nominal area, or
  !> a plane below the bottom of a sphere: the overlap W exceeds its diameter 2 R, and the radius
  !> sqrt(R W) of the contact is more than sqrt(2) R.
  pure subroutine check_meaning(position, nominal_area, failure)
    type(position_result), intent(in) :: position             !! result of the position
    real(real64), intent(in) :: nominal_area                  !! nominal area; 0: not given
    character(len=:), allocatable, intent(inout) :: failure  !! state and reason, unchanged when
                                                             !! possible
    real(real64), parameter :: rounding = 1.0e-9_real64
    real(real64) :: ratio
    integer :: i

    ! The numerator is limited so that a tiny area does not overflow the ratio.
    do i = 1, merge(size(position%states), 0, nominal_area > 0.0_real64)
      ratio = min(position%states(i)%projected_area, huge(ratio) * min(nominal_area, 1.0_real64)) &
              / nominal_area
      if (ratio > 1.0_real64 + rounding) &
        failure = 'the contact area of state ' // decimal_text(i) // ' is ' // &
                  real_text(ratio) // ' times the nominal area: reduce the load or ' // &
                  'check nominal_area'
    end do
    if (.not. allocated(position%warnings)) return
    do i = 1, size(position%warnings)
      associate (found => position%warnings(i))
        if (found%number == of_contact_radius .and. &
            found%magnitude > sqrt(2.0_real64) * (1.0_real64 + rounding)) &
          failure = 'a contact circle of state ' // decimal_text(found%state) // ' has ' // &
                    real_text(found%magnitude) // &
                    ' times the radius of its sphere, which lies ' // &
                    'beyond the sphere: reduce the load'
      end associate
    end do
  end subroutine check_meaning

  !> Warns where the sum of the normal forces and the vertical load differ by more than a share.
  pure subroutine compare_loads(position, share)
    type(position_result), intent(inout) :: position  !! result of the position; gets the warning
    real(real64), intent(in) :: share  !! limit, relative to the sum of the normal forces
    type(theory_warning), allocatable :: found(:)
    real(real64) :: difference
    integer :: i

    do i = 1, size(position%states)
      associate (state => position%states(i))
        if (.not. state%load > 0.0_real64) cycle
        difference = abs(state%load - state%vertical_load) / state%load
        if (.not. difference > share) cycle
        if (allocated(found)) deallocate (found)
        call add_warning(found, of_load_direction, difference)
        call take_worse(position%warnings, found, i)
      end associate
    end do
  end subroutine compare_loads

end module asperity_loads_met
