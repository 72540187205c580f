!> Overlap of two spheres, one above the other, without cancellation.
!>
!> Their centres are s apart when they touch, d apart in plan, so zc = sqrt(s**2 - d**2) apart in
!> height. After a vertical penetration p the overlap is W = s - sqrt(d**2 + (zc - p)**2), with
!> cancellation when it is small. Multiplied by its conjugate it is
!> W = p (2 zc - p)/(s + sqrt(d**2 + (zc - p)**2)).
module asperity_sphere_overlap
  use asperity_kinds, only: real64
  implicit none
  private

  public :: stable_overlap, touching_height

contains

  !> Height between the centres at first touch, and its rounding error. Without this rest the
  !> overlap of a pair with nearly level centres has an error of several units of the last place.
  pure subroutine touching_height(s, d, zc, rest)
    real(real64), intent(in) :: s      !! sum of the radii
    real(real64), intent(in) :: d      !! distance in plan, less than s
    real(real64), intent(out) :: zc    !! height, rounded to this arithmetic
    real(real64), intent(out) :: rest  !! exact height less zc
    real(real64) :: less, more, less_rest, more_rest, square

    less = s - d
    less_rest = (s - less) - d
    more = s + d
    more_rest = d - (more - s)
    square = less * more
    zc = sqrt(square)
    rest = 0.0_real64
    if (.not. zc > rest) return
    rest = ((square - zc * zc) + (product_rest(less, more) - product_rest(zc, zc)) + &
            (less_rest * more + more_rest * less)) / (zc + zc)
  end subroutine touching_height

  ! Exact product less the rounded one (Dekker 1971): products of halves are exact.
  pure function product_rest(a, b) result(rest)
    real(real64), intent(in) :: a, b
    real(real64) :: rest, a_upper, a_lower, b_upper, b_lower

    a_upper = upper_half(a)
    a_lower = a - a_upper
    b_upper = upper_half(b)
    b_lower = b - b_upper
    rest = (((a_upper * b_upper - a * b) + a_upper * b_lower) + a_lower * b_upper) + &
           a_lower * b_lower
  end function product_rest

  !> Overlap at a penetration, with an error of at most 4 units of the last place for any
  !> penetration and inclination.
  pure function stable_overlap(s, d, zc, rest, p) result(w)
    real(real64), intent(in) :: s         !! sum of the radii
    real(real64), intent(in) :: d         !! distance in plan, less than s
    real(real64), intent(in) :: zc, rest  !! height at first touch, from touching_height
    real(real64), intent(in) :: p         !! penetration, from 0 to zc
    real(real64) :: w, z, sum_of_heights, sum_rest, distances

    w = p
    if (.not. d > 0.0_real64) return
    z = zc - p
    sum_of_heights = zc + z
    ! Exact errors of the two roundings above, and twice the rest of zc.
    sum_rest = (((zc - z) - p) + (z - (sum_of_heights - zc))) + (rest + rest)
    distances = s + sqrt(d * d + z * z)
    ! The smallest factor is last, so that no intermediate result underflows before the result.
    w = (sum_of_heights / distances + sum_rest / distances) * p
  end function stable_overlap

  ! The number rounded to half its digits: products with it and with the remainder are exact
  ! (Veltkamp).
  elemental real(real64) function upper_half(number) result(upper)
    real(real64), intent(in) :: number
    real(real64), parameter :: factor = 2.0_real64**27 + 1.0_real64

    upper = factor * number
    upper = upper - (upper - number)
  end function upper_half

end module asperity_sphere_overlap
