!> Contacts that share a half-space: circles, and on cells those that are none any more.
!>
!> All contacts are coupled as circles. Those whose indicated error is too large, with all that is
!> close to them, are solved on cells, a cluster on a lattice, under the field of all others cell by
!> cell. A cluster answers with its loads and the centres of its pressures; the circles are coupled
!> again with contacts that carry just these loads there, and so on until the total settles. The
!> coupling knows how every load moves every other, so that only the cells' corrections lag.
module asperity_joint_contacts
  use asperity_cells_outside, only: beside_circle
  use asperity_cells_solver, only: cells_answer, outside_field, reach_of_cluster, solve_cells
  use asperity_chebyshev_basis, only: chebyshev_nodes
  use asperity_circle_error, only: find_errors, open_about
  use asperity_circle_field, only: circle_set
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_contacts, only: adopt, coupled_solution, resolved_contacts, solve_coupled
  use asperity_kinds, only: real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  use asperity_source_tree, only: plant_tree, source_tree
  implicit none
  private

  public :: joint_solution, solve_joint

  !> What was found.
  type :: joint_solution
    type(coupled_solution) :: coupled               !! closing, penetrations, circles
    real(real64), allocatable :: area(:)            !! in plan, by pair
    real(real64), allocatable :: maximum_pressure(:) !! by pair; below 0: that of its law
    logical, allocatable :: is_resolved(:)          !! by pair
    integer :: clusters = 0, cells = 0              !! of those resolved
    integer :: rounds = 0                           !! of circles and cells
    real(real64) :: error = 0.0_real64              !! estimate, a share of the total load
    real(real64) :: area_error = 0.0_real64         !! estimate, a share of the area
    character(len=:), allocatable :: failure        !! why there is none
  end type joint_solution

  ! A cluster of resolved contacts.
  type :: cluster
    integer, allocatable :: members(:)              ! places in the list of pairs
    type(cells_answer) :: answer
    real(real64) :: lowered = 0.0_real64            ! of the closing, for its cells
  end type cluster

  !> Which contacts are resolved.
  integer, parameter, public :: resolve_none = 0, resolve_all = 1, resolve_called_for = 2

  ! Shares of a tolerance: what circles may leave out, the last halving of cells, the last round.
  real(real64), parameter :: left_share = 0.4_real64, cells_share = 0.25_real64
  real(real64), parameter :: round_share = 0.2_real64
  ! Sums of radii between members of two clusters, at least: what a contact's being oval changes at
  ! another falls with the sixth power of their distance, and is below 4e-6 of its load from there.
  real(real64), parameter :: between = 3.0_real64
  ! A cluster that bears less than its part of the total over this is told as if it bore that: all
  ! errors together are a quarter above the tolerance at most.
  real(real64), parameter :: few_of_all = 4.0_real64
  ! Radii from a circle within which an open contact shares its cells.
  real(real64), parameter :: about_member = 1.3_real64
  integer, parameter :: most_rounds = 30
  ! Penetration of a resolved contact that the cells leave open: it joins no more.
  real(real64), parameter :: far_below = -1.0e-3_real64 * huge(1.0_real64)
  ! Of the change by the last halving, what the finest cells are off by: errors fall by 4 to 7.
  real(real64), parameter :: change_left = 1.0_real64 / 3.0_real64
  ! Relative error of an area over that of its load, and scatter of an area on cells (cells_solver).
  real(real64), parameter :: area_per_load = 16.0_real64 / 3.0_real64 + 2.0_real64 / 3.0_real64
  real(real64), parameter :: rim_scatter = 0.0075_real64
  ! A gap off everywhere moves a load by 1.5 times as much; neighbours that have taken half of
  ! a penetration double that. Largest on two paraboloids that overlap: 2.2.
  real(real64), parameter :: gap_left = 3.0_real64
  ! Chebyshev nodes of a field whose sources are farther off than so many half diagonals: 8 nodes
  ! are right within (3 + sqrt(8))**-8 = 1e-6 of it.
  integer, parameter :: nodes = 8
  real(real64), parameter :: far_off = 3.0_real64

contains

  !> Solves at the closing in `solution%coupled`, or at a load.
  subroutine solve_joint(pairs, law, which, tolerance, cells_tolerance, solution, target)
    type(contact_pairs), intent(in) :: pairs           !! those that may touch, ascending gap
    class(contact_law), intent(in) :: law              !! of each contact
    integer, intent(in) :: which                       !! `resolve_none` ...
    real(real64), intent(in) :: tolerance              !! share of load and area, where called for
    real(real64), intent(in) :: cells_tolerance        !! relative change by the last halving
    type(joint_solution), intent(inout) :: solution    !! closing; then all
    real(real64), intent(in), optional :: target       !! normal load
    type(resolved_contacts) :: resolved
    type(cluster), allocatable :: clusters(:)
    real(real64), allocatable :: error(:), emission(:)
    integer, allocatable :: hosts(:)
    real(real64) :: before, now, total, allowed, left
    integer :: k

    call solve_coupled(pairs, law, solution%coupled, target)
    if (failed(solution)) return
    associate (n => size(pairs%list))
      allocate (error(n), hosts(n), solution%is_resolved(n))
    end associate
    solution%is_resolved = .false.
    if (size(solution%coupled%set%number) == 0) then
      ! Nothing touches.
      call tell_areas(pairs, law, clusters, solution)
      return
    end if
    call find_errors(pairs, solution%coupled, hosts, error, emission)
    total = sum(solution%coupled%set%load)
    solution%is_resolved = .false.
    left = left_out(solution, error, emission)
    if (which == resolve_all) solution%is_resolved = pairs%list%gap < solution%coupled%closing
    do while (which == resolve_called_for .and. left > left_share * tolerance * total)
      call choose(pairs, solution, left_share * tolerance * total, error, emission, hosts)
      left = left_out(solution, error, emission)
    end do
    left = left_out(solution, error, emission)
    if (any(solution%is_resolved)) then
      call form_clusters(pairs, solution, clusters)
      allocate (resolved%is_one(size(error)), resolved%x(size(error)), resolved%y(size(error)), &
                resolved%gap(size(error)))
      resolved%is_one = solution%is_resolved
      allowed = merge(cells_tolerance, cells_share * tolerance, &
                      which == resolve_all)
      now = measure()
      do
        solution%rounds = solution%rounds + 1
        !$omp parallel do schedule(dynamic) if(size(clusters) > 1)
        do k = 1, size(clusters)
          call solve_cluster(pairs, solution%coupled, allowed, &
                             pairs%modulus * total / (few_of_all * size(clusters)), clusters(k))
        end do
        !$omp end parallel do
        call answer_with(pairs, law, clusters, solution, resolved)
        if (allocated(solution%failure)) return
        call solve_coupled(pairs, law, solution%coupled, target, resolved)
        if (failed(solution)) return
        before = now
        now = measure()
        if (abs(now - before) <= round_share * merge(cells_tolerance, tolerance, &
                                                     which == resolve_all) * now) exit
        ! All contacts in one cluster, at a closing: there is nothing to go back to.
        if (size(clusters) == 1 .and. .not. present(target) .and. &
            size(clusters(1)%members) == count(pairs%list%gap < solution%coupled%closing)) then
          before = now
          exit
        end if
        if (solution%rounds == most_rounds) then
          solution%failure = 'circles and cells do not settle'
          return
        end if
      end do
      total = sum(solution%coupled%set%load)
      ! Open: below 0, as 0 is a contact at first touch.
      where (solution%coupled%penetration < 0.5_real64 * far_below) &
        solution%coupled%penetration = -tiny(1.0_real64)
    end if
    call tell_areas(pairs, law, clusters, solution)
    solution%area_error = area_left(solution, error)
    solution%error = left / max(total, tiny(total))
    if (allocated(clusters)) then
      do k = 1, size(clusters)
        solution%error = solution%error + (change_left * clusters(k)%answer%change + &
                         gap_left * clusters(k)%answer%ending%residual) * &
                         sum(clusters(k)%answer%vertical_load) / (pairs%modulus * total)
      end do
      solution%error = solution%error + abs(now - before) / now
    end if

  contains

    ! What must settle: the load, or the closing at it.
    real(real64) function measure()
      if (present(target)) then
        measure = solution%coupled%closing
      else
        measure = sum(solution%coupled%set%load)
      end if
    end function measure

  end subroutine solve_joint

  logical function failed(solution)
    type(joint_solution), intent(inout) :: solution
    character(len=40) :: digits

    if (allocated(solution%coupled%failure)) then
      solution%failure = solution%coupled%failure
    else if (.not. solution%coupled%ending%converged) then
      write (digits, '(es9.1e3, ", iteration ", i0)') solution%coupled%ending%residual, &
        solution%coupled%ending%iterations
      solution%failure = 'did not converge: residual ' // trim(adjustl(digits))
    end if
    failed = allocated(solution%failure)
  end function failed

  ! What circles leave out: each by itself, and at its neighbours, unless both are on cells.
  real(real64) function left_out(solution, error, emission) result(left)
    type(joint_solution), intent(in) :: solution
    real(real64), intent(in) :: error(:), emission(:)
    integer :: k, l

    left = sum(error, mask=.not. solution%is_resolved)
    associate (set => solution%coupled%set, is_one => solution%is_resolved)
      do k = 1, size(set%number)
        do l = set%tree%first(k), set%tree%first(k + 1) - 1
          if (.not. (is_one(set%number(k)) .and. is_one(set%number(set%tree%near(l))))) &
            left = left + emission(l)
        end do
      end do
    end associate
  end function left_out

  ! What the area may be off by, a share of it. The harmonic n of the neighbours' field on the edge
  ! changes an area by the order of (U_n/p)**2, of the load it changes 3/16 of that; a load that is
  ! off has the area off by 2/3. Cells leave three standard deviations of the scatter at their rim.
  real(real64) function area_left(solution, error) result(share)
    type(joint_solution), intent(in) :: solution
    real(real64), intent(in) :: error(:)
    real(real64) :: on_cells
    integer :: k, l

    share = 0.0_real64
    if (.not. sum(solution%area) > 0.0_real64) return
    associate (set => solution%coupled%set)
      do k = 1, size(set%number)
        if (solution%is_resolved(set%number(k))) cycle
        share = share + area_per_load * error(set%number(k)) / set%load(k) * &
                solution%area(set%number(k))
      end do
    end associate
    on_cells = sum(solution%area, mask=solution%is_resolved)
    l = count(solution%is_resolved .and. solution%area > 0.0_real64)
    if (l > 0) share = share + rim_scatter * on_cells / sqrt(real(l, real64))
    share = share / sum(solution%area)
  end function area_left

  ! Who goes on cells: the largest errors, the more the farther off the rest is, and what is close.
  subroutine choose(pairs, solution, allowed, error, emission, hosts)
    type(contact_pairs), intent(in) :: pairs
    type(joint_solution), intent(inout) :: solution
    integer, intent(in) :: hosts(:)
    real(real64), intent(in) :: allowed, error(:), emission(:)
    type(source_tree) :: tree
    real(real64) :: most(size(error)), gone, over
    integer, allocatable :: number(:)
    integer :: i, k, l
    logical :: more

    associate (is_one => solution%is_resolved, set => solution%coupled%set)
      most = error
      where (is_one) most = 0.0_real64
      ! A pair of neighbours of which one is not on cells counts for both.
      do k = 1, size(set%number)
        do l = set%tree%first(k), set%tree%first(k + 1) - 1
          i = set%number(set%tree%near(l))
          if (.not. is_one(i)) most(i) = most(i) + emission(l)
          if (.not. is_one(set%number(k))) most(set%number(k)) = most(set%number(k)) + emission(l)
        end do
      end do
      over = left_out(solution, error, emission) - allowed
      gone = 0.0_real64
      do while (gone < 0.5_real64 * over .or. .not. gone > 0.0_real64)
        i = maxloc(most, dim=1)
        if (.not. most(i) > 0.0_real64) exit
        is_one(i) = .true.
        if (hosts(i) > 0) is_one(hosts(i)) = .true.
        gone = gone + most(i)
        most(i) = 0.0_real64
      end do
      if (.not. any(is_one)) return
      ! Circles that overlap a member.
      do
        more = .false.
        do k = 1, size(set%number)
          if (.not. is_one(set%number(k))) cycle
          do l = set%tree%first(k), set%tree%first(k + 1) - 1
            associate (j => set%tree%near(l))
              if (is_one(set%number(j))) cycle
              if (hypot(set%x(k) + set%move_x(k) - set%x(j) - set%move_x(j), &
                        set%y(k) + set%move_y(k) - set%y(j) - set%move_y(j)) < &
                  set%circle(k) + set%circle(j)) then
                is_one(set%number(j)) = .true.
                more = .true.
              end if
            end associate
          end do
        end do
        if (.not. more) exit
      end do
      call open_about(pairs, solution%coupled, about_member, tree, number)
      do i = 1, size(number)
        do l = tree%first(i), tree%first(i + 1) - 1
          if (is_one(set%number(tree%near(l)))) is_one(number(i)) = .true.
        end do
      end do
    end associate
  end subroutine choose

  ! Members nearer to each other than `between` share a lattice.
  subroutine form_clusters(pairs, solution, clusters)
    type(contact_pairs), intent(in) :: pairs
    type(joint_solution), intent(inout) :: solution
    type(cluster), allocatable, intent(out) :: clusters(:)
    type(source_tree) :: tree
    integer, allocatable :: number(:), parent(:), row(:), of(:)
    real(real64), allocatable :: reach(:)
    integer :: i, k, l, n

    number = pack([(i, i=1, size(pairs%list))], solution%is_resolved)
    n = size(number)
    allocate (reach(n), of(n))
    parent = [(i, i=1, n)]
    allocate (row(size(pairs%list)), source=0)
    row(solution%coupled%set%number) = [(i, i=1, size(solution%coupled%set%number))]
    do i = 1, n
      reach(i) = 1.0e-3_real64 * sqrt(pairs%list(number(i))%radius * &
                                      (solution%coupled%closing - pairs%list(number(i))%gap))
      if (row(number(i)) > 0) reach(i) = solution%coupled%set%circle(row(number(i)))
    end do
    call plant_tree(tree, pairs%list(number)%x, pairs%list(number)%y, reach, between)
    do i = 1, n
      do l = tree%first(i), tree%first(i + 1) - 1
        k = root_of(tree%near(l))
        parent(max(k, root_of(i))) = min(k, root_of(i))
      end do
    end do
    k = 0
    of = 0
    do i = 1, n
      if (root_of(i) == i) then
        k = k + 1
        of(i) = k
      end if
    end do
    allocate (clusters(k))
    do i = 1, n
      of(i) = of(root_of(i))
    end do
    do i = 1, k
      clusters(i)%members = pack(number, of == i)
    end do
    solution%clusters = k

  contains

    integer function root_of(one)
      integer, intent(in) :: one

      root_of = one
      do while (parent(root_of) /= root_of)
        root_of = parent(root_of)
      end do
    end function root_of

  end subroutine form_clusters

  ! One cluster under the field of the circles that are no members.
  subroutine solve_cluster(pairs, coupled, tolerance, worth, one)
    type(contact_pairs), intent(in) :: pairs
    type(coupled_solution), intent(in) :: coupled
    real(real64), intent(in) :: tolerance, worth
    type(cluster), intent(inout) :: one
    type(outside_field) :: outside
    logical, allocatable :: is_member(:)
    integer, allocatable :: others(:)
    integer :: i, pass

    allocate (is_member(size(pairs%list)), source=.false.)
    is_member(one%members) = .true.
    others = pack([(i, i=1, size(coupled%set%number))], .not. is_member(coupled%set%number))
    one%lowered = 0.0_real64
    if (size(others) > 0) then
      ! What the others lower the whole cluster by makes its lattice smaller.
      do pass = 1, 3
        call reach_of_cluster(pairs, one%members, coupled%closing - one%lowered, outside%x0, &
                              outside%x1, outside%y0, outside%y1)
        if (.not. outside%x1 > outside%x0) exit
        call field_of(coupled, others, pairs%modulus, outside, one%lowered)
      end do
      if (allocated(outside%at_nodes)) outside%at_nodes = outside%at_nodes - one%lowered
    end if
    call solve_cells(pairs, one%members, coupled%closing - one%lowered, outside, tolerance, &
                     one%answer, worth)
  end subroutine solve_cluster

  ! The field of some circles on a rectangle, and a bound that it is nowhere below.
  subroutine field_of(coupled, others, modulus, outside, least)
    type(coupled_solution), intent(in) :: coupled
    integer, intent(in) :: others(:)
    real(real64), intent(in) :: modulus
    type(outside_field), intent(inout) :: outside
    real(real64), intent(out) :: least
    real(real64), allocatable :: x(:), y(:), node(:)
    logical, allocatable :: is_near(:)
    real(real64) :: half, middle(2), place(2)
    integer :: i, j, k

    associate (set => coupled%set)
      allocate (x, source=set%x(others) + set%move_x(others))
      allocate (y, source=set%y(others) + set%move_y(others))
      middle = 0.5_real64 * [outside%x0 + outside%x1, outside%y0 + outside%y1]
      half = 0.5_real64 * hypot(outside%x1 - outside%x0, outside%y1 - outside%y0)
      is_near = hypot(x - middle(1), y - middle(2)) < far_off * half + set%circle(others)
      outside%x = pack(x, is_near)
      outside%y = pack(y, is_near)
      outside%circle = pack(set%circle(others), is_near)
      outside%load = pack(set%load(others), is_near) * modulus
      node = chebyshev_nodes(nodes)
      if (allocated(outside%at_nodes)) deallocate (outside%at_nodes)
      allocate (outside%at_nodes(nodes, nodes), source=0.0_real64)
      do k = 1, size(others)
        if (is_near(k)) cycle
        do j = 1, nodes
          do i = 1, nodes
            place = middle + 0.5_real64 * [node(i) * (outside%x1 - outside%x0), &
                                           node(j) * (outside%y1 - outside%y0)]
            outside%at_nodes(i, j) = outside%at_nodes(i, j) + set%load(others(k)) * &
              beside_circle(set%circle(others(k)), hypot(place(1) - x(k), place(2) - y(k)))
          end do
        end do
      end do
      ! Between the nodes the field is a little less than at the least of them at most.
      least = 0.98_real64 * minval(outside%at_nodes)
      do k = 1, size(others)
        if (.not. is_near(k)) cycle
        least = least + set%load(others(k)) * beside_circle(set%circle(others(k)), &
                hypot(abs(x(k) - middle(1)) + 0.5_real64 * (outside%x1 - outside%x0), &
                      abs(y(k) - middle(2)) + 0.5_real64 * (outside%y1 - outside%y0)))
      end do
    end associate
  end subroutine field_of

  ! The answers of the cells, as contacts that carry their loads where their pressures are.
  subroutine answer_with(pairs, law, clusters, solution, resolved)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(cluster), intent(in) :: clusters(:)
    type(joint_solution), intent(inout) :: solution
    type(resolved_contacts), intent(inout) :: resolved
    type(contact_response) :: free
    type(circle_set) :: old
    real(real64) :: share
    integer :: i, k, m

    old = solution%coupled%set
    solution%cells = 0
    do k = 1, size(clusters)
      associate (answer => clusters(k)%answer, coupled => solution%coupled)
        if (allocated(answer%failure)) then
          solution%failure = answer%failure
          return
        end if
        solution%cells = solution%cells + answer%cells
        do m = 1, size(clusters(k)%members)
          i = clusters(k)%members(m)
          resolved%x(i) = answer%centre_x(m)
          resolved%y(i) = answer%centre_y(m)
          coupled%penetration(i) = far_below
          coupled%move_x(i) = 0.0_real64
          coupled%move_y(i) = 0.0_real64
          if (.not. (answer%vertical_load(m) > 0.0_real64 .and. &
                     answer%alone_load(m) > 0.0_real64)) cycle
          ! Together over alone: how a pair is inclined counts as it does in its law. Neighbours
          ! never raise a load: more than 1 is what the cells are not solved to.
          share = min(1.0_real64, answer%vertical_load(m) / answer%alone_load(m))
          call law%respond(pairs%list(i), i, &
                           coupled%closing - clusters(k)%lowered - pairs%list(i)%gap, free)
          coupled%penetration(i) = penetration_at(pairs, law, i, share * free%vertical_load, &
                                                  coupled%closing - pairs%list(i)%gap)
        end do
      end associate
    end do
    call adopt(pairs, law, solution%coupled, resolved)
    if (allocated(solution%coupled%failure)) return
    do k = 1, size(clusters)
      call lift_by_others(old, solution%coupled, clusters(k)%members, resolved%gap)
    end do
  end subroutine answer_with

  ! The cells were solved under the others' old loads. With these the equations shall hold, so that
  ! the coupling lets each cluster respond to what the others have become since.
  subroutine lift_by_others(old, coupled, members, gap)
    type(circle_set), intent(in) :: old
    type(coupled_solution), intent(in) :: coupled
    integer, intent(in) :: members(:)
    real(real64), intent(inout) :: gap(:)
    integer :: before(size(gap)), now(size(gap)), i, j, m, n

    if (size(members) == max(size(old%number), size(coupled%set%number))) return
    before = 0
    now = 0
    before(old%number) = [(i, i=1, size(old%number))]
    now(coupled%set%number) = [(i, i=1, size(coupled%set%number))]
    do m = 1, size(members)
      i = members(m)
      if (before(i) == 0 .or. now(i) == 0) cycle
      ! The field of the others alone: first as it is, then as it was.
      gap(i) = gap(i) + coupled%set%lift(now(i)) - old%lift(before(i))
      do n = 1, size(members)
        j = members(n)
        if (n == m) cycle
        if (now(j) > 0) gap(i) = gap(i) - lift(coupled%set, now(i), now(j))
        if (before(j) > 0) gap(i) = gap(i) + lift(old, before(i), before(j))
      end do
    end do

  contains

    real(real64) function lift(set, on, by)
      type(circle_set), intent(in) :: set
      integer, intent(in) :: on, by
      type(mutual_terms) :: terms

      call mutual_displacement(hypot(set%x(on) + set%move_x(on) - set%x(by) - set%move_x(by), &
                                     set%y(on) + set%move_y(on) - set%y(by) - set%move_y(by)), &
                               set%circle(on), set%circle(by), terms)
      lift = set%load(by) * terms%on_first
    end function lift

  end subroutine lift_by_others

  ! Where a law has a vertical load.
  real(real64) function penetration_at(pairs, law, i, load, most) result(p)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    integer, intent(in) :: i
    real(real64), intent(in) :: load, most
    type(contact_response) :: response
    real(real64) :: before
    integer :: step

    p = most
    ! Newton's method on load**(2/3), nearly straight.
    do step = 1, 50
      call law%respond(pairs%list(i), i, p, response)
      if (.not. response%stiffness > 0.0_real64) exit
      before = p
      p = p + 1.5_real64 * response%vertical_load / response%stiffness * &
          ((load / response%vertical_load)**(2.0_real64 / 3.0_real64) - 1.0_real64)
      p = min(max(p, 0.1_real64 * before), 2 * before)
      if (abs(p - before) <= 1.0e-14_real64 * p) exit
    end do
  end function penetration_at

  ! Areas in plan: of circles to first order in the bend of the neighbours' field, a**2 = R (p -
  ! growth), where that is convex; of cells as they are.
  subroutine tell_areas(pairs, law, clusters, solution)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(cluster), allocatable, intent(in) :: clusters(:)
    type(joint_solution), intent(inout) :: solution
    type(contact_response) :: response
    real(real64), parameter :: pi = acos(-1.0_real64)
    integer :: i, k, m

    allocate (solution%area(size(pairs%list)), solution%maximum_pressure(size(pairs%list)))
    solution%area = 0.0_real64
    solution%maximum_pressure = -1.0_real64
    associate (coupled => solution%coupled, set => solution%coupled%set)
      do k = 1, size(set%number)
        i = set%number(k)
        if (solution%is_resolved(i)) cycle
        solution%area(i) = pi * set%circle(k)**2 * &
          (1.0_real64 - min(max(set%growth(k) / coupled%penetration(i), 0.0_real64), 0.5_real64))
      end do
      if (.not. allocated(clusters)) return
      do k = 1, size(clusters)
        do m = 1, size(clusters(k)%members)
          i = clusters(k)%members(m)
          if (.not. coupled%penetration(i) > 0.0_real64) cycle
          ! Together over alone, as the load.
          call law%respond(pairs%list(i), i, coupled%closing - clusters(k)%lowered - &
                           pairs%list(i)%gap, response)
          solution%area(i) = pi * response%contact_radius**2 * &
                             clusters(k)%answer%area(m) / clusters(k)%answer%alone_area(m)
          solution%maximum_pressure(i) = clusters(k)%answer%maximum_pressure(m)
        end do
      end do
    end associate
  end subroutine tell_areas

end module asperity_joint_contacts
