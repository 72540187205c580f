!> Numbers as people write them: `2`, `-.5`, `1.27`, `4d5`, `1e-3`, and the ranges of numbers.
!>
!> At most 18 digits are kept; a longer number is rounded at its 18th digit.
module asperity_numeral
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_kinds, only: int64, real64
  implicit none
  private

  public :: read_number, read_numeral, read_whole_number, is_a_double, rounded_decimal
  public :: expected_numbers, in_range
  public :: any_number, above_zero, share, poisson_range, not_negative, share_or_all
  public :: a_length, least_length, most_length

  integer, parameter :: most_digits = 18
  ! No number written with an exponent beyond this can be a double, whatever its length.
  integer, parameter :: largest_exponent = 100000000

  integer, parameter :: any_number = 1     !! any finite number
  integer, parameter :: above_zero = 2     !! more than 0
  integer, parameter :: share = 3          !! more than 0 and less than 1
  integer, parameter :: poisson_range = 4  !! more than -1 and at most 0.5
  integer, parameter :: not_negative = 5   !! 0 or more
  integer, parameter :: share_or_all = 6   !! more than 0 and at most 1
  integer, parameter :: a_length = 7       !! from `least_length` to `most_length`

  !> Lengths beyond these are no lengths of anything, and their powers would not fit in a double.
  real(real64), parameter :: least_length = 1.0e-30_real64, most_length = 1.0e30_real64

  !> Each range in words, for messages: `expected_numbers(above_zero)`.
  character(len=*), parameter :: expected_numbers(7) = [character(len=50) :: &
    'a finite number within the range of a double', 'a number more than 0', &
    'a number more than 0 and less than 1', 'a number more than -1 and at most 0.5', &
    'a number of 0 or more', 'a number more than 0 and at most 1', 'a length from 1e-30 to 1e30']
  ! The least and the largest double of each range.
  real(real64), parameter :: largest = huge(1.0_real64), above_0 = nearest(0.0_real64, 1.0_real64)
  real(real64), parameter :: limits(2, 7) = reshape([-largest, largest, above_0, largest, &
    above_0, nearest(1.0_real64, -1.0_real64), nearest(-1.0_real64, 1.0_real64), 0.5_real64, &
    0.0_real64, largest, above_0, 1.0_real64, least_length, most_length], [2, 7])

contains

  !> Reads a whole token as a number. Refused are also numbers that no double can hold:
  !> infinite ones, and ones other than zero that become zero.
  pure subroutine read_numeral(token, value, good)
    character(len=*), intent(in) :: token      !! the token, without blanks
    type(decimal_value), intent(out) :: value  !! the number, exactly; 0 when refused
    logical, intent(out) :: good               !! whether the token is such a number
    integer :: i, digit, kept, dropped, behind_point, power
    logical :: negative, after_point, digit_seen, round_up

    good = .false.
    negative = .false.
    after_point = .false.
    digit_seen = .false.
    round_up = .false.
    kept = 0
    dropped = 0
    behind_point = 0
    power = 0
    do i = 1, len(token)
      digit = iachar(token(i:i)) - iachar('0')
      if (digit >= 0 .and. digit <= 9) then
        digit_seen = .true.
        if (after_point) behind_point = behind_point + 1
        if (kept < most_digits) then
          value%all_digits = 10_int64 * value%all_digits + int(digit, int64)
          if (value%all_digits > 0_int64) kept = kept + 1
        else
          if (dropped == 0) round_up = digit >= 5
          dropped = dropped + 1
        end if
      else if (token(i:i) == '.' .and. .not. after_point) then
        after_point = .true.
      else if (scan(token(i:i), '+-') > 0 .and. i == 1) then
        negative = token(i:i) == '-'
      else if (scan(token(i:i), 'eEdD') > 0 .and. digit_seen) then
        call read_exponent(token(i + 1:), power, good)
        exit
      else
        good = .false.
        exit
      end if
      good = digit_seen
    end do
    if (.not. good) then
      value = decimal_value()
      return
    end if
    if (round_up) value%all_digits = value%all_digits + 1_int64
    if (negative) value%all_digits = -value%all_digits
    if (value%all_digits /= 0_int64) value%power_of_ten = power - behind_point + dropped
    good = is_a_double(value)
    if (.not. good) value = decimal_value()
  end subroutine read_numeral

  !> Reads a whole token as the nearest double.
  pure subroutine read_number(token, value, good)
    character(len=*), intent(in) :: token  !! the token, without blanks
    real(real64), intent(out) :: value     !! the number; 0 when refused
    logical, intent(out) :: good           !! as of `read_numeral`
    type(decimal_value) :: decimal

    call read_numeral(token, decimal, good)
    value = decimal_to_real64(decimal)
  end subroutine read_number

  !> Reads a whole token as a default integer.
  pure subroutine read_whole_number(token, value, good)
    character(len=*), intent(in) :: token  !! the token, without blanks
    integer, intent(out) :: value          !! the number; 0 when refused
    logical, intent(out) :: good           !! whether the token is such a number
    type(decimal_value) :: number

    value = 0
    call read_numeral(token, number, good)
    good = good .and. verify(token, '+-0123456789') == 0 .and. number%power_of_ten == 0 .and. &
           abs(number%all_digits) <= int(huge(value), int64)
    if (good) value = int(number%all_digits)
  end subroutine read_whole_number

  !> A double rounded to so many digits.
  pure function rounded_decimal(value, digit_count) result(number)
    real(real64), intent(in) :: value   !! finite double of any sign
    integer, intent(in) :: digit_count  !! from 1 to 18
    real(real64) :: number
    character(len=32) :: text, form

    write (form, '("(es32.", i0, "e3)")') digit_count - 1
    write (text, form) value
    read (text, *) number
  end function rounded_decimal

  !> Reads the digits behind an exponent's letter.
  pure subroutine read_exponent(text, power, good)
    character(len=*), intent(in) :: text
    integer, intent(out) :: power
    logical, intent(out) :: good
    integer :: i, first

    power = 0
    first = 1
    if (len(text) > 0) then
      if (scan(text(1:1), '+-') > 0) first = 2
    end if
    good = len(text) >= first
    if (good) good = verify(text(first:), '0123456789') == 0
    if (.not. good) return
    do i = first, len(text)
      power = min(10 * power + iachar(text(i:i)) - iachar('0'), largest_exponent)
    end do
    if (text(1:1) == '-') power = -power
  end subroutine read_exponent

  !> Whether the nearest double is finite, and zero only for zero.
  elemental logical function is_a_double(value)
    type(decimal_value), intent(in) :: value  !! decimal number of any size
    real(real64) :: nearest_double

    is_a_double = value%all_digits == 0_int64
    ! Beyond these no double lies, and the library's conversion need not be asked.
    if (is_a_double .or. value%power_of_ten > 309 .or. value%power_of_ten < -342) return
    is_a_double = .true.
    if (abs(value%power_of_ten) < 280) return
    nearest_double = decimal_to_real64(value)
    is_a_double = abs(nearest_double) <= huge(nearest_double) .and. abs(nearest_double) > 0.0_real64
  end function is_a_double

  !> Whether a number is in a range.
  pure logical function in_range(value, number_range)
    real(real64), intent(in) :: value    !! number that is checked
    integer, intent(in) :: number_range  !! `any_number` or another range

    in_range = value >= limits(1, number_range) .and. value <= limits(2, number_range)
  end function in_range

end module asperity_numeral
