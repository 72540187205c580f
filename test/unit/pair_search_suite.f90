!> Tests of the pair search against a search that compares all with all.
module asperity_test_pair_search
  use asperity_cell_grid, only: build_grid, cell_grid
  use asperity_cell_reach, only: pair_reach
  use asperity_cell_sort, only: sort_keys
  use asperity_kinds, only: int32, int64, real64
  use asperity_pair_search, only: find_candidate_pairs, find_touching_pairs, found_pair, &
                                  margin_of_arithmetic
  use asperity_testing, only: check, error_type, new_unittest, unittest_type
  implicit none
  private

  public :: collect_pair_search

  !> Asperities as the search is given them.
  type :: surface
    real(real64), allocatable :: x(:)       !! place in plan
    real(real64), allocatable :: y(:)       !! place in plan
    real(real64), allocatable :: height(:)  !! level of the summit
    real(real64), allocatable :: radius(:)  !! more than 0
  end type surface

  ! Kinds of random surfaces.
  integer, parameter :: even = 1, clustered = 2, mixed = 3, lattice = 4, crowded = 5, &
                        towering = 6
  character(len=*), parameter :: names(6) = ['even     ', 'clustered', 'mixed    ', 'lattice  ', &
                                             'crowded  ', 'towering ']
  real(real64), parameter :: all_levels = -huge(1.0_real64)

  ! Marsaglia's xorshift, so that every run sees the same surfaces.
  integer(int64) :: seed = 1_int64

contains

  !> Lists the tests.
  subroutine collect_pair_search(suite)
    !> all tests
    type(unittest_type), allocatable, intent(out) :: suite(:)

    suite = [ &
      new_unittest('pairs, separations and their order are those of all pairs', as_all_pairs), &
      new_unittest('the first pairs are the same whether or not the rest is kept', first_ones), &
      new_unittest('candidates come in the order of all pairs, none is lost', candidates), &
      new_unittest('surfaces that are empty, flat or far apart have no pairs', no_pairs), &
      new_unittest('keys of every distribution are sorted, equal ones keep their order', keys)]
  end subroutine collect_pair_search

  subroutine as_all_pairs(error)
    type(error_type), allocatable, intent(out) :: error
    type(surface) :: upper, lower
    type(cell_grid) :: above, below
    type(pair_reach) :: reach
    type(found_pair), allocatable :: found(:), truth(:)
    character(len=:), allocatable :: failure
    real(real64) :: shift(2)
    integer :: kind, turn, pairs

    pairs = 0
    do kind = 1, size(names)
      do turn = 1, 3
        call draw_surface(kind, 300 + 20 * turn, upper)
        call draw_surface(kind, 400 - 30 * turn, lower)
        reach = pair_reach()
        if (turn == 2) reach%distance = 0.7_real64
        if (turn == 3) reach%height = 0.05_real64
        shift = 0.0_real64
        if (turn > 1) shift = [0.375_real64, -1.25_real64]
        call build_grid(above, upper%x, upper%y, upper%height, upper%radius, reach)
        call build_grid(below, lower%x, lower%y, lower%height, lower%radius, reach)
        call find_touching_pairs(above, below, shift(1), shift(2), reach, all_levels, huge(1), &
                                 found, failure)
        call all_pairs(upper, lower, shift, reach, truth)
        call check(error, .not. allocated(failure), 'no memory')
        call check(error, size(found), size(truth), 'pairs, '//names(kind))
        if (allocated(error)) return
        call check(error, all(found%upper == truth%upper .and. found%lower == truth%lower), &
                   'other pairs or another order, '//names(kind))
        call check(error, all(same_bits(found%touch, truth%touch) .and. &
                              same_bits(found%squared, truth%squared)), &
                   'other separations, '//names(kind))
        pairs = pairs + size(found)
      end do
    end do
    ! The crowded ones alone fill the search's batches many times.
    call check(error, pairs > 100000, 'too few pairs to show anything')
  end subroutine as_all_pairs

  subroutine first_ones(error)
    type(error_type), allocatable, intent(out) :: error
    type(surface) :: upper, lower
    type(cell_grid) :: above, below
    type(pair_reach) :: reach
    type(found_pair), allocatable :: found(:), whole(:)
    character(len=:), allocatable :: failure
    real(real64) :: level
    integer :: kind, most, i, k

    do kind = 1, size(names)
      call draw_surface(kind, 300, upper)
      call draw_surface(kind, 300, lower)
      reach = pair_reach()
      call build_grid(above, upper%x, upper%y, upper%height, upper%radius, reach)
      call build_grid(below, lower%x, lower%y, lower%height, lower%radius, reach)
      call find_touching_pairs(above, below, 0.0_real64, 0.0_real64, reach, all_levels, huge(1), &
                               whole, failure)
      most = size(whole) / 3
      call find_touching_pairs(above, below, 0.0_real64, 0.0_real64, reach, all_levels, most, &
                               found, failure)
      call check(error, size(found), most, 'number of first pairs')
      if (allocated(error)) return
      call check(error, all(found%upper == whole(:most)%upper .and. &
                            found%lower == whole(:most)%lower), 'other first pairs')
      level = whole(most)%touch
      call find_touching_pairs(above, below, 0.0_real64, 0.0_real64, reach, level, huge(1), &
                               found, failure)
      call check(error, size(found), count(whole%touch >= level), 'pairs over a level')
      if (allocated(error)) return
      k = 0
      do i = 1, size(whole)
        if (whole(i)%touch < level) cycle
        k = k + 1
        call check(error, found(k)%upper == whole(i)%upper .and. &
                          found(k)%lower == whole(i)%lower, 'other pairs over a level')
      end do
    end do
  end subroutine first_ones

  subroutine candidates(error)
    type(error_type), allocatable, intent(out) :: error
    type(surface) :: upper, lower
    type(cell_grid) :: above, below
    type(pair_reach) :: reach, wider
    type(found_pair), allocatable :: least(:), most(:)
    integer(int32), allocatable :: uppers(:), lowers(:)
    character(len=:), allocatable :: failure
    real(real64) :: margin, level
    integer :: kind, i, k

    margin = margin_of_arithmetic(16.0_real64**(-5), 10.0_real64)
    reach%distance = 0.7_real64
    wider%distance = reach%distance + margin
    do kind = 1, size(names)
      call draw_surface(kind, 300, upper)
      call draw_surface(kind, 300, lower)
      call build_grid(above, upper%x, upper%y, upper%height, upper%radius, reach)
      call build_grid(below, lower%x, lower%y, lower%height, lower%radius, reach)
      call find_candidate_pairs(above, below, 0.0_real64, 0.0_real64, reach, margin, all_levels, &
                                uppers, lowers, failure)
      call all_pairs(upper, lower, [0.0_real64, 0.0_real64], reach, least)
      call all_pairs(upper, lower, [0.0_real64, 0.0_real64], wider, most)
      call check(error, size(uppers) >= size(least), 'candidates lost, '//names(kind))
      ! Spheres that all but touch may be candidates, too.
      if (kind == even) call check(error, size(uppers), size(most), 'candidates added')
      do i = 2, size(uppers)
        call check(error, uppers(i) > uppers(i - 1) .or. &
                          (uppers(i) == uppers(i - 1) .and. lowers(i) > lowers(i - 1)), &
                   'another order of candidates')
      end do
      level = least(size(least) / 2)%touch
      call find_candidate_pairs(above, below, 0.0_real64, 0.0_real64, reach, margin, level, &
                                uppers, lowers, failure)
      call check(error, size(uppers) < size(most), 'nothing is left out below a level')
      call sort_by_index(least)
      k = 1
      do i = 1, size(least)
        if (least(i)%touch < level) cycle
        do while (uppers(k) /= least(i)%upper .or. lowers(k) /= least(i)%lower)
          k = k + 1
          call check(error, k <= size(uppers), 'a pair is no candidate, '//names(kind))
          if (allocated(error)) return
        end do
      end do
    end do
  end subroutine candidates

  subroutine no_pairs(error)
    type(error_type), allocatable, intent(out) :: error
    type(surface) :: some, none
    type(cell_grid) :: above, below, empty
    type(pair_reach) :: reach
    real(real64) :: far(2, 4)

    call draw_surface(even, 300, some)
    call draw_surface(even, 0, none)
    reach%height = 0.05_real64
    call build_grid(above, some%x, some%y, some%height, some%radius, reach)
    call build_grid(below, some%x, some%y, some%height, some%radius, reach)
    call build_grid(empty, none%x, none%y, none%height, none%radius, reach)
    call check(error, pairs_of(above, below, [0.0_real64, 0.0_real64]) > 0, 'there are pairs')
    call check(error, pairs_of(above, empty, [0.0_real64, 0.0_real64]), 0, 'none below')
    call check(error, pairs_of(empty, below, [0.0_real64, 0.0_real64]), 0, 'none above')
    far = reshape([1.0e3_real64, 0.0_real64, 0.0_real64, -1.0e3_real64, -1.0e150_real64, &
                   0.0_real64, 0.0_real64, 1.0e150_real64], [2, 4])
    call check(error, pairs_of(above, below, far(:, 1)), 0, 'far to the right')
    call check(error, pairs_of(above, below, far(:, 2)), 0, 'far in front')
    call check(error, pairs_of(above, below, far(:, 3)), 0, 'very far to the left')
    call check(error, pairs_of(above, below, far(:, 4)), 0, 'very far behind')
    reach%height = 0.0_real64
    call build_grid(above, some%x, some%y, some%height, some%radius, reach)
    call check(error, pairs_of(above, below, [0.0_real64, 0.0_real64]), 0, 'no height')

  contains

    integer function pairs_of(one, other, shift)
      type(cell_grid), intent(in) :: one, other
      real(real64), intent(in) :: shift(2)
      type(found_pair), allocatable :: found(:)
      character(len=:), allocatable :: failure

      call find_touching_pairs(one, other, shift(1), shift(2), reach, all_levels, huge(1), found, &
                               failure)
      pairs_of = size(found)
    end function pairs_of

  end subroutine no_pairs

  subroutine keys(error)
    type(error_type), allocatable, intent(out) :: error
    integer, parameter :: sizes(5) = [1, 7, 24, 25, 5000]
    real(real64), allocatable :: key(:), given(:), spare(:)
    integer(int32), allocatable :: item(:), spare_item(:)
    integer :: n, turn, kind, i

    do turn = 1, 500
      n = sizes(modulo(turn, 5) + 1)
      kind = modulo(turn / 5, 5) + 1
      if (n > 100 .and. turn > 50) cycle
      allocate (key(n), given(n), spare(n), item(n), spare_item(n))
      do i = 1, n
        key(i) = draw_key(kind, i)
        item(i) = int(i, int32)
      end do
      given(:) = key
      call sort_keys(key, item, spare, spare_item)
      call check(error, all(same_bits(key, given(item))), 'an item lost its key')
      do i = 2, n
        call check(error, key(i) > key(i - 1) .or. &
                          (key(i) >= key(i - 1) .and. item(i) > item(i - 1)), 'not in order')
      end do
      deallocate (key, given, spare, item, spare_item)
    end do
  end subroutine keys

  ! A number of some distribution: even, over all magnitudes, few values, many in a heap beside one
  ! far off, too close for buckets.
  real(real64) function draw_key(kind, i)
    integer, intent(in) :: kind, i

    select case (kind)
    case (1)
      draw_key = draw() - 0.5_real64
    case (2)
      draw_key = 10.0_real64**(400.0_real64 * draw() - 200.0_real64)
    case (3)
      draw_key = real(int(4.0_real64 * draw()), real64)
    case (4)
      draw_key = 1.0_real64 + merge(1.0e12_real64, 0.0_real64, i == 3)
      if (modulo(i, 3) == 1) draw_key = draw_key + draw() * 1.0e-9_real64
    case default
      draw_key = real(modulo(-7 * i, 1000), real64) * tiny(1.0_real64)
    end select
  end function draw_key

  ! The pairs by the solver's formulas, all against all, sorted.
  subroutine all_pairs(upper, lower, shift, reach, list)
    type(surface), intent(in) :: upper, lower
    real(real64), intent(in) :: shift(2)
    type(pair_reach), intent(in) :: reach
    type(found_pair), allocatable, intent(out) :: list(:)
    type(found_pair), allocatable :: room(:)
    real(real64) :: across, along, s, d, d2, first
    integer :: i, k, n

    allocate (room(size(upper%x) * size(lower%x)))
    n = 0
    do i = 1, size(upper%x)
      do k = 1, size(lower%x)
        across = upper%x(i) + shift(1) - lower%x(k)
        along = upper%y(i) + shift(2) - lower%y(k)
        s = upper%radius(i) + lower%radius(k)
        d2 = across * across + along * along
        d = sqrt(d2)
        if (d2 >= s * s .or. d >= reach%distance) cycle
        if (reach%height < s .and. d2 >= (s + s) * min(reach%height, s)) cycle
        n = n + 1
        room(n)%touch = (upper%height(i) + lower%height(k)) - d2 / (s + sqrt((s - d) * (s + d)))
        room(n)%squared = d2
        room(n)%upper = int(i, int32)
        room(n)%lower = int(k, int32)
      end do
    end do
    allocate (list(n))
    list(:) = room(:n)
    if (n == 0) return
    first = maxval(list%touch)
    call sort_pairs(list)

  contains

    ! Merge sort; a list of all pairs is in the order of indices, which equal pairs keep.
    recursive subroutine sort_pairs(part)
      type(found_pair), intent(inout) :: part(:)
      type(found_pair), allocatable :: left(:)
      integer :: half, a, b, c

      if (size(part) < 2) return
      half = size(part) / 2
      call sort_pairs(part(:half))
      call sort_pairs(part(half + 1:))
      allocate (left(half))
      left(:) = part(:half)
      a = 1
      b = half + 1
      do c = 1, size(part)
        if (a > half) exit
        if (b <= size(part)) then
          if (earlier(part(b), left(a))) then
            part(c) = part(b)
            b = b + 1
            cycle
          end if
        end if
        part(c) = left(a)
        a = a + 1
      end do
    end subroutine sort_pairs

    ! Gap, distance, sum of the radii, combined radius: the first that differs decides.
    logical function earlier(one, other)
      type(found_pair), intent(in) :: one, other
      real(real64) :: difference(4)
      integer :: at

      associate (s1 => upper%radius(one%upper) + lower%radius(one%lower), &
                 s2 => upper%radius(other%upper) + lower%radius(other%lower))
        difference = [(first - one%touch) - (first - other%touch), &
                      sqrt(one%squared) - sqrt(other%squared), s1 - s2, &
                      upper%radius(one%upper) * lower%radius(one%lower) / s1 - &
                      upper%radius(other%upper) * lower%radius(other%lower) / s2]
      end associate
      earlier = .false.
      do at = 1, size(difference)
        if (abs(difference(at)) > 0.0_real64) then
          earlier = difference(at) < 0.0_real64
          return
        end if
      end do
    end function earlier

  end subroutine all_pairs

  ! Sorts a short list by upper, then lower index.
  subroutine sort_by_index(list)
    type(found_pair), intent(inout) :: list(:)
    real(real64), allocatable :: key(:), spare(:)
    integer(int32), allocatable :: item(:), spare_item(:)
    integer :: i

    allocate (key(size(list)), spare(size(list)), item(size(list)), spare_item(size(list)))
    do i = 1, size(list)
      key(i) = real(list(i)%upper, real64) * 1.0e6_real64 + real(list(i)%lower, real64)
      item(i) = int(i, int32)
    end do
    call sort_keys(key, item, spare, spare_item)
    list(:) = list(item)
  end subroutine sort_by_index

  ! A random surface of a kind.
  subroutine draw_surface(kind, n, drawn)
    integer, intent(in) :: kind, n
    type(surface), intent(out) :: drawn
    real(real64) :: centre(2)
    integer :: i

    allocate (drawn%x(n), drawn%y(n), drawn%height(n), drawn%radius(n))
    centre = 0.0_real64
    do i = 1, n
      drawn%x(i) = 20.0_real64 * draw()
      drawn%y(i) = 20.0_real64 * draw() - 10.0_real64
      drawn%height(i) = 0.1_real64 * draw()
      drawn%radius(i) = 1.25_real64
      select case (kind)
      case (clustered)
        ! The same places on every surface, so that clusters meet.
        centre = real(modulo(i, 7), real64) * [1.0e9_real64, -3.0e9_real64]
        drawn%x(i) = centre(1) + 0.1_real64 * drawn%x(i)
        drawn%y(i) = centre(2) + 0.1_real64 * drawn%y(i)
      case (mixed)
        drawn%radius(i) = 10.0_real64**(4.0_real64 * draw() - 3.0_real64)
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

  ! Uniform from 0 to 1.
  real(real64) function draw()
    seed = ieor(seed, ishft(seed, 13))
    seed = ieor(seed, ishft(seed, -7))
    seed = ieor(seed, ishft(seed, 17))
    draw = real(ishft(seed, -11), real64) * 2.0_real64**(-53)
  end function draw

  ! Whether two numbers are the same, bit for bit.
  elemental logical function same_bits(a, b)
    real(real64), intent(in) :: a, b

    same_bits = transfer(a, 0_int64) == transfer(b, 0_int64)
  end function same_bits

end module asperity_test_pair_search
