!> Friction on the pixels of a height map, as an effect of a scene: partial slip by a tangential
!> load after the last state. It leaves the normal contact as it is.
module asperity_pixel_friction
  use asperity_contact_field, only: contact_field
  use asperity_effect_header, only: area, column_list, force, length, moment, plain, stiffness
  use asperity_friction, only: shared_poisson_ratio
  use asperity_kinds, only: not_computed, real64
  use asperity_partial_slip, only: slip_answer, slip_of_patches, slip_request, solve_partial_slip, &
                                   take_traction
  use asperity_pixel_law, only: pixel_law, pixel_state
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: new_pixel_friction

  !> Friction with one coefficient for all pixels.
  type, extends(pixel_law) :: pixel_friction
    type(slip_request) :: request  !! tangential load or displacement
    type(slip_answer) :: slip      !! solution at the last state
  contains
    procedure :: estimate => estimate_friction
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
    new%shapes = .false.
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

  !> The normal contact of a level map has no friction.
  function estimate_friction(self, state) result(share)
    class(pixel_friction), intent(in) :: self
    type(pixel_state), intent(in) :: state
    real(real64) :: share

    associate (unused => self, unused_too => state)
    end associate
    share = 0.0_real64
  end function estimate_friction

  ! Solves partial slip at the last state, and adds its traction to the fields.
  subroutine solve_slip(self, state, field, failure)
    class(pixel_friction), intent(inout) :: self
    type(pixel_state), intent(in) :: state
    type(contact_field), intent(inout), optional :: field
    character(len=:), allocatable, intent(inout) :: failure

    call solve_partial_slip(state%deformed, state%modulus, self%request, state%answer, self%slip, &
                            failure)
    if (present(field) .and. .not. allocated(failure)) &
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
