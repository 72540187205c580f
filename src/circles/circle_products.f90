!> Products of the Hessian of the potential with changes of loads and shifts.
!>
!> The exact model has all second derivatives of near pairs, and of far pairs those by loads: the
!> others are of the order (radius/distance)**3. The convex model leaves out the terms that may be
!> negative: negative growth by the own radius, load with shift, and shift with shift of other
!> circles. It raises the second derivatives by the own shift until they are positive definite.
module asperity_circle_products
  use asperity_circle_field, only: circle_set, compliance, direction_x, direction_y, first_slope, &
                                   flat_spread, hessian_anisotropy, large_set, &
                                   least_curvature_share, second_slope, slope_over_distance
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  use asperity_source_tree, only: sum_sources
  implicit none
  private

  public :: lowest_shift, multiply, convex_hessian

contains

  !> Newton step of a shift, with a raised Hessian: a direction of descent in any case.
  pure function lowest_shift(hessian, isolated, slope) result(shift)
    real(real64), intent(in) :: hessian(3)  !! second derivatives by the shift: xx, xy, yy
    real(real64), intent(in) :: isolated   !! second derivative without neighbours, more than 0
    real(real64), intent(in) :: slope(2)   !! first derivatives along x and y
    real(real64) :: shift(2), h(3), s(2)
    integer :: power

    ! Powers of two change no digit; products of small loads would underflow.
    power = exponent(isolated)
    h = convex_hessian(scale(hessian, -power), scale(isolated, -power))
    s = scale(slope, -power)
    shift = -[h(3) * s(1) - h(2) * s(2), h(1) * s(2) - h(2) * s(1)] / (h(1) * h(3) - h(2)**2)
  end function lowest_shift

  !> Second derivatives by a shift, with a share of the identity added so that they are definite.
  pure function convex_hessian(hessian, isolated) result(raised)
    real(real64), intent(in) :: hessian(3)  !! second derivatives: xx, xy, yy
    real(real64), intent(in) :: isolated   !! second derivative without neighbours, more than 0
    real(real64) :: raised(3)

    raised = hessian + [1, 0, 1] * max(0.0_real64, least_curvature_share * isolated - &
             0.5_real64 * (hessian(1) + hessian(3) - hypot(hessian(1) - hessian(3), 2 * &
                                                           hessian(2))))
  end function convex_hessian

  !> Multiplies the Hessian of the potential by changes of loads and shifts.
  subroutine multiply(set, convex, change, image)
    type(circle_set), intent(inout) :: set      !! circles with their field; only its tree changes
    logical, intent(in) :: convex               !! the convex model in place of the exact one
    real(real64), intent(in) :: change(:, :)    !! (3, circle): of load, of shift along x and y
    real(real64), intent(out) :: image(:, :)    !! product, load and shift (3, circle)
    real(real64), allocatable :: far(:, :)
    real(real64) :: row(3), relative_shift(2), slope_own, slope_other, direction(2)
    integer :: i, j, k, l, n

    n = size(set%x)
    allocate (far(6, n))
    if (convex) then
      call sum_sources(set%tree, change(1, :), flat_spread(set%radius), far, set%shift_since, &
                       low_order=.true.)
    else
      call sum_sources(set%tree, change(1, :), flat_spread(set%radius), far, set%shift_since, &
                       low_order=.true., dipole=spread(set%load, 1, 2) * change(2:, :))
    end if
    !$omp parallel do schedule(static) if(n > large_set) &
    !$omp   private(i, j, k, l, row, relative_shift, slope_own, slope_other, direction)
    do i = 1, n
      row(1) = far(1, i) / pi + change(1, i) / set%stiffness(i)
      associate (growth_term => set%growth(i) / (3 * set%load(i)))
        row(1) = row(1) + merge(max(0.0_real64, growth_term), growth_term, convex) * &
          change(1, i)
      end associate
      if (convex) then
        associate (isolated => set%load(i) * set%curvature(i))
          row(2:) = own_hessian_product(set, i, convex_hessian(set%hessian(:, i), isolated), &
                                        change(2:, i))
        end associate
        do l = set%tree%first(i), set%tree%first(i + 1) - 1
          row(1) = row(1) + set%terms(compliance, set%pair(l)) * change(1, set%tree%near(l))
        end do
      else
        direction = set%shift(:, i) * set%curvature(i) + set%flat_slope(:, i)
        row(1) = row(1) + dot_product(direction, change(2:, i))
        row(2:) = direction * change(1, i) + set%load(i) * &
                  (far(3:4, i) / pi + own_hessian_product(set, i, set%far_hessian(:, i), &
                                                          change(2:, i)))
        do l = set%tree%first(i), set%tree%first(i + 1) - 1
          j = set%tree%near(l)
          k = set%pair(l)
          slope_own = set%terms(merge(first_slope, second_slope, i < j), k)
          slope_other = set%terms(merge(second_slope, first_slope, i < j), k)
          direction = merge(1.0_real64, -1.0_real64, i < j) * set%terms(direction_x:direction_y, k)
          relative_shift = change(2:, i) - change(2:, j)
          row(1) = row(1) + set%terms(compliance, k) * change(1, j) - &
                   slope_own * set%load(j) * dot_product(direction, change(2:, j))
          row(2:) = row(2:) + set%load(i) * (direction * (slope_other * change(1, j) + &
            set%load(j) * set%terms(hessian_anisotropy, k) * &
              dot_product(direction, relative_shift)) + &
            set%load(j) * set%terms(slope_over_distance, k) * relative_shift)
        end do
      end if
      if (set%shift_fixed(i)) row(2:) = 0.0_real64
      image(:, i) = row
    end do
    !$omp end parallel do
  end subroutine multiply

  ! Second derivatives xx, xy, yy times a shift; zero where the shift is fixed.
  pure function own_hessian_product(set, i, hessian, shift) result(slope)
    type(circle_set), intent(in) :: set
    integer, intent(in) :: i
    real(real64), intent(in) :: hessian(3), shift(2)
    real(real64) :: slope(2)

    slope = 0.0_real64
    if (.not. set%shift_fixed(i)) slope = [dot_product(hessian(1:2), shift), &
                                           dot_product(hessian(2:3), shift)]
  end function own_hessian_product

end module asperity_circle_products
