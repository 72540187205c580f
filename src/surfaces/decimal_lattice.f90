!> Whole numbers of a power of ten: in what a generated surface is counted.
!>
!> A coordinate is `value * 10**(-decimals)`, exactly. So a least distance and cut-offs hold to the
!> last digit written, and no rounding depends on a machine.
module asperity_decimal_lattice
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_generation_values, only: exact_value, gaussian_spec
  use asperity_kinds, only: int64, real128, real64
  use asperity_truncated_normal, only: draw_normal, prepare_normal, truncated_normal, whole_range
  implicit none
  private

  public :: lattice_gaussian, set_gaussian, draw_gaussian, units_below, units_above, order_of, &
            lattice_reals

  ! Digits of a range, and of a number: a double holds 15.
  integer, parameter :: range_digits = 12, number_digits = 15
  integer(int64), parameter :: low_31 = int(z'7FFFFFFF', int64)
  integer(int64), parameter :: pieces = whole_range / (low_31 + 1_int64)
  ! What rounding in real128 may have added to a number of units.
  real(real128), parameter :: slack = 1.0e-15_real128

  !> A Gaussian between cut-offs, in whole units.
  type :: lattice_gaussian
    integer :: decimals = 0                 !! a unit is 10**(-decimals)
    integer(int64) :: lowest = 0_int64      !! units
    integer(int64) :: highest = 0_int64     !! units; the same as `lowest` when all are equal
    type(truncated_normal) :: distribution  !! not used when all are equal
  end type lattice_gaussian

contains

  !> Chooses the unit, unless it is given, and prepares the draws.
  pure subroutine set_gaussian(spec, gaussian, decimals)
    type(gaussian_spec), intent(in) :: spec          !! checked
    type(lattice_gaussian), intent(out) :: gaussian  !! ready to draw from
    integer, intent(in), optional :: decimals        !! digits behind the point, when given
    real(real128) :: mean, deviation, unit

    mean = exact_value(spec%mean)
    deviation = exact_value(spec%deviation)
    if (present(decimals)) then
      gaussian%decimals = decimals
    else if (spec%highest > spec%lowest) then
      gaussian%decimals = min(range_digits - order_of(spec%highest - spec%lowest), &
           number_digits - order_of(max(abs(spec%lowest), abs(spec%highest))))
    else
      ! As it stands in the specification; three of at most 18 digits go from a long one.
      gaussian%decimals = -spec%mean%exponent
      if (abs(spec%mean%digits) >= 10_int64**number_digits) &
        gaussian%decimals = gaussian%decimals - 3
    end if
    if (.not. spec%highest > spec%lowest) then
      gaussian%lowest = nearest_units(mean, gaussian%decimals)
      gaussian%highest = gaussian%lowest
      return
    end if
    gaussian%lowest = units_above(spec%lowest, gaussian%decimals)
    gaussian%highest = units_below(spec%highest, gaussian%decimals)
    if (gaussian%highest <= gaussian%lowest) then
      ! Cut-offs between two neighbouring numbers of units: that next to the middle serves.
      gaussian%lowest = nearest_units((spec%lowest + spec%highest) / 2, gaussian%decimals)
      gaussian%highest = gaussian%lowest
      return
    end if
    unit = 10.0_real128**(-gaussian%decimals)
    call prepare_normal((real(gaussian%lowest, real128) * unit - mean) / deviation, &
                        (real(gaussian%highest, real128) * unit - mean) / deviation, &
                        gaussian%distribution)
  end subroutine set_gaussian

  !> A number of units from three random words, rounded to the nearest.
  pure integer(int64) function draw_gaussian(gaussian, words)
    type(lattice_gaussian), intent(in) :: gaussian  !! ready to draw from
    integer(int64), intent(in) :: words(3)          !! each from 0 to 2**32 - 1
    integer(int64) :: extent, place, whole, part, total

    draw_gaussian = gaussian%lowest
    extent = gaussian%highest - gaussian%lowest
    if (extent == 0_int64) return
    place = draw_normal(gaussian%distribution, words)
    ! extent * place / 2**41, rounded; the product itself has up to 91 bits.
    whole = shiftr(place, 31)
    part = iand(place, low_31)
    total = extent * whole + shiftr(extent, 31) * part + shiftr(iand(extent, low_31) * part, 31)
    draw_gaussian = gaussian%lowest + (total + pieces / 2_int64) / pieces
  end function draw_gaussian

  !> The largest number of units that is not above a value.
  pure integer(int64) function units_below(value, decimals)
    real(real128), intent(in) :: value  !! any length
    integer, intent(in) :: decimals     !! a unit is 10**(-decimals)

    units_below = floor(in_units(value, decimals) + slack, int64)
  end function units_below

  !> The smallest number of units that is not below a value.
  pure integer(int64) function units_above(value, decimals)
    real(real128), intent(in) :: value  !! any length
    integer, intent(in) :: decimals     !! a unit is 10**(-decimals)

    units_above = ceiling(in_units(value, decimals) - slack, int64)
  end function units_above

  !> The least n with |value| < 10**n.
  pure integer function order_of(value)
    real(real128), intent(in) :: value  !! not 0

    order_of = floor(log10(abs(value)))
    ! The logarithm may be off by its last digit.
    do while (10.0_real128**order_of <= abs(value))
      order_of = order_of + 1
    end do
  end function order_of

  !> The nearest doubles of numbers of units: what a reader of their text gets.
  pure subroutine lattice_reals(units, decimals, values)
    integer(int64), intent(in) :: units(:)  !! less than 2**53 each
    integer, intent(in) :: decimals         !! a unit is 10**(-decimals)
    real(real64), intent(out) :: values(:)  !! as many
    integer :: i

    do i = 1, size(units)
      values(i) = decimal_to_real64(decimal_value(units(i), -decimals))
    end do
  end subroutine lattice_reals

  pure integer(int64) function nearest_units(value, decimals)
    real(real128), intent(in) :: value
    integer, intent(in) :: decimals

    nearest_units = nint(in_units(value, decimals), int64)
  end function nearest_units

  pure real(real128) function in_units(value, decimals)
    real(real128), intent(in) :: value
    integer, intent(in) :: decimals

    if (decimals >= 0) then
      in_units = value * 10.0_real128**decimals
    else
      in_units = value / 10.0_real128**(-decimals)
    end if
  end function in_units

end module asperity_decimal_lattice
