!> Tests of the count of contact circles that overlap.
module asperity_circles_suite
  use asperity_kinds, only: real64
  use asperity_overlapping_circles, only: count_overlapping
  use asperity_testing, only: check, run_test
  implicit none
  private

  public :: run_circles

contains

  !> Runs the tests.
  subroutine run_circles
    call run_test('circles: a column of which one is at the end of the range', far_centre)
    call run_test('circles: scattered, radii from 1 to 2000, against each with each', scattered)
  end subroutine run_circles

  ! Its distance over a radius of 1/2 is beyond the largest number.
  subroutine far_centre
    integer, parameter :: n = 300
    integer :: i

    call check(count_overlapping([(0.0_real64, i=1, n)], &
                                        [(real(i, real64), i=1, n - 1), huge(1.0_real64)], &
                                        [(0.501_real64, i=1, n)]), n - 2, 'pairs')
  end subroutine far_centre

  subroutine scattered
    integer, parameter :: n = 3000
    real(real64) :: numbers(3, n)
    integer :: i, j, expected

    ! Multiples of irrational numbers, their whole parts left out: spread evenly, in no order.
    do i = 1, n
      numbers(:, i) = modulo(i * [0.7548776662466927_real64, 0.5698402909980532_real64, &
                                  0.6180339887498949_real64], 1.0_real64)
    end do
    numbers(:2, :) = 1000.0_real64 * numbers(:2, :)
    ! Most are small.
    numbers(3, :) = 1.0_real64 + 1999.0_real64 * numbers(3, :)**40
    expected = 0
    do i = 2, n
      do j = 1, i - 1
        if (norm2(numbers(:2, i) - numbers(:2, j)) < numbers(3, i) + numbers(3, j)) &
          expected = expected + 1
      end do
    end do
    call check(expected > 10000, 'too few pairs to tell')
    call check(count_overlapping(numbers(1, :), numbers(2, :), numbers(3, :)), expected, 'pairs')
  end subroutine scattered

end module asperity_circles_suite
