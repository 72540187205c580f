!> Solves a scene on the pixels of its map, state by state; contact patches are its contacts.
module asperity_map_press_solver
  use asperity_contact_field, only: contact_field, fields_all, fields_none, room_of_fields
  use asperity_contact_records, only: add_rows, contact_row, position_result, prescribed_normal, &
                                      state_row
  use asperity_decimal, only: decimal_to_real64
  use asperity_height_map, only: height_map
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_map_contact, only: map_answer, most_load, press_map, room_to_press
  use asperity_map_error, only: estimate_pixel_errors, is_rough_at_pixels, pixel_errors
  use asperity_map_fields, only: measure_fields, take_field
  use asperity_map_form, only: find_form_contact
  use asperity_map_interface, only: interface_columns, interface_powers, measure_interface
  use asperity_map_levelling, only: is_flat
  use asperity_map_patches, only: find_patches, map_patch
  use asperity_map_scene, only: map_loading
  use asperity_map_shares, only: find_shares, map_shares, warn_of_shares
  use asperity_partial_slip, only: slip_answer, slip_of_patches, slip_request, solve_partial_slip, &
                                   take_traction
  use asperity_position_solver, only: position_solver
  use asperity_problems, only: decimal_text, not_enough_memory, real_text
  use asperity_process, only: has_memory
  use asperity_scene_results, only: effect_header
  use asperity_scene_values, only: effect_off, has_hardness, scene, scene_limit
  use asperity_slip_columns, only: slip_contact_columns, slip_contact_powers, &
                                   slip_state_columns, slip_state_powers, stiffness_ratio_of
  use asperity_theory_limits, only: is_patch_at_limit, look_at_pressure, set_theory_limits, &
                                    theory_limits
  use asperity_theory_warnings, only: of_error, of_flat_map, of_resolution, take_worse, &
                                      theory_warning, add_warning, warning_kinds
  implicit none
  private

  public :: make_map_solver, name_map_columns

  ! Tolerance of the largest load at the hardness, for rounding.
  real(real64), parameter :: load_rounding = 1.0e-12_real64

  !> Solver of a map.
  type, extends(position_solver) :: map_press_solver
    private
    type(height_map), pointer :: map => null()
    type(map_loading) :: loading
    real(real64) :: tolerance = 0.0_real64
    real(real64), allocatable :: hardness        ! largest pressure; not allocated: elastic
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
  subroutine make_map_solver(scene_in, map, loading, fields, solver)
    type(scene), intent(in) :: scene_in               !! scene with a map, checked
    type(height_map), intent(in), target :: map       !! levelled map; must outlive the solver
    type(map_loading), intent(in) :: loading          !! loads or levels of the map
    integer, intent(in) :: fields                     !! `fields_none`, `fields_last`, `fields_all`
    class(position_solver), allocatable, intent(out) :: solver
    type(map_press_solver), allocatable :: new

    allocate (new)
    new%map => map
    new%loading = loading
    new%tolerance = scene_in%effects%number('tolerance')
    if (has_hardness(scene_in)) new%hardness = scene_in%effects%number('plastic_hardness')
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
    new%states = size(loading%values)
    new%work = int(map%columns, int64) * map%rows
    call move_alloc(new, solver)
  end subroutine make_map_solver

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
    if (.not. has_hardness(scene_in)) return
    header%names = [character(len=11) :: header%names, 'plasticity']
    header%modes = [header%modes, scene_in%effects%mode('plasticity')]
    header%hardness = scene_in%effects%number('plastic_hardness')
    header%state_columns = [character(len=24) :: header%state_columns, 'plastic_area', &
                            'dissipated_work']
    header%state_powers = reshape([header%state_powers, 0, 2, 1, 3], &
                                  [2, size(header%state_columns)])
  end subroutine name_map_columns

  ! Solves state after state, each the start of the next. With a hardness each state deforms the
  ! map: pixels at the hardness are lowered by the remaining overlap, at the same pressure.
  subroutine press_to_states(self, m, keep_rows, result, failure)
    class(map_press_solver), intent(in) :: self
    integer, intent(in) :: m
    logical, intent(in) :: keep_rows
    type(position_result), intent(out) :: result
    character(len=:), allocatable, intent(out) :: failure
    type(map_answer) :: answer
    type(height_map), allocatable, target :: deformed
    type(height_map), pointer :: pressed
    type(map_patch), allocatable :: patches(:)
    type(map_shares) :: shares
    type(theory_warning), allocatable :: warnings(:)
    real(real64), allocatable :: samples(:)
    real(real64) :: other_errors(3), spike_limit, work
    integer :: i

    spike_limit = -1.0_real64
    call make_room_for_fields(self, result, failure)
    if (allocated(failure)) return
    allocate (result%states(self%states), result%rows(0), samples(0))
    pressed => self%map
    work = 0.0_real64
    if (allocated(self%hardness)) then
      allocate (deformed, source=self%map)
      pressed => deformed
      associate (most => most_load(self%map, self%hardness))
        if (self%loading%by_load .and. &
            maxval(self%loading%values) > most * (1.0_real64 + load_rounding)) then
          failure = 'the load is above plastic_hardness times the measured area: found ' // &
                    real_text(maxval(self%loading%values)) // ', expected at most ' // &
                    real_text(most)
          return
        end if
      end associate
    end if
    answer%interrupt = self%interrupt
    do i = m, self%states
      if (self%loading%by_load .and. self%loading%values(i) > 0.0_real64) then
        call press_map(pressed, self%loading%modulus, answer, &
                       self%loading%values(i), hardness=self%hardness)
      else
        answer%level = maxval(pressed%height)
        if (.not. self%loading%by_load) answer%level = self%loading%values(i)
        call press_map(pressed, self%loading%modulus, answer, hardness=self%hardness)
      end if
      if (allocated(answer%failure)) then
        failure = answer%failure
        return
      end if
      if (allocated(deformed)) call deform_map(self%hardness, answer, deformed, work)
      call find_patches(self%map, answer%pressure, patches, hardness=self%hardness)
      call find_shares(self%map, answer%pressure, patches, self%tolerance, spike_limit, shares)
      if (allocated(warnings)) deallocate (warnings)
      call warn_of_shares(shares, self%tolerance, warnings)
      if (is_flat(self%map)) call add_warning(warnings, of_flat_map, 0.0_real64)
      call warn_of_patches(self, patches, warnings)
      call fill_state(self, pressed, answer, patches, work, keep_rows, result, i)
      if (i == self%states) &
        call estimate_errors(self, answer, patches, result, other_errors, warnings)
      call take_worse(result%warnings, warnings, i)
      if (self%fields == fields_all .or. (self%fields /= fields_none .and. i == self%states)) &
        call take_field(pressed, answer, i, result%fields(i - self%states + size(result%fields)))
      if (keep_rows) samples = [samples, real(patches%samples, real64)]
      call self%progress_count%count_state(result%counted)
    end do
    result%state_values = [count(answer%pressure > 0.0_real64) * &
                           [1.0_real64, product(self%map%pixel_spacing)], other_errors]
    if (allocated(self%slip)) then
      call add_slip(self, pressed, answer, samples, result, failure)
      if (allocated(failure)) return
    else
      result%contact_values = reshape(samples, [size(samples), 1])
    end if
    call add_last_columns(self, pressed, answer, work, result)
    allocate (result%effects(1 + count([allocated(self%slip), allocated(self%hardness)])))
    result%effects%simulated = 'on'
    result%effects(1)%simulated = 'boundary'
    result%effects%why = 'on the pixels of the map'
    result%effects%ending = answer%ending
  end subroutine press_to_states

  ! Adds the columns of the interface, of the smooth form and of a hardness.
  subroutine add_last_columns(self, pressed, answer, work, result)
    class(map_press_solver), intent(in) :: self
    type(height_map), intent(in) :: pressed    ! map with the residual shape
    type(map_answer), intent(in) :: answer
    real(real64), intent(in) :: work           ! dissipated
    type(position_result), intent(inout) :: result
    real(real64) :: of_interface(size(interface_columns)), smooth(2)

    call measure_interface(pressed, self%loading%modulus, answer%pressure, of_interface, &
                           self%hardness)
    result%state_values = [result%state_values, of_interface]
    if (any(self%form_radius > 0.0_real64)) then
      call find_form_contact(self%form_radius, answer%load, self%loading%modulus, &
                             length_of_cylinder(self), smooth(1), smooth(2))
      result%state_values = [result%state_values, smooth]
    end if
    if (allocated(self%hardness)) result%state_values = [result%state_values, &
      result%states(self%states)%plastic_area, work]
  end subroutine add_last_columns

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
  ! hardness they are known at the largest load of the path, where its history does not matter.
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
    if (size(patches) == 0) return
    associate (state => result%states(self%states))
      if (.not. allocated(self%hardness) .or. &
          answer%load >= maxval(result%states%load) * (1.0_real64 - load_rounding)) &
        call estimate_pixel_errors(self%map, self%loading%modulus, answer, patches, state, &
                                   self%loading%by_load, errors, self%hardness)
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

  ! Lowers the pixels at the hardness by the overlap of the surfaces there, and adds its work.
  subroutine deform_map(hardness, answer, map, work)
    real(real64), intent(in) :: hardness      ! largest pressure
    type(map_answer), intent(in) :: answer    ! solution of this map with its displacement
    type(height_map), intent(inout) :: map    ! measured pixels may sink
    real(real64), intent(inout) :: work       ! [force length], grows
    real(real64) :: overlap
    integer :: i, j

    do j = 1, map%rows
      do i = 1, map%columns
        if (answer%pressure(i, j) < hardness) cycle
        overlap = max(0.0_real64, (map%height(i, j) - answer%level) - answer%displacement(i, j))
        map%height(i, j) = map%height(i, j) - overlap
        work = work + hardness * overlap * product(map%pixel_spacing)
      end do
    end do
  end subroutine deform_map

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
  subroutine fill_state(self, deformed, answer, patches, work, keep_rows, result, number)
    class(map_press_solver), intent(in) :: self
    type(height_map), intent(in) :: deformed  ! map with the residual shape
    type(map_answer), intent(in) :: answer
    type(map_patch), intent(in) :: patches(:)
    real(real64), intent(in) :: work          ! dissipated
    logical, intent(in) :: keep_rows
    type(position_result), intent(inout) :: result
    integer, intent(in) :: number
    type(contact_row) :: rows(size(patches))
    type(state_row) :: state
    integer :: i

    state%time = 0.0_real64
    if (self%loading%by_load) then
      state%prescribed = prescribed_normal
      state%prescribed_load = self%loading%values(number)
    end if
    state%approach = answer%level
    state%closing = maxval(self%map%height) - answer%level
    state%contacts = size(patches)
    state%load = answer%load
    state%vertical_load = answer%load
    state%area = sum(patches%area)
    state%projected_area = state%area
    state%greatest_pressure = maxval([0.0_real64, patches%highest])
    call measure_fields(deformed, answer, state)
    if (allocated(self%hardness)) then
      state%plastic_area = product(self%map%pixel_spacing) * &
        count(.not. answer%pressure < self%hardness)
      state%dissipated_work = work
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
