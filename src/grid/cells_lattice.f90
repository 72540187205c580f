!> Where pressure can be: square cells of one lattice under all contacts of a cluster.
!>
!> Pressure only opens the gap, so that there is none where the undeformed gap is not below zero:
!> outside discs of radius sqrt(2) times the contact radius. A cell on which several of them lie has
!> the least gap and belongs to the contact that comes deepest, of equals to the first. The vertical
!> gap between two spheres is written from the place where they touch first, with the square roots
!> through their conjugates: a penetration of 1e-12 of the radius keeps its digits.
module asperity_cells_lattice
  use asperity_constants, only: pi
  use asperity_cells_relax, only: missing_gap
  use asperity_contact_pairs, only: contact_pair
  use asperity_kinds, only: real64
  implicit none
  private

  public :: box_of, cell_lattice, gap_at, gap_shape, lay_cells, shape_of_gap

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

  !> The gap of one pair. Lengths in the unit of the pairs.
  type :: gap_shape
    integer :: pair = 0                             !! place in the list of pairs
    real(real64) :: x = 0.0_real64                  !! place in plan of first touch
    real(real64) :: y = 0.0_real64                  !! place in plan of first touch
    real(real64) :: penetration = 0.0_real64        !! vertical, past first touch; more than 0
    real(real64) :: reach = 0.0_real64              !! no gap is below 0 farther than that from it
    real(real64) :: contact_radius = 0.0_real64     !! of Hertz, the slope left out
    real(real64) :: cosine = 1.0_real64             !! of the slope at first touch
    real(real64) :: curvature_radius = 0.0_real64   !! 1/R = 1/RU + 1/RL
    real(real64) :: upper(2) = 0.0_real64           !! from the upper centre to the touch, in plan
    real(real64) :: lower(2) = 0.0_real64           !! from the lower centre to the touch, in plan
    real(real64) :: upper_height = 0.0_real64       !! from the upper centre to the touch
    real(real64) :: lower_height = 0.0_real64       !! from the lower centre to the touch
  end type gap_shape

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
  subroutine lay_cells(shapes, x0, y0, cell, window, lattice)
    type(gap_shape), intent(in) :: shapes(:)      !! the contacts, at least one
    real(real64), intent(in) :: x0, y0            !! origin, in plan
    real(real64), intent(in) :: cell              !! side of a cell
    real(real64), intent(in) :: window(4)         !! x, y of two corners from the origin: limits
    type(cell_lattice), intent(out) :: lattice    !! the cells
    real(real64), allocatable :: least(:, :)
    real(real64) :: low(2), high(2), gaps(4), mean, x, y, step
    integer :: columns, rows, i, j, k, first, last

    call box_of(shapes, x0, y0, low, high)
    low = max(low, window(:2))
    high = max(low, min(high, window(3:)))
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
    lattice%gap = missing_gap
    lattice%owner = 0
    lattice%force = 0.0_real64
    ! Gauss' two places in an element, from its centre.
    step = 0.5_real64 / sqrt(3.0_real64) * cell
    do j = 1, rows
      least = missing_gap
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

  !> The shape of a pair's gap at a penetration.
  pure function shape_of_gap(pair, number, penetration) result(shape)
    type(contact_pair), intent(in) :: pair        !! who touches
    integer, intent(in) :: number                 !! its place in the list of pairs
    real(real64), intent(in) :: penetration       !! more than 0, less than the pair's zc
    type(gap_shape) :: shape
    real(real64) :: apart(2), share, far_above

    ! Height of a centre over a plane, the largest whose square is a number: nothing curves.
    far_above = 0.5_real64 * sqrt(huge(far_above))
    apart = [pair%lower_x - pair%upper_x, pair%lower_y - pair%upper_y]
    share = pair%upper_radius / pair%s
    shape%pair = number
    shape%penetration = penetration
    shape%cosine = pair%zc / pair%s
    shape%upper = share * apart
    shape%lower = -(pair%lower_radius / pair%s) * apart
    shape%x = pair%upper_x + shape%upper(1)
    shape%y = pair%upper_y + shape%upper(2)
    shape%upper_height = pair%upper_radius * shape%cosine
    shape%lower_height = pair%lower_radius * shape%cosine
    shape%curvature_radius = share * pair%lower_radius
    if (.not. min(pair%upper_radius, pair%lower_radius) > 0.0_real64) then
      shape%curvature_radius = pair%radius
      if (.not. pair%upper_radius > 0.0_real64) shape%upper_height = far_above
      if (.not. pair%lower_radius > 0.0_real64) shape%lower_height = far_above
    end if
    ! Both spheres curve by 1/radius at least everywhere: gap >= s**2/(2 R) - penetration.
    shape%contact_radius = sqrt(shape%curvature_radius * penetration)
    shape%reach = sqrt(2.0_real64) * shape%contact_radius
  end function shape_of_gap

  !> The gap before any deformation; less than 0 where the undeformed spheres overlap.
  pure function gap_at(shape, x, y) result(gap)
    type(gap_shape), intent(in) :: shape  !! whose gap
    real(real64), intent(in) :: x         !! from the place of first touch
    real(real64), intent(in) :: y         !! from the place of first touch
    real(real64) :: gap, square, upper, lower

    gap = missing_gap
    square = x * x + y * y
    upper = 2.0_real64 * (shape%upper(1) * x + shape%upper(2) * y) + square
    lower = 2.0_real64 * (shape%lower(1) * x + shape%lower(2) * y) + square
    ! Beside one of the spheres.
    if (upper >= shape%upper_height**2 .or. lower >= shape%lower_height**2) return
    gap = upper / (shape%upper_height + sqrt(shape%upper_height**2 - upper)) + &
          lower / (shape%lower_height + sqrt(shape%lower_height**2 - lower)) - shape%penetration
  end function gap_at

end module asperity_cells_lattice
