!> Asperities of two bodies at one position, with their effects, state by state.
module asperity_asperity_position
  use asperity_asperity_records, only: add_contacts
  use asperity_contact_effect, only: effect_box
  use asperity_contact_law, only: contact_law
  use asperity_contact_model, only: at_distance, at_load, held_distance, held_load, no_load, &
                                    path_step, placed_bodies
  use asperity_contact_pairs, only: contact_pairs, in_scene_units
  use asperity_contact_records, only: effect_record, position_result, prescribed_normal, &
                                      prescribed_vertical
  use asperity_contact_state, only: contact_state, controlled_load, load_rounding, start_state
  use asperity_effect_names, only: of_interaction
  use asperity_effect_sequence, only: choose_effects, drop_choice, first_failure, found_state, &
                                      simulate_effects
  use asperity_hertz_law, only: hertz_law
  use asperity_isolated_contacts, only: list_compressions
  use asperity_kinds, only: real64
  use asperity_loading_controls, only: compression_of, in_model_units
  use asperity_load_search, only: compress_to_load, search_load
  use asperity_path_steps, only: plan_hold, plan_path
  use asperity_problems, only: not_enough_memory
  use asperity_root_bracket, only: guess_by_secant, narrow_bracket, root_bracket
  use asperity_scene_values, only: effect_off, is_distance, is_limit, is_load, scene
  implicit none
  private

  public :: asperity_bodies, begin_asperities, estimate_shares

  !> Asperities at one position, in their last state.
  type, extends(placed_bodies) :: asperity_bodies
    type(scene), pointer :: scene_in => null()   !! scene, checked for faults
    type(contact_pairs) :: pairs                 !! pairs of the position, at least one
    type(effect_box), allocatable :: effects(:)  !! effects with their memory
    type(found_state) :: found                   !! the last state
    !> whether there was a path or a simulated effect; else the solver without effects suffices
    logical :: simulated = .false.
    real(real64) :: held = 0.0_real64            !! load of the last state of loading
    type(effect_box), allocatable :: left_out(:)  !! effects that are off
    real(real64), allocatable :: shares(:, :)    !! their shares of the load (effect, state)
  contains
    procedure :: list_steps => list_asperity_steps
    procedure :: solve_step => solve_asperity_step
    procedure :: add_totals => compare_effects
  end type asperity_bodies

contains

  !> Begins the path of a position, without any contact so far.
  subroutine begin_asperities(bodies)
    class(asperity_bodies), intent(inout) :: bodies  !! with scene, pairs and effects
    integer :: i

    bodies%simulated = allocated(bodies%scene_in%loading%path)
    do i = 1, size(bodies%effects)
      call bodies%effects(i)%effect%begin(bodies%pairs)
    end do
    do i = 1, size(bodies%left_out)
      call bodies%left_out(i)%effect%begin(bodies%pairs)
    end do
  end subroutine begin_asperities

  !> Estimates the shares of the load of effects that are off, in a state of isolated contacts.
  subroutine estimate_shares(pairs, effects, law, compression, shares)
    type(contact_pairs), intent(in) :: pairs     !! pairs of the position
    type(effect_box), intent(in) :: effects(:)   !! effects that have begun
    class(contact_law), intent(in) :: law        !! law of each contact
    real(real64), intent(in) :: compression      !! of the state, length, 0 or more
    real(real64), intent(out) :: shares(:)       !! of each effect
    type(contact_state) :: state
    integer :: i

    shares = 0.0_real64
    if (size(pairs%list) == 0 .or. size(effects) == 0) return
    call start_state(pairs, law, compression, state)
    do i = 1, size(effects)
      shares(i) = effects(i)%effect%estimate(pairs, state)
    end do
  end subroutine estimate_shares

  ! Lists the states: loading, or the path, then the hold.
  subroutine list_asperity_steps(self, steps, failure)
    class(asperity_bodies), intent(inout), target :: self
    type(path_step), allocatable, intent(out) :: steps(:)
    character(len=:), allocatable, intent(out) :: failure
    type(path_step), allocatable :: hold(:)
    type(contact_state) :: state
    real(real64) :: duration
    logical :: creeps
    integer :: i

    self%found%compression = self%pairs%compression
    if (is_load(self%scene_in%loading%control) .and. .not. self%simulated) then
      call compress_to_load(self%pairs, self%effects, self%pairs%target, 0.0_real64, self%found, &
                         failure)
      if (allocated(failure)) return
    end if
    creeps = .false.
    if (any([(self%effects(i)%effect%acts_in_time, i=1, size(self%effects))])) then
      call start_state(self%pairs, hertz_law(modulus=self%pairs%modulus), self%found%compression, &
                       state)
      call choose_effects(self%pairs, self%effects, state, self%found%choice)
      creeps = any([(self%found%choice%is_simulated(i) .and. &
                     self%effects(i)%effect%acts_in_time, i=1, size(self%effects))])
    end if
    duration = merge(self%scene_in%effects%number('loading_time'), 0.0_real64, creeps)
    call plan_states(self%scene_in, self%pairs, self%effects, self%found, duration, steps, failure)
    if (allocated(failure)) return
    if (creeps) then
      call plan_hold(self%scene_in, hold)
      steps = [steps, hold]
    end if
    allocate (self%shares(size(self%left_out), size(steps)))
    self%found%compression = 0.0_real64
  end subroutine list_asperity_steps

  ! Plans the states of loading. `points` equal parts lie between two values of a path.
  subroutine plan_states(scene_in, pairs, effects, found, duration, steps, failure)
    type(scene), intent(in) :: scene_in
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(in) :: effects(:)
    type(found_state), intent(inout) :: found  ! with the last compression
    real(real64), intent(in) :: duration  ! time of loading, 0 or more
    type(path_step), allocatable, intent(out) :: steps(:)  ! at least one
    character(len=:), allocatable, intent(out) :: failure
    real(real64), allocatable :: compressions(:), ends(:), gaps(:), given(:)

    if (.not. (allocated(scene_in%loading%path) .or. duration > 0.0_real64)) then
      allocate (gaps(0))
      if (scene_in%loading%events) then
        gaps = pairs%list%gap
        if (scene_in%effects%modes(of_interaction) /= effect_off) &
          call find_first_contacts(pairs, effects, found, gaps, failure)
        if (allocated(failure)) return
      end if
      call list_compressions(scene_in%loading%points, gaps, found%compression, compressions)
      allocate (steps(size(compressions)))
      steps%value = compressions
      if (.not. is_load(scene_in%loading%control)) return
      associate (last => steps(size(steps)))
        last%load = pairs%target
        ! After other states that of the load is searched again, as effects may have a memory.
        if (size(steps) > 1) last%control = at_load
      end associate
      return
    end if
    if (allocated(scene_in%loading%path)) then
      allocate (given, source=scene_in%loading%path)
    else
      allocate (given(1), source=scene_in%loading%value)
    end if
    associate (control => scene_in%loading%control)
      ends = in_model_units(control, given, scene_in%nominal_area, pairs%modulus_power, &
                            pairs%length_power)
      if (is_load(control) .and. any(abs(given) > 0.0_real64 .and. .not. abs(ends) / &
                                     max(1, scene_in%loading%points) > 0.0_real64)) then
        failure = 'a load of the path is too small beside the moduli and lengths to be met'
        return
      end if
      if (is_distance(control)) ends = compression_of(control, ends, pairs%first_touch)
      if (is_limit(control)) ends = found%compression
    end associate
    call plan_path(0.0_real64, ends, scene_in%loading%points, is_load(scene_in%loading%control), &
                   duration, steps)
  end subroutine plan_states

  ! Finds the compressions, up to the last, of the first contact of each pair, with displacements by
  ! neighbours: zeros of the largest penetration of the pairs that have not been in contact, by a
  ! bracketed secant method. Computed states serve the later contacts.
  ! The displacement by neighbours jumps as their load does where the number of boundary elements
  ! changes with the compression, and so does the place of a first contact.
  subroutine find_first_contacts(pairs, effects, end_state, contacts_begin, failure)
    ! Long: one search, whose states serve the next one.
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(in) :: effects(:)
    type(found_state), intent(inout) :: end_state  ! with the last compression
    real(real64), allocatable, intent(out) :: contacts_begin(:)  ! ascending, from first contact
    character(len=:), allocatable, intent(inout) :: failure
    ! Least tolerance over the last compression (chosen: the accuracy of the solution at one), and
    ! the penetration of an open contact without a value over the last one (chosen).
    real(real64), parameter :: least_tolerance = 1.0e-10_real64, share_open = 0.05_real64
    type(found_state) :: found
    type(root_bracket) :: bracket
    logical :: begun(size(pairs%list)), inside
    real(real64) :: at, below(size(pairs%list)), new, tolerance
    ! Known states with further contacts in descending compression [length].
    real(real64), allocatable :: compressions(:), penetrations(:, :)
    integer :: lead, used

    contacts_begin = [0.0_real64]
    begun = .not. pairs%list%gap > 0.0_real64
    below = -pairs%list%gap
    allocate (compressions(0), penetrations(size(begun), 0))
    call solve_at(end_state%compression)
    if (allocated(failure)) return
    do while (used > 0)
      bracket = root_bracket(low=contacts_begin(size(contacts_begin)), high=compressions(used), &
                             low_miss=-1.0_real64, high_miss=-1.0_real64, halving=4)
      lead = maxloc(penetrations(:, used), 1, .not. begun)
      if (below(lead) < -tiny(new)) call narrow_bracket(bracket, bracket%low, below(lead), .true.)
      call narrow_bracket(bracket, bracket%high, penetrations(lead, used), .false.)
      do
        lead = maxloc(penetrations(:, used), 1, .not. begun)
        new = penetrations(lead, used)
        tolerance = max(least_tolerance * end_state%compression, maxval(found%outcomes%load_jump) &
                        * (compressions(used) - pairs%list(lead)%gap - new))
        if (min(new, compressions(used) - bracket%low) <= tolerance) exit
        ! The compression since the first contact is larger than the penetration.
        call guess_by_secant(bracket, 1.0_real64, at, inside)
        if (.not. inside) exit
        ! A contact begins at the upper end.
        call solve_at(min(at + 0.5_real64 * tolerance, 0.5_real64 * (at + compressions(used))))
        if (allocated(failure)) return
        at = found%compression
        below = found%state%penetration
        if (any(.not. (begun .or. below < 0.0_real64))) then
          call narrow_bracket(bracket, at, maxval(below, .not. begun), .false.)
        else
          call narrow_bracket(bracket, at, merge(below(lead), -share_open * new, &
                                                 below(lead) < -tiny(new)), .true.)
        end if
      end do
      contacts_begin = [contacts_begin, compressions(used)]
      below = penetrations(:, used)
      begun = begun .or. .not. below < 0.0_real64
      ! The state of the least compression at which a contact is still new.
      do while (used > 0)
        if (any(.not. (begun .or. penetrations(:, used) < 0.0_real64))) exit
        used = used - 1
      end do
      compressions = compressions(:used)
      penetrations = penetrations(:, :used)
    end do

  contains

    ! Solves a state, and keeps it where a contact is new.
    subroutine solve_at(compression)
      real(real64), intent(in) :: compression

      found%compression = compression
      call simulate_effects(pairs, effects, 0.0_real64, found, .true.)
      call first_failure(effects, found%outcomes, failure)
      if (.not. allocated(failure)) then
        if (any(.not. (begun .or. found%state%penetration < 0.0_real64))) then
          compressions = [compressions, compression]
          penetrations = reshape([penetrations, found%state%penetration], &
                                 [size(begun), size(compressions)])
        end if
      end if
      used = size(compressions)
    end subroutine solve_at

  end subroutine find_first_contacts

  ! Solves a state and adds it to the results. One that the search for a load has left is not
  ! simulated again.
  subroutine solve_asperity_step(self, step, number, result, must_repeat, failure)
    class(asperity_bodies), intent(inout), target :: self
    type(path_step), intent(in) :: step
    integer, intent(in) :: number
    type(position_result), intent(inout) :: result
    logical, intent(out) :: must_repeat
    character(len=:), allocatable, intent(out) :: failure
    integer :: e

    associate (found => self%found, pairs => self%pairs, effects => self%effects)
      found%prescribed_load = step%load
      select case (step%control)
      case (at_distance)
        found%compression = step%value
      case (at_load)
        ! Without a path the compression has been found before its states.
        if (.not. (allocated(self%scene_in%loading%path) .or. step%time > 0.0_real64)) &
          found%compression = step%value
        call compress_to_load(pairs, effects, step%load, step%time, found, failure)
      case (held_load)
        found%prescribed_load = self%held
        call compress_to_load(pairs, effects, self%held, step%time, found, failure)
      case default  ! held_distance
      end select
      ! Pairs that are not listed may touch.
      must_repeat = found%compression > pairs%complete_to
      if (allocated(failure) .or. must_repeat) return
      if (.not. is_known(found, effects, step%time)) then
        ! Results of a search belong to its load.
        if (.not. found%prescribed_load < no_load) then
          if (allocated(found%fixed_choice)) deallocate (found%fixed_choice)
          if (allocated(found%solution)) deallocate (found%solution)
        end if
        call simulate_effects(pairs, effects, step%time, found)
      end if
      call first_failure(effects, found%outcomes, failure)
      if (allocated(failure)) return
      self%simulated = self%simulated .or. any(found%outcomes%simulated /= 'off')
      do e = 1, size(effects)
        call effects(e)%effect%keep(pairs, found%state)
      end do
      call drop_choice(found%choice)
      call add_contacts(self%scene_in, pairs, found%state, found%outcomes, number, &
                        found%prescribed_load < no_load, self%keep_rows, result)
      ! Estimates are for contacts without attraction.
      if (all(found%state%answers%load >= 0.0_real64)) then
        call estimate_shares(pairs, self%left_out, found%state%law, found%compression, &
                             self%shares(:, number))
      else
        call estimate_shares(pairs, self%left_out, hertz_law(modulus=pairs%modulus), &
                             found%compression, self%shares(:, number))
      end if
      if (found%prescribed_load < no_load) then
        result%states(number)%prescribed = &
          merge(prescribed_vertical, prescribed_normal, pairs%vertical)
        result%states(number)%prescribed_load = in_scene_units(pairs, found%prescribed_load, 1, 2)
        result%states(number)%load_rounding = &
          in_scene_units(pairs, load_rounding(found%state), 1, 2)
      end if
      ! Effects keep this state and may answer otherwise in the next one.
      if (allocated(found%outcomes)) deallocate (found%outcomes)
      if (step%control /= held_load) self%held = controlled_load(pairs, found%state)
    end associate
  end subroutine solve_asperity_step

  ! Compares the last state with those of fewer effects.
  subroutine compare_effects(self, steps, result, failure)
    class(asperity_bodies), intent(inout), target :: self
    type(path_step), intent(in) :: steps(:)
    type(position_result), intent(inout) :: result
    character(len=:), allocatable, intent(out) :: failure
    integer :: last

    associate (pairs => self%pairs)
      last = size(steps)
      do while (last > 1 .and. steps(last)%control == held_load)
        last = last - 1
      end do
      ! The last state is under a requested load and follows no larger one: the memory of effects on
      ! unloading is not that of fewer effects.
      if (steps(last)%load > 0.0_real64 .and. steps(last)%load < no_load .and. &
          steps(size(steps))%control /= held_distance .and. &
          all(steps(:last)%load <= steps(last)%load .or. steps(:last)%load >= no_load)) &
        call compare_at_load(pairs, self%effects, self%found, result%effects, failure)
    end associate
    ! Without a state of fewer effects under the load there is no comparison.
    if (allocated(failure)) then
      if (index(failure, not_enough_memory) == 0) deallocate (failure)
    end if
  end subroutine compare_effects

  ! Whether the state is that of its compression and a time, with all effects. The search for a load
  ! on loading leaves out effects that act in time.
  pure logical function is_known(found, effects, time)
    type(found_state), intent(in) :: found
    type(effect_box), intent(in) :: effects(:)
    real(real64), intent(in) :: time
    integer :: i

    is_known = allocated(found%outcomes)
    if (is_known .and. time > 0.0_real64) is_known = .not. abs(found%state%time - time) > 0.0_real64
    do i = 1, size(effects)
      if (.not. time > 0.0_real64) is_known = is_known .and. .not. effects(i)%effect%acts_in_time
    end do
    if (is_known) is_known = .not. abs(found%state%compression - found%compression) > 0.0_real64
  end function is_known

  ! Compares the last state with those of fewer effects under the same load: of Hertz, then with
  ! the first effect that was simulated, with the first two and so on. The change by an effect is
  ! that of its addition to those before it. It is not computed where the contacts cannot carry the
  ! load without the other effects.
  subroutine compare_at_load(pairs, effects, found, records, failure)
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(inout) :: effects(:)     ! undefined on exit
    type(found_state), intent(in) :: found            ! with all effects at the load
    type(effect_record), intent(inout) :: records(:)  ! results of each effect in it
    character(len=:), allocatable, intent(out) :: failure
    type(effect_box) :: those(size(effects))
    type(found_state) :: fewer
    real(real64) :: area, area_before, compression, compression_before
    logical :: jumps
    integer :: i, k, number, simulated

    simulated = count(records%simulated /= 'off')
    if (simulated == 0) return
    number = 0
    fewer%compression = pairs%compression
    call search_load(pairs, those(:0), found%prescribed_load, 0.0_real64, fewer, jumps, failure)
    if (allocated(failure)) return
    compression = fewer%compression
    area = area_of(fewer%state)
    do i = 1, size(effects)
      if (records(i)%simulated == 'off') cycle
      number = number + 1
      call move_alloc(effects(i)%effect, those(number)%effect)
      compression_before = compression
      area_before = area
      if (number == simulated) then
        compression = found%state%compression
        area = area_of(found%state)
      else
        ! The memory is that of all effects together.
        do k = 1, number
          call those(k)%effect%begin(pairs)
        end do
        call drop_choice(fewer%choice)
        allocate (fewer%fixed_choice(number))
        fewer%fixed_choice = .true.
        call search_load(pairs, those(:number), found%prescribed_load, found%state%time, fewer, &
                         jumps, failure)
        deallocate (fewer%fixed_choice)
        if (allocated(failure)) return
        compression = fewer%compression
        area = area_of(fewer%state)
      end if
      if (compression_before > 0.0_real64) &
        records(i)%compression_change = compression / compression_before - 1.0_real64
      if (area_before > 0.0_real64) records(i)%area_change = area / area_before - 1.0_real64
    end do
  end subroutine compare_at_load

  ! Contact area over pi, length squared.
  pure real(real64) function area_of(state)
    type(contact_state), intent(in) :: state

    area_of = sum(state%answers%contact_radius**2)
  end function area_of

end module asperity_asperity_position
