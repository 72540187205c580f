!> Stress in a half-space by pressures and tractions that are uniform on rectangles, and by waves.
!>
!> Sources are a pressure p and tractions qx and qy on the body. Tension is positive, z >= 0 points
!> into the body. Stresses by qy are those by qx with x and y exchanged.
!>
!> Rectangles: with X, Y from the point to a corner, R**2 = X**2 + Y**2 + z**2, t = atan(X Y/(z R)),
!> u = asinh(X/sqrt(Y**2 + z**2)), v = asinh(Y/sqrt(X**2 + z**2)) and w = R + z the stresses are the
!> differences over the four corners of
!>
!>   component  by p, times -1/(2 pi)                             by qx, times 1/(2 pi)
!>   xx         2 nu t + (1 - 2 nu) (atan(Y/X) - atan(z Y/(X R))) 2 v + 2 nu Y/w + z Y/(R w)
!>              - z X Y/(R (X**2 + z**2)); yy alike               - z**2 Y/((X**2 + z**2) R)
!>   yy                                                           2 nu v - 2 nu Y/w - z Y/(R w)
!>   zz         t + X Y z/R (1/(X**2 + z**2) + 1/(Y**2 + z**2))   z**2 Y/((X**2 + z**2) R)
!>   xy         (1 - 2 nu) ln(R + z) + z/R                        u - 2 nu X/w - z X/(R w)
!>   xz         -z**2 Y/(R (X**2 + z**2)); yz alike               z X Y/((X**2 + z**2) R) - t
!>   yz                                                           -z/R
!>
!> (p: Love, Phil. Trans. R. Soc. A 228 (1929) 377; qx: Cerruti's stresses, Johnson, Contact
!> Mechanics, 1985, eq. 3.76, integrated.)
!>
!> Waves: for the numbers qx, qy, with q**2 = qx**2 + qy**2, c = qx/q, s = qy/q and w = q z, the
!> stresses are exp(-w) times
!>
!>   component  by p                                  by qx
!>   xx         -(2 nu + (1 - 2 nu) c**2 - c**2 w)    i c (2 + 2 nu s**2 - c**2 w)
!>   yy         alike                                 i c (2 nu c**2 - s**2 w)
!>   zz         -(1 + w)                              i c w
!>   xy         -c s (1 - 2 nu - w)                   i s (1 - 2 nu c**2 - c**2 w)
!>   xz         i qx z                                -(1 - c**2 w)
!>   yz         i qy z                                c s w
!>
!> (Johnson, sections 2.2 and 13.2, and antiplane shear.) The mean pressure has no lateral strain:
!> xx = yy = -p nu/(1 - nu).
module asperity_stress_kernels
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  implicit none
  private

  public :: corner_function, corner_parity, grid_correction, stress_of_wave

  !> Sources of stress, and the factors of their corner functions.
  integer, parameter, public :: by_pressure = 1, by_traction_x = 2, by_traction_y = 3
  real(real64), parameter, public :: corner_factor(3) = [-1.0_real64, 1.0_real64, 1.0_real64]

  ! Parities of the corner functions in X and in Y, by p and by qx.
  integer, parameter :: parities(2, 6, 2) = reshape([-1, -1, -1, -1, -1, -1, 1, 1, 1, -1, -1, 1, &
                                                     1, -1, 1, -1, 1, -1, -1, 1, -1, -1, 1, 1], &
                                                    [2, 6, 2])
  ! Components with x and y exchanged.
  integer, parameter :: exchanged(6) = [2, 1, 3, 4, 6, 5]

contains

  !> Parities of a corner function in X and in Y.
  pure function corner_parity(source, component) result(mirrored)
    integer, intent(in) :: source, component  !! which of the `by_`; from 1
    integer :: mirrored(2)

    mirrored = parities(:, component, min(source, 2))
    if (source == by_traction_y) mirrored = parities([2, 1], exchanged(component), 2)
  end function corner_parity

  !> A corner function of the header, without its factor over 2 pi.
  pure real(real64) function corner_function(source, component, x, y, z, ratio) result(corner)
    integer, intent(in) :: source, component  !! which of the `by_`; from 1
    real(real64), intent(in) :: x, y          !! X and Y, more than 0
    real(real64), intent(in) :: z             !! depth, 0 or more
    real(real64), intent(in) :: ratio         !! Poisson's ratio, -1 to 0.5

    select case (source)
    case (by_pressure)
      corner = pressure_corner(component, x, y, z, ratio)
    case (by_traction_x)
      corner = traction_corner(component, x, y, z, ratio)
    case default
      corner = traction_corner(exchanged(component), y, x, z, ratio)
    end select
  end function corner_function

  ! Solid angle t of the header; at the surface its limit.
  pure real(real64) function solid_angle(x, y, z, r)
    real(real64), intent(in) :: x, y, z, r

    solid_angle = 0.5_real64 * pi
    if (z > 0.0_real64) solid_angle = atan(x * y / (z * r))
  end function solid_angle

  pure real(real64) function pressure_corner(component, x, y, z, ratio) result(corner)
    integer, intent(in) :: component
    real(real64), intent(in) :: x, y, z, ratio
    real(real64) :: r, solid

    r = sqrt(x**2 + y**2 + z**2)
    solid = solid_angle(x, y, z, r)
    select case (component)
    case (1)
      corner = lateral_corner(x, y)
    case (2)
      corner = lateral_corner(y, x)
    case (3)
      corner = solid + x * y * z / r * (1.0_real64 / (x**2 + z**2) + 1.0_real64 / (y**2 + z**2))
    case (4)
      corner = (1.0_real64 - 2.0_real64 * ratio) * log(r + z) + z / r
    case (5)
      corner = -z**2 * y / (r * (x**2 + z**2))
    case default
      corner = -z**2 * x / (r * (y**2 + z**2))
    end select

  contains

    pure real(real64) function lateral_corner(x, y)
      real(real64), intent(in) :: x, y

      lateral_corner = 2.0_real64 * ratio * solid + (1.0_real64 - 2.0_real64 * ratio) * &
                (atan(y / x) - atan(z * y / (x * r))) - z * x * y / (r * (x**2 + z**2))
    end function lateral_corner

  end function pressure_corner

  pure real(real64) function traction_corner(component, x, y, z, ratio) result(corner)
    integer, intent(in) :: component
    real(real64), intent(in) :: x, y, z, ratio
    real(real64) :: r

    r = sqrt(x**2 + y**2 + z**2)
    select case (component)
    case (1)
      corner = 2.0_real64 * asinh(y / hypot(x, z)) + (2.0_real64 * ratio + z / r) * y / (r + z) - &
               z**2 * y / ((x**2 + z**2) * r)
    case (2)
      corner = 2.0_real64 * ratio * asinh(y / hypot(x, z)) - (2.0_real64 * ratio + z / r) * y / &
               (r + z)
    case (3)
      corner = z**2 * y / ((x**2 + z**2) * r)
    case (4)
      corner = asinh(x / hypot(y, z)) - (2.0_real64 * ratio + z / r) * x / (r + z)
    case (5)
      corner = z * x * y / ((x**2 + z**2) * r) - solid_angle(x, y, z, r)
    case default
      corner = -z / r
    end select
  end function traction_corner

  !> Error of a component at the centre of a pixel by steps of tractions, with the sign reversed.
  !>
  !> The stress xx by a wave of qx near the surface is i c (2 - w) exp(-w) of it, odd, of order 0.
  !> A traction that is uniform on pixels of the side h adds, to the wave q, waves q + 2 pi k/h of
  !> the relative size (-1)**k q h/(2 pi k). At the centres all are one wave: the sum over k is
  !> -h dq/dx (2 L - W), with L = ln(1 + e)/pi, W = (2 pi z/h) e/(1 + e)/pi and e = exp(-2 pi z/h).
  !> Without it the stress is in error by O(h) at the surface, with it by O(h**2); it fades within
  !> the depth of a pixel. Other components alike.
  pure real(real64) function grid_correction(component, depth, side, ratio, steps) result(lacking)
    integer, intent(in) :: component        !! of the stress, from 1
    real(real64), intent(in) :: depth       !! below the surface, 0 or more
    real(real64), intent(in) :: side(2)     !! of a pixel along x and y
    real(real64), intent(in) :: ratio       !! Poisson's ratio of the body
    !> (traction, axis): half of the difference of the neighbours along the axis
    real(real64), intent(in) :: steps(2, 2)
    real(real64), dimension(2) :: e, l, w

    e = exp(-2.0_real64 * pi * depth / side)
    l = log(1.0_real64 + e) / pi
    w = 2.0_real64 * depth / side * e / (1.0_real64 + e)
    select case (component)
    case (1, 2)
      lacking = (2.0_real64 * l(component) - w(component)) * steps(component, component) + &
                2.0_real64 * ratio * l(3 - component) * steps(3 - component, 3 - component)
    case (3)
      lacking = w(1) * steps(1, 1) + w(2) * steps(2, 2)
    case (4)
      lacking = l(2) * steps(1, 2) + l(1) * steps(2, 1)
    case default
      lacking = 0.0_real64
    end select
  end function grid_correction

  !> Factor of a wave: stress over source. The sign of the shortest wave along a side is not known:
  !> components that are odd in it have none.
  pure complex(real64) function stress_of_wave(source, component, wave, odd, depth, ratio) &
    result(factor)
    integer, intent(in) :: source, component  !! which of the `by_`; from 1
    real(real64), intent(in) :: wave(2)       !! numbers along x and y
    real(real64), intent(in) :: odd(2)        !! the same, 0 where the sign is not known
    real(real64), intent(in) :: depth         !! below the surface, 0 or more
    real(real64), intent(in) :: ratio         !! Poisson's ratio of the body
    real(real64) :: q

    q = hypot(wave(1), wave(2))
    select case (source)
    case (by_pressure)
      if (.not. q > 0.0_real64) then
        factor = merge(1.0_real64, 0.0_real64, component == 3)
        if (component < 3) factor = ratio / (1.0_real64 - ratio)
      else
        select case (component)
        case (1, 2)
          factor = 2.0_real64 * ratio + (wave(component) / q)**2 * &
                   (1.0_real64 - 2.0_real64 * ratio - q * depth)
        case (3)
          factor = 1.0_real64 + q * depth
        case (4)
          factor = odd(1) * odd(2) / q**2 * (1.0_real64 - 2.0_real64 * ratio - q * depth)
        case default
          factor = cmplx(0.0_real64, -odd(component - 4) * depth, real64)
        end select
      end if
      factor = -exp(-q * depth) * factor
    case (by_traction_x)
      factor = exp(-q * depth) * wave_of_traction(component, wave, odd, q, depth, ratio)
    case default
      factor = exp(-q * depth) * wave_of_traction(exchanged(component), wave([2, 1]), odd([2, 1]), &
                                                  q, depth, ratio)
    end select
  end function stress_of_wave

  ! The factors by qx of the header without exp(-w).
  pure complex(real64) function wave_of_traction(component, wave, odd, q, depth, ratio) &
    result(factor)
    integer, intent(in) :: component
    real(real64), intent(in) :: wave(2), odd(2), q, depth, ratio
    real(real64) :: across, along

    factor = merge(-1.0_real64, 0.0_real64, component == 5)
    if (.not. q > 0.0_real64) return
    along = (wave(1) / q)**2
    across = (wave(2) / q)**2
    select case (component)
    case (1)
      factor = odd(1) / q * (2.0_real64 + 2.0_real64 * ratio * across - along * q * depth)
    case (2)
      factor = odd(1) / q * (2.0_real64 * ratio * along - across * q * depth)
    case (3)
      factor = odd(1) * depth
    case (4)
      factor = odd(2) / q * (1.0_real64 - (2.0_real64 * ratio + q * depth) * along)
    case (5)
      factor = along * q * depth - 1.0_real64
    case default
      factor = odd(1) * odd(2) / q * depth
    end select
    if (component <= 4) factor = (0.0_real64, 1.0_real64) * factor
  end function wave_of_traction

end module asperity_stress_kernels
