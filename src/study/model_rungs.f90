!> What each rung of the model costs: contacts that know nothing of each other, coupled, `auto`, and
!> on cells of three tolerances. Placing the surfaces is no part of the time.
!>
!> Errors are differences of the factor, load of the contacts together over load of the same
!> contacts each alone, against that on the finest cells. Other effects are left out.
module asperity_model_rungs
  use asperity_arithmetics, only: solver_in
  use asperity_contact_records, only: solve_method
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_effect_solver, only: make_effect_solver
  use asperity_kinds, only: int64, real64
  use asperity_error_budget, only: model_run, take_last_states, too_many_for_cells
  use asperity_position_solver, only: position_solver
  use asperity_progress, only: progress_line
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: effect_auto, effect_boundary, effect_coupled, effect_off, &
                                   scene, scene_effects
  use asperity_solve, only: solve
  use asperity_timing, only: time_allowance, time_solver, timing_samples
  implicit none
  private

  public :: model_rung, run_model_rungs, number_of_rungs

  !> The ladder, and the tolerance of each rung: of `auto` the share of the load that it may leave
  !> out, of `boundary` what halving the cells may change.
  integer, parameter :: ladder(6) = [effect_off, effect_coupled, effect_auto, effect_boundary, &
                                     effect_boundary, effect_boundary]
  integer, parameter :: number_of_rungs = size(ladder)  !! all of them
  type(decimal_value), parameter :: tolerances(6) = &
    [decimal_value(0_int64, 0), decimal_value(0_int64, 0), decimal_value(1_int64, -2), &
     decimal_value(1_int64, -2), decimal_value(1_int64, -3), decimal_value(1_int64, -4)]

  !> One way of taking neighbouring contacts together: its cost and its error.
  type :: model_rung
    integer :: interaction = effect_off       !! one of the `effect_` numbers
    real(real64) :: tolerance = 0.0_real64    !! of `auto` or `boundary`, else 0
    real(real64) :: seconds = 0.0_real64      !! a position, median
    real(real64) :: spread = 0.0_real64       !! half the quartile distance over the median
    integer :: passes = 0                     !! over all positions
    logical :: error_known = .false.          !! whether there were finer cells to compare with
    real(real64) :: largest = 0.0_real64      !! difference of the factor, over the positions
    real(real64) :: mean = 0.0_real64         !! the same, mean over the positions
    integer :: worst_position = 0             !! where it is largest
  end type model_rung

contains

  !> Climbs the ladder as far as it goes; `left_out` says why it ends early. The finest cells are
  !> the reference of the others, and have no error that is known.
  subroutine run_model_rungs(scene_in, least_seconds, allowance, progress, rungs, left_out, failure)
    type(scene), intent(in) :: scene_in                       !! checked values
    real(real64), intent(in) :: least_seconds                 !! time to spend on a rung, s
    type(time_allowance), intent(in) :: allowance             !! time that may be spent
    type(progress_line), intent(inout) :: progress            !! begun; a piece is a rung
    type(model_rung), allocatable, intent(out) :: rungs(:)    !! those that were reached
    character(len=:), allocatable, intent(out) :: left_out    !! why not all of them
    character(len=:), allocatable, intent(out) :: failure     !! why there is none at all
    type(scene) :: bare
    type(scene_effects) :: none
    type(model_run) :: runs(size(ladder))
    type(timing_samples) :: timing
    type(scene_results) :: results
    integer :: i, reached

    bare = scene_in
    bare%effects = none
    bare%loading%points = 0
    call solve(bare, results, failure, run_options(keep_contacts=.false.))
    if (allocated(failure)) return
    left_out = too_many_for_cells(results)
    allocate (rungs(size(ladder)))
    reached = 0
    do i = 1, size(ladder)
      if (ladder(i) == effect_boundary .and. left_out /= '') exit
      call run_timed(bare, i, least_seconds, 2 * allowance%next(), runs(i), timing, failure)
      call progress%step()
      if (.not. allocated(failure) .and. timing%passes() == 0) &
        failure = 'the next level takes longer than --seconds'
      if (allocated(failure)) then
        call move_alloc(failure, left_out)
        exit
      end if
      reached = i
      rungs(i) = model_rung(interaction=ladder(i), tolerance=decimal_to_real64(tolerances(i)), &
                            seconds=timing%median(), spread=timing%spread(), &
                            passes=timing%passes())
    end do
    rungs = rungs(:reached)
    if (reached == 0) return
    if (ladder(reached) /= effect_boundary) return
    do i = 1, reached - 1
      call compare(runs(i), runs(reached), rungs(i))
    end do
  end subroutine run_model_rungs

  ! One rung on the clock.
  subroutine run_timed(bare, number, least_seconds, most_seconds, run, timing, failure)
    type(scene), intent(in) :: bare
    integer, intent(in) :: number
    real(real64), intent(in) :: least_seconds, most_seconds
    type(model_run), intent(out) :: run
    type(timing_samples), intent(out) :: timing
    character(len=:), allocatable, intent(out) :: failure
    class(position_solver), allocatable :: solver
    type(scene_results) :: results
    type(scene), target :: copy

    copy = bare
    call copy%effects%call_for('interaction', ladder(number))
    if (ladder(number) == effect_auto) call copy%effects%set('tolerance', tolerances(number))
    if (ladder(number) == effect_boundary) &
      call copy%effects%set('boundary_tolerance', tolerances(number))
    if (copy%effects%any_on()) then
      allocate (results%effects)
      call make_effect_solver(copy, 'real64', solver, results%effects, failure)
    else
      call solver_in('real64', copy, solve_method(), solver, failure)
    end if
    if (.not. allocated(failure)) &
      call time_solver(solver, least_seconds, most_seconds, results%positions, timing, failure)
    if (.not. allocated(failure) .and. timing%passes() > 0) call take_last_states(results, run)
  end subroutine run_timed

  ! Differences of the factor over all positions.
  pure subroutine compare(run, reference, rung)
    type(model_run), intent(in) :: run, reference
    type(model_rung), intent(inout) :: rung
    real(real64) :: error(size(run%factor))

    error = abs(run%factor - reference%factor)
    rung%error_known = .true.
    rung%largest = maxval(error)
    rung%mean = sum(error) / size(error)
    rung%worst_position = maxloc(error, dim=1)
  end subroutine compare

end module asperity_model_rungs
