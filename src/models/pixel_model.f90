!> A plane on the pixels of a height map, state by state; contact patches are its contacts.
!>
!> Each state is the start of the next. A path is followed without the effects of `auto`; each state
!> estimates them. Where one is called for the path is repeated with it, from the last pressures.
module asperity_pixel_model
  use asperity_asperity_records, only: error_of_share
  use asperity_contact_field, only: fields_all, fields_none, room_of_fields
  use asperity_contact_model, only: at_distance, at_load, contact_model, held_load, no_load, &
                                    path_step, placed_bodies
  use asperity_contact_records, only: add_rows, contact_row, effect_record, position_result, &
                                      prescribed_normal, state_row
  use asperity_effect_header, only: add_effect, area, begin_header, column_list, effect_header, &
                                    length, plain
  use asperity_effect_list, only: list_pixel_laws
  use asperity_effect_names, only: known_effects, of_interaction
  use asperity_friction, only: shared_poisson_ratio
  use asperity_height_map, only: height_map
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_map_caps, only: placed_caps
  use asperity_map_contact, only: most_load, room_to_press
  use asperity_map_error, only: add_column_errors, error_request, estimate_pixel_errors, &
                                find_first_contact
  use asperity_map_fields, only: measure_fields, take_field
  use asperity_map_form, only: find_form_contact
  use asperity_map_levelling, only: is_flat
  use asperity_map_rims, only: share_at_ends
  use asperity_map_scene, only: area_of_map, displacement_of, join_maps, plan_map_path
  use asperity_map_shares, only: find_shares, map_shares, warn_of_map, warn_of_shares
  use asperity_path_steps, only: plan_hold
  use asperity_pixel_law, only: patches_in_contact, pixel_law_box, pixel_state, unknown_influence
  use asperity_pixel_sequence, only: add_state_interface, choose_laws, solve_pixel_state
  use asperity_problems, only: decimal_text, real_text
  use asperity_process, only: check_memory
  use asperity_scene_values, only: combined_modulus, effect_auto, has_tangential, is_compression, &
                                   is_load, scene
  use asperity_theory_limits, only: is_patch_at_limit, look_at_pressure, set_theory_limits, &
                                    theory_limits
  use asperity_theory_warnings, only: add_warning, of_barred, of_cap, of_contact_radius, &
                                      of_edge_pressure, of_error, of_flat_map, of_map_pressure, &
                                      of_not_estimated, of_off, of_resolution, take_worse, &
                                      theory_warning, warn_above
  implicit none
  private

  public :: make_pixel_model

  ! Residual of the elastic problem over the error of the load that is of use (chosen: the load then
  ! has 0.002 of that; test: times in test/bench/accuracy_promises.py).
  real(real64), parameter :: share_of_residual = 1.0e-2_real64
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
    real(real64) :: modulus = 0.0_real64         ! combined modulus
    real(real64) :: hardness = 0.0_real64        ! of the simulated laws; 0: none
    type(pixel_law_box), allocatable :: laws(:), left_out(:)  ! without memory
    type(theory_limits) :: limits
    real(real64) :: largest_error = 0.0_real64   ! of the load, above which results are not used
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
    type(height_map), pointer :: map => null()   ! without deformation
    type(pixel_law_box), allocatable :: laws(:), left_out(:)  ! with their memory
    real(real64), allocatable :: estimates(:), of_left_out(:)  ! of them, the largest of the states
    type(pixel_state) :: state                   ! the last state
    real(real64), allocatable :: samples(:)      ! pixels of the patches of all states kept
    real(real64) :: origin(2) = 0.0_real64       ! first pixel of the map from that of the lower one
    real(real64) :: spike_limit = -1.0_real64    ! of outliers of the map; below 0: unknown
    real(real64) :: held = 0.0_real64            ! load of the last state of loading
    real(real64) :: top = 0.0_real64             ! first contact: top of the map
    type(error_request) :: request               ! what errors depend on, with its error
    integer :: states = 0                        ! number of states
  contains
    procedure :: list_steps => list_pixel_steps
    procedure :: solve_step => solve_pixel_step
    procedure :: add_totals => add_pixel_totals
  end type pixel_bodies

contains

  !> Makes the model of a scene with a map.
  subroutine make_pixel_model(scene_in, fields, model, header, failure, largest_error)
    type(scene), intent(in), target :: scene_in  !! with a map, checked; must outlive the model
    integer, intent(in) :: fields                !! `fields_none`, `fields_last`, `fields_all`
    class(contact_model), allocatable, intent(out) :: model
    type(effect_header), intent(out) :: header   !! effects of the scene
    character(len=:), allocatable, intent(out) :: failure  !! reason, when there is no model
    !> Error of the load above which the results are not used, which then lack the columns of the
    !> interface; 0: they are all used.
    real(real64), intent(in) :: largest_error
    type(pixel_model), allocatable :: new
    type(path_step), allocatable :: steps(:)
    integer :: i

    allocate (new)
    new%scene_in => scene_in
    new%largest_error = largest_error
    call join_maps(scene_in, 1, new%first_map, new%origin, failure, new%caps)
    if (allocated(failure)) return
    new%tolerance = scene_in%effects%number('tolerance')
    new%modulus = combined_modulus(scene_in)
    call list_pixel_laws(scene_in, maxval(new%first_map%pixel_spacing), new%laws, new%left_out)
    call begin_header(header)
    header%tolerance = new%tolerance
    call add_effect(header, known_effects(of_interaction)%name, &
                    scene_in%effects%modes(of_interaction))
    do i = 1, size(new%laws)
      associate (law => new%laws(i)%law)
        call add_effect(header, law%name, law%mode)
        if (allocated(law%obstacle) .and. law%mode /= effect_auto) then
          failure = law%obstacle
          return
        end if
        new%hardness = max(new%hardness, law%hardness)
      end associate
    end do
    header%hardness = new%hardness
    call set_theory_limits(scene_in, 0, 0, new%limits)
    new%fields = fields
    new%unit = trim(scene_in%units(1))
    if (new%unit == '' .and. allocated(new%first_map%unit)) new%unit = trim(new%first_map%unit)
    new%positions = scene_in%motion%positions
    call plan_map_path(scene_in, new%first_map, .true., steps, failure)
    if (allocated(failure)) return
    new%states = size(steps)
    new%work = size(new%first_map%height, kind=int64)
    call move_alloc(new, model)
  end subroutine make_pixel_model

  ! Places the map at a position. A path is repeated with the laws that were called for, from the
  ! pressures of its last state.
  subroutine place_map(self, m, is_repeat, bodies, result, failure)
    class(pixel_model), intent(in), target :: self
    integer, intent(in) :: m
    logical, intent(in) :: is_repeat
    class(placed_bodies), allocatable, intent(inout) :: bodies
    type(position_result), intent(out) :: result
    character(len=:), allocatable, intent(out) :: failure
    type(pixel_bodies), allocatable :: placed
    real(real64) :: displacement(2)
    integer :: i

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
    allocate (placed%laws(size(self%laws)), placed%left_out(size(self%left_out)))
    do i = 1, size(self%laws)
      allocate (placed%laws(i)%law, source=self%laws(i)%law)
    end do
    do i = 1, size(self%left_out)
      allocate (placed%left_out(i)%law, source=self%left_out(i)%law)
    end do
    allocate (placed%estimates(size(self%laws)), placed%of_left_out(size(self%left_out)), &
              source=not_computed)
    placed%state%answer%interrupt = self%interrupt
    placed%state%modulus = self%modulus
    if (self%largest_error > 0.0_real64 .and. .not. any([(self%laws(i)%law%shapes, &
        i=1, size(self%laws))])) placed%state%tolerance = share_of_residual * self%largest_error
    allocate (placed%samples(0))
    if (is_repeat) then
      select type (before => bodies)
      type is (pixel_bodies)
        do i = 1, size(placed%laws)
          placed%laws(i)%law%is_simulated = before%laws(i)%law%is_simulated
          if (placed%laws(i)%law%is_simulated) placed%estimates(i) = before%estimates(i)
        end do
        call move_alloc(before%state%answer%pressure, placed%state%answer%pressure)
      end select
      deallocate (bodies)
    end if
    call move_alloc(placed, bodies)
  end subroutine place_map

  ! Lists the states of the path, with the hold of a law that acts in time.
  subroutine list_pixel_steps(self, steps, failure)
    class(pixel_bodies), intent(inout), target :: self
    type(path_step), allocatable, intent(out) :: steps(:)
    character(len=:), allocatable, intent(out) :: failure
    type(path_step), allocatable :: hold(:)
    real(real64) :: most
    logical :: in_time
    integer :: i, kept

    self%map => self%model%first_map
    if (allocated(self%moved)) self%map => self%moved
    self%state%deformed = self%map
    call find_first_contact(self%map, self%top, self%request)
    self%request%material = [self%model%modulus, shared_poisson_ratio(self%model%scene_in)]
    self%request%conductivity = self%model%scene_in%conductivity
    in_time = any([(self%laws(i)%law%acts_in_time .and. self%laws(i)%law%is_simulated, &
                    i=1, size(self%laws))])
    associate (model => self%model, map => self%map)
      call plan_map_path(model%scene_in, map, in_time, steps, failure)
      if (allocated(failure)) return
      if (model%hardness > 0.0_real64 .and. is_load(model%scene_in%loading%control)) then
        most = most_load(map, model%hardness)
        if (maxval(steps%value) > most * (1.0_real64 + load_rounding)) &
          failure = 'the load is above plastic_hardness times the measured area: found ' // &
                    real_text(maxval(steps%value)) // ', expected at most ' // real_text(most)
      end if
      if (allocated(failure)) return
      if (in_time) then
        call plan_hold(model%scene_in, hold)
        steps = [steps, hold]
      end if
      self%states = size(steps)
      kept = merge(self%states, 1, model%fields == fields_all)
      if (model%fields == fields_none) return
      ! The fields of a state are made where vectors of its solution were.
      call check_memory('the fields of ' // decimal_text(kept) // ' state', failure, &
                        bytes=room_to_press(model%first_map) - room_of_fields(model%work, 1) + &
                        room_of_fields(model%positions * model%work, kept))
      if (allocated(failure) .and. kept > 1) &
        failure = failure // 's, expected those of the last state alone'
    end associate
  end subroutine list_pixel_steps

  ! Solves a state and adds it to the results, with the warnings of its patches and its fields. The
  ! path has to be repeated where the state calls for a law.
  subroutine solve_pixel_step(self, step, number, result, must_repeat, failure)
    class(pixel_bodies), intent(inout), target :: self
    type(path_step), intent(in) :: step
    integer, intent(in) :: number
    type(position_result), intent(inout) :: result
    logical, intent(out) :: must_repeat
    character(len=:), allocatable, intent(out) :: failure
    type(map_shares) :: shares
    type(theory_warning), allocatable :: warnings(:)
    integer :: i

    must_repeat = .false.
    associate (state => self%state)
      if (allocated(state%load)) deallocate (state%load)
      if (step%control == at_load) state%load = step%value
      ! Without a load open surfaces stay where they are.
      if (step%control == held_load .and. .not. (state%answer%level > &
          maxval(state%deformed%height) .and. abs(self%held) <= 0.0_real64)) state%load = self%held
      if (step%control == at_distance) state%answer%level = step%value
      state%time = step%time
      state%number = number
      call solve_pixel_state(self%laws, state)
      if (allocated(state%answer%failure)) then
        failure = state%answer%failure
        return
      end if
      if (step%control /= held_load) self%held = state%answer%load
      state%largest_load = max(state%largest_load, state%answer%load)
    end associate
    call estimate_laws(self, number, must_repeat)
    if (must_repeat) return
    associate (model => self%model, map => self%map)
      call list_patches(self, shares)
      call warn_of_shares(map, shares, model%tolerance, warnings)
      if (is_flat(map)) call add_warning(warnings, of_flat_map, 0.0_real64)
      call warn_of_patches(self, warnings)
      do i = 1, size(self%laws)
        if (self%laws(i)%law%is_simulated) call self%laws(i)%law%add_warnings(self%state, warnings)
      end do
      call take_worse(result%warnings, warnings, number)
      call fill_state(self, result, number)
      call estimate_errors(self, step%load < no_load .or. step%control == held_load, number, result)
      if (self%keep_rows) &
        self%samples = [self%samples, real(self%state%patches%samples, real64)]
      if (number < self%states .and. model%fields == fields_all) &
        call keep_field(self, number, result)
    end associate
  end subroutine solve_pixel_step

  ! Keeps the field of a state.
  subroutine keep_field(self, number, result)
    class(pixel_bodies), intent(in) :: self
    integer, intent(in) :: number
    type(position_result), intent(inout) :: result
    integer :: i

    if (.not. allocated(result%fields)) then
      allocate (result%fields(merge(self%states, 1, self%model%fields == fields_all)))
      do i = 1, size(result%fields)
        result%fields(i)%unit = self%model%unit
        result%fields(i)%origin = self%origin
      end do
    end if
    call take_field(self%state%deformed, self%state%answer, number, &
                    result%fields(number - self%states + size(result%fields)))
  end subroutine keep_field

  ! Estimates the laws that are not simulated. Surfaces at first touch, where the path begins, have
  ! no load that an influence could be related to.
  subroutine estimate_laws(self, number, is_called)
    class(pixel_bodies), intent(inout) :: self
    integer, intent(in) :: number
    logical, intent(out) :: is_called  ! one of `auto` is called for
    integer :: i

    is_called = .false.
    if (number == 1 .and. self%states > 1 .and. .not. self%state%largest_load > 0.0_real64) return
    call choose_laws(self%laws, self%state, self%estimates, is_called)
    do i = 1, size(self%left_out)
      self%of_left_out(i) = max(self%of_left_out(i), self%left_out(i)%law%estimate(self%state))
    end do
  end subroutine estimate_laws

  ! Adds the columns of the last state, its estimated errors, and the warnings of the map itself.
  subroutine add_pixel_totals(self, steps, result, failure)
    class(pixel_bodies), intent(inout), target :: self
    type(path_step), intent(in) :: steps(:)
    type(position_result), intent(inout) :: result
    character(len=:), allocatable, intent(out) :: failure
    type(theory_warning), allocatable :: warnings(:)
    type(column_list) :: columns, of_contacts
    integer :: i

    associate (model => self%model, map => self%map, patches => self%state%patches, &
               last => result%states(size(steps)))
      call add_left_out(self, result, warnings)
      if (result%error_estimate > model%tolerance) &
        call add_warning(warnings, of_error, result%error_estimate)
      call warn_of_map(map, model%tolerance, any(model%scene_in%map%form_radius > 0.0_real64), &
                       allocated(self%caps%rise), warnings)
      call take_worse(result%warnings, warnings, size(steps))
      if (.not. model%nominal_area > 0.0_real64) result%nominal_area = area_of_map(map)
      call columns%add('samples_in_contact', plain, real(sum(patches%samples), real64))
      call columns%add('sample_area', area, sum(patches%samples) * product(map%pixel_spacing))
      call columns%add('area_error_estimate', plain, last%area_error)
      call columns%add('gap_error_estimate', plain, last%gap_error)
      call columns%add('pressure_error_estimate', plain, last%pressure_error)
      call columns%add('separation_error_estimate', plain, last%separation_error)
      if (.not. (model%largest_error > 0.0_real64 .and. &
                 result%error_estimate > model%largest_error)) &
        call add_surface_columns(self, columns)
      ! The stiffness needs more memory beside it.
      if (model%fields /= fields_none) call keep_field(self, size(steps), result)
      of_contacts%rows = size(self%samples)
      call of_contacts%add('samples', plain, self%samples)
    end associate
    do i = 1, size(self%laws)
      associate (law => self%laws(i)%law)
        columns%is_left_out = .not. law%is_simulated
        of_contacts%is_left_out = .not. law%is_simulated
        if (law%is_simulated .and. allocated(result%fields)) then
          call law%finish(self%state, result%fields(size(result%fields)), failure)
        else if (law%is_simulated) then
          call law%finish(self%state, failure=failure)
        end if
        if (allocated(failure)) return
        call law%add_columns(self%state, columns)
        call law%add_contact_columns(self%state, of_contacts)
      end associate
    end do
    columns%is_left_out = .false.
    call add_column_errors(self%request, columns)
    result%state_columns = columns%names
    result%state_values = columns%values(1, :)
    result%contact_columns = of_contacts%names
    call move_alloc(of_contacts%values, result%contact_values)
  end subroutine add_pixel_totals

  ! Finds the patches and shares of the contact pressure. Loads and pressures of the patches are
  ! then those of the net traction: on all pixels of a patch the attraction is that of contact.
  subroutine list_patches(self, shares)
    class(pixel_bodies), intent(inout) :: self
    type(map_shares), intent(out) :: shares

    associate (answer => self%state%answer, tolerance => self%model%tolerance)
      call patches_in_contact(self%map, answer, self%state%patches, self%state%hardness)
      if (.not. allocated(answer%contact_pressure)) then
        call find_shares(self%map, answer%pressure, self%state%patches, tolerance, &
                         self%spike_limit, shares)
        return
      end if
      call find_shares(self%map, answer%contact_pressure, self%state%patches, tolerance, &
                       self%spike_limit, shares)
    end associate
    associate (patches => self%state%patches, attraction => self%state%answer%attraction)
      patches%load = patches%load - &
                     attraction * patches%samples * product(self%map%pixel_spacing)
      patches%highest = patches%highest - attraction
      patches%mean = min(patches%load / patches%area, patches%highest)
    end associate
  end subroutine list_patches

  ! Adds the columns of the interface, and those of the smooth form of a map.
  subroutine add_surface_columns(self, columns)
    class(pixel_bodies), intent(in) :: self
    type(column_list), intent(inout) :: columns
    real(real64) :: width, smooth(2)
    integer :: axis

    associate (answer => self%state%answer, map => self%map, &
               form => self%model%scene_in%map%form_radius)
      call add_state_interface(self%state, self%request%material, self%request%conductivity, &
                               columns)
      if (.not. any(form > 0.0_real64)) return
      ! Length of the contact of a cylinder: that of a period along its axis; 0: its end is free.
      axis = minloc(form, 1)
      width = 0.0_real64
      if (map%repeats(axis)) width = map%pixel_spacing(axis) * size(map%height, axis)
      call find_form_contact(form, max(answer%load, 0.0_real64), self%model%modulus, width, &
                             smooth(1), smooth(2))
      if (any(map%bodies%thickness > 0.0_real64)) smooth = not_computed
      call columns%add('hertz_pressure', [1, 0], smooth(1))
      call columns%add('hertz_area', area, smooth(2))
    end associate
  end subroutine add_surface_columns

  ! Sets the records of the effects, and adds to the error and the warnings what is left out.
  subroutine add_left_out(self, result, warnings)
    class(pixel_bodies), intent(in) :: self
    type(position_result), intent(inout) :: result
    type(theory_warning), allocatable, intent(inout) :: warnings(:)
    character(len=*), parameter :: on_pixels = 'on the pixels of the map'
    logical :: is_unknown  ! an influence has no estimate
    real(real64) :: share
    integer :: i

    share = 0.0_real64
    is_unknown = .false.
    allocate (result%effects(1 + size(self%laws)))
    result%effects%simulated = 'on'
    result%effects(1)%simulated = 'boundary'
    result%effects%why = on_pixels
    result%effects%ending = self%state%answer%ending
    do i = 1, size(self%laws)
      associate (law => self%laws(i)%law, record => result%effects(1 + i))
        if (self%estimates(i) < unknown_influence) record%estimate = self%estimates(i)
        if (law%is_simulated) then
          if (law%mode == effect_auto .and. .not. law%is_free) record%why = &
            merge('estimate above tolerance', 'without an estimate     ', &
                  record%estimate > not_computed)
          ! Without a tangential load friction changes nothing.
          if (law%name == 'friction' .and. .not. law%solves .and. &
              .not. has_tangential(self%model%scene_in%loading)) &
            record = effect_record(why='no tangential load on the map', estimate=0.0_real64)
          cycle
        end if
        record = effect_record(estimate=record%estimate)
        if (.not. self%estimates(i) < unknown_influence) record%why = 'without an estimate'
        call warn_of_left_out(law%name, of_barred, self%estimates(i))
      end associate
    end do
    do i = 1, size(self%left_out)
      associate (law => self%left_out(i)%law, estimate => self%of_left_out(i))
        if (estimate < unknown_influence) &
          result%left_out(findloc(known_effects%name, law%name, 1)) = estimate
        call warn_of_left_out(law%name, merge( &
          of_barred, of_off, self%model%scene_in%effects%is_barred(law%name)), estimate)
      end associate
    end do
    share = error_of_share(is_load(self%model%scene_in%loading%control), share)
    associate (error => result%states%error_estimate)
      if (is_unknown) error = not_computed
      where (error > not_computed) error = error + share
    end associate
    result%error_estimate = result%states(self%states)%error_estimate

  contains

    subroutine warn_of_left_out(name, number, estimate)
      character(len=*), intent(in) :: name
      integer, intent(in) :: number
      real(real64), intent(in) :: estimate

      if (.not. estimate < unknown_influence) then
        is_unknown = .true.
        call add_warning(warnings, of_not_estimated, 0.0_real64, whose=name)
        return
      end if
      share = share + max(0.0_real64, estimate)
      if (estimate > self%model%tolerance) call add_warning(warnings, number, estimate, whose=name)
    end subroutine warn_of_left_out

  end subroutine add_left_out

  ! Estimates the errors of a state by the size of the pixels, where the laws have them, and warns
  ! of those of the last one.
  subroutine estimate_errors(self, by_load, number, result)
    class(pixel_bodies), intent(inout) :: self
    logical, intent(in) :: by_load  ! the load is prescribed
    integer, intent(in) :: number   ! of the state, from 1
    type(position_result), intent(inout) :: result
    type(theory_warning), allocatable :: warnings(:)
    real(real64) :: area_error, at_ends
    character(len=:), allocatable :: unsolved
    character(len=48) :: whose
    logical :: shapes(size(self%laws))
    integer :: i

    if (size(self%state%patches) == 0) return
    shapes = [(self%laws(i)%law%shapes .and. self%laws(i)%law%is_simulated, i=1, size(shapes))]
    do i = 1, size(shapes)
      if (.not. shapes(i)) cycle
      whose = self%laws(i)%law%why_unknown(self%state, count(shapes) == 1)
      if (whose == '') cycle
      if (number == self%states) result%no_estimate = 'none with ' // whose
      return
    end do
    associate (row => result%states(number))
      self%request%by_load = by_load
      self%request%is_last = number == self%states
      self%request%by_top = is_compression(self%model%scene_in%loading%control)
      at_ends = 0.0_real64
      if (self%state%answer%load > 0.0_real64 .and. .not. allocated(self%state%hardness)) &
        at_ends = share_at_ends(self%map, self%state%answer%pressure)
      self%request%is_cut = at_ends > 0.0_real64
      call estimate_pixel_errors(self%map, self%laws, self%state, self%request, row, unsolved)
      if (at_ends > 0.0_real64) row%pressure_error = not_computed
      result%error_estimate = row%error_estimate
      if (number < self%states) return
      if (allocated(unsolved)) result%no_estimate = &
        'unknown, the map of every second pixel could not be solved: ' // unsolved
      if (at_ends > 0.0_real64) call add_warning(warnings, of_edge_pressure, at_ends)
      area_error = max(0.5_real64 * sum(self%state%patches%rim) / row%area, row%area_error)
    end associate
    whose = ''
    if (self%request%growth > 0.0_real64) whose = 'it is rough at their size'
    call warn_above(warnings, of_resolution, area_error, whose=whose)
    call take_worse(result%warnings, warnings, number)
  end subroutine estimate_errors

  ! Warns of patches beyond yield or the limit, of strains beyond the linear theory, and of contacts
  ! that are wide for their asperity, or reach its base plane.
  subroutine warn_of_patches(self, warnings)
    class(pixel_bodies), intent(in), target :: self
    type(theory_warning), allocatable, intent(inout) :: warnings(:)
    real(real64), parameter :: peak = 1.5_real64  ! greatest over average pressure of Hertz
    real(real64) :: below
    integer :: i

    associate (patches => self%state%patches)
      call warn_above(warnings, of_map_pressure, &
                      maxval([0.0_real64, patches%highest]) / self%model%modulus)
      do i = 1, size(patches)
        call look_at_pressure(self%model%limits, patches(i)%mean, patches(i)%highest / peak, &
                              patches(i)%load, warnings)
      end do
    end associate
    if (.not. allocated(self%caps%rise)) return
    associate (caps => self%caps, is_loaded => self%state%answer%pressure > 0.0_real64)
      call warn_above(warnings, of_contact_radius, &
                      maxval([0.0_real64, pack(caps%slope, is_loaded)]))
      below = maxval([0.0_real64, pack(self%map%height - caps%rise, is_loaded) - &
                      self%state%answer%level]) / caps%radius
    end associate
    if (below > 0.0_real64) call add_warning(warnings, of_cap, below)
  end subroutine warn_of_patches

  ! Sets the results of one state and its contact patches.
  subroutine fill_state(self, result, number)
    class(pixel_bodies), intent(in), target :: self
    type(position_result), intent(inout) :: result
    integer, intent(in) :: number
    type(contact_row) :: rows(size(self%state%patches))
    type(state_row) :: state
    integer :: i

    state%time = self%state%time
    if (allocated(self%state%load)) then
      state%prescribed = prescribed_normal
      state%prescribed_load = self%state%load
    end if
    associate (answer => self%state%answer, patches => self%state%patches, map => self%map)
      state%approach = answer%level
      state%compression = self%top - answer%level
      state%contacts = size(patches)
      state%load = answer%load
      state%vertical_load = answer%load
      state%area = sum(patches%area)
      state%projected_area = state%area
      state%greatest_pressure = maxval([0.0_real64, patches%highest])
      call measure_fields(self%state%deformed, answer, state)
      do i = 1, size(self%laws)
        if (self%laws(i)%law%is_simulated) call self%laws(i)%law%fill_row(self%state, state)
      end do
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
