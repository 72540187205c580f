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

  public :: circle_blocks, factor_blocks, find_blocks, solve_blocks

  !> Factors of the blocks.
  type :: circle_blocks
    integer, allocatable :: member(:), first(:)     !! circles of each block
    integer, allocatable :: slot(:)                 !! block of each circle
    integer, allocatable :: start(:)                !! where its factor begins
    real(real64), allocatable :: factor(:)          !! L of L D L', its diagonal D
  end type circle_blocks

  ! Circles in a block at most: factors take the third power of it. Sums of radii up to which they
  ! may be in one: those farther off curve down together only far from the solution.
  integer, parameter :: most_in_block = 12
  real(real64), parameter :: close_by = 1.5_real64
  ! Least share of what a circle has alone that may be left of it in a block.
  real(real64), parameter :: least_pivot = 0.05_real64

contains

  !> Finds the blocks.
  subroutine find_blocks(set, blocks)
    type(circle_set), intent(in) :: set          !! places and near pairs are known
    type(circle_blocks), intent(out) :: blocks   !! of all circles, not factored
    logical :: overlap(size(set%one)), near(size(set%one))
    integer :: k, m

    !$omp parallel do schedule(static) if(size(near) > many)
    do k = 1, size(near)
      overlap(k) = are_close(set, set%one(k), set%other(k), 1.0_real64)
      near(k) = are_close(set, set%one(k), set%other(k), close_by) .and. .not. overlap(k)
    end do
    !$omp end parallel do
    ! Those that overlap come first.
    allocate (blocks%slot(size(set%x)))
    call gather_groups([pack(set%one, overlap), pack(set%one, near)], &
                       [pack(set%other, overlap), pack(set%other, near)], &
                       spread(.true., 1, count(overlap) + count(near)), &
                       spread(.true., 1, size(set%x)), most_in_block, blocks%member, blocks%first)
    allocate (blocks%start(size(blocks%first)))
    blocks%start(1) = 1
    do k = 1, size(blocks%first) - 1
      m = blocks%first(k + 1) - blocks%first(k)
      blocks%start(k + 1) = blocks%start(k) + (3 * m)**2
      blocks%slot(blocks%member(blocks%first(k):blocks%first(k + 1) - 1)) = k
    end do
    allocate (blocks%factor(blocks%start(size(blocks%start)) - 1))
  end subroutine find_blocks

  !> Factors the blocks. Where the potential curves down along the loads and shifts of one, its
  !> shifts are stiffened so that it does not, by no more than twice what that takes: a contact that
  !> may slide around another must not creep. Where the curvature alone does not do, they are held.
  subroutine factor_blocks(set, margin, blocks)
    type(circle_set), intent(inout) :: set        !! its field is known; gets who is stiffer or held
    real(real64), intent(in) :: margin            !! share of the second derivatives that is left
    type(circle_blocks), intent(inout) :: blocks  !! found
    integer :: k

    !$omp parallel do schedule(dynamic, 64) if(size(set%x) > many)
    do k = 1, size(blocks%first) - 1
      call factor_block(set, blocks%member(blocks%first(k):blocks%first(k + 1) - 1), blocks%slot, &
                        3 * (blocks%first(k + 1) - blocks%first(k)), margin, &
                        blocks%factor(blocks%start(k):blocks%start(k + 1) - 1))
    end do
    !$omp end parallel do
  end subroutine factor_blocks

  subroutine factor_block(set, member, slot, m, margin, h)
    type(circle_set), intent(inout) :: set
    integer, intent(in) :: member(:), slot(:), m
    real(real64), intent(in) :: margin
    real(real64), intent(out) :: h(m, m)
    real(real64) :: alone(m), least
    integer :: i, j

    do
      call fill_block(set, member, slot, m, h, alone)
      least = margin
      if (all(set%held(member))) least = least_pivot
      do j = 1, m
        if (.not. h(j, j) > least * alone(j)) then
          if (.not. all(set%held(member))) exit
          ! Loads of circles nearly in one place: as if this were alone.
          h(j, j) = alone(j)
          h(j + 1:, j) = 0.0_real64
        end if
        do i = j + 1, m
          h(i:, i) = h(i:, i) - h(i:, j) * (h(i, j) / h(j, j))
        end do
        h(j + 1:, j) = h(j + 1:, j) / h(j, j)
      end do
      if (j > m) exit
      set%stiffer(member) = max(margin, epsilon(margin), 2 * set%stiffer(member(1)))
      if (set%stiffer(member(1)) > 1.0_real64) set%held(member) = .true.
    end do
  end subroutine factor_block

  ! Second derivatives of a block as `multiply` has them, and what each circle has of them alone.
  subroutine fill_block(set, member, slot, m, h, alone)
    type(circle_set), intent(in) :: set
    integer, intent(in) :: member(:), slot(:), m
    real(real64), intent(out) :: h(m, m), alone(m)
    real(real64) :: both(3), x, y
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
          h(p + 1:p + 2, p) = set%move(:, i) * set%curvature(i) + set%steer(:, i)
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
  end subroutine fill_block

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
      real(real64) :: v(m)
      integer :: i

      do i = 1, size(member)
        v(3 * i - 2:3 * i) = left(:, member(i))
        if (set%held(member(i))) v(3 * i - 1:3 * i) = 0.0_real64
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
