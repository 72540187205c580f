!> The header of a height map written as text: comments, names of columns, or the lines of a grid of
!> ESRI or Surfer in front of the numbers, with the units, width, height and edge that they give.
module asperity_text_header
  use asperity_column_names, only: column_list, columns_named, is_height_name
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_delimited_text, only: separator_of
  use asperity_height_map, only: edge_names, is_length, length_units, no_power, plain_unit, &
                                 read_height, unit_number
  use asperity_input_text, only: blanks, lower_case, in_quotes, without_blanks
  use asperity_kinds, only: int64, real64
  use asperity_numeral, only: read_numeral
  use asperity_problems, only: decimal_text, problem_list
  implicit none
  private

  public :: text_header, read_header, is_numeric_line, is_surface_header, head_length

  !> Bytes of a file's beginning that hold its whole header.
  integer, parameter :: head_length = 262144
  character(len=*), parameter :: comment_signs = '#%'
  integer, parameter :: unit_length = 16
  character(len=*), parameter :: axis(3) = ['x', 'y', 'z']
  character(len=*), parameter :: surface_names(3) = [character(len=6) :: 'x', 'y', 'height']
  !> Beginnings of the words for `length_units`, and of the first one once more.
  character(len=*), parameter :: unit_words(7) = [character(len=8) :: 'metre', 'millimet', &
    'micromet', 'nanomet', 'centimet', 'inch', 'meter']
  !> Surfer's height of a pixel that is missing, and all above it.
  real(real64), parameter :: surfer_blank = 1.70141e38_real64
  !> ESRI's where the header has none.
  real(real64), parameter :: esri_blank = -9999.0_real64
  ! Names of a grid of ESRI.
  character(len=*), parameter :: esri_names(10) = [character(len=12) :: 'ncols', 'nrows', &
    'cellsize', 'dx', 'dy', 'nodata_value', 'xllcorner', 'xllcenter', 'yllcorner', 'yllcenter']

  !> Values of the header, and what is wrong with it.
  type :: text_header
    type(problem_list) :: problems              !! units that contradict each other, and so on
    type(problem_list) :: notes                 !! what is not understood
    integer, private :: line = 0                ! that is being read
    integer :: first_line = 0                   !! line of the first number; 0: there is none
    integer :: names_line = 0                   !! line of the names x, y, z; 0: there is none
    integer :: place(3) = [1, 2, 3]             !! cells of x, y and z in a line of points
    integer :: cell_count = 3                   !! cells of a line of points
    character(len=unit_length) :: unit(3) = ''  !! of x, y and z as it is written; empty: none
    real(real64) :: extent(2) = 0.0_real64      !! width and height of the map, in `unit(1:2)`
    real(real64) :: extent_error(2) = 0.0_real64  !! half a unit of their last digit
    real(real64) :: pixel_spacing(2) = 0.0_real64  !! along x and y, in `unit(1:2)`; 0: not given
    integer :: edge = 0                         !! which of `edge_names`; 0: not given
    integer :: stated(2) = 0                    !! columns and rows; 0: not stated
    logical :: from_top = .false.               !! the first profile is that of the largest y
    real(real64) :: missing(2) = huge(1.0_real64)  !! heights in this range stand for missing ones
  contains
    procedure :: has_spacing  !! whether the spacing of a matrix follows from it
  end type text_header

contains

  !> Whether the spacing of a matrix follows from the header.
  pure logical function has_spacing(self)
    class(text_header), intent(in) :: self  !! that was read

    has_spacing = all(self%pixel_spacing > 0.0_real64) .or. all(self%extent > 0.0_real64)
  end function has_spacing

  !> Reads the lines in front of the first number: comments, the names x, y, z, or a grid's header.
  subroutine read_header(head, header, text)
    character(len=*), intent(in) :: head                !! the beginning of the file
    type(text_header), intent(inout) :: header          !! gets what they say
    character(len=:), allocatable, intent(out) :: text  !! the line behind them; empty: none
    type(column_list) :: found
    integer :: at, last, surfer_lines

    at = 1
    header%line = 0
    surfer_lines = 0
    do while (at <= len(head))
      header%line = header%line + 1
      last = at + scan(head(at:), achar(10) // achar(13)) - 2
      if (last < at - 1) last = len(head)
      text = without_blanks(head(at:last))
      at = last + 2
      if (index(head(last + 1:min(last + 2, len(head))), achar(13) // achar(10)) == 1) at = at + 1
      if (text == '') cycle
      if (scan(text(1:1), comment_signs) == 1) then
        call read_comment(header, without_blanks(text(verify(text // '.', comment_signs):)))
      else if (surfer_lines > 0 .or. text == 'DSAA') then
        if (surfer_lines > 0) call take_surfer_line(header, text, surfer_lines)
        surfer_lines = modulo(surfer_lines + 1, 5)
        if (header%problems%count() > 0) return
      else if (any(lower_case(text(:scan(text // ' ', blanks) - 1)) == esri_names)) then
        call take_esri_line(header, text)
      else
        found = columns_named(text)
        if (header%names_line > 0 .or. any(found%of_points() == 0) .or. &
            is_surface_header(text)) then
          header%first_line = header%line
          return
        end if
        call take_names(header, found)
        if (.not. is_height_name(trim(found%name(header%place(3))))) &
          call header%notes%add_at(header%line, 1, 'note: the heights are those of column ' // &
                           in_quotes(trim(found%name(header%place(3)))))
        if (header%cell_count > 3) &
          call header%notes%add_at(header%line, 1, 'note: ' // decimal_text(header%cell_count - &
               3) // ' more columns are not read')
      end if
    end do
    text = ''
  end subroutine read_header

  ! Line 2, 3, 4 or 5 of a grid of Surfer: columns and rows; ranges of x, y and z.
  subroutine take_surfer_line(header, text, number)
    type(text_header), intent(inout) :: header
    character(len=*), intent(in) :: text
    integer, intent(in) :: number
    real(real64) :: values(2)
    logical :: good

    call read_pair(text, values, good)
    if (number == 1) good = good .and. all(values > 1.0_real64) .and. all(values < huge(1)) .and. &
                            all(abs(values - anint(values)) <= 0.0_real64)
    if (number == 2 .or. number == 3) good = good .and. values(2) > values(1)
    if (.not. good) then
      call header%problems%add_at(header%line, 1, 'found ' // in_quotes(text) // ', expected ' // &
                         trim(merge('columns and rows, from 2', 'least and largest ' // &
                         axis(max(1, number - 1)) // '     ', number == 1)) // &
                         ' in the header of a grid of Surfer (DSAA)')
    else if (number == 1) then
      header%stated = nint(values)
      header%missing(1) = surfer_blank
    else if (number < 4) then
      header%pixel_spacing(number - 1) = (values(2) - values(1)) / (header%stated(number - 1) - 1)
    end if
  end subroutine take_surfer_line

  ! A line of the header of a grid of ESRI.
  subroutine take_esri_line(header, text)
    type(text_header), intent(inout) :: header
    character(len=*), intent(in) :: text
    type(decimal_value) :: decimal
    character(len=:), allocatable :: name, number, expected
    real(real64) :: value
    integer :: at
    logical :: good

    at = scan(text // ' ', blanks)
    name = lower_case(text(:at - 1))
    number = without_blanks(text(at:))
    call read_numeral(number, decimal, good)
    value = decimal_to_real64(decimal)
    expected = 'a number'
    header%from_top = .true.
    if (.not. header%missing(1) < huge(1.0_real64)) header%missing = esri_blank
    select case (name)
    case ('ncols', 'nrows')
      expected = 'a whole number from 1'
      good = good .and. value >= 1.0_real64 .and. value < huge(1) .and. decimal%power_of_ten >= 0
      if (good) header%stated(merge(1, 2, name == 'ncols')) = nint(value)
    case ('cellsize', 'dx', 'dy')
      expected = 'a length from 1e-30 to 1e30'
      good = good .and. is_length(value)
      if (good .and. name /= 'dy') header%pixel_spacing(1) = value
      if (good .and. name /= 'dx') header%pixel_spacing(2) = value
    case ('nodata_value')
      if (lower_case(number) == 'nan') return
      ! The least real of 32 bits has more digits in the header than in the data, or fewer.
      header%missing = value + abs(value) * 1.0e-6_real64 * [-1, 1]
      if (abs(value) < 1.0e30_real64) header%missing = value
    case default
      continue
    end select
    if (.not. good) &
      call header%problems%add_at(header%line, 1, name // ': found ' // in_quotes(number) // &
           ', expected ' // expected)
  end subroutine take_esri_line

  ! Two numbers between blanks or a comma.
  pure subroutine read_pair(text, values, good)
    character(len=*), intent(in) :: text
    real(real64), intent(out) :: values(2)
    logical, intent(out) :: good
    type(decimal_value) :: number
    character(len=:), allocatable :: rest
    integer :: at

    at = scan(text // ' ', blanks // ',')
    call read_numeral(text(:at - 1), number, good)
    values(1) = decimal_to_real64(number)
    rest = without_blanks(text(at + 1:))
    if (good) call read_numeral(rest, number, good)
    values(2) = decimal_to_real64(number)
  end subroutine read_pair

  !> Whether the first cell of a line is a number, or a word for a height.
  pure logical function is_numeric_line(text)
    character(len=*), intent(in) :: text  !! the line, or its beginning
    character(len=:), allocatable :: cell
    real(real64) :: height
    integer :: power

    cell = text(verify(text // '.', blanks // ',;'):)
    cell = lower_case(cell(:scan(cell // ' ', blanks // ',;') - 1))
    power = no_power
    call read_height(cell, height, is_numeric_line, power)
    if (cell /= '') cell = cell(merge(2, 1, scan(cell(1:1), '+-') == 1):)
    is_numeric_line = is_numeric_line .or. cell == 'inf' .or. cell == 'infinity'
  end function is_numeric_line

  !> Whether a line names the columns of a surface: x, y and height, not between blanks alone.
  pure logical function is_surface_header(text)
    character(len=*), intent(in) :: text  !! line without its end
    type(column_list) :: found
    integer :: i

    found = columns_named(text)
    is_surface_header = separator_of(text) /= ' ' .and. &
      all([(any(found%name == surface_names(i)), i=1, size(surface_names))])
  end function is_surface_header

  ! The names x, y, z, and their units.
  subroutine take_names(header, found)
    type(text_header), intent(inout) :: header
    type(column_list), intent(in) :: found

    header%names_line = header%line
    header%place = found%of_points()
    header%cell_count = size(found%name)
    call set_units(header, found%unit(header%place))
  end subroutine take_names

  ! Units of x, y and z, or blanks. None must differ from one that the header has already.
  subroutine set_units(header, units)
    type(text_header), intent(inout) :: header
    character(len=*), intent(in) :: units(3)
    integer :: i

    do i = 1, 3
      if (units(i) == '') cycle
      if (header%unit(i) /= '' .and. header%unit(i) /= units(i)) &
        call header%problems%add_at(header%line, 1, 'found ' // in_quotes(trim(units(i))) // &
             ' as the unit of ' // axis(i) // ' beside ' // in_quotes(trim(header%unit(i))) // &
             ' in a line before, expected one')
      header%unit(i) = units(i)
    end do
  end subroutine set_units

  ! A comment before the numbers: names of columns, or a statement `name: value`.
  subroutine read_comment(header, text)
    type(text_header), intent(inout) :: header
    character(len=*), intent(in) :: text
    type(column_list) :: found
    type(decimal_value) :: number
    character(len=:), allocatable :: name, value, unit
    character(len=unit_length) :: units(3)
    integer :: at, i, first, last, place(3)
    logical :: good

    found = columns_named(text)
    place = found%of_points()
    units = ''
    if (place(3) > 0) then
      if (is_height_name(trim(found%name(place(3)))) .and. .not. is_surface_header(text)) then
        call take_names(header, found)
        return
      end if
    else if (size(found%name) == 1) then
      if (found%unit(1) /= '' .and. is_height_name(trim(found%name(1)))) then
        units(3) = found%unit(1)
        call set_units(header, units)
        return
      end if
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
      call read_pair(value, header%pixel_spacing, good)
      if (good) good = all(is_length(header%pixel_spacing))
      if (good) return
      header%pixel_spacing = 0.0_real64
      call header%notes%add_at(header%line, 1, 'note: the spacing in ' // in_quotes(text) // &
           ' is not used, expected two numbers: spacing: X Y')
    case ('edge')
      header%edge = findloc(edge_names == lower_case(value), .true., 1)
      return
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
      units(first:last) = unit
    else
      units = units_in_words(text)
      if (all(units == '') .and. (has_unit(text) .or. name == 'width' .or. name == 'height')) &
        call header%notes%add_at(header%line, 1, 'note: the unit in ' // in_quotes(text) // &
             ' is not understood and not used')
    end if
    call set_units(header, units)
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

  ! The units of x, y and z in a comment without numbers: `heights in nm`, `x, y in um, z in nm`.
  ! Each is that of the names before it. `m` and `in` are units behind `in` or at the end of a
  ! clause. Empty: none, or names with two `in` before a unit: the first unit is not known.
  pure function units_in_words(text) result(unit)
    character(len=*), intent(in) :: text
    character(len=unit_length) :: unit(3)
    character(len=:), allocatable :: before, words, word
    integer :: at, k, prepositions
    logical :: are_named(3), is_clear, is_unit

    unit = ''
    words = plain_unit(lower_case(text))
    do at = 1, len(words)
      if (scan(words(at:at), '=/"''([-_') == 1) words(at:at) = ' '
      if (scan(words(at:at), ',;:)]') == 1) words(at:at) = ';'
    end do
    words = words(verify(words // '.', blanks // ';'):)
    word = ''
    are_named = .false.
    is_clear = .true.
    prepositions = 0
    do while (words /= '' .and. scan(text, '0123456789') == 0)
      before = word
      at = scan(words // ' ', blanks // ';')
      word = words(:at - 1)
      words = without_blanks(words(at:))
      are_named = are_named .or. [any(word == ['x ', 'xy']), any(word == ['y ', 'xy']), &
                                  is_height_name(word)]
      is_unit = unit_number(word) > 0
      if (word == 'm' .or. word == 'in') is_unit = any(are_named) .and. &
        (before == 'in' .or. verify(words(:min(1, len(words))), ';') == 0)
      words = words(verify(words // '.', blanks // ';'):)
      at = findloc([(index(word, trim(unit_words(k))) == 1, k=1, size(unit_words))], .true., 1)
      if (at > 0) word = trim(length_units(mod(at - 1, size(length_units)) + 1))
      if (word == 'in' .and. .not. is_unit) prepositions = prepositions + 1
      if (.not. (is_unit .or. at > 0)) cycle
      is_clear = is_clear .and. any(are_named) .and. all(unit == '' .or. .not. are_named) .and. &
                 prepositions < 2
      where (are_named) unit = word
      are_named = .false.
      prepositions = 0
    end do
    if (any(are_named) .or. .not. is_clear) unit = ''
  end function units_in_words

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
                                  index(words, ' mm '), index(words, ' cm '), &
                                  index(words, ' in m '), index(words, ' in in ')] > 0) .or. &
               any([(index(words, ' ' // trim(unit_words(i))) > 0, i=1, size(unit_words))])
  end function has_unit

end module asperity_text_header
