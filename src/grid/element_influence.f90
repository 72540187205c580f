!> Displacement of one element of a lattice by the pressure on another: Love's rectangle.
!>
!> Love (1929) gives the displacement of a half-space at a point under uniform pressure on a
!> rectangle (Johnson, Contact Mechanics, 1985, section 3.4, eq. 3.25). For height maps, whose
!> heights are values at points, it is evaluated at the centres of elements (collocation). For
!> surfaces that are functions it is also averaged over the receiving element (Galerkin's method):
!> the solution then has the least energy of all pressures that are uniform on each element, and the
!> error of the total load is one order smaller.
module asperity_element_influence
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  implicit none
  private

  public :: centre_influence, mean_influence, strip_influence

  ! Offset, in sides, from which on the mean is computed by a series: there the rounding error of
  ! the closed form and the truncation error of the series are both 1.4e-10 of it (derived; test:
  ! influence by quadrature in test/unit/elements_suite.f90).
  integer, parameter :: far_offset = 20
  ! Periods of a strip on each side that are summed (derived: the next correction of Euler and
  ! Maclaurin is 7 (6/5760) (images_along + 1/2)**-4 = 1.4e-6 of a period).
  integer, parameter :: images_along = 8

contains

  !> Displacement times the modulus at the centres of elements with the sides 1 and `side_ratio`, by
  !> unit pressure on one element. The relative rounding error at an offset of n sides is 1e-16
  !> n**2.
  pure function centre_influence(columns, rows, side_ratio) result(table)
    integer, intent(in) :: columns, rows       !! numbers of columns and rows of the lattice
    real(real64), intent(in) :: side_ratio     !! side of an element along y, over that along x
    real(real64), allocatable :: table(:, :)   !! (columns, rows): by offset
    real(real64), allocatable :: corner(:, :)  ! double integral of 1/r up to a corner, over pi
    real(real64) :: x, y
    integer :: i, j

    allocate (corner(0:columns, 0:rows))
    do j = 0, rows
      do i = 0, columns
        x = i - 0.5_real64
        y = side_ratio * (j - 0.5_real64)
        corner(i, j) = (x * asinh(y / abs(x)) + y * asinh(x / abs(y))) / pi
      end do
    end do
    table = (corner(1:, 1:) - corner(:columns - 1, 1:)) - &
            (corner(1:, :rows - 1) - corner(:columns - 1, :rows - 1))
  end function centre_influence

  !> Displacement times the modulus by unit pressure on one element of each period of a strip, which
  !> repeats itself along one axis with the period L: Love's rectangles of `images_along` periods on
  !> both sides, and the integral of 1/r beyond them by the midpoint rule with its first correction
  !> (Euler and Maclaurin: L**2/24 times the change of the slope). The sum grows as the logarithm of
  !> the number of periods. The displacement by a line of pressure is 0 at the distance of a period
  !> or of the width, whichever is larger: the energy of pressures is then positive, as -log(r/w) is
  !> positive definite on a width below 4 w (logarithmic capacity, Ransford 1995, corollary 5.2.4).
  pure function strip_influence(elements, side_ratio, strip_axis) result(table)
    integer, intent(in) :: elements(2)      !! numbers of columns and rows of the lattice
    real(real64), intent(in) :: side_ratio  !! side of an element along y, over that along x
    integer, intent(in) :: strip_axis       !! axis of the period: 1 or 2
    real(real64), allocatable :: table(:, :)  !! (columns, rows): by offset, over a whole period
    real(real64), allocatable :: corner(:, :)  ! sums over the periods; along the strip, across it
    real(real64) :: displacement, length, side(2), u, v
    integer :: across, half, i, j, k, n

    across = 3 - strip_axis
    side = [1.0_real64, side_ratio]
    n = elements(strip_axis)
    half = n / 2
    length = n * side(strip_axis)
    allocate (corner(0:half + 1, 0:elements(across)), source=0.0_real64)
    do j = 0, ubound(corner, 2)
      v = side(across) * (j - 0.5_real64)
      do i = 0, ubound(corner, 1)
        do k = -images_along, images_along
          u = side(strip_axis) * (i - 0.5_real64 + real(k, real64) * n)
          corner(i, j) = corner(i, j) + (u * asinh(v / abs(u)) + v * asinh(u / abs(v))) / pi
        end do
      end do
    end do
    allocate (table(elements(1), elements(2)))
    do j = 1, elements(across)
      do i = 0, half
        displacement = (corner(i + 1, j) - corner(i, j)) - &
          (corner(i + 1, j - 1) - corner(i, j - 1)) + side_ratio / (pi * length) * &
          far_periods(i * side(strip_axis), (j - 1) * side(across), length, &
                      max(length, elements(across) * side(across)))
        do k = i, mod(n - i, n), max(1, mod(n - i, n) - i)
          if (strip_axis == 1) table(1 + k, j) = displacement
          if (strip_axis == 2) table(j, 1 + k) = displacement
        end do
      end do
    end do
  end function strip_influence

  ! Sum of L/r over the periods beyond those of `images_along`, less its value of a line at the
  ! distance without displacement.
  pure real(real64) function far_periods(x, y, length, reference)
    real(real64), intent(in) :: x, y    ! offset along the strip, at most half of L, and across it
    real(real64), intent(in) :: length  ! period L
    real(real64), intent(in) :: reference  ! distance without displacement
    real(real64) :: r, z
    integer :: side

    far_periods = 2.0_real64 * log(reference)
    do side = -1, 1, 2
      z = (images_along + 0.5_real64) * length + side * x
      r = hypot(z, y)
      far_periods = far_periods - log(z + r) - length**2 / 24.0_real64 * z / r**3
    end do
  end function far_periods

  !> Mean displacement times the modulus of square elements of side 1 by a unit force on one
  !> element: the mean of 1/r over both elements, over pi. For elements of side h it is divided by
  !> h.
  pure function mean_influence(columns, rows) result(table)
    integer, intent(in) :: columns, rows      !! numbers of columns and rows of the lattice
    real(real64), allocatable :: table(:, :)  !! (0:columns - 1, 0:rows - 1): by offset
    integer :: i, j

    allocate (table(0:columns - 1, 0:rows - 1))
    do j = 0, rows - 1
      do i = 0, columns - 1
        if (max(i, j) < far_offset) then
          table(i, j) = near_mean(max(i, j), min(i, j)) / pi
        else
          table(i, j) = far_mean(real(i, real64), real(j, real64)) / pi
        end if
      end do
    end do
  end function mean_influence

  ! Mean of 1/r over two elements at an offset: second differences, in both directions, of the
  ! function whose derivative d4/dx2dy2 is 1/r.
  pure function near_mean(i, j) result(mean)
    integer, intent(in) :: i, j
    real(real64) :: mean
    integer :: k, l

    mean = 0.0_real64
    do l = -1, 1
      do k = -1, 1
        mean = mean + merge(-2, 1, k == 0) * merge(-2, 1, l == 0) * &
               fourfold_integral(real(abs(i + k), real64), real(abs(j + l), real64))
      end do
    end do
  end function near_mean

  ! Integral of 1/r, twice in x and twice in y.
  pure function fourfold_integral(x, y) result(k)
    real(real64), intent(in) :: x, y  ! 0 or more
    real(real64) :: k

    k = -hypot(x, y)**3 / 6.0_real64
    if (x > 0.0_real64 .and. y > 0.0_real64) &
      k = k + 0.5_real64 * x * y * (x * asinh(y / x) + y * asinh(x / y))
  end function fourfold_integral

  ! Mean of 1/r over two elements at an offset by Taylor's series: the difference of two points of
  ! the elements has the moments 1/6 (xx), 1/15 (xxxx) and 1/36 (xxyy).
  pure function far_mean(x, y) result(mean)
    real(real64), intent(in) :: x, y  ! offset in sides, at least one of both large
    real(real64) :: mean, r2, r

    r2 = x * x + y * y
    r = sqrt(r2)
    mean = (1.0_real64 + (1.0_real64 / 12.0_real64 + (0.025_real64 + &
           (105.0_real64 * (x / r)**2 * (y / r)**2 - 12.0_real64) / 720.0_real64) / r2) / r2) / r
  end function far_mean

end module asperity_element_influence
