!> Tests of the pair search against a search that compares all with all.
module asperity_pair_search_suite
  use asperity_cell_layer, only: any_height, margin_of_arithmetic, squared_reach
  use asperity_coupled_scenes, only: random
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int32, int64, real64
  use asperity_pair_search_layers, only: found_pairs
  use asperity_pair_search_levels, only: build_levels, last_level, pair_levels, search_level, &
                                         surface_points
  use asperity_testing, only: check, has_failed, run_test
  implicit none
  private

  public :: run_pair_search

  ! Kinds of random surfaces.
  integer, parameter :: even = 1, clustered = 2, mixed = 3, lattice = 4, crowded = 5, &
                        towering = 6
  character(len=*), parameter :: names(6) = ['even     ', 'clustered', 'mixed    ', 'lattice  ', &
                                             'crowded  ', 'towering ']
  real(real64), parameter :: any_touch = -huge(1.0_real64)
  ! Spacing at 1 of the doubles, and of short hexadecimal numbers.
  real(real64), parameter :: double = epsilon(1.0_real64), short = 16.0_real64**(-5)

  ! Marsaglia's xorshift, so that every run sees the same surfaces.
  integer(int64) :: seed = 1_int64

contains

  !> Runs the tests.
  subroutine run_pair_search
    call run_test('a level has all pairs that touch as high as it is complete', by_level)
    call run_test('what rounding may count in a shorter arithmetic is found', by_margin)
    call run_test('surfaces that are flat or far apart have no pairs', no_pairs)
    call run_test('keys of every distribution are sorted, equal ones keep their order', keys)
  end subroutine run_pair_search

  subroutine by_level
    type(surface_points) :: upper, lower
    type(pair_levels) :: levels
    integer :: kind, k, pairs, several

    several = 0
    do kind = 1, size(names)
      call draw_surface(kind, 700, upper)
      call draw_surface(kind, 800, lower)
      call build_levels(levels, upper, lower, 0.1_real64, double)
      if (last_level(levels) > 1) several = several + 1
      pairs = 0
      do k = 1, last_level(levels)
        call compare(upper, lower, levels, k, [0.1_real64, 0.2_real64], 0.1_real64, double, &
                     levels%complete_from(k), pairs, names(kind))
        if (k < last_level(levels)) &
          call compare(upper, lower, levels, k, [0.1_real64, 0.2_real64], any_height, &
                       double, levels%complete_from(k), pairs, names(kind))
        if (has_failed()) return
      end do
    end do
    ! Towers and equal heights have none.
    call check(several >= 4, 'too few surfaces have levels')
  end subroutine by_level

  subroutine by_margin
    type(surface_points) :: upper, lower
    type(pair_levels) :: levels
    integer :: kind, pairs

    do kind = 1, size(names)
      call draw_surface(kind, 300, upper)
      call draw_surface(kind, 300, lower)
      pairs = 0
      call build_levels(levels, upper, lower, 0.1_real64, short)
      call compare(upper, lower, levels, last_level(levels), [0.0_real64, 0.0_real64], &
                   0.1_real64, short, any_touch, pairs, names(kind) // ', short')
      if (has_failed()) return
    end do
  end subroutine by_margin

  ! A search against all pairs. Those within the reach that touch at the floor must be found, and
  ! those that the margin adds; none twice; none beyond twice the margin.
  subroutine compare(upper, lower, levels, level, shift, height, unit, floor, pairs, what)
    type(surface_points), intent(in) :: upper, lower
    type(pair_levels), intent(in) :: levels
    integer, intent(in) :: level
    real(real64), intent(in) :: shift(2), height, unit, floor
    integer, intent(inout) :: pairs
    character(len=*), intent(in) :: what
    type(found_pairs) :: found
    integer, allocatable :: times(:, :)
    real(real64) :: margin, touch
    logical :: failed, is_near
    integer :: i, k, lost, added

    call search_level(levels, level, shift(1), shift(2), .not. height < any_height, floor, found, &
                      failed)
    call check(.not. failed, 'no memory')
    allocate (times(size(upper%x), size(lower%x)))
    times = 0
    do k = 1, found%blocks
      associate (block => found%block(k))
        do i = 1, block%used
          times(block%upper(i), block%lower(i)) = times(block%upper(i), block%lower(i)) + 1
        end do
      end associate
    end do
    call check(int(found%number), sum(times), 'another number of pairs, ' // what)
    call check(maxval(times) <= 1, 'a pair is found twice, ' // what)
    margin = margin_of_arithmetic(unit, maxval(abs(upper%x)) + maxval(abs(upper%y)) + &
                                        maxval(abs(lower%x)) + maxval(abs(lower%y)) + &
                                        sum(abs(shift)) + maxval(upper%radius) + &
                                        maxval(lower%radius))
    lost = 0
    added = 0
    do i = 1, size(upper%x)
      do k = 1, size(lower%x)
        call look_at(upper, lower, i, k, shift, height, 0.999_real64 * margin, is_near, touch)
        if (is_near .and. touch >= floor .and. times(i, k) == 0) lost = lost + 1
        call look_at(upper, lower, i, k, shift, height, 2 * margin, is_near, touch)
        if (.not. (is_near .and. touch >= floor) .and. times(i, k) == 1) added = added + 1
      end do
    end do
    call check(lost, 0, 'a pair is lost, ' // what)
    call check(added, 0, 'a pair is added, ' // what)
    pairs = pairs + int(found%number)
  end subroutine compare

  ! Whether a pair is within reach and a margin, and the approach at which it may touch: by the
  ! formulas of the thesis, the distance less the margin.
  subroutine look_at(upper, lower, i, k, shift, height, margin, is_near, touch)
    type(surface_points), intent(in) :: upper, lower
    integer, intent(in) :: i, k
    real(real64), intent(in) :: shift(2), height, margin
    logical, intent(out) :: is_near
    real(real64), intent(out) :: touch
    real(real64) :: d, s

    s = upper%radius(i) + lower%radius(k)
    d = sqrt((upper%x(i) + shift(1) - lower%x(k))**2 + (upper%y(i) + shift(2) - lower%y(k))**2)
    d = max(d - margin, 0.0_real64)
    is_near = d < s
    if (is_near .and. height < s) is_near = d * d < 2.0_real64 * s * height
    d = min(d, s)
    touch = upper%height(i) + lower%height(k) - d * d / (s + sqrt((s - d) * (s + d)))
  end subroutine look_at

  subroutine no_pairs
    type(surface_points) :: some
    type(pair_levels) :: levels
    real(real64), parameter :: far(2, 4) = &
      reshape([1.0e3_real64, 0.0_real64, 0.0_real64, -1.0e3_real64, -1.0e150_real64, 0.0_real64, &
               0.0_real64, 1.0e150_real64], [2, 4])
    integer :: i

    call draw_surface(even, 300, some)
    call build_levels(levels, some, some, 0.05_real64, double)
    call check(pairs_at([0.0_real64, 0.0_real64]) > 0, 'there are pairs')
    do i = 1, 2
      call check(pairs_at(far(:, i)), 0, 'far')
    end do
    ! Rounding of such a displacement may hide any distance: then all or none are found.
    do i = 3, 4
      call check(modulo(pairs_at(far(:, i)), 300 * 300), 0, 'very far')
    end do
    call check(squared_reach(0.0_real64, 1.0_real64) <= 0.0_real64, 'no height, no reach')
    call build_levels(levels, some, some, 0.0_real64, double)
    ! Each asperity is found with its twin: the margin is more than no distance.
    call check(pairs_at([0.0_real64, 0.0_real64]), 300, 'no height')
    call check(pairs_at([1.0e-3_real64, 0.0_real64]), 0, 'no height, displaced')

  contains

    integer function pairs_at(shift)
      real(real64), intent(in) :: shift(2)
      type(found_pairs) :: found
      logical :: failed

      call search_level(levels, last_level(levels), shift(1), shift(2), .false., any_touch, found, &
                        failed)
      pairs_at = int(found%number)
    end function pairs_at

  end subroutine no_pairs

  subroutine keys
    integer, parameter :: sizes(6) = [1, 7, 12, 13, 25, 5000]
    real(real64), allocatable :: key(:)
    integer(int32), allocatable :: order(:)
    integer :: n, turn, kind, i

    do turn = 1, 600
      n = sizes(modulo(turn, 6) + 1)
      kind = modulo(turn / 6, 5) + 1
      if (n > 100 .and. turn > 60) cycle
      allocate (key(n), order(n))
      do i = 1, n
        key(i) = draw_key(kind, i)
      end do
      call sort_keys(key, order)
      call check(all(order >= 1 .and. order <= n), 'an index out of the range')
      if (has_failed()) return
      do i = 2, n
        call check(key(order(i)) > key(order(i - 1)) .or. &
                          (key(order(i)) >= key(order(i - 1)) .and. order(i) > order(i - 1)), &
                   'not in order')
      end do
      deallocate (key, order)
    end do
  end subroutine keys

  ! A number of some distribution: even, over all magnitudes, few values, many in a heap beside one
  ! far off, too close for buckets.
  real(real64) function draw_key(kind, i)
    integer, intent(in) :: kind, i

    select case (kind)
    case (1)
      draw_key = random(seed) - 0.5_real64
    case (2)
      draw_key = 10.0_real64**(400.0_real64 * random(seed) - 200.0_real64)
    case (3)
      draw_key = real(int(4.0_real64 * random(seed)), real64)
    case (4)
      draw_key = 1.0_real64 + merge(1.0e12_real64, 0.0_real64, i == 3)
      if (modulo(i, 3) == 1) draw_key = draw_key + random(seed) * 1.0e-9_real64
    case default
      draw_key = real(modulo(-7 * i, 1000), real64) * tiny(1.0_real64)
    end select
  end function draw_key

  ! A random surface of a kind.
  subroutine draw_surface(kind, n, drawn)
    integer, intent(in) :: kind, n
    type(surface_points), intent(out) :: drawn
    real(real64) :: centre(2)
    integer :: i

    allocate (drawn%x(n), drawn%y(n), drawn%height(n), drawn%radius(n))
    centre = 0.0_real64
    do i = 1, n
      drawn%x(i) = 20.0_real64 * random(seed)
      drawn%y(i) = 20.0_real64 * random(seed) - 10.0_real64
      drawn%height(i) = 0.1_real64 * random(seed)
      drawn%radius(i) = 1.25_real64
      select case (kind)
      case (clustered)
        ! The same places on every surface, so that clusters meet.
        centre = real(modulo(i, 7), real64) * [1.0e9_real64, -3.0e9_real64]
        drawn%x(i) = centre(1) + 0.1_real64 * drawn%x(i)
        drawn%y(i) = centre(2) + 0.1_real64 * drawn%y(i)
      case (mixed)
        drawn%radius(i) = 10.0_real64**(4.0_real64 * random(seed) - 3.0_real64)
      case (lattice)
        drawn%x(i) = 0.5_real64 * real(modulo(i, 17), real64)
        drawn%y(i) = 0.5_real64 * real(i / 17, real64)
        drawn%height(i) = 0.125_real64 * real(modulo(i, 2), real64)
      case (crowded)
        drawn%x(i) = 0.02_real64 * drawn%x(i)
        drawn%y(i) = 0.01_real64 * drawn%y(i)
      case (towering)
        ! Beside the height of the first, gaps round to a few numbers: other things decide.
        if (i == 1) drawn%height(i) = 1.0e14_real64
        drawn%radius(i) = 1.0_real64 + 0.25_real64 * real(modulo(i, 2), real64)
        drawn%x(i) = 0.0625_real64 * real(int(16.0_real64 * drawn%x(i)), real64)
        drawn%y(i) = 0.0625_real64 * real(int(16.0_real64 * drawn%y(i)), real64)
      case default
        cycle
      end select
    end do
  end subroutine draw_surface

end module asperity_pair_search_suite
