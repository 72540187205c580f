!> Exact decimal numbers and doubles, which each arithmetic converts by its own rounding.
module asperity_decimal
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
  use asperity_kinds, only: int64, real128, real64
  implicit none
  private

  public :: decimal_value, decimal_to_real64, decimal_numeral, decimal_order, decimal_beyond

  !> The number digits * 10**exponent.
  type :: decimal_value
    integer(int64) :: all_digits = 0_int64  !! all digits, with the sign
    integer :: power_of_ten = 0         !! power of ten
  end type decimal_value

  ! Range of powers of ten that are exact in 113 bits and for which the quotient below is correctly
  ! rounded.
  integer, parameter :: most_negative_power = -25, most_positive_power = 22
  integer :: power
  real(real128), parameter :: powers(0:-most_negative_power) = &
    [(10.0_real128**power, power = 0, -most_negative_power)]
  ! Powers that are exact in a double, and their halves, whose products are exact.
  integer, parameter :: most_exact_power = 22
  real(real64), parameter :: exact_powers(0:most_exact_power) = &
    real(powers(:most_exact_power), real64)
  real(real64), parameter :: two_27 = 2.0_real64**27 + 1.0_real64
  real(real64), parameter :: upper_powers(0:most_exact_power) = &
    two_27 * exact_powers - (two_27 * exact_powers - exact_powers)
  real(real64), parameter :: lower_powers(0:most_exact_power) = exact_powers - upper_powers

contains

  !> Nearest IEEE double; infinite when the number is out of range.
  !>
  !> The digits (60 bits) and the power of ten are exact in 113 bits. A product below 60 + 51 bits
  !> is exact too. A quotient that is no midpoint of two doubles is at least 1/(2**54 * 5**25),
  !> more than 2**-113, of itself away from one, so that double rounding is correct.
  elemental function decimal_to_real64(value) result(number)
    type(decimal_value), intent(in) :: value  !! exact decimal number
    real(real64) :: number                    !! the nearest double
    character(len=40) :: numeral

    if (value%power_of_ten <= 0 .and. value%power_of_ten >= -most_exact_power) then
      number = quotient_in_doubles(value%all_digits, -value%power_of_ten)
    else if (value%power_of_ten >= 0 .and. value%power_of_ten <= most_positive_power) then
      number = real(real(value%all_digits, real128) * powers(value%power_of_ten), real64)
    else if (value%power_of_ten < 0 .and. value%power_of_ten >= most_negative_power) then
      number = real(real(value%all_digits, real128) / powers(-value%power_of_ten), real64)
    else if (decimal_beyond(value, real(huge(number), real128))) then
      number = sign(ieee_value(number, ieee_positive_inf), real(value%all_digits, real64))
    else if (decimal_order(value) < -(range(number) + 40)) then
      number = 0.0_real64
    else
      numeral = decimal_numeral(value)
      ! The library's own conversion is correctly rounded; a product with a power of ten is not.
      read (numeral, '(f40.0)') number
    end if
  end function decimal_to_real64

  ! The double nearest to numerator / 10**power, without numbers of 113 bits: several times as fast.
  !
  ! The numerator is high + low exactly. The remainder of a quotient q of doubles, high - q
  ! 10**power, is a double and is computed by Dekker's product (1971). Its sum with low is a whole
  ! number, in units of a power of two, of at most 1.5 * 5**22, and so is exact. Divided by
  ! 10**power it is the correction of q, with a relative rounding below 2**-53: halves of a unit of
  ! the last place of q are exact, and all other corrections differ from them by at least 1/(3 *
  ! 5**22), which is more.
  elemental function quotient_in_doubles(numerator, power) result(quotient)
    integer(int64), intent(in) :: numerator  ! less than 2**62
    integer, intent(in) :: power          ! from 0 to 22
    real(real64) :: quotient
    real(real64) :: high, low, q, upper, lower, multiple, rest

    high = real(numerator, real64)
    low = real(numerator - int(high, int64), real64)
    q = high / exact_powers(power)
    multiple = q * exact_powers(power)
    upper = two_27 * q - (two_27 * q - q)
    lower = q - upper
    rest = (((upper * upper_powers(power) - multiple) + upper * lower_powers(power)) + &
            lower * upper_powers(power)) + lower * lower_powers(power)
    quotient = q + (((high - multiple) - rest) + low) / exact_powers(power)
  end function quotient_in_doubles

  !> The least n with |value| < 10**n; a very negative number for zero.
  elemental integer function decimal_order(value)
    type(decimal_value), intent(in) :: value  !! exact decimal number
    integer(int64) :: rest

    decimal_order = value%power_of_ten
    rest = abs(value%all_digits)
    if (rest == 0_int64) decimal_order = -huge(decimal_order)
    do while (rest > 0_int64)
      rest = rest / 10_int64
      decimal_order = decimal_order + 1
    end do
  end function decimal_order

  !> Whether |value| is above `largest`, the largest number of some kind, to 18 digits. A read has
  !> the same result, but raises an overflow.
  elemental logical function decimal_beyond(value, largest)
    type(decimal_value), intent(in) :: value  !! exact decimal number
    real(real128), intent(in) :: largest      !! largest number, > 1
    real(real128) :: leading
    integer :: order

    decimal_beyond = .false.
    ! The largest number of each kind is above 1E38.
    if (decimal_order(value) < 38) return
    order = ceiling(log10(largest))
    decimal_beyond = decimal_order(value) > order
    if (decimal_order(value) /= order) return
    leading = abs(real(value%all_digits, real128)) * 10.0_real128**(value%power_of_ten - order + 18)
    decimal_beyond = leading > largest / 10.0_real128**(order - 18)
  end function decimal_beyond

  !> The number as 40 characters that every `F40.0` field reads.
  pure function decimal_numeral(value) result(numeral)
    type(decimal_value), intent(in) :: value  !! exact decimal number
    character(len=40) :: numeral              !! for instance `254E-2`

    write (numeral, '(i0, "E", i0)') value%all_digits, value%power_of_ten
    numeral = adjustr(numeral)
  end function decimal_numeral

end module asperity_decimal
