!> Memory of the running process.
module asperity_process
  use, intrinsic :: iso_c_binding, only: c_associated, c_ptr, c_size_t
  use asperity_files, only: read_whole_file
  use asperity_kinds, only: int64
  use asperity_system_calls, only: c_free, c_malloc
  implicit none
  private

  public :: has_memory, is_given

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

contains

  !> Whether memory is available: the system gives it (`ulimit -v`), and it is free in the machine
  !> and, in a container, in its limit. To be called before a large array is allocated.
  logical function has_memory(bytes)
    integer(int64), intent(in) :: bytes  !! size of the memory, 0 or more
    character(len=*), parameter :: group = '/sys/fs/cgroup/memory.'
    integer(int64) :: limit

    has_memory = bytes < small_request
    if (.not. has_memory) has_memory = is_given(bytes)
    if (bytes < large_request .or. .not. has_memory) return
    has_memory = bytes / 1024_int64 <= number_in_file('/proc/meminfo', 'MemAvailable:')
    limit = number_in_file(group // 'max', '')
    if (limit < huge(limit)) &
      has_memory = has_memory .and. bytes <= limit - number_in_file(group // 'stat', 'anon ')
  end function has_memory

  !> Whether the system gives addresses beside those in use. They take no memory until they are
  !> written to.
  logical function is_given(bytes)
    integer(int64), intent(in) :: bytes  !! size, 0 or more
    type(c_ptr) :: room

    is_given = bytes < all_addresses
    if (.not. is_given) return
    room = c_malloc(int(bytes + spare_room, c_size_t))
    is_given = c_associated(room)
    call c_free(room)
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
