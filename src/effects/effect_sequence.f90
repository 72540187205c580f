!> The effects of one state, one after the other: left out, estimated or simulated. Those that
!> `auto` leaves out are together within a tolerance.
module asperity_effect_sequence
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state, start_state, total_vertical_load
  use asperity_effect_names, only: why_not_together
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_scene_values, only: effect_auto, effect_boundary
  use asperity_theory_warnings, only: add_warning, of_together
  implicit none
  private

  public :: choose_effects, first_failure, found_state, simulate_effects

  !> A compression, the contacts there and the results of the search for it.
  type :: found_state
    real(real64) :: closing = 0.0_real64               !! compression, length, 0 or more
    real(real64) :: prescribed_load = huge(1.0_real64)  !! requested load; huge: none
    type(contact_state) :: state                       !! contacts with the effects
    type(effect_outcome), allocatable :: outcomes(:)   !! results of the effects
    !> By effect, for those of `auto`: whether it is simulated, regardless of its estimate; not
    !> allocated: its estimate decides.
    logical, allocatable :: called_for(:)
    !> Results of the search for the compression (pair, quantity), for the effect that searched; not
    !> allocated: no effect searched.
    real(real64), allocatable :: found(:, :)
  end type found_state

contains

  !> Computes the contacts at a compression with the effects that are called for.
  subroutine simulate_effects(pairs, effects, time, found, loading_only)
    type(contact_pairs), intent(in) :: pairs     !! pairs of the position
    type(effect_box), intent(in) :: effects(:)   !! effects of the scene, in their order of action
    real(real64), intent(in) :: time             !! time since the begin of loading, 0 or more
    type(found_state), intent(inout) :: found    !! compression and search; gets the state
    !> whether effects that act in time are left out; absent: .false.
    logical, intent(in), optional :: loading_only
    real(real64) :: before
    logical, allocatable :: called(:)
    character(len=:), allocatable :: why
    logical :: without_time
    integer :: i

    without_time = .false.
    if (present(loading_only)) without_time = loading_only
    if (allocated(found%outcomes)) deallocate (found%outcomes)
    allocate (found%outcomes(size(effects)))
    call start_state(pairs, hertz_law(modulus=pairs%modulus), found%closing, found%state)
    found%state%time = time
    if (pairs%interrupt%is_asked() .and. size(effects) > 0) then
      found%outcomes(1)%failure = 'interrupted'
      return
    end if
    if (allocated(found%found)) found%state%found = found%found
    call choose_effects(pairs, effects, found%state, found%outcomes, called, found%state%left)
    why = 'estimate above tolerance'
    if (allocated(found%called_for)) then
      why = 'estimate at tolerance'
      do i = 1, size(effects)
        if (effects(i)%effect%mode == effect_auto) called(i) = found%called_for(i)
      end do
    end if
    do i = 1, size(effects)
      associate (effect => effects(i)%effect, outcome => found%outcomes(i))
        if (without_time .and. effect%acts_in_time) cycle
        if (called(i) .and. effect%approximates .and. effect%mode == effect_auto .and. &
            .not. allocated(found%called_for)) then
          ! Effects before this one may have changed the contact law and so its estimate.
          outcome%estimate = effect%estimate(pairs, found%state)
          called(i) = outcome%estimate > found%state%left
        end if
        if (.not. called(i)) then
          call effect%leave_out(pairs, found%state, outcome)
          cycle
        end if
        if (effect%mode == effect_auto) outcome%why = why
        before = total_vertical_load(found%state)
        call effect%apply(pairs, found%state, outcome)
        if (allocated(outcome%failure)) return
        if (before > 0.0_real64 .and. .not. outcome%influence_known) &
          outcome%influence = total_vertical_load(found%state) / before - 1.0_real64
      end associate
    end do
    do i = 1, size(effects)
      call effects(i)%effect%finish(pairs, found%state, found%outcomes(i))
    end do
  end subroutine simulate_effects

  !> Message of the first effect that failed. It is unchanged when no effect failed.
  subroutine first_failure(effects, outcomes, failure)
    type(effect_box), intent(in) :: effects(:)                 !! effects of the scene
    type(effect_outcome), intent(in) :: outcomes(:)            !! their results in one state
    character(len=:), allocatable, intent(inout) :: failure    !! name of the effect and reason
    integer :: i

    do i = size(effects), 1, -1
      if (allocated(outcomes(i)%failure)) &
        failure = trim(effects(i)%effect%name) // ': ' // outcomes(i)%failure
    end do
  end subroutine first_failure

  !> Chooses effects by their estimates for a state without effects.
  !>
  !> The effects with the smallest estimates are left out as long as their sum is within the
  !> tolerance, or within half of it where an effect is simulated that approximates: the rest, at
  !> least the other half, is for its own error. Of two effects without a common theory the one with
  !> the larger estimate is simulated, with a warning for the other; an effect that is `on`, or acts
  !> in the hold, has precedence.
  subroutine choose_effects(pairs, effects, state, outcomes, called, left)
    type(contact_pairs), intent(in) :: pairs             !! pairs of the position
    type(effect_box), intent(in) :: effects(:)           !! effects of the scene
    type(contact_state), intent(in) :: state             !! contacts without effects
    type(effect_outcome), intent(inout) :: outcomes(:)   !! results of each effect: its estimate
    logical, allocatable, intent(out) :: called(:)       !! whether each effect is simulated
    real(real64), intent(out) :: left                    !! tolerance of the simulated effects
    integer :: order(size(effects)), i, number
    real(real64) :: tolerance

    allocate (called(size(effects)))
    tolerance = 1.0_real64
    left = 1.0_real64
    number = 0
    do i = 1, size(effects)
      associate (effect => effects(i)%effect)
        called(i) = effect%mode /= effect_auto
        if (called(i)) cycle
        tolerance = min(tolerance, effect%tolerance)
        outcomes(i)%estimate = effect%estimate(pairs, state)
        ! A hold has states because loading ended with an effect that acts in time.
        called(i) = effect%acts_in_time .and. state%time > 0.0_real64
        if (.not. called(i)) call insert_effect(i)
      end associate
    end do
    if (number == 0) return
    call drop_smallest(tolerance)
    do i = 1, number
      if (called(order(i)) .and. effects(order(i))%effect%approximates) then
        call drop_smallest(0.5_real64 * tolerance)
        exit
      end if
    end do
    ! At least half of the tolerance: effects that are `on` may approximate, too.
    left = max(0.5_real64 * tolerance, tolerance - sum(outcomes%estimate, .not. called))
    call exclude_conflicts(effects, order(:number), outcomes, called)

  contains

    ! Inserts an effect into the order of descending estimates; equal ones keep their order.
    subroutine insert_effect(effect)
      integer, intent(in) :: effect
      integer :: at

      at = number
      do while (at > 0)
        if (outcomes(order(at))%estimate >= outcomes(effect)%estimate) exit
        order(at + 1) = order(at)
        at = at - 1
      end do
      order(at + 1) = effect
      number = number + 1
    end subroutine insert_effect

    ! Leaves out the effects with the smallest estimates while their sum is within a share.
    subroutine drop_smallest(share)
      real(real64), intent(in) :: share
      real(real64) :: total
      integer :: k

      total = 0.0_real64
      do k = number, 1, -1
        ! An estimate may be huge: it is not added before the comparison.
        called(order(k)) = outcomes(order(k))%estimate > share - total
        if (.not. called(order(k))) total = total + outcomes(order(k))%estimate
      end do
    end subroutine drop_smallest

  end subroutine choose_effects

  ! Leaves out, with a warning, effects of `auto` without a common theory with one of precedence:
  ! one that is `on` or acts in the hold, then those of `auto` by descending estimate.
  subroutine exclude_conflicts(effects, order, outcomes, called)
    type(effect_box), intent(in) :: effects(:)
    integer, intent(in) :: order(:)  ! effects of `auto` by descending estimate
    type(effect_outcome), intent(inout) :: outcomes(:)
    logical, intent(inout) :: called(:)
    integer :: i, other

    do i = 1, size(order)
      do other = 1, size(effects)
        if (.not. (called(order(i)) .and. called(other))) cycle
        if (any(order(i:) == other)) cycle
        if (why_not_together(trim(effects(order(i))%effect%name), mode_word(order(i)), &
                             trim(effects(other)%effect%name), mode_word(other)) == '') cycle
        called(order(i)) = .false.
        call add_warning(outcomes(order(i))%warnings, of_together, outcomes(order(i))%estimate, &
                         whose=trim(effects(order(i))%effect%name) // ' beside ' // &
                               effects(other)%effect%name)
      end do
    end do

  contains

    ! The mode in which an effect would be simulated, as far as other effects depend on it.
    function mode_word(effect) result(word)
      integer, intent(in) :: effect
      character(len=:), allocatable :: word

      word = 'on'
      if (effects(effect)%effect%mode == effect_boundary) word = 'boundary'
    end function mode_word

  end subroutine exclude_conflicts

end module asperity_effect_sequence
