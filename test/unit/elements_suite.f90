!> Tests of the cells: influence, single contacts, contacts together, hard cases.
!>
!> The truths are closed forms (Hertz; the displacement beside a Hertz contact) and quadrature of
!> the definition. Contacts together are compared with grids in test/effects.
module asperity_elements_suite
  use asperity_lattice_convolution, only: lattice_convolution, padded_length
  use asperity_element_influence, only: mean_influence
  use asperity_element_lattice, only: penetration_of_load, radius_of_load
  use asperity_element_answer, only: element_answer
  use asperity_outside_field, only: outside_field
  use asperity_element_solver, only: cluster_lattice, cluster_extent, solve_elements
  use asperity_chebyshev_basis, only: chebyshev_nodes
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_kinds, only: real32, real64
  use asperity_testing, only: check, run_test
  implicit none
  private

  public :: run_elements

  real(real64), parameter :: pi = acos(-1.0_real64)

  ! Asked of the solver, and allowed to a load against a closed form.
  real(real64), parameter :: asked = 1.0e-3_real64, allowed = 1.0e-3_real64

  ! Shares of the load and of the area, and no part of anything larger.
  real(real64), parameter :: shares(2) = [1.0e-4_real64, 0.005_real64], no_more(2) = 0.0_real64
  real(real64), parameter :: asked_shares(2, 2) = reshape([shares, no_more], [2, 2])

contains

  !> Runs the tests.
  subroutine run_elements
    call run_test('influence of a cell against quadrature', influence_by_quadrature)
    call run_test('an aligned pair is Hertz, down to 1e-12 of the radius', single_is_hertz)
    call run_test('an inclined pair is an ellipse of Hertz', inclined_is_ellipse)
    call run_test('the area of a contact is within its tolerance and its error estimate', &
                  area_is_estimated)
    call run_test('a load on cells, and its compression', load_given)
    call run_test('a lattice stays while it is fine enough', lattice_stays)
    call run_test('an open contact far from a lattice that is kept', far_from_lattice)
    call run_test('a small contact far off feels the field of a large one', small_and_large)
    call run_test('coincident, covered, open and refused contacts', hard_cases)
    call run_test('a sum over cells through FFTW against a sum term by term', sum_over_cells)
    call run_test('an approximate inverse on a part bounds the inverse', inverse_on_part)
    call run_test('two far contacts in one cluster, and each outside the other', outside)
    call run_test('tiny caps on a flank, overlapping and far apart', tiny_and_far)
  end subroutine run_elements

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

  ! A load of 0.001 over the modulus, combined radius 1: Johnson 1985, eq. 4.26, with complete
  ! elliptic integrals in 30 digits (mpmath).
  subroutine inclined_is_ellipse
    real(real64), parameter :: slopes(3) = [0.5_real64, 1.0_real64, 2.0_real64], &
      depths(3) = [0.0088860900277672775_real64, 0.010331701420396328_real64, &
                   0.013633007597349369_real64], &
      radii(3) = [0.084285037842205072_real64, 0.071639110166946466_real64, &
                  0.051373487983671799_real64]
    type(contact_pair) :: pair
    integer :: i

    do i = 1, 3
      pair = pair_at(0.0_real64, 0.0_real64, 0.0_real64, &
                     4.0_real64 * slopes(i) / hypot(1.0_real64, slopes(i)), 2.0_real64)
      call check(abs(penetration_of_load(pair, 1.0e-3_real64) / depths(i) - 1.0_real64) < &
                 1.0e-13_real64, 'the vertical penetration')
      call check(abs(radius_of_load(pair, 1.0e-3_real64) / radii(i) - 1.0_real64) < &
                 1.0e-13_real64, 'the mean semi-axis')
    end do
  end subroutine inclined_is_ellipse

  ! All contacts in one cluster, nothing outside. Penetrations come as gaps below a compression of
  ! 0.
  subroutine solve(pairs, penetration, tolerance, answer)
    type(contact_pairs), intent(inout) :: pairs
    real(real64), intent(in) :: penetration(:), tolerance
    type(element_answer), intent(out) :: answer
    type(outside_field) :: nothing
    integer :: i

    pairs%list%gap = -penetration
    call solve_anew(pairs, [(i, i=1, size(penetration))], 0.0_real64, nothing, &
                    [tolerance, max(4 * tolerance, 0.005_real64)], answer)
  end subroutine solve

  ! A cluster at a compression, on a lattice of its own.
  subroutine solve_anew(pairs, members, compression, outside, tolerance, answer)
    type(contact_pairs), intent(in) :: pairs
    integer, intent(in) :: members(:)
    real(real64), intent(in) :: compression, tolerance(2)
    type(outside_field), intent(in) :: outside
    type(element_answer), intent(out) :: answer
    type(cluster_lattice) :: lattice

    call solve_elements(pairs, members, compression, outside, &
                        reshape([tolerance, no_more], [2, 2]), lattice, answer)
  end subroutine solve_anew

  real(real64) function total(answer)
    type(element_answer), intent(in) :: answer

    total = sum(answer%contacts%load)
  end function total

  ! Mean of 1/r: Love's displacement at a point, and Gauss over the receiving cell.
  subroutine influence_by_quadrature
    integer, parameter :: cases(2, 9) = reshape([0, 0, 1, 0, 1, 1, 2, 1, 15, 0, 15, 15, 16, 0, &
                                                 27, 7, 40, 33], [2, 9])
    integer, parameter :: parts = 200
    real(real64), allocatable :: table(:, :)
    real(real64) :: mean, off
    integer :: i
    character(60) :: text

    allocate (table(0:40, 0:33), source=pi * mean_influence(41, 34))
    do i = 1, size(cases, 2)
      ! The midpoints' error, of second order, is extrapolated away.
      mean = (4 * midpoints(cases(:, i), 2 * parts) - midpoints(cases(:, i), parts)) / 3
      off = table(cases(1, i), cases(2, i)) / mean - 1
      write (text, '(a, 2i4, es12.3)') 'influence at', cases(:, i), off
      ! Near by the integrand is not smooth.
      call check(abs(off) < merge(8.0e-6_real64, 3.0e-10_real64, cases(1, i) < 15), text)
    end do
    ! Closed form of the mean distance's inverse within one square.
    off = table(0, 0) - 4.0_real64 * (log(1.0_real64 + sqrt(2.0_real64)) + &
                                      (1.0_real64 - sqrt(2.0_real64)) / 3.0_real64)
    call check(abs(off) < 1.0e-14_real64, 'a cell on itself')
    call check(abs(table(3, 2) - table(2, 3)) < 1.0e-15_real64, 'not symmetric')
  end subroutine influence_by_quadrature

  ! Mean over a cell at an offset by midpoints.
  pure real(real64) function midpoints(offset, parts) result(mean)
    integer, intent(in) :: offset(2), parts
    integer :: k, l

    mean = 0.0_real64
    do l = 1, parts
      do k = 1, parts
        mean = mean + love(offset(1) + (k - 0.5_real64) / parts - 0.5_real64, &
                           offset(2) + (l - 0.5_real64) / parts - 0.5_real64) / parts**2
      end do
    end do
  end function midpoints

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

  subroutine single_is_hertz
    real(real64), parameter :: depths(5) = [1.0e-3_real64, 1.0e-6_real64, 1.0e-12_real64, &
                                            1.0e-24_real64, 1.0e-140_real64]
    type(contact_pairs) :: pairs
    type(element_answer) :: outcome
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
      call solve(pairs, depths(i:i), asked, outcome)
      hertz = 4.0_real64 / 3.0_real64 * 0.7_real64 * depths(i) * sqrt(depths(i))
      p0 = 2.0_real64 / pi * 0.7_real64 * sqrt(depths(i))
      call check(outcome%ending%converged, 'not converged')
      call check(total(outcome) / hertz, 1.0_real64, allowed, 'load over Hertz')
      call check(outcome%contacts(1)%area / (pi * depths(i)), 1.0_real64, 0.007_real64, 'area')
      call check(outcome%contacts(1)%pressure / p0, 1.0_real64, 0.005_real64, 'pressure')
    end do
  end subroutine single_is_hertz

  ! One contact on elements of many sizes against Hertz: the error estimate of an area is one
  ! standard deviation, and the area that is lacking is 0 in the mean, in squares by side of an
  ! element on the rim, of which a circle of n elements in the radius has 8 n. Without the area at
  ! the rim it is 0.012, with a standard error of 0.0006.
  subroutine area_is_estimated
    type(contact_pairs) :: pairs
    type(element_answer) :: answer
    type(outside_field) :: nothing
    real(real64), parameter :: depth = 1.0e-4_real64
    integer, parameter :: sizes = 201
    real(real64) :: deviation, lack(sizes), tolerance
    integer :: i

    pairs%modulus = 1.0_real64
    pairs%list = [pair_at(0.0_real64, 0.0_real64, 0.0_real64, 0.0_real64, 2.0_real64)]
    do i = 1, sizes
      tolerance = 0.004_real64 * 1.005_real64**(i - 1)
      block
        type(cluster_lattice) :: lattice
        call solve_elements(pairs, [1], depth, nothing, reshape([0.01_real64, tolerance, no_more], &
                                                                [2, 2]), lattice, answer)
        lack(i) = (pi * depth - answer%contacts(1)%area) / &
                  (8 * sqrt(depth) * lattice%elements%side)
      end block
      deviation = abs(answer%contacts(1)%area / (pi * depth) - 1.0_real64)
      call check(deviation <= tolerance, 'tolerance')
      call check(deviation <= 3 * answer%area_error, 'error estimate')
    end do
    call check(abs(sum(lack) / sizes) <= 0.004_real64, 'area at the rim')
  end subroutine area_is_estimated

  ! A given load: one contact is Hertz; three have the load and the compression of each other. The
  ! compression that comes with it is far too small, so that cells are laid anew.
  subroutine load_given
    type(contact_pairs) :: pairs
    type(element_answer) :: outcome
    type(outside_field) :: nothing
    real(real64), parameter :: depth = 1.0e-2_real64
    integer :: i, n

    pairs%modulus = 0.7_real64
    do n = 1, 3, 2
      pairs%list = [(pair_at(0.15_real64 * i, 0.05_real64 * i**2, 0.0_real64, 0.0_real64, &
                             2.0_real64), i=1, n)]
      pairs%list%gap = [(0.1_real64 * depth * (i - 1), i=1, n)]
      call solve_anew(pairs, [(i, i=1, n)], depth, nothing, shares, outcome)
      block
        type(cluster_lattice) :: lattice
        type(element_answer) :: again
        call solve_elements(pairs, [(i, i=1, n)], 0.3_real64 * depth, nothing, asked_shares, &
                            lattice, again, total(outcome))
        call check(total(again) / total(outcome), 1.0_real64, 1.0e-12_real64, 'load')
        call check(again%compression / depth, 1.0_real64, 2.0e-4_real64, 'compression')
        if (n == 1) call check(total(again) / (4.0_real64 / 3.0_real64 * 0.7_real64 * &
                                                      again%compression**1.5_real64), 1.0_real64, &
                               2.0e-4_real64, 'Hertz')
      end block
    end do
  end subroutine load_given

  subroutine lattice_stays
    type(contact_pairs) :: pairs
    type(element_answer) :: outcome
    type(outside_field) :: nothing
    type(cluster_lattice) :: lattice
    real(real64) :: first(3)

    allocate (pairs%list(1))
    pairs%modulus = 1.0_real64
    pairs%list(1) = pair_at(0.0_real64, 0.0_real64, 0.0_real64, 0.0_real64, 2.0_real64)
    pairs%list%gap = 0.0_real64
    call solve_elements(pairs, [1], 1.0e-4_real64, nothing, asked_shares, lattice, outcome)
    first = place_of(lattice)
    call check(lattice%elements%side > 0.0_real64, 'laid')
    ! Radii go with the root.
    call solve_elements(pairs, [1], 1.05e-4_real64, nothing, asked_shares, lattice, outcome)
    call check(all(abs(place_of(lattice) - first) <= 0.0_real64), 'kept, finer than called for')
    call solve_elements(pairs, [1], 0.95e-4_real64, nothing, asked_shares, lattice, outcome)
    call check(all(abs(place_of(lattice) - first) <= 0.0_real64), 'kept, a little coarser')
    call solve_elements(pairs, [1], 0.4e-4_real64, nothing, asked_shares, lattice, outcome)
    call check(lattice%elements%side < first(3), 'laid anew, finer')
    call solve_elements(pairs, [1], 5.0e-4_real64, nothing, asked_shares, lattice, outcome)
    call check(lattice%elements%side > first(3), 'laid anew, coarser')
    ! Others take all load off a lattice that is kept.
    nothing%x0 = -1.0_real64
    nothing%x1 = 1.0_real64
    nothing%y0 = -1.0_real64
    nothing%y1 = 1.0_real64
    allocate (nothing%node_displacement(2, 2), source=1.0e-2_real64)
    call solve_elements(pairs, [1], 5.0e-4_real64, nothing, asked_shares, lattice, outcome)
    call check(outcome%ending%converged, 'lifted: not converged')
    call check(outcome%contacts(1)%load, 0.0_real64, 0.0_real64, 'lifted: a load')
  end subroutine lattice_stays

  ! The second contact is below the displacement by the first at one compression, and above it at
  ! another, at ten contact radii from it. Its load is that of Hertz in the displacement beside the
  ! first circle (Johnson, Contact Mechanics, 1985, eq. 3.42); the curvature of that is 1e-4 of it.
  subroutine far_from_lattice
    type(contact_pairs) :: pairs
    type(element_answer) :: outcome
    type(outside_field) :: nothing
    type(cluster_lattice) :: lattice
    real(real64), parameter :: shut = 1.5e-4_real64, apart = 0.1_real64
    real(real64) :: beside

    allocate (pairs%list(2))
    pairs%modulus = 1.0_real64
    pairs%list(1) = pair_at(0.0_real64, 0.0_real64, 0.0_real64, 0.0_real64, 2.0_real64)
    pairs%list(2) = pair_at(apart, 0.0_real64, 0.0_real64, 0.0_real64, 2.0_real64)
    pairs%list%gap = [0.0_real64, 0.98e-4_real64]
    call solve_elements(pairs, [1, 2], 1.0e-4_real64, nothing, asked_shares, lattice, outcome)
    call check(outcome%contacts(2)%load, 0.0_real64, tiny(0.0_real64), 'open')
    call solve_elements(pairs, [1, 2], shut, nothing, asked_shares, lattice, outcome)
    beside = 4.0_real64 / 3.0_real64 * sqrt(shut) * shut / (acos(-1.0_real64) * apart)
    call check(outcome%contacts(2)%load / (4.0_real64 / 3.0_real64 * &
               (shut - pairs%list(2)%gap - beside)**1.5_real64), 1.0_real64, 0.005_real64, 'load')
  end subroutine far_from_lattice

  ! Origin and side of its cells.
  pure function place_of(lattice) result(place)
    type(cluster_lattice), intent(in) :: lattice
    real(real64) :: place(3)

    place = [lattice%elements%x, lattice%elements%y, lattice%elements%side]
  end function place_of

  pure function plain(a, r) result(u)
    real(real64), intent(in) :: a, r
    real(real64) :: u

    u = ((2.0_real64 * a * a - r * r) * asin(a / r) + a * sqrt(r * r - a * a)) / pi
  end function plain

  ! The large contact's field at the small one, which itself does next to nothing.
  subroutine small_and_large
    type(contact_pairs) :: pairs
    type(element_answer) :: outcome
    real(real64), parameter :: depth = 1.0e-2_real64, small = 1.0e-5_real64
    real(real64) :: field, slope, hertz

    allocate (pairs%list(2))
    pairs%modulus = 1.0_real64
    pairs%list(1) = pair_at(0.0_real64, 0.0_real64, 0.0_real64, 0.0_real64, 2.0_real64)
    pairs%list(2) = pair_at(0.5_real64, 0.0_real64, 0.0_real64, 0.0_real64, 2.0_real64)
    field = plain(0.1_real64, 0.5_real64)
    ! So fine that the small one, 1/30 of the large one's radius, has cells.
    call solve(pairs, [depth, field + small], 2.0e-5_real64, outcome)
    ! On a slope a sphere of radius 1 comes deeper by half the square. A thousandth of the field is
    ! a tenth of what is left to the small one.
    slope = (plain(0.1_real64, 0.499_real64) - plain(0.1_real64, 0.501_real64)) / 2.0e-3_real64
    hertz = 4.0_real64 / 3.0_real64 * (small + 0.5_real64 * slope**2)**1.5_real64
    call check(outcome%contacts(2)%load / hertz, 1.0_real64, 0.1_real64, 'small load')
    ! Without that it opens.
    call solve(pairs, [depth, 0.9_real64 * field], asked, outcome)
    call check(outcome%contacts(2)%load, 0.0_real64, 0.0_real64, 'open')
    ! A contact a million times smaller than the cells.
    call solve(pairs, [depth, 1.0e-14_real64], asked, outcome)
    call check(outcome%ending%converged, 'not converged')
    call check(outcome%contacts(2)%load, 0.0_real64, 0.0_real64, 'too small for the cells')
  end subroutine small_and_large

  subroutine hard_cases
    type(contact_pairs) :: pairs
    type(element_answer) :: one, outcome
    integer :: i

    allocate (pairs%list(3))
    pairs%modulus = 1.0_real64
    do i = 1, 3
      pairs%list(i) = pair_at(1.0_real64, 1.0_real64, 0.0_real64, 0.0_real64, 2.0_real64)
    end do
    call solve(pairs, [1.0e-2_real64, 0.0_real64, -1.0_real64], asked, one)
    call check(one%contacts(2)%load + one%contacts(3)%load, 0.0_real64, 0.0_real64, 'open')
    ! Three times the same surface is the same surface.
    call solve(pairs, spread(1.0e-2_real64, 1, 3), asked, outcome)
    call check(total(outcome), total(one), 1.0e-12_real64, 'coincident')
    ! One whose own overlap lies within a deeper one's.
    call solve(pairs, [1.0e-3_real64, 1.0e-2_real64, 1.0e-12_real64], asked, outcome)
    call check(total(outcome), total(one), 1.0e-12_real64, 'covered')
    call check(outcome%contacts(2)%load, total(one), 1.0e-12_real64, 'load of the deepest')
    call solve(pairs, [0.0_real64, 0.0_real64, 0.0_real64], asked, outcome)
    call check(outcome%ending%converged, 'nothing touches: not converged')
    call check(total(outcome), 0.0_real64, 0.0_real64, 'nothing touches: a load')
    ! Nearly level centres; flanks end inside the overlap. A hundredth is enough to ask for.
    pairs%list(1) = pair_at(1.0_real64, 1.0_real64, 3.6_real64, 1.0_real64, 2.0_real64)
    call solve(pairs, [0.9_real64 * pairs%list(1)%zc, 0.0_real64, 0.0_real64], 0.01_real64, outcome)
    call check(outcome%ending%converged .or. allocated(outcome%failure), 'flanks: silent')
    call solve(pairs, [4.0_real64, 0.0_real64, 0.0_real64], asked, outcome)
    call check(allocated(outcome%failure), 'level centres not refused')
    call check(.not. outcome%ending%converged, 'refused, yet converged')
    call solve(pairs, [1.0e-160_real64, 0.0_real64, 0.0_real64], asked, outcome)
    call check(allocated(outcome%failure), 'too shallow not refused')
  end subroutine hard_cases

  ! An influence that falls as 1/r, on lattices of even, odd and prime sides.
  subroutine sum_over_cells
    integer, parameter :: sides(2, 4) = reshape([1, 1, 7, 4, 13, 16, 1, 9], [2, 4])
    real(real64), allocatable :: influence(:, :), force(:, :), found(:, :)
    real(real32), allocatable :: back(:, :)
    type(lattice_convolution), allocatable :: cells
    real(real64) :: direct, worst
    integer :: i, j, k, l, n

    do n = 1, size(sides, 2)
      allocate (influence(0:sides(1, n) - 1, 0:sides(2, n) - 1))
      allocate (force(sides(1, n), sides(2, n)), found(sides(1, n), sides(2, n)))
      do j = 1, sides(2, n)
        do i = 1, sides(1, n)
          influence(i - 1, j - 1) = 1.0_real64 / hypot(i - 0.5_real64, j - 0.25_real64)
          force(i, j) = modulo(37 * i + 101 * j, 17) - 8.0_real64
        end do
      end do
      allocate (cells)
      call cells%prepare(influence, 1.0_real64)
      call cells%apply(force, found)
      worst = 0.0_real64
      do j = 1, sides(2, n)
        do i = 1, sides(1, n)
          direct = 0.0_real64
          do l = 1, sides(2, n)
            do k = 1, sides(1, n)
              direct = direct + influence(abs(i - k), abs(j - l)) * force(k, l)
            end do
          end do
          worst = max(worst, abs(found(i, j) - direct))
        end do
      end do
      call check(worst, 0.0_real64, 1.0e-13_real64 * sum(abs(force)), 'a sum')
      ! The energy of forces is within the norm; that of the rough inverse is more than 0.
      call check(sum(force * found) <= cells%norm * sum(force**2), 'norm')
      allocate (back(sides(1, n), sides(2, n)))
      call cells%apply(real(force, real32), back)
      call check(maxval(abs(back - found)), 0.0_real64, 16 * epsilon(1.0_real32) * &
                 maxval(abs(found)), 'a sum of single precision')
      call cells%invert_on(real(force, real32), back)
      call check(sum(force * back) > 0.0_real64, 'rough inverse')
      deallocate (cells, influence, force, found, back)
    end do
    call check(padded_length(2 * 7 - 1), 13, 'padded length of 13')
    call check(padded_length(121), 128, 'padded length of 121')
  end subroutine sum_over_cells

  ! With y = A x on a part, the energy x.y is that of the inverse of A there: y.By is at least that
  ! where B is the inverse on the whole, and E^T B E is symmetric.
  subroutine inverse_on_part
    real(real64), dimension(12, 10) :: x, y, other
    real(real32), dimension(12, 10) :: back, other_back
    type(lattice_convolution) :: cells
    integer :: i, j

    do j = 1, size(x, 2)
      do i = 1, size(x, 1)
        x(i, j) = merge(2.0_real64 + sin(3.0_real64 * i + 7.0_real64 * j), 0.0_real64, &
                        modulo(i * i + 5 * j + i * j * j, 7) < 4)
        other(i, j) = merge(cos(real(i * j, real64)), 0.0_real64, x(i, j) > 0.0_real64)
      end do
    end do
    call cells%prepare_periodic(size(x, 1), size(x, 2), 1.5_real64)
    ! Equal forces have no displacement: the sum is 0.
    where (abs(other) > 0.0_real64) x = x - sum(x) / count(abs(other) > 0.0_real64)
    call cells%apply(x, y)
    where (.not. abs(other) > 0.0_real64) y = 0.0_real64
    call cells%invert_on(real(y, real32), back)
    call cells%invert_on(real(other, real32), other_back)
    call check(sum(x * y) <= sum(y * back), 'bound of the energy')
    call check(sum(y * other_back), sum(other * back), 1.0e-5_real64, 'symmetry')
    call check(sum(other * other_back) > 0.0_real64, 'positive definite')
  end subroutine inverse_on_part

  ! The field of a contact apart is that of its circle of Hertz, but for what the other's field
  ! makes oval: of the order of (a/r)**3 times 1/18, below 1e-4 at six radii. Reported at nodes of
  ! Chebyshev or as a circle is the same but for the interpolation.
  subroutine outside
    type(contact_pairs) :: pairs
    type(element_answer) :: both, one
    type(outside_field) :: field, nodes
    integer, parameter :: n = 12
    real(real64) :: load, x(n), y(n), a
    integer :: i, j

    allocate (pairs%list(2))
    pairs%modulus = 0.7_real64
    pairs%list(1) = pair_at(0.2_real64, 0.1_real64, 0.0_real64, 0.0_real64, 2.0_real64)
    pairs%list(2) = pair_at(0.56_real64, 0.58_real64, 0.0_real64, 0.0_real64, 2.0_real64)
    call solve(pairs, [1.0e-2_real64, 0.9e-2_real64], 1.0e-4_real64, both)
    ! Each lies outside the other.
    allocate (field%x(1), field%y(1), field%radius(1), field%load(1))
    field%load = 4.0_real64 / 3.0_real64 * 0.7_real64 * 1.0e-3_real64
    do i = 1, 9
      j = modulo(i, 2) + 1
      field%x = pairs%list(3 - j)%x
      field%y = pairs%list(3 - j)%y
      field%radius = (0.75_real64 * field%load / 0.7_real64)**(1.0_real64 / 3.0_real64)
      call solve_anew(pairs, [j], 0.0_real64, field, shares, one)
      load = field%load(1)
      field%load = one%contacts(1)%load
    end do
    call check(one%contacts(1)%load / both%contacts(2)%load, 1.0_real64, 2.0e-4_real64, '2')
    call check(load / both%contacts(1)%load, 1.0_real64, 2.0e-4_real64, '1')
    call check(one%contacts(1)%x, both%contacts(2)%x, 1.0e-4_real64, 'centre')
    ! The same circle through nodes.
    field%load = load
    a = (0.75_real64 * load / 0.7_real64)**(1.0_real64 / 3.0_real64)
    field%radius = a
    call solve_anew(pairs, [2], 0.0_real64, field, shares, one)
    call cluster_extent(pairs, [2], 0.0_real64, nodes%x0, nodes%x1, nodes%y0, nodes%y1)
    call check(nodes%x1 - nodes%x0, 2.0_real64 * sqrt(2.0_real64 * 0.9e-2_real64), &
               1.0e-12_real64, 'rectangle')
    allocate (nodes%node_displacement(n, n))
    x = 0.5_real64 * (nodes%x0 + nodes%x1 + chebyshev_nodes(n) * (nodes%x1 - nodes%x0))
    y = 0.5_real64 * (nodes%y0 + nodes%y1 + chebyshev_nodes(n) * (nodes%y1 - nodes%y0))
    do j = 1, n
      do i = 1, n
        nodes%node_displacement(i, j) = plain(a, hypot(x(i) - pairs%list(1)%x, y(j) - &
                                                       pairs%list(1)%y)) * &
                                        load / (4.0_real64 / 3.0_real64 * 0.7_real64 * a**3)
      end do
    end do
    call solve_anew(pairs, [2], 0.0_real64, nodes, shares, both)
    call check(both%contacts(1)%load / one%contacts(1)%load, 1.0_real64, 1.0e-6_real64, 'nodes')
    ! A field that lifts all load off.
    nodes%node_displacement = 1.0e-2_real64
    call solve_anew(pairs, [2], 0.0_real64, nodes, shares, both)
    call check(both%ending%converged, 'lifted: not converged')
    call check(both%contacts(1)%load, 0.0_real64, 0.0_real64, 'lifted: a load')
  end subroutine outside

  ! More overlap everywhere is more load. So the load lies between those of two spheres of radius 1:
  ! the large one alone, and one that all caps lie within, .0115 deep (the first cap comes highest
  ! over it where its slope is the sphere's: .01145 + 1.6e-5).
  subroutine tiny_and_far
    type(contact_pairs) :: pairs
    type(element_answer) :: answer
    real(real64) :: hertz
    integer :: i

    allocate (pairs%list(3))
    pairs%modulus = 1.0_real64
    do i = 1, 3
      pairs%list(i) = pair_at(0.03_real64 * i, 0.0_real64, 0.0_real64, 0.0_real64, &
                              merge(2.0_real64, 0.07_real64, i == 1))
    end do
    call solve(pairs, [1.0e-2_real64, 1.1e-2_real64, 0.9e-2_real64], asked, answer)
    call check(answer%ending%converged, 'tiny caps: not converged')
    hertz = 4.0_real64 / 3.0_real64 * 1.0e-3_real64
    call check(total(answer) > 0.999_real64 * hertz, 'tiny caps: less than without')
    call check(total(answer) < 1.15_real64**1.5_real64 * hertz, 'tiny caps: too much')
    call check(answer%contacts(2)%load > 0.0_real64, 'the cap that stands out is open')
    ! So far apart that the cells between them are too many.
    pairs%list(3) = pair_at(1.0e5_real64, 1.0e5_real64, 0.0_real64, 0.0_real64, 2.0_real64)
    call solve(pairs, [1.0e-2_real64, 0.9e-2_real64, 0.6e-2_real64], asked, answer)
    call check(.not. answer%ending%converged, 'far apart: not refused')
    call check(answer%failure, 'the boundary elements would need more than 2 GiB of memory', &
               'words of the refusal')
  end subroutine tiny_and_far

end module asperity_elements_suite
