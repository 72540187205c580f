!> The library: what a program needs to read or build a scene, solve it, and use its results.
!>
!> `docs/library.md` shows how.
module asperity
  use asperity_contact_records, only: contact_row, effect_record, position_result, state_row
  use asperity_kinds, only: not_computed
  use asperity_height_map, only: height_map, is_measured, no_height
  use asperity_height_map_reader, only: read_height_map
  use asperity_map_despiking, only: despike_map
  use asperity_map_levelling, only: level_map, level_mean, level_none, level_plane
  use asperity_map_statistics, only: map_statistics, measure_map
  use asperity_map_summits, only: find_summits, map_summits, rule_contact, rule_eight
  use asperity_problems, only: problem_list
  use asperity_run_options, only: run_options
  use asperity_scene_reader, only: build_scene, read_scene
  use asperity_scene_results, only: effect_header, kinds_of_warnings, last_state, &
                                    scene_results
  use asperity_scene_surfaces, only: plane_surface, take_surface
  use asperity_scene_values, only: scene, scene_surface
  use asperity_solve, only: solve
  use asperity_theory_warnings, only: theory_warning, warning_kind, warning_kinds
  use asperity_summit_spheres, only: radius_geometric, radius_neighbours, radius_paraboloid
  use asperity_version, only: version
  use asperity_warning_lines, only: list_warnings
  implicit none
  private

  ! Scenes.
  public :: scene, scene_surface, problem_list
  public :: read_scene, take_surface, plane_surface, build_scene
  ! Measured maps and their summits.
  public :: height_map, is_measured, no_height, read_height_map
  public :: level_map, level_plane, level_mean, level_none, despike_map
  public :: find_summits, map_summits, rule_eight, rule_contact
  public :: radius_neighbours, radius_geometric, radius_paraboloid
  public :: measure_map, map_statistics
  ! Running scenes.
  public :: solve, run_options, version
  ! Results.
  public :: scene_results, position_result, state_row, contact_row, effect_record, effect_header
  public :: last_state
  ! What lies outside a theory, and what was not computed.
  public :: theory_warning, warning_kind, warning_kinds, kinds_of_warnings, list_warnings
  public :: not_computed

end module asperity
