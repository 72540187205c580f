!> The standard linear solid: relaxation, creep compliance and one step of its memory.
!>
!> Relaxation: E(t)/E(0) = r + (1 - r) exp(-t/tau). With it a load is the hereditary integral of the
!> elastic load of the same contact (Lee and Radok 1960, for contact areas that do not shrink),
!>
!>     P = r Pe + q,     q' = -q/tau + (1 - r) Pe'
!>
!> so that the history of a contact is one number, q. Over a step h the elastic load is assumed to
!> change as A + B exp(-r t/tau). This is its form in a hold of the load of all contacts: steps are
!> exact there and in a hold of the separation. Otherwise the error is of second order in the step.
module asperity_viscoelastic_solid
  use asperity_kinds, only: real64
  implicit none
  private

  public :: standard_linear_solid, solid_step
  public :: relaxation_ratio, creep_compliance, step_over, load_after, elastic_load_of, hold_times

  ! Largest argument of exp, derived: exp(-700) is negligible beside 1, exp(700) does not overflow.
  real(real64), parameter :: largest_argument = 700.0_real64
  ! Argument below which 1 - x/2 is 1, derived from the spacing of doubles.
  real(real64), parameter :: least_argument = 1.0e-17_real64

  !> A standard linear solid with a constant Poisson's ratio.
  type :: standard_linear_solid
    real(real64) :: relaxed_ratio = 1.0_real64    !! r, relaxed over instantaneous modulus, (0, 1]
    real(real64) :: relaxation_time = 0.0_real64  !! tau >= 0; 0: relaxes instantaneously
  end type standard_linear_solid

  !> Coefficients of one step: P_new = (r + growth) Pe_new - growth Pe_old + decay q_old.
  type :: solid_step
    real(real64) :: relaxed_ratio = 1.0_real64  !! r, relaxed over instantaneous modulus
    real(real64) :: decay = 1.0_real64          !! decay of the memory, exp(-h/tau)
    real(real64) :: growth = 0.0_real64         !! new memory over growth of the elastic load
  end type solid_step

contains

  !> E(t)/E(0), between r and 1: the load over that at time 0 in a hold of the separation.
  elemental real(real64) function relaxation_ratio(solid, time)
    type(standard_linear_solid), intent(in) :: solid  !! material of both bodies
    real(real64), intent(in) :: time                  !! time since loading, 0 or more
    real(real64) :: x

    x = time_over(time, solid%relaxation_time)
    relaxation_ratio = solid%relaxed_ratio + (1.0_real64 - solid%relaxed_ratio) * decay_of(x)
  end function relaxation_ratio

  !> J(t) E(0) = 1/r - (1/r - 1) exp(-r t/tau), between 1 and 1/r: the elastic load at the
  !> compression of a held load, over that load (Johnson, Contact Mechanics, 1985, section 6.5).
  elemental real(real64) function creep_compliance(solid, time)
    type(standard_linear_solid), intent(in) :: solid  !! material of both bodies
    real(real64), intent(in) :: time                  !! time since loading, 0 or more
    real(real64) :: r, x

    r = solid%relaxed_ratio
    x = r * time_over(time, solid%relaxation_time)
    creep_compliance = 1.0_real64 + ((1.0_real64 - r) / r) * growth_of(x)
  end function creep_compliance

  !> The step from one time to another; elastic for equal times.
  elemental type(solid_step) function step_over(solid, from, to) result(step)
    type(standard_linear_solid), intent(in) :: solid  !! material of both bodies
    real(real64), intent(in) :: from                  !! time at its begin
    real(real64), intent(in) :: to                    !! time at its end, >= from
    real(real64) :: r, x, slow

    r = solid%relaxed_ratio
    x = time_over(to - from, solid%relaxation_time)
    slow = r * x
    step%relaxed_ratio = r
    step%decay = decay_of(x)
    ! r (1 - exp(-(1-r) x))/(exp(r x) - 1), as a product of factors without cancellation.
    step%growth = (1.0_real64 - r) * mean_decay((1.0_real64 - r) * x) * decay_of(slow) / &
                  mean_decay(slow)
  end function step_over

  !> Computes load and memory at the end of a step.
  elemental subroutine load_after(step, elastic_before, elastic, memory, load)
    type(solid_step), intent(in) :: step        !! coefficients of the step
    real(real64), intent(in) :: elastic_before  !! elastic load at its begin
    real(real64), intent(in) :: elastic         !! elastic load at its end
    real(real64), intent(inout) :: memory       !! q at its begin, then at its end
    real(real64), intent(out) :: load           !! load P at its end

    memory = step%decay * memory + step%growth * (elastic - elastic_before)
    load = step%relaxed_ratio * elastic + memory
  end subroutine load_after

  !> Elastic load at the end of a step, from the load there.
  elemental function elastic_load_of(step, elastic_before, memory, load) result(elastic)
    type(solid_step), intent(in) :: step        !! coefficients of the step
    real(real64), intent(in) :: elastic_before  !! elastic load at its begin
    real(real64), intent(in) :: memory          !! q at its begin
    real(real64), intent(in) :: load            !! load P at its end
    real(real64) :: elastic

    elastic = (load - step%decay * memory + step%growth * elastic_before) / &
              (step%relaxed_ratio + step%growth)
  end function elastic_load_of

  !> Times of the states of a hold: evenly spaced up to a fraction of the relaxation time, in equal
  !> ratios beyond it.
  pure subroutine hold_times(hold_time, relaxation_time, points, times)
    real(real64), intent(in) :: hold_time                !! duration of the hold, 0 or more
    real(real64), intent(in) :: relaxation_time          !! relaxation time of the material
    integer, intent(in) :: points                        !! number of states, 2 or more
    real(real64), allocatable, intent(out) :: times(:)   !! from 0 to `hold_time`, ascending
    real(real64) :: interval, rise, span
    integer :: i, last

    if (.not. hold_time > 0.0_real64) then
      allocate (times(1))
      times = 0.0_real64
      return
    end if
    last = max(1, points - 1)
    allocate (times(last + 1))
    ! Chosen: ratios over at most six decades; from ten holds on times are nearly even.
    interval = min(max(0.1_real64 * relaxation_time, 1.0e-6_real64 * hold_time), &
                   10.0_real64 * hold_time)
    span = log(1.0_real64 + hold_time / interval)
    do i = 0, last
      rise = exp(span * i / last) - 1.0_real64
      times(i + 1) = min(hold_time, interval * rise)
    end do
    times(1) = 0.0_real64
    times(last + 1) = hold_time
  end subroutine hold_times

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
