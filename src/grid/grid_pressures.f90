!> Loads of contacts, distributed over the elements of a grid.
!>
!> A load is conserved: the sum over the elements does not depend on their size. Parts of a contact
!> outside the grid are added to the elements at its edge.
module asperity_grid_pressures
  use asperity_kinds, only: real64
  implicit none
  private

  public :: add_circle, add_square, field_grid

  !> Grid of square elements in plan.
  type :: field_grid
    real(real64) :: low(2) = 0.0_real64    !! lower left corner of the first element [length]
    real(real64) :: side = 0.0_real64      !! side of an element [length]
    integer :: elements(2) = 0             !! numbers of columns along x, rows along y
  end type field_grid

contains

  !> Adds the load of a circular contact of the pressure of Hertz, p0 sqrt(1 - (r/a)**2), whose
  !> integral over each element is computed in closed form.
  pure subroutine add_circle(grid, x, y, radius, load, force)
    type(field_grid), intent(in) :: grid               !! grid of square elements
    real(real64), intent(in) :: x, y                   !! centre in plan [length]
    real(real64), intent(in) :: radius                 !! contact radius a, 0 or more [length]
    real(real64), intent(in) :: load                   !! normal load, 0 or more [force]
    real(real64), intent(inout) :: force(:, :)         !! (columns, rows): sum of loads [force]
    real(real64), allocatable :: corner_volume(:, :), edge_x(:), edge_y(:), volume(:, :)
    integer :: first(2), last(2), i, j

    first = element_at(grid, [x, y] - radius)
    last = element_at(grid, [x, y] + radius)
    if (all(first == last)) then
      force(first(1), first(2)) = force(first(1), first(2)) + load
      return
    end if
    edge_x = edges_between(grid, 1, first(1), last(1), x, radius)
    edge_y = edges_between(grid, 2, first(2), last(2), y, radius)
    allocate (corner_volume(size(edge_x), size(edge_y)))
    do j = 1, size(edge_y)
      corner_volume(:, j) = dome_volume(edge_x, edge_y(j))
    end do
    allocate (volume(size(edge_x) - 1, size(edge_y) - 1), source=0.0_real64)
    do j = 1, size(volume, 2)
      do i = 1, size(volume, 1)
        ! Outside the circle the differences would be rounding errors.
        if (hypot(distance_from_zero(edge_x(i:i + 1)), &
                  distance_from_zero(edge_y(j:j + 1))) < 1.0_real64) &
          volume(i, j) = max(0.0_real64, (corner_volume(i + 1, j + 1) - corner_volume(i, j + 1)) - &
                                         (corner_volume(i + 1, j) - corner_volume(i, j)))
      end do
    end do
    associate (elements => force(first(1):last(1), first(2):last(2)))
      elements = elements + volume * (load / sum(volume))
    end associate
  end subroutine add_circle

  !> Adds the load of a square of uniform pressure, in proportion to its area in each element.
  pure subroutine add_square(grid, x, y, side, load, force)
    type(field_grid), intent(in) :: grid          !! grid of square elements
    real(real64), intent(in) :: x, y              !! centre in plan [length]
    real(real64), intent(in) :: side              !! side of the square, > 0 [length]
    real(real64), intent(in) :: load              !! normal load, 0 or more [force]
    real(real64), intent(inout) :: force(:, :)    !! (columns, rows): sum of loads [force]
    real(real64), allocatable :: edge_x(:), edge_y(:)
    integer :: first(2), last(2), i, j

    first = element_at(grid, [x, y] - 0.5_real64 * side)
    last = element_at(grid, [x, y] + 0.5_real64 * side)
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

  ! Column and row of the element at a position, of the nearest element outside the grid.
  pure function element_at(grid, position) result(element)
    type(field_grid), intent(in) :: grid
    real(real64), intent(in) :: position(2)
    integer :: element(2)

    element = int(min(max((position - grid%low) / grid%side, 0.0_real64), &
                      grid%elements - 0.5_real64)) + 1
  end function element_at

  ! Edges of the elements from `first` to `last` along an axis, from the centre of the loaded area,
  ! over its half width; the outermost ones are set to -1 and 1.
  pure function edges_between(grid, axis, first, last, centre, half_width) result(edges)
    type(field_grid), intent(in) :: grid
    integer, intent(in) :: axis, first, last
    real(real64), intent(in) :: centre, half_width
    real(real64) :: edges(last - first + 2)
    integer :: i

    edges = [((grid%low(axis) + i * grid%side - centre) / half_width, i=first - 1, last)]
    edges = min(max(edges, -1.0_real64), 1.0_real64)
    edges(1) = -1.0_real64
    edges(size(edges)) = 1.0_real64
  end function edges_between

  ! Integral of sqrt(1 - u**2 - v**2), where that is real, over 0 <= u <= x and 0 <= v <= y: an odd
  ! function of x and of y.
  elemental real(real64) function dome_volume(x, y)
    real(real64), intent(in) :: x, y  ! from -1 to 1
    real(real64) :: s

    s = sqrt(max(tiny(s), 1.0_real64 - x**2 - y**2))
    dome_volume = (2.0_real64 * x * y * s + x * (3.0_real64 - x**2) * atan2(y, s) + &
                   y * (3.0_real64 - y**2) * atan2(x, s) - &
                   2.0_real64 * atan2(x * y, s)) / 6.0_real64
  end function dome_volume

  ! Distance of an interval, given by its ends, from 0.
  pure real(real64) function distance_from_zero(ends)
    real(real64), intent(in) :: ends(2)

    distance_from_zero = max(0.0_real64, ends(1), -ends(2))
  end function distance_from_zero

end module asperity_grid_pressures
