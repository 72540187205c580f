!> The form of a body under the roughness of its map, and Hertz' contact of the smooth form.
!>
!> Near the contact the form is the paraboloid z = -x**2/(2 R(1)) - y**2/(2 R(2)) about the middle
!> of the map. Heights grow towards the other body: the form is convex towards it.
!>
!> The contact of the smooth form on a half-space is an ellipse (Johnson, Contact Mechanics, 1985,
!> section 4.2, eq. 4.24 to 4.28) or a strip (section 4.2(c), eq. 4.43 to 4.46). With the curvatures
!> A = 1/(2 R), the larger one B, the semi-axes a and k a and the greatest pressure p, in Carlson's
!> symmetric elliptic integrals (DLMF, section 19.25):
!>
!>     A = p k/(3 a E) RD(0, k**2, 1),  B = p k/(3 a E) RD(0, 1, k**2),  P = 2/3 p pi k a**2
module asperity_map_form
  use asperity_constants, only: pi
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: not_computed, real64
  implicit none
  private

  public :: add_form, find_form_contact

  ! Largest relative difference of the arguments at which the series of an elliptic integral is
  ! exact to rounding: its error is their sixth power (Carlson, Numer. Algorithms 10 (1995) 13).
  real(real64), parameter :: close_arguments = 1.0e-3_real64

contains

  !> Adds the form to the measured heights.
  pure subroutine add_form(map, radius)
    type(height_map), intent(inout) :: map   !! levelled height map
    real(real64), intent(in) :: radius(2)    !! along x and y [length]; 0: straight
    real(real64) :: curvature(2), square, x(map%columns)
    integer :: i, j

    if (.not. any(radius > 0.0_real64)) return
    curvature = curvatures_of(radius)
    x = [(from_middle(1, i), i=1, map%columns)]
    do j = 1, map%rows
      square = curvature(2) * from_middle(2, j)**2
      where (is_measured(map%height(:, j))) &
        map%height(:, j) = map%height(:, j) - (curvature(1) * x**2 + square)
    end do

  contains

    ! Distance of a column or row from the middle of the map.
    pure real(real64) function from_middle(axis, number)
      integer, intent(in) :: axis, number

      from_middle = map%pixel_spacing(axis) * (number - 0.5_real64 * (size(map%height, axis) + 1))
    end function from_middle

  end subroutine add_form

  !> Finds the greatest pressure and the contact area of the smooth form. A cylinder has them where
  !> the length of its contact is known; elsewhere they are `not_computed`.
  pure subroutine find_form_contact(radius, load, modulus, length, pressure, area)
    real(real64), intent(in) :: radius(2)  !! along x and y [length], one above 0; 0: straight
    real(real64), intent(in) :: load       !! normal load P, 0 or more
    real(real64), intent(in) :: modulus    !! combined modulus E, > 0
    real(real64), intent(in) :: length     !! length of the contact of a cylinder; 0: unknown
    real(real64), intent(out) :: pressure  !! greatest pressure p
    real(real64), intent(out) :: area      !! contact area [length**2]
    real(real64) :: axis, curvature(2), high, low, middle, ratio

    pressure = not_computed
    area = not_computed
    curvature = curvatures_of(radius)
    if (any(.not. radius > 0.0_real64)) then
      if (.not. length > 0.0_real64) return
      axis = sqrt(2.0_real64 * load / (pi * modulus * length * maxval(curvature)))
      pressure = axis * modulus * maxval(curvature)
      area = 2.0_real64 * axis * length
      return
    end if
    ! RD(0, 1, k**2)/RD(0, k**2, 1) = B/A falls from infinity to 1 with k, and is at least 1/k.
    low = minval(curvature) / maxval(curvature)
    ratio = low
    high = 1.0_real64
    do
      middle = 0.5_real64 * (low + high)
      if (.not. (middle > low .and. middle < high)) exit
      if (ratio * carlson_rd(1.0_real64, middle**2) > carlson_rd(middle**2, 1.0_real64)) then
        low = middle
      else
        high = middle
      end if
    end do
    axis = (load * carlson_rd(high**2, 1.0_real64) / &
            (2.0_real64 * pi * modulus * minval(curvature)))**(1.0_real64 / 3.0_real64)
    area = pi * high * axis**2
    pressure = 0.0_real64
    if (area > 0.0_real64) pressure = 1.5_real64 * load / area
  end subroutine find_form_contact

  ! Curvatures 1/(2 R) of the form; 0 along a straight axis.
  pure function curvatures_of(radius) result(curvature)
    real(real64), intent(in) :: radius(2)
    real(real64) :: curvature(2)
    integer :: i

    curvature = 0.0_real64
    do i = 1, 2
      if (radius(i) > 0.0_real64) curvature(i) = 0.5_real64 / radius(i)
    end do
  end function curvatures_of

  ! Carlson's RD(0, y, z), by his duplication theorem and Taylor's series (Numer. Algorithms 10
  ! (1995) 13, eq. 2.28 to 2.36; DLMF 19.36.2).
  pure real(real64) function carlson_rd(y, z) result(rd)
    real(real64), intent(in) :: y, z  ! > 0
    real(real64) :: a, e(5), lambda, power, s(3), sum_of_terms, t(3)

    s = [0.0_real64, y, z]
    sum_of_terms = 0.0_real64
    power = 1.0_real64
    do
      a = (s(1) + s(2) + 3.0_real64 * s(3)) / 5.0_real64
      if (maxval(abs(s - a)) < close_arguments * a) exit
      lambda = sqrt(s(1) * s(2)) + sqrt(s(2) * s(3)) + sqrt(s(3) * s(1))
      sum_of_terms = sum_of_terms + power / (sqrt(s(3)) * (s(3) + lambda))
      power = 0.25_real64 * power
      s = 0.25_real64 * (s + lambda)
    end do
    t = (a - s) / a
    e(2) = t(1) * t(2) - 6.0_real64 * t(3)**2
    e(3) = (3.0_real64 * t(1) * t(2) - 8.0_real64 * t(3)**2) * t(3)
    e(4) = 3.0_real64 * (t(1) * t(2) - t(3)**2) * t(3)**2
    e(5) = t(1) * t(2) * t(3)**3
    rd = 3.0_real64 * sum_of_terms + power / (a * sqrt(a)) * &
         (1.0_real64 - 3.0_real64 * e(2) / 14.0_real64 + e(3) / 6.0_real64 + &
          9.0_real64 * e(2)**2 / 88.0_real64 - 3.0_real64 * e(4) / 22.0_real64 - &
          9.0_real64 * e(2) * e(3) / 52.0_real64 + 3.0_real64 * e(5) / 26.0_real64)
  end function carlson_rd

end module asperity_map_form
