!> The library: what a program needs to read or build a scene, solve it, and use its results.
!>
!> `docs/library.md` shows how.
module asperity
  use asperity_contact_records, only: contact_row, effect_record, position_result, state_row
  use asperity_problems, only: problem_list
  use asperity_run_options, only: run_options
  use asperity_scene_reader, only: build_scene, read_scene
  use asperity_scene_results, only: effect_header, last_state, scene_results
  use asperity_scene_surfaces, only: plane_surface, take_surface
  use asperity_scene_values, only: scene, scene_surface
  use asperity_solve, only: solve
  use asperity_version, only: version
  implicit none
  private

  ! Scenes.
  public :: scene, scene_surface, problem_list
  public :: read_scene, take_surface, plane_surface, build_scene
  ! Running them.
  public :: solve, run_options, version
  ! Results.
  public :: scene_results, position_result, state_row, contact_row, effect_record, effect_header
  public :: last_state

end module asperity
