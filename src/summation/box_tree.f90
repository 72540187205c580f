!> A tree of square boxes over circles, and which boxes act on which as a whole.
!>
!> A box is split as long as it and a neighbour hold so many places that smaller boxes cost less.
!> Boxes of a level that do not touch act by their expansions, or place by place when they hold
!> few. A circle goes into no box narrower than twice its reach, so that circles in boxes that do
!> not touch are never near and expansions are smooth over every circle. (Fast multipole method:
!> Greengard, Rokhlin, J. Comput. Phys. 73, 325, 1987; the choices pair by pair are ours.)
module asperity_box_tree
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int64, real64
  implicit none
  private

  public :: box_level, box_tree, plant_boxes

  ! Levels below the root: Morton's key and a level, together, stay exact in a double.
  integer, parameter :: deepest = 24
  ! Pairs of places that take the time of one translation, and above which boxes that touch are
  ! split: 12 translations of each of four boxes save 3/4 of 9 * pairs (measured).
  real(real64), parameter :: worth = 50.0_real64, worth_a_split = 32 * worth
  ! Pairs of places up to which all are summed place by place: 600 places, where trees of any depth
  ! took as long (measured) and expansions need not be prepared.
  real(real64), parameter :: few_pairs = 3.6e5_real64

  !> The boxes of one width, in Morton's order.
  type :: box_level
    !> number of boxes
    integer :: boxes = 0
    !> half of a box's width
    real(real64) :: half = 0.0_real64
    !> column and row of a box
    integer, allocatable :: cell(:, :)
    !> its place in the box around it: 0 to 3, first in x
    integer, allocatable :: quarter(:)
    !> the box around it in the level above
    integer, allocatable :: parent(:)
    !> where its children begin in the level below
    integer, allocatable :: child(:)
    !> of its sources in order: the first, the last that is in no child, the last
    integer, allocatable :: source(:, :)
    !> the same of its targets
    integer, allocatable :: target(:, :)
    !> the box 7 rows + columns away when that acts by its expansion, or 0
    integer, allocatable :: partner(:, :)
    !> where in `near` the boxes begin that act on it place by place
    integer, allocatable :: first(:)
    !> these boxes; negative: their children are settled with its own in the level below
    integer, allocatable :: near(:)
    !> moments of the sources of a box, and coefficients of the field in it
    real(real64), allocatable :: moment(:, :), field(:, :)
  end type box_level

  !> All levels.
  type :: box_tree
    !> corner of the root
    real(real64) :: corner(2) = 0.0_real64
    !> last level, and the first with boxes that act by expansions
    integer :: last = 0, top = 0
    !> levels from 0, the root
    type(box_level), allocatable :: level(:)
    !> sources and targets in the order of the boxes
    integer, allocatable :: source_order(:), target_order(:)
  end type box_tree

contains

  !> Sorts circles into boxes and settles which boxes act on which.
  pure subroutine plant_boxes(source, target, same, tree)
    real(real64), intent(in) :: source(:, :)  !! x, y and reach of sources, rows, one at least
    real(real64), intent(in) :: target(:, :)  !! of targets, one at least
    logical, intent(in) :: same               !! targets are the sources
    type(box_tree), intent(out) :: tree       !! the boxes
    integer(int64), allocatable :: source_key(:), target_key(:)
    real(real64) :: width
    integer :: l, i

    tree%corner = [(min(minval(source(:, i)), minval(target(:, i))), i=1, 2)]
    ! A little more, so that the last place is inside; anything when all places are one.
    width = 1.0001_real64 * maxval([(max(maxval(source(:, i)), maxval(target(:, i))) &
                                     - tree%corner(i), i=1, 2)])
    if (.not. width > 0.0_real64) width = 1.0_real64
    call order_places(source, tree%corner, width, source_key, tree%source_order)
    if (same) then
      target_key = source_key
      tree%target_order = tree%source_order
    else
      call order_places(target, tree%corner, width, target_key, tree%target_order)
    end if
    allocate (tree%level(-1:deepest))
    ! Around the root one box that is split.
    tree%level(-1)%child = [1, 2]
    tree%level(-1)%first = [1, 2]
    tree%level(-1)%near = [-1]
    call make_level(tree%level(0), 1)
    tree%level(0)%cell(:, 1) = 0
    tree%level(0)%parent(1) = 1
    tree%level(0)%source(:, 1) = [1, size(source, 1), size(source, 1)]
    tree%level(0)%target(:, 1) = [1, size(target, 1), size(target, 1)]
    tree%top = deepest + 1
    do l = 0, deepest
      tree%last = l
      tree%level(l)%half = scale(0.5_real64 * width, -l)
      call meet(tree%level(l - 1), tree%level(l), merge(few_pairs, worth_a_split, l == 0))
      if (any(tree%level(l)%partner > 0)) tree%top = min(tree%top, l)
      if (l == deepest) exit
      call divide(tree%level(l), tree%level(l + 1), source_key, target_key, deepest - l - 1)
      if (tree%level(l + 1)%boxes == 0) exit
    end do
  end subroutine plant_boxes

  ! Sorts by Morton's key; a circle that stops at a level comes first in its box.
  pure subroutine order_places(place, corner, width, key, order)
    real(real64), intent(in) :: place(:, :), corner(2), width
    integer(int64), allocatable, intent(out) :: key(:)  ! 32 times Morton's, and the circle's level
    integer, allocatable, intent(out) :: order(:)
    real(real64) :: fine
    integer :: i, stop_level

    allocate (key(size(place, 1)), order(size(place, 1)))
    fine = scale(1.0_real64, deepest)
    do i = 1, size(key)
      stop_level = deepest
      if (place(i, 3) > 0.0_real64) &
        stop_level = max(0, min(deepest, exponent(0.5_real64 * width / place(i, 3)) - 1))
      key(i) = spread_out(int(fine * ((place(i, 1) - corner(1)) / width), int64)) + &
               2 * spread_out(int(fine * ((place(i, 2) - corner(2)) / width), int64))
      key(i) = 32 * ishft(ishft(key(i), 2 * (stop_level - deepest)), 2 * (deepest - stop_level)) &
               + stop_level
    end do
    call sort_keys(real(key, real64), order)
    key = key(order)
  end subroutine order_places

  ! Moves the bits of a number below 2**24 to even places.
  elemental integer(int64) function spread_out(number) result(bits)
    integer(int64), intent(in) :: number
    integer(int64) :: mask
    integer :: i

    bits = number
    mask = 2_int64**32 - 1
    do i = 4, 0, -1
      mask = ieor(mask, ishft(mask, 2**i))
      bits = iand(ior(bits, ishft(bits, 2**i)), mask)
    end do
  end function spread_out

  pure subroutine make_level(level, boxes)
    type(box_level), intent(inout) :: level
    integer, intent(in) :: boxes

    level%boxes = boxes
    allocate (level%cell(2, boxes), level%quarter(boxes), level%parent(boxes), &
              level%child(boxes + 1), level%source(3, boxes), level%target(3, boxes), &
              level%first(boxes + 1), level%near(36 * boxes), level%partner(-24:24, boxes))
    level%child = 1
    level%partner = 0
  end subroutine make_level

  ! Settles, for every box, how the boxes act whose parents touch its own.
  pure subroutine meet(above, this, enough)
    type(box_level), intent(in) :: above
    type(box_level), intent(inout) :: this
    real(real64), intent(in) :: enough  ! pairs of places, above which boxes that touch are split
    real(real64) :: pairs
    integer :: a, b, k, n, shift(2)

    n = 0
    do a = 1, this%boxes
      this%first(a) = n + 1
      do k = above%first(this%parent(a)), above%first(this%parent(a) + 1) - 1
        if (above%near(k) > 0) cycle
        do b = above%child(-above%near(k)), above%child(1 - above%near(k)) - 1
          pairs = real(this%target(3, a) - this%target(1, a) + 1, real64) &
                  * (this%source(3, b) - this%source(1, b) + 1)
          if (.not. pairs > 0.0_real64) cycle
          shift = this%cell(:, b) - this%cell(:, a)
          if (maxval(abs(shift)) > 1 .and. pairs > worth) then
            this%partner(7 * shift(2) + shift(1), a) = b
          else
            n = n + 1
            this%near(n) = b
            if (maxval(abs(shift)) <= 1 .and. pairs > enough) this%near(n) = -b
          end if
        end do
      end do
    end do
    this%first(this%boxes + 1) = n + 1
    this%near = this%near(:n)
  end subroutine meet

  ! Makes the boxes of the next level.
  pure subroutine divide(this, next, source_key, target_key, below)
    type(box_level), intent(inout) :: this
    type(box_level), intent(inout) :: next
    integer(int64), intent(in) :: source_key(:), target_key(:)
    integer, intent(in) :: below  ! levels below the next
    logical, allocatable :: split(:)
    integer :: a, n, k, source, target

    allocate (split(this%boxes))
    split(:) = .false.
    do a = 1, this%boxes
      do k = this%first(a), this%first(a + 1) - 1
        if (this%near(k) < 0) split([a, -this%near(k)]) = .true.
      end do
    end do
    call make_level(next, 4 * count(split))
    n = 0
    do a = 1, this%boxes
      this%child(a) = n + 1
      if (.not. split(a)) cycle
      source = this%source(1, a) - 1
      target = this%target(1, a) - 1
      do k = -1, 3
        n = n + 1
        next%source(:, n) = run(source_key, source, this%source(3, a), below, k)
        next%target(:, n) = run(target_key, target, this%target(3, a), below, k)
        source = next%source(3, n)
        target = next%target(3, n)
        if (k < 0) then
          this%source(2, a) = source
          this%target(2, a) = target
          n = n - 1
        else if (source < next%source(1, n) .and. target < next%target(1, n)) then
          n = n - 1
        else
          next%parent(n) = a
          next%quarter(n) = k
          next%cell(:, n) = 2 * this%cell(:, a) + [mod(k, 2), k / 2]
        end if
      end do
    end do
    this%child(this%boxes + 1) = n + 1
    next%boxes = n
  end subroutine divide

  ! The places after one that lie in a quarter of a box, or (-1) stop before its quarters.
  pure function run(key, after, last, below, quarter)
    integer(int64), intent(in) :: key(:)
    integer, intent(in) :: after, last, below, quarter
    integer :: run(3), i, part

    do i = after + 1, last
      part = int(ibits(key(i), 5 + 2 * below, 2))
      if (deepest - iand(key(i), 31_int64) > below) part = -1
      if (part /= quarter) exit
    end do
    run = [after + 1, i - 1, i - 1]
  end function run

end module asperity_box_tree
