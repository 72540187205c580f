!> Solves a scene on the pixels of its map, state by state; contact patches are its contacts.
module asperity_map_press_solver
  use asperity_attraction_law, only: attraction_at, attraction_law, new_attraction, pixel_steepness
  use asperity_contact_field, only: contact_field, fields_all, fields_none, room_of_fields
  use asperity_contact_records, only: add_rows, contact_row, position_result, prescribed_normal, &
                                      state_row
  use asperity_decimal, only: decimal_to_real64
  use asperity_height_map, only: height_map
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_map_contact, only: map_answer, most_load, room_to_press
  use asperity_map_error, only: estimate_pixel_errors, is_rough_at_pixels, pixel_errors
  use asperity_map_fields, only: measure_fields, take_field
  use asperity_map_form, only: find_form_contact
  use asperity_map_interface, only: interface_columns, interface_powers, measure_interface
  use asperity_map_levelling, only: is_flat
  use asperity_map_patches, only: find_patches, map_patch
  use asperity_map_scene, only: map_loading
  use asperity_map_shares, only: find_shares, map_shares, warn_of_shares
  use asperity_map_state, only: map_history, map_laws, solve_map_state
  use asperity_partial_slip, only: slip_answer, slip_of_patches, slip_request, solve_partial_slip, &
                                   take_traction
  use asperity_position_solver, only: position_solver
  use asperity_problems, only: decimal_text, not_enough_memory, real_text
  use asperity_process, only: has_memory
  use asperity_scene_results, only: effect_header
  use asperity_scene_values, only: combined_modulus, effect_off, has_hardness, hold_load, scene, &
                                   scene_limit
  use asperity_slip_columns, only: slip_contact_columns, slip_contact_powers, &
                                   slip_state_columns, slip_state_powers, stiffness_ratio_of
  use asperity_theory_limits, only: is_patch_at_limit, look_at_pressure, set_theory_limits, &
                                    theory_limits
  use asperity_theory_warnings, only: add_warning, of_attraction, of_error, of_flat_map, &
                                      of_held_gap, of_resolution, take_worse, theory_warning, &
                                      warning_kinds
  use asperity_viscoelastic_solid, only: hold_times
  implicit none
  private

  public :: is_attraction_resolved, make_map_solver, name_map_columns

  ! Tolerance of the largest load at the hardness, for rounding.
  real(real64), parameter :: load_rounding = 1.0e-12_real64

  ! Steepness of the attraction without a warning, and the largest (measured on a ball: up to 1.0
  ! states of open and of adhering surfaces agree to 1e-8 pi w R, at 1.2 they differ by 1e-2; test:
  ! wide pixels in test/regression/test_adhesive_pixels.py).
  real(real64), parameter :: resolved = 0.7_real64, steepest = 1.2_real64

  !> Solver of a map.
  type, extends(position_solver) :: map_press_solver
    private
    type(height_map), pointer :: map => null()
    type(map_loading) :: loading
    real(real64) :: tolerance = 0.0_real64
    type(map_laws) :: laws                       ! what acts on the pixels
    real(real64), allocatable :: times(:)        ! of the states; those of a hold are last
    logical :: has_adhesion = .false.            ! columns of adhesion
    real(real64) :: steepness = 0.0_real64       ! of the attraction over a pixel
    logical :: holds_load = .true.               ! a hold is one of the load, else of the separation
    type(slip_request), allocatable :: slip      ! tangential load; not allocated: no friction
    type(theory_limits) :: limits
    type(scene_limit) :: limit
    integer :: fields = fields_none              ! which states keep pressure and gap
    real(real64) :: form_radius(2) = 0.0_real64  ! of the form along x and y; 0: straight
    character(len=:), allocatable :: unit        ! unit of length; empty: unknown
  contains
    procedure :: solve => press_to_states  !! solves the one position
  end type map_press_solver

contains

  !> Makes the solver of a map.
  subroutine make_map_solver(scene_in, map, loading, fields, solver, failure)
    type(scene), intent(in) :: scene_in               !! scene with a map, checked
    type(height_map), intent(in), target :: map       !! levelled map; must outlive the solver
    type(map_loading), intent(in) :: loading          !! loads or levels of the map
    integer, intent(in) :: fields                     !! `fields_none`, `fields_last`, `fields_all`
    class(position_solver), allocatable, intent(out) :: solver
    character(len=:), allocatable, intent(out) :: failure  !! the attraction is not resolved
    type(map_press_solver), allocatable :: new

    allocate (new)
    new%map => map
    new%loading = loading
    new%tolerance = scene_in%effects%number('tolerance')
    call set_laws(scene_in, map, loading, new, failure)
    if (allocated(failure)) return
    if (scene_in%effects%mode('friction') /= effect_off) then
      allocate (new%slip)
      new%slip%coefficient = scene_in%effects%number('friction_coefficient')
      new%slip%kappa = stiffness_ratio_of(scene_in)
      associate (loading => scene_in%loading)
        new%slip%by_load = loading%tangential_displacement%all_digits == 0_int64
        new%slip%given = decimal_to_real64(merge(loading%tangential_load, &
                                                 loading%tangential_displacement, &
                                                 new%slip%by_load))
      end associate
    end if
    call set_theory_limits(scene_in, 0, 0, new%limits)
    new%limit = scene_in%limit
    new%fields = fields
    new%form_radius = scene_in%map%form_radius
    new%unit = trim(scene_in%units(1))
    if (new%unit == '' .and. allocated(map%unit)) new%unit = trim(map%unit)
    new%positions = 1
    new%states = size(new%times)
    new%work = int(map%columns, int64) * map%rows
    call move_alloc(new, solver)
  end subroutine make_map_solver

  ! Sets what acts on the pixels, and the times of the states. `failure` is allocated where the
  ! pixels are too wide for the attraction.
  subroutine set_laws(scene_in, map, loading, solver, failure)
    type(scene), intent(in) :: scene_in
    type(height_map), intent(in) :: map
    type(map_loading), intent(in) :: loading
    type(map_press_solver), intent(inout) :: solver
    character(len=:), allocatable, intent(out) :: failure
    real(real64), allocatable :: times(:)
    real(real64) :: pixel

    allocate (solver%times(size(loading%values)), source=0.0_real64)
    associate (effects => scene_in%effects, laws => solver%laws)
      laws%modulus = loading%modulus
      solver%has_adhesion = effects%mode('adhesion') /= effect_off
      if (has_hardness(scene_in)) laws%hardness = effects%number('plastic_hardness')
      if (effects%mode('adhesion') /= effect_off .and. &
          effects%number('work_of_adhesion') > 0.0_real64) then
        laws%attraction = attraction_of(scene_in)
        pixel = maxval(map%pixel_spacing)
        solver%steepness = pixel_steepness(laws%attraction, pixel, loading%modulus)
        if (.not. is_attraction_resolved(scene_in, map)) &
          failure = 'the pixels are too wide for the range of adhesion: found a spacing of ' // &
                    real_text(pixel) // ', expected at most ' // &
                    real_text(pixel * resolved / solver%steepness)
      end if
      if (effects%mode('creep') == effect_off) return
      allocate (laws%solid)
      laws%solid%relaxed_ratio = effects%number('relaxed_modulus_ratio')
      laws%solid%relaxation_time = effects%number('relaxation_time')
      solver%holds_load = nint(effects%number('hold')) == hold_load
      call hold_times(effects%number('hold_time'), laws%solid%relaxation_time, &
                      nint(effects%number('hold_points')), times)
      solver%times = [solver%times, times(2:)]
    end associate
  end subroutine set_laws

  !> Whether the range of adhesion is wide enough for the pixels.
  logical function is_attraction_resolved(scene_in, map) result(is_resolved)
    type(scene), intent(in) :: scene_in    !! scene with a work of adhesion > 0
    type(height_map), intent(in) :: map    !! levelled height map

    is_resolved = pixel_steepness(attraction_of(scene_in), maxval(map%pixel_spacing), &
                                  combined_modulus(scene_in)) <= steepest
  end function is_attraction_resolved

  ! Attraction of a scene.
  type(attraction_law) function attraction_of(scene_in) result(law)
    type(scene), intent(in) :: scene_in

    law = new_attraction(nint(scene_in%effects%number('adhesion_law')), &
                         scene_in%effects%number('work_of_adhesion'), &
                         scene_in%effects%number('equilibrium_distance'))
  end function attraction_of

  !> Names of the columns of a map that is solved on its pixels, beside those of contacts.
  subroutine name_map_columns(scene_in, header)
    type(scene), intent(in) :: scene_in         !! scene with a map that is solved on its pixels
    type(effect_header), intent(out) :: header  !! columns of interaction and, with a hardness,
                                                !! plasticity

    header%names = [character(len=11) :: 'interaction']
    header%modes = [scene_in%effects%mode('interaction')]
    header%contact_columns = [character(len=20) :: 'samples']
    header%state_columns = [character(len=24) :: 'samples_in_contact', 'sample_area', &
                            'area_error_estimate', 'gap_error_estimate', 'pressure_error_estimate']
    header%contact_powers = reshape([0, 0], [2, 1])
    header%state_powers = reshape([0, 0, 0, 2, 0, 0, 0, 0, 0, 0], [2, 5])
    if (scene_in%effects%mode('friction') /= effect_off) then
      header%names = [header%names, 'friction   ']
      header%modes = [header%modes, scene_in%effects%mode('friction')]
      header%contact_columns = [header%contact_columns, slip_contact_columns]
      header%contact_powers = reshape([header%contact_powers, slip_contact_powers], [2, 3])
      header%state_columns = [header%state_columns, slip_state_columns]
      header%state_powers = reshape([header%state_powers, slip_state_powers], [2, 10])
    end if
    header%state_columns = [header%state_columns, interface_columns]
    header%state_powers = reshape([header%state_powers, interface_powers], &
                                  [2, size(header%state_columns)])
    if (any(scene_in%map%form_radius > 0.0_real64)) then
      header%state_columns = [character(len=24) :: header%state_columns, 'hertz_pressure', &
                              'hertz_area']
      header%state_powers = reshape([header%state_powers, 1, 0, 0, 2], &
                                    [2, size(header%state_columns)])
    end if
    if (has_hardness(scene_in)) then
      call add_columns('plasticity', [character(len=24) :: 'plastic_area', 'dissipated_work'], &
                       [0, 2, 1, 3])
      header%hardness = scene_in%effects%number('plastic_hardness')
    end if
    if (scene_in%effects%mode('adhesion') /= effect_off) &
      call add_columns('adhesion', [character(len=24) :: 'adhering_contacts', &
                                    'pulling_contacts', 'gap_attraction'], [0, 0, 0, 0, 1, 2])
    if (scene_in%effects%mode('creep') /= effect_off) &
      call add_columns('creep', [character(len=24) :: 'time', 'elastic_load'], [0, 0, 1, 2])

  contains

    subroutine add_columns(name, columns, powers)
      character(len=*), intent(in) :: name, columns(:)
      integer, intent(in) :: powers(:)

      header%names = [character(len=11) :: header%names, name]
      header%modes = [header%modes, scene_in%effects%mode(name)]
      header%state_columns = [character(len=24) :: header%state_columns, columns]
      header%state_powers = reshape([header%state_powers, powers], [2, size(header%state_columns)])
    end subroutine add_columns

  end subroutine name_map_columns

  ! Solves state after state, each the start of the next.
  subroutine press_to_states(self, m, keep_rows, result, failure)
    class(map_press_solver), intent(in) :: self
    integer, intent(in) :: m
    logical, intent(in) :: keep_rows
    type(position_result), intent(out) :: result
    character(len=:), allocatable, intent(out) :: failure
    type(map_answer) :: answer
    type(map_history) :: history
    type(map_patch), allocatable :: patches(:)
    type(map_shares) :: shares
    type(theory_warning), allocatable :: warnings(:)
    real(real64), allocatable :: load, samples(:)
    real(real64) :: other_errors(3), spike_limit
    integer :: i, loaded

    spike_limit = -1.0_real64
    call make_room_for_fields(self, result, failure)
    if (allocated(failure)) return
    allocate (result%states(self%states), result%rows(0), samples(0))
    if (allocated(self%laws%hardness)) then
      associate (most => most_load(self%map, self%laws%hardness))
        if (self%loading%by_load .and. &
            maxval(self%loading%values) > most * (1.0_real64 + load_rounding)) then
          failure = 'the load is above plastic_hardness times the measured area: found ' // &
                    real_text(maxval(self%loading%values)) // ', expected at most ' // &
                    real_text(most)
          return
        end if
      end associate
    end if
    history%deformed = self%map
    answer%interrupt = self%interrupt
    loaded = size(self%loading%values)
    do i = m, self%states
      if (i <= loaded) then
        if (self%loading%by_load) load = self%loading%values(i)
        if (.not. self%loading%by_load) answer%level = self%loading%values(i)
      else if (i == loaded + 1) then
        if (self%holds_load) load = answer%load
        if (.not. self%holds_load .and. allocated(load)) deallocate (load)
      end if
      call solve_map_state(self%laws, self%times(i), history, answer, load)
      if (allocated(answer%failure)) then
        failure = answer%failure
        return
      end if
      call list_patches(self, history, answer, spike_limit, patches, shares)
      if (allocated(warnings)) deallocate (warnings)
      call warn_of_shares(shares, self%tolerance, warnings)
      if (is_flat(self%map)) call add_warning(warnings, of_flat_map, 0.0_real64)
      call warn_of_patches(self, patches, warnings)
      if (self%steepness > resolved) &
        call add_warning(warnings, of_attraction, self%steepness / resolved)
      if (allocated(self%laws%attraction) .and. self%map%periodic .and. i > 1 .and. &
          .not. allocated(load)) call add_warning(warnings, of_held_gap, real(i, real64))
      call fill_state(self, history, answer, patches, load, keep_rows, result, i)
      if (i == self%states) &
        call estimate_errors(self, answer, patches, result, other_errors, warnings)
      call take_worse(result%warnings, warnings, i)
      if (self%fields == fields_all .or. (self%fields /= fields_none .and. i == self%states)) &
        call take_field(history%deformed, answer, i, &
                        result%fields(i - self%states + size(result%fields)))
      if (keep_rows) samples = [samples, real(patches%samples, real64)]
      call self%progress_count%count_state(result%counted)
    end do
    result%state_values = [sum(patches%samples) * &
                           [1.0_real64, product(self%map%pixel_spacing)], other_errors]
    if (allocated(self%slip)) then
      call add_slip(self, history%deformed, answer, samples, result, failure)
      if (allocated(failure)) return
    else
      result%contact_values = reshape(samples, [size(samples), 1])
    end if
    call fill_effects(self, history, answer, patches, result)
  end subroutine press_to_states

  ! Finds the patches and shares of the contact pressure. Loads and pressures of the patches are
  ! then those of the net traction: on all pixels of a patch the attraction is that of contact.
  subroutine list_patches(self, history, answer, spike_limit, patches, shares)
    class(map_press_solver), intent(in) :: self
    type(map_history), intent(in) :: history
    type(map_answer), intent(in) :: answer
    real(real64), intent(inout) :: spike_limit  ! see `find_shares`
    type(map_patch), allocatable, intent(out) :: patches(:)
    type(map_shares), intent(out) :: shares
    real(real64) :: attraction

    if (.not. allocated(self%laws%attraction)) then
      call find_patches(self%map, answer%pressure, patches, hardness=self%laws%hardness)
      call find_shares(self%map, answer%pressure, patches, self%tolerance, spike_limit, shares)
      return
    end if
    associate (pressure => history%adhesion%contact_pressure)
      call find_patches(self%map, pressure, patches)
      call find_shares(self%map, pressure, patches, self%tolerance, spike_limit, shares)
    end associate
    attraction = attraction_at(self%laws%attraction, 0.0_real64)
    patches%load = patches%load - &
                   attraction * patches%samples * product(self%map%pixel_spacing)
    patches%highest = patches%highest - attraction
    patches%mean = min(patches%load / patches%area, patches%highest)
  end subroutine list_patches

  ! Sets the records of the effects and their columns of the last state.
  subroutine fill_effects(self, history, answer, patches, result)
    class(map_press_solver), intent(in) :: self
    type(map_history), intent(in) :: history
    type(map_answer), intent(in) :: answer
    type(map_patch), intent(in) :: patches(:)
    type(position_result), intent(inout) :: result
    real(real64) :: of_interface(size(interface_columns)), smooth(2)
    real(real64), allocatable :: pressure(:, :)

    allocate (pressure, source=answer%pressure)
    if (allocated(answer%touches)) &
      pressure = merge(max(pressure, tiny(pressure)), 0.0_real64, answer%touches)
    call measure_interface(history%deformed, self%loading%modulus, pressure, of_interface, &
                           self%laws%hardness)
    result%state_values = [result%state_values, of_interface]
    associate (last => result%states(self%states))
      if (any(self%form_radius > 0.0_real64)) then
        call find_form_contact(self%form_radius, max(answer%load, 0.0_real64), &
                               self%loading%modulus, length_of_cylinder(self), smooth(1), smooth(2))
        result%state_values = [result%state_values, smooth]
      end if
      if (allocated(self%laws%hardness)) &
        result%state_values = [result%state_values, last%plastic_area, last%dissipated_work]
      if (self%has_adhesion) result%state_values = [result%state_values, &
        real(size(patches), real64), real(count(patches%load < 0.0_real64), real64), &
        sum(patches%load) - answer%load]
      if (allocated(self%laws%solid)) result%state_values = [result%state_values, last%time, &
        product(self%map%pixel_spacing) * sum(history%creep%elastic)]
    end associate
    allocate (result%effects(1 + count([allocated(self%slip), allocated(self%laws%hardness), &
                                        self%has_adhesion, allocated(self%laws%solid)])))
    result%effects%simulated = 'on'
    result%effects(1)%simulated = 'boundary'
    result%effects%why = 'on the pixels of the map'
    result%effects%ending = answer%ending
  end subroutine fill_effects

  ! Length of the contact of a cylinder: that of a period along its axis; 0 where its end is free.
  pure real(real64) function length_of_cylinder(self) result(length)
    class(map_press_solver), intent(in) :: self
    integer :: axis

    axis = minloc(self%form_radius, 1)
    length = 0.0_real64
    if (self%map%repeats(axis)) length = self%map%pixel_spacing(axis) * size(self%map%height, axis)
  end function length_of_cylinder

  ! Solves partial slip at the last state and adds its columns and its traction.
  subroutine add_slip(self, shape_of_map, answer, samples, result, failure)
    class(map_press_solver), intent(in) :: self
    type(height_map), intent(in) :: shape_of_map   ! with a hardness the deformed map
    type(map_answer), intent(in) :: answer         ! solution of the last state
    real(real64), intent(in) :: samples(:)         ! pixels of the patches of all states
    type(position_result), intent(inout) :: result
    character(len=:), allocatable, intent(out) :: failure
    type(slip_answer) :: slip
    real(real64), allocatable :: load(:), stick_area(:), values(:, :)

    call solve_partial_slip(shape_of_map, self%loading%modulus, self%slip, answer, slip)
    if (allocated(slip%failure)) then
      failure = slip%failure
      return
    end if
    result%state_values = [result%state_values, slip%load, slip%displacement, slip%stiffness, &
                           slip%stick_area, merge(1.0_real64, 0.0_real64, slip%slides)]
    allocate (values(size(samples), 3), source=not_computed)
    values(:, 1) = samples
    if (size(samples) > 0) then
      call slip_of_patches(shape_of_map, answer, slip, load, stick_area)
      values(size(samples) - size(load) + 1:, 2) = load
      values(size(samples) - size(load) + 1:, 3) = stick_area
    end if
    call move_alloc(values, result%contact_values)
    if (self%fields /= fields_none) &
      call take_traction(shape_of_map, slip, result%fields(size(result%fields)))
  end subroutine add_slip

  ! Estimates the errors of the last state by the size of the pixels, and warns of them. With a
  ! hardness they are known at the largest load of the path, where its history does not matter. With
  ! adhesion or creep they are unknown.
  subroutine estimate_errors(self, answer, patches, result, other_errors, warnings)
    class(map_press_solver), intent(in) :: self
    type(map_answer), intent(in) :: answer
    type(map_patch), intent(in) :: patches(:)
    type(position_result), intent(inout) :: result
    ! Relative errors of area, mean gap and greatest pressure; `not_computed`: unknown.
    real(real64), intent(out) :: other_errors(3)
    type(theory_warning), allocatable, intent(inout) :: warnings(:)
    type(pixel_errors) :: errors
    real(real64) :: area_error
    character(len=32) :: whose

    other_errors = not_computed
    if (size(patches) == 0 .or. self%has_adhesion .or. allocated(self%laws%solid)) return
    associate (state => result%states(self%states))
      if (.not. allocated(self%laws%hardness) .or. &
          answer%load >= maxval(result%states%load) * (1.0_real64 - load_rounding)) &
        call estimate_pixel_errors(self%map, self%loading%modulus, answer, patches, state, &
                                   self%loading%by_load, errors, self%laws%hardness)
      if (errors%area > not_computed) other_errors = &
        [errors%area, errors%gap, errors%pressure] / &
        [state%area, max(state%mean_gap, errors%gap, tiny(errors%gap)), &
         state%greatest_pressure]
      if (errors%load > not_computed) result%error_estimate = errors%load / answer%load
      if (errors%level > not_computed .and. state%closing > 0.0_real64) &
        result%error_estimate = errors%level / state%closing
    end associate
    if (result%error_estimate > self%tolerance) &
      call add_warning(warnings, of_error, result%error_estimate)
    area_error = max(0.5_real64 * sum(patches%rim) / sum(patches%area), other_errors(1))
    if (.not. area_error > warning_kinds(of_resolution)%limit) return
    whose = ''
    if (is_rough_at_pixels(self%map)) whose = 'it is rough at their size'
    call add_warning(warnings, of_resolution, area_error, whose=whose)
  end subroutine estimate_errors

  ! Allocates the fields, if there is memory for them beside that of the solver.
  subroutine make_room_for_fields(self, result, failure)
    class(map_press_solver), intent(in) :: self
    type(position_result), intent(inout) :: result
    character(len=:), allocatable, intent(out) :: failure
    integer :: i, states

    if (self%fields == fields_none) return
    states = merge(self%states, 1, self%fields == fields_all)
    if (.not. has_memory(room_to_press(self%map) + room_of_fields(self%work, states))) then
      failure = not_enough_memory // ' for the fields of ' // decimal_text(states) // ' states'
      if (states == 1) failure = failure(:len(failure) - 1)
      if (states > 1) failure = failure // ', expected those of the last state alone'
      return
    end if
    allocate (result%fields(states))
    do i = 1, states
      result%fields(i)%unit = self%unit
    end do
  end subroutine make_room_for_fields

  ! Warns of patches beyond yield or the limit.
  pure subroutine warn_of_patches(self, patches, warnings)
    type(map_press_solver), intent(in) :: self
    type(map_patch), intent(in) :: patches(:)
    type(theory_warning), allocatable, intent(inout) :: warnings(:)
    real(real64), parameter :: peak = 1.5_real64  ! greatest over average pressure of Hertz
    integer :: i

    do i = 1, size(patches)
      call look_at_pressure(self%limits, patches(i)%mean, patches(i)%highest / peak, &
                            patches(i)%load, warnings)
    end do
  end subroutine warn_of_patches

  ! Sets the results of one state and its contact patches.
  subroutine fill_state(self, history, answer, patches, load, keep_rows, result, number)
    class(map_press_solver), intent(in) :: self
    type(map_history), intent(in) :: history  ! with the residual shape of the map
    type(map_answer), intent(in) :: answer
    type(map_patch), intent(in) :: patches(:)
    real(real64), allocatable, intent(in) :: load  ! prescribed; not allocated: the separation is
    logical, intent(in) :: keep_rows
    type(position_result), intent(inout) :: result
    integer, intent(in) :: number
    type(contact_row) :: rows(size(patches))
    type(state_row) :: state
    integer :: i

    state%time = self%times(number)
    if (allocated(load)) then
      state%prescribed = prescribed_normal
      state%prescribed_load = load
    end if
    state%approach = answer%level
    state%closing = maxval(self%map%height) - answer%level
    state%contacts = size(patches)
    state%load = answer%load
    state%vertical_load = answer%load
    state%area = sum(patches%area)
    state%projected_area = state%area
    state%greatest_pressure = maxval([0.0_real64, patches%highest])
    call measure_fields(history%deformed, answer, state)
    if (allocated(self%laws%hardness)) then
      state%plastic_area = product(self%map%pixel_spacing) * &
        count(.not. answer%pressure < self%laws%hardness)
      state%dissipated_work = history%plastic_work
    end if
    do i = 1, size(patches)
      associate (row => rows(i), patch => patches(i))
        row%area_no = i
        row%upper = 0
        row%lower = i
        row%x = patch%x
        row%y = patch%y
        row%area = patch%area
        row%projected_area = patch%area
        row%slope = 0.0_real64
        row%load = patch%load
        row%vertical_load = patch%load
        row%average_pressure = patch%mean
        row%maximum_pressure = patch%highest
        row%penetration = patch%top - answer%level
        row%limit_exceeded = is_patch_at_limit(self%limit, row%load, row%average_pressure, &
                                               row%maximum_pressure)
      end associate
    end do
    result%limit_reached = any(rows%limit_exceeded)
    if (keep_rows) call add_rows(result, rows, state)
    result%states(number) = state
  end subroutine fill_state

end module asperity_map_press_solver
