#define KIND real128
!> Functions of IEEE arithmetic in kind real128.
module asperity_numbers_real128
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
  use asperity_decimal, only: decimal_beyond, decimal_numeral, decimal_order, decimal_value
  use asperity_ieee_numbers, only:
  use asperity_kinds, only: real128, real64
#include "ieee_numbers.F90"
end module asperity_numbers_real128
