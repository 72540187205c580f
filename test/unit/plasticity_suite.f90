!> Tests of plastic flow: slope, memory, columns, extremes, and laws of the curves.
!>
!> test/effects/test_plasticity.py compares curves, unloading and onset with mpmath.
module asperity_plasticity_suite
  use asperity_contact_effect, only: contact_effect, effect_outcome
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_contact_state, only: contact_state, start_state, total_vertical_load
  use asperity_effect_helpers, only: act, as_decimal, pair_of, penetration_of, plastic_law_with, &
                                     set_number
  use asperity_first_yield, only: constraint_factor
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_plastic_curves, only: departure, loading_curve, plastic_scale, set_scale
  use asperity_plastic_law, only: past_of_contact, plastic_law, plastic_past
  use asperity_plasticity, only: new_plasticity
  use asperity_scene_values, only: effect_on, scene
  use asperity_testing, only: check, error_type, new_unittest, unittest_type
  implicit none
  private

  public :: collect_plasticity

  real(real64), parameter :: pi = acos(-1.0_real64)

contains

  !> Lists the tests.
  subroutine collect_plasticity(suite)
    !> all tests
    type(unittest_type), allocatable, intent(out) :: suite(:)

    allocate (suite(0))
    suite = [ &
      new_unittest('the stiffness is the slope of the vertical load', slopes), &
      new_unittest('the effect: memory, columns, estimate', whole_effect), &
      new_unittest('extreme numbers stay numbers', extremes), &
      new_unittest('the area power within and beyond the range of its fit', area_powers), &
      new_unittest('load and area never fall with the approach, from soft to rigid', never_falls), &
      new_unittest('unloading lies below loading, and loses more the further it was', bounded)]
  end subroutine collect_plasticity

  subroutine slopes(error)
    type(error_type), allocatable, intent(out) :: error
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
        call check(error, quotient, at%stiffness, 2.0e-9_real64 * at%stiffness, 'stiffness')
      end do
    end do
  end subroutine slopes

  ! Three pairs, one of which never comes to its limit, driven as the solver drives effects.
  subroutine whole_effect(error)
    type(error_type), allocatable, intent(out) :: error
    class(contact_effect), allocatable :: effect
    type(contact_pairs) :: pairs
    type(contact_state) :: state
    type(effect_outcome) :: outcome
    real(real64) :: elastic, load(4), share
    real(real64), parameter :: compression(4) = [0.01_real64, 0.05_real64, 0.03_real64, 0.05_real64]
    integer :: i

    call three_pairs(pairs)
    call plasticity_by_limit(effect)
    call effect%begin(pairs)
    do i = 1, size(compression)
      call start_state(pairs, hertz_law(modulus=pairs%modulus), compression(i), state)
      elastic = total_vertical_load(state)
      share = effect%estimate(pairs, state)
      call act(effect, pairs, state, outcome)
      load(i) = total_vertical_load(state)
      call check(error, outcome%simulated, 'on              ', 'how')
      call check(error, share, elastic / load(i) - 1.0_real64, 1.0e-14_real64, 'estimate')
      call check(error, outcome%of_state(1), elastic, 1.0e-14_real64 * elastic, 'elastic load')
      call check(error, nint(outcome%of_state(2)), merge(1, 0, mod(i, 2) == 0), 'flowing')
      call check(error, outcome%of_contacts(1, 1) > 0.5_real64 .eqv. i > 1, 'the first has flowed')
      call check(error, .not. any(outcome%of_contacts(2:, 1) > 0.0_real64), 'the others have not')
      call check(error, outcome%of_contacts(1, 3) < outcome%of_contacts(1, 2), 'residual')
      call check(error, outcome%of_state(3) > 0.0_real64 .eqv. i > 1, 'work lost')
      call effect%keep(pairs, state)
    end do
    call check(error, load(3) < 0.9_real64 * load(4), 'unloading')
    call check(error, load(4), load(2), 1.0e-14_real64 * load(2), 'loading again')
    ! A new position has no past.
    call effect%begin(pairs)
    call start_state(pairs, hertz_law(modulus=pairs%modulus), compression(1), state)
    call check(error, .not. effect%estimate(pairs, state) > 0.0_real64, 'the past is forgotten')
  end subroutine whole_effect

  subroutine extremes(error)
    type(error_type), allocatable, intent(out) :: error
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
          call check(error, all(abs([answer%overlap, answer%contact_radius, answer%load, &
                                     answer%vertical_load, answer%stiffness, &
                                     answer%maximum_pressure]) <= huge(1.0_real64)), 'not finite')
          call past_of_contact(law, pair, 1, max(law%largest(1), answer%overlap), past)
          call check(error, past%work_lost >= 0.0_real64 .and. &
                     past%work_lost <= huge(1.0_real64), 'work not finite')
        end do
      end do
    end do
  end subroutine extremes

  ! B = 0.14 exp(23 Sy/E) up to Sy/E = 1.619 (1 - 0.32**2)/200 = 0.0072661, constant beyond.
  subroutine area_powers(error)
    type(error_type), allocatable, intent(out) :: error
    type(plastic_scale) :: inside, outside

    call set_scale(1.6_real64, 0.8_real64 * pi * 0.0072_real64, inside)
    call check(error, inside%area_power, 0.16521413536821808_real64, 1.0e-14_real64, 'inside')
    call set_scale(1.6_real64, 0.8_real64 * pi * 0.01_real64, outside)
    call check(error, outside%area_power, 0.1654653948859781_real64, 1.0e-14_real64, 'beyond')
  end subroutine area_powers

  ! On first loading, and up and down below an earlier one.
  subroutine never_falls(error)
    type(error_type), allocatable, intent(out) :: error
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
          call check(error, load > load_before, 'the load falls')
          call check(error, 1.5_real64 * ratio + x * slope > 0.0_real64, 'the slope is negative')
          call check(error, ratio <= 1.0_real64 + 1.0e-15_real64, 'the load is above that of Hertz')
          call check(error, spread >= 1.0_real64, 'the area is below that of Hertz')
          call check(error, peak > 1.0_real64, 'greatest pressure below the average')
          call check(error, peak, 1.25_real64, 0.25_real64, 'greatest over average pressure')
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
        call check(error, answer%load >= before%load, 'the load falls with the approach')
        call check(error, answer%vertical_load >= before%vertical_load, 'the vertical load falls')
        call check(error, answer%contact_radius >= before%contact_radius, 'the area falls')
        before = answer
      end do
    end do
  end subroutine never_falls

  subroutine bounded(error)
    type(error_type), allocatable, intent(out) :: error
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
          call check(error, past%flowed .eqv. largest > departure * critical, 'it has flowed')
          call check(error, past%work_lost > work, 'the work lost does not grow')
          call check(error, past%residual > residual, 'the residual overlap does not grow')
          work = past%work_lost
          residual = past%residual
          law%largest = largest
          do m = 1, 9
            call law%respond(pair, 1, largest * m / 10.0_real64, later)
            call virgin%respond(pair, 1, largest * m / 10.0_real64, first)
            call check(error, later%load < first%load, 'unloading is above loading')
          end do
        end do
        call check(error, i > 100, 'too few')
      end do
    end do
    call past_of_contact(law, pair, 1, critical, past)
    call check(error, .not. (past%flowed .or. past%work_lost > 0.0_real64 .or. &
                             past%residual > 0.0_real64), 'at first yield nothing has flowed')
  end subroutine bounded

  ! Plasticity of bodies with Poisson's ratio 0.42 that flow from the limit of the scene on.
  subroutine plasticity_by_limit(effect)
    class(contact_effect), allocatable, intent(out) :: effect
    type(scene) :: scene_in

    call scene_in%effects%call_for('plasticity', effect_on)
    call set_number(scene_in, 'plastic_yield_stress', 0.0_real64)
    scene_in%upper%poisson_ratio = as_decimal(0.42_real64)
    scene_in%lower%poisson_ratio = as_decimal(0.42_real64)
    call new_plasticity(scene_in, effect)
  end subroutine plasticity_by_limit

  subroutine three_pairs(pairs)
    type(contact_pairs), intent(out) :: pairs

    pairs%modulus = 0.5_real64
    allocate (pairs%list(3))
    pairs%list = [pair_of(1.0_real64, 1.0_real64, 0.1_real64), &
                  pair_of(1.0_real64, 1.0_real64, 0.5_real64), &
                  pair_of(1.0_real64, 1.0_real64, 0.9_real64)]
    pairs%list%gap = [0.0_real64, 0.03_real64, 0.02_real64]
    pairs%list(:2)%limit = 0.025_real64
  end subroutine three_pairs

end module asperity_plasticity_suite
