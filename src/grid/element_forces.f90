!> Forces on elements that minimise the energy, between 0 and a largest force.
!>
!> Problem: minimise f.Af/2 + f.g over all forces 0 <= f <= H, of a prescribed sum where there is a
!> load. A f are the displacements, A is positive definite, and g are the undeformed gaps. H is the
!> force of an element at the hardness of a perfectly plastic body (Almqvist, Sahlin, Larsson and
!> Glavatskih, Tribol. Int. 40 (2007) 574; Weber et al., Nat. Commun. 9 (2018) 888), or infinite.
!> Both sets are convex: the solution is unique. With the gradient r = A f + g, under a load less
!> its mean where 0 < f < H, it has r = 0 where 0 < f < H, r >= 0 where f = 0, and r <= 0 where
!> f = H: at the hardness the surfaces may overlap. r is the gap of the deformed surfaces.
!>
!> Method: conjugate gradients on the free forces, 0 < f < H, preconditioned with an approximate
!> inverse of A (Polonsky and Keer, Wear 231 (1999) 206-219). The same step changes a force of 0 in
!> proportion to its overlap, and a force of H in proportion to its gap. The forces are then cut at
!> 0 and H, and the free ones are scaled to the load. Such a step alone need not converge. It is
!> accepted if it decreases the energy by at least the decrease that the projected gradient step to
!> P(f - r/|A|) guarantees; else the latter is taken. P projects on the set of allowed forces. Each
!> accepted step reduces the distance of the energy from its minimum at least by the factor
!> 1 - (least eigenvalue)/(2 |A|) (after Dostal and Schoeberl, Comput. Optim. Appl. 30 (2005) 23-43,
!> theorem 4.1): the solve converges.
!>
!> Residual: the largest gap where f > 0 or overlap where f < H. Exits: converged, at a residual of
!> at most the tolerance or the rounding error, `rounding` times the largest displacement; not
!> converged, after `iterations_allowed` steps or where the run is interrupted. The forces are in
!> the allowed set at both exits.
module asperity_element_forces
  use asperity_lattice_convolution, only: lattice_convolution
  use asperity_interruption, only: interruption
  use asperity_kinds, only: real64
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: find_forces, force_bounds, missing_gap

  !> Gap of an element that is never loaded, over the largest penetration: no displacement is as
  !! large (derived from the rounding of numbers).
  real(real64), parameter :: missing_gap = 1.0_real64 / epsilon(1.0_real64)

  ! Error of a displacement by FFT over the largest one, or over |A| times the root mean square of
  ! the forces, which bounds that of the displacements: few large forces have an error everywhere.
  ! It grows as the logarithm of the number of elements to the base 2 (Higham, Accuracy and
  ! Stability, 2002, theorem 24.2, in the Euclidean norm). Measured:
  ! 1070 units of rounding on a free map of 283 x 59 pixels three times as wide as high, ten times
  ! beyond full contact; four times that is allowed (chosen). Without it loads whose displacements
  ! are 1e6 times the heights do not end.
  real(real64), parameter :: rounding = 4096 * epsilon(1.0_real64)
  ! Largest number of iterations (chosen).
  integer, parameter :: iterations_allowed = 2000

  !> Bounds of the forces, and the residual that ends the search.
  type :: force_bounds
    real(real64) :: tolerance = 0.0_real64    !! largest gap under a force, or overlap without one
    real(real64) :: load = -1.0_real64        !! sum of the forces, > 0; below 0: not prescribed
    real(real64) :: limit = huge(1.0_real64)  !! largest force H, > 0; times their number >= load
  end type force_bounds

  ! State of the iteration between two steps; f and r as in the header.
  type :: force_iterate
    real(real64), allocatable, dimension(:, :) :: force, gradient            ! f, r
    real(real64), allocatable, dimension(:, :) :: next_force, next_gradient  ! f, r after the step
    real(real64), allocatable, dimension(:, :) :: preconditioned  ! approximate inverse of A times r
    real(real64), allocatable, dimension(:, :) :: direction, direction_image  ! d, A d
    real(real64) :: gradient_product = 0.0_real64  ! r times its preconditioned r; 0: restart
    real(real64) :: displacement_scale = 0.0_real64
    logical :: is_recomputed = .true.  ! r is computed from f, not updated by the step
  end type force_iterate

contains

  !> Finds the forces of least energy from a start. Modifies `force`; exits: see the header.
  subroutine find_forces(influence, gap, bounds, force, ending, interrupt, level, displacement)
    type(lattice_convolution), intent(inout) :: influence  !! matrix A of displacements
    real(real64), intent(in) :: gap(:, :)               !! undeformed gaps g
    type(force_bounds), intent(in) :: bounds            !! tolerance of the residual, load, limit
    !> forces f, 0 or more, of the prescribed sum; start and result
    real(real64), allocatable, intent(inout) :: force(:, :)
    type(solve_ending), intent(out) :: ending           !! exit, residual, number of steps
    type(interruption), intent(in) :: interrupt         !! request to stop the iteration
    real(real64), intent(out), optional :: level        !! mean of A f + g over the free forces
    real(real64), allocatable, intent(out), optional :: displacement(:, :)  !! A f at the end
    type(force_iterate) :: state
    real(real64) :: least_decrease, decrease

    call move_alloc(force, state%force)
    allocate (state%gradient, state%next_force, state%next_gradient, state%preconditioned, &
              state%direction_image, mold=gap)
    allocate (state%direction(size(gap, 1), size(gap, 2)), source=0.0_real64)
    if (bounds%limit < huge(1.0_real64)) call project_forces(gap, bounds, state%force)
    call find_gradient(influence, gap, bounds, state%force, state%gradient, &
                       state%displacement_scale)
    do
      ending%residual = max(maxval(state%gradient, mask=state%force > 0.0_real64), &
                            -minval(state%gradient, mask=state%force < bounds%limit), 0.0_real64)
      ending%converged = ending%residual <= max(bounds%tolerance, rounding * &
                                                state%displacement_scale)
      if (ending%converged .and. state%is_recomputed) exit
      if (ending%iterations == iterations_allowed .or. interrupt%is_asked()) exit
      if (ending%converged) then
        ! The gradient was updated step by step: its rounding errors are removed.
        call find_gradient(influence, gap, bounds, state%force, state%gradient, &
                           state%displacement_scale)
        state%is_recomputed = .true.
        state%gradient_product = 0.0_real64
        cycle
      end if
      ending%iterations = ending%iterations + 1
      state%next_force = state%force - state%gradient / influence%norm
      call project_forces(gap, bounds, state%next_force)
      least_decrease = 0.5_real64 * sum(state%gradient * (state%force - state%next_force))
      call take_conjugate_step(influence, gap, bounds, state, decrease)
      if (.not. decrease >= least_decrease) then
        state%next_force = state%force - state%gradient / influence%norm
        call project_forces(gap, bounds, state%next_force)
        call find_gradient(influence, gap, bounds, state%next_force, state%next_gradient, &
                           state%displacement_scale)
        state%is_recomputed = .true.
        state%gradient_product = 0.0_real64
      end if
      state%force = state%next_force
      state%gradient = state%next_gradient
    end do
    if (present(level) .or. present(displacement)) call influence%apply(state%force, state%gradient)
    if (present(level)) level = free_level(gap, bounds, state%force, state%gradient + gap)
    call move_alloc(state%force, force)
    if (present(displacement)) call move_alloc(state%gradient, displacement)
  end subroutine find_forces

  ! Takes a step of conjugate gradients in the free forces. Sets the forces and the gradient after
  ! the step; `decrease` is that of the energy, below 0 where there is no step.
  subroutine take_conjugate_step(influence, gap, bounds, state, decrease)
    type(lattice_convolution), intent(inout) :: influence
    real(real64), intent(in) :: gap(:, :)
    type(force_bounds), intent(in) :: bounds
    type(force_iterate), intent(inout) :: state
    real(real64), intent(out) :: decrease
    logical :: free(size(gap, 1), size(gap, 2))
    real(real64) :: gradient_product, step, curvature

    free = is_free(state%force, bounds%limit)
    ! The set of free forces changes at nearly every step: the formula of Polak and Ribiere (1969)
    ! makes a restart at each change unnecessary.
    state%next_force = merge(state%gradient, 0.0_real64, free)
    call influence%apply(state%next_force, state%next_gradient, inverse=.true.)
    gradient_product = sum(state%next_force * state%next_gradient)
    step = 0.0_real64
    if (state%gradient_product > 0.0_real64) &
      step = max(0.0_real64, (gradient_product - sum(state%next_force * state%preconditioned)) / &
                 state%gradient_product)
    state%preconditioned = state%next_gradient
    state%direction = merge(state%preconditioned + step * state%direction, 0.0_real64, free)
    ! The sum of the forces does not change.
    if (bounds%load > 0.0_real64) where (free) state%direction = state%direction - &
      sum(state%direction) / max(1, count(free))
    state%gradient_product = gradient_product
    call influence%apply(state%direction, state%direction_image)
    curvature = sum(state%direction_image * state%direction)
    step = sum(state%gradient * state%direction)
    decrease = -1.0_real64
    if (.not. (step > 0.0_real64 .and. curvature > 0.0_real64)) return
    step = step / curvature
    ! Forces that would be negative become 0; a force of 0 with an overlap becomes positive.
    state%next_force = min(bounds%limit, max(0.0_real64, &
      state%force - step * merge(state%direction, state%gradient, free)))
    state%is_recomputed = any((state%next_force > 0.0_real64 .neqv. state%force > 0.0_real64) .or. &
                              (state%next_force < bounds%limit .neqv. state%force < bounds%limit))
    if (state%is_recomputed) then
      call scale_to_load(gap, bounds, state%next_force)
      call find_gradient(influence, gap, bounds, state%next_force, state%next_gradient, &
                         state%displacement_scale)
    else
      state%next_gradient = state%gradient - step * state%direction_image
      call subtract_level(gap, bounds, state%next_force, state%next_gradient)
    end if
    decrease = 0.5_real64 * sum((state%force - state%next_force) * &
                                (state%gradient + state%next_gradient))
  end subroutine take_conjugate_step

  ! Computes the gradient r at the forces f, and the scale of the rounding of displacements.
  subroutine find_gradient(influence, gap, bounds, force, gradient, displacement_scale)
    type(lattice_convolution), intent(inout) :: influence
    real(real64), intent(in) :: gap(:, :), force(:, :)
    type(force_bounds), intent(in) :: bounds
    real(real64), intent(out) :: gradient(:, :), displacement_scale

    call influence%apply(force, gradient)
    displacement_scale = max(maxval(abs(gradient)), &
                               influence%norm * norm2(force) / sqrt(real(size(force), real64)))
    gradient = gradient + gap
    call subtract_level(gap, bounds, force, gradient)
  end subroutine find_gradient

  ! Subtracts from the gradient its level, where the sum of the forces is prescribed.
  subroutine subtract_level(gap, bounds, force, gradient)
    real(real64), intent(in) :: gap(:, :), force(:, :)
    type(force_bounds), intent(in) :: bounds
    real(real64), intent(inout) :: gradient(:, :)

    if (bounds%load > 0.0_real64) gradient = gradient - free_level(gap, bounds, force, gradient)
  end subroutine subtract_level

  ! Level of the gradient: its mean over the free forces. Where no force is between 0 and the limit,
  ! the level with the least residual: midway between the forces at the limit and the zero forces.
  real(real64) function free_level(gap, bounds, force, gradient) result(level)
    real(real64), intent(in) :: gap(:, :), force(:, :), gradient(:, :)
    type(force_bounds), intent(in) :: bounds
    logical :: is_unloaded(size(gap, 1), size(gap, 2))
    integer :: free

    free = count(is_free(force, bounds%limit))
    if (free > 0 .or. .not. bounds%limit < huge(1.0_real64)) then
      level = sum(gradient, mask=is_free(force, bounds%limit)) / max(1, free)
      return
    end if
    level = maxval(gradient, mask=force > 0.0_real64)
    is_unloaded = is_element(gap) .and. .not. force > 0.0_real64
    if (any(is_unloaded)) level = 0.5_real64 * (level + minval(gradient, mask=is_unloaded))
  end function free_level

  ! Scales forces from 0 to the limit to the prescribed sum, if any: only the free ones change, by a
  ! factor of their values or of their differences from the limit.
  recursive subroutine scale_to_load(gap, bounds, force)
    real(real64), intent(in) :: gap(:, :)
    type(force_bounds), intent(in) :: bounds
    real(real64), intent(inout) :: force(:, :)
    logical :: free(size(force, 1), size(force, 2))
    real(real64) :: capacity, free_sum, free_load

    if (.not. bounds%load > 0.0_real64) return
    if (.not. bounds%limit < huge(1.0_real64)) then
      force = force * (bounds%load / sum(force))
      return
    end if
    free = is_free(force, bounds%limit)
    free_sum = sum(force, mask=free)
    free_load = bounds%load - bounds%limit * count(.not. force < bounds%limit)
    capacity = count(free) * bounds%limit
    if (.not. (any(free) .and. free_load > 0.0_real64 .and. free_load < capacity)) then
      call project_forces(gap, bounds, force)
    else if (free_load < free_sum) then
      where (free) force = force * (free_load / free_sum)
    else
      where (free) force = bounds%limit - (bounds%limit - force) * &
        ((capacity - free_load) / (capacity - free_sum))
    end if
  end subroutine scale_to_load

  ! Projects forces on those from 0 to the limit of the prescribed sum. All are reduced by the same
  ! level, the root of a piecewise linear function that does not increase: Newton's method (without
  ! a limit: Michelot 1986) in a bracket of the root, with bisection where a step leaves it.
  recursive subroutine project_forces(gap, bounds, force)
    real(real64), intent(in) :: gap(:, :)
    type(force_bounds), intent(in) :: bounds
    real(real64), intent(inout) :: force(:, :)
    real(real64) :: excess, high, level, low
    integer :: moving_count

    if (bounds%load > 0.0_real64) then
      high = maxval(force)
      low = high - bounds%load
      if (bounds%limit < huge(low)) low = minval(force, mask=is_element(gap)) - bounds%limit
      level = min(high, max(low, 0.0_real64))
      do
        excess = sum(max(0.0_real64, min(bounds%limit, force - level))) - bounds%load
        if (.not. abs(excess) > rounding * bounds%load) exit
        if (excess > 0.0_real64) low = level
        if (excess < 0.0_real64) high = level
        moving_count = count(force > level .and. force - level < bounds%limit)
        level = level + excess / max(1, moving_count)
        if (moving_count == 0 .or. .not. (level > low .and. level < high)) &
          level = low + 0.5_real64 * (high - low)
        if (.not. (level > low .and. level < high)) exit
      end do
      force = force - level
    end if
    force = max(0.0_real64, min(bounds%limit, force))
    ! The sum is restored where the load is small against the level, whose rounding it has.
    if (.not. bounds%limit < huge(high) .and. any(force > 0.0_real64)) &
      call scale_to_load(gap, bounds, force)
  end subroutine project_forces

  ! Whether a force is neither 0 nor at the limit.
  elemental logical function is_free(force, limit)
    real(real64), intent(in) :: force, limit

    is_free = force > 0.0_real64 .and. force < limit
  end function is_free

  ! Whether an element can carry a force: not so a missing pixel, by its gap.
  elemental logical function is_element(gap)
    real(real64), intent(in) :: gap

    is_element = gap < 0.5_real64 * missing_gap
  end function is_element

end module asperity_element_forces
