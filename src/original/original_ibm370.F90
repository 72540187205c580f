#define NUMBER type(hex32)
!> The original program in System/370 short floating point.
module asperity_original_ibm370
  use asperity_card_deck, only: card_deck, model_cards
  use asperity_decimal, only: decimal_value
  use asperity_hex32, only: cos, hex32, operator(*), operator(+), operator(-), operator(/), &
                            operator(<), operator(>), operator(>=), sin, sqrt
  use asperity_kinds, only: int64, real64
  use asperity_numbers_ibm370, only: cut_to_integer, decimal_number, &
                            three_halves_power, to_real64, whole_number
  use asperity_original_records, only: append_contact, approach_row, contact_record, &
                                       individual_difference_row, model_record, &
                                       original_positions, original_records, &
                                       original_request, points_row, position_record, &
                                       slope_row, total_area_row, total_difference_row, &
                                       total_load_row
  use asperity_problems, only: decimal_text
  use asperity_sections, only:
#include "sections.F90"
end module asperity_original_ibm370
