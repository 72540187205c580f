!> Tests of contact circles that overlap, and of caps that rise above them.
module asperity_circles_suite
  use asperity_circle_field, only: circle_set
  use asperity_contact_pairs, only: contact_pairs
  use asperity_hidden_contacts, only: find_protrusion
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
    call run_test('circles: a sharper cap rises above a shifted contact', protrusion)
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

  ! Heights of the two paraboloids, point by point about the centre of the circle.
  subroutine protrusion
    type(contact_pairs) :: pairs
    type(circle_set) :: set
    real(real64) :: height, distance, slope, highest, place(2), of_cap(2)
    real(real64), parameter :: reach = 0.4_real64, step = acos(-1.0_real64) / 1000
    integer :: i, j

    allocate (pairs%list(2))
    pairs%list%radius = [2.0_real64, 0.5_real64]
    pairs%list%x = [0.3_real64, 0.8_real64]
    pairs%list%y = [-0.1_real64, -0.4_real64]
    pairs%list%gap = [0.1_real64, 0.15_real64]
    set%contact = [1]
    allocate (set%shift(2, 1), source=0.0_real64)
    set%shift(:, 1) = [0.15_real64, 0.05_real64]
    call find_protrusion(pairs, set, 1, 2, reach, height, distance, slope)
    highest = -huge(highest)
    do j = 0, 100
      do i = 1, 2000
        place = set%shift(:, 1) + 0.01_real64 * j * reach * [cos(i * step), sin(i * step)]
        of_cap = place + [pairs%list(1)%x - pairs%list(2)%x, pairs%list(1)%y - pairs%list(2)%y]
        highest = max(highest, pairs%list(1)%gap - pairs%list(2)%gap + &
                      0.5_real64 * sum(place**2) / pairs%list(1)%radius - &
                      0.5_real64 * sum(of_cap**2) / pairs%list(2)%radius)
      end do
    end do
    call check(abs(height - highest) < 1.0e-5_real64, 'the height of the cap')
  end subroutine protrusion

end module asperity_circles_suite
