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

  public :: found_state, simulate_effects, first_failure

  !> A compression, the contacts there and the results of the search for it.
  type :: found_state
    real(real64) :: closing = 0.0_real64               !! compression, length, 0 or more
    real(real64) :: prescribed_load = huge(1.0_real64)  !! requested load; huge: none
    type(contact_state) :: state                       !! contacts with the effects
    type(effect_outcome), allocatable :: outcomes(:)   !! results of the effects
    !> By effect, for those of `auto`: whether it is simulated, regardless of its estimate; not
    !> allocated: its estimate decides.
    logical, allocatable :: called_for(:)
    !> Results of the search for the compression (pair, quantity), for the effect that searched; not
    !> allocated: no effect searched.
    real(real64), allocatable :: found(:, :)
  end type found_state

contains

  !> Computes the contacts at a compression with the effects that are called for.
  subroutine simulate_effects(pairs, effects, time, found, loading_only)
    type(contact_pairs), intent(in) :: pairs     !! pairs of the position
    type(effect_box), intent(in) :: effects(:)   !! effects of the scene, in their order of action
    real(real64), intent(in) :: time             !! time since the begin of loading, 0 or more
    type(found_state), intent(inout) :: found    !! compression and search; gets the state
    !> whether effects that act in time are left out; absent: .false.
    logical, intent(in), optional :: loading_only
    real(real64) :: before
    logical, allocatable :: called(:)
    character(len=:), allocatable :: why
    logical :: without_time
    integer :: i

    without_time = .false.
    if (present(loading_only)) without_time = loading_only
    if (allocated(found%outcomes)) deallocate (found%outcomes)
    allocate (found%outcomes(size(effects)))
    call start_state(pairs, hertz_law(modulus=pairs%modulus), found%closing, found%state)
    found%state%time = time
    if (pairs%interrupt%is_asked() .and. size(effects) > 0) then
      found%outcomes(1)%failure = 'interrupted'
      return
    end if
    if (allocated(found%found)) found%state%found = found%found
    call choose_effects(pairs, effects, found%state, found%outcomes, called, found%state%left)
    why = 'estimate above tolerance'
    if (allocated(found%called_for)) then
      why = 'estimate at tolerance'
      do i = 1, size(effects)
        if (effects(i)%effect%mode == effect_auto) called(i) = found%called_for(i)
      end do
    end if
    do i = 1, size(effects)
      associate (effect => effects(i)%effect, outcome => found%outcomes(i))
        if (without_time .and. effect%acts_in_time) cycle
        if (called(i) .and. effect%approximates .and. effect%mode == effect_auto .and. &
            .not. allocated(found%called_for)) then
          ! Effects before this one may have changed the contact law and so its estimate.
          outcome%estimate = effect%estimate(pairs, found%state)
          called(i) = outcome%estimate > found%state%left
        end if
        if (.not. called(i)) then
          call effect%leave_out(pairs, found%state, outcome)
          cycle
        end if
        if (effect%mode == effect_auto) outcome%why = why
        before = total_vertical_load(found%state)
        call effect%apply(pairs, found%state, outcome)
        if (allocated(outcome%failure)) return
        if (before > 0.0_real64 .and. .not. outcome%influence_known) &
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

end module asperity_effect_sequence
