!> The contact of two bodies as the driver sees it: one interface for asperities and for the pixels
!> of a height map.
!>
!> A model places the bodies at a position. A position solves the states of its path one after the
!> other: each is the history of the next.
module asperity_contact_model
  use asperity_contact_records, only: most_rows, position_result
  use asperity_interruption, only: interruption
  use asperity_kinds, only: int64, real64
  use asperity_scene_values, only: hold_load, scene
  use asperity_solution_start, only: solution_reuse
  use asperity_viscoelastic_solid, only: hold_times, relaxing_solid, solid_of_scene
  use asperity_work_count, only: work_count
  implicit none
  private

  public :: contact_model, path_step, placed_bodies, at_distance, at_load, held_distance, &
            held_load, no_load, follow_path, plan_hold, plan_path, solve_position

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
    type(solution_reuse) :: reuse         !! solutions of an earlier run
  contains
    procedure(place_bodies), deferred :: place  !! places the bodies at a position
  end type contact_model

  !> The bodies at one position, in their last state.
  type, abstract :: placed_bodies
    logical :: keep_rows = .true.  !! keep the contacts of every state
  contains
    procedure(list_steps), deferred :: list_steps  !! lists the states of the position
    procedure(solve_step), deferred :: solve_step  !! solves the next state
    procedure(add_state), deferred :: add_state    !! adds the last state to the results
    procedure(add_totals), deferred :: add_totals  !! adds what the last of all states completes
  end type placed_bodies

  abstract interface
    !> Places the bodies at a position. Where its result needs no path it is complete, and `bodies`
    !> is not allocated.
    subroutine place_bodies(self, m, bodies, result, failure)
      import :: contact_model, placed_bodies, position_result
      implicit none
      class(contact_model), intent(in), target :: self        !! bodies ready to be placed
      integer, intent(in) :: m                                !! position, from 1
      class(placed_bodies), allocatable, intent(out) :: bodies  !! the bodies there
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

    !> Solves the next state of the path. `must_repeat` is set where more pairs turn out to matter.
    subroutine solve_step(self, step, must_repeat, failure)
      import :: path_step, placed_bodies
      implicit none
      class(placed_bodies), intent(inout), target :: self             !! in the state before
      type(path_step), intent(in) :: step                     !! control of the state
      logical, intent(out) :: must_repeat                     !! whether the path has to be repeated
      character(len=:), allocatable, intent(out) :: failure   !! reason, when it is not solved
    end subroutine solve_step

    !> Adds the last state to the results, with its contacts when they are kept.
    subroutine add_state(self, step, number, result)
      import :: path_step, placed_bodies, position_result
      implicit none
      class(placed_bodies), intent(inout), target :: self      !! in the state
      type(path_step), intent(in) :: step              !! control of the state
      integer, intent(in) :: number                    !! number of the state, from 1
      type(position_result), intent(inout) :: result   !! with allocated states
    end subroutine add_state

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

contains

  !> Solves all states of a position. `failure` is allocated when its end cannot be reached.
  subroutine solve_position(model, m, result, failure)
    class(contact_model), intent(in), target :: model       !! bodies ready to be placed
    integer, intent(in) :: m                                !! position, from 1
    type(position_result), intent(out) :: result            !! states, ending with the last
    character(len=:), allocatable, intent(out) :: failure   !! set where the end is not reached
    class(placed_bodies), allocatable, target :: bodies
    type(position_result) :: placed
    logical :: must_repeat

    call model%place(m, bodies, placed, failure)
    result = placed
    if (allocated(failure) .or. .not. allocated(bodies)) return
    bodies%keep_rows = model%keep_rows
    do
      call follow_path(bodies, model%progress_count, result, must_repeat, failure)
      if (.not. must_repeat) return
      call model%progress_count%add_work(-result%counted)
      if (allocated(failure)) return
      result = placed
    end do
  end subroutine solve_position

  !> Follows the path of placed bodies once.
  subroutine follow_path(bodies, progress_count, result, must_repeat, failure)
    class(placed_bodies), intent(inout), target :: bodies   !! bodies without contact
    type(work_count), intent(in) :: progress_count          !! progress of the run, in states
    type(position_result), intent(inout) :: result          !! without states; gets them
    logical, intent(out) :: must_repeat                     !! whether the path has to be repeated
    character(len=:), allocatable, intent(out) :: failure   !! set where the end is not reached
    type(path_step), allocatable :: steps(:)
    integer :: i

    must_repeat = .false.
    call bodies%list_steps(steps, failure)
    if (allocated(failure)) return
    allocate (result%states(size(steps)), result%rows(0))
    do i = 1, size(steps)
      call bodies%solve_step(steps(i), must_repeat, failure)
      if (allocated(failure) .or. must_repeat) return
      call bodies%add_state(steps(i), i, result)
      call progress_count%count_state(result%counted)
      ! The states end early when there are more contacts than can be kept.
      if (result%rows_used > most_rows) return
    end do
    call bodies%add_totals(steps, result, failure)
  end subroutine follow_path

  !> Plans the states between values of a path: equal parts lie between two of them. The path begins
  !> with its first contact where there are several parts. In time it has a constant rate.
  pure subroutine plan_path(from, ends, points, by_load, duration, steps)
    real(real64), intent(in) :: from       !! value of first contact
    real(real64), intent(in) :: ends(:)    !! values of the path, in units of the model
    integer, intent(in) :: points          !! parts between two values; 0: one, several in time
    logical, intent(in) :: by_load         !! whether values are loads
    real(real64), intent(in) :: duration   !! time of the path; 0: it is instantaneous
    type(path_step), allocatable, intent(out) :: steps(:)
    ! Parts of loading in time (chosen: those of a hold; test: Ting in test_creep_pixels.py).
    integer, parameter :: parts_in_time = 20
    real(real64) :: before, length
    integer :: i, j, parts, used

    parts = max(1, points)
    if (duration > 0.0_real64 .and. points == 0) parts = parts_in_time
    allocate (steps(merge(1, 0, parts > 1) + parts * size(ends)))
    steps%control = merge(at_load, at_distance, by_load)
    used = size(steps) - parts * size(ends)
    if (used > 0) steps(1)%value = from
    before = from
    length = 0.0_real64
    do i = 1, size(ends)
      do j = 1, parts
        used = used + 1
        steps(used)%value = before + (ends(i) - before) * (real(j, real64) / real(parts, real64))
        steps(used)%time = length + abs(ends(i) - before) * (real(j, real64) / real(parts, real64))
      end do
      steps(used)%value = ends(i)
      length = length + abs(ends(i) - before)
      before = ends(i)
    end do
    if (length > 0.0_real64) steps%time = duration * (steps%time / length)
    if (by_load) steps%load = steps%value
  end subroutine plan_path

  !> Plans the states of a hold after the last state of loading.
  subroutine plan_hold(scene_in, steps)
    type(scene), intent(in) :: scene_in                     !! scene, checked for faults
    type(path_step), allocatable, intent(out) :: steps(:)   !! states; without a hold none
    type(relaxing_solid) :: solid

    solid = solid_of_scene(scene_in)
    associate (effects => scene_in%effects)
      associate (times => hold_times(effects%number('hold_time'), solid%time(1), &
                                     nint(effects%number('hold_points'))))
        allocate (steps(size(times) - 1))
        steps%time = solid%loading_time + times(2:)
      end associate
      steps%control = merge(held_load, held_distance, nint(effects%number('hold')) == hold_load)
    end associate
  end subroutine plan_hold

end module asperity_contact_model
