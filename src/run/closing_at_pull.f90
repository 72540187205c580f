!> The closing at which contacts that attract each other bear a load, on the way back.
!>
!> Coming back from where they press, the load falls, and jumps up wherever a contact lets go.
!> Between two such closings it is convex: the curve of a contact that adheres rises ever steeper
!> from where it lets go. So the first place at which the load has fallen to what is asked for is
!> found interval by interval, with the least load of each by golden section; it is also where a
!> dead weight that pulls would hang.
module asperity_closing_at_pull
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_pairs, only: contact_pairs, in_scene_units
  use asperity_contact_state, only: contact_state, load_asked_for
  use asperity_effect_sequence, only: first_failure, simulate
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int32, real64
  use asperity_problems, only: real_text
  use asperity_root_bracket_real64, only: guess_root, narrow_bracket, root_bracket
  implicit none
  private

  public :: close_to_pull, pulls

  real(real64), parameter :: golden = 0.61803398874989485_real64
  ! Golden sections until an interval is 1e-9 of what it was: a minimum is flat to 1e-18 there.
  integer, parameter :: cuts = 43
  integer, parameter :: most_tries = 300, most_raises = 200
  ! How near a load is met, of the load; of no load, of the greatest pull.
  real(real64), parameter :: precision = 1.0e-11_real64

contains

  !> Whether an effect attracts.
  logical function pulls(pairs, effects)
    type(contact_pairs), intent(in) :: pairs    !! the position
    type(effect_box), intent(in) :: effects(:)  !! of the scene
    real(real64), allocatable :: ends(:)
    integer :: i

    pulls = .false.
    do i = 1, size(effects)
      call effects(i)%effect%letting_go(pairs, ends)
      pulls = pulls .or. size(ends) > 0
    end do
  end function pulls

  !> Finds the compression, from that of the former state or from first contact. `failure` reports
  !> the largest tensile load when the target exceeds it.
  subroutine close_to_pull(pairs, effects, target, closing, state, outcomes, failure)
    type(contact_pairs), intent(in) :: pairs                !! the position
    type(effect_box), intent(in) :: effects(:)              !! of the scene
    real(real64), intent(in) :: target                      !! less than that of the state before
    real(real64), intent(inout) :: closing                  !! of the state before; then there
    type(contact_state), intent(out) :: state               !! there
    type(effect_outcome), allocatable, intent(out) :: outcomes(:)  !! what the effects did
    character(len=:), allocatable, intent(out) :: failure   !! why not
    real(real64), allocatable :: ends(:)
    real(real64) :: top, bottom, best, least, lowest
    integer :: k

    call go_above(top)
    if (allocated(failure)) return
    call find_ends(pairs, effects, top, ends)
    least = min(0.0_real64, load_at(top))
    do k = 1, size(ends)
      bottom = ends(k)
      call find_least(bottom, top, best, lowest)
      if (allocated(failure)) return
      least = min(least, lowest)
      if (lowest <= target) then
        call find_crossing(best, lowest, top)
        return
      end if
      top = bottom
    end do
    failure = 'the pull is larger than the contacts carry: ' // &
              real_text(in_scene_units(pairs, abs(least), 1, 2)) // ' at most'

  contains

    ! A closing at which the load is more than asked for.
    subroutine go_above(above)
      real(real64), intent(out) :: above
      real(real64) :: step
      integer :: try

      above = max(closing, 0.0_real64)
      step = 1.0e-6_real64 * minval(pairs%list%radius)
      do try = 1, most_raises
        if (load_at(above) > target .or. allocated(failure)) return
        above = above + step
        step = 2.0_real64 * step
      end do
      failure = 'the load is larger than the surfaces carry'
    end subroutine go_above

    ! The least load between two closings at which contacts let go.
    subroutine find_least(low_end, high_end, place, value)
      real(real64), intent(in) :: low_end, high_end
      real(real64), intent(out) :: place, value
      real(real64) :: low, high, at(2), loads(2)
      integer :: cut

      low = low_end
      high = high_end
      at = [high - golden * (high - low), low + golden * (high - low)]
      loads = [load_at(at(1)), load_at(at(2))]
      do cut = 1, cuts
        if (allocated(failure)) return
        ! Far enough, or no more numbers between.
        if (minval(loads) <= target .or. .not. at(1) < at(2)) exit
        if (loads(1) < loads(2)) then
          high = at(2)
          at = [high - golden * (high - low), at(1)]
          loads = [load_at(at(1)), loads(1)]
        else
          low = at(1)
          at = [at(2), low + golden * (high - low)]
          loads = [loads(2), load_at(at(2))]
        end if
      end do
      place = at(minloc(loads, 1))
      value = minval(loads)
    end subroutine find_least

    ! Between a closing with too little load and one with too much.
    subroutine find_crossing(low, low_load, high)
      real(real64), intent(in) :: low, low_load, high
      type(root_bracket) :: bracket
      real(real64) :: above, load, scale
      logical :: inside
      integer :: try

      scale = max(abs(target), abs(low_load))
      bracket = root_bracket(low=0.0_real64, high=high - low, &
                             low_miss=(low_load - target) / scale, &
                             high_miss=(load_at(high) - target) / scale, halving=4)
      above = 0.0_real64
      load = low_load
      do try = 1, most_tries
        if (abs(load - target) <= precision * merge(abs(target), scale, target < 0.0_real64)) exit
        call guess_root(bracket, above, inside)
        if (.not. inside) exit
        load = load_at(low + above)
        call narrow_bracket(bracket, above, (load - target) / scale, load < target)
      end do
      closing = low + above
      ! The last one simulated, whatever the search looked at last.
      load = load_at(closing)
    end subroutine find_crossing

    real(real64) function load_at(place) result(load)
      real(real64), intent(in) :: place

      load = 0.0_real64
      if (allocated(failure)) return
      call simulate(pairs, effects, place, 0.0_real64, state, outcomes, .true.)
      call first_failure(effects, outcomes, failure)
      load = load_asked_for(pairs, state)
    end function load_at

  end subroutine close_to_pull

  ! Where contacts let go below a closing, the highest first.
  subroutine find_ends(pairs, effects, top, ends)
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(in) :: effects(:)
    real(real64), intent(in) :: top
    real(real64), allocatable, intent(out) :: ends(:)
    real(real64), allocatable :: one(:), all_of_them(:)
    integer(int32), allocatable :: order(:)
    integer :: i, k

    allocate (all_of_them(0))
    do i = 1, size(effects)
      call effects(i)%effect%letting_go(pairs, one)
      all_of_them = [all_of_them, pack(one, one < top)]
    end do
    allocate (order(size(all_of_them)), ends(size(all_of_them)))
    if (size(order) > 0) call sort_keys(-all_of_them, order)
    k = 0
    do i = 1, size(order)
      if (k > 0) then
        if (.not. all_of_them(order(i)) < ends(k)) cycle
      end if
      k = k + 1
      ends(k) = all_of_them(order(i))
    end do
    ends = ends(:k)
  end subroutine find_ends

end module asperity_closing_at_pull
