!> The cards of the original program: the table of their fields, and the text of a deck as cards,
!> with the numbers in their fields and problems with their places.
!>
!> A field is read by the rules of FORTRAN IV: blanks after the first digit are zeros, a field
!> without a decimal point has an implied one, and an exponent may follow, with `E`, `D` or its sign
!> alone.
module asperity_card_reader
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_input_text, only: line_end
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text, problem_list
  implicit none
  private

  public :: card_length, card_reader, deck_field, deck_fields, read_f_field, read_i_field
  public :: count_field, radius_field, height_max_field, modulus_field, ratio_field, stress_field, &
            width_field, angle_field, shift_field, x_field, y_field, z_field

  integer, parameter :: most_digits = 18, largest_exponent = 9999
  character(len=*), parameter :: digit_characters = '0123456789'

  !> A field of a card, as the original names it; in a symbol U or L, of a model, stands for `*`.
  type :: deck_field
    character(len=6) :: symbol            !! of the number
    character(len=24) :: meaning          !! of the number, for a message
    integer :: first, last                !! columns
    integer :: decimals                   !! digits behind the implied point
    logical :: is_positive = .false.      !! the number is more than 0
  end type deck_field

  !> Places in `deck_fields` of what cards 2 and 3 have of a model.
  integer, parameter :: count_field = 1, radius_field = 2, height_max_field = 3, modulus_field = 4
  !> Further fields of cards 2, 3 and 4.
  integer, parameter :: ratio_field = 5, stress_field = 6, width_field = 7
  !> Angles of both models, displacements along x and y.
  integer, parameter :: angle_field(2) = [8, 9], shift_field(2) = [10, 11]
  !> Position and height of an asperity.
  integer, parameter :: x_field = 12, y_field = 13, z_field = 14
  !> All fields, in inches, psi and radians.
  type(deck_field), parameter :: deck_fields(14) = [ &
    deck_field('N*', 'number of asperities', 1, 5, 0), &
    deck_field('R*', 'summit radius', 6, 10, 3, .true.), &
    deck_field('Z*MAX', 'greatest height', 11, 15, 3), &
    deck_field('E*', 'elastic modulus', 16, 25, 0, .true.), &
    deck_field('MU*', 'Poisson''s ratio', 26, 30, 3), &
    deck_field('ELIMT*', 'allowed stress', 31, 40, 0), &
    deck_field('WIDTHL', 'width of the lower model', 41, 47, 4, .true.), &
    deck_field('THETAU', 'angle of the upper model', 1, 8, 4), &
    deck_field('THETAL', 'angle of the lower model', 9, 16, 4), &
    deck_field('XDISPL', 'x displacement', 17, 23, 3), &
    deck_field('YDISPL', 'y displacement', 24, 30, 3), &
    deck_field('x', '', 1, 6, 3), deck_field('y', '', 7, 12, 3), &
    deck_field('height', '', 13, 19, 4)]

  integer, parameter :: card_length = 80  !! columns of a card

  integer, parameter :: text_length = 72  ! columns before a card's sequence number

  !> The cards of a file, and what is found wrong with them.
  type :: card_reader
    private
    character(len=:), allocatable :: text
    integer, allocatable :: first(:), last(:)   ! of every line, line end excluded
    type(problem_list), public :: problems      !! what is wrong with the deck
    type(problem_list), public :: unchecked     !! what is wrong, and the original did not check
  contains
    procedure :: take_text     !! takes the text of a deck
    procedure :: card_columns  !! the columns of a card
    procedure :: has_text      !! whether a card holds more than blanks and a sequence number
    procedure :: last_card     !! the last line that is a card
    procedure :: real_field    !! reads a number under F format
    procedure :: require_card  !! reports a problem when a card is missing
    procedure :: refuse_field  !! reports a problem of a field
  end type card_reader

contains

  !> Takes the text of a deck. A carriage return before a line feed belongs to the line end.
  subroutine take_text(self, file, text)
    class(card_reader), intent(out) :: self    !! cards of the deck
    character(len=*), intent(in) :: file       !! name for the messages
    character(len=*), intent(in) :: text       !! the whole deck
    integer :: i, number, begin

    call self%problems%start(file)
    call self%unchecked%start(file)
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
  end subroutine take_text

  !> The 80 columns of a card; a card that is not there is blank.
  pure function card_columns(self, line) result(columns)
    class(card_reader), intent(in) :: self  !! cards of the deck
    integer, intent(in) :: line             !! its line, from 1
    character(len=card_length) :: columns   !! what stands there

    columns = ''
    if (line > size(self%first)) return
    columns = self%text(self%first(line):self%last(line))
  end function card_columns

  !> Whether a card holds more than blanks and a sequence number.
  pure logical function has_text(self, line)
    class(card_reader), intent(in) :: self  !! cards of the deck
    integer, intent(in) :: line             !! its line, from 1
    character(len=card_length) :: columns

    columns = self%card_columns(line)
    has_text = verify(columns(:text_length), ' ' // achar(9)) > 0
  end function has_text

  !> The last line that is a card; 0 when none is. Blank lines at the end are none: they must not
  !> stand in for cards that are missing.
  pure integer function last_card(self)
    class(card_reader), intent(in) :: self  !! cards of the deck

    do last_card = size(self%first), 1, -1
      if (self%has_text(last_card)) return
    end do
  end function last_card

  !> Reads a field under F format; reports a problem when it holds no finite number, or none above
  !> zero where the field needs that.
  subroutine real_field(self, line, field, whose, value)
    class(card_reader), intent(inout) :: self   !! cards of the deck
    integer, intent(in) :: line                 !! the card's line, from 1
    integer, intent(in) :: field                !! which of `deck_fields`
    character(len=*), intent(in) :: whose       !! U, L, or the asperity
    type(decimal_value), intent(out) :: value   !! the number; zero when it is none
    type(deck_field) :: place
    character(len=card_length) :: columns
    integer :: bad_at

    columns = self%card_columns(line)
    place = deck_fields(field)
    call read_f_field(columns(place%first:place%last), place%decimals, value, bad_at)
    if (bad_at > 0) then
      call self%refuse_field(line, field, whose, 'a number in columns ' // &
                             decimal_text(place%first) // '-' // decimal_text(place%last) // &
                             ' (F' // decimal_text(place%last - place%first + 1) // '.' // &
                             decimal_text(place%decimals) // ')', bad_at)
      value = decimal_value()
    else if (abs(decimal_to_real64(value)) > huge(1.0_real64)) then
      call self%refuse_field(line, field, whose, 'a finite number')
      value = decimal_value()
    else if (place%is_positive .and. value%all_digits <= 0) then
      call self%refuse_field(line, field, whose, 'more than zero')
    end if
  end subroutine real_field

  !> Reports a problem when the deck ends before card `line`.
  subroutine require_card(self, line, names, complete)
    class(card_reader), intent(inout) :: self  !! cards of the deck
    integer, intent(in) :: line                !! the card's line, from 1
    character(len=*), intent(in) :: names      !! what it holds, for the message
    logical, intent(inout) :: complete         !! made false when the card is missing

    if (line <= size(self%first)) return
    complete = .false.
    call self%problems%add_at(line, 1, 'card ' // decimal_text(line) // &
                              ' is missing: found the end of the deck, expected ' // names)
  end subroutine require_card

  !> Reports `FILE:LINE:COLUMN: NAME: found '...', expected ...`.
  subroutine refuse_field(self, line, field, whose, expected, bad_at, unchecked)
    class(card_reader), intent(inout) :: self    !! cards of the deck
    integer, intent(in) :: line                  !! the card's line, from 1
    integer, intent(in) :: field                 !! which of `deck_fields`
    character(len=*), intent(in) :: whose        !! U, L, or the asperity
    character(len=*), intent(in) :: expected     !! what is expected in it
    integer, intent(in), optional :: bad_at      !! column of the field; absent: the first
    logical, intent(in), optional :: unchecked   !! present: the original program did not check it
    type(deck_field) :: place
    character(len=:), allocatable :: name
    character(len=card_length) :: columns
    integer :: column, star

    columns = self%card_columns(line)
    place = deck_fields(field)
    column = place%first
    if (present(bad_at)) column = column + bad_at - 1
    name = trim(place%symbol)
    star = index(name, '*')
    if (star > 0) name = name(:star - 1) // whose // name(star + 1:)
    if (place%meaning == '') name = name // ' of ' // whose
    if (place%meaning /= '') name = name // ' (' // trim(place%meaning) // ')'
    name = name // ': found ''' // columns(place%first:place%last) // ''', expected ' // expected
    if (present(unchecked)) then
      call self%unchecked%add_at(line, column, name)
    else
      call self%problems%add_at(line, column, name)
    end if
  end subroutine refuse_field

  !> Reads a field under `Fw.d`.
  pure subroutine read_f_field(field, implied_decimals, value, bad_at)
    character(len=*), intent(in) :: field        !! the w columns
    integer, intent(in) :: implied_decimals      !! d: digits behind the implied point
    type(decimal_value), intent(out) :: value    !! the number, exactly
    integer, intent(out) :: bad_at               !! 0, or the first column that is wrong
    integer :: i, digit, power, exponent_sign, behind_point, significant
    logical :: negative, after_point, started, digit_seen, in_exponent, exponent_digit

    value = decimal_value()
    bad_at = 0
    negative = .false.
    after_point = .false.
    started = .false.
    digit_seen = .false.
    in_exponent = .false.
    exponent_digit = .false.
    power = 0
    exponent_sign = 1
    behind_point = 0
    significant = 0
    do i = 1, len(field)
      digit = index(digit_characters, field(i:i)) - 1
      if (field(i:i) == ' ') then
        if (.not. started) cycle
        ! A blank between the exponent's letter and its digits stands for nothing.
        if (in_exponent .and. .not. exponent_digit) cycle
        digit = 0
      end if
      if (digit >= 0) then
        started = .true.
        digit_seen = .true.
        if (in_exponent) then
          power = min(10 * power + digit, largest_exponent)
          exponent_digit = .true.
        else if (significant >= most_digits) then
          bad_at = i
          return
        else
          value%all_digits = 10_int64 * value%all_digits + int(digit, int64)
          if (value%all_digits > 0_int64) significant = significant + 1
          if (after_point) behind_point = behind_point + 1
        end if
      else
        select case (field(i:i))
        case ('.')
          if (after_point .or. in_exponent) bad_at = i
          after_point = .true.
          started = .true.
        case ('+', '-')
          if (.not. started) then
            negative = field(i:i) == '-'
            started = .true.
          else if (exponent_digit .or. .not. digit_seen .or. len_trim(field(:i - 1)) == &
                   scan(field(:i - 1), '+-', back=.true.)) then
            bad_at = i
          else
            in_exponent = .true.
            exponent_sign = merge(-1, 1, field(i:i) == '-')
          end if
        case ('E', 'D', 'e', 'd')
          if (in_exponent .or. .not. digit_seen) bad_at = i
          in_exponent = .true.
        case default
          bad_at = i
        end select
        if (bad_at > 0) return
      end if
    end do
    if (in_exponent .and. .not. exponent_digit) bad_at = len(field)
    ! A sign or a point without a digit.
    if (scan(field, digit_characters) == 0 .and. field /= '') bad_at = verify(field, ' ')
    if (negative) value%all_digits = -value%all_digits
    if (.not. after_point) behind_point = implied_decimals
    value%power_of_ten = exponent_sign * power - behind_point
  end subroutine read_f_field

  !> Reads a field under `Iw`; the largest accepted magnitude is that of the default integer.
  pure subroutine read_i_field(field, value, bad_at)
    character(len=*), intent(in) :: field  !! the w columns
    integer, intent(out) :: value          !! the number read, 0 when none is
    integer, intent(out) :: bad_at         !! 0, or the first column that is wrong
    type(decimal_value) :: number
    integer :: first

    value = 0
    first = verify(field, ' ')
    if (first == 0) then
      bad_at = 0
      return
    end if
    bad_at = first
    if (scan(field(first:first), '+-' // digit_characters) == 0) return
    bad_at = verify(field(first + 1:), ' ' // digit_characters)
    if (bad_at > 0) then
      bad_at = bad_at + first
      return
    end if
    call read_f_field(field, 0, number, bad_at)
    if (abs(number%all_digits) > int(huge(value), int64)) bad_at = first
    if (bad_at == 0) value = int(number%all_digits)
  end subroutine read_i_field

end module asperity_card_reader
