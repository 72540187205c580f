!> The text of a card deck as cards: their columns, their numbers, and problems with their places.
module asperity_card_reader
  use asperity_card_fields, only: read_f_field
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_input_text, only: line_end
  use asperity_kinds, only: real64
  use asperity_problems, only: decimal_text, problem_list
  implicit none
  private

  public :: card_length, card_reader

  !> Columns of a card.
  integer, parameter :: card_length = 80

  ! Columns before a card's sequence number.
  integer, parameter :: text_length = 72

  !> The cards of a file, and what is found wrong with them.
  type :: card_reader
    private
    character(len=:), allocatable :: text
    integer, allocatable :: first(:), last(:)   ! of every line, line end excluded
    type(problem_list), public :: problems      !! what is wrong with the deck
  contains
    procedure :: start         !! takes the text of a deck
    procedure :: lines         !! number of lines
    procedure :: card          !! the columns of a card
    procedure :: has_text      !! whether a card holds more than blanks and a sequence number
    procedure :: last_card     !! the last line that is a card
    procedure :: real_field    !! reads a number under F format
    procedure :: require_card  !! reports a problem when a card is missing
    procedure :: complain      !! reports a problem at a column of a card
    procedure :: check_bytes   !! reports the first byte that is no text
  end type card_reader

contains

  !> Takes the text of a deck. A carriage return before a line feed belongs to the line end.
  subroutine start(self, file, text)
    class(card_reader), intent(out) :: self    !! the cards
    character(len=*), intent(in) :: file       !! name for the messages
    character(len=*), intent(in) :: text       !! the whole deck
    integer :: i, number, begin

    call self%problems%start(file)
    self%text = text
    number = 0
    do i = 1, len(text)
      if (text(i:i) == achar(10)) number = number + 1
    end do
    if (len(text) > 0) then
      if (text(len(text):) /= achar(10)) number = number + 1
    end if
    allocate (self%first(number), self%last(number))
    begin = 1
    do i = 1, number
      self%first(i) = begin
      self%last(i) = line_end(text, begin)
      begin = self%last(i) + 2
      if (self%last(i) >= self%first(i)) then
        if (text(self%last(i):self%last(i)) == achar(13)) self%last(i) = self%last(i) - 1
      end if
    end do
  end subroutine start

  !> Number of lines.
  pure integer function lines(self)
    class(card_reader), intent(in) :: self  !! the cards

    lines = size(self%first)
  end function lines

  !> The 80 columns of a card; a card that is not there is blank.
  pure function card(self, line) result(columns)
    class(card_reader), intent(in) :: self  !! the cards
    integer, intent(in) :: line             !! its line, from 1
    character(len=card_length) :: columns   !! what stands there

    columns = ''
    if (line > size(self%first)) return
    columns = self%text(self%first(line):self%last(line))
  end function card

  !> Whether a card holds more than blanks and a sequence number.
  pure logical function has_text(self, line)
    class(card_reader), intent(in) :: self  !! the cards
    integer, intent(in) :: line             !! its line, from 1
    character(len=card_length) :: columns

    columns = self%card(line)
    has_text = verify(columns(:text_length), ' ' // achar(9)) > 0
  end function has_text

  !> The last line that is a card; 0 when none is. Blank lines at the end are none: they must not
  !> stand in for cards that are missing.
  pure integer function last_card(self)
    class(card_reader), intent(in) :: self  !! the cards

    do last_card = size(self%first), 1, -1
      if (self%has_text(last_card)) return
    end do
  end function last_card

  !> Reads columns `from:to` under F format; reports a problem when that is no finite number,
  !> or, with `positive`, not above zero.
  subroutine real_field(self, line, from, to, decimals, name, value, positive)
    class(card_reader), intent(inout) :: self   !! the cards
    integer, intent(in) :: line                 !! the card's line, from 1
    integer, intent(in) :: from                 !! first column
    integer, intent(in) :: to                   !! last column
    integer, intent(in) :: decimals             !! digits behind the implied point
    character(len=*), intent(in) :: name        !! what it is, for a message
    type(decimal_value), intent(out) :: value   !! the number; zero when it is none
    logical, intent(in), optional :: positive   !! only above zero
    character(len=card_length) :: columns
    integer :: bad_at

    columns = self%card(line)
    call read_f_field(columns(from:to), decimals, value, bad_at)
    if (bad_at > 0) then
      call self%complain(line, from + bad_at - 1, name, columns(from:to), &
                         'a number in columns ' // decimal_text(from) // '-' // &
                         decimal_text(to) // ' (F' // decimal_text(to - from + 1) // '.' // &
                         decimal_text(decimals) // ')')
      value = decimal_value()
    else if (abs(decimal_to_real64(value)) > huge(1.0_real64)) then
      call self%complain(line, from, name, columns(from:to), 'a finite number')
      value = decimal_value()
    else if (present(positive)) then
      if (positive .and. value%digits <= 0) &
        call self%complain(line, from, name, columns(from:to), 'more than zero')
    end if
  end subroutine real_field

  !> Reports a problem when the deck ends before card `line`.
  subroutine require_card(self, line, names, complete)
    class(card_reader), intent(inout) :: self  !! the cards
    integer, intent(in) :: line                !! the card's line, from 1
    character(len=*), intent(in) :: names      !! what it holds, for the message
    logical, intent(inout) :: complete         !! made false when the card is missing

    if (line <= size(self%first)) return
    complete = .false.
    call self%problems%add_at(line, 1, 'card ' // decimal_text(line) // &
                              ' is missing: found the end of the deck, expected ' // names)
  end subroutine require_card

  !> Reports `FILE:LINE:COLUMN: NAME: found '...', expected ...`.
  subroutine complain(self, line, column, name, found, expected)
    class(card_reader), intent(inout) :: self  !! the cards
    integer, intent(in) :: line                !! the card's line, from 1
    integer, intent(in) :: column              !! where the problem begins
    character(len=*), intent(in) :: name       !! what stands there
    character(len=*), intent(in) :: found      !! its columns
    character(len=*), intent(in) :: expected   !! what is wanted

    call self%problems%add_at(line, column, &
                              name // ': found ''' // found // ''', expected ' // expected)
  end subroutine complain

  !> Reports the first byte that is no text. A carriage return is text only at the end of a line.
  subroutine check_bytes(self)
    class(card_reader), intent(inout) :: self  !! the cards
    integer :: i, code, line

    do i = 1, len(self%text)
      code = iachar(self%text(i:i))
      if (code >= 32 .and. code /= 127) cycle
      if (any(code == [9, 10])) cycle
      if (code == 13) then
        if (i == len(self%text)) cycle
        if (self%text(i + 1:i + 1) == achar(10)) cycle
      end if
      line = max(1, count(self%first <= i))
      call self%problems%add_at(line, i - self%first(line) + 1, 'not a text file: found byte ' // &
                                decimal_text(code) // ', expected a card deck')
      return
    end do
  end subroutine check_bytes

end module asperity_card_reader
