!> Interfaces to the C library: descriptors, names of files, signals, memory.
module asperity_system_calls
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, c_funptr, &
                                         c_int, c_int32_t, c_long, c_null_char, c_ptr, c_size_t
  implicit none
  private

  public :: posix_open, posix_mkstemps, posix_umask, posix_lseek, posix_read, posix_write
  public :: posix_close
  public :: file_owner, is_regular_file, posix_chmod, posix_chown
  public :: posix_rename, posix_unlink, posix_usleep, posix_signal
  public :: posix_isatty, posix_getpid, posix_exit
  public :: posix_execv, posix_setenv, posix_getrlimit, c_strfromd
  public :: system_error, system_reason, canonical_path, text_of

  ! PATH_MAX of Linux, with the null character.
  integer, parameter :: longest_path = 4096
  integer(c_int), parameter :: this_folder = -100_c_int  ! AT_FDCWD

  interface
    !> Opens a file or device; -1 when refused.
    integer(c_int) function posix_open(path, flags) bind(c, name='open')
      import :: c_char, c_int
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: flags
    end function posix_open

    !> Creates a file that did not exist, for reading and writing by its owner; its path with random
    !> letters in place of six X before a suffix; -1 when refused. A link is not followed.
    integer(c_int) function posix_mkstemps(path, suffix) bind(c, name='mkstemps')
      import :: c_char, c_int
      implicit none
      character(kind=c_char), intent(inout) :: path(*)
      integer(c_int), value :: suffix
    end function posix_mkstemps

    !> Sets the permissions that new files do not get; those before.
    integer(c_int) function posix_umask(mask) bind(c, name='umask')
      import :: c_int
      implicit none
      integer(c_int), value :: mask
    end function posix_umask

    !> Reads the attributes of a file (Linux, statx(2)); -1 when there is none.
    integer(c_int) function posix_statx(folder, path, flags, mask, found) bind(c, name='statx')
      import :: c_char, c_int, c_int32_t
      implicit none
      integer(c_int), value :: folder, flags, mask
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int32_t), intent(out) :: found(64)
    end function posix_statx

    !> Sets the permission bits of a file; -1 when refused.
    integer(c_int) function posix_chmod(path, mode) bind(c, name='chmod')
      import :: c_char, c_int
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: mode
    end function posix_chmod

    !> Sets the owner and the group of a file; -1 when refused.
    integer(c_int) function posix_chown(path, owner, group) bind(c, name='chown')
      import :: c_char, c_int
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: owner, group
    end function posix_chown

    !> Moves to a position of a file; -1 for a pipe.
    integer(c_long) function posix_lseek(descriptor, offset, whence) bind(c, name='lseek')
      import :: c_int, c_long
      implicit none
      integer(c_int), value :: descriptor
      integer(c_long), value :: offset
      integer(c_int), value :: whence
    end function posix_lseek

    !> Reads bytes and returns their number; 0 at the end, -1 when refused.
    integer(c_size_t) function posix_read(descriptor, bytes, number) bind(c, name='read')
      import :: c_char, c_int, c_size_t
      implicit none
      integer(c_int), value :: descriptor
      character(kind=c_char), intent(out) :: bytes(*)
      integer(c_size_t), value :: number
    end function posix_read

    !> Writes bytes and returns their number; -1 when refused.
    integer(c_size_t) function posix_write(descriptor, bytes, number) bind(c, name='write')
      import :: c_char, c_int, c_size_t
      implicit none
      integer(c_int), value :: descriptor
      character(kind=c_char), intent(in) :: bytes(*)
      integer(c_size_t), value :: number
    end function posix_write

    !> Closes a descriptor; -1 when written bytes are lost.
    integer(c_int) function posix_close(descriptor) bind(c, name='close')
      import :: c_int
      implicit none
      integer(c_int), value :: descriptor
    end function posix_close

    !> Renames a file, and replaces a file of that name.
    integer(c_int) function posix_rename(from, to) bind(c, name='rename')
      import :: c_char, c_int
      implicit none
      character(kind=c_char), intent(in) :: from(*), to(*)
    end function posix_rename

    !> Removes the name of a file.
    integer(c_int) function posix_unlink(path) bind(c, name='unlink')
      import :: c_char, c_int
      implicit none
      character(kind=c_char), intent(in) :: path(*)
    end function posix_unlink

    !> 1 when a descriptor is a terminal.
    integer(c_int) function posix_isatty(descriptor) bind(c, name='isatty')
      import :: c_int
      implicit none
      integer(c_int), value :: descriptor
    end function posix_isatty

    !> Suspends this thread for a number of microseconds.
    integer(c_int) function posix_usleep(microseconds) bind(c, name='usleep')
      import :: c_int
      implicit none
      integer(c_int), value :: microseconds
    end function posix_usleep

    !> Sets the handler of a signal, and returns the former handler.
    type(c_funptr) function posix_signal(number, handler) bind(c, name='signal')
      import :: c_funptr, c_int
      implicit none
      integer(c_int), value :: number
      type(c_funptr), value :: handler
    end function posix_signal

    !> Ends the process in order, with an exit status.
    subroutine posix_exit(status) bind(c, name='exit')
      import :: c_int
      implicit none
      integer(c_int), value :: status
    end subroutine posix_exit

    !> Replaces the program of this process, with a list of arguments that ends with a null pointer;
    !> returns only when refused.
    integer(c_int) function posix_execv(path, arguments) bind(c, name='execv')
      import :: c_char, c_int, c_ptr
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      type(c_ptr), intent(in) :: arguments(*)
    end function posix_execv

    !> Sets a variable of the environment; a variable that is there stays with `replaces` 0.
    integer(c_int) function posix_setenv(name, value, replaces) bind(c, name='setenv')
      import :: c_char, c_int
      implicit none
      character(kind=c_char), intent(in) :: name(*), value(*)
      integer(c_int), value :: replaces
    end function posix_setenv

    !> Reads a limit of the process and the largest that it may set; unsigned, -1: none.
    integer(c_int) function posix_getrlimit(which, limits) bind(c, name='getrlimit')
      import :: c_int, c_long
      implicit none
      integer(c_int), value :: which
      integer(c_long), intent(out) :: limits(2)
    end function posix_getrlimit

    !> Writes a number in a format of C for one double, with a null character; returns its length.
    !> Rounding is exact, as in Fortran's formats, in a fifth of their time.
    integer(c_int) function c_strfromd(text, room, form, value) bind(c, name='strfromd')
      import :: c_char, c_double, c_int, c_size_t
      implicit none
      character(kind=c_char), intent(out) :: text(*)
      integer(c_size_t), value :: room
      character(kind=c_char), intent(in) :: form(*)
      real(c_double), value :: value
    end function c_strfromd

    !> Number of this process.
    integer(c_int) function posix_getpid() bind(c, name='getpid')
      import :: c_int
      implicit none
    end function posix_getpid

    integer(c_size_t) function posix_readlink(path, target_path, room) bind(c, name='readlink')
      import :: c_char, c_size_t
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      character(kind=c_char), intent(out) :: target_path(*)
      integer(c_size_t), value :: room
    end function posix_readlink

    type(c_ptr) function posix_realpath(path, resolved) bind(c, name='realpath')
      import :: c_char, c_ptr
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      character(kind=c_char), intent(out) :: resolved(*)
    end function posix_realpath

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

  !> Reads owner and permission bits of a file; the mode is -1 when there is no file.
  subroutine file_owner(path, mode, owner, group)
    character(len=*), intent(in) :: path              !! path of the file
    integer(c_int), intent(out) :: mode               !! permission bits; -1: there is no file
    integer(c_int), intent(out) :: owner, group       !! numbers of the user and of the group
    integer(c_int), parameter :: mode_and_owners = 26_c_int
    integer(c_int32_t) :: found(64)

    mode = posix_statx(this_folder, path // c_null_char, 0_c_int, mode_and_owners, found)
    if (mode == 0) mode = iand(found(8), int(o'7777', c_int32_t))
    owner = found(6)
    group = found(7)
  end subroutine file_owner

  !> Whether a path leads to a file that is no device, pipe or folder.
  logical function is_regular_file(path)
    character(len=*), intent(in) :: path  !! path of the file
    integer(c_int), parameter :: kind_of_file = 1_c_int
    integer(c_int32_t) :: found(64)

    is_regular_file = .false.
    if (posix_statx(this_folder, path // c_null_char, 0_c_int, kind_of_file, found) == 0) &
      is_regular_file = iand(found(8), int(o'170000', c_int32_t)) == int(o'100000', c_int32_t)
  end function is_regular_file

  !> Number of the last error of the C library.
  function system_error() result(number)
    integer(c_int) :: number  !! errno
    integer(c_int), pointer :: errno

    call c_f_pointer(errno_location(), errno)
    number = errno
  end function system_error

  !> Text of the last error of the C library.
  function system_reason() result(reason)
    character(len=:), allocatable :: reason  !! for instance `No space left on device`

    reason = text_of(posix_strerror(system_error()))
  end function system_reason

  !> Canonical name of a file, the same for every path to it; symbolic links are followed. A file
  !> that does not exist yet has the canonical name of its folder.
  function canonical_path(path) result(name)
    character(len=*), intent(in) :: path   !! path of a file
    character(len=:), allocatable :: name  !! absolute where possible
    character(kind=c_char, len=longest_path) :: link
    character(len=:), allocatable :: folder
    integer :: length, slash, step

    name = path
    ! A link whose file does not exist yet is followed, up to a limit of 40 links.
    do step = 1, 40
      folder = real_path(name)
      if (folder /= '') then
        name = folder
        return
      end if
      length = int(posix_readlink(name // c_null_char, link, len(link, c_size_t)))
      if (length < 1) exit
      if (link(1:1) == '/') then
        name = link(:length)
      else
        name = name(:index(name, '/', back=.true.)) // link(:length)
      end if
    end do
    slash = index(name, '/', back=.true.)
    if (slash == len(name)) return
    folder = real_path('./' // name(:slash))
    if (index(name, '/') == 1) folder = real_path(name(:slash))
    if (folder /= '') name = folder // '/' // name(slash + 1:)
  end function canonical_path

  !> Resolved path of an existing file; empty when there is none.
  function real_path(path) result(name)
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: name
    character(kind=c_char, len=longest_path) :: resolved

    name = ''
    if (c_associated(posix_realpath(path // c_null_char, resolved))) &
      name = resolved(:index(resolved, c_null_char) - 1)
  end function real_path

  !> A text of C; empty for a null pointer.
  function text_of(address) result(text)
    type(c_ptr), intent(in) :: address     !! address of its first character
    character(len=:), allocatable :: text  !! text without the null character
    character(kind=c_char), pointer :: letters(:)
    integer :: i, length

    text = ''
    if (.not. c_associated(address)) return
    call c_f_pointer(address, letters, [huge(length)])
    length = 0
    do while (letters(length + 1) /= c_null_char)
      length = length + 1
    end do
    deallocate (text)
    allocate (character(len=length) :: text)
    do i = 1, length
      text(i:i) = letters(i)
    end do
  end function text_of

end module asperity_system_calls
