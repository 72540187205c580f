!> One layer of a sorted surface: strips along x, each sorted by x.
module asperity_cell_layer
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int32, real64
  implicit none
  private

  public :: grid_layer, grid_point, build_layer, spare_points, take_high_points, any_height, &
            margin_of_arithmetic, squared_reach

  !> Points after the last one of a layer, so that a search may test some together.
  integer, parameter :: spare_points = 4

  !> A summit. Not initialised: a large array of these would be written twice.
  type :: grid_point
    real(real64) :: x           !! place in plan
    real(real64) :: y           !! place in plan
    real(real64) :: height      !! level of the summit
    integer(int32) :: asperity  !! number of the asperity in its surface, from 1
  end type grid_point

  !> Asperities whose radii have one power of two.
  type :: grid_layer
    type(grid_point), allocatable :: points(:)  !! points of the strips by x; spare ones last
    real(real64), allocatable :: radius(:)      !! radius of each point; only where radii differ
    integer :: strips = 0                       !! number of strips, each with an asperity at least
    integer(int32), allocatable :: first(:)     !! first point of each strip; then the end
    real(real64), allocatable :: low(:)         !! least y of each strip, ascending
    real(real64), allocatable :: high(:)        !! largest y of each strip, ascending
    real(real64) :: smallest = 0.0_real64       !! least radius
    real(real64) :: largest = 0.0_real64        !! largest radius
    real(real64) :: highest = 0.0_real64        !! largest height
  end type grid_layer

  !> No bound by height: every pair whose spheres can touch counts.
  real(real64), parameter :: any_height = huge(1.0_real64)

contains

  !> Sorts the asperities of one layer.
  subroutine build_layer(layer, x, y, height, radius, members, reach)
    type(grid_layer), intent(inout) :: layer           !! the sorted layer
    real(real64), contiguous, intent(in) :: x(:)       !! positions of all asperities of the surface
    real(real64), contiguous, intent(in) :: y(:)       !! positions, as many as x
    real(real64), contiguous, intent(in) :: height(:)  !! summit levels, as many as x
    real(real64), contiguous, intent(in) :: radius(:)  !! radii, as many as x
    integer(int32), intent(in) :: members(:)           !! asperities of the layer; empty: all
    real(real64), intent(in) :: reach                  !! height of `squared_reach`
    integer(int32), allocatable :: ends(:)
    real(real64) :: tall, bottom, top
    integer :: n, i, m

    n = size(members)
    if (n == 0) n = size(x)
    layer%smallest = huge(1.0_real64)
    layer%largest = 0.0_real64
    layer%highest = -huge(1.0_real64)
    bottom = huge(1.0_real64)
    top = -huge(1.0_real64)
    do i = 1, n
      m = i
      if (size(members) > 0) m = members(i)
      layer%smallest = min(layer%smallest, radius(m))
      layer%largest = max(layer%largest, radius(m))
      layer%highest = max(layer%highest, height(m))
      bottom = min(bottom, y(m))
      top = max(top, y(m))
    end do
    allocate (layer%points(n + spare_points))
    tall = strip_height(layer%largest, reach)
    ! Both surfaces are cut at multiples of one height: undisplaced, a strip meets three others.
    if (abs(bottom) < 1.0e9_real64 * tall) bottom = tall * real(floor(bottom / tall), real64)
    if (top - bottom < tall * (4.0_real64 * real(n, real64) + 1000.0_real64)) then
      call fill_rows(layer%points(1:n), x, y, height, members, [bottom, top], tall, ends)
    else
      call fill_sorted(layer%points(1:n), x, y, height, members, tall, ends)
    end if
    layer%points(n + 1:n + spare_points) = layer%points(n)
    call finish_strips(layer, ends)
    if (.not. layer%smallest < layer%largest) return
    allocate (layer%radius(n))
    do i = 1, n
      layer%radius(i) = radius(layer%points(i)%asperity)
    end do
  end subroutine build_layer

  !> Selects the points of a layer that are not lower than a level, in the same order.
  subroutine take_high_points(layer, least, part)
    type(grid_layer), intent(in) :: layer  !! the sorted layer
    real(real64), intent(in) :: least      !! least height, at most `highest`
    type(grid_layer), intent(out) :: part  !! selected points with the bounds of the whole layer
    integer :: n, i, k, strip

    n = layer%first(layer%strips + 1) - 1
    if (allocated(layer%radius)) &
      part%radius = pack(layer%radius, layer%points(1:n)%height >= least)
    n = count(layer%points(1:n)%height >= least)
    allocate (part%points(n + spare_points))
    part%smallest = layer%smallest
    part%largest = layer%largest
    part%highest = layer%highest
    k = min(layer%strips, n)
    allocate (part%first(k + 1), part%low(k), part%high(k))
    part%first(1) = 1_int32
    n = 0
    do strip = 1, layer%strips
      k = n
      do i = layer%first(strip), layer%first(strip + 1) - 1
        ! Without a branch, which would be mispredicted: the next point overwrites a low one.
        part%points(n + 1) = layer%points(i)
        n = n + merge(1, 0, layer%points(i)%height >= least)
      end do
      if (n == k) cycle
      part%strips = part%strips + 1
      part%low(part%strips) = minval(part%points(k + 1:n)%y)
      part%high(part%strips) = maxval(part%points(k + 1:n)%y)
      part%first(part%strips + 1) = int(n + 1, int32)
    end do
    part%points(n + 1:n + spare_points) = part%points(n)
  end subroutine take_high_points

  ! Largest distance of a pair of asperities of a layer, with a margin.
  pure real(real64) function strip_height(largest, reach) result(tall)
    real(real64), intent(in) :: largest, reach

    tall = sqrt(squared_reach(reach, 2.0_real64 * largest)) * (1.0_real64 + 1.0e-6_real64)
    if (.not. tall > 0.0_real64) tall = largest
  end function strip_height

  ! Sorts points into rows of equal height by counting. `ends`: the last point of each row.
  subroutine fill_rows(points, x, y, height, members, span, tall, ends)
    type(grid_point), contiguous, intent(inout) :: points(:)
    real(real64), contiguous, intent(in) :: x(:), y(:), height(:)
    integer(int32), intent(in) :: members(:)
    real(real64), intent(in) :: span(2), tall
    integer(int32), allocatable, intent(out) :: ends(:)
    real(real64) :: rows_per_length
    integer :: rows, row, i, m, k, before, own
    logical :: all_members

    all_members = size(members) == 0
    rows_per_length = 1.0_real64 / tall
    rows = int((span(2) - span(1)) * rows_per_length) + 1
    allocate (ends(rows))
    ends(:) = 0_int32
    do i = 1, size(points)
      m = i
      if (.not. all_members) m = members(i)
      row = int((y(m) - span(1)) * rows_per_length) + 1
      ends(row) = ends(row) + 1_int32
    end do
    before = 0
    do row = 1, rows
      own = ends(row)
      ends(row) = before
      before = before + own
    end do
    do i = 1, size(points)
      m = i
      if (.not. all_members) m = members(i)
      row = int((y(m) - span(1)) * rows_per_length) + 1
      k = ends(row) + 1
      ends(row) = k
      points(k)%x = x(m)
      points(k)%y = y(m)
      points(k)%height = height(m)
      points(k)%asperity = int(m, int32)
    end do
  end subroutine fill_rows

  ! Sorts points into rows where rows of equal height would be empty mostly: points are sorted by y;
  ! a row begins with the first point above the previous row.
  subroutine fill_sorted(points, x, y, height, members, tall, ends)
    type(grid_point), contiguous, intent(inout) :: points(:)
    real(real64), contiguous, intent(in) :: x(:), y(:), height(:)
    integer(int32), intent(in) :: members(:)
    real(real64), intent(in) :: tall
    integer(int32), allocatable, intent(out) :: ends(:)
    real(real64), allocatable :: key(:)
    integer(int32), allocatable :: order(:)
    real(real64) :: bottom
    integer :: n, i, m, rows, pass

    n = size(points)
    allocate (key(n), order(n))
    if (size(members) > 0) then
      key(:) = y(members)
    else
      key(:) = y
    end if
    call sort_keys(key, order)
    key(:) = key(order)
    do i = 1, n
      m = order(i)
      if (size(members) > 0) m = members(m)
      points(i)%x = x(m)
      points(i)%y = y(m)
      points(i)%height = height(m)
      points(i)%asperity = int(m, int32)
    end do
    do pass = 1, 2
      rows = 1
      bottom = key(1)
      do i = 2, n
        if (key(i) - bottom < tall) cycle
        if (pass == 2) ends(rows) = int(i - 1, int32)
        rows = rows + 1
        bottom = key(i)
      end do
      if (pass == 1) allocate (ends(rows))
    end do
    ends(rows) = int(n, int32)
  end subroutine fill_sorted

  ! Sorts every row by x and removes empty rows.
  subroutine finish_strips(layer, ends)
    type(grid_layer), intent(inout) :: layer
    integer(int32), intent(in) :: ends(:)
    type(grid_point), allocatable :: row_points(:)
    real(real64), allocatable :: key(:)
    integer(int32), allocatable :: order(:)
    integer :: row, strips, begin, most, n, i

    strips = 0
    most = 0
    begin = 0
    do row = 1, size(ends)
      if (ends(row) > begin) strips = strips + 1
      most = max(most, ends(row) - begin)
      begin = ends(row)
    end do
    layer%strips = strips
    allocate (layer%first(strips + 1), layer%low(strips), layer%high(strips))
    allocate (row_points(most), key(most), order(most))
    strips = 0
    begin = 0
    do row = 1, size(ends)
      n = ends(row) - begin
      if (n == 0) cycle
      strips = strips + 1
      layer%first(strips) = int(begin + 1, int32)
      layer%low(strips) = layer%points(begin + 1)%y
      layer%high(strips) = layer%low(strips)
      do i = 1, n
        row_points(i) = layer%points(begin + i)
        key(i) = row_points(i)%x
        layer%low(strips) = min(layer%low(strips), row_points(i)%y)
        layer%high(strips) = max(layer%high(strips), row_points(i)%y)
      end do
      call sort_keys(key(:n), order(:n))
      do i = 1, n
        layer%points(begin + i) = row_points(order(i))
      end do
      begin = ends(row)
    end do
    layer%first(strips + 1) = ends(size(ends)) + 1_int32
  end subroutine finish_strips

  !> Upper bound of d**2, where d is the distance of two summits in plan. The sum of the radii
  !> s = RU + RL always bounds d: spheres farther apart cannot touch. The thesis bounds it by the
  !> largest height (Appendix 5), d**2 < 2 s height: a larger offset in plan reduces the height of
  !> contact by more than that. Zero when no pair can count.
  elemental real(real64) function squared_reach(height, s) result(bound)
    real(real64), intent(in) :: height  !! largest height; `any_height`: no such bound
    real(real64), intent(in) :: s       !! sum of the radii, more than 0

    bound = s * s
    ! The comparison comes first, so that a huge height does not overflow.
    if (height < s) bound = min(bound, max((s + s) * height, 0.0_real64))
  end function squared_reach

  !> Bound of the rounding of a distance in an arithmetic [length].
  !>
  !> An arithmetic rounds displaced positions (once each axis), their difference, the square of the
  !> distance and the bound (a few times each): less than 8 units of the last place of the largest
  !> length.
  elemental real(real64) function margin_of_arithmetic(unit, extent) result(margin)
    real(real64), intent(in) :: unit    !! spacing at 1 of its numbers: 2**-23, 16**-5, ...
    real(real64), intent(in) :: extent  !! upper bound of |x| + |y| + |dx| + |dy| + s

    margin = 8.0_real64 * max(unit, epsilon(unit)) * extent
  end function margin_of_arithmetic

end module asperity_cell_layer
