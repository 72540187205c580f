!> The pairs of two surfaces in order that are near enough in plan, by a sweep along strips.
!>
!> A layer of the one surface is searched with a layer of the other: strip against the strips in
!> reach, and in these from left to right, both in the order of x. So a search costs in proportion
!> to the asperities and the pairs found, wherever they lie.
module asperity_pair_search_layers
  use asperity_cell_grid, only: cell_grid
  use asperity_cell_layer, only: grid_layer
  use asperity_cell_reach, only: squared_reach
  use asperity_kinds, only: int64, real64
  use asperity_pair_search_blocks, only: found_pairs, room_in_block
  use asperity_pair_search_sweep, only: batch_room, batch_size, begin_sweep, most_lanes, &
                                        near_batch, sweep_place, sweep_strips
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

end module asperity_pair_search_layers
