!> Tests of the solid that creeps: steps in time, times of a hold, slope, refusals.
!>
!> test/effects/test_creep.py compares holds with closed forms and with the truth in
!> test/truth/creep_truth.py.
module asperity_creep_suite
  use asperity_contact_effect, only: contact_effect, effect_outcome
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state, start_state
  use asperity_creep, only: new_creep
  use asperity_effect_helpers, only: near, pair_of
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_scene_values, only: effect_on, scene
  use asperity_testing, only: check, run_test
  use asperity_theory_warnings, only: of_shrinking
  use asperity_viscoelastic_solid, only: creep_compliance, hold_times, new_solid, relaxing_solid
  implicit none
  private

  public :: run_creep

contains

  !> Runs the tests.
  subroutine run_creep
    call run_test('the stiffness is the slope of the vertical load', slopes)
    call run_test('shrinking areas with neighbours are warned of, rounding is not', shrinking)
    call run_test('compliance: Laplace inversion, no time, endless time', compliances)
    call run_test('times of a hold: ends, order, extremes', times_of_hold)
  end subroutine run_creep

  subroutine slopes
    type(contact_pairs) :: pairs
    class(contact_effect), allocatable :: creep
    type(contact_state) :: state, below, above
    type(effect_outcome) :: outcome, other
    real(real64), parameter :: h = 1.0e-6_real64, at(3) = [0.035_real64, 0.025_real64, &
                               0.02_real64], times(3) = [0.8_real64, 1.0_real64, 1.1_real64]
    integer :: i, k

    allocate (pairs%list(2))
    pairs%list(1) = pair_of(1.0_real64, 1.0_real64, 1.2_real64)
    pairs%list(2) = pair_of(1.0_real64, 2.0_real64, 0.0_real64)
    pairs%modulus = 1.0_real64
    call start(pairs, creep)
    call held_at(pairs, creep, 0.03_real64, 0.0_real64, state, outcome)
    call creep%keep(pairs, state)
    ! On loading, then as the contacts shrink.
    do k = 1, 3
      call held_at(pairs, creep, at(k), times(k), state, outcome)
      call held_at(pairs, creep, at(k) - h, times(k), below, outcome)
      call held_at(pairs, creep, at(k) + h, times(k), above, other)
      do i = 1, 2
        call near(state%answers(i)%stiffness, (above%answers(i)%vertical_load - &
                  below%answers(i)%vertical_load) / (2.0_real64 * h), 1.0e-8_real64, 'slope')
      end do
      call creep%keep(pairs, state)
    end do
  end subroutine slopes

  subroutine shrinking
    type(contact_pairs) :: pairs
    class(contact_effect), allocatable :: creep
    type(contact_state) :: state
    type(effect_outcome) :: outcome
    ! Compression, time, share of the elastic load on contacts that shrink.
    real(real64), parameter :: steps(3, 5) = reshape([ &
      0.02_real64, 0.0_real64, 0.0_real64, &
      0.04_real64 * (1.0_real64 - 1.0e-12_real64), 1.0_real64, 0.0_real64, &
      0.04_real64 * (1.0_real64 - 1.0e-6_real64), 1.0_real64, 1.0_real64, &
      0.01_real64, 1.0_real64, 1.0_real64, &
      0.05_real64, 1.0_real64, 0.0_real64], [3, 5])
    real(real64), parameter :: lowered = 0.01_real64
    real(real64) :: share
    integer :: i

    allocate (pairs%list(3))
    pairs%list = [pair_of(2.0_real64, 2.0_real64, 0.0_real64), &
                  pair_of(4.0_real64, 4.0_real64, 0.0_real64), &
                  pair_of(1.0_real64, 1.0_real64, 0.0_real64)]
    pairs%list%gap = [0.0_real64, 0.01_real64, 0.03_real64]
    pairs%modulus = 1.0_real64
    call start(pairs, creep)
    call held_at(pairs, creep, 0.04_real64, 0.0_real64, state, outcome, lowered)
    call creep%keep(pairs, state)
    do i = 1, size(steps, 2)
      call held_at(pairs, creep, steps(1, i), steps(2, i), state, outcome, lowered)
      share = 0.0_real64
      if (allocated(outcome%warnings)) &
        share = sum(outcome%warnings%magnitude, outcome%warnings%number == of_shrinking)
      call near(1.0_real64 + share, 1.0_real64 + steps(3, i), 1.0e-14_real64, 'share')
      call check(all(state%answers%load >= 0.0_real64), 'no pull')
    end do
    ! Where next to nothing of the elastic load is left, the surface has not recovered.
    call held_at(pairs, creep, 0.005_real64, 1.0_real64, state, outcome, lowered)
    call check(all(state%answers%load <= 0.0_real64), 'open')
    call check(all(state%answers%contact_radius <= 0.0_real64), 'open: no area')
  end subroutine shrinking

  subroutine compliances
    type(relaxing_solid) :: solid
    integer :: i
    ! r, tau, t, J(t) E(0): `compliance` of test/truth/creep_truth.py.
    real(real64), parameter :: truth(4, 4) = reshape([ &
      0.5_real64, 1.0_real64, 0.7_real64, 1.29531191028128655_real64, &
      0.9_real64, 150.0_real64, 600.0_real64, 1.1080751419503008_real64, &
      0.01_real64, 2.0_real64, 30.0_real64, 14.789910333919277_real64, &
      0.75_real64, 100.0_real64, 0.001_real64, 1.0000024999906250_real64], [4, 4])

    do i = 1, 4
      solid = new_solid(truth(1:1, i), truth(2:2, i), 0.0_real64)
      call near(creep_compliance(solid, truth(3, i)), truth(4, i), 1.0e-13_real64, 'J E0')
      call near(creep_compliance(solid, 0.0_real64), 1.0_real64, epsilon(1.0_real64), 'J(0)')
      call near(creep_compliance(solid, 1.0e300_real64), 1.0_real64 / solid%relaxed_ratio, &
                1.0e-15_real64, 'crept')
    end do
  end subroutine compliances

  subroutine times_of_hold
    real(real64), allocatable :: times(:)
    real(real64), parameter :: taus(5) = &
      [0.0_real64, 1.0e-300_real64, 1.0_real64, 150.0_real64, 1.0e300_real64]
    integer :: i

    allocate (times(0))
    do i = 1, size(taus)
      times = hold_times(600.0_real64, taus(i), 30)
      call check(size(times), 30, 'number')
      call check(times(1), 0.0_real64, 0.0_real64, 'first')
      call check(times(30), 600.0_real64, 0.0_real64, 'last')
      call check(all(times(2:) > times(:29)), 'ascending')
    end do
    ! A tenth of the relaxation time times equal factors, 1 + 600/15 = 41 in 29 steps.
    times = hold_times(600.0_real64, 150.0_real64, 30)
    call near(times(2), 15.0_real64 * (41.0_real64**(1.0_real64 / 29.0_real64) - &
              1.0_real64), 1.0e-13_real64, 'second')
    call near((times(30) + 15.0_real64) / (times(29) + 15.0_real64), &
              41.0_real64**(1.0_real64 / 29.0_real64), 1.0e-13_real64, 'factor')
    times = hold_times(600.0_real64, 150.0_real64, 2)
    call check(size(times), 2, 'two')
    times = hold_times(0.0_real64, 150.0_real64, 30)
    call check(size(times), 1, 'no hold')
    call check(times(1), 0.0_real64, 0.0_real64, 'no hold: time')
  end subroutine times_of_hold

  ! Creep as a scene names it, of a solid that keeps half its modulus; nothing has touched yet.
  subroutine start(pairs, creep)
    type(contact_pairs), intent(in) :: pairs
    class(contact_effect), allocatable, intent(out) :: creep
    type(scene) :: scene_in

    call scene_in%effects%call_for('creep', effect_on)
    call scene_in%effects%set('relaxed_modulus_ratio', 0.5_real64)
    call scene_in%effects%set('relaxation_time', 1.0_real64)
    call scene_in%effects%set('hold_time', 1.0_real64)
    call new_creep(scene_in, creep)
    call creep%begin(pairs)
  end subroutine start

  ! A state of a hold; `lowered` are displacements by neighbours, beside the compression.
  subroutine held_at(pairs, creep, compression, time, state, outcome, lowered)
    type(contact_pairs), intent(in) :: pairs
    class(contact_effect), intent(in) :: creep
    real(real64), intent(in) :: compression, time
    type(contact_state), intent(out) :: state
    type(effect_outcome), intent(out) :: outcome
    real(real64), intent(in), optional :: lowered

    call start_state(pairs, hertz_law(modulus=1.0_real64), compression, state)
    if (present(lowered)) state%compression = compression + lowered
    state%time = time
    call creep%apply(pairs, state, outcome)
  end subroutine held_at

end module asperity_creep_suite
