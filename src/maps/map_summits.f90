!> The summits of a height map.
!>
!> Rule `eight`: a summit is a pixel higher than all eight neighbours. A plateau counts once, at its
!> first pixel. Pixels on the rim of the map or beside a missing pixel are no summits. The models of
!> the thesis were taken from profiles in this manner (its Table I).
!>
!> Rule `contact`, for surfaces to be loaded: the edge of the map, and of missing pixels, is a
!> mirror, so that a hill cut by it has a summit. Ridges are filled with pixels of which one or two
!> neighbours are not lower, the highest first, none nearer than 2.5 pixels to a summit or to
!> another one, with the radius by neighbours. The top is the vertex of the parabolas through the
!> neighbours.
module asperity_map_summits
  use, intrinsic :: iso_c_binding, only: c_bool
  use asperity_height_map, only: height_map, index_beside, is_measured
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int32, int64, real64
  use asperity_problems, only: decimal_text
  use asperity_process, only: check_memory
  use asperity_summit_spheres, only: find_top, heights_around, mean_curvature, radius_geometric, &
                                     radius_neighbours
  implicit none
  private

  public :: map_summits, find_summits, rule_names, rule_eight, rule_contact, usual_radius

  integer, parameter :: rule_eight = 1, rule_contact = 2  !! rules for summits
  !> Names of the rules for summits in input.
  character(len=*), parameter :: rule_names(2) = [character(len=7) :: 'eight', 'contact']
  !> Default rule for radii of each rule for summits.
  integer, parameter :: usual_radius(2) = [radius_neighbours, radius_geometric]

  !> Summits, from profile to profile, those of ridges behind the others. Lengths as in the map.
  type :: map_summits
    !> Along a profile from its first pixel, and from the first profile; on a periodic map from 0 to
    !> below its length.
    real(real64), allocatable :: x(:), y(:)
    real(real64), allocatable :: height(:)    !! above the plane of the map
    real(real64), allocatable :: radius(:)    !! more than 0
    integer :: on_ridges = 0                  !! number of the last ones, which fill ridges
    integer(int64) :: possible = 0_int64      !! pixels that can be summits: none too near to the
                                              !! edge or to a missing pixel
  end type map_summits

  ! Places of pixels, counted row by row from 1.
  type :: place_list
    integer(int64), allocatable :: place(:)
    integer(int64) :: number = 0_int64
  end type place_list

  ! Least squared distance of two spheres on a ridge [pixels**2]. Limit of the radius of a sphere on
  ! a ridge, and of the curvature of the parabola of a top, as a multiple of the summits' median.
  real(real64), parameter :: least_squared_distance = 2.5_real64**2, most_radius = 4.0_real64
  integer, parameter :: reach = 2
  ! A curvature below this part of that by neighbours is rounding: the latter is used instead.
  real(real64), parameter :: rounding = 1.0e-9_real64
  ! Lower limit of curvatures: lengths from 1e-30 to 1e30 have none below it, except by rounding.
  real(real64), parameter :: no_curvature = 1.0e-90_real64

contains

  !> Finds the summits of a levelled map. `failure` is allocated when there is no memory for it.
  subroutine find_summits(map, rule, radius_rule, summits, failure)
    type(height_map), intent(in) :: map                     !! levelled, 3 x 3 pixels at least
    integer, intent(in) :: rule                             !! `rule_eight` or `rule_contact`
    integer, intent(in) :: radius_rule  !! rule for radii of `asperity_summit_spheres`
    type(map_summits), intent(out) :: summits               !! summits, those on ridges last
    character(len=:), allocatable, intent(out) :: failure   !! reason, when memory is short
    type(place_list) :: places
    integer(int64) :: plain

    call find_places(map, rule, places, summits%possible, failure)
    if (allocated(failure)) return
    plain = places%number
    if (rule == rule_contact) call fill_ridges(map, places, failure)
    if (allocated(failure)) return
    call make_spheres(map, rule, radius_rule, places, plain, summits, failure)
  end subroutine find_summits

  ! Finds the pixels that are not lower than any neighbour.
  subroutine find_places(map, rule, places, possible, failure)
    type(height_map), intent(in) :: map
    integer, intent(in) :: rule
    type(place_list), intent(inout) :: places
    integer(int64), intent(out) :: possible
    character(len=:), allocatable, intent(out) :: failure
    logical(c_bool), allocatable :: seen(:, :)
    real(real64) :: near(-1:1, -1:1)
    integer :: i, j
    logical :: inner, good

    possible = 0_int64
    do j = 1, map%rows
      do i = 1, map%columns
        if (.not. is_measured(map%height(i, j))) cycle
        inner = .true.
        if (rule == rule_eight) inner = is_inner(map, i, j)
        if (inner) possible = possible + 1_int64
        ! One of two neighbours is higher: it excludes most pixels.
        if (max(map%height(max(1, i - 1), j), map%height(min(map%columns, i + 1), j)) > &
            map%height(i, j)) cycle
        near = heights_around(map, i, j)
        if (any(near > near(0, 0))) cycle
        good = inner
        if (count(near >= near(0, 0)) > 1) call visit_plateau(map, rule, i, j, seen, good, failure)
        if (good) call add_place(map, i, j, places, failure)
        if (allocated(failure)) return
      end do
    end do
  end subroutine find_places

  ! Columns and rows of the pixels beside one: eight, fewer at the edge of a free map.
  pure subroutine list_neighbours(map, i, j, columns, rows, number)
    type(height_map), intent(in) :: map
    integer, intent(in) :: i, j
    integer, intent(out) :: columns(8), rows(8), number
    integer :: k, m, place(2)
    logical :: inside

    inside = i > 1 .and. i < map%columns .and. j > 1 .and. j < map%rows
    number = 0
    do m = -1, 1
      do k = -1, 1
        if (k == 0 .and. m == 0) cycle
        place = [i + k, j + m]
        if (.not. inside) place = index_beside(place, [map%columns, map%rows], map%periodic)
        if (min(place(1), place(2)) == 0) cycle
        number = number + 1
        columns(number) = place(1)
        rows(number) = place(2)
      end do
    end do
  end subroutine list_neighbours

  ! Whether all eight neighbours are measured.
  pure logical function is_inner(map, i, j)
    type(height_map), intent(in) :: map
    integer, intent(in) :: i, j
    integer :: columns(8), rows(8), k, number

    call list_neighbours(map, i, j, columns, rows, number)
    is_inner = number == 8
    do k = 1, number
      is_inner = is_inner .and. is_measured(map%height(columns(k), rows(k)))
    end do
  end function is_inner

  ! Visits the plateau of a pixel, once. It is a summit when no pixel beside it is higher and, by
  ! rule eight, all its pixels are inner.
  subroutine visit_plateau(map, rule, column, row, seen, is_summit, failure)
    type(height_map), intent(in) :: map
    integer, intent(in) :: rule, column, row
    logical(c_bool), allocatable, intent(inout) :: seen(:, :)
    logical, intent(out) :: is_summit
    character(len=:), allocatable, intent(out) :: failure
    type(place_list) :: pending
    real(real64) :: near(-1:1, -1:1)
    integer :: columns(8), rows(8), i, j, k, number, status

    is_summit = .false.
    if (.not. allocated(seen)) then
      allocate (seen(map%columns, map%rows), stat=status)
      call check_memory('the plateaus of the map', failure, status)
      if (allocated(failure)) return
      seen(:, :) = .false._c_bool
    end if
    if (seen(column, row)) return
    is_summit = .true.
    seen(column, row) = .true._c_bool
    call add_place(map, column, row, pending, failure)
    do while (pending%number > 0_int64 .and. .not. allocated(failure))
      call place_of(map, pending%place(pending%number), i, j)
      pending%number = pending%number - 1_int64
      near = heights_around(map, i, j)
      if (any(near > near(0, 0))) is_summit = .false.
      if (rule == rule_eight) is_summit = is_summit .and. is_inner(map, i, j)
      call list_neighbours(map, i, j, columns, rows, number)
      do k = 1, number
        if (seen(columns(k), rows(k))) cycle
        if (abs(map%height(columns(k), rows(k)) - map%height(i, j)) > 0.0_real64) cycle
        seen(columns(k), rows(k)) = .true._c_bool
        call add_place(map, columns(k), rows(k), pending, failure)
        if (allocated(failure)) return
      end do
    end do
  end subroutine visit_plateau

  ! Adds pixels of ridges to the summits.
  subroutine fill_ridges(map, places, failure)
    type(height_map), intent(in) :: map
    type(place_list), intent(inout) :: places
    character(len=:), allocatable, intent(out) :: failure
    type(place_list) :: ridges
    logical(c_bool), allocatable :: taken(:, :)
    real(real64), allocatable :: depth(:)
    integer(int32), allocatable :: order(:)
    real(real64) :: near(-1:1, -1:1)
    integer(int64) :: k
    integer :: i, j, number

    do j = 1, map%rows
      do i = 1, map%columns
        if (.not. is_measured(map%height(i, j))) cycle
        near = heights_around(map, i, j)
        ! The pixel itself, and the ridge on one side or, in a saddle, on both.
        number = count(near >= near(0, 0))
        if (number == 2 .or. number == 3) call add_place(map, i, j, ridges, failure)
        if (allocated(failure)) return
      end do
    end do
    if (ridges%number == 0_int64) return
    call check_number(ridges, failure)
    if (allocated(failure)) return
    ! The sort takes 16 bytes for each beside these.
    call check_memory('the ridges of the map', failure, bytes=44_int64 * ridges%number + &
                      int(map%columns, int64) * map%rows)
    if (allocated(failure)) return
    allocate (taken(map%columns, map%rows), depth(ridges%number), order(ridges%number))
    taken(:, :) = .false._c_bool
    do k = 1_int64, places%number
      call place_of(map, places%place(k), i, j)
      taken(i, j) = .true._c_bool
    end do
    do k = 1_int64, ridges%number
      call place_of(map, ridges%place(k), i, j)
      depth(k) = -map%height(i, j)
    end do
    call sort_keys(depth, order)
    do k = 1_int64, ridges%number
      call place_of(map, ridges%place(order(k)), i, j)
      if (has_near_summit(i, j)) cycle
      taken(i, j) = .true._c_bool
      call add_place(map, i, j, places, failure)
      if (allocated(failure)) return
    end do

  contains

    ! Whether a summit, or a pixel of a ridge, is too near.
    pure logical function has_near_summit(column, row)
      integer, intent(in) :: column, row
      integer :: k, m, other, step

      has_near_summit = .true.
      do step = -reach, reach
        m = index_beside(row + step, map%rows, map%periodic)
        if (m == 0) cycle
        do other = -reach, reach
          k = index_beside(column + other, map%columns, map%periodic)
          if (k == 0) cycle
          if (taken(k, m) .and. real(step**2 + other**2, real64) < least_squared_distance) return
        end do
      end do
      has_near_summit = .false.
    end function has_near_summit

  end subroutine fill_ridges

  ! Computes radii and tops. A summit surrounded by missing pixels has no sphere and is left out.
  subroutine make_spheres(map, rule, radius_rule, places, plain, summits, failure)
    type(height_map), intent(in) :: map
    integer, intent(in) :: rule, radius_rule
    integer(int64), intent(in) :: plain
    type(place_list), intent(inout) :: places
    type(map_summits), intent(inout) :: summits
    character(len=:), allocatable, intent(out) :: failure
    real(real64) :: near(-1:1, -1:1), step(2), rise, curvature, usual, flattest, sharpest
    integer(int64) :: k, kept
    integer :: i, j

    call check_number(places, failure)
    if (allocated(failure)) return
    call check_memory('the summits of the map', failure, bytes=56_int64 * places%number)
    if (allocated(failure)) return
    allocate (summits%x(places%number), summits%y(places%number), summits%height(places%number), &
              summits%radius(places%number))
    kept = 0_int64
    flattest = 0.0_real64
    do k = 1_int64, places%number
      if (k == plain + 1_int64 .and. kept > 0_int64) &
        flattest = 1.0_real64 / (most_radius * median_value(summits%radius(:kept)))
      call place_of(map, places%place(k), i, j)
      near = heights_around(map, i, j)
      usual = mean_curvature(near, map%pixel_spacing, radius_neighbours)
      curvature = mean_curvature(near, map%pixel_spacing, radius_rule)
      ! A ridge may rise on one side, and has no geometric mean then.
      if (k > plain) curvature = max(flattest, usual)
      if (.not. curvature > rounding * usual) curvature = usual
      if (.not. curvature > no_curvature) cycle
      kept = kept + 1_int64
      places%place(kept) = places%place(k)
      summits%radius(kept) = 1.0_real64 / curvature
      if (k > plain) summits%on_ridges = summits%on_ridges + 1
    end do
    step = 0.0_real64
    rise = 0.0_real64
    sharpest = sqrt(huge(1.0_real64))
    if (kept > summits%on_ridges) &
      sharpest = most_radius / median_value(summits%radius(:kept - summits%on_ridges))
    do k = 1_int64, kept
      call place_of(map, places%place(k), i, j)
      if (rule == rule_contact) &
        call find_top(heights_around(map, i, j), sharpest * map%pixel_spacing**2, step, rise)
      summits%x(k) = (i - 1 + step(1)) * map%pixel_spacing(1)
      summits%y(k) = (j - 1 + step(2)) * map%pixel_spacing(2)
      if (map%periodic) then
        summits%x(k) = modulo(summits%x(k), map%columns * map%pixel_spacing(1))
        summits%y(k) = modulo(summits%y(k), map%rows * map%pixel_spacing(2))
      end if
      summits%height(k) = map%height(i, j) + rise
    end do
    if (kept == places%number) return
    summits%x = summits%x(:kept)
    summits%y = summits%y(:kept)
    summits%height = summits%height(:kept)
    summits%radius = summits%radius(:kept)
  end subroutine make_spheres

  pure real(real64) function median_value(values)
    real(real64), intent(in) :: values(:)
    integer(int32), allocatable :: order(:)
    integer :: half

    allocate (order(size(values)))
    call sort_keys(values, order)
    half = (size(values) + 1) / 2
    median_value = 0.5_real64 * (values(order(half)) + values(order(size(values) + 1 - half)))
  end function median_value

  ! Refuses more places than the numbers of 32 bits by which they are sorted.
  pure subroutine check_number(list, failure)
    type(place_list), intent(in) :: list
    character(len=:), allocatable, intent(inout) :: failure

    if (list%number > int(huge(1), int64)) &
      failure = 'summits: found more than ' // decimal_text(huge(1)) // ', expected fewer'
  end subroutine check_number

  ! Adds a pixel to a list.
  subroutine add_place(map, i, j, list, failure)
    type(height_map), intent(in) :: map
    integer, intent(in) :: i, j
    type(place_list), intent(inout) :: list
    character(len=:), allocatable, intent(out) :: failure
    integer(int64), allocatable :: larger(:)
    integer :: status

    if (.not. allocated(list%place)) allocate (list%place(1024))
    if (list%number == size(list%place, kind=int64)) then
      allocate (larger(2_int64 * list%number), stat=status)
      call check_memory('the summits of the map', failure, status)
      if (allocated(failure)) return
      larger(:list%number) = list%place
      call move_alloc(larger, list%place)
    end if
    list%number = list%number + 1_int64
    list%place(list%number) = (j - 1_int64) * map%columns + i
  end subroutine add_place

  ! Computes the column and row of a pixel.
  pure subroutine place_of(map, place, i, j)
    type(height_map), intent(in) :: map
    integer(int64), intent(in) :: place
    integer, intent(out) :: i, j

    j = int((place - 1_int64) / map%columns) + 1
    i = int(place - (j - 1_int64) * map%columns)
  end subroutine place_of

end module asperity_map_summits
