!> Sums of 1/r of many sources in a plane at many places, in time proportional to their number.
!>
!> Source j is a circle with charge q_j and spread w_j, whose potential is q_j (1 + w_j Laplacian)
!> 1/r = q_j (1/r + w_j / r**3). Circles that are near each other, by the reaches they are planted
!> with, are left to the caller and listed; all others are summed, those in boxes that touch place
!> by place, those in other boxes by expansions (a fast multipole method, see
!> asperity_box_expansions).
module asperity_source_tree
  use asperity_box_expansions, only: add_field, add_moments, expand, expansion, multiply
  use asperity_box_tree, only: box_tree, plant_boxes
  use asperity_kinds, only: real64
  use asperity_near_circles, only: near_pairs
  implicit none
  private

  public :: source_tree, plant_tree, sum_sources

  ! Degree of the expansions.
  integer, parameter :: order = 7
  ! Boxes whose translations are made together, and fewest places for which threads are started.
  integer, parameter :: batch = 64, many = 512

  !> Sources and targets at their places.
  type :: source_tree
    !> where the near sources of a target begin in `near`
    integer, allocatable :: first(:)
    !> sources near each target, ascending; not the target itself
    integer, allocatable :: near(:)
    !> why the tree could not be planted; not allocated when all is well
    character(:), allocatable :: failure
    type(box_tree), private :: boxes
    type(expansion), private :: terms
    ! Places and limits of nearness in the order of the boxes.
    real(real64), allocatable, private :: source(:, :), target(:, :)
  end type source_tree

  ! Moments of the boxes of a level and their fields.
  type :: box_values
    real(real64), allocatable :: moment(:, :), field(:, :)
  end type box_values

  ! Sources as they are summed: planted place and limit; place, charge, charge times spread.
  integer, parameter :: numbers = 7

  character(*), parameter :: no_memory = 'no memory for the sum over all contacts'

contains

  !> Plants the places of sources and targets and finds their near pairs.
  subroutine plant_tree(tree, x_source, y_source, reach_source, near_factor, x_target, y_target, &
                        reach_target)
    type(source_tree), intent(out) :: tree                     !! the tree
    real(real64), contiguous, intent(in) :: x_source(:)        !! places
    real(real64), contiguous, intent(in) :: y_source(:)        !! places
    real(real64), contiguous, intent(in) :: reach_source(:)    !! reaches, none negative
    !> circles nearer than this times the sum of their reaches are near
    real(real64), intent(in) :: near_factor
    !> places of targets; absent: targets are the sources, and none acts on itself
    real(real64), contiguous, intent(in), optional :: x_target(:)
    real(real64), contiguous, intent(in), optional :: y_target(:)      !! places of targets
    real(real64), contiguous, intent(in), optional :: reach_target(:)  !! reaches of targets
    integer :: status

    if (present(x_target)) then
      call plant(x_target, y_target, near_factor * reach_target, .false.)
    else
      call plant(x_source, y_source, near_factor * reach_source, .true.)
    end if
    if (status /= 0) tree%failure = no_memory

  contains

    subroutine plant(x, y, reach, same)
      real(real64), contiguous, intent(in) :: x(:), y(:), reach(:)
      logical, intent(in) :: same
      real(real64), allocatable :: limit(:)

      allocate (limit(size(reach_source)))
      limit(:) = near_factor * reach_source
      call near_pairs(x_source, y_source, limit, x, y, reach, same, tree%first, tree%near, status)
      if (status /= 0) return
      call plant_boxes(x_source, y_source, limit, x, y, reach, same, tree%boxes, status)
      if (status /= 0) return
      if (tree%boxes%top <= tree%boxes%last) call expand(order, tree%terms, status)
      if (status /= 0 .or. .not. allocated(tree%boxes%source_order)) return
      allocate (tree%source(3, size(limit)), tree%target(3, size(x)), stat=status)
      if (status /= 0) return
      associate (s => tree%boxes%source_order, t => tree%boxes%target_order)
        tree%source(1, :) = x_source(s)
        tree%source(2, :) = y_source(s)
        tree%source(3, :) = limit(s)
        tree%target(1, :) = x(t)
        tree%target(2, :) = y(t)
        tree%target(3, :) = reach(t)
      end associate
    end subroutine plant
  end subroutine plant_tree

  !> Sums over all sources that are not near.
  !>
  !> Moves shift places without a change of what is near and of what is summed how: all sums are
  !> smooth functions of charges and moves, which must be small against the reaches. Slopes and
  !> Laplacian are those of the potential with its spread.
  subroutine sum_sources(tree, charge, spread, potential, lap, slope_x, slope_y, move_x, move_y, &
                         target_move_x, target_move_y)
    type(source_tree), intent(inout) :: tree                   !! the tree; its `failure` is set
    real(real64), contiguous, intent(in) :: charge(:)          !! of sources
    real(real64), contiguous, intent(in) :: spread(:)          !! of sources, a length squared
    real(real64), contiguous, intent(out) :: potential(:)      !! at targets
    real(real64), contiguous, intent(out), optional :: lap(:)  !! its Laplacian in the plane
    real(real64), contiguous, intent(out), optional :: slope_x(:)        !! its slope; both or none
    real(real64), contiguous, intent(out), optional :: slope_y(:)        !! its slope
    real(real64), contiguous, intent(in), optional :: move_x(:)          !! of sources
    real(real64), contiguous, intent(in), optional :: move_y(:)          !! of sources
    real(real64), contiguous, intent(in), optional :: target_move_x(:)   !! of targets
    real(real64), contiguous, intent(in), optional :: target_move_y(:)   !! of targets
    type(box_values), allocatable :: values(:)
    real(real64), allocatable :: source(:, :), target(:, :), sums(:, :)
    integer :: status, l, i, j

    status = 0

    if (allocated(tree%source)) then
      allocate (source(numbers, size(charge)), target(5, size(potential)), &
                values(0:tree%boxes%last), sums(merge(4, 2, present(slope_x)), size(potential)), stat=status)
      if (status == 0) call make_room(tree, values, status)
    else
      allocate (sums(4, size(potential)), stat=status)
    end if
    if (status /= 0) tree%failure = no_memory
    if (status /= 0) return
    sums = 0.0_real64
    if (allocated(tree%source)) then
      source(:5, :) = tree%source([1, 2, 3, 1, 2], :)
      target(:, :) = tree%target([1, 2, 3, 1, 2], :)
      associate (s => tree%boxes%source_order, t => tree%boxes%target_order)
        source(6, :) = charge(s)
        source(7, :) = charge(s) * spread(s)
        if (present(move_x)) source(4, :) = source(4, :) + move_x(s)
        if (present(move_y)) source(5, :) = source(5, :) + move_y(s)
        if (present(target_move_x)) target(4, :) = target(4, :) + target_move_x(t)
        if (present(target_move_y)) target(5, :) = target(5, :) + target_move_y(t)
      end associate
      do l = tree%boxes%last, tree%boxes%top, -1
        call rise(tree, l, source, values)
      end do
      do l = tree%boxes%top, tree%boxes%last
        call fall(tree, l, values)
      end do
      do l = 0, tree%boxes%last
        call evaluate(tree, l, source, target, values(l)%field, sums)
      end do
    end if
    do i = 1, size(potential)
      j = i
      if (allocated(tree%boxes%target_order)) j = tree%boxes%target_order(i)
      potential(j) = sums(1, i)
      if (present(lap)) lap(j) = sums(2, i)
      if (present(slope_x)) slope_x(j) = sums(3, i)
      if (present(slope_y)) slope_y(j) = sums(4, i)
    end do
  end subroutine sum_sources

  ! Moments and fields of all boxes that can act by them.
  pure subroutine make_room(tree, values, status)
    type(source_tree), intent(in) :: tree
    type(box_values), intent(inout) :: values(0:)
    integer, intent(out) :: status
    integer :: l, terms

    status = 0

    do l = 0, tree%boxes%last
      terms = merge(tree%terms%terms, 0, l >= tree%boxes%top)
      allocate (values(l)%moment(terms, tree%boxes%level(l)%boxes), &
                values(l)%field(terms, tree%boxes%level(l)%boxes), stat=status)
      if (status /= 0) return
    end do
  end subroutine make_room

  ! Moments of the boxes of a level, from their children and from what is in none.
  subroutine rise(tree, l, source, values)
    type(source_tree), intent(in) :: tree
    integer, intent(in) :: l
    real(real64), intent(in) :: source(:, :)
    type(box_values), intent(inout) :: values(0:)
    real(real64), allocatable :: part(:, :)
    real(real64) :: middle(2)
    integer :: a, b, j

    !$omp parallel private(part, middle, a, b, j) if(size(source, 2) > many)
    allocate (part(tree%terms%terms, 1))
    !$omp do schedule(static, 16)
    do a = 1, tree%boxes%level(l)%boxes
      associate (this => tree%boxes%level(l), moment => values(l)%moment)
        moment(:, a) = 0.0_real64
        middle = middle_of(tree, l, a)
        do j = this%source(1, a), this%source(2, a)
          call add_moments(tree%terms, source(4, j) - middle(1), source(5, j) - middle(2), &
                           this%half, source(6, j), source(7, j), moment(:, a))
        end do
        do b = this%child(a), this%child(a + 1) - 1
          call multiply(tree%terms%up(:, :, quarter(tree%boxes%level(l + 1)%cell(:, b))), &
                        values(l + 1)%moment(:, b:b), 1, part)
          moment(:, a) = moment(:, a) + part(:, 1)
        end do
      end associate
    end do
    !$omp end do
    !$omp end parallel
  end subroutine rise

  ! Fields in the boxes of a level: from the box around, and from boxes that act as a whole.
  subroutine fall(tree, l, values)
    type(source_tree), intent(in) :: tree
    integer, intent(in) :: l
    type(box_values), intent(inout) :: values(0:)
    real(real64), allocatable :: panel(:, :), part(:, :)
    integer :: begin, a, b, n, shift, into(batch)

    !$omp parallel private(panel, part, begin, a, b, n, shift, into) &
    !$omp if(tree%boxes%level(l)%boxes > batch)
    allocate (panel(tree%terms%terms, batch), part(tree%terms%terms, batch))
    !$omp do schedule(static, 1)
    do begin = 1, tree%boxes%level(l)%boxes, batch
      associate (this => tree%boxes%level(l), field => values(l)%field)
        do a = begin, min(begin + batch - 1, this%boxes)
          field(:, a) = 0.0_real64
          if (l == tree%boxes%top) cycle
          b = this%parent(a)
          call multiply(tree%terms%down(:, :, quarter(this%cell(:, a))), &
                        values(l - 1)%field(:, b:b), 1, part)
          field(:, a) = part(:, 1)
        end do
        do shift = lbound(this%partner, 1), ubound(this%partner, 1)
          n = 0
          do a = begin, min(begin + batch - 1, this%boxes)
            b = this%partner(shift, a)
            if (b == 0) cycle
            n = n + 1
            into(n) = a
            panel(:, n) = values(l)%moment(:, b)
          end do
          if (n == 0) cycle
          call multiply(tree%terms%across(:, :, shift), panel, n, part)
          do b = 1, n
            field(:, into(b)) = field(:, into(b)) + part(:, b) / this%half
          end do
        end do
      end associate
    end do
    !$omp end do
    !$omp end parallel
  end subroutine fall

  ! Sums at the targets of a level that are in no smaller box.
  subroutine evaluate(tree, l, source, target, field, sums)
    type(source_tree), intent(in) :: tree
    integer, intent(in) :: l
    real(real64), intent(in) :: source(:, :), target(:, :), field(:, :)
    real(real64), intent(inout) :: sums(:, :)
    real(real64), allocatable :: about(:, :)
    real(real64) :: middle(2)
    integer :: a, i, n

    !$omp parallel private(about, middle, a, i, n) if(size(target, 2) > many)
    allocate (about(1024, numbers))
    !$omp do schedule(static, 16)
    do a = 1, tree%boxes%level(l)%boxes
      associate (this => tree%boxes%level(l))
        if (this%target(2, a) < this%target(1, a)) cycle
        call gather(tree%boxes, l, a, source, about, n)
        middle = middle_of(tree, l, a)
        do i = this%target(1, a), this%target(2, a)
          call add_direct(about, n, target(:, i), sums(:, i))
          if (l >= tree%boxes%top) call add_field(tree%terms, target(4, i) - middle(1), &
                                                  target(5, i) - middle(2), this%half, &
                                                  field(:, a), sums(:, i))
        end do
      end associate
    end do
    !$omp end do
    !$omp end parallel
  end subroutine evaluate

  ! Sources that act place by place on what is in a box and in no smaller one.
  pure subroutine gather(boxes, depth, box, source, about, n)
    type(box_tree), intent(in) :: boxes
    integer, intent(in) :: depth, box
    real(real64), intent(in) :: source(:, :)
    real(real64), allocatable, intent(inout) :: about(:, :)
    integer, intent(out) :: n
    integer :: l, a, b, k, j, last
    logical :: counting

    do k = 1, 2
      counting = k == 1
      n = 0
      a = box
      do l = depth, 0, -1
        associate (this => boxes%level(l))
          do j = this%first(a), this%first(a + 1) - 1
            b = abs(this%near(j))
            last = this%source(3, b)
            ! Children of a box see what is in the children of its neighbours at their own level.
            if (l < depth .and. this%near(j) < 0) last = this%source(2, b)
            if (.not. counting) call copy(source(:, this%source(1, b):last), about, n)
            n = n + last - this%source(1, b) + 1
          end do
          a = this%parent(a)
        end associate
      end do
      if (n <= size(about, 1)) cycle
      deallocate (about)
      allocate (about(n + n / 2, numbers))
    end do
  end subroutine gather

  pure subroutine copy(source, about, before)
    real(real64), contiguous, intent(in) :: source(:, :)
    real(real64), contiguous, intent(inout) :: about(:, :)
    integer, intent(in) :: before
    integer :: j

    do j = 1, size(source, 2)
      about(before + j, :) = source(:, j)
    end do
  end subroutine copy

  ! Adds what sources do at a target, place by place. What is near is told by the very sums that
  ! near_pairs makes; nothing acts on its own place.
  pure subroutine add_direct(about, n, target, value)
    real(real64), contiguous, intent(in) :: about(:, :), target(:)
    integer, intent(in) :: n
    real(real64), intent(inout) :: value(:)
    real(real64) :: dx, dy, r2, limit, inverse, first, third, phi, lap, gx, gy, g
    logical :: counts
    integer :: k

    phi = 0.0_real64
    lap = 0.0_real64
    gx = 0.0_real64
    gy = 0.0_real64
    if (size(value) == 2) then
      !$omp simd reduction(+:phi, lap) private(dx, dy, r2, limit, inverse, first, third, counts)
      do k = 1, n
        r2 = (about(k, 1) - target(1))**2 + (about(k, 2) - target(2))**2
        limit = about(k, 3) + target(3)
        counts = .not. r2 < limit * limit .and. r2 > 0.0_real64
        dx = target(4) - about(k, 4)
        dy = target(5) - about(k, 5)
        inverse = 1.0_real64 / merge(dx * dx + dy * dy, 1.0_real64, counts)
        first = merge(sqrt(inverse), 0.0_real64, counts)
        third = first * inverse
        phi = phi + (about(k, 6) * first + about(k, 7) * third)
        lap = lap + (about(k, 6) + 9.0_real64 * about(k, 7) * inverse) * third
      end do
    else
      !$omp simd reduction(+:phi, lap, gx, gy) &
      !$omp private(dx, dy, r2, limit, inverse, first, third, g, counts)
      do k = 1, n
        r2 = (about(k, 1) - target(1))**2 + (about(k, 2) - target(2))**2
        limit = about(k, 3) + target(3)
        counts = .not. r2 < limit * limit .and. r2 > 0.0_real64
        dx = target(4) - about(k, 4)
        dy = target(5) - about(k, 5)
        inverse = 1.0_real64 / merge(dx * dx + dy * dy, 1.0_real64, counts)
        first = merge(sqrt(inverse), 0.0_real64, counts)
        third = first * inverse
        phi = phi + (about(k, 6) * first + about(k, 7) * third)
        lap = lap + (about(k, 6) + 9.0_real64 * about(k, 7) * inverse) * third
        g = (about(k, 6) + 3.0_real64 * about(k, 7) * inverse) * third
        gx = gx - g * dx
        gy = gy - g * dy
      end do
      value(3) = value(3) + gx
      value(4) = value(4) + gy
    end if
    value(1) = value(1) + phi
    value(2) = value(2) + lap
  end subroutine add_direct

  pure function middle_of(tree, l, a) result(middle)
    type(source_tree), intent(in) :: tree
    integer, intent(in) :: l, a
    real(real64) :: middle(2)

    associate (level => tree%boxes%level(l))
      middle = [tree%boxes%x, tree%boxes%y] + (2 * level%cell(:, a) + 1) * level%half
    end associate
  end function middle_of

  ! Which quarter of the box around it a box is.
  pure integer function quarter(cell)
    integer, intent(in) :: cell(2)

    quarter = mod(cell(1), 2) + 2 * mod(cell(2), 2)
  end function quarter

end module asperity_source_tree
