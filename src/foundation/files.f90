!> Reading of whole files, and the two standard streams. Output files are written by
!> `asperity_output_files`.
module asperity_files
  use, intrinsic :: iso_c_binding, only: c_int, c_size_t
  use asperity_byte_reader, only: byte_reader
  use asperity_kinds, only: int64
  use asperity_system_calls, only: posix_usleep, posix_write, system_error, system_reason
  implicit none
  private

  public :: same_name, read_whole_file, write_standard_output, write_standard_error
  public :: write_bytes, standard_output, standard_error

  !> Descriptors of the standard streams.
  integer(c_int), parameter :: standard_output = 1_c_int, standard_error = 2_c_int

  ! EAGAIN: a pipe without blocking is full.
  integer(c_int), parameter :: full_for_now = 11_c_int, wait_microseconds = 1000_c_int

contains

  !> Whether two paths have the same spelling. Blanks at the end, which == ignores, count.
  pure logical function same_name(a, b)
    character(len=*), intent(in) :: a, b  !! paths of two files

    same_name = len(a) == len(b) .and. a == b
  end function same_name

  !> Reads a whole file. `failure` is allocated, with the reason, when it cannot be read. A file may
  !> have 1000000000 bytes, a pipe or a device 100000000.
  subroutine read_whole_file(path, text, failure)
    character(len=*), intent(in) :: path                         !! path of the file
    character(len=:), allocatable, intent(out) :: text           !! bytes of the file
    character(len=:), allocatable, intent(out) :: failure        !! reason, when it cannot be read
    type(byte_reader) :: file

    call file%open(path)
    if (.not. allocated(file%failure)) call file%take_whole(text)
    if (allocated(file%failure)) failure = path // ': ' // file%failure
    call file%close()
    if (allocated(failure)) text = ''
  end subroutine read_whole_file

  !> Writes to standard output; `failure` is allocated when that is not possible.
  subroutine write_standard_output(text, failure)
    character(len=*), intent(in) :: text                   !! text to write
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it cannot be written

    call write_bytes(standard_output, text, failure)
    if (allocated(failure)) failure = 'standard output: cannot be written: ' // failure
  end subroutine write_standard_output

  !> Writes to standard error. A failure cannot be reported and is ignored.
  subroutine write_standard_error(text)
    character(len=*), intent(in) :: text  !! text to write
    character(len=:), allocatable :: failure

    call write_bytes(standard_error, text, failure)
  end subroutine write_standard_error

  !> Writes a whole text, in as many calls as the system needs.
  subroutine write_bytes(descriptor, text, failure)
    integer(c_int), intent(in) :: descriptor               !! descriptor of the open file
    character(len=*), intent(in) :: text                   !! text to write
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it cannot be written
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
