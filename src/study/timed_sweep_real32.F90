!> Rows of the accuracy study in real32.
module asperity_timed_sweep_real32
  use asperity_contact_records, only: scene_results, solve_method
  use asperity_kernel_real32, only: place_scene, placed_scene, solve_position
  use asperity_kinds, only: int64, real64
  use asperity_scene_values, only: scene
  use asperity_timing, only: timing_samples
#include "timed_sweep.inc"
end module asperity_timed_sweep_real32
