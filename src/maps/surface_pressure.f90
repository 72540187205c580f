!> Pressures on all pixels that give displacements.
!>
!> Problem: A p = u for the pressures p, with the matrix A of displacements. On a periodic map the
!> mean of u is that of a rigid base, or has no effect. Method: conjugate gradients, preconditioned
!> with the approximate inverse of `lattice_convolution`.
module asperity_surface_pressure
  use asperity_height_map, only: height_map
  use asperity_kinds, only: int64, real32, real64
  use asperity_lattice_convolution, only: lattice_convolution
  use asperity_layer_compliance, only: mean_displacement
  use asperity_map_contact, only: prepare_influence
  implicit none
  private

  public :: find_pressure

  ! Largest residual over the largest displacement (chosen; test: test_python_half_space.py).
  real(real64), parameter :: residual_left = 1.0e-10_real64
  ! Largest number of iterations (chosen).
  integer, parameter :: iterations_allowed = 10000

contains

  !> Solves for the pressures; positive and negative ones.
  subroutine find_pressure(map, modulus, displacement, pressure, failure)
    type(height_map), intent(in) :: map              !! map with its edges and bodies
    real(real64), intent(in) :: modulus              !! combined modulus, more than 0
    real(real64), intent(in) :: displacement(:, :)   !! of each pixel [length]
    real(real64), allocatable, intent(out) :: pressure(:, :)   !! of each pixel
    character(len=:), allocatable, intent(out) :: failure      !! reason, when it is not solved
    type(lattice_convolution) :: influence
    real(real64), allocatable, dimension(:, :) :: direction, image, residual
    real(real32), allocatable :: inverse(:, :)
    real(real64) :: product_before, residual_product, step
    integer :: turn
    logical :: has_mean

    call prepare_influence(map, influence)
    allocate (residual, source=displacement * (modulus / map%pixel_spacing(1)))
    has_mean = .not. map%periodic .or. mean_displacement(map%bodies) > 0.0_real64
    if (.not. has_mean) residual = residual - sum(residual) / size(residual, kind=int64)
    allocate (pressure, direction, image, mold=residual)
    allocate (inverse(size(residual, 1), size(residual, 2)))
    pressure = 0.0_real64
    direction = 0.0_real64
    product_before = 0.0_real64
    associate (least => residual_left * maxval(abs(residual)))
      do turn = 1, iterations_allowed
        if (.not. maxval(abs(residual)) > least) return
        call influence%invert_on(real(residual, real32), inverse)
        image = inverse
        if (.not. has_mean) image = image - sum(image) / size(image, kind=int64)
        residual_product = sum(image * residual)
        step = 0.0_real64
        if (product_before > 0.0_real64) step = residual_product / product_before
        product_before = residual_product
        direction = image + step * direction
        call influence%apply(direction, image)
        step = residual_product / sum(image * direction)
        pressure = pressure + step * direction
        residual = residual - step * image
      end do
    end associate
    failure = 'the pressures did not converge'
  end subroutine find_pressure

end module asperity_surface_pressure
