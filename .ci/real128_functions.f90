!> REAL(16) functions that the run-time library of Debian's flang-19 lacks, by the names under
!> which flang calls them. Compiled by gfortran, linked into the program that flang builds.
module real128_functions
  use, intrinsic :: iso_fortran_env, only: int32, int64, real128
  implicit none
  private

  public :: f128_ceiling, f128_cos, f128_exponent, f128_log10, f128_power, f128_scale, f128_sin
  public :: f128_erfc, f128_exp, f128_floor, f128_hypot, f128_nearest, f128_round, f128_sqrt
  public :: f128_atan2, f128_truncate

contains

  function f128_sqrt(x) result(y) bind(c, name='_FortranASqrtF128')
    real(real128), value :: x
    real(real128) :: y

    y = sqrt(x)
  end function f128_sqrt

  function f128_atan2(y, x) result(angle) bind(c, name='_FortranAAtan2F128')
    real(real128), value :: y, x
    real(real128) :: angle

    angle = atan2(y, x)
  end function f128_atan2

  function f128_sin(x) result(y) bind(c, name='_FortranASinF128')
    real(real128), value :: x
    real(real128) :: y

    y = sin(x)
  end function f128_sin

  function f128_cos(x) result(y) bind(c, name='_FortranACosF128')
    real(real128), value :: x
    real(real128) :: y

    y = cos(x)
  end function f128_cos

  function f128_log10(x) result(y) bind(c, name='_FortranALog10F128')
    real(real128), value :: x
    real(real128) :: y

    y = log10(x)
  end function f128_log10

  function f128_power(x, power) result(y) bind(c, name='_FortranAPowF128')
    real(real128), value :: x, power
    real(real128) :: y

    y = x**power
  end function f128_power

  function f128_exp(x) result(y) bind(c, name='_FortranAExpF128')
    real(real128), value :: x
    real(real128) :: y

    y = exp(x)
  end function f128_exp

  function f128_hypot(x, y) result(length) bind(c, name='_FortranAHypotF128')
    real(real128), value :: x, y
    real(real128) :: length

    length = hypot(x, y)
  end function f128_hypot

  function f128_erfc(x) result(y) bind(c, name='_FortranAErfcF128')
    real(real128), value :: x
    real(real128) :: y

    y = erfc(x)
  end function f128_erfc

  !> The nearest whole number, as a real.
  function f128_nearest(x) result(y) bind(c, name='_FortranARoundF128')
    real(real128), value :: x
    real(real128) :: y

    y = anint(x)
  end function f128_nearest

  !> The whole number towards 0, as a real.
  function f128_truncate(x) result(y) bind(c, name='_FortranATruncF128')
    real(real128), value :: x
    real(real128) :: y

    y = aint(x)
  end function f128_truncate

  !> The largest whole number not above x.
  function f128_floor(x) result(y) bind(c, name='_FortranAFloorF128')
    real(real128), value :: x
    real(real128) :: y

    y = aint(x)
    if (y > x) y = y - 1
  end function f128_floor

  !> The least whole number not below x.
  function f128_ceiling(x) result(y) bind(c, name='_FortranACeilF128')
    real(real128), value :: x
    real(real128) :: y

    y = aint(x)
    if (y < x) y = y + 1
  end function f128_ceiling

  !> The nearest whole number.
  function f128_round(x) result(whole) bind(c, name='_FortranALlroundF128')
    real(real128), value :: x
    integer(int64) :: whole

    whole = nint(x, int64)
  end function f128_round

  function f128_scale(x, power) result(y) bind(c, name='_FortranAScale16')
    real(real128), value :: x
    integer(int64), value :: power
    real(real128) :: y

    y = scale(x, int(power))
  end function f128_scale

  function f128_exponent(x) result(power) bind(c, name='_FortranAExponent16_4')
    real(real128), value :: x
    integer(int32) :: power

    power = int(exponent(x), int32)
  end function f128_exponent

end module real128_functions
