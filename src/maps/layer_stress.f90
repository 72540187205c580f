!> Stress in a layer that is bonded to a half-space, and below it, by a wave of pressure.
!>
!> Airy's function of a wave of the number q is f(x) exp(i q s) along the wave, with x = q z. The
!> stresses are f'' along it, -f down, i T with T = -f' in shear, nu times the sum of the first two
!> across. f is a sum of exp(-x), x exp(-x) and of the growing pair, which begins at the base, in the
!> layer, and of the decaying pair in the base: six coefficients from pressure and shear at the
!> surface and from stresses and displacements at the base,
!>
!>   2 G q U = -((1 - nu) f'' + nu f),  2 G q W = (1 - nu) f''' - (2 - nu) f'
!>
!> (plane strain; Johnson, Contact Mechanics, 1985, section 2.2).
module asperity_layer_stress
  use asperity_constants, only: pi
  use asperity_gauss_rule, only: gauss_node, gauss_points, gauss_weight
  use asperity_height_map, only: layered_body
  use asperity_kinds, only: real64
  use asperity_layer_compliance, only: far, integral_of, nodes, shear_ratio
  implicit none
  private

  public :: add_free_layer, along_axes, layer_stress

  ! Largest x of the waves (derived: what a layer changes falls as exp(-x) at its base, to 1e-17).
  real(real64), parameter :: last_number = 40.0_real64

contains

  !> Stresses along, across and down the wave, and T, by a pressure of 1. At the base those of the
  !> layer.
  pure function layer_stress(body, q, depth) result(stress)
    type(layered_body), intent(in) :: body  !! layer and base
    real(real64), intent(in) :: q           !! wave number, more than 0
    real(real64), intent(in) :: depth       !! below the surface, 0 or more
    real(real64) :: stress(4)
    real(real64) :: system(6, 7), parts(5, 6), total(5)
    integer :: first, last, material

    system = 0.0_real64
    associate (base => q * body%thickness, soft => shear_ratio(body), nu => body%ratio)
      parts = 0.0_real64
      parts(:, :4) = layer_parts(0.0_real64)
      system(:2, :4) = parts(:2, :4)
      parts(:, :4) = layer_parts(base)
      parts(:, 5:) = -wave_parts(0.0_real64, -1, soft, nu(2))
      system(3:, :6) = parts(:4, :)
      system(1, 7) = -1.0_real64
      call solve_system(system)
      if (depth > body%thickness) then
        parts(:, 5:) = wave_parts(q * depth - base, -1, soft, nu(2))
        first = 5
        last = 6
      else
        parts(:, :4) = layer_parts(q * depth)
        first = 1
        last = 4
      end if
      total = matmul(parts(:, first:last), system(first:last, 7))
      material = merge(2, 1, first == 5)
      stress = [total(5), nu(material) * (total(5) + total(1)), total(1), total(2)]
    end associate

  contains

    pure function layer_parts(x) result(parts)
      real(real64), intent(in) :: x
      real(real64) :: parts(5, 4)

      parts(:, :2) = wave_parts(x, -1, 1.0_real64, body%ratio(1))
      parts(:, 3:) = wave_parts(x - q * body%thickness, 1, 1.0_real64, body%ratio(1))
    end function layer_parts

  end function layer_stress

  !> A component of the stresses of a wave.
  pure complex(real64) function along_axes(component, wave, odd, stress) result(factor)
    integer, intent(in) :: component       !! xx, yy, zz, xy, xz, yz
    real(real64), intent(in) :: wave(2)    !! numbers along x and y, not both 0
    real(real64), intent(in) :: odd(2)     !! the same, 0 where the sign is not known
    real(real64), intent(in) :: stress(4)  !! those of `layer_stress`

    associate (square => wave**2 / sum(wave**2))
      select case (component)
      case (1, 2)
        factor = square(component) * stress(1) + square(3 - component) * stress(2)
      case (3)
        factor = stress(3)
      case (4)
        factor = odd(1) * odd(2) / sum(wave**2) * (stress(1) - stress(2))
      case default
        factor = cmplx(0.0_real64, odd(component - 4) / norm2(wave) * stress(4), real64)
      end select
    end associate
  end function along_axes

  !> Adds to a component by unit pressure of an element of a free lattice what the layer changes of
  !> it: the half-space of the surface material is exact there.
  !>
  !> The changes d of the stresses of a wave give, over 2 pi, the integrals over q of d(down) J0 q,
  !> of (d(along) + d(across)) J0 q/2, -(d(along) - d(across)) cos(2 phi) J2 q/2 and -dT cos(phi) J1 q
  !> (Hankel), which are smooth at the scale of the thickness.
  subroutine add_free_layer(body, depth, component, side, elements, kernel)
    type(layered_body), intent(in) :: body      !! layer and base
    real(real64), intent(in) :: depth           !! below the surface, 0 or more
    integer, intent(in) :: component            !! xx, yy, zz, xy, xz, yz
    real(real64), intent(in) :: side(2)         !! of an element along x and y
    integer, intent(in) :: elements(2)          !! numbers of columns and rows
    real(real64), intent(inout) :: kernel(0:, 0:)  !! by offset on the padded lattice
    real(real64), allocatable :: isotropic(:), angular(:)
    real(real64) :: step, value
    integer :: angle(2), i, j, k, l

    call fill_tables(body, depth, component, norm2(side * elements), step, isotropic, angular)
    angle = 0
    if (component /= 3) angle(merge(2, 1, component == 4 .or. component == 6)) = &
      merge(2, 1, component < 5)
    !$omp parallel do private(i, k, l, value)
    do j = 0, elements(2) - 1
      do i = 0, elements(1) - 1
        value = integral_of(angular, step, side / body%thickness, i, j, merge(2, 3, component < 5), &
                            angle)
        if (component <= 3) value = value + integral_of(isotropic, step, side / body%thickness, &
                                                        i, j, 3)
        do k = -1, 1, 2
          do l = -1, 1, 2
            if ((k < 0 .and. i == 0) .or. (l < 0 .and. j == 0)) cycle
            associate (entry => kernel(modulo(k * i, size(kernel, 1)), &
                                       modulo(l * j, size(kernel, 2))))
              entry = entry + value * merge(k, 1, any(component == [4, 5])) * &
                      merge(l, 1, any(component == [4, 6]))
            end associate
          end do
        end do
      end do
    end do
    !$omp end parallel do
  end subroutine add_free_layer

  ! Tabulates the integrals of a component at radii t sinh(i step), i = -1, 0, ...
  subroutine fill_tables(body, depth, component, largest, step, isotropic, angular)
    type(layered_body), intent(in) :: body
    real(real64), intent(in) :: depth, largest
    integer, intent(in) :: component
    real(real64), intent(out) :: step
    real(real64), allocatable, intent(out) :: isotropic(:), angular(:)
    real(real64), allocatable :: changes(:, :), x(:)
    real(real64) :: panel, w
    integer :: g, i, n

    associate (radius => min(largest / body%thickness, far))
      step = asinh(far) / (nodes - 2)
      n = ceiling(last_number * max(1.0_real64, radius / (2.0_real64 * pi)))
    end associate
    panel = last_number / n
    allocate (isotropic(-1:nodes), angular(-1:nodes), source=0.0_real64)
    allocate (changes(4, n * gauss_points), x(n * gauss_points))
    !$omp parallel do private(g, w)
    do i = 1, n
      do g = (i - 1) * gauss_points + 1, i * gauss_points
        x(g) = (i - 1 + gauss_node(g - (i - 1) * gauss_points)) * panel
        w = x(g) * depth / body%thickness
        changes(:, g) = (layer_stress(body, x(g) / body%thickness, depth) - exp(-w) * &
                         [w - 1.0_real64, -2.0_real64 * body%ratio(1), -1.0_real64 - w, w]) * &
                        x(g) * panel * gauss_weight(g - (i - 1) * gauss_points) / (2.0_real64 * pi)
      end do
    end do
    !$omp end parallel do
    !$omp parallel do schedule(dynamic)
    do i = 0, nodes
      associate (r => sinh(i * step))
        select case (component)
        case (1, 2)
          isotropic(i) = 0.5_real64 * sum((changes(1, :) + changes(2, :)) * bessel_j0(x * r))
          angular(i) = (component - 1.5_real64) * sum((changes(1, :) - changes(2, :)) * &
                                                      bessel_jn(2, x * r))
        case (3)
          isotropic(i) = sum(changes(3, :) * bessel_j0(x * r))
        case (4)
          angular(i) = -0.5_real64 * sum((changes(1, :) - changes(2, :)) * bessel_jn(2, x * r))
        case default
          angular(i) = -sum(changes(4, :) * bessel_j1(x * r))
        end select
      end associate
    end do
    !$omp end parallel do
    isotropic(-1) = isotropic(1)
    angular(-1) = merge(-1, 1, component > 4) * angular(1)
  end subroutine fill_tables

  ! Down, T, 2 G U, 2 G W and along, of exp(growth x) and x exp(growth x).
  pure function wave_parts(x, growth, softness, ratio) result(parts)
    real(real64), intent(in) :: x, softness, ratio  ! softness: shear modulus of the layer over G
    integer, intent(in) :: growth  ! 1 or -1
    real(real64) :: parts(5, 2)
    real(real64) :: d(0:3, 2), e  ! derivatives

    e = exp(growth * x)
    d(:, 1) = e * [1, growth, 1, growth]
    d(:, 2) = e * [x, 1.0_real64 + growth * x, 2.0_real64 * growth + x, 3.0_real64 + growth * x]
    parts(1, :) = -d(0, :)
    parts(2, :) = -d(1, :)
    parts(3, :) = -softness * ((1.0_real64 - ratio) * d(2, :) + ratio * d(0, :))
    parts(4, :) = softness * ((1.0_real64 - ratio) * d(3, :) - (2.0_real64 - ratio) * d(1, :))
    parts(5, :) = d(2, :)
  end function wave_parts

  ! Gauss's elimination with pivots over the largest entry of a row; the last column is solved.
  pure subroutine solve_system(system)
    real(real64), intent(inout) :: system(:, :)
    integer :: i, j, n

    n = size(system, 1)
    do i = 1, n
      system(i, :) = system(i, :) / maxval(abs(system(i, :n)))
    end do
    do i = 1, n
      j = i - 1 + maxloc(abs(system(i:, i)), 1)
      if (j > i) system([i, j], :) = system([j, i], :)
      system(i, :) = system(i, :) / system(i, i)
      do j = 1, n
        if (j /= i) system(j, :) = system(j, :) - system(j, i) * system(i, :)
      end do
    end do
  end subroutine solve_system

end module asperity_layer_stress
