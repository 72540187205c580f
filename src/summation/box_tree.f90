!> A tree of square boxes over points with reaches (the centres and radii of circles).
!>
!> A box is split where the pairs of points between it and a touching box of its level outnumber
!> `split_pairs`, the number from which on expansions are faster than direct sums. A point belongs
!> to the smallest box around it that is at least twice as wide as its reach: points in boxes of one
!> level that do not touch are never near each other, and expansions are smooth over every circle
!> (fast multipole method: Greengard and Rokhlin, J. Comput. Phys. 73, 325, 1987).
module asperity_box_tree
  use asperity_kinds, only: real64
  implicit none
  private

  public :: build_boxes, square_box, as_source, as_target, first_point, last_own_point, last_point

  !> Rows of `square_box%points`: first point, last point that belongs to no child, last point.
  integer, parameter :: first_point = 1, last_own_point = 2, last_point = 3
  !> Columns of `square_box%points`: sources, targets.
  integer, parameter :: as_source = 1, as_target = 2

  ! Largest number of levels below the root, as points may coincide (chosen).
  integer, parameter :: max_levels = 24
  ! Number of pairs of points of two touching boxes above which they are split (measured).
  real(real64), parameter :: split_pairs = 1600.0_real64
  ! Number of points above which threads sort them (measured: a level of fewer takes less than a
  ! millisecond).
  integer, parameter :: thread_threshold = 8192
  ! Number of pairs of sources and targets up to which all are summed directly (measured: with 600
  ! points trees of any depth take equally long, and no expansions have to be prepared).
  real(real64), parameter :: direct_pairs = 3.6e5_real64

  !> A square box.
  type :: square_box
    real(real64) :: centre(2) = 0.0_real64   !! position of the centre [length]
    real(real64) :: half_width = 0.5_real64  !! half of the width [length]
    !> indices of its sources and targets in the order of the boxes: `first_point` ... by row,
    !> `as_source` ... by column
    integer :: points(3, 2) = 0
    integer :: parent = 0                    !! index of the parent
    integer :: quadrant = 0                  !! in the parent: 1 if right, plus 2 if upper
    integer :: children(2) = [1, 0]          !! indices of the first and the last child
    !> box of its level at an offset in columns and rows if the parents touch, else 0
    integer :: neighbour(-3:3, -3:3) = 0
  end type square_box

contains

  !> Sorts points into boxes.
  subroutine build_boxes(points, sources, targets, order, boxes, level_start)
    !> (point, 3): x, y and reach, 0 or more [length]; on return in the order of the boxes
    real(real64), intent(inout) :: points(:, :)
    integer, intent(in) :: sources              !! number of sources, the first points
    integer, intent(in) :: targets              !! number of targets, the last points; may overlap
    integer, allocatable, intent(out) :: order(:)  !! original index of each ordered point
    type(square_box), allocatable, intent(out) :: boxes(:)  !! boxes, level by level
    integer, allocatable, intent(out) :: level_start(:)  !! first box of each level, last box + 1
    real(real64) :: low(2), high(2)
    integer :: i

    order = [(i, i=1, size(points, 1))]
    allocate (boxes(1))
    boxes(1)%points(:, as_source) = [1, sources, sources]
    boxes(1)%points(:, as_target) = [size(order) - targets + 1, size(order), size(order)]
    boxes(1)%neighbour(0, 0) = 1
    level_start = [1, 2]
    if (real(sources, real64) * targets <= direct_pairs) return
    low = minval(points(:, :2), 1)
    high = maxval(points(:, :2), 1)
    boxes(1)%centre = 0.5_real64 * (low + high)
    if (any(high > low)) boxes%half_width = 0.5_real64 * maxval(high - low)
    do i = 1, max_levels
      call divide_boxes(points, order, boxes, level_start(i))
      if (size(boxes) < level_start(i + 1)) exit
      level_start = [level_start, size(boxes) + 1]
    end do
  end subroutine build_boxes

  ! Indices of the boxes of the same level that touch a box, itself included.
  pure function touching_boxes(box) result(touching)
    type(square_box), intent(in) :: box
    integer, allocatable :: touching(:)

    touching = pack(box%neighbour(-1:1, -1:1), box%neighbour(-1:1, -1:1) > 0)
  end function touching_boxes

  ! Splits boxes of the last level and appends their children as the next level.
  subroutine divide_boxes(points, order, boxes, first_box)
    real(real64), intent(inout) :: points(:, :)
    integer, intent(inout) :: order(:)
    type(square_box), allocatable, intent(inout) :: boxes(:)
    integer, intent(in) :: first_box  ! first box of the last level
    type(square_box), allocatable :: children(:)
    integer, allocatable :: bounds(:, :, :, :)
    integer :: a, b, i, k, n, offset(2)
    logical :: is_split(size(boxes))

    is_split = .false.
    do a = first_box, size(boxes)
      associate (touching => touching_boxes(boxes(a)))
        is_split(a) = max( &
          maxval(point_count(as_source, boxes(touching))) * point_count(as_target, boxes(a)), &
          maxval(point_count(as_target, boxes(touching))) * point_count(as_source, boxes(a))) > &
          split_pairs
      end associate
    end do
    allocate (bounds(3, -1:3, 2, first_box:size(boxes)))
    !$omp parallel do schedule(dynamic) if(size(order) > thread_threshold)
    do a = first_box, size(boxes)
      if (is_split(a)) call sort_into_quadrants(points, order, boxes(a), bounds(:, :, :, a))
    end do
    !$omp end parallel do
    allocate (children(4 * count(is_split)))
    n = 0
    do a = first_box, size(boxes)
      if (.not. is_split(a)) cycle
      associate (box => boxes(a))
        box%points(last_own_point, :) = bounds(last_own_point, -1, :, a)
        box%children(1) = size(boxes) + n + 1
        do k = 0, 3
          if (all(bounds(first_point, k, :, a) > bounds(last_point, k, :, a))) cycle
          n = n + 1
          children(n)%points = bounds(:, k, :, a)
          children(n)%half_width = 0.5_real64 * box%half_width
          children(n)%centre = box%centre + ([mod(k, 2), k / 2] - 0.5_real64) * box%half_width
          children(n)%parent = a
          children(n)%quadrant = k
        end do
        box%children(2) = size(boxes) + n
      end associate
    end do
    boxes = [boxes, children(:n)]
    do a = size(boxes) - n + 1, size(boxes)
      associate (touching => touching_boxes(boxes(boxes(a)%parent)))
        do i = 1, size(touching)
          do b = boxes(touching(i))%children(1), boxes(touching(i))%children(2)
            offset = nint(0.5_real64 * (boxes(b)%centre - boxes(a)%centre) / boxes(a)%half_width)
            boxes(a)%neighbour(offset(1), offset(2)) = b
          end do
        end do
      end associate
    end do
  end subroutine divide_boxes

  ! Sorts the points of a box: first those that belong to no child, then by quadrant.
  subroutine sort_into_quadrants(points, order, box, bounds)
    real(real64), intent(inout) :: points(:, :)
    integer, intent(inout) :: order(:)
    type(square_box), intent(in) :: box
    integer, intent(out) :: bounds(3, -1:3, 2)  ! `points` of the box itself (-1) and of quadrants
    real(real64), allocatable :: box_points(:, :)
    integer, allocatable :: indices(:), quadrant(:), chosen(:)
    integer :: b, i, k, l

    do l = as_source, as_target
      i = box%points(first_point, l)
      ! Sources that are the targets, too, are already sorted.
      if (l == as_target .and. all(box%points(:, as_source) == box%points(:, as_target))) then
        bounds(:, :, as_target) = bounds(:, :, as_source)
        return
      end if
      box_points = points(i:box%points(last_point, l), :)
      indices = order(i:box%points(last_point, l))
      quadrant = merge(1, 0, box_points(:, 1) > box%centre(1)) + &
                 merge(2, 0, box_points(:, 2) > box%centre(2))
      where (2 * box_points(:, 3) > box%half_width) quadrant = -1
      do k = -1, 3
        chosen = pack([(b, b=1, size(quadrant))], quadrant == k)
        b = i + size(chosen) - 1
        points(i:b, :) = box_points(chosen, :)
        order(i:b) = indices(chosen)
        bounds(:, k, l) = [i, b, b]
        i = b + 1
      end do
    end do
  end subroutine sort_into_quadrants

  ! Number of sources or of targets of a box.
  elemental real(real64) function point_count(kind_of_point, box)
    integer, intent(in) :: kind_of_point  ! `as_source` or `as_target`
    type(square_box), intent(in) :: box

    point_count = box%points(last_point, kind_of_point) - &
                  box%points(first_point, kind_of_point) + 1.0_real64
  end function point_count

end module asperity_box_tree
