!> Solves the trust-region subproblem: min g'd + d'H d/2 for |d| <= radius.
!>
!> Method: truncated conjugate gradients (Steihaug, SIAM J. Numer. Anal. 20 (1983) 626; Toint 1981;
!> Nocedal and Wright, Numerical Optimization, 2006, algorithm 7.2) in the norm of the blocks. The
!> first iterate is the preconditioned gradient, so that a step decreases the model by a share of
!> the decrease by Cauchy's step, as convergence requires (Conn, Gould and Toint, Trust-Region
!> Methods, 2000, theorem 6.4.6). Preconditioner: block Jacobi, and a coarse level of squares for
!> more than `circles_per_square` circles. Exits: the gradient of the model has fallen to a given
!> share; the border is reached; the curvature along a direction is negative (the step then ends on
!> the border).
module asperity_circle_step
  use asperity_circle_blocks, only: circle_blocks, factor_blocks, find_blocks, solve_blocks
  use asperity_circle_field, only: circle_set
  use asperity_circle_products, only: multiply
  use asperity_coarse_circles, only: circles_per_square, coarse_circles, gather_squares, &
                                     shared_change, sum_of_squares
  use asperity_interruption, only: interruption
  use asperity_kinds, only: real64
  implicit none
  private

  public :: circle_model, find_step, prepare_model, trust_step

  !> Quadratic model of the potential about a state.
  type :: circle_model
    real(real64), allocatable :: gradient(:, :)     !! (3, circle): by load, by shift along x and y
    logical :: keep_sum = .false.                   !! the sum of the loads is constrained
    logical :: convex = .false.                     !! the convex model in place of the exact one
    real(real64), allocatable :: weight(:, :)       !! of changes, in the norm
    type(circle_blocks), private :: blocks
    type(coarse_circles), private :: coarse
    ! Under the constraint: weights of the loads in the sum, and their preconditioned direction.
    real(real64), allocatable, private :: load_share(:), projection(:, :)
  end type circle_model

  !> A step and its prediction by the model.
  type :: trust_step
    real(real64), allocatable :: change(:, :)       !! (3, circle): of load, of shift
    real(real64) :: length = 0.0_real64             !! in the norm of the blocks
    real(real64) :: decrease = 0.0_real64           !! predicted, of the potential, 0 or more
    logical :: at_border = .false.                  !! the step ends on the border of the region
    logical :: curves_down = .false.                !! the last direction has negative curvature
  end type trust_step

contains

  !> Factors the blocks of a model and prepares its squares.
  subroutine prepare_model(set, model)
    type(circle_set), intent(inout) :: set      !! circles with their field
    type(circle_model), intent(inout) :: model  !! gradient and kind are set
    real(real64), allocatable :: projection(:, :), ones(:, :)
    real(real64) :: mean_penetration
    integer :: i

    if (.not. allocated(model%weight)) allocate (model%weight, mold=model%gradient)
    if (allocated(model%load_share)) deallocate (model%load_share)
    mean_penetration = sum(set%load) / sum(set%stiffness)
    model%weight(1, :) = 1.0_real64 / set%stiffness
    model%weight(2, :) = sqrt(mean_penetration * set%curvature)
    model%weight(3, :) = model%weight(2, :)
    call find_blocks(set, model%blocks)
    call factor_blocks(set, model%convex, model%blocks)
    allocate (ones(3, size(set%x)), source=0.0_real64)
    ones(1, :) = 1.0_real64
    if (size(set%x) > circles_per_square) then
      call gather_squares(set%x, set%y, model%coarse)
      ! A block is in one square, so that the sums of its response are known.
      do i = 1, size(model%blocks%first) - 1
        associate (member => model%blocks%member(model%blocks%first(i): &
                                                 model%blocks%first(i + 1) - 1))
          model%coarse%square(member) = model%coarse%square(member(1))
        end associate
      end do
      model%coarse%answer = ones
      call solve_blocks(model%blocks, ones, model%coarse%answer)
      model%coarse%stiffness = sum_of_squares(model%coarse, model%coarse%answer(1, :))
    end if
    if (.not. model%keep_sum) return
    ones(1, :) = set%load_share
    allocate (projection, mold=ones)
    call apply_preconditioner(model, ones, projection)
    projection = projection / sum(set%load_share * projection(1, :))
    call move_alloc(projection, model%projection)
    allocate (model%load_share, source=set%load_share)
  end subroutine prepare_model

  !> Finds a step that decreases the model within the region.
  subroutine find_step(set, model, accuracy, radius, step, products, interrupt)
    type(circle_set), intent(inout) :: set          !! circles of the model; only its tree changes
    type(circle_model), intent(inout) :: model      !! model that is prepared
    real(real64), intent(in) :: accuracy            !! share of the gradient that may remain
    real(real64), intent(inout) :: radius           !! of the region; 0: becomes the first length
    type(trust_step), intent(out) :: step           !! step that was found
    integer, intent(inout) :: products              !! number of products with the Hessian so far
    type(interruption), intent(in) :: interrupt     !! of the run: ends the iteration early
    real(real64), allocatable, dimension(:, :) :: residual, preconditioned, direction, image, &
      scaled_step, scaled_direction
    real(real64) :: curvature, first_product, to_border, inner_product, step_length
    integer :: round

    allocate (preconditioned, direction, image, scaled_step, scaled_direction, mold=model%gradient)
    allocate (residual, source=-model%gradient)
    allocate (step%change, mold=model%gradient)
    step%change = 0.0_real64
    scaled_step = 0.0_real64
    call apply_preconditioner(model, residual, preconditioned)
    direction = preconditioned
    inner_product = sum(residual * preconditioned)
    first_product = inner_product
    if (.not. inner_product > 0.0_real64) return
    if (.not. radius > 0.0_real64) then
      scaled_direction = model%weight * direction
      radius = sqrt(sum(scaled_direction**2))
    end if
    do round = 1, size(residual)
      if (.not. inner_product > accuracy**2 * first_product .or. interrupt%is_asked()) exit
      call multiply(set, model%convex, direction, image)
      products = products + 1
      scaled_direction = model%weight * direction
      curvature = sum(direction * image)
      step%curves_down = .not. curvature > 0.0_real64
      to_border = distance_to_border()
      step_length = to_border
      step%at_border = .not. curvature * to_border > inner_product
      if (.not. step%at_border) step_length = inner_product / curvature
      step%change = step%change + step_length * direction
      scaled_step = scaled_step + step_length * scaled_direction
      residual = residual - step_length * image
      if (step%at_border) exit
      call apply_preconditioner(model, residual, preconditioned)
      ! The coarse level is not solved exactly: flexible conjugate gradients (Polak and Ribiere).
      direction = preconditioned - (step_length * sum(preconditioned * image) / inner_product) * &
        direction
      inner_product = sum(residual * preconditioned)
    end do
    step%length = sqrt(sum(scaled_step**2))
    step%decrease = 0.5_real64 * sum((residual - model%gradient) * step%change)

  contains

    ! Length along the direction at which the step reaches the border.
    real(real64) function distance_to_border() result(to_border)
      real(real64) :: a, b, c

      a = sum(scaled_direction**2)
      b = sum(scaled_direction * scaled_step)
      c = max(0.0_real64, radius**2 - sum(scaled_step**2))
      ! The root without cancellation.
      if (b > 0.0_real64) then
        to_border = c / (b + sqrt(b**2 + a * c))
      else
        to_border = (sqrt(b**2 + a * c) - b) / a
      end if
    end function distance_to_border

  end subroutine find_step

  ! Applies the preconditioner: blocks, and their coupling by squares full of circles.
  subroutine apply_preconditioner(model, residual, preconditioned)
    type(circle_model), intent(inout) :: model
    real(real64), intent(in) :: residual(:, :)
    real(real64), intent(out) :: preconditioned(:, :)
    real(real64), allocatable :: displacement(:)
    integer :: i

    call solve_blocks(model%blocks, residual, preconditioned)
    associate (coarse => model%coarse)
      if (allocated(coarse%square)) then
        displacement = sum_of_squares(coarse, preconditioned(1, :))
        where (coarse%stiffness > 0.0_real64) displacement = displacement / coarse%stiffness
        displacement = displacement - shared_change(coarse, displacement)
        !$omp parallel do schedule(static)
        do i = 1, size(residual, 2)
          preconditioned(:, i) = preconditioned(:, i) - displacement(coarse%square(i)) * &
            coarse%answer(:, i)
        end do
        !$omp end parallel do
      end if
    end associate
    if (allocated(model%load_share)) &
      preconditioned = preconditioned - model%projection * &
        sum(model%load_share * preconditioned(1, :))
  end subroutine apply_preconditioner

end module asperity_circle_step
