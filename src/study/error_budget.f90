!> How much of each total's error comes from the arithmetic, from the step and from the model.
module asperity_error_budget
  use asperity_contact_records, only: solve_method, state_row
  use asperity_kinds, only: real64
  use asperity_model_budget, only: measure_model, model_budget
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: last_state, scene_results
  use asperity_scene_values, only: scene
  use asperity_surface_solve, only: solve_in_arithmetic
  implicit none
  private

  public :: budget_line, error_budget, measure_budget

  !> One total: its value and the plus-or-minus of each source, in the total's own unit.
  type :: budget_line
    character(len=14) :: name = ''            !! the total
    real(real64) :: value = 0.0_real64        !! over one position, or the average of the sweep
    real(real64) :: arithmetic = 0.0_real64   !! largest over the positions
    real(real64) :: step = 0.0_real64         !! largest over the positions; exact events have none
  end type budget_line

  !> The budget of a scene.
  type :: error_budget
    type(budget_line) :: lines(4)   !! load, vertical load, area, approach
    type(model_budget) :: model     !! of the same totals: what the model leaves out
    logical :: by_reference = .false.     !! arithmetic: only rounding to doubles remains
    logical :: without_effects = .false.  !! arithmetic: compared without the scene's effects
  end type error_budget

contains

  !> Compares results with exact events in real128, and the model with contacts on cells. Effects
  !> are computed in doubles only: with them the arithmetic is that of the scene without, at the
  !> deepest of a path.
  !> `failure` is allocated when the arithmetics cannot be run.
  subroutine measure_budget(scene_in, options, results, budget, failure)
    type(scene), intent(in) :: scene_in                    !! what was solved
    type(run_options), intent(in) :: options               !! threads and progress of the runs
    type(scene_results), intent(in) :: results             !! its results, by exact events
    type(error_budget), intent(out) :: budget              !! plus-or-minus of the totals
    character(len=:), allocatable, intent(out) :: failure  !! why not
    type(scene_results) :: reference, plain
    real(real64) :: have(4), want(4)
    type(run_options) :: beside
    integer :: m

    beside = run_options(keep_contacts=.false., threads=options%threads, &
                         progress=options%progress)
    beside%arithmetic = 'real128'
    call solve_in_arithmetic(scene_in, solve_method(), beside, reference, failure)
    if (allocated(failure)) return
    budget%by_reference = results%arithmetic == 'real128'
    budget%without_effects = scene_in%effects%any_on() .or. allocated(scene_in%loading%path)
    if (budget%without_effects) then
      beside%arithmetic = results%arithmetic
      call solve_in_arithmetic(scene_in, solve_method(), beside, plain, failure)
      if (allocated(failure)) return
    end if
    budget%lines%name = [character(len=14) :: 'total load', 'vertical load', 'contact area', &
                         'approach']
    do m = 1, size(results%positions)
      have = totals(results, m)
      budget%lines%value = budget%lines%value + have / size(results%positions)
      if (budget%without_effects) have = totals(plain, m)
      want = totals(reference, m)
      ! The reference itself is handed over as doubles.
      budget%lines%arithmetic = max(budget%lines%arithmetic, abs(have - want) + 0.5 * spacing(want))
    end do
    call measure_model(scene_in, beside, results, budget%model)
  end subroutine measure_budget

  !> Load, vertical load, area and approach of the last state.
  pure function totals(results, m) result(row)
    type(scene_results), intent(in) :: results
    integer, intent(in) :: m
    real(real64) :: row(4)
    type(state_row) :: last

    last = last_state(results%positions(m))
    row = [last%load, last%vertical_load, last%area, last%approach]
  end function totals

end module asperity_error_budget
