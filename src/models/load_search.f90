!> The compression at which the contacts with their effects carry a load.
module asperity_load_search
  use asperity_adhesion, only: adhesion_effect
  use asperity_pull_off_search, only: unload_to_load
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_pairs, only: contact_pairs, in_scene_units
  use asperity_contact_state, only: contact_state, controlled_load, load_rounding, start_state
  use asperity_effect_sequence, only: choose_effects, first_failure, found_state, &
                                      simulate_effects
  use asperity_hertz_law, only: hertz_law
  use asperity_interaction, only: interaction_effect
  use asperity_kinds, only: real64
  use asperity_problems, only: real_text
  use asperity_root_bracket, only: guess_by_secant, narrow_bracket, root_bracket
  use asperity_scene_values, only: effect_auto
  implicit none
  private

  public :: compress_to_load, search_load

  integer, parameter :: most_tries = 300
  real(real64), parameter :: two_thirds = 2.0_real64 / 3.0_real64
  ! A compression below this share of the largest is rounding.
  real(real64), parameter :: least_compression = 1.0e-18_real64
  ! Relative error of a load: the solvers of effects converge to less, and a state with a larger
  ! one is refused.
  real(real64), parameter :: least_error = 1.0e-11_real64, largest_error = 1.0e-7_real64

contains

  !> Finds the compression at which the contacts carry a load at a time.
  !>
  !> The load grows with the compression: `search_load`, to the tolerance of the effects. Without a
  !> load: the largest compression without one. Where contacts attract each other, a load of 0 or
  !> less, or below that of the last state, is found on unloading.
  !>
  !> Where `auto` begins or ends to simulate an effect the load jumps. A load within the jump is
  !> carried with the effect, whose estimate equals its tolerance there; `fixed_choice` is then set.
  subroutine compress_to_load(pairs, effects, target, time, found, failure)
    type(contact_pairs), intent(in) :: pairs       !! pairs of the position
    type(effect_box), intent(in) :: effects(:)     !! effects; those in time act in `there` only
    real(real64), intent(in) :: target             !! load, < 0 for tension
    real(real64), intent(in) :: time               !! time since the begin of loading, 0 or more
    type(found_state), intent(inout) :: found      !! a guess of the compression; the state found
    character(len=:), allocatable, intent(out) :: failure   !! reason, when the load is not carried
    type(contact_state) :: state
    logical :: jumps, unloads
    integer :: e, i

    if (allocated(found%fixed_choice)) deallocate (found%fixed_choice)
    if (allocated(found%solution)) deallocate (found%solution)
    ! No effect that acts in time goes together with attraction.
    e = merge(0, attracting_effect(effects), time > 0.0_real64)
    ! Adhesion that `auto` leaves out at the guess does not pull.
    if (e > 0 .and. target > 0.0_real64 .and. .not. is_at_compression(found)) then
      call start_state(pairs, hertz_law(modulus=pairs%modulus), found%compression, state)
      state%time = time
      call choose_effects(pairs, effects, state, found%choice)
      if (.not. found%choice%is_simulated(e)) e = 0
    end if
    if (e > 0) then
      unloads = .not. target > 0.0_real64
      if (.not. unloads) then
        if (.not. is_at_compression(found)) &
          call simulate_effects(pairs, effects, time, found, .true.)
        unloads = controlled_load(pairs, found%state) > target
      end if
      if (unloads) then
        select type (adhesion => effects(e)%effect)
        type is (adhesion_effect)
          call unload_to_load(pairs, adhesion, target, found%compression, failure)
        end select
        if (.not. allocated(failure)) call simulate_effects(pairs, effects, time, found, .true.)
        if (.not. allocated(failure)) call first_failure(effects, found%outcomes, failure)
        ! Where `auto` leaves adhesion out the load is that of loading.
        if (allocated(failure)) return
        if (found%outcomes(e)%simulated /= 'off') return
      end if
    end if
    call search_load(pairs, effects, target, time, found, jumps, failure)
    if (jumps .and. any([(effects(i)%effect%mode == effect_auto, i=1, size(effects))])) then
      ! The last state is just past the jump.
      allocate (found%fixed_choice(size(found%outcomes)))
      do i = 1, size(found%outcomes)
        found%fixed_choice(i) = found%outcomes(i)%simulated /= 'off'
      end do
      deallocate (failure)
      call search_load(pairs, effects, target, time, found, jumps, failure)
    end if
    if (jumps) call search_interacting_load(pairs, effects, target, time, found, failure)
  end subroutine compress_to_load

  ! Place of an effect that makes contacts attract each other; 0: there is none.
  integer function attracting_effect(effects) result(e)
    type(effect_box), intent(in) :: effects(:)

    do e = size(effects), 1, -1
      select type (effect => effects(e)%effect)
      type is (adhesion_effect)
        if (effect%work > 0.0_real64) return
      end select
    end do
  end function attracting_effect

  !> Finds the compression at which the contacts carry a compressive load on loading: safeguarded
  !> secant method for (load/target)**(2/3), from the tangent at the last state. It ends when the
  !> load is met to the tolerance of the effects; when no number is left within the bracket the
  !> upper end is used, if its load is accurate enough. A load that is small beside the forces of
  !> which it is the difference is accurate to its rounding error: a load that is continuous changes
  !> by no more between neighbouring numbers.
  recursive subroutine search_load(pairs, effects, target, time, found, jumps, failure)
    type(contact_pairs), intent(in) :: pairs       !! pairs of the position
    type(effect_box), intent(in) :: effects(:)     !! effects; those in time act in `there` only
    real(real64), intent(in) :: target             !! load, 0 or more
    real(real64), intent(in) :: time               !! time since the begin of loading, 0 or more
    type(found_state), intent(inout) :: found      !! a guess, `fixed_choice`; the state found
    logical, intent(out) :: jumps                  !! whether the load jumps past the target
    character(len=:), allocatable, intent(out) :: failure   !! reason, when the load is not carried
    type(root_bracket) :: bracket
    real(real64) :: load, residual, nothing, greatest
    logical :: enough, inside
    integer :: try

    jumps = .false.
    bracket = root_bracket(low=0.0_real64, high=minval(pairs%list%gap + pairs%list%zc), &
                           low_miss=-1.0_real64, high_miss=-1.0_real64, halving=4)
    enough = .false.
    greatest = 0.0_real64
    call guess_compression(pairs, effects, target, time, bracket%high, found, failure)
    if (allocated(failure)) return
    nothing = least_compression * minval(pairs%list%gap + pairs%list%radius)
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
      if (allocated(found%solution)) deallocate (found%solution)
      greatest = max(greatest, load)
      residual = merge(1.0_real64, -1.0_real64, load > 0.0_real64)
      if (target > 0.0_real64) residual = (max(load, 0.0_real64) / target)**two_thirds - 1.0_real64
      call narrow_bracket(bracket, found%compression, residual, residual < 0.0_real64)
      enough = enough .or. .not. residual < 0.0_real64
      if (.not. target > 0.0_real64 .and. bracket%high < nothing) exit
      call guess_by_secant(bracket, residual_slope(found%state, load, residual), &
                           found%compression, inside)
      if (.not. inside) exit
      ! Without an upper end yet the compression is doubled at most.
      if (.not. enough .and. bracket%low > 0.0_real64) found%compression = &
        min(found%compression, bracket%low * (1.0_real64 + min(1.0_real64, -2.0_real64 * residual)))
      ! Contacts that attract have a load below 0 up to a compression that is no rounding.
      if (.not. (enough .or. load > 0.0_real64)) &
        found%compression = max(found%compression, nothing)
    end do
    found%compression = bracket%low
    if (bracket%high < nothing) found%compression = 0.0_real64
    if (.not. target > 0.0_real64) return
    if (.not. enough) then
      failure = 'the load is larger than the surfaces carry before the centres of two ' // &
                'asperities are level: ' // real_text(in_scene_units(pairs, greatest, 1, 2)) // &
                ' at most'
      return
    end if
    found%compression = bracket%high
    call simulate_effects(pairs, effects, time, found, .not. time > 0.0_real64)
    call first_failure(effects, found%outcomes, failure)
    if (allocated(failure)) return
    if (abs(controlled_load(pairs, found%state) - target) <= &
        max(largest_error * target, load_rounding(found%state))) return
    failure = 'the load is not reached: with the effects it jumps past it'
    jumps = .true.
  end subroutine search_load

  ! Finds the compression at which interacting contacts carry a load at a time, from their load P
  ! without effects in time, by the secant method. P is a constraint of the potential of
  ! interaction,
  ! which has a minimum under any P, whereas P jumps at a compression where a contact opens another
  ! one nearby, or where the number of boundary elements changes. The load at the time is a gain
  ! times P and what is left of the states before: linear as long as the same contacts are loaded.
  subroutine search_interacting_load(pairs, effects, target, time, found, failure)
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(in) :: effects(:)
    real(real64), intent(in) :: target, time  ! load, more than 0; time since the begin of loading
    type(found_state), intent(inout) :: found  ! state at a compression near by; the state found
    character(len=:), allocatable, intent(inout) :: failure  ! reason; not allocated where solved
    character(len=:), allocatable :: why
    real(real64) :: elastic, former(2), load, slope
    integer :: try

    elastic = target / share_at(effects, time)
    former = 0.0_real64
    do try = 1, digits(elastic)
      call estimate_compression(pairs, effects, .false., elastic, time, found, why)
      if (.not. allocated(why) .and. .not. allocated(found%solution)) return
      if (.not. allocated(why)) call simulate_effects(pairs, effects, time, found)
      if (.not. allocated(why)) call first_failure(effects, found%outcomes, why)
      if (allocated(why)) then
        failure = why
        return
      end if
      load = controlled_load(pairs, found%state)
      if (abs(load - target) <= least_error * target) exit
      slope = (load - former(2)) / (elastic - former(1))
      if (.not. (slope > 0.0_real64 .and. slope <= huge(slope))) slope = load / elastic
      former = [elastic, load]
      elastic = elastic + (target - load) / slope
      if (.not. (elastic > 0.0_real64 .and. abs(elastic - former(1)) > 0.0_real64)) exit
    end do
    if (abs(load - target) <= largest_error * target) deallocate (failure)
  end subroutine search_interacting_load

  ! Ratio of the load at a time to that at the same compression on loading.
  real(real64) function share_at(effects, time) result(share)
    type(effect_box), intent(in) :: effects(:)
    real(real64), intent(in) :: time
    integer :: i

    share = 1.0_real64
    do i = 1, merge(size(effects), 0, time > 0.0_real64)
      share = share * effects(i)%effect%held_share(time)
    end do
  end function share_at

  ! First compression of a search: that of the effects that can estimate it, else the given one,
  ! else that of Hertzian contacts.
  recursive subroutine guess_compression(pairs, effects, target, time, most, found, failure)
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(in) :: effects(:)
    real(real64), intent(in) :: target, time, most  ! most: largest compression
    type(found_state), intent(inout) :: found
    character(len=:), allocatable, intent(inout) :: failure
    type(found_state) :: elastic
    type(effect_box) :: none(0)
    character(len=:), allocatable :: why
    real(real64) :: guessed, load, residual, slope
    logical :: jumps

    if (allocated(found%solution)) deallocate (found%solution)
    if (target > 0.0_real64) then
      load = 0.0_real64
      if (is_at_compression(found)) load = max(controlled_load(pairs, found%state), 0.0_real64)
      if (load > 0.0_real64) then
        residual = (load / target)**two_thirds - 1.0_real64
        slope = residual_slope(found%state, load, residual)
        ! The last state is that of another load or time: at most half or twice its compression.
        if (slope * found%compression > 0.0_real64) found%compression = found%compression * &
          min(max(1.0_real64 - residual / (slope * found%compression), 0.5_real64), 2.0_real64)
      else if (is_at_compression(found) .or. .not. found%compression > 0.0_real64) then
        ! The first contact alone has a larger compression.
        elastic%compression = (0.75_real64 * target / pairs%modulus)**two_thirds / &
                              pairs%list(1)%radius**(1.0_real64 / 3.0_real64)
        call search_load(pairs, none, target, 0.0_real64, elastic, jumps, why)
        found%compression = max(found%compression, elastic%compression)
      end if
    end if
    if (target > 0.0_real64) &
      call estimate_compression(pairs, effects, .true., target / share_at(effects, time), time, &
                                found, failure)
    if (allocated(failure)) then
      if (pairs%interrupt%is_asked()) return
      ! The bracketed search finds the load, or the largest one, from compressions.
      deallocate (failure)
      if (allocated(found%solution)) deallocate (found%solution)
    end if
    guessed = found%compression
    found%compression = min(max(found%compression, 0.0_real64), &
                            most * (1.0_real64 - epsilon(1.0_real64)))
    if (abs(found%compression - guessed) > 0.0_real64 .and. allocated(found%solution)) &
      deallocate (found%solution)
  end subroutine guess_compression

  ! Whether the state is that of the compression, also where it belongs to another load or time.
  pure logical function is_at_compression(found)
    type(found_state), intent(in) :: found

    is_at_compression = allocated(found%state%answers)
    if (is_at_compression) &
      is_at_compression = .not. abs(found%state%compression - found%compression) > 0.0_real64
  end function is_at_compression

  ! Derivative of (load/target)**(2/3) by the compression from the stiffness of the contacts, which
  ! is that of vertical loads without interaction; 0 where it is not positive.
  pure real(real64) function residual_slope(state, load, residual) result(slope)
    type(contact_state), intent(in) :: state
    real(real64), intent(in) :: load, residual

    slope = 0.0_real64
    if (load > 0.0_real64) slope = &
      max(0.0_real64, two_thirds * (residual + 1.0_real64) / load * sum(state%answers%stiffness))
  end function residual_slope

  ! Sets the compression to that of interaction, which has a search of its own for a load.
  subroutine estimate_compression(pairs, effects, is_elastic, target, time, found, failure)
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(in) :: effects(:)
    logical, intent(in) :: is_elastic  ! only of elastic contacts
    real(real64), intent(in) :: target, time
    type(found_state), intent(inout) :: found
    character(len=:), allocatable, intent(inout) :: failure
    type(contact_state) :: state
    type(effect_outcome) :: outcomes(size(effects))
    integer :: i, k

    call start_state(pairs, hertz_law(modulus=pairs%modulus), found%compression, state)
    state%time = time
    call choose_effects(pairs, effects, state, found%choice)
    do i = 1, size(effects)
      if (.not. is_simulated(i)) cycle
      select type (effect => effects(i)%effect)
      type is (interaction_effect)
        if (is_elastic .and. any([(is_simulated(k), k=1, i - 1)])) return
        ! The law of the contacts is that of the effects before.
        do k = 1, i - 1
          if (is_simulated(k)) call effects(k)%effect%apply(pairs, state, outcomes(k))
        end do
        call effect%solve_together(pairs, state%law, found%choice%tolerance, found%compression, &
                                   found%solution, failure, target)
        if (allocated(failure)) failure = 'interaction: ' // failure
        return
      end select
    end do

  contains

    logical function is_simulated(i)
      integer, intent(in) :: i

      is_simulated = found%choice%is_simulated(i)
      if (allocated(found%fixed_choice) .and. effects(i)%effect%mode == effect_auto) &
        is_simulated = found%fixed_choice(i)
    end function is_simulated

  end subroutine estimate_compression

end module asperity_load_search
