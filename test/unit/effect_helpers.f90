!> What the suites of effects share: pairs of spheres, a plastic law, and comparisons.
module asperity_effect_helpers
  use asperity_contact_effect, only: contact_effect, effect_outcome
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_contact_state, only: contact_state
  use asperity_sphere_overlap, only: touching_height
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_first_yield, only: constraint_factor
  use asperity_plastic_law, only: plastic_law
  use asperity_testing, only: check
  implicit none
  private

  public :: pair_of, penetration_of, plastic_law_with
  public :: near, values_of
  public :: act

contains

  !> Lower centre at the origin, upper one at a distance in plan, first touch at zero.
  function pair_of(upper, lower, d, direction) result(pair)
    real(real64), intent(in) :: upper, lower  !! radii of the spheres, positive
    !> distance of the centres in plan, from 0 to less than the sum of the radii
    real(real64), intent(in) :: d
    !> unit vector from the lower centre to the upper one; (1, 0) without it
    real(real64), intent(in), optional :: direction(2)
    type(contact_pair) :: pair

    pair%upper_radius = upper
    pair%lower_radius = lower
    pair%upper_x = d
    if (present(direction)) then
      pair%upper_x = direction(1) * d
      pair%upper_y = direction(2) * d
    end if
    pair%s = upper + lower
    pair%d = d
    pair%radius = upper * lower / pair%s
    call touching_height(pair%s, d, pair%zc, pair%rest)
  end function pair_of

  !> The penetration of an overlap.
  function penetration_of(pair, overlap) result(p)
    type(contact_pair), intent(in) :: pair  !! the pair
    real(real64), intent(in) :: overlap     !! sum of the radii less the distance of the centres
    real(real64) :: p, z

    z = sqrt((pair%s - overlap - pair%d) * (pair%s - overlap + pair%d))
    p = overlap * (2.0_real64 * pair%s - overlap) / (pair%zc + z)
  end function penetration_of

  !> The law of one pair that flows, before its first loading.
  function plastic_law_with(poisson_ratio, modulus, critical) result(law)
    !> Poisson's ratio, combined elastic modulus, critical overlap
    real(real64), intent(in) :: poisson_ratio, modulus, critical
    type(plastic_law) :: law

    law%elastic = hertz_law(modulus=modulus)
    law%constraint = constraint_factor(poisson_ratio)
    allocate (law%critical(1), law%largest(1))
    law%critical = critical
    law%largest = 0.0_real64
  end function plastic_law_with

  !> One effect on one state, as the solver calls it.
  subroutine act(effect, pairs, state, outcome)
    class(contact_effect), intent(in) :: effect   !! the effect
    type(contact_pairs), intent(in) :: pairs      !! the position
    type(contact_state), intent(inout) :: state   !! without, then with the effect
    type(effect_outcome), intent(out) :: outcome  !! what it did

    call effect%apply(pairs, state, outcome)
    call effect%finish(pairs, state, outcome)
  end subroutine act

  !> Notes a failure unless a number is the expected one within a relative tolerance.
  subroutine near(found, expected, tolerance, message)
    !> the two numbers, and the largest difference as a share of the expected one
    real(real64), intent(in) :: found, expected, tolerance
    character(*), intent(in) :: message  !! what is compared

    call check(found, expected, tolerance * abs(expected), message)
  end subroutine near

  !> All numbers of an answer.
  pure function values_of(response) result(values)
    type(contact_response), intent(in) :: response  !! the answer
    real(real64) :: values(7)

    values = [response%overlap, response%contact_radius, response%load, response%cosine, &
              response%vertical_load, response%stiffness, response%maximum_pressure]
  end function values_of

end module asperity_effect_helpers
