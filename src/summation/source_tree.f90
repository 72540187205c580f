!> Sums of 1/r of many sources in a plane at many places, in time proportional to their number.
!>
!> Source j is a circle with charge q_j and spread w_j and the potential q_j (1 + w_j Laplacian) 1/r
!> = q_j (1/r + w_j / r**3). Circles that are near each other, by the reaches they are planted with,
!> are listed and left to the caller. All others are summed: those in boxes that touch place by
!> place, those in other boxes by expansions (asperity_box_expansions).
module asperity_source_tree
  use asperity_box_expansions, only: add_dipole, add_field, add_moments, add_translated, down, &
                                     lanes, prepare_translations, translations, up
  use asperity_box_tree, only: build_boxes, square_box, touching
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: not_enough_memory
  use asperity_process, only: has_memory
  implicit none
  private

  public :: source_tree, build_tree, sum_sources

  ! Fewest places for which threads are started.
  integer, parameter :: many = 512
  ! Bytes of a circle without near ones. A million circles that are both took 210 each
  ! all over a square, 200 in clusters (measured); the rest is for worse.
  integer(int64), parameter :: bytes_per_circle = 200_int64
  character(*), parameter :: no_memory = not_enough_memory // ' for the sum over all contacts'

  !> Sources and targets at their places.
  type :: source_tree
    !> where the near sources of a target begin in `near`
    integer, allocatable :: first(:)
    !> sources near each target, without itself, in the order of the boxes
    integer, allocatable :: near(:)
    !> why the tree could not be planted; not allocated when all is well
    character(:), allocatable :: failure
    ! Circles: which are sources, as the first; of all others the number is less by `before`.
    integer, private :: sources = 0, before = 0
    ! In the order of the boxes: their numbers; planted place, near_factor * reach, place, charge,
    ! spread, dipole.
    integer, allocatable, private :: order(:)
    real(real64), allocatable, private :: circle(:, :)
    type(square_box), allocatable, private :: boxes(:)
    ! The first box of each level.
    integer, allocatable, private :: level(:)
    type(translations), private :: ways
    ! By box: moments of its sources, and coefficients of the field in it.
    real(real64), allocatable, private :: moment(:, :), field(:, :)
  end type source_tree

contains

  !> Plants circles at their places and finds which are near each other.
  subroutine build_tree(tree, x, y, reach, near_factor, sources)
    !> the tree; one that was planted before keeps its expansions between boxes
    type(source_tree), intent(inout) :: tree
    real(real64), intent(in) :: x(:)         !! places of all points
    real(real64), intent(in) :: y(:)         !! places of all points
    real(real64), intent(in) :: reach(:)     !! reaches, none negative
    !> circles whose places are nearer than this times the sum of their reaches are near
    real(real64), intent(in) :: near_factor
    !> so many are the sources, and all others the targets; absent: all are both, and none acts on
    !> itself
    integer, intent(in), optional :: sources

    tree%sources = size(x)
    tree%before = 0
    if (present(sources)) then
      tree%sources = sources
      tree%before = sources
    end if
    if (allocated(tree%failure)) deallocate (tree%failure)
    if (allocated(tree%near)) deallocate (tree%near)
    if (allocated(tree%circle)) deallocate (tree%circle)
    if (allocated(tree%moment)) deallocate (tree%moment, tree%field)
    tree%first = [1, spread(0, 1, size(x) - tree%before)]
    allocate (tree%near(0))
    if (.not. has_memory(bytes_per_circle * size(x))) then
      tree%failure = no_memory
      return
    end if
    allocate (tree%circle(size(x), 9))
    tree%circle(:, 1) = x
    tree%circle(:, 2) = y
    tree%circle(:, 3) = near_factor * reach
    call build_boxes(tree%circle(:, :3), tree%sources, size(x) - tree%before, tree%order, &
                     tree%boxes, tree%level)
    call list_near(tree)
    if (size(tree%level) < 4) return
    if (.not. allocated(tree%ways%way)) call prepare_translations(tree%ways)
    allocate (tree%moment(tree%ways%terms, size(tree%boxes)), &
              tree%field(tree%ways%terms, size(tree%boxes)))
  end subroutine build_tree

  ! Counts the near sources of every target, then lists them.
  subroutine list_near(tree)
    type(source_tree), intent(inout) :: tree
    real(real64), allocatable :: about(:, :)
    real(real64) :: here(3), apart
    integer, allocatable :: name(:), found(:)
    integer :: a, i, j, k, n
    integer(int64) :: pairs
    logical :: listing

    tree%circle(:, 4) = tree%order
    listing = .false.
    do
      !$omp parallel do schedule(dynamic, 16) private(about, here, apart, name, found, i, j, k, n) &
      !$omp   if(size(tree%first) > many)
      do a = 1, size(tree%boxes)
        about = sources_about(tree, a, 4)
        if (size(about) == 0) cycle
        name = int(about(:, 4))
        found = name
        do i = tree%boxes(a)%circles(1, 2), tree%boxes(a)%circles(2, 2)
          k = tree%order(i) - tree%before
          here = tree%circle(i, :3)
          n = 0
          ! No branch, as it would be mispredicted: the next name overwrites that of a far circle.
          do j = 1, size(name)
            found(n + 1) = name(j)
            apart = (about(j, 1) - here(1))**2 + (about(j, 2) - here(2))**2
            n = n + iand(merge(1, 0, apart < (about(j, 3) + here(3))**2), &
                         merge(1, 0, name(j) /= tree%order(i)))
          end do
          if (listing) then
            tree%near(tree%first(k):tree%first(k + 1) - 1) = found(:n)
          else
            tree%first(k + 1) = n
          end if
        end do
      end do
      !$omp end parallel do
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
      allocate (tree%near(pairs))
      listing = .true.
    end do
  end subroutine list_near

  ! The sources that act one by one on the targets that rest in a box: none if there are none.
  pure function sources_about(tree, box, columns) result(about)
    type(source_tree), intent(in) :: tree
    integer, intent(in) :: box, columns  ! so many of the circles' numbers
    real(real64), allocatable :: about(:, :)
    integer :: run(2, 9 * size(tree%level)), a, i, j, n

    n = 0
    a = box
    if (tree%boxes(a)%circles(2, 2) < tree%boxes(a)%circles(1, 2)) a = 0
    do while (a > 0)
      associate (near => tree%boxes(touching(tree%boxes(a))))
        run(1, n + 1:n + size(near)) = near%circles(1, 1)
        ! Those that rest deeper act in the levels below.
        run(2, n + 1:n + size(near)) = near%circles(merge(3, 2, a == box), 1)
        n = n + size(near)
      end associate
      a = tree%boxes(a)%parent
    end do
    allocate (about(sum(run(2, :n) - run(1, :n) + 1), columns))
    a = 0
    do i = 1, n
      do j = 1, columns
        about(a + 1:a + 1 + run(2, i) - run(1, i), j) = tree%circle(run(1, i):run(2, i), j)
      end do
      a = a + 1 + run(2, i) - run(1, i)
    end do
  end function sources_about

  !> Sums over all sources that are not near.
  !>
  !> Moves shift places without a change of what is near and of what is summed how: all sums are
  !> smooth functions of charges and moves. Moves must be small against the reaches. Targets that
  !> are the sources move with them. Laplacian and slopes are those of the potential with spread.
  subroutine sum_sources(tree, charge, spreading, value, move, rough, dipole)
    type(source_tree), intent(inout) :: tree           !! tree of the sources
    real(real64), intent(in) :: charge(:)              !! charges of the sources
    real(real64), intent(in) :: spreading(:)              !! of sources, at most reach**2
    !> (6, target): potential, its Laplacian in the plane, slopes in x and y, half of what it bends
    !! more in x than in y, bend in xy
    real(real64), intent(out) :: value(:, :)
    real(real64), intent(in), optional :: move(:, :)   !! (2, source): in x and y
    !> only the potential, and to 1e-4 or so; mean by the target's spread
    logical, intent(in), optional :: rough
    !> (2, source), with `rough`: dipoles d at the sources, with the potential d * (x - x_j)/r**3;
    !! slopes are then summed, too
    real(real64), intent(in), optional :: dipole(:, :)
    real(real64), allocatable :: about(:, :)
    integer :: a, columns, i, k, terms
    logical :: is_rough

    ! Without expansions all sums are exact.
    terms = merge(tree%ways%terms, 0, allocated(tree%moment))
    is_rough = .false.
    if (present(rough)) is_rough = rough .and. terms > 0
    if (is_rough) terms = tree%ways%rough_terms
    columns = merge(9, 7, present(dipole))
    !$omp parallel private(about, a, i, k) if(size(tree%order) > many)
    !$omp do
    do i = 1, size(tree%order)
      k = tree%order(i)
      tree%circle(i, 4:) = 0.0_real64
      tree%circle(i, 4:5) = tree%circle(i, :2)
      if (k > tree%sources) cycle
      tree%circle(i, 6:7) = [charge(k), spreading(k)]
      if (present(move)) tree%circle(i, 4:5) = tree%circle(i, 4:5) + move(:, k)
      if (present(dipole)) tree%circle(i, 8:9) = dipole(:, k)
    end do
    !$omp end do
    do i = size(tree%level) - 1, 3, -1
      call gather_moments(tree, i, terms, present(dipole))
    end do
    do i = 3, size(tree%level) - 1
      call distribute_fields(tree, i, terms)
    end do
    !$omp do schedule(dynamic, 16)
    do a = 1, size(tree%boxes)
      about = sources_about(tree, a, columns)
      do i = tree%boxes(a)%circles(1, 2), tree%boxes(a)%circles(2, 2)
        k = tree%order(i) - tree%before
        if (present(dipole)) then
          value(:, k) = dipole_sum(about, tree%circle(i, :))
        else if (is_rough) then
          value(:, k) = [1, 0, 0, 0, 0, 0] * rough_sum(about, tree%circle(i, :))
        else
          value(:, k) = direct_sum(about, tree%circle(i, :))
        end if
        ! Boxes of the first two levels touch.
        if (a >= tree%level(min(3, size(tree%level)))) call add_field(tree%ways, &
          (tree%circle(i, 4:5) - tree%boxes(a)%middle) / tree%boxes(a)%half, tree%boxes(a)%half, &
          tree%field(:terms, a), present(dipole), value(:, k))
      end do
    end do
    !$omp end do
    !$omp end parallel
  end subroutine sum_sources

  ! Field of the sources at a target by direct summation. The near sources were selected by the same
  ! distances when the tree was built; a source has no effect at its own position.
  pure function direct_sum(about, here) result(value)
    real(real64), contiguous, intent(in) :: about(:, :)
    real(real64), intent(in) :: here(:)
    real(real64) :: value(6), phi, lap, gx, gy, more_x, xy, counts, dx, dy, square, charge
    real(real64) :: spreading, third, fifth
    integer :: k

    phi = 0.0_real64
    lap = 0.0_real64
    gx = 0.0_real64
    gy = 0.0_real64
    more_x = 0.0_real64
    xy = 0.0_real64
    !$omp simd reduction(+:phi, lap, gx, gy, more_x, xy) &
    !$omp   private(counts, dx, dy, square, charge, spreading, third, fifth)
    do k = 1, size(about, 1)
      ! 1, or 0 when they are near or, without reaches, coincide.
      counts = 0.5_real64 + &
        sign(0.5_real64, (about(k, 1) - here(1))**2 + (about(k, 2) - here(2))**2 - &
                         ((about(k, 3) + here(3))**2 + tiny(here)))
      dx = here(4) - about(k, 4)
      dy = here(5) - about(k, 5)
      square = 1.0_real64 / ((dx**2 + dy**2) * counts + (1.0_real64 - counts))
      charge = about(k, 6) * counts
      spreading = charge * about(k, 7) * square
      third = sqrt(square)
      phi = phi + (charge + spreading) * third
      third = third * square
      lap = lap + (charge + 9.0_real64 * spreading) * third
      fifth = (3.0_real64 * charge + 15.0_real64 * spreading) * third * square
      third = (charge + 3.0_real64 * spreading) * third
      gx = gx - third * dx
      gy = gy - third * dy
      more_x = more_x + 0.5_real64 * fifth * (dx**2 - dy**2)
      xy = xy + fifth * dx * dy
    end do
    value = [phi, lap, gx, gy, more_x, xy]
  end function direct_sum

  ! The same, only the potential, and but for terms in 1/r**5; mean by the target's spread.
  pure function rough_sum(about, here) result(phi)
    real(real64), contiguous, intent(in) :: about(:, :)
    real(real64), intent(in) :: here(:)
    real(real64) :: phi, counts, square
    integer :: k

    phi = 0.0_real64
    !$omp simd reduction(+:phi) private(counts, square)
    do k = 1, size(about, 1)
      counts = 0.5_real64 + &
        sign(0.5_real64, (about(k, 1) - here(1))**2 + (about(k, 2) - here(2))**2 - &
                         ((about(k, 3) + here(3))**2 + tiny(here)))
      square = ((here(4) - about(k, 4))**2 + (here(5) - about(k, 5))**2) * counts + &
               (1.0_real64 - counts)
      ! A move may have made r small.
      phi = phi + about(k, 6) * counts / &
            sqrt(max(square - 2.0_real64 * (about(k, 7) + here(7)), 0.5_real64 * square))
    end do
  end function rough_sum

  ! The same with dipoles, and slopes.
  pure function dipole_sum(about, here) result(value)
    real(real64), contiguous, intent(in) :: about(:, :)
    real(real64), intent(in) :: here(:)
    real(real64) :: value(6), phi, gx, gy, along, charge, counts, dx, dy, square, third
    integer :: k

    phi = 0.0_real64
    gx = 0.0_real64
    gy = 0.0_real64
    !$omp simd reduction(+:phi, gx, gy) &
    !$omp   private(along, charge, counts, dx, dy, square, third)
    do k = 1, size(about, 1)
      counts = 0.5_real64 + &
        sign(0.5_real64, (about(k, 1) - here(1))**2 + (about(k, 2) - here(2))**2 - &
                         ((about(k, 3) + here(3))**2 + tiny(here)))
      dx = here(4) - about(k, 4)
      dy = here(5) - about(k, 5)
      square = (dx**2 + dy**2) * counts + (1.0_real64 - counts)
      square = 1.0_real64 / max(square - 2.0_real64 * (about(k, 7) + here(7)), 0.5_real64 * square)
      charge = about(k, 6) * counts
      third = sqrt(square)
      along = (about(k, 8) * dx + about(k, 9) * dy) * square * counts
      phi = phi + (charge + along) * third
      third = third * square
      gx = gx + (about(k, 8) * counts - (charge + 3.0_real64 * along) * dx) * third
      gy = gy + (about(k, 9) * counts - (charge + 3.0_real64 * along) * dy) * third
    end do
    value = [phi, 0.0_real64, gx, gy, 0.0_real64, 0.0_real64]
  end function dipole_sum

  ! Moments of the boxes of a level, from their children and from what rests in them. All threads
  ! come here together.
  subroutine gather_moments(tree, l, terms, with_dipoles)
    type(source_tree), intent(inout) :: tree
    integer, intent(in) :: l, terms
    logical, intent(in) :: with_dipoles
    real(real64) :: sums(lanes, terms)
    integer :: a, b, begin, box(0:3, lanes), i

    !$omp do schedule(dynamic)
    do begin = tree%level(l), tree%level(l + 1) - 1, lanes
      box = 0
      do a = begin, min(begin + lanes, tree%level(l + 1)) - 1
        do b = tree%boxes(a)%child(1), tree%boxes(a)%child(2)
          box(tree%boxes(b)%quarter, a - begin + 1) = b
        end do
      end do
      sums = 0.0_real64
      call add_translated(tree%ways, up, tree%moment, box, sums)
      do a = begin, min(begin + lanes, tree%level(l + 1)) - 1
        associate (this => tree%boxes(a))
          tree%moment(:terms, a) = sums(a - begin + 1, :)
          do i = this%circles(1, 1), this%circles(2, 1)
            ! Rough fields give no Laplacian: without spread what two circles do stays symmetric.
            call add_moments(tree%ways, (tree%circle(i, 4:5) - this%middle) / this%half, &
                             tree%circle(i, 6), &
                             merge(tree%circle(i, 7) / this%half**2, 0.0_real64, &
                                   terms == tree%ways%terms), tree%moment(:terms, a))
            if (with_dipoles) call add_dipole(tree%ways, &
              (tree%circle(i, 4:5) - this%middle) / this%half, tree%circle(i, 8:9) / this%half, &
              tree%moment(:terms, a))
          end do
        end associate
      end do
    end do
    !$omp end do
  end subroutine gather_moments

  ! Fields in the boxes of a level: from the box around, and from boxes that do not touch while
  ! those around them do. All threads come here together.
  subroutine distribute_fields(tree, l, terms)
    type(source_tree), intent(inout) :: tree
    integer, intent(in) :: l, terms
    real(real64) :: sums(lanes, terms)
    integer :: a, begin, box(0:3, lanes), column, n, row

    !$omp do schedule(dynamic)
    do begin = tree%level(l), tree%level(l + 1) - 1, lanes
      n = min(lanes, tree%level(l + 1) - begin)
      box = 0
      sums = 0.0_real64
      do row = 0, 3
        do column = 0, 3
          if (max(row, column) < 2) cycle
          do a = 1, n
            associate (this => tree%boxes(begin + a - 1))
              box(:, a) = [this%around(column, row), this%around(-column, row), &
                           this%around(column, -row), this%around(-column, -row)]
            end associate
          end do
          if (column == 0) box(1::2, :) = 0
          if (row == 0) box(2:, :) = 0
          call add_translated(tree%ways, 4 * row + column, tree%moment, box, sums)
        end do
      end do
      sums = sums / tree%boxes(begin)%half
      if (l > 3) then
        box = 0
        do a = 1, n
          associate (this => tree%boxes(begin + a - 1))
            box(this%quarter, a) = this%parent
          end associate
        end do
        call add_translated(tree%ways, down, tree%field, box, sums)
      end if
      tree%field(:terms, begin:begin + n - 1) = transpose(sums(:n, :))
    end do
    !$omp end do
  end subroutine distribute_fields

end module asperity_source_tree
