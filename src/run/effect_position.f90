!> One position with its effects: loading, path and hold, state by state.
module asperity_effect_position
  use asperity_closing_at_load, only: close_to_load, search_load
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_law, only: contact_law
  use asperity_contact_pairs, only: contact_pairs, in_scene_units
  use asperity_contact_records, only: prescribed_normal, prescribed_vertical, effect_record, &
    most_rows, &
                                      position_result
  use asperity_contact_state, only: kept_results, contact_state, controlled_load, shift_x, &
    shift_y, &
                                    start_state, total_load, total_vertical_load
  use asperity_earlier_solutions, only: keep_solution, mark_crowded
  use asperity_effect_choice, only: choose_effects
  use asperity_effect_path, only: as_before, path_step, plan_hold, plan_states, stay, to_closing, &
                                   to_load
  use asperity_effect_rows, only: add_state
  use asperity_effect_sequence, only: first_failure, found_state, simulate_effects
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_problems, only: not_enough_memory
  use asperity_scene_values, only: is_load, scene
  implicit none
  private

  public :: position_run, run_position

  !> Options and outcome of the computation of one position.
  type :: position_run
    logical :: keep_rows = .true.   !! whether the contacts of every state are kept
    !> whether there was a path or a simulated effect; else the solver without effects suffices
    logical :: simulated = .false.
    logical :: too_far = .false.    !! pairs that are not listed may touch: repeat with all pairs
    !> contact law in the state of the largest compression; not allocated: one with attraction
    class(contact_law), allocatable :: law
  end type position_run

contains

  !> Computes all states of a position that has pairs.
  subroutine run_position(scene_in, pairs, effects, result, run, failure)
    type(scene), intent(in) :: scene_in                    !! scene, checked for faults
    type(contact_pairs), intent(in) :: pairs               !! pairs of the position, at least one
    type(effect_box), intent(inout) :: effects(:)          !! effects of the scene with their memory
    type(position_result), intent(out) :: result           !! states, results of the effects
    type(position_run), intent(inout) :: run               !! options; the outcome
    character(len=:), allocatable, intent(out) :: failure  !! reason, when a state is not solved
    type(path_step), allocatable :: steps(:), hold(:)
    type(found_state) :: found
    integer :: i

    result%x_displacement = pairs%x_displacement
    result%y_displacement = pairs%y_displacement
    run%simulated = allocated(scene_in%loading%path)
    run%too_far = .false.
    if (allocated(run%law)) deallocate (run%law)
    do i = 1, size(effects)
      call effects(i)%effect%begin(pairs)
    end do
    found%closing = pairs%closing
    if (is_load(scene_in%loading%control) .and. .not. run%simulated) then
      call close_to_load(pairs, effects, pairs%target, 0.0_real64, found, failure)
      if (allocated(failure)) return
    end if
    call plan_states(scene_in, pairs, effects, found%closing, steps, failure)
    if (allocated(failure)) return
    allocate (hold(0))
    if (acts_in_time(pairs, effects, found%closing)) call plan_hold(scene_in, hold)
    steps = [steps, hold]
    allocate (result%states(size(steps)), result%rows(0))
    call run_steps(scene_in, pairs, effects, steps, found, result, run, failure)
    ! The states end early when there are more contacts than can be kept.
    if (run%too_far .or. allocated(failure) .or. .not. allocated(result%effects)) return
    associate (state => found%state)
      if (pairs%keeps_solution .and. allocated(state%found)) then
        if (state%found(1, kept_results) > 0.0_real64) then
          call keep_solution(pairs, state%closing, &
                             [total_load(state), total_vertical_load(state)], &
                             state%penetration, transpose(state%found(2:, shift_x:shift_y)), &
                             result%start)
        else
          call mark_crowded(pairs, state%closing, controlled_load(pairs, state), result%start)
        end if
      end if
      if (only_grows(steps)) &
        call compare_at_load(pairs, effects, found%prescribed_load, state, result%effects, failure)
    end associate
    ! Without a state of fewer effects under the load there is no comparison.
    if (allocated(failure)) then
      if (index(failure, not_enough_memory) == 0) deallocate (failure)
    end if
  end subroutine run_position

  ! Computes state after state. A state that the search for a load has left is not simulated again.
  subroutine run_steps(scene_in, pairs, effects, steps, found, result, run, failure)
    type(scene), intent(in) :: scene_in
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(inout) :: effects(:)
    type(path_step), intent(in) :: steps(:)
    type(found_state), intent(inout) :: found   ! last state
    type(position_result), intent(inout) :: result
    type(position_run), intent(inout) :: run
    character(len=:), allocatable, intent(out) :: failure
    real(real64) :: deepest, held
    integer :: e, i

    found%closing = 0.0_real64
    deepest = -1.0_real64
    held = 0.0_real64
    do i = 1, size(steps)
      found%prescribed_load = steps(i)%load
      select case (steps(i)%control)
      case (to_closing)
        found%closing = steps(i)%value
      case (to_load)
        call close_to_load(pairs, effects, steps(i)%load, 0.0_real64, found, failure)
      case (as_before)
        found%prescribed_load = held
        call close_to_load(pairs, effects, held, steps(i)%time, found, failure)
      case default  ! stay
      end select
      run%too_far = found%closing > pairs%complete_to
      if (allocated(failure) .or. run%too_far) return
      if (.not. is_known(found, effects, steps(i)%time)) then
        ! Results of a search belong to its load.
        if (.not. found%prescribed_load < huge(held)) then
          if (allocated(found%called_for)) deallocate (found%called_for)
          if (allocated(found%found)) deallocate (found%found)
        end if
        call simulate_effects(pairs, effects, steps(i)%time, found)
      end if
      call first_failure(effects, found%outcomes, failure)
      if (allocated(failure)) return
      run%simulated = run%simulated .or. any(found%outcomes%simulated /= 'off')
      do e = 1, size(effects)
        call effects(e)%effect%keep(pairs, found%state)
      end do
      call add_state(scene_in, pairs, effects, found%state, found%outcomes, i, run%keep_rows, &
                     result)
      if (found%closing > deepest) then
        deepest = found%closing
        if (allocated(run%law)) deallocate (run%law)
        if (all(found%state%answers%load >= 0.0_real64)) allocate (run%law, source=found%state%law)
      end if
      if (found%prescribed_load < huge(held)) then
        result%states(i)%prescribed = merge(prescribed_vertical, prescribed_normal, pairs%vertical)
        result%states(i)%prescribed_load = in_scene_units(pairs, found%prescribed_load, 1, 2)
      end if
      call pairs%progress_count%count_state(result%counted)
      ! Effects keep this state and may answer otherwise in the next one.
      if (allocated(found%outcomes)) deallocate (found%outcomes)
      if (steps(i)%control /= as_before) held = controlled_load(pairs, found%state)
      if (result%rows_used > most_rows) exit
    end do
  end subroutine run_steps

  ! Whether the last state is under a requested load and follows no larger one: the memory of
  ! effects on unloading is not that of fewer effects.
  pure logical function only_grows(steps)
    type(path_step), intent(in) :: steps(:)
    integer :: last

    last = size(steps)
    do while (last > 1 .and. steps(last)%control == as_before)
      last = last - 1
    end do
    only_grows = steps(last)%load > 0.0_real64 .and. steps(last)%load < huge(1.0_real64) .and. &
                 steps(size(steps))%control /= stay
    if (only_grows) only_grows = all(steps(:last)%load <= steps(last)%load .or. &
                                     steps(:last)%load >= huge(1.0_real64))
  end function only_grows

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
    if (is_known) is_known = .not. abs(found%state%closing - found%closing) > 0.0_real64
  end function is_known

  ! Whether an effect that acts in time is simulated.
  logical function acts_in_time(pairs, effects, closing)
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(in) :: effects(:)
    real(real64), intent(in) :: closing
    type(contact_state) :: state
    type(effect_outcome) :: outcomes(size(effects))
    logical, allocatable :: called(:)
    real(real64) :: left
    integer :: i

    acts_in_time = .false.
    if (.not. any([(effects(i)%effect%acts_in_time, i=1, size(effects))])) return
    call start_state(pairs, hertz_law(modulus=pairs%modulus), closing, state)
    call choose_effects(pairs, effects, state, outcomes, called, left)
    do i = 1, size(effects)
      acts_in_time = acts_in_time .or. (called(i) .and. effects(i)%effect%acts_in_time)
    end do
  end function acts_in_time

  ! Compares the last state with those of fewer effects under the same load: of Hertz, then with
  ! the first effect that was simulated, with the first two and so on. The change by an effect is
  ! that of its addition to those before it. It is not computed where the contacts cannot carry the
  ! load without the other effects.
  subroutine compare_at_load(pairs, effects, load, state, records, failure)
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(inout) :: effects(:)     ! undefined on exit
    real(real64), intent(in) :: load                  ! requested load, > 0
    type(contact_state), intent(in) :: state          ! state with all effects at this load
    type(effect_record), intent(inout) :: records(:)  ! results of each effect in it
    character(len=:), allocatable, intent(out) :: failure
    type(effect_box) :: those(size(effects))
    type(found_state) :: fewer
    real(real64) :: area, area_before, closing, closing_before
    logical :: jumps
    integer :: i, k, number, simulated

    simulated = count(records%simulated /= 'off')
    if (simulated == 0) return
    number = 0
    fewer%closing = pairs%closing
    call search_load(pairs, those(:0), load, 0.0_real64, fewer, jumps, failure)
    if (allocated(failure)) return
    closing = fewer%closing
    area = area_of(fewer%state)
    do i = 1, size(effects)
      if (records(i)%simulated == 'off') cycle
      number = number + 1
      call move_alloc(effects(i)%effect, those(number)%effect)
      closing_before = closing
      area_before = area
      if (number == simulated) then
        closing = state%closing
        area = area_of(state)
      else
        ! The memory is that of all effects together.
        do k = 1, number
          call those(k)%effect%begin(pairs)
        end do
        allocate (fewer%called_for(number))
        fewer%called_for = .true.
        call search_load(pairs, those(:number), load, state%time, fewer, jumps, failure)
        deallocate (fewer%called_for)
        if (allocated(failure)) return
        closing = fewer%closing
        area = area_of(fewer%state)
      end if
      if (closing_before > 0.0_real64) &
        records(i)%closing_change = closing / closing_before - 1.0_real64
      if (area_before > 0.0_real64) records(i)%area_change = area / area_before - 1.0_real64
    end do
  end subroutine compare_at_load

  ! Contact area over pi, length squared.
  pure real(real64) function area_of(state)
    type(contact_state), intent(in) :: state

    area_of = sum(state%answers%contact_radius**2)
  end function area_of

end module asperity_effect_position
