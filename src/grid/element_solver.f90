!> A cluster of contacts resolved on boundary elements, under the field of the contacts outside.
!>
!> Problem: a half-space of the combined modulus under a rigid surface, the sum of both profiles;
!> the gap is vertical, also where a pair is inclined. Find the pressures >= 0 of least energy at a
!> given compression (asperity_element_forces), on square elements of uniform pressure.
!>
!> Method: the elements of one lattice are halved until the changes of load and area, extrapolated
!> with the order 3/2 of the elements, are below their tolerances (Richardson), and as small as the
!> scatter of areas and the smallest contacts require. The lattice covers a window, which is
!> extended where contacts outside it are loaded.
!>
!> Exits: converged; or a message in `failure`, where penetrations are too large or too small for
!> the model, memory is short, the pressures do not converge or the run is interrupted. Modifies the
!> lattice, which is used again while the largest penetration changes by less than a factor of 2.
module asperity_element_solver
  use asperity_lattice_convolution, only: lattice_convolution
  use asperity_element_answer, only: area_error, element_answer, element_contact, find_contacts, &
                                     keep_elements
  use asperity_element_influence, only: mean_influence
  use asperity_element_lattice, only: bounding_box, element_lattice, gap_at, gap_of_pair, &
                                      gap_shape, lay_elements
  use asperity_outside_field, only: add_outside_field, element_displacement, &
                                    outside_displacement, outside_field
  use asperity_constants, only: pi
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_element_forces, only: find_forces, force_bounds
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text, not_enough_memory
  use asperity_process, only: has_memory
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
    real(real64) :: totals(2) = 0.0_real64           ! load and area on the last lattice
    real(real64), allocatable :: displacement(:, :)  ! by element of the last lattice, over depth
  end type cluster_task

  ! Elements along the longer side of the box of a cluster while the box is searched; half as many
  ! at least on the first lattice that is halved, and twice as many at most in the radius of an
  ! isolated contact, whose load is in error by less than 1e-5 there (chosen).
  integer, parameter :: box_elements = 24
  ! Elements in a radius from which on the load of the isolated contact is taken from them, and that
  ! the least radius of a loaded contact has to have: with fewer the elements of the box are halved
  ! (chosen: else the load of 120 caps on caps has an error of 3 %).
  integer, parameter :: least_elements = 2
  ! Offset of the lattice from the contact with the largest isolated load, in elements of the first
  ! lattice that is halved, x and y (chosen: a symmetric offset lets the errors of elements at the
  ! rim add up; test: elements_suite.f90).
  real(real64), parameter :: lattice_offset(2) = [0.29_real64, 0.13_real64]
  !> Number of standard deviations of an area, and of a load, that its error estimate holds
  !! (chosen).
  real(real64), parameter, public :: deviations = 3.0_real64
  ! Residual of the gaps over the deepest penetration: so much while the box is searched, then so
  ! much times the tolerance of the load, whose error is then 0.44 of the residual in the root mean
  ! square (measured on 390 Hertz contacts).
  real(real64), parameter :: gap_residual = 0.004_real64
  ! Bytes that a cluster may use (chosen).
  real(real64), parameter :: bytes_allowed = 2.0_real64**31

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
  subroutine solve_elements(pairs, members, compression, outside, tolerance, reference, lattice, &
                            answer)
    type(contact_pairs), intent(in), target :: pairs       !! pairs of the position
    integer, intent(in) :: members(:)                      !! contacts, indices in the list of pairs
    real(real64), intent(in) :: compression                !! compression of the contacts [length]
    type(outside_field), intent(in), target :: outside     !! field of contacts not in the cluster
    real(real64), intent(in) :: tolerance(2)               !! relative errors of load and area
    real(real64), intent(in) :: reference(2)               !! least load and area they refer to
    type(cluster_lattice), intent(inout) :: lattice        !! last lattice, used again if possible
    type(element_answer), intent(out) :: answer            !! contacts and errors, or a failure
    type(cluster_task) :: task
    real(real64) :: first_side

    task%pairs => pairs
    task%outside => outside
    task%tolerance = tolerance
    task%reference = reference
    allocate (answer%contacts(size(members)), answer%isolated(size(members)))
    allocate (answer%is_isolated_solved(size(members)), source=.false.)
    answer%contacts%x = pairs%list(members)%x
    answer%contacts%y = pairs%list(members)%y
    call find_shapes(pairs, members, compression, task%shapes)
    associate (shapes => task%shapes)
      if (size(shapes) == 0) then
        answer%ending = solve_ending(.true., 0.0_real64, 0)
        return
      end if
      if (.not. all(shapes%penetration < level_height(pairs%list(members(shapes%pair))))) then
        answer%failure = 'a penetration reaches the level of the centres'
      else if (.not. maxval(shapes%penetration / shapes%curvature_radius)**2 > &
               tiny(compression)) then
        answer%failure = 'penetrations below the resolution of boundary elements'
      end if
      if (allocated(answer%failure)) return
      if (is_kept(lattice, maxval(shapes%penetration))) then
        call solve_in_window(task, lattice, answer, lattice%elements%side, &
                             gap_residual * tolerance(1))
      else
        call find_box(task, lattice, answer, first_side)
        call halve_elements(task, first_side, lattice, answer)
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
        call keep_elements(lattice%elements, members(shapes%pair), answer%pressures)
      if (allocated(outside%x)) &
        answer%outside_displacement = element_displacement(lattice%elements, outside%x, outside%y)
    end associate
  end subroutine solve_elements

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
      k = maxloc(shapes%contact_radius * shapes%penetration * shapes%cosine, 1)
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
          if (least_elements * side < shapes(k)%contact_radius) exit
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
      lattice%halving_error = remaining_error(abs(task%totals / previous_totals - 1.0_real64))
      if (all(lattice%halving_error <= allowed_errors(task)) .and. &
          side < required_side(task, lattice, answer)) exit
      ! The rounding of coordinates is not small against the contact: further halving would converge
      ! slowly. The last change is the error estimate.
      associate (largest => task%shapes(task%origin))
        if (.not. is_radius_resolved(largest%x, largest%y, largest%contact_radius)) exit
      end associate
      ! The errors decrease at most with the third power of the side: the memory for a tolerance
      ! is checked ahead of time.
      call check_memory(lattice, side * min(0.5_real64, minval(allowed_errors(task) / &
        max(lattice%halving_error, tiny(side)))**(1.0_real64 / 3)), answer)
    end do
  end subroutine halve_elements

  ! Estimates the errors of load and area. The change by halving can be small by chance: the scatter
  ! of loads is a lower bound, but not above the error for a change equal to the tolerance.
  subroutine estimate_errors(task, lattice, answer)
    type(cluster_task), intent(in) :: task
    type(cluster_lattice), intent(in) :: lattice
    type(element_answer), intent(inout) :: answer

    answer%error = max(lattice%halving_error(1) * task%totals(1), &
                       min(deviations * norm2(answer%contacts%error), &
                           remaining_error(task%tolerance(1)) * &
                           max(task%reference(1), task%totals(1))))
    if (lattice%halving_error(1) > 0.0_real64 .and. task%totals(1) > 0.0_real64) &
      answer%area_error = max(lattice%halving_error(2) / deviations, &
          area_error * (lattice%elements%side / largest_radius(lattice, answer))**1.5_real64)
  end subroutine estimate_errors

  ! Tolerated errors of load and area, relative to those on the last lattice.
  function allowed_errors(task) result(share)
    type(cluster_task), intent(in) :: task
    real(real64) :: share(2)

    share = task%tolerance * max(1.0_real64, task%reference / max(task%totals, tiny(share)))
  end function allowed_errors

  ! Largest side of the elements that meets the tolerance of the area, by its scatter, and resolves
  ! the smallest loaded contact.
  real(real64) function required_side(task, lattice, answer) result(side)
    type(cluster_task), intent(in) :: task
    type(cluster_lattice), intent(in) :: lattice
    type(element_answer), intent(in) :: answer
    real(real64) :: share(2)

    share = allowed_errors(task)
    side = largest_radius(lattice, answer) * &
           (share(2) / (deviations * area_error))**(2.0_real64 / 3.0_real64)
    if (sqrt(minval(answer%contacts%area, mask=answer%contacts%area > 0.0_real64) / pi) < &
        least_elements * side) &
      side = min(side, sqrt(0.5_real64) * longer_side(lattice%window) / box_elements)
  end function required_side

  ! Largest radius of a contact, or of equal circles with the total area and rim of the loaded
  ! elements, as contacts that merge have no rim between them. The rim of a circle of radius a has
  ! 8 a/h sides.
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
    radius = max(sqrt(maxval(answer%contacts%area) / pi), &
                 8 * count(loaded) * lattice%elements%side / (pi * max(1, sides)))
  end function largest_radius

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
      call check_memory(lattice, side, answer)
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
    end associate
  end subroutine solve_in_window

  ! Sets a failure if elements of a side need more memory than is allowed or available.
  subroutine check_memory(lattice, side, answer)
    type(cluster_lattice), intent(in) :: lattice
    real(real64), intent(in) :: side
    type(element_answer), intent(inout) :: answer
    real(real64) :: bytes

    ! 17 arrays of 8 bytes; 4 more for two spectra and a transform of the padded lattice.
    bytes = 8 * (17 + 4) * product((lattice%window(3:) - lattice%window(:2)) / side + 2)
    if (.not. bytes < bytes_allowed) then
      answer%failure = 'the boundary elements would need more than ' // &
                       decimal_text(nint(bytes_allowed / 2.0_real64**30)) // ' GiB of memory'
    else if (.not. has_memory(nint(bytes, int64))) then
      answer%failure = not_enough_memory // ' for the boundary elements of a group of contacts'
    end if
  end subroutine check_memory

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
        gap = least_gap(contact, lattice%elements, task%outside, task%pairs%modulus)
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

    if (.not. task%pairs%interrupt%is_asked()) &
      call influence%prepare(mean_influence(size(next%gap, 1), size(next%gap, 2)))
    if (task%pairs%interrupt%is_asked()) answer%failure = 'interrupted'
    if (allocated(answer%failure)) return
    call find_forces(influence, next%gap, force_bounds(tolerance=residual), next%force, &
                     answer%ending, task%pairs%interrupt, displacement=task%displacement)
    if (.not. answer%ending%converged) &
      answer%failure = 'the pressures on the boundary elements did not converge'
  end subroutine solve_lattice

  ! Solves each isolated contact on the elements of the cluster, as the discretisation errors then
  ! cancel in the ratio of loads. Contacts smaller than that have the load of Hertz' law.
  subroutine solve_isolated(task, lattice, answer)
    type(cluster_task), intent(inout) :: task
    type(cluster_lattice), intent(in) :: lattice
    type(element_answer), intent(inout) :: answer
    type(element_lattice) :: next
    type(solve_ending) :: ending
    real(real64) :: centre(2), side
    integer :: i

    ending = answer%ending
    do i = 1, size(task%shapes)
      associate (contact => task%shapes(i))
        answer%isolated(contact%pair) = hertz_contact(task%pairs%modulus, contact)
        if (.not. answer%contacts(contact%pair)%load > 0.0_real64) cycle
        answer%is_isolated_solved(contact%pair) = &
          contact%contact_radius > least_elements * lattice%elements%side
        if (.not. answer%is_isolated_solved(contact%pair)) cycle
        if (size(task%shapes) == 1 .and. .not. (allocated(task%outside%x) .or. &
                                                allocated(task%outside%node_displacement))) then
          answer%isolated = answer%contacts
          return
        end if
        side = lattice%elements%side * 2.0_real64**max(0, ceiling(log(contact%contact_radius / &
          (2 * box_elements * lattice%elements%side)) / log(2.0_real64)))
        centre = [contact%x - lattice%x, contact%y - lattice%y]
        call lay_elements(task%shapes(i:i), lattice%x, lattice%y, side, &
                          [centre - contact%contact_radius - side, &
                           centre + contact%contact_radius + side], next)
        call solve_lattice(task, gap_residual * task%tolerance(1), next, answer)
        if (allocated(answer%failure)) return
        call find_contacts(task%pairs%modulus, task%shapes(i:i), next, answer%isolated)
      end associate
    end do
    answer%ending = ending
  end subroutine solve_isolated

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
        if (.not. contact%penetration > task%displacement(i, j) * lattice%depth) cycle
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

  ! Relative error after halving the elements changed a result by `change`: errors are proportional
  ! to the power 3/2 of the side of the elements, those of loads to a higher power.
  elemental real(real64) function remaining_error(change)
    real(real64), intent(in) :: change

    remaining_error = change / (2.0_real64**1.5_real64 - 1.0_real64)
  end function remaining_error

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

  ! The isolated contact by Hertz' law. By its inclination a vertical section of a sphere has the
  ! curvature over the cosine across the slope, and over its third power along it: the radius is
  ! that of the circle of equal area.
  pure type(element_contact) function hertz_contact(modulus, profile) result(contact)
    real(real64), intent(in) :: modulus
    type(gap_shape), intent(in) :: profile

    associate (radius => profile%contact_radius * profile%cosine)
      contact%x = profile%x
      contact%y = profile%y
      contact%load = 4.0_real64 / 3.0_real64 * modulus * radius * profile%penetration
      contact%area = pi * radius**2
      if (radius > 0.0_real64) &
        contact%pressure = 2.0_real64 / pi * modulus * profile%penetration / radius
    end associate
  end function hertz_contact

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
