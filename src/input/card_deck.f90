!> The original program's card deck: cards in, checked values or a list of problems out.
module asperity_card_deck
  use asperity_card_reader, only: angle_field, card_length, card_reader, count_field, deck_fields, &
                                  height_max_field, modulus_field, radius_field, ratio_field, &
                                  read_i_field, shift_field, stress_field, width_field, x_field, &
                                  y_field, z_field
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_delimited_text, only: cells_of, line_cells, separator_of
  use asperity_file_kind, only: other_kind
  use asperity_input_text, only: blanks, check_text, line_end, read_text
  use asperity_kinds, only: real64
  use asperity_library_turn, only: library_turn
  use asperity_numeral, only: read_numeral
  use asperity_problems, only: decimal_text, problem_list
  implicit none
  private

  public :: card_deck, has_cards, model_cards, notes_of_deck, read_card_deck, parse_card_deck

  !> One model as the cards give it: inches and psi.
  type :: model_cards
    integer :: number = 0                       !! NU, NL: asperities
    type(decimal_value) :: radius               !! RU, RL: summit radius, in
    type(decimal_value) :: height_max           !! ZUMAX, ZLMAX: stated greatest height, in
    type(decimal_value) :: elastic_modulus      !! EU, EL: psi
    type(decimal_value) :: poisson_ratio        !! MUU, MUL
    type(decimal_value) :: stress_max           !! ELIMTU, ELIMTL: psi
    type(decimal_value) :: angle                !! THETAU, THETAL: rad
    type(decimal_value), allocatable :: x(:)    !! mold positions, in
    type(decimal_value), allocatable :: y(:)    !! mold positions, in
    type(decimal_value), allocatable :: z(:)    !! heights, in
  end type model_cards

  !> A whole deck.
  type :: card_deck
    character(len=4) :: word_no = ''            !! printed for a contact within the limit
    character(len=4) :: word_yes = ''           !! printed for a contact at or over the limit
    type(model_cards) :: upper                  !! the upper model
    type(model_cards) :: lower                  !! the lower model
    type(decimal_value) :: lower_width          !! WIDTHL, in
    type(decimal_value) :: x_displacement       !! XDISPL, in
    type(decimal_value) :: y_displacement       !! YDISPL, in
    type(problem_list) :: notes                 !! oddities that are no errors
    !> Values that the original program ran with unchecked: problems of a scene.
    type(problem_list) :: unchecked
  end type card_deck

  integer, parameter :: header_cards = 4  ! cards before the first asperity

contains

  !> Reads and checks a deck. With problems the deck is not to be used.
  subroutine read_card_deck(path, deck, problems)
    character(len=*), intent(in) :: path           !! path of the deck; `-` is standard input
    type(card_deck), intent(out) :: deck           !! values of the cards, as written
    type(problem_list), intent(out) :: problems    !! all that is wrong
    character(len=:), allocatable :: text
    type(library_turn) :: turn

    call turn%begin()
    call read_text(path, 'a card deck', text, problems)
    if (problems%count() == 0) call parse_card_deck(path, text, deck, problems)
  end subroutine read_card_deck

  !> Writes the notes of a run of the original program: oddities, and what it did not check.
  subroutine notes_of_deck(path, deck, text)
    character(len=*), intent(in) :: path                !! path of the deck
    type(card_deck), intent(in) :: deck                 !! values of its cards
    character(len=:), allocatable, intent(out) :: text  !! lines with their ends
    type(library_turn) :: turn

    call turn%begin()
    text = deck%notes%text()
    if (deck%unchecked%count() > 0) &
      text = text // path // ': note: the original program did not check this, and ran:' // &
             new_line('a') // deck%unchecked%text()
  end subroutine notes_of_deck

  !> Whether one of the three cards behind the first has numbers alone, as in every deck.
  pure logical function has_cards(text)
    character(len=*), intent(in) :: text  !! the whole file
    integer :: first, last, line

    has_cards = .false.
    last = 0
    do line = 1, header_cards
      first = last + 1
      last = line_end(text, min(first, len(text) + 1)) + 1
      if (line > 1 .and. first <= len(text)) &
        has_cards = has_cards .or. (scan(text(first:last - 1), '0123456789') > 0 .and. &
                    verify(text(first:last - 1), blanks // '+-.0123456789eEdD') == 0)
    end do

  end function has_cards

  !> Checks the text of a deck; `path` serves the messages only.
  subroutine parse_card_deck(path, text, deck, problems)
    character(len=*), intent(in) :: path           !! name for the messages
    character(len=*), intent(in) :: text           !! the whole deck
    type(card_deck), intent(out) :: deck           !! values of the cards, as written
    type(problem_list), intent(out) :: problems    !! all that is wrong
    type(card_reader) :: reader
    character(len=:), allocatable :: other
    logical :: complete

    call reader%take_text(path, text)
    other = other_kind(text, [integer ::])
    if (other /= '') then
      call reader%problems%add_at(1, 1, other // '; expected a card deck')
    else if (verify(text, blanks) == 0) then
      call reader%problems%add_at(1, 1, 'the deck is empty: found no text, ' // &
                                   'expected at least six cards')
    else
      call check_text(text, 'a card deck', reader%problems)
      if (reader%problems%count() == 0 .and. .not. has_cards(text) .and. &
          (scan(text, ':={[') > 0 .or. &
           index(path, '.scene', back=.true.) == max(1, len(path) - 5))) &
        call reader%problems%add_at(1, 1, 'found no card of numbers behind the first one, ' // &
                                    'expected a card deck; a scene: asperity solve FILE')
    end if
    if (reader%problems%count() == 0) then
      call read_header(reader, deck, complete)
      if (complete) then
        call read_asperities(reader, deck)
        call note_heights(path, deck%upper, 'upper', deck%notes)
        call note_heights(path, deck%lower, 'lower', deck%notes)
        deck%unchecked = reader%unchecked
      end if
      if (.not. has_numbers(text) .or. is_table(reader)) call reader%problems%shorten(0)
    end if
    problems = reader%problems
  end subroutine parse_card_deck

  ! Whether three quarters of the signs behind the first card are those of numbers.
  pure logical function has_numbers(text)
    character(len=*), intent(in) :: text
    integer :: i, numeric, others

    numeric = 0
    others = 0
    do i = min(len(text), line_end(text, 1)) + 1, len(text)
      if (scan(text(i:i), '+-.0123456789') == 1) then
        numeric = numeric + 1
      else if (scan(text(i:i), blanks) == 0) then
        others = others + 1
      end if
    end do
    has_numbers = numeric >= 3 * others
  end function has_numbers

  ! Whether cards 2, 3 and 4 cannot be those of a deck, which have 6, 7 and 4 numbers, or fewer
  ! where numbers touch, with one in columns 41-47 of card 3.
  pure logical function is_table(reader)
    type(card_reader), intent(in) :: reader
    type(line_cells) :: cells
    type(decimal_value) :: number
    character(len=card_length) :: columns
    integer :: i, k, numbers(2:header_cards), words(2:header_cards)
    logical :: good

    numbers = 0
    do i = 2, header_cards
      columns = reader%card_columns(i)
      if (i == 3) is_table = columns(deck_fields(width_field)%first:) == ''
      cells = cells_of(columns, separator_of(columns), .false.)
      words(i) = cells%cell_count
      do k = 1, words(i)
        call read_numeral(columns(cells%first(k):cells%last(k)), number, good)
        numbers(i) = numbers(i) + merge(1, 0, good)
      end do
    end do
    is_table = is_table .or. numbers(2) == 0 .or. numbers(2) >= max(3, numbers(3)) .or. &
               all(words == words(2)) .or. any(numbers > [6, 7, 4])
  end function is_table

  !> Cards 1 to 4; `complete` is false when one of them is missing.
  subroutine read_header(reader, deck, complete)
    type(card_reader), intent(inout) :: reader
    type(card_deck), intent(inout) :: deck
    logical, intent(out) :: complete
    character(len=card_length) :: words

    words = reader%card_columns(1)
    deck%word_no = words(1:4)
    deck%word_yes = words(5:8)
    complete = .true.
    call reader%require_card(2, 'NU, RU, ZUMAX, EU, MUU, ELIMTU (the upper model)', complete)
    if (complete) call read_model(reader, 2, 'U', deck%upper)
    call reader%require_card(3, 'NL, RL, ZLMAX, EL, MUL, ELIMTL, WIDTHL (the lower model)', &
                             complete)
    if (complete) then
      call read_model(reader, 3, 'L', deck%lower)
      call reader%real_field(3, width_field, 'L', deck%lower_width)
    end if
    call reader%require_card(4, 'THETAU, THETAL, XDISPL, YDISPL (angles, displacement)', complete)
    if (.not. complete) return
    call reader%real_field(4, angle_field(1), 'U', deck%upper%angle)
    call reader%real_field(4, angle_field(2), 'L', deck%lower%angle)
    call reader%real_field(4, shift_field(1), '', deck%x_displacement)
    call reader%real_field(4, shift_field(2), '', deck%y_displacement)
  end subroutine read_header

  !> Card 2 or 3: one model's numbers.
  subroutine read_model(reader, line, letter, model)
    type(card_reader), intent(inout) :: reader
    integer, intent(in) :: line
    character(len=1), intent(in) :: letter
    type(model_cards), intent(inout) :: model
    character(len=card_length) :: columns
    integer :: bad_at
    real(real64) :: ratio

    columns = reader%card_columns(line)
    ! Deviation n: the library took a character that is no digit as 0. Deviation o: a loop DO ran
    ! once for a count below 1. Deviation p, also in the fields of radius, modulus and width.
    call read_i_field(columns(:deck_fields(count_field)%last), model%number, bad_at)
    if (bad_at > 0) then
      call reader%refuse_field(line, count_field, letter, 'a whole number in columns 1-5', bad_at)
      model%number = 0
    else if (model%number < 1) then
      call reader%refuse_field(line, count_field, letter, 'at least 1')
    end if
    call reader%real_field(line, radius_field, letter, model%radius)
    call reader%real_field(line, height_max_field, letter, model%height_max)
    if (model%height_max%all_digits < 0) &
      call reader%refuse_field(line, height_max_field, letter, 'no negative number')
    call check_height(reader, line, height_max_field, letter, model, model%height_max)
    call reader%real_field(line, modulus_field, letter, model%elastic_modulus)
    call reader%real_field(line, ratio_field, letter, model%poisson_ratio)
    ratio = decimal_to_real64(model%poisson_ratio)
    if (ratio <= -1.0_real64 .or. ratio > 0.5_real64) &
      call reader%refuse_field(line, ratio_field, letter, 'more than -1 and at most 0.5', &
                               unchecked=.true.)
    call reader%real_field(line, stress_field, letter, model%stress_max)
  end subroutine read_model

  !> The coordinate cards of both models, and their count. Where NU or NL is not to be trusted, its
  !> model takes the cards that the other leaves: their fields are checked, their count is not.
  subroutine read_asperities(reader, deck)
    type(card_reader), intent(inout) :: reader
    type(card_deck), intent(inout) :: deck
    integer :: cards, upper, lower

    cards = max(0, reader%last_card() - header_cards)
    upper = min(deck%upper%number, cards)
    lower = min(deck%lower%number, cards - upper)
    if (deck%upper%number < 1 .and. deck%lower%number < 1) then
      ! Whose cards these are is unknown, and so is the radius to check their heights against.
      deck%upper%radius = decimal_value()
      call read_positions(reader, deck%upper, 'upper or lower', header_cards, cards)
      call read_positions(reader, deck%lower, 'lower', header_cards + cards, 0)
      return
    else if (deck%upper%number < 1) then
      lower = min(deck%lower%number, cards)
      upper = cards - lower
    else if (deck%lower%number < 1) then
      lower = cards - upper
    end if
    call read_positions(reader, deck%upper, 'upper', header_cards, upper)
    call read_positions(reader, deck%lower, 'lower', header_cards + upper, lower)
    if (min(deck%upper%number, deck%lower%number) > 0) call check_count(reader, deck, cards)
  end subroutine read_asperities

  !> The coordinate cards of one model: `number` cards that follow line `before`.
  subroutine read_positions(reader, model, name, before, number)
    type(card_reader), intent(inout) :: reader
    type(model_cards), intent(inout) :: model
    character(len=*), intent(in) :: name
    integer, intent(in) :: before, number
    character(len=:), allocatable :: asperity
    integer :: i, line

    allocate (model%x(number), model%y(number), model%z(number))
    do i = 1, number
      line = before + i
      asperity = name // ' asperity ' // decimal_text(i)
      call reader%real_field(line, x_field, asperity, model%x(i))
      call reader%real_field(line, y_field, asperity, model%y(i))
      call reader%real_field(line, z_field, asperity, model%z(i))
      call check_height(reader, line, z_field, asperity, model, model%z(i))
    end do
  end subroutine read_positions

  !> As many coordinate cards as NU and NL say, and nothing but blank lines after them, which the
  !> original program did not read.
  subroutine check_count(reader, deck, cards)
    type(card_reader), intent(inout) :: reader
    type(card_deck), intent(in) :: deck
    integer, intent(in) :: cards
    character(len=card_length) :: columns
    character(len=:), allocatable :: wrong_count
    integer :: expected, line

    expected = deck%upper%number + deck%lower%number
    if (cards == expected) return
    wrong_count = 'wrong count of cards: found ' // decimal_text(cards) // &
            ' asperities, expected ' // &
            decimal_text(expected) // ' (NU ' // decimal_text(deck%upper%number) // ' and NL ' // &
            decimal_text(deck%lower%number) // ')'
    do line = header_cards + 1, header_cards + min(cards, expected)
      if (reader%has_text(line)) cycle
      wrong_count = wrong_count // '; line ' // decimal_text(line) // &
                    ' is blank: an asperity of zeros'
      exit
    end do
    ! Deviation q: the original read to the end of the data.
    if (cards < expected) then
      wrong_count = wrong_count // shift_hint(2, 'NU', deck%upper%number, deck%lower%number, cards)
      wrong_count = wrong_count // shift_hint(3, 'NL', deck%lower%number, deck%upper%number, cards)
      call reader%problems%add_at(header_cards + cards + 1, 1, wrong_count)
      return
    end if
    do line = header_cards + expected + 1, reader%last_card()
      if (.not. reader%has_text(line)) cycle
      columns = reader%card_columns(line)
      call reader%unchecked%add_at(line, verify(columns, ' ' // achar(9)), &
           'text after the last card: found ''' // trim(columns) // &
           ''', expected the end: ' // wrong_count)
      exit
    end do
  end subroutine check_count

  !> Text for a count whose zeros at the end make it too large, as those of a shifted card do.
  pure function shift_hint(line, name, number, other, cards) result(hint)
    integer, intent(in) :: line              !! line of the card with the count
    character(len=*), intent(in) :: name     !! NU or NL
    integer, intent(in) :: number            !! count of this model, as read
    integer, intent(in) :: other             !! count of the other model
    integer, intent(in) :: cards             !! coordinate cards of the deck
    character(len=:), allocatable :: hint    !! empty where no zero too many explains the count
    integer :: without

    hint = ''
    without = number
    do while (without > 0 .and. mod(without, 10) == 0)
      without = without / 10
      if (without + other /= cards) cycle
      hint = '; ' // name // ' ' // decimal_text(without) // ' would fit: is card ' // &
             decimal_text(line) // ' shifted to the left? Blanks after a digit are zeros'
      return
    end do
  end function shift_hint

  !> A sphere does not stand higher than its diameter. The original program uses its centre alone.
  subroutine check_height(reader, line, field, whose, model, height)
    type(card_reader), intent(inout) :: reader
    integer, intent(in) :: line, field
    character(len=*), intent(in) :: whose
    type(model_cards), intent(in) :: model
    type(decimal_value), intent(in) :: height

    if (model%radius%all_digits <= 0) return
    if (decimal_to_real64(height) >= 2 * decimal_to_real64(model%radius)) &
      call reader%refuse_field(line, field, whose, 'less than twice the radius', unchecked=.true.)
  end subroutine check_height

  !> Names the asperities that stand higher than the stated maximum: the thesis' deck has some.
  subroutine note_heights(path, model, name, notes)
    character(len=*), intent(in) :: path, name
    type(model_cards), intent(in) :: model
    type(problem_list), intent(inout) :: notes
    real(real64) :: stated, highest
    character(len=:), allocatable :: which
    character(len=16) :: numeral
    integer :: i, found

    stated = decimal_to_real64(model%height_max)
    highest = stated
    which = ''
    found = 0
    do i = 1, size(model%z)
      if (.not. decimal_to_real64(model%z(i)) > stated) cycle
      highest = max(highest, decimal_to_real64(model%z(i)))
      found = found + 1
      if (found <= 10) which = which // ' ' // decimal_text(i)
    end do
    if (found == 0) return
    if (found > 10) which = which // ' ...'
    write (numeral, '(f16.4)') highest
    call notes%add(path // ': note: ' // decimal_text(found) // ' ' // name // &
                   ' asperities are higher (up to ' // trim(adjustl(numeral)) // &
                   ' in) than the stated maximum:' // which)
  end subroutine note_heights

end module asperity_card_deck
