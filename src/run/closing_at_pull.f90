!> The compression at which contacts that attract each other carry a load, on unloading.
!>
!> On unloading the load decreases, and increases abruptly where a contact parts. Between two such
!> compressions the load is a convex function of the compression, as that of each adhering contact
!> is. The first compression at which the load has decreased to the target is found interval by
!> interval, from the highest; the least load of an interval is found by golden-section search. It
!> is also the equilibrium of a dead weight.
module asperity_closing_at_pull
  use asperity_contact_effect, only: effect_box
  use asperity_contact_pairs, only: contact_pairs, in_scene_units
  use asperity_contact_state, only: controlled_load
  use asperity_effect_sequence, only: first_failure, found_state, simulate_effects
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int32, real64
  use asperity_problems, only: real_text
  use asperity_root_bracket_real64, only: guess_root, narrow_bracket, root_bracket
  implicit none
  private

  public :: close_to_pull, has_attraction

  real(real64), parameter :: golden = 0.61803398874989485_real64
  ! Number of golden sections: they reduce an interval to 1e-9, in which a minimum is flat to 1e-18.
  integer, parameter :: cuts = 43
  integer, parameter :: most_tries = 300, most_raises = 200
  ! Tolerance of a load, relative to a tensile target, else to the largest of the loads.
  real(real64), parameter :: load_tolerance = 1.0e-11_real64

contains

  !> Whether an effect makes contacts attract each other.
  logical function has_attraction(pairs, effects)
    type(contact_pairs), intent(in) :: pairs    !! pairs of the position
    type(effect_box), intent(in) :: effects(:)  !! effects of the scene
    real(real64), allocatable :: ends(:)
    integer :: i

    has_attraction = .false.
    do i = 1, size(effects)
      call effects(i)%effect%letting_go(pairs, ends)
      has_attraction = has_attraction .or. size(ends) > 0
    end do
  end function has_attraction

  !> Finds the compression, from that of the last state or from first contact. `failure` reports the
  !> largest tensile load when the target exceeds it.
  subroutine close_to_pull(pairs, effects, target, found, failure)
    ! Long: the stages are internal procedures, which share the state of the search.
    type(contact_pairs), intent(in) :: pairs                !! pairs of the position
    type(effect_box), intent(in) :: effects(:)              !! effects of the scene
    real(real64), intent(in) :: target                      !! load, below that of the last state
    type(found_state), intent(inout) :: found               !! last compression; the state found
    character(len=:), allocatable, intent(out) :: failure   !! reason, when the load is not carried
    real(real64), allocatable :: ends(:)
    real(real64) :: top, bottom, best, least, lowest
    integer :: k

    call raise_load(top)
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

    ! Finds a compression with a load above the target.
    subroutine raise_load(above)
      real(real64), intent(out) :: above
      real(real64) :: step
      integer :: try

      above = max(found%closing, 0.0_real64)
      step = 1.0e-6_real64 * minval(pairs%list%radius)
      do try = 1, most_raises
        if (load_at(above) > target .or. allocated(failure)) return
        above = above + step
        step = 2.0_real64 * step
      end do
      failure = 'the load is larger than the surfaces carry'
    end subroutine raise_load

    ! Finds the least load between two compressions at which contacts part.
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
        ! The target is reached, or the interval has no further numbers.
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

    ! Finds the target between a compression with a smaller load and one with a larger load.
    subroutine find_crossing(low, low_load, high)
      real(real64), intent(in) :: low, low_load, high
      type(root_bracket) :: bracket
      real(real64) :: above, load, largest
      logical :: inside
      integer :: try

      largest = max(abs(target), abs(low_load))
      bracket = root_bracket(low=0.0_real64, high=high - low, &
                             low_miss=(low_load - target) / largest, &
                             high_miss=(load_at(high) - target) / largest, halving=4)
      above = 0.0_real64
      load = low_load
      do try = 1, most_tries
        if (abs(load - target) <= &
            load_tolerance * merge(abs(target), largest, target < 0.0_real64)) exit
        call guess_root(bracket, above, inside)
        if (.not. inside) exit
        load = load_at(low + above)
        call narrow_bracket(bracket, above, (load - target) / largest, load < target)
      end do
      ! The state returned is that of the last simulation.
      load = load_at(low + above)
    end subroutine find_crossing

    real(real64) function load_at(place) result(load)
      real(real64), intent(in) :: place

      load = 0.0_real64
      if (allocated(failure)) return
      found%closing = place
      call simulate_effects(pairs, effects, 0.0_real64, found, .true.)
      call first_failure(effects, found%outcomes, failure)
      load = controlled_load(pairs, found%state)
    end function load_at

  end subroutine close_to_pull

  ! Finds the compressions below `top` at which contacts part, in descending order.
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
