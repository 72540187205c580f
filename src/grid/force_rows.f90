!> Loops of the iteration for forces over one row of elements, with their sums.
!>
!> Rows are independent and their sums are added in order: the bytes do not depend on the number of
!> threads. The loops have no branches and their arrays do not overlap, so that they are vectorised.
!> Symbols are those of `asperity_element_forces`.
module asperity_force_rows
  use asperity_kinds, only: real32, real64
  implicit none
  private

  public :: direction_row, gradient_row, image_row, one_where, product_row, &
            residual_row, step_row, working_row

contains

  !> The gradient of the elements in W, else 0.
  pure subroutine working_row(limit, f, r, w)
    real(real64), intent(in) :: limit                 !! largest force H
    real(real64), intent(in), contiguous :: f(:), r(:)  !! forces and their gradient
    real(real32), intent(out), contiguous :: w(:)     !! gradient in W
    integer :: i

    !$omp simd
    do i = 1, size(f)
      w(i) = real(max(-one_where(f(i) < limit) * huge(limit), &
                      min(one_where(f(i) > 0.0_real64) * huge(limit), r(i))), real32)
    end do
  end subroutine working_row

  !> Sums in W of z.r, z.(r - r before), z, d and 1, with z = B r.
  pure subroutine product_row(w, z, before, d, sums)
    !> gradient r in W; B r; direction
    real(real32), intent(in), contiguous :: w(:), z(:), d(:)
    real(real64), intent(in), contiguous :: before(:)  !! gradient before the step
    real(real64), intent(out) :: sums(5)
    real(real64) :: changes, number, one, others, products, total, value
    integer :: i

    changes = 0.0_real64
    number = 0.0_real64
    others = 0.0_real64
    products = 0.0_real64
    total = 0.0_real64
    !$omp simd private(one, value) reduction(+:changes, number, others, products, total)
    do i = 1, size(w)
      one = one_where(abs(w(i)) > 0.0_real32)
      value = one * z(i)
      products = products + value * w(i)
      changes = changes + value * (w(i) - before(i))
      total = total + value
      others = others + one * d(i)
      number = number + one
    end do
    sums = [products, changes, total, others, number]
  end subroutine product_row

  !> Direction z + step d less a mean in W, else 0, and its product with the gradient.
  pure subroutine direction_row(step, mean, w, z, d, total)
    real(real32), intent(in) :: step, mean             !! share of the direction before; mean
    real(real32), intent(in), contiguous :: w(:), z(:)   !! gradient in W; B r
    real(real32), intent(inout), contiguous :: d(:)    !! direction of the step
    real(real64), intent(out) :: total                 !! sum of the products
    integer :: i

    total = 0.0_real64
    !$omp simd reduction(+:total)
    do i = 1, size(w)
      d(i) = merge(1.0_real32, 0.0_real32, abs(w(i)) > 0.0_real32) * (z(i) + step * d(i) - mean)
      total = total + real(d(i), real64) * w(i)
    end do
  end subroutine direction_row

  !> Sum of the products of a direction with its displacements, and the largest of those.
  pure subroutine image_row(d, image, sums)
    real(real32), intent(in), contiguous :: d(:), image(:)  !! direction d and A d
    real(real64), intent(out) :: sums(2)
    real(real32) :: largest
    real(real64) :: total
    integer :: i

    largest = 0.0_real32
    total = 0.0_real64
    !$omp simd reduction(+:total) reduction(max:largest)
    do i = 1, size(d)
      total = total + real(d(i), real64) * image(i)
      largest = max(largest, abs(image(i)))
    end do
    sums = [total, real(largest, real64)]
  end subroutine image_row

  !> Forces after a step along the direction, cut at 0 and H; sums of the forces, of the cuts, of 1
  !> and the gradient without the cuts where forces are free.
  pure subroutine step_row(step_limit, f, d, r, image, next, sums)
    real(real64), intent(in) :: step_limit(2)         !! length of the step, largest force
    real(real64), intent(in), contiguous :: f(:), r(:)
    real(real32), intent(in), contiguous :: d(:), image(:)  !! d and A d
    real(real64), intent(out), contiguous :: next(:)  !! f after the step
    real(real64), intent(out) :: sums(4)
    real(real64) :: cuts, force, free, level, limit, number, step, total
    integer :: i

    step = step_limit(1)
    limit = step_limit(2)
    cuts = 0.0_real64
    level = 0.0_real64
    number = 0.0_real64
    total = 0.0_real64
    !$omp simd private(force, free) reduction(+:cuts, level, number, total)
    do i = 1, size(f)
      force = f(i) - step * d(i)
      next(i) = min(limit, max(0.0_real64, force))
      total = total + next(i)
      cuts = cuts + abs(force - next(i))
      free = one_where(next(i) > 0.0_real64) * one_where(next(i) < limit)
      number = number + free
      level = level + free * (r(i) - step * image(i))
    end do
    sums = [total, cuts, number, level]
  end subroutine step_row

  !> Sums of 1 and the gradient where forces are free, of the squares of the forces, and the largest
  !> displacement.
  pure subroutine gradient_row(limit, f, displacement, gap, sums)
    real(real64), intent(in) :: limit                 !! largest force of an element
    real(real64), intent(in), contiguous :: f(:)      !! forces after a step
    !> displacements and gaps, or their changes and the gradient before
    real(real64), intent(in), contiguous :: displacement(:), gap(:)
    real(real64), intent(out) :: sums(4)
    real(real64) :: free, largest, level, number, squares
    integer :: i

    largest = 0.0_real64
    level = 0.0_real64
    number = 0.0_real64
    squares = 0.0_real64
    !$omp simd private(free) reduction(+:level, number, squares) reduction(max:largest)
    do i = 1, size(f)
      free = one_where(f(i) > 0.0_real64) * one_where(f(i) < limit)
      number = number + free
      level = level + free * (displacement(i) + gap(i))
      squares = squares + f(i)**2
      largest = max(largest, abs(displacement(i)))
    end do
    sums = [number, level, squares, largest]
  end subroutine gradient_row

  !> Adds a multiple of displacements to the gradient, and subtracts its level; sums of the decrease
  !> of the energy, twice, and of the bound of the next one, and the residual.
  pure subroutine residual_row(numbers, before, gradient, image, f, r, w, sums)
    real(real64), intent(in) :: numbers(4)            !! level, |A|, largest force, multiple
    real(real64), intent(in), contiguous :: before(:), gradient(:)  !! f and r before the step
    real(real32), intent(in), contiguous :: image(:)  !! displacements to be added
    real(real64), intent(in), contiguous :: f(:)      !! f after the step
    real(real64), intent(inout), contiguous :: r(:)   !! gradient; then that after the step
    real(real32), intent(out), contiguous :: w(:)     !! that in W
    real(real64), intent(out) :: sums(3)
    real(real64) :: above, change, decrease, enough, half, inverse, least, level, limit, multiple, &
                    residual
    integer :: i

    level = numbers(1)
    half = 0.5_real64 * numbers(2)
    inverse = 1.0_real64 / numbers(2)
    limit = numbers(3)
    multiple = numbers(4)
    decrease = 0.0_real64
    enough = 0.0_real64
    residual = 0.0_real64
    !$omp simd private(above, change, least) reduction(+:decrease, enough) reduction(max:residual)
    do i = 1, size(f)
      r(i) = r(i) + multiple * image(i) - level
      decrease = decrease + (before(i) - f(i)) * (gradient(i) + r(i))
      above = min(r(i), one_where(f(i) > 0.0_real64) * huge(level))
      least = -one_where(f(i) < limit) * huge(level)
      w(i) = real(max(least, above), real32)
      residual = max(residual, above, min(-r(i), -least))
      change = f(i) - min(limit, max(0.0_real64, f(i) - inverse * r(i)))
      enough = enough + change * (r(i) - half * change)
    end do
    sums = [decrease, enough, residual]
  end subroutine residual_row

  !> 1 or 0, by which loops multiply.
  elemental real(real64) function one_where(is_true) result(one)
    logical, intent(in) :: is_true  !! whether it is 1

    one = merge(1.0_real64, 0.0_real64, is_true)
  end function one_where

end module asperity_force_rows
