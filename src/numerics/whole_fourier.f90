!> Discrete Fourier transform in whole numbers: the same bits on every machine.
!>
!> X(u) = sum over t from 0 to n - 1 of x(t) exp(2 pi i t u/n), without a factor. Method: Stockham's
!> transform of mixed radix (C. Van Loan, Computational Frameworks for the Fast Fourier Transform,
!> 1992), prime factors in descending order, pairs of twos as fours.
!>
!> Real and imaginary parts are int64, roots of unity are whole numbers of 2**-62. A product has 128
!> bits and is rounded to the nearest whole number, so a transform is in error by about one unit for
!> each factor of n. No partial sum exceeds the sum of |x(t)|, which must be below 2**60: nothing
!> overflows. Whole numbers have neither fused operations nor another order of summation: a compiler
!> or processor cannot change a bit. The roots are computed in real128: two mathematical libraries
!> could differ only where one of n roots lies within 1e-33 of a tie.
module asperity_whole_fourier
  use asperity_constants, only: pi_128
  use asperity_kinds, only: int128, int64, real128
  implicit none
  private

  public :: whole_fourier, prepare_fourier, transform_wholes, smooth_length
  public :: real_part, imaginary_part

  !> First index of a complex number.
  integer, parameter :: real_part = 1, imaginary_part = 2

  !> Factors and roots of a transform of one length; several threads may use it.
  type :: whole_fourier
    private
    integer :: length = 0
    integer, allocatable :: factors(:)
    integer(int64), allocatable :: roots(:, :)  ! part; exp(2 pi i k/n), k from 0 to n - 1
  end type whole_fourier

  ! Roots of unity are whole numbers of 2**-root_bits.
  integer, parameter :: root_bits = 62
  integer(int64), parameter :: one = 2_int64**root_bits
  integer(int128), parameter :: half = 2_int128**(root_bits - 1)

contains

  !> Computes factors and roots.
  pure subroutine prepare_fourier(length, transform)
    integer, intent(in) :: length                 !! n, 1 or more
    type(whole_fourier), intent(out) :: transform !! factors and roots of this length
    real(real128) :: angle
    integer :: k

    transform%length = length
    transform%factors = factors_of(length)
    allocate (transform%roots(2, 0:length - 1))
    ! An eighth of the circle is computed; the rest follows exactly by symmetry.
    do k = 0, length - 1
      associate (octant => (8_int64 * k) / length, root => transform%roots(:, k))
        angle = pi_128 * real(distance_to_axis(k, length), real128) / &
                (2 * real(length, real128))
        root = root_units([cos(angle), sin(angle)])
        if (octant == 1 .or. octant == 2 .or. octant == 5 .or. octant == 6) root = root([2, 1])
        if (octant >= 2 .and. octant <= 5) root(1) = -root(1)
        if (octant >= 4) root(2) = -root(2)
      end associate
    end do
  end subroutine prepare_fourier

  ! Distance of k/n of a turn from the nearest quarter, in turns over 4 n.
  pure integer(int64) function distance_to_axis(k, n) result(distance)
    integer, intent(in) :: k, n

    distance = modulo(4_int64 * k, int(n, int64))
    distance = min(distance, n - distance)
  end function distance_to_axis

  elemental integer(int64) function root_units(value)
    real(real128), intent(in) :: value

    root_units = nint(value * real(one, real128), int64)
  end function root_units

  ! Factors of a length, descending, but a pair of twos is a four.
  pure function factors_of(length) result(factors)
    integer, intent(in) :: length
    integer, allocatable :: factors(:)
    integer :: rest, factor

    allocate (factors(0))
    rest = length
    factor = 4
    do while (rest > 1)
      if (factor > 4 .and. factor > rest / factor) factor = rest
      if (modulo(rest, factor) == 0) then
        factors = [factor, factors]
        rest = rest / factor
      else if (factor == 4) then
        factor = 2
      else
        factor = merge(3, factor + 2, factor == 2)
      end if
    end do
  end function factors_of

  !> Least length, n or more, without a prime factor above 5.
  pure integer function smooth_length(n) result(length)
    integer, intent(in) :: n  !! least length, 1 or more
    integer :: rest, i
    integer, parameter :: primes(3) = [2, 3, 5]

    length = n
    do
      rest = length
      do i = 1, size(primes)
        do while (modulo(rest, primes(i)) == 0)
          rest = rest / primes(i)
        end do
      end do
      if (rest == 1) return
      length = length + 1
    end do
  end function smooth_length

  !> Transforms x in place.
  pure subroutine transform_wholes(transform, x, work)
    type(whole_fourier), intent(in) :: transform  !! transform of the length of x
    integer(int64), intent(inout) :: x(2, 0:transform%length - 1)     !! part, t; then X(u)
    integer(int64), intent(inout) :: work(2, 0:transform%length - 1)  !! work space like x
    integer :: i, groups, stride
    logical :: in_work

    groups = transform%length
    stride = 1
    in_work = .false.
    do i = 1, size(transform%factors)
      groups = groups / transform%factors(i)
      if (in_work) then
        call apply_factor(transform, transform%factors(i), groups, stride, work, x)
      else
        call apply_factor(transform, transform%factors(i), groups, stride, x, work)
      end if
      in_work = .not. in_work
      stride = stride * transform%factors(i)
    end do
    if (in_work) x = work
  end subroutine transform_wholes

  ! Applies one factor p: y(r + s (p q + u)) = w**(q u) sum over t of x(r + s (q + m t)) exp(2 pi i
  ! t u/p), with m groups, stride s and w = exp(2 pi i/(p m)).
  pure subroutine apply_factor(transform, p, m, s, x, y)
    type(whole_fourier), intent(in) :: transform
    integer, intent(in) :: p, m, s
    integer(int64), intent(in) :: x(2, 0:s - 1, 0:m - 1, 0:p - 1)
    integer(int64), intent(inout) :: y(2, 0:s - 1, 0:p - 1, 0:m - 1)
    integer(int64) :: sums(2), a(2), b(2), c(2), d(2)
    integer :: q, r, t, u, turn

    select case (p)
    case (2)
      do q = 0, m - 1
        do r = 0, s - 1
          y(:, r, 0, q) = x(:, r, q, 0) + x(:, r, q, 1)
          y(:, r, 1, q) = rotated_number(x(:, r, q, 0) - x(:, r, q, 1), transform%roots(:, q * s))
        end do
      end do
    case (4)
      do q = 0, m - 1
        do r = 0, s - 1
          a = x(:, r, q, 0) + x(:, r, q, 2)
          b = x(:, r, q, 0) - x(:, r, q, 2)
          c = x(:, r, q, 1) + x(:, r, q, 3)
          d = x(:, r, q, 1) - x(:, r, q, 3)
          d = [-d(2), d(1)]
          y(:, r, 0, q) = a + c
          y(:, r, 1, q) = rotated_number(b + d, transform%roots(:, q * s))
          y(:, r, 2, q) = rotated_number(a - c, transform%roots(:, 2 * q * s))
          y(:, r, 3, q) = rotated_number(b - d, transform%roots(:, 3 * q * s))
        end do
      end do
    case default
      turn = transform%length / p
      do q = 0, m - 1
        do u = 0, p - 1
          do r = 0, s - 1
            sums = x(:, r, q, 0)
            do t = 1, p - 1
              sums = sums + rotated_number(x(:, r, q, t), &
                     transform%roots(:, int(modulo(int(t, int64) * u, int(p, int64))) * turn))
            end do
            y(:, r, u, q) = rotated_number(sums, transform%roots(:, q * u * s))
          end do
        end do
      end do
    end select
  end subroutine apply_factor

  ! Product of a number and a root, rounded.
  pure function rotated_number(number, root) result(rotated)
    integer(int64), intent(in) :: number(2), root(2)
    integer(int64) :: rotated(2)

    if (root(1) == one) then
      rotated = number
      return
    end if
    rotated(1) = int(shifta(int(number(1), int128) * root(1) - int(number(2), int128) * root(2) + &
                            half, root_bits), int64)
    rotated(2) = int(shifta(int(number(1), int128) * root(2) + int(number(2), int128) * root(1) + &
                            half, root_bits), int64)
  end function rotated_number

end module asperity_whole_fourier
