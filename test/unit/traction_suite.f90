!> Tests of displacements by tangential tractions on a lattice.
module asperity_traction_suite
  use asperity_constants, only: pi
  use asperity_gauss_rule, only: gauss_node, gauss_weight
  use asperity_interruption, only: interruption
  use asperity_kinds, only: real64
  use asperity_slip_solver, only: find_tractions, slip_problem, tangent_space
  use asperity_solve_ending, only: solve_ending
  use asperity_testing, only: check, run_test
  use asperity_traction_convolution, only: by_tractions, inverse_of_tractions, list_elements, &
                                           normal_by_tractions, tangential_by_pressures, &
                                           traction_convolution
  implicit none
  private

  public :: run_tractions

  real(real64), parameter :: nu = 0.3_real64, beta = 0.2_real64, side_ratio = 1.3_real64

contains

  !> Runs the tests.
  subroutine run_tractions
    call run_test('displacements by a traction: quadrature of Cerruti''s solution', elements)
    call run_test('displacements by a wave of tractions: Westergaard''s compliances', waves)
    call run_test('tractions and displacements are reciprocal, also with coupling', reciprocity)
    call run_test('a strip under a line of tractions: plane strain and antiplane shear', lines)
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
