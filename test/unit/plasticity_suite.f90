!> Tests of plastic flow in the solver: slope, work of cycles, memory, columns, onset, extremes.
!>
!> Truths are closed forms, and balances of work by quadrature.
module asperity_plasticity_suite
  use asperity_contact_effect, only: contact_effect, effect_outcome
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_contact_state, only: contact_state, start_state, total_vertical_load
  use asperity_effect_helpers, only: act, as_decimal, pair_of, penetration_of, plastic_law_with, &
                                     same, set_number
  use asperity_hertz_law, only: hertz_law
  use asperity_kernel_real64, only: stable_overlap
  use asperity_kinds, only: real64
  use asperity_plastic_curves, only: departure
  use asperity_plastic_law, only: past_of_contact, plastic_law, plastic_past
  use asperity_plasticity, only: new_plasticity
  use asperity_scene_values, only: criterion_hardy, criterion_load, effect_on, scene
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
      new_unittest('work of closed cycles, below and past the onset, inclined', cycles), &
      new_unittest('a million cycles do not drift', million), &
      new_unittest('the effect: memory, columns, estimate', whole_effect), &
      new_unittest('the onset by the limit, a hair below and above', by_limit), &
      new_unittest('the onset by a yield stress, in any unit', by_yield_stress), &
      new_unittest('extreme numbers stay numbers', extremes)]
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

  ! The work of the vertical load, by Gauss points, along closed paths.
  subroutine cycles(error)
    type(error_type), allocatable, intent(out) :: error
    real(real64), parameter :: critical = 1.0e-3_real64
    type(contact_pair) :: pair
    type(plastic_law) :: law
    type(plastic_past) :: past
    real(real64) :: onset, up, down, again, most, residual

    pair = pair_of(1.0_real64, 1.0_real64, 1.2_real64)
    law = plastic_law_with(0.42_real64, 1.0_real64, critical)

    ! Below first yield: what went in comes out.
    most = penetration_of(pair, 0.999_real64 * critical)
    up = work(law, pair, 0.0_real64, most)
    law%largest = stable_overlap(pair%s, pair%d, pair%zc, pair%rest, most)
    down = work(law, pair, 0.0_real64, most)
    call check(error, up, down, 1.0e-10_real64 * up, 'an elastic cycle')
    call check(error, up > 0.0_real64, 'work goes in')

    ! Past it: what is lost is what the law says.
    law%largest = 0.0_real64
    onset = penetration_of(pair, departure * critical)
    most = penetration_of(pair, 8.0_real64 * critical)
    up = work(law, pair, 0.0_real64, onset) + &
         work(law, pair, onset, penetration_of(pair, 6.0_real64 * critical)) + &
         work(law, pair, penetration_of(pair, 6.0_real64 * critical), most)
    call past_of_contact(law, pair, 1, 8.0_real64 * critical, past)
    law%largest = 8.0_real64 * critical
    residual = penetration_of(pair, past%residual)
    down = work(law, pair, residual, most)
    call check(error, up > down .and. down > 0.0_real64, 'a plastic cycle loses work')
    call check(error, up - down, past%work_lost, 1.0e-8_real64 * up, 'work lost')
    call check(error, .not. work(law, pair, 0.0_real64, residual) > 0.0_real64, 'it stays open')

    ! The second cycle to the same place is elastic; a further one loses more.
    again = work(law, pair, residual, most)
    call check(error, again, down, 1.0e-10_real64 * down, 'the second cycle')
    call past_of_contact(law, pair, 1, 9.0_real64 * critical, past)
    call check(error, past%work_lost > up - down, 'further')
  end subroutine cycles

  ! Loading to 8 critical overlaps and back, a million times, with the memory of the effect.
  subroutine million(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pair) :: pair
    type(plastic_law) :: law
    type(contact_response) :: top, bottom, first_top, first_bottom
    real(real64) :: high, low
    integer :: i

    pair = pair_of(1.0_real64, 1.0_real64, 0.5_real64)
    law = plastic_law_with(0.42_real64, 1.0_real64, 1.0e-3_real64)
    high = penetration_of(pair, 8.0e-3_real64)
    low = penetration_of(pair, 5.0e-3_real64)
    do i = 1, 1000000
      call law%respond(pair, 1, high, top)
      law%largest(1) = max(law%largest(1), top%overlap)
      call law%respond(pair, 1, low, bottom)
      law%largest(1) = max(law%largest(1), bottom%overlap)
      if (i == 1) then
        first_top = top
        first_bottom = bottom
      end if
    end do
    call check(error, same(top, first_top) .and. same(bottom, first_bottom), 'it drifts')
    call check(error, top%load > bottom%load .and. bottom%load > 0.0_real64, 'loads')
  end subroutine million

  ! Three pairs, one of which never comes to its limit, driven as the solver drives effects.
  subroutine whole_effect(error)
    type(error_type), allocatable, intent(out) :: error
    class(contact_effect), allocatable :: effect
    type(contact_pairs) :: pairs
    type(contact_state) :: state
    type(effect_outcome) :: outcome
    real(real64) :: elastic, load(4), share
    real(real64), parameter :: closing(4) = [0.01_real64, 0.05_real64, 0.03_real64, 0.05_real64]
    integer :: i

    call three_pairs(pairs)
    call plasticity_of(0.0_real64, criterion_load, effect)
    call effect%begin(pairs)
    do i = 1, size(closing)
      call start_state(pairs, hertz_law(modulus=pairs%modulus), closing(i), state)
      elastic = total_vertical_load(state)
      share = effect%estimate(pairs, state)
      call act(effect, pairs, state, outcome)
      load(i) = total_vertical_load(state)
      call check(error, outcome%simulated, 'on              ', 'how')
      call check(error, share, 1.0_real64 - load(i) / elastic, 1.0e-14_real64, 'estimate')
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
    call start_state(pairs, hertz_law(modulus=pairs%modulus), closing(1), state)
    call check(error, .not. effect%estimate(pairs, state) > 0.0_real64, 'the past is forgotten')
  end subroutine whole_effect

  ! A limit that is the onset, and one that is the first yield: the onset is 1.9 times its overlap.
  subroutine by_limit(error)
    type(error_type), allocatable, intent(out) :: error
    class(contact_effect), allocatable :: effect
    type(contact_pairs) :: pairs
    type(contact_state) :: state
    type(effect_outcome) :: outcome
    real(real64), parameter :: hair(3) = [-1.0e-9_real64, 0.0_real64, 1.0e-9_real64]
    real(real64) :: onset
    integer :: i, k

    call three_pairs(pairs)
    do k = 1, 2
      call plasticity_of(0.0_real64, merge(criterion_hardy, criterion_load, k == 2), effect)
      call effect%begin(pairs)
      onset = 0.025_real64
      associate (pair => pairs%list(1))
        if (k == 2) onset = penetration_of(pair, 1.9_real64 * stable_overlap( &
                                           pair%s, pair%d, pair%zc, pair%rest, onset))
      end associate
      do i = 1, size(hair)
        call start_state(pairs, hertz_law(modulus=pairs%modulus), &
                         onset * (1.0_real64 + hair(i)), state)
        call act(effect, pairs, state, outcome)
        call check(error, outcome%of_contacts(1, 1) > 0.5_real64 .eqv. i == 3, 'a hair off')
        call check(error, total_vertical_load(state), outcome%of_state(1), &
                   1.0e-9_real64 * outcome%of_state(1), 'the load at the onset')
      end do
    end do
  end subroutine by_limit

  subroutine by_yield_stress(error)
    type(error_type), allocatable, intent(out) :: error
    class(contact_effect), allocatable :: effect
    type(contact_pairs) :: pairs
    type(contact_state) :: state
    type(effect_outcome) :: outcome
    real(real64) :: critical, load(-1:1), c
    integer :: power

    c = 1.295_real64 * exp(0.736_real64 * 0.42_real64)
    do power = -1, 1
      call three_pairs(pairs)
      pairs%modulus_power = power
      ! The yield stress in the unit of the scene, so that it is 0.02 in that of the pairs.
      call plasticity_of(0.02_real64 * 16.0_real64**power, criterion_hardy, effect)
      call effect%begin(pairs)
      call start_state(pairs, hertz_law(modulus=pairs%modulus), 0.05_real64, state)
      call act(effect, pairs, state, outcome)
      load(power) = total_vertical_load(state)
    end do
    call check(error, load(-1), load(0), 1.0e-15_real64, 'a smaller unit')
    call check(error, load(1), load(0), 1.0e-15_real64, 'a larger unit')
    critical = (pi * c * 0.02_real64 / (2.0_real64 * pairs%modulus))**2 * pairs%list(1)%radius
    call check(error, outcome%of_contacts(1, 1) > 0.5_real64 .eqv. &
               outcome%of_contacts(1, 2) > 1.9_real64 * critical, 'onset')
    call check(error, outcome%of_contacts(1, 1) > 0.5_real64, 'the first has flowed')
    ! A yield stress just too large for the first contact.
    critical = outcome%of_contacts(1, 2) / 1.8999_real64
    call plasticity_of(16.0_real64 * sqrt(critical / pairs%list(1)%radius) * 2.0_real64 * &
                       pairs%modulus / (pi * c), criterion_load, effect)
    call effect%begin(pairs)
    call act(effect, pairs, state, outcome)
    call check(error, outcome%of_contacts(1, 1) < 0.5_real64, 'the first has flowed too early')
  end subroutine by_yield_stress

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

  ! Work of the vertical load from one penetration to another. The path between the load's zero and
  ! the end is stretched so that powers near 3/2 are integrated to rounding.
  function work(law, pair, from, to) result(sum)
    type(plastic_law), intent(in) :: law
    type(contact_pair), intent(in) :: pair
    real(real64), intent(in) :: from, to
    real(real64), parameter :: node(3) = [0.2386191860831969_real64, 0.6612093864662645_real64, &
                                          0.9324695142031521_real64]
    real(real64), parameter :: weight(3) = [0.4679139345726910_real64, 0.3607615730481386_real64, &
                                            0.1713244923791704_real64]
    integer, parameter :: panels = 200
    type(contact_response) :: answer
    real(real64) :: sum, t
    integer :: i, j, side

    sum = 0.0_real64
    do i = 1, panels
      do j = 1, size(node)
        do side = -1, 1, 2
          t = (i - 0.5_real64 + 0.5_real64 * side * node(j)) / panels
          call law%respond(pair, 1, from + (to - from) * t**4, answer)
          sum = sum + 0.5_real64 * weight(j) / panels * 4.0_real64 * t**3 * (to - from) * &
                answer%vertical_load
        end do
      end do
    end do
  end function work

  ! Plasticity of bodies with Poisson's ratio 0.42, as a scene names it.
  subroutine plasticity_of(yield_stress, criterion, effect)
    real(real64), intent(in) :: yield_stress
    integer, intent(in) :: criterion
    class(contact_effect), allocatable, intent(out) :: effect
    type(scene) :: scene_in

    call scene_in%effects%call_for('plasticity', effect_on)
    call set_number(scene_in, 'plastic_yield_stress', yield_stress)
    scene_in%upper%poisson_ratio = as_decimal(0.42_real64)
    scene_in%lower%poisson_ratio = as_decimal(0.42_real64)
    scene_in%limit%criterion = criterion
    call new_plasticity(scene_in, effect)
  end subroutine plasticity_of

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
