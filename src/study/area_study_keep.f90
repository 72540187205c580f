!> The file in which a study keeps the surfaces that are done, so that a rerun goes on from there.
!>
!> A line names the study by a checksum of its specification. Then, for every surface in order, a
!> line with its number, how many numbers follow and their checksum, and a line with the numbers,
!> bit by bit as 16 hexadecimal digits. Each is appended in one go; what an end in the middle left
!> of the last one does not meet its checksum and is cut off by the next run.
module asperity_area_study_keep
  use, intrinsic :: iso_c_binding, only: c_int, c_null_char
  use asperity_files, only: read_whole_file, write_bytes
  use asperity_kinds, only: int64, real64
  use asperity_output_files, only: commit_files, stage_file
  use asperity_system_calls, only: posix_close, posix_fsync, posix_open, system_error, &
                                   system_reason
  implicit none
  private

  public :: resume_kept, keep_surfaces

  ! O_RDWR and O_APPEND of Linux.
  integer(c_int), parameter :: read_only = 0_c_int, append = 1025_c_int, no_such_file = 2_c_int
  integer, parameter :: digits = 16

contains

  !> Reads what a former run kept and makes the file ready for more. `failure` is allocated when the
  !> file is of another specification or cannot be read or written.
  subroutine resume_kept(path, spec_text, numbers, done, failure)
    character(len=*), intent(in) :: path                   !! the file; it need not be there
    character(len=*), intent(in) :: spec_text              !! the specification
    real(real64), intent(inout) :: numbers(:, :)           !! a column a surface
    integer, intent(out) :: done                           !! so many surfaces were kept
    character(len=:), allocatable, intent(out) :: failure  !! why not
    character(len=:), allocatable :: text, heading
    integer(c_int) :: descriptor, status
    integer :: used

    done = 0
    heading = 'asperity study, specification ' // checksum(spec_text) // new_line('a')
    text = ''
    descriptor = posix_open(path // c_null_char, read_only)
    if (descriptor >= 0) then
      status = posix_close(descriptor)
      call read_whole_file(path, text, failure)
    else if (system_error() /= no_such_file) then
      failure = path // ': cannot be opened: ' // system_reason()
    end if
    if (allocated(failure)) return
    used = 0
    if (len(text) > 0) then
      used = min(len(heading), len(text))
      if (text(:used) /= heading(:used)) then
        failure = path // ': holds no surfaces of this specification, expected a file that a ' // &
                  'run with the same text kept, or none'
        return
      end if
      if (used < len(heading)) used = 0
    end if
    if (used > 0) call take_surfaces(text, used, numbers, done)
    if (used == len(text) .and. used > 0) return
    ! A new file, or one whose last surface is not whole.
    if (used > 0) heading = text(:used)
    call stage_file(path, heading, failure)
    if (.not. allocated(failure)) call commit_files(failure)
  end subroutine resume_kept

  !> Appends surfaces. `failure` is allocated when they cannot be kept.
  subroutine keep_surfaces(path, first, numbers, failure)
    character(len=*), intent(in) :: path                   !! the file, from resume_kept
    integer, intent(in) :: first                           !! number of the first surface
    real(real64), intent(in) :: numbers(:, :)              !! a column a surface
    character(len=:), allocatable, intent(out) :: failure  !! why not
    character(len=:), allocatable :: text, body
    integer(c_int) :: descriptor, status
    integer :: i

    text = ''
    do i = 1, size(numbers, 2)
      body = hexadecimal(numbers(:, i))
      text = text // heading_of(first + i - 1, size(numbers, 1), body) // body // new_line('a')
    end do
    descriptor = posix_open(path // c_null_char, append)
    if (descriptor < 0) then
      failure = path // ': cannot be written: ' // system_reason()
      return
    end if
    call write_bytes(descriptor, text, failure)
    if (allocated(failure)) failure = path // ': cannot be written: ' // failure
    ! A pipe refuses, and need not.
    status = posix_fsync(descriptor)
    status = posix_close(descriptor)
  end subroutine keep_surfaces

  !> Takes all whole surfaces; `used` is moved behind them.
  subroutine take_surfaces(text, used, numbers, done)
    character(len=*), intent(in) :: text
    integer, intent(inout) :: used
    real(real64), intent(inout) :: numbers(:, :)
    integer, intent(inout) :: done
    character(len=:), allocatable :: heading
    integer :: length, first, line_end

    length = digits * size(numbers, 1)
    do while (done < size(numbers, 2))
      line_end = index(text(used + 1:), new_line('a'))
      first = used + line_end + 1
      if (line_end == 0 .or. len(text) < first + length) exit
      if (text(first + length:first + length) /= new_line('a')) exit
      heading = heading_of(done + 1, size(numbers, 1), text(first:first + length - 1))
      if (text(used + 1:used + line_end) /= heading) exit
      done = done + 1
      call from_hexadecimal(text(first:first + length - 1), numbers(:, done))
      used = first + length
    end do
  end subroutine take_surfaces

  !> The line before the numbers of a surface.
  pure function heading_of(surface, number, body) result(line)
    integer, intent(in) :: surface, number
    character(len=*), intent(in) :: body
    character(len=:), allocatable :: line
    character(len=60) :: text

    write (text, '("surface ", i0, ", numbers ", i0, ", checksum ", a8)') surface, number, &
      checksum(body)
    line = trim(text) // new_line('a')
  end function heading_of

  pure function hexadecimal(numbers) result(text)
    real(real64), intent(in) :: numbers(:)
    character(len=digits * size(numbers)) :: text
    integer :: i

    do i = 1, size(numbers)
      write (text(digits * (i - 1) + 1:digits * i), '(z16.16)') transfer(numbers(i), 0_int64)
    end do
  end function hexadecimal

  pure subroutine from_hexadecimal(text, numbers)
    character(len=*), intent(in) :: text
    real(real64), intent(out) :: numbers(:)
    integer(int64) :: word
    integer :: i

    do i = 1, size(numbers)
      read (text(digits * (i - 1) + 1:digits * i), '(z16)') word
      numbers(i) = transfer(word, 0.0_real64)
    end do
  end subroutine from_hexadecimal

  !> FNV-1a of 32 bits (Fowler, Noll, Vo), as 8 hexadecimal digits.
  pure function checksum(text) result(word)
    character(len=*), intent(in) :: text
    character(len=8) :: word
    integer(int64), parameter :: prime = 16777619_int64, low_32 = int(z'FFFFFFFF', int64)
    integer(int64) :: state
    integer :: i

    state = 2166136261_int64
    do i = 1, len(text)
      state = iand(ieor(state, int(iachar(text(i:i)), int64)) * prime, low_32)
    end do
    write (word, '(z8.8)') state
  end function checksum

end module asperity_area_study_keep
