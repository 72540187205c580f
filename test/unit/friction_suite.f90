!> Tests of friction on inclined contacts: stiffness ratio, joints of the states, slope.
!>
!> test/effects/test_friction.py compares forces and radii with test/truth/friction_truth.py.
module asperity_friction_suite
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pair
  use asperity_effect_helpers, only: pair_of
  use asperity_friction, only: rubbing, solve_friction, tangential_stiffness_ratio
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_testing, only: check, run_test
  implicit none
  private

  public :: run_friction

  ! From the lower centre to the upper one.
  real(real64), parameter :: plan(2) = [0.6_real64, 0.8_real64]
  ! A few units of the last place.
  real(real64), parameter :: tolerance = 5.0e-14_real64

contains

  !> Runs the tests.
  subroutine run_friction
    call run_test('stiffness ratio: closed forms, Poisson from -1 to 0.5, huge moduli', ratios)
    call run_test('the stiffness is the slope of the vertical load', slopes)
  end subroutine run_friction

  subroutine ratios
    real(real64), parameter :: &
      nu(5) = [0.5_real64, 0.42_real64, 0.0_real64, -0.5_real64, -1.0_real64]
    real(real64) :: found
    integer :: i

    do i = 1, size(nu)
      found = tangential_stiffness_ratio(3.0_real64, nu(i), 3.0_real64, nu(i))
      call check(found, 2.0_real64 * (1.0_real64 - nu(i)) / (2.0_real64 - nu(i)), &
                 tolerance, 'equal materials')
    end do
    ! By hand from 1/G and 1/E: 0.959764474975466143 (mpmath); 6/7 where body 1 cannot be sheared.
    found = tangential_stiffness_ratio(2.0e5_real64, 0.5_real64, 7.0e4_real64, -0.2_real64)
    call check(found, 0.95976447497546614328_real64, tolerance, 'unlike materials')
    found = tangential_stiffness_ratio(7.0e4_real64, -0.2_real64, 2.0e5_real64, 0.5_real64)
    call check(found, 0.95976447497546614328_real64, tolerance, 'bodies exchanged')
    found = tangential_stiffness_ratio(1.0_real64, -1.0_real64, 1.0_real64, 0.25_real64)
    call check(found, 6.0_real64 / 7.0_real64, tolerance, 'one of -1')
    ! A rigid body leaves the other one's own ratio.
    found = tangential_stiffness_ratio(1.0e300_real64, 0.1_real64, 1.0e-300_real64, 0.5_real64)
    call check(found, 2.0_real64 / 3.0_real64, tolerance, 'one nearly rigid')
    found = tangential_stiffness_ratio(1.0e308_real64, 0.0_real64, 1.0e308_real64, 0.0_real64)
    call check(found, 1.0_real64, tolerance, 'huge moduli')
  end subroutine ratios

  subroutine slopes
    type(contact_pair) :: pair
    type(rubbing) :: rubbed, above, below
    real(real64), parameter :: p = 0.1_real64, kappa = 0.8_real64, h = 1.0e-5_real64
    real(real64), parameter :: mu(3) = [0.5_real64, 0.83_real64, 1.5_real64]
    integer :: i

    pair = pair_of(1.0_real64, 1.0_real64, 1.4_real64, plan)
    do i = 1, size(mu)
      call solve_friction(pair, p, answer(pair, 1.0_real64, p), kappa, mu(i), rubbed)
      call solve_friction(pair, p + h, answer(pair, 1.0_real64, p + h), kappa, mu(i), above)
      call solve_friction(pair, p - h, answer(pair, 1.0_real64, p - h), kappa, mu(i), below)
      if (i == 2) call check(rubbed%slip_annulus > 0.1_real64 .and. &
                             rubbed%slip_annulus < 0.9_real64, 'the second slips in part')
      ! The error of the quotient is about (h/p)**2.
      call check((above%vertical_load - below%vertical_load) / (2.0_real64 * h), &
                 rubbed%stiffness, 1.0e-7_real64 * rubbed%stiffness, 'stiffness')
    end do
  end subroutine slopes

  function answer(pair, modulus, p) result(response)
    type(contact_pair), intent(in) :: pair
    real(real64), intent(in) :: modulus, p
    type(contact_response) :: response
    type(hertz_law) :: law

    law%modulus = modulus
    call law%respond(pair, 1, p, response)
  end function answer

end module asperity_friction_suite
