#define NUMBER real(real32)
#define ITEM type(candidate)
!> The present-day solver's kernel in IEEE arithmetic of kind real32.
module asperity_kernel_real32
  use asperity_kinds, only: real32
  use asperity_kernel_parts
  use asperity_numbers_real32, only: cube_root, decimal_number, exponent_of_16, from_real64, &
                                     times_power_of_16, to_real64, upper_half, whole_number
  use asperity_root_bracket_real32, only: guess_root, narrow_bracket, root_bracket
#include "kernel.inc"
end module asperity_kernel_real32
