!> Short hexadecimal floating point of the IBM System/360 and 370, as a number type.
!>
!> A number is a signed 24-bit fraction times a power of 16. Every operation is integer work, so
!> the same bits come out with every compiler, flag and processor.
!>
!> Exceptions set no flag and stop nothing. They give what the period's FORTRAN library put in as
!> its standard correction after the interrupt:
!> exponent overflow gives the largest magnitude with the sign of the result; exponent underflow
!> gives true zero; x/0 gives the largest magnitude with the sign of x, and 0/0 gives zero;
!> the root of a negative number is the root of its magnitude.
!>
!> Source: the machine's rules for short floating point (normalised add, subtract, multiply,
!> divide, compare), that is, one guard digit and no rounding anywhere.
module asperity_hex32
  use asperity_kinds, only: int32, int64, real64
  implicit none
  private

  public :: hex32
  public :: operator(+), operator(-), operator(*), operator(/)
  public :: operator(<), operator(<=), operator(>), operator(>=), operator(==), operator(/=)
  public :: sqrt, sin, cos, three_halves_power
  public :: hex32_from_integer, hex32_from_decimal, hex32_from_binary
  public :: hex32_from_real64, hex32_from_word
  public :: hex32_to_integer, hex32_to_real64, hex32_word
  public :: hex32_huge, hex32_tiny

  !> Hex digits in a fraction.
  integer, parameter :: fraction_digits = 6
  integer(int32), parameter :: exponent_max = 63_int32
  integer(int32), parameter :: exponent_min = -64_int32
  !> The characteristic in a machine word is the exponent plus this.
  integer(int32), parameter :: exponent_bias = 64_int32
  integer(int32), parameter :: fraction_max = 16_int32**fraction_digits - 1_int32
  integer(int32), parameter :: fraction_min = 16_int32**(fraction_digits - 1)

  integer, parameter :: int64_bits = bit_size(0_int64)
  !> Long integers are held as limbs of this many bits, so that a product of two fits in int64.
  integer, parameter :: limb_bits = 30
  integer(int64), parameter :: limb_mask = 2_int64**limb_bits - 1_int64

  !> A short hexadecimal number, fraction/2**24 * 16**exponent. It starts as zero.
  !>
  !> The magnitude of the fraction is 0 or in [2**20, 2**24), the exponent in [-64, 63].
  !> Zero is only (0, 0), so equal numbers have equal components.
  type :: hex32
    private
    integer(int32) :: fraction = 0_int32
    integer(int32) :: exponent = 0_int32
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

  !> Square root by the method of the FORTRAN library: a hyperbola for the first value, then two
  !> Newton steps in this arithmetic, the last sum halved and rounded. It is not always the
  !> nearest number: it can be one unit of the last place off.
  !> A negative number gives the root of its magnitude.
  interface sqrt
    elemental module function square_root(x) result(root)
      implicit none
      !> any number
      type(hex32), intent(in) :: x
      type(hex32) :: root
    end function square_root
  end interface sqrt

  !> Sine of an angle in radians, rounded to the nearest number; sin 0 = 0 exactly.
  !> The library's own polynomials are not known. The thesis' angles are zero, so nothing printed
  !> there hangs on them.
  interface sin
    elemental module function sine(x) result(value)
      implicit none
      !> angle, rad; any size
      type(hex32), intent(in) :: x
      type(hex32) :: value
    end function sine
  end interface sin

  !> Cosine of an angle in radians, rounded to the nearest number; cos 0 = 1 exactly.
  !> See `sin` for what is not known of the original.
  interface cos
    elemental module function cosine(x) result(value)
      implicit none
      !> angle, rad; any size
      type(hex32), intent(in) :: x
      type(hex32) :: value
    end function cosine
  end interface cos

  interface
    !> x**1.5 rounded to the nearest number, from the exact value; a tie goes up.
    !> The library went by logarithm and exponential; rounding meets what the thesis printed.
    !> A negative number gives the power of its magnitude.
    elemental module function three_halves_power(x) result(power)
      implicit none
      !> any number; zero gives zero
      type(hex32), intent(in) :: x
      type(hex32) :: power
    end function three_halves_power
  end interface

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

  !> A whole number, exact up to 24 bits and cut beyond.
  elemental function hex32_from_integer(i) result(x)
    !> any whole number
    integer, intent(in) :: i
    type(hex32) :: x

    x = cut(i < 0, abs(int(i, int64)), 0_int32)
  end function hex32_from_integer

  !> digits * 10**exponent10, cut to 24 bits from the exact value: what the compiler and the
  !> FORMAT routines of the time made of a decimal number.
  elemental function hex32_from_decimal(digits, exponent10) result(x)
    !> the decimal number without its point, with its sign
    integer(int64), intent(in) :: digits
    !> power of ten; any, a number out of range overflows or underflows
    integer, intent(in) :: exponent10
    type(hex32) :: x
    ! 10**120 takes 399 bits, digits 64; a quotient needs 16 limbs below its unit.
    integer, parameter :: limbs = 20
    integer, parameter :: power_limit = 120
    integer(int64) :: limb(0:limbs - 1), rest, factor
    integer :: first, top, left, step, i

    if (digits == 0_int64) then
      x = hex32()
    else if (exponent10 > power_limit) then
      x = largest(digits < 0_int64)
    else if (exponent10 < -power_limit) then
      x = hex32()
    else
      ! A divided number is first moved up by enough limbs to leave more than 24 bits below.
      first = 0
      if (exponent10 < 0) first = (-10*exponent10/3)/limb_bits + 2
      limb(:) = 0_int64
      ! The magnitude of the most negative digits has no int64, that less one has.
      rest = merge(not(digits), digits - 1_int64, digits < 0_int64)
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
          ! Cutting after each part is the same as cutting once after the whole.
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
      ! Two limbs hold at least 31 bits of the number; those below do not touch the first 24.
      if (top == 0) then
        x = hex32_from_binary(limb(0), -limb_bits*first)
      else
        x = hex32_from_binary(shiftl(limb(top), limb_bits) + limb(top - 1), &
                              limb_bits*(top - 1 - first))
      end if
      if (digits < 0_int64) x = negative(x)
    end if
  end function hex32_from_decimal

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

  !> A double-precision number, cut to 24 bits. Infinity gives the largest magnitude, a NaN zero.
  elemental function hex32_from_real64(value) result(x)
    !> any double-precision number
    real(real64), intent(in) :: value
    type(hex32) :: x
    integer, parameter :: mantissa_bits = 52, exponent_bits = 11, bias = 1023
    integer(int64) :: bits, mantissa
    integer :: exponent2

    ! By its bits, so that no flag may reorder it and no trap is sprung.
    bits = transfer(value, bits)
    mantissa = ibits(bits, 0, mantissa_bits)
    exponent2 = int(ibits(bits, mantissa_bits, exponent_bits))
    if (exponent2 == 2*bias + 1) then
      x = hex32()
      if (mantissa == 0_int64) x = largest(bits < 0_int64)
    else if (exponent2 == 0) then
      x = hex32()
    else
      x = hex32_from_binary(ibset(mantissa, mantissa_bits), exponent2 - bias - mantissa_bits)
      if (bits < 0_int64) x = negative(x)
    end if
  end function hex32_from_real64

  !> The number whose machine word this is; an unnormalised one is normalised first.
  elemental function hex32_from_word(word) result(x)
    !> sign, excess-64 exponent in 7 bits, fraction in 24 bits
    integer(int32), intent(in) :: word
    type(hex32) :: x

    x = cut(word < 0_int32, int(ibits(word, 0, 24), int64), &
            ibits(word, 24, 7) - exponent_bias - int(fraction_digits, int32))
  end function hex32_from_word

  !> The whole part, cut towards zero; beyond the range the largest integer with the sign.
  elemental function hex32_to_integer(x) result(i)
    !> any number
    type(hex32), intent(in) :: x
    integer :: i
    integer(int64) :: magnitude

    magnitude = int(abs(x%fraction), int64)
    if (x%exponent <= 0_int32) then
      magnitude = 0_int64
    else if (x%exponent <= fraction_digits) then
      magnitude = shiftr(magnitude, 4*(fraction_digits - x%exponent))
    else
      ! Fifteen digits fit in int64 and are more than a default integer has.
      magnitude = shiftl(magnitude, 4*(min(x%exponent, 15_int32) - fraction_digits))
    end if
    i = int(min(magnitude, int(huge(i), int64)))
    if (x%fraction < 0_int32) i = -i
  end function hex32_to_integer

  !> The number in double precision, exactly.
  elemental function hex32_to_real64(x) result(value)
    !> any number
    type(hex32), intent(in) :: x
    real(real64) :: value

    value = scale(real(x%fraction, real64), 4*(x%exponent - fraction_digits))
  end function hex32_to_real64

  !> The machine's word: sign, excess-64 exponent in 7 bits, fraction in 24 bits. Zero is 0.
  elemental function hex32_word(x) result(word)
    !> any number
    type(hex32), intent(in) :: x
    integer(int32) :: word

    word = 0_int32
    if (x%fraction /= 0_int32) then
      word = ior(shiftl(x%exponent + exponent_bias, 24), abs(x%fraction))
      if (x%fraction < 0_int32) word = ibset(word, 31)
    end if
  end function hex32_word

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

end module asperity_hex32
