!> One Newton step of coupled contacts, by conjugate gradients.
module asperity_coupled_step
  use asperity_circle_field, only: circle_set, many, multiply
  use asperity_coarse_circles, only: coarse_circles, factor_squares, gather_squares, &
                                     shared_change, sum_of_squares
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
    type(coarse_circles) :: coarse
    real(real64), allocatable :: even(:)
    integer :: round

    allocate (scaled, direction, image, mold=gradient)
    allocate (left, source=-gradient)
    step = 0.0_real64
    if (size(set%x) > many) then
      call gather_squares(set%x, set%y, coarse)
      call factor_squares(coarse, set%stiffness)
    end if
    ! What all alike would change, to be taken off where the sum is kept.
    allocate (even(size(set%x)), source=0.0_real64)
    if (keep_sum) call add_loads(set, coarse, spread(1.0_real64, 1, size(even)), even)
    call precondition(set, coarse, even, left, scaled)
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
      call precondition(set, coarse, even, left, scaled)
      size_before = size_now
      size_now = sum(left * scaled)
      direction = scaled + (size_now / size_before) * direction
    end do
  end subroutine newton_step

  ! As if each contact were alone; many also in squares.
  subroutine precondition(set, coarse, even, left, scaled)
    type(circle_set), intent(in) :: set
    type(coarse_circles), intent(in) :: coarse
    real(real64), intent(in) :: even(:), left(:, :)
    real(real64), intent(out) :: scaled(:, :)
    integer :: i

    scaled = 0.0_real64
    call add_loads(set, coarse, left(1, :), scaled(1, :))
    if (sum(even) > 0.0_real64) scaled(1, :) = scaled(1, :) - even * (sum(scaled(1, :)) / sum(even))
    do i = 1, size(set%x)
      if (.not. set%still(i)) scaled(2:, i) = left(2:, i) / (set%load(i) * set%curvature(i))
    end do
  end subroutine precondition

  ! Changes of load for what the equations leave over: each alone, and in squares.
  subroutine add_loads(set, coarse, left, loads)
    type(circle_set), intent(in) :: set
    type(coarse_circles), intent(in) :: coarse
    real(real64), intent(in) :: left(:)
    real(real64), intent(inout) :: loads(:)
    real(real64), allocatable :: shared(:)

    loads = loads + set%stiffness * left
    if (.not. allocated(coarse%square)) return
    shared = shared_change(coarse, sum_of_squares(coarse, set%stiffness * left))
    loads = loads + set%stiffness * shared(coarse%square)
  end subroutine add_loads

end module asperity_coupled_step
