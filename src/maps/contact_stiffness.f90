!> Normal stiffness of a height map in contact.
!>
!> Problem: A x = 1 on the pixels in contact, x = 0 elsewhere, with the matrix A of displacements.
!> x are the pressures by a unit increase of the compression while no pixel opens or closes; their
!> sum times the area of a pixel is dP/d(compression). The change of the set of pixels in contact
!> has no effect of first order (Barber, Proc. R. Soc. A 459 (2003) 53).
!>
!> Method: conjugate gradients on these pixels, preconditioned with the approximate inverse of
!> `lattice_convolution`, which is symmetric and positive definite on them.
module asperity_contact_stiffness
  use asperity_height_map, only: height_map
  use asperity_kinds, only: not_computed, real64
  use asperity_lattice_convolution, only: lattice_convolution
  use asperity_map_contact, only: prepare_influence
  implicit none
  private

  public :: find_stiffness

  ! Largest residual relative to the unit displacement: above the rounding of the transforms
  ! (chosen; test: a sphere in test/regression/test_partial_slip.py).
  real(real64), parameter :: residual_left = 1.0e-9_real64
  ! Largest number of iterations (chosen).
  integer, parameter :: iterations_allowed = 1000

contains

  !> Solves for the stiffness. It is `not_computed` where the method does not converge, as on a
  !> periodic map in full contact, whose mean pressure has no displacement.
  subroutine find_stiffness(map, modulus, carries, stiffness)
    type(height_map), intent(in) :: map          !! map with its edges
    real(real64), intent(in) :: modulus          !! combined modulus, more than 0
    logical, intent(in) :: carries(:, :)         !! pixels in contact, below the hardness
    real(real64), intent(out) :: stiffness       !! dP/d(compression) [force/length], 0 or more
    type(lattice_convolution) :: influence
    real(real64), allocatable, dimension(:, :) :: direction, image, residual, pressure
    real(real64) :: curvature, product_before, residual_product, step
    integer :: turn

    stiffness = 0.0_real64
    if (.not. any(carries)) return
    call prepare_influence(map, influence)
    residual = merge(1.0_real64, 0.0_real64, carries)
    allocate (direction, pressure, source=0.0_real64 * residual)
    allocate (image, mold=residual)
    stiffness = not_computed
    residual_product = 0.0_real64
    do turn = 1, iterations_allowed
      call influence%apply(residual, image, inverse=.true.)
      product_before = residual_product
      residual_product = sum(residual * image)
      step = 0.0_real64
      if (product_before > 0.0_real64) step = residual_product / product_before
      direction = merge(image + step * direction, 0.0_real64, carries)
      call influence%apply(direction, image)
      curvature = sum(direction * image)
      if (.not. (curvature > 0.0_real64 .and. residual_product > 0.0_real64)) return
      step = residual_product / curvature
      pressure = pressure + step * direction
      residual = residual - merge(step * image, 0.0_real64, carries)
      if (maxval(abs(residual)) <= residual_left) exit
    end do
    if (turn > iterations_allowed) return
    ! Lengths across are over the side of a pixel.
    stiffness = modulus * map%pixel_spacing(2) * sum(pressure)
  end subroutine find_stiffness

end module asperity_contact_stiffness
