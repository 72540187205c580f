!> What effects did at a position as numbers, to be sent to another image or kept in a file.
!>
!> Only what is written out travels: how each effect was simulated and ended, and the columns.
module asperity_effect_packet
  use asperity_contact_effect, only: effect_outcome
  use asperity_effect_report, only: effects_at_position
  use asperity_kinds, only: real64
  use asperity_letters, only: numbers_for, text_in, text_to_numbers
  implicit none
  private

  public :: pack_effects, unpack_effects

  ! Numbers before the outcomes, and of an outcome without its words.
  integer, parameter :: of_head = 4, of_outcome = 6

contains

  !> The numbers of a position's effects.
  pure subroutine pack_effects(at_position, numbers)
    type(effects_at_position), intent(in) :: at_position    !! a position that is solved
    real(real64), allocatable, intent(out) :: numbers(:)    !! never none
    integer :: i, at, words, values(2)

    words = words_of_outcome()
    ! A list of contacts that is not kept has no columns.
    values = 0
    if (allocated(at_position%contact_values)) values = shape(at_position%contact_values)
    allocate (numbers(of_head + size(at_position%outcomes) * (words + of_outcome) + &
                      product(values) + size(at_position%state_values)))
    numbers(:of_head) = real([size(at_position%outcomes), values, &
                              size(at_position%state_values)], real64)
    at = of_head
    do i = 1, size(at_position%outcomes)
      call pack_outcome(at_position%outcomes(i), numbers(at + 1:at + words + of_outcome))
      at = at + words + of_outcome
    end do
    if (product(values) > 0) numbers(at + 1:at + product(values)) = &
      reshape(at_position%contact_values, [product(values)])
    numbers(at + product(values) + 1:) = at_position%state_values
  end subroutine pack_effects

  !> The effects in such numbers; without any they stay.
  pure subroutine unpack_effects(numbers, at_position)
    real(real64), intent(in) :: numbers(:)                  !! from pack_effects
    type(effects_at_position), intent(inout) :: at_position !! the position
    integer :: i, at, words, values(2), states

    if (size(numbers) == 0) return
    at_position = effects_at_position()
    words = words_of_outcome()
    values = nint(numbers(2:3))
    states = nint(numbers(4))
    allocate (at_position%outcomes(nint(numbers(1))), &
              at_position%contact_values(values(1), values(2)), at_position%state_values(states))
    at = of_head
    do i = 1, size(at_position%outcomes)
      call unpack_outcome(numbers(at + 1:at + words + of_outcome), at_position%outcomes(i))
      at = at + words + of_outcome
    end do
    at_position%contact_values = reshape(numbers(at + 1:at + product(values)), values)
    at_position%state_values = numbers(at + product(values) + 1:)
  end subroutine unpack_effects

  ! Numbers for the words of an outcome.
  pure integer function words_of_outcome()
    type(effect_outcome) :: outcome

    words_of_outcome = numbers_for(len(outcome%simulated)) + numbers_for(len(outcome%why))
  end function words_of_outcome

  pure subroutine pack_outcome(outcome, numbers)
    type(effect_outcome), intent(in) :: outcome
    real(real64), intent(out) :: numbers(:)
    integer :: way, words

    way = numbers_for(len(outcome%simulated))
    words = words_of_outcome()
    call text_to_numbers(outcome%simulated, numbers(:way))
    call text_to_numbers(outcome%why, numbers(way + 1:words))
    numbers(words + 1:) = [outcome%estimate, outcome%influence, &
                           merge(1.0_real64, 0.0_real64, outcome%influence_known), &
                           merge(1.0_real64, 0.0_real64, outcome%ending%converged), &
                           outcome%ending%residual, real(outcome%ending%iterations, real64)]
  end subroutine pack_outcome

  pure subroutine unpack_outcome(numbers, outcome)
    real(real64), intent(in) :: numbers(:)
    type(effect_outcome), intent(inout) :: outcome
    integer :: way, words

    way = numbers_for(len(outcome%simulated))
    words = words_of_outcome()
    outcome%simulated = text_in(numbers(:way))
    outcome%why = text_in(numbers(way + 1:words))
    outcome%estimate = numbers(words + 1)
    outcome%influence = numbers(words + 2)
    outcome%influence_known = nint(numbers(words + 3)) == 1
    outcome%ending%converged = nint(numbers(words + 4)) == 1
    outcome%ending%residual = numbers(words + 5)
    outcome%ending%iterations = nint(numbers(words + 6))
  end subroutine unpack_outcome

end module asperity_effect_packet
