!> The sequence of states of a position: loading, a path of loads or separations, and a hold.
module asperity_asperity_path
  use asperity_contact_effect, only: effect_box
  use asperity_contact_model, only: at_load, path_step
  use asperity_contact_pairs, only: contact_pairs
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_effect_sequence, only: first_failure, found_state, simulate_effects
  use asperity_isolated_contacts, only: list_compressions
  use asperity_kinds, only: real64
  use asperity_path_steps, only: plan_path
  use asperity_root_bracket, only: guess_by_secant, narrow_bracket, root_bracket
  use asperity_scene_values, only: control_compression, control_limit, control_pressure, &
                                   effect_off, is_load, scene
  implicit none
  private

  public :: plan_states

contains

  !> Plans the states of loading. `points` equal parts lie between two values of a path.
  subroutine plan_states(scene_in, pairs, effects, found, duration, steps, failure)
    type(scene), intent(in) :: scene_in                       !! scene, checked for faults
    type(contact_pairs), intent(in) :: pairs                  !! pairs of the position
    type(effect_box), intent(in) :: effects(:)                !! effects of the scene
    !> with the last compression without a path; gets the number of solves
    type(found_state), intent(inout) :: found
    real(real64), intent(in) :: duration                      !! time of loading, 0 or more
    type(path_step), allocatable, intent(out) :: steps(:)     !! states, at least one
    !> a load of the path is 0 in the unit of the pairs, or a first contact is not found
    character(len=:), allocatable, intent(out) :: failure
    type(decimal_value), allocatable :: given(:)
    real(real64), allocatable :: compressions(:), ends(:), gaps(:)
    integer :: i

    if (.not. (allocated(scene_in%loading%path) .or. duration > 0.0_real64)) then
      allocate (gaps(0))
      if (scene_in%loading%events) then
        gaps = pairs%list%gap
        if (scene_in%effects%mode('interaction') /= effect_off) &
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
    allocate (ends(size(given)))
    do i = 1, size(ends)
      ends(i) = value_of(scene_in, pairs, given(i))
      if (is_load(scene_in%loading%control) .and. given(i)%all_digits /= 0 .and. &
          .not. abs(ends(i)) / max(1, scene_in%loading%points) > 0.0_real64) then
        failure = 'a load of the path is too small beside the moduli and lengths to be met'
        return
      end if
    end do
    if (scene_in%loading%control == control_limit) ends = found%compression
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
    type(found_state), intent(inout) :: end_state  ! with the last compression; counts solves
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
      found%solves = end_state%solves
      call simulate_effects(pairs, effects, 0.0_real64, found, .true.)
      end_state%solves = found%solves
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

  ! A value of the path in the unit of the pairs: a load, or the compression of a separation.
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

end module asperity_asperity_path
