!> Two numbers in the memory of another program: pieces of work that are done, and all of them. Any
!> thread may read them at any time.
module asperity_work_count
  use, intrinsic :: iso_c_binding, only: c_int
  implicit none
  private

  public :: work_count

  !> Where the numbers are. As it stands nothing is counted.
  type :: work_count
    integer(c_int), pointer :: numbers(:) => null()  !! pieces done; all of them, 0: not known yet
    integer :: of_position = 1                       !! pieces of a position of a sweep
  contains
    procedure :: begin  !! work begins
    procedure :: add    !! more pieces are done
    procedure :: step   !! a state of a position is done
  end type work_count

contains

  !> Work begins: a number of pieces, of which some were done before.
  subroutine begin(self, number, before)
    class(work_count), intent(in) :: self  !! of the work
    integer, intent(in) :: number          !! all pieces; at most the largest integer counts
    integer, intent(in) :: before          !! of them, done before

    if (.not. associated(self%numbers)) return
    !$omp atomic write
    self%numbers(1) = int(before, c_int)
    !$omp atomic write
    self%numbers(2) = int(number, c_int)
  end subroutine begin

  !> More pieces are done.
  subroutine add(self, number)
    class(work_count), intent(in) :: self  !! begun
    integer, intent(in) :: number          !! of them; below 0: they are done again

    if (.not. associated(self%numbers)) return
    !$omp atomic update
    self%numbers(1) = self%numbers(1) + int(number, c_int)
  end subroutine add

  !> A state of a position is done. Its last one is counted with the position, which may have other
  !> states than were known when the work began.
  subroutine step(self, counted)
    class(work_count), intent(in) :: self  !! begun
    integer, intent(inout) :: counted      !! states of the position that are counted

    if (counted >= self%of_position - 1) return
    counted = counted + 1
    call self%add(1)
  end subroutine step

end module asperity_work_count
