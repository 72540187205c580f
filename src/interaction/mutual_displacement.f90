!> What one contact's pressure does to another contact, for two circles anywhere in plan.
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
module asperity_mutual_displacement
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  implicit none
  private

  public :: mutual_terms, mutual_displacement
  public :: binomial, flat_means, hertz_means, root_terms, terms_kept

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
    real(real64) :: slope = 0.0_real64       !! d/dr of Hertz on one, mean of Hertz on the other
    real(real64) :: bend = 0.0_real64        !! d2/dr2 of the same
  end type mutual_terms

  !> Antiderivatives of 1/sqrt(r**2 - tau**2), and of their derivatives by r, at one tau.
  type :: antiderivatives
    real(real64) :: second = 0.0_real64      !! twice integrated
    real(real64) :: third = 0.0_real64       !! three times
    real(real64) :: fourth = 0.0_real64      !! four times
    real(real64) :: slope_third = 0.0_real64   !! d/dr of the third
    real(real64) :: slope_fourth = 0.0_real64  !! d/dr of the fourth
    real(real64) :: slope_fifth = 0.0_real64   !! d/dr of the fifth
    real(real64) :: slope_sixth = 0.0_real64   !! d/dr of the sixth
  end type antiderivatives

  ! Below this ratio of radii the differences of the closed forms lose digits; the smaller circle
  ! is then sampled at three points, whose error is below the sixth power of the ratio.
  real(real64), parameter :: small_ratio = 0.04_real64
  ! From so many sums of radii on the closed forms, made of differences of r**4, lose digits; seven
  ! terms of the series leave 1e-12 there.
  real(real64), parameter :: series_from = 4.0_real64
  !> Terms of the series behind the first.
  integer, parameter :: terms_kept = 6
  integer :: loop
  !> 1/sqrt(1 - z) in powers of z.
  real(real64), parameter :: root_terms(0:terms_kept) = &
    [1.0_real64, 0.5_real64, 0.375_real64, 0.3125_real64, 0.2734375_real64, 0.24609375_real64, &
     0.2255859375_real64]
  !> Means of t**(2 k) over a row of radius 1, of a flat punch.
  real(real64), parameter :: flat_means(0:terms_kept) = &
    [(1.0_real64 / (2 * loop + 1), loop=0, terms_kept)]
  !> The same with Hertz' weight.
  real(real64), parameter :: hertz_means(0:terms_kept) = &
    [(3.0_real64 / ((2 * loop + 1) * (2 * loop + 3)), loop=0, terms_kept)]
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
    type(mutual_terms), intent(out) :: terms !! the terms
    type(antiderivatives) :: far, near
    real(real64) :: a, b, bend, flat, hertz, scale, rim

    if (min(first, second) <= small_ratio * max(first, second)) then
      call with_small_circle(r, first, second, terms)
      return
    end if
    if (r > series_from * (first + second)) then
      call by_series(r, first, second, terms)
      return
    end if
    a = first
    b = second
    call integrate(r, a + b, far)
    call integrate(r, b - a, near)
    flat = 0.5_real64 / (pi * a * b)
    hertz = (4.5_real64 / (pi * a * b)) / (a * b)
    scale = 1.5_real64 / (pi * a * b)
    terms%compliance = flat * (far%second - near%second)
    terms%on_first = scale * ((far%third - near%third) - (far%fourth - near%fourth) / b) / b
    ! The same with the circles exchanged: odd antiderivatives change their sign at b - a.
    terms%on_second = scale * ((far%third + near%third) - (far%fourth - near%fourth) / a) / a
    rim = (scale / b) * (a / b) * (b * (far%second + near%second) - (far%third + near%third))
    terms%first_growth = rim - terms%on_first
    rim = (scale / a) * (b / a) * (a * (far%second + near%second) - (far%third - near%third))
    terms%second_growth = rim - terms%on_second
    terms%first_slope = (scale / b) * ((far%slope_third - near%slope_third) - &
                                       (far%slope_fourth - near%slope_fourth) / b)
    terms%second_slope = (scale / a) * ((far%slope_third + near%slope_third) - &
                                        (far%slope_fourth - near%slope_fourth) / a)
    terms%slope = hertz * ( &
      (far%slope_fourth + near%slope_fourth) - (far%slope_fifth - near%slope_fifth) / a - &
      (far%slope_fifth + near%slope_fifth) / b + &
      (far%slope_sixth - near%slope_sixth) / (a * b))
    ! The root is harmonic in r and i tau: its Laplacian in plan is its second derivative by tau.
    bend = hertz * ((far%second + near%second) - (far%third - near%third) / a - &
                    (far%third + near%third) / b + (far%fourth - near%fourth) / (a * b))
    terms%bend = 0.5_real64 * bend
    if (r > 0.0_real64) terms%bend = bend - terms%slope / r
  end subroutine mutual_displacement

  ! Circles well apart: the root in powers of tau/r, averaged term by term.
  pure subroutine by_series(r, first, second, terms)
    real(real64), intent(in) :: r, first, second
    type(mutual_terms), intent(out) :: terms
    real(real64), dimension(0:terms_kept) :: a, b
    real(real64) :: unit, mean, grown, bent
    integer :: k

    unit = 1.0_real64 / (pi * r)
    a(0) = 1.0_real64
    b(0) = 1.0_real64
    do k = 1, terms_kept
      a(k) = a(k - 1) * (first / r)**2
      b(k) = b(k - 1) * (second / r)**2
    end do
    terms%bend = 0.0_real64
    do k = terms_kept, 0, -1
      call average(k, flat_means, hertz_means, mean, grown)
      terms%on_first = terms%on_first + unit * mean
      terms%first_growth = terms%first_growth + unit * grown
      terms%first_slope = terms%first_slope - unit * (2 * k + 1) * mean / r
      call average(k, hertz_means, flat_means, mean, grown)
      terms%on_second = terms%on_second + unit * mean
      terms%second_slope = terms%second_slope - unit * (2 * k + 1) * mean / r
      ! By its own radius: what is left of the degree 2 k.
      terms%second_growth = terms%second_growth + unit * (2 * k * mean - grown)
      call average(k, flat_means, flat_means, mean, grown)
      terms%compliance = terms%compliance + unit * mean
      call average(k, hertz_means, hertz_means, mean, grown)
      terms%slope = terms%slope - unit * (2 * k + 1) * mean / r
      bent = unit * (2 * k + 1) * (2 * k + 2) * mean / r**2
      terms%bend = terms%bend + bent
    end do

  contains

    ! Mean of the k-th term over two rows, and its derivative by the log of the first radius.
    pure subroutine average(k, first_means, second_means, mean, grown)
      integer, intent(in) :: k
      real(real64), intent(in) :: first_means(0:), second_means(0:)
      real(real64), intent(out) :: mean, grown
      real(real64) :: part
      integer :: m

      mean = 0.0_real64
      grown = 0.0_real64
      do m = 0, k
        part = root_terms(k) * binomial(m, k) * (a(m) * first_means(m)) * &
               (b(k - m) * second_means(k - m))
        mean = mean + part
        grown = grown + 2 * m * part
      end do
    end subroutine average

  end subroutine by_series

  ! The antiderivatives at tau. Beyond r the root is zero, so that they are polynomials there:
  ! the same expressions with the arc at its end and no root.
  pure subroutine integrate(r, tau, values)
    real(real64), intent(in) :: r, tau
    type(antiderivatives), intent(out) :: values
    real(real64) :: arc, root, cube, rr, tt

    if (abs(tau) >= r) then
      arc = sign(0.5_real64 * pi, tau)
      root = 0.0_real64
    else
      root = sqrt((r - tau) * (r + tau))
      arc = atan2(tau, root)
    end if
    rr = r * r
    tt = tau * tau
    cube = root * root * root
    values%second = tau * arc + root
    values%third = (tt / 2 + rr / 4) * arc + 0.75_real64 * tau * root
    values%fourth = tau * (tt / 6 + rr / 4) * arc + (11 * tt / 36 + rr / 9) * root
    values%slope_third = 0.5_real64 * r * arc
    values%slope_fourth = 0.5_real64 * r * (tau * arc + root)
    values%slope_fifth = 0.5_real64 * r * ((tt / 2 + rr / 8) * arc + 0.625_real64 * tau * root)
    values%slope_sixth = 0.5_real64 * r * (tau * (tt / 6 + rr / 8) * arc + 7 * rr * root / 24)
    ! What is left of the first of them has r below the line and vanishes with it.
    if (.not. root > 0.0_real64) return
    values%slope_third = values%slope_third + tau * root / (2 * r)
    values%slope_fourth = values%slope_fourth - cube / (6 * r)
    values%slope_fifth = values%slope_fifth - tau * cube / (24 * r)
    values%slope_sixth = values%slope_sixth - 19 * r * cube / 144 + cube * root**2 / (120 * r)
  end subroutine integrate

  ! One circle is much smaller, or a point: its means over a few places.
  pure subroutine with_small_circle(r, first, second, terms)
    real(real64), intent(in) :: r, first, second
    type(mutual_terms), intent(out) :: terms
    ! Gauss' three points for a flat punch (Legendre) and for Hertz' weight 1 - t**2 (Gegenbauer).
    real(real64), parameter :: legendre_place = sqrt(0.6_real64)
    real(real64), parameter :: legendre_weight = 5.0_real64 / 18
    real(real64), parameter :: gegenbauer_place = sqrt(3.0_real64 / 7)
    real(real64), parameter :: gegenbauer_weight = 7.0_real64 / 30
    real(real64) :: a, b, hertz, hertz_aside, hertz_rim, flat, flat_aside, flat_rim, slope
    real(real64) :: flat_hertz, slope_aside, by_flat_rim, flat_of_small, place, hertz_slope
    real(real64) :: flat_slope, outside
    logical :: first_is_small

    first_is_small = first < second
    a = min(first, second)
    b = max(first, second)
    call field_at(r, b, 0.0_real64, hertz, flat, slope)
    place = legendre_place * a
    call field_at(r, b, place, hertz_aside, flat_aside, slope_aside)
    ! Fields of the large circle, mean over the small one as a flat punch.
    hertz = hertz + 2 * legendre_weight * (hertz_aside - hertz)
    flat_of_small = flat + 2 * legendre_weight * (flat_aside - flat)
    hertz_slope = slope + 2 * legendre_weight * (slope_aside - slope)
    terms%compliance = flat_of_small
    call field_at(r, b, a, hertz_rim, flat_rim, slope_aside)
    place = gegenbauer_place * a
    call field_at(r, b, place, hertz_aside, flat_aside, slope_aside)
    flat_hertz = flat + 2 * gegenbauer_weight * (flat_aside - flat)
    terms%slope = slope + 2 * gegenbauer_weight * (slope_aside - slope)
    ! Only Newton's method needs these: those at a point.
    terms%bend = -0.75_real64 / b**3
    flat_slope = 0.0_real64
    if (r > b) then
      outside = max(sqrt((r - b) * (r + b)), a, 1.0e-6_real64 * b)
      terms%bend = 1.5_real64 / (pi * b**3) * &
                   (b / outside * (1.0_real64 + (b / r)**2) - atan2(b, outside))
      flat_slope = -1.0_real64 / (pi * r * outside)
    end if
    ! Hertz on the small circle, felt by the large: its rim is where the small circle's row ends.
    by_flat_rim = hertz_of_small(r, a, b)
    if (first_is_small) then
      terms%on_first = hertz
      terms%first_growth = hertz_rim - hertz
      terms%on_second = flat_hertz
      terms%first_slope = hertz_slope
      terms%second_slope = flat_slope
      terms%second_growth = by_flat_rim - flat_hertz
    else
      terms%on_second = hertz
      terms%second_growth = hertz_rim - hertz
      terms%on_first = flat_hertz
      terms%first_slope = flat_slope
      terms%second_slope = hertz_slope
      terms%first_growth = by_flat_rim - flat_hertz
    end if
  end subroutine with_small_circle

  ! Rim value of the row of the small circle's Hertz pressure at the end of the large flat row.
  pure function hertz_of_small(r, a, b) result(value)
    real(real64), intent(in) :: r, a, b
    real(real64) :: value, outside

    ! A point load is close enough: this only helps Newton's method along.
    outside = (r - b) * (r + b)
    value = 0.0_real64
    if (outside > a * b) value = 1.0_real64 / (pi * sqrt(outside))
  end function hertz_of_small

  ! Rows of the large circle seen from one place t of the small circle's row.
  pure subroutine field_at(r, b, t, hertz, flat, slope)
    real(real64), intent(in) :: r, b, t
    real(real64), intent(out) :: hertz, flat, slope
    real(real64) :: arc(2), root(2), tau(2), third(2), slope_third(2)
    integer :: k

    tau = [b + t, b - t]
    do k = 1, 2
      if (tau(k) >= r) then
        arc(k) = 0.5_real64 * pi
        root(k) = 0.0_real64
      else
        root(k) = sqrt((r - tau(k)) * (r + tau(k)))
        arc(k) = atan2(tau(k), root(k))
      end if
      third(k) = (tau(k)**2 / 2 + r**2 / 4) * arc(k) + 0.75_real64 * tau(k) * root(k)
      slope_third(k) = 0.5_real64 * r * arc(k)
      if (root(k) > 0.0_real64) then
        slope_third(k) = slope_third(k) + root(k) * (0.5_real64 * tau(k) - b) / r
      end if
    end do
    ! With t and -t together, third(2) stands for the odd function at t - b.
    hertz = 1.5_real64 / (pi * b**2) * &
            ((tau(1) * arc(1) + root(1)) + (tau(2) * arc(2) + root(2)) - (third(1) + third(2)) / b)
    flat = (arc(1) + arc(2)) / (2 * pi * b)
    slope = -1.5_real64 / (pi * b**3) * (slope_third(1) + slope_third(2))
  end subroutine field_at

end module asperity_mutual_displacement
