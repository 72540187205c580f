!> A surface sorted for the search of neighbours.
!>
!> Asperities are divided into layers by the power of two of their radius, so that a few large ones
!> do not widen the search for all small ones. Each layer is cut into strips along x, as high as the
!> largest distance of a pair of its asperities; a strip is sorted by x. Strips without asperities
!> do not exist: the cost is proportional to the number of asperities, whatever their distances. The
!> order does not depend on the displacement of the surface: one grid serves all positions.
module asperity_cell_grid
  use asperity_cell_reach, only: squared_reach
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int32, real64
  implicit none
  private

  public :: cell_grid, grid_layer, grid_point
  public :: build_grid, take_high_part

  !> A summit. Not initialised: a large array of these would be written twice.
  type :: grid_point
    real(real64) :: x           !! place in plan
    real(real64) :: y           !! place in plan
    real(real64) :: height      !! level of the summit
    real(real64) :: radius      !! radius of the asperity, > 0
    integer(int32) :: asperity  !! number of the asperity in its surface, from 1
  end type grid_point

  !> Asperities whose radii have one power of two.
  type :: grid_layer
    type(grid_point), allocatable :: points(:)  !! points strip by strip, in each by x
    integer(int32), allocatable :: first(:)     !! first point of each strip; then the end
    real(real64), allocatable :: low(:)         !! least y of each strip, ascending
    real(real64), allocatable :: high(:)        !! largest y of each strip, ascending
    real(real64) :: largest = 0.0_real64        !! largest radius
    real(real64) :: highest = 0.0_real64        !! largest height
  end type grid_layer

  !> A surface in layers and strips.
  type :: cell_grid
    type(grid_layer), allocatable :: layers(:)  !! layers in ascending order of the radius
  end type cell_grid

contains

  !> Sorts a surface. All lengths have one unit, near the radii: squares must not overflow.
  subroutine build_grid(grid, points, reach)
    type(cell_grid), intent(out) :: grid        !! the sorted surface
    type(grid_point), intent(in) :: points(:)   !! its summits at finite places; one at least
    real(real64), intent(in) :: reach           !! height of `squared_reach` of the searches;
                                                !! another one is correct, but slower
    integer, allocatable :: numbers(:)
    integer :: first_power, i, layer, power

    first_power = exponent(minval(points%radius))
    allocate (numbers(first_power:exponent(maxval(points%radius))), source=0)
    do i = 1, size(points)
      power = exponent(points(i)%radius)
      numbers(power) = numbers(power) + 1
    end do
    allocate (grid%layers(count(numbers > 0)))
    layer = 0
    do power = first_power, ubound(numbers, 1)
      if (numbers(power) == 0) cycle
      layer = layer + 1
      call build_layer(grid%layers(layer), pack(points, exponent(points%radius) == power), reach)
    end do
  end subroutine build_grid

  !> Selects the asperities of a sorted surface that are not lower than a level, in the same order.
  subroutine take_high_part(grid, least, part)
    type(cell_grid), intent(in) :: grid   !! the sorted surface
    real(real64), intent(in) :: least     !! level of the lowest summits
    type(cell_grid), intent(out) :: part  !! asperities with their indices in the surface
    logical, allocatable :: is_high(:)
    integer :: i, k, strip

    allocate (part%layers(count(grid%layers%highest >= least)))
    k = 0
    do i = 1, size(grid%layers)
      if (grid%layers(i)%highest < least) cycle
      k = k + 1
      associate (layer => grid%layers(i))
        is_high = layer%points%height >= least
        part%layers(k)%points = pack(layer%points, is_high)
        call set_strips(part%layers(k), [(count(is_high(layer%first(strip): &
                                                        layer%first(strip + 1) - 1)), &
                                          strip=1, size(layer%low))])
      end associate
    end do
  end subroutine take_high_part

  ! Sorts the asperities of one layer: by y, a strip begins with the first point above the previous
  ! one; then each strip by x. Both surfaces are cut at multiples of one height: undisplaced, a
  ! strip meets three others.
  subroutine build_layer(layer, points, reach)
    type(grid_layer), intent(inout) :: layer
    type(grid_point), intent(in) :: points(:)
    real(real64), intent(in) :: reach
    integer(int32), allocatable :: order(:)
    integer, allocatable :: numbers(:)
    real(real64) :: edge, tall
    integer :: i, strip

    ! Largest distance of a pair of asperities of a layer, with a margin.
    tall = sqrt(squared_reach(reach, 2 * maxval(points%radius))) * (1.0_real64 + 1.0e-6_real64)
    if (.not. tall > 0.0_real64) tall = maxval(points%radius)
    allocate (order(size(points)))
    allocate (numbers(size(points)), source=0)
    call sort_keys(points%y, order)
    layer%points = points(order)
    strip = 0
    edge = -huge(edge)
    do i = 1, size(points)
      associate (y => layer%points(i)%y)
        if (strip == 0 .or. .not. y < edge) then
          strip = strip + 1
          edge = y + tall
          if (abs(y) < 1.0e9_real64 * tall) edge = tall * (floor(y / tall) + 1.0_real64)
        end if
      end associate
      numbers(strip) = numbers(strip) + 1
    end do
    call set_strips(layer, numbers(:strip))
    do strip = 1, size(layer%low)
      i = numbers(strip)
      associate (row => layer%points(layer%first(strip):layer%first(strip + 1) - 1))
        call sort_keys(row%x, order(:i))
        row = row(order(:i))
      end associate
    end do
  end subroutine build_layer

  ! Sets the bounds of a layer and of its strips, from the numbers of their points.
  subroutine set_strips(layer, numbers)
    type(grid_layer), intent(inout) :: layer
    integer, intent(in) :: numbers(:)
    integer :: i, strip

    layer%largest = maxval(layer%points%radius)
    layer%highest = maxval(layer%points%height)
    strip = count(numbers > 0)
    allocate (layer%first(strip + 1), layer%low(strip), layer%high(strip))
    layer%first(1) = 1
    strip = 0
    do i = 1, size(numbers)
      if (numbers(i) == 0) cycle
      strip = strip + 1
      layer%first(strip + 1) = layer%first(strip) + int(numbers(i), int32)
      associate (y => layer%points(layer%first(strip):layer%first(strip + 1) - 1)%y)
        layer%low(strip) = minval(y)
        layer%high(strip) = maxval(y)
      end associate
    end do
  end subroutine set_strips

end module asperity_cell_grid
