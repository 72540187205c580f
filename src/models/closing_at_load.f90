!> The compression at which the contacts with their effects carry a load.
module asperity_closing_at_load
  use asperity_closing_at_pull, only: close_to_pull, has_attraction
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_pairs, only: contact_pairs, in_scene_units
  use asperity_contact_state, only: contact_state, controlled_load, start_state
  use asperity_effect_sequence, only: choose_effects, first_failure, found_state, simulate_effects
  use asperity_hertz_law, only: hertz_law
  use asperity_interaction, only: interaction_effect
  use asperity_kinds, only: real64
  use asperity_problems, only: real_text
  use asperity_root_bracket, only: guess_root, narrow_bracket, root_bracket
  use asperity_scene_values, only: effect_auto
  implicit none
  private

  public :: close_to_load, search_load

  integer, parameter :: most_tries = 300
  real(real64), parameter :: two_thirds = 2.0_real64 / 3.0_real64
  ! A compression below this share of the largest is rounding.
  real(real64), parameter :: least_closing = 1.0e-18_real64
  ! Relative error of a load: the solvers of effects converge to less, and a state with a larger
  ! one is refused.
  real(real64), parameter :: least_error = 1.0e-11_real64, largest_error = 1.0e-7_real64

contains

  !> Finds the compression at which the contacts carry a load at a time.
  !>
  !> The load grows with the compression: bracketed root search for load**(2/3), to the tolerance of
  !> the effects. Without a load: the largest compression without one. Where contacts attract each
  !> other, a load of 0 or less, or below that of the last state, is found on unloading.
  !>
  !> Where `auto` begins or ends to simulate an effect the load jumps. A load within the jump is
  !> carried with the effect, whose estimate equals its tolerance there; `called_for` is then set.
  subroutine close_to_load(pairs, effects, target, time, found, failure)
    type(contact_pairs), intent(in) :: pairs       !! pairs of the position
    type(effect_box), intent(in) :: effects(:)     !! effects; those in time act in `there` only
    real(real64), intent(in) :: target             !! load, < 0 for tension
    real(real64), intent(in) :: time               !! time since the begin of loading, 0 or more
    type(found_state), intent(inout) :: found      !! a guess of the compression; the state found
    character(len=:), allocatable, intent(out) :: failure   !! reason, when the load is not carried
    logical :: jumps, unloads
    integer :: i

    if (allocated(found%called_for)) deallocate (found%called_for)
    if (allocated(found%found)) deallocate (found%found)
    ! No effect that acts in time goes together with attraction.
    if (.not. time > 0.0_real64 .and. has_attraction(pairs, effects)) then
      unloads = .not. target > 0.0_real64
      if (.not. unloads) then
        call simulate_effects(pairs, effects, time, found, .true.)
        unloads = controlled_load(pairs, found%state) > target
      end if
      if (unloads) call close_to_pull(pairs, effects, target, found, failure)
      if (unloads) return
    end if
    call search_load(pairs, effects, target, time, found, jumps, failure)
    if (.not. jumps) return
    ! The last state is just past the jump.
    allocate (found%called_for(size(found%outcomes)))
    do i = 1, size(found%outcomes)
      found%called_for(i) = found%outcomes(i)%simulated /= 'off'
    end do
    deallocate (failure)
    call search_load(pairs, effects, target, time, found, jumps, failure)
  end subroutine close_to_load

  !> Finds the compression at which the contacts carry a compressive load on loading, by a bracketed
  !> root search. It ends when the load is met to the tolerance of the effects; when no number is
  !> left within the bracket the upper end is used, if its load is accurate enough.
  subroutine search_load(pairs, effects, target, time, found, jumps, failure)
    type(contact_pairs), intent(in) :: pairs       !! pairs of the position
    type(effect_box), intent(in) :: effects(:)     !! effects; those in time act in `there` only
    real(real64), intent(in) :: target             !! load, 0 or more
    real(real64), intent(in) :: time               !! time since the begin of loading, 0 or more
    type(found_state), intent(inout) :: found      !! a guess, `called_for`; the state found
    logical, intent(out) :: jumps                  !! whether the load jumps past the target
    character(len=:), allocatable, intent(out) :: failure   !! reason, when the load is not carried
    type(root_bracket) :: bracket
    real(real64) :: load, residual, nothing, greatest
    logical :: enough, inside
    integer :: i, try

    jumps = .false.
    bracket = root_bracket(low=0.0_real64, high=minval(pairs%list%gap + pairs%list%zc), &
                           low_miss=-1.0_real64, high_miss=-1.0_real64, halving=4)
    enough = .false.
    greatest = 0.0_real64
    call guess_closing(pairs, effects, target, time, bracket%high, found, failure)
    if (allocated(failure)) return
    nothing = least_closing * minval(pairs%list%gap + pairs%list%radius)
    do try = 1, most_tries
      call simulate_effects(pairs, effects, time, found, .not. time > 0.0_real64)
      load = controlled_load(pairs, found%state)
      call first_failure(effects, found%outcomes, failure)
      if (allocated(failure)) return
      if (target > 0.0_real64) then
        if (abs(load - target) <= target * &
            min(max(least_error, maxval(found%outcomes%load_jump)), largest_error)) return
      end if
      ! Results of the search of an effect are valid at its compression only.
      if (allocated(found%found)) deallocate (found%found)
      greatest = max(greatest, load)
      residual = merge(1.0_real64, -1.0_real64, load > 0.0_real64)
      if (target > 0.0_real64) residual = (max(load, 0.0_real64) / target)**two_thirds - 1.0_real64
      call narrow_bracket(bracket, found%closing, residual, residual < 0.0_real64)
      enough = enough .or. .not. residual < 0.0_real64
      if (.not. target > 0.0_real64 .and. bracket%high < nothing) exit
      call guess_root(bracket, found%closing, inside)
      if (.not. inside) exit
      ! Without an upper end yet the compression is doubled at most.
      if (.not. enough .and. bracket%low > 0.0_real64) found%closing = &
        min(found%closing, bracket%low * (1.0_real64 + min(1.0_real64, -2.0_real64 * residual)))
    end do
    found%closing = bracket%low
    if (bracket%high < nothing) found%closing = 0.0_real64
    if (.not. target > 0.0_real64) return
    if (.not. enough) then
      failure = 'the load is larger than the surfaces carry before the centres of two ' // &
                'asperities are level: ' // real_text(in_scene_units(pairs, greatest, 1, 2)) // &
                ' at most'
      return
    end if
    found%closing = bracket%high
    call simulate_effects(pairs, effects, time, found, .not. time > 0.0_real64)
    call first_failure(effects, found%outcomes, failure)
    if (allocated(failure)) return
    if (abs(controlled_load(pairs, found%state) - target) <= largest_error * target) return
    failure = 'the load is not reached: with the effects it jumps past it'
    jumps = .not. allocated(found%called_for) .and. &
            any([(effects(i)%effect%mode == effect_auto, i=1, size(effects))])
  end subroutine search_load

  ! First compression of a search: that of the effects that can estimate it, else the given one, but
  ! no less than a thousandth of that of Hertz.
  subroutine guess_closing(pairs, effects, target, time, most, found, failure)
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(in) :: effects(:)
    real(real64), intent(in) :: target, time, most  ! most: largest compression
    type(found_state), intent(inout) :: found
    character(len=:), allocatable, intent(inout) :: failure
    real(real64) :: guessed

    if (allocated(found%found)) deallocate (found%found)
    if (target > 0.0_real64) &
      call ask_effects(pairs, effects, target / share_held(effects, time), time, found, failure)
    if (allocated(failure)) then
      if (pairs%interrupt%is_asked()) return
      ! The bracketed search finds the load, or the largest one, from compressions.
      deallocate (failure)
      if (allocated(found%found)) deallocate (found%found)
    end if
    guessed = found%closing
    if (target > 0.0_real64 .and. pairs%target > 0.0_real64) found%closing = &
      max(found%closing, 1.0e-3_real64 * pairs%closing * (target / pairs%target)**two_thirds)
    found%closing = min(max(found%closing, 0.0_real64), most * (1.0_real64 - epsilon(1.0_real64)))
    if (abs(found%closing - guessed) > 0.0_real64 .and. allocated(found%found)) &
      deallocate (found%found)
  end subroutine guess_closing

  ! Sets the compression to that of interaction, which has a search of its own for a load.
  subroutine ask_effects(pairs, effects, target, time, found, failure)
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(in) :: effects(:)
    real(real64), intent(in) :: target, time
    type(found_state), intent(inout) :: found
    character(len=:), allocatable, intent(inout) :: failure
    type(contact_state) :: state
    type(effect_outcome) :: outcomes(size(effects))
    logical, allocatable :: called(:)
    real(real64) :: left
    integer :: i

    call start_state(pairs, hertz_law(modulus=pairs%modulus), found%closing, state)
    state%time = time
    call choose_effects(pairs, effects, state, outcomes, called, left)
    do i = 1, size(effects)
      if (allocated(found%called_for) .and. effects(i)%effect%mode == effect_auto) &
        called(i) = found%called_for(i)
      if (.not. called(i)) cycle
      select type (effect => effects(i)%effect)
      type is (interaction_effect)
        call effect%solve_together(pairs, hertz_law(modulus=pairs%modulus), left, found%closing, &
                                   found%found, failure, target)
        if (allocated(failure)) failure = 'interaction: ' // failure
      end select
      if (allocated(failure)) return
    end do
  end subroutine ask_effects

  ! Ratio of the load at a time to that at the same compression on loading.
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
