!> Solution of two surfaces of summits: with their effects, in an arithmetic, or in the fastest
!> arithmetic within an accuracy.
module asperity_surface_solve
  use asperity_accuracy_bound, only: error_bound, front_arithmetics
  use asperity_accuracy_choice, only: check_left_out, influence_left_out
  use asperity_arithmetics, only: solver_in
  use asperity_contact_records, only: solve_method
  use asperity_effect_solver, only: make_effect_solver
  use asperity_kinds, only: real64
  use asperity_position_solver, only: position_solver
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: effect_header, scene_results
  use asperity_scene_values, only: scene
  use asperity_sweep, only: sweep_scene
  implicit none
  private

  public :: needs_doubles, solve_in_arithmetic, solve_surfaces

contains

  !> Solves two surfaces of summits, or one and a plane.
  subroutine solve_surfaces(scene_in, chosen, results, failure)
    type(scene), intent(in) :: scene_in                    !! scene without a map, checked
    type(run_options), intent(in) :: chosen                !! options of the run
    type(scene_results), intent(inout) :: results          !! results of all positions
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is not solved

    if (chosen%accuracy > 0 .and. .not. needs_doubles(scene_in)) then
      call solve_to_accuracy(scene_in, chosen, results, failure)
    else
      call solve_effects(scene_in, chosen, results, failure)
    end if
  end subroutine solve_surfaces

  !> Solves every position without effects, in the arithmetic of the options, by a method: the
  !> default is `solve_method()`; others are for the accuracy study.
  subroutine solve_in_arithmetic(scene_in, method, options, results, failure)
    type(scene), intent(in) :: scene_in                    !! scene, checked for faults
    type(solve_method), intent(in) :: method               !! method of the solver
    type(run_options), intent(in) :: options               !! options with the arithmetic
    type(scene_results), intent(out) :: results            !! results of all positions
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is not solved
    class(position_solver), allocatable :: solver

    results%arithmetic = options%arithmetic
    call solver_in(trim(options%arithmetic), scene_in, method, solver, failure)
    if (.not. allocated(failure)) call sweep_scene(scene_in, options, solver, results, failure)
  end subroutine solve_in_arithmetic

  ! Solves a scene with its effects in doubles; without effects in the arithmetic of the options.
  subroutine solve_effects(scene_in, options, results, failure)
    type(scene), intent(in), target :: scene_in
    type(run_options), intent(in) :: options
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure
    class(position_solver), allocatable :: solver
    type(effect_header) :: header

    if (options%arithmetic /= 'real64' .and. needs_doubles(scene_in)) then
      failure = 'effects and paths of several values are computed in real64 only'
      return
    end if
    results%arithmetic = options%arithmetic
    call make_effect_solver(scene_in, trim(options%arithmetic), solver, header, failure, &
                            options%fields)
    if (needs_doubles(scene_in)) results%effects = header
    if (.not. allocated(failure)) call sweep_scene(scene_in, options, solver, results, failure)
  end subroutine solve_effects

  ! Solves a scene in the fastest arithmetic whose error bound is within the requested accuracy.
  subroutine solve_to_accuracy(scene_in, options, results, failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure
    type(run_options) :: candidate
    character(len=10) :: bound_text
    integer :: i

    candidate = options
    do i = 1, size(front_arithmetics)
      candidate%arithmetic = front_arithmetics(i)
      call solve_effects(scene_in, candidate, results, failure)
      if (allocated(failure)) return
      call check_left_out(scene_in, options%accuracy, results, failure)
      if (allocated(failure)) return
      results%error_bound = error_bound(trim(candidate%arithmetic), scene_in, results%positions) + &
                            influence_left_out(results)
      if (results%error_bound <= options%accuracy) then
        results%way_taken = trim(candidate%arithmetic) // ', exact events'
        results%way_told = 'ten times better: reached by this run'
        if (results%error_bound > 0.1_real64 * options%accuracy) &
          results%way_told = 'ten times better: ' // trim(merge( &
            'real128, up to 40 times the run time', 'not possible                        ', i == 1))
        return
      end if
    end do
    write (bound_text, '(es10.1e3)') results%error_bound
    failure = 'no method has this accuracy; the most accurate one, ' // &
              trim(candidate%arithmetic) // ', has an error of' // bound_text
  end subroutine solve_to_accuracy

  !> Whether a scene is solved in doubles only: with effects, or a path of several values.
  pure logical function needs_doubles(scene_in)
    type(scene), intent(in) :: scene_in  !! scene, checked for faults

    needs_doubles = scene_in%effects%any_on() .or. allocated(scene_in%loading%path)
  end function needs_doubles

end module asperity_surface_solve
