!> One Newton step of coupled contacts, by conjugate gradients.
module asperity_coupled_step
  use asperity_circle_field, only: circle_set, multiply
  use asperity_kinds, only: real64
  implicit none
  private

  public :: newton_step

  ! Rounds of conjugate gradients; what is there then is a direction that goes down as well.
  integer, parameter :: most_rounds = 400

contains

  !> The step that makes the gradient of the potential zero to first order, to an accuracy. Where
  !> the potential curves down along a direction, the steps before it are kept (Nocedal and Wright,
  !> Numerical Optimization, 2006, algorithm 7.1): the result goes down in any case.
  subroutine newton_step(set, gradient, keep_sum, accuracy, step, rounds)
    type(circle_set), intent(inout) :: set      !! its field is known; stays
    real(real64), intent(in) :: gradient(:, :)  !! (3, circle): by load, by shift along x and y
    logical, intent(in) :: keep_sum             !! the changes of the loads add up to zero
    real(real64), intent(in) :: accuracy        !! share of the gradient that may remain
    real(real64), intent(out) :: step(:, :)     !! (3, circle)
    integer, intent(inout) :: rounds            !! products, counted on
    real(real64), allocatable :: left(:, :), scaled(:, :), direction(:, :), image(:, :)
    real(real64) :: size_now, size_first, size_before, curvature, part
    integer :: round

    allocate (scaled, direction, image, mold=gradient)
    allocate (left, source=-gradient)
    step = 0.0_real64
    call precondition(set, keep_sum, left, scaled)
    direction = scaled
    size_now = sum(left * scaled)
    size_first = size_now
    do round = 1, most_rounds
      if (.not. size_now > accuracy**2 * size_first) exit
      call multiply(set, direction, image)
      rounds = rounds + 1
      curvature = sum(direction * image)
      if (.not. curvature > 0.0_real64) then
        if (curvature < 0.0_real64) step = step + (size_now / abs(curvature)) * direction
        exit
      end if
      part = size_now / curvature
      step = step + part * direction
      left = left - part * image
      call precondition(set, keep_sum, left, scaled)
      size_before = size_now
      size_now = sum(left * scaled)
      direction = scaled + (size_now / size_before) * direction
    end do
  end subroutine newton_step

  ! As if each contact were alone.
  subroutine precondition(set, keep_sum, left, scaled)
    type(circle_set), intent(in) :: set
    logical, intent(in) :: keep_sum
    real(real64), intent(in) :: left(:, :)
    real(real64), intent(out) :: scaled(:, :)
    real(real64) :: mean
    integer :: i

    mean = 0.0_real64
    if (keep_sum) mean = dot_product(set%stiffness, left(1, :)) / sum(set%stiffness)
    do i = 1, size(set%x)
      scaled(1, i) = set%stiffness(i) * (left(1, i) - mean)
      scaled(2:, i) = 0.0_real64
      if (.not. set%still(i)) scaled(2:, i) = left(2:, i) / (set%load(i) * set%curvature(i))
    end do
  end subroutine precondition

end module asperity_coupled_step
