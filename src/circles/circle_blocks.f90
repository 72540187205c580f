!> Block-Jacobi preconditioner of the coupled contacts, which is also the norm of their steps.
!>
!> Circles that overlap or nearly touch form a block. Its matrix is the exact Hessian where that is
!> positive definite, else that of the convex model (circle_products), factored as L D L'.
module asperity_circle_blocks
  use asperity_circle_field, only: are_close, circle_set, close_distance, compliance, direction_x, &
                                   direction_y, first_slope, large_set, pair_hessian, second_slope
  use asperity_coarse_circles, only: circles_per_square
  use asperity_circle_products, only: convex_hessian
  use asperity_index_groups, only: gather_groups
  use asperity_kinds, only: real64
  implicit none
  private

  public :: circle_blocks, factor_blocks, find_blocks, solve_blocks

  !> Blocks of circles and their factors.
  type :: circle_blocks
    integer, allocatable :: member(:), first(:)     !! circles of each block
    integer, allocatable :: block_of(:)             !! block of each circle
    integer, allocatable :: start(:)                !! first element of each block in `factor`
    real(real64), allocatable :: factor(:)          !! L of L D L', with D as its diagonal
  end type circle_blocks

contains

  !> Finds the blocks.
  subroutine find_blocks(set, blocks)
    type(circle_set), intent(in) :: set          !! circles with their near pairs
    type(circle_blocks), intent(out) :: blocks   !! of all circles, not factored
    logical :: overlap(size(set%one)), near(size(set%one))
    integer :: k, m

    !$omp parallel do schedule(static) if(size(near) > large_set)
    do k = 1, size(near)
      overlap(k) = are_close(set, set%one(k), set%other(k), 1.0_real64)
      near(k) = are_close(set, set%one(k), set%other(k), close_distance) .and. .not. overlap(k)
    end do
    !$omp end parallel do
    ! Pairs that overlap are linked first, as the size of a block is limited.
    allocate (blocks%block_of(size(set%x)))
    call gather_groups([pack(set%one, overlap), pack(set%one, near)], &
                       [pack(set%other, overlap), pack(set%other, near)], &
                       spread(.true., 1, count(overlap) + count(near)), &
                       spread(.true., 1, size(set%x)), int(circles_per_square), blocks%member, &
                       blocks%first)
    allocate (blocks%start(size(blocks%first)))
    blocks%start(1) = 1
    do k = 1, size(blocks%first) - 1
      m = blocks%first(k + 1) - blocks%first(k)
      blocks%start(k + 1) = blocks%start(k) + (3 * m)**2
      blocks%block_of(blocks%member(blocks%first(k):blocks%first(k + 1) - 1)) = k
    end do
    allocate (blocks%factor(blocks%start(size(blocks%start)) - 1))
  end subroutine find_blocks

  !> Factors the blocks.
  subroutine factor_blocks(set, convex, blocks)
    type(circle_set), intent(in) :: set           !! circles with their field
    logical, intent(in) :: convex                 !! the convex model in place of the exact one
    type(circle_blocks), intent(inout) :: blocks  !! members of blocks are set
    integer :: k
    logical :: is_definite

    !$omp parallel do schedule(dynamic, 64) private(is_definite) if(size(set%x) > large_set)
    do k = 1, size(blocks%first) - 1
      associate (member => blocks%member(blocks%first(k):blocks%first(k + 1) - 1), &
                 factor => blocks%factor(blocks%start(k):blocks%start(k + 1) - 1))
        is_definite = .false.
        if (.not. convex) &
          call factor_block(set, member, blocks%block_of, .false., 3 * size(member), factor, &
                            is_definite)
        if (.not. is_definite) &
          call factor_block(set, member, blocks%block_of, .true., 3 * size(member), factor, &
                            is_definite)
      end associate
    end do
    !$omp end parallel do
  end subroutine factor_blocks

  ! Factors one block. The convex model raises pivots, which vanish for concentric circles; the
  ! exact model is not definite where a pivot is too small.
  pure subroutine factor_block(set, member, block_of, convex, m, h, is_definite)
    type(circle_set), intent(in) :: set
    integer, intent(in) :: member(:), block_of(:), m
    logical, intent(in) :: convex
    real(real64), intent(out) :: h(m, m)
    logical, intent(out) :: is_definite
    real(real64) :: isolated(m)
    integer :: i, j

    is_definite = .false.
    call fill_block(set, member, block_of, convex, m, h, isolated)
    do j = 1, m
      if (.not. h(j, j) > sqrt(epsilon(h)) * isolated(j)) then
        if (.not. convex) return
        h(j, j) = isolated(j)
        h(j + 1:, j) = 0.0_real64
      end if
      do i = j + 1, m
        h(i:, i) = h(i:, i) - h(i:, j) * (h(i, j) / h(j, j))
      end do
      h(j + 1:, j) = h(j + 1:, j) / h(j, j)
    end do
    is_definite = .true.
  end subroutine factor_block

  ! Fills the lower half of a block with the second derivatives of `multiply`, and a vector with
  ! those of isolated contacts.
  pure subroutine fill_block(set, member, block_of, convex, m, h, isolated)
    type(circle_set), intent(in) :: set
    integer, intent(in) :: member(:), block_of(:), m
    logical, intent(in) :: convex
    real(real64), intent(out) :: h(m, m), isolated(m)
    real(real64) :: b(3), x, y
    integer :: a, i, j, k, l

    h = 0.0_real64
    do a = 1, size(member)
      i = member(a)
      associate (p => 3 * a - 2, growth_term => set%growth(i) / (3 * set%load(i)))
        isolated(p:p + 2) = [1 / set%stiffness(i), set%load(i) * set%curvature(i) * [1, 1]]
        if (set%shift_fixed(i)) isolated(p + 1:p + 2) = 1.0_real64
        b = set%hessian(:, i)
        if (convex) b = convex_hessian(b, isolated(p + 1))
        if (set%shift_fixed(i)) b = [1, 0, 1]
        h(p, p) = isolated(p) + merge(max(growth_term, 0.0_real64), growth_term, convex)
        h(p + 1, p + 1) = b(1)
        h(p + 2, p + 1) = b(2)
        h(p + 2, p + 2) = b(3)
        if (.not. (convex .or. set%shift_fixed(i))) &
          h(p + 1:p + 2, p) = set%shift(:, i) * set%curvature(i) + set%flat_slope(:, i)
        do l = set%tree%first(i), set%tree%first(i + 1) - 1
          j = set%tree%near(l)
          if (block_of(j) /= block_of(i) .or. j < i) cycle
          k = set%pair(l)
          associate (q => 3 * findloc(member, j, dim=1) - 2)
            h(q, p) = set%terms(compliance, k)
            if (convex) cycle
            x = set%terms(direction_x, k)
            y = set%terms(direction_y, k)
            if (.not. set%shift_fixed(j)) h(q + 1:q + 2, p) = -set%terms(first_slope, k) * &
              set%load(j) * &
                                                              [x, y]
            if (.not. set%shift_fixed(i)) h(q, p + 1:p + 2) = set%terms(second_slope, k) * &
                                                              set%load(i) * [x, y]
            if (set%shift_fixed(i) .or. set%shift_fixed(j)) cycle
            b = -set%load(i) * set%load(j) * pair_hessian(set, k)
            h(q + 1:q + 2, p + 1) = b(1:2)
            h(q + 1:q + 2, p + 2) = b(2:3)
          end associate
        end do
      end associate
    end do
  end subroutine fill_block

  !> Solves the equations of the blocks.
  subroutine solve_blocks(blocks, left, change)
    type(circle_blocks), intent(in) :: blocks      !! blocks with their factors
    real(real64), intent(in) :: left(:, :)         !! right-hand sides (3, circle)
    real(real64), intent(out) :: change(:, :)      !! solutions (3, circle)
    integer :: k

    !$omp parallel do schedule(static) if(size(left, 2) > large_set)
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
      real(real64) :: v(m)
      integer :: i

      do i = 1, size(member)
        v(3 * i - 2:3 * i) = left(:, member(i))
      end do
      do i = 1, m
        v(i + 1:) = v(i + 1:) - h(i + 1:, i) * v(i)
      end do
      do i = m, 1, -1
        v(i) = v(i) / h(i, i) - sum(h(i + 1:, i) * v(i + 1:))
      end do
      do i = 1, size(member)
        change(:, member(i)) = v(3 * i - 2:3 * i)
      end do
    end subroutine solve_one

  end subroutine solve_blocks

end module asperity_circle_blocks
