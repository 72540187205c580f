!> Surface displacements of half-spaces under bonded layers.
!>
!> A wave of pressure of the number q on a layer of the thickness t, with the shear modulus G1 and
!> Poisson's ratio nu1, on a half-space (G2, nu2) displaces the surface by
!>
!>   C(q) = (1 - nu1)/(G1 q) (1 + 4 x k e - l k e**2)/(1 - (l + k + 4 k x**2) e + l k e**2)
!>
!> with x = q t, e = exp(-2 x), M = G1/G2, l = 1 - 4 (1 - nu1)/(1 + M (3 - 4 nu2)) and
!> k = (M - 1)/(M + 3 - 4 nu1) (Burmister 1945; O'Sullivan and King, J. Tribol. 110 (1988) 235). The
!> factor behind (1 - nu1)/(G1 q) is 1 where q is large, and (1 - nu2) G1/((1 - nu1) G2) where q is
!> small. On a rigid base, M = 0, the mean pressure has the displacement
!> t (1 - 2 nu1)/(2 G1 (1 - nu1)); on others, in waves, it has none.
!>
!> Displacements of two bodies are times the combined modulus of their surfaces: each body has its
!> share of 2/q, (1 - nu**2)/E of its surface over that of both.
module asperity_layer_compliance
  use asperity_constants, only: pi
  use asperity_gauss_rule, only: gauss_node, gauss_points, gauss_weight
  use asperity_height_map, only: layered_body
  use asperity_kinds, only: real64
  implicit none
  private

  public :: add_layers, far, integral_of, layer_factor, mean_displacement, nodes, shear_ratio

  ! Largest x of the waves (derived: the rest behind the image falls as x**2 exp(-2 x), to 1e-17).
  real(real64), parameter :: last_number = 22.0_real64
  !> Nodes of the table of radii (chosen: cubics are then in error by 1e-7 of it; test: Hankel's
  !> integral in test/maps/test_layers.py).
  integer, parameter :: nodes = 300
  ! Distance in thicknesses from which on an element needs no finer squares, radius from which on
  ! the rest falls as its cube, and the largest number of squares along an element (derived: rest(q)
  ! is analytic in q, its even powers give r**-3, r**-5 ...: errors of the order of the square of
  ! 1/far, and of the thickness over an element of many squares; test: test/maps/test_layers.py).
  real(real64), parameter :: near = 8.0_real64, most_squares = 1000.0_real64
  !> Largest radius of the table, in thicknesses (derived: as above).
  real(real64), parameter :: far = 50.0_real64

contains

  !> Ratio of the shear moduli of layer and base; 0: the base is rigid.
  elemental real(real64) function shear_ratio(body) result(ratio)
    type(layered_body), intent(in) :: body  !! layer and base

    ratio = 0.0_real64
    if (body%modulus(2) > 0.0_real64) ratio = body%modulus(1) * (1.0_real64 + body%ratio(2)) / &
                                              (body%modulus(2) * (1.0_real64 + body%ratio(1)))
  end function shear_ratio

  !> Displacement by a wave over that of the surface material alone, both bodies together.
  pure real(real64) function layer_factor(bodies, q) result(factor)
    type(layered_body), intent(in) :: bodies(:)  !! one or both
    real(real64), intent(in) :: q                !! wave number, more than 0

    factor = sum(body_shares(bodies) * (1.0_real64 + factor_excess(bodies, q * bodies%thickness)))
  end function layer_factor

  !> Displacement times the modulus by a mean pressure of 1 [length].
  pure real(real64) function mean_displacement(bodies) result(displacement)
    type(layered_body), intent(in) :: bodies(:)  !! one or both

    displacement = sum(body_shares(bodies) * bodies%thickness * (1.0_real64 - 2.0_real64 * &
                       bodies%ratio(1)) / (1.0_real64 - bodies%ratio(1))**2, &
                       mask=bodies%thickness > 0.0_real64 .and. &
                            .not. bodies%modulus(2) > 0.0_real64)
  end function mean_displacement

  ! Shares of the bodies in the displacement by short waves.
  pure function body_shares(bodies) result(share)
    type(layered_body), intent(in) :: bodies(:)  ! moduli of 0: a rigid one
    real(real64) :: share(size(bodies))

    share = 0.0_real64
    where (bodies%modulus(1) > 0.0_real64) share = (1.0_real64 - bodies%ratio(1)**2) / &
                                                   bodies%modulus(1)
    share = share / max(sum(share), tiny(share))
  end function body_shares

  ! The factor of C(q) in the header, less 1. With c = 3 - 4 nu of layer and base the numerator is
  ! 1 - l k + 2 e (l k (sinh 2x - 2x) + k (1 + l) 2x): nothing cancels where x is small.
  elemental real(real64) function factor_excess(body, x) result(excess)
    type(layered_body), intent(in) :: body
    real(real64), intent(in) :: x
    real(real64) :: c(2), e, k, l, m, y

    excess = 0.0_real64
    if (.not. body%thickness > 0.0_real64) return
    m = shear_ratio(body)
    c = 3.0_real64 - 4.0_real64 * body%ratio
    l = (m * c(2) - c(1)) / (1.0_real64 + m * c(2))
    k = (m - 1.0_real64) / (m + c(1))
    y = 2.0_real64 * x
    e = exp(-y)
    associate (denominator => (1.0_real64 - l * e) * (1.0_real64 - k * e) - k * y**2 * e)
      if (y > 0.5_real64) then
        excess = e * (l + k + k * y * (2.0_real64 + y) - 2.0_real64 * l * k * e) / denominator
      else
        ! Series of sinh y - y, to 1e-17 of it.
        excess = y**3 / 6.0_real64 * (1.0_real64 + y**2 / 20.0_real64 * (1.0_real64 + y**2 / &
                 42.0_real64 * (1.0_real64 + y**2 / 72.0_real64 * (1.0_real64 + y**2 / &
                 110.0_real64))))
        excess = (m * (1.0_real64 + c(1)) * (1.0_real64 + c(2)) / &
                  ((1.0_real64 + m * c(2)) * (m + c(1))) + 2.0_real64 * e * (l * k * excess + &
                  k * (1.0_real64 + l) * y)) / denominator - 1.0_real64
      end if
    end associate
  end function factor_excess

  !> Adds the layers to displacements times the modulus at the centres of elements by unit pressure
  !> on one of them, over the side along x.
  !>
  !> The factor of C(q) is 1 + d exp(-2 x) + rest(q), d + 1 its value for small q: Boussinesq's
  !> point load, its image at the height 2 t, whose integral over an element is closed, and the
  !> rest, the integral of rest(q) J0(q r) over q (Hankel). It is smooth at the scale of t: cubic
  !> interpolation in asinh(r/t), Gauss's rule on squares of an element.
  subroutine add_layers(bodies, side, table)
    type(layered_body), intent(in) :: bodies(:)       !! one or both
    real(real64), intent(in) :: side(2)               !! of an element along x and y [length]
    real(real64), intent(inout) :: table(0:, 0:)      !! (columns, rows): by offset
    real(real64), allocatable :: rest(:)
    real(real64) :: corner(0:1, 0:1), d, share(size(bodies)), step, x, y
    integer :: b, i, j, k, l

    share = body_shares(bodies)
    do b = 1, size(bodies)
      associate (body => bodies(b), s => 2.0_real64 * bodies(b)%thickness)
        if (.not. body%thickness > 0.0_real64) cycle
        d = shear_ratio(body) * (1.0_real64 - body%ratio(2)) / (1.0_real64 - body%ratio(1)) - &
            1.0_real64
        step = asinh(far) / (nodes - 2)
        call fill_rest(body, d, step, rest)
        !$omp parallel do private(i, k, l, x, y, corner)
        do j = 0, ubound(table, 2)
          do i = 0, ubound(table, 1)
            do l = 0, 1
              do k = 0, 1
                x = (i + k - 0.5_real64) * side(1)
                y = (j + l - 0.5_real64) * side(2)
                corner(k, l) = x * asinh(y / hypot(x, s)) + y * asinh(x / hypot(y, s)) - &
                               s * atan(x * y / (s * norm2([x, y, s])))
              end do
            end do
            table(i, j) = table(i, j) + share(b) / (pi * side(1)) * &
              (d * ((corner(1, 1) - corner(0, 1)) - (corner(1, 0) - corner(0, 0))) + &
               integral_of(rest, step, side / body%thickness, i, j, 3) * body%thickness)
          end do
        end do
        !$omp end parallel do
      end associate
    end do
  end subroutine add_layers

  ! Tabulates the rest at radii t sinh(i step), i = -1, 0, ...
  subroutine fill_rest(body, d, step, rest)
    type(layered_body), intent(in) :: body
    real(real64), intent(in) :: d, step
    real(real64), allocatable, intent(out) :: rest(:)
    real(real64) :: r, panel, x
    integer :: g, i, k

    allocate (rest(-1:nodes), source=0.0_real64)
    !$omp parallel do private(r, panel, x, g, k) schedule(dynamic)
    do i = 0, nodes
      ! Ten points for a period of J0 and for a unit of x at least.
      r = sinh(i * step)
      panel = min(1.0_real64, 2.0_real64 * pi / max(r, tiny(r)))
      panel = last_number / ceiling(last_number / panel)
      do k = 0, nint(last_number / panel) - 1
        do g = 1, gauss_points
          x = (k + gauss_node(g)) * panel
          rest(i) = rest(i) + panel * gauss_weight(g) * bessel_j0(x * r) * &
                    (factor_excess(body, x) - d * exp(-2.0_real64 * x))
        end do
      end do
    end do
    !$omp end parallel do
    rest(-1) = rest(1)
  end subroutine fill_rest

  !> Integral of a function of the radius over the element at an offset, times the cosine or sine of
  !> a multiple of the angle. Lengths are over the thickness.
  pure real(real64) function integral_of(rest, step, side, i, j, power, angle) result(integral)
    real(real64), allocatable, intent(in) :: rest(:)  !! values at radii sinh(k step), from k = -1
    real(real64), intent(in) :: step                  !! step of the inverse hyperbolic sine
    real(real64), intent(in) :: side(2)               !! of the element along x and y
    integer, intent(in) :: i, j                       !! columns and rows of the offset, 0 or more
    integer, intent(in) :: power                      !! of the fall beyond the table
    !> multiples of the angle in the cosine and in the sine; absent: 0, 0
    integer, intent(in), optional :: angle(2)
    real(real64) :: x, y
    integer :: k, l, m, n, squares

    squares = 1
    if (norm2(max(0.0_real64, [i, j] - 0.5_real64) * side) < near) &
      squares = ceiling(min(2.0_real64 * maxval(side), most_squares))
    integral = 0.0_real64
    do l = 1, squares
      do k = 1, squares
        ! Gauss's rule of three points along each side.
        do m = -1, 1
          do n = -1, 1
            x = (i + (k - 0.5_real64 + n * sqrt(0.15_real64)) / squares - 0.5_real64) * side(1)
            y = (j + (l - 0.5_real64 + m * sqrt(0.15_real64)) / squares - 0.5_real64) * side(2)
            integral = integral + (8 - 3 * abs(m)) * (8 - 3 * abs(n)) / 324.0_real64 * &
                       value_at(hypot(x, y)) * factor_at(atan2(y, x))
          end do
        end do
      end do
    end do
    integral = integral * product(side) / squares**2

  contains

    ! Lagrange's cubic through four nodes.
    pure real(real64) function value_at(radius)
      real(real64), intent(in) :: radius
      real(real64) :: place
      integer :: o

      o = min(int(asinh(radius) / step), nodes - 2)
      place = min(asinh(radius) / step, nodes - 2.0_real64) - o
      value_at = (place + 1.0_real64) * (place - 2.0_real64) * 0.5_real64 * ( &
                   (place - 1.0_real64) * rest(o) - place * rest(o + 1)) + &
                 place * (place - 1.0_real64) / 6.0_real64 * ( &
                   (place + 1.0_real64) * rest(o + 2) - (place - 2.0_real64) * rest(o - 1))
      if (radius > far) value_at = value_at * (far / radius)**power
    end function value_at

    pure real(real64) function factor_at(direction)
      real(real64), intent(in) :: direction

      factor_at = 1.0_real64
      if (.not. present(angle)) return
      if (angle(1) > 0) factor_at = cos(angle(1) * direction)
      if (angle(2) > 0) factor_at = sin(angle(2) * direction)
    end function factor_at

  end function integral_of

end module asperity_layer_compliance
