!> Displacement of one element of a lattice by tractions on another: Cerruti's integrals.
!>
!> Tangential tractions q on a half-space displace its surface (Cerruti; Johnson, Contact Mechanics,
!> 1985, section 3.6). With the compliances g = 1/G1 + 1/G2 and m = nu1/G1 + nu2/G2 of two bodies,
!> 2 pi u_x is q_x times the integral of (g - m)/r + m x**2/r**3, and q_y times that of m x y/r**3.
!> Over an element these are differences of the functions `corner_value` at its corners: the
!> integrals of x**2/r**3 and y**2/r**3 are the two halves of Love's integral of 1/r. Unlike bodies
!> have besides a normal displacement by q_x, beta/(pi E) times the integral of x/r**2.
module asperity_traction_influence
  use asperity_kinds, only: real64
  implicit none
  private

  public :: integral_over_element
  public :: of_xx, of_xy, of_yy, of_x, of_y

  !> Numbers of the integrands x**2/r**3, x y/r**3, y**2/r**3, x/r**2, y/r**2 (chosen).
  integer, parameter :: of_xx = 1, of_xy = 2, of_yy = 3, of_x = 4, of_y = 5

  ! Periods of a strip on each side that are summed (derived: the next correction of Euler and
  ! Maclaurin is 7 (6/5760) (images_along + 1/2)**-4 = 1.4e-6 of a period).
  integer, parameter :: images_along = 8

contains

  !> Integrals over elements with the sides 1 and `side_ratio`, by the offset of their centres.
  !>
  !> On a strip they are summed over all periods L: those beyond `images_along` by the midpoint rule
  !> with its first correction (Euler and Maclaurin: L**2/24 times the change of the slope). The sum
  !> of 1/r grows as the logarithm of their number: the displacement by a line of pressure is 0 at
  !> the distance of a period or of the width, whichever is larger. The energy is then positive, as
  !> -log(r/w) is positive definite on a width below 4 w (logarithmic capacity, Ransford 1995,
  !> corollary 5.2.4). The sum of (across)**2/r**3 is 2/L far from a line of elements. That constant
  !> is moved to the other half of 1/r: lines of tractions have then no displacement at the same
  !> distance, and those across a strip exactly the displacements of plane strain.
  pure function integral_over_element(integrand, elements, side_ratio, strip_axis) result(table)
    integer, intent(in) :: integrand             !! one of the five integrands
    integer, intent(in) :: elements(2)      !! numbers of columns and rows of the lattice
    real(real64), intent(in) :: side_ratio  !! side of an element along y, over that along x
    integer, intent(in) :: strip_axis       !! axis of the period: 1 or 2; 0: no period
    real(real64), allocatable :: table(:, :)    !! (0:columns - 1, 0:rows - 1): by offset
    real(real64), allocatable :: corner(:, :)
    real(real64) :: length, place(2), period(2), side(2)
    integer :: half(2), i, j, k, images, turned

    side = [1.0_real64, side_ratio]
    half = elements - 1
    images = 0
    period = 0.0_real64
    if (strip_axis > 0) then
      half(strip_axis) = elements(strip_axis) / 2
      images = images_along
      period(strip_axis) = elements(strip_axis) * side(strip_axis)
    end if
    allocate (corner(0:half(1) + 1, 0:half(2) + 1), source=0.0_real64)
    do j = 0, half(2) + 1
      do i = 0, half(1) + 1
        do k = -images, images
          place = ([i, j] - 0.5_real64) * side + k * period
          corner(i, j) = corner(i, j) + corner_value(integrand, place(1), place(2))
        end do
      end do
    end do
    allocate (table(0:elements(1) - 1, 0:elements(2) - 1))
    table(:half(1), :half(2)) = (corner(1:, 1:) - corner(:half(1), 1:)) - &
                                (corner(1:, :half(2)) - corner(:half(1), :half(2)))
    if (strip_axis == 0) return
    length = sum(period)
    turned = merge(integrand, integrand_turned(integrand), strip_axis == 1)
    do j = 0, half(2)
      do i = 0, half(1)
        place = cshift([i, j] * side, strip_axis - 1)
        table(i, j) = table(i, j) + side_ratio / length * far_periods( &
                      turned, place(1), place(2), length, &
                      max(length, elements(3 - strip_axis) * side(3 - strip_axis)))
      end do
    end do
    ! The other half of the period mirrors the first: odd integrands are 0 at its middle.
    associate (n => elements(strip_axis), odd => is_odd(integrand, strip_axis))
      if (strip_axis == 1) then
        if (odd .and. mod(n, 2) == 0) table(n / 2, :) = 0.0_real64
        table(n - (n - 1) / 2:, :) = merge(-1, 1, odd) * table((n - 1) / 2:1:-1, :)
      else
        if (odd .and. mod(n, 2) == 0) table(:, n / 2) = 0.0_real64
        table(:, n - (n - 1) / 2:) = merge(-1, 1, odd) * table(:, (n - 1) / 2:1:-1)
      end if
    end associate
  end function integral_over_element

  ! Whether an integrand changes its sign with the offset along an axis.
  pure logical function is_odd(integrand, axis)
    integer, intent(in) :: integrand, axis

    is_odd = integrand == of_xy .or. integrand == merge(of_x, of_y, axis == 1)
  end function is_odd

  ! Number of the same integrand with x and y exchanged.
  pure integer function integrand_turned(integrand)
    integer, intent(in) :: integrand
    integer, parameter :: other(5) = [of_yy, of_xy, of_xx, of_y, of_x]

    integrand_turned = other(integrand)
  end function integrand_turned

  ! Function whose derivative by x and y is the integrand; neither x nor y is 0.
  elemental real(real64) function corner_value(integrand, x, y)
    integer, intent(in) :: integrand
    real(real64), intent(in) :: x, y

    select case (integrand)
    case (of_xx)
      corner_value = y * asinh(x / abs(y))
    case (of_yy)
      corner_value = x * asinh(y / abs(x))
    case (of_xy)
      corner_value = -hypot(x, y)
    case (of_x)
      corner_value = y * log(hypot(x, y)) + x * atan(y / x)
    case default
      corner_value = x * log(hypot(x, y)) + y * atan(x / y)
    end select
  end function corner_value

  ! Sum of L times the integrand over the periods along x beyond those of `images_along`.
  pure real(real64) function far_periods(integrand, x, y, length, reference)
    integer, intent(in) :: integrand
    real(real64), intent(in) :: x, y       ! offset along the strip, at most half of L, and across
    real(real64), intent(in) :: length     ! period L
    real(real64), intent(in) :: reference  ! distance without displacement by a line
    real(real64) :: correction, r, z
    integer :: side

    correction = length**2 / 24.0_real64
    far_periods = 0.0_real64
    do side = -1, 1, 2
      z = (images_along + 0.5_real64) * length + side * x
      r = hypot(z, y)
      select case (integrand)
      case (of_xx)
        far_periods = far_periods + log(reference) - log(z + r) + z / r - &
                      correction * z / r**3 * (1.0_real64 - 3.0_real64 * (y / r)**2)
      case (of_yy)
        far_periods = far_periods - z / r - correction * 3.0_real64 * z * y**2 / r**5
      case (of_xy)
        far_periods = far_periods + side * (y / r + correction * y / r**3 * &
                                            (1.0_real64 - 3.0_real64 * (z / r)**2))
      case (of_x)
        far_periods = far_periods + side * (correction / r**2 * &
                                            (1.0_real64 - 2.0_real64 * (z / r)**2) - log(r))
      case default
        far_periods = far_periods + atan(y / z) - correction * 2.0_real64 * z * y / r**4
      end select
    end do
  end function far_periods

end module asperity_traction_influence
