#define NUMBER type(hex32)
!> All asperities compared with all, in System/370 short floating point.
module asperity_compare_all_ibm370
  use asperity_all_pairs, only: all_pairs
  use asperity_decimal, only: decimal_value
  use asperity_hex32, only: hex32, operator(*), operator(+), operator(-), operator(/), &
                            operator(<=), operator(>), operator(>=), sqrt
  use asperity_kernel_ibm370, only: touching_height
  use asperity_kinds, only: real64
  use asperity_numbers_ibm370, only: decimal_number, from_real64, times_power_of_16, to_real64, &
                                     whole_number
  use asperity_scene_values, only: scene
#include "compare_all.inc"
end module asperity_compare_all_ibm370
