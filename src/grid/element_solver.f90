!> A cluster of contacts resolved on boundary elements, under the field of the contacts outside.
!>
!> Problem: a half-space of the combined modulus under a rigid surface, the least of the paraboloids
!> of all pairs; the gap is vertical, also where a pair is inclined. Find the pressures >= 0 of
!> least energy, at a given compression or of a given sum (asperity_element_forces), on square
!> elements of uniform pressure.
!>
!> Method: the elements of one lattice are halved until the changes of load and area, extrapolated
!> with the orders 2 and 3/2 of the elements (Richardson), are below their tolerances, and as small
!> as the scatter of areas and the smallest contacts require. Of a given sum the compression stands
!> for the load. The lattice covers a window, which is extended to loaded contacts outside it.
!>
!> Exits: converged; or a message in `failure`, where penetrations are too large or too small for
!> the model, memory is short, the pressures do not converge or the run is interrupted. Modifies the
!> lattice, which is used again while the largest penetration changes by less than a factor of 2.
module asperity_element_solver
  use asperity_lattice_convolution, only: lattice_convolution
  use asperity_element_answer, only: area_error, element_answer, find_contacts, keep_elements
  use asperity_element_influence, only: mean_influence
  use asperity_element_lattice, only: bounding_box, element_lattice, gap_at, gap_of_pair, &
                                      gap_shape, lay_elements
  use asperity_outside_field, only: add_outside_field, element_displacement, &
                                    outside_displacement, outside_field
  use asperity_constants, only: pi
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_element_forces, only: find_forces, force_bounds
  use asperity_kinds, only: int64, real64
  use asperity_line_transform, only: bytes_of_plans
  use asperity_process, only: check_memory
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: cluster_extent, cluster_lattice, solve_elements

  !> Lattice of a cluster, kept for the next compression.
  type :: cluster_lattice
    real(real64) :: x = 0.0_real64            !! origin in plan
    real(real64) :: y = 0.0_real64            !! origin in plan
    type(element_lattice) :: elements         !! last solved lattice; without forces: none
    real(real64) :: window(4) = 0.0_real64    !! x, y of two corners of its elements from the origin
    real(real64) :: largest_penetration = 0.0_real64  !! penetration for which it was laid
    !> relative discretisation errors of load and area, by the changes in the last halving
    real(real64) :: halving_error(2) = 0.0_real64
  end type cluster_lattice

  ! Contacts of a cluster and the accuracy of their solution.
  type :: cluster_task
    type(contact_pairs), pointer :: pairs => null()
    type(outside_field), pointer :: outside => null()
    type(gap_shape), allocatable :: shapes(:)        ! members that penetrate
    integer :: origin = 1                            ! index of that with the largest isolated load
    real(real64) :: tolerance(2) = 0.0_real64        ! relative errors of load and area
    real(real64) :: reference(2) = 0.0_real64        ! least load and area they are relative to
    real(real64) :: target = -1.0_real64             ! given load over the modulus; below 0: none
    !> load, of a given load the compression since first touch, and area on the last lattice
    real(real64) :: totals(2) = 0.0_real64
    real(real64) :: level = 0.0_real64               ! mean gap under a given load [length]
    real(real64), allocatable :: displacement(:, :)  ! by element of the last lattice, over depth
  end type cluster_task

  ! Elements along the longer side of the box of a cluster while the box is searched; half as many
  ! at least on the first lattice that is halved (derived: the box of one contact, 2 sqrt(2) of its
  ! radii, has 8.5 in a radius, and its area the error area_error/8.5**1.5 = 0.5 %).
  integer, parameter :: box_elements = 24
  ! Factor of the compression for which elements of a given load are laid, on that of Hertzian
  ! contacts (measured: their error is at most 0.024 in the scenes of
  ! reference_output/interaction/dense.csv; a larger compression is laid again).
  real(real64), parameter :: laid_ratio = 1.1_real64
  ! Offset of the lattice from the contact with the largest isolated load, in elements of the first
  ! lattice that is halved, x and y (chosen: a symmetric offset lets the errors of elements at the
  ! rim add up; test: elements_suite.f90).
  real(real64), parameter :: lattice_offset(2) = [0.29_real64, 0.13_real64]
  !> Number of standard deviations of an area, and of a load, that its error estimate holds: errors
  !! of one mode are larger in at most 4/81 of the cases (Vysochanskij and Petunin 1980).
  real(real64), parameter, public :: deviations = 3.0_real64
  ! Residual of the gaps over the deepest penetration: so much while the box is searched, then so
  ! much times the tolerance of the load, whose error is then 0.44 of the residual in the root mean
  ! square (measured on 390 Hertz contacts).
  real(real64), parameter :: gap_residual = 0.004_real64
  !> Largest number of elements of a lattice: 2 GiB (chosen) of 17 arrays of 8 bytes, and 4 more for
  !! two spectra and a transform of the padded lattice.
  real(real64), parameter, public :: elements_allowed = 2.0_real64**31 / (8 * (17 + 4))

contains

  !> Finds the rectangle in plan in which the elements of a cluster lie; a point if no member
  !> penetrates.
  pure subroutine cluster_extent(pairs, members, compression, x0, x1, y0, y1)
    type(contact_pairs), intent(in) :: pairs       !! pairs of the position
    integer, intent(in) :: members(:)              !! contacts, indices in the list of pairs
    real(real64), intent(in) :: compression        !! compression of the contacts [length]
    real(real64), intent(out) :: x0, x1, y0, y1    !! lower and upper limits in plan
    type(gap_shape), allocatable :: shapes(:)
    real(real64) :: low(2), high(2)

    call find_shapes(pairs, members, compression, shapes)
    low = [pairs%list(members(1))%x, pairs%list(members(1))%y]
    high = low
    if (size(shapes) > 0) call bounding_box(shapes, 0.0_real64, 0.0_real64, low, high)
    x0 = low(1)
    y0 = low(2)
    x1 = high(1)
    y1 = high(2)
  end subroutine cluster_extent

  !> Solves a cluster at a compression (problem, method and exits: see the module).
  !>
  !> Only lattices of one origin are compared. The load of members with the same position of first
  !> touch is stored at the first one.
  subroutine solve_elements(pairs, members, compression, outside, accuracy, lattice, answer, target)
    type(contact_pairs), intent(in), target :: pairs       !! pairs of the position
    integer, intent(in) :: members(:)                      !! contacts, indices in the list of pairs
    real(real64), intent(in) :: compression                !! compression of the contacts [length]
    type(outside_field), intent(in), target :: outside     !! field of contacts not in the cluster
    !> relative errors of load and area; least load and area that they refer to
    real(real64), intent(in) :: accuracy(2, 2)
    type(cluster_lattice), intent(inout) :: lattice        !! last lattice, used again if possible
    type(element_answer), intent(out) :: answer            !! contacts and errors, or a failure
    !> sum of the forces on the elements [force]; the compression is an estimate then
    real(real64), intent(in), optional :: target
    type(cluster_task) :: task
    real(real64) :: first_touch, laid

    task%pairs => pairs
    task%outside => outside
    task%tolerance = accuracy(:, 1)
    task%reference = accuracy(:, 2)
    first_touch = minval(pairs%list(members)%gap)
    laid = compression
    if (present(target)) then
      task%target = target / pairs%modulus
      laid = first_touch + laid_ratio * (compression - first_touch)
    end if
    do
      call find_shapes(pairs, members, laid, task%shapes)
      call solve_shapes(task, members, lattice, answer)
      answer%compression = laid + task%level
      if (allocated(answer%failure) .or. .not. task%level > 0.0_real64) return
      ! The elements were laid for a smaller compression than that of the load.
      laid = first_touch + laid_ratio * (answer%compression - first_touch)
      deallocate (answer%contacts, lattice%elements%force)
    end do
  end subroutine solve_elements

  ! Solves the contacts that penetrate on lattices that are halved.
  subroutine solve_shapes(task, members, lattice, answer)
    type(cluster_task), intent(inout) :: task
    integer, intent(in) :: members(:)
    type(cluster_lattice), intent(inout) :: lattice
    type(element_answer), intent(inout) :: answer
    real(real64) :: first_side

    associate (shapes => task%shapes, pairs => task%pairs, outside => task%outside)
      allocate (answer%contacts(size(members)))
      answer%contacts%x = pairs%list(members)%x
      answer%contacts%y = pairs%list(members)%y
      if (size(shapes) == 0) then
        answer%ending = solve_ending(converged=.true.)
        return
      end if
      if (.not. all(shapes%penetration < level_height(pairs%list(members(shapes%pair))))) then
        answer%failure = 'a penetration reaches the level of the centres'
      else if (.not. maxval(shapes%penetration * shapes%curvature)**2 > tiny(first_side)) then
        answer%failure = 'penetrations below the resolution of boundary elements'
      end if
      if (allocated(answer%failure)) return
      if (is_kept(lattice, maxval(shapes%penetration))) then
        call solve_in_window(task, lattice, answer, lattice%elements%side, &
                             gap_residual * task%tolerance(1))
      else
        call find_box(task, lattice, answer, first_side)
        call halve_elements(task, first_side, lattice, answer)
      end if
      if (.not. allocated(answer%failure)) call estimate_errors(task, lattice, answer)
      if (allocated(answer%failure)) then
        answer%ending%converged = .false.
        if (pairs%interrupt%is_asked()) answer%failure = 'interrupted'
        return
      end if
      answer%elements = size(lattice%elements%force)
      if (associated(pairs%pressures)) &
        call keep_elements(lattice%elements, members(shapes%pair), answer%pressures)
      if (allocated(outside%x)) &
        answer%outside_displacement = element_displacement(lattice%elements, outside%x, outside%y)
    end associate
  end subroutine solve_shapes

  ! Whether the last lattice is used again. Its elements are smaller than required by a factor from
  ! 1 to the root of 2, and the radius of a contact is proportional to the root of the penetration.
  ! A new lattice would change the discretisation error, and the iteration of Hertzian contacts and
  ! boundary elements would not converge.
  pure logical function is_kept(lattice, largest_penetration)
    type(cluster_lattice), intent(in) :: lattice
    real(real64), intent(in) :: largest_penetration

    is_kept = allocated(lattice%elements%force) .and. &
              2 * largest_penetration > lattice%largest_penetration .and. &
              largest_penetration < 2 * lattice%largest_penetration
  end function is_kept

  ! Finds the window around the loaded elements, and the side of the first elements that are halved.
  subroutine find_box(task, lattice, answer, first_side)
    type(cluster_task), intent(inout) :: task
    type(cluster_lattice), intent(inout) :: lattice
    type(element_answer), intent(inout) :: answer
    real(real64), intent(out) :: first_side
    real(real64) :: side, box_side, origin_shift(2), low(2), high(2)

    associate (shapes => task%shapes, k => task%origin)
      if (allocated(lattice%elements%force)) deallocate (lattice%elements%force)
      lattice%largest_penetration = maxval(shapes%penetration)
      k = maxloc(shapes%contact_radius * shapes%penetration, 1)
      call bounding_box(shapes, shapes(k)%x, shapes(k)%y, low, high)
      side = maxval(high - low) / box_elements
      lattice%x = shapes(k)%x - lattice_offset(1) * side
      lattice%y = shapes(k)%y - lattice_offset(2) * side
      call bounding_box(shapes, lattice%x, lattice%y, low, high)
      lattice%window = [low, high]
      ! Each iteration reduces the side of the window, or of its elements, at least by half.
      do
        call solve_in_window(task, lattice, answer, side, gap_residual)
        if (allocated(answer%failure)) return
        if (.not. task%totals(1) > 0.0_real64) then
          ! No element is loaded: the loaded contact may be smaller than an element.
          if (2 * side < shapes(k)%contact_radius) exit
          side = 0.5_real64 * side
          cycle
        end if
        box_side = longer_side(lattice%window)
        call find_loaded_box(task, lattice%elements, lattice%window)
        ! The window then has at least as many elements as the first lattice that is halved.
        if (2 * longer_side(lattice%window) > box_side) exit
        side = longer_side(lattice%window) / box_elements
      end do
      first_side = 2 * longer_side(lattice%window) / box_elements
      ! One halving goes from sqrt(2) times the required side to 1/sqrt(2) times it.
      if (task%totals(1) > 0.0_real64) &
        first_side = min(first_side, sqrt(2.0_real64) * required_side(task, lattice, answer))
      origin_shift = [shapes(k)%x, shapes(k)%y] - lattice_offset * first_side - &
                     [lattice%x, lattice%y]
      lattice%x = lattice%x + origin_shift(1)
      lattice%y = lattice%y + origin_shift(2)
      lattice%window = lattice%window - [origin_shift, origin_shift]
    end associate
  end subroutine find_box

  ! Halves the elements until the errors of load and area are within their tolerances.
  subroutine halve_elements(task, first_side, lattice, answer)
    type(cluster_task), intent(inout) :: task
    real(real64), intent(in) :: first_side
    type(cluster_lattice), intent(inout) :: lattice
    type(element_answer), intent(inout) :: answer
    real(real64) :: side, previous_totals(2)

    if (allocated(answer%failure)) return
    side = first_side
    lattice%halving_error = 0.0_real64
    call solve_in_window(task, lattice, answer, side, gap_residual * task%tolerance(1))
    do while (.not. allocated(answer%failure) .and. task%totals(1) > 0.0_real64)
      previous_totals = task%totals
      side = 0.5_real64 * side
      call solve_in_window(task, lattice, answer, side, gap_residual * task%tolerance(1))
      if (allocated(answer%failure)) return
      lattice%halving_error = remaining_errors(abs(task%totals / previous_totals - 1.0_real64))
      if (all(lattice%halving_error <= allowed_errors(task)) .and. &
          side < required_side(task, lattice, answer)) exit
      ! The rounding of coordinates is not small against the contact: further halving would converge
      ! slowly. The last change is the error estimate.
      associate (largest => task%shapes(task%origin))
        if (.not. is_radius_resolved(largest%x, largest%y, largest%contact_radius)) exit
      end associate
      ! The errors decrease at most with the third power of the side: the memory for a tolerance
      ! is checked ahead of time.
      call check_elements(lattice, side * min(0.5_real64, minval(allowed_errors(task) / &
        max(lattice%halving_error, tiny(side)))**(1.0_real64 / 3)), answer)
    end do
  end subroutine halve_elements

  ! Estimates the errors of load and area. The change by halving can be small by chance: the scatter
  ! of loads is a lower bound, but not above the error for a change equal to the tolerance.
  subroutine estimate_errors(task, lattice, answer)
    type(cluster_task), intent(in) :: task
    type(cluster_lattice), intent(in) :: lattice
    type(element_answer), intent(inout) :: answer

    real(real64) :: load, error(2)

    load = sum(answer%contacts%load)
    error = remaining_errors(task%tolerance)
    answer%error = max(lattice%halving_error(1) * load, &
                       min(deviations * norm2(answer%contacts%error), &
                           error(1) * max(task%reference(1), load)))
    if (lattice%halving_error(1) > 0.0_real64 .and. task%totals(1) > 0.0_real64) &
      answer%area_error = max(lattice%halving_error(2) / deviations, &
          area_error * (lattice%elements%side / scatter_radius(lattice, answer))**1.5_real64)
  end subroutine estimate_errors

  ! Tolerated errors of load and area, relative to those on the last lattice.
  function allowed_errors(task) result(share)
    type(cluster_task), intent(in) :: task
    real(real64) :: share(2)

    share = task%tolerance
    if (.not. task%target > 0.0_real64) &
      share = share * max(1.0_real64, task%reference / max(task%totals, tiny(share)))
  end function allowed_errors

  ! Largest side of the elements that meets the tolerance of the area, by its scatter, and that of
  ! the load by contacts that are smaller than an element.
  real(real64) function required_side(task, lattice, answer) result(side)
    type(cluster_task), intent(in) :: task
    type(cluster_lattice), intent(in) :: lattice
    type(element_answer), intent(in) :: answer
    real(real64) :: share(2)

    share = allowed_errors(task)
    side = scatter_radius(lattice, answer) * &
           (share(2) / (deviations * area_error))**(2.0_real64 / 3.0_real64)
    if (missed_load(task, lattice%elements, answer) > &
        share(1) * sum(answer%contacts%load) / task%pairs%modulus) &
      side = min(side, sqrt(0.5_real64) * lattice%elements%side)
  end function required_side

  ! Load over the modulus of contacts of which no element is loaded: that of their isolated contacts
  ! in the displacement at first touch, by the elements and by contacts outside.
  pure real(real64) function missed_load(task, lattice, answer) result(load)
    type(cluster_task), intent(in) :: task
    type(element_lattice), intent(in) :: lattice
    type(element_answer), intent(in) :: answer
    real(real64) :: penetration
    integer :: i, j, n

    load = 0.0_real64
    do n = 1, size(task%shapes)
      associate (contact => task%shapes(n))
        if (answer%contacts(contact%pair)%load > 0.0_real64) cycle
        i = floor((contact%x - lattice%x) / lattice%side) - lattice%left + 1
        j = floor((contact%y - lattice%y) / lattice%side) - lattice%bottom + 1
        if (min(i, j) < 1 .or. i > size(lattice%force, 1) .or. j > size(lattice%force, 2)) cycle
        penetration = contact%penetration + task%level - task%displacement(i, j) * lattice%depth - &
          outside_displacement(task%outside, task%pairs%modulus, contact%x, contact%y)
        if (penetration > 0.0_real64) load = load + 4.0_real64 / 3.0_real64 * &
          contact%contact_radius * penetration * sqrt(penetration / contact%penetration)
      end associate
    end do
  end function missed_load

  ! Radius a of a contact whose area has the same relative scatter, of the power -3/2 of a, as the
  ! sum of independent areas; or of equal circles with the total area and rim of the loaded
  ! elements, if that is larger, as contacts that merge have no rim between them. The rim of a
  ! circle of radius a has 8 a/h sides.
  real(real64) function scatter_radius(lattice, answer) result(radius)
    type(cluster_lattice), intent(in) :: lattice
    type(element_answer), intent(in) :: answer
    logical, allocatable :: loaded(:, :)
    integer :: columns, rows, sides

    columns = size(lattice%elements%force, 1)
    rows = size(lattice%elements%force, 2)
    allocate (loaded(columns, rows))
    loaded(:, :) = lattice%elements%force > 0.0_real64
    sides = count(loaded(:columns - 1, :) .neqv. loaded(2:, :)) + &
            count(loaded(:, :rows - 1) .neqv. loaded(:, 2:)) + count(loaded(1, :)) + &
            count(loaded(columns, :)) + count(loaded(:, 1)) + count(loaded(:, rows))
    radius = 0.0_real64
    if (any(answer%contacts%area > 0.0_real64)) radius = sqrt(1.0_real64 / pi) * &
      (sum(max(answer%contacts%area, 0.0_real64)) / (lattice%elements%side * &
       sqrt(sum(sqrt(max(answer%contacts%area, 0.0_real64))) * lattice%elements%side)))** &
      (2.0_real64 / 3.0_real64)
    radius = max(radius, 8 * count(loaded) / (pi * max(1, sides))) * lattice%elements%side
  end function scatter_radius

  ! Solves all contacts in the window with elements of a side, and sets the totals. The window is
  ! extended where elements on its rim, or contacts outside it, are loaded.
  subroutine solve_in_window(task, lattice, answer, side, residual)
    type(cluster_task), intent(inout) :: task
    type(cluster_lattice), intent(inout) :: lattice
    type(element_answer), intent(inout) :: answer
    real(real64), intent(in) :: side      ! side of an element
    real(real64), intent(in) :: residual  ! residual of the gaps over the largest penetration
    type(element_lattice) :: next
    real(real64) :: rim(4), growth, low(2), high(2)
    logical :: is_complete

    call bounding_box(task%shapes, lattice%x, lattice%y, low, high)
    growth = side
    task%totals = 0.0_real64
    do
      call check_elements(lattice, side, answer)
      if (allocated(answer%failure)) return
      call lay_elements(task%shapes, lattice%x, lattice%y, side, lattice%window, next)
      if (allocated(lattice%elements%force)) call transfer_forces(lattice%elements, next)
      call add_outside_field(task%outside, task%pairs%modulus, next)
      call solve_lattice(task, residual, next, answer)
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
      call extend_window(task, lattice, is_complete)
      if (is_complete .and. .not. any(rim > 0.0_real64)) exit
    end do
    associate (contacts => answer%contacts)
      contacts%load = 0.0_real64
      contacts%area = 0.0_real64
      contacts%pressure = 0.0_real64
      contacts%error = 0.0_real64
      call find_contacts(task%pairs%modulus, task%shapes, lattice%elements, contacts)
      task%totals = [sum(contacts%load), sum(contacts%area)]
      if (task%target > 0.0_real64) &
        task%totals(1) = max(0.0_real64, lattice%elements%depth + task%level)
    end associate
  end subroutine solve_in_window

  ! Sets a failure if elements of a side need more memory than is allowed or available.
  subroutine check_elements(lattice, side, answer)
    type(cluster_lattice), intent(in) :: lattice
    real(real64), intent(in) :: side
    type(element_answer), intent(inout) :: answer
    real(real64) :: share

    share = product((lattice%window(3:) - lattice%window(:2)) / side + 2) / elements_allowed
    if (.not. share < 1.0_real64) then
      answer%failure = 'the boundary elements would need more than 2 GiB of memory'
    else
      call check_memory('the boundary elements of a group of contacts', answer%failure, &
                        bytes=nint(share * 2.0_real64**31, int64) + bytes_of_plans)
    end if
  end subroutine check_elements

  ! Extends the window to each contact outside it that is loaded in the displacement there.
  subroutine extend_window(task, lattice, is_complete)
    type(cluster_task), intent(in) :: task
    type(cluster_lattice), intent(inout) :: lattice
    logical, intent(out) :: is_complete
    real(real64) :: position(2), gap, reach
    integer :: n

    is_complete = .true.
    do n = 1, size(task%shapes)
      associate (contact => task%shapes(n))
        position = [contact%x - lattice%x, contact%y - lattice%y]
        if (all(position > lattice%window(:2) .and. position < lattice%window(3:))) cycle
        gap = least_gap(contact, lattice%elements, task%outside, task%pairs%modulus) - task%level
        if (.not. gap < 0.0_real64) cycle
        is_complete = .false.
        reach = contact%contact_radius * sqrt(min(1.0_real64, -gap / contact%penetration)) + &
                lattice%elements%side
        lattice%window(:2) = min(lattice%window(:2), position - reach)
        lattice%window(3:) = max(lattice%window(3:), position + reach)
      end associate
    end do
  end subroutine extend_window

  ! Finds the forces on a lattice to a residual of the gaps over the largest penetration.
  subroutine solve_lattice(task, residual, next, answer)
    type(cluster_task), intent(inout) :: task
    real(real64), intent(in) :: residual
    type(element_lattice), intent(inout) :: next
    type(element_answer), intent(inout) :: answer
    type(lattice_convolution) :: influence
    type(force_bounds) :: bounds

    if (.not. task%pairs%interrupt%is_asked()) &
      call influence%prepare(mean_influence(size(next%gap, 1), size(next%gap, 2)), 1.0_real64)
    if (task%pairs%interrupt%is_asked()) answer%failure = 'interrupted'
    if (allocated(answer%failure)) return
    bounds%tolerance = residual
    if (task%target > 0.0_real64 .and. any(next%owner > 0)) then
      bounds%load = task%target / (next%depth * next%side)
      where (next%owner > 0) next%force = max(next%force, epsilon(residual))
      next%force = next%force * (bounds%load / sum(next%force))
    end if
    call find_forces(influence, next%gap, bounds, next%force, answer%ending, task%pairs%interrupt, &
                     level=task%level, displacement=task%displacement)
    task%level = merge(task%level * next%depth, 0.0_real64, bounds%load > 0.0_real64)
    if (.not. answer%ending%converged) &
      answer%failure = 'the pressures on the boundary elements did not converge'
  end subroutine solve_lattice

  ! Finds the box of the loaded elements and their neighbours, and of contacts smaller than an
  ! element that are loaded in the displacement there.
  pure subroutine find_loaded_box(task, lattice, box)
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
      associate (contact => task%shapes(n), x => task%shapes(n)%x - lattice%x, &
                 y => task%shapes(n)%y - lattice%y)
        if (all([x, y] > box(:2) .and. [x, y] < box(3:))) cycle
        i = floor(x / lattice%side) - lattice%left + 1
        j = floor(y / lattice%side) - lattice%bottom + 1
        if (min(i, j) < 1 .or. i > size(lattice%force, 1) .or. j > size(lattice%force, 2)) cycle
        if (.not. contact%penetration + task%level > task%displacement(i, j) * lattice%depth) cycle
        reach = min(contact%reach, lattice%side)
        box(:2) = min(box(:2), [x, y] - reach)
        box(3:) = max(box(3:), [x, y] + reach)
      end associate
    end do
  end subroutine find_loaded_box

  ! Longer side of a box, given by x, y of two corners.
  pure real(real64) function longer_side(box)
    real(real64), intent(in) :: box(4)

    longer_side = maxval(box(3:) - box(:2))
  end function longer_side

  ! Least gap of a contact in the displacement by elements and by contacts outside, or 0 if that is
  ! positive: at first touch and half an isolated contact radius from there, as a contact can be
  ! loaded beside first touch only.
  pure real(real64) function least_gap(profile, lattice, outside, modulus) result(gap)
    type(gap_shape), intent(in) :: profile
    type(element_lattice), intent(in) :: lattice
    type(outside_field), intent(in) :: outside
    real(real64), intent(in) :: modulus
    real(real64) :: position(2, 5)
    integer :: i

    position = 0.5_real64 * profile%contact_radius * &
               reshape([0, 0, -1, 0, 1, 0, 0, -1, 0, 1], [2, 5])
    gap = 0.0_real64
    do i = 1, size(position, 2)
      associate (x => position(1, i), y => position(2, i))
        gap = min(gap, gap_at(profile, x, y) + &
                       element_displacement(lattice, profile%x + x, profile%y + y) + &
                       outside_displacement(outside, modulus, profile%x + x, profile%y + y))
      end associate
    end do
  end function least_gap

  ! Whether the coordinates of a contact resolve its radius: at least half of their digits are finer
  ! than the radius.
  elemental logical function is_radius_resolved(x, y, contact_radius)
    real(real64), intent(in) :: x, y            ! position of first touch in plan
    real(real64), intent(in) :: contact_radius  ! contact radius, same unit

    is_radius_resolved = contact_radius > sqrt(epsilon(x)) * max(abs(x), abs(y))
  end function is_radius_resolved

  ! Relative errors of load and area after halving the elements has changed them: these are
  ! proportional to the powers 2 and 3/2 of the side of the elements.
  pure function remaining_errors(change) result(error)
    real(real64), intent(in) :: change(2)
    real(real64) :: error(2)

    error = change / ([4.0_real64, 2.0_real64**1.5_real64] - 1.0_real64)
  end function remaining_errors

  ! Penetration at which the centres of a pair are at equal height, or a centre is in the plane.
  elemental real(real64) function level_height(pair)
    type(contact_pair), intent(in) :: pair

    level_height = pair%zc
    if (.not. min(pair%upper_radius, pair%lower_radius) > 0.0_real64) level_height = pair%radius
  end function level_height

  ! Finds the gaps of the members that penetrate; `pair` is the index among the members.
  pure subroutine find_shapes(pairs, members, compression, shapes)
    type(contact_pairs), intent(in) :: pairs
    integer, intent(in) :: members(:)
    real(real64), intent(in) :: compression
    type(gap_shape), allocatable, intent(out) :: shapes(:)
    integer :: i, n

    allocate (shapes(count(compression - pairs%list(members)%gap > 0.0_real64)))
    n = 0
    do i = 1, size(members)
      associate (pair => pairs%list(members(i)))
        if (.not. compression - pair%gap > 0.0_real64) cycle
        n = n + 1
        shapes(n) = gap_of_pair(pair, i, compression - pair%gap)
      end associate
    end do
  end subroutine find_shapes

  ! Sets the forces on a lattice to those of the pressures on a solved one.
  pure subroutine transfer_forces(solved, next)
    type(element_lattice), intent(in) :: solved
    type(element_lattice), intent(inout) :: next
    real(real64) :: factor, ratio
    integer :: i, j, k, l

    ratio = next%side / solved%side
    factor = ratio * (solved%depth / next%depth)
    do j = 1, size(next%force, 2)
      l = floor(((next%bottom + j - 0.5_real64) * next%side + next%y - solved%y) / solved%side) - &
          solved%bottom + 1
      do i = 1, size(next%force, 1)
        if (next%owner(i, j) == 0) cycle
        k = floor(((next%left + i - 0.5_real64) * next%side + next%x - solved%x) / solved%side) - &
            solved%left + 1
        next%force(i, j) = 0.0_real64
        if (min(k, l) < 1 .or. k > size(solved%force, 1) .or. l > size(solved%force, 2)) cycle
        next%force(i, j) = factor * solved%force(k, l)
      end do
    end do
  end subroutine transfer_forces

end module asperity_element_solver
