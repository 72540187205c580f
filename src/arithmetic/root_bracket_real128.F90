#define NUMBER real(real128)
!> Brackets of roots in IEEE arithmetic of kind real128.
module asperity_root_bracket_real128
  use asperity_kinds, only: real128
  use asperity_numbers_real128, only: whole_number
#include "../numerics/root_bracket.inc"
end module asperity_root_bracket_real128
