!> Where pressure can be: square cells of one lattice under all contacts of a cluster.
!>
!> Pressure only opens the gap, so that there is none where the undeformed gap is not below zero:
!> outside discs of radius sqrt(2) times the contact radius. A cell on which several of them lie has
!> the least gap and belongs to the contact that comes deepest, of equals to the first.
module asperity_cells_lattice
  use asperity_cells_gap, only: gap_at, gap_nowhere, gap_shape
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  implicit none
  private

  public :: box_of, cell_lattice, lay_cells

  ! Gauss' two places in a cell, from its centre, over its side.
  real(real64), parameter :: gauss = 0.5_real64 / sqrt(3.0_real64)

  !> A rectangle of cells. Cell (1, 1) has its lower left corner at (left, bottom) cells from the
  !> origin. Lengths in the unit of the pairs.
  type :: cell_lattice
    real(real64) :: x = 0.0_real64         !! origin, in plan
    real(real64) :: y = 0.0_real64         !! origin, in plan
    real(real64) :: cell = 0.0_real64      !! side of a cell
    real(real64) :: scale = 0.0_real64     !! deepest penetration: gaps on cells are over it
    integer :: left = 0                    !! columns between the origin and the first
    integer :: bottom = 0                  !! rows between the origin and the first
    real(real64), allocatable :: gap(:, :) !! mean over the cell, over the scale
    integer, allocatable :: owner(:, :)    !! place of its contact in the list; 0: no pressure here
    real(real64), allocatable :: force(:, :) !! over the modulus, the scale and the side of a cell
  end type cell_lattice

contains

  !> The rectangle in plan outside which there is no pressure.
  pure subroutine box_of(shapes, x, y, low, high)
    type(gap_shape), intent(in) :: shapes(:)       !! the contacts, at least one
    real(real64), intent(in) :: x, y               !! a place in plan
    real(real64), intent(out) :: low(2), high(2)   !! x, y of two corners, from that place

    low = [minval(shapes%x - x - shapes%reach), minval(shapes%y - y - shapes%reach)]
    high = [maxval(shapes%x - x + shapes%reach), maxval(shapes%y - y + shapes%reach)]
  end subroutine box_of

  !> Lays the cells under some contacts. Each begins with the pressure of Hertz as if alone: 2/pi E
  !> (a/R) sqrt(1 - (r/a)**2), and its undeformed gap is p (r**2/(2 a**2) - 1).
  subroutine lay_cells(shapes, x0, y0, cell, lattice)
    type(gap_shape), intent(in) :: shapes(:)      !! the contacts, at least one
    real(real64), intent(in) :: x0, y0            !! origin, in plan
    real(real64), intent(in) :: cell              !! side of a cell
    type(cell_lattice), intent(out) :: lattice    !! the cells
    real(real64), allocatable :: least(:, :)
    real(real64) :: low(2), high(2), gaps(4), mean, x, y, step
    integer :: columns, rows, i, j, k, first, last

    call box_of(shapes, x0, y0, low, high)
    lattice%x = x0
    lattice%y = y0
    lattice%cell = cell
    lattice%scale = maxval(shapes%penetration)
    lattice%left = floor(low(1) / cell)
    lattice%bottom = floor(low(2) / cell)
    columns = floor(high(1) / cell) - lattice%left + 1
    rows = floor(high(2) / cell) - lattice%bottom + 1
    allocate (lattice%gap(columns, rows), lattice%owner(columns, rows))
    allocate (lattice%force(columns, rows), least(4, columns))
    lattice%gap = gap_nowhere
    lattice%owner = 0
    lattice%force = 0.0_real64
    step = gauss * cell
    do j = 1, rows
      least = gap_nowhere
      do k = 1, size(shapes)
        associate (s => shapes(k))
          y = y0 - s%y + (lattice%bottom + j - 0.5_real64) * cell
          if (abs(y) > s%reach + cell) cycle
          x = x0 - s%x + lattice%left * cell
          first = max(1, floor((-s%reach - x) / cell) + 1)
          last = min(columns, floor((s%reach - x) / cell) + 1)
          do i = first, last
            associate (c => x + (i - 0.5_real64) * cell)
              gaps = [gap_at(s, c - step, y - step), gap_at(s, c + step, y - step), &
                      gap_at(s, c - step, y + step), gap_at(s, c + step, y + step)]
            end associate
            if (minval(gaps) < min(0.0_real64, minval(least(:, i)))) lattice%owner(i, j) = k
            least(:, i) = min(least(:, i), gaps)
          end do
        end associate
      end do
      do i = 1, columns
        ! Exact for a cubic.
        mean = 0.25_real64 * sum(least(:, i))
        if (.not. mean < 0.0_real64) lattice%owner(i, j) = 0
        if (lattice%owner(i, j) == 0) cycle
        lattice%gap(i, j) = mean / lattice%scale
        associate (s => shapes(lattice%owner(i, j)))
          lattice%force(i, j) = 2.0_real64 / pi * cell / s%contact_radius * sqrt(max( &
            0.0_real64, -1.0_real64 - 2.0_real64 * mean / s%penetration)) * &
            (s%penetration / lattice%scale)
        end associate
      end do
    end do
  end subroutine lay_cells

end module asperity_cells_lattice
