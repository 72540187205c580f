!> Solution of a scene by its model: a map on its pixels, or two surfaces of summits.
module asperity_model_solve
  use asperity_asperity_model, only: make_asperity_model
  use asperity_contact_model, only: contact_model
  use asperity_contact_records, only: solve_method
  use asperity_effect_header, only: effect_header
  use asperity_pixel_model, only: make_pixel_model
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: effect_off, scene
  use asperity_sweep, only: sweep_scene
  implicit none
  private

  public :: has_effects, solve_effects, solve_map

contains

  !> Solves a map on its pixels with its effects.
  subroutine solve_map(scene_in, options, results, failure)
    type(scene), intent(in), target :: scene_in            !! scene with a map, checked
    type(run_options), intent(in) :: options               !! options of the run
    type(scene_results), intent(inout) :: results          !! results of all positions
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is not solved
    class(contact_model), allocatable, target :: model

    allocate (results%effects)
    call make_pixel_model(scene_in, options%fields, model, results%effects, failure, &
                          options%largest_error)
    if (allocated(failure)) return
    results%nominal_area = max(scene_in%nominal_area, model%nominal_area)
    call sweep_scene(scene_in, options, model, results, failure)
  end subroutine solve_map

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

  !> Whether a scene has effects, or a path of several values.
  pure logical function has_effects(scene_in)
    type(scene), intent(in) :: scene_in  !! scene, checked for faults

    has_effects = any(scene_in%effects%modes /= effect_off) .or. allocated(scene_in%loading%path)
  end function has_effects

end module asperity_model_solve
