!> Solution of a map on its pixels.
module asperity_map_solve
  use asperity_contact_model, only: contact_model
  use asperity_pixel_model, only: make_pixel_model
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: scene
  use asperity_sweep, only: sweep_scene
  implicit none
  private

  public :: solve_map

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

end module asperity_map_solve
