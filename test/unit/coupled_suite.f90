!> Tests of contacts that share a half-space.
!>
!> Truths: Johnson's displacement of a Hertz pressure (Contact Mechanics, 1985, eq. 3.41a, 3.42a)
!> averaged by brute force; closed forms where two contacts coincide or lie far apart; and loads of
!> two to four paraboloids on one half-space from a boundary-element solve in numpy (Love's cells,
!> non-negative pressure by Polonsky and Keer, 40 cells a radius, the fifth digit steady).
module asperity_coupled_suite
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_contacts, only: estimate_of_interaction, solve_coupled, solve_coupled_load
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: int64, real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  use asperity_solve_ending, only: solve_ending
  use asperity_testing, only: check, error_type, new_unittest, unittest_type
  implicit none
  private

  public :: collect_coupled

  real(real64), parameter :: pi = acos(-1.0_real64)
  ! Penetration of a contact alone, so small that the sphere is a paraboloid.
  real(real64), parameter :: depth = 1.0e-8_real64
  ! What is asked of the share of the load: circles apart, circles that overlap.
  real(real64), parameter :: apart = 0.002_real64, overlapping = 0.02_real64

contains

  !> Lists the tests.
  subroutine collect_coupled(suite)
    !> all tests
    type(unittest_type), allocatable, intent(out) :: suite(:)

    suite = [ &
      new_unittest('the field at a point is that of Johnson, in and out', field_of_johnson), &
      new_unittest('means over a circle are those of that field', means_by_force), &
      new_unittest('closed forms and series meet', forms_meet), &
      new_unittest('two contacts: load together over load alone', two_contacts), &
      new_unittest('two contacts: the equations, from near to far', two_by_hand), &
      new_unittest('three and four contacts, unequal ones', groups), &
      new_unittest('coincident contacts share the load', coincident), &
      new_unittest('contacts far apart, one, none', far_one_none), &
      new_unittest('the load asked for is found, and what closes for it', load_found), &
      new_unittest('a contact at the rim of another opens and closes without a jump', at_the_rim), &
      new_unittest('thousands of crowded contacts converge', thousands), &
      new_unittest('the estimate is above the loss', estimate_is_above)]
  end subroutine collect_coupled

  ! Displacement at distance r by a unit load on a circle of radius a, modulus 1.
  pure function johnson(r, a) result(lift)
    real(real64), intent(in) :: r, a
    real(real64) :: lift, peak

    peak = 1.5_real64 / (pi * a**2)
    if (r <= a) then
      lift = peak * pi / (4 * a) * (2 * a**2 - r**2)
    else
      lift = peak / (2 * a) * ((2 * a**2 - r**2) * asin(a / r) + r * a * sqrt(1 - (a / r)**2))
    end if
  end function johnson

  subroutine field_of_johnson(error)
    type(error_type), allocatable, intent(out) :: error
    type(mutual_terms) :: terms
    real(real64) :: r, truth
    integer :: i

    do i = 0, 40
      r = 0.25_real64 * i
      call mutual_displacement(r, 0.0_real64, 1.3_real64, terms)
      truth = johnson(r, 1.3_real64)
      call check(error, terms%on_first / truth, 1.0_real64, 1.0e-11_real64, 'on a point')
      call mutual_displacement(r, 1.3_real64, 0.0_real64, terms)
      call check(error, terms%on_second / truth, 1.0_real64, 1.0e-11_real64, 'exchanged')
    end do
  end subroutine field_of_johnson

  subroutine means_by_force(error)
    type(error_type), allocatable, intent(out) :: error
    real(real64), parameter :: cases(3, 8) = reshape(real([ &
      0, 10, 10, 3, 10, 7, 10, 10, 10, 17, 10, 10, 20, 10, 10, 25, 6, 12, 60, 10, 4, 95, 10, 10], &
      real64) / 10, [3, 8])
    integer, parameter :: rings = 400, spokes = 400
    type(mutual_terms) :: terms
    real(real64) :: r, a, b, rho, truth
    integer :: i, j, k

    do k = 1, size(cases, 2)
      r = cases(1, k)
      a = cases(2, k)
      b = cases(3, k)
      truth = 0.0_real64
      do i = 1, rings
        ! The flat punch weighs equal steps of the root of 1 - (rho/a)**2 alike.
        rho = a * sqrt(1 - ((i - 0.5_real64) / rings)**2)
        do j = 1, spokes
          truth = truth + johnson(sqrt(r**2 + rho**2 + &
                                       2 * r * rho * cos(pi * (j - 0.5_real64) / spokes)), b)
        end do
      end do
      truth = truth / (rings * spokes)
      call mutual_displacement(r, a, b, terms)
      call check(error, terms%on_first / truth, 1.0_real64, 1.0e-5_real64, 'mean on the first')
      call mutual_displacement(r, b, a, terms)
      call check(error, terms%on_second / truth, 1.0_real64, 1.0e-5_real64, 'mean on the second')
    end do
  end subroutine means_by_force

  subroutine forms_meet(error)
    type(error_type), allocatable, intent(out) :: error
    type(mutual_terms) :: before, after
    real(real64), parameter :: step = 1.0e-9_real64

    ! Four sums of radii.
    call mutual_displacement(6.4_real64 * (1 - step), 1.0_real64, 0.6_real64, before)
    call mutual_displacement(6.4_real64 * (1 + step), 1.0_real64, 0.6_real64, after)
    call check(error, after%on_first / before%on_first, 1.0_real64, 5.0e-9_real64, 'first')
    call check(error, after%on_second / before%on_second, 1.0_real64, 5.0e-9_real64, 'second')
    call check(error, after%compliance / before%compliance, 1.0_real64, 5.0e-9_real64, 'flat')
    call check(error, after%slope / before%slope, 1.0_real64, 1.0e-8_real64, 'slope')
  end subroutine forms_meet

  ! Spheres of radius 1 unless told, places in units of the circle of a contact at full depth,
  ! gaps in units of the depth. Modulus 2.
  pure subroutine set_out(x, y, gap, pairs, law, radius)
    real(real64), intent(in) :: x(:), y(:), gap(:)
    type(contact_pairs), intent(out) :: pairs
    type(hertz_law), intent(out) :: law
    real(real64), intent(in), optional :: radius(:)
    integer :: i

    law%modulus = 2.0_real64
    pairs%modulus = law%modulus
    allocate (pairs%list(size(x)))
    do i = 1, size(x)
      pairs%list(i)%x = x(i) * sqrt(depth)
      pairs%list(i)%y = y(i) * sqrt(depth)
      pairs%list(i)%gap = gap(i) * depth
      pairs%list(i)%radius = 1.0_real64
      if (present(radius)) pairs%list(i)%radius = radius(i)
      pairs%list(i)%s = 4 * pairs%list(i)%radius
      pairs%list(i)%zc = pairs%list(i)%s
    end do
  end subroutine set_out

  ! Load together over the loads alone, and how the solve ended.
  pure subroutine factor_of(pairs, law, factor, ending, penetration)
    type(contact_pairs), intent(in) :: pairs
    type(hertz_law), intent(in) :: law
    real(real64), intent(out) :: factor, penetration(:)
    type(solve_ending), intent(out) :: ending
    real(real64) :: alone

    call solve_coupled(pairs, law, depth, penetration, ending)
    alone = sum(sqrt(pairs%list%radius) * max(0.0_real64, depth - pairs%list%gap)**1.5_real64)
    factor = sum(sqrt(pairs%list%radius) * max(0.0_real64, penetration)**1.5_real64) / alone
  end subroutine factor_of

  subroutine expect(error, x, y, gap, truth, allowed, what, radius)
    type(error_type), allocatable, intent(inout) :: error
    real(real64), intent(in) :: x(:), y(:), gap(:), truth, allowed
    character(*), intent(in) :: what
    real(real64), intent(in), optional :: radius(:)
    type(contact_pairs) :: pairs
    type(hertz_law) :: law
    type(solve_ending) :: ending
    real(real64) :: factor, p(size(x))

    call set_out(x, y, gap, pairs, law, radius)
    call factor_of(pairs, law, factor, ending, p)
    call check(error, ending%converged .and. ending%residual <= 1.0e-11_real64, &
               what // ' not converged')
    call check(error, factor, truth, allowed, what)
  end subroutine expect

  subroutine two_contacts(error)
    type(error_type), allocatable, intent(out) :: error
    ! Distance over the circle of one alone, share of the load.
    real(real64), parameter :: truth(2, 9) = reshape([ &
      0.8_real64, 0.63423_real64, 1.2_real64, 0.68788_real64, 1.5_real64, 0.72194_real64, &
      1.7_real64, 0.74183_real64, 2.0_real64, 0.76779_real64, 2.3_real64, 0.78966_real64, &
      3.0_real64, 0.82844_real64, 4.0_real64, 0.86472_real64, 10.0_real64, 0.94060_real64], [2, 9])
    real(real64), parameter :: zeros(2) = 0.0_real64
    integer :: i

    do i = 1, size(truth, 2)
      call expect(error, [0.0_real64, truth(1, i)], zeros, zeros, truth(2, i), &
                  merge(apart, overlapping, truth(1, i) >= 2.0_real64), 'two')
    end do
  end subroutine two_contacts

  ! The equations of two equal contacts solved by repetition.
  subroutine two_by_hand(error)
    type(error_type), allocatable, intent(out) :: error
    real(real64), parameter :: distances(5) = [3.0_real64, 12.0_real64, 17.0_real64, 19.0_real64, &
                                               40.0_real64], zeros(2) = 0.0_real64
    type(contact_pairs) :: pairs
    type(hertz_law) :: law
    type(solve_ending) :: ending
    type(mutual_terms) :: terms
    real(real64) :: factor, p, both(2), circle, load, shift, cap
    integer :: i, pass

    do i = 1, size(distances)
      p = 1.0_real64
      shift = 0.0_real64
      do pass = 1, 200
        circle = sqrt(p)
        load = p**1.5_real64 * 4 / 3
        call mutual_displacement(distances(i) + 2 * shift, circle, circle, terms)
        shift = -terms%slope * load
        ! Capped at half the circle, or half of itself.
        cap = 0.5_real64 * sqrt(circle**2 + shift**2)
        shift = shift / (1 + (shift / cap)**4)**0.25_real64
        p = 1 - terms%on_first * load - shift**2 / 2
      end do
      call set_out([0.0_real64, distances(i)], zeros, zeros, pairs, law)
      call factor_of(pairs, law, factor, ending, both)
      call check(error, both(1) / depth, p, 2.0e-11_real64, 'penetration')
    end do
  end subroutine two_by_hand

  subroutine groups(error)
    type(error_type), allocatable, intent(out) :: error
    real(real64), parameter :: o = 0.0_real64, high = 0.75_real64**0.5_real64
    real(real64), parameter :: zeros(5) = o, two = 2.0_real64, three = 3.0_real64

    call expect(error, [o, two, two / 2], [o, o, two * high], zeros(:3), 0.63307_real64, apart, &
                'triangle, 2')
    call expect(error, [o, three, three / 2], [o, o, three * high], zeros(:3), 0.71338_real64, &
                apart, 'triangle, 3')
    call expect(error, [o, two, o, two], [o, o, two, two], zeros(:4), 0.56320_real64, apart, &
                'square, 2')
    call expect(error, [o, 1.7_real64, o, 1.7_real64], [o, o, 1.7_real64, 1.7_real64], &
                zeros(:4), 0.52868_real64, overlapping, 'square, 1.7')
    call expect(error, [o, two, 2 * two, 3 * two, 4 * two], zeros, zeros, 0.57449_real64, apart, &
                'row, 2')
    call expect(error, [o, two], zeros(:2), [o, 0.75_real64], 0.89341_real64, apart, &
                'a shallow one, 2')
    call expect(error, [o, 1.3_real64], zeros(:2), [o, 0.75_real64], 0.88886_real64, apart, &
                'a shallow one that opens')
    call expect(error, [o, two], zeros(:2), zeros(:2), 0.83274_real64, apart, &
                'a small sphere, 2', [1.0_real64, 0.25_real64])
    call expect(error, [o, 1.2_real64], zeros(:2), zeros(:2), 0.76251_real64, overlapping, &
                'a small sphere, 1.2', [1.0_real64, 0.25_real64])
  end subroutine groups

  subroutine coincident(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(hertz_law) :: law
    type(solve_ending) :: ending
    real(real64) :: factor, p(5), zeros(5)

    ! The mean of its own field over a circle is 2/3 of its penetration: n share closing as
    ! p (1 + 2 (n - 1)/3).
    zeros = 0.0_real64
    call set_out(zeros, zeros, zeros, pairs, law)
    call factor_of(pairs, law, factor, ending, p)
    call check(error, ending%converged, 'five in one place do not converge')
    call check(error, p(1) / depth, 3.0_real64 / 11, 1.0e-10_real64, 'five in one place')
    call check(error, p(5) / p(1), 1.0_real64, 1.0e-10_real64, 'five alike')
    call set_out(zeros(:2), zeros(:2), [0.0_real64, 1.0_real64 - 1.0e-12_real64], pairs, law)
    call factor_of(pairs, law, factor, ending, p(:2))
    call check(error, ending%converged .and. .not. p(2) > 0.0_real64, 'a hidden one must open')
    call check(error, p(1) / depth, 1.0_real64, 1.0e-10_real64, 'the other stands alone')
  end subroutine coincident

  subroutine far_one_none(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(hertz_law) :: law
    type(solve_ending) :: ending
    real(real64) :: factor, p(2), zeros(2)

    zeros = 0.0_real64
    call set_out([0.0_real64, 1000.0_real64], zeros, zeros, pairs, law)
    call factor_of(pairs, law, factor, ending, p)
    ! A point load: V/(pi E r) = 4/(3 pi) p**1.5/r, in units of depth and circle.
    factor = p(1) / depth + 4 / (3 * pi) * (p(1) / depth)**1.5_real64 / 1000
    call check(error, factor, 1.0_real64, 1.0e-9_real64, 'far apart')
    call set_out(zeros(:1), zeros(:1), zeros(:1), pairs, law)
    call factor_of(pairs, law, factor, ending, p(:1))
    call check(error, ending%converged, 'one does not converge')
    call check(error, factor, 1.0_real64, 1.0e-12_real64, 'one alone')
    call set_out(zeros(:0), zeros(:0), zeros(:0), pairs, law)
    call solve_coupled(pairs, law, depth, p(:0), ending)
    call check(error, ending%converged, 'none')
  end subroutine far_one_none

  subroutine load_found(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(hertz_law) :: law
    type(solve_ending) :: ending
    character(:), allocatable :: failure
    real(real64) :: p(4), again(4), closing, load, target

    call set_out([0.0_real64, 2.5_real64, 0.0_real64, 9.0_real64], &
                 [0.0_real64, 0.0_real64, 3.0_real64, 1.0_real64], &
                 [0.0_real64, 0.1_real64, 0.2_real64, 0.9_real64], pairs, law)
    target = 2.0_real64 * depth**1.5_real64
    call solve_coupled_load(pairs, law, target, closing, p, ending, failure=failure)
    call check(error, ending%converged .and. .not. allocated(failure), 'load not found')
    load = 4 * law%modulus / 3 * sum(max(0.0_real64, p)**1.5_real64)
    call check(error, load / target, 1.0_real64, 1.0e-11_real64, 'load')
    call solve_coupled(pairs, law, closing, again, ending)
    call check(error, maxval(abs(again - p)) / maxval(p), 0.0_real64, 1.0e-10_real64, &
               'the same at that closing')
    call solve_coupled_load(pairs, law, 10 * target, closing, p, ending, depth, failure=failure)
    call check(error, allocated(failure) .and. .not. ending%converged, 'a load out of reach')
  end subroutine load_found

  ! A shallow contact beside a deep one, as the gap of the shallow one falls.
  subroutine at_the_rim(error)
    type(error_type), allocatable, intent(out) :: error
    integer, parameter :: steps = 400
    type(contact_pairs) :: pairs
    type(hertz_law) :: law
    type(solve_ending) :: ending
    real(real64) :: factor, p(2), before, distance, largest
    integer :: i, k

    do k = 1, 8
      distance = 0.5_real64 + 0.2_real64 * k
      before = -1.0_real64
      largest = 0.0_real64
      do i = 0, steps
        call set_out([0.0_real64, distance], [0.0_real64, 0.0_real64], &
                     [0.0_real64, 0.9_real64 - 0.7_real64 * i / steps], pairs, law)
        call factor_of(pairs, law, factor, ending, p)
        call check(error, ending%converged .and. ending%residual <= 1.0e-10_real64, &
                   'not converged')
        if (i > 0) largest = max(largest, abs(p(2) - before) / depth)
        before = max(p(2), 0.0_real64)
        if (.not. p(2) > 0.0_real64) largest = 0.0_real64
      end do
      call check(error, p(2) > 0.0_real64, 'stays open')
      ! Several times the step of the gap.
      call check(error, largest < 10 * 0.7_real64 / steps, 'a jump')
    end do
  end subroutine at_the_rim

  subroutine thousands(error)
    type(error_type), allocatable, intent(out) :: error
    integer, parameter :: contacts = 1500
    type(contact_pairs) :: pairs
    type(hertz_law) :: law
    type(solve_ending) :: ending
    real(real64) :: x(contacts), y(contacts), gap(contacts), p(contacts), factor
    integer(int64) :: seed
    integer :: i

    seed = 1_int64
    do i = 1, contacts
      x(i) = 120.0_real64 * random(seed)
      y(i) = 120.0_real64 * random(seed)
      gap(i) = real(i - 1, real64) / contacts
    end do
    call set_out(x, y, gap, pairs, law)
    call factor_of(pairs, law, factor, ending, p)
    call check(error, ending%converged .and. ending%residual <= 1.0e-10_real64, 'not converged')
    call check(error, factor > 0.05_real64 .and. factor < 0.5_real64, 'share of the load')
    call check(error, count(p > 0.0_real64) < contacts, 'none has opened')
  end subroutine thousands

  subroutine estimate_is_above(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(hertz_law) :: law
    type(solve_ending) :: ending
    real(real64) :: p(3), factor, share, distance
    integer :: i

    do i = 0, 30
      distance = 1.2_real64 * 1.25_real64**i
      call set_out([0.0_real64, distance, 0.0_real64], [0.0_real64, 0.0_real64, distance], &
                   [0.0_real64, 0.1_real64, 0.4_real64], pairs, law)
      call factor_of(pairs, law, factor, ending, p)
      share = estimate_of_interaction(pairs, law, depth)
      call check(error, share >= 1.0_real64 - factor - 1.0e-10_real64, 'below the loss')
      ! And no more than the first order of it.
      if (distance > 20.0_real64) &
        call check(error, share / (1.0_real64 - factor), 1.0_real64, 0.15_real64, 'far above it')
    end do
  end subroutine estimate_is_above

  ! A number from 0 to 1 (Marsaglia's xorshift).
  function random(seed) result(number)
    integer(int64), intent(inout) :: seed
    real(real64) :: number

    seed = ieor(seed, shiftl(seed, 13))
    seed = ieor(seed, shiftr(seed, 7))
    seed = ieor(seed, shiftl(seed, 17))
    number = shiftr(seed, 11) * 2.0_real64**(-53)
  end function random

end module asperity_coupled_suite
