!> Delimited text: lines and the cells between their separators, of a text in memory or of a file.
!>
!> A line ends with a line feed; in a file a carriage return alone ends one as well. Blank lines and
!> comments have no cells. Blanks around a cell do not belong to it.
module asperity_delimited_text
  use asperity_byte_reader, only: byte_reader
  use asperity_input_text, only: blanks, line_end, skip_mark
  use asperity_kinds, only: int64
  use asperity_problems, only: decimal_text, problem_list
  implicit none
  private

  public :: cells_of, column_of, line_cells, line_reader, separator_of

  ! Bytes that are read at once, as many as a block of a file; a longer line needs more.
  integer, parameter :: block_length = 65536
  ! Bytes of a line that `next_line` returns (chosen): no line of a header is as long.
  integer, parameter :: longest_line = 200
  character(len=1), parameter :: feed = achar(10), return_sign = achar(13), tabulator = achar(9)

  !> The cells of one line, and the signs that separate them.
  type :: line_cells
    character(len=1) :: separator = ','        !! one sign; a blank: blanks and tabulators
    character(len=2) :: line_comments = '#'    !! a line that begins with one of them is a comment
    character(len=1) :: comment = feed         !! begins a comment within a line; a line feed: none
    logical :: keep_empty = .true.             !! empty cells are counted
    integer :: cell_count = 0                  !! number of cells; 0 behind the last line
    integer :: word = 0                        !! cell that `next_word` has returned
    integer :: line = 0                        !! number of the line
    integer :: start = 1                       !! place of column 1 of the line in the text
    integer, allocatable :: first(:), last(:)  !! places of each cell; last < first: an empty cell
  end type line_cells

  !> A file that is read by lines, and what is wrong with it.
  type, extends(byte_reader) :: line_reader
    type(problem_list) :: problems             !! what is wrong
    character(len=:), allocatable :: lack      !! why there is no memory for what the file holds
    type(line_cells) :: cells                  !! signs of the text, and cells of the line at hand
    character(len=:), allocatable :: lines     !! whole lines at hand
    integer, private :: place = 1              ! in `lines`, of the next line
    integer, private :: line = 1               ! its number
    integer, private :: margin = 0             ! bytes of line 1 before the first one of `lines`
    character(len=:), allocatable, private :: rest  ! bytes behind `lines`
  contains
    procedure :: begin_lines  !! starts line 1 at the next byte
    procedure :: begin_text   !! starts at the first line of the whole text
    procedure :: begin_memory !! starts at a text in memory
    procedure :: next_line    !! a copy of the next line
    procedure :: next_cells   !! cells of the next line that has some
    procedure :: next_word    !! the next cell, of whatever line
    procedure :: cell_text    !! a copy of a cell
    procedure :: refuse_cell  !! reports a problem at a cell
    procedure :: refuse_byte  !! reports a problem at a byte
    procedure :: is_refused   !! whether there is a problem, or no memory
    procedure :: next_byte    !! place of the next byte in the file
    procedure, private :: find_end, read_block
  end type line_reader

contains

  !> The sign between the cells of a line: a semicolon, a comma, a tabulator, or blanks.
  pure character(len=1) function separator_of(text)
    character(len=*), intent(in) :: text  !! line without its end

    separator_of = ' '
    if (index(text, tabulator) > 0) separator_of = tabulator
    if (index(text, ',') > 0) separator_of = ','
    if (index(text, ';') > 0) separator_of = ';'
  end function separator_of

  !> The cells of one line, which is no comment.
  pure function cells_of(text, separator, keep_empty) result(cells)
    character(len=*), intent(in) :: text       !! line without its end
    character(len=1), intent(in) :: separator  !! one sign; a blank: blanks and tabulators
    logical, intent(in) :: keep_empty          !! empty cells are counted
    type(line_cells) :: cells                  !! their places in the line
    integer :: at, line

    cells = line_cells(separator, line_comments='', keep_empty=keep_empty)
    at = 1
    line = 1
    call read_cells(text, at, line, cells)
  end function cells_of

  ! Finds the cells of the next line that has some. `at`, place where a line begins, and `line`, its
  ! number, are left at the next one.
  pure subroutine read_cells(text, at, line, cells)
    character(len=*), intent(in) :: text
    integer, intent(inout) :: at, line
    type(line_cells), intent(inout) :: cells
    integer :: first

    if (.not. allocated(cells%first)) allocate (cells%first(8), cells%last(8))
    cells%cell_count = 0
    do while (at <= len(text) .and. cells%cell_count == 0)
      cells%line = line
      cells%start = at
      first = at
      if (iachar(text(at:at)) <= iachar(' ')) &
        first = at - 1 + verify(text(at:line_end(text, at)), blanks)
      if (first < at) then
        at = line_end(text, at) + 2
      else if (scan(text(first:first), cells%line_comments) > 0 .and. &
               .not. is_error_value(text, first)) then
        at = line_end(text, at) + 2
      else
        call cut_line(text, at, cells)
      end if
      if (at <= len(text) + 1) line = min(line, huge(line) - 1) + 1
    end do
  end subroutine read_cells

  ! Cuts the line that begins at `at` into cells; `at` is left at the next line.
  pure subroutine cut_line(text, at, cells)
    character(len=*), intent(in) :: text
    integer, intent(inout) :: at
    type(line_cells), intent(inout) :: cells
    character(len=1) :: other
    integer :: i, from

    other = merge(tabulator, cells%separator, cells%separator == ' ')
    from = at
    do i = at, len(text)
      if (text(i:i) == feed) exit
      if (text(i:i) == cells%comment) then
        if (begins_comment(text, at, i)) exit
      end if
      if (text(i:i) /= cells%separator .and. text(i:i) /= other) cycle
      call add_cell(text, from, i - 1, cells)
      from = i + 1
    end do
    call add_cell(text, from, i - 1, cells)
    at = i + 1
    if (i <= len(text) .and. cells%comment /= feed) at = line_end(text, i) + 2
  end subroutine cut_line

  ! Whether a sign of comments within a line begins one: a `#` only behind a blank, so that
  ! `1.#QNAN` is a cell, and unless it is an error value of a spreadsheet.
  pure logical function begins_comment(text, first, at)
    character(len=*), intent(in) :: text  ! text of whole lines
    integer, intent(in) :: first          ! place where the line begins
    integer, intent(in) :: at             ! place of the sign

    begins_comment = .true.
    if (text(at:at) /= '#') return
    if (at > first) begins_comment = scan(text(at - 1:at - 1), ' ' // tabulator) == 1
    if (begins_comment) begins_comment = .not. is_error_value(text, at)
  end function begins_comment

  ! Whether a spreadsheet's word for a missing value begins at a place: `#N/A`, `#DIV/0!`.
  pure logical function is_error_value(text, at)
    character(len=*), intent(in) :: text
    integer, intent(in) :: at
    integer :: last

    last = min(len(text), at + 8)
    last = at - 2 + scan(text(at:last) // ' ', blanks // ',;')
    is_error_value = text(at:at) == '#' .and. scan(text(at:last), '/!?') > 0
  end function is_error_value

  ! Adds the cell `from:to` without the blanks around it; between blanks there is no empty cell.
  pure subroutine add_cell(text, from, to, cells)
    character(len=*), intent(in) :: text
    integer, intent(in) :: from, to
    type(line_cells), intent(inout) :: cells
    integer :: first, last

    first = from
    last = to
    if (to >= from) then
      if (iachar(text(from:from)) <= iachar(' ')) &
        first = from + max(0, verify(text(from:to), blanks) - 1)
      if (iachar(text(to:to)) <= iachar(' ')) &
        last = from + verify(text(from:to), blanks, back=.true.) - 1
    end if
    if (last < first .and. .not. cells%keep_empty) return
    if (cells%cell_count == size(cells%first)) then
      cells%first = [cells%first, cells%first]
      cells%last = [cells%last, cells%last]
    end if
    cells%cell_count = cells%cell_count + 1
    cells%first(cells%cell_count) = first
    cells%last(cells%cell_count) = last
  end subroutine add_cell

  !> Column of the line where a cell begins.
  pure integer function column_of(cells, i)
    type(line_cells), intent(in) :: cells  !! the cells of a line
    integer, intent(in) :: i               !! number of one of them

    column_of = cells%first(i) - cells%start + 1
  end function column_of

  !> Starts line 1 at the next byte.
  subroutine begin_lines(self)
    class(line_reader), intent(inout) :: self  !! file that is read by lines

    self%lines = ''
    self%rest = ''
    self%place = 1
    self%line = 1
    self%margin = int(self%before) + self%at - 1
  end subroutine begin_lines

  !> Starts at a text in memory in the place of a file.
  subroutine begin_memory(self, text)
    class(line_reader), intent(inout) :: self                    !! reader without a file
    character(len=:), allocatable, intent(inout) :: text         !! all lines, which are moved away

    call self%begin_lines()
    call move_alloc(text, self%lines)
  end subroutine begin_memory

  !> Starts at the first line of the whole text, which begins behind a mark of byte order.
  subroutine begin_text(self)
    class(line_reader), intent(inout) :: self  !! file that is read by lines

    call self%rewind()
    call skip_mark(self)
    call self%begin_lines()
  end subroutine begin_text

  ! Reads whole lines into `lines`, which stay as they are at the end of the file. A carriage return
  ! alone becomes a line feed.
  subroutine read_block(self)
    class(line_reader), intent(inout) :: self
    character(len=:), allocatable :: bytes
    integer :: length, before, last, i

    length = block_length
    do
      before = len(self%rest)
      call self%take(length, bytes)
      if (.not. allocated(bytes)) return
      self%rest = self%rest // bytes
      last = len(self%rest)
      if (len(bytes) == length) last = last - 1
      do i = max(1, before), last
        if (self%rest(i:i) /= return_sign) cycle
        if (self%rest(i + 1:min(i + 1, len(self%rest))) /= feed) self%rest(i:i) = feed
      end do
      if (len(bytes) < length) exit
      last = index(self%rest, feed, back=.true.)
      if (last > 0) exit
      length = len(self%rest)
      if (length >= 2**30) self%failure = 'cannot be read: a line of more than 1 GiB'
      if (allocated(self%failure)) return
    end do
    if (last == 0) return
    self%lines = self%rest(:last)
    self%rest = self%rest(last + 1:)
    self%place = 1
  end subroutine read_block

  !> Copies the next line, its end left out.
  subroutine next_line(self, text, line, column)
    class(line_reader), intent(inout) :: self            !! file that is read by lines
    character(len=:), allocatable, intent(out) :: text   !! 200 bytes at most; not allocated: none
    integer, intent(out) :: line                         !! its number, or the last one's
    integer, intent(out) :: column                       !! 1, or behind the end of the file
    integer :: last

    line = self%line
    column = 1
    if (self%place > len(self%lines)) call self%read_block()
    if (self%place > len(self%lines)) then
      call self%find_end(line, column)
      return
    end if
    last = line_end(self%lines, self%place)
    text = self%lines(self%place:min(last, self%place + longest_line - 1))
    if (last < self%place + longest_line .and. index(text, return_sign, back=.true.) == len(text)) &
      text = text(:max(0, len(text) - 1))
    self%place = last + 2
    if (last < len(self%lines)) self%line = self%line + 1
  end subroutine next_line

  !> Finds the cells of the next line that has some; their places are those in `lines`. Behind the
  !> last one the first cell stands at the end of the file.
  subroutine next_cells(self)
    class(line_reader), intent(inout) :: self  !! file that is read by lines

    associate (cells => self%cells)
      do
        call read_cells(self%lines, self%place, self%line, cells)
        if (cells%line == 1) cells%start = cells%start - self%margin
        if (cells%cell_count > 0) return
        call self%read_block()
        if (self%place > len(self%lines)) exit
      end do
      cells%start = 1
      call self%find_end(cells%line, cells%first(1))
    end associate
  end subroutine next_cells

  !> The next cell of whatever line; empty at the end of the file.
  subroutine next_word(self, word)
    class(line_reader), intent(inout) :: self           !! file that is read by lines
    character(len=:), allocatable, intent(out) :: word  !! as it is written

    self%cells%word = self%cells%word + 1
    if (self%cells%word > self%cells%cell_count) then
      call self%next_cells()
      self%cells%word = 1
    end if
    word = ''
    if (self%cells%cell_count > 0) word = self%cell_text(self%cells%word)
  end subroutine next_word

  !> The text of a cell of the line at hand.
  pure function cell_text(self, i) result(text)
    class(line_reader), intent(in) :: self  !! file that is read by lines
    integer, intent(in) :: i                !! number of the cell
    character(len=:), allocatable :: text   !! as it is written

    text = self%lines(self%cells%first(i):self%cells%last(i))
  end function cell_text

  !> Reports a problem at a cell of the line at hand.
  pure subroutine refuse_cell(self, i, message)
    class(line_reader), intent(inout) :: self  !! file that is read by lines
    integer, intent(in) :: i                   !! number of the cell
    character(len=*), intent(in) :: message    !! fault, text found and expected

    call self%problems%add_at(self%cells%line, column_of(self%cells, i), message)
  end subroutine refuse_cell

  !> Reports a problem at a byte of a file without lines.
  pure subroutine refuse_byte(self, byte, message)
    class(line_reader), intent(inout) :: self  !! file that is read as bytes
    integer(int64), intent(in) :: byte         !! its place, from 1
    character(len=*), intent(in) :: message    !! behind the number of the byte

    call self%problems%add_in_file('byte ' // decimal_text(byte) // message)
  end subroutine refuse_byte

  !> Whether a problem was found, or there is no memory for what the file holds.
  pure logical function is_refused(self)
    class(line_reader), intent(in) :: self  !! file that is read by lines

    is_refused = self%problems%count() > 0 .or. allocated(self%lack)
  end function is_refused

  !> Place in the file of the first byte that no line had, from 1.
  pure integer(int64) function next_byte(self)
    class(line_reader), intent(in) :: self  !! the file, read by lines or not

    next_byte = self%before + int(self%at, int64)
    if (allocated(self%lines)) &
      next_byte = next_byte - max(0, len(self%lines) - self%place + 1) - len(self%rest)
  end function next_byte

  ! Finds line and column behind the last byte of the file, when no line is left.
  pure subroutine find_end(self, line, column)
    class(line_reader), intent(in) :: self
    integer, intent(out) :: line, column

    line = self%line
    column = len(self%lines) - index(self%lines, feed, back=.true.) + 1
    if (line == 1) column = column + self%margin
  end subroutine find_end

end module asperity_delimited_text
