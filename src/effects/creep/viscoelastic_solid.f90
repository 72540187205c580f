!> A linear viscoelastic solid: relaxation, creep compliance and one step of its memory.
!>
!> Relaxation is a Prony series: E(t)/E(0) = r + sum of g_k exp(-t/tau_k), r + sum of g_k = 1. With
!> it a load is the hereditary integral of the elastic load of the same contact (Lee and Radok 1960,
!> for contact areas that do not shrink),
!>
!>     P = r Pe + sum of q_k,     q_k' = -q_k/tau_k + g_k Pe'
!>
!> so that the history of a contact is one number q_k for each relaxation time. The compliance is
!> (Gross, Mathematical Structure of the Theories of Viscoelasticity, 1953)
!>
!>     J(t) E(0) = 1/r - sum of d_j exp(-m_j t/tau_j)
!>
!> where the rates l_j = m_j/tau_j are the roots of r = sum of g_k l tau_k/(1 - l tau_k), one below
!> each 1/tau_j. Over a step of loading the elastic load is assumed to change as A + B t, over one
!> of a hold as A + B J. This is its form in a hold of the load of all contacts after fast loading:
!> steps are exact there and in a hold of the separation. Otherwise the error is of second order in
!> the step.
module asperity_viscoelastic_solid
  use asperity_kinds, only: real64
  use asperity_scene_values, only: most_relaxations, scene
  implicit none
  private

  public :: relaxing_solid, solid_step
  public :: creep_compliance, history_of, hold_times, keep_load, new_solid, relaxation_ratio, &
            solid_of_scene, step_over

  ! Largest argument of exp, derived: exp(-700) is negligible beside 1, exp(700) does not overflow.
  real(real64), parameter :: largest_argument = 700.0_real64
  ! Argument below which 1 - x/2 is 1, derived from the spacing of doubles.
  real(real64), parameter :: least_argument = 1.0e-17_real64
  ! Bisections of a rate on a logarithmic scale: 690/2**60 is below rounding. Derived.
  integer, parameter :: bisections = 60

  !> A solid with a constant Poisson's ratio, and the time in which it is loaded.
  type :: relaxing_solid
    integer :: terms = 0                              !! number of relaxation times
    real(real64) :: relaxed_ratio = 1.0_real64        !! r, relaxed over instantaneous modulus
    real(real64) :: time(most_relaxations) = 0.0_real64     !! tau_k, ascending
    real(real64) :: share(most_relaxations) = 0.0_real64    !! g_k of the modulus
    real(real64) :: delayed(most_relaxations) = 0.0_real64  !! d_j of the compliance
    real(real64) :: slowing(most_relaxations) = 1.0_real64  !! m_j, rate of creep times tau_j
    real(real64) :: loading_time = 0.0_real64         !! time of loading; a hold begins there
  end type relaxing_solid

  !> Coefficients of one step: P_new = gain Pe_new - sum of growth Pe_old + sum of decay q_old.
  type :: solid_step
    integer :: terms = 0                        !! number of relaxation times
    real(real64) :: gain = 1.0_real64           !! r + sum of growth
    real(real64) :: decay(most_relaxations) = 1.0_real64   !! decay of the memory, exp(-h/tau_k)
    real(real64) :: growth(most_relaxations) = 0.0_real64  !! new memory over growth of Pe
  end type solid_step

contains

  !> Material of both bodies of a scene.
  pure function solid_of_scene(scene_in) result(solid)
    type(scene), intent(in) :: scene_in  !! scene with checked values
    type(relaxing_solid) :: solid

    associate (effects => scene_in%effects)
      if (allocated(effects%relaxation)) then
        solid = new_solid(effects%relaxation(:, 2), effects%relaxation(:, 1), &
                          effects%number('loading_time'))
      else
        solid = new_solid([effects%number('relaxed_modulus_ratio')], &
                          [effects%number('relaxation_time')], effects%number('loading_time'))
      end if
    end associate
  end function solid_of_scene

  !> Makes a solid from its modulus after the relaxation of each time.
  pure function new_solid(ratios, times, loading_time) result(solid)
    real(real64), intent(in) :: ratios(:)     !! over the instantaneous modulus, (0, 1], descending
    real(real64), intent(in) :: times(:)      !! relaxation times >= 0, ascending; several: > 0
    real(real64), intent(in) :: loading_time  !! time of loading, 0 or more
    type(relaxing_solid) :: solid
    real(real64) :: high, low, middle, over(size(times))
    integer :: cut, j, n

    n = size(times)
    solid%terms = n
    solid%loading_time = loading_time
    solid%relaxed_ratio = ratios(n)
    solid%time(:n) = times
    solid%share(:n) = [1.0_real64, ratios(:n - 1)] - ratios
    do j = 1, n
      over = 1.0_real64
      if (n > 1) over = times / times(j)
      low = ratios(n)
      if (j < n) low = times(j) / times(j + 1) * (1.0_real64 + 4 * epsilon(low))  ! beside a pole
      high = 1.0_real64
      do cut = 1, bisections
        middle = sqrt(low) * sqrt(high)
        if (.not. (middle > low .and. middle < high)) exit
        if (sum(solid%share(:n) * middle * over / (1.0_real64 - middle * over)) > ratios(n)) then
          high = middle
        else
          low = middle
        end if
      end do
      solid%slowing(j) = low
      if (low < 1.0_real64) solid%delayed(j) = 1.0_real64 / &
        sum(solid%share(:n) * low * over / (1.0_real64 - low * over)**2)
    end do
    ! Their sum is exact.
    if (any(solid%delayed > 0.0_real64)) solid%delayed = &
      solid%delayed / sum(solid%delayed) * ((1.0_real64 - ratios(n)) / ratios(n))
  end function new_solid

  !> E(t)/E(0), between r and 1: the load over that at time 0 in a hold of the separation.
  elemental real(real64) function relaxation_ratio(solid, time)
    type(relaxing_solid), intent(in) :: solid  !! material of both bodies
    real(real64), intent(in) :: time           !! time since loading, 0 or more

    relaxation_ratio = solid%relaxed_ratio + &
                       sum(solid%share * decay_of(time_over(time, solid%time)))
  end function relaxation_ratio

  !> J(t) E(0), between 1 and 1/r: the elastic load at the compression of a held load, over that
  !> load (Johnson, Contact Mechanics, 1985, section 6.5).
  elemental real(real64) function creep_compliance(solid, time)
    type(relaxing_solid), intent(in) :: solid  !! material of both bodies
    real(real64), intent(in) :: time           !! time since loading, 0 or more

    creep_compliance = 1.0_real64 + &
      sum(solid%delayed * growth_of(solid%slowing * time_over(time, solid%time)))
  end function creep_compliance

  !> The step from one time to another; elastic for equal times.
  elemental type(solid_step) function step_over(solid, from, to) result(step)
    type(relaxing_solid), intent(in) :: solid  !! material of both bodies
    real(real64), intent(in) :: from           !! time at its begin
    real(real64), intent(in) :: to             !! time at its end, >= from
    real(real64), dimension(solid%terms) :: before, creeping, weight, x
    integer :: k, n

    n = solid%terms
    step%terms = n
    x = time_over(to - from, solid%time(:n))
    step%decay(:n) = decay_of(x)
    step%growth(:n) = solid%share(:n) * mean_decay(x)
    if (.not. from < solid%loading_time) then
      creeping = solid%slowing(:n) * x
      before = solid%slowing(:n) * time_over(from - solid%loading_time, solid%time(:n))
      weight = 1.0_real64
      if (n > 1) weight = solid%delayed(:n) * solid%slowing(:n) / solid%time(:n) * solid%time(1) * &
                          decay_of(max(before - before(n), 0.0_real64))
      weight = weight / maxval(weight)
      ! Integral of exp(-(h - s)/tau_k) dJ(s) over that of dJ(s), without cancellation.
      do k = 1, n
        step%growth(k) = solid%share(k) * &
          sum(weight * decay_of(min(creeping, x(k))) * mean_decay(abs(x(k) - creeping))) / &
          sum(weight * mean_decay(creeping))
      end do
    end if
    step%gain = solid%relaxed_ratio + sum(step%growth(:n))
  end function step_over

  !> Load at the end of a step where the elastic load is then 0.
  pure real(real64) function history_of(step, elastic, relaxing) result(history)
    type(solid_step), intent(in) :: step       !! coefficients of the step
    real(real64), intent(in) :: elastic        !! elastic load Pe at its begin
    real(real64), intent(in) :: relaxing(:)    !! memory q_k at its begin

    history = sum(step%decay(:step%terms) * relaxing) - sum(step%growth(:step%terms)) * elastic
  end function history_of

  !> Sets elastic load and memory at the end of a step from the load there. Without contact the load
  !> is 0, and the elastic load that of the surface as it recovers.
  pure subroutine keep_load(step, load, elastic, relaxing)
    type(solid_step), intent(in) :: step           !! coefficients of the step
    real(real64), intent(in) :: load               !! load P at its end
    real(real64), intent(inout) :: elastic         !! Pe at its begin, then at its end
    real(real64), intent(inout) :: relaxing(:)     !! q_k at its begin, then at its end
    real(real64) :: before

    before = elastic
    elastic = (load - history_of(step, elastic, relaxing)) / step%gain
    relaxing = step%decay(:step%terms) * relaxing + &
               step%growth(:step%terms) * (elastic - before)
  end subroutine keep_load

  !> Times of the states of a hold: evenly spaced up to a fraction of the relaxation time, in equal
  !> ratios beyond it.
  pure function hold_times(hold_time, relaxation_time, points) result(times)
    real(real64), intent(in) :: hold_time        !! duration of the hold, 0 or more
    real(real64), intent(in) :: relaxation_time  !! relaxation time of the material
    integer, intent(in) :: points                !! number of states, 2 or more
    !> from 0 to `hold_time`, ascending; without a hold 0 alone
    real(real64) :: times(merge(points, 1, hold_time > 0.0_real64))
    real(real64) :: interval, span
    integer :: i

    ! Chosen: ratios over at most six decades; from ten holds on times are nearly even.
    interval = min(max(0.1_real64 * relaxation_time, 1.0e-6_real64 * hold_time), &
                   10.0_real64 * hold_time)
    times = 0.0_real64
    do i = 2, size(times)
      span = log(1.0_real64 + hold_time / interval) * (i - 1) / (size(times) - 1)
      times(i) = min(hold_time, interval * (exp(span) - 1.0_real64))
    end do
    times(size(times)) = hold_time
  end function hold_times

  ! A time over the relaxation time; huge where that overflows.
  elemental real(real64) function time_over(time, relaxation_time)
    real(real64), intent(in) :: time
    real(real64), intent(in) :: relaxation_time

    if (.not. time > 0.0_real64) then
      time_over = 0.0_real64
      return
    end if
    time_over = huge(time)
    ! The product overflows for no relaxation time below 1.
    if (relaxation_time < 1.0_real64) then
      if (time > relaxation_time * huge(time)) return
    end if
    time_over = time / relaxation_time
  end function time_over

  ! exp(-x) for x of 0 or more.
  elemental real(real64) function decay_of(x)
    real(real64), intent(in) :: x

    decay_of = 0.0_real64
    if (x < largest_argument) decay_of = exp(-x)
  end function decay_of

  ! 1 - exp(-x) for x of 0 or more, without cancellation.
  elemental real(real64) function growth_of(x)
    real(real64), intent(in) :: x

    if (x < largest_argument) then
      growth_of = 2.0_real64 * exp(-0.5_real64 * x) * sinh(0.5_real64 * x)
    else
      growth_of = 1.0_real64
    end if
  end function growth_of

  ! (1 - exp(-x))/x, the mean of exp(-x) from 0 to x.
  elemental real(real64) function mean_decay(x)
    real(real64), intent(in) :: x

    if (x > least_argument) then
      mean_decay = growth_of(x) / x
    else
      mean_decay = 1.0_real64
    end if
  end function mean_decay

end module asperity_viscoelastic_solid
