!> A text that grows line by line: what every writer fills before anything is written out.
module asperity_text_buffer
  use asperity_kinds, only: int64
  implicit none
  private

  public :: text_buffer

  !> Text under construction. Lines end with a line feed.
  type :: text_buffer
    character(len=:), allocatable :: store  !! not allocated: nothing was added yet
    integer(int64) :: used = 0_int64        !! characters of `store` that are text
    logical :: failed = .false.             !! there was no memory for it: the text is not whole
  contains
    procedure :: append => buffer_append  !! adds characters without a line end
    procedure :: append_text              !! adds another text
    procedure :: line => buffer_line      !! adds one line; blanks at its end are dropped
    procedure :: text => buffer_text      !! the text so far
  end type text_buffer

contains

  !> Adds `piece` as it stands.
  pure subroutine buffer_append(self, piece)
    class(text_buffer), intent(inout) :: self  !! the text
    character(len=*), intent(in) :: piece      !! characters to add
    character(len=:), allocatable :: larger
    integer(int64) :: needed
    integer :: status

    if (self%failed) return
    if (.not. allocated(self%store)) allocate (character(len=4096) :: self%store)
    needed = self%used + len(piece, int64)
    if (needed > len(self%store, int64)) then
      allocate (character(len=max(needed, 2_int64 * len(self%store, int64))) :: larger, &
                stat=status)
      self%failed = status /= 0
      if (self%failed) return
      larger(:self%used) = self%store(:self%used)
      call move_alloc(larger, self%store)
    end if
    self%store(self%used + 1_int64:needed) = piece
    self%used = needed
  end subroutine buffer_append

  !> Adds another text, without a copy of it. A text that is not whole makes this one so, too.
  pure subroutine append_text(self, other)
    class(text_buffer), intent(inout) :: self  !! the text
    type(text_buffer), intent(in) :: other     !! what is added

    if (allocated(other%store)) call self%append(other%store(:other%used))
    self%failed = self%failed .or. other%failed
  end subroutine append_text

  !> Adds `piece` without its trailing blanks, and a line feed.
  pure subroutine buffer_line(self, piece)
    class(text_buffer), intent(inout) :: self  !! the text
    character(len=*), intent(in) :: piece      !! the line

    call self%append(piece(:len_trim(piece)) // new_line('a'))
  end subroutine buffer_line

  !> The text so far.
  pure function buffer_text(self) result(text)
    class(text_buffer), intent(in) :: self  !! the text
    character(len=:), allocatable :: text   !! a copy of it

    ! An assignment alone would not notice an end of memory.
    allocate (character(len=self%used) :: text)
    if (allocated(self%store)) text(:) = self%store(:self%used)
  end function buffer_text

end module asperity_text_buffer
