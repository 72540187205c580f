!> The least and the largest of an array of numbers.
module asperity_number_span
  use asperity_kinds, only: real64
  implicit none
  private

  public :: number_span
  public :: span_of

  !> Range of numbers.
  type :: number_span
    real(real64) :: least = huge(1.0_real64)      !! least number; huge when there are none
    real(real64) :: largest = -huge(1.0_real64)   !! largest number; -huge when there are none
  end type number_span

contains

  !> Range of numbers in one pass, with four independent comparisons at a time.
  pure function span_of(numbers) result(span)
    real(real64), contiguous, intent(in) :: numbers(:)  !! any finite numbers
    type(number_span) :: span                           !! range of all numbers
    real(real64) :: low(4), high(4)
    integer :: i, k

    low = span%least
    high = span%largest
    do i = 1, size(numbers) - 3, 4
      do k = 1, 4
        low(k) = min(low(k), numbers(i + k - 1))
        high(k) = max(high(k), numbers(i + k - 1))
      end do
    end do
    do k = i, size(numbers)
      low(1) = min(low(1), numbers(k))
      high(1) = max(high(1), numbers(k))
    end do
    span%least = minval(low)
    span%largest = maxval(high)
  end function span_of

end module asperity_number_span
