!> Surfaces as comma-separated values: text in, checked numbers or a list of problems out.
!>
!> The first line that is not blank names the columns `x,y,height,radius` in any order; `radius`
!> may be left out. Reading takes time and memory in proportion to the file.
module asperity_surface_csv
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_input_text, only: blanks, check_text, line_end, quoted, read_text, text_start
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
    character(len=:), allocatable :: text

    call read_text(path, 'comma-separated numbers', text, problems)
    if (problems%count() == 0) call parse_surface_csv(path, text, table, problems, common_radius)
  end subroutine read_surface_csv

  !> Checks the text of a surface; `path` serves the messages only.
  pure subroutine parse_surface_csv(path, text, table, problems, common_radius)
    character(len=*), intent(in) :: path                !! name for the messages
    character(len=*), intent(in) :: text                !! the whole file
    type(surface_table), intent(out) :: table           !! its numbers
    type(problem_list), intent(out) :: problems         !! all that is wrong
    real(real64), intent(in), optional :: common_radius !! radius of all, when no column gives it
    type(problem_list) :: strange

    call parse_numbers(path, text, table, problems, common_radius)
    if (problems%count() == 0) return
    ! Where every cell is a number there is no byte that no text has. Such a byte says enough.
    call strange%start(path)
    call check_text(text, 'comma-separated numbers', strange)
    if (strange%count() > 0) problems = strange
  end subroutine parse_surface_csv

  ! The same for what may have bytes that no text has.
  pure subroutine parse_numbers(path, text, table, problems, common_radius)
    character(len=*), intent(in) :: path, text
    type(surface_table), intent(out) :: table
    type(problem_list), intent(out) :: problems
    real(real64), intent(in), optional :: common_radius
    integer :: column_of(4), first, line, columns, rows

    call problems%start(path)
    line = 1
    first = text_start(text)
    call skip_blank_lines(text, first, line)
    if (first > len(text)) then
      call problems%add_at(1, 1, 'the file is empty, expected the header x,y,height,radius')
      return
    end if
    call read_header(text, first, line, column_of, columns, problems)
    table%has_radius = any(column_of(:columns) == radius_column)
    if (problems%count() > 0) return
    ! One more than the line feeds that are left: never too few.
    rows = count_line_feeds(text(first:)) + 1
    allocate (table%x(rows), table%y(rows), table%height(rows))
    if (table%has_radius .or. present(common_radius)) allocate (table%radius(rows))
    if (present(common_radius)) table%radius = common_radius
    call read_rows(text, first, line, column_of(:columns), table, rows, problems)
    if (rows == 0 .and. problems%count() == 0) &
      call problems%add_at(line, 1, 'no asperity: found the end of the file, expected a row')
    call cut(table, rows)
  end subroutine parse_numbers

  !> Which column holds which number.
  pure subroutine read_header(text, first, line, column_of, columns, problems)
    character(len=*), intent(in) :: text
    integer, intent(inout) :: first, line        ! left at the next line
    integer, intent(out) :: column_of(4)         ! index in `names` of each column
    integer, intent(out) :: columns
    type(problem_list), intent(inout) :: problems
    type(line_cells) :: cells
    character(len=:), allocatable :: name
    integer :: i, start

    start = first
    column_of = 0
    call cut_line(text, first, cells)
    columns = min(cells%count, size(names))
    do i = 1, columns
      name = text(cells%first(i):cells%last(i))
      column_of(i) = findloc(names == name, .true., 1)
      if (column_of(i) == 0) then
        call problems%add_at(line, cells%first(i) - start + 1, 'unknown column: found ' // &
                          quoted(name) // ', expected x, y, height or radius')
      else if (any(column_of(:i - 1) == column_of(i))) then
        call problems%add_at(line, cells%first(i) - start + 1, 'column ' // name // &
                          ' stands twice, expected once')
      end if
    end do
    if (cells%count > size(names)) &
      call problems%add_at(line, 1, 'found ' // decimal_text(cells%count) // &
                        ' columns, expected x, y, height and perhaps radius')
    if (problems%count() == 0) then
      do i = 1, height_column
        if (any(column_of(:columns) == i)) cycle
        call problems%add_at(line, 1, 'no column ' // trim(names(i)) // &
                          ': expected x, y, height and perhaps radius')
      end do
    end if
    line = line + 1
  end subroutine read_header

  !> Reads all rows; `rows` becomes the number of good ones.
  pure subroutine read_rows(text, first, line, column_of, table, rows, problems)
    character(len=*), intent(in) :: text
    integer, intent(inout) :: first, line
    integer, intent(in) :: column_of(:)
    type(surface_table), intent(inout) :: table
    integer, intent(out) :: rows
    type(problem_list), intent(inout) :: problems
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
        call problems%add_at(line, 1, 'found ' // decimal_text(cells%count) // ' cells, ' // &
                             'expected ' // decimal_text(size(column_of)) // ' as in the header')
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
          call problems%add_at(line, place(column_of(i)), trim(names(column_of(i))) // &
                               ': found ' // cell(column_of(i)) // &
                               ', expected a finite number within the range of a double')
        end do
        if (all_good .and. allocated(table%radius)) then
          if (numbers(radius_column) <= 0.0_real64) then
            call problems%add_at(line, place(radius_column), 'radius: found ' // &
                                 cell(radius_column) // ', expected more than 0')
          else if (numbers(height_column) / 2 >= numbers(radius_column)) then
            ! A sphere does not stand higher than its diameter.
            call problems%add_at(line, place(height_column), 'height: found ' // &
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
    integer :: at, from

    from = first
    do at = first, len(text)
      if (text(at:at) == achar(10)) exit
      if (text(at:at) /= ',') cycle
      call add_cell(text, from, at - 1, cells)
      from = at + 1
    end do
    call add_cell(text, from, at - 1, cells)
    first = at + 1
  end subroutine cut_line

  !> Adds the cell `from:to`, without the blanks around it.
  pure subroutine add_cell(text, from, to, cells)
    character(len=*), intent(in) :: text
    integer, intent(in) :: from, to
    type(line_cells), intent(inout) :: cells

    cells%count = cells%count + 1
    if (cells%count > size(cells%first)) return
    cells%first(cells%count) = from
    cells%last(cells%count) = to
    if (to < from) return
    ! As a rule there are none.
    if (iachar(text(from:from)) <= iachar(' ')) &
      cells%first(cells%count) = from + max(0, verify(text(from:to), blanks) - 1)
    if (iachar(text(to:to)) <= iachar(' ')) &
      cells%last(cells%count) = from + verify(text(from:to), blanks, back=.true.) - 1
  end subroutine add_cell

  !> Steps over blank lines; `first` is left at the first byte of a line, or behind the text.
  pure subroutine skip_blank_lines(text, first, line)
    character(len=*), intent(in) :: text
    integer, intent(inout) :: first, line
    integer :: last

    do while (first <= len(text))
      if (verify(text(first:first), blanks // achar(10)) > 0) return
      last = line_end(text, first)
      if (verify(text(first:last), blanks) > 0) return
      if (last < len(text)) line = line + 1
      first = last + 2
    end do
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

  ! Piece by piece of a fixed length: such loops work on many bytes at once.
  pure integer function count_line_feeds(text)
    character(len=*), intent(in) :: text
    integer, parameter :: piece = 64
    integer :: i, begin

    count_line_feeds = 0
    do begin = 0, len(text) - piece, piece
      do i = begin + 1, begin + piece
        count_line_feeds = count_line_feeds + merge(1, 0, text(i:i) == achar(10))
      end do
    end do
    do i = begin + 1, len(text)
      count_line_feeds = count_line_feeds + merge(1, 0, text(i:i) == achar(10))
    end do
  end function count_line_feeds

end module asperity_surface_csv
