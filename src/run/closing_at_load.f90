!> The closing at which the contacts with their effects carry a load.
module asperity_closing_at_load
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state, total_load
  use asperity_effect_sequence, only: first_failure, simulate
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_scene_values, only: effect_auto
  implicit none
  private

  public :: close_to_load

  integer, parameter :: most_tries = 300
  real(real64), parameter :: two_thirds = 2.0_real64 / 3.0_real64
  ! A closing below this share of the largest is none.
  real(real64), parameter :: least_closing = 1.0e-18_real64

  !> Two closings between which the load is met, and how far each is off.
  type :: load_bracket
    real(real64) :: low = 0.0_real64, high = 0.0_real64
    real(real64) :: low_miss = -1.0_real64, high_miss = huge(1.0_real64)
    integer :: side = 0  ! which end moved last
  end type load_bracket

contains

  !> Finds the closing at which the sum of the normal forces is a load. Load grows with closing: a
  !> bracket that never opens, false position on load**(2/3), until the load is met as closely as
  !> the effects can meet it. For no load at all: the largest closing without.
  subroutine close_to_load(pairs, effects, target, closing, state, outcomes, failure)
    type(contact_pairs), intent(in) :: pairs                !! the position
    type(effect_box), intent(in) :: effects(:)              !! those that act in time do not here
    real(real64), intent(in) :: target                      !! 0 or more
    real(real64), intent(inout) :: closing                  !! a guess, then the closing
    type(contact_state), intent(out) :: state               !! the last one that was simulated
    type(effect_outcome), allocatable, intent(out) :: outcomes(:)  !! what the effects did in it
    character(len=:), allocatable, intent(out) :: failure   !! why not
    type(load_bracket) :: bracket
    real(real64), allocatable :: found(:, :)
    real(real64) :: load, nothing, asked
    integer :: try

    bracket%high = minval(pairs%list%gap + pairs%list%zc)
    if (target > 0.0_real64) call ask_effects(pairs, effects, target, closing, found, failure)
    if (allocated(failure)) return
    asked = closing
    if (target > 0.0_real64 .and. pairs%target > 0.0_real64) &
      closing = max(closing, 1.0e-3_real64 * pairs%closing * (target / pairs%target)**two_thirds)
    closing = min(max(closing, 0.0_real64), bracket%high * (1.0_real64 - epsilon(1.0_real64)))
    nothing = bracket%high * least_closing
    if (abs(closing - asked) > 0.0_real64 .and. allocated(found)) deallocate (found)
    do try = 1, most_tries
      call simulate(pairs, effects, closing, 0.0_real64, state, outcomes, .true., found)
      if (allocated(found)) deallocate (found)
      call first_failure(effects, outcomes, failure)
      if (allocated(failure)) return
      load = total_load(state)
      if (target > 0.0_real64) then
        if (abs(load - target) <= load_tolerance(effects, outcomes) * target) return
      end if
      call narrow(bracket, closing, load, target)
      if (.not. target > 0.0_real64 .and. bracket%high < nothing) exit
      closing = next_guess(bracket, try)
      if (.not. (closing > bracket%low .and. closing < bracket%high)) exit
    end do
    closing = bracket%low
    if (bracket%high < nothing) closing = 0.0_real64
    if (.not. target > 0.0_real64) return
    if (bracket%high_miss < huge(1.0_real64)) closing = bracket%high
    if (abs(load - target) <= jump_allowed(effects, outcomes) * target) return
    if (bracket%high_miss < huge(1.0_real64)) then
      failure = 'the load is not reached: with the effects it jumps past it'
    else
      failure = 'the load is more than the surfaces can bear before the centres of two ' // &
                'asperities are level'
    end if
  end subroutine close_to_load

  ! Where the effects that know it say that the load is reached.
  subroutine ask_effects(pairs, effects, target, closing, found, failure)
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(in) :: effects(:)
    real(real64), intent(in) :: target
    real(real64), intent(inout) :: closing
    real(real64), allocatable, intent(inout) :: found(:, :)
    character(len=:), allocatable, intent(inout) :: failure
    integer :: i

    do i = 1, size(effects)
      call effects(i)%effect%closing_at_load(pairs, hertz_law(modulus=pairs%modulus), target, &
                                             closing, found, failure)
      if (allocated(failure)) return
    end do
  end subroutine ask_effects

  ! Moves the end of the bracket on whose side the load is. An end that stays twice counts half as
  ! far off (Illinois), so that both ends move.
  subroutine narrow(bracket, closing, load, target)
    type(load_bracket), intent(inout) :: bracket
    real(real64), intent(in) :: closing, load, target
    real(real64) :: miss

    if (target > 0.0_real64) then
      miss = (max(load, 0.0_real64) / target)**two_thirds - 1.0_real64
    else
      miss = merge(1.0_real64, -1.0_real64, load > 0.0_real64)
    end if
    if (miss < 0.0_real64) then
      bracket%low = closing
      bracket%low_miss = miss
      if (bracket%side < 0 .and. bracket%high_miss < huge(1.0_real64)) &
        bracket%high_miss = 0.5_real64 * bracket%high_miss
      bracket%side = -1
    else
      bracket%high = closing
      bracket%high_miss = miss
      if (bracket%side > 0) bracket%low_miss = 0.5_real64 * bracket%low_miss
      bracket%side = 1
    end if
  end subroutine narrow

  ! A closing inside the bracket, unless no number lies between its ends.
  pure real(real64) function next_guess(bracket, try) result(guess)
    type(load_bracket), intent(in) :: bracket
    integer, intent(in) :: try

    associate (low => bracket%low, high => bracket%high)
      guess = low + 0.5_real64 * (high - low)
      if (bracket%high_miss < huge(1.0_real64)) then
        if (modulo(try, 4) > 0) &
          guess = low - (high - low) * (bracket%low_miss / (bracket%high_miss - bracket%low_miss))
        if (.not. (guess > low .and. guess < high)) guess = low + 0.5_real64 * (high - low)
      else if (low > 0.0_real64) then
        ! Not high enough yet: up to twice the closing.
        guess = min(guess, low * (1.0_real64 + min(1.0_real64, -2.0_real64 * bracket%low_miss)))
      end if
    end associate
  end function next_guess

  ! How near a load can be met by the effects that are simulated.
  pure real(real64) function load_tolerance(effects, outcomes) result(tolerance)
    type(effect_box), intent(in) :: effects(:)
    type(effect_outcome), intent(in) :: outcomes(:)
    integer :: i

    tolerance = 1.0e-11_real64
    do i = 1, size(effects)
      if (outcomes(i)%simulated /= 'off') &
        tolerance = max(tolerance, effects(i)%effect%load_tolerance)
    end do
  end function load_tolerance

  ! Where `auto` begins to simulate an effect, the load jumps by up to its tolerance.
  pure real(real64) function jump_allowed(effects, outcomes) result(tolerance)
    type(effect_box), intent(in) :: effects(:)
    type(effect_outcome), intent(in) :: outcomes(:)
    integer :: i

    tolerance = load_tolerance(effects, outcomes)
    do i = 1, size(effects)
      associate (effect => effects(i)%effect)
        if (effect%mode /= effect_auto .or. effect%acts_in_time) cycle
        tolerance = max(tolerance, effect%tolerance, effect%load_tolerance)
      end associate
    end do
  end function jump_allowed

end module asperity_closing_at_load
