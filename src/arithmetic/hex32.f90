!> Short hexadecimal floating point of the IBM System/360 and 370, as a number type.
!>
!> A number is a signed 24-bit fraction times a power of 16. This module is the interface for
!> others:
!> the type with its operators (`asperity_hex32_arithmetic`, which documents the rules and
!> exceptions), its conversions (`asperity_hex32_conversions`), and the functions of the FORTRAN
!> library, which also use integer arithmetic only.
module asperity_hex32
  use asperity_hex32_arithmetic, only: hex32, hex32_from_binary, hex32_huge, hex32_tiny, &
                                       operator(+), operator(-), operator(*), operator(/), &
                                       operator(<), operator(<=), operator(>), operator(>=), &
                                       operator(==), operator(/=)
  use asperity_hex32_conversions, only: hex32_from_decimal, hex32_from_integer, &
                                        hex32_from_real64, hex32_from_word, hex32_to_integer, &
                                        hex32_to_real64, hex32_word
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

  !> Square root by the method of the FORTRAN library: a hyperbola for the first value, then two
  !> Newton steps in this arithmetic, the last sum halved and rounded. It is not always the
  !> nearest number: its error is at most one unit of the last place.
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
  !> The polynomials of the library are unknown. No printed result of the thesis depends on them, as
  !> its angles are zero.
  interface sin
    elemental module function sine(x) result(value)
      implicit none
      !> angle, rad; any size
      type(hex32), intent(in) :: x
      type(hex32) :: value
    end function sine
  end interface sin

  !> Cosine of an angle in radians, rounded to the nearest number; cos 0 = 1 exactly.
  !> The polynomials of the library are unknown, see `sin`.
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
    !> The library used logarithm and exponential; the rounded value agrees with the thesis.
    !> A negative number gives the power of its magnitude.
    elemental module function three_halves_power(x) result(power)
      implicit none
      !> any number; zero gives zero
      type(hex32), intent(in) :: x
      type(hex32) :: power
    end function three_halves_power
  end interface

end module asperity_hex32
