!> Two sorted surfaces in levels: the highest summits in the first, all in the last.
!>
!> A few of the highest pairs carry the load of a position. Each level holds the asperities whose
!> summits are less than a drop below the highest of their surface. So it holds every pair whose
!> separation at first contact is above a known value. A position uses the smallest sufficient
!> level: its cost is that of its contacts, not of the surfaces.
module asperity_pair_search_levels
  use asperity_cell_grid, only: build_grid, cell_grid, number_span, span_of, take_high_part
  use asperity_cell_layer, only: any_height, margin_of_arithmetic
  use asperity_kinds, only: real64
  use asperity_pair_search_layers, only: found_pairs, search_pairs
  implicit none
  private

  public :: pair_levels, surface_points, build_levels, last_level, search_level

  ! Ratio of the numbers of asperities of successive levels; least number of the first level.
  integer, parameter :: growth = 8, fewest = 64
  ! Fewest asperities of both for which threads are started, which takes a millisecond in a fresh
  ! process: twice the time of 20,000, a tenth less for 200,000 (measured).
  integer, parameter :: thread_threshold = 100000
  ! Number of steps of the histogram of drops.
  integer, parameter :: steps = 4096

  !> Input of the search, one surface: lengths in one unit near the radii.
  type :: surface_points
    real(real64), allocatable :: x(:)       !! positions along x
    real(real64), allocatable :: y(:)       !! positions along y, as many as x
    real(real64), allocatable :: height(:)  !! summit levels, as many as x
    real(real64), allocatable :: radius(:)  !! radii, as many as x, each > 0
  end type surface_points

  ! The high asperities of both surfaces.
  type :: pair_level
    type(cell_grid) :: upper, lower
  end type pair_level

  !> Both surfaces at all levels.
  type :: pair_levels
    !> separation at first contact: pairs with this or more are in the level, by level
    real(real64), allocatable :: complete_from(:)
    type(pair_level), allocatable, private :: level(:)
    real(real64), private :: height = 0.0_real64   ! of `squared_reach`
    real(real64), private :: unit = 0.0_real64     ! spacing of the arithmetic at 1
    real(real64), private :: extent = 0.0_real64   ! largest |x| + |y| + sum of radii
  end type pair_levels

contains

  !> Sorts two surfaces, once for all positions.
  subroutine build_levels(levels, upper, lower, height, unit)
    type(pair_levels), intent(out) :: levels   !! the sorted surfaces by level
    type(surface_points), intent(in) :: upper  !! the surface that is displaced
    type(surface_points), intent(in) :: lower  !! the other surface
    real(real64), intent(in) :: height         !! height of `squared_reach`
    real(real64), intent(in) :: unit           !! spacing of the arithmetic at 1
    real(real64), allocatable :: drops(:)
    type(number_span) :: above, below, radii(2)
    real(real64) :: top
    integer :: k, n

    above = span_of(upper%height)
    below = span_of(lower%height)
    radii = [span_of(upper%radius), span_of(lower%radius)]
    levels%height = height
    levels%unit = unit
    levels%extent = extent_of(upper) + extent_of(lower) + sum(radii%largest)
    top = above%largest + below%largest
    call choose_drops(upper, lower, above, below, drops)
    n = size(drops)
    allocate (levels%level(n + 1), levels%complete_from(n + 1))
    levels%complete_from(n + 1) = -huge(top)
    levels%complete_from(:n) = top - drops
    ! Every level is part of the next. Each surface is sorted by one thread.
    !$omp parallel sections private(k) if(size(upper%x) + size(lower%x) > thread_threshold)
    call build_grid(levels%level(n + 1)%upper, upper%x, upper%y, upper%height, upper%radius, height)
    do k = n, 1, -1
      call take_high_part(levels%level(k + 1)%upper, above%largest - drops(k), &
                          levels%level(k)%upper)
    end do
    !$omp section
    call build_grid(levels%level(n + 1)%lower, lower%x, lower%y, lower%height, lower%radius, height)
    do k = n, 1, -1
      call take_high_part(levels%level(k + 1)%lower, below%largest - drops(k), &
                          levels%level(k)%lower)
    end do
    !$omp end parallel sections
  end subroutine build_levels

  !> Number of the level that holds all asperities.
  pure integer function last_level(levels)
    type(pair_levels), intent(in) :: levels  !! result of build_levels

    last_level = size(levels%complete_from)
  end function last_level

  !> Finds the pairs of a level that the arithmetic may count as near and as touching at
  !> `least_touch` or above, and few others. Their order has no meaning, but is the same in every
  !> run.
  subroutine search_level(levels, k, dx, dy, all_pairs, least_touch, found, failed)
    type(pair_levels), intent(in) :: levels  !! result of build_levels
    integer, intent(in) :: k                 !! level, from 1
    real(real64), intent(in) :: dx           !! displacement of the upper surface along x
    real(real64), intent(in) :: dy           !! displacement of the upper surface along y
    logical, intent(in) :: all_pairs         !! whether to find every pair whose spheres can touch
    real(real64), intent(in) :: least_touch  !! least touch, less the bound of its rounding
    type(found_pairs), intent(out) :: found  !! pairs with their indices in the surfaces
    logical, intent(out) :: failed           !! whether memory is short
    real(real64) :: height, margin

    margin = margin_of_arithmetic(levels%unit, levels%extent + abs(dx) + abs(dy))
    height = levels%height
    if (all_pairs) height = any_height
    associate (level => levels%level(k))
      call search_pairs(level%upper, level%lower, dx, dy, height, margin, least_touch, found, &
                        failed)
    end associate
  end subroutine search_level

  ! Chooses the drops of all levels but the last: the first level has few asperities, each other one
  ! about `growth` times those of the previous one, but at most half of all. Equal heights have
  ! none.
  subroutine choose_drops(upper, lower, above, below, drops)
    type(surface_points), intent(in) :: upper, lower
    type(number_span), intent(in) :: above, below
    real(real64), allocatable, intent(out) :: drops(:)
    real(real64) :: deepest, steps_per_length
    integer, allocatable :: counts(:)
    integer :: all_of_them, counted, k, target, used

    all_of_them = size(upper%x) + size(lower%x)
    deepest = max(above%largest - above%least, below%largest - below%least)
    allocate (drops(0))
    if (.not. deepest > tiny(deepest) * steps) return
    steps_per_length = real(steps, real64) / deepest
    allocate (counts(0:steps))
    counts(:) = 0
    call count_drops(upper%height, above%largest, steps_per_length, counts)
    call count_drops(lower%height, below%largest, steps_per_length, counts)
    target = all_of_them
    do while (target / growth >= fewest)
      target = target / growth
    end do
    counted = 0
    used = 0
    do k = 0, steps - 1
      counted = counted + counts(k)
      if (2 * counted > all_of_them) exit
      if (counted < target) cycle
      used = used + 1
      drops = [drops, real(k + 1, real64) / steps_per_length]
      target = growth * counted
    end do
  end subroutine choose_drops

  ! Counts asperities by the step of their drop.
  pure subroutine count_drops(height, top, steps_per_length, counts)
    real(real64), contiguous, intent(in) :: height(:)
    real(real64), intent(in) :: top, steps_per_length
    integer, intent(inout) :: counts(0:)
    integer :: i, step

    do i = 1, size(height)
      step = min(int((top - height(i)) * steps_per_length), steps)
      counts(step) = counts(step) + 1
    end do
  end subroutine count_drops

  ! Upper bound of |x| + |y|.
  pure real(real64) function extent_of(surface) result(extent)
    type(surface_points), intent(in) :: surface
    type(number_span) :: x, y

    x = span_of(surface%x)
    y = span_of(surface%y)
    extent = max(abs(x%least), abs(x%largest)) + max(abs(y%least), abs(y%largest))
  end function extent_of

end module asperity_pair_search_levels
