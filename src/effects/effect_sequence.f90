!> The effects of one state, one after the other: left out, estimated or simulated.
module asperity_effect_sequence
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state, start_state, total_vertical_load
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_scene_values, only: effect_auto
  implicit none
  private

  public :: simulate, all_left_out

contains

  !> The contacts at a closing with the effects called for.
  subroutine simulate(pairs, effects, closing, state, outcomes)
    type(contact_pairs), intent(in) :: pairs                        !! the position
    type(effect_box), intent(in) :: effects(:)                      !! in the order they act
    real(real64), intent(in) :: closing                             !! past first touch
    type(contact_state), intent(out) :: state                       !! with the effects
    type(effect_outcome), allocatable, intent(out) :: outcomes(:)   !! what each did
    real(real64) :: before
    integer :: i

    allocate (outcomes(size(effects)))
    call start_state(pairs, hertz_law(modulus=pairs%modulus), closing, state)
    do i = 1, size(effects)
      associate (effect => effects(i)%effect, outcome => outcomes(i))
        before = total_vertical_load(state)
        if (effect%mode == effect_auto) then
          outcome%estimate = effect%estimate(pairs, state)
          if (.not. outcome%estimate > effect%tolerance) cycle
        end if
        call effect%apply(pairs, state, outcome)
        if (allocated(outcome%failure)) return
        if (before > 0.0_real64 .and. .not. outcome%influence_known) &
          outcome%influence = total_vertical_load(state) / before - 1.0_real64
      end associate
    end do
  end subroutine simulate

  !> Whether `auto` left all effects out.
  pure logical function all_left_out(outcomes)
    type(effect_outcome), intent(in) :: outcomes(:)  !! of one state
    integer :: i

    all_left_out = .true.
    do i = 1, size(outcomes)
      all_left_out = all_left_out .and. outcomes(i)%simulated == 'off'
    end do
  end function all_left_out

end module asperity_effect_sequence
