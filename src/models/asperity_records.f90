!> Records of the states and contacts of a position with effects, in the units of the scene.
module asperity_asperity_records
  use asperity_constants, only: pi
  use asperity_contact_effect, only: column_name, effect_box, effect_outcome, moment
  use asperity_contact_pairs, only: contact_pairs, in_scene_units
  use asperity_contact_records, only: contact_row, position_result, prescribed_nothing, state_row
  use asperity_contact_state, only: contact_state, in_contact, start_state
  use asperity_contact_law, only: contact_response
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: not_computed, real64
  use asperity_effect_header, only: add_effect, begin_header, effect_header
  use asperity_scene_values, only: criterion_load, criterion_none, is_load, scene
  use asperity_state_tally, only: add_contact, begin_tally, finish_tally, state_tally
  use asperity_theory_limits, only: seen_contact
  use asperity_theory_warnings, only: of_error, of_together, take_worse, theory_warning, add_warning
  implicit none
  private

  public :: add_contacts, add_nothing, add_without_effects, error_of_share, name_effects

  ! Largest ratio of the relative error of the compression at a load to that of the load at a
  ! compression.
  real(real64), parameter :: of_compression = 0.75_real64

contains

  !> Sets the names and modes of the effects.
  subroutine name_effects(effects, header)
    type(effect_box), intent(in) :: effects(:)     !! effects of the scene
    type(effect_header), intent(out) :: header     !! header without columns
    integer :: i

    call begin_header(header)
    do i = 1, size(effects)
      call add_effect(header, effects(i)%effect%name, effects(i)%effect%mode)
    end do
  end subroutine name_effects

  !> Adds a state to its position: totals, and the rows of contacts when they are kept.
  subroutine add_contacts(scene_in, pairs, state, outcomes, number, by_load, keep_rows, result)
    type(scene), intent(in) :: scene_in                !! scene that is solved
    type(contact_pairs), intent(in) :: pairs           !! pairs of the position
    type(contact_state), intent(in) :: state           !! contacts with the effects
    type(effect_outcome), intent(in) :: outcomes(:)    !! results of each effect
    integer, intent(in) :: number                      !! number of the state, from 1
    logical, intent(in) :: by_load                     !! whether the load is prescribed
    logical, intent(in) :: keep_rows                   !! whether contacts are kept
    type(position_result), intent(inout) :: result     !! result of the position
    type(state_tally) :: tally
    integer :: i

    tally = state_tally(pairs%length_power, pairs%modulus_power, &
                        pairs%modulus_power + 2 * pairs%length_power)
    call begin_tally(tally, size(pairs%list), keep_rows, number == size(result%states))
    do i = 1, size(pairs%list)
      if (in_contact(state, i)) &
        call add_contact(tally, pairs%limits, contact_of(scene_in, pairs, state, i))
    end do
    call finish_tally(tally, pairs%limits, pairs%first_touch - state%compression, &
                      state%compression, number, result)
    result%states(number)%time = state%time
    if (keep_rows) call add_contact_values(pairs, state, outcomes, result)
    if (associated(pairs%pressures)) then
      if (pairs%pressures%of_all_states .or. number == size(result%states)) then
        if (.not. allocated(result%pressures)) allocate (result%pressures(size(result%states)))
        associate (kept => result%pressures(number), unit => pairs%length_power)
          ! Pressures on boundary elements are those of their compression only.
          if (.not. abs(pairs%pressures%compression - state%compression) > 0.0_real64) then
            kept = pairs%pressures
            kept%x = scale(kept%x, unit)
            kept%y = scale(kept%y, unit)
            kept%side = scale(kept%side, unit)
          end if
          if (allocated(state%solution)) kept%shift = scale(state%solution%shift, unit)
        end associate
      end if
    end if
    do i = 1, size(outcomes)
      call take_worse(result%warnings, outcomes(i)%warnings, number)
    end do
    call add_errors(pairs, by_load, outcomes, result%states(number))
    if (number == size(result%states)) &
      call close_position(scene_in, pairs, outcomes, result)
  end subroutine add_contacts

  !> Adds the results of the effects for a state at which all of them are left out.
  subroutine add_without_effects(scene_in, pairs, effects, state, outcomes, number, keep_rows, &
                                 result)
    type(scene), intent(in) :: scene_in                  !! scene that is solved
    type(contact_pairs), intent(in) :: pairs             !! pairs of the position
    type(effect_box), intent(in) :: effects(:)           !! effects of the scene
    type(contact_state), intent(in) :: state             !! contacts without effects
    type(effect_outcome), intent(inout) :: outcomes(:)   !! results with the estimates
    integer, intent(in) :: number                        !! number of the state, from 1
    logical, intent(in) :: keep_rows                     !! whether contacts are kept
    !> Result with states, and whether they are under a prescribed load; gets values.
    type(position_result), intent(inout) :: result
    integer :: i

    do i = 1, size(effects)
      call effects(i)%effect%leave_out(pairs, state, outcomes(i))
      call effects(i)%effect%finish(pairs, state, outcomes(i))
    end do
    if (keep_rows) then
      result%rows_used = result%rows_used + count([(in_contact(state, i), i=1, size(pairs%list))])
      call add_contact_values(pairs, state, outcomes, result)
    end if
    call add_errors(pairs, result%states(number)%prescribed /= prescribed_nothing, outcomes, &
                    result%states(number))
    if (number == size(result%states)) &
      call close_position(scene_in, pairs, outcomes, result)
  end subroutine add_without_effects

  ! Adds the dissipated work of a state, and its errors: estimates of the effects that `auto` left
  ! out, and errors of the simulated ones.
  subroutine add_errors(pairs, by_load, outcomes, state)
    type(contact_pairs), intent(in) :: pairs
    logical, intent(in) :: by_load  ! the load is prescribed
    type(effect_outcome), intent(in) :: outcomes(:)
    type(state_row), intent(inout) :: state
    integer :: at, i

    associate (total => state%error_estimate)
      do i = 1, size(outcomes)
        associate (outcome => outcomes(i))
          if (outcome%dissipated_work > not_computed) state%dissipated_work = &
            in_scene_units(pairs, outcome%dissipated_work, moment(1), moment(2))
          if (outcome%simulated == 'off' .and. outcome%estimate > not_computed) then
            total = max(total, 0.0_real64) + error_of_share(by_load, outcome%estimate)
          else if (outcome%error > not_computed) then
            total = max(total, 0.0_real64) + outcome%error
          end if
          if (.not. allocated(outcome%of_state%names)) cycle
          at = findloc(outcome%of_state%names%text, 'area_error_estimate', 1)
          if (at > 0) state%area_error = outcome%of_state%values(1, at)
        end associate
      end do
    end associate
  end subroutine add_errors

  !> Relative error by a share of the load that is left out: of the load or, under a prescribed one,
  !> of the compression.
  elemental real(real64) function error_of_share(by_load, share)
    logical, intent(in) :: by_load       !! the load is prescribed
    real(real64), intent(in) :: share    !! of the load

    error_of_share = merge(of_compression, 1.0_real64, by_load) * share
  end function error_of_share

  ! Sets the results of the effects for a position, from its last state.
  subroutine close_position(scene_in, pairs, outcomes, result)
    type(scene), intent(in) :: scene_in
    type(contact_pairs), intent(in) :: pairs
    type(effect_outcome), intent(in) :: outcomes(:)
    type(position_result), intent(inout) :: result
    type(theory_warning), allocatable :: warnings(:)
    integer :: i

    allocate (result%effects(size(outcomes)), result%state_values(0), result%state_columns(0), &
              result%contact_columns(0))
    do i = 1, size(outcomes)
      result%effects(i) = outcomes(i)%effect_record
      associate (columns => outcomes(i)%of_state)
        result%state_columns = [result%state_columns, columns%names]
        result%contact_columns = [result%contact_columns, outcomes(i)%of_contacts%names]
        result%state_values = [result%state_values, &
                               in_units(columns%names, pairs, columns%values(1, :))]
      end associate
    end do
    ! Contacts in tension have no estimate of an effect that has no common theory with another one:
    ! the largest over the states.
    if (allocated(result%warnings)) then
      do i = 1, size(result%warnings)
        associate (states => result%states, warning => result%warnings(i))
          if (warning%number == of_together) &
            where (states%load < 0.0_real64) states%error_estimate = max( &
              states%error_estimate, error_of_share(is_load(scene_in%loading%control), &
                                                    warning%magnitude))
        end associate
      end do
    end if
    result%error_estimate = result%states(size(result%states))%error_estimate
    if (result%error_estimate > scene_in%effects%number('tolerance')) &
      call add_warning(warnings, of_error, result%error_estimate)
    call take_worse(result%warnings, warnings, size(result%states))
  end subroutine close_position

  !> Adds the results of the effects at a position at which no pair can touch.
  subroutine add_nothing(scene_in, pairs, effects, result)
    type(scene), intent(in) :: scene_in              !! scene that is solved
    type(contact_pairs), intent(in) :: pairs         !! position without pairs
    type(effect_box), intent(inout) :: effects(:)    !! effects of the scene
    type(position_result), intent(inout) :: result   !! result with allocated states
    type(contact_state) :: state
    type(effect_outcome) :: outcomes(size(effects))
    integer :: i

    call start_state(pairs, hertz_law(modulus=pairs%modulus), 0.0_real64, state)
    do i = 1, size(effects)
      call effects(i)%effect%begin(pairs)
    end do
    call add_without_effects(scene_in, pairs, effects, state, outcomes, size(result%states), &
                             .true., result)
  end subroutine add_nothing

  ! One contact of a state.
  type(seen_contact) function contact_of(scene_in, pairs, state, i) result(contact)
    type(scene), intent(in) :: scene_in
    type(contact_pairs), intent(in) :: pairs
    type(contact_state), intent(in) :: state
    integer, intent(in) :: i
    type(contact_response) :: at_limit
    real(real64), parameter :: rounding = 8 * epsilon(1.0_real64)

    associate (pair => pairs%list(i), answer => state%answers(i))
      contact%contact_row = contact_row(area_no=i, upper=pair%upper, lower=pair%lower, x=pair%x, &
        y=pair%y, average_pressure=0.0_real64, penetration=state%penetration(i), &
        overlap=answer%overlap, area=pi * answer%contact_radius**2, load=answer%load, &
        vertical_load=answer%vertical_load, maximum_pressure=answer%maximum_pressure)
      contact%upper_radius = pair%upper_radius
      contact%lower_radius = pair%lower_radius
      contact%upper_height = pair%upper_height
      contact%lower_height = pair%lower_height
      contact%contact_radius = answer%contact_radius
      contact%cosine = answer%cosine
      contact%d = pair%d
      contact%z = pair%zc - state%penetration(i)
      if (contact%area > 0.0_real64) contact%average_pressure = contact%load / contact%area
      if (scene_in%limit%criterion == criterion_none .or. &
          pair%limit > 0.5_real64 * huge(1.0_real64)) return
      ! A contact is at its limit where its load or greatest pressure is that of the contact law at
      ! the penetration of the limit.
      call state%law%respond(pair, i, pair%limit, at_limit)
      if (scene_in%limit%criterion == criterion_load) then
        contact%limit_exceeded = answer%load >= at_limit%load * (1.0_real64 - rounding)
      else
        contact%limit_exceeded = answer%maximum_pressure >= &
                                 at_limit%maximum_pressure * (1.0_real64 - rounding)
      end if
    end associate
  end function contact_of

  ! Appends the values of the effects for the contacts of a state to those of the former states.
  subroutine add_contact_values(pairs, state, outcomes, result)
    type(contact_pairs), intent(in) :: pairs
    type(contact_state), intent(in) :: state
    type(effect_outcome), intent(in) :: outcomes(:)
    type(position_result), intent(inout) :: result
    real(real64), allocatable :: values(:, :)
    integer :: before, e, i, last, row

    before = 0
    if (allocated(result%contact_values)) before = size(result%contact_values, 1)
    allocate (values(result%rows_used, sum([(size(outcomes(e)%of_contacts%names), &
                                             e=1, size(outcomes))])))
    if (before > 0) values(:before, :) = result%contact_values
    row = before
    do i = 1, size(pairs%list)
      if (.not. in_contact(state, i)) cycle
      row = row + 1
      last = 0
      do e = 1, size(outcomes)
        associate (columns => outcomes(e)%of_contacts)
          values(row, last + 1:last + size(columns%names)) = &
            in_units(columns%names, pairs, columns%values(i, :))
          last = last + size(columns%names)
        end associate
      end do
    end do
    call move_alloc(values, result%contact_values)
  end subroutine add_contact_values

  ! A value of a column in the units of the scene.
  elemental real(real64) function in_units(column, pairs, value)
    type(column_name), intent(in) :: column
    type(contact_pairs), intent(in) :: pairs
    real(real64), intent(in) :: value

    in_units = value
    if (value > not_computed) &
      in_units = in_scene_units(pairs, value, column%modulus_power, column%length_power)
  end function in_units

end module asperity_asperity_records
