!> One Newton step of coupled contacts, by conjugate gradients.
module asperity_coupled_step
  use asperity_circle_field, only: circle_set, many
  use asperity_circle_products, only: hold_bent, multiply, shift_down
  use asperity_coarse_circles, only: coarse_circles, gather_squares, shared_change, sum_of_squares
  use asperity_kinds, only: real64
  implicit none
  private

  public :: newton_step

  ! Rounds of conjugate gradients; what is there then is a direction that goes down as well.
  integer, parameter :: most_rounds = 400
  ! These four choose the way and not its end: the step is cut until it goes down, and what is left
  ! of the gradient tells when the solution is there.
  ! Along a direction that the potential curves down along, those circles are held that have more
  ! than this share of the most.
  real(real64), parameter :: share_held = 0.1_real64
  ! What is there is worth a step when the gradient's square has fallen to this share.
  real(real64), parameter :: worth_a_step = 0.5_real64
  ! Shifts wait for loads where no less than this share of the gradient is asked for.
  real(real64), parameter :: far_off = 0.1_real64
  ! Near pairs are stiffened where the potential is nearly flat, by how far off all is times this.
  real(real64), parameter :: flat = 3.0_real64

contains

  !> The step that makes the gradient of the potential zero to first order, to an accuracy, or goes
  !> down at least.
  !>
  !> Loads alone, with growth of 0 at least, have positive definite second derivatives. So a shift
  !> is held out of the equations, and goes down by itself, where the potential curves down along
  !> the loads and shifts of a near pair; far from the solution all are, as long as the loads have
  !> more to do than they. Where it curves down all the same, the steps before it are kept (Nocedal
  !> and Wright, Numerical Optimization, 2006, algorithm 7.1), or all shifts are held.
  subroutine newton_step(set, gradient, keep_sum, accuracy, off, step, rounds)
    type(circle_set), intent(inout) :: set      !! its field is known; stays
    real(real64), intent(in) :: gradient(:, :)  !! (3, circle): by load, by shift along x and y
    logical, intent(in) :: keep_sum             !! the changes of the loads add up to zero
    real(real64), intent(in) :: accuracy        !! share of the gradient that may remain
    real(real64), intent(in) :: off             !! how far the equations are off, a share
    real(real64), intent(out) :: step(:, :)     !! (3, circle)
    integer, intent(inout) :: rounds            !! products, counted on
    real(real64), allocatable, dimension(:, :) :: left, scaled, direction, image
    real(real64), allocatable :: even(:), bent(:)
    type(coarse_circles) :: coarse
    real(real64) :: size_now, size_first, curvature, part
    integer :: i, round

    allocate (scaled, direction, image, mold=gradient)
    allocate (left, source=-gradient)
    step = 0.0_real64
    if (size(set%x) > many) then
      call gather_squares(set%x, set%y, coarse)
      coarse%stiffness = sum_of_squares(coarse, set%stiffness)
    end if
    ! What all alike would change, to be taken off where the sum is kept.
    allocate (even(size(set%x)), source=0.0_real64)
    if (keep_sum) call find_loads(set, coarse, spread(1.0_real64, 1, size(even)), even)
    call precondition(set, coarse, even, left, scaled)
    if (accuracy >= far_off .and. &
        sum(left(2:, :) * scaled(2:, :)) < sum(left(1, :) * scaled(1, :))) set%held = .true.
    call hold_bent(set, flat * off)
    size_first = -1.0_real64
    do
      call precondition(set, coarse, even, left, scaled)
      direction = scaled
      size_now = sum(left * scaled)
      if (size_first < 0.0_real64) size_first = size_now
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
        call precondition(set, coarse, even, left, scaled)
        ! The squares are not solved exactly: each direction against the last one.
        direction = scaled - (part * sum(scaled * image) / size_now) * direction
        size_now = sum(left * scaled)
      end do
      if (curvature > 0.0_real64 .or. all(set%held)) exit
      bent = sum(direction * image, dim=1)
      set%held = set%held .or. bent < share_held * minval(bent) .or. &
                 size_now > worth_a_step * size_first
      if (.not. all(set%held)) exit
      step(2:, :) = 0.0_real64
      call multiply(set, step, image)
      rounds = rounds + 1
      left = -gradient - image
    end do
    do i = 1, size(set%x)
      if (set%held(i) .and. .not. set%still(i)) &
        step(2:, i) = shift_down(set%bends(:, i), set%load(i) * set%curvature(i), gradient(2:, i))
    end do
  end subroutine newton_step

  ! As if each contact were alone; many also in squares.
  subroutine precondition(set, coarse, even, left, scaled)
    type(circle_set), intent(in) :: set
    type(coarse_circles), intent(inout) :: coarse
    real(real64), intent(in) :: even(:), left(:, :)
    real(real64), intent(out) :: scaled(:, :)
    integer :: i

    scaled = 0.0_real64
    call find_loads(set, coarse, left(1, :), scaled(1, :))
    if (sum(even) > 0.0_real64) scaled(1, :) = scaled(1, :) - even * (sum(scaled(1, :)) / sum(even))
    do i = 1, size(set%x)
      if (.not. set%held(i)) scaled(2:, i) = &
          shift_down(set%bends(:, i) + set%stiffer(i) * set%load(i) * set%curvature(i) * &
                     [1, 0, 1], set%load(i) * set%curvature(i), -left(2:, i))
    end do
  end subroutine precondition

  ! Changes of load for what the equations leave over, were circles lowered by squares full of them
  ! alone: the inverse of 1/k and what squares do.
  subroutine find_loads(set, coarse, left, loads)
    type(circle_set), intent(in) :: set
    type(coarse_circles), intent(inout) :: coarse
    real(real64), intent(in) :: left(:)
    real(real64), intent(out) :: loads(:)
    real(real64), allocatable :: lowered(:)

    loads = set%stiffness * left
    if (.not. allocated(coarse%square)) return
    lowered = sum_of_squares(coarse, loads)
    where (coarse%stiffness > 0.0_real64) lowered = lowered / coarse%stiffness
    lowered = lowered - shared_change(coarse, lowered)
    loads = loads - set%stiffness * lowered(coarse%square)
  end subroutine find_loads

end module asperity_coupled_step
