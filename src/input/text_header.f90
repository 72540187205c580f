!> The header of a height map written as text: comments and names of columns in front of the
!> numbers, with the units, width and height that they give.
module asperity_text_header
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_height_map, only: is_length, plain_unit, unit_number
  use asperity_input_text, only: blanks, lower_case, in_quotes, text_start
  use asperity_kinds, only: int64, real64
  use asperity_numeral, only: read_numeral
  use asperity_problems, only: problem_list
  implicit none
  private

  public :: text_header, read_header, is_numeric_line, is_surface_header, head_length

  !> Bytes of a file's beginning that hold its whole header.
  integer, parameter :: head_length = 262144
  character(len=*), parameter :: comment_signs = '#%'
  integer, parameter :: unit_length = 16, most_names = 4
  character(len=*), parameter :: axis(3) = ['x', 'y', 'z']

  !> Values of the header.
  type :: text_header
    integer :: first_line = 0                   !! line of the first number; 0: there is none
    integer :: names_line = 0                   !! line of the names x, y, z; 0: there is none
    character(len=unit_length) :: unit(3) = ''  !! of x, y and z as it is written; empty: none
    real(real64) :: extent(2) = 0.0_real64      !! width and height of the map, in `unit(1:2)`
    real(real64) :: extent_error(2) = 0.0_real64  !! half a unit of their last digit
    real(real64) :: pixel_spacing(2) = 0.0_real64  !! along x and y, in `unit(1:2)`; 0: not given
  contains
    procedure :: has_spacing  !! whether the spacing of a matrix follows from it
  end type text_header

  !> Names of columns with their units.
  type :: column_list
    integer :: name_count = 0
    character(len=unit_length) :: name(most_names) = '', unit(most_names) = ''
  end type column_list

contains

  !> Whether the spacing of a matrix follows from the header.
  pure logical function has_spacing(self)
    class(text_header), intent(in) :: self  !! that was read

    has_spacing = all(self%pixel_spacing > 0.0_real64) .or. all(self%extent > 0.0_real64)
  end function has_spacing

  !> Reads the lines in front of the first number: comments, and the names x, y, z.
  subroutine read_header(head, header, text, problems, notes)
    character(len=*), intent(in) :: head                !! the beginning of the file
    type(text_header), intent(inout) :: header          !! gets what they say
    character(len=:), allocatable, intent(out) :: text  !! the line behind them; empty: none
    type(problem_list), intent(inout) :: problems       !! units that contradict each other
    type(problem_list), intent(inout) :: notes          !! what is not understood
    integer :: at, last, line

    text = ''
    at = text_start(head)
    line = 0
    do while (at <= len(head))
      line = line + 1
      last = at + scan(head(at:), achar(10) // achar(13)) - 2
      if (last < at - 1) last = len(head)
      text = without_blanks(head(at:last))
      at = last + 2
      if (index(head(last + 1:min(last + 2, len(head))), achar(13) // achar(10)) == 1) at = at + 1
      if (text == '') cycle
      if (scan(text(1:1), comment_signs) == 1) then
        call read_comment(without_blanks(text(verify(text // '.', comment_signs):)), line, header, &
                          problems, notes)
      else if (header%names_line == 0 .and. names_points(text)) then
        call take_names(columns_named(text), line, header, problems)
      else
        header%first_line = line
        return
      end if
    end do
    text = ''
  end subroutine read_header

  ! Text without blanks and tabulators around it.
  pure function without_blanks(text) result(inner)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: inner
    integer :: first

    first = verify(text, blanks)
    inner = ''
    if (first > 0) inner = text(first:verify(text, blanks, back=.true.))
  end function without_blanks

  !> Whether the first cell of a line is a number, or a word for a height.
  pure logical function is_numeric_line(text)
    character(len=*), intent(in) :: text  !! the line, or its beginning
    character(len=:), allocatable :: cell
    type(decimal_value) :: value

    cell = text(verify(text // '.', blanks // ',;'):)
    cell = lower_case(cell(:scan(cell // ' ', blanks // ',;#') - 1))
    call read_numeral(cell, value, is_numeric_line)
    if (cell /= '') cell = cell(merge(2, 1, scan(cell(1:1), '+-') == 1):)
    is_numeric_line = is_numeric_line .or. any(cell == [character(len=8) :: 'nan', 'bad', 'inf', &
                                                        'infinity'])
  end function is_numeric_line

  !> Whether a line names the columns of a surface: x, y and height, not between blanks alone.
  pure logical function is_surface_header(text)
    character(len=*), intent(in) :: text  !! line without its end
    type(column_list) :: found

    found = columns_named(text)
    is_surface_header = any(found%name == 'x') .and. any(found%name == 'y') .and. &
                        any(found%name == 'height') .and. scan(text, ',;' // achar(9)) > 0
  end function is_surface_header

  ! Whether a line names the columns of x,y,z lines.
  pure logical function names_points(text)
    character(len=*), intent(in) :: text
    type(column_list) :: found

    found = columns_named(text)
    names_points = found%name_count >= 3 .and. all(found%name(:2) == axis(:2)) .and. &
                   any(found%name(3) == [character(len=6) :: 'z', 'height', 'value']) .and. &
                   .not. (is_surface_header(text) .or. any(found%name == 'radius'))
  end function names_points

  ! The names in a line: words, between quotes or not, each perhaps with a unit in brackets.
  pure function columns_named(text) result(found)
    character(len=*), intent(in) :: text
    type(column_list) :: found
    character(len=*), parameter :: between = blanks // ',;"'''
    integer :: at, last

    at = 1
    do
      at = at + verify(text(min(at, len(text) + 1):) // '.', between) - 1
      ! A line of many names: flang-19 keeps the text of every turn on the stack.
      if (at > len(text) .or. found%name_count > most_names) return
      if (scan(text(at:at), '[(') == 1 .and. found%name_count > 0) then
        last = at + scan(text(at:) // ']', '])') - 1
        if (found%name_count <= most_names) found%unit(found%name_count) = plain_unit(text(at + &
          1:last - 1))
        at = last + 1
      else
        last = at + scan(text(at + 1:) // ' ', between // '[(') - 1
        found%name_count = found%name_count + 1
        if (found%name_count <= most_names) found%name(found%name_count) = lower_case(text(at:last))
        at = last + 1
      end if
    end do
  end function columns_named

  ! The names x, y, z, and their units.
  subroutine take_names(found, line, header, problems)
    type(column_list), intent(in) :: found
    integer, intent(in) :: line
    type(text_header), intent(inout) :: header
    type(problem_list), intent(inout) :: problems
    integer :: i

    header%names_line = line
    do i = 1, 3
      call set_unit(i, found%unit(i), line, header, problems)
    end do
  end subroutine take_names

  ! A unit of x, y or z. It must not differ from one that the header has already.
  subroutine set_unit(i, unit, line, header, problems)
    integer, intent(in) :: i, line
    character(len=*), intent(in) :: unit
    type(text_header), intent(inout) :: header
    type(problem_list), intent(inout) :: problems

    if (unit == '') return
    if (header%unit(i) /= '' .and. header%unit(i) /= unit) &
      call problems%add_at(line, 1, 'found ' // in_quotes(trim(unit)) // ' as the unit of ' // &
                           axis(i) // ' beside ' // in_quotes(trim(header%unit(i))) // &
                           ' in a line before, expected one')
    header%unit(i) = unit
  end subroutine set_unit

  ! A comment before the numbers: names of columns, or a statement `name: value`.
  subroutine read_comment(text, line, header, problems, notes)
    character(len=*), intent(in) :: text
    integer, intent(in) :: line
    type(text_header), intent(inout) :: header
    type(problem_list), intent(inout) :: problems, notes
    type(column_list) :: found
    type(decimal_value) :: number
    character(len=:), allocatable :: name, value, unit
    integer :: at, i, first, last
    logical :: good

    found = columns_named(text)
    if (names_points(text)) then
      call take_names(found, line, header, problems)
      return
    else if (found%name_count == 1 .and. found%unit(1) /= '' .and. &
             any(found%name(1) == [character(len=7) :: 'z', 'height', 'heights', 'value'])) then
      call set_unit(3, trim(found%unit(1)), line, header, problems)
      return
    end if
    at = scan(text, ':=')
    name = lower_case(without_blanks(text(:at - 1)))
    value = without_blanks(text(at + 1:))
    first = 1
    last = 0
    select case (name)
    case ('width', 'height')
      i = merge(1, 2, name == 'width')
      at = scan(value // ' ', blanks // '[(')
      unit = bare_unit(value(at:))
      call read_numeral(value(:at - 1), number, good)
      if (good .and. number%all_digits > 0_int64 .and. unit_number(unit) > 0) then
        header%extent(i) = decimal_to_real64(number)
        header%extent_error(i) = 0.5_real64 * 10.0_real64**number%power_of_ten
        first = i
        last = i
      end if
    case ('spacing')
      at = scan(value // ' ', blanks // ',')
      call read_numeral(value(:at - 1), number, good)
      header%pixel_spacing(1) = decimal_to_real64(number)
      value = without_blanks(value(at + 1:))
      if (good) call read_numeral(value, number, good)
      header%pixel_spacing(2) = decimal_to_real64(number)
      if (good) good = all(is_length(header%pixel_spacing))
      if (good) return
      header%pixel_spacing = 0.0_real64
      call notes%add_at(line, 1, 'note: the spacing in ' // in_quotes(text) // ' is not used, ' // &
                        'expected two numbers: spacing: X Y')
    case ('value units', 'value unit', 'z units', 'z unit', 'height units', 'height unit')
      first = 3
      last = 3
    case ('xy units', 'xy unit', 'lateral units', 'lateral unit')
      last = 2
    case ('units', 'unit', 'length units', 'length unit')
      last = 3
    case default
      continue
    end select
    if (last > 0) then
      if (.not. allocated(unit)) unit = bare_unit(value)
      do i = first, last
        call set_unit(i, unit, line, header, problems)
      end do
    else if (has_unit(text) .or. name == 'width' .or. name == 'height') then
      call notes%add_at(line, 1, 'note: the unit in ' // in_quotes(text) // &
                        ' is not understood and not used')
    end if
  end subroutine read_comment

  ! The name of a unit without brackets.
  pure function bare_unit(text) result(unit)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: unit

    unit = without_blanks(text)
    if (scan(unit, '[(') == 1) unit = unit(2:scan(unit // ']', '])') - 1)
    unit = plain_unit(unit)
    unit = unit(:min(len(unit), unit_length))
  end function bare_unit

  ! Whether a comment speaks of a unit of length: a word, for `m` and `in` between brackets.
  pure logical function has_unit(text)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: words
    integer :: i

    words = ' ' // plain_unit(lower_case(text)) // ' '
    has_unit = index(words, 'unit') > 0 .or. scan(words, '[') > 0 .or. &
               any([index(words, '(m)'), index(words, '(in)')] > 0)
    do i = 1, len(words)
      if (verify(words(i:i), ',;:=/"''()') == 0) words(i:i) = ' '
    end do
    has_unit = has_unit .or. any([index(words, ' um '), index(words, ' nm '), &
                                  index(words, ' mm '), index(words, ' cm ')] > 0)
  end function has_unit

end module asperity_text_header
