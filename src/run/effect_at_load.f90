!> Changes of compression and area by each effect at a requested load: the load is the same with and
!> without it.
module asperity_effect_at_load
  use asperity_closing_at_load, only: search_load
  use asperity_contact_effect, only: effect_box
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_records, only: effect_record
  use asperity_contact_state, only: contact_state
  use asperity_effect_sequence, only: found_state
  use asperity_kinds, only: real64
  implicit none
  private

  public :: compare_at_load

contains

  !> Compares the last state with those of fewer effects under the same load: of Hertz, then with
  !> the first effect that was simulated, with the first two and so on. The change by an effect is
  !> that of its addition to those before it. It is not computed where the contacts cannot carry the
  !> load without the other effects.
  subroutine compare_at_load(pairs, effects, load, state, records, failure)
    type(contact_pairs), intent(in) :: pairs            !! pairs of the position
    type(effect_box), intent(inout) :: effects(:)       !! effects of the scene; undefined on exit
    real(real64), intent(in) :: load                    !! requested load, > 0
    type(contact_state), intent(in) :: state            !! state with all effects at this load
    type(effect_record), intent(inout) :: records(:)    !! results of each effect in it
    character(len=:), allocatable, intent(out) :: failure  !! reason, when not all are compared
    type(effect_box) :: those(size(effects))
    type(found_state) :: fewer
    real(real64) :: area, area_before, closing, closing_before
    logical :: jumps
    integer :: i, k, number, simulated

    simulated = count(records%simulated /= 'off')
    if (simulated == 0) return
    number = 0
    fewer%closing = pairs%closing
    call search_load(pairs, those(:0), load, 0.0_real64, fewer, jumps, failure)
    if (allocated(failure)) return
    closing = fewer%closing
    area = area_of(fewer%state)
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
        ! The memory is that of all effects together.
        do k = 1, number
          call those(k)%effect%begin(pairs)
        end do
        allocate (fewer%called_for(number))
        fewer%called_for = .true.
        call search_load(pairs, those(:number), load, state%time, fewer, jumps, failure)
        deallocate (fewer%called_for)
        if (allocated(failure)) return
        closing = fewer%closing
        area = area_of(fewer%state)
      end if
      if (closing_before > 0.0_real64) &
        records(i)%closing_change = closing / closing_before - 1.0_real64
      if (area_before > 0.0_real64) records(i)%area_change = area / area_before - 1.0_real64
    end do
  end subroutine compare_at_load

  ! Contact area over pi, length squared.
  pure real(real64) function area_of(state)
    type(contact_state), intent(in) :: state

    area_of = sum(state%answers%contact_radius**2)
  end function area_of

end module asperity_effect_at_load
