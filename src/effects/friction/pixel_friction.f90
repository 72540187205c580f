!> Friction on the pixels of a height map, as an effect of a scene: partial slip by tangential loads
!> after the last state.
!>
!> It leaves the normal contact of like bodies as it is. Unlike bodies rub on each other while they
!> are pressed: both problems are then solved in turns, in `loading_steps` increments of each state,
!> without a tangential load. Errors by the pixels are those of the map less the displacements by
!> the tractions.
module asperity_pixel_friction
  use asperity_contact_field, only: contact_field
  use asperity_effect_header, only: area, column_list, force, length, moment, plain, stiffness
  use asperity_friction, only: shared_poisson_ratio
  use asperity_height_map, only: is_measured
  use asperity_kinds, only: not_computed, real64
  use asperity_map_contact, only: map_answer
  use asperity_map_fields, only: take_field
  use asperity_map_top, only: find_top, first_contact
  use asperity_partial_slip, only: slip_answer, slip_of_patches, solve_partial_slip, take_traction
  use asperity_pixel_law, only: pixel_law, pixel_state
  use asperity_scene_values, only: coupling_influence, dundurs_beta, is_coupled, scene
  use asperity_slip_increments, only: begin_rubbing, forget_tractions, rubbed_map, slip_memory, &
                                      slip_request, take_increment
  use asperity_traction_convolution, only: traction_convolution
  implicit none
  private

  public :: new_pixel_friction

  !> Friction with one coefficient for all pixels.
  type, extends(pixel_law) :: pixel_friction
    type(slip_request) :: request  !! tangential load or displacement
    type(slip_answer) :: slip      !! solution at the last state
    type(slip_memory) :: memory    !! tractions by the normal load of coupled bodies
    integer :: steps = 1           !! increments of a state with coupling
    real(real64) :: influence = 0.0_real64  !! estimate of the coupling
    real(real64) :: load = 0.0_real64, level = 0.0_real64  !! of the state before; 0: no contact
  contains
    procedure :: estimate => estimate_friction
    procedure :: begin_step => subtract_lift
    procedure :: act => press_with_friction
    procedure :: end_step => add_lift
    procedure :: coarsen => keep_lift
    procedure :: add_columns => add_slip_columns
    procedure :: add_contact_columns => add_slip_of_patches
    procedure :: finish => solve_slip
  end type pixel_friction

contains

  !> Makes the law of a scene.
  subroutine new_pixel_friction(scene_in, law)
    type(scene), intent(in) :: scene_in                !! scene with checked values
    class(pixel_law), allocatable, intent(out) :: law  !! law without a solution
    type(pixel_friction) :: new

    new%is_free = .true.
    new%solves = is_coupled(scene_in)
    new%shapes = new%solves
    new%steps = nint(scene_in%effects%number('loading_steps'))
    new%influence = coupling_influence(scene_in)
    ! Positive where the lower body is the softer one.
    if (new%solves) new%request%beta = -dundurs_beta(scene_in)
    new%request%coefficient = scene_in%effects%number('friction_coefficient')
    new%request%poisson_ratio = shared_poisson_ratio(scene_in)
    associate (loading => scene_in%loading, request => new%request)
      request%by_load = .not. any(abs(loading%tangential_displacement) > 0.0_real64)
      request%path = reshape(loading%tangential_load + loading%tangential_displacement, [2, 1])
      if (allocated(loading%tangential_path)) request%path = loading%tangential_path
    end associate
    call new%call_as('friction', scene_in%effects)
    allocate (law, source=new)
  end subroutine new_pixel_friction

  !> The change of the pressures of unlike bodies.
  function estimate_friction(self, state) result(share)
    class(pixel_friction), intent(in) :: self
    type(pixel_state), intent(in) :: state
    real(real64) :: share

    associate (unused => state)
    end associate
    share = self%influence
  end function estimate_friction

  !> Where the tractions are those of finer pixels, subtracts their displacement from the heights.
  subroutine subtract_lift(self, state)
    class(pixel_friction), intent(inout) :: self
    type(pixel_state), intent(inout) :: state

    if (self%solves .or. .not. allocated(self%memory%uplift)) return
    where (is_measured(state%problem_map%height)) &
      state%problem_map%height = state%problem_map%height - self%memory%uplift
  end subroutine subtract_lift

  !> Presses unlike bodies from the state before: the radius of a new contact grows evenly.
  subroutine press_with_friction(self, state)
    class(pixel_friction), intent(inout) :: self
    type(pixel_state), intent(inout) :: state
    type(traction_convolution), target :: operator
    type(rubbed_map) :: surface
    real(real64) :: aim, first_touch, share
    type(first_contact) :: found
    integer :: i

    associate (map => state%problem_map, modulus => state%problem_modulus, answer => state%answer)
      found = find_top(map)
      first_touch = found%height
      aim = answer%level
      if (allocated(state%load)) aim = merge(aim, first_touch, state%load > 0.0_real64)
      if (.not. aim < first_touch .and. .not. allocated(state%load)) self%load = 0.0_real64
      if (allocated(state%load)) self%load = merge(self%load, 0.0_real64, state%load > 0.0_real64)
      call begin_rubbing(map, modulus, self%request, operator, surface, self%memory)
      if (.not. self%load > 0.0_real64) then
        self%level = first_touch
        call forget_tractions(map, self%memory)
      end if
      do i = 1, self%steps
        share = real(i, real64) / self%steps
        if (allocated(state%load)) then
          if (.not. self%load > 0.0_real64) share = share**3
          if (.not. state%load > 0.0_real64) then
            answer%level = first_touch
            call take_increment(surface, .true., [0.0_real64, 0.0_real64], self%memory, answer, &
                                answer%failure)
          else
            call take_increment(surface, .true., [0.0_real64, 0.0_real64], self%memory, answer, &
                                answer%failure, self%load + (state%load - self%load) * share)
          end if
        else
          if (.not. self%load > 0.0_real64) share = share**2
          answer%level = self%level + (aim - self%level) * share
          call take_increment(surface, .true., [0.0_real64, 0.0_real64], self%memory, answer, &
                              answer%failure)
        end if
        if (allocated(answer%failure)) return
      end do
      self%load = answer%load
      self%level = answer%level
    end associate
  end subroutine press_with_friction

  !> Adds the displacement by the tractions of finer pixels to that by the pressures.
  subroutine add_lift(self, state)
    class(pixel_friction), intent(inout) :: self
    type(pixel_state), intent(inout) :: state

    if (.not. self%solves .and. allocated(self%memory%uplift)) &
      state%answer%displacement = state%answer%displacement + self%memory%uplift
  end subroutine add_lift

  !> Keeps the tractions and displacements on every second pixel.
  subroutine keep_lift(self, columns, rows, state)
    class(pixel_friction), intent(inout) :: self
    integer, intent(in) :: columns(:), rows(:)
    type(pixel_state), intent(inout) :: state

    associate (as_it_is => state)
    end associate
    if (.not. self%solves) return
    self%solves = .false.
    associate (memory => self%memory)
      memory%uplift = memory%uplift(columns, rows)
      memory%traction = memory%traction(columns, rows, :)
      memory%change = memory%change(columns, rows, :)
      memory%sticks = memory%sticks(columns, rows)
      ! Lengths are over the side of a pixel.
      memory%moved = 0.5_real64 * memory%moved(columns, rows, :)
      memory%slip = 0.5_real64 * memory%slip(columns, rows, :)
      memory%displacement = 0.5_real64 * memory%displacement
    end associate
  end subroutine keep_lift

  ! Solves partial slip at the last state, and adds its traction to the fields.
  subroutine solve_slip(self, state, field, failure)
    class(pixel_friction), intent(inout) :: self
    type(pixel_state), intent(in) :: state
    type(contact_field), intent(inout), optional :: field
    character(len=:), allocatable, intent(inout) :: failure
    type(map_answer) :: answer

    answer = state%answer
    call solve_partial_slip(state%deformed, state%modulus, self%request, self%memory, answer, &
                            self%slip, failure)
    if (.not. present(field) .or. allocated(failure)) return
    if (self%solves) call take_field(state%deformed, answer, state%number, field)
    call take_traction(state%deformed, self%slip, field)
  end subroutine solve_slip

  !> Adds tangential load, displacement and stiffness, and the area that sticks; `slides` is 1 in
  !> complete sliding.
  subroutine add_slip_columns(self, state, columns)
    class(pixel_friction), intent(in) :: self
    type(pixel_state), intent(in) :: state
    type(column_list), intent(inout) :: columns

    associate (unused => state, slip => self%slip)
      call columns%add('tangential_load', force, norm2(slip%load))
      call columns%add('tangential_displacement', length, merge( &
        norm2(slip%displacement), not_computed, slip%displacement(1) > not_computed))
      call columns%add('tangential_stiffness', stiffness, slip%stiffness)
      call columns%add('stick_area', area, slip%stick_area)
      call columns%add('slides', plain, merge(1.0_real64, 0.0_real64, slip%slides))
      call columns%add('tangential_displacement_x', length, slip%displacement(1))
      call columns%add('tangential_displacement_y', length, slip%displacement(2))
      call columns%add('friction_energy', moment, slip%energy)
      call columns%add('cycle_energy', moment, slip%cycle_energy)
      call columns%add('path_error_estimate', plain, slip%path_error)
    end associate
  end subroutine add_slip_columns

  !> Adds tangential load and area that sticks of each patch.
  subroutine add_slip_of_patches(self, state, columns)
    class(pixel_friction), intent(in) :: self
    type(pixel_state), intent(in) :: state
    type(column_list), intent(inout) :: columns
    real(real64), allocatable :: load(:), stick_area(:)

    allocate (load(0), stick_area(0))
    if (columns%rows > 0) &
      call slip_of_patches(state%deformed, state%answer, self%slip, load, stick_area)
    call columns%add('shear_load', force, load)
    call columns%add('stick_area', area, stick_area)
  end subroutine add_slip_of_patches

end module asperity_pixel_friction
