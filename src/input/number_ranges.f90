!> The ranges a number of a scene may have to lie in, and what a message says of them.
module asperity_number_ranges
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_kinds, only: int64, real64
  implicit none
  private

  public :: any_number, above_zero, share, poisson_range, not_negative, share_or_all
  public :: expected_numbers, in_range

  integer, parameter :: any_number = 1     !! any finite number
  integer, parameter :: above_zero = 2     !! more than 0
  integer, parameter :: share = 3          !! more than 0 and less than 1
  integer, parameter :: poisson_range = 4  !! more than -1 and at most 0.5
  integer, parameter :: not_negative = 5   !! 0 or more
  integer, parameter :: share_or_all = 6   !! more than 0 and at most 1

  !> Each range in words, for messages: `expected_numbers(above_zero)`.
  character(len=*), parameter :: expected_numbers(6) = [character(len=50) :: &
    'a finite number within the range of a double', 'a number more than 0', &
    'a number more than 0 and less than 1', 'a number more than -1 and at most 0.5', &
    'a number of 0 or more', 'a number more than 0 and at most 1']

contains

  !> Whether a number is in a range.
  pure logical function in_range(value, number_range)
    type(decimal_value), intent(in) :: value  !! number that is checked
    integer, intent(in) :: number_range       !! `any_number` or another range
    real(real64) :: number

    number = decimal_to_real64(value)
    select case (number_range)
    case (above_zero)
      in_range = value%all_digits > 0_int64
    case (share)
      in_range = value%all_digits > 0_int64 .and. number < 1.0_real64
    case (share_or_all)
      in_range = value%all_digits > 0_int64 .and. number <= 1.0_real64
    case (poisson_range)
      in_range = number > -1.0_real64 .and. number <= 0.5_real64
    case (not_negative)
      in_range = value%all_digits >= 0_int64
    case default
      in_range = .true.
    end select
  end function in_range

end module asperity_number_ranges
