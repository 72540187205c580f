!> Forces of least energy between 0 and a largest force.
!>
!> Problem: minimise f.Af/2 + f.g over all forces 0 <= f <= H, of a given sum where there is a
!> load. A f are the displacements, A is positive definite, and g are the undeformed gaps. H is the
!> force of an element at the hardness of a perfectly plastic body (Almqvist, Sahlin, Larsson and
!> Glavatskih, Tribol. Int. 40 (2007) 574; Weber et al., Nat. Commun. 9 (2018) 888), or infinite.
!> Both sets are convex, so there is one solution. With the gaps r = A f + g, under a load less
!> their mean where 0 < f < H, it has r = 0 where 0 < f < H, r >= 0 where f = 0, and r <= 0 where
!> f = H: at the hardness the surfaces may overlap.
!>
!> Method: conjugate gradients on the free forces, 0 < f < H, with a rough inverse of A (Polonsky
!> and Keer, Wear 231 (1999) 206-219). In the same step a force of 0 follows an overlap, and a
!> force of H a gap. The forces are then cut at 0 and H, and the free ones are scaled to the load.
!> This step alone need not end. It is accepted if it lowers the energy by as much as the step to
!> P(f - r/|A|) is sure to; else that one is taken. P projects on the set of allowed forces. Such a
!> step, and so every step, brings the energy nearer to its least value at least by the factor
!> 1 - (least eigenvalue)/(2 |A|) (after Dostal and Schoeberl, Comput. Optim. Appl. 30 (2005) 23-43,
!> theorem 4.1): the solve converges.
!>
!> Residual: the largest gap where f > 0 or overlap where f < H. Exits: converged, at a residual of
!> the tolerance at most, or of what rounding leaves of it, `rounding` times the largest
!> displacement; not converged, after `iterations_allowed` steps or where the run is interrupted.
!> The forces are in the allowed set at both exits.
module asperity_element_forces
  use asperity_cell_convolution, only: cell_convolution
  use asperity_interruption, only: interruption
  use asperity_kinds, only: real64
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: find_forces, force_bounds, missing_gap

  !> Gap of an element that is never loaded, over the largest penetration: no displacement is as
  !! large (derived from the rounding of numbers; test: pixels without a height in
  !! test/regression/test_map_edges.py).
  real(real64), parameter :: missing_gap = 1.0_real64 / epsilon(1.0_real64)

  ! Error of a displacement by FFT over the largest one: rounding grows as the logarithm of the
  ! number of elements to the base 2 (Higham, Accuracy and Stability, 2002, theorem 24.2). Measured:
  ! 1070 units of rounding on a free map of 283 x 59 pixels three times as wide as high, ten times
  ! beyond full contact; four times that is allowed (chosen). Without it loads whose displacements
  ! are 1e6 times the heights do not end (tests: far beyond full contact in
  ! test/unit/map_suite.f90 and test/regression/test_map_edges.py).
  real(real64), parameter :: rounding = 4096 * epsilon(1.0_real64)
  ! Largest number of iterations (chosen; test: far beyond full contact in
  ! test/regression/test_map_edges.py).
  integer, parameter :: iterations_allowed = 2000

  !> Bounds of the forces, and the residual that ends the search.
  type :: force_bounds
    real(real64) :: tolerance = 0.0_real64    !! largest gap under a force, or overlap without one
    real(real64) :: load = -1.0_real64        !! sum of the forces, > 0; below 0: not prescribed
    real(real64) :: limit = huge(1.0_real64)  !! largest force H, > 0; times their number >= load
  end type force_bounds

  ! Forces between two steps.
  type :: force_iterate
    real(real64), allocatable, dimension(:, :) :: force, rest  ! f, r
    real(real64), allocatable, dimension(:, :) :: next, after  ! f and r after the step
    real(real64), allocatable, dimension(:, :) :: steepest, direction, change
    real(real64) :: slope = 0.0_real64    ! residual times its rough inverse; 0: begin anew
    real(real64) :: largest = 0.0_real64  ! displacement
    logical :: is_fresh = .true.          ! r is found from f, not carried along
  end type force_iterate

contains

  !> Improves forces until no gap is violated by more than the tolerance.
  subroutine find_forces(influence, gap, bounds, force, ending, interrupt, level, displacement)
    type(cell_convolution), intent(inout) :: influence  !! matrix A of displacements
    real(real64), intent(in) :: gap(:, :)               !! undeformed gaps g
    type(force_bounds), intent(in) :: bounds            !! tolerance of the gaps, load, limit
    !> forces f, 0 or more, of the prescribed sum; start and result
    real(real64), allocatable, intent(inout) :: force(:, :)
    type(solve_ending), intent(out) :: ending           !! how it ended; residual as the tolerance
    type(interruption), intent(in) :: interrupt         !! ends the search, which has not converged
    real(real64), intent(out), optional :: level        !! mean of A f + g over the free forces
    real(real64), allocatable, intent(out), optional :: displacement(:, :)  !! A f at the end
    type(force_iterate) :: now
    real(real64) :: sure, fall

    call move_alloc(force, now%force)
    allocate (now%rest, now%next, now%after, now%steepest, now%change, mold=gap)
    allocate (now%direction(size(gap, 1), size(gap, 2)), source=0.0_real64)
    if (bounds%limit < huge(1.0_real64)) call project_forces(gap, bounds, now%force)
    call find_rest(influence, gap, bounds, now%force, now%rest, now%largest)
    do
      ending%residual = max(maxval(now%rest, mask=now%force > 0.0_real64), &
                            -minval(now%rest, mask=now%force < bounds%limit), 0.0_real64)
      ending%converged = ending%residual <= max(bounds%tolerance, rounding * now%largest)
      if (ending%converged .and. now%is_fresh) exit
      if (ending%iterations == iterations_allowed .or. interrupt%is_asked()) exit
      if (ending%converged) then
        ! The gap was carried along; make sure of it.
        call find_rest(influence, gap, bounds, now%force, now%rest, now%largest)
        now%is_fresh = .true.
        now%slope = 0.0_real64
        cycle
      end if
      ending%iterations = ending%iterations + 1
      now%next = now%force - now%rest / influence%norm
      call project_forces(gap, bounds, now%next)
      sure = 0.5_real64 * sum(now%rest * (now%force - now%next))
      call take_conjugate_step(influence, gap, bounds, now, fall)
      if (.not. fall >= sure) then
        now%next = now%force - now%rest / influence%norm
        call project_forces(gap, bounds, now%next)
        call find_rest(influence, gap, bounds, now%next, now%after, now%largest)
        now%is_fresh = .true.
        now%slope = 0.0_real64
      end if
      now%force = now%next
      now%rest = now%after
    end do
    if (present(level) .or. present(displacement)) call influence%apply(now%force, now%rest)
    if (present(level)) level = free_level(gap, bounds, now%force, now%rest + gap)
    call move_alloc(now%force, force)
    if (present(displacement)) call move_alloc(now%rest, displacement)
  end subroutine find_forces

  ! Step of the conjugate gradients in the free forces; `fall` is the decrease of the energy, below
  ! 0 where there is no step.
  subroutine take_conjugate_step(influence, gap, bounds, now, fall)
    type(cell_convolution), intent(inout) :: influence
    real(real64), intent(in) :: gap(:, :)
    type(force_bounds), intent(in) :: bounds
    type(force_iterate), intent(inout) :: now
    real(real64), intent(out) :: fall
    logical :: free(size(gap, 1), size(gap, 2))
    real(real64) :: slope, step, curvature

    free = is_free(now%force, bounds%limit)
    ! Forces become free and bound at nearly every step: the part of the last slope in this one is
    ! subtracted (Polak and Ribiere 1969), so that the search need not begin anew each time.
    now%next = merge(now%rest, 0.0_real64, free)
    call influence%apply(now%next, now%after, inverse=.true.)
    slope = sum(now%next * now%after)
    step = 0.0_real64
    if (now%slope > 0.0_real64) &
      step = max(0.0_real64, (slope - sum(now%next * now%steepest)) / now%slope)
    now%steepest = now%after
    now%direction = merge(now%steepest + step * now%direction, 0.0_real64, free)
    ! The sum of the forces does not change.
    if (bounds%load > 0.0_real64) where (free) now%direction = now%direction - &
      sum(now%direction) / max(1, count(free))
    now%slope = slope
    call influence%apply(now%direction, now%change)
    curvature = sum(now%change * now%direction)
    step = sum(now%rest * now%direction)
    fall = -1.0_real64
    if (.not. (step > 0.0_real64 .and. curvature > 0.0_real64)) return
    step = step / curvature
    ! Forces that fall below 0 end there; those without one that would overlap get one.
    now%next = min(bounds%limit, max(0.0_real64, now%force - &
                                     step * merge(now%direction, now%rest, free)))
    now%is_fresh = any((now%next > 0.0_real64 .neqv. now%force > 0.0_real64) .or. &
                       (now%next < bounds%limit .neqv. now%force < bounds%limit))
    if (now%is_fresh) then
      call scale_to_load(gap, bounds, now%next)
      call find_rest(influence, gap, bounds, now%next, now%after, now%largest)
    else
      now%after = now%rest - step * now%change
      call subtract_level(gap, bounds, now%next, now%after)
    end if
    fall = 0.5_real64 * sum((now%force - now%next) * (now%rest + now%after))
  end subroutine take_conjugate_step

  ! Gaps r of some forces, and the largest displacement.
  subroutine find_rest(influence, gap, bounds, force, rest, largest)
    type(cell_convolution), intent(inout) :: influence
    real(real64), intent(in) :: gap(:, :), force(:, :)
    type(force_bounds), intent(in) :: bounds
    real(real64), intent(out) :: rest(:, :), largest

    call influence%apply(force, rest)
    largest = maxval(abs(rest))
    rest = rest + gap
    call subtract_level(gap, bounds, force, rest)
  end subroutine find_rest

  ! Gaps from their mean over the free forces, where the sum of the forces is prescribed.
  subroutine subtract_level(gap, bounds, force, rest)
    real(real64), intent(in) :: gap(:, :), force(:, :)
    type(force_bounds), intent(in) :: bounds
    real(real64), intent(inout) :: rest(:, :)

    if (bounds%load > 0.0_real64) rest = rest - free_level(gap, bounds, force, rest)
  end subroutine subtract_level

  ! Mean over the free forces. Where no force is between 0 and the limit, the level whose residual
  ! is least: as far above those at the limit as below those without force.
  real(real64) function free_level(gap, bounds, force, rest) result(level)
    real(real64), intent(in) :: gap(:, :), force(:, :), rest(:, :)
    type(force_bounds), intent(in) :: bounds
    logical :: can_close(size(gap, 1), size(gap, 2))
    integer :: free

    free = count(is_free(force, bounds%limit))
    if (free > 0 .or. .not. bounds%limit < huge(1.0_real64)) then
      level = sum(rest, mask=is_free(force, bounds%limit)) / max(1, free)
      return
    end if
    level = maxval(rest, mask=force > 0.0_real64)
    can_close = is_element(gap) .and. .not. force > 0.0_real64
    if (any(can_close)) level = 0.5_real64 * (level + minval(rest, mask=can_close))
  end function free_level

  ! Gives forces from 0 to the limit the prescribed sum, if any: those in between are scaled, as
  ! they are or in their difference to the limit, so that the others keep their values.
  recursive subroutine scale_to_load(gap, bounds, force)
    real(real64), intent(in) :: gap(:, :)
    type(force_bounds), intent(in) :: bounds
    real(real64), intent(inout) :: force(:, :)
    logical :: free(size(force, 1), size(force, 2))
    real(real64) :: room, share, total

    if (.not. bounds%load > 0.0_real64) return
    if (.not. bounds%limit < huge(1.0_real64)) then
      force = force * (bounds%load / sum(force))
      return
    end if
    free = is_free(force, bounds%limit)
    share = sum(force, mask=free)
    total = bounds%load - bounds%limit * count(.not. force < bounds%limit)
    room = count(free) * bounds%limit
    if (.not. (any(free) .and. total > 0.0_real64 .and. total < room)) then
      call project_forces(gap, bounds, force)
    else if (total < share) then
      where (free) force = force * (total / share)
    else
      where (free) force = bounds%limit - (bounds%limit - force) * ((room - total) / (room - share))
    end if
  end subroutine scale_to_load

  ! Moves forces to the nearest ones from 0 to the limit of the prescribed sum. All sink by the same
  ! level, the root of a piecewise linear function that does not grow: Newton's method (without a
  ! limit: Michelot 1986) within an interval that holds the root, halved where that leaves it.
  recursive subroutine project_forces(gap, bounds, force)
    real(real64), intent(in) :: gap(:, :)
    type(force_bounds), intent(in) :: bounds
    real(real64), intent(inout) :: force(:, :)
    real(real64) :: excess, high, level, low
    integer :: moving

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
        moving = count(force > level .and. force - level < bounds%limit)
        level = level + excess / max(1, moving)
        if (moving == 0 .or. .not. (level > low .and. level < high)) &
          level = low + 0.5_real64 * (high - low)
        if (.not. (level > low .and. level < high)) exit
      end do
      force = force - level
    end if
    force = max(0.0_real64, min(bounds%limit, force))
    ! A load that is small beside the level is kept.
    if (.not. bounds%limit < huge(high) .and. any(force > 0.0_real64)) &
      call scale_to_load(gap, bounds, force)
  end subroutine project_forces

  ! Whether a force is neither 0 nor at the limit.
  elemental logical function is_free(force, limit)
    real(real64), intent(in) :: force, limit

    is_free = force > 0.0_real64 .and. force < limit
  end function is_free

  ! Whether an element may bear a force: missing pixels are too far apart for any.
  elemental logical function is_element(gap)
    real(real64), intent(in) :: gap

    is_element = gap < 0.5_real64 * missing_gap
  end function is_element

end module asperity_element_forces
