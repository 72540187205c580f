!> Tests of friction on inclined contacts, one contact at a time.
!>
!> The truth of the cases is `closed_form` of test/truth/friction_truth.py, evaluated by mpmath
!> with 40 digits: quadrature and a root search of plain differences. The same file's step-by-step
!> integration agrees with it to 2e-8 with 4000 steps. Run that file to print the values again.
module asperity_friction_suite
  use asperity_contact_effect, only: contact_effect, effect_outcome
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_contact_state, only: contact_state, start_state
  use asperity_effect_helpers, only: act, as_decimal, pair_of, set_number
  use asperity_friction, only: estimate_of_friction, rubbing, solve_friction, &
                               tangential_stiffness_ratio
  use asperity_friction_effect, only: new_friction
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_scene_values, only: effect_on, scene
  use asperity_testing, only: check, error_type, new_unittest, unittest_type
  implicit none
  private

  public :: collect_friction

  ! One closing and what it gives.
  type :: closing_case
    character(6) :: name
    ! Radii of the spheres, offset, penetration.
    real(real64) :: upper, lower, d, p
    ! Elastic moduli and Poisson's ratios, coefficient of friction.
    real(real64) :: e1, nu1, e2, nu2, mu
    ! Truth.
    real(real64) :: normal, tangential, contact, stick, lateral, vertical
  end type closing_case

  ! From the lower centre to the upper one.
  real(real64), parameter :: plan(2) = [0.6_real64, 0.8_real64]
  ! Loads and radii of the cases: a few units of the last place, and what the rounding of the height
  ! zc makes of a small penetration in a stick radius.
  real(real64), parameter :: tolerance = 5.0e-14_real64

contains

  !> Lists the tests.
  subroutine collect_friction(suite)
    !> all tests
    type(unittest_type), allocatable, intent(out) :: suite(:)

    allocate (suite(0))
    suite = [ &
      new_unittest('closings that stick, slip in part and slide, against mpmath', six_closings), &
      new_unittest('stiffness ratio: closed forms, Poisson from -1 to 0.5, huge moduli', ratios), &
      new_unittest('no friction, huge friction, no offset, no contact', limits), &
      new_unittest('stick, slip and slide meet; friction never loses load', states_meet), &
      new_unittest('the stiffness is the slope of the vertical load', slopes), &
      new_unittest('forces and moments on the rig', rig_holds), &
      new_unittest('the estimate is above the truth, and near it', estimates)]
  end subroutine collect_friction

  subroutine six_closings(error)
    type(error_type), allocatable, intent(out) :: error
    type(closing_case) :: cases(6)
    type(contact_pair) :: pair
    type(contact_response) :: response
    type(rubbing) :: rubbed
    real(real64) :: kappa
    integer :: i

    ! The first three are the spheres and the plastic of the thesis, in cm and N.
    cases(1) = closing_case('stick', 1.27_real64, 1.27_real64, 0.3_real64, 0.02_real64, &
      275760.0_real64, 0.42_real64, 275760.0_real64, 0.42_real64, 0.3_real64, &
      497.78683680883140533_real64, 43.677263473094897855_real64, 0.11229605166003979321_real64, &
      0.11229605166003979321_real64, 15.890330337215734534_real64, 499.44662942742386671_real64)
    cases(2) = closing_case('part', 1.27_real64, 1.27_real64, 0.5_real64, 0.02_real64, &
      275760.0_real64, 0.42_real64, 275760.0_real64, 0.42_real64, 0.14835_real64, &
      488.29311911765104883_real64, 72.323788038096610836_real64, 0.11157756654692950989_real64, &
      0.085140951541764692542_real64, 25.982052666232060435_real64, 492.93593238175813275_real64)
    cases(3) = closing_case('slide', 1.27_real64, 1.27_real64, 0.9_real64, 0.02_real64, &
      275760.0_real64, 0.42_real64, 275760.0_real64, 0.42_real64, 0.25_real64, &
      454.57932874882788698_real64, 113.64483218720697175_real64, 0.10894816293191350679_real64, &
      0.0_real64, 56.107589758644106115_real64, 465.19829361259384205_real64)
    cases(4) = closing_case('unlike', 0.5_real64, 2.0_real64, 1.2_real64, 0.3_real64, &
      2.0e5_real64, 0.5_real64, 7.0e4_real64, -0.2_real64, 0.575_real64, &
      6347.9746922041960269_real64, 3617.4595220998164818_real64, 0.32158991659852716723_real64, &
      0.16438928222449647653_real64, 343.12585065765859028_real64, 7298.2916314371850476_real64)
    cases(5) = closing_case('steep', 1.0_real64, 1.0_real64, 1.9_real64, 0.1_real64, &
      1.0_real64, 0.3_real64, 1.0_real64, 0.3_real64, 2.75_real64, &
      0.0025495970992171933724_real64, 0.0069894040674316105448_real64, &
      0.12027944182432431589_real64, 0.04097717340797991714_real64, &
      0.00059779511516111080035_real64, 0.0074158516426945720518_real64)
    cases(6) = closing_case('tiny', 1.0_real64, 1.0_real64, 1.0e-9_real64, 1.0e-12_real64, &
      1.0_real64, -1.0_real64, 1.0_real64, 0.0_real64, 0.5_real64, &
      9.4280904158206336569e-19_real64, 4.7140452079117310426e-28_real64, &
      7.0710678118654752436e-7_real64, 7.0710678118654752436e-7_real64, &
      9.4280904158276316067e-41_real64, 9.4280904158206336581e-19_real64)

    do i = 1, size(cases)
      associate (it => cases(i))
        pair = pair_of(it%upper, it%lower, it%d, plan)
        kappa = tangential_stiffness_ratio(it%e1, it%nu1, it%e2, it%nu2)
        response = answer(pair, combined(it%e1, it%nu1, it%e2, it%nu2), it%p)
        call solve_friction(pair, it%p, response, kappa, it%mu, rubbed)
        call near(error, response%load, it%normal, it%normal, it%name//': normal load')
        call near(error, rubbed%tangential_load, it%tangential, it%tangential, &
                  it%name//': tangential load')
        call near(error, rubbed%stick_radius, it%stick, it%contact, it%name//': stick radius')
        call near(error, rubbed%slip_annulus, 1.0_real64 - it%stick / it%contact, 1.0_real64, &
                  it%name//': slip annulus')
        call near(error, rubbed%lateral_x, 0.6_real64 * it%lateral, it%tangential, &
                  it%name//': lateral force, x')
        call near(error, rubbed%lateral_y, 0.8_real64 * it%lateral, it%tangential, &
                  it%name//': lateral force, y')
        call near(error, rubbed%vertical_load, it%vertical, it%vertical, &
                  it%name//': vertical load')
        call check(error, rubbed%sliding .eqv. it%name == 'slide', it%name//': sliding')
      end associate
    end do
  end subroutine six_closings

  subroutine ratios(error)
    type(error_type), allocatable, intent(out) :: error
    real(real64), parameter :: &
      nu(5) = [0.5_real64, 0.42_real64, 0.0_real64, -0.5_real64, -1.0_real64]
    real(real64) :: found
    integer :: i

    do i = 1, size(nu)
      found = tangential_stiffness_ratio(3.0_real64, nu(i), 3.0_real64, nu(i))
      call near(error, found, 2.0_real64 * (1.0_real64 - nu(i)) / (2.0_real64 - nu(i)), &
                1.0_real64, 'equal materials')
    end do
    ! By hand from 1/G and 1/E: 0.959764474975466143 (mpmath); 6/7 where body 1 cannot be sheared.
    found = tangential_stiffness_ratio(2.0e5_real64, 0.5_real64, 7.0e4_real64, -0.2_real64)
    call near(error, found, 0.95976447497546614328_real64, 1.0_real64, 'unlike materials')
    found = tangential_stiffness_ratio(7.0e4_real64, -0.2_real64, 2.0e5_real64, 0.5_real64)
    call near(error, found, 0.95976447497546614328_real64, 1.0_real64, 'bodies exchanged')
    found = tangential_stiffness_ratio(1.0_real64, -1.0_real64, 1.0_real64, 0.25_real64)
    call near(error, found, 6.0_real64 / 7.0_real64, 1.0_real64, 'one of -1')
    ! A rigid body leaves the other one's own ratio.
    found = tangential_stiffness_ratio(1.0e300_real64, 0.1_real64, 1.0e-300_real64, 0.5_real64)
    call near(error, found, 2.0_real64 / 3.0_real64, 1.0_real64, 'one nearly rigid')
    found = tangential_stiffness_ratio(1.0e308_real64, 0.0_real64, 1.0e308_real64, 0.0_real64)
    call near(error, found, 1.0_real64, 1.0_real64, 'huge moduli')
  end subroutine ratios

  subroutine limits(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pair) :: pair
    type(contact_response) :: response
    type(rubbing) :: rubbed, other
    real(real64), parameter :: p = 0.01_real64, kappa = 0.7_real64
    real(real64) :: sine

    pair = pair_of(1.0_real64, 1.5_real64, 1.5_real64, plan)
    response = answer(pair, 2.0_real64, p)
    sine = sqrt((1.0_real64 - response%cosine) * (1.0_real64 + response%cosine))

    call solve_friction(pair, p, response, kappa, 0.0_real64, rubbed)
    call check(error, rubbed%sliding, 'without friction it slides')
    call check(error, .not. rubbed%tangential_load > 0.0_real64, 'no friction, no force')
    call near(error, rubbed%vertical_load, response%vertical_load, response%load, 'mu = 0: load')
    call near(error, rubbed%stiffness, response%stiffness, response%stiffness, 'mu = 0: stiffness')
    call near(error, rubbed%lateral_x, 0.6_real64 * response%load * sine, response%load, &
              'mu = 0: the normal force pushes sideways')

    call solve_friction(pair, p, response, kappa, huge(1.0_real64), rubbed)
    call solve_friction(pair, p, response, kappa, 10.0_real64, other)
    call check(error, .not. rubbed%sliding, 'with huge friction it sticks')
    call near(error, rubbed%slip_annulus, 0.0_real64, 1.0_real64, 'huge mu: no annulus')
    call near(error, rubbed%tangential_load, other%tangential_load, response%load, 'huge mu: T')
    call near(error, rubbed%stiffness, other%stiffness, other%stiffness, 'huge mu: stiffness')

    pair = pair_of(1.0_real64, 1.5_real64, 0.0_real64, plan)
    response = answer(pair, 2.0_real64, p)
    call solve_friction(pair, p, response, kappa, 0.0_real64, rubbed)
    call check(error, .not. rubbed%sliding, 'aligned: nothing to slide')
    call solve_friction(pair, p, response, kappa, 0.3_real64, rubbed)
    call check(error, .not. (rubbed%tangential_load > 0.0_real64 .or. &
                             abs(rubbed%lateral_x) > 0.0_real64), 'aligned: no force in plan')
    call near(error, rubbed%vertical_load, response%load, response%load, 'aligned: load')

    response = contact_response()
    call solve_friction(pair, -p, response, kappa, 0.3_real64, rubbed)
    call check(error, .not. (rubbed%sliding .or. abs(rubbed%vertical_load) > 0.0_real64), &
               'apart: nothing')
  end subroutine limits

  ! Over friction coefficients from stick to slide.
  subroutine states_meet(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pair) :: pair
    type(contact_response) :: response
    type(rubbing) :: rubbed, before
    real(real64), parameter :: p = 0.1_real64, kappa = 0.8_real64
    integer, parameter :: steps = 20000
    real(real64) :: mu, jump
    integer :: i, in_part

    pair = pair_of(1.0_real64, 1.0_real64, 1.4_real64, plan)
    response = answer(pair, 1.0_real64, p)
    in_part = 0
    jump = 0.0_real64
    call solve_friction(pair, p, response, kappa, 0.7_real64, before)
    do i = 1, steps
      mu = 0.7_real64 + 0.3_real64 * i / steps
      call solve_friction(pair, p, response, kappa, mu, rubbed)
      if (.not. rubbed%sliding .and. rubbed%slip_annulus > 0.0_real64) in_part = in_part + 1
      jump = max(jump, rubbed%tangential_load - before%tangential_load)
      ! The rounding of a load that does not change.
      call check(error, rubbed%tangential_load >= &
                 before%tangential_load - 1.0e-15_real64 * response%load, 'T falls with mu')
      call check(error, rubbed%tangential_load <= mu * response%load, 'T above mu N')
      call check(error, rubbed%stick_radius >= before%stick_radius - 1.0e-12_real64, &
                 'the stick radius falls with mu')
      before = rubbed
    end do
    call check(error, in_part > steps / 20, 'too few of them slip in part')
    ! T can grow by no more than the step of mu times N.
    call check(error, jump <= 1.001_real64 * 0.3_real64 / steps * response%load, 'T jumps')
  end subroutine states_meet

  subroutine slopes(error)
    type(error_type), allocatable, intent(out) :: error
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
      if (i == 2) call check(error, rubbed%slip_annulus > 0.1_real64 .and. &
                             rubbed%slip_annulus < 0.9_real64, 'the second slips in part')
      ! The error of the quotient is about (h/p)**2.
      call check(error, (above%vertical_load - below%vertical_load) / (2.0_real64 * h), &
                 rubbed%stiffness, 1.0e-7_real64 * rubbed%stiffness, 'stiffness')
    end do
  end subroutine slopes

  subroutine rig_holds(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pair) :: pair, mirrored
    real(real64) :: rig(5), load, push

    ! Centres at (0, 0) below and (0.6, 0.8) d above; equal spheres touch half way.
    pair = pair_of(1.0_real64, 1.0_real64, 1.0_real64, plan)
    pair%x = 0.3_real64
    pair%y = 0.4_real64
    call hold_rig([pair], load, push, rig)
    call near(error, rig(1), -0.6_real64 * push, push, 'force x')
    call near(error, rig(2), -0.8_real64 * push, push, 'force y')
    call near(error, rig(3), -0.4_real64 * load, load, 'moment x')
    call near(error, rig(4), 0.3_real64 * load, load, 'moment y')
    call near(error, rig(5), 0.0_real64, push, 'a push from the origin does not turn')

    ! Turned by half a turn about (1, 0): forces in plan cancel, and leave a couple.
    mirrored = pair
    mirrored%x = 2.0_real64 - pair%x
    mirrored%y = -pair%y
    mirrored%lower_x = 2.0_real64 - pair%lower_x
    mirrored%upper_x = 2.0_real64 - pair%upper_x
    mirrored%lower_y = -pair%lower_y
    mirrored%upper_y = -pair%upper_y
    call hold_rig([pair, mirrored], load, push, rig)
    call near(error, rig(1), 0.0_real64, push, 'mirrored: force x')
    call near(error, rig(2), 0.0_real64, push, 'mirrored: force y')
    call near(error, rig(3), 0.0_real64, load, 'mirrored: moment x')
    call near(error, rig(4), 2.0_real64 * load, load, 'mirrored: moment y')
    call near(error, rig(5), 1.6_real64 * push, push, 'mirrored: moment z')
  end subroutine rig_holds

  ! What the rig holds of contacts that friction acts on; vertical load and push of the first.
  subroutine hold_rig(list, load, push, rig)
    type(contact_pair), intent(in) :: list(:)
    real(real64), intent(out) :: load, push, rig(5)
    class(contact_effect), allocatable :: friction
    type(scene) :: scene_in
    type(contact_pairs) :: pairs
    type(contact_state) :: state
    type(effect_outcome) :: outcome

    call scene_in%effects%call_for('friction', effect_on)
    call set_number(scene_in, 'friction_coefficient', 0.2_real64)
    scene_in%upper%elastic_modulus = as_decimal(1.0_real64)
    scene_in%lower%elastic_modulus = as_decimal(1.0_real64)
    call new_friction(scene_in, friction)
    allocate (pairs%list(size(list)))
    pairs%list = list
    call start_state(pairs, hertz_law(modulus=1.0_real64), 0.02_real64, state)
    call act(friction, pairs, state, outcome)
    load = state%answers(1)%vertical_load
    push = norm2(outcome%of_contacts(1, 4:5))
    rig = outcome%of_state(3:)
  end subroutine hold_rig

  subroutine estimates(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(hertz_law) :: law
    type(rubbing) :: rubbed
    type(contact_response) :: response
    real(real64), parameter :: closing = 0.02_real64, kappa = 0.734_real64
    real(real64), parameter :: mu(4) = [0.0_real64, 0.1_real64, 0.3_real64, 5.0_real64]
    real(real64) :: estimate, truth, plain
    integer :: i, j

    law%modulus = 1.0_real64
    allocate (pairs%list(4))
    pairs%list = [pair_of(1.0_real64, 1.0_real64, 0.1_real64, plan), &
                  pair_of(1.0_real64, 1.0_real64, 0.5_real64, plan), &
                  pair_of(1.0_real64, 1.0_real64, 0.9_real64, plan), &
                  pair_of(1.0_real64, 1.0_real64, 0.2_real64, plan)]
    pairs%list%gap = [0.0_real64, 0.004_real64, 0.01_real64, 0.03_real64]
    do j = 1, size(mu)
      truth = 0.0_real64
      plain = 0.0_real64
      do i = 1, 3
        response = answer(pairs%list(i), 1.0_real64, closing - pairs%list(i)%gap)
        call solve_friction(pairs%list(i), closing - pairs%list(i)%gap, response, kappa, mu(j), &
                            rubbed)
        truth = truth + rubbed%vertical_load
        plain = plain + response%vertical_load
      end do
      truth = truth / plain - 1.0_real64
      estimate = estimate_of_friction(pairs, law, closing, kappa, mu(j))
      call check(error, estimate >= truth - 1.0e-15_real64, 'below the truth')
      ! The slope of the steepest pair grows by 2 % while it closes.
      call check(error, estimate, truth, 0.02_real64 * truth + 1.0e-15_real64, 'estimate')
    end do
    call near(error, estimate_of_friction(pairs, law, -1.0_real64, kappa, 0.3_real64), &
              0.0_real64, 1.0_real64, 'apart')
  end subroutine estimates

  function answer(pair, modulus, p) result(response)
    type(contact_pair), intent(in) :: pair
    real(real64), intent(in) :: modulus, p
    type(contact_response) :: response
    type(hertz_law) :: law

    law%modulus = modulus
    call law%respond(pair, 1, p, response)
  end function answer

  pure function combined(e1, nu1, e2, nu2) result(modulus)
    real(real64), intent(in) :: e1, nu1, e2, nu2
    real(real64) :: modulus

    modulus = 1.0_real64 / ((1.0_real64 - nu1**2) / e1 + (1.0_real64 - nu2**2) / e2)
  end function combined

  subroutine near(error, found, expected, scale, message)
    type(error_type), allocatable, intent(inout) :: error
    real(real64), intent(in) :: found, expected, scale
    character(*), intent(in) :: message

    call check(error, found, expected, tolerance * abs(scale), message)
  end subroutine near

end module asperity_friction_suite
