!> Whole files: read at once, written at once. A written file appears by rename, whole or not at
!> all; a device or a pipe is written as it stands.
module asperity_files
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char, c_ptr, c_size_t, &
                                         c_associated, c_f_pointer, c_null_ptr
  use asperity_problems, only: decimal_text
  use asperity_process, only: process_number
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: read_whole_file, write_whole_file, write_standard_output, write_standard_error

  integer(c_int), parameter :: standard_output = 1_c_int, standard_error = 2_c_int
  integer(c_int), parameter :: mode_rw_r_r = int(o'644', c_int), write_only = 1_c_int
  ! Bytes a pipe may give: a device that never ends must not fill the memory.
  integer, parameter :: longest_pipe = 100000000

  interface
    integer(c_int) function posix_creat(path, mode) bind(c, name='creat')
      import :: c_char, c_int
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: mode
    end function posix_creat

    integer(c_int) function posix_open(path, flags) bind(c, name='open')
      import :: c_char, c_int
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: flags
    end function posix_open

    integer(c_int) function posix_fsync(descriptor) bind(c, name='fsync')
      import :: c_int
      implicit none
      integer(c_int), value :: descriptor
    end function posix_fsync

    type(c_ptr) function posix_realpath(path, resolved) bind(c, name='realpath')
      import :: c_char, c_ptr
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      type(c_ptr), value :: resolved
    end function posix_realpath

    subroutine posix_free(memory) bind(c, name='free')
      import :: c_ptr
      implicit none
      type(c_ptr), value :: memory
    end subroutine posix_free

    integer(c_size_t) function posix_write(descriptor, bytes, count) bind(c, name='write')
      import :: c_char, c_int, c_size_t
      implicit none
      integer(c_int), value :: descriptor
      character(kind=c_char), intent(in) :: bytes(*)
      integer(c_size_t), value :: count
    end function posix_write

    integer(c_int) function posix_close(descriptor) bind(c, name='close')
      import :: c_int
      implicit none
      integer(c_int), value :: descriptor
    end function posix_close

    integer(c_int) function posix_rename(from, to) bind(c, name='rename')
      import :: c_char, c_int
      implicit none
      character(kind=c_char), intent(in) :: from(*), to(*)
    end function posix_rename

    integer(c_int) function posix_unlink(path) bind(c, name='unlink')
      import :: c_char, c_int
      implicit none
      character(kind=c_char), intent(in) :: path(*)
    end function posix_unlink

    type(c_ptr) function errno_location() bind(c, name='__errno_location')
      import :: c_ptr
      implicit none
    end function errno_location

    type(c_ptr) function posix_strerror(number) bind(c, name='strerror')
      import :: c_int, c_ptr
      implicit none
      integer(c_int), value :: number
    end function posix_strerror
  end interface

contains

  !> Reads a file whole. `failure` is allocated, with the reason, when it cannot be read.
  subroutine read_whole_file(path, text, failure)
    character(len=*), intent(in) :: path                         !! the file
    character(len=:), allocatable, intent(out) :: text           !! its bytes
    character(len=:), allocatable, intent(out) :: failure        !! why not
    character(len=256) :: message
    character(len=1) :: byte
    type(text_buffer) :: bytes
    integer :: unit, status, length

    text = ''
    message = ''
    open (newunit=unit, file=path, status='old', action='read', access='stream', &
          form='unformatted', iostat=status, iomsg=message)
    if (status /= 0) then
      failure = path // ': cannot be opened: ' // reason_of(message)
      return
    end if
    inquire (unit=unit, size=length)
    if (length > 0) then
      deallocate (text)
      allocate (character(len=length) :: text)
      read (unit, iostat=status, iomsg=message) text
    else
      ! A pipe has no size: byte by byte until it ends.
      do while (bytes%length() < longest_pipe)
        read (unit, iostat=status, iomsg=message) byte
        if (status /= 0) exit
        call bytes%append(byte)
      end do
      if (status == 0) then
        status = 1
        message = 'more than ' // decimal_text(longest_pipe) // ' bytes'
      else if (is_iostat_end(status)) then
        status = 0
      end if
      text = bytes%text()
    end if
    if (status /= 0) failure = path // ': cannot be read: ' // reason_of(message)
    close (unit, iostat=status)
  end subroutine read_whole_file

  !> Writes a file whole: beside its place first, then renamed onto it. A link stays a link.
  !> `failure` is allocated, with the reason, when that is not possible; nothing is left then.
  subroutine write_whole_file(path, text, failure)
    character(len=*), intent(in) :: path                   !! the file
    character(len=*), intent(in) :: text                   !! its bytes
    character(len=:), allocatable, intent(out) :: failure  !! why not
    character(len=:), allocatable :: place, beside
    integer(c_int) :: descriptor, status

    descriptor = special_file(path)
    if (descriptor >= 0) then
      call write_bytes(descriptor, text, failure)
      if (descriptor /= standard_output) status = posix_close(descriptor)
      if (allocated(failure)) failure = path // ': cannot be written: ' // failure
      return
    end if
    place = resolved(path)
    beside = place // '.' // decimal_text(process_number()) // '.part'
    descriptor = posix_creat(beside // c_null_char, mode_rw_r_r)
    if (descriptor < 0) then
      failure = path // ': cannot be written: ' // system_reason()
      return
    end if
    call write_bytes(descriptor, text, failure)
    status = posix_close(descriptor)
    if (status /= 0 .and. .not. allocated(failure)) failure = system_reason()
    if (.not. allocated(failure)) then
      status = posix_rename(beside // c_null_char, place // c_null_char)
      if (status /= 0) failure = system_reason()
    end if
    if (allocated(failure)) then
      failure = path // ': cannot be written: ' // failure
      status = posix_unlink(beside // c_null_char)
    end if
  end subroutine write_whole_file

  !> Opens a device or a pipe for writing; -1 for anything else. A rename would put a file in its
  !> place: nobody wants that of /dev/null.
  function special_file(path) result(descriptor)
    character(len=*), intent(in) :: path
    integer(c_int) :: descriptor, status

    if (path == '/dev/stdout') then
      ! Perhaps a file, but one whose writing has begun.
      descriptor = standard_output
      return
    end if
    descriptor = posix_open(path // c_null_char, write_only)
    if (descriptor < 0) return
    ! Files can be brought to the disk; devices and pipes refuse.
    if (posix_fsync(descriptor) /= 0) return
    status = posix_close(descriptor)
    descriptor = -1
  end function special_file

  !> The file behind symbolic links; the path itself when there is none yet.
  function resolved(path) result(place)
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: place
    type(c_ptr) :: letters

    letters = posix_realpath(path // c_null_char, c_null_ptr)
    if (c_associated(letters)) then
      place = text_of(letters)
      call posix_free(letters)
    else
      place = path
    end if
  end function resolved

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

  !> Writes all of `text`, in as many calls as the system asks for.
  subroutine write_bytes(descriptor, text, failure)
    integer(c_int), intent(in) :: descriptor
    character(len=*), intent(in) :: text
    character(len=:), allocatable, intent(out) :: failure
    integer(c_size_t) :: written
    integer :: first

    first = 1
    do while (first <= len(text))
      written = posix_write(descriptor, text(first:), int(len(text) - first + 1, c_size_t))
      if (written <= 0) then
        failure = system_reason()
        return
      end if
      first = first + int(written)
    end do
  end subroutine write_bytes

  !> What the system says of its last refusal.
  function system_reason() result(reason)
    character(len=:), allocatable :: reason
    integer(c_int), pointer :: errno

    call c_f_pointer(errno_location(), errno)
    reason = text_of(posix_strerror(errno))
  end function system_reason

  !> A text of the C library, which ends with a null character.
  function text_of(address) result(text)
    type(c_ptr), intent(in) :: address
    character(len=:), allocatable :: text
    character(kind=c_char), pointer :: letters(:)
    integer :: i

    call c_f_pointer(address, letters, [huge(i)])
    text = ''
    do i = 1, size(letters)
      if (letters(i) == c_null_char) exit
      text = text // letters(i)
    end do
  end function text_of

  !> The last part of a compiler's message about a file: the system's own words.
  pure function reason_of(message) result(reason)
    character(len=*), intent(in) :: message
    character(len=:), allocatable :: reason

    reason = trim(message(index(message, ': ', back=.true.) + 1:))
    reason = trim(adjustl(reason))
  end function reason_of

end module asperity_files
