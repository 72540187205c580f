!> The field of far contacts: the first terms of a series in powers of 1/r**2.
!>
!> pi E times a mean (see mutual_displacement) is the sum over k of c(k) <tau**(2 k)>/r**(2 k + 1),
!> c = 1, 1/2, 3/8, 5/16, ... as in 1/sqrt(1 - z). The root and the quotient of a pair serve both
!> of its contacts. No loop adds up into one number: so all become vectors.
module asperity_coupled_far
  use asperity_kinds, only: real32, real64
  implicit none
  private

  public :: far_contact, feel_source, share_field

  !> Sums of radii from which on the series serves: its first term left out is 3e-12 of the
  !> penetration there, which is less than the closed form loses by rounding.
  real(real64), parameter :: far_from = 9.0_real64
  ! Means over a flat row and one of Hertz, to the third term: sum and difference of the two ways.
  real(real64), parameter :: even(5) = &
    [2.0_real64 / 15, 3.0_real64 / 56, 3.0_real64 / 70, 5.0_real64 / 168, 1.0_real64 / 14]
  real(real64), parameter :: uneven(4) = &
    [1.0_real64 / 30, 3.0_real64 / 140, 5.0_real64 / 336, 1.0_real64 / 84]

  !> One contact and what it feels.
  type :: far_contact
    real(real64) :: x = 0.0_real64       !! place in plan
    real(real64) :: y = 0.0_real64       !! place in plan
    real(real64) :: circle = 0.0_real64  !! radius of the contact circle
    real(real64) :: load = 0.0_real64    !! vertical, over pi times the combined modulus
    real(real64) :: lift = 0.0_real64    !! displacement by the others
    real(real64) :: tilt_x = 0.0_real64  !! slope of their surface
    real(real64) :: tilt_y = 0.0_real64  !! slope of their surface
  end type far_contact

contains

  !> What contacts without load feel of one with load.
  pure subroutine feel_source(source, x, y, lift, tilt_x, tilt_y, is_far)
    type(far_contact), intent(in) :: source                   !! has load
    real(real64), contiguous, intent(in) :: x(:), y(:)        !! of those who feel
    real(real64), contiguous, intent(inout) :: lift(:)        !! gets more
    real(real64), contiguous, intent(inout) :: tilt_x(:)      !! gets more
    real(real64), contiguous, intent(inout) :: tilt_y(:)      !! gets more
    real(real64), contiguous, intent(out) :: is_far(:)        !! 1; 0 where not: nothing felt
    real(real64) :: dx, dy, w, root, slope, limit, h2, h4, h6, x0, y0, load
    real(real64) :: squares(size(x))
    integer :: i

    h2 = source%circle**2 / 5
    h4 = 3 * source%circle**4 / 35
    h6 = source%circle**6 / 21
    limit = (far_from * source%circle)**2
    x0 = source%x
    y0 = source%y
    load = source%load
    do i = 1, size(x)
      squares(i) = (x(i) - x0)**2 + (y(i) - y0)**2
      is_far(i) = merge(1.0_real64, 0.0_real64, squares(i) > limit)
    end do
    do i = 1, size(x)
      dx = x(i) - x0
      dy = y(i) - y0
      w = 1.0_real64 / (squares(i) + (1.0_real64 - is_far(i)) * limit)
      root = is_far(i) * load * sqrt(w)
      lift(i) = lift(i) + root * (1.0_real64 + w * (0.5_real64 * h2 + w * (0.375_real64 * h4 + &
                w * 0.3125_real64 * h6)))
      slope = root * w * (1.0_real64 + w * (1.5_real64 * h2 + w * 1.875_real64 * h4))
      tilt_x(i) = tilt_x(i) - slope * dx
      tilt_y(i) = tilt_y(i) - slope * dy
    end do
  end subroutine feel_source

  !> What one contact with load and others with load feel of each other.
  pure subroutine share_field(one, x, y, circle, load, lift, tilt_x, tilt_y, is_far)
    type(far_contact), intent(inout) :: one                   !! gets what it feels
    real(real64), contiguous, intent(in) :: x(:), y(:)        !! of the others
    real(real64), contiguous, intent(in) :: circle(:)         !! of the others
    real(real64), contiguous, intent(in) :: load(:)           !! as in `one`
    real(real64), contiguous, intent(inout) :: lift(:)        !! gets more
    real(real64), contiguous, intent(inout) :: tilt_x(:)      !! gets more
    real(real64), contiguous, intent(inout) :: tilt_y(:)      !! gets more
    real(real64), contiguous, intent(out) :: is_far(:)        !! 1; 0 where not: nothing felt
    real(real64) :: dx, dy, rr, w, root, slope, limit, b, b2, a2, x0, y0, one_load
    real(real64) :: sum2, diff2, squares, products, mean, odd
    real(real64), dimension(size(x)) :: back, back_x, back_y
    integer :: i

    x0 = one%x
    y0 = one%y
    one_load = one%load
    b = one%circle
    b2 = b * b
    do i = 1, size(x)
      dx = x(i) - x0
      dy = y(i) - y0
      rr = dx * dx + dy * dy
      limit = (far_from * (circle(i) + b))**2
      is_far(i) = merge(1.0_real64, 0.0_real64, rr > limit)
      w = 1.0_real64 / max(rr, limit)
      root = is_far(i) * sqrt(w)
      ! The one who feels is a flat punch, its source has Hertz' weight: terms in the sum and in the
      ! difference of the squared radii, of which the last changes its sign for the other one.
      a2 = circle(i) * circle(i)
      sum2 = a2 + b2
      diff2 = a2 - b2
      squares = sum2 * sum2
      products = a2 * b2
      mean = 1.0_real64 + w * (even(1) * sum2 + w * (even(2) * squares + even(3) * products + &
             w * sum2 * (even(4) * squares + even(5) * products)))
      odd = w * diff2 * (uneven(1) + w * (uneven(2) * sum2 + &
            w * (uneven(3) * squares + uneven(4) * products)))
      lift(i) = lift(i) + one_load * (root * (mean + odd))
      back(i) = load(i) * (root * (mean - odd))
      ! For the slope both have Hertz' weight.
      slope = root * w * (1.0_real64 + w * (0.3_real64 * sum2 + &
              w * ((9.0_real64 / 56) * squares + (9.0_real64 / 70) * products)))
      dx = slope * dx
      dy = slope * dy
      tilt_x(i) = tilt_x(i) - one_load * dx
      tilt_y(i) = tilt_y(i) - one_load * dy
      back_x(i) = load(i) * dx
      back_y(i) = load(i) * dy
    end do
    one%lift = one%lift + total(back)
    one%tilt_x = one%tilt_x + total(back_x)
    one%tilt_y = one%tilt_y + total(back_y)
  end subroutine share_field

  ! A sum in four parts, always in this order.
  pure function total(parts) result(added)
    real(real64), contiguous, intent(in) :: parts(:)
    real(real64) :: added, four(4)
    integer :: i, n

    four = 0.0_real64
    n = size(parts) - modulo(size(parts), 4)
    do i = 1, n, 4
      four = four + parts(i:i + 3)
    end do
    added = (four(1) + four(2)) + (four(3) + four(4))
    do i = n + 1, size(parts)
      added = added + parts(i)
    end do
  end function total

end module asperity_coupled_far
