!> The adhering contact between soft and stiff: Maugis (1992), with Dugdale's constant attraction.
!>
!> The surfaces attract each other with a constant stress where they are less than h0 apart. They
!> touch within a radius a and attract within c = a/cos(v). Units are those of Maugis: contact
!> radius (pi w R**2/K)**(1/3), load pi w R, overlap (pi**2 w**2 R/K**2)**(1/3), K = 4/3 E; h0 is
!> 2/(pi lambda). With v = arcsec(c/a) the equations are
!>
!>     1       = lambda/2 c**2 (sin v cos v - v cos 2v) + 4/3 lambda**2 c (v sin v - 1 + cos v)
!>     load    = (c cos v)**3 - lambda c**2 (sin v cos v + v)
!>     overlap = (c cos v)**2 - 4/3 lambda c sin v
!>
!> so c follows from v by a quadratic equation and the curve has one parameter, s = sin v. At s = 1
!> the contact radius is 0 and the attraction acts across a gap (Johnson and Greenwood 1997; the
!> edge of a circle under constant stress: Johnson 1985, section 3.4(a))
!>
!>     overlap = c**2/2 - k c - h0,   k = 8 lambda/(3 pi),   load = -pi/2 lambda c**2
!>
!> The limits of the curve are that of Johnson, Kendall and Roberts for large lambda, that of
!> Derjaguin, Muller and Toporov for small lambda.
module asperity_adhesion_maugis
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  implicit none
  private

  public :: central_answer, maugis_curve, new_maugis, follow_maugis

  ! Chosen: bounds the iterations, each of which halves the bracket at least.
  integer, parameter :: most_turns = 200

  !> The curve of one lambda, dimensionless.
  type :: maugis_curve
    real(real64) :: lambda = 1.0_real64     !! 1.157 times the Tabor parameter
    real(real64) :: last = 1.0_real64       !! s of the least overlap, or 1
    real(real64) :: snap_in = 0.0_real64    !! overlap from which the attraction acts, -h0
    real(real64) :: snap_off = 0.0_real64   !! least overlap
    real(real64) :: touching = 0.0_real64   !! least overlap with a contact circle
    real(real64) :: pull_off = 0.0_real64   !! largest tensile load, 1.5 to 2
  end type maugis_curve

  !> One point of a curve, along the line of centres.
  type :: central_answer
    real(real64) :: contact_radius = 0.0_real64  !! 0 across a gap
    real(real64) :: load = 0.0_real64            !! < 0 in tension
    real(real64) :: stiffness = 0.0_real64       !! d load/d overlap
    real(real64) :: pressure = 0.0_real64        !! at the centre of the contact circle, or 0
  end type central_answer

  ! The point of a parameter s, with its slopes.
  type :: curve_point
    real(real64) :: angle = 0.0_real64
    real(real64) :: cosine = 1.0_real64
    real(real64) :: outer = 0.0_real64          ! c
    real(real64) :: overlap = 0.0_real64
    real(real64) :: load = 0.0_real64
    real(real64) :: overlap_slope = 0.0_real64  ! d overlap/ds
    real(real64) :: load_slope = 0.0_real64     ! d load/ds
  end type curve_point

contains

  !> Finds the ends of the curve of a lambda and its largest tensile load.
  pure subroutine new_maugis(lambda, curve)
    real(real64), intent(in) :: lambda         !! parameter lambda, 0.01 to 100
    type(maugis_curve), intent(out) :: curve   !! ends of the curve
    type(curve_point) :: at
    real(real64) :: high

    curve%lambda = lambda
    curve%snap_in = -2.0_real64 / (pi * lambda)
    at = point_at(lambda, 1.0_real64)
    curve%touching = at%overlap
    curve%snap_off = curve%snap_in - 0.5_real64 * (8.0_real64 * lambda / (3.0_real64 * pi))**2
    ! The overlap decreases with s up to its least value, which has a contact circle if the overlap
    ! increases at s = 1. The load decreases with s up to the largest tensile load.
    if (at%overlap_slope > 0.0_real64) then
      call find_slope_end(lambda, .false., curve%last, at)
      at = point_at(lambda, curve%last)
      curve%touching = at%overlap
      curve%snap_off = at%overlap
    end if
    high = curve%last
    call find_slope_end(lambda, .true., high, at)
    curve%pull_off = -at%load
  end subroutine new_maugis

  ! Finds, between 0 and `bound`, the s up to which the slope of the load or of the overlap is not
  ! positive: false position with the Illinois rule, every eighth step a bisection; `at` is the last
  ! point.
  pure subroutine find_slope_end(lambda, of_load, bound, at)
    real(real64), intent(in) :: lambda
    logical, intent(in) :: of_load
    real(real64), intent(inout) :: bound
    type(curve_point), intent(inout) :: at
    real(real64) :: high, s, slope, slopes(2)
    integer :: side, turn

    high = bound
    bound = 0.0_real64
    slopes = 0.0_real64
    side = 0
    do turn = 1, most_turns
      s = bound + 0.5_real64 * (high - bound)
      if (modulo(turn, 8) > 0 .and. slopes(1) < 0.0_real64 .and. slopes(2) > 0.0_real64) &
        s = bound - (high - bound) * (slopes(1) / (slopes(2) - slopes(1)))
      if (.not. (s > bound .and. s < high)) exit
      at = point_at(lambda, s)
      slope = merge(at%load_slope, at%overlap_slope, of_load)
      if (slope > 0.0_real64) then
        high = s
        slopes(2) = slope
        if (side > 0) slopes(1) = 0.5_real64 * slopes(1)
        side = 1
      else
        bound = s
        slopes(1) = slope
        if (side < 0) slopes(2) = 0.5_real64 * slopes(2)
        side = -1
      end if
    end do
  end subroutine find_slope_end

  !> Response at an overlap, dimensionless; the unit of the pressure is E a/(pi R) with the unit of
  !> the contact radius for a.
  pure subroutine follow_maugis(curve, overlap, answer)
    type(maugis_curve), intent(in) :: curve     !! curve of the contact's lambda
    real(real64), intent(in) :: overlap         !! overlap, not below `snap_off`
    type(central_answer), intent(out) :: answer !! point of the curve
    type(curve_point) :: at
    real(real64) :: edge, root

    ! Where the least overlap has a contact circle, an overlap below it is due to rounding.
    if (overlap < curve%touching .and. .not. curve%last < 1.0_real64) then
      edge = 8.0_real64 * curve%lambda / (3.0_real64 * pi)
      root = sqrt(max(edge**2 + 2.0_real64 * (overlap - curve%snap_in), 0.0_real64))
      answer%load = -0.5_real64 * pi * curve%lambda * (edge + root)**2
      answer%stiffness = -pi * curve%lambda * (edge + root) / &
                         max(root, epsilon(root) * edge)
      return
    end if
    at = point_at(curve%lambda, parameter_at(curve, overlap))
    answer%contact_radius = at%outer * at%cosine
    answer%load = at%load
    answer%stiffness = at%load_slope / min(at%overlap_slope, -epsilon(root))
    answer%pressure = 2.0_real64 * answer%contact_radius - &
                      (4.0_real64 / 3.0_real64) * curve%lambda * at%angle
  end subroutine follow_maugis

  ! The parameter s at an overlap, by Newton's method for log(s) within a shrinking bracket. The
  ! inverse hyperbolic sine of the overlap is nearly linear in log(s); the last steps solve for the
  ! overlap itself.
  pure function parameter_at(curve, overlap) result(s)
    type(maugis_curve), intent(in) :: curve
    real(real64), intent(in) :: overlap
    type(curve_point) :: at
    real(real64) :: s, low, high, radius, error, next
    integer :: turn

    low = 0.0_real64
    high = curve%last
    radius = sqrt(max(overlap, 1.0_real64))
    s = min((1.5_real64 / (curve%lambda * radius**2))**(1.0_real64 / 3.0_real64), &
            sqrt(1.5_real64 / radius) / curve%lambda, 0.9_real64 * high)
    do turn = 1, most_turns
      at = point_at(curve%lambda, s)
      error = at%overlap - overlap
      if (error > 0.0_real64) then
        low = s
      else
        high = s
      end if
      if (abs(error) > 0.01_real64 * (1.0_real64 + abs(overlap))) then
        error = (asinh(at%overlap) - asinh(overlap)) * hypot(1.0_real64, at%overlap)
        next = s * exp(min(-error / min(s * at%overlap_slope, -tiny(s)), 2.0_real64))
      else
        next = s - error / min(at%overlap_slope, -tiny(s))
      end if
      if (.not. abs(next - s) > 0.5_real64 * epsilon(s) * s) exit
      if (next > low .and. next < high) then
        s = next
      else
        next = low + 0.5_real64 * (high - low)
        if (.not. (next > low .and. next < high)) exit
        s = next
      end if
    end do
  end function parameter_at

  ! The point of a parameter. Slopes by s are regular up to s = 1, slopes by the angle are not.
  pure function point_at(lambda, s) result(at)
    real(real64), intent(in) :: lambda, s
    type(curve_point) :: at
    real(real64) :: square, linear, c, change

    at%angle = asin(s)
    at%cosine = sqrt((1.0_real64 - s) * (1.0_real64 + s))
    associate (v => at%angle, cosine => at%cosine)
      square = 0.25_real64 * lambda * sine_less_arc(2.0_real64 * v)
      linear = (4.0_real64 / 3.0_real64) * lambda**2 * (v * s - s**2 / (1.0_real64 + cosine))
      c = 2.0_real64 / (linear + sqrt(linear**2 + 4.0_real64 * square))
      change = -2.0_real64 * lambda * v * (s * c + (2.0_real64 / 3.0_real64) * lambda) * c / &
               (2.0_real64 * square * c + linear)
      at%outer = c
      at%overlap = (c * cosine)**2 - (4.0_real64 / 3.0_real64) * lambda * c * s
      at%load = (c * cosine)**3 - lambda * c**2 * (s * cosine + v)
      at%overlap_slope = 2.0_real64 * c * (change * cosine**2 - c * s) - &
                         (4.0_real64 / 3.0_real64) * lambda * (change * s + c)
      at%load_slope = 3.0_real64 * c**2 * cosine * (change * cosine**2 - c * s) - &
                      2.0_real64 * lambda * c * (change * (s * cosine + v) + c * cosine)
    end associate
  end function point_at

  ! sin(x) - x cos(x), by its series where the terms cancel.
  pure function sine_less_arc(x) result(value)
    real(real64), intent(in) :: x
    real(real64) :: value, term
    integer :: n

    if (x > 1.5_real64) then
      value = sin(x) - x * cos(x)
      return
    end if
    term = x**3 / 6.0_real64
    value = 2.0_real64 * term
    do n = 2, 12
      term = -term * x**2 / real(2 * n * (2 * n + 1), real64)
      value = value + 2 * n * term
    end do
  end function sine_less_arc

end module asperity_adhesion_maugis
