!> Files read at once, and the two standard streams. What is written as a file is the matter of
!> `asperity_output_files`.
module asperity_files
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_long, c_null_char, c_size_t
  use asperity_kinds, only: int64
  use asperity_printable, only: printable
  use asperity_problems, only: decimal_text
  use asperity_system_calls, only: posix_close, posix_lseek, posix_open, posix_read, &
                                   posix_usleep, posix_write, system_error, system_reason
  implicit none
  private

  public :: same_name, read_whole_file, write_standard_output, write_standard_error, write_message
  public :: write_bytes, standard_output, standard_error

  !> Descriptors of the standard streams.
  integer(c_int), parameter :: standard_output = 1_c_int, standard_error = 2_c_int

  integer(c_int), parameter :: read_only = 0_c_int, from_end = 2_c_int, from_start = 0_c_int
  ! EAGAIN: a pipe that does not wait is full.
  integer(c_int), parameter :: full_for_now = 11_c_int, wait_microseconds = 1000_c_int
  ! Bytes of a file, and of a pipe or device: one that never ends must not fill the memory.
  integer, parameter :: longest_file = 1000000000, longest_pipe = 100000000
  integer, parameter :: block_size = 65536

contains

  !> Whether two paths are spelled alike. A name may end with blanks, which Fortran's == leaves out.
  pure logical function same_name(a, b)
    character(len=*), intent(in) :: a  !! a path
    character(len=*), intent(in) :: b  !! a path

    same_name = len(a) == len(b) .and. a == b
  end function same_name

  !> Reads a file whole. `failure` is allocated, with the reason, when it cannot be read. A file may
  !> have 1000000000 bytes, a pipe or a device 100000000.
  subroutine read_whole_file(path, text, failure)
    character(len=*), intent(in) :: path                         !! the file
    character(len=:), allocatable, intent(out) :: text           !! its bytes
    character(len=:), allocatable, intent(out) :: failure        !! why not
    character(len=:), allocatable :: larger
    character(len=block_size) :: block
    integer(c_long) :: known, place
    integer(c_size_t) :: got
    integer(c_int) :: descriptor, status
    integer :: used, longest

    text = ''
    descriptor = posix_open(path // c_null_char, read_only)
    if (descriptor < 0) then
      failure = path // ': cannot be opened: ' // system_reason()
      return
    end if
    known = posix_lseek(descriptor, 0_c_long, from_end)
    place = posix_lseek(descriptor, 0_c_long, from_start)
    longest = longest_pipe
    if (known > 0_c_long .and. place == 0_c_long) longest = longest_file
    used = 0
    if (known <= int(longest, c_long)) then
      deallocate (text)
      ! As long as the file: it need not be copied to be cut.
      allocate (character(len=max(0, int(known))) :: text)
      do while (used <= longest)
        if (used < len(text)) then
          got = posix_read(descriptor, text(used + 1:), int(len(text) - used, c_size_t))
        else
          got = posix_read(descriptor, block, int(len(block), c_size_t))
        end if
        if (got < 0_c_size_t) failure = path // ': cannot be read: ' // system_reason()
        if (got <= 0_c_size_t) exit
        if (used == len(text)) then
          allocate (character(len=2 * used + block_size) :: larger)
          larger(:used) = text
          larger(used + 1:used + int(got)) = block(:got)
          call move_alloc(larger, text)
        end if
        used = used + int(got)
      end do
      if (used <= longest .and. used < len(text)) text = text(:used)
    end if
    if (known > int(longest, c_long) .or. used > longest) then
      text = ' '
      ! A folder can have any length, but refuses to be read: that is what to tell.
      got = posix_read(descriptor, text, 1_c_size_t)
      if (got < 0_c_size_t) then
        failure = path // ': cannot be read: ' // system_reason()
      else
        failure = path // ': cannot be read: more than ' // decimal_text(longest) // ' bytes'
      end if
      text = ''
    end if
    status = posix_close(descriptor)
  end subroutine read_whole_file

  !> Writes to standard output; `failure` is allocated when that is not possible.
  subroutine write_standard_output(text, failure)
    character(len=*), intent(in) :: text                   !! what to write
    character(len=:), allocatable, intent(out) :: failure  !! why not

    call write_bytes(standard_output, text, failure)
    if (allocated(failure)) failure = 'standard output: cannot be written: ' // failure
  end subroutine write_standard_output

  !> Writes to standard error. A failure there has nowhere to go and is ignored.
  subroutine write_standard_error(text)
    character(len=*), intent(in) :: text  !! what to write
    character(len=:), allocatable :: failure

    call write_bytes(standard_error, text, failure)
  end subroutine write_standard_error

  !> Writes one line to standard error, made printable.
  subroutine write_message(text)
    character(len=*), intent(in) :: text  !! the line, without its end

    call write_standard_error(printable(text) // new_line('a'))
  end subroutine write_message

  !> Writes all of `text`, in as many calls as the system asks for.
  subroutine write_bytes(descriptor, text, failure)
    integer(c_int), intent(in) :: descriptor               !! where to
    character(len=*), intent(in) :: text                   !! what to write
    character(len=:), allocatable, intent(out) :: failure  !! why not
    integer(c_size_t) :: written
    integer(c_int) :: status
    integer(int64) :: first

    first = 1_int64
    do while (first <= len(text, int64))
      written = posix_write(descriptor, text(first:), &
                            int(len(text, int64) - first + 1_int64, c_size_t))
      status = 0
      if (written < 0_c_size_t) status = int(system_error(), c_int)
      if (written > 0_c_size_t) then
        first = first + int(written, int64)
      else if (status == full_for_now) then
        status = posix_usleep(wait_microseconds)
      else
        failure = system_reason()
        return
      end if
    end do
  end subroutine write_bytes

end module asperity_files
