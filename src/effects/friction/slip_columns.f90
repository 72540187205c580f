!> Columns of a tangential load: names and units, the same for asperities and pixels.
module asperity_slip_columns
  use asperity_contact_effect, only: force, length, plain
  use asperity_decimal, only: decimal_to_real64
  use asperity_friction, only: tangential_stiffness_ratio
  use asperity_kinds, only: real64
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: slip_contact_columns, slip_contact_powers, slip_state_columns, slip_state_powers, &
            stiffness_ratio_of

  !> Columns of a contact: its share of the tangential load, the area that sticks.
  character(len=*), parameter :: slip_contact_columns(2) = &
    [character(len=20) :: 'shear_load', 'stick_area']
  !> Columns of the last state; `slides` is 1 in complete sliding.
  character(len=*), parameter :: slip_state_columns(5) = [character(len=24) :: 'tangential_load', &
    'tangential_displacement', 'tangential_stiffness', 'stick_area', 'slides']

  integer, parameter :: stiffness(2) = [1, 1], area(2) = [0, 2]
  !> Powers of the modulus and of the length in the units of the columns of a contact.
  integer, parameter :: slip_contact_powers(2, 2) = reshape([force, area], [2, 2])
  !> Powers of the modulus and of the length in the units of the columns of a state.
  integer, parameter :: slip_state_powers(2, 5) = &
    reshape([force, length, stiffness, area, plain], [2, 5])

contains

  !> Tangential over normal stiffness of the two bodies of a scene, kappa.
  pure real(real64) function stiffness_ratio_of(scene_in)
    type(scene), intent(in) :: scene_in  !! scene with moduli and ratios of both bodies

    stiffness_ratio_of = tangential_stiffness_ratio( &
      decimal_to_real64(scene_in%upper%elastic_modulus), &
      decimal_to_real64(scene_in%upper%poisson_ratio), &
      decimal_to_real64(scene_in%lower%elastic_modulus), &
      decimal_to_real64(scene_in%lower%poisson_ratio))
  end function stiffness_ratio_of

end module asperity_slip_columns
