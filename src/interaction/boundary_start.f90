!> Forces on cells to start from.
module asperity_boundary_start
  use asperity_boundary_patches, only: cell_set, patch
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  implicit none
  private

  public :: start_forces, refine_forces

contains

  !> The pressure of Hertz under each contact.
  subroutine start_forces(cells, modulus, force, loads)
    type(cell_set), intent(in) :: cells                   !! the cells
    real(real64), intent(in) :: modulus                   !! combined
    real(real64), allocatable, intent(out) :: force(:)    !! over the modulus
    real(real64), intent(in), optional :: loads(:)        !! by pair; without: as if alone
    real(real64) :: x, y, radius, share, deepness
    integer :: i, j, k, at

    allocate (force(size(cells%gap)))
    force = 0.0_real64
    do k = 1, size(cells%patches)
      associate (p => cells%patches(k))
        deepness = p%shape%penetration
        ! Hertz: the load is 4/3 E sqrt(R) penetration**1.5.
        if (present(loads)) then
          deepness = 0.75_real64 * max(0.0_real64, loads(p%shape%pair)) / modulus
          deepness = (deepness / sqrt(p%shape%curvature_radius))**(2.0_real64 / 3.0_real64)
          deepness = min(deepness, p%shape%penetration)
        end if
        if (.not. deepness > 0.0_real64) cycle
        radius = sqrt(p%shape%curvature_radius * deepness)
        do j = 1, p%rows
          y = p%origin_y + (p%bottom + j - 0.5_real64) * p%cell
          do i = cells%first(p%rows_before + j), cells%last(p%rows_before + j)
            x = p%origin_x + (p%left + i - 0.5_real64) * p%cell
            share = 1.0_real64 - (x / radius)**2 - (y / radius)**2
            at = p%before + (j - 1) * p%columns + i
            if (.not. share > 0.0_real64 .or. .not. cells%gap(at) < 0.0_real64) cycle
            force(at) = 2.0_real64 / pi * (deepness / radius) * sqrt(share) * p%cell**2
          end do
        end do
      end associate
    end do
  end subroutine start_forces

  !> Forces on halved cells, interpolated in both directions from the cells before.
  subroutine refine_forces(coarse, coarse_force, fine, force)
    type(cell_set), intent(in) :: coarse                  !! the cells before
    real(real64), intent(in) :: coarse_force(:)           !! forces on them
    type(cell_set), intent(in) :: fine                    !! the same patches, cells halved
    real(real64), allocatable, intent(out) :: force(:)    !! forces on the fine cells
    integer :: i, j, k, at, x, y, across, along

    allocate (force(size(fine%gap)))
    force = 0.0_real64
    do k = 1, size(fine%patches)
      associate (p => fine%patches(k), c => coarse%patches(k))
        do j = 1, p%rows
          y = floor_half(p%bottom + j - 1)
          along = 2 * modulo(p%bottom + j - 1, 2) - 1
          do i = fine%first(p%rows_before + j), fine%last(p%rows_before + j)
            at = p%before + (j - 1) * p%columns + i
            if (.not. fine%gap(at) < 0.0_real64) cycle
            x = floor_half(p%left + i - 1)
            across = 2 * modulo(p%left + i - 1, 2) - 1
            ! The fine cell's centre is a quarter of a coarse cell from the coarse one's; its area
            ! a quarter.
            force(at) = (9.0_real64 * value_at(c, x, y) + 3.0_real64 * value_at(c, x + across, y) &
                         + 3.0_real64 * value_at(c, x, y + along) + &
                         value_at(c, x + across, y + along)) / 64.0_real64
          end do
        end do
      end associate
    end do

  contains

    pure real(real64) function value_at(c, x, y)
      type(patch), intent(in) :: c
      integer, intent(in) :: x, y  ! column and row of the lattice

      value_at = 0.0_real64
      if (x < c%left .or. x >= c%left + c%columns) return
      if (y < c%bottom .or. y >= c%bottom + c%rows) return
      value_at = coarse_force(c%before + (y - c%bottom) * c%columns + x - c%left + 1)
    end function value_at

  end subroutine refine_forces

  pure integer function floor_half(i)
    integer, intent(in) :: i

    floor_half = (i - modulo(i, 2)) / 2
  end function floor_half

end module asperity_boundary_start
