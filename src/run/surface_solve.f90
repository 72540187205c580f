!> Solution of two surfaces of summits: with their effects, or without them to an accuracy.
module asperity_surface_solve
  use asperity_accuracy_bound, only: error_bound
  use asperity_accuracy_choice, only: add_proposal, check_left_out, influence_left_out
  use asperity_asperity_model, only: make_asperity_model
  use asperity_contact_model, only: contact_model
  use asperity_contact_records, only: solve_method
  use asperity_kinds, only: real64
  use asperity_problems, only: real_text
  use asperity_run_options, only: run_options
  use asperity_effect_header, only: effect_header
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: effect_off, scene
  use asperity_sweep, only: sweep_scene
  implicit none
  private

  public :: has_effects, solve_effects, solve_surfaces

contains

  !> Solves two surfaces of summits, or one and a plane.
  subroutine solve_surfaces(scene_in, chosen, results, failure)
    type(scene), intent(in) :: scene_in                    !! scene without a map, checked
    type(run_options), intent(in) :: chosen                !! options of the run
    type(scene_results), intent(inout) :: results          !! results of all positions
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is not solved

    if (chosen%accuracy > 0 .and. .not. has_effects(scene_in)) then
      call solve_to_accuracy(scene_in, chosen, results, failure)
    else
      call solve_effects(scene_in, chosen, results, failure)
    end if
  end subroutine solve_surfaces

  !> Solves a scene with its effects, or without any by a method.
  subroutine solve_effects(scene_in, options, results, failure, method)
    type(scene), intent(in), target :: scene_in            !! scene, checked for faults
    type(run_options), intent(in) :: options               !! options of the run
    type(scene_results), intent(inout) :: results          !! results of all positions
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is not solved
    type(solve_method), intent(in), optional :: method     !! for the study; absent: with effects
    class(contact_model), allocatable, target :: model
    type(effect_header) :: header

    call make_asperity_model(scene_in, model, header, failure, options%fields, method)
    if (has_effects(scene_in) .and. .not. present(method)) results%effects = header
    if (.not. allocated(failure)) call sweep_scene(scene_in, options, model, results, failure)
  end subroutine solve_effects

  ! Solves a scene without effects, and fails where the error bound exceeds the requested accuracy.
  subroutine solve_to_accuracy(scene_in, options, results, failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure

    call solve_effects(scene_in, options, results, failure)
    if (allocated(failure)) return
    call check_left_out(scene_in, options%accuracy, results, failure)
    if (allocated(failure)) return
    results%error_bound = error_bound(scene_in, results%positions) + influence_left_out(results)
    results%way_taken = 'real64, exact events'
    results%way_told = 'ten times better: reached by this run'
    if (results%error_bound > 0.1_real64 * options%accuracy) &
      results%way_told = 'ten times better: not possible'
    if (results%error_bound <= options%accuracy) return
    failure = 'no method has this accuracy; the most accurate one, real64, has an error of ' // &
              real_text(results%error_bound, 'es7.1')
    call add_proposal(results%error_bound, 'all', failure)
  end subroutine solve_to_accuracy

  !> Whether a scene has effects, or a path of several values.
  pure logical function has_effects(scene_in)
    type(scene), intent(in) :: scene_in  !! scene, checked for faults

    has_effects = any(scene_in%effects%modes /= effect_off) .or. allocated(scene_in%loading%path)
  end function has_effects

end module asperity_surface_solve
