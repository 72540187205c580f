!> The states of a position, one after the other: on the way to its end, along a path of loads or
!> approaches, and through a hold.
module asperity_effect_path
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state, in_contact
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_effect_sequence, only: first_failure, simulate
  use asperity_kernel_real64, only: closings_on_the_way
  use asperity_kinds, only: real64
  use asperity_scene_values, only: control_compression, control_pressure, effect_off, hold_load, &
                                   is_load, scene
  use asperity_viscoelastic_solid, only: hold_times
  implicit none
  private

  public :: path_step, plan_states, plan_hold
  public :: to_closing, to_load, stay, as_before

  integer, parameter :: to_closing = 1  !! the step ends at a closing
  integer, parameter :: to_load = 2     !! the step ends at a load
  integer, parameter :: stay = 3        !! the step keeps the closing of the last state
  integer, parameter :: as_before = 4   !! the step keeps the load of the last state of loading

  !> The way to one state.
  type :: path_step
    integer :: kind = to_closing       !! `to_closing`, `to_load`, `stay` or `as_before`
    real(real64) :: value = 0.0_real64 !! the closing or the load, in the unit of the pairs
    real(real64) :: time = 0.0_real64  !! since the end of loading
    !> The load asked for, in the unit of the pairs; huge: none. Of `as_before` it is the one held.
    real(real64) :: load = huge(1.0_real64)
  end type path_step

contains

  !> The states of loading. `points` equal parts lie between one value of a path and the next.
  subroutine plan_states(scene_in, pairs, effects, closing, steps, failure)
    type(scene), intent(in) :: scene_in                       !! checked values
    type(contact_pairs), intent(in) :: pairs                  !! the position
    type(effect_box), intent(in) :: effects(:)                !! of the scene
    real(real64), intent(in) :: closing                       !! the end, without a path
    type(path_step), allocatable, intent(out) :: steps(:)     !! at least one
    !> a load of the path becomes 0 in the unit of the pairs, or why a beginning is not found
    character(len=:), allocatable, intent(out) :: failure
    real(real64), allocatable :: closings(:), gaps(:)
    real(real64) :: from, to
    integer :: i, j, parts, used

    if (.not. allocated(scene_in%loading%path)) then
      allocate (gaps(0))
      if (scene_in%loading%events) then
        gaps = pairs%list%gap
        if (scene_in%effects%mode('interaction') /= effect_off) &
          call find_beginnings(pairs, effects, closing, gaps, failure)
        if (allocated(failure)) return
      end if
      call closings_on_the_way(scene_in%loading%points, gaps, closing, closings)
      allocate (steps(size(closings)))
      steps%value = closings
      if (.not. is_load(scene_in%loading%control)) return
      associate (last => steps(size(steps)))
        last%load = pairs%target
        ! Behind others the state of the load is found once more: those may be remembered.
        if (size(steps) > 1) last%kind = to_load
      end associate
      return
    end if
    parts = max(1, scene_in%loading%points)
    allocate (steps(1 + parts * size(scene_in%loading%path)))
    if (is_load(scene_in%loading%control)) steps%kind = to_load
    used = 1
    from = 0.0_real64
    do i = 1, size(scene_in%loading%path)
      to = value_of(scene_in, pairs, scene_in%loading%path(i))
      if (is_load(scene_in%loading%control) .and. scene_in%loading%path(i)%digits /= 0 .and. &
          .not. abs(to) / real(parts, real64) > 0.0_real64) then
        failure = 'a load of the path is too small beside the moduli and lengths to be met'
        return
      end if
      do j = 1, parts
        used = used + 1
        steps(used)%value = from + (to - from) * (real(j, real64) / real(parts, real64))
      end do
      steps(used)%value = to
      from = to
    end do
    if (is_load(scene_in%loading%control)) steps%load = steps%value
    ! The curve begins at first touch.
    if (parts == 1) steps = steps(2:)
  end subroutine plan_states

  ! The closings, up to the last, at which contacts begin that are lowered by others. A contact
  ! penetrates by less than the closing since it began: the closing less the deepest penetration of
  ! the contacts that are new leads down to the first beginning, never past it. A contact that
  ! begins with a jump is found by halving.
  subroutine find_beginnings(pairs, effects, last, closings, failure)
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(in) :: effects(:)
    real(real64), intent(in) :: last
    real(real64), allocatable, intent(out) :: closings(:)          ! ascending, from first touch on
    character(len=:), allocatable, intent(inout) :: failure
    ! Error of a beginning over the last closing (chosen: the accuracy of a solve at a closing).
    real(real64), parameter :: precision = 1.0e-10_real64
    type(contact_state) :: state
    type(effect_outcome), allocatable :: outcomes(:)
    logical, dimension(size(pairs%list)) :: begun, fresh, first
    real(real64) :: at, low, high
    integer :: i

    closings = [0.0_real64]
    begun = .not. pairs%list%gap > 0.0_real64
    at = last
    do
      low = closings(size(closings))
      high = last
      do
        call simulate(pairs, effects, at, 0.0_real64, state, outcomes, .true.)
        call first_failure(effects, outcomes, failure)
        if (allocated(failure)) return
        fresh = in_contact(state, [(i, i=1, size(fresh))]) .and. .not. begun
        if (any(fresh)) then
          high = at
          first = fresh
          at = max(low, high - maxval(state%penetration, fresh))
          if (high - at <= precision * last) exit
        else if (.not. at < last) then
          return
        else
          low = at
        end if
        if (high - low <= precision * last) exit
        if (.not. at > low) at = 0.5_real64 * (low + high)
      end do
      closings = [closings, high]
      begun = begun .or. first
      at = last
    end do
  end subroutine find_beginnings

  !> The states of a hold after the last state of loading.
  subroutine plan_hold(scene_in, steps)
    type(scene), intent(in) :: scene_in                     !! checked values
    type(path_step), allocatable, intent(out) :: steps(:)   !! none without a hold
    real(real64), allocatable :: times(:)

    associate (effects => scene_in%effects)
      call hold_times(effects%number('hold_time'), effects%number('relaxation_time'), &
                      nint(effects%number('hold_points')), times)
      allocate (steps(size(times) - 1))
      steps%time = times(2:)
      steps%kind = merge(as_before, stay, nint(effects%number('hold')) == hold_load)
    end associate
  end subroutine plan_hold

  ! A value of the path in the unit of the pairs: a load, or the closing of an approach.
  real(real64) function value_of(scene_in, pairs, value)
    type(scene), intent(in) :: scene_in
    type(contact_pairs), intent(in) :: pairs
    type(decimal_value), intent(in) :: value

    if (scene_in%loading%control == control_pressure) then
      value_of = scale(decimal_to_real64(value), -4 * pairs%modulus_power) * &
                 scale(decimal_to_real64(scene_in%nominal_area), -8 * pairs%length_power)
    else if (is_load(scene_in%loading%control)) then
      value_of = scale(decimal_to_real64(value), &
                       -4 * (pairs%modulus_power + 2 * pairs%length_power))
    else if (scene_in%loading%control == control_compression) then
      value_of = scale(decimal_to_real64(value), -4 * pairs%length_power)
    else
      value_of = pairs%first_touch - scale(decimal_to_real64(value), -4 * pairs%length_power)
    end if
  end function value_of

end module asperity_effect_path
