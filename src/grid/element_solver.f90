!> A cluster of contacts resolved on boundary elements, under the field of the contacts outside.
!>
!> The two bodies are one half-space of the combined modulus under a rigid surface, the sum of both
!> profiles; the gap is vertical, also where a pair is inclined. There are no periodic images and no
!> end of the half-space. The elements are as fine as the tolerances of load and area require.
module asperity_element_solver
  use asperity_cell_convolution, only: cell_convolution
  use asperity_element_answer, only: area_error, element_answer, element_contact, find_contacts, &
                                     keep_elements
  use asperity_element_influence, only: mean_influence
  use asperity_element_lattice, only: box_of, element_lattice, gap_at, gap_shape, lay_elements, &
                                    gap_of_pair
  use asperity_outside_field, only: add_outside, field_of_elements, outside_at, outside_field
  use asperity_constants, only: pi
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_element_forces, only: find_forces, force_bounds
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: not_enough_memory
  use asperity_process, only: has_memory
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: any_loaded, cluster_lattice, cluster_extent, solve_elements, is_resolved

  !> The lattice of a cluster, kept from one round to the next.
  type :: cluster_lattice
    real(real64) :: x = 0.0_real64            !! origin, in plan
    real(real64) :: y = 0.0_real64            !! origin, in plan
    type(element_lattice) :: elements         !! last lattice solved; without forces: none
    real(real64) :: window(4) = 0.0_real64    !! x, y of two corners from its origin
    real(real64) :: deepest = 0.0_real64      !! penetration when it was laid
    !> relative error of load and area that the change by the last halving leaves
    real(real64) :: left(2) = 0.0_real64
  end type cluster_lattice

  ! Contacts of a cluster and what is asked of their solution.
  type :: cluster_task
    type(contact_pairs), pointer :: pairs => null()
    type(outside_field), pointer :: outside => null()
    type(gap_shape), allocatable :: shapes(:)        ! members that penetrate
    integer :: origin = 1                            ! shape with the largest isolated load
    real(real64) :: tolerance(2) = 0.0_real64        ! relative errors of load and area
    real(real64) :: worth(2) = 0.0_real64            ! load, area: smaller ones count as this
    real(real64) :: totals(2) = 0.0_real64           ! load and area on the last lattice
    real(real64), allocatable :: displacement(:, :)  ! on the last lattice, over its scale
  end type cluster_task

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
  !! test: areas and their error estimates in test/unit/elements_suite.f90).
  real(real64), parameter, public :: deviations = 3.0_real64
  ! Residual of the gaps over the deepest penetration: so much while the box is searched, then so
  ! much times the tolerance of the load, whose error is then 0.44 of the residual in the root mean
  ! square (measured on 390 Hertz contacts; test: loads against Hertz in
  ! test/unit/elements_suite.f90).
  real(real64), parameter :: gap_residual = 0.004_real64
  ! Bytes that a cluster may use (chosen; test: refusals in test/unit/elements_suite.f90).
  real(real64), parameter :: bytes_allowed = 2.0_real64**31

contains

  !> The rectangle in plan in which the elements of a cluster lie; a point when nothing touches.
  pure subroutine cluster_extent(pairs, members, closing, x0, x1, y0, y1)
    type(contact_pairs), intent(in) :: pairs       !! pairs of the position
    integer, intent(in) :: members(:)              !! places of the contacts in the list of pairs
    real(real64), intent(in) :: closing            !! compression of the contacts [length]
    real(real64), intent(out) :: x0, x1, y0, y1    !! lower and upper sides in plan
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
  end subroutine cluster_extent

  !> Whether a contact is wide enough for elements of its own at its place: half of the digits of
  !! its coordinates are left for its radius.
  elemental logical function is_resolved(x, y, contact_radius)
    real(real64), intent(in) :: x, y            !! first touch, in plan
    real(real64), intent(in) :: contact_radius  !! in the same unit

    is_resolved = contact_radius > sqrt(epsilon(x)) * max(abs(x), abs(y))
  end function is_resolved

  !> Solves a cluster at a compression.
  !>
  !> The elements of one lattice, in the box of the loaded ones, are halved until load and area
  !> change by no more than the tolerances allow. Only lattices of one origin are compared.
  !> Members that touch at the same place share one contact: its load is stored at the first.
  subroutine solve_elements(pairs, members, closing, outside, tolerance, worth, lattice, answer)
    type(contact_pairs), intent(in), target :: pairs       !! pairs of the position
    integer, intent(in) :: members(:)                      !! contacts, places in the list of pairs
    real(real64), intent(in) :: closing                    !! compression of the contacts [length]
    type(outside_field), intent(in), target :: outside     !! field of contacts not in the cluster
    real(real64), intent(in) :: tolerance(2)               !! relative errors of load and area
    real(real64), intent(in) :: worth(2)                   !! load, area: smaller ones count as this
    type(cluster_lattice), intent(inout) :: lattice        !! last lattice, kept while it suffices
    type(element_answer), intent(out) :: answer            !! contacts, or a failure
    type(cluster_task) :: task
    real(real64) :: first

    task%pairs => pairs
    task%outside => outside
    task%tolerance = tolerance
    task%worth = worth
    allocate (answer%together(size(members)), answer%alone(size(members)))
    allocate (answer%known_alone(size(members)), source=.false.)
    answer%together%x = pairs%list(members)%x
    answer%together%y = pairs%list(members)%y
    call find_shapes(pairs, members, closing, task%shapes)
    associate (shapes => task%shapes)
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
      if (is_kept(lattice, maxval(shapes%penetration))) then
        call press_in_window(task, lattice, answer, lattice%elements%side, &
                             gap_residual * tolerance(1))
      else
        call find_box(task, lattice, answer, first)
        call halve_elements(task, first, lattice, answer)
      end if
      if (.not. allocated(answer%failure)) call estimate_errors(task, lattice, answer)
      if (.not. allocated(answer%failure)) call solve_isolated(task, lattice, answer)
      if (allocated(answer%failure)) then
        answer%ending%converged = .false.
        if (pairs%interrupt%is_asked()) answer%failure = 'interrupted'
        return
      end if
      answer%elements = size(lattice%elements%force)
      if (associated(pairs%pressures)) &
        call keep_elements(lattice%elements, members(shapes%pair), answer%loaded)
      if (allocated(outside%x)) &
        answer%beside = field_of_elements(lattice%elements, outside%x, outside%y)
    end associate
  end subroutine solve_elements

  ! Whether the last lattice suffices. Its elements are smaller than required by a factor from 1 to
  ! the root of 2, and the radius of a contact is as the root of the penetration. A new lattice has
  ! another discretisation error, with which the iteration of Hertzian contacts and boundary
  ! elements would not settle.
  pure logical function is_kept(lattice, deepest)
    type(cluster_lattice), intent(in) :: lattice
    real(real64), intent(in) :: deepest           ! penetration

    is_kept = allocated(lattice%elements%force) .and. 2 * deepest > lattice%deepest .and. &
              deepest < 2 * lattice%deepest
  end function is_kept

  ! Finds the box that the contact fills, and the side of the first elements that are halved.
  subroutine find_box(task, lattice, answer, first)
    type(cluster_task), intent(inout) :: task
    type(cluster_lattice), intent(inout) :: lattice
    type(element_answer), intent(inout) :: answer
    real(real64), intent(out) :: first
    real(real64) :: width, side, moved(2), low(2), high(2)

    associate (shapes => task%shapes, k => task%origin)
      if (allocated(lattice%elements%force)) deallocate (lattice%elements%force)
      lattice%deepest = maxval(shapes%penetration)
      k = maxloc(shapes%contact_radius * shapes%penetration * shapes%cosine, 1)
      call box_of(shapes, shapes(k)%x, shapes(k)%y, low, high)
      width = maxval(high - low) / box_elements
      lattice%x = shapes(k)%x - lattice_offset(1) * width
      lattice%y = shapes(k)%y - lattice_offset(2) * width
      call box_of(shapes, lattice%x, lattice%y, low, high)
      lattice%window = [low, high]
      ! Each round halves the side of the box, or of its elements, at least.
      do
        call press_in_window(task, lattice, answer, width, gap_residual)
        if (allocated(answer%failure)) return
        if (.not. task%totals(1) > 0.0_real64) then
          ! No element is loaded: the contact may be smaller than an element.
          if (least_elements * width < shapes(k)%contact_radius) exit
          width = 0.5_real64 * width
          cycle
        end if
        side = longer_side(lattice%window)
        call find_loaded(task, lattice%elements, lattice%window)
        ! The loaded elements are no fewer than on the first lattice that is halved.
        if (2 * longer_side(lattice%window) > side) exit
        width = longer_side(lattice%window) / box_elements
      end do
      first = 2 * longer_side(lattice%window) / box_elements
      ! One halving leads from above the required side to below it, in equal ratios.
      if (task%totals(1) > 0.0_real64) &
        first = min(first, sqrt(2.0_real64) * required_side(task, lattice, answer))
      moved = [shapes(k)%x, shapes(k)%y] - lattice_offset * first - [lattice%x, lattice%y]
      lattice%x = lattice%x + moved(1)
      lattice%y = lattice%y + moved(2)
      lattice%window = lattice%window - [moved, moved]
    end associate
  end subroutine find_box

  ! Halves the elements until the changes of load and area are within their tolerances.
  subroutine halve_elements(task, first, lattice, answer)
    type(cluster_task), intent(inout) :: task
    real(real64), intent(in) :: first                ! side of the elements that are halved first
    type(cluster_lattice), intent(inout) :: lattice
    type(element_answer), intent(inout) :: answer
    real(real64) :: width, before(2)

    if (allocated(answer%failure)) return
    width = first
    lattice%left = 0.0_real64
    call press_in_window(task, lattice, answer, width, gap_residual * task%tolerance(1))
    do while (.not. allocated(answer%failure) .and. task%totals(1) > 0.0_real64)
      before = task%totals
      width = 0.5_real64 * width
      call press_in_window(task, lattice, answer, width, gap_residual * task%tolerance(1))
      if (allocated(answer%failure)) return
      lattice%left = error_left(abs(task%totals / before - 1.0_real64))
      if (all(lattice%left <= allowed_errors(task)) .and. &
          width < required_side(task, lattice, answer)) exit
      ! The place of the lattice is rounded to the place of the contact: further halving would
      ! converge slowly. The change is the estimate.
      associate (largest => task%shapes(task%origin))
        if (.not. is_resolved(largest%x, largest%y, largest%contact_radius)) exit
      end associate
      ! No error falls faster than with the third power of the side: a tolerance that is out of
      ! reach is refused before its elements are solved.
      call check_memory(lattice, width * min(0.5_real64, &
        minval(allowed_errors(task) / max(lattice%left, tiny(width)))**(1.0_real64 / 3)), answer)
    end do
  end subroutine halve_elements

  ! Estimates the errors of load and area. The change by halving can be small by chance: the scatter
  ! is a lower bound, up to what a change of the tolerance leaves.
  subroutine estimate_errors(task, lattice, answer)
    type(cluster_task), intent(in) :: task
    type(cluster_lattice), intent(in) :: lattice
    type(element_answer), intent(inout) :: answer

    answer%error = max(lattice%left(1) * task%totals(1), &
                       min(deviations * norm2(answer%together%error), error_left( &
                           task%tolerance(1)) * max(task%worth(1), task%totals(1))))
    if (lattice%left(1) > 0.0_real64 .and. task%totals(1) > 0.0_real64) answer%area_error = &
      max(lattice%left(2) / deviations, &
          area_error * (lattice%elements%side / largest_radius(lattice, answer))**1.5_real64)
  end subroutine estimate_errors

  ! Relative errors that load and area may have.
  function allowed_errors(task) result(share)
    type(cluster_task), intent(in) :: task
    real(real64) :: share(2)

    share = task%tolerance * max(1.0_real64, task%worth / max(task%totals, tiny(share)))
  end function allowed_errors

  ! Side of the elements that the scatter of areas and the smallest loaded contacts require.
  real(real64) function required_side(task, lattice, answer) result(width)
    type(cluster_task), intent(in) :: task
    type(cluster_lattice), intent(in) :: lattice
    type(element_answer), intent(in) :: answer
    real(real64) :: share(2)

    share = allowed_errors(task)
    width = largest_radius(lattice, answer) * &
           (share(2) / (deviations * area_error))**(2.0_real64 / 3.0_real64)
    if (sqrt(minval(answer%together%area, mask=answer%together%area > 0.0_real64) / pi) < &
        least_elements * width) &
      width = min(width, sqrt(0.5_real64) * longer_side(lattice%window) / box_elements)
  end function required_side

  ! Largest radius of a contact, or of circles with the area and the rim of the loaded elements, as
  ! contacts that merge have no rim between them. A circle of radius a has 8 a/h sides on its rim.
  real(real64) function largest_radius(lattice, answer) result(radius)
    type(cluster_lattice), intent(in) :: lattice
    type(element_answer), intent(in) :: answer
    logical :: loaded(size(lattice%elements%force, 1), size(lattice%elements%force, 2))
    integer :: columns, rows, sides

    loaded = lattice%elements%force > 0.0_real64
    columns = size(loaded, 1)
    rows = size(loaded, 2)
    sides = count(loaded(:columns - 1, :) .neqv. loaded(2:, :)) + &
            count(loaded(:, :rows - 1) .neqv. loaded(:, 2:)) + count(loaded(1, :)) + &
            count(loaded(columns, :)) + count(loaded(:, 1)) + count(loaded(:, rows))
    radius = max(sqrt(maxval(answer%together%area) / pi), &
                 8 * count(loaded) * lattice%elements%side / (pi * max(1, sides)))
  end function largest_radius

  ! Solves all contacts in the box, which grows where its rim is loaded; sets the totals.
  subroutine press_in_window(task, lattice, answer, width, residual)
    type(cluster_task), intent(inout) :: task
    type(cluster_lattice), intent(inout) :: lattice
    type(element_answer), intent(inout) :: answer
    real(real64), intent(in) :: width, residual       ! side; of gaps over the deepest penetration
    type(element_lattice) :: next
    real(real64) :: rim(4), growth, low(2), high(2)
    logical :: is_complete

    call box_of(task%shapes, lattice%x, lattice%y, low, high)
    growth = width
    task%totals = 0.0_real64
    do
      call check_memory(lattice, width, answer)
      if (allocated(answer%failure)) return
      call lay_elements(task%shapes, lattice%x, lattice%y, width, lattice%window, next)
      if (allocated(lattice%elements%force)) call start_from(lattice%elements, next)
      call add_outside(task%outside, task%pairs%modulus, next)
      call press_elements(task, residual, next, answer)
      if (allocated(answer%failure)) return
      lattice%elements = next
      associate (force => next%force)
        rim = merge(1.0_real64, 0.0_real64, [lattice%window(:2) > low, lattice%window(3:) < high] &
          .and. [any(force(1, :) > 0.0_real64), any(force(:, 1) > 0.0_real64), &
                 any(force(size(force, 1), :) > 0.0_real64), &
                 any(force(:, size(force, 2)) > 0.0_real64)])
      end associate
      growth = 2 * growth
      lattice%window = lattice%window + growth * rim * [-1, -1, 1, 1]
      call add_missed(task, lattice, is_complete)
      if (is_complete .and. .not. any(rim > 0.0_real64)) exit
    end do
    associate (together => answer%together)
      together%load = 0.0_real64
      together%area = 0.0_real64
      together%pressure = 0.0_real64
      together%error = 0.0_real64
      call find_contacts(task%pairs%modulus, task%shapes, lattice%elements, together)
      task%totals = [sum(together%load), sum(together%area)]
    end associate
  end subroutine press_in_window

  ! Refuses elements of a side that need more memory than allowed or left.
  subroutine check_memory(lattice, width, answer)
    type(cluster_lattice), intent(in) :: lattice
    real(real64), intent(in) :: width            ! side
    type(element_answer), intent(inout) :: answer
    real(real64) :: bytes

    ! 17 arrays of 8 bytes, and spectra and transform of twice the size in both directions.
    bytes = 8 * (17 + 4) * product((lattice%window(3:) - lattice%window(:2)) / width + 2)
    if (.not. bytes < bytes_allowed) then
      answer%failure = 'the boundary elements would need more than 2 GiB of memory'
    else if (.not. has_memory(nint(bytes, int64))) then
      answer%failure = not_enough_memory // ' for the boundary elements of a group of contacts'
    end if
  end subroutine check_memory

  ! Widens the box to each contact outside it that the displacement there leaves loaded.
  subroutine add_missed(task, lattice, is_complete)
    type(cluster_task), intent(in) :: task
    type(cluster_lattice), intent(inout) :: lattice
    logical, intent(out) :: is_complete
    real(real64) :: place(2), gap, reach
    integer :: n

    is_complete = .true.
    do n = 1, size(task%shapes)
      associate (one => task%shapes(n))
        place = [one%x - lattice%x, one%y - lattice%y]
        if (all(place > lattice%window(:2) .and. place < lattice%window(3:))) cycle
        gap = least_gap(one, lattice%elements, task%outside, task%pairs%modulus)
        if (.not. gap < 0.0_real64) cycle
        is_complete = .false.
        reach = one%contact_radius * sqrt(min(1.0_real64, -gap / one%penetration)) + &
                lattice%elements%side
        lattice%window(:2) = min(lattice%window(:2), place - reach)
        lattice%window(3:) = max(lattice%window(3:), place + reach)
      end associate
    end do
  end subroutine add_missed

  ! Finds the forces on a lattice; `residual` of the gaps is over the deepest penetration.
  subroutine press_elements(task, residual, next, answer)
    type(cluster_task), intent(inout) :: task
    real(real64), intent(in) :: residual
    type(element_lattice), intent(inout) :: next
    type(element_answer), intent(inout) :: answer
    type(cell_convolution) :: influence

    if (.not. task%pairs%interrupt%is_asked()) &
      call influence%prepare(mean_influence(size(next%gap, 1), size(next%gap, 2)))
    if (task%pairs%interrupt%is_asked()) answer%failure = 'interrupted'
    if (allocated(answer%failure)) return
    call find_forces(influence, next%gap, force_bounds(tolerance=residual), next%force, &
                     answer%ending, task%pairs%interrupt, displacement=task%displacement)
    if (.not. answer%ending%converged) &
      answer%failure = 'the pressures on the boundary elements did not converge'
  end subroutine press_elements

  ! Solves each contact by itself, nothing outside, on the same lattice, so that the errors of the
  ! elements cancel in the ratio.
  subroutine solve_isolated(task, lattice, answer)
    type(cluster_task), intent(inout) :: task
    type(cluster_lattice), intent(in) :: lattice
    type(element_answer), intent(inout) :: answer
    type(element_lattice) :: next
    type(solve_ending) :: ending
    real(real64) :: middle(2), width
    integer :: i

    ending = answer%ending
    do i = 1, size(task%shapes)
      associate (one => task%shapes(i))
        answer%alone(one%pair) = hertz_contact(task%pairs%modulus, one)
        answer%known_alone(one%pair) = one%contact_radius > least_elements * lattice%elements%side
        if (.not. answer%known_alone(one%pair)) cycle
        if (size(task%shapes) == 1 .and. .not. (allocated(task%outside%x) .or. &
                                                allocated(task%outside%at_nodes))) then
          answer%alone = answer%together
          return
        end if
        width = lattice%elements%side * 2.0_real64**max(0, ceiling(log(one%contact_radius / &
          (2 * box_elements * lattice%elements%side)) / log(2.0_real64)))
        middle = [one%x - lattice%x, one%y - lattice%y]
        call lay_elements(task%shapes(i:i), lattice%x, lattice%y, width, &
                       [middle - one%contact_radius - width, middle + one%contact_radius + width], &
                       next)
        call press_elements(task, gap_residual * task%tolerance(1), next, answer)
        if (allocated(answer%failure)) return
        call find_contacts(task%pairs%modulus, task%shapes(i:i), next, answer%alone)
      end associate
    end do
    answer%ending = ending
  end subroutine solve_isolated

  ! Finds the box of the loaded elements and their neighbours, and of contacts smaller than an
  ! element that the displacement there leaves loaded.
  pure subroutine find_loaded(task, lattice, box)
    type(cluster_task), intent(in) :: task
    type(element_lattice), intent(in) :: lattice
    real(real64), intent(out) :: box(4)
    real(real64) :: reach
    integer :: i, j, n

    box(:2) = huge(reach)
    box(3:) = -huge(reach)
    do j = 1, size(lattice%force, 2)
      do i = 1, size(lattice%force, 1)
        if (.not. lattice%force(i, j) > 0.0_real64) cycle
        box(:2) = min(box(:2), ([i, j] - 2 + [lattice%left, lattice%bottom]) * lattice%side)
        box(3:) = max(box(3:), ([i, j] + 1 + [lattice%left, lattice%bottom]) * lattice%side)
      end do
    end do
    do n = 1, size(task%shapes)
      associate (one => task%shapes(n), x => task%shapes(n)%x - lattice%x, &
                 y => task%shapes(n)%y - lattice%y)
        if (all([x, y] > box(:2) .and. [x, y] < box(3:))) cycle
        i = floor(x / lattice%side) - lattice%left + 1
        j = floor(y / lattice%side) - lattice%bottom + 1
        if (min(i, j) < 1 .or. i > size(lattice%force, 1) .or. j > size(lattice%force, 2)) cycle
        if (.not. one%penetration > task%displacement(i, j) * lattice%depth) cycle
        reach = min(one%reach, lattice%side)
        box(:2) = min(box(:2), [x, y] - reach)
        box(3:) = max(box(3:), [x, y] + reach)
      end associate
    end do
  end subroutine find_loaded

  ! Longer side of a box, given by the coordinates of two corners.
  pure real(real64) function longer_side(box)
    real(real64), intent(in) :: box(4)

    longer_side = maxval(box(3:) - box(:2))
  end function longer_side

  !> Whether the displacement by a cluster leaves any of these contacts loaded.
  pure logical function any_loaded(pairs, others, closing, outside, lattice)
    type(contact_pairs), intent(in) :: pairs         !! pairs of the position
    integer, intent(in) :: others(:)                 !! contacts that are no members
    real(real64), intent(in) :: closing              !! compression of the contacts [length]
    type(outside_field), intent(in) :: outside       !! of the contacts that are no members
    type(cluster_lattice), intent(in) :: lattice     !! lattice of the cluster, solved
    type(gap_shape), allocatable :: shapes(:)
    integer :: i

    call find_shapes(pairs, others, closing, shapes)
    any_loaded = .false.
    do i = 1, size(shapes)
      any_loaded = least_gap(shapes(i), lattice%elements, outside, pairs%modulus) < 0.0_real64
      if (any_loaded) return
    end do
  end function any_loaded

  ! Least gap of a contact in the displacement by elements and contacts outside, or 0: at its first
  ! touch and half its isolated radius from there, as the displacement may leave it loaded beside
  ! its first touch only.
  pure real(real64) function least_gap(profile, lattice, outside, modulus) result(gap)
    type(gap_shape), intent(in) :: profile
    type(element_lattice), intent(in) :: lattice
    type(outside_field), intent(in) :: outside
    real(real64), intent(in) :: modulus
    real(real64) :: place(2, 5)
    integer :: i

    place = 0.5_real64 * profile%contact_radius * reshape([0, 0, -1, 0, 1, 0, 0, -1, 0, 1], [2, 5])
    gap = 0.0_real64
    do i = 1, size(place, 2)
      associate (x => place(1, i), y => place(2, i))
        gap = min(gap, gap_at(profile, x, y) + &
                       field_of_elements(lattice, profile%x + x, profile%y + y) + &
                       outside_at(outside, modulus, profile%x + x, profile%y + y))
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
        shapes(n) = gap_of_pair(pair, i, closing - pair%gap)
      end associate
    end do
  end subroutine find_shapes

  ! A contact alone as Hertz has it. A sphere's slope curves it more, by 1/cosine across and by its
  ! third power along: the radius of a circle as large as the ellipse.
  pure type(element_contact) function hertz_contact(modulus, profile) result(contact)
    real(real64), intent(in) :: modulus
    type(gap_shape), intent(in) :: profile

    associate (circle => profile%contact_radius * profile%cosine)
      contact%x = profile%x
      contact%y = profile%y
      contact%load = 4.0_real64 / 3.0_real64 * modulus * circle * profile%penetration
      contact%area = pi * circle**2
      if (circle > 0.0_real64) &
        contact%pressure = 2.0_real64 / pi * modulus * profile%penetration / circle
    end associate
  end function hertz_contact

  ! The pressures of one lattice as a start on another.
  pure subroutine start_from(known, next)
    type(element_lattice), intent(in) :: known
    type(element_lattice), intent(inout) :: next
    real(real64) :: factor, ratio
    integer :: i, j, k, l

    ratio = next%side / known%side
    factor = ratio * (known%depth / next%depth)
    do j = 1, size(next%force, 2)
      l = floor(((next%bottom + j - 0.5_real64) * next%side + next%y - known%y) / known%side) - &
          known%bottom + 1
      do i = 1, size(next%force, 1)
        if (next%owner(i, j) == 0) cycle
        k = floor(((next%left + i - 0.5_real64) * next%side + next%x - known%x) / known%side) - &
            known%left + 1
        next%force(i, j) = 0.0_real64
        if (min(k, l) < 1 .or. k > size(known%force, 1) .or. l > size(known%force, 2)) cycle
        next%force(i, j) = factor * known%force(k, l)
      end do
    end do
  end subroutine start_from

end module asperity_element_solver
