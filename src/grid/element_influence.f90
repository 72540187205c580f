!> Displacement of one element of a lattice by the pressure on another: Love's rectangle.
!>
!> Love (1929) gives the displacement of a half-space at a point under uniform pressure on a
!> rectangle (Johnson, Contact Mechanics, 1985, section 3.4, eq. 3.25). It is taken at the centres
!> of elements where heights are samples. Where a surface is known between them it is averaged over
!> the receiving element as well: then the equations are those of the least energy among all
!> pressures that are uniform on each element, and the total load comes out an order better.
module asperity_element_influence
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  implicit none
  private

  public :: centre_influence, mean_influence

  ! Offset, in sides, from which on the mean is a series: the rounding of the closed form grows,
  ! what the series leaves out falls, and both are 1.4e-10 of the mean there (derived; test:
  ! influence by quadrature in test/unit/elements_suite.f90).
  integer, parameter :: far_offset = 20

contains

  !> Displacement times the modulus at the centres of elements with the sides 1 and `other`, by unit
  !> pressure on one. At an offset of n sides rounding leaves 1e-16 n**2 of it.
  pure function centre_influence(columns, rows, other) result(table)
    integer, intent(in) :: columns, rows       !! of the lattice
    real(real64), intent(in) :: other          !! side of an element along y, over that along x
    real(real64), allocatable :: table(:, :)   !! by offset
    real(real64), allocatable :: corner(:, :)  ! double integral of 1/r
    real(real64) :: x, y
    integer :: i, j

    allocate (corner(0:columns, 0:rows))
    do j = 0, rows
      do i = 0, columns
        x = i - 0.5_real64
        y = other * (j - 0.5_real64)
        corner(i, j) = (x * asinh(y / abs(x)) + y * asinh(x / abs(y))) / pi
      end do
    end do
    table = (corner(1:, 1:) - corner(:columns - 1, 1:)) - &
            (corner(1:, :rows - 1) - corner(:columns - 1, :rows - 1))
  end function centre_influence

  !> Mean displacement times the modulus of square elements of side 1 by a unit force on one: the
  !> mean of 1/r over both, over pi. Where elements have side h it is the entry over h.
  pure function mean_influence(columns, rows) result(table)
    integer, intent(in) :: columns, rows      !! of the lattice
    real(real64), allocatable :: table(:, :)  !! by offset
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

  ! Second differences, in both directions, of a function whose fourth derivative d4/dx2dy2 is 1/r.
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

  ! Fourfold integral of 1/r: Love's logarithms, integrated twice more.
  pure function fourfold_integral(x, y) result(k)
    real(real64), intent(in) :: x, y  ! 0 or more
    real(real64) :: k

    k = -hypot(x, y)**3 / 6.0_real64
    if (x > 0.0_real64 .and. y > 0.0_real64) &
      k = k + 0.5_real64 * x * y * (x * asinh(y / x) + y * asinh(x / y))
  end function fourfold_integral

  ! Taylor's series of the mean: the difference of two places in the elements has the moments 1/6,
  ! 1/15 and 1/36 (xx, xxxx, xxyy).
  pure function far_mean(x, y) result(mean)
    real(real64), intent(in) :: x, y  ! not both small
    real(real64) :: mean, r2, r

    r2 = x * x + y * y
    r = sqrt(r2)
    mean = (1.0_real64 + (1.0_real64 / 12.0_real64 + (0.025_real64 + &
           (105.0_real64 * (x / r)**2 * (y / r)**2 - 12.0_real64) / 720.0_real64) / r2) / r2) / r
  end function far_mean

end module asperity_element_influence
