!> The effects of one state, one after the other: left out, estimated or simulated. Those that
!> `auto` leaves out are together within a tolerance.
module asperity_effect_sequence
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state, interaction_solution, start_state, &
                                    total_vertical_load
  use asperity_effect_names, only: go_together
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: not_computed, real64
  use asperity_scene_values, only: effect_auto, effect_boundary
  use asperity_theory_warnings, only: add_warning, of_together
  implicit none
  private

  public :: choose_effects, drop_choice, effect_choice, first_failure, found_state, &
            leave_smallest, simulate_effects

  !> Effects chosen for a state without effects.
  type :: effect_choice
    real(real64) :: compression = 0.0_real64         !! of this state
    real(real64) :: time = 0.0_real64                !! of this state
    logical, allocatable :: is_simulated(:)          !! by effect; not allocated: none is chosen
    type(effect_outcome), allocatable :: outcomes(:)  !! by effect: its estimate and warnings
    real(real64) :: tolerance = 1.0_real64           !! relative, of the simulated effects
  end type effect_choice

  !> A compression, the contacts there and the results of the search for it.
  type :: found_state
    real(real64) :: compression = 0.0_real64           !! compression, length, 0 or more
    real(real64) :: prescribed_load = huge(1.0_real64)  !! requested load; huge: none
    type(contact_state) :: state                       !! contacts with the effects
    type(effect_outcome), allocatable :: outcomes(:)   !! results of the effects
    type(effect_choice) :: choice                      !! effects of the last state without them
    !> By effect, for those of `auto`: whether it is simulated, regardless of its estimate; not
    !> allocated: its estimate decides.
    logical, allocatable :: fixed_choice(:)
    !> Solution of the search for the compression; not allocated: no effect searched.
    type(interaction_solution), allocatable :: solution
  end type found_state

contains

  !> Computes the contacts at a compression with the effects that are chosen.
  subroutine simulate_effects(pairs, effects, time, found, loading_only)
    type(contact_pairs), intent(in) :: pairs     !! pairs of the position
    type(effect_box), intent(in) :: effects(:)   !! effects of the scene, in their order of action
    real(real64), intent(in) :: time             !! time since the begin of loading, 0 or more
    type(found_state), intent(inout) :: found    !! compression and search; gets the state
    !> whether effects that act in time are left out; absent: .false.
    logical, intent(in), optional :: loading_only
    real(real64) :: before
    logical :: is_simulated(size(effects)), without_time
    character(len=:), allocatable :: why
    integer :: i

    without_time = .false.
    if (present(loading_only)) without_time = loading_only
    if (allocated(found%outcomes)) deallocate (found%outcomes)
    call start_state(pairs, hertz_law(modulus=pairs%modulus), found%compression, found%state)
    found%state%time = time
    if (pairs%interrupt%is_asked() .and. size(effects) > 0) then
      allocate (found%outcomes(size(effects)))
      found%outcomes(1)%failure = 'interrupted'
      return
    end if
    call choose_effects(pairs, effects, found%state, found%choice)
    found%outcomes = found%choice%outcomes
    found%state%tolerance = found%choice%tolerance
    is_simulated = found%choice%is_simulated
    why = 'estimate above tolerance'
    if (allocated(found%fixed_choice)) then
      why = 'estimate at tolerance'
      do i = 1, size(effects)
        if (effects(i)%effect%mode == effect_auto) is_simulated(i) = found%fixed_choice(i)
      end do
    end if
    ! A search for a load has solved this state.
    if (allocated(found%solution)) then
      found%state%solution = found%solution
    end if
    do i = 1, size(effects)
      associate (effect => effects(i)%effect, outcome => found%outcomes(i))
        if (without_time .and. effect%acts_in_time) then
          outcome%of_contacts%is_left_out = .true.
          outcome%of_state%is_left_out = .true.
          call effect%leave_out(pairs, found%state, outcome)
          cycle
        end if
        if (is_simulated(i) .and. effect%approximates .and. effect%mode == effect_auto .and. &
            .not. allocated(found%fixed_choice)) then
          ! Effects before this one may have changed the contact law and so its estimate.
          if (any(is_simulated(:i - 1))) outcome%estimate = effect%estimate(pairs, found%state)
          is_simulated(i) = outcome%estimate > found%state%tolerance
        end if
        if (.not. is_simulated(i)) then
          call effect%leave_out(pairs, found%state, outcome)
          cycle
        end if
        if (effect%mode == effect_auto) outcome%why = why
        before = total_vertical_load(found%state)
        call effect%apply(pairs, found%state, outcome)
        if (allocated(outcome%failure)) return
        if (before > 0.0_real64 .and. .not. outcome%influence > not_computed) &
          outcome%influence = total_vertical_load(found%state) / before - 1.0_real64
      end associate
    end do
    do i = 1, size(effects)
      call effects(i)%effect%finish(pairs, found%state, found%outcomes(i))
    end do
  end subroutine simulate_effects

  !> Message of the first effect that failed. It is unchanged when no effect failed.
  subroutine first_failure(effects, outcomes, failure)
    type(effect_box), intent(in) :: effects(:)                 !! effects of the scene
    type(effect_outcome), intent(in) :: outcomes(:)            !! their results in one state
    character(len=:), allocatable, intent(inout) :: failure    !! name of the effect and reason
    integer :: i

    do i = size(effects), 1, -1
      if (allocated(outcomes(i)%failure)) &
        failure = trim(effects(i)%effect%name) // ': ' // outcomes(i)%failure
    end do
  end subroutine first_failure

  !> Chooses effects by their estimates for a state without effects, unless the last choice is that
  !> of its compression and time.
  !>
  !> The effects with the smallest estimates are left out as long as their sum is within the
  !> tolerance, or within half of it where an effect is simulated that approximates: the rest, at
  !> least the other half, is for its own error. Of two effects without a common theory the one with
  !> the larger estimate is simulated, with a warning for the other; an effect that is `on`, or acts
  !> in the hold, has precedence.
  subroutine choose_effects(pairs, effects, state, choice)
    type(contact_pairs), intent(in) :: pairs       !! pairs of the position
    type(effect_box), intent(in) :: effects(:)     !! effects of the scene
    type(contact_state), intent(in) :: state       !! contacts without effects
    type(effect_choice), intent(inout) :: choice   !! last choice of these effects; the new one

    integer :: order(size(effects)), i, number
    logical, dimension(size(effects)) :: is_open, of_choice
    real(real64) :: tolerance

    if (allocated(choice%is_simulated)) then
      if (.not. (abs(choice%compression - state%compression) > 0.0_real64 .or. &
                 abs(choice%time - state%time) > 0.0_real64)) return
    end if
    call drop_choice(choice)
    choice%compression = state%compression
    choice%time = state%time
    choice%tolerance = 1.0_real64
    allocate (choice%is_simulated(size(effects)), choice%outcomes(size(effects)))
    associate (outcomes => choice%outcomes, is_chosen => choice%is_simulated)
      tolerance = 1.0_real64
      is_open = .false.
      do i = 1, size(effects)
        associate (effect => effects(i)%effect)
          is_chosen(i) = effect%mode /= effect_auto
          if (is_chosen(i)) cycle
          tolerance = min(tolerance, effect%tolerance)
          outcomes(i)%estimate = effect%estimate(pairs, state)
          ! A hold has states because loading ended with an effect that acts in time.
          is_chosen(i) = effect%acts_in_time .and. state%time > 0.0_real64
          is_open(i) = .not. is_chosen(i)
        end associate
      end do
      ! Descending estimates; equal ones keep their order.
      of_choice = is_open
      number = 0
      do while (any(is_open))
        number = number + 1
        order(number) = maxloc(outcomes%estimate, 1, is_open)
        is_open(order(number)) = .false.
      end do
      if (number == 0) return
      call leave_smallest(outcomes%estimate, of_choice, tolerance, is_chosen)
      if (any([(is_chosen(order(i)) .and. effects(order(i))%effect%approximates, i=1, number)])) &
        call leave_smallest(outcomes%estimate, of_choice, 0.5_real64 * tolerance, is_chosen)
      ! At least half of the tolerance: effects that are `on` may approximate, too.
      choice%tolerance = max(0.5_real64 * tolerance, &
                             tolerance - sum(outcomes%estimate, .not. is_chosen))
      call exclude_conflicts(effects, order(:number), outcomes, is_chosen)
    end associate
  end subroutine choose_effects

  !> Leaves out the effects with the smallest estimates while their sum is within a share.
  pure subroutine leave_smallest(estimates, of_choice, share, is_chosen)
    real(real64), intent(in) :: estimates(:)  !! of each effect; may be huge
    logical, intent(in) :: of_choice(:)       !! effects with a choice
    real(real64), intent(in) :: share         !! largest sum of those left out
    logical, intent(inout) :: is_chosen(:)    !! whether each is simulated
    logical :: is_open(size(of_choice))
    real(real64) :: total
    integer :: i

    is_open = of_choice
    total = 0.0_real64
    do while (any(is_open))
      i = minloc(estimates, 1, is_open, back=.true.)
      is_open(i) = .false.
      ! A huge estimate is not added before the comparison.
      is_chosen(i) = estimates(i) > share - total
      if (.not. is_chosen(i)) total = total + estimates(i)
    end do
  end subroutine leave_smallest

  !> Drops the last choice, as estimates depend on the states that effects keep.
  subroutine drop_choice(choice)
    type(effect_choice), intent(inout) :: choice  !! without a last choice

    if (allocated(choice%is_simulated)) deallocate (choice%is_simulated, choice%outcomes)
  end subroutine drop_choice

  ! Leaves out, with a warning, effects of `auto` without a common theory with one of precedence:
  ! one that is `on` or acts in the hold, then those of `auto` by descending estimate.
  subroutine exclude_conflicts(effects, order, outcomes, is_chosen)
    type(effect_box), intent(in) :: effects(:)
    integer, intent(in) :: order(:)  ! effects of `auto` by descending estimate
    type(effect_outcome), intent(inout) :: outcomes(:)
    logical, intent(inout) :: is_chosen(:)
    integer :: i, other

    do i = 1, size(order)
      do other = 1, size(effects)
        if (.not. (is_chosen(order(i)) .and. is_chosen(other))) cycle
        if (any(order(i:) == other)) cycle
        if (go_together(effects(order(i))%effect%name, mode_word(order(i)), &
                        effects(other)%effect%name, mode_word(other))) cycle
        is_chosen(order(i)) = .false.
        call add_warning(outcomes(order(i))%warnings, of_together, outcomes(order(i))%estimate, &
                         whose=trim(effects(order(i))%effect%name) // ' beside ' // &
                               effects(other)%effect%name)
      end do
    end do

  contains

    ! The mode in which an effect would be simulated, as far as other effects depend on it.
    character(len=8) function mode_word(effect)
      integer, intent(in) :: effect

      mode_word = 'on'
      if (effects(effect)%effect%mode == effect_boundary) mode_word = 'boundary'
    end function mode_word

  end subroutine exclude_conflicts

end module asperity_effect_sequence
