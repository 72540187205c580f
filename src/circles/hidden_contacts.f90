!> Caps that hardly protrude from the cap of another contact: they are a part of that contact.
!>
!> The potential has several minima where the top of a cap lies in the contact circle of another
!> one. It is least where one of the two carries the load: equal caps in one place are one surface.
!> Caps that protrude by less than `hidden_share` stay open; without this rule the coincident caps
!> of test/hard/test_hard_effects.py carry too much.
module asperity_hidden_contacts
  use asperity_circle_field, only: circle_set
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_state, only: coupled_solution
  use asperity_kinds, only: real64
  implicit none
  private

  public :: is_hidden, release_hidden, find_protrusion

  ! Height by which a cap stands out of the surface of a loaded one, over the penetration of that
  ! [1], up to which it stays open; chosen: its own load is below its 3/2th power, 0.3 %; test:
  ! coupled_suite.f90.
  real(real64), parameter :: hidden_share = 0.05_real64

contains

  !> Releases the loaded contacts that are hidden in another one; of equals the one listed last.
  subroutine release_hidden(pairs, solution, any_released)
    type(contact_pairs), intent(in) :: pairs           !! pairs of the position
    type(coupled_solution), intent(inout) :: solution  !! circles; gets those that stay open
    logical, intent(out) :: any_released               !! circles are those of earlier penetrations
    logical :: is_released(size(solution%set%x))
    real(real64) :: share_of_second, share_of_first
    integer :: i, j, k

    is_released = .false.
    any_released = .false.
    associate (set => solution%set)
      if (.not. allocated(set%one)) return
      do k = 1, size(set%one)
        i = set%one(k)
        j = set%other(k)
        if (is_released(i) .or. is_released(j) .or. set%shift_fixed(i) .or. &
            set%shift_fixed(j)) cycle
        share_of_second = protrusion_share(pairs, set, i, set%contact(j))
        share_of_first = protrusion_share(pairs, set, j, set%contact(i))
        is_released(j) = share_of_second <= hidden_share .and. &
          .not. share_of_first < share_of_second
        is_released(i) = share_of_first <= hidden_share .and. .not. is_released(j)
      end do
      any_released = any(is_released)
      solution%stays_open(set%contact) = is_released
      where (solution%stays_open) solution%penetration = 0.0_real64
    end associate
  end subroutine release_hidden

  !> Whether an open contact is hidden in one of the loaded ones.
  pure logical function is_hidden(pairs, set, near, i)
    type(contact_pairs), intent(in) :: pairs   !! pairs of the position
    type(circle_set), intent(in) :: set        !! circles of loaded contacts
    integer, intent(in) :: near(:)             !! circles near the contact
    integer, intent(in) :: i                   !! number of the pair
    integer :: k

    is_hidden = .true.
    do k = 1, size(near)
      if (set%shift_fixed(near(k))) cycle
      if (protrusion_share(pairs, set, near(k), i) < hidden_share) return
    end do
    is_hidden = .false.
  end function is_hidden

  !> Finds the largest height of the paraboloid of a pair above that of a loaded pair, its host, and
  !> its distance from the centre of the host's circle.
  pure subroutine find_protrusion(pairs, set, host, i, reach, height, distance, slope)
    type(contact_pairs), intent(in) :: pairs    !! pairs of the position
    type(circle_set), intent(in) :: set         !! circles with centres and shifts
    integer, intent(in) :: host                 !! circle of the host
    integer, intent(in) :: i                    !! number of the pair
    real(real64), intent(in) :: reach           !! largest distance that is searched [length]
    real(real64), intent(out) :: height         !! protrusion [length], < 0: nowhere above the host
    real(real64), intent(out) :: distance       !! distance from the middle
    real(real64), intent(out) :: slope          !! of that height at the centre of the circle
    real(real64) :: offset(2), sharper

    associate (own => pairs%list(set%contact(host)), pair => pairs%list(i), &
               shift => set%shift(:, host))
      offset = shift + [own%x - pair%x, own%y - pair%y]
      ! Along the steepest line the height is a parabola: its maximum, or the end of the reach.
      sharper = 1.0_real64 / pair%radius - 1.0_real64 / own%radius
      slope = norm2(offset / pair%radius - shift / own%radius)
      distance = reach
      if (sharper * distance > slope) distance = slope / sharper
      height = own%gap - pair%gap + distance * (slope - 0.5_real64 * sharper * distance) + &
               0.5_real64 * (dot_product(shift, shift) / own%radius - &
                             dot_product(offset, offset) / pair%radius)
    end associate
  end subroutine find_protrusion

  ! Protrusion over the host's penetration, within twice its radius: farther away the surfaces
  ! separate by more. 2 where the cap is much blunter, or touches first beside the circle.
  pure real(real64) function protrusion_share(pairs, set, host, i) result(share)
    type(contact_pairs), intent(in) :: pairs
    type(circle_set), intent(in) :: set
    integer, intent(in) :: host, i
    real(real64) :: distance, slope

    share = 2.0_real64
    associate (own => pairs%list(set%contact(host)), pair => pairs%list(i), a => set%radius(host))
      if (pair%radius < 2 * own%radius .and. norm2(set%shift(:, host) + &
          [set%x(host) - pair%x, set%y(host) - pair%y]) < hidden_share * a) then
        call find_protrusion(pairs, set, host, i, 2 * a, share, distance, slope)
        share = share / a**2 * own%radius
      end if
    end associate
  end function protrusion_share

end module asperity_hidden_contacts
