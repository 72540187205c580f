#define NUMBER type(hex32)
!> Brackets of roots in System/370 short floating point.
module asperity_root_bracket_ibm370
  use asperity_hex32, only: hex32, operator(*), operator(+), operator(-), operator(/), &
                            operator(<), operator(>), sqrt
  use asperity_numbers_ibm370, only: whole_number
#include "../numerics/root_bracket.inc"
end module asperity_root_bracket_ibm370
