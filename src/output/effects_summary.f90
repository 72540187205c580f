!> The effects in the summary of `asperity solve`: where each was simulated, why, and how it ended.
module asperity_effects_summary
  use asperity_contact_records, only: effect_record
  use asperity_effect_names, only: known_effects
  use asperity_kinds, only: not_computed, real64
  use asperity_number_format, only: count_text, percent_text, positions_text, number_text
  use asperity_problems, only: decimal_text, real_text
  use asperity_effect_header, only: effect_header
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: effect_auto, effect_words
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: load_is_met, effect_sentence, list_effects, write_effects, effects_in_words

  !> A prescribed load is met to this relative error.
  real(real64), parameter :: load_is_met = 1.0e-6_real64

  integer, parameter :: widest = 100, indent = 15
  ! A sentence lists positions up to half of this length.
  integer, parameter :: longest = 1000

  !> A sentence about an effect.
  type :: effect_sentence
    character(len=11) :: effect = ''         !! its name in its first sentence, blank in the others
    character(len=longest) :: text = ''      !! the sentence
  end type effect_sentence

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

  !> One paragraph an effect, below a heading.
  subroutine write_effects(results, buffer)
    type(scene_results), intent(in) :: results  !! results of a run
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    type(effect_sentence), allocatable :: lines(:)
    integer :: i

    call list_effects(results, lines)
    if (size(lines) == 0) return
    call buffer%line('')
    call buffer%line('Effects, relative to the vertical load without the effect')
    do i = 1, size(lines)
      call write_paragraph(trim(lines(i)%effect), trim(lines(i)%text), buffer)
    end do
  end subroutine write_effects

  !> The sentences about all effects: at how many positions each was estimated and simulated, its
  !> measured influence, the largest estimate left out, how the solves ended; the estimated
  !> influence of each that is off.
  subroutine list_effects(results, lines)
    type(scene_results), intent(in) :: results              !! results of a run
    type(effect_sentence), allocatable, intent(out) :: lines(:)   !! none where there are no effects
    character(len=:), allocatable :: text
    real(real64) :: share
    integer :: e, worst

    allocate (lines(0))
    if (allocated(results%effects)) then
      do e = 1, size(results%effects%names)
        call list_effect(results, results%effects, e, lines)
      end do
    end if
    do e = 1, size(known_effects)
      worst = maxloc(results%positions%left_out(e), 1)
      share = results%positions(worst)%left_out(e)
      if (.not. share > not_computed) cycle
      text = 'off: estimated influence on the load ' // percent_text(share)
      lines = [lines, effect_sentence(known_effects(e)%name, &
                                      text // at_position(worst, size(results%positions)))]
    end do
  end subroutine list_effects

  ! The sentences about one effect.
  subroutine list_effect(results, header, e, lines)
    type(scene_results), intent(in) :: results
    type(effect_header), intent(in) :: header
    integer, intent(in) :: e
    type(effect_sentence), allocatable, intent(inout) :: lines(:)
    type(effect_record) :: outcomes(size(results%positions))
    logical, dimension(size(results%positions)) :: alike, is_named, is_simulated
    character(len=:), allocatable :: mode, text
    integer :: first, m

    outcomes = [(results%positions(m)%effects(e), m=1, size(outcomes))]
    is_simulated = outcomes%simulated /= 'off'
    text = ''
    if (any(is_simulated .and. outcomes%ending%residual > not_computed)) then
      first = maxloc(merge(outcomes%ending%residual, not_computed, is_simulated), 1)
      text = ', largest residual ' // number_text(outcomes(first)%ending%residual, 2) // &
             at_position(first, size(outcomes))
    end if
    mode = trim(effect_words(header%modes(e)))
    if (header%modes(e) == effect_auto) then
      mode = mode // ', tolerance ' // percent_text(header%tolerance) // ': estimated at ' // &
             count_text(size(outcomes), 'position') // ', simulated at ' // &
             decimal_text(count(is_simulated))
    else
      mode = mode // ': simulated at ' // count_text(count(is_simulated), 'position')
    end if
    lines = [lines, effect_sentence(trim(header%names(e)), mode // text)]
    if (header%names(e) == 'plasticity') then
      if (header%hardness > 0.0_real64) then
        lines = [lines, effect_sentence('', 'perfectly plastic pixels: pressures up to ' // &
                                        'plastic_hardness = ' // number_text(header%hardness))]
      else
        lines = [lines, effect_sentence('', 'the ' // header%plastic_body // ' body yields')]
      end if
      if (.not. header%plasticity_index < 0.0_real64) &
        lines = [lines, effect_sentence('', 'plasticity index ' // &
                                        real_text(header%plasticity_index, 'g10.3'))]
    end if
    ! The modes in which it was simulated, in the order in which they first occur.
    is_named = .not. is_simulated .or. header%modes(e) /= effect_auto
    do while (.not. all(is_named))
      first = findloc(is_named, .false., 1)
      alike = .not. is_named .and. outcomes%simulated == outcomes(first)%simulated .and. &
              outcomes%why == outcomes(first)%why
      text = trim(outcomes(first)%simulated)
      if (outcomes(first)%why /= '') text = text // ' (' // trim(outcomes(first)%why) // ')'
      lines = [lines, effect_sentence('', text // ' at ' // positions_text(alike))]
      is_named = is_named .or. alike
    end do
    if (any(is_simulated)) call list_influence(outcomes, is_simulated, lines)
    if (all(is_simulated) .or. header%modes(e) /= effect_auto) return
    first = maxloc(merge(-1.0_real64, max(0.0_real64, outcomes%estimate), is_simulated), 1)
    lines = [lines, effect_sentence('', 'largest estimated influence left out ' // &
                                    percent_text(max(0.0_real64, outcomes(first)%estimate)) // &
                                    at_position(first, size(outcomes)))]
  end subroutine list_effect

  ! The measured influence of an effect on the load, and on compression and area at a given load.
  subroutine list_influence(outcomes, is_simulated, lines)
    type(effect_record), intent(in) :: outcomes(:)
    logical, intent(in) :: is_simulated(:)
    type(effect_sentence), allocatable, intent(inout) :: lines(:)
    real(real64) :: influence(size(outcomes))
    character(len=:), allocatable :: text
    integer :: first

    text = ''
    ! On pixels the load without an effect is not computed.
    if (any(is_simulated .and. outcomes%influence > not_computed)) then
      influence = merge(outcomes%influence, 0.0_real64, &
                        is_simulated .and. outcomes%influence > not_computed)
      first = maxloc(abs(influence), 1)
      text = 'influence ' // percent_text(influence(first)) // at_position(first, size(outcomes))
      if (size(outcomes) > 1) text = text // ', smallest ' // &
        percent_text(influence(minloc(abs(influence), 1, is_simulated)))
    end if
    if (any(outcomes%compression_change > not_computed)) then
      if (text /= '') text = text // '; '
      text = text // 'at the prescribed load: compression ' // &
             largest_change(outcomes%compression_change) // ', area ' // &
             largest_change(outcomes%area_change)
    end if
    if (text /= '') lines = [lines, effect_sentence('', text)]
  end subroutine list_influence

  ! The largest of the changes that were measured, with its sign; a load is met to `load_is_met`.
  function largest_change(changes) result(text)
    real(real64), intent(in) :: changes(:)
    character(len=:), allocatable :: text
    integer :: at

    at = maxloc(abs(changes), 1, changes > not_computed)
    if (at == 0) then
      text = 'unknown'
    else if (abs(changes(at)) < load_is_met) then
      text = '0 %'
    else
      text = percent_text(changes(at)) // at_position(at, size(changes))
      if (changes(at) > 0.0_real64) text = '+' // text
    end if
  end function largest_change

  ! ` (position 3)`; empty where there is only one.
  pure function at_position(position, number) result(text)
    integer, intent(in) :: position, number
    character(len=:), allocatable :: text

    text = ''
    if (number > 1) text = ' (position ' // decimal_text(position) // ')'
  end function at_position

  ! A text in lines, after a word.
  subroutine write_paragraph(head, text, buffer)
    character(len=*), intent(in) :: head, text
    type(text_buffer), intent(inout) :: buffer
    character(len=indent) :: margin
    integer :: from, to, room

    room = widest - indent
    margin = '  ' // head
    from = 1
    do
      to = len(text)
      if (to - from + 1 > room) then
        to = from + index(text(from:from + room - 1), ' ', back=.true.) - 2
        if (to < from) to = from + room - 1
      end if
      call buffer%line(margin // text(from:to))
      margin = ''
      from = to + verify(text(to + 1:), ' ')
      if (from == to) return
    end do
  end subroutine write_paragraph

end module asperity_effects_summary
