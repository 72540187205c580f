!> A surface sorted for the search of neighbours.
!>
!> Asperities are divided into layers by the power of two of their radius, so that a few large ones
!> do not widen the search for all small ones. Each layer is cut into strips along x, as high as the
!> largest distance of a pair of its asperities; a strip is sorted by x. Strips without asperities
!> do not exist: the cost is proportional to the number of asperities, whatever their distances. The
!> order does not depend on the displacement of the surface: one grid serves all positions.
module asperity_cell_grid
  use asperity_cell_layer, only: build_layer, grid_layer, take_high_points
  use asperity_kinds, only: int32, real64
  implicit none
  private

  public :: build_grid, cell_grid, number_span, span_of, take_high_part

  !> A surface in layers and strips.
  type :: cell_grid
    type(grid_layer), allocatable :: layers(:)  !! layers in ascending order of the radius
  end type cell_grid

  !> Range of numbers.
  type :: number_span
    real(real64) :: least = huge(1.0_real64)      !! least number; huge when there are none
    real(real64) :: largest = -huge(1.0_real64)   !! largest number; -huge when there are none
  end type number_span

contains

  !> Sorts a surface. All lengths have one unit, near the radii: squares must not overflow.
  subroutine build_grid(grid, x, y, height, radius, reach)
    type(cell_grid), intent(out) :: grid               !! the sorted surface
    real(real64), contiguous, intent(in) :: x(:)       !! positions, finite; one at least
    real(real64), contiguous, intent(in) :: y(:)       !! positions, as many as x
    real(real64), contiguous, intent(in) :: height(:)  !! summit levels, as many as x
    real(real64), contiguous, intent(in) :: radius(:)  !! radii, as many as x, each > 0
    real(real64), intent(in) :: reach                  !! height of `squared_reach` of the searches;
                                                       !! another one is correct, but slower
    integer(int32), allocatable :: members(:), ends(:)
    type(number_span) :: radii
    integer :: power, i, previous_end, layers

    radii = span_of(radius)
    if (exponent(radii%least) == exponent(radii%largest)) then
      allocate (grid%layers(1), members(0))
      call build_layer(grid%layers(1), x, y, height, radius, members, reach)
      return
    end if
    call part_by_power(radius, exponent(radii%least), exponent(radii%largest), members, ends)
    layers = 0
    previous_end = 0
    do i = lbound(ends, 1), ubound(ends, 1)
      if (ends(i) > previous_end) layers = layers + 1
      previous_end = ends(i)
    end do
    allocate (grid%layers(layers))
    layers = 0
    previous_end = 0
    do power = lbound(ends, 1), ubound(ends, 1)
      if (ends(power) == previous_end) cycle
      layers = layers + 1
      call build_layer(grid%layers(layers), x, y, height, radius, &
                       members(previous_end + 1:ends(power)), reach)
      previous_end = ends(power)
    end do
  end subroutine build_grid

  !> Selects the asperities of a sorted surface that are not lower than a level, in the same order.
  subroutine take_high_part(grid, least, part)
    type(cell_grid), intent(in) :: grid   !! the sorted surface
    real(real64), intent(in) :: least     !! level of the lowest summits
    type(cell_grid), intent(out) :: part  !! asperities with their indices in the surface
    integer :: i, k

    allocate (part%layers(count(grid%layers%highest >= least)))
    k = 0
    do i = 1, size(grid%layers)
      if (grid%layers(i)%highest < least) cycle
      k = k + 1
      call take_high_points(grid%layers(i), least, part%layers(k))
    end do
  end subroutine take_high_part

  !> Range of numbers.
  pure function span_of(numbers) result(span)
    real(real64), contiguous, intent(in) :: numbers(:)  !! any finite numbers
    type(number_span) :: span                           !! range of all numbers

    span = number_span(minval(numbers), maxval(numbers))
  end function span_of

  ! Sorts indices by the power of two of the radius. `ends`: the last index of each power.
  subroutine part_by_power(radius, first, last, members, ends)
    real(real64), contiguous, intent(in) :: radius(:)
    integer, intent(in) :: first, last
    integer(int32), allocatable, intent(out) :: members(:), ends(:)
    integer :: i, power, before, own

    allocate (members(size(radius)), ends(first:last))
    ends(:) = 0_int32
    do i = 1, size(radius)
      power = exponent(radius(i))
      ends(power) = ends(power) + 1_int32
    end do
    before = 0
    do power = lbound(ends, 1), ubound(ends, 1)
      own = ends(power)
      ends(power) = before
      before = before + own
    end do
    do i = 1, size(radius)
      power = exponent(radius(i))
      ends(power) = ends(power) + 1_int32
      members(ends(power)) = int(i, int32)
    end do
  end subroutine part_by_power

end module asperity_cell_grid
