!> Draws from a Gaussian that is cut off at both ends, by the inverse of its distribution.
!>
!> A piece of the range is chosen by its probability, then a place in the piece by the inverse of
!> the distribution within it. That inverse, Q(w), solves Q'' = Q Q'**2 (G. Steinbrecher, W. T.
!> Shaw, "Quantile mechanics", European Journal of Applied Mathematics 19 (2008) 87-112, equation
!> of the normal quantile); its Taylor series is computed for every piece.
!>
!> A draw uses whole numbers only, so it is the same on every machine. The tables are computed in
!> real128 and rounded to some 50 bits. Two machines could differ only where one of some 1e4 entries
!> lies within 1e-30 of a tie.
!>
!> Error of a draw: below 1e-11 of the range, as long as the range is within 17 deviations.
module asperity_truncated_normal
  use asperity_constants, only: pi_128
  use asperity_kinds, only: int64, real128
  implicit none
  private

  public :: truncated_normal, prepare_normal, draw_normal, whole_range

  integer, parameter :: pieces = 1024
  integer, parameter :: degree = 8
  ! Probabilities are counted in 2**-52, places and coefficients in 2**-31 of a piece.
  integer, parameter :: bits = 31
  integer(int64), parameter :: certain = 2_int64**52, unit = 2_int64**bits

  !> The whole range, as `draw_normal` counts: 1024 pieces of 2**31.
  integer(int64), parameter :: whole_range = pieces * unit

  !> A Gaussian with cut-offs, ready to draw from.
  type :: truncated_normal
    private
    integer(int64), allocatable :: cumulative(:)  ! from 0: probability below the end of a piece
    integer(int64), allocatable :: series(:, :)   ! coefficients of the place, by degree and piece
  end type truncated_normal

contains

  !> Computes the tables for a range.
  pure subroutine prepare_normal(lowest, highest, distribution)
    real(real128), intent(in) :: lowest   !! cut-off below, deviations from the mean
    real(real128), intent(in) :: highest  !! cut-off above, more than `lowest`
    type(truncated_normal), intent(out) :: distribution  !! tables of the distribution
    real(real128) :: step, left, total, nodes(0:pieces), outside(0:pieces)
    real(real128) :: q(0:degree)
    integer :: i

    allocate (distribution%cumulative(0:pieces), distribution%series(degree, pieces))
    distribution%cumulative = 0_int64
    distribution%series = 0_int64
    step = (highest - lowest) / real(pieces, real128)
    do i = 0, pieces
      nodes(i) = lowest + step * real(i, real128)
    end do
    outside = erfc(abs(nodes) / sqrt(2.0_real128)) / 2
    total = probability_between(0, pieces)
    do i = 1, pieces
      left = nodes(i - 1)
      if (i < pieces) &
        distribution%cumulative(i) = nint(real(certain, real128) * &
                                          (probability_between(0, i) / total), int64)
      ! The series of a piece that is never drawn may exceed the range of numbers.
      if (distribution%cumulative(i) == distribution%cumulative(i - 1) .and. i < pieces) cycle
      call expand_quantile(left, probability_between(i - 1, i), q)
      distribution%series(:, i) = nint(real(unit, real128) * (q(1:) / step), int64)
    end do
    distribution%cumulative(pieces) = certain

  contains

    !> Probability of the Gaussian between two nodes, without loss in the tails.
    pure real(real128) function probability_between(from, to)
      integer, intent(in) :: from, to

      if (nodes(from) >= 0.0_real128) then
        probability_between = outside(from) - outside(to)
      else if (nodes(to) <= 0.0_real128) then
        probability_between = outside(to) - outside(from)
      else
        probability_between = 1.0_real128 - outside(from) - outside(to)
      end if
    end function probability_between

  end subroutine prepare_normal

  !> Expands the quantile in a Taylor series: q(k) is the coefficient of w**k, with w from 0 to 1 in
  !> the piece.
  pure subroutine expand_quantile(left, mass, q)
    real(real128), intent(in) :: left, mass
    real(real128), intent(out) :: q(0:degree)
    real(real128), parameter :: root_two_pi = sqrt(2 * pi_128)
    real(real128) :: slope_squared(0:degree), total
    integer :: k, m

    q = 0.0_real128
    q(0) = left
    q(1) = mass * root_two_pi * exp(left * left / 2)
    do k = 0, degree - 2
      slope_squared(k) = 0.0_real128
      do m = 0, k
        slope_squared(k) = slope_squared(k) + &
                           real((m + 1) * (k - m + 1), real128) * q(m + 1) * q(k - m + 1)
      end do
      total = 0.0_real128
      do m = 0, k
        total = total + q(m) * slope_squared(k - m)
      end do
      q(k + 2) = total / real((k + 1) * (k + 2), real128)
    end do
  end subroutine expand_quantile

  !> A random place in the range, from 0 to `whole_range`, from three random words.
  pure integer(int64) function draw_normal(distribution, words)
    type(truncated_normal), intent(in) :: distribution  !! tables of the distribution
    integer(int64), intent(in) :: words(3)              !! each from 0 to 2**32 - 1
    integer(int64) :: target, share, place
    integer :: first, last, middle, k

    target = ior(shiftl(words(1), 20), shiftr(words(2), 12))
    first = 0
    last = pieces
    do while (last - first > 1)
      middle = (first + last) / 2
      if (distribution%cumulative(middle) > target) then
        last = middle
      else
        first = middle
      end if
    end do
    share = shiftr(words(3), 1)
    place = distribution%series(degree, last)
    do k = degree - 1, 1, -1
      place = distribution%series(k, last) + shifta(place * share, bits)
    end do
    place = min(unit, max(0_int64, shifta(place * share, bits)))
    draw_normal = int(first, int64) * unit + place
  end function draw_normal

end module asperity_truncated_normal
