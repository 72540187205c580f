!> Normal stiffness of a height map in contact.
!>
!> Problem: minimise x.Ax/2 over all x with the sum 1 on the pixels in contact, x = 0 elsewhere,
!> with the matrix A of displacements. At the minimum A x is the same, y, on these pixels: x are the
!> pressures by a small increase of the load while no pixel opens or closes, and 1/y is
!> dP/d(compression) over the area of a pixel. The change of the set of pixels in contact has no
!> effect of first order (Barber, Proc. R. Soc. A 459 (2003) 53).
!>
!> Method: conjugate gradients on these pixels with a fixed sum, preconditioned with the approximate
!> inverse of `lattice_convolution`, which is symmetric and positive definite on them. The sum is
!> fixed as a strip is known up to a constant displacement, which A need not be definite with.
module asperity_contact_stiffness
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: not_computed, real64
  use asperity_lattice_convolution, only: lattice_convolution
  use asperity_map_contact, only: prepare_influence
  implicit none
  private

  public :: find_stiffness

  ! Largest residual relative to y: the error is its square, by the mean gap 1e-7 at most (chosen;
  ! test: differences of loads in test/maps/test_map_interface.py).
  real(real64), parameter :: residual_left = 1.0e-5_real64
  ! Largest number of iterations (chosen).
  integer, parameter :: iterations_allowed = 1000

contains

  !> Solves for the stiffness. It is `not_computed` where the method does not converge; on a
  !> periodic map in full contact, whose mean pressure has no displacement; for the compression,
  !> also on a strip, whose displacement has no reference.
  subroutine find_stiffness(map, modulus, carries, stiffness, gap_stiffness)
    type(height_map), intent(in) :: map          !! map with its edges
    real(real64), intent(in) :: modulus          !! combined modulus, more than 0
    logical, intent(in) :: carries(:, :)         !! pixels in contact, below the hardness
    real(real64), intent(out) :: stiffness       !! dP/d(compression) [force/length], 0 or more
    !> load by a decrease of the mean gap over the measured pixels [force/length], 0 or more
    real(real64), intent(out), optional :: gap_stiffness
    type(lattice_convolution) :: influence
    real(real64), allocatable, dimension(:, :) :: direction, image, pressure, residual, &
                                                weight
    real(real64) :: curvature, displacement, largest, mean, product_before, residual_product, step
    integer :: i, j, number, turn

    stiffness = 0.0_real64
    if (present(gap_stiffness)) gap_stiffness = 0.0_real64
    number = count(carries)
    if (number == 0) return
    stiffness = not_computed
    if (present(gap_stiffness)) gap_stiffness = not_computed
    call prepare_influence(map, influence)
    weight = merge(1.0_real64, 0.0_real64, carries)
    pressure = weight / number
    allocate (image, residual, mold=pressure)
    allocate (direction, source=0.0_real64 * pressure)
    call influence%apply(pressure, image)
    displacement = sum(image, mask=carries) / number
    residual = weight * (displacement - image)
    largest = maxval(abs(residual))
    residual_product = 0.0_real64
    do turn = 1, iterations_allowed
      if (.not. displacement > epsilon(displacement) * influence%norm) return
      if (largest <= residual_left * displacement) exit
      call influence%invert_on(residual, image)
      product_before = residual_product
      call find_sums(image, residual, weight, mean, residual_product)
      mean = mean / number
      step = 0.0_real64
      if (product_before > 0.0_real64) step = residual_product / product_before
      do j = 1, size(image, 2)
        !$omp simd
        do i = 1, size(image, 1)
          direction(i, j) = weight(i, j) * (image(i, j) - mean) + step * direction(i, j)
        end do
      end do
      call influence%apply(direction, image)
      call find_sums(image, direction, weight, mean, curvature)
      mean = mean / number
      if (.not. (curvature > 0.0_real64 .and. residual_product > 0.0_real64)) return
      step = residual_product / curvature
      displacement = displacement + step * mean
      largest = 0.0_real64
      do j = 1, size(image, 2)
        !$omp simd reduction(max:largest)
        do i = 1, size(image, 1)
          pressure(i, j) = pressure(i, j) + step * direction(i, j)
          residual(i, j) = residual(i, j) - weight(i, j) * step * (image(i, j) - mean)
          largest = max(largest, abs(residual(i, j)))
        end do
      end do
    end do
    if (turn > iterations_allowed) return
    call influence%apply(pressure, image)
    ! Lengths across are over the side of a pixel.
    displacement = sum(pressure * image)
    if (map%strip_axis == 0) stiffness = modulus * map%pixel_spacing(2) / displacement
    if (.not. present(gap_stiffness)) return
    displacement = displacement - sum(image, mask=is_measured(map%height)) / &
                                  count(is_measured(map%height))
    if (displacement > epsilon(displacement) * influence%norm) &
      gap_stiffness = modulus * map%pixel_spacing(2) / displacement
  end subroutine find_stiffness

  ! Finds the sum of an array over the pixels in contact and its product with another one.
  pure subroutine find_sums(image, other, weight, total, scalar_product)
    real(real64), intent(in) :: image(:, :), other(:, :)
    real(real64), intent(in) :: weight(:, :)  ! 1 on the pixels in contact, else 0
    real(real64), intent(out) :: total, scalar_product
    integer :: i, j

    total = 0.0_real64
    scalar_product = 0.0_real64
    do j = 1, size(image, 2)
      !$omp simd reduction(+:total, scalar_product)
      do i = 1, size(image, 1)
        total = total + weight(i, j) * image(i, j)
        scalar_product = scalar_product + other(i, j) * image(i, j)
      end do
    end do
  end subroutine find_sums

end module asperity_contact_stiffness
