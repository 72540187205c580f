!> The linear equations of one Newton step: (diag(d) + C) y = b, C the compliances of the contacts.
!>
!> Symmetric and positive definite, so conjugate gradients with the diagonal as preconditioner
!> (Hestenes and Stiefel 1952). The far field is smooth: a dozen iterations whatever the number.
module asperity_coupled_equations
  use asperity_kinds, only: real32, real64
  implicit none
  private

  public :: multiply, solve_equations

contains

  !> Solves to a relative accuracy, which a Newton step needs only roughly.
  pure subroutine solve_equations(diagonal, compliance, rhs, tolerance, solution, definite)
    real(real64), intent(in) :: diagonal(:)        !! more than 0
    real(real32), intent(in) :: compliance(:, :)   !! symmetric, zero on the diagonal
    real(real64), intent(in) :: rhs(:)             !! right-hand side
    real(real64), intent(in) :: tolerance          !! of the residual over the right-hand side
    real(real64), intent(out) :: solution(:)       !! y
    logical, intent(out) :: definite               !! false: not positive definite, y is no solution
    real(real64) :: direction(size(rhs)), residual(size(rhs)), image(size(rhs))
    real(real64) :: size_now, size_before, first, curvature
    integer :: iteration

    definite = .true.
    solution = 0.0_real64
    residual = rhs
    direction = residual / diagonal
    size_now = dot_product(residual, direction)
    first = size_now
    do iteration = 1, 4 * size(rhs) + 20
      if (.not. size_now > tolerance**2 * first) exit
      call multiply(compliance, direction, image)
      image = image + diagonal * direction
      curvature = dot_product(direction, image)
      definite = curvature > 0.0_real64
      if (.not. definite) return
      solution = solution + (size_now / curvature) * direction
      residual = residual - (size_now / curvature) * image
      size_before = size_now
      image = residual / diagonal
      size_now = dot_product(residual, image)
      direction = image + (size_now / size_before) * direction
    end do
  end subroutine solve_equations

  !> A symmetric matrix times a vector.
  !>
  !> Column by column, four at once: no sum need be split to make this vectors.
  pure subroutine multiply(compliance, vector, image)
    real(real32), intent(in) :: compliance(:, :)   !! the matrix
    real(real64), intent(in) :: vector(:)          !! the vector
    real(real64), intent(out) :: image(:)          !! their product
    integer :: i, j, n

    n = size(vector)
    image = 0.0_real64
    do j = 1, n - 3, 4
      do i = 1, n
        image(i) = image(i) + ( &
          (compliance(i, j) * vector(j) + compliance(i, j + 1) * vector(j + 1)) + &
          (compliance(i, j + 2) * vector(j + 2) + compliance(i, j + 3) * vector(j + 3)))
      end do
    end do
    do j = n - modulo(n, 4) + 1, n
      image = image + compliance(:n, j) * vector(j)
    end do
  end subroutine multiply

end module asperity_coupled_equations
