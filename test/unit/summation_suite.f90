!> Tests of the sums over many circles.
!>
!> The reference is a sum over all pairs, written here from the definition; the near pairs are
!> those of all pairs, too. Bounds: an expansion gives what a source does at a place to 1.3e-5
!> (order 8, greatest over boxes and places in them), so that no sum of positive charges errs by
!> more; where no source is much more than the others, sums differ by 1e-6 of the mean potential and
!> slopes by 3e-4 of the mean slope. What is reported of symmetry is to rounding, of bytes exact.
module asperity_summation_suite
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_kinds, only: real64
  use asperity_random_philox, only: philox_block
  use asperity_source_tree, only: build_tree, source_tree, sum_sources
  use asperity_testing, only: check, has_failed, run_test
  !$ use omp_lib, only: omp_get_max_threads, omp_set_num_threads
  implicit none
  private

  public :: run_summation

  real(real64), parameter :: potential_bound = 1.0e-6_real64, slope_bound = 3.0e-4_real64
  real(real64), parameter :: source_bound = 1.3e-5_real64
  real(real64), parameter :: factor = 3.0_real64

  ! Circles, what they carry and how they move.
  type :: circles
    real(real64), allocatable, dimension(:) :: x, y, reach, charge, spread
    real(real64), allocatable :: move(:, :)
  end type circles

  ! What is summed.
  type :: sums
    real(real64), allocatable, dimension(:) :: potential, lap, slope_x, slope_y, more_x, xy
  end type sums

contains

  !> Runs the tests.
  subroutine run_summation
    call run_test('few places', few)
    call run_test('places all over a square', square)
    call run_test('clusters in clusters', clusters)
    call run_test('places on a line', line)
    call run_test('a point-like cluster and one place far away', far_away)
    call run_test('reaches from 1 to 1000', unequal)
    call run_test('coincident places', coincident)
    call run_test('a lattice whose neighbours are just near', lattice)
    call run_test('targets other than the sources', other_targets)
    call run_test('places beside and between the sources', places)
    call run_test('what two sets of charges do to each other is the same', symmetry)
  end subroutine run_summation

  subroutine few
    integer :: n

    do n = 0, 3
      call compare(spread_out(n, 1), factor)
    end do
    call compare(spread_out(300, 2), factor)
  end subroutine few

  subroutine square
    call compare(spread_out(2500, 3), factor)
  end subroutine square

  ! Each place is the sum of steps that are a third of those before, chosen by digits of its number.
  subroutine clusters
    call compare(clustered(2000), factor)
  end subroutine clusters

  subroutine line
    type(circles) :: some

    some = spread_out(2000, 4)
    some%y = 0.7_real64
    some%reach = 1.0e-4_real64 * some%reach / maxval(some%reach)
    some%spread = some%reach**2
    call compare(some, factor)
  end subroutine line

  subroutine far_away
    type(circles) :: some

    some = spread_out(2000, 5)
    some%x(:1999) = 1.0e-5_real64 * some%x(:1999)
    some%y(:1999) = 1.0e-5_real64 * some%y(:1999)
    some%reach(:1999) = 1.0e-5_real64 * some%reach(:1999)
    some%move(:, :1999) = 1.0e-5_real64 * some%move(:, :1999)
    some%spread = some%reach**2
    call compare(some, factor)
  end subroutine far_away

  subroutine unequal
    type(circles) :: some

    some = spread_out(2000, 6)
    some%reach = 1.0e-4_real64 * 1000.0_real64**(uniform(2000, 7)**4)
    some%spread = 0.3_real64 * some%reach**2
    some%charge = some%reach**2 * some%charge
    some%move(1, :) = 0.05_real64 * some%reach
    some%move(2, :) = -0.05_real64 * some%reach
    call compare(some, factor, dominated=.true.)
  end subroutine unequal

  subroutine coincident
    type(circles) :: some

    some = spread_out(1000, 8)
    some%x(501:) = some%x(:500)
    some%y(501:) = some%y(:500)
    some%move = 0.0_real64
    call compare(some, factor)
    ! Without reaches nothing is near; what coincides does not act.
    some%reach = 0.0_real64
    some%spread = 0.0_real64
    some%x(1:300) = some%x(1)
    some%y(1:300) = some%y(1)
    some%x(501:800) = some%x(1)
    some%y(501:800) = some%y(1)
    call compare(some, factor, dominated=.true.)
  end subroutine coincident

  subroutine lattice
    type(circles) :: some
    integer :: i

    some = spread_out(1600, 9)
    do i = 1, 1600
      some%x(i) = 0.25_real64 * mod(i, 40)
      some%y(i) = 0.25_real64 * ((i - mod(i, 40)) / 40)
    end do
    ! Neighbours in a row touch exactly: they are not near, as all numbers are exact.
    some%reach = 0.125_real64
    some%spread = 0.003_real64
    call compare(some, 1.0_real64)
    call compare(some, 1.5_real64)
  end subroutine lattice

  subroutine other_targets
    type(circles) :: sources, targets

    sources = spread_out(1500, 10)
    targets = spread_out(1000, 11)
    targets%x = 0.5_real64 * targets%x + 0.8_real64
    call compare(sources, factor, targets)
    targets%x(:3) = sources%x(:3)
    targets%y(:3) = sources%y(:3)
    call compare(targets, factor, sources)
    ! Too far off for any source to act place by place.
    targets%x = targets%x + 5.0_real64
    call compare(sources, factor, targets)
    call compare(spread_out(0, 1), factor, sources)
    call compare(sources, factor, spread_out(0, 1))
  end subroutine other_targets

  ! Rough potentials at any places are lower bounds of those by circles that are not near: nothing
  ! beside all boxes, nearly all of it where sources are.
  subroutine places
    type(circles) :: sources
    type(source_tree) :: tree
    real(real64) :: place(2, 1000), found(6, 1000), exact(3, 1000), r
    integer :: i, j

    sources = spread_out(2500, 13)
    call build_tree(tree, sources%x, sources%y, sources%reach, factor)
    place = reshape(1.2_real64 * uniform(2000, 14), [2, 1000])
    call sum_sources(tree, sources%charge, sources%spread, found, low_order=.true., places=place)
    exact = 0.0_real64
    do i = 1, 1000
      do j = 1, 2500
        r = hypot(place(1, i) - sources%x(j), place(2, i) - sources%y(j))
        if (r < factor * sources%reach(j)) cycle
        exact(:, i) = exact(:, i) + sources%charge(j) * [1.0_real64, &
          (sources%x(j) - place(1, i)) / r**2, (sources%y(j) - place(2, i)) / r**2] / r
      end do
    end do
    call check(all(found(1, :) <= 1.0001_real64 * exact(1, :)), 'bounds')
    call check(count(found(1, :) > 0.997_real64 * exact(1, :)) >= 600, 'close bounds')
    ! Slopes are in error by 1e-3 of the potential over the half width of a box, 1/128.
    call check(all(hypot(found(3, :) - exact(2, :), found(4, :) - exact(3, :)) <= &
                   0.2_real64 * exact(1, :) .or. found(1, :) < 0.997_real64 * exact(1, :)), &
               'slopes')
    call check(all(found(1, :) <= 0.0_real64 .or. maxval(place, 1) < 1.0_real64), 'beside')
  end subroutine places

  ! The sums are symmetric but for rounding, also where they are not exact. The mean over a circle
  ! is the potential and its spread times the Laplacian; rough potentials are means.
  subroutine symmetry
    type(circles) :: one, other
    type(sums) :: of_one, of_other
    type(source_tree) :: tree
    real(real64) :: forth, back, of_one_rough(6, 3000), of_other_rough(6, 3000)

    one = clustered(3000)
    other = one
    other%charge = uniform(3000, 12)
    call build_tree(tree, one%x, one%y, one%reach, factor)
    of_one = sum_over(tree, one, one)
    of_other = sum_over(tree, other, other)
    forth = sum(other%charge * (of_one%potential + one%spread * of_one%lap))
    back = sum(one%charge * (of_other%potential + one%spread * of_other%lap))
    call check(forth, back, 1.0e-13_real64 * abs(back), 'energy of two sets of charges')
    if (has_failed()) return
    call sum_sources(tree, one%charge, one%spread, of_one_rough, low_order=.true.)
    call sum_sources(tree, other%charge, one%spread, of_other_rough, low_order=.true.)
    forth = sum(other%charge * of_one_rough(1, :))
    call check(forth, sum(one%charge * of_other_rough(1, :)), 1.0e-13_real64 * abs(back), &
               'rough energy of two sets of charges')
    if (has_failed()) return
    call check(forth, back, 1.0e-4_real64 * abs(back), 'rough energy')
  end subroutine symmetry

  ! Checks near pairs and sums against all pairs, with moves and without.
  subroutine compare(sources, near_factor, targets, dominated)
    type(circles), intent(in) :: sources
    real(real64), intent(in) :: near_factor
    type(circles), intent(in), optional :: targets
    logical, intent(in), optional :: dominated  ! some sources are much more than the others
    type(circles) :: still, goal
    type(source_tree) :: tree
    logical :: same, even

    if (has_failed()) return
    even = .not. present(dominated)
    same = .not. present(targets)
    if (same) then
      goal = sources
      call build_tree(tree, sources%x, sources%y, sources%reach, near_factor)
    else
      goal = targets
      call build_tree(tree, [sources%x, goal%x], [sources%y, goal%y], &
                      [sources%reach, goal%reach], near_factor, size(sources%x))
      goal%move = 0.0_real64
    end if
    call check(.not. allocated(tree%failure), 'not planted')
    call check_near(tree, sources, goal, near_factor, same)
    if (has_failed()) return
    call check_sums(tree, sources, goal, near_factor, same, even)
    still = sources
    still%move = 0.0_real64
    goal%move = 0.0_real64
    call check_sums(tree, still, goal, near_factor, same, even)
  end subroutine compare

  subroutine check_near(tree, sources, targets, near_factor, same)
    type(source_tree), intent(in) :: tree
    type(circles), intent(in) :: sources, targets
    real(real64), intent(in) :: near_factor
    logical, intent(in) :: same
    integer :: i, j, at, number

    call check(size(tree%first), size(targets%x) + 1, 'first')
    if (has_failed()) return
    number = 0
    do i = 1, size(targets%x)
      call check(tree%first(i), number + 1, 'where the near ones of a target begin')
      at = number + 1
      do j = 1, size(sources%x)
        if (.not. near(sources, j, targets, i, near_factor)) cycle
        if (same .and. i == j) cycle
        associate (listed => tree%near(at:min(tree%first(i + 1) - 1, size(tree%near))))
          call check(count(listed == j), 1, 'how often a near source is listed')
        end associate
        number = number + 1
      end do
      if (has_failed()) return
    end do
    call check(size(tree%near), number, 'number of near pairs')
  end subroutine check_near

  pure logical function near(sources, j, targets, i, near_factor)
    type(circles), intent(in) :: sources, targets
    integer, intent(in) :: j, i
    real(real64), intent(in) :: near_factor

    near = hypot(sources%x(j) - targets%x(i), sources%y(j) - targets%y(i)) &
           < near_factor * (sources%reach(j) + targets%reach(i))
  end function near

  subroutine check_sums(tree, sources, targets, near_factor, same, even)
    type(source_tree), intent(inout) :: tree
    type(circles), intent(in) :: sources, targets
    real(real64), intent(in) :: near_factor
    logical, intent(in) :: same, even
    type(sums) :: found
    real(real64), dimension(size(targets%x)) :: potential, lap, slope_x, slope_y, more_x, xy
    real(real64) :: x, y, r2, r, mean, mean_slope
    integer :: i, j

    potential = 0.0_real64
    lap = 0.0_real64
    slope_x = 0.0_real64
    slope_y = 0.0_real64
    more_x = 0.0_real64
    xy = 0.0_real64
    do i = 1, size(potential)
      do j = 1, size(sources%x)
        if (near(sources, j, targets, i, near_factor) .or. (same .and. i == j)) cycle
        if (hypot(sources%x(j) - targets%x(i), sources%y(j) - targets%y(i)) < tiny(r)) cycle
        x = targets%x(i) + targets%move(1, i) - sources%x(j) - sources%move(1, j)
        y = targets%y(i) + targets%move(2, i) - sources%y(j) - sources%move(2, j)
        r2 = x * x + y * y
        r = sqrt(r2)
        potential(i) = potential(i) + sources%charge(j) * (1 + sources%spread(j) / r2) / r
        lap(i) = lap(i) + sources%charge(j) * (1 + 9 * sources%spread(j) / r2) / (r * r2)
        r = sources%charge(j) * (1 + 3 * sources%spread(j) / r2) / (r * r2)
        slope_x(i) = slope_x(i) - r * x
        slope_y(i) = slope_y(i) - r * y
        r = sources%charge(j) * (3 + 15 * sources%spread(j) / r2) / (r2**2 * sqrt(r2))
        more_x(i) = more_x(i) + r * (x * x - y * y) / 2
        xy(i) = xy(i) + r * x * y
      end do
    end do
    found = sum_over(tree, sources, targets)
    if (size(potential) == 0) return
    mean = sum(potential) / size(potential)
    mean_slope = sum(hypot(slope_x, slope_y)) / size(potential)
    ! What is left beside 1e-12 is rounding.
    call check(all(abs(found%potential - potential) <= source_bound * potential &
                          + 1.0e-12_real64 * mean), 'potential by one source')
    if (.not. even) return
    call check(maxval(abs(found%potential - potential)), 0.0_real64, &
               potential_bound * mean, 'potential')
    call check(maxval(abs(found%lap - lap) * targets%spread), 0.0_real64, &
               potential_bound * mean, 'spread times Laplacian')
    call check(maxval(hypot(found%more_x - more_x, found%xy - xy) * targets%spread), &
               0.0_real64, potential_bound * mean, 'spread times bends')
    call check(maxval(hypot(found%slope_x - slope_x, found%slope_y - slope_y)), &
               0.0_real64, slope_bound * mean_slope, 'slope')
  end subroutine check_sums

  function sum_over(tree, sources, targets) result(of)
    type(source_tree), intent(inout) :: tree
    type(circles), intent(in) :: sources, targets
    type(sums) :: of
    real(real64) :: value(6, size(targets%x))

    call sum_sources(tree, sources%charge, sources%spread, value, sources%move)
    allocate (of%potential, source=value(1, :))
    allocate (of%lap, source=value(2, :))
    allocate (of%slope_x, source=value(3, :))
    allocate (of%slope_y, source=value(4, :))
    allocate (of%more_x, source=value(5, :))
    allocate (of%xy, source=value(6, :))
  end function sum_over

  ! Circles of mixed reach that cover some ten per cent of a square of side 1.
  function spread_out(n, key) result(some)
    integer, intent(in) :: n, key
    type(circles) :: some

    allocate (some%x(n), some%y(n), some%reach(n), some%charge(n), some%spread(n), &
              some%move(2, n))
    some%x(:) = uniform(n, 20 * key)
    some%y(:) = uniform(n, 20 * key + 1)
    some%charge(:) = 0.5_real64 + uniform(n, 20 * key + 2)
    some%reach(:) = (0.1_real64 + 0.1_real64 * uniform(n, 20 * key + 3)) &
                    / sqrt(real(max(n, 4), real64))
    some%spread(:) = 0.2_real64 * some%reach**2
    some%move(1, :) = 0.1_real64 * some%reach * (uniform(n, 20 * key + 4) - 0.5_real64)
    some%move(2, :) = 0.1_real64 * some%reach * (uniform(n, 20 * key + 5) - 0.5_real64)
  end function spread_out

  function clustered(n) result(some)
    integer, intent(in) :: n
    type(circles) :: some
    real(real64) :: choice(5), step
    integer :: i, k, digits

    some = spread_out(n, 15)
    choice = uniform(5, 400)
    do i = 1, n
      digits = i
      step = 1.0_real64 / 3
      some%x(i) = step**7 * some%x(i)
      some%y(i) = step**7 * some%y(i)
      do k = 1, 6
        some%x(i) = some%x(i) + step**k * choice(1 + mod(digits, 4))
        some%y(i) = some%y(i) + step**k * choice(2 + mod(digits, 4))
        digits = digits / 4
      end do
    end do
    some%reach = 0.1_real64 * some%reach
    some%spread = 0.01_real64 * some%spread
    some%move = 0.1_real64 * some%move
  end function clustered

  ! Numbers from [0, 1).
  function uniform(n, key)
    integer, intent(in) :: n, key
    real(real64) :: uniform(n)
    integer(int64) :: words(4)
    integer :: i

    do i = 1, n
      words = philox_block([int(i, int64), 0_int64, 0_int64, 0_int64], [int(key, int64), 13_int64])
      uniform(i) = real(words(1), real64) / 2.0_real64**32
    end do
  end function uniform

end module asperity_summation_suite
