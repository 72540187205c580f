!> Solves a scene with its effects: the contacts of every position, then the effects called for.
!>
!> Effects are computed in doubles. A position at which `auto` leaves all effects out is that of the
!> solver without effects, byte for byte. Positions are shared out to threads.
module asperity_effect_solver
  use asperity_contact_effect, only: effect_box
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_records, only: are_finite, scene_results, solve_method
  use asperity_decimal, only: decimal_to_real64
  use asperity_effect_list, only: list_effects
  use asperity_effect_packet, only: pack_effects, unpack_effects
  use asperity_effect_position, only: run_position
  use asperity_effect_report, only: effect_report
  use asperity_effect_rows, only: name_columns
  use asperity_kernel_real64, only: empty_state, list_pairs, place_scene, placed_scene, &
                                    solve_position
  use asperity_kinds, only: int64, real64
  use asperity_plastic_surface, only: surface_index
  use asperity_position_loop, only: added_numbers, another_round, are_packed, begin_positions, &
                                    end_positions, first_of_round, is_wanted, last_of_round, &
                                    position_done, position_watch, threads_for
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: solve_with_effects

contains

  !> Solves every position of a scene. `failure` is allocated, with the position, when one cannot be
  !> solved or an effect does not converge.
  subroutine solve_with_effects(scene_in, keep_rows, results, report, failure)
    type(scene), intent(in) :: scene_in                    !! checked values
    logical, intent(in) :: keep_rows                       !! keep the contacts of every state
    type(scene_results), intent(out) :: results            !! all positions
    type(effect_report), intent(out) :: report             !! what the effects did
    character(len=:), allocatable, intent(out) :: failure  !! why not
    type(placed_scene) :: placed
    type(effect_box), allocatable :: effects(:)
    type(position_watch) :: watch
    integer :: threads, m

    call list_effects(scene_in, effects)
    call name_columns(effects, report)
    report%tolerance = decimal_to_real64(scene_in%effects%tolerance)
    if (any(report%names == 'plasticity')) report%plasticity_index = surface_index(scene_in)
    call place_scene(scene_in, placed, failure)
    if (allocated(failure)) return
    allocate (results%positions(placed%positions), report%positions(placed%positions))
    ! Effects take long: a few positions are worth a thread each.
    threads = threads_for(placed%positions, huge(1_int64))
    call begin_positions(watch, placed%positions)
    do while (another_round(watch, results%positions))
      !$omp parallel num_threads(threads) if(threads > 1)
      call solve_share(scene_in, placed, keep_rows, results, report, watch)
      !$omp end parallel
    end do
    call end_positions(watch, results%positions, failure)
    if (allocated(failure) .or. .not. are_packed(watch)) return
    do m = 1, placed%positions
      call unpack_effects(added_numbers(watch, m), report%positions(m))
    end do
  end subroutine solve_with_effects

  ! The positions of one thread, which has effects of its own: they remember.
  subroutine solve_share(scene_in, placed, keep_rows, results, report, watch)
    type(scene), intent(in) :: scene_in
    type(placed_scene), intent(in) :: placed
    logical, intent(in) :: keep_rows
    type(scene_results), intent(inout) :: results
    type(effect_report), intent(inout) :: report
    type(position_watch), intent(inout) :: watch
    type(effect_box), allocatable :: effects(:)
    character(len=:), allocatable :: failure
    real(real64), allocatable :: numbers(:)
    integer :: m

    allocate (effects(0))
    call list_effects(scene_in, effects)
    !$omp do schedule(dynamic)
    do m = first_of_round(watch), last_of_round(watch)
      if (.not. is_wanted(watch, m)) cycle
      call solve_one(scene_in, placed, m, effects, keep_rows, results, report, failure)
      if (.not. allocated(failure)) then
        if (.not. are_finite(results%positions(m))) &
          failure = 'a result is beyond the range of a double'
      end if
      if (are_packed(watch) .and. .not. allocated(failure)) then
        call pack_effects(report%positions(m), numbers)
        call position_done(watch, m, results%positions(m), failure, numbers)
      else
        call position_done(watch, m, results%positions(m), failure)
      end if
    end do
    !$omp end do
  end subroutine solve_share

  ! One position: its pairs, its states, or the solver without effects where none was called for.
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
    logical :: simulated, too_far

    associate (result => results%positions(m), at => report%positions(m))
      call list_pairs(placed, m, .false., pairs, failure)
      if (allocated(failure)) return
      if (size(pairs%list) > 0) then
        call run_position(scene_in, pairs, effects, keep_rows, result, at, simulated, too_far, &
                          failure)
        if (too_far) then
          ! Pairs outside the candidate distance can matter: take all that can touch at all.
          call list_pairs(placed, m, .true., pairs, failure)
          if (.not. allocated(failure)) &
            call run_position(scene_in, pairs, effects, keep_rows, result, at, simulated, &
                              too_far, failure)
        end if
        if (allocated(failure) .or. simulated) return
        call solve_position(placed, m, solve_method(), keep_rows, result, failure)
      else
        allocate (at%outcomes(size(effects)), at%state_values(size(report%state_columns)), &
                  at%contact_values(0, size(report%contact_columns)))
        at%state_values = 0.0_real64
        result%x_displacement = pairs%x_displacement
        result%y_displacement = pairs%y_displacement
        call empty_state(placed, result, failure)
      end if
    end associate
  end subroutine solve_one

end module asperity_effect_solver
