!> The pairs of a position that may touch: of two surfaces of asperities, or of caps and a plane.
!>
!> The candidates of a search are tested again, so the pairs are those of a comparison of all with
!> all, bit for bit. Their order is different; no result depends on it.
!>
!> A plane is a body without asperities: its reference plane itself, tilted or not. Each cap meets
!> it vertically above or below its summit, with its own radius as the combined one, and the overlap
!> is the penetration. The tilt of the plane changes summit levels as it does for asperities; the
!> inclination of the contact by the tilt is neglected, an error of the order of the slope squared.
module asperity_pair_finding
  use asperity_candidate_pairs, only: largest_rise, refine_heights, set_gaps, sort_by_gap
  use asperity_contact_records, only: by_events, solve_method
  use asperity_isolated_compression, only: compression_at_load, first_at_limit
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int64, real64
  use asperity_loading_controls, only: is_limit, is_load, is_separation
  use asperity_pair_search_layers, only: found_pairs
  use asperity_pair_search_levels, only: build_levels, last_level, search_level, &
                                         surface_points
  use asperity_placed_scene, only: candidate, largest_value, placed_scene, position_pairs
  implicit none
  private

  public :: find_pairs, prepare_search

contains

  !> Prepares the search, once for all positions.
  subroutine prepare_search(placed)
    type(placed_scene), intent(inout) :: placed  !! scene in solver units
    ! Comparisons up to which all with all is as fast as a grid.
    integer(int64), parameter :: few = 10000_int64
    real(real64) :: widest

    widest = largest_value(placed%ru) + largest_value(placed%rl)
    placed%far_reach = widest * (1.0_real64 + 1.0e-6_real64)
    placed%rise = largest_value(abs(placed%hu)) + largest_value(abs(placed%hl)) + widest
    if (placed%on_plane) then
      ! One of the two has no asperity. A displacement shifts all heights equally.
      placed%level = [placed%hu, placed%hl]
      allocate (placed%order(size(placed%level)))
      call sort_keys(-placed%level, placed%order)
    else if (size(placed%xu, kind=int64) * size(placed%xl, kind=int64) > few) then
      call build_levels(placed%levels, &
                        surface_points(placed%xu, placed%yu, placed%hu, placed%ru), &
                        surface_points(placed%xl, placed%yl, placed%hl, placed%rl), &
                        placed%height_max, epsilon(widest))
    end if
  end subroutine prepare_search

  !> Finds all pairs that may touch by the end of a position, and possibly others. A candidate pair
  !> can touch before a summit reaches the other reference plane; by Appendix 5 of the thesis, for
  !> two radii: d**2 < 2 (RU + RL) * (largest height). With `all_pairs` every pair whose spheres can
  !> touch is found.
  subroutine find_pairs(placed, all_pairs, method, position, failure)
    type(placed_scene), intent(in) :: placed  !! scene in solver units
    logical, intent(in) :: all_pairs  !! every pair whose spheres can touch
    type(solve_method), intent(in) :: method  !! path, overlap formula, step
    type(position_pairs), intent(inout) :: position  !! gets its pairs
    character(len=:), allocatable, intent(out) :: failure  !! set where the end is not reached
    real(real64), parameter :: none = -huge(1.0_real64)
    real(real64) :: least_touch
    integer :: level, last

    if (placed%on_plane) then
      call find_on_plane(placed, method, position, failure)
      return
    end if
    if (.not. allocated(placed%levels%complete_from)) then
      call compare_all(placed, all_pairs, position)
      return
    end if
    last = last_level(placed%levels)
    least_touch = none
    level = last
    if (method%path == by_events) then
      if (.not. (is_load(placed%control) .and. method%past_the_end)) level = 1
      if (is_separation(placed%control)) then
        ! Pairs that touch past the end are not needed.
        least_touch = below_with_rounding(placed, placed%target) - largest_rise(placed, method)
        do while (placed%levels%complete_from(level) > least_touch)
          level = level + 1
        end do
      end if
    end if
    do
      call find_in_level(placed, level, all_pairs, least_touch, position, failure)
      if (allocated(failure)) return
      if (level == last) exit
      call raise_least_touch(placed, method, position, least_touch)
      if (position%number > 0 .and. least_touch >= placed%levels%complete_from(level)) return
      level = level + 1
    end do
    ! The first of all pairs decides whether pairs outside the candidate distance matter. It is
    ! among the pairs of the first level that is complete down to its touch.
    if (position%number > 0 .or. .not. least_touch > none) return
    do level = 1, last
      call find_in_level(placed, level, all_pairs, none, position, failure)
      if (allocated(failure)) return
      if (position%number == 0) cycle
      call set_gaps(position%found(:position%number), least_touch)
      if (least_touch >= placed%levels%complete_from(level)) return
    end do
  end subroutine find_pairs

  ! Raises the separation below which first touches are not needed, from the pairs found so far.
  subroutine raise_least_touch(placed, method, position, least_touch)
    type(placed_scene), intent(in) :: placed
    type(solve_method), intent(in) :: method
    type(position_pairs), intent(inout) :: position
    real(real64), intent(inout) :: least_touch
    real(real64) :: first_touch, compression
    logical :: is_reachable

    if (position%number == 0) return
    associate (found => position%found(:position%number))
      if (is_load(placed%control)) then
        call raise_by_load(placed, method%overlap, found, least_touch)
      else if (.not. is_separation(placed%control)) then
        ! Under limit control the compression at which the first of some pairs reaches its limit
        ! bounds that of all pairs; under compression control their first touch does. Pairs that
        ! touch only beyond this bound, and attract only beyond it, are not needed.
        call set_gaps(found, first_touch)
        compression = placed%target
        is_reachable = .not. is_limit(placed%control)
        if (.not. is_reachable) call first_at_limit(placed, found, compression, is_reachable)
        if (is_reachable) least_touch = max(least_touch, below_with_rounding( &
          placed, first_touch - compression) - largest_rise(placed, method))
      end if
    end associate
  end subroutine raise_least_touch

  ! Load control. The compression at which some pairs carry the load is an upper bound of that of
  ! all pairs; only pairs that touch before it are needed. The next pair to touch is needed as well,
  ! as the compression is bracketed between two consecutive first touches.
  subroutine raise_by_load(placed, overlap, found, least_touch)
    type(placed_scene), intent(in) :: placed
    integer, intent(in) :: overlap
    type(candidate), contiguous, intent(inout) :: found(:)
    real(real64), intent(inout) :: least_touch
    character(len=:), allocatable :: failure
    real(real64) :: first_touch, compression
    integer :: next

    call set_gaps(found, first_touch)
    call sort_by_gap(found)
    call refine_heights(found)
    call compression_at_load(placed, found, overlap, compression, failure)
    if (allocated(failure)) return
    next = findloc(found%gap > compression, .true., 1)
    if (next == 0) return
    ! The search for the compression ends where centres are level.
    if (found(next)%gap < minval(found%gap + found%zc)) &
      least_touch = max(least_touch, below_with_rounding(placed, first_touch - found(next)%gap))
  end subroutine raise_by_load

  ! A lower bound of a separation, whatever its rounding.
  pure real(real64) function below_with_rounding(placed, approach) result(below)
    type(placed_scene), intent(in) :: placed
    real(real64), intent(in) :: approach

    below = approach - 64.0_real64 * epsilon(below) * (placed%rise + abs(approach))
  end function below_with_rounding

  ! Pairs of a small scene: all are compared with all.
  subroutine compare_all(placed, all_pairs, position)
    type(placed_scene), intent(in) :: placed
    logical, intent(in) :: all_pairs
    type(position_pairs), intent(inout) :: position
    real(real64) :: x, y
    integer :: j, k

    if (.not. allocated(position%found)) allocate (position%found(256))
    position%number = 0
    do j = 1, size(placed%xu)
      x = placed%xu(j) + position%dx
      y = placed%yu(j) + position%dy
      do k = 1, size(placed%xl)
        if (abs(x - placed%xl(k)) < placed%far_reach) &
          call add_if_near(placed, j, k, x, y, all_pairs, position)
      end do
    end do
  end subroutine compare_all

  ! Pairs of a large scene, of the asperities of one level, that touch at `least_touch` or above.
  subroutine find_in_level(placed, level, all_pairs, least_touch, position, failure)
    type(placed_scene), intent(in) :: placed
    integer, intent(in) :: level
    logical, intent(in) :: all_pairs
    real(real64), intent(in) :: least_touch
    type(position_pairs), intent(inout) :: position
    character(len=:), allocatable, intent(inout) :: failure
    type(found_pairs) :: near
    integer :: i, k, status
    logical :: failed

    position%number = 0
    call search_level(placed%levels, level, position%dx, position%dy, &
                      all_pairs, least_touch, near, failed)
    failed = failed .or. near%number >= int(huge(position%number), int64)
    if (allocated(position%found) .and. .not. failed) then
      if (size(position%found, kind=int64) < near%number) deallocate (position%found)
    end if
    if (.not. allocated(position%found) .and. .not. failed) then
      allocate (position%found(max(int(near%number), 256)), stat=status)
      failed = status /= 0
    end if
    if (failed) then
      failure = 'not enough memory for the pairs of a position'
      return
    end if
    do k = 1, near%blocks
      associate (block => near%block(k))
        do i = 1, block%used
          call add_if_near(placed, int(block%upper(i)), int(block%lower(i)), &
                           placed%xu(block%upper(i)) + position%dx, &
                           placed%yu(block%upper(i)) + position%dy, all_pairs, position)
        end do
      end associate
    end do
  end subroutine find_in_level

  ! Adds a pair that is near enough, the upper asperity being at (x, y).
  subroutine add_if_near(placed, j, k, x, y, all_pairs, position)
    type(placed_scene), intent(in) :: placed
    integer, intent(in) :: j, k
    real(real64), intent(in) :: x, y
    logical, intent(in) :: all_pairs
    type(position_pairs), intent(inout) :: position
    real(real64) :: across, along, s, d2, d
    integer :: status

    across = x - placed%xl(k)
    s = placed%ru(j) + placed%rl(k)
    ! Distant pairs end here, before a square can overflow.
    if (across >= s .or. across <= -s) return
    along = y - placed%yl(k)
    if (along >= s .or. along <= -s) return
    d2 = across * across + along * along
    if (.not. all_pairs .and. d2 >= (s + s) * placed%height_max) return
    d = sqrt(d2)
    if (d >= s) return
    if (position%number == size(position%found)) &
      call make_room(position, 2 * position%number, status)
    position%number = position%number + 1
    associate (pair => position%found(position%number))
      pair%upper = j
      pair%lower = k
      pair%d = d
      pair%s = s
      pair%zc = sqrt((s - d) * (s + d))
      pair%radius = placed%ru(j) * placed%rl(k) / s
      ! Sum of the summit levels less s - zc = d**2/(s + zc), by the offset in plan.
      pair%touch = (placed%hu(j) + placed%hl(k)) - d2 / (s + pair%zc)
    end associate
  end subroutine add_if_near

  ! Finds all caps that may touch by the end of a position, and possibly others: the highest first,
  ! until the next one touches past the end.
  subroutine find_on_plane(placed, method, position, failure)
    type(placed_scene), intent(in) :: placed
    type(solve_method), intent(in) :: method
    type(position_pairs), intent(inout) :: position
    character(len=:), allocatable, intent(out) :: failure
    ! Number of caps at first, and the factor by which it grows.
    integer, parameter :: fewest = 512, growth = 8
    real(real64) :: shift, least_touch
    integer :: caps, last, status

    caps = size(placed%order)
    shift = placed%plane_slope(1) * position%dx + placed%plane_slope(2) * position%dy
    least_touch = -huge(least_touch)
    last = caps
    if (method%path == by_events) then
      if (is_separation(placed%control)) then
        least_touch = below_with_rounding(placed, placed%target) - largest_rise(placed, method)
      else if (.not. (is_load(placed%control) .and. method%past_the_end)) then
        last = min(caps, fewest)
      end if
    end if
    position%number = 0
    do
      call make_room(position, max(last, 1), status)
      if (status /= 0) then
        failure = 'not enough memory for the pairs of a position'
        return
      end if
      do while (position%number < last)
        if (placed%level(placed%order(position%number + 1)) + shift < least_touch .and. &
            .not. (method%keeps_first .and. position%number == 0)) return
        position%number = position%number + 1
        call set_on_plane(placed, int(placed%order(position%number)), shift, &
                          position%found(position%number))
      end do
      if (last == caps) return
      call raise_least_touch(placed, method, position, least_touch)
      last = merge(caps, growth * min(last, caps / growth), last > caps / growth)
    end do
  end subroutine find_on_plane

  ! Allocates room for more candidates and keeps those found.
  subroutine make_room(position, wanted, status)
    type(position_pairs), intent(inout) :: position
    integer, intent(in) :: wanted
    integer, intent(out) :: status
    type(candidate), allocatable :: larger(:)

    status = 0
    if (allocated(position%found)) then
      if (size(position%found) >= wanted) return
    end if
    allocate (larger(wanted), stat=status)
    if (status /= 0) return
    if (position%number > 0) larger(:position%number) = position%found(:position%number)
    call move_alloc(larger, position%found)
  end subroutine make_room

  ! Sets the pair of a cap and the plane, which is asperity 0 of its surface. Centres are never
  ! level: that of a plane is out of reach of any compression, and no result depends on its height.
  subroutine set_on_plane(placed, i, shift, pair)
    type(placed_scene), intent(in) :: placed
    integer, intent(in) :: i
    real(real64), intent(in) :: shift
    type(candidate), intent(out) :: pair

    if (size(placed%hu) > 0) then
      pair%upper = i
      pair%lower = 0
      pair%radius = placed%ru(i)
    else
      pair%upper = 0
      pair%lower = i
      pair%radius = placed%rl(i)
    end if
    pair%d = 0.0_real64
    pair%s = placed%out_of_reach
    pair%zc = pair%s
    pair%rest = 0.0_real64
    pair%touch = placed%level(i) + shift
    pair%gap = 0.0_real64
  end subroutine set_on_plane

end module asperity_pair_finding
