!> How much of each total's error comes from the arithmetic, from the step and from the model.
!>
!> The model's share is measured against `boundary` at the same approach. At a given load the error
!> is in the approach instead: the scene's contacts are pressed to the load at which `boundary`
!> would carry the given one. `boundary` has vertical gaps only: an inclined contact by itself has
!> another load there than by Hertz's equations along its normal, by about slope**2/4. Therefore
!> the factor is compared, the load of the contacts together over the load of the same contacts
!> each alone, and the area in plan.
module asperity_error_budget
  use asperity_accuracy_choice, only: error_bound
  use asperity_contact_records, only: solve_method, state_row
  use asperity_decimal, only: decimal_to_real64
  use asperity_kinds, only: real64
  use asperity_numeral, only: rounded_decimal
  use asperity_problems, only: decimal_text
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: last_state, scene_results
  use asperity_scene_values, only: control_separation, effect_boundary, effect_off, is_load, scene
  use asperity_solve, only: solve
  use asperity_surface_solve, only: has_effects, solve_effects
  implicit none
  private

  public :: budget_line, error_budget, model_budget, measure_budget
  public :: share_given, share_measured, share_unknown, of_load, of_area, of_approach

  !> One total: its value and the plus-or-minus of each source, in the total's own unit.
  type :: budget_line
    character(len=14) :: name = ''            !! the total
    real(real64) :: value = 0.0_real64        !! over one position, or the average of the sweep
    real(real64) :: arithmetic = 0.0_real64   !! largest over the positions
    real(real64) :: step = 0.0_real64         !! largest over the positions; exact events have none
  end type budget_line

  ! State of the model's share in a total.
  integer, parameter :: share_unknown = 1   !! not estimated
  integer, parameter :: share_measured = 2  !! against `boundary`
  integer, parameter :: share_given = 3     !! the total is given: it has none

  ! Places of the totals.
  integer, parameter :: of_load = 1           !! sum of the normal forces
  integer, parameter :: of_vertical_load = 2  !! sum of their vertical parts
  integer, parameter :: of_area = 3           !! contact area
  integer, parameter :: of_approach = 4       !! approach

  !> The model's share in every total.
  type :: model_budget
    integer :: interaction = effect_off            !! how the scene takes contacts together
    integer :: known(4) = share_unknown            !! what is known of the share
    real(real64) :: error(4) = 0.0_real64          !! largest over the positions, the total's unit
    real(real64) :: cells_are_good_to = 0.0_real64 !! boundary_tolerance, a share of the load
    character(len=:), allocatable :: why_not       !! why nothing is measured
  end type model_budget

  !> The budget of a scene.
  type :: error_budget
    type(budget_line) :: lines(4)   !! load, vertical load, area, approach
    type(model_budget) :: model     !! of the same totals: what the model leaves out
    logical :: without_effects = .false.  !! arithmetic: bound without the scene's effects
  end type error_budget

  ! Largest sum over the positions of the squared number of contacts for boundary elements: 500 in
  ! one position, or 5 in each of 10000, take some minutes (chosen). `test_too_many_contacts_for_a_
  ! budget` of test_accuracy.py has 528.
  real(real64), parameter :: squares_allowed = 250000.0_real64

contains

  !> Bounds the error of rounding, and compares the model with contacts on cells. With effects the
  !> bound is that of the scene without, at the deepest of a path.
  !> `failure` is allocated when the scene without effects cannot be solved.
  subroutine measure_budget(scene_in, options, results, budget, failure)
    type(scene), intent(in) :: scene_in                    !! what was solved
    type(run_options), intent(in) :: options               !! threads and progress of the runs
    type(scene_results), intent(in) :: results             !! its results, by exact events
    type(error_budget), intent(out) :: budget              !! plus-or-minus of the totals
    character(len=:), allocatable, intent(out) :: failure  !! reason of a failure
    type(scene_results) :: plain
    type(state_row) :: last(size(results%positions))
    real(real64) :: bound, totals(4)
    type(run_options) :: beside
    integer :: m

    beside = run_options(keep_contacts=.false., threads=options%threads, progress=options%progress)
    budget%without_effects = has_effects(scene_in)
    bound = error_bound(scene_in, results%positions)
    if (budget%without_effects) then
      call solve_effects(scene_in, beside, plain, failure, solve_method())
      if (allocated(failure)) return
      bound = error_bound(scene_in, plain%positions)
    end if
    budget%lines%name = [character(len=14) :: 'total load', 'vertical load', 'contact area', &
                         'separation']
    last = [(last_state(results%positions(m)), m=1, size(last))]
    do m = 1, size(last)
      totals = [last(m)%load, last(m)%vertical_load, last(m)%area, last(m)%approach]
      budget%lines%value = budget%lines%value + totals / size(last)
      budget%lines%arithmetic = max(budget%lines%arithmetic, bound * abs(totals))
    end do
    ! The model's share. What cannot be measured stays unknown: that is no failure.
    associate (model => budget%model)
      model%interaction = scene_in%effects%mode('interaction')
      model%cells_are_good_to = scene_in%effects%number('boundary_tolerance')
      associate (effects => scene_in%effects)
        if (any([effects%mode('plasticity'), effects%mode('adhesion'), effects%mode('creep')] &
                /= effect_off)) then
          model%why_not = 'boundary elements are for elastic contacts only'
        else if (allocated(scene_in%loading%path)) then
          model%why_not = 'it depends on the load history'
        end if
      end associate
      if (.not. allocated(model%why_not) .and. &
          sum(real(last%contacts, real64)**2) > squares_allowed) &
        model%why_not = 'up to ' // decimal_text(maxval(last%contacts)) // &
                        ' contacts at a position are too many for boundary elements'
      if (allocated(model%why_not)) return
      if (model%interaction /= effect_boundary) then
        call compare_models(scene_in, beside, results, model)
        return
      end if
      ! Boundary elements are the reference: their error is their tolerance.
      model%error(of_load) = model%cells_are_good_to * max(0.0_real64, maxval(last%load))
      model%error(of_vertical_load) = model%cells_are_good_to * &
                                      max(0.0_real64, maxval(last%vertical_load))
      model%known = [share_measured, share_measured, share_unknown, &
                     merge(share_unknown, share_given, is_load(scene_in%loading%control))]
    end associate
  end subroutine measure_budget

  ! Compares the interaction of the scene with boundary elements at the separation of every
  ! position. Under load control these carry another load there; the largest such share is made up
  ! for by more load.
  subroutine compare_models(scene_in, options, results, model)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(scene_results), intent(in) :: results
    type(model_budget), intent(inout) :: model
    type(scene) :: one
    type(scene_results) :: used, cells
    real(real64) :: factor(2), share
    type(state_row) :: of_cells, of_used, last
    integer :: m

    share = 0.0_real64
    do m = 1, size(results%positions)
      last = last_state(results%positions(m))
      associate (position => results%positions(m))
        one = scene_in
        one%motion%positions = 1
        one%motion%x_first = rounded_decimal(position%x_displacement, 17)
        one%motion%y_first = rounded_decimal(position%y_displacement, 17)
        one%loading%control = control_separation
        one%loading%value = rounded_decimal(last%approach, 17)
        call run_model(one, model%interaction, options, used, model%why_not)
        if (.not. allocated(model%why_not)) &
          call run_model(one, effect_boundary, options, cells, model%why_not)
        if (allocated(model%why_not)) return
        factor = [factor_of(used), factor_of(cells)]
        of_used = last_state(used%positions(1))
        of_cells = last_state(cells%positions(1))
        if (is_load(scene_in%loading%control)) then
          if (factor(2) > 0.0_real64) share = max(share, abs(factor(1) / factor(2) - 1.0_real64))
        else
          if (factor(1) > 0.0_real64) factor = factor / factor(1)
          model%error(of_load:of_vertical_load) = max(model%error(of_load:of_vertical_load), &
            abs(factor(1) - factor(2)) * [last%load, last%vertical_load])
          if (of_used%projected_area > 0.0_real64) model%error(of_area) = &
            max(model%error(of_area), last%area * &
                abs(1.0_real64 - of_cells%projected_area / of_used%projected_area))
        end if
      end associate
    end do
    if (.not. is_load(scene_in%loading%control)) then
      model%known = share_measured
      model%known(of_approach) = share_given
      return
    end if
    one = scene_in
    one%loading%value = rounded_decimal(decimal_to_real64(one%loading%value) * &
                                        (1.0_real64 + share), 17)
    call run_model(one, model%interaction, options, used, model%why_not)
    if (allocated(model%why_not)) return
    do m = 1, size(results%positions)
      of_used = last_state(used%positions(m))
      last = last_state(results%positions(m))
      model%error(of_approach) = max(model%error(of_approach), &
                                     abs(of_used%approach - last%approach))
    end do
    model%known = [share_given, share_given, share_unknown, share_measured]
  end subroutine compare_models

  !> Runs a scene with `interaction` set, all its other effects as they are, to the last state only.
  subroutine run_model(scene_in, interaction, options, results, failure)
    type(scene), intent(in) :: scene_in                    !! scene with checked values
    integer, intent(in) :: interaction                     !! one of the `effect_` numbers
    type(run_options), intent(in) :: options               !! options of a run
    type(scene_results), intent(out) :: results            !! results, all positions
    character(len=:), allocatable, intent(out) :: failure  !! reason of a failure
    type(scene) :: copy

    copy = scene_in
    call copy%effects%call_for('interaction', interaction)
    copy%loading%points = 0
    call solve(copy, results, failure, options)
  end subroutine run_model

  ! Load with interaction over that of the same contacts isolated, at the only position; 1 where
  ! interaction is off or was left out.
  pure real(real64) function factor_of(results) result(factor)
    type(scene_results), intent(in) :: results
    integer :: column, e

    factor = 1.0_real64
    if (.not. allocated(results%effects)) return
    associate (position => results%positions(1))
      e = findloc(results%effects%names == 'interaction', .true., 1)
      if (e > 0) then
        if (position%effects(e)%simulated == 'off') return
      end if
      column = findloc(results%effects%state_columns == 'factor', .true., 1)
      if (column > 0) factor = position%state_values(column)
    end associate
  end function factor_of

end module asperity_error_budget
