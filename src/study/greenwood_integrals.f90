!> Contact of large rough surfaces by integrals over their statistics.
!>
!> One rough surface against a plane: J. A. Greenwood, J. B. P. Williamson, "Contact of nominally
!> flat surfaces", Proc. R. Soc. Lond. A 295 (1966) 300-319. Two rough surfaces whose asperities
!> meet at any offset: J. A. Greenwood, J. H. Tripp, "The contact of two nominally flat rough
!> surfaces", Proc. Inst. Mech. Engrs 185 (1970-71) 625-633. Here heights have cut-offs, radii may
!> vary, and the spheres of two surfaces are spheres, not paraboloids: with t the sum of the
!> heights above the separation, s the sum of the radii and W the overlap, an offset d holds
!> d**2 = (s - W)**2 - (s - t)**2, so that the integral over d is one over W:
!> 2 pi d dd = 2 pi (s - W) dW, W from 0 to t. It is done in closed form; what is left is the mean
!> of t**k. The terms of the lowest power of t are those of Greenwood and Tripp.
!>
!> The sum of two cut Gaussians has a closed density: that of the sum without cut-offs times the
!> probability that both parts lie between their cut-offs, given the sum. Integrals are by Gauss's
!> rule on equal pieces between the kinks of the density. The density is in 113 bits: near the
!> highest summit and in the tails a double would lose digits.
module asperity_greenwood_integrals
  use asperity_constants, only: pi => pi_128
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_gauss_rule, only: gauss_node, gauss_weight
  use asperity_generation_values, only: exact_value, gaussian_spec, generation_spec
  use asperity_kinds, only: real128, real64
  use asperity_root_bracket, only: guess_root, narrow_bracket, root_bracket
  implicit none
  private

  public :: greenwood_law, greenwood_law_of, densities_at, separation_at_pressure
  public :: excess_moments, means_over_radii
  public :: quantities, contacts_per_area, area_per_area, load_per_area, vertical_per_area

  integer, parameter :: quantities = 4        !! what there is of on an area
  integer, parameter :: contacts_per_area = 1  !! number of contacts
  integer, parameter :: area_per_area = 2     !! contact area
  integer, parameter :: load_per_area = 3     !! sum of the forces normal to the contacts
  integer, parameter :: vertical_per_area = 4  !! sum of their vertical parts: the mean pressure

  ! Pieces of Gauss's rule between two kinks of the density of heights: below the rounding of a
  ! double. `moments_at_limits` of `test/unit/study_suite.f90` holds the moments.
  integer, parameter :: pieces_of_heights = 24

  !> The statistics of two surfaces, or of one against a plane.
  type :: greenwood_law
    private
    logical :: with_plane = .false.
    type(gaussian_spec), public :: heights(2)            !! of summits; of a plane all are 0
    real(real128) :: radii(quantities, 2) = 0.0_real128  ! by `means_over_radii`
    real(real128) :: modulus = 0.0_real128
    real(real64), public :: density(2) = 0.0_real64  !! asperities per area, upper and lower
    real(real64), public :: highest = 0.0_real64     !! largest height, or sum of two
    real(real64), public :: least_sum = 0.0_real64   !! least sum of the radii of a pair
  end type greenwood_law

contains

  !> The statistics of a specification.
  pure function greenwood_law_of(spec, elastic_modulus, poisson_ratio, with_plane) result(law)
    type(generation_spec), intent(in) :: spec               !! checked specification of surfaces
    type(decimal_value), intent(in) :: elastic_modulus(2)   !! of upper and lower surface
    type(decimal_value), intent(in) :: poisson_ratio(2)     !! of upper and lower surface
    logical, intent(in) :: with_plane                       !! the upper surface against a plane
    type(greenwood_law) :: law
    real(real128) :: ratio(2)

    law%with_plane = with_plane
    associate (rough => spec%sides(:merge(1, 2, with_plane)))
      law%heights(:size(rough)) = rough%height
      law%highest = real(sum(rough%height%highest), real64)
      law%radii = means_over_radii(rough%radius)
      law%least_sum = real(sum(rough%radius%lowest), real64)
    end associate
    law%density = spec%sides%number / &
                  (decimal_to_real64(spec%sides%length) * decimal_to_real64(spec%sides%width))
    ratio = decimal_to_real64(poisson_ratio)
    law%modulus = 1 / sum((1 - ratio) * (1 + ratio) / &
                          real(decimal_to_real64(elastic_modulus), real128))
  end function greenwood_law_of

  !> Contacts, area and loads of large surfaces over their area, at a separation of the reference
  !> planes at which no pair of spheres could come level.
  pure function densities_at(law, separation, shallow) result(values)
    type(greenwood_law), intent(in) :: law         !! statistics of the surfaces
    real(real64), intent(in) :: separation         !! separation of the planes [length]
    logical, intent(in), optional :: shallow       !! only the terms of Greenwood and Tripp
    real(real64) :: values(quantities)             !! contacts_per_area and so on
    real(real128) :: found(quantities), terms(quantities, 2)
    real(real128), parameter :: divisors(quantities, 2) = reshape( &
      [1.0_real128, 2.0_real128, 2.5_real128, 2.5_real128, &
       2.0_real128, 3.0_real128, 3.5_real128, 2.5_real128], [quantities, 2])

    if (law%with_plane) then
      found = law%density(1) * law%radii(:, 1) * &
              excess_moments(law%heights, real(separation, real128), [0, 2, 3, 3])
    else
      ! Loads differ by the cosine of the slope, (s - t)/(s - W).
      terms = law%radii / divisors * reshape( &
        excess_moments(law%heights, real(separation, real128), [2, 4, 5, 5, 4, 6, 7, 7]), &
        shape(terms))
      if (present(shallow)) terms(:, 2) = merge(0.0_real128, terms(:, 2), shallow)
      found = 2 * pi * law%density(1) * law%density(2) * (terms(:, 1) - terms(:, 2))
    end if
    found = found * [1.0_real128, pi, 4 * law%modulus / 3, 4 * law%modulus / 3]
    ! Beyond the doubles, as with a modulus of 1E308: the largest of them, without an overflow.
    values = real(min(found, real(huge(values), real128)), real64)

  end function densities_at

  !> The separation at which large surfaces bear a mean pressure. `failure` is allocated when they
  !> would have to come so near that pairs penetrate by more than half the sum of their radii.
  pure subroutine separation_at_pressure(law, pressure, separation, failure)
    type(greenwood_law), intent(in) :: law                 !! statistics of the surfaces
    real(real64), intent(in) :: pressure                   !! mean pressure, more than 0
    real(real64), intent(out) :: separation                !! of the reference planes
    character(len=:), allocatable, intent(out) :: failure  !! reason of a failure
    type(root_bracket) :: bracket
    real(real64) :: deepest, place, residual, values(quantities)
    logical :: inside

    ! A place is how far down, and the deepest once more: so a middle is no mean by ratio.
    deepest = law%least_sum / 2
    bracket = root_bracket(low=deepest, high=2 * deepest, low_miss=-1.0_real64, &
                           high_miss=-1.0_real64)
    place = bracket%high
    inside = .true.
    do while (inside)
      separation = law%highest - (place - deepest)
      values = densities_at(law, separation)
      residual = log(max(values(vertical_per_area), tiny(residual))) - log(pressure)
      if (place >= 2 * deepest .and. residual < 0.0_real64) then
        failure = 'the pressure is more than the surfaces carry before asperities ' // &
                  'penetrate by half the sum of their radii'
        return
      end if
      if (abs(residual) <= epsilon(residual)) return
      call narrow_bracket(bracket, place, residual, residual < 0.0_real64)
      call guess_root(bracket, place, inside)
    end do
  end subroutine separation_at_pressure

  !> Integral of (u - separation)**power times the density over the heights u above the separation.
  !> Powers are given doubled, as 5 for 5/2.
  pure function excess_moments(heights, separation, doubled_powers) result(moments)
    type(gaussian_spec), intent(in) :: heights(:)     !! one height, or two whose sum u is
    real(real128), intent(in) :: separation           !! separation of the planes [length]
    integer, intent(in) :: doubled_powers(:)          !! twice the powers, 0 or more
    real(real128) :: moments(size(doubled_powers))    !! moments, as many [length**power]
    type(gaussian_spec), allocatable :: part(:)
    real(real128), allocatable :: v(:), weights(:), mean(:), deviation(:)
    real(real128) :: kinks(4), least, mass
    integer :: i, k

    moments = 0.0_real128
    ! A height that does not vary only moves the other one.
    part = pack(heights, heights%highest > heights%lowest)
    least = separation - sum(heights%lowest, .not. heights%highest > heights%lowest)
    if (size(part) == 0 .and. least < 0) moments = sqrt(-least)**doubled_powers
    if (size(part) == 0 .or. .not. sum(part%highest) > least) return
    mean = exact_value(part%mean)
    deviation = exact_value(part%deviation)
    mass = product(normal_probability((part%lowest - mean) / deviation, &
                                      (part%highest - mean) / deviation))
    ! The density has kinks where a cut-off of one part meets one of the other. With
    ! u = least + v**2 the integrand has no root at its end.
    associate (width => part%highest - part%lowest)
      kinks = sum(part%lowest) + [0.0_real128, minval(width), maxval(width), sum(width)]
    end associate
    do i = 1, 3
      if (.not. kinks(i + 1) > max(kinks(i), least)) cycle
      call place_points(sqrt(max(kinks(i), least) - least), sqrt(kinks(i + 1) - least), &
                        pieces_of_heights, v, weights)
      do k = 1, size(v)
        moments = moments + 2 * weights(k) * density_at(least + v(k)**2) * &
                  v(k)**(doubled_powers + 1)
      end do
    end do

  contains

    !> Density of the varying heights, or of their sum.
    pure real(real128) function density_at(u)
      real(real128), intent(in) :: u
      real(real128) :: sum_deviation, z, first

      sum_deviation = sqrt(sum(deviation**2))
      z = (u - sum(mean)) / sum_deviation
      density_at = exp(-z**2 / 2) / (sqrt(2 * pi) * sum_deviation * mass)
      if (size(part) == 1) return
      ! The first part has this mean, given the sum, and the deviation product/sum_deviation.
      first = mean(1) + z * deviation(1)**2 / sum_deviation
      density_at = density_at * normal_probability( &
        (max(part(1)%lowest, u - part(2)%highest) - first) * sum_deviation / product(deviation), &
        (min(part(1)%highest, u - part(2)%lowest) - first) * sum_deviation / product(deviation))
    end function density_at

  end function excess_moments

  !> Probability of the normal distribution between two places; by the tails on the far side of 0,
  !> where a difference loses no digits.
  elemental real(real128) function normal_probability(from, to)
    real(real128), intent(in) :: from, to
    real(real128), parameter :: root = sqrt(2.0_real128)

    if (from > 0) then
      normal_probability = (erfc(from / root) - erfc(to / root)) / 2
    else if (to < 0) then
      normal_probability = (erfc(-to / root) - erfc(-from / root)) / 2
    else
      normal_probability = 1 - (erfc(-from / root) + erfc(to / root)) / 2
    end if
  end function normal_probability

  !> Means over pairs of radii r1 and r2, with s = r1 + r2 and R = r1 r2/s: of 1, R, sqrt(R) and
  !> sqrt(R) in column 2, and of these times s in column 1. Against a plane s is 1, and R is r1.
  pure function means_over_radii(radii) result(means)
    type(gaussian_spec), intent(in) :: radii(:)  !! one, or of the upper and the lower surface
    real(real128) :: means(quantities, 2)        !! means over all pairs
    real(real128), allocatable :: upper(:), lower(:), weights(:), lower_weights(:)
    real(real128) :: s, combined, terms(quantities)
    integer :: i, j

    call weigh_radii(radii(1), upper, weights)
    call weigh_radii(radii(size(radii)), lower, lower_weights)
    means = 0.0_real128
    do i = 1, size(upper)
      do j = 1, size(lower)
        s = upper(i) + lower(j)
        combined = upper(i) * lower(j) / s
        if (size(radii) == 1) then
          s = 1.0_real128
          combined = upper(i)
        end if
        terms = weights(i) * lower_weights(j) * &
                [1.0_real128, combined, sqrt(combined), sqrt(combined)]
        means = means + reshape([terms * s, terms], [quantities, 2])
      end do
    end do
  end function means_over_radii

  !> Radii of a distribution and their weights, whose sum is 1, on pieces of at most a deviation.
  !> The integrals are over the root of the radius: sqrt(R) has no root there.
  pure subroutine weigh_radii(radius, places, weights)
    type(gaussian_spec), intent(in) :: radius
    real(real128), allocatable, intent(out) :: places(:), weights(:)
    real(real128), allocatable :: roots(:)
    real(real128) :: deviation

    if (.not. radius%highest > radius%lowest) then
      places = [radius%lowest]
      weights = [1.0_real128]
      return
    end if
    deviation = exact_value(radius%deviation)
    call place_points(sqrt(radius%lowest), sqrt(radius%highest), &
                      max(4, ceiling(2 * (radius%highest - radius%lowest) / deviation)), roots, &
                      weights)
    places = roots**2
    weights = weights * roots * exp(-((places - exact_value(radius%mean)) / deviation)**2 / 2)
    weights = weights / sum(weights)
  end subroutine weigh_radii

  !> Places and weights of Gauss's rule on equal pieces between two places.
  pure subroutine place_points(from, to, pieces, places, weights)
    real(real128), intent(in) :: from, to
    integer, intent(in) :: pieces
    real(real128), allocatable, intent(out) :: places(:), weights(:)
    integer :: i

    places = [(from + (i - 1 + real(gauss_node, real128)) * (to - from) / pieces, i=1, pieces)]
    weights = [(gauss_weight * (to - from) / pieces, i=1, pieces)]
  end subroutine place_points

end module asperity_greenwood_integrals
