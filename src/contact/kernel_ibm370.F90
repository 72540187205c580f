#define NUMBER type(hex32)
#define ITEM type(candidate)
!> The present-day solver's kernel in System/370 short floating point.
module asperity_kernel_ibm370
  use asperity_hex32, only: cos, hex32, operator(*), operator(+), operator(-), operator(/), &
                            operator(<), operator(<=), operator(>), operator(>=), sin, sqrt
  use asperity_kernel_parts
  use asperity_numbers_ibm370, only: cube_root, decimal_number, exponent_of_16, from_real64, &
                                     times_power_of_16, to_real64, upper_half, whole_number
  use asperity_root_bracket_ibm370, only: guess_root, narrow_bracket, root_bracket
#include "kernel.inc"
end module asperity_kernel_ibm370
