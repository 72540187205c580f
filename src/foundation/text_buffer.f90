!> A text that grows line by line, which writers fill before it is written to a file.
module asperity_text_buffer
  use asperity_kinds, only: int64
  implicit none
  private

  public :: text_buffer

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

end module asperity_text_buffer
