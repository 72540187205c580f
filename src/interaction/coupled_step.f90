!> One Newton step of coupled contacts, by conjugate gradients.
module asperity_coupled_step
  use asperity_circle_blocks, only: circle_blocks, factor_blocks, find_blocks, solve_blocks
  use asperity_circle_field, only: circle_set
  use asperity_circle_products, only: multiply, shift_down
  use asperity_coarse_circles, only: circles_in_one, coarse_circles, gather_squares, &
                                     shared_change, sum_of_squares
  use asperity_kinds, only: real64
  implicit none
  private

  public :: newton_step

  ! Rounds of conjugate gradients; what is there then is a direction that goes down as well.
  integer, parameter :: most_rounds = 400
  ! These four choose the way and not its end: the step is cut until it goes down, and what is left
  ! of the gradient tells when the solution is there.
  ! Shifts wait for loads where no less than this share of the gradient is asked for.
  real(real64), parameter :: far_off = 0.1_real64
  ! Near pairs are stiffened where the potential is nearly flat, by how far off all is times this.
  real(real64), parameter :: flat = 3.0_real64

contains

  !> The step that makes the gradient of the potential zero to first order, to an accuracy, or goes
  !> down at least.
  !>
  !> Loads alone, with growth of 0 at least, have positive definite second derivatives. So shifts
  !> are stiffened or held out of the equations, and go down by themselves, where the potential
  !> curves down along the loads and shifts of a block; far from the solution all are, as long as
  !> the loads have more to do than they. Where it curves down all the same, all are stiffened more
  !> and more, and held at last: each by itself, shifts that block each other would creep.
  subroutine newton_step(set, gradient, keep_sum, accuracy, off, step, rounds)
    type(circle_set), intent(inout) :: set      !! its field is known; stays
    real(real64), intent(in) :: gradient(:, :)  !! (3, circle): by load, by shift along x and y
    logical, intent(in) :: keep_sum             !! the changes of the loads add up to zero
    real(real64), intent(in) :: accuracy        !! share of the gradient that may remain
    real(real64), intent(in) :: off             !! how far the equations are off, a share
    real(real64), intent(out) :: step(:, :)     !! (3, circle)
    integer, intent(inout) :: rounds            !! products, counted on
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
        if (.not. size_now > accuracy**2 * size_first) exit
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
      if (curvature > 0.0_real64 .or. all(set%held)) exit
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
      real(real64) :: ones(3, size(set%x))

      call factor_blocks(set, flat * off, blocks)
      ones = 0.0_real64
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

end module asperity_coupled_step
