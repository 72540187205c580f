!> The inner loop of the pair search: a strip against some strips, all in the order of x.
module asperity_pair_search_sweep
  use asperity_cell_layer, only: grid_layer, grid_point, spare_points
  use asperity_kinds, only: int32, real64
  implicit none
  private

  public :: near_batch, sweep_place
  public :: batch_room, batch_size, begin_sweep, most_lanes, sweep_strips

  !> Near pairs gathered before their separations are computed together.
  integer, parameter :: batch_size = 2048
  !> Strips searched side by side. Where the next search begins depends on the one before; while
  !> the processor waits for that in one strip it works in the others.
  integer, parameter :: most_lanes = 4

  ! Points tested together. A group may begin just behind the last point of a layer.
  integer, parameter :: group = spare_points

  !> Room of a batch: it is looked at when a point has been to all lanes.
  integer, parameter :: batch_room = batch_size + most_lanes * group

  !> Pairs within the largest reach of two layers.
  type :: near_batch
    integer :: used = 0                   !! pairs gathered; a batch is full from batch_size on
    integer(int32) :: seeker(batch_room)  !! place in the layer that seeks
    integer(int32) :: sought(batch_room)  !! place in the layer that is searched
    real(real64) :: squared(batch_room)   !! square of their distance in plan
  end type near_batch

  !> Where a sweep stands, so that it can go on after a full batch.
  type :: sweep_place
    integer :: seeker = 1            !! the point that seeks
    integer :: last_seeker = 0       !! the last one
    integer :: lanes = 0             !! strips searched
    integer :: lane = 1              !! the one that is searched
    integer :: next = 1              !! the next point to test in it
    integer :: start(most_lanes) = 1  !! in each, the first point that may be in reach
    integer :: last(most_lanes) = 0  !! in each, the last point
  end type sweep_place

contains

  !> Sets a sweep to the points of a strip and of `lanes` others that can be in reach.
  pure subroutine begin_sweep(seekers, points, strip, other, lanes, offset, distance, place)
    type(grid_layer), intent(in) :: seekers  !! the layer that seeks
    type(grid_layer), intent(in) :: points   !! the layer that is searched
    integer, intent(in) :: strip             !! of the one
    integer, intent(in) :: other             !! the first of the other
    integer, intent(in) :: lanes             !! strips from there on, `most_lanes` at most
    real(real64), intent(in) :: offset(4)    !! added to x, y of seekers, of points
    real(real64), intent(in) :: distance     !! reach
    type(sweep_place), intent(out) :: place  !! where to begin
    real(real64) :: left, right
    integer :: lane, first, last

    place%lanes = lanes
    first = seekers%first(strip)
    last = seekers%first(strip + 1) - 1
    left = huge(left)
    right = -huge(right)
    do lane = 1, lanes
      place%start(lane) = points%first(other + lane - 1)
      place%last(lane) = points%first(other + lane) - 1
      left = min(left, points%points(place%start(lane))%x + offset(3))
      right = max(right, points%points(place%last(lane))%x + offset(3))
    end do
    place%seeker = first_reached(seekers%points(1:), first, last, left, offset(1), distance)
    place%last_seeker = last_reaching(seekers%points(1:), place%seeker, last, right, offset(1), &
                                      distance)
    if (place%seeker > place%last_seeker) return
    left = seekers%points(place%seeker)%x + offset(1)
    do lane = 1, lanes
      place%start(lane) = first_reached(points%points(1:), place%start(lane), place%last(lane), &
                                        left, offset(3), distance)
    end do
    place%next = place%start(1)
  end subroutine begin_sweep

  ! The first point from `from` to `to` that is not left of all that `x` can reach, or the one
  ! behind `to`. Gallops: it is near as a rule.
  pure integer function first_reached(list, from, to, x, shift, distance)
    type(grid_point), contiguous, intent(in) :: list(:)
    integer, intent(in) :: from, to
    real(real64), intent(in) :: x, shift, distance
    integer :: low, high, middle, step

    low = from
    high = from
    step = 1
    do while (high <= to)
      if (x - (list(high)%x + shift) < distance) exit
      low = high + 1
      high = high + step
      step = min(2 * step, to)
    end do
    high = min(high, to + 1)
    do while (low < high)
      middle = low + (high - low) / 2
      if (x - (list(middle)%x + shift) < distance) then
        high = middle
      else
        low = middle + 1
      end if
    end do
    first_reached = low
  end function first_reached

  ! The last point from `from` to `to` that is not right of all that `x` can reach, or the one
  ! before `from`.
  pure integer function last_reaching(list, from, to, x, shift, distance)
    type(grid_point), contiguous, intent(in) :: list(:)
    integer, intent(in) :: from, to
    real(real64), intent(in) :: x, shift, distance
    integer :: low, high, middle

    low = from - 1
    high = to
    do while (low < high)
      middle = high - (high - low) / 2
      if ((list(middle)%x + shift) - x < distance) then
        low = middle
      else
        high = middle - 1
      end if
    end do
    last_reaching = low
  end function last_reaching

  !> Gathers pairs nearer than `distance` until the strips or the batch are at their end.
  !>
  !> Differences are taken as the distance itself takes them, so no rounding can lose a pair. A
  !> group of points is tested without a branch: whether a point is near cannot be foretold.
  pure subroutine sweep_strips(seekers, points, offset, distance, place, near)
    type(grid_point), contiguous, intent(in) :: seekers(:)  !! the layer that seeks
    type(grid_point), contiguous, intent(in) :: points(:)   !! searched; with spare ones
    real(real64), intent(in) :: offset(4)                   !! added to x, y of seekers, of points
    real(real64), intent(in) :: distance                    !! reach
    type(sweep_place), intent(inout) :: place               !! where to go on
    type(near_batch), intent(inout) :: near                 !! pairs so far
    real(real64) :: x, y, shift_x, shift_y, across, along, squared, bound
    integer :: seeker, lane, start, next, last, used, inside, i

    bound = distance * distance
    shift_x = offset(3)
    shift_y = offset(4)
    lane = place%lane
    next = place%next
    used = near%used
    seeker = place%seeker
    strips: do while (seeker <= place%last_seeker)
      x = seekers(seeker)%x + offset(1)
      y = seekers(seeker)%y + offset(2)
      do
        start = place%start(lane)
        last = place%last(lane)
        do
          do i = next, next + group - 1
            across = x - (points(i)%x + shift_x)
            along = y - (points(i)%y + shift_y)
            squared = across * across + along * along
            inside = merge(1, 0, i <= last)
            near%seeker(used + 1) = seeker
            near%sought(used + 1) = i
            near%squared(used + 1) = squared
            used = used + iand(inside, merge(1, 0, squared < bound))
            start = start + iand(inside, merge(1, 0, across >= distance))
          end do
          next = next + group
          if (start == next) then
            ! All were left behind: many more may be.
            start = first_reached(points, start, last, x, shift_x, distance)
            next = start
          end if
          if (next > last) exit
          if ((points(next)%x + shift_x) - x >= distance) exit
          if (used < batch_size) cycle
          place%start(lane) = start
          exit strips
        end do
        place%start(lane) = start
        if (lane == place%lanes) exit
        lane = lane + 1
        next = place%start(lane)
      end do
      seeker = seeker + 1
      lane = 1
      next = place%start(1)
      if (used >= batch_size) exit strips
    end do strips
    near%used = used
    place%seeker = seeker
    place%lane = lane
    place%next = next
  end subroutine sweep_strips

end module asperity_pair_search_sweep
