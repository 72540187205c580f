#ifndef KIND
!> The functions in which the arithmetics differ, for an IEEE kind.
!>
!> The modules that include this file name the kind: KIND. Without it this is an empty module, by
!> which fpm compiles them anew when this file changes.
module asperity_ieee_numbers
  implicit none
end module asperity_ieee_numbers
#else
  implicit none
  private

  public :: decimal_number, whole_number, from_real64, to_real64, cut_to_integer
  public :: three_halves_power

contains

  !> The number of this kind nearest to an exact decimal; infinite when out of range.
  elemental function decimal_number(value) result(number)
    type(decimal_value), intent(in) :: value  !! exact decimal number
    real(KIND) :: number                      !! nearest number
    character(len=40) :: numeral

    if (decimal_beyond(value, real(huge(number), real128))) then
      number = sign(ieee_value(number, ieee_positive_inf), real(value%all_digits, KIND))
    else if (decimal_order(value) < -(range(number) + 40)) then
      number = 0
    else
      numeral = decimal_numeral(value)
      read (numeral, '(f40.0)') number
    end if
  end function decimal_number

  !> An integer as a number of this kind.
  elemental function whole_number(value) result(number)
    integer, intent(in) :: value  !! integer of any size
    real(KIND) :: number          !! nearest number

    number = real(value, KIND)
  end function whole_number

  !> The nearest double: exact for the shorter kinds.
  elemental function to_real64(number) result(double)
    real(KIND), intent(in) :: number  !! number of this kind
    real(real64) :: double            !! nearest double

    double = real(number, real64)
  end function to_real64

  !> The number nearest to a double; infinite when out of range.
  elemental function from_real64(double) result(number)
    real(real64), intent(in) :: double  !! double of any size
    real(KIND) :: number                !! nearest number

    if (exponent(double) > maxexponent(number)) then
      number = sign(ieee_value(number, ieee_positive_inf), real(sign(1.0_real64, double), KIND))
    else
      number = real(double, KIND)
    end if
  end function from_real64

  !> The whole part, as an assignment to an INTEGER does.
  elemental integer function cut_to_integer(number)
    real(KIND), intent(in) :: number  !! within the range of the default integer

    cut_to_integer = int(number)
  end function cut_to_integer

  !> number**1.5, for number >= 0.
  elemental function three_halves_power(number) result(power)
    real(KIND), intent(in) :: number  !! number, 0 or more
    real(KIND) :: power               !! its power 1.5

    power = number**real(1.5, KIND)
  end function three_halves_power
#endif
