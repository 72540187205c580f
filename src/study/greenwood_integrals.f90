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
module asperity_greenwood_integrals
  use asperity_constants, only: pi => pi_128
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_generation_values, only: gaussian_spec, generation_spec
  use asperity_greenwood_moments, only: excess_moments, height_law, law_of_heights, &
                                        means_over_radii, radius_means
  use asperity_kinds, only: real128, real64
  use asperity_root_bracket, only: guess_root, narrow_bracket, root_bracket
  implicit none
  private

  public :: greenwood_law, greenwood_law_of, densities_at, separation_at_pressure
  public :: quantities, contacts_per_area, area_per_area, load_per_area, vertical_per_area

  integer, parameter :: quantities = 4        !! what there is of on an area
  integer, parameter :: contacts_per_area = 1  !! number of contacts
  integer, parameter :: area_per_area = 2     !! contact area
  integer, parameter :: load_per_area = 3     !! sum of the forces normal to the contacts
  integer, parameter :: vertical_per_area = 4  !! sum of their vertical parts: the mean pressure

  !> The statistics of two surfaces, or of one against a plane.
  type :: greenwood_law
    private
    logical :: with_plane = .false.
    type(height_law), public :: heights                !! of a summit, or of the sum of two
    type(radius_means) :: radii
    real(real128) :: modulus = 0.0_real128
    real(real64), public :: density(2) = 0.0_real64    !! asperities per area, upper and lower
    real(real128), public :: least_sum = 0.0_real128   !! least sum of the radii of a pair
  end type greenwood_law

contains

  !> The statistics of a specification.
  pure function greenwood_law_of(spec, elastic_modulus, poisson_ratio, with_plane) result(law)
    type(generation_spec), intent(in) :: spec               !! checked specification of surfaces
    type(decimal_value), intent(in) :: elastic_modulus(2)   !! of upper and lower surface
    type(decimal_value), intent(in) :: poisson_ratio(2)     !! of upper and lower surface
    logical, intent(in) :: with_plane                       !! the upper surface against a plane
    type(greenwood_law) :: law
    type(gaussian_spec) :: heights(2), radii(2)
    real(real128) :: ratio(2), modulus(2)
    integer :: side

    law%with_plane = with_plane
    heights = spec%sides%height
    radii = spec%sides%radius
    law%heights = law_of_heights(heights(:merge(1, 2, with_plane)))
    call means_over_radii(radii, law%radii)
    law%least_sum = sum(spec%sides%radius%lowest)
    if (with_plane) law%least_sum = spec%sides(1)%radius%lowest
    do side = 1, 2
      ratio(side) = real(decimal_to_real64(poisson_ratio(side)), real128)
      modulus(side) = real(decimal_to_real64(elastic_modulus(side)), real128)
      law%density(side) = real(spec%sides(side)%number, real64) / &
                          (decimal_to_real64(spec%sides(side)%length) * &
                           decimal_to_real64(spec%sides(side)%width))
    end do
    law%modulus = 1 / sum((1 - ratio) * (1 + ratio) / modulus)
  end function greenwood_law_of

  !> Contacts, area and loads of large surfaces over their area, at a separation of the reference
  !> planes at which no pair of spheres could come level.
  pure function densities_at(law, separation, shallow) result(values)
    type(greenwood_law), intent(in) :: law         !! statistics of the surfaces
    real(real64), intent(in) :: separation         !! separation of the planes [length]
    logical, intent(in), optional :: shallow       !! only the terms of Greenwood and Tripp
    real(real64) :: values(quantities)             !! contacts_per_area and so on
    real(real128) :: moments(5), found(quantities), pairs, beyond
    integer, parameter :: doubled_powers(5) = [2, 4, 5, 6, 7]

    if (law%with_plane) then
      call excess_moments(law%heights, real(separation, real128), [0, 2, 3], moments(:3))
      pairs = real(law%density(1), real128)
      found(contacts_per_area) = pairs * moments(1)
      found(area_per_area) = pairs * pi * law%radii%upper * moments(2)
      found(load_per_area) = pairs * 4 * law%modulus * law%radii%root_upper * moments(3) / 3
      found(vertical_per_area) = found(load_per_area)
    else
      call excess_moments(law%heights, real(separation, real128), doubled_powers, moments)
      beyond = 1.0_real128
      if (present(shallow)) beyond = merge(0.0_real128, 1.0_real128, shallow)
      pairs = real(law%density(1), real128) * real(law%density(2), real128)
      associate (t => moments(1), t_2 => moments(2), t_5_2 => moments(3), t_3 => moments(4), &
                 t_7_2 => moments(5), radii => law%radii)
        found(contacts_per_area) = 2 * pi * pairs * (radii%radius_sum * t - beyond * t_2 / 2)
        found(area_per_area) = 2 * pi**2 * pairs * &
                               (radii%radius_product * t_2 / 2 - beyond * radii%combined * t_3 / 3)
        pairs = 8 * pi / 3 * law%modulus * pairs
        found(load_per_area) = pairs * (radii%root_sum * t_5_2 / 2.5_real128 - &
                                        beyond * radii%root * t_7_2 / 3.5_real128)
        ! The cosine of the slope is (s - t)/(s - W).
        found(vertical_per_area) = pairs * (radii%root_sum * t_5_2 - &
                                            beyond * radii%root * t_7_2) / 2.5_real128
      end associate
    end if
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
    deepest = real(law%least_sum, real64) / 2
    bracket = root_bracket(low=deepest, high=2 * deepest, low_miss=-1.0_real64, &
                           high_miss=-1.0_real64)
    place = bracket%high
    inside = .true.
    do while (inside)
      separation = real(law%heights%highest, real64) - (place - deepest)
      values = densities_at(law, separation)
      residual = log(max(values(vertical_per_area), tiny(residual))) - log(pressure)
      if (place >= 2 * deepest .and. residual < 0.0_real64) then
        failure = 'the pressure is more than the surfaces carry before asperities ' // &
            'penetrate by ' // &
                  'half the sum of their radii'
        return
      end if
      if (abs(residual) <= epsilon(residual)) return
      call narrow_bracket(bracket, place, residual, residual < 0.0_real64)
      call guess_root(bracket, place, inside)
    end do
  end subroutine separation_at_pressure

end module asperity_greenwood_integrals
