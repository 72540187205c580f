!> Properties of the interface of a height map in contact: its stiffness, its contact conductance,
!> and whether a fluid finds a path through its open area.
!>
!> The conductance of an interface with the stiffness K = dP/d(compression), the combined modulus E
!> and bodies of the resistivities s1 and s2 is 2 K/(E (s1 + s2)) (Barber, Proc. R. Soc. A 459
!> (2003) 53), for heat and for an electric current. The length 2 K/E is that of the surface alone;
!> it is 4 a of a circle of the radius a.
module asperity_map_interface
  use asperity_contact_stiffness, only: find_stiffness
  use asperity_effect_header, only: column_list, length, plain, stiffness
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: not_computed, real64
  use asperity_map_patches, only: find_patches, map_patch
  use asperity_tangential_stiffness, only: find_tangential_stiffness
  implicit none
  private

  public :: add_interface

  ! Names and units of the conductances where both bodies have a conductivity.
  character(len=*), parameter :: conductance_columns(2) = &
    [character(len=24) :: 'electrical_conductance', 'thermal_conductance']
  character(len=*), parameter :: conductance_units(2) = [character(len=3) :: 'S', 'W/K']

contains

  !> Adds the stiffness by the compression and by the mean gap, that of pixels that stick by
  !> tangential displacements, the conductance over the conductivity, whether the open area
  !> percolates along x and y, and the conductances. A stiffness that is unknown or infinite, and a
  !> tangential one of layers, is `not_computed`.
  subroutine add_interface(map, material, pressure, conductivity, columns, hardness)
    type(height_map), intent(in) :: map         !! map with its edges
    !> combined modulus, more than 0, and Poisson's ratio of tangential displacements
    real(real64), intent(in) :: material(2)
    real(real64), intent(in) :: pressure(:, :)  !! pressures of the solution
    real(real64), intent(in) :: conductivity(:, :)  !! (body, electrical or thermal); 0: not given
    type(column_list), intent(inout) :: columns     !! gets the columns
    real(real64), intent(in), optional :: hardness  !! largest pressure; absent: elastic
    real(real64) :: by_compression, by_gap, conductance, tangential(2, 2)
    type(height_map) :: bare
    type(map_patch), allocatable :: patches(:)
    logical, allocatable :: carries(:, :)
    logical :: is_open(2)
    integer :: i

    allocate (carries(size(pressure, 1), size(pressure, 2)), source=pressure > 0.0_real64)
    if (present(hardness)) carries = carries .and. pressure < hardness
    call find_stiffness(map, material(1), carries, by_compression, by_gap)
    conductance = by_compression
    ! The conductance is that of one conductivity in layer and base.
    if (any(map%bodies%thickness > 0.0_real64)) then
      bare = map
      bare%bodies%thickness = 0.0_real64
      call find_stiffness(bare, material(1), carries, conductance)
    end if
    if (conductance > not_computed) conductance = 2.0_real64 * conductance / material(1)
    call columns%add('contact_stiffness', stiffness, by_compression)
    call columns%add('interface_stiffness', stiffness, by_gap)
    call columns%add('conductance_length', length, conductance)
    tangential = not_computed
    if (all(map%bodies%thickness <= 0.0_real64)) call find_tangential_stiffness( &
      map, material(1), material(2), pressure > 0.0_real64, tangential)
    call columns%add('tangential_stiffness_xx', stiffness, tangential(1, 1))
    call columns%add('tangential_stiffness_xy', stiffness, tangential(1, 2))
    call columns%add('tangential_stiffness_yy', stiffness, tangential(2, 2))
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
    call columns%add('open_path_x', plain, merge(1.0_real64, 0.0_real64, is_open(1)))
    call columns%add('open_path_y', plain, merge(1.0_real64, 0.0_real64, is_open(2)))
    do i = 1, 2
      associate (both => conductivity(:, i))
        if (all(both > 0.0_real64)) call columns%add( &
          trim(conductance_columns(i)), plain, &
          max(not_computed, conductance * (product(both) / sum(both))), conductance_units(i))
      end associate
    end do
  end subroutine add_interface

end module asperity_map_interface
