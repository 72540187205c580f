!> The pairs of two surfaces in order that are near enough in plan, by a sweep along strips.
!>
!> A layer of the one surface is searched with a layer of the other: strip against the strips in
!> reach, and in these from left to right, both in the order of x. So a search costs in proportion
!> to the asperities and the pairs found, wherever they lie.
module asperity_pair_search_layers
  use asperity_cell_grid, only: cell_grid
  use asperity_cell_layer, only: grid_layer, grid_point, spare_points
  use asperity_cell_reach, only: squared_reach
  use asperity_kinds, only: int32, int64, real64
  use asperity_pair_search_blocks, only: found_pairs, room_in_block
  implicit none
  private

  public :: search_pairs

  ! What one search is about.
  type :: search_task
    real(real64) :: height = 0.0_real64
    real(real64) :: offset(4) = 0.0_real64
    real(real64) :: margin = 0.0_real64
    real(real64) :: floor = -huge(1.0_real64)
    real(real64) :: distance = 0.0_real64         ! of the layers at hand
    logical :: upper_sought = .false.             ! the lower layer seeks
  end type search_task

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

  !> Finds the pairs of one position.
  !>
  !> A pair is found when (d - margin)**2 < squared_reach(height, RU + RL), d**2 being
  !> ((xu + dx) - xl)**2 + ((yu + dy) - yl)**2 in doubles, and when it touches at the floor or
  !> above: touch = (hu + hl) - d**2/(s + zc), zc**2 = (s - d)(s + d), s = RU + RL, for the least d
  !> that the margin allows, so that none can be larger.
  subroutine search_pairs(upper, lower, dx, dy, height, margin, floor, found, failed)
    type(cell_grid), intent(in) :: upper     !! the surface displaced
    type(cell_grid), intent(in) :: lower     !! the other surface
    real(real64), intent(in) :: dx           !! displacement of the upper surface
    real(real64), intent(in) :: dy           !! displacement of the upper surface
    real(real64), intent(in) :: height       !! how near pairs are, see `squared_reach`
    real(real64), intent(in) :: margin       !! what rounding may add to a distance, 0 or more
    real(real64), intent(in) :: floor        !! pairs with a smaller touch are left out
    type(found_pairs), intent(out) :: found  !! all other pairs
    logical, intent(out) :: failed           !! there is no memory for all pairs
    type(search_task) :: task
    integer :: i, j

    task%height = height
    task%margin = margin
    task%floor = floor
    failed = .false.
    do i = 1, size(upper%layers)
      do j = 1, size(lower%layers)
        associate (above => upper%layers(i), below => lower%layers(j))
          if (above%highest + below%highest < floor) cycle
          ! A little more: the sweep compares d**2 with the square of this.
          task%distance = (sqrt(squared_reach(height, above%largest + below%largest)) + margin) * &
                          (1.0_real64 + 1.0e-14_real64)
          if (.not. task%distance > 0.0_real64) cycle
          ! The larger radii are sought: their strips are as high as the reach.
          task%upper_sought = exponent(above%largest) > exponent(below%largest)
          ! The upper surface is displaced, whichever it is. Adding zero changes nothing.
          if (task%upper_sought) then
            task%offset = [0.0_real64, 0.0_real64, dx, dy]
            call sweep_layers(below, above, task, found, failed)
          else
            task%offset = [dx, dy, 0.0_real64, 0.0_real64]
            call sweep_layers(above, below, task, found, failed)
          end if
        end associate
        if (failed) return
      end do
    end do
  end subroutine search_pairs

  ! Strips of the one layer against the strips in reach of the other.
  subroutine sweep_layers(seekers, points, task, found, failed)
    type(grid_layer), intent(in) :: seekers, points
    type(search_task), intent(in) :: task
    type(found_pairs), intent(inout) :: found
    logical, intent(out) :: failed
    type(near_batch) :: near
    type(sweep_place) :: place
    real(real64) :: low, high
    integer :: strip, other, begin, lanes

    failed = .false.
    begin = 1
    do strip = 1, seekers%strips
      low = seekers%low(strip) + task%offset(2)
      high = seekers%high(strip) + task%offset(2)
      do while (begin <= points%strips)
        if (low - (points%high(begin) + task%offset(4)) < task%distance) exit
        begin = begin + 1
      end do
      other = begin
      do
        lanes = 0
        do while (lanes < most_lanes .and. other + lanes <= points%strips)
          if ((points%low(other + lanes) + task%offset(4)) - high >= task%distance) exit
          lanes = lanes + 1
        end do
        if (lanes == 0) exit
        call begin_sweep(seekers, points, strip, other, lanes, task%offset, task%distance, place)
        do while (place%seeker <= place%last_seeker)
          call sweep_strips(seekers%points(1:), points%points(1:), task%offset, task%distance, &
                            place, near)
          if (near%used < batch_size) cycle
          call keep_batch(seekers, points, task, near, found, failed)
          if (failed) return
        end do
        other = other + lanes
      end do
    end do
    call keep_batch(seekers, points, task, near, found, failed)
  end subroutine sweep_layers

  ! Keeps the pairs of a batch that are within reach and touch above the floor.
  subroutine keep_batch(seekers, points, task, near, found, failed)
    type(grid_layer), intent(in) :: seekers, points
    type(search_task), intent(in) :: task
    type(near_batch), intent(inout) :: near
    type(found_pairs), intent(inout) :: found
    logical, intent(out) :: failed
    real(real64) :: s(batch_room), bound(batch_room), touch(batch_room), d
    integer :: i, n, used

    failed = .false.
    n = near%used
    near%used = 0
    if (n == 0) return
    s(:n) = seekers%largest
    if (allocated(seekers%radius)) s(:n) = seekers%radius(near%seeker(:n))
    if (allocated(points%radius)) then
      s(:n) = s(:n) + points%radius(near%sought(:n))
    else
      s(:n) = s(:n) + points%largest
    end if
    if (allocated(seekers%radius) .or. allocated(points%radius)) then
      bound(:n) = reach_with_margin(task, s(:n))
    else
      bound(:n) = reach_with_margin(task, s(1))
    end if
    do i = 1, n
      associate (one => seekers%points(near%seeker(i)), other => points%points(near%sought(i)))
        touch(i) = one%height + other%height
        near%seeker(i) = one%index
        near%sought(i) = other%index
      end associate
    end do
    do i = 1, n
      d = min(max(sqrt(near%squared(i)) - task%margin, 0.0_real64), s(i))
      touch(i) = touch(i) - d * d / (s(i) + sqrt((s(i) - d) * (s(i) + d)))
    end do
    call room_in_block(found, n, failed)
    if (failed) return
    associate (block => found%block(found%blocks))
      used = block%used
      do i = 1, n
        if (.not. (near%squared(i) < bound(i) .and. touch(i) >= task%floor)) cycle
        used = used + 1
        if (task%upper_sought) then
          block%upper(used) = near%sought(i)
          block%lower(used) = near%seeker(i)
        else
          block%upper(used) = near%seeker(i)
          block%lower(used) = near%sought(i)
        end if
      end do
      found%number = found%number + int(used - block%used, int64)
      block%used = used
    end associate
  end subroutine keep_batch

  ! The bound on the square of the distance, with the margin of the task.
  elemental function reach_with_margin(task, s) result(bound)
    type(search_task), intent(in) :: task
    real(real64), intent(in) :: s
    real(real64) :: bound

    bound = (sqrt(squared_reach(task%height, s)) + task%margin)**2
  end function reach_with_margin

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
  !> group of points is tested without a branch, as that would be mispredicted.
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

end module asperity_pair_search_layers
