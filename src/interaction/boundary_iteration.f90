!> Pressures of least energy that nowhere pull: conjugate gradients with an active set.
!>
!> After Polonsky and Keer, Wear 231 (1999) 206-219, for a prescribed approach: no sum of forces is
!> kept. A cell whose force comes out negative is let go; a cell without force under which the
!> surfaces overlap is taken in, and the search starts anew. Forces are scaled by the cell's side,
!> the inverse of what a cell does to itself, so that lattices of different fineness do not matter.
module asperity_boundary_iteration
  use asperity_boundary_products, only: displace, half_space
  use asperity_kinds, only: real64
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: relax

  ! Far more than was ever needed.
  integer, parameter :: iterations_allowed = 2000

contains

  !> Improves forces until no gap is violated by more than a tolerance.
  subroutine relax(space, tolerance, force, ending)
    type(half_space), intent(in) :: space       !! the cells
    !> largest gap under a force, or overlap without one, over the largest undeformed overlap in
    !> the same patch
    real(real64), intent(in) :: tolerance
    real(real64), intent(inout) :: force(:)     !! over the modulus; 0 or more; start and result
    type(solve_ending), intent(out) :: ending   !! how it ended; residual as the tolerance
    real(real64), allocatable :: gap(:), direction(:), change(:), side(:), scale(:)
    real(real64) :: slope, slope_before, curvature, step
    logical :: fresh, taken_in, let_go
    integer :: i, n

    n = size(force)
    allocate (gap(n), direction(n), change(n), side(n), scale(n))
    call scales_of(space, side, scale)
    call displace(space, force, gap)
    gap = gap + space%cells%gap
    direction = 0.0_real64
    slope_before = 0.0_real64
    fresh = .true.
    do
      ending%residual = residual_of(force, gap, scale)
      ending%converged = ending%residual <= tolerance
      if (ending%converged .and. fresh) exit
      if (ending%iterations == iterations_allowed) exit
      if (ending%converged) then
        ! The gap was carried along; make sure of it.
        call displace(space, force, gap)
        gap = gap + space%cells%gap
        fresh = .true.
        slope_before = 0.0_real64
        cycle
      end if
      ending%iterations = ending%iterations + 1
      slope = 0.0_real64
      do i = 1, n
        if (force(i) > 0.0_real64) slope = slope + gap(i)**2 * side(i)
      end do
      step = 0.0_real64
      if (slope_before > 0.0_real64) step = slope / slope_before
      do i = 1, n
        if (force(i) > 0.0_real64) then
          direction(i) = side(i) * gap(i) + step * direction(i)
        else
          direction(i) = 0.0_real64
        end if
      end do
      call displace(space, direction, change)
      slope_before = slope
      slope = 0.0_real64
      curvature = 0.0_real64
      do i = 1, n
        if (.not. force(i) > 0.0_real64) cycle
        slope = slope + gap(i) * direction(i)
        curvature = curvature + change(i) * direction(i)
      end do
      ! Without any force yet: a step as if each cell were alone.
      step = 1.0_real64
      if (curvature > 0.0_real64) step = slope / curvature
      let_go = .false.
      taken_in = .false.
      do i = 1, n
        if (force(i) > 0.0_real64) then
          force(i) = force(i) - step * direction(i)
          if (force(i) > 0.0_real64) cycle
          force(i) = 0.0_real64
          let_go = .true.
        end if
      end do
      do i = 1, n
        if (force(i) > 0.0_real64 .or. .not. gap(i) < 0.0_real64) cycle
        force(i) = -step * side(i) * gap(i)
        taken_in = .true.
      end do
      fresh = let_go .or. taken_in
      if (fresh) then
        call displace(space, force, gap)
        gap = gap + space%cells%gap
      else
        gap = gap - step * change
      end if
      if (taken_in) slope_before = 0.0_real64
    end do
  end subroutine relax

  subroutine scales_of(space, side, scale)
    type(half_space), intent(in) :: space
    real(real64), intent(out) :: side(:), scale(:)
    integer :: i

    do i = 1, size(space%cells%patches)
      associate (p => space%cells%patches(i))
        side(p%before + 1:p%before + p%columns * p%rows) = p%cell
        scale(p%before + 1:p%before + p%columns * p%rows) = p%shape%penetration
      end associate
    end do
  end subroutine scales_of

  pure function residual_of(force, gap, scale) result(residual)
    real(real64), intent(in) :: force(:), gap(:), scale(:)
    real(real64) :: residual
    integer :: i

    residual = 0.0_real64
    do i = 1, size(force)
      if (force(i) > 0.0_real64) then
        residual = max(residual, abs(gap(i)) / scale(i))
      else
        residual = max(residual, -gap(i) / scale(i))
      end if
    end do
  end function residual_of

end module asperity_boundary_iteration
