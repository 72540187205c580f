!> The way from a scene to its results: with its effects, in an arithmetic, or to an accuracy.
module asperity_solve
  use asperity_accuracy_bound, only: error_bound, front_arithmetics
  use asperity_accuracy_choice, only: accuracy_had, choose_model, had_text, has_accuracy, &
                                      may_go_on_cells, next_tolerance, tell_way, total_of, &
                                      with_circles
  use asperity_contact_records, only: solve_method, state_row
  use asperity_decimal, only: decimal_to_real64
  use asperity_effect_solver, only: make_effect_solver
  use asperity_height_map, only: height_map
  use asperity_kept_records, only: kept_work
  use asperity_kinds, only: not_computed, real64
  use asperity_map_check, only: a_little_more, hold_against_map, map_seen, see_map, &
                                stiffness_between
  use asperity_map_press_solver, only: make_map_solver, name_map_columns
  use asperity_map_scene, only: area_of_map, join_maps, load_the_map, map_loading, summits_of_scene
  use asperity_map_shares, only: warn_of_shares
  use asperity_map_summits, only: map_summits
  use asperity_arithmetics, only: solver_in
  use asperity_position_solver, only: position_solver
  use asperity_run_options, only: run_options
  use asperity_scene_inputs, only: input_file, list_inputs
  use asperity_scene_results, only: last_state, scene_results
  use asperity_scene_values, only: combined_modulus, control_approach, control_limit, effect_auto, &
                                   effect_boundary, effect_off, scene
  use asperity_sweep, only: run_sweep
  use asperity_theory_warnings, only: take_worse, theory_warning
  use asperity_version, only: version
  implicit none
  private

  public :: solve, solve_in_arithmetic

contains

  !> Solves every position of a scene. `failure` is allocated, with the position, when one cannot be
  !> solved, or when what is asked for cannot be had.
  recursive subroutine solve(scene_in, results, failure, options)
    type(scene), intent(in) :: scene_in                    !! checked values
    type(scene_results), intent(out) :: results            !! all positions
    character(len=:), allocatable, intent(out) :: failure  !! why not
    type(run_options), intent(in), optional :: options     !! absent: those of `run_options()`
    type(run_options) :: chosen

    if (present(options)) chosen = options
    if (chosen%accuracy > 0 .and. (needs_doubles(scene_in) .or. allocated(scene_in%map))) then
      call solve_model_to_accuracy(scene_in, chosen, results, failure)
    else if (allocated(scene_in%map)) then
      call solve_map(scene_in, chosen, results, failure)
    else
      call solve_surfaces(scene_in, chosen, results, failure)
    end if
    if (.not. results%nominal_area > 0.0_real64) &
      results%nominal_area = decimal_to_real64(scene_in%nominal_area)
  end subroutine solve

  ! Two surfaces of summits, or one and a plane.
  subroutine solve_surfaces(scene_in, chosen, results, failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: chosen
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure

    if (needs_doubles(scene_in)) then
      call solve_effects(scene_in, chosen, results, failure)
    else if (chosen%accuracy > 0) then
      call solve_to_accuracy(scene_in, chosen, results, failure)
    else
      call solve_in_arithmetic(scene_in, solve_method(), chosen, results, failure)
    end if
  end subroutine solve_surfaces

  ! A map: its summits, held against the map itself, or the samples of the map.
  subroutine solve_map(scene_in, options, results, failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure
    type(height_map), target :: map
    type(map_loading) :: loading
    type(map_seen) :: seen
    type(map_summits) :: summits
    type(scene) :: plain
    type(scene_results) :: of_summits
    type(run_options) :: of_summits_options
    integer :: mode

    call join_maps(scene_in, map, failure)
    if (allocated(failure)) return
    mode = scene_in%effects%mode('interaction')
    results%nominal_area = decimal_to_real64(scene_in%nominal_area)
    if (.not. results%nominal_area > 0.0_real64) results%nominal_area = area_of_map(map)
    if (mode == effect_boundary) then
      call solve_samples(scene_in, map, options, results, failure)
      return
    end if
    if (scene_in%loading%control == control_limit) then
      loading%values = [0.0_real64]
    else
      call load_the_map(scene_in, map, loading, failure)
      if (allocated(failure)) return
    end if
    call see_map(map, scene_in%map%periodic, loading, seen, failure)
    if (allocated(failure) .and. mode == effect_auto) then
      call solve_samples(scene_in, map, options, results, failure)
      return
    end if
    if (allocated(failure) .and. mode /= effect_off) return
    call summits_of_scene(scene_in, map, plain, summits, failure)
    if (allocated(failure)) return
    ! What is kept is the answer: of `auto` that is not known yet.
    of_summits_options = options
    if (mode == effect_auto .and. allocated(options%keep_file)) &
      deallocate (of_summits_options%keep_file)
    call solve_surfaces(plain, of_summits_options, of_summits, failure)
    if (allocated(failure)) return
    call check_summits(scene_in, plain, map, seen, summits, of_summits, failure)
    if (allocated(failure)) return
    of_summits%nominal_area = results%nominal_area
    if (mode == effect_auto .and. .not. is_good_enough(scene_in, of_summits)) then
      results%map = of_summits%map
      call solve_samples(scene_in, map, options, results, failure)
      if (allocated(failure)) failure = 'its summits are not good enough, and its samples: ' // &
                                        failure
    else
      results = of_summits
    end if
  end subroutine solve_map

  ! The samples of a map themselves.
  subroutine solve_samples(scene_in, map, options, results, failure)
    type(scene), intent(in) :: scene_in
    type(height_map), intent(in), target :: map
    type(run_options), intent(in) :: options
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure
    class(position_solver), allocatable :: solver
    type(map_loading) :: loading

    results%arithmetic = 'real64'
    call load_the_map(scene_in, map, loading, failure)
    if (allocated(failure)) return
    call make_map_solver(map, scene_in%map%periodic, loading, &
                         scene_in%effects%number('tolerance'), solver)
    allocate (results%effects)
    call name_map_columns(scene_in%effects%mode('interaction'), results%effects)
    results%effects%tolerance = scene_in%effects%number('tolerance')
    call sweep(scene_in, options, solver, results, failure)
  end subroutine solve_samples

  ! What the summits cost, from the map itself: told with the results.
  subroutine check_summits(scene_in, plain, map, seen, summits, results, failure)
    type(scene), intent(in) :: scene_in, plain
    type(height_map), intent(in) :: map
    type(map_seen), intent(inout) :: seen
    type(map_summits), intent(in) :: summits
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure
    type(scene_results) :: more
    type(scene) :: other
    type(state_row) :: last
    type(theory_warning), allocatable :: warnings(:)
    real(real64) :: stiffness
    character(len=:), allocatable :: why

    last = last_state(results%positions(1))
    if (.not. last%vertical_load > 0.0_real64) then
      ! At a level where no summit touches all that the map bears is missing.
      results%positions(1)%error_estimate = merge(1.0_real64, 0.0_real64, &
                                                  seen%answer%load > 0.0_real64)
      return
    end if
    ! The stiffness of the summits takes a second state, worth it where the map's is known. None:
    ! it is not told.
    stiffness = not_computed
    if (seen%coarser == 1) then
      other = plain
      other%loading = a_little_more(last)
      call solve_surfaces(other, run_options(), more, why)
      if (.not. allocated(why)) stiffness = stiffness_between(last, last_state(more%positions(1)))
    end if
    allocate (results%map)
    call hold_against_map(map, seen, combined_modulus(scene_in), summits, last, stiffness, &
                          results%map, failure)
    if (allocated(failure)) return
    call warn_of_shares(results%map%shares, scene_in%effects%number('tolerance'), warnings)
    call take_worse(results%positions(1)%warnings, warnings, size(results%positions(1)%states))
    if (scene_in%loading%control == control_approach) then
      results%positions(1)%error_estimate = abs(results%map%load_difference) + &
                                            results%map%load_uncertain
    else
      results%positions(1)%error_estimate = &
        (abs(results%map%difference) + results%map%uncertain) * results%map%rms_height / &
        results%map%closing
    end if
  end subroutine check_summits

  ! Whether `auto` is content with summits: within its tolerance, area included.
  logical function is_good_enough(scene_in, results)
    type(scene), intent(in) :: scene_in
    type(scene_results), intent(in) :: results
    real(real64) :: tolerance

    tolerance = scene_in%effects%number('tolerance')
    is_good_enough = results%positions(1)%error_estimate <= tolerance
    if (is_good_enough .and. allocated(results%map)) is_good_enough = &
      results%map%coarser == 1 .and. abs(results%map%area_difference) <= tolerance
  end function is_good_enough

  !> Solves every position without effects, in the arithmetic of the options, by a method: the
  !> solver proper is `solve_method()`, the others serve the accuracy study.
  subroutine solve_in_arithmetic(scene_in, method, options, results, failure)
    type(scene), intent(in) :: scene_in                    !! checked values
    type(solve_method), intent(in) :: method               !! how to compute
    type(run_options), intent(in) :: options               !! its arithmetic, and how
    type(scene_results), intent(out) :: results            !! all positions
    character(len=:), allocatable, intent(out) :: failure  !! why not
    class(position_solver), allocatable :: solver

    results%arithmetic = options%arithmetic
    call solver_in(trim(options%arithmetic), scene_in, method, solver, failure)
    if (.not. allocated(failure)) call sweep(scene_in, options, solver, results, failure)
  end subroutine solve_in_arithmetic

  ! With the effects of the scene, in doubles.
  subroutine solve_effects(scene_in, options, results, failure)
    type(scene), intent(in), target :: scene_in
    type(run_options), intent(in) :: options
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure
    class(position_solver), allocatable :: solver

    if (options%arithmetic /= 'real64') then
      failure = 'effects and paths of several values are computed in real64 only'
      return
    end if
    results%arithmetic = options%arithmetic
    allocate (results%effects)
    call make_effect_solver(scene_in, solver, results%effects, failure)
    if (.not. allocated(failure)) call sweep(scene_in, options, solver, results, failure)
  end subroutine solve_effects

  ! In the cheapest arithmetic whose error bound is within the accuracy asked for.
  subroutine solve_to_accuracy(scene_in, options, results, failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure
    type(run_options) :: way
    character(len=10) :: digits
    integer :: i

    way = options
    do i = 1, size(front_arithmetics)
      way%arithmetic = front_arithmetics(i)
      call solve_in_arithmetic(scene_in, solve_method(), way, results, failure)
      if (allocated(failure)) return
      results%error_bound = error_bound(trim(way%arithmetic), scene_in, results%positions)
      if (results%error_bound <= options%accuracy) then
        results%way_taken = trim(way%arithmetic) // ', exact events'
        results%way_told = 'ten times better: this run has it'
        if (results%error_bound > 0.1_real64 * options%accuracy) &
          results%way_told = 'ten times better: ' // trim(merge( &
            'real128, up to 40 times the time', 'cannot be had                   ', i == 1))
        results%way_told = results%way_told // '; contacts each alone, as the scene asks'
        return
      end if
    end do
    write (digits, '(es10.1e3)') results%error_bound
    failure = 'no way of computing has this accuracy; the best one, ' // trim(way%arithmetic) // &
              ', is good to' // digits
  end subroutine solve_to_accuracy

  ! With the effects of the scene so that what they leave out or approximate is within the accuracy
  ! asked for, by estimate before and check after. A tolerance of the half leaves room for the rest.
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
    tolerance = options%accuracy
    on_cells = .false.
    do while (tolerance > 0.0_real64)
      call choose_model(scene_in, 0.5_real64 * tolerance, on_cells, chosen)
      call solve(chosen, results, unsolved, way)
      if (allocated(unsolved)) exit
      had = has_accuracy(chosen, results)
      results%error_bound = total_of(had)
      if (results%error_bound <= options%accuracy) then
        call tell_way(chosen, options%accuracy, results)
        return
      end if
      best = had_text(had)
      if (.not. on_cells) then
        on_cells = may_go_on_cells(scene_in, options%accuracy)
        if (on_cells) cycle
      end if
      tolerance = next_tolerance(had, options%accuracy, tolerance)
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
    failure = 'no way of computing has this accuracy; the best one has ' // best
    if (scene_in%effects%mode('interaction') /= effect_off .and. .not. allocated(unsolved)) &
      failure = failure // '; for loads alone set tolerance and interaction = ''auto'''
    if (allocated(unsolved)) failure = failure // ' (' // unsolved // ')'
  end subroutine solve_model_to_accuracy

  ! The sweep, with the file in which its positions are kept.
  subroutine sweep(scene_in, options, solver, results, failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    class(position_solver), intent(inout) :: solver
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure
    type(kept_work) :: kept

    solver%interrupt = options%interrupt
    call name_work(scene_in, options, kept, failure)
    if (allocated(failure)) return
    if (results%begun < 0.0_real64) call cpu_time(results%begun)
    call run_sweep(solver, options, kept, results%positions, failure)
  end subroutine sweep

  ! What a file of kept positions is for: all files that the scene is made of, and what else the
  ! results depend on. Every image reads them: what fails on one fails on all, and nobody waits.
  subroutine name_work(scene_in, options, kept, failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(kept_work), intent(out) :: kept
    character(len=:), allocatable, intent(out) :: failure
    type(input_file) :: inputs(3)
    integer :: i

    kept%path = ''
    if (allocated(options%keep_file)) kept%path = options%keep_file
    if (kept%path == '') return
    kept%piece = 'position'
    kept%part = options%part
    kept%parts = options%parts
    if (allocated(options%more_files)) kept%more = options%more_files
    kept%of_what = 'this scene, arithmetic and list of contacts'
    call list_inputs(scene_in, inputs, failure)
    kept%heading = 'asperity ' // version // ' solve, ' // trim(options%arithmetic) // &
                   ', contacts ' // trim(merge('kept  ', 'summed', options%keep_contacts)) // &
                   ', input'
    do i = 1, size(inputs)
      kept%heading = kept%heading // ' ' // inputs(i)%checksum
    end do
  end subroutine name_work

  ! Effects and paths of several values are computed in doubles only.
  pure logical function needs_doubles(scene_in)
    type(scene), intent(in) :: scene_in

    needs_doubles = scene_in%effects%any_on() .or. allocated(scene_in%loading%path)
  end function needs_doubles

end module asperity_solve
