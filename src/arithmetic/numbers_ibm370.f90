!> Functions of System/370 short arithmetic under the names of the IEEE kinds.
module asperity_numbers_ibm370
  use asperity_decimal, only: decimal_value
  use asperity_hex32, only: cut_to_integer => hex32_to_integer, from_real64 => hex32_from_real64, &
                            hex32, hex32_from_decimal, &
                            three_halves_power, to_real64 => hex32_to_real64, &
                            whole_number => hex32_from_integer
  implicit none
  private

  public :: decimal_number, whole_number, from_real64, to_real64, cut_to_integer
  public :: three_halves_power

contains

  !> An exact decimal cut to 24 bits, as the compiler and the card reader of the machine did.
  elemental function decimal_number(value) result(number)
    type(decimal_value), intent(in) :: value  !! exact decimal number
    type(hex32) :: number                     !! largest number not above it in magnitude

    number = hex32_from_decimal(value%all_digits, value%power_of_ten)
  end function decimal_number

end module asperity_numbers_ibm370
