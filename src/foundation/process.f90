!> The running process: its memory, its stacks and its end.
module asperity_process
  use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t, c_long, c_null_ptr, c_ptr, c_size_t
  use asperity_kinds, only: int64
  use asperity_problems, only: decimal_text
  use asperity_system_calls, only: posix_exit, posix_getrlimit, posix_mmap, posix_munmap
  !$ use omp_lib, only: omp_get_max_threads, omp_set_num_threads
  implicit none
  private

  public :: end_process, has_memory, prepare_process, threads_with_memory

  ! RLIMIT_STACK and RLIMIT_AS of Linux.
  integer(c_int), parameter :: stack_limit = 3_c_int, address_limit = 9_c_int
  ! PROT_READ and PROT_WRITE, MAP_PRIVATE and MAP_ANONYMOUS of Linux.
  integer(c_int), parameter :: read_and_write = 3_c_int, private_memory = 34_c_int
  ! Bytes of stack. All tests ran on a quarter of it; a build with checks needs more than another.
  integer(int64), parameter :: least_stack = 512_int64 * 1024_int64
  ! What the system gives a thread when its user has set no limit.
  integer(int64), parameter :: usual_stack = 8_int64 * 1024_int64 * 1024_int64

contains

  !> To be called once, at the start. `failure` is allocated when a stack is too small: its end
  !> would be met in the middle of the work, and without a word. Where the shell limits memory,
  !> threads begin now, as many as there is room for: later on none might be left.
  subroutine prepare_process(failure)
    character(len=:), allocatable, intent(out) :: failure  !! what is too small
    integer(int64) :: found
    integer :: threads, begun

    found = limit_of(stack_limit)
    if (found < least_stack) then
      failure = 'the stack is too small: found ' // kilobytes(found) // ', expected at least ' // &
                kilobytes(least_stack) // ': ulimit -s 8192'
      return
    end if
    found = stack_of_a_thread()
    if (found < least_stack) then
      failure = 'the stack of a thread is too small: found ' // kilobytes(found) // &
                ', expected at least ' // kilobytes(least_stack) // ': OMP_STACKSIZE=8M'
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

  !> As many threads as there is memory for their stacks, at least 1.
  integer function threads_with_memory(wanted) result(threads)
    integer, intent(in) :: wanted  !! at most

    threads = max(1, wanted)
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

  ! Bytes of stack of a thread that OpenMP starts: as the environment says, or as large as the
  ! stack of the process.
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

  pure function kilobytes(bytes) result(text)
    integer(int64), intent(in) :: bytes
    character(len=:), allocatable :: text

    text = decimal_text(int(bytes / 1024_int64)) // ' kB'
  end function kilobytes

  !> Ends the process with an exit status and, unlike STOP, without a word.
  subroutine end_process(status)
    integer, intent(in) :: status  !! 0 done, 1 could not be computed, 2 bad input

    call posix_exit(int(status, c_int))
  end subroutine end_process

  !> Whether the system would give so much memory now: asked before a million positions (0.4 GB a
  !> state) or 20 million asperities (2.6 GB) are worked on, not after minutes of it.
  logical function has_memory(bytes)
    integer(int64), intent(in) :: bytes  !! 0 or more
    type(c_ptr) :: room
    integer(c_int) :: status

    ! Not by `allocate`: where memory ends, that need not come back.
    room = posix_mmap(c_null_ptr, int(bytes + 1_int64, c_size_t), read_and_write, &
                      private_memory, -1_c_int, 0_c_long)
    has_memory = transfer(room, 0_c_intptr_t) /= -1_c_intptr_t
    if (has_memory) status = posix_munmap(room, int(bytes + 1_int64, c_size_t))
  end function has_memory

end module asperity_process
