#define NUMBER real(real64)
!> All asperities compared with all, in doubles.
module asperity_compare_all_real64
  use asperity_all_pairs, only: all_pairs
  use asperity_decimal, only: decimal_value
  use asperity_kernel_real64, only: touching_height
  use asperity_kinds, only: real64
  use asperity_numbers_real64, only: decimal_number, from_real64, times_power_of_16, to_real64, &
                                     whole_number
  use asperity_scene_values, only: scene
#include "compare_all.inc"
end module asperity_compare_all_real64
