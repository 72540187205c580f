!> A text that grows line by line, which writers fill before it is written to a file.
!>
!> Printable text of any bytes of a file or a command line, for a terminal.
module asperity_text_buffer
  use asperity_kinds, only: int64
  implicit none
  private

  public :: text_buffer, printable_text

  !> Text under construction. Lines end with a line feed.
  type :: text_buffer
    character(len=:), allocatable :: store  !! text and room; not allocated: no text
    integer(int64) :: used = 0_int64        !! number of characters of the text
    logical :: failed = .false.             !! whether memory was short: incomplete
  contains
    procedure :: append => buffer_append  !! appends characters without a line end
    procedure :: append_text              !! appends another text
    procedure :: line => buffer_line      !! appends one line without blanks at its end
    procedure :: text => buffer_text      !! the text so far
  end type text_buffer

contains

  !> Appends characters.
  pure subroutine buffer_append(self, piece)
    class(text_buffer), intent(inout) :: self  !! text that is extended
    character(len=*), intent(in) :: piece      !! characters to append
    character(len=:), allocatable :: larger
    integer(int64) :: needed
    integer :: status

    if (self%failed) return
    if (.not. allocated(self%store)) allocate (character(len=4096) :: self%store)
    needed = self%used + len(piece, int64)
    if (needed > len(self%store, int64)) then
      allocate (character(len=max(needed, 2_int64 * len(self%store, int64))) :: larger, stat=status)
      self%failed = status /= 0
      if (self%failed) return
      larger(:self%used) = self%store(:self%used)
      call move_alloc(larger, self%store)
    end if
    self%store(self%used + 1_int64:needed) = piece
    self%used = needed
  end subroutine buffer_append

  !> Appends another text, without a copy of it. After an incomplete text this one is incomplete.
  pure subroutine append_text(self, other)
    class(text_buffer), intent(inout) :: self  !! text that is extended
    type(text_buffer), intent(in) :: other     !! text to append

    if (allocated(other%store)) call self%append(other%store(:other%used))
    self%failed = self%failed .or. other%failed
  end subroutine append_text

  !> Appends characters without trailing blanks, and a line feed.
  pure subroutine buffer_line(self, piece)
    class(text_buffer), intent(inout) :: self  !! text that is extended
    character(len=*), intent(in) :: piece      !! line to append

    call self%append(piece(:len_trim(piece)) // new_line('a'))
  end subroutine buffer_line

  !> The text so far.
  pure function buffer_text(self) result(text)
    class(text_buffer), intent(in) :: self  !! text so far
    character(len=:), allocatable :: text   !! copy of the text

    ! An assignment would not detect a lack of memory.
    allocate (character(len=self%used) :: text)
    if (allocated(self%store)) text(:) = self%store(:self%used)
  end function buffer_text

  !> Replaces each byte that is no part of printable UTF-8 by a question mark: control characters,
  !> broken sequences, and marks that change the direction of the text.
  pure function printable_text(text) result(shown)
    character(len=*), intent(in) :: text  !! text of any bytes
    character(len=len(text)) :: shown     !! printable text of the same length
    integer :: i, length

    i = 1
    do while (i <= len(text))
      length = letter_length(text(i:))
      if (length == 0) then
        shown(i:i) = '?'
        i = i + 1
      else
        shown(i:i + length - 1) = text(i:i + length - 1)
        i = i + length
      end if
    end do
  end function printable_text

  !> Bytes of the printable letter at the start of a text; 0 when there is none.
  pure integer function letter_length(text)
    character(len=*), intent(in) :: text
    ! Least code of each number of bytes: a longer encoding is not valid UTF-8.
    integer, parameter :: least(4) = [0, 128, 2048, 65536]
    integer :: code, first, i

    letter_length = 0
    first = iachar(text(1:1))
    select case (first)
    case (32:126)
      letter_length = 1
      return
    case (194:223)
      code = first - 192
      letter_length = 2
    case (224:239)
      code = first - 224
      letter_length = 3
    case (240:244)
      code = first - 240
      letter_length = 4
    case default
      return
    end select
    do i = 2, letter_length
      if (i > len(text)) then
        code = -1
      else if (iachar(text(i:i)) < 128 .or. iachar(text(i:i)) > 191) then
        code = -1
      else
        code = 64 * code + iachar(text(i:i)) - 128
      end if
      if (code < 0) exit
    end do
    if (code < 0 .or. code < least(letter_length) .or. is_hidden(code)) letter_length = 0
  end function letter_length

  !> Controls, halves of pairs, blanks other than the blank, marks of direction, private codes.
  pure logical function is_hidden(code)
    integer, intent(in) :: code

    select case (code)
    case (128:160, 173, 1564, 5760, 6158, 8192:8207, 8232:8239, 8287:8303, 12288, 55296:63743, &
          65024:65039, 65279, 65520:65535)
      is_hidden = .true.
    case default
      is_hidden = code > 917503
    end select
  end function is_hidden

end module asperity_text_buffer
