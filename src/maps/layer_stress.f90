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
  use asperity_height_map, only: layered_body
  use asperity_kinds, only: real64
  use asperity_layer_compliance, only: shear_ratio
  implicit none
  private

  public :: along_axes, layer_stress

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
