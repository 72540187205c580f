!> The near pairs of two sorted surfaces, by a sweep along strips.
!>
!> Each layer of one surface is searched with each layer of the other: every strip against the
!> strips in reach, both from left to right in the order of x. The cost is proportional to the
!> number of asperities and of the pairs found, whatever their positions.
module asperity_pair_search_layers
  use asperity_cell_grid, only: cell_grid, grid_layer, grid_point
  use asperity_cell_reach, only: squared_reach
  use asperity_kinds, only: real64
  use asperity_pair_search_blocks, only: add_pair, found_pairs
  implicit none
  private

  public :: search_pairs

  ! Criteria of one search.
  type :: search_task
    real(real64) :: height = 0.0_real64               ! of `squared_reach`
    real(real64) :: offset(4) = 0.0_real64            ! added to x, y of first and second layer
    real(real64) :: margin = 0.0_real64               ! bound of the rounding of a distance
    real(real64) :: least_touch = -huge(1.0_real64)   ! compression of first contact at least
    real(real64) :: distance = 0.0_real64             ! largest reach of the two layers
    logical :: upper_is_second = .false.              ! the first layer is of the lower surface
  end type search_task

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
  subroutine sweep_layers(layer, other, task, found, failed)
    type(grid_layer), intent(in) :: layer, other
    type(search_task), intent(in) :: task
    type(found_pairs), intent(inout) :: found
    logical, intent(out) :: failed
    integer :: begin, k, strip

    failed = .false.
    begin = 1
    do strip = 1, size(layer%low)
      associate (low => layer%low(strip) + task%offset(2), &
                 high => layer%high(strip) + task%offset(2))
        do while (begin <= size(other%low))
          if (low - (other%high(begin) + task%offset(4)) < task%distance) exit
          begin = begin + 1
        end do
        do k = begin, size(other%low)
          if ((other%low(k) + task%offset(4)) - high >= task%distance) exit
          call sweep_strips(layer%points(layer%first(strip):layer%first(strip + 1) - 1), &
                            other%points(other%first(k):other%first(k + 1) - 1), task, found, &
                            failed)
          if (failed) return
        end do
      end associate
    end do
  end subroutine sweep_layers

  ! Keeps the pairs of two strips that are within reach and whose touch is large enough. Differences
  ! are rounded as those of the distance itself, so that rounding loses no pair.
  subroutine sweep_strips(points, others, task, found, failed)
    type(grid_point), contiguous, intent(in) :: points(:), others(:)
    type(search_task), intent(in) :: task
    type(found_pairs), intent(inout) :: found
    logical, intent(out) :: failed
    real(real64) :: across, bound, d, s, squared, touch, x, y
    integer :: first, i, k, start

    failed = .false.
    bound = task%distance**2
    ! The first points that the other strip reaches.
    first = first_reached(points, others(1)%x + task%offset(3), task%offset(1), task%distance)
    if (first > size(points)) return
    start = first_reached(others, points(first)%x + task%offset(1), task%offset(3), task%distance)
    do i = first, size(points)
      x = points(i)%x + task%offset(1)
      y = points(i)%y + task%offset(2)
      do while (start <= size(others))
        if (x - (others(start)%x + task%offset(3)) < task%distance) exit
        start = start + 1
      end do
      if (start > size(others)) return
      do k = start, size(others)
        across = x - (others(k)%x + task%offset(3))
        if (-across >= task%distance) exit
        squared = across**2 + (y - (others(k)%y + task%offset(4)))**2
        if (squared >= bound) cycle
        s = points(i)%radius + others(k)%radius
        if (squared >= (sqrt(squared_reach(task%height, s)) + task%margin)**2) cycle
        d = min(max(sqrt(squared) - task%margin, 0.0_real64), s)
        touch = points(i)%height + others(k)%height - d * d / (s + sqrt((s - d) * (s + d)))
        if (touch < task%least_touch) cycle
        if (task%upper_is_second) then
          call add_pair(found, others(k)%asperity, points(i)%asperity, failed)
        else
          call add_pair(found, points(i)%asperity, others(k)%asperity, failed)
        end if
        if (failed) return
      end do
    end do
  end subroutine sweep_strips

  ! Index of the first point that is less than `distance` left of `x`, or one more than there are:
  ! by bisection.
  pure integer function first_reached(list, x, shift, distance) result(first)
    type(grid_point), contiguous, intent(in) :: list(:)
    real(real64), intent(in) :: x, shift, distance
    integer :: last, middle

    first = 1
    last = size(list) + 1
    do while (first < last)
      middle = (first + last) / 2
      if (x - (list(middle)%x + shift) < distance) then
        last = middle
      else
        first = middle + 1
      end if
    end do
  end function first_reached

end module asperity_pair_search_layers
