!> Fourier components of a self-affine random height map, in whole numbers.
!>
!> h(x, y) = sum over wave vectors q of a(q) exp(i q.(x, y)), a(-q) the conjugate of a(q), with
!> q = 2 pi (k_x/L_x, k_y/L_y) on a periodic map of sides L. Real and imaginary part of a(q) are
!> Gaussian with the same variance, in proportion to the power spectral density
!>
!>   C(q) = C_0                            q <= q_r   (or 0 there)
!>   C(q) = C_0 (q/q_r)**(-2 (1 + H))      q_r <= q <= q_c
!>   C(q) = 0                              q > q_c
!>
!> with q_r, q_c = 2 pi over the roll-off and the cut-off wavelength and the Hurst exponent H (B. N.
!> J. Persson, O. Albohr, U. Tartaglino, A. I. Volokitin, E. Tosatti, J. Phys.: Condens. Matter 17
!> (2005) R1; T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5 (2017) 013001).
!> q = 0 has no power, nor has a wave of two pixels, which has no slope there.
!>
!> A component is a function of the seed and its two wave numbers: neither the number of pixels nor
!> that of threads changes it. Counter of the generator: k_x, k_y modulo 2**32, 1 for the real and 2
!> for the imaginary part, 7; key: seed, 0.
!>
!> Whole numbers only, as in `asperity_whole_fourier`. Tables are computed in real128: two
!> mathematical libraries could differ only where an entry lies within 1e-30 of a tie.
module asperity_map_waves
  use asperity_generation_values, only: below_none, exact_value, map_spec, period_of
  use asperity_kinds, only: int128, int64, real128
  use asperity_random_philox, only: philox_block
  use asperity_truncated_normal, only: draw_normal, prepare_normal, truncated_normal, whole_range
  implicit none
  private

  public :: map_waves, plan_waves, draw_waves

  !> Range, spectrum and units of the components of a map.
  type :: map_waves
    integer :: period(2) = 0                 !! pixels of the periodic map along x and y
    integer :: most(2) = 0                   !! largest wave numbers along x and y
    real(real128) :: side(2) = 0.0_real128   !! lengths of the periodic map along x and y
    logical :: empty = .true.                !! no component has power
    integer :: unit_bits = 0                 !! a component of 1 is 2**-unit_bits of its amplitude
    type(map_spec), private :: spec
    integer(int128), private :: square(2) = 0_int128  ! (q/q_r)**2 of the wave numbers 1
    integer(int128), private :: lowest = 0_int128     ! (q/q_r)**2 of the first and last component
    integer(int128), private :: highest = 0_int128
    integer(int64), private, allocatable :: series(:, :)  ! coefficients by degree and piece
    integer(int64), private, allocatable :: decay(:)      ! amplitude by power of 4
    type(truncated_normal), private :: gaussian
  end type map_waves

  ! (q/q_r)**2 is counted in 2**-square_bits, an amplitude in 2**-amplitude_bits.
  integer, parameter :: square_bits = 80, amplitude_bits = 60
  integer, parameter :: wide_bits = int(bit_size(1_int128))
  integer(int128), parameter :: unity = 2_int128**square_bits
  ! The interval from 1 to 4 in pieces of 2**-8: the series ends with 2**-8 to the power 7, 1e-17.
  integer, parameter :: piece_bits = 8, pieces = 3 * 2**piece_bits, degree = 6
  integer, parameter :: place_bits = amplitude_bits - piece_bits
  ! (q/q_r)**2 is at most 4**most_decay: the square of the largest wave number, 2**20.
  integer, parameter :: most_decay = 21
  ! A wavelength that differs from the roll-off or the cut-off by rounding alone is in the band.
  real(real128), parameter :: slack = 1.0e-12_real128
  ! Draws are cut off at so many deviations, beyond which the probability is 1.2e-15; a draw is a
  ! whole number of 2**-draw_bits.
  integer, parameter :: farthest = 8, draw_bits = 37
  ! The sum of all components is below 2**sum_bits: two rows of a map are transformed as one, and a
  ! transform takes 2**60.
  integer, parameter :: sum_bits = 58
  integer, parameter :: draw_order = 4  ! |a| <= 8 sqrt(2) amplitude < 2**4 amplitude
  ! Stream of the generator: surfaces have 1 to 6.
  integer(int64), parameter :: stream = 7_int64, low_32 = int(z'FFFFFFFF', int64)

contains

  !> Prepares the components of a map.
  pure subroutine plan_waves(spec, waves)
    type(map_spec), intent(in) :: spec    !! specification, checked for faults
    type(map_waves), intent(out) :: waves  !! tables to draw from
    real(real128) :: roll_off, power, left
    integer(int128) :: total
    integer :: i, k, piece

    waves%spec = spec
    waves%period = period_of(spec%pixels, spec%periodic)
    waves%side = waves%period * exact_value(spec%pixel_spacing)
    ! A roll-off beyond the longest wave of the map changes no ratio of two components.
    roll_off = min(spec%roll_off, maxval(waves%side))
    waves%most = min(int(waves%side / spec%cut_off * (1 + slack)), (waves%period - 1) / 2)
    ! Along a side without waves the square is not needed, and may exceed the range of integers.
    where (waves%most > 0) waves%square = square_units((roll_off / waves%side)**2)
    waves%highest = square_units((roll_off / spec%cut_off)**2 * (1 + slack))
    if (spec%below == below_none) &
      waves%lowest = square_units((roll_off / spec%roll_off)**2 * (1 - slack))
    power = (1 + spec%hurst) / 2
    allocate (waves%series(0:degree, 0:pieces - 1), waves%decay(0:most_decay))
    do piece = 0, pieces - 1
      left = 1 + real(piece, real128) / 2**piece_bits
      waves%series(0, piece) = amplitude_units(left**(-power))
      do k = 1, degree
        waves%series(k, piece) = amplitude_units(binomial(k) * left**(-power - k) / &
                                                 2.0_real128**(k * piece_bits))
      end do
    end do
    waves%decay = amplitude_units([(4.0_real128**(-power * i), i=0, most_decay)])
    call prepare_normal(-real(farthest, real128), real(farthest, real128), waves%gaussian)
    total = 0_int128
    do i = 0, waves%most(1)
      do k = merge(1, 0, i == 0), waves%most(2)
        total = total + merge(4, 2, i > 0 .and. k > 0) * int(amplitude_of(waves, i, k), int128)
      end do
    end do
    waves%empty = total == 0_int128
    if (.not. waves%empty) waves%unit_bits = sum_bits - draw_order - &
                                             max(0, wide_bits - leadz(total) - amplitude_bits)

  contains

    elemental integer(int128) function square_units(value)
      real(real128), intent(in) :: value

      square_units = int(value * real(unity, real128) + 0.5_real128, int128)
    end function square_units

    elemental integer(int64) function amplitude_units(value)
      real(real128), intent(in) :: value

      amplitude_units = nint(value * 2.0_real128**amplitude_bits, int64)
    end function amplitude_units

    ! Binomial coefficient of -power over order.
    pure real(real128) function binomial(order)
      integer, intent(in) :: order
      integer :: n

      binomial = 1.0_real128
      do n = 0, order - 1
        binomial = binomial * (-power - n) / (n + 1)
      end do
    end function binomial

  end subroutine plan_waves

  ! Root of C(q)/C_0, in 2**-amplitude_bits: m**(-power) with a series about the left end of a
  ! piece, where (q/q_r)**2 = 4**k m and m is from 1 to 4.
  pure integer(int64) function amplitude_of(waves, i, j)
    type(map_waves), intent(in) :: waves
    integer, intent(in) :: i, j  ! wave numbers, none negative
    integer(int128) :: square
    integer(int64) :: mantissa, place
    integer :: k, n, piece

    amplitude_of = 0_int64
    square = waves%square(1) * (int(i, int128) * i) + waves%square(2) * (int(j, int128) * j)
    if (square < waves%lowest .or. square > waves%highest) return
    amplitude_of = 2_int64**amplitude_bits
    if (square <= unity) return
    k = (wide_bits - 1 - leadz(square) - square_bits) / 2
    mantissa = int(shiftr(square, square_bits - amplitude_bits + 2 * k), int64)
    piece = int(shiftr(mantissa, place_bits)) - 2**piece_bits
    place = iand(mantissa, 2_int64**place_bits - 1_int64)
    amplitude_of = waves%series(degree, piece)
    do n = degree - 1, 0, -1
      amplitude_of = waves%series(n, piece) + product_of(amplitude_of, place, place_bits)
    end do
    amplitude_of = product_of(amplitude_of, waves%decay(k), amplitude_bits)
  end function amplitude_of

  !> The components of one wave number along x.
  pure subroutine draw_waves(waves, i, components)
    type(map_waves), intent(in) :: waves             !! tables of `plan_waves`
    integer, intent(in) :: i                         !! wave number along x, 0 to `most(1)`
    integer(int64), intent(out) :: components(:, 0:)  !! part, wave number along y modulo the period
    integer(int64) :: amplitude_here, part(2)
    integer :: j, k

    components = 0_int64
    do j = merge(1, -waves%most(2), i == 0), waves%most(2)
      amplitude_here = amplitude_of(waves, i, abs(j))
      if (amplitude_here == 0_int64) cycle
      do k = 1, 2
        part(k) = product_of(amplitude_here, drawn_number(waves%gaussian, i, j, k), &
                             amplitude_bits + draw_bits - waves%unit_bits)
      end do
      components(:, modulo(j, waves%period(2))) = part
      if (i == 0) components(:, waves%period(2) - j) = [part(1), -part(2)]
    end do

  contains

    ! A random number of a Gaussian of deviation 1, in 2**-draw_bits.
    pure integer(int64) function drawn_number(gaussian, x, y, which)
      type(truncated_normal), intent(in) :: gaussian
      integer, intent(in) :: x, y, which
      integer(int64) :: words(4)

      words = philox_block([int(x, int64), iand(int(y, int64), low_32), int(which, int64), &
                            stream], [int(waves%spec%seed, int64), 0_int64])
      drawn_number = draw_normal(gaussian, words(:3)) - whole_range / 2_int64
    end function drawn_number

  end subroutine draw_waves

  ! a b/2**bits, rounded.
  pure integer(int64) function product_of(a, b, bits)
    integer(int64), intent(in) :: a, b
    integer, intent(in) :: bits

    product_of = int(shifta(int(a, int128) * b + shiftl(1_int128, bits - 1), bits), int64)
  end function product_of

end module asperity_map_waves
