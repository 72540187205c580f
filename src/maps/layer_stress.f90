!> Stress in a layer that is bonded to a half-space, and below it, by a wave of pressure.
!>
!> Airy's function of a wave of the number q is f(x) exp(i q s) along the wave, with x = q z. The
!> stresses are f'' along it, -f down, i T with T = -f' in shear, nu times the sum of the first two
!> across. f is a sum of exp(-x), x exp(-x) and of the growing pair, which begins at the base, in
!> the layer, and of the decaying pair in the base: six coefficients from pressure and shear at the
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

  public :: add_free_layer, along_axes, layer_stress, tabulate_layer

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

  !> Tabulates what a layer changes of the stresses by a point load, at radii t sinh(k step) from
  !> k = -1.
  !>
  !> The changes d of the stresses of a wave give, over 2 pi, the integrals over q of
  !> (d(along) + d(across)) J0 q/2, -(d(along) - d(across)) J2 q/2, d(down) J0 q and -dT J1 q
  !> (Hankel): of (xx + yy)/2, of (xx - yy)/2 over cos(2 phi), which is xy over sin(2 phi), of zz,
  !> and of xz over cos(phi). They are smooth at the scale of the thickness.
  subroutine tabulate_layer(body, depth, largest, step, tables)
    type(layered_body), intent(in) :: body     !! layer and base
    real(real64), intent(in) :: depth          !! below the surface, 0 or more
    real(real64), intent(in) :: largest        !! radius that is needed [length]
    real(real64), intent(out) :: step          !! step of the table
    real(real64), allocatable, intent(out) :: tables(:, :)  !! by node and function
    real(real64), allocatable :: changes(:, :), j0(:), j1(:), x(:)
    real(real64) :: panel, w
    integer :: g, i, k, n

    step = asinh(far) / (nodes - 2)
    n = ceiling(last_number * max(1.0_real64, min(largest / body%thickness, far) / &
                                              (2.0_real64 * pi)))
    panel = last_number / n
    allocate (tables(-1:nodes, 4), changes(n * gauss_points, 4), x(n * gauss_points))
    !$omp parallel do private(g, k, w)
    do i = 1, n
      do k = 1, gauss_points
        g = (i - 1) * gauss_points + k
        x(g) = (i - 1 + gauss_node(k)) * panel
        w = x(g) * depth / body%thickness
        changes(g, :) = (layer_stress(body, x(g) / body%thickness, depth) - exp(-w) * &
                         [w - 1.0_real64, -2.0_real64 * body%ratio(1), -1.0_real64 - w, w]) * &
                        x(g) * panel * gauss_weight(k) / (2.0_real64 * pi)
      end do
    end do
    !$omp end parallel do
    !$omp parallel private(j0, j1)
    allocate (j0, j1, mold=x)
    !$omp do schedule(dynamic)
    do i = 0, nodes
      associate (r => max(sinh(i * step), epsilon(step)))
        j0 = bessel_j0(x * r)
        j1 = bessel_j1(x * r)
        tables(i, 1) = 0.5_real64 * sum((changes(:, 1) + changes(:, 2)) * j0)
        tables(i, 2) = -0.5_real64 * sum((changes(:, 1) - changes(:, 2)) * &
                                         (2.0_real64 * j1 / (x * r) - j0))
        tables(i, 3) = sum(changes(:, 3) * j0)
        tables(i, 4) = -sum(changes(:, 4) * j1)
      end associate
    end do
    !$omp end do nowait
    !$omp end parallel
    tables(-1, :) = [1, 1, 1, -1] * tables(1, :)
  end subroutine tabulate_layer

  !> Adds to the influence of unit pressure of an element of a free lattice on a component what the
  !> layer changes of it.
  subroutine add_free_layer(tables, step, side, elements, component, kernel)
    real(real64), allocatable, intent(in) :: tables(:, :)  !! those of `tabulate_layer`
    real(real64), intent(in) :: step               !! step of the table
    real(real64), intent(in) :: side(2)            !! of an element along x and y over the thickness
    integer, intent(in) :: elements(2)             !! numbers of columns and rows
    integer, intent(in) :: component               !! xx, yy, zz, xy, xz, yz
    real(real64), intent(inout) :: kernel(0:, 0:)  !! by offset on the padded lattice
    ! Multiples of the angle in cosine and sine, functions, and signs.
    integer, parameter :: angles(2, 6) = reshape([2, 0, 2, 0, 0, 0, 0, 2, 1, 0, 0, 1], [2, 6])
    integer, parameter :: of_angle(6) = [2, 2, 3, 2, 4, 4], signs(6) = [1, -1, 1, 1, 1, 1]
    real(real64), allocatable :: mean(:), table(:)
    real(real64) :: value
    integer :: i, j, k, l

    allocate (mean(-1:nodes), source=tables(:, 1))
    allocate (table(-1:nodes), source=signs(component) * tables(:, of_angle(component)))
    !$omp parallel do private(i, k, l, value)
    do j = 0, elements(2) - 1
      do i = 0, elements(1) - 1
        value = integral_of(table, step, side, i, j, merge(2, 3, of_angle(component) == 2), &
                            angles(:, component))
        if (component < 3) value = value + integral_of(mean, step, side, i, j, 3)
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
