!> Curvature of the field of one contact along the line of centres less that across, on another.
!>
!> The mean of G'' - G'/r over a circle of radius a with the weight (1 - rho**2/a**2)**(3/2), G the
!> displacement by a unit load on a circle of radius b: the part of the field that makes a contact
!> oval. Method: rows, as in mutual_displacement. The weight is the row
!> 15 (a**2 - t**2)**2/(16 a**5), and as the root is harmonic in r and i tau its second derivative
!> by r is that by tau less its derivative by r over r.
module asperity_oval_field
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  implicit none
  private

  public :: oval_field

  ! Distance over the sum of radii [1] from which on the series leaves less than 1e-7; derived.
  real(real64), parameter :: series_distance = 2.5_real64
  ! Terms of the series behind the first [1]; derived.
  integer, parameter :: terms_kept = 8
  ! Ratio of the radii [1] below which the closed form has no digits: the field is then that of the
  ! series, and left out at less than `rim_distance` sums of radii, where the load of the smaller
  ! circle is below 1e-5 of that of the larger one; derived.
  real(real64), parameter :: small_ratio = 0.02_real64, rim_distance = 1.02_real64

contains

  !> Oval field on a circle, by a unit load over the modulus: with Hertz' pressure, and with that of
  !> a flat punch.
  pure function oval_field(distance, averaged, loaded) result(field)
    real(real64), intent(in) :: distance   !! distance of the centres [length]
    real(real64), intent(in) :: averaged   !! radius of the circle with the mean, more than 0
    real(real64), intent(in) :: loaded     !! radius of the loaded circle, more than 0
    real(real64) :: field(2), a, b, factor, r, unit
    real(real64), dimension(8, 2) :: far, near, plus, minus

    ! A power of two as unit of length changes no digit; fifth powers of a radius would underflow.
    unit = scale(1.0_real64, exponent(averaged + loaded))
    r = distance / unit
    a = averaged / unit
    b = loaded / unit
    field = 0.0_real64
    if (r > series_distance * (a + b) .or. min(a, b) < small_ratio * max(a, b)) then
      if (r > rim_distance * (a + b)) field = by_series(r, a, b) / unit**3
      return
    end if
    if (.not. r > 0.0_real64) return
    call integrate(r, a + b, far)
    call integrate(r, a - b, near)
    plus = far + near
    minus = far - near
    factor = 15.0_real64 / (16 * a**5 * pi)
    factor = factor / unit**3
    field(1) = 1.5_real64 * factor / b**3 * ( &
      over_row([b * plus(3:5, 1) - minus(4:6, 1)]) - &
      2 / r * over_row([b * plus(5:7, 2) - minus(6:8, 2)]))
    field(2) = 0.5_real64 * factor / b * (over_row(minus(2:4, 1)) - &
                                          2 / r * over_row(minus(4:6, 2)))

  contains

    ! Three times by parts over the row (a**2 - t**2)**2, by antiderivatives at its end.
    pure real(real64) function over_row(values)
      real(real64), intent(in) :: values(3)

      over_row = 16 * (a**2 * values(1) - 3 * a * values(2) + 3 * values(3))
    end function over_row

  end function oval_field

  ! Antiderivatives at tau of 1/sqrt(r**2 - tau**2), and their derivatives by r (see
  ! mutual_closed_form.inc).
  pure subroutine integrate(r, tau, values)
    real(real64), intent(in) :: r, tau
    real(real64), intent(out) :: values(8, 2)
    real(real64) :: root, square
    integer :: n

    square = (r - tau) * (r + tau)
    root = sqrt(max(square, 0.0_real64))
    values(1, 1) = atan2(tau, root)
    values(2, 1) = tau * values(1, 1) + root
    values(3, 1) = (3 * tau * values(2, 1) + square * values(1, 1)) / 4
    values(1, 2) = 0.0_real64
    values(2, 2) = root / r
    values(3, 2) = 0.5_real64 * (tau * values(2, 2) + r * values(1, 1))
    if (.not. square > 0.0_real64) values(2, 2) = 0.0_real64
    do n = 3, 7
      values(n + 1, :) = (2 * n - 1) * tau * values(n, :) + square * values(n - 1, :)
      values(n + 1, 2) = values(n + 1, 2) + 2 * r * values(n - 1, 1)
      values(n + 1, :) = values(n + 1, :) / n**2
    end do
  end subroutine integrate

  ! Circles apart: the root in powers of tau/r, averaged term by term.
  pure function by_series(r, a, b) result(field)
    real(real64), intent(in) :: r, a, b
    real(real64) :: field(2), weight, binomial, row, loaded(2, 0:terms_kept)
    integer :: k, m

    do k = 0, terms_kept
      loaded(:, k) = [3.0_real64 / (2 * k + 3), 1.0_real64] / (2 * k + 1) * (b / r)**(2 * k)
    end do
    field = 0.0_real64
    weight = 1.0_real64 / (pi * r**3)
    do k = 0, terms_kept
      binomial = weight * (2 * k + 1) * (2 * k + 3)
      do m = 0, k
        row = 15.0_real64 / ((2 * m + 1) * (2 * m + 3) * (2 * m + 5)) * (a / r)**(2 * m)
        field = field + binomial * row * loaded(:, k - m)
        binomial = binomial * (2 * k - 2 * m) * (2 * k - 2 * m - 1) / ((2 * m + 1) * (2 * m + 2))
      end do
      weight = weight * (2 * k + 1) / (2 * k + 2)
    end do
  end function by_series

end module asperity_oval_field
