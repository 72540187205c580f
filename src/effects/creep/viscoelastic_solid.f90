!> The standard linear solid: how it relaxes, how it creeps, and one step of its memory.
!>
!> Relaxation: E(t)/E(0) = r + (1 - r) exp(-t/tau). With it a load is the hereditary integral of the
!> elastic load of the same contact (Lee and Radok 1960, for contact areas that do not shrink),
!>
!>     P = r Pe + q,     q' = -q/tau + (1 - r) Pe'
!>
!> so that one number a contact, q, holds the whole past. Over a step h the elastic load is taken to
!> run from its old to its new value as A + B exp(-r t/tau). So it runs where the load of all
!> contacts is held, so the steps are exact there and where the approach is held. Otherwise the
!> error falls with the square of the step.
module asperity_viscoelastic_solid
  use asperity_kinds, only: real64
  implicit none
  private

  public :: standard_linear_solid, solid_step
  public :: relaxation, creep_compliance, step_over, loaded, elastic_load_of, hold_times

  ! Where exp(-x) is nothing beside one, and where exp(x) is still in range.
  real(real64), parameter :: most = 700.0_real64
  ! Below it 1 - x/2 is 1.
  real(real64), parameter :: least = 1.0e-17_real64

  !> A standard linear solid with a constant Poisson's ratio.
  type :: standard_linear_solid
    real(real64) :: relaxed_ratio = 1.0_real64    !! r, relaxed over instantaneous modulus, (0, 1]
    real(real64) :: relaxation_time = 0.0_real64  !! tau, 0 or more: 0 relaxes in no time
  end type standard_linear_solid

  !> What one step does: P_new = (r + growth) Pe_new - growth Pe_old + decay q_old.
  type :: solid_step
    real(real64) :: relaxed_ratio = 1.0_real64  !! r
    real(real64) :: decay = 1.0_real64          !! what is left of the memory, exp(-h/tau)
    real(real64) :: growth = 0.0_real64         !! new memory over growth of the elastic load
  end type solid_step

contains

  !> E(t)/E(0), between r and 1: the load over that at once after loading, at a held approach.
  elemental real(real64) function relaxation(solid, time)
    type(standard_linear_solid), intent(in) :: solid  !! the material
    real(real64), intent(in) :: time                  !! since loading, 0 or more
    real(real64) :: x

    x = time_over(time, solid%relaxation_time)
    relaxation = solid%relaxed_ratio + (1.0_real64 - solid%relaxed_ratio) * left(x)
  end function relaxation

  !> J(t) E(0) = 1/r - (1/r - 1) exp(-r t/tau), between 1 and 1/r: the elastic load at the closing
  !> of a held load, over that load (Johnson, Contact Mechanics, 1985, section 6.5).
  elemental real(real64) function creep_compliance(solid, time)
    type(standard_linear_solid), intent(in) :: solid  !! the material
    real(real64), intent(in) :: time                  !! since loading, 0 or more
    real(real64) :: r, x

    r = solid%relaxed_ratio
    x = r * time_over(time, solid%relaxation_time)
    creep_compliance = 1.0_real64 + ((1.0_real64 - r) / r) * lost(x)
  end function creep_compliance

  !> The step from one time to another. No time: an elastic step.
  elemental type(solid_step) function step_over(solid, from, to) result(step)
    type(standard_linear_solid), intent(in) :: solid  !! the material
    real(real64), intent(in) :: from                  !! where the step begins
    real(real64), intent(in) :: to                    !! where it ends, not before
    real(real64) :: r, x, slow

    r = solid%relaxed_ratio
    x = time_over(to - from, solid%relaxation_time)
    slow = r * x
    step%relaxed_ratio = r
    step%decay = left(x)
    ! r (1 - exp(-(1-r) x))/(exp(r x) - 1), as a product of factors without cancellation.
    step%growth = (1.0_real64 - r) * mean_of((1.0_real64 - r) * x) * left(slow) / mean_of(slow)
  end function step_over

  !> Load at the end of a step. `memory` becomes that of the end.
  elemental subroutine loaded(step, elastic_before, elastic, memory, load)
    type(solid_step), intent(in) :: step        !! the step
    real(real64), intent(in) :: elastic_before  !! elastic load at its begin
    real(real64), intent(in) :: elastic         !! elastic load at its end
    real(real64), intent(inout) :: memory       !! q
    real(real64), intent(out) :: load           !! P at the end

    memory = step%decay * memory + step%growth * (elastic - elastic_before)
    load = step%relaxed_ratio * elastic + memory
  end subroutine loaded

  !> Elastic load at the end of a step, from the load there.
  elemental function elastic_load_of(step, elastic_before, memory, load) result(elastic)
    type(solid_step), intent(in) :: step        !! the step
    real(real64), intent(in) :: elastic_before  !! elastic load at its begin
    real(real64), intent(in) :: memory          !! q at its begin
    real(real64), intent(in) :: load            !! P at its end
    real(real64) :: elastic

    elastic = (load - step%decay * memory + step%growth * elastic_before) / &
              (step%relaxed_ratio + step%growth)
  end function elastic_load_of

  !> Times of the states of a hold: evenly spaced while well below the relaxation time, by equal
  !> factors beyond it.
  pure subroutine hold_times(hold_time, relaxation_time, points, times)
    real(real64), intent(in) :: hold_time                !! how long, 0 or more
    real(real64), intent(in) :: relaxation_time          !! of the material, 0 or more
    integer, intent(in) :: points                        !! number of states, 2 or more
    real(real64), allocatable, intent(out) :: times(:)   !! from 0 to `hold_time`, ascending
    real(real64) :: even, rise, span
    integer :: i, last

    if (.not. hold_time > 0.0_real64) then
      allocate (times(1))
      times = 0.0_real64
      return
    end if
    last = max(1, points - 1)
    allocate (times(last + 1))
    ! Six decades at most. Ten holds or more: nearly even all over.
    even = min(max(0.1_real64 * relaxation_time, 1.0e-6_real64 * hold_time), &
               10.0_real64 * hold_time)
    span = log(1.0_real64 + hold_time / even)
    do i = 0, last
      rise = exp(span * i / last) - 1.0_real64
      times(i + 1) = min(hold_time, even * rise)
    end do
    times(1) = 0.0_real64
    times(last + 1) = hold_time
  end subroutine hold_times

  ! A time in relaxation times; huge where that is out of range.
  elemental real(real64) function time_over(time, relaxation_time)
    real(real64), intent(in) :: time
    real(real64), intent(in) :: relaxation_time

    if (.not. time > 0.0_real64) then
      time_over = 0.0_real64
      return
    end if
    time_over = huge(time)
    ! Nothing overflows: the product is asked for only below one.
    if (relaxation_time < 1.0_real64) then
      if (time > relaxation_time * huge(time)) return
    end if
    time_over = time / relaxation_time
  end function time_over

  ! exp(-x) for x of 0 or more.
  elemental real(real64) function left(x)
    real(real64), intent(in) :: x

    left = 0.0_real64
    if (x < most) left = exp(-x)
  end function left

  ! 1 - exp(-x) for x of 0 or more, without cancellation.
  elemental real(real64) function lost(x)
    real(real64), intent(in) :: x

    if (x < most) then
      lost = 2.0_real64 * exp(-0.5_real64 * x) * sinh(0.5_real64 * x)
    else
      lost = 1.0_real64
    end if
  end function lost

  ! (1 - exp(-x))/x, the mean of exp(-x) from 0 to x.
  elemental real(real64) function mean_of(x)
    real(real64), intent(in) :: x

    if (x > least) then
      mean_of = lost(x) / x
    else
      mean_of = 1.0_real64
    end if
  end function mean_of

end module asperity_viscoelastic_solid
