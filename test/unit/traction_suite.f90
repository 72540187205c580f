!> Tests of displacements by tangential tractions on a lattice.
module asperity_traction_suite
  use asperity_constants, only: pi
  use asperity_gauss_rule, only: gauss_node, gauss_weight
  use asperity_interruption, only: interruption
  use asperity_kinds, only: real64
  use asperity_slip_solver, only: find_tractions, slip_problem, tangent_space
  use asperity_solve_ending, only: solve_ending
  use asperity_stress_kernels, only: corner_factor, corner_function, corner_parity
  use asperity_testing, only: check, run_test
  use asperity_traction_convolution, only: by_tractions, inverse_of_tractions, list_elements, &
                                           normal_by_tractions, tangential_by_pressures, &
                                           traction_convolution
  implicit none
  private

  public :: run_tractions

  real(real64), parameter :: nu = 0.3_real64, beta = 0.2_real64, side_ratio = 1.3_real64

  ! Place x, y, z, and stress xx, yy, zz, xy, xz, yz, all times 1e6.
  integer, parameter :: points(9, 40) = reshape([ &
    -100000, -2000000, 0, -15265, 20443, 0, 21341, 0, 0, &
    600000, -200000, 0, -1115320, -347912, 0, 51967, 0, 0, &
    -800000, 600000, 0, 347576, 56144, 0, -223615, 0, 0, &
    0, -800000, 100000, -84476, -42847, -6162, 174231, -26209, 26188, &
    800000, 0, 100000, -667085, -138027, -32406, 60, -150391, 17, &
    -600000, 1000000, 100000, 57820, 70500, 1566, -117362, -8802, 11468, &
    100000, -400000, 200000, -388363, -242860, -776558, 226515, -394553, 240572, &
    1000000, 200000, 200000, -402518, -57102, -34112, -47603, -123012, -17916, &
    -400000, -2000000, 300000, -6058, 9715, 80, 18374, -478, -497, &
    200000, -200000, 300000, -382109, -208106, -904948, 79536, -382433, 109721, &
    2000000, 400000, 300000, -95581, -11864, -3090, -14240, -19009, -3668, &
    -300000, -800000, 400000, 9125, -75007, -59629, 51467, -9722, 70420, &
    300000, 0, 400000, -298446, -128755, -842832, 68, -361128, 113, &
    -2000000, 1000000, 400000, 54040, -211, 2226, -27955, -10516, 5090, &
    -200000, -400000, 500000, 3074, -75657, -399772, 34892, -34811, 137407, &
    400000, 200000, 500000, -218803, -66064, -642528, -59276, -314196, -105124, &
    -1000000, -2000000, 600000, 3428, 7836, 977, 16333, -1893, -3030, &
    -100000, -200000, 600000, -14000, -44941, -514283, 16124, -51902, 78611, &
    600000, 400000, 600000, -178957, -51778, -339316, -91347, -237652, -132842, &
    -800000, -800000, 700000, 17221, -12980, -7199, 17426, -900, 5404, &
    0, 0, 700000, -19797, -19816, -521973, 16, -67973, 79, &
    800000, 800000, 700000, -96147, -65912, -107616, -81339, -101374, -95051, &
    -600000, -400000, 800000, 8431, -19721, -90995, 564, 29902, 29512, &
    100000, 200000, 800000, -19398, -12951, -446431, -15181, -77067, -68441, &
    1000000, 2000000, 800000, -16886, -31295, -8168, -20603, -9864, -18959, &
    -400000, -200000, 900000, 6696, -10298, -199924, -1337, 38102, 29449, &
    200000, 400000, 900000, -17821, -22658, -332420, -26659, -74781, -103019, &
    2000000, -1000000, 1000000, -55968, -10885, -17747, 25375, -33532, 16467, &
    -300000, 0, 1000000, 7452, -1430, -233887, -1, 29534, 33, &
    300000, 800000, 1000000, -13398, -49764, -161024, -32570, -46747, -102780, &
    -2000000, -400000, 1250000, 20160, -6210, 6465, 4375, -10244, -1922, &
    -200000, 200000, 1250000, 7758, 2101, -193634, 34, 13931, -24478, &
    400000, 2000000, 1250000, -4159, -28923, -17179, -10759, -5753, -25589, &
    -1000000, -200000, 1667000, -2001, -1588, -35317, -884, 16987, 3776, &
    -100000, 400000, 1667000, 6623, 1122, -125880, -801, 2838, -26410, &
    600000, -1000000, 2500000, 299, -2900, -56092, 5322, -13339, 21269, &
    -800000, 0, 2500000, 566, 1711, -40155, -1, 11376, 3, &
    0, 800000, 2500000, 3633, -934, -57488, -984, -745, -17339, &
    800000, -600000, 5000000, 849, 1269, -19764, 413, -3168, 2335, &
    -600000, 200000, 5000000, 1026, 1024, -15943, 36, 1823, -627 &
    ], [9, 40])

contains

  !> Runs the tests.
  subroutine run_tractions
    call run_test('displacements by a traction: quadrature of Cerruti''s solution', elements)
    call run_test('displacements by a wave of tractions: Westergaard''s compliances', waves)
    call run_test('tractions and displacements are reciprocal, also with coupling', reciprocity)
    call run_test('a strip under a line of tractions: plane strain and antiplane shear', lines)
    call run_test('stress below a square with a traction: CONTACT''s file of points', stresses)
    call run_test('slip: 200 random problems, at most 60 applications', random_problems)
  end subroutine run_tractions

  ! Displacements at an offset by a traction on one element, by Gauss' rule over it.
  subroutine elements
    integer, parameter :: n(2) = [9, 7], at(2) = [3, 5], to(2) = [8, 2]
    real(real64) :: q(n(1), n(2), 2), u(n(1), n(2), 2), uz(n(1), n(2), 1), sums(5), x, y, r
    type(traction_convolution) :: operator
    integer :: i, j, k

    call operator%prepare(n, side_ratio, [.false., .false.], nu, beta)
    sums = 0.0_real64
    do k = 0, 3
      do j = 1, size(gauss_node)
        do i = 1, size(gauss_node)
          x = to(1) - at(1) + 0.5_real64 * merge(1, -1, mod(k, 2) == 0) * gauss_node(i)
          y = side_ratio * (to(2) - at(2) + 0.5_real64 * merge(1, -1, k < 2) * gauss_node(j))
          r = hypot(x, y)
          sums = sums + 0.25_real64 * side_ratio * gauss_weight(i) * gauss_weight(j) * &
                 [x**2 / r**3, x * y / r**3, y**2 / r**3, x / r**2, y / r**2]
        end do
      end do
    end do
    q = 0.0_real64
    q(at(1), at(2), 1) = 1.0_real64
    call operator%apply(q, u, by_tractions)
    ! g = 2/(1 - nu), m = nu g.
    associate (g => 2.0_real64 / (1.0_real64 - nu) / (2.0_real64 * pi))
      call check(u(to(1), to(2), 1), g * (sums(1) + (1.0_real64 - nu) * sums(3)), 1.0e-10_real64, &
                 'along')
      call check(u(to(1), to(2), 2), g * nu * sums(2), 1.0e-10_real64, 'across')
    end associate
    call operator%apply(q, uz, normal_by_tractions)
    call check(uz(to(1), to(2), 1), beta / pi * sums(4), 1.0e-10_real64, 'normal')
    q = cshift(q, 1, 3)
    call operator%apply(q, uz, normal_by_tractions)
    call check(uz(to(1), to(2), 1), beta / pi * sums(5), 1.0e-10_real64, 'normal by y')
  end subroutine elements

  ! A wave of shear along itself, (1 - nu) stiffer than one across itself.
  subroutine waves
    integer, parameter :: n(2) = [16, 12]
    real(real64) :: q(n(1), n(2), 2), u(n(1), n(2), 2), back(n(1), n(2), 2), wave(2), c(2), number
    type(traction_convolution) :: operator
    integer :: i, j

    call operator%prepare(n, side_ratio, [.true., .true.], nu, 0.0_real64)
    wave = 2.0_real64 * pi * [3.0_real64 / n(1), 2.0_real64 / (n(2) * side_ratio)]
    number = norm2(wave)
    c = wave / number
    do j = 1, n(2)
      do i = 1, n(1)
        q(i, j, :) = c * cos(wave(1) * i + wave(2) * side_ratio * j)
      end do
    end do
    call operator%apply(q, u, by_tractions)
    call check(maxval(abs(u - 2.0_real64 / number * q)), 0.0_real64, 1.0e-14_real64, 'along')
    call operator%apply(u, back, inverse_of_tractions)
    call check(maxval(abs(back - q)), 0.0_real64, 1.0e-14_real64, 'inverse')
    q = cshift(q, 1, 3)
    q(:, :, 1) = -q(:, :, 1)
    call operator%apply(q, u, by_tractions)
    call check(maxval(abs(u - 2.0_real64 / (1.0_real64 - nu) / number * q)), 0.0_real64, &
               1.0e-14_real64, 'across')
  end subroutine waves

  ! q.u(p) of two random fields is symmetric, whatever the edges.
  subroutine reciprocity
    integer, parameter :: n(2) = [10, 7]
    real(real64) :: q(n(1), n(2), 2), r(n(1), n(2), 2), u(n(1), n(2), 2), p(n(1), n(2), 1), &
                    uz(n(1), n(2), 1), other
    type(traction_convolution), allocatable :: operator
    integer :: i, k

    q = reshape([(sin(7.0_real64 * i**2), i=1, size(q))], shape(q))
    r = reshape([(cos(5.0_real64 * i**2), i=1, size(q))], shape(q))
    p(:, :, 1) = r(:, :, 1)
    do k = 0, 3
      allocate (operator)
      call operator%prepare(n, side_ratio, [mod(k, 2) == 1, k > 1], nu, beta)
      call operator%apply(q, u, by_tractions)
      other = sum(r * u)
      call operator%apply(r, u, by_tractions)
      call check(sum(q * u), other, 1.0e-12_real64, 'tangential')
      call operator%apply(q, uz, normal_by_tractions)
      call operator%apply(p, u, tangential_by_pressures)
      call check(sum(q * u), sum(p * uz), 1.0e-12_real64, 'coupled')
      deallocate (operator)
    end do
  end subroutine reciprocity

  ! Uniform tractions along a strip: the displacements across it are (1 - nu) of those along it, and
  ! there are none of the other component.
  subroutine lines
    integer, parameter :: n(2) = [12, 9]
    real(real64) :: q(n(1), n(2), 2), u(n(1), n(2), 2), along(n(2))
    type(traction_convolution) :: operator

    call operator%prepare(n, side_ratio, [.true., .false.], nu, beta)
    q = 0.0_real64
    q(:, 3, 1) = 1.0_real64
    call operator%apply(q, u, by_tractions)
    along = u(5, :, 1)
    call check(maxval(abs(u(:, :, 2))), 0.0_real64, 1.0e-13_real64, 'no displacement across')
    q = cshift(q, 1, 3)
    call operator%apply(q, u, by_tractions)
    call check(maxval(abs(u(:, :, 1))), 0.0_real64, 1.0e-13_real64, 'none along')
    call check(maxval(abs(u(5, :, 2) - (1.0_real64 - nu) * along)), 0.0_real64, &
               2.0e-5_real64, 'plane strain')
    ! The mean of -log(r) over a row at the distance d of n sides is -log(d) + 1/(24 n**2) + ...
    call check(along(1) - along(9), 2.0_real64 * side_ratio / (pi * (1.0_real64 - nu)) * &
               (log(3.0_real64) + (1.0_real64 / 4 - 1.0_real64 / 36) / 24), 1.0e-3_real64, &
               'logarithm')
  end subroutine lines

  ! The square of -0.4999 to 0.5001 along x and -0.4998 to 0.5002 along y, with the pressure 1, the
  ! traction 0.999 along x and Poisson's ratio 0.28: every 110th point of examples/subsurf.ref_subs
  ! of CONTACT (E. A. H. Vollebregt), within 2 of its middle, to its six digits.
  subroutine stresses
    integer :: i, j, k
    real(real64) :: found(6)

    do i = 1, size(points, 2)
      do k = 1, 6
        found(k) = sum(corner_factor(:2) * [1.0_real64, 0.999_real64] * &
                       [(of_corner(j, k, 0.4999_real64, 0.4998_real64) - &
                         of_corner(j, k, -0.5001_real64, 0.4998_real64) - &
                         of_corner(j, k, 0.4999_real64, -0.5002_real64) + &
                         of_corner(j, k, -0.5001_real64, -0.5002_real64), j=1, 2)]) / (2 * pi)
      end do
      call check(maxval(abs(found - 1.0e-6_real64 * points(4:, i))), 0.0_real64, 6.0e-6_real64, &
                 'stress')
    end do

  contains

    real(real64) function of_corner(source, component, x, y)
      integer, intent(in) :: source, component
      real(real64), intent(in) :: x, y   ! of the square's corner, reversed

      associate (place => 1.0e-6_real64 * points(:3, i) + [x, y, 0.0_real64])
        of_corner = corner_function(source, component, abs(place(1)), abs(place(2)), place(3), &
                                    0.28_real64) * &
                    product(merge(corner_parity(source, component), 1, place(:2) < 0.0_real64))
      end associate
    end function of_corner

  end subroutine stresses

  ! Spheres and waves on lattices of 16 to 24 elements, both edges, any direction, 1e-3 to 0.999 of
  ! the load of sliding, half of them after another load. The tractions are in their discs, and slip
  ! opposes them where they are on the rim.
  subroutine random_problems
    real(real64), parameter :: shares(7) = [1.0e-3_real64, 0.05_real64, 0.3_real64, 0.6_real64, &
                                            0.9_real64, 0.99_real64, 0.999_real64]
    integer :: i, j, k, n(2), most
    real(real64) :: angle, displacement(2), nu_here, share, side, state(8)
    real(real64), allocatable :: limit(:, :), q(:, :), slip(:, :)
    type(traction_convolution), allocatable :: operator
    type(slip_problem), allocatable :: problem
    type(tangent_space) :: space
    type(solve_ending) :: ending
    type(interruption) :: never

    most = 0
    do k = 1, 200
      ! A sequence with irrational steps in each number.
      state = modulo(k * sqrt(real([2, 3, 5, 7, 11, 13, 17, 19], real64)), 1.0_real64)
      n = 16 + int(9 * state(1:2))
      side = 0.6_real64 + state(3)
      nu_here = 0.5_real64 * state(4)
      allocate (operator, problem, limit(n(1), n(2)))
      do j = 1, n(2)
        do i = 1, n(1)
          limit(i, j) = 1.0_real64 - ((i - 0.45_real64 * n(1)) / (0.35_real64 * n(1)))**2 - &
                        ((j - 0.55_real64 * n(2)) / (0.4_real64 * n(2)))**2 + &
                        0.8_real64 * state(5) * sin(1.3_real64 * i + k) * cos(0.9_real64 * j)
        end do
      end do
      limit = sqrt(max(limit, 0.0_real64)) * 10.0_real64**(-1.5_real64 + 2.0_real64 * state(6))
      call operator%prepare(n, side, spread(mod(k, 4) < 2, 1, 2), nu_here, 0.0_real64)
      call list_elements(limit > 0.0_real64, problem%set)
      problem%limit = pack(limit, limit > 0.0_real64)
      allocate (problem%base(size(problem%limit), 2), q(size(problem%limit), 2), &
                source=0.0_real64)
      allocate (slip, mold=q)
      problem%tolerance = 1.0e-6_real64
      do j = 0, mod(k, 2)
        angle = 2.0_real64 * pi * modulo(state(7) + 0.4_real64 * j, 1.0_real64)
        share = shares(1 + int(7 * modulo(state(8) + 0.5_real64 * j, 1.0_real64)))
        problem%given = share * sum(problem%limit) * [cos(angle), sin(angle)]
        call find_tractions(operator, problem, q, slip, displacement, space, ending, never)
        most = max(most, ending%iterations)
        if (.not. ending%converged) most = huge(most)
        call operator%apply_at(problem%set, q, problem%base, by_tractions)
      end do
      call check(maxval(abs([sum(q(:, 1)), sum(q(:, 2))] - problem%given)), 0.0_real64, &
                 1.0e-12_real64 * sum(problem%limit), 'sum')
      call check(maxval(hypot(q(:, 1), q(:, 2)) / problem%limit), 0.5_real64, &
                 0.5_real64 + 1.0e-12_real64, 'discs')
      call check(minval(sum(q * slip, 2) - hypot(q(:, 1), q(:, 2)) * &
                        hypot(slip(:, 1), slip(:, 2))) / maxval(abs(displacement)) / &
                 maxval(problem%limit), 0.0_real64, 1.0e-9_real64, 'slip along the tractions')
      deallocate (operator, problem, limit, q, slip)
    end do
    call check(most <= 60, 'applications')
  end subroutine random_problems

end module asperity_traction_suite
