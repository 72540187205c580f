!> Sums of 1/r over many sources in a plane at many targets, in time proportional to their number.
!>
!> Source j is a circle with the charge q_j and the second moment w_j [length**2], a quarter of the
!> mean square of the radius at which the charge lies. Its potential at a distance r is
!> q_j (1 + w_j Laplacian) 1/r = q_j (1/r + w_j/r**3). Sources near a target, by the reaches of
!> both, are listed for the caller and not summed. All others are: those in touching boxes directly
!> (P2P), those in other boxes by expansions (fast multipole method, asperity_box_expansions).
module asperity_source_tree
  use asperity_box_expansions, only: add_dipole, add_field, add_moments, add_translated, l2l, &
                                     lanes, m2m, prepare_translations, translations
  use asperity_box_tree, only: as_source, as_target, build_boxes, first_point, last_own_point, &
                               last_point, square_box
  use asperity_kinds, only: int64, real32, real64
  use asperity_process, only: check_memory
  implicit none
  private

  public :: source_tree, build_tree, sum_sources

  ! Number of targets above which threads share the work (chosen).
  integer, parameter :: thread_threshold = 512
  ! Memory [bytes] of a point without its list of near sources (measured: 210 for each of a million
  ! points that are sources and targets, uniform over a square, 200 in clusters).
  integer(int64), parameter :: bytes_per_point = 200_int64
  character(*), parameter :: purpose = 'the sum over all contacts'
  ! Columns of `source_tree%points`: position at which the tree was built, reach times near_factor;
  ! then position in the sum, charge, second moment and dipole. While near sources are listed, the
  ! fourth column is the index of the point.
  integer, parameter :: listed_x = 1, listed_y = 2, listed_reach = 3, point_index = 4
  integer, parameter :: shifted_x = 4, shifted_y = 5, point_charge = 6, point_moment = 7, &
                        dipole_x = 8, dipole_y = 9

  ! Sources near the targets of a box, target by target.
  type :: near_list
    integer, allocatable :: near(:)
  end type near_list

  !> Sources and targets, sorted into boxes.
  type :: source_tree
    !> index in `near` of the first source near each target, and one index more
    integer, allocatable :: first(:)
    !> sources near each target, without itself, in the order of the boxes
    integer, allocatable :: near(:)
    !> error message if there was no memory for the tree, else not allocated
    character(:), allocatable :: failure
    !> of expansions: the same for all trees, kept once a sum has prepared them
    type(translations) :: translation
    ! Number of sources, which are the first points; index of the point before the first target.
    integer, private :: sources = 0, target_offset = 0
    ! In the order of the boxes: the original indices, and the points (point, column).
    integer, allocatable, private :: order(:)
    real(real64), allocatable, private :: points(:, :)
    type(square_box), allocatable, private :: boxes(:)
    ! First box of each level, and the number of boxes plus 1.
    integer, allocatable, private :: level_start(:)
    ! (term, box): moments of the sources of a box, and expansion of the far field in it.
    real(real64), allocatable, private :: moment(:, :), field(:, :)
  end type source_tree

contains

  !> Sorts points into boxes and lists the sources near each target.
  subroutine build_tree(tree, x, y, reach, near_factor, sources)
    type(source_tree), intent(inout) :: tree  !! the tree; translations are kept
    real(real64), intent(in) :: x(:)         !! positions x of all points [length]
    real(real64), intent(in) :: y(:)         !! positions y of all points [length]
    real(real64), intent(in) :: reach(:)     !! reaches of all points, 0 or more [length]
    !> two points are near if their distance is below this times the sum of their reaches
    real(real64), intent(in) :: near_factor
    !> number of sources, the first points; the others are the targets; absent: each point is both,
    !> and has no effect on itself
    integer, intent(in), optional :: sources

    tree%sources = size(x)
    tree%target_offset = 0
    if (present(sources)) then
      tree%sources = sources
      tree%target_offset = sources
    end if
    if (allocated(tree%failure)) deallocate (tree%failure)
    if (allocated(tree%near)) deallocate (tree%near)
    if (allocated(tree%points)) deallocate (tree%points)
    if (allocated(tree%moment)) deallocate (tree%moment, tree%field)
    call check_memory(purpose, tree%failure, bytes=bytes_per_point * size(x))
    if (allocated(tree%failure)) return
    tree%first = [1, spread(0, 1, size(x) - tree%target_offset)]
    allocate (tree%near(0))
    allocate (tree%points(size(x), dipole_y))
    tree%points(:, listed_x) = x
    tree%points(:, listed_y) = y
    tree%points(:, listed_reach) = near_factor * reach
    call build_boxes(tree%points(:, :listed_reach), tree%sources, size(x) - tree%target_offset, &
                     tree%order, tree%boxes, tree%level_start)
    call list_near(tree)
  end subroutine build_tree

  ! Sets `first` and `near` by lists of the targets of each box.
  subroutine list_near(tree)
    type(source_tree), intent(inout) :: tree
    type(near_list), allocatable :: lists(:)
    integer :: a, i, k, n
    integer(int64) :: pairs

    tree%points(:, point_index) = tree%order
    allocate (lists(size(tree%boxes)))
    !$omp parallel do schedule(dynamic, 16) &
    !$omp   if(size(tree%first) > thread_threshold .and. size(lists) > 1)
    do a = 1, size(lists)
      call list_box(a, lists(a)%near)
    end do
    !$omp end parallel do
    pairs = sum(int(tree%first(2:), int64))
    call check_memory(purpose, tree%failure, merge(0, 1, pairs < huge(i)), 4_int64 * pairs)
    if (allocated(tree%failure)) return
    deallocate (tree%near)
    allocate (tree%near(pairs))
    do i = 2, size(tree%first)
      tree%first(i) = tree%first(i) + tree%first(i - 1)
    end do
    do a = 1, size(lists)
      n = 0
      do i = tree%boxes(a)%points(first_point, as_target), &
             tree%boxes(a)%points(last_own_point, as_target)
        k = tree%order(i) - tree%target_offset
        tree%near(tree%first(k):tree%first(k + 1) - 1) = &
          lists(a)%near(n + 1:n + tree%first(k + 1) - tree%first(k))
        n = n + tree%first(k + 1) - tree%first(k)
      end do
    end do

  contains

    ! Lists the near sources of the targets of a box, target by target, and counts them.
    subroutine list_box(a, near)
      integer, intent(in) :: a
      integer, allocatable, intent(out) :: near(:)
      real(real64), allocatable :: source(:, :)
      integer, allocatable :: is_near(:)
      integer :: first, i, j, last, listed, n

      first = tree%boxes(a)%points(first_point, as_target)
      last = tree%boxes(a)%points(last_own_point, as_target)
      if (last < first) return
      allocate (source, source=touching_sources(tree, a, point_index))
      allocate (is_near(size(source, 1)))
      allocate (near(size(source, 1)))
      n = 0
      do i = first, last
        listed = n
        !$omp simd
        do j = 1, size(source, 1)
          is_near(j) = merge(1, 0, (source(j, listed_x) - tree%points(i, listed_x))**2 + &
                             (source(j, listed_y) - tree%points(i, listed_y))**2 < &
                             (source(j, listed_reach) + tree%points(i, listed_reach))**2 .and. &
                             abs(source(j, point_index) - tree%order(i)) > 0.5_real64)
        end do
        if (n + size(is_near) > size(near)) near = [near, spread(0, 1, size(near) + size(is_near))]
        do j = 1, size(is_near)
          near(n + 1) = int(source(j, point_index))
          n = n + is_near(j)
        end do
        tree%first(tree%order(i) - tree%target_offset + 1) = n - listed
      end do
      near = near(:n)
    end subroutine list_box

  end subroutine list_near

  ! The first columns of the sources that are summed directly for the targets that belong to a box
  ! and to none of its children: those in the boxes that touch it or one of its ancestors.
  pure function touching_sources(tree, box, columns) result(source)
    type(source_tree), intent(in) :: tree
    integer, intent(in) :: box, columns  ! index of the box; number of columns
    real(real64), allocatable :: source(:, :)
    integer :: bounds(2, 9 * size(tree%level_start)), a, column, i, last, n, row

    n = 0
    a = box
    last = last_point
    do while (a > 0)
      do row = -1, 1
        do column = -1, 1
          i = tree%boxes(a)%neighbour(column, row)
          if (i == 0) cycle
          n = n + 1
          bounds(:, n) = tree%boxes(i)%points([first_point, last], as_source)
        end do
      end do
      ! Beside an ancestor only the sources that belong to none of the children: those of the
      ! children are summed by boxes of the levels below.
      last = last_own_point
      a = tree%boxes(a)%parent
    end do
    allocate (source(sum(bounds(2, :n) - bounds(1, :n) + 1), columns))
    a = 0
    do i = 1, n
      source(a + 1:a + 1 + bounds(2, i) - bounds(1, i), :) = &
        tree%points(bounds(1, i):bounds(2, i), :columns)
      a = a + 1 + bounds(2, i) - bounds(1, i)
    end do
  end function touching_sources

  !> Sums the potentials of all sources that are not near each target.
  !>
  !> Shifts change positions, but not which sources are near and which are summed directly: all sums
  !> are smooth functions of charges and shifts. Shifts must be small against the reaches. Targets
  !> that are the sources are shifted with them. The Laplacian, the slopes and the second
  !> derivatives include the second moments. Without expansions all sums are exact.
  subroutine sum_sources(tree, charge, second_moment, value, shift, low_order, dipole, places)
    type(source_tree), intent(inout) :: tree           !! tree of the sources
    real(real64), intent(in) :: charge(:)              !! charges q of the sources
    real(real64), intent(in) :: second_moment(:)       !! w of the sources, at most reach**2
    !> (6, target): potential, its Laplacian in the plane, its slopes in x and y, half of the
    !! difference of its second derivatives in x and in y, its mixed second derivative
    real(real64), intent(out) :: value(:, :)
    real(real64), intent(in), optional :: shift(:, :)  !! (2, source): shifts in x and y [length]
    !> whether only the potential and its slopes are summed, to about 1e-4, as means over the target
    !! by its second moment; without expansions all values are summed, exactly
    logical, intent(in), optional :: low_order
    !> (2, source), only with `low_order`: dipoles d of the sources, with the potential
    !! d * (x - x_j)/r**3
    real(real64), intent(in), optional :: dipole(:, :)
    !> (2, target), only with `low_order` and several boxes: x and y of targets in place of those of
    !! the tree [length]; potentials of positive charges are lower bounds there
    real(real64), intent(in), optional :: places(:, :)
    real(real64), allocatable :: source(:, :)
    integer :: a, columns, i, k, terms
    logical :: is_low_order

    if (size(tree%level_start) > 3 .and. .not. allocated(tree%moment)) then
      if (.not. allocated(tree%translation%entry)) call prepare_translations(tree%translation)
      allocate (tree%moment(tree%translation%terms, size(tree%boxes)), &
                tree%field(tree%translation%terms, size(tree%boxes)))
    end if
    terms = merge(tree%translation%terms, 0, allocated(tree%moment))
    is_low_order = .false.
    if (present(low_order)) is_low_order = low_order .and. terms > 0
    if (is_low_order) terms = tree%translation%low_order_terms
    columns = merge(dipole_y, point_moment, is_low_order .or. present(dipole))
    if (size(tree%boxes) == 1) then
      do i = 1, size(tree%order)
        ! An absent array that is passed on here has bounds that nothing has set.
        call set_point(tree, i, charge, second_moment)
        k = tree%order(i)
        if (k > tree%sources) cycle
        associate (point => tree%points(i, :))
          if (present(shift)) point(shifted_x:shifted_y) = point(shifted_x:shifted_y) + shift(:, k)
          if (present(dipole)) point(dipole_x:dipole_y) = dipole(:, k)
        end associate
      end do
      call sum_one_box(tree, columns, present(dipole), value)
      return
    end if
    !$omp parallel private(source, a, i, k) if(size(tree%order) > thread_threshold)
    !$omp do
    do i = 1, size(tree%order)
      call set_point(tree, i, charge, second_moment, shift, dipole)
    end do
    !$omp end do
    do i = size(tree%level_start) - 1, 3, -1
      call gather_moments(tree, i, terms, present(dipole))
    end do
    do i = 3, size(tree%level_start) - 1
      call distribute_fields(tree, i, terms)
    end do
    if (present(places)) then
      call sum_at_places(tree, places, terms, value)
    else
      !$omp do schedule(dynamic, 16)
      do a = 1, size(tree%boxes)
        associate (own => tree%boxes(a)%points(:, as_target))
          if (own(last_own_point) < own(first_point)) cycle
          source = touching_sources(tree, a, columns)
          do i = own(first_point), own(last_own_point)
            k = tree%order(i) - tree%target_offset
            if (is_low_order .or. present(dipole)) then
              value(:, k) = dipole_sum(source, tree%points(i, :))
            else
              value(:, k) = direct_sum(source, tree%points(i, :))
            end if
            call add_far_field(tree, a, terms, tree%points(i, shifted_x:shifted_y), value(:, k))
          end do
        end associate
      end do
      !$omp end do
    end if
    !$omp end parallel
  end subroutine sum_sources

  ! Adds the field of a box at a place in it.
  pure subroutine add_far_field(tree, a, terms, place, value)
    type(source_tree), intent(in) :: tree
    integer, intent(in) :: a, terms   ! box, terms of its field
    real(real64), intent(in) :: place(2)
    real(real64), intent(inout) :: value(:)

    ! All boxes of the first two levels touch: they have no far field.
    if (a < tree%level_start(min(3, size(tree%level_start)))) return
    associate (box => tree%boxes(a))
      call add_field(tree%translation, (place - box%centre) / box%half_width, box%half_width, &
                     tree%field(:terms, a), value)
    end associate
  end subroutine add_far_field

  ! Sums of low order at any places; potentials of positive charges are lower bounds but for the
  ! error of the expansions. The sources that are summed directly are left out beside the boxes, and
  ! in boxes where no child is. The square of a distance is increased by 1e-4 squares of the half
  ! width of the box, far above its rounding error. All threads call it together.
  subroutine sum_at_places(tree, places, terms, value)
    type(source_tree), intent(in) :: tree
    real(real64), intent(in) :: places(:, :)
    integer, intent(in) :: terms
    real(real64), intent(inout) :: value(:, :)
    real(real64), allocatable :: source(:, :)
    real(real32), allocatable :: near_box(:, :)
    integer :: a, b, last, k

    last = 0
    a = 1
    !$omp do schedule(dynamic, 64)
    do k = 1, size(places, 2)
      value(:, k) = 0.0_real64
      if (.not. is_inside(tree%boxes(a), places(:, k))) a = 1
      if (.not. is_inside(tree%boxes(a), places(:, k))) cycle
      do
        do b = tree%boxes(a)%children(1), tree%boxes(a)%children(2)
          if (is_inside(tree%boxes(b), places(:, k))) exit
        end do
        if (b > tree%boxes(a)%children(2)) exit
        a = b
      end do
      associate (box => tree%boxes(a))
        if (box%children(2) == 0) then
          if (a /= last) then
            source = touching_sources(tree, a, point_charge)
            near_box = real(reshape([(source(:, shifted_x) - box%centre(1)) / box%half_width, &
                                     (source(:, shifted_y) - box%centre(2)) / box%half_width, &
                                     (source(:, listed_reach) / box%half_width)**2, &
                                     source(:, point_charge) / box%half_width], &
                                    [size(source, 1), 4]), real32)
          end if
          last = a
          value([1, 3, 4], k) = rough_sum(near_box, real((places(:, k) - box%centre) / &
                                                         box%half_width, real32))
          value(3:4, k) = value(3:4, k) / box%half_width
        end if
      end associate
      call add_far_field(tree, a, terms, places(:, k), value(:, k))
    end do
    !$omp end do
  end subroutine sum_at_places

  ! Whether a place is in a box.
  pure logical function is_inside(box, place)
    type(square_box), intent(in) :: box
    real(real64), intent(in) :: place(2)

    is_inside = all(abs(place - box%centre) <= box%half_width)
  end function is_inside

  ! Potential and slopes by sources that are not near, lengths over the half width of a box.
  pure function rough_sum(source, place) result(value)
    real(real32), contiguous, intent(in) :: source(:, :)  ! x, y, reach**2, charge
    real(real32), intent(in) :: place(2)
    real(real32) :: value(3), phi, slope_x, slope_y, dx, dy, charge, root, square
    integer :: k

    phi = 0.0_real32
    slope_x = 0.0_real32
    slope_y = 0.0_real32
    !$omp simd reduction(+:phi, slope_x, slope_y) private(dx, dy, charge, root, square)
    do k = 1, size(source, 1)
      dx = place(1) - source(k, 1)
      dy = place(2) - source(k, 2)
      square = dx**2 + dy**2
      charge = source(k, 4) * (0.5_real32 + sign(0.5_real32, square - source(k, 3)))
      square = 1.0_real32 / (square + 1.0e-4_real32)
      root = charge * sqrt(square)
      phi = phi + root
      root = root * square
      slope_x = slope_x - root * dx
      slope_y = slope_y - root * dy
    end do
    value = [phi, slope_x, slope_y]
  end function rough_sum

  ! Sums over the points of one box, for which a team of threads, and boxes, take longer. It is no
  ! internal procedure: an absent array that such a one names has no bounds in its host.
  subroutine sum_one_box(tree, columns, has_dipoles, value)
    type(source_tree), intent(in) :: tree  ! its points are set
    integer, intent(in) :: columns         ! of a source
    logical, intent(in) :: has_dipoles
    real(real64), intent(inout) :: value(:, :)
    real(real64), allocatable :: source(:, :)
    integer :: i, k

    allocate (source, source=tree%points(:tree%sources, :columns))
    do i = tree%target_offset + 1, size(tree%order)
      k = tree%order(i) - tree%target_offset
      if (has_dipoles) then
        value(:, k) = dipole_sum(source, tree%points(i, :))
      else
        value(:, k) = direct_sum(source, tree%points(i, :))
      end if
    end do
  end subroutine sum_one_box

  ! Sets the position, charge, second moment and dipole of a point in the sum; targets have none.
  subroutine set_point(tree, i, charge, second_moment, shift, dipole)
    type(source_tree), intent(inout) :: tree
    integer, intent(in) :: i
    real(real64), intent(in) :: charge(:), second_moment(:)
    real(real64), intent(in), optional :: shift(:, :), dipole(:, :)

    associate (k => tree%order(i), point => tree%points(i, :))
      point(shifted_x:) = 0.0_real64
      point(shifted_x:shifted_y) = point(listed_x:listed_y)
      if (k > tree%sources) return
      point(point_charge:point_moment) = [charge(k), second_moment(k)]
      if (present(shift)) point(shifted_x:shifted_y) = point(shifted_x:shifted_y) + shift(:, k)
      if (present(dipole)) point(dipole_x:dipole_y) = dipole(:, k)
    end associate
  end subroutine set_point

  ! Values at a target by direct summation over sources that are not near by the positions at which
  ! the tree was built, which also leaves out the target itself.
  pure function direct_sum(source, point) result(value)
    real(real64), contiguous, intent(in) :: source(:, :)
    real(real64), intent(in) :: point(:)
    real(real64) :: value(6), phi, laplacian, slope_x, slope_y, anisotropy, mixed, factor, dx, dy
    real(real64) :: inverse_square, charge, moment, third, fifth
    integer :: k

    phi = 0.0_real64
    laplacian = 0.0_real64
    slope_x = 0.0_real64
    slope_y = 0.0_real64
    anisotropy = 0.0_real64
    mixed = 0.0_real64
    !$omp simd reduction(+:phi, laplacian, slope_x, slope_y, anisotropy, mixed) &
    !$omp   private(factor, dx, dy, inverse_square, charge, moment, third, fifth)
    do k = 1, size(source, 1)
      ! 1, or 0 if the source is near or, without reaches, at the same position.
      factor = 0.5_real64 + sign(0.5_real64, &
        (source(k, listed_x) - point(listed_x))**2 + (source(k, listed_y) - point(listed_y))**2 - &
        ((source(k, listed_reach) + point(listed_reach))**2 + tiny(point)))
      dx = point(shifted_x) - source(k, shifted_x)
      dy = point(shifted_y) - source(k, shifted_y)
      inverse_square = 1.0_real64 / ((dx**2 + dy**2) * factor + (1.0_real64 - factor))
      charge = source(k, point_charge) * factor
      moment = charge * source(k, point_moment) * inverse_square
      third = sqrt(inverse_square)
      phi = phi + (charge + moment) * third
      third = third * inverse_square
      laplacian = laplacian + (charge + 9.0_real64 * moment) * third
      fifth = (3.0_real64 * charge + 15.0_real64 * moment) * third * inverse_square
      third = (charge + 3.0_real64 * moment) * third
      slope_x = slope_x - third * dx
      slope_y = slope_y - third * dy
      anisotropy = anisotropy + 0.5_real64 * fifth * (dx**2 - dy**2)
      mixed = mixed + fifth * dx * dy
    end do
    value = [phi, laplacian, slope_x, slope_y, anisotropy, mixed]
  end function direct_sum

  ! Potential and slopes at a target as by `direct_sum`, without terms in 1/r**5, as means over the
  ! target by its second moment, with dipoles. The lower limit of the square of a distance is for
  ! those that shifts have made small.
  pure function dipole_sum(source, point) result(value)
    real(real64), contiguous, intent(in) :: source(:, :)
    real(real64), intent(in) :: point(:)
    real(real64) :: value(6), phi, slope_x, slope_y, dipole, charge, factor, dx, dy, square, third
    integer :: k

    phi = 0.0_real64
    slope_x = 0.0_real64
    slope_y = 0.0_real64
    !$omp simd reduction(+:phi, slope_x, slope_y) &
    !$omp   private(dipole, charge, factor, dx, dy, square, third)
    do k = 1, size(source, 1)
      factor = 0.5_real64 + sign(0.5_real64, &
        (source(k, listed_x) - point(listed_x))**2 + (source(k, listed_y) - point(listed_y))**2 - &
        ((source(k, listed_reach) + point(listed_reach))**2 + tiny(point)))
      dx = point(shifted_x) - source(k, shifted_x)
      dy = point(shifted_y) - source(k, shifted_y)
      square = (dx**2 + dy**2) * factor + (1.0_real64 - factor)
      square = 1.0_real64 / max(square - 2.0_real64 * &
                                (source(k, point_moment) + point(point_moment)), &
                                0.5_real64 * square)
      charge = source(k, point_charge) * factor
      third = sqrt(square)
      dipole = (source(k, dipole_x) * dx + source(k, dipole_y) * dy) * square * factor
      phi = phi + (charge + dipole) * third
      third = third * square
      slope_x = slope_x + (source(k, dipole_x) * factor - &
                           (charge + 3.0_real64 * dipole) * dx) * third
      slope_y = slope_y + (source(k, dipole_y) * factor - &
                           (charge + 3.0_real64 * dipole) * dy) * third
    end do
    value = [phi, 0.0_real64, slope_x, slope_y, 0.0_real64, 0.0_real64]
  end function dipole_sum

  ! Upward pass for one level: sets the moments of its boxes from those of their children (M2M) and
  ! from the sources that belong to no child (P2M). All threads call it together.
  subroutine gather_moments(tree, level, terms, with_dipoles)
    type(source_tree), intent(inout) :: tree
    integer, intent(in) :: level, terms
    logical, intent(in) :: with_dipoles
    real(real64) :: sums(lanes, terms)
    integer :: a, b, first_box, i, source_box(0:3, lanes)

    !$omp do schedule(dynamic)
    do first_box = tree%level_start(level), tree%level_start(level + 1) - 1, lanes
      source_box = 0
      do a = first_box, min(first_box + lanes, tree%level_start(level + 1)) - 1
        do b = tree%boxes(a)%children(1), tree%boxes(a)%children(2)
          source_box(tree%boxes(b)%quadrant, a - first_box + 1) = b
        end do
      end do
      sums = 0.0_real64
      call add_translated(tree%translation, m2m, tree%moment, source_box, sums)
      do a = first_box, min(first_box + lanes, tree%level_start(level + 1)) - 1
        associate (box => tree%boxes(a))
          tree%moment(:terms, a) = sums(a - first_box + 1, :)
          do i = box%points(first_point, as_source), box%points(last_own_point, as_source)
            ! Fields of low order have no Laplacian: without second moments the effects of two
            ! circles on each other stay symmetric.
            call add_moments( &
              tree%translation, &
              (tree%points(i, shifted_x:shifted_y) - box%centre) / box%half_width, &
              tree%points(i, point_charge), &
              merge(tree%points(i, point_moment) / box%half_width**2, 0.0_real64, &
                    terms == tree%translation%terms), tree%moment(:terms, a))
            if (with_dipoles) call add_dipole( &
              tree%translation, &
              (tree%points(i, shifted_x:shifted_y) - box%centre) / box%half_width, &
              tree%points(i, dipole_x:dipole_y) / box%half_width, tree%moment(:terms, a))
          end do
        end associate
      end do
    end do
    !$omp end do
  end subroutine gather_moments

  ! Downward pass for one level: sets the fields in its boxes by the moments of the boxes that do
  ! not touch them while their parents touch (M2L), and by the field in the parent (L2L). All
  ! threads call it together.
  subroutine distribute_fields(tree, level, terms)
    type(source_tree), intent(inout) :: tree
    integer, intent(in) :: level, terms
    real(real64) :: sums(lanes, terms)
    integer :: a, column, first_box, n, row, source_box(0:3, lanes)

    !$omp do schedule(dynamic)
    do first_box = tree%level_start(level), tree%level_start(level + 1) - 1, lanes
      n = min(lanes, tree%level_start(level + 1) - first_box)
      source_box = 0
      sums = 0.0_real64
      do row = 0, 3
        do column = 0, 3
          if (max(row, column) < 2) cycle
          do a = 1, n
            associate (box => tree%boxes(first_box + a - 1))
              source_box(:, a) = [box%neighbour(column, row), box%neighbour(-column, row), &
                                  box%neighbour(column, -row), box%neighbour(-column, -row)]
            end associate
          end do
          if (column == 0) source_box(1::2, :) = 0
          if (row == 0) source_box(2:, :) = 0
          call add_translated(tree%translation, 4 * row + column, tree%moment, source_box, sums)
        end do
      end do
      sums = sums / tree%boxes(first_box)%half_width
      if (level > 3) then
        source_box = 0
        do a = 1, n
          associate (box => tree%boxes(first_box + a - 1))
            source_box(box%quadrant, a) = box%parent
          end associate
        end do
        call add_translated(tree%translation, l2l, tree%field, source_box, sums)
      end if
      tree%field(:terms, first_box:first_box + n - 1) = transpose(sums(:n, :))
    end do
    !$omp end do
  end subroutine distribute_fields

end module asperity_source_tree
