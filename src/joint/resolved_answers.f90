!> Results of the boundary elements of clusters, passed on to the Hertzian contacts.
module asperity_resolved_answers
  use asperity_circle_field, only: circle_set, relative_position
  use asperity_outside_field, only: circle_displacement
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_coupled_contacts, only: adopt_penetrations, coupled_solution, resolved_contacts
  use asperity_coupled_state, only: far_below, raise_to_load
  use asperity_kinds, only: real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  use asperity_resolved_clusters, only: cluster
  implicit none
  private

  public :: represent_clusters, distribute_loads

  ! The law of one contact of a list.
  type, extends(contact_law) :: law_of_one
    class(contact_law), pointer :: whole => null()
    integer :: contact = 0                          ! place in the list
  contains
    procedure :: respond => respond_as_one
  end type law_of_one

  ! Least share of a change of gaps that is applied (chosen; test: clusters in
  ! test/unit/joint_suite.f90).
  real(real64), parameter :: least_taken = 0.1_real64

contains

  !> Finds the response of the contact.
  pure subroutine respond_as_one(self, pair, number, penetration, response)
    class(law_of_one), intent(in) :: self            !! law with its list
    type(contact_pair), intent(in) :: pair           !! pair of asperities
    integer, intent(in) :: number                    !! number in the list of one, 1
    real(real64), intent(in) :: penetration          !! vertical, past first touch; less than zc
    type(contact_response), intent(out) :: response  !! response of the contact

    call self%whole%respond(pair, self%contact + number - 1, penetration, response)
  end subroutine respond_as_one

  !> Represents the clusters by contacts that carry their loads at the centres of their pressures.
  subroutine represent_clusters(pairs, law, clusters, coupled, resolved, each)
    type(contact_pairs), intent(in) :: pairs            !! pairs of the position
    class(contact_law), intent(in) :: law               !! of each contact
    type(cluster), intent(inout) :: clusters(:)         !! solved; get loads and hosts
    type(coupled_solution), intent(inout) :: coupled    !! gets their penetrations
    type(resolved_contacts), intent(inout) :: resolved  !! those on cells: all but places and gaps
    logical, intent(in) :: each                         !! each contact represents itself
    type(contact_response) :: isolated
    type(circle_set) :: old_set
    real(real64), dimension(size(pairs%list)) :: former_gap
    integer, dimension(size(pairs%list)) :: old_circle, new_circle
    real(real64) :: share
    integer :: i, k, m

    old_set = coupled%set
    former_gap = resolved%gap
    do k = 1, size(clusters)
      associate (answer => clusters(k)%answer, members => clusters(k)%members)
        resolved%x(members) = answer%contacts%x
        resolved%y(members) = answer%contacts%y
        coupled%penetration(members) = far_below
        coupled%shift(:, members) = 0.0_real64
        clusters(k)%load = 0 * answer%contacts%load
        do m = 1, size(members)
          i = members(m)
          if (.not. (answer%contacts(m)%load > 0.0_real64 .and. &
                     answer%isolated(m)%load > 0.0_real64)) cycle
          ! Together over alone: how a pair is inclined counts as it does in its law. Neighbours
          ! never raise a load: more than 1 is what the cells are not solved to.
          share = answer%contacts(m)%load / answer%isolated(m)%load
          if (answer%is_isolated_solved(m)) share = min(1.0_real64, share)
          call law%respond(pairs%list(i), i, &
                           coupled%closing - clusters(k)%displacement - pairs%list(i)%gap, isolated)
          clusters(k)%load(m) = share * isolated%vertical_load
        end do
      end associate
      call find_hosts(pairs, law, clusters(k), coupled, resolved, each)
    end do
    call adopt_penetrations(pairs, law, coupled, resolved)
    if (allocated(coupled%failure)) return
    old_circle = 0
    new_circle = 0
    old_circle(old_set%contact) = [(i, i=1, size(old_set%contact))]
    new_circle(coupled%set%contact) = [(i, i=1, size(coupled%set%contact))]
    where (.not. resolved%is_resolved) resolved%gap = pairs%list%gap
    do k = 1, size(clusters)
      associate (members => clusters(k)%members, gap => resolved%gap)
        ! The cells were solved under the others' old loads. With these the equations shall hold, so
        ! that the coupling lets each cluster respond to what the others have become since: without,
        ! 6500 contacts with 700 on cells took more than twenty times as long.
        gap(members) = gap(members) + &
          merge(displacement_by_others(coupled%set, new_circle(members)) - &
                displacement_by_others(old_set, old_circle(members)), &
                0.0_real64, old_circle(members) > 0 .and. new_circle(members) > 0)
        call apply_change(clusters(k), former_gap(members), gap)
        call correct_outside_gaps(clusters(k), coupled%set, pack(new_circle(members), &
                                                                 new_circle(members) > 0), resolved)
      end associate
    end do
  end subroutine represent_clusters

  ! Gaps between the last ones and those that the cells call for, by the secant of the last two
  ! rounds (Aitken), where a cluster answers to the closing more stiffly than its circles: a ring
  ! around a contact grows in all its length, and rounds would alternate without end.
  subroutine apply_change(one, former_gap, gap)
    type(cluster), intent(inout) :: one
    real(real64), intent(in) :: former_gap(:)  ! by member
    real(real64), intent(inout) :: gap(:)      ! by pair
    real(real64) :: change(size(former_gap)), share_applied(size(former_gap))

    change = gap(one%members) - former_gap
    share_applied = 1.0_real64
    if (allocated(one%change)) then
      where (max(abs(change), abs(one%change)) < -far_below .and. &
             sign(1.0_real64, one%change) * (one%change - change) > 0.0_real64) &
        share_applied = max(least_taken, min(1.0_real64, one%taken * &
                                             (one%change / (one%change - change))))
      gap(one%members) = merge(former_gap + share_applied * change, gap(one%members), &
                               share_applied < 1.0_real64)
    end if
    one%change = change
    one%taken = share_applied
  end subroutine apply_change

  ! Members of which one has its centre in the other's circle are one circle for all others, with
  ! the law of the one that bears most. How they share their load hardly matters there, and the
  ! equations of circles nearly in one place have several solutions. Who was one stays one.
  subroutine find_hosts(pairs, law, one, coupled, resolved, each)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(cluster), intent(inout) :: one
    type(coupled_solution), intent(inout) :: coupled
    type(resolved_contacts), intent(inout) :: resolved
    logical, intent(in) :: each
    real(real64), dimension(size(one%members)) :: load, circle
    integer, dimension(size(one%members)) :: former_host
    logical :: merged
    integer :: a, b, m

    load = one%load
    if (.not. allocated(one%host)) one%host = [(m, m=1, size(load))]
    former_host = one%host
    one%host = [(m, m=1, size(load))]
    do m = 1, size(load)
      call set_circle(m)
    end do
    merged = .not. each
    do while (merged)
      merged = .false.
      do a = 1, size(load)
        do b = 1, size(load)
          if (a == b .or. load(b) > load(a) .or. .not. load(b) > 0.0_real64) cycle
          associate (i => one%members(a), j => one%members(b), x => resolved%x, y => resolved%y, &
                     weight => load(b) / (load(a) + load(b)))
            if (former_host(a) /= former_host(b) .and. &
                .not. hypot(x(i) - x(j), y(i) - y(j)) < max(circle(a), circle(b))) cycle
            x(i) = x(i) + weight * (x(j) - x(i))
            y(i) = y(i) + weight * (y(j) - y(i))
            coupled%penetration(j) = far_below
          end associate
          where (one%host == b) one%host = a
          load(a) = load(a) + load(b)
          load(b) = 0.0_real64
          call set_circle(a)
          merged = .true.
        end do
      end do
    end do

  contains

    subroutine set_circle(m)
      integer, intent(in) :: m
      type(contact_response) :: response

      circle(m) = 0.0_real64
      if (.not. load(m) > 0.0_real64) return
      associate (i => one%members(m))
        coupled%penetration(i) = penetration_at(pairs, law, i, load(m), &
                                                coupled%closing - pairs%list(i)%gap)
        call law%respond(pairs%list(i), i, coupled%penetration(i), response)
        circle(m) = response%contact_radius
      end associate
    end subroutine set_circle

  end subroutine find_hosts

  !> Distributes the loads of hosts over the contacts that they represent, as on the elements.
  subroutine distribute_loads(pairs, law, clusters, coupled, resolved)
    type(contact_pairs), intent(in) :: pairs            !! pairs of the position
    class(contact_law), intent(in) :: law               !! of each contact
    type(cluster), intent(in) :: clusters(:)            !! clusters that are represented
    type(coupled_solution), intent(inout) :: coupled    !! gets penetrations and circles of all
    type(resolved_contacts), intent(inout) :: resolved  !! gets their places
    type(contact_response) :: response
    real(real64) :: load_ratio
    integer :: host, i, k, m

    do k = 1, size(clusters)
      associate (one => clusters(k))
        do host = 1, size(one%members)
          i = one%members(host)
          if (count(one%host == host) < 2 .or. .not. coupled%penetration(i) > 0.0_real64) cycle
          call law%respond(pairs%list(i), i, coupled%penetration(i), response)
          load_ratio = response%vertical_load / sum(one%load, mask=one%host == host)
          do m = 1, size(one%members)
            if (one%host(m) /= host) cycle
            i = one%members(m)
            resolved%x(i) = one%answer%contacts(m)%x
            resolved%y(i) = one%answer%contacts(m)%y
            coupled%penetration(i) = penetration_at(pairs, law, i, load_ratio * one%load(m), &
                                                    coupled%closing - pairs%list(i)%gap)
          end do
        end do
      end associate
    end do
    call adopt_penetrations(pairs, law, coupled, resolved)
  end subroutine distribute_loads

  ! Adds the difference between the displacements of circles outside by elements and by circles.
  ! Without it estimates would be below the error in 7 % of the dense scenes at a tolerance of .001.
  subroutine correct_outside_gaps(one, set, circles, resolved)
    type(cluster), intent(in) :: one
    type(circle_set), intent(in) :: set
    integer, intent(in) :: circles(:)        ! in the places of the members
    type(resolved_contacts), intent(inout) :: resolved
    integer :: l

    if (.not. allocated(one%answer%outside_displacement)) return
    do l = 1, size(one%answer%outside_displacement)
      associate (n => one%outside%pair(l))
        if (.not. resolved%is_resolved(n)) resolved%gap(n) = resolved%gap(n) + &
          one%answer%outside_displacement(l) - &
          sum(set%load(circles) * circle_displacement(set%radius(circles), hypot( &
            set%x(circles) - one%outside%x(l), set%y(circles) - one%outside%y(l))))
      end associate
    end do
  end subroutine correct_outside_gaps

  ! Displacement of the members of a cluster by all others.
  pure function displacement_by_others(set, circle) result(displacement)
    type(circle_set), intent(in) :: set
    integer, intent(in) :: circle(:)         ! of each member, 0: none
    real(real64) :: displacement(size(circle))
    type(mutual_terms) :: terms
    integer :: m, n

    displacement = 0.0_real64
    do m = 1, size(circle)
      if (circle(m) == 0) cycle
      displacement(m) = set%displacement(circle(m))
      do n = 1, size(circle)
        if (n == m .or. circle(n) == 0) cycle
        associate (i => circle(m), j => circle(n))
          call mutual_displacement(norm2(relative_position(set, i, j)), set%radius(i), &
                                   set%radius(j), &
                                   terms)
          displacement(m) = displacement(m) - set%load(j) * terms%on_first
        end associate
      end do
    end do
  end function displacement_by_others

  ! Where a law has a vertical load.
  real(real64) function penetration_at(pairs, law, i, load, most) result(p)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in), target :: law
    integer, intent(in) :: i
    real(real64), intent(in) :: load, most
    type(contact_pairs) :: one_pair
    type(law_of_one) :: law_of_pair
    real(real64) :: penetration(1)

    one_pair%modulus = pairs%modulus
    one_pair%vertical = .true.
    one_pair%list = pairs%list(i:i)
    law_of_pair%whole => law
    law_of_pair%contact = i
    penetration = most
    call raise_to_load(one_pair, law_of_pair, load / pairs%modulus, penetration)
    p = penetration(1)
  end function penetration_at

end module asperity_resolved_answers
