!> The far field in single precision, and the compliances beside it: for steps that are rough.
!>
!> Two terms of the series of coupled_far serve from four sums of radii on: a lift is off by some
!> 1e-5 of the largest penetration. Lengths count in one that is large, loads in the largest:
!> nothing overflows.
module asperity_coupled_rough
  use asperity_kinds, only: real32, real64
  implicit none
  private

  public :: rough_contacts, set_out_roughly, feel_roughly, rough_lift, rough_tilt

  ! Squared distances below this count as this: nothing is divided by zero.
  real(real32), parameter :: least = 1.0e-20_real32

  !> Contacts in plan, and what they feel.
  type :: rough_contacts
    real(real64) :: length = 1.0_real64          !! unit of length
    real(real64) :: load_unit = 1.0_real64       !! unit of load
    real(real32), allocatable :: x(:)            !! place in plan
    real(real32), allocatable :: y(:)            !! place in plan
    real(real32), allocatable :: circle(:)       !! radius of the contact circle
    real(real32), allocatable :: load(:)         !! vertical; of those that have one
    real(real32), allocatable :: lift(:)         !! displacement times pi times the modulus
    real(real32), allocatable :: tilt_x(:)       !! its slope
    real(real32), allocatable :: tilt_y(:)       !! its slope
    real(real32), allocatable :: is_far(:)       !! 1; 0 where near to the source: nothing felt
    real(real32), allocatable :: compliance(:)   !! with the source, as between flat punches
  end type rough_contacts

contains

  !> Sets out contacts that feel nothing yet.
  pure subroutine set_out_roughly(x, y, circle, load, rough)
    real(real64), contiguous, intent(in) :: x(:), y(:)  !! places
    real(real64), contiguous, intent(in) :: circle(:)   !! radii of their circles
    real(real64), contiguous, intent(in) :: load(:)     !! of the first ones, which have load
    type(rough_contacts), intent(out) :: rough          !! ready
    real(real64) :: low_x, low_y
    integer :: i, m, n

    m = size(load)
    n = size(x)
    allocate (rough%x(n), rough%y(n), rough%circle(n), rough%load(m), rough%lift(n), &
              rough%tilt_x(n), rough%tilt_y(n), rough%is_far(n), rough%compliance(n))
    rough%lift = 0.0_real32
    rough%tilt_x = 0.0_real32
    rough%tilt_y = 0.0_real32
    if (m == 0) return
    low_x = minval(x)
    low_y = minval(y)
    rough%length = max(maxval(x) - low_x, maxval(y) - low_y, maxval(circle))
    rough%load_unit = maxval(load)
    if (.not. rough%length > 0.0_real64) rough%length = 1.0_real64
    if (.not. rough%load_unit > 0.0_real64) rough%load_unit = 1.0_real64
    do i = 1, n
      rough%x(i) = real((x(i) - low_x) / rough%length, real32)
      rough%y(i) = real((y(i) - low_y) / rough%length, real32)
      rough%circle(i) = real(circle(i) / rough%length, real32)
    end do
    rough%load = real(load / rough%load_unit, real32)
  end subroutine set_out_roughly

  !> Unit of a lift for a modulus of 1/pi.
  pure function rough_lift(rough) result(unit)
    type(rough_contacts), intent(in) :: rough !! the contacts
    real(real64) :: unit

    unit = rough%load_unit / rough%length
  end function rough_lift

  !> Unit of a tilt for a modulus of 1/pi.
  pure function rough_tilt(rough) result(unit)
    type(rough_contacts), intent(in) :: rough !! the contacts
    real(real64) :: unit

    unit = rough%load_unit / rough%length**2
  end function rough_tilt

  !> What contacts feel of a source, those near to it nothing. Called from another file: so the
  !> compiler knows that no two arrays are the same, and makes vectors.
  pure subroutine feel_roughly(x0, y0, b, load, near_to, x, y, circle, lift, tilt_x, tilt_y, &
                               is_far, compliance)
    real(real32), intent(in) :: x0                              !! place of the source
    real(real32), intent(in) :: y0                              !! place of the source
    real(real32), intent(in) :: b                               !! radius of its circle
    real(real32), intent(in) :: load                            !! its load
    real(real32), intent(in) :: near_to                         !! sums of radii that are near
    real(real32), contiguous, intent(in) :: x(:), y(:)          !! of those who feel
    real(real32), contiguous, intent(in) :: circle(:)           !! of those who feel
    real(real32), contiguous, intent(inout) :: lift(:)          !! gets more
    real(real32), contiguous, intent(inout) :: tilt_x(:)        !! gets more
    real(real32), contiguous, intent(inout) :: tilt_y(:)        !! gets more
    real(real32), contiguous, intent(out) :: is_far(:)          !! 1; 0 where not: nothing felt
    real(real32), contiguous, intent(out) :: compliance(:)      !! as between flat punches
    real(real32) :: dx, dy, rr, a2, sum2, limit, w, root, slope, b2
    integer :: i

    b2 = b * b
    do i = 1, size(x)
      limit = (near_to * (circle(i) + b))**2
      is_far(i) = merge(1.0_real32, 0.0_real32, (x(i) - x0)**2 + (y(i) - y0)**2 > limit)
    end do
    do i = 1, size(x)
      dx = x(i) - x0
      dy = y(i) - y0
      rr = dx * dx + dy * dy
      a2 = circle(i) * circle(i)
      sum2 = a2 + b2
      w = 1.0_real32 / max(rr, sum2, least)
      root = sqrt(w)
      compliance(i) = root * (1.0_real32 + w * sum2 * (1.0_real32 / 6.0_real32))
      root = is_far(i) * load * root
      ! The one who feels is a flat punch, its source has Hertz' weight; both have for the slope.
      lift(i) = lift(i) + root * (1.0_real32 + w * (0.1_real32 * sum2 + &
                                                    a2 * (1.0_real32 / 15.0_real32)))
      slope = root * w * (1.0_real32 + w * 0.3_real32 * sum2)
      tilt_x(i) = tilt_x(i) - slope * dx
      tilt_y(i) = tilt_y(i) - slope * dy
    end do
  end subroutine feel_roughly

end module asperity_coupled_rough
