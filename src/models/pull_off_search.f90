!> The compression at which contacts that attract each other carry a load, on unloading.
!>
!> On unloading the load decreases, and increases abruptly where a contact parts. Between two such
!> compressions the load is a convex function of the compression, as that of each adhering contact
!> is. The first compression at which the load has decreased to the target is found by branch and
!> bound (Land and Doig 1960) over the intervals, from the highest: groups of intervals whose lower
!> bound of the load exceeds the target are skipped. The least load of an interval is found by
!> golden-section search. It is also the equilibrium of a dead weight.
!>
!> The work of a state is proportional to the number of contacts and to the logarithm of the number
!> of intervals that are skipped.
module asperity_pull_off_search
  use asperity_adhesion, only: adhesion_effect
  use asperity_contact_effect, only: effect_box
  use asperity_contact_pairs, only: contact_pairs, in_scene_units
  use asperity_contact_state, only: controlled_load
  use asperity_effect_sequence, only: first_failure, found_state, simulate_effects
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int32, real64
  use asperity_problems, only: real_text
  use asperity_root_bracket, only: guess_by_secant, narrow_bracket, root_bracket
  implicit none
  private

  public :: unload_to_load, has_attraction

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
    real(real64), allocatable :: compressions(:)

    call find_partings(pairs, effects, compressions)
    has_attraction = size(compressions) > 0
  end function has_attraction

  !> Finds the compression, from that of the last state or from first contact. `failure` reports the
  !> largest tensile load when the target exceeds it.
  subroutine unload_to_load(pairs, effects, target, found, failure)
    ! Long: the stages are internal procedures, which share the state of the search.
    type(contact_pairs), intent(in) :: pairs                !! pairs of the position
    type(effect_box), intent(in) :: effects(:)              !! effects of the scene
    real(real64), intent(in) :: target                      !! load, below that of the last state
    type(found_state), intent(inout) :: found               !! last compression; the state found
    character(len=:), allocatable, intent(out) :: failure   !! reason, when the load is not carried
    real(real64), allocatable :: ends(:)
    real(real64), allocatable :: known(:, :)  ! compressions and loads so far
    real(real64) :: top, best, level
    logical :: begins_open, is_met, seeks_least
    integer :: first, last

    begins_open = .not. found%compression > 0.0_real64
    allocate (known(2, 0))
    if (allocated(found%state%answers)) &
      known = reshape([found%state%compression, controlled_load(pairs, found%state)], [2, 1])
    call raise_load(top)
    if (allocated(failure)) return
    call find_ends(pairs, effects, top, ends)
    level = target
    is_met = .false.
    seeks_least = .false.
    ! Groups of 1, 2, 4 ... intervals: the work grows with the distance of the compression.
    first = 2
    do while (first <= size(ends))
      last = min(2 * first - 2, size(ends))
      call search_group(first, last)
      if (is_met .or. allocated(failure)) return
      first = last + 1
    end do
    level = min(0.0_real64, load_at(top))
    seeks_least = .true.
    call search_group(2, size(ends))
    if (allocated(failure)) return
    failure = 'the pull is larger than the contacts carry: ' // &
              real_text(in_scene_units(pairs, abs(level), 1, 2)) // ' at most'
    if (begins_open) failure = failure // ' from first contact; after loading they may carry ' // &
                               'more: expected a path, value = LOAD, PULL'

  contains

    ! Finds a compression with a load above the target.
    subroutine raise_load(above)
      real(real64), intent(out) :: above
      real(real64) :: step
      integer :: try

      above = max(found%compression, 0.0_real64)
      step = 1.0e-6_real64 * minval(pairs%list%radius)
      do try = 1, most_raises
        if (load_at(above) > target .or. allocated(failure)) return
        above = above + step
        step = 2.0_real64 * step
      end do
      failure = 'the load is larger than the surfaces carry'
    end subroutine raise_load

    ! Searches the intervals that end at ends(first:last), from the highest, for the level: the
    ! target, or the least load so far.
    recursive subroutine search_group(first, last)
      integer, intent(in) :: first, last
      real(real64) :: bound, lowest
      integer :: i, middle

      if (is_met .or. allocated(failure) .or. first > last) return
      bound = -huge(bound)
      do i = 1, size(effects)
        select type (effect => effects(i)%effect)
        type is (adhesion_effect)
          bound = effect%least_load(pairs, ends(last), ends(first - 1))
        end select
      end do
      if (exceeds_level(bound)) return
      if (first < last) then
        middle = (first + last) / 2
        if (seeks_least) level = min(level, load_at(ends(middle)))
        call search_group(first, middle)
        call search_group(middle + 1, last)
        return
      end if
      call find_least(ends(last), ends(last - 1), best, lowest)
      if (allocated(failure)) return
      is_met = lowest <= target
      if (is_met) call find_crossing(best, lowest, ends(last - 1))
      if (seeks_least) level = min(level, lowest)
    end subroutine search_group

    logical function exceeds_level(bound)
      real(real64), intent(in) :: bound

      exceeds_level = bound > level + load_tolerance * abs(level)
    end function exceeds_level

    ! Finds the least load between two compressions at which contacts part, unless it exceeds the
    ! level: lines through two points are below a convex function outside of them. The
    ! loads at the ends are no points of that function, as a contact parts there.
    subroutine find_least(low, high, place, value)
      real(real64), intent(in) :: low, high
      real(real64), intent(out) :: place, value
      real(real64) :: at(4), loads(4)
      integer :: cut

      at = [low, high - golden * (high - low), low + golden * (high - low), high]
      loads = sqrt(huge(loads))
      loads(2:3) = [load_at(at(2)), load_at(at(3))]
      do cut = 1, cuts
        if (allocated(failure)) return
        ! The target is reached, or the interval has no further numbers.
        if (minval(loads) <= target .or. .not. at(2) < at(3)) exit
        if (exceeds_level(convex_bound(at, loads))) exit
        if (loads(2) < loads(3)) then
          at(3:) = at(2:3)
          loads(3:) = loads(2:3)
          at(2) = at(4) - golden * (at(4) - at(1))
          loads(2) = load_at(at(2))
        else
          at(:2) = at(2:3)
          loads(:2) = loads(2:3)
          at(3) = at(1) + golden * (at(4) - at(1))
          loads(3) = load_at(at(3))
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
      bracket = root_bracket(low=0.0_real64, high=high - low, low_miss=-1.0_real64, &
                             high_miss=-1.0_real64, halving=4)
      call narrow_bracket(bracket, high - low, (load_at(high) - target) / largest, .false.)
      call narrow_bracket(bracket, 0.0_real64, (low_load - target) / largest, .true.)
      above = 0.0_real64
      load = low_load
      do try = 1, most_tries
        if (abs(load - target) <= &
            load_tolerance * merge(abs(target), largest, target < 0.0_real64)) exit
        call guess_by_secant(bracket, 0.0_real64, above, inside)
        if (.not. inside) exit
        load = load_at(low + above)
        call narrow_bracket(bracket, above, (load - target) / largest, load < target)
      end do
      if (abs(found%state%compression - (low + above)) > 0.0_real64 .or. &
          .not. allocated(found%outcomes)) call solve_at(low + above)
    end subroutine find_crossing

    ! Load at a compression; a known one is not solved again.
    real(real64) function load_at(place) result(load)
      real(real64), intent(in) :: place
      integer :: k

      load = 0.0_real64
      if (allocated(failure)) return
      do k = size(known, 2), 1, -1
        if (abs(known(1, k) - place) > 0.0_real64) cycle
        load = known(2, k)
        return
      end do
      call solve_at(place)
      load = controlled_load(pairs, found%state)
      known = reshape([known, place, load], [2, size(known, 2) + 1])
    end function load_at

    subroutine solve_at(place)
      real(real64), intent(in) :: place

      found%compression = place
      call simulate_effects(pairs, effects, 0.0_real64, found, .true.)
      call first_failure(effects, found%outcomes, failure)
    end subroutine solve_at

  end subroutine unload_to_load

  ! Lower bound of a convex function through four ascending points, between the first and the last.
  pure real(real64) function convex_bound(at, values) result(bound)
    real(real64), intent(in) :: at(4), values(4)
    real(real64) :: slopes(3)

    slopes = (values(2:) - values(:3)) / (at(2:) - at(:3))
    bound = min(values(2) - max(slopes(2), 0.0_real64) * (at(2) - at(1)), &
                values(3) + min(slopes(2), 0.0_real64) * (at(4) - at(3)), &
                max(values(2) + min(slopes(1), 0.0_real64) * (at(3) - at(2)), &
                    values(3) - max(slopes(3), 0.0_real64) * (at(3) - at(2))))
  end function convex_bound

  ! Finds `top` and the compressions below it at which contacts part, in descending order.
  subroutine find_ends(pairs, effects, top, ends)
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(in) :: effects(:)
    real(real64), intent(in) :: top
    real(real64), allocatable, intent(out) :: ends(:)
    real(real64), allocatable :: all_of_them(:)
    integer(int32), allocatable :: order(:)
    integer :: i, k

    call find_partings(pairs, effects, all_of_them)
    all_of_them = pack(all_of_them, all_of_them < top)
    allocate (order(size(all_of_them)), ends(size(all_of_them) + 1))
    if (size(order) > 0) call sort_keys(-all_of_them, order)
    ends(1) = top
    k = 1
    do i = 1, size(order)
      if (.not. all_of_them(order(i)) < ends(k)) cycle
      k = k + 1
      ends(k) = all_of_them(order(i))
    end do
    ends = ends(:k)
  end subroutine find_ends

  ! Compressions below which an adhering contact separates, at which the load is discontinuous: one
  ! for each pair, or none where nothing attracts.
  subroutine find_partings(pairs, effects, compressions)
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(in) :: effects(:)
    real(real64), allocatable, intent(out) :: compressions(:)
    integer :: i

    allocate (compressions(0))
    do i = 1, size(effects)
      select type (effect => effects(i)%effect)
      type is (adhesion_effect)
        call effect%pull_off_compressions(pairs, compressions)
      end select
    end do
  end subroutine find_partings

end module asperity_pull_off_search
