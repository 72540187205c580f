!> Two surfaces in order, level by level: few high summits first, all of them last.
!>
!> A position ends where a few of the highest pairs bear its load. Each level holds the asperities
!> whose summits lie less than a drop below the highest of their surface, so every pair that
!> touches above a known approach is in it. A position asks the least level that is enough: it
!> costs its own contacts, not the surfaces.
module asperity_pair_search_levels
  use asperity_cell_grid, only: build_grid, cell_grid, take_high_part
  use asperity_cell_reach, only: any_height, margin_of_arithmetic, squared_reach
  use asperity_kinds, only: int32, real64
  use asperity_number_span, only: number_span, span_of
  use asperity_pair_search_blocks, only: found_pairs
  use asperity_pair_search_layers, only: search_pairs
  implicit none
  private

  public :: pair_levels, surface_points
  public :: build_levels, last_level, search_level

  ! Each level has about so many times the asperities of the one before; the first so many at least.
  integer, parameter :: growth = 8, fewest = 64
  ! Fewest asperities of both for which threads are started, which takes a millisecond in a fresh
  ! process: twice the time of 20,000, a tenth less for 200,000 (measured).
  integer, parameter :: many = 100000
  ! Steps in which the drop of a level is found.
  integer, parameter :: steps = 4096
  ! A search for all pairs whose spheres can touch gets strips of its own when those of the level
  ! are lower than the reach by more than this.
  real(real64), parameter :: most_strips = 8.0_real64

  !> A surface as the search is given it: lengths in one unit near the radii.
  type :: surface_points
    real(real64), allocatable :: x(:)       !! places in plan
    real(real64), allocatable :: y(:)       !! as many
    real(real64), allocatable :: height(:)  !! summit levels, as many
    real(real64), allocatable :: radius(:)  !! as many, each more than 0
  end type surface_points

  ! The high asperities of both surfaces.
  type :: pair_level
    type(cell_grid) :: upper, lower
  end type pair_level

  !> Both surfaces at all levels.
  type :: pair_levels
    !> every pair that touches at this approach or above is of the level, by level
    real(real64), allocatable :: complete_from(:)
    type(pair_level), allocatable, private :: level(:)
    real(real64), private :: height = 0.0_real64   ! how near pairs are, see `squared_reach`
    real(real64), private :: unit = 0.0_real64     ! spacing of the arithmetic at 1
    real(real64), private :: extent = 0.0_real64   ! largest |x| + |y| + sum of radii
    real(real64), private :: tall = 0.0_real64     ! extent along y of the highest strips
    real(real64), private :: widest = 0.0_real64   ! largest sum of radii
  end type pair_levels

contains

  !> Puts two surfaces in order, once for all positions.
  subroutine build_levels(levels, upper, lower, height, unit)
    type(pair_levels), intent(out) :: levels   !! in order
    type(surface_points), intent(in) :: upper  !! the surface that is displaced
    type(surface_points), intent(in) :: lower  !! the other surface
    real(real64), intent(in) :: height         !! how near pairs are, see `squared_reach`
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
    levels%widest = sum(radii%largest)
    levels%tall = sqrt(squared_reach(height, levels%widest))
    levels%extent = extent_of(upper) + extent_of(lower) + levels%widest
    top = above%largest + below%largest
    call choose_drops(upper, lower, above, below, drops)
    n = size(drops)
    allocate (levels%level(n + 1), levels%complete_from(n + 1))
    levels%complete_from(n + 1) = -huge(top)
    levels%complete_from(:n) = top - drops
    ! Every level is part of the next. A thread orders each surface.
    !$omp parallel sections private(k) if(size(upper%x) + size(lower%x) > many)
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

  !> The level that holds all asperities.
  pure integer function last_level(levels)
    type(pair_levels), intent(in) :: levels  !! built

    last_level = size(levels%complete_from)
  end function last_level

  !> Finds the pairs of a level that the arithmetic may count as near enough and as touching above
  !> the floor, and few others, in no order that means anything, but the same in every run.
  subroutine search_level(levels, k, dx, dy, all_pairs, floor, found, failed)
    type(pair_levels), intent(in) :: levels  !! built
    integer, intent(in) :: k                 !! level, from 1
    real(real64), intent(in) :: dx           !! displacement of the upper surface
    real(real64), intent(in) :: dy           !! displacement of the upper surface
    logical, intent(in) :: all_pairs         !! every pair whose spheres can touch
    real(real64), intent(in) :: floor        !! least touch, less what rounding may add to one
    type(found_pairs), intent(out) :: found  !! with the indices of the surfaces
    logical, intent(out) :: failed           !! there is no memory for all pairs
    type(cell_grid) :: upper, lower
    real(real64) :: height, margin

    margin = margin_of_arithmetic(levels%unit, levels%extent + abs(dx) + abs(dy))
    height = levels%height
    if (all_pairs) height = any_height
    associate (level => levels%level(k))
      if (all_pairs .and. levels%widest > most_strips * levels%tall) then
        call build_again(level%upper, upper)
        call build_again(level%lower, lower)
        call search_pairs(upper, lower, dx, dy, height, margin, floor, found, failed)
      else
        call search_pairs(level%upper, level%lower, dx, dy, height, margin, floor, found, failed)
      end if
    end associate
  end subroutine search_level

  ! Drops below the highest summits that leave some of the asperities, then `growth` times as many,
  ! and so on. Drops that leave no fewer than half are none: equal heights have no levels.
  subroutine choose_drops(upper, lower, above, below, drops)
    type(surface_points), intent(in) :: upper, lower
    type(number_span), intent(in) :: above, below
    real(real64), allocatable, intent(out) :: drops(:)
    real(real64) :: deepest, scale
    integer, allocatable :: counts(:)
    integer :: all_of_them, counted, k, wanted, used

    all_of_them = size(upper%x) + size(lower%x)
    deepest = max(above%largest - above%least, below%largest - below%least)
    allocate (drops(0))
    if (.not. deepest > tiny(deepest) * steps) return
    scale = real(steps, real64) / deepest
    allocate (counts(0:steps))
    counts(:) = 0
    call count_drops(upper%height, above%largest, scale, counts)
    call count_drops(lower%height, below%largest, scale, counts)
    wanted = all_of_them
    do while (wanted / growth >= fewest)
      wanted = wanted / growth
    end do
    counted = 0
    used = 0
    do k = 0, steps - 1
      counted = counted + counts(k)
      if (2 * counted > all_of_them) exit
      if (counted < wanted) cycle
      used = used + 1
      drops = [drops, real(k + 1, real64) / scale]
      wanted = growth * counted
    end do
  end subroutine choose_drops

  ! Counts asperities by the step of their drop.
  pure subroutine count_drops(height, top, scale, counts)
    real(real64), contiguous, intent(in) :: height(:)
    real(real64), intent(in) :: top, scale
    integer, intent(inout) :: counts(0:)
    integer :: i, step

    do i = 1, size(height)
      step = min(int((top - height(i)) * scale), steps)
      counts(step) = counts(step) + 1
    end do
  end subroutine count_drops

  ! A surface in order for all pairs whose spheres can touch.
  subroutine build_again(from, grid)
    type(cell_grid), intent(in) :: from
    type(cell_grid), intent(out) :: grid
    real(real64), allocatable :: x(:), y(:), height(:), radius(:)
    integer(int32), allocatable :: index(:)
    integer :: i, k

    allocate (x(0), y(0), height(0), radius(0), index(0))
    do k = 1, size(from%layers)
      associate (layer => from%layers(k))
        associate (points => layer%points(1:layer%first(layer%strips + 1) - 1))
          x = [x, points%x]
          y = [y, points%y]
          height = [height, points%height]
          index = [index, points%index]
          if (allocated(layer%radius)) then
            radius = [radius, layer%radius]
          else
            radius = [radius, spread(layer%largest, 1, size(points))]
          end if
        end associate
      end associate
    end do
    call build_grid(grid, x, y, height, radius, any_height)
    do k = 1, size(grid%layers)
      associate (layer => grid%layers(k))
        do i = 1, layer%first(layer%strips + 1) - 1
          layer%points(i)%index = index(layer%points(i)%index)
        end do
      end associate
    end do
  end subroutine build_again

  ! The largest |x| + |y|, at least.
  pure function extent_of(surface) result(extent)
    type(surface_points), intent(in) :: surface
    real(real64) :: extent

    type(number_span) :: x, y

    x = span_of(surface%x)
    y = span_of(surface%y)
    extent = max(abs(x%least), abs(x%largest)) + max(abs(y%least), abs(y%largest))
  end function extent_of

end module asperity_pair_search_levels
