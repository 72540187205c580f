!> Surfaces as comma-separated values: text in, checked numbers or a list of problems out.
!>
!> The first line that is not blank names the columns `x,y,height,radius` in any order; `radius`
!> may be left out. Reading takes time and memory in proportion to the file.
module asperity_surface_csv
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_files, only: read_whole_file
  use asperity_input_problems, only: binary_byte, input_problems, quoted, text_start
  use asperity_kinds, only: real64
  use asperity_numeral, only: read_numeral
  use asperity_problems, only: decimal_text, problem_list
  implicit none
  private

  public :: surface_table, read_surface_csv, parse_surface_csv

  !> The asperities of a surface; lengths in the unit of the file.
  type :: surface_table
    real(real64), allocatable :: x(:), y(:)    !! summits on the reference plane
    real(real64), allocatable :: height(:)     !! summits above the plane, less than 2 radii
    real(real64), allocatable :: radius(:)     !! more than 0; not allocated when nobody gives it
    logical :: has_radius = .false.            !! the file has a radius column
  end type surface_table

  character(len=*), parameter :: names(4) = [character(len=6) :: 'x', 'y', 'height', 'radius']
  integer, parameter :: height_column = 3, radius_column = 4
  character(len=*), parameter :: blanks = ' ' // achar(9) // achar(13)

  !> One line, cut at its commas.
  type :: line_cells
    integer :: count = 0                  ! cells found, those beyond the table's included
    integer :: first(4) = 1, last(4) = 0  ! places in the text, blanks around left out
  end type line_cells

contains

  !> Reads and checks a surface. With problems the table is not to be used.
  subroutine read_surface_csv(path, table, problems, common_radius)
    character(len=*), intent(in) :: path                !! the file
    type(surface_table), intent(out) :: table           !! its numbers
    type(problem_list), intent(out) :: problems         !! all that is wrong
    real(real64), intent(in), optional :: common_radius !! radius of all, when no column gives it
    character(len=:), allocatable :: text, failure

    call read_whole_file(path, text, failure)
    if (allocated(failure)) then
      ! The failure begins with the path; a problem of a file names a line and a column as well.
      call problems%add_at(path, 1, 1, failure(len(path) + 3:) // &
                           ', expected comma-separated numbers')
    else
      call parse_surface_csv(path, text, table, problems, common_radius)
    end if
  end subroutine read_surface_csv

  !> Checks the text of a surface; `path` serves the messages only.
  pure subroutine parse_surface_csv(path, text, table, problems, common_radius)
    character(len=*), intent(in) :: path                !! name for the messages
    character(len=*), intent(in) :: text                !! the whole file
    type(surface_table), intent(out) :: table           !! its numbers
    type(problem_list), intent(out) :: problems         !! all that is wrong
    real(real64), intent(in), optional :: common_radius !! radius of all, when no column gives it
    type(input_problems) :: found
    integer :: column_of(4), first, line, columns, rows, bad

    call found%start(path)
    columns = 0
    line = 1
    first = text_start(text)
    bad = binary_byte(text)
    if (bad > 0) then
      call found%add_at_byte(text, bad, 'not a text file: found a control character, ' // &
                             'expected comma-separated numbers')
    else
      call skip_blank_lines(text, first, line)
      if (first > len(text)) then
        call found%add_at(1, 1, 'the file is empty, expected the header x,y,height,radius')
      else
        call read_header(text, first, line, column_of, columns, found)
        table%has_radius = any(column_of(:columns) == radius_column)
      end if
    end if
    if (found%count() == 0) then
      ! One more than the line feeds that are left: never too few.
      rows = count_line_feeds(text(first:)) + 1
      allocate (table%x(rows), table%y(rows), table%height(rows))
      if (table%has_radius) then
        allocate (table%radius(rows))
      else if (present(common_radius)) then
        allocate (table%radius(rows))
        table%radius = common_radius
      end if
      call read_rows(text, first, line, column_of(:columns), table, rows, found)
      if (rows == 0 .and. found%count() == 0) &
        call found%add_at(line, 1, 'no asperity: found the end of the file, expected a row')
      call cut(table, rows)
    end if
    call found%hand_over(problems)
  end subroutine parse_surface_csv

  !> Which column holds which number.
  pure subroutine read_header(text, first, line, column_of, columns, found)
    character(len=*), intent(in) :: text
    integer, intent(inout) :: first, line        ! left at the next line
    integer, intent(out) :: column_of(4)         ! index in `names` of each column
    integer, intent(out) :: columns
    type(input_problems), intent(inout) :: found
    type(line_cells) :: cells
    character(len=:), allocatable :: name
    integer :: i, start

    start = first
    column_of = 0
    call cut_line(text, first, cells)
    columns = min(cells%count, size(names))
    do i = 1, columns
      name = text(cells%first(i):cells%last(i))
      column_of(i) = column_named(name)
      if (column_of(i) == 0) then
        call found%add_at(line, cells%first(i) - start + 1, 'unknown column: found ' // &
                          quoted(name) // ', expected x, y, height or radius')
      else if (any(column_of(:i - 1) == column_of(i))) then
        call found%add_at(line, cells%first(i) - start + 1, 'column ' // name // &
                          ' stands twice, expected once')
      end if
    end do
    if (cells%count > size(names)) &
      call found%add_at(line, 1, 'found ' // decimal_text(cells%count) // &
                        ' columns, expected x, y, height and perhaps radius')
    if (found%count() == 0) then
      do i = 1, height_column
        if (any(column_of(:columns) == i)) cycle
        call found%add_at(line, 1, 'no column ' // trim(names(i)) // &
                          ': expected x, y, height and perhaps radius')
      end do
    end if
    line = line + 1
  end subroutine read_header

  !> Reads all rows; `rows` becomes the number of good ones.
  pure subroutine read_rows(text, first, line, column_of, table, rows, found)
    character(len=*), intent(in) :: text
    integer, intent(inout) :: first, line
    integer, intent(in) :: column_of(:)
    type(surface_table), intent(inout) :: table
    integer, intent(out) :: rows
    type(input_problems), intent(inout) :: found
    type(line_cells) :: cells
    type(decimal_value) :: decimal
    real(real64) :: numbers(4)
    integer :: i, start, place(4), cell_of(4)
    logical :: good, all_good

    cell_of = 0
    do i = 1, size(column_of)
      cell_of(column_of(i)) = i
    end do
    place = 1
    rows = 0
    do
      call skip_blank_lines(text, first, line)
      if (first > len(text)) exit
      start = first
      call cut_line(text, first, cells)
      if (cells%count /= size(column_of)) then
        call found%add_at(line, 1, 'found ' // decimal_text(cells%count) // ' cells, expected ' // &
                          decimal_text(size(column_of)) // ' as in the header')
      else
        all_good = .true.
        if (allocated(table%radius) .and. .not. table%has_radius) &
          numbers(radius_column) = table%radius(1)
        do i = 1, size(column_of)
          place(column_of(i)) = cells%first(i) - start + 1
          call read_numeral(text(cells%first(i):cells%last(i)), decimal, good)
          numbers(column_of(i)) = decimal_to_real64(decimal)
          if (good) cycle
          all_good = .false.
          call found%add_at(line, place(column_of(i)), trim(names(column_of(i))) // ': found ' // &
                            quoted(text(cells%first(i):cells%last(i))) // &
                            ', expected a finite number within the range of a double')
        end do
        if (all_good .and. allocated(table%radius)) then
          if (numbers(radius_column) <= 0.0_real64) then
            call found%add_at(line, place(radius_column), 'radius: found ' // &
                              cell(radius_column) // ', expected more than 0')
          else if (numbers(height_column) / 2 >= numbers(radius_column)) then
            ! A sphere does not stand higher than its diameter.
            call found%add_at(line, place(height_column), 'height: found ' // &
                              cell(height_column) // ', expected less than twice the radius')
          end if
        end if
        rows = rows + 1
        table%x(rows) = numbers(1)
        table%y(rows) = numbers(2)
        table%height(rows) = numbers(height_column)
        if (table%has_radius) table%radius(rows) = numbers(radius_column)
      end if
      line = line + 1
    end do

  contains

    !> The cell of a named column, for a message.
    pure function cell(column)
      integer, intent(in) :: column
      character(len=:), allocatable :: cell

      cell = quoted(text(cells%first(cell_of(column)):cells%last(cell_of(column))))
    end function cell

  end subroutine read_rows

  !> Cuts the line at `first` at its commas; `first` is left at the next line.
  pure subroutine cut_line(text, first, cells)
    character(len=*), intent(in) :: text
    integer, intent(inout) :: first
    type(line_cells), intent(out) :: cells
    integer :: at
    logical :: ends

    at = first
    do
      ends = at > len(text)
      if (.not. ends) ends = text(at:at) == achar(10)
      if (ends) exit
      if (text(at:at) == ',') then
        call add_cell(text, first, at - 1, cells)
        first = at + 1
      end if
      at = at + 1
    end do
    call add_cell(text, first, at - 1, cells)
    first = at + 1
  end subroutine cut_line

  !> Adds the cell `from:to`, without the blanks around it.
  pure subroutine add_cell(text, from, to, cells)
    character(len=*), intent(in) :: text
    integer, intent(in) :: from, to
    type(line_cells), intent(inout) :: cells
    integer :: first, last

    cells%count = cells%count + 1
    if (cells%count > size(cells%first)) return
    first = from
    last = to
    do while (last >= first)
      if (scan(text(last:last), blanks) == 0) exit
      last = last - 1
    end do
    do while (first < last)
      if (scan(text(first:first), blanks) == 0) exit
      first = first + 1
    end do
    cells%first(cells%count) = first
    cells%last(cells%count) = last
  end subroutine add_cell

  !> Steps over blank lines; `first` is left at the first byte of a line, or behind the text.
  pure subroutine skip_blank_lines(text, first, line)
    character(len=*), intent(in) :: text
    integer, intent(inout) :: first, line
    integer :: at

    at = first
    do while (at <= len(text))
      if (text(at:at) == achar(10)) then
        line = line + 1
        first = at + 1
      else if (scan(text(at:at), blanks) == 0) then
        return
      end if
      at = at + 1
    end do
    first = at
  end subroutine skip_blank_lines

  !> Shortens the table to its rows.
  pure subroutine cut(table, rows)
    type(surface_table), intent(inout) :: table
    integer, intent(in) :: rows

    if (rows == size(table%x)) return
    table%x = table%x(:rows)
    table%y = table%y(:rows)
    table%height = table%height(:rows)
    if (allocated(table%radius)) table%radius = table%radius(:rows)
  end subroutine cut

  pure integer function count_line_feeds(text)
    character(len=*), intent(in) :: text
    integer :: i

    count_line_feeds = 0
    do i = 1, len(text)
      if (text(i:i) == achar(10)) count_line_feeds = count_line_feeds + 1
    end do
  end function count_line_feeds

  !> Place of a name among the columns' names; 0 when it is none.
  pure integer function column_named(name)
    character(len=*), intent(in) :: name

    do column_named = size(names), 1, -1
      if (name == trim(names(column_named)) .and. len(name) > 0) exit
    end do
  end function column_named

end module asperity_surface_csv
