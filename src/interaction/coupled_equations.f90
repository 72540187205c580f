!> Krylov methods for the linear equations of one Newton step.
!>
!> Simplified ones, (diag(d) + C) y = b with C the compliances of the contacts, are symmetric and
!> positive definite: conjugate gradients with the diagonal as preconditioner (Hestenes and Stiefel
!> 1952). The full ones are not symmetric: generalised minimal residuals (Saad and Schultz 1986).
!> The far field is smooth: a dozen iterations whatever the number.
module asperity_coupled_equations
  use asperity_kinds, only: real32, real64
  implicit none
  private

  public :: krylov_space, make_room, begin, next_direction, add_image, end_of_space
  public :: comply, multiply, solve_equations

  !> What generalised minimal residuals keep. The caller applies its matrix.
  type :: krylov_space
    integer :: used = 0                            !! directions known
    logical :: done = .false.                      !! accurate enough, or no room
    real(real64) :: first = 0.0_real64             !! size of the right-hand side
    real(real64) :: aim = 0.0_real64               !! size of the residual to reach
    real(real64), allocatable :: basis(:, :)       !! orthonormal directions
    real(real64), allocatable :: triangle(:, :)    !! the matrix in the basis, rotated
    real(real64), allocatable :: rhs(:)            !! right-hand side in the basis, rotated
    real(real64), allocatable :: rotation(:, :)    !! cosine and sine
  end type krylov_space

contains

  !> Room for some directions.
  pure subroutine make_room(space, unknowns, most)
    type(krylov_space), intent(inout) :: space   !! the space
    integer, intent(in) :: unknowns              !! length of a direction
    integer, intent(in) :: most                  !! directions

    if (allocated(space%basis)) then
      if (size(space%basis, 1) == unknowns .and. size(space%basis, 2) == most + 1) return
      deallocate (space%basis, space%triangle, space%rhs, space%rotation)
    end if
    allocate (space%basis(unknowns, most + 1), space%triangle(most + 1, most))
    allocate (space%rhs(most + 1), space%rotation(2, most))
  end subroutine make_room

  !> Begins with a right-hand side.
  pure subroutine begin(space, rhs, tolerance)
    type(krylov_space), intent(inout) :: space  !! has room
    real(real64), intent(in) :: rhs(:)          !! right-hand side
    real(real64), intent(in) :: tolerance       !! of the residual over it

    space%used = 0
    space%first = norm2(rhs)
    space%aim = tolerance * space%first
    space%rhs = 0.0_real64
    space%rhs(1) = space%first
    space%done = .not. (space%first > 0.0_real64 .and. space%first < huge(1.0_real64))
    if (.not. space%done) space%basis(:, 1) = rhs / space%first
  end subroutine begin

  !> The direction whose image is asked for.
  pure subroutine next_direction(space, direction)
    type(krylov_space), intent(in) :: space       !! not done
    real(real64), intent(out) :: direction(:)     !! of size 1

    direction = space%basis(:, space%used + 1)
  end subroutine next_direction

  !> Takes the image of the last direction.
  pure subroutine add_image(space, image)
    type(krylov_space), intent(inout) :: space  !! gets one direction more
    real(real64), contiguous, intent(inout) :: image(:)  !! matrix times direction; overwritten
    real(real64) :: before, size_left
    integer :: i, k

    k = space%used + 1
    do i = 1, k
      space%triangle(i, k) = product_of(space%basis(:, i), image)
      image = image - space%triangle(i, k) * space%basis(:, i)
    end do
    size_left = sqrt(product_of(image, image))
    if (size_left > 0.0_real64) space%basis(:, k + 1) = image / size_left
    do i = 1, k - 1
      before = space%triangle(i, k)
      space%triangle(i, k) = space%rotation(1, i) * before + &
                             space%rotation(2, i) * space%triangle(i + 1, k)
      space%triangle(i + 1, k) = space%rotation(1, i) * space%triangle(i + 1, k) - &
                                 space%rotation(2, i) * before
    end do
    before = hypot(space%triangle(k, k), size_left)
    if (.not. before > 0.0_real64) then
      space%done = .true.
      return
    end if
    space%rotation(:, k) = [space%triangle(k, k), size_left] / before
    space%triangle(k, k) = before
    space%rhs(k + 1) = -space%rotation(2, k) * space%rhs(k)
    space%rhs(k) = space%rotation(1, k) * space%rhs(k)
    space%used = k
    space%done = abs(space%rhs(k + 1)) <= space%aim .or. k + 1 == size(space%basis, 2) .or. &
                 .not. size_left > 1.0e-14_real64 * before
  end subroutine add_image

  ! A product of vectors in four parts, always in this order: it can become vectors.
  pure function product_of(one, other) result(added)
    real(real64), contiguous, intent(in) :: one(:), other(:)
    real(real64) :: added, four(4)
    integer :: i, n

    four = 0.0_real64
    n = size(one) - modulo(size(one), 4)
    do i = 1, n, 4
      four = four + one(i:i + 3) * other(i:i + 3)
    end do
    added = (four(1) + four(2)) + (four(3) + four(4))
    do i = n + 1, size(one)
      added = added + one(i) * other(i)
    end do
  end function product_of

  !> The solution in the space.
  pure subroutine end_of_space(space, solution, left)
    type(krylov_space), intent(in) :: space       !! done
    real(real64), intent(out) :: solution(:)      !! least residual
    real(real64), intent(out) :: left             !! residual over the right-hand side
    real(real64) :: weight(space%used)
    integer :: k

    solution = 0.0_real64
    left = 0.0_real64
    if (.not. space%first > 0.0_real64) return
    left = abs(space%rhs(space%used + 1)) / space%first
    do k = space%used, 1, -1
      weight(k) = (space%rhs(k) - dot_product(space%triangle(k, k + 1:space%used), &
                                              weight(k + 1:))) / space%triangle(k, k)
    end do
    do k = 1, space%used
      solution = solution + weight(k) * space%basis(:, k)
    end do
  end subroutine end_of_space

  !> Solves to a relative accuracy, which a Newton step needs only roughly.
  pure subroutine solve_equations(diagonal, compliance, rhs, tolerance, solution, definite)
    real(real64), intent(in) :: diagonal(:)        !! more than 0
    real(real32), contiguous, intent(in) :: compliance(:, :)   !! symmetric, zero on the diagonal
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
    size_now = product_of(residual, direction)
    first = size_now
    do iteration = 1, 4 * size(rhs) + 20
      if (.not. size_now > tolerance**2 * first) exit
      call multiply(compliance, direction, image)
      image = image + diagonal * direction
      curvature = product_of(direction, image)
      definite = curvature > 0.0_real64
      if (.not. definite) return
      solution = solution + (size_now / curvature) * direction
      residual = residual - (size_now / curvature) * image
      size_before = size_now
      image = residual / diagonal
      size_now = product_of(residual, image)
      direction = image + (size_now / size_before) * direction
    end do
  end subroutine solve_equations

  !> A symmetric matrix times a vector.
  !>
  !> Column by column, four at once: no sum need be split to make this vectors. Single precision
  !> throughout: a step of Newton's method needs no more.
  pure subroutine multiply(compliance, vector, image)
    real(real32), contiguous, intent(in) :: compliance(:, :)   !! the matrix
    real(real64), intent(in) :: vector(:)                      !! the vector
    real(real64), intent(out) :: image(:)                      !! their product
    real(real32) :: factor(size(vector)), sums(size(vector))
    real(real64) :: largest
    integer :: i, j, n

    n = size(vector)
    largest = 0.0_real64
    do i = 1, n
      largest = max(largest, abs(vector(i)))
    end do
    if (.not. largest > 0.0_real64) then
      image = 0.0_real64
      return
    end if
    factor = real(vector / largest, real32)
    sums = 0.0_real32
    do j = 1, n - 3, 4
      do i = 1, n
        sums(i) = sums(i) + ( &
          (compliance(i, j) * factor(j) + compliance(i, j + 1) * factor(j + 1)) + &
          (compliance(i, j + 2) * factor(j + 2) + compliance(i, j + 3) * factor(j + 3)))
      end do
    end do
    do j = n - modulo(n, 4) + 1, n
      sums = sums + compliance(:n, j) * factor(j)
    end do
    image = largest * sums
  end subroutine multiply

  !> One column of the matrix of compliances, from the first terms of their series.
  pure subroutine comply(x, y, b2, px, py, circle, scale, compliance)
    real(real64), intent(in) :: x                              !! place of the one
    real(real64), intent(in) :: y                              !! place of the one
    real(real64), intent(in) :: b2                             !! square of its circle's radius
    real(real64), contiguous, intent(in) :: px(:), py(:)       !! places of the others
    real(real64), contiguous, intent(in) :: circle(:)          !! radii of their circles
    real(real32), intent(in) :: scale                          !! one over pi times the modulus
    real(real32), contiguous, intent(out) :: compliance(:)     !! with each
    real(real32) :: dx, dy, sum2, w
    integer :: i

    do i = 1, size(px)
      dx = real(px(i) - x, real32)
      dy = real(py(i) - y, real32)
      sum2 = real(circle(i)**2 + b2, real32)
      ! Of itself, and where circles are as good as none, next to nothing stands below the line.
      w = 1.0_real32 / max(dx * dx + dy * dy, sum2, tiny(w))
      compliance(i) = scale * sqrt(w) * (1.0_real32 + w * sum2 / 6.0_real32)
    end do
  end subroutine comply

end module asperity_coupled_equations
