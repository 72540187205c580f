!> The closing at which the contacts with their effects carry a load.
module asperity_closing_at_load
  use asperity_closing_at_pull, only: close_to_pull, pulls
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_pairs, only: contact_pairs, in_scene_units
  use asperity_contact_state, only: contact_state, load_asked_for, start_state
  use asperity_effect_choice, only: choose_effects
  use asperity_effect_sequence, only: first_failure, simulate
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_problems, only: real_text
  use asperity_root_bracket_real64, only: guess_root, narrow_bracket, root_bracket
  use asperity_scene_values, only: effect_auto
  implicit none
  private

  public :: close_to_load, search_load

  integer, parameter :: most_tries = 300
  real(real64), parameter :: two_thirds = 2.0_real64 / 3.0_real64
  ! A closing below this share of the largest is none.
  real(real64), parameter :: least_closing = 1.0e-18_real64
  ! No load is met worse than this: the driver would refuse the state.
  real(real64), parameter :: precision = 1.0e-7_real64

contains

  !> Finds the closing at which the load asked for is borne at a time. Load grows with closing: a
  !> bracket of load**(2/3), until the load is met as closely as the effects can meet it. For no
  !> load at all: the largest closing without. Where contacts attract each other a load that is
  !> less than that of the state before, or 0 or less, is looked for on the way back.
  !>
  !> Where `auto` begins or ends to simulate an effect the load jumps; a load within the jump is
  !> carried with the effect, whose estimate equals its tolerance there; `called_for` is then true.
  subroutine close_to_load(pairs, effects, target, time, closing, state, outcomes, called_for, &
                           found, failure)
    type(contact_pairs), intent(in) :: pairs                !! the position
    type(effect_box), intent(in) :: effects(:)              !! those that act in time only in it
    real(real64), intent(in) :: target                      !! below 0: a pull
    real(real64), intent(in) :: time                        !! since the end of loading
    real(real64), intent(inout) :: closing                  !! a guess, then the closing
    type(contact_state), intent(out) :: state               !! the last one that was simulated
    type(effect_outcome), allocatable, intent(out) :: outcomes(:)  !! what the effects did in it
    logical, allocatable, intent(out) :: called_for(:)      !! by effect; or not allocated
    !> What an effect that knows a way to a load found there, for who simulates the state again; not
    !> allocated: nothing.
    real(real64), allocatable, intent(out) :: found(:, :)
    character(len=:), allocatable, intent(out) :: failure   !! why not
    logical :: jumps
    integer :: i

    if (pulls(pairs, effects)) then
      if (goes_back()) then
        call close_to_pull(pairs, effects, target, closing, state, outcomes, failure)
        return
      end if
    end if
    call search_load(pairs, effects, target, time, closing, state, outcomes, called_for, jumps, &
                     found, failure)
    if (.not. jumps) return
    ! The last state is just past the jump.
    allocate (called_for(size(outcomes)))
    do i = 1, size(outcomes)
      called_for(i) = outcomes(i)%simulated /= 'off'
    end do
    deallocate (failure)
    call search_load(pairs, effects, target, time, closing, state, outcomes, called_for, jumps, &
                     found, failure)

  contains

    ! Whether the load is reached by opening.
    logical function goes_back()
      goes_back = .true.
      if (.not. target > 0.0_real64) return
      call simulate(pairs, effects, closing, time, state, outcomes, .true.)
      goes_back = load_asked_for(pairs, state) > target
    end function goes_back

  end subroutine close_to_load

  !> The same for a load that presses, reached by closing.
  subroutine search_load(pairs, effects, target, time, closing, state, outcomes, called_for, &
                         jumps, found, failure)
    type(contact_pairs), intent(in) :: pairs                !! the position
    type(effect_box), intent(in) :: effects(:)              !! those that act in time only in it
    real(real64), intent(in) :: target                      !! load asked for
    real(real64), intent(in) :: time                        !! since the end of loading
    real(real64), intent(inout) :: closing                  !! a guess, then the closing
    type(contact_state), intent(out) :: state               !! the last one that was simulated
    type(effect_outcome), allocatable, intent(out) :: outcomes(:)  !! what the effects did in it
    !> of `auto`, which to simulate; not allocated: those that it calls for
    logical, allocatable, intent(in) :: called_for(:)
    logical, intent(out) :: jumps                           !! simulated effects change at the load
    real(real64), allocatable, intent(out) :: found(:, :)   !! as of `close_to_load`
    character(len=:), allocatable, intent(out) :: failure   !! why not
    type(root_bracket) :: bracket
    real(real64) :: load, miss, nothing, asked, greatest
    logical :: enough, inside
    integer :: try

    jumps = .false.
    bracket = root_bracket(low=0.0_real64, high=minval(pairs%list%gap + pairs%list%zc), &
                           low_miss=-1.0_real64, high_miss=-1.0_real64, halving=4)
    enough = .false.
    greatest = 0.0_real64
    if (target > 0.0_real64) &
      call ask_effects(pairs, effects, target / share_held(effects, time), time, called_for, &
                       closing, found, failure)
    if (allocated(failure)) return
    asked = closing
    if (target > 0.0_real64 .and. pairs%target > 0.0_real64) &
      closing = max(closing, 1.0e-3_real64 * pairs%closing * (target / pairs%target)**two_thirds)
    closing = min(max(closing, 0.0_real64), bracket%high * (1.0_real64 - epsilon(1.0_real64)))
    nothing = least_closing * minval(pairs%list%gap + pairs%list%radius)
    if (abs(closing - asked) > 0.0_real64 .and. allocated(found)) deallocate (found)
    do try = 1, most_tries
      call simulate_at(closing, found)
      load = load_asked_for(pairs, state)
      call first_failure(effects, outcomes, failure)
      if (allocated(failure)) then
        ! Less closing than a hold has had is not covered by its theory, but is not the end either.
        if (.not. (time > 0.0_real64 .and. load < target)) return
        if (load >= target * (1.0_real64 - precision)) return
        deallocate (failure)
      end if
      if (target > 0.0_real64) then
        if (abs(load - target) <= load_tolerance(effects, outcomes) * target) return
      end if
      ! It was found at that closing alone.
      if (allocated(found)) deallocate (found)
      greatest = max(greatest, load)
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
    if (.not. enough) then
      failure = 'the load is larger than the surfaces carry before the centres of two ' // &
                'asperities are level: ' // real_text(in_scene_units(pairs, greatest, 1, 2)) // &
                ' at most'
      return
    end if
    closing = bracket%high
    call simulate_at(closing, found)
    if (abs(load_asked_for(pairs, state) - target) <= precision * target) return
    failure = 'the load is not reached: with the effects it jumps past it'
    jumps = .not. allocated(called_for) .and. any(effect_modes() == effect_auto)

  contains

    subroutine simulate_at(at, found_there)
      real(real64), intent(in) :: at
      real(real64), allocatable, intent(in) :: found_there(:, :)

      ! What is not allocated is not there.
      call simulate(pairs, effects, at, time, state, outcomes, .not. time > 0.0_real64, &
                    found_there, called_for)
    end subroutine simulate_at

    function effect_modes() result(modes)
      integer :: modes(size(effects))
      integer :: i

      modes = [(effects(i)%effect%mode, i=1, size(effects))]
    end function effect_modes

  end subroutine search_load

  ! Where the effects that know it say that the load is reached.
  subroutine ask_effects(pairs, effects, target, time, called_for, closing, found, failure)
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(in) :: effects(:)
    real(real64), intent(in) :: target, time
    logical, allocatable, intent(in) :: called_for(:)
    real(real64), intent(inout) :: closing
    real(real64), allocatable, intent(inout) :: found(:, :)
    character(len=:), allocatable, intent(inout) :: failure
    type(contact_state) :: state
    type(effect_outcome) :: outcomes(size(effects))
    logical, allocatable :: called(:)
    real(real64) :: left
    integer :: i

    call start_state(pairs, hertz_law(modulus=pairs%modulus), closing, state)
    state%time = time
    call choose_effects(pairs, effects, state, outcomes, called, left)
    do i = 1, size(effects)
      if (allocated(called_for) .and. effects(i)%effect%mode == effect_auto) &
        called(i) = called_for(i)
      if (.not. called(i)) cycle
      call effects(i)%effect%closing_at_load(pairs, hertz_law(modulus=pairs%modulus), target, &
                                             left, closing, found, failure)
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
    tolerance = min(tolerance, precision)
  end function load_tolerance

  ! What is left of a load at a time, over that of the same closing while loading.
  real(real64) function share_held(effects, time) result(share)
    type(effect_box), intent(in) :: effects(:)
    real(real64), intent(in) :: time
    integer :: i

    share = 1.0_real64
    if (.not. time > 0.0_real64) return
    do i = 1, size(effects)
      share = share * effects(i)%effect%held_share(time)
    end do
  end function share_held

end module asperity_closing_at_load
