!> Results of the boundary elements of clusters, passed on to the Hertzian contacts.
module asperity_resolved_answers
  use asperity_circle_field, only: circle_set, from_other
  use asperity_outside_field, only: beside_circle
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_coupled_contacts, only: adopt_penetrations, coupled_solution, resolved_contacts
  use asperity_coupled_state, only: far_below, raise_to_load
  use asperity_kinds, only: real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  use asperity_resolved_clusters, only: cluster
  implicit none
  private

  public :: answer_with, share_out

  ! The law of one contact of a list.
  type, extends(contact_law) :: law_of_one
    class(contact_law), pointer :: whole => null()
    integer :: number = 0                           ! place in the list
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

    call self%whole%respond(pair, self%number + number - 1, penetration, response)
  end subroutine respond_as_one

  !> Represents the clusters by contacts that carry their loads at the centres of their pressures.
  subroutine answer_with(pairs, law, clusters, coupled, resolved, each)
    type(contact_pairs), intent(in) :: pairs            !! pairs of the position
    class(contact_law), intent(in) :: law               !! of each contact
    type(cluster), intent(inout) :: clusters(:)         !! solved; get loads and hosts
    type(coupled_solution), intent(inout) :: coupled    !! gets their penetrations
    type(resolved_contacts), intent(inout) :: resolved  !! those on cells: all but places and gaps
    logical, intent(in) :: each                         !! each contact represents itself
    type(contact_response) :: free
    type(circle_set) :: old
    real(real64), dimension(size(pairs%list)) :: used
    integer, dimension(size(pairs%list)) :: before, now
    real(real64) :: share
    integer :: i, k, m

    old = coupled%set
    used = resolved%gap
    do k = 1, size(clusters)
      associate (answer => clusters(k)%answer, members => clusters(k)%members)
        resolved%x(members) = answer%together%x
        resolved%y(members) = answer%together%y
        coupled%penetration(members) = far_below
        coupled%move(:, members) = 0.0_real64
        clusters(k)%load = 0 * answer%together%load
        do m = 1, size(members)
          i = members(m)
          if (.not. (answer%together(m)%load > 0.0_real64 .and. &
                     answer%alone(m)%load > 0.0_real64)) cycle
          ! Together over alone: how a pair is inclined counts as it does in its law. Neighbours
          ! never raise a load: more than 1 is what the cells are not solved to.
          share = answer%together(m)%load / answer%alone(m)%load
          if (answer%known_alone(m)) share = min(1.0_real64, share)
          call law%respond(pairs%list(i), i, &
                           coupled%closing - clusters(k)%lowered - pairs%list(i)%gap, free)
          clusters(k)%load(m) = share * free%vertical_load
        end do
      end associate
      call find_hosts(pairs, law, clusters(k), coupled, resolved, each)
    end do
    call adopt_penetrations(pairs, law, coupled, resolved)
    if (allocated(coupled%failure)) return
    before = 0
    now = 0
    before(old%number) = [(i, i=1, size(old%number))]
    now(coupled%set%number) = [(i, i=1, size(coupled%set%number))]
    where (.not. resolved%is_one) resolved%gap = pairs%list%gap
    do k = 1, size(clusters)
      associate (members => clusters(k)%members, gap => resolved%gap)
        ! The cells were solved under the others' old loads. With these the equations shall hold, so
        ! that the coupling lets each cluster respond to what the others have become since: without,
        ! 6500 contacts with 700 on cells took more than twenty times as long.
        gap(members) = gap(members) + &
          merge(by_others(coupled%set, now(members)) - by_others(old, before(members)), &
                0.0_real64, before(members) > 0 .and. now(members) > 0)
        call apply_change(clusters(k), used(members), gap)
        call lift_others(clusters(k), coupled%set, pack(now(members), now(members) > 0), resolved)
      end associate
    end do
  end subroutine answer_with

  ! Gaps between the last ones and those that the cells call for, by the secant of the last two
  ! rounds (Aitken), where a cluster answers to the closing more stiffly than its circles: a ring
  ! around a contact grows in all its length, and rounds would alternate without end.
  subroutine apply_change(one, used, gap)
    type(cluster), intent(inout) :: one
    real(real64), intent(in) :: used(:)        ! by member
    real(real64), intent(inout) :: gap(:)      ! by pair
    real(real64) :: change(size(used)), taken(size(used))

    change = gap(one%members) - used
    taken = 1.0_real64
    if (allocated(one%change)) then
      where (max(abs(change), abs(one%change)) < -far_below .and. &
             sign(1.0_real64, one%change) * (one%change - change) > 0.0_real64) &
        taken = max(least_taken, min(1.0_real64, one%taken * (one%change / (one%change - change))))
      gap(one%members) = merge(used + taken * change, gap(one%members), taken < 1.0_real64)
    end if
    one%change = change
    one%taken = taken
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
    integer, dimension(size(one%members)) :: was
    logical :: joined
    integer :: a, b, m

    load = one%load
    if (.not. allocated(one%host)) one%host = [(m, m=1, size(load))]
    was = one%host
    one%host = [(m, m=1, size(load))]
    do m = 1, size(load)
      call set_circle(m)
    end do
    joined = .not. each
    do while (joined)
      joined = .false.
      do a = 1, size(load)
        do b = 1, size(load)
          if (a == b .or. load(b) > load(a) .or. .not. load(b) > 0.0_real64) cycle
          associate (i => one%members(a), j => one%members(b), x => resolved%x, y => resolved%y, &
                     part => load(b) / (load(a) + load(b)))
            if (was(a) /= was(b) .and. &
                .not. hypot(x(i) - x(j), y(i) - y(j)) < max(circle(a), circle(b))) cycle
            x(i) = x(i) + part * (x(j) - x(i))
            y(i) = y(i) + part * (y(j) - y(i))
            coupled%penetration(j) = far_below
          end associate
          where (one%host == b) one%host = a
          load(a) = load(a) + load(b)
          load(b) = 0.0_real64
          call set_circle(a)
          joined = .true.
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
  subroutine share_out(pairs, law, clusters, coupled, resolved)
    type(contact_pairs), intent(in) :: pairs            !! pairs of the position
    class(contact_law), intent(in) :: law               !! of each contact
    type(cluster), intent(in) :: clusters(:)            !! clusters that are represented
    type(coupled_solution), intent(inout) :: coupled    !! gets penetrations and circles of all
    type(resolved_contacts), intent(inout) :: resolved  !! gets their places
    type(contact_response) :: response
    real(real64) :: borne
    integer :: host, i, k, m

    do k = 1, size(clusters)
      associate (one => clusters(k))
        do host = 1, size(one%members)
          i = one%members(host)
          if (count(one%host == host) < 2 .or. .not. coupled%penetration(i) > 0.0_real64) cycle
          call law%respond(pairs%list(i), i, coupled%penetration(i), response)
          borne = response%vertical_load / sum(one%load, mask=one%host == host)
          do m = 1, size(one%members)
            if (one%host(m) /= host) cycle
            i = one%members(m)
            resolved%x(i) = one%answer%together(m)%x
            resolved%y(i) = one%answer%together(m)%y
            coupled%penetration(i) = penetration_at(pairs, law, i, borne * one%load(m), &
                                                    coupled%closing - pairs%list(i)%gap)
          end do
        end do
      end associate
    end do
    call adopt_penetrations(pairs, law, coupled, resolved)
  end subroutine share_out

  ! Adds the difference between the displacements of circles outside by elements and by circles.
  ! Without it estimates would be below the error in 7 % of the dense scenes at a tolerance of .001.
  subroutine lift_others(one, set, circles, resolved)
    type(cluster), intent(in) :: one
    type(circle_set), intent(in) :: set
    integer, intent(in) :: circles(:)        ! in the places of the members
    type(resolved_contacts), intent(inout) :: resolved
    integer :: l

    if (.not. allocated(one%answer%beside)) return
    do l = 1, size(one%answer%beside)
      associate (n => one%outside%pair(l))
        if (.not. resolved%is_one(n)) resolved%gap(n) = resolved%gap(n) + one%answer%beside(l) - &
          sum(set%load(circles) * beside_circle(set%circle(circles), hypot( &
            set%x(circles) - one%outside%x(l), set%y(circles) - one%outside%y(l))))
      end associate
    end do
  end subroutine lift_others

  ! Displacement of the members of a cluster by all others.
  pure function by_others(set, circle) result(lift)
    type(circle_set), intent(in) :: set
    integer, intent(in) :: circle(:)         ! of each member, 0: none
    real(real64) :: lift(size(circle))
    type(mutual_terms) :: terms
    integer :: m, n

    lift = 0.0_real64
    do m = 1, size(circle)
      if (circle(m) == 0) cycle
      lift(m) = set%lift(circle(m))
      do n = 1, size(circle)
        if (n == m .or. circle(n) == 0) cycle
        associate (i => circle(m), j => circle(n))
          call mutual_displacement(norm2(from_other(set, i, j)), set%circle(i), set%circle(j), &
                                   terms)
          lift(m) = lift(m) - set%load(j) * terms%on_first
        end associate
      end do
    end do
  end function by_others

  ! Where a law has a vertical load.
  real(real64) function penetration_at(pairs, law, i, load, most) result(p)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in), target :: law
    integer, intent(in) :: i
    real(real64), intent(in) :: load, most
    type(contact_pairs) :: alone
    type(law_of_one) :: alone_law
    real(real64) :: found(1)

    alone%modulus = pairs%modulus
    alone%vertical = .true.
    alone%list = pairs%list(i:i)
    alone_law%whole => law
    alone_law%number = i
    found = most
    call raise_to_load(alone, alone_law, load / pairs%modulus, found)
    p = found(1)
  end function penetration_at

end module asperity_resolved_answers
