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
!> Method: conjugate gradients on the set W of the free forces, 0 < f < H, those of 0 with an
!> overlap and those of H with a gap, preconditioned with `invert_on` W (Polonsky and Keer, Wear 231
!> (1999) 206-219). The forces are then cut at 0 and H, and where any was cut the free ones are
!> scaled to the load and the gradient is computed anew. Such a step alone need not converge. It is
!> accepted if it decreases the energy by at least the decrease that the projected gradient step to
!> P(f - r/|A|) guarantees; else P(f - t r) is taken, with the length t of steepest descent, halved
!> until it guarantees as much (More and Toraldo, SIAM J. Optim. 1 (1991) 93-113). P projects on the
!> set of allowed forces. Each accepted step reduces the distance of the energy from its minimum at
!> least by the factor 1 - (least eigenvalue)/(2 |A|) (after Dostal and Schoeberl, Comput. Optim.
!> Appl. 30 (2005) 23-43, theorem 4.1): the solve converges.
!>
!> Directions and their displacements are of single precision: these may be as inexact as the step
!> is small (van den Eshof and Sleijpen, SIAM J. Matrix Anal. Appl. 26 (2004) 125). Where the sum of
!> their errors is not small beside the residual, and at the end, r is computed from f in double.
!>
!> On a periodic map equal forces have no displacements: along them A is not positive definite and
!> the energy is linear, with the sum of r as its slope. Where all forces are above 0 and the mean
!> of r is above the residual that is asked for, the least force is taken from all: the minimum on
!> this line. Then one force is 0, and the others cannot all decrease together. A mean of less
!> is that of full contact at any load: the sum of the forces stays that of the start.
!>
!> Residual: the largest gap where f > 0 or overlap where f < H. Exits: converged, at a residual of
!> at most the tolerance or the rounding error, `rounding` times the largest displacement; not
!> converged, after `iterations_allowed` steps or where the run is interrupted. The forces are in
!> the allowed set at both exits. A limit H of at least the load is no bound, as forces of 0 or more
!> with this sum are not larger: such a problem is solved without a limit.
module asperity_element_forces
  use asperity_lattice_convolution, only: lattice_convolution
  use asperity_force_rows, only: direction_row, gradient_row, image_row, product_row, &
                                 residual_row, step_row, working_row
  use asperity_interruption, only: interruption
  use asperity_kinds, only: int64, real32, real64
  use asperity_line_transform, only: thread_threshold
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: displacement_error, find_forces, force_bounds, missing_gap

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
  ! Error of a displacement by numbers of single precision over the largest one (measured where
  ! transforms are of single precision, too: 3.4 units of rounding on periodic and free maps of up
  ! to 1024 x 1024; 16 are allowed, chosen).
  real(real64), parameter :: single_error = 16 * epsilon(1.0_real32)
  ! Largest error of the gradient by steps over the residual, beyond which it is computed from the
  ! forces (chosen).
  real(real64), parameter :: drift_allowed = 0.01_real64
  !> Largest number of iterations, of a method that converges (chosen).
  integer, parameter, public :: iterations_allowed = 2000

  !> Bounds of the forces, and the residual that ends the search.
  type :: force_bounds
    real(real64) :: tolerance = 0.0_real64    !! largest gap under a force, or overlap without one
    real(real64) :: load = -1.0_real64        !! sum of the forces, > 0; below 0: not prescribed
    real(real64) :: limit = huge(1.0_real64)  !! largest force H, > 0; times their number >= load
  end type force_bounds

  ! State of the iteration between two steps, with f, r and W as in the header.
  type :: force_iterate
    real(real64), allocatable, dimension(:, :) :: force, gradient            ! f, r
    real(real64), allocatable, dimension(:, :) :: next_force, next_gradient  ! f, r after the step
    !> gradient in W, or change of f; d; forces by the inverse, A d, or A times the change of f
    real(real32), allocatable, dimension(:, :) :: working, direction, image
    real(real64), allocatable :: row_sums(:, :)    ! sums or maxima of each row of a loop
    real(real64) :: level = 0.0_real64             ! still to be subtracted from the next gradient
    real(real64) :: gradient_product = 0.0_real64  ! r times its preconditioned r; 0: restart
    real(real64) :: rounding_error = 0.0_real64    ! of the displacements
    real(real64) :: drift = 0.0_real64     ! error of r by the steps since it was computed from f
    real(real64) :: residual = 0.0_real64  ! after the step, as in the header
    real(real64) :: decrease = 0.0_real64  ! of the energy by the step; below 0: there is no step
    real(real64) :: enough = 0.0_real64    ! upper bound of the decrease that is asked of a step
    logical :: is_recomputed = .true.      ! r is computed from f, not updated by a step
  end type force_iterate

contains

  !> Finds the forces of least energy from a start. Modifies `force`; exits: see the header.
  subroutine find_forces(influence, gap, given_bounds, force, ending, interrupt, level, &
                         displacement)
    type(lattice_convolution), intent(inout) :: influence  !! matrix A of displacements
    real(real64), intent(in) :: gap(:, :)               !! undeformed gaps g
    type(force_bounds), intent(in) :: given_bounds      !! tolerance of the residual, load, limit
    !> forces f, 0 or more, of the prescribed sum; start and result
    real(real64), allocatable, intent(inout) :: force(:, :)
    type(solve_ending), intent(out) :: ending           !! exit, residual, number of steps
    type(interruption), intent(in) :: interrupt         !! request to stop the iteration
    !> where converged: mean of A f + g over the free forces under a load, else 0; A f
    real(real64), intent(out), optional :: level
    real(real64), allocatable, intent(out), optional :: displacement(:, :)
    type(force_bounds) :: bounds
    type(force_iterate) :: state
    real(real64), allocatable :: projected(:, :)
    real(real64) :: enough

    bounds = given_bounds
    if (bounds%load > 0.0_real64 .and. bounds%limit >= bounds%load) bounds%limit = huge(enough)
    call move_alloc(force, state%next_force)
    if (bounds%limit < huge(1.0_real64)) call project_forces(gap, bounds, state%next_force)
    allocate (state%force, source=state%next_force)
    allocate (state%next_gradient, mold=gap)
    allocate (state%row_sums(5, size(gap, 2)))
    allocate (state%gradient(size(gap, 1), size(gap, 2)), source=0.0_real64)
    allocate (state%direction(size(gap, 1), size(gap, 2)), source=0.0_real32)
    allocate (state%working, mold=state%direction)
    allocate (state%image, source=state%direction)
    call find_gradient(influence, gap, bounds, .true., state)
    do
      call swap_arrays(state%force, state%next_force)
      call swap_arrays(state%gradient, state%next_gradient)
      ending%residual = state%residual
      ending%converged = ending%residual <= max(bounds%tolerance, state%rounding_error)
      if (ending%converged .and. state%is_recomputed) exit
      if (ending%iterations == iterations_allowed .or. interrupt%is_asked()) exit
      if (ending%converged) then
        ! The gradient was updated step by step: its rounding errors are removed.
        call scale_to_load(gap, bounds, state%force, sum(state%force))
        state%next_force = state%force
        state%gradient_product = 0.0_real64
        call find_gradient(influence, gap, bounds, .true., state)
        cycle
      end if
      ending%iterations = ending%iterations + 1
      if (.not. bounds%load > 0.0_real64) call take_least_force(influence, bounds, state)
      enough = state%enough
      call take_conjugate_step(influence, gap, bounds, state)
      if (state%decrease >= enough) cycle
      projected = state%force - state%gradient / influence%norm
      call project_forces(gap, bounds, projected)
      if (state%decrease >= 0.5_real64 * sum(state%gradient * (state%force - projected))) cycle
      call take_projected_step(influence, gap, bounds, state)
    end do
    if (present(level)) level = state%level
    call move_alloc(state%force, force)
    if (.not. present(displacement)) return
    call move_alloc(state%gradient, displacement)
    if (state%is_recomputed .and. epsilon(enough) * maxval(gap) < state%rounding_error) then
      displacement = displacement + (state%level - gap)
    else
      call influence%apply(force, displacement)
    end if
  end subroutine find_forces

  !> Rounding error of displacements by FFT (see `rounding`).
  pure real(real64) function displacement_error(norm, mean_square, largest) result(error)
    real(real64), intent(in) :: norm         !! |A|, norm of the matrix of displacements
    real(real64), intent(in) :: mean_square  !! of the forces
    real(real64), intent(in) :: largest      !! largest displacement by them

    error = rounding * max(largest, norm * sqrt(mean_square))
  end function displacement_error

  ! Takes a step of conjugate gradients in W: sets the forces and the gradient after the step.
  subroutine take_conjugate_step(influence, gap, bounds, state)
    type(lattice_convolution), intent(inout) :: influence
    real(real64), intent(in) :: gap(:, :)
    type(force_bounds), intent(in) :: bounds
    type(force_iterate), intent(inout) :: state
    real(real64) :: curvature, drift, mean, step, sums(5)
    logical :: is_exact
    integer :: j

    associate (f => state%force, r => state%gradient, next => state%next_force, &
               d => state%direction, gradient => state%next_gradient, image => state%image, &
               limit => bounds%limit, w => state%working)
      call influence%invert_on(w, image)
      !$omp parallel do if(size(gap, kind=int64) > thread_threshold)
      do j = 1, size(gap, 2)
        call product_row(w(:, j), image(:, j), gradient(:, j), d(:, j), state%row_sums(:, j))
      end do
      sums = sum(state%row_sums, 2)
      ! W changes at nearly every step: the formula of Polak and Ribiere (1969), with the change of
      ! the gradient, makes a restart at each change unnecessary.
      step = 0.0_real64
      if (state%gradient_product > 0.0_real64) &
        step = max(0.0_real64, sums(2) / state%gradient_product)
      state%gradient_product = sums(1)
      ! The sum of the forces does not change.
      mean = 0.0_real64
      if (bounds%load > 0.0_real64) mean = (sums(3) + step * sums(4)) / max(1.0_real64, sums(5))
      !$omp parallel do if(size(gap, kind=int64) > thread_threshold)
      do j = 1, size(gap, 2)
        call direction_row(real(step, real32), real(mean, real32), w(:, j), image(:, j), d(:, j), &
                           state%row_sums(1, j))
      end do
      step = sum(state%row_sums(1, :))
      call influence%apply(d, image)
      !$omp parallel do if(size(gap, kind=int64) > thread_threshold)
      do j = 1, size(gap, 2)
        call image_row(d(:, j), image(:, j), state%row_sums(:2, j))
      end do
      curvature = sum(state%row_sums(1, :))
      state%decrease = -1.0_real64
      if (.not. (step > 0.0_real64 .and. curvature > 0.0_real64)) return
      step = step / curvature
      drift = state%drift + single_error * step * maxval(state%row_sums(2, :))
      !$omp parallel do if(size(gap, kind=int64) > thread_threshold)
      do j = 1, size(gap, 2)
        call step_row([step, limit], f(:, j), d(:, j), r(:, j), image(:, j), next(:, j), &
                      state%row_sums(:4, j))
      end do
      sums = sum(state%row_sums, 2)
      ! The gradient is known where no force is cut. A direction of rounding errors alone, where W
      ! has next to equal forces by the inverse, does not keep the load.
      is_exact = drift > drift_allowed * state%residual
      if (is_exact .or. sums(2) > 0.0_real64 .or. bounds%load > 0.0_real64 .and. &
          abs(sums(1) - bounds%load) > single_error * bounds%load) then
        call scale_to_load(gap, bounds, next, sums(1))
        call find_gradient(influence, gap, bounds, is_exact, state)
        return
      end if
    end associate
    state%drift = drift
    state%is_recomputed = .false.
    state%level = 0.0_real64
    if (bounds%load > 0.0_real64) state%level = sums(4) / max(1.0_real64, sums(3))
    call finish_step(influence%norm, -step, bounds, state)
  end subroutine take_conjugate_step

  ! Takes the least force from all where equal forces have no displacements and cost energy. The
  ! gradient stays the same.
  subroutine take_least_force(influence, bounds, state)
    type(lattice_convolution), intent(inout) :: influence
    type(force_bounds), intent(in) :: bounds
    type(force_iterate), intent(inout) :: state
    real(real64), allocatable :: displaced(:, :)

    if (.not. (all(state%force > 0.0_real64) .and. sum(state%gradient) / &
               size(state%gradient, kind=int64) > &
               max(bounds%tolerance, state%rounding_error, state%drift))) return
    allocate (displaced, mold=state%force)
    call influence%apply(0.0_real64 * state%force + 1.0_real64, displaced)
    if (maxval(abs(displaced)) > rounding * influence%norm) return
    state%force = state%force - minval(state%force)
    state%gradient_product = 0.0_real64
    call find_working(bounds, state)
  end subroutine take_least_force

  ! Finds the gradient in W.
  subroutine find_working(bounds, state)
    type(force_bounds), intent(in) :: bounds
    type(force_iterate), intent(inout) :: state
    integer :: j

    do j = 1, size(state%force, 2)
      call working_row(bounds%limit, state%force(:, j), state%gradient(:, j), state%working(:, j))
    end do
  end subroutine find_working

  ! Takes a projected gradient step P(f - t r), after which conjugate gradients begin again: t is
  ! that of steepest descent in the forces that can move, halved until the energy decreases by half
  ! of r.(f - P(f - t r)). That grows with t, and t = 1/|A| has it.
  subroutine take_projected_step(influence, gap, bounds, state)
    type(lattice_convolution), intent(inout) :: influence
    real(real64), intent(in) :: gap(:, :)
    type(force_bounds), intent(in) :: bounds
    type(force_iterate), intent(inout) :: state
    real(real64) :: curvature, enough, least, length, squares

    associate (f => state%force, r => state%gradient)
      call find_working(bounds, state)
      call influence%apply(state%working, state%image)
      squares = sum(real(state%working, real64)**2)
      curvature = sum(real(state%working, real64) * state%image)
      least = 1.0_real64 / influence%norm
      length = least
      if (curvature > epsilon(least) * influence%norm * squares) length = squares / curvature
      do
        state%next_force = f - length * r
        call project_forces(gap, bounds, state%next_force)
        enough = 0.5_real64 * sum(r * (f - state%next_force))
        call find_gradient(influence, gap, bounds, .true., state)
        if (state%decrease >= enough .or. .not. length > least) exit
        length = max(least, 0.5_real64 * length)
      end do
    end associate
    state%gradient_product = 0.0_real64
  end subroutine take_projected_step

  ! Computes the gradient after a step: from the forces, and the rounding error of displacements, or
  ! from that before by the displacements of the change of the forces.
  recursive subroutine find_gradient(influence, gap, bounds, is_exact, state)
    type(lattice_convolution), intent(inout) :: influence
    real(real64), intent(in) :: gap(:, :)
    type(force_bounds), intent(in) :: bounds
    logical, intent(in) :: is_exact  ! from the forces
    type(force_iterate), intent(inout) :: state
    real(real64) :: sums(3)
    integer :: j

    associate (next => state%next_force, gradient => state%next_gradient, image => state%image, &
               limit => bounds%limit, rows => state%row_sums)
      if (is_exact) then
        call influence%apply(next, gradient)
        !$omp parallel do if(size(gap, kind=int64) > thread_threshold)
        do j = 1, size(gap, 2)
          call gradient_row(limit, next(:, j), gradient(:, j), gap(:, j), rows(:4, j))
          gradient(:, j) = gradient(:, j) + gap(:, j)
        end do
      else
        !$omp parallel do if(size(gap, kind=int64) > thread_threshold)
        do j = 1, size(gap, 2)
          state%working(:, j) = real(next(:, j) - state%force(:, j), real32)
        end do
        call influence%apply(state%working, image)
        !$omp parallel do if(size(gap, kind=int64) > thread_threshold)
        do j = 1, size(gap, 2)
          call gradient_row(limit, next(:, j), real(image(:, j), real64), state%gradient(:, j), &
                            rows(:4, j))
        end do
      end if
    end associate
    sums = sum(state%row_sums(:3, :), 2)
    state%drift = state%drift + single_error * maxval(state%row_sums(4, :))
    if (is_exact) then
      state%rounding_error = displacement_error(influence%norm, sums(3) / size(gap, kind=int64), &
                                                maxval(state%row_sums(4, :)))
      state%drift = 0.0_real64
    else if (bounds%load > 0.0_real64 .and. .not. sums(1) > 0.0_real64) then
      call find_gradient(influence, gap, bounds, .true., state)
      return
    end if
    state%is_recomputed = is_exact
    state%level = 0.0_real64
    if (bounds%load > 0.0_real64) then
      state%level = sums(2) / max(1.0_real64, sums(1))
      if (.not. sums(1) > 0.0_real64) &
        state%level = free_level(gap, bounds, state%next_force, state%next_gradient)
    end if
    call finish_step(influence%norm, 1.0_real64, bounds, state)
  end subroutine find_gradient

  ! Computes the gradient after a step from that before, if not from the forces, subtracts its
  ! level, and sets it in W. Finds the decrease of the energy, the residual, and a bound of the
  ! decrease that is asked of the next step. That is half of D = r.(f - P(f - r/|A|)), where
  ! P(f - r/|A|) has the greatest r.(f - g) - |A|/2 (f - g)**2 of all allowed forces g, at least
  ! D/2: it is largest without the load.
  subroutine finish_step(norm, multiple, bounds, state)
    real(real64), intent(in) :: norm      ! |A|
    real(real64), intent(in) :: multiple  ! change of the gradient over `image`
    type(force_bounds), intent(in) :: bounds
    type(force_iterate), intent(inout) :: state
    real(real64) :: numbers(4)
    integer :: j

    numbers = [state%level, norm, bounds%limit, merge(0.0_real64, multiple, state%is_recomputed)]
    !$omp parallel do if(size(state%force, kind=int64) > thread_threshold)
    do j = 1, size(state%force, 2)
      if (.not. state%is_recomputed) state%next_gradient(:, j) = state%gradient(:, j)
      call residual_row(numbers, state%force(:, j), state%gradient(:, j), state%image(:, j), &
                        state%next_force(:, j), state%next_gradient(:, j), state%working(:, j), &
                        state%row_sums(:3, j))
    end do
    state%decrease = 0.5_real64 * sum(state%row_sums(1, :))
    state%enough = sum(state%row_sums(2, :))
    state%residual = maxval(state%row_sums(3, :))
  end subroutine finish_step

  ! Exchanges two arrays without a copy.
  pure subroutine swap_arrays(one, other)
    real(real64), allocatable, intent(inout) :: one(:, :), other(:, :)
    real(real64), allocatable :: third(:, :)

    call move_alloc(one, third)
    call move_alloc(other, one)
    call move_alloc(third, other)
  end subroutine swap_arrays

  ! Level of the gradient: its mean over the free forces. Where no force is between 0 and the limit,
  ! the level with the least residual: midway between the forces at the limit and the zero forces.
  real(real64) function free_level(gap, bounds, force, gradient) result(level)
    real(real64), intent(in) :: gap(:, :), force(:, :), gradient(:, :)
    type(force_bounds), intent(in) :: bounds
    real(real64) :: highest, lowest
    integer(int64) :: free
    integer :: i, j

    free = 0_int64
    level = 0.0_real64
    highest = -huge(highest)
    lowest = huge(lowest)
    do j = 1, size(gap, 2)
      do i = 1, size(gap, 1)
        if (is_free(force(i, j), bounds%limit)) then
          free = free + 1_int64
          level = level + gradient(i, j)
        end if
        if (force(i, j) > 0.0_real64) then
          highest = max(highest, gradient(i, j))
        else if (is_element(gap(i, j))) then
          lowest = min(lowest, gradient(i, j))
        end if
      end do
    end do
    if (free > 0_int64 .or. .not. bounds%limit < huge(1.0_real64)) then
      level = level / max(1_int64, free)
    else
      level = highest
      if (lowest < huge(lowest)) level = 0.5_real64 * (highest + lowest)
    end if
  end function free_level

  ! Scales forces from 0 to the limit to the prescribed sum, if any, or projects them on it if the
  ! free forces alone cannot have it.
  subroutine scale_to_load(gap, bounds, force, total)
    real(real64), intent(in) :: gap(:, :)
    type(force_bounds), intent(in) :: bounds
    real(real64), intent(inout) :: force(:, :)
    real(real64), intent(in) :: total  ! sum of the forces
    logical :: is_scaled

    if (.not. bounds%load > 0.0_real64) return
    call scale_free_forces(bounds, total, force, is_scaled)
    if (.not. is_scaled) call project_forces(gap, bounds, force)
  end subroutine scale_to_load

  ! Scales the free forces, if they can have the prescribed sum: by a factor of their values or of
  ! their differences from the limit.
  subroutine scale_free_forces(bounds, total, force, is_scaled)
    type(force_bounds), intent(in) :: bounds
    real(real64), intent(in) :: total  ! sum of the forces
    real(real64), intent(inout) :: force(:, :)
    logical, intent(out) :: is_scaled
    logical, allocatable :: free(:, :)
    real(real64) :: capacity, free_sum, free_load

    if (.not. bounds%limit < huge(1.0_real64)) then
      is_scaled = total > 0.0_real64
      if (is_scaled) force = force * (bounds%load / total)
      return
    end if
    allocate (free(size(force, 1), size(force, 2)), source=is_free(force, bounds%limit))
    free_sum = sum(force, mask=free)
    free_load = bounds%load - bounds%limit * count(.not. force < bounds%limit, kind=int64)
    capacity = count(free, kind=int64) * bounds%limit
    is_scaled = any(free) .and. free_load > 0.0_real64 .and. free_load < capacity
    if (.not. is_scaled) return
    if (free_load < free_sum) then
      where (free) force = force * (free_load / free_sum)
    else
      where (free) force = bounds%limit - (bounds%limit - force) * &
        ((capacity - free_load) / (capacity - free_sum))
    end if
  end subroutine scale_free_forces

  ! Projects forces on those from 0 to the limit of the prescribed sum. All are reduced by the same
  ! level, the root of a piecewise linear function that does not increase: Newton's method (without
  ! a limit: Michelot 1986) in a bracket of the root, with bisection where a step leaves it.
  subroutine project_forces(gap, bounds, force)
    real(real64), intent(in) :: gap(:, :)
    type(force_bounds), intent(in) :: bounds
    real(real64), intent(inout) :: force(:, :)
    real(real64) :: excess, high, level, low
    logical :: is_scaled
    integer(int64) :: moving_count

    ! A missing pixel has no force at any level.
    where (.not. is_element(gap)) force = -missing_gap
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
        moving_count = count(force > level .and. force - level < bounds%limit, kind=int64)
        level = level + excess / max(1_int64, moving_count)
        if (moving_count == 0_int64 .or. .not. (level > low .and. level < high)) &
          level = low + 0.5_real64 * (high - low)
        if (.not. (level > low .and. level < high)) exit
      end do
      force = force - level
    end if
    force = max(0.0_real64, min(bounds%limit, force))
    ! The sum is restored where the load is small against the level, whose rounding it has.
    if (bounds%load > 0.0_real64) call scale_free_forces(bounds, sum(force), force, is_scaled)
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
