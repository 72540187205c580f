!> Progress in two numbers in the memory of a calling program: pieces of work done, and all pieces.
!> Any thread may read them at any time.
module asperity_work_count
  use, intrinsic :: iso_c_binding, only: c_int
  implicit none
  private

  public :: work_count

  !> Reference to the numbers. By default nothing is counted.
  type :: work_count
    integer(c_int), pointer :: numbers(:) => null()  !! pieces done; all pieces, 0: unknown
    integer :: of_position = 1                       !! number of pieces of a position of a sweep
  contains
    procedure :: begin_count  !! sets the number of pieces
    procedure :: add_work     !! counts pieces that are done
    procedure :: count_state  !! counts a state of a position
  end type work_count

contains

  !> Sets the number of pieces, and of those that are already done.
  subroutine begin_count(self, number, before)
    class(work_count), intent(in) :: self  !! numbers of the work
    integer, intent(in) :: number          !! number of all pieces
    integer, intent(in) :: before          !! number of pieces already done

    if (.not. associated(self%numbers)) return
    !$omp atomic write
    self%numbers(1) = int(before, c_int)
    !$omp atomic write
    self%numbers(2) = int(number, c_int)
  end subroutine begin_count

  !> Counts pieces that are done.
  subroutine add_work(self, number)
    class(work_count), intent(in) :: self  !! numbers of the work
    integer, intent(in) :: number          !! number of pieces; < 0: to be repeated

    if (.not. associated(self%numbers)) return
    !$omp atomic update
    self%numbers(1) = self%numbers(1) + int(number, c_int)
  end subroutine add_work

  !> Counts a state of a position. The last one is counted with the position, whose number of states
  !> may differ from the one assumed.
  subroutine count_state(self, counted)
    class(work_count), intent(in) :: self  !! numbers of the work
    integer, intent(inout) :: counted      !! number of counted states of the position

    if (counted >= self%of_position - 1) return
    counted = counted + 1
    call self%add_work(1)
  end subroutine count_state

end module asperity_work_count
