!> Solution of a map: by its summits, compared with the map, or on its pixels.
module asperity_map_solve
  use asperity_contact_records, only: position_result, state_row
  use asperity_decimal, only: decimal_to_real64
  use asperity_effect_names, only: known_effects
  use asperity_effect_rows, only: of_compression
  use asperity_height_map, only: height_map
  use asperity_kinds, only: not_computed, real64
  use asperity_map_check, only: compare_with_map, increased_load, map_reference, &
                                solve_reference, stiffness_between
  use asperity_map_press_solver, only: make_map_solver, name_map_columns
  use asperity_map_scene, only: area_of_map, join_maps, list_map_loads, map_loading, &
                                summits_of_scene
  use asperity_map_shares, only: warn_of_map, warn_of_shares
  use asperity_map_summits, only: map_summits
  use asperity_position_solver, only: position_solver
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: last_state, scene_results
  use asperity_scene_values, only: combined_modulus, control_limit, effect_auto, effect_off, &
                                   is_load, may_choose_pixels, scene, solves_pixels
  use asperity_surface_fields, only: has_field_grid, solve_with_fields
  use asperity_surface_solve, only: solve_surfaces
  use asperity_sweep, only: sweep_scene
  use asperity_theory_warnings, only: of_barred, of_cap, of_error, of_excluded, of_off, &
                                      of_together, take_worse, theory_warning, add_warning
  implicit none
  private

  public :: solve_map

contains

  !> Solves a map by its summits, which are compared with the map, or on its pixels.
  subroutine solve_map(scene_in, options, results, failure)
    type(scene), intent(in) :: scene_in                    !! scene with a map, checked
    type(run_options), intent(in) :: options               !! options of the run
    type(scene_results), intent(inout) :: results          !! results of the one position
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is not solved
    type(height_map), target :: map
    type(map_loading) :: loading
    type(map_reference) :: reference
    type(map_summits) :: summits
    type(scene) :: plain
    type(scene_results) :: of_summits
    type(run_options) :: of_summits_options
    integer :: mode
    logical :: by_summits

    call join_maps(scene_in, map, failure)
    if (allocated(failure)) return
    mode = scene_in%effects%mode('interaction')
    results%nominal_area = decimal_to_real64(scene_in%nominal_area)
    if (.not. results%nominal_area > 0.0_real64) results%nominal_area = area_of_map(map)
    by_summits = .not. may_choose_pixels(scene_in)
    if (solves_pixels(scene_in) .or. &
        (options%needs_fields .and. .not. (by_summits .or. has_field_grid(scene_in)))) then
      call solve_pixels(scene_in, map, options, results, failure)
      return
    end if
    if (scene_in%loading%control == control_limit) then
      loading%values = [0.0_real64]
    else
      call list_map_loads(scene_in, map, loading, failure)
      if (allocated(failure)) return
    end if
    reference%answer%interrupt = options%interrupt
    call solve_reference(map, loading, reference, failure)
    reference%by_load = is_load(scene_in%loading%control)
    if (options%interrupt%is_asked()) failure = 'interrupted'
    if (allocated(failure) .and. .not. by_summits) then
      call solve_pixels(scene_in, map, options, results, failure)
      return
    end if
    if (allocated(failure) .and. mode /= effect_off) return
    ! The file keeps the final result, which with `auto` may be that of the pixels.
    of_summits_options = options
    if (mode == effect_auto .and. allocated(options%keep_file)) &
      deallocate (of_summits_options%keep_file)
    call summits_of_scene(scene_in, map, plain, summits, failure)
    if (.not. allocated(failure)) &
      call solve_with_fields(plain, of_summits_options, of_summits, failure, &
                             reshape([-0.5_real64 * map%pixel_spacing, map%pixel_spacing * &
                                      ([map%columns, map%rows] - 0.5_real64)], [2, 2]))
    if (.not. allocated(failure)) &
      call check_summits(scene_in, plain, map, reference, summits, of_summits, failure)
    if (options%interrupt%is_asked()) failure = 'interrupted'
    if (allocated(failure)) then
      ! The pixels have a solution where summits have none.
      if (.not. (by_summits .or. options%interrupt%is_asked())) &
        call solve_pixels(scene_in, map, options, results, failure)
      return
    end if
    of_summits%nominal_area = results%nominal_area
    if (by_summits .and. mode == effect_auto .and. scene_in%loading%control /= control_limit) &
      by_summits = any(of_summits%effects%names /= 'interaction' .and. &
                       of_summits%positions(1)%effects%simulated /= 'off')
    if (.not. by_summits) by_summits = is_good_enough(scene_in, of_summits)
    if (.not. by_summits) then
      results%map = of_summits%map
      call solve_pixels(scene_in, map, options, results, failure)
      if (allocated(failure)) then
        failure = 'the error of its summits is above the tolerance; its pixels: ' // failure
        return
      end if
      call keep_estimates(scene_in, of_summits, results%positions(1))
    else
      results = of_summits
      call add_map_warnings(scene_in, map, results)
    end if
  end subroutine solve_map

  ! Keeps the estimates of the effects that are left out on the summits, for the pixels.
  subroutine keep_estimates(scene_in, summits, pixels)
    type(scene), intent(in) :: scene_in
    type(scene_results), intent(in) :: summits
    type(position_result), intent(inout) :: pixels
    type(theory_warning), allocatable :: warnings(:)
    real(real64) :: share
    integer :: e

    associate (of_summits => summits%positions(1))
      pixels%left_out = of_summits%left_out
      do e = 1, size(summits%effects%names)
        if (summits%effects%names(e) /= 'interaction') pixels%left_out(findloc( &
          known_effects%name, summits%effects%names(e), 1)) = of_summits%effects(e)%estimate
      end do
      share = sum(pixels%left_out, pixels%left_out > 0.0_real64)
      if (.not. share > 0.0_real64) return
      if (is_load(scene_in%loading%control)) share = of_compression * share
      pixels%error_estimate = max(pixels%error_estimate, 0.0_real64) + share
      if (allocated(of_summits%warnings)) warnings = pack(of_summits%warnings, [( &
        any(of_summits%warnings(e)%number == [of_together, of_off, of_barred, of_excluded]), &
        e=1, size(of_summits%warnings))])
      if (pixels%error_estimate > scene_in%effects%number('tolerance')) &
        call add_warning(warnings, of_error, pixels%error_estimate)
      call take_worse(pixels%warnings, warnings, size(pixels%states))
    end associate
  end subroutine keep_estimates

  ! Solves a map on its pixels.
  subroutine solve_pixels(scene_in, map, options, results, failure)
    type(scene), intent(in) :: scene_in
    type(height_map), intent(in), target :: map
    type(run_options), intent(in) :: options
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure
    class(position_solver), allocatable :: solver
    type(map_loading) :: loading

    call list_map_loads(scene_in, map, loading, failure)
    if (allocated(failure)) return
    call make_map_solver(scene_in, map, loading, options%fields, solver)
    allocate (results%effects)
    call name_map_columns(scene_in, results%effects)
    results%effects%tolerance = scene_in%effects%number('tolerance')
    call sweep_scene(scene_in, options, solver, results, failure)
    if (.not. allocated(failure)) call add_map_warnings(scene_in, map, results)
  end subroutine solve_pixels

  ! Adds the warnings of the map itself to those of its last state.
  subroutine add_map_warnings(scene_in, map, results)
    type(scene), intent(in) :: scene_in
    type(height_map), intent(in) :: map
    type(scene_results), intent(inout) :: results
    type(theory_warning), allocatable :: warnings(:)

    ! The height of a summit above the base of its cap is that of the map.
    if (allocated(results%positions(1)%warnings)) then
      associate (found => results%positions(1)%warnings)
        where (found%number == of_cap) found%whose = 'summits of the map'
      end associate
    end if
    call warn_of_map(map, scene_in%effects%number('tolerance'), warnings)
    call take_worse(results%positions(1)%warnings, warnings, size(results%positions(1)%states))
  end subroutine add_map_warnings

  ! Estimates the error of the summit model by the comparison with the map.
  subroutine check_summits(scene_in, plain, map, reference, summits, results, failure)
    type(scene), intent(in) :: scene_in, plain
    type(height_map), intent(in) :: map
    type(map_reference), intent(inout) :: reference
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
      ! Without contact of a summit the error is the load of the map.
      results%positions(1)%error_estimate = merge(1.0_real64, 0.0_real64, &
                                                  reference%answer%load > 0.0_real64)
      return
    end if
    ! The stiffness of the summits needs a second state, solved only where the stiffness of the map
    ! is computed. If that fails the stiffness is not reported.
    stiffness = not_computed
    if (reference%coarser == 1) then
      other = plain
      other%loading = increased_load(last)
      call solve_surfaces(other, run_options(interrupt=reference%answer%interrupt), more, why)
      if (.not. allocated(why)) stiffness = stiffness_between(last, last_state(more%positions(1)))
    end if
    allocate (results%map)
    call compare_with_map(map, reference, combined_modulus(scene_in), summits, last, stiffness, &
                          results%map, failure)
    if (allocated(failure)) return
    call warn_of_shares(results%map%shares, scene_in%effects%number('tolerance'), warnings, &
                        forbids_boundary(scene_in))
    if (.not. is_load(scene_in%loading%control)) then
      ! A map without load at this separation: the error is the load of the summits.
      results%positions(1)%error_estimate = 1.0_real64
      if (results%map%load_difference < huge(1.0_real64)) results%positions(1)%error_estimate = &
        abs(results%map%load_difference) + results%map%load_uncertain
    else if (results%map%closing > 0.0_real64) then
      results%positions(1)%error_estimate = &
        (abs(results%map%difference) + results%map%uncertain) * results%map%rms_height / &
        results%map%closing
    else
      ! The compression is below the rounding of the heights: its error is unknown.
      results%positions(1)%error_estimate = 1.0_real64
    end if
    ! The estimate of the contacts among themselves is replaced by the comparison with the map.
    if (allocated(results%positions(1)%warnings)) results%positions(1)%warnings = &
      pack(results%positions(1)%warnings, results%positions(1)%warnings%number /= of_error)
    if (results%positions(1)%error_estimate > scene_in%effects%number('tolerance')) &
      call add_warning(warnings, of_error, results%positions(1)%error_estimate)
    call take_worse(results%positions(1)%warnings, warnings, size(results%positions(1)%states))
  end subroutine check_summits

  ! The name that rules out interaction = 'boundary': another effect, or the control; '': none.
  pure function forbids_boundary(scene_in) result(name)
    type(scene), intent(in) :: scene_in
    character(len=32) :: name
    integer :: i

    name = ''
    if (scene_in%loading%control == control_limit) name = 'not with control = ''limit'''
    do i = 1, size(known_effects)
      if (scene_in%effects%modes(i) /= effect_off .and. known_effects(i)%name /= 'interaction') &
        name = 'not with ' // known_effects(i)%name
    end do
  end function forbids_boundary

  ! Whether the errors of the summits are within the tolerance of `auto`, area included.
  logical function is_good_enough(scene_in, results)
    type(scene), intent(in) :: scene_in
    type(scene_results), intent(in) :: results
    real(real64) :: tolerance

    tolerance = scene_in%effects%number('tolerance')
    is_good_enough = results%positions(1)%error_estimate <= tolerance
    if (is_good_enough .and. allocated(results%map)) is_good_enough = &
      results%map%coarser == 1 .and. abs(results%map%area_difference) <= tolerance
  end function is_good_enough

end module asperity_map_solve
