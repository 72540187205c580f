!> What the effects change at a load that is asked for: there the load is the same with and without
!> them, and closing and area are not.
module asperity_effect_at_load
  use asperity_closing_at_load, only: search_load
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_records, only: effect_record
  use asperity_contact_state, only: contact_state
  use asperity_kinds, only: real64
  implicit none
  private

  public :: weigh_at_load

contains

  !> Compares the last state with those of fewer effects under the same load: of Hertz alone, then
  !> with the first effect that was simulated, with the first two and so on. The influence of an
  !> effect is its addition to those before it. It is not computed where the contacts cannot carry
  !> the load without the other effects.
  subroutine weigh_at_load(pairs, effects, load, state, records, failure)
    type(contact_pairs), intent(in) :: pairs            !! the position
    type(effect_box), intent(inout) :: effects(:)       !! not needed any more: they are forgotten
    real(real64), intent(in) :: load                    !! asked for, more than 0
    type(contact_state), intent(in) :: state            !! that bears it with all effects
    type(effect_record), intent(inout) :: records(:)    !! of each effect in it
    character(len=:), allocatable, intent(out) :: failure  !! why not all are compared
    type(effect_box) :: those(size(effects))
    type(contact_state) :: fewer
    type(effect_outcome), allocatable :: outcomes(:)
    logical, allocatable :: called_for(:)
    real(real64), allocatable :: found(:, :)
    real(real64) :: area, area_before, closing, closing_before
    logical :: jumps
    integer :: i, number, simulated

    simulated = count(records%simulated /= 'off')
    if (simulated == 0) return
    number = 0
    closing = pairs%closing
    call search_load(pairs, those(:0), load, 0.0_real64, closing, fewer, outcomes, called_for, &
                     jumps, found, failure)
    if (allocated(failure)) return
    area = area_of(fewer)
    do i = 1, size(effects)
      if (records(i)%simulated == 'off') cycle
      number = number + 1
      call move_alloc(effects(i)%effect, those(number)%effect)
      closing_before = closing
      area_before = area
      if (number == simulated) then
        closing = state%closing
        area = area_of(state)
      else
        call begin_anew(pairs, those(:number))
        allocate (called_for(number))
        called_for = .true.
        call search_load(pairs, those(:number), load, state%time, closing, fewer, outcomes, &
                         called_for, jumps, found, failure)
        deallocate (called_for)
        if (allocated(failure)) return
        area = area_of(fewer)
      end if
      if (closing_before > 0.0_real64) &
        records(i)%closing_change = closing / closing_before - 1.0_real64
      if (area_before > 0.0_real64) records(i)%area_change = area / area_before - 1.0_real64
    end do
  end subroutine weigh_at_load

  ! What effects remember is that of all of them together.
  subroutine begin_anew(pairs, effects)
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(inout) :: effects(:)
    integer :: i

    do i = 1, size(effects)
      call effects(i)%effect%begin(pairs)
    end do
  end subroutine begin_anew

  ! In squares of a length, over pi.
  pure real(real64) function area_of(state)
    type(contact_state), intent(in) :: state

    area_of = sum(state%answers%contact_radius**2)
  end function area_of

end module asperity_effect_at_load
