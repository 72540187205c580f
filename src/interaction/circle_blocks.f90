!> Circles that overlap, block by block: the inverse of their second derivatives.
!>
!> How two circles nearly in one place share their load hardly matters, so that the second
!> derivatives are nearly singular there, and conjugate gradients slow. Only a preconditioner: it
!> changes how many products are needed, not the result.
module asperity_circle_blocks
  use asperity_circle_field, only: are_close, between, circle_set, comply, east, many, north, &
                                   steer_one, steer_other
  use asperity_index_groups, only: gather_groups
  use asperity_kinds, only: real64
  implicit none
  private

  public :: circle_blocks, find_blocks, solve_blocks

  !> Factors of the blocks.
  type :: circle_blocks
    integer, allocatable :: member(:), first(:)     !! circles of each block
    integer, allocatable :: start(:)                !! where its factor begins
    real(real64), allocatable :: factor(:)          !! L of L D L', its diagonal D
  end type circle_blocks

  ! Circles in a block at most: factors take the third power of it.
  integer, parameter :: most_in_block = 12
  ! Least share of what a circle has alone that may be left of it in a block.
  real(real64), parameter :: least_pivot = 0.05_real64

contains

  !> Finds and factors the blocks.
  subroutine find_blocks(set, blocks)
    type(circle_set), intent(in) :: set          !! its field is known, and who is held
    type(circle_blocks), intent(out) :: blocks   !! of all circles
    logical :: joins(size(set%one))
    integer :: slot(size(set%x)), k, m

    !$omp parallel do schedule(static) if(size(joins) > many)
    do k = 1, size(joins)
      joins(k) = are_close(set, set%one(k), set%other(k), 1.0_real64)
    end do
    !$omp end parallel do
    call gather_groups(set%one, set%other, joins, spread(.true., 1, size(slot)), most_in_block, &
                       blocks%member, blocks%first)
    allocate (blocks%start(size(blocks%first)))
    blocks%start(1) = 1
    do k = 1, size(blocks%first) - 1
      m = blocks%first(k + 1) - blocks%first(k)
      blocks%start(k + 1) = blocks%start(k) + (3 * m)**2
      slot(blocks%member(blocks%first(k):blocks%first(k + 1) - 1)) = k
    end do
    allocate (blocks%factor(blocks%start(size(blocks%start)) - 1))
    !$omp parallel do schedule(static) private(m) if(size(slot) > many)
    do k = 1, size(blocks%first) - 1
      m = 3 * (blocks%first(k + 1) - blocks%first(k))
      call factor_block(set, blocks%member(blocks%first(k):blocks%first(k + 1) - 1), slot, m, &
                        blocks%factor(blocks%start(k):blocks%start(k + 1) - 1))
    end do
    !$omp end parallel do
  end subroutine find_blocks

  ! Second derivatives of a block as `multiply` has them, factored.
  subroutine factor_block(set, member, slot, m, h)
    type(circle_set), intent(in) :: set
    integer, intent(in) :: member(:), slot(:), m
    real(real64), intent(out) :: h(m, m)
    real(real64) :: alone(m), own(m), both(3), x, y
    integer :: a, b, i, j, k, l

    h = 0.0_real64
    do a = 1, size(member)
      i = member(a)
      associate (p => 3 * a - 2)
        alone(p:p + 2) = [1 / set%stiffness(i), set%load(i) * set%curvature(i) * [1, 1]]
        h(p, p) = alone(p) + merge(max(set%growth(i), 0.0_real64), set%growth(i), set%held(i)) / &
                  (3 * set%load(i))
        h(p + 1, p + 1) = 1.0_real64
        h(p + 2, p + 2) = 1.0_real64
        if (set%held(i)) then
          alone(p + 1:p + 2) = 1.0_real64
        else
          h(p + 1, p) = set%move_x(i) * set%curvature(i) + set%steer_x(i)
          h(p + 2, p) = set%move_y(i) * set%curvature(i) + set%steer_y(i)
          h(p + 1, p + 1) = set%bends(1, i) + set%stiffer(i) * alone(p + 1)
          h(p + 2, p + 1) = set%bends(2, i)
          h(p + 2, p + 2) = set%bends(3, i) + set%stiffer(i) * alone(p + 1)
        end if
        do l = set%tree%first(i), set%tree%first(i + 1) - 1
          j = set%tree%near(l)
          if (slot(j) /= slot(i) .or. j < i) cycle
          k = set%pair(l)
          b = findloc(member, j, dim=1)
          associate (q => 3 * b - 2)
            h(q, p) = set%terms(comply, k)
            x = set%terms(east, k)
            y = set%terms(north, k)
            if (.not. set%held(j)) h(q + 1:q + 2, p) = -set%terms(steer_one, k) * set%load(j) * &
                                                       [x, y]
            if (.not. set%held(i)) h(q, p + 1:p + 2) = set%terms(steer_other, k) * set%load(i) * &
                                                       [x, y]
            if (set%held(i) .or. set%held(j)) cycle
            both = -set%load(i) * set%load(j) * between(set, k)
            h(q + 1:q + 2, p + 1) = both(1:2)
            h(q + 1:q + 2, p + 2) = both(2:3)
          end associate
        end do
      end associate
    end do
    own = [(h(j, j), j=1, m)]
    do j = 1, m
      if (.not. h(j, j) > least_pivot * alone(j)) then
        ! Not positive definite: as if this were alone.
        h(j, j) = max(own(j), alone(j))
        h(j + 1:, j) = 0.0_real64
      end if
      do i = j + 1, m
        h(i:, i) = h(i:, i) - h(i:, j) * (h(i, j) / h(j, j))
      end do
      h(j + 1:, j) = h(j + 1:, j) / h(j, j)
    end do
  end subroutine factor_block

  !> Changes that take away what the equations leave over, were there nothing but the blocks.
  subroutine solve_blocks(set, blocks, left, change)
    type(circle_set), intent(in) :: set            !! who is held
    type(circle_blocks), intent(in) :: blocks      !! factored
    real(real64), intent(in) :: left(:, :)         !! (3, circle)
    real(real64), intent(out) :: change(:, :)      !! (3, circle)
    integer :: k

    !$omp parallel do schedule(static) if(size(left, 2) > many)
    do k = 1, size(blocks%first) - 1
      call solve_one(blocks%member(blocks%first(k):blocks%first(k + 1) - 1), &
                     3 * (blocks%first(k + 1) - blocks%first(k)), &
                     blocks%factor(blocks%start(k):blocks%start(k + 1) - 1))
    end do
    !$omp end parallel do

  contains

    subroutine solve_one(member, m, h)
      integer, intent(in) :: member(:), m
      real(real64), intent(in) :: h(m, m)
      real(real64) :: z(3, m / 3), v(m)
      integer :: i

      z = left(:, member)
      do i = 1, size(member)
        if (set%held(member(i))) z(2:, i) = 0.0_real64
      end do
      v = reshape(z, [m])
      do i = 1, m
        v(i + 1:) = v(i + 1:) - h(i + 1:, i) * v(i)
      end do
      do i = m, 1, -1
        v(i) = v(i) / h(i, i) - sum(h(i + 1:, i) * v(i + 1:))
      end do
      change(:, member) = reshape(v, [3, m / 3])
    end subroutine solve_one

  end subroutine solve_blocks

end module asperity_circle_blocks
