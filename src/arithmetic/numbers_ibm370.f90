!> Functions of System/370 short arithmetic under the names of the IEEE kinds.
module asperity_numbers_ibm370
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_hex32, only: cut_to_integer => hex32_to_integer, from_real64 => hex32_from_real64, &
                            hex32, hex32_from_decimal, hex32_from_word, hex32_word, &
                            three_halves_power, to_real64 => hex32_to_real64, &
                            whole_number => hex32_from_integer
  use asperity_kinds, only: int32, real64
  implicit none
  private

  public :: decimal_number, whole_number, from_real64, to_real64, cut_to_integer
  public :: three_halves_power, cube_root, times_power_of_16, exponent_of_16, upper_half

  ! A machine word: sign, 7 bits of characteristic (exponent + 64), 24 bits of fraction.
  integer, parameter :: fraction_bits = 24, characteristic_bits = 7, bias = 64

contains

  !> An exact decimal cut to 24 bits, as the compiler and the card reader of the machine did.
  elemental function decimal_number(value) result(number)
    type(decimal_value), intent(in) :: value  !! exact decimal number
    type(hex32) :: number                     !! largest number not above it in magnitude

    if (value%twos /= 0) then
      number = from_real64(decimal_to_real64(value))
    else
      number = hex32_from_decimal(value%all_digits, value%power_of_ten)
    end if
  end function decimal_number

  !> number * 16**power; zero or the largest number where the exponent leaves its range.
  elemental function times_power_of_16(number, power) result(scaled)
    type(hex32), intent(in) :: number  !! number of any size
    integer, intent(in) :: power       !! power of 16, any integer
    type(hex32) :: scaled              !! number * 16**power
    integer :: scaled_power

    scaled = number
    scaled_power = exponent_of_16(number) + power
    if (ibits(hex32_word(number), 0, fraction_bits) == 0) return
    if (scaled_power < -bias) then
      scaled = hex32_from_word(0_int32)
    else
      scaled_power = min(scaled_power, bias - 1)
      scaled = hex32_from_word(ior(iand(hex32_word(number), not(characteristic_mask())), &
                                   ishft(int(scaled_power + bias, int32), fraction_bits)))
    end if
  end function times_power_of_16

  !> The least n with |number| < 16**n; 0 for zero.
  elemental integer function exponent_of_16(number)
    type(hex32), intent(in) :: number  !! number of any size

    exponent_of_16 = 0
    if (ibits(hex32_word(number), 0, fraction_bits) == 0) return
    exponent_of_16 = ibits(hex32_word(number), fraction_bits, characteristic_bits) - bias
  end function exponent_of_16

  !> The number cut to half its digits: products with it and with the remainder are exact.
  elemental function upper_half(number) result(upper)
    type(hex32), intent(in) :: number  !! number of any size
    type(hex32) :: upper               !! the number with the lower half of its fraction zero

    upper = hex32_from_word(iand(hex32_word(number), not(maskr(fraction_bits / 2, int32))))
  end function upper_half

  !> The cube root, for number >= 0, cut to 24 bits. The original has no cube root.
  elemental function cube_root(number) result(root)
    type(hex32), intent(in) :: number  !! number, 0 or more
    type(hex32) :: root                !! its cube root

    root = from_real64(to_real64(number)**(1.0_real64 / 3.0_real64))
  end function cube_root

  elemental integer(int32) function characteristic_mask()
    characteristic_mask = ishft(maskr(characteristic_bits, int32), fraction_bits)
  end function characteristic_mask

end module asperity_numbers_ibm370
