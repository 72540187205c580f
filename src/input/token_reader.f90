!> Words of a text of any length, one after the other, each with its line and column.
!>
!> A line ends with a line feed, a carriage return, or both.
module asperity_token_reader
  use asperity_byte_reader, only: byte_reader
  use asperity_input_text, only: text_start
  use asperity_kinds, only: int64
  implicit none
  private

  public :: token_reader, token

  integer, parameter :: of_word = 0, is_blank = 1, is_feed = 2, is_return = 3, is_cell_end = 4, &
                        is_comment = 5
  integer, parameter :: longest = 120, longest_line = 200

  !> A word; a longer one is cut, which no number is.
  type :: token
    character(len=longest) :: text = ''   !! its bytes
    integer :: length = 0                 !! 0 at the end of the file
    integer :: line = 1                   !! where it begins
    integer :: column = 1                 !! where it begins
    logical :: cell_missing = .false.     !! an empty cell stands before it, or behind the last
    logical :: is_cut = .false.           !! it is longer than its text here
  end type token

  !> A file that is read as words.
  type, extends(byte_reader) :: token_reader
    integer :: line = 1                            !! of the next byte
    integer :: class_of(0:255) = of_word           !! what a byte does
    integer(int64), private :: line_begin = 0_int64
    logical, private :: after_return = .false., after_cell_end = .false., line_is_new = .true.
  contains
    procedure :: start      !! sets what separates words
    procedure :: next       !! the next word
    procedure :: next_line  !! the rest of the line
    procedure :: again      !! from the first byte on, once more
    procedure :: skip_to    !! goes to the beginning of a line
  end type token_reader

contains

  !> Sets what separates words, beside blanks and tabs: characters that end a cell, and those that
  !> make the rest of the line a comment, a per cent sign at the beginning of a line alone.
  subroutine start(self, cell_ends, comments)
    class(token_reader), intent(inout) :: self  !! opened
    character(len=*), intent(in) :: cell_ends   !! for instance a comma
    character(len=*), intent(in) :: comments    !! for instance a number sign
    integer :: i

    self%class_of(:) = of_word
    self%class_of(iachar(' ')) = is_blank
    self%class_of(9) = is_blank
    self%class_of(10) = is_feed
    self%class_of(13) = is_return
    do i = 1, len(cell_ends)
      self%class_of(iachar(cell_ends(i:i))) = is_cell_end
    end do
    do i = 1, len(comments)
      self%class_of(iachar(comments(i:i))) = is_comment
    end do
  end subroutine start

  !> The next word.
  subroutine next(self, word)
    class(token_reader), intent(inout) :: self  !! the file
    type(token), intent(out) :: word            !! its length is 0 at the end of the file
    integer :: code
    logical :: in_comment

    in_comment = .false.
    do
      if (self%at > self%used) call self%more()
      if (self%at > self%used) exit
      code = self%class_of(iachar(self%block(self%at:self%at)))
      if (code == is_comment .and. .not. self%line_is_new) then
        if (self%block(self%at:self%at) == '%') code = of_word
      end if
      if (in_comment .and. code /= is_feed .and. code /= is_return) code = is_blank
      select case (code)
      case (of_word)
        if (word%length == 0) then
          word%line = self%line
          word%column = int(self%before + int(self%at, int64) - self%line_begin)
        end if
        word%length = word%length + 1
        if (word%length <= longest) then
          word%text(word%length:word%length) = self%block(self%at:self%at)
        else
          word%length = longest
          word%is_cut = .true.
        end if
        ! Blanks to come do not make the next cell end one of an empty cell.
        self%after_cell_end = .false.
        self%line_is_new = .false.
        self%after_return = .false.
      case default
        if (word%length > 0) return
        select case (code)
        case (is_feed, is_return)
          call end_line(self, code)
          in_comment = .false.
        case (is_cell_end)
          if (self%after_cell_end .or. self%line_is_new) word%cell_missing = .true.
          self%after_cell_end = .true.
          self%line_is_new = .false.
          self%after_return = .false.
        case (is_comment)
          in_comment = .true.
        case default
          continue
        end select
      end select
      self%at = self%at + 1
    end do
    if (word%length > 0) return
    word%line = self%line
    word%column = int(self%before + int(self%at, int64) - self%line_begin)
  end subroutine next

  !> The rest of the line, its end left out, and the place where it begins. A long line is cut.
  subroutine next_line(self, text, line, column)
    class(token_reader), intent(inout) :: self           !! the file
    character(len=:), allocatable, intent(out) :: text   !! not allocated at the end of the file
    integer, intent(out) :: line                         !! of the first byte
    integer, intent(out) :: column                       !! of the first byte
    integer :: code

    call skip_feed(self)
    line = self%line
    column = int(self%before + int(self%at, int64) - self%line_begin)
    do
      if (self%at > self%used) call self%more()
      if (self%at > self%used) return
      if (.not. allocated(text)) text = ''
      code = self%class_of(iachar(self%block(self%at:self%at)))
      self%at = self%at + 1
      if (code == is_feed .or. code == is_return) then
        self%at = self%at - 1
        call end_line(self, code)
        self%at = self%at + 1
        return
      end if
      self%after_return = .false.
      if (len(text) < longest_line) text = text // self%block(self%at - 1:self%at - 1)
    end do
  end subroutine next_line

  ! The byte at hand ends a line.
  subroutine end_line(self, code)
    class(token_reader), intent(inout) :: self
    integer, intent(in) :: code

    if (.not. (code == is_feed .and. self%after_return)) self%line = self%line + 1
    self%after_return = code == is_return
    self%line_begin = self%before + int(self%at, int64)
    self%after_cell_end = .false.
    self%line_is_new = .true.
  end subroutine end_line

  !> Goes on to the beginning of a line.
  subroutine skip_to(self, line)
    class(token_reader), intent(inout) :: self  !! the file, not behind that line
    integer, intent(in) :: line                 !! its number
    character(len=:), allocatable :: text
    integer :: number, column

    do while (self%line < line)
      call self%next_line(text, number, column)
    end do
    call skip_feed(self)
  end subroutine skip_to

  ! Steps over the line feed behind a carriage return.
  subroutine skip_feed(self)
    class(token_reader), intent(inout) :: self

    if (self%at > self%used) call self%more()
    if (self%at > self%used .or. .not. self%after_return) return
    if (self%block(self%at:self%at) /= achar(10)) return
    call end_line(self, is_feed)
    self%at = self%at + 1
  end subroutine skip_feed

  !> Goes back to the first byte, behind the mark of byte order that some programs write before
  !> UTF-8.
  subroutine again(self)
    class(token_reader), intent(inout) :: self  !! the file

    call self%rewind()
    if (self%at > self%used) call self%more()
    if (self%used >= 3) self%at = text_start(self%block(:self%used))
    self%line = 1
    self%line_begin = 0_int64
    self%after_return = .false.
    self%after_cell_end = .false.
    self%line_is_new = .true.
  end subroutine again

end module asperity_token_reader
