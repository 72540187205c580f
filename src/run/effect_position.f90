!> One position with its effects: loading, path and hold, state by state.
module asperity_effect_position
  use asperity_closing_at_load, only: close_to_load
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_law, only: contact_law
  use asperity_contact_pairs, only: contact_pairs, in_scene_units
  use asperity_contact_records, only: asked_normal, asked_vertical, most_rows, &
                                      position_result
  use asperity_contact_state, only: apart, contact_state, load_asked_for, move_x, move_y, &
                                    start_state, total_load, total_vertical_load
  use asperity_earlier_solutions, only: keep_solution, mark_crowded
  use asperity_effect_at_load, only: weigh_at_load
  use asperity_effect_choice, only: choose_effects
  use asperity_effect_path, only: as_before, path_step, plan_hold, plan_states, stay, to_closing, &
                                   to_load
  use asperity_effect_rows, only: add_state
  use asperity_effect_sequence, only: first_failure, simulate
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_problems, only: not_enough_memory
  use asperity_scene_values, only: is_load, scene
  implicit none
  private

  public :: run_position

contains

  !> Computes all states of a position that has pairs. `simulated` is false when `auto` left all
  !> effects out and the position has nothing that the solver without effects does not know;
  !> `too_far` is true when pairs that were not listed may touch.
  subroutine run_position(scene_in, pairs, effects, keep_rows, result, law, simulated, too_far, &
                          failure)
    type(scene), intent(in) :: scene_in                    !! checked values
    type(contact_pairs), intent(in) :: pairs               !! at least one
    type(effect_box), intent(inout) :: effects(:)          !! of the scene; they remember
    logical, intent(in) :: keep_rows                       !! keep the contacts of every state
    type(position_result), intent(out) :: result           !! the states, what the effects did
    !> of the contacts in the state of the largest compression; not allocated: it attracts
    class(contact_law), allocatable, intent(out) :: law
    logical, intent(out) :: simulated                      !! an effect was
    logical, intent(out) :: too_far                        !! to be done again with all pairs
    character(len=:), allocatable, intent(out) :: failure  !! why not
    type(path_step), allocatable :: steps(:), hold(:)
    type(contact_state) :: state
    type(effect_outcome), allocatable :: outcomes(:)
    logical, allocatable :: called_for(:)
    real(real64), allocatable :: found(:, :)
    real(real64) :: closing, held
    integer :: i

    result%x_displacement = pairs%x_displacement
    result%y_displacement = pairs%y_displacement
    simulated = allocated(scene_in%loading%path)
    too_far = .false.
    do i = 1, size(effects)
      call effects(i)%effect%begin(pairs)
    end do
    closing = pairs%closing
    if (is_load(scene_in%loading%control) .and. .not. simulated) then
      call close_to_load(pairs, effects, pairs%target, 0.0_real64, closing, state, outcomes, &
                         called_for, found, failure)
      if (allocated(failure)) return
    end if
    call plan_states(scene_in, pairs, effects, closing, steps, failure)
    if (allocated(failure)) return
    allocate (hold(0))
    if (acts_in_time(pairs, effects, closing)) call plan_hold(scene_in, hold)
    steps = [steps, hold]
    allocate (result%states(size(steps)), result%rows(0))
    call walk(scene_in, pairs, effects, steps, keep_rows, result, law, state, outcomes, &
              called_for, found, held, simulated, too_far, failure)
    ! More contacts than can be kept end the walk early.
    if (too_far .or. allocated(failure) .or. .not. allocated(result%effects)) return
    if (pairs%keeps_solution .and. allocated(state%found)) then
      if (state%found(1, apart) > 0.0_real64) then
        call keep_solution(pairs, state%closing, [total_load(state), total_vertical_load(state)], &
                           state%penetration, transpose(state%found(2:, move_x:move_y)), &
                           result%start)
      else
        call mark_crowded(pairs, state%closing, load_asked_for(pairs, state), result%start)
      end if
    end if
    if (only_grows(steps)) &
      call weigh_at_load(pairs, effects, held, state, result%effects, failure)
    ! A load that is not borne with fewer effects cannot be compared.
    if (allocated(failure)) then
      if (index(failure, not_enough_memory) == 0) deallocate (failure)
    end if
  end subroutine run_position

  ! Goes from state to state. A state that is known already, from the search for a load, is not
  ! simulated again.
  subroutine walk(scene_in, pairs, effects, steps, keep_rows, result, law, state, outcomes, &
                  called_for, found, asked, simulated, too_far, failure)
    type(scene), intent(in) :: scene_in
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(inout) :: effects(:)
    type(path_step), intent(in) :: steps(:)
    logical, intent(in) :: keep_rows
    type(position_result), intent(inout) :: result
    class(contact_law), allocatable, intent(inout) :: law
    type(contact_state), intent(inout) :: state
    type(effect_outcome), allocatable, intent(inout) :: outcomes(:)
    logical, allocatable, intent(inout) :: called_for(:)
    real(real64), allocatable, intent(inout) :: found(:, :)
    real(real64), intent(out) :: asked
    logical, intent(inout) :: simulated
    logical, intent(out) :: too_far
    character(len=:), allocatable, intent(out) :: failure
    real(real64) :: closing, deepest, held
    integer :: e, i

    closing = 0.0_real64
    deepest = -1.0_real64
    held = 0.0_real64
    too_far = .false.
    do i = 1, size(steps)
      asked = steps(i)%load
      select case (steps(i)%kind)
      case (to_closing)
        closing = steps(i)%value
      case (to_load)
        call close_to_load(pairs, effects, asked, 0.0_real64, closing, state, outcomes, &
                           called_for, found, failure)
      case (as_before)
        asked = held
        call close_to_load(pairs, effects, held, steps(i)%time, closing, state, outcomes, &
                           called_for, found, failure)
      case default  ! stay
      end select
      too_far = closing > pairs%complete_to
      if (allocated(failure) .or. too_far) return
      if (.not. is_known(state, outcomes, effects, closing, steps(i)%time)) then
        if (asked < huge(asked)) then
          call simulate(pairs, effects, closing, steps(i)%time, state, outcomes, found=found, &
                        called_for=called_for)
        else
          call simulate(pairs, effects, closing, steps(i)%time, state, outcomes)
        end if
      end if
      call first_failure(effects, outcomes, failure)
      if (allocated(failure)) return
      simulated = simulated .or. any(outcomes%simulated /= 'off')
      do e = 1, size(effects)
        call effects(e)%effect%keep(pairs, state)
      end do
      call add_state(scene_in, pairs, effects, state, outcomes, i, keep_rows, result)
      if (closing > deepest) then
        deepest = closing
        if (allocated(law)) deallocate (law)
        if (all(state%answers%load >= 0.0_real64)) allocate (law, source=state%law)
      end if
      if (asked < huge(asked)) then
        result%states(i)%asked = merge(asked_vertical, asked_normal, pairs%vertical)
        result%states(i)%load_asked = in_scene_units(pairs, asked, 1, 2)
      end if
      call pairs%count%step(result%counted)
      ! What follows may remember this state and answer otherwise.
      if (allocated(outcomes)) deallocate (outcomes)
      if (steps(i)%kind /= as_before) held = load_asked_for(pairs, state)
      if (result%rows_used > most_rows) exit
    end do
  end subroutine walk

  ! Whether the last state is under a load that was asked for and comes from no larger one: what is
  ! remembered of a way back is not what fewer effects would remember.
  pure logical function only_grows(steps)
    type(path_step), intent(in) :: steps(:)
    integer :: last

    last = size(steps)
    do while (last > 1 .and. steps(last)%kind == as_before)
      last = last - 1
    end do
    only_grows = steps(last)%load > 0.0_real64 .and. steps(last)%load < huge(1.0_real64) .and. &
                 steps(size(steps))%kind /= stay
    if (only_grows) only_grows = all(steps(:last)%load <= steps(last)%load .or. &
                                     steps(:last)%load >= huge(1.0_real64))
  end function only_grows

  ! Whether a state is that of a closing and time, with all effects. The search for a load while
  ! loading leaves out those that act in time.
  pure logical function is_known(state, outcomes, effects, closing, time)
    type(contact_state), intent(in) :: state
    type(effect_outcome), allocatable, intent(in) :: outcomes(:)
    type(effect_box), intent(in) :: effects(:)
    real(real64), intent(in) :: closing, time
    integer :: i

    is_known = allocated(outcomes)
    if (is_known .and. time > 0.0_real64) is_known = .not. abs(state%time - time) > 0.0_real64
    do i = 1, size(effects)
      if (.not. time > 0.0_real64) &
        is_known = is_known .and. .not. effects(i)%effect%acts_in_time
    end do
    if (is_known) is_known = .not. abs(state%closing - closing) > 0.0_real64
  end function is_known

  ! Whether an effect that acts in time is called for.
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

end module asperity_effect_position
