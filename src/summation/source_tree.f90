!> Sums of 1/r of many sources in a plane at many places, in time proportional to their number.
!>
!> Source j is a circle with charge q_j and spread w_j and the potential q_j (1 + w_j Laplacian) 1/r
!> = q_j (1/r + w_j / r**3). Circles that are near each other, by the reaches they are planted with,
!> are listed and left to the caller. All others are summed: those in boxes that touch place by
!> place, those in other boxes by expansions (asperity_box_expansions).
module asperity_source_tree
  use asperity_box_expansions, only: add_field, add_moments, full_order, multiply, prepare, &
                                     rough_order, translations
  use asperity_box_tree, only: box_tree, plant_boxes
  use asperity_direct_sums, only: add_direct, gather_sources
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int64, real64
  use asperity_process, only: has_memory
  implicit none
  private

  public :: source_tree, plant_tree, sum_sources

  ! Boxes whose translations are made together, and fewest places for which threads are started.
  integer, parameter :: batch = 64, many = 512
  ! Pairs of places that take the time of one translation (measured: 100 to 200 do as well); rough
  ! ones have a twelfth of the terms squared.
  real(real64), parameter :: worth = 100.0_real64, rough_worth = worth / 8
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
                        reach_target, rough)
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
    !> errors of 1e-4 or so will do, and what is near is not listed
    logical, intent(in), optional :: rough
    logical :: is_rough
    integer :: n

    tree%same = .not. present(x_target)
    n = size(x_source)
    if (.not. tree%same) n = size(x_target)
    tree%first = spread(1, 1, n + 1)
    allocate (tree%near(0), tree%source(7, size(x_source)), tree%target(5, n))
    if (size(x_source) == 0 .or. n == 0) return
    if (.not. has_memory(bytes_per_place * (n + size(x_source)))) then
      tree%failure = no_memory
      return
    end if
    tree%source(1, :) = x_source
    tree%source(2, :) = y_source
    tree%source(3, :) = near_factor * reach_source
    if (tree%same) then
      tree%target(:3, :) = tree%source(:3, :)
    else
      tree%target(1, :) = x_target
      tree%target(2, :) = y_target
      tree%target(3, :) = near_factor * reach_target
    end if
    is_rough = .false.
    if (present(rough)) is_rough = rough
    call plant_boxes(tree%source, tree%target, tree%same, merge(rough_worth, worth, is_rough), &
                     tree%boxes)
    tree%source(:, :) = tree%source(:, tree%boxes%source_order)
    tree%target(:, :) = tree%target(:, tree%boxes%target_order)
    if (.not. is_rough) call list_near(tree)
    if (tree%boxes%top > tree%boxes%last .or. allocated(tree%failure)) return
    call prepare(merge(rough_order, full_order, is_rough), tree%ways)
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
    real(real64), allocatable :: about(:, :), found(:)
    integer, allocatable :: order(:)
    logical, allocatable :: close_by(:)
    integer :: l, a, i, n, name
    integer(int64) :: pairs
    logical :: listing

    ! Every source carries its name.
    tree%source(4, :) = tree%boxes%source_order
    listing = .false.
    do
      !$omp parallel private(about, found, order, close_by, l, a, i, n, name) &
      !$omp if(size(tree%target, 2) > many)
      allocate (about(0, 7))
      do l = 0, tree%boxes%last
        !$omp do schedule(dynamic, 16)
        do a = 1, tree%boxes%level(l)%boxes
          associate (run => tree%boxes%level(l)%target(:, a))
            if (run(2) < run(1)) cycle
            call gather_sources(tree%boxes, l, a, tree%source, about, n)
            do i = run(1), run(2)
              close_by = (about(:n, 1) - tree%target(1, i))**2 &
                         + (about(:n, 2) - tree%target(2, i))**2 &
                         < (about(:n, 3) + tree%target(3, i))**2
              name = tree%boxes%target_order(i)
              if (tree%same) close_by = close_by .and. nint(about(:n, 4)) /= name
              if (listing) then
                found = pack(about(:n, 4), close_by)
                if (size(found) == 0) cycle
                order = nint(found)
                call sort_keys(found, order)
                tree%near(tree%first(name):tree%first(name + 1) - 1) = nint(found(order))
              else
                tree%first(name + 1) = count(close_by)
              end if
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
  !> smooth functions of charges and moves. Moves must be small against the reaches. Laplacian and
  !> slopes are those of the potential with its spread.
  subroutine sum_sources(tree, charge, spread, potential, lap, slope_x, slope_y, move_x, move_y, &
                         target_move_x, target_move_y)
    type(source_tree), intent(inout) :: tree                  !! the tree
    real(real64), intent(in) :: charge(:)                     !! of sources
    real(real64), intent(in) :: spread(:)                     !! of sources, at most reach**2
    real(real64), intent(inout) :: potential(:)               !! at targets
    real(real64), intent(inout), optional :: lap(:)           !! its Laplacian in the plane
    real(real64), intent(inout), optional :: slope_x(:)       !! its slope; both or none
    real(real64), intent(inout), optional :: slope_y(:)       !! its slope
    real(real64), intent(in), optional :: move_x(:)           !! of sources
    real(real64), intent(in), optional :: move_y(:)           !! of sources
    real(real64), intent(in), optional :: target_move_x(:)    !! of targets
    real(real64), intent(in), optional :: target_move_y(:)    !! of targets
    real(real64), allocatable :: about(:, :)
    real(real64) :: value(4), place(2)
    integer :: l, a, i, n, at

    potential(:) = 0.0_real64
    if (present(lap)) lap(:) = 0.0_real64
    if (present(slope_x)) slope_x(:) = 0.0_real64
    if (present(slope_y)) slope_y(:) = 0.0_real64
    if (.not. allocated(tree%boxes%level)) return
    associate (s => tree%boxes%source_order, t => tree%boxes%target_order)
      tree%source(4:5, :) = tree%source(:2, :)
      tree%target(4:5, :) = tree%target(:2, :)
      if (present(move_x)) tree%source(4, :) = tree%source(1, :) + move_x(s)
      if (present(move_y)) tree%source(5, :) = tree%source(2, :) + move_y(s)
      if (present(target_move_x)) tree%target(4, :) = tree%target(1, :) + target_move_x(t)
      if (present(target_move_y)) tree%target(5, :) = tree%target(2, :) + target_move_y(t)
      tree%source(6, :) = charge(s)
      tree%source(7, :) = charge(s) * spread(s)
    end associate
    do l = tree%boxes%last, tree%boxes%top, -1
      call rise(tree, l)
    end do
    do l = tree%boxes%top, tree%boxes%last
      call fall(tree, l)
    end do
    !$omp parallel private(about, value, place, l, a, i, n, at) if(size(tree%target, 2) > many)
    allocate (about(0, 7))
    do l = 0, tree%boxes%last
      !$omp do schedule(dynamic, 16)
      do a = 1, tree%boxes%level(l)%boxes
        associate (this => tree%boxes%level(l))
          if (this%target(2, a) < this%target(1, a)) cycle
          call gather_sources(tree%boxes, l, a, tree%source, about, n)
          do i = this%target(1, a), this%target(2, a)
            value = 0.0_real64
            call add_direct(about, n, tree%target(:, i), value)
            place = tree%target(4:5, i) - middle_of(tree%boxes, l, a)
            if (l >= tree%boxes%top) &
              call add_field(tree%ways, place(1), place(2), this%half, this%field(:, a), value)
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

  ! Moments of the boxes of a level, from their children and from what is in none.
  subroutine rise(tree, l)
    type(source_tree), intent(inout) :: tree
    integer, intent(in) :: l
    real(real64) :: place(2), part(tree%ways%terms, 1)
    integer :: a, b, j

    associate (this => tree%boxes%level(l), terms => tree%ways%terms)
      !$omp parallel do schedule(static, 16) private(place, part, b, j) if(this%boxes > batch)
      do a = 1, this%boxes
        this%moment(:, a) = 0.0_real64
        do j = this%source(1, a), this%source(2, a)
          place = tree%source(4:5, j) - middle_of(tree%boxes, l, a)
          call add_moments(tree%ways, place(1), place(2), this%half, tree%source(6, j), &
                           tree%source(7, j), this%moment(:, a))
        end do
        do b = this%child(a), this%child(a + 1) - 1
          associate (below => tree%boxes%level(l + 1))
            call multiply(tree%ways%up(:, :, below%quarter(b)), below%moment(:, b:b), terms, 1, &
                          part)
          end associate
          this%moment(:, a) = this%moment(:, a) + part(:, 1)
        end do
      end do
      !$omp end parallel do
    end associate
  end subroutine rise

  ! Fields in the boxes of a level: from the box around, and from boxes that act as a whole.
  subroutine fall(tree, l)
    type(source_tree), intent(inout) :: tree
    integer, intent(in) :: l
    real(real64), dimension(tree%ways%terms, batch) :: panel, part
    integer :: begin, a, b, n, shift, into(batch)

    associate (this => tree%boxes%level(l), terms => tree%ways%terms)
      !$omp parallel do schedule(static, 1) private(panel, part, a, b, n, shift, into) &
      !$omp if(this%boxes > batch)
      do begin = 1, this%boxes, batch
        do a = begin, min(begin + batch - 1, this%boxes)
          this%field(:, a) = 0.0_real64
          if (l > tree%boxes%top) call multiply(tree%ways%down(:, :, this%quarter(a)), &
                                                tree%boxes%level(l - 1)%field(:, this%parent(a): &
                                                this%parent(a)), terms, 1, this%field(:, a:a))
        end do
        do shift = -24, 24
          n = 0
          do a = begin, min(begin + batch - 1, this%boxes)
            b = this%partner(shift, a)
            if (b == 0) cycle
            n = n + 1
            into(n) = a
            panel(:, n) = this%moment(:terms, b)
          end do
          call multiply(tree%ways%across(:, :, shift), panel, terms, n, part)
          do b = 1, n
            this%field(:, into(b)) = this%field(:, into(b)) + part(:, b) / this%half
          end do
        end do
      end do
      !$omp end parallel do
    end associate
  end subroutine fall

  pure function middle_of(boxes, l, a) result(middle)
    type(box_tree), intent(in) :: boxes
    integer, intent(in) :: l, a
    real(real64) :: middle(2)

    middle = boxes%corner + (2 * boxes%level(l)%cell(:, a) + 1) * boxes%level(l)%half
  end function middle_of

end module asperity_source_tree
