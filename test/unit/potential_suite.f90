!> Tests of the potential of loads and shifts: its derivatives, and that it is least where the
!> solver ends. Truths: differences of the energy itself.
module asperity_potential_suite
  use asperity_circle_blocks, only: circle_blocks, factor_blocks, find_blocks, solve_blocks
  use asperity_circle_correction, only: find_curvature_terms
  use asperity_circle_field, only: circle_set, find_field, list_near_circles
  use asperity_circle_products, only: multiply
  use asperity_circle_step, only: circle_model, find_step, prepare_model, trust_step
  use asperity_coupled_scenes, only: random
  use asperity_interruption, only: interruption
  use asperity_kinds, only: int64, real64
  use asperity_testing, only: check, run_test
  implicit none
  private

  public :: run_potential

  real(real64), parameter :: third = 1.0_real64 / 3

contains

  !> Runs the tests.
  subroutine run_potential
    call run_test('the gradient is that of the energy, near and far', gradient)
    call run_test('the gradient of the curvature terms is that of their sum', curvature_terms)
    call run_test('a product is the change of the gradient, near', hessian_near)
    call run_test('a product is the change of the gradient by loads, far', hessian_far)
    call run_test('a product is the change of the gradient among thousands', hessian_of_many)
    call run_test('a block of few circles has all second derivatives', one_block)
    call run_test('a step is the minimum of the model, or ends at the border', steps)
    call run_test('a step keeps the sum of the loads', kept_sum)
  end subroutine run_potential

  ! Circles of spheres of radius 1 in a square of some circles' side, all shifted a little.
  subroutine scatter(n, side, set)
    integer, intent(in) :: n
    real(real64), intent(in) :: side
    type(circle_set), intent(out) :: set
    integer(int64) :: seed
    integer :: i

    seed = 7_int64
    call set%allocate_arrays(n)
    do i = 1, n
      set%contact(i) = i
      set%x(i) = side * random(seed)
      set%y(i) = side * random(seed)
      set%shift(1, i) = 0.2_real64 * random(seed)
      set%shift(2, i) = 0.2_real64 * random(seed)
      set%load(i) = 0.1_real64 + 1.2_real64 * random(seed)
    end do
    set%curvature = 1.0_real64
    call load_up(set)
    call list_near_circles(set)
    call find_field(set)
  end subroutine scatter

  ! Circles and stiffness of the loads, by Hertz: V = 4/3 p**1.5, a = sqrt(p).
  subroutine load_up(set)
    type(circle_set), intent(inout) :: set

    set%radius = (0.75_real64 * set%load)**third
    set%stiffness = 2 * set%radius
  end subroutine load_up

  ! Three changes of a set: state = (load, shift along x and y; circle).
  subroutine change_by(before, step, change, after)
    type(circle_set), intent(in) :: before
    real(real64), intent(in) :: step, change(:, :)
    type(circle_set), intent(inout) :: after

    after%load = before%load + step * change(1, :)
    after%shift = before%shift + step * change(2:, :)
    call load_up(after)
    call find_field(after)
  end subroutine change_by

  ! The potential without gaps and compression, whose terms are plain.
  pure real(real64) function potential(set)
    type(circle_set), intent(in) :: set

    potential = sum(0.6_real64 * set%radius**2 * set%load) + set%energy + &
                sum(set%load * set%curvature * sum(set%shift**2, 1)) / 2
  end function potential

  pure function gradient_of(set) result(gradient)
    type(circle_set), intent(in) :: set
    real(real64) :: gradient(3, size(set%x))

    gradient(1, :) = set%radius**2 + set%displacement + set%curvature * sum(set%shift**2, 1) / 2
    gradient(2:, :) = spread(set%load, 1, 2) * (spread(set%curvature, 1, 2) * set%shift + set%slope)
  end function gradient_of

  ! A direction: all at random, or one number of one circle.
  function direction(n, seed, loads_only) result(change)
    integer, intent(in) :: n
    integer(int64), intent(inout) :: seed
    logical, intent(in) :: loads_only
    real(real64) :: change(3, n)
    integer :: i, k

    do i = 1, n
      do k = 1, 3
        change(k, i) = random(seed) - 0.5_real64
      end do
    end do
    if (loads_only) change(2:, :) = 0.0_real64
  end function direction

  subroutine gradient
    real(real64), parameter :: step = 1.0e-4_real64
    integer, parameter :: n = 24
    type(circle_set) :: set, more, less
    real(real64) :: change(3, n), slope
    integer(int64) :: seed
    integer :: k

    seed = 3_int64
    ! All near, overlapping; then some far, of which the tilt has all but its own circle's width:
    ! .3 (a/r)**2 at ten radii.
    do k = 1, 20
      call scatter(n, merge(4.0_real64, 60.0_real64, k <= 10), set)
      call check(size(set%one) == n * (n - 1) / 2 .eqv. k <= 10, 'far ones or none')
      more = set
      less = set
      change = direction(n, seed, .false.)
      call change_by(set, step, change, more)
      call change_by(set, -step, change, less)
      slope = (potential(more) - potential(less)) / (2 * step)
      call check(sum(gradient_of(set) * change), slope, &
                 merge(1.0e-6_real64, 1.0e-4_real64, k <= 10), 'slope along a direction')
      change = direction(n, seed, .true.)
      call change_by(set, step, change, more)
      call change_by(set, -step, change, less)
      slope = (potential(more) - potential(less)) / (2 * step)
      call check(sum(gradient_of(set) * change), slope, 1.0e-6_real64, 'slope along loads')
    end do
  end subroutine gradient

  ! Near circles, apart and overlapping; then some far, whose Laplacian is kept without that of the
  ! circle's own width. The places are kept.
  subroutine curvature_terms
    real(real64), parameter :: sides(3) = [7.0_real64, 5.0_real64, 40.0_real64]
    integer, parameter :: numbers(3) = [6, 6, 24]
    real(real64), parameter :: step = 1.0e-4_real64
    type(circle_set) :: set, other
    real(real64), allocatable :: change(:, :), curvature(:, :), gain(:), gradient(:), unused(:)
    real(real64) :: slope, sums(-2:2)
    integer(int64) :: seed
    integer :: k, l

    seed = 5_int64
    do k = 1, 3
      call scatter(numbers(k), sides(k), set)
      allocate (curvature(2, numbers(k)))
      allocate (gain(numbers(k)))
      allocate (gradient, unused, mold=gain)
      set%own_oval = [(0.02_real64 * cmplx(l, 3 - l, real64), l=1, numbers(k))]
      call find_curvature_terms(set, curvature, gain, gradient)
      change = direction(numbers(k), seed, .true.)
      other = set
      do l = -2, 2
        call change_by(set, l * step, change, other)
        call find_curvature_terms(other, curvature, gain, unused)
        sums(l) = sum(gain)
      end do
      ! Five points: the error of the difference is of the fourth order in the step.
      slope = -(8 * (sums(1) - sums(-1)) - (sums(2) - sums(-2))) / (12 * step)
      call check(sum(gradient * change(1, :)) / slope, 1.0_real64, &
                 merge(1.0e-4_real64, 1.0e-7_real64, k == 3), 'slope along loads')
      deallocate (curvature, gain, gradient, unused)
    end do
  end subroutine curvature_terms

  subroutine hessian_near
    call compare_products(4.0_real64, .false., 1.0e-5_real64)
  end subroutine hessian_near

  subroutine hessian_far
    ! Rough sums.
    call compare_products(60.0_real64, .true., 1.0e-4_real64)
  end subroutine hessian_far

  ! Boxes of several levels sum loads and shifts: rough sums.
  subroutine hessian_of_many
    real(real64), parameter :: step = 1.0e-5_real64
    integer, parameter :: n = 3000
    type(circle_set) :: set, more, less
    real(real64), dimension(3, n) :: change, image, truth
    integer(int64) :: seed
    integer :: k

    seed = 17_int64
    call scatter(n, 150.0_real64, set)
    more = set
    less = set
    do k = 1, 2
      change = direction(n, seed, .false.)
      if (k == 2) change(1, :) = 0.0_real64
      call change_by(set, step, change, more)
      call change_by(set, -step, change, less)
      truth = (gradient_of(more) - gradient_of(less)) / (2 * step)
      call multiply(set, .false., change, image)
      call check(norm2(image(1, :) - truth(1, :)), 0.0_real64, &
                 1.0e-3_real64 * norm2(truth(1, :)), 'by loads')
      call check(norm2(image(2:, :) - truth(2:, :)), 0.0_real64, &
                 1.0e-3_real64 * norm2(truth(2:, :)), 'by shifts')
    end do
  end subroutine hessian_of_many

  subroutine compare_products(side, loads_only, tolerance)
    real(real64), intent(in) :: side, tolerance
    logical, intent(in) :: loads_only
    real(real64), parameter :: step = 1.0e-4_real64
    integer, parameter :: n = 24
    type(circle_set) :: set, more, less
    real(real64), dimension(3, n) :: change, image, truth
    integer(int64) :: seed
    integer :: k, rows

    rows = merge(1, 3, loads_only)
    seed = 5_int64
    do k = 1, 10
      call scatter(n, side, set)
      more = set
      less = set
      change = direction(n, seed, loads_only)
      call change_by(set, step, change, more)
      call change_by(set, -step, change, less)
      truth = (gradient_of(more) - gradient_of(less)) / (2 * step)
      call multiply(set, .false., change, image)
      call check(maxval(abs(image(:rows, :) - truth(:rows, :))), 0.0_real64, &
                 tolerance * maxval(abs(truth)), 'product')
      call check(maxval(abs(image(:rows, :))) > 0.1_real64, 'nothing to compare')
      if (loads_only) cycle
      ! A circle that may not shift has no derivatives by its shift.
      set%shift_fixed(1) = .true.
      call multiply(set, .false., change, image)
      call check(maxval(abs(image(2:, 1))), 0.0_real64, 0.0_real64, 'still')
    end do
  end subroutine compare_products

  ! Circles that are all in one block: its solution, multiplied, is the right-hand side again.
  subroutine one_block
    integer, parameter :: n = 6
    type(circle_set) :: set
    type(circle_blocks) :: blocks
    real(real64) :: left(3, n), change(3, n), image(3, n)
    integer(int64) :: seed
    integer :: k

    seed = 19_int64
    call scatter(n, 3.0_real64, set)
    ! Stiff against shifts: the second derivatives are positive definite.
    set%far_hessian([1, 3], :) = set%far_hessian([1, 3], :) + 20
    set%hessian([1, 3], :) = set%hessian([1, 3], :) + 20 * spread(set%load, 1, 2)
    set%stiffness = 0.3_real64 * set%stiffness
    call find_blocks(set, blocks)
    call check(size(blocks%first), 2, 'one block')
    do k = 1, 2
      left = direction(n, seed, .false.)
      call factor_blocks(set, k == 2, blocks)
      call solve_blocks(blocks, left, change)
      call multiply(set, k == 2, change, image)
      call check(maxval(abs(image - left)), 0.0_real64, 1.0e-10_real64, &
                 merge('convex', 'exact ', k == 2))
    end do
  end subroutine one_block

  subroutine steps
    integer, parameter :: n = 30
    type(circle_set) :: set
    type(circle_model) :: model
    type(trust_step) :: step, short
    type(interruption) :: never
    real(real64) :: image(3, n), radius, length
    integer(int64) :: seed
    integer :: products

    seed = 23_int64
    call scatter(n, 30.0_real64, set)
    allocate (model%gradient, source=direction(n, seed, .false.))
    call prepare_model(set, model)
    products = 0
    radius = 1.0e6_real64
    call find_step(set, model, 1.0e-10_real64, radius, step, products, never)
    call check(.not. (step%at_border .or. step%curves_down), 'inside')
    call multiply(set, .false., step%change, image)
    call check(maxval(abs(image + model%gradient)), 0.0_real64, 1.0e-8_real64, 'minimum')
    call check(step%decrease, -0.5_real64 * sum(model%gradient * step%change), &
               1.0e-8_real64 * step%decrease, 'decrease')
    radius = 0.3_real64 * step%length
    call find_step(set, model, 1.0e-10_real64, radius, short, products, never)
    length = sqrt(sum((model%weight * short%change)**2))
    call check(short%at_border, 'border')
    call check(length, radius, 1.0e-12_real64 * radius, 'length')
    call multiply(set, .false., short%change, image)
    call check(short%decrease, -sum((model%gradient + image / 2) * short%change), &
               1.0e-10_real64 * step%decrease, 'decrease at the border')
    ! That along the Newton step to the same length is less or equal.
    call check(short%decrease > 0.3_real64 * step%decrease, 'less than a shortened step')
  end subroutine steps

  subroutine kept_sum
    integer, parameter :: n = 30
    type(circle_set) :: set
    type(circle_model) :: model
    type(trust_step) :: step
    type(interruption) :: never
    real(real64) :: image(3, n), rest(n), radius
    integer(int64) :: seed
    integer :: products, i

    seed = 29_int64
    call scatter(n, 30.0_real64, set)
    set%load_share = [(1 + 0.01_real64 * i, i=1, n)]
    allocate (model%gradient, source=direction(n, seed, .false.))
    model%keep_sum = .true.
    call prepare_model(set, model)
    products = 0
    radius = 1.0e6_real64
    call find_step(set, model, 1.0e-9_real64, radius, step, products, never)
    call check(sum(set%load_share * step%change(1, :)), 0.0_real64, &
               1.0e-12_real64 * sum(abs(step%change(1, :))), 'sum of the loads')
    ! What is left is one multiple of the weights: the Lagrangian is stationary.
    call multiply(set, .false., step%change, image)
    rest = (image(1, :) + model%gradient(1, :)) / set%load_share
    call check(maxval(rest) - minval(rest), 0.0_real64, 1.0e-8_real64, 'multiplier')
    call check(maxval(abs(image(2:, :) + model%gradient(2:, :))), 0.0_real64, &
               1.0e-8_real64, 'shifts')
  end subroutine kept_sum

end module asperity_potential_suite
