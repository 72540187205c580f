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

  public :: centre_influence, mean_influence

  ! Offset, in sides, from which on the mean is computed by a series: there the rounding error of
  ! the closed form and the truncation error of the series are both 1.4e-10 of it (derived; test:
  ! influence by quadrature in test/unit/elements_suite.f90).
  integer, parameter :: far_offset = 20

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
