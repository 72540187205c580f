!> Tangential stiffness of a height map whose pixels in contact all stick.
!>
!> Problem: the tractions on these pixels that displace them equally, for a load along x and along
!> y (`asperity_slip_solver`). The 2 x 2 matrix of the load by the displacement depends on the
!> shape and direction: over the normal stiffness it is 2 (1 - nu)/(2 - nu) for a circle (Mindlin
!> 1949), 1 across ridges and 1 - nu along them.
module asperity_tangential_stiffness
  use asperity_height_map, only: height_map
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_lattice_convolution, only: padded_length
  use asperity_line_transform, only: bytes_of_plans
  use asperity_process, only: check_memory
  use asperity_slip_solver, only: find_compliance, set_sticking, tangent_space
  use asperity_traction_convolution, only: element_set, list_elements, traction_convolution
  implicit none
  private

  public :: find_tangential_stiffness, prepare_for_map, room_for_tractions

contains

  !> Finds the stiffness of pixels that stick. It is `not_computed` on a strip, whose displacement
  !> has no reference, on a periodic map in full contact, without two bodies, and without memory.
  subroutine find_tangential_stiffness(map, modulus, poisson_ratio, sticks, stiffness)
    type(height_map), intent(in) :: map           !! map with its edges
    real(real64), intent(in) :: modulus           !! combined modulus, more than 0
    real(real64), intent(in) :: poisson_ratio     !! of both bodies; `not_computed`: unknown
    logical, intent(in) :: sticks(:, :)           !! pixels in contact
    real(real64), intent(out) :: stiffness(2, 2)  !! load by displacement [force/length]
    type(traction_convolution) :: operator
    type(element_set) :: set
    type(tangent_space) :: space
    character(len=:), allocatable :: failure
    real(real64) :: compliance(2, 2)
    real(real64), parameter :: along_axes(2, 2) = &
      reshape([1.0_real64, 0.0_real64, 0.0_real64, 1.0_real64], [2, 2])

    stiffness = 0.0_real64
    if (.not. any(sticks)) return
    stiffness = not_computed
    if (.not. (poisson_ratio > not_computed .and. map%strip_axis == 0)) return
    call check_memory('the tractions of the map', failure, bytes=room_for_tractions(map))
    if (allocated(failure)) return
    call prepare_for_map(map, poisson_ratio, 0.0_real64, operator)
    call list_elements(sticks, set)
    call set_sticking(set, space)
    call find_compliance(operator, space, along_axes, compliance)
    associate (determinant => compliance(1, 1) * compliance(2, 2) - compliance(1, 2)**2)
      ! Lengths across are over the side of a pixel.
      if (determinant > 0.0_real64) stiffness = modulus * map%pixel_spacing(2) / determinant * &
        reshape([compliance(2, 2), -compliance(2, 1), -compliance(1, 2), compliance(1, 1)], [2, 2])
    end associate
  end subroutine find_tangential_stiffness

  !> Prepares the displacements by tractions on a map.
  subroutine prepare_for_map(map, poisson_ratio, beta, operator)
    type(height_map), intent(in) :: map              !! map with its edges
    real(real64), intent(in) :: poisson_ratio, beta  !! of both bodies; Dundurs' number or 0
    type(traction_convolution), intent(inout) :: operator  !! convolution without plans

    call operator%prepare(shape(map%height), map%pixel_spacing(2) / map%pixel_spacing(1), &
                          [map%repeats(1), map%repeats(2)], poisson_ratio, beta)
  end subroutine prepare_for_map

  !> Memory of the tangential problem of a map, bytes: at most 8 spectra, a quarter of each, two
  !> transforms, and at most 34 arrays of the pixels.
  pure integer(int64) function room_for_tractions(map) result(bytes)
    type(height_map), intent(in) :: map  !! height map, periodic or free
    real(real64) :: padded(2)

    padded = shape(map%height)
    where (.not. [map%repeats(1), map%repeats(2)]) padded = padded_length(2 * shape(map%height) - 1)
    bytes = nint(16 * (product(padded) + padded(1) * map%rows) + &
                 8 * 34 * real(size(map%height, kind=int64), real64), int64) + bytes_of_plans
  end function room_for_tractions

end module asperity_tangential_stiffness
