!> Threads that wait sleep: otherwise each of them uses its processor while it waits, and on a busy
!> machine the run takes ten times the processor time.
module asperity_waiting_threads
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_loc, c_null_char, c_null_ptr, c_ptr
  use asperity_arguments, only: word_at
  use asperity_images, only: is_image_build
  use asperity_system_calls, only: posix_execv, posix_setenv
  !$ use omp_lib, only: omp_get_max_threads
  implicit none
  private

  public :: let_threads_sleep

  ! Settings of the OpenMP run-time library, which reads them when it is loaded. Turns of a loop
  ! before a thread sleeps: some microseconds, the time between two loops of a solve (measured:
  ! reference_output/bench/threads.2026-11-29.txt).
  character(len=*), parameter :: policy = 'OMP_WAIT_POLICY', turns = 'GOMP_SPINCOUNT'

contains

  !> Starts the program again with these settings where it has several threads and the environment
  !> sets neither. Returns where there is nothing to do, or where the system refuses.
  subroutine let_threads_sleep()
    character(kind=c_char), allocatable, target :: bytes(:)
    type(c_ptr), allocatable :: arguments(:)
    character(len=:), allocatable :: word
    integer(c_int) :: status
    integer :: i, last, set

    !$ if (omp_get_max_threads() == 1) return
    if (is_image_build()) return
    do i = 1, 2
      call get_environment_variable(merge(policy, turns // ' ', i == 1), status=set)
      if (set == 0) return
    end do
    last = 0
    do i = 0, command_argument_count()
      last = last + len(word_at(i)) + 1
    end do
    allocate (bytes(last))
    allocate (arguments(0:command_argument_count() + 1))
    last = 0
    do i = 0, command_argument_count()
      word = word_at(i) // c_null_char
      bytes(last + 1:last + len(word)) = transfer(word, bytes)
      arguments(i) = c_loc(bytes(last + 1))
      last = last + len(word)
    end do
    arguments(ubound(arguments, 1)) = c_null_ptr
    status = posix_setenv(policy // c_null_char, 'passive' // c_null_char, 0_c_int)
    status = posix_setenv(turns // c_null_char, '2000' // c_null_char, 0_c_int)
    status = posix_execv('/proc/self/exe' // c_null_char, arguments)
  end subroutine let_threads_sleep

end module asperity_waiting_threads
