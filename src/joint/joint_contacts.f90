!> Contacts that share a half-space: Hertzian contacts, and boundary elements for the others.
!>
!> All contacts are coupled as Hertzian contacts. Those whose indicated error is too large, with all
!> that are close to them, are solved on boundary elements, a cluster on a lattice, in the field of
!> all others. A cluster returns its loads and the centres of its pressures. The Hertzian contacts
!> are coupled again with contacts that carry these loads there. This is block coordinate descent
!> (Gauss and Seidel) between clusters and Hertzian contacts, with the derivatives of all loads in
!> the second block. Exits: converged, where the total load changes by `settled` times the tolerance
!> at most; not converged after `most_rounds` rounds.
!>
!> One cluster of all contacts needs no Hertzian contacts. Its compression at a load is found by
!> secants in a bracket, with elements of a coarse tolerance first.
module asperity_joint_contacts
  use asperity_circle_error, only: find_errors, find_open_neighbours
  use asperity_outside_field, only: outside_field
  use asperity_element_solver, only: any_loaded, cluster_lattice, deviations
  use asperity_circle_field, only: are_close
  use asperity_constants, only: pi
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_contacts, only: adopt_penetrations, coupled_solution, resolved_contacts, &
                                       solve_coupled
  use asperity_coupled_groups, only: group_law
  use asperity_coupled_state, only: find_carried_load, far_below, raise_to_load
  use asperity_element_pressures, only: join_elements
  use asperity_index_groups, only: gather_groups
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: real64
  use asperity_near_tops, only: find_near_tops
  use asperity_problems, only: decimal_text, real_text
  use asperity_resolved_answers, only: represent_clusters, distribute_loads
  use asperity_resolved_clusters, only: area_per_load, cluster, form_clusters, solve_clusters
  use asperity_source_tree, only: source_tree
  implicit none
  private

  public :: joint_solution, resolve_all, resolve_called_for, resolve_none, solve_joint

  !> Solution of the contacts of a position.
  type :: joint_solution
    type(coupled_solution) :: coupled               !! compression, penetrations, circles
    real(real64), allocatable :: area(:)            !! in plan, by pair
    real(real64), allocatable :: maximum_pressure(:)  !! by pair; below 0: that of its law
    logical, allocatable :: is_resolved(:)          !! by pair
    integer :: clusters = 0, elements = 0           !! of the resolved; number of elements
    integer :: rounds = 0                           !! of Hertzian contacts and clusters
    real(real64) :: error = 0.0_real64              !! estimate, a share of load or closing
    real(real64) :: area_error = 0.0_real64         !! estimate, a share of the area
    real(real64) :: nested = 0.0_real64             !! share of the load on nested contacts
    character(len=:), allocatable :: failure        !! why there is none
  end type joint_solution

  !> Which contacts are resolved by boundary elements.
  enum, bind(c)
    enumerator :: resolve_none, resolve_all, resolve_called_for
  end enum

  ! Share of the tolerance for the boundary elements; the errors of areas, and of spheres as
  ! paraboloids, have what it leaves, those of Hertzian contacts half of that (chosen; test: errors
  ! within the tolerance in test/regression/test_dense.py).
  real(real64), parameter :: elements_share = 0.25_real64
  ! Share of the tolerance of a load by which one cluster may miss a given load, and by which the
  ! last round of Hertzian contacts and boundary elements may change the total; as a relative error
  ! of the load that of the elements while the compression is searched (chosen; test: load that a
  ! separation gave in test/regression/test_dense.py).
  real(real64), parameter :: settled = 0.02_real64
  ! Largest number of rounds (chosen; test: loads of clusters in test/unit/joint_suite.f90).
  integer, parameter :: most_rounds = 30
  ! Sums of radii: Hertzian contacts nearer to each other go to boundary elements together, with the
  ! open contacts within as many radii (chosen: just beside a large contact the error indicated for
  ! a small one is a third of the true one; test: errors in test/regression/test_dense.py).
  real(real64), parameter :: along = 1.1_real64

  ! A position, what is asked of its solution, and what the stages leave to each other.
  type :: joint_task
    type(contact_pairs), pointer :: pairs => null()
    class(contact_law), pointer :: law => null()
    integer :: which = resolve_none                  ! `resolve_none` ...
    real(real64) :: tolerance = 0.0_real64           ! relative error of load and area
    real(real64) :: elements_tolerance = 0.0_real64  ! relative error of loads on elements
    real(real64) :: area_tolerance = 0.0_real64      ! least relative error of the area
    real(real64), allocatable :: target              ! normal load, or at a given compression
    logical, allocatable :: is_near(:), is_host(:)   ! by pair: first touches are near
    real(real64), allocatable :: radius(:)           ! by pair: least radius for clusters
    !> errors of load and area as a Hertzian contact, and of the load as a paraboloid, by pair
    real(real64), allocatable :: error(:), area_error(:), sphere_error(:)
    real(real64) :: compression_share = 1.0_real64   ! error of the compression over that of a load
    real(real64) :: last_change = 0.0_real64         ! relative, of the load in the last round
    type(resolved_contacts) :: resolved
    type(cluster), allocatable :: clusters(:)
  end type joint_task

  ! Search of the compression at a load, by secants in a bracket.
  type :: load_search
    real(real64) :: least = 0.0_real64                 ! first touch of all contacts
    real(real64) :: low = 0.0_real64, high = 0.0_real64
    real(real64) :: earlier(2) = 0.0_real64            ! compression and load before the last
    real(real64) :: power = 2.0_real64 / 3.0_real64    ! of the load, as Hertz' law has it at first
  end type load_search

contains

  !> Solves at the compression in `solution%coupled`, or at a load.
  subroutine solve_joint(pairs, law, which, tolerance, cluster_tolerance, area_tolerance, &
                         solution, &
                         target)
    type(contact_pairs), intent(in), target :: pairs   !! pairs that may touch, ascending gap
    class(contact_law), intent(in), target :: law      !! contact law of each pair
    integer, intent(in) :: which                       !! contacts resolved: `resolve_none` ...
    real(real64), intent(in) :: tolerance              !! relative error of load and area
    real(real64), intent(in) :: cluster_tolerance      !! relative error of the load on elements
    real(real64), intent(in) :: area_tolerance         !! least relative error of the area
    type(joint_solution), intent(inout) :: solution    !! compression; then all components
    real(real64), intent(in), optional :: target       !! normal load [force]
    type(joint_task) :: task
    real(real64) :: expected
    logical :: is_whole

    if (associated(pairs%pressures)) pairs%pressures%closing = -1.0_real64
    task%pairs => pairs
    task%law => law
    task%which = which
    task%tolerance = tolerance
    task%elements_tolerance = merge(cluster_tolerance, elements_share * tolerance, &
                                    which == resolve_all)
    task%area_tolerance = area_tolerance
    if (present(target)) task%target = target
    associate (n => size(pairs%list))
      allocate (task%is_near(n), task%is_host(n), solution%is_resolved(n), source=.false.)
      allocate (task%radius(n), task%error(n), task%area_error(n), task%sphere_error(n), &
                source=0.0_real64)
    end associate
    expected = solution%coupled%closing
    if (which /= resolve_none) call find_near_tops(pairs, law, along, expected, task%is_near, &
                                                   task%is_host, task%radius, target)
    if (any(task%is_near)) call start_with_near_tops(task, solution)
    is_whole = is_one_cluster(pairs, task%is_near, task%radius, task%clusters)
    if (is_whole) then
      call solve_one_cluster(task, solution, expected, is_whole)
      if (.not. (allocated(solution%failure) .or. is_whole)) call add_near_tops(task, solution, &
                                                                                expected)
    end if
    if (.not. (allocated(solution%failure) .or. is_whole)) call solve_with_circles(task, solution)
    if (allocated(solution%failure)) return
    if (allocated(task%clusters)) then
      solution%clusters = size(task%clusters)
      solution%elements = sum(task%clusters%answer%elements)
      if (associated(pairs%pressures)) then
        call join_elements(task%clusters%answer%pressures, pairs%pressures)
        pairs%pressures%closing = solution%coupled%closing
      end if
    end if
    ! Open contacts are below 0, as 0 is a contact at first touch.
    where (solution%coupled%penetration < 0.5_real64 * far_below) &
      solution%coupled%penetration = -tiny(1.0_real64)
    call set_areas(task, solution)
    call estimate_errors(task, solution)
  end subroutine solve_joint

  ! Begins anew with the contacts whose first touches are near, which are no Hertzian contacts: of
  ! those near to each other one represents the others.
  subroutine start_with_near_tops(task, solution)
    type(joint_task), intent(inout) :: task
    type(joint_solution), intent(inout) :: solution

    solution%is_resolved = task%is_near
    if (allocated(solution%coupled%penetration)) &
      deallocate (solution%coupled%penetration, solution%coupled%shift)
    solution%coupled%is_near = .false.
    associate (list => task%pairs%list)
      task%resolved = resolved_contacts(task%is_near, list%x, list%y, list%gap)
    end associate
  end subroutine start_with_near_tops

  ! Adds the contacts whose first touches are near at a compression, and begins anew with them.
  subroutine add_near_tops(task, solution, closing, has_grown)
    type(joint_task), intent(inout) :: task
    type(joint_solution), intent(inout) :: solution
    real(real64), intent(in) :: closing
    logical, intent(out), optional :: has_grown
    logical, dimension(size(task%is_near)) :: near, host
    real(real64) :: compression, radius(size(near))

    compression = closing
    call find_near_tops(task%pairs, task%law, along, compression, near, host, radius)
    if (present(has_grown)) then
      has_grown = any(near .and. .not. task%is_near)
      if (.not. has_grown) return
    end if
    task%is_host = host .or. (task%is_host .and. .not. near)
    task%is_near = task%is_near .or. near
    task%radius = max(task%radius, radius)
    if (allocated(task%clusters)) deallocate (task%clusters)
    solution%rounds = 0
    call start_with_near_tops(task, solution)
  end subroutine add_near_tops

  ! Solves Hertzian contacts, and clusters where some are resolved.
  subroutine solve_with_circles(task, solution)
    type(joint_task), intent(inout) :: task
    type(joint_solution), intent(inout) :: solution
    logical :: more

    more = .true.
    do while (more)
      if (any(task%is_near)) then
        call solve_hosts(task%pairs, task%law, task%is_near .and. .not. task%is_host, &
                         solution%coupled, task%target)
      else
        call solve_coupled(task%pairs, task%law, solution%coupled, task%target)
      end if
      if (has_failed(solution)) return
      more = allocated(task%target) .and. task%which /= resolve_none
      ! The radii at the load are known with its compression.
      if (more) call add_near_tops(task, solution, solution%coupled%closing, more)
    end do
    if (sum(solution%coupled%set%load) > 0.0_real64) call estimate_circle_errors(task, solution)
    if (task%which == resolve_all) &
      solution%is_resolved = task%pairs%list%gap < solution%coupled%closing
    if (any(solution%is_resolved)) call alternate_blocks(task, solution)
  end subroutine solve_with_circles

  ! Estimates the errors of Hertzian contacts and chooses those that are resolved.
  subroutine estimate_circle_errors(task, solution)
    type(joint_task), intent(inout) :: task
    type(joint_solution), intent(inout) :: solution
    integer :: hosts(size(task%error))
    real(real64) :: allowed

    associate (coupled => solution%coupled, set => solution%coupled%set)
      call find_errors(task%pairs, coupled, hosts, task%error, task%sphere_error, &
                       task%compression_share, solution%nested)
      where (task%is_near)
        task%error = 0.0_real64
        task%sphere_error = 0.0_real64
      end where
      task%area_error(set%contact) = pi * set%radius**2 * min(1.0_real64, area_per_load * &
                                                              task%error(set%contact) / set%load)
      allowed = (1 - elements_share) * task%tolerance * sum(set%load)
      ! Contacts of loads that underflow are too shallow for elements.
      if (task%which == resolve_called_for .and. allowed > tiny(allowed)) call choose_resolved( &
        task%pairs, coupled, max(2 * task%error, task%error + task%sphere_error, &
          task%area_error * sum(set%load) * task%tolerance / (max(task%tolerance, &
            task%area_tolerance) * pi * sum(set%radius**2))) / allowed, hosts, solution%is_resolved)
    end associate
  end subroutine estimate_circle_errors

  ! Solves clusters and Hertzian contacts in turns until the total load settles.
  subroutine alternate_blocks(task, solution)
    type(joint_task), intent(inout) :: task
    type(joint_solution), intent(inout) :: solution
    type(cluster), allocatable :: former(:)
    real(real64) :: before, now, tolerance
    logical :: more

    tolerance = merge(task%elements_tolerance, task%tolerance, task%which == resolve_all)
    more = .true.
    associate (pairs => task%pairs, coupled => solution%coupled, is_resolved => &
               solution%is_resolved)
      do
        if (more) then
          if (allocated(task%clusters)) call move_alloc(task%clusters, former)
          call form_clusters(pairs, coupled, is_resolved, task%radius, task%clusters)
          if (allocated(former)) call keep_lattices(former, task%clusters)
          task%resolved = resolved_contacts(is_resolved, pairs%list%x, pairs%list%y, pairs%list%gap)
          if (size(task%clusters) == 1 .and. all(is_resolved(coupled%set%contact))) then
            now = coupled%closing
            call solve_one_cluster(task, solution, now)
            return
          end if
        end if
        solution%rounds = solution%rounds + 1
        call solve_clusters(pairs, coupled, task%elements_tolerance, task%area_tolerance, &
                            task%clusters, solution%failure)
        if (allocated(solution%failure)) return
        call add_close_contacts(pairs, task%clusters, is_resolved, more)
        if (more) cycle
        task%clusters%is_solved = .false.
        call represent_clusters(pairs, task%law, task%clusters, coupled, task%resolved, .false.)
        if (has_failed(solution)) return
        ! The change of the load by the coupling is not in the field that the clusters were solved
        ! in. At a given load it is that of their loads at the compression they were solved at.
        before = sum(coupled%set%load)
        call solve_coupled(pairs, task%law, coupled, task%target, task%resolved)
        if (has_failed(solution)) return
        now = sum(coupled%set%load)
        task%last_change = abs(now - before) / max(now, tiny(now))
        if (task%last_change <= settled * tolerance) exit
        if (solution%rounds == most_rounds) then
          solution%failure = 'Hertzian contacts and boundary elements did not converge together'
          return
        end if
      end do
      call distribute_loads(pairs, task%law, task%clusters, coupled, task%resolved)
    end associate
    if (has_failed(solution)) return
  end subroutine alternate_blocks

  ! Estimates the errors of load, or compression at a load, and area.
  subroutine estimate_errors(task, solution)
    type(joint_task), intent(in) :: task
    type(joint_solution), intent(inout) :: solution
    real(real64) :: total, area
    integer :: k

    associate (coupled => solution%coupled, is_resolved => solution%is_resolved)
      area = sum(solution%area)
      if (area > 0.0_real64) solution%area_error = sum(task%area_error, mask=.not. is_resolved) / &
        area
      if (area > 0.0_real64 .and. allocated(task%clusters)) &
        solution%area_error = solution%area_error + deviations * norm2([( &
          task%clusters(k)%answer%area_error * sum(solution%area(task%clusters(k)%members)), &
          k=1, size(task%clusters))]) / area
      total = sum(coupled%set%load)
      if (.not. total > 0.0_real64) return
      solution%error = sum(task%error + task%sphere_error, mask=.not. is_resolved) / total
      if (allocated(task%clusters)) then
        ! Neighbours turn the line of centres of an inclined contact, and its load along it.
        associate (set => coupled%set, pair => task%pairs%list(coupled%set%contact))
          if (allocated(task%target)) solution%error = solution%error + &
            sum(set%load * (pair%d / pair%zc)**2 * max(0.0_real64, coupled%closing - pair%gap - &
                coupled%penetration(set%contact)) / pair%zc, mask=is_resolved(set%contact)) / total
        end associate
        ! Errors by elements add up, as all clusters have too little load. They are independent of
        ! the residuals and of the last change, which alternates and contracts.
        solution%error = solution%error + norm2([(sum(task%clusters%answer%error) + norm2([( &
          task%clusters(k)%answer%ending%residual * sum(task%clusters(k)%answer%contacts%load), &
          k=1, size(task%clusters))])) / (task%pairs%modulus * total), task%last_change])
      end if
      if (allocated(task%target)) solution%error = task%compression_share * solution%error
    end associate
  end subroutine estimate_errors

  ! Solves Hertzian contacts but those in `is_out`, which are open.
  subroutine solve_hosts(pairs, law, is_out, coupled, target)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in), target :: law
    logical, intent(in) :: is_out(:)
    type(coupled_solution), intent(inout) :: coupled
    real(real64), intent(in), optional :: target
    type(contact_pairs) :: host_pairs
    type(group_law) :: law_of_hosts
    type(coupled_solution) :: solved
    type(resolved_contacts) :: no_circles
    integer :: i

    law_of_hosts%whole => law
    law_of_hosts%contact = pack([(i, i=1, size(is_out))], .not. is_out)
    law_of_hosts%softening = spread(1.0_real64, 1, size(law_of_hosts%contact))
    host_pairs%modulus = pairs%modulus
    host_pairs%vertical = pairs%vertical
    host_pairs%complete_to = pairs%complete_to
    host_pairs%interrupt = pairs%interrupt
    host_pairs%list = pairs%list(law_of_hosts%contact)
    solved%closing = coupled%closing
    call solve_coupled(host_pairs, law_of_hosts, solved, target)
    allocate (coupled%penetration(size(is_out)), source=far_below)
    allocate (coupled%shift(2, size(is_out)), source=0.0_real64)
    coupled%penetration(law_of_hosts%contact) = solved%penetration
    coupled%shift(:, law_of_hosts%contact) = solved%shift
    coupled%closing = solved%closing
    if (allocated(solved%failure)) coupled%failure = solved%failure
    if (allocated(solved%failure)) return
    no_circles = resolved_contacts(spread(.false., 1, size(is_out)), pairs%list%x, pairs%list%y, &
                                   pairs%list%gap)
    call adopt_penetrations(pairs, law, coupled, no_circles)
    coupled%ending = solved%ending
  end subroutine solve_hosts

  ! Solves one cluster of all contacts at a compression, or at a load. The cluster grows by contacts
  ! that are loaded at its load. `is_whole` is false where these are no part of it: the compression
  ! is then an upper bound. Without it all contacts that penetrate are members.
  subroutine solve_one_cluster(task, solution, closing, is_whole)
    type(joint_task), intent(inout) :: task
    type(joint_solution), intent(inout) :: solution
    real(real64), intent(inout) :: closing        ! expected; then that of the load
    logical, intent(out), optional :: is_whole
    logical, dimension(size(task%is_near)) :: is_member, near, host
    type(cluster), allocatable :: solved(:)
    type(cluster_lattice) :: fresh                ! no elements yet
    type(load_search) :: search
    real(real64) :: load, slope, compression, share, radius(size(near))
    integer :: k

    task%compression_share = 1.0_real64
    ! The elements are those of the compression of the load, which coarse ones find.
    share = task%elements_tolerance
    if (allocated(task%target)) share = max(share, settled)
    is_member = .not. present(is_whole)
    is_member(task%clusters(1)%members) = .true.
    if (present(is_whole)) is_whole = .true.
    search%least = minval(task%pairs%list%gap)
    call begin_search(search)
    associate (coupled => solution%coupled, pairs => task%pairs)
      coupled%penetration = spread(far_below, 1, size(pairs%list))
      coupled%shift = spread(spread(0.0_real64, 1, 2), 2, size(pairs%list))
      do
        if (solution%rounds == most_rounds) then
          solution%failure = 'the load of the boundary elements was not met'
          return
        end if
        solution%rounds = solution%rounds + 1
        coupled%closing = closing
        task%resolved%is_resolved = is_member .and. pairs%list%gap < closing
        call press_one_cluster(task, solution, share)
        if (allocated(solution%failure)) return
        if (.not. allocated(task%target)) exit
        call find_carried_load(pairs, task%law, coupled%penetration, 0.0_real64, load, slope)
        load = load * pairs%modulus
        if (abs(load - task%target) > task%target * &
            merge(share, settled * share, share > task%elements_tolerance)) then
          call take_secant(search, load, task%target, closing, task%compression_share)
          cycle
        end if
        ! Near at this compression, or loaded by it: the area of a blunt contact that the probes of
        ! `any_loaded` miss may count.
        compression = closing
        call find_near_tops(pairs, task%law, along, compression, near, host, radius)
        if (any(near .and. .not. is_member) .or. any_loaded(pairs, pack([(k, k=1, &
            size(is_member))], .not. is_member), closing, outside_field(), &
            task%clusters(1)%lattice)) then
          is_whole = is_one_cluster(pairs, near, radius, solved)
          if (.not. is_whole) return
          is_member = is_member .or. near
        else if (share <= task%elements_tolerance) then
          exit
        else
          share = task%elements_tolerance
          task%clusters(1)%lattice = fresh
        end if
        ! The load at this compression changes: the bracket does not hold.
        call begin_search(search)
      end do
      solution%is_resolved = task%resolved%is_resolved
      if (allocated(task%target)) call raise_to_load(pairs, task%law, task%target / pairs%modulus, &
                                             coupled%penetration)
      call distribute_loads(pairs, task%law, task%clusters, coupled, task%resolved)
    end associate
    if (has_failed(solution)) return
  end subroutine solve_one_cluster

  ! Solves the one cluster at the compression, with nothing outside.
  subroutine press_one_cluster(task, solution, tolerance)
    type(joint_task), intent(inout) :: task
    type(joint_solution), intent(inout) :: solution
    real(real64), intent(in) :: tolerance          ! relative error of the load
    integer :: k

    associate (one => task%clusters(1), coupled => solution%coupled)
      if (allocated(one%host)) deallocate (one%host)
      ! Members change with the compression.
      if (allocated(one%change)) deallocate (one%change, one%taken)
      call coupled%set%allocate_arrays(0)
      one%members = pack([(k, k=1, size(task%is_near))], task%resolved%is_resolved)
      one%is_solved = .false.
      call solve_clusters(task%pairs, coupled, tolerance, task%area_tolerance, task%clusters, &
                          solution%failure)
      if (allocated(solution%failure)) return
      call represent_clusters(task%pairs, task%law, task%clusters, coupled, task%resolved, .true.)
      coupled%ending = one%answer%ending
      if (has_failed(solution)) return
    end associate
  end subroutine press_one_cluster

  ! Forgets bracket and secant.
  subroutine begin_search(search)
    type(load_search), intent(inout) :: search

    search%low = search%least
    search%high = huge(search%high)
    search%earlier = [search%least, 0.0_real64]
  end subroutine begin_search

  ! Next compression: by a power of the load, then by secants; bisection outside the bracket, or
  ! doubling while it is open.
  subroutine take_secant(search, load, target, closing, compression_share)
    type(load_search), intent(inout) :: search
    real(real64), intent(in) :: load, target    ! load at `closing`, and the prescribed one
    real(real64), intent(inout) :: closing
    real(real64), intent(inout) :: compression_share ! d log closing/d log load
    real(real64) :: next

    if (load < target) search%low = closing
    if (load > target) search%high = closing
    associate (least => search%least, earlier => search%earlier)
      next = closing + (target - load) * (closing - earlier(1)) / (load - earlier(2))
      if (earlier(2) <= 0.0_real64) then
        next = least + (closing - least) * min(2.0_real64, (target / load)**search%power)
      else
        compression_share = load / (closing - least) * (closing - earlier(1)) / (load - earlier(2))
        if (compression_share > 0.0_real64 .and. compression_share < 1.0_real64) search%power = &
          compression_share
      end if
      if (.not. (next > search%low .and. next < search%high)) &
        next = merge(0.5_real64 * (search%low + search%high), least + 2 * (closing - least), &
                     search%high < huge(next))
      earlier = [closing, load]
    end associate
    closing = next
  end subroutine take_secant

  ! Clusters whose members stay keep their lattices and, as long as the circles stay, their answers.
  subroutine keep_lattices(former, clusters)
    type(cluster), intent(in) :: former(:)
    type(cluster), intent(inout) :: clusters(:)
    integer :: i, k

    do k = 1, size(clusters)
      do i = 1, size(former)
        if (size(former(i)%members) /= size(clusters(k)%members)) cycle
        if (any(former(i)%members /= clusters(k)%members)) cycle
        clusters(k)%lattice = former(i)%lattice
        clusters(k)%answer = former(i)%answer
        clusters(k)%is_solved = former(i)%is_solved
        exit
      end do
    end do
  end subroutine keep_lattices

  ! Whether the contacts that are loaded by geometry are near and form one cluster.
  logical function is_one_cluster(pairs, is_near, radius, clusters) result(is_single)
    type(contact_pairs), intent(in) :: pairs
    logical, intent(in) :: is_near(:)
    real(real64), intent(in) :: radius(:)                   ! radius by pair; 0: open
    type(cluster), allocatable, intent(out) :: clusters(:)  ! allocated where it is one
    type(coupled_solution) :: no_circles

    is_single = any(is_near) .and. all(is_near .or. .not. radius > 0.0_real64)
    if (.not. is_single) return
    call no_circles%set%allocate_arrays(0)
    call form_clusters(pairs, no_circles, is_near, radius, clusters)
    is_single = size(clusters) == 1
    if (.not. is_single) deallocate (clusters)
  end function is_one_cluster

  ! Whether a solve has failed, with the message in `solution`.
  logical function has_failed(solution)
    type(joint_solution), intent(inout) :: solution

    if (allocated(solution%coupled%failure)) then
      solution%failure = solution%coupled%failure
    else if (.not. solution%coupled%ending%converged) then
      solution%failure = 'did not converge: residual ' // &
                         real_text(solution%coupled%ending%residual, 'es9.1e3') // &
                         ', iteration ' // decimal_text(solution%coupled%ending%iterations)
    end if
    has_failed = allocated(solution%failure)
  end function has_failed

  ! Sets areas in plan and pressures. The area of a Hertzian contact is exact for a field that bends
  ! as a paraboloid; on elements the ratio to the isolated contact multiplies that of the law.
  subroutine set_areas(task, solution)
    type(joint_task), intent(in) :: task
    type(joint_solution), intent(inout) :: solution
    type(contact_response) :: response
    real(real64) :: growth_ratio, most
    integer :: i, k, m

    allocate (solution%area(size(task%is_near)), source=0.0_real64)
    allocate (solution%maximum_pressure(size(task%is_near)), source=-1.0_real64)
    associate (coupled => solution%coupled, set => solution%coupled%set, pairs => task%pairs)
      do k = 1, size(set%contact)
        i = set%contact(k)
        if (solution%is_resolved(i)) cycle
        growth_ratio = max(set%growth(k) / coupled%penetration(i), 0.0_real64)
        solution%area(i) = pi * set%radius(k)**2 * (2 + growth_ratio) / (2 + 3 * growth_ratio)
      end do
      if (.not. allocated(task%clusters)) return
      do k = 1, size(task%clusters)
        associate (one => task%clusters(k), answer => task%clusters(k)%answer)
          do m = 1, size(one%members)
            i = one%members(m)
            if (.not. coupled%penetration(i) > 0.0_real64) cycle
            call task%law%respond(pairs%list(i), i, coupled%closing - one%displacement - &
                                  pairs%list(i)%gap, response)
            most = merge(1.0_real64, huge(most), answer%is_isolated_solved(m))
            solution%area(i) = pi * response%contact_radius**2 * &
                               min(most, answer%contacts(m)%area / answer%isolated(m)%area)
            solution%maximum_pressure(i) = response%maximum_pressure * &
              min(most, answer%contacts(m)%pressure / answer%isolated(m)%pressure)
          end do
        end associate
      end do
    end associate
  end subroutine set_areas

  ! Adds to the resolved until the errors of the others are no more than 1.
  subroutine choose_resolved(pairs, coupled, error, hosts, is_resolved)
    type(contact_pairs), intent(in) :: pairs     ! pairs of the position
    type(coupled_solution), intent(in) :: coupled   ! solved
    real(real64), intent(in) :: error(:)            ! by pair, over what all may be off by
    integer, intent(in) :: hosts(:)                 ! circle that hides an open pair, else 0
    logical, intent(inout) :: is_resolved(:)        ! by pair: resolved
    type(source_tree) :: tree
    integer, allocatable :: number(:), member(:), first(:)
    integer :: order(size(error)), i, k, l, next
    real(real64) :: excess, resolved_error

    associate (set => coupled%set)
      call gather_groups(set%one, set%other, &
                         [(are_close(set, set%one(k), set%other(k), along), k=1, size(set%one))], &
                         spread(.true., 1, size(set%contact)), size(set%contact), member, first)
      call find_open_neighbours(pairs, coupled, along, tree, number)
      call sort_keys(-error, order)
      next = 1
      do
        do k = 1, size(first) - 1
          associate (group => set%contact(member(first(k):first(k + 1) - 1)))
            is_resolved(group) = any(is_resolved(group))
          end associate
        end do
        do i = 1, size(number)
          do l = tree%first(i), tree%first(i + 1) - 1
            if (is_resolved(set%contact(tree%near(l)))) is_resolved(number(i)) = .true.
          end do
        end do
        excess = sum(error, mask=.not. is_resolved) - 1.0_real64
        if (.not. excess > 0.0_real64) exit
        ! The largest errors, half of what is too much at a time: their neighbours, which follow,
        ! may be most of the rest.
        resolved_error = 0.0_real64
        do while (resolved_error < excess - resolved_error .and. next <= size(order))
          i = order(next)
          next = next + 1
          if (is_resolved(i)) cycle
          is_resolved(i) = .true.
          if (hosts(i) > 0) is_resolved(hosts(i)) = .true.
          resolved_error = resolved_error + error(i)
        end do
      end do
    end associate
  end subroutine choose_resolved

  ! Also resolves Hertzian contacts that are close to the loaded members of a cluster: a contact in
  ! a ring around another has its centre there.
  subroutine add_close_contacts(pairs, clusters, is_resolved, more)
    type(contact_pairs), intent(in) :: pairs      ! pairs of the position
    type(cluster), intent(in) :: clusters(:)      ! solved
    logical, intent(inout) :: is_resolved(:)      ! by pair: resolved
    logical, intent(out) :: more                  ! contacts than before
    integer :: k, l

    more = .false.
    do k = 1, size(clusters)
      associate (o => clusters(k)%outside, together => clusters(k)%answer%contacts, &
                 list => pairs%list(clusters(k)%members))
        if (.not. allocated(o%pair)) cycle
        do l = 1, size(o%pair)
          ! In another cluster.
          if (is_resolved(o%pair(l))) cycle
          ! Radii of Hertzian contacts by their loads.
          if (.not. any(together%load > 0.0_real64 .and. &
                        hypot(together%x - o%x(l), together%y - o%y(l)) < &
              along * (o%radius(l) + (0.75_real64 * together%load / pairs%modulus * &
                                      list%radius)**(1.0_real64 / 3)))) cycle
          is_resolved(o%pair(l)) = .true.
          more = .true.
        end do
      end associate
    end do
  end subroutine add_close_contacts

end module asperity_joint_contacts
