!> The near pairs of two sorted surfaces, by a sweep along strips.
!>
!> Each layer of one surface is searched with each layer of the other: every strip against the
!> strips in reach, both from left to right in the order of x. The cost is proportional to the
!> number of asperities and of the pairs found, whatever their positions.
!>
!> Found pairs are kept in blocks: nothing is copied when their number grows.
module asperity_pair_search_layers
  use asperity_cell_grid, only: cell_grid
  use asperity_cell_layer, only: grid_layer, grid_point, spare_points, squared_reach
  use asperity_kinds, only: int32, int64, real64
  implicit none
  private

  public :: search_pairs, found_pairs

  ! Criteria of one search.
  type :: search_task
    real(real64) :: height = 0.0_real64               ! of `squared_reach`
    real(real64) :: offset(4) = 0.0_real64            ! added to x, y of first and second layer
    real(real64) :: margin = 0.0_real64               ! bound of the rounding of a distance
    real(real64) :: least_touch = -huge(1.0_real64)   ! compression of first contact at least
    real(real64) :: distance = 0.0_real64             ! largest reach of the two layers
    logical :: upper_is_second = .false.              ! the first layer is of the lower surface
  end type search_task

  !> Number of near pairs that are collected before they are examined together.
  integer, parameter :: batch_size = 2048
  !> Number of strips searched in turn. The start of a search depends on the result of the previous
  !> one in the same strip; strips in turn are independent, which hides that latency.
  integer, parameter :: most_lanes = 4

  ! Number of points tested together. A group may begin just after the last point of a layer.
  integer, parameter :: group = spare_points

  !> Room of a batch: whether it is full is tested once for each point and all lanes.
  integer, parameter :: batch_room = batch_size + most_lanes * group

  !> Pairs within the largest reach of two layers, the first and the second.
  type :: near_batch
    integer :: used = 0                   !! number of pairs; full from batch_size on
    integer(int32) :: first(batch_room)   !! index in the first layer
    integer(int32) :: second(batch_room)  !! index in the second layer
    real(real64) :: squared(batch_room)   !! square of their distance in plan
  end type near_batch

  !> State of a sweep, so that it can be resumed after a full batch.
  type :: sweep_place
    integer :: point = 1              !! current point of the strip of the first layer
    integer :: last_point = 0         !! last point of that strip
    integer :: lanes = 0              !! number of strips of the second layer
    integer :: lane = 1               !! current one of these strips
    integer :: next = 1               !! next point to test in it
    integer :: start(most_lanes) = 1  !! first point in each that may be in reach
    integer :: last(most_lanes) = 0   !! last point in each
  end type sweep_place

  ! Number of pairs of a block.
  integer, parameter :: block_size = 65536

  !> A block of pairs.
  type :: pair_block
    integer :: used = 0                      !! number of pairs in the block
    integer(int32), allocatable :: upper(:)  !! indices of the upper asperities, from 1
    integer(int32), allocatable :: lower(:)  !! indices of the lower asperities, from 1
  end type pair_block

  !> All pairs found, in the order of the search, which is the same in every run.
  type :: found_pairs
    integer(int64) :: number = 0_int64         !! pairs in all blocks
    integer :: blocks = 0                      !! blocks in use
    type(pair_block), allocatable :: block(:)  !! the first `blocks` are in use
  end type found_pairs

contains

  !> Finds the near pairs at one position.
  !>
  !> A pair is found when (d - margin)**2 < squared_reach(height, RU + RL), d**2 being
  !> ((xu + dx) - xl)**2 + ((yu + dy) - yl)**2 in doubles, and when its touch is `least_touch` or
  !> more: touch = (hu + hl) - d**2/(s + zc), zc**2 = (s - d)(s + d), s = RU + RL, for the least d
  !> that the margin allows, an upper bound of the touch.
  subroutine search_pairs(upper, lower, dx, dy, height, margin, least_touch, found, failed)
    ! Long: position and bounds are plain numbers, which callers have as such.
    type(cell_grid), intent(in) :: upper     !! the sorted surface that is displaced
    type(cell_grid), intent(in) :: lower     !! the other sorted surface
    real(real64), intent(in) :: dx           !! displacement of the upper surface along x
    real(real64), intent(in) :: dy           !! displacement of the upper surface along y
    real(real64), intent(in) :: height       !! height of `squared_reach`
    real(real64), intent(in) :: margin       !! bound of the rounding of a distance, 0 or more
    real(real64), intent(in) :: least_touch  !! pairs with a smaller touch are left out
    type(found_pairs), intent(out) :: found  !! near pairs, in the order of the search
    logical, intent(out) :: failed           !! whether memory is short
    type(search_task) :: task
    integer :: i, j

    task%height = height
    task%margin = margin
    task%least_touch = least_touch
    failed = .false.
    do i = 1, size(upper%layers)
      do j = 1, size(lower%layers)
        associate (above => upper%layers(i), below => lower%layers(j))
          if (above%highest + below%highest < least_touch) cycle
          ! The factor covers rounding: the sweep compares d**2 with the square of this.
          task%distance = (sqrt(squared_reach(height, above%largest + below%largest)) + margin) * &
                          (1.0_real64 + 1.0e-14_real64)
          if (.not. task%distance > 0.0_real64) cycle
          ! The second layer has the larger radii: its strips are as high as the reach.
          task%upper_is_second = exponent(above%largest) > exponent(below%largest)
          ! The upper surface is displaced, whether first or second. Adding zero is exact.
          if (task%upper_is_second) then
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

  ! Searches each strip of the first layer with the strips in reach of the second.
  subroutine sweep_layers(first_layer, points, task, found, failed)
    type(grid_layer), intent(in) :: first_layer, points
    type(search_task), intent(in) :: task
    type(found_pairs), intent(inout) :: found
    logical, intent(out) :: failed
    type(near_batch) :: near
    type(sweep_place) :: place
    real(real64) :: low, high
    integer :: strip, other, begin, lanes

    failed = .false.
    begin = 1
    do strip = 1, first_layer%strips
      low = first_layer%low(strip) + task%offset(2)
      high = first_layer%high(strip) + task%offset(2)
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
        call begin_sweep(first_layer, points, strip, other, lanes, task%offset, task%distance, &
                         place)
        do while (place%point <= place%last_point)
          call sweep_strips(first_layer%points(1:), points%points(1:), task%offset, task%distance, &
                            place, near)
          if (near%used < batch_size) cycle
          call keep_batch(first_layer, points, task, near, found, failed)
          if (failed) return
        end do
        other = other + lanes
      end do
    end do
    call keep_batch(first_layer, points, task, near, found, failed)
  end subroutine sweep_layers

  ! Keeps the pairs of a batch that are within reach and whose touch is large enough.
  subroutine keep_batch(first_layer, points, task, near, found, failed)
    type(grid_layer), intent(in) :: first_layer, points
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
    s(:n) = first_layer%largest
    if (allocated(first_layer%radius)) s(:n) = first_layer%radius(near%first(:n))
    if (allocated(points%radius)) then
      s(:n) = s(:n) + points%radius(near%second(:n))
    else
      s(:n) = s(:n) + points%largest
    end if
    if (allocated(first_layer%radius) .or. allocated(points%radius)) then
      bound(:n) = reach_with_margin(task, s(:n))
    else
      bound(:n) = reach_with_margin(task, s(1))
    end if
    do i = 1, n
      associate (one => first_layer%points(near%first(i)), other => points%points(near%second(i)))
        touch(i) = one%height + other%height
        near%first(i) = one%asperity
        near%second(i) = other%asperity
      end associate
    end do
    do i = 1, n
      d = min(max(sqrt(near%squared(i)) - task%margin, 0.0_real64), s(i))
      touch(i) = touch(i) - d * d / (s(i) + sqrt((s(i) - d) * (s(i) + d)))
    end do
    call reserve_room(found, n, failed)
    if (failed) return
    associate (block => found%block(found%blocks))
      used = block%used
      do i = 1, n
        if (.not. (near%squared(i) < bound(i) .and. touch(i) >= task%least_touch)) cycle
        used = used + 1
        if (task%upper_is_second) then
          block%upper(used) = near%second(i)
          block%lower(used) = near%first(i)
        else
          block%upper(used) = near%first(i)
          block%lower(used) = near%second(i)
        end if
      end do
      found%number = found%number + int(used - block%used, int64)
      block%used = used
    end associate
  end subroutine keep_batch

  ! Upper bound of the square of the distance, with the margin of the task.
  elemental real(real64) function reach_with_margin(task, s) result(bound)
    type(search_task), intent(in) :: task
    real(real64), intent(in) :: s

    bound = (sqrt(squared_reach(task%height, s)) + task%margin)**2
  end function reach_with_margin

  !> Sets a sweep to the points of a strip and of `lanes` others that may be in reach.
  pure subroutine begin_sweep(first_layer, points, strip, other, lanes, offset, distance, place)
    type(grid_layer), intent(in) :: first_layer  !! the first layer
    type(grid_layer), intent(in) :: points   !! the second layer
    integer, intent(in) :: strip             !! strip of the first layer
    integer, intent(in) :: other             !! first strip of the second layer
    integer, intent(in) :: lanes             !! number of strips from there, `most_lanes` at most
    real(real64), intent(in) :: offset(4)    !! added to x, y of the first, of the second layer
    real(real64), intent(in) :: distance     !! largest reach, length
    type(sweep_place), intent(out) :: place  !! start of the sweep
    real(real64) :: left, right
    integer :: lane, first, last

    place%lanes = lanes
    first = first_layer%first(strip)
    last = first_layer%first(strip + 1) - 1
    left = huge(left)
    right = -huge(right)
    do lane = 1, lanes
      place%start(lane) = points%first(other + lane - 1)
      place%last(lane) = points%first(other + lane) - 1
      left = min(left, points%points(place%start(lane))%x + offset(3))
      right = max(right, points%points(place%last(lane))%x + offset(3))
    end do
    place%point = first_reached(first_layer%points(1:), first, last, left, offset(1), distance)
    place%last_point = last_reaching(first_layer%points(1:), place%point, last, right, offset(1), &
                                      distance)
    if (place%point > place%last_point) return
    left = first_layer%points(place%point)%x + offset(1)
    do lane = 1, lanes
      place%start(lane) = first_reached(points%points(1:), place%start(lane), place%last(lane), &
                                        left, offset(3), distance)
    end do
    place%next = place%start(1)
  end subroutine begin_sweep

  ! Index of the first point from `from` to `to` that is less than `distance` left of `x`, or
  ! to + 1. Galloping search, as the result is near `from` mostly.
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

  ! Index of the last point from `from` to `to` that is less than `distance` right of `x`, or
  ! from - 1. Bisection.
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

  !> Collects pairs nearer than `distance` until the strip ends or the batch is full.
  !>
  !> Differences are rounded as those of the distance itself, so that rounding loses no pair. A
  !> group of points is tested without a branch, which would be mispredicted.
  pure subroutine sweep_strips(first_points, points, offset, distance, place, near)
    type(grid_point), contiguous, intent(in) :: first_points(:)  !! points of the first layer
    type(grid_point), contiguous, intent(in) :: points(:)  !! points of the second, with spare ones
    real(real64), intent(in) :: offset(4)                  !! added to x, y of both layers
    real(real64), intent(in) :: distance                   !! largest reach, length
    type(sweep_place), intent(inout) :: place              !! state of the sweep
    type(near_batch), intent(inout) :: near                !! pairs collected so far
    real(real64) :: x, y, shift_x, shift_y, across, along, squared, bound
    integer :: point, lane, start, next, last, used, inside, i

    bound = distance * distance
    shift_x = offset(3)
    shift_y = offset(4)
    lane = place%lane
    next = place%next
    used = near%used
    point = place%point
    strips: do while (point <= place%last_point)
      x = first_points(point)%x + offset(1)
      y = first_points(point)%y + offset(2)
      do
        start = place%start(lane)
        last = place%last(lane)
        do
          do i = next, next + group - 1
            across = x - (points(i)%x + shift_x)
            along = y - (points(i)%y + shift_y)
            squared = across * across + along * along
            inside = merge(1, 0, i <= last)
            near%first(used + 1) = point
            near%second(used + 1) = i
            near%squared(used + 1) = squared
            used = used + iand(inside, merge(1, 0, squared < bound))
            start = start + iand(inside, merge(1, 0, across >= distance))
          end do
          next = next + group
          if (start == next) then
            ! All points tested are too far left, also for the following ones; more may be.
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
      point = point + 1
      lane = 1
      next = place%start(1)
      if (used >= batch_size) exit strips
    end do strips
    near%used = used
    place%point = point
    place%lane = lane
    place%next = next
  end subroutine sweep_strips

  !> Adds a block when the last one has too little room.
  subroutine reserve_room(found, needed, failed)
    type(found_pairs), intent(inout) :: found  !! pairs so far
    integer, intent(in) :: needed              !! number of pairs to be added, 65536 at most
    logical, intent(out) :: failed             !! whether memory is short
    type(pair_block), allocatable :: larger(:)
    integer :: i, status

    failed = .false.
    if (found%blocks > 0) then
      if (found%block(found%blocks)%used + needed <= block_size) return
    end if
    if (.not. allocated(found%block)) allocate (found%block(64))
    if (found%blocks == size(found%block)) then
      allocate (larger(2 * found%blocks))
      do i = 1, found%blocks
        larger(i)%used = found%block(i)%used
        call move_alloc(found%block(i)%upper, larger(i)%upper)
        call move_alloc(found%block(i)%lower, larger(i)%lower)
      end do
      call move_alloc(larger, found%block)
    end if
    associate (next => found%block(found%blocks + 1))
      allocate (next%upper(block_size), stat=status)
      failed = status /= 0
      if (failed) return
      allocate (next%lower(block_size), stat=status)
    end associate
    failed = status /= 0
    if (.not. failed) found%blocks = found%blocks + 1
  end subroutine reserve_room

end module asperity_pair_search_layers
