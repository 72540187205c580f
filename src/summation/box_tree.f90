!> A tree of square boxes over sources and targets, and which boxes act on which as a whole.
!>
!> A box is split as long as it and a neighbour hold so many places that smaller boxes cost less.
!> Two boxes of a level that do not touch act by their expansions, or place by place when they hold
!> few. A circle goes into no box narrower than twice its reach: boxes that do not touch never hold
!> near circles, and expansions stay smooth over every circle (Greengard, Rokhlin, J. Comput. Phys.
!> 73, 325, 1987; the choice pair by pair is ours).
module asperity_box_tree
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int64, real64
  implicit none
  private

  public :: box_level, box_tree, plant_boxes

  ! Levels below the root: a key and a level stay exact in a double.
  integer, parameter :: deepest = 24
  !> Places of one box times places of another that cost as much as one translation.
  real(real64), parameter :: direct_pairs = 100.0_real64
  ! A pair of boxes that touch is split above this many pairs of places: 27 translations a box
  ! against 9 * 3/4 of the direct sums saved.
  real(real64), parameter :: pairs_to_split = 4 * direct_pairs * 4

  !> The boxes of one width, in Morton's order.
  type :: box_level
    !> number of boxes
    integer :: boxes = 0
    !> half of a box's width
    real(real64) :: half = 0.0_real64
    !> column and row of a box
    integer, allocatable :: cell(:, :)
    !> place of the box around it in the level above
    integer, allocatable :: parent(:)
    !> where the children of a box begin in the level below
    integer, allocatable :: child(:)
    !> first place in order, last of those that are in no child, last of all
    integer, allocatable :: source(:, :)
    !> the same of targets
    integer, allocatable :: target(:, :)
    !> box that acts by its expansion from each of 49 shifts, or 0
    integer, allocatable :: partner(:, :)
    !> where in `near` the boxes begin that act on a box place by place
    integer, allocatable :: first(:)
    !> these boxes; negative: only what is in none of their children
    integer, allocatable :: near(:)
  end type box_level

  !> All levels.
  type :: box_tree
    !> corner of the root
    real(real64) :: x = 0.0_real64, y = 0.0_real64
    !> least level
    integer :: last = 0
    !> least level with expansions that act; above `last` when there is none
    integer :: top = 0
    !> levels
    type(box_level), allocatable :: level(:)
    !> places of sources and targets in order
    integer, allocatable :: source_order(:), target_order(:)
  end type box_tree

  ! Places in the order of the boxes.
  type :: ordered_places
    integer, allocatable :: order(:)       ! places as they were given
    integer, allocatable :: cell(:, :)     ! column and row at the deepest level
    integer, allocatable :: stop_level(:)  ! least box the circle goes into
  end type ordered_places

  ! Boxes that touch each box and were split.
  type :: adjacency
    integer, allocatable :: first(:), box(:)
  end type adjacency

contains

  !> Sorts places into boxes and finds which boxes act on which.
  subroutine plant_boxes(x, y, reach, x_target, y_target, reach_target, same, tree, status)
    real(real64), contiguous, intent(in) :: x(:)             !! places of sources
    real(real64), contiguous, intent(in) :: y(:)             !! places of sources
    real(real64), contiguous, intent(in) :: reach(:)         !! of sources, none negative
    real(real64), contiguous, intent(in) :: x_target(:)      !! places of targets
    real(real64), contiguous, intent(in) :: y_target(:)      !! places of targets
    real(real64), contiguous, intent(in) :: reach_target(:)  !! of targets, none negative
    logical, intent(in) :: same                              !! targets are the sources
    type(box_tree), intent(out) :: tree                      !! the boxes; empty without pairs
    integer, intent(out) :: status                           !! 0, or memory has run out
    type(ordered_places) :: sources, targets
    type(adjacency) :: old, new
    logical, allocatable :: split(:)
    real(real64) :: width
    integer :: l

    allocate (tree%level(0:deepest), stat=status)
    tree%top = deepest + 1
    if (size(x) == 0 .or. size(x_target) == 0 .or. status /= 0) return
    tree%x = min(minval(x), minval(x_target))
    tree%y = min(minval(y), minval(y_target))
    ! A little more, so that the last place is inside.
    width = 1.0001_real64 * max(maxval(x) - tree%x, maxval(x_target) - tree%x, &
                                maxval(y) - tree%y, maxval(y_target) - tree%y)
    if (.not. width > 0.0_real64) width = 1.0_real64
    call order_places(x, y, reach, tree, width, sources, status)
    if (status /= 0) return
    if (same) then
      targets = sources
    else
      call order_places(x_target, y_target, reach_target, tree, width, targets, status)
      if (status /= 0) return
    end if
    call make_level(tree%level(0), 1, status)
    if (status /= 0) return
    tree%level(0)%parent = 1
    tree%level(0)%cell = 0
    tree%level(0)%source(:, 1) = [1, size(x), size(x)]
    tree%level(0)%target(:, 1) = [1, size(x_target), size(x_target)]
    old%first = [1, 2]
    old%box = [1]
    do l = 0, deepest
      tree%last = l
      associate (this => tree%level(l), above => tree%level(max(l - 1, 0)))
        this%half = scale(0.5_real64 * width, -l)
        allocate (split(this%boxes), this%partner(-24:24, this%boxes), stat=status)
        if (status /= 0) return
        call meet(this, above%child, l == 0, old, new, split, status)
        if (status /= 0) return
        if (tree%top > deepest .and. any(this%partner > 0)) tree%top = l
        if (l == deepest) exit
        call divide(this, tree%level(l + 1), l, split, sources, targets, status)
        if (status /= 0) return
        if (tree%level(l + 1)%boxes == 0) exit
      end associate
      call move_alloc(new%first, old%first)
      call move_alloc(new%box, old%box)
      deallocate (split)
    end do
    call move_alloc(sources%order, tree%source_order)
    call move_alloc(targets%order, tree%target_order)
  end subroutine plant_boxes

  ! Sorts by Morton's key; a circle that stops at a level comes first in its box.
  subroutine order_places(x, y, reach, tree, width, places, status)
    real(real64), contiguous, intent(in) :: x(:), y(:), reach(:)
    type(box_tree), intent(in) :: tree
    real(real64), intent(in) :: width
    type(ordered_places), intent(out) :: places
    integer, intent(out) :: status
    real(real64), allocatable :: key(:)
    integer, allocatable :: cell(:, :), stop_level(:)
    integer :: i, n

    n = size(x)
    allocate (key(n), cell(2, n), stop_level(n), places%order(n), places%cell(2, n), &
              places%stop_level(n), stat=status)
    if (status /= 0) return
    !$omp parallel do schedule(static)
    do i = 1, n
      stop_level(i) = deepest
      if (reach(i) > 0.0_real64) stop_level(i) = max(0, min(deepest, &
                                               exponent(width / (2.0_real64 * reach(i))) - 1))
      cell(:, i) = int(scale([x(i) - tree%x, y(i) - tree%y] / width, deepest))
      cell(:, i) = ishft(ishft(cell(:, i), stop_level(i) - deepest), deepest - stop_level(i))
      key(i) = real(32_int64 * (spread_bits(cell(1, i)) + 2_int64 * spread_bits(cell(2, i))) &
                    + stop_level(i), real64)
    end do
    !$omp end parallel do
    call sort_keys(key, places%order)
    do i = 1, n
      places%cell(:, i) = cell(:, places%order(i))
      places%stop_level(i) = stop_level(places%order(i))
    end do
  end subroutine order_places

  ! Every bit of a number to the even places.
  pure integer(int64) function spread_bits(number)
    integer, intent(in) :: number
    integer :: bit

    spread_bits = 0_int64
    do bit = 0, deepest - 1
      if (btest(number, bit)) spread_bits = ibset(spread_bits, 2 * bit)
    end do
  end function spread_bits

  pure subroutine make_level(level, boxes, status)
    type(box_level), intent(inout) :: level
    integer, intent(in) :: boxes
    integer, intent(out) :: status

    level%boxes = boxes
    allocate (level%cell(2, boxes), level%parent(boxes), level%child(boxes + 1), &
              level%source(3, boxes), level%target(3, boxes), level%first(boxes + 1), stat=status)
    if (status == 0) level%child = 1
  end subroutine make_level

  ! Settles, for every box, how the boxes around it act, and finds which must be split.
  pure subroutine meet(this, child, root, old, new, split, status)
    type(box_level), intent(inout) :: this   ! its `first`, `near` and `partner` are set
    integer, intent(in) :: child(:)          ! of the level above
    logical, intent(in) :: root
    type(adjacency), intent(in) :: old       ! boxes above that touch and were split
    type(adjacency), intent(out) :: new      ! the same of this level
    logical, intent(out) :: split(:)
    integer, intent(out) :: status
    integer :: a, b, k, shift(2), nears, touching, about(2)
    real(real64) :: pairs

    allocate (this%near(64), new%first(this%boxes + 1), new%box(64), stat=status)
    if (status /= 0) return
    this%partner = 0
    split(:) = .false.
    nears = 0
    touching = 0
    do a = 1, this%boxes
      this%first(a) = nears + 1
      new%first(a) = touching + 1
      if (this%target(3, a) < this%target(1, a)) cycle
      do k = old%first(this%parent(a)), old%first(this%parent(a) + 1) - 1
        about = [1, 1]
        if (.not. root) about = [child(old%box(k)), child(old%box(k) + 1) - 1]
        do b = about(1), about(2)
          pairs = real(this%target(3, a) - this%target(1, a) + 1, real64) &
                  * real(this%source(3, b) - this%source(1, b) + 1, real64)
          if (.not. pairs > 0.0_real64) cycle
          shift = this%cell(:, b) - this%cell(:, a)
          if (maxval(abs(shift)) > 1) then
            if (pairs > direct_pairs) then
              this%partner(7 * shift(2) + shift(1), a) = b
            else
              call append(this%near, nears, b, status)
            end if
          else if (pairs > pairs_to_split) then
            split([a, b]) = .true.
            call append(this%near, nears, -b, status)
            if (status == 0) call append(new%box, touching, b, status)
          else
            call append(this%near, nears, b, status)
          end if
          if (status /= 0) return
        end do
      end do
    end do
    this%first(this%boxes + 1) = nears + 1
    new%first(this%boxes + 1) = touching + 1
    this%near = this%near(:nears)
  end subroutine meet

  pure subroutine append(list, count, value, status)
    integer, allocatable, intent(inout) :: list(:)
    integer, intent(inout) :: count
    integer, intent(in) :: value
    integer, intent(out) :: status
    integer, allocatable :: longer(:)

    status = 0
    if (count == size(list)) then
      allocate (longer(2 * count), stat=status)
      if (status /= 0) return
      longer(:count) = list
      call move_alloc(longer, list)
    end if
    count = count + 1
    list(count) = value
  end subroutine append

  ! Makes the boxes of the next level from those that are to be split.
  pure subroutine divide(this, next, depth, split, sources, targets, status)
    type(box_level), intent(inout) :: this   ! its `child`, `source` and `target` are completed
    type(box_level), intent(inout) :: next
    integer, intent(in) :: depth
    logical, intent(in) :: split(:)
    type(ordered_places), intent(in) :: sources, targets
    integer, intent(out) :: status
    integer :: a, n, quarter, source(3), target(3)
    logical :: counting
    integer :: pass

    do pass = 1, 2
      counting = pass == 1
      n = 0
      do a = 1, this%boxes
        this%child(a) = n + 1
        if (.not. split(a)) cycle
        this%source(2, a) = last_in(sources, this%source(:, a), depth, -1)
        this%target(2, a) = last_in(targets, this%target(:, a), depth, -1)
        source = this%source([1, 2, 2], a)
        target = this%target([1, 2, 2], a)
        do quarter = 0, 3
          source = [source(3) + 1, 0, this%source(3, a)]
          target = [target(3) + 1, 0, this%target(3, a)]
          source(3) = last_in(sources, source, depth, quarter)
          target(3) = last_in(targets, target, depth, quarter)
          if (source(3) < source(1) .and. target(3) < target(1)) cycle
          n = n + 1
          if (counting) cycle
          next%parent(n) = a
          next%cell(:, n) = 2 * this%cell(:, a) + [mod(quarter, 2), quarter / 2]
          next%source(:, n) = source([1, 3, 3])
          next%target(:, n) = target([1, 3, 3])
        end do
      end do
      this%child(this%boxes + 1) = n + 1
      status = 0
      if (counting) call make_level(next, n, status)
      if (status /= 0) return
    end do
  end subroutine divide

  ! Last place of a run that stops at this depth (quarter -1) or lies in a quarter of the box.
  pure integer function last_in(places, run, depth, quarter)
    type(ordered_places), intent(in) :: places
    integer, intent(in) :: run(3), depth, quarter
    integer :: above, middle

    ! What stops here comes first, then the quarters one after another.
    last_in = run(1) - 1
    above = run(3) + 1
    do while (above - last_in > 1)
      middle = (above + last_in) / 2
      if (part(middle) <= quarter) then
        last_in = middle
      else
        above = middle
      end if
    end do

  contains

    pure integer function part(i)
      integer, intent(in) :: i

      part = -1
      if (places%stop_level(i) > depth) part = ibits(places%cell(1, i), deepest - depth - 1, 1) &
                                      + 2 * ibits(places%cell(2, i), deepest - depth - 1, 1)
    end function part
  end function last_in

end module asperity_box_tree
