!> Solution of a scene, with its own settings or to a requested accuracy.
module asperity_solve
  use asperity_accuracy_choice, only: check_accuracy, check_left_out, choose_model, &
                                      compare_pixels, errors_of_run, first_method, method_choice, &
                                      proposed_accuracy, report_errors, report_method, take_next
  use asperity_height_map, only: height_map
  use asperity_kinds, only: int64, real64
  use asperity_map_contact, only: room_to_solve
  use asperity_model_solve, only: has_effects, solve_map
  use asperity_numeral, only: rounded_decimal
  use asperity_problems, only: problem_list
  use asperity_process, only: bytes_of_thread, check_memory, is_given
  use asperity_run_options, only: check_options, run_options, totals_of_accuracy
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: by_default, by_word, effect_off, scene, scene_effects
  use asperity_surface_fields, only: solve_with_fields
  !$ use omp_lib, only: omp_get_max_threads, omp_set_num_threads
  implicit none
  private

  public :: solve

contains

  !> Solves every position of a scene. `failure` is allocated, with the position, when one cannot be
  !> solved, or when the requested accuracy cannot be reached.
  recursive subroutine solve(scene_in, results, failure, options)
    type(scene), intent(in) :: scene_in                    !! scene, checked for faults
    type(scene_results), intent(out) :: results            !! results of all positions
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is not solved
    type(run_options), intent(in), optional :: options     !! options; absent: the defaults
    type(run_options) :: chosen
    type(problem_list) :: problems
    type(scene) :: written
    integer(int64) :: room
    !$ integer :: usual

    if (.not. scene_in%is_checked) then
      failure = 'the scene was not read or built without problems'
      return
    end if
    if (present(options)) chosen = options
    call check_options(chosen, problems)
    if (problems%count() > 0) then
      call problems%write_text(failure)
      failure = failure(:len(failure) - 1)
      return
    end if
    if (chosen%accuracy > 0 .and. chosen%accuracy_of == 'pressure' .and. &
        .not. allocated(scene_in%map)) then
      failure = 'the error of the greatest pressure is estimated on the pixels of a map: ' // &
                'expected one, or --of load or --of area'
      return
    end if
    room = 0_int64
    if (allocated(scene_in%map)) room = max(room_of(scene_in%map%upper, scene_in%effects), &
                                            room_of(scene_in%map%lower, scene_in%effects))
    call check_memory('the pixels of the map', failure, bytes=room)
    if (allocated(failure)) return
    ! An accuracy may be reached without interaction, where the scene does not set it.
    associate (on => scene_in%effects%modes /= effect_off, given => scene_in%effects%given)
      if (any(on .and. given < by_word) .and. chosen%accuracy > 0 .and. &
          all(given == by_default .or. .not. on) .and. &
          .not. (allocated(scene_in%map) .or. allocated(scene_in%loading%path))) then
        written = scene_in
        where (written%effects%given < by_word) written%effects%modes = effect_off
        call written%effects%set('tolerance', rounded_decimal(chosen%accuracy, 3))
        call solve(written, results, failure, chosen)
        if (results%are_solved) return
        deallocate (failure)
      end if
    end associate
    ! A single position, or a map, may use all threads. The run-time library ends the process where
    ! it cannot start one.
    !$ usual = omp_get_max_threads()
    !$ if (.not. is_given(room + bytes_of_thread * (max(usual, chosen%threads) - 1))) &
    !$   chosen%threads = 1
    !$ if (chosen%threads > 0) call omp_set_num_threads(chosen%threads)
    if (chosen%accuracy > 0 .and. (has_effects(scene_in) .or. allocated(scene_in%map))) then
      call solve_model_to_accuracy(scene_in, chosen, results, failure)
    else if (allocated(scene_in%map)) then
      call solve_map(scene_in, chosen, results, failure)
    else
      call solve_with_fields(scene_in, chosen, results, failure)
      if (chosen%accuracy > 0 .and. .not. allocated(failure)) &
        call check_accuracy(scene_in, chosen%accuracy, results, failure)
    end if
    !$ call omp_set_num_threads(usual)
    if (allocated(failure)) results = scene_results()
    results%are_solved = .not. allocated(failure)
    if (.not. results%nominal_area > 0.0_real64) results%nominal_area = scene_in%nominal_area
  end subroutine solve

  ! Memory of a solve of a map, bytes; 0 where there is none.
  pure integer(int64) function room_of(map, effects) result(bytes)
    type(height_map), intent(in) :: map
    type(scene_effects), intent(in) :: effects
    integer :: relaxations

    bytes = 0_int64
    relaxations = merge(1, 0, effects%mode('creep') /= effect_off)
    if (allocated(effects%relaxation)) relaxations = relaxations * size(effects%relaxation, 1)
    if (map%columns > 0) bytes = room_to_solve(map, relaxations)
  end function room_of

  ! Solves a scene with its effects to the requested accuracy. A refusal proposes one that is met:
  ! other tolerances and pixels are tried for it, which may all have larger errors than the best of
  ! those for a smaller accuracy, so that the methods are tried for each proposal.
  recursive subroutine solve_model_to_accuracy(scene_in, options, results, failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure
    type(run_options) :: wanted
    type(method_choice) :: method
    real(real64), dimension(size(totals_of_accuracy)) :: errors, least
    character(len=:), allocatable :: unsolved, reason
    integer :: total

    total = findloc(totals_of_accuracy == options%accuracy_of, .true., 1)
    wanted = options
    call try_methods(scene_in, wanted, total, results, least, method, unsolved, failure)
    if (allocated(failure) .or. least(total) <= options%accuracy) return
    if (.not. any(least < huge(least))) then
      ! A scene that cannot be solved at all fails with its own reason.
      call move_alloc(unsolved, failure)
      return
    end if
    errors = least
    do
      wanted%accuracy = proposed_accuracy(errors(total))
      if (.not. wanted%accuracy < 1.0_real64) exit
      call try_methods(scene_in, wanted, total, results, errors, method, reason, failure)
      if (allocated(failure) .or. errors(total) <= wanted%accuracy) exit
    end do
    failure = 'no method has this accuracy; '
    call report_errors(least, allocated(scene_in%map) .and. method%finest <= 1.0_real64, &
                       options%accuracy, options%accuracy_of, wanted%accuracy, failure)
    if (allocated(unsolved)) failure = failure // ' (' // unsolved // ')'
  end subroutine solve_model_to_accuracy

  ! Tries methods until the estimated error is within the requested accuracy. Hertzian contacts are
  ! a part of any solution on boundary elements, and coarser pixels take a third of the time of the
  ! next.
  recursive subroutine try_methods(scene_in, options, total, results, least, method, unsolved, &
                                   failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    integer, intent(in) :: total                    ! of `totals_of_accuracy`
    type(scene_results), intent(inout) :: results
    real(real64), intent(out) :: least(:)           ! errors of the most accurate method
    type(method_choice), intent(out) :: method      ! the last one
    character(len=:), allocatable, intent(out) :: unsolved  ! why that is not solved
    character(len=:), allocatable, intent(out) :: failure   ! an effect has to be turned on
    type(run_options) :: method_options
    type(scene) :: chosen
    real(real64) :: errors(size(least))

    method_options = options
    method_options%accuracy = 0.0_real64
    if (options%accuracy_of == 'load') method_options%largest_error = options%accuracy
    method = first_method(scene_in, options)
    least = huge(least)
    do while (method%tolerance > 0.0_real64)
      call choose_model(scene_in, method, options%accuracy_of, chosen, unsolved)
      if (.not. allocated(unsolved)) call solve(chosen, results, unsolved, method_options)
      errors = huge(errors)
      if (.not. allocated(unsolved)) then
        call check_left_out(chosen, options%accuracy, results, failure)
        if (allocated(failure)) return
        errors = errors_of_run(chosen, results)
        if (allocated(scene_in%map)) call compare_pixels( &
          scene_in, results, options%accuracy, method, errors(1))
        results%error_bound = errors(total)
        if (errors(total) < least(total)) least = errors
        if (errors(total) <= options%accuracy) then
          call report_method(chosen, method, results)
          return
        end if
      else if (.not. method%resolution < 1.0_real64) then
        return
      end if
      call take_next(scene_in, options, results, errors(total), method)
    end do
  end subroutine try_methods

end module asperity_solve
