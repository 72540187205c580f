!> The names of other modules that the kernel of each arithmetic uses.
module asperity_kernel_parts
  use asperity_cell_reach, only: margin_of_arithmetic, squared_reach
  use asperity_contact_records, only: add_rows, prescribed_normal, prescribed_vertical, by_events, &
                                      by_marching, contact_row, cut_rows, most_rows, &
                                      overlap_stable, position_result, solve_method, state_row
  use asperity_contact_pairs, only: contact_pairs, least_exponent
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int32, int64, real64
  use asperity_overlapping_circles, only: count_overlapping
  use asperity_pair_search_blocks, only: found_pairs
  use asperity_pair_search_levels, only: build_levels, last_level, pair_levels, search_level, &
                                         surface_points
  use asperity_pair_search_row, only: build_row, first_from, summit_row
  use asperity_position_solver, only: position_solver
  use asperity_problems, only: decimal_text, not_enough_memory, real_text
  use asperity_process, only: has_memory
  use asperity_scene_values, only: control_compression, control_limit, control_load, &
                                   control_pressure, control_separation, control_words, &
                                   criterion_greenwood_williamson, criterion_hardy, &
                                   criterion_load, criterion_none, criterion_pressure, is_load, &
                                   is_vertical_load, scene, scene_limit, scene_surface
  use asperity_theory_limits, only: look_at_contact, look_at_state, seen_contact, &
                                    set_theory_limits, theory_limits
  use asperity_theory_warnings, only: take_worse, theory_warning
  implicit none
end module asperity_kernel_parts
