!> Sums of 1/r of many sources in a plane at many places, in time proportional to their number.
!>
!> Source j is a circle with charge q_j and spread w_j and the potential q_j (1 + w_j Laplacian) 1/r
!> = q_j (1/r + w_j / r**3). Circles that are near each other, by the reaches they are planted with,
!> are listed and left to the caller. All others are summed: those in boxes that touch place by
!> place, those in other boxes by expansions (asperity_box_expansions).
module asperity_source_tree
  use asperity_box_expansions, only: add_field, add_moments, down, go, lanes, prepare, &
                                     translations, up
  use asperity_box_tree, only: box_tree, plant_boxes
  use asperity_direct_sums, only: add_direct, gather_sources
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int64, real64
  use asperity_process, only: has_memory
  implicit none
  private

  public :: source_tree, plant_tree, sum_sources

  ! Fewest places for which threads are started.
  integer, parameter :: many = 512
  ! Bytes of a source or target without near ones. A million circles that are both took 210 each
  ! all over a square, 200 in clusters (measured); the rest is for worse.
  integer(int64), parameter :: bytes_per_place = 200_int64
  character(*), parameter :: no_memory = 'no memory for the sum over all contacts'

  !> Sources and targets at their places.
  type :: source_tree
    !> where the near sources of a target begin in `near`
    integer, allocatable :: first(:)
    !> sources near each target, ascending, without itself
    integer, allocatable :: near(:)
    !> why the tree could not be planted; not allocated when all is well
    character(:), allocatable :: failure
    type(box_tree), private :: boxes
    type(translations), private :: ways
    ! In the order of the boxes: planted place, near_factor * reach, place; of sources charge and
    ! charge times spread, too.
    real(real64), allocatable, private :: source(:, :), target(:, :)
    logical, private :: same = .true.
  end type source_tree

contains

  !> Plants sources and targets at their places and finds which are near each other.
  subroutine plant_tree(tree, x_source, y_source, reach_source, near_factor, x_target, y_target, &
                        reach_target)
    type(source_tree), intent(out) :: tree           !! the tree
    real(real64), intent(in) :: x_source(:)          !! places
    real(real64), intent(in) :: y_source(:)          !! places
    real(real64), intent(in) :: reach_source(:)      !! reaches, none negative
    !> circles whose places are nearer than this times the sum of their reaches are near
    real(real64), intent(in) :: near_factor
    !> places of targets; absent: targets are the sources, and none acts on itself
    real(real64), intent(in), optional :: x_target(:)
    real(real64), intent(in), optional :: y_target(:)      !! places of targets
    real(real64), intent(in), optional :: reach_target(:)  !! reaches of targets
    integer :: n

    tree%same = .not. present(x_target)
    n = size(x_source)
    if (.not. tree%same) n = size(x_target)
    tree%first = spread(1, 1, n + 1)
    allocate (tree%near(0), tree%source(size(x_source), 7), tree%target(n, 6))
    if (size(x_source) == 0 .or. n == 0) return
    if (.not. has_memory(bytes_per_place * (n + size(x_source)))) then
      tree%failure = no_memory
      return
    end if
    tree%source(:, 1) = x_source
    tree%source(:, 2) = y_source
    tree%source(:, 3) = near_factor * reach_source
    if (tree%same) then
      tree%target(:, :3) = tree%source(:, :3)
    else
      tree%target(:, 1) = x_target
      tree%target(:, 2) = y_target
      tree%target(:, 3) = near_factor * reach_target
    end if
    call plant_boxes(tree%source, tree%target, tree%same, tree%boxes)
    tree%source(:, :3) = tree%source(tree%boxes%source_order, :3)
    tree%target(:, :3) = tree%target(tree%boxes%target_order, :3)
    tree%target(:, 4:5) = tree%target(:, :2)
    tree%target(:, 6) = 0.0_real64
    call list_near(tree)
    if (tree%boxes%top > tree%boxes%last .or. allocated(tree%failure)) return
    call prepare(tree%ways)
    do n = tree%boxes%top, tree%boxes%last
      associate (level => tree%boxes%level(n))
        allocate (level%moment(tree%ways%terms, level%boxes), &
                  level%field(tree%ways%terms, level%boxes))
      end associate
    end do
  end subroutine plant_tree

  ! Counts the near sources of every target, then lists them.
  subroutine list_near(tree)
    type(source_tree), intent(inout) :: tree
    real(real64), allocatable :: about(:, :)
    integer, allocatable :: name(:), found(:), order(:)
    integer :: l, a, i, k, n, own, near
    integer(int64) :: pairs
    logical :: listing

    ! Every source carries its name.
    tree%source(:, 4) = tree%boxes%source_order
    listing = .false.
    do
      !$omp parallel private(about, name, found, order, l, a, i, k, n, own, near) &
      !$omp if(size(tree%target, 1) > many)
      allocate (about(0, 4))
      do l = 0, tree%boxes%last
        !$omp do schedule(dynamic, 16)
        do a = 1, tree%boxes%level(l)%boxes
          associate (run => tree%boxes%level(l)%target(:, a))
            if (run(2) < run(1)) cycle
            call gather_sources(tree%boxes, l, a, tree%source(:, :4), about, n)
            if (listing .and. n > 0) then
              order = [(k, k=1, n)]
              call sort_keys(about(:n, 4), order)
              about(:n, :) = about(order, :)
            end if
            name = nint(about(:n, 4))
            found = spread(0, 1, n + 1)
            do i = run(1), run(2)
              own = merge(tree%boxes%target_order(i), 0, tree%same)
              near = 0
              ! Without a branch, which would be mispredicted.
              do k = 1, n
                found(near + 1) = name(k)
                near = near + merge(1, 0, (about(k, 1) - tree%target(i, 1))**2 &
                                    + (about(k, 2) - tree%target(i, 2))**2 &
                                    < (about(k, 3) + tree%target(i, 3))**2 .and. name(k) /= own)
              end do
              associate (first => tree%first(tree%boxes%target_order(i):))
                if (listing) then
                  tree%near(first(1):first(2) - 1) = found(:near)
                else
                  first(2) = near
                end if
              end associate
            end do
          end associate
        end do
        !$omp end do nowait
      end do
      !$omp end parallel
      if (listing) exit
      pairs = sum(int(tree%first(2:), int64))
      if (pairs > huge(i) - 1 .or. .not. has_memory(4_int64 * pairs + 1_int64)) then
        tree%failure = no_memory
        return
      end if
      do i = 2, size(tree%first)
        tree%first(i) = tree%first(i) + tree%first(i - 1)
      end do
      deallocate (tree%near)
      allocate (tree%near(tree%first(size(tree%first)) - 1))
      listing = .true.
    end do
  end subroutine list_near

  !> Sums over all sources that are not near.
  !>
  !> Moves shift places without a change of what is near and of what is summed how: all sums are
  !> smooth functions of charges and moves. Moves must be small against the reaches. Targets that
  !> are the sources move with them. Laplacian and slopes are those of the potential with spread.
  subroutine sum_sources(tree, charge, spread, potential, lap, slope_x, slope_y, move_x, move_y, &
                         rough)
    type(source_tree), intent(inout) :: tree                  !! the tree
    real(real64), intent(in) :: charge(:)                     !! of sources
    real(real64), intent(in) :: spread(:)                     !! of sources, at most reach**2
    real(real64), intent(inout) :: potential(:)               !! at targets
    real(real64), intent(inout), optional :: lap(:)           !! its Laplacian in the plane
    real(real64), intent(inout), optional :: slope_x(:)       !! its slope; both or none
    real(real64), intent(inout), optional :: slope_y(:)       !! its slope
    real(real64), intent(in), optional :: move_x(:)           !! of sources
    real(real64), intent(in), optional :: move_y(:)           !! of sources
    !> only the potential, and of boxes without spread, to 1e-4 or so; mean by the target's spread
    logical, intent(in), optional :: rough
    real(real64), allocatable :: about(:, :)
    real(real64) :: value(4), place(2)
    integer :: l, a, i, n, at, terms
    logical :: is_rough

    is_rough = .false.
    if (present(rough)) is_rough = rough
    potential(:) = 0.0_real64
    if (present(lap)) lap(:) = 0.0_real64
    if (present(slope_x)) slope_x(:) = 0.0_real64
    if (present(slope_y)) slope_y(:) = 0.0_real64
    if (.not. allocated(tree%boxes%level)) return
    terms = merge(tree%ways%rough_terms, tree%ways%terms, is_rough)
    !$omp parallel private(about, value, place, l, a, i, n, at) if(size(tree%target, 1) > many)
    !$omp do
    do i = 1, size(tree%source, 1)
      at = tree%boxes%source_order(i)
      tree%source(i, 4:5) = tree%source(i, :2)
      if (present(move_x)) tree%source(i, 4) = tree%source(i, 4) + move_x(at)
      if (present(move_y)) tree%source(i, 5) = tree%source(i, 5) + move_y(at)
      tree%source(i, 6:7) = [charge(at), merge(2.0_real64, charge(at), is_rough) * spread(at)]
      if (tree%same) tree%target(i, 4:6) = tree%source(i, [4, 5, 7])
    end do
    !$omp end do
    do l = tree%boxes%last, tree%boxes%top, -1
      call rise(tree, l, terms)
    end do
    do l = tree%boxes%top, tree%boxes%last
      call fall(tree, l, terms)
    end do
    allocate (about(0, 7))
    do l = 0, tree%boxes%last
      !$omp do schedule(dynamic, 16)
      do a = 1, tree%boxes%level(l)%boxes
        associate (this => tree%boxes%level(l))
          if (this%target(2, a) < this%target(1, a)) cycle
          call gather_sources(tree%boxes, l, a, tree%source, about, n)
          do i = this%target(1, a), this%target(2, a)
            value = 0.0_real64
            call add_direct(about, n, tree%target(i, :), is_rough, value)
            place = (tree%target(i, 4:5) - middle_of(tree%boxes, l, a)) / this%half
            if (l >= tree%boxes%top) call add_field(tree%ways, place(1), place(2), this%half, &
                                                    this%field(:terms, a), value)
            at = tree%boxes%target_order(i)
            potential(at) = value(1)
            if (present(lap)) lap(at) = value(2)
            if (present(slope_x)) slope_x(at) = value(3)
            if (present(slope_y)) slope_y(at) = value(4)
          end do
        end associate
      end do
      !$omp end do nowait
    end do
    !$omp end parallel
  end subroutine sum_sources

  ! Moments of the boxes of a level, from their children and from what is in none. All threads come
  ! here together.
  subroutine rise(tree, l, terms)
    type(source_tree), intent(inout) :: tree
    integer, intent(in) :: l, terms
    real(real64) :: sums(lanes, terms), place(2)
    integer :: a, b, begin, box(0:3, lanes), j

    associate (this => tree%boxes%level(l))
      !$omp do schedule(dynamic)
      do begin = 1, this%boxes, lanes
        box = 0
        do a = begin, min(begin + lanes - 1, this%boxes)
          do b = this%child(a), this%child(a + 1) - 1
            box(tree%boxes%level(l + 1)%quarter(b), a - begin + 1) = b
          end do
        end do
        sums = 0.0_real64
        if (any(box > 0)) call go(tree%ways, up, tree%boxes%level(l + 1)%moment, box, sums)
        do a = begin, min(begin + lanes - 1, this%boxes)
          this%moment(:terms, a) = sums(a - begin + 1, :)
          do j = this%source(1, a), this%source(2, a)
            place = (tree%source(j, 4:5) - middle_of(tree%boxes, l, a)) / this%half
            call add_moments(tree%ways, place(1), place(2), tree%source(j, 6), &
                             merge(tree%source(j, 7) / this%half**2, 0.0_real64, &
                                   terms == tree%ways%terms), this%moment(:terms, a))
          end do
        end do
      end do
      !$omp end do
    end associate
  end subroutine rise

  ! Fields in the boxes of a level: from the box around, and from boxes that act as a whole. All
  ! threads come here together.
  subroutine fall(tree, l, terms)
    type(source_tree), intent(inout) :: tree
    integer, intent(in) :: l, terms
    real(real64) :: sums(lanes, terms)
    integer :: a, begin, box(0:3, lanes), column, n, row

    associate (this => tree%boxes%level(l))
      !$omp do schedule(dynamic)
      do begin = 1, this%boxes, lanes
        n = min(lanes, this%boxes - begin + 1)
        box = 0
        sums = 0.0_real64
        do row = 0, 3
          do column = 0, 3
            if (max(row, column) < 2) cycle
            do a = 1, n
              associate (b => this%partner(:, begin + a - 1))
                ! Partners count from -24.
                box(:, a) = [b(25 + 7 * row + column), b(25 + 7 * row - column), &
                             b(25 - 7 * row + column), b(25 - 7 * row - column)]
                if (column == 0) box(1::2, a) = 0
                if (row == 0) box(2:, a) = 0
              end associate
            end do
            if (any(box > 0)) &
              call go(tree%ways, 4 * row + column, this%moment, box, sums)
          end do
        end do
        sums = sums / this%half
        if (l > tree%boxes%top) then
          box = 0
          do a = 1, n
            box(this%quarter(begin + a - 1), a) = this%parent(begin + a - 1)
          end do
          call go(tree%ways, down, tree%boxes%level(l - 1)%field, box, sums)
        end if
        this%field(:terms, begin:begin + n - 1) = transpose(sums(:n, :))
      end do
      !$omp end do
    end associate
  end subroutine fall

  pure function middle_of(boxes, l, a) result(middle)
    type(box_tree), intent(in) :: boxes
    integer, intent(in) :: l, a
    real(real64) :: middle(2)

    middle = boxes%corner + (2 * boxes%level(l)%cell(:, a) + 1) * boxes%level(l)%half
  end function middle_of

end module asperity_source_tree
