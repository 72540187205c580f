!> The effects in the summary of `asperity solve`: a row an effect.
module asperity_effects_summary
  use asperity_contact_records, only: effect_record
  use asperity_effect_header, only: effect_header
  use asperity_effect_names, only: known_effects, of_plasticity
  use asperity_kinds, only: not_computed, real64
  use asperity_number_format, only: number_text, percent_text
  use asperity_problems, only: decimal_text, real_text
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: effect_auto, effect_words
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: load_is_met, write_effects, effects_in_words

  !> A prescribed load is met to this relative error.
  real(real64), parameter :: load_is_met = 1.0e-6_real64

contains

  !> `interaction auto, friction on`.
  pure function effects_in_words(results) result(text)
    type(scene_results), intent(in) :: results  !! results of a run
    character(len=:), allocatable :: text
    integer :: e

    text = ''
    if (allocated(results%effects)) then
      do e = 1, size(results%effects%names)
        if (e > 1) text = text // ', '
        text = text // trim(results%effects%names(e)) // ' ' // &
               trim(effect_words(results%effects%modes(e)))
      end do
    end if
    if (text == '') text = 'none'
  end function effects_in_words

  !> The table: mode and tolerance of each effect, at how many positions it was simulated, its
  !> largest measured influence on the vertical load, the largest estimate where it is left out or
  !> off, and a note.
  subroutine write_effects(results, buffer)
    type(scene_results), intent(in) :: results  !! results of a run
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    real(real64) :: share
    integer :: e

    if (.not. allocated(results%effects) .and. &
        .not. any([(results%positions%left_out(e) > not_computed, &
                    e=1, size(known_effects))])) return
    call buffer%line('')
    call put_row(buffer, 'effect', 'mode', 'tolerance', 'simulated at', 'influence', 'left out', '')
    if (allocated(results%effects)) then
      do e = 1, size(results%effects%names)
        call write_effect(results, results%effects, e, buffer)
      end do
    end if
    do e = 1, size(known_effects)
      share = maxval(results%positions%left_out(e))
      if (share > not_computed) &
        call put_row(buffer, known_effects(e)%name, 'off', '', '', '', percent_text(share), '')
    end do
  end subroutine write_effects

  ! Writes the row of an effect that the scene names.
  subroutine write_effect(results, header, e, buffer)
    type(scene_results), intent(in) :: results
    type(effect_header), intent(in) :: header
    integer, intent(in) :: e
    type(text_buffer), intent(inout) :: buffer
    type(effect_record) :: outcomes(size(results%positions))
    logical :: is_simulated(size(outcomes))
    character(len=:), allocatable :: influence, left_out, note, tolerance
    integer :: at, m

    outcomes = [(results%positions(m)%effects(e), m=1, size(outcomes))]
    is_simulated = outcomes%simulated /= 'off'
    influence = ''
    left_out = ''
    tolerance = ''
    note = ''
    if (header%modes(e) == effect_auto) then
      tolerance = percent_text(header%tolerance)
      if (.not. all(is_simulated)) left_out = percent_text(max(0.0_real64, &
        maxval(outcomes%estimate, .not. is_simulated)))
      if (any(.not. is_simulated .and. outcomes%why /= '' .and. .not. &
              outcomes%estimate > not_computed)) left_out = 'unknown'
    end if
    ! On pixels the load without an effect is not computed.
    at = maxloc(abs(outcomes%influence), 1, is_simulated .and. outcomes%influence > not_computed)
    if (at > 0) influence = percent_text(outcomes(at)%influence)
    at = maxloc(abs(outcomes%compression_change), 1, outcomes%compression_change > not_computed)
    if (at > 0) note = 'at the prescribed load: compression ' // &
      percent_text(outcomes(at)%compression_change) // ', area ' // &
      percent_text(outcomes(at)%area_change)
    at = findloc(is_simulated .and. outcomes%why /= '', .true., 1)
    if (at > 0) note = note_behind(note, trim(outcomes(at)%simulated) // ' (' // &
                                         trim(outcomes(at)%why) // ')')
    if (header%names(e) == known_effects(of_plasticity)%name) then
      if (header%hardness > 0.0_real64) then
        note = note_behind(note, 'pressures up to ' // number_text(header%hardness))
      else
        note = note_behind(note, 'the ' // header%plastic_body // ' body yields')
      end if
      if (.not. header%plasticity_index < 0.0_real64) &
        note = note_behind(note, 'index ' // real_text(header%plasticity_index, 'g10.3'))
    end if
    if (any(is_simulated .and. outcomes%ending%residual > not_computed)) &
      note = note_behind(note, 'residual ' // &
                         number_text(maxval(outcomes%ending%residual, is_simulated), 2))
    call put_row(buffer, header%names(e), effect_words(header%modes(e)), tolerance, &
                 decimal_text(count(is_simulated)) // ' of ' // decimal_text(size(outcomes)), &
                 influence, left_out, note)
  end subroutine write_effect

  subroutine put_row(buffer, name, mode, tolerance, simulated, influence, left_out, note)
    type(text_buffer), intent(inout) :: buffer
    character(len=*), intent(in) :: name, mode, tolerance, simulated, influence, left_out, note
    character(len=75) :: row

    write (row, '(a12, a9, a10, a15, 2a12, 3x)') [character(len=12) :: name], &
      [character(len=9) :: mode], tolerance, simulated, influence, left_out
    call buffer%line(trim(row(:75) // note))
  end subroutine put_row

  ! A note with more behind it.
  pure function note_behind(note, more) result(text)
    character(len=*), intent(in) :: note, more
    character(len=:), allocatable :: text

    text = more
    if (note /= '') text = note // ', ' // more
  end function note_behind

end module asperity_effects_summary
