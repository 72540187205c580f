#define NUMBER real(real32)
!> Brackets of roots in IEEE arithmetic of kind real32.
module asperity_root_bracket_real32
  use asperity_kinds, only: real32
  use asperity_numbers_real32, only: whole_number
#include "../numerics/root_bracket.inc"
end module asperity_root_bracket_real32
