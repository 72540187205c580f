!> Sum, product, quotient and order of short hexadecimal numbers, and their normalised form.
!>
!> Every operation uses integers only, so that the bits of the result do not depend on compiler,
!> flags and processor.
!>
!> Exceptions set no flag and do not end the program. Their results are the standard corrections of
!> the FORTRAN library of the period after the interrupt: exponent overflow gives the largest
!> magnitude with the sign of the result; exponent underflow gives true zero; x/0 gives the largest
!> magnitude with the sign of x, and 0/0 gives zero.
!>
!> Source: the machine's rules for short floating point (normalised add, subtract, multiply,
!> divide, compare), that is, one guard digit and no rounding anywhere.
module asperity_hex32_arithmetic
  use asperity_kinds, only: int32, int64
  implicit none
  private

  public :: hex32
  public :: operator(+), operator(-), operator(*), operator(/)
  public :: operator(<), operator(<=), operator(>), operator(>=), operator(==), operator(/=)
  public :: hex32_from_binary, hex32_huge, hex32_tiny
  public :: fraction_digits, exponent_bias, int64_bits

  !> Hex digits in a fraction.
  integer, parameter :: fraction_digits = 6
  integer(int32), parameter :: exponent_max = 63_int32
  integer(int32), parameter :: exponent_min = -64_int32
  !> The characteristic in a machine word is the exponent plus this.
  integer(int32), parameter :: exponent_bias = 64_int32
  integer(int32), parameter :: fraction_max = 16_int32**fraction_digits - 1_int32
  integer(int32), parameter :: fraction_min = 16_int32**(fraction_digits - 1)

  integer, parameter :: int64_bits = bit_size(0_int64)  !! bits of a long integer

  !> A short hexadecimal number, fraction/2**24 * 16**exponent. It starts as zero.
  !>
  !> The magnitude of the fraction is 0 or in [2**20, 2**24), the exponent in [-64, 63].
  !> Zero is only (0, 0), so equal numbers have equal components.
  !> Only the files `hex32*` use the components; all others convert.
  type :: hex32
    integer(int32) :: mantissa = 0_int32  !! signed, in units of 2**(-24)
    integer(int32) :: power = 0_int32     !! power of 16, the exponent
  end type hex32

  !> Sum, or the number itself. The smaller number is shifted right by whole hex digits with one
  !> guard digit; the sum is normalised with it, and lower digits are dropped.
  interface operator(+)
    module procedure add
    module procedure same_number
  end interface operator(+)

  !> Difference, by the rule of the sum, or the negative.
  interface operator(-)
    module procedure subtract
    module procedure opposite_of
  end interface operator(-)

  !> Product: exact, then cut to 24 bits.
  interface operator(*)
    module procedure cut_product
  end interface operator(*)

  !> Quotient: exact, then cut to 24 bits.
  interface operator(/)
    module procedure divide
  end interface operator(/)

  !> Exact order. With one guard digit the sign of every difference of normalised numbers is
  !> correct, so that the comparison of the machine, by subtraction, gives the same.
  interface operator(<)
    module procedure is_less
  end interface operator(<)

  !> Exact order, see `<`.
  interface operator(<=)
    module procedure is_less_or_equal
  end interface operator(<=)

  !> Exact order, see `<`.
  interface operator(>)
    module procedure is_greater
  end interface operator(>)

  !> Exact order, see `<`.
  interface operator(>=)
    module procedure is_greater_or_equal
  end interface operator(>=)

  !> Same number.
  interface operator(==)
    module procedure is_equal
  end interface operator(==)

  !> Different numbers.
  interface operator(/=)
    module procedure is_not_equal
  end interface operator(/=)

contains
  elemental type(hex32) function add(x, y) result(total)
    type(hex32), intent(in) :: x, y
    integer(int32) :: large, small, places, signed_sum
    integer(int32) :: power
    logical :: x_leads

    if (x%mantissa == 0_int32) then
      total = y
    else if (y%mantissa == 0_int32) then
      total = x
    else
      x_leads = x%power >= y%power
      ! One place further left than the fraction stands the guard digit.
      large = 16_int32*merge(x%mantissa, y%mantissa, x_leads)
      small = 16_int32*merge(y%mantissa, x%mantissa, x_leads)
      power = max(x%power, y%power)
      ! A shift by seven places or more leaves 0.
      places = min(abs(x%power - y%power), fraction_digits + 1)
      ! Magnitudes are shifted, as a shift of the signed number would round downwards.
      signed_sum = large + sign(shiftr(abs(small), 4*places), small)
      total = cut_number(signed_sum < 0_int32, int(abs(signed_sum), int64), &
                         power - int(fraction_digits + 1, int32))
    end if
  end function add

  elemental type(hex32) function same_number(x) result(same)
    type(hex32), intent(in) :: x

    same = x
  end function same_number

  elemental type(hex32) function subtract(x, y) result(difference)
    type(hex32), intent(in) :: x, y

    difference = add(x, opposite_of(y))
  end function subtract

  elemental type(hex32) function opposite_of(x) result(opposite)
    type(hex32), intent(in) :: x

    opposite = hex32(-x%mantissa, x%power)
  end function opposite_of

  elemental type(hex32) function cut_product(x, y) result(xy)
    type(hex32), intent(in) :: x, y

    xy = cut_number((x%mantissa < 0_int32) .neqv. (y%mantissa < 0_int32), &
                    int(abs(x%mantissa), int64)*int(abs(y%mantissa), int64), &
                    x%power + y%power - int(2*fraction_digits, int32))
  end function cut_product

  elemental type(hex32) function divide(x, y) result(quotient)
    type(hex32), intent(in) :: x, y
    integer(int64) :: dividend

    if (x%mantissa == 0_int32) then
      quotient = x
    else if (y%mantissa == 0_int32) then
      quotient = largest_number(x%mantissa < 0_int32)
    else
      ! Six digits more in the dividend give a quotient of six or seven digits.
      dividend = shiftl(int(abs(x%mantissa), int64), 4*fraction_digits)
      quotient = cut_number((x%mantissa < 0_int32) .neqv. (y%mantissa < 0_int32), &
                            dividend/int(abs(y%mantissa), int64), &
                            x%power - y%power - int(fraction_digits, int32))
    end if
  end function divide

  elemental logical function is_less(x, y) result(holds)
    type(hex32), intent(in) :: x, y

    holds = rank_of(x) < rank_of(y)
  end function is_less

  elemental logical function is_less_or_equal(x, y) result(holds)
    type(hex32), intent(in) :: x, y

    holds = rank_of(x) <= rank_of(y)
  end function is_less_or_equal

  elemental logical function is_greater(x, y) result(holds)
    type(hex32), intent(in) :: x, y

    holds = rank_of(x) > rank_of(y)
  end function is_greater

  elemental logical function is_greater_or_equal(x, y) result(holds)
    type(hex32), intent(in) :: x, y

    holds = rank_of(x) >= rank_of(y)
  end function is_greater_or_equal

  elemental logical function is_equal(x, y) result(holds)
    type(hex32), intent(in) :: x, y

    holds = x%mantissa == y%mantissa .and. x%power == y%power
  end function is_equal

  elemental logical function is_not_equal(x, y) result(holds)
    type(hex32), intent(in) :: x, y

    holds = x%mantissa /= y%mantissa .or. x%power /= y%power
  end function is_not_equal

  !> digits * 2**exponent2, cut to 24 bits.
  elemental type(hex32) function hex32_from_binary(factor, exponent2) result(x)
    !> any integer, with its sign
    integer(int64), intent(in) :: factor
    !> power of two; any within +-10**9, a number out of range overflows or underflows
    integer, intent(in) :: exponent2
    integer(int64) :: magnitude
    integer :: power

    magnitude = factor
    power = exponent2
    ! Room for the sign of the most negative integer and for three more bits.
    if (leadz(ieor(factor, shifta(factor, int64_bits - 1))) < 5) then
      magnitude = magnitude/16_int64
      power = power + 4
    end if
    ! Whole powers of 16 are added to the exponent, the other powers of 2 to the digits.
    x = cut_number(factor < 0_int64, shiftl(abs(magnitude), iand(power, 3)), &
                   int(shifta(power, 2), int32))
  end function hex32_from_binary

  !> The largest number, (1 - 2**(-24)) * 16**63, about 7.2e75.
  pure type(hex32) function hex32_huge() result(x)

    x = largest_number(.false.)
  end function hex32_huge

  !> The smallest number above zero, 16**(-65), about 5.4e-79.
  pure type(hex32) function hex32_tiny() result(x)

    x = hex32(fraction_min, exponent_min)
  end function hex32_tiny

  !> The largest magnitude with a sign.
  elemental type(hex32) function largest_number(below_zero) result(x)
    logical, intent(in) :: below_zero

    x = hex32(merge(-fraction_max, fraction_max, below_zero), exponent_max)
  end function largest_number

  !> The number magnitude * 16**power, normalised and cut to 24 bits, with over- and underflow.
  elemental type(hex32) function cut_number(below_zero, magnitude, power) result(x)
    logical, intent(in) :: below_zero
    !> not negative
    integer(int64), intent(in) :: magnitude
    integer(int32), intent(in) :: power
    integer(int32) :: mantissa, final_power
    integer :: places

    places = (int64_bits - leadz(magnitude) + 3)/4
    final_power = power + int(places, int32)
    if (places > fraction_digits) then
      mantissa = int(shiftr(magnitude, 4*(places - fraction_digits)), int32)
    else
      mantissa = int(shiftl(magnitude, 4*(fraction_digits - places)), int32)
    end if
    if (mantissa == 0_int32 .or. final_power < exponent_min) then
      x = hex32(0_int32, 0_int32)
    else if (final_power > exponent_max) then
      x = largest_number(below_zero)
    else
      x = hex32(merge(-mantissa, mantissa, below_zero), final_power)
    end if
  end function cut_number

  !> An integer with the same order as the numbers.
  elemental function rank_of(x) result(rank)
    type(hex32), intent(in) :: x
    integer(int32) :: rank

    rank = 0_int32
    if (x%mantissa /= 0_int32) then
      rank = sign(ior(shiftl(x%power + exponent_bias, 24), abs(x%mantissa)), x%mantissa)
    end if
  end function rank_of

end module asperity_hex32_arithmetic
