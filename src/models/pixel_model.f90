!> A plane on the pixels of a height map, state by state; contact patches are its contacts.
!>
!> Each state is the start of the next. With a hardness each state deforms the map: pixels at the
!> hardness are lowered by the remaining overlap, at the same pressure.
module asperity_pixel_model
  use asperity_attraction_law, only: attraction_at
  use asperity_contact_field, only: fields_all, fields_none, room_of_fields
  use asperity_contact_model, only: at_distance, at_load, contact_model, held_load, no_load, &
                                    path_step, placed_bodies
  use asperity_contact_records, only: add_rows, contact_row, position_result, prescribed_normal, &
                                      state_row
  use asperity_friction, only: stiffness_ratio_of
  use asperity_height_map, only: height_map
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_map_caps, only: placed_caps
  use asperity_map_contact, only: map_answer, most_load, room_to_press
  use asperity_map_error, only: estimate_pixel_errors, growth_of_slope
  use asperity_map_fields, only: measure_fields, take_field
  use asperity_map_form, only: find_form_contact
  use asperity_map_interface, only: interface_columns, measure_interface
  use asperity_map_levelling, only: is_flat
  use asperity_map_patches, only: find_patches, map_patch
  use asperity_map_scene, only: area_of_map, displacement_of, join_maps, plan_map_path
  use asperity_map_shares, only: find_shares, map_shares, warn_of_map, warn_of_shares
  use asperity_map_adhesion, only: work_at_edge
  use asperity_map_state, only: map_history, map_laws, solve_map_state
  use asperity_partial_slip, only: slip_answer, slip_of_patches, slip_request, solve_partial_slip, &
                                   take_traction
  use asperity_path_steps, only: plan_hold
  use asperity_pixel_effects, only: name_map_columns, resolved_steepness, set_map_laws, steepest
  use asperity_problems, only: decimal_text, not_enough_memory, real_text
  use asperity_process, only: has_memory
  use asperity_effect_header, only: effect_header
  use asperity_scene_values, only: effect_off, is_load, scene
  use asperity_theory_limits, only: is_patch_at_limit, look_at_pressure, set_theory_limits, &
                                    theory_limits
  use asperity_theory_warnings, only: add_warning, of_attraction, of_cap, of_contact_radius, &
                                      of_cut_range, of_error, of_flat_map, of_held_gap, &
                                      of_map_pressure, of_resolution, take_worse, &
                                      theory_warning, warn_above
  implicit none
  private

  public :: make_pixel_model

  ! Tolerance of the largest load at the hardness, for rounding.
  real(real64), parameter :: load_rounding = 1.0e-12_real64

  !> One map, or two that are moved over each other.
  type, extends(contact_model) :: pixel_model
    private
    type(scene), pointer :: scene_in => null()
    type(height_map) :: first_map                ! at the first position, levelled
    real(real64) :: origin(2) = 0.0_real64       ! its first pixel from that of the lower map
    type(placed_caps) :: caps                    ! asperities of a table on it
    real(real64) :: tolerance = 0.0_real64
    type(map_laws) :: laws                       ! what acts on the pixels
    logical :: has_adhesion = .false.            ! columns of adhesion
    real(real64) :: steepness = 0.0_real64       ! of the attraction over a pixel
    type(slip_request), allocatable :: slip      ! tangential load; not allocated: no friction
    type(theory_limits) :: limits
    integer :: fields = fields_none              ! which states keep pressure and gap
    character(len=:), allocatable :: unit        ! unit of length; empty: unknown
  contains
    procedure :: place => place_map  !! places the map at a position
  end type pixel_model

  ! A map at one position, in its last state.
  type, extends(placed_bodies) :: pixel_bodies
    class(pixel_model), pointer :: model => null()
    type(height_map), allocatable :: moved       ! not at the first position: the map here
    type(placed_caps) :: caps                    ! asperities of a table on it
    type(map_history) :: history                 ! residual shape, and what the state leaves
    type(height_map), pointer :: map => null()   ! without deformation
    type(map_answer) :: answer                   ! pressures of the last state
    type(map_patch), allocatable :: patches(:)   ! its contact patches
    real(real64), allocatable :: samples(:)      ! pixels of the patches of all states kept
    real(real64) :: origin(2) = 0.0_real64       ! first pixel of the map from that of the lower one
    real(real64) :: spike_limit = -1.0_real64    ! of outliers of the map; below 0: unknown
    real(real64), allocatable :: load            ! prescribed; not allocated: the separation is
    real(real64) :: held = 0.0_real64            ! load of the last state of loading
    integer :: states = 0                        ! number of states
  contains
    procedure :: list_steps => list_pixel_steps
    procedure :: solve_step => solve_pixel_step
    procedure :: add_totals => add_pixel_totals
  end type pixel_bodies

contains

  !> Makes the model of a scene with a map.
  subroutine make_pixel_model(scene_in, fields, model, header, failure)
    type(scene), intent(in), target :: scene_in  !! with a map, checked; must outlive the model
    integer, intent(in) :: fields                !! `fields_none`, `fields_last`, `fields_all`
    class(contact_model), allocatable, intent(out) :: model
    type(effect_header), intent(out) :: header   !! columns of the effects
    character(len=:), allocatable, intent(out) :: failure  !! reason, when memory is short
    type(pixel_model), allocatable :: new
    type(path_step), allocatable :: steps(:)

    allocate (new)
    new%scene_in => scene_in
    call join_maps(scene_in, 1, new%first_map, new%origin, failure, new%caps)
    if (allocated(failure)) return
    call name_map_columns(scene_in, header)
    header%tolerance = scene_in%effects%number('tolerance')
    new%tolerance = header%tolerance
    call set_map_laws(scene_in, maxval(new%first_map%pixel_spacing), new%laws, new%steepness, &
                      failure)
    new%has_adhesion = scene_in%effects%mode('adhesion') /= effect_off
    if (allocated(failure)) return
    if (scene_in%effects%mode('friction') /= effect_off) then
      allocate (new%slip)
      new%slip%coefficient = scene_in%effects%number('friction_coefficient')
      new%slip%kappa = stiffness_ratio_of(scene_in)
      associate (loading => scene_in%loading)
        new%slip%by_load = .not. abs(loading%tangential_displacement) > 0.0_real64
        new%slip%given = merge(loading%tangential_load, loading%tangential_displacement, &
                                                 new%slip%by_load)
      end associate
    end if
    call set_theory_limits(scene_in, 0, 0, new%limits)
    new%fields = fields
    new%unit = trim(scene_in%units(1))
    if (new%unit == '' .and. allocated(new%first_map%unit)) new%unit = trim(new%first_map%unit)
    new%positions = scene_in%motion%positions
    call plan_map_path(scene_in, new%first_map, steps, failure)
    if (allocated(failure)) return
    new%states = size(steps)
    new%work = size(new%first_map%height, kind=int64)
    ! The window of free maps changes with the displacement.
    if (new%positions == 1 .or. new%first_map%periodic) &
      new%nominal_area = area_of_map(new%first_map)
    call move_alloc(new, model)
  end subroutine make_pixel_model

  ! Places the map at a position.
  subroutine place_map(self, m, is_wide, bodies, result, failure)
    class(pixel_model), intent(in), target :: self
    integer, intent(in) :: m
    logical, intent(in) :: is_wide
    class(placed_bodies), allocatable, intent(out) :: bodies
    type(position_result), intent(out) :: result
    character(len=:), allocatable, intent(out) :: failure
    type(pixel_bodies), allocatable :: placed
    real(real64) :: displacement(2)

    associate (unused => is_wide)
    end associate
    displacement = displacement_of(self%scene_in%motion, m)
    result%x_displacement = displacement(1)
    result%y_displacement = displacement(2)
    allocate (placed)
    placed%model => self
    placed%origin = self%origin
    if (m == 1) then
      placed%caps = self%caps
    else
      allocate (placed%moved)
      call join_maps(self%scene_in, m, placed%moved, placed%origin, failure, placed%caps)
      if (allocated(failure)) return
    end if
    placed%answer%interrupt = self%interrupt
    allocate (placed%samples(0))
    call move_alloc(placed, bodies)
  end subroutine place_map

  ! Lists the states of the path.
  subroutine list_pixel_steps(self, steps, failure)
    class(pixel_bodies), intent(inout), target :: self
    type(path_step), allocatable, intent(out) :: steps(:)
    character(len=:), allocatable, intent(out) :: failure
    type(path_step), allocatable :: hold(:)
    real(real64) :: most
    integer :: kept

    self%map => self%model%first_map
    if (allocated(self%moved)) self%map => self%moved
    self%history%deformed = self%map
    associate (model => self%model, map => self%map)
      call plan_map_path(model%scene_in, map, steps, failure)
      if (allocated(failure)) return
      if (allocated(model%laws%hardness) .and. is_load(model%scene_in%loading%control)) then
        most = most_load(map, model%laws%hardness)
        if (maxval(steps%value) > most * (1.0_real64 + load_rounding)) &
          failure = 'the load is above plastic_hardness times the measured area: found ' // &
                    real_text(maxval(steps%value)) // ', expected at most ' // real_text(most)
      end if
      if (allocated(failure)) return
      if (allocated(model%laws%solid)) then
        call plan_hold(model%scene_in, hold)
        steps = [steps, hold]
      end if
      self%states = size(steps)
      kept = merge(self%states, 1, model%fields == fields_all)
      if (model%fields == fields_none .or. has_memory( &
          room_to_press(model%first_map) + room_of_fields(model%work, kept))) return
      failure = not_enough_memory // ' for the fields of ' // decimal_text(kept) // ' state'
      if (kept > 1) failure = failure // 's, expected those of the last state alone'
    end associate
  end subroutine list_pixel_steps

  ! Solves a state and adds it to the results, with the warnings of its patches and its fields.
  subroutine solve_pixel_step(self, step, number, result, must_repeat, failure)
    class(pixel_bodies), intent(inout), target :: self
    type(path_step), intent(in) :: step
    integer, intent(in) :: number
    type(position_result), intent(inout) :: result
    logical, intent(out) :: must_repeat
    character(len=:), allocatable, intent(out) :: failure
    type(map_shares) :: shares
    type(theory_warning), allocatable :: warnings(:)
    real(real64) :: cut
    integer :: i

    must_repeat = .false.
    if (allocated(self%load)) deallocate (self%load)
    if (step%control == at_load) self%load = step%value
    ! Without a load open surfaces stay where they are.
    if (step%control == held_load .and. .not. (self%answer%level > &
        maxval(self%history%deformed%height) .and. abs(self%held) <= 0.0_real64)) &
      self%load = self%held
    if (step%control == at_distance) self%answer%level = step%value
    call solve_map_state(self%model%laws, step%time, self%history, self%answer, self%load)
    if (allocated(self%answer%failure)) then
      failure = self%answer%failure
      return
    end if
    if (step%control /= held_load) self%held = self%answer%load
    associate (model => self%model, map => self%map, answer => self%answer)
      call list_patches(self, shares)
      call warn_of_shares(shares, model%tolerance, warnings)
      if (is_flat(map)) call add_warning(warnings, of_flat_map, 0.0_real64)
      call warn_of_patches(self, warnings)
      if (model%steepness > resolved_steepness) &
        call add_warning(warnings, of_attraction, model%steepness / resolved_steepness)
      if (allocated(model%laws%attraction)) then
        if (map%periodic .and. number > 1 .and. .not. allocated(self%load)) &
          call add_warning(warnings, of_held_gap, real(number, real64))
        cut = work_at_edge(map, model%laws%attraction, self%history%adhesion%attraction)
        if (cut > model%tolerance) call add_warning(warnings, of_cut_range, cut)
      end if
      call take_worse(result%warnings, warnings, number)
      call fill_state(self, step, result, number)
      if (self%keep_rows) self%samples = [self%samples, real(self%patches%samples, real64)]
      if (model%fields == fields_none .or. &
          (model%fields /= fields_all .and. number < self%states)) return
      if (.not. allocated(result%fields)) then
        allocate (result%fields(merge(self%states, 1, model%fields == fields_all)))
        do i = 1, size(result%fields)
          result%fields(i)%unit = model%unit
        end do
      end if
      call take_field(self%history%deformed, answer, number, &
                      result%fields(number - self%states + size(result%fields)))
    end associate
  end subroutine solve_pixel_step

  ! Adds the columns of the last state, its estimated errors, and the warnings of the map itself.
  subroutine add_pixel_totals(self, steps, result, failure)
    class(pixel_bodies), intent(inout), target :: self
    type(path_step), intent(in) :: steps(:)
    type(position_result), intent(inout) :: result
    character(len=:), allocatable, intent(out) :: failure
    type(theory_warning), allocatable :: warnings(:)
    real(real64) :: other_errors(3)

    associate (model => self%model, map => self%map)
      associate (last => steps(size(steps)))
        call estimate_errors(self, last%load < no_load .or. last%control == held_load, result, &
                             other_errors, warnings)
      end associate
      call warn_of_map(map, model%tolerance, any(model%scene_in%map%form_radius > 0.0_real64), &
                       allocated(self%caps%rise), warnings)
      call take_worse(result%warnings, warnings, size(steps))
      result%state_values = [sum(self%patches%samples) * &
                             [1.0_real64, product(map%pixel_spacing)], other_errors]
      if (allocated(model%slip)) then
        call add_slip(self, result, failure)
        if (allocated(failure)) return
      else
        result%contact_values = reshape(self%samples, [size(self%samples), 1])
      end if
      call fill_effects(self, result)
    end associate
  end subroutine add_pixel_totals

  ! Finds the patches and shares of the contact pressure. Loads and pressures of the patches are
  ! then those of the net traction: on all pixels of a patch the attraction is that of contact.
  subroutine list_patches(self, shares)
    class(pixel_bodies), intent(inout) :: self
    type(map_shares), intent(out) :: shares
    real(real64) :: attraction

    associate (laws => self%model%laws, patches => self%patches, tolerance => self%model%tolerance)
      if (.not. allocated(laws%attraction)) then
        call find_patches(self%map, self%answer%pressure, self%patches, hardness=laws%hardness)
        call find_shares(self%map, self%answer%pressure, self%patches, tolerance, &
                         self%spike_limit, shares)
        return
      end if
      associate (pressure => self%history%adhesion%contact_pressure)
        call find_patches(self%map, pressure, self%patches)
        call find_shares(self%map, pressure, self%patches, tolerance, self%spike_limit, shares)
      end associate
      attraction = attraction_at(laws%attraction, 0.0_real64)
    end associate
    associate (patches => self%patches)
      patches%load = patches%load - &
                     attraction * patches%samples * product(self%map%pixel_spacing)
      patches%highest = patches%highest - attraction
      patches%mean = min(patches%load / patches%area, patches%highest)
    end associate
  end subroutine list_patches

  ! Sets the records of the effects and their columns of the last state.
  subroutine fill_effects(self, result)
    class(pixel_bodies), intent(in) :: self
    type(position_result), intent(inout) :: result
    real(real64) :: length, of_interface(size(interface_columns)), smooth(2)
    real(real64), allocatable :: pressure(:, :)
    integer :: axis, i

    associate (answer => self%answer, laws => self%model%laws, map => self%map, &
               patches => self%patches, form => self%model%scene_in%map%form_radius, &
               last => result%states(self%states))
      allocate (pressure, source=answer%pressure)
      if (allocated(answer%touches)) &
        pressure = merge(max(pressure, tiny(pressure)), 0.0_real64, answer%touches)
      call measure_interface(self%history%deformed, laws%modulus, pressure, of_interface, &
                             laws%hardness)
      result%state_values = [result%state_values, of_interface]
      do i = 1, 2
        associate (both => self%model%scene_in%conductivity(:, i))
          if (all(both > 0.0_real64)) result%state_values = [result%state_values, &
            max(not_computed, of_interface(3) * (product(both) / sum(both)))]
        end associate
      end do
      if (any(form > 0.0_real64)) then
        ! Length of the contact of a cylinder: that of a period along its axis; 0: its end is free.
        axis = minloc(form, 1)
        length = 0.0_real64
        if (map%repeats(axis)) length = map%pixel_spacing(axis) * size(map%height, axis)
        call find_form_contact(form, max(answer%load, 0.0_real64), laws%modulus, length, &
                               smooth(1), smooth(2))
        result%state_values = [result%state_values, smooth]
      end if
      if (allocated(laws%hardness)) &
        result%state_values = [result%state_values, last%plastic_area, last%dissipated_work]
      if (self%model%has_adhesion) result%state_values = [result%state_values, &
        real(size(patches), real64), real(count(patches%load < 0.0_real64), real64), &
        max(0.0_real64, sum(patches%load) - answer%load)]
      if (allocated(laws%solid)) result%state_values = [result%state_values, last%time, &
        product(map%pixel_spacing) * sum(self%history%creep%elastic)]
      allocate (result%effects(1 + count([allocated(self%model%slip), allocated(laws%hardness), &
                                          self%model%has_adhesion, allocated(laws%solid)])))
      result%effects%simulated = 'on'
      result%effects(1)%simulated = 'boundary'
      result%effects%why = 'on the pixels of the map'
      result%effects%ending = answer%ending
    end associate
  end subroutine fill_effects

  ! Solves partial slip at the last state and adds its columns and its traction.
  subroutine add_slip(self, result, failure)
    class(pixel_bodies), intent(in), target :: self
    type(position_result), intent(inout) :: result
    character(len=:), allocatable, intent(out) :: failure
    type(slip_answer) :: slip
    real(real64), allocatable :: load(:), stick_area(:), values(:, :)

    call solve_partial_slip(self%history%deformed, self%model%laws%modulus, self%model%slip, &
                            self%answer, slip, failure)
    if (allocated(failure)) return
    result%state_values = [result%state_values, slip%load, slip%displacement, slip%stiffness, &
                           slip%stick_area, merge(1.0_real64, 0.0_real64, slip%slides)]
    associate (samples => self%samples)
      allocate (values(size(samples), 3), source=not_computed)
      values(:, 1) = samples
      if (size(samples) > 0) then
        call slip_of_patches(self%history%deformed, self%answer, slip, load, stick_area)
        values(size(samples) - size(load) + 1:, 2) = load
        values(size(samples) - size(load) + 1:, 3) = stick_area
      end if
    end associate
    call move_alloc(values, result%contact_values)
    if (self%model%fields /= fields_none) &
      call take_traction(self%history%deformed, slip, result%fields(size(result%fields)))
  end subroutine add_slip

  ! Estimates the errors of the last state by the size of the pixels, and warns of them. With a
  ! hardness they are known at the largest load of the path, where its history does not matter: not
  ! beside creep. With adhesion they are known where pixels twice as wide resolve it, and not under
  ! a pull that is prescribed: wider pixels may not carry it.
  subroutine estimate_errors(self, by_load, result, other_errors, warnings)
    class(pixel_bodies), intent(in), target :: self
    logical, intent(in) :: by_load  ! the load is prescribed
    type(position_result), intent(inout) :: result
    ! Relative errors of area, mean gap and greatest pressure; `not_computed`: unknown.
    real(real64), intent(out) :: other_errors(3)
    type(theory_warning), allocatable, intent(inout) :: warnings(:)
    character(len=:), allocatable :: unsolved
    real(real64) :: area_error
    character(len=32) :: whose

    other_errors = not_computed
    if (size(self%patches) == 0) return
    associate (laws => self%model%laws)
      if (allocated(laws%solid) .and. (allocated(laws%hardness) .or. allocated(laws%attraction))) &
        return
      if (allocated(laws%attraction) .and. (2.0_real64 * self%model%steepness > steepest .or. &
          (by_load .and. .not. self%answer%load > 0.0_real64))) return
    end associate
    associate (state => result%states(self%states), answer => self%answer, model => self%model)
      if (.not. allocated(model%laws%hardness) .or. &
          answer%load >= maxval(result%states%load) * (1.0_real64 - load_rounding)) &
        call estimate_pixel_errors(self%map, model%laws, self%history, answer, self%patches, &
                                   state, by_load, result%error_estimate, other_errors, unsolved)
    end associate
    if (allocated(unsolved)) result%no_estimate = unsolved
    if (result%error_estimate > self%model%tolerance) &
      call add_warning(warnings, of_error, result%error_estimate)
    area_error = max(0.5_real64 * sum(self%patches%rim) / sum(self%patches%area), other_errors(1))
    whose = ''
    if (growth_of_slope(self%map) > 0.0_real64) whose = 'it is rough at their size'
    call warn_above(warnings, of_resolution, area_error, whose=whose)
  end subroutine estimate_errors

  ! Warns of patches beyond yield or the limit, of strains beyond the linear theory, and of contacts
  ! that are wide for their asperity, or reach its base plane.
  subroutine warn_of_patches(self, warnings)
    class(pixel_bodies), intent(in), target :: self
    type(theory_warning), allocatable, intent(inout) :: warnings(:)
    real(real64), parameter :: peak = 1.5_real64  ! greatest over average pressure of Hertz
    real(real64) :: below
    integer :: i

    associate (patches => self%patches)
      call warn_above(warnings, of_map_pressure, &
                      maxval([0.0_real64, patches%highest]) / self%model%laws%modulus)
      do i = 1, size(patches)
        call look_at_pressure(self%model%limits, patches(i)%mean, patches(i)%highest / peak, &
                              patches(i)%load, warnings)
      end do
    end associate
    if (.not. allocated(self%caps%rise)) return
    associate (caps => self%caps, is_loaded => self%answer%pressure > 0.0_real64)
      call warn_above(warnings, of_contact_radius, &
                      maxval([0.0_real64, pack(caps%slope, is_loaded)]))
      below = maxval([0.0_real64, pack(self%map%height - caps%rise, is_loaded) - &
                      self%answer%level]) / caps%radius
    end associate
    if (below > 0.0_real64) call add_warning(warnings, of_cap, below)
  end subroutine warn_of_patches

  ! Sets the results of one state and its contact patches.
  subroutine fill_state(self, step, result, number)
    class(pixel_bodies), intent(in), target :: self
    type(path_step), intent(in) :: step
    type(position_result), intent(inout) :: result
    integer, intent(in) :: number
    type(contact_row) :: rows(size(self%patches))
    type(state_row) :: state
    integer :: i

    state%time = step%time
    if (allocated(self%load)) then
      state%prescribed = prescribed_normal
      state%prescribed_load = self%load
    end if
    associate (answer => self%answer, patches => self%patches, map => self%map)
      state%approach = answer%level
      state%compression = maxval(map%height) - answer%level
      state%contacts = size(patches)
      state%load = answer%load
      state%vertical_load = answer%load
      state%area = sum(patches%area)
      state%projected_area = state%area
      state%greatest_pressure = maxval([0.0_real64, patches%highest])
      call measure_fields(self%history%deformed, answer, state)
      if (allocated(self%model%laws%hardness)) then
        state%plastic_area = product(map%pixel_spacing) * &
          count(.not. answer%pressure < self%model%laws%hardness)
        state%dissipated_work = self%history%plastic_work
      end if
      ! Places are from the first pixel of the lower map; a patch that spans the map has none.
      do i = 1, size(patches)
        associate (row => rows(i), patch => patches(i))
          row = contact_row( &
            area_no=i, upper=0, lower=i, &
            x=patch%x + merge(self%origin(1), 0.0_real64, patch%x > not_computed), &
            y=patch%y + merge(self%origin(2), 0.0_real64, patch%y > not_computed), &
            area=patch%area, projected_area=patch%area, slope=0.0_real64, load=patch%load, &
            vertical_load=patch%load, average_pressure=patch%mean, &
            maximum_pressure=patch%highest, penetration=patch%top - answer%level)
          row%limit_exceeded = is_patch_at_limit(self%model%scene_in%limit, row%load, &
                                                 row%average_pressure, row%maximum_pressure)
        end associate
      end do
    end associate
    result%limit_reached = any(rows%limit_exceeded)
    if (self%keep_rows) call add_rows(result, rows, state)
    result%states(number) = state
  end subroutine fill_state

end module asperity_pixel_model
