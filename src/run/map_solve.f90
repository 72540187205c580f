!> Solution of a map: on its pixels, or by its summits, compared with the map.
module asperity_map_solve
  use asperity_asperity_records, only: of_compression
  use asperity_constants, only: pi
  use asperity_contact_field, only: fields_none
  use asperity_contact_model, only: contact_model, path_step
  use asperity_contact_records, only: contact_row, drop_rows, position_result, state_row
  use asperity_decimal, only: decimal_to_real64
  use asperity_effect_names, only: by_numbers, go_together, known_effects
  use asperity_height_map, only: height_map
  use asperity_kept_records, only: whole_number
  use asperity_kinds, only: not_computed, real64
  use asperity_map_check, only: compare_with_map, map_reference, solve_reference, stiffness_step
  use asperity_map_scene, only: area_of_map, join_maps, plan_map_path, summits_of_scene
  use asperity_map_shares, only: warn_of_map, warn_of_shares
  use asperity_map_summits, only: map_summits
  use asperity_numeral, only: rounded_decimal
  use asperity_pixel_effects, only: is_attraction_resolved
  use asperity_pixel_model, only: make_pixel_model
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: last_state, scene_results
  use asperity_scene_values, only: combined_modulus, control_limit, control_load, &
                                   control_separation, effect_auto, effect_off, effect_on, &
                                   has_hardness, is_load, scene, scene_loading, solves_pixels
  use asperity_surface_fields, only: solve_with_fields
  use asperity_surface_solve, only: solve_effects
  use asperity_sweep, only: sweep_scene
  use asperity_theory_warnings, only: of_barred, of_cap, of_error, of_off, &
                                      of_together, take_worse, theory_warning, add_warning
  implicit none
  private

  public :: solve_map

contains

  !> Solves a map on its pixels, or by its summits, which are compared with the map.
  subroutine solve_map(scene_in, options, results, failure)
    type(scene), intent(in) :: scene_in                    !! scene with a map, checked
    type(run_options), intent(in) :: options               !! options of the run
    type(scene_results), intent(inout) :: results          !! results of the one position
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is not solved
    logical :: needs_summits

    results%nominal_area = decimal_to_real64(scene_in%nominal_area)
    ! Pixels may suffice where the effects that only asperities have turn out negligible.
    needs_summits = .not. (solves_pixels(scene_in) .or. &
                           (scene_in%effects%mode('interaction') == effect_auto .and. &
                            scene_in%loading%control /= control_limit .and. &
                            .not. any(scene_in%effects%modes == effect_on .and. &
                                      known_effects%not_on_pixels /= '')))
    if (.not. needs_summits) call solve_chosen(scene_in, options, results, needs_summits, failure)
    if (allocated(failure)) return
    if (needs_summits) call solve_summits(scene_in, options, results, failure)
  end subroutine solve_map

  ! Solves a map by its summits, and compares them with its pixels.
  subroutine solve_summits(scene_in, options, results, failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure
    type(height_map) :: map
    type(path_step), allocatable :: steps(:)
    real(real64) :: origin(2)
    type(map_reference) :: reference
    type(map_summits) :: summits
    type(scene) :: plain
    type(scene_results) :: of_summits
    type(theory_warning), allocatable :: warnings(:)

    call join_maps(scene_in, 1, map, origin, failure)
    if (allocated(failure)) return
    if (.not. results%nominal_area > 0.0_real64) results%nominal_area = area_of_map(map)
    allocate (steps(1))
    if (scene_in%loading%control /= control_limit) &
      call plan_map_path(scene_in, map, steps, failure)
    if (allocated(failure)) return
    reference%answer%interrupt = options%interrupt
    reference%by_load = is_load(scene_in%loading%control) .or. &
                        scene_in%loading%control == control_limit
    call solve_reference(map, combined_modulus(scene_in), steps(size(steps))%value, reference, &
                         failure)
    reference%by_load = is_load(scene_in%loading%control)
    if (options%interrupt%is_asked()) failure = 'interrupted'
    if (allocated(failure) .and. scene_in%effects%mode('interaction') /= effect_off) return
    call summits_of_scene(scene_in, map, plain, summits, failure)
    if (.not. allocated(failure)) &
      call solve_with_fields(plain, options, of_summits, failure, &
                             reshape([-0.5_real64 * map%pixel_spacing, map%pixel_spacing * &
                                      ([map%columns, map%rows] - 0.5_real64)], [2, 2]))
    if (options%interrupt%is_asked()) failure = 'interrupted'
    if (allocated(failure)) return
    call check_summits(scene_in, plain, map, reference, summits, of_summits, failure)
    if (options%interrupt%is_asked()) failure = 'interrupted'
    if (allocated(failure)) return
    of_summits%nominal_area = results%nominal_area
    results = of_summits
    ! The height of a summit above the base of its cap is that of the map.
    if (allocated(results%positions(1)%warnings)) then
      associate (found => results%positions(1)%warnings)
        where (found%number == of_cap) found%whose = 'summits of the map'
      end associate
    end if
    call warn_of_map(map, scene_in%effects%number('tolerance'), &
                     any(scene_in%map%form_radius > 0.0_real64), .false., warnings)
    call take_worse(results%positions(1)%warnings, warnings, size(results%positions(1)%states))
  end subroutine solve_summits

  ! Solves a map on its pixels with the effects of `auto` whose estimated influence is above the
  ! tolerance. The estimate is that of the last state without them; under a tensile load all are
  ! chosen. Adhesion that the pixels do not resolve is left out. Where an effect is called for that
  ! only asperities have, there are no results.
  subroutine solve_chosen(scene_in, options, results, needs_summits, failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(scene_results), intent(inout) :: results
    logical, intent(out) :: needs_summits
    character(len=:), allocatable, intent(out) :: failure
    type(scene), target :: chosen
    type(scene_results) :: without
    real(real64) :: influence(size(known_effects))
    logical :: is_called(size(known_effects)), is_final
    integer :: at, e, k, m

    needs_summits = .false.
    chosen = scene_in
    is_final = .false.
    is_called = scene_in%effects%modes == effect_auto .and. &
                (known_effects%name == 'adhesion' .or. known_effects%name == 'creep')
    if ((any(is_called) .and. .not. is_tensile(scene_in%loading)) .or. &
        .not. solves_pixels(scene_in)) then
      if (.not. is_tensile(scene_in%loading)) then
        where (is_called)
          chosen%effects%modes = effect_off
          chosen%effects%given = by_numbers
        end where
      end if
      without = results
      call solve_trial(chosen, options, without, is_final, failure)
      if (allocated(failure)) return
      influence = [(maxval(without%positions%left_out(e)), e=1, size(influence))]
      ! An effect that only asperities have is simulated beside interaction.
      needs_summits = .not. solves_pixels(scene_in) .and. any([( &
        scene_in%effects%modes(e) == effect_auto .and. known_effects(e)%not_on_pixels /= '' .and. &
        influence(e) > scene_in%effects%number('tolerance') .and. &
        go_together(known_effects(e)%name, 'on', 'interaction', 'coupled'), &
        e=1, size(known_effects))])
      if (needs_summits) return
      if (.not. is_tensile(scene_in%loading)) then
        is_called = is_called .and. influence > scene_in%effects%number('tolerance') .and. &
                    (known_effects%name /= 'adhesion' .or. is_attraction_resolved(scene_in))
        is_final = is_final .and. .not. any(is_called)
      end if
    end if
    if (is_final) then
      results = without
    else
      where (is_called) chosen%effects%modes = effect_on
      call solve_pixels(chosen, options, results, failure)
      if (allocated(failure)) return
    end if
    do m = 1, size(results%positions)
      if (.not. allocated(results%positions(m)%effects)) cycle
      k = whole_number(m, options%part, options%parts)
      associate (position => results%positions(m))
        if (allocated(without%positions)) then
          position%choices = 1
          if (.not. is_final) position%solves = position%solves + without%positions(k)%solves
        end if
        do e = 1, size(known_effects)
          if (.not. is_called(e)) cycle
          at = findloc(results%effects%names, known_effects(e)%name, 1)
          if (allocated(without%positions)) &
            position%effects(at)%estimate = without%positions(k)%left_out(e)
          position%effects(at)%why = 'estimate above tolerance'
          results%effects%modes(at) = effect_auto
        end do
      end associate
    end do
  end subroutine solve_chosen

  ! Solves the last value with contact of a map to estimate influences, at all positions, also in a
  ! part of the work or on one of many images. With a hardness the last state depends on the states
  ! before it: all are solved.
  subroutine solve_trial(scene_in, options, results, is_final, failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(scene_results), intent(inout) :: results
    logical, intent(out) :: is_final  ! the results are those of all states, and need no file
    character(len=:), allocatable, intent(out) :: failure
    type(run_options) :: trial
    type(scene) :: last
    type(scene_results) :: found
    integer :: at, m

    last = scene_in
    trial = options
    at = 0  ! value of the path; 0: all states
    trial%part = 1
    trial%parts = 1
    trial%all_images = .false.
    is_final = .not. options%all_images
    if (allocated(options%keep_file)) is_final = is_final .and. options%keep_file == ''
    if (allocated(trial%more_files)) deallocate (trial%more_files)
    if (allocated(trial%keep_file)) deallocate (trial%keep_file)
    if (.not. has_hardness(scene_in) .and. &
        (allocated(scene_in%loading%path) .or. scene_in%loading%points > 1)) then
      is_final = .false.
      trial%fields = fields_none
      last%loading%points = 0
      if (allocated(last%loading%path)) then
        at = size(last%loading%path)
        last%loading%value = last%loading%path(at)
        deallocate (last%loading%path)
      end if
    end if
    do
      found = results
      call solve_pixels(last, trial, found, failure)
      if (allocated(failure) .or. at <= 1) exit
      if (any([(maxval(found%positions(m)%states%load) > 0.0_real64, &
                m=1, size(found%positions))])) exit
      at = at - 1
      last%loading%value = scene_in%loading%path(at)
    end do
    results = found
  end subroutine solve_trial

  ! Whether a load of a scene is tensile or 0.
  pure logical function is_tensile(loading)
    type(scene_loading), intent(in) :: loading

    is_tensile = is_load(loading%control) .and. loading%value%all_digits <= 0
    if (allocated(loading%path)) is_tensile = is_load(loading%control) .and. &
                                              any(loading%path%all_digits <= 0)
  end function is_tensile

  ! Solves a map on its pixels.
  subroutine solve_pixels(scene_in, options, results, failure)
    type(scene), intent(in), target :: scene_in
    type(run_options), intent(in) :: options
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure
    class(contact_model), allocatable, target :: model
    type(run_options) :: with_contacts
    logical :: is_left(size(known_effects))
    integer :: e, m

    allocate (results%effects)
    call make_pixel_model(scene_in, options%fields, model, results%effects, failure)
    if (allocated(failure)) return
    if (.not. results%nominal_area > 0.0_real64) results%nominal_area = model%nominal_area
    is_left = [(scene_in%effects%has_numbers(e) .and. &
                all(results%effects%names /= known_effects(e)%name), e=1, size(known_effects))]
    with_contacts = options
    with_contacts%keep_contacts = options%keep_contacts .or. any(is_left)
    call sweep_scene(scene_in, with_contacts, model, results, failure)
    if (allocated(failure) .or. .not. any(is_left)) return
    do m = 1, size(results%positions)
      ! Positions of other images have no states here.
      if (.not. allocated(results%positions(m)%states)) cycle
      call estimate_left_out(scene_in, is_left, results%positions(m))
      if (.not. options%keep_contacts) call drop_rows(results%positions(m))
    end do
  end subroutine solve_pixels

  ! Estimates the influence of effects that are not simulated, in the last state with contact: each
  ! patch of pixels is taken as the Hertzian contact of its area and load.
  subroutine estimate_left_out(scene_in, is_left, position)
    type(scene), intent(in) :: scene_in
    logical, intent(in) :: is_left(:)  ! whether each known effect is not simulated
    type(position_result), intent(inout) :: position
    type(scene) :: spheres
    type(scene_results) :: of_spheres
    type(theory_warning), allocatable :: warnings(:)
    type(state_row) :: last
    character(len=:), allocatable :: failure
    type(contact_row), allocatable :: rows(:)
    real(real64), allocatable :: square(:), radius(:)
    real(real64) :: share
    integer :: at, e, number

    do at = size(position%states), 1, -1
      last = position%states(at)
      ! A patch in tension has no sphere.
      rows = position%rows(last%first_row:last%last_row)
      rows = pack(rows, rows%load > 0.0_real64)
      if (size(rows) > 0) exit
    end do
    if (at == 0) return
    spheres = scene_in
    deallocate (spheres%map)
    spheres%effects%modes = effect_off
    if (allocated(spheres%loading%path)) deallocate (spheres%loading%path)
    spheres%loading%control = control_separation
    spheres%loading%value = rounded_decimal(last%approach, 17)
    spheres%loading%points = 1
    spheres%motion%positions = 1
    square = rows%area / pi
    radius = 4 * combined_modulus(scene_in) * square * sqrt(square) / (3 * rows%load)
    spheres%upper%is_plane = .true.
    spheres%lower%is_plane = .false.
    ! A patch that spans a periodic map has no centre.
    spheres%lower%x = merge(rows%x, 0.0_real64, rows%x > not_computed)
    spheres%lower%y = merge(rows%y, 0.0_real64, rows%y > not_computed)
    spheres%lower%height = last%approach + square / radius
    spheres%lower%radius = radius
    spheres%upper%x = rows(:0)%x
    spheres%upper%y = rows(:0)%x
    spheres%upper%height = rows(:0)%x
    spheres%upper%radius = rows(:0)%x
    call solve_effects(spheres, run_options(), of_spheres, failure)
    if (allocated(failure)) return
    associate (found => of_spheres%positions(1))
      position%left_out = merge(found%left_out, not_computed, is_left)
      share = sum(position%left_out, position%left_out > 0.0_real64)
      if (.not. share > 0.0_real64) return
      if (is_load(scene_in%loading%control)) share = of_compression * share
      position%error_estimate = max(position%error_estimate, 0.0_real64) + share
    end associate
    do e = 1, size(known_effects)
      if (.not. position%left_out(e) > scene_in%effects%number('tolerance')) cycle
      if (scene_in%effects%modes(e) == effect_auto) then
        call add_warning(warnings, of_together, position%left_out(e), &
                         whose=trim(known_effects(e)%name) // ' beside interaction')
      else
        number = merge(of_barred, of_off, scene_in%effects%is_barred(known_effects(e)%name))
        call add_warning(warnings, number, position%left_out(e), whose=known_effects(e)%name)
      end if
    end do
    if (position%error_estimate > scene_in%effects%number('tolerance')) &
      call add_warning(warnings, of_error, position%error_estimate)
    call take_worse(position%warnings, warnings, at)
  end subroutine estimate_left_out

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
    type(scene_loading) :: load_again
    type(state_row) :: increased, last
    type(theory_warning), allocatable :: warnings(:)
    real(real64) :: stiffness
    character(len=32) :: forbids
    character(len=:), allocatable :: why
    integer :: i

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
      other%loading = load_again
      other%loading%control = control_load
      other%loading%value = rounded_decimal((1.0_real64 + stiffness_step) * last%load, 17)
      call solve_effects(other, run_options(interrupt=reference%answer%interrupt), more, why)
      if (.not. allocated(why)) then
        increased = last_state(more%positions(1))
        if (increased%compression > last%compression) &
          stiffness = (increased%vertical_load - last%vertical_load) / &
                      (increased%compression - last%compression)
      end if
    end if
    allocate (results%map)
    call compare_with_map(map, reference, combined_modulus(scene_in), summits, last, stiffness, &
                          results%map, failure)
    if (allocated(failure)) return
    associate (position => results%positions(1), check => results%map, &
               tolerance => scene_in%effects%number('tolerance'))
      ! Another effect, or the control, excludes interaction = 'boundary'.
      forbids = ''
      if (scene_in%loading%control == control_limit) forbids = 'not with control = ''limit'''
      do i = 1, size(known_effects)
        if (scene_in%effects%modes(i) /= effect_off .and. known_effects(i)%name /= 'interaction') &
          forbids = 'not with ' // known_effects(i)%name
      end do
      call warn_of_shares(check%shares, tolerance, warnings, forbids)
      ! Unknown where the compression is below the rounding of the heights, and of the order of the
      ! load of the summits where the map has none at this separation.
      position%error_estimate = 1.0_real64
      if (.not. is_load(scene_in%loading%control)) then
        if (check%load_difference < huge(1.0_real64)) &
          position%error_estimate = abs(check%load_difference) + check%load_uncertain
      else if (check%compression > 0.0_real64) then
        position%error_estimate = (abs(check%difference) + check%uncertain) * check%rms_height / &
                                  check%compression
      end if
      ! The estimate of the contacts among themselves is replaced by the comparison with the map.
      if (allocated(position%warnings)) position%warnings = &
        pack(position%warnings, position%warnings%number /= of_error)
      if (position%error_estimate > tolerance) &
        call add_warning(warnings, of_error, position%error_estimate)
      call take_worse(position%warnings, warnings, size(position%states))
    end associate
  end subroutine check_summits

end module asperity_map_solve
