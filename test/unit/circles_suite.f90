!> Tests of the count of contact circles that overlap, and of their clusters.
module asperity_circles_suite
  use asperity_contact_clusters, only: cluster_of_each
  use asperity_kinds, only: real64
  use asperity_overlapping_circles, only: circles_overlap, count_overlapping
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
      new_unittest('circles: all in one column, all in one place, none', lines), &
      new_unittest('circles: scattered, radii from 1 to 2000, against each with each', scattered), &
      new_unittest('clusters: a chain back and forth, rows far apart, one alone', chains), &
      new_unittest('clusters: scattered, against a spread from each circle', spreading)]
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
        if (circles_overlap(numbers(1, i) - numbers(1, j), numbers(2, i) - numbers(2, j), &
                            numbers(3, i), numbers(3, j))) expected = expected + 1
      end do
    end do
    call check(error, expected > 10000, 'too few pairs to tell')
    call check(error, count_overlapping(numbers(1, :), numbers(2, :), numbers(3, :)), expected, &
               'pairs')
  end subroutine scattered

  !> Contacts in the order of x modulo a stride: a chain joins its ends last.
  subroutine chains(error)
    type(error_type), allocatable, intent(out) :: error
    integer, parameter :: n = 10007, rows = 40, row = 50
    real(real64) :: x(n + 1), y(n + 1)
    integer :: cluster(n + 1), clusters, i

    ! 3001 has no common factor with n, a prime: every place once.
    x(:n) = [(real(modulo(3001 * i, n), real64), i=1, n)]
    y(:n) = 0.0_real64
    x(n + 1) = -5.0_real64
    y(n + 1) = 0.0_real64
    call cluster_of_each(x, y, [(0.51_real64, i=1, n + 1)], cluster, clusters)
    call check(error, clusters, 1, 'a chain')
    call check(error, all(cluster(:n) == 1) .and. cluster(n + 1) == 0, 'members of a chain')
    call cluster_of_each(x, y, [(0.49_real64, i=1, n + 1)], cluster, clusters)
    call check(error, clusters == 0 .and. all(cluster == 0), 'none touches another')
    ! The rows take turns, so that their numbers are those of their first contacts.
    do i = 1, rows * row
      x(i) = real((i - 1) / rows, real64)
      y(i) = 3.0_real64 * real(modulo(7 * i, rows), real64)
    end do
    call cluster_of_each(x(:rows * row), y(:rows * row), [(0.51_real64, i=1, rows * row)], &
                         cluster(:rows * row), clusters)
    call check(error, clusters, rows, 'rows')
    call check(error, all(cluster(:rows * row) == [(1 + modulo(i, rows), i=0, rows * row - 1)]), &
               'members of rows')
  end subroutine chains

  !> Numbers are given from the first contact on, each to all that it reaches.
  subroutine spreading(error)
    type(error_type), allocatable, intent(out) :: error
    integer, parameter :: n = 1500
    real(real64) :: numbers(3, n)
    integer :: expected(n), cluster(n), reached(n), clusters, known, i, j, at

    do i = 1, n
      numbers(:, i) = modulo(i * [0.7548776662466927_real64, 0.5698402909980532_real64, &
                                  0.6180339887498949_real64], 1.0_real64)
    end do
    ! Nearly as many as join into one cluster throughout.
    numbers(3, :) = 0.024_real64 * numbers(3, :)**2
    numbers(3, ::7) = 0.0_real64
    expected = 0
    known = 0
    do i = 1, n
      if (expected(i) > 0) cycle
      known = known + 1
      expected(i) = known
      reached(1) = i
      at = 0
      clusters = 1
      do while (at < clusters)
        at = at + 1
        do j = 1, n
          if (expected(j) > 0) cycle
          if (.not. circles_overlap(numbers(1, j) - numbers(1, reached(at)), &
                                    numbers(2, j) - numbers(2, reached(at)), numbers(3, j), &
                                    numbers(3, reached(at)))) cycle
          expected(j) = known
          clusters = clusters + 1
          reached(clusters) = j
        end do
      end do
      if (clusters > 1) cycle
      expected(i) = huge(known)
      known = known - 1
    end do
    where (expected == huge(known)) expected = 0
    call cluster_of_each(numbers(1, :), numbers(2, :), numbers(3, :), cluster, clusters)
    call check(error, known > 50 .and. count(expected == 0) > 200, 'too few clusters to tell')
    call check(error, clusters, known, 'clusters')
    call check(error, all(cluster == expected), 'members of clusters')
  end subroutine spreading

end module asperity_circles_suite
