!> Tests of the count of contact circles that overlap.
module asperity_circles_suite
  use asperity_kinds, only: real64
  use asperity_overlapping_circles, only: count_overlapping
  use asperity_testing, only: check, error_type, new_unittest, unittest_type
  implicit none
  private

  public :: collect_circles

contains

  !> Lists the tests.
  subroutine collect_circles(suite)
    !> all tests
    type(unittest_type), allocatable, intent(out) :: suite(:)

    suite = [ &
      new_unittest('circles: a square lattice in which each meets its eight neighbours', lattice), &
      new_unittest('circles: a column of which one is at the end of the range', far_centre), &
      new_unittest('circles: all in one column, all in one place, none', lines), &
      new_unittest('circles: scattered, radii from 1 to 2000, against each with each', scattered)]
  end subroutine collect_circles

  !> n * n circles a little larger than half the diagonal: 4 n**2 - 6 n + 2 pairs.
  subroutine lattice(error)
    type(error_type), allocatable, intent(out) :: error
    integer, parameter :: sides(4) = [2, 8, 9, 300]
    integer :: i, k, n

    do k = 1, size(sides)
      n = sides(k)
      call check(error, &
                 count_overlapping([(real(modulo(i, n), real64), i=0, n * n - 1)], &
                                   [(real(i / n, real64), i=0, n * n - 1)], &
                                   [(0.71_real64, i=1, n * n)]), 4 * n * n - 6 * n + 2, 'pairs')
    end do
  end subroutine lattice

  ! Its distance over a radius of 1/2 is beyond the largest number.
  subroutine far_centre(error)
    type(error_type), allocatable, intent(out) :: error
    integer, parameter :: n = 300
    integer :: i

    call check(error, count_overlapping([(0.0_real64, i=1, n)], &
                                        [(real(i, real64), i=1, n - 1), huge(1.0_real64)], &
                                        [(0.501_real64, i=1, n)]), n - 2, 'pairs')
  end subroutine far_centre

  subroutine lines(error)
    type(error_type), allocatable, intent(out) :: error
    integer, parameter :: n = 5000, few = 300
    integer :: i

    call check(error, count_overlapping([(0.1_real64, i=1, n)], [(real(i, real64), i=1, n)], &
                                        [(0.501_real64, i=1, n)]), n - 1, 'a column')
    call check(error, count_overlapping([(0.1_real64, i=1, few)], [(7.0_real64, i=1, few)], &
                                        [(1.0e-9_real64, i=1, few)]), few * (few - 1) / 2, &
               'one place')
    call check(error, count_overlapping([(0.1_real64, i=1, few)], [(7.0_real64, i=1, few)], &
                                        [(0.0_real64, i=1, few)]), 0, 'no radius')
  end subroutine lines

  subroutine scattered(error)
    type(error_type), allocatable, intent(out) :: error
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
    call check(error, expected > 10000, 'too few pairs to tell')
    call check(error, count_overlapping(numbers(1, :), numbers(2, :), numbers(3, :)), expected, &
               'pairs')
  end subroutine scattered

end module asperity_circles_suite
