!> Solves a scene with its effects: the contacts of every position, then the effects called for.
!>
!> Effects are computed in doubles. A position at which `auto` leaves all effects out is that of the
!> solver without effects, byte for byte.
module asperity_effect_solver
  use asperity_closing_at_load, only: close_to_load
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_records, only: are_finite, most_rows, scene_results, solve_method
  use asperity_contact_state, only: contact_state
  use asperity_effect_list, only: list_effects
  use asperity_effect_report, only: effect_report, effects_at_position
  use asperity_effect_rows, only: add_state, name_columns
  use asperity_effect_sequence, only: all_left_out, simulate
  use asperity_decimal, only: decimal_to_real64
  use asperity_kernel_real64, only: closings_on_the_way, empty_state, list_pairs, place_scene, &
                                    placed_scene, solve_position
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text
  use asperity_scene_values, only: control_load, scene
  implicit none
  private

  public :: solve_with_effects

contains

  !> Solves every position of a scene. `failure` is allocated, with the position, when one cannot be
  !> solved or an effect does not converge.
  subroutine solve_with_effects(scene_in, keep_rows, results, report, failure)
    type(scene), intent(in) :: scene_in                    !! checked values, an effect not off
    logical, intent(in) :: keep_rows                       !! keep the contacts of every state
    type(scene_results), intent(out) :: results            !! all positions
    type(effect_report), intent(out) :: report             !! what the effects did
    character(len=:), allocatable, intent(out) :: failure  !! why not
    type(placed_scene) :: placed
    type(effect_box), allocatable :: effects(:)
    integer(int64) :: rows
    integer :: m

    call list_effects(scene_in, effects)
    call name_columns(effects, report)
    report%tolerance = decimal_to_real64(scene_in%effects%tolerance)
    call place_scene(scene_in, placed, failure)
    if (allocated(failure)) return
    allocate (results%positions(placed%positions), report%positions(placed%positions))
    rows = 0_int64
    do m = 1, placed%positions
      call solve_one(scene_in, placed, m, effects, keep_rows, results, report, failure)
      if (.not. allocated(failure)) then
        if (.not. are_finite(results%positions(m))) &
          failure = 'a result is beyond the range of a double'
      end if
      rows = rows + int(results%positions(m)%rows_used, int64)
      if (rows > int(most_rows, int64)) &
        failure = 'more than ' // decimal_text(most_rows) // ' contacts to keep: expected ' // &
                  'fewer positions or points, or no list of contacts'
      if (.not. allocated(failure)) cycle
      failure = 'position ' // decimal_text(m) // ': ' // failure
      return
    end do
  end subroutine solve_with_effects

  ! One position: where it ends, and the states on the way.
  subroutine solve_one(scene_in, placed, m, effects, keep_rows, results, report, failure)
    type(scene), intent(in) :: scene_in
    type(placed_scene), intent(in) :: placed
    integer, intent(in) :: m
    type(effect_box), intent(inout) :: effects(:)
    logical, intent(in) :: keep_rows
    type(scene_results), intent(inout) :: results
    type(effect_report), intent(inout) :: report
    character(len=:), allocatable, intent(out) :: failure
    type(contact_pairs) :: pairs
    type(contact_state) :: state
    type(effect_outcome), allocatable :: outcomes(:)
    real(real64), allocatable :: closings(:)
    logical :: nothing_simulated
    integer :: e, i

    call list_pairs(placed, m, .false., pairs, failure)
    if (allocated(failure)) return
    if (scene_in%loading%control == control_load .and. size(pairs%list) > 0) then
      call close_to_load(pairs, effects, failure)
      if (.not. allocated(failure) .and. pairs%closing > pairs%complete_to) then
        call list_pairs(placed, m, .true., pairs, failure)
        if (.not. allocated(failure)) call close_to_load(pairs, effects, failure)
      end if
      if (allocated(failure)) return
    end if
    associate (result => results%positions(m), at => report%positions(m))
      if (size(pairs%list) == 0) then
        allocate (at%outcomes(size(effects)), at%state_values(size(report%state_columns)), &
                  at%contact_values(0, size(report%contact_columns)))
        at%state_values = 0.0_real64
        result%x_displacement = pairs%x_displacement
        result%y_displacement = pairs%y_displacement
        call empty_state(placed, result, failure)
        return
      end if
      call closings_on_the_way(scene_in%loading%points, pairs%list%gap, pairs%closing, closings)
      allocate (result%states(size(closings)), result%rows(0))
      result%x_displacement = pairs%x_displacement
      result%y_displacement = pairs%y_displacement
      nothing_simulated = .true.
      do e = 1, size(effects)
        if (associated(effects(e)%effect%begin)) call effects(e)%effect%begin(pairs)
      end do
      do i = 1, size(closings)
        call simulate(pairs, effects, closings(i), state, outcomes)
        call first_failure(effects, outcomes, failure)
        if (allocated(failure)) return
        nothing_simulated = nothing_simulated .and. all_left_out(outcomes)
        do e = 1, size(effects)
          if (associated(effects(e)%effect%keep)) call effects(e)%effect%keep(pairs, state)
        end do
        call add_state(scene_in, pairs, effects, state, outcomes, i, keep_rows, result, at)
      end do
      if (nothing_simulated) call solve_position(placed, m, solve_method(), keep_rows, result, &
                                                 failure)
    end associate
  end subroutine solve_one

  ! Why the first of the effects that failed could not be simulated.
  subroutine first_failure(effects, outcomes, failure)
    type(effect_box), intent(in) :: effects(:)
    type(effect_outcome), intent(in) :: outcomes(:)
    character(len=:), allocatable, intent(inout) :: failure
    integer :: i

    do i = size(effects), 1, -1
      if (allocated(outcomes(i)%failure)) &
        failure = trim(effects(i)%effect%name) // ': ' // outcomes(i)%failure
    end do
  end subroutine first_failure

end module asperity_effect_solver
