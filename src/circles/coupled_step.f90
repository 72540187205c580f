!> One Newton step of coupled contacts, by preconditioned conjugate gradients.
!>
!> The preconditioner inverts the second derivatives of contacts that overlap, block by block: how
!> two contacts at nearly the same place share their load hardly matters, so that these derivatives
!> are nearly singular. It changes the number of products, not the result.
module asperity_coupled_step
  use asperity_circle_field, only: are_close, between, circle_set, comply, east, many, north, &
                                   steer_one, steer_other
  use asperity_circle_products, only: multiply, shift_down
  use asperity_coarse_circles, only: circles_in_one, coarse_circles, gather_squares, &
                                     shared_change, sum_of_squares
  use asperity_index_groups, only: gather_groups
  use asperity_interruption, only: interruption
  use asperity_kinds, only: real64
  implicit none
  private

  public :: newton_step

  ! Rounds of conjugate gradients; what is there then is a direction that goes down as well.
  integer, parameter :: most_rounds = 400
  ! The next four constants change the path of the minimisation and not its result: the line search
  ! requires a decrease of the potential, and the norm of the gradient decides on convergence.
  ! Shifts stay fixed while the relative residual of the gradient is above this value.
  real(real64), parameter :: far_off = 0.1_real64
  ! Near pairs are stiffened where the potential is nearly flat, by how far off all is times this.
  real(real64), parameter :: flat = 3.0_real64

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

  !> The step that makes the gradient of the potential zero to first order, to an accuracy, or goes
  !> down at least.
  !>
  !> Loads alone, with growth of 0 at least, have positive definite second derivatives. So shifts
  !> are stiffened or held out of the equations, and go down by themselves, where the potential
  !> curves down along the loads and shifts of a block; far from the solution all are, as long as
  !> the loads have more to do than they. Where it curves down all the same, all are stiffened more
  !> and more, and held at last: each by itself, shifts that block each other would creep.
  subroutine newton_step(set, gradient, keep_sum, accuracy, off, step, rounds, interrupt)
    type(circle_set), intent(inout) :: set      !! its field is known; stays
    real(real64), intent(in) :: gradient(:, :)  !! (3, circle): by load, by shift along x and y
    logical, intent(in) :: keep_sum             !! the changes of the loads add up to zero
    real(real64), intent(in) :: accuracy        !! share of the gradient that may remain
    real(real64), intent(in) :: off             !! how far the equations are off, a share
    real(real64), intent(out) :: step(:, :)     !! (3, circle)
    integer, intent(inout) :: rounds            !! products, counted on
    type(interruption), intent(in) :: interrupt !! of the run: the step is of no use then
    real(real64), allocatable, dimension(:, :) :: left, scaled, direction, image
    real(real64), allocatable :: even(:, :)
    type(circle_blocks) :: blocks
    type(coarse_circles) :: coarse
    real(real64) :: size_now, size_first, curvature, part
    integer :: i, round

    allocate (scaled, direction, image, mold=gradient)
    allocate (left, source=-gradient)
    step = 0.0_real64
    if (size(set%x) > circles_in_one) call gather_squares(set%x, set%y, coarse)
    ! What all alike would change, to be taken off where the sum is kept.
    allocate (even, mold=gradient)
    even = 0.0_real64
    set%stiffer = 0.0_real64
    call find_blocks(set, blocks)
    call prepare_blocks()
    if (accuracy >= far_off) then
      call precondition(set, blocks, coarse, even, left, scaled)
      if (sum(left(2:, :) * scaled(2:, :)) < sum(left(1, :) * scaled(1, :))) then
        set%held = .true.
        call prepare_blocks()
      end if
    end if
    do
      call precondition(set, blocks, coarse, even, left, scaled)
      direction = scaled
      size_now = sum(left * scaled)
      size_first = size_now
      curvature = 1.0_real64
      do round = 1, most_rounds
        if (.not. size_now > accuracy**2 * size_first .or. interrupt%is_asked()) exit
        call multiply(set, direction, image)
        rounds = rounds + 1
        curvature = sum(direction * image)
        if (.not. curvature > 0.0_real64) exit
        part = size_now / curvature
        step = step + part * direction
        left = left - part * image
        call precondition(set, blocks, coarse, even, left, scaled)
        ! The squares are not solved exactly: each direction against the last one.
        direction = scaled - (part * sum(scaled * image) / size_now) * direction
        size_now = sum(left * scaled)
      end do
      if (curvature > 0.0_real64 .or. all(set%held) .or. interrupt%is_asked()) exit
      ! It curves down all the same.
      set%held = set%held .or. set%stiffer > 1.0_real64
      set%stiffer = max(4 * set%stiffer, flat * off, epsilon(off))
      step = 0.0_real64
      left = -gradient
      call prepare_blocks()
    end do
    do i = 1, size(set%x)
      if (set%held(i) .and. .not. set%still(i)) &
        step(2:, i) = shift_down(set%bends(:, i), set%load(i) * set%curvature(i), gradient(2:, i))
    end do

  contains

    ! The blocks, their sums over squares, and what all alike would change.
    subroutine prepare_blocks()
      real(real64), allocatable :: ones(:, :)

      call factor_blocks(set, flat * off, blocks)
      allocate (ones(3, size(set%x)), source=0.0_real64)
      ones(1, :) = 1.0_real64
      even = 0.0_real64
      if (allocated(coarse%square)) then
        ! A block in one square: what it answers to that is then known by the sum.
        do i = 1, size(blocks%first) - 1
          associate (member => blocks%member(blocks%first(i):blocks%first(i + 1) - 1))
            coarse%square(member) = coarse%square(member(1))
          end associate
        end do
        coarse%answer = ones
        call solve_blocks(set, blocks, ones, coarse%answer)
        coarse%stiffness = sum_of_squares(coarse, coarse%answer(1, :))
      end if
      if (.not. keep_sum) return
      call precondition(set, blocks, coarse, even, ones, scaled)
      even = scaled
    end subroutine prepare_blocks

  end subroutine newton_step

  ! As if there were nothing but blocks; many also in squares: the inverse of blocks and of what
  ! squares full of circles do to each other.
  subroutine precondition(set, blocks, coarse, even, left, scaled)
    type(circle_set), intent(in) :: set
    type(circle_blocks), intent(in) :: blocks
    type(coarse_circles), intent(inout) :: coarse
    real(real64), intent(in) :: even(:, :), left(:, :)
    real(real64), intent(out) :: scaled(:, :)
    real(real64), allocatable :: lowered(:)
    integer :: i

    call solve_blocks(set, blocks, left, scaled)
    if (allocated(coarse%square)) then
      lowered = sum_of_squares(coarse, scaled(1, :))
      where (coarse%stiffness > 0.0_real64) lowered = lowered / coarse%stiffness
      lowered = lowered - shared_change(coarse, lowered)
      !$omp parallel do schedule(static)
      do i = 1, size(left, 2)
        scaled(:, i) = scaled(:, i) - lowered(coarse%square(i)) * coarse%answer(:, i)
      end do
      !$omp end parallel do
    end if
    if (sum(even(1, :)) > 0.0_real64) &
      scaled = scaled - even * (sum(scaled(1, :)) / sum(even(1, :)))
  end subroutine precondition

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

end module asperity_coupled_step
