#define NUMBER real(real64)
!> Brackets of roots in IEEE arithmetic of kind real64.
module asperity_root_bracket_real64
  use asperity_kinds, only: real64
  use asperity_numbers_real64, only: whole_number
#include "../numerics/root_bracket.inc"
end module asperity_root_bracket_real64
