!> Displacement of one contact by the pressure of another, for two circles anywhere in plan.
!>
!> A unit load with Hertz' pressure on a circle of radius b lifts the surface around it; a contact
!> of radius a feels that field through its mean with the weight of a flat punch,
!> 1/(2 pi a sqrt(a**2 - rho**2)): by the reciprocal theorem this mean is, to first order, the exact
!> loss of approach. The field itself is Johnson, Contact Mechanics (1985), eq. 3.41 and 3.42.
!>
!> All means are one integral. In Hankel transforms the flat punch is a uniform row of cosines
!> cos(k t), |t| < a, Hertz' pressure a row with the weight 3 (b**2 - t**2)/(4 b**3), and the
!> integral of J0(k r) cos(k tau) over k is 1/sqrt(r**2 - tau**2) for |tau| < r, else zero
!> (Sneddon, Mixed Boundary Value Problems, 1966). So pi E times a mean is that root averaged over
!> tau = t1 + t2, with closed antiderivatives, and holds for circles that overlap as well.
!>
!> The rows make Hertz' mean, with a third of its growth with the radius, that of a flat punch; and
!> all means are over the distance, so that their growths with both radii make up for their slope:
!> growths follow from means and slopes.
module asperity_mutual_displacement
  use asperity_constants, only: pi, pi_128
  use asperity_kinds, only: real128, real64
  implicit none
  private

  public :: mutual_terms, mutual_displacement, oval_field

  !> The terms between a first circle and a second. All are for a modulus of 1 and are to be
  !> divided by the combined modulus; per unit load.
  type :: mutual_terms
    real(real64) :: on_first = 0.0_real64    !! displacement of the first by Hertz on the second
    real(real64) :: on_second = 0.0_real64   !! displacement of the second by Hertz on the first
    real(real64) :: first_growth = 0.0_real64   !! d(on_first)/d(log of first radius)
    real(real64) :: second_growth = 0.0_real64  !! d(on_second)/d(log of second radius)
    real(real64) :: compliance = 0.0_real64  !! flat punch on one, mean of a flat punch on the other
    real(real64) :: first_slope = 0.0_real64   !! d(on_first)/dr
    real(real64) :: second_slope = 0.0_real64  !! d(on_second)/dr
    real(real64) :: mean = 0.0_real64        !! Hertz on one, mean with Hertz' weight on the other
    real(real64) :: slope = 0.0_real64       !! d/dr of the same
    real(real64) :: bend = 0.0_real64        !! d2/dr2 of the same
  end type mutual_terms

  ! Ratio of radii [1] below which the closed forms, which lose digits with its third power, are
  ! found with twice the digits: 3e-12 are left of 2e-16; derived. Below the root of the rounding
  ! error the smaller circle is a point.
  real(real64), parameter :: small_ratio = 0.04_real64
  ! Distance over the sum of radii [1] from which on the closed forms, made of differences of r**4,
  ! lose digits: seven terms of the series leave 1e-12 there; derived; test: mutual_suite.f90.
  real(real64), parameter :: series_distance = 4.0_real64
  !> 1/sqrt(1 - z) in powers of z.
  real(real64), parameter :: root_terms(0:*) = &
    [1.0_real64, 0.5_real64, 0.375_real64, 0.3125_real64, 0.2734375_real64, 0.24609375_real64, &
     0.2255859375_real64]
  !> Terms of the series behind the first.
  integer, parameter :: terms_kept = ubound(root_terms, 1)
  integer :: loop
  !> Means of t**(2 k) over a row of radius 1: of a flat punch, with Hertz' weight; derived.
  real(real64), parameter :: row_means(2, 0:terms_kept) = reshape( &
    [(1.0_real64 / (2 * loop + 1), 3.0_real64 / ((2 * loop + 1) * (2 * loop + 3)), &
      loop=0, terms_kept)], [2, terms_kept + 1])
  !> Even places of Pascal's triangle, by 2 k and 2 m.
  real(real64), parameter :: binomial(0:terms_kept, 0:terms_kept) = reshape(real([ &
    1, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 1, 6, 1, 0, 0, 0, 0, 1, 15, 15, 1, 0, 0, 0, &
    1, 28, 70, 28, 1, 0, 0, 1, 45, 210, 210, 45, 1, 0, 1, 66, 495, 924, 495, 66, 1], real64), &
    [terms_kept + 1, terms_kept + 1])

contains

  !> All terms between two circles.
  pure subroutine mutual_displacement(r, first, second, terms)
    real(real64), intent(in) :: r            !! distance of the centres, 0 or more
    real(real64), intent(in) :: first        !! radius of the first circle, 0 or more
    real(real64), intent(in) :: second       !! radius of the second circle; one is more than 0
    type(mutual_terms), intent(out) :: terms  !! terms between both circles
    real(real64) :: means(2, 2, 0:1), bend, ratio

    ratio = min(first, second) / max(first, second)
    if (r > series_distance * (first + second)) then
      call by_series(r, first, second, means, bend)
    else if (ratio < sqrt(epsilon(ratio))) then
      call with_a_point(r, max(first, second), means, bend)
      ! The field of the larger alone, by its own pressure.
      if (first > second) means = reshape(means, shape(means), order=[2, 1, 3])
    else if (ratio < small_ratio) then
      call closed_form_128(r, first, second, means, bend)
    else
      call closed_form_64(r, first, second, means, bend)
    end if
    terms%compliance = means(1, 1, 0)
    terms%on_first = means(1, 2, 0)
    terms%on_second = means(2, 1, 0)
    terms%mean = means(2, 2, 0)
    terms%first_slope = means(1, 2, 1)
    terms%second_slope = means(2, 1, 1)
    terms%slope = means(2, 2, 1)
    terms%bend = bend
    terms%first_growth = 2 * terms%on_first - 3 * terms%compliance - r * terms%first_slope
    terms%second_growth = 2 * terms%on_second - 3 * terms%compliance - r * terms%second_slope
  end subroutine mutual_displacement

  ! The following find means, and their derivatives by r, for a flat punch (1) or Hertz' pressure
  ! (2) on the first circle, then on the second; and the second derivative for Hertz with Hertz.
  pure subroutine closed_form_64(r_in, first, second, means, bend)
    integer, parameter :: kind_of_real = real64
#include "mutual_closed_form.inc"
  end subroutine closed_form_64

  pure subroutine closed_form_128(r_in, first, second, means, bend)
    integer, parameter :: kind_of_real = real128
#include "mutual_closed_form.inc"
  end subroutine closed_form_128

  ! Circles well apart: the root in powers of tau/r, averaged term by term.
  pure subroutine by_series(r, first, second, means, bend)
    real(real64), intent(in) :: r, first, second
    real(real64), intent(out) :: means(2, 2, 0:1), bend
    real(real64) :: a(2, 0:terms_kept), b(2, 0:terms_kept), power(2), term(2, 2)
    integer :: k, m

    ! Powers of the radii over the distance, with the means.
    power = 1.0_real64
    do k = 0, terms_kept
      a(:, k) = power(1) * row_means(:, k)
      b(:, k) = power(2) * row_means(:, k)
      power = power * ([first, second] / r)**2
    end do
    means = 0.0_real64
    bend = 0.0_real64
    do k = terms_kept, 0, -1
      term = 0.0_real64
      do m = 0, k
        term(:, 1) = term(:, 1) + binomial(m, k) * b(1, k - m) * a(:, m)
        term(:, 2) = term(:, 2) + binomial(m, k) * b(2, k - m) * a(:, m)
      end do
      term = root_terms(k) / (pi * r) * term
      means(:, :, 0) = means(:, :, 0) + term
      means(:, :, 1) = means(:, :, 1) - (2 * k + 1) / r * term
      bend = bend + (2 * k + 1) * (2 * k + 2) / r**2 * term(2, 2)
    end do
  end subroutine by_series

  ! The first circle is a point: the fields of the other at it (Johnson 1985, eq. 3.41 and 3.42).
  pure subroutine with_a_point(r, b, means, bend)
    real(real64), intent(in) :: r, b
    real(real64), intent(out) :: means(2, 2, 0:1), bend
    real(real64) :: arc, outside, root

    ! Inside there is no root; just outside some slopes have no bound.
    root = sqrt(max(0.0_real64, (r - b) * (r + b)))
    arc = atan2(b, root)
    outside = merge(1.0_real64 / max(root, sqrt(epsilon(b)) * b), 0.0_real64, r > b)
    means(:, 1, 0) = arc / (pi * b)
    means(:, 2, 0) = 0.75_real64 / (pi * b**3) * ((2 * b**2 - r**2) * arc + b * root)
    means(:, 1, 1) = -outside / (pi * max(r, b))
    means(:, 2, 1) = -1.5_real64 / (pi * b**3) * (r * arc - b * root / max(r, b))
    bend = -1.5_real64 / (pi * b**3) * (arc - b * outside * (1.0_real64 + (b / max(r, b))**2))
  end subroutine with_a_point

  !> Oval field on a circle, by a unit load over the modulus on another one: with Hertz' pressure,
  !> and with that of a flat punch.
  !>
  !> It is the mean of G'' - G'/r with the weight (1 - rho**2/a**2)**(3/2), G the displacement: the
  !> part of the field that makes a contact oval. The weight is the row
  !> 15 (a**2 - t**2)**2/(16 a**5), and as the root is harmonic in r and i tau its second derivative
  !> by r is that by tau less its derivative by r over r. The closed form is in error by 4e-7 of it
  !> for radii to 1:10, by 3e-5 at 1:25. Of other radii it is the series, in error where the rims
  !> nearly touch; within the rim of the other circle the field is left out.
  pure function oval_field(distance, averaged, loaded) result(field)
    real(real64), intent(in) :: distance   !! distance of the centres [length]
    real(real64), intent(in) :: averaged   !! radius of the circle with the mean, more than 0
    real(real64), intent(in) :: loaded     !! radius of the loaded circle, more than 0
    integer, parameter :: kind_of_real = real64
    real(real64) :: field(2), a, b, factor, r, unit
    real(real64), dimension(8, 0:1) :: far, near, plus, minus

    ! A power of two as unit of length changes no digit; fifth powers of a radius would underflow.
    unit = scale(1.0_real64, exponent(averaged + loaded))
    r = distance / unit
    a = averaged / unit
    b = loaded / unit
    field = 0.0_real64
    if (r > series_distance * (a + b) .or. min(a, b) < small_ratio * max(a, b)) then
      if (r > a + b) field = oval_by_series(r, a, b) / unit**3
      return
    end if
    if (.not. r > 0.0_real64) return
    call integrate(a + b, far)
    call integrate(a - b, near)
    plus = far + near
    minus = far - near
    factor = 15.0_real64 / (16 * a**5 * pi)
    factor = factor / unit**3
    field(1) = 1.5_real64 * factor / b**3 * ( &
      over_row([b * plus(3:5, 0) - minus(4:6, 0)]) - &
      2 / r * over_row([b * plus(5:7, 1) - minus(6:8, 1)]))
    field(2) = 0.5_real64 * factor / b * (over_row(minus(2:4, 0)) - &
                                          2 / r * over_row(minus(4:6, 1)))

  contains

    ! Three times by parts over the row (a**2 - t**2)**2, by antiderivatives at its end.
    pure real(real64) function over_row(values)
      real(real64), intent(in) :: values(3)

      over_row = 16 * (a**2 * values(1) - 3 * a * values(2) + 3 * values(3))
    end function over_row

#include "antiderivatives.inc"
  end function oval_field

  ! The oval field of circles apart, as in `by_series`.
  pure function oval_by_series(r, a, b) result(field)
    real(real64), intent(in) :: r, a, b
    real(real64) :: field(2), averaged(0:terms_kept), loaded(2, 0:terms_kept)
    integer :: k, m

    do k = 0, terms_kept
      averaged(k) = 15.0_real64 / ((2 * k + 1) * (2 * k + 3) * (2 * k + 5)) * (a / r)**(2 * k)
      loaded(:, k) = row_means([2, 1], k) * (b / r)**(2 * k)
    end do
    field = 0.0_real64
    do k = 0, terms_kept
      do m = 0, k
        field = field + root_terms(k) * (2 * k + 1) * (2 * k + 3) * binomial(m, k) * averaged(m) * &
                loaded(:, k - m)
      end do
    end do
    field = field / (pi * r**3)
  end function oval_by_series

end module asperity_mutual_displacement
