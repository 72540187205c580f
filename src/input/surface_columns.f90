!> The header of a surface as separated values: which column is what.
!>
!> Names in capitals or small letters, between quotes or not, a unit in brackets behind them. Other
!> columns may stand there; they are not read.
module asperity_surface_columns
  use asperity_decimal, only: decimal_value
  use asperity_delimited_text, only: column_of, find_separator, line_cells, read_cells
  use asperity_height_map, only: plain_unit
  use asperity_input_text, only: line_end, lower_case, quoted
  use asperity_numeral, only: read_numeral
  use asperity_problems, only: decimal_text, problem_list
  use asperity_word_hint, only: nearest_word
  implicit none
  private

  public :: surface_columns, column_names, height_column, radius_column, read_header

  !> What a column can be.
  character(len=*), parameter :: column_names(4) = &
    [character(len=6) :: 'x', 'y', 'height', 'radius']
  !> Place in `column_names`.
  integer, parameter :: height_column = 3, radius_column = 4

  ! Unread columns that a note names; the rest is counted. Chosen: one line of a terminal.
  integer, parameter :: most_named = 5

  !> What the columns of a file are.
  type :: surface_columns
    integer :: cell_of(4) = 0                 !! cell of each of `column_names`; 0: there is none
    integer :: count = 0                      !! columns of the file
    character(len=1) :: separator = ','       !! what stands between them
    character(len=:), allocatable :: unit     !! of all lengths; empty: not given in the file
    !> Names of columns that are not read, the first five, and how many there are; or empty.
    character(len=:), allocatable :: others
  end type surface_columns

contains

  !> Reads the header at `first`.
  pure subroutine read_header(text, first, line, columns, problems)
    character(len=*), intent(in) :: text            !! the whole file
    integer, intent(inout) :: first                 !! byte where it begins; left at the next line's
    integer, intent(inout) :: line                  !! its number; left at the next line's
    type(surface_columns), intent(out) :: columns   !! what stands where
    type(problem_list), intent(inout) :: problems   !! what is wrong
    type(line_cells) :: cells
    character(len=:), allocatable :: name, unit
    integer :: i, role, last, start, unread
    logical :: is_mixed

    is_mixed = .false.
    last = line_end(text, first)
    start = first
    cells%separator = find_separator(text(first:last))
    call read_cells(text, first, line, cells)
    line = cells%line + 1
    columns%count = cells%count
    columns%separator = cells%separator
    columns%unit = ''
    columns%others = ''
    unread = 0
    if (all_numbers(text, cells)) then
      call problems%add_at(cells%line, 1, 'no header: found numbers in the first line, ' // &
                           'expected x,y,height,radius')
      return
    end if
    do i = 1, cells%count
      call split(text(cells%first(i):cells%last(i)), name, unit)
      role = findloc(column_names == name, .true., 1)
      if (name == '') name = 'column ' // decimal_text(i)
      if (role == 0) then
        unread = unread + 1
        if (unread <= most_named) columns%others = columns%others // ', ' // name
      else if (columns%cell_of(role) > 0) then
        call refuse(i, 'column ' // name // ' occurs twice, expected once', problems)
      else
        columns%cell_of(role) = i
        if (all(columns%cell_of == 0 .or. columns%cell_of == i)) columns%unit = unit
        if (columns%unit == unit .or. is_mixed) cycle
        is_mixed = .true.
        call refuse(i, name // ': found ' // unit_in_words(unit) // ' beside ' // &
                    unit_in_words(columns%unit) // ', expected one unit for all lengths, in ' // &
                    'each column or in none', problems)
      end if
    end do
    ! A name that is nearly one of those that are missing is no other column.
    do i = 1, cells%count
      call split(text(cells%first(i):cells%last(i)), name, unit)
      if (any(column_names == name)) cycle
      role = nearest_word(name, column_names)
      if (role == 0) cycle
      if (columns%cell_of(role) > 0) cycle
      columns%cell_of(role) = i
      call refuse(i, 'unknown column: found ' // quoted(name) // '; did you mean ''' // &
                  trim(column_names(role)) // '''?', problems)
    end do
    if (unread > 0) columns%others = columns%others(3:)
    if (unread > most_named) &
      columns%others = columns%others // ' and ' // decimal_text(unread - most_named) // ' more'
    name = ''
    do i = 1, height_column
      if (columns%cell_of(i) == 0) name = name // ', ' // trim(column_names(i))
    end do
    if (name /= '') &
      call problems%add_at(cells%line, 1, 'no column ' // name(3:) // ': found ' // &
                           quoted(text(start:last)) // ', expected x, y, height and perhaps ' // &
                           'radius, between commas, semicolons or tabulators')

  contains

    pure subroutine refuse(cell, message, problems)
      integer, intent(in) :: cell
      character(len=*), intent(in) :: message
      type(problem_list), intent(inout) :: problems

      call problems%add_at(cells%line, column_of(cells, cell), message)
    end subroutine refuse

  end subroutine read_header

  ! A unit for a message.
  pure function unit_in_words(unit) result(text)
    character(len=*), intent(in) :: unit
    character(len=:), allocatable :: text

    text = 'no unit'
    if (unit /= '') text = 'unit ' // quoted(unit)
  end function unit_in_words

  ! Whether all cells are numbers: the header is missing.
  pure logical function all_numbers(text, cells)
    character(len=*), intent(in) :: text
    type(line_cells), intent(in) :: cells
    type(decimal_value) :: value
    integer :: i

    do i = 1, cells%count
      call read_numeral(text(cells%first(i):cells%last(i)), value, all_numbers)
      if (.not. all_numbers) return
    end do
  end function all_numbers

  ! A name in small letters without quotes, and the unit in brackets behind it.
  pure subroutine split(cell, name, unit)
    character(len=*), intent(in) :: cell
    character(len=:), allocatable, intent(out) :: name, unit
    integer :: left, right

    name = cell
    unit = ''
    if (len(name) > 1) then
      if (name(1:1) == '"' .and. name(len(name):) == '"') name = name(2:len(name) - 1)
    end if
    left = scan(name, '[(')
    if (left > 1) then
      right = scan(name(left:), '])') + left - 1
      if (right > left) unit = plain_unit(name(left + 1:right - 1))
      name = name(:left - 1)
    end if
    name = trim(adjustl(lower_case(name)))
  end subroutine split

end module asperity_surface_columns
