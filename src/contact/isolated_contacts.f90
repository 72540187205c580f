!> Positions of isolated contacts: their pairs, their end, and the states on the way to it.
module asperity_isolated_contacts
  use asperity_candidate_pairs, only: four_thirds, keep_within, largest_rise, &
                                      limit_penetration, load_of_overlap, overlap_of, &
                                      refine_heights, set_gaps, sort_by_gap
  use asperity_constants, only: pi
  use asperity_contact_pairs, only: contact_pairs, scaled_to_real64
  use asperity_contact_records, only: by_marching, cut_rows, most_rows, no_contacts, &
                                      position_result, prescribed_normal, prescribed_vertical, &
                                      solve_method
  use asperity_isolated_compression, only: check_level, compression_at_load, first_at_limit, &
                                           march_compression
  use asperity_kinds, only: int64, real64
  use asperity_loading_controls, only: compression_of, is_limit, is_load, is_separation
  use asperity_pair_finding, only: find_pairs
  use asperity_placed_scene, only: load_unit, place_of_touch, placed_scene, position_pairs
  use asperity_process, only: check_memory
  use asperity_scene_values, only: criterion_none
  use asperity_state_tally, only: add_contact, begin_tally, finish_tally, state_tally
  use asperity_theory_limits, only: seen_contact
  implicit none
  private

  public :: list_compressions, empty_state, list_pairs, solve_position

contains

  !> Solves one position. `failure` is allocated when its prescribed end cannot be reached.
  subroutine solve_position(placed, m, method, keep_rows, result, failure, pairs)
    type(placed_scene), intent(in) :: placed               !! scene in solver units
    integer, intent(in) :: m                               !! position, from 1
    type(solve_method), intent(in) :: method               !! path, overlap formula, step
    logical, intent(in) :: keep_rows                       !! keep the contacts of every state
    type(position_result), intent(out) :: result           !! states, ending with the last
    character(len=:), allocatable, intent(out) :: failure  !! set where the end is not reached
    !> those in contact at the end, or within the reach of the method
    type(contact_pairs), intent(out), optional :: pairs
    type(position_pairs) :: position
    logical :: all_pairs

    all_pairs = .false.
    call end_position(placed, m, method, position, all_pairs, failure)
    result%x_displacement = scaled_to_real64(position%dx, placed%length_power)
    result%y_displacement = scaled_to_real64(position%dy, placed%length_power)
    if (allocated(failure)) return
    if (present(pairs)) then
      call cut_pairs(scale(method%reach, -placed%length_power), position)
      call fill_pairs(placed, position, pairs)
      call cut_pairs(0.0_real64, position)
    end if
    if (position%number == 0) then
      call empty_state(placed, result, failure)
      return
    end if
    call compute_states(placed, position, method%overlap, keep_rows, result)
  end subroutine solve_position

  ! Drops the pairs that are farther from contact than a reach.
  pure subroutine cut_pairs(reach, position)
    real(real64), intent(in) :: reach
    type(position_pairs), intent(inout) :: position

    do while (position%number > 0)
      if (.not. position%found(position%number)%gap > position%compression + reach) exit
      position%number = position%number - 1
    end do
  end subroutine cut_pairs

  ! Finds the pairs that matter at a position, and its last compression. `all_pairs` is true when
  ! all were wanted or the candidate distance did not suffice.
  subroutine end_position(placed, m, method, position, all_pairs, failure)
    type(placed_scene), intent(in) :: placed
    integer, intent(in) :: m
    type(solve_method), intent(in) :: method
    type(position_pairs), intent(inout) :: position
    logical, intent(inout) :: all_pairs
    character(len=:), allocatable, intent(out) :: failure
    logical :: complete

    position%dx = placed%x_first + real(m - 1, real64) * placed%x_step
    position%dy = placed%y_first + real(m - 1, real64) * placed%y_step
    ! On a plane no distance in plan is too large.
    all_pairs = all_pairs .or. placed%on_plane
    call close_position(placed, all_pairs, method, position, complete, failure)
    if (complete) return
    ! Pairs outside the candidate distance can matter: take all pairs whose spheres can touch.
    all_pairs = .true.
    call close_position(placed, .true., method, position, complete, failure)
  end subroutine end_position

  ! Finds the pairs and the last compression of a position. `complete` is false when pairs that were
  ! left out for their distance in plan may touch before it.
  subroutine close_position(placed, all_pairs, method, position, complete, failure)
    type(placed_scene), intent(in) :: placed
    logical, intent(in) :: all_pairs
    type(solve_method), intent(in) :: method
    type(position_pairs), intent(inout) :: position
    logical, intent(out) :: complete
    character(len=:), allocatable, intent(out) :: failure
    logical :: is_reachable

    call find_pairs(placed, all_pairs, method, position, failure)
    complete = .true.
    if (allocated(failure)) return
    position%first_touch = 0.0_real64
    position%compression = 0.0_real64
    if (position%number == 0) then
      ! The caps of a deck end at their reference plane: under limit control such a position of it
      ! has no contact.
      complete = all_pairs .or. (placed%is_deck .and. is_limit(placed%control) .and. &
                                 placed%height_max > 0.0_real64)
      return
    end if
    call set_gaps(position%found(:position%number), position%first_touch)
    associate (found => position%found(:position%number), compression => position%compression)
      if (method%path == by_marching) then
        call sort_by_gap(found)
        call refine_heights(found)
        call march_compression(placed, found, scale(method%step, -placed%length_power), &
                           method%overlap, compression)
      else
        if (is_limit(placed%control)) then
          call first_at_limit(placed, found, compression, is_reachable)
          if (is_reachable) call check_level(placed, found, compression, failure)
          if (.not. is_reachable) &
            failure = 'no pair of asperities reaches the limit before its centres are level'
        else if (is_load(placed%control)) then
          call sort_by_gap(found)
          call refine_heights(found)
          call compression_at_load(placed, found, method%overlap, compression, failure)
        else
          compression = compression_of(placed%control, placed%target, position%first_touch)
          call check_level(placed, found, compression, failure)
        end if
      end if
    end associate
    complete = all_pairs .or. (.not. allocated(failure) .and. &
               position%first_touch - position%compression - &
               largest_rise(placed, method) >= placed%complete_above)
    if (allocated(failure) .or. method%path == by_marching) return
    if (is_load(placed%control)) return
    call keep_within(placed, method, position%found, position%number, position%compression)
    call refine_heights(position%found(:position%number))
  end subroutine close_position

  !> Sets the state of a position without contacts. Under load control that is a failure; else it
  !> is at the prescribed separation, or where the reference planes meet.
  subroutine empty_state(placed, result, failure)
    type(placed_scene), intent(in) :: placed                  !! scene in solver units
    type(position_result), intent(inout) :: result            !! gets its only state
    character(len=:), allocatable, intent(inout) :: failure   !! set under load control

    allocate (result%states(1), result%rows(0))
    if (is_load(placed%control)) then
      failure = 'no pair of asperities can touch, so they carry no load'
      return
    end if
    result%states(1) = no_contacts
    result%states(1)%compression = 0.0_real64
    result%states(1)%approach = 0.0_real64
    result%overlapping_circles = 0
    if (is_separation(placed%control)) &
      result%states(1)%approach = scaled_to_real64(placed%target, placed%length_power)
  end subroutine empty_state

  ! The states of a position up to its end.
  subroutine compute_states(placed, position, overlap, keep_rows, result)
    type(placed_scene), intent(in) :: placed
    type(position_pairs), intent(in) :: position
    integer, intent(in) :: overlap
    logical, intent(in) :: keep_rows
    type(position_result), intent(inout) :: result
    real(real64), allocatable :: compressions(:), gaps(:)
    type(state_tally) :: tally
    type(seen_contact) :: contact
    integer :: i, k

    allocate (gaps(merge(position%number, 0, placed%events)))
    if (placed%events) gaps = position%found(:position%number)%gap
    call list_compressions(placed%points, gaps, position%compression, compressions)
    allocate (result%states(size(compressions)), result%rows(0))
    do i = 1, size(compressions)
      tally = state_tally(placed%length_power, placed%modulus_power, load_unit(placed))
      call begin_tally(tally, position%number, keep_rows, i == size(compressions))
      do k = 1, position%number
        if (position%found(k)%gap > compressions(i)) exit
        call solve_contact(placed, position, k, compressions(i), overlap, contact)
        call add_contact(tally, placed%limits, contact)
      end do
      call finish_tally(tally, placed%limits, position%first_touch - compressions(i), &
                        compressions(i), i, result)
      if (result%rows_used > most_rows) exit
    end do
    call cut_rows(result)
    if (.not. is_load(placed%control)) return
    associate (last => result%states(size(compressions)))
      last%prescribed = merge(prescribed_vertical, prescribed_normal, placed%control%is_vertical)
      last%prescribed_load = scaled_to_real64(placed%target, load_unit(placed))
    end associate
  end subroutine compute_states

  !> Sets the compressions of the states, ascending, each once: first touch and the ends of the
  !> equal parts, if any; the gaps; the end.
  subroutine list_compressions(points, gaps, compression, compressions)
    integer, intent(in) :: points                    !! number of equal parts; 0 or 1: none
    real(real64), intent(in) :: gaps(:)              !! compressions of first touches, ascending
    real(real64), intent(in) :: compression              !! compression at the end
    real(real64), allocatable, intent(out) :: compressions(:)  !! at least one compression
    real(real64) :: part
    integer :: event, k, used, parts

    parts = merge(points, 0, points > 1)
    allocate (compressions(parts + size(gaps) + 2))
    used = 0
    event = 1
    do k = 0, parts
      part = compression
      if (k < parts) part = compression * real(k, real64) / real(parts, real64)
      do while (event <= size(gaps))
        if (gaps(event) > part) exit
        call add_if_new(gaps(event))
        event = event + 1
      end do
      call add_if_new(part)
    end do
    compressions = compressions(:used)

  contains

    subroutine add_if_new(candidate_compression)
      real(real64), intent(in) :: candidate_compression

      if (candidate_compression > compression) return
      if (used > 0) then
        if (.not. candidate_compression > compressions(used)) return
      end if
      used = used + 1
      compressions(used) = candidate_compression
    end subroutine add_if_new

  end subroutine list_compressions

  ! Solves one contact at a compression, by Hertz' law.
  pure subroutine solve_contact(placed, position, i, compression, overlap, contact)
    type(placed_scene), intent(in) :: placed
    type(position_pairs), intent(in) :: position
    integer, intent(in) :: i
    real(real64), intent(in) :: compression
    integer, intent(in) :: overlap
    type(seen_contact), intent(out) :: contact
    real(real64) :: limit
    logical :: reachable

    associate (pair => position%found(i))
      contact%area_no = i
      contact%upper = pair%upper
      contact%lower = pair%lower
      call place_of_touch(placed, pair, position%dx, position%dy, contact%x, contact%y)
      contact%penetration = compression - pair%gap
      contact%d = pair%d
      contact%z = pair%zc - contact%penetration
      contact%overlap = overlap_of(pair, contact%penetration, overlap)
      contact%contact_radius = sqrt(pair%radius * contact%overlap)
      contact%area = pi * contact%overlap * pair%radius
      contact%load = placed%modulus * load_of_overlap(pair%radius, contact%overlap)
      contact%cosine = contact%z / (pair%s - contact%overlap)
      contact%vertical_load = contact%load * contact%cosine
      ! Average pressure 4 E sqrt(W/R)/(3 pi).
      contact%average_pressure = &
        placed%modulus * four_thirds * sqrt(contact%overlap / pair%radius) / pi
      contact%maximum_pressure = 1.5_real64 * contact%average_pressure
      if (pair%upper > 0) then
        contact%upper_radius = placed%ru(pair%upper)
        contact%upper_height = placed%cap_u(pair%upper)
      end if
      if (pair%lower > 0) then
        contact%lower_radius = placed%rl(pair%lower)
        contact%lower_height = placed%cap_l(pair%lower)
      end if
      if (placed%criterion == criterion_none) return
      call limit_penetration(placed, pair, limit, reachable)
      if (reachable) contact%limit_exceeded = pair%gap + limit <= compression
    end associate
  end subroutine solve_contact

  !> Lists the pairs of a position, with the compression at which non-interacting elastic
  !> contacts end. Under load control these are all pairs that may touch, as effects may increase
  !> the compression; else those that touch or attract by the end, as effects decrease penetrations
  !> only. With `all_pairs` no candidate distance is used.
  subroutine list_pairs(placed, m, all_pairs, pairs, failure, wanted)
    type(placed_scene), intent(in) :: placed               !! scene in solver units
    integer, intent(in) :: m                               !! position, from 1
    logical, intent(in) :: all_pairs                       !! every pair whose spheres can touch
    type(contact_pairs), intent(out) :: pairs              !! pairs in order of first touch
    character(len=:), allocatable, intent(out) :: failure  !! set where the end is not reached
    type(solve_method), intent(in), optional :: wanted     !! range of attraction; absent: none
    ! Memory of a pair, bytes: about 20 numbers in the list and 13 in each of three states (start,
    ! solution, trial).
    integer(int64), parameter :: bytes_of_pair = 500
    type(position_pairs) :: position
    logical :: are_all
    type(solve_method) :: method

    if (present(wanted)) method = wanted
    method%past_the_end = .true.
    ! A load that is 0 in the solver's units would be reached at first touch.
    if ((placed%target > 0.0_real64 .or. placed%target < 0.0_real64) .and. &
        is_load(placed%control) .and. .not. abs(target_of(placed)) > 0.0_real64) then
      failure = 'the load is too small beside the moduli and lengths to be met with effects'
      return
    end if
    are_all = all_pairs
    call end_position(placed, m, method, position, are_all, failure)
    if (allocated(failure)) return
    ! The list is also complete when it has every combination of asperities.
    if (real(position%number, real64) >= real(size(placed%xu), real64) * size(placed%xl)) &
      are_all = .true.
    call check_memory('the pairs of a position', failure, &
                      bytes=int(position%number, int64) * bytes_of_pair)
    if (allocated(failure)) return
    call fill_pairs(placed, position, pairs)
    if (.not. are_all) &
      pairs%complete_to = position%first_touch - placed%complete_above - &
                          largest_rise(placed, method)
  end subroutine list_pairs

  ! The target load in the unit of the pairs; 0 under another control.
  real(real64) function target_of(placed)
    type(placed_scene), intent(in) :: placed

    target_of = 0.0_real64
    if (is_load(placed%control)) target_of = placed%target
  end function target_of

  ! Sets pairs from those of a position.
  subroutine fill_pairs(placed, position, pairs)
    type(placed_scene), intent(in) :: placed
    type(position_pairs), intent(in) :: position
    type(contact_pairs), intent(out) :: pairs
    real(real64) :: limit
    integer :: i, j, k
    logical :: reachable

    pairs%x_displacement = scaled_to_real64(position%dx, placed%length_power)
    pairs%y_displacement = scaled_to_real64(position%dy, placed%length_power)
    pairs%modulus = placed%modulus
    pairs%modulus_power = placed%modulus_power
    pairs%length_power = placed%length_power
    pairs%limits = placed%limits
    pairs%vertical = placed%control%is_vertical
    pairs%target = target_of(placed)
    pairs%first_touch = position%first_touch
    pairs%compression = position%compression
    allocate (pairs%list(position%number))
    do i = 1, position%number
      associate (pair => pairs%list(i), from => position%found(i))
        j = from%upper
        k = from%lower
        pair%upper = j
        pair%lower = k
        call place_of_touch(placed, from, position%dx, position%dy, pair%x, pair%y)
        ! The centre of a plane is taken vertically above or below the contact.
        pair%upper_x = pair%x
        pair%upper_y = pair%y
        pair%lower_x = pair%x
        pair%lower_y = pair%y
        if (j > 0) then
          pair%upper_x = placed%xu(j) + position%dx
          pair%upper_y = placed%yu(j) + position%dy
          pair%upper_radius = placed%ru(j)
          pair%upper_height = placed%cap_u(j)
        end if
        if (k > 0) then
          pair%lower_x = placed%xl(k)
          pair%lower_y = placed%yl(k)
          pair%lower_radius = placed%rl(k)
          pair%lower_height = placed%cap_l(k)
        end if
        pair%gap = from%gap
        pair%d = from%d
        pair%s = from%s
        pair%zc = from%zc
        pair%rest = from%rest
        pair%radius = from%radius
        if (placed%criterion == criterion_none) cycle
        call limit_penetration(placed, from, limit, reachable)
        if (reachable) pair%limit = limit
      end associate
    end do
  end subroutine fill_pairs

end module asperity_isolated_contacts
