!> Gauss' rule, and the Pareto front of an accuracy study.
module asperity_study_suite
  use asperity_gauss_rule, only: gauss_node, gauss_points, gauss_weight
  use asperity_kinds, only: real64
  use asperity_method_study, only: on_front
  use asperity_testing, only: check, run_test
  implicit none
  private

  public :: run_study

contains

  !> Runs the tests.
  subroutine run_study
    call run_test('Gauss'' rule: exact for polynomials', integrate_powers)
    call run_test('Pareto front: run times do not choose between equal methods', mark_front)
  end subroutine run_study

  !> n points are exact for powers below 2 n: the integral of x**k from 0 to 1 is 1/(k + 1).
  subroutine integrate_powers
    real(real64), parameter :: rounding = 2.0e-15_real64
    integer :: k

    do k = 0, 2 * gauss_points - 1
      call check(abs(sum(gauss_weight * gauss_node**k) * (k + 1) - 1) < rounding, 'a power')
    end do
    call check(abs(sum(gauss_weight * gauss_node**20) * 21 - 1) > 1.0e-13_real64, 'degree 20')
  end subroutine integrate_powers

  !> Of methods of one error in times within 1.5 the first is taken, with the least time of them.
  subroutine mark_front
    call check(all(on_front([1.4_real64, 1.0_real64, 1.6_real64], [0.1_real64, 0.1_real64, &
                                                                          0.105_real64]) &
                          .eqv. [.true., .false., .false.]), 'equal methods')
    call check(all(on_front([1.6_real64, 1.0_real64], [0.1_real64, 0.1_real64]) &
                          .eqv. [.false., .true.]), 'a faster method')
    call check(all(on_front([4.0_real64, 1.0_real64], [0.0_real64, 0.1_real64])), 'both')
  end subroutine mark_front

end module asperity_study_suite
