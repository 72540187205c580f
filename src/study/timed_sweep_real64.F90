!> Rows of the accuracy study in real64.
module asperity_timed_sweep_real64
  use asperity_contact_records, only: scene_results, solve_method
  use asperity_kernel_real64, only: place_scene, placed_scene, solve_position
  use asperity_kinds, only: int64, real64
  use asperity_scene_values, only: scene
  use asperity_timing, only: timing_samples
#include "timed_sweep.inc"
end module asperity_timed_sweep_real64
