!> Many circles as a few squares: what they do to each other over long distances.
!>
!> The slow part of conjugate gradients on many contacts are changes of load that vary slowly from
!> place to place. So the circles of each square of a grid get a shared change of penetration, and
!> the equations of these few unknowns are solved at once: their matrix has the stiffnesses of the
!> squares and the mean of 1/r over two squares (Love 1929), a Gram matrix, so that it is positive
!> definite. Only a preconditioner and a start: they change how many steps are needed, not the
!> result.
module asperity_coarse_circles
  use asperity_cells_influence, only: influence_table
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  implicit none
  private

  public :: coarse_circles, gather_squares, factor_squares, shared_change, sum_of_squares

  !> Circles gathered in squares.
  type :: coarse_circles
    integer, allocatable :: square(:)             !! of each circle
    real(real64), allocatable :: presses(:, :)    !! displacement of a square by a load on another
    real(real64), allocatable :: stiffness(:)     !! sum over a square
    real(real64), allocatable :: factor(:, :)     !! lower triangle of Cholesky
  end type coarse_circles

  ! Squares along a side, so that each has so many circles: the factors then cost less than the
  ! products that they save.
  integer, parameter :: least_squares = 16, most_squares = 24
  real(real64), parameter :: circles_in_one = 50.0_real64

contains

  !> Gathers circles at their places.
  pure subroutine gather_squares(x, y, coarse)
    real(real64), intent(in) :: x(:), y(:)           !! places, one at least
    type(coarse_circles), intent(out) :: coarse      !! ready for `factor_squares`
    real(real64), allocatable :: table(:, :)
    real(real64) :: low(2), side
    integer :: i, j, k, l, squares

    squares = max(least_squares, min(nint(sqrt(size(x) / circles_in_one)), most_squares))
    low = [minval(x), minval(y)]
    side = max(maxval(x) - low(1), maxval(y) - low(2), tiny(side)) / squares
    coarse%square = min(int((x - low(1)) / side), squares - 1) + &
                    squares * min(int((y - low(2)) / side), squares - 1) + 1
    allocate (table(squares, squares))
    call influence_table(table)
    table = table / (pi * side)
    allocate (coarse%presses(squares**2, squares**2))
    do j = 0, squares - 1
      do i = 0, squares - 1
        do l = 0, squares - 1
          do k = 0, squares - 1
            coarse%presses(1 + k + squares * l, 1 + i + squares * j) = &
              table(1 + abs(i - k), 1 + abs(j - l))
          end do
        end do
      end do
    end do
  end subroutine gather_squares

  !> Sets up the equations of the squares for the stiffnesses of circles.
  pure subroutine factor_squares(coarse, stiffness)
    type(coarse_circles), intent(inout) :: coarse   !! gathered; gets its factor
    real(real64), intent(in) :: stiffness(:)        !! of circles; none negative
    integer :: i, j, k, n

    coarse%stiffness = sum_of_squares(coarse, stiffness)
    coarse%factor = coarse%presses
    n = size(coarse%stiffness)
    do j = 1, n
      coarse%factor(:, j) = coarse%factor(:, j) * coarse%stiffness * coarse%stiffness(j)
      coarse%factor(j, j) = coarse%factor(j, j) + coarse%stiffness(j)
      ! A square without stiffness stays out.
      if (.not. coarse%stiffness(j) > 0.0_real64) coarse%factor(j, j) = 1.0_real64
    end do
    do j = 1, n
      coarse%factor(j, j) = sqrt(coarse%factor(j, j))
      coarse%factor(j + 1:, j) = coarse%factor(j + 1:, j) / coarse%factor(j, j)
      do k = j + 1, n
        do i = k, n
          coarse%factor(i, k) = coarse%factor(i, k) - coarse%factor(i, j) * coarse%factor(k, j)
        end do
      end do
    end do
  end subroutine factor_squares

  !> Sums over the circles of each square.
  pure function sum_of_squares(coarse, values) result(sums)
    type(coarse_circles), intent(in) :: coarse
    real(real64), intent(in) :: values(:)
    real(real64) :: sums(size(coarse%presses, 1))
    integer :: i

    sums = 0.0_real64
    do i = 1, size(values)
      sums(coarse%square(i)) = sums(coarse%square(i)) + values(i)
    end do
  end function sum_of_squares

  !> Changes of penetration, by square, that take away what the equations leave over.
  pure function shared_change(coarse, left) result(shared)
    type(coarse_circles), intent(in) :: coarse    !! factored
    real(real64), intent(in) :: left(:)           !! by square, times its stiffness
    real(real64) :: shared(size(left))
    integer :: i, n

    n = size(left)
    shared = left
    do i = 1, n
      shared(i) = shared(i) / coarse%factor(i, i)
      shared(i + 1:) = shared(i + 1:) - shared(i) * coarse%factor(i + 1:, i)
    end do
    do i = n, 1, -1
      shared(i) = (shared(i) - dot_product(coarse%factor(i + 1:, i), shared(i + 1:))) / &
                  coarse%factor(i, i)
    end do
  end function shared_change

end module asperity_coarse_circles
