!> A tree of square boxes over circles.
!>
!> Boxes that touch are split as long as they hold so many circles that smaller ones cost less. A
!> circle rests in the smallest box around it that is at least twice as wide as its reach: circles
!> in boxes of a level that do not touch are never near, and expansions are smooth over every
!> circle. (Fast multipole method: Greengard, Rokhlin, J. Comput. Phys. 73, 325, 1987.)
module asperity_box_tree
  use asperity_kinds, only: real64
  implicit none
  private

  public :: build_boxes, square_box, touching

  ! Levels below the root: circles may coincide.
  integer, parameter :: deepest = 24
  ! Pairs of circles above which two boxes that touch are split (measured).
  real(real64), parameter :: worth_a_split = 1600.0_real64
  ! Fewest circles that threads sort: a level of fewer takes less than a millisecond.
  integer, parameter :: many = 8192
  ! Pairs of sources and targets up to which all are summed one by one: 600 circles, where trees of
  ! any depth took as long (measured) and expansions need not be prepared.
  real(real64), parameter :: few_pairs = 3.6e5_real64

  !> A box.
  type :: square_box
    real(real64) :: middle(2) = 0.0_real64  !! place
    real(real64) :: half = 0.5_real64       !! of the width
    !> of its sources and of its targets, in the order of the boxes: the first, the last that is in
    !> no child, the last
    integer :: circles(3, 2) = 0
    integer :: parent = 0                   !! the box around it
    integer :: quarter = 0                  !! of that, 0 to 3, first in x
    integer :: child(2) = [1, 0]            !! the first and the last of its quarters
    !> the box of its level so many columns and rows away if their parents touch, or 0
    integer :: around(-3:3, -3:3) = 0
  end type square_box

contains

  !> Sorts circles into boxes.
  subroutine build_boxes(place, sources, targets, order, boxes, level)
    real(real64), intent(inout) :: place(:, :)  !! x, y and reach, rows; ordered by boxes then
    integer, intent(in) :: sources              !! so many are the first
    integer, intent(in) :: targets              !! so many are the last; they may be the same
    integer, allocatable, intent(out) :: order(:)  !! which circle comes where
    type(square_box), allocatable, intent(out) :: boxes(:)  !! level by level
    integer, allocatable, intent(out) :: level(:)  !! the first box of each level, and one more
    real(real64) :: low(2), high(2)
    integer :: i

    order = [(i, i=1, size(place, 1))]
    allocate (boxes(1))
    boxes(1)%circles(:, 1) = [1, sources, sources]
    boxes(1)%circles(:, 2) = [size(order) - targets + 1, size(order), size(order)]
    boxes(1)%around(0, 0) = 1
    level = [1, 2]
    if (real(sources, real64) * targets <= few_pairs) return
    low = minval(place(:, :2), 1)
    high = maxval(place(:, :2), 1)
    boxes(1)%middle = 0.5_real64 * (low + high)
    if (any(high > low)) boxes%half = 0.5_real64 * maxval(high - low)
    do i = 1, deepest
      call divide_boxes(place, order, boxes, level(i))
      if (size(boxes) < level(i + 1)) exit
      level = [level, size(boxes) + 1]
    end do
  end subroutine build_boxes

  !> The boxes that touch one, itself included.
  pure function touching(this) result(near)
    type(square_box), intent(in) :: this  !! box of a level with its neighbours known
    integer, allocatable :: near(:)       !! those of its level

    near = pack(this%around(-1:1, -1:1), this%around(-1:1, -1:1) > 0)
  end function touching

  ! Makes the next level from boxes that are split.
  subroutine divide_boxes(place, order, boxes, from)
    real(real64), intent(inout) :: place(:, :)
    integer, intent(inout) :: order(:)
    type(square_box), allocatable, intent(inout) :: boxes(:)
    integer, intent(in) :: from  ! first box of the last level
    type(square_box), allocatable :: new(:)
    integer, allocatable :: run(:, :, :, :)
    integer :: a, b, i, k, n, shift(2)
    logical :: split(size(boxes))

    split = .false.
    do a = from, size(boxes)
      associate (near => touching(boxes(a)))
        split(a) = max(maxval(number_of(1, boxes(near))) * number_of(2, boxes(a)), &
                       maxval(number_of(2, boxes(near))) * number_of(1, boxes(a))) > worth_a_split
      end associate
    end do
    allocate (run(3, -1:3, 2, from:size(boxes)))
    !$omp parallel do schedule(dynamic) if(size(order) > many)
    do a = from, size(boxes)
      if (split(a)) call sort_into_quarters(place, order, boxes(a), run(:, :, :, a))
    end do
    !$omp end parallel do
    allocate (new(4 * count(split)))
    n = 0
    do a = from, size(boxes)
      if (.not. split(a)) cycle
      associate (this => boxes(a))
        this%circles(2, :) = run(2, -1, :, a)
        this%child(1) = size(boxes) + n + 1
        do k = 0, 3
          if (all(run(1, k, :, a) > run(3, k, :, a))) cycle
          n = n + 1
          new(n)%circles = run(:, k, :, a)
          new(n)%half = 0.5_real64 * this%half
          new(n)%middle = this%middle + ([mod(k, 2), k / 2] - 0.5_real64) * this%half
          new(n)%parent = a
          new(n)%quarter = k
        end do
        this%child(2) = size(boxes) + n
      end associate
    end do
    boxes = [boxes, new(:n)]
    do a = size(boxes) - n + 1, size(boxes)
      associate (near => touching(boxes(boxes(a)%parent)))
        do i = 1, size(near)
          do b = boxes(near(i))%child(1), boxes(near(i))%child(2)
            shift = nint(0.5_real64 * (boxes(b)%middle - boxes(a)%middle) / boxes(a)%half)
            boxes(a)%around(shift(1), shift(2)) = b
          end do
        end do
      end associate
    end do
  end subroutine divide_boxes

  ! Orders the circles of a box: those that rest in it, then quarter by quarter.
  subroutine sort_into_quarters(place, order, this, run)
    real(real64), intent(inout) :: place(:, :)
    integer, intent(inout) :: order(:)
    type(square_box), intent(in) :: this
    integer, intent(out) :: run(3, -1:3, 2)  ! of sources and targets: first, last, last
    real(real64), allocatable :: places(:, :)
    integer, allocatable :: names(:), part(:), chosen(:)
    integer :: b, i, k, l

    do l = 1, 2
      i = this%circles(1, l)
      ! Sources that are the targets have been sorted.
      if (l == 2 .and. all(this%circles(:, 1) == this%circles(:, 2))) then
        run(:, :, 2) = run(:, :, 1)
        return
      end if
      places = place(i:this%circles(3, l), :)
      names = order(i:this%circles(3, l))
      part = merge(1, 0, places(:, 1) > this%middle(1)) + &
             merge(2, 0, places(:, 2) > this%middle(2))
      where (2 * places(:, 3) > this%half) part = -1
      do k = -1, 3
        chosen = pack([(b, b=1, size(part))], part == k)
        b = i + size(chosen) - 1
        place(i:b, :) = places(chosen, :)
        order(i:b) = names(chosen)
        run(:, k, l) = [i, b, b]
        i = b + 1
      end do
    end do
  end subroutine sort_into_quarters

  ! How many sources or targets a box has.
  elemental real(real64) function number_of(kind_of, this)
    integer, intent(in) :: kind_of
    type(square_box), intent(in) :: this

    number_of = this%circles(3, kind_of) - this%circles(1, kind_of) + 1.0_real64
  end function number_of

end module asperity_box_tree
