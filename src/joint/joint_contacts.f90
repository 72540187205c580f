!> Contacts that share a half-space: circles, and on cells those that are none any more.
!>
!> All contacts are coupled as circles. Those whose indicated error is too large, with all that is
!> close to them, are solved on cells, a cluster on a lattice, under the field of all others cell by
!> cell. A cluster answers with its loads, the centres and the spread of its pressures; the circles
!> are coupled again with contacts that carry just these loads there, and so on until the total
!> settles. The coupling knows how every load moves every other, so that only the cells' corrections
!> lag.
module asperity_joint_contacts
  use asperity_circle_error, only: find_errors, open_about
  use asperity_cells_outside, only: outside_field
  use asperity_cells_solver, only: any_loaded, cluster_lattice, deviations
  use asperity_circle_field, only: are_close
  use asperity_constants, only: pi
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_contacts, only: adopt, coupled_solution, resolved_contacts, solve_coupled
  use asperity_coupled_groups, only: group_law
  use asperity_coupled_state, only: bear, far_below, raise
  use asperity_element_pressures, only: join_elements
  use asperity_index_groups, only: gather_groups
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: real64
  use asperity_near_tops, only: find_near_tops
  use asperity_problems, only: decimal_text, real_text
  use asperity_resolved_answers, only: answer_with, share_out
  use asperity_resolved_clusters, only: area_per_load, cluster, form_clusters, solve_clusters
  use asperity_source_tree, only: source_tree
  implicit none
  private

  public :: joint_solution, resolve_all, resolve_called_for, resolve_none, solve_joint

  !> What was found.
  type :: joint_solution
    type(coupled_solution) :: coupled               !! closing, penetrations, circles
    real(real64), allocatable :: area(:)            !! in plan, by pair
    real(real64), allocatable :: maximum_pressure(:) !! by pair; below 0: that of its law
    logical, allocatable :: is_resolved(:)          !! by pair
    integer :: clusters = 0, cells = 0              !! of those resolved
    integer :: rounds = 0                           !! of circles and cells
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
  ! Largest number of rounds (chosen: 3 to 9 are taken in the dense scenes; test: loads of
  ! clusters in test/unit/joint_suite.f90).
  integer, parameter :: most_rounds = 30
  ! Sums of radii: Hertzian contacts nearer to each other go to boundary elements together, with the
  ! open contacts within as many radii (chosen: just beside a large contact the error indicated for
  ! a small one is a third of the true one; test: errors in test/regression/test_dense.py).
  real(real64), parameter :: along = 1.1_real64

contains

  !> Solves at the closing in `solution%coupled`, or at a load.
  subroutine solve_joint(pairs, law, which, tolerance, cells_tolerance, area_tolerance, solution, &
                         target)
    type(contact_pairs), intent(in) :: pairs           !! those that may touch, ascending gap
    class(contact_law), intent(in) :: law              !! of each contact
    integer, intent(in) :: which                       !! `resolve_none` ...
    real(real64), intent(in) :: tolerance              !! share of load and area, where called for
    real(real64), intent(in) :: cells_tolerance        !! share of the load that halving may change
    real(real64), intent(in) :: area_tolerance         !! share of the area that may be off at least
    type(joint_solution), intent(inout) :: solution    !! closing; then all
    real(real64), intent(in), optional :: target       !! normal load
    type(resolved_contacts) :: resolved
    type(cluster), allocatable :: clusters(:), former(:)
    real(real64), dimension(size(pairs%list)) :: error, shape, area_error, circle
    logical, dimension(size(pairs%list)) :: is_near, is_host
    integer :: hosts(size(pairs%list)), k
    real(real64) :: before, now, of_closing, total, expected, allowed
    logical :: more, is_whole

    if (associated(pairs%pressures)) pairs%pressures%closing = -1.0_real64
    is_near = .false.
    circle = 0.0_real64
    expected = solution%coupled%closing
    if (which /= resolve_none) &
      call find_near_tops(pairs, law, along, expected, is_near, is_host, circle, target)
    allocate (solution%is_resolved(size(error)), source=is_near)
    if (any(is_near)) then
      ! First touches that are near are no Hertzian contacts: one represents those near to it.
      if (allocated(solution%coupled%penetration)) &
        deallocate (solution%coupled%penetration, solution%coupled%move)
      solution%coupled%is_near = .false.
      resolved = resolved_contacts(is_near, pairs%list%x, pairs%list%y, pairs%list%gap)
    end if
    error = 0.0_real64
    shape = 0.0_real64
    area_error = 0.0_real64
    is_whole = is_one_cluster(pairs, is_near, circle, clusters)
    if (is_whole) then
      call solve_whole(expected, is_whole)
      if (allocated(solution%failure)) return
      if (.not. is_whole) call add_near(expected)
    end if
    if (.not. is_whole) call solve_with_circles()
    if (allocated(solution%failure)) return
    if (allocated(clusters)) then
      solution%clusters = size(clusters)
      solution%cells = sum(clusters%answer%cells)
      if (associated(pairs%pressures)) then
        call join_elements(clusters%answer%loaded, pairs%pressures)
        pairs%pressures%closing = solution%coupled%closing
      end if
    end if
    call finish()

  contains

    ! Adds the contacts whose first touches are near at a closing, and starts anew with them.
    subroutine add_near(closing, grown)
      real(real64), intent(in) :: closing
      logical, intent(out), optional :: grown
      logical, dimension(size(pairs%list)) :: near, host
      real(real64) :: at, radius(size(pairs%list))

      at = closing
      call find_near_tops(pairs, law, along, at, near, host, radius)
      if (present(grown)) then
        grown = any(near .and. .not. is_near)
        if (.not. grown) return
      end if
      is_host = host .or. (is_host .and. .not. near)
      is_near = is_near .or. near
      circle = max(circle, radius)
      solution%is_resolved = is_near
      resolved = resolved_contacts(is_near, pairs%list%x, pairs%list%y, pairs%list%gap)
      if (allocated(clusters)) deallocate (clusters)
      if (allocated(solution%coupled%penetration)) &
        deallocate (solution%coupled%penetration, solution%coupled%move)
      solution%coupled%is_near = .false.
      solution%rounds = 0
    end subroutine add_near

    ! Solves one cluster of all contacts. `is_whole` is false where others are loaded: the closing
    ! is then an upper bound of that at the load.
    subroutine solve_whole(closing, is_whole)
      real(real64), intent(inout) :: closing
      logical, intent(out), optional :: is_whole

      call solve_one_cluster(pairs, law, merge(cells_tolerance, elements_share * tolerance, &
                             which == resolve_all), area_tolerance, closing, clusters, resolved, &
                             solution, of_closing, target, is_whole)
      if (allocated(solution%failure)) return
      if (present(is_whole)) then
        if (.not. is_whole) return
      end if
      total = sum(solution%coupled%set%load)
      now = total
      before = total
    end subroutine solve_whole

    ! Solves Hertzian contacts, and clusters where some are resolved.
    subroutine solve_with_circles()
      more = .true.
      do while (more)
        if (any(is_near)) then
          call solve_hosts(pairs, law, is_near .and. .not. is_host, solution%coupled, target)
        else
          call solve_coupled(pairs, law, solution%coupled, target)
        end if
        if (failed(solution)) return
        more = present(target) .and. which /= resolve_none
        ! The radii at the load are known with its closing.
        if (more) call add_near(solution%coupled%closing, more)
      end do
      associate (coupled => solution%coupled, is_one => solution%is_resolved)
        total = sum(coupled%set%load)
        ! Else nothing touches.
        if (total > 0.0_real64) &
          call find_errors(pairs, coupled, hosts, error, shape, of_closing, solution%nested)
        where (is_near)
          error = 0.0_real64
          shape = 0.0_real64
        end where
        if (which == resolve_all) is_one = pairs%list%gap < coupled%closing
        associate (set => coupled%set)
          area_error(set%number) = pi * set%circle**2 * min(1.0_real64, &
                                   area_per_load * error(set%number) / set%load)
          ! Shares of next to nothing are no numbers, and its contacts too shallow for cells.
          allowed = (1 - elements_share) * tolerance * total
          if (which == resolve_called_for .and. allowed > tiny(allowed)) &
            call choose_resolved(pairs, coupled, &
              max(2 * error, error + shape, area_error * total * tolerance / &
                  (max(tolerance, area_tolerance) * pi * sum(set%circle**2))) / allowed, &
              hosts, is_one)
        end associate
        now = total
        before = total
        if (any(is_one)) then
          more = .true.
          do
            if (more) then
              if (allocated(clusters)) call move_alloc(clusters, former)
              call form_clusters(pairs, coupled, is_one, circle, clusters)
              if (allocated(former)) call keep_lattices(former, clusters)
              resolved = resolved_contacts(is_one, pairs%list%x, pairs%list%y, pairs%list%gap)
              if (size(clusters) == 1 .and. all(is_one(coupled%set%number))) then
                call solve_whole(coupled%closing)
                return
              end if
            end if
            solution%rounds = solution%rounds + 1
            call solve_clusters(pairs, coupled, merge(cells_tolerance, elements_share * tolerance, &
                                which == resolve_all), area_tolerance, clusters, solution%failure)
            if (allocated(solution%failure)) return
            call reach_others(pairs, clusters, is_one, more)
            if (more) cycle
            clusters%is_solved = .false.
            call answer_with(pairs, law, clusters, coupled, resolved, .false.)
            if (failed(solution)) return
            ! The cells know nothing of what the coupling changes from here on. At a given load it
            ! changes the load that they bear at the closing that they were solved at.
            before = sum(coupled%set%load)
            call solve_coupled(pairs, law, coupled, target, resolved)
            if (failed(solution)) return
            now = sum(coupled%set%load)
            if (abs(now - before) <= settled * merge(cells_tolerance, tolerance, &
                                                     which == resolve_all) * now) exit
            if (solution%rounds == most_rounds) then
              solution%failure = 'Hertzian contacts and boundary elements did not converge together'
              return
            end if
          end do
          call share_out(pairs, law, clusters, coupled, resolved)
          if (failed(solution)) return
        end if
      end associate
    end subroutine solve_with_circles

    ! Sets areas and estimates of errors.
    subroutine finish()
      associate (coupled => solution%coupled, is_one => solution%is_resolved)
        ! Open: below 0, as 0 is a contact at first touch.
        where (coupled%penetration < 0.5_real64 * far_below) coupled%penetration = -tiny(1.0_real64)
        call tell_areas(pairs, law, clusters, solution)
        solution%area_error = area_left(solution, clusters, area_error)
        if (.not. total > 0.0_real64) return
        total = sum(coupled%set%load)
        solution%error = sum(error + shape, mask=.not. is_one) / total
        if (allocated(clusters)) then
          ! Neighbours turn the line of centres of an inclined contact, and its load along it.
          associate (set => coupled%set, pair => pairs%list(coupled%set%number))
            if (present(target)) solution%error = solution%error + &
              sum(set%load * (pair%d / pair%zc)**2 * max(0.0_real64, coupled%closing - pair%gap - &
                  coupled%penetration(set%number)) / pair%zc, mask=is_one(set%number)) / total
          end associate
          ! These know nothing of each other: their squares add up.
          solution%error = solution%error + norm2([ &
            ! Clusters all have too little load: their errors add up.
            (sum(clusters%answer%error) + norm2([(clusters(k)%answer%ending%residual * &
              sum(clusters(k)%answer%together%load), k=1, size(clusters))])) / &
              (pairs%modulus * total), &
            ! Changes alternate and contract: the rest is less than the last one.
            abs(now - before) / now])
        end if
        if (present(target)) solution%error = of_closing * solution%error
      end associate
    end subroutine finish

  end subroutine solve_joint

  ! Solves Hertzian contacts but those in `is_out`, which are open.
  subroutine solve_hosts(pairs, law, is_out, coupled, target)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in), target :: law
    logical, intent(in) :: is_out(:)
    type(coupled_solution), intent(inout) :: coupled
    real(real64), intent(in), optional :: target
    type(contact_pairs) :: part
    type(group_law) :: part_law
    type(coupled_solution) :: found
    type(resolved_contacts) :: none
    integer :: i

    part_law%whole => law
    part_law%number = pack([(i, i=1, size(is_out))], .not. is_out)
    part_law%deeper = spread(1.0_real64, 1, size(part_law%number))
    part%modulus = pairs%modulus
    part%vertical = pairs%vertical
    part%complete_to = pairs%complete_to
    part%interrupt = pairs%interrupt
    part%list = pairs%list(part_law%number)
    found%closing = coupled%closing
    call solve_coupled(part, part_law, found, target)
    allocate (coupled%penetration(size(is_out)), source=far_below)
    allocate (coupled%move(2, size(is_out)), source=0.0_real64)
    coupled%penetration(part_law%number) = found%penetration
    coupled%move(:, part_law%number) = found%move
    coupled%closing = found%closing
    if (allocated(found%failure)) coupled%failure = found%failure
    if (allocated(found%failure)) return
    none = resolved_contacts(spread(.false., 1, size(is_out)), pairs%list%x, pairs%list%y, &
                             pairs%list%gap)
    call adopt(pairs, law, coupled, none)
    coupled%ending = found%ending
  end subroutine solve_hosts

  ! Solves one cluster of all contacts at a closing, or at a load by the secant method.
  ! The members of a cluster grow by contacts that are loaded at its load. `is_whole` is false where
  ! these are no part of it; without it all contacts that penetrate are members.
  subroutine solve_one_cluster(pairs, law, tolerance, area_tolerance, closing, clusters, &
                               resolved, solution, of_closing, target, is_whole)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    real(real64), intent(in) :: tolerance, area_tolerance
    real(real64), intent(inout) :: closing  ! expected; then that of the load
    type(cluster), intent(inout), allocatable :: clusters(:)
    type(resolved_contacts), intent(inout) :: resolved
    type(joint_solution), intent(inout) :: solution
    real(real64), intent(out) :: of_closing
    real(real64), intent(in), optional :: target
    logical, intent(out), optional :: is_whole
    logical, dimension(size(pairs%list)) :: is_member, near, host
    type(cluster), allocatable :: found(:)
    real(real64) :: load, slope, next, low, high, low0, earlier(2), at, radius(size(pairs%list))
    real(real64) :: power, share, met
    type(cluster_lattice) :: fresh  ! no elements yet
    integer :: k

    of_closing = 1.0_real64
    power = 2.0_real64 / 3.0_real64  ! Hertz' law
    ! The elements are those of the closing of the load, which coarse ones find.
    share = tolerance
    if (present(target)) share = max(tolerance, settled)
    is_member = .not. present(is_whole)
    is_member(clusters(1)%members) = .true.
    if (present(is_whole)) is_whole = .true.
    low0 = minval(pairs%list%gap)
    low = low0
    high = huge(high)
    earlier = [low, 0.0_real64]
    associate (coupled => solution%coupled)
      coupled%penetration = spread(far_below, 1, size(pairs%list))
      coupled%move = spread(spread(0.0_real64, 1, 2), 2, size(pairs%list))
      call coupled%set%make_room(0)
      do
        if (solution%rounds == most_rounds) then
          solution%failure = 'the load of the boundary elements was not met'
          return
        end if
        solution%rounds = solution%rounds + 1
        coupled%closing = closing
        resolved%is_one = is_member .and. pairs%list%gap < closing
        if (allocated(clusters(1)%host)) deallocate (clusters(1)%host)
        call coupled%set%make_room(0)
        clusters(1)%members = pack([(k, k=1, size(pairs%list))], resolved%is_one)
        clusters%is_solved = .false.
        call solve_clusters(pairs, coupled, share, area_tolerance, clusters, solution%failure)
        if (allocated(solution%failure)) return
        call answer_with(pairs, law, clusters, coupled, resolved, .true.)
        coupled%ending = clusters(1)%answer%ending
        if (failed(solution)) return
        if (.not. present(target)) exit
        call bear(pairs, law, coupled%penetration, 0.0_real64, load, slope)
        load = load * pairs%modulus
        met = merge(share, settled * tolerance, share > tolerance)
        if (abs(load - target) <= met * target) then
          if (any_loaded(pairs, pack([(k, k=1, size(is_member))], .not. is_member), closing, &
                         outside_field(), clusters(1)%lattice)) then
            at = closing
            call find_near_tops(pairs, law, along, at, near, host, radius)
            is_whole = is_one_cluster(pairs, near, radius, found)
            if (.not. is_whole) return
            is_member = is_member .or. near
          else if (share <= tolerance) then
            exit
          else
            share = tolerance
            clusters(1)%lattice = fresh
          end if
          ! The load at this closing changes: the bracket does not hold.
          low = low0
          high = huge(high)
          earlier = [low, 0.0_real64]
          cycle
        end if
        if (load < target) low = closing
        if (load > target) high = closing
        ! Secant; first step by a power of the load; kept inside the bracket.
        next = closing + (target - load) * (closing - earlier(1)) / (load - earlier(2))
        if (earlier(2) <= 0.0_real64) then
          next = low0 + (closing - low0) * min(2.0_real64, (target / load)**power)
        else
          of_closing = load / (closing - low0) * (closing - earlier(1)) / (load - earlier(2))
          if (of_closing > 0.0_real64 .and. of_closing < 1.0_real64) power = of_closing
        end if
        if (.not. (next > low .and. next < high)) next = merge(0.5_real64 * (low + high), &
          low0 + 2 * (closing - low0), high < huge(high))
        earlier = [closing, load]
        closing = next
      end do
      solution%is_resolved = resolved%is_one
      if (present(target)) call raise(pairs, law, target / pairs%modulus, coupled%penetration)
      call share_out(pairs, law, clusters, coupled, resolved)
    end associate
    if (failed(solution)) return
  end subroutine solve_one_cluster

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
  logical function is_one_cluster(pairs, is_near, circle, clusters) result(is_one)
    type(contact_pairs), intent(in) :: pairs
    logical, intent(in) :: is_near(:)
    real(real64), intent(in) :: circle(:)                   ! radius by pair; 0: open
    type(cluster), allocatable, intent(out) :: clusters(:)  ! allocated where it is one
    type(coupled_solution) :: none

    is_one = any(is_near) .and. all(is_near .or. .not. circle > 0.0_real64)
    if (.not. is_one) return
    call none%set%make_room(0)
    call form_clusters(pairs, none, is_near, circle, clusters)
    is_one = size(clusters) == 1
    if (.not. is_one) deallocate (clusters)
  end function is_one_cluster

  logical function failed(solution)
    type(joint_solution), intent(inout) :: solution

    if (allocated(solution%coupled%failure)) then
      solution%failure = solution%coupled%failure
    else if (.not. solution%coupled%ending%converged) then
      solution%failure = 'did not converge: residual ' // &
                         real_text(solution%coupled%ending%residual, 'es9.1e3') // &
                         ', iteration ' // decimal_text(solution%coupled%ending%iterations)
    end if
    failed = allocated(solution%failure)
  end function failed

  ! What the area may be off by, a share of it: what circles are, and the scatter on cells.
  real(real64) function area_left(solution, clusters, error) result(share)
    type(joint_solution), intent(in) :: solution
    type(cluster), allocatable, intent(in) :: clusters(:)
    real(real64), intent(in) :: error(:)  ! of circles
    real(real64) :: total
    integer :: k

    share = 0.0_real64
    total = sum(solution%area)
    if (.not. total > 0.0_real64) return
    share = sum(error, mask=.not. solution%is_resolved) / total
    if (.not. allocated(clusters)) return
    share = share + deviations * norm2([(clusters(k)%answer%area_error * &
            sum(solution%area(clusters(k)%members)), k=1, size(clusters))]) / total
  end function area_left

  ! Areas in plan. Of circles: exact for a field that bends as a paraboloid, and where it is convex;
  ! of cells as they are.
  subroutine tell_areas(pairs, law, clusters, solution)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(cluster), allocatable, intent(in) :: clusters(:)
    type(joint_solution), intent(inout) :: solution
    type(contact_response) :: response
    real(real64) :: bend, most
    integer :: i, k, m

    allocate (solution%area(size(pairs%list)), solution%maximum_pressure(size(pairs%list)))
    solution%area = 0.0_real64
    solution%maximum_pressure = -1.0_real64
    associate (coupled => solution%coupled, set => solution%coupled%set)
      do k = 1, size(set%number)
        i = set%number(k)
        if (solution%is_resolved(i)) cycle
        bend = max(set%growth(k) / coupled%penetration(i), 0.0_real64)
        solution%area(i) = pi * set%circle(k)**2 * (2 + bend) / (2 + 3 * bend)
      end do
      if (.not. allocated(clusters)) return
      do k = 1, size(clusters)
        do m = 1, size(clusters(k)%members)
          i = clusters(k)%members(m)
          if (.not. coupled%penetration(i) > 0.0_real64) cycle
          ! Together over alone, as the load.
          call law%respond(pairs%list(i), i, coupled%closing - clusters(k)%lowered - &
                           pairs%list(i)%gap, response)
          associate (answer => clusters(k)%answer)
            most = merge(1.0_real64, huge(most), answer%known_alone(m))
            solution%area(i) = pi * response%contact_radius**2 * &
                               min(most, answer%together(m)%area / answer%alone(m)%area)
            solution%maximum_pressure(i) = response%maximum_pressure * &
              min(most, answer%together(m)%pressure / answer%alone(m)%pressure)
          end associate
        end do
      end do
    end associate
  end subroutine tell_areas

  !> Adds to the resolved until what the others are off by is no more than 1.
  subroutine choose_resolved(pairs, coupled, error, hosts, is_one)
    type(contact_pairs), intent(in) :: pairs        !! the position
    type(coupled_solution), intent(in) :: coupled   !! solved
    real(real64), intent(in) :: error(:)            !! by pair, over what all may be off by
    integer, intent(in) :: hosts(:)                 !! circle that hides an open pair, else 0
    logical, intent(inout) :: is_one(:)             !! by pair: resolved
    type(source_tree) :: tree
    integer, allocatable :: number(:), member(:), first(:)
    integer :: order(size(error)), i, k, l, next
    real(real64) :: over, gone

    associate (set => coupled%set)
      call gather_groups(set%one, set%other, &
                         [(are_close(set, set%one(k), set%other(k), along), k=1, size(set%one))], &
                         spread(.true., 1, size(set%number)), size(set%number), member, first)
      call open_about(pairs, coupled, along, tree, number)
      call sort_keys(-error, order)
      next = 1
      do
        do k = 1, size(first) - 1
          associate (group => set%number(member(first(k):first(k + 1) - 1)))
            is_one(group) = any(is_one(group))
          end associate
        end do
        do i = 1, size(number)
          do l = tree%first(i), tree%first(i + 1) - 1
            if (is_one(set%number(tree%near(l)))) is_one(number(i)) = .true.
          end do
        end do
        over = sum(error, mask=.not. is_one) - 1.0_real64
        if (.not. over > 0.0_real64) exit
        ! The largest errors, half of what is too much at a time: their neighbours, which follow,
        ! may be most of the rest.
        gone = 0.0_real64
        do while (gone < over - gone .and. next <= size(order))
          i = order(next)
          next = next + 1
          if (is_one(i)) cycle
          is_one(i) = .true.
          if (hosts(i) > 0) is_one(hosts(i)) = .true.
          gone = gone + error(i)
        end do
      end do
    end associate
  end subroutine choose_resolved

  !> Also resolves circles that go together with a member's, as its cells have it: a contact in a
  !> ring around another has its centre there.
  subroutine reach_others(pairs, clusters, is_one, more)
    type(contact_pairs), intent(in) :: pairs      !! the position
    type(cluster), intent(in) :: clusters(:)      !! solved
    logical, intent(inout) :: is_one(:)           !! by pair: resolved
    logical, intent(out) :: more                  !! than before
    integer :: k, l

    more = .false.
    do k = 1, size(clusters)
      associate (o => clusters(k)%outside, all => clusters(k)%answer%together, &
                 list => pairs%list(clusters(k)%members))
        if (.not. allocated(o%pair)) cycle
        do l = 1, size(o%pair)
          ! On cells of another cluster.
          if (is_one(o%pair(l))) cycle
          ! Circles of Hertz by their loads.
          if (.not. any(all%load > 0.0_real64 .and. hypot(all%x - o%x(l), all%y - o%y(l)) < &
              along * (o%circle(l) + (0.75_real64 * all%load / pairs%modulus * &
                                      list%radius)**(1.0_real64 / 3)))) cycle
          is_one(o%pair(l)) = .true.
          more = .true.
        end do
      end associate
    end do
  end subroutine reach_others

end module asperity_joint_contacts
