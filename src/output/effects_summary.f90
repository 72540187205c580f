!> The effects in the summary of `asperity solve`: where each was simulated, why, and how it ended.
module asperity_effects_summary
  use asperity_effect_names, only: known_effects
  use asperity_kinds, only: not_computed, real64
  use asperity_number_format, only: count_text, percent_text, positions_text, number_text
  use asperity_problems, only: decimal_text, real_text
  use asperity_scene_results, only: effect_header, scene_results
  use asperity_scene_values, only: effect_auto, effect_words
  use asperity_text_buffer, only: text_buffer
  use asperity_totals_table, only: load_is_met
  implicit none
  private

  public :: effect_sentence, list_effects, write_effects, effects_in_words

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
    type(text_buffer), intent(inout) :: buffer  !! the text
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
      if (size(results%positions) > 1) text = text // ' (position ' // decimal_text(worst) // ')'
      lines = [lines, effect_sentence(known_effects(e)%name, text)]
    end do
  end subroutine list_effects

  subroutine list_effect(results, header, e, lines)
    type(scene_results), intent(in) :: results
    type(effect_header), intent(in) :: header
    integer, intent(in) :: e
    type(effect_sentence), allocatable, intent(inout) :: lines(:)
    logical, allocatable :: simulated(:), so(:)
    real(real64), allocatable :: area(:), closing(:), influence(:), left_out(:), residual(:)
    character(len=:), allocatable :: word, head, text, why
    integer :: first, m, number, simulated_at
    logical :: has_pixels

    number = size(results%positions)
    allocate (simulated(number), so(number), influence(number), left_out(number), &
              residual(number), area(number), closing(number))
    influence = 0.0_real64
    left_out = -1.0_real64
    residual = 0.0_real64
    ! On pixels the load without plasticity is not computed.
    has_pixels = header%names(e) == 'plasticity' .and. header%hardness > 0.0_real64
    do m = 1, number
      associate (outcome => results%positions(m)%effects(e))
        simulated(m) = outcome%simulated /= 'off'
        closing(m) = outcome%closing_change
        area(m) = outcome%area_change
        if (simulated(m)) then
          influence(m) = 0.0_real64
          if (outcome%influence > not_computed) influence(m) = outcome%influence
          if (has_pixels) influence(m) = not_computed
          residual(m) = outcome%ending%residual
        else
          left_out(m) = max(0.0_real64, outcome%estimate)
        end if
      end associate
    end do
    simulated_at = count(simulated)
    head = trim(header%names(e))
    word = trim(effect_words(header%modes(e)))
    first = maxloc(residual, 1)
    text = ''
    if (simulated_at > 0) &
      text = ', largest residual ' // number_text(residual(first), 2) // at_position(first)
    if (header%modes(e) == effect_auto) then
      call add_sentence(head, word // ', tolerance ' // percent_text(header%tolerance) // &
               ': estimated at ' // count_text(number, 'position') // ', simulated at ' // &
               decimal_text(simulated_at) // text)
    else
      call add_sentence(head, word // ': simulated at ' // count_text(simulated_at, 'position') // &
                        text)
    end if
    if (has_pixels) then
      call add_sentence('', 'perfectly plastic pixels: pressures up to plastic_hardness = ' // &
               number_text(header%hardness, 6))
    else if (header%names(e) == 'plasticity') then
      call add_sentence('', 'the ' // header%plastic_body // ' body yields')
    end if
    if (header%names(e) == 'plasticity' .and. .not. header%plasticity_index < 0.0_real64) then
      call add_sentence('', 'plasticity index ' // &
               real_text(header%plasticity_index, 'g10.3'))
    end if

    ! The modes in which it was simulated, in the order in which they first occur.
    so = .not. simulated
    do while (.not. all(so))
      first = findloc(so, .false., 1)
      word = trim(results%positions(first)%effects(e)%simulated)
      why = trim(results%positions(first)%effects(e)%why)
      call describe_mode(word, why)
    end do
    if (simulated_at > 0) then
      first = maxloc(abs(influence), 1)
      text = ''
      if (all(influence > not_computed)) then
        text = 'influence ' // percent_text(influence(first)) // at_position(first)
        if (number > 1) text = text // ', smallest ' // &
                               percent_text(influence(minloc(abs(influence), 1, simulated)))
      end if
      if (any(closing > not_computed)) text = text // trim(merge('; ', '  ', text /= '')) // &
        ' at the prescribed load: compression ' // largest_change(closing) // ', area ' // &
        largest_change(area)
      if (text /= '') call add_sentence('', trim(adjustl(text)))
    end if
    if (simulated_at < number .and. header%modes(e) == effect_auto) then
      first = maxloc(left_out, 1)
      call add_sentence('', 'largest estimated influence left out ' // &
          percent_text(left_out(first)) // at_position(first))
    end if

  contains

    subroutine describe_mode(word, why)
      character(len=*), intent(in) :: word, why
      logical :: this_way(size(so))
      integer :: i

      do i = 1, size(so)
        this_way(i) = .not. so(i)
        if (this_way(i)) this_way(i) = results%positions(i)%effects(e)%simulated == word
      end do
      so = so .or. this_way
      if (header%modes(e) /= effect_auto) return
      if (why == '') then
        call add_sentence('', word // ' at ' // positions_text(this_way))
      else
        call add_sentence('', word // ' (' // why // ') at ' // positions_text(this_way))
      end if
    end subroutine describe_mode

    subroutine add_sentence(effect, text)
      character(len=*), intent(in) :: effect, text
      lines = [lines, effect_sentence(effect, text)]
    end subroutine add_sentence

    ! The greatest of the changes that were measured, with its sign.
    function largest_change(changes) result(text)
      real(real64), intent(in) :: changes(:)
      character(len=:), allocatable :: text
      integer :: at

      at = maxloc(abs(changes), 1, changes > not_computed)
      if (at == 0) then
        text = 'unknown'
        return
      end if
      ! A load is met to this share.
      if (abs(changes(at)) < load_is_met) then
        text = '0 %'
        return
      end if
      text = percent_text(changes(at)) // at_position(at)
      if (changes(at) > 0.0_real64) text = '+' // text
    end function largest_change

    function at_position(position) result(text)
      integer, intent(in) :: position
      character(len=:), allocatable :: text

      text = ''
      if (number > 1) text = ' (position ' // decimal_text(position) // ')'
    end function at_position

  end subroutine list_effect

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
