!> The compression at which contacts that attract each other carry a load, on unloading.
!>
!> On unloading the load decreases, and increases abruptly where a contact parts. Between two such
!> compressions the load is a convex function of the compression, as that of each adhering contact
!> is: Newton's method from the upper end converges to the target from above, or arrives where the
!> load increases on unloading. Then the interval is without the target. Intervals are searched from
!> the highest by branch and bound (Land and Doig 1960): groups of intervals whose lower bound of
!> the load exceeds the target are skipped. The result is also the equilibrium of a dead weight.
!>
!> No effect that changes loads has a common theory with adhesion, so the loads are those of its
!> law: no state is solved. The work is proportional to the number of contacts and to the logarithm
!> of the number of intervals that are skipped.
module asperity_pull_off_search
  use asperity_adhesion, only: adhesion_effect
  use asperity_adhesion_law, only: adhesion_law, complete_law
  use asperity_contact_pairs, only: contact_pairs, in_scene_units
  use asperity_contact_state, only: answer_all, contact_state, controlled_load, load_rounding, &
                                    start_state
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int32, real64
  use asperity_problems, only: real_text
  implicit none
  private

  public :: unload_to_load

  integer, parameter :: most_tries = 300, most_raises = 200
  ! Tolerance of a load, relative to a tensile target, else to the sum of all forces.
  real(real64), parameter :: load_tolerance = 1.0e-11_real64
  ! Largest sum of all forces, over a compressive target, of which its error is a share. Derived:
  ! the
  ! load is met to 1e-7. Test: test_loads_near_zero of test_adhesion.py.
  real(real64), parameter :: largest_scale = 1.0e4_real64

  ! Load and its derivative at a compression.
  type :: tangent
    real(real64) :: at = 0.0_real64, load = 0.0_real64, slope = 0.0_real64
  end type tangent

contains

  !> Finds the compression, from that of the last state or from first contact. `failure` reports the
  !> largest tensile load when the target exceeds it.
  subroutine unload_to_load(pairs, adhesion, target, compression, failure)
    ! Long: the stages are internal procedures, which share the state of the search.
    type(contact_pairs), intent(in) :: pairs                !! pairs of the position
    type(adhesion_effect), intent(in) :: adhesion           !! adhesion with the last state
    real(real64), intent(in) :: target                      !! load, below that of the last state
    real(real64), intent(inout) :: compression              !! of the last state; the one found
    character(len=:), allocatable, intent(out) :: failure   !! reason, when the load is not carried
    type(contact_state) :: state
    type(tangent) :: start
    type(adhesion_law) :: law
    real(real64), allocatable :: ends(:)
    real(real64) :: level, margin
    logical :: begins_open, is_met, seeks_least
    integer :: first, last

    begins_open = .not. compression > 0.0_real64
    law = adhesion%law
    call complete_law(law)
    call start_state(pairs, law, max(compression, 0.0_real64), state)
    call raise_load()
    if (allocated(failure)) return
    call list_ends(pairs, law, start%at, ends)
    ! Beside an end of an interval rounding decides which contacts have parted.
    margin = 8 * epsilon(margin) * max(start%at, maxval(abs(pairs%list%gap)))
    level = target
    is_met = .false.
    seeks_least = .false.
    ! Groups of 1, 2, 4 ... intervals: the work grows with the distance of the compression.
    first = 2
    do while (first <= size(ends))
      last = min(2 * first - 2, size(ends))
      call search_group(first, last)
      if (is_met) return
      first = last + 1
    end do
    level = min(0.0_real64, start%load)
    seeks_least = .true.
    call search_group(2, size(ends))
    failure = 'the pull is larger than the contacts carry: ' // &
              real_text(in_scene_units(pairs, abs(level), 1, 2)) // ' at most'
    if (begins_open) failure = failure // ' from first contact; after loading they may carry ' // &
                               'more: expected a path, value = LOAD, PULL'

  contains

    ! Finds a compression with a load above the target.
    subroutine raise_load()
      real(real64) :: step
      integer :: try

      start = tangent_at(state%compression)
      step = 1.0e-6_real64 * minval(pairs%list%radius)
      do try = 1, most_raises
        if (start%load > target) return
        start = tangent_at(start%at + step)
        step = 2.0_real64 * step
      end do
      failure = 'the load is larger than the surfaces carry'
    end subroutine raise_load

    ! Searches the intervals that end at ends(first:last), from the highest, for the level: the
    ! target, or the least load so far.
    recursive subroutine search_group(first, last)
      integer, intent(in) :: first, last
      integer :: i, middle

      if (is_met .or. first > last) return
      ! Contacts are independent, so the sum of their least loads is a lower bound of the load;
      ! without adhesion the load is larger.
      if (exceeds_level(sum([(law%least_load( &
        pairs%list(i), i, ends(last) - pairs%list(i)%gap, ends(first - 1) - pairs%list(i)%gap, &
        pairs%vertical), i=1, size(pairs%list))]))) return
      if (first < last) then
        middle = (first + last) / 2
        call search_group(first, middle)
        call search_group(middle + 1, last)
      else if (ends(last) + margin < ends(last - 1) - margin) then
        if (seeks_least) then
          call find_least(ends(last) + margin, tangent_at(ends(last - 1) - margin))
        else
          call find_target(ends(last), tangent_at(ends(last - 1) - margin))
        end if
      end if
    end subroutine search_group

    logical function exceeds_level(bound)
      real(real64), intent(in) :: bound

      exceeds_level = bound > level + load_tolerance * abs(level)
    end function exceeds_level

    ! Finds the target between two compressions by Newton's method from the upper one, at most as
    ! far as a load below it: that of inclined contacts is not quite convex.
    subroutine find_target(low, high)
      real(real64), intent(in) :: low
      type(tangent), intent(in) :: high
      type(tangent) :: place
      real(real64) :: above, below, next, scale_of_load
      integer :: try

      place = high
      above = high%at
      below = low
      scale_of_load = abs(target)
      do try = 1, most_tries
        if (.not. target < 0.0_real64) scale_of_load = max(target, sum(abs(state%answers%load)))
        ! A small load is the difference of large forces.
        if (target > 0.0_real64) scale_of_load = min(scale_of_load, largest_scale * target)
        is_met = abs(place%load - target) <= max(load_tolerance * scale_of_load, &
                                                 merge(load_rounding(state), 0.0_real64, &
                                                       target > 0.0_real64))
        if (place%load < target) then
          below = place%at
        else
          above = place%at
        end if
        compression = place%at
        next = low
        if (place%slope > 0.0_real64) next = place%at - (place%load - target) / place%slope
        if (below > low .and. .not. (next > below .and. next < above)) then
          next = 0.5_real64 * (above + below)
          is_met = is_met .or. .not. (next > below .and. next < above)
        end if
        is_met = is_met .or. .not. abs(next - place%at) > 0.0_real64
        ! Without a load below the target there is none before the upper end.
        if (is_met .or. .not. next > low) return
        place = tangent_at(next)
      end do
    end subroutine find_target

    ! Finds the least load between two compressions, unless it exceeds the level: tangents are below
    ! a convex function (cutting planes, Kelley 1960).
    subroutine find_least(low, high)
      real(real64), intent(in) :: low
      type(tangent), intent(in) :: high
      type(tangent) :: place, left, right
      integer :: try

      right = high
      place = tangent_at(low)
      left = place
      do try = 1, most_tries
        level = min(level, place%load, right%load)
        if (.not. (left%slope < 0.0_real64 .and. right%slope > 0.0_real64)) return
        place%at = left%at + (left%load - right%load - right%slope * (left%at - right%at)) / &
                  (right%slope - left%slope)
        if (exceeds_level(right%load + right%slope * (place%at - right%at))) return
        if (.not. (place%at > left%at .and. place%at < right%at)) return
        place = tangent_at(place%at)
        if (place%slope < 0.0_real64) left = place
        if (.not. place%slope < 0.0_real64) right = place
      end do
    end subroutine find_least

    ! Evaluates the law of each contact at a compression.
    type(tangent) function tangent_at(compression) result(place)
      real(real64), intent(in) :: compression

      state%compression = compression
      state%penetration = compression - pairs%list%gap
      call answer_all(pairs, state)
      place%at = compression
      place%load = controlled_load(pairs, state)
      place%slope = sum(state%answers%stiffness)
      ! Derivative of the force along the line of centres, see `set_vertical_parts`.
      if (.not. pairs%vertical) place%slope = sum((state%answers%stiffness + &
        state%answers%load * pairs%list%d**2 / (pairs%list%s - state%answers%overlap)**3) / &
        state%answers%cosine)
    end function tangent_at

  end subroutine unload_to_load

  ! Lists `top` and the compressions below it at which contacts part, in descending order.
  subroutine list_ends(pairs, law, top, ends)
    type(contact_pairs), intent(in) :: pairs
    type(adhesion_law), intent(in) :: law
    real(real64), intent(in) :: top
    real(real64), allocatable, intent(out) :: ends(:)
    real(real64), allocatable :: partings(:)
    real(real64) :: centres, overlap
    integer(int32), allocatable :: order(:)
    integer :: i, used

    allocate (partings(merge(size(pairs%list), 0, law%numbers%work > 0.0_real64)))
    do i = 1, size(partings)
      associate (pair => pairs%list(i), known => law%known(i))
        overlap = merge(known%snap_off, known%snap_in, law%adhered(i))
        centres = pair%s - overlap
        ! zc - sqrt(centres**2 - d**2), without cancellation.
        partings(i) = pair%gap + overlap * ((pair%s + centres) / &
                      (pair%zc + sqrt((centres - pair%d) * (centres + pair%d))))
        if (.not. pair%d > 0.0_real64) partings(i) = pair%gap + overlap
      end associate
    end do
    partings = pack(partings, partings < top)
    allocate (order(size(partings)), ends(size(partings) + 1))
    if (size(order) > 0) call sort_keys(-partings, order)
    ends(1) = top
    used = 1
    do i = 1, size(order)
      if (.not. partings(order(i)) < ends(used)) cycle
      used = used + 1
      ends(used) = partings(order(i))
    end do
    ends = ends(:used)
  end subroutine list_ends

end module asperity_pull_off_search
