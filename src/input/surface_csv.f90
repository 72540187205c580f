!> Surfaces as separated values: text in, checked numbers or a list of problems out.
!>
!> The first line that is neither blank nor a comment (`#`) names the columns `x,y,height,radius`
!> in any order; `radius` may be left out. Reading takes time and memory in proportion to the file.
module asperity_surface_csv
  use asperity_byte_reader, only: byte_reader
  use asperity_column_names, only: split_name
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_delimited_text, only: column_of, line_cells, read_cells, separator_of
  use asperity_file_kind, only: a_surface, other_kind
  use asperity_input_text, only: check_text, line_end, in_quotes, read_text
  use asperity_kinds, only: int64, real64
  use asperity_numeral, only: read_numeral
  use asperity_problems, only: decimal_text, not_enough_memory, problem_list
  use asperity_process, only: has_memory
  use asperity_word_hint, only: did_you_mean, nearest_word
  implicit none
  private

  public :: surface_table, read_surface_csv, parse_surface_csv

  !> Names of columns that are read.
  character(len=*), parameter :: column_names(4) = &
    [character(len=6) :: 'x', 'y', 'height', 'radius']
  integer, parameter :: height_column = 3, radius_column = 4  !! place in `column_names`

  ! Unread columns that a note names; the rest is counted. Chosen: one line of a terminal.
  integer, parameter :: most_named = 5

  !> The asperities of a surface; lengths in the unit of the file.
  type :: surface_table
    real(real64), allocatable :: x(:), y(:)    !! summits on the reference plane
    real(real64), allocatable :: height(:)     !! summits above the plane, less than 2 radii
    real(real64), allocatable :: radius(:)     !! more than 0; not allocated: not given
    logical :: has_radius = .false.            !! the file has a radius column
    character(len=:), allocatable :: unit      !! of its lengths; empty: not given
    !> Names of columns that are not read, the first five, and how many there are; or empty.
    character(len=:), allocatable :: others
    integer, private :: cell_of(4) = 0         ! cell of each of `column_names`; 0: there is none
    integer, private :: column_count = 0       ! columns of the file
    character(len=1), private :: separator = ','  ! what stands between them
  end type surface_table

contains

  !> Reads and checks a surface. With problems the table is not to be used.
  subroutine read_surface_csv(path, table, problems, common_radius, opened)
    character(len=*), intent(in) :: path                !! path of the surface
    type(surface_table), intent(out) :: table           !! numbers of the asperities
    type(problem_list), intent(out) :: problems         !! all that is wrong
    real(real64), intent(in), optional :: common_radius !! where no column gives radii; 0: none
    class(byte_reader), intent(inout), optional :: opened !! the file, at its first byte
    character(len=:), allocatable :: text

    call read_text(path, 'comma-separated numbers', text, problems, opened)
    if (problems%count() == 0) call parse_surface_csv(path, text, table, problems, common_radius)
  end subroutine read_surface_csv

  !> Checks the text of a surface; `path` serves the messages only.
  subroutine parse_surface_csv(path, text, table, problems, common_radius)
    character(len=*), intent(in) :: path                !! name for the messages
    character(len=*), intent(in) :: text                !! the whole file
    type(surface_table), intent(out) :: table           !! numbers of the asperities
    type(problem_list), intent(out) :: problems         !! all that is wrong
    real(real64), intent(in), optional :: common_radius !! where no column gives radii; 0: none
    type(problem_list) :: strange
    type(line_cells) :: cells
    character(len=:), allocatable :: other
    integer :: first, line

    call problems%start(path)
    line = 1
    first = 1
    call read_cells(text, first, line, cells)
    other = other_kind(text, [a_surface])
    if (cells%cell_count == 0) then
      call problems%add_at(1, 1, 'the file is empty, expected the header x,y,height,radius')
    else if (other /= '') then
      call problems%add_at(cells%line, 1, other // '; expected a surface, x,y,height,radius')
    else
      first = cells%start
      line = cells%line
      call read_header(text, first, line, table, problems)
      table%has_radius = table%cell_of(radius_column) > 0
      if (problems%count() == 0) &
        call read_rows(text(first:), line, table, problems, common_radius)
    end if
    if (problems%count() == 0) return
    ! Where every cell is a number there is no byte that no text has. Such a byte says enough.
    call strange%start(path)
    call check_text(text, 'comma-separated numbers', strange)
    if (strange%count() > 0) problems = strange
  end subroutine parse_surface_csv

  ! Long: a row shares its cells with the messages. Reads all rows of a text, whose first line has
  ! the number `first_line`.
  subroutine read_rows(text, first_line, table, problems, common_radius)
    character(len=*), intent(in) :: text
    integer, intent(in) :: first_line
    type(surface_table), intent(inout) :: table
    type(problem_list), intent(inout) :: problems
    real(real64), intent(in), optional :: common_radius
    type(line_cells) :: cells
    type(decimal_value) :: decimal
    real(real64) :: numbers(4)
    integer :: i, at, line, lines, rows
    logical :: good, all_good

    ! The last line may have no line feed.
    lines = 1
    do i = 1, len(text)
      if (text(i:i) == achar(10)) lines = lines + 1
    end do
    if (.not. has_memory(32_int64 * lines)) then
      problems%lacks_memory = .true.
      call problems%add_in_file(not_enough_memory // ' for ' // decimal_text(lines) // &
                                ' asperities')
      return
    end if
    allocate (table%x(lines), table%y(lines), table%height(lines))
    numbers(radius_column) = 0.0_real64
    if (present(common_radius)) numbers(radius_column) = common_radius
    if (table%has_radius .or. numbers(radius_column) > 0.0_real64) allocate (table%radius(lines))
    at = 1
    line = first_line
    rows = 0
    cells%separator = table%separator
    do
      call read_cells(text, at, line, cells)
      if (cells%cell_count == 0) exit
      rows = rows + 1
      if (cells%cell_count /= table%column_count) then
        call problems%add_at(cells%line, 1, 'found ' // decimal_text(cells%cell_count) // &
                             ' cells, expected ' // decimal_text(table%column_count) // &
                             ' as in the header' // &
                             point_hint(cells%cell_count > table%column_count .and. &
                             cells%separator == ','))
        cycle
      end if
      all_good = .true.
      do i = 1, size(column_names)
        if (table%cell_of(i) == 0) cycle
        call read_numeral(text(cells%first(table%cell_of(i)):cells%last(table%cell_of(i))), &
                          decimal, good)
        numbers(i) = decimal_to_real64(decimal)
        if (good) cycle
        all_good = .false.
        call refuse_value(i, 'a finite number within the range of a double')
      end do
      if (all_good .and. allocated(table%radius)) then
        if (numbers(radius_column) <= 0.0_real64) then
          call refuse_value(radius_column, 'more than 0')
        else if (numbers(height_column) / 2 >= numbers(radius_column)) then
          ! A sphere does not stand higher than its diameter.
          call refuse_value(height_column, 'less than twice the radius')
        end if
      end if
      table%x(rows) = numbers(1)
      table%y(rows) = numbers(2)
      table%height(rows) = numbers(height_column)
      if (allocated(table%radius)) table%radius(rows) = numbers(radius_column)
    end do
    if (rows == 0) call problems%add_at(first_line + lines - 1, 1, 'no asperity: found the end ' &
                                        // 'of the file, expected a row')
    if (rows == lines) return
    table%x = table%x(:rows)
    table%y = table%y(:rows)
    table%height = table%height(:rows)
    if (allocated(table%radius)) table%radius = table%radius(:rows)

  contains

    ! Reports that the value of a column is not what is expected.
    subroutine refuse_value(column, expected)
      integer, intent(in) :: column
      character(len=*), intent(in) :: expected

      associate (cell => table%cell_of(column))
        associate (found => text(cells%first(cell):cells%last(cell)))
          call problems%add_at(cells%line, column_of(cells, cell), trim(column_names(column)) // &
                               ': found ' // in_quotes(found) // ', expected ' // expected // &
                               point_hint(index(found, ',') > 0))
        end associate
      end associate
    end subroutine refuse_value

  end subroutine read_rows

  ! Advice about a decimal comma.
  pure function point_hint(is_needed) result(text)
    logical, intent(in) :: is_needed
    character(len=:), allocatable :: text

    text = ''
    if (is_needed) text = '; a decimal comma? write a point'
  end function point_hint

  !> Reads the header at `first`.
  subroutine read_header(text, first, line, table, problems)
    character(len=*), intent(in) :: text            !! the whole file
    integer, intent(inout) :: first                 !! byte where it begins; left at the next line's
    integer, intent(inout) :: line                  !! its number; left at the next line's
    type(surface_table), intent(inout) :: table     !! gets what stands where
    type(problem_list), intent(inout) :: problems   !! what is wrong
    type(line_cells) :: cells
    character(len=:), allocatable :: name, unit
    integer :: i, role, last, unread
    logical :: is_mixed

    is_mixed = .false.
    last = line_end(text, first)
    cells%separator = separator_of(text(first:last))
    if (cells%separator == ' ') cells%separator = achar(9)
    call read_cells(text, first, line, cells)
    line = cells%line + 1
    table%column_count = cells%cell_count
    table%separator = cells%separator
    table%unit = ''
    table%others = ''
    unread = 0
    if (all_numbers(text, cells)) then
      call problems%add_at(cells%line, 1, 'no header: found numbers in the first line, ' // &
                           'expected x,y,height,radius')
      return
    end if
    do i = 1, cells%cell_count
      call split_name(text(cells%first(i):cells%last(i)), name, unit)
      role = findloc(column_names == name, .true., 1)
      if (name == '') name = 'column ' // decimal_text(i)
      if (role == 0) then
        unread = unread + 1
        if (unread <= most_named) table%others = table%others // ', ' // name
      else if (table%cell_of(role) > 0) then
        call refuse_cell(i, 'column ' // name // ' occurs twice, expected once')
      else
        table%cell_of(role) = i
        if (all(table%cell_of == 0 .or. table%cell_of == i)) table%unit = unit
        if (table%unit == unit .or. is_mixed) cycle
        is_mixed = .true.
        call refuse_cell(i, name // ': found ' // unit_in_words(unit) // ' beside ' // &
                    unit_in_words(table%unit) // ', expected one unit for all lengths, in ' // &
                    'each column or in none')
      end if
    end do
    ! A name that is nearly one of those that are missing is no other column.
    do i = 1, cells%cell_count
      call split_name(text(cells%first(i):cells%last(i)), name, unit)
      if (any(column_names == name)) cycle
      role = nearest_word(name, column_names)
      if (role == 0) cycle
      if (table%cell_of(role) > 0) cycle
      table%cell_of(role) = i
      call refuse_cell(i, 'unknown column: found ' // in_quotes(name) // &
                       did_you_mean(name, column_names))
    end do
    if (unread > 0) table%others = table%others(3:)
    if (unread > most_named) &
      table%others = table%others // ' and ' // decimal_text(unread - most_named) // ' more'
    name = ''
    do i = 1, height_column
      if (table%cell_of(i) == 0) name = name // ', ' // trim(column_names(i))
    end do
    if (name /= '') &
      call problems%add_at(cells%line, 1, 'no column ' // name(3:) // ': found ' // &
                           in_quotes(text(cells%start:last)) // ', expected x, y, height and ' // &
                           'perhaps radius, between commas, semicolons or tabulators')

  contains

    subroutine refuse_cell(named_cell, message)
      integer, intent(in) :: named_cell
      character(len=*), intent(in) :: message

      call problems%add_at(cells%line, column_of(cells, named_cell), message)
    end subroutine refuse_cell

  end subroutine read_header

  ! A unit for a message.
  pure function unit_in_words(unit) result(text)
    character(len=*), intent(in) :: unit
    character(len=:), allocatable :: text

    text = 'no unit'
    if (unit /= '') text = 'unit ' // in_quotes(unit)
  end function unit_in_words

  ! Whether all cells are numbers: the header is missing.
  pure logical function all_numbers(text, cells)
    character(len=*), intent(in) :: text
    type(line_cells), intent(in) :: cells
    type(decimal_value) :: value
    integer :: i

    do i = 1, cells%cell_count
      call read_numeral(text(cells%first(i):cells%last(i)), value, all_numbers)
      if (.not. all_numbers) return
    end do
  end function all_numbers

end module asperity_surface_csv
