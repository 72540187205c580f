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
!> Products have single precision, but for the mean gap, which is a small difference.
module asperity_contact_stiffness
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: int64, not_computed, real32, real64
  use asperity_lattice_convolution, only: lattice_convolution
  use asperity_line_transform, only: thread_threshold
  use asperity_map_contact, only: prepare_influence
  implicit none
  private

  public :: find_stiffness

  ! Largest error of y over y. Derived: it is e.Ae with the error e of x, and A e is the residual r
  ! on the pixels up to a constant. The inverse of A on some pixels is at most B of `invert_on`
  ! there, so that e.Ae is at most r.Br: of second order in the residual.
  real(real64), parameter :: error_left = 1.0e-6_real64
  ! Largest relative error of the change of the mean gap, y - m.x with the displacements m by equal
  ! forces on all measured pixels, of the sum 1: 0 on a periodic map. Derived: m.e is at most the
  ! root of e.Ae times the energy of these forces (Cauchy and Schwarz), which is at most y (test of
  ! both: differences of loads in test/maps/test_map_interface.py).
  real(real64), parameter :: gap_error_left = 1.0e-5_real64
  ! Largest number of iterations (chosen).
  integer, parameter :: iterations_allowed = 1000

contains

  !> Solves for the stiffness. It is `not_computed` where the method does not converge; on a
  !> periodic map in full contact, whose mean pressure has no displacement; for the compression,
  !> also on a strip, whose displacement has no reference; for the mean gap, in any full contact.
  subroutine find_stiffness(map, modulus, carries, stiffness, gap_stiffness)
    type(height_map), intent(in) :: map          !! map with its edges
    real(real64), intent(in) :: modulus          !! combined modulus, more than 0
    logical, intent(in), contiguous :: carries(:, :)  !! pixels in contact, below the hardness
    real(real64), intent(out) :: stiffness       !! dP/d(compression) [force/length], 0 or more
    !> load by a decrease of the mean gap over the measured pixels [force/length], 0 or more
    real(real64), intent(out), optional :: gap_stiffness
    type(lattice_convolution) :: influence
    real(real64), allocatable, dimension(:, :) :: direction, image, residual
    real(real32), allocatable, dimension(:, :) :: given, found
    real(real64) :: displacement, gap, product_before, step, totals(2)
    integer(int64) :: number
    integer :: turn
    logical :: has_mean, is_met(2)

    stiffness = 0.0_real64
    if (present(gap_stiffness)) gap_stiffness = 0.0_real64
    number = count(carries, kind=int64)
    if (number == 0) return
    stiffness = not_computed
    if (present(gap_stiffness)) gap_stiffness = not_computed
    has_mean = present(gap_stiffness) .and. any(is_measured(map%height) .and. .not. carries) &
               .and. .not. (map%periodic .and. all(is_measured(map%height)))
    call prepare_influence(map, influence)
    allocate (image, residual, mold=map%height)
    allocate (given(map%columns, map%rows), found(map%columns, map%rows))
    allocate (direction(map%columns, map%rows), source=0.0_real64)
    where (carries) direction = 1.0_real64 / number
    call influence%apply(direction, image)
    totals = sums_on(carries, image, direction)
    displacement = totals(2)
    gap = displacement
    if (has_mean) gap = displacement - measured_mean(map, image)
    residual = 0.0_real64
    where (carries) residual = displacement - image
    direction = 0.0_real64
    product_before = 0.0_real64
    is_met = .false.
    do turn = 1, iterations_allowed
      if (.not. displacement > epsilon(displacement) * influence%norm) return
      given = real(residual, real32)
      call influence%invert_on(given, found)
      image = found
      totals = sums_on(carries, image, residual)
      is_met = totals(2) <= error_left * displacement
      if (has_mean) is_met(2) = totals(2) * displacement <= (gap_error_left * gap)**2
      ! The gap is a difference with an error of rounding: less is not asked for.
      if (all(is_met) .or. totals(2) <= epsilon(gap)**2 * displacement) exit
      step = 0.0_real64
      if (product_before > 0.0_real64) step = totals(2) / product_before
      product_before = totals(2)
      call add_on(carries, [step, 1.0_real64, totals(1) / number], image, direction)
      if (has_mean) then
        call influence%apply(direction, image)
      else
        given = real(direction, real32)
        call influence%apply(given, found)
        image = found
      end if
      totals = sums_on(carries, image, direction)
      if (.not. (totals(2) > 0.0_real64 .and. product_before > 0.0_real64)) exit
      step = product_before / totals(2)
      ! x.Ax decreases by the product of the step and the residual.
      displacement = displacement - step * product_before
      gap = gap - step * product_before
      if (has_mean) gap = gap - step * measured_mean(map, image)
      call add_on(carries, [1.0_real64, -step, totals(1) / number], image, residual)
    end do
    ! Lengths across are over the side of a pixel.
    if (is_met(1) .and. map%strip_axis == 0) &
      stiffness = modulus * map%pixel_spacing(2) / displacement
    if (present(gap_stiffness) .and. is_met(2) .and. gap > epsilon(gap) * influence%norm .and. &
        any(is_measured(map%height) .and. .not. carries)) &
      gap_stiffness = modulus * map%pixel_spacing(2) / gap
  end subroutine find_stiffness

  ! Multiplies values by the first factor and adds, on a part of the pixels, an image less a mean,
  ! times the second.
  subroutine add_on(part, factors_mean, image, values)
    logical, intent(in), contiguous :: part(:, :)
    real(real64), intent(in) :: factors_mean(3)
    real(real64), intent(in), contiguous :: image(:, :)
    real(real64), intent(inout), contiguous :: values(:, :)
    integer :: i, j

    !$omp parallel do if(size(image, kind=int64) > thread_threshold)
    do j = 1, size(image, 2)
      !$omp simd
      do i = 1, size(image, 1)
        values(i, j) = factors_mean(1) * values(i, j) + factors_mean(2) * &
                       merge(image(i, j) - factors_mean(3), 0.0_real64, part(i, j))
      end do
    end do
  end subroutine add_on

  ! Mean of displacements over the measured pixels.
  real(real64) function measured_mean(map, displacement) result(mean)
    type(height_map), intent(in) :: map
    real(real64), intent(in), contiguous :: displacement(:, :)
    real(real64) :: totals(2)

    totals = sums_on(is_measured(map%height), displacement, displacement)
    mean = totals(1) / count(is_measured(map%height), kind=int64)
  end function measured_mean

  ! Sum of an array over a part of the pixels, and that of its product with another one, by rows.
  function sums_on(part, image, other) result(totals)
    logical, intent(in), contiguous :: part(:, :)
    real(real64), intent(in), contiguous :: image(:, :), other(:, :)
    real(real64) :: row_sums(2, size(part, 2)), total, product_sum, totals(2), value
    integer :: i, j

    !$omp parallel do private(total, product_sum, value) &
    !$omp if(size(image, kind=int64) > thread_threshold)
    do j = 1, size(image, 2)
      total = 0.0_real64
      product_sum = 0.0_real64
      !$omp simd private(value) reduction(+:total, product_sum)
      do i = 1, size(image, 1)
        value = merge(image(i, j), 0.0_real64, part(i, j))
        total = total + value
        product_sum = product_sum + value * other(i, j)
      end do
      row_sums(:, j) = [total, product_sum]
    end do
    totals = sum(row_sums, 2)
  end function sums_on

end module asperity_contact_stiffness
