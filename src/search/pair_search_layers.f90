!> The near pairs of two sorted surfaces, by a sweep along strips.
!>
!> Each layer of one surface is searched with each layer of the other: every strip against the
!> strips in reach, both from left to right in the order of x. The cost is proportional to the
!> number of asperities and of the pairs found, whatever their positions.
!>
!> Found pairs are kept in blocks: nothing is copied when their number grows.
module asperity_pair_search_layers
  use asperity_cell_grid, only: cell_grid
  use asperity_cell_layer, only: grid_layer, spare_points, squared_reach
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

  ! Number of points tested together. A group may begin just before the last point of a layer.
  integer, parameter :: group = spare_points
  ! Number of near pairs that are collected before they are examined together.
  integer, parameter :: batch_size = 2048

  !> Pairs within the largest reach of two layers, the first and the second.
  type :: near_batch
    integer :: used = 0                              !! number of pairs; full from batch_size on
    integer(int32) :: first(batch_size + group)      !! index in the first layer
    integer(int32) :: second(batch_size + group)     !! index in the second layer
    real(real64) :: squared(batch_size + group)      !! square of their distance in plan
  end type near_batch

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
    real(real64) :: low, high
    integer :: strip, other, begin

    failed = .false.
    begin = 1
    do strip = 1, first_layer%strips
      low = first_layer%low(strip) + task%offset(2)
      high = first_layer%high(strip) + task%offset(2)
      do while (begin <= points%strips)
        if (low - (points%high(begin) + task%offset(4)) < task%distance) exit
        begin = begin + 1
      end do
      do other = begin, points%strips
        if ((points%low(other) + task%offset(4)) - high >= task%distance) exit
        call sweep_strips(first_layer, strip, points, other, task, near, found, failed)
        if (failed) return
      end do
    end do
    call keep_batch(first_layer, points, task, near, found, failed)
  end subroutine sweep_layers

  ! Finds the pairs of two strips. Differences are rounded as those of the distance itself, so that
  ! rounding loses no pair. A group of points is tested without a branch, which would be
  ! mispredicted; most pairs are left out by a bound of their touch, which needs no root.
  subroutine sweep_strips(first_layer, strip, points, other, task, near, found, failed)
    type(grid_layer), intent(in) :: first_layer, points
    integer, intent(in) :: strip, other
    type(search_task), intent(in) :: task
    type(near_batch), intent(inout) :: near
    type(found_pairs), intent(inout) :: found
    logical, intent(inout) :: failed
    real(real64) :: x, y, across, squared, bound, fall, slack, least
    integer :: i, j, start, next, last, inside

    bound = task%distance**2
    ! A touch is below the sum of the heights by d**2/(s + zc), d**2/(2 s) or more.
    fall = (1.0_real64 - 1.0e-14_real64) / (2 * (first_layer%largest + points%largest))
    slack = 2 * task%margin * task%distance
    start = points%first(other)
    last = points%first(other + 1) - 1
    do i = first_layer%first(strip), first_layer%first(strip + 1) - 1
      x = first_layer%points(i)%x + task%offset(1)
      y = first_layer%points(i)%y + task%offset(2)
      least = task%least_touch - first_layer%points(i)%height
      next = start
      do
        do j = next, next + group - 1
          across = x - (points%points(j)%x + task%offset(3))
          squared = across * across + (y - (points%points(j)%y + task%offset(4)))**2
          near%first(near%used + 1) = i
          near%second(near%used + 1) = j
          near%squared(near%used + 1) = squared
          inside = merge(1, 0, j <= last)
          start = start + iand(inside, merge(1, 0, across >= task%distance))
          near%used = near%used + iand(iand(inside, merge(1, 0, squared < bound)), merge(1, 0, &
            .not. points%points(j)%height - (squared - slack) * fall < least))
        end do
        if (near%used >= batch_size) then
          call keep_batch(first_layer, points, task, near, found, failed)
          if (failed) return
        end if
        next = next + group
        if (next > last) exit
        if ((points%points(next)%x + task%offset(3)) - x >= task%distance) exit
      end do
      if (start > last) exit
    end do
  end subroutine sweep_strips

  ! Keeps the pairs of a batch that are within reach and whose touch is large enough.
  subroutine keep_batch(first_layer, points, task, near, found, failed)
    type(grid_layer), intent(in) :: first_layer, points
    type(search_task), intent(in) :: task
    type(near_batch), intent(inout) :: near
    type(found_pairs), intent(inout) :: found
    logical, intent(out) :: failed
    real(real64), dimension(size(near%squared)) :: s, bound, touch
    real(real64) :: d
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
