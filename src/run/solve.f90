!> The way from a scene to its results, as it asks or to an accuracy.
module asperity_solve
  use asperity_accuracy_choice, only: accuracy_had, check_left_out, choose_model, &
                                      first_tolerance, had_text, has_accuracy, may_go_on_cells, &
                                      next_tolerance, tell_way, total_of, with_circles
  use asperity_decimal, only: decimal_to_real64
  use asperity_kinds, only: real64
  use asperity_map_solve, only: solve_map
  use asperity_numeral, only: rounded_decimal
  use asperity_problems, only: problem_list
  use asperity_run_options, only: check_options, run_options
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: by_default, by_word, effect_off, scene
  use asperity_surface_fields, only: solve_with_fields
  use asperity_surface_solve, only: needs_doubles
  !$ use omp_lib, only: omp_get_max_threads, omp_set_num_threads
  implicit none
  private

  public :: solve

contains

  !> Solves every position of a scene. `failure` is allocated, with the position, when one cannot be
  !> solved, or when what is asked for cannot be had.
  recursive subroutine solve(scene_in, results, failure, options)
    type(scene), intent(in) :: scene_in                    !! checked values
    type(scene_results), intent(out) :: results            !! all positions
    character(len=:), allocatable, intent(out) :: failure  !! why not
    type(run_options), intent(in), optional :: options     !! absent: those of `run_options()`
    type(run_options) :: chosen
    type(problem_list) :: problems
    type(scene) :: written
    !$ integer :: usual

    if (present(options)) chosen = options
    call check_options(chosen, problems)
    if (problems%count() > 0) then
      failure = problems%text()
      failure = failure(:len(failure) - 1)
      return
    end if
    ! Effects are computed in doubles: another arithmetic leaves out those that are not written.
    ! An accuracy may be had without interaction, where the scene does not write it.
    associate (on => scene_in%effects%modes /= effect_off, given => scene_in%effects%given)
      if (any(on .and. given < by_word) .and. &
          (chosen%arithmetic /= 'real64' .or. &
           (chosen%accuracy > 0 .and. all(given == by_default .or. .not. on) .and. &
            .not. (allocated(scene_in%map) .or. allocated(scene_in%loading%path))))) then
        written = scene_in
        call written%effects%drop_unwritten()
        if (chosen%accuracy > 0) &
          call written%effects%set('tolerance', rounded_decimal(chosen%accuracy, 3))
        call solve(written, results, failure, chosen)
        if (.not. (allocated(failure) .and. chosen%accuracy > 0)) return
        deallocate (failure)
        results = scene_results()
      end if
    end associate
    ! A position by itself, or a map, may use the threads within.
    !$ usual = omp_get_max_threads()
    !$ if (chosen%threads > 0) call omp_set_num_threads(chosen%threads)
    if (chosen%accuracy > 0 .and. (needs_doubles(scene_in) .or. allocated(scene_in%map))) then
      call solve_model_to_accuracy(scene_in, chosen, results, failure)
    else if (allocated(scene_in%map)) then
      call solve_map(scene_in, chosen, results, failure)
    else
      call solve_with_fields(scene_in, chosen, results, failure)
    end if
    !$ call omp_set_num_threads(usual)
    if (.not. results%nominal_area > 0.0_real64) &
      results%nominal_area = decimal_to_real64(scene_in%nominal_area)
  end subroutine solve

  ! With the effects of the scene so that what they leave out or approximate is within the accuracy
  ! asked for, by estimate before and check after. Circles come first: they are cheap beside cells,
  ! and a part of any solve on cells. A tolerance of the half leaves room for the rest.
  recursive subroutine solve_model_to_accuracy(scene_in, options, results, failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure
    type(run_options) :: way
    type(scene) :: chosen
    type(accuracy_had) :: had
    real(real64) :: tolerance
    character(len=:), allocatable :: best, unsolved
    logical :: on_cells

    way = options
    way%accuracy = 0.0_real64
    tolerance = 0.5_real64 * options%accuracy
    on_cells = .false.
    do while (tolerance > 0.0_real64)
      call choose_model(scene_in, tolerance, on_cells, chosen)
      call solve(chosen, results, unsolved, way)
      if (allocated(unsolved)) exit
      call check_left_out(chosen, options%accuracy, results, failure)
      if (allocated(failure)) return
      had = has_accuracy(chosen, results)
      results%error_bound = total_of(had)
      if (results%error_bound <= options%accuracy) then
        call tell_way(chosen, options%accuracy, results)
        return
      end if
      best = had_text(had)
      if (on_cells) then
        tolerance = next_tolerance(had, options%accuracy, tolerance)
      else
        on_cells = may_go_on_cells(scene_in, options%accuracy)
        if (.not. on_cells) exit
        tolerance = first_tolerance(options%accuracy)
      end if
    end do
    if (.not. allocated(best)) then
      ! What cannot be solved at all has nothing to do with the accuracy.
      call with_circles(scene_in, chosen)
      if (chosen%effects%mode('interaction') /= effect_off) &
        call solve(chosen, results, failure, way)
      if (allocated(failure) .or. .not. allocated(results%positions)) then
        call move_alloc(unsolved, failure)
        return
      end if
      best = had_text(has_accuracy(chosen, results)) // ' with interaction = ''coupled'''
    end if
    failure = 'no method has this accuracy; the most accurate one has ' // best
    if (scene_in%effects%mode('interaction') /= effect_off .and. .not. allocated(unsolved)) &
      failure = failure // '; where only loads are needed set tolerance and interaction = ''auto'''
    if (allocated(unsolved)) failure = failure // ' (' // unsolved // ')'
  end subroutine solve_model_to_accuracy

end module asperity_solve
