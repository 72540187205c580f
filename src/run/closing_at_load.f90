!> The closing at which the contacts with their effects carry a load.
module asperity_closing_at_load
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state, total_load
  use asperity_effect_sequence, only: first_failure, simulate
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_root_bracket_real64, only: guess_root, narrow_bracket, root_bracket
  use asperity_scene_values, only: effect_auto
  implicit none
  private

  public :: close_to_load

  integer, parameter :: most_tries = 300
  real(real64), parameter :: two_thirds = 2.0_real64 / 3.0_real64
  ! A closing below this share of the largest is none.
  real(real64), parameter :: least_closing = 1.0e-18_real64

contains

  !> Finds the closing at which the sum of the normal forces is a load. Load grows with closing: a
  !> bracket of load**(2/3), until the load is met as closely as the effects can meet it. For no
  !> load at all: the largest closing without.
  subroutine close_to_load(pairs, effects, target, closing, state, outcomes, failure)
    type(contact_pairs), intent(in) :: pairs                !! the position
    type(effect_box), intent(in) :: effects(:)              !! those that act in time do not here
    real(real64), intent(in) :: target                      !! 0 or more
    real(real64), intent(inout) :: closing                  !! a guess, then the closing
    type(contact_state), intent(out) :: state               !! the last one that was simulated
    type(effect_outcome), allocatable, intent(out) :: outcomes(:)  !! what the effects did in it
    character(len=:), allocatable, intent(out) :: failure   !! why not
    type(root_bracket) :: bracket
    real(real64), allocatable :: found(:, :)
    real(real64) :: load, miss, nothing, asked
    logical :: enough, inside
    integer :: try

    bracket = root_bracket(low=0.0_real64, high=minval(pairs%list%gap + pairs%list%zc), &
                           low_miss=-1.0_real64, high_miss=-1.0_real64, halving=4)
    enough = .false.
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
      miss = merge(1.0_real64, -1.0_real64, load > 0.0_real64)
      if (target > 0.0_real64) miss = (max(load, 0.0_real64) / target)**two_thirds - 1.0_real64
      call narrow_bracket(bracket, closing, miss, miss < 0.0_real64)
      enough = enough .or. .not. miss < 0.0_real64
      if (.not. target > 0.0_real64 .and. bracket%high < nothing) exit
      call guess_root(bracket, closing, inside)
      if (.not. inside) exit
      ! Not high enough yet: up to twice the closing.
      if (.not. enough .and. bracket%low > 0.0_real64) &
        closing = min(closing, bracket%low * (1.0_real64 + min(1.0_real64, -2.0_real64 * miss)))
    end do
    closing = bracket%low
    if (bracket%high < nothing) closing = 0.0_real64
    if (.not. target > 0.0_real64) return
    if (enough) closing = bracket%high
    if (abs(load - target) <= jump_allowed(effects, outcomes) * target) return
    if (enough) then
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
