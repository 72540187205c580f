!> Properties of the interface of a height map in contact: its stiffness, its contact conductance,
!> and whether a fluid finds a path through its open area.
!>
!> The conductance of an interface with the stiffness K = dP/d(compression), the combined modulus E
!> and bodies of the resistivities s1 and s2 is 2 K/(E (s1 + s2)) (Barber, Proc. R. Soc. A 459
!> (2003) 53), for heat and for an electric current. The length 2 K/E is that of the surface alone;
!> it is 4 a of a circle of the radius a.
module asperity_map_interface
  use asperity_contact_stiffness, only: find_stiffness
  use asperity_effect_header, only: column_name, length, plain, stiffness
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: not_computed, real64
  use asperity_map_patches, only: find_patches, map_patch
  implicit none
  private

  public :: conductance_columns, conductance_units, interface_columns, measure_interface

  !> Columns of a state: the stiffness by the compression and by the mean gap, the conductance over
  !> the conductivity, and whether the open area percolates along x and y.
  type(column_name), parameter :: interface_columns(5) = [ &
    column_name('contact_stiffness', stiffness(1), stiffness(2)), &
    column_name('interface_stiffness', stiffness(1), stiffness(2)), &
    column_name('conductance_length', length(1), length(2)), &
    column_name('open_path_x', plain(1), plain(2)), column_name('open_path_y', plain(1), plain(2))]
  !> Columns of the conductances where both bodies have a conductivity.
  character(len=*), parameter :: conductance_columns(2) = &
    [character(len=24) :: 'electrical_conductance', 'thermal_conductance']
  !> Units of these columns.
  character(len=*), parameter :: conductance_units(2) = [character(len=3) :: 'S', 'W/K']

contains

  !> Computes the columns of a solution; `not_computed` where a stiffness is unknown or infinite.
  subroutine measure_interface(map, modulus, pressure, values, hardness)
    type(height_map), intent(in) :: map         !! map with its edges
    real(real64), intent(in) :: modulus         !! combined modulus, more than 0
    real(real64), intent(in) :: pressure(:, :)  !! pressures of the solution
    real(real64), intent(out) :: values(size(interface_columns))
    real(real64), intent(in), optional :: hardness  !! largest pressure; absent: elastic
    type(map_patch), allocatable :: patches(:)
    logical, allocatable :: carries(:, :)
    logical :: is_open(2)
    integer :: i

    allocate (carries(size(pressure, 1), size(pressure, 2)), source=pressure > 0.0_real64)
    if (present(hardness)) carries = carries .and. pressure < hardness
    call find_stiffness(map, modulus, carries, values(1), values(2))
    values(3) = not_computed
    if (values(1) > not_computed) values(3) = 2.0_real64 * values(1) / modulus
    ! Pixels out of contact form a path along an axis: between both edges of the map, or closed
    ! around a period. Pixels of a path share sides; missing ones are no part of it.
    call find_patches(map, merge(1.0_real64, 0.0_real64, is_measured(map%height) .and. &
                                 .not. pressure > 0.0_real64), patches)
    is_open = .false.
    do i = 1, size(patches)
      associate (patch => patches(i))
        is_open(1) = is_open(1) .or. merge(patch%x <= not_computed, patch%across(2) - &
                     patch%across(1) == map%columns - 1, map%repeats(1))
        is_open(2) = is_open(2) .or. merge(patch%y <= not_computed, patch%along(2) - &
                     patch%along(1) == map%rows - 1, map%repeats(2))
      end associate
    end do
    values(4:) = merge(1.0_real64, 0.0_real64, is_open)
  end subroutine measure_interface

end module asperity_map_interface
