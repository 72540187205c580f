!> Short hexadecimal numbers from and to integers, decimals, doubles and machine words.
!>
!> Digits that do not fit are cut, as in all operations of this arithmetic; no conversion rounds.
module asperity_hex32_conversions
  use asperity_hex32_arithmetic, only: exponent_bias, fraction_digits, hex32, hex32_from_binary, &
                                       hex32_huge, operator(-)
  use asperity_kinds, only: int32, int64, real64
  implicit none
  private

  public :: hex32_from_integer, hex32_from_decimal, hex32_from_real64, hex32_from_word
  public :: hex32_to_integer, hex32_to_real64, hex32_word
  public :: limb_bits, limb_mask

  !> Long integers are held as limbs of this many bits, so that a product of two fits in int64.
  integer, parameter :: limb_bits = 30
  integer(int64), parameter :: limb_mask = 2_int64**limb_bits - 1_int64  !! the bits of a limb

contains

  !> A whole number, exact up to 24 bits and cut beyond.
  elemental type(hex32) function hex32_from_integer(i) result(x)
    !> any whole number
    integer, intent(in) :: i

    x = hex32_from_binary(int(i, int64), 0)
  end function hex32_from_integer

  !> numerator * 10**exponent10, cut to 24 bits from the exact value: the conversion of the compiler
  !> and the FORMAT routines of the time.
  elemental type(hex32) function hex32_from_decimal(numerator, exponent10) result(x)
    !> the decimal number without its point, with its sign
    integer(int64), intent(in) :: numerator
    !> power of ten; any, a number out of range overflows or underflows
    integer, intent(in) :: exponent10
    ! 10**120 has 399 bits, the numerator 64; a quotient needs 16 limbs below its unit.
    integer, parameter :: limbs = 20
    integer, parameter :: power_limit = 120
    integer(int64) :: limb(0:limbs - 1), rest, factor
    integer :: first, top, left, step, i

    if (numerator == 0_int64) then
      x = hex32()
    else if (exponent10 > power_limit) then
      x = merge(-hex32_huge(), hex32_huge(), numerator < 0_int64)
    else if (exponent10 < -power_limit) then
      x = hex32()
    else
      ! A divided number is first moved up by enough limbs to leave more than 24 bits below.
      first = 0
      if (exponent10 < 0) first = (-10*exponent10/3)/limb_bits + 2
      limb(:) = 0_int64
      ! The magnitude of the most negative integer exceeds an int64; that less one does not.
      rest = merge(not(numerator), numerator - 1_int64, numerator < 0_int64)
      limb(first) = iand(rest, limb_mask) + 1_int64
      limb(first + 1) = iand(shiftr(rest, limb_bits), limb_mask)
      limb(first + 2) = shiftr(rest, 2*limb_bits)
      top = first + 2
      left = abs(exponent10)
      do
        step = min(left, 9)
        factor = 10_int64**step
        rest = 0_int64
        if (exponent10 < 0) then
          ! Cutting after each part gives the same as cutting once.
          do i = top, 0, -1
            rest = shiftl(rest, limb_bits) + limb(i)
            limb(i) = rest/factor
            rest = rest - limb(i)*factor
          end do
        else
          do i = 0, top
            rest = limb(i)*factor + rest
            limb(i) = iand(rest, limb_mask)
            rest = shiftr(rest, limb_bits)
          end do
          top = top + 1
          limb(top) = rest
        end if
        left = left - step
        if (left == 0) exit
      end do
      do while (limb(top) == 0_int64)
        top = top - 1
      end do
      ! Two limbs hold at least 31 bits of the number; lower ones do not affect the first 24.
      if (top == 0) then
        x = hex32_from_binary(limb(0), -limb_bits*first)
      else
        x = hex32_from_binary(shiftl(limb(top), limb_bits) + limb(top - 1), &
                              limb_bits*(top - 1 - first))
      end if
      if (numerator < 0_int64) x = -x
    end if
  end function hex32_from_decimal

  !> A double-precision number, cut to 24 bits. Infinity gives the largest magnitude, a NaN zero.
  elemental type(hex32) function hex32_from_real64(value) result(x)
    !> any double-precision number
    real(real64), intent(in) :: value
    integer, parameter :: mantissa_bits = 52, exponent_bits = 11, bias = 1023
    integer(int64) :: bits, mantissa
    integer :: exponent2

    ! By its bits, so that no compiler flag may reorder it and no exception is raised.
    bits = transfer(value, bits)
    mantissa = ibits(bits, 0, mantissa_bits)
    exponent2 = int(ibits(bits, mantissa_bits, exponent_bits))
    if (exponent2 == 2*bias + 1) then
      x = hex32()
      if (mantissa == 0_int64) x = merge(-hex32_huge(), hex32_huge(), bits < 0_int64)
    else if (exponent2 == 0) then
      x = hex32()
    else
      x = hex32_from_binary(ibset(mantissa, mantissa_bits), exponent2 - bias - mantissa_bits)
      if (bits < 0_int64) x = -x
    end if
  end function hex32_from_real64

  !> The number whose machine word this is; an unnormalised one is normalised first.
  elemental type(hex32) function hex32_from_word(word) result(x)
    !> sign, excess-64 exponent in 7 bits, fraction in 24 bits
    integer(int32), intent(in) :: word

    x = hex32_from_binary(int(ibits(word, 0, 24), int64), &
                          4*(int(ibits(word, 24, 7) - exponent_bias) - fraction_digits))
    if (word < 0_int32) x = -x
  end function hex32_from_word

  !> The whole part, cut towards zero; beyond the range the largest integer with the sign.
  elemental integer function hex32_to_integer(x) result(i)
    !> any number
    type(hex32), intent(in) :: x
    integer(int64) :: magnitude

    magnitude = int(abs(x%mantissa), int64)
    if (x%power <= 0_int32) then
      magnitude = 0_int64
    else if (x%power <= fraction_digits) then
      magnitude = shiftr(magnitude, 4*(fraction_digits - x%power))
    else
      ! Fifteen digits fit in int64 and are more than a default integer has.
      magnitude = shiftl(magnitude, 4*(min(x%power, 15_int32) - fraction_digits))
    end if
    i = int(min(magnitude, int(huge(i), int64)))
    if (x%mantissa < 0_int32) i = -i
  end function hex32_to_integer

  !> The number in double precision, exactly.
  elemental real(real64) function hex32_to_real64(x) result(value)
    !> any number
    type(hex32), intent(in) :: x

    value = scale(real(x%mantissa, real64), 4*(x%power - fraction_digits))
  end function hex32_to_real64

  !> The machine's word: sign, excess-64 exponent in 7 bits, fraction in 24 bits. Zero is 0.
  elemental function hex32_word(x) result(word)
    !> any number
    type(hex32), intent(in) :: x
    integer(int32) :: word

    word = 0_int32
    if (x%mantissa /= 0_int32) then
      word = ior(shiftl(x%power + exponent_bias, 24), abs(x%mantissa))
      if (x%mantissa < 0_int32) word = ibset(word, 31)
    end if
  end function hex32_word

end module asperity_hex32_conversions
