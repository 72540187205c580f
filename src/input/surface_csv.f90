!> Surfaces as separated values: text in, checked numbers or a list of problems out.
!>
!> The first line that is neither blank nor a comment (`#`) names the columns `x,y,height,radius`
!> in any order; `radius` may be left out. Reading takes time and memory in proportion to the file.
module asperity_surface_csv
  use asperity_byte_reader, only: byte_reader
  use asperity_delimited_text, only: cells_of, line_cells, line_reader, separator_of
  use asperity_file_kind, only: a_surface, other_kind
  use asperity_height_map, only: plain_unit, unit_number
  use asperity_input_text, only: check_text, in_quotes, line_end, lower_case, read_text, &
                                 replaced_text
  use asperity_kinds, only: int64, real64
  use asperity_numeral, only: read_number
  use asperity_problems, only: decimal_text, problem_list
  use asperity_process, only: check_memory
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
  end type surface_table

contains

  !> Reads and checks a surface. With problems the table is not to be used.
  subroutine read_surface_csv(path, table, problems, common_radius, opened)
    character(len=*), intent(in) :: path                !! path of the surface
    type(surface_table), intent(out) :: table           !! numbers of the asperities
    type(problem_list), intent(out) :: problems         !! all that is wrong
    real(real64), intent(in) :: common_radius           !! where no column gives radii; 0: none
    class(byte_reader), intent(inout) :: opened         !! the file, at its first byte
    character(len=:), allocatable :: text

    call read_text(path, 'comma-separated numbers', text, problems, opened)
    if (problems%count() == 0) call parse_surface_csv(path, text, table, problems, common_radius)
  end subroutine read_surface_csv

  !> Checks the text of a surface, which is moved away; `path` serves the messages only.
  subroutine parse_surface_csv(path, text, table, problems, common_radius)
    character(len=*), intent(in) :: path                        !! name for the messages
    character(len=:), allocatable, intent(inout) :: text        !! the whole file
    type(surface_table), intent(out) :: table                   !! numbers of the asperities
    type(problem_list), intent(out) :: problems                 !! all that is wrong
    real(real64), intent(in) :: common_radius   !! where no column gives radii; 0: none
    type(problem_list) :: strange
    type(line_reader) :: file
    character(len=:), allocatable :: other

    call file%problems%start(path)
    call file%begin_memory(text)
    call file%next_cells()
    other = other_kind(file%lines, [a_surface])
    if (file%cells%cell_count == 0) then
      call file%problems%add_at(1, 1, 'the file is empty, expected the header x,y,height,radius')
    else if (other /= '') then
      call file%problems%add_at(file%cells%line, 1, other // '; expected a surface, ' // &
                                'x,y,height,radius')
    else
      call read_header(file, table)
      table%has_radius = table%cell_of(radius_column) > 0
      if (file%problems%count() == 0) call read_rows(file, table, common_radius)
    end if
    problems = file%problems
    if (problems%count() == 0) return
    ! Where every cell is a number there is no byte that no text has. Such a byte says enough.
    call strange%start(path)
    call check_text(file%lines, 'comma-separated numbers', strange)
    if (strange%count() > 0) problems = strange
  end subroutine parse_surface_csv

  ! Reads all rows behind the header, which is the line at hand.
  subroutine read_rows(file, table, common_radius)
    type(line_reader), intent(inout) :: file
    type(surface_table), intent(inout) :: table
    real(real64), intent(in) :: common_radius
    real(real64) :: numbers(4)
    character(len=:), allocatable :: failure
    integer :: first_line, i, lines, rows
    logical :: good, all_good

    ! The last line may have no line feed.
    lines = 1
    do i = line_end(file%lines, file%cells%start) + 2, len(file%lines)
      if (file%lines(i:i) == achar(10)) lines = lines + 1
    end do
    call check_memory(decimal_text(lines) // ' asperities', failure, bytes=32_int64 * lines)
    if (allocated(failure)) then
      file%problems%lacks_memory = .true.
      call file%problems%add_in_file(failure)
      return
    end if
    allocate (table%x(lines), table%y(lines), table%height(lines))
    numbers(radius_column) = common_radius
    if (table%has_radius .or. common_radius > 0.0_real64) allocate (table%radius(lines))
    first_line = file%cells%line + 1
    rows = 0
    do
      call file%next_cells()
      associate (cells => file%cells)
        if (cells%cell_count == 0) exit
        rows = rows + 1
        if (cells%cell_count /= table%column_count) then
          call file%problems%add_at(cells%line, 1, 'found ' // decimal_text(cells%cell_count) // &
               ' cells, expected ' // decimal_text(table%column_count) // ' as in the header' // &
               point_hint(cells%cell_count > table%column_count .and. cells%separator == ','))
          cycle
        end if
        all_good = .true.
        do i = 1, size(column_names)
          if (table%cell_of(i) == 0) cycle
          call read_number(file%lines(cells%first(table%cell_of(i)): &
                                      cells%last(table%cell_of(i))), numbers(i), good)
          all_good = all_good .and. good
          if (.not. good) &
            call refuse_value(file, table, i, 'a finite number within the range of a double')
        end do
      end associate
      if (all_good .and. allocated(table%radius)) then
        if (numbers(radius_column) <= 0.0_real64) then
          call refuse_value(file, table, radius_column, 'more than 0')
        else if (numbers(height_column) / 2 >= numbers(radius_column)) then
          ! A sphere does not stand higher than its diameter.
          call refuse_value(file, table, height_column, 'less than twice the radius')
        end if
      end if
      table%x(rows) = numbers(1)
      table%y(rows) = numbers(2)
      table%height(rows) = numbers(height_column)
      if (allocated(table%radius)) table%radius(rows) = numbers(radius_column)
    end do
    if (rows == 0) &
      call file%problems%add_at(first_line + lines - 1, 1, 'no asperity: found the end of the ' // &
                                'file, expected a row')
    if (rows == lines) return
    table%x = table%x(:rows)
    table%y = table%y(:rows)
    table%height = table%height(:rows)
    if (allocated(table%radius)) table%radius = table%radius(:rows)
  end subroutine read_rows

  ! Reports that the value of a column is not what is expected.
  subroutine refuse_value(file, table, column, expected)
    type(line_reader), intent(inout) :: file
    type(surface_table), intent(in) :: table
    integer, intent(in) :: column
    character(len=*), intent(in) :: expected
    character(len=:), allocatable :: found

    found = file%cell_text(table%cell_of(column))
    call file%refuse_cell(table%cell_of(column), trim(column_names(column)) // ': found ' // &
                          in_quotes(found) // ', expected ' // expected // &
                          point_hint(index(found, ',') > 0))
  end subroutine refuse_value

  ! Advice about a decimal comma.
  pure function point_hint(is_needed) result(text)
    logical, intent(in) :: is_needed
    character(len=:), allocatable :: text

    text = ''
    if (is_needed) text = '; a decimal comma? write a point'
  end function point_hint

  ! Reads the header, the line at hand: which column stands where, between which signs.
  subroutine read_header(file, table)
    type(line_reader), intent(inout) :: file
    type(surface_table), intent(inout) :: table
    type(line_cells) :: cells
    real(real64) :: number
    character(len=:), allocatable :: header, name, unit
    integer :: i, role, unread
    logical :: are_numbers, is_mixed

    header = file%lines(file%cells%start:line_end(file%lines, file%cells%start))
    file%cells%separator = separator_of(header)
    if (file%cells%separator == ' ') file%cells%separator = achar(9)
    cells = cells_of(header, file%cells%separator, .true.)
    table%column_count = cells%cell_count
    file%cells%cell_count = cells%cell_count
    file%cells%first = cells%first + file%cells%start - 1
    file%cells%last = cells%last + file%cells%start - 1
    table%unit = ''
    table%others = ''
    do i = 1, table%column_count
      call read_number(file%cell_text(i), number, are_numbers)
      if (.not. are_numbers) exit
    end do
    if (are_numbers) then
      call file%problems%add_at(file%cells%line, 1, 'no header: found numbers in the first line, ' &
                                // 'expected x,y,height,radius')
      return
    end if
    unread = 0
    is_mixed = .false.
    do i = 1, table%column_count
      call split_name(file%cell_text(i), name, unit)
      role = findloc(column_names == name, .true., 1)
      if (name == '') name = 'column ' // decimal_text(i)
      if (role == 0) then
        unread = unread + 1
        if (unread <= most_named) table%others = table%others // ', ' // name
      else if (table%cell_of(role) > 0) then
        call file%refuse_cell(i, 'column ' // name // ' occurs twice, expected once')
      else
        table%cell_of(role) = i
        if (all(table%cell_of == 0 .or. table%cell_of == i)) table%unit = unit
        if (table%unit == unit .or. is_mixed) cycle
        is_mixed = .true.
        call file%refuse_cell(i, name // ': found ' // unit_in_words(unit) // ' beside ' // &
             unit_in_words(table%unit) // ', expected one unit for all lengths, in each ' // &
             'column or in none')
      end if
    end do
    ! A name that is nearly one of those that are missing is no other column.
    do i = 1, table%column_count
      call split_name(file%cell_text(i), name, unit)
      if (any(column_names == name)) cycle
      role = nearest_word(name, column_names)
      if (role == 0) cycle
      if (table%cell_of(role) > 0) cycle
      table%cell_of(role) = i
      call file%refuse_cell(i, 'unknown column: found ' // in_quotes(name) // &
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
      call file%problems%add_at(file%cells%line, 1, 'no column ' // name(3:) // ': found ' // &
           in_quotes(header) // ', expected x, y, height and perhaps radius, between commas, ' // &
           'semicolons or tabulators')
  end subroutine read_header

  ! A name in small letters without quotes, and the unit behind it: `z [um]`, `z (um)`, `z/um`,
  ! `z_um`, `z um`.
  pure subroutine split_name(cell, name, unit)
    character(len=*), intent(in) :: cell                      ! name and unit as written
    character(len=:), allocatable, intent(out) :: name, unit  ! empty: there is none
    character(len=len(cell)) :: word
    integer :: at, i, used

    word = adjustl(replaced_text(replaced_text(cell, '"', ''), '''', ''))
    used = len_trim(word)
    unit = ''
    at = scan(word, '[(/')
    if (at > 1) then
      i = used
      if (word(at:at) /= '/') i = at + scan(word(at + 1:used), '])') - 1
      unit = plain_unit(word(at + 1:i))
      used = at - 1
    else
      at = scan(word(:used), '_ ', back=.true.)
      if (at > 1) unit = plain_unit(word(at + 1:used))
      if (unit_number(unit) == 0) unit = ''
      if (unit /= '') used = at - 1
    end if
    name = trim(lower_case(word(:used)))
  end subroutine split_name

  ! A unit for a message.
  pure function unit_in_words(unit) result(text)
    character(len=*), intent(in) :: unit
    character(len=:), allocatable :: text

    text = 'no unit'
    if (unit /= '') text = 'unit ' // in_quotes(unit)
  end function unit_in_words

end module asperity_surface_csv
