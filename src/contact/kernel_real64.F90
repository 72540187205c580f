#define NUMBER real(real64)
#define ITEM type(candidate)
!> The present-day solver's kernel in IEEE arithmetic of kind real64.
module asperity_kernel_real64
  use asperity_kernel_parts
  use asperity_numbers_real64, only: cube_root, decimal_number, exponent_of_16, from_real64, &
                                     times_power_of_16, to_real64, upper_half, whole_number
  use asperity_root_bracket, only: guess_root, narrow_bracket, root_bracket
#include "kernel.inc"
end module asperity_kernel_real64
