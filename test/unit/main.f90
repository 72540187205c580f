!> Runs every suite of unit tests.
program unit_tests
  use, intrinsic :: ieee_exceptions, only: ieee_divide_by_zero, ieee_invalid, ieee_overflow, &
                                           ieee_set_halting_mode
  use asperity_testing, only: finish, run_suite, tally_type
  use asperity_adhesion_suite, only: collect_adhesion
  use asperity_elements_suite, only: collect_elements
  use asperity_circles_suite, only: collect_circles
  use asperity_bracket_suite, only: collect_brackets
  use asperity_coupled_suite, only: collect_coupled
  use asperity_creep_suite, only: collect_creep
  use asperity_friction_suite, only: collect_friction
  use asperity_generation_suite, only: collect_generation
  use asperity_joint_suite, only: collect_joint
  use asperity_map_suite, only: collect_maps
  use asperity_mutual_suite, only: collect_mutual
  use asperity_new_effect_suite, only: collect_new_effect
  use asperity_plasticity_suite, only: collect_plasticity
  use asperity_potential_suite, only: collect_potential
  use asperity_pair_search_suite, only: collect_pair_search
  use asperity_study_suite, only: collect_study
  use asperity_summation_suite, only: collect_summation
  use asperity_cards_suite, only: collect_cards
  use asperity_hex32_suite, only: collect_hex32
  use asperity_overlap_suite, only: collect_overlap
  use asperity_printable_suite, only: collect_printable
  use asperity_report_fields_suite, only: collect_report_fields
  use asperity_scene_suite, only: collect_scene
  implicit none

  type(tally_type) :: tally

  ! An unset number is a signalling NaN in the strict build: its first use ends the run.
  call ieee_set_halting_mode([ieee_divide_by_zero, ieee_invalid, ieee_overflow], .true.)
  call run_suite('hex32', collect_hex32, tally)
  call run_suite('overlap', collect_overlap, tally)
  call run_suite('cards', collect_cards, tally)
  call run_suite('printable text', collect_printable, tally)
  call run_suite('report fields', collect_report_fields, tally)
  call run_suite('scene', collect_scene, tally)
  call run_suite('circles', collect_circles, tally)
  call run_suite('brackets of roots', collect_brackets, tally)
  call run_suite('elements', collect_elements, tally)
  call run_suite('sums over many circles', collect_summation, tally)
  call run_suite('circles on each other', collect_mutual, tally)
  call run_suite('potential of contacts', collect_potential, tally)
  call run_suite('coupled contacts', collect_coupled, tally)
  call run_suite('circles and cells', collect_joint, tally)
  call run_suite('maps', collect_maps, tally)
  call run_suite('friction', collect_friction, tally)
  call run_suite('adhesion', collect_adhesion, tally)
  call run_suite('creep', collect_creep, tally)
  call run_suite('plastic flow', collect_plasticity, tally)
  call run_suite('an effect made up', collect_new_effect, tally)
  call run_suite('generation', collect_generation, tally)
  call run_suite('pair search', collect_pair_search, tally)
  call run_suite('representative area', collect_study, tally)
  call finish(tally)
end program unit_tests
