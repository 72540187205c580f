!> Begins the program anew with what its runtime libraries read of the environment before it begins.
module asperity_begin_anew
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_loc, c_null_char, c_null_ptr, c_ptr
  use asperity_files, only: read_whole_file
  use asperity_images, only: image_count
  use asperity_system_calls, only: canonical_path, posix_execv, posix_setenv
  !$ use omp_lib, only: omp_get_max_threads
  implicit none
  private

  public :: begin_anew_with_settings

  ! What the environment may say of it; the second is libgomp's own.
  character(len=*), parameter :: policies(2) = [character(len=15) :: 'OMP_WAIT_POLICY', &
    'GOMP_SPINCOUNT']
  ! Rounds that a thread of libgomp waits awake: 0.03 ms with pauses of 13 ns. A region of threads
  ! that sleep at once takes 0.07 ms (both measured): no wait costs much more than twice the least.
  character(len=*), parameter :: rounds_awake = '2000'
  ! Memory given back is kept for what comes next, large pieces, too: the system zeroes each page
  ! that it hands out. A million coupled contacts take 2 s of the system so, else 11 (the GNU C
  ! library's manual, Memory Allocation Tunables).
  character(len=*), parameter :: tunables = 'GLIBC_TUNABLES', &
    keep_memory = 'glibc.malloc.mmap_threshold=4294967296:glibc.malloc.trim_threshold=4294967296'

contains

  !> Begins anew, once, with the same words, where threads are to be used and the environment does
  !> not say how they wait. To be called before any input is read. Threads then soon sleep while
  !> they wait: by default they spin, and where other programs need the cores, that keeps those from
  !> working that are waited for. And memory that is given back is kept, unless the environment
  !> says what becomes of it. docs/large-surfaces.md has the figures of both.
  subroutine begin_anew_with_settings()
    character(kind=c_char), allocatable, target :: letters(:)
    character(len=:), allocatable :: words, failure
    type(c_ptr), allocatable :: address(:)
    integer(c_int) :: status
    integer :: i, length, threads

    threads = 1
    !$ threads = omp_get_max_threads()
    ! What began several images would lose one that begins anew.
    if (threads == 1 .or. image_count() > 1) return
    do i = 1, size(policies)
      call get_environment_variable(trim(policies(i)), status=length)
      if (length /= 1) return
    end do

    ! Each word ends with a null character; here each begins after one, too.
    call read_whole_file('/proc/self/cmdline', words, failure)
    if (allocated(failure)) return
    letters = transfer(c_null_char // words, letters)
    allocate (address(0))
    do i = 1, size(letters) - 1
      if (letters(i) == c_null_char) address = [address, c_loc(letters(i + 1))]
    end do
    address = [address, c_null_ptr]
    if (posix_setenv(trim(policies(1)) // c_null_char, 'passive' // c_null_char, 1_c_int) /= 0) &
      return
    status = posix_setenv(trim(policies(2)) // c_null_char, rounds_awake // c_null_char, 1_c_int)
    call get_environment_variable(tunables, status=length)
    if (length == 1) &
      status = posix_setenv(tunables // c_null_char, keep_memory // c_null_char, 1_c_int)
    ! It comes back only where the system does not begin the program; then threads spin.
    status = posix_execv(canonical_path('/proc/self/exe') // c_null_char, address)
  end subroutine begin_anew_with_settings

end module asperity_begin_anew
