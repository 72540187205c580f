!> Contacts that share a half-space: Hertzian contacts, and boundary elements for the others.
!>
!> Problem: find the loads of all contacts at a compression, or at a total normal load, to a
!> relative error of the total load or of the compression, and of the area.
!>
!> Method: all contacts are coupled as Hertzian contacts, and corrected (circle_correction) where
!> they are elastic; the errors that are left are estimated. Those of large errors, with all that
!> are close to them, are solved on boundary elements: clusters of them on one lattice each, in the
!> field of all contacts outside. A cluster returns its loads and centres of pressure, and the
!> Hertzian contacts are coupled again with contacts that carry these loads there. This is block
!> coordinate descent (Gauss and Seidel) between clusters and Hertzian
!> contacts, with the derivatives of all loads in the second block. Where one lattice under all
!> contacts costs less than the clusters, it is solved instead.
!>
!> Exits: converged, where the last change of the total load is at most `elements_share` times the
!> tolerance of the elements; a message in `failure`, where a solve failed or after as many
!> iterations as a number has binary digits.
module asperity_joint_contacts
  use asperity_circle_correction, only: circle_correction
  use asperity_circle_error, only: circle_errors, find_errors, find_open_neighbours, &
                                   sphere_share
  use asperity_element_answer, only: area_error
  use asperity_element_lattice, only: penetration_of_load, radius_of_load
  use asperity_element_solver, only: deviations, elements_allowed, solve_elements
  use asperity_circle_field, only: are_close, circle_set, inclination_factor, linear_residual
  use asperity_constants, only: pi
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_contacts, only: adopt_penetrations, coupled_solution, resolved_contacts, &
                                       solve_coupled
  use asperity_coupled_state, only: answer_at, correct_to_load, find_carried_load, raise_to_load
  use asperity_element_pressures, only: join_elements
  use asperity_hertz_law, only: hertz_law
  use asperity_index_groups, only: gather_groups
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: real64
  use asperity_outside_field, only: outside_field
  use asperity_problems, only: decimal_text, real_text
  use asperity_resolved_answers, only: represent_clusters, distribute_loads
  use asperity_resolved_clusters, only: cluster, form_clusters, solve_clusters
  use asperity_source_tree, only: source_tree
  implicit none
  private

  public :: joint_solution, resolve_all, resolve_called_for, resolve_none, solve_joint

  !> Solution of the contacts of a position.
  type :: joint_solution
    type(coupled_solution) :: coupled               !! compression, penetrations, circles
    real(real64), allocatable :: area(:)            !! by pair: contact area in plan
    real(real64), allocatable :: maximum_pressure(:)  !! by pair; below 0: that of its law
    logical, allocatable :: is_resolved(:)          !! by pair: solved on boundary elements
    integer :: clusters = 0, elements = 0           !! numbers of clusters and of their elements
    integer :: iterations = 0                       !! iterations of clusters and Hertzian contacts
    real(real64) :: error = 0.0_real64              !! relative error of the load or compression
    real(real64) :: area_error = 0.0_real64         !! relative error of the area, estimate
    real(real64) :: nested = 0.0_real64             !! share of the load on nested contacts
    character(len=:), allocatable :: failure        !! error message; not allocated if solved
  end type joint_solution

  !> Which contacts are resolved by boundary elements.
  enum, bind(c)
    enumerator :: resolve_none, resolve_all, resolve_called_for
  end enum

  ! Share of the tolerance for the boundary elements, where there are any: Hertzian contacts have
  ! the rest. Also that of the last change of the total load by iterations, of which the tolerance
  ! is that of the elements (chosen).
  real(real64), parameter :: elements_share = 0.25_real64
  ! Relative error of an area on elements of any size, as it is extrapolated from pressures as those
  ! of Hertz. Measured on fine elements beside reference_output/interaction/dense.csv: 99 of 100
  ! scenes have less, none has twice as much (test: areas in test/effects/test_dense.py).
  real(real64), parameter :: extrapolation_error = 1.5e-3_real64
  ! Distance in sums of radii below which Hertzian contacts are resolved together, with the open
  ! contacts within as many radii (chosen: close to a large contact the error estimated for a small
  ! one is a third of the true one; test: errors in test/effects/test_dense.py).
  real(real64), parameter :: adjacent_distance = 1.1_real64

  ! A position, the accuracy of its solution, and the intermediate results of the stages.
  type :: joint_task
    type(contact_pairs), pointer :: pairs => null()
    class(contact_law), pointer :: law => null()
    integer :: choice = resolve_none                 ! contacts to resolve: `resolve_none` ...
    real(real64) :: tolerance = 0.0_real64           ! relative error of load and area
    real(real64) :: elements_tolerance = 0.0_real64  ! relative error of loads on elements
    real(real64) :: area_tolerance = 0.0_real64      ! least relative error of the area
    real(real64), allocatable :: target              ! normal load; else at a compression
    type(circle_correction) :: correction            ! of the Hertzian contacts
    type(circle_errors) :: errors                    ! of the corrected Hertzian contacts
    real(real64) :: compression_share = 1.0_real64   ! error of the compression over that of a load
    real(real64) :: last_change = 0.0_real64         ! relative, of the load in the last iteration
    type(resolved_contacts) :: resolved
    type(cluster), allocatable :: clusters(:)
  end type joint_task

contains

  !> Solves the contacts at the compression in `solution%coupled`, or at a load (problem, method and
  !> exits: see the module).
  subroutine solve_joint(pairs, law, choice, tolerance, cluster_tolerance, area_tolerance, &
                         solution, target)
    type(contact_pairs), intent(in), target :: pairs   !! pairs that may touch, ascending gap
    class(contact_law), intent(in), target :: law      !! contact law of each pair
    integer, intent(in) :: choice                      !! contacts to resolve: `resolve_none` ...
    real(real64), intent(in) :: tolerance              !! relative error of load and area
    real(real64), intent(in) :: cluster_tolerance      !! relative error of the load on elements
    real(real64), intent(in) :: area_tolerance         !! least relative error of the area
    type(joint_solution), intent(inout) :: solution    !! compression; then all components
    real(real64), intent(in), optional :: target       !! normal load [force]
    type(joint_task) :: task

    if (associated(pairs%pressures)) pairs%pressures%compression = -1.0_real64
    task%pairs => pairs
    task%law => law
    task%choice = choice
    task%tolerance = tolerance
    task%elements_tolerance = merge(cluster_tolerance, elements_share * tolerance, &
                                    choice == resolve_all)
    task%area_tolerance = area_tolerance
    if (present(target)) task%target = target
    associate (n => size(pairs%list))
      allocate (solution%is_resolved(n), source=.false.)
      allocate (solution%area(n), source=0.0_real64)
      allocate (solution%maximum_pressure(n), source=-1.0_real64)
    end associate
    call solve_coupled(pairs, law, solution%coupled, task%target)
    call adopt_failure(solution)
    if (allocated(solution%failure)) return
    if (choice == resolve_all) &
      solution%is_resolved = pairs%list%gap < solution%coupled%compression
    if (sum(solution%coupled%set%load) > 0.0_real64) then
      call find_errors(pairs, solution%coupled, keeps_load(task), task%correction, &
                       task%errors)
      if (choice == resolve_called_for) call choose_resolved(task, solution%coupled, &
                                                             solution%is_resolved)
      if (.not. any(solution%is_resolved)) call correct_circles(task, solution)
    end if
    if (any(solution%is_resolved)) call alternate_blocks(task, solution)
    if (allocated(solution%failure)) return
    if (allocated(task%clusters)) then
      solution%clusters = size(task%clusters)
      solution%elements = sum(task%clusters%answer%elements)
      if (associated(pairs%pressures)) then
        call join_elements(task%clusters%answer%pressures, pairs%pressures)
        pairs%pressures%compression = solution%coupled%compression
      end if
    end if
    ! Penetrations of open contacts are negative, as 0 is a contact at first touch.
    where (solution%coupled%stays_open) solution%coupled%penetration = -tiny(1.0_real64)
    call set_cluster_areas(task, solution)
    call estimate_errors(task, solution)
  end subroutine solve_joint

  ! Sets loads and areas of contacts by their law, and corrects those of elastic ones: the
  ! penetration of an isolated contact is a power 2/3 of its load.
  subroutine correct_circles(task, solution)
    type(joint_task), intent(inout) :: task
    type(joint_solution), intent(inout) :: solution
    type(contact_response) :: response
    integer :: k

    task%compression_share = task%errors%compression_share
    associate (coupled => solution%coupled, set => solution%coupled%set, pairs => task%pairs, &
               contact => solution%coupled%set%contact)
      if (same_type_as(task%law, hertz_law())) then
        coupled%penetration(contact) = coupled%penetration(contact) * &
          (1 + task%correction%load_change / set%load)**(2.0_real64 / 3)
        coupled%compression = coupled%compression + task%correction%compression_change
        if (allocated(task%target)) &
          call correct_to_load(pairs, task%law, task%target / pairs%modulus, coupled)
      else
        ! A correction that is not made is an error of the area.
        task%errors%of_shape(contact, 2) = task%errors%of_shape(contact, 2) + set%radius**2 * &
          abs(task%correction%area_ratio - 1.0_real64) / sum(set%radius**2)
        task%correction%area_ratio = 1.0_real64
      end if
      do k = 1, size(contact)
        response = answer_at(pairs, task%law, contact(k), coupled%penetration(contact(k)))
        set%load(k) = response%vertical_load * inclination_factor(response%cosine) / pairs%modulus
        solution%area(contact(k)) = pi * response%contact_radius**2 * task%correction%area_ratio(k)
      end do
    end associate
  end subroutine correct_circles

  ! Solves clusters and Hertzian contacts in turns until the total load converges.
  subroutine alternate_blocks(task, solution)
    type(joint_task), intent(inout) :: task
    type(joint_solution), intent(inout) :: solution
    type(cluster), allocatable :: previous_clusters(:)
    real(real64) :: area_tolerance, load, previous_load, tolerance
    logical :: has_grown

    tolerance = elements_share * task%elements_tolerance
    area_tolerance = max(task%area_tolerance, merge(task%elements_tolerance, task%tolerance, &
                                                    task%choice == resolve_all))
    has_grown = .true.
    associate (pairs => task%pairs, coupled => solution%coupled, &
               is_resolved => solution%is_resolved)
      do
        if (has_grown) then
          if (allocated(task%clusters)) call move_alloc(task%clusters, previous_clusters)
          call form_clusters(pairs, coupled, is_resolved, task%clusters, solution%failure)
          if (allocated(solution%failure)) return
          if (allocated(previous_clusters)) call keep_lattices(previous_clusters, task%clusters)
          task%resolved = resolved_contacts(is_resolved, pairs%list%x, pairs%list%y, pairs%list%gap)
          if (is_one_grid_cheaper(task, coupled)) then
            call solve_one_grid(task, solution)
            return
          end if
        end if
        solution%iterations = solution%iterations + 1
        call solve_clusters(pairs, coupled, task%elements_tolerance, area_tolerance, &
                            task%clusters, solution%failure)
        if (allocated(solution%failure)) return
        call add_close_contacts(pairs, task%clusters, is_resolved, has_grown)
        if (has_grown) cycle
        task%clusters%is_solved = .false.
        call represent_clusters(pairs, task%law, task%clusters, coupled, task%resolved)
        call adopt_failure(solution)
        if (allocated(solution%failure)) return
        ! The change of the load by this coupling is the error of the field in which the clusters
        ! were solved. At a prescribed load it is that of their loads at the last compression.
        previous_load = sum(coupled%set%load)
        call solve_coupled(pairs, task%law, coupled, task%target, task%resolved)
        call adopt_failure(solution)
        if (allocated(solution%failure)) return
        load = sum(coupled%set%load)
        task%last_change = abs(load - previous_load) / max(load, tiny(load))
        if (task%last_change <= tolerance) exit
        if (solution%iterations == digits(tolerance)) then
          solution%failure = 'Hertzian contacts and boundary elements did not converge together'
          return
        end if
      end do
      call find_errors(pairs, coupled, keeps_load(task), task%correction, task%errors)
      call correct_circles(task, solution)
      call distribute_loads(pairs, task%law, task%clusters, coupled, task%resolved, task%target)
    end associate
    call adopt_failure(solution)
  end subroutine alternate_blocks

  ! Whether the correction keeps the load: it is made of elastic contacts alone.
  pure logical function keeps_load(task)
    type(joint_task), intent(in) :: task

    keeps_load = allocated(task%target) .and. same_type_as(task%law, hertz_law())
  end function keeps_load

  ! Estimates the errors of the load, or of the compression at a load, and of the area.
  subroutine estimate_errors(task, solution)
    type(joint_task), intent(in) :: task
    type(joint_solution), intent(inout) :: solution
    real(real64) :: total, area, spheres
    integer :: k

    associate (coupled => solution%coupled, is_resolved => solution%is_resolved)
      area = sum(solution%area)
      if (allocated(task%errors%of_field)) &
        solution%area_error = norm2(pack(task%errors%of_field(:, 2), .not. is_resolved)) + &
                              sum(task%errors%of_shape(:, 2), mask=.not. is_resolved)
      if (area > 0.0_real64 .and. allocated(task%clusters)) &
        solution%area_error = solution%area_error + hypot(deviations * norm2([( &
          task%clusters(k)%answer%area_error * sum(solution%area(task%clusters(k)%members)), &
          k=1, size(task%clusters))]) / area, &
          extrapolation_error * sum(solution%area, mask=is_resolved) / area)
      total = sum(coupled%set%load)
      if (.not. total > 0.0_real64) return
      if (allocated(task%errors%is_nested)) solution%nested = &
        sum(coupled%set%load, mask=task%errors%is_nested(coupled%set%contact)) / total
      if (allocated(task%errors%of_field)) solution%error = ( &
        norm2(pack(task%errors%of_field(:, 1), .not. is_resolved)) + &
        sum(task%errors%of_shape(:, 1), mask=.not. is_resolved)) / total
      if (allocated(task%clusters)) then
        ! Displacements by neighbours change the inclination of the line of centres, and with it the
        ! normal load at a vertical load.
        associate (set => coupled%set, pair => task%pairs%list(coupled%set%contact))
          if (allocated(task%target)) solution%error = solution%error + &
            sum(set%load * (pair%d / pair%zc)**2 * max(0.0_real64, coupled%compression - &
                                                       pair%gap - &
                coupled%penetration(set%contact)) / pair%zc, mask=is_resolved(set%contact)) / total
        end associate
        ! Discretisation errors add up, as they reduce the loads of all clusters. The last change,
        ! which alternates and contracts, is independent of them.
        solution%error = solution%error + norm2([(sum(task%clusters%answer%error) + norm2([( &
          task%clusters(k)%answer%ending%residual * sum(task%clusters(k)%answer%contacts%load), &
          k=1, size(task%clusters))])) / (task%pairs%modulus * total), task%last_change])
      end if
      ! The law and the elements have paraboloids for spheres.
      spheres = sum(coupled%set%load * sphere_share(task%pairs%list(coupled%set%contact), &
                                                    coupled%penetration(coupled%set%contact))) / &
                total
      if (allocated(task%target)) then
        solution%error = task%compression_share * solution%error
        spheres = task%errors%compression_share * spheres
      end if
      solution%error = solution%error + spheres
    end associate
  end subroutine estimate_errors

  ! Whether one lattice under all contacts costs less than the lattices of the clusters: elements
  ! times the logarithm of their number, by the transforms of a product, and for clusters times the
  ! iterations until changes that contract by a half are below `elements_share`. One lattice serves
  ! also where the only cluster has all loaded contacts.
  logical function is_one_grid_cheaper(task, coupled) result(is_cheaper)
    type(joint_task), intent(in) :: task
    type(coupled_solution), intent(in) :: coupled
    integer :: circle_of(size(task%pairs%list)), i, k
    real(real64) :: cluster_elements(size(task%clusters)), reference(2), elements

    associate (set => coupled%set)
      circle_of = 0
      circle_of(set%contact) = [(i, i=1, size(set%contact))]
      reference = [sum(set%load), pi * sum(set%radius**2)]
      elements = elements_needed(task, grid_tolerance(task), set, [(i, i=1, size(set%contact))], &
                                 reference)
      do k = 1, size(task%clusters)
        associate (circles => circle_of(task%clusters(k)%members), n => size(task%clusters))
          cluster_elements(k) = elements_needed( &
            task, task%elements_tolerance, set, pack(circles, circles > 0), &
            reference / [real(n, real64), sqrt(real(n, real64))])
        end associate
      end do
      is_cheaper = (size(task%clusters) == 1 .and. all(task%resolved%is_resolved(set%contact))) &
        .or. (elements < elements_allowed .and. elements * log(elements) < &
              log(elements_share) / log(0.5_real64) * sum(cluster_elements * log(cluster_elements)))
    end associate
  end function is_one_grid_cheaper

  ! Number of elements under circles whose load and area are in error by the tolerances, by the
  ! errors of isolated contacts (asperity_element_answer): these of loads add up, those of areas are
  ! independent.
  real(real64) function elements_needed(task, tolerance, set, circles, reference) result(elements)
    type(joint_task), intent(in) :: task
    real(real64), intent(in) :: tolerance      ! of loads on elements, relative
    type(circle_set), intent(in) :: set
    integer, intent(in) :: circles(:)
    real(real64), intent(in) :: reference(2)   ! least load over the modulus, and area
    real(real64) :: side

    elements = 2.0_real64
    if (size(circles) == 0) return
    associate (x => set%x(circles), y => set%y(circles), load => set%load(circles), &
               radius => set%radius(circles))
      side = min((tolerance * max(reference(1), sum(load)) / &
                  (0.5_real64 * area_error * sum(load / radius**2.5_real64)))**0.4_real64, &
                 (max(tolerance, task%area_tolerance) * &
                  max(reference(2), pi * sum(radius**2)) / &
                  (deviations * area_error * pi * norm2(sqrt(radius))))**(2.0_real64 / 3.0_real64))
      elements = elements + (maxval(x + radius) - minval(x - radius)) * &
                 (maxval(y + radius) - minval(y - radius)) / side**2
    end associate
  end function elements_needed

  ! Relative error of the load on one lattice under all contacts: none is Hertzian, so the elements
  ! have half of the tolerance (with all of it an area was in error by 1.6 times the tolerance:
  ! test_blunter_caps_below in test/effects/test_dense.py).
  pure real(real64) function grid_tolerance(task)
    type(joint_task), intent(in) :: task

    grid_tolerance = task%elements_tolerance
    if (task%choice == resolve_called_for) grid_tolerance = 0.5_real64 * task%tolerance
  end function grid_tolerance

  ! Solves all contacts on one lattice, at a compression or at a load. The given load is that of the
  ! law, and the sum of the forces on elements differs from it by inclinations: a few iterations.
  ! Exits: solved, or a message in `failure`.
  subroutine solve_one_grid(task, solution)
    type(joint_task), intent(inout) :: task
    type(joint_solution), intent(inout) :: solution
    real(real64), allocatable :: force
    real(real64) :: load, slope, tolerance
    integer :: i

    tolerance = grid_tolerance(task)
    task%compression_share = 1.0_real64
    if (size(task%clusters) > 1) task%clusters = task%clusters(1:1)
    associate (coupled => solution%coupled, pairs => task%pairs, grid => task%clusters(1), &
               resolved => task%resolved)
      if (allocated(task%target)) force = pairs%modulus * sum(coupled%set%load)
      grid%members = [(i, i=1, size(pairs%list))]
      coupled%shift = 0.0_real64
      do
        solution%iterations = solution%iterations + 1
        call solve_elements(pairs, grid%members, coupled%compression, outside_field(), &
                            reshape([tolerance, max(tolerance, task%area_tolerance), 0.0_real64, &
                                 0.0_real64], [2, 2]), &
                            grid%lattice, grid%answer, force)
        if (allocated(grid%answer%failure)) solution%failure = grid%answer%failure
        if (allocated(solution%failure)) return
        coupled%compression = grid%answer%compression
        associate (contacts => grid%answer%contacts)
          coupled%stays_open = .not. contacts%load > 0.0_real64
          coupled%penetration = merge(0.0_real64, penetration_of_load(pairs%list, contacts%load / &
                                                                      pairs%modulus), &
                                      coupled%stays_open)
          resolved = resolved_contacts(pairs%list%gap < coupled%compression .or. &
                                       contacts%load > 0.0_real64, contacts%x, contacts%y, &
                                       pairs%list%gap)
        end associate
        if (.not. allocated(task%target)) exit
        call find_carried_load(pairs, task%law, coupled, 0.0_real64, load, slope)
        load = load * pairs%modulus
        if (abs(load - task%target) <= linear_residual * tolerance * task%target) exit
        if (solution%iterations == digits(load)) then
          solution%failure = 'the load of the boundary elements was not met'
          return
        end if
        force = force * (task%target / load)
      end do
      if (allocated(task%target)) &
        call raise_to_load(pairs, task%law, task%target / pairs%modulus, coupled)
      solution%is_resolved = resolved%is_resolved
      coupled%ending = grid%answer%ending
      call adopt_penetrations(pairs, task%law, coupled, resolved)
    end associate
    call adopt_failure(solution)
  end subroutine solve_one_grid

  ! Copies lattices and answers from previous clusters of the same members.
  subroutine keep_lattices(previous_clusters, clusters)
    type(cluster), intent(in) :: previous_clusters(:)
    type(cluster), intent(inout) :: clusters(:)
    integer :: i, k

    do k = 1, size(clusters)
      do i = 1, size(previous_clusters)
        if (size(previous_clusters(i)%members) /= size(clusters(k)%members)) cycle
        if (any(previous_clusters(i)%members /= clusters(k)%members)) cycle
        clusters(k)%lattice = previous_clusters(i)%lattice
        clusters(k)%answer = previous_clusters(i)%answer
        clusters(k)%is_solved = previous_clusters(i)%is_solved
        exit
      end do
    end do
  end subroutine keep_lattices

  ! Sets the failure of a solution if its coupled solve has failed.
  subroutine adopt_failure(solution)
    type(joint_solution), intent(inout) :: solution

    if (allocated(solution%coupled%failure)) then
      solution%failure = solution%coupled%failure
    else if (.not. solution%coupled%ending%converged) then
      solution%failure = 'did not converge: residual ' // &
                         real_text(solution%coupled%ending%residual, 'es9.1e3') // &
                         ', iteration ' // decimal_text(solution%coupled%ending%iterations)
    end if
  end subroutine adopt_failure

  ! Sets areas in plan and maximum pressures of contacts on elements: these are multiplied by the
  ! ratio of the law and of the paraboloid at the load of the contact, 1 but for the inclination.
  subroutine set_cluster_areas(task, solution)
    type(joint_task), intent(in) :: task
    type(joint_solution), intent(inout) :: solution
    type(contact_response) :: response
    real(real64) :: penetration, radius
    integer :: i, k, m

    associate (coupled => solution%coupled, pairs => task%pairs)
      if (.not. allocated(task%clusters)) return
      do k = 1, size(task%clusters)
        associate (this_cluster => task%clusters(k), answer => task%clusters(k)%answer)
          do m = 1, size(this_cluster%members)
            i = this_cluster%members(m)
            if (.not. coupled%penetration(i) > 0.0_real64) cycle
            penetration = penetration_of_load(pairs%list(i), answer%contacts(m)%load / &
                                              pairs%modulus)
            if (.not. penetration > 0.0_real64) cycle
            radius = radius_of_load(pairs%list(i), answer%contacts(m)%load / pairs%modulus)
            call task%law%respond(pairs%list(i), i, penetration, response)
            solution%area(i) = answer%contacts(m)%area * (response%contact_radius / radius)**2
            solution%maximum_pressure(i) = answer%contacts(m)%pressure * &
              response%maximum_pressure * pi * radius**2 / (1.5_real64 * answer%contacts(m)%load)
          end do
        end associate
      end do
    end associate
  end subroutine set_cluster_areas

  ! Adds contacts to those resolved until the errors of the others are within the tolerances.
  subroutine choose_resolved(task, coupled, is_resolved)
    type(joint_task), intent(in) :: task
    type(coupled_solution), intent(in) :: coupled   ! solved Hertzian contacts
    logical, intent(inout) :: is_resolved(:)
    type(source_tree) :: tree
    integer, allocatable :: open_pairs(:), member(:), first(:)
    real(real64) :: error(size(is_resolved)), allowed(2), excess, resolved_error
    integer :: order(size(is_resolved)), i, k, l, next_rank

    ! Elements do not resolve contacts whose loads underflow.
    allowed = [task%tolerance * sum(coupled%set%load), max(task%tolerance, task%area_tolerance)]
    if (.not. allowed(1) > tiny(allowed)) return
    if (allocated(task%target)) allowed(1) = allowed(1) / task%errors%compression_share
    if (.not. (any(is_resolved) .or. excess_error() > 0.0_real64)) return
    allowed = (1 - elements_share) * allowed
    error = maxval((task%errors%of_field + task%errors%of_shape) / &
                   spread(allowed, 1, size(error)), 2)
    associate (set => coupled%set)
      call gather_groups(set%one, set%other, &
                         [(are_close(set, set%one(k), set%other(k), adjacent_distance), k=1, &
                           size(set%one))], &
                         spread(.true., 1, size(set%contact)), size(set%contact), member, first)
      call find_open_neighbours(task%pairs, coupled, adjacent_distance, tree, open_pairs)
      call sort_keys(-error, order)
      next_rank = 1
      do
        do k = 1, size(first) - 1
          associate (group => set%contact(member(first(k):first(k + 1) - 1)))
            is_resolved(group) = any(is_resolved(group))
          end associate
        end do
        do i = 1, size(open_pairs)
          do l = tree%first(i), tree%first(i + 1) - 1
            if (is_resolved(set%contact(tree%near(l)))) is_resolved(open_pairs(i)) = .true.
          end do
        end do
        excess = excess_error()
        if (.not. excess > 0.0_real64) exit
        ! Contacts of the largest errors, up to half of the excess in one pass: the contacts close
        ! to them, which are resolved with them, may have most of the rest.
        resolved_error = 0.0_real64
        do while (resolved_error < excess - resolved_error .and. next_rank <= size(order))
          i = order(next_rank)
          next_rank = next_rank + 1
          if (is_resolved(i)) cycle
          is_resolved(i) = .true.
          if (task%errors%covering(i) > 0) is_resolved(task%errors%covering(i)) = .true.
          resolved_error = resolved_error + error(i)
        end do
      end do
    end associate

  contains

    ! Error of the contacts that are not resolved, over what is allowed, less 1.
    real(real64) function excess_error() result(excess)
      integer :: l

      excess = maxval([((norm2(pack(task%errors%of_field(:, l), .not. is_resolved)) + &
                         sum(task%errors%of_shape(:, l), mask=.not. is_resolved)) / allowed(l), &
                        l=1, 2)]) - 1
    end function excess_error

  end subroutine choose_resolved

  ! Adds Hertzian contacts that are close to loaded members of a cluster to those resolved: the
  ! centre of pressure of a ring is inside the contact that it surrounds.
  subroutine add_close_contacts(pairs, clusters, is_resolved, has_grown)
    type(contact_pairs), intent(in) :: pairs
    type(cluster), intent(in) :: clusters(:)      ! solved clusters
    logical, intent(inout) :: is_resolved(:)
    logical, intent(out) :: has_grown             ! whether contacts were added
    integer :: k, l

    has_grown = .false.
    do k = 1, size(clusters)
      associate (outside => clusters(k)%outside, contacts => clusters(k)%answer%contacts, &
                 list => pairs%list(clusters(k)%members))
        if (.not. allocated(outside%pair)) cycle
        do l = 1, size(outside%pair)
          if (is_resolved(outside%pair(l))) cycle
          ! Members count with the radii of Hertzian contacts of their loads.
          if (.not. any(contacts%load > 0.0_real64 .and. &
                        hypot(contacts%x - outside%x(l), contacts%y - outside%y(l)) < &
                        adjacent_distance * (outside%radius(l) + (0.75_real64 * contacts%load / &
                                             pairs%modulus * list%radius)**(1.0_real64 / 3)))) cycle
          is_resolved(outside%pair(l)) = .true.
          has_grown = .true.
        end do
      end associate
    end do
  end subroutine add_close_contacts

end module asperity_joint_contacts
