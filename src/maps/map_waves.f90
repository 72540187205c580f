!> Fourier components of a self-affine random height map.
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
!> The random numbers are whole numbers, the same on every machine; amplitudes are rounded.
module asperity_map_waves
  use asperity_generation_values, only: below_none, exact_value, map_spec, period_of
  use asperity_kinds, only: int64, real128, real64
  use asperity_random_philox, only: philox_block
  use asperity_truncated_normal, only: draw_normal, prepare_normal, truncated_normal, whole_range
  implicit none
  private

  public :: map_waves, plan_waves, draw_waves

  !> Range and spectrum of the components of a map.
  type :: map_waves
    integer :: period(2) = 0                 !! pixels of the periodic map along x and y
    integer :: most(2) = 0                   !! largest wave numbers along x and y
    real(real128) :: side(2) = 0.0_real128   !! lengths of the periodic map along x and y
    logical :: empty = .true.                !! no component has power
    integer(int64), private :: seed = 0_int64
    real(real64), private :: power = 0.0_real64          ! (1 + H)/2
    real(real64), private :: square(2) = 0.0_real64      ! (q/q_r)**2 of the wave numbers 1
    real(real64), private :: lowest = 0.0_real64         ! (q/q_r)**2 of the first component
    real(real64), private :: highest = 0.0_real64        ! (q/q_r)**2 of the last component
    type(truncated_normal), private :: gaussian
  end type map_waves

  ! A wavelength that differs from the roll-off or the cut-off by rounding alone is in the band.
  real(real128), parameter :: slack = 1.0e-12_real128
  ! Draws are cut off at so many deviations, beyond which the probability is 1.2e-15; a draw is a
  ! whole number of 2**-draw_bits.
  integer, parameter :: farthest = 8, draw_bits = 37
  ! Stream of the generator: surfaces have 1 to 6.
  integer(int64), parameter :: stream = 7_int64, low_32 = int(z'FFFFFFFF', int64)

contains

  !> Prepares the components of a map.
  pure subroutine plan_waves(spec, waves)
    type(map_spec), intent(in) :: spec    !! specification, checked for faults
    type(map_waves), intent(out) :: waves  !! tables to draw from
    real(real128) :: roll_off
    integer :: i

    waves%seed = int(spec%seed, int64)
    waves%period = period_of(spec%pixels, spec%periodic)
    waves%side = waves%period * exact_value(spec%pixel_spacing)
    ! A roll-off beyond the longest wave of the map changes no ratio of two components.
    roll_off = min(spec%roll_off, maxval(waves%side))
    waves%most = min(int(waves%side / spec%cut_off * (1 + slack)), (waves%period - 1) / 2)
    ! Along a side without waves the square is not needed, and may exceed the range of numbers.
    where (waves%most > 0) waves%square = real((roll_off / waves%side)**2, real64)
    waves%highest = real((roll_off / spec%cut_off)**2 * (1 + slack), real64)
    if (spec%below == below_none) &
      waves%lowest = real((roll_off / spec%roll_off)**2 * (1 - slack), real64)
    waves%power = real(1 + spec%hurst, real64) / 2
    call prepare_normal(-real(farthest, real128), real(farthest, real128), waves%gaussian)
    do i = 0, waves%most(1)
      waves%empty = .not. any(amplitudes_of(waves, i) > 0.0_real64)
      if (.not. waves%empty) exit
    end do
  end subroutine plan_waves

  ! Root of C(q)/C_0, for the wave numbers along y from 0 on; 0 for q = 0.
  pure function amplitudes_of(waves, i) result(amplitude)
    type(map_waves), intent(in) :: waves
    integer, intent(in) :: i  ! wave number along x, 0 or more
    real(real64) :: amplitude(0:waves%most(2)), square
    integer :: j

    amplitude = 0.0_real64
    do j = merge(1, 0, i == 0), waves%most(2)
      square = waves%square(1) * real(i, real64)**2 + waves%square(2) * real(j, real64)**2
      if (square >= waves%lowest .and. square <= waves%highest) &
        amplitude(j) = max(1.0_real64, square)**(-waves%power)
    end do
  end function amplitudes_of

  !> The components of one wave number along x.
  pure subroutine draw_waves(waves, i, components)
    type(map_waves), intent(in) :: waves            !! tables of `plan_waves`
    integer, intent(in) :: i                        !! wave number along x, 0 to `most(1)`
    complex(real64), intent(out) :: components(0:)  !! by wave number along y modulo the period
    real(real64) :: amplitude(0:waves%most(2))
    integer :: j

    components = (0.0_real64, 0.0_real64)
    amplitude = amplitudes_of(waves, i)
    do j = merge(1, -waves%most(2), i == 0), waves%most(2)
      if (.not. amplitude(abs(j)) > 0.0_real64) cycle
      associate (component => components(modulo(j, waves%period(2))))
        component = amplitude(abs(j)) * cmplx(drawn_number(i, j, 1), drawn_number(i, j, 2), real64)
        if (i == 0) components(waves%period(2) - j) = conjg(component)
      end associate
    end do

  contains

    ! A random number of a Gaussian of deviation 1.
    pure real(real64) function drawn_number(x, y, which)
      integer, intent(in) :: x, y, which
      integer(int64) :: words(4)

      words = philox_block([int(x, int64), iand(int(y, int64), low_32), int(which, int64), &
                            stream], [waves%seed, 0_int64])
      drawn_number = scale(real(draw_normal(waves%gaussian, words(:3)) - whole_range / 2_int64, &
                                real64), -draw_bits)
    end function drawn_number

  end subroutine draw_waves

end module asperity_map_waves
