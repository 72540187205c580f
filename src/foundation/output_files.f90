!> The output files of a command: all of them appear complete, by renaming, or none appears.
!>
!> A file is written under a temporary name in its folder (`stage_file`). After success, standard
!> output included, the files are renamed (`commit_files`); after a failure they are removed.
!> Devices and pipes are written directly. A run that is killed while it writes leaves
!> `.asperity.*.part`.
module asperity_output_files
  use, intrinsic :: iso_c_binding, only: c_funptr, c_int, c_intptr_t, c_null_char
  use asperity_files, only: same_name, standard_error, standard_output, write_bytes
  use asperity_system_calls, only: canonical_path, file_owner, is_regular_file, posix_chmod, &
                                   posix_chown, posix_close, posix_mkstemps, posix_open, &
                                   posix_rename, posix_signal, posix_umask, posix_unlink, &
                                   system_error, system_reason
  implicit none
  private

  public :: stage_file, open_part, close_part, commit_files, discard_files, guard_files, same_file

  integer(c_int), parameter :: mode_rw_r_r = int(o'644', c_int), write_only = 1_c_int
  integer(c_int), parameter :: no_such_file = 2_c_int, no_permission = 13_c_int
  ! PIPE and XFSZ become failures of a write.
  integer(c_int), parameter :: ignored_signals(2) = [13_c_int, 25_c_int]
  integer(c_intptr_t), parameter :: ignore = 1_c_intptr_t  ! SIG_IGN of the C library

  integer, parameter :: most_files = 1100, longest_path = 4400
  ! Names of a staged file; each may end with blanks. The temporary one is empty when it is renamed.
  type :: staged_name
    character(len=:), allocatable :: place, path, part
  end type staged_name
  type(staged_name) :: names(most_files)
  integer :: staged = 0

contains

  !> Makes a closed pipe and a full quota failures of a write, once at the start.
  subroutine guard_files()
    type(c_funptr) :: before
    integer :: i

    do i = 1, size(ignored_signals)
      before = posix_signal(ignored_signals(i), transfer(ignore, before))
    end do
  end subroutine guard_files

  !> Writes a file under its temporary name. `failure` is allocated, with the reason, when that is
  !> not possible; all staged files are removed then.
  subroutine stage_file(path, text, failure)
    character(len=*), intent(in) :: path                   !! path of the file
    character(len=*), intent(in) :: text                   !! bytes of the file
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it cannot be written
    integer(c_int) :: descriptor

    call open_part(path, descriptor, failure)
    if (allocated(failure)) return
    call write_bytes(descriptor, text, failure)
    call close_part(path, descriptor, failure)
  end subroutine stage_file

  !> Opens a file under its temporary name; `close_part` must follow. `failure` is allocated, with
  !> the reason, when that is not possible; all staged files are removed then.
  subroutine open_part(path, descriptor, failure)
    character(len=*), intent(in) :: path                   !! path of the file
    integer(c_int), intent(out) :: descriptor              !! descriptor to write to
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it cannot be written
    character(len=:), allocatable :: place, part
    integer(c_int) :: status, mode, owner, group

    call open_special(path, descriptor, failure)
    if (descriptor < 0 .and. .not. allocated(failure)) then
      place = canonical_path(path)
      part = place(:index(place, '/', back=.true.)) // '.asperity.XXXXXX.part'
      if (staged == most_files .or. len(part) > longest_path) then
        failure = 'too many files, or too long a path'
      else
        call file_owner(place, mode, owner, group)
        part = part // c_null_char
        descriptor = posix_mkstemps(part, len('.part', c_int))
        part = part(:len(part) - 1)
        if (descriptor < 0) then
          status = int(system_error(), c_int)
          failure = system_reason()
          if (mode >= 0 .and. status == no_permission) &
            failure = 'its folder takes no new file, which a whole output needs: ' // failure
        else
          staged = staged + 1
          names(staged) = staged_name(place, path, part)
          ! A file keeps its permissions, and its owner where the system permits it.
          if (mode >= 0) then
            status = posix_chown(part // c_null_char, owner, group)
          else
            mode = posix_umask(0_c_int)
            status = posix_umask(mode)
            mode = iand(mode_rw_r_r, not(mode))
          end if
          status = posix_chmod(part // c_null_char, mode)
        end if
      end if
    end if
    if (.not. allocated(failure)) return
    failure = path // ': cannot be written: ' // failure
    call discard_files()
  end subroutine open_part

  !> Closes a file of `open_part`; a failure of its writing is given the name of the file.
  subroutine close_part(path, descriptor, failure)
    character(len=*), intent(in) :: path                      !! path of the file
    integer(c_int), intent(in) :: descriptor                  !! descriptor of `open_part`
    character(len=:), allocatable, intent(inout) :: failure   !! reason, where a write has failed
    integer(c_int) :: status

    ! A file has the descriptor of a standard stream that was closed before the start.
    if (path /= '/dev/stdout' .and. path /= '/dev/stderr') then
      status = posix_close(descriptor)
      if (status /= 0 .and. .not. allocated(failure)) failure = system_reason()
    end if
    if (.not. allocated(failure)) return
    failure = path // ': cannot be written: ' // failure
    call discard_files()
  end subroutine close_part

  !> Renames all staged files. `failure` is allocated, with the reason, when one cannot be renamed;
  !> the rest is removed then.
  subroutine commit_files(failure)
    character(len=:), allocatable, intent(out) :: failure  !! reason, when one cannot be renamed
    integer(c_int) :: status
    integer :: i

    do i = 1, staged
      status = posix_rename(names(i)%part // c_null_char, names(i)%place // c_null_char)
      if (status == 0) then
        names(i)%part = ''
      else
        failure = names(i)%path // ': cannot be written: ' // system_reason()
        exit
      end if
    end do
    call discard_files()
  end subroutine commit_files

  !> Removes all staged files.
  subroutine discard_files()
    integer(c_int) :: status
    integer :: i

    do i = 1, staged
      if (names(i)%part /= '') status = posix_unlink(names(i)%part // c_null_char)
    end do
    staged = 0
  end subroutine discard_files

  !> Whether two paths lead to one file, or will. Devices and pipes may be shared. Hard links are
  !> not detected: renaming does not change the file of the other name.
  logical function same_file(a, b)
    character(len=*), intent(in) :: a, b  !! paths of files, or empty
    character(len=:), allocatable :: name

    same_file = .false.
    if (a == '' .or. b == '' .or. index(a, '/dev/std') == 1 .or. index(b, '/dev/std') == 1) &
      return
    name = canonical_path(a)
    ! Devices, and what a process has open, may be shared.
    if ((index(name, '/dev/') == 1 .and. index(name, '/dev/shm/') /= 1) .or. &
        index(name, '/proc/') == 1) return
    same_file = same_name(name, canonical_path(b))
  end function same_file

  !> Opens a device or a pipe for writing. `descriptor` is -1 for a regular file. Devices are
  !> written directly, because renaming a staged file would replace the device (/dev/null) by a
  !> file.
  subroutine open_special(path, descriptor, failure)
    character(len=*), intent(in) :: path
    integer(c_int), intent(out) :: descriptor
    character(len=:), allocatable, intent(out) :: failure
    integer(c_int) :: status

    ! The standard streams may be files, which are already open.
    descriptor = standard_output
    if (path == '/dev/stdout') return
    descriptor = standard_error
    if (path == '/dev/stderr') return
    descriptor = posix_open(path // c_null_char, write_only)
    if (descriptor < 0) then
      if (system_error() /= no_such_file) failure = system_reason()
      return
    end if
    if (.not. is_regular_file(path)) return
    status = posix_close(descriptor)
    descriptor = -1
  end subroutine open_special

end module asperity_output_files
