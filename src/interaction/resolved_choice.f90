!> Which contacts go on cells: those whose indicated error is too large, with all that is close.
module asperity_resolved_choice
  use asperity_circle_error, only: open_about
  use asperity_circle_field, only: are_close
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_contacts, only: coupled_solution
  use asperity_index_groups, only: gather_groups
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: real64
  use asperity_resolved_clusters, only: cluster
  use asperity_source_tree, only: source_tree
  implicit none
  private

  public :: choose_resolved, reach_others

  ! Radii from a circle within which an open contact shares its cells.
  real(real64), parameter :: about_member = 1.3_real64
  ! Sums of radii: circles nearer to each other than that go together. Just beside a large circle
  ! the errors indicated for a small one were a third of the true ones.
  real(real64), parameter :: along = 1.1_real64

contains

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
      call open_about(pairs, coupled, about_member, tree, number)
      call sort_keys(-error, order)
      next = 1
      do
        over = sum(error, mask=.not. is_one) - 1.0_real64
        if (.not. over > 0.0_real64) exit
        ! The largest errors, the more at a time the farther off the rest is.
        gone = 0.0_real64
        do while (gone < 0.5_real64 * over .and. next <= size(order))
          i = order(next)
          next = next + 1
          if (is_one(i)) cycle
          is_one(i) = .true.
          if (hosts(i) > 0) is_one(hosts(i)) = .true.
          gone = gone + error(i)
        end do
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

end module asperity_resolved_choice
