!> Abstract solver of the positions of a sweep, with one interface for the arithmetics and the
!> effects.
module asperity_position_solver
  use asperity_contact_records, only: position_result
  use asperity_interruption, only: interruption
  use asperity_kinds, only: int64, real64
  use asperity_solution_start, only: solution_reuse
  use asperity_work_count, only: work_count
  implicit none
  private

  public :: position_solver

  !> A scene made ready. Positions know nothing of each other, so threads may solve them at once.
  type, abstract :: position_solver
    integer :: positions = 0              !! of the scene
    integer :: states = 1                 !! of a position, as far as that is known
    integer(int64) :: work = 0_int64      !! asperities that a position looks at, at most
    !> How near a load asked for is met; numbers of few digits are no nearer.
    real(real64) :: load_precision = 1.0e-6_real64
    !> Total normal force and vertical load are both reported when they differ by more than this
    !> fraction; huge: never.
    real(real64) :: loads_differ = huge(1.0_real64)
    real(real64) :: nominal_area = 0.0_real64  !! in the scene's unit; 0: not given
    type(interruption) :: interrupt       !! of the run: long positions look at it
    type(work_count) :: count             !! of the run: states of long positions are counted
    type(solution_reuse) :: reuse         !! of the run: solutions of an earlier one
  contains
    procedure(solve_one), deferred :: solve  !! one position
  end type position_solver

  abstract interface
    !> Solves one position. `failure` is allocated when the end asked for cannot be reached.
    subroutine solve_one(self, m, keep_rows, result, failure)
      import :: position_result, position_solver
      implicit none
      class(position_solver), intent(in) :: self             !! the scene
      integer, intent(in) :: m                               !! position, from 1
      logical, intent(in) :: keep_rows                       !! keep the contacts of every state
      type(position_result), intent(out) :: result           !! states, ending with the last
      character(len=:), allocatable, intent(out) :: failure  !! why not
    end subroutine solve_one
  end interface

end module asperity_position_solver
