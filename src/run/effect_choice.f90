!> Which of the effects of a state `auto` calls for, so that all it leaves out together stays within
!> one tolerance.
module asperity_effect_choice
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state
  use asperity_effect_names, only: why_not_together
  use asperity_kinds, only: real64
  use asperity_scene_values, only: by_default, effect_auto, effect_boundary
  use asperity_theory_warnings, only: of_together, warn
  implicit none
  private

  public :: choose_effects

contains

  !> Chooses from the estimates of a state without effects. What is smallest is left out first, as
  !> long as the sum of all that is left out stays within the tolerance, or within half of it where
  !> an effect is simulated that leaves something out itself: it gets the rest, at least the other
  !> half. Of two effects without a common theory the one with the larger estimate is simulated and
  !> the other one warned of; one that is `on` comes first. The outcomes get the estimates.
  subroutine choose_effects(pairs, effects, state, outcomes, called, left)
    type(contact_pairs), intent(in) :: pairs               !! the position
    type(effect_box), intent(in) :: effects(:)             !! of the scene
    type(contact_state), intent(in) :: state               !! contacts without effects
    type(effect_outcome), intent(inout) :: outcomes(:)     !! of each effect
    logical, allocatable, intent(out) :: called(:)         !! which of them to simulate
    real(real64), intent(out) :: left                      !! of the tolerance, for those simulated
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
        call put_in_order(i)
      end associate
    end do
    if (number == 0) return
    call share_out(tolerance)
    do i = 1, number
      if (called(order(i)) .and. effects(order(i))%effect%approximates) then
        call share_out(0.5_real64 * tolerance)
        exit
      end if
    end do
    ! Never less than that half: what is simulated for another reason needs it, too.
    left = max(0.5_real64 * tolerance, tolerance - sum(outcomes%estimate, .not. called))
    do i = 1, number
      if (called(order(i)) .and. is_asked_for(order(i))) call keep_together(order(i))
    end do
    do i = 1, number
      if (called(order(i)) .and. .not. is_asked_for(order(i))) call keep_together(order(i))
    end do

  contains

    ! Takes an effect into the order of falling estimates; equals stay in the order of the list.
    subroutine put_in_order(effect)
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
    end subroutine put_in_order

    ! Leaves out the smallest ones while their sum is within a share.
    subroutine share_out(share)
      real(real64), intent(in) :: share
      real(real64) :: total
      integer :: k

      total = 0.0_real64
      do k = number, 1, -1
        ! An estimate may be huge.
        called(order(k)) = outcomes(order(k))%estimate > share - total
        if (.not. called(order(k))) total = total + outcomes(order(k))%estimate
      end do
    end subroutine share_out

    ! Leaves an effect out when one that comes before it has no common theory with it.
    subroutine keep_together(effect)
      integer, intent(in) :: effect
      integer :: other

      do other = 1, size(effects)
        if (other == effect .or. .not. called(other)) cycle
        if (effects(other)%effect%mode == effect_auto) then
          if (is_asked_for(other) .neqv. is_asked_for(effect)) then
            if (is_asked_for(effect)) cycle
          else if (place_of(other) > place_of(effect)) then
            cycle
          end if
        end if
        if (why_not_together(trim(effects(effect)%effect%name), way_of(effect), &
                             trim(effects(other)%effect%name), way_of(other)) == '') cycle
        called(effect) = .false.
        call warn(outcomes(effect)%warnings, of_together, outcomes(effect)%estimate, &
                  whose=trim(effects(effect)%effect%name) // ' beside ' // &
                        effects(other)%effect%name)
        return
      end do
    end subroutine keep_together

    ! Whether the scene writes an effect or gives its numbers.
    logical function is_asked_for(effect)
      integer, intent(in) :: effect

      is_asked_for = effects(effect)%effect%given > by_default
    end function is_asked_for

    integer function place_of(effect)
      integer, intent(in) :: effect

      place_of = findloc(order(:number), effect, 1)
    end function place_of

    ! How an effect would be simulated, as far as that matters to others.
    function way_of(effect) result(way)
      integer, intent(in) :: effect
      character(len=:), allocatable :: way

      way = 'on'
      if (effects(effect)%effect%mode == effect_boundary) way = 'boundary'
    end function way_of

  end subroutine choose_effects

end module asperity_effect_choice
