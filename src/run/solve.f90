!> Solution of a scene, with its own settings or to a requested accuracy.
module asperity_solve
  use asperity_accuracy_choice, only: add_possible_accuracy, check_accuracy, check_left_out, &
                                      choose_model, errors_of_run, first_tolerance, &
                                      next_tolerance, report_method, &
                                      run_errors, total_error
  use asperity_effect_names, only: of_interaction
  use asperity_height_map, only: height_map
  use asperity_kinds, only: int64, real64
  use asperity_map_contact, only: room_to_solve
  use asperity_map_solve, only: solve_map
  use asperity_numeral, only: rounded_decimal
  use asperity_problems, only: not_enough_memory, problem_list
  use asperity_process, only: has_memory
  use asperity_run_options, only: check_options, run_options
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: by_default, by_word, effect_boundary, effect_coupled, &
                                   effect_off, scene, scene_effects
  use asperity_surface_fields, only: solve_with_fields
  use asperity_surface_solve, only: has_effects
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
    if (allocated(scene_in%map)) then
      if (.not. has_memory(max(room_of(scene_in%map%upper, scene_in%effects), &
                               room_of(scene_in%map%lower, scene_in%effects)))) then
        failure = not_enough_memory // ' for the pixels of the map'
        return
      end if
    end if
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
    ! A single position, or a map, may use all threads.
    !$ usual = omp_get_max_threads()
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

  ! Solves a scene with its effects so that the estimated errors are within the requested accuracy.
  ! Hertzian contacts come first: they are fast, and a part of any solution on boundary elements.
  ! The first tolerance is half of the accuracy; the rest is for other errors.
  recursive subroutine solve_model_to_accuracy(scene_in, options, results, failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure
    type(run_options) :: method_options
    type(scene) :: chosen
    type(run_errors) :: errors, least
    real(real64) :: tolerance
    character(len=:), allocatable :: unsolved
    logical :: on_elements

    method_options = options
    method_options%accuracy = 0.0_real64
    tolerance = 0.5_real64 * options%accuracy
    on_elements = .false.
    least%load = huge(tolerance)
    do while (tolerance > 0.0_real64)
      call choose_model(scene_in, tolerance, options%accuracy_of, on_elements, chosen)
      call solve(chosen, results, unsolved, method_options)
      if (.not. results%are_solved) exit
      call check_left_out(chosen, options%accuracy, results, failure)
      if (allocated(failure)) return
      errors = errors_of_run(chosen, on_elements, results)
      results%error_bound = total_error(errors, options%accuracy_of)
      if (results%error_bound <= options%accuracy) then
        call report_method(chosen, options%accuracy, results)
        return
      end if
      if (results%error_bound < total_error(least, options%accuracy_of)) least = errors
      if (on_elements) then
        tolerance = next_tolerance(errors, options%accuracy, options%accuracy_of, tolerance)
      else
        ! Boundary elements are a method with interaction.
        on_elements = scene_in%effects%modes(of_interaction) /= effect_off .and. &
                      .not. allocated(scene_in%map)
        if (.not. on_elements) exit
        tolerance = first_tolerance(options%accuracy, options%accuracy_of)
      end if
    end do
    if (.not. least%load < huge(tolerance)) then
      ! A scene that cannot be solved at all fails with its own reason.
      chosen = scene_in
      if (chosen%effects%modes(of_interaction) /= effect_off) then
        chosen%effects%modes(of_interaction) = effect_coupled
        call solve(chosen, results, failure, method_options)
      end if
      if (.not. results%are_solved) then
        call move_alloc(unsolved, failure)
        return
      end if
      least = errors_of_run(chosen, .false., results)
    end if
    failure = 'no method has this accuracy; '
    call add_possible_accuracy(least, chosen%effects%modes(of_interaction) == effect_boundary, &
                               options%accuracy, options%accuracy_of, failure)
    if (allocated(unsolved)) failure = failure // ' (' // unsolved // ')'
  end subroutine solve_model_to_accuracy

end module asperity_solve
