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

  !> A scene ready to be solved. Positions are independent, so threads may solve them in parallel.
  type, abstract :: position_solver
    integer :: positions = 0              !! number of positions of the scene
    integer :: states = 1                 !! estimated states of a position
    integer(int64) :: work = 0_int64      !! largest number of asperities of a position
    !> Relative error of a prescribed load; larger in arithmetics of few digits.
    real(real64) :: load_precision = 1.0e-6_real64
    !> Total normal force and vertical load are both reported when they differ by more than this
    !> fraction; huge: never.
    real(real64) :: loads_differ = huge(1.0_real64)
    real(real64) :: nominal_area = 0.0_real64  !! in the scene's unit; 0: not given
    type(interruption) :: interrupt       !! interruption of the run
    type(work_count) :: progress_count    !! progress of the run, in states
    type(solution_reuse) :: reuse         !! solutions of an earlier run
  contains
    procedure(solve_one), deferred :: solve  !! solves one position
  end type position_solver

  abstract interface
    !> Solves one position. `failure` is allocated when its prescribed end cannot be reached.
    subroutine solve_one(self, m, keep_rows, result, failure)
      import :: position_result, position_solver
      implicit none
      class(position_solver), intent(in) :: self             !! scene ready to be solved
      integer, intent(in) :: m                               !! position, from 1
      logical, intent(in) :: keep_rows                       !! keep the contacts of every state
      type(position_result), intent(out) :: result           !! states, ending with the last
      character(len=:), allocatable, intent(out) :: failure  !! set where the end is not reached
    end subroutine solve_one
  end interface

end module asperity_position_solver
