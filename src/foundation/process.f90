!> The running process: its memory and its end.
module asperity_process
  use, intrinsic :: iso_c_binding, only: c_int
  use asperity_kinds, only: int64
  use asperity_system_calls, only: posix_exit
  implicit none
  private

  public :: end_process, has_memory

contains

  !> Ends the process with an exit status and, unlike STOP, without a word.
  subroutine end_process(status)
    integer, intent(in) :: status  !! 0 done, 1 could not be computed, 2 bad input

    call posix_exit(int(status, c_int))
  end subroutine end_process

  !> Whether the system would give so much memory now: asked before a million positions (0.4 GB a
  !> state) or 20 million asperities (2.6 GB) are worked on, not after minutes of it.
  logical function has_memory(bytes)
    integer(int64), intent(in) :: bytes  !! at least 1
    ! Volatile, or a compiler leaves out what seems to have no use.
    integer(int64), allocatable, volatile :: room(:)
    integer :: status

    allocate (room(bytes / 8_int64 + 1_int64), stat=status)
    has_memory = status == 0
  end function has_memory

end module asperity_process
