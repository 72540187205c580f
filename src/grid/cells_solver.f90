!> A cluster of contacts resolved on cells, under the field of the contacts outside.
!>
!> The two bodies are one half-space of the combined modulus under a rigid surface, the sum of both
!> profiles; the gap is vertical, also where a pair is inclined. There are no periodic images and no
!> end of the half-space. The cells are as fine as the load and the area call for.
module asperity_cells_solver
  use asperity_cell_convolution, only: cell_convolution
  use asperity_cells_answer, only: area_error, area_order, cell_contact, cells_answer, &
                                   keep_elements, tell
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
    real(real64) :: change = 0.0_real64       !! relative, of the load by the last halving
    real(real64) :: area_change = 0.0_real64  !! relative, of the area by the last halving
  end type cluster_lattice

  ! Elements along the longer side of the box of a cluster: while the box is searched, and at least
  ! on the first lattice that is halved (chosen).
  real(real64), parameter :: box_cells = 32.0_real64, first_cells = 12.0_real64
  ! The box shrinks to the loaded elements while they fill less than this share of its longer side
  ! (chosen).
  real(real64), parameter :: filled = 0.6_real64
  ! Width of the margin of the box around the loaded elements, in elements (chosen).
  real(real64), parameter :: beyond = 1.5_real64
  ! Elements in a radius from which on the load of the isolated contact is taken from them, and that
  ! the least radius of a loaded contact has to have: with fewer, the box has four times as many
  ! elements along its longer side (chosen: 24 give the load of 120 caps on caps an error of 3 %).
  real(real64), parameter :: least_seen = 2.0_real64
  ! Ratio of the side of an element to the required one below which it is not halved (chosen).
  real(real64), parameter :: nearly = 1.2_real64
  ! Elements in a radius from which on the isolated contact is solved on larger ones: the error of
  ! its load is 1e-5 there.
  real(real64), parameter :: most_alone = 32.0_real64
  ! Share of its longer side by which the box grows where its rim is loaded (chosen).
  real(real64), parameter :: widened = 0.2_real64
  ! Places at which an open contact is tested, from its first touch, over its isolated radius
  ! (chosen): the displacement by others may leave it loaded beside its first touch only.
  real(real64), parameter :: half = 0.5_real64, probes(2, 5) = reshape([0.0_real64, 0.0_real64, &
    -half, 0.0_real64, half, 0.0_real64, 0.0_real64, -half, 0.0_real64, half], [2, 5])
  ! Largest number of boxes in a search (chosen).
  integer, parameter :: most_boxes = 12

  ! Bound of the remaining error of the load, and of the area, over the change by the last halving
  ! of the elements. The error of a load is 0.8/3 of the change in the median, 2.7/3 at 90 % (12
  ! scenes, 32 to 256 elements a side).
  real(real64), parameter :: left_of_change = 2.0_real64 / 3.0_real64
  real(real64), parameter :: area_left_of_change = 0.5_real64

  ! Number of standard deviations of a load in the error estimate, and the share of the tolerance
  ! that they count at most: in caps on caps the scatter of each contact exceeds the error of their
  ! sum (chosen).
  real(real64), parameter :: scatter_told = 2.0_real64, scatter_share = 0.5_real64

  ! Offset of the lattice from the contact with the largest isolated load, in elements of the first
  ! lattice that is halved. A symmetric offset would let the errors of elements at the rim add up.
  real(real64), parameter :: lattice_x = 0.29_real64, lattice_y = 0.13_real64

  ! A lattice is kept while the side of its elements over the root of the deepest penetration is
  ! within these factors of the first. A new lattice has another discretisation error, with which
  ! the iteration of Hertzian contacts and boundary elements would not settle.
  real(real64), parameter :: least_kept = 0.5_real64, most_kept = 1.05_real64

  ! Bytes that may be held, and that are held for each cell.
  real(real64), parameter :: bytes_allowed = 2.0_real64**31, bytes_per_cell = 170.0_real64

  ! Least penetration over the radius that is solved: squares of smaller ones underflow.
  real(real64), parameter :: shallowest = 1.0e-120_real64
  ! Least contact radius over its coordinates: elements of a thousandth of it then have coordinates
  ! of three digits (derived from the rounding of numbers).
  real(real64), parameter :: least_radius = 1.0e6_real64 * epsilon(1.0_real64)

  ! Number of standard deviations of an area that its tolerance holds, and of those in its estimate
  ! (chosen).
  real(real64), parameter :: area_told = 5.5_real64
  real(real64), parameter, public :: area_scatter_told = 3.0_real64
  ! Least residual of the gaps, over the deepest penetration, above the rounding of sums (chosen).
  real(real64), parameter :: least_residual = 1.0e-10_real64

  ! The gaps are closed to that times the tolerance, of the penetration. The load is then off by .44
  ! (rms; 1.1 at most) of it: measured on 3 times 130 circles. While the box is sought: to this.
  real(real64), parameter :: inner = 0.004_real64, inner_of_box = 0.01_real64

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

  !> Whether a contact is wide enough for elements of its own at its place.
  elemental logical function is_resolved(x, y, contact_radius)
    real(real64), intent(in) :: x, y            !! first touch, in plan
    real(real64), intent(in) :: contact_radius  !! in the same unit

    is_resolved = contact_radius > least_radius * max(abs(x), abs(y))
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
    else if (.not. maxval(shapes%penetration / shapes%curvature_radius) > shallowest) then
      answer%failure = 'penetrations below the resolution of boundary elements'
    end if
    if (allocated(answer%failure)) return
    if (is_kept()) then
      call press_in_window(lattice%cells%cell, inner * tolerance(1), now)
    else
      call find_box()
      if (.not. allocated(answer%failure)) call halve()
    end if
    if (.not. allocated(answer%failure)) then
      ! The change can be small by chance: the scatter is added as a lower bound.
      answer%error = max(left_of_change * lattice%change * sum(answer%together%load), &
        min(scatter_told * norm2(answer%together%error), &
            scatter_share * tolerance(1) * max(worth(1), sum(answer%together%load))))
      if (lattice%change > 0.0_real64) answer%area_error = max( &
        area_left_of_change * lattice%area_change / area_scatter_told, area_error * &
        (lattice%cells%cell / max(sqrt(maxval(answer%together%area) / pi), &
                                  radius_of(lattice%cells%force > 0.0_real64)))**area_order)
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
                                             least_seen * lattice%cells%cell
        if (answer%known_alone(shapes(i)%pair)) call press_alone(shapes(i:i))
      end do
    end if
    if (.not. allocated(answer%failure)) return
    answer%ending%converged = .false.
    if (pairs%interrupt%is_asked()) answer%failure = 'interrupted'

  contains

    ! Whether the last lattice suffices.
    logical function is_kept()
      real(real64) :: larger

      is_kept = allocated(lattice%cells%force)
      if (.not. is_kept) return
      larger = sqrt(lattice%deepest / maxval(shapes%penetration))
      is_kept = larger > least_kept .and. larger < most_kept
    end function is_kept

    ! Finds the box that the contact fills, and the side of the first elements that are halved.
    subroutine find_box()
      real(real64) :: cell, side, loaded(4), moved(2)
      integer :: box

      if (allocated(lattice%cells%force)) deallocate (lattice%cells%force)
      lattice%deepest = maxval(shapes%penetration)
      ! Origin: the contact with the largest isolated load.
      k = maxloc(shapes%contact_radius * shapes%penetration * shapes%cosine, 1)
      call box_of(shapes, shapes(k)%x, shapes(k)%y, low, high)
      cell = maxval(high - low) / box_cells
      lattice%x = shapes(k)%x - lattice_x * cell
      lattice%y = shapes(k)%y - lattice_y * cell
      call box_of(shapes, lattice%x, lattice%y, low, high)
      lattice%window = [low, high]
      do box = 1, most_boxes
        call press_in_window(cell, inner_of_box, now)
        if (allocated(answer%failure)) return
        if (.not. now(1) > 0.0_real64) then
          ! No element is loaded: the contact may be smaller than an element.
          if (least_seen * cell < shapes(k)%contact_radius) exit
          cell = 0.5_real64 * cell
          cycle
        end if
        side = maxval(lattice%window(3:) - lattice%window(:2))
        call find_loaded(loaded)
        lattice%window = loaded
        if (maxval(loaded(3:) - loaded(:2)) > filled * side) exit
        cell = maxval(loaded(3:) - loaded(:2)) / box_cells
      end do
      side = maxval(lattice%window(3:) - lattice%window(:2))
      first = side / first_cells
      if (now(1) > 0.0_real64) first = min(first, 2 * called_for())
      moved = [shapes(k)%x - lattice_x * first - lattice%x, &
               shapes(k)%y - lattice_y * first - lattice%y]
      lattice%x = lattice%x + moved(1)
      lattice%y = lattice%y + moved(2)
      lattice%window = lattice%window - [moved, moved]
    end subroutine find_box

    ! Halves the elements until the changes of load and area are within their tolerances.
    subroutine halve()
      real(real64) :: cell

      cell = first
      call press_in_window(cell, inner * tolerance(1), before)
      lattice%change = 0.0_real64
      lattice%area_change = 0.0_real64
      do while (.not. allocated(answer%failure) .and. before(1) > 0.0_real64)
        cell = 0.5_real64 * cell
        call press_in_window(cell, inner * tolerance(1), now)
        if (allocated(answer%failure)) return
        lattice%change = abs(now(1) / before(1) - 1.0_real64)
        lattice%area_change = abs(now(2) / before(2) - 1.0_real64)
        if (all([left_of_change * lattice%change, &
                 area_left_of_change * lattice%area_change] <= allowed()) .and. &
            cell < nearly * called_for()) exit
        ! The place of the lattice is rounded to the place of the contact: further halving would
        ! converge slowly. The change is the estimate.
        if (.not. is_resolved(shapes(k)%x, shapes(k)%y, shapes(k)%contact_radius)) exit
        before = now
      end do
    end subroutine halve

    ! Relative errors that load and area may have.
    function allowed() result(share)
      real(real64) :: share(2)

      share = tolerance * max(1.0_real64, worth / max(now, tiny(now)))
    end function allowed

    ! Side of the elements that the scatter of areas and the smallest loaded contacts require.
    real(real64) function called_for() result(cell)
      real(real64) :: share(2), radius(size(members))

      share = allowed()
      radius = sqrt(answer%together%area / pi)
      cell = max(maxval(radius), radius_of(lattice%cells%force > 0.0_real64)) / &
             (area_told * area_error / share(2))**(1.0_real64 / area_order)
      if (minval(radius, mask=radius > 0.0_real64) < least_seen * cell) cell = min(cell, &
        maxval(lattice%window(3:) - lattice%window(:2)) / (4 * first_cells))
    end function called_for

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

      bytes = bytes_per_cell * product((lattice%window(3:) - lattice%window(:2)) / cell + &
                                       2.0_real64)
    end function bytes_of

    ! Solves all contacts in the box, which grows where its rim is loaded; totals: load and area.
    subroutine press_in_window(cell, tolerance, totals)
      real(real64), intent(in) :: cell, tolerance
      real(real64), intent(out) :: totals(2)
      type(cell_lattice) :: next
      real(real64) :: rim(4)
      integer :: turn
      logical :: is_complete

      call box_of(shapes, lattice%x, lattice%y, low, high)
      do turn = 1, most_boxes
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
        lattice%window = lattice%window + widened * maxval(lattice%window(3:) - &
          lattice%window(:2)) * rim * [-1, -1, 1, 1]
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
                beyond * lattice%cells%cell
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
      call relax(influence, next%gap, max(least_residual, tolerance), next%force, answer%ending, &
                 pairs%interrupt, displacement=displacement)
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
        (most_alone * lattice%cells%cell)) / log(2.0_real64)))
      middle = [shape(1)%x - lattice%x, shape(1)%y - lattice%y]
      reach = shape(1)%contact_radius + beyond * cell
      call lay_cells(shape, lattice%x, lattice%y, cell, &
                     [middle - reach, middle + reach], next)
      call press(next, inner * tolerance(1))
      call tell(pairs%modulus, shape, next, answer%alone)
      answer%ending = ending
    end subroutine press_alone

    ! The box of the loaded elements, and of contacts smaller than an element that the displacement
    ! there leaves loaded.
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
            box(:2) = min(box(:2), (real([i, j], real64) - 1.0_real64 - beyond + &
                                    [cells%left, cells%bottom]) * cells%cell)
            box(3:) = max(box(3:), (real([i, j], real64) + beyond + &
                                    [cells%left, cells%bottom]) * cells%cell)
          end do
        end do
        do n = 1, size(shapes)
          associate (x => shapes(n)%x - cells%x, y => shapes(n)%y - cells%y)
            if (all([x, y] > box(:2) .and. [x, y] < box(3:))) cycle
            i = floor(x / cells%cell) - cells%left + 1
            j = floor(y / cells%cell) - cells%bottom + 1
            if (min(i, j) < 1 .or. i > size(cells%force, 1) .or. j > size(cells%force, 2)) cycle
            if (.not. shapes(n)%penetration > displacement(i, j) * cells%scale) cycle
            reach = min(shapes(n)%reach, beyond * cells%cell)
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

  ! Least gap of a contact at `probes` in the displacement by elements and contacts outside, or 0.
  pure real(real64) function least_gap(shape, cells, outside, modulus) result(gap)
    type(gap_shape), intent(in) :: shape
    type(cell_lattice), intent(in) :: cells
    type(outside_field), intent(in) :: outside
    real(real64), intent(in) :: modulus
    integer :: i

    gap = 0.0_real64
    do i = 1, size(probes, 2)
      associate (x => probes(1, i) * shape%contact_radius, y => probes(2, i) * shape%contact_radius)
        gap = min(gap, gap_at(shape, x, y) + field_of_cells(cells, shape%x + x, shape%y + y) + &
                  outside_at(outside, modulus, shape%x + x, shape%y + y))
      end associate
    end do
  end function least_gap

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
