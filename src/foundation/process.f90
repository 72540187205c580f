!> Memory of the running process.
module asperity_process
  use, intrinsic :: iso_c_binding, only: c_int, c_long
  use, intrinsic :: iso_fortran_env, only: int8
  use asperity_files, only: read_whole_file
  use asperity_kinds, only: int64
  use asperity_problems, only: decimal_text, not_enough_memory
  use asperity_system_calls, only: posix_getrlimit
  implicit none
  private

  public :: check_memory, check_stack, is_given

  !> Addresses of a thread beside the data [bytes]: its usual stack, and the part of the heap that
  !> allocations of a thread begin with (glibc, HEAP_MAX_SIZE).
  integer(int64), parameter, public :: bytes_of_thread = 8388608_int64 + 67108864_int64

  ! Least request for memory [bytes] that is compared with the free memory of the machine: reading
  ! that takes 0.1 ms, and smaller requests do not exhaust a machine.
  integer(int64), parameter :: large_request = 67108864_int64
  ! Memory to be left beside a request [bytes], for small arrays without a request (chosen), and the
  ! least request that is tried: smaller ones are in that room.
  integer(int64), parameter :: spare_room = 4194304_int64, small_request = spare_room / 128
  ! Size of the addresses of a process [bytes] (48 bits, a half for the system).
  integer(int64), parameter :: all_addresses = 2_int64**47

  ! Least stack [kB]: local variables along the calls take up to 200, FFTW takes up to 64 for each
  ! of its steps (derived: -fstack-usage; test: small stacks in test_outside_faults.py).
  integer(c_long), parameter :: least_stack = 1024_c_long

contains

  !> Sets the failure where the stack is too small: the system ends a process beyond it by a signal.
  subroutine check_stack(failure)
    character(len=:), allocatable, intent(inout) :: failure  !! set where it is too small
    integer(c_int), parameter :: of_stack = 3_c_int  ! RLIMIT_STACK of Linux
    integer(c_long) :: limits(2)

    if (posix_getrlimit(of_stack, limits) /= 0_c_int) return
    if (limits(1) >= 0_c_long .and. limits(1) < 1024_c_long * least_stack) &
      failure = 'stack: found a limit of ' // decimal_text(limits(1) / 1024_c_long) // &
                ' kB, expected ' // decimal_text(least_stack) // ' or more (ulimit -s)'
  end subroutine check_stack

  !> Sets the failure where memory is short: an allocation has failed or has left no room for small
  !> arrays, or the memory that the arrays of a solve, their copies and FFTW take is not there. FFTW
  !> and copies end the process where they get none. Linux gives addresses (`ulimit -v`) for more
  !> than the free memory of the machine or of a container, and ends the process when it is written.
  subroutine check_memory(purpose, failure, status, bytes)
    character(len=*), intent(in) :: purpose                  !! of the memory, for the message
    character(len=:), allocatable, intent(inout) :: failure  !! set where memory is short
    integer, intent(in), optional :: status                  !! of an allocation, 0: done
    integer(int64), intent(in), optional :: bytes            !! of arrays that follow, 0 or more
    character(len=*), parameter :: group = '/sys/fs/cgroup/memory.'
    integer(int64) :: limit, needed
    logical :: is_short

    needed = 0_int64
    if (present(bytes)) needed = bytes
    is_short = .false.
    if (present(status)) is_short = status /= 0
    if (.not. (is_short .or. needed < small_request .and. present(bytes))) &
      is_short = .not. is_given(needed)
    if (needed >= large_request .and. .not. is_short) then
      is_short = needed / 1024_int64 > number_in_file('/proc/meminfo', 'MemAvailable:')
      limit = number_in_file(group // 'max', '')
      if (limit < huge(limit)) &
        is_short = is_short .or. needed > limit - number_in_file(group // 'stat', 'anon ')
    end if
    if (is_short) failure = not_enough_memory // ' for ' // purpose
  end subroutine check_memory

  !> Whether the system gives addresses beside those in use. They take no memory until they are
  !> written to.
  logical function is_given(bytes)
    integer(int64), intent(in) :: bytes  !! size, 0 or more
    integer(int8), allocatable, volatile :: room(:)
    integer :: status

    status = 1
    if (bytes < all_addresses) allocate (room(bytes + spare_room), stat=status)
    is_given = status == 0
  end function is_given

  ! The integer that follows a name in a file of the system; the largest integer when there is
  ! none.
  integer(int64) function number_in_file(path, name) result(number)
    character(len=*), intent(in) :: path, name
    character(len=:), allocatable :: text, failure
    integer :: at, status

    call read_whole_file(path, text, failure)
    at = index(new_line('a') // text, new_line('a') // name)
    status = 1
    if (at > 0) read (text(at + len(name):), *, iostat=status) number
    if (status /= 0) number = huge(number)
  end function number_in_file

end module asperity_process
