!> The pairs of one position that touch or may touch, for the effects.
!>
!> Numbers are doubles in the solver's own units: lengths in 2**length_power of the scene's unit,
!> near the largest radius, and the combined modulus in 2**modulus_power. So all are near 1.
module asperity_contact_pairs
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
  use asperity_element_pressures, only: element_pressures
  use asperity_interruption, only: interruption
  use asperity_kinds, only: real64
  use asperity_theory_limits, only: theory_limits
  use asperity_work_count, only: work_count
  implicit none
  private

  public :: contact_pair, contact_pairs, in_scene_units, scaled_to_real64

  ! Least exponent of a result: below it a double is 0.
  integer, parameter :: least_exponent = minexponent(1.0_real64) - digits(1.0_real64)

  !> One upper and one lower asperity, or one asperity and a plane.
  type :: contact_pair
    integer :: upper = 0                            !! index of the upper asperity; 0: a plane
    integer :: lower = 0                            !! index of the lower asperity; 0: a plane
    real(real64) :: x = 0.0_real64                  !! point in plan where they touch first
    real(real64) :: y = 0.0_real64                  !! point in plan where they touch first
    real(real64) :: upper_x = 0.0_real64            !! centre of the upper sphere, displaced
    real(real64) :: upper_y = 0.0_real64            !! centre of the upper sphere, displaced
    real(real64) :: upper_radius = 0.0_real64       !! radius of the sphere; 0: a plane
    real(real64) :: upper_height = 0.0_real64       !! height of its summit above its plane
    real(real64) :: lower_x = 0.0_real64            !! centre of the lower sphere
    real(real64) :: lower_y = 0.0_real64            !! centre of the lower sphere
    real(real64) :: lower_radius = 0.0_real64       !! radius of the sphere; 0: a plane
    real(real64) :: lower_height = 0.0_real64       !! height of its summit above its plane
    real(real64) :: gap = 0.0_real64                !! compression at first touch, 0 for the first
    real(real64) :: limit = huge(1.0_real64)        !! penetration at the limit; huge: none
    real(real64) :: d = 0.0_real64                  !! distance of the centres in plan
    real(real64) :: s = 0.0_real64                  !! sum of the radii
    real(real64) :: zc = 0.0_real64                 !! height between the centres at first touch
    real(real64) :: rest = 0.0_real64               !! rounding error of zc
    real(real64) :: radius = 0.0_real64             !! combined, 1/R = 1/RU + 1/RL
  end type contact_pair

  !> The pairs of one position in the order of first touch.
  type :: contact_pairs
    real(real64) :: modulus = 0.0_real64            !! combined: 1/E = (1-nu1^2)/E1 + (1-nu2^2)/E2
    integer :: modulus_power = 0                    !! unit of the modulus is 2**modulus_power
    integer :: length_power = 0                     !! unit of length is 2**length_power
    type(contact_pair), allocatable :: list(:)      !! ascending gap
    real(real64) :: first_touch = 0.0_real64        !! separation at which the first pair touches
    real(real64) :: complete_to = huge(1.0_real64)  !! largest compression with all pairs listed
    real(real64) :: compression = 0.0_real64            !! compression without interaction
    type(theory_limits) :: limits                   !! limits of the theories
    real(real64) :: target = 0.0_real64             !! prescribed load, modulus times length**2
    logical :: vertical = .false.                   !! prescribed loads are vertical loads
    real(real64) :: x_displacement = 0.0_real64     !! of the upper surface, in the scene's unit
    real(real64) :: y_displacement = 0.0_real64     !! of the upper surface, in the scene's unit
    type(interruption) :: interrupt                 !! ends the solve of the position when set
    type(work_count) :: progress_count              !! counts the states that are done
    !> Gets the pressures of each solve by boundary elements; not associated: they are not kept.
    type(element_pressures), pointer :: pressures => null()
  end type contact_pairs

contains

  !> A number in the unit of the scene, given the powers of modulus and length in its unit: 1 and 2
  !> for a load.
  elemental function in_scene_units(pairs, number, modulus_power, length_power) result(value)
    type(contact_pairs), intent(in) :: pairs  !! pairs with the solver's units
    real(real64), intent(in) :: number        !! in the solver's units
    integer, intent(in) :: modulus_power      !! power of the modulus in the unit
    integer, intent(in) :: length_power       !! power of the length in the unit
    real(real64) :: value

    value = scaled_to_real64(number, modulus_power * pairs%modulus_power + &
                                     length_power * pairs%length_power)
  end function in_scene_units

  !> A number times 2**power. A result out of the range of doubles, by overflow or underflow, is
  !> infinite, without a trap; `are_finite` finds it.
  elemental real(real64) function scaled_to_real64(number, power) result(value)
    real(real64), intent(in) :: number  !! any finite number
    integer, intent(in) :: power        !! power of 2

    if (abs(number) > 0.0_real64 .and. (exponent(number) + power > maxexponent(value) .or. &
                                        exponent(number) + power < least_exponent)) then
      value = sign(ieee_value(value, ieee_positive_inf), number)
    else
      value = scale(number, power)
    end if
  end function scaled_to_real64

end module asperity_contact_pairs
