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
module asperity_cells_relax
  use asperity_cell_convolution, only: cell_convolution
  use asperity_interruption, only: interruption
  use asperity_kinds, only: real64
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: missing_gap, relax

  !> Gap of an element that is never loaded, over the largest penetration: no displacement is as
  !! large (derived from the rounding of numbers; test: pixels without a height in
  !! test/regression/test_map_edges.py).
  real(real64), parameter :: missing_gap = 1.0_real64 / epsilon(1.0_real64)

  ! Error of a displacement by FFT over the largest one: rounding grows as the logarithm of the
  ! number of cells to the base 2 (Higham, Accuracy and Stability, 2002, theorem 24.2). Measured:
  ! 1070 units of rounding on a free map of 283 x 59 pixels three times as wide as high, ten times
  ! beyond full contact; four times that is allowed (chosen). Without it loads whose displacements
  ! are 1e6 times the heights do not end (tests: far beyond full contact in
  ! test/unit/map_suite.f90 and test/regression/test_map_edges.py).
  real(real64), parameter :: rounding = 4096 * epsilon(1.0_real64)
  ! Largest number of iterations (chosen: a cluster takes 20 to 60 on a lattice, a map of 512 x 512
  ! pixels at full contact 300; test: far beyond full contact in test/regression/test_map_edges.py).
  integer, parameter :: iterations_allowed = 2000

contains

  !> Improves forces until no gap is violated by more than a tolerance.
  subroutine relax(influence, gap, tolerance, force, ending, interrupt, load, closing, &
                   displacement, limit)
    type(cell_convolution), intent(inout) :: influence  !! A
    real(real64), intent(in) :: gap(:, :)               !! undeformed
    real(real64), intent(in) :: tolerance  !! largest gap under a force, or overlap without one
    real(real64), intent(inout) :: force(:, :)          !! 0 or more; start and result
    type(solve_ending), intent(out) :: ending           !! how it ended; residual as the tolerance
    type(interruption), intent(in) :: interrupt         !! who can end it; it is not converged then
    real(real64), intent(in), optional :: load          !! sum of the forces, which start with it
    real(real64), intent(out), optional :: closing      !! that it takes: less than every gap left
    real(real64), allocatable, intent(out), optional :: displacement(:, :)  !! A f at the end
    !> Largest force, > 0; times the number of forces at least the load; absent: none.
    real(real64), intent(in), optional :: limit
    real(real64), allocatable, dimension(:, :) :: rest, steepest, direction, change, next, after
    real(real64) :: slope, slope_before, curvature, step, fall, sure, largest, most
    logical :: fresh

    allocate (rest, steepest, direction, change, next, after, mold=gap)
    direction = 0.0_real64
    slope_before = 0.0_real64
    most = huge(most)
    if (present(limit)) then
      most = limit
      call project_on_limits(force)
    end if
    call find_rest(force, rest)
    fresh = .true.
    do
      ending%residual = max(maxval(rest, mask=force > 0.0_real64), &
                            -minval(rest, mask=force < most), 0.0_real64)
      ending%converged = ending%residual <= max(tolerance, rounding * largest)
      if (ending%converged .and. fresh) exit
      if (ending%iterations == iterations_allowed .or. interrupt%is_asked()) exit
      if (ending%converged) then
        ! The gap was carried along; make sure of it.
        call find_rest(force, rest)
        fresh = .true.
        slope_before = 0.0_real64
        cycle
      end if
      ending%iterations = ending%iterations + 1
      call go_down(next)
      sure = 0.5_real64 * sum(rest * (force - next))
      ! Cells come and go at nearly every step: what the last slope has in common with this one is
      ! taken off (Polak and Ribiere), so that the search need not start anew each time.
      next = merge(rest, 0.0_real64, is_free(force))
      call influence%apply(next, after, inverse=.true.)
      slope = sum(next * after)
      step = 0.0_real64
      if (slope_before > 0.0_real64) &
        step = max(0.0_real64, (slope - sum(next * steepest)) / slope_before)
      steepest = after
      direction = merge(steepest + step * direction, 0.0_real64, is_free(force))
      ! A cell let go has left its part to the others.
      if (present(load)) where (is_free(force)) direction = direction - &
        sum(direction) / max(1, count(is_free(force)))
      slope_before = slope
      call influence%apply(direction, change)
      curvature = sum(change * direction)
      step = sum(rest * direction)
      fall = -1.0_real64
      if (step > 0.0_real64 .and. curvature > 0.0_real64) then
        step = step / curvature
        ! Cells that open end at 0, those that would touch are taken in.
        next = min(most, max(0.0_real64, force - step * merge(direction, rest, is_free(force))))
        fresh = any(next > 0.0_real64 .neqv. force > 0.0_real64)
        if (present(limit)) fresh = fresh .or. any(next < most .neqv. force < most)
        if (fresh) then
          if (present(limit)) then
            call scale_to_load(next)
          else if (present(load)) then
            next = next * (load / sum(next))
          end if
          call find_rest(next, after)
        else
          after = rest - step * change
          call centre(next, after)
        end if
        fall = 0.5_real64 * sum((force - next) * (rest + after))
      end if
      if (.not. fall >= sure) then
        call go_down(next)
        call find_rest(next, after)
        fresh = .true.
        slope_before = 0.0_real64
      end if
      force = next
      rest = after
    end do
    if (present(closing) .or. present(displacement)) call influence%apply(force, rest)
    if (present(closing)) closing = level_of(force, rest + gap)
    if (present(displacement)) call move_alloc(rest, displacement)

  contains

    subroutine find_rest(force, rest)
      real(real64), intent(in) :: force(:, :)
      real(real64), intent(out) :: rest(:, :)

      call influence%apply(force, rest)
      largest = maxval(abs(rest))
      rest = rest + gap
      call centre(force, rest)
    end subroutine find_rest

    ! Over the mean under force where the sum of the forces is given.
    subroutine centre(force, rest)
      real(real64), intent(in) :: force(:, :)
      real(real64), intent(inout) :: rest(:, :)

      if (present(load)) rest = rest - level_of(force, rest)
    end subroutine centre

    ! Mean under force below the limit. Where no force is between 0 and the limit, the level whose
    ! residual is least: as far above those at the limit as below those without force.
    real(real64) function level_of(force, rest) result(level)
      real(real64), intent(in) :: force(:, :), rest(:, :)
      integer :: free

      free = count(is_free(force))
      if (free > 0 .or. .not. present(limit)) then
        level = sum(rest, mask=is_free(force)) / max(1, free)
        return
      end if
      level = maxval(rest, mask=force > 0.0_real64)
      if (any(is_cell(gap) .and. .not. force > 0.0_real64)) level = 0.5_real64 * (level + &
        minval(rest, mask=is_cell(gap) .and. .not. force > 0.0_real64))
    end function level_of

    ! Whether a force is neither 0 nor at the limit.
    elemental logical function is_free(force)
      real(real64), intent(in) :: force

      is_free = force > 0.0_real64 .and. force < most
    end function is_free

    ! Gives forces from 0 to the limit the sum that is given: those in between are scaled, as they
    ! are or what they lack to the limit, so that the others stay there.
    subroutine scale_to_load(forces)
      real(real64), intent(inout) :: forces(:, :)
      real(real64) :: room, share, total
      integer :: free

      if (.not. present(load)) return
      free = count(is_free(forces))
      share = sum(forces, mask=is_free(forces))
      total = load - most * count(.not. forces < most)
      room = free * most
      if (free == 0 .or. .not. (total > 0.0_real64 .and. total < room)) then
        call project_on_limits(forces)
      else if (total < share) then
        where (is_free(forces)) forces = forces * (total / share)
      else
        where (is_free(forces)) forces = most - (most - forces) * ((room - total) / (room - share))
      end if
    end subroutine scale_to_load

    ! Moves forces to the nearest ones from 0 to the limit and, where it is given, of the load. All
    ! sink by the same level, the root of a piecewise linear function that does not grow: Newton's
    ! method within an interval that holds the root, halved where that leaves it.
    subroutine project_on_limits(forces)
      real(real64), intent(inout) :: forces(:, :)
      real(real64) :: excess, high, level, low
      integer :: moving

      if (present(load)) then
        low = minval(forces, mask=is_cell(gap)) - most
        high = maxval(forces)
        level = min(high, max(low, 0.0_real64))
        do
          excess = sum(max(0.0_real64, min(most, forces - level))) - load
          if (.not. abs(excess) > rounding * load) exit
          if (excess > 0.0_real64) low = level
          if (excess < 0.0_real64) high = level
          moving = count(forces > level .and. forces < level + most)
          level = level + excess / max(1, moving)
          if (moving == 0 .or. .not. (level > low .and. level < high)) &
            level = low + 0.5_real64 * (high - low)
          if (.not. (level > low .and. level < high)) exit
        end do
        forces = forces - level
      end if
      forces = max(0.0_real64, min(most, forces))
    end subroutine project_on_limits

    ! The step that is sure. It ends at the nearest forces that are allowed: 0 or more, of the sum
    ! that is given. All sink alike until what is left has that sum; each round is Newton's and none
    ! is passed twice (Michelot 1986).
    subroutine go_down(next)
      real(real64), intent(out) :: next(:, :)
      real(real64) :: level, before

      next = force - rest / influence%norm
      if (present(limit)) then
        call project_on_limits(next)
        return
      end if
      if (present(load)) then
        level = (sum(next, mask=next > 0.0_real64) - load) / count(next > 0.0_real64)
        do
          before = level
          level = (sum(next, mask=next > before) - load) / count(next > before)
          if (.not. level > before) exit
        end do
        next = next - level
      end if
      next = max(0.0_real64, next)
    end subroutine go_down

  end subroutine relax

  ! Whether a cell may bear a force: missing pixels are too far apart for any.
  elemental logical function is_cell(gap)
    real(real64), intent(in) :: gap

    is_cell = gap < 0.5_real64 * missing_gap
  end function is_cell

end module asperity_cells_relax
