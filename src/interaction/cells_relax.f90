!> Pressures of least energy that nowhere pull.
!>
!> The energy is f.Af/2 + f.g, of forces f that are 0 or more, gaps g and a positive definite A. The
!> steps are those of Polonsky and Keer, Wear 231 (1999) 206-219, for a prescribed approach:
!> conjugate gradients, a cell whose force comes out negative is let go, one without force under
!> which the surfaces overlap is taken in. That alone is not sure to end. So a step must lower the
!> energy by half of what a step along the projected gradient is sure to, of length 1/|A|; else that
!> one is taken. Such a step brings the energy nearer to its least value at least by the factor
!> 1 - (least eigenvalue)/|A| (Dostal and Schoeberl, Comput. Optim. Appl. 30 (2005) 23-43, theorem
!> 4.1), and every step here by 1 - (least eigenvalue)/(4 |A|): the solve ends. The same is true on
!> the forces of a given sum, which are as convex a set; gaps are then over their mean under force.
!>
!> It ends where the residual, the largest gap under a force or overlap without one, is at most the
!> tolerance, or at most what rounding leaves of it: `rounding` times the largest displacement.
module asperity_cells_relax
  use asperity_cell_convolution, only: cell_convolution
  use asperity_interruption, only: interruption
  use asperity_kinds, only: real64
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: relax

  ! Error of a displacement by FFT over the largest one: rounding grows as the logarithm of the
  ! number of cells to the base 2 (Higham, Accuracy and Stability, 2002, theorem 24.2). Measured:
  ! 1070 units of rounding on a free map of 283 x 59 pixels three times as wide as high, ten times
  ! beyond full contact; four times that is allowed (chosen). Without it loads whose displacements
  ! are 1e6 times the heights do not end (tests: far beyond full contact in
  ! test/unit/map_suite.f90 and test/regression/test_map_edges.py).
  real(real64), parameter :: rounding = 4096 * epsilon(1.0_real64)
  ! Far more than was ever needed.
  integer, parameter :: iterations_allowed = 2000

contains

  !> Improves forces until no gap is violated by more than a tolerance.
  subroutine relax(influence, gap, tolerance, force, ending, interrupt, load, closing, displacement)
    type(cell_convolution), intent(inout) :: influence  !! A
    real(real64), intent(in) :: gap(:, :)               !! undeformed
    real(real64), intent(in) :: tolerance  !! largest gap under a force, or overlap without one
    real(real64), intent(inout) :: force(:, :)          !! 0 or more; start and result
    type(solve_ending), intent(out) :: ending           !! how it ended; residual as the tolerance
    type(interruption), intent(in) :: interrupt         !! who can end it; it is not converged then
    real(real64), intent(in), optional :: load          !! sum of the forces, which start with it
    real(real64), intent(out), optional :: closing      !! that it takes: less than every gap left
    real(real64), allocatable, intent(out), optional :: displacement(:, :)  !! A f at the end
    real(real64), allocatable, dimension(:, :) :: rest, steepest, direction, change, next, after
    real(real64) :: slope, slope_before, curvature, step, fall, sure, largest
    logical :: fresh

    allocate (rest, steepest, direction, change, next, after, mold=gap)
    direction = 0.0_real64
    slope_before = 0.0_real64
    call find_rest(force, rest)
    fresh = .true.
    do
      ending%residual = max(maxval(abs(rest), mask=force > 0.0_real64), -minval(rest), 0.0_real64)
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
      next = merge(rest, 0.0_real64, force > 0.0_real64)
      call influence%apply(next, after, inverse=.true.)
      slope = sum(next * after)
      step = 0.0_real64
      if (slope_before > 0.0_real64) &
        step = max(0.0_real64, (slope - sum(next * steepest)) / slope_before)
      steepest = after
      direction = merge(steepest + step * direction, 0.0_real64, force > 0.0_real64)
      ! A cell let go has left its part to the others.
      if (present(load)) where (force > 0.0_real64) direction = direction - &
        sum(direction) / count(force > 0.0_real64)
      slope_before = slope
      call influence%apply(direction, change)
      curvature = sum(change * direction)
      step = sum(rest * direction)
      fall = -1.0_real64
      if (step > 0.0_real64 .and. curvature > 0.0_real64) then
        step = step / curvature
        ! Cells that open end at 0, those that would touch are taken in.
        next = max(0.0_real64, force - step * merge(direction, rest, force > 0.0_real64))
        fresh = any(next > 0.0_real64 .neqv. force > 0.0_real64)
        if (fresh) then
          if (present(load)) next = next * (load / sum(next))
          call find_rest(next, after)
        else
          after = rest - step * change
          call centre(next, after)
        end if
        fall = 0.5_real64 * sum((force - next) * (rest + after))
      end if
      if (.not. fall >= 0.5_real64 * sure) then
        call go_down(next)
        call find_rest(next, after)
        fresh = .true.
        slope_before = 0.0_real64
      end if
      force = next
      rest = after
    end do
    if (present(closing) .or. present(displacement)) call influence%apply(force, rest)
    if (present(closing)) &
      closing = sum(rest + gap, mask=force > 0.0_real64) / max(1, count(force > 0.0_real64))
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

      if (present(load)) &
        rest = rest - sum(rest, mask=force > 0.0_real64) / count(force > 0.0_real64)
    end subroutine centre

    ! The step that is sure. It ends at the nearest forces that are allowed: 0 or more, of the sum
    ! that is given. All sink alike until what is left has that sum; each round is Newton's and none
    ! is passed twice (Michelot 1986).
    subroutine go_down(next)
      real(real64), intent(out) :: next(:, :)
      real(real64) :: level, before

      next = force - rest / influence%norm
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

end module asperity_cells_relax
