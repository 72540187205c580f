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

  public :: cell_frame, cell_lattice, frame_of, box_of, lay_cells, cells_expected, start_forces
  public :: refine_forces

  ! Place of the lattice in a cluster's largest contact, in coarse cells. Any but a symmetric one:
  ! there the errors of many cells at the contact's edge are the same and add up.
  real(real64), parameter :: lattice_x = 0.29_real64, lattice_y = 0.13_real64

  ! Gauss' two places in a cell, from its centre, over its side.
  real(real64), parameter :: gauss = 0.5_real64 / sqrt(3.0_real64)

  !> What all lattices of a cluster have in common. Lengths in the unit of the pairs.
  type :: cell_frame
    real(real64) :: x = 0.0_real64       !! origin, beside first touch of the largest contact
    real(real64) :: y = 0.0_real64       !! origin, beside first touch of the largest contact
    real(real64) :: coarse = 0.0_real64  !! side of a cell before any halving
    real(real64) :: scale = 0.0_real64   !! deepest penetration: gaps on cells are over it
  end type cell_frame

  !> A rectangle of cells. Cell (1, 1) has its lower left corner at (left, bottom) cells from the
  !> origin.
  type :: cell_lattice
    real(real64) :: cell = 0.0_real64      !! side of a cell
    integer :: left = 0                    !! columns between the origin and the first
    integer :: bottom = 0                  !! rows between the origin and the first
    real(real64), allocatable :: gap(:, :) !! mean over the cell, over the scale
    integer, allocatable :: owner(:, :)    !! place of its contact in the list; 0: no pressure here
    !> over the modulus, the scale and the side of a cell; 0 at first
    real(real64), allocatable :: force(:, :)
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

  !> The frame of a cluster.
  pure type(cell_frame) function frame_of(shapes, cells_per_radius)
    type(gap_shape), intent(in) :: shapes(:)      !! the contacts, at least one
    !> for the contact that would bear most alone, of a circle as large
    real(real64), intent(in) :: cells_per_radius
    integer :: k

    ! A load alone is 4/3 of the modulus times that.
    k = maxloc(shapes%contact_radius * shapes%penetration * shapes%cosine, 1)
    ! A sphere's slope curves it more, by 1/cosine across and by its third power along: the radius
    ! of a circle as large as the ellipse.
    frame_of%coarse = shapes(k)%contact_radius * shapes(k)%cosine / cells_per_radius
    frame_of%x = shapes(k)%x - lattice_x * frame_of%coarse
    frame_of%y = shapes(k)%y - lattice_y * frame_of%coarse
    frame_of%scale = maxval(shapes%penetration)
  end function frame_of

  !> Cells that a lattice will have, at most.
  pure real(real64) function cells_expected(frame, shapes, halvings) result(cells)
    type(cell_frame), intent(in) :: frame     !! of the cluster
    type(gap_shape), intent(in) :: shapes(:)  !! the contacts, at least one
    integer, intent(in) :: halvings           !! 0 or more
    real(real64) :: low(2), high(2)

    call box_of(shapes, frame%x, frame%y, low, high)
    cells = product((high - low) / frame%coarse * 2.0_real64**halvings + 2.0_real64)
  end function cells_expected

  !> Lays the cells under some contacts of a cluster.
  subroutine lay_cells(frame, shapes, halvings, lattice)
    type(cell_frame), intent(in) :: frame         !! of the cluster
    type(gap_shape), intent(in) :: shapes(:)      !! the contacts, at least one
    integer, intent(in) :: halvings               !! how often to halve the coarse cell
    type(cell_lattice), intent(out) :: lattice    !! the cells
    real(real64), allocatable :: least(:, :)
    real(real64) :: low(2), high(2), gaps(4), x, y, step
    integer :: columns, rows, i, j, k, first, last

    call box_of(shapes, frame%x, frame%y, low, high)
    lattice%cell = frame%coarse * 0.5_real64**halvings
    lattice%left = floor(low(1) / lattice%cell)
    lattice%bottom = floor(low(2) / lattice%cell)
    columns = floor(high(1) / lattice%cell) - lattice%left + 1
    rows = floor(high(2) / lattice%cell) - lattice%bottom + 1
    allocate (lattice%gap(columns, rows), lattice%owner(columns, rows))
    allocate (lattice%force(columns, rows), least(4, columns))
    lattice%gap = gap_nowhere
    lattice%owner = 0
    lattice%force = 0.0_real64
    step = gauss * lattice%cell
    do j = 1, rows
      least = gap_nowhere
      do k = 1, size(shapes)
        associate (s => shapes(k))
          y = frame%y - s%y + (lattice%bottom + j - 0.5_real64) * lattice%cell
          if (abs(y) > s%reach + lattice%cell) cycle
          x = frame%x - s%x + lattice%left * lattice%cell
          first = max(1, floor((-s%reach - x) / lattice%cell) + 1)
          last = min(columns, floor((s%reach - x) / lattice%cell) + 1)
          do i = first, last
            associate (c => x + (i - 0.5_real64) * lattice%cell)
              gaps = [gap_at(s, c - step, y - step), gap_at(s, c + step, y - step), &
                      gap_at(s, c - step, y + step), gap_at(s, c + step, y + step)]
            end associate
            if (minval(gaps) < min(0.0_real64, minval(least(:, i)))) lattice%owner(i, j) = k
            least(:, i) = min(least(:, i), gaps)
          end do
        end associate
      end do
      do i = 1, columns
        if (lattice%owner(i, j) == 0) cycle
        ! Exact for a cubic.
        lattice%gap(i, j) = 0.25_real64 * sum(least(:, i)) / frame%scale
        if (lattice%gap(i, j) < 0.0_real64) cycle
        lattice%gap(i, j) = gap_nowhere
        lattice%owner(i, j) = 0
      end do
    end do
  end subroutine lay_cells

  !> Begins with the pressure of Hertz under every contact as if alone: 2/pi E (a/R) sqrt(1 -
  !> (r/a)**2), and its undeformed gap is p (r**2/(2 a**2) - 1).
  subroutine start_forces(frame, shapes, lattice)
    type(cell_frame), intent(in) :: frame           !! of the cluster
    type(gap_shape), intent(in) :: shapes(:)       !! the contacts
    type(cell_lattice), intent(inout) :: lattice   !! gets its forces
    integer :: i, j

    do j = 1, size(lattice%gap, 2)
      do i = 1, size(lattice%gap, 1)
        if (lattice%owner(i, j) == 0) cycle
        associate (s => shapes(lattice%owner(i, j)), gap => lattice%gap(i, j) * frame%scale)
          lattice%force(i, j) = 2.0_real64 / pi * lattice%cell / s%contact_radius * sqrt(max( &
            0.0_real64, -1.0_real64 - 2.0_real64 * gap / s%penetration)) * &
            (s%penetration / frame%scale)
        end associate
      end do
    end do
  end subroutine start_forces

  !> Shares the force of a cell out over its four parts. A coarse lattice covers the fine one.
  subroutine refine_forces(coarse, fine)
    type(cell_lattice), intent(in) :: coarse     !! solved
    type(cell_lattice), intent(inout) :: fine    !! of half the cells; gets its forces
    integer :: i, j

    do j = 1, size(fine%gap, 2)
      do i = 1, size(fine%gap, 1)
        ! A quarter, and the unit is half.
        if (fine%owner(i, j) > 0) fine%force(i, j) = 0.5_real64 * &
          coarse%force(half(fine%left + i - 1) - coarse%left + 1, &
                       half(fine%bottom + j - 1) - coarse%bottom + 1)
      end do
    end do

  contains

    pure integer function half(i)
      integer, intent(in) :: i

      half = (i - modulo(i, 2)) / 2
    end function half

  end subroutine refine_forces

end module asperity_cells_lattice
