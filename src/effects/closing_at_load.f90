!> The closing at which the contacts with their effects carry a load.
module asperity_closing_at_load
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state, total_load
  use asperity_effect_sequence, only: simulate
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_scene_values, only: effect_auto
  implicit none
  private

  public :: close_to_load

  integer, parameter :: most_tries = 60

contains

  !> Sets `pairs%closing`, which comes in as that of independent contacts. The load grows with the
  !> closing, nearly as its power 3/2 or faster: false position on load**(2/3), until the load is
  !> met as closely as the effects can meet it.
  subroutine close_to_load(pairs, effects, failure)
    type(contact_pairs), intent(inout) :: pairs                !! with `target` and `closing`
    type(effect_box), intent(in) :: effects(:)                 !! of the scene
    character(len=:), allocatable, intent(out) :: failure      !! why not
    type(contact_state) :: state
    type(effect_outcome), allocatable :: outcomes(:)
    real(real64) :: closing, most, tolerance, low, high, low_miss, high_miss, load, miss
    logical :: has_auto
    integer :: i, try

    closing = pairs%closing
    tolerance = 1.0e-11_real64
    has_auto = .false.
    do i = 1, size(effects)
      tolerance = max(tolerance, effects(i)%effect%load_tolerance)
      has_auto = has_auto .or. effects(i)%effect%mode == effect_auto
      if (.not. associated(effects(i)%effect%closing_at_load)) cycle
      call effects(i)%effect%closing_at_load(pairs, hertz_law(modulus=pairs%modulus), &
                                             pairs%target, closing, failure)
      if (allocated(failure)) return
    end do
    most = minval(pairs%list%gap + pairs%list%zc)
    low = 0.0_real64
    low_miss = -1.0_real64
    high = most
    high_miss = huge(1.0_real64)
    do try = 1, most_tries
      call simulate(pairs, effects, closing, state, outcomes)
      do i = 1, size(effects)
        if (.not. allocated(outcomes(i)%failure)) cycle
        failure = trim(effects(i)%effect%name) // ': ' // outcomes(i)%failure
        return
      end do
      load = total_load(state)
      pairs%closing = closing
      if (abs(load - pairs%target) <= tolerance * pairs%target) return
      miss = (load / pairs%target)**(2.0_real64 / 3.0_real64) - 1.0_real64
      if (miss < 0.0_real64) then
        low = closing
        low_miss = miss
      else
        high = closing
        high_miss = miss
      end if
      if (high_miss < huge(1.0_real64) .and. modulo(try, 4) > 0) then
        closing = low - (high - low) * (low_miss / (high_miss - low_miss))
      else if (high_miss < huge(1.0_real64)) then
        closing = low + (high - low) / 2
      else
        closing = min(low * (1.0_real64 - 1.5_real64 * low_miss), low + (most - low) / 2)
      end if
      if (.not. (closing > low .and. closing < high)) exit
    end do
    if (has_auto) then
      do i = 1, size(effects)
        tolerance = max(tolerance, effects(i)%effect%tolerance)
      end do
      if (abs(load - pairs%target) <= tolerance * pairs%target) return
    end if
    failure = 'the load is not reached: with the effects it jumps, or is more than the ' // &
              'surfaces can bear before the centres of two asperities are level'
  end subroutine close_to_load

end module asperity_closing_at_load
