!> Tests of the cells: influence, single contacts, contacts together, hard cases.
!>
!> The truths are closed forms (Hertz; the displacement beside a Hertz contact), quadrature of the
!> definition, and one case evaluated apart in numpy: a lattice turned along the line of the two
!> contacts, Love's displacement at the cells' centres, a dense matrix solved directly.
module asperity_boundary_suite
  use asperity_boundary_influence, only: influence_table
  use asperity_boundary_solver, only: boundary_outcome, solve_boundary
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_kinds, only: real64
  use asperity_testing, only: check, error_type, new_unittest, unittest_type
  implicit none
  private

  public :: collect_boundary

  real(real64), parameter :: pi = acos(-1.0_real64)

  ! Asked of the solver, and allowed to a load against a closed form.
  real(real64), parameter :: asked = 1.0e-3_real64, allowed = 1.0e-3_real64

contains

  !> Lists the tests.
  subroutine collect_boundary(suite)
    !> all tests
    type(unittest_type), allocatable, intent(out) :: suite(:)

    suite = [ &
      new_unittest('influence of a cell against quadrature', influence_by_quadrature), &
      new_unittest('an aligned pair is Hertz, down to 1e-12 of the radius', single_is_hertz), &
      new_unittest('an inclined pair is that of its vertical gap', inclined_pair), &
      new_unittest('two contacts apart, near and far', two_apart), &
      new_unittest('two contact circles that overlap, against numpy', two_overlapping), &
      new_unittest('a small contact far off feels the field of a large one', small_and_large), &
      new_unittest('nine in a square: corners alike, the middle least, totals agree', nine), &
      new_unittest('coincident, covered, open and refused contacts', hard_cases), &
      new_unittest('the same input gives the same bytes', repeatable)]
  end subroutine collect_boundary

  ! Equal spheres, first touch at (x, y), centres offset by (dx, dy).
  function pair_at(x, y, dx, dy, radius) result(pair)
    real(real64), intent(in) :: x, y, dx, dy
    real(real64), intent(in) :: radius  ! of both spheres
    type(contact_pair) :: pair

    pair%upper = 1
    pair%lower = 1
    pair%x = x
    pair%y = y
    pair%upper_x = x - 0.5_real64 * dx
    pair%upper_y = y - 0.5_real64 * dy
    pair%lower_x = x + 0.5_real64 * dx
    pair%lower_y = y + 0.5_real64 * dy
    pair%upper_radius = radius
    pair%lower_radius = radius
    pair%d = hypot(dx, dy)
    pair%s = 2.0_real64 * radius
    pair%zc = sqrt((pair%s - pair%d) * (pair%s + pair%d))
    pair%radius = 0.5_real64 * radius
  end function pair_at

  ! Mean of 1/r: Love's displacement at a point, and Gauss over the receiving cell.
  subroutine influence_by_quadrature(error)
    type(error_type), allocatable, intent(out) :: error
    integer, parameter :: cases(2, 9) = reshape([0, 0, 1, 0, 1, 1, 2, 1, 15, 0, 15, 15, 16, 0, &
                                                 16, 7, 40, 33], [2, 9])
    integer, parameter :: parts = 400
    real(real64), allocatable :: table(:, :)
    real(real64) :: mean, x, y, off
    integer :: i, k, l
    character(60) :: text

    call influence_table(40, table)
    do i = 1, size(cases, 2)
      mean = 0.0_real64
      do l = 1, parts
        do k = 1, parts
          x = cases(1, i) + (k - 0.5_real64) / parts - 0.5_real64
          y = cases(2, i) + (l - 0.5_real64) / parts - 0.5_real64
          mean = mean + love(x, y) / parts**2
        end do
      end do
      off = table(cases(1, i), cases(2, i)) / mean - 1
      write (text, '(a, 2i4, es12.3)') 'influence at', cases(:, i), off
      ! The midpoints' own error falls with the square of the distance.
      call check(error, abs(off) < merge(8.0e-6_real64, 5.0e-9_real64, cases(1, i) < 15), text)
    end do
    ! Closed form of the mean distance's inverse within one square.
    off = table(0, 0) - 4.0_real64 * (log(1.0_real64 + sqrt(2.0_real64)) + &
                                      (1.0_real64 - sqrt(2.0_real64)) / 3.0_real64)
    call check(error, abs(off) < 1.0e-14_real64, 'a cell on itself')
    call check(error, abs(table(-3, 2) - table(2, 3)) < 1.0e-15_real64, 'not symmetric')
  end subroutine influence_by_quadrature

  ! Integral of 1/r from a point over the square of side 1 around the origin (Love 1929).
  pure function love(x, y) result(integral)
    real(real64), intent(in) :: x, y
    real(real64) :: integral

    integral = corner(x + 0.5_real64, y + 0.5_real64) - corner(x - 0.5_real64, y + 0.5_real64) - &
               corner(x + 0.5_real64, y - 0.5_real64) + corner(x - 0.5_real64, y - 0.5_real64)
  end function love

  pure function corner(x, y) result(integral)
    real(real64), intent(in) :: x, y  ! not 0
    real(real64) :: integral

    integral = x * asinh(y / abs(x)) + y * asinh(x / abs(y))
  end function corner

  subroutine single_is_hertz(error)
    type(error_type), allocatable, intent(out) :: error
    real(real64), parameter :: depths(5) = [1.0e-3_real64, 1.0e-6_real64, 1.0e-12_real64, &
                                            1.0e-24_real64, 1.0e-50_real64]
    type(contact_pairs) :: pairs
    type(boundary_outcome) :: outcome
    real(real64) :: hertz, p0
    integer :: i

    allocate (pairs%list(1))
    pairs%modulus = 0.7_real64
    ! Radii 3 and 1.5: combined 1.
    pairs%list(1) = pair_at(5.3_real64, -2.1_real64, 0.0_real64, 0.0_real64, 2.0_real64)
    pairs%list(1)%upper_radius = 3.0_real64
    pairs%list(1)%lower_radius = 1.5_real64
    pairs%list(1)%s = 4.5_real64
    pairs%list(1)%zc = 4.5_real64
    do i = 1, size(depths)
      call solve_boundary(pairs, depths(i:i), asked, .true., outcome)
      hertz = 4.0_real64 / 3.0_real64 * 0.7_real64 * depths(i) * sqrt(depths(i))
      p0 = 2.0_real64 / pi * 0.7_real64 * sqrt(depths(i))
      call check(error, outcome%ending%converged, 'not converged')
      call check(error, outcome%total / hertz, 1.0_real64, allowed, 'load over Hertz')
      call check(error, outcome%alone_total / outcome%total, 1.0_real64, 1.0e-5_real64, 'alone')
      call check(error, outcome%area(1) / (pi * depths(i)), 1.0_real64, 0.02_real64, 'area')
      call check(error, outcome%maximum_pressure(1) / p0, 1.0_real64, 0.005_real64, 'pressure')
    end do
  end subroutine single_is_hertz

  ! To first order in the penetration: an elliptical contact of curvatures 1/(R c**3) and 1/(R c),
  ! c the cosine. The eccentricity lowers its load by less than the square of the slope squared,
  ! so that it is the round one of the geometric mean radius R c**2.
  subroutine inclined_pair(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(boundary_outcome) :: outcome
    real(real64) :: cosine, hertz
    real(real64), parameter :: depth = 1.0e-6_real64

    allocate (pairs%list(1))
    pairs%modulus = 1.0_real64
    pairs%list(1) = pair_at(0.0_real64, 0.0_real64, 0.6_real64, 0.3_real64, 2.0_real64)
    cosine = pairs%list(1)%zc / pairs%list(1)%s
    call solve_boundary(pairs, [depth], asked, .false., outcome)
    hertz = 4.0_real64 / 3.0_real64 * cosine * depth * sqrt(depth)
    call check(error, outcome%total / hertz, 1.0_real64, allowed, 'load over the round contact')
  end subroutine inclined_pair

  ! Each contact stands in the displacement that a Hertz pressure causes beside its circle
  ! (Johnson, Contact Mechanics, 1985, eq. 3.42); the mean over the other's circle is taken with
  ! its second derivative. The next term is of the order (a/r)**5.
  subroutine two_apart(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(boundary_outcome) :: outcome
    real(real64), parameter :: depth = 1.0e-4_real64, radius = 1.0_real64
    real(real64), parameter :: apart(4) = [4.5_real64, 5.55_real64, 5.75_real64, 40.0_real64]
    real(real64) :: alone, factor, lowered, slope, a, r
    integer :: i, k

    allocate (pairs%list(2))
    pairs%modulus = 1.0_real64
    alone = sqrt(radius * depth)
    do i = 1, size(apart)
      r = apart(i) * alone
      pairs%list(1) = pair_at(3.0_real64, 1.0_real64, 0.0_real64, 0.0_real64, 2.0_real64)
      pairs%list(2) = pair_at(3.0_real64 + 0.6_real64 * r, 1.0_real64 + 0.8_real64 * r, &
                              0.0_real64, 0.0_real64, 2.0_real64)
      lowered = depth
      do k = 1, 100
        a = sqrt(radius * lowered)
        ! The slope of the field shifts each contact away from the other and deepens it.
        slope = (plain(a, 0.99_real64 * r) - plain(a, 1.01_real64 * r)) / (0.02_real64 * r) / radius
        lowered = depth - beside(a, r + slope * radius) / radius + 0.5_real64 * radius * slope**2
      end do
      factor = (lowered / depth) * sqrt(lowered / depth)
      call solve_boundary(pairs, [depth, depth], asked, .true., outcome)
      call check(error, outcome%total / outcome%alone_total, factor, 5.0e-4_real64, 'factor')
      call check(error, outcome%vertical_load(1) / outcome%vertical_load(2), 1.0_real64, &
                 5.0e-4_real64, 'two alike')
    end do
  end subroutine two_apart

  ! Displacement beside a Hertz contact of radius a, times the combined radius: the mean weighted
  ! with the pressure that a flat punch has on a circle of radius a at r, which is what counts for
  ! that contact's load (Betti's theorem): over the circle the weight has the mean square a**2/3
  ! in each direction.
  pure function beside(a, r) result(u)
    real(real64), intent(in) :: a, r
    real(real64) :: u, step, here

    here = plain(a, r)
    step = 0.05_real64 * r
    ! Laplacian in two dimensions.
    u = here + a * a / 6.0_real64 * ((plain(a, r + step) - 2.0_real64 * here + &
        plain(a, r - step)) / step**2 + (plain(a, r + step) - plain(a, r - step)) / (2.0_real64 * &
        step * r))
  end function beside

  pure function plain(a, r) result(u)
    real(real64), intent(in) :: a, r
    real(real64) :: u

    u = ((2.0_real64 * a * a - r * r) * asin(a / r) + a * sqrt(r * r - a * a)) / pi
  end function plain

  ! The two deepest contacts of the thesis' position 56, in cm and N: 0.160 cm apart, circles of
  ! 0.094 cm. Evaluated apart: 8, 12, 16 and 20 cells a radius, total 431.76, 431.77, 431.68 and
  ! 431.66; factors 0.74346, 0.74358, 0.74358 and 0.74361.
  subroutine two_overlapping(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(boundary_outcome) :: outcome

    allocate (pairs%list(2))
    pairs%modulus = 275760.0_real64 / (2.0_real64 * (1.0_real64 - 0.42_real64**2))
    pairs%list(1) = pair_at(9.97423_real64, 2.12598_real64, 0.37154_real64, 0.16256_real64, &
                            1.27_real64)
    pairs%list(2) = pair_at(9.82945_real64, 2.19456_real64, 0.08198_real64, 0.29972_real64, &
                            1.27_real64)
    call solve_boundary(pairs, [0.013997549934151452_real64, 0.013920271076202782_real64], &
                        1.0e-4_real64, .true., outcome)
    call check(error, outcome%total, 431.63_real64, 0.13_real64, 'total')
    call check(error, outcome%vertical_load(1), 216.63_real64, 0.1_real64, 'first')
    call check(error, outcome%total / outcome%alone_total, 0.74361_real64, 2.0e-4_real64, 'factor')
  end subroutine two_overlapping

  ! The large contact's field at the small one, which itself does next to nothing.
  subroutine small_and_large(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(boundary_outcome) :: outcome
    real(real64), parameter :: depth = 1.0e-2_real64, small = 1.0e-5_real64
    real(real64) :: field, slope, hertz

    allocate (pairs%list(2))
    pairs%modulus = 1.0_real64
    pairs%list(1) = pair_at(0.0_real64, 0.0_real64, 0.0_real64, 0.0_real64, 2.0_real64)
    pairs%list(2) = pair_at(0.5_real64, 0.0_real64, 0.0_real64, 0.0_real64, 2.0_real64)
    field = plain(0.1_real64, 0.5_real64)
    call solve_boundary(pairs, [depth, field + small], 1.0e-4_real64, .false., outcome)
    ! On a slope a sphere of radius 1 comes deeper by half the square. A thousandth of the field is
    ! a tenth of what is left to the small one.
    slope = (plain(0.1_real64, 0.499_real64) - plain(0.1_real64, 0.501_real64)) / 2.0e-3_real64
    hertz = 4.0_real64 / 3.0_real64 * (small + 0.5_real64 * slope**2)**1.5_real64
    call check(error, outcome%vertical_load(2) / hertz, 1.0_real64, 0.1_real64, 'small load')
    ! Without that it opens.
    call solve_boundary(pairs, [depth, 0.9_real64 * field], asked, .true., outcome)
    call check(error, outcome%vertical_load(2), 0.0_real64, 0.0_real64, 'open')
    call check(error, outcome%alone_load(2) > 0.0_real64, 'alone it touches')
    ! A contact a million times smaller, far off, alone in its cluster.
    pairs%list(2) = pair_at(30.0_real64, 0.0_real64, 0.0_real64, 0.0_real64, 2.0_real64)
    call solve_boundary(pairs, [depth, 1.0e-14_real64], asked, .true., outcome)
    call check(error, outcome%ending%converged, 'not converged')
    call check(error, outcome%vertical_load(2), 0.0_real64, 0.0_real64, 'open, far off')
    hertz = 4.0_real64 / 3.0_real64 * 1.0e-21_real64
    call check(error, outcome%alone_load(2) / hertz, 1.0_real64, allowed, 'alone, far off')
  end subroutine small_and_large

  subroutine nine(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(boundary_outcome) :: outcome
    real(real64) :: depth(9), corners(4)
    integer :: i

    allocate (pairs%list(9))
    pairs%modulus = 1.0_real64
    do i = 1, 9
      pairs%list(i) = pair_at(0.21_real64 * modulo(i - 1, 3), 0.21_real64 * ((i - 1) / 3), &
                              0.0_real64, 0.0_real64, 2.0_real64)
    end do
    depth = 1.0e-2_real64
    call solve_boundary(pairs, depth, asked, .true., outcome)
    corners = outcome%vertical_load([1, 3, 7, 9])
    call check(error, maxval(corners) / minval(corners), 1.0_real64, 2.0e-3_real64, 'corners')
    call check(error, minloc(outcome%vertical_load, 1), 5, 'the middle is not the least')
    call check(error, sum(outcome%vertical_load), outcome%total, 1.0e-12_real64, 'total')
    call check(error, outcome%total < 0.7_real64 * outcome%alone_total, 'no interaction')
  end subroutine nine

  subroutine hard_cases(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(boundary_outcome) :: one, outcome
    integer :: i

    allocate (pairs%list(3))
    pairs%modulus = 1.0_real64
    do i = 1, 3
      pairs%list(i) = pair_at(1.0_real64, 1.0_real64, 0.0_real64, 0.0_real64, 2.0_real64)
    end do
    call solve_boundary(pairs, [1.0e-2_real64, 0.0_real64, -1.0_real64], asked, .false., one)
    call check(error, one%vertical_load(2) + one%vertical_load(3), 0.0_real64, 0.0_real64, 'open')
    ! Three times the same surface is the same surface.
    call solve_boundary(pairs, spread(1.0e-2_real64, 1, 3), asked, .true., outcome)
    call check(error, outcome%total, one%total, 1.0e-12_real64, 'coincident')
    call check(error, outcome%alone_total, 3.0_real64 * one%total, 1.0e-5_real64 * one%total, &
               'coincident, alone')
    ! One whose own overlap lies within a deeper one's.
    call solve_boundary(pairs, [1.0e-3_real64, 1.0e-2_real64, 1.0e-12_real64], asked, .false., &
                        outcome)
    call check(error, outcome%total, one%total, 1.0e-12_real64, 'covered')
    call check(error, outcome%vertical_load(2), one%total, 1.0e-12_real64, 'load of the deepest')
    call solve_boundary(pairs, [0.0_real64, 0.0_real64, 0.0_real64], asked, .true., outcome)
    call check(error, outcome%ending%converged, 'nothing touches: not converged')
    call check(error, outcome%total, 0.0_real64, 0.0_real64, 'nothing touches: a load')
    ! Nearly level centres; flanks end inside the overlap. A hundredth is enough to ask for.
    pairs%list(1) = pair_at(1.0_real64, 1.0_real64, 3.6_real64, 1.0_real64, 2.0_real64)
    call solve_boundary(pairs, [0.9_real64 * pairs%list(1)%zc, 0.0_real64, 0.0_real64], &
                        0.01_real64, .true., outcome)
    call check(error, outcome%ending%converged .or. allocated(outcome%failure), 'flanks: silent')
    call solve_boundary(pairs, [4.0_real64, 0.0_real64, 0.0_real64], asked, .true., outcome)
    call check(error, allocated(outcome%failure), 'level centres not refused')
    call check(error, .not. outcome%ending%converged, 'refused, yet converged')
    call solve_boundary(pairs, [1.0e-70_real64, 0.0_real64, 0.0_real64], asked, .true., outcome)
    call check(error, allocated(outcome%failure), 'too shallow not refused')
  end subroutine hard_cases

  subroutine repeatable(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(boundary_outcome) :: one, other, started
    real(real64), parameter :: depth(2) = [1.0e-2_real64, 0.9e-2_real64]

    allocate (pairs%list(2))
    pairs%modulus = 1.0_real64
    pairs%list(1) = pair_at(0.0_real64, 0.0_real64, 0.1_real64, 0.0_real64, 2.0_real64)
    pairs%list(2) = pair_at(0.2_real64, 0.1_real64, 0.0_real64, 0.2_real64, 2.0_real64)
    call solve_boundary(pairs, depth, asked, .true., one)
    call solve_boundary(pairs, depth, asked, .true., other)
    call check(error, all(transfer(one%vertical_load, [0]) == transfer(other%vertical_load, [0])), &
               'loads differ')
    call check(error, all(transfer(one%alone_load, [0]) == transfer(other%alone_load, [0])), &
               'loads alone differ')
    call solve_boundary(pairs, depth, asked, .true., started, 0.8_real64 * one%alone_load)
    call check(error, started%total / one%total, 1.0_real64, 1.0e-5_real64, 'another start')
  end subroutine repeatable

end module asperity_boundary_suite
