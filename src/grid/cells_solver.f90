!> A cluster of contacts resolved on cells, under the field of the contacts outside.
!>
!> The two bodies are one half-space of the combined modulus under a rigid surface, the sum of both
!> profiles; the gap is vertical, also where a pair is inclined. There are no periodic images and no
!> end of the half-space. The cells are as fine as the load and the area call for.
module asperity_cells_solver
  use asperity_cell_convolution, only: cell_convolution
  use asperity_cells_answer, only: area_error, cell_contact, cells_answer, keep_elements, tell
  use asperity_cells_influence, only: mean_influence
  use asperity_cells_lattice, only: box_of, cell_lattice, gap_at, gap_shape, lay_cells, &
                                    shape_of_gap
  use asperity_cells_outside, only: add_outside, field_of_cells, outside_at, outside_field
  use asperity_cells_relax, only: relax
  use asperity_constants, only: pi
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: not_enough_memory
  use asperity_process, only: has_memory
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: any_loaded, cluster_lattice, reach_of_cluster, solve_cells, is_resolved

  !> The lattice of a cluster, kept from one round to the next.
  type :: cluster_lattice
    real(real64) :: x = 0.0_real64            !! origin, in plan
    real(real64) :: y = 0.0_real64            !! origin, in plan
    type(cell_lattice) :: cells               !! last lattice solved; forces not allocated: none
    real(real64) :: window(4) = 0.0_real64    !! x, y of two corners from its origin
    real(real64) :: deepest = 0.0_real64      !! penetration when it was laid
    !> relative error of load and area that the change by the last halving leaves
    real(real64) :: left(2) = 0.0_real64
  end type cluster_lattice

  ! Elements along the longer side of the box of a cluster while the box is searched; half as many
  ! at least on the first lattice that is halved, and twice as many at most in the radius of an
  ! isolated contact, whose load is in error by less than 1e-5 there (chosen; test: loads against
  ! Hertz in test/regression/test_effect_contacts.py).
  integer, parameter :: box_elements = 24
  ! Elements in a radius from which on the load of the isolated contact is taken from them, and that
  ! the least radius of a loaded contact has to have: with fewer the elements of the box are halved
  ! (chosen: else the load of 120 caps on caps has an error of 3 %; test: boundary elements in
  ! test/regression/test_dense.py).
  integer, parameter :: least_elements = 2
  ! Offset of the lattice from the contact with the largest isolated load, in elements of the first
  ! lattice that is halved, x and y (chosen: a symmetric offset lets the errors of elements at the
  ! rim add up; test: areas in test/regression/test_dense.py).
  real(real64), parameter :: lattice_offset(2) = [0.29_real64, 0.13_real64]
  !> Number of standard deviations of an area, and of a load, that its error estimate holds (chosen;
  !! test: estimates in test/regression/test_dense.py).
  real(real64), parameter, public :: deviations = 3.0_real64
  ! Residual of the gaps over the deepest penetration: so much while the box is searched, then so
  ! much times the tolerance of the load, whose error is then 0.44 of the residual in the root mean
  ! square (measured on 390 Hertz contacts; test: loads against Hertz in
  ! test/unit/cells_suite.f90).
  real(real64), parameter :: gap_residual = 0.004_real64
  ! Bytes that a cluster may use (chosen; test: refusals in test/unit/cells_suite.f90), and that are
  ! held for each element (measured; test: memory in test/regression/test_cost.py).
  real(real64), parameter :: bytes_allowed = 2.0_real64**31, bytes_per_element = 170.0_real64

contains

  !> The rectangle in plan in which the cells of a cluster will lie; a point when nothing touches.
  pure subroutine reach_of_cluster(pairs, members, closing, x0, x1, y0, y1)
    type(contact_pairs), intent(in) :: pairs       !! the position
    integer, intent(in) :: members(:)              !! places of the contacts in the list of pairs
    real(real64), intent(in) :: closing            !! past first touch
    real(real64), intent(out) :: x0, x1, y0, y1    !! its sides
    type(gap_shape), allocatable :: shapes(:)
    real(real64) :: low(2), high(2)

    call find_shapes(pairs, members, closing, shapes)
    low = [pairs%list(members(1))%x, pairs%list(members(1))%y]
    high = low
    if (size(shapes) > 0) call box_of(shapes, 0.0_real64, 0.0_real64, low, high)
    x0 = low(1)
    y0 = low(2)
    x1 = high(1)
    y1 = high(2)
  end subroutine reach_of_cluster

  !> Whether a contact is wide enough for elements of its own at its place: half of the digits of
  !! its coordinates are left for its radius.
  elemental logical function is_resolved(x, y, contact_radius)
    real(real64), intent(in) :: x, y            !! first touch, in plan
    real(real64), intent(in) :: contact_radius  !! in the same unit

    is_resolved = contact_radius > sqrt(epsilon(x)) * max(abs(x), abs(y))
  end function is_resolved

  !> Solves a cluster at a closing.
  !>
  !> The elements of one lattice, in the box of the loaded ones, are halved until load and area
  !> change by no more than the tolerances allow. Only lattices of one origin are compared.
  !> Members that touch at the same place share one contact: its load is stored at the first.
  subroutine solve_cells(pairs, members, closing, outside, tolerance, worth, lattice, answer)
    type(contact_pairs), intent(in) :: pairs       !! the position
    integer, intent(in) :: members(:)              !! places of the contacts in the list of pairs
    real(real64), intent(in) :: closing            !! past first touch
    type(outside_field), intent(in) :: outside     !! of the contacts that are no members
    real(real64), intent(in) :: tolerance(2)       !! relative errors allowed in load and area
    real(real64), intent(in) :: worth(2)           !! load, area: smaller ones count as this
    type(cluster_lattice), intent(inout) :: lattice  !! kept while it suffices
    type(cells_answer), intent(out) :: answer      !! the answer
    type(gap_shape), allocatable :: shapes(:)
    real(real64), allocatable :: displacement(:, :)
    real(real64) :: before(2), now(2), low(2), high(2), first
    integer :: i, k

    allocate (answer%together(size(members)), answer%alone(size(members)))
    allocate (answer%known_alone(size(members)), source=.false.)
    answer%together%x = pairs%list(members)%x
    answer%together%y = pairs%list(members)%y
    call find_shapes(pairs, members, closing, shapes)
    if (size(shapes) == 0) then
      answer%ending = solve_ending(.true., 0.0_real64, 0)
      return
    end if
    if (.not. all(shapes%penetration < level_height(pairs%list(members(shapes%pair))))) then
      answer%failure = 'a penetration reaches the level of the centres'
    else if (.not. maxval(shapes%penetration / shapes%curvature_radius)**2 > tiny(closing)) then
      answer%failure = 'penetrations below the resolution of boundary elements'
    end if
    if (allocated(answer%failure)) return
    if (is_kept()) then
      call press_in_window(lattice%cells%cell, gap_residual * tolerance(1), now)
    else
      call find_box()
      if (.not. allocated(answer%failure)) call halve()
    end if
    if (.not. allocated(answer%failure)) then
      ! The change can be small by chance: the scatter is added as a lower bound, up to what a
      ! change of the tolerance leaves.
      answer%error = max(lattice%left(1) * sum(answer%together%load), &
        min(deviations * norm2(answer%together%error), &
            error_left(tolerance(1)) * max(worth(1), sum(answer%together%load))))
      if (lattice%left(1) > 0.0_real64 .and. any(answer%together%load > 0.0_real64)) &
        answer%area_error = max( &
        lattice%left(2) / deviations, area_error * &
        (lattice%cells%cell / max(sqrt(maxval(answer%together%area) / pi), &
                                  radius_of(lattice%cells%force > 0.0_real64)))**1.5_real64)
      answer%cells = size(lattice%cells%force)
      if (associated(pairs%pressures)) &
        call keep_elements(lattice%cells, members(shapes%pair), answer%loaded)
      if (allocated(outside%x)) answer%beside = [ &
        (field_of_cells(lattice%cells, outside%x(i), outside%y(i)), i=1, size(outside%x))]
      ! Each by itself on the same lattice, so that the errors of cells cancel in the ratio.
      do i = 1, size(shapes)
        if (allocated(answer%failure)) exit
        answer%alone(shapes(i)%pair) = hertz_contact(pairs%modulus, shapes(i))
        answer%known_alone(shapes(i)%pair) = shapes(i)%contact_radius > &
                                             least_elements * lattice%cells%cell
        if (.not. answer%known_alone(shapes(i)%pair)) cycle
        if (size(shapes) == 1 .and. .not. (allocated(outside%x) .or. allocated(outside%at_nodes))) &
          then
          answer%alone = answer%together
        else
          call press_alone(shapes(i:i))
        end if
      end do
    end if
    if (.not. allocated(answer%failure)) return
    answer%ending%converged = .false.
    if (pairs%interrupt%is_asked()) answer%failure = 'interrupted'

  contains

    ! Whether the last lattice suffices. Its elements are smaller than required by a factor from 1
    ! to the root of 2, and the radius of a contact is as the root of the penetration. A new lattice
    ! has another discretisation error, with which the iteration of Hertzian contacts and boundary
    ! elements would not settle.
    logical function is_kept()
      is_kept = allocated(lattice%cells%force)
      if (is_kept) is_kept = 2 * maxval(shapes%penetration) > lattice%deepest .and. &
                             maxval(shapes%penetration) < 2 * lattice%deepest
    end function is_kept

    ! Finds the box that the contact fills, and the side of the first elements that are halved.
    subroutine find_box()
      real(real64) :: cell, side, loaded(4), moved(2)

      if (allocated(lattice%cells%force)) deallocate (lattice%cells%force)
      lattice%deepest = maxval(shapes%penetration)
      ! Origin: the contact with the largest isolated load.
      k = maxloc(shapes%contact_radius * shapes%penetration * shapes%cosine, 1)
      call box_of(shapes, shapes(k)%x, shapes(k)%y, low, high)
      cell = maxval(high - low) / box_elements
      lattice%x = shapes(k)%x - lattice_offset(1) * cell
      lattice%y = shapes(k)%y - lattice_offset(2) * cell
      call box_of(shapes, lattice%x, lattice%y, low, high)
      lattice%window = [low, high]
      ! Each round halves the side of the box, or of its elements, at least.
      do
        call press_in_window(cell, gap_residual, now)
        if (allocated(answer%failure)) return
        if (.not. now(1) > 0.0_real64) then
          ! No element is loaded: the contact may be smaller than an element.
          if (least_elements * cell < shapes(k)%contact_radius) exit
          cell = 0.5_real64 * cell
          cycle
        end if
        side = maxval(lattice%window(3:) - lattice%window(:2))
        call find_loaded(loaded)
        lattice%window = loaded
        ! The loaded elements are no fewer than on the first lattice that is halved.
        if (2 * maxval(loaded(3:) - loaded(:2)) > side) exit
        cell = maxval(loaded(3:) - loaded(:2)) / box_elements
      end do
      side = maxval(lattice%window(3:) - lattice%window(:2))
      first = 2 * side / box_elements
      ! One halving leads from above the required side to below it, in equal ratios.
      if (now(1) > 0.0_real64) first = min(first, sqrt(2.0_real64) * required_side())
      moved = [shapes(k)%x, shapes(k)%y] - lattice_offset * first - [lattice%x, lattice%y]
      lattice%x = lattice%x + moved(1)
      lattice%y = lattice%y + moved(2)
      lattice%window = lattice%window - [moved, moved]
    end subroutine find_box

    ! Halves the elements until the changes of load and area are within their tolerances.
    subroutine halve()
      real(real64) :: cell

      cell = first
      call press_in_window(cell, gap_residual * tolerance(1), before)
      lattice%left = 0.0_real64
      do while (.not. allocated(answer%failure) .and. before(1) > 0.0_real64)
        cell = 0.5_real64 * cell
        call press_in_window(cell, gap_residual * tolerance(1), now)
        if (allocated(answer%failure)) return
        lattice%left = error_left(abs(now / before - 1.0_real64))
        if (all(lattice%left <= allowed_errors()) .and. cell < required_side()) exit
        ! The place of the lattice is rounded to the place of the contact: further halving would
        ! converge slowly. The change is the estimate.
        if (.not. is_resolved(shapes(k)%x, shapes(k)%y, shapes(k)%contact_radius)) exit
        before = now
      end do
    end subroutine halve

    ! Relative errors that load and area may have.
    function allowed_errors() result(share)
      real(real64) :: share(2)

      share = tolerance * max(1.0_real64, worth / max(now, tiny(now)))
    end function allowed_errors

    ! Side of the elements that the scatter of areas and the smallest loaded contacts require.
    real(real64) function required_side() result(cell)
      real(real64) :: share(2), radius(size(members))

      share = allowed_errors()
      radius = sqrt(answer%together%area / pi)
      cell = max(maxval(radius), radius_of(lattice%cells%force > 0.0_real64)) * &
             (share(2) / (deviations * area_error))**(2.0_real64 / 3.0_real64)
      if (minval(radius, mask=radius > 0.0_real64) < least_elements * cell) cell = min(cell, &
        sqrt(0.5_real64) * maxval(lattice%window(3:) - lattice%window(:2)) / box_elements)
    end function required_side

    ! Radius of circles with the area and the rim of the loaded elements. A circle of radius a has 8
    ! a/h element sides on its rim; contacts that merge have none between them.
    real(real64) function radius_of(loaded) result(radius)
      logical, intent(in) :: loaded(:, :)
      integer :: columns, rows, sides

      columns = size(loaded, 1)
      rows = size(loaded, 2)
      sides = count(loaded(:columns - 1, :) .neqv. loaded(2:, :)) + &
              count(loaded(:, :rows - 1) .neqv. loaded(:, 2:)) + count(loaded(1, :)) + &
              count(loaded(columns, :)) + count(loaded(:, 1)) + count(loaded(:, rows))
      radius = 8 * count(loaded) * lattice%cells%cell / (pi * max(1, sides))
    end function radius_of

    ! Whether memory suffices for the elements of the box.
    logical function has_room(cell)
      real(real64), intent(in) :: cell

      has_room = bytes_of(cell) < bytes_allowed
      if (has_room) has_room = has_memory(nint(bytes_of(cell), int64))
    end function has_room

    real(real64) function bytes_of(cell) result(bytes)
      real(real64), intent(in) :: cell

      bytes = bytes_per_element * product((lattice%window(3:) - lattice%window(:2)) / cell + &
                                          2.0_real64)
    end function bytes_of

    ! Solves all contacts in the box, which grows where its rim is loaded; totals: load and area.
    subroutine press_in_window(cell, tolerance, totals)
      real(real64), intent(in) :: cell, tolerance
      real(real64), intent(out) :: totals(2)
      type(cell_lattice) :: next
      real(real64) :: rim(4)
      real(real64) :: growth
      logical :: is_complete

      call box_of(shapes, lattice%x, lattice%y, low, high)
      growth = cell
      do
        totals = 0.0_real64
        if (.not. bytes_of(cell) < bytes_allowed) then
          answer%failure = 'the boundary elements would need more than 2 GiB of memory'
        else if (.not. has_room(cell)) then
          answer%failure = not_enough_memory // ' for the boundary elements of a group of contacts'
        end if
        if (allocated(answer%failure)) return
        call lay_cells(shapes, lattice%x, lattice%y, cell, lattice%window, next)
        if (allocated(lattice%cells%force)) call start_from(lattice%cells, next)
        call add_outside(outside, pairs%modulus, next)
        call press(next, tolerance)
        if (allocated(answer%failure)) return
        call move_lattice(next, lattice%cells)
        associate (force => lattice%cells%force)
          rim = merge(1.0_real64, 0.0_real64, [any(force(1, :) > 0.0_real64), &
            any(force(:, 1) > 0.0_real64), any(force(size(force, 1), :) > 0.0_real64), &
            any(force(:, size(force, 2)) > 0.0_real64)])
        end associate
        rim = rim * merge(1.0_real64, 0.0_real64, [lattice%window(:2) > low, &
                                                   lattice%window(3:) < high])
        growth = 2 * growth
        lattice%window = lattice%window + growth * rim * [-1, -1, 1, 1]
        call add_missed(is_complete)
        if (is_complete .and. .not. any(rim > 0.0_real64)) exit
      end do
      answer%together = cell_contact()
      answer%together%x = pairs%list(members)%x
      answer%together%y = pairs%list(members)%y
      call tell(pairs%modulus, shapes, lattice%cells, answer%together)
      totals = [sum(answer%together%load), sum(answer%together%area)]
    end subroutine press_in_window

    ! Widens the box to each contact outside it that the displacement there leaves loaded.
    subroutine add_missed(is_complete)
      logical, intent(out) :: is_complete
      real(real64) :: place(2), gap, reach
      integer :: n

      is_complete = .true.
      do n = 1, size(shapes)
        place = [shapes(n)%x - lattice%x, shapes(n)%y - lattice%y]
        if (all(place > lattice%window(:2) .and. place < lattice%window(3:))) cycle
        gap = least_gap(shapes(n), lattice%cells, outside, pairs%modulus)
        if (.not. gap < 0.0_real64) cycle
        is_complete = .false.
        reach = shapes(n)%contact_radius * sqrt(min(1.0_real64, -gap / shapes(n)%penetration)) + &
                lattice%cells%cell
        lattice%window(:2) = min(lattice%window(:2), place - reach)
        lattice%window(3:) = max(lattice%window(3:), place + reach)
      end do
    end subroutine add_missed

    ! Relaxes the forces of a lattice.
    subroutine press(next, tolerance)
      type(cell_lattice), intent(inout) :: next
      real(real64), intent(in) :: tolerance
      type(cell_convolution) :: influence

      if (pairs%interrupt%is_asked()) answer%failure = 'interrupted'
      if (allocated(answer%failure)) return
      call influence%prepare(mean_influence(size(next%gap, 1), size(next%gap, 2)))
      if (pairs%interrupt%is_asked()) answer%failure = 'interrupted'
      if (allocated(answer%failure)) return
      call relax(influence, next%gap, tolerance, next%force, answer%ending, pairs%interrupt, &
                 displacement=displacement)
      if (.not. answer%ending%converged) &
        answer%failure = 'the pressures on the boundary elements did not converge'
    end subroutine press

    ! One contact by itself, nothing outside.
    subroutine press_alone(shape)
      type(gap_shape), intent(in) :: shape(:)
      type(cell_lattice) :: next
      type(solve_ending) :: ending
      real(real64) :: middle(2), reach, cell

      ending = answer%ending
      cell = lattice%cells%cell * 2.0_real64**max(0, ceiling(log(shape(1)%contact_radius / &
        (2 * box_elements * lattice%cells%cell)) / log(2.0_real64)))
      middle = [shape(1)%x - lattice%x, shape(1)%y - lattice%y]
      reach = shape(1)%contact_radius + cell
      call lay_cells(shape, lattice%x, lattice%y, cell, &
                     [middle - reach, middle + reach], next)
      call press(next, gap_residual * tolerance(1))
      call tell(pairs%modulus, shape, next, answer%alone)
      answer%ending = ending
    end subroutine press_alone

    ! The box of the loaded elements and their neighbours, and of contacts smaller than an element
    ! that the displacement there leaves loaded.
    subroutine find_loaded(box)
      real(real64), intent(out) :: box(4)
      real(real64) :: reach
      integer :: i, j, n

      box(:2) = huge(reach)
      box(3:) = -huge(reach)
      associate (cells => lattice%cells)
        do j = 1, size(cells%force, 2)
          do i = 1, size(cells%force, 1)
            if (.not. cells%force(i, j) > 0.0_real64) cycle
            box(:2) = min(box(:2), ([i, j] - 2 + [cells%left, cells%bottom]) * cells%cell)
            box(3:) = max(box(3:), ([i, j] + 1 + [cells%left, cells%bottom]) * cells%cell)
          end do
        end do
        do n = 1, size(shapes)
          associate (x => shapes(n)%x - cells%x, y => shapes(n)%y - cells%y)
            if (all([x, y] > box(:2) .and. [x, y] < box(3:))) cycle
            i = floor(x / cells%cell) - cells%left + 1
            j = floor(y / cells%cell) - cells%bottom + 1
            if (min(i, j) < 1 .or. i > size(cells%force, 1) .or. j > size(cells%force, 2)) cycle
            if (.not. shapes(n)%penetration > displacement(i, j) * cells%scale) cycle
            reach = min(shapes(n)%reach, cells%cell)
            box(:2) = min(box(:2), [x, y] - reach)
            box(3:) = max(box(3:), [x, y] + reach)
          end associate
        end do
      end associate
    end subroutine find_loaded

  end subroutine solve_cells

  !> Whether the displacement by a cluster leaves any of these contacts loaded.
  pure logical function any_loaded(pairs, others, closing, outside, lattice)
    type(contact_pairs), intent(in) :: pairs         !! the position
    integer, intent(in) :: others(:)                 !! contacts that are no members
    real(real64), intent(in) :: closing              !! past first touch
    type(outside_field), intent(in) :: outside       !! of the contacts that are no members
    type(cluster_lattice), intent(in) :: lattice     !! solved
    type(gap_shape), allocatable :: shapes(:)
    integer :: i

    call find_shapes(pairs, others, closing, shapes)
    any_loaded = .false.
    do i = 1, size(shapes)
      any_loaded = least_gap(shapes(i), lattice%cells, outside, pairs%modulus) < 0.0_real64
      if (any_loaded) return
    end do
  end function any_loaded

  ! Least gap of a contact in the displacement by elements and contacts outside, or 0: at its first
  ! touch and half its isolated radius from there, as the displacement may leave it loaded beside
  ! its first touch only.
  pure real(real64) function least_gap(shape, cells, outside, modulus) result(gap)
    type(gap_shape), intent(in) :: shape
    type(cell_lattice), intent(in) :: cells
    type(outside_field), intent(in) :: outside
    real(real64), intent(in) :: modulus
    real(real64) :: place(2, 5)
    integer :: i

    place = 0.5_real64 * shape%contact_radius * reshape([0, 0, -1, 0, 1, 0, 0, -1, 0, 1], [2, 5])
    gap = 0.0_real64
    do i = 1, size(place, 2)
      associate (x => place(1, i), y => place(2, i))
        gap = min(gap, gap_at(shape, x, y) + field_of_cells(cells, shape%x + x, shape%y + y) + &
                  outside_at(outside, modulus, shape%x + x, shape%y + y))
      end associate
    end do
  end function least_gap

  ! Relative error that is left where halving the elements changed a result by `change`: errors fall
  ! as the power 3/2 of the side of the elements, those of loads by a higher one.
  elemental real(real64) function error_left(change)
    real(real64), intent(in) :: change

    error_left = change / (2.0_real64**1.5_real64 - 1.0_real64)
  end function error_left

  ! Penetration at which the centres of a pair are level, or a centre comes to the plane.
  elemental real(real64) function level_height(pair)
    type(contact_pair), intent(in) :: pair

    level_height = pair%zc
    if (.not. min(pair%upper_radius, pair%lower_radius) > 0.0_real64) level_height = pair%radius
  end function level_height

  ! The members that penetrate; a shape's pair is its place among the members.
  pure subroutine find_shapes(pairs, members, closing, shapes)
    type(contact_pairs), intent(in) :: pairs
    integer, intent(in) :: members(:)
    real(real64), intent(in) :: closing
    type(gap_shape), allocatable, intent(out) :: shapes(:)
    integer :: i, n

    allocate (shapes(count(closing - pairs%list(members)%gap > 0.0_real64)))
    n = 0
    do i = 1, size(members)
      associate (pair => pairs%list(members(i)))
        if (.not. closing - pair%gap > 0.0_real64) cycle
        n = n + 1
        shapes(n) = shape_of_gap(pair, i, closing - pair%gap)
      end associate
    end do
  end subroutine find_shapes

  ! A contact alone as Hertz has it. A sphere's slope curves it more, by 1/cosine across and by its
  ! third power along: the radius of a circle as large as the ellipse.
  pure type(cell_contact) function hertz_contact(modulus, shape) result(contact)
    real(real64), intent(in) :: modulus
    type(gap_shape), intent(in) :: shape

    associate (circle => shape%contact_radius * shape%cosine)
      contact%x = shape%x
      contact%y = shape%y
      contact%load = 4.0_real64 / 3.0_real64 * modulus * circle * shape%penetration
      contact%area = pi * circle**2
      if (circle > 0.0_real64) &
        contact%pressure = 2.0_real64 / pi * modulus * shape%penetration / circle
    end associate
  end function hertz_contact

  ! The pressures of one lattice as a start on another.
  pure subroutine start_from(known, next)
    type(cell_lattice), intent(in) :: known
    type(cell_lattice), intent(inout) :: next
    real(real64) :: factor, ratio
    integer :: i, j, k, l

    ratio = next%cell / known%cell
    factor = ratio * (known%scale / next%scale)
    do j = 1, size(next%force, 2)
      l = floor(((next%bottom + j - 0.5_real64) * next%cell + next%y - known%y) / known%cell) - &
          known%bottom + 1
      do i = 1, size(next%force, 1)
        if (next%owner(i, j) == 0) cycle
        k = floor(((next%left + i - 0.5_real64) * next%cell + next%x - known%x) / known%cell) - &
            known%left + 1
        next%force(i, j) = 0.0_real64
        if (min(k, l) < 1 .or. k > size(known%force, 1) .or. l > size(known%force, 2)) cycle
        next%force(i, j) = factor * known%force(k, l)
      end do
    end do
  end subroutine start_from

  ! One lattice takes the place of another.
  subroutine move_lattice(from, to)
    type(cell_lattice), intent(inout) :: from, to

    to%x = from%x
    to%y = from%y
    to%cell = from%cell
    to%scale = from%scale
    to%left = from%left
    to%bottom = from%bottom
    call move_alloc(from%gap, to%gap)
    call move_alloc(from%owner, to%owner)
    call move_alloc(from%force, to%force)
  end subroutine move_lattice

end module asperity_cells_solver
