!> The running process: its number and its end.
module asperity_process
  use, intrinsic :: iso_c_binding, only: c_int
  implicit none
  private

  public :: end_process, process_number

  interface
    subroutine posix_exit(status) bind(c, name='exit')
      import :: c_int
      implicit none
      integer(c_int), value :: status
    end subroutine posix_exit

    integer(c_int) function posix_getpid() bind(c, name='getpid')
      import :: c_int
      implicit none
    end function posix_getpid
  end interface

contains

  !> Ends the process with an exit status and, unlike STOP, without a word.
  subroutine end_process(status)
    integer, intent(in) :: status  !! 0 done, 1 could not be computed, 2 bad input

    call posix_exit(int(status, c_int))
  end subroutine end_process

  !> The number by which the system knows this process.
  integer function process_number()
    process_number = int(posix_getpid())
  end function process_number

end module asperity_process
