!> One run of a scene with one way of taking neighbouring contacts together, for comparing ways.
!>
!> `boundary` knows vertical gaps only: an inclined contact by itself has another load there than by
!> Hertz's equations along its normal, by about slope**2/4. What is compared is therefore the
!> factor, load of the contacts together over load of the same contacts each alone, and the area in
!> plan.
module asperity_model_run
  use asperity_contact_records, only: state_row
  use asperity_kinds, only: real64
  use asperity_problems, only: decimal_text
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: last_state, scene_results
  use asperity_scene_values, only: scene
  use asperity_solve, only: solve
  implicit none
  private

  public :: model_run, run_model, take_last_states, too_many_for_cells

  !> Contacts of a position, squared and summed over the positions, that are solved on cells: 500 in
  !> one position, or 5 in each of 10000, take some minutes.
  real(real64), parameter :: squares_allowed = 250000.0_real64

  !> The last state of every position.
  type :: model_run
    type(state_row), allocatable :: last(:)   !! its totals
    real(real64), allocatable :: factor(:)    !! load together over load alone, vertical
  end type model_run

contains

  !> Runs a scene with `interaction` set, all its other effects as they are, to the last state only.
  subroutine run_model(scene_in, interaction, options, run, failure)
    type(scene), intent(in) :: scene_in                    !! checked values
    integer, intent(in) :: interaction                     !! one of the `effect_` numbers
    type(run_options), intent(in) :: options               !! in doubles
    type(model_run), intent(out) :: run                    !! all positions
    character(len=:), allocatable, intent(out) :: failure  !! why not
    type(scene) :: copy
    type(scene_results) :: results

    copy = scene_in
    call copy%effects%call_for('interaction', interaction)
    copy%loading%points = 0
    call solve(copy, results, failure, options)
    if (.not. allocated(failure)) call take_last_states(results, run)
  end subroutine run_model

  !> Why the contacts of a solved scene are too many for cells; empty when they are not.
  pure function too_many_for_cells(results) result(why)
    type(scene_results), intent(in) :: results   !! of any way of taking them together
    character(len=:), allocatable :: why
    real(real64) :: squares
    integer :: m, most
    type(state_row) :: last

    squares = 0.0_real64
    most = 0
    do m = 1, size(results%positions)
      last = last_state(results%positions(m))
      squares = squares + real(last%contacts, real64)**2
      most = max(most, last%contacts)
    end do
    why = ''
    if (squares > squares_allowed) &
      why = 'up to ' // decimal_text(most) // ' contacts at a position would take long on cells'
  end function too_many_for_cells

  !> The last state of every position, and its factor.
  subroutine take_last_states(results, run)
    type(scene_results), intent(in) :: results  !! solved
    type(model_run), intent(inout) :: run       !! gets them
    integer :: m

    allocate (run%last(size(results%positions)), run%factor(size(results%positions)))
    do m = 1, size(results%positions)
      run%last(m) = last_state(results%positions(m))
      run%factor(m) = factor_of(results, m)
    end do
  end subroutine take_last_states

  ! Load together over load alone; 1 where interaction is off or was left out.
  pure real(real64) function factor_of(results, m) result(factor)
    type(scene_results), intent(in) :: results
    integer, intent(in) :: m
    integer :: column, e

    factor = 1.0_real64
    if (.not. allocated(results%effects)) return
    do e = 1, size(results%effects%names)
      if (results%effects%names(e) /= 'interaction') cycle
      if (results%positions(m)%effects(e)%simulated == 'off') return
    end do
    do column = 1, size(results%effects%state_columns)
      if (results%effects%state_columns(column) == 'factor') &
        factor = results%positions(m)%state_values(column)
    end do
  end function factor_of

end module asperity_model_run
