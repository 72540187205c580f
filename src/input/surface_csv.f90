!> Surfaces as separated values: text in, checked numbers or a list of problems out.
!>
!> The first line that is neither blank nor a comment (`#`) names the columns `x,y,height,radius`
!> in any order; `radius` may be left out. Reading takes time and memory in proportion to the file.
!> A long file is read by all threads, each its pieces.
module asperity_surface_csv
  use asperity_byte_reader, only: byte_reader
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_file_kind, only: a_surface, other_kind
  use asperity_input_text, only: check_text, line_end, quoted, read_text, text_start
  use asperity_kinds, only: int64, real64
  use asperity_numeral, only: read_numeral
  use asperity_problems, only: decimal_text, not_enough_memory, problem_list
  use asperity_process, only: has_memory
  use asperity_separated_cells, only: cut_line, line_cells, skip_to_line
  use asperity_surface_columns, only: column_names, height_column, radius_column, read_header, &
                                      surface_columns
  implicit none
  private

  public :: surface_table, read_surface_csv, parse_surface_csv

  ! Bytes of a piece that a thread reads: some 2000 rows, in a millisecond or less; fewer are not
  ! worth a thread.
  integer, parameter :: piece_length = 131072

  !> The asperities of a surface; lengths in the unit of the file.
  type :: surface_table
    real(real64), allocatable :: x(:), y(:)    !! summits on the reference plane
    real(real64), allocatable :: height(:)     !! summits above the plane, less than 2 radii
    real(real64), allocatable :: radius(:)     !! more than 0; not allocated: not given
    logical :: has_radius = .false.            !! the file has a radius column
    character(len=:), allocatable :: unit      !! of its lengths; empty: not given
    character(len=:), allocatable :: others    !! names of columns that are not read; or empty
  end type surface_table

contains

  !> Reads and checks a surface. With problems the table is not to be used.
  subroutine read_surface_csv(path, table, problems, common_radius, opened)
    character(len=*), intent(in) :: path                !! the file
    type(surface_table), intent(out) :: table           !! its numbers
    type(problem_list), intent(out) :: problems         !! all that is wrong
    real(real64), intent(in), optional :: common_radius !! radius of all, when no column gives it
    class(byte_reader), intent(inout), optional :: opened !! the file, at its first byte
    character(len=:), allocatable :: text

    call read_text(path, 'comma-separated numbers', text, problems, opened)
    if (problems%count() == 0) call parse_surface_csv(path, text, table, problems, common_radius)
  end subroutine read_surface_csv

  !> Checks the text of a surface; `path` serves the messages only.
  subroutine parse_surface_csv(path, text, table, problems, common_radius)
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
  subroutine parse_numbers(path, text, table, problems, common_radius)
    character(len=*), intent(in) :: path, text
    type(surface_table), intent(out) :: table
    type(problem_list), intent(out) :: problems
    real(real64), intent(in), optional :: common_radius
    type(surface_columns) :: columns
    character(len=:), allocatable :: other
    integer :: first, line

    call problems%start(path)
    line = 1
    first = text_start(text)
    call skip_to_line(text, first, line)
    if (first > len(text)) then
      call problems%add_at(1, 1, 'the file is empty, expected the header x,y,height,radius')
      return
    end if
    other = other_kind(text, [a_surface])
    if (other /= '') then
      call problems%add_at(line, 1, other // '; expected a surface, x,y,height,radius')
      return
    end if
    call read_header(text, first, line, columns, problems)
    table%has_radius = columns%cell_of(radius_column) > 0
    table%unit = columns%unit
    table%others = columns%others
    if (problems%count() > 0) return
    call read_pieces(path, text(first:), line, columns, table, problems, common_radius)
  end subroutine parse_numbers

  ! Reads all rows, piece by piece. Where a piece has problems all is read again as one, so that
  ! they are counted as one list.
  subroutine read_pieces(path, text, line, columns, table, problems, common_radius)
    character(len=*), intent(in) :: path, text  ! rows only
    integer, intent(in) :: line                 ! number of the first one
    type(surface_columns), intent(in) :: columns
    type(surface_table), intent(inout) :: table
    type(problem_list), intent(inout) :: problems
    real(real64), intent(in), optional :: common_radius
    integer, allocatable :: first(:)   ! byte of each piece, a line's; and one behind the last
    integer, allocatable :: before(:)  ! places in the table before those of each piece
    integer, allocatable :: last(:)    ! place of its last row
    type(problem_list), allocatable :: found(:)
    integer :: k, pieces, rows

    pieces = 1 + len(text) / piece_length
    allocate (first(pieces + 1), before(pieces + 1), last(pieces), found(pieces))
    first(1) = 1
    do k = 2, pieces
      first(k) = max(first(k - 1), min(len(text), line_end(text, (k - 1) * piece_length) + 1) + 1)
    end do
    first(pieces + 1) = len(text) + 1
    before(1) = 0
    !$omp parallel do if(pieces > 1)
    do k = 1, pieces
      before(k + 1) = count_line_feeds(text(first(k):first(k + 1) - 1))
    end do
    !$omp end parallel do
    do k = 1, pieces
      before(k + 1) = before(k) + before(k + 1)
    end do
    ! One more than line feeds: never too few.
    rows = before(pieces + 1) + 1
    if (.not. has_memory(32_int64 * rows)) then
      problems%lacks_memory = .true.
      call problems%add_in_file(not_enough_memory // ' for ' // decimal_text(rows) // ' asperities')
      return
    end if
    allocate (table%x(rows), table%y(rows), table%height(rows))
    if (table%has_radius .or. present(common_radius)) allocate (table%radius(rows))
    if (present(common_radius)) table%radius = common_radius
    !$omp parallel do schedule(dynamic) if(pieces > 1)
    do k = 1, pieces
      call found(k)%start(path)
      last(k) = before(k)
      call read_rows(text(first(k):first(k + 1) - 1), line + before(k), columns, table, last(k), &
                     found(k))
    end do
    !$omp end parallel do
    rows = last(1)
    do k = 2, pieces
      if (rows < before(k)) call move_rows(table, before(k) + 1, last(k), rows + 1)
      rows = rows + last(k) - before(k)
    end do
    if (any([(found(k)%count() > 0, k=1, pieces)])) then
      rows = 0
      call read_rows(text, line, columns, table, rows, problems)
    else if (rows == 0) then
      call problems%add_at(line + before(pieces + 1), 1, &
                           'no asperity: found the end of the file, expected a row')
    end if
    call cut(table, rows)
  end subroutine read_pieces

  !> Reads all rows of a text into places from `rows + 1` on; `rows` becomes the last one taken.
  pure subroutine read_rows(text, first_line, columns, table, rows, problems)
    character(len=*), intent(in) :: text
    integer, intent(in) :: first_line
    type(surface_columns), intent(in) :: columns
    type(surface_table), intent(inout) :: table
    integer, intent(inout) :: rows
    type(problem_list), intent(inout) :: problems
    type(line_cells) :: cells
    type(decimal_value) :: decimal
    real(real64) :: numbers(4)
    integer :: i, first, line, start
    logical :: good, all_good

    first = 1
    line = first_line
    cells%separator = columns%separator
    allocate (cells%first(columns%count), cells%last(columns%count))
    do
      call skip_to_line(text, first, line)
      if (first > len(text)) exit
      start = first
      call cut_line(text, first, cells)
      if (cells%count /= columns%count) then
        call problems%add_at(line, 1, 'found ' // decimal_text(cells%count) // ' cells, ' // &
                             'expected ' // decimal_text(columns%count) // ' as in the header' // &
                             point_hint(cells%count > columns%count .and. cells%separator == ','))
      else
        all_good = .true.
        if (allocated(table%radius) .and. .not. table%has_radius) &
          numbers(radius_column) = table%radius(1)
        do i = 1, size(column_names)
          if (columns%cell_of(i) == 0) cycle
          call read_numeral(text(cells%first(columns%cell_of(i)):cells%last(columns%cell_of(i))), &
                            decimal, good)
          numbers(i) = decimal_to_real64(decimal)
          if (good) cycle
          all_good = .false.
          call refuse(i, 'a finite number within the range of a double' // &
                      point_hint(index(cell(i), ',') > 0), problems)
        end do
        if (all_good .and. allocated(table%radius)) then
          if (numbers(radius_column) <= 0.0_real64) then
            call refuse(radius_column, 'more than 0', problems)
          else if (numbers(height_column) / 2 >= numbers(radius_column)) then
            ! A sphere does not stand higher than its diameter.
            call refuse(height_column, 'less than twice the radius', problems)
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

    ! The cell of a named column.
    pure function cell(column)
      integer, intent(in) :: column
      character(len=:), allocatable :: cell

      cell = text(cells%first(columns%cell_of(column)):cells%last(columns%cell_of(column)))
    end function cell

    ! Reports that the value of a column is not what is expected.
    pure subroutine refuse(column, expected, problems)
      integer, intent(in) :: column
      character(len=*), intent(in) :: expected
      type(problem_list), intent(inout) :: problems

      call problems%add_at(line, cells%first(columns%cell_of(column)) - start + 1, &
                           trim(column_names(column)) // ': found ' // quoted(cell(column)) // &
                           ', expected ' // expected)
    end subroutine refuse

  end subroutine read_rows

  ! What to do about a decimal comma.
  pure function point_hint(is_needed) result(text)
    logical, intent(in) :: is_needed
    character(len=:), allocatable :: text

    text = ''
    if (is_needed) text = '; a decimal comma? write a point'
  end function point_hint

  ! Rows from one place to another, to lower ones.
  pure subroutine move_rows(table, first, last, place)
    type(surface_table), intent(inout) :: table
    integer, intent(in) :: first, last, place
    integer :: i, j

    do i = first, last
      j = place + i - first
      table%x(j) = table%x(i)
      table%y(j) = table%y(i)
      table%height(j) = table%height(i)
      if (table%has_radius) table%radius(j) = table%radius(i)
    end do
  end subroutine move_rows

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
