!> Tests of plastic flow: slope, extremes, and laws of the curves.
!>
!> test/effects/test_plasticity.py compares curves, unloading and onset with mpmath.
module asperity_plasticity_suite
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pair
  use asperity_effect_helpers, only: pair_of, penetration_of, plastic_law_with
  use asperity_first_yield, only: constraint_factor
  use asperity_kinds, only: real64
  use asperity_plastic_curves, only: departure, loading_curve, plastic_scale, set_scale
  use asperity_plastic_law, only: past_of_contact, plastic_law, plastic_past
  use asperity_testing, only: check, run_test
  implicit none
  private

  public :: run_plasticity

  real(real64), parameter :: pi = acos(-1.0_real64)

contains

  !> Runs the tests.
  subroutine run_plasticity
    call run_test('the stiffness is the slope of the vertical load', slopes)
    call run_test('extreme numbers stay numbers', extremes)
    call run_test('the area power within and beyond the range of its fit', area_powers)
    call run_test('load and area never fall with the approach, from soft to rigid', never_falls)
    call run_test('unloading lies below loading, and loses more the further it was', bounded)
  end subroutine run_plasticity

  subroutine slopes
    real(real64), parameter :: x(8) = [1.0_real64, 1.91_real64, 2.5_real64, 5.9_real64, &
      6.1_real64, 8.0_real64, 12.0_real64, 30.0_real64]
    real(real64), parameter :: critical = 1.0e-3_real64
    type(contact_pair) :: pair
    type(plastic_law) :: law
    type(contact_response) :: at, above(2), below(2)
    real(real64) :: p, h, quotient
    integer :: i, j, k

    pair = pair_of(1.0_real64, 1.0_real64, 1.4_real64)
    law = plastic_law_with(0.42_real64, 1.0_real64, critical)
    do k = 0, 1
      ! First loading, and below an earlier loading to 15 critical overlaps.
      law%largest = 15.0_real64 * critical * k
      do i = 1, size(x)
        p = penetration_of(pair, x(i) * critical)
        h = 1.0e-3_real64 * p
        call law%respond(pair, 1, p, at)
        do j = 1, 2
          call law%respond(pair, 1, p + j * h, above(j))
          call law%respond(pair, 1, p - j * h, below(j))
        end do
        quotient = (8.0_real64 * (above(1)%vertical_load - below(1)%vertical_load) - &
                    (above(2)%vertical_load - below(2)%vertical_load)) / (12.0_real64 * h)
        ! The error of the quotient is about (h/p)**4; below the residual overlap both are zero.
        call check(quotient, at%stiffness, 2.0e-9_real64 * at%stiffness, 'stiffness')
      end do
    end do
  end subroutine slopes

  subroutine extremes
    real(real64), parameter :: critical(5) = [tiny(1.0_real64), 1.0e-300_real64, 1.0e-30_real64, &
                                              1.0e-3_real64, 0.2_real64]
    real(real64), parameter :: p(4) = [1.0e-300_real64, 1.0e-20_real64, 1.0e-3_real64, 1.0_real64]
    type(contact_pair) :: pair
    type(plastic_law) :: law
    type(plastic_past) :: past
    type(contact_response) :: answer
    integer :: i, j, k

    pair = pair_of(1.0_real64, 1.0_real64, 0.3_real64)
    do i = 1, size(critical)
      do j = 1, size(p)
        do k = 0, 1
          law = plastic_law_with(0.3_real64, 1.0_real64, critical(i))
          law%largest = 0.5_real64 * k
          call law%respond(pair, 1, p(j), answer)
          call check(all(abs([answer%overlap, answer%contact_radius, answer%load, &
                                     answer%vertical_load, answer%stiffness, &
                                     answer%maximum_pressure]) <= huge(1.0_real64)), 'not finite')
          call past_of_contact(law, pair, 1, max(law%largest(1), answer%overlap), past)
          call check(past%work_lost >= 0.0_real64 .and. &
                     past%work_lost <= huge(1.0_real64), 'work not finite')
        end do
      end do
    end do
  end subroutine extremes

  ! B = 0.14 exp(23 Sy/E) up to Sy/E = 1.619 (1 - 0.32**2)/200 = 0.0072661, constant beyond.
  subroutine area_powers
    type(plastic_scale) :: inside, outside

    call set_scale(1.6_real64, 0.8_real64 * pi * 0.0072_real64, inside)
    call check(inside%area_power, 0.16521413536821808_real64, 1.0e-14_real64, 'inside')
    call set_scale(1.6_real64, 0.8_real64 * pi * 0.01_real64, outside)
    call check(outside%area_power, 0.1654653948859781_real64, 1.0e-14_real64, 'beyond')
  end subroutine area_powers

  ! On first loading, and up and down below an earlier one.
  subroutine never_falls
    real(real64), parameter :: nu(4) = [-1.0_real64, 0.0_real64, 0.32_real64, 0.5_real64]
    real(real64), parameter :: strain(5) = [1.0e-4_real64, 0.01_real64, 0.1_real64, 0.3_real64, &
                                            1.0_real64]
    integer, parameter :: steps = 4000
    type(plastic_scale) :: scale
    type(contact_pair) :: pair
    type(plastic_law) :: law
    type(contact_response) :: answer, before
    real(real64) :: x, ratio, slope, spread, peak, load, load_before, p
    integer :: i, j, k

    do j = 1, size(nu)
      do k = 1, size(strain)
        call set_scale(constraint_factor(nu(j)), strain(k), scale)
        load_before = 0.0_real64
        do i = 1, steps
          x = 1.5_real64 * 1000.0_real64**(real(i, real64) / steps)
          call loading_curve(scale, x, ratio, slope, spread, peak)
          load = ratio * x**1.5_real64
          call check(load > load_before, 'the load falls')
          call check(1.5_real64 * ratio + x * slope > 0.0_real64, 'the slope is negative')
          call check(ratio <= 1.0_real64 + 1.0e-15_real64, 'the load is above that of Hertz')
          call check(spread >= 1.0_real64, 'the area is below that of Hertz')
          call check(peak > 1.0_real64, 'greatest pressure below the average')
          call check(peak, 1.25_real64, 0.25_real64, 'greatest over average pressure')
          load_before = load
        end do
      end do
    end do

    pair = pair_of(1.0_real64, 1.0_real64, 1.0_real64)
    law = plastic_law_with(0.42_real64, 1.0_real64, 1.0e-3_real64)
    do j = 0, 1
      law%largest = 8.0e-3_real64 * j
      before = contact_response()
      do i = 1, steps
        p = 0.03_real64 * i / steps
        call law%respond(pair, 1, p, answer)
        call check(answer%load >= before%load, 'the load falls with the approach')
        call check(answer%vertical_load >= before%vertical_load, 'the vertical load falls')
        call check(answer%contact_radius >= before%contact_radius, 'the area falls')
        before = answer
      end do
    end do
  end subroutine never_falls

  subroutine bounded
    real(real64), parameter :: nu(4) = [-1.0_real64, 0.0_real64, 0.32_real64, 0.5_real64]
    real(real64), parameter :: strain(4) = [1.0e-4_real64, 0.02_real64, 0.15_real64, 0.6_real64]
    type(contact_pair) :: pair
    type(plastic_law) :: law, virgin
    type(plastic_past) :: past
    type(contact_response) :: first, later
    real(real64) :: critical, work, residual, largest
    integer :: i, j, k, m

    pair = pair_of(2.0e6_real64, 2.0e6_real64, 0.0_real64)
    do j = 1, size(nu)
      do k = 1, size(strain)
        critical = strain(k)**2 * pair%radius
        law = plastic_law_with(nu(j), 1.0_real64, critical)
        virgin = law
        work = 0.0_real64
        residual = 0.0_real64
        do i = 1, 200
          largest = critical * (1.0_real64 + 1.0e-3_real64 * 1.05_real64**i)
          if (largest > 0.9_real64 * pair%s) exit
          call past_of_contact(law, pair, 1, largest, past)
          call check(past%flowed .eqv. largest > departure * critical, 'it has flowed')
          call check(past%work_lost > work, 'the work lost does not grow')
          call check(past%residual > residual, 'the residual overlap does not grow')
          work = past%work_lost
          residual = past%residual
          law%largest = largest
          do m = 1, 9
            call law%respond(pair, 1, largest * m / 10.0_real64, later)
            call virgin%respond(pair, 1, largest * m / 10.0_real64, first)
            call check(later%load < first%load, 'unloading is above loading')
          end do
        end do
        call check(i > 100, 'too few')
      end do
    end do
    call past_of_contact(law, pair, 1, critical, past)
    call check(.not. (past%flowed .or. past%work_lost > 0.0_real64 .or. &
                             past%residual > 0.0_real64), 'at first yield nothing has flowed')
  end subroutine bounded

end module asperity_plasticity_suite
