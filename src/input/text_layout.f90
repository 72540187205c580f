!> Layout of a height map written as text, found before a number of it is read: lines in front of
!> the numbers, what separates cells, how many lines and columns there are, units of the header.
!>
!> The layout is refused where it can be read in two ways.
module asperity_text_layout
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_height_map, only: number_text, plain_unit, unit_number
  use asperity_input_text, only: blanks, lower_case, quoted, text_start
  use asperity_kinds, only: int64, real64
  use asperity_numeral, only: read_numeral
  use asperity_problems, only: decimal_text, problem_list
  use asperity_token_reader, only: token_reader
  implicit none
  private

  public :: text_layout, find_layout, read_front, is_numeric_line, is_surface_header, head_length

  !> Bytes of a file's beginning that tell what it is, with all lines in front of the numbers.
  integer, parameter :: head_length = 262144
  character(len=*), parameter :: comment_signs = '#%'
  integer, parameter :: unit_length = 16, most_names = 4
  character(len=*), parameter :: axis(3) = ['x', 'y', 'z']

  !> What is known of the text.
  type :: text_layout
    integer :: first_line = 0                   !! line of the first number; 0: there is none
    integer :: names_line = 0                   !! line of the names x, y, z; 0: there is none
    integer(int64) :: lines = 0_int64           !! lines of numbers
    integer :: columns = 0                      !! cells of the first line of numbers
    integer :: gap_line = 0                     !! empty, or a comment, between numbers; 0: none
    logical :: decimal_comma = .false.          !! a comma stands before decimals
    character(len=1) :: cell_end = ' '          !! what separates cells
    character(len=unit_length) :: unit(3) = ''  !! of x, y and z as the header has them; empty: none
    real(real64) :: extent(2) = 0.0_real64      !! width and height of the map, in `unit(1:2)`
    real(real64) :: extent_error(2) = 0.0_real64  !! half a unit of their last digit
  end type text_layout

  !> Names of columns with their units.
  type :: column_list
    integer :: count = 0
    character(len=unit_length) :: name(most_names) = '', unit(most_names) = ''
  end type column_list

  ! What a byte is, and what stands between two cells.
  integer, parameter :: a_blank = 1, a_tab = 2, a_comma = 3, a_semicolon = 4, a_decimal_comma = 5, &
    a_feed = 6, a_return = 7, a_hash = 8, a_point = 9, a_sign = 10, a_digit = 11, a_letter = 12
  character(len=*), parameter :: gap_names(4) = [character(len=11) :: 'a blank', 'a tabulator', &
    'a comma', 'a semicolon']

  !> What the cells of the whole text have in common.
  type :: cell_counts
    integer(int64) :: gaps(5) = 0_int64       ! of each kind
    integer :: line(5) = 0, column(5) = 0     ! the first of each
    integer(int64) :: ended(5) = 0_int64      ! lines that end with a separator
    logical :: point = .false.                ! there is a decimal point
    logical :: spaced_comma = .false.         ! blanks stand beside a comma
    logical :: two_commas = .false.           ! digits,digits,digits
    logical :: surely_decimal = .false.       ! no thousands: 0,25 or 12,3456
    integer :: least(0:1) = huge(0), most(0:1) = 0  ! digits of even and odd cells
    logical :: signed(0:1) = .false., zero_first(0:1) = .false.
    integer :: commas = 0                     ! between digits, in the first line of numbers
  end type cell_counts

contains

  !> Finds the layout. What is not understood of the header is noted.
  subroutine find_layout(file, layout, problems, notes)
    type(token_reader), intent(inout) :: file      !! opened
    type(text_layout), intent(out) :: layout       !! what was found
    type(problem_list), intent(inout) :: problems  !! what can be read in two ways
    type(problem_list), intent(inout) :: notes     !! names the same file
    type(cell_counts) :: counts
    character(len=:), allocatable :: head, text

    call file%again()
    call file%take(head_length, head)
    call read_front(head, layout, text, problems, notes)
    if (layout%first_line == 0) return
    if (is_surface_header(text)) &
      call problems%add_at(layout%first_line, 1, 'found a surface: name it in &surfaces of a ' // &
                           'scene; expected a height map, with z for height if this is one')
    call file%start('', '')
    call file%again()
    call file%skip_to(layout%first_line)
    call count_cells(file, layout, counts, problems)
    call choose_separator(layout, counts, problems, notes)
  end subroutine find_layout

  !> Reads the lines in front of the first number: comments, and the names x, y, z.
  subroutine read_front(head, layout, text, problems, notes)
    character(len=*), intent(in) :: head                !! the beginning of the file
    type(text_layout), intent(inout) :: layout          !! gets what they say
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
      text = trimmed(head(at:last))
      at = last + 2
      if (index(head(last + 1:min(last + 2, len(head))), achar(13) // achar(10)) == 1) at = at + 1
      if (text == '') cycle
      if (scan(text(1:1), comment_signs) == 1) then
        call read_comment(trimmed(text(verify(text // '.', comment_signs):)), line, layout, &
                          problems, notes)
      else if (layout%names_line == 0 .and. names_points(text)) then
        call take_names(columns_named(text), line, layout, problems)
      else
        layout%first_line = line
        return
      end if
    end do
    text = ''
  end subroutine read_front

  ! Text without blanks and tabulators around it.
  pure function trimmed(text) result(inner)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: inner
    integer :: first

    first = verify(text, blanks)
    inner = ''
    if (first > 0) inner = text(first:verify(text, blanks, back=.true.))
  end function trimmed

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
    character(len=*), intent(in) :: text  !! the line
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
    names_points = found%count >= 3 .and. all(found%name(:2) == axis(:2)) .and. &
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
      if (at > len(text)) return
      if (scan(text(at:at), '[(') == 1 .and. found%count > 0) then
        last = at + scan(text(at:) // ']', '])') - 1
        if (found%count <= most_names) found%unit(found%count) = plain_unit(text(at + 1:last - 1))
        at = last + 1
      else
        last = at + scan(text(at + 1:) // ' ', between // '[(') - 1
        found%count = found%count + 1
        if (found%count <= most_names) found%name(found%count) = lower_case(text(at:last))
        at = last + 1
      end if
    end do
  end function columns_named

  ! The names x, y, z, and their units.
  subroutine take_names(found, line, layout, problems)
    type(column_list), intent(in) :: found
    integer, intent(in) :: line
    type(text_layout), intent(inout) :: layout
    type(problem_list), intent(inout) :: problems
    integer :: i

    layout%names_line = line
    do i = 1, 3
      call set_unit(i, found%unit(i), line, layout, problems)
    end do
  end subroutine take_names

  ! A unit of x, y or z. It must not differ from one that the header has already.
  subroutine set_unit(i, unit, line, layout, problems)
    integer, intent(in) :: i, line
    character(len=*), intent(in) :: unit
    type(text_layout), intent(inout) :: layout
    type(problem_list), intent(inout) :: problems

    if (unit == '') return
    if (layout%unit(i) /= '' .and. layout%unit(i) /= unit) &
      call problems%add_at(line, 1, 'found ' // quoted(trim(unit)) // ' as the unit of ' // &
                           axis(i) // ' beside ' // quoted(trim(layout%unit(i))) // &
                           ' in a line before, expected one')
    layout%unit(i) = unit
  end subroutine set_unit

  ! A comment before the numbers: names of columns, or a statement `name: value`.
  subroutine read_comment(text, line, layout, problems, notes)
    character(len=*), intent(in) :: text
    integer, intent(in) :: line
    type(text_layout), intent(inout) :: layout
    type(problem_list), intent(inout) :: problems, notes
    type(column_list) :: found
    type(decimal_value) :: number
    character(len=:), allocatable :: name, value, unit
    integer :: at, i, first, last
    logical :: good

    found = columns_named(text)
    if (names_points(text)) then
      call take_names(found, line, layout, problems)
      return
    else if (found%count == 1 .and. found%unit(1) /= '' .and. &
             any(found%name(1) == [character(len=7) :: 'z', 'height', 'heights', 'value'])) then
      call set_unit(3, trim(found%unit(1)), line, layout, problems)
      return
    end if
    at = scan(text, ':=')
    name = lower_case(trimmed(text(:at - 1)))
    value = trimmed(text(at + 1:))
    first = 1
    last = 0
    select case (name)
    case ('width', 'height')
      i = merge(1, 2, name == 'width')
      at = scan(value // ' ', blanks // '[(')
      unit = bare_unit(value(at:))
      call read_numeral(value(:at - 1), number, good)
      if (good .and. number%digits > 0_int64 .and. unit_number(unit) > 0) then
        layout%extent(i) = decimal_to_real64(number)
        layout%extent_error(i) = 0.5_real64 * 10.0_real64**number%exponent
        first = i
        last = i
      end if
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
        call set_unit(i, unit, line, layout, problems)
      end do
    else if (has_unit(text) .or. name == 'width' .or. name == 'height') then
      call notes%add_at(line, 1, 'note: the unit in ' // quoted(text) // ' is not understood ' // &
                        'and not used')
    end if
  end subroutine read_comment

  ! The name of a unit without brackets.
  pure function bare_unit(text) result(unit)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: unit

    unit = trimmed(text)
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

  ! Counts lines and cells, and what stands between them.
  subroutine count_cells(file, layout, counts, problems)
    type(token_reader), intent(inout) :: file
    type(text_layout), intent(inout) :: layout
    type(cell_counts), intent(out) :: counts
    type(problem_list), intent(inout) :: problems
    integer :: class_of(0:255), code, before, line, i
    integer(int64) :: line_begin
    integer :: cells, gap_line, gap_place, digits, digits_before, first_digit, first_before
    integer(int64) :: gap(5)
    logical :: inside, comment, whole, digit_last, signed, after_comma

    class_of = a_letter
    class_of([iachar(' '), 9, iachar(','), iachar(';'), 10, 13, iachar('#'), iachar('%'), &
              iachar('.'), iachar('+'), iachar('-')]) = [a_blank, a_tab, a_comma, a_semicolon, &
              a_feed, a_return, a_hash, a_hash, a_point, a_sign, a_sign]
    class_of(iachar('0'):iachar('9')) = a_digit
    line = layout%first_line
    line_begin = file%before + int(file%at, int64) - 1_int64
    gap_line = 0
    before = a_feed
    digits_before = 0
    first_before = 0
    call begin_line()
    do
      if (file%at > file%used) call file%more()
      if (file%at > file%used) exit
      i = iachar(file%block(file%at:file%at))
      file%at = file%at + 1
      code = class_of(i)
      if (comment .and. code /= a_feed .and. code /= a_return) cycle
      ! A per cent sign is one of a comment at the beginning of a line alone.
      if (code == a_hash .and. i == iachar('%') .and. cells > 0) code = a_letter
      if (code >= a_point) then
        if (.not. inside) call begin_cell()
        digit_last = code == a_digit
        if (digit_last) then
          if (digits == 0) first_digit = i - iachar('0')
          if (whole) digits = digits + 1
        else if (code == a_sign .and. digits == 0) then
          signed = .true.
        else
          whole = .false.
          if (code == a_point) counts%point = .true.
        end if
      else
        if (inside) call end_cell()
        select case (code)
        case (a_feed, a_return)
          if (.not. (code == a_feed .and. before == a_return)) then
            call end_line()
            line = line + 1
          end if
          line_begin = file%before + int(file%at, int64) - 1_int64
          call begin_line()
        case (a_hash)
          comment = .true.
        case default
          if (sum(gap) == 0_int64) gap_place = column_now()
          gap(code) = gap(code) + 1_int64
        end select
      end if
      before = code
    end do
    if (inside) call end_cell()
    call end_line()

  contains

    integer function column_now()
      column_now = int(file%before + int(file%at, int64) - 1_int64 - line_begin)
    end function column_now

    subroutine begin_line()
      cells = 0
      gap = 0_int64
      gap_place = 0
      inside = .false.
      comment = .false.
      digit_last = .false.
      after_comma = .false.
    end subroutine begin_line

    ! What stands before the cell.
    subroutine begin_cell()
      integer :: kind

      if (cells > 0) then
        if (gap(a_comma) == 1_int64 .and. sum(gap) == 1_int64 .and. digit_last .and. &
            code == a_digit) then
          kind = a_decimal_comma
          if (after_comma) counts%two_commas = .true.
        else if (gap(a_semicolon) > 0_int64) then
          kind = a_semicolon
          if (gap(a_comma) > 0_int64) call count_gap(a_comma)
        else
          kind = merge(a_tab, a_blank, gap(a_tab) > 0_int64)
          if (gap(a_comma) > 0_int64) then
            kind = a_comma
            if (sum(gap) > gap(a_comma)) counts%spaced_comma = .true.
          end if
        end if
        call count_gap(kind)
        after_comma = kind == a_decimal_comma
      end if
      if (layout%lines == 0_int64) then
        if (after_comma) counts%commas = counts%commas + 1
        if (.not. after_comma) layout%columns = layout%columns + 1
      end if
      inside = .true.
      cells = cells + 1
      digits_before = digits
      first_before = first_digit
      digits = 0
      first_digit = -1
      whole = .true.
      signed = .false.
      gap = 0_int64
    end subroutine begin_cell

    subroutine count_gap(kind)
      integer, intent(in) :: kind

      if (counts%gaps(kind) == 0_int64) then
        counts%line(kind) = line
        counts%column(kind) = gap_place
      end if
      counts%gaps(kind) = counts%gaps(kind) + 1_int64
    end subroutine count_gap

    subroutine end_cell()
      integer :: side

      inside = .false.
      side = modulo(cells, 2)
      counts%least(side) = min(counts%least(side), digits)
      counts%most(side) = max(counts%most(side), digits)
      if (signed) counts%signed(side) = .true.
      if (first_digit == 0 .and. digits > 1) counts%zero_first(side) = .true.
      if (after_comma .and. (digits /= 3 .or. digits_before > 3 .or. first_before == 0)) &
        counts%surely_decimal = .true.
    end subroutine end_cell

    subroutine end_line()
      integer :: kind

      if (cells == 0 .and. maxval(gap(a_comma:a_semicolon)) == 0_int64) then
        if (layout%lines > 0_int64 .and. gap_line == 0) gap_line = line
        return
      end if
      if (cells == 0) &
        call problems%add_at(line, 1, 'found a line of empty cells, expected heights, or NaN ' // &
                             'for a missing one')
      if (layout%gap_line == 0) layout%gap_line = gap_line
      layout%lines = layout%lines + 1_int64
      do kind = a_tab, a_semicolon
        if (gap(kind) > 0_int64) counts%ended(kind) = counts%ended(kind) + 1_int64
      end do
    end subroutine end_line

  end subroutine count_cells

  ! Chooses the separator of cells from what stands between them, unless there are two choices.
  subroutine choose_separator(layout, counts, problems, notes)
    type(text_layout), intent(inout) :: layout
    type(cell_counts), intent(in) :: counts
    type(problem_list), intent(inout) :: problems, notes
    character(len=*), parameter :: signs = ' ' // achar(9) // ',;'
    logical :: used(5)
    integer :: i, first, second

    used = counts%gaps > 0_int64
    first = findloc(used(:a_semicolon), .true., 1)
    if (used(a_decimal_comma) .and. count(used) == 2 .and. .not. used(a_comma) .and. &
        .not. (counts%point .or. counts%two_commas)) then
      layout%decimal_comma = .true.
      layout%cell_end = signs(first:first)
      if (.not. counts%surely_decimal) &
        call refuse([a_decimal_comma], 'found a comma before three digits in every number with ' &
                    // 'one: thousands or decimals')
    else
      layout%columns = layout%columns + counts%commas
      used(a_comma) = used(a_comma) .or. used(a_decimal_comma)
      first = max(1, findloc(used(:a_semicolon), .true., 1))
      second = max(1, findloc(used(:a_semicolon), .true., 1, back=.true.))
      layout%cell_end = signs(first:first)
      if (first /= second) then
        call refuse([first, second, a_decimal_comma], 'found ' // trim(gap_names(first)) // &
                    ' and ' // trim(gap_names(second)) // ' between cells')
      else if (used(a_decimal_comma) .and. .not. counts%point) then
        if (counts%spaced_comma) then
          call refuse([a_comma, a_decimal_comma], 'found commas with and without a blank, and ' // &
                      'no point in the file: separators or decimals')
        else if (modulo(layout%columns, 2) == 0) then
          if (may_be_decimals(counts)) &
            call refuse([a_decimal_comma], 'found commas alone, no point in the file, and ' // &
                        'second numbers of a pair that look like decimals of the first')
          if (problems%count() == 0) &
            call notes%add_at(counts%line(a_decimal_comma), counts%column(a_decimal_comma), &
                              'note: commas without a decimal point in the file are taken as ' // &
                              'separators of whole numbers')
        end if
      end if
    end if
    do i = a_tab, a_semicolon
      if (counts%ended(i) == 0_int64 .or. (i == a_tab .and. i /= index(signs, layout%cell_end)) &
          .or. (i == index(signs, layout%cell_end) .and. counts%ended(i) == layout%lines)) cycle
      call problems%add_in_file('found ' // number_text(counts%ended(i)) // ' of ' // &
                                number_text(layout%lines) // ' lines that end with ' // &
                                trim(gap_names(i)) // ', expected all, between cells too, or none')
    end do

  contains

    ! Tells it at that kind of gap whose first one comes last.
    subroutine refuse(kinds, found)
      integer, intent(in) :: kinds(:)
      character(len=*), intent(in) :: found
      integer :: k, place

      place = kinds(1)
      do k = 2, size(kinds)
        if (counts%line(kinds(k)) > counts%line(place) .or. &
            (counts%line(kinds(k)) == counts%line(place) .and. &
             counts%column(kinds(k)) > counts%column(place))) place = kinds(k)
      end do
      call problems%add_at(counts%line(place), counts%column(place), found // ', expected ' // &
                           'decimal points and one separator, for instance blanks')
    end subroutine refuse

  end subroutine choose_separator

  ! Whether of all whole numbers between commas every second one may be the decimals of the one
  ! before it: all have as many digits, without a sign. A tenth of decimals begins with 0, so of
  ! many numbers as long as the others, of which none does, none is a fraction.
  pure logical function may_be_decimals(counts)
    type(cell_counts), intent(in) :: counts
    integer(int64), parameter :: many = 200_int64
    logical :: alike

    alike = all([counts%least(1), counts%most(1)] == counts%least(0)) .and. &
            .not. counts%signed(1)
    may_be_decimals = counts%least(0) == counts%most(0) .and. .not. counts%signed(0) .and. &
      (.not. alike .or. counts%least(0) == 1 .or. counts%gaps(a_decimal_comma) < many)
    may_be_decimals = may_be_decimals .or. (counts%zero_first(0) .and. .not. counts%zero_first(1))
  end function may_be_decimals

end module asperity_text_layout
