!> Loads of contacts, distributed over the cells of a grid.
!>
!> A load is conserved: the cells get all of it, whatever their size. Parts beyond the grid go to
!> the cells at its edge.
module asperity_grid_pressures
  use asperity_kinds, only: real64
  implicit none
  private

  public :: add_circle, add_square, field_grid

  !> Square cells in plan.
  type :: field_grid
    real(real64) :: low(2) = 0.0_real64    !! corner of the first cell [length]
    real(real64) :: side = 0.0_real64      !! of a cell [length]
    integer :: cells(2) = 0                !! columns along x, rows along y
  end type field_grid

contains

  !> Adds the load of a circle under the pressure of Hertz, p0 sqrt(1 - (r/a)**2): each cell gets
  !> the integral over it, in closed form.
  pure subroutine add_circle(grid, x, y, radius, load, force)
    type(field_grid), intent(in) :: grid               !! grid of square cells
    real(real64), intent(in) :: x, y                   !! centre in plan [length]
    real(real64), intent(in) :: radius                 !! a, 0 or more [length]
    real(real64), intent(in) :: load                   !! 0 or more [force]
    real(real64), intent(inout) :: force(:, :)         !! of each cell, grows [force]
    real(real64), allocatable :: corner(:, :), edge_x(:), edge_y(:), share(:, :)
    integer :: first(2), last(2), i, j

    first = cell_at(grid, [x, y] - radius)
    last = cell_at(grid, [x, y] + radius)
    if (all(first == last)) then
      force(first(1), first(2)) = force(first(1), first(2)) + load
      return
    end if
    edge_x = edges_between(grid, 1, first(1), last(1), x, radius)
    edge_y = edges_between(grid, 2, first(2), last(2), y, radius)
    allocate (corner(size(edge_x), size(edge_y)))
    do j = 1, size(edge_y)
      corner(:, j) = dome_volume(edge_x, edge_y(j))
    end do
    allocate (share(size(edge_x) - 1, size(edge_y) - 1), source=0.0_real64)
    do j = 1, size(share, 2)
      do i = 1, size(share, 1)
        ! Beside the circle only rounding would be left.
        if (hypot(distance_of(edge_x(i:i + 1)), distance_of(edge_y(j:j + 1))) < 1.0_real64) &
          share(i, j) = max(0.0_real64, (corner(i + 1, j + 1) - corner(i, j + 1)) - &
                                        (corner(i + 1, j) - corner(i, j)))
      end do
    end do
    associate (cells => force(first(1):last(1), first(2):last(2)))
      cells = cells + share * (load / sum(share))
    end associate
  end subroutine add_circle

  !> Adds the load of a square of uniform pressure: each cell gets that of their common area.
  pure subroutine add_square(grid, x, y, side, load, force)
    type(field_grid), intent(in) :: grid          !! grid of square cells
    real(real64), intent(in) :: x, y              !! centre in plan [length]
    real(real64), intent(in) :: side              !! more than 0 [length]
    real(real64), intent(in) :: load              !! 0 or more [force]
    real(real64), intent(inout) :: force(:, :)    !! of each cell, grows [force]
    real(real64), allocatable :: edge_x(:), edge_y(:)
    integer :: first(2), last(2), i, j

    first = cell_at(grid, [x, y] - 0.5_real64 * side)
    last = cell_at(grid, [x, y] + 0.5_real64 * side)
    edge_x = edges_between(grid, 1, first(1), last(1), x, 0.5_real64 * side)
    edge_y = edges_between(grid, 2, first(2), last(2), y, 0.5_real64 * side)
    do j = first(2), last(2)
      do i = first(1), last(1)
        force(i, j) = force(i, j) + 0.25_real64 * load * &
          (edge_x(i - first(1) + 2) - edge_x(i - first(1) + 1)) * &
          (edge_y(j - first(2) + 2) - edge_y(j - first(2) + 1))
      end do
    end do
  end subroutine add_square

  ! Column and row of a place; of a place beyond the grid those of the nearest cell.
  pure function cell_at(grid, place) result(cell)
    type(field_grid), intent(in) :: grid
    real(real64), intent(in) :: place(2)
    integer :: cell(2)

    cell = int(min(max((place - grid%low) / grid%side, 0.0_real64), grid%cells - 0.5_real64)) + 1
  end function cell_at

  ! Edges of some cells along an axis, from a middle, over a reach; the outermost are -1 and 1.
  pure function edges_between(grid, axis, first, last, middle, reach) result(edges)
    type(field_grid), intent(in) :: grid
    integer, intent(in) :: axis, first, last
    real(real64), intent(in) :: middle, reach
    real(real64) :: edges(last - first + 2)
    integer :: i

    edges = [((grid%low(axis) + i * grid%side - middle) / reach, i=first - 1, last)]
    edges = min(max(edges, -1.0_real64), 1.0_real64)
    edges(1) = -1.0_real64
    edges(size(edges)) = 1.0_real64
  end function edges_between

  ! Integral of sqrt(1 - u**2 - v**2), where that is real, over 0 <= u <= x, 0 <= v <= y; odd in
  ! both.
  elemental real(real64) function dome_volume(x, y)
    real(real64), intent(in) :: x, y  ! from -1 to 1
    real(real64) :: s

    s = sqrt(max(tiny(s), 1.0_real64 - x**2 - y**2))
    dome_volume = (2.0_real64 * x * y * s + x * (3.0_real64 - x**2) * atan2(y, s) + &
                   y * (3.0_real64 - y**2) * atan2(x, s) - &
                   2.0_real64 * atan2(x * y, s)) / 6.0_real64
  end function dome_volume

  ! Distance of an interval from 0.
  pure real(real64) function distance_of(ends)
    real(real64), intent(in) :: ends(2)

    distance_of = max(0.0_real64, ends(1), -ends(2))
  end function distance_of

end module asperity_grid_pressures
