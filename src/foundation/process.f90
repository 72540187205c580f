!> The running process: its memory and its stacks.
module asperity_process
  use, intrinsic :: iso_c_binding, only: c_int, c_long
  use asperity_files, only: read_whole_file
  use asperity_kinds, only: int64
  use asperity_problems, only: decimal_text
  use asperity_system_calls, only: posix_getrlimit
  !$ use omp_lib, only: omp_get_max_threads, omp_set_num_threads
  implicit none
  private

  public :: has_memory, number_in_file, prepare_process, threads_with_memory

  ! RLIMIT_STACK and RLIMIT_AS of Linux.
  integer(c_int), parameter :: stack_limit = 3_c_int, address_limit = 9_c_int
  ! Least stack [bytes]. All tests passed with a quarter of it; a build with checks needs more.
  integer(int64), parameter :: least_stack = 512_int64 * 1024_int64
  ! Least request for memory [bytes] that is compared with the free memory of the machine: reading
  ! that takes 0.1 ms, and smaller requests do not exhaust a machine.
  integer(int64), parameter :: large_request = 67108864_int64
  ! Memory to be left beside a request [bytes], for small arrays without a request (chosen), and the
  ! least request that is compared with the limit of the shell: smaller ones are in that room.
  integer(int64), parameter :: spare_room = 4194304_int64, small_request = spare_room / 128
  ! Stack of a thread without a limit of the user [bytes].
  integer(int64), parameter :: usual_stack = 8_int64 * 1024_int64 * 1024_int64

contains

  !> Prepares memory and threads, once at the start. `failure` is allocated when a stack is too
  !> small:
  !> the run would end later without a message. Where the shell limits memory, all threads for which
  !> there is memory are started, as it may be short later.
  subroutine prepare_process(failure)
    character(len=:), allocatable, intent(out) :: failure  !! reason, when a stack is too small
    integer(int64) :: found
    integer :: threads, begun

    found = limit_of(stack_limit)
    if (found < least_stack) then
      failure = 'the stack is too small: found ' // kilobyte_text(found) // &
                ', expected at least ' // kilobyte_text(least_stack) // ': ulimit -s 8192'
      return
    end if
    found = stack_of_a_thread()
    if (found < least_stack) then
      failure = 'the stack of a thread is too small: found ' // kilobyte_text(found) // &
                ', expected at least ' // kilobyte_text(least_stack) // ': OMP_STACKSIZE=8M'
      return
    end if
    if (limit_of(address_limit) == huge(found)) return
    threads = 1
    !$ threads = threads_with_memory(omp_get_max_threads())
    begun = 0
    !$omp parallel num_threads(threads) reduction(+:begun)
    begun = begun + 1
    !$omp end parallel
    !$ call omp_set_num_threads(begun)
  end subroutine prepare_process

  !> Number of threads for whose stacks there is memory, at least 1.
  integer function threads_with_memory(most) result(threads)
    integer, intent(in) :: most  !! largest number of threads

    threads = max(1, most)
    do while (threads > 1)
      if (has_memory(stack_of_a_thread() * int(threads, int64))) exit
      threads = threads / 2
    end do
  end function threads_with_memory

  ! A limit of the shell, in bytes; the largest number for none.
  integer(int64) function limit_of(resource) result(bytes)
    integer(c_int), intent(in) :: resource
    integer(c_long) :: limits(2)

    bytes = huge(bytes)
    if (posix_getrlimit(resource, limits) == 0_c_int .and. limits(1) >= 0_c_long) &
      bytes = int(limits(1), int64)
  end function limit_of

  ! Stack of a thread of OpenMP [bytes]: that of the environment, or that of the process.
  integer(int64) function stack_of_a_thread() result(bytes)
    character(len=*), parameter :: names(2) = [character(len=14) :: 'OMP_STACKSIZE', &
      'GOMP_STACKSIZE']
    character(len=*), parameter :: units = 'bBkKmMgG'
    character(len=32) :: word
    integer :: i, last, status, unit

    do i = 1, size(names)
      call get_environment_variable(trim(names(i)), word, status=status)
      if (status /= 0) cycle
      word = adjustl(word)
      last = verify(word, '0123456789') - 1
      if (last < 1 .or. last > 12) cycle
      read (word(:last), '(i12)') bytes
      word = adjustl(word(last + 1:))
      unit = index(units, word(:1))
      if (word == '') unit = index(units, 'k')
      if (unit == 0 .or. len_trim(word) > 1) cycle
      bytes = bytes * 1024_int64**((unit - 1) / 2)
      return
    end do
    bytes = limit_of(stack_limit)
    if (bytes == huge(bytes)) bytes = usual_stack
  end function stack_of_a_thread

  pure function kilobyte_text(bytes) result(text)
    integer(int64), intent(in) :: bytes
    character(len=:), allocatable :: text

    text = decimal_text(int(bytes / 1024_int64)) // ' kB'
  end function kilobyte_text

  !> Whether memory is available within the limit of the shell (`ulimit -v`), the free memory of the
  !> machine and the limit of its control group. To be called before a large array is allocated.
  logical function has_memory(bytes)
    integer(int64), intent(in) :: bytes  !! size of the memory, 0 or more
    integer(int64) :: limit

    has_memory = .true.
    if (bytes < small_request) return
    if (bytes >= large_request) has_memory = bytes <= available_memory()
    limit = limit_of(address_limit)
    if (.not. has_memory .or. limit == huge(limit)) return
    ! Without memory the file cannot be read: the number is the largest one.
    has_memory = number_in_file('/proc/self/status', 'VmSize:') <= &
                 (limit - spare_room - bytes) / 1024_int64
  end function has_memory

  ! Available memory of the machine and the control groups of this process [bytes]. Cached files
  ! count as free (Linux: proc(5), cgroups(7) of versions 2 and 1).
  integer(int64) function available_memory() result(bytes)
    character(len=*), parameter :: marks(2) = [character(len=8) :: '0::', ':memory:'], &
      folders(2) = [character(len=21) :: '/sys/fs/cgroup', '/sys/fs/cgroup/memory'], &
      limits(2) = [character(len=22) :: '/memory.max', '/memory.limit_in_bytes'], &
      used(2) = [character(len=4) :: 'anon', 'rss']
    character(len=:), allocatable :: text, failure, group
    integer(int64) :: limit
    integer :: at, i

    bytes = number_in_file('/proc/meminfo', 'MemAvailable:')
    limit = number_in_file('/proc/meminfo', 'SwapFree:')
    if (max(bytes, limit) < huge(bytes)) bytes = 1024_int64 * (bytes + limit)
    call read_whole_file('/proc/self/cgroup', text, failure)
    if (allocated(failure)) return
    do i = 1, size(marks)
      at = index(text, trim(marks(i)))
      if (at == 0) cycle
      group = text(at + len_trim(marks(i)):)
      group = group(:index(group // new_line('a'), new_line('a')) - 1)
      ! The limits of the groups that contain a group also hold.
      do
        limit = number_in_file(trim(folders(i)) // group // trim(limits(i)), '')
        if (limit < huge(limit)) &
          bytes = min(bytes, limit - number_in_file(trim(folders(i)) // group // '/memory.stat', &
                                                    trim(used(i)) // ' '))
        if (group == '') exit
        group = group(:index(group, '/', back=.true.) - 1)
      end do
    end do
  end function available_memory

  !> The integer that follows a name in a file of the system; the largest integer when there is
  !> none.
  integer(int64) function number_in_file(path, name) result(number)
    character(len=*), intent(in) :: path  !! path, for instance `/proc/meminfo`
    character(len=*), intent(in) :: name  !! name with the separator, or empty
    character(len=:), allocatable :: text, failure
    integer :: at, status

    number = huge(number)
    call read_whole_file(path, text, failure)
    if (allocated(failure)) return
    at = index(new_line('a') // text, new_line('a') // name)
    if (at == 0) return
    at = at + len(name)
    at = at - 1 + max(1, verify(text(at:), ' ' // achar(9)))
    read (text(at:at - 2 + verify(text(at:) // ' ', '0123456789')), *, iostat=status) number
    if (status /= 0) number = huge(number)
  end function number_in_file

end module asperity_process
