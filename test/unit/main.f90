!> Runs every suite of unit tests.
program unit_tests
  use, intrinsic :: ieee_exceptions, only: ieee_divide_by_zero, ieee_invalid, ieee_overflow, &
                                           ieee_set_halting_mode
  use asperity_testing, only: finish, run_suite
  use asperity_adhesion_suite, only: run_adhesion
  use asperity_elements_suite, only: run_elements
  use asperity_circles_suite, only: run_circles
  use asperity_bracket_suite, only: run_brackets
  use asperity_coupled_suite, only: run_coupled
  use asperity_creep_suite, only: run_creep
  use asperity_friction_suite, only: run_friction
  use asperity_generation_suite, only: run_generation
  use asperity_joint_suite, only: run_joint
  use asperity_map_suite, only: run_maps
  use asperity_mutual_suite, only: run_mutual
  use asperity_new_effect_suite, only: run_new_effect
  use asperity_plasticity_suite, only: run_plasticity
  use asperity_potential_suite, only: run_potential
  use asperity_pair_search_suite, only: run_pair_search
  use asperity_study_suite, only: run_study
  use asperity_summation_suite, only: run_summation
  use asperity_traction_suite, only: run_tractions
  use asperity_cards_suite, only: run_cards
  use asperity_hex32_suite, only: run_hex32
  use asperity_overlap_suite, only: run_overlap
  use asperity_printable_suite, only: run_printable
  use asperity_report_fields_suite, only: run_report_fields
  use asperity_scene_suite, only: run_scene
  implicit none

  ! An unset number is a signalling NaN in the strict build: its first use ends the run.
  call ieee_set_halting_mode([ieee_divide_by_zero, ieee_invalid, ieee_overflow], .true.)
  call run_suite('hex32', run_hex32)
  call run_suite('overlap', run_overlap)
  call run_suite('cards', run_cards)
  call run_suite('printable text', run_printable)
  call run_suite('report fields', run_report_fields)
  call run_suite('scene', run_scene)
  call run_suite('circles', run_circles)
  call run_suite('brackets of roots', run_brackets)
  call run_suite('elements', run_elements)
  call run_suite('sums over many circles', run_summation)
  call run_suite('circles on each other', run_mutual)
  call run_suite('potential of contacts', run_potential)
  call run_suite('coupled contacts', run_coupled)
  call run_suite('joint contacts', run_joint)
  call run_suite('maps', run_maps)
  call run_suite('tractions', run_tractions)
  call run_suite('friction', run_friction)
  call run_suite('adhesion', run_adhesion)
  call run_suite('creep', run_creep)
  call run_suite('plastic flow', run_plasticity)
  call run_suite('an effect made up', run_new_effect)
  call run_suite('generation', run_generation)
  call run_suite('pair search', run_pair_search)
  call run_suite('accuracy study', run_study)
  call finish()
end program unit_tests
