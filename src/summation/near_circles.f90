!> Which circles of two sets are near each other.
!>
!> Circles are sorted into classes of reach, a factor of two each, and every class into a grid of
!> its own whose cells are as wide as two of its reaches: whoever has no larger reach finds all its
!> near ones of a class in nine cells. So the time follows the number of near pairs and circles,
!> whatever the ratio of reaches.
module asperity_near_circles
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int32, real64
  implicit none
  private

  public :: near_pairs

  ! Classes down from the largest reach; the last holds all that are smaller, to 0.
  integer, parameter :: classes = 20
  ! Columns a grid has at most: a cell's number stays exact in a double.
  real(real64), parameter :: most_columns = 2.0_real64**25

  ! The circles of a set, by class and within by cell.
  type :: class_grids
    integer :: first(classes + 1) = 1                  ! where a class begins in the next two
    integer, allocatable :: member(:)                  ! places in the set
    real(real64), allocatable :: key(:)                ! row * columns + column
    real(real64), allocatable :: x(:), y(:), reach(:)  ! of members
  end type class_grids

  ! What all grids share.
  type :: grid_frame
    real(real64) :: x, y            ! a corner
    real(real64) :: cell(classes)   ! width of a cell
    integer :: largest              ! exponent of the largest reach
  end type grid_frame

  type :: pair_list
    integer :: count = 0
    integer, allocatable :: target(:), source(:)
    integer :: status = 0
  end type pair_list

contains

  !> All pairs whose places are nearer than the sum of their reaches.
  !>
  !> Within one set a circle is not near itself, and both orders of a pair are listed.
  subroutine near_pairs(x, y, reach, x_target, y_target, reach_target, same, first, near, status)
    real(real64), contiguous, intent(in) :: x(:)             !! places of sources
    real(real64), contiguous, intent(in) :: y(:)             !! places of sources
    real(real64), contiguous, intent(in) :: reach(:)         !! of sources, none negative
    real(real64), contiguous, intent(in) :: x_target(:)      !! places of targets
    real(real64), contiguous, intent(in) :: y_target(:)      !! places of targets
    real(real64), contiguous, intent(in) :: reach_target(:)  !! of targets, none negative
    logical, intent(in) :: same                              !! targets are the sources
    integer, allocatable, intent(out) :: first(:)            !! where a target's sources begin
    integer, allocatable, intent(out) :: near(:)             !! sources, ascending for a target
    integer, intent(out) :: status                           !! 0, or memory has run out
    type(class_grids) :: sources, targets
    type(grid_frame) :: frame
    type(pair_list) :: pairs
    real(real64) :: largest, extent
    integer :: k

    allocate (first(size(x_target) + 1), near(0), stat=status)
    if (status /= 0) return
    first(:) = 1
    if (size(x) == 0 .or. size(x_target) == 0) return
    largest = max(maxval(reach), maxval(reach_target))
    if (.not. largest > 0.0_real64) return
    frame%x = min(minval(x), minval(x_target))
    frame%y = min(minval(y), minval(y_target))
    extent = max(maxval(x) - frame%x, maxval(x_target) - frame%x, maxval(y) - frame%y, &
                 maxval(y_target) - frame%y)
    frame%largest = exponent(largest)
    do k = 1, classes
      frame%cell(k) = max(scale(2.0_real64, frame%largest - k + 1), extent / (most_columns - 2))
    end do
    call lay_out(x, y, reach, frame, sources, status)
    if (status == 0 .and. .not. same) call lay_out(x_target, y_target, reach_target, frame, &
                                                   targets, status)
    if (status == 0) allocate (pairs%target(4096), pairs%source(4096), stat=status)
    if (status /= 0) return
    if (same) then
      call look(sources, sources, frame, same, .false., pairs)
      call look(sources, sources, frame, same, .true., pairs)
    else
      call look(targets, sources, frame, same, .false., pairs)
      call look(sources, targets, frame, same, .true., pairs)
    end if
    status = pairs%status
    if (status == 0) call list_by_target(pairs, size(x), first, near, status)
  end subroutine near_pairs

  pure elemental integer function class_of(reach, largest)
    real(real64), intent(in) :: reach
    integer, intent(in) :: largest

    class_of = classes
    if (reach > 0.0_real64) class_of = min(largest - exponent(reach) + 1, classes)
  end function class_of

  pure subroutine lay_out(x, y, reach, frame, grids, status)
    real(real64), contiguous, intent(in) :: x(:), y(:), reach(:)
    type(grid_frame), intent(in) :: frame
    type(class_grids), intent(out) :: grids
    integer, intent(out) :: status
    integer, allocatable :: member(:), order(:)
    real(real64), allocatable :: key(:)
    integer :: class, i, n

    n = size(x)
    allocate (grids%member(n), grids%key(n), grids%x(n), grids%y(n), grids%reach(n), member(n), &
              order(n), key(n), stat=status)
    if (status /= 0) return
    do class = 1, classes
      n = grids%first(class) - 1
      do i = 1, size(x)
        if (class_of(reach(i), frame%largest) /= class) cycle
        n = n + 1
        member(n) = i
        key(n) = aint((y(i) - frame%y) / frame%cell(class)) * most_columns &
                 + aint((x(i) - frame%x) / frame%cell(class))
      end do
      grids%first(class + 1) = n + 1
      associate (a => grids%first(class))
        if (n < a) cycle
        call sort_keys(key(a:n), order(a:n))
        order(a:n) = order(a:n) + a - 1
        grids%key(a:n) = key(order(a:n))
        grids%member(a:n) = member(order(a:n))
      end associate
    end do
    grids%x(:) = x(grids%member)
    grids%y(:) = y(grids%member)
    grids%reach(:) = reach(grids%member)
  end subroutine lay_out

  ! Circles look among those of no smaller class; in turn, larger classes see the smaller ones.
  pure subroutine look(from, into, frame, same, turned, pairs)
    type(class_grids), intent(in) :: from, into
    type(grid_frame), intent(in) :: frame
    logical, intent(in) :: same, turned
    type(pair_list), intent(inout) :: pairs
    real(real64) :: key, old_key, limit
    integer :: class, larger, row, m, k, at(-1:1)

    do class = 1, classes
      do larger = 1, merge(class - 1, class, turned)
        if (into%first(larger + 1) == into%first(larger)) cycle
        old_key = huge(key)
        do m = from%first(class), from%first(class + 1) - 1
          key = aint((from%y(m) - frame%y) / frame%cell(larger)) * most_columns &
                + aint((from%x(m) - frame%x) / frame%cell(larger)) - 1.0_real64
          do row = -1, 1
            ! Neighbours in `from` mostly share a cell.
            if (key < old_key .or. key > old_key) at(row) = &
              place_of(into%key(:into%first(larger + 1) - 1), into%first(larger), &
                       key + row * most_columns)
            do k = at(row), into%first(larger + 1) - 1
              if (into%key(k) > key + row * most_columns + 2.0_real64) exit
              limit = from%reach(m) + into%reach(k)
              if (.not. (from%x(m) - into%x(k))**2 + (from%y(m) - into%y(k))**2 &
                  < limit * limit) cycle
              if (same .and. from%member(m) == into%member(k)) cycle
              call append(pairs, from%member(m), into%member(k), turned)
              if (pairs%status /= 0) return
            end do
          end do
          old_key = key
        end do
      end do
    end do
  end subroutine look

  ! The first place from `begin` on whose key is not smaller.
  pure integer function place_of(keys, begin, key)
    real(real64), intent(in) :: keys(:), key
    integer, intent(in) :: begin
    integer :: above, middle

    place_of = begin
    above = size(keys) + 1
    do while (place_of < above)
      middle = (place_of + above) / 2
      if (keys(middle) < key) then
        place_of = middle + 1
      else
        above = middle
      end if
    end do
  end function place_of

  pure subroutine append(pairs, target, source, turned)
    type(pair_list), intent(inout) :: pairs
    integer, intent(in) :: target, source
    logical, intent(in) :: turned
    integer, allocatable :: more(:, :)

    if (pairs%count == size(pairs%target)) then
      allocate (more(2 * pairs%count, 2), stat=pairs%status)
      if (pairs%status /= 0) return
      more(:pairs%count, 1) = pairs%target
      more(:pairs%count, 2) = pairs%source
      pairs%target = more(:, 1)
      pairs%source = more(:, 2)
    end if
    pairs%count = pairs%count + 1
    pairs%target(pairs%count) = merge(source, target, turned)
    pairs%source(pairs%count) = merge(target, source, turned)
  end subroutine append

  ! Sorts by source, then, keeping that order, by target.
  pure subroutine list_by_target(pairs, sources, first, near, status)
    type(pair_list), intent(in) :: pairs
    integer, intent(in) :: sources
    integer, intent(inout) :: first(:)
    integer, allocatable, intent(out) :: near(:)
    integer, intent(out) :: status
    integer, allocatable :: order(:), next(:)
    integer :: k, i

    allocate (near(pairs%count), order(pairs%count), next(sources + 1), stat=status)
    if (status /= 0) return
    associate (n => pairs%count)
      call count_up(pairs%source(:n), next)
      do k = 1, n
        i = pairs%source(k)
        order(next(i)) = k
        next(i) = next(i) + 1
      end do
      call count_up(pairs%target(:n), first)
      next = first
      do k = 1, n
        i = pairs%target(order(k))
        near(next(i)) = pairs%source(order(k))
        next(i) = next(i) + 1
      end do
    end associate
  end subroutine list_by_target

  ! Where each value begins when all are in order.
  pure subroutine count_up(value, begin)
    integer, intent(in) :: value(:)
    integer, intent(out) :: begin(:)
    integer :: k

    begin(:) = 0
    do k = 1, size(value)
      begin(value(k) + 1) = begin(value(k) + 1) + 1
    end do
    begin(1) = 1
    do k = 2, size(begin)
      begin(k) = begin(k) + begin(k - 1)
    end do
  end subroutine count_up

end module asperity_near_circles
