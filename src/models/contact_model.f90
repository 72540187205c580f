!> The contact of two bodies as the driver sees it: one interface for asperities and for the pixels
!> of a height map.
!>
!> A model places the bodies at a position. A position solves the states of its path one after the
!> other: each is the history of the next.
module asperity_contact_model
  use asperity_contact_records, only: position_result
  use asperity_interruption, only: interruption
  use asperity_kinds, only: int64, real64
  use asperity_work_count, only: work_count
  implicit none
  private

  public :: contact_model, path_step, placed_bodies, at_distance, at_load, held_distance, &
            held_load, no_load

  integer, parameter :: at_distance = 1    !! at a given compression or separation
  integer, parameter :: at_load = 2        !! at a given load
  integer, parameter :: held_distance = 3  !! in a hold, at the compression of the last state
  integer, parameter :: held_load = 4      !! in a hold, at the load of the last state of loading

  real(real64), parameter :: no_load = huge(1.0_real64)  !! no load is prescribed

  !> Control of one state.
  type :: path_step
    integer :: control = at_distance     !! `at_distance`, `at_load`, `held_distance`, `held_load`
    real(real64) :: value = 0.0_real64   !! compression, separation or load, in units of the model
    real(real64) :: time = 0.0_real64    !! time since the begin of loading
    real(real64) :: load = no_load       !! prescribed load, in units of the model, or `no_load`
  end type path_step

  !> Two bodies ready to be placed at positions. Positions are independent, so threads may solve
  !> them in parallel.
  type, abstract :: contact_model
    integer :: positions = 0              !! number of positions of the scene
    integer :: states = 1                 !! estimated states of a position
    integer(int64) :: work = 0_int64      !! largest number of asperities or pixels of a position
    !> Total normal force and vertical load are both reported when they differ by more than this
    !> fraction; huge: never.
    real(real64) :: loads_differ = huge(1.0_real64)
    real(real64) :: nominal_area = 0.0_real64  !! in the scene's unit; 0: not given
    logical :: keep_rows = .true.         !! keep the contacts of every state
    type(interruption) :: interrupt       !! interruption of the run
    type(work_count) :: progress_count    !! progress of the run, in states
  contains
    procedure(place_bodies), deferred :: place  !! places the bodies at a position
  end type contact_model

  !> The bodies at one position, in their last state.
  type, abstract :: placed_bodies
    logical :: keep_rows = .true.  !! keep the contacts of every state
  contains
    procedure(list_steps), deferred :: list_steps  !! lists the states of the position
    procedure(solve_step), deferred :: solve_step  !! solves the next state and adds it
    procedure(add_totals), deferred :: add_totals  !! adds what the last of all states completes
  end type placed_bodies

  abstract interface
    !> Places the bodies at a position. Where its result needs no path it is complete, and `bodies`
    !> is not allocated. A path is repeated with all pairs, or with the effects that it calls for.
    subroutine place_bodies(self, m, is_repeat, bodies, result, failure)
      import :: contact_model, placed_bodies, position_result
      implicit none
      class(contact_model), intent(in), target :: self        !! bodies ready to be placed
      integer, intent(in) :: m                                !! position, from 1
      logical, intent(in) :: is_repeat                        !! the path has to be repeated
      !> the bodies there; on a repeat those of the path before
      class(placed_bodies), allocatable, intent(inout) :: bodies
      type(position_result), intent(out) :: result            !! displacement, or all results
      character(len=:), allocatable, intent(out) :: failure   !! reason, when it is not solved
    end subroutine place_bodies

    !> Lists the states of a position: loading, a path, a hold.
    subroutine list_steps(self, steps, failure)
      import :: path_step, placed_bodies
      implicit none
      class(placed_bodies), intent(inout), target :: self             !! bodies without contact
      type(path_step), allocatable, intent(out) :: steps(:)   !! at least one
      character(len=:), allocatable, intent(out) :: failure   !! reason, when there are none
    end subroutine list_steps

    !> Solves the next state of the path and adds it to the results, with its contacts when they are
    !> kept. `must_repeat` is set where more pairs, or an effect, turn out to matter.
    subroutine solve_step(self, step, number, result, must_repeat, failure)
      import :: path_step, placed_bodies, position_result
      implicit none
      class(placed_bodies), intent(inout), target :: self             !! in the state before
      type(path_step), intent(in) :: step                     !! control of the state
      integer, intent(in) :: number                           !! number of the state, from 1
      type(position_result), intent(inout) :: result          !! with allocated states
      logical, intent(out) :: must_repeat                     !! whether the path has to be repeated
      character(len=:), allocatable, intent(out) :: failure   !! reason, when it is not solved
    end subroutine solve_step

    !> Completes the results of a position after its last state.
    subroutine add_totals(self, steps, result, failure)
      import :: path_step, placed_bodies, position_result
      implicit none
      class(placed_bodies), intent(inout), target :: self             !! in the last state
      type(path_step), intent(in) :: steps(:)                 !! all states of the path
      type(position_result), intent(inout) :: result          !! with all states
      character(len=:), allocatable, intent(out) :: failure   !! reason, when it is not solved
    end subroutine add_totals
  end interface

end module asperity_contact_model
