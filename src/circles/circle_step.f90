!> A step of the trust-region method: conjugate gradients on the second derivatives, cut at the
!> border of the region.
!>
!> Method: truncated conjugate gradients (Steihaug, SIAM J. Numer. Anal. 20 (1983) 626; Toint 1981;
!> Nocedal and Wright, Numerical Optimization, 2006, algorithm 7.2) in the norm of the blocks. The
!> first iterate is the preconditioned gradient, so that a step lowers the model by a share of
!> Cauchy's step at least, which is what convergence needs (Conn, Gould and Toint, Trust-Region
!> Methods, 2000, theorem 6.4.6). Many circles are preconditioned by their blocks and by squares
!> full of circles (two levels). Exits: the gradient of the model has fallen to a share; the border
!> is met; the potential curves down (then on to the border).
module asperity_circle_step
  use asperity_circle_blocks, only: circle_blocks, factor_blocks, find_blocks, solve_blocks
  use asperity_circle_field, only: circle_set, most_rounds
  use asperity_circle_products, only: multiply
  use asperity_coarse_circles, only: circles_in_one, coarse_circles, gather_squares, &
                                     shared_change, sum_of_squares
  use asperity_interruption, only: interruption
  use asperity_kinds, only: real64
  implicit none
  private

  public :: circle_model, find_step, prepare_model, trust_step

  !> Quadratic model of the potential about a state.
  type :: circle_model
    real(real64), allocatable :: gradient(:, :)     !! (3, circle): by load, by shift along x and y
    logical :: keep_sum = .false.                   !! changes of the loads add up to zero
    logical :: convex = .false.                     !! without what may curve down
    real(real64), allocatable :: weight(:, :)       !! of changes in the norm
    type(circle_blocks), private :: blocks
    type(coarse_circles), private :: coarse
    ! Where the sum is kept: weights of the loads in it, and the preconditioned answer to them.
    real(real64), allocatable, private :: load_share(:), retraction(:, :)
  end type circle_model

  !> A step and what the model says of it.
  type :: trust_step
    real(real64), allocatable :: change(:, :)       !! (3, circle): of load, of shift
    real(real64) :: length = 0.0_real64             !! in the norm of the blocks
    real(real64) :: decrease = 0.0_real64           !! of the model, 0 or more
    logical :: at_border = .false.                  !! of the region
    logical :: curves_down = .false.                !! the model does along a direction
  end type trust_step

contains

  !> Factors the blocks of a model and prepares its squares.
  subroutine prepare_model(set, model)
    type(circle_set), intent(inout) :: set      !! its field is known
    type(circle_model), intent(inout) :: model  !! gradient and kind are set
    real(real64), allocatable :: retraction(:, :), ones(:, :)
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
    if (size(set%x) > circles_in_one) then
      call gather_squares(set%x, set%y, model%coarse)
      ! A block is in one square: what it answers is then known by the sum.
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
    allocate (retraction, mold=ones)
    call apply_preconditioner(model, ones, retraction)
    retraction = retraction / sum(set%load_share * retraction(1, :))
    call move_alloc(retraction, model%retraction)
    allocate (model%load_share, source=set%load_share)
  end subroutine prepare_model

  !> The step that lowers the model within a radius.
  subroutine find_step(set, model, accuracy, radius, step, products, interrupt)
    type(circle_set), intent(inout) :: set          !! of the model; not changed but for its tree
    type(circle_model), intent(inout) :: model      !! model that is prepared
    real(real64), intent(in) :: accuracy            !! share of the gradient that may remain
    real(real64), intent(inout) :: radius           !! of the region; 0: becomes the first length
    type(trust_step), intent(out) :: step           !! step that was found
    integer, intent(inout) :: products              !! made, counted on
    type(interruption), intent(in) :: interrupt     !! of the run: the step is of no use then
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
    do round = 1, most_rounds
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
      ! Squares are not solved exactly: each direction against the last one (Polak and Ribiere).
      direction = preconditioned - (step_length * sum(preconditioned * image) / inner_product) * &
        direction
      inner_product = sum(residual * preconditioned)
    end do
    step%length = sqrt(sum(scaled_step**2))
    step%decrease = 0.5_real64 * sum((residual - model%gradient) * step%change)

  contains

    ! Part of the direction at which the step meets the border.
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

  ! Approximate solution of the model's equations: blocks alone, and what squares full of circles do
  ! to each other.
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
      preconditioned = preconditioned - model%retraction * &
        sum(model%load_share * preconditioned(1, :))
  end subroutine apply_preconditioner

end module asperity_circle_step
