!> Sum, product, quotient and order of short hexadecimal numbers, and their normalised form.
!>
!> Every operation is integer work, so the same bits come out with every compiler, flag and
!> processor.
!>
!> Exceptions set no flag and stop nothing. They give what the period's FORTRAN library put in as
!> its standard correction after the interrupt:
!> exponent overflow gives the largest magnitude with the sign of the result; exponent underflow
!> gives true zero; x/0 gives the largest magnitude with the sign of x, and 0/0 gives zero.
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

  !> Bits of a long integer.
  integer, parameter :: int64_bits = bit_size(0_int64)

  !> A short hexadecimal number, fraction/2**24 * 16**exponent. It starts as zero.
  !>
  !> The magnitude of the fraction is 0 or in [2**20, 2**24), the exponent in [-64, 63].
  !> Zero is only (0, 0), so equal numbers have equal components.
  !> The components are for the files `hex32*` alone, which keep to this; all others convert.
  type :: hex32
    integer(int32) :: fraction = 0_int32  !! signed, in units of 2**(-24)
    integer(int32) :: exponent = 0_int32  !! of 16
  end type hex32

  !> Sum, or the number itself. The smaller is shifted right by whole hex digits, of which one
  !> guard digit is kept; the sum is normalised with it and the rest dropped.
  interface operator(+)
    module procedure add
    module procedure plus
  end interface operator(+)

  !> Difference, by the rule of the sum, or the negative.
  interface operator(-)
    module procedure subtract
    module procedure negative
  end interface operator(-)

  !> Product: exact, then cut to 24 bits.
  interface operator(*)
    module procedure multiply
  end interface operator(*)

  !> Quotient: exact, then cut to 24 bits.
  interface operator(/)
    module procedure divide
  end interface operator(/)

  !> Exact order. One guard digit keeps the sign of every difference of normalised numbers right,
  !> so the machine's comparison by subtraction gives the same.
  interface operator(<)
    module procedure less
  end interface operator(<)

  !> Exact order, see `<`.
  interface operator(<=)
    module procedure less_or_equal
  end interface operator(<=)

  !> Exact order, see `<`.
  interface operator(>)
    module procedure greater
  end interface operator(>)

  !> Exact order, see `<`.
  interface operator(>=)
    module procedure greater_or_equal
  end interface operator(>=)

  !> Same number.
  interface operator(==)
    module procedure equal
  end interface operator(==)

  !> Different numbers.
  interface operator(/=)
    module procedure not_equal
  end interface operator(/=)

contains
  elemental function add(x, y) result(total)
    type(hex32), intent(in) :: x, y
    type(hex32) :: total
    integer(int32) :: large, small, digits, signed_sum
    integer(int32) :: exponent
    logical :: x_leads

    if (x%fraction == 0_int32) then
      total = y
    else if (y%fraction == 0_int32) then
      total = x
    else
      x_leads = x%exponent >= y%exponent
      ! One place further left than the fraction stands the guard digit.
      large = 16_int32*merge(x%fraction, y%fraction, x_leads)
      small = 16_int32*merge(y%fraction, x%fraction, x_leads)
      exponent = max(x%exponent, y%exponent)
      ! From seven places on nothing is left of it.
      digits = min(abs(x%exponent - y%exponent), fraction_digits + 1)
      ! Magnitudes are shifted: a shift of the signed number would round downwards.
      signed_sum = large + sign(shiftr(abs(small), 4*digits), small)
      total = cut(signed_sum < 0_int32, int(abs(signed_sum), int64), &
                  exponent - int(fraction_digits + 1, int32))
    end if
  end function add

  elemental function plus(x) result(same)
    type(hex32), intent(in) :: x
    type(hex32) :: same

    same = x
  end function plus

  elemental function subtract(x, y) result(difference)
    type(hex32), intent(in) :: x, y
    type(hex32) :: difference

    difference = add(x, negative(y))
  end function subtract

  elemental function negative(x) result(opposite)
    type(hex32), intent(in) :: x
    type(hex32) :: opposite

    opposite = hex32(-x%fraction, x%exponent)
  end function negative

  elemental function multiply(x, y) result(product)
    type(hex32), intent(in) :: x, y
    type(hex32) :: product

    product = cut((x%fraction < 0_int32) .neqv. (y%fraction < 0_int32), &
                  int(abs(x%fraction), int64)*int(abs(y%fraction), int64), &
                  x%exponent + y%exponent - int(2*fraction_digits, int32))
  end function multiply

  elemental function divide(x, y) result(quotient)
    type(hex32), intent(in) :: x, y
    type(hex32) :: quotient
    integer(int64) :: dividend

    if (x%fraction == 0_int32) then
      quotient = x
    else if (y%fraction == 0_int32) then
      quotient = largest(x%fraction < 0_int32)
    else
      ! Six digits more in the dividend give a quotient of six or seven digits.
      dividend = shiftl(int(abs(x%fraction), int64), 4*fraction_digits)
      quotient = cut((x%fraction < 0_int32) .neqv. (y%fraction < 0_int32), &
                     dividend/int(abs(y%fraction), int64), &
                     x%exponent - y%exponent - int(fraction_digits, int32))
    end if
  end function divide

  elemental function less(x, y) result(holds)
    type(hex32), intent(in) :: x, y
    logical :: holds

    holds = rank_of(x) < rank_of(y)
  end function less

  elemental function less_or_equal(x, y) result(holds)
    type(hex32), intent(in) :: x, y
    logical :: holds

    holds = rank_of(x) <= rank_of(y)
  end function less_or_equal

  elemental function greater(x, y) result(holds)
    type(hex32), intent(in) :: x, y
    logical :: holds

    holds = rank_of(x) > rank_of(y)
  end function greater

  elemental function greater_or_equal(x, y) result(holds)
    type(hex32), intent(in) :: x, y
    logical :: holds

    holds = rank_of(x) >= rank_of(y)
  end function greater_or_equal

  elemental function equal(x, y) result(holds)
    type(hex32), intent(in) :: x, y
    logical :: holds

    holds = x%fraction == y%fraction .and. x%exponent == y%exponent
  end function equal

  elemental function not_equal(x, y) result(holds)
    type(hex32), intent(in) :: x, y
    logical :: holds

    holds = x%fraction /= y%fraction .or. x%exponent /= y%exponent
  end function not_equal

  !> digits * 2**exponent2, cut to 24 bits.
  elemental function hex32_from_binary(digits, exponent2) result(x)
    !> any integer, with its sign
    integer(int64), intent(in) :: digits
    !> power of two; any within +-10**9, a number out of range overflows or underflows
    integer, intent(in) :: exponent2
    type(hex32) :: x
    integer(int64) :: magnitude
    integer :: power

    magnitude = digits
    power = exponent2
    ! Room for the sign of the most negative integer and for three more bits below.
    if (leadz(ieor(digits, shifta(digits, int64_bits - 1))) < 5) then
      magnitude = magnitude/16_int64
      power = power + 4
    end if
    ! Whole powers of 16 go to the exponent, what is left of the two's to the digits.
    x = cut(digits < 0_int64, shiftl(abs(magnitude), iand(power, 3)), int(shifta(power, 2), int32))
  end function hex32_from_binary

  !> The largest number, (1 - 2**(-24)) * 16**63, about 7.2e75.
  pure function hex32_huge() result(x)
    type(hex32) :: x

    x = largest(.false.)
  end function hex32_huge

  !> The smallest number above zero, 16**(-65), about 5.4e-79.
  pure function hex32_tiny() result(x)
    type(hex32) :: x

    x = hex32(fraction_min, exponent_min)
  end function hex32_tiny

  !> The largest magnitude with a sign.
  elemental function largest(below_zero) result(x)
    logical, intent(in) :: below_zero
    type(hex32) :: x

    x = hex32(merge(-fraction_max, fraction_max, below_zero), exponent_max)
  end function largest

  !> The number magnitude * 16**power, normalised and cut to 24 bits, with over- and underflow.
  elemental function cut(below_zero, magnitude, power) result(x)
    logical, intent(in) :: below_zero
    !> not negative
    integer(int64), intent(in) :: magnitude
    integer(int32), intent(in) :: power
    type(hex32) :: x
    integer(int32) :: fraction, exponent
    integer :: digits

    digits = (int64_bits - leadz(magnitude) + 3)/4
    exponent = power + int(digits, int32)
    if (digits > fraction_digits) then
      fraction = int(shiftr(magnitude, 4*(digits - fraction_digits)), int32)
    else
      fraction = int(shiftl(magnitude, 4*(fraction_digits - digits)), int32)
    end if
    if (fraction == 0_int32 .or. exponent < exponent_min) then
      x = hex32(0_int32, 0_int32)
    else if (exponent > exponent_max) then
      x = largest(below_zero)
    else
      x = hex32(merge(-fraction, fraction, below_zero), exponent)
    end if
  end function cut

  !> An integer that stands in the same order as the numbers do.
  elemental function rank_of(x) result(rank)
    type(hex32), intent(in) :: x
    integer(int32) :: rank

    rank = 0_int32
    if (x%fraction /= 0_int32) then
      rank = sign(ior(shiftl(x%exponent + exponent_bias, 24), abs(x%fraction)), x%fraction)
    end if
  end function rank_of

end module asperity_hex32_arithmetic
