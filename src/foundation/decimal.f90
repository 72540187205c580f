!> Decimal numbers kept exactly, so that each arithmetic converts them by its own rule.
module asperity_decimal
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
  use asperity_kinds, only: int64, real64
  implicit none
  private

  public :: decimal_value, decimal_to_real64, decimal_numeral

  !> The number digits * 10**exponent.
  type :: decimal_value
    integer(int64) :: digits = 0_int64  !! all digits, with the sign
    integer :: exponent = 0             !! power of ten
  end type decimal_value

contains

  !> Nearest IEEE double; infinite when the number is out of range.
  elemental function decimal_to_real64(value) result(nearest)
    type(decimal_value), intent(in) :: value  !! exact decimal
    real(real64) :: nearest                   !! the nearest double
    character(len=40) :: numeral
    integer :: status

    numeral = decimal_numeral(value)
    ! The library's own conversion is correctly rounded; a product with a power of ten is not.
    read (numeral, '(f40.0)', iostat=status) nearest
    if (status /= 0) &
      nearest = sign(ieee_value(nearest, ieee_positive_inf), real(value%digits, real64))
  end function decimal_to_real64

  !> The number as 40 characters that every `F40.0` field reads.
  pure function decimal_numeral(value) result(numeral)
    type(decimal_value), intent(in) :: value  !! exact decimal
    character(len=40) :: numeral              !! for instance `254E-2`

    write (numeral, '(i0, "E", i0)') value%digits, value%exponent
    numeral = adjustr(numeral)
  end function decimal_numeral

end module asperity_decimal
