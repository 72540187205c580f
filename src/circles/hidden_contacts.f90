!> Caps that hardly stand out of the cap of another contact: they are a part of that contact.
!>
!> The potential of circles has several minima where the top of a cap lies in the circle of another
!> one. That in which the cap alone in its place carries the load is the least: equal caps in one
!> place are one surface. Such caps stay open.
module asperity_hidden_contacts
  use asperity_circle_field, only: circle_set
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_state, only: coupled_solution, far_below
  use asperity_kinds, only: real64
  implicit none
  private

  public :: is_hidden, open_hidden, stand_out

  ! Height by which a cap stands out of the surface of a loaded one, over the penetration of that
  ! [1], up to which it stays open; chosen: its own load is below its 3/2th power, 0.3 %; test:
  ! coupled_suite.f90.
  real(real64), parameter :: as_one = 0.05_real64

contains

  !> Opens the loaded contacts that are hidden in another one; of equals the one listed last.
  subroutine open_hidden(pairs, solution, any_opened)
    type(contact_pairs), intent(in) :: pairs           !! pairs of the position
    type(coupled_solution), intent(inout) :: solution  !! its circles are set out; penetrations then
    logical, intent(out) :: any_opened                 !! the circles must be set out again
    logical :: opens(size(solution%set%x))
    real(real64) :: over, under
    integer :: i, j, k

    opens = .false.
    any_opened = .false.
    associate (set => solution%set)
      if (.not. allocated(set%one)) return
      do k = 1, size(set%one)
        i = set%one(k)
        j = set%other(k)
        if (opens(i) .or. opens(j) .or. set%still(i) .or. set%still(j)) cycle
        over = standing_share(pairs, set, i, set%number(j))
        under = standing_share(pairs, set, j, set%number(i))
        opens(j) = over <= as_one .and. .not. under < over
        opens(i) = under <= as_one .and. .not. opens(j)
      end do
      any_opened = any(opens)
      if (any_opened) solution%penetration(pack(set%number, opens)) = far_below
    end associate
  end subroutine open_hidden

  !> Whether an open contact is hidden in one of the loaded ones.
  pure logical function is_hidden(pairs, set, near, i)
    type(contact_pairs), intent(in) :: pairs   !! pairs of the position
    type(circle_set), intent(in) :: set        !! circles of loaded contacts
    integer, intent(in) :: near(:)             !! circles near the contact
    integer, intent(in) :: i                   !! number of the pair
    integer :: k

    is_hidden = .true.
    do k = 1, size(near)
      if (set%still(near(k))) cycle
      if (standing_share(pairs, set, near(k), i) < as_one) return
    end do
    is_hidden = .false.
  end function is_hidden

  !> How far the surface of a pair stands out of a loaded one's, its host, at most, and how far from
  !> the middle of the host's circle. Paraboloids.
  pure subroutine stand_out(pairs, set, host, i, reach, height, off, slope)
    type(contact_pairs), intent(in) :: pairs    !! pairs of the position
    type(circle_set), intent(in) :: set         !! places and shifts are set
    integer, intent(in) :: host                 !! circle of the host
    integer, intent(in) :: i                    !! number of the pair
    real(real64), intent(in) :: reach           !! from the middle of the circle, at most
    real(real64), intent(out) :: height         !! below 0: it stands out nowhere
    real(real64), intent(out) :: off            !! distance from the middle
    real(real64), intent(out) :: slope          !! how fast it rises in the middle of the circle
    real(real64) :: along(2), sharper

    associate (own => pairs%list(set%number(host)), pair => pairs%list(i), &
               move => set%move(:, host))
      along = move + [own%x - pair%x, own%y - pair%y]
      ! Along its steepest line it stands out by a parabola: as far as its top, or to the end.
      sharper = 1.0_real64 / pair%radius - 1.0_real64 / own%radius
      slope = norm2(along / pair%radius - move / own%radius)
      off = reach
      if (sharper * off > slope) off = slope / sharper
      height = own%gap - pair%gap + off * (slope - 0.5_real64 * sharper * off) + &
               0.5_real64 * (dot_product(move, move) / own%radius - &
                             dot_product(along, along) / pair%radius)
    end associate
  end subroutine stand_out

  ! The same over the host's penetration, within twice its circle: farther off the surfaces part by
  ! more than it can stand out. 2 where it is much blunter, or touches first beside it.
  pure real(real64) function standing_share(pairs, set, host, i) result(share)
    type(contact_pairs), intent(in) :: pairs
    type(circle_set), intent(in) :: set
    integer, intent(in) :: host, i
    real(real64) :: off, slope

    share = 2.0_real64
    associate (own => pairs%list(set%number(host)), pair => pairs%list(i), a => set%circle(host))
      if (pair%radius < 2 * own%radius .and. norm2(set%move(:, host) + &
          [set%x(host) - pair%x, set%y(host) - pair%y]) < as_one * a) then
        call stand_out(pairs, set, host, i, 2 * a, share, off, slope)
        share = share / a**2 * own%radius
      end if
    end associate
  end function standing_share

end module asperity_hidden_contacts
