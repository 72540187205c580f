!> Pressures of least energy that nowhere pull.
!>
!> The energy is f.Af/2 + f.g, of forces f that are 0 or more, gaps g and a positive definite A. The
!> steps are those of Polonsky and Keer, Wear 231 (1999) 206-219, for a prescribed approach:
!> conjugate gradients, a cell whose force comes out negative is let go, one without force under
!> which the surfaces overlap is taken in. That alone is not sure to end. So a step must lower the
!> energy by half of what a step along the projected gradient is sure to, of length 1/|A|; else that
!> one is taken. Such a step brings the energy nearer to its least value at least by the factor
!> 1 - (least eigenvalue)/|A| (Dostal and Schoeberl, Comput. Optim. Appl. 30 (2005) 23-43, theorem
!> 4.1), and every step here by 1 - (least eigenvalue)/(4 |A|): the solve ends.
module asperity_cells_relax
  use asperity_cell_convolution, only: cell_convolution
  use asperity_kinds, only: real64
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: relax

  ! Far more than was ever needed.
  integer, parameter :: iterations_allowed = 2000

contains

  !> Improves forces until no gap is violated by more than a tolerance.
  subroutine relax(influence, gap, tolerance, force, ending)
    type(cell_convolution), intent(inout) :: influence  !! A
    real(real64), intent(in) :: gap(:, :)               !! undeformed
    real(real64), intent(in) :: tolerance  !! largest gap under a force, or overlap without one
    real(real64), intent(inout) :: force(:, :)          !! 0 or more; start and result
    type(solve_ending), intent(out) :: ending           !! how it ended; residual as the tolerance
    real(real64), allocatable, dimension(:, :) :: rest, steepest, direction, change, next, after
    real(real64) :: slope, slope_before, curvature, step, fall, sure
    logical :: same, fresh

    allocate (rest, steepest, direction, change, next, after, mold=gap)
    direction = 0.0_real64
    slope_before = 0.0_real64
    call influence%apply(force, rest)
    rest = rest + gap
    fresh = .true.
    do
      ending%residual = violation(force, rest)
      ending%converged = ending%residual <= tolerance
      if (ending%converged .and. fresh) exit
      if (ending%iterations == iterations_allowed) exit
      if (ending%converged) then
        ! The gap was carried along; make sure of it.
        call influence%apply(force, rest)
        rest = rest + gap
        fresh = .true.
        slope_before = 0.0_real64
        cycle
      end if
      ending%iterations = ending%iterations + 1
      sure = 0.5_real64 * sum(rest * (force - max(0.0_real64, force - rest / influence%norm)))
      next = merge(rest, 0.0_real64, force > 0.0_real64)
      call influence%apply_inverse(next, steepest)
      slope = sum(next * steepest)
      step = 0.0_real64
      if (slope_before > 0.0_real64) step = slope / slope_before
      where (force > 0.0_real64)
        direction = steepest + step * direction
      else where
        direction = 0.0_real64
      end where
      slope_before = slope
      call influence%apply(direction, change)
      curvature = sum(change * direction)
      step = sum(rest * direction)
      fall = -1.0_real64
      same = .true.
      if (step > 0.0_real64 .and. curvature > 0.0_real64) then
        step = step / curvature
        call move(force, rest, direction, step, next, same, slope_before)
        if (same) then
          after = rest - step * change
        else
          call influence%apply(next, after)
          after = after + gap
        end if
        fall = 0.5_real64 * sum((force - next) * (rest + after))
      end if
      if (.not. fall >= 0.5_real64 * sure) then
        same = .false.
        next = max(0.0_real64, force - rest / influence%norm)
        call influence%apply(next, after)
        after = after + gap
        slope_before = 0.0_real64
      end if
      fresh = .not. same
      force = next
      rest = after
    end do
  end subroutine relax

  ! One step. After cells were taken in the search starts anew.
  pure subroutine move(force, rest, direction, step, next, same, slope_before)
    real(real64), intent(in) :: force(:, :), rest(:, :), direction(:, :), step
    real(real64), intent(out) :: next(:, :)
    logical, intent(inout) :: same
    real(real64), intent(inout) :: slope_before
    integer :: i, j

    do j = 1, size(force, 2)
      do i = 1, size(force, 1)
        if (force(i, j) > 0.0_real64) then
          next(i, j) = force(i, j) - step * direction(i, j)
          if (next(i, j) > 0.0_real64) cycle
          next(i, j) = 0.0_real64
          same = .false.
        else if (rest(i, j) < 0.0_real64) then
          next(i, j) = -step * rest(i, j)
          same = .false.
          slope_before = 0.0_real64
        else
          next(i, j) = 0.0_real64
        end if
      end do
    end do
  end subroutine move

  pure real(real64) function violation(force, rest)
    real(real64), intent(in) :: force(:, :), rest(:, :)

    violation = max(maxval(abs(rest), mask=force > 0.0_real64), -minval(rest), 0.0_real64)
  end function violation

end module asperity_cells_relax
