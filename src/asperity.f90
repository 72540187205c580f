!> The library: what a program needs to read or build a scene, solve it, and use its results.
!>
!> `docs/reference/fortran.md` shows how. All names used here are public.
module asperity
  ! Scenes.
  use asperity_problems, only: decimal_text, not_enough_memory, problem_list, problem_place
  use asperity_scene_groups, only: list_groups
  use asperity_scene_reader, only: build_scene, build_scene_of, parse_scene, read_scene, &
                                   rebuild_scene
  use asperity_scene_surfaces, only: plane_surface, take_surface
  use asperity_scene_values, only: scene, scene_map, scene_side, scene_surface
  ! Measured maps and their summits.
  use asperity_height_map, only: edge_names, height_map, is_measured, length_units, level_mean, &
                                 level_names, level_none, level_plane, longest_side, no_height, &
                                 periodic_edge, plain_unit, put_in_unit, usual_level
  use asperity_height_map_reader, only: read_height_map, take_map
  use asperity_map_despiking, only: despike_map
  use asperity_map_file, only: note_of_file, write_map_file
  use asperity_map_levelling, only: level_map
  use asperity_map_spectrum, only: measure_spectra, power_spectrum, spectrum_names
  use asperity_map_statistics, only: map_statistics, measure_map
  use asperity_map_summits, only: find_summits, map_summits, rule_contact, rule_eight, &
                                  rule_names
  use asperity_summit_spheres, only: radius_geometric, radius_names, radius_neighbours, &
                                     radius_paraboloid
  use asperity_summits_of_file, only: summit_choices, summits_of_array, summits_of_file
  use asperity_summits_table, only: add_statistics, write_summits_table
  use asperity_unit_names, only: length_power
  ! Generated surfaces.
  use asperity_generated_map, only: generate_map
  use asperity_generated_surface, only: generate_surface, generated_surface, plan_surface, &
                                        surface_plan
  use asperity_generation_spec, only: parse_generation_spec, read_generation_spec
  use asperity_generation_values, only: generation_spec, map_spec
  ! The original program and its report.
  use asperity_card_deck, only: card_deck, notes_of_deck, read_card_deck
  use asperity_original, only: arithmetic_names, run_in_arithmetic
  use asperity_original_records, only: original_records, original_request, thesis_tables
  use asperity_report, only: write_report
  ! Running scenes.
  use asperity_run_options, only: check_options, run_options
  use asperity_scene_inputs, only: input_file, keep_checksums, list_inputs
  use asperity_solve, only: solve
  use asperity_surface_fields, only: check_field_request
  use asperity_version, only: version
  ! Results.
  use asperity_contact_records, only: contact_row, effect_record, position_result, state_row
  use asperity_effect_header, only: effect_header
  use asperity_scene_results, only: last_state, scene_results
  ! Pressure and gap on the pixels of a map, and the stress below them.
  use asperity_contact_field, only: contact_field, fields_all, fields_last, fields_none, &
                                    pressure_histogram
  use asperity_map_stress, only: component_names, largest_shear, stress_below, von_mises
  ! Results as tables of arrays, and in words.
  use asperity_result_table, only: add_reals, add_surface, add_wholes, array_column, &
                                   array_table, make_arrays, name_units, of_contacts, &
                                   of_positions, of_states, place_of
  use asperity_summary, only: write_summary
  use asperity_text_buffer, only: text_buffer
  ! Warnings outside a theory, and values that are not computed.
  use asperity_kinds, only: not_computed
  use asperity_scene_results, only: kinds_of_warnings
  use asperity_theory_warnings, only: theory_warning, warning_kind, warning_kinds
  use asperity_warning_lines, only: list_warnings
  implicit none
  public

end module asperity
