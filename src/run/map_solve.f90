!> Solution of a map on its pixels.
module asperity_map_solve
  use asperity_asperity_records, only: of_compression
  use asperity_constants, only: pi
  use asperity_contact_field, only: fields_none
  use asperity_contact_model, only: contact_model
  use asperity_contact_records, only: contact_row, drop_rows, position_result, state_row
  use asperity_effect_names, only: by_numbers, known_effects
  use asperity_images, only: image_count
  use asperity_kept_records, only: whole_number
  use asperity_kinds, only: not_computed, real64
  use asperity_numeral, only: rounded_decimal
  use asperity_pixel_effects, only: is_attraction_resolved
  use asperity_pixel_model, only: make_pixel_model
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: combined_modulus, control_separation, effect_auto, effect_off, &
                                   effect_on, has_hardness, is_load, scene, scene_loading
  use asperity_surface_solve, only: solve_effects
  use asperity_sweep, only: sweep_scene
  use asperity_theory_warnings, only: of_barred, of_error, of_off, of_together, take_worse, &
                                      theory_warning, add_warning
  implicit none
  private

  public :: solve_map

contains

  !> Solves a map on its pixels with the effects of `auto` whose estimated influence is above the
  !> tolerance. The estimate is that of the last state without them; under a tensile load all are
  !> chosen. Adhesion that the pixels do not resolve is left out.
  subroutine solve_map(scene_in, options, results, failure)
    type(scene), intent(in) :: scene_in                    !! scene with a map, checked
    type(run_options), intent(in) :: options               !! options of the run
    type(scene_results), intent(inout) :: results          !! results of all positions
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is not solved
    type(scene), target :: chosen
    type(scene_results) :: without
    real(real64) :: influence(size(known_effects))
    logical :: is_called(size(known_effects)), is_final
    integer :: at, e, k, m

    results%nominal_area = scene_in%nominal_area
    chosen = scene_in
    is_final = .false.
    is_called = scene_in%effects%modes == effect_auto .and. &
                (known_effects%name == 'adhesion' .or. known_effects%name == 'creep')
    if (any(is_called) .and. .not. is_tensile(scene_in%loading)) then
      where (is_called)
        chosen%effects%modes = effect_off
        chosen%effects%given = by_numbers
      end where
      without = results
      call solve_trial(chosen, options, without, is_final, failure)
      if (allocated(failure)) return
      influence = [(maxval(without%positions%left_out(e)), e=1, size(influence))]
      is_called = is_called .and. influence > scene_in%effects%number('tolerance') .and. &
                  (known_effects%name /= 'adhesion' .or. is_attraction_resolved(scene_in))
      is_final = is_final .and. .not. any(is_called)
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
  end subroutine solve_map

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
    is_final = .not. (options%all_images .and. image_count() > 1)
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

    is_tensile = is_load(loading%control) .and. .not. loading%value > 0.0_real64
    if (allocated(loading%path)) is_tensile = is_load(loading%control) .and. &
                                              any(.not. loading%path > 0.0_real64)
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

end module asperity_map_solve
