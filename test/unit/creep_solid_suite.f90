!> Tests of the solid that creeps, its steps in time, and the times of a hold.
!>
!> Truths are closed forms and what test/truth/creep_truth.py prints: mpmath integrals and
!> Laplace inversion. They share no code with src.
module asperity_creep_solid_suite
  use asperity_creep_holds, only: half
  use asperity_effect_helpers, only: near
  use asperity_kinds, only: real64
  use asperity_testing, only: check, error_type, new_unittest, unittest_type
  use asperity_viscoelastic_solid, only: creep_compliance, hold_times, load_after, &
                                         relaxation_ratio, solid_step, standard_linear_solid, &
                                         step_over
  implicit none
  private

  public :: collect_creep_solid

contains

  !> Lists the tests.
  subroutine collect_creep_solid(suite)
    !> all tests
    type(unittest_type), allocatable, intent(out) :: suite(:)

    allocate (suite(0))
    suite = [ &
      new_unittest('relaxation and compliance: closed forms, Laplace inversion, limits', solids), &
      new_unittest('steps of a smooth course: second order, against mpmath', steps_converge), &
      new_unittest('steps from no time to endless time, r from 1e-12 to 1', extreme_steps), &
      new_unittest('times of a hold: ends, order, extremes', times_of_hold)]
  end subroutine collect_creep_solid

  subroutine solids(error)
    type(error_type), allocatable, intent(out) :: error
    type(standard_linear_solid) :: solid
    integer :: i
    ! r, tau, t, J(t) E(0) by inverting its Laplace transform.
    real(real64), parameter :: truth(4, 4) = reshape([ &
      0.5_real64, 1.0_real64, 0.7_real64, 1.29531191028128655_real64, &
      0.9_real64, 150.0_real64, 600.0_real64, 1.1080751419503008_real64, &
      0.01_real64, 2.0_real64, 30.0_real64, 14.789910333919277_real64, &
      0.75_real64, 100.0_real64, 0.001_real64, 1.0000024999906250_real64], [4, 4])

    do i = 1, 4
      solid = standard_linear_solid(truth(1, i), truth(2, i))
      call near(error, creep_compliance(solid, truth(3, i)), truth(4, i), 1.0e-13_real64, 'J E0')
      call near(error, relaxation_ratio(solid, 0.0_real64), 1.0_real64, epsilon(1.0_real64), 'E(0)')
      call near(error, creep_compliance(solid, 0.0_real64), 1.0_real64, epsilon(1.0_real64), 'J(0)')
      call near(error, relaxation_ratio(solid, 1.0e300_real64), solid%relaxed_ratio, &
                1.0e-15_real64, &
                'relaxed')
      call near(error, creep_compliance(solid, 1.0e300_real64), 1.0_real64 / solid%relaxed_ratio, &
                1.0e-15_real64, 'crept')
    end do
    call near(error, relaxation_ratio(half, log(2.0_real64)), 0.75_real64, 1.0e-15_real64, &
              'half gone')
    ! Nearly a fluid: J E0 = 1 + t/tau.
    solid = standard_linear_solid(1.0e-14_real64, 2.0_real64)
    call near(error, creep_compliance(solid, 10.0_real64), 6.0_real64, 1.0e-13_real64, 'fluid')
  end subroutine solids

  ! Elastic load (1 + t)**1.5 up to t = 2.
  subroutine steps_converge(error)
    type(error_type), allocatable, intent(out) :: error
    ! r, tau, load by mpmath.quad.
    real(real64), parameter :: truth(3, 3) = reshape([ &
      0.5_real64, 1.0_real64, 3.6448235300786179_real64, &
      0.2_real64, 0.3_real64, 1.6303432024502850_real64, &
      0.9_real64, 5.0_real64, 5.0953264259506911_real64], [3, 3])
    real(real64) :: off(3)
    integer, parameter :: counts(3) = [20, 200, 400]
    integer :: i, k

    do i = 1, 3
      do k = 1, 3
        off(k) = abs(smooth_course(standard_linear_solid(truth(1, i), truth(2, i)), counts(k)) / &
                     truth(3, i) - 1.0_real64)
      end do
      call check(error, off(1) < 1.0e-3_real64, '20 steps')
      call check(error, off(2) < 1.0e-5_real64, '200 steps')
      call near(error, off(2) / off(3), 4.0_real64, 0.01_real64, 'second order')
    end do
  end subroutine steps_converge

  real(real64) function smooth_course(solid, steps)
    type(standard_linear_solid), intent(in) :: solid
    integer, intent(in) :: steps
    real(real64) :: memory, before, now, t, last
    integer :: i

    memory = 0.0_real64
    before = 1.0_real64
    last = 0.0_real64
    call load_after(step_over(solid, 0.0_real64, 0.0_real64), 0.0_real64, before, memory, &
                    smooth_course)
    do i = 1, steps
      t = 2.0_real64 * i / steps
      now = (1.0_real64 + t)**1.5_real64
      call load_after(step_over(solid, last, t), before, now, memory, smooth_course)
      before = now
      last = t
    end do
  end function smooth_course

  ! Growth against its series in h for short steps and its limits for long ones.
  subroutine extreme_steps(error)
    type(error_type), allocatable, intent(out) :: error
    type(solid_step) :: step
    real(real64), parameter :: ratios(4) = &
      [1.0e-12_real64, 0.3_real64, 1.0_real64 - 1.0e-9_real64, 1.0_real64]
    real(real64), parameter :: tiny_steps(3) = [0.0_real64, 1.0e-300_real64, 1.0e-9_real64]
    integer :: i, k

    do i = 1, size(ratios)
      do k = 1, size(tiny_steps)
        step = step_over(standard_linear_solid(ratios(i), 1.0_real64), 0.0_real64, tiny_steps(k))
        call check(error, step%growth, (1.0_real64 - ratios(i)) * &
                   (1.0_real64 - 0.5_real64 * tiny_steps(k)), 4.0e-16_real64, 'short: growth')
        call check(error, step%decay, 1.0_real64 - tiny_steps(k), 4.0e-16_real64, 'short: decay')
      end do
      step = step_over(standard_linear_solid(ratios(i), 1.0e-300_real64), 0.0_real64, &
                       1.0e300_real64)
      call check(error, step%growth, 0.0_real64, 0.0_real64, 'endless: growth')
      call check(error, step%decay, 0.0_real64, 0.0_real64, 'endless: decay')
      step = step_over(standard_linear_solid(ratios(i), 0.0_real64), 0.0_real64, 1.0_real64)
      call check(error, step%growth + step%decay, 0.0_real64, 0.0_real64, 'instant relaxation')
    end do
    ! r -> 0: the straight line, (1 - exp(-x))/x.
    step = step_over(standard_linear_solid(1.0e-12_real64, 1.0_real64), 1.0_real64, 3.0_real64)
    call near(error, step%growth, (1.0_real64 - exp(-2.0_real64)) / 2.0_real64, 2.0e-12_real64, &
              'straight line')
  end subroutine extreme_steps

  subroutine times_of_hold(error)
    type(error_type), allocatable, intent(out) :: error
    real(real64), allocatable :: times(:)
    real(real64), parameter :: taus(5) = &
      [0.0_real64, 1.0e-300_real64, 1.0_real64, 150.0_real64, 1.0e300_real64]
    integer :: i

    do i = 1, size(taus)
      call hold_times(600.0_real64, taus(i), 30, times)
      call check(error, size(times), 30, 'number')
      call check(error, times(1), 0.0_real64, 0.0_real64, 'first')
      call check(error, times(30), 600.0_real64, 0.0_real64, 'last')
      call check(error, all(times(2:) > times(:29)), 'ascending')
    end do
    ! A tenth of the relaxation time times equal factors, 1 + 600/15 = 41 in 29 steps.
    call hold_times(600.0_real64, 150.0_real64, 30, times)
    call near(error, times(2), 15.0_real64 * (41.0_real64**(1.0_real64 / 29.0_real64) - &
              1.0_real64), 1.0e-13_real64, 'second')
    call near(error, (times(30) + 15.0_real64) / (times(29) + 15.0_real64), &
              41.0_real64**(1.0_real64 / 29.0_real64), 1.0e-13_real64, 'factor')
    call hold_times(600.0_real64, 150.0_real64, 2, times)
    call check(error, size(times), 2, 'two')
    call hold_times(0.0_real64, 150.0_real64, 30, times)
    call check(error, size(times), 1, 'no hold')
    call check(error, times(1), 0.0_real64, 0.0_real64, 'no hold: time')
  end subroutine times_of_hold

end module asperity_creep_solid_suite
