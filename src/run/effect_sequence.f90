!> The effects of one state, one after the other: left out, estimated or simulated.
module asperity_effect_sequence
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state, start_state, total_vertical_load
  use asperity_effect_choice, only: choose_effects
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_scene_values, only: effect_auto
  implicit none
  private

  public :: simulate, first_failure

contains

  !> The contacts at a closing with the effects called for.
  subroutine simulate(pairs, effects, closing, time, state, outcomes, loading_only, found, &
                      called_for)
    type(contact_pairs), intent(in) :: pairs                        !! the position
    type(effect_box), intent(in) :: effects(:)                      !! in the order they act
    real(real64), intent(in) :: closing                             !! past first touch
    real(real64), intent(in) :: time                                !! since the end of loading
    type(contact_state), intent(out) :: state                       !! with the effects
    type(effect_outcome), allocatable, intent(out) :: outcomes(:)   !! what each did
    !> leave out what acts in time; without it nothing is left out
    logical, intent(in), optional :: loading_only
    !> what a search for the closing has found (pair, quantity)
    real(real64), intent(in), optional :: found(:, :)
    !> of `auto`, what is simulated whatever its estimate is, and what is not
    logical, intent(in), optional :: called_for(:)
    real(real64) :: before
    logical, allocatable :: called(:)
    character(len=:), allocatable :: why
    logical :: without_time
    integer :: i

    without_time = .false.
    if (present(loading_only)) without_time = loading_only
    allocate (outcomes(size(effects)))
    call start_state(pairs, hertz_law(modulus=pairs%modulus), closing, state)
    state%time = time
    if (pairs%interrupt%is_asked() .and. size(effects) > 0) then
      outcomes(1)%failure = 'interrupted'
      return
    end if
    if (present(found)) state%found = found
    call choose_effects(pairs, effects, state, outcomes, called, state%left)
    why = 'estimate above tolerance'
    if (present(called_for)) then
      why = 'estimate at tolerance'
      do i = 1, size(effects)
        if (effects(i)%effect%mode == effect_auto) called(i) = called_for(i)
      end do
    end if
    do i = 1, size(effects)
      associate (effect => effects(i)%effect, outcome => outcomes(i))
        if (without_time .and. effect%acts_in_time) cycle
        if (called(i) .and. effect%approximates .and. effect%mode == effect_auto .and. &
            .not. present(called_for)) then
          ! The laws of contact may have changed what it would do.
          outcome%estimate = effect%estimate(pairs, state)
          called(i) = outcome%estimate > state%left
        end if
        if (.not. called(i)) then
          call effect%leave_out(pairs, state, outcome)
          cycle
        end if
        if (effect%mode == effect_auto) outcome%why = why
        before = total_vertical_load(state)
        call effect%apply(pairs, state, outcome)
        if (allocated(outcome%failure)) return
        if (before > 0.0_real64 .and. .not. outcome%influence_known) &
          outcome%influence = total_vertical_load(state) / before - 1.0_real64
      end associate
    end do
    do i = 1, size(effects)
      call effects(i)%effect%finish(pairs, state, outcomes(i))
    end do
  end subroutine simulate

  !> Why the first of the effects that failed could not be simulated.
  subroutine first_failure(effects, outcomes, failure)
    type(effect_box), intent(in) :: effects(:)                 !! of the scene
    type(effect_outcome), intent(in) :: outcomes(:)            !! of one state
    character(len=:), allocatable, intent(inout) :: failure    !! stays as it is when none failed
    integer :: i

    do i = size(effects), 1, -1
      if (allocated(outcomes(i)%failure)) &
        failure = trim(effects(i)%effect%name) // ': ' // outcomes(i)%failure
    end do
  end subroutine first_failure

end module asperity_effect_sequence
