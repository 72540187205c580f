!> Tests of creep on contacts that are held.
!>
!> Truths are closed forms and what test/truth/creep_truth.py prints: mpmath integrals, and a
!> march of its own for several spheres. They share no code with src.
module asperity_creep_suite
  use asperity_contact_effect, only: contact_effect, effect_outcome
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state, start_state, total_load
  use asperity_creep_holds, only: creep_of, half, held_at, hold_load, start, three_spheres
  use asperity_effect_helpers, only: near, pair_of
  use asperity_hertz_law, only: hertz_law
  use asperity_interaction, only: new_interaction
  use asperity_kinds, only: real64
  use asperity_scene_values, only: effect_coupled, effect_on, scene
  use asperity_testing, only: check, error_type, new_unittest, unittest_type
  use asperity_viscoelastic_solid, only: hold_times, standard_linear_solid
  implicit none
  private

  public :: collect_creep

contains

  !> Lists the tests.
  subroutine collect_creep(suite)
    !> all tests
    type(unittest_type), allocatable, intent(out) :: suite(:)

    allocate (suite(0))
    suite = [ &
      new_unittest('held approach: load and pressure relax exactly', held_approach), &
      new_unittest('held load: approach exact in any steps, pressure of second order', held_load), &
      new_unittest('held load on spheres that touch one after the other', held_spheres), &
      new_unittest('neighbours that lower each other: both holds', lowered), &
      new_unittest('the stiffness is the slope of the vertical load', slopes), &
      new_unittest('no, instant and endless relaxation', limits), &
      new_unittest('a hold dissipates: no more comes back than was taken', energy), &
      new_unittest('shrinking areas are refused, rounding is not', refusals), &
      new_unittest('the estimate bounds the truth', estimates)]
  end subroutine collect_creep

  subroutine held_approach(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    class(contact_effect), allocatable :: creep
    type(contact_state) :: state, elastic
    type(effect_outcome) :: outcome
    type(standard_linear_solid) :: solid
    real(real64), allocatable :: times(:)
    real(real64) :: share
    integer :: i

    solid = standard_linear_solid(0.3_real64, 7.0_real64)
    call three_spheres(pairs)
    call start(solid, pairs, creep)
    call start_state(pairs, hertz_law(modulus=1.0_real64), 0.04_real64, elastic)
    call hold_times(70.0_real64, 7.0_real64, 50, times)
    do i = 1, size(times)
      call held_at(pairs, creep, 0.04_real64, times(i), state, outcome)
      call check(error, .not. allocated(outcome%failure), 'held')
      if (allocated(error)) return
      call creep%keep(pairs, state)
      share = 0.3_real64 + 0.7_real64 * exp(-times(i) / 7.0_real64)
      call near(error, total_load(state), share * total_load(elastic), 1.0e-14_real64, 'load')
      call near(error, state%answers(2)%maximum_pressure, &
                share * elastic%answers(2)%maximum_pressure, 1.0e-14_real64, 'pressure')
      call near(error, state%answers(3)%vertical_load, share * elastic%answers(3)%vertical_load, &
                1.0e-14_real64, 'vertical load')
      call near(error, outcome%of_contacts(1, 2), share, 1.0e-14_real64, 'relaxed share')
      call near(error, outcome%of_state(2), total_load(elastic), 1.0e-14_real64, 'elastic load')
      call near(error, state%answers(1)%contact_radius, elastic%answers(1)%contact_radius, &
                epsilon(1.0_real64), 'radius')
    end do
  end subroutine held_approach

  ! One aligned pair: delta**1.5 is J E0 times that at once, whatever the steps (Johnson 1985,
  ! section 6.5). The pressure at t = 5 by mpmath.quad.
  subroutine held_load(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(contact_state) :: state
    integer, parameter :: counts(4) = [2, 20, 200, 400]
    real(real64), parameter :: pressure = 0.63321328450956530_real64
    real(real64) :: first, off(4)
    integer :: k

    allocate (pairs%list(1))
    pairs%list(1) = pair_of(1.0_real64, 1.0_real64, 0.0_real64)
    pairs%modulus = 1.0_real64
    first = (0.01_real64 / (4.0_real64 / 3.0_real64 * sqrt(0.5_real64)))**(2.0_real64 / 3.0_real64)
    do k = 1, size(counts)
      call hold_load(error, half, pairs, 0.01_real64, 5.0_real64, counts(k) + 1, state)
      call near(error, (state%closing / first)**1.5_real64, &
                2.0_real64 - exp(-2.5_real64), 1.0e-13_real64, 'approach')
      call near(error, state%answers(1)%contact_radius**2, 0.5_real64 * state%closing, &
                1.0e-13_real64, 'area')
      off(k) = abs(state%answers(1)%maximum_pressure / pressure / &
                   (2.0_real64 / acos(-1.0_real64) * sqrt(first / 0.5_real64)) - 1.0_real64)
    end do
    call check(error, off(2) < 2.0e-5_real64, '20 steps: pressure')
    call check(error, off(3) < 2.0e-7_real64, '200 steps: pressure')
    call near(error, off(3) / off(4), 4.0_real64, 0.02_real64, 'pressure: second order')
  end subroutine held_load

  ! Against `held_load` of creep_truth.py. The last sphere touches during the hold.
  subroutine held_spheres(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(contact_state) :: state
    type(standard_linear_solid) :: solid
    real(real64), parameter :: truth(3) = [ &
      0.00413350336929_real64, 0.00365172349731_real64, 0.00021477313340_real64]
    real(real64) :: off(2)
    integer :: k

    solid = standard_linear_solid(0.4_real64, 1.0_real64)
    call three_spheres(pairs)
    do k = 1, 2
      call hold_load(error, solid, pairs, 0.008_real64, 3.0_real64, 10**k * 2 + 1, state)
      ! The sum of the elastic loads is J E0 times the load in any steps.
      call near(error, sum(4.0_real64 / 3.0_real64 * sqrt(pairs%list%radius) * &
                           max(0.0_real64, state%penetration)**1.5_real64), &
                0.008_real64 * (2.5_real64 - 1.5_real64 * exp(-1.2_real64)), 1.0e-12_real64, 'sum')
      off(k) = maxval(abs(state%answers%load - truth)) / 0.008_real64
    end do
    call check(error, off(1) < 1.0e-3_real64, '20 steps')
    call check(error, off(2) < 2.0e-5_real64, '200 steps')
  end subroutine held_spheres

  ! Three coupled contacts. The compliance law holds for their sum, relaxation for each.
  subroutine lowered(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    class(contact_effect), allocatable :: creep, coupling
    type(contact_state) :: state, elastic
    type(effect_outcome) :: outcome
    type(scene) :: scene_in
    type(standard_linear_solid) :: solid
    real(real64), allocatable :: times(:)
    real(real64) :: share
    integer :: i, k

    call scene_in%effects%call_for('interaction', effect_coupled)
    call new_interaction(scene_in, coupling)
    solid = standard_linear_solid(0.4_real64, 1.0_real64)
    call three_spheres(pairs)
    pairs%list%x = [0.0_real64, 0.5_real64, 0.3_real64]
    pairs%list%y = [0.0_real64, 0.0_real64, 0.4_real64]
    call start(solid, pairs, creep)
    call hold_times(3.0_real64, 1.0_real64, 21, times)
    call held_at(pairs, creep, 0.05_real64, 0.0_real64, elastic, outcome, coupling)
    call start_state(pairs, hertz_law(modulus=1.0_real64), 0.05_real64, state)
    call check(error, total_load(elastic) < 0.9_real64 * total_load(state), 'coupled')
    do i = 1, size(times)
      call held_at(pairs, creep, 0.05_real64, times(i), state, outcome, coupling)
      call creep%keep(pairs, state)
      share = 0.4_real64 + 0.6_real64 * exp(-times(i))
      do k = 1, 3
        call near(error, state%answers(k)%load, share * elastic%answers(k)%load, 1.0e-13_real64, &
                  'held approach')
      end do
    end do
    call hold_load(error, solid, pairs, 0.008_real64, 3.0_real64, 21, state, coupling)
    call creep%begin(pairs)
    call held_at(pairs, creep, state%closing, 0.0_real64, elastic, outcome, coupling)
    call near(error, total_load(elastic), 0.008_real64 * &
              (2.5_real64 - 1.5_real64 * exp(-1.2_real64)), 1.0e-10_real64, 'held load')
  end subroutine lowered

  subroutine slopes(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    class(contact_effect), allocatable :: creep
    type(contact_state) :: state, below, above
    type(effect_outcome) :: outcome, other
    real(real64), parameter :: h = 1.0e-6_real64
    integer :: i

    allocate (pairs%list(2))
    pairs%list(1) = pair_of(1.0_real64, 1.0_real64, 1.2_real64)
    pairs%list(2) = pair_of(1.0_real64, 2.0_real64, 0.0_real64)
    pairs%modulus = 1.0_real64
    call start(half, pairs, creep)
    call held_at(pairs, creep, 0.03_real64, 0.0_real64, state, outcome)
    call creep%keep(pairs, state)
    call held_at(pairs, creep, 0.035_real64, 0.8_real64, state, outcome)
    call held_at(pairs, creep, 0.035_real64 - h, 0.8_real64, below, outcome)
    call held_at(pairs, creep, 0.035_real64 + h, 0.8_real64, above, other)
    do i = 1, 2
      call near(error, state%answers(i)%stiffness, (above%answers(i)%vertical_load - &
                below%answers(i)%vertical_load) / (2.0_real64 * h), 1.0e-8_real64, 'slope')
    end do
  end subroutine slopes

  subroutine limits(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(contact_state) :: state
    real(real64) :: first

    allocate (pairs%list(1))
    pairs%list(1) = pair_of(1.0_real64, 1.0_real64, 0.0_real64)
    pairs%modulus = 1.0_real64
    first = (0.01_real64 / (4.0_real64 / 3.0_real64 * sqrt(0.5_real64)))**(2.0_real64 / 3.0_real64)
    call hold_load(error, standard_linear_solid(1.0_real64, 1.0_real64), pairs, 0.01_real64, &
                   5.0_real64, 6, state)
    call near(error, state%closing, first, 1.0e-13_real64, 'r = 1')
    call hold_load(error, standard_linear_solid(0.5_real64, 1.0e300_real64), pairs, 0.01_real64, &
                   5.0_real64, 6, state)
    call near(error, state%closing, first, 1.0e-13_real64, 'tau = 1e300')
    first = first * 2.0_real64**(2.0_real64 / 3.0_real64)
    call hold_load(error, standard_linear_solid(0.5_real64, 1.0e-300_real64), pairs, 0.01_real64, &
                   5.0_real64, 6, state)
    call near(error, state%closing, first, 1.0e-13_real64, 'tau = 1e-300')
    call hold_load(error, standard_linear_solid(0.5_real64, 0.0_real64), pairs, 0.01_real64, &
                   5.0_real64, 6, state)
    call near(error, state%closing, first, 1.0e-13_real64, 'tau = 0')
    call near(error, state%answers(1)%maximum_pressure, 0.5_real64 * 2.0_real64 / &
              acos(-1.0_real64) * sqrt(first / 0.5_real64), 1.0e-13_real64, 'tau = 0: pressure')
  end subroutine limits

  ! The work taken by loading and a held load, and what Ting (1966) lets come back at once:
  ! `cycle_work` of creep_truth.py, in units of load and approach at once.
  subroutine energy(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(contact_state) :: state
    real(real64), parameter :: truth(3, 2) = reshape([ &
      1.0_real64, 0.647570063884365_real64, 0.353402899794_real64, &
      50.0_real64, 0.987401051960851_real64, 0.317480259306_real64], [3, 2])
    real(real64) :: first, taken
    integer :: k

    allocate (pairs%list(1))
    pairs%list(1) = pair_of(1.0_real64, 1.0_real64, 0.0_real64)
    pairs%modulus = 1.0_real64
    first = (0.01_real64 / (4.0_real64 / 3.0_real64 * sqrt(0.5_real64)))**(2.0_real64 / 3.0_real64)
    do k = 1, 2
      call hold_load(error, half, pairs, 0.01_real64, truth(1, k), 12, state)
      taken = 0.4_real64 + (state%closing / first - 1.0_real64) * total_load(state) / 0.01_real64
      call near(error, taken, truth(2, k), 1.0e-12_real64, 'work taken')
      call check(error, truth(3, k) < taken, 'work given back')
    end do
  end subroutine energy

  subroutine refusals(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    class(contact_effect), allocatable :: creep
    type(contact_state) :: state
    type(effect_outcome) :: outcome

    call three_spheres(pairs)
    call creep_of(half, 1.0_real64, creep)
    call creep%begin(pairs)
    call held_at(pairs, creep, 0.04_real64, 0.0_real64, state, outcome)
    call creep%keep(pairs, state)
    ! Loading takes no time: closings may go anywhere as long as none has passed.
    call held_at(pairs, creep, 0.02_real64, 0.0_real64, state, outcome)
    call check(error, .not. allocated(outcome%failure), 'unloading at once')
    call held_at(pairs, creep, 0.04_real64 * (1.0_real64 - 1.0e-12_real64), 1.0_real64, state, &
                 outcome)
    call check(error, .not. allocated(outcome%failure), 'rounding')
    call held_at(pairs, creep, 0.04_real64 * (1.0_real64 - 1.0e-6_real64), 1.0_real64, state, &
                 outcome)
    call check(error, allocated(outcome%failure), 'a shrinking area')
    if (allocated(outcome%failure)) call check(error, index(outcome%failure, &
      'the area of contact 2 shrinks') == 1, outcome%failure)
    call held_at(pairs, creep, 0.05_real64, 1.0_real64, state, outcome)
    call check(error, .not. allocated(outcome%failure), 'growing')
  end subroutine refusals

  subroutine estimates(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    class(contact_effect), allocatable :: creep
    type(contact_state) :: state
    type(effect_outcome) :: outcome
    real(real64) :: share

    call three_spheres(pairs)
    call start(half, pairs, creep)
    call held_at(pairs, creep, 0.04_real64, 0.0_real64, state, outcome)
    share = creep%estimate(pairs, state)
    call near(error, share, 0.5_real64 * (1.0_real64 - exp(-1.0_real64)), 1.0e-14_real64, &
              'estimate')
    call creep%keep(pairs, state)
    call held_at(pairs, creep, 0.04_real64, 1.0_real64, state, outcome)
    call near(error, share, 1.0_real64 - total_load(state) / outcome%of_state(2), 1.0e-13_real64, &
              'held approach')
    call held_at(pairs, creep, 0.05_real64, 1.0_real64, state, outcome)
    call check(error, share > 1.0_real64 - total_load(state) / outcome%of_state(2), 'growing')
    call creep_of(half, 0.0_real64, creep)
    call check(error, creep%estimate(pairs, state), 0.0_real64, 0.0_real64, 'no hold')
  end subroutine estimates

end module asperity_creep_suite
