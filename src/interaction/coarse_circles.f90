!> Many circles as a few squares: what they do to each other over long distances.
!>
!> The slow part of conjugate gradients on many contacts are changes of load that vary slowly from
!> place to place. So the circles of each square of a grid get a shared change of penetration, and
!> the equations of these few unknowns are solved at once: their matrix has the stiffnesses of the
!> squares and the mean of 1/r over two squares (Love 1929), a Gram matrix, so that it is positive
!> definite. Only a preconditioner: it changes how many steps are needed, not the result.
module asperity_coarse_circles
  use asperity_cells_influence, only: influence_table
  use asperity_circle_field, only: circle_set
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  implicit none
  private

  public :: coarse_circles, gather_circles, add_coarse

  !> Circles gathered in squares.
  type :: coarse_circles
    integer, allocatable :: square(:)             !! of each circle
    real(real64), allocatable :: stiffness(:)     !! sum over a square
    real(real64), allocatable :: factor(:, :)     !! lower triangle of Cholesky
  end type coarse_circles

  ! Squares along a side: the factors then cost less than the products that they save.
  integer, parameter :: squares = 16

contains

  !> Gathers circles and factors their equations.
  pure subroutine gather_circles(set, coarse)
    type(circle_set), intent(in) :: set              !! places and stiffnesses
    type(coarse_circles), intent(out) :: coarse      !! ready for `add_coarse`
    real(real64) :: table(squares, squares), low(2), side
    integer :: row(0:squares**2 - 1), i, j, k, n

    call influence_table(table)
    low = [minval(set%x), minval(set%y)]
    side = max(maxval(set%x) - low(1), maxval(set%y) - low(2)) / squares * &
           (1.0_real64 + epsilon(side) * 8)
    side = max(side, tiny(side))
    allocate (coarse%square(size(set%x)))
    row = 0
    do i = 1, size(set%x)
      coarse%square(i) = min(int((set%x(i) - low(1)) / side), squares - 1) + &
                         squares * min(int((set%y(i) - low(2)) / side), squares - 1)
      row(coarse%square(i)) = 1
    end do
    ! Squares with circles, numbered.
    n = 0
    do k = 0, squares**2 - 1
      if (row(k) == 0) cycle
      n = n + 1
      row(k) = n
    end do
    coarse%square = row(coarse%square)
    allocate (coarse%stiffness(n), coarse%factor(n, n))
    coarse%stiffness = 0.0_real64
    do i = 1, size(set%x)
      coarse%stiffness(coarse%square(i)) = coarse%stiffness(coarse%square(i)) + set%stiffness(i)
    end do
    do k = 0, squares**2 - 1
      if (row(k) == 0) cycle
      do j = 0, k
        if (row(j) == 0) cycle
        coarse%factor(row(k), row(j)) = coarse%stiffness(row(k)) * coarse%stiffness(row(j)) * &
          table(1 + abs(modulo(k, squares) - modulo(j, squares)), &
                1 + abs(line(k) - line(j))) / (pi * side)
      end do
      coarse%factor(row(k), row(k)) = coarse%factor(row(k), row(k)) + coarse%stiffness(row(k))
    end do
    do j = 1, n
      coarse%factor(j, j) = sqrt(coarse%factor(j, j))
      coarse%factor(j + 1:, j) = coarse%factor(j + 1:, j) / coarse%factor(j, j)
      do k = j + 1, n
        coarse%factor(k:, k) = coarse%factor(k:, k) - coarse%factor(k:, j) * coarse%factor(k, j)
      end do
    end do

  contains

    pure integer function line(k)
      integer, intent(in) :: k

      line = (k - modulo(k, squares)) / squares
    end function line

  end subroutine gather_circles

  !> Adds the changes of load by the shared changes of the squares' penetrations.
  pure subroutine add_coarse(set, coarse, left, scaled)
    type(circle_set), intent(in) :: set             !! the circles
    type(coarse_circles), intent(in) :: coarse      !! gathered from them
    real(real64), intent(in) :: left(:)             !! what the equations leave over, by circle
    real(real64), intent(inout) :: scaled(:)        !! changes of load, by circle
    real(real64) :: shared(size(coarse%stiffness))
    integer :: i, n

    n = size(shared)
    shared = 0.0_real64
    do i = 1, size(left)
      shared(coarse%square(i)) = shared(coarse%square(i)) + set%stiffness(i) * left(i)
    end do
    do i = 1, n
      shared(i) = shared(i) / coarse%factor(i, i)
      shared(i + 1:) = shared(i + 1:) - shared(i) * coarse%factor(i + 1:, i)
    end do
    do i = n, 1, -1
      shared(i) = (shared(i) - dot_product(coarse%factor(i + 1:, i), shared(i + 1:))) / &
                  coarse%factor(i, i)
    end do
    scaled = scaled + set%stiffness * shared(coarse%square)
  end subroutine add_coarse

end module asperity_coarse_circles
