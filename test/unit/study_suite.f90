!> Integrals of Greenwood, Williamson and Tripp. test/contact/test_study.py compares sections.
!>
!> Expected numbers come from mpmath (20 digits) by other ways than the code's: moments of the sum
!> of two heights as double integrals over both heights; contacts of two rough surfaces with the
!> offset itself as the variable; means over radii as double integrals over both radii.
module asperity_study_suite
  use asperity_decimal, only: decimal_value
  use asperity_gauss_rule, only: gauss_node, gauss_points, gauss_weight
  use asperity_generation_values, only: gaussian_spec
  use asperity_greenwood_integrals, only: densities_at, excess_moments, greenwood_law, &
                                          greenwood_law_of, means_over_radii, quantities
  use asperity_kinds, only: int64, real128, real64
  use asperity_method_study, only: on_front
  use asperity_study_spec, only: places_grid, study_spec
  use asperity_testing, only: check, run_test
  implicit none
  private

  public :: run_study

  ! The last of the 15 digits and more that mpmath gave, and some room.
  real(real64), parameter :: exact = 2.0e-15_real64

contains

  !> Runs the tests.
  subroutine run_study
    call run_test('heights without cut-offs: moments in closed form', gaussian_moments)
    call run_test('sum of two cut heights: moments by a double integral', sum_moments)
    call run_test('heights that do not vary', fixed_moments)
    call run_test('means over radii', radii_means)
    call run_test('Greenwood-Tripp: integral over the offset itself', two_rough)
    call run_test('Greenwood-Williamson against a plane', rough_on_plane)
    call run_test('Greenwood and Tripp''s own terms', shallow_terms)
    call run_test('Gauss''s rule: exact for polynomials', gauss)
    call run_test('Pareto front: the clock does not choose between equal methods', front)
    call run_test('moments 29 deviations out, and of widths 1 to 10000', moments_at_limits)
  end subroutine run_study

  !> Of n points it is right for powers below 2 n: the integral of x**k from 0 to 1 is 1/(k + 1).
  subroutine gauss
    integer :: k

    do k = 0, 2 * gauss_points - 1
      call check(abs(sum(gauss_weight * gauss_node**k) * (k + 1) - 1) < exact, 'a power')
    end do
    call check(abs(sum(gauss_weight * gauss_node**20) * 21 - 1) > 1.0e-13_real64, 'degree 20')
  end subroutine gauss

  !> Of methods of one error in times within 1.5 the first is taken, with the least time of them.
  subroutine front
    call check(all(on_front([1.4_real64, 1.0_real64, 1.6_real64], [0.1_real64, 0.1_real64, &
                                                                          0.105_real64]) &
                          .eqv. [.true., .false., .false.]), 'equal methods')
    call check(all(on_front([1.6_real64, 1.0_real64], [0.1_real64, 0.1_real64]) &
                          .eqv. [.false., .true.]), 'a faster method')
    call check(all(on_front([4.0_real64, 1.0_real64], [0.0_real64, 0.1_real64])), 'both')
  end subroutine front

  !> F_n(h) of Greenwood and Williamson: at 0 it is 2**(n/2) gamma((n + 1)/2)/(2 sqrt(pi)).
  subroutine gaussian_moments
    integer, parameter :: doubled(5) = [0, 2, 3, 4, 5]
    real(real64), parameter :: at_1(5) = &
      [0.158655253931_real64, 0.0833154705877_real64, 0.0756681773910_real64, &
       0.0753397833438_real64, 0.0805623355708_real64]
    real(real64), parameter :: at_3(5) = &
      [0.00134989803163_real64, 3.82154317048e-4_real64, 2.63967554269e-4_real64, &
       2.03435080487e-4_real64, 1.70872996214e-4_real64]
    real(real128) :: moments(5), power
    integer :: i

    ! Beyond 14 deviations there is nothing that a double would show.
    moments = excess_moments([gaussian(0, 1, -14.0_real128, 14.0_real128)], 0.0_real128, doubled)
    do i = 1, 5
      power = real(doubled(i), real128) / 2
      call check(real(moments(i), real64), &
                 real(2**(power / 2) * gamma((power + 1) / 2) / (2 * sqrt(acos(-1.0_real128))), &
                      real64), exact, 'F(0)')
    end do
    moments = excess_moments([gaussian(0, 1, -14.0_real128, 14.0_real128)], 1.0_real128, doubled)
    call check_all(real(moments, real64), at_1, 1.0e-11_real64, 'F(1)')
    moments = excess_moments([gaussian(0, 1, -14.0_real128, 14.0_real128)], 3.0_real128, doubled)
    call check_all(real(moments, real64), at_3, 1.0e-11_real64, 'F(3)')
  end subroutine gaussian_moments

  subroutine sum_moments
    real(real64), parameter :: separations(4) = [0.15_real64, 0.22_real64, 0.3_real64, 0.355_real64]
    real(real64), parameter :: expected(5, 4) = reshape([ &
      0.12305888523497826_real64, 0.016002629124739525_real64, 0.005879702610612601_real64, &
      0.0021851010217999201_real64, 8.2073450122119118e-4_real64, &
      0.053154309998926207_real64, 0.0036737499190270438_real64, 0.001019331264885785_real64, &
      2.905196147532247e-4_real64, 8.467793596824767e-5_real64, &
      0.0031021551904182272_real64, 7.8537719954691508e-5_real64, 1.3653099562722894e-5_real64, &
      2.4704811139824768e-6_real64, 4.6137750789413194e-7_real64, &
      2.0468546620032781e-7_real64, 3.1364366032105945e-10_real64, 1.3249517422197298e-11_real64, &
      5.7891412201831397e-13_real64, 2.5969544403278447e-14_real64], [5, 4])

    call compare_sums([upper_heights(), lower_heights()], separations, expected)
  end subroutine sum_moments

  !> The tail beyond 29 deviations, and a sum whose parts differ 10000-fold in width: below its
  !> kinks, and between the last two of them.
  subroutine moments_at_limits
    real(real64), parameter :: tail(5) = &
      [0.0080318059732192362149_real64, 0.00055101464444826685868_real64, &
       0.00016950355545899944082_real64, 0.000056636525215494428566_real64, &
       0.000020314486898669850615_real64]
    real(real64), parameter :: sums(5, 2) = reshape([ &
      8.4906988041970182315e-4_real64, 5.7687098712126370852e-5_real64, &
      1.7151152253210383921e-5_real64, 5.4438808225097543137e-6_real64, &
      1.8255475958945043818e-6_real64, &
      2.2893331453406606625e-19_real64, 1.8493217618628256104e-24_real64, &
      5.9634134787850811668e-27_real64, 2.046891806080600732e-29_real64, &
      7.4033496176322419282e-32_real64], [5, 2])
    real(real128) :: moments(5)
    integer :: i

    moments = excess_moments([gaussian(0, 1, 29.0_real128, 30.3_real128)], 29.05_real128, &
                             [2, 4, 5, 6, 7])
    call check_all(real(moments, real64), tail, exact, 'tail')
    do i = 1, 2
      moments = excess_moments(&
        [wide(100, 100, -5000, 7000), &
         gaussian_decimal(decimal_value(2_int64, -1), decimal_value(1_int64, -5), &
                          0.19995_real128, 0.20006_real128)], &
        merge(0.5_real128, 0.90001_real128, i == 1), [2, 4, 5, 6, 7])
      call check_all(real(moments, real64), sums(:, i), exact, 'sum')
    end do
  end subroutine moments_at_limits

  subroutine compare_sums(heights, separations, expected)
    type(gaussian_spec), intent(in) :: heights(2)
    real(real64), intent(in) :: separations(:), expected(:, :)
    real(real128) :: moments(5), separation
    integer :: i

    do i = 1, size(separations)
      ! Thousandths, exactly.
      separation = nint(1000 * separations(i)) / 1000.0_real128
      moments = excess_moments(heights, separation, [2, 4, 5, 6, 7])
      call check_all(real(moments, real64), expected(:, i), exact, 'moment')
      moments = excess_moments(heights(2:1:-1), separation, [2, 4, 5, 6, 7])
      call check_all(real(moments, real64), expected(:, i), exact, 'moment, exchanged')
    end do
  end subroutine compare_sums

  !> Without spread: a power. A part that does not vary only moves the other one.
  subroutine fixed_moments
    type(gaussian_spec) :: fixed
    real(real128) :: moments(2), moved(2)

    fixed = gaussian(3, 0, 3.0_real128, 3.0_real128)
    moments = excess_moments([fixed], 1.0_real128, [2, 5])
    call check_all(real(moments, real64), [2.0_real64, sqrt(32.0_real64)], exact, 'one')
    moments = excess_moments([fixed, fixed], 7.0_real128, [2, 5])
    call check_all(real(moments, real64), [0.0_real64, 0.0_real64], exact, 'out of reach')
    moments = excess_moments([fixed, upper_heights()], 3.13_real128, [2, 5])
    moved = excess_moments([upper_heights()], 0.13_real128, [2, 5])
    call check_all(real(moments, real64), real(moved, real64), exact, 'moved')
  end subroutine fixed_moments

  subroutine radii_means
    real(real128) :: means(quantities, 2)
    type(gaussian_spec) :: radii(2)

    radii = [wide(1000, 200, 6000, 16000), wide(800, 100, 5000, 11000)]
    means = means_over_radii(radii)
    call check_all(real([means(:3, 1), means(2:3, 2)], real64), &
                   [1.8101565979349758_real64, 0.80812527834798064_real64, &
                    1.2076935140472496_real64, 0.44097665386191635_real64, &
                    0.66305501604704309_real64], exact, 'mean')
    means = means_over_radii(radii(:1))
    call check_all(real(means(2:3, 1), real64), &
                   [1.0101565979349758_real64, 1.0007175525050815_real64], exact, 'against a plane')
  end subroutine radii_means

  subroutine two_rough
    type(study_spec) :: spec
    type(greenwood_law) :: law

    call fill(spec)
    law = greenwood_law_of(spec%surfaces, spec%elastic_modulus, spec%poisson_ratio, .false.)
    call check_all(densities_at(law, 0.2_real64), &
                   [0.2152760161925759_real64, 0.01393685402762784_real64, &
                    168.8945684104764_real64, 166.5325103185897_real64], exact, 'at 0.2')
    call check_all(densities_at(law, 0.3_real64), &
                   [0.009274963095681208_real64, 1.803067584175419e-4_real64, &
                    1.254885849497894_real64, 1.24896362379921_real64], 2 * exact, 'at 0.3')
  end subroutine two_rough

  subroutine rough_on_plane
    type(study_spec) :: spec
    type(greenwood_law) :: law

    call fill(spec)
    law = greenwood_law_of(spec%surfaces, spec%elastic_modulus, spec%poisson_ratio, .true.)
    call check_all(densities_at(law, 0.13_real64), &
                   [0.296774672247378_real64, 0.02078379014090802_real64, &
                    99.87495107344976_real64, 99.87495107344976_real64], exact, 'at 0.13')
  end subroutine rough_on_plane

  !> Greenwood and Tripp 1970-71, equal surfaces of radius b: area pi**2 (n b)**2 F_2, load
  !> (16 sqrt(2)/15) pi n**2 E b**(3/2) F_5/2.
  subroutine shallow_terms
    type(study_spec) :: spec
    type(greenwood_law) :: law
    real(real64) :: values(quantities), load
    real(real64), parameter :: pi = acos(-1.0_real64)
    real(real64), parameter :: modulus = 275760.0_real64 / (2 * 0.8236_real64)
    real(real128) :: moments(2)
    integer :: side

    call fill(spec)
    do side = 1, 2
      spec%surfaces%sides(side) = spec%surfaces%sides(1)
      spec%elastic_modulus(side) = spec%elastic_modulus(1)
      spec%poisson_ratio(side) = spec%poisson_ratio(1)
    end do
    law = greenwood_law_of(spec%surfaces, spec%elastic_modulus, spec%poisson_ratio, .false.)
    law%density = 0.5_real64
    moments = excess_moments(law%heights, 0.25_real128, [4, 5])
    values = densities_at(law, 0.25_real64, shallow=.true.)
    load = 16 * sqrt(2.0_real64) / 15 * pi * 0.25_real64 * modulus * 1.27_real64**1.5_real64 * &
           real(moments(2), real64)
    call check_all(values(2:), [(pi * 0.5_real64 * 1.27_real64)**2 * &
                                       real(moments(1), real64), load, load], exact, 'published')
  end subroutine shallow_terms

  !> The surfaces of the tests: 765 and 774 asperities on 40 by 40.
  subroutine fill(spec)
    type(study_spec), intent(out) :: spec
    integer :: side

    spec%surfaces%file = 'test'
    spec%text = 'test'
    spec%surfaces%ensemble = 40
    do side = 1, 2
      spec%surfaces%sides(side)%number = merge(765, 774, side == 1)
      spec%surfaces%sides(side)%length = decimal_value(40_int64, 0)
      spec%surfaces%sides(side)%width = decimal_value(40_int64, 0)
      spec%surfaces%sides(side)%height = merge(upper_heights(), lower_heights(), side == 1)
    end do
    spec%surfaces%sides(1)%radius = gaussian_decimal(decimal_value(127_int64, -2), &
                                                     decimal_value(), 1.27_real128, 1.27_real128)
    spec%surfaces%sides(2)%radius = gaussian_decimal(decimal_value(8_int64, -1), &
                                                     decimal_value(), 0.8_real128, 0.8_real128)
    spec%elastic_modulus = [decimal_value(275760_int64, 0), decimal_value(100000_int64, 0)]
    spec%poisson_ratio = [decimal_value(42_int64, -2), decimal_value(3_int64, -1)]
    spec%separation = decimal_value(2_int64, -1)
    spec%steps = 3
    spec%places = places_grid
    allocate (spec%sizes(0))
  end subroutine fill

  pure type(gaussian_spec) function upper_heights()
    upper_heights = gaussian_decimal(decimal_value(127_int64, -3), decimal_value(3048_int64, -5), &
                                     0.111_real128, 0.1722_real128)
  end function upper_heights

  pure type(gaussian_spec) function lower_heights()
    lower_heights = gaussian_decimal(decimal_value(12_int64, -2), decimal_value(5_int64, -2), &
                                     0.0955_real128, 0.1859_real128)
  end function lower_heights

  !> Mean and deviation in thousandths, cut-offs in ten-thousandths.
  pure type(gaussian_spec) function wide(mean, deviation, lowest, highest)
    integer, intent(in) :: mean, deviation, lowest, highest

    wide = gaussian_decimal(decimal_value(int(mean, int64), -3), &
                            decimal_value(int(deviation, int64), -3), lowest / 1.0e4_real128, &
                            highest / 1.0e4_real128)
  end function wide

  pure type(gaussian_spec) function gaussian(mean, deviation, lowest, highest)
    integer, intent(in) :: mean, deviation
    real(real128), intent(in) :: lowest, highest

    gaussian = gaussian_decimal(decimal_value(int(mean, int64), 0), &
                                decimal_value(int(deviation, int64), 0), lowest, highest)
  end function gaussian

  pure type(gaussian_spec) function gaussian_decimal(mean, deviation, lowest, highest)
    type(decimal_value), intent(in) :: mean, deviation
    real(real128), intent(in) :: lowest, highest

    gaussian_decimal%mean = mean
    gaussian_decimal%deviation = deviation
    gaussian_decimal%lowest = lowest
    gaussian_decimal%highest = highest
  end function gaussian_decimal

  !> Compares numbers with a relative tolerance.
  subroutine check_all(found, expected, tolerance, message)
    real(real64), intent(in) :: found(:), expected(:), tolerance
    character(len=*), intent(in) :: message
    integer :: i

    do i = 1, size(expected)
      call check(found(i), expected(i), tolerance * abs(expected(i)), message)
    end do
  end subroutine check_all

end module asperity_study_suite
